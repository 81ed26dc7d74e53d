"""An independent tracer for symmetric stones: 57 half-spaces and a cylinder (`docs/model.md`, 2 and 4).

It shares nothing with the package but the numbers of the facets: its planes come from the proportions, not
from vertices; a ray is clipped against all of them at once, and no triangle, edge or tolerance occurs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gemrender.cuts import RoundBrilliant

_STEP = math.pi / 8
#: Number of the cylinder among the surfaces.
CYLINDER = 57

#: What became of a ray, numbered as in `RayStatus`.
MISSED, EXITED, TRAPPED = 0, 1, 2


@dataclass(frozen=True, kw_only=True)
class HalfSpaces:
    """Points p with normals @ p <= offsets, within the cylinder of radius 1."""

    normals: np.ndarray  # (57, 3), unit
    offsets: np.ndarray  # (57,)

    def outside(self, p: np.ndarray) -> np.ndarray:
        """Largest distance by which points (n, 3) lie beyond one of the 58 surfaces, (n,)."""
        beyond = (p @ self.normals.T - self.offsets).max(axis=1)
        return np.maximum(beyond, np.hypot(p[:, 0], p[:, 1]) - 1)

    def clip(self, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Where rays come in and go out: distance (n,) and facet (n,) of each; in >= out for a miss."""
        slope = d @ self.normals.T
        room = self.offsets - o @ self.normals.T
        a, b = (d[:, :2] ** 2).sum(axis=1), (o[:, :2] * d[:, :2]).sum(axis=1)
        c = (o[:, :2] ** 2).sum(axis=1) - 1
        with np.errstate(divide="ignore", invalid="ignore"):
            t = room / slope
            root = np.sqrt(b * b - a * c)
            wall_in, wall_out = (-b - root) / a, (-b + root) / a
        # Parallel to a surface: all of the ray is on one side of it.
        wall_in = np.where(a > 0, wall_in, np.where(c <= 0, -np.inf, np.inf))
        wall_out = np.where(a > 0, wall_out, np.inf)
        wall_in = np.where(np.isnan(wall_in), np.inf, wall_in)  # passes the cylinder by
        entries = np.where(slope < 0, t, np.where((slope == 0) & (room < 0), np.inf, -np.inf))
        exits = np.where(slope > 0, t, np.inf)
        entries = np.column_stack([entries, wall_in])
        exits = np.column_stack([exits, np.where(np.isnan(wall_out), np.inf, wall_out)])
        return entries.max(axis=1), entries.argmax(axis=1), exits.min(axis=1), exits.argmin(axis=1)

    def normal(self, facet: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Outward unit normals (n, 3) of facets (n,) at the points (n, 3)."""
        out = self.normals[np.minimum(facet, CYLINDER - 1)]
        wall = facet == CYLINDER
        out[wall] = 0.0
        out[wall, :2] = p[wall, :2] / np.hypot(p[wall, 0], p[wall, 1])[:, None]
        return out


@dataclass(frozen=True, kw_only=True)
class Paths:
    """What became of n rays; their first facets (n, 4), -1 for none; cosines (n, 2): in air, in the stone."""

    status: np.ndarray
    reflections: np.ndarray
    entry_facet: np.ndarray
    exit_facet: np.ndarray
    first_facets: np.ndarray
    exit_point: np.ndarray
    exit_direction: np.ndarray
    eye_side: np.ndarray
    light_side: np.ndarray


def half_spaces(p: RoundBrilliant) -> HalfSpaces:
    """The half-spaces of the symmetric stone of these proportions, in the order of its facets.

    Every plane but the table is z = height - slope * (distance along its azimuth), with the height and the
    slope fixed by two points of `docs/model.md`, section 2.
    """
    r_t, crown, girdle, depth = (
        x / 100 for x in (p.table, 2 * p.crown_height, 2 * p.girdle_thickness, 2 * p.pavilion_depth)
    )
    cos, half = math.cos(_STEP), math.cos(_STEP / 2)
    e = r_t * cos
    r_s, r_l = e + p.star / 100 * (1 - e), p.lower_girdle_contact / 100
    z_s, z_l = crown * (1 - r_s * cos) / (1 - r_t), -depth * (1 - r_l * cos)

    even, odd, halves = (
        2 * _STEP * np.arange(8),
        _STEP * (2 * np.arange(8) + 1),
        _STEP * (np.arange(16) + 0.5),
    )
    star, bezel = (crown - z_s) / (r_s - e), crown / (1 - r_t)
    upper, lower = z_s / (half * (1 - r_s)), z_l / (half * (1 - r_l))
    # Azimuth, slope, height on the axis, and whether the stone lies below the plane.
    rings = [
        (np.zeros(1), 0.0, girdle + crown, 1),
        (odd, star, girdle + crown + star * e, 1),
        (even, bezel, girdle + bezel, 1),
        (halves, upper, girdle + upper * half, 1),
        (halves, lower, lower * half, -1),
        (even, -depth, -depth, -1),
    ]
    normals, offsets = [], []
    for azimuth, slope, height, side in rings:
        n = side * np.stack(
            [slope * np.cos(azimuth), slope * np.sin(azimuth), np.ones_like(azimuth)], axis=-1
        )
        length = math.hypot(1.0, slope)
        normals.append(n / length)
        offsets.append(np.full(len(azimuth), side * height / length))
    return HalfSpaces(normals=np.concatenate(normals), offsets=np.concatenate(offsets))


def follow(
    solid: HalfSpaces, o: np.ndarray, d: np.ndarray, index: float, max_reflections: int = 1000
) -> Paths:
    """Follow rays from outside, by refraction and total reflection, until they leave (section 4)."""
    n = len(o)
    status, reflections = np.zeros(n, dtype=int), np.zeros(n, dtype=int)
    exit_facet, entry_facet = np.full(n, -1), np.full(n, -1)
    first_facets = np.full((n, 4), -1)
    exit_point, exit_direction = np.zeros((n, 3)), np.zeros((n, 3))
    eye_side, light_side = np.ones((n, 2)), np.ones((n, 2))

    t_in, facet_in, t_out, _ = solid.clip(o, d)
    ray = np.flatnonzero(t_in < t_out)
    status[ray], entry_facet[ray], first_facets[ray, 0] = TRAPPED, facet_in[ray], facet_in[ray]
    o, d = o[ray] + t_in[ray, None] * d[ray], d[ray]
    normal = solid.normal(facet_in[ray], o)
    cos_air = -(d * normal).sum(axis=1, keepdims=True)
    cos_stone = np.sqrt(1 - (1 - cos_air**2) / index**2)
    d = (d + cos_air * normal) / index - cos_stone * normal
    eye_side[ray] = np.hstack([cos_air, cos_stone])

    for number in range(1, max_reflections + 2):
        if not ray.size:
            break
        _, _, t, facet = solid.clip(o, d)
        if number < first_facets.shape[1]:
            first_facets[ray, number] = facet
        o = o + t[:, None] * d
        normal = solid.normal(facet, o)
        cos = (d * normal).sum(axis=1, keepdims=True)
        sin2_air = index**2 * (1 - cos**2)
        leaves = sin2_air[:, 0] < 1
        out = ray[leaves]
        cos_air = np.sqrt(1 - sin2_air[leaves])
        status[out], exit_facet[out], exit_point[out] = EXITED, facet[leaves], o[leaves]
        exit_direction[out] = index * (d - cos * normal)[leaves] + cos_air * normal[leaves]
        light_side[out] = np.hstack([cos_air, cos[leaves]])
        ray, o, d = ray[~leaves], o[~leaves], (d - 2 * cos * normal)[~leaves]
        reflections[ray] += 1
    reflections[ray] = max_reflections
    return Paths(
        status=status,
        reflections=reflections,
        entry_facet=entry_facet,
        exit_facet=exit_facet,
        first_facets=first_facets,
        exit_point=exit_point,
        exit_direction=exit_direction,
        eye_side=eye_side,
        light_side=light_side,
    )

"""Where a ray meets the stone: 78 triangles and the girdle, surface number 79 (the paper's section 3.2).

Every surface is tested. A girdle facet goes on beyond its chord, as the same plane, until it meets the
girdle's wall or the facet on the girdle's other side. Ties go to the surface with the lower number, and a
ray that slips between two surfaces by rounding takes the nearest plane ahead, so that none is lost.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gemrender.stone import Stone
from gemrender.stone.topology import (
    GIRDLE,
    LOWER_GIRDLE_TRIANGLES,
    N_TRIANGLES,
    TRIANGLE_FACET,
    UPPER_GIRDLE_TRIANGLES,
)

__all__ = ["Hit", "Surfaces"]

#: Slack of the tests of edges and distances [girdle radius]: some thousand roundings of float64, so that a
#: ray through an edge or a vertex meets at least one surface.
EDGE_TOLERANCE = 1e-11

#: Of a triangle that goes on beyond its chord, the one across the girdle; else -1.
_OPPOSITE = np.full(N_TRIANGLES, -1)
_OPPOSITE[UPPER_GIRDLE_TRIANGLES], _OPPOSITE[LOWER_GIRDLE_TRIANGLES] = (
    LOWER_GIRDLE_TRIANGLES,
    UPPER_GIRDLE_TRIANGLES,
)


#: A measured wall is searched for in so many steps between two cylinders, then by halving to rounding.
_WALL_STEPS = 16
_WALL_HALVINGS = 46

#: Rays tested at a time: their distances to 79 surfaces stay in a core's cache.
_CHUNK = 2048


@dataclass(frozen=True, slots=True)
class Hit:
    """The nearest surface along each of n rays.

    Attributes
    ----------
    distance : (n,) float64
        Distance along the ray [girdle radius]; infinite where it meets nothing.
    facet : (n,) int64
        Facet number, the girdle's 57 included; -1 where it meets nothing.
    normal : (n, 3) float64
        Outward unit normal.
    """

    distance: np.ndarray
    facet: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True, slots=True)
class Surfaces:
    """The 79 surfaces of a stone, as planes and edge functionals.

    Parameters
    ----------
    stone : Stone
        The stone to trace.
    """

    stone: Stone
    #: (3, 78, 3) and (3, 78): distance from each edge, positive on the triangle's side, as an affine
    #: function of the point: functional . p - constant.
    _functionals: np.ndarray = field(init=False, repr=False)
    _constants: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        v = self.stone.vertices[self.stone.triangles]
        along = np.roll(v, -1, axis=1) - v
        inward = np.cross(self.stone.triangle_normals[:, None], along)
        inward /= np.linalg.norm(inward, axis=-1, keepdims=True)
        constants = np.einsum("ijk,ijk->ij", inward, v)
        object.__setattr__(self, "_functionals", np.ascontiguousarray(inward.transpose(1, 0, 2)))
        object.__setattr__(self, "_constants", np.ascontiguousarray(constants.T))

    def nearest(self, origin: np.ndarray, direction: np.ndarray, *, inside: bool) -> Hit:
        """Find the nearest surface that each ray goes out through, or comes in through.

        Parameters
        ----------
        origin, direction : (n, 3) float64
            Rays, inside the stone or outside it; unit directions.
        inside : bool
            Whether the rays are inside. Surfaces that face the other way are passed by, so the surface
            just left needs no offset.
        """
        parts = [
            self._nearest(origin[i : i + _CHUNK], direction[i : i + _CHUNK], inside)
            for i in range(0, len(origin), _CHUNK)
        ]
        return Hit(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

    def _nearest(
        self, origin: np.ndarray, direction: np.ndarray, inside: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n = len(origin)
        slope = self.stone.triangle_normals @ direction.T
        heads = slope > 0.0 if inside else slope < 0.0  # neither for a ray parallel to the plane
        distances = np.empty((N_TRIANGLES + 1, n))
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.stone.triangle_offsets[:, None] - self.stone.triangle_normals @ origin.T) / slope
        distances[:-1] = np.where(heads & (t >= -EDGE_TOLERANCE), t, np.inf)
        distances[-1] = self._girdle_distance(origin, direction, inside)
        nearest_plane, ahead = distances.argmin(axis=0), distances.min(axis=0)

        # One surface after the other, in the order of their distance, until the point lies on it.
        surface, distance = np.zeros(n, dtype=np.int64), np.full(n, np.inf)
        open_rays = np.arange(n)
        while open_rays.size:
            tried = distances[:, open_rays].argmin(axis=0)
            t_tried = distances[tried, open_rays]
            some = np.isfinite(t_tried)
            open_rays, tried, t_tried = open_rays[some], tried[some], t_tried[some]
            point = origin[open_rays] + t_tried[:, None] * direction[open_rays]
            on_it = tried == N_TRIANGLES
            on_it[~on_it] = self._within(tried[~on_it], point[~on_it])
            surface[open_rays[on_it]] = tried[on_it]
            distance[open_rays[on_it]] = t_tried[on_it]
            distances[tried[~on_it], open_rays[~on_it]] = np.inf
            open_rays = open_rays[~on_it]
        if inside:
            slipped = np.isinf(distance)
            surface[slipped], distance[slipped] = nearest_plane[slipped], ahead[slipped]

        met = np.isfinite(distance)
        on_girdle = surface == N_TRIANGLES
        triangle = np.where(on_girdle, 0, surface)
        normal = self.stone.triangle_normals[triangle]
        facet = np.where(on_girdle, GIRDLE, TRIANGLE_FACET[triangle])
        on_wall = origin[on_girdle] + distance[on_girdle, None] * direction[on_girdle]
        normal[on_girdle] = self.stone.girdle.normals(on_wall)
        return distance, np.where(met, facet, -1), normal

    def _within(self, triangle: np.ndarray, point: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) of the planes of the triangles (n,) lie on them, or beyond their chord."""
        if self.stone.is_half_spaces:
            return self._inside_all(point)
        edges = [
            np.einsum("ij,ij->i", self._functionals[k, triangle], point) - self._constants[k, triangle]
            for k in range(3)
        ]
        within = np.minimum(np.minimum(edges[0], edges[1]), edges[2]) >= -EDGE_TOLERANCE
        outer = np.flatnonzero((_OPPOSITE[triangle] >= 0) & (edges[1] <= 0.0) & ~within)
        if outer.size:
            p, opposite = point[outer], _OPPOSITE[triangle[outer]]
            wall = self.stone.girdle.radius(p[:, 0], p[:, 1], p[:, 2])
            above = np.einsum("ij,ij->i", self.stone.triangle_normals[opposite], p)
            within[outer] = (np.hypot(p[:, 0], p[:, 1]) <= wall + EDGE_TOLERANCE) & (
                above <= self.stone.triangle_offsets[opposite] + EDGE_TOLERANCE
            )
        return np.asarray(within)

    def _inside_all(self, point: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie in all half-spaces of a stone with tilted facets, and in the cylinder."""
        within = point @ self.stone.facet_normals.T <= self.stone.facet_offsets + EDGE_TOLERANCE
        near = np.hypot(point[:, 0], point[:, 1]) <= 1.0 + EDGE_TOLERANCE
        return np.asarray(within.all(axis=1) & near)

    def _girdle_distance(self, origin: np.ndarray, direction: np.ndarray, inside: bool) -> np.ndarray:
        """Distance to the girdle's wall, (n,); infinite for rays that miss it."""
        girdle = self.stone.girdle
        if girdle.is_round:
            t = _cylinder(origin, direction, 1.0)[1 if inside else 0]
        else:
            t = self._measured_wall(origin, direction, inside)
        ok = np.flatnonzero(np.isfinite(t) & (t >= -EDGE_TOLERANCE))
        if not self.stone.is_half_spaces:
            # Beyond these heights there is no wall: what gets there has slipped between two planes.
            z = origin[ok, 2] + t[ok] * direction[ok, 2]
            low, high = girdle.lower[:, 2].min() - EDGE_TOLERANCE, girdle.upper[:, 2].max() + EDGE_TOLERANCE
            ok = ok[(z >= low) & (z <= high)]
        if not girdle.is_round:
            normals = girdle.normals(origin[ok] + t[ok, None] * direction[ok])
            facing = np.einsum("ij,ij->i", direction[ok], normals)
            ok = ok[facing > 0.0 if inside else facing < 0.0]
        if not inside:
            ok = ok[self._on_girdle(origin[ok] + t[ok, None] * direction[ok])]
        out = np.full(len(origin), np.inf)
        out[ok] = t[ok]
        return out

    def _measured_wall(self, origin: np.ndarray, direction: np.ndarray, inside: bool) -> np.ndarray:
        """First distance (n,) at which rays cross the measured wall outwards, or inwards; else infinite."""
        # The wall lies between two cylinders and between two heights.
        girdle = self.stone.girdle
        near, far = _cylinder(origin, direction, girdle.largest_radius)
        near_inner, far_inner = _cylinder(origin, direction, girdle.smallest_radius)
        with np.errstate(divide="ignore", invalid="ignore"):
            heights = np.array([girdle.lower[:, 2].min(), girdle.upper[:, 2].max()])
            levels = np.sort((heights[:, None] - origin[:, 2]) / direction[:, 2], axis=0)
        first = np.fmax(np.maximum(near, 0.0), levels[0])
        last = np.fmin(far, levels[1])
        if inside:
            first = np.where(np.isfinite(far_inner), np.maximum(first, far_inner), first)
        else:
            last = np.where(
                np.isfinite(near_inner) & (near_inner > first), np.minimum(last, near_inner), last
            )
        possible = np.flatnonzero(last > first)
        out = np.full(len(origin), np.inf)
        first, last, origin, direction = (
            first[possible],
            last[possible],
            origin[possible],
            direction[possible],
        )

        def crossed(t: np.ndarray) -> np.ndarray:
            p = origin + t[:, None] * direction
            is_out = np.hypot(p[:, 0], p[:, 1]) > self.stone.girdle.radius(p[:, 0], p[:, 1], p[:, 2])
            return np.asarray(is_out == inside)

        # The start counts as not crossed: it is the surface just left, or the cylinder's outside.
        found = np.zeros(len(origin), dtype=bool)
        low, high = first.copy(), np.full(len(origin), np.inf)
        for k in range(1, _WALL_STEPS + 1):
            t = first + (last - first) * (k / _WALL_STEPS)
            beyond = crossed(t) & ~found
            high[beyond] = t[beyond]
            found |= beyond
            low[~found] = t[~found]
        searched = np.flatnonzero(found)
        lo, hi = low[searched], high[searched]
        origin, direction = origin[searched], direction[searched]
        for _ in range(_WALL_HALVINGS):
            middle = 0.5 * (lo + hi)
            beyond = crossed(middle)
            hi, lo = np.where(beyond, middle, hi), np.where(beyond, lo, middle)
        high[searched] = 0.5 * (lo + hi)
        out[possible] = high
        return out

    def _on_girdle(self, p: np.ndarray) -> np.ndarray:
        """Whether points of the wall lie between the facets above and below the girdle."""
        if self.stone.is_half_spaces:
            return self._inside_all(p)
        upper = (
            p @ self.stone.triangle_normals[UPPER_GIRDLE_TRIANGLES].T
            <= self.stone.triangle_offsets[UPPER_GIRDLE_TRIANGLES]
        )
        lower = (
            p @ self.stone.triangle_normals[LOWER_GIRDLE_TRIANGLES].T
            <= self.stone.triangle_offsets[LOWER_GIRDLE_TRIANGLES]
        )
        # Of each ring only the facet of the point's own sector bounds it.
        return np.asarray(
            upper[np.arange(len(p)), self._sector(p, self.stone.girdle.upper)]
            & lower[np.arange(len(p)), self._sector(p, self.stone.girdle.lower)]
        )

    @staticmethod
    def _sector(p: np.ndarray, ring: np.ndarray) -> np.ndarray:
        start = np.arctan2(ring[0, 1], ring[0, 0])
        angles = (np.arctan2(ring[:, 1], ring[:, 0]) - start) % (2 * np.pi)
        angles[0] = 0.0
        azimuth = (np.arctan2(p[:, 1], p[:, 0]) - start) % (2 * np.pi)
        return np.asarray(np.searchsorted(angles, azimuth, side="right") - 1)


def _cylinder(origin: np.ndarray, direction: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances (n,) at which rays enter and leave the vertical cylinder.

    Infinite, and minus infinite, where they miss it; vertical rays stay inside or outside for ever.
    """
    a = direction[:, 0] ** 2 + direction[:, 1] ** 2
    b = origin[:, 0] * direction[:, 0] + origin[:, 1] * direction[:, 1]
    c = origin[:, 0] ** 2 + origin[:, 1] ** 2 - radius**2
    root = b * b - a * c
    near, far = np.full(len(origin), np.inf), np.full(len(origin), -np.inf)
    vertical = (a == 0.0) & (c <= 0.0)
    near[vertical], far[vertical] = -np.inf, np.inf
    meets = (a > 0.0) & (root >= 0.0)
    a, b, root = a[meets], b[meets], np.sqrt(root[meets])
    near[meets], far[meets] = (-b - root) / a, (-b + root) / a
    return near, far

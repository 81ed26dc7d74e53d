"""Paths through the points of a view, by the float64 tracer: of the principal light, or of all light."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from gemrender.observation import Model, RayStatus, View
from gemrender.optics.fresnel import is_totally_reflected, reflectance, transmittance
from gemrender.paths import FOLLOW, Paths
from gemrender.reference.surfaces import Surfaces, surfaces_of
from gemrender.reference.tracer import BLOCK, START_DISTANCE, into_air, into_stone
from gemrender.stone import Stone

__all__ = ["LEAST_LIGHT", "paths", "paths_by_ray"]

#: Light inside that has been reflected in part is followed down to this share of the light at the eye.
LEAST_LIGHT = 1e-5


def paths(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    follow: str = "principal",
    points: np.ndarray | None = None,
    least: float = LEAST_LIGHT,
) -> Paths:
    """Follow the rays through the centres of a view's pixels, or through other points of it.

    Each ray that meets the stone has a row for each crossing below the critical angle, the principal path's
    first; those that miss it have none. Nothing is random: the share R = (Rs + Rp)/2 of the light goes on,
    and what is left when it is small is a last row, TRAPPED.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View
        Where the eye is, and the pixels.
    model : Model, optional
        The optical model; by default that of the stone's material.
    follow : {"principal", "all"}
        Whether a ray ends at the first crossing below the critical angle, or its reflected share goes on.
    points : (n, 2) array_like, optional
        x and y in the view [stone's unit], instead of the pixels' centres. Each stands for a pixel's area.
    least : float
        Share of the light at the eye, T of the entry times weight, from which on it is followed no further.

    Raises
    ------
    ValueError
        `follow` is no way to follow light.
    """
    return paths_by_ray(stone, view, model, follow=follow, points=points, least=least)[0]


def paths_by_ray(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    follow: str = "principal",
    points: np.ndarray | None = None,
    least: float = LEAST_LIGHT,
) -> tuple[Paths, np.ndarray]:
    """Return what `paths` does, and the ray of each row, (n,) int64: its pixel, row by row, or its point."""
    if follow not in FOLLOW:
        raise ValueError(f"follow must be one of {', '.join(FOLLOW)}, got {follow!r}")
    model = model or Model.of(stone)
    through_centres = points is None
    if points is None:
        x, y = view.cell_centres()
        points = np.stack(np.broadcast_arrays(x, y[:, None]), axis=-1).reshape(-1, 2)
    points = np.atleast_2d(np.asarray(points, dtype=np.float64))
    surfaces, (right, up, eye) = surfaces_of(stone), view.basis()
    parts: dict[str, list[np.ndarray]] = defaultdict(list)
    for begin in range(0, len(points), BLOCK):
        block = points[begin : begin + BLOCK]
        origin = block[:, :1] * right + block[:, 1:] * up + START_DISTANCE * eye
        rows = _follow(surfaces, origin, -eye, model, all_light=follow == "all", least=least)
        rows["ray"] = rows["ray"] + begin
        for name, column in rows.items():
            parts[name].append(column)
    columns = {name: np.concatenate(columns) for name, columns in parts.items()}
    ray = columns.pop("ray")
    area = np.full(len(ray), (2.0 * view.half_width / view.resolution) ** 2)
    return Paths(area=area, **columns, pixel=ray if through_centres else None, stone=stone), ray


def _follow(
    surfaces: Surfaces,
    origin: np.ndarray,
    direction: np.ndarray,
    model: Model,
    *,
    all_light: bool,
    least: float,
) -> dict[str, np.ndarray]:
    """Follow parallel rays from outside; return the columns of their paths, and the `ray` of each."""
    hit = surfaces.nearest(origin, np.broadcast_to(direction, origin.shape), inside=False)
    number = np.flatnonzero(hit.facet >= 0)
    normal, n = hit.normal[number], len(number)
    cos = -normal @ direction
    # What is known of each ray on its way; `unfold` turns directions there into those of the way unfolded.
    rays: dict[str, np.ndarray] = {
        "ray": number,
        "entry_facet": hit.facet[number],
        "entry_normal": normal,
        "cos_entry": cos,
        "entering": transmittance(cos, model.index),
        "weight": np.ones(n),
        "reflections": np.zeros(n, dtype=np.int64),
        "partial_reflections": np.zeros(n, dtype=np.int64),
        "point": origin[number] + hit.distance[number, None] * direction,
        "direction": into_stone(np.broadcast_to(direction, (n, 3)), normal, model.index),
        "unfold": np.broadcast_to(np.eye(3), (n, 3, 3)),
    }
    rows: dict[str, list[np.ndarray]] = defaultdict(list)
    while True:
        hit = surfaces.nearest(rays["point"], rays["direction"], inside=True)
        found = hit.facet >= 0
        _write(rows, _some(rays, ~found), RayStatus.LOST)
        rays, facet, normal = _some(rays, found), hit.facet[found], hit.normal[found]
        rays["point"] = rays["point"] + hit.distance[found, None] * rays["direction"]
        cos = np.einsum("ij,ij->i", rays["direction"], normal)
        below = ~is_totally_reflected(cos, model.index)

        # Below the critical angle the share T leaves.
        out, cos_out = into_air(rays["direction"][below], normal[below], model.index)
        _write(
            rows,
            _some(rays, below),
            RayStatus.EXITED,
            exit_facet=facet[below],
            cos_exit=cos_out,
            exit_point=rays["point"][below],
            exit_direction=out,
            unfolded_exit_normal=np.einsum("ijk,ik->ij", rays["unfold"][below], normal[below]),
        )
        # And R goes on, mirrored.
        rays["weight"][below] *= reflectance(cos_out, model.index)
        rays["partial_reflections"] += below
        rays["direction"] = rays["direction"] - 2.0 * cos[:, None] * normal
        across = np.einsum("ijk,ik->ij", rays["unfold"], normal)
        rays["unfold"] = rays["unfold"] - 2.0 * across[:, :, None] * normal[:, None, :]
        if not all_light:
            rays = _some(rays, ~below)
        is_weak = (rays["partial_reflections"] > 0) & (rays["weight"] * rays["entering"] < least)
        is_last = rays["reflections"] == model.max_reflections  # no more are allowed, nor counted
        rays["reflections"] += ~is_last
        ends = is_weak | is_last
        _write(rows, _some(rays, ends), RayStatus.TRAPPED)
        rays = _some(rays, ~ends)
        if not len(rays["ray"]):
            break
    columns = {name: np.concatenate(parts) for name, parts in rows.items()}
    order = np.argsort(columns["ray"], kind="stable")
    return {name: column[order] for name, column in columns.items()}


def _some(rays: dict[str, np.ndarray], chosen: np.ndarray) -> dict[str, np.ndarray]:
    return {name: column[chosen] for name, column in rays.items()}


#: Columns of a path that are those of its ray.
_OF_RAY = (
    "ray", "weight", "reflections", "partial_reflections", "entry_facet", "entry_normal", "cos_entry",
)  # fmt: skip


def _write(
    rows: dict[str, list[np.ndarray]], rays: dict[str, np.ndarray], status: RayStatus, **exits: np.ndarray
) -> None:
    """Add a row for each ray; what it says of no exit is 0, its facet -1."""
    n = len(rays["ray"])
    missing = {
        "exit_facet": np.full(n, -1),
        "cos_exit": np.zeros(n),
        "exit_point": np.zeros((n, 3)),
        "exit_direction": np.zeros((n, 3)),
        "unfolded_exit_normal": np.zeros((n, 3)),
    }
    columns = {name: rays[name] for name in _OF_RAY} | {"status": np.full(n, status)} | missing | exits
    for name, column in columns.items():
        rows[name].append(column)

"""Maps of a view: virtual facets drawn into pixels, and single rays where there are none."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import jit_with_arrays
from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.beam.measure import measure_facets
from gemrender.beam.rays import CODE, empty_rays, enter_rays, follow_rays, ray_paths
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.measures import inoue
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.observation import (
    LIGHT_LEVEL,
    MAP_TYPES,
    PATH_CODE_FACTOR,
    PATH_CODE_MASK,
    Model,
    Observation,
    RayStatus,
    View,
)
from gemrender.stone import Stone

__all__ = ["observe", "pixel_facets"]

#: Pixels that are dealt with at a time: whole rows.
_BLOCK = 1 << 20
#: Points this far outside an edge still count as inside [girdle radius]: none is lost between two facets.
_EDGE_TOLERANCE = 1e-12


def observe(
    stone: Stone | BeamStone,
    view: View,
    model: Model | None = None,
    *,
    bound: float = 0.05,
    seed: int = 1,
    measures: Sequence[Measure] = (),
    head_deg: float = HEAD_DEG,
    rays: tuple[np.ndarray, np.ndarray] | None = None,
    progress: Callable[[float], None] | None = None,
    budget: Budget | None = None,
) -> Observation:
    """Tell of the ray through the centre of every pixel what becomes of it, and score the view exactly.

    Parameters
    ----------
    stone : Stone or BeamStone
        The stone.
    view : View
        The map.
    model : Model, optional
        The optical model; by default that of the stone's material.
    bound, seed, measures, head_deg
        Of the scores, as for `measure`.
    rays : tuple of two (h, w, 3) float64 arrays, optional
        Starts [girdle radius] and directions of the rays, which must be the view's own but for rounding, for
        comparing with another tracer.
    progress : callable, optional
        Called with the share done, 0 to 1.
    budget : Budget, optional
        Time and memory that the scores keep to, and once more the polygons of the maps; what they cannot tell
        of the pixels, single rays do.

    Raises
    ------
    InputError
        The stone is not convex, or the bound out of range.
    """
    start = time.perf_counter()
    convex = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    measured, facets = measure_facets(
        convex, view=view, model=model, measures=measures, head_deg=head_deg, bound=bound, seed=seed,
        progress=progress, budget=budget,
    )  # fmt: skip
    if facets.parts > 1 or measures:  # a part of the view, or more than its principal light
        facets = trace_facets(convex, view=view, model=model, budget=budget.anew() if budget else None)
    right, up, _ = view.basis()
    x, y = view.cell_centres()
    maps = _empty_maps(view)
    codes = _path_codes(facets)
    rows = max(1, _BLOCK // view.resolution)
    for first in range(0, view.resolution, rows):
        block = slice(first, min(first + rows, view.resolution))
        if rays is None:
            points = np.stack(np.broadcast_arrays(x, y[block, None]), axis=-1)
        else:
            points = np.stack([rays[0][block] @ right, rays[0][block] @ up], axis=-1)
        points = points.reshape(-1, 2)
        owner = pixel_facets(facets, points, view, first)
        part = {name: array[block].reshape(len(points), *array.shape[2:]) for name, array in maps.items()}
        _fill_from_facets(part, facets, codes, owner, points)
        alone = np.flatnonzero(owner < 0)
        _fill_from_rays(part, convex, facets, alone, points[alone])
    return Observation(
        **maps,
        stone=convex.stone,
        view=view,
        model=facets.model,
        engine="exact",
        seconds=time.perf_counter() - start,
        measured=measured,
    )


def pixel_facets(facets: VirtualFacets, points: np.ndarray, view: View, first_row: int = 0) -> np.ndarray:
    """Return the virtual facet that each pixel's point (n, 2) lies in, (n,), or -1 if in none.

    The points are those of whole rows of the view's map, from a first row on.
    """
    shown = np.flatnonzero(facets.status != FacetStatus.GIRDLE)
    owner = np.full(len(points), -1, dtype=np.int64)
    _draw(
        facets.corners, facets.starts[shown], facets.ends[shown], shown, points, view.resolution,
        view.half_width, first_row, owner,
    )  # fmt: skip
    return owner


@jit_with_arrays
def _draw(
    corners: Any, starts: Any, ends: Any, names: Any, points: Any, resolution: int, half_width: float,
    first_row: int, owner: Any,
) -> None:  # fmt: skip
    """Give every point within a convex polygon the polygon's name; on an edge the first one has it."""
    step = 2.0 * half_width / resolution
    last_row = first_row + len(owner) // resolution - 1
    for f in range(len(starts)):
        polygon = corners[starts[f] : ends[f]]
        n = len(polygon)
        # A pixel more on every side, for points that are not quite at the centres.
        left = max(int((polygon[:, 0].min() + half_width) / step) - 1, 0)
        right = min(int((polygon[:, 0].max() + half_width) / step) + 1, resolution - 1)
        top = max(int((half_width - polygon[:, 1].max()) / step) - 1, first_row)
        bottom = min(int((half_width - polygon[:, 1].min()) / step) + 1, last_row)
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                pixel = (row - first_row) * resolution + column
                if owner[pixel] >= 0:
                    continue
                x, y = points[pixel, 0], points[pixel, 1]
                inside = True
                for k in range(n):
                    a, b = polygon[k], polygon[k + 1 if k + 1 < n else 0]
                    ex, ey = b[0] - a[0], b[1] - a[1]
                    across = ex * (y - a[1]) - ey * (x - a[0])
                    if across < -_EDGE_TOLERANCE * np.sqrt(ex * ex + ey * ey):
                        inside = False
                        break
                if inside:
                    owner[pixel] = names[f]


def _empty_maps(view: View) -> dict[str, Any]:
    return {
        name: np.zeros(
            (*view.shape, 3) if name in ("exit_point", "exit_direction") else view.shape, dtype=kind
        )
        for name, kind in MAP_TYPES.items()
    }


def _path_codes(facets: VirtualFacets) -> np.ndarray:
    """Return the code of each virtual facet's path, (n,) int64.

    A step of a code is c <- (c factor + f + 1) & mask: an affine function modulo a power of two, and so are
    several of them one after the other.
    """
    parents, facet = facets.nodes.T
    codes = facet + 1
    before, factors = parents, np.full(len(parents), PATH_CODE_FACTOR)
    while (before >= 0).any():  # by doubling: each round every node knows twice as many before it
        more = np.flatnonzero(before >= 0)
        codes, factors = codes.copy(), factors.copy()
        earlier = before[more]
        codes[more] = (codes[earlier] * factors[more] + codes[more]) & PATH_CODE_MASK
        factors[more] = (factors[earlier] * factors[more]) & PATH_CODE_MASK
        before = np.where(before >= 0, before[before], -1)
    return np.asarray(codes[facets.node])


def _fill_from_facets(
    maps: dict[str, Any], facets: VirtualFacets, codes: np.ndarray, owner: np.ndarray, points: np.ndarray
) -> None:
    """Write what its virtual facet tells of each pixel into the maps."""
    pixel = np.flatnonzero(owner >= 0)
    of, paths = owner[pixel], facets.paths
    exits = paths.status[of] == RayStatus.EXITED
    by_place, places = facets.exit_map[of], points[pixel]
    point = by_place[:, 0] + places[:, :1] * by_place[:, 1] + places[:, 1:] * by_place[:, 2]
    for name, value in {
        "primary_intensity": facets.primary_intensity[of],
        "rear_mask": facets.rear_mask[of],
        "coverage": True,
        "status": paths.status[of],
        "reflections": paths.reflections[of],
        "exit_point": np.where(exits[:, None], point, 0.0),
        "exit_direction": np.where(exits[:, None], paths.exit_direction[of], 0.0),
        "entry_facet": paths.entry_facet[of],
        "exit_facet": paths.exit_facet[of],
        "path_code": codes[of],
    }.items():
        maps[name][pixel] = value


def _fill_from_rays(
    maps: dict[str, Any], convex: BeamStone, facets: VirtualFacets, pixel: np.ndarray, at: np.ndarray
) -> None:
    """Write what single rays through places (n, 2) of the view find into pixels (n,) of the maps."""
    model, rays = facets.model, empty_rays(len(at))
    enter_rays(at, facets.view.basis(), convex.solid, convex.facet, model.index, rays)
    follow_rays(convex.solid, convex.facet, model.index, model.max_reflections, rays)
    paths = ray_paths(rays, convex.facet, np.zeros(len(at)), convex.stone)
    rear, exits = inoue.rear_mask(paths, model), (paths.status == RayStatus.EXITED)[:, None]
    for name, value in {
        "primary_intensity": LIGHT_LEVEL * inoue.primary_intensity(paths, model, rear),
        "rear_mask": rear,
        "coverage": paths.status != RayStatus.MISSED,
        "status": paths.status,
        "reflections": paths.reflections,
        "exit_point": np.where(exits, paths.exit_point, 0.0),
        "exit_direction": np.where(exits, paths.exit_direction, 0.0),
        "entry_facet": paths.entry_facet,
        "exit_facet": paths.exit_facet,
        "path_code": rays.facts[CODE, : len(at)],
    }.items():
        maps[name][pixel] = value

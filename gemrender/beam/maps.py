"""Maps of a view: virtual facets drawn into pixels, and single rays where there are none."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import jit
from gemrender.beam.facets import FacetStatus, VirtualFacets, kernel_rules, trace_facets
from gemrender.beam.measure import measure_facets
from gemrender.beam.rays import trace_rays
from gemrender.beam.solid import BeamStone, beam_stone
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
    bound, seed
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
    ready = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    measured, facets = measure_facets(
        ready, view=view, model=model, bound=bound, seed=seed, progress=progress, budget=budget
    )
    if facets.parts > 1:
        facets = trace_facets(ready, view=view, model=model, budget=budget.anew() if budget else None)
    right, up, _ = view.basis()
    x, y = view.cell_centres()
    maps = _empty_maps(view)
    tables = _tables(facets)
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
        _fill(owner, points, *tables, *(part[name] for name in MAP_TYPES))
        alone = np.flatnonzero(owner < 0)
        _fill_from_rays(part, ready, facets, alone, points[alone])
    return Observation(
        **maps,
        stone=ready.stone,
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


@jit
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


def _tables(facets: VirtualFacets) -> tuple[np.ndarray, ...]:
    """Return what `_fill` needs of each virtual facet."""
    first, code = _from_the_eye(facets.nodes)
    end = facets.node
    left = facets.status == FacetStatus.EXITED
    status = np.where(left, int(RayStatus.EXITED), int(RayStatus.TRAPPED))
    exit_facet = np.where(left, facets.nodes[end, 1], -1)
    numbers = np.stack([status, facets.reflections, first[end], exit_facet, code[end]], axis=1)
    return facets.primary_intensity, facets.rear_mask, numbers, facets.exit_map, facets.exit_direction


@jit
def _from_the_eye(nodes: Any) -> Any:
    """Return the first facet, and the code, of the path to each node (k, 2)."""
    first, code = np.empty(len(nodes), np.int64), np.empty(len(nodes), np.int64)
    for node in range(len(nodes)):  # parents come first
        parent, facet = nodes[node]
        first[node] = facet if parent < 0 else first[parent]
        before = 0 if parent < 0 else code[parent]
        code[node] = (before * PATH_CODE_FACTOR + facet + 1) & PATH_CODE_MASK
    return first, code


@jit
def _fill(
    owner: Any, points: Any, facet_intensity: Any, facet_rear: Any, numbers: Any, exit_map: Any,
    facet_direction: Any, primary_intensity: Any, rear_mask: Any, coverage: Any, status: Any,
    reflections: Any, exit_point: Any, exit_direction: Any, entry_facet: Any, exit_facet: Any, path_code: Any,
) -> None:  # fmt: skip
    """Write what its virtual facet tells of each pixel into the maps, in the order of MAP_TYPES."""
    for pixel in range(len(owner)):
        f = owner[pixel]
        if f < 0:
            continue
        primary_intensity[pixel] = facet_intensity[f]
        rear_mask[pixel] = 1.0 if facet_rear[f] else 0.0
        coverage[pixel] = 1.0
        status[pixel], reflections[pixel] = numbers[f, 0], numbers[f, 1]
        entry_facet[pixel], exit_facet[pixel], path_code[pixel] = numbers[f, 2], numbers[f, 3], numbers[f, 4]
        if numbers[f, 3] < 0:
            continue
        x, y = points[pixel, 0], points[pixel, 1]
        for k in range(3):
            exit_point[pixel, k] = exit_map[f, 0, k] + x * exit_map[f, 1, k] + y * exit_map[f, 2, k]
            exit_direction[pixel, k] = facet_direction[f, k]


def _fill_from_rays(
    maps: dict[str, Any], ready: BeamStone, facets: VirtualFacets, pixel: np.ndarray, at: np.ndarray
) -> None:
    found, numbers = trace_rays(at, facets.view.basis(), ready.solid, ready.facet, kernel_rules(facets.model))
    status, met = numbers[:, 0], numbers[:, 0] != RayStatus.MISSED
    surfaces = np.append(ready.facet, -1)  # the last one for none
    for name, value in {
        "primary_intensity": LIGHT_LEVEL * found[:, 0],
        "rear_mask": found[:, 1],
        "coverage": met,
        "status": status,
        "reflections": numbers[:, 1],
        "exit_point": found[:, 2:5],
        "exit_direction": found[:, 5:8],
        "entry_facet": surfaces[numbers[:, 2]],
        "exit_facet": surfaces[numbers[:, 3]],
        "path_code": numbers[:, 4],
    }.items():
        maps[name][pixel] = value

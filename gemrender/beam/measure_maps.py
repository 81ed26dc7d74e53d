"""Maps of measures: polygons drawn into pixels with what each adds, and single rays for what they leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.cells import cell_rays, starts_of
from gemrender.beam.compiled import jit
from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.beam.rays import Rays, empty_rays, enter_rays, follow_rays, ray_paths
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.measures.maps import MapBuilder, MeasureMaps
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.observation import Model, RayStatus, View
from gemrender.processors import usable_processors
from gemrender.stone import Stone

__all__ = ["measure_maps"]

#: Pixels that are dealt with at a time: whole rows.
_BLOCK = 1 << 16
#: Pixels stand for places a little off their centres, in a direction that no edge of a symmetric stone has:
#: through the centres themselves edges go, and rounding would tell on which side they lie [girdle radius].
_ASIDE = np.array([0.7548776662e-9, 0.5698402910e-9])
#: All light is followed by polygons down to this share of a pixel (area times weight), but at the most to the
#: second share of the view; by rays from there. What rays are left with is what single pixels scatter by.
_LEAST_OF_PIXEL, _LEAST = 0.2, 1e-5
#: The golden ratio as a fraction of 2^64: states of random numbers that are multiples of it apart.
_ODD = np.uint64(0x9E3779B97F4A7C15)
#: One ray for so much of a pixel's light that is in its cell, but no more than so many.
_LIGHT_OF_RAY, _MOST_RAYS = 0.03, 16
#: What polygons may leave untold of a pixel's light: rounding.
_ROUNDING = 1e-9


def measure_maps(
    stone: Stone | BeamStone,
    view: View,
    model: Model | None = None,
    *,
    measures: Sequence[Measure],
    head_deg: float = HEAD_DEG,
    seed: int = 1,
    progress: Callable[[float], None] | None = None,
    budget: Budget | None = None,
) -> MeasureMaps:
    """Tell what the light of every pixel adds to measures.

    All of a pixel's light is accounted for: each polygon adds what its path does to the pixels whose centres
    it holds. From where polygons end, in a cell of light that has been reflected in part, one random ray goes
    on at the pixel's place, or several where much light is left. A pixel whose polygons do not tell all of
    its light, such as one near a round girdle, has a ray of its own from the eye.

    Parameters
    ----------
    stone : Stone or BeamStone
        The stone.
    view : View
        The map.
    model : Model, optional
        The optical model; by default that of the stone's material.
    measures : sequence of Measure
        The measures, each of one view.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    seed : int
        Seed of the single rays' random numbers.
    progress : callable, optional
        Called with the share done, 0 to 1.
    budget : Budget, optional
        Time and memory that the polygons keep to; what they cannot tell single rays do.

    Raises
    ------
    InputError
        The stone is not convex.
    """
    convex = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    builder = MapBuilder(measures, view, model or Model.of(convex.stone), head_deg)
    least = min(_LEAST_OF_PIXEL / view.resolution**2, _LEAST) if builder.follows_all else 0.0
    facets = trace_facets(convex, view=view, model=builder.model, least=least, budget=budget)
    blocks = _Blocks(convex, facets, builder, seed)
    rows = max(1, _BLOCK // view.resolution)
    firsts = range(0, view.resolution, rows)
    with ThreadPoolExecutor(usable_processors()) as pool:
        done = pool.map(lambda first: blocks.block(first, min(rows, view.resolution - first)), firsts)
        for first, (sums, covered) in zip(firsts, done, strict=True):
            builder.write(first, sums, covered)
            if progress is not None:
                progress(min((first + rows) / view.resolution, 1.0))
    return builder.maps(convex.stone, "exact")


class _Blocks:
    """Blocks of whole rows of a view, each by itself.

    Parameters
    ----------
    convex, facets : BeamStone, VirtualFacets
        The stone, and its polygons.
    builder : MapBuilder
        What is to be told of them.
    seed : int
        Seed of the rays' random numbers.
    """

    def __init__(self, convex: BeamStone, facets: VirtualFacets, builder: MapBuilder, seed: int) -> None:
        self._convex, self._facets, self._builder, self._seed = convex, facets, builder, seed
        # Cells of principal light are left to rays from the eye.
        is_cell, is_later = facets.status == FacetStatus.GIRDLE, facets.paths.partial_reflections > 0
        self._shown = np.flatnonzero(~is_cell | is_later)
        paths = facets.paths.rows(self._shown)
        paths = replace(paths, status=np.where(is_cell[self._shown], RayStatus.TRAPPED, paths.status))
        light = builder.light(paths)
        self._added = builder.added(light)
        cells = np.flatnonzero(is_cell[self._shown])
        self._added[cells] = 0.0  # their rays add it
        self._cell = np.full(len(paths), -1)
        self._cell[cells] = np.arange(len(cells))
        of_cells = self._shown[cells]
        self._maps, self._starts = facets.exit_map[of_cells], starts_of(facets, of_cells)
        # Share of a pixel's light that each tells.
        self._told = light.is_principal.astype(np.float64)
        if builder.follows_all:
            told = self._told * light.surface_reflectance
            self._told = told + np.where(light.is_exit, light.share, light.arriving)
        self._rays = np.clip(np.ceil(self._told[cells] / _LIGHT_OF_RAY), 1, _MOST_RAYS).astype(np.int64)

    def block(self, first_row: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Return what light adds to the pixels of some rows, (n, n_channels), and which met the stone, (n,).

        n is the number of their pixels.
        """
        view, facets, random = self._builder.view, self._facets, np.empty(0, np.uint64)
        n = rows * view.resolution
        sums, told = np.zeros((n, self._builder.n_channels)), np.zeros(n)
        cell = np.full(n, -1)
        _draw(
            facets.corners, facets.starts[self._shown], facets.ends[self._shown], self._added, self._told,
            self._cell, view.resolution, view.half_width, _ASIDE, first_row, sums, told, cell,
        )  # fmt: skip
        x, y = view.cell_centres()
        points = np.stack(np.broadcast_arrays(x, y[first_row : first_row + rows, None]), axis=-1)
        points = points.reshape(-1, 2) + _ASIDE
        if self._builder.follows_all:
            random = np.random.default_rng([self._seed, first_row]).integers(1, 1 << 63, n, dtype=np.uint64)

        alone = np.flatnonzero(np.abs(told - 1.0) > _ROUNDING)
        sums[alone], cell[alone] = 0.0, -1
        rays = empty_rays(len(alone), random[alone] if len(random) else None)
        solid, facet, index = self._convex.solid, self._convex.facet, self._builder.model.index
        enter_rays(points[alone], view.basis(), solid, facet, index, rays)
        self._follow(rays, alone, np.ones(len(alone)), sums)
        covered = np.ones(n, dtype=bool)
        covered[alone] = rays.facts[0, : len(alone)] != RayStatus.MISSED

        pixel, aside = np.flatnonzero(cell >= 0), np.arange(_MOST_RAYS, dtype=np.uint64) * _ODD
        for k in range(_MOST_RAYS):  # of each pixel one after the other
            pixel = pixel[self._rays[cell[pixel]] > k]
            if not len(pixel):
                break
            of, states = cell[pixel], (random[pixel] + aside[k]) | np.uint64(1)
            rays = cell_rays(self._starts, self._maps, of, points[pixel], states)
            self._follow(rays, pixel, 1.0 / self._rays[of], sums)
        return sums, covered

    def _follow(self, rays: Rays, pixel: np.ndarray, area: np.ndarray, sums: np.ndarray) -> None:
        """Follow a ray for each of some pixels (m,), and add what it finds to their sums, times area (m,)."""
        convex, model, n = self._convex, self._builder.model, len(pixel)
        follow_rays(convex.solid, convex.facet, model.index, model.max_reflections, rays)
        paths = ray_paths(rays, convex.facet, area, convex.stone)
        for first in range(0, len(paths), max(n, 1)):  # of each ray one path, and then its later exit
            met = np.flatnonzero(paths.status[first : first + n] != RayStatus.MISSED)
            some = paths.rows(first + met)
            sums[pixel[met]] += some.area[:, None] * self._builder.added(self._builder.light(some))


@jit
def _draw(
    corners: Any, starts: Any, ends: Any, added: Any, told: Any, cell: Any, resolution: int,
    half_width: float, aside: Any, first_row: int, sums: Any, told_of_pixel: Any, cell_of_pixel: Any,
) -> None:  # fmt: skip
    """Add to every pixel whose place lies in a convex polygon what the polygon does."""
    step = 2.0 * half_width / resolution
    x0, y0 = -half_width + 0.5 * step + aside[0], half_width - 0.5 * step + aside[1]
    last_row = first_row + len(told_of_pixel) // resolution - 1
    for f in range(len(starts)):
        low = high = corners[starts[f], 1]
        for k in range(starts[f] + 1, ends[f]):
            low, high = min(low, corners[k, 1]), max(high, corners[k, 1])
        top = max(math.ceil((y0 - high) / step), first_row)
        bottom = min(math.floor((y0 - low) / step), last_row)
        for row in range(top, bottom + 1):
            y = y0 - row * step
            left, right = half_width, -half_width
            before = ends[f] - 1
            for k in range(starts[f], ends[f]):
                if (corners[before, 1] <= y) != (corners[k, 1] <= y):
                    share = (y - corners[before, 1]) / (corners[k, 1] - corners[before, 1])
                    x = corners[before, 0] + share * (corners[k, 0] - corners[before, 0])
                    left, right = min(left, x), max(right, x)
                before = k
            first = max(math.ceil((left - x0) / step), 0)
            last = min(math.ceil((right - x0) / step), resolution)
            for column in range(first, last):
                pixel = (row - first_row) * resolution + column
                told_of_pixel[pixel] += told[f]
                if cell[f] >= 0:
                    cell_of_pixel[pixel] = cell[f]
                    continue
                for j in range(added.shape[1]):
                    sums[pixel, j] += added[f, j]

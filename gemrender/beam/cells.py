"""The cells that no polygon tells, as triangles, and rays spread over them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import jit
from gemrender.beam.facets import FacetStatus, VirtualFacets
from gemrender.beam.rays import (
    COS_ENTRY,
    DIRECTION,
    ENTRY,
    EXIT,
    FACTOR,
    INSIDE,
    NORMAL,
    PARTIAL,
    POINT,
    REFLECTIONS,
    STATUS,
    UNFOLD,
    WEIGHT,
    Rays,
    empty_rays,
)
from gemrender.optics.fresnel import transmittance
from gemrender.paths import Paths

__all__ = ["Cells", "cell_rays", "cell_starts", "fans", "spread", "starts_of", "triangle_areas"]


class Cells:
    """The girdle cells, as triangles one after the other; their rays go on where the polygons end.

    Parameters
    ----------
    facets : VirtualFacets
        The polygons.
    of_principal : bool
        Whether the cells are those of principal light, or of light that has been reflected in part.

    Attributes
    ----------
    area : float
        Area of all of them; of light that has been reflected in part, each times the share of the light at
        the eye that is in it [girdle radius^2].
    largest : float
        As any region has it (`near_girdle`).
    """

    def __init__(self, facets: VirtualFacets, *, of_principal: bool) -> None:
        is_chosen = (facets.paths.partial_reflections == 0) == of_principal
        cells = np.flatnonzero((facets.status == FacetStatus.GIRDLE) & is_chosen)
        self._cell, corners = fans(facets.starts[cells], facets.ends[cells])
        self._triangles = facets.corners[corners]
        # Every ray of light that has been reflected in part has the same share of the light at the eye, so
        # that all shares together make just what there is.
        self._weights = facets.paths.weight[cells]
        if not of_principal:
            self._weights *= transmittance(facets.paths.cos_entry[cells], facets.model.index)
        areas = np.abs(triangle_areas(self._triangles))
        self._upto = np.cumsum(areas * self._weights[self._cell])
        self.area = float(self._upto[-1]) if len(self._upto) else 0.0
        self.largest = self.area  # all rays are alike
        self._maps = facets.exit_map[cells]
        self._starts = starts_of(facets, cells)

    def rays(self, unit: np.ndarray, random: np.ndarray) -> tuple[Rays, np.ndarray, np.ndarray]:
        """Spread rays over them, of each area as many as its share of the light says.

        Parameters
        ----------
        unit : (n, 2) float64
            Points of the unit square.
        random : (n,) uint64
            States of the rays' random numbers; (0,) if only principal light is followed.

        Returns
        -------
        rays : Rays
            n rays inside the stone.
        areas : (n,) float64
            What each stands for, if there were but one point in the unit square [girdle radius^2].
        of : (n,) int64
            The point of the unit square that each was made from.
        """
        rays, cell = empty_rays(len(unit), random), np.empty(len(unit), np.int64)
        spread(unit, self._upto, self._triangles, self._cell, self._maps, self._starts, rays, cell)
        return rays, self.area / self._weights[cell], np.arange(len(unit))


def cell_rays(
    starts: Rays, maps: np.ndarray, cell: np.ndarray, places: np.ndarray, random: np.ndarray
) -> Rays:
    """Put a ray into a cell at each of some places in the view.

    Parameters
    ----------
    starts, maps : Rays, (k, 3, 3) float64
        As `cell_starts` makes them, and `VirtualFacets.exit_map`, of k cells.
    cell, places : (n,) int64, (n, 2) float64
        The cell of each, and the place [girdle radius].
    random : (n,) uint64
        States of the rays' random numbers; (0,) if only principal light is followed.
    """
    rays, n, by_place = empty_rays(len(cell), random), len(cell), maps[cell]
    rays.numbers[:, :n], rays.facts[:, :n] = starts.numbers[:, cell], starts.facts[:, cell]
    point = by_place[:, 0] + places[:, :1] * by_place[:, 1] + places[:, 1:] * by_place[:, 2]
    rays.numbers[POINT:DIRECTION, :n] = point.T
    return rays


def starts_of(facets: VirtualFacets, cells: np.ndarray) -> Rays:
    """Return the ray of each of some girdle cells (k,), but for its place."""
    unfolding = None if facets.unfolding is None else facets.unfolding[facets.node[cells]]
    return cell_starts(facets.paths.rows(cells), unfolding)


def cell_starts(paths: Paths, unfolding: np.ndarray | None) -> Rays:
    """Return the ray of each of some girdle cells, but for its place.

    Parameters
    ----------
    paths : Paths
        The paths of k cells.
    unfolding : (k, 3, 3) float64 or None
        Where all light is followed, what mirrors a direction back through the reflections of each.
    """
    n = len(paths)
    rays = empty_rays(n, None if unfolding is None else np.ones(n, np.uint64))
    numbers, facts = rays.numbers, rays.facts
    numbers[DIRECTION:COS_ENTRY, :n] = paths.exit_direction.T
    numbers[COS_ENTRY, :n] = paths.cos_entry
    facts[STATUS, :n], facts[EXIT, :n] = INSIDE, -1
    facts[REFLECTIONS, :n], facts[PARTIAL, :n] = paths.reflections, paths.partial_reflections
    facts[ENTRY, :n] = paths.entry_facet
    if unfolding is not None and paths.entry_normal is not None:
        numbers[WEIGHT, :n], numbers[FACTOR, :n] = paths.weight, 1.0
        numbers[NORMAL:UNFOLD, :n] = paths.entry_normal.T
        numbers[UNFOLD:, :n] = unfolding.reshape(n, 9).T
    return rays


def fans(starts: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut polygons, whose corners begin and end at (k,), into fans of triangles about their first corners.

    Returns
    -------
    (t,) int64, (t, 3) int64
        The polygon of each triangle, and its corners.
    """
    number = ends - starts - 2
    apex = np.repeat(starts, number)
    second = apex + 1 + np.arange(len(apex)) - np.repeat(np.cumsum(number) - number, number)
    return np.repeat(np.arange(len(starts)), number), np.stack([apex, second, second + 1], axis=1)


def triangle_areas(triangles: np.ndarray) -> np.ndarray:
    """Return the areas of triangles (t, 3, 2), (t,), those of clockwise ones negative."""
    a, b = (triangles[:, k] - triangles[:, 0] for k in (1, 2))
    return np.asarray(0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))


@jit
def spread(
    unit: Any, upto: Any, triangles: Any, cell: Any, maps: Any, starts: Any, rays: Any, of: Any
) -> None:  # fmt: skip
    """Put rays into triangles, and write the cell of each."""
    last, total = len(upto) - 1, upto[-1]
    for i in range(len(unit)):
        x = unit[i, 0] * total
        low, high = 0, last
        while low < high:
            middle = (low + high) // 2
            if upto[middle] > x:
                high = middle
            else:
                low = middle + 1
        below = upto[low - 1] if low > 0 else 0.0
        across = np.sqrt(min(max((x - below) / (upto[low] - below), 0.0), 1.0))
        along, t, c = unit[i, 1], triangles[low], cell[low]
        u = (1.0 - across) * t[0, 0] + across * ((1.0 - along) * t[1, 0] + along * t[2, 0])
        v = (1.0 - across) * t[0, 1] + across * ((1.0 - along) * t[1, 1] + along * t[2, 1])
        for row in range(rays.numbers.shape[0]):
            rays.numbers[row, i] = starts.numbers[row, c]
        for row in range(rays.facts.shape[0]):
            rays.facts[row, i] = starts.facts[row, c]
        for j in range(3):
            rays.numbers[POINT + j, i] = maps[c, 0, j] + u * maps[c, 1, j] + v * maps[c, 2, j]
        of[i] = c

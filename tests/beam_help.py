"""Stones and views for the tests of the exact engine."""

from __future__ import annotations

import numpy as np

from gemrender.beam import FacetStatus, VirtualFacets
from gemrender.beam.polygons import area
from gemrender.cuts import RoundBrilliant
from gemrender.stone import Stone

#: Upright planes around the view of a round stone, seen from straight above (`beam.solid`).
RIM_SIDES = 256
#: Area that polygons tell of such a view: of a regular polygon in the circle of radius 1.
TOLD_AREA = RIM_SIDES / 2 * np.sin(2 * np.pi / RIM_SIDES)


def girdle_heavy_brilliant(rng: np.random.Generator) -> RoundBrilliant:
    """Draw a stone with much light near the girdle: a thick girdle, a large table, a low crown."""
    ranges = {
        "table": (62, 70), "star": (40, 55), "lower_girdle_contact": (10, 20), "crown_height": (8, 12),
        "pavilion_depth": (44, 48), "girdle_thickness": (4, 8),
    }  # fmt: skip
    return RoundBrilliant(**{key: float(rng.uniform(*range_)) for key, range_ in ranges.items()})


def gem(proportions: RoundBrilliant, number: int = 0) -> Stone:
    return Stone.from_proportions(proportions, name=f"random {number}")


def owners(facets: VirtualFacets, points: np.ndarray, margin: float) -> list[list[int]]:
    """For each point (n, 2) the virtual facets that hold it; none for one within the margin of an edge."""
    out: list[list[int]] = [[] for _ in points]
    near_edge = np.zeros(len(points), dtype=bool)
    # Of most polygons the box holds none of the points
    ends = np.column_stack([facets.starts, facets.ends]).ravel()
    corners = np.concatenate([facets.corners, facets.corners[-1:]])  # the last end is one, too
    low, high = (of.reduceat(corners, ends)[::2][:, None] for of in (np.minimum, np.maximum))
    in_box = ((low - margin <= points) & (points <= high + margin)).all(axis=-1)
    for i in np.flatnonzero(in_box.any(axis=1) & (facets.area >= margin**2)).tolist():
        corners, among = facets.polygon(i), np.flatnonzero(in_box[i])
        along = np.roll(corners, -1, axis=0) - corners
        length = np.linalg.norm(along, axis=1)
        gap = points[among, None] - corners
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = (along[:, 0] * gap[..., 1] - along[:, 1] * gap[..., 0]) / length
        least = np.nanmin(inside, axis=1)
        near_edge[among[np.abs(least) <= margin]] = True
        for k in among[least > 0]:
            out[k].append(i)
    return [[] if near else held for near, held in zip(near_edge, out, strict=True)]


def covered_area(facets: VirtualFacets) -> float:
    """Area of the facets' outlines in the view [girdle radius^2]."""
    total, begin = 0.0, 0
    for end in facets.covered_ends:
        if end > begin:
            total += float(area(facets.covered[begin:], end - begin))
        begin = end
    return total


def path_of(facets: VirtualFacets, i: int) -> tuple[list[int], bool]:
    """The facets that a virtual facet's light meets, and whether that is its whole path."""
    return facets.path(i), facets.status[i] == FacetStatus.EXITED

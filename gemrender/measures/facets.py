"""How finely a view is divided: `facets`, number and sizes of its virtual facets."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.measures.aset import ZONES, zone
from gemrender.measures.measure import Light, Measure

__all__ = ["VirtualFacetSizes", "half_area_number"]

#: Smaller ones are slivers of rounding [share of the view].
_SMALLEST = 1e-12
_ZONES = ("green", "red", "blue", "leak")


def half_area_number(sizes: np.ndarray) -> int:
    """Return how many of the largest of some sizes (n,) make half of their sum; 0 of none."""
    if not len(sizes):
        return 0
    largest_first = np.cumsum(np.sort(sizes)[::-1])
    return int(np.searchsorted(largest_first, 0.5 * largest_first[-1] * (1.0 - 1e-12))) + 1


class VirtualFacetSizes(Measure):
    """Number and sizes of virtual facets."""

    name, version = "facets", 1
    definition = (
        "virtual facets, areas of the view whose principal light meets the same facets: their number, the "
        "largest and the median [% of their area], and half, the number of the largest that make half of "
        "it; number, share [%] and half of those of each zone of `aset`, too"
    )
    source = "virtual facets: Sasian, Quick, Sheffield, Caudill & Yantzer, Opt. Eng. 46, 093604 (2007)"
    keys = ()
    detail_keys = (
        "number", "half", "largest", "median",
        *(f"{name}_{what}" for name in _ZONES for what in ("number", "share", "half")),
    )  # fmt: skip
    follow = "principal"
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return nothing, (n, 0): numbers of facets are no sums of areas."""
        return np.zeros((len(light), 0))

    def details(self, light: Light) -> dict[str, Any]:
        """Return the numbers and sizes, of paths each of which is a virtual facet."""
        paths = light.paths
        area = np.where(light.is_principal, paths.area.real, 0.0)
        rows = np.flatnonzero(area > _SMALLEST * area.sum())
        images = np.ones(len(rows), dtype=np.int64) if paths.images is None else paths.images[rows]
        # Of a part of a symmetric view a row stands for so many facets, which together have its share.
        sizes = np.repeat(100.0 * area[rows] / area.sum() / images, images)
        zones = np.repeat(np.where(light.is_exit, zone(light), -1)[rows], images)
        out: dict[str, Any] = {
            "number": len(sizes),
            "half": half_area_number(sizes),
            "largest": float(sizes.max(initial=0.0)),
            "median": float(np.median(sizes)) if len(sizes) else 0.0,
        }
        for name in _ZONES:
            of_zone = sizes[zones == ZONES.index(name)]
            out[f"{name}_number"] = len(of_zone)
            out[f"{name}_share"] = float(of_zone.sum())
            out[f"{name}_half"] = half_area_number(of_zone)
        return out

"""GemRay's own light return, for comparing with it: `gemray-iso`, `gemray-cos` and `gemray-sc2`."""

from __future__ import annotations

import numpy as np

from gemrender.measures.iso import HEAD_WORDS, SkyMeasure, sky_light
from gemrender.measures.measure import Light, in_columns

__all__ = ["LEAST_WEIGHT", "MOST_HITS", "TABLE_RISE", "GemRay"]

#: Facets that light meets inside, at most, the one that it leaves by included.
MOST_HITS = 9
#: Share of the light at the eye below which it is followed no further.
LEAST_WEIGHT = 1e-3
#: Facets whose normals rise by more than this are the table.
TABLE_RISE = 0.9999


class GemRay(SkyMeasure):
    """Light return as GemRay caps it, of the whole stone and of what is seen through its table."""

    version = 1
    source = "GemRay 1.2.0"
    keys = ("value", "internal", "surface", "tied", "table", "table_share")
    smooth_keys = keys

    def __init__(self, sky: str) -> None:
        super().__init__(sky)
        self.name = f"gemray-{sky}"
        self.definition = (
            f"{sky} with at most {MOST_HITS} hits inside, and no light of a share below {LEAST_WEIGHT:g}; "
            "for the whole stone and for its table (facets of entry whose normal rises by more than "
            f"{TABLE_RISE}; none if there is none); g = {self.formula}, {HEAD_WORDS}"
        )

    def contributions(self, light: Light) -> np.ndarray:
        """Return what counts by GemRay's rules, (n, 6): together, inside, surface, tied, table, its share."""
        paths = light.paths
        is_counted = (paths.reflections < MOST_HITS) & (light.arriving.real >= LEAST_WEIGHT)
        internal, surface, tied, tied_surface = sky_light(light, self.sky)
        internal, tied = is_counted * internal, is_counted * tied + tied_surface
        together = internal + surface
        # A round girdle has no normal of its own; it is the last facet, and no table.
        is_table = np.append(paths.stone.facet_normals[:, 2] > TABLE_RISE, False)[paths.entry_facet]
        table = np.where(is_table, together, 0.0)
        return in_columns(together, internal, surface, tied, table, is_table & light.is_principal)

    def values(self, sums: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return per cent of the view, and of the table for `table`: NaN where there is none."""
        out = super().values(sums, area)
        with np.errstate(divide="ignore", invalid="ignore"):
            out[..., 4] = np.where(sums[..., 5].real > 0.0, 100.0 * sums[..., 4] / sums[..., 5], np.nan)
        return out

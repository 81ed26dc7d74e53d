"""Weighted light return of a crown under a bright hemisphere: `wlr-like`, a sum over all views from above."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure, in_columns
from gemrender.stone.facets import CROWN

__all__ = ["WlrLike"]


class WlrLike(Measure):
    """Light that a crown gives back, seen from all around.

    Each view stands for the light that falls in from there, and areas are those of the view times the solid
    angle of its direction, of the upper hemisphere together 2 pi [stone's unit^2 sr]. Then the areas of what
    enters by the crown are the flux on it, pi times the sum of A (1 + n_z)/2.
    """

    name, version = "wlr-like", 1
    definition = (
        "what the crown's facets give back of the light that a uniform hemisphere sends on them alone: the "
        "sum of w (1 - R) d^2 over exits through the crown with d > 0, d the cosine with the stone's axis, "
        "without the first reflection, divided by the flux on the crown, pi sum A (1 + n_z)/2. Not GIA's "
        "number, whose normalisation is unpublished: the shape agrees"
    )
    source = "after Hemphill, Reinitz, Johnson & Shigley, Gems & Gemology 34, 158 (1998)"
    channels = ("returned", "fallen")
    unit = ""
    smooth_keys = ("value",)
    is_axial = True
    views = "hemisphere"

    def contributions(self, light: Light) -> np.ndarray:
        """Return the light given back, and 1 for what falls on the crown, (n, 2)."""
        falls, d = light.enters_by(CROWN), light.paths.exit_direction[:, 2].real
        returned = falls & light.leaves_by(CROWN) & (d > 0.0)
        return in_columns(np.where(returned, light.share * d**2, 0.0), falls & light.is_principal)

    def values(self, sums: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return the light given back as a share of what falls on the crown, 0 to 1."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(sums[..., :1] / sums[..., 1:])

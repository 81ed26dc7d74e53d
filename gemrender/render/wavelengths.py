"""The wavelengths that pictures are made of, drawn by how much they count in a picture's colours."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from gemrender.colorimetry import VISIBLE_NM

__all__ = ["FIRST_NM", "LAST_NM", "binned", "drawing_table"]

#: Wavelengths that pictures are made of [nm].
FIRST_NM, LAST_NM = VISIBLE_NM
#: Entries of the table that wavelengths are drawn by.
_N_DRAW = 1024


def drawing_table() -> Any:
    """Return what draws four wavelengths from one number, by how much they count in linear sRGB."""
    import drjit as dr
    import mitsuba as mi

    from gemrender.colorimetry import colour_matching, matrix_to_linear_srgb, y_integral_nm

    grid = np.linspace(FIRST_NM, LAST_NM, 3801)
    # That has the least variance in a picture; and some of each wavelength, so that none has a great weight
    response = np.linalg.norm(colour_matching(grid) @ matrix_to_linear_srgb().T, axis=1)
    density = response + 0.05 * response.max()
    cumulative = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    nm = np.interp(np.linspace(0, 1, _N_DRAW + 1), cumulative / cumulative[-1], grid)
    places = mi.Float(nm.astype(np.float32))
    rows = np.arange(int(FIRST_NM), int(LAST_NM) + 2, dtype=np.float64)
    matching = colour_matching(rows).astype(np.float32) / y_integral_nm()
    tables = [mi.Float(np.ascontiguousarray(column, dtype=np.float32)) for column in matching.T]

    def draw(u: Any) -> tuple[Any, list[Any], list[list[Any]]]:
        lanes = len(mi.Spectrum())
        wavelengths, weights, responses = [], [], []
        for k in range(lanes):
            shifted = u + k / lanes
            shifted = dr.select(shifted >= 1, shifted - 1, shifted) * _N_DRAW
            row = dr.minimum(mi.UInt32(shifted), _N_DRAW - 1)
            a, b = dr.gather(mi.Float, places, row), dr.gather(mi.Float, places, row + 1)
            at = dr.fma(shifted - mi.Float(row), b - a, a)
            wavelengths.append(at)
            weights.append((b - a) * (_N_DRAW / lanes))
            place = at - FIRST_NM
            below = mi.UInt32(place)
            part = place - mi.Float(below)
            responses.append(
                [
                    dr.lerp(dr.gather(mi.Float, t, below), dr.gather(mi.Float, t, below + 1), part)
                    for t in tables
                ]
            )
        return mi.Spectrum(wavelengths), weights, responses

    return draw


def binned(bins_nm: np.ndarray, radiance: Any, weight: Any, nm: Any) -> list[Any]:
    """Return the radiance in each bin between edges [nm], a mean over its width, of what was drawn."""
    import drjit as dr
    import mitsuba as mi

    out = []
    for low, high in pairwise(bins_nm):
        total = mi.Float(0)
        for L, w, at in zip(radiance, weight, nm, strict=True):
            total += dr.select((at >= float(low)) & (at < float(high)), L * w, 0)
        out.append(total / float(high - low))
    return out

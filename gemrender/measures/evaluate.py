"""Measures evaluated: what paths add to each, and the values that come of it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gemrender.measures.measure import Light, Measure
from gemrender.paths import Paths

__all__ = ["area_sums", "contributions", "evaluate", "light_of"]


def contributions(measure: Measure, light: Light) -> np.ndarray:
    """Return what each path adds to each channel of a measure, (n, k).

    Of a measure of the principal light these are the paths of `light.principal`.

    Raises
    ------
    ValueError
        The measure returns another shape.
    """
    light = light_of(measure, light)
    found = np.asarray(measure.contributions(light))
    found = found.astype(np.result_type(np.float64, found), copy=False)
    found = found[:, None] if found.ndim == 1 else found
    expected = (len(light), len(measure.channels or measure.keys))
    if found.shape != expected:
        raise ValueError(f"contributions of {measure.name} must have shape {expected}, got {found.shape}")
    return found


def light_of(measure: Measure, light: Light) -> Light:
    """Return the light that a measure is given: all of it, or the principal paths."""
    return light.principal if measure.follow == "principal" else light


def evaluate(lights: Iterable[Light], measures: Iterable[Measure]) -> dict[str, dict[str, float]]:
    """Return what measures say of paths, whoever has traced them.

    Parameters
    ----------
    lights : iterable of Light
        The paths, in parts or, for measures of the hemisphere, of many views; none is kept.
    measures : iterable of Measure
        What to measure.

    Returns
    -------
    dict of dict
        Of each measure's name its values by name; NaN where one is not defined.
    """
    chosen = list(measures)
    sums, area = [np.zeros(len(measure.channels or measure.keys)) for measure in chosen], 0.0
    for light in lights:
        principal = light.principal
        area += float(principal.paths.area.real @ principal.is_principal)
        for total, measure in zip(sums, chosen, strict=True):
            total += area_sums(light_of(measure, light).paths, contributions(measure, light)).real
    return {
        measure.name: dict(zip(measure.keys, map(float, measure.values(total, np.array(area))), strict=True))
        for total, measure in zip(sums, chosen, strict=True)
    }


def area_sums(paths: Paths, added: np.ndarray) -> np.ndarray:
    """Return the sums (k,) of area times what each path adds per unit of it, (n, k) [stone's unit^2]."""
    # By einsum: BLAS would start threads for each.
    return np.array([np.einsum("i,i->", paths.area, column) for column in added.T])

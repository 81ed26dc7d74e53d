"""Measures evaluated: what paths add to each, their sums, and the values that come of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gemrender.measures.measure import Light, Measure

__all__ = ["Evaluation", "contributions", "evaluate"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evaluation:
    """What a measure finds in paths.

    Attributes
    ----------
    measure : Measure
        The measure.
    sums : (k,) float64
        Areas times contributions of the paths that belong to no set, summed up [stone's unit^2].
    area : float
        Area of the view that they make [stone's unit^2].
    set_sums, set_areas : (n_sets, k) float64, (n_sets,) float64
        The same of the paths of each set (`Paths.set_number`).
    details : dict
        Values that are no sums.
    """

    measure: Measure
    sums: np.ndarray
    area: float
    set_sums: np.ndarray
    set_areas: np.ndarray
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """The values by name, of all paths together, with the details; NaN where one is not defined."""
        found = self.measure.values(self.sums + self.set_sums.sum(axis=0), self.area + self.set_areas.sum())
        return dict(zip(self.measure.keys, map(float, found), strict=True)) | self.details

    @property
    def set_values(self) -> np.ndarray:
        """The values as each set by itself has them, (n_sets, number of keys): their scatter tells the error.

        A set stands for what all sets together stand for, so it counts as often as there are sets.
        """
        n_sets = len(self.set_areas)
        return self.measure.values(self.sums + n_sets * self.set_sums, self.area + n_sets * self.set_areas)


def contributions(measure: Measure, light: Light) -> np.ndarray:
    """Return what each path adds to each channel of a measure, (n, k).

    Of a measure of the principal light these are the paths of `light.principal`.

    Raises
    ------
    ValueError
        The measure returns another shape.
    """
    light = light_of(measure, light)
    found = np.asarray(measure.contributions(light), dtype=np.float64)
    found = found[:, None] if found.ndim == 1 else found
    expected = (len(light), len(measure.channels or measure.keys))
    if found.shape != expected:
        raise ValueError(f"contributions of {measure.name} must have shape {expected}, got {found.shape}")
    return found


def light_of(measure: Measure, light: Light) -> Light:
    """Return the light that a measure is given: all of it, or the principal paths."""
    return light.principal if measure.follow == "principal" else light


def evaluate(
    lights: Iterable[Light], measures: Sequence[Measure], *, details: bool = False
) -> dict[str, Evaluation]:
    """Evaluate measures of one set of paths.

    Parameters
    ----------
    lights : iterable of Light
        The paths, in parts or, for measures of the hemisphere, of many views; each is taken once, and none is
        kept.
    measures : sequence of Measure
        What to evaluate.
    details : bool
        Whether paths that belong to no set are virtual facets, and may be asked for details.

    Returns
    -------
    dict of Evaluation
        By the measures' names.
    """
    ends = np.cumsum([0, *(len(measure.channels or measure.keys) for measure in measures)])
    sums, by_set = np.zeros(ends[-1] + 1), np.zeros((0, ends[-1] + 1))  # the area last
    told: list[dict[str, Any]] = [{} for _ in measures]
    for light in lights:
        n_sets = 0 if light.paths.set_number is None else int(light.paths.set_number.max(initial=-1)) + 1
        by_set = np.pad(by_set, ((0, max(n_sets - len(by_set), 0)), (0, 0)))
        parts = [(light_of(measure, light), contributions(measure, light)) for measure in measures]
        parts.append((light.principal, light.principal.is_principal[:, None].astype(np.float64)))
        columns = [(of.paths, column) for of, part in parts for column in part.T]
        for k, (paths, column) in enumerate(columns):
            if paths.set_number is None:
                # By einsum: BLAS would start threads for each.
                sums[k] += np.einsum("i,i->", paths.area.real, column)
            else:
                by_set[:, k] += np.bincount(paths.set_number, paths.area.real * column, len(by_set))
        if details and light.paths.set_number is None:
            for known, measure in zip(told, measures, strict=True):
                known |= measure.details(light_of(measure, light))
    return {
        measure.name: Evaluation(
            measure=measure,
            sums=sums[first:last],
            area=float(sums[-1]),
            set_sums=by_set[:, first:last],
            set_areas=by_set[:, -1],
            details=known,
        )
        for measure, first, last, known in zip(measures, ends[:-1], ends[1:], told, strict=True)
    }

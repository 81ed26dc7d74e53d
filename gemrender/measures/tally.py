"""What is summed up over paths for a score: Inoue's sums, and those of further measures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gemrender.measures import inoue
from gemrender.measures.evaluate import area_sums, contributions, light_of
from gemrender.measures.measure import HEAD_DEG, Light, Measure
from gemrender.observation import Model, RayStatus, View
from gemrender.paths import Paths

__all__ = ["REST", "SETS", "STUDENT_T", "Tally", "bounds_of_sets"]

#: Independent sets of rays; Student's t for their mean with 15 degrees of freedom, two-sided, 99.9 %. More
#: sets have a smaller t, and fewer rays each: for the same rays 16 give the smallest bound.
SETS, STUDENT_T = 16, 4.073

#: What is summed up behind Inoue's sums: area times share of later light that is still inside at the end.
REST = inoue.N_SUMS
_INSIDE = (RayStatus.TRAPPED, RayStatus.LOST)


class Tally:
    """Sums over paths of one view, and the values that they make.

    Parameters
    ----------
    view, model : View, Model
        From where and by which model the paths are traced.
    measures : sequence of Measure
        The measures, besides Inoue's.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    zenith : (3,) float64, optional
        The viewer's zenith (`Light`).

    Attributes
    ----------
    n_sums : int
        Numbers that are summed up: first those of `inoue.sum_up`; where there are measures, then `REST` and
        the channels of each.
    follows_all : bool
        Whether a measure needs all light.
    needs_normals : bool
        Whether a measure needs the normals of paths.
    needs_images : bool
        Whether a measure needs the angle between the two images of paths.
    is_axial : bool
        Whether a part of a symmetric stone's view is enough for all of them.
    """

    def __init__(
        self,
        view: View,
        model: Model,
        measures: Sequence[Measure] = (),
        head_deg: float = HEAD_DEG,
        zenith: np.ndarray | None = None,
    ) -> None:
        self.view, self.model, self.measures = view, model, tuple(measures)
        self.head_deg, self.zenith = head_deg, zenith
        self.follows_all = any(measure.follow == "all" for measure in measures)
        self.needs_normals = any(measure.needs_normals for measure in measures)
        self.needs_images = any(measure.needs_images for measure in measures)
        self.is_axial = zenith is None and all(measure.is_axial for measure in measures)
        numbers = [len(measure.channels or measure.keys) for measure in measures]
        ends = REST + 1 + np.cumsum(numbers, dtype=np.int64)
        self._columns = [slice(end - n, end) for end, n in zip(ends, numbers, strict=True)]
        self.n_sums = REST + 1 + sum(numbers) if measures else inoue.N_SUMS

    def sum_up(self, paths: Paths, n_sets: int = 1) -> np.ndarray:
        """Sum up paths, each set of them (`Paths.set_number`) by itself; without sets all are one.

        Returns
        -------
        (n_sets, n_sums) float64
            Areas, or areas times contributions [stone's unit^2].
        """
        rear = inoue.rear_mask(paths, self.model)
        intensity = inoue.primary_intensity(paths, self.model, rear)
        out = np.zeros((n_sets, self.n_sums))
        out[:, : inoue.N_SUMS] = inoue.sum_up(paths, rear, intensity, n_sets)
        if self.measures:
            light = self.light(paths)
            is_left = np.isin(paths.status, _INSIDE) & (paths.partial_reflections > 0)
            out[:, REST] = _sums(paths, (is_left * light.arriving)[:, None], n_sets)[:, 0]
            for measure, columns in zip(self.measures, self._columns, strict=True):
                of = light_of(measure, light)
                out[:, columns] = _sums(of.paths, contributions(measure, of), n_sets)
        return out

    def light(self, paths: Paths) -> Light:
        """Return paths as measures take them."""
        return Light(
            paths=paths, view=self.view, model=self.model, head_deg=self.head_deg, zenith=self.zenith
        )

    def of_model(self, model: Model) -> Tally:
        """Return the same with another model."""
        return Tally(self.view, model, self.measures, self.head_deg, self.zenith)

    def values(self, sums: np.ndarray) -> list[np.ndarray]:
        """Return the values of each measure, (..., len(keys)), from sums (..., n_sums)."""
        area = sums[..., inoue.MET]
        return [
            measure.values(sums[..., columns], area)
            for measure, columns in zip(self.measures, self._columns, strict=True)
        ]

    def changes(self, sums: np.ndarray, areas: Sequence[float]) -> list[np.ndarray]:
        """Return how much the values of each measure change with an area more in one channel, (len(keys),).

        It is the largest change among the channels; the sums are (n_sums,), the areas those of each measure.
        """
        out = []
        for measure, columns, area in zip(self.measures, self._columns, areas, strict=True):
            of = sums[columns]
            more = measure.values(of + area * np.eye(len(of)), np.full(len(of), sums[inoue.MET]))
            change = np.abs(more - measure.values(of, sums[inoue.MET]))
            out.append(change.max(axis=0, initial=0.0))
        return out


def bounds_of_sets(values: np.ndarray) -> np.ndarray:
    """Return the bounds (k,) that values of sets (SETS, k) give their mean, with a confidence of 99.9 %."""
    apart = values - np.add.reduce(values) / len(values)
    deviation = np.sqrt(np.add.reduce(apart * apart) / (len(values) - 1))  # `std` takes twice as long
    return np.asarray(STUDENT_T / np.sqrt(SETS) * deviation)


def _sums(paths: Paths, added: np.ndarray, n_sets: int) -> np.ndarray:
    """Sum up what each path adds per unit of its area, (n, k); (n_sets, k)."""
    if paths.set_number is None:
        return np.broadcast_to(area_sums(paths, added), (n_sets, added.shape[1]))
    out = np.empty((n_sets, added.shape[1]))
    for k, column in enumerate(added.T):
        out[:, k] = np.bincount(paths.set_number, paths.area * column, n_sets)
    return out

"""What derivatives of scores are, and how they are put together."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from gemrender.beam.compiled import STEP
from gemrender.errors import InputError
from gemrender.measures import inoue
from gemrender.measures.measure import Measure
from gemrender.measures.tally import REST, Tally, bounds_of_sets
from gemrender.observation import LIGHT_LEVEL
from gemrender.shown import Tabled
from gemrender.stone import Stone

__all__ = [
    "Derivative",
    "Sensitivity",
    "ValueSlope",
    "are_wanted",
    "derivative",
    "result",
    "score_slopes",
    "smooth_values",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ValueSlope:
    """How fast a measure's value changes with one parameter.

    Attributes
    ----------
    measure, key : str
        Name of the measure and of its value.
    unit : str
        The value's unit, such as "%".
    slope, bound : float
        Its derivative, NaN where the value is not defined, and how far that may be off, with a confidence of
        99.9 % [the value's unit per unit of the parameter].
    """

    measure: str
    key: str
    unit: str
    slope: float
    bound: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Derivative:
    """How fast the scores change with one parameter.

    Attributes
    ----------
    parameter : str
        Its name, as stone files have it; of a design the tier's name and "angle" or "distance".
    kept : str
        What stays as it is: the other "proportions", the other "angles" of a laboratory report, or the other
        "tiers" of a design.
    unit : str
        "%" or "deg"; distances of tiers are in per cent of half the stone's length.
    average, rear : float
        d(Average) and d(Rear) [% per unit].
    average_bound, rear_bound : float
        How far they may be off, with a confidence of 99.9 % [% per unit]. Where the derivatives on the two
        sides differ, their mean is told, and half of the difference counts here.
    measures : tuple of ValueSlope
        The values of further measures.
    """

    parameter: str
    kept: str
    unit: str
    average: float
    rear: float
    average_bound: float
    rear_bound: float
    measures: tuple[ValueSlope, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the derivatives for JSON; those of further measures by name, if there are any."""
        out = asdict(self)
        del out["measures"]
        measures: dict[str, dict[str, Any]] = {}
        for of in self.measures:
            is_known = not np.isnan(of.slope)
            told = {"slope": of.slope if is_known else None, "bound": of.bound if is_known else None}
            measures.setdefault(of.measure, {})[of.key] = told
        return out | ({"measures": measures} if measures else {})


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Sensitivity(Tabled):
    """The derivatives of one stone's scores.

    Attributes
    ----------
    name : str
        The stone's name.
    average, rear : float
        The scores themselves [%].
    derivatives : tuple of Derivative
        By the paper's proportions, then by what a laboratory report prints.
    girdle : float
        Share of the view that no virtual facet tells [%].
    fresnel, rear_rule, intensity : str
        The model's options.
    index : float
        Refractive index.
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye and its azimuth [deg].
    seconds : float
        Time that it took [s].
    """

    name: str
    average: float
    rear: float
    derivatives: tuple[Derivative, ...]
    girdle: float
    fresnel: str
    rear_rule: str
    intensity: str
    index: float
    tilt_deg: float
    tilt_azimuth_deg: float
    seconds: float

    def __repr__(self) -> str:
        return f"<Sensitivity of {self.name!r} to {len(self.derivatives)} parameters>"

    def to_dict(self) -> dict[str, object]:
        """Return the derivatives for JSON."""
        out = {each.name: getattr(self, each.name) for each in fields(self)}
        return out | {"derivatives": [of.to_dict() for of in self.derivatives]}


def are_wanted(
    parameters: Collection[str | tuple[str, str]] | None, known: Sequence[tuple[str, str]]
) -> list[bool]:
    """Return of each known parameter, (name, kept), whether it is among those that were asked for.

    Raises
    ------
    InputError
        One that is not known, or none at all.
    """
    if parameters is None:
        return [True] * len(known)
    allowed = {*known, *(name for name, _ in known)}
    for of in parameters:
        if of not in allowed:
            names = ", ".join(dict.fromkeys(name for name, _ in known))
            value = of if isinstance(of, str) else ", ".join(of)
            raise InputError(f"must be one of {names}", key="parameter", value=value)
    if not parameters:
        raise InputError("names none to differentiate by", key="parameter")
    return [(name, kept) in parameters or name in parameters for name, kept in known]


def smooth_values(tally: Tally, area: np.ndarray, channels: np.ndarray) -> np.ndarray:
    """Return the values that can be differentiated, measure by measure, (..., n).

    Parameters
    ----------
    tally : Tally
        The measures.
    area : (...,) float64 or complex128
        Area of the view [stone's unit^2].
    channels : (..., k) float64 or complex128
        Sums of all channels of the measures [stone's unit^2].
    """
    sums = np.zeros((*channels.shape[:-1], tally.n_sums), channels.dtype)
    sums[..., inoue.MET], sums[..., REST + 1 :] = area, channels
    out = [
        values[..., [of.keys.index(key) for key in of.smooth_keys]]
        for of, values in zip(tally.measures, tally.values(sums), strict=True)
    ]
    return np.concatenate(out, axis=-1) if out else np.zeros((*channels.shape[:-1], 0), channels.dtype)


def score_slopes(tally: Tally, totals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Average, Rear and values of measures, (2 + n,), and their derivatives.

    Parameters
    ----------
    tally : Tally
        The measures.
    totals : (1 or 2, SETS or 1, 4 + k) complex128
        What `gemrender.beam.totals.side_sums` returns, of a stone whose principal light is nothing but
        polygons.

    Returns
    -------
    (2 + n,) float64, (1 or 2, SETS or 1, 2 + n) float64
        Values, and derivatives of both sides by each set of rays.
    """
    scores = LIGHT_LEVEL * (totals[..., :2] / totals[..., 2:3])
    both = np.concatenate([scores, smooth_values(tally, totals[..., 2], totals[..., 4:])], axis=-1)
    return both[0].mean(axis=0).real, both.imag / STEP


def derivative(
    parameter: str, kept: str, unit: str, measures: Sequence[Measure], slopes: np.ndarray
) -> Derivative:
    """Put together the derivatives by a parameter.

    Parameters
    ----------
    parameter, kept, unit
        As in `Derivative`.
    measures : sequence of Measure
        The measures, in the order of their values.
    slopes : (1 or 2, SETS or 1, 2 + n) float64
        Derivatives of Average, Rear and the values of measures, where they differ on both sides, by each set
        of rays; one of what is exact.
    """
    sets, sides = slopes.mean(axis=0), slopes.mean(axis=1)
    means = sets.mean(axis=0).tolist()
    scatter = bounds_of_sets(sets) if len(sets) > 1 else 0.0
    bounds = (scatter + 0.5 * np.abs(sides[-1] - sides[0])).tolist()
    names = [(of.name, key, of.unit) for of in measures for key in of.smooth_keys]
    return Derivative(
        parameter=parameter, kept=kept, unit=unit,
        average=means[0], rear=means[1], average_bound=bounds[0], rear_bound=bounds[1],
        measures=tuple(
            ValueSlope(measure=measure, key=key, unit=of, slope=slope, bound=bound)
            for (measure, key, of), slope, bound in zip(names, means[2:], bounds[2:], strict=True)
        ),
    )  # fmt: skip


def result(
    stone: Stone,
    tally: Tally,
    scores: np.ndarray,
    derivatives: list[Derivative],
    girdle: float,
    start: float,
) -> Sensitivity:
    """Put the derivatives of a stone together.

    The scores (2 + n,) are Average, Rear, and values of measures; `start` is when the work began
    (`time.perf_counter`) [s].
    """
    view, model = tally.view, tally.model
    return Sensitivity(
        name=stone.name,
        average=float(scores[0]),
        rear=float(scores[1]),
        derivatives=tuple(derivatives),
        girdle=float(girdle),
        fresnel=model.fresnel,
        rear_rule=model.rear,
        intensity=model.intensity,
        index=model.index,
        tilt_deg=float(view.tilt_deg),
        tilt_azimuth_deg=float(view.tilt_azimuth_deg),
        seconds=time.perf_counter() - start,
    )

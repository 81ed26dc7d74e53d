"""How far it is to the next jump: scores are discontinuous where facets reach the critical angle.

Derivatives (`gemrender.beam.sensitivity`) hold up to there. A parameter is moved in steps to either side;
where a value changes more within a step than a threshold allows, halving tells whether it jumps, and where.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from gemrender.beam.by_parameters import changes_of
from gemrender.beam.by_proportions import PROPORTIONS
from gemrender.beam.by_tiers import KEPT_BY_WAY, design_unit, parameters_of_stone
from gemrender.beam.measure import measure
from gemrender.beam.sensitivity import check_differentiable
from gemrender.cuts import StoneLike, as_stone
from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.cuts.meets import changeable
from gemrender.cuts.round_brilliant import RoundBrilliant
from gemrender.cuts.turning import Free, Quantity
from gemrender.cuts.turning import parameter_name as tier_parameter_name
from gemrender.errors import InputError
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.measures.registry import chosen_measures
from gemrender.observation import Model, View
from gemrender.request import ShortForms, resolve, spelt_out
from gemrender.stone import Stone

__all__ = ["Cliff", "Jump", "Parameter", "check_reach", "find_cliffs", "parameters_of"]

#: How far is looked by default, by unit, and in how many steps.
REACH = {"deg": 1.0, "%": 2.0, "": 0.05}
STEPS = 50
#: A jump's place is told to this [% or deg].
PLACE = 1e-4
#: Changes by less are no cliff [% of the light].
THRESHOLD = 0.5


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """What of a stone can be moved.

    Attributes
    ----------
    name, kept, unit : str
        As in `gemrender.beam.derivatives.Derivative`.
    value : float
        What it is.
    moved : callable
        Returns the stone with it changed by so much; InputError if that makes no stone.
    """

    name: str
    kept: str
    unit: str
    value: float
    moved: Callable[[float], Stone]


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """By how much a measure's value jumps.

    Attributes
    ----------
    measure, key, unit : str
        Which value, and its unit.
    size : float
        Value above the jump minus that below, by the parameter.
    """

    measure: str
    key: str
    unit: str
    size: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Cliff:
    """The nearest jump to one side of a parameter.

    Attributes
    ----------
    parameter, kept, unit : str
        As in `Parameter`.
    value : float
        Where the stone is.
    side : {"below", "above"}
        To which side was looked.
    searched : float
        How far: to the jump, to the reach, or to the end of the parameter's range.
    at : float or None
        Where it jumps, to `PLACE`; None if nowhere so far.
    jumps : tuple of Jump
        Of every value.
    """

    parameter: str
    kept: str
    unit: str
    value: float
    side: str
    searched: float
    at: float | None
    jumps: tuple[Jump, ...] = ()

    @property
    def largest(self) -> Jump | None:
        """The value in per cent that jumps most."""
        counted = (of for of in self.jumps if _counts(of.unit, of.key))
        return max(counted, key=lambda of: abs(of.size), default=None)

    def to_dict(self) -> dict[str, Any]:
        """Return the cliff for JSON: jumps by measure and value; null for NaN."""
        out = asdict(self)
        jumps: dict[str, dict[str, float | None]] = {}
        for of in self.jumps:
            jumps.setdefault(of.measure, {})[of.key] = None if math.isnan(of.size) else of.size
        return out | {"jumps": jumps}


def check_reach(reach: float | None, threshold: float = THRESHOLD) -> None:
    """Refuse how far cliffs are looked for, and how large they must be, if that cannot be.

    Raises
    ------
    InputError
        One is no number above 0.
    """
    for key, number in (("reach", reach), ("threshold", threshold)):
        if number is not None and not (math.isfinite(number) and number > 0.0):
            raise InputError("must be a number above 0", key=key, value=number)


@spelt_out()
def find_cliffs(
    stone: StoneLike,
    parameters: Sequence[str | Parameter] | None = None,
    *,
    measures: str | Measure | Iterable[str | Measure] = "inoue",
    view: View | None = None,
    model: Model | None = None,
    head: float = HEAD_DEG,
    reach: float | None = None,
    threshold: float = THRESHOLD,
    values: Collection[str] | None = None,
    bound: float = 0.05,
    seed: int = 1,
    meets: str = "free",
    progress: Callable[[float], None] | None = None,
    **short: Unpack[ShortForms],
) -> tuple[Cliff, ...]:
    """Find the nearest jump of scores to either side of a stone's parameters.

    Parameters
    ----------
    stone : Stone, str or path
        A stone made from proportions or angles, from the parameters of a family, or from a design; or what
        `load_stone` takes.
    parameters : sequence of str or Parameter, optional
        Their names (`parameters_of`), or parameters of your own; by default all.
    measures : str, Measure, or iterable of them
        What to look at, as `gemrender.measures.chosen_measures` takes it. Values in per cent tell where a
        jump is, but for bands of intensity; of all of them its size is told.
    reach : float, optional
        How far to look [% or deg]; by default 1 deg, 2 %, or 0.05 of a ratio.
    threshold : float
        Changes by less are no cliff [% of the light].
    values : collection of str, optional
        The values that tell where a jump is, as "aset.leak"; by default all in per cent, but for bands.
    meets : {"free", "loose", "kept"}
        Of designs, what becomes of meet points, as for `gemrender.sensitivity`.
    seed : int
        Seed of rays near a round girdle: the same ones on both sides of a jump.
    **short
        As of `ShortForms`.

    Returns
    -------
    tuple of Cliff
        Two for each parameter, below and above it; those of your own come last.

    Raises
    ------
    InputError
        The stone was made from none of them, it has no such parameter, or a number is out of range.

    Notes
    -----
    Two jumps within one step, a fiftieth of the reach, that cancel each other are not seen, nor is one that a
    steep slope the other way hides by half of the threshold.
    """
    stone = as_stone(stone)
    check_reach(reach, threshold)
    chosen = chosen_measures(measures)
    counts = np.array([_counts(of.unit, key) for of in chosen for key in of.keys])
    if values is not None:
        counts &= [f"{of.name}.{key}" in values for of in chosen for key in of.keys]
    if not counts.any():
        names = ",".join(of.name for of in chosen)
        raise InputError("must have values in per cent, to tell a jump by", key="measures", value=names)
    view, model = resolve(stone, view, model, short)
    if isinstance(stone.cut, Design) and model.rear == "position":
        model = replace(model, rear="facet")  # as `by_tiers`: the girdle's edge does not stay level
    listed = [of for of in parameters or () if isinstance(of, str)]
    moving = [of for of in parameters or () if isinstance(of, Parameter)]
    if listed or parameters is None:
        known = parameters_of(stone, meets)
        for wanted in listed:
            if wanted not in (allowed := dict.fromkeys(of.name for of in known)):
                raise InputError(f"must be one of {', '.join(allowed)}", key="parameter", value=wanted)
        moving = [*(of for of in known if of.name in listed or parameters is None), *moving]
    measured = partial(
        _values, measures=chosen, view=view, model=model, head_deg=head, bound=bound, seed=seed
    )
    here, found = measured(stone), []
    for place, parameter in enumerate(moving):
        for half, side in enumerate((-1, 1)):
            walk = _Walk(parameter, side, measured, threshold, counts)
            found.append(walk.to(reach or REACH[parameter.unit], here, chosen))
            if progress is not None:
                progress((2 * place + half + 1) / (2 * len(moving)))
    return tuple(found)


def _values(
    stone: Stone, *, measures: tuple[Measure, ...], view: View, model: Model, **options: Any
) -> np.ndarray:
    """Return all values of measures, one after the other, (n,)."""
    told = measure(stone, view=view, model=model, measures=measures, **options).measures
    return np.array([value for of in told for value in of.values.values()])


def _counts(unit: str, key: str) -> bool:
    """Whether a value's jump is a cliff: facets go from one band to the next with their light unchanged."""
    return unit == "%" and not key.startswith("band_")


class _Walk:
    """A way from a stone along one parameter, to one side (-1 or 1), with values (n,) at each place."""

    def __init__(
        self,
        parameter: Parameter,
        side: int,
        values: Callable[[Stone], np.ndarray],
        threshold: float,
        counts: np.ndarray,
    ) -> None:
        self._parameter, self._side, self._values = parameter, side, values
        self._threshold, self._counts = threshold, counts

    def to(self, reach: float, here: np.ndarray, measures: Sequence[Measure]) -> Cliff:
        """Look for a jump as far as the reach, or as the range goes."""
        parameter, side = self._parameter, self._side
        found, far, before = None, 0.0, here
        for step in np.linspace(0.0, reach, STEPS + 1)[1:].tolist():
            try:
                after = self._at(step)
            except InputError:  # the end of its range
                break
            found = self._jump(far, step, before, after)
            far, before = step, after
            if found is not None:
                far = found[0]
                break
        jumps: tuple[Jump, ...] = ()
        if found is not None:
            names = [(of.name, key, of.unit) for of in measures for key in of.keys]
            jumps = tuple(
                Jump(measure=measure, key=key, unit=unit, size=side * size)
                for (measure, key, unit), size in zip(names, found[1].tolist(), strict=True)
            )
        return Cliff(
            parameter=parameter.name, kept=parameter.kept, unit=parameter.unit, value=parameter.value,
            side="below" if side < 0 else "above", searched=far,
            at=None if found is None else parameter.value + side * far, jumps=jumps,
        )  # fmt: skip

    def _at(self, far: float) -> np.ndarray:
        return self._values(self._parameter.moved(self._side * far))

    def _change(self, change: np.ndarray) -> float:
        return float(np.nanmax(np.abs(change[self._counts]), initial=0.0))

    def _jump(
        self, near: float, far: float, before: np.ndarray, after: np.ndarray
    ) -> tuple[float, np.ndarray] | None:
        """Return place and size of the nearest jump between two places, if there is one.

        What is smooth halves with the distance, and a jump stays.
        """
        change = after - before
        if self._change(change) < 0.5 * self._threshold:
            return None
        if far - near <= PLACE:
            return (0.5 * (near + far), change) if self._change(change) >= self._threshold else None
        middle = 0.5 * (near + far)
        between = self._at(middle)
        found = self._jump(near, middle, before, between)
        return found or self._jump(middle, far, between, after)


# ---- What can be moved ---------------------------------------------------------------------------------


def parameters_of(stone: Stone, meets: str = "free") -> list[Parameter]:
    """Return what a stone is differentiated by (`gemrender.beam.sensitivity`): what can be moved.

    Of designs `meets` says what becomes of meet points.

    Raises
    ------
    InputError
        It was neither made from proportions, nor of a family, nor from a design.
    """
    check_differentiable(stone)
    return list(_parameters(stone, meets))


def _parameters(stone: Stone, meets: str) -> Iterator[Parameter]:
    cut = stone.cut
    if isinstance(cut, Design):
        unit, ways = design_unit(stone, cut), changeable(cut, meets)
        for tier, key in parameters_of_stone(stone, cut):
            is_angle = key == "angle_deg"
            scale = 1.0 if is_angle else 0.01 * unit
            yield Parameter(
                name=tier_parameter_name(cut, tier, key),
                kept=KEPT_BY_WAY[meets],
                unit="deg" if is_angle else "%",
                value=float(getattr(ways.design.tiers[tier], key)) / scale,
                moved=partial(_tier_moved, stone, ways, tier, key, scale),
            )
    elif isinstance(cut, Family):
        for change in changes_of(cut):
            yield Parameter(
                name=change.parameter,
                kept=change.kept,
                unit=unit_of(cut, change.parameter),
                value=change.value,
                moved=partial(change.moved, stone),
            )
    elif stone.proportions is not None:
        proportions = stone.proportions
        angles = {
            "table": proportions.table,
            "crown_angle": proportions.crown_angle_deg,
            "pavilion_angle": proportions.pavilion_angle_deg,
            "star": proportions.star,
            "lower_half": 100.0 - proportions.lower_girdle_contact,
            "girdle_thickness": proportions.girdle_thickness,
        }
        for kept, values, make in (
            ("proportions", {name: getattr(proportions, name) for name in PROPORTIONS}, RoundBrilliant),
            ("angles", angles, RoundBrilliant.from_angles),
        ):
            for name, value in values.items():
                if kept == "angles" and name in ("star", "girdle_thickness"):  # the same either way
                    continue
                yield Parameter(
                    name=name,
                    kept=kept,
                    unit="deg" if name.endswith("angle") else "%",
                    value=value,
                    moved=partial(_proportion_moved, stone, make, values, name),
                )


def _proportion_moved(
    stone: Stone, make: Callable[..., RoundBrilliant], values: dict[str, float], name: str, by: float
) -> Stone:
    made = make(**{**values, name: values[name] + by})
    return Stone.from_proportions(made, name=stone.name, material=stone.material)


def _tier_moved(stone: Stone, ways: Free, tier: int, key: Quantity, scale: float, by: float) -> Stone:
    value = float(getattr(ways.design.tiers[tier], key)) + by * scale
    return ways.changed({(tier, key): value}).stone(name=stone.name, material=stone.material)

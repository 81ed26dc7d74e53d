"""What a page tells of a stone besides its maps: what measures say of it, and what when it is turned."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from gemrender.engines import DEFAULT_HEAD, observe
from gemrender.errors import InputError
from gemrender.measures import Measure, measure_named
from gemrender.observation import MeasureValues, Observation, View
from gemrender.report.tables import band_key
from gemrender.scoring import Score, chosen_or_none, score, score_observation
from gemrender.stone import Stone

__all__ = ["MOST_TURNS", "Study", "Turned", "check_turns", "study_stone"]

#: Most poses of a page, besides the one straight above.
MOST_TURNS = 180
#: Name of the paper's score among the measures.
_INOUE = "inoue"
_AXES = {"x": 0.0, "y": 90.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class Turned:
    """What measures say of a stone that is turned about a level axis.

    Attributes
    ----------
    turn_deg : float
        By how much it is turned, right-handed [deg].
    view : View
        The same as a view of the stone.
    measures : tuple of MeasureValues
        What they say: the paper's score, then the others, as `Study.measures`.
    """

    turn_deg: float
    view: View
    measures: tuple[MeasureValues, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """What measures say of a stone.

    Attributes
    ----------
    score : Score
        Its score, with further measures if there are any.
    view : View
        From where that is.
    definitions : tuple of Measure
        The further measures.
    axis : float or None
        Azimuth of the axis that it was turned about [deg]; None if it was not.
    turned : tuple of Turned
        What the measures say of it when it is turned; without the one straight above.
    """

    score: Score
    view: View
    definitions: tuple[Measure, ...] = ()
    axis: float | None = None
    turned: tuple[Turned, ...] = ()

    @classmethod
    def of(cls, observation: Observation) -> Study:
        """Return what an observation alone tells."""
        return cls(score=score_observation(observation), view=observation.view)

    @property
    def measures(self) -> tuple[MeasureValues, ...]:
        """What all measures say, the paper's score first."""
        return all_measures(self.score)


def all_measures(of: Score) -> tuple[MeasureValues, ...]:
    """Return the measures of a score, its own values first: those of `inoue`."""
    values = {"average": of.average, "rear": of.rear, "trapped": of.trapped, "lost": of.lost}
    values |= {band_key(band): band.share for band in of.bands}
    own = MeasureValues(name=_INOUE, version=measure_named(_INOUE).version, values=values, bound=of.bound)
    return (own, *(other for other in of.measures or () if other.name != _INOUE))


def check_turns(to_deg: float, step_deg: float) -> list[float]:
    """Return the turns up to a largest one [deg], in steps; without 0.

    Raises
    ------
    InputError
        A turn or a step out of range.
    """
    if not 0 < to_deg < 90:
        raise InputError("must be above 0 and below 90 [deg]", key="tilts", value=to_deg)
    if not to_deg / MOST_TURNS <= step_deg <= to_deg:
        allowed = f"must be from {to_deg / MOST_TURNS:.3g} to {to_deg:g} [deg]"
        raise InputError(allowed, key="tilt_step", value=step_deg)
    count = math.floor(to_deg / step_deg * (1.0 + 1e-12))
    return [round(step_deg * (k + 1), 9) for k in range(count)]


def study_stone(
    stone: Stone,
    *,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    turns: Iterable[float] = (),
    axis: str | float = "x",
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> tuple[Observation, Study]:
    """Trace a stone for a page: its maps, and what measures say.

    Parameters
    ----------
    stone : Stone
        The stone.
    measures, head
        As for `gemrender.score`.
    turns : iterable of float
        Turns of the stone under the eye and the light, above 0 and below 90 [deg].
    axis : {"x", "y"} or float
        Level axis that it is turned about, right-handed: by name, or by its azimuth [deg].
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        As for `gemrender.observe`.

    Raises
    ------
    InputError, BackendError
        As for `gemrender.score`; turns of a view that is tilted itself.
    """
    turns = list(turns)
    if turns and options.get("tilt"):
        raise InputError("turns are from straight above: the view must not be tilted", key="turns")
    chosen = chosen_or_none(measures)
    tell = progress or (lambda share: None)
    parts = 1 + len(turns)
    observation = observe(stone, progress=lambda share: tell(share / parts), **options)
    found = score_observation(observation)
    if chosen is not None:
        found = score(stone, measures=chosen, head=head, **options)
    azimuth = _AXES[axis] if isinstance(axis, str) else float(axis)
    turned = []
    for number, turn in enumerate(turns):
        turned.append(_turned(stone, turn, azimuth, found, chosen, head=head, **options))
        tell((number + 2) / parts)
    study = Study(
        score=found,
        view=observation.view,
        definitions=chosen or (),
        axis=azimuth if turns else None,
        turned=tuple(turned),
    )
    return observation, study


def _turned(
    stone: Stone,
    turn: float,
    axis: float,
    upright: Score,
    measures: tuple[Measure, ...] | None,
    **options: Any,
) -> Turned:
    """Measure a stone that is turned; sums over all views stay as they are."""
    eye = {"tilt": turn, "tilt_azimuth": (axis + 90.0) % 360.0}
    of_view = None if measures is None else [of for of in measures if of.views == "one"]
    found = all_measures(score(stone, **{**options, **eye}, measures=of_view or None))
    known = {of.name: of for of in (*all_measures(upright), *found)}
    view = View.of(stone, 1, tilt_deg=turn, tilt_azimuth_deg=eye["tilt_azimuth"])
    return Turned(turn_deg=turn, view=view, measures=tuple(known[of.name] for of in all_measures(upright)))

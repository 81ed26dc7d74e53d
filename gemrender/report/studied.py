"""What a page tells of a stone besides its maps: what measures say of it, and what when it is turned."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from gemrender.engines import DEFAULT_HEAD
from gemrender.errors import InputError
from gemrender.mapping import score_and_observation
from gemrender.measures import Measure, measure_named
from gemrender.observation import MeasureValues, Observation, View
from gemrender.report.tables import band_key
from gemrender.scoring import Score, chosen_or_none, score_observation
from gemrender.stone import Stone
from gemrender.sweep.tilt import TiltedValues, study_tilt

__all__ = ["MOST_TURNS", "Study", "Turned", "check_tilts", "study_stone"]

#: Most poses of a page, besides the one straight above.
MOST_TURNS = 180
#: Name of the paper's score among the measures.
_INOUE = "inoue"
#: Share of the time that the maps take, where there are tilts.
_MAP_SHARE = 0.1


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


def check_tilts(to_deg: float, step_deg: float, view_tilt_deg: float = 0.0) -> None:
    """See that a page can have these tilts: up to a largest one both ways, in steps [deg].

    Raises
    ------
    InputError
        A tilt or a step out of range, or a view that is tilted itself.
    """
    if view_tilt_deg:
        raise InputError("is from straight above, and cannot be given with tilt", key="tilts", value=to_deg)
    if not 0 < to_deg < 90:
        raise InputError("must be above 0 and below 90 [deg]", key="tilts", value=to_deg)
    least = 2 * to_deg / MOST_TURNS
    if not least <= step_deg <= to_deg:
        raise InputError(f"must be from {least:.3g} to {to_deg:g} [deg]", key="tilt_step", value=step_deg)


def study_stone(
    stone: Stone,
    *,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    tilts: float = 0.0,
    tilt_step: float = 2.0,
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
    tilts, tilt_step : float
        Largest turn of the stone under the eye and the light, both ways, and the step [deg]; 0 for none.
    axis : {"x", "y"} or float
        Level axis that it is turned about, right-handed: by name, or by its azimuth [deg].
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        As for `gemrender.observe`.

    Raises
    ------
    InputError, BackendError
        As for `gemrender.score`; tilts of a view that is tilted itself.
    """
    if tilts:
        check_tilts(tilts, tilt_step)
        if options.get("tilt"):
            raise InputError(
                "are from straight above, and the view is tilted itself", key="tilts", value=tilts
            )
    chosen = chosen_or_none(measures)
    tell = progress or (lambda share: None)
    first = _MAP_SHARE if tilts else 1.0
    found, observation = score_and_observation(
        stone, measures=chosen, head=head, progress=lambda share: tell(first * share), **options
    )
    turned: tuple[Turned, ...] = ()
    if tilts:
        of_view = [of for of in chosen or () if of.views == "one" and of.name != _INOUE]
        study = study_tilt(
            stone,
            measures=[measure_named(_INOUE), *of_view],
            axis=axis,
            to_deg=tilts,
            step_deg=tilt_step,
            head=head,
            progress=lambda share: tell(first + (1.0 - first) * share),
            **{key: value for key, value in options.items() if key not in ("tilt", "tilt_azimuth")},
        )
        turned = tuple(_turned(stone, of, found) for of in study.found if of.pose.turn_deg)
    azimuth = {"x": 0.0, "y": 90.0}[axis] if isinstance(axis, str) else axis
    return observation, Study(
        score=found,
        view=observation.view,
        definitions=chosen or (),
        axis=float(azimuth) if tilts else None,
        turned=turned,
    )


def _turned(stone: Stone, found: TiltedValues, upright: Score) -> Turned:
    """Return what was found of a pose; sums over all views are as they are straight above."""
    straight = all_measures(upright)
    known = {of.name: of for of in (*straight, *found.measures)}
    tilt, azimuth = found.pose.eye
    return Turned(
        turn_deg=found.pose.turn_deg,
        view=View.of(stone, 1, tilt_deg=tilt, tilt_azimuth_deg=azimuth),
        measures=tuple(known[of.name] for of in straight),
    )

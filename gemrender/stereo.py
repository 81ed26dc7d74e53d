"""A viewer with two eyes: each eye's score, and how much of the view they see differently."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

from gemrender.engines import DEFAULT_BOUND, DEFAULT_ENGINE, DEFAULT_HEAD, engine_for, measure
from gemrender.errors import InputError
from gemrender.request import ShortForms, TraceOptions, resolve, spelt_out
from gemrender.scoring import Score, chosen_or_none, score_measurement
from gemrender.shown import Tabled

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np

    from gemrender.cuts import StoneLike
    from gemrender.measures import Measure
    from gemrender.observation import View

__all__ = ["EYE_DISTANCE", "EYE_SEPARATION", "StereoScore", "score_stereo"]

#: How far apart the eyes are, and how far from the stone [mm].
EYE_SEPARATION, EYE_DISTANCE = 65.0, 300.0
#: Allowed ranges of both [mm].
_SEPARATIONS, _DISTANCES = (0.0, 200.0), (50.0, 10_000.0)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class StereoScore(Tabled):
    """What a pair of eyes sees of a stone.

    Attributes
    ----------
    middle, left, right : Score
        From between the eyes, and by each eye; sky and head of measures are about the middle.
    disagreement : float
        Share of the view that the eyes see lit from different zones of `aset`, or one of them the head [%].
    bound : float
        The disagreement is within this of the truth, with a confidence of 99.9 % [%].
    eye_separation, eye_distance : float
        How far apart the eyes are, and how far from the stone [mm].
    """

    middle: Score
    left: Score
    right: Score
    disagreement: float
    bound: float
    eye_separation: float
    eye_distance: float

    def __repr__(self) -> str:
        return f"<StereoScore of {self.middle.name!r}: the eyes disagree on {self.disagreement:.2f} %>"

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it: the score from between the eyes, and `stereo` after it."""
        stereo = {
            "eye_separation": self.eye_separation,
            "eye_distance": self.eye_distance,
            "disagreement": self.disagreement,
            "bound": self.bound,
            "left": self.left.to_dict(),
            "right": self.right.to_dict(),
        }
        return self.middle.to_dict() | {"stereo": stereo}


@spelt_out()
def score_stereo(
    stone: StoneLike,
    *,
    engine: str = DEFAULT_ENGINE,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    eye_separation: float = EYE_SEPARATION,
    eye_distance: float = EYE_DISTANCE,
    **options: Unpack[TraceOptions],
) -> StereoScore:
    """Score a stone by the exact engine as two eyes see it.

    Parameters
    ----------
    engine : {"auto", "exact"}
        The exact engine alone scores for two eyes.
    measures : str, Measure, or iterable of them, optional
        What to measure besides the paper's score, as for `gemrender.score`.
    view : View, optional
        The view from between the eyes; by default what the short forms say.
    eye_separation : float
        How far apart the eyes are, 0 to 200 [mm], along the view's x.
    eye_distance : float
        How far they are from the stone, 50 to 10000 [mm].
    **options
        As of `TraceOptions`.

    Returns
    -------
    StereoScore
        Three scores, and the share of the view on which the eyes disagree [%].

    Raises
    ------
    InputError
        As for `gemrender.score`; a stone that is not convex, or an eye below the horizon.
    """
    from gemrender.cuts import as_stone

    for key, value, (low, high) in (
        ("eye_separation", eye_separation, _SEPARATIONS),
        ("eye_distance", eye_distance, _DISTANCES),
    ):
        if not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g} [mm]", key=key, value=value)
    stone = as_stone(stone)
    if engine_for(engine, stone) != "exact":
        raise InputError("must be exact for two eyes, and the stone convex", key="engine", value=engine)
    given: dict[str, Any] = {**options}
    short: Any = {key: given.pop(key) for key in list(given) if key in ShortForms.__annotations__}
    view, model = resolve(stone, given.pop("view", None), given.pop("model", None), short)
    bound, seed = options.get("bound", DEFAULT_BOUND), options.get("seed", 1)
    right, _, middle = view.basis()
    half = math.atan(0.5 * eye_separation / eye_distance)
    views = [
        _view_from(math.cos(half) * middle + side * math.sin(half) * right, view) for side in (-1.0, 1.0)
    ]
    chosen = chosen_or_none(measures)
    scores = []
    for each in (view, *views):
        zenith = None if each is view else middle
        measured, _, _ = measure(
            stone, view=each, model=model, measures=chosen or (), head=head, zenith=zenith, **given,
        )  # fmt: skip
        scores.append(score_measurement(measured, stone, each, model, with_measures=chosen is not None))
    from gemrender.beam.solid import beam_stone
    from gemrender.beam.stereo import disagreement

    share, error = disagreement(
        beam_stone(stone), view, (views[0], views[1]), model, head_deg=head, bound=max(bound, 0.05), seed=seed
    )
    return StereoScore(
        middle=scores[0],
        left=scores[1],
        right=scores[2],
        disagreement=share,
        bound=error,
        eye_separation=eye_separation,
        eye_distance=eye_distance,
    )


def _view_from(eye: np.ndarray, view: View) -> View:
    """Return a view from a direction (3,)."""
    from gemrender.observation import View

    return View(
        resolution=view.resolution,
        half_width=view.half_width,
        tilt_deg=math.degrees(math.acos(min(max(float(eye[2]), -1.0), 1.0))),
        tilt_azimuth_deg=math.degrees(math.atan2(eye[1], eye[0])),
    )

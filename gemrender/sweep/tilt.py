"""What a tilt does to a stone's light: measures over its poses, as curves about axes or as a surface."""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from gemrender.cuts import StoneLike, as_stone
from gemrender.engines import (
    DEFAULT_ENGINE,
    DEFAULT_HEAD,
    check_head,
    engine_for,
    require_engine,
)
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.measures import Measure, chosen_measures
from gemrender.observation import MeasureValues
from gemrender.request import TiltOptions, spelt_out
from gemrender.stone import Stone
from gemrender.stone.symmetry import NONE, Symmetry
from gemrender.sweep.poses import Pose, alike, tilt_poses
from gemrender.sweep.spreading import FEW, STUDY_RESOLUTION, limit_threads, spread
from gemrender.sweep.tilted import Tie, TiltedValues, TiltStudy
from gemrender.sweep.workers import LostProcessError

__all__ = [
    "DEFAULT_TILT_BOUND",
    "Tie",
    "TiltStudy",
    "TiltedValues",
    "solid_digest",
    "study_tilt",
    "tilt_measures",
]

#: Error bound of exact values unless another is asked for [%].
DEFAULT_TILT_BOUND = 0.1


def tilt_measures(chosen: str | Measure | Iterable[str | Measure] = "inoue") -> tuple[Measure, ...]:
    """Return the measures that were asked for, as `chosen_measures`; of `all` those of a single view.

    Raises
    ------
    InputError
        None at all, an unknown name, or a measure that is a sum over views.
    """
    measures = chosen_measures(chosen)
    if chosen == "all":
        return tuple(of for of in measures if of.views == "one")
    for of in measures:
        if of.views != "one":
            raise InputError(
                f"{of.name} is a sum over all views and has no tilt", key="measures", value=of.name
            )
    return measures


@spelt_out(bound=DEFAULT_TILT_BOUND, resolution=STUDY_RESOLUTION)
def study_tilt(
    stone: StoneLike,
    *,
    measures: str | Measure | Iterable[str | Measure] = "inoue",
    axis: str | float = "x",
    to_deg: float = 30.0,
    step_deg: float = 1.0,
    head: float = DEFAULT_HEAD,
    journal: Path | None = None,
    processes: int | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[TiltOptions],
) -> TiltStudy:
    """Measure a stone in many poses, on all processors.

    A pose that a symmetry of the stone makes of another one is not traced: it has the other one's values.
    The sky and the head of measures stay with the viewer, the rules of the paper's score with the stone.

    Parameters
    ----------
    stone : Stone, str or path
        The stone, or what `load_stone` takes.
    measures : str, Measure, or iterable of them
        What to measure: names, several with commas between them, `all`, or measures of your own.
    axis : {"x", "y", "both", "surface"} or float
        What to turn about: an axis, given by its azimuth [deg] if it is neither x nor y, from -`to_deg` to
        `to_deg`; or every level axis, for a surface over all tilts up to `to_deg`.
    to_deg, step_deg : float
        Largest tilt, above 0 and below 90, and the step [deg].
    head : float
        Half the angle at which the viewer's head is seen from the stone, 0 to below 90 [deg].
    journal : Path, optional
        File that every pose is added to when it is known; a study that was stopped, however that came about,
        goes on from it, and so does one with other poses (`gemrender.journal.Journal`).
    processes : int, optional
        Processes to use, or threads where the exact engine has few poses to trace; by default one a
        processor.
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        How each pose is traced, as of `gemrender.score`.

    Raises
    ------
    InputError
        A value out of range, a measure that there is not or that has no tilt, or a journal that is of another
        study or in use.
    LostProcessError
        Processes were lost again and again, as where memory runs out; what is in the journal is kept.
    """
    stone, chosen = as_stone(stone), tilt_measures(measures)
    asked: dict[str, Any] = {"bound": DEFAULT_TILT_BOUND, "resolution": STUDY_RESOLUTION, **options}
    used = engine_for(asked.get("engine", DEFAULT_ENGINE), stone)
    if used == "exact":  # its first kernel must not be called by two threads at once: numba has no lock there
        require_engine(used, stones=[stone])
    # A measure that sees a turn about the eye's direction tells symmetric poses apart.
    symmetry = stone.symmetry if all(of.is_axial for of in chosen) else NONE
    poses = tilt_poses(axis, to_deg, step_deg, stone.symmetry)
    traced: dict[tuple[float, float], Pose] = {}
    for pose in poses:
        traced.setdefault(alike(symmetry, pose), pose)
    work = partial(_trace, stone, chosen, check_head(head), asked)
    with contextlib.ExitStack() as stack:
        kept = None
        if journal is not None:
            entry = partial(_entry, chosen, symmetry)
            kept = stack.enter_context(
                Journal(journal, _head(stone, chosen, head, asked), entry, work="study")
            )
        known: dict[tuple[float, float], _Found] = {} if kept is None else dict(kept.known)
        missing = [pose for key, pose in traced.items() if key not in known]
        try:
            by_threads = used == "exact" and len(missing) <= FEW
            missing.sort(key=lambda pose: -abs(pose.turn_deg))  # the most tilted take longest
            results = spread(work, missing, processes, by_threads=by_threads)
            for pose, found in stack.enter_context(contextlib.closing(results)):
                known[alike(symmetry, pose)] = found
                if kept is not None:
                    kept.add(*_line(pose, found))
                if progress is not None:
                    progress(len(known.keys() & traced.keys()) / len(traced))
        except LostProcessError as error:
            done = "" if kept is None else f"; what is done is kept in {journal}"
            raise LostProcessError(f"{error}{done}") from error
    return TiltStudy(
        name=stone.name,
        axis=axis,
        measures=chosen,
        head_deg=float(head),
        engine=used,
        found=tuple(
            TiltedValues(pose=pose, measures=known[key][0], notes=known[key][1])
            for pose in poses
            for key in [alike(symmetry, pose)]
        ),
    )


# ---- Tracing -------------------------------------------------------------------------------------------

#: What is found of a pose: values of measures, and notes.
_Found = tuple[tuple[MeasureValues, ...], tuple[str, ...]]


def _trace(
    stone: Stone,
    measures: tuple[Measure, ...],
    head: float,
    options: dict[str, Any],
    threads: int | None,
    pose: Pose,
) -> tuple[Pose, _Found]:
    from gemrender.scoring import score

    limit_threads(threads, stone, options)
    tilt, azimuth = pose.eye
    found = score(stone, measures=measures, head=head, **{**options, "tilt": tilt, "tilt_azimuth": azimuth})
    return pose, (found.measures or (), found.notes)


# ---- The journal ---------------------------------------------------------------------------------------


def solid_digest(stone: Stone) -> str:
    """Return what tells a stone's shape and facets from those of others, for the first line of a journal."""
    solid = stone.solid
    digest = hashlib.sha256(repr((stone.facets, solid.is_round)).encode())
    for part in (solid.planes, solid.facet, *([] if stone.is_convex else [solid.vertices])):
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def _head(
    stone: Stone, measures: tuple[Measure, ...], head: float, options: dict[str, Any]
) -> dict[str, Any]:
    """Return all that a pose's values depend on, but the pose."""
    return {
        "tilted": stone.name,
        "solid": solid_digest(stone),
        "material": stone.material,
        "measures": [[of.name, of.version] for of in measures],
        "head_deg": float(head),
        "options": {
            key: value
            for key, value in {**options, "rear": options.get("rear") or stone.rear_rule}.items()
            if key not in ("tilt", "tilt_azimuth")
        },
    }


def _line(pose: Pose, found: _Found) -> list[Any]:
    """Return a pose and what was found as an entry of a journal; null stands for what is not defined."""
    measures, notes = found
    told = [
        [[None if math.isnan(value) else value for value in of.values.values()], of.bound, of.details]
        for of in measures
    ]
    return [pose.axis_deg, pose.turn_deg, told, list(notes)]


def _entry(
    measures: tuple[Measure, ...], symmetry: Symmetry, line: Any
) -> tuple[tuple[float, float], _Found]:
    """Return an entry's key and what was found; ValueError or TypeError if it is none."""
    axis, turn, told, notes = line
    if not (_is_number(axis) and _is_number(turn) and abs(turn) < 90):
        raise ValueError("is no pose")
    if not isinstance(notes, list) or not all(isinstance(words, str) for words in notes):
        raise TypeError("are no notes")
    values = []
    for of, (numbers, bound, details) in zip(measures, told, strict=True):
        if not all(number is None or _is_number(number) for number in (*numbers, bound)):
            raise TypeError("are no values")
        if not isinstance(details, dict) or set(details) - set(of.detail_keys):
            raise TypeError("are no details")
        values.append(
            MeasureValues(
                name=of.name,
                version=of.version,
                values={
                    key: math.nan if number is None else float(number)
                    for key, number in zip(of.keys, numbers, strict=True)
                },
                bound=bound,
                details=details,
            )
        )
    pose = Pose(axis_deg=float(axis), turn_deg=float(turn))
    return alike(symmetry, pose), (tuple(values), tuple(notes))


def _is_number(value: Any) -> bool:
    return type(value) in (int, float)

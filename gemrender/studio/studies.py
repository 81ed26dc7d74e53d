"""What is found out of a stone while nothing moves: slopes, cliffs, the curve over tilt, the map around it.

Each study yields messages as soon as it knows something more, and asks `check` again and again whether it is
still wanted; that raises `Outdated` where it is not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from gemrender.beam import Budget
from gemrender.beam import measure as measure_by_beams
from gemrender.beam.sensitivity import sensitivity
from gemrender.cuts.design import Design
from gemrender.engines import measure
from gemrender.errors import InputError
from gemrender.measures import chosen_measures
from gemrender.observation import View
from gemrender.stone import Stone
from gemrender.studio.frames import Wanted, measured_values
from gemrender.sweep.cliffs import Cliff, Parameter, find_cliffs, parameters_of
from gemrender.sweep.poses import alike, tilt_poses

__all__ = ["Outdated", "studies"]

Check = Callable[[], None]
Message = dict[str, Any]

#: Bound of scores of a curve or a map [%], which are drawn, and how far and in which steps they go [deg].
_DRAWN_BOUND = 0.2
_TILT, _TILT_STEP = 30.0, 2.0
#: The map around the present stone: so far by either angle, in so many steps to a side, coarser ones first.
_AROUND, _STEPS = 2.4, 12
_COARSEST = 4
#: The angles of the map.
_CROWN, _PAVILION = "crown_angle", "pavilion_angle"
#: What scores of the map and the curve may take each [s], [GiB].
_LIMITS = (2.0, 1.0)


class Outdated(Exception):  # noqa: N818 (no error: something newer is wanted)
    """What is worked at is wanted no more."""


def studies(wanted: Wanted, stone: Stone, shelf: dict[str, Stone], check: Check) -> Iterator[Message]:
    """Yield all that is found out of a stone, what is soonest known first.

    Parameters
    ----------
    wanted : Wanted
        What the page shows.
    stone : Stone
        Its stone.
    shelf : dict of str to Stone
        As of `Wanted.stone`.
    check : callable
        Raises `Outdated`.
    """
    steps = [partial(_slopes, wanted, stone, check)]
    if wanted.measures:
        steps.append(partial(_measures, wanted, stone, check))
    steps.append(partial(_curve, stone, check))
    steps.append(partial(_around, wanted, shelf, check))
    steps.append(partial(_cliffs, wanted, stone, check))
    for step in steps:
        check()
        for message in step():
            yield {**message, "number": wanted.number}


# ---- Slopes and cliffs ---------------------------------------------------------------------------------


def _meets(wanted: Wanted) -> str:
    return str(wanted.cut.get("meets", "loose")) if "design" in wanted.cut else "free"


def _slopes(wanted: Wanted, stone: Stone, check: Check) -> Iterator[Message]:
    """Tell what one unit of each parameter does to Average and Rear; angles stay, as on the sliders."""
    try:
        found = sensitivity(
            stone, view=wanted.view(stone), bound=_DRAWN_BOUND, meets=_meets(wanted),
            progress=lambda share: check(),
        )  # fmt: skip
    except InputError as error:  # a stone without parameters, or of too many virtual facets
        yield {"type": "slopes", "slopes": {}, "why": error.allowed}
        return
    slopes: dict[str, Any] = {}
    for of in found.derivatives:
        if of.parameter not in slopes or of.kept != "proportions":
            slopes[of.parameter] = {
                "average": of.average,
                "averageBound": of.average_bound,
                "rear": of.rear,
                "rearBound": of.rear_bound,
            }
    yield {"type": "slopes", "slopes": slopes, "why": ""}


def _cliffs(wanted: Wanted, stone: Stone, check: Check) -> Iterator[Message]:
    """Tell the next jump to either side of each parameter, angles first."""
    try:
        known = parameters_of(stone, _meets(wanted))
    except InputError:
        return
    chosen = {of.name: of for of in known if of.kept == "proportions"}
    chosen |= {of.name: of for of in known if of.kept != "proportions"}
    for parameter in sorted(chosen.values(), key=lambda of: not of.name.endswith("angle")):
        if parameter.name.endswith("distance"):
            continue
        watched = replace(parameter, moved=partial(_moved, parameter, check))
        try:
            cliffs = find_cliffs(stone, [watched], view=wanted.view(stone), bound=_DRAWN_BOUND)
        except InputError:
            continue
        yield {
            "type": "cliffs",
            "parameter": parameter.name,
            "sides": {of.side: _told(of, isinstance(stone.cut, Design)) for of in cliffs},
        }


def _moved(parameter: Parameter, check: Check, by: float) -> Stone:
    check()
    return parameter.moved(by)


def _told(of: Cliff, is_design: bool) -> Message:
    largest = of.largest
    at = of.at if of.at is None or not is_design else abs(of.at)  # sliders have no sign
    return {
        "at": at,
        "searched": of.searched,
        "what": None if largest is None else f"{largest.measure} {largest.key}",
        "jump": None if largest is None else largest.size,
    }


# ---- Measures, the curve and the map -------------------------------------------------------------------


def _measures(wanted: Wanted, stone: Stone, check: Check) -> Iterator[Message]:
    """Tell what further measures say."""
    for name in wanted.measures:
        check()
        try:
            of = chosen_measures(name)
            told = measure(
                stone, measures=of, head=wanted.head, tilt=wanted.tilt, tilt_azimuth=wanted.azimuth,
                bound=_DRAWN_BOUND, time_limit=20.0, progress=lambda share: check(),
            )[0].measures  # fmt: skip
        except InputError as error:
            yield {"type": "measures", "measures": [], "why": str(error)}
            continue
        yield {"type": "measures", "measures": measured_values(told), "unit": of[0].unit, "why": ""}


def _score(stone: Stone, view: View) -> Message:
    told = measure_by_beams(stone, view=view, bound=_DRAWN_BOUND, budget=Budget(*_LIMITS))
    return {"average": told.average, "rear": told.rear, "bound": told.bound}


def _curve(stone: Stone, check: Check) -> Iterator[Message]:
    """Tell the scores of the stone tilted about x, from straight above outwards."""
    poses = tilt_poses("x", _TILT, _TILT_STEP, stone.symmetry)
    known: dict[Any, Message] = {}
    for pose in sorted(poses, key=lambda of: abs(of.turn_deg)):
        check()
        key = alike(stone.symmetry, pose)
        if key not in known:
            tilt, azimuth = pose.eye
            known[key] = _score(stone, View.of(stone, 1, tilt_deg=tilt, tilt_azimuth_deg=azimuth))
        yield {"type": "curve", "turn": pose.turn_deg, "to": _TILT, **known[key]}


def _around(wanted: Wanted, shelf: dict[str, Stone], check: Check) -> Iterator[Message]:
    """Tell the scores of stones of other crown and pavilion angles, coarse ones first."""
    values = dict(wanted.cut.get("values", {}))
    if "family" not in wanted.cut or not {_CROWN, _PAVILION} <= values.keys():
        return
    step = _AROUND / _STEPS
    by_level: dict[int, list[tuple[int, int]]] = {}
    for row in range(-_STEPS, _STEPS + 1):
        for column in range(-_STEPS, _STEPS + 1):
            level = next(n for n in (_COARSEST, 2, 1) if row % n == 0 and column % n == 0)
            by_level.setdefault(level, []).append((row, column))
    for level in (_COARSEST, 2, 1):
        cells = []
        for row, column in sorted(by_level[level], key=lambda of: of[0] ** 2 + of[1] ** 2):
            check()
            angles = {_CROWN: values[_CROWN] + row * step, _PAVILION: values[_PAVILION] + column * step}
            try:
                made = replace(wanted, cut={**wanted.cut, "values": values | angles}).stone(shelf)
                cells.append([row, column, *list(_score(made, View.of(made, 1)).values())])
            except InputError:  # no stone has these angles
                cells.append([row, column, None, None, None])
            if len(cells) == 2 * _STEPS:
                yield _cells(values, cells, level, step)
                cells = []
        yield _cells(values, cells, level, step)


def _cells(values: dict[str, Any], cells: list[Any], level: int, step: float) -> Message:
    return {
        "type": "around",
        "crown": values[_CROWN],
        "pavilion": values[_PAVILION],
        "steps": _STEPS,
        "step": step,
        "size": level,
        "cells": cells,
    }

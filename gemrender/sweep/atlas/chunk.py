"""One chunk of an atlas measured: the same numbers whoever does it, and when."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from gemrender.beam import MemoryBudget, measure, prepare
from gemrender.errors import InputError
from gemrender.measures.inoue import Inoue
from gemrender.observation import Measurement
from gemrender.request import resolve
from gemrender.stone import Stone
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.store import DONE, FAILED, NO_STONE

__all__ = ["chunk_values", "measure_chunk"]

#: Memory that a measurement may take, whatever the number of threads: a process stays below 1 GiB [GiB].
_MEMORY = 0.25
_PREPARING = threading.Lock()


def measure_chunk(
    plan: AtlasPlan, chunk: int, goes_on: Callable[[], bool] = lambda: True
) -> dict[str, np.ndarray] | None:
    """Measure the stones of a chunk.

    Parameters
    ----------
    plan : AtlasPlan
        The plan.
    chunk : int
        Which one, from 0.
    goes_on : callable
        Asked before each stone whether to go on.

    Returns
    -------
    dict of str to array, or None
        `status`, each of the plan's variables, and parameters of a Sobol design, as the store has them; None
        where it was stopped.
    """
    with _PREPARING:  # a kernel's first call must not be made by two threads at once
        prepare(rays=True)
    place = plan.place(chunk)
    shape = tuple(part.stop - part.start for part in place)
    rows: list[np.ndarray] = []
    status = []
    for setting in plan.settings(place):
        if not goes_on():
            return None
        values, state = _measured(plan, setting)
        rows.append(values)
        status.append(state)
    found = np.array(rows, dtype=np.float32)
    views = (len(plan.tilts),) if plan.tilts else ()
    out = {variable.name: found[:, :, k].reshape(shape + views) for k, variable in enumerate(plan.variables)}
    if plan.ranges:
        points = plan.points(place[0])
        out |= {key: points[:, k] for k, key in enumerate(plan.ranges)}
    return out | {"status": np.array(status, dtype=np.int8).reshape(shape)}


def _measured(plan: AtlasPlan, setting: dict[str, float | str]) -> tuple[np.ndarray, int]:
    """Return the values of a stone, (views, variables), NaN where there are none; and its status."""
    nothing = np.full((len(plan.views), len(plan.variables)), np.nan)
    try:
        stone = plan.made(setting)
    except InputError:
        return nothing, NO_STONE
    try:
        return np.array([chunk_values(plan, stone, tilt) for tilt in plan.views]), DONE
    except InputError:  # a model that cannot be of this material
        return nothing, NO_STONE
    except (ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError):
        return nothing, FAILED


def chunk_values(plan: AtlasPlan, stone: Stone, tilt: tuple[float, float]) -> list[float]:
    """Return what is measured of a stone in a view, in the order of the plan's variables.

    The paper's score comes with every measurement, and is not measured a second time.
    """
    view, model = resolve(stone, None, None, {"resolution": 1, "tilt": tilt[0], "tilt_azimuth": tilt[1]})
    asked = [of for of in plan.measures if not isinstance(of, Inoue)]
    measured = measure(
        stone, view=view, model=model, measures=asked, head_deg=plan.head, bound=plan.bound,
        budget=MemoryBudget(_MEMORY),
    )  # fmt: skip
    by_name = {of.name: (of.values, of.bound) for of in measured.measures}
    by_name["inoue"] = (_inoue(measured), measured.bound)
    out: list[float] = []
    for of in plan.measures:
        values, bound = by_name[of.name]
        out += [*(values[key] for key in of.keys), np.nan if bound is None else bound]
    return out


def _inoue(measured: Measurement) -> dict[str, float]:
    """Return the values of the measure `inoue`, which every measurement has."""
    four = (measured.average, measured.rear, measured.trapped, measured.lost)
    return dict(zip(Inoue.keys, map(float, (*four, *measured.bands)), strict=True))

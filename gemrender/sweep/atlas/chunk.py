"""Stones of an atlas measured: the same numbers whoever does it, in whichever parts, and when."""

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
from gemrender.sweep.atlas.parts import Measured, Part, chunk_arrays, chunk_size
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.store import DONE, FAILED, NO_STONE

__all__ = ["chunk_values", "measure_chunk", "measure_part"]

#: Memory that a measurement may take, whatever the number of threads: a process stays below 1 GiB [GiB].
_MEMORY = 0.25
_PREPARING = threading.Lock()


def measure_part(plan: AtlasPlan, part: Part, goes_on: Callable[[], bool] = lambda: True) -> Measured | None:
    """Measure some stones of a chunk.

    Parameters
    ----------
    plan : AtlasPlan
        The plan.
    part : Part
        Which stones.
    goes_on : callable
        Asked before each stone whether to go on.

    Returns
    -------
    Measured or None
        None where it was stopped.
    """
    with _PREPARING:  # a kernel's first call must not be made by two threads at once
        prepare(rays=True)
    n = part.last - part.first
    values = np.full((n, len(plan.views), len(plan.variables)), np.nan, dtype=np.float32)
    status = np.empty(n, dtype=np.int8)
    for k, setting in enumerate(plan.settings(plan.place(part.chunk), part.first, part.last)):
        if not goes_on():
            return None
        status[k] = _measure(plan, setting, values[k])
    return Measured(part, values, status)


def measure_chunk(plan: AtlasPlan, chunk: int) -> dict[str, np.ndarray]:
    """Measure a chunk; return what `chunk_arrays` does."""
    measured = measure_part(plan, Part(chunk, 0, chunk_size(plan, chunk)))
    assert measured is not None  # nobody stops it
    return chunk_arrays(plan, chunk, measured.values, measured.status)


def _measure(plan: AtlasPlan, setting: dict[str, float | str], out: np.ndarray) -> int:
    """Write the values of a stone, (views, variables), where there are some; return its status."""
    try:
        stone = plan.made(setting)
    except InputError:
        return NO_STONE
    try:
        out[...] = [chunk_values(plan, stone, tilt) for tilt in plan.views]
    except InputError:  # a model that cannot be of this material
        return NO_STONE
    except (ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError):
        return FAILED
    return DONE


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

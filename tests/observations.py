"""Observations made by hand, and the command line run in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts import load_stone
from gemrender.observation import MAP_TYPES, Model, Observation, RayStatus, View
from gemrender.stone import Stone

#: Shares and scores [%] by counting pixels: a quotient of whole numbers, with float64's rounding.
SHARE = 1e-12

STONE = load_stone("inoue-3")
ROOT = Path(__file__).parents[1]
#: By these rich takes a file for a terminal, or of some width.
TERMINAL_VARIABLES = ("FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE", "COLUMNS")


def observation(
    status: Any = RayStatus.EXITED, *, resolution: int | None = None, stone: Stone = STONE, **maps: Any
) -> Observation:
    """Make an observation with the given maps, (n, n) each or one value for all pixels; the rest is zeros."""
    n = resolution or len(status)
    view = View(resolution=n)
    status = np.broadcast_to(np.asarray(status, dtype=np.uint8), view.shape)
    maps = {"status": status, "coverage": status != RayStatus.MISSED, **maps}
    full = {}
    for name, kind in MAP_TYPES.items():
        shape = (n, n, 3) if name in ("exit_point", "exit_direction") else (n, n)
        full[name] = np.broadcast_to(np.asarray(maps.get(name, 0), dtype=kind), shape).copy()
    return Observation(**full, stone=stone, view=view, model=Model(), engine="reference")


def run_python(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run Python on this checkout; `environment` adds to the environment's variables."""
    return subprocess.run(
        [sys.executable, *arguments],
        env=environment(options.pop("environment", {})),
        **{"capture_output": True, "text": True, "encoding": "utf-8", "timeout": 120, **options},
    )


def run_gemrender(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own."""
    return run_python("-m", "gemrender", *arguments, **options)


def environment(variables: dict[str, str]) -> dict[str, str]:
    """Return the environment for a process on this checkout, whatever a CI system asks of terminals."""
    kept = {key: value for key, value in os.environ.items() if key not in TERMINAL_VARIABLES}
    return {**kept, "PYTHONPATH": str(ROOT), **variables}

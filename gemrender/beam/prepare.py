"""The kernels made ready: compiled when they are first needed on a machine, else read from numba's cache."""

from __future__ import annotations

from functools import lru_cache

from gemrender.beam.maps import observe
from gemrender.observation import View
from gemrender.stone import RoundBrilliant, Stone

__all__ = ["prepare"]


@lru_cache(maxsize=1)
def prepare() -> None:
    """Compile or load every kernel that scores and maps need: ten seconds once, then 0.2 s a process."""
    proportions = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=14.5, pavilion_depth=43, girdle_thickness=3
    )
    observe(Stone.from_proportions(proportions), View(resolution=4), bound=10.0)

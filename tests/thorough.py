"""Large tables of cases: some are run, so that the suite takes minutes; all by `GEMRENDER_THOROUGH=1`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TypeVar

Case = TypeVar("Case")

THOROUGH = bool(os.environ.get("GEMRENDER_THOROUGH"))


def some(cases: Sequence[Case], every: int) -> Sequence[Case]:
    """Return every so manieth of the cases, or all of them."""
    return cases if THOROUGH else cases[::every]

"""Large tables of cases: those that show a rule are run always, the others, marked `slow`, on request."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def some(cases: Iterable[Any], every: int) -> list[Any]:
    """Return cases as parameters, all but every so manieth of them slow."""
    return [_slow(case) if k % every else case for k, case in enumerate(cases)]


def chosen(cases: Iterable[Any], always: Collection[Any]) -> list[Any]:
    """Return cases as parameters, all but the chosen ones slow."""
    cases = list(cases)
    assert all(case in cases for case in always)
    return [case if case in always else _slow(case) for case in cases]


def _slow(case: Any) -> Any:
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)

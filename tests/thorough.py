"""Large tables of cases: those that show a rule are run always, the others, marked `slow`, on request."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable
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


def examples(few: int, many: int, given: Any, **options: Any) -> Callable[[Callable[..., None]], Any]:
    """Return what makes a test of few examples, and of many as a slow case, of what `hypothesis.given` gives.

    Options are those of `hypothesis.settings`.
    """
    from hypothesis import settings

    def decorate(function: Callable[..., None]) -> Any:
        tests = {number: settings(max_examples=number, **options)(given(function)) for number in (few, many)}

        def run(number: int, **fixtures: Any) -> None:
            tests[number](**fixtures)

        others = inspect.signature(tests[few])
        own = inspect.signature(run).parameters["number"]
        run.__signature__ = others.replace(parameters=[own, *others.parameters.values()])  # type: ignore[attr-defined]
        run.__doc__ = function.__doc__
        return pytest.mark.parametrize("number", chosen([few, many], [few]))(run)

    return decorate


def _slow(case: Any) -> Any:
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)

"""Work is shared among as many threads as there are processors for it."""

from __future__ import annotations

import os

import pytest

from gemrender.processors import usable_processors
from gemrender.sweep.atlas.work import workers_of


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="this system does not say")
def test_a_process_that_may_use_some_processors_has_as_many_workers(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 3, 5})
    assert usable_processors() == workers_of(None, None) == 3


def test_where_the_system_does_not_say_all_are_taken(monkeypatch):
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    assert usable_processors() == 7
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert usable_processors() == 1

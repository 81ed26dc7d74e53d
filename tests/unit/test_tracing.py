"""While kernels are made, nothing is collected."""

from __future__ import annotations

import gc

import pytest

from gemrender.plugins.tracing import instances_held


@pytest.mark.parametrize("enabled", [True, False])
def test_the_collector_is_held_and_then_as_it_was(enabled):
    before = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        with instances_held():
            assert not gc.isenabled()
        assert gc.isenabled() == enabled
    finally:
        (gc.enable if before else gc.disable)()

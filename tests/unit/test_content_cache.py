"""What functions of arrays return is kept by what is in the arrays."""

from __future__ import annotations

import numpy as np
import pytest

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.scene import content_cache
from gemrender.scene.closed import closed_surface
from gemrender.scene.content_cache import cached_by_content
from gemrender.stone.mesh import tessellate


@pytest.fixture
def counted():
    """A function of arrays, and how often it was called."""
    calls = []

    @cached_by_content
    def total(*arrays):
        calls.append(arrays)
        if not arrays[0].any():
            raise InputError("must not be 0")
        return sum(array.sum() for array in arrays)

    return total, calls


def test_the_same_numbers_are_looked_at_once(counted):
    total, calls = counted
    array = np.arange(6.0)
    assert total(array) == total(array.copy()) == total([0.0, 1, 2, 3, 4, 5]) == 15
    assert len(calls) == 1


@pytest.mark.parametrize(
    "other",
    [
        np.nextafter(np.arange(6.0), 9.0),
        np.arange(6.0).reshape(2, 3),
        np.arange(6),
        np.arange(6.0)[::-1],
    ],
)
def test_other_numbers_shapes_and_types_are_others(counted, other):
    total, calls = counted
    total(np.arange(6.0))
    total(other)
    assert len(calls) == 2
    assert calls[1][0].shape == other.shape
    np.testing.assert_array_equal(calls[1][0], other)


def test_an_array_that_is_written_to_is_another(counted):
    total, _ = counted
    array = np.arange(6.0)
    assert total(array) == 15
    array[0] = 5
    assert total(array) == 20


def test_refusals_and_large_arrays_are_not_kept(counted, monkeypatch):
    total, calls = counted
    for _ in range(2):
        with pytest.raises(InputError, match="must not be 0"):
            total(np.zeros(3))
    monkeypatch.setattr(content_cache, "LARGEST", 8 * 5)
    for _ in range(2):
        total(np.ones(6))
    assert len(calls) == 4


def test_what_is_kept_cannot_be_changed():
    mesh = tessellate(load_stone("inoue-3"))
    found = closed_surface(mesh.vertices, mesh.faces)
    assert closed_surface(mesh.vertices.copy(), mesh.faces.copy()) is found
    with pytest.raises(ValueError, match="read-only"):
        found.triangles[0] = 0

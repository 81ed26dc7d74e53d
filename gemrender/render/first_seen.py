"""What camera rays meet first: a stone, the ground, or what stands beside the stones."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

__all__ = ["Seen", "is_foreground", "kind_of", "kinds_of"]


class Seen(IntEnum):
    """What a camera ray meets before anything else."""

    #: Nothing, a light or a black screen; in scenes that are not of set-ups anything but a stone.
    OTHER = 0
    STONE = 1
    GROUND = 2
    #: A setting or a thing.
    BESIDE = 3


#: How the names begin that `photoreal_scene` gives to shapes.
_NAMES = {"ground": Seen.GROUND, "cup_": Seen.GROUND, "setting_": Seen.BESIDE, "thing_": Seen.BESIDE}


def kinds_of(scene: Any) -> Any:
    """Return what each shape is, by the number that Dr.Jit knows it by (UInt32); 0 is no shape."""
    import drjit as dr
    import mitsuba as mi

    numbers = [int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0]) for shape in scene.shapes()]
    table = np.zeros(max(numbers, default=0) + 1, dtype=np.uint32)
    for number, shape in zip(numbers, scene.shapes(), strict=True):
        table[number] = _kind(shape)
    return mi.UInt32(table)


def kind_of(kinds: Any, shape: Any, active: Any = True) -> Any:
    """Return what shapes are by the table of `kinds_of`, as `Seen`; 0 where they are none."""
    import drjit as dr
    import mitsuba as mi

    return dr.gather(mi.UInt32, kinds, dr.reinterpret_array(mi.UInt32, shape), active)


def is_foreground(kinds: Any, shape: Any, active: Any = True) -> Any:
    """Return whether shapes are stones or stand beside them, by the table of `kinds_of`."""
    kind = kind_of(kinds, shape, active)
    return (kind == int(Seen.STONE)) | (kind == int(Seen.BESIDE))


def _kind(shape: Any) -> Seen:
    if type(shape.bsdf()).__name__ == "GemDielectric":
        return Seen.STONE
    return next((kind for name, kind in _NAMES.items() if shape.id().startswith(name)), Seen.OTHER)

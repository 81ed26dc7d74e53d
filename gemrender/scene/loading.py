"""Loading of scenes: always in the order in which they are described."""

from __future__ import annotations

from typing import Any

__all__ = ["load_scene"]

#: What Mitsuba's loader is told. By default Mitsuba 3.9 puts all meshes, rectangles among them, through its
#: plugin `merge`, whose table is keyed by addresses in memory: shapes and emitters then come out in an order
#: that differs from run to run, and as an emitter is drawn by its place, so do pictures of one seed. And it
#: makes the parts on several threads, which number them as they happen to end.
_IN_ORDER = {"optimize": False, "parallel": False}


def load_scene(description: dict[str, Any]) -> Any:
    """Load a scene, or a part of one, for the active variant: shapes and lights in one order.

    Parameters
    ----------
    description : dict
        As for `mi.load_dict`.

    Returns
    -------
    mi.Object
        A `mi.Scene` for a dictionary of type "scene".
    """
    import drjit as dr
    import mitsuba as mi

    # Dr.Jit orders a kernel's numbers by the block that they are from, and equal numbers are from that of the
    # first. Those of a scene are its own, and from before any pass: else the first pass would be another
    # kernel than the others, and those of the next scene other ones again.
    with dr.scoped_set_flag(dr.JitFlag.ValueNumbering, False):
        made = mi.load_dict(description, **_IN_ORDER)
    dr.detail.new_scope(dr.backend_v(mi.Float))
    return made

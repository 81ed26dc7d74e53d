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
    import mitsuba as mi

    return mi.load_dict(description, **_IN_ORDER)

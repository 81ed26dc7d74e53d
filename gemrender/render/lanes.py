"""How many rays Mitsuba follows at once."""

from __future__ import annotations

__all__ = ["AT_ONCE", "lanes_at_once"]

#: Rays that keep the cores of a processor busy, and need less than half a GiB.
AT_ONCE = 1 << 21
#: A graphics processor has room for so many times as many, and is idle while Python prepares the next.
_ON_GRAPHICS = 4


def lanes_at_once() -> int:
    """Return how many rays the active variant is to follow at once, a power of two."""
    import mitsuba as mi

    return AT_ONCE * (_ON_GRAPHICS if mi.variant().startswith("cuda") else 1)

"""Scenes loaded by one thread, for tests that compare pictures bit for bit."""

from __future__ import annotations

from functools import partial
from typing import Any

from gemrender.render import photoreal


def load_one_after_the_other(set_attribute: Any = setattr) -> None:
    """Have pictures load their scenes without Mitsuba's threads, whose order numbers the shapes.

    `set_attribute` may be monkeypatch's.
    """
    ensure = photoreal.ensure_variant

    def ensure_variant(name: str) -> str:
        out = ensure(name)
        import mitsuba as mi

        if not isinstance(mi.load_dict, partial):
            set_attribute(mi, "load_dict", partial(mi.load_dict, parallel=False))
        return out

    set_attribute(photoreal, "ensure_variant", ensure_variant)

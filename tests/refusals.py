"""What is refused, and the one line that says why."""

from __future__ import annotations

import pytest

from gemrender.errors import InputError


def refused(call, *parts):
    """See that a call is refused in one line that has these parts."""
    with pytest.raises(InputError) as caught:
        call()
    line = str(caught.value)
    assert "\n" not in line
    for part in parts:
        assert part in line

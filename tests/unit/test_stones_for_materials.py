"""Bundled stones that were cut for their material: no window in it, where a diamond's cut has one."""

from __future__ import annotations

from dataclasses import replace

import pytest

import gemrender

CUTS = {
    "corundum-round": "ruby",
    "corundum-oval": "blue sapphire",
    "quartz-round": "amethyst",
    "quartz-emerald": "amethyst",
    "garnet-cushion": "rhodolite",
}
#: The cut of a diamond that each was improved from.
FROM = {
    "corundum-round": "gia-excellent",
    "corundum-oval": "oval-classic",
    "quartz-round": "gia-excellent",
    "quartz-emerald": "emerald-even",
    "garnet-cushion": "cushion-antique",
}
#: A window that nobody sees [per cent of the view].
UNSEEN = 0.1


def returned(stone):
    """Light return and window [per cent of the view]."""
    iso, window = gemrender.score(stone, measures=["iso", "window"], fresnel="exact").measures
    return iso.values["value"], window.values["value"]


@pytest.mark.parametrize("name", CUTS)
def test_it_has_no_window_and_returns_more_light_than_the_diamonds_cut(name):
    stone = gemrender.load_stone(name)
    assert stone.material == CUTS[name]
    assert stone.size_mm is not None
    iso, window = returned(stone)
    assert window <= UNSEEN
    others_iso, others_window = returned(replace(gemrender.load_stone(FROM[name]), material=stone.material))
    assert iso - 2 * window > others_iso - 2 * others_window

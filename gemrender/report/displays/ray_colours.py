"""Colours of rays: the paper's shades of red by intensity, white for rear light."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from gemrender.observation import RayStatus
from gemrender.reference import RayPath
from gemrender.report.displays.page import DARK, Page

__all__ = ["RAY_COLOURS", "REAR_COLOUR", "draw_scale", "intensity_text", "ray_colour", "text_colour"]

#: Shades of red for intensities from 0 to 100 %, their lightness rising evenly: told apart without seeing
#: red as well.
RAY_COLOURS = ("#96191d", "#b82328", "#e0322f", "#ff6b57", "#ffa491")
#: Words in the shades of weaker rays would be hard to read on the dark ground [%].
LEAST_TEXT_INTENSITY = 60.0
#: Rear light, of intensity 0, and rays that never leave.
REAR_COLOUR = "#ffffff"
UNSOLVED_COLOUR = "#5fb3d9"


def ray_colour(path: RayPath) -> Any:
    """Return a ray's colour: shades of red by intensity, white for rear light."""
    if path.status != RayStatus.EXITED:
        return UNSOLVED_COLOUR
    return REAR_COLOUR if path.rear else _red(path.primary_intensity)


def text_colour(path: RayPath) -> Any:
    """Return the colour of words about a ray: its own, but never so dark that they are hard to read."""
    if path.status != RayStatus.EXITED or path.rear:
        return ray_colour(path)
    return _red(max(path.primary_intensity, LEAST_TEXT_INTENSITY))


def _red(intensity: float) -> Any:
    return _reds()(np.clip(intensity / 100, 0, 1))


@cache
def _reds() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("gemrender_rays", RAY_COLOURS)


def intensity_text(path: RayPath) -> str:
    """Return a ray's intensity as it is written."""
    if path.status == RayStatus.TRAPPED:
        return "trapped"
    if path.status == RayStatus.LOST:
        return "lost"
    return "0 (rear)" if path.rear else f"{path.primary_intensity:.1f} %"


def draw_scale(page: Page, left: float, bottom: float, width: float) -> None:
    """Draw the scale of intensity: red from 0 to 100, white for rear light apart."""
    from matplotlib.collections import PolyCollection

    axes = page.axes(left, bottom, width, 0.62)
    steps, start = 100, 1.05
    length = width - start - 0.15
    ends = [(0.1, 0.6)]
    # Each reaches under the next: no seams.
    ends += [(start + length * i / steps, start + length * min(i + 2, steps) / steps) for i in range(steps)]
    fields = [[(low, 0.0), (high, 0.0), (high, 0.16), (low, 0.16)] for low, high in ends]
    colours = [REAR_COLOUR, *(_red(100 * (i + 0.5) / steps) for i in range(steps))]
    axes.add_collection(PolyCollection(fields, facecolors=colours, linewidths=0), autolim=False)
    axes.text(0.35, -0.08, "rear, 0", fontsize=9.5, color=DARK.soft, ha="center", va="top")
    for tick in range(0, 101, 25):
        x = start + length * tick / 100
        axes.text(x, -0.08, f"{tick}", fontsize=9.5, color=DARK.soft, ha="center", va="top")
    axes.text(0.1, 0.27, "Intensity [%]", fontsize=9.5, color=DARK.soft)

"""A studio all around: softboxes with soft edges and gradients in a room, drawn as an image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from gemrender.colorimetry import white_xyz
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import located_at, section
from gemrender.scene import setup_checks as check
from gemrender.scene.placing import towards

__all__ = ["MOST_BOXES", "SHAPES", "Box", "boxes_of", "draw_studio"]

#: Most boxes of a studio.
MOST_BOXES = 64
SHAPES = ("rectangle", "disc")
#: Rows of the image, 0.18 degrees each, and how soft the hardest edge is [deg]: no stairs are seen.
ROWS, _HARDEST_DEG = 1024, 0.25
_ALLOWED = f"must be 1 to {MOST_BOXES} tables, as [[sky.boxes]] with elevation, azimuth, size"


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A softbox, infinitely far away.

    Attributes
    ----------
    shape : {"rectangle", "disc"}
        What it looks like from the stones, straight on; a disc may be an ellipse.
    elevation, azimuth : float
        Where its middle is seen from the stones [deg].
    size : (float, float)
        Width and height, as seen from the stones; one number for both [deg].
    soft : float
        Width of the edge, over which it fades from its full radiance to what is behind it [deg].
    gradient : (float, float)
        Share of the radiance at the lower and at the upper edge, even in between.
    radiance : float
        Luminance, as of a light. Of 0 it is a black flag: later boxes hide earlier ones.
    spectrum : str or float
        As of a light.
    """

    shape: str = "rectangle"
    elevation: float = 45.0
    azimuth: float = 0.0
    size: tuple[float, float] = (30.0, 30.0)
    soft: float = 2.0
    gradient: tuple[float, float] = (1.0, 1.0)
    radiance: float = 1.0
    spectrum: str | float = "d65"

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "shape", SHAPES)
            mistakes.of(check.within, self, "elevation", -90, 90)
            mistakes.of(check.within, self, "azimuth", -360, 360)
            mistakes.of(check.within, self, "soft", 0, 90)
            mistakes.of(check.radiance, self)
            mistakes.of(check.spectrum, self)
            size = mistakes.of(_pair, self, "size", 0.1, 170, "one or two numbers", "[degrees]", same=True)
            gradient = mistakes.of(_pair, self, "gradient", 0, 1, "two numbers", "", same=False)
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "gradient", gradient)

    @property
    def is_dark(self) -> bool:
        """Whether it gives no light."""
        return self.radiance == 0 or not any(self.gradient)


def boxes_of(rows: Any) -> tuple[Box, ...]:
    """Return the boxes of rows, each a `Box` or a table of its attributes.

    Raises
    ------
    InputError
        What is wrong with each.
    """
    if rows == ():
        raise InputError(f"missing; {_ALLOWED}", key="boxes")
    if not isinstance(rows, (list, tuple)) or not 1 <= len(rows) <= MOST_BOXES:
        raise InputError(_ALLOWED, key="boxes", value=rows)
    if not all(isinstance(row, (Box, dict)) for row in rows):
        raise InputError(_ALLOWED, key="boxes", value=list(rows))
    with Mistakes() as mistakes:
        boxes = [mistakes.of(_box, row, f"boxes {k}", mistakes) for k, row in enumerate(rows, start=1)]
    return tuple(box for box in boxes if box is not None)


def draw_studio(
    boxes: Sequence[Box], *, radiance: float, spectrum: str | float, rows: int = ROWS
) -> np.ndarray:
    """Return the image of a studio, (rows, 2 rows, 3) float32: CIE XYZ, equirectangular.

    The middle column is azimuth 0. A box is drawn on the plane that touches the sphere of directions in its
    middle; its luminance there is (1 - a) of what is behind it plus a of its own.

    Parameters
    ----------
    boxes : sequence of Box
        The boxes, each before the one before it.
    radiance, spectrum : float, str or float
        Of the room, all around.
    rows : int
        Rows of the image.
    """
    columns = 2 * rows
    elevation = np.radians(90 - (np.arange(rows) + 0.5) * 180 / rows)[:, None]
    azimuth = np.radians(180 - (np.arange(columns) + 0.5) * 360 / columns)[None, :]
    directions = np.stack(
        np.broadcast_arrays(
            np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
        ),
        axis=2,
    ).astype(np.float32)
    image = np.broadcast_to(radiance * white_xyz(spectrum), directions.shape).astype(np.float32)
    directions, image = directions.reshape(-1, 3), image.reshape(-1, 3)
    for box in boxes:
        there = _around(box, directions)
        share, level = _seen(box, directions[there])
        own = (box.radiance * level)[:, None] * white_xyz(box.spectrum)
        image[there] += share[:, None] * (own - image[there])
    return image.reshape(rows, columns, 3)


def _around(box: Box, directions: np.ndarray) -> np.ndarray:
    """Return which of directions (n, 3) a box can cover: a cone about its middle, up to its corners."""
    middle = towards(box.elevation, box.azimuth).astype(np.float32)
    reach = np.tan(np.radians(0.5 * np.array(box.size)))
    return np.flatnonzero(directions @ middle > 1 / np.sqrt(1 + reach @ reach) - 1e-5)


def _seen(box: Box, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how much of a box covers each direction, 0 to 1, and the share of its radiance there."""
    middle = towards(box.elevation, box.azimuth)
    turn = np.radians(box.azimuth)
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.cross(middle, right)
    forward, x, y = (directions @ axis.astype(np.float32) for axis in (middle, right, up))
    facing = forward > 1e-3
    forward = np.where(facing, forward, 1.0)
    # Angles from the middle along both sides; on the plane their tangents
    across, above = np.degrees(np.arctan2(x, forward)), np.degrees(np.arctan2(y, forward))
    half = 0.5 * np.array(box.size)
    soft = max(box.soft, _HARDEST_DEG)
    if box.shape == "rectangle":
        inside = np.minimum(half[0] - np.abs(across), half[1] - np.abs(above))
    else:
        inside = min(half) * (1 - np.hypot(across / half[0], above / half[1]))
    edge = np.clip(inside / soft, 0, 1)
    share = np.where(facing, edge * edge * (3 - 2 * edge), 0.0)
    low, high = box.gradient
    height = np.clip(0.5 + 0.5 * above / half[1], 0, 1)
    return share, low + (high - low) * height


def _box(row: Any, name: str, mistakes: Mistakes) -> Box:
    if isinstance(row, Box):
        return row
    values = section({name: row}, name, [f.name for f in fields(Box)], mistakes=mistakes)
    with located_at(None, name):
        return Box(**values)


def _pair(
    box: Box, key: str, low: float, high: float, what: str, unit: str, *, same: bool
) -> tuple[float, float]:
    values = getattr(box, key)
    if same and isinstance(values, (int, float)) and not isinstance(values, bool):
        values = (values, values)
    allowed = f"must be {what} from {low:g} to {high:g} {unit}".rstrip()
    error = InputError(allowed, key=key, value=getattr(box, key))
    if not isinstance(values, (list, tuple)) or len(values) != 2:
        raise error
    for value in values:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            raise error
    return float(values[0]), float(values[1])

"""The section [crystal] of stone files, read and written: how the crystal lies in the stone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.crystals.frame import TABLE, frame_of_angles, frame_of_c_axis
from gemrender.stone.orientation import Orientation

__all__ = [
    "CRYSTAL_KEYS",
    "crystal_lines",
    "orientation",
    "orientation_values",
    "parse_c_axis",
    "read_orientation",
]

#: Keys of the section, of which a file has one.
CRYSTAL_KEYS = ("c_axis", "angles")


def orientation(*, c_axis: Any = None, angles: Any = None) -> Orientation:
    """Return how a crystal lies in a stone, by one of both.

    Parameters
    ----------
    c_axis : sequence of 3 float, or "table"
        The optic axis in the stone's frame (z along its axis, table up), of any length; or along the stone's
        axis. Of a biaxial crystal it is the axis gamma, of the greatest index; alpha and beta are across it.
    angles : sequence of 3 float
        Euler's angles of the optic frame by Bunge's convention [deg], as of
        `gemrender.optics.crystals.frame_of_angles`.

    Raises
    ------
    InputError
        None or both of them, or values that make no frame.
    """
    given = {key: value for key, value in (("c_axis", c_axis), ("angles", angles)) if value is not None}
    return read_orientation(given)


def read_orientation(values: Mapping[str, Any]) -> Orientation:
    """Return how a crystal lies by the keys of a section [crystal]; errors as of `orientation`."""
    if len(values) != 1:
        has = "both" if values else "none"
        raise InputError(f"needs exactly one of {' and '.join(CRYSTAL_KEYS)}; has {has}", key="[crystal]")
    ((key, value),) = values.items()
    frame = frame_of_c_axis(value) if key == "c_axis" else frame_of_angles(value)
    told = value if isinstance(value, str) else tuple(float(part) for part in value)
    return Orientation(axes=tuple(map(tuple, frame.tolist())), key=key, value=told)


def parse_c_axis(text: str) -> Any:
    """Return the c axis that a text names: "table", or three numbers with commas between them.

    Raises
    ------
    InputError
        Something else.
    """
    words = text.strip()
    try:
        value: Any = words if words == TABLE else tuple(float(part) for part in words.split(","))
    except ValueError:
        value = ()
    if not isinstance(value, str) and len(value) != 3:
        raise InputError(f'must be three numbers, as 1,0,0, or "{TABLE}"', key="c_axis", value=text)
    orientation(c_axis=value)
    return value


def orientation_values(crystal: Orientation) -> dict[str, Any]:
    """Return how a crystal lies as `read_orientation` takes it, with all digits: plain data."""
    key, value = crystal.key, crystal.value
    if not key:
        key, value = "angles", _angles_deg(crystal.array())
    return {key: value if isinstance(value, str) else list(value)}


def crystal_lines(crystal: Orientation) -> list[str]:
    """Return the section [crystal] of a stone file that says how a crystal lies."""
    ((key, value),) = orientation_values(crystal).items()
    shown = f'"{value}"' if isinstance(value, str) else repr(value)
    return ["", "[crystal]", f"{key} = {shown}"]


def _angles_deg(frame: np.ndarray) -> tuple[float, ...]:
    """Return Euler's angles of an optic frame (3, 3) by Bunge's convention [deg]."""
    third = frame[2]
    if np.hypot(third[0], third[1]) < 1e-12:  # along the stone's axis: one angle tells it
        first, last = np.arctan2(frame[0, 1], frame[0, 0]), 0.0
    else:
        first, last = np.arctan2(third[0], -third[1]), np.arctan2(frame[0, 2], frame[1, 2])
    middle = np.arctan2(np.hypot(third[0], third[1]), third[2])
    return tuple(float(angle) for angle in np.degrees([first, middle, last]))

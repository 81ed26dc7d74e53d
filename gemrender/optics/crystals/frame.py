"""How a crystal lies in a stone: its optic frame, the principal axes in the stone's frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.tabulated import numbers_of

__all__ = ["RIGHT_ANGLE_DEG", "TABLE", "frame_of_angles", "frame_of_axes", "frame_of_c_axis"]

#: The word for an optic axis along the stone's axis: one looks along it through the table.
TABLE = "table"
#: How far from a right angle two axes may be that are given as numbers: written with four decimals [deg].
RIGHT_ANGLE_DEG = 0.05


def frame_of_c_axis(c_axis: Any, key: str = "c_axis") -> np.ndarray:
    """Return the optic frame of a uniaxial crystal.

    Parameters
    ----------
    c_axis : sequence of 3 float, or str
        The optic axis in the stone's frame (z along the axis, table up), of any length; or "table".
    key : str
        What errors call it.

    Returns
    -------
    (3, 3) float64
        Rows are the principal axes as unit vectors, right-handed; the last is the optic axis. The first is at
        right angles to it and to that of the stone's x and y axes which is further from it.

    Raises
    ------
    InputError
        No three finite numbers, or all of them zero; another word.
    """
    if isinstance(c_axis, str):
        if c_axis != TABLE:
            raise InputError(f'must be [x, y, z] in the stone\'s frame, or "{TABLE}"', key=key, value=c_axis)
        return np.eye(3)
    axis = _unit(c_axis, key)
    other = np.eye(3)[int(np.argmin(np.abs(axis[:2])))]
    first = np.cross(other, axis)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first), axis])


def frame_of_axes(*, alpha: Any = None, beta: Any = None, gamma: Any = None) -> np.ndarray:
    """Return the optic frame of a biaxial crystal from two or three of its axes.

    Parameters
    ----------
    alpha, beta, gamma : sequence of 3 float, or None
        Axes of the least, middle and greatest index in the stone's frame, of any length and either sense, at
        right angles within `RIGHT_ANGLE_DEG`. One may be left out.

    Returns
    -------
    (3, 3) float64
        Rows are the axes alpha, beta and gamma as unit vectors, right-handed (where three are given, gamma's
        sense gives way) and at right angles: the second of those given is turned to it.

    Raises
    ------
    InputError
        Fewer than two axes; no three finite numbers, or all of them zero; axes not at right angles.
    """
    given = {
        name: _unit(axis, name)
        for name, axis in (("alpha", alpha), ("beta", beta), ("gamma", gamma))
        if axis is not None
    }
    if len(given) < 2:
        raise InputError("must be at least two of alpha, beta, gamma", key="axes", value=list(given))
    names = list(given)
    for i, one in enumerate(names):
        for other in names[:i]:
            off = np.degrees(np.arcsin(min(abs(float(given[one] @ given[other])), 1.0)))
            if off > RIGHT_ANGLE_DEG:
                raise InputError(
                    f"must be at right angles to {other}, within {RIGHT_ANGLE_DEG:g} degrees, and is "
                    f"{off:.3g} off",
                    key=one,
                    value=given[one].tolist(),
                )
    first, second = given[names[0]], given[names[1]]
    second = second - (second @ first) * first
    second /= np.linalg.norm(second)
    if names[:2] == ["alpha", "beta"]:
        return np.array([first, second, np.cross(first, second)])
    if names[:2] == ["alpha", "gamma"]:
        return np.array([first, np.cross(second, first), second])
    return np.array([np.cross(first, second), first, second])


def frame_of_angles(angles_deg: Any, key: str = "angles") -> np.ndarray:
    """Return the optic frame from Euler's angles.

    Bunge's convention of crystallography (Bunge, Texture Analysis in Materials Science (1982), section
    2.1.2): the crystal's axes, first along the stone's x, y and z, are turned right-handed about their third
    axis, about their first, and about their third again.

    Parameters
    ----------
    angles_deg : sequence of 3 float
        The three angles, phi1, Phi and phi2 [deg].
    key : str
        What errors call them.

    Returns
    -------
    (3, 3) float64
        Rows are the principal axes as unit vectors, right-handed.

    Raises
    ------
    InputError
        No three finite numbers.
    """
    first, second, third = np.radians(_three(angles_deg, key))
    return np.asarray(_about_third(third) @ _about_first(second) @ _about_third(first))


def _about_third(angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _about_first(angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]])


def _three(values: Any, key: str) -> np.ndarray:
    made = numbers_of(values, key)
    if len(made) != 3:
        raise InputError("must be three numbers", key=key, value=list(made))
    return np.array(made)


def _unit(values: Any, key: str) -> np.ndarray:
    made = _three(values, key)
    largest = np.abs(made).max()
    if not largest > 0:
        raise InputError("must be a direction, not all zeros", key=key, value=made.tolist())
    made = made / largest  # its square is a float, whatever the length
    return np.asarray(made / np.linalg.norm(made))

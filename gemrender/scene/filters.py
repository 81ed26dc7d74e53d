"""Polarising filters of a set-up: before the camera, and before all lights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.scene import setup_checks as check

__all__ = ["Filters"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Filters:
    """Polarising filters, by the angles of the axes along which they let light through.

    Angles are from the picture's horizontal, anticlockwise as the camera sees them [deg]; None is no filter.

    Attributes
    ----------
    analyser : float or None
        Of the filter before the camera.
    polariser : float or None
        Of that before all lights and the sky.
    windows : {1, 2}
        Whether two windows show the same, side by side, the right one through a filter across the left one's:
        a dichroscope.

    Raises
    ------
    InputError
        An angle that is no number from -360 to 360, or two windows without an analyser.
    """

    analyser: float | None = None
    polariser: float | None = None
    windows: int = 1

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            for key in ("analyser", "polariser"):
                if getattr(self, key) is not None:
                    mistakes.of(check.within, self, key, -360, 360)
            if isinstance(self.windows, bool) or self.windows not in (1, 2):
                mistakes.add(InputError("must be 1 or 2", key="windows", value=self.windows))
            elif self.windows == 2 and self.analyser is None:
                mistakes.add(InputError("needs an analyser, that of the left one", key="windows", value=2))

    def window_width(self, width: int) -> int:
        """Return the width of each window of a picture [pixels].

        Raises
        ------
        InputError
            There are two, and the picture's width is odd.
        """
        if width % self.windows:
            raise InputError("must be even, for two windows", key="size: width", value=width)
        return width // self.windows

    def axes(self, right: np.ndarray, up: np.ndarray) -> dict[str, list[float]]:
        """Return the axes of those that there are, as parameters of `gem_path`.

        Parameters
        ----------
        right, up : (3,) float64
            The camera's, in the world.
        """
        angles = {"analyser": self.analyser, "polariser": self.polariser}
        if self.windows == 2 and self.analyser is not None:
            angles["right_analyser"] = self.analyser + 90.0
        return {
            key: (np.cos(np.radians(angle)) * right + np.sin(np.radians(angle)) * up).tolist()
            for key, angle in angles.items()
            if angle is not None
        }

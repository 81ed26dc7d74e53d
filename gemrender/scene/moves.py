"""How stones move in films: turned once about the vertical, or rocked or tilted to and fro.

Each move is a closed form of the share of the film, and at 1 is where it was at 0: films are loops without
a seam. Camera, lights and ground stand still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.placing import Placed

__all__ = ["DEFAULT_TO_DEG", "MOVES", "Move"]

MOVES = ("turntable", "rock", "tilt")
#: How far a stone is rocked and tilted [deg]: as far as a hand does that shows how it sparkles.
DEFAULT_TO_DEG = 15.0
#: Shares of a move that the camera leaves room for.
_LOOKED_AT = 36


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """How stones move.

    Attributes
    ----------
    type : {"turntable", "rock", "tilt"}
        One turn about the vertical through the middle of all stones, anticlockwise as seen from above; to and
        fro from side to side, each stone about the level axis through its middle that points to the camera,
        first to the right; or to the camera and away from it, about the axis across the picture.
    to_deg : float
        How far stones are rocked and tilted, either way [deg].

    Raises
    ------
    InputError
        No such move, or an angle that is not above 0 and up to 90.
    """

    type: str = "turntable"
    to_deg: float = DEFAULT_TO_DEG

    def __post_init__(self) -> None:
        if self.type not in MOVES:
            raise InputError(f"must be one of {', '.join(MOVES)}", key="move", value=self.type)
        number = isinstance(self.to_deg, (int, float)) and not isinstance(self.to_deg, bool)
        if not number or not 0 < self.to_deg <= 90:
            raise InputError("must be above 0 and up to 90 [degrees]", key="to", value=self.to_deg)

    @classmethod
    def of(cls, type_: str, to_deg: float | None) -> Move:
        """Return a move, by default as far as one has it.

        Raises
        ------
        InputError
            No such move or angle, or an angle for a turntable.
        """
        if to_deg is None:
            return cls(type=type_)
        if type_ == "turntable":
            raise InputError("is of rock and tilt; a turntable turns once round", key="to", value=to_deg)
        return cls(type=type_, to_deg=to_deg)

    def check_ground(self, ground: str) -> None:
        """Check that stones can move so on a ground, one of `gemrender.scene.setup.GROUNDS`.

        Raises
        ------
        InputError
            They stand in cups, which hold them upright.
        """
        if ground == "cup" and self.type != "turntable":
            raise InputError("must be turntable where stones stand in cups", key="move", value=self.type)

    def angle_deg(self, share: float) -> float:
        """Return the angle at a share of the film [deg]: evenly once round, or as a pendulum swings."""
        share %= 1.0
        return 360.0 * share if self.type == "turntable" else self.to_deg * float(np.sin(2 * np.pi * share))

    def placed(
        self, stones: Sequence[Placed], share: float, *, azimuth_deg: float, on_ground: bool
    ) -> list[Placed]:
        """Return stones in their places at a share of the film.

        Parameters
        ----------
        stones : sequence of Placed
            Where they rest.
        share : float
            Share of the film; whole numbers are where it begins.
        azimuth_deg : float
            Azimuth of the camera [deg].
        on_ground : bool
            Whether they are rocked and tilted on the ground, which they go on touching, or in the air.
        """
        angle = self.angle_deg(share)
        if self.type == "turntable":
            return [stone.turned(angle) for stone in stones] if angle else list(stones)
        cos, sin = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
        # Across the picture to the right; and away from the camera, for the table to lean to the right
        axis = [-sin, cos, 0.0] if self.type == "tilt" else [-cos, -sin, 0.0]
        rotation = _about(np.array(axis), np.radians(angle))
        moved = []
        for stone in stones:
            points = stone.points()
            turned = stone.rotated(rotation, about=0.5 * (points.min(axis=0) + points.max(axis=0)))
            if on_ground:
                sunk = points[:, 2].min() - turned.points()[:, 2].min()
                turned = turned.shifted(np.array([0.0, 0.0, sunk]))
            moved.append(turned)
        return moved

    def all_placed(
        self, stones: Sequence[Placed], *, azimuth_deg: float, on_ground: bool
    ) -> list[list[Placed]]:
        """Return stones in their places all through the film, as the camera must see them."""
        shares = np.arange(_LOOKED_AT) / _LOOKED_AT
        return [self.placed(stones, float(s), azimuth_deg=azimuth_deg, on_ground=on_ground) for s in shares]


def _about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the right-handed rotation (3, 3) about a unit vector, by Rodrigues' formula [rad]."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)

"""What a set-up says of the stones' setting."""

from __future__ import annotations

from dataclasses import dataclass

from gemrender.mistakes import Mistakes
from gemrender.optics.metals import METALS
from gemrender.scene import setup_checks as check
from gemrender.scene.surfaces import FINISHES

__all__ = ["FINISHES", "SETTINGS", "Setting"]

SETTINGS = ("none", "solitaire", "bezel", "pendant")


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What holds each of the stones.

    Attributes
    ----------
    type : {"none", "solitaire", "bezel", "pendant"}
        Nothing; a ring with claws; a ring with a rim around the girdle; claws that hang on a chain.
    metal : {"platinum", "gold", "silver"}
        What it is made of.
    finish : {"polished", "rough"}
        Its surface; rough is satin.
    """

    type: str = "none"
    metal: str = "platinum"
    finish: str = "polished"

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "type", SETTINGS)
            mistakes.of(check.one_of, self, "metal", tuple(METALS))
            mistakes.of(check.one_of, self, "finish", FINISHES)

"""Settings made for a stone: heads on rings and on chains, in sensible proportions.

What a finger asks for is in millimetres, whatever the stone: a ring of 17.3 mm inside (54 by ISO 8653, 7 in
the United States). Wires, walls and bands grow as the root of the stone's size, the geometric mean of length
and width; for 6.5 mm, a round diamond of 1 ct, a band is 1.8 mm wide and 1.6 mm thick, a claw 0.7 mm, a rim
0.5 mm. These are a goldsmith's usual figures, chosen here and taken from no one source.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.scene.settings.heads import GAP, Head, claws, rim
from gemrender.scene.settings.outline import Outline, claw_directions
from gemrender.scene.settings.solids import band, loop, wire
from gemrender.scene.smooth import PlainMesh, joined
from gemrender.stone import Stone

__all__ = ["CONTACT", "MadeSetting", "make_setting"]

#: How far metal is at most from the girdle where it holds a stone [girdle radius].
CONTACT = 2 * GAP
#: Inner diameter of a ring [mm].
FINGER_MM = 17.3
#: Of a stone of this diameter [mm]: width and thickness of a band, radius of claws, thickness of a rim.
_USUAL_MM = 6.5
BAND_MM, THICK_MM, CLAW_MM, RIM_MM = 1.8, 1.6, 0.35, 0.5
#: A claw is no thicker, and a rim, beside a small stone [girdle radius].
_THICKEST = 0.2
#: What is as near to the stone's middle should be seen of a ring: head and shoulders [girdle radius].
_SHOWN = 2.5
#: A ring's finger points so far beside the camera: three-quarter view [deg].
_ASIDE_DEG = 32.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MadeSetting:
    """A setting in its stone's own frame.

    Attributes
    ----------
    mesh : PlainMesh
        All of it, closed parts that overlap [girdle radius].
    framed : (n, 3) float64
        What a picture should show of it.
    lowest : float
        Height of what it stands on.
    turn_deg : float
        Turn about the vertical for a camera at azimuth -90 to see it well.
    """

    mesh: PlainMesh
    framed: np.ndarray
    lowest: float
    turn_deg: float


def make_setting(stone: Stone, kind: str, *, radius_mm: float) -> MadeSetting:
    """Make a setting from a stone's outline.

    Parameters
    ----------
    stone : Stone
        The stone.
    kind : {"solitaire", "bezel", "pendant"}
        What to make.
    radius_mm : float
        Size of the stone's unit: its girdle radius, or half its longer side [mm].
    """
    outline = Outline.of(stone)
    length, width = np.ptp(outline.points, axis=0)
    growth = (radius_mm * (length * width) ** 0.5 / _USUAL_MM) ** 0.5
    claw, wall = (min(mm * growth / radius_mm, _THICKEST) for mm in (CLAW_MM, RIM_MM))
    long_angle = outline.long_angle
    if kind == "pendant":
        head = claws(outline, claw_directions(outline, first=long_angle), claw, "pendant")
        bail, chain = _bail(outline, head, long_angle, claw)
        framed = joined([*head.parts, *bail])
        return MadeSetting(
            mesh=joined([framed, chain]),
            framed=framed.positions,
            lowest=head.bottom,
            turn_deg=90.0 - float(np.degrees(long_angle)),
        )
    if kind == "solitaire":
        head = claws(outline, claw_directions(outline), claw, "ring")
    else:
        head = rim(outline, wall)
    ring = _ring(outline, head, long_angle, growth / radius_mm, radius_mm)
    whole = joined([*head.parts, ring])
    near = np.linalg.norm(whole.positions - [*outline.middle, outline.girdle[1]], axis=1) < _SHOWN
    return MadeSetting(
        mesh=whole,
        framed=whole.positions[near],
        lowest=float(ring.positions[:, 2].min()),
        turn_deg=90.0 - float(np.degrees(long_angle)) - _ASIDE_DEG,
    )


def _ring(outline: Outline, head: Head, long_angle: float, per_mm: float, radius_mm: float) -> PlainMesh:
    """Return a band under a head, around a finger that points along the stone's longer side."""
    inner = 0.5 * FINGER_MM / radius_mm
    width, thickness = BAND_MM * per_mm, THICK_MM * per_mm
    along = np.array([np.cos(long_angle), np.sin(long_angle), 0.0])
    # The head stands in the band by a little, so that no light falls between them
    middle = np.array([*outline.middle, head.base + 0.1 * thickness - thickness - inner])
    middle[2] = min(middle[2], outline.bottom - GAP - 0.02 - thickness - inner)
    return band(inner, width, thickness, along, middle)


def _bail(outline: Outline, head: Head, angle: float, claw: float) -> tuple[list[PlainMesh], PlainMesh]:
    """Return the two links that a stone hangs by, and the chain that lies on the ground beside it."""
    out = np.array([np.cos(angle), np.sin(angle), 0.0])
    aside, up = np.array([-out[1], out[0], 0.0]), np.array([0.0, 0.0, 1.0])
    contact = np.array([*outline.support(angle), 0.0])
    low, high = outline.girdle
    thin, link, cord = 0.3 * claw, 1.1 * claw, 0.55 * claw
    # A link around the claw, level; one through it, upright; and the chain through that
    claw_at = contact + (claw + GAP) * out + (0.5 * (low + high) - 0.25 * claw) * up
    turn = 2 * np.pi * np.arange(40) / 40
    cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
    size = claw + link
    first = loop(claw_at + size * out + size * (cos * out + sin * aside), thin, up)
    length, height = 2.6 * claw, 1.7 * claw
    through = claw_at + (2 * size - 2 * thin - 1e-3 + length) * out
    second = loop(through + length * cos * out + height * sin * up, 1.3 * thin, aside)
    at = through + (length - 1.3 * thin - cord) * out
    floor = head.bottom + cord
    t = np.linspace(-1, 1, 161)
    sag = np.exp(-((3.2 * t) ** 2))
    reach = 14.0
    path = (
        at
        + reach * t[:, None] * aside
        + (0.45 * reach * np.abs(t) ** 1.3)[:, None] * out
        + ((floor - at[2]) * (1 - sag))[:, None] * up
    )
    return [first, second], wire(path, np.full(len(path), cord), up)

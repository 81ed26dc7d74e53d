"""A stone as the beam tracer sees it: a convex solid, and upright planes just inside its girdle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gemrender.beam.rules import Solid
from gemrender.beam.wall import wall_of
from gemrender.errors import InputError
from gemrender.observation import View
from gemrender.stone import Girdle, Stone
from gemrender.stone.topology import FACET_NAMES, N_SECTORS, TRIANGLE_FACET

__all__ = ["NO_WEDGE", "BeamStone", "beam_stone"]

#: Upright planes a sixteenth of a round girdle, for beams inside the stone and for the rim of the view.
#: More of them leave less light to single rays, and cut it into more cells.
_WALLS, _RIM = 2, 16
#: The same for a girdle that is not round.
_MEASURED_WALLS = 4
#: Hollows as deep as this are rounding in a file's digits, and are traced as flat [girdle radius]: they move
#: no score by more than a few times as much.
_HOLLOW = 1e-5

_STEP = np.pi / 8
#: The sixteenth of the view that the others are turned and mirrored images of: wedge . (u, v) <= 0.
_WEDGE = np.array([[0.0, -1.0], [-np.sin(_STEP), np.cos(_STEP)]])
#: The whole view.
NO_WEDGE = np.empty((0, 2))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeamStone:
    """A convex stone, ready for beams.

    Attributes
    ----------
    stone : Stone
        The stone.
    solid : Solid
        Its planes and walls.
    facet : (p + 1,) int64
        The facet that each plane belongs to; the last one is the girdle.
    symmetric : bool
        Whether it has the eight mirror planes of a perfect brilliant.
    """

    stone: Stone
    solid: Solid
    facet: np.ndarray
    symmetric: bool

    def wedge(self, view: View) -> np.ndarray:
        """Return the part of a view that tells all of it, (k, 2): a sixteenth, or no wedge for all."""
        return _WEDGE if self.symmetric and view.tilt_deg == 0 else NO_WEDGE


@lru_cache(maxsize=4)  # a score asks for it when the engine is chosen, checked and used
def beam_stone(stone: Stone) -> BeamStone:
    """Return the stone as planes and walls.

    Raises
    ------
    InputError
        The stone is not convex.
    """
    planes, facet = _planes(stone)
    if not stone.is_half_spaces:
        _check_convex(stone, planes, facet)
    if stone.girdle.is_round:
        walls, rim = _chords(N_SECTORS * _WALLS), _chords(N_SECTORS * _RIM)
    else:
        walls = rim = _measured_chords(stone.girdle)
    return BeamStone(
        stone=stone,
        solid=Solid(planes, planes, np.ascontiguousarray(planes.T), walls, rim, wall_of(stone.girdle)),
        facet=np.append(facet, len(FACET_NAMES) - 1),
        symmetric=stone.proportions is not None and not stone.is_half_spaces,
    )


def _planes(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    """One plane for each flat facet, one for each triangle of the others."""
    normals, offsets, facets = stone.triangle_normals, stone.triangle_offsets, TRIANGLE_FACET
    if stone.is_half_spaces:
        normals, offsets, facets = stone.facet_normals, stone.facet_offsets, np.arange(len(FACET_NAMES) - 1)
    planes = np.column_stack([normals, offsets])
    # The triangles of a flat facet have its very plane; neighbours in the list.
    new = np.ones(len(planes), dtype=bool)
    new[1:] = (planes[1:] != planes[:-1]).any(axis=1) | (facets[1:] != facets[:-1])
    return np.ascontiguousarray(planes[new]), facets[new]


def _check_convex(stone: Stone, planes: np.ndarray, facet: np.ndarray) -> None:
    beyond = stone.vertices @ planes[:, :3].T - planes[:, 3]
    worst = int(beyond.max(axis=0).argmax())
    depth = float(beyond[:, worst].max())
    if depth > _HOLLOW:
        raise InputError(
            f"is hollow beside facet {FACET_NAMES[facet[worst]]}, by {depth:.2g} girdle radii; the exact "
            "engine traces convex stones only, the engines mitsuba and reference trace this one",
            source=stone.source or stone.name,
        )


def _chords(number: int) -> np.ndarray:
    """Upright planes through so many even chords of the circle of radius 1, (number, 3)."""
    azimuth = (np.arange(number) + 0.5) * (2 * np.pi / number)
    offset = np.full(number, np.cos(np.pi / number))
    return np.column_stack([np.cos(azimuth), np.sin(azimuth), offset])


def _measured_chords(girdle: Girdle) -> np.ndarray:
    """Upright planes inside a measured girdle, some a sector, (n, 3)."""
    ring = np.unwrap(np.arctan2(girdle.upper[:, 1], girdle.upper[:, 0]))
    ring = np.append(ring, ring[0] + 2 * np.pi)
    share = np.arange(N_SECTORS * _MEASURED_WALLS) / _MEASURED_WALLS
    azimuth = np.interp(share, np.arange(N_SECTORS + 1), ring)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    edges = [girdle.radius(cos, sin, height) for height in _heights(girdle, azimuth)]
    # Scallops reach beyond the vertices' heights, where a leaning wall comes further in.
    lean = np.abs(edges[0] - edges[1]).max()
    radius = np.minimum(*edges) - lean
    corners = radius[:, None] * np.column_stack([cos, sin])
    along = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    return np.column_stack([normals, np.einsum("ij,ij->i", corners, normals)])


def _heights(girdle: Girdle, azimuth: np.ndarray) -> list[np.ndarray]:
    """Heights of the wall's two edges at some azimuths."""
    out = []
    for ring in (girdle.upper, girdle.lower):
        at = np.arctan2(ring[:, 1], ring[:, 0])
        out.append(np.interp(azimuth, at, ring[:, 2], period=2 * np.pi))
    return out

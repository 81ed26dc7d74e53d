"""The lists of polygons with modes that a trace works on, and how they grow."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.ahead import Ahead
from gemrender.beam.beams import BEAM, write_beam
from gemrender.beam.clipping import copy_out
from gemrender.beam.compiled import jit_inner
from gemrender.beam.modes.shares import Facet, empty_facet

__all__ = [
    "AREA", "BYTES", "ENTERING", "KX", "LEAVING", "NUMBERS", "SECTION", "SHARE", "WEIGHT", "ModePath",
    "ModePolygons", "ModeWork", "add", "add_node", "empty_mode_work", "has_room", "with_room",
]  # fmt: skip

#: What of `ModePolygons.numbers` comes after the beam: area, the mode's share, weight, and what leaves.
AREA, SHARE, WEIGHT, LEAVING, NUMBERS = BEAM, BEAM + 1, BEAM + 2, BEAM + 3, BEAM + 4
#: What `ModeWork.waves` holds: a wave vector, the cross-section, and what entered.
KX, SECTION, ENTERING, _WAVES = 0, 3, 4, 5
#: What of `facts` there is.
_FACTS, _NODE = 7, 3
#: What the lists hold of each node, corner and polygon [bytes].
BYTES = (8 * (_NODE + _WAVES), 16, 8 * (_FACTS + NUMBERS))
#: Room at first.
_CORNERS, _POLYGONS = 1 << 15, 1 << 13


class ModePath(NamedTuple):
    """How a polygon's light has come so far.

    Its last node, reflections, the plane it entered by, how many of the reflections were partial ones, its
    share of the light before these, and what they have left of that.
    """

    node: Any
    reflections: Any
    entry: Any
    partial: Any
    share: Any
    weight: Any


class ModePolygons(NamedTuple):
    """A list of polygons, one after the other.

    corners : (c, 2) float64
        Corners of all of them.
    facts : (m, 7) int64
        Of each: where its corners end, status, node, reflections, the planes that it enters and leaves by (-1
        for none), and partial reflections.
    numbers : (m, NUMBERS) float64
        Its `Beam`, its area, share and weight (`ModePath`), and the share of it that leaves here.
    used : (2,) int64
        How many corners and polygons there are.
    """

    corners: Any
    facts: Any
    numbers: Any
    used: Any


class ModeWork(NamedTuple):
    """What a trace works with.

    done, waiting : ModePolygons
        The polygons that are done, and those that wait to be followed, the last one first.
    nodes : (k, 3) int64
        The tree of paths: a node's parent, -1 at the crown, the plane that it met, and the mode in which
        light goes on from there, -1 where it leaves.
    waves : (k, 5) float64
        Of each node its wave vector, its beam's cross-section by that in the view, and the share of the light
        at the eye that has entered the stone.
    used : (1,) int64
        How many nodes there are.
    room : (6,) int64
        What there must be before the next polygon is followed: corners and polygons that are done, corners
        and polygons that wait, nodes, and corners of the table.
    sums : (1,) float64
        Area times share that no polygon of principal light holds, slivers thinner than rounding.
    table, distances, ahead
        As of `gemrender.beam.lists.Work`.
    facet : Facet
        Room for the waves at a facet.
    """

    done: ModePolygons
    waiting: ModePolygons
    nodes: Any
    waves: Any
    used: Any
    room: Any
    sums: Any
    table: Any
    distances: Any
    ahead: Ahead
    facet: Facet


@jit_inner
def add(
    polygons: Any, status: int, path: Any, leaves: int, beam: Any, table: Any, part: int, n: int, size: float,
    passed: float,
) -> None:  # fmt: skip
    """Add a polygon, in part of a table, to a list."""
    used = polygons.used
    end, m = used[0] + n, used[1]
    copy_out(table, part, n, polygons.corners, used[0])
    facts, numbers = polygons.facts[m], polygons.numbers
    facts[0], facts[1], facts[2], facts[3] = end, status, path.node, path.reflections
    facts[4], facts[5], facts[6] = path.entry, leaves, path.partial
    write_beam(beam, numbers, m)
    numbers[m, AREA], numbers[m, SHARE] = size, path.share
    numbers[m, WEIGHT], numbers[m, LEAVING] = path.weight, passed
    used[0], used[1] = end, m + 1


@jit_inner
def add_node(
    work: Any, parent: int, plane: int, mode: int, kx: float, ky: float, kz: float, section: float,
    entering: float,
) -> int:  # fmt: skip
    """Add a node to the tree of paths; return its number."""
    here = int(work.used[0])
    node, waves = work.nodes[here], work.waves[here]
    node[0], node[1], node[2] = parent, plane, mode
    waves[0], waves[1], waves[2], waves[3], waves[4] = kx, ky, kz, section, entering
    work.used[0] = here + 1
    return here


@jit_inner
def has_room(n: int, count: int, walls: int, work: Any) -> bool:
    """Whether there is room for all that may come of a polygon of n corners that meets so many planes."""
    most = n + count + walls + 2  # a cell gains one corner at the most by each cut
    done, waiting, room = work.done, work.waiting, work.room
    room[0], room[1] = done.used[0] + count * (walls + 3) * most, done.used[1] + count * (walls + 3)
    room[2], room[3] = waiting.used[0] + 2 * count * most, waiting.used[1] + 2 * count
    room[4], room[5] = work.used[0] + 3 * count, most
    return bool(
        room[0] <= done.corners.shape[0]
        and room[1] <= done.facts.shape[0]
        and room[2] <= waiting.corners.shape[0]
        and room[3] <= waiting.facts.shape[0]
        and room[4] <= work.nodes.shape[0]
        and room[5] <= work.table.shape[1]
    )


def _empty(corners: int, polygons: int) -> ModePolygons:
    return ModePolygons(
        corners=np.empty((corners, 2)),
        facts=np.empty((polygons, _FACTS), np.int64),
        numbers=np.empty((polygons, NUMBERS)),
        used=np.zeros(2, np.int64),
    )


def empty_mode_work(p: int, corners: int) -> ModeWork:
    """Return empty lists for p planes, with room for each of them in both modes, of so many corners."""
    return ModeWork(
        done=_empty(_CORNERS, _POLYGONS),
        waiting=_empty(2 * p * corners + _CORNERS, 2 * p + _POLYGONS),
        nodes=np.empty((2 * p + _POLYGONS, _NODE), np.int64),
        waves=np.empty((2 * p + _POLYGONS, _WAVES)),
        used=np.zeros(1, np.int64),
        room=np.zeros(6, np.int64),
        sums=np.zeros(1),
        table=np.empty((3, corners, 3)),
        distances=np.empty((p, 3)),
        ahead=Ahead(np.empty(p), np.empty((2, p), np.int64), np.empty((p, corners))),
        facet=empty_facet(),
    )


def with_room(work: ModeWork) -> ModeWork:
    """Return the lists, twice as large at least where more is needed."""
    room = work.room

    def grown(array: np.ndarray, k: int) -> np.ndarray:
        if room[k] <= len(array):
            return array
        out = np.empty((max(2 * len(array), int(room[k])), *array.shape[1:]), array.dtype)
        out[: len(array)] = array
        return out

    def longer(polygons: ModePolygons, k: int) -> ModePolygons:
        return polygons._replace(
            corners=grown(polygons.corners, k),
            facts=grown(polygons.facts, k + 1),
            numbers=grown(polygons.numbers, k + 1),
        )

    table, ahead = work.table, work.ahead
    if room[5] > table.shape[1]:
        most = 2 * int(room[5])
        table, ahead = np.empty((3, most, 3)), ahead._replace(at_corners=np.empty((len(ahead.out), most)))
    return work._replace(
        done=longer(work.done, 0),
        waiting=longer(work.waiting, 2),
        nodes=grown(work.nodes, 4),
        waves=grown(work.waves, 4),
        table=table,
        ahead=ahead,
    )

"""The lists of polygons that a trace works on, how compiled functions add to them, and how they grow."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.ahead import Ahead
from gemrender.beam.beams import BEAM, write_beam
from gemrender.beam.clipping import copy_out
from gemrender.beam.compiled import jit_inner

__all__ = [
    "CORNER_BYTES",
    "NODE_BYTES",
    "NO_MEMORY",
    "NO_TIME",
    "OPENS",
    "POLYGON_BYTES",
    "UNACCOUNTED",
    "Path",
    "Polygons",
    "Work",
    "add",
    "empty_work",
    "has_room",
    "with_room",
]


class Path(NamedTuple):
    """How a polygon's light has come so far.

    Its last node, its reflections, the plane it entered by, how many of the reflections were partial ones,
    and the product of their reflectances.
    """

    node: Any
    reflections: Any
    entry: Any
    partial: Any
    weight: Any


class Polygons(NamedTuple):
    """A list of polygons with their paths, one after the other.

    corners : (c, 2) float64 or complex128
        Corners of all of them.
    facts : (m, 7) int64
        Of each: where its corners end, status (EXITED ...), node, reflections, the planes that it enters
        and leaves by (-1 for none), and partial reflections.
    numbers : (m, BEAM + 2) like `corners`
        Its `Beam`, where it left or was last reflected, its area, and its weight.
    used : (2,) int64
        How many corners and polygons there are.
    """

    corners: Any
    facts: Any
    numbers: Any
    used: Any


class Work(NamedTuple):
    """What a trace works with.

    done, waiting : Polygons
        The polygons that are done, and those that wait to be followed, the last one first.
    nodes : (k, 2) int64
        The tree of paths: a node's parent, -1 at the crown, and the plane that it met.
    used : (1,) int64
        How many nodes there are.
    room : (2, 6) int64
        How many corners and polygons that are done, corners and polygons that wait, nodes, and corners of the
        table there is room for, and for how many there must be before the next polygon is followed.
    sums : (4,) float64
        Areas [girdle radius^2]: that no polygon of principal light holds, slivers thinner than rounding; and
        of girdle cells that the limits have made of it, by time and by memory. Where there are derivatives,
        then how often a polygon of no width opens (`clipping.opens`).
    table : (3, m, 3) like the corners
        Polygons that are cut (`clipping`).
    distances : (p, 3) like the corners
        Distance along a beam to a plane, d0 + u d1 + v d2.
    ahead : Ahead
        Room to find the planes ahead of a beam in.
    """

    done: Polygons
    waiting: Polygons
    nodes: Any
    used: Any
    room: Any
    sums: Any
    table: Any
    distances: Any
    ahead: Ahead


#: Room at first; most stones seen from above need no more.
_FIRST_CORNERS, _FIRST_POLYGONS = 1 << 14, 1 << 12
#: What is in `sums`, by place.
UNACCOUNTED, NO_TIME, NO_MEMORY, OPENS = range(4)
#: What the lists hold of each [bytes]: of a node, of a corner, and of a polygon besides.
NODE_BYTES, CORNER_BYTES, POLYGON_BYTES = 16, 16, 8 * (7 + BEAM + 2)


@jit_inner
def add(
    polygons: Any, status: int, path: Any, leaves: int, beam: Any, table: Any, part: int, n: int, size: Any
) -> None:  # fmt: skip
    """Add a polygon, in part of a table, to a list."""
    used = polygons.used
    end, m = used[0] + n, used[1]
    copy_out(table, part, n, polygons.corners, used[0])
    facts = polygons.facts[m]
    facts[0], facts[1], facts[2], facts[3] = end, status, path.node, path.reflections
    facts[4], facts[5], facts[6] = path.entry, leaves, path.partial
    write_beam(beam, polygons.numbers, m)
    polygons.numbers[m, BEAM], polygons.numbers[m, BEAM + 1] = size, path.weight
    used[0], used[1] = end, m + 1


@jit_inner
def has_room(n: int, count: int, walls: int, done: Any, waiting: Any, nodes: Any, room: Any) -> bool:
    """Whether there is room for all that may come of a polygon of n corners; else write how much is needed.

    `done`, `waiting` and `nodes` are how many of each there are.
    """
    most = n + count + walls + 2  # a cell gains one corner at the most by each cut
    needed, enough = room[1], True
    needed[0], needed[1] = done[0] + count * (walls + 3) * most, done[1] + count * (walls + 3)
    needed[2], needed[3] = waiting[0] + count * most, waiting[1] + count
    needed[4], needed[5] = nodes[0] + count, most
    for k in range(6):
        enough = enough and needed[k] <= room[0, k]
    return enough


def _empty_polygons(corners: int, polygons: int, kind: np.dtype) -> Polygons:
    """Return an empty list."""
    return Polygons(
        corners=np.empty((corners, 2), kind),
        facts=np.empty((polygons, 7), np.int64),
        numbers=np.empty((polygons, BEAM + 2), kind),
        used=np.zeros(2, np.int64),
    )


def _with_capacity(work: Work) -> Work:
    """Return lists that know how much room they have."""
    done, waiting = work.done, work.waiting
    work.room[0] = (
        len(done.corners), len(done.facts), len(waiting.corners), len(waiting.facts), len(work.nodes),
        work.table.shape[1],
    )  # fmt: skip
    return work


def empty_work(p: int, more: int, kind: np.dtype) -> Work:
    """Return empty lists for p planes of a type, with room to see each of them, cut by so many lines more."""
    most = p + more
    work = Work(
        done=_empty_polygons(_FIRST_CORNERS, _FIRST_POLYGONS, kind),
        waiting=_empty_polygons(p * most + _FIRST_CORNERS, p + _FIRST_POLYGONS, kind),
        nodes=np.empty((p + _FIRST_POLYGONS, 2), np.int64),
        used=np.zeros(1, np.int64),
        room=np.zeros((2, 6), np.int64),
        sums=np.zeros(4),
        table=np.empty((3, most, 3), kind),
        distances=np.empty((p, 3), kind),
        ahead=Ahead(np.empty(p), np.empty((2, p), np.int64), np.empty((p, most))),
    )
    return _with_capacity(work)


def with_room(work: Work) -> Work:
    """Return the lists, twice as large at least where more is needed."""
    room, needed = work.room

    def grown(array: np.ndarray, k: int) -> np.ndarray:
        if room[k] >= needed[k]:
            return array
        out = np.empty((max(2 * len(array), int(needed[k])), *array.shape[1:]), array.dtype)
        out[: len(array)] = array
        return out

    def longer(polygons: Polygons, k: int) -> Polygons:
        return polygons._replace(
            corners=grown(polygons.corners, k),
            facts=grown(polygons.facts, k + 1),
            numbers=grown(polygons.numbers, k + 1),
        )

    table, ahead = work.table, work.ahead
    if room[5] < needed[5]:
        most = 2 * int(needed[5])
        table = np.empty((3, most, 3), table.dtype)
        ahead = ahead._replace(at_corners=np.empty((len(ahead.at_corners), most)))
    return _with_capacity(
        work._replace(
            done=longer(work.done, 0),
            waiting=longer(work.waiting, 2),
            nodes=grown(work.nodes, 4),
            table=table,
            ahead=ahead,
        )
    )

"""The lists of polygons that a trace works on, how compiled functions add to them, and how they grow."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.ahead import Ahead
from gemrender.beam.beams import BEAM, write_beam
from gemrender.beam.clipping import copy_out
from gemrender.beam.compiled import jit_inner

__all__ = [
    "CORNERS",
    "CORNER_BYTES",
    "DONE",
    "NODES",
    "NODE_BYTES",
    "NO_MEMORY",
    "NO_TIME",
    "POLYGON_BYTES",
    "STACK",
    "TABLE",
    "UNACCOUNTED",
    "WAITING",
    "Path",
    "Polygons",
    "Work",
    "empty_polygons",
    "has_room",
    "push",
    "store",
    "with_room",
]


class Path(NamedTuple):
    """How a polygon's light has come so far: its last node, its reflections, and the plane it entered by."""

    node: int
    reflections: int
    entry: int


class Polygons(NamedTuple):
    """A list of polygons with their paths, one after the other.

    corners : (c, 2) float64 or complex128
        Corners of all of them.
    ends : (m,) int64
        Where the corners of each end.
    facts : (m, 5) int64
        Status (EXITED ...), node, reflections, and the planes that it enters and leaves by (-1 for none).
    areas : (m,) like `corners`
        Area of each.
    beams : (m, BEAM) like `corners`
        The `Beam` of each, where it left or was last reflected.
    """

    corners: Any
    ends: Any
    facts: Any
    areas: Any
    beams: Any


class Work(NamedTuple):
    """What a trace works with.

    done, waiting : Polygons
        The polygons that are done, and those that wait to be followed, the last one first; of the latter
        `ends` are numbers of corners.
    nodes : (k, 2) int64
        The tree of paths: a node's parent, -1 at the crown, and the plane that it met.
    used : (5,) int64
        How many there are: corners and polygons that are done, corners and polygons that wait, and nodes.
    needed : (6,) int64
        For how many there must be room before the next one is followed; last for corners in the table.
    sums : (3,) float64
        Areas [girdle radius^2]: that no polygon holds, slivers thinner than rounding; and of girdle cells
        that the limits have made, by time and by memory.
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
    needed: Any
    sums: Any
    table: Any
    distances: Any
    ahead: Ahead


#: What is in `used` and `needed`, and in `sums`, by place.
CORNERS, DONE, STACK, WAITING, NODES, TABLE = range(6)
UNACCOUNTED, NO_TIME, NO_MEMORY = range(3)
#: What the lists hold of each [bytes]: of a node, of a corner, and of a polygon besides.
NODE_BYTES, CORNER_BYTES, POLYGON_BYTES = 16, 16, 8 * (1 + 5 + 1 + BEAM)


@jit_inner
def store(
    status: int, path: Any, leaves: int, beam: Any, part: int, n: int, size: Any, work: Any
) -> None:  # fmt: skip
    """Write a polygon into the list of those that are done."""
    done, used = work.done, work.used
    first, m = used[CORNERS], used[DONE]
    copy_out(work.table, part, n, done.corners, first)
    facts = done.facts[m]
    facts[0], facts[1], facts[2], facts[3], facts[4] = status, path.node, path.reflections, path.entry, leaves
    done.ends[m], done.areas[m] = first + n, size
    write_beam(beam, done.beams, m)
    used[CORNERS], used[DONE] = first + n, m + 1


@jit_inner
def push(path: Any, beam: Any, part: int, n: int, size: Any, work: Any) -> None:
    """Let a polygon wait."""
    waiting, used = work.waiting, work.used
    first, m = used[STACK], used[WAITING]
    copy_out(work.table, part, n, waiting.corners, first)
    facts = waiting.facts[m]
    facts[1], facts[2], facts[3] = path.node, path.reflections, path.entry
    waiting.ends[m], waiting.areas[m] = n, size
    write_beam(beam, waiting.beams, m)
    used[STACK], used[WAITING] = first + n, m + 1


@jit_inner
def has_room(n: int, count: int, walls: int, work: Any) -> bool:
    """Whether the lists have room for all that may come of a polygon of n corners; else say how much."""
    used, needed, done, waiting = work.used, work.needed, work.done, work.waiting
    most = n + count + walls + 2  # a cell gains one corner at the most by each cut
    needed[CORNERS] = used[CORNERS] + count * (walls + 2) * most
    needed[DONE] = used[DONE] + count * (walls + 2)
    needed[STACK] = used[STACK] + count * most
    needed[WAITING] = used[WAITING] + count
    needed[NODES] = used[NODES] + count
    needed[TABLE] = most
    there = (
        done.corners.shape[0], done.ends.shape[0], waiting.corners.shape[0], waiting.ends.shape[0],
        work.nodes.shape[0], work.table.shape[1],
    )  # fmt: skip
    enough = True
    for k in range(len(there)):
        enough = enough and needed[k] <= there[k]
    return enough


def empty_polygons(corners: int, polygons: int, kind: np.dtype) -> Polygons:
    """Return an empty list."""
    return Polygons(
        corners=np.empty((corners, 2), kind),
        ends=np.empty(polygons, np.int64),
        facts=np.empty((polygons, 5), np.int64),
        areas=np.empty(polygons, kind),
        beams=np.empty((polygons, BEAM), kind),
    )


def _grown(array: np.ndarray, used: int, needed: int) -> np.ndarray:
    """Return an array with room for what is needed, twice as much as before at least."""
    if len(array) >= needed:
        return array
    out = np.empty((max(2 * len(array), needed), *array.shape[1:]), array.dtype)
    out[:used] = array[:used]
    return out


def with_room(work: Work) -> Work:
    """Return the lists, larger where more is needed."""
    used, needed = work.used, work.needed

    def grown(polygons: Polygons, corners: int, number: int) -> Polygons:
        lists = [_grown(list_, used[number], needed[number]) for list_ in polygons[1:]]
        return Polygons(_grown(polygons.corners, used[corners], needed[corners]), *lists)

    table, ahead = work.table, work.ahead
    if needed[TABLE] > table.shape[1]:
        most = 2 * int(needed[TABLE])
        table = np.empty((3, most, 3), table.dtype)
        ahead = ahead._replace(at_corners=np.empty((len(ahead.least), most)))
    return work._replace(
        done=grown(work.done, CORNERS, DONE),
        waiting=grown(work.waiting, STACK, WAITING),
        nodes=_grown(work.nodes, used[NODES], needed[NODES]),
        table=table,
        ahead=ahead,
    )

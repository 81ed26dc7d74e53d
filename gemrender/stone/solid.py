"""The two kinds of solid that a stone can be: half-spaces, perhaps with a cylinder, or a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gemrender.stone.polyhedron import Polyhedron, intersect

__all__ = ["ROUND_PIECES", "ConvexSolid", "MeshSolid", "convex_solid", "with_chords"]

#: Level facets that stand for a round girdle where a polyhedron is needed. Their sagitta,
#: (pi / 1024)^2 / 2 = 4.7e-6 girdle radii, is the largest distance from the true wall.
ROUND_PIECES = 1024
#: Facets of a smaller area are none [share of the square of the solid's size]: what rounding in a file's
#: digits leaves of planes that others cut away.
LEAST_AREA = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class ConvexSolid:
    """A convex solid: what lies inside all its planes and, where the girdle is round, its cylinder.

    Parameters
    ----------
    planes : (p, 4) float64
        Outward unit normals and offsets: n . x <= offset inside.
    facet : (p,) int64
        Facet that each plane belongs to. One that is not flat has several planes.
    is_round : bool
        Whether the girdle is the upright cylinder of radius 1 about the z axis. It then is the last facet.
    """

    planes: np.ndarray
    facet: np.ndarray
    is_round: bool = False

    def __post_init__(self) -> None:
        for name, kind in (("planes", np.float64), ("facet", np.int64)):
            array = np.array(getattr(self, name), dtype=kind)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_facets(self) -> int:
        """Number of facets."""
        return int(self.facet.max()) + 1 + self.is_round

    @cached_property
    def polyhedron(self) -> Polyhedron:
        """The solid as a polyhedron; a round girdle is cut into `ROUND_PIECES` level facets inside it."""
        return self.cut(ROUND_PIECES)

    def cut(self, pieces: int) -> Polyhedron:
        """Return the solid as a polyhedron whose round girdle has so many level facets, after its planes."""
        return intersect(with_chords(self.planes, pieces) if self.is_round else self.planes)

    @cached_property
    def vertices(self) -> np.ndarray:
        """(v, 3) float64: corners; of a round girdle many."""
        return self.polyhedron.vertices

    @cached_property
    def areas(self) -> np.ndarray:
        """(n_facets,) float64: area of each facet."""
        facet = np.full(len(self.polyhedron.planes), self.n_facets - 1)
        facet[: len(self.facet)] = self.facet
        areas = np.bincount(facet, self.polyhedron.areas, self.n_facets)
        areas.setflags(write=False)
        return areas

    @cached_property
    def volume(self) -> float:
        """Volume, right to 1e-9; what chords lack falls as the square of their number (Richardson)."""
        if not self.is_round:
            return self.polyhedron.volume
        return self.polyhedron.volume + (self.polyhedron.volume - self.cut(ROUND_PIECES // 2).volume) / 3.0

    def transformed(self, matrix: np.ndarray) -> ConvexSolid:
        """Return the solid turned or mirrored by an orthogonal matrix (3, 3) about the origin."""
        planes = np.column_stack([self.planes[:, :3] @ matrix.T, self.planes[:, 3]])
        return ConvexSolid(planes=planes, facet=self.facet, is_round=self.is_round)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshSolid:
    """A closed mesh that need not be convex.

    Parameters
    ----------
    vertices : (v, 3) float64
        Positions.
    triangles : (f, 3) int64
        Vertices of each triangle, anticlockwise seen from outside.
    facet : (f,) int64
        Facet that each triangle belongs to.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    facet: np.ndarray

    is_round = False

    def __post_init__(self) -> None:
        for name, kind in (("vertices", np.float64), ("triangles", np.int64), ("facet", np.int64)):
            array = np.array(getattr(self, name), dtype=kind)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_facets(self) -> int:
        """Number of facets."""
        return int(self.facet.max()) + 1

    @cached_property
    def _crosses(self) -> np.ndarray:
        a, b, c = self.vertices[self.triangles].transpose(1, 0, 2)
        return np.asarray(np.cross(b - a, c - a))

    @cached_property
    def planes(self) -> np.ndarray:
        """(f, 4) float64: outward unit normal and offset of each triangle; of a flat facet they are equal."""
        from gemrender.stone.planes import flat_facets

        return flat_facets(self.vertices, self.triangles, self.facet)

    @property
    def triangle_areas(self) -> np.ndarray:
        """(f,) float64: area of each triangle."""
        return np.asarray(0.5 * np.linalg.norm(self._crosses, axis=1))

    @property
    def areas(self) -> np.ndarray:
        """(n_facets,) float64: area of each facet."""
        return np.bincount(self.facet, self.triangle_areas, self.n_facets)

    @property
    def volume(self) -> float:
        """Volume, by Gauss's theorem."""
        return float((self._crosses * self.vertices[self.triangles[:, 0]]).sum()) / 6.0

    def transformed(self, matrix: np.ndarray) -> MeshSolid:
        """Return the solid turned by an orthogonal matrix (3, 3) about the origin."""
        return MeshSolid(vertices=self.vertices @ matrix.T, triangles=self.triangles, facet=self.facet)


def with_chords(planes: np.ndarray, pieces: int) -> np.ndarray:
    """Return planes (p, 4) with so many more, upright through even chords of the circle of radius 1.

    Their ends lie at whole multiples of 360 / `pieces` degrees.
    """
    azimuth = (np.arange(pieces) + 0.5) * (2 * np.pi / pieces)
    chords = np.column_stack(
        [np.cos(azimuth), np.sin(azimuth), np.zeros(pieces), np.full(pieces, np.cos(np.pi / pieces))]
    )
    return np.concatenate([planes, chords])


def convex_solid(planes: np.ndarray, facet: np.ndarray) -> tuple[ConvexSolid, np.ndarray]:
    """Return the solid inside planes, without those that others cut away.

    Parameters
    ----------
    planes : (p, 4) float64
        Outward unit normals and offsets.
    facet : (p,) int64
        Facet that each belongs to.

    Returns
    -------
    (ConvexSolid, (k,) int64)
        The solid, its facets numbered anew, and the number that each had before.

    Raises
    ------
    InputError
        The planes do not close.
    """
    planes, facet = np.asarray(planes, dtype=np.float64), np.asarray(facet)
    while True:
        body = intersect(planes)
        size = float(np.ptp(body.vertices, axis=0).max())
        bounds = body.areas > LEAST_AREA * size * size
        if bounds.all():
            break
        # What is cut away a little more of is seen only without it.
        planes, facet = planes[bounds], facet[bounds]
    before, numbers = np.unique(facet, return_inverse=True)
    solid = ConvexSolid(planes=planes, facet=numbers)
    solid.__dict__["polyhedron"] = body  # as its cached property would find it once more
    return solid, before

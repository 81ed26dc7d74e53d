"""The stone: a solid with named facets, a material, and where it came from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, TypeVar

import numpy as np

from gemrender.errors import InputError
from gemrender.shown import Shown, plots
from gemrender.stone.facets import LEVEL, Facet
from gemrender.stone.frame import lower_edge
from gemrender.stone.orientation import Orientation
from gemrender.stone.planes import mean_planes
from gemrender.stone.solid import ConvexSolid, MeshSolid
from gemrender.stone.symmetry import NONE, Symmetry, find_symmetry

__all__ = ["Cut", "Stone"]

#: Heights of a girdle's lower edge that differ by no more are level [stone's unit]: rounding in files.
_LEVEL_EDGE = 1e-6
#: A facet of a smaller area is cut away by others, but for rounding [stone's unit^2].
_NO_AREA = 1e-12
#: A facet whose planes' areas, added as vectors, make less of their sum is a wall all round: not one plane.
_WALL = 0.5


class Cut(Protocol):
    """How a person describes a stone: a family with its parameters, or a faceter's design."""

    def stone(self, **facts: Any) -> Stone:
        """Make the stone; `facts` are fields of `Stone` such as its name."""
        ...


_T = TypeVar("_T", bound="Stone")


@dataclass(frozen=True, kw_only=True, eq=False)
class Stone(Shown):
    """A solid with named facets.

    Lengths are in the stone's own unit, in its frame: z along the axis, table up. Round brilliants: the
    girdle radius, with z = 0 at the girdle's lower edge (`docs/model.md`). Others: half the longer side of
    the outline's bounding box, centred on it, with z = 0 at the lowest point of the girdle's lower edge.

    Parameters
    ----------
    solid : ConvexSolid or MeshSolid
        Its shape.
    facets : tuple of Facet
        All facets by their numbers; a round girdle is the last.
    name : str
        What to call the stone in tables and files.
    cut : Cut or None
        What it was made from, such as `RoundBrilliant`; None for a measured stone or a mesh.
    material : str, float or None
        Name of a gem material or its refractive index, as the stone file says; None is diamond.
    source : str or None
        Where the stone came from, for error messages.
    description : str or None
        How the cut was given: "proportions", "angles" or "report", as the sections of stone files are called.
    assumed : tuple of str
        What was assumed of the stone or inferred since its description left it out, such as
        "star 50 (not in the report)".
    notes : tuple of str
        What was mended when it was read.
    labelled_vertices : (57, 3) float64 or None
        Of a round brilliant its vertices in their order.
    known_symmetry : Symmetry or None
        Its symmetry, where the cut knows it.
    size_mm : float or None
        Two of its units: the longer side of the outline, or the diameter of a round one [mm], where it is
        known. It stays as it is when the stone is turned.
    crystal : Orientation or None
        How its crystal lies in it, of use to birefringent materials; None is with the optic axis along the
        stone's axis. It turns with the stone.

    Raises
    ------
    InputError
        Facets and solid do not fit.
    """

    solid: ConvexSolid | MeshSolid = field(repr=False)
    facets: tuple[Facet, ...] = field(repr=False)
    name: str = "stone"
    cut: Cut | None = None
    material: str | float | None = None
    source: str | None = None
    description: str | None = None
    assumed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    labelled_vertices: np.ndarray | None = field(default=None, repr=False)
    known_symmetry: Symmetry | None = field(default=None, repr=False)
    size_mm: float | None = None
    crystal: Orientation | None = None

    def __post_init__(self) -> None:
        if len(self.facets) != self.solid.n_facets:
            raise InputError(f"has {self.solid.n_facets} facets, and {len(self.facets)} names for them")
        if self.labelled_vertices is not None:
            vertices = np.array(self.labelled_vertices, dtype=np.float64)
            vertices.setflags(write=False)
            object.__setattr__(self, "labelled_vertices", vertices)

    @classmethod
    def from_proportions(cls, proportions: Cut, **facts: Any) -> Stone:
        """Make the stone of proportions such as `RoundBrilliant`; `facts` are fields such as its name."""
        return proportions.stone(**facts)

    # ---- Facets ----

    @property
    def facet_names(self) -> tuple[str, ...]:
        """Name of each facet."""
        return tuple(facet.name for facet in self.facets)

    @property
    def facet_kinds(self) -> tuple[str, ...]:
        """Kind of each facet."""
        return tuple(facet.kind for facet in self.facets)

    @property
    def facet_sides(self) -> tuple[str, ...]:
        """Side of each facet: "crown", "girdle" or "pavilion"."""
        return tuple(facet.side for facet in self.facets)

    @cached_property
    def _mean_planes(self) -> np.ndarray:
        """Plane of each facet that has one, (m, 4); the mean over its area where it is not flat."""
        solid = self.solid
        if isinstance(solid, MeshSolid):
            planes = mean_planes(solid.vertices, solid.triangles, solid.facet)
            crosses = solid.planes[:, :3] * solid.triangle_areas[:, None]
            last = np.linalg.norm(crosses[solid.facet == len(planes) - 1].sum(axis=0))
            return planes[:-1] if last < _WALL * solid.areas[-1] else planes
        count = len(self.facets) - solid.is_round
        if len(solid.planes) == count:
            return solid.planes
        weights = solid.polyhedron.areas[: len(solid.planes)]
        # Of a facet that others cut away all planes count alike.
        weights = np.where(np.bincount(solid.facet, weights)[solid.facet] > _NO_AREA, weights, 1.0)
        total = np.column_stack([np.bincount(solid.facet, solid.planes[:, k] * weights) for k in range(4)])
        length, weight = np.linalg.norm(total[:, :3], axis=1), np.bincount(solid.facet, weights)
        if length[-1] < _WALL * weight[-1]:
            total, length, weight = total[:-1], length[:-1], weight[:-1]
        return np.column_stack([total[:, :3] / length[:, None], total[:, 3] / weight])

    @property
    def facet_normals(self) -> np.ndarray:
        """(m, 3) float64: outward unit normals of plane facets; a girdle that is not plane comes after."""
        return self._mean_planes[:, :3]

    @property
    def facet_offsets(self) -> np.ndarray:
        """(m,) float64: their offsets: a point p of the facet has normal . p = offset."""
        return self._mean_planes[:, 3]

    # ---- Shape ----

    @property
    def is_convex(self) -> bool:
        """Whether it is convex: half-spaces, which the exact engine traces."""
        return isinstance(self.solid, ConvexSolid)

    @property
    def is_round(self) -> bool:
        """Whether its girdle is a cylinder."""
        return self.solid.is_round

    @property
    def vertices(self) -> np.ndarray:
        """(v, 3) float64: the labelled vertices of a round brilliant, else all corners."""
        return self.solid.vertices if self.labelled_vertices is None else self.labelled_vertices

    @property
    def proportions(self) -> Any:
        """The proportions that it was made from (`RoundBrilliant`), or None."""
        return self.cut if self.labelled_vertices is not None else None

    @cached_property
    def half_width(self) -> float:
        """Largest absolute x or y: half the side of the square that holds the view from above."""
        if self.is_round:
            return 1.0
        return float(np.abs(self.solid.vertices[:, :2]).max())

    @cached_property
    def reach(self) -> float:
        """Radius of a sphere about the origin that holds the stone."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    @cached_property
    def rear_rule(self) -> str:
        """What tells rear light: "position" (z <= 0) where the girdle's lower edge is level, else "facet"."""
        if self.labelled_vertices is not None or isinstance(self.solid, MeshSolid) or self.is_round:
            return "position"
        return "position" if np.ptp(lower_edge(self.solid.polyhedron)) <= _LEVEL_EDGE else "facet"

    @cached_property
    def symmetry(self) -> Symmetry:
        """Rotations and mirror planes; of solids that are not convex none is looked for."""
        if self.known_symmetry is not None:
            return self.known_symmetry
        return find_symmetry(self.solid) if isinstance(self.solid, ConvexSolid) else NONE

    @property
    def crystal_axes(self) -> np.ndarray:
        """(3, 3) float64: rows are the axes of the optic frame in the stone's frame (`Orientation.axes`)."""
        return (self.crystal or Orientation()).array()

    def plot(self, ax: Any = None, *, view: str = "crown") -> Any:
        """Draw a view of the stone: its edges, the outline in a heavier line.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.
        view : {"crown", "pavilion", "side", "oblique"}
            From where.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            Another word.
        """
        return plots().plot_stone(self, ax, view)

    # ---- Others like it ----

    def rotated(self, angle_deg: float) -> Stone:
        """Return the stone turned about the z axis, anticlockwise seen from the table [deg]."""
        cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        labelled = self.labelled_vertices
        return replace(
            self,
            solid=self.solid.transformed(turn),
            cut=None,
            labelled_vertices=None if labelled is None else labelled @ turn.T,
            known_symmetry=None,
            crystal=(self.crystal or Orientation()).turned(turn),
        )

    def tilted(
        self, deviation_deg: float, rng: np.random.Generator, *, depth: float = 0.0, name: str | None = None
    ) -> Stone:
        """Return the stone with every plane facet tilted at random about its middle, and cut deeper or less.

        Level ones stay, and those that others cut away.

        The facet's normal is turned by two angles, about two perpendicular axes in the facet, each normally
        distributed.

        Parameters
        ----------
        deviation_deg : float
            Standard deviation of either angle [deg].
        rng : numpy.random.Generator
            Source of the angles and depths.
        depth : float
            Standard deviation of how far each facet is moved along its normal [stone's unit].

        Raises
        ------
        InputError
            The stone is not convex, or nothing is left of it.
        """
        solid = self.solid
        if not isinstance(solid, ConvexSolid):
            raise InputError("facets can be tilted of convex stones only", source=self.source or self.name)
        normals = self.facet_normals
        u = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(normals, u)
        a, b = np.tan(np.radians(rng.normal(0.0, deviation_deg, (2, len(normals), 1))))
        areas, middles = self._middles
        stays = (np.array(self.facet_sides[: len(normals)]) == "girdle") | (areas <= _NO_AREA)
        turned = np.where(stays[:, None], normals, normals + a * u + b * v)
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        offsets = np.where(stays, self.facet_offsets, np.einsum("ij,ij->i", turned, middles))
        if depth:
            level = np.abs(normals[:, 2]) <= LEVEL  # the girdle is the outline, and stays
            offsets += np.where(level | (areas <= _NO_AREA), 0.0, rng.normal(0.0, depth, len(normals)))
        kept = solid.facet >= len(normals)  # the planes of a girdle that is not one plane
        planes = np.column_stack([turned, offsets])
        return replace(
            self,
            solid=ConvexSolid(
                planes=np.concatenate([planes, solid.planes[kept]]),
                facet=np.concatenate([np.arange(len(normals)), solid.facet[kept]]),
                is_round=solid.is_round,
            ),
            name=name or self.name,
            cut=None,
            labelled_vertices=None,
            known_symmetry=NONE,
        )

    @cached_property
    def _middles(self) -> tuple[np.ndarray, np.ndarray]:
        """The area of each plane facet, (m,), and its middle, (m, 3); of one that is cut away 0."""
        solid = self.solid
        assert isinstance(solid, ConvexSolid)
        body, n = solid.polyhedron, len(solid.planes)
        areas = body.areas[:n]
        moments = np.nan_to_num(body.middles[:n]) * areas[:, None]
        total = np.column_stack([np.bincount(solid.facet, moments[:, k]) for k in range(3)])
        count = len(self.facet_normals)
        whole = np.bincount(solid.facet, areas)[:count]
        return whole, total[:count] / np.where(whole > _NO_AREA, whole, np.inf)[:, None]

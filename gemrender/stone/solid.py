"""The stone: 57 vertices, the planes through them, and the girdle."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gemrender.errors import InputError
from gemrender.stone.checks import check_vertices
from gemrender.stone.girdle import Girdle
from gemrender.stone.proportions import RoundBrilliant
from gemrender.stone.topology import (
    FACET_KINDS,
    FACET_POLYGONS,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    N_TRIANGLES,
    N_VERTICES,
    TRIANGLE_FACET,
    TRIANGLES,
)

__all__ = ["Stone", "facet_planes"]

#: Largest distance of a vertex from its facet's plane that counts as flat [girdle radius]: rounding.
FLAT_TOLERANCE = 1e-12
#: Largest coordinate of a measured stone, and the reciprocal of its smallest radius [any unit]: the squares
#: of what they make are finite.
LARGEST = 1e50
#: Deviation from the paper's frame that is left alone [girdle radius]: rounding in a file's digits.
FRAME_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stone:
    """A round brilliant of 57 vertices, ready to trace.

    Build it by `from_proportions` or `from_vertices`. Lengths are in units of the girdle radius, in the
    paper's frame: z along the stone's axis, z = 0 at the girdle's lower edge, table up.

    Parameters
    ----------
    vertices : (57, 3) float64
        In the order of `topology.VERTEX_LABELS`.
    name : str
        What to call the stone in tables and files.
    proportions : RoundBrilliant or None
        What the stone was made from; None for a measured stone.
    material : str, float or None
        Name of a gem material or its refractive index, as the stone file says; None is diamond.
    source : str or None
        Where the stone came from, for error messages.
    description : str or None
        How the proportions were given: "proportions", "angles" or "report", as the sections of stone files
        are called; None for a measured stone, and for one made in Python.
    assumed : tuple of str
        What was assumed of the stone or inferred since its description left it out, such as
        "star 50 (not in the report)".
    tilted_planes : pair of (57, 3) and (57,) float64, or None
        Outward unit normals and offsets of planes that take the place of the facets: the solid then is what
        lies inside them and the cylinder of radius 1, and `vertices` are those before the tilt. `tilted`
        makes them.

    Attributes
    ----------
    facet_normals : (57, 3) float64
        Outward unit normals of the plane facets; of a facet that is not flat, the mean over its area.
    facet_offsets : (57,) float64
        Plane offsets [girdle radius]: a point p of the facet has normal . p = offset.
    triangle_normals : (78, 3) float64
        Outward unit normals; those of a flat facet's triangles equal the facet's, to the last bit.
    triangle_offsets : (78,) float64
        Plane offsets of the triangles [girdle radius].
    girdle : Girdle
        The wall between the upper and the lower girdle vertices.

    Raises
    ------
    InputError
        The vertices make no round brilliant.
    """

    vertices: np.ndarray
    name: str = "stone"
    proportions: RoundBrilliant | None = None
    material: str | float | None = None
    source: str | None = None
    description: str | None = None
    assumed: tuple[str, ...] = ()
    tilted_planes: tuple[np.ndarray, np.ndarray] | None = field(default=None, repr=False)
    facet_normals: np.ndarray = field(init=False, repr=False)
    facet_offsets: np.ndarray = field(init=False, repr=False)
    triangle_normals: np.ndarray = field(init=False, repr=False)
    triangle_offsets: np.ndarray = field(init=False, repr=False)
    girdle: Girdle = field(init=False, repr=False)

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64)
        check_vertices(vertices)
        normals, offsets, triangle_normals, triangle_offsets = _planes(vertices)
        girdle = Girdle(upper=vertices[GIRDLE_UPPER], lower=vertices[GIRDLE_LOWER])
        if self.tilted_planes is not None:
            if not girdle.is_round:
                raise InputError("facets can be tilted of stones with a round outline only")
            normals, offsets = (np.array(part, dtype=np.float64) for part in self.tilted_planes)
            triangle_normals, triangle_offsets = normals[TRIANGLE_FACET], offsets[TRIANGLE_FACET]
        made = {
            "vertices": vertices,
            "facet_normals": normals,
            "facet_offsets": offsets,
            "triangle_normals": triangle_normals,
            "triangle_offsets": triangle_offsets,
        }
        for name, array in made.items():
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "girdle", girdle)

    @classmethod
    def from_proportions(
        cls,
        proportions: RoundBrilliant,
        *,
        name: str = "stone",
        material: str | float | None = None,
        source: str | None = None,
        description: str | None = None,
        assumed: tuple[str, ...] = (),
    ) -> Stone:
        """Build the perfectly symmetric stone of these proportions."""
        return cls(
            vertices=proportions.vertices(),
            name=name,
            proportions=proportions,
            material=material,
            source=source,
            description=description,
            assumed=assumed,
        )

    @classmethod
    def from_vertices(
        cls,
        vertices: np.ndarray,
        *,
        name: str = "stone",
        material: str | float | None = None,
        source: str | None = None,
    ) -> Stone:
        """Build a measured stone from its 57 vertices, in any unit of length and with any origin.

        The z axis must be the stone's axis, table up. The vertices are moved and scaled to the paper's
        frame: girdle vertices centred on the axis with mean radius 1, mean height of the girdle's lower
        vertices 0.

        Parameters
        ----------
        vertices : (57, 3) array_like
            x, y, z in the order of `topology.VERTEX_LABELS`.

        Raises
        ------
        InputError
            Not 57 rows of 3 finite numbers, or no round brilliant in that order.
        """
        return cls(
            vertices=_to_paper_frame(vertices),
            name=name,
            material=material,
            source=source,
        )

    def rotated(self, angle_deg: float) -> Stone:
        """Return the stone turned about its axis, anticlockwise seen from the table [deg]."""
        cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        tilted = self.tilted_planes
        return Stone(
            vertices=self.vertices @ turn.T,
            name=self.name,
            material=self.material,
            source=self.source,
            assumed=self.assumed,
            # A turn about the axis leaves the planes' distances from the origin.
            tilted_planes=None if tilted is None else (tilted[0] @ turn.T, tilted[1]),
        )

    def tilted(self, deviation_deg: float, rng: np.random.Generator, *, name: str | None = None) -> Stone:
        """Return the stone with every facet tilted at random about the middle of its vertices.

        The facet's normal is turned by two angles, about two perpendicular axes in the facet, each normally
        distributed.

        Parameters
        ----------
        deviation_deg : float
            Standard deviation of either angle [deg].
        rng : numpy.random.Generator
            Source of the angles.

        Raises
        ------
        InputError
            The stone's outline is not round.
        """
        middles = np.array([self.vertices[list(polygon)].mean(axis=0) for polygon in FACET_POLYGONS])
        normals = self.facet_normals
        helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
        u = np.cross(normals, helper)
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(normals, u)
        a, b = np.tan(np.radians(rng.normal(0.0, deviation_deg, (2, len(normals), 1))))
        turned = normals + a * u + b * v
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        return Stone(
            vertices=self.vertices,
            name=name or self.name,
            material=self.material,
            source=self.source,
            assumed=self.assumed,
            tilted_planes=(turned, np.einsum("ij,ij->i", turned, middles)),
        )

    @property
    def is_half_spaces(self) -> bool:
        """Whether the solid is made from tilted planes, not from the vertices."""
        return self.tilted_planes is not None

    @property
    def facet_kinds(self) -> tuple[str, ...]:
        """Kind of each of the 58 facets, the girdle last."""
        return FACET_KINDS

    @property
    def triangles(self) -> np.ndarray:
        """(78, 3) int: vertices of each triangle, anticlockwise seen from outside."""
        return TRIANGLES

    @property
    def triangle_facet(self) -> np.ndarray:
        """(78,) int: facet that each triangle belongs to."""
        return TRIANGLE_FACET


def facet_planes(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the outward unit normals (57, 3) and the offsets (57,) of the facets of 57 vertices (57, 3).

    Of a facet that is not flat, the mean over its area. Complex vertices give complex planes: analytic
    functions, for derivatives by the complex step.
    """
    # The normal of the facet's projected area: the sum over its triangles.
    total = np.zeros((len(FACET_POLYGONS), 3), dtype=vertices.dtype)
    np.add.at(total, TRIANGLE_FACET, _crosses(vertices))
    normals = total / _lengths(total)
    offsets = [n @ vertices[list(p)].mean(axis=0) for n, p in zip(normals, FACET_POLYGONS, strict=True)]
    return normals, np.array(offsets)


def _crosses(vertices: np.ndarray) -> np.ndarray:
    """Twice the area of each triangle, along its outward normal, (78, 3)."""
    a, b, c = vertices[TRIANGLES].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (n, 3), (n, 1); analytic, unlike a norm."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1, keepdims=True)))


def _planes(v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Planes of the 57 facets and of the 78 triangles."""
    cross = _crosses(v)
    triangle_normals = cross / _lengths(cross)
    triangle_offsets = np.einsum("ij,ij->i", triangle_normals, v[TRIANGLES].mean(axis=1))
    normals, offsets = facet_planes(v)
    for facet, polygon in enumerate(FACET_POLYGONS):
        if np.abs(v[list(polygon)] @ normals[facet] - offsets[facet]).max() <= FLAT_TOLERANCE:
            of_facet = facet == TRIANGLE_FACET
            triangle_normals[of_facet] = normals[facet]
            triangle_offsets[of_facet] = offsets[facet]
    assert len(triangle_normals) == N_TRIANGLES
    return normals, offsets, triangle_normals, triangle_offsets


def _to_paper_frame(vertices: np.ndarray) -> np.ndarray:
    try:
        v = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"must be {N_VERTICES} rows of three numbers", key="vertices") from error
    if v.shape != (N_VERTICES, 3):
        raise InputError(f"must have shape ({N_VERTICES}, 3), got {v.shape}", key="vertices")
    if not (np.abs(v) <= LARGEST).all():  # false for NaN too
        raise InputError(f"must be finite numbers of at most {LARGEST:g}", key="vertices")
    girdle = np.concatenate([v[GIRDLE_UPPER], v[GIRDLE_LOWER]])
    origin = np.array([*girdle[:, :2].mean(axis=0), v[GIRDLE_LOWER, 2].mean()])
    radius = float(np.hypot(*(girdle - origin)[:, :2].T).mean())
    if radius < 1 / LARGEST:
        raise InputError("all girdle vertices lie on the axis", key="vertices")
    if np.abs(origin).max() <= FRAME_TOLERANCE and abs(radius - 1) <= FRAME_TOLERANCE:
        return v
    return np.asarray((v - origin) / radius)

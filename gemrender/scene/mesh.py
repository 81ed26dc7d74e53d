"""The stone as a `mi.Mesh`: the one file that touches Mitsuba's mesh class (3.10 changes it)."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.scene.convex import PlacedSolid, placed_solid
from gemrender.scene.loading import load_scene
from gemrender.scene.placing import Placed
from gemrender.scene.smooth import PlainMesh
from gemrender.stone import Stone, StoneMesh, tessellate

__all__ = [
    "FACET_ATTRIBUTE",
    "NORMAL_ATTRIBUTES",
    "OFFSET_ATTRIBUTES",
    "carried_planes",
    "mesh_solid",
    "placed_mesh",
    "plain_mesh",
    "stone_mesh",
    "sweep_mesh",
    "tube_mesh",
]

#: Face attribute with the number of the facet.
FACET_ATTRIBUTE = "face_facet"
#: Face attributes with the plane's outward normal and its offset in the mesh's own coordinates, each in
#: double precision as the sum of two singles. On a round girdle the normal is 0 and the offset the radius of
#: its cylinder. Where a mesh is moved they no longer fit, which its vertices tell.
NORMAL_ATTRIBUTES = ("face_normal_high", "face_normal_low")
OFFSET_ATTRIBUTES = ("face_offset_high", "face_offset_low")


def stone_mesh(stone: Stone | StoneMesh, bsdf: dict[str, Any] | None = None, name: str = "stone") -> Any:
    """Build the stone's mesh for the active variant.

    Vertex normals are those of the planes, and radial on a round girdle.

    Parameters
    ----------
    stone : Stone or StoneMesh
        The stone, or its tessellation.
    bsdf : dict, optional
        Surface, as a scene dictionary.
    name : str
        Identifier of the shape.

    Returns
    -------
    mi.Mesh
    """
    mesh = stone if isinstance(stone, StoneMesh) else tessellate(stone)
    return _with_planes(
        _mesh(name, *mesh.split(), bsdf), mesh.face_facet, mesh.face_normals, mesh.face_offsets
    )


def _with_planes(shape: Any, facet: np.ndarray, normals: np.ndarray, offsets: np.ndarray) -> Any:
    """Give a mesh its facets' numbers, and their planes in double precision."""
    shape.add_attribute(FACET_ATTRIBUTE, 1, facet.astype(np.float32))
    for names, values in ((NORMAL_ATTRIBUTES, normals), (OFFSET_ATTRIBUTES, offsets)):
        high = values.astype(np.float32)
        low = (values - high).astype(np.float32)
        for name, part in zip(names, (high, low), strict=True):
            shape.add_attribute(name, part[0].size, part.ravel())
    return shape


def placed_mesh(placed: Placed, bsdf: dict[str, Any] | None = None, name: str = "stone") -> Any:
    """Build the mesh of a stone in its place, for pictures.

    Returns
    -------
    mi.Mesh
    """
    _, normals, faces = placed.mesh.split()
    shape = _mesh(name, placed.split_points(), normals @ placed.rotation.T, faces, bsdf)
    planes = placed.planes()
    return _with_planes(shape, placed.mesh.face_facet, planes[:, :3], planes[:, 3])


def sweep_mesh(
    *,
    half_width: float,
    wall: float,
    bend: float,
    azimuth_deg: float,
    level: float = 0.0,
    bsdf: dict[str, Any] | None = None,
    name: str = "ground",
) -> Any:
    """Build a photographer's sweep: a level plane that bends up to a wall.

    Parameters
    ----------
    half_width, wall, bend : float
        Half of its width and of its height, distance of the wall, and radius of the bend [scene unit].
    azimuth_deg : float
        Where the wall stands [deg].
    level : float
        Height of the plane [scene unit].

    Returns
    -------
    mi.Mesh
    """
    angle = np.linspace(0, np.pi / 2, 49)
    y = np.concatenate([[-half_width], wall - bend + bend * np.sin(angle), [wall]])
    z = level + np.concatenate([[0.0], bend - bend * np.cos(angle), [2 * half_width]])
    ny = np.concatenate([[0.0], -np.sin(angle), [-1.0]])
    nz = np.concatenate([[1.0], np.cos(angle), [0.0]])
    n = len(y)
    positions = np.array([[x, b, c] for x in (-half_width, half_width) for b, c in zip(y, z, strict=True)])
    normals = np.array([[0.0, b, c] for _ in range(2) for b, c in zip(ny, nz, strict=True)])
    k = np.arange(n - 1)
    faces = np.concatenate([np.column_stack([k, k + n, k + n + 1]), np.column_stack([k, k + n + 1, k + 1])])
    turn = np.radians(azimuth_deg - 90)
    to_place = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return _mesh(name, positions @ to_place, normals @ to_place, faces, bsdf)


def plain_mesh(mesh: PlainMesh, *, bsdf: dict[str, Any] | None = None, name: str = "thing") -> Any:
    """Build a mesh that is no stone.

    Returns
    -------
    mi.Mesh
    """
    return _mesh(name, mesh.positions, mesh.normals, mesh.faces, bsdf)


def tube_mesh(
    *, outline: np.ndarray, low: float, high: float, bsdf: dict[str, Any] | None = None, name: str = "tube"
) -> Any:
    """Build an upright tube, open at both ends.

    Parameters
    ----------
    outline : (n, 2) float64
        Corners of a convex polygon, anticlockwise [scene unit].
    low, high : float
        Heights of its ends [scene unit].

    Returns
    -------
    mi.Mesh
    """
    n = len(outline)
    along = np.roll(outline, -1, axis=0) - outline
    across = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    corners = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1).repeat(2, axis=0).reshape(-1, 2)
    heights = np.tile([low, low, high, high], n)
    normals = np.column_stack([np.repeat(across, 4, axis=0), np.zeros(4 * n)])
    first = 4 * np.arange(n)[:, None, None]
    faces = (first + np.array([[0, 1, 3], [0, 3, 2]])).reshape(-1, 3)
    return _mesh(name, np.column_stack([corners, heights]), normals, faces, bsdf)


def carried_planes(shape: Any) -> np.ndarray | None:
    """Return the plane that a mesh carries for each face, (f, 4) float64: normal and offset; None if none."""
    import mitsuba as mi

    names = (*NORMAL_ATTRIBUTES, *OFFSET_ATTRIBUTES)
    if not isinstance(shape, mi.Mesh) or not all(np.all(shape.has_attribute(name)) for name in names):
        return None
    values = mi.traverse(shape)
    high, low, offset_high, offset_low = (np.array(values[name], dtype=np.float64) for name in names)
    return np.column_stack([(high + low).reshape(-1, 3), offset_high + offset_low])


def mesh_solid(shape: Any) -> PlacedSolid | None:
    """Return a stone's solid by the planes that its mesh carries; None if it has none or is not convex."""
    import mitsuba as mi

    planes = carried_planes(shape)
    if planes is None:
        return None
    values = mi.traverse(shape)
    positions = np.array(values["vertex_positions"]).reshape(-1, 3)
    normals = np.array(values["vertex_normals"]) if shape.has_vertex_normals() else np.zeros(positions.size)
    return placed_solid(positions, normals.reshape(-1, 3), np.array(values["faces"]).reshape(-1, 3), planes)


def _mesh(
    name: str, positions: np.ndarray, normals: np.ndarray, faces: np.ndarray, bsdf: dict[str, Any] | None
) -> Any:
    """Build a mesh with one normal a vertex."""
    import mitsuba as mi

    props = mi.Properties()
    if bsdf is not None:
        props["mesh_bsdf"] = load_scene(bsdf)
    shape = mi.Mesh(name, len(positions), len(faces), has_vertex_normals=True, props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mi.Float(positions.astype(np.float32).ravel())
    parameters["vertex_normals"] = mi.Float(normals.astype(np.float32).ravel())
    parameters["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
    parameters.update()
    return shape

"""The stone as a `mi.Mesh`: the one file that touches Mitsuba's mesh class (3.10 changes it)."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.stone import Stone, StoneMesh, tessellate

__all__ = ["FACET_ATTRIBUTE", "NORMAL_ATTRIBUTES", "OFFSET_ATTRIBUTES", "stone_mesh"]

#: Face attribute with the number of the facet (0 to 57, the girdle last).
FACET_ATTRIBUTE = "face_facet"
#: Face attributes with the plane's outward normal and its offset [girdle radius], each in double precision
#: as the sum of two singles. On the girdle the normal is 0 and the offset the radius of its cylinder, or 0
#: where the outline is not round.
NORMAL_ATTRIBUTES = ("face_normal_high", "face_normal_low")
OFFSET_ATTRIBUTES = ("face_offset_high", "face_offset_low")


def stone_mesh(stone: Stone | StoneMesh, bsdf: dict[str, Any] | None = None, name: str = "stone") -> Any:
    """Build the stone's mesh for the active variant.

    Vertex normals are those of the planes, and radial on the girdle. Two stones' meshes have the same
    numbers of vertices and faces.

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
    import mitsuba as mi

    mesh = stone if isinstance(stone, StoneMesh) else tessellate(stone)
    positions, normals, faces = mesh.split()
    props = mi.Properties()
    if bsdf is not None:
        props["mesh_bsdf"] = mi.load_dict(bsdf)
    shape = mi.Mesh(name, len(positions), len(faces), has_vertex_normals=True, props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = mi.Float(positions.astype(np.float32).ravel())
    parameters["vertex_normals"] = mi.Float(normals.astype(np.float32).ravel())
    parameters["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
    parameters.update()
    shape.add_attribute(FACET_ATTRIBUTE, 1, mesh.face_facet.astype(np.float32))
    for names, values in ((NORMAL_ATTRIBUTES, mesh.face_normals), (OFFSET_ATTRIBUTES, mesh.face_offsets)):
        high = values.astype(np.float32)
        low = (values - high).astype(np.float32)
        for name, part in zip(names, (high, low), strict=True):
            shape.add_attribute(name, part[0].size, part.ravel())
    return shape

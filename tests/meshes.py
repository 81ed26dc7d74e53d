"""Small meshes of which everything is known: boxes, joined and split in the ways that files have them."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

#: Faces of a box with the corners of `box`, anticlockwise seen from outside.
BOX_FACES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip
#: Pairs of points and triangles whose distances are found together.
_PAIRS = 20_000


def box(half=(1, 1, 1), centre=(0, 0, 0), rotation=None):
    """Corners (8, 3) and faces (12, 3) of a box."""
    corners = np.array(list(product((-1, 1), repeat=3)), dtype=float) * half
    return corners @ (np.eye(3) if rotation is None else rotation).T + centre, BOX_FACES


def obj(path, mesh):
    """Write a mesh as an OBJ file; return its path."""
    positions, faces = mesh
    lines = [f"v {x} {y} {z}" for x, y, z in positions] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    Path(path).write_text("\n".join(lines) + "\n")
    return str(path)


def distances(points, triangles):
    """Distance of points (k, 3) from the nearest of triangles (n, 3, 3), by trimesh, (k,)."""
    from trimesh.triangles import closest_point

    n, least = len(triangles), []
    for some in np.array_split(points, 1 + len(points) * n // _PAIRS):
        at = closest_point(np.tile(triangles, (len(some), 1, 1)), np.repeat(some, n, axis=0))
        least.append(np.linalg.norm(at.reshape(-1, n, 3) - some[:, None], axis=2).min(axis=1))
    return np.concatenate(least)


def soup(positions, faces):
    """Each face with corners of its own."""
    return positions[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def together(*meshes):
    """Several meshes as one."""
    positions, faces, first = [], [], 0
    for p, f in meshes:
        positions.append(p)
        faces.append(f + first)
        first += len(p)
    return np.concatenate(positions), np.concatenate(faces)


def turned(mesh, *numbers):
    """A mesh with some faces wound the other way, by default all."""
    positions, faces = mesh
    faces = faces.copy()
    rows = list(numbers) or slice(None)
    faces[rows] = faces[rows][:, ::-1]
    return positions, faces


def seamed_box():
    """The box of `box` in three: a half, and two quarters that meet at corners on the half's edges."""
    half, low, high = (
        box((0.5, 1, z), (x, 0, c)) for x, z, c in ((-0.5, 1, 0), (0.5, 0.5, -0.5), (0.5, 0.5, 0.5))
    )
    parts = ((half, (2, 3)), (low, (0, 1, 10, 11)), (high, (0, 1, 8, 9)))
    return together(*((p, np.delete(f, inner, axis=0)) for (p, f), inner in parts))


def ball(n=48):
    """A sphere of 2 n^2 - 2 n triangles that share their corners."""
    polar, turn = np.linspace(0, np.pi, n + 1)[1:-1], 2 * np.pi * np.arange(2 * n) / (2 * n)
    ring = np.stack(
        [
            np.outer(np.sin(polar), np.cos(turn)),
            np.outer(np.sin(polar), np.sin(turn)),
            np.outer(np.cos(polar), np.ones(2 * n)),
        ],
        axis=2,
    )
    positions = np.concatenate([ring.reshape(-1, 3), [(0, 0, 1), (0, 0, -1)]])
    k = np.arange(2 * n)
    after, last, top = (k + 1) % (2 * n), 2 * n * (n - 2), 2 * n * (n - 1)
    faces = [np.stack([np.full(2 * n, top), k, after], axis=1)]
    for first in range(0, last, 2 * n):
        a, b, c, d = first + k, first + 2 * n + k, first + 2 * n + after, first + after
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    faces.append(np.stack([last + k, np.full(2 * n, top + 1), last + after], axis=1))
    return positions, np.concatenate(faces)


def write_ply(path, mesh, normals=None):
    """Write a mesh as an ASCII PLY file."""
    positions, faces = mesh
    names = ["x", "y", "z", *(["nx", "ny", "nz"] if normals is not None else [])]
    rows = positions if normals is None else np.hstack([positions, normals])
    head = ["ply", "format ascii 1.0", f"element vertex {len(positions)}"]
    head += [f"property float {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines = [" ".join(f"{x:.9g}" for x in row) for row in rows] + [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join([*head, *lines]) + "\n")
    return path

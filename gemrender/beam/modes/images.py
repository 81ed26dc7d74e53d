"""The two images that a birefringent stone shows through one sequence of facets, compiled.

Light that enters in one mode and stays in it at every facet makes an image by itself: ordinary (or fast)
light one, extraordinary (or slow) light the other. Here both are followed by the same facets, whichever path
a polygon or a ray has taken through them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, jit_inner
from gemrender.beam.modes.lists import ModePolygons, ModeWork
from gemrender.beam.modes.shares import empty_facet, into_air, meet, wave_vector_of, write_entering
from gemrender.beam.modes.waves import BACK
from gemrender.optics.fresnel import LEAST_TOTAL

__all__ = ["angle_of_images", "image_angles", "images_of_nodes", "reflect_images", "write_first_images"]


@jit_inner
def write_first_images(kx: float, ky: float, kz: float, facet: Any, images: Any) -> None:
    """Write the wave vectors of both images, (2, 3), where light of a wave vector has entered by a facet."""
    for mode in range(2):
        images[mode, 0], images[mode, 1], images[mode, 2] = wave_vector_of(BACK + mode, kx, ky, kz, facet)


@jit_inner
def reflect_images(crystal: Any, nx: float, ny: float, nz: float, facet: Any, images: Any) -> None:
    """Reflect both images at a facet, each in its mode; NaN where its wave does not go on."""
    for mode in range(2):
        kx, ky, kz = images[mode, 0], images[mode, 1], images[mode, 2]
        if math.isnan(kx):
            continue
        meet(crystal, nx, ny, nz, kx, ky, kz, mode, facet)
        if facet.waves.flux[BACK + mode] == 0.0:
            images[mode, 0] = math.nan
            continue
        images[mode, 0], images[mode, 1], images[mode, 2] = wave_vector_of(BACK + mode, kx, ky, kz, facet)


@jit
def angle_of_images(nx: float, ny: float, nz: float, images: Any) -> float:
    """Return the angle between both images where they leave by a facet [deg]; NaN if one does not."""
    for mode in range(2):
        kx, ky, kz = images[mode, 0], images[mode, 1], images[mode, 2]
        along = kx * nx + ky * ny + kz * nz
        if not kx * kx + ky * ky + kz * kz - along * along < LEAST_TOTAL:
            return math.nan
    ax, ay, az, _ = into_air(nx, ny, nz, images[0, 0], images[0, 1], images[0, 2])
    bx, by, bz, _ = into_air(nx, ny, nz, images[1, 0], images[1, 1], images[1, 2])
    square = (ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2
    return 2.0 * math.degrees(math.asin(min(0.5 * math.sqrt(square), 1.0)))


@jit
def _write_images(crystal: Any, planes: Any, basis: Any, nodes: Any, facet: Any, images: Any) -> None:
    dx, dy, dz = -basis[2, 0], -basis[2, 1], -basis[2, 2]
    for i in range(nodes.shape[0]):
        parent, plane = nodes[i, 0], nodes[i, 1]
        nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
        if parent < 0:
            write_entering(crystal, nx, ny, nz, dx, dy, dz, facet)
            write_first_images(dx, dy, dz, facet, images[i])
            continue
        for mode in range(2):
            for a in range(3):
                images[i, mode, a] = images[parent, mode, a]
        if nodes[i, 2] >= 0:  # where light leaves they stay what comes there
            reflect_images(crystal, nx, ny, nz, facet, images[i])


@jit
def _write_angles(planes: Any, facts: Any, images: Any, out: Any) -> None:
    for i in range(out.shape[0]):
        plane = facts[i, 5]
        if plane >= 0:
            out[i] = angle_of_images(
                planes[plane, 0], planes[plane, 1], planes[plane, 2], images[facts[i, 2]]
            )


def images_of_nodes(work: ModeWork, crystal: Any, planes: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return the wave vectors of both images behind each node of a tree of paths, (k, 2, 3).

    NaN in the first place where an image does not go so far. Where light leaves they are what comes there.

    Parameters
    ----------
    work : ModeWork
        A trace.
    crystal, planes, basis
        As it was traced.
    """
    nodes = work.nodes[: work.used[0]]
    images = np.zeros((len(nodes), 2, 3))
    _write_images(crystal, planes, basis, nodes, empty_facet(), images)
    return images


def image_angles(polygons: ModePolygons, planes: np.ndarray, images: np.ndarray) -> np.ndarray:
    """Return the angle between both images of each polygon [deg], (n,); NaN where there are not both."""
    n = int(polygons.used[1])
    out = np.full(n, np.nan)
    _write_angles(planes, polygons.facts[:n], images, out)
    return out

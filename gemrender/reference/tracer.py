"""The paper's tracer in float64, step by step: the truth that the Mitsuba engine is held against.

Sections and equations are those of Inoue's paper, restated in `docs/model.md`. One correction: equations (2)
and (4) are misprinted; Snell's law is used as `docs/model.md`, section 4, states it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.observation import (
    LIGHT_LEVEL,
    MAP_TYPES,
    PATH_CODE_FACTOR,
    PATH_CODE_MASK,
    Model,
    Observation,
    RayStatus,
    View,
)
from gemrender.optics.fresnel import is_totally_reflected, transmittance
from gemrender.processors import usable_processors
from gemrender.reference.surfaces import Surfaces, surfaces_of
from gemrender.stone import Stone
from gemrender.stone.facets import LEVEL

__all__ = ["BLOCK", "START_DISTANCE", "RayRecord", "into_air", "into_stone", "observe", "trace"]

#: Rays traced at a time: many, because the last few of each block are reflected hundreds of times.
BLOCK = 1 << 16

#: Distance from the origin at which rays begin, outside every stone [girdle radius].
START_DISTANCE = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RayRecord:
    """What became of n rays; see `Observation` for the meaning of each.

    Attributes
    ----------
    status, reflections, entry_facet, exit_facet, path_code : (n,) int64
    primary_intensity, rear_mask, coverage : (n,) float64
    exit_point, exit_direction : (n, 3) float64
    """

    primary_intensity: np.ndarray
    rear_mask: np.ndarray
    coverage: np.ndarray
    status: np.ndarray
    reflections: np.ndarray
    exit_point: np.ndarray
    exit_direction: np.ndarray
    entry_facet: np.ndarray
    exit_facet: np.ndarray
    path_code: np.ndarray


#: Called at each surface with the rays' numbers (m,), the points (m, 3), facets (m,) and normals (m, 3), and
#: the rays' directions (m, 3) before and after.
OnSurface = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], None]


def trace(
    stone: Stone | Surfaces,
    origin: np.ndarray,
    direction: np.ndarray,
    model: Model | None = None,
    *,
    on_surface: OnSurface | None = None,
) -> RayRecord:
    """Follow rays from the eye back into the stone until they leave (the paper's sections 2.1 and 2.2).

    Parameters
    ----------
    stone : Stone or Surfaces
        The stone, or its surfaces where many calls share them.
    origin : (n, 3) float64
        Points outside the stone [girdle radius].
    direction : (n, 3) float64
        Unit directions from the eye.
    model : Model, optional
        The optical model; by default the paper's.
    on_surface : callable, optional
        Told of every surface that a ray meets, for drawing paths.
    """
    surfaces = surfaces_of(stone) if isinstance(stone, Stone) else stone
    model = model or Model()
    n = len(origin)
    record = RayRecord(
        primary_intensity=np.zeros(n),
        rear_mask=np.zeros(n),
        coverage=np.zeros(n),
        status=np.full(n, RayStatus.MISSED),
        reflections=np.zeros(n, dtype=np.int64),
        exit_point=np.zeros((n, 3)),
        exit_direction=np.zeros((n, 3)),
        entry_facet=np.full(n, -1),
        exit_facet=np.full(n, -1),
        path_code=np.zeros(n, dtype=np.int64),
    )

    # Section 2.1, step 1: the ray meets the stone and is refracted into it.
    hit = surfaces.nearest(origin, direction, inside=False)
    ray = np.flatnonzero(hit.facet >= 0)
    record.coverage[ray] = 1.0
    record.entry_facet[ray] = hit.facet[ray]
    record.path_code[ray] = hit.facet[ray] + 1
    normal, o, d = hit.normal[ray], origin[ray], direction[ray]
    cos_air = -np.einsum("ij,ij->i", d, normal)
    o = o + hit.distance[ray, None] * d
    before, d = d, into_stone(d, normal, model.index)
    if on_surface is not None:
        on_surface(ray, o, hit.facet[ray], normal, before, d)
    cos_stone = -np.einsum("ij,ij->i", d, normal)
    leaving = _crossing_factor(cos_air, cos_stone, model, towards_eye=True)

    # Steps 2 to 5: from surface to surface until it leaves.
    for _ in range(model.max_reflections + 1):
        if not ray.size:
            break
        hit = surfaces.nearest(o, d, inside=True)
        found = hit.facet >= 0
        record.status[ray[~found]] = RayStatus.LOST
        ray, o, d, leaving = ray[found], o[found], d[found], leaving[found]
        normal, facet = hit.normal[found], hit.facet[found]
        o = o + hit.distance[found, None] * d
        record.path_code[ray] = (record.path_code[ray] * PATH_CODE_FACTOR + facet + 1) & PATH_CODE_MASK

        # Equation (3). At the critical angle itself the surface still reflects all light.
        cos_stone = np.einsum("ij,ij->i", d, normal)
        exits = ~is_totally_reflected(cos_stone, model.index)
        out = ray[exits]
        d_out, cos_out = into_air(d[exits], normal[exits], model.index)
        entering = _crossing_factor(cos_out, cos_stone[exits], model, towards_eye=False)
        record.status[out] = RayStatus.EXITED
        record.exit_point[out] = o[exits]
        record.exit_direction[out] = d_out
        record.exit_facet[out] = facet[exits]
        # Section 2.3: light that came in at z <= 0 is rear light, of intensity 0. Where the girdle's lower
        # edge is not level, what came in through a pavilion facet.
        if model.rear == "facet":
            rear = normal[exits, 2] < -LEVEL
        else:
            rear = o[exits, 2] <= model.ground if model.rear == "position" else d_out[:, 2] <= 0.0
        record.rear_mask[out] = rear
        record.primary_intensity[out] = np.where(rear, 0.0, LIGHT_LEVEL * entering * leaving[exits])

        # Equation (5): total reflection turns the normal component round.
        after = d - 2.0 * cos_stone[:, None] * normal
        after[exits] = d_out
        if on_surface is not None:
            on_surface(ray, o, facet, normal, d, after)
        stays = ~exits
        ray, o, d, leaving = ray[stays], o[stays], after[stays], leaving[stays]
        record.reflections[ray] += 1
    record.status[ray] = RayStatus.TRAPPED
    record.reflections[ray] = model.max_reflections  # the last one is no more allowed
    return record


def observe(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    rays: tuple[np.ndarray, np.ndarray] | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Observation:
    """Trace the ray through the centre of every pixel.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View
        The map.
    model : Model, optional
        The optical model; by default that of the stone's material.
    rays : tuple of two (h, w, 3) float64 arrays, optional
        Starts [girdle radius] and directions of the rays, for tracing just those of another tracer; by
        default the view's own.
    threads : int, optional
        Threads to use; by default one a processor.
    progress : callable, optional
        Called with the share done, 0 to 1, from the calling thread.
    """
    start = time.perf_counter()
    model = model or Model.of(stone)
    surfaces = surfaces_of(stone)
    right, up, eye = view.basis()
    x, y = view.cell_centres()
    n = view.resolution**2
    maps: dict[str, Any] = {
        name: np.zeros((n, 3) if name.startswith("exit_") and name != "exit_facet" else n, dtype=kind)
        for name, kind in MAP_TYPES.items()
    }

    def block(begin: int) -> None:
        pixel = np.arange(begin, min(begin + BLOCK, n))
        row, column = np.divmod(pixel, view.resolution)
        if rays is None:
            origin = x[column, None] * right + y[row, None] * up + START_DISTANCE * eye
            direction = np.broadcast_to(-eye, origin.shape)
        else:
            origin, direction = (part[row, column] for part in rays)
            direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        record = trace(surfaces, origin, direction, model)
        for name, array in maps.items():
            array[pixel] = getattr(record, name)

    begins = range(0, n, BLOCK)
    with ThreadPoolExecutor(threads or usable_processors()) as pool:
        futures = [pool.submit(block, begin) for begin in begins]
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                if progress is not None:
                    progress(done / len(futures))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return Observation(
        **{name: array.reshape(*view.shape, *array.shape[1:]) for name, array in maps.items()},
        stone=stone,
        view=view,
        model=model,
        engine="reference",
        seconds=time.perf_counter() - start,
    )


def into_stone(d: np.ndarray, normal: np.ndarray, index: float) -> np.ndarray:
    """Snell's law from air into the stone: tangential components divided by n (equation (2))."""
    tangential = (d - np.einsum("ij,ij->i", d, normal)[:, None] * normal) / index
    cos = np.sqrt(1.0 - np.einsum("ij,ij->i", tangential, tangential))
    return np.asarray(tangential - cos[:, None] * normal)


def into_air(d: np.ndarray, normal: np.ndarray, index: float) -> tuple[np.ndarray, np.ndarray]:
    """Snell's law from the stone into air: tangential components times n (equation (4)); the cosine too."""
    tangential = (d - np.einsum("ij,ij->i", d, normal)[:, None] * normal) * index
    cos = np.sqrt(np.maximum(1.0 - np.einsum("ij,ij->i", tangential, tangential), 0.0))
    return tangential + cos[:, None] * normal, cos


def _crossing_factor(
    cos_air: np.ndarray, cos_stone: np.ndarray, model: Model, *, towards_eye: bool
) -> np.ndarray:
    """T S of one crossing (section 2.2, step 1, and figure 1), as the light travels."""
    t = transmittance(cos_air, model.index, model.fresnel)
    if model.intensity == "radiance":
        return t
    with np.errstate(divide="ignore"):
        return np.asarray(t * (cos_stone / cos_air if towards_eye else cos_air / cos_stone))

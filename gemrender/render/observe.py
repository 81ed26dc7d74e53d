"""Scored maps by Mitsuba."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from gemrender.observation import MAP_TYPES, Model, Observation, View
from gemrender.render.backend import ensure_variant
from gemrender.scene.generator import rows_window, stone_scene
from gemrender.stone import Stone

__all__ = ["observe"]


#: Rays of a pass: enough to keep all cores busy, few enough that a pass stays well below 1 GiB.
PASS_RAYS = 1 << 21

#: Channels of `gem_primary` that make each map.
_CHANNELS: dict[str, tuple[str, ...]] = {
    "primary_intensity": ("primary.intensity",),
    "rear_mask": ("rear.mask",),
    "coverage": ("coverage",),
    "status": ("status",),
    "reflections": ("reflections",),
    "exit_point": ("exit.x", "exit.y", "exit.z"),
    "exit_direction": ("exit.dx", "exit.dy", "exit.dz"),
    "entry_facet": ("entry.facet",),
    "exit_facet": ("exit.facet",),
    "path_code": ("path.code",),
}


def observe(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    variant: str = "llvm_ad_mono",
    progress: Callable[[float], None] | None = None,
) -> Observation:
    """Trace the ray through the centre of every pixel with Mitsuba, in passes of some rows.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View
        The map.
    model : Model, optional
        The optical model; by default that of the stone's material.
    variant : str
        Mitsuba variant; set, and left set.
    progress : callable, optional
        Called with the share done, 0 to 1, after each pass.

    Raises
    ------
    InputError
        Unknown variant.
    BackendError
        Mitsuba cannot run here.
    """
    model = model or Model.of(stone)
    ensure_variant(variant)
    import mitsuba as mi

    start = time.perf_counter()
    passes = -(-(view.resolution**2) // PASS_RAYS)
    rows = -(-view.resolution // passes)
    scene: Any = mi.load_dict(stone_scene(stone, view, model, rows=rows))
    sensor = mi.traverse(scene.sensors()[0])
    maps = {
        name: np.empty((*view.shape, 3) if len(channels) == 3 else view.shape, dtype=MAP_TYPES[name])
        for name, channels in _CHANNELS.items()
    }
    for first in range(0, view.resolution, rows):
        for key, value in rows_window(view, first, rows).items():
            sensor[key] = value
        sensor.update()
        kept = min(rows, view.resolution - first)
        for name, values in _trace_film(scene).items():
            maps[name][first : first + kept] = values[:kept]
        if progress is not None:
            progress((first + kept) / view.resolution)
    return Observation(
        **maps,
        stone=stone,
        view=view,
        model=model,
        engine="mitsuba",
        variant=variant,
        seconds=time.perf_counter() - start,
    )


def _trace_film(scene: Any) -> dict[str, np.ndarray]:
    """Trace one ray a pixel of the film and return the maps' values, (rows, columns[, 3]).

    Sensor and integrator are called as `mi.render` calls them. The film itself is left out: with one
    sample a pixel it would only copy, and that costs half as much as the rays.
    """
    import drjit as dr
    import mitsuba as mi

    sensor, integrator = scene.sensors()[0], scene.integrator()
    columns, rows = sensor.film().size()
    pixel = dr.arange(mi.UInt32, columns * rows)
    row = pixel // columns
    place = mi.Point2f(
        (mi.Float(pixel - row * columns) + 0.5) / columns,
        (mi.Float(row) + 0.5) / rows,
    )
    ray, _ = sensor.sample_ray_differential(0.0, 0.5, place, mi.Point2f(0.5))
    _, _, aovs = integrator.sample(scene, None, ray)
    dr.eval(aovs)
    channel = dict(zip(integrator.aov_names(), aovs, strict=True))
    out = {}
    for name, channels in _CHANNELS.items():
        of_map = [np.asarray(channel[c]).reshape(rows, columns) for c in channels]
        out[name] = of_map[0] if len(of_map) == 1 else np.stack(of_map, axis=-1)
    return out

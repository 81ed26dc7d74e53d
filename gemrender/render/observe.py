"""Scored maps by Mitsuba."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from gemrender.observation import MAP_CHANNELS, MAP_TYPES, Model, Observation, View
from gemrender.render.backend import ensure_variant
from gemrender.scene.generator import rows_window, sensor, stone_scene
from gemrender.scene.loading import load_scene
from gemrender.stone import Stone

__all__ = ["film_rays", "follow", "observe", "observe_sets", "rows_of_pass", "sensor_rays", "view_passes"]

#: Rays of a pass: enough to keep all cores busy, few enough that a pass stays well below 1 GiB.
PASS_RAYS = 1 << 21


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
    start = time.perf_counter()
    rows = rows_of_pass(view, PASS_RAYS)
    scene: Any = load_scene(stone_scene(stone, view, model, rows=rows))
    maps = _maps(scene, view, rows, lambda eye, _: follow(scene, film_rays(eye)), progress)
    return Observation(
        **maps,
        stone=stone,
        view=view,
        model=model,
        engine="mitsuba",
        variant=variant,
        seconds=time.perf_counter() - start,
    )


def observe_sets(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    sets: int,
    seed: int = 1,
    birefringence: bool = False,
    variant: str = "llvm_ad_mono",
    progress: Callable[[float], None] | None = None,
) -> Iterator[Observation]:
    """Trace independent sets of rays, each ray through a random place of its pixel.

    Means over sets are unbiased, and their scatter tells the error: of a birefringent stone each ray has one
    history of modes, drawn by its share.

    Parameters
    ----------
    stone, view, model, variant
        As of `observe`.
    sets : int
        How many.
    seed : int
        Seed of the random numbers, 0 or more.
    birefringence : bool
        Whether light is split in a birefringent stone.
    progress : callable, optional
        Called with the share done, 0 to 1, after each pass.

    Yields
    ------
    Observation
        Of a set.

    Raises
    ------
    InputError
        Unknown variant.
    BackendError
        Mitsuba cannot run here.
    """
    model = model or Model.of(stone)
    ensure_variant(variant)
    rows = rows_of_pass(view, PASS_RAYS)
    described = stone_scene(stone, view, model, rows=rows, birefringence=birefringence)
    described["sensor"]["sampling"] = "area"
    scene, sampler = load_scene(described), load_scene({"type": "independent"})
    for number in range(sets):
        start = time.perf_counter()

        def trace(eye: Any, first: int, number: int = number) -> dict[str, np.ndarray]:
            of_pass = np.random.SeedSequence([seed, number, first]).generate_state(1)
            sampler.seed(int(of_pass[0]), rows * view.resolution)
            return follow(scene, film_rays(eye, sampler), sampler)

        def go_on(done: float, number: int = number) -> None:
            if progress is not None:
                progress((number + done) / sets)

        maps = _maps(scene, view, rows, trace, go_on)
        yield Observation(
            **maps,
            stone=stone,
            view=view,
            model=model,
            engine="mitsuba",
            variant=variant,
            seconds=time.perf_counter() - start,
        )


def _maps(
    scene: Any,
    view: View,
    rows: int,
    trace: Callable[[Any, int], dict[str, np.ndarray]],
    progress: Callable[[float], None] | None,
) -> dict[str, Any]:
    """Return the maps of an observation, of channels that are traced in passes from a sensor and a row."""
    eye = scene.sensors()[0]
    maps: dict[str, Any] = {
        name: np.empty((*view.shape, 3) if len(channels) == 3 else view.shape, dtype=MAP_TYPES[name])
        for name, channels in MAP_CHANNELS.items()
    }
    for first, kept in view_passes(eye, view, rows):
        channels = trace(eye, first)
        for name, of_map in MAP_CHANNELS.items():
            of_pass = maps[name][first : first + kept]
            for k, channel in enumerate(of_map):
                part = of_pass if len(of_map) == 1 else of_pass[..., k]
                part[:] = channels[channel].reshape(-1, view.resolution)[:kept]
        if progress is not None:
            progress((first + kept) / view.resolution)
    return maps


def sensor_rays(view: View, *, variant: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the rays that `observe` follows, as the sensor makes them in single precision.

    Returns
    -------
    origin, direction : (h, w, 3) float64
        Starts [girdle radius] and directions, unit vectors but for single precision's rounding.
    """
    ensure_variant(variant)
    origin, direction = np.empty((*view.shape, 3)), np.empty((*view.shape, 3))
    rows = rows_of_pass(view, PASS_RAYS)
    eye: Any = load_scene(sensor(view, rows=rows))
    for first, kept in view_passes(eye, view, rows):
        ray = film_rays(eye)
        for whole, values in ((origin, ray.o), (direction, ray.d)):
            # One direction serves all rays of a pass.
            of_pass = np.broadcast_to(np.array(values).T, (len(np.array(ray.o).T), 3))
            whole[first : first + kept] = of_pass.reshape(-1, view.resolution, 3)[:kept]
    return origin, direction


def follow(scene: Any, ray: Any, sampler: Any = None) -> dict[str, np.ndarray]:
    """Follow rays by the scene's integrator; return its channels, each (n,). Modes are drawn by a sampler.

    Neither light nor film is asked: with one sample a pixel the film would only copy, and that costs half as
    much as the rays.
    """
    import drjit as dr

    aovs = scene.integrator().measure(scene, ray, sampler)
    dr.eval(aovs)
    names = scene.integrator().aov_names()
    return {name: np.asarray(values) for name, values in zip(names, aovs, strict=True)}


def film_rays(sensor: Any, sampler: Any = None) -> Any:
    """Return the sensor's rays, row by row: through the middle of each pixel, or where the sampler says."""
    import drjit as dr
    import mitsuba as mi

    columns, rows = sensor.film().size()
    pixel = dr.arange(mi.UInt32, columns * rows)
    row = pixel // columns
    inside = mi.Point2f(0.5) if sampler is None else sampler.next_2d()
    place = mi.Point2f(
        (mi.Float(pixel - row * columns) + inside.x) / columns,
        (mi.Float(row) + inside.y) / rows,
    )
    ray, _ = sensor.sample_ray_differential(0.0, 0.5, place, mi.Point2f(0.5))
    return ray


def rows_of_pass(view: View, most: int) -> int:
    """Rows of each pass over the view, of at most about so many rays; the last may reach beyond it."""
    n_passes = -(-(view.resolution**2) // most)
    return -(-view.resolution // n_passes)


def view_passes(sensor: Any, view: View, rows: int) -> Iterator[tuple[int, int]]:
    """Move the sensor's window over the view; yield the first row, and the rows that count."""
    import mitsuba as mi

    parameters = mi.traverse(sensor)
    for first in range(0, view.resolution, rows):
        for key, value in rows_window(view, first, rows).items():
            parameters[key] = value
        parameters.update()
        yield first, min(rows, view.resolution - first)

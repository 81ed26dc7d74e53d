"""The kernels made ready: compiled when they are first needed on a machine, else read from numba's cache."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from typing import Any

import numpy as np
from numba.core.registry import cpu_target

from gemrender.beam import polygons, rim, unfold
from gemrender.beam import rays as ray_kernels
from gemrender.beam.cache import KernelCache
from gemrender.beam.compiled import COMPILING
from gemrender.beam.facets import trace_facets
from gemrender.beam.measure import measure
from gemrender.beam.solid import beam_stone
from gemrender.cuts import RoundBrilliant
from gemrender.observation import Model, View
from gemrender.stone import Stone

__all__ = ["PREPARING", "compile_rays", "damaged_cache_files", "is_compiled", "prepare", "sample_stone"]


#: Held by who makes kernels ready: other threads wait, and find them so.
PREPARING = threading.Lock()


def prepare(*, rays: bool = True) -> None:
    """Compile or load the kernels that scores need: some seconds once, then 0.2 s a process.

    Parameters
    ----------
    rays : bool
        Whether those of single rays too, which stones without a round girdle seldom need.
    """
    with PREPARING:
        _prepare(rays)


@cache
def _prepare(rays: bool) -> None:
    with _rays_compiled_beside() if rays and not is_compiled() else nullcontext():
        trace_facets(sample_stone(), whole=False)
    if rays:
        measure(sample_stone(), bound=10.0)


@contextmanager
def _rays_compiled_beside() -> Iterator[None]:
    """Let another process compile the rays' kernels meanwhile: numba compiles on one core at a time.

    What it could not do, whatever the reason, is compiled here when it is needed.
    """
    command = [sys.executable, "-c", "from gemrender.beam.prepare import compile_rays; compile_rays()"]
    quiet = subprocess.DEVNULL
    try:
        beside = subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet)
    except OSError:
        yield
        return
    try:
        yield
        beside.wait()
    finally:
        beside.kill()
        beside.wait()


def compile_rays() -> None:
    """Compile the kernels of single rays, and keep them on disk."""
    convex, view, model = beam_stone(sample_stone()), View(resolution=1), Model()
    rays, points = ray_kernels.empty_rays(2), np.zeros((2, 4))[:, :2]  # as `rim_points` gives them
    ray_kernels.enter_rays(points, view.basis(), convex.solid, convex.facet, model.index, rays)
    ray_kernels.follow_rays(convex.solid, convex.facet, model.index, model.max_reflections, rays)
    covered, ends = np.empty((0, 2)), np.zeros(len(convex.solid.planes), dtype=np.int64)
    rim.rim_points(covered, ends, convex.wedge(view), 1.0, 0.1, points[:, 0] + 0.0, points[:, 1])


def sample_stone() -> Stone:
    """Return a stone that every kernel is compiled by."""
    proportions = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=14.5, pavilion_depth=43, girdle_thickness=3
    )
    return Stone.from_proportions(proportions)


def is_compiled() -> bool:
    """Return whether `prepare` has nothing to compile: the kernels are loaded, or whole on disk."""
    context = cpu_target.target_context
    with COMPILING:
        context.refresh()
    target = context.codegen().magic_tuple()

    def is_there(kernel: Any) -> bool:
        cache = _cache(kernel)
        return bool(kernel.signatures) or (cache is not None and cache.holds(target))

    return all(map(is_there, _kernels()))


def damaged_cache_files() -> list[str]:
    """Return files of compiled kernels that are damaged or cannot be read; they are made anew when needed."""
    return [path for cache in map(_cache, _kernels()) if cache is not None for path in cache.damaged()]


def _kernels() -> tuple[Any, ...]:
    """Return the kernels that Python calls; they hold those that they call."""
    return (
        polygons.see_facets,
        polygons.follow_polygons,
        unfold.write_in_common,
        rim.line_points,
        ray_kernels.enter_rays,
        ray_kernels.follow_rays,
    )


def _cache(kernel: Any) -> KernelCache | None:
    cache = getattr(kernel, "_cache", None)
    return cache if isinstance(cache, KernelCache) else None

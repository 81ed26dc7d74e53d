"""The kernels made ready: compiled when they are first needed on a machine, else read from numba's cache."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from numba.core.registry import cpu_target

from gemrender.beam import maps, polygons, rays, rim
from gemrender.beam.cache import KernelCache
from gemrender.beam.maps import observe
from gemrender.cuts import RoundBrilliant
from gemrender.observation import View
from gemrender.stone import Stone

__all__ = ["damaged_cache_files", "is_compiled", "prepare"]


@lru_cache(maxsize=1)
def prepare() -> None:
    """Compile or load every kernel that scores and maps need: ten seconds once, then 0.2 s a process."""
    proportions = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=14.5, pavilion_depth=43, girdle_thickness=3
    )
    observe(Stone.from_proportions(proportions), View(resolution=4), bound=10.0)


def is_compiled() -> bool:
    """Return whether `prepare` has nothing to compile: the kernels are loaded, or whole on disk."""
    if prepare.cache_info().currsize:
        return True
    context = cpu_target.target_context
    context.refresh()
    target = context.codegen().magic_tuple()
    return all(cache is not None and cache.holds(target) for cache in map(_cache, _kernels()))


def damaged_cache_files() -> list[str]:
    """Return files of compiled kernels that are damaged or cannot be read; they are made anew when needed."""
    return [path for cache in map(_cache, _kernels()) if cache is not None for path in cache.damaged()]


def _kernels() -> tuple[Any, ...]:
    """Return the kernels that Python calls; they hold those that they call."""
    return (
        polygons.see_facets, polygons.follow_polygons, rim.rim_points, rays.enter_rays, rays.follow_rays,
        maps._draw,
    )  # fmt: skip


def _cache(kernel: Any) -> KernelCache | None:
    cache = getattr(kernel, "_cache", None)
    return cache if isinstance(cache, KernelCache) else None

"""The kernels made ready: compiled when they are first needed on a machine, else read from numba's cache."""

from __future__ import annotations

from functools import cache
from typing import Any

from numba.core.registry import cpu_target

from gemrender.beam import polygons, rim
from gemrender.beam import rays as ray_kernels
from gemrender.beam.cache import KernelCache
from gemrender.beam.facets import trace_facets
from gemrender.beam.measure import measure
from gemrender.cuts import RoundBrilliant
from gemrender.stone import Stone

__all__ = ["damaged_cache_files", "is_compiled", "prepare"]


@cache
def prepare(*, rays: bool = True) -> None:
    """Compile or load the kernels that scores need: some seconds once, then 0.2 s a process.

    Parameters
    ----------
    rays : bool
        Whether those of single rays too, which stones without a round girdle seldom need.
    """
    proportions = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=14.5, pavilion_depth=43, girdle_thickness=3
    )
    stone = Stone.from_proportions(proportions)
    if rays:
        measure(stone, bound=10.0)
    else:
        trace_facets(stone, whole=False)


def is_compiled() -> bool:
    """Return whether `prepare` has nothing to compile: the kernels are loaded, or whole on disk."""
    context = cpu_target.target_context
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
        rim.line_points,
        ray_kernels.enter_rays,
        ray_kernels.follow_rays,
    )


def _cache(kernel: Any) -> KernelCache | None:
    cache = getattr(kernel, "_cache", None)
    return cache if isinstance(cache, KernelCache) else None

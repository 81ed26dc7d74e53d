"""Maps of measures by any of the engines, and scores together with the maps behind them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack, cast

from gemrender.engines import (
    DEFAULT_ENGINE,
    DEFAULT_HEAD,
    DEFAULT_MEMORY_LIMIT,
    DEFAULT_TIME_LIMIT,
    DEFAULT_VARIANT,
    check_head,
    engine_for,
    observe,
    require_engine,
)
from gemrender.request import ShortForms, resolve, spelt_out
from gemrender.scoring import Score, add_measures, chosen_or_none, score_observation

if TYPE_CHECKING:
    from gemrender.cuts import StoneLike
    from gemrender.measures import Measure
    from gemrender.measures.maps import MeasureMaps
    from gemrender.observation import Model, Observation, View
    from gemrender.paths import Paths
    from gemrender.stone import Stone

__all__ = ["measure_maps", "score_and_observation", "score_with_maps"]

#: Rays that the reference follows at a time: each has some ten paths.
_REFERENCE_RAYS = 1 << 16


@spelt_out()
def measure_maps(
    stone: StoneLike,
    *,
    measures: str | Measure | Iterable[str | Measure],
    head: float = DEFAULT_HEAD,
    view: View | None = None,
    model: Model | None = None,
    engine: str = DEFAULT_ENGINE,
    variant: str = DEFAULT_VARIANT,
    seed: int = 1,
    time_limit: float = DEFAULT_TIME_LIMIT,
    memory_limit: float = DEFAULT_MEMORY_LIMIT,
    progress: Callable[[float], None] | None = None,
    **short: Unpack[ShortForms],
) -> MeasureMaps:
    """Tell what the light of every pixel of a stone's view adds to measures.

    Their means over the pixels that met the stone are the measures' values. All light of a pixel is
    accounted for: what polygons of the exact engine do not tell of it, and what Mitsuba's rays leave at their
    first exit, one random continuation tells, so that single pixels scatter by that much. Only the reference
    follows every exit of each pixel.

    Parameters
    ----------
    measures : str, Measure, or iterable of them
        Names, several with commas between them, or measures of your own; `all` are all that have maps.
    seed : int
        Seed of the random continuations.
    **short
        As of `ShortForms`.

    Returns
    -------
    MeasureMaps
        Maps (resolution, resolution, channels), row 0 at the top, and the values that they make.

    Raises
    ------
    InputError
        A value outside what is listed, a measure that has no map, or a stone that the engine cannot trace.
    BackendError
        The engine cannot run here.
    """
    from gemrender.cuts import as_stone
    from gemrender.measures.maps import MapBuilder, mapped_measures

    stone = as_stone(stone)
    chosen = mapped_measures(measures)
    check_head(head)
    view, model = resolve(stone, view, model, short)
    require_engine(engine, variant, stones=[stone], time_limit=time_limit, memory_limit=memory_limit)
    used = engine_for(engine, stone)
    if used == "exact":
        from gemrender.beam import Budget
        from gemrender.beam.measure_maps import measure_maps as by_beams

        return by_beams(
            stone, view, model, measures=chosen, head_deg=head, seed=seed, progress=progress,
            budget=Budget(time_limit, memory_limit),
        )  # fmt: skip
    builder = MapBuilder(chosen, view, model, head)
    follow = "all" if builder.follows_all else "principal"
    if used == "reference":
        variant, parts = "", _reference_paths(stone, view, model, follow, progress)
    else:
        from gemrender.render.paths import trace_passes

        parts = trace_passes(stone, view, model, follow=follow, variant=variant, seed=seed, progress=progress)
    for part in parts:
        builder.write_paths(part)
    return builder.maps(stone, used, variant)


def _reference_paths(
    stone: Stone, view: View, model: Model, follow: str, progress: Callable[[float], None] | None
) -> Iterator[Paths]:
    """Yield the reference's paths of some rows of the view, from the top."""
    import numpy as np

    from gemrender.reference import paths_by_ray

    x, y = view.cell_centres()
    rows = max(1, _REFERENCE_RAYS // view.resolution)
    for first in range(0, view.resolution, rows):
        points = np.stack(np.broadcast_arrays(x, y[first : first + rows, None]), axis=-1).reshape(-1, 2)
        paths, ray = paths_by_ray(stone, view, model, follow=follow, points=points)
        yield replace(paths, pixel=first * view.resolution + ray)
        if progress is not None:
            progress(min((first + rows) / view.resolution, 1.0))


def score_and_observation(
    stone: Stone,
    *,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    **options: Any,
) -> tuple[Score, Observation]:
    """Score a stone as `score` does, and return its observation too; parameters and errors as there."""
    chosen = chosen_or_none(measures)
    engine = options.get("engine", DEFAULT_ENGINE)
    observation = observe(stone, measures=chosen or (), head=head, **options)
    found = score_observation(observation)
    if chosen is not None and engine_for(engine, stone) != "exact":
        found = add_measures(found, stone, engine, chosen, head, cast("Any", options))
    return found, observation


def score_with_maps(
    stone: Stone,
    *,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    **options: Any,
) -> tuple[Score, Observation, MeasureMaps | None]:
    """Score a stone as `score` does, and return the maps behind it; where measures have none, None.

    Parameters
    ----------
    stone, measures, head, **options
        As for `score`.

    Raises
    ------
    InputError, BackendError
        As for `score`.
    """
    from gemrender.measures.maps import has_map

    chosen = chosen_or_none(measures)
    found, observation = score_and_observation(stone, measures=chosen, head=head, **options)
    if chosen is None:
        return found, observation, None
    mapped = [of for of in chosen if has_map(of)]
    of_maps = {key: value for key, value in options.items() if key != "bound"}
    maps = measure_maps(stone, measures=mapped, head=head, **of_maps) if mapped else None
    return found, observation, maps

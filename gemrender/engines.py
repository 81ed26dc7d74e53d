"""The engines behind one call: any of them turns a stone into an Observation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

from gemrender.errors import BackendError, InputError
from gemrender.request import (
    DEFAULT_BOUND,
    DEFAULT_HEAD,
    DEFAULT_MEMORY_LIMIT,
    DEFAULT_RESOLUTION,
    DEFAULT_TIME_LIMIT,
    DEFAULT_VARIANT,
    ShortForms,
    resolve,
    spelt_out,
)

if TYPE_CHECKING:
    import numpy as np

    from gemrender.cuts import StoneLike
    from gemrender.measures.measure import Measure
    from gemrender.observation import Measurement, Model, Observation, View
    from gemrender.paths import Paths
    from gemrender.stone import Stone

__all__ = [
    "AUTO",
    "DEFAULT_BOUND",
    "DEFAULT_ENGINE",
    "DEFAULT_HEAD",
    "DEFAULT_MEMORY_LIMIT",
    "DEFAULT_RESOLUTION",
    "DEFAULT_TIME_LIMIT",
    "DEFAULT_VARIANT",
    "ENGINES",
    "VARIANTS",
    "check_head",
    "engine_for",
    "measure",
    "observe",
    "observe_alike",
    "observe_sets",
    "require_engine",
    "split_crystal",
    "trace_paths",
]

#: Exact for convex stones, Mitsuba for others.
AUTO = "auto"
ENGINES = (AUTO, "exact", "mitsuba", "reference")
DEFAULT_ENGINE = AUTO
#: The variants of Mitsuba's wheels but the scalar ones, which are too slow for plugins in Python.
VARIANTS = tuple(
    f"{backend}_ad_{colour}"
    for backend in ("llvm", "cuda")
    for colour in ("rgb", "mono", "mono_polarized", "spectral", "spectral_polarized")
)
#: By how much stones are turned where engines are compared [deg]: rows, columns and diagonals of pixels lie
#: on planes of symmetry of many, and so on edges, where either of two paths is right.
_OFF_PLANES = 1.0


def engine_for(engine: str, stone: Stone) -> str:
    """Return the engine that traces a stone: for "auto" the exact one if the stone is convex, else Mitsuba's.

    Raises
    ------
    InputError
        Unknown engine.
    """
    if engine not in ENGINES:
        raise InputError(f"must be one of {', '.join(ENGINES)}", key="engine", value=engine)
    if engine != AUTO:
        return engine
    try:
        from gemrender.beam import beam_stone

        beam_stone(stone)
    except (InputError, ImportError):  # hollow, or no numba here
        return "mitsuba"
    return "exact"


def require_engine(
    engine: str,
    variant: str = DEFAULT_VARIANT,
    *,
    stones: Iterable[Stone] = (),
    bound: float = DEFAULT_BOUND,
    time_limit: float = DEFAULT_TIME_LIMIT,
    memory_limit: float = DEFAULT_MEMORY_LIMIT,
) -> None:
    """Check that an engine can trace here, before any work is done for it.

    Parameters
    ----------
    engine : {"auto", "exact", "mitsuba", "reference"}
        Which tracer. For Mitsuba, the variant is set, and left set; the exact one is compiled.
    variant : str
        Mitsuba variant. The other engines make no use of it, but a name that no variant has is refused all
        the same: it is a slip.
    stones : iterable of Stone
        What is to be traced.
    bound : float
        Error bound of exact scores [%].
    time_limit, memory_limit : float
        What an exact score may take [s], [GiB].

    Raises
    ------
    InputError
        Unknown engine or variant, a bound or a limit out of range, or a stone that the engine cannot trace.
    BackendError
        The engine cannot run here.
    """
    if engine not in ENGINES:
        raise InputError(f"must be one of {', '.join(ENGINES)}", key="engine", value=engine)
    if variant not in VARIANTS:
        raise InputError(f"must be one of {', '.join(VARIANTS)}", key="variant", value=variant)
    needed = {engine_for(engine, stone) for stone in stones} or {engine}
    if "mitsuba" in needed:
        from gemrender.render.backend import ensure_variant

        try:
            ensure_variant(variant)
        except BackendError as error:
            raise BackendError(
                f"{error}; without Mitsuba, --engine exact and --engine reference work"
            ) from error
    if "exact" in needed:
        beam = _beam()
        beam.check_bound(bound)
        beam.check_limits(time_limit, memory_limit)
        for stone in stones:
            if engine_for(engine, stone) == "exact":
                beam.beam_stone(stone)
        beam.prepare(rays=not stones or any(stone.is_round for stone in stones))


@spelt_out()
def observe(
    stone: StoneLike,
    *,
    view: View | None = None,
    model: Model | None = None,
    engine: str = DEFAULT_ENGINE,
    variant: str = DEFAULT_VARIANT,
    bound: float = DEFAULT_BOUND,
    seed: int = 1,
    measures: Sequence[Measure] = (),
    head: float = DEFAULT_HEAD,
    time_limit: float = DEFAULT_TIME_LIMIT,
    memory_limit: float = DEFAULT_MEMORY_LIMIT,
    progress: Callable[[float], None] | None = None,
    **short: Unpack[ShortForms],
) -> Observation:
    """Trace a stone's top view and return the maps behind its score.

    Parameters
    ----------
    measures : sequence of Measure
        For exact scores what to measure besides the paper's; the other engines make no use of it.
    **short
        As of `ShortForms`.

    Returns
    -------
    Observation
        Maps (resolution, resolution), row 0 at the top; `plot`, `to_xarray`.

    Raises
    ------
    InputError
        A value outside what is listed, or a stone that the engine cannot trace.
    BackendError
        The engine cannot run here.
    """
    from gemrender.cuts import as_stone

    stone = as_stone(stone)
    view, model = resolve(stone, view, model, short)
    require_engine(
        engine, variant, stones=[stone], bound=bound, time_limit=time_limit, memory_limit=memory_limit
    )
    used = engine_for(engine, stone)
    if used == "exact":
        from gemrender.beam import Budget
        from gemrender.beam.maps import observe as by_beams

        budget = Budget(time_limit, memory_limit)
        return by_beams(
            stone, view, model, bound=bound, seed=seed, measures=measures, head_deg=check_head(head),
            progress=progress, budget=budget,
        )  # fmt: skip
    if used == "reference":
        from gemrender.reference import observe as by_reference

        return by_reference(stone, view, model, progress=progress)
    from gemrender.render.observe import observe as by_mitsuba

    return by_mitsuba(stone, view, model, variant=variant, progress=progress)


def measure(
    stone: Stone,
    *,
    view: View | None = None,
    model: Model | None = None,
    measures: Sequence[Measure] = (),
    head: float = DEFAULT_HEAD,
    zenith: np.ndarray | None = None,
    variant: str = DEFAULT_VARIANT,
    bound: float = DEFAULT_BOUND,
    seed: int = 1,
    time_limit: float = DEFAULT_TIME_LIMIT,
    memory_limit: float = DEFAULT_MEMORY_LIMIT,
    progress: Callable[[float], None] | None = None,
    birefringence: bool = False,
    **short: Unpack[ShortForms],
) -> tuple[Measurement, View, Model]:
    """Score a stone by the exact engine without maps, which cost more than the score.

    Options and errors as for `observe`; resolution and variant are checked, and make no difference.

    Parameters
    ----------
    measures : sequence of Measure
        What to measure besides the paper's score.
    head : float
        Half the angle at which the viewer's head is seen from the stone, 0 to below 90 [deg].
    zenith : (3,) float64, optional
        The viewer's zenith, in the stone's frame; by default the direction to the eye.
    birefringence : bool
        Whether light is split in a birefringent stone (`gemrender.beam.modes`).

    Returns
    -------
    (Measurement, View, Model)
        What was measured, from where, and by which model.
    """
    view, model = resolve(stone, view, model, short)
    require_engine(
        "exact", variant, stones=[stone], bound=bound, time_limit=time_limit, memory_limit=memory_limit
    )
    from gemrender.beam import Budget
    from gemrender.beam import measure as by_beams

    crystal = split_crystal(stone, model) if birefringence else None
    asked: Any = {
        "view": view, "model": model, "measures": measures, "head_deg": check_head(head), "zenith": zenith,
        "bound": bound, "seed": seed, "progress": progress, "budget": Budget(time_limit, memory_limit),
    }  # fmt: skip
    if crystal is not None:
        from gemrender.beam.modes import measure_modes

        return measure_modes(stone, crystal, **asked)[0], view, model
    return by_beams(stone, **asked), view, model


def split_crystal(stone: Stone, model: Model) -> Any:
    """Return the crystal that splits a stone's light, with the kernels for it ready; None where none does.

    Parameters
    ----------
    stone : Stone
        A convex stone.
    model : Model
        With the material's ordinary index; another one is of an isotropic stone.

    Raises
    ------
    InputError
        A material that there is not.
    """
    from gemrender.beam.modes import crystal_of
    from gemrender.beam.modes.prepare import prepare_modes

    crystal = crystal_of(stone, model)
    if crystal is not None:
        prepare_modes(crystal)
    return crystal


@spelt_out()
def trace_paths(
    stone: StoneLike,
    *,
    follow: str = "principal",
    view: View | None = None,
    model: Model | None = None,
    engine: str = DEFAULT_ENGINE,
    variant: str = DEFAULT_VARIANT,
    bound: float = DEFAULT_BOUND,
    seed: int = 1,
    samples: int = 1,
    progress: Callable[[float], None] | None = None,
    **short: Unpack[ShortForms],
) -> Paths:
    """Follow the light of a view of a stone, and return its paths.

    The exact engine's rows are virtual facets, and, in independent sets (`set_number`), single rays for what
    polygons do not tell. Those of the other engines are pixels' rays.

    Parameters
    ----------
    follow : {"principal", "all"}
        The light that is followed: the paper's, or all of it.
    bound : float
        The exact engine adds single rays until the paper's scores, and of all light `iso` and `aset`, have
        this bound [%].
    seed : int
        Seed of single rays, and of Mitsuba's random continuations.
    samples : int
        Mitsuba's rays a pixel: one through its centre, or several at random, each in a set of its own.
    **short
        As of `ShortForms`.

    Returns
    -------
    Paths
        Columns (n,) and (n, 3), a row a path; `to_pandas`, `to_xarray`.

    Raises
    ------
    InputError
        A value outside what is listed, or a stone that the engine cannot trace.
    BackendError
        The engine cannot run here.
    """
    from gemrender.cuts import as_stone
    from gemrender.paths import FOLLOW

    stone = as_stone(stone)
    if follow not in FOLLOW:
        raise InputError(f"must be one of {', '.join(FOLLOW)}", key="follow", value=follow)
    view, model = resolve(stone, view, model, short)
    require_engine(engine, variant, stones=[stone], bound=bound)
    used = engine_for(engine, stone)
    if used == "exact":
        from gemrender.beam.measure import trace_paths as by_beams

        return by_beams(stone, view=view, model=model, follow=follow, bound=bound, seed=seed)
    if used == "reference":
        from gemrender.reference import paths as by_reference

        return by_reference(stone, view, model, follow=follow)
    from gemrender.render.paths import trace_paths as by_mitsuba

    return by_mitsuba(
        stone, view, model, follow=follow, variant=variant, seed=seed, spp=samples, progress=progress
    )


def check_head(head: float) -> float:
    """Return half the angle of the viewer's head if it is one [deg].

    Raises
    ------
    InputError
        It is no number, or out of range.
    """
    is_number = isinstance(head, (int, float)) and not isinstance(head, bool)
    if not is_number or not 0 <= head < 90:
        raise InputError("must be from 0 to below 90 [deg]", key="head", value=head)
    return float(head)


def observe_alike(
    stone: Stone,
    *,
    variant: str = DEFAULT_VARIANT,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> list[Observation]:
    """Trace the very same rays with all engines; options and errors as for `observe`.

    Mitsuba's rays start where single precision puts them, and the others follow just those. The stone is
    turned a little about its axis, and the eye with it, so that no pixels lie on planes of symmetry: there
    either of two mirror images of a path is right.

    Returns
    -------
    list of Observation
        By the reference, by Mitsuba, and, if the stone is convex, by beams.
    """
    stone, options = stone.rotated(_OFF_PLANES), _turned(options)
    by_mitsuba = observe(stone, engine="mitsuba", variant=variant, **options)
    from gemrender.reference import observe as by_reference
    from gemrender.render.observe import sensor_rays

    view, model = by_mitsuba.view, by_mitsuba.model
    rays = sensor_rays(view, variant=variant)
    out = [by_reference(stone, view, model, rays=rays, progress=progress), by_mitsuba]
    if engine_for(AUTO, stone) == "exact":
        from gemrender.beam import Budget
        from gemrender.beam.maps import observe as by_beams

        budget = Budget(DEFAULT_TIME_LIMIT, DEFAULT_MEMORY_LIMIT)
        # Pixels are compared, not scores.
        out.append(by_beams(stone, view, model, rays=rays, bound=10.0, budget=budget))
    return out


def observe_sets(
    stone: Stone,
    *,
    sets: int,
    view: View | None = None,
    model: Model | None = None,
    variant: str = DEFAULT_VARIANT,
    seed: int = 1,
    birefringence: bool = False,
    progress: Callable[[float], None] | None = None,
    **short: Unpack[ShortForms],
) -> Iterator[Observation]:
    """Yield observations of independent sets of random rays by Mitsuba.

    Each set sees all of the view, in so many fewer pixels that all sets together have about as many rays as
    the view that was asked for has pixels. Options and errors are those of `observe`; see
    `gemrender.render.observe.observe_sets`.
    """
    view, model = resolve(stone, view, model, short)
    require_engine("mitsuba", variant, stones=[stone])
    from gemrender.render.observe import observe_sets as by_mitsuba

    fewer = replace(view, resolution=math.ceil(view.resolution / math.sqrt(sets)))
    return by_mitsuba(
        stone, fewer, model, sets=sets, seed=seed, birefringence=birefringence, variant=variant,
        progress=progress,
    )  # fmt: skip


def _turned(options: dict[str, Any]) -> dict[str, Any]:
    """Return options with the eye turned as the stone is where engines are compared."""
    view = options.get("view")
    if view is None:
        return options | {"tilt_azimuth": options.get("tilt_azimuth", 0.0) + _OFF_PLANES}
    return options | {"view": replace(view, tilt_azimuth_deg=view.tilt_azimuth_deg + _OFF_PLANES)}


def _beam() -> Any:
    """Import the exact engine.

    Raises
    ------
    BackendError
        numba cannot be imported.
    """
    try:
        import gemrender.beam
    except ImportError as error:
        raise BackendError(f"the exact engine cannot run: {error}; to cure it: pip install numba") from error
    return gemrender.beam

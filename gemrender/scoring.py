"""Scores: Average, Rear and the bands of a stone's top view."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Unpack

from gemrender.engines import (
    DEFAULT_ENGINE,
    DEFAULT_HEAD,
    check_head,
    engine_for,
    measure,
    observe,
    observe_sets,
    trace_paths,
)
from gemrender.errors import InputError
from gemrender.request import ShortForms, TraceOptions, spelt_out
from gemrender.shown import Tabled, plots

if TYPE_CHECKING:
    import numpy as np

    from gemrender.cuts import StoneLike
    from gemrender.measures import Measure
    from gemrender.observation import Measurement, MeasureValues, Model, Observation, View
    from gemrender.stone import Stone

__all__ = [
    "BAND_EDGES",
    "UNSEEN_RAYS",
    "Band",
    "FacetSizes",
    "Score",
    "add_measures",
    "chosen_or_none",
    "score",
    "score_measurement",
    "score_observation",
    "score_pixels",
    "scores_of_sets",
]

#: Lower edges of the bands of intensity [%], brightest first (`docs/model.md`, section 1).
BAND_EDGES = (75.0, 60.0, 45.0, 30.0, 15.0, 0.0)

#: Light of which so many random rays would be expected may be missed by all of them, where no scatter tells
#: of it: with a probability of exp(-6.9), 0.1 %.
UNSEEN_RAYS = 6.9

#: The keys of the JSON that scripts rely on, in their order; further keys come after them.
_CONTRACT = (
    "name", "average", "rear", "bands", "trapped", "engine", "variant", "resolution", "fresnel", "seconds",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Share of the top view whose light has an intensity from `low` to below `high`.

    Attributes
    ----------
    low, high : float
        Edges [%]; `high` is None for the brightest band.
    share : float
        Share of the top view's area [%].
    """

    low: float
    high: float | None
    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FacetSizes:
    """How many virtual facets a view has, and how large they are, in per cent of the view's area.

    Attributes
    ----------
    number : int
        Virtual facets; the light near the girdle has none.
    near_girdle : float
        Share of the view that comes near the girdle, or was left to single rays for want of time or memory
        [%].
    largest, median : float
        Area of the largest one, and of the middle one by size [%].
    half : int
        So many of the largest ones make half of the view.
    classes : tuple of (float, int, float)
        Lower edge of a class of areas [%], number and total area [%] of those in it, largest first.
    """

    number: int
    near_girdle: float
    largest: float
    median: float
    half: int
    classes: tuple[tuple[float, int, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Score(Tabled):
    """The scores of one stone, in per cent.

    Attributes
    ----------
    name : str
        The stone's name.
    average : float
        Mean intensity over the top view, rear light counted as 0 [%].
    rear : float
        Share of the top view whose light is rear light [%].
    bands : tuple of Band
        Shares of the lit part by intensity, brightest first. Bands, rear, trapped and lost make 100.
    trapped : float
        Share whose rays were still inside after the largest number of reflections [%].
    lost : float
        Share whose rays were lost to rounding [%].
    engine, variant : str
        What traced it; only Mitsuba has a variant.
    resolution : int or None
        Pixels a side; an exact score has none.
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye from the stone's axis, and the azimuth it is tilted to [deg].
    fresnel, rear_rule, intensity : str
        The model's options.
    index : float
        Refractive index.
    seconds : float
        Time of the trace [s].
    bound : float or None
        Of an exact score, and of Mitsuba's random rays: Average, Rear and every band are within this of the
        truth, each with a confidence of 99.9 % [%].
    facets : FacetSizes or None
        Of an exact score: number and sizes of the virtual facets.
    assumed : tuple of str
        What was assumed of the stone, as its description left it out (`Stone.assumed`).
    notes : tuple of str
        What was asked for and not reached, in words, such as a bound; empty where all was.
    measures : tuple of MeasureValues or None
        What further measures say; None if none was asked for.
    """

    name: str
    average: float
    rear: float
    bands: tuple[Band, ...]
    trapped: float
    lost: float
    engine: str
    variant: str
    resolution: int | None
    tilt_deg: float = 0.0
    tilt_azimuth_deg: float = 0.0
    fresnel: str
    rear_rule: str
    intensity: str
    index: float
    seconds: float
    bound: float | None = None
    facets: FacetSizes | None = None
    assumed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    measures: tuple[MeasureValues, ...] | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the score as the command line's JSON has it."""
        measures = self.measures
        values = asdict(replace(self, measures=None))
        del values["measures"]
        values["bands"] = [{"from": b.low, "to": b.high, "share": b.share} for b in self.bands]
        values["assumed"], values["notes"] = list(self.assumed), list(self.notes)
        if self.facets is not None:
            values["facets"]["classes"] = [
                {"from": low, "number": number, "share": share} for low, number, share in self.facets.classes
            ]
        if measures is not None:
            values["measures"] = {of.name: of.to_dict() for of in measures}
        return {key: values.pop(key) for key in _CONTRACT} | values

    def plot(self, ax: Any = None) -> Any:
        """Draw the shares of the view by intensity, as bars in the colours of maps.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.

        Returns
        -------
        matplotlib.axes.Axes
        """
        return plots().plot_score(self, ax)


def score_observation(observation: Observation) -> Score:
    """Score an observation: exactly where its engine did, else by its pixels (`score_pixels`)."""
    if observation.measured is None:
        return score_pixels(observation)
    return score_measurement(
        observation.measured,
        observation.stone,
        observation.view,
        observation.model,
        seconds=observation.seconds,
        with_measures=bool(observation.measured.measures),
    )


def score_pixels(observation: Observation) -> Score:
    """Score the maps of an observation.

    All shares are of the pixels whose ray met the stone: equal cells of the top view.

    Raises
    ------
    InputError
        No ray met the stone (a map of too few pixels).
    """
    import numpy as np

    from gemrender.observation import RayStatus

    met = observation.coverage > 0
    area = int(np.count_nonzero(met))
    if area == 0:
        resolution = observation.view.resolution
        raise InputError("must be larger, no ray met the stone", key="resolution", value=resolution)
    intensity = observation.primary_intensity
    lit = (observation.status == RayStatus.EXITED) & (observation.rear_mask == 0)

    def share(mask: np.ndarray) -> float:
        return 100.0 * float(np.count_nonzero(mask)) / area

    return Score(
        name=observation.stone.name,
        average=float(intensity.sum(dtype=np.float64)) / area,
        rear=share(observation.rear_mask > 0),
        bands=_bands(
            share(lit & (intensity >= low) & (intensity < (high or np.inf))) for low, high in _EDGES
        ),
        trapped=share(observation.status == RayStatus.TRAPPED),
        lost=share(observation.status == RayStatus.LOST),
        engine=observation.engine,
        variant=observation.variant,
        resolution=int(observation.view.resolution),
        seconds=observation.seconds,
        assumed=observation.stone.assumed,
        **_request(observation.view, observation.model),
    )


@spelt_out()
def score(
    stone: StoneLike,
    *,
    engine: str = DEFAULT_ENGINE,
    measures: str | Measure | Iterable[str | Measure] | None = None,
    head: float = DEFAULT_HEAD,
    birefringence: bool = False,
    **options: Unpack[TraceOptions],
) -> Score:
    """Trace a stone and score it.

    ::

        gemrender.score("inoue-3").average
        gemrender.score("my-design.asc", measures="iso,aset", tilt=10)

    Parameters
    ----------
    measures : str, Measure, or iterable of them, optional
        What to measure besides the paper's score: names (`gemrender.measures`), several with commas between
        them, `all`, or measures of your own.
    birefringence : bool
        Whether light is split in a birefringent stone, whose crystal lies as the stone says. By default such
        a stone has its ordinary index alone (biaxial: its middle one). An index of your own is an isotropic
        stone's. Mitsuba's rays, for stones that are not convex, are random then, and have a bound.
    **options
        As of `TraceOptions`.

    Returns
    -------
    Score
        Average, Rear and bands [%]; `to_dict`, `to_pandas`, `plot`.

    Raises
    ------
    InputError
        A value outside what is listed, a stone that the engine cannot trace, a measure that there is not, or
        that the engine cannot tell.
    BackendError
        The engine cannot run here.
    """
    from gemrender.cuts import as_stone

    stone = as_stone(stone)
    chosen = chosen_or_none(measures)
    check_head(head)
    if engine_for(engine, stone) != "exact":
        if birefringence:
            if engine == "reference" or chosen is not None:
                of = (
                    "by the engines exact and mitsuba"
                    if chosen is None
                    else "for measures by the exact engine"
                )
                raise InputError(f"light is split {of} alone", key="birefringence", value=birefringence)
            return _split_by_rays(stone, options)
        found = score_observation(observe(stone, engine=engine, **options))
        return found if chosen is None else add_measures(found, stone, engine, chosen, head, options)
    measured, view, model = measure(
        stone, measures=chosen or (), head=head, birefringence=birefringence, **options
    )
    return score_measurement(measured, stone, view, model, with_measures=chosen is not None)


def scores_of_sets(stone: Stone, options: TraceOptions) -> tuple[list[Score], int]:
    """Score independent sets of Mitsuba's random rays, light split in a birefringent stone.

    Parameters
    ----------
    stone : Stone
        The stone.
    options : TraceOptions
        Of the resolution, the square is the number of rays in all; what is the exact engine's is left out.

    Returns
    -------
    (sets, rays)
        Scores of `gemrender.measures.tally.SETS` sets, and how many rays of all of them met the stone.
    """
    import numpy as np

    from gemrender.measures.tally import SETS
    from gemrender.observation import indicatrix_of

    of_exact = ("bound", "time_limit", "memory_limit")
    asked: Any = {key: value for key, value in options.items() if key not in of_exact}
    sets, rays = [], 0
    notes: tuple[str, ...] = ()
    for seen in observe_sets(stone, sets=SETS, birefringence=True, **asked):
        if not notes and (crystal := indicatrix_of(stone, seen.model)) is not None:
            indices = ", ".join(f"{index:.5f}" for index in dict.fromkeys(crystal.indices.tolist()))
            notes = (f"light is split: indices {indices}",)
        sets.append(replace(score_pixels(seen), notes=notes))
        rays += int(np.count_nonzero(seen.coverage))
    return sets, rays


def _split_by_rays(stone: Stone, options: TraceOptions) -> Score:
    """Score a birefringent stone by Mitsuba, which draws the modes of rays."""
    import numpy as np

    from gemrender.measures.tally import SETS, bounds_of_sets

    sets, rays = scores_of_sets(stone, options)
    found = np.array([[s.average, s.rear, s.trapped, s.lost, *(b.share for b in s.bands)] for s in sets])
    average, rear, trapped, lost, *shares = found.mean(axis=0).tolist()
    bands = zip(sets[0].bands, shares, strict=True)
    return replace(
        sets[0],
        average=average,
        rear=rear,
        trapped=trapped,
        lost=lost,
        bands=tuple(replace(band, share=share) for band, share in bands),
        resolution=round(sets[0].resolution * SETS**0.5) if sets[0].resolution else None,
        bound=float(bounds_of_sets(found).max()) + 100.0 * UNSEEN_RAYS / rays,
        seconds=sum(s.seconds for s in sets),
    )


def chosen_or_none(
    measures: str | Measure | Iterable[str | Measure] | None,
) -> tuple[Measure, ...] | None:
    """Return the measures that were asked for, if any were; errors as of `chosen_measures`."""
    if measures is None:
        return None
    from gemrender.measures import chosen_measures

    return chosen_measures(measures)


def add_measures(
    found: Score,
    stone: Stone,
    engine: str,
    measures: tuple[Measure, ...],
    head: float,
    options: TraceOptions,
) -> Score:
    """Return a score by pixels with what measures say of its engine's paths."""
    import numpy as np

    from gemrender.measures.tally import SETS, Tally, bounds_of_sets
    from gemrender.observation import MeasureValues
    from gemrender.request import resolve

    for of in measures:
        if of.views != "one":
            raise InputError(
                f"{of.name} is a sum over views, which the exact engine alone tells",
                key="measures",
                value=of.name,
            )
    given: Any = {**options}
    short: Any = {key: given[key] for key in ShortForms.__annotations__ if key in given}
    view, model = resolve(stone, given.get("view"), given.get("model"), short)
    tally = Tally(view, model, measures, head)
    of_paths = {key: given[key] for key in ("variant", "seed", "progress") if key in given}
    sets = SETS if engine_for(engine, stone) == "mitsuba" else 1
    # As many rays, in sets: their scatter tells the error.
    coarser = replace(view, resolution=max(round(view.resolution / sets**0.5), 1))
    paths = trace_paths(
        stone, view=coarser, model=model, engine=engine, follow="all" if tally.follows_all else "principal",
        samples=sets, **of_paths,
    )  # fmt: skip
    by_set = sets * tally.sum_up(paths, sets)
    values, scatter = tally.values(by_set.mean(axis=0)), tally.values(by_set)
    return replace(
        found,
        measures=tuple(
            MeasureValues(
                name=of.name,
                version=of.version,
                values=dict(zip(of.keys, map(float, each), strict=True)),
                bound=None if sets == 1 else float(np.nanmax(bounds_of_sets(spread), initial=0.0)),
            )
            for of, each, spread in zip(measures, values, scatter, strict=True)
        ),
    )


_EDGES = tuple(zip(BAND_EDGES, (None, *BAND_EDGES[:-1]), strict=True))
#: Lower edges of the classes of virtual facets by size [% of the view].
_SIZE_CLASSES = (1.0, 0.1, 0.01, 0.001, 0.0)


def _bands(shares: Iterable[float]) -> tuple[Band, ...]:
    return tuple(
        Band(low=low, high=high, share=share) for (low, high), share in zip(_EDGES, shares, strict=True)
    )


def _request(view: View, model: Model) -> dict[str, Any]:
    return {
        "tilt_deg": float(view.tilt_deg),
        "tilt_azimuth_deg": float(view.tilt_azimuth_deg),
        "fresnel": model.fresnel,
        "rear_rule": model.rear,
        "intensity": model.intensity,
        "index": model.index,
    }


def score_measurement(
    measured: Measurement,
    stone: Stone,
    view: View,
    model: Model,
    *,
    seconds: float | None = None,
    with_measures: bool = False,
) -> Score:
    """Return a measurement as a score; its time [s] is that of the measurement, or another one."""
    return Score(
        name=stone.name,
        average=measured.average,
        rear=measured.rear,
        bands=_bands(float(share) for share in measured.bands),
        trapped=measured.trapped,
        lost=measured.lost,
        engine="exact",
        variant="",
        resolution=None,
        seconds=measured.seconds if seconds is None else seconds,
        bound=measured.bound,
        facets=_facet_sizes(measured),
        assumed=stone.assumed,
        notes=measured.notes,
        measures=measured.measures if with_measures else None,
        **_request(view, model),
    )


def _facet_sizes(measured: Measurement) -> FacetSizes:
    import numpy as np

    sizes = np.sort(measured.sizes)[::-1]
    classes = []
    for low, high in zip(_SIZE_CLASSES, (np.inf, *_SIZE_CLASSES[:-1]), strict=True):
        within = sizes[(sizes >= low) & (sizes < high)]
        classes.append((low, len(within), float(within.sum())))
    return FacetSizes(
        number=len(sizes),
        near_girdle=float(measured.girdle),
        largest=float(sizes[0]) if len(sizes) else 0.0,
        median=float(np.median(sizes)) if len(sizes) else 0.0,
        half=min(int(np.searchsorted(np.cumsum(sizes), 50.0)) + 1, len(sizes)),
        classes=tuple(classes),
    )

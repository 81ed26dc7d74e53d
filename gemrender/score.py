"""Scores: Average, Rear and the bands of a stone's top view."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from gemrender.engines import DEFAULT_ENGINE, observe

if TYPE_CHECKING:
    from gemrender.observation import Observation
    from gemrender.stone import Stone

__all__ = ["BAND_EDGES", "Band", "Score", "score", "score_observation"]

#: Lower edges of the bands of intensity [%], brightest first (`model.md`, section 1).
BAND_EDGES = (75.0, 60.0, 45.0, 30.0, 15.0, 0.0)


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
class Score:
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
        What traced it; the reference has no variant.
    resolution : int
        Pixels a side.
    fresnel, rear_rule, intensity : str
        The model's options.
    index : float
        Refractive index.
    seconds : float
        Time of the trace [s].
    """

    name: str
    average: float
    rear: float
    bands: tuple[Band, ...]
    trapped: float
    lost: float
    engine: str
    variant: str
    resolution: int
    fresnel: str
    rear_rule: str
    intensity: str
    index: float
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return the score as the command line's JSON has it."""
        out = asdict(self)
        out["bands"] = [{"from": b.low, "to": b.high, "share": b.share} for b in self.bands]
        return out


def score_observation(observation: Observation) -> Score:
    """Score the maps of an observation.

    Averages are over the pixels whose ray met the stone: equal cells of the top view.

    Raises
    ------
    ValueError
        No ray met the stone (a map of too few pixels).
    """
    import numpy as np

    from gemrender.observation import RayStatus

    met = observation.coverage > 0
    area = int(np.count_nonzero(met))
    if area == 0:
        raise ValueError("no ray met the stone")
    intensity = observation.primary_intensity
    lit = (observation.status == RayStatus.EXITED) & (observation.rear_mask == 0)

    def share(mask: np.ndarray) -> float:
        return 100.0 * float(np.count_nonzero(mask)) / area

    bands, high = [], np.inf
    for low in BAND_EDGES:
        inside = share(lit & (intensity >= low) & (intensity < high))
        bands.append(Band(low=low, high=None if np.isinf(high) else float(high), share=inside))
        high = low
    model = observation.model
    return Score(
        name=observation.stone.name,
        average=float(intensity.sum(dtype=np.float64)) / area,
        rear=100.0 * float(observation.rear_mask.sum(dtype=np.float64)) / area,
        bands=tuple(bands),
        trapped=share(observation.status == RayStatus.TRAPPED),
        lost=share(observation.status == RayStatus.LOST),
        engine=observation.engine,
        variant=observation.variant,
        resolution=observation.view.resolution,
        fresnel=model.fresnel,
        rear_rule=model.rear,
        intensity=model.intensity,
        index=model.index,
        seconds=observation.seconds,
    )


def score(stone: Stone, *, engine: str = DEFAULT_ENGINE, **options: Any) -> Score:
    """Trace a stone and score it; options and errors as for `observe`."""
    return score_observation(observe(stone, engine=engine, **options))

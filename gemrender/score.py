"""Scores: Average, Rear and the bands of a stone's top view."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from gemrender.engines import DEFAULT_ENGINE, observe
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Observation
    from gemrender.stone import Stone

__all__ = ["BAND_EDGES", "Band", "Score", "score", "score_observation"]

#: Lower edges of the bands of intensity [%], brightest first (`model.md`, section 1).
BAND_EDGES = (75.0, 60.0, 45.0, 30.0, 15.0, 0.0)

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
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye from the stone's axis, and the azimuth it is tilted to [deg].
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
    tilt_deg: float = 0.0
    tilt_azimuth_deg: float = 0.0
    fresnel: str
    rear_rule: str
    intensity: str
    index: float
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return the score as the command line's JSON has it."""
        values = asdict(self)
        values["bands"] = [{"from": b.low, "to": b.high, "share": b.share} for b in self.bands]
        return {key: values.pop(key) for key in _CONTRACT} | values


def score_observation(observation: Observation) -> Score:
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

    uppers = (None, *BAND_EDGES[:-1])
    bands = tuple(
        Band(low=low, high=high, share=share(lit & (intensity >= low) & (intensity < (high or np.inf))))
        for low, high in zip(BAND_EDGES, uppers, strict=True)
    )
    model, view = observation.model, observation.view
    return Score(
        name=observation.stone.name,
        average=float(intensity.sum(dtype=np.float64)) / area,
        rear=share(observation.rear_mask > 0),
        bands=bands,
        trapped=share(observation.status == RayStatus.TRAPPED),
        lost=share(observation.status == RayStatus.LOST),
        engine=observation.engine,
        variant=observation.variant,
        resolution=int(view.resolution),
        tilt_deg=float(view.tilt_deg),
        tilt_azimuth_deg=float(view.tilt_azimuth_deg),
        fresnel=model.fresnel,
        rear_rule=model.rear,
        intensity=model.intensity,
        index=model.index,
        seconds=observation.seconds,
    )


def score(stone: Stone, *, engine: str = DEFAULT_ENGINE, **options: Any) -> Score:
    """Trace a stone and score it; options and errors as for `observe`."""
    return score_observation(observe(stone, engine=engine, **options))

"""How far two tracers agree on the same rays."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from gemrender.scoring import Band, score_pixels

if TYPE_CHECKING:
    from gemrender.observation import Observation

__all__ = [
    "LEAST_SAME_EXIT",
    "LONG_PATH",
    "MOST_AVERAGE_DIFFERENCE",
    "MOST_BAND_DIFFERENCE",
    "MOST_INTENSITY_DIFFERENCE",
    "MOST_LOST",
    "MOST_REAR_DIFFERENCE",
    "CrossCheck",
    "crosscheck",
]

#: Share of rays with the same status and exit facet [%], among those that are reflected at most LONG_PATH
#: times to either tracer. The rest are rays that pass within single precision's rounding of an edge.
LEAST_SAME_EXIT = 99.9
#: Rays that are reflected more often run about the curved girdle, where any rounding is multiplied at every
#: reflection: two float64 tracers part after some 120. Of stones of a high index they are one in 300. What
#: they do in the mean counts still, in Average, Rear and bands.
LONG_PATH = 100
#: Difference in Average [%] and in Rear [%]: one ray in a thousand, wrong by half the intensity of light.
MOST_AVERAGE_DIFFERENCE = 0.05
MOST_REAR_DIFFERENCE = 0.05
#: Difference in the share of a band [%]: rays at a band's edge may fall to either side as well.
MOST_BAND_DIFFERENCE = 0.1
#: Mean difference in intensity [%] among rays with the same facet sequence: single precision's rounding of
#: the result (4e-6) and of Gübelin's angles near 90 degrees.
MOST_INTENSITY_DIFFERENCE = 1e-3
#: Share of rays lost to rounding [%]: one in 100 000.
MOST_LOST = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossCheck:
    """How two observations of the same rays compare; shares and differences in per cent.

    Attributes
    ----------
    name : str
        The stone's name.
    engines : (str, str)
        What traced the first and the second.
    rays : int
        Rays that met the stone in either observation.
    same_exit : float
        Share of them with the same status and exit facet [%].
    same_path : float
        Share of them with the same status and facet sequence [%].
    largest_intensity, mean_intensity : float
        Largest and mean difference in intensity among rays with the same facet sequence [%].
    average, rear : float
        Difference, first minus second, in Average and Rear [%].
    bands : tuple of Band
        Difference in the share of each band [%].
    lost : float
        Larger share of lost rays [%].
    seconds : tuple of float
        Time of each trace [s].
    same_exit_short : float
        Share of rays with the same status and exit facet among those that are reflected at most LONG_PATH
        times in either observation [%].
    """

    name: str
    engines: tuple[str, str]
    rays: int
    same_exit: float
    same_path: float
    largest_intensity: float
    mean_intensity: float
    average: float
    rear: float
    bands: tuple[Band, ...]
    lost: float
    seconds: tuple[float, float]
    same_exit_short: float

    @property
    def failures(self) -> list[str]:
        """What lies outside the tolerances, each told in words; empty when all is well."""
        band = max(abs(b.share) for b in self.bands)
        checks = [
            (self.same_exit_short >= LEAST_SAME_EXIT,
             f"{self.same_exit_short:.4f} % of rays end alike, at least {LEAST_SAME_EXIT:g} % must"),
            (abs(self.average) <= MOST_AVERAGE_DIFFERENCE,
             f"Average differs by {self.average:+.4f}, at most {MOST_AVERAGE_DIFFERENCE:g} is allowed"),
            (abs(self.rear) <= MOST_REAR_DIFFERENCE,
             f"Rear differs by {self.rear:+.4f}, at most {MOST_REAR_DIFFERENCE:g} is allowed"),
            (band <= MOST_BAND_DIFFERENCE,
             f"a band differs by {band:.4f}, at most {MOST_BAND_DIFFERENCE:g} is allowed"),
            (self.mean_intensity <= MOST_INTENSITY_DIFFERENCE,
             f"intensities differ by {self.mean_intensity:.2e} in the mean, "
             f"at most {MOST_INTENSITY_DIFFERENCE:g} is allowed"),
            (self.lost <= MOST_LOST,
             f"{self.lost:.4f} % of rays are lost, at most {MOST_LOST:g} % may be"),
        ]  # fmt: skip
        return [text for ok, text in checks if not ok]

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison for JSON."""
        out = asdict(self)
        out["bands"] = [{"from": b.low, "to": b.high, "difference": b.share} for b in self.bands]
        out["failures"] = self.failures
        out["same_exit_short"] = out.pop("same_exit_short")  # further keys come last
        return out


def crosscheck(first: Observation, second: Observation) -> CrossCheck:
    """Compare two observations of the same stone, view and model, ray by ray.

    Raises
    ------
    ValueError
        The stones, the views or the models differ.
    """
    import numpy as np

    one, other = first.stone.solid, second.stone.solid
    same_stone = type(one) is type(other) and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in ("planes", "facet", "is_round")
    )
    if not same_stone or first.view != second.view or first.model != second.model:
        raise ValueError("the observations are of different stones, views or models")
    met = (first.coverage > 0) | (second.coverage > 0)
    rays = int(np.count_nonzero(met))
    same_status = met & (first.status == second.status)
    same_exit = same_status & (first.exit_facet == second.exit_facet)
    short = met & (np.minimum(first.reflections, second.reflections) <= LONG_PATH)
    same_path = same_exit & (first.path_code == second.path_code)
    difference = np.abs(
        first.primary_intensity[same_path].astype(np.float64) - second.primary_intensity[same_path]
    )
    a, b = score_pixels(first), score_pixels(second)
    return CrossCheck(
        name=first.stone.name,
        engines=(first.engine, second.engine),
        rays=rays,
        same_exit=100.0 * np.count_nonzero(same_exit) / rays,
        same_path=100.0 * np.count_nonzero(same_path) / rays,
        largest_intensity=float(difference.max(initial=0.0)),
        mean_intensity=float(difference.mean()) if difference.size else 0.0,
        average=a.average - b.average,
        rear=a.rear - b.rear,
        bands=tuple(
            Band(low=x.low, high=x.high, share=x.share - y.share)
            for x, y in zip(a.bands, b.bands, strict=True)
        ),
        lost=max(a.lost, b.lost),
        seconds=(a.seconds, b.seconds),
        same_exit_short=100.0 * np.count_nonzero(same_exit & short) / (int(np.count_nonzero(short)) or 1),
    )

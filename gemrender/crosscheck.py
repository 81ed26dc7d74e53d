"""How far two tracers agree: on the same rays, or in the mean where each has rays of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from gemrender.scoring import UNSEEN_RAYS, Band, Score, score, score_pixels, scores_of_sets

if TYPE_CHECKING:
    from gemrender.observation import Observation
    from gemrender.stone import Stone

__all__ = [
    "LEAST_SAME_EXIT",
    "LONG_PATH",
    "MOST_AVERAGE_DIFFERENCE",
    "MOST_BAND_DIFFERENCE",
    "MOST_INTENSITY_DIFFERENCE",
    "MOST_LOST",
    "MOST_REAR_DIFFERENCE",
    "CrossCheck",
    "ScoreCheck",
    "compare_scores",
    "crosscheck",
    "crosscheck_scores",
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreCheck:
    """How the mean over random rays compares with an exact score; shares and differences in per cent.

    Of a birefringent stone no two tracers can follow the same rays: in which mode one goes on is drawn.

    Attributes
    ----------
    name : str
        The stone's name.
    engines : (str, str)
        What traced the rays, and what the exact score.
    rays : int
        Rays that met the stone.
    average, rear : float
        Difference, first minus second, in Average and Rear [%].
    bands : tuple of Band
        Difference in the share of each band [%].
    average_allowed, rear_allowed : float
        How far each may differ [%]: by the exact score's bound, by what the scatter of the rays allows their
        mean, and by what all of them may miss, each with a confidence of 99.9 %.
    bands_allowed : tuple of float
        The same of each band [%].
    bound : float
        The exact score's bound [%].
    lost : float
        Share of lost rays [%].
    seconds : tuple of float
        Time of the rays, and of the exact score [s].
    """

    name: str
    engines: tuple[str, str]
    rays: int
    average: float
    rear: float
    bands: tuple[Band, ...]
    average_allowed: float
    rear_allowed: float
    bands_allowed: tuple[float, ...]
    bound: float
    lost: float
    seconds: tuple[float, float]

    @property
    def failures(self) -> list[str]:
        """What lies outside the tolerances, each told in words; empty when all is well."""
        bands = zip(self.bands, self.bands_allowed, strict=True)
        differences = [
            ("Average", self.average, self.average_allowed),
            ("Rear", self.rear, self.rear_allowed),
            *((f"the band from {band.low:g}", band.share, allowed) for band, allowed in bands),
        ]
        out = [
            f"{what} differs by {difference:+.4f}, at most {allowed:.4f} is allowed"
            for what, difference, allowed in differences
            if not abs(difference) <= allowed  # NaN is none
        ]
        if not self.lost <= MOST_LOST:
            out.append(f"{self.lost:.4f} % of rays are lost, at most {MOST_LOST:g} % may be")
        return out

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison for JSON."""
        out = asdict(self)
        bands = zip(self.bands, out.pop("bands_allowed"), strict=True)
        out["bands"] = [
            {"from": b.low, "to": b.high, "difference": b.share, "allowed": allowed} for b, allowed in bands
        ]
        out["failures"] = self.failures
        return out


def compare_scores(sets: Sequence[Score], exact: Score, *, rays: int) -> ScoreCheck:
    """Compare the mean of scores of independent sets of rays with an exact score.

    Parameters
    ----------
    sets : sequence of Score
        Of `gemrender.measures.tally.SETS` sets, of about as many rays each.
    exact : Score
        The exact score, with its bound.
    rays : int
        Rays of all sets that met the stone.
    """
    import numpy as np

    from gemrender.measures.tally import bounds_of_sets

    def values(of: Score) -> list[float]:
        return [of.average, of.rear, *(band.share for band in of.bands)]

    found = np.array([values(of) for of in sets])
    apart = (found.mean(axis=0) - values(exact)).tolist()
    bound = exact.bound or 0.0
    allowed = (bound + bounds_of_sets(found) + 100.0 * UNSEEN_RAYS / rays).tolist()
    return ScoreCheck(
        name=exact.name,
        engines=(sets[0].engine, exact.engine),
        rays=rays,
        average=apart[0],
        rear=apart[1],
        bands=tuple(
            Band(low=band.low, high=band.high, share=share)
            for band, share in zip(exact.bands, apart[2:], strict=True)
        ),
        average_allowed=allowed[0],
        rear_allowed=allowed[1],
        bands_allowed=tuple(allowed[2:]),
        bound=bound,
        lost=float(np.mean([of.lost for of in sets])),
        seconds=(sum(of.seconds for of in sets), exact.seconds),
    )


def crosscheck_scores(
    stone: Stone,
    *,
    variant: str,
    seed: int = 1,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> ScoreCheck:
    """Compare Mitsuba's mean over random rays with the exact score, light split in a birefringent stone.

    Parameters
    ----------
    stone : Stone
        The stone.
    variant : str
        Mitsuba variant.
    seed : int
        Seed of all random numbers.
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        As of `gemrender.observe`; of the resolution, the square is the number of rays in all.

    Raises
    ------
    InputError
        A value outside what is listed, or a stone that is not convex.
    BackendError
        An engine cannot run here.
    """

    def half(first: float) -> Callable[[float], None]:
        def go_on(done: float) -> None:
            if progress is not None:
                progress(first + 0.5 * done)

        return go_on

    exact = score(
        stone, engine="exact", birefringence=True, variant=variant, seed=seed, progress=half(0.0), **options
    )
    asked: Any = {**options, "variant": variant, "seed": seed, "progress": half(0.5)}
    sets, rays = scores_of_sets(stone, asked)
    return compare_scores(sets, exact, rays=rays)

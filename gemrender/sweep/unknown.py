"""What is not known of a stone: a report's rounding, a cutter's or a scanner's errors; as random draws.

Each draw has a seed of its own, so that a study can be stopped and go on, and any draw be made again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np

from gemrender.cuts import StoneLike, as_stone, stone_from_vertices
from gemrender.cuts.families.family import Family
from gemrender.cuts.variations import vary
from gemrender.errors import InputError
from gemrender.reading import did_you_mean
from gemrender.stone import ConvexSolid, Stone

__all__ = [
    "MOST_JITTER", "MOST_TILT_DEG", "STEPS", "Cutting", "Measuring", "Rounding", "Unknown", "draw",
]  # fmt: skip

#: Largest standard deviation of a facet's tilt [deg]: the worst stones sold are off by one or two.
MOST_TILT_DEG = 5.0
#: Largest standard deviation of how far a facet is cut too deep [% of half the outline's longer side].
MOST_DEPTH = 5.0
#: Largest standard deviation of a jittered vertex [girdle radius].
MOST_JITTER = 0.05
#: A draw that makes no stone (facets that vanish, vertices out of order) is drawn again so many times.
MOST_ATTEMPTS = 100

#: The steps that laboratories round figures to [%, deg]: those of GIA Facetware for table, angles, star,
#: lower half and girdle; hundredths of a ratio, as reports print it.
STEPS: dict[str, float] = {
    "table": 1.0,
    "crown_angle": 0.5,
    "pavilion_angle": 0.2,
    "star": 5.0,
    "lower_half": 5.0,
    "girdle_thickness": 0.5,
    "length_to_width": 0.01,
}


class Unknown(Protocol):
    """Something that is not known of a stone."""

    def draw(self, stone: Stone, rng: np.random.Generator) -> Stone:
        """Return a stone that it might as well be; InputError where the draw makes no stone."""
        ...

    def check(self, stone: Stone) -> None:
        """Refuse a stone of which this can not be drawn."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """Return what it is, of JSON's types."""
        ...


@dataclass(frozen=True, slots=True)
class Rounding:
    """A report's rounding: each figure lies anywhere within half a step of what is stated.

    Parameters
    ----------
    steps : mapping of str to float
        The step of each figure, by keys of `STEPS` or other parameters of the cut [%, deg]; 0 for one that is
        known exactly.
    """

    steps: Mapping[str, float]

    @classmethod
    def of(cls, stone: StoneLike, changes: Mapping[str, float] | None = None) -> Rounding:
        """Return the rounding of a laboratory's report of a stone, with some steps changed.

        The stone may be what `load_stone` takes.

        Raises
        ------
        InputError
            The stone was not made from proportions, a key that it has not, or a step below 0.
        """
        known = figures_of(as_stone(stone))
        steps = {key: step for key, step in STEPS.items() if key in known}
        for key, step in (changes or {}).items():
            if key not in known:
                raise InputError(
                    f"unknown key; must be one of {', '.join(known)}{did_you_mean(key, list(known))}", key=key
                )
            if not 0 <= step < np.inf:
                raise InputError("must be 0 or more", key=key, value=step)
            if key in _HEIGHTS:
                steps.pop(_HEIGHTS[key], None)
            steps[key] = step
        return cls(steps)

    def check(self, stone: Stone) -> None:
        """Refuse a stone that was not made from proportions."""
        figures_of(stone)

    def draw(self, stone: Stone, rng: np.random.Generator) -> Stone:
        """Return the stone with every figure somewhere within its step."""
        values = figures_of(stone)
        moved = {
            key: values[key] + step * (rng.random() - 0.5) for key, step in sorted(self.steps.items()) if step
        }
        if isinstance(stone.cut, Family):
            family_stone: Stone = stone.cut.changed(**moved).stone(name=stone.name, material=stone.material)
            return family_stone
        return vary(stone, [(key, (value,)) for key, value in moved.items()])[0]

    def to_dict(self) -> dict[str, Any]:
        """Return it, of JSON's types."""
        return {"of": "rounding", "steps": dict(self.steps)}


#: Heights, and the angles that stand for them.
_HEIGHTS = {"crown_height": "crown_angle", "pavilion_depth": "pavilion_angle"}


def figures_of(stone: Stone) -> dict[str, float]:
    """Return what a report states of a stone, or could, by name: proportions, parameters and angles.

    Raises
    ------
    InputError
        It was not made from proportions.
    """
    if isinstance(stone.cut, Family):
        numbers = {part.name for part in fields(stone.cut) if "range" in part.metadata}  # type: ignore[arg-type]
        values = {key: value for key, value in stone.cut.values().items() if key in numbers}
        return {**values, **{key: float(value) for key, value in stone.cut.alternatives().items()}}
    proportions = stone.proportions
    if proportions is None:
        raise InputError(
            "has no proportions that a report could round: it must be made from [proportions], [angles], "
            "[report] or [cut]",
            source=stone.source or stone.name,
        )
    return {
        "table": proportions.table,
        "crown_angle": proportions.crown_angle_deg,
        "pavilion_angle": proportions.pavilion_angle_deg,
        "star": proportions.star,
        "lower_half": 100.0 - proportions.lower_girdle_contact,
        "girdle_thickness": proportions.girdle_thickness,
        "crown_height": proportions.crown_height,
        "pavilion_depth": proportions.pavilion_depth,
    }


@dataclass(frozen=True, slots=True)
class Cutting:
    """A cutter's errors: each facet tilted, and cut too deep or not deep enough, by normal deviates.

    Parameters
    ----------
    tilt_deg : float
        Standard deviation of the two angles that each facet is tilted by, about its middle [deg].
    depth : float
        Standard deviation of how far each facet is off [% of half the outline's longer side].
    """

    tilt_deg: float
    depth: float = 0.0

    def __post_init__(self) -> None:
        for key, value, high in (
            ("deviation", self.tilt_deg, MOST_TILT_DEG), ("depth", self.depth, MOST_DEPTH),
        ):  # fmt: skip
            if not 0 <= value <= high:
                raise InputError(f"must be from 0 to {high:g}", key=key, value=value)

    def check(self, stone: Stone) -> None:
        """Refuse a stone that is not convex."""
        if not stone.is_convex:
            raise InputError("facets can be tilted of convex stones only", source=stone.source or stone.name)

    def draw(self, stone: Stone, rng: np.random.Generator) -> Stone:
        """Return the stone with its facets tilted and moved."""
        drawn = stone.tilted(self.tilt_deg, rng, depth=self.depth / 100.0)
        assert isinstance(drawn.solid, ConvexSolid)
        drawn.solid.cut(32)  # fails where nothing is left
        return drawn

    def to_dict(self) -> dict[str, Any]:
        """Return it, of JSON's types."""
        return {"of": "cutting", "tilt_deg": self.tilt_deg, "depth": self.depth}


@dataclass(frozen=True, slots=True)
class Measuring:
    """A scanner's errors: each vertex of a round brilliant off by normal deviates.

    Parameters
    ----------
    jitter : float
        Standard deviation of each coordinate [girdle radius].
    """

    jitter: float

    def __post_init__(self) -> None:
        if not 0 <= self.jitter <= MOST_JITTER:
            raise InputError(f"must be from 0 to {MOST_JITTER:g}", key="jitter", value=self.jitter)

    def check(self, stone: Stone) -> None:
        """Refuse a stone without the 57 vertices of a round brilliant."""
        if stone.labelled_vertices is None:
            raise InputError(
                "only the 57 vertices of round brilliants can be jittered", source=stone.source or stone.name
            )

    def draw(self, stone: Stone, rng: np.random.Generator) -> Stone:
        """Return the stone with its vertices jittered."""
        moved = stone.vertices + rng.normal(0.0, self.jitter, stone.vertices.shape)
        return stone_from_vertices(moved, name=stone.name, material=stone.material)

    def to_dict(self) -> dict[str, Any]:
        """Return it, of JSON's types."""
        return {"of": "measuring", "jitter": self.jitter}


def draw(stone: Stone, unknown: Unknown, seed: int, number: int) -> Stone:
    """Return draw `number` of a stone; one that makes no stone is drawn again.

    Raises
    ------
    InputError
        No draw made a stone: the deviation is too large for it.
    """
    rng = np.random.default_rng([seed, number])
    for _ in range(MOST_ATTEMPTS):
        try:
            return unknown.draw(stone, rng)
        except InputError as error:
            last = error
    key, value = next((key, value) for key, value in unknown.to_dict().items() if key != "of" and value)
    key = {"tilt_deg": "deviation"}.get(key, key)
    raise InputError(f"makes no stone in {MOST_ATTEMPTS} draws: {last}", key=key, value=value) from last

"""The plan of an atlas: which stones, what is measured of them, and how that is shared out in chunks."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from gemrender.cuts.variations import Value, varied
from gemrender.engines import DEFAULT_BOUND, DEFAULT_HEAD
from gemrender.measures import Measure
from gemrender.stone import Stone

__all__ = ["CHUNK", "MOST_CELLS", "STONES", "VIEWS", "AtlasPlan", "AtlasVariable", "part_shape"]

#: Most stones of a plan.
MOST_CELLS = 100_000_000
#: Stones of a chunk unless a plan says otherwise: some seconds of work, which is what is lost at the most.
CHUNK = 512
#: Names of the dimensions that are no parameters: stones of a Sobol design, and views of each stone.
STONES, VIEWS = "stone", "view"


@dataclass(frozen=True, slots=True, kw_only=True)
class AtlasVariable:
    """A number that an atlas has for each stone and view.

    Attributes
    ----------
    name : str
        Name in the data set: `iso`, `inoue_average`, or `iso_bound` for how far all values of a measure are
        from the truth at the most.
    measure : Measure
        The measure.
    key : str
        Which of its values; "" for the bound.
    """

    name: str
    measure: Measure
    key: str


@dataclass(frozen=True, kw_only=True)
class AtlasPlan:
    """Which stones are measured, and how.

    Attributes
    ----------
    name : str
        What the atlas is called.
    stone : Stone
        The stone that is varied.
    grid : dict of str to tuple
        Values of each parameter that is on a grid, by its key (`settings_of`).
    ranges : dict of str to (float, float)
        First and last value of each parameter of the Sobol design.
    number, seed : int
        Stones of the Sobol design, 0 without one, and the seed that its points are scrambled by.
    measures : tuple of Measure
        What is measured.
    bound, head : float
        Wanted error bound [%], and half the angle at which the viewer's head is seen [deg].
    tilts : tuple of (float, float)
        Tilt of the eye and the azimuth it is tilted to of each view [deg]; empty for the top view alone,
        which then is no dimension.
    chunk : int
        Most stones of a chunk.
    """

    name: str
    stone: Stone
    grid: dict[str, tuple[Value, ...]]
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    number: int = 0
    seed: int = 1
    measures: tuple[Measure, ...]
    bound: float = DEFAULT_BOUND
    head: float = DEFAULT_HEAD
    tilts: tuple[tuple[float, float], ...] = ()
    chunk: int = CHUNK

    # ---- Shape ----

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Number of stones along each dimension but the views."""
        design = {STONES: self.number} if self.ranges else {}
        return design | {key: len(values) for key, values in self.grid.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """The same as a shape."""
        return tuple(self.sizes.values())

    @property
    def stones(self) -> int:
        """Number of stones."""
        return math.prod(self.shape)

    @cached_property
    def chunk_shape(self) -> tuple[int, ...]:
        """Most stones of a chunk along each dimension: whole rows of the last ones."""
        return part_shape(self.shape, self.chunk)

    @cached_property
    def chunks_along(self) -> tuple[int, ...]:
        """Number of chunks along each dimension."""
        return tuple(-(-size // part) for size, part in zip(self.shape, self.chunk_shape, strict=True))

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return math.prod(self.chunks_along)

    def place(self, chunk: int) -> tuple[slice, ...]:
        """Return where a chunk lies, a slice along each dimension."""
        numbers = np.unravel_index(chunk, self.chunks_along)
        return tuple(
            slice(int(k) * part, min((int(k) + 1) * part, size))
            for k, part, size in zip(numbers, self.chunk_shape, self.shape, strict=True)
        )

    # ---- Stones ----

    def settings(
        self, place: tuple[slice, ...], first: int = 0, last: int | None = None
    ) -> Iterator[dict[str, Value]]:
        """Yield what is set for the stones there, or some of them; the last dimension varies fastest."""
        parts = dict(zip(self.sizes, place, strict=True))
        axes: list[list[dict[str, Value]]] = [
            [{key: value} for value in values[parts[key]]] for key, values in self.grid.items()
        ]
        if self.ranges:  # points only of what is asked for
            rows, inner = parts[STONES], math.prod(len(axis) for axis in axes)
            end = rows.stop if last is None else rows.start + -(-last // inner)
            rows = slice(rows.start + first // inner, end)
            last = None if last is None else last - first // inner * inner
            first %= inner
            points = self.points(rows)
            axes.insert(0, [dict(zip(self.ranges, map(float, point), strict=True)) for point in points])
        for cell in itertools.islice(itertools.product(*axes), first, last):
            yield {key: value for each in cell for key, value in each.items()}

    def points(self, numbers: slice) -> np.ndarray:
        """Return points of the Sobol design, (n, parameters): the same whichever are asked for together."""
        unit = _points(len(self.ranges), self.seed, numbers.start, numbers.stop)
        low, high = np.array(list(self.ranges.values())).T
        return np.asarray(low + (high - low) * unit)

    def made(self, setting: dict[str, Value]) -> Stone:
        """Return the stone with values set.

        Raises
        ------
        InputError
            The values make no stone.
        """
        return varied(self.stone, setting)

    def sample(self, number: int) -> list[dict[str, Value]]:
        """Return what is set for some stones, spread evenly over the plan."""
        count = min(number, self.stones)
        cells = [np.unravel_index(k * self.stones // count, self.shape) for k in range(count)]
        return [next(self.settings(tuple(slice(int(k), int(k) + 1) for k in cell))) for cell in cells]

    # ---- What is found ----

    @cached_property
    def variables(self) -> tuple[AtlasVariable, ...]:
        """All numbers of a stone and view: of each measure its values, then their bound."""
        out = []
        for of in self.measures:
            name = of.name.replace("-", "_")
            for key in of.keys:
                out.append(
                    AtlasVariable(name=name if key == "value" else f"{name}_{key}", measure=of, key=key)
                )
            out.append(AtlasVariable(name=f"{name}_bound", measure=of, key=""))
        return tuple(out)

    @property
    def views(self) -> tuple[tuple[float, float], ...]:
        """Tilt and azimuth of every view [deg]."""
        return self.tilts or ((0.0, 0.0),)

    @property
    def bytes(self) -> int:
        """Size of the whole atlas before compression [bytes]: single precision, and a byte of status."""
        return self.stones * (1 + 4 * len(self.variables) * len(self.views) + 8 * len(self.ranges))

    @cached_property
    def record(self) -> dict[str, Any]:
        """All that the values depend on, of JSON's types: atlases of one plan have the same."""
        base = self.stone
        return {
            "name": self.name,
            "stone": base.name,
            "shape": _shape_digest(base),
            "material": base.material,
            "vary": {key: list(values) for key, values in self.grid.items()}
            | {key: {"first": low, "last": high} for key, (low, high) in self.ranges.items()},
            "sobol": {"number": self.number, "seed": self.seed} if self.ranges else None,
            "measures": {of.name: of.version for of in self.measures},
            "bound": self.bound,
            "head": self.head,
            "tilts": [list(tilt) for tilt in self.tilts],
            "chunk": self.chunk,
        }


#: Where each thread's last sequence of points is: to go on there is quicker than to begin anew.
_LAST = threading.local()


def _points(dimensions: int, seed: int, start: int, stop: int) -> np.ndarray:
    """Return points of a scrambled Sobol sequence, (stop - start, dimensions)."""
    from scipy.stats import qmc

    of = dimensions, seed
    if getattr(_LAST, "of", None) != of or _LAST.engine.num_generated > start:
        _LAST.engine = qmc.Sobol(dimensions, scramble=True, seed=np.random.default_rng(seed))
        _LAST.of = of
    engine = _LAST.engine
    if engine.num_generated < start:
        engine.fast_forward(start - engine.num_generated)
    if start:
        return np.asarray(engine.random(stop - start))
    # The first alone, else there is a warning that the number is no power of two.
    return np.concatenate([engine.random(1), engine.random(stop - 1)])


def _shape_digest(stone: Stone) -> str:
    """Return a digest of what a stone is before it is varied: its cut's parameters, or its planes.

    Numbers count to twelve digits, which are the same on all machines.
    """
    shape: list[Any]
    if stone.cut is None:
        shape = [stone.is_round, stone.facet_sides, np.round(stone.solid.planes, 9).tolist()]
    else:
        values = {part.name: getattr(stone.cut, part.name) for part in fields(stone.cut)}  # type: ignore[arg-type]
        words = {key: f"{value:.12g}" if isinstance(value, float) else value for key, value in values.items()}
        shape = [type(stone.cut).__module__.rpartition(".")[2], words, stone.description]
    return hashlib.sha256(json.dumps(shape, default=str).encode()).hexdigest()


def part_shape(shape: tuple[int, ...], most: int) -> tuple[int, ...]:
    """Return the shape of parts of at most so many items: whole rows of the last dimensions."""
    left, sizes = most, []
    for size in reversed(shape):
        sizes.append(min(size, left))
        left = max(left // size, 1)
    return tuple(reversed(sizes))

"""Maps of measures: what each pixel of a view adds to them."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.measures.evaluate import contributions, light_of
from gemrender.measures.measure import HEAD_DEG, Light, Measure
from gemrender.measures.registry import chosen_measures, measures
from gemrender.observation import Model, View
from gemrender.paths import Paths
from gemrender.shown import Shown, library, plots
from gemrender.stone import Stone

__all__ = ["MapBuilder", "MeasureMaps", "channel_names", "has_map", "mapped_measures"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class MeasureMaps(Shown):
    """Maps of measures over a view of a stone, row 0 at the top.

    Attributes
    ----------
    maps : dict of str to (h, w, k) float32
        By the names of the measures, one layer for each of their channels: per cent of the light or of the
        area of the pixel, and of measures of another unit what a path adds; 0 outside the stone.
    coverage : (h, w) float32
        1 where the ray met the stone, else 0.
    values : dict of str to dict of str to float
        Of each measure its values by name, as the pixels have them; NaN where one is not defined.
    measures : tuple of Measure
        The measures.
    stone, view, model : Stone, View, Model
        What was traced.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    engine, variant : str
        What traced it; only Mitsuba has a variant.
    seconds : float
        Time that it took [s].
    """

    maps: dict[str, np.ndarray]
    coverage: np.ndarray
    values: dict[str, dict[str, float]]
    measures: tuple[Measure, ...]
    stone: Stone
    view: View
    model: Model
    head_deg: float
    engine: str
    variant: str
    seconds: float

    def __repr__(self) -> str:
        names = ", ".join(of.name for of in self.measures)
        return f"<MeasureMaps of {self.stone.name!r}: {names}; {self.view.resolution} pixels a side>"

    def __getitem__(self, measure: str) -> np.ndarray:
        """Return the map of a measure, (h, w, k)."""
        return self.maps[measure]

    def channels(self) -> dict[str, np.ndarray]:
        """Return each channel by its name, such as `aset.green`, (h, w) float32."""
        return {
            f"{measure.name}.{name}": self.maps[measure.name][..., k]
            for measure in self.measures
            for k, name in enumerate(channel_names(measure))
        }

    def to_xarray(self) -> Any:
        """Return the channels as an xarray Dataset along `y` (from the top) and `x`, and `coverage`.

        Both are places in the view [stone's unit]; `attrs` name the stone, and hold the measures' values.

        Raises
        ------
        BackendError
            xarray is not installed.
        """
        x, y = self.view.cell_centres()
        maps = {**self.channels(), "coverage": self.coverage}
        return library("xarray").Dataset(
            {name: (("y", "x"), values) for name, values in maps.items()},
            coords={"x": x, "y": y},
            attrs={
                "stone": self.stone.name,
                "engine": self.engine,
                **{f"{of}.{key}": value for of, told in self.values.items() for key, value in told.items()},
            },
        )

    def plot(self, ax: Any = None, *, measure: str | None = None) -> Any:
        """Draw the map of a measure.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.
        measure : str, optional
            Its name; by default the first.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            No map of such a measure.
        """
        return plots().plot_map(self, ax, measure)


def channel_names(measure: Measure) -> tuple[str, ...]:
    """Return the names of what a measure's `contributions` yields."""
    return measure.channels or measure.keys


def has_map(measure: Measure) -> bool:
    """Tell whether a measure has a map: it is of one view, and paths add to it."""
    return measure.views == "one" and len(channel_names(measure)) > 0


def mapped_measures(chosen: str | Measure | Iterable[str | Measure]) -> tuple[Measure, ...]:
    """Return the measures that maps were asked of, as `chosen_measures` does; all are all that have one.

    Raises
    ------
    InputError
        As for `chosen_measures`, or a measure that has no map.
    """
    if chosen == "all":
        return tuple(filter(has_map, measures()))
    found = chosen_measures(chosen)
    for measure in found:
        if not has_map(measure):
            why = "is a sum over views" if measure.views != "one" else "counts virtual facets"
            raise InputError(f"has no map: it {why}", key="measures", value=measure.name)
    return found


class MapBuilder:
    """Maps while they are made, block by block of whole rows; sums are in double precision.

    Parameters
    ----------
    measures : sequence of Measure
        The measures.
    view, model : View, Model
        From where and by which model the paths are traced.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].

    Attributes
    ----------
    n_channels : int
        Channels of all measures together.
    follows_all : bool
        Whether a measure needs all light.
    """

    def __init__(
        self, measures: Sequence[Measure], view: View, model: Model, head_deg: float = HEAD_DEG
    ) -> None:
        self.measures, self.view, self.model, self.head_deg = tuple(measures), view, model, head_deg
        numbers = [len(channel_names(measure)) for measure in measures]
        ends = np.cumsum(numbers, dtype=np.int64)
        self._columns = [slice(end - n, end) for end, n in zip(ends, numbers, strict=True)]
        self.n_channels = sum(numbers)
        self.follows_all = any(measure.follow == "all" for measure in measures)
        self._maps = [np.zeros((*view.shape, n), dtype=np.float32) for n in numbers]
        self._coverage = np.zeros(view.shape, dtype=np.float32)
        self._sums, self._covered = np.zeros(self.n_channels), 0
        self._start = time.perf_counter()

    def light(self, paths: Paths) -> Light:
        """Return paths as measures take them."""
        return Light(paths=paths, view=self.view, model=self.model, head_deg=self.head_deg)

    def added(self, light: Light) -> np.ndarray:
        """Return what each path adds to each channel of all measures, per unit of area, (n, n_channels)."""
        out = np.zeros((len(light), self.n_channels))
        principal = np.flatnonzero(light.paths.partial_reflections == 0)
        for measure, columns in zip(self.measures, self._columns, strict=True):
            rows = slice(None) if light_of(measure, light) is light else principal
            out[rows, columns] = contributions(measure, light)
        return out

    def write(self, first_row: int, block: np.ndarray, covered: np.ndarray) -> None:
        """Write whole rows: what is added to each pixel (n, n_channels), and which met the stone (n,)."""
        rows = slice(first_row, first_row + len(block) // self.view.resolution)
        shape = (-1, self.view.resolution)
        for measure, of, columns in zip(self.measures, self._maps, self._columns, strict=True):
            of[rows] = (_scale(measure) * block[:, columns]).reshape(*shape, of.shape[-1])
        self._coverage[rows] = covered.reshape(shape)
        self._sums += block.sum(axis=0)
        self._covered += int(np.count_nonzero(covered))

    def write_paths(self, paths: Paths) -> None:
        """Write whole rows from paths through pixels: all those of these rows, one after the other."""
        pixel, resolution = paths.pixel, self.view.resolution
        assert pixel is not None
        if not len(pixel):
            return
        first, last = int(pixel.min()) // resolution, int(pixel.max()) // resolution
        of, n = pixel - first * resolution, (last + 1 - first) * resolution
        area = (2.0 * self.view.half_width / resolution) ** 2
        light = self.light(paths)
        added = self.added(light) * (paths.area / area)[:, None]
        block = np.stack([np.bincount(of, column, n) for column in added.T], axis=1)
        self.write(first, block, np.bincount(of[light.is_principal], minlength=n) > 0)

    def maps(self, stone: Stone, engine: str, variant: str = "") -> MeasureMaps:
        """Return the maps, once all rows are written.

        Raises
        ------
        InputError
            No ray met the stone (a map of too few pixels).
        """
        if not self._covered:
            resolution = self.view.resolution
            raise InputError("must be larger, no ray met the stone", key="resolution", value=resolution)
        values = {}
        for measure, columns in zip(self.measures, self._columns, strict=True):
            found = measure.values(self._sums[columns], np.array(self._covered, dtype=np.float64))
            values[measure.name] = dict(zip(measure.keys, map(float, found), strict=True))
        return MeasureMaps(
            maps=dict(zip((measure.name for measure in self.measures), self._maps, strict=True)),
            coverage=self._coverage,
            values=values,
            measures=self.measures,
            stone=stone,
            view=self.view,
            model=self.model,
            head_deg=self.head_deg,
            engine=engine,
            variant=variant,
            seconds=time.perf_counter() - self._start,
        )


def _scale(measure: Measure) -> float:
    return 100.0 if measure.unit == "%" else 1.0

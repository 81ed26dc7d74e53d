"""Maps of measures as pictures: zones in their colours, light on a scale, with the values beside them."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import gemrender
from gemrender.measures import Measure
from gemrender.measures.maps import MeasureMaps, channel_names
from gemrender.report.figures import (
    BAND_COLOURS,
    MAP_PIXELS,
    OUTSIDE_COLOUR,
    REAR_COLOUR,
    UNSOLVED_COLOUR,
    colour_numbers,
    map_page,
    picture_of_rows,
)
from gemrender.scoring import BAND_EDGES
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["ZONE_COLOURS", "measure_map_figure", "measure_map_picture", "write_measure_maps"]

#: Zones of an ASET, as the instrument has them; what leaks is dark, as rear light is in other maps.
ZONE_COLOURS = {"green": "#2fbf4f", "red": "#e0252b", "blue": "#2440d8", "leak": REAR_COLOUR}
#: What belongs to none of a map's zones.
_NO_ZONE = "#dcdcdc"
_GREY = "#666666"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Zones:
    """A map of channels, each with a colour: that of the one which has the light of a pixel.

    Or, where they share it, their mixture, by their shares in linear light: then the rest is black.
    """

    colours: dict[str, str]
    rest: str = _NO_ZONE
    mixes: bool = False
    caption: str = ""

    def picture(self, maps: MeasureMaps, measure: Measure, rows: slice) -> np.ndarray:
        names = channel_names(measure)
        of = maps[measure.name][rows][..., [names.index(name) for name in self.colours]] / 100.0
        colours = colour_numbers(*self.colours.values(), self.rest).astype(np.float64)
        if self.mixes:
            return _encoded(np.nan_to_num(of) @ _linear(colours[:-1]))
        return np.asarray(colours[np.where((of > 0.0).any(axis=-1), of.argmax(axis=-1), len(self.colours))])


@dataclass(frozen=True, slots=True, kw_only=True)
class _Scale:
    """A map of one channel in the colours of a scale from 0; up to the map's largest where `top` is None.

    It has no value where that is not known, or where the channel `where` is 0.
    """

    channel: str
    top: float | None = 100.0
    colours: str = "gray"
    where: str | None = None
    caption: str = ""

    def top_of(self, maps: MeasureMaps, measure: Measure) -> float:
        if self.top is not None:
            return self.top
        values = maps[measure.name][..., channel_names(measure).index(self.channel)]
        largest = float(np.nanmax(values, initial=0.0))
        step = 10.0 ** math.floor(math.log10(largest)) if largest > 0.0 else 1.0
        return math.ceil(largest / step) * step if largest > 0.0 else 1.0

    def picture(self, maps: MeasureMaps, measure: Measure, rows: slice) -> np.ndarray:
        from matplotlib import colormaps

        names, of = channel_names(measure), maps[measure.name][rows]
        values = of[..., names.index(self.channel)]
        known = ~np.isnan(values) & ((of[..., names.index(self.where)] > 0.0) if self.where else True)
        shares = np.clip(np.nan_to_num(values) / self.top_of(maps, measure), 0.0, 1.0)
        colours = 255.0 * colormaps[self.colours](shares)[..., :3]
        return np.asarray(np.where(known[..., None], colours, colour_numbers(_NO_ZONE)[0]))


_BANDS = {f"band_{100 * low / 100:.0f}": c for low, c in zip(BAND_EDGES, BAND_COLOURS, strict=True)}
#: The maps of each measure; of others one of its first channel.
_PICTURES: dict[str, tuple[_Zones | _Scale, ...]] = {
    "inoue": (
        _Zones(colours=_BANDS | {"rear": REAR_COLOUR, "trapped": UNSOLVED_COLOUR, "lost": UNSOLVED_COLOUR}),
    ),
    "aset": (
        _Zones(colours=ZONE_COLOURS | {"trapped": UNSOLVED_COLOUR}, caption="principal light"),
        _Zones(
            colours={f"weighted_{name}": ZONE_COLOURS[name] for name in ("green", "red", "blue")},
            mixes=True,
            caption="all light, by its share",
        ),
    ),
    "window": (_Zones(colours={"value": "#2b748e"}),),
    "extinction": (_Zones(colours={"head": REAR_COLOUR, "late_leak": "#de5f26"}),),
    "dispersion": (_Scale(channel="angle", top=None, colours="viridis", where="area"),),
}


def _pictures(maps: MeasureMaps, measure: Measure) -> tuple[_Zones | _Scale, ...]:
    first = channel_names(measure)[0]
    return _PICTURES.get(measure.name, (_Scale(channel=first, top=100.0 if measure.unit == "%" else None),))


def measure_map_picture(maps: MeasureMaps, name: str) -> list[np.ndarray]:
    """Return the maps of a measure in colours, each (n, n, 3) uint8, as `figures.picture_of_rows` does."""
    measure = _measure(maps, name)
    outside = colour_numbers(OUTSIDE_COLOUR)[0]

    def picture(drawn: _Zones | _Scale) -> np.ndarray:
        def rows(of: slice) -> np.ndarray:
            return np.where(maps.coverage[of][..., None] > 0, drawn.picture(maps, measure, of), outside)

        return picture_of_rows(rows, maps.view.resolution)

    return [picture(drawn) for drawn in _pictures(maps, measure)]


def measure_map_figure(maps: MeasureMaps, name: str) -> Figure:
    """Draw the maps of a measure, with its values as the pixels have them beside them.

    Parameters
    ----------
    maps : MeasureMaps
        The maps.
    name : str
        The measure's name.

    Returns
    -------
    matplotlib.figure.Figure
        To be saved at its own resolution (`write_measure_maps`).
    """
    measure = _measure(maps, name)
    drawn = _pictures(maps, measure)
    captions = [each.caption for each in drawn] if len(drawn) > 1 else ()
    figure, panel = map_page(measure_map_picture(maps, name), maps.view, maps.stone, captions)
    for axes, each in zip(figure.axes, drawn, strict=False):  # the panel comes last
        if isinstance(each, _Scale):  # white on white
            _draw_outline(axes, maps)
    _draw_panel(panel, maps, measure, drawn)
    return figure


def write_measure_maps(
    maps: MeasureMaps, folder: str | os.PathLike[str], stem: str, *, formats: Iterable[str] = ("png",)
) -> list[Path]:
    """Write `stem`-measures.exr, and a picture `stem`-map-`measure` of each: all whole, or none; return them.

    Parameters
    ----------
    maps : MeasureMaps
        The maps.
    folder : path
        A folder that can be written (`files.prepare_folder`).
    stem : str
        How the files' names begin.
    formats : iterable of str
        Of the pictures: png, svg, pdf.

    Raises
    ------
    InputError
        They cannot be written.
    """
    from gemrender.report.displays import save_figure
    from gemrender.report.files import file_stems, write_measures_exr

    def picture(name: str, path: Path) -> None:
        save_figure(measure_map_figure(maps, name), path, f"{maps.stone.name}: map of {name}")

    names = [measure.name for measure in maps.measures]
    files: dict[str, Callable[[Path], None]] = {
        f"{stem}-map-{safe}.{ending}": partial(picture, name)
        for name, safe in zip(names, file_stems(names), strict=True)
        for ending in dict.fromkeys(formats)
    }
    files[f"{stem}-measures.exr"] = partial(write_measures_exr, maps)
    return write_whole(Path(folder), files)


def _measure(maps: MeasureMaps, name: str) -> Measure:
    return next(measure for measure in maps.measures if measure.name == name)


def _draw_outline(axes: Axes, maps: MeasureMaps) -> None:
    """Draw the stone's outline."""
    step = -(-maps.view.resolution // MAP_PIXELS[1])
    x, y = maps.view.cell_centres()
    if min(maps.view.shape) > step:  # else there is nothing between
        axes.set_zorder(1)  # above the map
        axes.contour(x[::step], y[::step], maps.coverage[::step, ::step], [0.5], colors=_GREY, linewidths=0.8)


# ---- The panel -----------------------------------------------------------------------------------------


def _draw_panel(axes: Axes, maps: MeasureMaps, measure: Measure, drawn: tuple[_Zones | _Scale, ...]) -> None:
    """Write the measure's name, its values with their colours, and how the map was made."""
    axes.set(xlim=(0, 1), ylim=(14.5, 0))  # one unit down is one row
    axes.set_axis_off()
    axes.text(0, 0.5, measure.name, fontsize=22, fontweight="bold")
    y = 1.4
    for each in drawn:
        if isinstance(each, _Scale):
            _draw_scale(axes, each, maps, measure, y)
            y += 1.6
    colours = {
        name: colour for each in drawn if isinstance(each, _Zones) for name, colour in each.colours.items()
    }
    for key in measure.keys:
        if key in colours:
            axes.scatter(
                0.035, y, s=130, marker="s", facecolor=colours[key], edgecolor="#888888", linewidth=0.8
            )
        axes.text(0.09, y, key.replace("_", " "), fontsize=13, va="center_baseline")
        value = _value(maps.values[measure.name][key], measure.unit)
        axes.text(0.98, y, value, fontsize=13, va="center_baseline", ha="right")
        y += 0.6
    axes.text(0, 14.5, _rules(maps, measure), fontsize=9.5, color=_GREY, va="bottom", linespacing=1.3)


def _draw_scale(axes: Axes, scale: _Scale, maps: MeasureMaps, measure: Measure, y: float) -> None:
    """Draw a bar in the scale's colours, with its ends."""
    top = scale.top_of(maps, measure)
    axes.imshow(
        np.linspace(0.0, 1.0, 256)[None],
        cmap=scale.colours,
        extent=(0.0, 0.98, y + 0.35, y - 0.25),
        aspect="auto",
    )
    for x, value, align in ((0.0, 0.0, "left"), (0.49, 0.5 * top, "center"), (0.98, top, "right")):
        axes.text(x, y + 0.8, _value(value, measure.unit), fontsize=11, color=_GREY, ha=align)
    axes.set(xlim=(0, 1), ylim=(14.5, 0))


def _value(value: float, unit: str) -> str:
    if math.isnan(value):
        return "–"
    if unit == "%":
        return f"{value:.1f} %"
    return f"{value:.3g}" + {"deg": "°"}.get(unit, f" {unit}" if unit else "")


def _rules(maps: MeasureMaps, measure: Measure) -> str:
    """Say what the measure is, and how the map was made."""
    view, index = maps.view, maps.model.index
    engine = f"{maps.engine} ({maps.variant})" if maps.variant else maps.engine
    tilt = f"eye tilted by {view.tilt_deg:g}° towards azimuth {view.tilt_azimuth_deg:g}°"
    lines = [
        f"{measure.name} {measure.version}: {measure.definition}. Source: {measure.source}.",
        (f"viewer's head {maps.head_deg:g}°, " if "head" in measure.definition else "") + f"index {index:g}",
        *([tilt] if view.tilt_deg else []),
        f"{view.resolution} × {view.resolution} pixels, {engine}; figures are of the pixels",
        f"gemrender {gemrender.__version__}",
    ]
    return "\n".join(part for line in lines for part in textwrap.wrap(line, 58))


# ---- Mixtures ------------------------------------------------------------------------------------------


def _linear(colours: np.ndarray) -> np.ndarray:
    """Return colours, 0 to 255, in linear light, 0 to 1 (IEC 61966-2-1)."""
    c = colours / 255.0
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def _encoded(light: np.ndarray) -> np.ndarray:
    """Return linear light, 0 to 1, as colours, 0 to 255."""
    c = np.clip(light, 0.0, 1.0)
    return np.asarray(255.0 * np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055))

"""Results drawn onto matplotlib's axes: what `plot` of each calls."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import Observation, View, bound_text
from gemrender.report.dimensions import length_unit
from gemrender.report.displays.page import PAPER, draw_lines
from gemrender.report.displays.projection import CROWN, OBLIQUE, PAVILION, look_at, side
from gemrender.report.facets import check_colour, draw_facets, facet_classes, silhouette
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR, map_picture
from gemrender.report.lettering import name_fonts
from gemrender.report.measure_maps import measure_map_picture
from gemrender.report.tables import LEAST_SHOWN, band_names
from gemrender.report.tilt import axis_name, draw_curves
from gemrender.scoring import Score
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gemrender.beam import VirtualFacets
    from gemrender.measures.maps import MeasureMaps
    from gemrender.sweep import TiltStudy

__all__ = [
    "plot_facets",
    "plot_map",
    "plot_observation",
    "plot_score",
    "plot_stone",
    "plot_tilt",
]

_VIEWS = {"crown": CROWN, "pavilion": PAVILION, "side": side(), "oblique": OBLIQUE}


def plot_stone(stone: Stone, axes: Axes | None, view: str) -> Axes:
    """Draw a view of a stone: its edges, the outline in a heavier line."""
    _check("view", view, tuple(_VIEWS))
    axes, seen = _axes(axes), look_at(stone, _VIEWS[view])
    draw_lines(axes, seen, PAPER)
    corners = np.concatenate([*seen.visible, *seen.outline])
    axes.update_datalim(corners)
    _to_scale(axes, length_unit(stone), ("x", "y") if view in ("crown", "pavilion") else ("", ""))
    axes.autoscale_view()
    return _titled(axes, stone.name)


def plot_score(score: Score, axes: Axes | None) -> Axes:
    """Draw the shares of the view by intensity, as bars in the colours of maps."""
    axes = _axes(axes)
    names = [f"{name} %" for name in band_names(typeset=True)] + ["Rear"]
    shares = [*(band.share for band in score.bands), score.rear]
    colours = [*BAND_COLOURS, REAR_COLOUR]
    unsolved = score.trapped + score.lost
    if unsolved >= LEAST_SHOWN:
        names, shares, colours = [*names, "Trapped"], [*shares, unsolved], [*colours, UNSOLVED_COLOUR]
    bars = axes.barh(names, shares, color=colours, edgecolor="#888888", linewidth=0.6)
    axes.bar_label(bars, [f"{share:.2f}" for share in shares], padding=3)
    axes.invert_yaxis()
    axes.margins(x=0.12)
    axes.spines[["top", "right"]].set_visible(False)
    bound = "" if score.bound is None else f" ± {bound_text(score.bound)}"
    axes.set_xlabel(f"share of the view [%]; average intensity {score.average:.2f}{bound} %")
    return _titled(axes, score.name)


def plot_facets(facets: VirtualFacets, axes: Axes | None, colour: str) -> Axes:
    """Draw virtual facets as the polygons that they are."""
    check_colour(colour)
    axes = _axes(axes)
    outline = silhouette(facets.stone, facets.view)
    half = 1.02 * float(np.abs(outline).max())
    _to_scale(axes, length_unit(facets.stone), ("x", "y"))
    axes.set(xlim=(-half, half), ylim=(-half, half))
    width = axes.get_window_extent().width / axes.figure.dpi
    draw_facets(axes, facets, facet_classes(facets, colour), width / (2.0 * half), clips=True)
    return _titled(axes, facets.stone.name)


def plot_map(maps: MeasureMaps, axes: Axes | None, measure: str | None) -> Axes:
    """Draw the map of a measure; by default of the first."""
    names = tuple(of.name for of in maps.measures)
    name = names[0] if measure is None else measure
    _check("measure", name, names)
    axes = _map_axes(axes, measure_map_picture(maps, name)[0], maps.view, maps.stone)
    return _titled(axes, f"{maps.stone.name}: {name}")


def plot_observation(seen: Observation, axes: Axes | None) -> Axes:
    """Draw the map of intensity in its bands."""
    return _titled(_map_axes(axes, map_picture(seen), seen.view, seen.stone), seen.stone.name)


def plot_tilt(study: TiltStudy, axes: Axes | None, measure: str | None, axis_deg: float | None) -> Axes:
    """Draw the curves of a measure about one axis."""
    if study.is_surface:
        raise InputError("has no curves, as it is of all tilts; x has", key="axis", value=study.axis)
    curves, names = study.curves(), tuple(of.name for of in study.measures)
    name = names[0] if measure is None else measure
    _check("measure", name, names)
    axis = next(iter(curves)) if axis_deg is None else axis_deg
    _check("axis_deg", axis, tuple(curves))
    axes = _axes(axes)
    draw_curves(axes, study.measures[names.index(name)], curves[axis])
    axes.set_xlabel(f"turned about {axis_name(axis).replace(' deg', '°')} by [°]")
    return axes


def _axes(axes: Axes | None) -> Axes:
    """Return axes as they are, or new ones in a figure of their own, which notebooks show."""
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots()[1]


def _map_axes(axes: Axes | None, picture: np.ndarray, view: View, stone: Stone) -> Axes:
    axes, half = _axes(axes), view.half_width
    axes.imshow(picture, extent=(-half, half, -half, half), interpolation="nearest")
    return _to_scale(axes, length_unit(stone), ("x", "y"))


def _to_scale(axes: Axes, unit: str, names: tuple[str, str]) -> Axes:
    axes.set_aspect("equal")
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel(f"{names[0]} [{unit}]".strip())
    axes.set_ylabel(f"{names[1]} [{unit}]".strip())
    return axes


def _titled(axes: Axes, name: str) -> Axes:
    axes.set_title(name, loc="left", family=name_fonts(), parse_math=False)
    return axes


def _check(key: str, value: Any, allowed: tuple[Any, ...]) -> None:
    if value not in allowed:
        raise InputError(f"must be one of {', '.join(map(str, allowed))}", key=key, value=value)

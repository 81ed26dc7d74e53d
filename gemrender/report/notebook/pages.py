"""The HTML of each kind of result."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import Observation, bound_text
from gemrender.paths import Paths
from gemrender.report.displays.projection import CROWN, PAVILION, side
from gemrender.report.facets import facet_classes
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR, map_picture
from gemrender.report.inspection import figures_of_stone, inspect_stone
from gemrender.report.measure_maps import measure_map_picture
from gemrender.report.notebook.drawings import facets_drawing, map_pixels, stone_drawing
from gemrender.report.notebook.elements import bar, beside, box, cell, image, notes, swatch, table
from gemrender.report.tables import LEAST_SHOWN, band_name, how_text, model_text, value_text
from gemrender.scoring import Score
from gemrender.stone import Stone

if TYPE_CHECKING:
    from gemrender.beam import VirtualFacets
    from gemrender.measures.maps import MeasureMaps

__all__ = ["html_of"]

#: Widths of drawings and maps [pixels].
_STONE, _MAP = 190, 320
#: Paths and maps that are shown.
_PATHS, _MAPS = 8, 6
#: A stone of more triangles or planes is not drawn: its edges hidden by one another would take long.
_MOST_DRAWN = 3000


def html_of(thing: Any) -> str:
    """Return what notebooks show of a result.

    Parameters
    ----------
    thing : Stone, Score, Paths, VirtualFacets, MeasureMaps or Observation
        The result.
    """
    makers: dict[str, Callable[[Any], str]] = {
        "Stone": _stone, "Score": _score, "Paths": _paths, "VirtualFacets": _facets, "MeasureMaps": _maps,
        "Observation": _observation,
    }  # fmt: skip
    return next(makers[kind.__name__](thing) for kind in type(thing).__mro__ if kind.__name__ in makers)


def _stone(stone: Stone) -> str:
    lines = [*stone.notes, *(f"taken: {words}" for words in stone.assumed)]
    try:
        facts = figures_of_stone(inspect_stone(stone))
    except InputError as error:  # a material that there is not
        facts, lines = [["Facets", f"{len(stone.facets)}"]], [*lines, str(error)]
    drawn = []
    if len(stone.solid.planes) <= _MOST_DRAWN:
        drawn = [stone_drawing(stone, view, _STONE) for view in (CROWN, PAVILION, side())]
    else:
        lines.append(f"not drawn here: it has {len(stone.solid.planes)} planes")
    rows = table([cell(name), cell(words)] for name, words in facts)
    return box(stone.name, beside(*drawn, rows), notes(lines))


def _score(score: Score) -> str:
    bound = "" if score.bound is None else f"± {bound_text(score.bound)}"
    shares = [
        (swatch(colour, f"{band_name(band, typeset=True)} %"), band.share, colour)
        for colour, band in zip(BAND_COLOURS, score.bands, strict=True)
    ]
    shares.append((swatch(REAR_COLOUR, "Rear"), score.rear, REAR_COLOUR))
    shares += [
        (swatch(UNSOLVED_COLOUR, name), share, UNSOLVED_COLOUR)
        for name, share in (("Trapped", score.trapped), ("Lost", score.lost))
        if share >= LEAST_SHOWN
    ]
    most = max(share for _, share, _ in shares) or 1.0
    rows = [[cell("Average intensity"), cell(f"{score.average:.2f}"), cell(bound), ""]]
    rows += [[name, cell(f"{share:.2f}"), cell(bound), bar(share / most, of)] for name, share, of in shares]
    parts = [table(rows, ("Share of the view by intensity", "%", "", ""), numbers=(1, 2))]
    if score.measures:
        values = [
            [
                cell(of.name if first else ""),
                cell("" if key == "value" else key.replace("_", " ")),
                cell(value_text(value, of.bound)),
                cell("" if of.bound is None or key not in of.values else f"± {bound_text(of.bound)}"),
            ]
            for of in score.measures
            for first, (key, value) in _marked(of.values | of.details)
            if isinstance(value, int | float)
        ]
        parts.append(table(values, ("Measure", "", "Value", ""), numbers=(2, 3)))
    lines = [how_text(score), model_text(score)]
    if score.tilt_deg:
        lines.append(f"eye tilted by {score.tilt_deg:g}° towards azimuth {score.tilt_azimuth_deg:g}°")
    lines += [*score.notes, *(f"taken: {words}" for words in score.assumed)]
    return box(score.name, beside(*parts), notes(lines))


def _marked(values: dict[str, Any]) -> list[tuple[bool, tuple[str, Any]]]:
    """Return keys and values, the first of them marked."""
    return [(number == 0, item) for number, item in enumerate(values.items())]


def _paths(paths: Paths) -> str:
    from gemrender.observation import RayStatus

    def facet(number: int) -> str:
        return paths.stone.facet_names[number].replace("_", " ") if number >= 0 else "–"

    def degrees(cosine: float) -> str:
        return f"{math.degrees(math.acos(min(cosine, 1.0))):.2f}°" if cosine > 0.0 else "–"

    rows = []
    for k in range(min(len(paths), _PATHS)):
        point, direction = paths.exit_point[k].real, paths.exit_direction[k].real
        rows.append([
            cell(f"{k}"),
            cell(f"{paths.area[k].real:.3g}"),
            cell(f"{paths.weight[k].real:.3g}"),
            cell(RayStatus(int(paths.status[k])).name.lower()),
            cell(f"{paths.reflections[k]}"),
            cell(facet(int(paths.entry_facet[k]))),
            cell(facet(int(paths.exit_facet[k]))),
            cell(degrees(float(paths.cos_entry[k].real))),
            cell(degrees(float(paths.cos_exit[k].real))),
            cell(", ".join(f"{x:.3f}" for x in point.tolist())),
            cell(", ".join(f"{x:.3f}" for x in direction.tolist())),
        ])  # fmt: skip
    heads = (
        "", "Area", "Weight", "Status", "Reflections", "Entry", "Exit", "Angle at entry", "at exit",
        "Exit point", "Exit direction",
    )  # fmt: skip
    left = len(paths) - len(rows)
    lines = [f"and {left} more; all of them: to_pandas(), to_xarray()"] if left > 0 else []
    return box(
        f"Paths of {paths.stone.name}",
        table(rows, heads, numbers=(0, 1, 2, 4, 7, 8)),
        notes(lines),
        below=f"{len(paths)} paths, followed back from the eye; lengths in the stone's unit, angles in air",
    )


def _facets(facets: VirtualFacets) -> str:
    classes = facet_classes(facets, "intensity")
    drawn, left_out = facets_drawing(facets, classes, _MAP)
    whole = facets.area[facets.paths.partial_reflections == 0].sum() or 1.0
    shares = np.bincount(classes.of, 100.0 * facets.area[classes.drawn] / whole, len(classes.names))
    numbers = np.bincount(classes.of, minlength=len(classes.names))
    rows = [
        [swatch(colour, name), cell(f"{number}"), cell(f"{share:.2f}")]
        for colour, name, number, share in zip(
            classes.colours, classes.names, numbers.tolist(), shares.tolist(), strict=True
        )
        if number or name != "Trapped"
    ]
    lines = [f"{_model_line(facets)}{_view_line(facets)}"]
    if facets.parts > 1:
        lines.append(f"one of {facets.parts} alike parts of the view was traced, and is drawn")
    if left_out:
        lines.append(
            f"drawn are the {len(classes.drawn) - left_out} largest; {left_out} smaller ones are left out"
        )
    return box(
        f"Virtual facets of {facets.stone.name}",
        beside(drawn, table(rows, ("Intensity", "Number", "% of the view"), numbers=(1, 2))),
        notes(lines),
        below=f"{len(classes.drawn)} virtual facets; grey is light near the girdle, which no polygon tells",
    )


def _maps(maps: MeasureMaps) -> str:
    parts = []
    for measure in maps.measures[:_MAPS]:
        picture = measure_map_picture(maps, measure.name)[0]
        shown = image(map_pixels(picture, maps.coverage), _MAP * 2 // 3, f"map of {measure.name}")
        values = [
            [cell(key.replace("_", " ")), cell(value_text(value, None))]
            for key, value in list(maps.values[measure.name].items())[:8]
        ]
        parts.append(f"<b>{cell(measure.name)}</b><br/>{shown}{table(values, numbers=(1,))}")
    left = len(maps.measures) - len(parts)
    lines = [f"{_model_line(maps)}{_view_line(maps)}, by pixels ({maps.engine})"]
    if left > 0:
        lines.append(f"and {left} more: {', '.join(of.name for of in maps.measures[_MAPS:])}")
    return box(
        f"Maps of {maps.stone.name}",
        beside(*parts),
        notes(lines),
        below=f"{maps.view.resolution} × {maps.view.resolution} pixels",
    )


def _observation(seen: Observation) -> str:
    from gemrender.scoring import score_observation

    pixels = map_pixels(map_picture(seen), seen.coverage)
    shown = image(pixels, _MAP, f"intensity of {seen.stone.name}")
    return box(f"View of {seen.stone.name}", beside(shown, _score(score_observation(seen))))


def _model_line(of: Any) -> str:
    """Say by which model something was traced."""
    model = of.model
    law = {"gubelin": "Gübelin's table", "exact": "Fresnel's equations"}[model.fresnel]
    return f"index {model.index:g}, {law}, rear light by {model.rear}"


def _view_line(of: Any) -> str:
    """Say that the eye is tilted, where it is."""
    view = of.view
    return f", eye tilted by {view.tilt_deg:g}° towards {view.tilt_azimuth_deg:g}°" if view.tilt_deg else ""

"""The report: stones in 3D, their maps, and the ray behind every point of them, in one HTML file.

The page fetches nothing: style, scripts, three.js and the data are all in the file, and its content security
policy forbids the rest. The path of a ray is traced in the page, by `assets/tracer.js`, with the rules of
`gemrender.reference`; the map is the observation's.
"""

from __future__ import annotations

import base64
import html
import json
import math
import os
import re
import tempfile
import zlib
from collections.abc import Iterable, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.engines import DEFAULT_MEMORY_LIMIT, DEFAULT_TIME_LIMIT
from gemrender.errors import InputError
from gemrender.observation import Model, Observation, RayStatus, View
from gemrender.optics.fresnel import (
    GUBELIN_ANGLES_DEG,
    GUBELIN_REFLECTED,
    LEAST_TOTAL,
    critical_angle_deg,
)
from gemrender.report.dimensions import dimensions, length_unit
from gemrender.report.displays.ray_colours import RAY_COLOURS
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR
from gemrender.report.page_table import page_table
from gemrender.report.studied import Study
from gemrender.report.tables import LEAST_SHOWN, band_name, how_text, model_text
from gemrender.scoring import Score
from gemrender.stone import MeshSolid, Stone, tessellate
from gemrender.stone.facets import LEVEL
from gemrender.writing import write_whole

__all__ = [
    "MOST_STONES",
    "Shown",
    "check_number",
    "check_target",
    "common_data",
    "report_html",
    "write_report",
]

#: A stone of a page: its maps, and what measures say of it; by default what the maps tell.
Shown = Observation | tuple[Observation, Study]

#: Most stones of a report: each takes 0.2 MB of the file, and a column or a row of the page.
MOST_STONES = 24
#: Most pixels a side of the map in the page; of larger maps every second, third, ... pixel is kept.
MAP_PIXELS = 1024
#: Steps of the map's intensities per per cent. They are rounded down, which keeps every pixel in its band.
INTENSITY_STEPS = 200
#: Codes of a pixel that has no intensity: rear light, neither (trapped or lost), outside the stone.
_REAR, _UNSOLVED, _OUTSIDE = 65001, 65002, 65003
#: Most virtual facets that are outlined: each takes some 60 bytes.
MOST_OUTLINES = 20_000
#: Kinds of the largest ones that are listed.
MOST_ALIKE = 8
#: Straight pieces of a round girdle in the drawing.
_PIECES = 128
#: What lengths of a stone count, by `length_unit`, in the plural.
_UNITS = {"girdle radius": "girdle radii", "half length": "half lengths"}

#: Scripts of the page in `assets`, each after those that it takes names from.
SCRIPTS = (
    "tracer", "dom", "choices", "scores", "tilts",
    "state", "light", "ray", "stone", "stage", "map", "card", "page",
)  # fmt: skip

_ASSETS = resources.files("gemrender.report").joinpath("assets")


def write_report(stones: Iterable[Shown], path: str | os.PathLike[str], further: str = "") -> Path:
    """Write the report of some stones, whole or not at all; a file that is there is replaced.

    Parameters
    ----------
    stones : iterable of Observation, or of (Observation, Study)
        One for each stone, in the order of the page; taken one after the other, and no maps are kept.
    path : str or path-like
        The HTML file to write.
    further : str
        HTML that stands beneath the stones, as of `gemrender.report.page_sections`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        No stones, too many, or a file that cannot be written.
    """
    target = check_target(path)
    page = report_html(stones, further).encode("utf-8", errors="replace")
    try:
        write_whole(target.parent, {target.name: lambda file: file.write_bytes(page)})
    except InputError as error:
        raise _refused(path, error.allowed) from error
    return target


def check_number(stones: int) -> None:
    """See that a page holds so many stones.

    Raises
    ------
    InputError
        None, or too many.
    """
    if not 1 <= stones <= MOST_STONES:
        raise InputError(f"a report takes from 1 to {MOST_STONES} stones, got {stones}", key="stone")


def check_target(path: str | os.PathLike[str]) -> Path:
    """See that the report can be written there, before any work is done for it; make its folder.

    Raises
    ------
    InputError
        The path names no file that can be written.
    """
    name = os.fspath(path)
    if not name.strip():
        raise _refused(name, "must be the name of an HTML file")
    try:
        target = Path(name).resolve()
        if target.is_dir():
            raise _refused(name, "must be a file; this is a folder")
        if target.exists() and not target.is_file():  # a device, a pipe
            raise _refused(name, "must be a regular file")
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target.parent):
            pass
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links; a name with a null character
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise _refused(name, f"cannot be written: {reason}") from error
    return target


def report_html(stones: Iterable[Shown], further: str = "") -> str:
    """Return the report of some stones as one HTML page that needs nothing else; parameters as above.

    Raises
    ------
    InputError
        No stones, or too many.
    """
    data = _data(stones)
    licence = _asset("LICENSE-three.txt").strip()
    parts = {
        "title": html.escape(f"{_title([stone['name'] for stone in data['stones']])} – gemrender"),
        "style": _asset("page.css"),
        "further": further,
        "data": _json(data),
        "three": f"/*!\n{licence}\n*/\n{_asset('three.min.js')}",
        "scripts": "\n".join(f"<script>\n{_asset(f'{name}.js')}\n</script>" for name in SCRIPTS),
    }
    # In one pass: nothing that is put in is looked at again.
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _asset("page.html"))


def _refused(path: str | os.PathLike[str], reason: str) -> InputError:
    return InputError(reason, key="out", value=os.fspath(path))


def _asset(name: str) -> str:
    return _ASSETS.joinpath(name).read_text(encoding="utf-8")


def _title(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _json(value: Any) -> str:
    """Return JSON that no HTML parser takes for anything else."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


# ---- What the page is told -----------------------------------------------------------------------------


def _data(shown: Iterable[Shown]) -> dict[str, Any]:
    stones: list[dict[str, Any]] = []
    studies: list[Study] = []
    for of in shown:
        check_number(len(stones) + 1)
        observation, study = (of, Study.of(of)) if isinstance(of, Observation) else of
        studies.append(study)
        stones.append(
            {
                "solid": traced_solid(observation.stone),
                **traced_as(observation.model, observation.view),
                **_shown(observation.stone),
                **_scored(observation, study.score),
            }
        )
        del of, observation  # before the next one is made
    check_number(len(stones))
    return {
        **common_data(),
        "stones": stones,
        "table": page_table(studies),
    }


def common_data() -> dict[str, Any]:
    """Return what pages are told whatever they show, for JSON: optics, colours, and codes of maps."""
    return {
        "generator": f"gemrender {gemrender.__version__}",
        "optics": optics(),
        "colours": {
            "bands": BAND_COLOURS,
            "rear": REAR_COLOUR,
            "unsolved": UNSOLVED_COLOUR,
            "rays": RAY_COLOURS,
        },
        "codes": {"steps": INTENSITY_STEPS, "rear": _REAR, "unsolved": _UNSOLVED, "outside": _OUTSIDE},
    }


def optics() -> dict[str, Any]:
    """Return what `tracer.js` needs that is the same for every stone."""
    return {
        "gubelinAngles": GUBELIN_ANGLES_DEG.tolist(),
        "gubelinReflected": GUBELIN_REFLECTED.tolist(),
        "leastTotal": LEAST_TOTAL,
        "level": LEVEL,
    }


def traced_solid(stone: Stone) -> dict[str, Any]:
    """Return the surfaces that `tracer.js` traces, their numbers to the last bit."""
    solid, mesh = stone.solid, None
    if isinstance(solid, MeshSolid):
        mesh = {"vertices": solid.vertices.tolist(), "triangles": solid.triangles.tolist()}
    return {
        "planes": solid.planes.tolist(),
        "planeFacet": solid.facet.tolist(),
        "round": solid.is_round,
        "mesh": mesh,
    }


def traced_as(model: Model, view: View) -> dict[str, Any]:
    """Return the rules that `tracer.js` traces by, and from where."""
    return {
        "model": {
            "index": model.index,
            "fresnel": model.fresnel,
            "rear": model.rear,
            "intensity": model.intensity,
            "maxReflections": model.max_reflections,
            "ground": model.ground,
        },
        "view": {"basis": view.basis().tolist(), "halfWidth": view.half_width, "tilt": view.tilt_deg},
    }


def _shown(stone: Stone) -> dict[str, Any]:
    """Return the stone's drawing: its mesh, and its proportions in words and numbers."""
    mesh = tessellate(stone, _PIECES)
    last = len(stone.facets) - 1
    has_wall = len(stone.facet_normals) == last  # a girdle that is not one plane
    is_brilliant = stone.labelled_vertices is not None
    return {
        "name": stone.name,
        "unit": _UNITS[length_unit(stone)],
        "facetNames": stone.facet_names,
        "wall": last if has_wall else None,
        "round": stone.is_round,
        "measured": is_brilliant and stone.proportions is None,
        "mesh": {
            "vertices": mesh.vertices.round(6).tolist(),
            "faces": mesh.faces.tolist(),
            "facets": mesh.face_facet.tolist(),
        },
        "proportions": _proportions(stone),
        "proportionsText": (
            "Per cent of the girdle’s diameter; star and lower-half length as on a laboratory report."
            if is_brilliant
            else "Per cent of the width; the crown above the girdle’s highest point, the pavilion below its "
            "lowest."
        ),
    }


def _scored(observation: Observation, result: Score) -> dict[str, Any]:
    """Return the map and what it scores."""
    how = how_text(result)
    if result.tilt_deg:
        how += f", the eye tilted by {result.tilt_deg:g}° towards azimuth {result.tilt_azimuth_deg:g}°"
    unsolved = result.trapped + result.lost
    return {
        "map": _map(observation),
        "virtualFacets": _virtual_facets(observation, result),
        "score": {
            "average": result.average,
            "rear": result.rear,
            "unsolved": unsolved if unsolved >= LEAST_SHOWN else 0,
            "bands": [
                {"name": band_name(band, typeset=True), "low": band.low, "share": band.share}
                for band in result.bands
            ],
        },
        "material": observation.stone.material if isinstance(observation.stone.material, str) else None,
        "criticalAngle": critical_angle_deg(result.index),
        "modelText": model_text(result),
        "engineText": how,
    }


def _virtual_facets(observation: Observation, result: Score) -> dict[str, Any] | None:
    """Return the virtual facets, the largest first, where the engine knows them.

    `outlines` has x, y, x, y ... of each, `alike` groups of the largest ones that are of one size and one
    intensity, such as images of each other: `share` of each [% of the view], `intensity` [%], `rear`, and
    `members`, numbers of outlines.
    """
    if result.facets is None:
        return None
    from gemrender.beam import Budget, trace_facets

    budget = Budget(DEFAULT_TIME_LIMIT, DEFAULT_MEMORY_LIMIT)
    facets = trace_facets(observation.stone, view=observation.view, model=observation.model, budget=budget)
    shown = np.argsort(-facets.area, kind="stable")[:MOST_OUTLINES]
    shares, intensity = 100.0 * facets.area / facets.area.sum(), facets.primary_intensity
    alike: dict[tuple[Any, ...], dict[str, Any]] = {}
    for number, i in enumerate(shown.tolist()):
        if not facets.is_counted[i]:
            continue
        is_rear = bool(facets.rear_mask[i])
        key = (f"{shares[i]:.5e}", f"{intensity[i]:.4f}", is_rear)
        if key not in alike and len(alike) == MOST_ALIKE:
            break
        kind = {"share": float(shares[i]), "intensity": float(intensity[i]), "rear": is_rear, "members": []}
        alike.setdefault(key, kind)["members"].append(number)
    return {
        "number": result.facets.number,
        "outlines": [facets.polygon(i).round(4).ravel().tolist() for i in shown],
        "alike": list(alike.values()),
    }


def _map(observation: Observation) -> dict[str, Any]:
    """Return the map's pixels, coded in 16 bits, filtered by row, deflated, as base64.

    Pixel (row, column) of it is the ray through x = start + pitch column, y = -start - pitch row.
    """
    view = observation.view
    stride = math.ceil(view.resolution / MAP_PIXELS)
    kept = slice(stride // 2, None, stride)
    status, rear = observation.status[kept, kept], observation.rear_mask[kept, kept] > 0
    steps = np.floor(observation.primary_intensity[kept, kept].astype(np.float64) * INTENSITY_STEPS)
    codes = np.clip(steps, 0, _REAR - 1).astype(np.int32)
    codes[rear] = _REAR
    codes[(status == RayStatus.TRAPPED) | (status == RayStatus.LOST)] = _UNSOLVED
    codes[status == RayStatus.MISSED] = _OUTSIDE
    # Differences along the rows, high and low bytes apart: neighbours are alike, and deflate finds it.
    differences = np.diff(codes, axis=1, prepend=0).astype(np.uint16)
    planes = np.stack([differences >> 8, differences & 255]).astype(np.uint8)
    x = view.cell_centres()[0][kept]
    return {
        "size": len(x),
        "start": float(x[0]),
        "pitch": 2 * view.half_width / view.resolution * stride,
        "data": base64.b64encode(zlib.compress(planes.tobytes())).decode(),
    }


#: Rows of the table of proportions: what it calls each dimension, and its key.
_ROWS = (
    ("Length to width", "length_to_width"),
    ("Table size", "table"),
    ("Crown angle", "crown_angle"),
    ("Crown height", "crown_height"),
    ("Pavilion angle", "pavilion_angle"),
    ("Pavilion depth", "pavilion_depth"),
    ("Girdle thickness", "girdle_thickness"),
    ("Total depth", "total_depth"),
    ("Star length", "star"),
)


def _proportions(stone: Stone) -> list[dict[str, Any]]:
    """Return rows of the table of proportions: name, value, unit; of a measured stone their means."""
    known = dimensions(stone)
    rows = [(name, known[key].value, known[key].unit) for name, key in _ROWS if key in known]
    if "lower_girdle_contact" in known:
        rows.append(("Lower-half length", 100 - known["lower_girdle_contact"].value, "%"))
    return [{"name": name, "value": round(value, 2), "unit": unit} for name, value, unit in rows]

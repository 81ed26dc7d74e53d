"""A film of a stone that is tilted: a map of it, and the curves with a mark that goes along."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gemrender.errors import InputError
from gemrender.mapping import measure_maps
from gemrender.measures import Measure, measure_named
from gemrender.measures.maps import has_map
from gemrender.observation import View
from gemrender.render.film_files import check_film, encode_film
from gemrender.render.formats import FILM_SUFFIXES
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR
from gemrender.report.lettering import name_fonts, save_png
from gemrender.report.measure_maps import measure_map_picture
from gemrender.report.tilt import axis_name, draw_curves
from gemrender.scoring import BAND_EDGES
from gemrender.stone import Stone
from gemrender.sweep import TiltStudy
from gemrender.sweep.poses import Pose
from gemrender.sweep.tilt import TiltedValues
from gemrender.writing import check_place, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["check_tilt_film", "write_tilt_film"]

#: Size of a frame [pixels], and pixels a side of its map.
_WIDTH, _HEIGHT, _MAP = 1280, 640, 512
_DPI = 100
#: To and fro takes about so long [s], at so many frames a second.
_SECONDS, _FPS = 6.0, (4.0, 30.0)
#: What options say that is another matter for a frame.
_NO_RULES = ("resolution", "tilt", "tilt_azimuth", "bound")
#: Most measures whose curves have room beside the map.
_MOST_PANELS = 4


def check_tilt_film(path: Path, poses: Sequence[Pose], measures: int) -> None:
    """Check that a film can be made, before any work is done for it.

    Parameters
    ----------
    path : Path
        The film.
    poses : sequence of Pose
        What it shows, as `tilt_poses` has them.
    measures : int
        Number of measures.

    Raises
    ------
    InputError
        Its ending is no film's, it cannot be written, or there are too many measures or axes.
    BackendError
        The library that writes it is not installed.
    """
    if path.suffix.lower() not in FILM_SUFFIXES:
        raise InputError(f"must end in {', '.join(FILM_SUFFIXES)}", key="film", value=str(path))
    if measures > _MOST_PANELS:
        raise InputError(f"shows up to {_MOST_PANELS} measures", key="film", value=str(path))
    if len({pose.axis_deg for pose in poses}) > 1:
        raise InputError(
            "shows turns about one axis: x, y, or one by its azimuth", key="film", value=str(path)
        )
    check_place(path)
    order = _to_and_fro(len(poses))
    check_film(path, _WIDTH, _HEIGHT, len(order), _fps(len(order)))


def write_tilt_film(
    study: TiltStudy,
    stone: Stone,
    path: Path,
    *,
    options: dict[str, Any] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write a film of a stone that is tilted to and fro, about one axis; return its path.

    It shows the map of the first measure that has one; where none has, that of the paper's score.

    Parameters
    ----------
    study : TiltStudy
        What was found, about one axis.
    stone : Stone
        The stone that was studied.
    path : Path
        The film, ending in .mp4, .gif or .webp.
    options : dict, optional
        Further arguments of `gemrender.measure_maps`: engine, rear ...; the bound makes no difference.
    progress : callable, optional
        Called with the share done, 0 to 1.

    Raises
    ------
    InputError, BackendError
        As for `check_tilt_film` and `measure_maps`, or the film cannot be written.
    """
    poses = [found.pose for found in study.found]
    check_tilt_film(path, poses, len(study.measures))
    order = _to_and_fro(len(poses))
    with tempfile.TemporaryDirectory(prefix="gemrender-film-") as folder:
        files = [Path(folder, f"{k:05d}.png") for k in range(len(poses))]
        for k, found in enumerate(study.found):
            save_png(_frame(study, stone, found, options or {}), files[k])
            if progress is not None:
                progress((k + 1) / len(poses))
        title = f"{study.name}, turned about {axis_name(poses[0].axis_deg)}"
        frames = [files[k] for k in order]
        return write_whole(
            path.parent,
            {path.name: lambda made: encode_film(made, frames, _fps(len(order)), title=title)},
        )[0]


def _to_and_fro(poses: int) -> list[int]:
    """Return the poses of a film that goes round for ever: from upright to one side, the other, and back."""
    forth = list(range(poses))
    order = forth + forth[-2:0:-1]
    middle = poses // 2
    return order[middle:] + order[:middle]


def _fps(frames: int) -> float:
    low, high = _FPS
    return min(max(frames / _SECONDS, low), high)


def _frame(study: TiltStudy, stone: Stone, found: TiltedValues, options: dict[str, Any]) -> Figure:
    from matplotlib.figure import Figure

    tilt, azimuth = found.pose.eye
    reach = max(stone.half_width, stone.reach)  # one scale for all of them
    view = View(resolution=_MAP, half_width=reach, tilt_deg=tilt, tilt_azimuth_deg=azimuth)
    rules = {key: value for key, value in options.items() if key not in _NO_RULES}
    shown = next((of for of in study.measures if has_map(of)), measure_named("inoue"))
    maps = measure_maps(stone, measures=[shown], head=study.head_deg, view=view, **rules)
    picture = measure_map_picture(maps, shown.name)[0]

    figure = Figure(figsize=(_WIDTH / _DPI, _HEIGHT / _DPI), dpi=_DPI)
    figure.text(0.02, 0.94, study.name, fontsize=15, fontweight="bold", family=name_fonts(), parse_math=False)
    turn = f"{found.pose.turn_deg:+.4g}".replace("-", "−")
    axis = axis_name(found.pose.axis_deg).replace(" deg", "°")
    figure.text(0.02, 0.895, f"turned about {axis} by {turn if tilt else '0'}°", fontsize=11, color="#666666")
    _draw_key(figure, shown)
    axes = figure.add_axes((0.01, 0.02, 0.42, 0.84))
    axes.imshow(picture, interpolation="antialiased")
    axes.set_axis_off()
    height = 0.94 / len(study.measures)
    for row, of in enumerate(study.measures):
        axes = figure.add_axes((0.49, 0.99 - (row + 1) * height + 0.07, 0.42, height - 0.14))
        draw_curves(axes, of, study.found)
        axes.axvline(found.pose.turn_deg, color="#d6322d", linewidth=1.4)
    axes.set_xlabel(f"turned about {axis} by [°]", fontsize=10)
    return figure


def _draw_key(figure: Figure, shown: Measure) -> None:
    """Say what the map shows; of the paper's score its colours, by the bands' lower edges [%]."""
    from matplotlib.colors import to_rgb

    if shown.name != "inoue":
        figure.text(0.43, 0.94, f"map of {shown.name}", fontsize=11, color="#666666", ha="right")
        return
    names = [*(f"≥{edge:g}" for edge in BAND_EDGES), "rear"]
    axes = figure.add_axes((0.22, 0.945, 0.21, 0.028))
    axes.imshow([[to_rgb(colour) for colour in (*BAND_COLOURS, REAR_COLOUR)]], aspect="auto")
    axes.set_xticks(range(len(names)), names, fontsize=9)
    axes.set_yticks([])
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    figure.text(0.22, 0.978, "intensity [%]", fontsize=9, color="#666666")

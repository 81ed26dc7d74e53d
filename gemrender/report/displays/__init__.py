"""Displays of a stone: the paper's (photos 1 to 8), from the outline to the map, and its virtual facets."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gemrender.engines import DEFAULT_ENGINE, DEFAULT_RESOLUTION, DEFAULT_VARIANT
from gemrender.errors import InputError
from gemrender.report.displays.fan import fan_figure
from gemrender.report.displays.rays import FAN_RAYS, rays_figure
from gemrender.stone import Stone
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gemrender.observation import Observation

__all__ = ["DISPLAYS", "FORMATS", "draw", "save_figure", "write_display"]

#: What can be shown.
DISPLAYS = ("outline", "vertices", "shape", "triangles", "rays", "fan", "map", "facets")
#: Formats of files.
FORMATS = ("png", "svg", "pdf")


def draw(
    stone: Stone,
    display: str,
    *,
    at: Sequence[Sequence[float]] | None = None,
    azimuth_deg: float = 0.0,
    rays: int = FAN_RAYS,
    fresnel: str | None = None,
    rear: str | None = None,
    intensity: str = "primary",
    engine: str = DEFAULT_ENGINE,
    variant: str = DEFAULT_VARIANT,
    resolution: int = DEFAULT_RESOLUTION,
    observation: Observation | None = None,
    colour: str = "intensity",
) -> Figure:
    """Draw one display of a stone.

    Parameters
    ----------
    stone : Stone
        The stone.
    display : str
        One of `DISPLAYS`. Vertices are a round brilliant's 57, of others the corners; triangles its 78, of
        others the facets by their names.
    at : (n, 2) array_like, optional
        For rays: x and y in the top view [stone's unit]; by default a bright, a weak and a rear ray.
    azimuth_deg : float
        For rays the azimuth to the right in the side view, for a fan that of its section [deg].
    rays : int
        For a fan: number of rays.
    fresnel, rear, intensity : str
        For rays, a fan, the map and virtual facets: the model's options, as for `observe`.
    engine, variant, resolution
        For the map: what traces it, as for `observe`.
    observation : Observation, optional
        For the map: what to draw, if it has been traced already.
    colour : str
        For virtual facets: what their colours tell, as for `facets_figure`.

    Returns
    -------
    matplotlib.figure.Figure
        To be saved at its own resolution (`write_display`).

    Raises
    ------
    InputError
        Unknown display, a point that is no pair of finite numbers or lies outside the stone, an option
        outside what is allowed, or virtual facets of a stone that is not convex.
    BackendError
        For the map and virtual facets: what traces them cannot run here.
    """
    if display not in DISPLAYS:
        raise InputError(f"must be one of {', '.join(DISPLAYS)}", key="what", value=display)
    if display in ("rays", "fan", "facets"):
        from gemrender.observation import Model

        model = Model.of(stone, fresnel=fresnel, rear=rear, intensity=intensity)
        if display == "facets":
            from gemrender.report.facets import facets_figure

            return facets_figure(stone, colour=colour, model=model)
        if display == "rays":
            return rays_figure(stone, at, model=model, azimuth_deg=azimuth_deg)
        return fan_figure(stone, azimuth_deg=azimuth_deg, rays=rays, model=model)
    if display == "map":
        return _map(stone, observation, engine=engine, variant=variant, resolution=resolution,
                    fresnel=fresnel, rear=rear, intensity=intensity)  # fmt: skip
    return _drawing(stone, display)


def write_display(
    stone: Stone,
    display: str,
    folder: str | os.PathLike[str],
    stem: str,
    *,
    formats: Iterable[str] = ("png",),
    **options: Any,
) -> list[Path]:
    """Draw one display of a stone and write it as `stem`-`display`.png, .svg or .pdf: all of them or none.

    Parameters
    ----------
    stone, display
        As for `draw`.
    folder : path
        A folder that can be written (`files.prepare_folder`).
    stem : str
        How the files' names begin.
    formats : iterable of str
        Of `FORMATS`.
    **options
        As for `draw`.

    Raises
    ------
    InputError
        As for `draw`; or the files cannot be written.
    """
    endings = tuple(dict.fromkeys(formats))
    for ending in endings:
        if ending not in FORMATS:
            raise InputError(f"must be one of {', '.join(FORMATS)}", key="format", value=ending)
    figure = draw(stone, display, **options)
    title = f"{stone.name}: {display}"
    return write_whole(
        Path(folder),
        {f"{stem}-{display}.{ending}": lambda path: save_figure(figure, path, title) for ending in endings},
    )


def save_figure(figure: Figure, path: Path, title: str) -> None:
    """Save a figure in the format that its file's ending says; the same picture is the same file."""
    from matplotlib import rc_context

    ending = path.suffix[1:]
    # Without the date.
    dates: dict[str, dict[str, None]] = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    metadata = {"Title": title, **dates[ending]}
    # Letters look alike everywhere: as shapes, or with their font (as TrueType, which journals ask for).
    letters = {"svg.fonttype": "path", "svg.hashsalt": "gemrender", "pdf.fonttype": 42}
    with rc_context(letters), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        figure.savefig(path, format=ending, dpi=figure.dpi, metadata=metadata)


def _drawing(stone: Stone, display: str) -> Figure:
    from gemrender.cuts.families.family import Family

    is_brilliant = stone.labelled_vertices is not None
    if display == "shape":
        from gemrender.report.displays.shape import shape_figure as figure
    elif display == "outline":
        if is_brilliant:
            from gemrender.report.brilliant.outline import brilliant_outline_figure as figure
        elif isinstance(stone.cut, Family):
            from gemrender.report.displays.family_outline import family_outline_figure as figure
        else:
            from gemrender.report.displays.outline import outline_figure as figure
    elif display == "vertices":
        if is_brilliant:
            from gemrender.report.brilliant.vertices import brilliant_vertices_figure as figure
        else:
            from gemrender.report.displays.corners import corners_figure as figure
    elif is_brilliant:
        from gemrender.report.brilliant.triangles import brilliant_triangles_figure as figure
    else:
        from gemrender.report.displays.polygons import polygons_figure as figure
    return figure(stone)


def _map(stone: Stone, observation: Observation | None, **options: Any) -> Figure:
    from gemrender.engines import observe
    from gemrender.report.figures import map_figure

    if observation is None:
        observation = observe(stone, **options)
    elif observation.stone is not stone:
        raise ValueError("the observation is of another stone")
    return map_figure(observation)

"""A fan of rays across a section, as gemmology books draw it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import Model, RayStatus
from gemrender.reference import RayPath, full_paths
from gemrender.report.displays.page import DARK, Page, draw_lines, stone_extent
from gemrender.report.displays.projection import CROWN, Projection, look_at, section, side
from gemrender.report.displays.ray_colours import draw_scale, ray_colour, text_colour
from gemrender.report.displays.rays import FAN_RAYS, check_fan, draw_head
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fan_figure", "fan_points"]

SCALE = 3.0  # inch per unit
#: Width of a digit, as a share of its size.
_LETTER = 0.64


def fan_points(stone: Stone, azimuth_deg: float = 0.0, rays: int = FAN_RAYS) -> np.ndarray:
    """Return points equally spaced across the diameter along an azimuth, (n, 2) [stone's unit].

    They are the middles of equal parts: none lies on the girdle, and an even number spares the culet.
    """
    check_fan(rays)
    outline = section(stone, azimuth_deg)
    low, high = outline[:, 0].min(), outline[:, 0].max()
    along = low + (high - low) * (np.arange(rays) + 0.5) / rays
    azimuth = np.radians(azimuth_deg)
    return np.asarray(along[:, None] * np.array([np.cos(azimuth), np.sin(azimuth)]))


def fan_figure(
    stone: Stone, *, azimuth_deg: float = 0.0, rays: int = FAN_RAYS, model: Model | None = None
) -> Figure:
    """Draw rays across a section, as they are seen from the side that the section faces.

    Parameters
    ----------
    stone : Stone
    azimuth_deg : float
        Azimuth of the section, to the right in the drawing [deg]; by default through a main.
    rays : int
        Number of rays.
    model : Model, optional
        The optical model; by default that of the stone's material.
    """
    if not np.isfinite(azimuth_deg):
        raise InputError("must be a finite angle [deg]", key="azimuth", value=azimuth_deg)
    points = fan_points(stone, azimuth_deg, rays)
    paths = full_paths(stone, points, model=model)
    _, high, radius = stone_extent(stone)
    projection = side(azimuth_deg)
    reach = 0.36
    top = high + reach
    routes = {id(path): _fan_route(path, projection, top, reach) for path in paths if len(path.points)}
    ends = np.concatenate([projection.flat(stone.vertices), *routes.values()])
    (left, bottom), right = ends.min(axis=0) - 0.08, ends[:, 0].max() + 0.08
    left, right = min(left, -right), max(right, -left)
    column = (right - left) * SCALE
    panel, gap, small = 3.6, 0.35, 1.3
    tall = max((top + 0.2 - bottom) * SCALE, 5.3)
    height = tall + Page.TITLE + Page.MARGIN
    page = Page(
        stone,
        f"{rays} rays across the section at azimuth {azimuth_deg:g}°".replace("-", "−"),
        width=column + gap + panel + 2 * Page.MARGIN,
        height=height,
        theme=DARK,
    )
    axes = page.view(
        Page.MARGIN, Page.MARGIN, column, tall, scale=SCALE,
        centre=((left + right) / 2, top + 0.2 - tall / SCALE / 2),
    )  # fmt: skip
    draw_lines(axes, look_at(stone, projection), DARK, strength=0.28)
    outline = section(stone, azimuth_deg)
    axes.fill(*outline.T, facecolor="#1a222c", edgecolor="none", zorder=0.5)
    axes.plot(*np.concatenate([outline, outline[:1]]).T, color=DARK.ink, linewidth=1.5, zorder=5)
    for path in sorted(paths, key=_brightness):
        if id(path) in routes:
            _draw_fan_ray(axes, path, routes[id(path)])
    _write_fan_labels(axes, paths, projection, top)

    x = Page.MARGIN + column + gap
    plan = page.view(x, height - Page.TITLE - 3.0, panel, 3.0, scale=small, centre=(0.0, 0.0))
    draw_lines(plan, look_at(stone, CROWN), DARK, strength=0.5)
    ends = np.array([-1.1, 1.1])[:, None] * projection.right[:2] * radius
    plan.plot(*ends.T, color=DARK.accent, linewidth=0.9, zorder=5, linestyle=(0, (8, 3, 2, 3)))
    plan.scatter(*points.T, s=11, color=[ray_colour(path) for path in paths], zorder=6, linewidths=0)
    _write_fan_notes(page.axes(x, height - Page.TITLE - 4.2, panel, 1.1), paths)
    draw_scale(page, x, Page.MARGIN + 0.4, panel)
    return page.figure


def _brightness(path: RayPath) -> float:
    return path.primary_intensity


def _fan_route(path: RayPath, projection: Projection, top: float, reach: float) -> np.ndarray:
    """Points of a ray in the drawing, from the eye's end to where the light comes from."""
    flat = projection.flat(path.points)
    route = [np.array([flat[0][0], top]), *flat]
    if path.status == RayStatus.EXITED:
        route.append(flat[-1] + projection.flat(path.directions[-1]) * reach * 0.8)
    return np.array(route)


def _draw_fan_ray(axes: Axes, path: RayPath, route: np.ndarray) -> None:
    from matplotlib.collections import LineCollection

    colour = ray_colour(path)
    many = len(route) > 30
    axes.add_collection(
        LineCollection(
            [route], colors=[colour], linewidths=0.5 if many else 1.15, zorder=7, joinstyle="round",
            capstyle="round", alpha=0.6 if many else 0.95,
        ),
        autolim=False,
    )  # fmt: skip
    if path.status == RayStatus.EXITED and np.hypot(*(route[-1] - route[-2])) > 0.1:
        draw_head(axes, route[-1], route[-2], colour, 0.3, size=10)
    draw_head(axes, route[1], route[0], colour, 0.7, size=10)


def _write_fan_labels(axes: Axes, paths: list[RayPath], projection: Projection, top: float) -> None:
    """Write each ray's intensity at the eye's end, as long as there is room."""
    met = [path for path in paths if len(path.points)]
    places = [float(projection.flat(path.points[0])[0]) for path in met]
    texts = [f"{path.primary_intensity:.0f}" if path.status == RayStatus.EXITED else "–" for path in met]
    apart = 72 * SCALE * min(np.abs(np.diff(places)), default=1.0)
    longest = max(map(len, texts), default=1)
    size = min(10.0, 10.0 * 30 / len(paths), apart / (_LETTER * (longest + 0.3)))
    if size < 6:
        return
    for path, x, text in zip(met, places, texts, strict=True):
        axes.text(x, top + 0.035, text, fontsize=size, color=text_colour(path), ha="center", va="bottom")


def _write_fan_notes(axes: Axes, paths: list[RayPath]) -> None:
    met = [path for path in paths if path.status != RayStatus.MISSED]
    mean = float(np.mean([path.primary_intensity for path in met])) if met else 0.0
    rear = sum(path.rear for path in met)
    inside = sum(path.status != RayStatus.EXITED for path in met)
    rows = [("Mean intensity", f"{mean:.1f} %"), ("Rear light", f"{rear} of {len(met)} rays")]
    if inside:
        rows.append(("Never leave", f"{inside} of {len(met)} rays"))
    y = axes.get_ylim()[1] - 0.25
    for name, value in rows:
        axes.text(0.1, y, name, fontsize=11, color=DARK.soft)
        axes.text(3.45, y, value, fontsize=11, color=DARK.ink, ha="right")
        y -= 0.28

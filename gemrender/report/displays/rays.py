"""Rays: their whole paths in the stone, on a dark ground as in the paper's photo 5."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import Model, RayStatus
from gemrender.reference import RayPath, full_paths
from gemrender.report.dimensions import length_unit
from gemrender.report.displays.labels import Label, place_labels
from gemrender.report.displays.page import DARK, Page, draw_lines
from gemrender.report.displays.projection import CROWN, Projection, look_at, side
from gemrender.report.displays.ray_colours import (
    RAY_COLOURS,
    draw_scale,
    intensity_text,
    ray_colour,
    text_colour,
)
from gemrender.report.displays.ray_list import LINE_HEIGHT, draw_list
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "FAN_RAYS",
    "MOST_FAN_RAYS",
    "MOST_POINTS",
    "RAY_COLOURS",
    "check_fan",
    "check_points",
    "default_points",
    "draw_head",
    "rays_figure",
]

#: Where none are asked for, three rays are chosen out of so many: of those with few reflections that run
#: this far along x, y and z [stone's unit].
CANDIDATES, FEW_REFLECTIONS, LEAST_SPREAD = 160, 7, 0.4
#: Most rays in one drawing of paths, and of a fan.
MOST_POINTS = 100
FAN_RAYS, MOST_FAN_RAYS = 24, 200

#: Length of a ray outside the stone [stone's unit].
OUTSIDE = 0.42
SCALE = 2.1  # inch per unit
#: A line of more points is drawn fine and without arrows; so is, without, a piece shorter than this
#: [stone's unit].
MANY_POINTS, LEAST_WITH_HEAD = 40, 0.16
_LABEL_SIZE = 11.0


def rays_figure(
    stone: Stone,
    at: Sequence[Sequence[float]] | None = None,
    *,
    model: Model | None = None,
    azimuth_deg: float = 0.0,
) -> Figure:
    """Draw the paths of the rays that are seen at points of the top view.

    Parameters
    ----------
    stone : Stone
    at : (n, 2) array_like, optional
        The points [stone's unit].
    model : Model, optional
        The optical model; by default that of the stone's material.
    azimuth_deg : float
        Azimuth to the right in the side view [deg].

    Raises
    ------
    InputError
        Not pairs of finite numbers, or a point outside the stone.
    """
    if not np.isfinite(azimuth_deg):
        raise InputError("must be a finite angle [deg]", key="azimuth", value=azimuth_deg)
    model = model or Model.of(stone)
    paths = check_points(stone, default_points(stone, model) if at is None else at, model)
    profile = side(azimuth_deg)
    plan_low, plan_high = _extent(stone, paths, CROWN)
    side_low, side_high = _extent(stone, paths, profile)
    left, right = min(plan_low[0], side_low[0]), max(plan_high[0], side_high[0])
    column = (right - left) * SCALE
    upper, lower = (plan_high[1] - plan_low[1]) * SCALE + 0.5, (side_high[1] - side_low[1]) * SCALE + 0.5
    panel, gap = 5.3, 0.5
    height = max(upper + lower + Page.TITLE + Page.MARGIN, 8.0)
    title = "The path of a ray" if len(paths) == 1 else f"The paths of {len(paths)} rays"
    page = Page(stone, title, width=column + gap + panel + 2 * Page.MARGIN, height=height, theme=DARK)

    name = (
        profile.name
        if azimuth_deg % 360 == 0
        else f"{profile.name}, azimuth {azimuth_deg:g}° to the right".replace("-", "−")
    )
    top = height - Page.TITLE - upper
    for projection, y, depth, low, high, caption in (
        (CROWN, top, upper, plan_low, plan_high, CROWN.name),
        (profile, top - lower, lower, side_low, side_high, name),
    ):
        axes = page.view(
            Page.MARGIN, y + 0.4, column, depth - 0.4, scale=SCALE,
            centre=((left + right) / 2, (low[1] + high[1]) / 2),
        )  # fmt: skip
        view = look_at(stone, projection)
        draw_lines(axes, view, DARK, hidden=True, strength=0.42)
        lines = [_draw_path(axes, path, projection) for path in paths]
        _label_paths(axes, paths, projection, [*view.visible, *view.outline, *lines])
        page.caption(Page.MARGIN - (left + right) / 2 * SCALE, y + 0.13, column, caption)

    x = Page.MARGIN + column + gap
    axes = page.axes(x, Page.MARGIN, panel, height - Page.TITLE - Page.MARGIN)
    rows = int((height - Page.TITLE - 2.1) / LINE_HEIGHT)
    draw_list(axes, paths, rows, model)
    draw_scale(page, x, Page.MARGIN + 0.4, panel)
    return page.figure


def default_points(stone: Stone, model: Model) -> list[tuple[float, float]]:
    """Return points of a bright, a weak and a rear ray, as far as the stone has them."""
    number = np.arange(CANDIDATES) + 0.5
    radius = 0.97 * stone.half_width * np.sqrt(number / CANDIDATES)
    azimuth = number * np.pi * (3 - np.sqrt(5))  # the golden angle
    points = np.round(radius[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1), 2)
    paths = [
        path
        for path in full_paths(stone, points, model=model)
        if path.status == RayStatus.EXITED
        and path.reflections <= FEW_REFLECTIONS
        and np.ptp(path.points, axis=0).min() > LEAST_SPREAD
    ]
    lit = sorted((path for path in paths if not path.rear), key=lambda path: path.primary_intensity)
    chosen = [*lit[-1:], *lit[:1][: len(lit) - 1], *[path for path in paths if path.rear][-1:]]
    return [(path.x, path.y) for path in chosen] or [(0.35, 0.12)]


def check_points(stone: Stone, at: Sequence[Sequence[float]] | np.ndarray, model: Model) -> list[RayPath]:
    """Return the paths of the rays at points of the top view.

    Raises
    ------
    InputError
        Not pairs of finite numbers, more than `MOST_POINTS`, or a point outside the stone.
    """
    unit = length_unit(stone)
    try:
        points = np.array(at, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("must be pairs of numbers x, y", key="at", value=at) from error
    if points.shape == (2,):
        points = points[None]
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise InputError("must be pairs of numbers x, y", key="at", value=at)
    if len(points) > MOST_POINTS:
        raise InputError(f"must be at most {MOST_POINTS} points, not {len(points)}", key="at")
    if not np.isfinite(points).all():
        wrong = points[~np.isfinite(points).all(axis=1)][0]
        raise InputError(f"must be two finite numbers [{unit}]", key="at", value=tuple(wrong.tolist()))
    # Far outside nothing is traced: there a ray's start would have no digits left.
    near = np.abs(points).max(axis=1) <= 2 * stone.half_width
    paths = full_paths(stone, np.where(near[:, None], points, 10.0), model=model)
    for point, path in zip(points, paths, strict=True):
        if path.status == RayStatus.MISSED:
            known = "the girdle's radius" if unit == "girdle radius" else "half its length"
            raise InputError(f"lies outside the stone; {known} is 1", key="at", value=tuple(point.tolist()))
    return paths


def _extent(stone: Stone, paths: list[RayPath], projection: Projection) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of the stone and the rays, with room for labels [stone's unit]."""
    flat = np.concatenate([projection.flat(stone.vertices), *[projection.flat(_route(p)) for p in paths]])
    margin = np.array([0.42, 0.17])
    return flat.min(axis=0) - margin, flat.max(axis=0) + margin


def check_fan(rays: int) -> None:
    """Refuse a number of rays that is not from 1 to `MOST_FAN_RAYS`."""
    if isinstance(rays, bool) or not isinstance(rays, (int, np.integer)) or not 1 <= rays <= MOST_FAN_RAYS:
        raise InputError(f"must be a whole number from 1 to {MOST_FAN_RAYS}", key="rays", value=rays)


def _route(path: RayPath) -> np.ndarray:
    """Points that a path runs through, (k + 2, 3), from outside the stone to the eye, as the light runs."""
    inner = path.points[::-1]
    eye = path.points[0] - OUTSIDE * path.directions[0]
    if path.status != RayStatus.EXITED:
        return np.concatenate([inner, eye[None]])
    start = path.points[-1] + OUTSIDE * path.directions[-1]
    return np.concatenate([start[None], inner, eye[None]])


def _draw_path(axes: Axes, path: RayPath, projection: Projection) -> np.ndarray:
    """Draw a ray with arrows the way the light runs; return its line."""
    from matplotlib.collections import LineCollection

    flat = projection.flat(_route(path))
    colour = ray_colour(path)
    many = len(flat) > MANY_POINTS
    axes.add_collection(
        LineCollection(
            [flat], colors=[colour], linewidths=0.6 if many else 1.6, zorder=7, capstyle="round",
            joinstyle="round", alpha=0.7 if many else None,
        ),
        autolim=False,
    )  # fmt: skip
    if not many:
        axes.scatter(*projection.flat(path.points).T, s=9, color=[colour], zorder=8, linewidths=0)
        for number, (a, b) in enumerate(pairwise(flat)):
            if np.hypot(*(b - a)) > LEAST_WITH_HEAD:
                share = 0.35 if number == 0 else (0.8 if number == len(flat) - 2 else 0.5)
                draw_head(axes, a, b, colour, share, size=15)
    if projection.up[2] == 0:  # towards the eye: a ring, as drawings have an arrow's point
        axes.scatter(*flat[-1], s=46, facecolor="none", edgecolor=[colour], linewidths=1.3, zorder=8)
    return flat


def draw_head(axes: Axes, a: np.ndarray, b: np.ndarray, colour: Any, share: float, *, size: float) -> None:
    """Draw an arrow's head at a share of the way from a to b, of a size in points."""
    from matplotlib.patches import FancyArrowPatch

    tip = a + share * (b - a) + 0.02 * (b - a) / np.hypot(*(b - a))
    axes.add_patch(
        FancyArrowPatch(
            tuple(tip - 0.01 * (b - a) / np.hypot(*(b - a))), tuple(tip),
            arrowstyle="-|>,head_length=0.55,head_width=0.24", mutation_scale=size,
            color=colour, linewidth=0, shrinkA=0, shrinkB=0, zorder=8,
        )
    )  # fmt: skip


def _label_paths(axes: Axes, paths: list[RayPath], projection: Projection, lines: list[np.ndarray]) -> None:
    """Write each ray's number where its light comes from, and where the eye sees it."""
    labels = []
    from_above = projection.up[2] == 0
    for number, path in enumerate(paths, start=1):
        flat = projection.flat(_route(path))
        name = f"{number}" if len(paths) > 1 else ""
        if path.status == RayStatus.EXITED and len(paths) <= 12:
            text = f"{name}: {intensity_text(path)}" if name else f"{intensity_text(path)}"
            labels.append(Label(text=text, at=flat[0], towards=flat[0] - flat[1], colour=text_colour(path)))
        if name:
            towards = flat[-1] if from_above else np.array([0.0, 1.0])
            labels.append(Label(text=name, at=flat[-1], towards=towards, colour=text_colour(path)))
    if labels:
        place_labels(
            axes,
            labels,
            lines=lines,
            fontsize=_LABEL_SIZE,
            fontweight="bold",
            leader_colour=DARK.soft,
            halo=DARK.ground,
            line_cost=1.0,
        )

"""The list beside the rays: point, direction and intensity of each, and what happens at each facet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.observation import Model, RayStatus
from gemrender.reference import RayPath
from gemrender.report.displays.page import DARK
from gemrender.report.displays.ray_colours import intensity_text, ray_colour, text_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["LINE_HEIGHT", "draw_list"]

#: Height of a line [inch].
LINE_HEIGHT = 0.225
_LIST_SIZE = 10.0
# Columns of the list [inch]: number, facet, what happens, angle in air, angle in the stone.
_COLUMNS = (0.28, 0.45, 1.95, 4.35, 5.3)


def draw_list(axes: Axes, paths: list[RayPath], rows: int, model: Model) -> None:
    """Write point, direction and intensity of each ray, and what happens at each facet if there is room."""
    y = axes.get_ylim()[1] - 0.15
    head = 5  # rows of a ray without its facets
    share = (rows - 2) // len(paths) - head - 1
    whole = share >= 3
    if not whole:
        if len(paths) <= (rows - 2) // 4:
            _write_medium(axes, paths, y)
        else:
            _write_short(axes, paths, rows, y)
        return
    room = rows - 2 - (head + 1) * len(paths)
    for number, path in enumerate(paths, start=1):
        left = len(paths) - number + 1
        most = max(room // left, 3)
        used = min(len(path.points), most)
        room -= used
        y = _write_ray(axes, path, str(number) if len(paths) > 1 else "", y, most)
    axes.text(
        0.0, y - 0.02, f"Index {model.index:g}. Facets in the order in which the light meets them.",
        fontsize=9, color=DARK.soft, va="top",
    )  # fmt: skip


def _write_ray(axes: Axes, path: RayPath, number: str, y: float, most: int) -> float:
    """Write a ray's list from the height y downwards; return where it ends."""
    colour = ray_colour(path)
    title = f"Ray {number}   seen at" if number else "Ray seen at"
    axes.plot([0.0, 0.18], [y + 0.055] * 2, color=colour, linewidth=3.5, solid_capstyle="butt")
    axes.text(0.28, y, f"{title} {_place(path)}", fontsize=12, fontweight="bold",
              color=DARK.ink)  # fmt: skip
    axes.text(
        _COLUMNS[-1],
        y,
        intensity_text(path),
        fontsize=12,
        fontweight="bold",
        color=text_colour(path),
        ha="right",
    )
    y -= LINE_HEIGHT * 1.15
    if path.status == RayStatus.EXITED:
        facts = [
            ("light enters at", _triple(path.points[-1], 3)),
            ("direction", _triple(-path.directions[-1], 3)),
        ]
    else:
        facts = [("light enters", "never: followed back it stays inside"), ("", "")]
    for name, value in facts:
        axes.text(_COLUMNS[0], y, name, fontsize=_LIST_SIZE, color=DARK.soft)
        axes.text(1.6, y, value, fontsize=_LIST_SIZE, color=DARK.ink)
        y -= LINE_HEIGHT
    axes.text(_COLUMNS[3], y, "in air", fontsize=9, color=DARK.soft, ha="right")
    axes.text(_COLUMNS[4], y, "in the stone", fontsize=9, color=DARK.soft, ha="right")
    axes.plot([0.28, _COLUMNS[-1]], [y - 0.06] * 2, color=DARK.faint, linewidth=0.8)
    y -= LINE_HEIGHT
    for row in _rows(path, most):
        shades = (DARK.soft, DARK.ink, DARK.soft, DARK.ink, DARK.ink)
        for place, text, shade in zip(_COLUMNS, row, shades, strict=True):
            right = place in (_COLUMNS[0], *_COLUMNS[3:])
            axes.text(place, y, text, fontsize=_LIST_SIZE, color=shade, ha="right" if right else "left")
        y -= LINE_HEIGHT
    return y - LINE_HEIGHT * 0.9


def _rows(path: RayPath, most: int) -> list[tuple[str, str, str, str, str]]:
    """Return number, facet, event and angles at each point as the light runs, at most so many rows."""
    count = len(path.points)
    in_stone, in_air = _angles(path)
    exited = path.status == RayStatus.EXITED
    rows = []
    for order, k in enumerate(reversed(range(count)), start=1):
        crossing = k == 0 or (exited and k == count - 1)
        event = "to the eye" if k == 0 else ("light in" if crossing else "total reflection")
        air = f"{in_air[k]:.1f}°" if crossing else ""
        rows.append((f"{order}", path.facet_names[k].replace("_", " "), event, air, f"{in_stone[k]:.1f}°"))
    if count <= most:
        return rows
    first = (most - 1) // 2
    last = most - 1 - first
    gap = ("", "…", f"{count - most + 1} total reflections more", "", "")
    return [*rows[:first], gap, *rows[count - last :]]


def _angles(path: RayPath) -> tuple[np.ndarray, np.ndarray]:
    """Angles with the normals in the stone and in air, each (k,) [deg]; in air of the crossings only."""
    before, after = path.directions[:-1], path.directions[1:]

    def angle(directions: np.ndarray) -> np.ndarray:
        cos = np.abs(np.einsum("ij,ij->i", directions[: len(path.normals)], path.normals))
        return np.asarray(np.degrees(np.arccos(np.clip(cos, 0.0, 1.0))))

    # Followed back from the eye: at the first point the ray comes from air, at the last it goes there.
    arriving, leaving = angle(before), angle(after)
    in_stone, in_air = arriving.copy(), leaving.copy()
    in_stone[0], in_air[0] = leaving[0], arriving[0]
    return in_stone, in_air


def _write_medium(axes: Axes, paths: list[RayPath], y: float) -> None:
    """Write three lines a ray, for several rays."""
    for number, path in enumerate(paths, start=1):
        colour = text_colour(path)
        axes.plot([0.0, 0.18], [y + 0.055] * 2, color=ray_colour(path), linewidth=3.5, solid_capstyle="butt")
        axes.text(0.28, y, f"Ray {number}   seen at {_place(path)}", fontsize=11, fontweight="bold",
                  color=DARK.ink)  # fmt: skip
        axes.text(5.3, y, intensity_text(path), fontsize=11, fontweight="bold", color=colour, ha="right")
        facts = [("light", "never enters: followed back it stays inside"), ("", "")]
        if path.status == RayStatus.EXITED:
            facet = path.facet_names[-1].replace("_", " ")
            facts = [
                ("light enters at", f"{_triple(path.points[-1], 3)}, {facet}"),
                ("direction", f"{_triple(-path.directions[-1], 3)}, {_count(path.reflections)}"),
            ]
        for name, value in facts:
            y -= LINE_HEIGHT
            axes.text(0.28, y, name, fontsize=_LIST_SIZE, color=DARK.soft)
            axes.text(1.6, y, value, fontsize=_LIST_SIZE, color=DARK.ink)
        y -= 2 * LINE_HEIGHT


def _count(reflections: int) -> str:
    return f"{reflections} reflection{'' if reflections == 1 else 's'}"


def _write_short(axes: Axes, paths: list[RayPath], rows: int, y: float) -> None:
    """Write one line a ray, for many rays."""
    columns = (0.24, 0.36, 1.32, 2.33, 3.55, 5.3)
    heads = ("", "seen at", "light enters by", "at", "direction", "intensity")
    for x, text in zip(columns, heads, strict=True):
        axes.text(x, y, text, fontsize=8.5, color=DARK.soft, ha="right" if x in (0.24, 5.3) else "left")
    axes.plot([0.0, columns[-1]], [y - 0.07] * 2, color=DARK.faint, linewidth=0.8)
    shown = paths if len(paths) <= rows - 3 else paths[: rows - 4]
    for number, path in enumerate(shown, start=1):
        y -= LINE_HEIGHT
        exited = path.status == RayStatus.EXITED
        cells = (
            f"{number}",
            _triple(np.array([path.x, path.y]), 2),
            path.facet_names[-1].replace("_", " ") if exited else "–",
            _triple(path.points[-1], 2) if exited else "–",
            _triple(-path.directions[-1], 2) if exited else "–",
            intensity_text(path),
        )
        for x, text in zip(columns, cells, strict=True):
            axes.text(
                x, y, text, fontsize=8.5, ha="right" if x in (0.24, 5.3) else "left",
                color=text_colour(path) if x in (0.24, 5.3) else DARK.ink,
            )  # fmt: skip
    if len(shown) < len(paths):
        y -= LINE_HEIGHT
        axes.text(columns[1], y, f"and {len(paths) - len(shown)} more", fontsize=8.5, color=DARK.soft)


def _place(path: RayPath) -> str:
    return f"({path.x + 0.0:.4g}, {path.y + 0.0:.4g})".replace("-", "−")


def _triple(values: np.ndarray, digits: int) -> str:
    return f"({', '.join(f'{v + 0.0:.{digits}f}' for v in values)})".replace("-", "−")

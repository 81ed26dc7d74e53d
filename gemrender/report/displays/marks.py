"""What the drawing of a cut says at its arrows, in one view: dimension lines, arcs, words.

Lengths stand around the stone, the shorter ones nearer to it; all else is named in a column to its left, or
to its right where no lengths are, in the order of height, with a line to its place. So nothing lies on
anything else, however long the stone is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gemrender.cuts.marks import VIEWS, Angle, Length, Mark, Place, Share, Tilt
from gemrender.report.displays.dimension_lines import draw_arc, draw_dimension, draw_row
from gemrender.report.displays.page import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["MarkedView"]

#: Size of the letters [points], and what the widest of them takes, on the average of a text [inch].
_SIZE, _LETTER = 10.0, 0.083
#: From the stone to the first dimension line, from line to line, and from text to text in a column [inch].
_FIRST, _NEXT, _STEP = 0.40, 0.38, 0.23
#: From the stone to the columns of text [inch].
_GAP = 0.35
#: Largest radius of an angle's arc, and its share of the shorter side [stone's unit].
_RADIUS, _RADIUS_SHARE = 0.26, 0.6
#: Lengths that overlap by less stand in one row [stone's unit]: rounding.
_SAME = 1e-9


class MarkedView:
    """A view of a stone with its marks: how much room they need, and drawing them.

    Parameters
    ----------
    marks : sequence of Mark
        Those of this view.
    view : str
        One of `VIEWS`.
    low, high : (2,) float64
        The box of the stone on the page [stone's unit].
    scale : float
        Inches in the stone's unit.
    """

    def __init__(
        self, marks: Sequence[Mark], view: str, *, low: np.ndarray, high: np.ndarray, scale: float
    ) -> None:
        own = [mark for mark in marks if mark.view == view]
        self._axes_of_page, self._low, self._high, self._scale = VIEWS[view], low, high, scale
        self._is_profile = view in ("width", "length")
        lengths = [mark for mark in own if isinstance(mark, Length) and not mark.is_inside]
        level = [mark for mark in lengths if self._axes_of_page[0][mark.axis]]
        upright = [mark for mark in lengths if not self._axes_of_page[0][mark.axis]]
        wide = high[0] - low[0] - _SAME
        self._below = [[mark] for mark in level if _length(self._span(mark)) > wide]
        self._above = self._in_rows([mark for mark in level if _length(self._span(mark)) <= wide])
        self._beside = self._in_rows(upright)
        named = [mark for mark in own if mark not in lengths]
        middle = (low[0] + high[0]) / 2
        self._on_right = [mark for mark in named if not upright and self._place(mark)[0] > middle + _SAME]
        self._on_left = [mark for mark in named if mark not in self._on_right]

    # ---- Room, in inches ----

    @property
    def left(self) -> float:
        """Room to the left of the stone, for names."""
        return _GAP + _widest([mark.text for mark in self._on_left]) if self._on_left else 0.2

    @property
    def right(self) -> float:
        """Room to the right of the stone, for upright lengths or names."""
        if self._on_right:
            return _GAP + _widest([mark.text for mark in self._on_right])
        if not self._beside:
            return 0.2
        return _FIRST + _NEXT * len(self._beside) + self._words

    @property
    def above(self) -> float:
        """Room above the stone."""
        return _FIRST + _NEXT * len(self._above) if self._above else 0.15

    @property
    def below(self) -> float:
        """Room below the stone."""
        return _FIRST + _NEXT * len(self._below) if self._below else 0.15

    @property
    def _words(self) -> float:
        """Room for the words of heights, which are level, beside the first row of them."""
        if not self._is_profile or not self._beside:
            return 0.0
        return _widest([mark.text for mark in self._beside[0]])

    # ---- Drawing ----

    def draw(self, axes: Axes) -> None:
        """Draw the marks around the stone, in axes that count in the stone's unit."""
        first, step = _FIRST / self._scale, _NEXT / self._scale
        for row, marks in enumerate(self._below):
            self._dimension(axes, marks[0], (0.0, self._low[1] - first - row * step))
        for row, marks in enumerate(self._above):
            for mark in marks:
                self._dimension(axes, mark, (0.0, self._high[1] + first - 0.15 / self._scale + row * step))
        for row, marks in enumerate(self._beside):
            x = self._high[0] + first - 0.1 / self._scale + row * step
            if row == 0 and self._words:
                self._heights(axes, marks, x)
                continue
            for mark in marks:
                self._dimension(axes, mark, (x + self._words / self._scale, 0.0), upright=True)
        self._names(axes)

    def _dimension(
        self, axes: Axes, mark: Length, line: tuple[float, float], *, upright: bool = False
    ) -> None:
        a, b = self._flat(mark.start), self._flat(mark.end)
        is_wide = _widest([mark.text]) > _length(self._span(mark)) * self._scale
        draw_dimension(
            axes, a, b, line, mark.text, upright=upright, turned=upright, is_wide=is_wide, size=_SIZE
        )

    def _heights(self, axes: Axes, marks: Sequence[Length], x: float) -> None:
        """Draw heights one above the other, and what they are to their right."""
        wanted = [float(np.mean(self._span(mark))) for mark in marks]
        for mark, y, place in zip(marks, wanted, spread(wanted, _STEP / self._scale), strict=True):
            a, b = self._flat(mark.start), self._flat(mark.end)
            draw_dimension(axes, a, b, (x, 0.0), "", upright=True)
            elbow = np.array([[x, y], [x + 0.1 / self._scale, y], [x + 0.28 / self._scale, place]])
            if abs(place - y) > 0.03 / self._scale:
                axes.plot(*elbow[[0, 2]].T, color=PAPER.accent, linewidth=PAPER.thin_width, zorder=5)
            axes.text(
                x + 0.33 / self._scale, place, mark.text, fontsize=_SIZE, color=PAPER.accent, ha="left",
                va="center_baseline", zorder=10,
            )  # fmt: skip

    def _names(self, axes: Axes) -> None:
        """Draw angles, shares and places, and write what they are to the left or to the right."""
        gap = _GAP / self._scale
        for marks, x, way, side in (
            (self._on_left, self._low[0] - gap, 1.0, "right"),
            (self._on_right, self._high[0] + gap, -1.0, "left"),
        ):
            ends = [self._place(mark) for mark in marks]
            places = spread([float(end[1]) for end in ends], _STEP / self._scale)
            for mark, end, y in zip(marks, ends, places, strict=True):
                self._draw_on_stone(axes, mark)
                near, far = (x + way * inch / self._scale for inch in (0.05, 0.15))
                line = np.array([[near, y], [far, y], end])
                axes.plot(*line.T, color=PAPER.accent, linewidth=PAPER.thin_width, zorder=8)
                axes.text(
                    x,
                    y,
                    mark.text,
                    fontsize=_SIZE,
                    color=PAPER.accent,
                    ha=side,
                    va="center_baseline",
                    zorder=10,
                )

    def _place(self, mark: Mark) -> np.ndarray:
        """Return where the line from a mark's name ends."""
        if isinstance(mark, Angle):
            return self._flat(mark.corner)
        if isinstance(mark, Place | Tilt):
            return self._flat(mark.at)
        assert isinstance(mark, Share | Length)
        start, end = self._flat(mark.start), self._flat(mark.end)
        if isinstance(mark, Length):
            return np.asarray((start + end) / 2)
        return start if start[0] < end[0] else end

    def _draw_on_stone(self, axes: Axes, mark: Mark) -> None:
        if isinstance(mark, Angle):
            corner, start, end = map(self._flat, (mark.corner, mark.start, mark.end))
            shorter = min(np.hypot(*(start - corner)), np.hypot(*(end - corner)))
            draw_arc(axes, corner, start, end, min(_RADIUS, _RADIUS_SHARE * shorter))
        elif isinstance(mark, Share):
            start, end, at = map(self._flat, (mark.start, mark.end, mark.at))
            way = end - start
            draw_row(axes, [start, start + way * ((at - start) @ way) / (way @ way), end])
        elif isinstance(mark, Length):
            draw_row(axes, [self._flat(mark.start), self._flat(mark.end)])
        else:
            axes.scatter(*self._place(mark), s=11, color=PAPER.accent, zorder=8, linewidths=0)

    def _flat(self, point: np.ndarray) -> np.ndarray:
        return np.asarray(self._axes_of_page @ point)

    def _span(self, mark: Length) -> tuple[float, float]:
        """Return from where to where a length reaches along its dimension line."""
        a, b = self._flat(mark.start), self._flat(mark.end)
        along = 0 if self._axes_of_page[0][mark.axis] else 1
        return float(min(a[along], b[along])), float(max(a[along], b[along]))

    def _in_rows(self, marks: Sequence[Length]) -> list[list[Length]]:
        """Lay lengths in rows, the shorter ones first, in which none lies beside another."""
        rows: list[list[Length]] = []
        for mark in sorted(marks, key=lambda mark: _length(self._span(mark))):
            low, high = self._room(mark)
            for row in rows:
                if all(high <= a + _SAME or b <= low + _SAME for a, b in map(self._room, row)):
                    row.append(mark)
                    break
            else:
                rows.append([mark])
        return rows

    def _room(self, mark: Length) -> tuple[float, float]:
        """Return from where to where a length with its text reaches; that of heights stands beside them."""
        low, high = self._span(mark)
        more = (
            0.0 if self._is_profile and mark.axis == 2 else _widest([mark.text]) / self._scale - (high - low)
        )
        return low - max(more, 0.0) / 2, high + max(more, 0.0) / 2


def spread(wanted: Sequence[float], least: float) -> list[float]:
    """Return places as near as can be to those wanted (least squares), in their order, `least` apart."""
    order = sorted(range(len(wanted)), key=lambda number: wanted[number])
    # Less the distances that there must be, they must not fall: neighbours that do are put at their mean.
    groups: list[list[float]] = []
    for rank, number in enumerate(order):
        groups.append([wanted[number] - rank * least])
        while len(groups) > 1 and np.mean(groups[-2]) > np.mean(groups[-1]):
            last = groups.pop()
            groups[-1] += last
    shifted = [float(np.mean(group)) for group in groups for _ in group]
    places = [0.0] * len(wanted)
    for rank, number in enumerate(order):
        places[number] = shifted[rank] + rank * least
    return places


def _length(span: tuple[float, float]) -> float:
    return span[1] - span[0]


def _widest(words: Sequence[str]) -> float:
    """Return the room that the widest of some texts takes [inch]."""
    return _LETTER * max(map(len, words))

"""Labels that overlap neither each other nor, where it can be helped, the lines of a drawing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

__all__ = ["Label", "fits", "largest_fit", "place_labels", "text_boxes", "write_with_room"]

#: Space around a label [points].
PADDING = 1.6
#: Distances tried between a label and its point [points]; beyond the second it gets a leader.
DISTANCES = (5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 75.0, 95.0, 120.0)
#: Directions tried at each distance.
DIRECTIONS = 32
#: What a label costs that stands nearer to another's point than to its own, or hardly less near.
DOUBT_COST, DOUBT_MARGIN = 200.0, 1.35
#: What a label costs: for each point of line length that it covers, of distance, and of turn [1/rad].
LINE_COST, DISTANCE_COST, TURN_COST = 3.0, 0.6, 4.0
_BLOCKED = 1e6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Label:
    """A text that belongs to a point.

    Attributes
    ----------
    text : str
    at : (2,) array_like
        The point, in the axes' data.
    towards : (2,) array_like
        Direction in which the label stands by preference.
    polygon : (n, 2) float64, optional
        A convex patch, in the axes' data, that the label stands in if there is room.
    otherwise : (2,) array_like, optional
        Where its middle stands if there is none; by default near the point.
    colour : str, optional
        Of the text, if not that of all.
    """

    text: str
    at: Any
    towards: Any = (0.0, 1.0)
    polygon: np.ndarray | None = None
    otherwise: Any = None
    colour: str | None = None


def place_labels(
    axes: Axes,
    labels: Sequence[Label],
    *,
    lines: Iterable[np.ndarray] = (),
    points: Iterable[Any] = (),
    fontsize: float = 9.0,
    colour: str = "black",
    leader_colour: str = "#7a8792",
    halo: str | None = None,
    line_cost: float = LINE_COST,
    **font: Any,
) -> list[Text]:
    """Write labels, each where it costs least after those before it.

    The axes' limits and place must be final: the labels' sizes are measured on the page.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    labels : sequence of Label
        The most important first.
    lines : iterable of (n, 2) float64
        Lines of the drawing, in the axes' data, that labels rather not cover.
    points : iterable of (2,)
        Points, in the axes' data, that labels must not cover; those of the labels are among them.
    fontsize : float
        Size of the text [points].
    colour, leader_colour : str
        Of the text, and of the lines that lead to it.
    halo : str, optional
        Colour of a margin that sets the letters off from lines beneath.
    line_cost : float
        What each point of line length that a label covers costs, beside `DISTANCE_COST`.
    **font
        Further properties of the text.

    Returns
    -------
    list of matplotlib.text.Text
    """
    from matplotlib.patheffects import withStroke

    if halo is not None:
        font["path_effects"] = [withStroke(linewidth=2.6, foreground=halo)]
    unit = axes.figure.dpi / 72  # pixels in a point
    to_page = axes.transData.transform
    segments = [np.stack([line[:-1], line[1:]], axis=1) for line in map(to_page, lines) if len(line) > 1]
    pieces = np.concatenate(segments) if segments else np.empty((0, 2, 2))
    spots = to_page(np.array([*[label.at for label in labels], *points], dtype=float).reshape(-1, 2))

    taken: list[np.ndarray] = []
    leaders: list[np.ndarray] = []
    texts = []
    for number, label in enumerate(labels):
        text = axes.text(
            *label.at, label.text, fontsize=fontsize, color=label.colour or colour, ha="center",
            va="center_baseline", zorder=10, **font,
        )  # fmt: skip
        box = text.get_window_extent(_renderer(text))
        half = np.array([box.width, box.height]) / 2 + PADDING * unit
        own = spots[number]
        centre, polygon = None, None
        if label.polygon is not None:
            polygon = to_page(label.polygon)
            centre = _room(polygon, half, taken)
        led = False
        if centre is None and label.otherwise is not None:
            centre, led = to_page(label.otherwise), True
            axes.scatter(*label.at, s=5, color=leader_colour, zorder=5, linewidths=0)
        if centre is None:
            others = np.delete(spots, number, axis=0)
            centre = _cheapest(own, label.towards, half, unit, line_cost, pieces, others, taken, leaders)
            gap = _gap(own, centre, half)
            led = gap > DISTANCES[1] * unit
        _move(text, box, centre, axes)
        taken.append(np.concatenate([centre - half, centre + half]))
        if led:
            end = _towards_box(own, centre, half - 0.6 * PADDING * unit)
            leaders.append(np.stack([own, end]))
            axes.plot(
                *axes.transData.inverted().transform([own, end]).T, color=leader_colour, linewidth=0.6,
                zorder=9, solid_capstyle="butt",
            )  # fmt: skip
        texts.append(text)
    return texts


def write_with_room(axes: Axes, labels: Sequence[Label], *, fontsize: float, **font: Any) -> list[Text]:
    """Write labels beside their points, outwards; leave out those that would lie on another one.

    For very many labels: nothing is searched for. Parameters as for `place_labels`.
    """
    unit = axes.figure.dpi / 72
    spots = axes.transData.transform(np.array([label.at for label in labels], dtype=float))
    texts: list[Text] = []
    taken = np.empty((0, 4))
    for label, spot in zip(labels, spots, strict=True):
        half = unit * fontsize * np.array([0.36 * len(label.text), 0.5])  # as wide and high as letters are
        away = np.asarray(label.towards, dtype=float) / np.hypot(*label.towards)
        centre = spot + (half + 1.5 * unit) * away
        box = np.concatenate([centre - half, centre + half])
        if ((box[:2] < taken[:, 2:]) & (taken[:, :2] < box[2:])).all(axis=1).any():
            continue
        taken = np.concatenate([taken, box[None]])
        place = axes.transData.inverted().transform(centre)
        texts.append(
            axes.text(*place, label.text, fontsize=fontsize, color=label.colour, ha="center",
                      va="center_baseline", zorder=10, **font)
        )  # fmt: skip
    return texts


def fits(axes: Axes, label: Label, fontsize: float) -> bool:
    """Say whether a label fits into its polygon, other labels left aside."""
    return largest_fit(axes, label, (fontsize,)) is not None


def largest_fit(axes: Axes, label: Label, sizes: Sequence[float]) -> float | None:
    """Return the first of some sizes [points] at which a label fits into its polygon, or None.

    Other labels are left aside. The letters are measured once: their boxes grow as their size.
    """
    if label.polygon is None:
        return None
    polygon = axes.transData.transform(label.polygon)
    unit = axes.figure.dpi / 72
    x, y = polygon.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    narrow = 0.2 * len(label.text) * unit**2  # less than letters of size 1 take
    sizes = [size for size in sizes if area > narrow * size**2]
    if not sizes:
        return None
    text = axes.text(0, 0, label.text, fontsize=sizes[0])
    box = text.get_window_extent(_renderer(text))
    half = np.array([box.width, box.height]) / 2
    text.remove()
    for size in sizes:
        if _room(polygon, half * (size / sizes[0]) + PADDING * unit, []) is not None:
            return size
    return None


def text_boxes(axes: Axes) -> np.ndarray:
    """Return the boxes of all texts of an axes, (n, 4): left, bottom, right, top [pixels]."""
    shown = [text for text in axes.texts if text.get_visible() and text.get_text().strip()]
    return np.array([text.get_window_extent(_renderer(text)).extents for text in shown]).reshape(-1, 4)


# ---- On the page, in pixels ----


def _renderer(text: Text) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = text.get_figure(root=True)
    canvas = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    return canvas.get_renderer()


def _move(text: Text, box: Bbox, centre: np.ndarray, axes: Axes) -> None:
    """Put the middle of the text's box at a place of the page."""
    place = axes.transData.transform(text.get_position())
    shift = centre - np.array([(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2])
    text.set_position(axes.transData.inverted().transform(place + shift))


def _cheapest(
    own: np.ndarray,
    towards: Any,
    half: np.ndarray,
    unit: float,
    line_cost: float,
    pieces: np.ndarray,
    spots: np.ndarray,
    taken: list[np.ndarray],
    leaders: list[np.ndarray],
) -> np.ndarray:
    """Return the place around a point where a label costs least, looking at cheap ones first."""
    centres, costs = _candidates(own, towards, half, unit)
    order = np.argsort(costs, kind="stable")
    best, least = centres[order[0]], np.inf
    for some in np.array_split(order, len(order) // DIRECTIONS):
        if costs[some[0]] >= least:
            break
        places = centres[some]
        boxes = np.concatenate([places - half, places + half], axis=1)
        cost = costs[some] + line_cost / unit * _covered(boxes, pieces)
        cost += _BLOCKED * _blocked(boxes, taken, spots)
        cost += DOUBT_COST * _doubtful(own, boxes, spots, unit)
        cost += _BLOCKED * _crossed(own, places, boxes, taken, leaders)
        if cost.min() < least:
            best, least = places[np.argmin(cost)], float(cost.min())
    return np.asarray(best)


def _candidates(
    own: np.ndarray, towards: Any, half: np.ndarray, unit: float
) -> tuple[np.ndarray, np.ndarray]:
    """Places around a point, and what their distance and turn cost."""
    turns = np.linspace(-np.pi, np.pi, DIRECTIONS, endpoint=False)
    angle = np.arctan2(towards[1], towards[0]) + turns
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # From the point to where the box just touches it, then on by the distance.
    with np.errstate(divide="ignore"):
        touch = np.min(half / np.abs(direction), axis=1)
    reach = np.minimum(touch, np.hypot(*half))
    centres = own + (reach[:, None] + unit * np.array(DISTANCES))[..., None] * direction[:, None]
    cost = DISTANCE_COST * np.array(DISTANCES) + TURN_COST * np.abs(turns)[:, None]
    return centres.reshape(-1, 2), cost.reshape(-1)


def _covered(boxes: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """Length of line that each box covers."""
    if not len(pieces):
        return np.zeros(len(boxes))
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    near = (pieces.max(axis=1) >= low).all(axis=1) & (pieces.min(axis=1) <= high).all(axis=1)
    return np.asarray(_clipped(boxes, pieces[near]).sum(axis=1))


def _clipped(boxes: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """Length of each piece of line within each box, (boxes, pieces) (Liang and Barsky's clipping)."""
    start, along = pieces[:, 0], pieces[:, 1] - pieces[:, 0]
    # A piece that runs along an axis is turned by a billionth, not to divide by zero.
    slope = np.where(np.abs(along) < 1e-9, 1e-9, along)
    one, other = (boxes[:, None, :2] - start) / slope, (boxes[:, None, 2:] - start) / slope
    enter = np.minimum(one, other).max(axis=2).clip(0.0, 1.0)
    leave = np.maximum(one, other).min(axis=2).clip(0.0, 1.0)
    return np.asarray(np.maximum(leave - enter, 0.0) * np.hypot(*along.T))


def _blocked(boxes: np.ndarray, taken: list[np.ndarray], spots: np.ndarray) -> np.ndarray:
    """How many labels and points of others each box covers."""
    others = np.concatenate([np.reshape(taken, (-1, 4)), np.concatenate([spots - 2, spots + 2], axis=1)])
    apart = (boxes[:, None, :2] >= others[:, 2:]) | (boxes[:, None, 2:] <= others[:, :2])
    return np.asarray((~apart.any(axis=2)).sum(axis=1))


def _doubtful(own: np.ndarray, boxes: np.ndarray, spots: np.ndarray, unit: float) -> np.ndarray:
    """Whether a reader may take each box for another point's: with a leader, only if it nearly touches."""
    if not len(spots):
        return np.zeros(len(boxes))

    def gap(points: np.ndarray) -> np.ndarray:
        outside = np.maximum(np.maximum(boxes[:, None, :2] - points, points - boxes[:, None, 2:]), 0.0)
        return np.asarray(np.hypot(outside[..., 0], outside[..., 1]))

    others = gap(spots).min(axis=1)
    mine = gap(own[None])[:, 0]
    led = mine > DISTANCES[1] * unit
    return np.asarray(np.where(led, others < DISTANCES[0] * unit, others < DOUBT_MARGIN * mine).astype(float))


def _crossed(
    own: np.ndarray,
    centres: np.ndarray,
    boxes: np.ndarray,
    taken: list[np.ndarray],
    leaders: list[np.ndarray],
) -> np.ndarray:
    """How many labels and leaders the line from the point to each place would cross, or its box would."""
    lines = np.stack([np.broadcast_to(own, centres.shape), centres], axis=1)
    crossed = np.zeros(len(centres))
    if taken:
        crossed += (_clipped(np.array(taken), lines) > 0).sum(axis=0)
    if leaders:
        others = np.array(leaders)
        crossed += (_clipped(boxes, others) > 0).sum(axis=1) + _meet(lines, others).sum(axis=1)
    return crossed


def _meet(lines: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether each line crosses each of the others, (lines, others)."""

    def sides(line: np.ndarray, point: np.ndarray) -> np.ndarray:
        u, v = line[:, 1] - line[:, 0], point[:, None] - line[:, 0]
        return np.asarray(u[:, 0] * v[..., 1] - u[:, 1] * v[..., 0])  # (points, lines)

    a = sides(lines, others[:, 0]) * sides(lines, others[:, 1]) < 0
    b = sides(others, lines[:, 0]) * sides(others, lines[:, 1]) < 0
    return np.asarray(a.T & b)


def _gap(own: np.ndarray, centre: np.ndarray, half: np.ndarray) -> float:
    return float(np.hypot(*np.maximum(np.abs(own - centre) - half, 0.0)))


def _towards_box(own: np.ndarray, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Where the line from a point to a box's middle meets the box."""
    along = centre - own
    with np.errstate(divide="ignore"):
        share = 1 - np.min(half / np.abs(along))
    return np.asarray(own + max(share, 0.0) * along)


def _room(polygon: np.ndarray, half: np.ndarray, taken: list[np.ndarray]) -> np.ndarray | None:
    """Return where a box has most room within a convex polygon, or None if it has none."""
    edge = np.roll(polygon, -1, axis=0) - polygon
    length = np.hypot(*edge.T)
    polygon, edge, length = polygon[length > 1e-9], edge[length > 1e-9], length[length > 1e-9]
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) / length[:, None]
    middle = polygon.mean(axis=0)
    normal *= np.sign(((polygon - middle) * normal).sum(axis=1))[:, None]  # outward
    offset = (polygon * normal).sum(axis=1) - np.abs(normal) @ half  # for the box's middle
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    grid = np.stack(np.meshgrid(*[np.linspace(a, b, 41) for a, b in zip(low, high, strict=True)]), axis=-1)
    places = np.concatenate([middle[None], grid.reshape(-1, 2)])
    room = (offset - places @ normal.T).min(axis=1)
    most = room.max()
    for box in taken:
        if np.maximum(box[:2] - half - high, low - half - box[2:]).max() >= most:
            continue  # too far away to matter
        clear = np.maximum(box[:2] - half - places, places - half - box[2:]).max(axis=1)
        room = np.minimum(room, clear)
    best = int(np.argmax(room))
    return places[best] if room[best] >= 0 else None

"""A measured stone for drawings, and what stands in a figure."""

from __future__ import annotations

import numpy as np

from gemrender.cuts import load_stone, stone_from_vertices
from gemrender.report.displays.labels import text_boxes
from gemrender.report.lettering import boxes_for_letters
from gemrender.stone import Stone


def measured_stone(deviation: float = 0.004, seed: int = 3) -> Stone:
    """Return inoue-2 as if measured in millimetres, every vertex off by a normal deviate [girdle radius]."""
    vertices = load_stone("inoue-2").vertices
    off = np.random.default_rng(seed).normal(0.0, deviation, vertices.shape)
    return stone_from_vertices(3.1 * (vertices + off), name="measured stone")


def texts(figure) -> list[str]:
    """Return everything that is written in a figure."""
    written = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    return [text.get_text() for text in written if text.get_text().strip()]


def boxes(figure) -> list[tuple[str, np.ndarray]]:
    """Return every text that is seen with its box on the page, by the renderer [pixels]."""
    found = []
    for holder in (figure, *figure.axes):
        shown = [text for text in holder.texts if text.get_text().strip()]
        found += zip([text.get_text() for text in shown], text_boxes(holder), strict=True)
    return found


def overlaps(figure, found=None) -> list[tuple[str, str]]:
    """Return the pairs of texts whose boxes, by default all of the figure's, overlap."""
    found = boxes(figure) if found is None else found
    names, all_boxes = [name for name, _ in found], np.reshape([box for _, box in found], (-1, 4))
    low, high = all_boxes[:, :2], all_boxes[:, 2:]
    below = (low[:, None] < high).all(axis=2)
    return [(names[i], names[k]) for i, k in np.argwhere(np.tril(below & below.T, -1))]


def assert_within(figure):
    """No text may be cut by the edge of the page."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    canvas = FigureCanvasAgg(figure)
    with boxes_for_letters():
        canvas.draw()  # which puts the labels of the axes in their place
    renderer = canvas.get_renderer()
    for text in figure.findobj(Text):
        if text.get_text() and text.get_visible():
            box = text.get_window_extent(renderer)
            assert figure.bbox.x0 <= box.x0, text
            assert figure.bbox.y0 <= box.y0, text
            assert box.x1 <= figure.bbox.x1, text
            assert box.y1 <= figure.bbox.y1, text

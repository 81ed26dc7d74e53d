"""Polygons that lines cut in values and derivatives, where more than two lines run through a point."""

from __future__ import annotations

import numpy as np
import pytest

from gemrender.beam.clipping import area, keep_below, opens
from gemrender.beam.compiled import STEP

#: Areas and their derivatives: rounding of some ten cuts.
ROUNDING = 1e-12
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def cut(corners, lines):
    """Cut a polygon by lines a + b u + c v <= 0, rows (a, b, c); return table, part, number of corners."""
    table = np.zeros((3, len(corners) + len(lines), 3), complex)
    table[0, : len(corners), :2] = corners
    part, n = 0, len(corners)
    for a, b, c in np.asarray(lines, complex):
        part, n = keep_below(table, part, n, a, b, c)
    return table, part, n


@pytest.mark.parametrize("size", [1e-17, 1e-16, 1e-15, 1e-13, 1e-11, 1e-9])
def test_edges_of_no_length_change_no_area(size):
    """Rationale: what opens at a point is of second order, whatever edges rounding leaves there.

    A square's corner is an edge of no length, which moves anyhow; its diagonal cuts that edge. Below it is a
    triangle; its lower side moves up at q and the diagonal down at w.

    Expected: of the area (1 - (w + q) t)^2 / 2 the derivative -(w + q).
    """
    rng = np.random.default_rng(3)
    for _ in range(200):
        x, y = rng.uniform(-1.0, 1.0, 2)
        p, q, r, s, w = rng.normal(0.0, 1.0, 5)
        corners = np.array([[x, y], [x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]])
        corners[:2] += rng.uniform(-size, size, (2, 2))
        speeds = np.array([[p, s], [r, q], [0.0, q], [0.0, 0.0], [p, 0.0]])
        offset = x - y + rng.uniform(-size, size) + 1j * STEP * w
        table, part, n = cut(corners + 1j * STEP * speeds, [[offset, -1.0, 1.0]])
        found = area(table[part], n)
        assert found.real == pytest.approx(0.5, abs=10.0 * size + ROUNDING)
        assert found.imag / STEP == pytest.approx(-w - q, abs=20.0 * size + ROUNDING)


def test_distances_of_less_than_the_step_of_derivatives():
    """Rationale: at the middle of symmetric stones rounding leaves distances of 1e-130, beside which the
    1e-30 of derivatives are no small part: a quotient of complex numbers is one of derivatives.

    Expected: corners and area are those of real numbers.
    """
    corners = np.array([[-8.5e-130, -3.7e-132], [8.6e-131, -4.4e-132], [0.5, 0.5], [0.0, 0.5]])
    moving = corners + 1j * STEP * np.array([[0.3, 0.7], [-0.2, 0.1], [0.0, 1.0], [1.0, 0.0]])
    table, part, n = cut(moving, [[0.4j * STEP, -0.900341, 0.063302]])
    expected, other, m = cut(corners, [[0.0, -0.900341, 0.063302]])
    assert np.array_equal(table[part, :n, :2].real, expected[other, :m, :2].real)
    left = 0.5 * 0.5**2 * (1.0 - 0.063302 / 0.900341)
    assert area(table[part], n).real == pytest.approx(left, abs=ROUNDING)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("offset", "turn", "gap", "is_told"),
    [(0.0, 0.0, 0.0, False), (1.0, 0.0, 0.0, True), (0.0, 1.0, 1e-15, True), (0.0, 1e-9, 0.0, False),
     (1.0, 0.0, 1e-8, False)],
)  # fmt: skip
def test_a_line_on_an_edge_opens_where_it_moves_otherwise(sign, offset, turn, gap, is_told):
    """A line on the square's edge u = 1, or beside it, that moves, or turns, or next to not."""
    line = sign * np.array([-1.0 + gap + 1j * STEP * offset, 1.0, 1j * STEP * turn])
    table = cut(SQUARE, [line])[0]
    assert opens(table[0], len(SQUARE), line[1], line[2]) is is_told
    assert not opens(table[0].real.copy(), len(SQUARE), line[1].real, line[2].real)

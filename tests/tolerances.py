"""Tolerances of the tests, each with its reason. Lengths are in girdle radii unless said otherwise."""

from __future__ import annotations

import math

from gemrender.stone.solid import ROUND_PIECES

#: Coordinates of order 1 after a few dozen float64 operations (rounding 1.1e-16 each).
ROUNDING = 1e-14

#: Distance of points to planes. On facets as steep as the ranges allow (normal 0.005 from horizontal)
#: a height is computed from the plane with its rounding errors multiplied by some hundreds.
PLANE = 1e-12

#: Laboratories print heights in per cent with one decimal.
PRINTED_PERCENT = 0.05

#: Largest distance of the mesh's straight pieces of a round girdle from the wall.
SAGITTA = (math.pi / ROUND_PIECES) ** 2 / 2

#: Volume that the mesh lacks [girdle radius^3]: between each arc piece and the wall lies an area of 2/3
#: its length times its sagitta, under at most 0.2 of girdle height (10 % of the diameter).
MESH_VOLUME = 2 / 3 * 2 * math.pi * SAGITTA * 0.2

#: Volume by quadrature over the disc [girdle radius^3]: midpoint rule of 2000 steps along the radius, where
#: the height has kinks: (1 / 2000)^2 times the slopes, of order 1.
QUADRATURE_VOLUME = 1e-6

#: Angles by arccos of a normal's component [deg]: rounding, in degrees, over the sine of the angle.
ANGLE_DEG = 1e-12 * 180 / math.pi

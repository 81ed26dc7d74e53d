"""Tolerances of the tests, each with its reason. Lengths are in girdle radii unless said otherwise."""

from __future__ import annotations

import math

from gemrender.stone.mesh import ARC_SEGMENTS

#: Coordinates of order 1 after a few dozen float64 operations (rounding 1.1e-16 each).
ROUNDING = 1e-14

#: Distance of points to planes. On facets as steep as the ranges allow (normal 0.005 from horizontal)
#: a height is computed from the plane with its rounding errors multiplied by some hundreds.
PLANE = 1e-12

#: Laboratories print heights in per cent with one decimal.
PRINTED_PERCENT = 0.05

#: Largest distance of the mesh's straight arc pieces from the wall.
SAGITTA = (math.pi / 16 / ARC_SEGMENTS) ** 2 / 2

#: Volume that the mesh lacks [girdle radius^3]: between each arc piece and the wall lies an area of 2/3
#: its length times its sagitta, under at most 0.2 of girdle height (10 % of the diameter).
MESH_VOLUME = 2 / 3 * 2 * math.pi * SAGITTA * 0.2

#: Volume by quadrature over the disc [girdle radius^3]: midpoint rule of 2000 steps along the radius, where
#: the height has kinks: (1 / 2000)^2 times the slopes, of order 1.
QUADRATURE_VOLUME = 1e-6

#: Points that one bisection, or the fixed point of the edge, puts on a measured stone's wall.
MEASURED_WALL = 1e-12

#: Normals of a measured wall at the corners of neighbouring faces: they are taken 1e-6 of a face inside it,
#: and a face's normals turn by pi / 8 / ARC_SEGMENTS; with that of thin faces some times as much.
CORNER_NORMAL = 10 * 1e-6 * math.pi / 8 / ARC_SEGMENTS

#: By how much a wall measured to 1e-3 bends at its vertices [rad]: changes of radius over pi / 8.
WALL_BEND = 0.01

#: Angles by arccos of a normal's component [deg]: rounding, in degrees, over the sine of the angle.
ANGLE_DEG = 1e-12 * 180 / math.pi

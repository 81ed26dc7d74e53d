"""Tolerances of the physics tests, each with its reason. Lengths in girdle radii, intensities in per cent."""

from __future__ import annotations

# ---- Rounding ----

#: Values of order 1 after some dozen operations in float64 (rounding 1.1e-16 each).
ROUNDING = 1e-14
#: Angles from arccos: near 1 degree its slope is 60.
ROUNDED_ANGLE = 1e-12
#: How far from the critical angle a ray is on the side that it was meant to be [deg]: that angle's rounding,
#: and the rounding of what a stone's planes are made of, with room.
CRITICAL_MARGIN_DEG = 1e-9
#: Where and in which direction a float64 path of at most FEW_REFLECTIONS ends: 1e-15, about doubled by each
#: reflection off the curved girdle. (After a hundred, two float64 tracers part.)
FEW_REFLECTIONS = 20
PATH = 1e-9
#: The intensity at its end: T falls from 80 % to 0 within the last few per cent of the cosine.
PATH_PERCENT = 1000 * PATH
#: Values of order 1, and intensities, that an Observation keeps in single precision (2^-24).
SINGLE = 1.2e-7
SINGLE_PERCENT = 100 * SINGLE

# ---- Numbers that a source prints ----

FOUR_DECIMALS, FIVE_DECIMALS = 0.5e-4, 0.5e-5
#: Degrees, shares and scores with one decimal.
ONE_DECIMAL = 0.05

# ---- Maps of so many pixels ----

#: The eight pixels, mirrored and turned, that a ray along an edge has in a map of 96 x 96, in per cent of the
#: stone's: what rounding of a symmetric stone's vertices may change.
ORBIT_96 = 8 * 100 / 7232


def outline_error(half_width: float, resolution: int) -> float:
    """Error of an area by counting the cells of a map whose centres it covers [girdle radius^2].

    Along an outline the errors of the cells nearly cancel, except where a straight edge runs along a row:
    at worst all across the map and half a cell off.
    """
    return half_width * (2 * half_width / resolution)

"""Tolerances of the physics tests, each with its reason. Lengths in girdle radii, intensities in per cent."""

from __future__ import annotations

# ---- Rounding in double precision ----

#: Values of order 1 after some dozen operations in float64 (rounding 1.1e-16 each).
ROUNDING = 1e-14
#: Angles from arccos: near 1 degree its slope is 60.
ROUNDED_ANGLE = 1e-12
#: Fresnel's laws in sines and tangents lose digits where the two angles are close.
ROUNDED_SINES = 1e-12
#: How far from the critical angle a ray is on the side that it was meant to be [deg]: that angle's rounding,
#: and the rounding of what a stone's planes are made of, with room.
CRITICAL_MARGIN_DEG = 1e-9
#: Where and in which direction a float64 path of at most FEW_REFLECTIONS ends: 1e-15, about doubled by each
#: reflection off the curved girdle. (After a hundred, two float64 tracers part.)
FEW_REFLECTIONS = 20
PATH = 1e-9
#: The intensity at its end: T falls from 80 % to 0 within the last few per cent of the cosine.
PATH_PERCENT = 1000 * PATH

# ---- Rounding in single precision (2^-24 = 6e-8) ----

#: Values of order 1, and intensities, that an Observation keeps in single precision.
SINGLE = 1.2e-7
SINGLE_PERCENT = 100 * SINGLE
#: Coordinates and directions that come out of two or three such roundings.
COORDINATE = 3e-7
#: Radiances of order 1, and intensities, after some dozen.
SINGLE_RADIANCE = 1e-6
SINGLE_INTENSITY = 100 * SINGLE_RADIANCE

# ---- Numbers that a source prints ----

FOUR_DECIMALS, FIVE_DECIMALS = 0.5e-4, 0.5e-5
#: Degrees, shares and scores with one decimal.
ONE_DECIMAL = 0.05

# ---- Maps of so many pixels ----

#: The eight pixels, mirrored and turned, that a ray along an edge has in a map of 96 x 96, in per cent of the
#: stone's: what rounding of a symmetric stone's vertices may change.
ORBIT_96 = 8 * 100 / 7232
#: Share of pixels in which an image and its mirror image may differ: rays within rounding of an edge, and
#: those that are reflected a hundred times.
SYMMETRIC_SHARE = 1e-3
#: Share of rays with the same facet sequence in both tracers [%]: as many as the cross-check wants of exits.
SAME_PATH = 99.9
#: Error of Average and Rear of a map of 512 x 512 by sampling [%]. The edges of the facets' images, some 60
#: long, cut 20 000 of its 200 000 cells, each right to 0.3 times the step in intensity (about 50): together
#: 15 sqrt(20 000) / 200 000 = 0.01. For Rear the steps are 100 and symmetry lets eight errors count as one:
#: 0.025 was found. This is two and a half times that.
SAMPLING_512 = 0.06


def outline_error(half_width: float, resolution: int) -> float:
    """Error of an area by counting the cells of a map whose centres it covers [girdle radius^2].

    Along an outline the errors of the cells nearly cancel, except where a straight edge runs along a row:
    at worst all across the map and half a cell off.
    """
    return half_width * (2 * half_width / resolution)


# ---- Light by `path` ----

#: Standard deviations that a mean by chance may be off: 7 in a million are further off, and the tests make
#: some 300 such comparisons, so that a wrong alarm is one in 500 (their seeds are fixed).
Z = 4.5
#: Radiance beside 1 in a white furnace: rounding of a throughput of some dozen factors.
FURNACE_ROUNDING = 1e-5
#: Share of pixels that leak in a white furnace, and what they cost in the mean: 1 in 2000 and 5e-5 were found
#: in a map of 64 x 64 of sample 2, nothing in the maps of the tests.
FURNACE_PIXELS = 2e-3
FURNACE_DEFICIT = 2e-4

# ---- Light by `gem_path` ----

#: Standard errors that the mean over a million samples may be off: 3 in a thousand are further off by chance,
#: so that of 40 such means one is in one case of nine. Their seeds are fixed.
THREE_SIGMA = 3.0
#: Chance that the pictures of two integrators which agree are told to differ, over all their pixels.
SIGNIFICANCE = 0.01
#: Share of energy that may be lost or made where wavelengths part.
WHITE = 5e-3
#: Radiance of a slab from 65 536 samples, by its mean: roulette alone makes noise there, 1e-4 of it.
SLAB = 1e-3
#: Angle by which a prism deviates [rad]. Directions in single precision are right to 1e-7; index tables have
#: rows of 1 nm: 2e-7; the lamp is 1e5 prisms away, as far off as the ray's displacement by a prism: 5e-6.
DEVIATION = 1e-5
#: Share of rays that may go other ways where facets are found in other ways: those within rounding of an
#: edge, which are more with each reflection. Half a per cent were found.
OTHER_WAY = 0.01
#: Radiance along a ray that goes the same way by another arithmetic: rounding of a few dozen directions.
SAME_WAY = 1e-3
#: Planes and cylinder read back from a mesh of size 4, rounded to single precision: 1e-7 of it.
READ_BACK = 1e-6

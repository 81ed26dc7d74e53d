"""Tolerances of the tests of the exact engine, each with its reason."""

from __future__ import annotations

#: Areas [girdle radius^2] and shares: some thousand polygons, each right to rounding (1e-16).
TILING = 1e-12
#: What the issue of exact scores asks of the tiling; the tests of 200 stones use it.
TILING_ASKED = 1e-9
#: Intensity of a polygon's light [%] beside the reference's: rounding, multiplied near the critical angle,
#: where T falls from 80 % to 0 within the last few per cent of the cosine.
FACET_PERCENT = 1e-7
#: A point this close to an edge may fall to either side of it [girdle radius]: rounding, multiplied by some
#: hundred reflections.
EDGE = 1e-9
#: Derivatives beside central differences, relative to the largest of a stone's: as the issue asks.
DERIVATIVE = 1e-5
#: Average and Rear of a map of 256 x 256 beside the exact ones [%]: edges 60 long cut 10 000 of 51 000 cells,
#: each right to 0.3 of the step in intensity: 15 sqrt(10 000) / 51 000 = 0.03 for Average and twice that for
#: Rear, whose step is 100; symmetry lets eight errors count as one. This is some three standard deviations.
SAMPLING_256 = 0.25
#: The same at 1024 x 1024, where errors are 4^1.5 = 8 times smaller.
SAMPLING_1024 = SAMPLING_256 / 8
#: Share of pixels with the reference's facet sequence [%]. A third of the light of a stone seen from the side
#: runs about its girdle, a hundred reflections long, where two float64 tracers part.
SAME_PATH = 99.5
#: The same among rays of few reflections: but for one in ten thousand within rounding of an edge.
SAME_PATH_FEW = 99.99
#: A measured wall is met where a bisection finds it: to 1e-13, from where both tracers go their ways.
SAME_PATH_MEASURED = 99.95

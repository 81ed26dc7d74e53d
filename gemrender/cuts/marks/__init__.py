"""What the drawing of a cut says at its arrows: lengths, angles, shares and names of places, at meet points.

A family states them in its method `marks`: those of every cut are made by `usual_marks`, those of its own by
the classes here. All are measured from the points, so that a drawing shows what the stone is.
"""

from gemrender.cuts.marks.breaks import break_marks
from gemrender.cuts.marks.kinds import VIEWS, Angle, Length, Mark, Place, Share, Tilt, slope
from gemrender.cuts.marks.steps import corner_mark, step_marks
from gemrender.cuts.marks.usual import apex, tilt, usual_marks

__all__ = [
    "VIEWS",
    "Angle",
    "Length",
    "Mark",
    "Place",
    "Share",
    "Tilt",
    "apex",
    "break_marks",
    "corner_mark",
    "slope",
    "step_marks",
    "tilt",
    "usual_marks",
]

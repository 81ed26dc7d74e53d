"""How the facets of a family are found: meet points first, then the planes through them.

A cutter brings facets to meet points, and so does a family: it places the points, real or complex, and says
which of them bound each facet. Planes, tiers and checks follow.
"""

from gemrender.cuts.construction.meet_points import Construction

__all__ = ["Construction"]

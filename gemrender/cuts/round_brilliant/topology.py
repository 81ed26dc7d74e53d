"""How the 57 vertices of a round brilliant make 58 facets and 78 triangles.

Indices only, the same for every stone. With azimuth step pi/8 and k = 0..7, table corners, bezel mains
and pavilion mains lie at azimuth 2k, star tips and lower-girdle contacts at 2k + 1 (the paper's figures
5 and 6; `docs/model.md`, section 2). Every polygon runs anticlockwise seen from outside the stone.
"""

from __future__ import annotations

import numpy as np

__all__ = [
    "CONTACT",
    "CULET",
    "FACET_KINDS",
    "FACET_NAMES",
    "FACET_POLYGONS",
    "GIRDLE",
    "GIRDLE_LOWER",
    "GIRDLE_UPPER",
    "IS_CROWN",
    "LOWER_GIRDLE_FACETS",
    "LOWER_GIRDLE_TRIANGLES",
    "N_FACETS",
    "N_SECTORS",
    "N_TRIANGLES",
    "N_VERTICES",
    "STAR_TIP",
    "TABLE_CORNER",
    "TRIANGLES",
    "TRIANGLE_FACET",
    "UPPER_GIRDLE_FACETS",
    "UPPER_GIRDLE_TRIANGLES",
    "VERTEX_LABELS",
]

N_VERTICES = 57
N_TRIANGLES = 78
N_SECTORS = 16  # of the girdle, one between two neighbouring girdle vertices
N_FACETS = 58  # 57 planes and the girdle

# Rows of the (57, 3) vertex array.
TABLE_CORNER = np.arange(0, 8)
STAR_TIP = np.arange(8, 16)
GIRDLE_UPPER = np.arange(16, 32)
GIRDLE_LOWER = np.arange(32, 48)
CONTACT = np.arange(48, 56)
CULET = 56

VERTEX_LABELS: tuple[str, ...] = (
    *(f"table_{k}" for k in range(8)),
    *(f"star_{k}" for k in range(8)),
    *(f"girdle_upper_{j}" for j in range(16)),
    *(f"girdle_lower_{j}" for j in range(16)),
    *(f"contact_{k}" for k in range(8)),
    "culet",
)


def _polygons() -> list[tuple[str, tuple[int, ...]]]:
    t, s, u, b, c = (x.tolist() for x in (TABLE_CORNER, STAR_TIP, GIRDLE_UPPER, GIRDLE_LOWER, CONTACT))
    out: list[tuple[str, tuple[int, ...]]] = [("table", tuple(t))]
    out += [("star", (t[k], s[k], t[(k + 1) % 8])) for k in range(8)]
    out += [("bezel", (t[k], s[k - 1], u[2 * k], s[k])) for k in range(8)]
    out += [("upper_girdle", (s[j // 2], u[j], u[(j + 1) % 16])) for j in range(16)]
    out += [("lower_girdle", (c[j // 2], b[(j + 1) % 16], b[j])) for j in range(16)]
    out += [("pavilion_main", (CULET, c[k], b[2 * k], c[k - 1])) for k in range(8)]
    return out


#: Vertices of the 57 plane facets, in order: table, 8 stars, 8 bezels, 16 upper, 16 lower girdle, 8 mains.
FACET_POLYGONS: tuple[tuple[int, ...], ...] = tuple(polygon for _, polygon in _polygons())

#: Kind of each of the 58 facets; the last is the girdle.
FACET_KINDS: tuple[str, ...] = (*(kind for kind, _ in _polygons()), "girdle")

#: Number of the girdle among the facets.
GIRDLE = FACET_KINDS.index("girdle")

#: (57,) bool: which of the plane facets belong to the crown.
IS_CROWN = np.array([kind in ("table", "star", "bezel", "upper_girdle") for kind in FACET_KINDS[:-1]])

UPPER_GIRDLE_FACETS = np.array([i for i, kind in enumerate(FACET_KINDS) if kind == "upper_girdle"])
LOWER_GIRDLE_FACETS = np.array([i for i, kind in enumerate(FACET_KINDS) if kind == "lower_girdle"])


def _names() -> tuple[str, ...]:
    counted = {"table", "girdle"}
    seen: dict[str, int] = {}
    out = []
    for kind in FACET_KINDS:
        number = seen[kind] = seen.get(kind, 0) + 1
        out.append(kind if kind in counted else f"{kind}_{number}")
    return tuple(out)


#: A name for each of the 58 facets: "table", "star_1" ... "pavilion_main_8", "girdle".
FACET_NAMES = _names()

# Fans from the first vertex: the octagon is cut into 6 triangles and each kite, along its long diagonal,
# into 2.
_FANS = [
    (facet, polygon[0], polygon[i], polygon[i + 1])
    for facet, polygon in enumerate(FACET_POLYGONS)
    for i in range(1, len(polygon) - 1)
]

#: (78,) int: the facet that each triangle belongs to.
TRIANGLE_FACET = np.array([fan[0] for fan in _FANS])

#: The triangle that each upper and each lower girdle facet is.
UPPER_GIRDLE_TRIANGLES = np.searchsorted(TRIANGLE_FACET, UPPER_GIRDLE_FACETS)
LOWER_GIRDLE_TRIANGLES = np.searchsorted(TRIANGLE_FACET, LOWER_GIRDLE_FACETS)

#: (78, 3) int: vertices of each triangle. Of a girdle facet the first vertex is the one off the girdle.
TRIANGLES = np.array([fan[1:] for fan in _FANS])

for _array in (
    *(TABLE_CORNER, STAR_TIP, GIRDLE_UPPER, GIRDLE_LOWER, CONTACT, TRIANGLES, TRIANGLE_FACET, IS_CROWN),
    *(UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS, UPPER_GIRDLE_TRIANGLES, LOWER_GIRDLE_TRIANGLES),
):
    _array.setflags(write=False)

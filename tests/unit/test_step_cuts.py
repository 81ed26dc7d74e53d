"""Step cuts: facets, symmetry, proportions measured from the planes, volumes in closed form, hollow ones."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from gemrender.cuts.construction.steps import profile, trapezoid
from gemrender.cuts.families import families
from gemrender.cuts.girdle_words import CULET_WORDS
from gemrender.errors import InputError
from gemrender.stone.symmetry import find_symmetry

#: What is measured from planes is what was asked: rounding.
ASKED = 1e-9
#: Volumes of a few dozen products: rounding, relative.
ROUNDING = 1e-12

CUTS = {
    "emerald": {
        "length_to_width": 1.37,
        "corner": 13.0,
        "table": 63.0,
        "crown_height": 12.7,
        "crown_bulge": 1.9,
    },
    "emerald, culet": {"length_to_width": 1.8, "culet": 7.0, "pavilion_depth": 45.0, "pavilion_bulge": 4.0},
    "emerald, five steps": {"length_to_width": 1.2, "pavilion_steps": 5, "girdle_thickness": 2.0},
    "asscher": {"corner": 24.0, "table": 55.0, "crown_height": 16.0},
    "asscher, long": {"length_to_width": 1.1, "pavilion_steps": 4, "culet": 3.0},
    "baguette": {"length_to_width": 3.1, "table": 70.0},
    "baguette, three steps": {"length_to_width": 1.0, "steps": 3},
    "baguette, tapered": {"length_to_width": 2.2, "taper": 72.0},
}


def cut(name):
    return families()[name.partition(",")[0]](**CUTS[name])


@pytest.fixture(params=CUTS)
def any_cut(request):
    return cut(request.param)


def corners_of(construction, kind):
    """Return the corners of the first facet of a kind, (k, 3), in the stone's unit."""
    return construction.points[list(construction.corners[construction.kinds.index(kind)])]


@pytest.mark.parametrize("name", ["emerald", "asscher"])
@pytest.mark.parametrize("rows", [3, 4, 5])
def test_emerald_and_asscher_cuts_have_eight_facets_in_each_row(name, rows):
    kind = families()[name]
    of_row = {"side": 2, "end": 2, "corner": 4}
    expected = Counter(table=1, girdle=8)
    for part, count in (("crown", 3), ("pavilion", rows)):
        expected += Counter({f"{part}_{edge}_{k + 1}": n for k in range(count) for edge, n in of_row.items()})
    assert Counter(kind(pavilion_steps=rows).construction().kinds) == expected
    with_culet = kind(pavilion_steps=rows, culet=5.0).stone()
    assert Counter(facet.kind for facet in with_culet.facets) == expected + Counter(culet=1)
    if rows == 3:  # the standard: 57, and 58 with a culet
        assert expected.total() == 57


@pytest.mark.parametrize("steps", [2, 3])
def test_baguettes_have_four_facets_in_each_row(steps):
    kinds = Counter(families()["baguette"](steps=steps).construction().kinds)
    parts = {f"{part}_{edge}_{k + 1}" for part in ("crown", "pavilion") for edge in ("side", "end")
             for k in range(steps)}  # fmt: skip
    assert kinds == Counter(table=1, girdle=4) + Counter(dict.fromkeys(parts, 2))


@pytest.mark.parametrize(
    ("name", "fold", "mirrors"),
    [("emerald", 2, 2), ("asscher", 4, 4), ("asscher, long", 2, 2), ("baguette", 2, 2),
     ("baguette, tapered", 1, 1)],
)  # fmt: skip
def test_symmetry(name, fold, mirrors):
    found = find_symmetry(cut(name).stone().solid)
    assert (found.fold, len(found.mirrors)) == (fold, mirrors)


def test_proportions_measured_from_the_planes_are_those_that_were_asked(any_cut):
    vertices = any_cut.stone().solid.polyhedron.vertices
    size = np.ptp(vertices, axis=0)
    percent = size[0] / 100
    asked = any_cut.values()
    assert size[1] == pytest.approx(2.0, abs=ASKED)
    assert size[1] / size[0] == pytest.approx(asked["length_to_width"], abs=ASKED)
    parts = ("crown_height", "girdle_thickness", "pavilion_depth")
    assert size[2] / percent == pytest.approx(sum(asked[part] for part in parts), abs=ASKED)
    top = vertices[vertices[:, 2] > vertices[:, 2].max() - ASKED]
    assert np.ptp(top[:, 0]) / percent == pytest.approx(asked["table"], abs=ASKED)
    # As far from the outline at the ends as at the sides of the wide end.
    assert size[1] - np.ptp(top[:, 1]) == pytest.approx(size[0] - np.ptp(top[:, 0]), abs=ASKED)
    assert top[0, 2] / percent - asked["girdle_thickness"] == pytest.approx(asked["crown_height"], abs=ASKED)
    assert vertices[:, 2].min() / percent == pytest.approx(-asked["pavilion_depth"], abs=ASKED)


@pytest.mark.parametrize("name", [name for name in CUTS if "tapered" not in name])
def test_the_bulge_is_how_far_the_steps_stand_out_of_the_straight_line(name):
    """Where two rows meet along the sides, the height above or below the line across the width."""
    asked, made = cut(name).values(), cut(name).construction()
    percent = 2.0 / asked["length_to_width"] / 100
    run = {"crown": 50 - asked["table"] / 2, "pavilion": 50 - asked.get("culet", 0.0) / 2}
    rise = {"crown": asked["crown_height"], "pavilion": asked["pavilion_depth"]}
    for part, girdle in (("crown", asked["girdle_thickness"]), ("pavilion", 0.0)):
        rows = sum(kind.startswith(f"{part}_side_") for kind in set(made.kinds))
        out = []
        for row in range(1, rows):
            ring = corners_of(made, f"{part}_side_{row}") / percent
            meets = ring[np.abs(ring[:, 2] - girdle).argmax()]
            way = (50 - abs(meets[0])) / run[part]
            assert way == pytest.approx(row / rows, abs=ASKED)  # rows of equal width
            out.append(abs(meets[2] - girdle) - way * rise[part])
        assert max(out) == pytest.approx(asked[f"{part}_bulge"], abs=ASKED)
        assert out == pytest.approx(out[::-1], abs=ASKED)


@pytest.mark.parametrize("name", ["emerald", "asscher", "baguette, three steps"])
def test_of_three_rows_the_middle_one_is_parallel_to_the_straight_line(name):
    made = cut(name).construction()
    rise = np.degrees(np.arccos(np.abs(made.planes[:, 2])))
    for part in ("crown", "pavilion"):
        angle = cut(name).alternatives()[f"{part}_angle"]
        assert rise[made.kinds.index(f"{part}_side_2")] == pytest.approx(angle, abs=ASKED)


def area(asked, share):
    """Area of a level in closed form, at a share of the way from the outline to the keel [unit^2]."""
    w = (1 - share) / asked["length_to_width"]
    h = 1 - share / asked["length_to_width"]
    c = w * 2 * asked.get("corner", 0.0) / 100
    return 4 * w * h - 2 * c * c


@pytest.mark.parametrize("name", [name for name in CUTS if "tapered" not in name])
def test_volume_is_the_sum_of_prismatoids(name):
    """Each row is a prismatoid: h/6 (bottom + 4 middle + top)."""
    asked = cut(name).values()
    percent = 2.0 / asked["length_to_width"] / 100
    total = area(asked, 0.0) * asked["girdle_thickness"] * percent
    rows = {"crown": asked.get("steps", 3), "pavilion": asked.get("steps") or asked["pavilion_steps"]}
    reach = {"crown": 1 - asked["table"] / 100, "pavilion": 1 - asked.get("culet", 0.0) / 100}
    height = {"crown": asked["crown_height"], "pavilion": asked["pavilion_depth"]}
    for part, n in rows.items():
        out = np.array([i * (n - i) / ((n // 2) * ((n + 1) // 2)) for i in range(n + 1)])
        levels = percent * (height[part] * np.arange(n + 1) / n + asked[f"{part}_bulge"] * out)
        shares = reach[part] * np.arange(n + 1) / n
        for (z, after), (s, t) in zip(pairwise(levels), pairwise(shares), strict=True):
            total += (after - z) / 6 * (area(asked, s) + 4 * area(asked, (s + t) / 2) + area(asked, t))
    assert cut(name).stone().solid.volume == pytest.approx(total, rel=ROUNDING)


def test_volume_is_that_of_the_hull_of_the_meet_points(any_cut):
    trimesh = pytest.importorskip("trimesh")
    hull = trimesh.convex.convex_hull(any_cut.construction().points)
    assert any_cut.stone().solid.volume == pytest.approx(hull.volume, rel=ASKED)


@pytest.mark.parametrize("name", ["emerald", "asscher, long"])
def test_the_facets_at_the_corners_run_to_the_ends_of_the_keel(name):
    made = cut(name).changed(culet=0.0).construction()
    last = cut(name).pavilion_steps
    for end in made.rings["keel"].tolist():
        meet = Counter(kind for kind, ring in zip(made.kinds, made.corners, strict=True) if end in ring)
        assert meet == {f"pavilion_corner_{last}": 2, f"pavilion_end_{last}": 1, f"pavilion_side_{last}": 2}


def test_the_keel_of_a_tapered_baguette_rises_to_its_narrow_end():
    made = cut("baguette, tapered").construction()
    wide, narrow = made.points[made.rings["keel"]]
    assert wide[1] > 0 > narrow[1]
    assert wide[2] < narrow[2] < 0
    assert wide[0] == narrow[0] == 0
    # The narrow end has the width that was asked, and the table's sides are parallel to the outline's.
    low = made.points[made.rings["pavilion_0"]]
    at_end = low[low[:, 1] < 0]
    assert np.ptp(at_end[:, 0]) / np.ptp(low[:, 0]) == pytest.approx(0.72, abs=ASKED)
    table = made.points[made.rings["crown_2"]]
    (x, y), (u, v) = ((ring[3] - ring[0])[:2] for ring in (low, table))
    assert x * v - y * u == pytest.approx(0.0, abs=ASKED)


def test_without_taper_the_trapezium_is_a_rectangle():
    plan = trapezoid(0.4, 1.0)
    assert plan.reach == 1
    assert plan.keel == pytest.approx(np.array([[0, 0.6], [0, -0.6]]))


@pytest.mark.parametrize(
    ("name", "values", "part"),
    [("emerald", {"crown_height": 6.0, "crown_bulge": 2.1}, "crown"),
     ("asscher", {"crown_height": 8.0, "crown_bulge": 2.7}, "crown"),
     ("baguette", {"crown_height": 5.0, "crown_bulge": 2.6}, "crown")],
)  # fmt: skip
def test_a_hollow_crown_or_pavilion_is_refused_in_one_line(name, values, part):
    kind = families()[name]
    with pytest.raises(InputError, match=f"^these make a hollow {part}: [^\n]*$"):
        kind(**values).stone()
    # At the edge of what is allowed, the last row is just not level.
    kind(**values | {"crown_bulge": values["crown_bulge"] - 0.2}).stone()


def test_rows_of_a_hollow_pavilion_are_refused():
    """No parameters in range make one; levels that do."""
    made = families()["emerald"]().construction()
    made.profiles["pavilion"] = profile(3, 1.0, 1.0, -0.1)
    with pytest.raises(InputError, match="hollow pavilion"):
        made.check()


@pytest.mark.parametrize("name", [name for name, kind in families().items() if hasattr(kind, "culet")])
def test_every_culet_is_told_in_words_too(name):
    """IGI calls a keel a long culet."""
    kind = families()[name]
    assert [kind(culet=words).culet for words in ("None", "Long")] == [0.0, 0.0]
    assert kind(culet="very small").culet == CULET_WORDS["very small"]

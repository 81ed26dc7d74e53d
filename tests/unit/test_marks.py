"""What drawings of families say at their arrows: it is what was asked, it is there, and nothing overlaps."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from displays_help import boxes, overlaps, texts
from thorough import chosen

from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.marks import VIEWS, Angle, Length, Place, Share, slope
from gemrender.cuts.random import random_member
from gemrender.report.displays import draw
from gemrender.report.displays.marks import spread

FAMILIES = {name: kind for name, kind in families().items() if issubclass(kind, Family)}
#: What is drawn is what was asked [%, deg]: rounding, of solids at the edges of their ranges.
ASKED = 1e-9
#: Lengths of order 1 after a few operations.
ROUNDING = 1e-12
#: What a drawing tells in its table of parameters alone: no line of the stone shows it.
IN_THE_TABLE = {"radiant": {"bulge"}}
#: Random members of each family.
MEMBERS = 12


def members(kind: type[Family], count: int = MEMBERS, seed: int = 7) -> list[Family]:
    rng = np.random.default_rng(seed)
    return [kind(), *(random_member(kind, rng) for _ in range(count))]


def asked(cut: Family) -> dict[str, float]:
    """Return all that can be asked of a cut: parameters, alternatives, the sum of the heights."""
    values = cut.values() | cut.alternatives()
    parts = [values.get(key) for key in ("crown_height", "girdle_thickness", "pavilion_depth")]
    return values | ({} if None in parts else {"depth": sum(parts)})


def is_none(kind: type[Family], name: str, value: object) -> bool:
    """Whether it is 0 for nothing at all, such as no culet."""
    part = kind.__dataclass_fields__.get(name)
    return part is not None and bool(part.metadata.get("or_zero")) and value == 0


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_marks_measure_what_was_asked(kind):
    for cut in members(kind):
        values = asked(cut)
        told = {
            mark.parameter: mark.value
            for mark in cut.marks()
            if mark.parameter in values
            and mark.value is not None
            and not is_none(kind, mark.parameter, values[mark.parameter])
        }
        assert told == pytest.approx({key: values[key] for key in told}, abs=ASKED)


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_every_number_that_can_be_asked_is_in_the_drawing(kind):
    """By itself, or by what may stand for it. One of 0, such as no culet, is none, and needs no mark."""
    least = {
        part.name: part.metadata["range"][0]
        for part in fields(kind)
        if part.metadata.get("or_zero")
        and part.metadata["unit"] != ""  # but not a triangle that is stretched
    }
    for cut in (kind(), kind(**least)):
        told = {mark.parameter for mark in cut.marks()}
        told |= {other.stands_for for other in kind.ALTERNATIVES if other.name in told}
        numbers = {part.name for part in fields(kind) if "range" in part.metadata and getattr(cut, part.name)}
        assert numbers - told - IN_THE_TABLE.get(kind.family(), set()) == set()


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_names_are_told_once_and_stand_in_a_view(kind):
    marks = kind().marks()
    assert len({mark.name for mark in marks}) == len(marks)
    assert {mark.view for mark in marks} <= VIEWS.keys()


DRAWN = [
    # A round brilliant without a culet has the drawing of the paper's proportions.
    *((name, {"culet": 2.0} if name == "round brilliant" else {}) for name in FAMILIES),
    ("oval", {"length_to_width": 1.0, "crown_height": 10.0, "girdle_thickness": 2.5}),
    ("marquise", {"length_to_width": 3.0, "culet": 2.0, "mains": 4}),
]
#: One that is round, one of steps, one of no mirror plane across, and what is not a family's default.
OF_KINDS = [case for case in DRAWN if case[0] in ("round brilliant", "emerald", "pear")] + DRAWN[-2:]


@pytest.mark.parametrize(("name", "changes"), chosen(DRAWN, OF_KINDS))
def test_the_drawing_has_them_all_and_no_text_lies_on_another(name, changes):
    cut = FAMILIES[name](**changes)
    figure = draw(cut.stone(name="x"), "outline")
    found = boxes(figure)
    assert overlaps(figure, found) == []
    width, height = figure.bbox.size
    for text, (left, bottom, right, top) in found:
        assert 0 <= left <= right <= width, text
        assert 0 <= bottom <= top <= height, text
    said = texts(figure)
    views = [view for view in VIEWS if view != "length" or not cut.IS_ROUND]
    drawn = dict(zip(("crown", "pavilion", "width", "length"), figure.axes, strict=False))
    for mark in cut.marks():
        assert mark.view in views
        assert mark.text in said
        if isinstance(mark, Length):
            assert_spans(drawn[mark.view], mark)
    assert {name.replace("_", " ") for name in asked(cut)} - {"depth"} <= set(said)


def assert_spans(axes, mark: Length) -> None:
    """A line of a dimension, or its extension lines, stand where it begins and ends."""
    page = VIEWS[mark.view]
    if mark.is_inside:
        ends = page @ np.stack([mark.start, mark.end], axis=1)
        shapes = [line.get_xydata() for line in axes.lines if line.get_xydata().shape == (2, 2)]
        assert min(np.abs(shape - ends.T).max() for shape in shapes) <= ROUNDING
        return
    along = int(np.flatnonzero(page[:, mark.axis])[0])
    lines = [line.get_xydata() for line in axes.lines]
    places = np.array(
        [line[0, along] for line in lines if len(line) == 2 and line[0, along] == line[1, along]]
    )
    for end in (mark.start, mark.end):
        assert np.abs(places - (page @ end)[along]).min() <= ROUNDING


# ---- The marks themselves ------------------------------------------------------------------------------


def point(*xyz: float) -> np.ndarray:
    return np.array(xyz)


def test_a_length_is_told_in_per_cent_of_a_whole_or_as_a_ratio():
    ends = {"name": "x", "view": "crown", "start": point(1, 3, 0), "end": point(-1, 5, 7)}
    assert Length(axis=1, whole=4.0, **ends).value == 50.0
    assert Length(axis=1, whole=4.0, per="length", **ends).text == "x 50.0 % of the length"
    assert Length(axis=1, whole=1.0, is_ratio=True, **ends).text == "x 2.00"
    assert Length(axis=0, whole=4.0, **ends).value == -50.0


def test_an_angle_is_that_of_its_view():
    corner, end = point(-1, 5, 0), point(0, 9, 1)
    assert slope("a", "width", corner, end).value == pytest.approx(45.0, abs=ROUNDING)
    assert slope("a", "length", corner, end).value == pytest.approx(
        np.degrees(np.arctan2(1, 4)), abs=ROUNDING
    )
    flat = Angle(name="a", view="pavilion", corner=point(0, 0, 0), start=point(1, 0, 5), end=point(-1, 1, 8))
    assert flat.value == pytest.approx(135.0, abs=ROUNDING)


def test_a_share_is_along_its_way():
    share = Share(name="s", view="crown", start=point(0, 0, 0), end=point(0, 4, 1), at=point(3, 1, 9))
    assert share.value == 25.0
    assert Place(name="wing", view="crown", at=point(0, 0, 0)).text == "wing"


@pytest.mark.parametrize("wanted", [[0.0, 1.0, 2.0], [0.0, 0.0, 0.0], [3.0, 0.1, 0.0, 0.2], [1.0]])
def test_texts_are_spread_around_where_they_are_wanted(wanted):
    """In order, apart, and with the same mean: that of least squares."""
    places = spread(wanted, 0.5)
    assert np.argsort(places, kind="stable").tolist() == np.argsort(wanted, kind="stable").tolist()
    assert (np.diff(np.sort(places)) >= 0.5 - ROUNDING).all()
    assert np.mean(places) == pytest.approx(np.mean(wanted), abs=ROUNDING)

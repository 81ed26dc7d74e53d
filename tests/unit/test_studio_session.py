"""The studio without a server: cuttings, frames, messages, and what is worked at."""

from __future__ import annotations

import json
import queue
import struct
import threading
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from solids import star_prism

import gemrender
from gemrender.cuts.crystal_axes import orientation
from gemrender.cuts.families import families
from gemrender.studio.cuttings import family_cutting, opened, present_values, stone_of
from gemrender.studio.desk import Desk
from gemrender.studio.frames import MOVING, RESTING, Wanted, frame
from gemrender.studio.live import Live
from gemrender.studio.protocol import MOST_MESSAGE, packed, unpacked
from gemrender.studio.studies import Outdated, studies
from gemrender.studio.texts import dropped_stones, known_material, saved

#: Heights go through angles and back.
SAME = 1e-9
#: Corners come in single precision.
SINGLE = 1e-5


def told(name, **changes):
    """What a page sends of a stone."""
    of = opened(gemrender.load_stone(name), name)
    facts = {"name": of.name, "material": of.material, "size_mm": of.size_mm}
    return {"number": 1, "cut": of.cut, **facts, **changes}


def read(message):
    """A message as the page reads it."""
    length = struct.unpack_from("<I", message)[0]
    header = json.loads(message[4 : 4 + length])
    arrays = {
        of["name"]: np.frombuffer(
            message, np.dtype(of["type"]), int(np.prod(of["shape"])), 4 + length + of["at"]
        ).reshape(of["shape"])
        for of in header["arrays"]
    }
    return header, arrays


# ---- Cuttings ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["inoue-3", "oval-classic", "emerald-even", "cushion-antique", "round-brilliant-painted"]
)
def test_an_opened_stone_is_made_again_from_its_cutting(name):
    stone = gemrender.load_stone(name)
    made = Wanted.of(json.loads(json.dumps(told(name)))).stone({})
    assert made.facet_names == stone.facet_names
    assert np.abs(made.solid.planes - stone.solid.planes).max() < SAME


@pytest.mark.parametrize("name", ["inoue-3", "oval-classic", "a design"])
@pytest.mark.parametrize("lies", [{"c_axis": [1.0, 0.0, 2.0]}, {"angles": [10.0, 20.0, 30.0]}])
def test_a_crystal_lies_as_before_when_a_cut_is_changed(name, lies):
    design = saved(gemrender.load_stone("trilliant-solitaire"), "asc")
    stone = dropped_stones("t.asc", design)[0] if name == "a design" else gemrender.load_stone(name)
    stone = replace(stone, crystal=orientation(**lies))
    made = stone_of(json.loads(json.dumps(opened(stone, "").cut)), {}, "changed", "sapphire")
    assert made.crystal.axes == stone.crystal.axes


@pytest.mark.parametrize(
    "lies", ["table", {}, {"c_axis": "up"}, {"c_axis": [0, 0, 0]}, {"angles": [1, 2, "x"]}]
)
def test_a_crystal_that_lies_nowhere_is_refused(lies):
    cut = {**family_cutting("oval").cut, "crystal": lies}
    refused(lambda: stone_of(cut, {}, "new", "sapphire"), *lies if isinstance(lies, dict) else ["crystal"])


@pytest.mark.parametrize("family", families())
def test_every_family_can_be_begun_with_and_its_values_lie_on_its_sliders(family):
    of = family_cutting(family)
    for slider in of.sliders:
        if slider.choices:
            assert slider.value in slider.choices
        else:
            assert (
                slider.least - SAME <= slider.low <= slider.value <= slider.high <= slider.most + slider.step
            )
    assert stone_of(of.cut, {}, "new", None).is_convex


@pytest.mark.parametrize("meets", ["kept", "loose", "free"])
def test_a_designs_tier_turns_whatever_becomes_of_its_meets(meets):
    (stone,) = dropped_stones("t.asc", saved(gemrender.load_stone("trilliant-solitaire"), "asc"))
    of = opened(stone, "")
    slider = next(each for each in of.sliders if each.group == "Pavilion" and each.unit)
    cut = {**of.cut, "meets": meets, "values": {slider.name: slider.value + 0.2}}
    made = stone_of(cut, {}, "turned", None)
    assert len(made.facets) == len(stone.facets)
    angles = np.degrees(np.arccos(np.abs(made.facet_normals[:, 2])))
    assert np.isclose(angles, slider.value + 0.2, atol=1e-6).any()


def test_a_tiers_distance_is_its_own_and_an_angle_that_turns_takes_it_along():
    (stone,) = dropped_stones("t.asc", saved(gemrender.load_stone("trilliant-solitaire"), "asc"))
    of = opened(stone, "")
    sliders = {slider.name: slider for slider in of.sliders}
    assert present_values(stone) == {name: slider.value for name, slider in sliders.items()}
    angle = next(name for name, slider in sliders.items() if slider.group == "Pavilion" and slider.unit)
    distance = angle.replace(" angle", " distance")
    assert {"Crown", "Girdle", "Pavilion"} == {slider.group for slider in of.sliders}

    def values(meets, **changed):
        return present_values(stone_of({**of.cut, "meets": meets, "values": changed}, {}, "changed", None))

    wanted = sliders[distance].value - 0.01
    moved = values("free", **{distance: wanted})
    assert moved == {**present_values(stone), distance: wanted}
    turned = values("loose", **{angle: sliders[angle].value + 0.5})
    assert abs(turned[distance] - sliders[distance].value) > SAME
    both = values("loose", **{angle: sliders[angle].value + 0.5, distance: wanted})
    assert both[distance] == wanted
    refused(lambda: values("free", **{distance: -0.1}), "distance")


def test_a_stone_that_is_not_convex_is_not_opened():
    refused(lambda: opened(star_prism(), ""), "not convex")


def test_what_cannot_be_is_told_in_a_line():
    cut = told("inoue-3")["cut"]
    for bad, *parts in (
        ({**cut, "values": {**cut["values"], "table": 99.0}}, "table", "99"),
        ({"family": "no such"}, "family"),
        ({"family": ["oval"]}, "family"),
        ({"stone": "gone"}, "stone"),
        ({"design": "nonsense"}, "design"),
        ({"design": "x" * 300_000}, "design"),
        ({**cut, "values": []}, "values"),
    ):
        refused(lambda bad=bad: stone_of(bad, {}, "bad", None), *parts)


@pytest.mark.parametrize("material", ["/etc/passwd", "../glass.toml", "glass.toml", True, [], 0.5, 1e9])
def test_a_material_is_a_known_name_or_an_index_and_no_file(material):
    refused(lambda: known_material(material), "material")


# ---- Dropped files -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        'vertices = "/etc/passwd"',
        'design = "../secret.asc"',
        'mesh = "x.stl"',
        '[mesh]\nfile = "x.stl"',
        '[material]\nname = "/tmp/glass.toml"\n[cut]\nfamily = "oval"',
    ],
)
def test_a_dropped_file_cannot_name_another_one(text):
    refused(lambda: dropped_stones("stone.toml", text.encode()), "stone.toml")


def test_a_dropped_files_name_is_no_path():
    data = b'[cut]\nfamily = "oval"\n'
    for name in ("../../home/me/my-oval.toml", "C:\\stones\\my-oval.toml"):
        (stone,) = dropped_stones(name, data)
        assert (stone.name, stone.source) == ("my-oval", None)


def test_what_is_saved_opens_as_the_same_stone():
    desk = Desk()
    for kind in ("toml", "asc", "gcs", "vertices"):
        header, arrays = read(desk.answer({"type": "save", "kind": kind, "state": told("inoue-3")}, b""))
        (stone,) = dropped_stones(header["name"], arrays["file"].tobytes())
        assert stone.facet_kinds[0] == "table", kind
        assert gemrender.score(stone).average == pytest.approx(gemrender.score("inoue-3").average, abs=0.3)


# ---- Frames --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "tilt"), [("inoue-3", 0.0), ("inoue-3", 12.0), ("pear-classic", 0.0)])
def test_a_frames_polygons_and_their_images_make_the_score(name, tilt):
    wanted = Wanted.of(told(name, view={"tilt": tilt, "azimuth": 30.0}))
    header, arrays = read(packed(*frame(wanted, wanted.stone({}), RESTING)[:2]))
    exits = arrays["status"] == 0
    area, light = arrays["area"].astype(float), arrays["intensity"].astype(float)
    near = area[arrays["status"] == 2].sum() / area.sum() * 100
    assert light[exits] @ area[exits] / area.sum() == pytest.approx(
        header["score"]["average"], abs=near + 0.06
    )
    # Corners of all images: the area that each polygon's own outline has.
    starts = np.concatenate([[0], arrays["ends"][:-1]])
    x, y = arrays["corners"].astype(float).T
    k = int(np.argmax(area))
    of = slice(starts[k], arrays["ends"][k])
    for a, b, c, d, e, f in header["images"]:
        u, v = a * x[of] + c * y[of] + e, b * x[of] + d * y[of] + f
        shoelace = 0.5 * abs(u @ np.roll(v, -1) - v @ np.roll(u, -1))
        assert shoelace == pytest.approx(area[k], abs=SINGLE)
    same = gemrender.score(wanted.stone({}), tilt=tilt, tilt_azimuth=30.0)
    assert header["score"]["average"] == pytest.approx(
        same.average, abs=header["score"]["bound"] + same.bound
    )


def test_images_of_a_part_cover_the_view_once():
    wanted = Wanted.of(told("inoue-3"))
    header, arrays, _ = frame(wanted, wanted.stone({}))
    assert len(header["images"]) == 16
    total = 16 * arrays["area"].sum()
    assert total == pytest.approx(np.pi, rel=1e-3)
    middles = (
        np.add.reduceat(arrays["corners"], np.concatenate([[0], arrays["ends"][:-1]]))
        / np.diff(np.concatenate([[0], arrays["ends"]]))[:, None]
    )
    at = middles[np.argmax(arrays["area"])]
    places = {
        (round(float(a * at[0] + c * at[1]), 4), round(float(b * at[0] + d * at[1]), 4))
        for a, b, c, d, _, _ in header["images"]
    }
    assert len(places) in (8, 16)  # a polygon on a mirror plane falls on half as many places


@pytest.mark.parametrize(
    "bad",
    [
        {"view": {"tilt": 89}},
        {"view": {"tilt": "x"}},
        {"head": float("nan")},
        {"cut": 1},
        {"measures": "iso"},
    ],
)
def test_a_state_that_cannot_be_is_refused(bad):
    refused(lambda: Wanted.of({**told("inoue-3"), **bad}))


# ---- Messages ------------------------------------------------------------------------------------------


def test_messages_come_back_as_they_were_sent():
    arrays = {"a": np.arange(3, dtype=np.uint8), "b": np.linspace(0, 1, 5), "c": np.zeros((2, 3), np.float32)}
    header, found = read(packed({"type": "x", "nan": float("nan"), "of": np.float64(2)}, arrays))
    assert (header["type"], header["nan"], header["of"]) == ("x", None, 2.0)
    for name, values in arrays.items():
        assert np.array_equal(found[name], values)


@pytest.mark.parametrize(
    "message",
    [
        b"", b"\x01", b"\xff\xff\xff\xff{}", "no json", "[]", '{"type": 1}', "[" * 100_000,
        "x" * ((1 << 20) + 1), struct.pack("<I", 2 << 20) + b" " * (2 << 20),
    ],
)  # fmt: skip
def test_what_is_no_message_is_refused(message):
    refused(lambda: unpacked(message), "message")


def test_a_message_that_is_too_long_is_refused():
    refused(lambda: unpacked(bytes(MOST_MESSAGE + 1)), "longer")


def test_a_page_can_open_bundled_stones_by_name_only():
    desk = Desk()
    for name in ("/etc/passwd", "../scenes/inoue-3", "inoue-3.toml", 3):
        refused(lambda name=name: desk.answer({"type": "open", "bundled": name}, b""), "bundled")
    assert read(desk.answer({"type": "open", "bundled": "inoue-3"}, b""))[0]["stones"][0]["sliders"]


# ---- Studies and what is worked at ---------------------------------------------------------------------


def test_studies_tell_slopes_by_the_sliders_names_and_end_where_they_are_wanted_no_more():
    wanted = Wanted.of(told("inoue-3"))
    stone = wanted.stone({})
    calls = []

    def check():
        calls.append(1)
        if len(calls) > 40:
            raise Outdated

    found = []
    with pytest.raises(Outdated):
        found.extend(studies(wanted, stone, {}, check))
    slopes = found[0]["slopes"]
    assert {slider.name for slider in opened(stone, "").sliders} >= {"table", "crown_angle"} & slopes.keys()
    exact = {
        of.parameter: of.average for of in gemrender.sensitivity(stone).derivatives if of.kept == "angles"
    }
    assert slopes["pavilion_angle"]["average"] == pytest.approx(exact["pavilion_angle"], abs=0.2)
    assert {message["type"] for message in found} >= {"slopes", "curve"}


def at_work():
    """The threads of all studios."""
    return {thread for thread in threading.enumerate() if thread.name.startswith("studio ")}


def test_of_many_states_the_last_one_is_shown():
    sent, before = queue.Queue(), at_work()
    live = Live({}, sent.put)
    assert at_work() > before
    try:
        for number in range(40):
            cut = told("inoue-3")["cut"]
            values = {**cut["values"], "table": 50.0 + 0.1 * number}
            live.want({**told("inoue-3"), "number": number, "cut": {**cut, "values": values}})
        numbers = []
        while not numbers or numbers[-1] != 39:
            numbers.append(read(sent.get(timeout=60))[0]["number"])
        assert numbers == sorted(numbers)
        live.want({"number": 40, "cut": {"family": "none"}})
        while (header := read(sent.get(timeout=60))[0])["type"] != "refused":
            assert header["number"] == 39
        assert header["number"] == 40
        assert "family" in header["why"]
    finally:
        live.close(wait=60)
    assert at_work() <= before


def test_where_kernels_cannot_be_made_ready_frames_come_all_the_same(monkeypatch, caplog):
    def fail():
        raise RuntimeError("no kernels")

    monkeypatch.setattr("gemrender.studio.live.prepare", fail)
    sent = queue.Queue()
    live = Live({}, sent.put)
    try:
        live.want({**told("inoue-3"), "number": 7})
        assert read(sent.get(timeout=60))[0]["number"] == 7
    finally:
        live.close(wait=60)
    assert "no kernels" in caplog.text


def test_a_frame_that_moves_is_as_one_at_rest_but_for_its_bound():
    wanted = Wanted.of(told("inoue-1"))
    moving, resting = (frame(wanted, wanted.stone({}), effort)[0]["score"] for effort in (MOVING, RESTING))
    assert abs(moving["average"] - resting["average"]) <= moving["bound"] + resting["bound"]


def test_a_settled_frame_of_flat_facets_is_the_one_at_rest():
    wanted = Wanted.of(told("emerald-market"))
    (moving, arrays, _), (resting, same, _) = (
        frame(wanted, wanted.stone({}), effort) for effort in (MOVING, RESTING)
    )
    assert moving["isSettled"]
    assert {**moving, "seconds": 0} == {**resting, "seconds": 0}
    for name, values in arrays.items():
        np.testing.assert_array_equal(values, same[name], err_msg=name)


@pytest.mark.parametrize(("name", "frames"), [("emerald-market", 1), ("inoue-3", 2)])
def test_a_frame_is_sent_again_at_rest_where_it_becomes_finer(name, frames, monkeypatch):
    """A round girdle has more pieces then."""
    monkeypatch.setattr("gemrender.studio.live.studies", lambda *_: [])
    sent = queue.Queue()
    live = Live({}, sent.put)
    try:
        live.want(told(name))
        kinds = [""]
        while kinds[-1] != "rested":
            kinds.append(read(sent.get(timeout=60))[0]["type"])
    finally:
        live.close(wait=60)
    assert kinds[1:] == [*["frame"] * frames, "rested"]

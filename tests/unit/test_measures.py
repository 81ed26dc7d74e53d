"""Measures: closed forms of a slab, paths by hand, ties, the registry, sums over sets."""

from __future__ import annotations

import numpy as np
import pytest
from any_stones import design
from designs_help import level, ring, stone_of
from light_help import OF_A_VIEW, by_hand, light_of, spread_points, towards, values

from gemrender import InputError, Model, RayStatus, View, load_stone
from gemrender.measures import (
    Light,
    Measure,
    chosen_measures,
    contributions,
    evaluate,
    measure_named,
    measures,
)
from gemrender.measures.facets import half_area_number
from gemrender.measures.measure import TIE
from gemrender.optics import load_material
from gemrender.optics.fresnel import reflectance
from gemrender.reference import observe, paths
from gemrender.scoring import score_observation

NAMES = [
    "inoue", "iso", "cos", "sc2", "gemray-iso", "gemray-cos", "gemray-sc2", "aset", "window", "extinction",
    "wlr-like", "dispersion", "facets", "doubling",
]  # fmt: skip
#: Sums of per cent of order 100, float64.
ROUNDING = 1e-9
#: Maps are float32 [%].
SINGLE = 1e-5
#: Shares make 100 within this [%].
SUM = 1e-6
#: Rounding that paths over a round girdle, which spreads light, have multiplied [%].
TURNED = 1e-5
#: Flux by 50 views of 400 points.
WLR_FLUX = 1e-2
EDGE = np.cos(np.radians(10.0))  # of the viewer's head

#: A flat stone: f0 above, f1 below, four upright walls, and a sloping facet of crown and pavilion each.
FLAT = stone_of(
    np.vstack([level(1.0), level(1.0, down=True), ring(4, 90, 5.0), ring(1, 45, 3.0), ring(1, -45, 3.0)])
)
CROWN, PAVILION, WALL = 6, 7, 2


def slab_light(tilt):
    """Return all light through the middle of a wide slab of index 1.54."""
    slab = stone_of(np.vstack([level(0.05), level(0.05, down=True), ring(4, 90, 5.0)]))
    view = View(resolution=1, half_width=0.5, tilt_deg=tilt, tilt_azimuth_deg=90.0)
    found = paths(slab, view, follow="all", points=[(0.01, 0.02)], least=1e-13)
    return Light(paths=found, view=view, model=Model.of(slab))


def one(name, light):
    return evaluate([light], [measure_named(name)])[name]


# ---- Closed forms ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("tilt", [0.0, 10.0, 20.0, 30.0])
def test_light_return_of_a_slab(tilt):
    # R comes off the surface, T^2 R / (1 - R^2) out of the top, T^2 / (1 - R^2) straight through, in the
    # mirror direction and along the ray: d = cos 2 T and -1.
    light = slab_light(tilt)
    r = reflectance(np.cos(np.radians(tilt)), 1.54)
    back, through = (1 - r) ** 2 * r / (1 - r**2), (1 - r) ** 2 / (1 - r**2)
    d = np.cos(np.radians(2 * tilt))
    seen = values(light)
    brightness = {"iso": 1.0, "cos": d, "sc2": 2 * d * np.sqrt(1 - d**2)}
    for name, g in brightness.items():
        lit = 100 * g if tilt > 5 else 0.0  # behind the head
        assert seen[name]["surface"] == pytest.approx(lit * r, abs=ROUNDING)
        assert seen[name]["internal"] == pytest.approx(lit * back, abs=ROUNDING)
        assert seen[name]["value"] == pytest.approx(lit * (r + back), abs=ROUNDING)
        assert seen[name]["tied"] == 0
    aset = seen["aset"]
    zone = "blue" if 2 * tilt < 15 else "red" if 2 * tilt < 45 else "green"
    expected = dict.fromkeys(("green", "red", "blue"), 0.0) | {zone: 100 * back, "leak": 100 * through}
    for name, share in expected.items():
        assert aset[f"weighted_{name}"] == pytest.approx(share, abs=ROUNDING)
        assert aset[name] == (100 if name == "leak" else 0)
    assert aset["surface"] == pytest.approx(100 * r, abs=ROUNDING)
    assert seen["window"] == {"value": 100.0}
    assert seen["extinction"] == {"head": 0.0, "late_leak": 0.0, "tied": 0.0}


def test_gemray_stops_at_nine_hits_and_at_a_thousandth():
    # Of a slab, w = T R^k at hit k + 1: of index 1.54 and 20 deg, R = 0.046, w falls below 0.001 at hit 4,
    # so what leaves above at hit 2 counts, and at hit 4 no more.
    light = slab_light(20.0)
    r = reflectance(np.cos(np.radians(20)), 1.54)
    assert (1 - r) * r**2 > 1e-3 > (1 - r) * r**3
    assert one("gemray-iso", light)["internal"] == pytest.approx(100 * (1 - r) ** 2 * r, abs=ROUNDING)
    # Of light that loses nothing, the tenth hit does not count.
    hits = by_hand(FLAT, reflections=[8, 9], exit_direction=towards(0.5))
    assert contributions(measure_named("gemray-iso"), hits)[:, 1] == pytest.approx([0.96**2, 0])
    assert contributions(measure_named("iso"), hits)[:, 1] == pytest.approx([0.96**2, 0.96**2])
    ties = by_hand(FLAT, reflections=[8, 9], exit_direction=towards(EDGE))
    assert contributions(measure_named("gemray-iso"), ties)[:, 3] == pytest.approx([0.96**2, 0])


def test_gemray_of_the_table_is_a_mean_over_what_is_seen_through_it():
    light = by_hand(
        FLAT,
        area=[3.0, 1.0, 1.0],
        entry_facet=[0, 0, CROWN],
        exit_direction=np.concatenate([towards(0.5), towards(-0.5), towards(0.5)]),
    )
    found = one("gemray-cos", light)
    assert found["table_share"] == pytest.approx(80)
    assert found["table"] == pytest.approx(100 * 0.75 * 0.5 * 0.96**2)
    assert found["value"] == pytest.approx(100 * 0.8 * 0.5 * 0.96**2)
    no_table = one("gemray-iso", by_hand(FLAT, entry_facet=[CROWN], exit_direction=towards(0.5)))
    assert np.isnan(no_table["table"])
    assert no_table["table_share"] == 0


@pytest.mark.parametrize(
    ("elevation", "zone"),
    [
        *((elevation, "leak") for elevation in (-90, -0.1)),
        *((elevation, "green") for elevation in (0.1, 44.9)),
        *((elevation, "red") for elevation in (45.1, 74.9)),
        *((elevation, "blue") for elevation in (75.1, 90)),
    ],
)
def test_zones_by_elevation(elevation, zone):
    found = one("aset", by_hand(FLAT, exit_direction=towards(np.sin(np.radians(elevation)))))
    assert {name for name in ("green", "red", "blue", "leak") if found[name] == 100} == {zone}
    assert found[f"weighted_{zone}"] == pytest.approx(100 * 0.96**2)
    assert found["surface"] == pytest.approx(4)


def test_zones_are_the_viewers():
    # A hand tilts the stone under a fixed eye: zeniths are directions to the eye.
    light = by_hand(FLAT, tilt=30.0, exit_direction=[(0.0, np.sin(np.radians(60)), 0.5)])  # 30 deg beyond
    assert one("aset", light)["red"] == 100
    assert one("cos", light)["internal"] == pytest.approx(100 * 0.96**2 * np.cos(np.radians(30)))


def test_light_that_stays_inside_is_trapped_and_the_rest():
    light = by_hand(
        FLAT,
        status=[RayStatus.EXITED, RayStatus.TRAPPED, RayStatus.TRAPPED, RayStatus.LOST, RayStatus.MISSED],
        partial_reflections=[0, 1, 0, 0, 0],
        weight=[1.0, 0.04, 1.0, 1.0, 1.0],
    )
    found = one("aset", light)
    assert found["leak"] == pytest.approx(100 / 3)
    assert found["trapped"] == pytest.approx(200 / 3)  # what is lost is never hidden
    assert found["weighted_leak"] == pytest.approx(100 / 3 * 0.96**2)
    assert found["rest"] == pytest.approx(100 / 3 * 0.96 * (0.04 + 2))
    assert found["surface"] == pytest.approx(4)


def test_window_is_what_leaves_the_pavilion_at_its_first_hit():
    light = by_hand(
        FLAT,
        area=[1.0, 2.0, 4.0, 8.0, 16.0],
        exit_facet=[1, PAVILION, 1, WALL, 1],
        reflections=[0, 0, 1, 0, 0],
        partial_reflections=[0, 0, 0, 0, 1],
    )
    assert one("window", light) == {"value": pytest.approx(300 / 15)}


def test_extinction_is_the_head_and_late_leak():
    d = np.array([1.0, 0.99, 0.98, -0.5, -0.5, 1.0])
    light = by_hand(
        FLAT,
        area=2.0 ** np.arange(6),
        reflections=[3, 3, 3, 0, 1, 3],
        partial_reflections=[0, 0, 0, 0, 0, 1],
        exit_direction=towards(d),
    )
    found = one("extinction", light)
    assert found == {"head": pytest.approx(300 / 31), "late_leak": pytest.approx(1600 / 31), "tied": 0}
    wider = by_hand(FLAT, head=15.0, exit_direction=towards(0.98))
    assert one("extinction", wider)["head"] == 100


def test_wlr_like_of_light_that_comes_and_goes_by_the_crown():
    # Seen from straight above; of what falls on the crown 0.96^2 d^2 comes back through it.
    light = by_hand(
        FLAT,
        area=[1.0, 1.0, 1.0, 1.0, 1.0],
        entry_facet=[0, CROWN, WALL, 0, 0],
        exit_facet=[CROWN, 0, 0, PAVILION, 0],
        exit_direction=np.concatenate([towards(d) for d in (0.8, 0.6, 1.0, 0.5, -0.1)]),
    )
    assert one("wlr-like", light)["value"] == pytest.approx(0.96**2 * (0.64 + 0.36) / 4)


def test_wlr_like_divides_by_the_flux_on_the_crown():
    # Views that stand for equal solid angles make the flux of a hemisphere, pi sum A (1 + n_z)/2.
    stone, n = design("emerald"), 50
    fallen = 0.0
    for k in range(n):
        tilt = np.degrees(np.arccos((k + 0.5) / n))
        view = View.of(stone, 20, tilt_deg=tilt, tilt_azimuth_deg=137.5077 * k)
        found = paths(stone, view, points=spread_points(20, view))
        found.area[:] *= 2 * np.pi / n
        light = Light(paths=found, view=view, model=Model.of(stone))
        fallen += found.area @ contributions(measure_named("wlr-like"), light)[:, 1]
    crown = np.array(stone.facet_sides) == "crown"
    flux = np.pi * (stone.solid.areas * (1 + stone.facet_normals[:, 2]) / 2)[crown].sum()
    assert fallen == pytest.approx(flux, rel=WLR_FLUX)


@pytest.mark.parametrize("slope", [5.0, 20.0])
def test_dispersion_of_a_prism(slope):
    # Straight in, and out where the unfolded stone slopes: sin(out) = n sin(slope) for each colour.
    blue, red = load_material("diamond").index([486.1, 656.3])
    stone = load_stone("inoue-3")
    a = np.radians(slope)
    light = by_hand(
        stone,
        index=2.4173,
        area=[1.0, 3.0, 5.0, 7.0],
        exit_direction=np.concatenate([towards(d) for d in (0.8, 0.7, -0.7, 0.9)]),
        partial_reflections=[0, 0, 0, 1],
        cos_exit=[1.0, np.cos(np.radians(75)), 1.0, 1.0],
        unfolded_exit_normal=[(0, 0, -1), (np.sin(a), 0, -np.cos(a)), (0, 0, -1), (0, 0, -1)],
    )
    fan = np.degrees(np.arcsin(blue * np.sin(a)) - np.arcsin(red * np.sin(a)))
    shares = 1 - reflectance(light.paths.cos_exit[:2], 2.4173)
    found = one("dispersion", light)
    assert found["value"] == pytest.approx(0.75 * fan, rel=1e-9)
    assert found["weighted"] == pytest.approx(3 * shares[1] * fan / (shares[0] + 3 * shares[1]), rel=1e-9)


def test_dispersion_of_light_at_the_critical_angle_ends_at_grazing():
    stone, a = load_stone("inoue-3"), np.arcsin(1 / 2.42)  # blue is totally reflected
    _, red = load_material("diamond").index([486.1, 656.3])
    normal = (np.sin(a), 0.0, -np.cos(a))
    light = by_hand(stone, index=2.4173, exit_direction=towards(0.5), unfolded_exit_normal=[normal])
    fan = 90 - np.degrees(np.arcsin(red * np.sin(a)))
    assert one("dispersion", light)["value"] == pytest.approx(fan, rel=1e-9)


@pytest.mark.parametrize(
    ("stone", "index"), [(FLAT, 1.54), (load_stone("inoue-3"), 1.54)], ids=["index alone", "other index"]
)
def test_dispersion_is_not_known_without_the_materials(stone, index):
    light = by_hand(stone, index=index, exit_direction=towards(0.5))
    assert np.isnan(list(one("dispersion", light).values())).all()


def test_virtual_facets_are_counted_with_their_images():
    light = by_hand(
        FLAT,
        area=[4.0, 2.0, 2.0, 1e-30],
        images=np.array([1, 4, 2, 1]),
        exit_direction=np.concatenate([towards(d) for d in (0.1, 0.8, -0.5, 0.8)]),
    )
    found = measure_named("facets").details(light)
    assert found["number"] == 7
    assert found["largest"] == pytest.approx(50)
    assert found["median"] == pytest.approx(6.25)
    assert found["half"] == 1
    assert (found["green_number"], found["red_number"], found["blue_number"], found["leak_number"]) == (
        1,
        4,
        0,
        2,
    )
    assert (found["red_half"], found["blue_half"], found["leak_half"]) == (2, 0, 1)
    assert found["leak_share"] == pytest.approx(25)
    assert list(found) == list(measure_named("facets").detail_keys)
    assert half_area_number(np.array([1.0, 1.0, 1.0])) == 2


def test_inoue_is_the_score():
    stone = load_stone("inoue-3")
    view, model = View.of(stone, 32, tilt_deg=12.0), Model.of(stone)
    score = score_observation(observe(stone, view, model))
    for follow in ("principal", "all"):
        light = Light(paths=paths(stone, view, model, follow=follow), view=view, model=model)
        found = one("inoue", light)
        bands = [band.share for band in score.bands]
        assert [found["average"], found["rear"]] == pytest.approx(
            [score.average, score.rear], abs=1e-5
        )  # float32
        assert [found[key] for key in measure_named("inoue").keys[4:]] == pytest.approx(bands)


# ---- Ties ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("off", [0.0, 0.5, -0.5])
@pytest.mark.parametrize("limit", [0.0, EDGE])
def test_a_tie_is_outside_the_sky_and_told(limit, off):
    d = limit + off * TIE
    found = values(by_hand(FLAT, exit_direction=towards(d)))
    for name in ("iso", "gemray-iso"):
        assert found[name]["internal"] == 0
        assert found[name]["tied"] == pytest.approx(100 * 0.96**2)
    assert found["extinction"]["head"] == 0
    assert found["extinction"]["tied"] == (100 if limit else 0)  # a leak at the first hit is not asked for
    mirrored = values(by_hand(FLAT, cos_entry=np.sqrt([(1 + d) / 2])))
    assert mirrored["iso"]["surface"] == 0
    assert mirrored["iso"]["tied"] == pytest.approx(mirrored["aset"]["surface"])


@pytest.mark.parametrize(("elevation", "zone"), [(0, "leak"), (45, "green"), (75, "red")])
def test_a_tie_is_in_the_lower_zone_and_told(elevation, zone):
    found = one("aset", by_hand(FLAT, exit_direction=towards(np.sin(np.radians(elevation)))))
    assert (found[zone], found["tied"]) == (100, 100)
    assert found["weighted_tied"] == found[f"weighted_{zone}"] > 0


@pytest.mark.parametrize("off", [2.0, -2.0])
def test_beside_a_limit_nothing_is_tied(off):
    found = values(by_hand(FLAT, exit_direction=towards(EDGE + off * TIE)))
    assert found["iso"]["tied"] == found["extinction"]["tied"] == 0
    assert (found["iso"]["internal"] > 0) == (off < 0) == (found["extinction"]["head"] == 0)


def test_without_a_head_nothing_hides_the_zenith():
    found = values(by_hand(FLAT, head=0.0, exit_direction=towards(1.0)))
    assert found["iso"]["internal"] == pytest.approx(100 * 0.96**2)
    assert found["iso"]["surface"] == pytest.approx(4)
    assert found["iso"]["tied"] == found["extinction"]["head"] == 0


# ---- All measures ----------------------------------------------------------------------------------------


def test_measures_are_listed_in_their_order():
    assert [measure.name for measure in measures()] == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_every_measure_tells_what_it_is(name):
    measure = measure_named(name)
    assert isinstance(measure.version, int)
    assert measure.version >= 1
    assert len(measure.definition.split()) > 5
    assert measure.source
    assert measure.is_axial
    assert measure.follow in ("principal", "all")
    assert len(set(measure.keys)) == len(measure.keys)
    assert measure.keys or measure.detail_keys


@pytest.mark.parametrize("name", ["inoue-3", "round"])
@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_shares_make_a_hundred(name, tilt):
    stone = load_stone(name) if name == "inoue-3" else design(name)
    found = values(light_of(stone, 24, least=1e-3, tilt=tilt))
    aset, inoue = found["aset"], found["inoue"]
    zones = ("green", "red", "blue", "leak")
    assert sum(aset[key] for key in (*zones, "trapped")) == pytest.approx(100, abs=SUM)
    weighted = [aset[f"weighted_{key}"] for key in zones]
    assert sum([*weighted, aset["surface"], aset["rest"]]) == pytest.approx(100, abs=SUM)
    assert sum(list(inoue.values())[1:]) == pytest.approx(100, abs=SUM)
    assert 0 < aset["rest"] < 0.2


@pytest.mark.parametrize("name", ["inoue-3", "pear"])
def test_turning_stone_and_eye_together_changes_nothing(name):
    # The same rays, in the frame of the turned stone.
    stone, turn = load_stone(name) if name == "inoue-3" else design(name), 33.0
    light = light_of(stone, 16, least=1e-3, tilt=20.0, tilt_azimuth=0.0)
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    turning = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    view = View(resolution=16, half_width=light.view.half_width, tilt_deg=20.0, tilt_azimuth_deg=turn)
    points = spread_points(16, view) @ (light.view.basis()[:2] @ turning.T @ view.basis()[:2].T)
    found = paths(stone.rotated(turn), view, light.model, follow="all", points=points, least=1e-3)
    turned = values(Light(paths=found, view=view, model=light.model))
    for measure, expected in values(light).items():
        assert turned[measure] == pytest.approx(expected, abs=TURNED, nan_ok=True), measure


def test_values_of_parts_are_those_of_the_whole():
    light = light_of(load_stone("inoue-3"), 20, least=1e-3)
    rows = np.arange(len(light))
    parts = [
        Light(paths=light.paths.rows(part), view=light.view, model=light.model)
        for part in (rows[:500], rows[500:])
    ]
    summed = evaluate(parts, OF_A_VIEW)
    for name, found in evaluate([light], OF_A_VIEW).items():
        assert summed[name] == pytest.approx(found, nan_ok=True)


def test_a_principal_measure_is_given_the_principal_paths_only():
    class Everything(Measure):
        name, follow, keys = "everything", "principal", ("value", "number")

        def contributions(self, light):
            return np.column_stack([np.ones(len(light)), np.ones(len(light))])

    light = by_hand(FLAT, partial_reflections=[0, 1, 2, 0])
    found = evaluate([light], [Everything()])["everything"]
    assert found == {"value": 100, "number": 100}


def test_a_measure_of_another_shape_is_refused():
    class Wrong(Measure):
        name, keys = "wrong", ("a", "b")

        def contributions(self, light):
            return np.ones(len(light))

    with pytest.raises(ValueError, match=r"contributions of wrong must have shape \(1, 2\), got \(1, 1\)"):
        evaluate([by_hand(FLAT, area=[1.0])], [Wrong()])


# ---- Names -----------------------------------------------------------------------------------------------


def test_measures_are_chosen_by_name():
    assert [m.name for m in chosen_measures("iso, aset,iso")] == ["iso", "aset"]
    assert chosen_measures("all") == chosen_measures(["all"]) == measures()
    assert chosen_measures(["aset", measure_named("iso")]) == (measure_named("aset"), measure_named("iso"))


class Own(Measure):
    name = "iso"


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        ("iso,assetz", "measures = 'assetz': must be one of inoue, iso, .*; did you mean aset?"),
        ("", "measures = '': must be names of measures, with commas between them, or all"),
        (",", "measures = ',': must be names"),
        ([], "measures = \\[\\]: must be names"),
        (["iso", Own()], "measures = 'iso': is the name of two measures"),
        ([Measure()], "measures = 'Measure': must have a name"),
        ([3], "measures = 3: must be names or measures"),
    ],
)
def test_other_names_are_refused(chosen, message):
    with pytest.raises(InputError, match=f"^{message}"):
        chosen_measures(chosen)
    with pytest.raises(InputError, match=r"^measure = 'isso': must be one of .*; did you mean iso\?"):
        measure_named("isso")

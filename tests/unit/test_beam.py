"""The exact engine's parts: closed forms first, then the pieces beside what they stand for."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from beam_help import RIM_SIDES, TOLD_AREA, gem, girdle_heavy_brilliant
from exact_tolerances import TILING
from physics_tolerances import ROUNDED_ANGLE, ROUNDING
from solids import bent_stone

from gemrender.beam import FacetStatus, beam_stone, check_bound, measure, trace_facets
from gemrender.beam.clipping import area, keep_below
from gemrender.beam.compiled import STEP
from gemrender.beam.crossing import into_air, into_stone
from gemrender.beam.measure import BOUND_RANGE, facet_sums
from gemrender.beam.near_girdle import CELLS, RIM, NearGirdle
from gemrender.beam.unfold import in_common
from gemrender.beam.view_area import view_area
from gemrender.cuts import RoundBrilliant, load_stone, stone_from_vertices
from gemrender.cuts.random import random_brilliant
from gemrender.engines import engine_for, observe, require_engine
from gemrender.errors import InputError
from gemrender.measures.inoue import BANDS, INTENSITY, MET, REAR, path_intensity
from gemrender.observation import Model, View
from gemrender.optics.fresnel import transmittance
from gemrender.reference import full_paths
from gemrender.scoring import BAND_EDGES, score

INDEX = 2.4173
LAWS = ("exact", "gubelin")

#: What 64 level girdle facets in place of the cylinder change of this stone's scores [%].
LEVEL_GIRDLE = 0.01
#: What chords are still off by once they are extrapolated [girdle radius^2].
CHORDS = 2e-5


# ---- Optics --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_the_complex_step_differentiates_the_transmittance(law):
    for cos in (0.1, 0.37, 0.8, 0.98):  # of Gübelin's table between two rows
        step = 1e-5
        difference = transmittance(cos + step, INDEX, law) - transmittance(cos - step, INDEX, law)
        stepped = transmittance(np.array([complex(cos, STEP)]), INDEX, law)[0]
        assert stepped.imag / STEP == pytest.approx(difference / 2 / step, rel=1e-6)
        assert stepped.real == pytest.approx(transmittance(cos, INDEX, law), abs=ROUNDED_ANGLE)


def test_refraction_in_and_out_is_the_same_way():
    normal = np.array([0.48, 0.6, 0.64])
    into = np.array([0.1, -0.2, -np.sqrt(0.95)])
    *inside, cos_air, cos_stone = into_stone(*into, *normal, INDEX)
    assert np.linalg.norm(inside) == pytest.approx(1, abs=ROUNDING)
    *out, again_air, again_stone = into_air(*(-np.array(inside)), *normal, INDEX)
    np.testing.assert_allclose(out, -into, atol=ROUNDING)
    assert (again_air, again_stone) == pytest.approx((cos_air, cos_stone), abs=ROUNDING)


@pytest.mark.parametrize("intensity", ["primary", "radiance"])
def test_straight_through_the_cross_section_does_not_change(intensity):
    transmitted = 1 - ((INDEX - 1) / (INDEX + 1)) ** 2
    straight = np.ones(1)
    found = path_intensity(straight, straight, Model(fresnel="exact", intensity=intensity))
    assert found == pytest.approx(transmitted**2, abs=ROUNDING)


def test_the_cross_section_changes_as_the_cosines_do():
    """Light that comes in at 60 degrees in air and goes out straight: the beam grows by cos b / cos a."""
    at_60 = np.array([0.5])
    model = {kind: Model(fresnel="exact", intensity=kind) for kind in ("primary", "radiance")}
    shares = [path_intensity(np.ones(1), at_60, model[kind])[0] for kind in ("primary", "radiance")]
    cos_stone = np.sqrt(1 - 0.75 / INDEX**2)
    assert shares[0] / shares[1] == pytest.approx(0.5 / cos_stone, abs=ROUNDING)


# ---- Polygons ------------------------------------------------------------------------------------------

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def kept(corners, n, a, b, c):
    """Area of the part of a polygon where a + b u + c v <= 0."""
    table = np.zeros((2, n + 1, 3), dtype=corners.dtype)
    table[0, :n, :2] = corners
    part, m = keep_below(table, 0, n, a, b, c)
    return area(table[part], m) if m else 0.0


def test_a_square_has_its_area_and_loses_half_of_it_to_a_diagonal():
    assert area(SQUARE, 4) == 1
    assert kept(SQUARE, 4, 0.0, 1.0, -1.0) == 0.5  # u <= v


def test_both_sides_of_a_cut_make_the_whole(rng):
    for a, b, c in rng.normal(0, 0.5, (100, 3)):
        parts = [kept(SQUARE, 4, s * a, s * b, s * c) for s in (1, -1)]
        assert sum(parts) == pytest.approx(1, abs=ROUNDING)


def test_the_area_of_a_moving_edge_has_its_derivative():
    """A unit square cut at u = t has the area t, and its derivative is the edge's length."""
    cut = kept(SQUARE.astype(complex), 4, -complex(0.3, STEP), 1.0 + 0j, 0.0 + 0j)
    assert cut == pytest.approx(0.3)
    assert cut.imag / STEP == pytest.approx(1)


def test_the_bits_of_all_facets_along_a_path_are_combined():
    parents, facets = [-1, -1, 0, 2, 3, 1], [0, 1, 2, 0, 3, 2]
    nodes = np.column_stack([parents, facets])
    bits = np.array([0b0111, 0b1000, 0b0101, 0b0110])
    np.testing.assert_array_equal(in_common(nodes, bits), [0b0111, 0b1000, 0b0101, 0b0101, 0b0100, 0])


# ---- Stones --------------------------------------------------------------------------------------------


def test_a_perfect_stone_is_57_planes_and_a_bent_one_has_more():
    assert len(beam_stone(load_stone("inoue-3")).solid.planes) == 57
    bent = beam_stone(bent_stone(-0.003))
    assert (bent.facet < 57).sum() == 57 + 8


def test_a_hollow_stone_is_refused_by_name_and_told_what_can_trace_it():
    with pytest.raises(InputError) as caught:
        beam_stone(bent_stone(0.003, name="hollow"))
    words = str(caught.value)
    assert words.startswith("hollow: is not convex")
    assert words.endswith("the engines mitsuba and reference trace this one")


def test_hollows_of_rounded_digits_are_traced():
    vertices = np.round(load_stone("inoue-3").vertices, 6)
    rounded = score(stone_from_vertices(vertices, name="rounded"), engine="exact")
    perfect = score(load_stone("inoue-3"), engine="exact")
    assert rounded.average == pytest.approx(perfect.average, abs=LEVEL_GIRDLE)
    assert rounded.rear == pytest.approx(perfect.rear, abs=LEVEL_GIRDLE)


@pytest.mark.parametrize(("culet", "engine"), [(-0.003, "exact"), (0.003, "mitsuba")])
def test_auto_is_exact_for_convex_stones_and_mitsuba_for_others(culet, engine):
    assert engine_for("auto", bent_stone(culet)) == engine


def test_an_engine_that_is_asked_for_is_taken():
    assert [engine_for(e, bent_stone(0.003)) for e in ("exact", "reference")] == ["exact", "reference"]
    with pytest.raises(InputError, match="hollow"):
        require_engine("exact", stones=[bent_stone(0.003, name="hollow")])


def test_walls_stand_inside_a_round_girdle_and_others_need_none():
    solid = beam_stone(load_stone("inoue-3")).solid
    azimuth = np.linspace(0, 2 * np.pi, 20_001)
    for walls in (solid.walls, solid.rim):
        along = walls[:, :2] @ [np.cos(azimuth), np.sin(azimuth)]
        assert ((walls[:, 2:] / np.maximum(along, 1e-9)).min(axis=0) <= 1 + ROUNDING).all()
    measured = beam_stone(bent_stone(-0.003, stretched=1.03)).solid
    assert (len(measured.walls), len(measured.rim), measured.is_round) == (0, 0, False)


@pytest.mark.parametrize("girdle", [0.0, 0.8, 3.0])
@pytest.mark.parametrize(("tilt", "azimuth"), [(0, 0), (20, 30), (70, -170)])
def test_the_area_of_a_round_stones_view_is_that_of_finer_and_finer_polyhedra(girdle, tilt, azimuth):
    """Thin girdles too, where crown and pavilion meet within the circle."""
    proportions = asdict(load_stone("tolkowsky").proportions)
    stone = gem(RoundBrilliant(**{**proportions, "girdle_thickness": girdle}))
    view = View(resolution=1, tilt_deg=tilt, tilt_azimuth_deg=azimuth)
    eye = view.basis()[2]
    areas = [np.maximum(stone.solid.cut(n).crosses @ eye, 0.0).sum() for n in (256, 512)]
    smooth = areas[1] + (areas[1] - areas[0]) / 3  # what they lack falls as the square of the number
    assert view_area(beam_stone(stone), view) == pytest.approx(smooth, abs=CHORDS)


# ---- Virtual facets ------------------------------------------------------------------------------------


def ways(stone, points):
    """The different sequences of facets that light takes to places of the view, by the reference tracer."""
    return {tuple(path.facet_names) for path in full_paths(stone, points)}


def test_virtual_facets_are_the_ways_that_the_reference_finds(rng):
    """As many as there are: no two have the same way, and no other place of the view has another one."""
    stone = load_stone("inoue-3")
    facets = trace_facets(stone)
    middles = [facets.corners[a:b].mean(axis=0) for a, b in zip(facets.starts, facets.ends, strict=True)]
    known = ways(stone, middles)
    assert len(facets) == len(known) == len(measure(stone).sizes)
    radius, turn = np.sqrt(rng.uniform(0, 1, 2000)), rng.uniform(0, 2 * np.pi, 2000)
    others = ways(stone, np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])) - known
    assert all("girdle" in way for way in others), "what its curved wall mirrors is told by single rays"


@pytest.mark.parametrize("name", ["inoue-1", "inoue-2", "inoue-3", "fish-eye", "nail-head", "tolkowsky"])
def test_a_sixteenth_stands_for_the_whole(name):
    stone = load_stone(name)
    whole, part = trace_facets(stone), trace_facets(stone, whole=False)
    np.testing.assert_allclose(16 * facet_sums(part), facet_sums(whole), rtol=0, atol=TILING)
    assert part.images()[part.is_counted].sum() == whole.is_counted.sum()


def test_the_part_turns_with_the_stone():
    stone = load_stone("inoue-3")
    still, turned = (trace_facets(s, whole=False) for s in (stone, stone.rotated(11.25)))
    assert still.parts == turned.parts == 16
    np.testing.assert_allclose(facet_sums(turned), facet_sums(still), rtol=0, atol=TILING)
    assert turned.images()[turned.is_counted].sum() == still.images()[still.is_counted].sum()


def test_symmetric_stones_tilt_into_whole_views():
    tilted = View(resolution=1, tilt_deg=10)
    assert len(trace_facets(load_stone("inoue-3"), view=tilted, whole=False).wedge) == 0


@pytest.mark.parametrize("heavy", [False, True])
def test_nothing_is_lost(heavy, rng):
    """Emitted, trapped and girdle cells make what the rim's walls hold; 200 stones are a system test."""
    stone = gem(girdle_heavy_brilliant(rng) if heavy else random_brilliant(rng))
    assert len(beam_stone(stone).solid.rim) == RIM_SIDES
    assert trace_facets(stone).area.sum() == pytest.approx(TOLD_AREA, abs=TILING)


def test_too_many_reflections_are_trapped_and_counted():
    model = Model(max_reflections=2)
    facets = trace_facets(load_stone("inoue-2"), model=model)
    trapped = facets.status == FacetStatus.TRAPPED
    assert (facets.reflections[trapped] == 2).all()
    assert facets.area.sum() == pytest.approx(TOLD_AREA, abs=TILING)
    found = measure(load_stone("inoue-2"), model=model, bound=10.0)
    share = 100 * facets.area[trapped].sum() / np.pi
    assert share > 1
    assert found.trapped >= share  # and more near the girdle
    assert found.bound >= found.trapped


def test_a_path_is_told_from_the_eye():
    facets = trace_facets(load_stone("inoue-3"))
    kinds = load_stone("inoue-3").facet_kinds
    for i in range(len(facets)):
        path = facets.path(i)
        assert len(path) == facets.reflections[i] + 2
        assert kinds[path[0]] in ("table", "star", "bezel", "upper_girdle")


# ---- Scores --------------------------------------------------------------------------------------------


def test_shares_make_100():
    found = measure(load_stone("inoue-2"))
    assert found.bands.sum() + found.rear + found.trapped + found.lost == pytest.approx(100, abs=1e-9)
    assert found.sizes.sum() + found.girdle == pytest.approx(100, abs=1e-9)


def test_a_seed_repeats_and_another_agrees_within_the_bounds():
    stone = load_stone("inoue-2")
    first, again, other = (measure(stone, seed=seed) for seed in (1, 1, 2))
    assert (first.average, first.rear, first.bound) == (again.average, again.rear, again.bound)
    assert first.average != other.average
    assert first.average == pytest.approx(other.average, abs=first.bound + other.bound)
    assert first.rear == pytest.approx(other.rear, abs=first.bound + other.bound)


def test_a_smaller_bound_is_reached_by_more_rays():
    wide, narrow = (measure(load_stone("inoue-2"), bound=bound) for bound in (0.5, 0.02))
    assert wide.bound <= 0.5
    assert narrow.bound <= 0.02
    assert narrow.rays > wide.rays
    assert wide.average == pytest.approx(narrow.average, abs=wide.bound + narrow.bound)


def test_threads_change_nothing():
    """More rays than one thread is given; the sets are the same whoever follows them."""
    stone = beam_stone(load_stone("inoue-2"))
    near = [NearGirdle(stone, trace_facets(stone, whole=False), seed=1) for _ in range(2)]
    near[0].go_on((4000, 100))
    for numbers in ((1000, 50), (2500, 75), (4000, 100)):
        near[1].go_on(numbers)
    np.testing.assert_allclose(near[0].found(), near[1].found(), rtol=0, atol=TILING)
    assert near[0].rays == near[1].rays


def test_a_stone_without_girdle_cells_takes_no_rays_for_them():
    """As one that was moved to where its last girdle cell vanished, asked for as many rays as before."""
    stone = beam_stone(load_stone("inoue-3"))
    near = NearGirdle(stone, trace_facets(stone, whole=False), seed=1)
    assert near.areas[CELLS] == 0
    near.go_on((50, 50))
    assert near.found()[:, MET] == pytest.approx(near.areas[RIM])


@pytest.mark.parametrize("bound", [0, -1, 11, float("nan"), True, "small", None])
def test_a_bound_out_of_range_is_refused(bound):
    low, high = BOUND_RANGE
    with pytest.raises(InputError, match=rf"must be from {low:g} to {high:g} \[%\]"):
        check_bound(bound)


def test_a_score_tells_what_made_it():
    stone = load_stone("inoue-3")
    found = score(stone, engine="exact")
    assert (found.engine, found.variant, found.resolution) == ("exact", "", None)
    assert found.bound <= 0.05
    assert found.facets.number == len(trace_facets(stone))
    assert sum(number for _, number, _ in found.facets.classes) == found.facets.number
    assert sum(share for *_, share in found.facets.classes) + found.facets.near_girdle == pytest.approx(100)


def test_the_score_of_maps_is_the_exact_one():
    stone = load_stone("inoue-3")
    maps = observe(stone, engine="exact", resolution=16)
    assert maps.measured.average == score(stone, engine="exact").average


def test_average_is_made_of_intensity_and_area():
    facets = trace_facets(load_stone("inoue-3"))
    sums = facet_sums(facets)
    assert 100 * sums[INTENSITY] == pytest.approx(facets.area @ facets.primary_intensity)
    assert sums[REAR] == pytest.approx(facets.area[facets.rear_mask].sum())
    assert sums[BANDS : BANDS + 6].sum() + sums[REAR] == pytest.approx(sums[MET])


def test_a_stone_of_no_girdle_height_is_scored():
    thin = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=14.5, pavilion_depth=43, girdle_thickness=0
    )
    exact = score(gem(thin), engine="exact")
    seen = score(gem(thin), engine="reference", resolution=256)
    assert exact.average == pytest.approx(seen.average, abs=0.25)


@pytest.mark.parametrize("engine", ["exact", "reference"])
def test_a_misspelt_option_is_refused_not_passed_over(engine):
    with pytest.raises(TypeError, match="resoltion"):
        score(load_stone("inoue-3"), engine=engine, resoltion=5)


def test_single_rays_sort_by_the_bands_of_scores():
    from gemrender.measures.inoue import BAND_EDGES as SHARES

    assert [100 * share for share in SHARES] == list(BAND_EDGES[:-1])

"""Stones with tilted facets: 57 half-spaces and a cylinder."""

from __future__ import annotations

import numpy as np
import pytest
from thorough import chosen

import gemrender
from gemrender.crosscheck import crosscheck
from gemrender.cuts import RoundBrilliant, load_stone, stone_from_vertices
from gemrender.cuts.round_brilliant.topology import GIRDLE
from gemrender.engines import observe, observe_alike
from gemrender.scoring import score_observation
from gemrender.stone import Stone, tessellate
from tests.solids import assert_closed, mesh_volume
from tests.tolerances import PLANE, ROUNDING, SAGITTA

SEEDS = range(6)
#: Volume of a stone whose facets turn by half a degree about their middles: second order in the angle,
#: (0.0087)^2 times lengths and areas of order 1, a few of them.
VOLUME_CHANGE = 5e-3
#: A stone tilted by nothing has the same planes; what differs is the mesh, by the sagitta of its arcs.
SAME_SCORE = 0.02
#: Bound of exact scores of stones that are turned [%].
TURNED_BOUND = 0.02


def tilted(name: str, seed: int, deviation_deg: float = 0.5) -> Stone:
    return load_stone(name).tilted(deviation_deg, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", ["inoue-1", "inoue-2", "inoue-3"])
def test_mesh_is_closed(name, seed):
    assert_closed(tessellate(tilted(name, seed)))


@pytest.mark.parametrize("seed", SEEDS)
def test_no_vertex_lies_outside_a_half_space_or_the_cylinder(seed):
    stone = tilted("inoue-2", seed)
    v = tessellate(stone).vertices
    assert (v @ stone.facet_normals.T - stone.facet_offsets).max() <= PLANE
    assert np.hypot(v[:, 0], v[:, 1]).max() <= 1.0 + ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
def test_faces_lie_in_the_planes_of_their_facets(seed):
    stone = tilted("inoue-3", seed)
    mesh = tessellate(stone)
    flat = mesh.face_facet != GIRDLE
    corners = mesh.vertices[mesh.faces[flat]]
    height = np.einsum("fij,fj->fi", corners, mesh.face_normals[flat]) - mesh.face_offsets[flat, None]
    assert np.abs(height).max() <= PLANE
    rim = mesh.vertices[mesh.faces[~flat]]
    assert np.abs(np.hypot(rim[..., 0], rim[..., 1]) - 1.0).max() <= SAGITTA


def test_every_plane_turns_about_the_middle_of_its_facet():
    stone, turned = load_stone("inoue-1"), tilted("inoue-1", 1)
    middles = stone.solid.polyhedron.middles[: len(stone.facet_normals)]
    on_plane = np.einsum("ij,ij->i", middles, turned.facet_normals) - turned.facet_offsets
    assert np.abs(on_plane).max() <= PLANE


def test_angles_have_the_deviation_asked_for():
    stone, rng = load_stone("inoue-3"), np.random.default_rng(1)
    n = 40
    cos = [np.einsum("ij,ij->i", stone.facet_normals, stone.tilted(0.5, rng).facet_normals) for _ in range(n)]
    angles = np.degrees(np.arccos(np.clip(cos, -1, 1)))
    # Two normal angles: the mean square is twice the variance; its relative error 1 / sqrt(57 n).
    assert np.mean(angles**2) == pytest.approx(2 * 0.5**2, rel=5 / np.sqrt(57 * n))


@pytest.mark.parametrize("seed", SEEDS)
def test_volume_hardly_changes(seed):
    straight = mesh_volume(tessellate(load_stone("inoue-2")))
    assert mesh_volume(tessellate(tilted("inoue-2", seed))) == pytest.approx(straight, abs=VOLUME_CHANGE)


@pytest.mark.parametrize("engine", ["reference", "mitsuba"])
def test_a_tilt_so_small_that_it_does_not_count_leaves_the_score(engine, variant_llvm_ad_mono):
    options = {"engine": engine, "resolution": 128}
    straight = score_observation(observe(load_stone("inoue-3"), **options))
    turned = score_observation(observe(tilted("inoue-3", 1, 1e-7), **options))
    assert turned.average == pytest.approx(straight.average, abs=SAME_SCORE)
    assert turned.rear == pytest.approx(straight.rear, abs=SAME_SCORE)


@pytest.mark.parametrize("tilt_deg", chosen([0.0, 30.0], [30.0]))
@pytest.mark.parametrize("seed", [1, 2])
def test_both_tracers_agree(seed, tilt_deg, variant_llvm_ad_mono):
    truth, by_mitsuba, _ = observe_alike(tilted("inoue-3", seed), resolution=160, tilt=tilt_deg)
    check = crosscheck(by_mitsuba, truth)
    assert check.failures == []


def test_where_a_tilt_makes_crown_and_pavilion_meet_the_girdle_has_a_gap():
    thin = RoundBrilliant(
        table=54,
        star=57,
        lower_girdle_contact=20,
        crown_height=15.7,
        pavilion_depth=43.08,
        girdle_thickness=1,
    )
    stone = Stone.from_proportions(thin).tilted(1.0, np.random.default_rng(1))
    assert_closed(tessellate(stone))
    assert 0 < stone.solid.areas[GIRDLE] < 2 * np.pi * 0.02


def test_level_facets_of_a_measured_outline_stay():
    moved = load_stone("inoue-3").vertices + np.random.default_rng(1).normal(0, 1e-6, (57, 3))
    stone = stone_from_vertices(moved)
    turned = stone.tilted(0.5, np.random.default_rng(1))
    girdle = turned.solid.facet == GIRDLE
    assert np.array_equal(turned.solid.planes[girdle], stone.solid.planes[stone.solid.facet == GIRDLE])
    assert_closed(tessellate(turned))


def test_a_turned_stone_keeps_its_tilt():
    stone = tilted("inoue-3", 1, 1.0)
    still = stone.rotated(0.0)
    assert np.array_equal(still.facet_normals, stone.facet_normals)
    assert np.array_equal(still.facet_offsets, stone.facet_offsets)
    # Turned by any angle it is the same solid, seen from straight above the same score.
    scores = [gemrender.score(s, bound=TURNED_BOUND) for s in (stone, stone.rotated(17.3))]
    for key in ("average", "rear"):
        first, second = (getattr(s, key) for s in scores)
        assert first == pytest.approx(second, abs=sum(s.bound for s in scores))
    assert scores[0].average != pytest.approx(gemrender.score(load_stone("inoue-3")).average, abs=0.1)


def test_differently_tilted_stones_are_not_the_same():
    first, second = (observe(tilted("inoue-3", seed), engine="reference", resolution=8) for seed in (1, 2))
    with pytest.raises(ValueError, match="different stones"):
        crosscheck(first, second)

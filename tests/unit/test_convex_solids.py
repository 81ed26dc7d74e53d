"""Properties of random solids: closed and convex, measured as others measure them, and traced alike."""

from __future__ import annotations

import numpy as np
import pytest
from exact_tolerances import FACET_PERCENT, TILING_ASKED
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from random_solids import (
    about_ellipsoid,
    assert_closed_and_convex,
    doubled,
    mirror,
    solid_of,
    stone_of,
    symmetric,
    turn,
    turned,
    with_culet,
    with_slivers,
)
from scipy.spatial import ConvexHull
from solids import assert_closed, bent_stone, half_space_volume, mesh_volume
from thorough import examples
from tolerances import QUADRATURE_VOLUME

from gemrender.beam import measure, trace_facets
from gemrender.beam.measure import facet_sums
from gemrender.cuts import RoundBrilliant
from gemrender.cuts.round_brilliant.proportions import RANGES, smallest_star
from gemrender.engines import observe
from gemrender.observation import REAR_RULES, Model, Observation, RayStatus, View
from gemrender.stone import Stone, tessellate
from gemrender.stone.polyhedron import intersect
from gemrender.stone.symmetry import find_symmetry

# The same examples in every run; no deadline, since machines differ.
REPEATABLE = {"derandomize": True, "deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
SEEDS = st.integers(0, 2**32 - 1)

#: Corners beside their planes [share of the solid's size]: rounding, where planes meet at small angles.
CORNERS = 1e-10
#: The same of planes that nearly coincide: corners closer than 1e-10 are one.
CORNERS_NEARLY_ONE = 1e-9
#: Volumes and areas beside Qhull's, of the corners' convex hull, and trimesh's [share of them].
MEASURED = 1e-9
#: Azimuths of mirror planes [rad] and places of axes: planes of the size of 1, through a centre of up to 3.
SYMMETRY = 1e-9
#: Pixels of a map in which two float64 tracers part: within rounding of an edge.
PARTED = 2
#: Reflections within which a round girdle does not part two tracers: each multiplies rounding by some
#: five. And how far intensities may be apart then [%].
FEW_REFLECTIONS, ROUND_PERCENT = 8, 1e-5
#: Bound of exact scores that are compared with coarse maps [%].
COARSE = 0.5
#: A map's Average and Rear beside the exact ones: no more than four standard errors of independent samples,
#: whose deviation is 50 at most as all lie between 0 and 100 [%].
SAMPLES_OFF = 4 * 50.0


# ---- Planes, corners, areas, volume --------------------------------------------------------------------


@examples(12, 40, given(seed=SEEDS, number=st.integers(8, 120)), **REPEATABLE)
def test_planes_about_an_ellipsoid_are_a_closed_convex_solid(seed, number):
    planes = about_ellipsoid(np.random.default_rng(seed), number)
    body = intersect(planes)
    assert_closed_and_convex(body, CORNERS)
    assert body.bounds.sum() > 3

    stone = stone_of(planes)
    assert_closed_and_convex(stone.solid.polyhedron, CORNERS)
    low, high = stone.vertices.min(axis=0), stone.vertices.max(axis=0)
    assert (high - low)[:2].max() == pytest.approx(2, abs=CORNERS)
    assert (low + high)[:2] == pytest.approx(0, abs=CORNERS)


@examples(12, 40, given(seed=SEEDS, number=st.integers(8, 120)), **REPEATABLE)
def test_volume_areas_and_middle_are_those_of_the_corners_hull(seed, number):
    solid = stone_of(about_ellipsoid(np.random.default_rng(seed), number)).solid
    hull = ConvexHull(solid.vertices)
    assert solid.volume == pytest.approx(hull.volume, rel=MEASURED)
    areas = np.zeros(len(solid.planes))
    corners = solid.vertices[hull.simplices]
    sizes = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    owner = (hull.equations[:, :3] @ solid.planes[:, :3].T).argmax(axis=1)
    np.add.at(areas, owner, sizes)
    np.testing.assert_allclose(solid.areas, areas, rtol=0, atol=MEASURED * areas.sum())
    # Of tetrahedra from an inner point.
    inside = solid.vertices.mean(axis=0)
    volumes = np.abs(np.linalg.det(corners - inside)) / 6
    middle = (volumes[:, None] * (corners.sum(axis=1) + inside) / 4).sum(axis=0) / volumes.sum()
    np.testing.assert_allclose(solid.polyhedron.centroid, middle, rtol=0, atol=MEASURED)


@settings(max_examples=5, **REPEATABLE)
@given(seed=SEEDS, number=st.integers(8, 120))
def test_the_mesh_is_what_trimesh_takes_for_a_closed_convex_body(seed, number):
    trimesh = pytest.importorskip("trimesh")
    stone = stone_of(about_ellipsoid(np.random.default_rng(seed), number))
    mesh = tessellate(stone)
    assert_closed(mesh)
    body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.is_convex
    assert body.volume == pytest.approx(stone.solid.volume, rel=MEASURED)
    assert body.area == pytest.approx(stone.solid.areas.sum(), rel=MEASURED)


@examples(12, 30, given(seed=SEEDS, number=st.integers(8, 80), exponent=st.floats(-13, -6)), **REPEATABLE)
def test_planes_that_nearly_coincide_close(seed, number, exponent):
    rng = np.random.default_rng(seed)
    planes = doubled(rng, about_ellipsoid(rng, number), 10**exponent)
    assert_closed_and_convex(intersect(planes), CORNERS_NEARLY_ONE)
    stone = stone_of(planes)
    assert_closed_and_convex(stone.solid.polyhedron, CORNERS_NEARLY_ONE)
    assert_closed(tessellate(stone))


@examples(
    12,
    30,
    given(seed=SEEDS, number=st.integers(8, 24), exponent=st.one_of(st.just(-np.inf), st.floats(-15, -6))),
    **REPEATABLE,
)
def test_planes_through_one_corner_close(seed, number, exponent):
    rng = np.random.default_rng(seed)
    culet = np.array([*rng.uniform(-0.1, 0.1, 2), -1.0])
    planes = with_culet(rng, number, culet, 10**exponent)
    body = intersect(planes)
    assert_closed_and_convex(body, CORNERS_NEARLY_ONE)
    if exponent < -13:
        assert (np.linalg.norm(body.vertices - culet, axis=1) < CORNERS_NEARLY_ONE).sum() == 1
    assert_closed(tessellate(stone_of(planes)))


@examples(12, 30, given(seed=SEEDS, number=st.integers(8, 60), exponent=st.floats(-13, -3)), **REPEATABLE)
def test_slivers_close(seed, number, exponent):
    rng = np.random.default_rng(seed)
    planes = with_slivers(rng, about_ellipsoid(rng, number), 10**exponent)
    assert_closed_and_convex(intersect(planes), CORNERS_NEARLY_ONE)
    assert_closed(tessellate(stone_of(planes)))


@settings(max_examples=15, **REPEATABLE)
@given(seed=SEEDS, number=st.integers(8, 80), deviation=st.floats(0.1, 3.0))
def test_tilted_facets_close_even_where_others_cut_them_away(seed, number, deviation):
    rng = np.random.default_rng(seed)
    stone = stone_of(about_ellipsoid(rng, number))
    for _ in range(2):
        stone = stone.tilted(deviation, rng)
        assert_closed_and_convex(stone.solid.polyhedron, CORNERS)
    assert_closed(tessellate(stone))


def test_measured_facets_that_are_cut_away_have_planes_still():
    rng = np.random.default_rng(1)
    stone = bent_stone(-0.003)
    hidden = 0
    for _ in range(6):
        stone = stone.tilted(2.0, rng)
        hidden += int((stone.solid.areas == 0).sum())
        assert np.isfinite(stone.solid.planes).all()
        assert np.linalg.norm(stone.facet_normals, axis=1) == pytest.approx(1, abs=CORNERS)
    assert hidden, "a facet is cut away"


# ---- Symmetry ------------------------------------------------------------------------------------------


def apart(one: float, other: float, period: float) -> float:
    """How far two angles are apart, but for a period."""
    gap = (one - other) % period
    return min(gap, period - gap)


@examples(
    12,
    40,
    given(
        seed=SEEDS,
        fold=st.integers(2, 24),
        azimuth=st.one_of(st.none(), st.sampled_from([0.0, np.pi / 2]), st.floats(0, np.pi)),
        rings=st.integers(3, 5),
    ),
    **REPEATABLE,
)
def test_symmetry_is_found_where_it_was_made(seed, fold, azimuth, rings):
    rng = np.random.default_rng(seed)
    centre = rng.uniform(-3.0, 3.0, 2)
    planes = symmetric(rng, fold, azimuth, rings, centre)
    solid = solid_of(planes)
    assume(solid.n_facets == len(planes))  # a ring that is cut away makes no symmetry
    found = find_symmetry(solid)
    assert found.fold == fold
    assert len(found.mirrors) == (0 if azimuth is None else fold)
    assert found.centre == pytest.approx(centre, abs=SYMMETRY)
    if azimuth is None:
        return
    assert apart(found.mirrors[0], azimuth, np.pi / fold) < SYMMETRY
    moved = solid.planes - np.column_stack([np.zeros((len(solid.planes), 3)), solid.planes[:, :2] @ centre])
    for at, images in zip(found.mirrors, found.images, strict=True):
        np.testing.assert_allclose(turned(moved, mirror(at)), moved[images], rtol=0, atol=10 * SYMMETRY)


@settings(max_examples=15, **REPEATABLE)
@given(seed=SEEDS, azimuth=st.floats(0, np.pi), rings=st.integers(4, 10))
def test_a_single_mirror_plane_is_found(seed, azimuth, rings):
    rng = np.random.default_rng(seed)
    planes = symmetric(rng, 2, None, rings, np.zeros(2))
    planes = np.concatenate([planes[:rings], turned(planes[:rings], mirror(azimuth)), planes[-2:]])
    walls = turned(np.array([[1.0, 0.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 1.2]]), turn(azimuth))
    planes = np.concatenate(
        [planes, walls, turned(np.array([[0.0, s, 0.0, 1.1] for s in (1.0, -1.0)]), turn(azimuth))]
    )
    found = find_symmetry(solid_of(planes))
    assert found.fold == 1
    assert len(found.mirrors) == 1
    assert apart(found.mirrors[0], azimuth, np.pi) < SYMMETRY


@settings(max_examples=20, **REPEATABLE)
@given(seed=SEEDS, number=st.integers(8, 120))
def test_no_symmetry_is_found_where_there_is_none(seed, number):
    found = find_symmetry(solid_of(about_ellipsoid(np.random.default_rng(seed), number)))
    assert (found.fold, len(found.mirrors)) == (1, 0)


@examples(
    12,
    40,
    given(seed=SEEDS, fold=st.integers(2, 12), azimuth=st.floats(0, np.pi), digits=st.floats(2e-8, 8e-8)),
    **REPEATABLE,
)
def test_symmetry_survives_rounding_in_files(seed, fold, azimuth, digits):
    rng = np.random.default_rng(seed)
    planes = symmetric(rng, fold, azimuth, 3, np.zeros(2))
    planes[:, 3] += digits * rng.uniform(-1.0, 1.0, len(planes))
    found = find_symmetry(solid_of(planes))
    assert (found.fold, len(found.mirrors)) == (fold, fold)


@examples(
    12,
    40,
    given(seed=SEEDS, fold=st.integers(2, 12), azimuth=st.floats(0, np.pi), digits=st.floats(8e-8, 4e-7)),
    **REPEATABLE,
)
def test_mirror_planes_are_found_all_or_none(seed, fold, azimuth, digits):
    """Where rounding is as large as what counts as the same, some images fall on planes and some do not."""
    rng = np.random.default_rng(seed)
    planes = symmetric(rng, fold, azimuth, 3, np.zeros(2))
    planes[:, 3] += digits * rng.uniform(-1.0, 1.0, len(planes))
    found = find_symmetry(solid_of(planes))
    assert len(found.mirrors) in (0, found.fold)
    assert len(found.images) == len(found.mirrors)


# ---- Round brilliants over their whole range -----------------------------------------------------------

PROPORTIONS = st.fixed_dictionaries(
    {key: st.one_of(st.floats(*span), st.sampled_from(span)) for key, span in RANGES.items()}
)


def brilliant(values: dict[str, float]) -> RoundBrilliant:
    """Proportions with a star that is long enough for the table."""
    values["star"] = max(values["star"], smallest_star(values["table"]) + 0.01)
    assume(values["star"] <= RANGES["star"][1])
    return RoundBrilliant(**values)


@examples(15, 60, given(values=PROPORTIONS), **REPEATABLE)
def test_any_round_brilliant_is_a_closed_convex_solid(values):
    proportions = brilliant(values)
    stone = Stone.from_proportions(proportions)
    pieces = 128
    body = stone.solid.cut(pieces)
    assert_closed_and_convex(body, CORNERS)
    mesh = tessellate(stone, pieces)
    assert_closed(mesh)
    assert mesh_volume(mesh) == pytest.approx(body.volume, rel=MEASURED)
    assert ConvexHull(body.vertices).volume == pytest.approx(body.volume, rel=MEASURED)


@settings(max_examples=8, **REPEATABLE)
@given(values=PROPORTIONS)
def test_volume_of_any_round_brilliant_is_that_of_half_spaces_and_cylinder(values):
    proportions = brilliant(values)
    stone = Stone.from_proportions(proportions)
    steepest = 1 / np.abs(stone.facet_normals[:, 2]).min()  # the quadrature's error grows with slopes
    assert stone.solid.volume == pytest.approx(
        half_space_volume(proportions), abs=steepest * QUADRATURE_VOLUME
    )


# ---- Exact scores --------------------------------------------------------------------------------------


def random_stone(seed: int) -> Stone:
    """A random solid: of no symmetry, or a few rings of planes, mirrored or not."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        return stone_of(about_ellipsoid(rng, int(rng.integers(12, 60))))
    fold, centre = int(rng.integers(2, 9)), rng.uniform(-1.0, 1.0, 2)
    azimuth = float(rng.uniform(0.0, np.pi)) if seed % 4 else None
    return stone_of(symmetric(rng, fold, azimuth, 3, centre))


def assert_scores(exact: Observation, by_rays: Observation) -> None:
    """The exact scores are those of the map that the reference has made, within what pixels tell."""
    seen = by_rays.status != RayStatus.MISSED
    tolerance = SAMPLES_OFF / np.sqrt(seen.sum()) + exact.measured.bound
    assert exact.measured.average == pytest.approx(by_rays.primary_intensity[seen].mean(), abs=tolerance)
    assert exact.measured.rear == pytest.approx(100 * by_rays.rear_mask[seen].mean(), abs=tolerance)


@pytest.mark.parametrize("rear", REAR_RULES)
@pytest.mark.parametrize("tilt_deg", [0.0, 27.0])
@settings(max_examples=4, **REPEATABLE)
@given(seed=SEEDS, index=st.floats(1.4, 2.6))
def test_exact_maps_and_scores_of_any_solid_are_the_references(rear, tilt_deg, seed, index):
    stone = random_stone(seed)
    view = View.of(stone, 32, tilt_deg=tilt_deg, tilt_azimuth_deg=40.0)
    model = Model.of(stone, index=index, fresnel="exact", rear=rear)
    exact = observe(stone, view=view, model=model, engine="exact")
    by_rays = observe(stone, view=view, model=model, engine="reference")
    assert not (by_rays.status == RayStatus.LOST).any()
    same = (exact.path_code == by_rays.path_code) & (exact.status == by_rays.status)
    assert (~same).sum() <= PARTED
    off = np.abs(exact.primary_intensity - by_rays.primary_intensity)[same]
    assert off.max() <= FACET_PERCENT
    assert (exact.rear_mask == by_rays.rear_mask)[same].all()

    assert_scores(exact, by_rays)
    assert exact.measured.rays == 0, "plane facets need no random ray"


@settings(max_examples=10, **REPEATABLE)
@given(
    values=PROPORTIONS,
    index=st.floats(1.4, 2.6),
    tilt=st.sampled_from([0.0, 35.0]),
    rear=st.sampled_from(REAR_RULES),
)
def test_exact_maps_and_scores_of_any_round_brilliant_are_the_references(values, index, tilt, rear):
    stone = Stone.from_proportions(brilliant(values))
    view = View.of(stone, 32, tilt_deg=tilt, tilt_azimuth_deg=20.0)
    model = Model.of(stone, index=index, fresnel="exact", rear=rear)
    exact = observe(stone, view=view, model=model, engine="exact", bound=COARSE)
    by_rays = observe(stone, view=view, model=model, engine="reference")
    assert not (by_rays.status == RayStatus.LOST).any()
    few = (by_rays.status == RayStatus.EXITED) & (by_rays.reflections <= FEW_REFLECTIONS)
    same = few & (exact.path_code == by_rays.path_code)
    assert (few & ~same).sum() <= PARTED
    assert np.abs(exact.primary_intensity - by_rays.primary_intensity)[same].max(initial=0) <= ROUND_PERCENT
    assert_scores(exact, by_rays)


@settings(max_examples=8, **REPEATABLE)
@given(seed=SEEDS, fold=st.integers(1, 12), index=st.floats(1.4, 2.6))
def test_a_wedge_tells_what_the_whole_view_does(seed, fold, index):
    rng = np.random.default_rng(seed)
    azimuth = float(rng.uniform(0.0, np.pi))
    stone = stone_of(symmetric(rng, max(fold, 2), azimuth, 3, rng.uniform(-1.0, 1.0, 2)))
    model = Model.of(stone, index=index, fresnel="exact")
    part, whole = (trace_facets(stone, model=model, whole=whole) for whole in (False, True))
    assert (part.parts, whole.parts) == (2 * stone.symmetry.fold, 1)
    np.testing.assert_allclose(part.parts * facet_sums(part), facet_sums(whole), rtol=0, atol=TILING_ASKED)


@settings(max_examples=8, **REPEATABLE)
@given(seed=SEEDS, angle=st.floats(0, 360))
def test_turned_stones_have_the_same_volume_and_score(seed, angle):
    stone = random_stone(seed)
    other = stone.rotated(angle)
    assert other.solid.volume == pytest.approx(stone.solid.volume, rel=MEASURED)
    one, turned_one = measure(stone), measure(other)
    bound = one.bound + turned_one.bound + FACET_PERCENT
    assert turned_one.average == pytest.approx(one.average, abs=bound)
    assert turned_one.rear == pytest.approx(one.rear, abs=bound)

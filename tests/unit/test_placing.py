"""Stones in their places: what rests on what, who stands beside whom, and what the camera sees of it."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from solids import BRILLIANTS, half_space_volume
from thorough import chosen
from tolerances import MESH_VOLUME, QUADRATURE_VOLUME, ROUNDING

from gemrender.cuts import load_stone
from gemrender.cuts.round_brilliant.topology import CULET, FACET_POLYGONS
from gemrender.errors import InputError
from gemrender.optics import load_material
from gemrender.render.photoreal import make_gems
from gemrender.scene.moves import Move
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import frame, place, towards
from gemrender.scene.setup import CAMERAS, POSES, Camera, Setup, Sky, load_setup
from gemrender.stone import tessellate

STONES = [load_stone(name) for name in BRILLIANTS]
ROW = [load_stone(name) for name in ("inoue-1", "inoue-3", "tolkowsky")]
AZIMUTHS = [-90.0, 0.0, 37.0, 180.0, 250.0]

#: Lying stones are turned twice, from coordinates of order 1.
TURNED = 10 * ROUNDING
#: Mitsuba's sensors compute in single precision, at distances of some tens.
SENSOR = 2e-5


def laid(stones, pose="lying", *, facing=0.0, gap=0.4, azimuth=-90.0, sizes=None):
    return place(
        list(stones),
        pose=pose,
        facing_deg=facing,
        gap=gap,
        azimuth_deg=azimuth,
        sizes=sizes or [1.0] * len(stones),
    )


def brought(placed, stone):
    """The stone's 57 vertices in its place."""
    return placed.scale * stone.vertices @ placed.rotation.T + placed.shift


def to_the_right(azimuth):
    """What is to the right for a camera at an azimuth: it looks along minus its direction."""
    ahead = -towards(0.0, azimuth)
    return np.cross(ahead, [0.0, 0.0, 1.0])


# ---- One stone -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("stone", STONES, ids=lambda stone: stone.name)
def test_a_lying_stone_rests_on_a_whole_pavilion_main(stone):
    (placed,) = laid([stone], facing=11.0)
    assert placed.points()[:, 2].min() == pytest.approx(0, abs=1e-9)
    points = brought(placed, stone)
    mains = [k for k, kind in enumerate(stone.facet_kinds) if kind == "pavilion_main"]
    (touching,) = (k for k in mains if abs(points[list(FACET_POLYGONS[k]), 2]).max() < 1e-9)
    # Nothing else touches: all other vertices of the stone are above
    others = np.setdiff1d(np.arange(57), FACET_POLYGONS[touching])
    assert points[others, 2].min() > 1e-3
    assert CULET in FACET_POLYGONS[touching]


@pytest.mark.parametrize("stone", STONES, ids=lambda stone: stone.name)
@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_its_table_leans_to_the_wanted_azimuth(stone, azimuth):
    for facing in (0.0, 20.0, -130.0):
        (placed,) = laid([stone], facing=facing, azimuth=azimuth)
        table = placed.rotation @ [0.0, 0.0, 1.0]
        # By as much as the main facets are inclined
        main = stone.facet_normals[stone.facet_kinds.index("pavilion_main")]
        assert table[2] == pytest.approx(-main[2], abs=TURNED)
        lean = math.radians(azimuth + facing)
        wanted = math.hypot(*main[:2]) * np.array([math.cos(lean), math.sin(lean)])
        np.testing.assert_allclose(table[:2], wanted, rtol=0, atol=TURNED)


@pytest.mark.parametrize("pose", POSES)
def test_a_stone_keeps_its_shape(pose):
    stone = ROW[0]
    (placed,) = laid([stone], pose, facing=33.0, azimuth=70.0, sizes=[2.5])
    np.testing.assert_allclose(placed.rotation @ placed.rotation.T, np.eye(3), rtol=0, atol=TURNED)
    assert np.linalg.det(placed.rotation) == pytest.approx(1, abs=TURNED)
    points = brought(placed, stone)
    lengths = np.linalg.norm(points[:, None] - points, axis=2)
    expected = 2.5 * np.linalg.norm(stone.vertices[:, None] - stone.vertices, axis=2)
    np.testing.assert_allclose(lengths, expected, rtol=0, atol=TURNED)


@pytest.mark.parametrize("stone", STONES, ids=lambda stone: stone.name)
def test_upright_poses_rest_on_culet_and_table(stone):
    (up,), (down,) = laid([stone], "table-up"), laid([stone], "table-down")
    heights = stone.vertices[:, 2]
    np.testing.assert_allclose(brought(up, stone)[:, 2], heights - heights.min(), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(brought(down, stone)[:, 2], heights.max() - heights, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("pose", POSES)
def test_a_stone_stands_in_the_middle(pose):
    (placed,) = laid([ROW[0]], pose, facing=20.0)
    points = placed.points()
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    np.testing.assert_allclose(middle[:2], 0, rtol=0, atol=TURNED)


def test_a_turn_is_anticlockwise_from_above():
    (placed,) = laid([ROW[0]], "table-up")
    x, y, z = placed.points().T
    np.testing.assert_allclose(placed.turned(90).points(), np.column_stack([-y, x, z]), atol=TURNED)
    np.testing.assert_allclose(placed.turned(360).points(), placed.points(), atol=TURNED)


def test_directions():
    np.testing.assert_allclose(towards(0, 0), [1, 0, 0], atol=ROUNDING)
    np.testing.assert_allclose(towards(0, 90), [0, 1, 0], atol=ROUNDING)
    np.testing.assert_allclose(towards(90, 12), [0, 0, 1], atol=ROUNDING)
    np.testing.assert_allclose(towards(-30, 0), [math.sqrt(0.75), 0, -0.5], atol=ROUNDING)


# ---- Stones in a row -----------------------------------------------------------------------------------


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("gap", chosen([0.01, 0.4, 3.0], [0.4]))
def test_a_row_goes_from_left_to_right_with_its_gaps(pose, azimuth, gap):
    row = laid(ROW, pose, azimuth=azimuth, gap=gap, facing=20.0, sizes=[1.0, 0.6, 1.7])
    assert [placed.name for placed in row] == [stone.name for stone in ROW]
    along = [placed.points() @ to_the_right(azimuth) for placed in row]
    for left, right in itertools.pairwise(along):
        assert right.min() - left.max() == pytest.approx(gap, abs=TURNED)
    # The row stands in the middle, and on the ground
    assert along[0].min() == pytest.approx(-along[-1].max(), abs=TURNED)
    for placed in row:
        assert placed.points()[:, 2].min() == pytest.approx(0, abs=1e-9)


def test_a_row_turns_as_a_whole():
    row = laid(ROW)
    turned = [placed.turned(77.0) for placed in row]
    for before, after in zip(itertools.pairwise(row), itertools.pairwise(turned), strict=True):
        gaps = [np.linalg.norm(a.points()[::40, None] - b.points()[::40], axis=2) for a, b in (before, after)]
        np.testing.assert_allclose(*gaps, rtol=0, atol=TURNED)


# ---- Sizes ---------------------------------------------------------------------------------------------


def test_a_weight_is_volume_times_density():
    for name, density in (("diamond", 3.52), ("cubic zirconia", 5.9), ("moissanite", 3.22)):
        for stone, gem in zip(ROW, make_gems(ROW, material=name, carat=1.5), strict=True):
            # A carat is 200 mg, and a g/cm^3 is a mg/mm^3
            volume = half_space_volume(stone.proportions)
            carat = volume * (gem.diameter_mm / 2) ** 3 * density / 200
            assert carat == pytest.approx(1.5, rel=(MESH_VOLUME + QUADRATURE_VOLUME) / volume)
            assert load_material(name).density == density


def test_of_one_weight_the_denser_stone_is_smaller():
    (diamond,) = make_gems(ROW[:1], carat=1)
    (zirconia,) = make_gems(ROW[:1], carat=1, material="cubic zirconia")
    assert zirconia.diameter_mm / diamond.diameter_mm == pytest.approx((3.52 / 5.9) ** (1 / 3), rel=1e-12)


def test_of_one_weight_the_deeper_stone_is_smaller():
    shallow, deep = make_gems([load_stone("fish-eye"), load_stone("nail-head")], carat=1)
    assert deep.diameter_mm < shallow.diameter_mm


def test_a_carat_of_well_cut_diamond_is_six_and_a_half_millimetres_wide():
    (gem,) = make_gems([load_stone("gia-excellent")], carat=1)
    assert gem.diameter_mm == pytest.approx(6.45, abs=0.1)  # any jeweller's table


def test_sizes_go_into_the_scene(variant_llvm_ad_spectral):
    gems = make_gems([load_stone("fish-eye"), load_stone("nail-head")], carat=1)
    first, second = photoreal_scene(gems, load_setup("white"), width=8, height=8).stones
    assert first.scale == 1  # a scene unit is the girdle radius of the first
    assert second.scale == pytest.approx(gems[1].diameter_mm / gems[0].diameter_mm, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"carat": 1.0, "diameter_mm": 6.0}, "carat = 1.0: give a weight or a diameter, not both"),
        ({"diameter_mm": 0.0}, "diameter = 0.0: must be from 0.1 to 1000 [mm]"),
        ({"diameter_mm": math.nan}, "diameter = nan: must be from 0.1 to 1000 [mm]"),
        ({"carat": -1.0}, "carat = -1.0: must be a finite number above 0"),
        ({"carat": 0.0}, "carat = 0.0: must be a finite number above 0"),
        ({"carat": 1e9}, "carat = 1000000000.0: must be from 1e-05 to 1e+06 [carat]"),
        ({"diameter_mm": 1e4}, "diameter = 10000.0: must be from 0.1 to 1000 [mm]"),
    ],
)
def test_sizes_that_no_stone_has_are_refused(options, line):
    with pytest.raises(InputError) as caught:
        make_gems(ROW, **options)
    assert str(caught.value) == line


def test_a_weight_that_makes_too_wide_a_stone_is_refused(monkeypatch):
    monkeypatch.setattr("gemrender.optics.material.DIAMETER_RANGE_MM", (0.1, 500.0))
    line = r"^carat = 900000: must make a girdle of 0.1 to 500 mm; this makes \d+ mm$"
    with pytest.raises(InputError, match=line):
        make_gems(ROW[:1], carat=900_000)


def test_a_weight_needs_a_density():
    stone = dataclasses.replace(ROW[0], material=1.76)
    assert make_gems([stone])[0].material_name == 1.76
    with pytest.raises(InputError, match=r"carat = 1: needs the material's density"):
        make_gems([stone], carat=1)


def test_an_unknown_material_is_told_where_it_was_named(tmp_path):
    with pytest.raises(InputError, match=r"^material = 'daimond': must be .*; did you mean diamond\?$"):
        make_gems(ROW, material="daimond")
    stone = dataclasses.replace(ROW[0], material="daimond", source="x.toml")
    with pytest.raises(InputError, match=r"^x\.toml: material\.name = 'daimond': must be one of "):
        make_gems([stone])


# ---- The camera ----------------------------------------------------------------------------------------


def setup_of(camera, pose="lying"):
    return Setup(name="test", pose=pose, sky=Sky(radiance=1), camera=camera)


def seen(scene):
    """Where the stones' vertices lie in a scene's picture: (v, 2) each, -1 and 1 being its borders.

    By the rays of Mitsuba's sensor through the corners of the picture, not by the formulae of `frame`.
    """
    import mitsuba as mi

    plain = scene.plain["sensor"]
    sensor = mi.load_dict(plain)

    def ray(u, v):
        made, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(u, v), mi.Point2f(0.5, 0.5))
        return np.array(made.o, dtype=np.float64).ravel(), np.array(made.d, dtype=np.float64).ravel()

    (_, ahead), corners = ray(0.5, 0.5), [ray(0.0, 0.0), ray(1.0, 0.0), ray(0.0, 1.0), ray(1.0, 1.0)]
    eye = np.array(plain["to_world"].matrix, dtype=np.float64)[:3, 3]
    # The picture, stretched over a plane before the camera
    near = 10.0
    p00, p10, p01, p11 = (o + d * (near - (o - eye) @ ahead) / (d @ ahead) for o, d in corners)
    middle, half_x, half_y = 0.5 * (p00 + p11), 0.5 * (p10 - p00), 0.5 * (p01 - p00)
    width, height = plain["film"]["width"], plain["film"]["height"]
    assert np.linalg.norm(half_x) / np.linalg.norm(half_y) == pytest.approx(width / height, rel=SENSOR)
    out = []
    for placed in scene.stones:
        to = placed.points() - eye
        depth = to @ ahead
        assert depth.min() > 0
        if plain["type"] == "orthographic":
            to = to + (near - depth)[:, None] * ahead
        else:
            to = to * (near / depth)[:, None]
        to = to + eye - middle
        out.append(np.column_stack([to @ half_x / (half_x @ half_x), -(to @ half_y) / (half_y @ half_y)]))
    return out


def camera_of(kind, **options):
    return Camera(type=kind, **({"aperture": 0.1} if kind == "thin-lens" else {}), **options)


@pytest.mark.parametrize("kind", CAMERAS)
@pytest.mark.parametrize(("width", "height"), [(64, 64), (90, 30), (30, 90)])
@pytest.mark.parametrize(
    ("stones", "elevation", "azimuth"),
    chosen(
        [(3, 90, -90), (1, 32, -90), (3, 0, 20), (1, -90, 0), (2, 89.999, 200)], [(1, 32, -90), (3, 0, 20)]
    ),
)
def test_all_vertices_are_in_the_picture_with_the_margin(
    kind, width, height, stones, elevation, azimuth, variant_llvm_ad_spectral
):
    margin = 1.3
    camera = camera_of(kind, elevation=elevation, azimuth=azimuth, distance=12.0, margin=margin)
    scene = photoreal_scene(make_gems(ROW[:stones]), setup_of(camera), width=width, height=height)
    # The margin is kept at one border at least, and no vertex is nearer to any
    assert np.abs(np.concatenate(seen(scene))).max() == pytest.approx(1 / margin, abs=SENSOR)


@pytest.mark.parametrize("kind", CAMERAS)
@pytest.mark.parametrize("azimuth", AZIMUTHS[:3])
@pytest.mark.parametrize("elevation", [90, 20])
def test_the_picture_shows_the_row_from_left_to_right_and_up_is_up(
    kind, azimuth, elevation, variant_llvm_ad_spectral
):
    camera = camera_of(kind, elevation=elevation, azimuth=azimuth)
    parts = seen(photoreal_scene(make_gems(ROW), setup_of(camera, "table-up"), width=64, height=64))
    for left, right in itertools.pairwise(parts):
        assert left[:, 0].max() < right[:, 0].min()
    if elevation < 90:
        for part, stone in zip(parts, ROW, strict=True):
            heights = tessellate(stone).vertices[:, 2]
            table, culet = part[heights.argmax()], part[heights.argmin()]
            assert table[1] > culet[1], stone.name


@pytest.mark.parametrize("kind", CAMERAS)
@pytest.mark.parametrize(("stones", "elevation"), chosen([(1, 5), (1, 90), (3, 5), (3, 40)], [(3, 5)]))
def test_a_turntable_leaves_room_for_all_turns(kind, stones, elevation, variant_llvm_ad_spectral):
    camera = camera_of(kind, elevation=elevation, distance=20.0, margin=1.1)
    gems, setup = make_gems(ROW[:stones]), setup_of(camera)
    sensors, most = set(), 0.0
    for turn in (0.0, 24.7, 91.2, 180.0, 265.0):
        scene = photoreal_scene(gems, setup, width=64, height=48, move=Move(), share=turn / 360)
        sensors.add(repr(scene.plain["sensor"]))
        most = max(most, float(np.abs(np.concatenate(seen(scene))).max()))
    assert len(sensors) == 1  # the camera stands still
    assert 0.97 / 1.1 < most < 1  # in the picture, with no more room than is needed


@pytest.mark.parametrize("kind", CAMERAS)
@pytest.mark.parametrize("distance", chosen([0.1, 0.3], [0.3]))
@pytest.mark.parametrize("pose", POSES)
def test_a_camera_inside_a_stone_is_refused(kind, distance, pose, variant_llvm_ad_spectral):
    gems = make_gems(ROW[:1])
    for elevation in (90, 0, -20):
        setup = setup_of(camera_of(kind, elevation=elevation, distance=distance), pose)
        with pytest.raises(InputError) as caught:
            photoreal_scene(gems, setup, width=8, height=8)
        line = str(caught.value)
        told = (
            f"test: camera.distance = {distance}: is too near to see Inoue sample 1 from outside; its front"
        )
        assert line.startswith(told)
        assert "\n" not in line


def test_a_camera_above_the_table_by_little_is_allowed_and_below_it_is_not():
    """The front of an upright stone is its table: half its height above the middle."""
    stone = ROW[0]
    (placed,) = laid([stone], "table-up")
    half = 0.5 * float(np.ptp(placed.points()[:, 2]))
    target = np.array([0.0, 0.0, half])
    camera = Camera(elevation=90, distance=1.05 * half)
    frame(camera, [placed], target, 1.0)
    with pytest.raises(InputError, match=f"its front is {half:.3g} girdle radii from the middle"):
        frame(dataclasses.replace(camera, distance=0.95 * half), [placed], target, 1.0)


def test_a_row_may_not_come_too_near_while_it_turns(variant_llvm_ad_spectral):
    """From ahead there is room before a row; turned, its end comes to the camera."""
    setup = setup_of(Camera(elevation=0, distance=3.0))
    gems = make_gems(ROW)
    photoreal_scene(gems, setup, width=8, height=8)
    with pytest.raises(InputError, match=r"^test: camera\.distance = 3\.0: is too near to see "):
        photoreal_scene(gems, setup, width=8, height=8, move=Move())


def test_the_file_of_the_setup_is_named(variant_llvm_ad_spectral):
    setup = dataclasses.replace(setup_of(Camera(distance=0.2)), source="near.toml")
    with pytest.raises(InputError, match=r"^near\.toml: camera\.distance = 0\.2: is too near "):
        photoreal_scene(make_gems(ROW[:1]), setup, width=8, height=8)


@pytest.mark.parametrize(("width", "height"), [(0, 5), (5, 0), (70000, 5), (5, -1)])
def test_a_size_that_no_picture_has_is_refused(width, height, variant_llvm_ad_spectral):
    with pytest.raises(InputError, match=r"^size: (width|height) = .*: must be from 1 to 16384 \[pixels\]$"):
        photoreal_scene(make_gems(ROW[:1]), load_setup("white"), width=width, height=height)

"""How stones move in films: angles and places in closed form, loops without a seam."""

from __future__ import annotations

import numpy as np
import pytest
from thorough import some

from gemrender import InputError, load_stone
from gemrender.render.photoreal import make_gems
from gemrender.scene.moves import DEFAULT_TO_DEG, MOVES, Move
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import place
from gemrender.scene.setup import Camera, Ground, Setup, Sky

#: Lengths and directions after a few rotations in double precision [girdle radius].
ROUNDING = 1e-12
FRAMES = 24
#: The camera's azimuth, which the moves go by [deg].
AZIMUTH = -50.0
ROW = [load_stone("inoue-1"), load_stone("oval-classic")]


def resting(pose="table-up"):
    return place(ROW, pose=pose, facing_deg=0.0, gap=0.4, azimuth_deg=AZIMUTH, sizes=[1.0, 1.3])


def at(move, share, *, on_ground=True, pose="table-up"):
    return move.placed(resting(pose), share, azimuth_deg=AZIMUTH, on_ground=on_ground)


def same(a, b):
    return all(
        np.allclose(x.rotation, y.rotation, rtol=0, atol=ROUNDING)
        and np.allclose(x.shift, y.shift, rtol=0, atol=ROUNDING)
        for x, y in zip(a, b, strict=True)
    )


def middle(placed):
    points = placed.points()
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def axes():
    """To the camera's right, and to the camera, both level."""
    a = np.radians(AZIMUTH)
    return np.array([-np.sin(a), np.cos(a), 0.0]), np.array([np.cos(a), np.sin(a), 0.0])


def test_a_turntable_turns_evenly_and_its_last_frame_leads_to_the_first():
    move = Move()
    steps = [
        at(move, (k + 1) / FRAMES)[0].rotation @ at(move, k / FRAMES)[0].rotation.T for k in range(FRAMES)
    ]
    c, s = np.cos(2 * np.pi / FRAMES), np.sin(2 * np.pi / FRAMES)
    np.testing.assert_allclose(steps, [[[c, -s, 0], [s, c, 0], [0, 0, 1]]] * FRAMES, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", ["rock", "tilt"])
def test_a_swing_is_a_pendulums(name):
    """Where the table looks: a sine of the share, to the right or to the camera first."""
    move, (right, front) = Move(type=name, to_deg=20.0), axes()
    first = right if name == "rock" else front
    for share in np.arange(FRAMES) / FRAMES:
        angle = np.radians(20.0 * np.sin(2 * np.pi * share))
        expected = np.cos(angle) * np.array([0, 0, 1]) + np.sin(angle) * first
        for stone in at(move, share):
            np.testing.assert_allclose(stone.rotation[:, 2], expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("name", MOVES)
@pytest.mark.parametrize("pose", ["table-up", "lying"])
def test_films_are_loops(name, pose):
    move = Move(type=name)
    assert same(at(move, 0.0, pose=pose), resting(pose))
    for share in (0.0, 0.3, 0.75):
        assert same(at(move, share + 1, pose=pose), at(move, share, pose=pose))
    # No step is longer than the longest within the film: the way from the last frame to the first is none
    turns = [move.angle_deg(k / FRAMES) for k in range(FRAMES + 1)]
    if name == "turntable":
        turns[-1] = 360.0
    steps = np.abs(np.diff(turns))
    assert steps[-1] == pytest.approx(steps[0])
    assert steps[-1] <= steps.max() * (1 + ROUNDING)


@pytest.mark.parametrize("name", ["rock", "tilt"])
def test_stones_swing_about_their_middle_and_touch_the_ground(name):
    move = Move(type=name)
    for share in (0.1, 0.25, 0.6):
        for before, on_ground, in_air in zip(
            resting(), at(move, share), at(move, share, on_ground=False), strict=True
        ):
            assert on_ground.points()[:, 2].min() == pytest.approx(0, abs=ROUNDING)
            np.testing.assert_allclose(in_air.rotation, on_ground.rotation, rtol=0, atol=0)
            turn = in_air.rotation @ before.rotation.T
            there = turn @ (before.points() - middle(before)).T
            np.testing.assert_allclose(in_air.points() - middle(before), there.T, rtol=0, atol=ROUNDING)
            np.testing.assert_allclose(
                on_ground.points()[:, :2], in_air.points()[:, :2], rtol=0, atol=ROUNDING
            )


STILL = [(name, ground, at) for name in MOVES for ground in ("none", "plane") for at in (10, 40)]


@pytest.mark.parametrize(("name", "ground", "elevation"), some(STILL, 3))
def test_the_camera_stands_still_and_sees_all_of_it(name, ground, elevation, variant_llvm_ad_spectral):
    camera = Camera(type="orthographic", azimuth=AZIMUTH, elevation=elevation, margin=1.0)
    setup = Setup(name="test", sky=Sky(radiance=1.0), ground=Ground(type=ground), camera=camera)
    gems, move = make_gems(ROW), Move(type=name, to_deg=30.0)
    sensors, most = set(), 0.0
    for share in np.arange(12) / 12:
        scene = photoreal_scene(gems, setup, width=90, height=160, move=move, share=float(share))
        sensors.add(repr(scene.plain["sensor"]))
        to_picture = np.linalg.inv(np.array(scene.plain["sensor"]["to_world"].matrix, dtype=np.float64))
        points = np.concatenate([p.points() for p in scene.stones])
        x, y = (points @ to_picture[:2, :3].T + to_picture[:2, 3]).T
        most = max(most, np.abs(x).max(), np.abs(y).max() * 90 / 160)
    assert len(sensors) == 1
    assert 0.97 < most < 1 + 1e-5  # single precision of the matrix


def test_a_stone_in_a_cup_stays_upright(variant_llvm_ad_spectral):
    setup = Setup(name="test", sky=Sky(radiance=1.0), ground=Ground(type="cup"))
    gems = make_gems(ROW[:1])
    photoreal_scene(gems, setup, width=8, height=8, move=Move(), share=0.2)
    with pytest.raises(InputError, match=r"^move = 'rock': must be turntable where stones stand in cups$"):
        photoreal_scene(gems, setup, width=8, height=8, move=Move(type="rock"))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("spin", None), "move = 'spin': must be one of turntable, rock, tilt"),
        (("rock", 0.0), "to = 0.0: must be above 0 and up to 90"),
        (("tilt", 91.0), "to = 91.0: must be above 0 and up to 90"),
        (("tilt", float("nan")), "to = nan: must be above 0 and up to 90"),
        (("rock", "far"), "to = 'far': must be above 0 and up to 90"),
        (("turntable", 20.0), "to = 20.0: is of rock and tilt"),
    ],
)
def test_what_is_no_move_is_refused(options, words):
    with pytest.raises(InputError) as caught:
        Move.of(*options)
    assert str(caught.value).startswith(words)


def test_the_default_is_what_a_hand_does():
    assert Move.of("rock", None).to_deg == DEFAULT_TO_DEG

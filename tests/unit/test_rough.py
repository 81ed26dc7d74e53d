"""Yield: the largest stones that boxes and meshes hold, whose sizes are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from designs_help import level, ring, stone_of
from meshes import BOX_FACES, box, turned

from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.rough import Box, Diameter
from gemrender.sweep.improve.rough_mesh import MeshRough
from gemrender.sweep.improve.sized import Sized, read_rough

#: Rounding of sums and products.
ROUNDING = 1e-12
#: What linear programmes are solved to, and what a turn that is off by 1e-4 degrees makes [share].
SOLVED = 1e-5
BRILLIANT = load_stone("gia-excellent")


def column(length=1.0, width=1.0, height=1.0, material="quartz"):
    """An upright box of these half sides, with its frame's unit along the longest; turned by 45 degrees from
    how `ring` has it, so that its sides lie along x and y."""
    sides = ring(4, 90, 1.0, start=0.0)
    sides[:, 3] = [length, width, length, width]
    return stone_of(np.concatenate([sides, level(height), level(height, down=True)]), material=material)


def around_z(degrees):
    a = np.radians(degrees)
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def around_x(degrees):
    a = np.radians(degrees)
    return np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])


def test_a_box_in_a_box_is_all_of_it():
    fit = Box((10.0, 8.0, 6.0)).fit(column(1.0, 0.8, 0.6))
    assert fit.scale_mm == pytest.approx(5.0, rel=ROUNDING)
    assert fit.yielded == pytest.approx(100.0, rel=ROUNDING)
    assert fit.carat(2.65) == pytest.approx(480 * 2.65 / 200, rel=ROUNDING)


def test_a_box_turns_to_where_it_fits():
    fit = Box((8.0, 10.0, 6.0)).fit(column(1.0, 0.8, 0.6))
    assert (fit.yielded, abs(fit.turn_deg)) == pytest.approx((100.0, 90.0), rel=ROUNDING)


def test_a_stick_lies_along_the_diagonal():
    """At 45 degrees it is (length + width) / sqrt 2 wide in both directions."""
    fit = Box((3.0, 3.0, 100.0)).fit(column(1.0, 0.1, 0.1))
    assert fit.scale_mm == pytest.approx(3.0 / (2.2 / np.sqrt(2.0)), rel=ROUNDING)
    assert abs(fit.turn_deg) % 90 == pytest.approx(45.0, rel=ROUNDING)


@pytest.mark.parametrize("sides", [(3.0, 2.9), (3.0, 2.0), (2.0, 5.0)])
def test_no_turn_is_better_than_the_one_that_is_found(sides):
    stone = families()["pear"]().stone(name="pear")
    points = stone.vertices[:, :2]
    turns = np.radians(np.linspace(0, 180, 20_001))
    x = np.ptp(np.column_stack([np.cos(turns), np.sin(turns)]) @ points.T, axis=1)
    y = np.ptp(np.column_stack([-np.sin(turns), np.cos(turns)]) @ points.T, axis=1)
    best = np.minimum(sides[0] / x, sides[1] / y).max()
    found = Box((*sides, 100.0)).fit(stone).scale_mm
    assert best <= found * (1 + ROUNDING)
    assert found == pytest.approx(best, rel=1e-4)  # the turns tried are 0.009 degrees apart


def test_a_round_brilliant_in_a_box():
    fit = Box((10.0, 8.0, 20.0)).fit(BRILLIANT)
    assert fit.scale_mm == pytest.approx(4.0, rel=ROUNDING)
    assert fit.volume_mm3 == pytest.approx(BRILLIANT.solid.volume * 64, rel=ROUNDING)
    flat = Box((10.0, 8.0, 1.0)).fit(BRILLIANT)
    assert flat.scale_mm == pytest.approx(1.0 / np.ptp(BRILLIANT.vertices[:, 2]), rel=1e-9)


def test_a_mesh_that_is_a_box_turned_about_the_axis():
    rough = MeshRough("r", *box((5, 4, 3), (7, -2, 1), around_z(20)))
    assert rough.volume_mm3 == pytest.approx(480.0, rel=ROUNDING)
    fit = rough.fit(column(1.0, 0.8, 0.6))
    assert fit.yielded == pytest.approx(100.0, rel=SOLVED)
    assert fit.turn_deg % 180 == pytest.approx(20.0, abs=2e-4)


def test_a_tilted_mesh_leaves_less():
    """An upright square in a square tilted by a: cos a + sin a times smaller."""
    rough = MeshRough("r", *box((10, 1, 1), (0, 0, 5), around_x(30)))
    fit = rough.fit(column(1.0, 1.0, 1.0))
    expected = 1.0 / (np.cos(np.pi / 6) + np.sin(np.pi / 6))
    assert fit.scale_mm == pytest.approx(expected, rel=SOLVED)


def test_a_round_brilliant_in_a_mesh():
    rough = MeshRough("r", *box((5, 4, 10)))
    assert rough.fit(BRILLIANT).scale_mm == pytest.approx(4.0, rel=SOLVED)


def dented(depth, half=1.0):
    """A cube, whose upper face goes down to a point in the middle."""
    positions, faces = box((1, 1, 1))
    positions = np.concatenate([positions, [(0, 0, 1 - depth)]])
    top = [k for k, face in enumerate(BOX_FACES) if (positions[face, 2] == 1).all()]
    ring = [(1, 5), (5, 7), (7, 3), (3, 1)]
    return positions * half, np.array([*np.delete(faces, top, axis=0), *((a, b, 8) for a, b in ring)])


def test_of_rough_that_is_not_convex_what_lies_below_its_dents_is_used():
    rough = MeshRough("r.stl", *dented(0.3))
    assert rough.volume_mm3 == pytest.approx(8.0 - 4 * 0.3 / 3, rel=ROUNDING)
    assert rough.note == "r.stl is not convex: what lies 0.3 mm inside its hull is used"
    assert rough.fit(column()).scale_mm == pytest.approx(0.7, rel=SOLVED)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (dented(1.2), "is too far from convex"),
        ((box()[0], BOX_FACES[1:]), "is an open surface: a hole with 3 edges"),
        ((box()[0] * 0.01, BOX_FACES), "must be from 0.1 to 10000 mm"),
        ((box((1, 1, 0))[0], BOX_FACES), "is flat|flat|encloses|at least four"),
    ],
)
def test_what_is_no_rough_is_told(mesh, said):
    with pytest.raises(InputError, match=said) as caught:
        MeshRough("r", *mesh)
    assert "\n" not in str(caught.value)


def test_faces_that_are_wound_the_wrong_way_do_not_matter():
    assert MeshRough("r", *turned(box(), 0, 5)).volume_mm3 == pytest.approx(8.0, rel=ROUNDING)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("box=10x8x6", Box((10.0, 8.0, 6.0))),
        ("box = 10 X 8.5 x 6", Box((10.0, 8.5, 6.0))),
        ("diameter=6.5", Diameter(6.5)),
    ],
)
def test_rough_is_read(text, expected):
    assert read_rough(text) == expected


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("box=10x8", "must be box=LENGTHxWIDTHxHEIGHT, diameter=D"),
        ("box=10x8xa", "must be box="),
        ("10x8x6", "must be box="),
        ("ball=3", "must be box="),
        ("box=10x8x0", "must be from 0.1 to 10000 mm"),
        ("box=10x-8x6", "must be from 0.1 to 10000 mm"),
        ("box=10xnanx6", "must be from 0.1 to 10000 mm"),
        ("diameter=inf", "must be from 0.1 to 10000 mm"),
        ("mesh=rough.xyz", "must be a mesh, one of .stl, .obj, .ply, .glb"),
        ("mesh=not-there.stl", "not-there.stl: no such file|not-there.stl: "),
        ("mesh=", "must be box="),
    ],
)
def test_what_is_written_of_no_rough_is_told(text, said):
    with pytest.raises(InputError, match=said) as caught:
        read_rough(text)
    assert "\n" not in str(caught.value)


def test_a_mesh_is_read_from_its_file(tmp_path):
    from gemrender.cuts.mesh_files import write_mesh

    write_mesh(column(1.0, 0.8, 0.6), tmp_path / "rough.stl")
    rough = read_rough(f"mesh={tmp_path / 'rough.stl'}")
    assert rough.fit(column(1.0, 0.8, 0.6)).yielded == pytest.approx(100.0, rel=SOLVED)
    (tmp_path / "open.stl").write_text(
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
        "endfacet\nendsolid\n"
    )
    with pytest.raises(InputError, match=r"open\.stl: ") as caught:
        read_rough(f"mesh={tmp_path / 'open.stl'}")
    assert "\n" not in str(caught.value)


def values(goal, stone, rough):
    return Sized.of([Goal.parse(goal)], stone, rough).values(stone)


def test_goals_name_yield_and_carat():
    stone = column(1.0, 0.8, 0.6)
    assert Goal.parse("yield").sizes == ("yield",)
    assert Goal.parse("(inoue - 0.5*yield) + carat").sizes == ("yield", "carat")
    assert values("yield + carat + volume", stone, Box((10, 8, 6))) == pytest.approx(
        {"volume": 8 * 0.48, "yield": 100.0, "carat": 480 * 2.65 / 200}, rel=ROUNDING
    )
    known = {"yield": 30.0, "carat": 2.0}
    assert Goal.parse("yield*carat").value(lambda number, pose: known) == 60.0


def test_a_diameter_is_kept():
    found = values("carat", BRILLIANT, Diameter(6.5))
    assert found["carat"] == pytest.approx(BRILLIANT.solid.volume * 3.25**3 * 3.52 / 200, rel=ROUNDING)


def test_the_size_that_a_stone_has_makes_its_weight():
    sized = load_stone("gia-excellent")
    from dataclasses import replace

    assert values("carat", replace(sized, size_mm=6.5), None) == values("carat", sized, Diameter(6.5))


@pytest.mark.parametrize(
    ("goal", "stone", "rough", "said"),
    [
        ("yield", BRILLIANT, None, "goal = 'yield': yield needs rough, as --rough box=10x8x6"),
        ("carat", BRILLIANT, None, "carat needs rough"),
        ("yield", BRILLIANT, Diameter(6.5), "yield needs rough that has a volume"),
        ("carat", column(material=1.54), Diameter(6.5), "material = 1.54: carat needs a material with a"),
    ],
)
def test_what_goals_lack_is_told(goal, stone, rough, said):
    with pytest.raises(InputError, match=said) as caught:
        values(goal, stone, rough)
    assert "\n" not in str(caught.value)

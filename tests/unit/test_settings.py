"""Settings: made for every cut, closed, touching the girdle, and nowhere in the stone."""

from __future__ import annotations

import numpy as np
import pytest
from any_stones import FOLDER
from meshes import ball, box, distances
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.scene.closed import closed_surface
from gemrender.scene.cutting import inside_of, refuse_cutting
from gemrender.scene.placing import Placed
from gemrender.scene.settings import make_setting
from gemrender.scene.settings.heads import GAP
from gemrender.scene.settings.making import CONTACT
from gemrender.scene.settings.outline import Outline, claw_directions
from gemrender.scene.smooth import creased
from gemrender.stone import tessellate

KINDS = ("solitaire", "bezel", "pendant")
#: A stone of each family, and designs of corners, hollows and no symmetry.
CUTS = [*families(), "novelty-chiral", "triangle-negative-gear"]
#: A round one, points, a square, corners that are cut, a hollow and no symmetry.
SHOWN = ("round brilliant", "pear", "princess", "emerald", "novelty-chiral", "triangle-negative-gear")
#: Rounding, of distances [girdle radius].
ROUNDING = 1e-9
#: How far a round girdle is beyond the chords that a setting is made by [girdle radius].
CHORDS = 1 - np.cos(np.pi / 128)
#: Of a claw this much around the contact is looked at, a part of its bend [girdle radius].
NEAR = 0.12


def stone_of(name):
    if name in families():
        return families()[name]().stone(name=name)
    return load_stone(FOLDER / f"{name}.asc")


def in_place(stone):
    mesh = tessellate(stone)
    return Placed(name=stone.name, mesh=mesh, rotation=np.eye(3), scale=1.0, shift=np.zeros(3))


@pytest.mark.parametrize("name", chosen(CUTS, SHOWN))
def test_settings_are_made_for_every_cut_and_cut_none(name):
    """They cut no stone, and claws are as near to the girdle as said, and no nearer."""
    stone = stone_of(name)
    outline, mesh = Outline.of(stone), tessellate(stone)
    inside = [(name, inside_of(in_place(stone)))]
    triangles = mesh.vertices[mesh.faces]
    for kind in KINDS:
        setting = make_setting(stone, kind, radius_mm=3.25)
        made = setting.mesh
        refuse_cutting(made.triangles, inside, key="setting", value=kind, may_hold=False)
        np.testing.assert_allclose(np.linalg.norm(made.normals, axis=1), 1, atol=ROUNDING)
        assert setting.lowest <= stone.vertices[:, 2].min() - GAP
        if kind == "bezel":
            continue
        angles = claw_directions(outline, first=outline.long_angle if kind == "pendant" else None)
        assert len(angles) >= 3
        for angle in angles:
            contact = outline.support(angle)
            near = np.linalg.norm(made.positions[:, :2] - contact, axis=1) < NEAR
            near &= made.positions[:, 2] > outline.girdle[0] - NEAR
            flat = triangles[:, :, :2]
            low, high = flat.min(axis=1), flat.max(axis=1)
            beside = ((low < contact + 2 * NEAR) & (high > contact - 2 * NEAR)).all(axis=1)
            distance = distances(made.positions[near], triangles[beside]).min()
            assert GAP - CHORDS <= distance <= CONTACT


@pytest.mark.parametrize("name", ["round brilliant", "pear", "princess"])
def test_a_rim_follows_the_outline(name):
    """Its inside is as far from the outline, seen from above, as said, all around."""
    stone = stone_of(name)
    outline = Outline.of(stone)
    made = make_setting(stone, "bezel", radius_mm=3.25).mesh
    low, _ = outline.girdle
    beside = (np.abs(made.positions[:, 2] - low) < ROUNDING) & (outline.scales(made.positions[:, :2]) < 1.05)
    corners = np.column_stack([outline.points, np.zeros(len(outline.points))])
    fan = np.stack(
        [np.tile([*outline.middle, 0.0], (len(corners), 1)), corners, np.roll(corners, -1, axis=0)], 1
    )
    flat = made.positions[beside] * (1, 1, 0)
    distance = distances(flat, fan)
    assert distance.min() >= GAP - ROUNDING
    assert np.median(distance) <= CONTACT


@pytest.mark.parametrize("mm", [0.5, 25.0])
@pytest.mark.parametrize("kind", KINDS)
def test_stones_of_any_size_are_held(kind, mm):
    stone = stone_of("oval")
    made = make_setting(stone, kind, radius_mm=mm).mesh
    inside = [("oval", inside_of(in_place(stone)))]
    refuse_cutting(made.triangles, inside, key="setting", value=kind, may_hold=False)


def test_a_ring_fits_a_finger():
    made = make_setting(stone_of("round brilliant"), "solitaire", radius_mm=3.25)
    low, high = made.mesh.positions.min(axis=0), made.mesh.positions.max(axis=0)
    # 17.3 mm inside and twice 1.6 mm of band, across the finger
    assert (high - low)[0] * 3.25 == pytest.approx(17.3 + 2 * 1.6, abs=0.01)


@pytest.mark.parametrize(
    ("name", "degrees"),
    [
        ("round brilliant", [30, 90, 150, 210, 270, 330]),
        ("princess", [45, 135, 225, 315]),
        ("emerald", [45, 135, 225, 315]),
        ("trilliant", [90, 210, 330]),
        ("marquise", [30, 90, 150, 210, 270, 330]),
        ("pear", [18, 90, 162, 234, 306]),
    ],
)
def test_claws_stand_at_corners_and_between(name, degrees):
    found = np.degrees(claw_directions(Outline.of(stone_of(name)))) % 360
    np.testing.assert_allclose(np.sort(found), degrees, atol=1)


def test_parts_of_a_setting_are_closed():
    """Each of them, where normals are smooth: they overlap, so that together they are no solid."""
    from gemrender.scene.settings import heads, solids

    outline = Outline.of(stone_of("pear"))
    parts = [
        *heads.claws(outline, claw_directions(outline), 0.12, "ring").parts,
        *heads.rim(outline, 0.15).parts,
    ]
    parts.append(solids.band(2.0, 0.5, 0.4, np.array([0.0, 1.0, 0.0]), np.zeros(3)))
    for part in parts:
        found = closed_surface(part.positions, part.faces)
        assert (found.outward == 1).all()
        area = np.cross(
            part.triangles[:, 1] - part.triangles[:, 0], part.triangles[:, 2] - part.triangles[:, 0]
        )
        area /= np.linalg.norm(area, axis=1, keepdims=True)
        assert (np.einsum("fki,fi->fk", part.normals[part.faces], area) > 0.6).all()


def test_a_mesh_that_cuts_a_stone_or_holds_it_is_refused():
    stone = stone_of("round brilliant")
    inside = [("round", inside_of(in_place(stone)))]
    for half, told in (
        (0.3, "must not cut a stone; it reaches into round"),
        (3.0, "must not have a stone inside"),
    ):
        positions, faces = box((half, half, half))
        with pytest.raises(InputError, match=told):
            refuse_cutting(positions[faces], inside, key="thing 1.mesh", value="box.ply")
    positions, faces = box((0.3, 0.3, 0.3), centre=(1.4, 0, 0))
    refuse_cutting(positions[faces], inside, key="thing 1.mesh", value="box.ply")


def test_normals_break_at_creases_only():
    made = creased(*box())
    assert len(made.positions) == 24  # each corner of a box has three normals
    np.testing.assert_allclose(np.abs(made.normals).max(axis=1), 1, atol=ROUNDING)
    round_one = creased(*ball())
    np.testing.assert_allclose(round_one.normals, round_one.positions, atol=0.05)

"""Settings: made for every cut, closed, touching the girdle, and nowhere in the stone."""

from __future__ import annotations

import numpy as np
import pytest
from designs_help import DESIGNS

from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.scene.closed import closed_surface
from gemrender.scene.cutting import inside_of, refuse_cutting
from gemrender.scene.inside import _distance
from gemrender.scene.placing import Placed
from gemrender.scene.settings import make_setting
from gemrender.scene.settings.heads import GAP
from gemrender.scene.settings.making import CONTACT
from gemrender.scene.settings.outline import Outline, claw_directions
from gemrender.scene.smooth import creased
from gemrender.stone import tessellate

KINDS = ("solitaire", "bezel", "pendant")
#: A stone of each family, and designs of corners, hollows and no symmetry.
CUTS = [*families(), "heart", "novelty-chiral", "triangle-negative-gear", "slab-chiral"]
#: Rounding, of distances [girdle radius].
ROUNDING = 1e-9


def stone_of(name):
    if name in families():
        return families()[name]().stone(name=name)
    return load_stone(f"{CASES}/{name}.asc")


def in_place(stone):
    mesh = tessellate(stone)
    return Placed(name=stone.name, mesh=mesh, rotation=np.eye(3), scale=1.0, shift=np.zeros(3))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", CUTS)
def test_a_setting_is_made_for_every_cut_and_cuts_none(name, kind):
    stone = stone_of(name)
    made = make_setting(stone, kind, radius_mm=3.25)
    refuse_cutting(made.mesh.triangles, [(name, inside_of(in_place(stone)))], key="setting", value=kind)
    assert np.isfinite(made.mesh.positions).all()
    np.testing.assert_allclose(np.linalg.norm(made.mesh.normals, axis=1), 1, atol=1e-9)
    assert made.lowest <= stone.vertices[:, 2].min() - GAP


@pytest.mark.parametrize("kind", ["solitaire", "pendant"])
@pytest.mark.parametrize("name", CUTS)
def test_claws_touch_the_girdle(name, kind):
    """At each claw the metal is as near to the stone as said, and no nearer."""
    stone = stone_of(name)
    outline = Outline.of(stone)
    made = make_setting(stone, kind, radius_mm=3.25).mesh
    first = outline.long_angle if kind == "pendant" else None
    places = stone.vertices
    triangles = places[tessellate(stone).faces] if stone.is_round else in_place(stone).mesh.vertices
    if not stone.is_round:
        triangles = triangles[tessellate(stone).faces]
    for angle in claw_directions(outline, first=first):
        contact = outline.support(angle)
        near = np.linalg.norm(made.positions[:, :2] - contact, axis=1) < 0.1
        near &= made.positions[:, 2] > outline.girdle[0] - 0.1
        distance = _distance(made.positions[near], triangles).min()
        assert GAP - ROUNDING <= distance <= CONTACT

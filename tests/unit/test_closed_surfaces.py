"""Meshes as solids: what is joined, what is turned, what is no solid."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import box, seamed_box, soup, together, turned

from gemrender.errors import InputError
from gemrender.scene.closed import closed_surface

#: Volumes of boxes in float64.
EXACT = 1e-12


def volume(surface):
    """Volume that the triangles of a surface enclose, by the divergence theorem."""
    a, b, c = surface.triangles.transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def blown(mesh, tolerance, rng):
    """Vertices moved by up to `tolerance` each."""
    positions, faces = mesh
    return positions + rng.uniform(-tolerance, tolerance, positions.shape), faces


@pytest.mark.parametrize("join", [lambda m: m, lambda m: soup(*m)], ids=["joined", "soup"])
def test_a_right_mesh_looks_outwards(join):
    surface = closed_surface(*join(box()))
    assert (surface.outward == 1).all()
    assert volume(surface) == pytest.approx(8, abs=EXACT)


@pytest.mark.parametrize("wrong", [(0,), (0, 5, 7), range(12), range(1, 12)], ids=str)
def test_faces_that_look_inwards_are_found(wrong):
    # From a soup too: the corners are joined before faces are compared
    for mesh in (turned(box(), *wrong), soup(*turned(box(), *wrong))):
        surface = closed_surface(*mesh)
        np.testing.assert_array_equal(np.flatnonzero(surface.outward == -1), np.sort(wrong))
        assert volume(surface) == pytest.approx(8, abs=EXACT)


def test_corners_within_the_tolerance_are_one(rng):
    # 2e-6 of the size each, wherever the corner lies in the grid that they are joined by
    for shift in rng.uniform(-3, 3, (20, 3)):
        surface = closed_surface(*blown(soup(*box(centre=shift)), 2e-6, rng))
        assert (surface.outward == 1).all()


def test_corners_farther_apart_are_an_open_surface(rng):
    with pytest.raises(
        InputError, match=r"^must be a closed surface; \d+ edges have a face on one side only$"
    ):
        closed_surface(*blown(soup(*box()), 2e-3, rng))


def test_corners_on_edges_of_neighbours_close_a_surface():
    surface = closed_surface(*turned(seamed_box(), 0, 11, 17))
    assert volume(surface) == pytest.approx(8, abs=EXACT)
    np.testing.assert_array_equal(np.flatnonzero(surface.outward == -1), [0, 11, 17])


def test_an_open_surface_says_how_open():
    positions, faces = box()
    with pytest.raises(InputError, match=r"^must be a closed surface; 3 edges have"):
        closed_surface(positions, faces[1:])


def test_faces_without_an_area_are_passed_by():
    positions, faces = box()
    surface = closed_surface(positions, np.concatenate([faces, [(3, 3, 5), (2, 2, 2)]]))
    assert list(surface.outward) == [1] * 12 + [0] * 2
    assert len(surface.triangles) == len(surface.body) == 12


@pytest.mark.parametrize("wound", [lambda m: m, lambda m: soup(*m)], ids=["joined", "soup"])
@pytest.mark.parametrize("swap", [False, True])
def test_a_part_inside_another_that_is_wound_the_other_way_is_a_hollow(wound, swap):
    hollow = together(box(), turned(box((0.5, 0.5, 0.5))))
    surface = closed_surface(*wound(turned(hollow) if swap else hollow))
    assert (surface.outward == (-1 if swap else 1)).all()
    assert volume(surface) == pytest.approx(8 - 1, abs=EXACT)
    assert (surface.body == 0).all()


def test_a_part_in_a_hollow_is_a_solid():
    nested = together(box((0.4, 0.4, 0.4)), turned(box((0.5, 0.5, 0.5))), box())
    surface = closed_surface(*nested)
    assert volume(surface) == pytest.approx(8 - 1 + 0.512, abs=EXACT)
    assert len(np.unique(surface.body)) == 2


@pytest.mark.parametrize(
    "other", [box((0.5, 0.5, 0.5)), box(centre=(0.5, 0.5, 0.5)), box((0.1, 0.1, 5)), box()], ids=str
)
def test_parts_that_overlap_are_refused(other):
    # As Mitsuba makes one mesh of stones of one material
    for mesh in (together(box(), other), turned(together(box(), other))):
        with pytest.raises(InputError, match=r"^must not overlap itself"):
            closed_surface(*mesh)


@pytest.mark.parametrize("centre", [(2, 2, 2), (2, 2, 0), (2, 0, 0), (2, 0.5, 0.3), (3, 0, 0)])
@pytest.mark.parametrize("wound", [lambda m: m, lambda m: soup(*m)], ids=["joined", "soup"])
def test_parts_that_touch_are_solids(wound, centre):
    # At a corner, at an edge where four faces meet, or with two faces in one place; one of them is inside out
    surface = closed_surface(*wound(together(box(), turned(box(centre=centre)))))
    assert volume(surface) == pytest.approx(16, abs=EXACT)
    np.testing.assert_array_equal(surface.outward, np.repeat([1, -1], 12))
    assert len(np.unique(surface.body)) == 2


def doubled(mesh):
    """Each face followed by itself, wound the other way."""
    positions, faces = mesh
    return positions, np.stack([faces, faces[:, ::-1]], axis=1).reshape(-1, 3)


def moebius(n=24):
    """A strip that is turned half round, closed to a surface without edges by no face."""
    k = np.arange(n)
    turn = 2 * np.pi * k / n
    out = []
    for side in (-0.3, 0.3):
        radius = 1 + side * np.cos(turn / 2)
        out.append(np.stack([radius * np.cos(turn), radius * np.sin(turn), side * np.sin(turn / 2)], axis=1))
    positions = np.concatenate(out)
    a, b = k, k + n
    c, d = np.where(k + 1 < n, k + 1, n), np.where(k + 1 < n, k + 1 + n, 0)
    return positions, np.concatenate([np.stack([a, c, b], axis=1), np.stack([c, d, b], axis=1)])


def klein(n=24):
    """A surface without edges or sides: a bottle whose neck goes through its wall (figure-8 immersion)."""
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(n) / n, indexing="ij")
    r = 3 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    positions = np.stack([r * np.cos(u), r * np.sin(u), z], axis=2).reshape(-1, 3)

    def number(i, j):  # after a round of u, v runs backwards
        return np.where(i < n, i * n + j % n, (-j) % n)

    i, j = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
    return positions, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


@pytest.mark.parametrize(
    ("mesh", "refused"),
    [
        ((np.zeros((3, 3)), np.zeros((0, 3), dtype=int)), "must have faces"),
        ((np.eye(3), [(0, 1, 3)]), "must have a vertex of every number that a face names"),
        ((np.diag([1, 1, np.nan]), [(0, 1, 2)]), "must have vertices that are finite numbers"),
        (doubled(box()), "must have each face once; 12 of them are there again"),
        ((np.eye(3), [(0, 1, 2), (0, 2, 1)]), "must have each face once; 1 of them are there again"),
        (box((1, 1, 0)), "must have each face once"),
        (box((1, 1, 1e-11)), "must"),
        (moebius(), "must be a closed surface; 48 edges have a face on one side only"),
        (klein(), "must have an inside and an outside; it is one-sided"),
    ],
)
def test_what_is_no_solid_is_refused(mesh, refused):
    with pytest.raises(InputError, match=f"^{refused}"):
        closed_surface(*mesh)


def test_a_sheet_with_two_sides_encloses_nothing():
    # Its two sides are triangulated the other way, so that no face is there twice
    positions = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    with pytest.raises(InputError, match=r"^must enclose a volume$"):
        closed_surface(positions, [(0, 1, 2), (0, 2, 3), (1, 0, 3), (1, 3, 2)])

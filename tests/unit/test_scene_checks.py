"""Scenes of one's own in which light cannot be followed by `gem_path`: told or refused, once a scene."""

from __future__ import annotations

import gc
import re
import weakref

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from checked_scenes import GEM, INWARDS, QUARTZ, SOME, camera, check, refused, scene, told
from meshes import ball, box, turned

from gemrender.errors import GemrenderWarning, InputError

#: Single precision.
SINGLE = 1e-5
#: A small part of a box: its faces do not meet those of a box of the same centre.
SMALL = (0.2, 0.3, 0.25)


# ---- Stones, cameras and lights in stones --------------------------------------------------------------


@pytest.mark.parametrize(
    "other",
    [
        box(SMALL),
        box((0.1, 0.1, 5)),  # its edges go through faces: no corner is inside
        box(centre=(1.9, 1.9, 1.9)),
        box(),
        ball(6),
    ],
    ids=["inside", "through", "corner", "the same", "ball"],
)
def test_stones_that_overlap_are_refused(variant_llvm_ad_rgb, ply, other):
    assert refused(scene(one=ply(box()), two=ply(other, bsdf=QUARTZ))) in (
        "stones = 'two in one': must not overlap",
        "stones = 'one in two': must not overlap",
    )
    # Of one material, Mitsuba makes them one mesh without an id
    together_refused = refused(scene(one=ply(box()), two=ply(other)))
    assert together_refused.startswith("stone = 'mesh_")
    assert "must not overlap itself" in together_refused


def test_stones_of_one_material_are_told_by_their_files(variant_llvm_ad_rgb, ply):
    # Mitsuba makes one mesh of them; they touch at an edge, whose corners are in the same places
    two = scene(one=ply(box()), two=ply(turned(box(centre=(0, 2, 2)))))
    assert len(two.shapes()) == 1
    expected = "stone mesh_1.ply + mesh_2.ply has 12 faces of 24 that look inwards; they are turned round"
    (message,) = told(two)
    assert message in (expected, expected.replace("1.ply + mesh_2", "2.ply + mesh_1"))


def test_a_sphere_in_a_stone_is_refused(variant_llvm_ad_rgb, ply):
    sphere = {"type": "sphere", "center": [0.9, 0.9, 0.9], "radius": 0.3, "bsdf": GEM}
    assert "must not overlap" in refused(scene(one=ply(box()), two=sphere))


def test_what_touches_a_stone_is_no_matter(variant_llvm_ad_rgb, ply):
    # Stones edge to edge and corner to corner, the ground, a cup, a lamp: no error and no warning
    diffuse = {"type": "diffuse"}
    up = mi.ScalarTransform4f().translate([0, 0, -1]).scale([60, 60, 1])
    lamp = mi.ScalarTransform4f().translate([0, 0, 1])
    check(
        scene(
            one=ply(box()),
            two=ply(box(centre=(2, -2, 0.1))),
            three=ply(box(centre=(-2, -2, 2)), bsdf=QUARTZ),
            four=ply(box(centre=(20, 0, 0)), bsdf=QUARTZ),
            round_one={"type": "sphere", "center": [0, 3, 1], "radius": 2, "bsdf": GEM},
            ground={"type": "disk", "to_world": up, "bsdf": diffuse},
            floor={"type": "rectangle", "to_world": up, "bsdf": diffuse},
            cup={"type": "cylinder", "p0": [20, 0, -1], "p1": [20, 0, 0], "radius": 2**0.5, "bsdf": diffuse},
            lamp={"type": "rectangle", "to_world": lamp, "emitter": {"type": "area"}},
        )
    )


def lamp_of_kind(kind, middle):
    """A lamp with its middle at a place."""
    there = mi.ScalarTransform4f().translate(middle)
    shining = {"emitter": {"type": "area"}}
    return {
        "sphere": {"type": "sphere", "center": middle, "radius": 0.1, **shining},
        "cylinder": {"type": "cylinder", "p0": middle, "p1": [*middle[:2], 9], "radius": 0.1, **shining},
        "rectangle": {"type": "rectangle", "to_world": there.scale(0.1), **shining},
        "wide rectangle": {"type": "rectangle", "to_world": there.scale(50), **shining},
        "disk": {"type": "disk", "to_world": there.scale(0.1), **shining},
        "wide disk": {"type": "disk", "to_world": there.scale(50), **shining},
        "point": {"type": "point", "position": middle},
        "spot": {"type": "spot", "to_world": there},
        "projector": {"type": "projector", "to_world": there, "irradiance": {"type": "rgb", "value": 1.0}},
    }[kind]


@pytest.mark.parametrize(
    "kind",
    [
        *("sphere", "cylinder", "rectangle", "wide rectangle", "disk", "wide disk"),
        *("point", "spot", "projector"),
    ],
)
def test_a_light_in_a_stone_is_refused(variant_llvm_ad_rgb, ply, kind):
    stone = ply(box())
    expected = "light = 'lamp in gem': must be outside all stones"
    assert refused(scene(gem=stone, lamp=lamp_of_kind(kind, [0.2, 0, 0.5]))) == expected
    told(scene(gem=stone, lamp=lamp_of_kind(kind, [0.2, 0, 1.2])))  # and not above it


def test_a_stone_that_shines_is_refused(variant_llvm_ad_rgb, ply):
    expected = "stone = 'gem': must not be a light as well"
    assert refused(scene(gem=ply(box(), emitter={"type": "area"}))) == expected


def test_a_light_around_stones_is_none_in_them(variant_llvm_ad_rgb, ply):
    dome = {"type": "sphere", "radius": 30, "flip_normals": True, "emitter": {"type": "area"}}
    check(scene(gem=ply(box()), dome=dome))


@pytest.mark.parametrize("bsdf", [GEM, QUARTZ], ids=["one mesh", "two"])
def test_stones_face_to_face_are_told(variant_llvm_ad_rgb, ply, bsdf):
    for gap, expected in ((0, True), (1e-6, True), (1e-4, False)):
        other = ply(box(SMALL, (0.1, 0.9, 1 + SMALL[2] + gap)), bsdf=bsdf)  # over an edge
        messages = told(scene(one=ply(box()), two=other))
        assert len(messages) == expected
        assert all(m.startswith("stones lie face to face, and light passes between") for m in messages)
        assert all(re.search("; leave [23]e-05 or more between: ", m) for m in messages)


@pytest.mark.parametrize("kind", ["perspective", "thinlens", "orthographic"])
def test_a_camera_in_a_stone_is_refused(variant_llvm_ad_rgb, ply, kind):
    inside = camera((0.2, 0.1, 0.3), type=kind)
    if kind != "perspective":
        del inside["fov"]
    if kind == "thinlens":
        inside |= {"fov": 20, "aperture_radius": 0.01}
    through = scene(gem=ply(box()), sensor=inside)
    assert refused(through) == "camera = 'inside gem': must be outside all stones"


def test_a_wide_plane_of_rays_that_starts_in_a_stone_is_refused(variant_llvm_ad_rgb, ply):
    # The stone is small beside the film, and away from its middle
    to_world = mi.ScalarTransform4f().look_at([0, 0, 0.2], [0, 0, -5], [0, 1, 0]).scale([40, 40, 1])
    view = {"type": "orthographic", "to_world": to_world}
    gem = ply(box((0.5, 0.5, 0.5), (11.3, 7.7, 0)))
    assert refused(scene(gem=gem, sensor=view)) == "camera = 'inside gem': must be outside all stones"


def test_another_integrator_asks_for_the_camera_too(variant_llvm_ad_rgb, ply):
    around = {"type": "moment", "nested": {"type": "gem_path"}}
    inside = scene(gem=ply(box()), sensor=camera((0.2, 0.1, 0.3)), integrator=around)
    with pytest.raises(RuntimeError) as error:
        mi.render(inside, spp=1)
    assert str(error.value.__cause__) == "camera = 'inside gem': must be outside all stones"


def test_the_camera_that_renders_counts(variant_llvm_ad_rgb, ply):
    both = scene(gem=ply(box()), inside=camera((0.2, 0.1, 0.3)))
    far = next(k for k, s in enumerate(both.sensors()) if s.id() == "sensor")
    mi.render(both, sensor=far, spp=1)
    with pytest.raises(RuntimeError) as error:
        mi.render(both, sensor=1 - far, spp=1)
    assert str(error.value.__cause__).startswith("camera = 'inside gem'")


def test_scenes_of_other_integrators_can_be_checked(variant_llvm_ad_rgb, ply):
    positions, faces = box()
    other = scene(gem=ply((positions, faces[1:])), integrator={"type": "path"})
    with pytest.raises(InputError, match="stone = 'gem': must be a closed surface"):
        mi.load_dict({"type": "gem_path"}).check(other, other.sensors()[0])


def test_other_things_in_stones_are_told(variant_llvm_ad_rgb, ply):
    inclusion = {"type": "sphere", "radius": 0.2, "bsdf": {"type": "diffuse"}}
    with_it = scene(gem=ply(box()), speck=inclusion)
    assert told(with_it) == ["other things reach into stones, and are not seen inside: speck in gem"]
    assert not told(with_it)  # once


def test_of_many_things_in_stones_some_are_named(variant_llvm_ad_rgb, ply):
    specks = {
        f"speck_{k}": {"type": "sphere", "center": [0.2 * k - 0.7, 0, 0], "radius": 0.05} for k in range(8)
    }
    (message,) = told(scene(gem=ply(box()), **specks))
    assert message.count(" in gem") == 5
    assert message.endswith(" and 3 more")


# ---- Lights that cannot be seen ------------------------------------------------------------------------

UNSEEN = (
    "lamp: point and directional lights light plain surfaces, but are not seen in or through stones; "
    "give them a size"
)


@pytest.mark.parametrize("kind", ["point", "spot", "directional"])
def test_lights_without_a_size_are_told_once(variant_llvm_ad_rgb, ply, kind):
    lamp = {"type": kind}
    if kind == "directional":
        lamp["direction"] = [0, 0, -1]
    else:
        lamp |= {"to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])}
    lit = scene(gem=ply(box()), lamp=lamp)
    assert told(lit) == [UNSEEN]
    mi.render(lit, spp=1)  # and no more
    assert not told(scene(lamp=lamp))  # where there are no stones


def test_a_point_light_lights_plain_surfaces(variant_llvm_ad_rgb, ply):
    # Radiance rho I / (pi r^2) straight below it (Lambert's law), as without the stone
    ground = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    lit = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "gem_path", "max_depth": 2},  # not by way of the stone
            "gem": ply(box(centre=(5, 0, 2))),
            "ground": {"type": "rectangle", "bsdf": ground},
            "lamp": {"type": "point", "position": [0, 0, 4], "intensity": {"type": "rgb", "value": 3.0}},
            "sensor": camera((0, 1e-3, 3), fov=0.01),
        }
    )
    with pytest.warns(GemrenderWarning, match="lamp: point and directional lights"):
        picture = np.array(mi.render(lit, spp=1))
    np.testing.assert_allclose(picture, 0.5 * 3 / (np.pi * 16), rtol=SINGLE)


# ---- Once a scene --------------------------------------------------------------------------------------


def test_a_scene_is_told_once_and_another_again(variant_llvm_ad_rgb, ply):
    stone = ply(turned(box()))
    for _ in range(2):
        wrong = scene(gem=stone)
        assert told(wrong) == [INWARDS]
        assert not told(wrong)
        mi.render(wrong, spp=1)


def test_a_changed_scene_is_checked_again(variant_llvm_ad_rgb, ply):
    two = scene(one=ply(box()), two=ply(box(SMALL, (3, 0, 0)), bsdf=QUARTZ))
    params = mi.traverse(two)
    for x, apart in ((3, True), (0, False), (3, True), (-2, True), (0.9, False)):
        params["two.vertex_positions"] = mi.Float(box(SMALL, (x, 0, 0))[0].astype(np.float32).ravel())
        params.update()
        if apart:
            check(two)
        else:
            assert "must not overlap" in refused(two)


def test_values_written_in_place_are_seen(variant_llvm_ad_rgb, ply):
    one = scene(gem=ply(box()))
    check(one)
    params = mi.traverse(one)
    faces = params["gem.faces"]
    dr.scatter(faces, mi.UInt32(1, 0), mi.UInt32(0, 1))
    params["gem.faces"] = faces
    params.update()
    assert told(one) == [SOME.format(1)]


def test_a_moved_light_is_checked_again(variant_llvm_ad_rgb, ply):
    lit = scene(gem=ply(box()), lamp={"type": "point", "position": [0, 0, 5]})
    assert told(lit) == [UNSEEN]
    params = mi.traverse(lit)
    params["lamp.position"] = mi.Point3f(0, 0, 0.5)
    params.update()
    assert refused(lit) == "light = 'lamp in gem': must be outside all stones"


def test_a_checked_scene_goes_when_it_is_dropped(variant_llvm_ad_rgb, ply):
    one = scene(gem=ply(box()))
    mi.render(one, spp=1)
    surface, integrator = weakref.ref(one.shapes()[0].bsdf()), weakref.ref(one.integrator())
    assert surface() is not None
    del one
    gc.collect()
    assert surface() is None
    assert integrator() is None


# ---- Instances -----------------------------------------------------------------------------------------


def test_a_stone_in_a_shape_group_is_refused(variant_llvm_ad_rgb, ply):
    group = {"type": "shapegroup", "inner": ply(box())}
    instance = {"type": "instance", "group": {"type": "ref", "id": "group"}}
    expected = "stone = 'inner': must stand by itself, not in a shape group with instances"
    assert refused(scene(group=group, instance=instance)) == expected


def test_instances_of_plain_shapes_are_seen_through_stones(variant_llvm_ad_rgb, ply):
    # As the same shapes without a group; the group's own have numbers that no shape of the scene has
    red = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.2, 0.2]}}
    sphere = {"type": "sphere", "radius": 0.4, "bsdf": red}
    there = [mi.ScalarTransform4f().translate(x) for x in ([2, 0, 0], [0, 2, 0])]
    stone = ply(box())
    plain = {f"ball_{k}": sphere | {"to_world": t} for k, t in enumerate(there)}
    reference = {"type": "ref", "id": "group"}
    instances = {f"i_{k}": {"type": "instance", "to_world": t, "g": reference} for k, t in enumerate(there)}
    pictures = [
        np.array(mi.render(scene(gem=stone, **others), spp=16))
        for others in (plain, {"group": {"type": "shapegroup", "inner": sphere}, **instances})
    ]
    assert pictures[0].std() > 0.05
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=0, atol=SINGLE)

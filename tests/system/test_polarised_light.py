"""Stokes vectors of light from stones, in polarised variants, as Mitsuba's integrator `stokes` shows them."""

from __future__ import annotations

import mitsuba as mi
import numpy as np
import pytest
from physics_tolerances import SINGLE_RADIANCE, Z
from test_birefringent_stones import FURNACE, mesh, plate

#: Pixels of a block, whose means are compared.
BLOCK = 4
#: Mean over the first channels of a block that is lit [radiance of the light].
LIT = 0.1
#: A square of 2 x 2, by a camera straight above, in light from everywhere.
FROM_ABOVE = {
    "light": FURNACE, "origin": [0, 0, 10], "up": [0, 1, 0], "type": "orthographic", "half_width": 1.0,
    "seeds": [1], "spp": 4,
}  # fmt: skip


def stokes(integrator, stone, *, light, origin, up, seeds, target=(0, 0, 0), spp=256, size=24, **camera):
    """Return Stokes vectors (seeds, size, size, 4) of light that comes to a camera."""
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    to_world = mi.ScalarTransform4f().look_at(origin, list(target), up)
    if camera["type"] == "orthographic":
        half_width = camera.pop("half_width")
        to_world = to_world.scale([half_width, half_width, 1])
    sampler = {"type": "multijitter", "sample_count": spp}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "stokes", "nested": integrator},
            "sensor": {**camera, "to_world": to_world, "film": film, "sampler": sampler},
            "light": light,
            "stone": stone,
        }
    )
    pictures = [np.array(mi.render(scene, seed=seed), dtype=np.float64) for seed in seeds]
    # Of each of the four, three channels that are alike in a monochrome variant, after the film's own
    return np.array(pictures)[..., -12::3]


def of_blocks(pictures):
    """Return the mean over each block, and its standard error by the pictures' scatter."""
    n, size, _, k = pictures.shape
    blocks = pictures.reshape(n, size // BLOCK, BLOCK, size // BLOCK, BLOCK, k).mean(axis=(2, 4))
    return blocks.mean(axis=0), blocks.std(axis=0, ddof=1) / np.sqrt(n)


def test_a_stone_of_one_index_polarises_light_as_mitsubas_dielectric_does(variant_llvm_ad_mono_polarized):
    # A glass cube, seen by its corner; circular light too, by total reflection
    turn = mi.ScalarTransform4f().rotate(list(np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)), 40).scale(0.8)
    found = []
    for integrator, surface in (
        ({"type": "gem_path"}, {"type": "gem_dielectric", "int_ior": 1.6}),
        (
            {"type": "path", "max_depth": 200, "rr_depth": 200},
            {"type": "dielectric", "int_ior": 1.6, "ext_ior": 1.0},
        ),
    ):
        stone = {"type": "cube", "face_normals": True, "to_world": turn, "bsdf": surface}
        seen = stokes(
            integrator,
            stone,
            light={"type": "gem_hemisphere"},
            origin=[3.2, 2.4, 4.5],
            up=[0, 0, 1],
            type="perspective",
            fov=28,
            seeds=range(8),
        )
        found.append(of_blocks(seen))
    (ours, our_error), (theirs, their_error) = found
    error = np.hypot(our_error, their_error) + SINGLE_RADIANCE
    # Of eight pictures the scatter itself is known to a quarter
    assert np.all(np.abs(ours - theirs) <= 1.5 * Z * error)
    polarised = np.sqrt(np.mean(theirs[..., 1:] ** 2, axis=(0, 1)))
    assert np.all(np.sqrt(np.mean(error[..., 1:] ** 2, axis=(0, 1))) < polarised / 4)


@pytest.mark.parametrize(("lit_from", "sign"), [(0.0, 1.0), (-4.0, -1.0)])
def test_calcites_two_images_are_polarised_across_each_other(variant_llvm_ad_mono_polarized, lit_from, sign):
    # With c at 45 degrees towards x the extraordinary image is moved by 0.11 of the thickness along x. Where
    # it alone is lit, light is polarised along x; where the ordinary one alone, across.
    middle = mi.ScalarTransform4f().translate([lit_from + 2.0, 0, -1.5]).scale([2.0, 4.0, 1.0])
    lamp = {
        "type": "rectangle",
        "to_world": middle,
        "emitter": {"type": "area", "radiance": {"type": "uniform", "value": 1.0}},
    }
    seen = stokes(
        {"type": "gem_path"},
        mesh(plate(), material="calcite", c_axis=[1.0, 0.0, 1.0]),
        light=lamp,
        origin=[-0.05, 0, 10],
        target=[-0.05, 0, 0],
        up=[0, 1, 0],
        type="orthographic",
        half_width=0.02,
        seeds=range(8),
        size=4,
    )
    (mean,), error = (x.reshape(-1, 4) for x in of_blocks(seen))
    assert mean[0] > LIT
    off = mean[1:] - [sign * mean[0], 0, 0]
    assert np.all(np.abs(off) <= 1.5 * Z * np.hypot(error[0, 1:], error[0, 0]))


def test_what_comes_through_a_filter_is_polarised_along_it(variant_llvm_ad_mono_polarized):
    seen = stokes(
        {"type": "gem_path", "analyser": [1.0, 0.0, 0.0]},
        mesh(plate(0.5), material="moissanite", c_axis=[0.3, -0.5, 0.8]),
        **FROM_ABOVE,
    )
    along = np.broadcast_to([1.0, 1.0, 0.0, 0.0], seen.shape)
    assert seen == pytest.approx(seen[..., :1] * along, abs=10 * SINGLE_RADIANCE)
    assert seen[..., 0].mean() == pytest.approx(0.5, abs=0.02)


def test_the_sky_beside_a_stone_is_unpolarised(variant_llvm_ad_mono_polarized):
    seen = stokes(
        {"type": "gem_path"},
        mesh(plate(0.1), material="diamond"),
        **FROM_ABOVE,
    )
    assert np.array_equal(seen[0, :4], np.broadcast_to([1.0, 0.0, 0.0, 0.0], seen[0, :4].shape))

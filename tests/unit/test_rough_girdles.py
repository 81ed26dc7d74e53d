"""Bruted girdles: where single rays go, by closed forms, and that no light is lost."""

from __future__ import annotations

import math
import sys

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from gemrender.cuts import load_stone
from gemrender.scene.loading import load_scene
from gemrender.scene.mesh import placed_mesh
from gemrender.scene.placing import place
from gemrender.stone import tessellate

N = 1 << 16
#: Five standard errors: with a fixed seed, a difference of no chance.
SIGMAS = 5.0
#: Single precision, of a direction.
SINGLE = 2e-6
#: A picture whose pixels were sampled evenly: the mean's own error is far less.
EVEN = 2e-3


def walk(d, eta, alpha, *, outside=True, n=(0.0, 0.0, 1.0), count=N):
    """Directions (3, count) that rays leave a rough surface in, and whether they are outside."""
    scattered = sys.modules["gemrender.plugins.rough"].scattered  # never imported: it belongs to the variant
    chance = mi.PCG32(count, 7)
    d = mi.Vector3f(d) + dr.zeros(mi.Float, count)
    live = dr.full(mi.Bool, True, count)
    w, out = scattered(
        d, mi.Vector3f(n), live & mi.Bool(outside), mi.Float(eta), mi.Float(alpha), chance, live
    )
    dr.eval(w, out)
    return np.array(w), np.array(out)


def fresnel(cos, eta):
    """Reflected share at a smooth surface, from the thinner side (Born & Wolf, section 1.5.2)."""
    t = math.sqrt(1 - (1 - cos * cos) / eta**2)
    s, p = (cos - eta * t) / (cos + eta * t), (eta * cos - t) / (eta * cos + t)
    return 0.5 * (s * s + p * p)


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
def test_without_a_difference_of_index_nothing_happens(variant_llvm_ad_rgb, alpha):
    d = np.array([0.6, 0.0, -0.8])
    w, out = walk(d, 1.0, alpha)
    assert not out.any()
    np.testing.assert_allclose(w, np.repeat(d[:, None], N, axis=1), atol=1e-3)


def test_next_to_smooth_it_is_fresnel_and_snell(variant_llvm_ad_rgb):
    cos, eta = 0.8, 2.4
    w, out = walk((0.6, 0.0, -cos), eta, 1e-4)
    share = fresnel(cos, eta)
    assert abs(out.mean() - share) < SIGMAS * math.sqrt(share / N)
    assert np.median(w[0][out]) == pytest.approx(0.6, abs=1e-3)
    assert np.median(w[0][~out]) == pytest.approx(0.6 / eta, abs=1e-3)


@pytest.mark.parametrize("outside", [True, False])
@pytest.mark.parametrize("alpha", [0.05, 0.4, 1.0])
def test_every_ray_comes_out_on_the_side_that_is_told(variant_llvm_ad_rgb, outside, alpha):
    n = np.array([0.48, 0.6, 0.64])
    d = np.array([0.36, -0.48, -0.8]) * (1 if outside else -1)
    w, out = walk(d, 2.4, alpha, outside=outside, n=n)
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=SINGLE)
    assert ((n @ w > 0) == out).all()


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
def test_diffuse_light_passes_both_ways_alike(variant_llvm_ad_rgb, alpha):
    """Of diffuse light the share that enters is n^2 times what leaves: reciprocity, all bounces together."""
    eta = 1.8
    u = np.array(mi.PCG32(N, 3).next_float32()), np.array(mi.PCG32(N, 5).next_float32())
    local = np.array(mi.warp.square_to_cosine_hemisphere(mi.Point2f(*map(mi.Float, u))))
    _, out = walk(-local, eta, alpha)
    entering = 1 - out.mean()
    _, out = walk(local, eta, alpha, outside=False)
    leaving = out.mean()
    assert abs(entering - eta**2 * leaving) < SIGMAS * math.sqrt((1 + eta**4) / 4 / N)


# ---- In pictures ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "pose"), [("single-cut-melee", "lying"), ("baguette-three", "table-up")])
def test_a_bruted_girdle_loses_no_light(variant_llvm_ad_rgb, name, pose):
    """A white furnace: radiance 1 everywhere, seen along the girdle."""
    placed = place([load_stone(name)], pose=pose, facing_deg=0, gap=1, azimuth_deg=-90, sizes=[1.0])[0]
    bsdf = {"type": "gem_dielectric", "girdle_alpha": 0.4, "axis": placed.rotation[:, 2].tolist()}
    to_world = mi.ScalarTransform4f().look_at([0, -9, 2], [0, 0, 0.4], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    scene = load_scene(
        {
            "type": "scene",
            "integrator": {"type": "gem_path"},
            "sky": {"type": "constant"},
            "stone": placed_mesh(placed, bsdf),
            "sensor": {"type": "perspective", "fov": 14, "to_world": to_world, "film": film},
        }
    )
    picture = np.array(mi.render(scene, spp=128))
    assert picture.mean() == pytest.approx(1, abs=EVEN)


def test_the_girdle_is_what_is_rough(variant_llvm_ad_rgb):
    stone = load_stone("emerald-market")
    placed = place([stone], pose="lying", facing_deg=30, gap=1, azimuth_deg=-90, sizes=[1.0])[0]
    bsdf = {"type": "gem_dielectric", "girdle_alpha": 0.3, "axis": placed.rotation[:, 2].tolist()}
    scene = load_scene({"type": "scene", "stone": placed_mesh(placed, bsdf), "sky": {"type": "constant"}})
    stones = sys.modules["gemrender.plugins.stones"].Stones(scene, mi.load_dict({"type": "independent"}))
    mesh = tessellate(stone)
    normals = mi.Vector3f((mesh.face_normals @ placed.rotation.T).T)
    ones = dr.full(mi.UInt32, 1, len(mesh.faces))
    rough = np.array(stones.roughness(ones, normals, mi.Bool(True)))
    level = np.array([stone.facets[k].side == "girdle" for k in mesh.face_facet])
    np.testing.assert_allclose(rough, np.where(level, 0.3, 0), atol=SINGLE)

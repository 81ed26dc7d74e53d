"""Light that stones throw around them: traced from the lights, and parted from what the eye follows."""

from __future__ import annotations

import math
import sys
import warnings

import mitsuba as mi
import numpy as np
import pytest
from test_photoreal_physics import FURNACE, STONES, prism, standing, surface

from gemrender.errors import GemrenderWarning
from gemrender.optics import load_material
from gemrender.render import passes as of_passes
from gemrender.render.backend import ensure_variant
from gemrender.render.passes import Passes
from gemrender.scene.mesh import placed_mesh
from gemrender.stone import tessellate

#: Pictures that tell the standard error of their mean. Student's t of 1 in 1000 for 5 degrees of freedom.
SEEDS, SURE = 6, 6.9


@pytest.fixture(autouse=True)
def variant():
    ensure_variant("llvm_ad_spectral")


@pytest.fixture
def all_traced(monkeypatch):
    """Whatever their size, lights count as small, the sky too."""
    monkeypatch.setattr(sys.modules["gemrender.plugins.emission"], "SMALL_SR", math.inf)


# ---- Scenes --------------------------------------------------------------------------------------------


def camera(kind, *, size=12, origin=(0.0, -6.0, 5.0)):
    to_world = mi.ScalarTransform4f().look_at(origin=list(origin), target=[0, 0, -0.4], up=[0, 0, 1])
    film = {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb"}
    if kind == "orthographic":
        return {"type": kind, "to_world": to_world.scale([1.6, 1.6, 1]), "film": film}
    lens = {"aperture_radius": 0.4, "focus_distance": 7.0} if kind == "thinlens" else {}
    return {"type": kind, "fov": 24, "to_world": to_world, "film": film, **lens}


def matt(reflectance):
    bsdf = {"type": "diffuse", "reflectance": {"type": "uniform", "value": reflectance}}
    return {"type": "twosided", "bsdf": bsdf}


def ground(reflectance, *, scale=4.0):
    below = float(STONES["inoue-3"].vertices[:, 2].min()) - 0.02
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([0, 0, below]).scale(scale),
        "bsdf": matt(reflectance),
    }


def stone(material="diamond", at=(0, 0, 0), scale=1.0, name="stone"):
    return placed_mesh(
        standing(tessellate(STONES["inoue-3"]), name, at=at, scale=scale), surface(material=material), name
    )


def lamp(half, power, *, direction=(0.5, -0.4, 1.0), distance=5.0):
    """A square light that faces the stone; the radiance times its area is its power."""
    origin = distance * np.array(direction) / np.linalg.norm(direction)
    to_world = mi.ScalarTransform4f().look_at(origin=origin.tolist(), target=[0, 0, 0], up=[0, 1, 0])
    radiance = {"type": "uniform", "value": power / (2 * half) ** 2}
    return {
        "type": "rectangle",
        "to_world": to_world.scale(half),
        "bsdf": matt(0.0),
        "emitter": {"type": "area", "radiance": radiance},
    }


def scene(sensor, **parts):
    return mi.load_dict({"type": "scene", "integrator": {"type": "gem_path"}, "sensor": sensor, **parts})


def pictures(loaded, spp, seeds=SEEDS, **options):
    """XYZ of pictures of several seeds, (seeds, pixels, 3)."""
    out = []
    for seed in range(seeds):
        passes = Passes(loaded, seed=seed, **options)
        passes.add(spp)
        out.append(passes.xyz.reshape(-1, 3).astype(np.float64))
    return np.array(out)


def off_by(values, expected=0.0):
    """How far the mean of values, one a seed, is off in its standard errors."""
    return (values.mean() - expected) / (values.std(ddof=1) / math.sqrt(len(values)))


# ---- Each path once ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "radius"), [("perspective", 0.5), ("thinlens", 1.0), ("orthographic", 1.0)])
def test_a_furnace_with_a_white_ground_is_white(all_traced, kind, radius):
    # Radiance 1 from everywhere, two stones and paper that absorb nothing: radiance 1 everywhere. What the
    # sky sends to the paper through the stones is all traced from the sky.
    loaded = scene(
        camera(kind),
        sky=FURNACE,
        ground=ground(1.0),
        one=stone("quartz"),
        other=stone(at=(1.6, 0.3, -0.2), scale=0.6, name="other"),
    )
    found = pictures(loaded, 64, filter_radius=radius)
    assert Passes(loaded)._caustics is not None
    luminance = found[..., 1].mean(axis=1)
    assert abs(off_by(luminance, 1.0)) <= SURE
    assert luminance.std(ddof=1) < 0.01
    # Neither brighter nor darker somewhere than elsewhere: in the rows, and at the edges of the picture
    side = found[..., 1].reshape(SEEDS, 12, 12)
    for part in (
        *np.moveaxis(side.mean(axis=2), 1, 0),
        side[:, :, 0].mean(axis=1),
        side[:, :, -1].mean(axis=1),
    ):
        assert abs(off_by(part, 1.0)) <= SURE


def test_the_ground_gets_the_light_that_paths_from_the_eye_find(all_traced):
    # A large lamp, which the eye finds too: the same mean on the ground, and in each part of the picture.
    loaded = scene(camera("perspective"), lamp=lamp(1.2, 20.0), ground=ground(0.6), stone=stone())
    traced, found = (pictures(loaded, spp, caustics=c) for spp, c in ((36, True), (100, False)))
    assert np.abs(traced - found).max() > 0
    shown = ~Passes(loaded).stone_pixels.ravel()
    for one, other in (
        (traced[:, shown].mean(axis=1), found[:, shown].mean(axis=1)),
        (traced.mean(axis=1), found.mean(axis=1)),
    ):
        for channel in range(3):
            assert abs(off_by(one[:, channel] - other[:, channel])) <= SURE
    blocks = (traced - found)[..., 1].reshape(SEEDS, 4, 3, 4, 3).mean(axis=(2, 4)).reshape(SEEDS, -1)
    off = blocks.mean(axis=0) / (blocks.std(axis=0, ddof=1) / math.sqrt(SEEDS))
    assert (np.abs(off) <= SURE).mean() >= 15 / 16


def test_a_small_light_is_traced_and_a_large_one_is_not():
    for half, traced in ((0.1, True), (2.0, False)):
        loaded = scene(camera("perspective"), lamp=lamp(half, 20.0), ground=ground(0.6), stone=stone())
        assert (Passes(loaded)._caustics is not None) == traced
        assert Passes(loaded, caustics=False)._caustics is None


@pytest.mark.parametrize("without", ["ground", "stone"])
def test_where_nothing_can_be_thrown_nothing_is_traced(without):
    parts = {"lamp": lamp(0.1, 20.0), "ground": ground(0.6), "stone": stone()}
    parts["lamp"]["bsdf"] = {"type": "null"}  # its own surface is no paper
    del parts[without]
    assert Passes(scene(camera("perspective"), **parts))._caustics is None


def test_lights_without_a_size_throw_what_small_ones_do():
    # A point is the limit of a small lamp, a direction that of a far one: the same caustics on the ground.
    d = np.array([0.5, -0.4, 1.0]) / math.sqrt(1.41)
    power = 20.0
    point = {
        "type": "point",
        "position": (5 * d).tolist(),
        "intensity": {"type": "uniform", "value": power},
    }
    sun = {"type": "directional", "direction": (-d).tolist(), "irradiance": {"type": "uniform", "value": 1.0}}
    far = lamp(1.0, 1e6, distance=1e3)
    emitter = {"type": "area", "radiance": {"type": "uniform", "value": power / (math.pi * 0.05**2)}}
    small = {"type": "sphere", "center": point["position"], "radius": 0.05, "bsdf": matt(0.0)}
    rooms = [{"ground": ground(0.6), "stone": stone()} for _ in range(4)]
    means = []
    for light, room in zip((point, small | {"emitter": emitter}, sun, far), rooms, strict=True):
        loaded = scene(camera("orthographic", origin=(0, 0.1, 6)), lamp=light, **room)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GemrenderWarning)  # that they are not seen in stones
            passes = Passes(loaded, seed=3)
            for _ in range(4):
                passes.add(64)
        shown = ~passes.stone_pixels
        means.append(passes.xyz[shown].mean(axis=0))
    np.testing.assert_allclose(means[0], means[1], rtol=0.02)
    np.testing.assert_allclose(means[2], means[3], rtol=0.02)


# ---- A prism -------------------------------------------------------------------------------------------


def refracted_2d(d, n, ratio):
    """Snell's law for a direction (2,), a normal (2,) against it, and the index before by that behind."""
    cos = -d @ n
    return ratio * d + (ratio * cos - math.sqrt(1 - ratio**2 * (1 - cos**2))) * n


def test_a_beam_through_a_prism_lands_with_its_colours(monkeypatch):
    # In the plane y = 0: through a slit, in at the left face, out at the right one, onto a far screen.
    apex, distance = math.radians(20.0), 12.0
    tan = math.tan(apex / 2)
    left, right = (np.array([s * math.cos(apex / 2), math.sin(apex / 2)]) for s in (-1, 1))
    d = np.array([math.cos(math.radians(17)), math.sin(math.radians(17))])
    entry = np.array([-0.5 * tan, -0.5])
    edges_nm = np.arange(420.0, 681.0, 20.0)
    middles = 0.5 * (edges_nm[1:] + edges_nm[:-1])
    lands = []
    for index in load_material("diamond").index(middles):
        inside = refracted_2d(d, left, 1 / index)
        t = -(entry @ right) / (inside @ right)  # the right face goes through the origin
        out = refracted_2d(inside, -right, index)
        exit_ = entry + t * inside
        lands.append(exit_[1] + (distance - exit_[0]) / out[0] * out[1])
    lands = np.array(lands)
    middle = float(lands.mean())

    half = 0.01  # of the slit
    across = np.array([-d[1], d[0]])
    blinds = {}
    for k, side in enumerate((-1, 1)):
        at = entry - 0.5 * d + side * (half + 8.0) * across
        to_world = mi.ScalarTransform4f().look_at(
            origin=[at[0], 0, at[1]], target=[at[0] - d[0], 0, at[1] - d[1]], up=[0, 1, 0]
        )
        blinds[f"blind_{k}"] = {
            "type": "rectangle", "to_world": to_world.scale([8.0, 8.0, 1]), "bsdf": matt(0.0),
        }  # fmt: skip
    facing = mi.ScalarTransform4f().look_at(origin=[distance, 0, middle], target=[0, 0, middle], up=[0, 0, 1])
    seen = mi.ScalarTransform4f().look_at(
        origin=[distance - 1, 0, middle], target=[distance, 0, middle], up=[0, 1, 0]
    )
    sensor = {
        "type": "orthographic",
        "to_world": seen.scale([0.3, 0.3, 1]),
        "film": {"type": "hdrfilm", "width": 64, "height": 2, "pixel_format": "rgb"},
    }
    loaded = scene(
        sensor,
        sun={
            "type": "directional",
            "direction": [d[0], 0, d[1]],
            "irradiance": {"type": "uniform", "value": 1},
        },
        prism=placed_mesh(standing(prism(apex)), surface(material="diamond")),
        screen={"type": "rectangle", "to_world": facing.scale(3), "bsdf": matt(1.0)},
        **blinds,
    )
    monkeypatch.setattr(of_passes, "_RAYS_A_SAMPLE", 256.0)
    with pytest.warns(GemrenderWarning, match="not seen in or through stones"):
        passes = Passes(loaded, seed=1, bins_nm=edges_nm)
    for _ in range(2):
        passes.add(64)
    found = passes.spectrum.astype(np.float64).sum(axis=0)  # (columns, bins)
    places = mi.Point2f(mi.Float((np.arange(64) + 0.5) / 64), mi.Float(0.5))
    ray, _ = passes.sensor.sample_ray(mi.Float(0), mi.Float(0.5), places, mi.Point2f(0.5))
    z = np.array(ray.o, dtype=np.float64)[2]
    centroids = (found * z[:, None]).sum(axis=0) / found.sum(axis=0)
    assert np.ptp(lands) > 20 * PLACE
    np.testing.assert_allclose(centroids, lands, rtol=0, atol=PLACE)


#: Where the light of a bin of 20 nm lands [girdle radii]: about a pixel of the picture.
PLACE = 0.01


# ---- One seed, one picture -----------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_caustics():
    found = []
    for seed in (5, 5, 6):
        loaded = scene(camera("perspective"), lamp=lamp(0.1, 20.0), ground=ground(0.6), stone=stone())
        passes = Passes(loaded, seed=seed, filter_radius=1.0, bins_nm=[400, 500, 600, 700])
        for _ in range(2):
            passes.add(64)
        found.append((passes.xyz, passes.spectrum))
    for one, same, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, same)
        assert np.abs(one - other).max() > 0

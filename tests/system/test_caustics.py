"""Light that stones throw around them: traced from the lights, and parted from what the eye follows."""

from __future__ import annotations

import math
import sys

import mitsuba as mi
import numpy as np
import pytest
from test_photoreal_physics import FURNACE, INDEX, PATH, STOCK, STONES, prism, standing, surface

from gemrender.errors import GemrenderWarning
from gemrender.optics import load_material
from gemrender.render.backend import ensure_variant
from gemrender.render.passes import Passes
from gemrender.scene.mesh import placed_mesh
from gemrender.stone import tessellate

#: Pictures of seeds of their own that tell the standard error of a mean.
SEEDS = 8
#: Standard errors that a mean may be off by, of so many pictures.
SIGMAS = 3.0
#: The same where some dozen means are looked at: Student's t of 1 in 1000, of seven degrees of freedom.
SURE = 5.4
#: Standard errors of a mean of rays that are drawn evenly, as if they were not: a chance of 1 in 1000.
OF_RAYS = 3.3
#: What Mitsuba's spectral variants make of a flat radiance of 1, above it.
FLAT = 1.5e-3
#: Single precision, of places by their distance, and of a light's power.
SINGLE = 2e-5
#: Flux by density of rays beside radiance, at grazing angles too, where single precision ends.
BY_ETENDUE = 2e-3
#: A derivative by differences over a hundredth of the distance.
BY_DIFFERENCES = 2e-3


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


def stone(material="diamond", at=(0, 0, 0), scale=1.0, name="stone", **more):
    placed = standing(tessellate(STONES["inoue-3"]), name, at=at, scale=scale)
    return placed_mesh(placed, surface(material=material, **more), name)


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


def standard_error(values):
    """Of the mean of values, one a seed."""
    return float(values.std(ddof=1) / math.sqrt(len(values)))


# ---- From lights, and to the camera ---------------------------------------------------------------------


def flux(light, *stones):
    """Flux that the rays of a light to stones, spheres here, carry: its mean and standard error, and rays."""
    shapes = {f"stone_{k}": s | {"bsdf": surface()} for k, s in enumerate(stones)}
    loaded = mi.load_dict({"type": "scene", "light": light, **shapes})
    found = [s for s in loaded.shapes() if type(s.bsdf()).__name__ == "GemDielectric"]
    emission = sys.modules["gemrender.plugins.emission"].Emission(loaded, found)
    chance = mi.PCG32(1 << 14, 1)
    ray, weight, density = emission.sample([chance.next_float32() for _ in range(6)], mi.Spectrum(550.0))
    values = np.array(weight[0], dtype=np.float64)
    return values.mean(), values.std() / math.sqrt(values.size), ray, values * np.array(density)


#: A ball, and radius of the sphere that is aimed at for it: about its box, and a little larger.
BALL = {"type": "sphere", "radius": 0.5}
AIMED = 0.5 * math.sqrt(3) * 1.001


@pytest.mark.parametrize("kind", ["point", "directional", "constant", "area"])
def test_the_light_that_is_sent_is_what_the_light_gives(all_traced, kind):
    value = {"type": "uniform", "value": 2.0}
    cos = math.sqrt(1 - (AIMED / 4) ** 2)  # of the sphere's rim, from 4 away
    side, distance = 0.02, 4.0
    square = mi.ScalarTransform4f().look_at([0, 0, distance], [0, 0, 0], [0, 1, 0]).scale(side / 2)
    light, expected = {
        "point": ({"type": kind, "position": [0, 0, 4.0], "intensity": value}, 4 * math.pi * (1 - cos)),
        "directional": (
            {"type": kind, "direction": [1.0, 2, -1], "irradiance": value},
            2 * math.pi * AIMED**2,
        ),
        "constant": ({"type": kind, "radiance": value}, 2 * 4 * math.pi**2 * AIMED**2),
        # Lambert's law within the cone: radiance times area times pi sin^2
        "area": (
            {"type": "rectangle", "to_world": square, "emitter": {"type": kind, "radiance": value}},
            2 * side**2 * math.pi * (1 - cos**2),
        ),
    }[kind]
    mean, error, ray, radiance = flux(light, BALL)
    assert abs(mean / expected - 1) <= FLAT + SINGLE + OF_RAYS * error / expected
    assert error < 0.03 * expected
    # Flux by density of rays is radiance, of which points and directions have any amount
    if kind in ("constant", "area"):
        np.testing.assert_allclose(radiance, 2.0, rtol=BY_ETENDUE)
    else:
        assert (radiance > 1e30).all()
    o, d = np.array(ray.o, dtype=np.float64), np.array(ray.d, dtype=np.float64)
    assert (np.linalg.norm(np.cross(o, d, axis=0), axis=0) <= AIMED + SINGLE * np.abs(o).max()).all()


def test_the_light_to_stones_behind_each_other_is_sent_once():
    light = {"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "uniform", "value": 1.0}}
    small = {"type": "sphere", "radius": 0.3, "center": [0.1, 0, -3]}
    apart = {"type": "sphere", "radius": 0.3, "center": [5, 0, 0]}
    mean, error, *_ = flux(light, BALL, small, apart)
    expected = math.pi * AIMED**2 * (1 + 0.6**2)
    assert abs(mean / expected - 1) <= FLAT + OF_RAYS * error / expected


@pytest.mark.parametrize("kind", ["perspective", "thinlens", "orthographic"])
def test_a_place_is_found_where_the_camera_sees_it(kind):
    sensor = mi.load_dict(camera(kind))
    projection = sys.modules["gemrender.plugins.projection"].Projection(sensor)
    rng = np.random.default_rng(5)
    p = rng.uniform([-1.5, -1.5, -1], [1.5, 1.5, 0.5], (64, 3))
    lens = mi.Point2f(*rng.uniform(size=(2, 64)).astype(np.float32))
    film, d, distance, importance = projection.connect(mi.Point3f(p.T), lens)
    ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), film, lens)
    o, along = (np.array(x, dtype=np.float64) + np.zeros((3, 64)) for x in (ray.o, ray.d))
    beside = np.linalg.norm(np.cross((p.T - o).T, along.T), axis=1)
    np.testing.assert_allclose(beside, 0, atol=SINGLE * 10)
    np.testing.assert_allclose(np.array(d) + np.zeros((3, 64)), -along, atol=SINGLE)
    # What is counted: the film's share that an area across the ray fills
    step = 0.01 * float(np.mean(np.array(distance)))
    across = np.cross(along.T, [0, 0, 1.0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    sides = []
    for direction in (across, np.cross(along.T, across)):
        ends = [projection.connect(mi.Point3f((p + s * step * direction).T), lens)[0] for s in (-1, 1)]
        sides.append((np.array(ends[1], dtype=np.float64) - np.array(ends[0])) / (2 * step))
    share = np.abs(sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0])
    np.testing.assert_allclose(np.array(importance) + np.zeros(64), share, rtol=BY_DIFFERENCES)


# ---- Each path once ------------------------------------------------------------------------------------


def test_a_furnace_with_a_white_ground_is_white(all_traced, monkeypatch):
    monkeypatch.setattr(sys.modules["gemrender.plugins.caustics"], "RAYS_A_SAMPLE", 16.0)
    # Radiance 1 from everywhere, and nothing absorbs: two stones, one of a ground girdle, paper, a mirror and
    # a ball of glass. Radiance 1 everywhere: what the sky sends to the paper through the stones is all traced
    # from the sky.
    mirror = {"type": "conductor", "material": "none"}
    glass = {"type": "dielectric", "int_ior": 1.52, "ext_ior": 1.0}
    loaded = scene(
        camera("thinlens"),
        sky=FURNACE,
        ground=ground(1.0),
        one=stone("quartz"),
        other=stone(at=(1.6, 0.3, -0.2), scale=0.6, name="other", girdle_alpha=0.4),
        mirror={"type": "sphere", "center": [-1.3, 0.9, -0.2], "radius": 0.4, "bsdf": mirror},
        glass={"type": "sphere", "center": [-1.2, -0.8, -0.3], "radius": 0.3, "bsdf": glass},
    )
    found = pictures(loaded, 32, filter_radius=1.0)[..., 1]
    assert Passes(loaded).caustics is not None
    luminance = found.mean(axis=1)
    assert abs(luminance.mean() - 1) <= FLAT + SIGMAS * standard_error(luminance)
    assert standard_error(luminance) < 0.003
    # Neither brighter nor darker somewhere than elsewhere: in the rows, and at the edges of the picture
    side = found.reshape(SEEDS, 12, 12)
    for part in (
        *np.moveaxis(side.mean(axis=2), 1, 0),
        side[:, :, 0].mean(axis=1),
        side[:, :, -1].mean(axis=1),
    ):
        assert abs(part.mean() - 1) <= FLAT + SURE * standard_error(part)


def test_the_ground_gets_the_light_that_paths_from_the_eye_find(all_traced):
    # A large lamp, which the eye finds too: the same mean on the ground, and in each part of the picture.
    loaded = scene(
        camera("perspective"), lamp=lamp(1.2, 20.0), ground=ground(0.6), stone=stone(girdle_alpha=0.3)
    )
    traced, found = (pictures(loaded, spp, caustics=c) for spp, c in ((64, True), (200, False)))
    assert np.abs(traced - found).max() > 0
    shown = ~Passes(loaded).stone_pixels.ravel()
    for channel in range(3):
        for where in (shown, slice(None)):
            one, other = (x[:, where, channel].mean(axis=1) for x in (traced, found))
            error = math.hypot(standard_error(one), standard_error(other))
            assert abs(one.mean() - other.mean()) <= SIGMAS * error
            assert error < 0.01 * other.mean()
    blocks = (traced - found)[..., 1].reshape(SEEDS, 4, 3, 4, 3).mean(axis=(2, 4)).reshape(SEEDS, -1)
    off = blocks.mean(axis=0) / (blocks.std(axis=0, ddof=1) / math.sqrt(SEEDS))
    assert (np.abs(off) <= SURE).all()


def test_the_ground_gets_the_light_that_mitsubas_path_finds():
    """A stone of one index under a lamp that `path` meets often enough: nothing of ours but the scene."""
    placed = standing(tessellate(STONES["inoue-3"]), "stone")
    parts = {"lamp": lamp(1.2, 20.0), "ground": ground(0.6)}
    sensor = camera("perspective")
    ours = scene(sensor, **parts, stone=placed_mesh(placed, surface(int_ior=INDEX), "stone"))
    assert Passes(ours).caustics is not None
    sensor["film"]["pixel_format"] = "xyz"
    stock = scene(sensor, **parts, stone=placed_mesh(placed, STOCK, "stone"), integrator=PATH)
    shown = ~Passes(ours).stone_pixels
    one = pictures(ours, 64)[:, shown.ravel(), 1].mean(axis=1)
    rendered = (np.array(mi.render(stock, seed=seed, spp=512))[..., 1] for seed in range(SEEDS))
    other = np.array([picture[shown].mean() for picture in rendered])
    error = math.hypot(standard_error(one), standard_error(other))
    assert abs(one.mean() - other.mean()) <= FLAT * other.mean() + SIGMAS * error
    assert error < 0.003 * other.mean()


def test_a_small_light_is_traced_and_a_large_one_is_not():
    for half, traced in ((0.1, True), (2.0, False)):
        loaded = scene(camera("perspective"), lamp=lamp(half, 20.0), ground=ground(0.6), stone=stone())
        assert (Passes(loaded).caustics is not None) == traced
        assert Passes(loaded, caustics=False).caustics is None


@pytest.mark.parametrize("without", ["ground", "stone", "light on it"])
def test_where_nothing_can_be_thrown_nothing_is_traced(without):
    parts = {"lamp": lamp(0.1, 20.0), "ground": ground(0.6), "stone": stone()}
    parts["lamp"]["bsdf"] = {"type": "null"}  # its own surface is no paper
    if without == "light on it":
        parts |= {"lamp": lamp(0.1, 20.0) | {"bsdf": matt(0.0)}, "ground": ground(0.0)}
    else:
        del parts[without]
    assert Passes(scene(camera("perspective"), **parts)).caustics is None


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
    monkeypatch.setattr(sys.modules["gemrender.plugins.caustics"], "RAYS_A_SAMPLE", 256.0)
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
    loaded = scene(
        camera("perspective"), lamp=lamp(0.1, 20.0), ground=ground(0.6), stone=stone(girdle_alpha=0.3)
    )
    found = []
    for seed in (5, 5, 6):
        passes = Passes(loaded, seed=seed)
        for _ in range(2):
            passes.add(36)
        found.append(passes.xyz)
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found[0], found[1])
    assert np.abs(found[0] - found[2]).max() > 0


def test_an_interrupted_pass_counts_nothing(monkeypatch):
    """The eye's samples of a pass are done when Ctrl-C comes; its rays from lights are not."""
    loaded = scene(camera("perspective"), lamp=lamp(0.1, 20.0), ground=ground(0.6), stone=stone())
    whole, cut = Passes(loaded, seed=3), Passes(loaded, seed=3)
    for passes in (whole, cut):
        passes.add(4)
    with monkeypatch.context() as patch:
        patch.setattr(type(cut.caustics), "trace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            cut.add(4)
    assert cut.samples == 4
    for passes in (whole, cut):
        passes.add(4)
    np.testing.assert_array_equal(cut.xyz, whole.xyz)


def interrupted(*_):
    raise KeyboardInterrupt


def test_light_that_nothing_takes_away_ends_by_chance():
    """In a closed box of white walls no ray loses light or gets out: without a chance to end it would not."""
    box = {"type": "cube", "to_world": mi.ScalarTransform4f().scale(8.0), "bsdf": matt(1.0)}
    light = {"type": "point", "position": [2, -1, 4], "intensity": {"type": "uniform", "value": 1.0}}
    loaded = scene(camera("perspective", size=2), box=box, light=light, stone=stone())
    with pytest.warns(GemrenderWarning, match="give them a size"):
        found = pictures(loaded, 1, seeds=1)
    assert np.isfinite(found).all()
    assert found.min() > 0

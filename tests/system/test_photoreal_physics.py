"""Known physics through `gem_path` and `gem_dielectric`: furnaces, prisms, slabs, Mitsuba's own `path`."""

from __future__ import annotations

import math
import sys
from statistics import NormalDist

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from physics_tolerances import (
    DEVIATION,
    FURNACE_DEFICIT,
    OTHER_WAY,
    SAME_WAY,
    SIGNIFICANCE,
    SINGLE_RADIANCE,
    SLAB,
    THREE_SIGMA,
    WHITE,
)
from solids import bent_stone, cleft_heart, star_prism
from thorough import chosen

from gemrender import load_stone
from gemrender.optics import load_material
from gemrender.optics.fresnel import reflectance
from gemrender.render.passes import Passes
from gemrender.scene.mesh import OFFSET_ATTRIBUTES, mesh_solid, placed_mesh
from gemrender.scene.placing import Placed
from gemrender.stone import ConvexSolid, Facet, Stone, side_of, tessellate

#: Light of radiance 1 from everywhere (a plain number would be a multiple of daylight in spectral variants).
FURNACE = {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}}
INDEX = 2.4173
STONES = {
    "inoue-1": load_stone("inoue-1"),
    "inoue-2": load_stone("inoue-2"),
    "inoue-3": load_stone("inoue-3"),
    # The first is not convex, and left to Embree; of the other the girdle is not round.
    "hollow": bent_stone(0.003, name="hollow"),
    "oval": bent_stone(0, name="oval", stretched=1.05),
    # With edges that go in: light leaves them and comes in again.
    "star": star_prism(),
    "heart": cleft_heart(),
}


# ---- Scenes --------------------------------------------------------------------------------------------


def film(width, height):
    return {
        "type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
        "component_format": "float32", "rfilter": {"type": "box"},
    }  # fmt: skip


def seen_from_above(half_width, width, height):
    """A sensor of parallel rays."""
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0])
    return {
        "type": "orthographic",
        "to_world": to_world.scale([half_width, half_width, 1]),
        "film": film(width, height),
    }


def standing(mesh, name="stone", *, at=(0, 0, 0), scale=1.0, rotation=None):
    rotation = np.eye(3) if rotation is None else rotation
    return Placed(name=name, mesh=mesh, rotation=rotation, scale=scale, shift=np.asarray(at, dtype=float))


def surface(**properties):
    return {"type": "gem_dielectric", **properties}


def furnace(stone, bsdf, **more):
    """A stone that fills the view, in light of radiance 1 from everywhere."""
    scene = {
        "type": "scene",
        "integrator": {"type": "gem_path"},
        "light": FURNACE,
        "stone": placed_mesh(standing(tessellate(stone)), bsdf),
        "sensor": seen_from_above(0.6, 32, 32),
    }
    return mi.load_dict(scene | more)


def polyhedron(corners, polygons):
    """A convex body of planes, as the mesh of a stone."""
    planes = []
    for polygon in polygons:
        points = np.array([corners[i] for i in polygon], dtype=float)
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        normal /= np.linalg.norm(normal)
        planes.append([*normal, normal @ points[0]])
    solid = ConvexSolid(planes=np.array(planes), facet=np.arange(len(planes)))
    facets = tuple(Facet(f"f_{k}", "f", side_of(plane[2])) for k, plane in enumerate(planes))
    return tessellate(Stone(solid=solid, facets=facets))


def by_ray_tracer(shape):
    """The same shape without what it carries of its planes: left to Embree."""
    shape.remove_attribute(OFFSET_ATTRIBUTES[0])
    assert mesh_solid(shape) is None
    return shape


WAYS = {"planes": lambda shape: shape, "embree": by_ray_tracer}


# ---- Measuring -----------------------------------------------------------------------------------------


def traced(scene, ray, seed):
    """Radiance along rays, (channels, n)."""
    n = dr.width(ray)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, n)
    radiance, _, _ = scene.integrator().sample(scene, sampler, ray)
    return np.array(radiance, dtype=np.float64).reshape(-1, n)


def rays_of(*, origin, direction, nm=None):
    """Rays from points (n, 3) in directions (n, 3) of wavelengths (n,) [nm]."""
    ray = dr.zeros(mi.RayDifferential3f, len(origin))
    ray.o = mi.Point3f(*(mi.Float(x.astype(np.float32)) for x in np.transpose(origin)))
    ray.d = mi.Vector3f(*(mi.Float(x.astype(np.float32)) for x in np.transpose(direction)))
    ray.maxt = dr.largest(mi.Float)
    if nm is not None:
        ray.wavelengths = mi.Spectrum(mi.Float(np.asarray(nm, dtype=np.float32)))
    return ray


def camera_rays(scene, spp, seed, nm=None):
    """Rays of the scene's sensor, spread over its pixels, `spp` one after the other for each."""
    sensor = scene.sensors()[0]
    width, height = sensor.film().size()
    n = int(width * height) * spp
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, n)
    pixel = dr.arange(mi.UInt32, n) // spp
    corner = mi.Point2f(pixel % int(width), pixel // int(width))
    place = (corner + sampler.next_2d()) / mi.Point2f(width, height)
    ray, _ = sensor.sample_ray_differential(0.0, 0.5, place, mi.Point2f(0.5))
    if nm is not None:
        ray.wavelengths = mi.Spectrum(nm)
    return ray


def pixels(scene, spp, seed, nm=None):
    """Radiance of each pixel, and its standard error, (channels, pixels) each."""
    samples = traced(scene, camera_rays(scene, spp, seed, nm), seed + 1)
    samples = samples.reshape(len(samples), -1, spp)
    return samples.mean(axis=2), samples.std(axis=2, ddof=1) / math.sqrt(spp)


def off_by(mean, error, expected=1.0):
    """How far the mean over all pixels is off, in its standard errors; also what these are."""
    of_mean = math.sqrt(float((np.asarray(error, dtype=np.float64) ** 2).sum())) / np.size(error)
    return (float(np.mean(mean)) - expected) / of_mean, of_mean


def assert_same_picture(a, b):
    """Two pictures (mean, error): Z-test of each pixel and channel, and of the mean over all.

    By Sidak's correction the chance that any of n pixels is off by more than z is `SIGNIFICANCE`.
    """
    difference, error = a[0] - b[0], np.hypot(a[1], b[1])
    noisy = error > SINGLE_RADIANCE
    np.testing.assert_allclose(difference[~noisy], 0, rtol=0, atol=SINGLE_RADIANCE)
    assert noisy.mean() > 0.3
    single = 1 - (1 - SIGNIFICANCE) ** (1 / noisy.sum())
    most = NormalDist().inv_cdf(1 - single / 2)
    assert np.abs(difference[noisy] / error[noisy]).max() <= most
    for channel, its_error in zip(difference, error, strict=True):
        assert abs(off_by(channel, its_error, 0)[0]) <= THREE_SIGMA


def kernels(work):
    """Hashes of the kernels that some work launches."""
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        work()
        return {k["hash"] for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT}


# ---- White furnace -------------------------------------------------------------------------------------


#: Samples a pixel of furnaces of 32 x 32: a million, and a quarter of that, of which the noise is twice as
#: large: 1e-4 of the light, far less than a picture shows.
MILLION, QUARTER = 1024, 256
FURNACES = [
    *[("inoue-1", of, nm) for of in ("diamond", "quartz") for nm in (400, 550, 700)],
    # Rutile without a cut is below.
    *[("inoue-3", of, nm) for of in ("diamond", "rutile") for nm in (400, 550, 700)],
    *[("heart", "quartz", 550), ("oval", "cubic zirconia", 400), ("star", "quartz", 550)],
    ("hollow", "diamond", 550),
]


@pytest.mark.parametrize(
    ("stone", "material", "nm", "samples"),
    [
        *chosen([(*of, MILLION) for of in FURNACES], [("inoue-1", "quartz", 700, MILLION)]),
        *[("inoue-1", "diamond", 400, QUARTER), ("heart", "quartz", 550, QUARTER)],
        ("hollow", "diamond", 550, QUARTER),
    ],
)
def test_stone_cannot_be_seen_in_a_furnace(variant_llvm_ad_spectral, stone, material, nm, samples):
    # No absorption and light of radiance 1 from everywhere: radiance 1, whatever way it takes. Its only noise
    # is Russian roulette.
    passes = Passes(furnace(STONES[stone], surface(material=material)), seed=1)
    off, of_mean = off_by(*passes.radiance_at(nm, samples))
    assert of_mean < 1e-4 * math.sqrt(MILLION / samples)
    assert abs(off) <= THREE_SIGMA


def test_furnace_has_no_bias_at_long_paths(variant_llvm_ad_spectral):
    # Sample 2 of rutile keeps 0.2 % of the light for more than 100 segments: what a cut there takes away is
    # seen, and without a cut nothing is missing.
    for max_depth, samples, complete in ((100, 128, False), (-1, 256, True)):
        integrator = {"type": "gem_path", "max_depth": max_depth}
        scene = furnace(STONES["inoue-2"], surface(material="rutile"), integrator=integrator)
        off, of_mean = off_by(*Passes(scene, seed=2).radiance_at(589.3, samples))
        assert of_mean < 1e-4
        if complete:
            assert abs(off) <= THREE_SIGMA
        else:
            assert off < -10


@pytest.mark.parametrize(("way", "birefringence", "samples"), [("branches", False, 256), ("modes", True, 64)])
def test_late_roulette_has_no_bias(variant_llvm_ad_spectral, monkeypatch, way, birefringence, samples):
    # From a late segment on paths end by chance whatever they carry: more noise, the same mean.
    scene = furnace(STONES["inoue-3"], surface(material="rutile", birefringence=birefringence))
    _, usual = off_by(*Passes(scene, seed=3).radiance_at(589.3, samples))
    module = sys.modules[f"gemrender.plugins.{way}"]
    monkeypatch.setattr(module, "LATE", 8)
    off, of_mean = off_by(*Passes(scene, seed=3).radiance_at(589.3, samples))
    assert of_mean > 1.1 * usual
    assert abs(off) <= THREE_SIGMA


def test_furnace_is_white_where_wavelengths_part(variant_llvm_ad_spectral):
    # One wavelength goes on for all four: equal-energy light of Y = 1 stays X = Y = Z = 1.
    passes = Passes(furnace(STONES["inoue-3"], surface(material="diamond")), seed=4)
    passes.add(64)
    xyz = passes.xyz.reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(xyz, 1, rtol=0, atol=WHITE)


@pytest.mark.parametrize("dispersion", chosen([True, False], [True]))
def test_furnace_is_white_in_rgb(variant_llvm_ad_rgb, dispersion):
    mean, error = pixels(furnace(STONES["inoue-1"], surface(dispersion=dispersion)), 1024, seed=5)
    assert len(mean) == 3
    for channel, its_error in zip(mean, error, strict=True):
        assert abs(off_by(channel, its_error)[0]) <= THREE_SIGMA
        assert channel.mean() == pytest.approx(1, abs=WHITE)


@pytest.mark.parametrize("name", chosen(["inoue-1", "inoue-3"], ["inoue-3"]))
def test_furnace_by_mitsubas_path(variant_llvm_ad_mono, name):
    # Mitsuba's integrator with the same surface, a wavelength after the other by one kernel. It starts each
    # segment 2e-4 off the surface, and a few leave through an edge unrefracted: what those cost is known.
    integrator = {"type": "path", "max_depth": -1, "rr_depth": 5}
    scene = furnace(STONES[name], surface(material="diamond"), integrator=integrator)
    params = mi.traverse(scene)
    (key,) = (key for key in params.keys() if key.endswith(".wavelength"))  # noqa: SIM118 (no mapping)
    used = []

    def measure(nm):
        params[key] = mi.Float(nm)
        params.update()
        off, of_mean = off_by(*pixels(scene, 1024, seed=6))
        assert -THREE_SIGMA * of_mean - FURNACE_DEFICIT <= off * of_mean <= THREE_SIGMA * of_mean, nm

    for nm in (400.0, 550.0, 700.0):
        used.append(kernels(lambda nm=nm: measure(nm)))
    assert used[0]
    assert used[1] == used[0]
    assert used[2] == used[0]


# ---- Prism ---------------------------------------------------------------------------------------------

APEX = math.radians(20.0)
#: Lines of mercury, hydrogen, helium and sodium [nm].
LINES_NM = np.array([404.7, 435.8, 486.1, 546.1, 587.6, 589.3, 656.3, 706.5])


def prism(apex):
    """A prism, its refracting edge along y through the origin, its base at z = -1."""
    x = math.tan(apex / 2)
    corners = [(0, -1, 0), (0, 1, 0), (-x, -1, -1), (-x, 1, -1), (x, -1, -1), (x, 1, -1)]
    return polyhedron(corners, [(0, 1, 3, 2), (0, 4, 5, 1), (2, 3, 5, 4), (0, 2, 4), (1, 5, 3)])


def far_lamp(direction, half_angle, distance):
    """A far rectangle whose radiance grows across it, and where its places are: radiance 4 u."""
    to_world = (
        mi.ScalarTransform4f()
        .look_at(origin=list(distance * direction), target=[0, 0, 0], up=[0, 1, 0])
        .scale(distance * math.tan(half_angle))
    )
    # Texels at u = 1/4 and 3/4, and linear between them
    ramp = mi.TensorXf(np.array([[1.0, 3.0], [1.0, 3.0]], dtype=np.float32)[..., None])
    radiance = {
        "type": "bitmap", "data": ramp, "raw": True, "filter_type": "bilinear", "wrap_mode": "clamp",
        "format": "variant",
    }  # fmt: skip
    lamp = {
        "type": "rectangle",
        "to_world": to_world,
        "emitter": {"type": "area", "radiance": radiance},
    }
    matrix = np.array(to_world.matrix, dtype=np.float64)

    def place(radiance):
        u = radiance / 4
        assert ((u > 0.26) & (u < 0.74)).all()
        return np.array([matrix @ [2 * x - 1, 0, 0, 1] for x in u])[:, :3]

    return lamp, place


def elevations(directions):
    """Angle above the horizon of directions in the plane y = 0 [rad]."""
    return np.arctan2(directions[:, 2], directions[:, 0])


@pytest.mark.parametrize("way", WAYS)
def test_prism_deviates_each_wavelength_by_its_index(variant_llvm_ad_spectral, way):
    # At minimum deviation D the ray goes through parallel to the base, sin((A + D) / 2) = n sin(A / 2).
    # Where it goes is told by a far lamp whose radiance grows across it; of it, T T is left.
    index = load_material("diamond").index(LINES_NM)
    incidence = np.arcsin(index * math.sin(APEX / 2))
    deviation = 2 * incidence - APEX
    # Enters upwards, leaves downwards
    d = np.stack([np.cos(deviation / 2), np.zeros(8), np.sin(deviation / 2)], axis=1)
    entry = np.array([-0.5 * math.tan(APEX / 2), 0.01, -0.5])
    middle = -float(deviation.mean()) / 2
    lamp, place = far_lamp(np.array([math.cos(middle), 0, math.sin(middle)]), math.radians(3), 1e5)
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "gem_path", "max_depth": 3},  # straight through
            "stone": WAYS[way](placed_mesh(standing(prism(APEX)), surface(material="diamond"))),
            "lamp": lamp,
        }
    )
    ray = rays_of(origin=entry - 2 * d, direction=d, nm=LINES_NM)
    radiance = traced(scene, ray, seed=7).mean(axis=0)
    transmitted = np.array(
        [(1 - float(reflectance(math.cos(i), n))) ** 2 for i, n in zip(incidence, index, strict=True)]
    )
    measured = deviation / 2 - elevations(place(radiance / transmitted))
    np.testing.assert_allclose(measured, deviation, rtol=0, atol=DEVIATION)
    assert np.ptp(deviation) > 100 * DEVIATION  # the wavelengths are told apart


# ---- Against Mitsuba's own ``path`` --------------------------------------------------------------------


def colour(r, g, b):
    return {"type": "rgb", "value": [r, g, b]} if mi.is_rgb else {"type": "uniform", "value": g}


def room(bsdf, integrator):
    """A stone just above a coloured ground, under a lamp and a sky."""
    stone = STONES["inoue-3"]
    below = float(stone.vertices[:, 2].min()) - 0.05
    to_world = mi.ScalarTransform4f()
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": integrator,
            "stone": placed_mesh(standing(tessellate(stone)), bsdf),
            "sky": {"type": "constant", "radiance": colour(0.3, 0.4, 0.6)},
            "ground": {
                "type": "rectangle",
                "to_world": to_world.translate([0, 0, below]).scale(4),
                "bsdf": {"type": "diffuse", "reflectance": colour(0.7, 0.5, 0.2)},
            },
            "lamp": {
                "type": "rectangle",
                "to_world": to_world.look_at(origin=[1.5, -1, 3], target=[0, 0, 0], up=[0, 1, 0]).scale(1.2),
                "emitter": {"type": "area", "radiance": colour(2.5, 2.0, 1.5)},
            },
            "sensor": {
                "type": "perspective",
                "fov": 18,
                "to_world": to_world.look_at(origin=[0, -6, 6], target=[0, 0, -0.1], up=[0, 0, 1]),
                "film": film(32, 32),
            },
        }
    )


STOCK = {"type": "dielectric", "int_ior": INDEX, "ext_ior": 1.0}
#: Roulette by Mitsuba's rule begins later than any path ends.
PATH = {"type": "path", "max_depth": -1, "rr_depth": 1000}


@pytest.fixture(params=chosen(["variant_llvm_ad_mono", "variant_llvm_ad_rgb"], ["variant_llvm_ad_rgb"]))
def variant(request):
    """A variant in which Mitsuba's dielectric has one index and light all its channels."""
    return request.getfixturevalue(request.param)


def test_without_dispersion_gem_path_renders_what_path_does(variant):
    ours = room(surface(int_ior=INDEX), {"type": "gem_path"})
    stock = room(STOCK, PATH)
    assert_same_picture(pixels(ours, 512, seed=8), pixels(stock, 512, seed=18))


def test_dispersion_switched_off_is_one_index(variant_llvm_ad_rgb):
    # The index at 589.3 nm for every wavelength: along the same rays, with the same random numbers, nothing
    # differs but rounding from a surface of that index, of which the picture is that of `path`.
    index = float(load_material("diamond").index(589.3))
    scenes = (
        room(surface(**of), {"type": "gem_path"})
        for of in ({"material": "diamond", "dispersion": False}, {"int_ior": index})
    )
    one, other = (traced(scene, camera_rays(scene, 64, 9), 19) for scene in scenes)
    np.testing.assert_allclose(one, other, rtol=0, atol=SINGLE_RADIANCE)
    # A wavelength further, rays go elsewhere
    scene = room(surface(int_ior=float(load_material("diamond").index(588.3))), {"type": "gem_path"})
    assert np.abs(traced(scene, camera_rays(scene, 64, 9), 19) - one).max() > 100 * SINGLE_RADIANCE


def test_path_takes_gem_dielectric_as_its_own(variant):
    # The same random numbers make the same choices: nothing differs but rounding.
    scenes = room(surface(int_ior=INDEX), PATH), room(STOCK, PATH)
    one, other = (traced(scene, camera_rays(scene, 16, 10), 11) for scene in scenes)
    np.testing.assert_allclose(one, other, rtol=0, atol=SINGLE_RADIANCE)


@pytest.mark.parametrize("mode", ["Radiance", "Importance"])
def test_surface_is_sampled_as_mitsubas_dielectric(variant, mode):
    # From both sides: pictures cannot tell the factor n^2, which cancels between the ways in and out.
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(22, 4096)
    si = dr.zeros(mi.SurfaceInteraction3f, 4096)
    si.wi = mi.warp.square_to_uniform_sphere(sampler.next_2d())
    u, v = sampler.next_1d(), sampler.next_2d()
    context = mi.BSDFContext(getattr(mi.TransportMode, mode))
    ours, its_weight = mi.load_dict(surface(int_ior=INDEX)).sample(context, si, u, v)
    stock, stock_weight = mi.load_dict(STOCK).sample(context, si, u, v)
    np.testing.assert_allclose(dr.zeros(mi.Spectrum, 4096) + its_weight, stock_weight, rtol=SINGLE_RADIANCE)
    for field in ("wo", "pdf", "eta"):
        np.testing.assert_allclose(
            getattr(ours, field), getattr(stock, field), rtol=SINGLE_RADIANCE, atol=SINGLE_RADIANCE
        )
    for field in ("sampled_component", "sampled_type"):
        np.testing.assert_array_equal(getattr(ours, field), getattr(stock, field))
    assert len(np.unique(np.array(ours.eta).round(3))) == 3  # in, out, and reflected


@pytest.mark.parametrize("max_depth", chosen([2, 3, 5, 9], [2, 5]))
def test_paths_are_cut_off_where_path_cuts_them_off(variant_llvm_ad_mono, max_depth):
    # Fewer than all orders of reflection: a segment more or less is seen.
    ours = furnace(
        STONES["inoue-3"], surface(int_ior=INDEX), integrator={"type": "gem_path"} | {"max_depth": max_depth}
    )
    stock = furnace(STONES["inoue-3"], STOCK, integrator=PATH | {"max_depth": max_depth})
    (a, a_error), (b, b_error) = pixels(ours, 256, seed=20), pixels(stock, 256, seed=21)
    assert a.mean() < 0.99
    assert abs(off_by(a - b, np.hypot(a_error, b_error), 0)[0]) <= THREE_SIGMA


# ---- Absorption ----------------------------------------------------------------------------------------

#: A glass that absorbs more at shorter wavelengths [1/mm], linear between the two.
GLASS = """
[index]
wavelength_nm = [380, 760]
n = [2.1, 2.0]
[absorption]
wavelength_nm = [380, 400, 700, 760]
per_mm = [0.4, 0.4, 0.1, 0.1]
"""


def slab(thickness):
    """A slab between z = 0 and -thickness, 20 wide."""
    corners = [(x, y, z) for x in (-10, 10) for y in (-10, 10) for z in (-thickness, 0)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return polyhedron(corners, faces)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("angle_deg", [0.0, 50.0])
def test_slab_absorbs_by_beers_law(variant_llvm_ad_spectral, tmp_path, way, angle_deg):
    # All orders of reflection between two parallel surfaces, in light of radiance 1 from everywhere: of each
    # way through, a = exp(-sigma d / cos) is left: R + T^2 a (1 + R a + ...) = R + T^2 a / (1 - R a).
    path = tmp_path / "glass.toml"
    path.write_text(GLASS)
    unit_mm, thickness, n = 2.5, 0.8, 1 << 16
    shape = placed_mesh(standing(slab(thickness)), surface(material=str(path), unit_mm=unit_mm))
    scene = mi.load_dict(
        {"type": "scene", "integrator": {"type": "gem_path"}, "light": FURNACE, "stone": WAYS[way](shape)}
    )
    angle = math.radians(angle_deg)
    for nm, index, sigma in ((400.0, 2.1 - 0.1 * 20 / 380, 0.4), (600.0, 2.1 - 0.1 * 220 / 380, 0.2)):
        d = np.tile([math.sin(angle), 0.0, -math.cos(angle)], (n, 1))
        ray = rays_of(origin=-3 * d, direction=d, nm=np.full(n, nm))
        measured = traced(scene, ray, seed=12).mean()
        way_mm = unit_mm * thickness / math.sqrt(1 - (math.sin(angle) / index) ** 2)
        R, a = float(reflectance(math.cos(angle), index)), math.exp(-sigma * way_mm)
        assert measured == pytest.approx(R + (1 - R) ** 2 * a / (1 - R * a), rel=SLAB)


# ---- Kernels -------------------------------------------------------------------------------------------


def ellipsoid(n, seed=0):
    """A stone of n planes that touch an ellipsoid."""
    normals = np.random.default_rng(seed).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    planes = np.column_stack([normals, np.linalg.norm(normals * [1.0, 0.8, 0.6], axis=1)])
    facets = tuple(Facet(f"f_{k}", "f", side_of(plane[2])) for k, plane in enumerate(planes))
    return Stone(solid=ConvexSolid(planes=planes, facet=np.arange(n)), facets=facets)


def test_a_stone_of_another_cut_needs_no_new_kernel(variant_llvm_ad_spectral):
    def of(stone, **properties):
        scene = furnace(stone, surface(material="diamond", **properties))
        return kernels(lambda: dr.eval(mi.render(scene, spp=4)))

    known = of(STONES["inoue-1"])  # 57 planes and a cylinder
    for stone in (STONES["inoue-3"], bent_stone(-0.003).rotated(10.0), ellipsoid(33), ellipsoid(64)):
        assert (of(stone) <= known) == (len(stone.solid.planes) <= 64), len(stone.solid.planes)
    assert of(ellipsoid(96, seed=1)) <= of(ellipsoid(70))
    assert not of(ellipsoid(97)) <= of(ellipsoid(96))


@pytest.mark.parametrize(("n", "by_planes"), [(384, True), (385, False)])
def test_stones_of_many_planes_lose_no_light(variant_llvm_ad_spectral, n, by_planes):
    scene = furnace(ellipsoid(n), surface(material="quartz"))
    stones = sys.modules["gemrender.plugins.stones"].Stones(scene, mi.load_dict({"type": "independent"}))
    assert stones.by_planes == by_planes
    off, _ = off_by(*Passes(scene, seed=15).radiance_at(550.0, 16))
    assert abs(off) <= THREE_SIGMA


# ---- Two ways to the next facet ------------------------------------------------------------------------


def row(way):
    """Four stones of three materials in a row, over the dark; `way` is how their facets are found."""
    stones = [STONES["inoue-1"], STONES["inoue-2"], STONES["inoue-3"], bent_stone(-0.003)]
    # Modes that are drawn by chance part the ways of rays that differ by rounding alone
    materials = ("diamond", "quartz", "rutile", "diamond")
    surfaces = [surface(material=material, birefringence=False) for material in materials]
    turn = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    scene = {
        "type": "scene",
        "integrator": {"type": "gem_path"},
        "light": {"type": "gem_hemisphere"},
        "sensor": seen_from_above(4.4, 128, 32),
    }
    for k, (stone, bsdf) in enumerate(zip(stones, surfaces, strict=True)):
        at = (2.2 * (k - 1.5), 0.3 * k, -0.2 * k)
        placed = standing(tessellate(stone), at=at, rotation=turn if k == 1 else None)
        scene[f"stone_{k}"] = placed_mesh(placed, bsdf, f"stone_{k}")
    if way == "embree":
        by_ray_tracer(scene["stone_0"])
    scene = mi.load_dict(scene)
    # Never imported: it belongs to the variant
    stones = sys.modules["gemrender.plugins.stones"].Stones(scene, mi.load_dict({"type": "independent"}))
    assert ("planes" if stones.by_planes else "embree") == way
    return scene


def test_both_ways_to_find_facets_lead_to_the_same_light(variant_llvm_ad_spectral):
    # Along the same rays, with the same random numbers
    planes, other = (
        traced(scene, camera_rays(scene, 16, 13, nm=500.0), 14).mean(axis=0)
        for scene in (row("planes"), row("embree"))
    )
    assert ((planes > 0.01) & (planes < 0.99)).mean() > 0.3
    assert (np.abs(planes - other) > SAME_WAY).mean() <= OTHER_WAY
    # The others went another way by chance: neither more nor less light
    difference = (planes - other).reshape(-1, 16)
    error = math.sqrt(difference.var() / difference.size)
    assert abs(difference.mean()) <= THREE_SIGMA * error

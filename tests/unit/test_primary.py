"""The integrator ``gem_primary``: its manual, its channels, its light, and what it refuses."""

from __future__ import annotations

import dataclasses

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from manuals import code_tab
from physics_tolerances import SINGLE_RADIANCE
from solids import cleft_heart

from gemrender import Model, RayStatus, View, load_stone, observe
from gemrender.errors import InputError
from gemrender.optics.fresnel import reflectance
from gemrender.render.observe import film_rays
from gemrender.scene import stone_scene

#: The manual's list of channels, in order.
AOVS = [
    "primary.intensity", "rear.mask", "coverage", "status", "reflections",
    "exit.x", "exit.y", "exit.z", "exit.dx", "exit.dy", "exit.dz", "entry.facet", "exit.facet", "path.code",
]  # fmt: skip
#: Those that follow where all light is followed.
LATER = [
    "entry.nx", "entry.ny", "entry.nz", "entry.cosine", "exit.cosine",
    "later.status", "later.reflections", "later.partial", "later.weight", "later.probability",
    "later.x", "later.y", "later.z", "later.dx", "later.dy", "later.dz", "later.facet", "later.cosine",
]  # fmt: skip

STONE = load_stone("inoue-1")
SIZE = 48
VIEW = View.of(STONE, SIZE)
FURNACE = {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}}


def scene_of(stone=STONE, view=VIEW, model=None, **other):
    return mi.load_dict(stone_scene(stone, view, model or Model(fresnel="exact")) | other)


def channels(scene, integrator=None):
    """Render through the film; return the radiance (h, w), and the AOVs by name."""
    integrator = integrator or scene.integrator()
    image = mi.render(scene, integrator=integrator).numpy()
    names = integrator.aov_names()
    return image[..., 0], {name: image[..., i - len(names)] for i, name in enumerate(names)}


# ---- The manual ----------------------------------------------------------------------------------------


def test_examples_of_the_manual_render(variants_all):
    manual = type(mi.load_dict({"type": "gem_primary"})).__doc__
    from_dict = mi.load_dict(eval(f"{{{code_tab(manual, 'python')}}}"))
    from_xml = mi.load_string(f'<scene version="3.0.0">{code_tab(manual, "xml")}</scene>').integrator()
    seen = observe(STONE, engine="mitsuba", resolution=SIZE, fresnel="exact", variant=variants_all)
    for integrator in (from_dict, from_xml):
        radiance, aov = channels(scene_of(), integrator)
        np.testing.assert_array_equal(aov["primary.intensity"], seen.primary_intensity)
        np.testing.assert_array_equal(radiance > 0, seen.exit_direction[..., 2] > 0)


def test_every_parameter_is_in_the_manual(variant_llvm_ad_mono):
    integrator = mi.load_dict({"type": "gem_primary"})
    for key in ("fresnel", "rear", "intensity", "follow", *(key for key, _ in mi.traverse(integrator))):
        assert f"     * - {key}\n" in type(integrator).__doc__


def test_says_what_it_is(variant_llvm_ad_mono):
    properties = {"int_ior": 2.0, "fresnel": "exact", "max_reflections": 7, "follow": "all"}
    text = str(mi.load_dict({"type": "gem_primary", **properties}))
    words = ("PrimaryIntegrator", "int_ior = 2,", "fresnel = exact", "max_reflections = 7", "follow = all")
    for part in words:
        assert part in text


# ---- Channels ------------------------------------------------------------------------------------------


def test_channels_have_the_manuals_names_and_order(variant_llvm_ad_mono):
    integrator = mi.load_dict({"type": "gem_primary"})
    assert integrator.aov_names() == AOVS
    scene = scene_of()
    mi.render(scene)
    struct = scene.sensors()[0].film().bitmap().struct_()
    assert [field.name for field in struct] == ["Y", *AOVS]  # the film's own channel comes first


def test_channels_of_all_light_come_after_the_others(variants_all):
    scene = mi.load_dict(stone_scene(STONE, VIEW, Model(fresnel="exact"), follow="all"))
    assert scene.integrator().aov_names() == [*AOVS, *LATER]
    radiance, aov = channels(scene)
    alone, expected = channels(scene_of())
    # A random sample in ten thousand is rounded into the next pixel (the manual of gem_orthographic).
    same = aov["coverage"] == expected["coverage"]
    assert np.count_nonzero(~same) < 0.002 * same.size
    for name in AOVS:
        np.testing.assert_array_equal(aov[name][same], expected[name][same], err_msg=name)
    np.testing.assert_array_equal(radiance[same] > 0, alone[same] > 0)  # of random wavelengths, in spectral
    # Every ray that leaves has a later exit, chosen as likely as T of its crossing times what came before.
    later = aov["later.status"] > 0
    np.testing.assert_array_equal(later, aov["status"] == RayStatus.EXITED)
    crossed = later & (aov["later.partial"] == 1)
    back, again = (reflectance(aov[f"{part}.cosine"][crossed], 2.4173) for part in ("exit", "later"))
    np.testing.assert_allclose(aov["later.weight"][crossed], back, rtol=SINGLE_RADIANCE)
    np.testing.assert_allclose(aov["later.probability"][crossed], 1 - again, rtol=0, atol=SINGLE_RADIANCE)
    for name in LATER:
        untold = ~later if name.startswith("later") else aov["coverage"] == 0
        assert (aov[name][untold] == (-1 if name == "later.facet" else 0)).all(), name


def test_image_holds_what_observe_returns(variant_llvm_ad_mono):
    # Through Mitsuba's film, pixel by pixel: the same as the way around the film that scores take.
    _, aov = channels(scene_of(model=Model()))
    seen = observe(STONE, engine="mitsuba", resolution=SIZE)
    maps = {
        "primary.intensity": seen.primary_intensity, "rear.mask": seen.rear_mask, "coverage": seen.coverage,
        "status": seen.status, "reflections": seen.reflections, "entry.facet": seen.entry_facet,
        "exit.facet": seen.exit_facet, "path.code": seen.path_code,
    }  # fmt: skip
    for k, axis in enumerate("xyz"):
        maps |= {f"exit.{axis}": seen.exit_point[..., k], f"exit.d{axis}": seen.exit_direction[..., k]}
    assert maps.keys() == set(AOVS)
    for name, values in maps.items():
        np.testing.assert_array_equal(aov[name], values, err_msg=name)


def test_nothing_is_told_of_rays_that_miss_the_stone(variant_llvm_ad_mono):
    radiance, aov = channels(scene_of(light=FURNACE))
    missed = aov["coverage"] == 0
    assert missed.any()
    assert (radiance[missed] == 0).all()
    for name in AOVS:
        assert (aov[name][missed] == (-1 if name.endswith("facet") else 0)).all(), name


# ---- Parameters that change ----------------------------------------------------------------------------


def test_changed_parameters_take_effect(variant_llvm_ad_mono):
    scene = scene_of()
    params = mi.traverse(scene.integrator())
    for key, value in {"int_ior": 3.0, "ext_ior": 1.5, "max_reflections": 1}.items():
        params[key] = value
    params.update()
    _, aov = channels(scene)
    glass = dataclasses.replace(STONE, material=2.0)  # only the ratio of the indices counts
    _, expected = channels(scene_of(glass, model=Model(index=2.0, fresnel="exact", max_reflections=1)))
    assert (aov["status"] == RayStatus.TRAPPED).any()
    for name in AOVS:
        np.testing.assert_array_equal(aov[name], expected[name], err_msg=name)


def test_changed_parameters_need_no_new_kernel(variant_llvm_ad_mono):
    scene = scene_of()
    params = mi.traverse(scene.integrator())

    def kernels():
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            dr.eval(mi.render(scene))
            return {k["hash"] for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT}

    known = kernels()
    assert known
    for key, value in {"int_ior": 2.3, "ext_ior": 1.000277, "max_reflections": 50}.items():
        params[key] = value
        params.update()
        assert kernels() == known, key


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("int_ior", 0.9, r"int_ior = 0\.9: must be greater than ext_ior = 1"),
        ("int_ior", 1.5, r"int_ior = 1\.5: Gübelin's table holds for a relative index of 2\.4173"),
        ("max_reflections", 0, "max_reflections = 0: must be at least 1"),
    ],
)
def test_bad_update_is_refused(variant_llvm_ad_mono, key, value, message):
    params = mi.traverse(mi.load_dict({"type": "gem_primary"}))
    params[key] = value
    with pytest.raises(ValueError, match=message):
        params.update()


# ---- Its colour: the light along the principal ray -----------------------------------------------------


@pytest.fixture(params=["variant_llvm_ad_mono", "variant_llvm_ad_rgb"])
def variant(request):
    """A variant in which a pixel's radiance is no average over wavelengths."""
    return request.getfixturevalue(request.param)


def transmitted():
    """T T of each pixel: what is seen in light of radiance 1 from everywhere."""
    radiance, aov = channels(scene_of(light=FURNACE))
    return radiance, {name: values.astype(float) for name, values in aov.items()}


def meets_plate(aov, z, half):
    """Whether the ray that leaves the stone meets the square |x|, |y| < half at the height z."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (z - aov["exit.z"]) / aov["exit.dz"]
        x, y = (aov[f"exit.{axis}"] + t * aov[f"exit.d{axis}"] for axis in "xy")
    return (aov["status"] == RayStatus.EXITED) & (t > 0) & (np.abs(x) < half) & (np.abs(y) < half)


def plate(z, half, **more):
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, z]).scale(half), **more}


def test_area_light_is_seen_beside_the_hemisphere(variant):
    # A shining plate under the stone: light of radiance 3 along rays that come from it, the hemisphere's 1
    # along those from above, nothing between the plate and the horizon.
    lamp = plate(-2.0, 1.0, emitter={"type": "area", "radiance": {"type": "uniform", "value": 3.0}})
    carried, aov = transmitted()
    on_lamp = meets_plate(aov, -2.0, 1.0)
    from_above = aov["exit.dz"] > 0
    between = (aov["status"] == RayStatus.EXITED) & ~on_lamp & ~from_above
    assert min(on_lamp.sum(), from_above.sum(), between.sum()) > 20

    radiance, _ = channels(scene_of(lamp=lamp))
    expected = carried * (3 * on_lamp + from_above)
    np.testing.assert_allclose(radiance, expected, rtol=0, atol=3 * SINGLE_RADIANCE)
    alone = stone_scene(STONE, VIEW, Model(fresnel="exact")) | {"lamp": lamp}
    del alone["light"]
    radiance, _ = channels(mi.load_dict(alone))
    np.testing.assert_allclose(radiance, 3 * carried * on_lamp, rtol=0, atol=3 * SINGLE_RADIANCE)


def test_plate_that_does_not_shine_stands_in_the_way(variant_llvm_ad_mono):
    carried, aov = transmitted()
    blocked = meets_plate(aov, -2.0, 3.0)
    assert blocked.sum() > 20
    radiance, seen = channels(scene_of(light=FURNACE, plate=plate(-2.0, 3.0)))
    np.testing.assert_allclose(radiance, np.where(blocked, 0, carried), rtol=0, atol=SINGLE_RADIANCE)
    # What is measured of the stone is the same, with whatever stands under it.
    for name in AOVS:
        np.testing.assert_array_equal(seen[name], aov[name], err_msg=name)


def test_colour_is_the_same_at_all_wavelengths(variant_llvm_ad_rgb):
    scene = stone_scene(STONE, VIEW, Model(fresnel="exact"))
    scene["sensor"]["film"]["pixel_format"] = "rgb"
    image = mi.render(mi.load_dict(scene)).numpy()
    assert image.shape[-1] == 3 + len(AOVS)
    np.testing.assert_array_equal(image[..., 0], image[..., 1])
    np.testing.assert_array_equal(image[..., 0], image[..., 2])
    lit = image[..., 0] > 0
    assert lit.any()


# ---- Other stones --------------------------------------------------------------------------------------


def test_a_stone_hides_the_light_behind_its_own_edge(variant_llvm_ad_mono):
    # What leaves one lobe of the heart towards the other does not see the sky; the maps do not mind.
    stone = cleft_heart()
    view, model = View.of(stone, SIZE), Model.of(stone, index=1.54, fresnel="exact")
    scene = mi.load_dict(stone_scene(stone, view, model) | {"light": FURNACE})
    radiance, aov = channels(scene)
    lit = aov["status"] == RayStatus.EXITED
    hidden = lit & (radiance == 0)
    assert 0 < hidden.sum() < 0.1 * lit.sum()
    # They leave inwards: towards the cleft's plane x = 0
    assert (aov["exit.x"][hidden] * aov["exit.dx"][hidden] < 0).all()
    seen = observe(stone, engine="mitsuba", resolution=SIZE, model=model)
    np.testing.assert_array_equal(aov["primary.intensity"], seen.primary_intensity)


def measured(scene):
    return scene.integrator().measure(scene, film_rays(scene.sensors()[0]))


def test_a_stone_that_was_moved_is_refused(variant_llvm_ad_mono):
    parts = stone_scene(STONE, VIEW, Model())
    corners = mi.traverse(parts["stone"])
    corners["vertex_positions"] = corners["vertex_positions"] * 1.0001
    corners.update()
    told = "stone = 'stone': must stand where its planes do; it has been moved since they were written"
    with pytest.raises(InputError, match=told):
        measured(mi.load_dict(parts))
    scene = scene_of()
    measured(scene)  # remembers that all is well, until it is not
    changed = mi.traverse(scene)
    changed["stone.vertex_positions"] = changed["stone.vertex_positions"] + 0.01
    changed.update()
    with pytest.raises(InputError, match=told):
        measured(scene)


# ---- Bad values ----------------------------------------------------------------------------------------

BAD = [
    ({"int_ior": 0.9}, "int_ior = 0.9: must be greater than ext_ior = 1"),
    ({"ext_ior": 2.5}, "int_ior = 2.4173: must be greater than ext_ior = 2.5"),
    ({"ext_ior": 0}, "int_ior = 2.4173: must be greater than ext_ior = 0"),
    ({"int_ior": float("nan")}, "int_ior = nan: must be a finite number"),
    ({"int_ior": float("inf")}, "int_ior = inf: must be a finite number"),
    ({"int_ior": "glass"}, "int_ior = 'glass': must be a finite number"),
    ({"int_ior": True}, "int_ior = True: must be a finite number"),
    ({"int_ior": 1.5}, "int_ior = 1.5: Gübelin's table holds for a relative index of 2.4173 (diamond) only"),
    ({"max_reflections": 0}, "max_reflections = 0: must be a whole number, at least 1"),
    ({"max_reflections": 2.5}, "max_reflections = 2.5: must be a whole number, at least 1"),
    ({"max_reflections": 1 << 32}, "max_reflections = 4294967296: must be a whole number, at least 1"),
    ({"max_reflections": "many"}, "max_reflections = 'many': must be a whole number, at least 1"),
    ({"fresnel": "table"}, "fresnel = 'table': must be one of gubelin, exact"),
    ({"rear": "below"}, "rear = 'below': must be one of position, facet, direction"),
    ({"follow": "some"}, "follow = 'some': must be one of principal, all"),
    ({"intensity": "full"}, "intensity = 'full': must be one of primary, radiance"),
]


@pytest.mark.parametrize(("properties", "message"), BAD, ids=[" ".join(map(str, bad)) for bad, _ in BAD])
def test_bad_value_is_refused_in_one_line(variant_llvm_ad_mono, properties, message):
    with pytest.raises(RuntimeError) as refused:
        mi.load_dict({"type": "gem_primary", **properties})
    last = str(refused.value).strip().splitlines()[-1]
    assert last.startswith(f"InputError: {message}")


def test_unknown_property_is_refused(variant_llvm_ad_mono):
    with pytest.raises(RuntimeError, match=r'(?s)unreferenced property.*"max_depth"'):
        mi.load_dict({"type": "gem_primary", "max_depth": 5})


def test_air_counts_as_the_tables_outside(variant_llvm_ad_mono):
    # Mitsuba's own index of air, 1.000277: near enough to 1 for Gübelin's table.
    text = str(mi.load_dict({"type": "gem_primary", "ext_ior": 1.000277}))
    assert "fresnel = gubelin" in text


def test_state_is_not_traced_for_gradients(variant_llvm_ad_mono):
    # The loop of total reflections is no differentiable one; a parameter with gradients does no harm.
    scene = scene_of(light=FURNACE)
    params = mi.traverse(scene)
    dr.enable_grad(params["light.radiance.value"])
    image = mi.render(scene)
    assert not dr.grad_enabled(image)

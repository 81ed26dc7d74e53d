"""`gem_primary` in birefringent stones: beside numpy ray by ray, and beside exact scores in the mean."""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from any_stones import hollow_stone
from mode_rays import tree
from physics_tolerances import COORDINATE, SAMPLING_512, SINGLE_INTENSITY
from refusals import refused
from thorough import chosen

from gemrender import Model, RayStatus, View, load_stone, score
from gemrender.beam.modes import score_modes
from gemrender.cuts import orientation
from gemrender.errors import InputError
from gemrender.observation import indicatrix_of
from gemrender.optics import load_material, refractive_index
from gemrender.optics.crystals import Indicatrix, optic_axes
from gemrender.optics.dispersion import SODIUM_NM
from gemrender.render.observe import film_rays
from gemrender.scene import stone_scene

#: The probability that a normal number is further from its mean by chance: 6e-5.
FOUR_ERRORS = 4.0
#: What is asked of a million rays, in standard errors and in per cent.
THREE_ERRORS, A_TENTH = 3.0, 0.1
#: Share of rays with the same facet sequence in both ways: but for those within rounding of an edge.
MOST_ALIKE = 0.998
#: Directions and intensities [%] of a path of some ten reflections, by two ways in double precision, told in
#: single.
ANGLE, PERCENT = COORDINATE, SINGLE_INTENSITY
#: Average and Rear of 384 x 384 pixels of a grid, by sampling [%]: twice that of 512 x 512 (`SAMPLING_512`).
ONE_GRID = 2 * SAMPLING_512
#: Half the width of a window that is next to a point [girdle radius].
NEXT_TO = 1e-6
#: Paths of a smaller share of the light are not looked for: a thousand times as many have it.
LEAST_SHARE = 3e-3

SLANTED = (np.sin(np.radians(35.0)), 0.0, np.cos(np.radians(35.0)))
LYING = (1.0, 0.0, 0.0)


def made_of(material, c_axis=None, name="inoue-3"):
    return replace(
        load_stone(name),
        material=material,
        crystal=None if c_axis is None else orientation(c_axis=c_axis),
    )


def scene_of(stone, resolution=32, model=None, birefringence=True, tilt=0.0, **integrator):
    """Return a scene whose rays go through random places of their pixels."""
    view, model = View.of(stone, resolution, tilt_deg=tilt), model or Model.of(stone)
    made = stone_scene(stone, view, model, birefringence=birefringence)
    made["sensor"]["sampling"] = "area"
    made["integrator"] |= integrator
    return mi.load_dict(made)


def channels(scene, seed=1):
    """Follow a ray for each pixel; return the AOVs by name."""
    integrator, eye = scene.integrator(), scene.sensors()[0]
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, int(np.prod(eye.film().size())))
    found = integrator.measure(scene, film_rays(eye, sampler), sampler)
    dr.eval(found)
    return dict(zip(integrator.aov_names(), map(np.array, found), strict=True))


# ---- Ray by ray ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("material", "c_axis"), [("moissanite", LYING), ("moissanite", SLANTED), ("topaz", (1.0, 0.3, 0.5))]
)
@pytest.mark.parametrize("place", [(0.1875, 0.3125), (0.0625, 0.5)])
def test_rays_take_the_paths_that_there_are_as_often_as_their_shares(
    variant_llvm_ad_mono, material, c_axis, place
):
    """From one place, or next to it: but for light at the round girdle, which these do not lead to."""
    stone, side = made_of(material, c_axis), 141
    scene, n = scene_of(stone, side), side * side
    window = mi.traverse(scene.sensors()[0])
    for axis, at in zip("xy", place, strict=True):
        window[f"{axis}_min"], window[f"{axis}_max"] = at - NEXT_TO, at + NEXT_TO
    window.update()
    seen = channels(scene, seed=2)
    directions = np.column_stack([seen[f"exit.d{axis}"] for axis in "xyz"])

    crystal, view = indicatrix_of(stone, Model.of(stone)), View(resolution=1)
    paths, told = tree(stone, crystal, view.basis(), place, LEAST_SHARE), np.zeros(n, bool)
    assert len(paths) > 5
    for share, light, direction in paths.values():
        same = np.abs(directions - direction).max(axis=1) < ANGLE
        front = same & (seen["rear.mask"] == 0)
        np.testing.assert_allclose(seen["primary.intensity"][front], 100.0 * light, rtol=0, atol=PERCENT)
        of_direction = sum(x[0] for x in paths.values() if np.abs(x[2] - direction).max() < ANGLE)
        assert same.sum() == pytest.approx(n * of_direction, abs=FOUR_ERRORS * np.sqrt(n * share) + 1)
        told |= same
    rest = n * max(1.0 - sum(share for share, *_ in paths.values()), 0.0)
    assert (~told).sum() == pytest.approx(rest, abs=FOUR_ERRORS * np.sqrt(rest) + 1)


def test_without_birefringence_rays_go_the_same_ways(variant_llvm_ad_mono):
    """Equal indices split nothing: modes differ in intensities, by how light is polarised."""
    stone, equal = made_of("sapphire"), {"principal": [refractive_index("sapphire")] * 3}
    one, other = channels(scene_of(stone, 48, birefringence=False)), channels(scene_of(stone, 48, **equal))
    for name in ("coverage", "status", "entry.facet", "rear.mask"):
        np.testing.assert_array_equal(other[name], one[name], err_msg=name)
    exited = one["status"] == RayStatus.EXITED
    same = exited & (one["path.code"] == other["path.code"])
    assert same.sum() > MOST_ALIKE * exited.sum()
    for name in ("exit.x", "exit.y", "exit.z", "exit.dx", "exit.dy", "exit.dz"):
        np.testing.assert_allclose(other[name][same], one[name][same], rtol=0, atol=ANGLE, err_msg=name)


def test_two_equal_indices_may_be_any(variant_llvm_ad_mono):
    """The optic axis is that of the third."""
    last = {"principal": [1.76, 1.76, 1.77], "c_axis": LYING, "a_axis": (0.0, 0.0, 1.0)}
    first = {"principal": [1.77, 1.76, 1.76], "c_axis": (0.0, 1.0, 0.0), "a_axis": LYING}
    one, other = (channels(scene_of(made_of("sapphire", LYING), **axes)) for axes in (last, first))
    for name, values in one.items():
        np.testing.assert_allclose(other[name], values, rtol=0, atol=PERCENT, err_msg=name)


def test_the_medium_outside_counts_by_the_ratio(variant_llvm_ad_mono):
    air, water = (
        channels(scene_of(made_of("topaz", SLANTED), principal=[n * 1.5, n * 1.6, n * 1.7], ext_ior=n))
        for n in (1.0, 1.33)
    )
    for name, values in air.items():
        np.testing.assert_allclose(water[name], values, rtol=0, atol=PERCENT, err_msg=name)


def test_one_seed_is_one_result(variant_llvm_ad_mono):
    scene = scene_of(made_of("moissanite", LYING))
    one, again, other = (channels(scene, seed) for seed in (1, 1, 2))
    for name, values in one.items():
        np.testing.assert_array_equal(again[name], values, err_msg=name)
    assert (other["primary.intensity"] != one["primary.intensity"]).mean() > 0.5


def test_another_crystal_needs_no_other_kernel(variant_llvm_ad_mono):
    def kernels(stone):
        scene = scene_of(stone)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            channels(scene)
            return {k["hash"] for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT}

    assert kernels(made_of("moissanite", LYING)) == kernels(made_of("sapphire", SLANTED))


# ---- In the mean ---------------------------------------------------------------------------------------


def means(scene, sets):
    """Return Average and Rear [%] of as many sets of rays, (sets, 2)."""
    out = []
    for seed in range(sets):
        aov = channels(scene, seed)
        assert not (aov["status"] == RayStatus.LOST).any()
        met = aov["coverage"].sum()
        out.append([aov[name].sum(dtype=float) / met for name in ("primary.intensity", "rear.mask")])
    return np.array(out) * [1.0, 100.0]


def check_mean(stone, resolution, sets, errors, bound=0.05, **options):
    """Compare means with the exact score; return the differences [%]."""
    tilt = options.pop("tilt", 0.0)
    model = Model.of(stone, **options)
    found = means(scene_of(stone, resolution, model, tilt=tilt), sets)
    exact = score(stone, birefringence=True, model=model, tilt=tilt, bound=bound)
    error = found.std(axis=0, ddof=1) / np.sqrt(sets)
    apart = found.mean(axis=0) - [exact.average, exact.rear]
    assert (np.abs(apart) < exact.bound + errors * error).all(), (apart, error, exact.bound)
    return apart


STONES = {
    "moissanite": made_of("moissanite", name="gia-excellent"),
    "moissanite, slanted": made_of("moissanite", SLANTED, "gia-excellent"),
    "sapphire": made_of("sapphire", name="corundum-round"),
    "sapphire, slanted": made_of("sapphire", SLANTED, "corundum-round"),
    "topaz, slanted": made_of("topaz", (1.0, 0.3, 0.5), "corundum-round"),
}


@pytest.mark.parametrize("name", chosen(STONES, ["moissanite", "sapphire, slanted", "topaz, slanted"]))
def test_the_mean_is_the_exact_score(variant_llvm_ad_mono, name):
    """Of 30 000 rays, whose error is some 0.1 %."""
    check_mean(STONES[name], 48, 16, FOUR_ERRORS, bound=0.2)


@pytest.mark.parametrize(
    "options", [{"intensity": "radiance"}, {"rear": "direction"}, {"tilt": 15.0}], ids=lambda o: next(iter(o))
)
def test_the_mean_is_the_exact_score_by_all_rules(variant_llvm_ad_mono, options):
    check_mean(made_of("moissanite", SLANTED), 48, 16, FOUR_ERRORS, bound=0.2, **options)


def test_an_eye_along_an_optic_axis_sees_the_exact_score(variant_llvm_ad_mono):
    """There both waves of a biaxial stone are one behind the table."""
    stone, indices = made_of("topaz"), indicatrix_of(made_of("topaz"), Model.of(made_of("topaz"))).indices
    sine, _, cosine = np.asarray(optic_axes(Indicatrix.biaxial(*indices, np.eye(3)))).reshape(-1, 3)[0]
    axes = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    found = means(scene_of(stone, 48, c_axis=axes[2].tolist(), a_axis=axes[0].tolist()), 16)
    exact, _ = score_modes(stone, principal=indices, axes=axes, model=Model.of(stone))
    apart = np.abs(found.mean(axis=0) - [exact.average, exact.rear])
    assert (apart < exact.bound + FOUR_ERRORS * found.std(axis=0, ddof=1) / 4.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", STONES)
def test_a_million_rays_are_within_a_tenth_of_the_exact_score(variant_llvm_ad_mono, name):
    apart = check_mean(STONES[name], 256, 16, THREE_ERRORS)
    assert (np.abs(apart) < A_TENTH).all()


# ---- Light ---------------------------------------------------------------------------------------------


def test_what_is_seen_in_even_light_is_what_both_crossings_let_through(variant_llvm_ad_mono):
    """Radiance has no factor of the cross-section, nor of any index."""
    stone = made_of("moissanite", LYING)
    made = stone_scene(stone, View.of(stone, 32), Model.of(stone, intensity="radiance"), birefringence=True)
    made["light"] = {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}}
    scene = mi.load_dict(made)
    image = mi.render(scene, spp=1, seed=1).numpy()
    aov = dict(zip(scene.integrator().aov_names(), np.moveaxis(image[..., 1:], -1, 0), strict=True))
    lit = (aov["status"] == RayStatus.EXITED) & (aov["rear.mask"] == 0)
    assert lit.sum() > 100
    seen, carried = 100.0 * image[..., 0][lit], aov["primary.intensity"][lit]
    np.testing.assert_allclose(seen, carried, rtol=0, atol=PERCENT)


# ---- The manual, and what is refused -------------------------------------------------------------------

SAPPHIRE = {"principal": [1.7681, 1.7681, 1.76]}


def test_every_parameter_is_in_the_manual(variant_llvm_ad_mono):
    integrator = mi.load_dict({"type": "gem_primary", **SAPPHIRE})
    manual = type(integrator).__doc__
    for key in ("principal", "c_axis, a_axis", *(key for key, _ in mi.traverse(integrator))):
        assert f"     * - {key}\n" in manual


def test_says_what_it_is(variant_llvm_ad_mono):
    text = str(mi.load_dict({"type": "gem_primary", **SAPPHIRE}))
    assert "principal = 1.7681, 1.7681, 1.76," in text
    assert "fresnel = exact" in text


def test_indices_cannot_change(variant_llvm_ad_mono):
    """What the waves are made of is set once."""
    exposed = {key for key, _ in mi.traverse(mi.load_dict({"type": "gem_primary", **SAPPHIRE}))}
    assert exposed == {"max_reflections"}


BAD = [
    ({"int_ior": 1.77, **SAPPHIRE}, "int_ior = 1.77: needs int_ior or principal, not both"),
    ({"fresnel": "gubelin", **SAPPHIRE}, "fresnel = 'gubelin': must be one of exact"),
    ({"follow": "all", **SAPPHIRE}, "follow = 'all': must be principal: all light is followed in"),
    ({"ext_ior": 1.8, **SAPPHIRE}, "principal = [1.7681, 1.7681, 1.76]: must be greater than ext_ior = 1.8"),
    ({"principal": [1.7, float("nan"), 1.8]}, "principal = [1.7, nan, 1.8]: must be three finite numbers"),
    ({"principal": 1.7}, "principal = 1.7: must be three finite numbers"),
    ({"c_axis": [0, 0, 0], **SAPPHIRE}, "c_axis = [0.0, 0.0, 0.0]: must be a vector that is not 0"),
    ({"a_axis": [0, 0, 1], **SAPPHIRE}, "a_axis = [0.0, 0.0, 1.0]: must be at right angles to c_axis"),
]  # fmt: skip


@pytest.mark.parametrize(("properties", "message"), BAD, ids=[message for _, message in BAD])
def test_bad_value_is_refused_in_one_line(variant_llvm_ad_mono, properties, message):
    with pytest.raises(RuntimeError) as refused:
        mi.load_dict({"type": "gem_primary", **properties})
    assert str(refused.value).strip().splitlines()[-1].startswith(f"InputError: {message}")


@pytest.mark.parametrize("birefringence", [True, False], ids=["modes", "all light"])
@pytest.mark.parametrize("kind", ["stratified", None])
def test_what_draws_must_be_random(variant_llvm_ad_mono, birefringence, kind):
    more = {} if birefringence else {"follow": "all"}
    scene = scene_of(made_of("sapphire"), birefringence=birefringence, **more)
    sampler = None if kind is None else mi.load_dict({"type": kind, "sample_count": 1, "jitter": False})
    with pytest.raises(InputError, match=r"sampler = .*: must be a random one"):
        scene.integrator().measure(scene, film_rays(scene.sensors()[0]), sampler)


# ---- Scores by random rays -----------------------------------------------------------------------------


def test_mitsubas_score_of_a_birefringent_stone_is_the_exact_one_within_both_bounds(variant_llvm_ad_mono):
    stone = made_of("sapphire", SLANTED, "corundum-round")
    found = score(stone, engine="mitsuba", birefringence=True, resolution=384)
    exact = score(stone, engine="exact", birefringence=True)
    assert found.bound < 0.3
    allowed = found.bound + exact.bound
    assert abs(found.average - exact.average) <= allowed
    assert abs(found.rear - exact.rear) <= allowed
    ordinary, extraordinary = load_material("sapphire").crystal.principal_indices(SODIUM_NM)
    told = f"light is split: indices {ordinary:.5f}, {extraordinary:.5f}"
    assert found.notes == exact.notes == (told,)


def test_a_hollow_stone_of_nearly_one_index_scores_as_of_one(variant_llvm_ad_mono, tmp_path):
    form = 'formula = "cauchy"\ncoefficients = [{}]\nrange_nm = [380, 760]\n'
    file = tmp_path / "nearly.toml"
    file.write_text(f"[index]\n{form.format(1.8)}[index_e]\n{form.format(1.800001)}", encoding="utf-8")
    stone = replace(hollow_stone(), material=str(file))
    found = score(stone, birefringence=True, resolution=384)
    one = score(replace(stone, material=1.8), resolution=384)
    assert (found.engine, found.lost) == ("mitsuba", 0.0)
    assert abs(found.average - one.average) <= found.bound + ONE_GRID
    assert abs(found.rear - one.rear) <= found.bound + ONE_GRID


def test_light_is_not_split_by_the_reference_nor_for_measures_of_a_hollow_stone():
    refused(lambda: score("inoue-3", engine="reference", birefringence=True), "birefringence")
    refused(lambda: score(hollow_stone(), birefringence=True, measures="iso"), "birefringence")

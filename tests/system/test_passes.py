"""Passes of a picture: how samples are counted, what the noise says, what the spectrum says."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from thorough import chosen

from gemrender.colorimetry import colour_matching, y_integral_nm
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.render.backend import ensure_variant
from gemrender.render.passes import Passes, camera_samples, check_range
from gemrender.render.photoreal import FILTER_RADIUS, make_gems, render
from gemrender.scene.loading import load_scene
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup

#: Standard error of the stated noise by the measured one, of all pictures: so well it is tested.
NOISE_KNOWN = 0.07
#: Standard errors that hold 99.9 % of a normal distribution.
SURE = 3.3
#: Standard deviations of a chi-square statistic, of some dozen of them.
CHI_SQUARE = 5
#: Noise stated of one picture of some hundred pixels, by that of another.
ONE_PICTURE = 0.3
#: Kernels of so many operations follow light: they take seconds to compile.
LARGE = 2000
#: Bins of 10 nm against the matching functions within them: their curvature.
BINNED = 0.01


#: Width and height of pictures [pixels].
SIZE = 32, 32


def scene_of(setup="window", width=1, height=1):
    """A set-up's scene, of the film that `render` gives square pictures of all sizes: they share kernels."""
    gems = make_gems([load_stone("inoue-3")])
    return load_scene(photoreal_scene(gems, load_setup(setup), width=width, height=height).to_dict())


@pytest.fixture(scope="module")
def scene():
    ensure_variant("llvm_ad_spectral")
    return scene_of()


@pytest.mark.parametrize("spp", chosen([1, 2, 3, 7, 13], [13]))
def test_all_samples_are_counted(scene, spp):
    passes = Passes(scene, size=SIZE)
    passes.add(spp)
    assert passes.samples == spp


OF_NOISE = [("hemisphere", 8), ("arrows", 16), ("studio", 40)]


@pytest.mark.parametrize(("setup", "number"), chosen(OF_NOISE, OF_NOISE[:1]))
def test_the_noise_is_the_error_on_the_stone(setup, number):
    """Stated of one picture, against the scatter of pictures of many seeds, with its jackknife error.

    Under small lights a few pixels, which one in some ten samples finds one in, have most of the error: it
    takes more pictures to know it as well.
    """
    ensure_variant("llvm_ad_spectral")
    scene = scene_of(setup)
    pictures, stated = [], []
    for seed in range(number):
        passes = Passes(scene, seed=seed, filter_radius=FILTER_RADIUS, size=(16, 16))
        for _ in range(2):
            passes.add(16)
        pictures.append(passes.xyz[passes.stone_pixels, 1].astype(float))
        stated.append(passes.noise())

    def ratio(kept):
        shown = np.array([pictures[k] for k in kept])
        measured = np.sqrt(np.var(shown, axis=0, ddof=1).mean()) / shown.mean()
        return np.sqrt(np.mean(np.square([stated[k] for k in kept]))) / measured

    n = len(stated)
    left_one_out = [ratio([k for k in range(n) if k != one]) for one in range(n)]
    error = np.sqrt((n - 1) * np.var(left_one_out))
    assert error < NOISE_KNOWN
    assert abs(ratio(range(n)) - 1) < SURE * error


@pytest.mark.usefixtures("scene")
def test_camera_samples_of_neighbours_and_halves_have_nothing_in_common():
    """Differences of independent numbers, modulo 1, are even: chi-square over 64 bins."""
    n = 1 << 16
    for seed in (0, 2, 1000):
        first, second = ([np.asarray(x) for x in camera_samples(0, n, 1, 0, seed + k)[2]] for k in (0, 1))
        for a, b in zip(first, second, strict=True):
            for difference in (a - b, np.diff(a), a[::32][1:] - a[::32][:-1]):
                counts, _ = np.histogram(difference % 1, 64, (0, 1))
                expected = len(difference) / 64
                chi_square = np.sum((counts - expected) ** 2) / expected
                assert chi_square < 63 + CHI_SQUARE * np.sqrt(2 * 63)


def test_later_passes_and_pictures_of_other_sizes_need_no_new_kernel():
    """Of a lens, whose numbers are in the kernel; the first scene is gone before the second is made."""
    import drjit as dr

    ensure_variant("llvm_ad_spectral")
    stones, around = make_gems([load_stone("inoue-3")]), load_setup("hand")
    found = []
    for size, pass_samples in ((16, None), (16, 16 * 16 * 4), (24, None)):
        gc.collect()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            render(stones, around, width=size, height=size, spp=8, pass_samples=pass_samples)
            kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
        found.append([k["hash"] for k in kernels if k["operation_count"] > LARGE])
    at_once, in_two, larger = found
    assert in_two == at_once * 2
    assert larger == at_once


def test_passes_go_with_their_last_user(variant_llvm_ad_spectral):
    """They hold the scene, whose shapes' numbers would be in the kernels of the next one's."""
    passes = Passes(scene_of("white"), size=SIZE, foreground=True, bins_nm=[400.0, 700.0])
    passes.add(8)
    gone = weakref.ref(passes)
    gc.disable()
    try:
        del passes
        assert gone() is None
    finally:
        gc.enable()


def test_stone_pixels_are_those_of_the_stone(scene):
    passes = Passes(scene, size=SIZE)
    for _ in range(4):  # by the kernel of four samples, as elsewhere
        passes.add(4)
    shown = passes.stone_pixels
    assert (passes.albedo[shown].max(axis=-1) > 0).all()
    assert 0.2 < shown.mean() < 0.5
    inside = shown[:-2, 1:-1] & shown[1:-1, :-2] & shown[1:-1, 2:] & shown[2:, 1:-1] & shown[1:-1, 1:-1]
    np.testing.assert_array_equal(passes.albedo[1:-1, 1:-1][inside], 1)


def test_the_noise_does_not_count_what_is_beside_the_stone():
    """The same stone, of the same size in pixels, with four times as much black beside it."""
    ensure_variant("llvm_ad_spectral")
    found = []
    for width in (24, 96):
        passes = Passes(scene_of("hemisphere", width // 24), size=(width, 24))
        for _ in range(2):
            passes.add(16)
        found.append((passes.noise(), passes.stone_pixels.sum()))
    (narrow, n_narrow), (wide, n_wide) = found
    assert n_wide == pytest.approx(n_narrow, rel=0.05)
    assert wide == pytest.approx(narrow, rel=ONE_PICTURE)


def test_radiance_at_a_wavelength_takes_any_number_of_samples(scene):
    radiance, error = Passes(scene, size=SIZE).radiance_at(550.0, 7)
    assert radiance.shape == error.shape == (32, 32)
    assert np.isfinite(radiance).all()


def test_before_two_passes_nothing_is_said_of_noise(scene):
    passes = Passes(scene, size=SIZE)
    passes.add(4)
    assert passes.noise() == float("inf")


def test_the_same_seed_gives_the_same_picture(scene):
    pictures = []
    for seed in (5, 5, 6):
        passes = Passes(scene, seed=seed, size=SIZE)
        passes.add(4)
        pictures.append(passes.xyz)
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert np.abs(pictures[0] - pictures[2]).max() > 0


def test_the_spectrum_has_the_pictures_colour(scene):
    edges = np.linspace(380, 760, 39)
    passes = Passes(scene, bins_nm=edges, size=SIZE)
    passes.add(64)
    middles = 0.5 * (edges[1:] + edges[:-1])
    spectrum = passes.spectrum.reshape(-1, 38).mean(axis=0, dtype=np.float64)
    from_bins = 10 * spectrum @ colour_matching(middles) / y_integral_nm()
    np.testing.assert_allclose(from_bins, passes.xyz.reshape(-1, 3).mean(axis=0), rtol=BINNED)


def test_both_halves_at_once_are_the_two_passes(scene):
    one, other = (Passes(scene, size=SIZE) for _ in range(2))
    assert one.caustics is not None  # light is traced to the ground too
    for spp in (4, 8):
        one.add(spp, both=True)
        other.add(spp)
        other.add(spp)
    assert one.samples == other.samples == 24
    np.testing.assert_array_equal(one.halves, other.halves)
    np.testing.assert_array_equal(one.xyz, other.xyz)


def test_an_interruption_leaves_the_sums(scene, monkeypatch):
    passes = Passes(scene, size=SIZE)
    passes.add(4)
    before = passes.xyz

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("gemrender.render.passes.camera_samples", interrupt)
    with pytest.raises(KeyboardInterrupt):
        passes.add(4)
    assert passes.samples == 4
    np.testing.assert_array_equal(passes.xyz, before)


@pytest.mark.parametrize("bad", [(300, 500), (400, 800), (500, 400), (500, 500)])
def test_other_wavelengths_than_visible_ones_are_refused(bad):
    with pytest.raises(InputError, match="must be two increasing wavelengths from 380 to 760"):
        check_range(*bad)


def own_scene(camera, *shifts):
    """A scene of one's own, with stones where one likes."""
    import mitsuba as mi

    from gemrender.scene.mesh import placed_mesh
    from gemrender.scene.placing import Placed
    from gemrender.stone import tessellate

    ensure_variant("llvm_ad_spectral")
    mesh = tessellate(load_stone("inoue-3"))
    stones = {}
    for k, shift in enumerate(shifts):
        at = Placed(name="a", mesh=mesh, rotation=np.eye(3), scale=1.0, shift=np.array(shift, dtype=float))
        stones[f"stone_{k}"] = placed_mesh(at, {"type": "gem_dielectric"}, f"stone_{k}")
    to_world = mi.ScalarTransform4f().look_at(camera, [0, 0, -0.3], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 4, "height": 4}
    sensor = {"type": "perspective", "to_world": to_world, "film": film}
    return mi.load_dict({"type": "scene", "integrator": {"type": "gem_path"}, "sensor": sensor, **stones})


def test_a_camera_inside_a_stone_is_refused():
    Passes(own_scene([0, 0.1, 5], (0, 0, 0)))
    with pytest.raises(InputError, match=r"^camera = 'inside stone_0': must be outside all stones$"):
        Passes(own_scene([0, 0.1, 0.1], (0, 0, 0)))


def test_a_stone_in_a_stone_is_refused():
    Passes(own_scene([0, 0.1, 5], (0, 0, 0), (2.0, 0, 0)))  # they touch
    with pytest.raises(InputError, match=r"^stones = 'stone_\d in stone_\d': must not overlap$"):
        Passes(own_scene([0, 0.1, 5], (0, 0, 0), (1.9, 0, 0)))


@pytest.mark.usefixtures("scene")
def test_the_numbers_of_a_camera_sample_have_nothing_in_common():
    """Sums and differences of two of them, modulo 1, are even over the samples of a pixel."""
    u = [np.asarray(x) for x in camera_samples(0, 1, 4096, 0, 3)[2]]
    for k, a in enumerate(u):
        for b in u[:k]:
            for together in (a + b, a - b):
                counts, _ = np.histogram(together % 1, 16, (0, 1))
                assert counts.min() > 0.5 * counts.mean()

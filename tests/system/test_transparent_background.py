"""Stones before a transparent background: the same light, and of what is beside them nothing."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import box, obj
from PIL import Image
from render_help import read_exr
from thorough import chosen

from gemrender.colorimetry import colour_matching, y_integral_nm
from gemrender.cuts import load_stone
from gemrender.render.backend import ensure_variant
from gemrender.render.first_seen import Seen
from gemrender.render.frames import render_film
from gemrender.render.passes import Passes
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.moves import Move
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import Camera, Ground, Light, Setting, Setup, Sky, Thing, load_setup

SIZE, SPP = 24, 8
#: Bins of 5 nm against the matching function within them.
BINNED = 0.02
#: Reflectance of white paper, of all wavelengths alike.
WHITE = 0.8


def whole(inside):
    """Pixels that the foreground fills, as those beside them: traced light lands on slivers of ground."""
    padded = np.pad(inside, 1)
    h, w = inside.shape
    return np.all([padded[i : i + h, j : j + w] for i in range(3) for j in range(3)], axis=0)


def rendered(setup, **options):
    gems = make_gems([load_stone("inoue-3")])
    return render(gems, load_setup(setup), width=SIZE, height=SIZE, spp=SPP, **options)


@pytest.mark.parametrize("setup", chosen(["studio", "white"], ["white"]))
def test_the_light_is_the_same(setup):
    import mitsuba as mi

    ensure_variant("llvm_ad_spectral")
    gems = make_gems([load_stone("inoue-3")])
    scene = mi.load_dict(photoreal_scene(gems, load_setup(setup), width=1, height=1).to_dict())
    plain, cut = (Passes(scene, size=(SIZE, SIZE), foreground=of) for of in (False, True))
    for passes in (plain, cut):
        for _ in range(2):
            passes.add(SPP // 2)
    for name in ("xyz", "albedo", "normal", "coverage"):
        np.testing.assert_array_equal(getattr(cut, name), getattr(plain, name), err_msg=name)
    assert cut.noise() == plain.noise()
    assert plain.foreground is None
    xyz, albedo, normal, alpha = cut.foreground
    inside = whole(alpha == 1)
    assert 0.1 < inside.mean() < 0.9
    np.testing.assert_array_equal(xyz[inside], plain.xyz[inside])
    np.testing.assert_array_equal(normal[inside], plain.normal[inside])
    np.testing.assert_array_equal(albedo[inside], 1)


@pytest.mark.parametrize("setup", chosen(["studio", "white"], ["white"]))
def test_ground_and_lights_beside_the_stone_are_gone(setup):
    cut = rendered(setup, transparent=True)
    front = cut.foreground
    assert (cut.coverage == 1).all()  # there was ground everywhere
    beside = front.alpha == 0
    assert beside.mean() > 0.1
    assert front.xyz[beside].max() == 0
    edge = (front.alpha > 0) & (front.alpha < 1)
    assert edge.any()
    # What the ground had of the edge is out of the sums
    assert (front.xyz[edge, 1] < cut.xyz[edge, 1]).mean() > 0.9


@pytest.mark.parametrize("beside", ["setting", "thing"])
def test_settings_and_things_stay(beside, tmp_path):
    """As they are in the whole picture; ground and light are gone."""
    if beside == "setting":
        held = {"setting": Setting(type="solitaire", metal="gold")}
    else:
        mesh = obj(tmp_path / "box.obj", box())
        paper = Thing(mesh=mesh, material="paper", colour=(WHITE,) * 3, scale=0.3, place=(1.3, -0.8, 0.3))
        held = {"things": (paper,)}
    setup = Setup(
        name="beside",
        camera=Camera(elevation=40.0),
        lights=(Light(shape="disc", elevation=60.0, radiance=30.0),),
        sky=Sky(radiance=1.0),
        ground=Ground(type="plane", reflectance=0.3),
        **held,
    )
    gems, size = make_gems([load_stone("inoue-3")]), 2 * SIZE
    cut = render(gems, setup, width=size, height=size, spp=SPP, transparent=True)
    front, shows = cut.foreground, cut.shows
    for kind, least in ((Seen.STONE, 0.08), (Seen.BESIDE, 0.03), (Seen.GROUND, 0.3)):
        assert (shows == kind).mean() > least
    inside = whole(front.alpha == 1)
    assert (front.alpha == 1)[shows == Seen.BESIDE].mean() > 0.5
    assert inside[shows == Seen.BESIDE].mean() > 0.2
    for name in ("xyz", "albedo", "normal"):
        np.testing.assert_array_equal(getattr(front, name)[inside], getattr(cut, name)[inside])
    assert set(shows[front.alpha == 0]) == {Seen.GROUND}
    assert front.xyz[front.alpha == 0].max() == 0

    channels, _ = read_exr(cut.save(tmp_path / "a.exr"))
    np.testing.assert_array_equal(channels["A"], front.alpha)
    of_most = np.median(channels["albedo.R"][inside & (shows == Seen.BESIDE)])
    assert of_most == pytest.approx(0.0 if beside == "setting" else WHITE)  # of metal none is diffuse


def test_before_black_it_is_the_picture():
    """The hemisphere shows nothing beside the stone: its edge, premultiplied, is all there was."""
    cut = rendered("hemisphere", transparent=True)
    np.testing.assert_array_equal(cut.foreground.xyz, cut.xyz)
    np.testing.assert_array_equal(cut.foreground.alpha, cut.coverage)


def test_spectral_bins_are_the_stones():
    edges = np.linspace(380, 760, 77)
    cut = rendered("white", transparent=True, bins_nm=edges)
    assert cut.spectrum[cut.foreground.alpha == 0].max() == 0
    y = cut.spectrum @ colour_matching(0.5 * (edges[1:] + edges[:-1]))[:, 1] * 5 / y_integral_nm()
    assert y.mean() == pytest.approx(cut.foreground.xyz[..., 1].mean(), rel=BINNED)


@pytest.mark.parametrize("name", ["a.gif", "a.webp"])
def test_a_film_before_a_transparent_background(name, tmp_path):
    gems = make_gems([load_stone("inoue-3")])
    path = render_film(
        tmp_path / name, gems, load_setup("white"), frames=2, fps=10.0, move=Move(), ev=0.0,
        curve="filmic", denoise=False, progress=lambda _: lambda _: None, width=SIZE,
        height=SIZE, spp=2, transparent=True,
    )  # fmt: skip
    assert [file.name for file in tmp_path.iterdir()] == [name]
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (2, (SIZE, SIZE))
        film.seek(1)
        alpha = np.asarray(film.convert("RGBA"))[..., 3]
    assert alpha[0, 0] == 0
    assert alpha[SIZE // 2, SIZE // 2] == 255

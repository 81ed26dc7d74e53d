"""Compare a stone's spectral radiance with raysect's, a renderer that no one here wrote.

    pip install raysect
    python scripts/compare_raysect.py [--stone inoue-3] [--samples 2048] [--ours 64] [--pixels 48] [--block 4]
                                      [--passes 16] [--workers 2] [--seed 1] [--out FOLDER]

The same diamond, lamps and camera in both, in 8 bins from 400 to 720 nm. raysect has one index in each, its
mean over the bin; `gem_path` renders the wavelength where diamond has that index, with a `gem_dielectric` of
the material diamond in a spectral variant. What differs is set against the noise of both: pixel by pixel, in
blocks of pixels, and as a mean of each bin. As a check that this would tell a wrong index, raysect's bins are
also compared with our next ones.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import math
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.cuts import load_stone
from gemrender.report.lettering import save_png
from gemrender.stone import Stone
from gemrender.stone.mesh import tessellate
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Diamond after Peter 1923: n^2 = 1 + sum of B L^2 / (L^2 - C), with L in micrometres.
SELLMEIER = ((0.3306, 0.1750**2), (4.3356, 0.1060**2))
RANGE, BINS = (400.0, 720.0), 8
#: Step at which raysect averages the index over a bin [nm].
STEP = 1.0
#: Longest paths of raysect, far above what occurs (`print_furnace` checks it).
DEPTH = 1000
#: Size of the girdle radius in raysect. It starts each ray 1e-6 off a mesh, whatever the mesh's size, and
#: meets triangles in single precision: sizes 0.01 to 1 agree, 100 is 15 % too dark (rays stick to it).
RAYSECT_SCALE = 0.1
#: Below this share of its usual ratio to ours, an error of raysect's is of samples that missed something.
UNSEEN = 0.2
#: Samples a pixel in one pass of ours.
SAMPLES = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class Lamp:
    """A shining ball: where its middle is, by tilt from the table's normal and azimuth [degrees]."""

    tilt: float
    azimuth: float
    radiance: float
    distance: float = 5.0
    radius: float = 1.8

    @property
    def centre(self) -> np.ndarray:
        """Middle of the ball [girdle radius]."""
        return self.distance * direction(self.tilt, self.azimuth)


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneDescription:
    """What both render; lengths are in girdle radii.

    Attributes
    ----------
    stone : Stone
        The stone.
    lamps : tuple of Lamp
        The lamps, of the same radiance at all wavelengths.
    environment : float
        Radiance from everywhere else.
    tilt, azimuth : float
        Where the eye is, far away: from the table's normal, and about it [degrees].
    half_width : float
        Half the width of the square window.
    distance : float
        How far from the stone's origin the rays start.
    pixels : int
        Pixels a side.
    """

    stone: Stone
    lamps: tuple[Lamp, ...] = (
        Lamp(tilt=25, azimuth=60, radiance=3.0),
        Lamp(tilt=55, azimuth=200, radiance=2.0),
        Lamp(tilt=75, azimuth=310, radiance=4.0),
    )
    environment: float = 0.25
    tilt: float = 40.0
    azimuth: float = 15.0
    half_width: float = 1.05
    distance: float = 2.0
    pixels: int = 48

    def furnace(self) -> SceneDescription:
        """Return the scene with radiance 1 from everywhere: every path that ends in time brings 1."""
        return replace(self, lamps=tuple(replace(lamp, radiance=1.0) for lamp in self.lamps), environment=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bin:
    """A range of wavelengths [nm], the index that stands for it, and the wavelength where diamond has it."""

    low: float
    high: float
    index: float
    wavelength: float

    def __str__(self) -> str:
        return f"{self.low:.0f}-{self.high:.0f} nm"


def direction(tilt: float, azimuth: float) -> np.ndarray:
    """Return the unit vector at a tilt from the z axis and an azimuth [degrees]."""
    t, a = math.radians(tilt), math.radians(azimuth)
    return np.array([math.sin(t) * math.cos(a), math.sin(t) * math.sin(a), math.cos(t)])


def diamond_index(wavelength: np.ndarray) -> np.ndarray:
    """Return diamond's index at wavelengths [nm]."""
    square = (np.asarray(wavelength) * 1e-3) ** 2
    return np.sqrt(1 + sum(b * square / (square - c) for b, c in SELLMEIER))


def make_bins() -> list[Bin]:
    """Cut the range into bins, each with its mean index, as raysect has it for a spectral ray."""
    fine = np.linspace(*RANGE, 32001)
    edges = np.linspace(*RANGE, BINS + 1)
    out = []
    for low, high in pairwise(edges):
        parts = math.ceil((high - low) / STEP)
        middles = low + (np.arange(parts) + 0.5) * (high - low) / parts
        index = float(diamond_index(middles).mean())
        wavelength = float(np.interp(-index, -diamond_index(fine), fine))
        out.append(Bin(low=float(low), high=float(high), index=index, wavelength=wavelength))
    return out


# ---- raysect ----


def _raysect_pass(
    scene: SceneDescription, bins: Sequence[Bin], samples: int, seed: int, scale: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Render one pass in this process: mean (8, h, w), variance of one sample, CPU time [s].

    Raises
    ------
    RuntimeError
        raysect does not use the index that the bins state.
    """
    os.environ["MPLBACKEND"] = "Agg"  # raysect imports pyplot
    core, optical, primitive = (
        importlib.import_module(f"raysect.{name}") for name in ("core", "optical", "primitive")
    )
    material = importlib.import_module("raysect.optical.material")
    observer = importlib.import_module("raysect.optical.observer")
    importlib.import_module("raysect.core.math.random").seed(seed)
    start = time.process_time()

    (b1, c1), (b2, c2) = SELLMEIER
    index = material.Sellmeier(b1, b2, 0.0, c1, c2, 0.0, STEP)
    for one in bins:
        if abs(index.average(one.low, one.high) - one.index) > 1e-9:
            raise RuntimeError(
                f"raysect's index at {one} is {index.average(one.low, one.high)}, ours {one.index}"
            )

    world = optical.World()
    positions, normals, faces = tessellate(scene.stone).split()
    # An open mesh, for raysect: a closed one is asked at each bounce whether the ray is inside, to absorb.
    stone = primitive.Mesh(
        positions * scale, np.hstack([faces, faces]), normals, smoothing=True, closed=False, parent=world
    )
    stone.material = material.Dielectric(index, optical.ConstantSF(1.0))
    balls = [(lamp.radius, lamp.centre, lamp.radiance) for lamp in scene.lamps]
    for radius, centre, radiance in [*balls, (50.0, np.zeros(3), scene.environment)]:
        ball = primitive.Sphere(radius * scale, parent=world)
        ball.transform = core.translate(*(centre * scale))
        ball.material = material.UniformSurfaceEmitter(optical.ConstantSF(1.0), radiance)

    # It looks along its z axis, with x to the left and y up.
    right, up, eye = view_axes(scene)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([-right, up, -eye, eye * scene.distance * scale])
    frame = observer.SpectralRadiancePipeline2D(accumulate=False)
    camera = observer.OrthographicCamera(
        (scene.pixels, scene.pixels),
        width=2 * scene.half_width * scale,
        frame_sampler=observer.FullFrameSampler2D(),
        pipelines=[frame],
        parent=world,
        transform=core.AffineMatrix3D(matrix.tolist()),
    )
    camera.render_engine = core.SerialEngine()
    camera.quiet = True
    camera.min_wavelength, camera.max_wavelength = bins[0].low, bins[-1].high
    camera.spectral_bins = camera.spectral_rays = len(bins)
    camera.pixel_samples = samples
    # Set here: as arguments 0 and False would be taken for "not given".
    camera.ray_max_depth = camera.ray_extinction_min_depth = DEPTH
    camera.ray_extinction_prob = 0.0
    camera.ray_importance_sampling = False
    camera.observe()
    mean, variance = (
        np.array(values).transpose(2, 1, 0) for values in (frame.frame.mean, frame.frame.variance)
    )
    return mean, variance, time.process_time() - start


def view_axes(scene: SceneDescription) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the image's right and up and the direction to the eye, as of `gem_orthographic`."""
    eye = direction(scene.tilt, scene.azimuth)
    towards = direction(90, scene.azimuth)
    axis = direction(90, scene.azimuth + 90)
    lowered = direction(scene.tilt + 90, scene.azimuth)

    def turned(v: np.ndarray) -> np.ndarray:
        return np.asarray((v @ axis) * axis + (v @ towards) * lowered)

    return turned(np.array([1.0, 0, 0])), turned(np.array([0, 1.0, 0])), eye


def raysect_radiance(
    scene: SceneDescription,
    bins: Sequence[Bin],
    samples: int,
    seed: int,
    *,
    passes: int = 16,
    workers: int = 2,
    scale: float = RAYSECT_SCALE,
    progress: bool = True,
) -> tuple[np.ndarray, np.ndarray]:
    """Render with raysect, in independent passes that processes share.

    Returns
    -------
    mean, standard_error : (bins, h, w) float64
        Radiance, rows from the top.
    """
    passes = min(passes, samples)
    each = math.ceil(samples / passes)
    seeds = [int(s.generate_state(1, np.uint64)[0] >> 1) for s in np.random.SeedSequence(seed).spawn(passes)]
    means, variances = [], []
    begun, used = time.perf_counter(), 0.0
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        running = [pool.submit(_raysect_pass, scene, bins, each, one, scale) for one in seeds]
        for done in as_completed(running):
            mean, variance, seconds = done.result()
            means.append(mean)
            variances.append(variance)
            used += seconds
            if progress:
                print(
                    f"  raysect: pass {len(means)} of {passes}, {time.perf_counter() - begun:.0f} s",
                    flush=True,
                )
    if progress:
        paths = passes * each * scene.pixels**2 * len(bins)
        print(f"  raysect: {paths:.3g} paths, {paths / used:.3g} a second and core")
    return np.mean(means, axis=0), np.sqrt(np.mean(variances, axis=0) / (passes * each))


# ---- gemrender ----


def gemrender_radiance(
    scene: SceneDescription, bins: Sequence[Bin], passes: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Render the same here, one bin after the other; what independent passes scatter tells the error.

    Returns
    -------
    mean, standard_error : (bins, h, w) float64
        Radiance, rows from the top.
    """
    from gemrender.render.backend import ensure_variant
    from gemrender.render.passes import Passes
    from gemrender.scene.loading import load_scene

    ensure_variant("llvm_ad_spectral")
    ours = Passes(load_scene(mitsuba_scene(scene)))
    out = np.empty((2, len(bins), scene.pixels, scene.pixels))
    for number, one in enumerate(bins):
        first = (seed * len(bins) + number) * passes
        found = [ours.radiance_at(one.wavelength, SAMPLES, seed=first + k)[0] for k in range(passes)]
        out[:, number] = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / math.sqrt(passes)
    return out[0], out[1]


def mitsuba_scene(scene: SceneDescription) -> dict[str, Any]:
    """Return the scene for Mitsuba's spectral variant."""
    from gemrender.scene.mesh import stone_mesh

    def same(radiance: float) -> dict[str, Any]:
        return {"type": "uniform", "value": radiance}

    half = scene.half_width
    out: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "gem_path"},
        "sensor": {
            "type": "gem_orthographic",
            "sampling": "area",
            "x_min": -half, "x_max": half, "y_min": -half, "y_max": half,
            "tilt": scene.tilt, "tilt_azimuth": scene.azimuth, "distance": scene.distance,
            "film": {"type": "hdrfilm", "width": scene.pixels, "height": scene.pixels},
        },
        "environment": {"type": "constant", "radiance": same(scene.environment)},
        "stone": stone_mesh(scene.stone, {"type": "gem_dielectric", "material": "diamond"}),
    }  # fmt: skip
    for number, lamp in enumerate(scene.lamps):
        out[f"lamp_{number}"] = {
            "type": "sphere",
            "center": lamp.centre.tolist(),
            "radius": lamp.radius,
            "emitter": {"type": "area", "radiance": same(lamp.radiance)},
        }
    return out


# ---- Comparison ----


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """Two renderings set against their noise.

    Attributes
    ----------
    pixels, blocks : (n,) float64
        Difference over its standard error, of each pixel and each block of pixels in each bin that has noise.
    bins : (b, 4) float64
        Mean of raysect's radiance, ours minus raysect's, its standard error, and their ratio.
    chi_square, p_value : float
        Of the blocks: the sum of squares, and how often noise alone would make it as large.
    still : float
        Largest difference where neither has noise.
    """

    pixels: np.ndarray
    blocks: np.ndarray
    bins: np.ndarray
    chi_square: float
    p_value: float
    still: float


def compare(
    theirs: tuple[np.ndarray, np.ndarray], ours: tuple[np.ndarray, np.ndarray], block: int
) -> Compared:
    """Compare means and standard errors (bins, h, w), by pixels and by blocks of so many a side."""
    difference, variance = ours[0] - theirs[0], ours[1] ** 2 + theirs[1] ** 2
    # Single precision, and sums of it: the environment itself seems to scatter by that little.
    noisy = variance > (1e-5 * theirs[0]) ** 2
    pixels = difference[noisy] / np.sqrt(variance[noisy])
    sums, variances, counts = (
        _blocks(np.where(noisy, values, 0.0), block)
        for values in (difference, variance, np.ones_like(variance))
    )
    blocks = sums[counts > 0] / np.sqrt(variances[counts > 0])
    chi_square = float((blocks**2).sum())
    size = difference[0].size
    error = np.sqrt(variance.sum(axis=(1, 2))) / size
    off = difference.mean(axis=(1, 2))
    still = np.abs(difference[~noisy])
    return Compared(
        pixels=pixels,
        blocks=blocks,
        bins=np.column_stack([theirs[0].mean(axis=(1, 2)), off, error, off / error]),
        chi_square=chi_square,
        p_value=chi_square_tail(chi_square, blocks.size),
        still=float(still.max()) if still.size else 0.0,
    )


def with_unseen_noise(theirs: np.ndarray, ours: np.ndarray) -> np.ndarray:
    """Return raysect's errors, in pixels where it cannot know its own by ours at their usual ratio.

    Where raysect met the same radiance in (nearly) all of its samples, as where a lamp is seen by one path in
    some thousand, they scatter by (nearly) nothing, and its error would be as small. Ours know of that path.
    """
    both = (theirs > 0) & (ours > 0)
    ratio = float(np.median(theirs[both] / ours[both]))
    return np.where(theirs < UNSEEN * ratio * ours, ratio * ours, theirs)


def _blocks(values: np.ndarray, block: int) -> np.ndarray:
    """Sum (b, h, w) over squares of so many pixels a side; incomplete ones at the border count too."""
    _, h, w = values.shape
    by_row = np.add.reduceat(values, range(0, h, block), axis=1)
    return np.add.reduceat(by_row, range(0, w, block), axis=2)


def chi_square_tail(value: float, degrees: int) -> float:
    """Return the probability of a chi-square as large or larger, after Wilson and Hilferty."""
    spread = 2 / (9 * degrees)
    return normal_tail(((value / degrees) ** (1 / 3) - 1 + spread) / math.sqrt(spread))


def normal_tail(z: float) -> float:
    """Return the probability of a normal deviate above `z`."""
    return 0.5 * math.erfc(z / math.sqrt(2))


def _words(p_value: float) -> str:
    return f"= {p_value:.2g}" if p_value > 1e-100 else "< 1e-100"


def print_furnace(scene: SceneDescription, bins: Sequence[Bin], options: argparse.Namespace) -> None:
    """Print whether light gets lost: with radiance 1 from everywhere, each pixel is 1."""
    furnace = scene.furnace()
    found = {
        "raysect": raysect_radiance(furnace, bins, 8, options.seed + 1, passes=1, workers=1, progress=False),
        "ours": gemrender_radiance(furnace, bins, 4, options.seed + 1),
    }
    for name, (mean, error) in found.items():
        total = math.sqrt(float((error**2).sum())) / error.size
        print(f"{name}: radiance lost in a furnace of radiance 1: {1 - mean.mean():.1e} +- {total:.1e}")


def print_found(found: Compared, bins: Sequence[Bin], block: int) -> None:
    """Print a comparison."""
    print(
        f"\n{'bin':<12}{'index':>9}{'ours at':>10}{'raysect':>10}"
        f"{'ours - it':>12}{'error':>10}{'sigmas':>8}{'relative':>20}"
    )
    for one, (mean, off, error, sigmas) in zip(bins, found.bins, strict=True):
        relative = f"{100 * off / mean:+.3f} +- {100 * error / mean:.3f} %"
        print(
            f"{one!s:<12}{one.index:>9.5f}{one.wavelength:>10.2f}{mean:>10.5f}{off:>+12.5f}{error:>10.5f}{sigmas:>+8.2f}{relative:>20}"
        )
    mean, off = found.bins[:, 0].mean(), found.bins[:, 1].mean()
    error = float(np.sqrt((found.bins[:, 2] ** 2).sum()) / len(bins))
    relative = f"{100 * off / mean:+.3f} +- {100 * error / mean:.3f} %"
    print(f"{'all':<31}{mean:>10.5f}{off:>+12.5f}{error:>10.5f}{off / error:>+8.2f}{relative:>20}")
    squares = float((found.bins[:, 3] ** 2).sum())
    p_value = chi_square_tail(squares, len(bins))
    print(f"means of bins: chi-square {squares:.1f} of {len(bins)}, p {_words(p_value)}")

    expected = [1 - 2 * normal_tail(sigmas) for sigmas in (1, 2, 3)]
    words = ", ".join(f"{100 * share:.2f}" for share in expected)
    print(f"\nshare within 1, 2, 3 sigmas [%] (noise alone: {words}), mean and spread of the deviations")
    for name, z in (("pixels", found.pixels), (f"blocks of {block} x {block}", found.blocks)):
        shares = "".join(f"{100 * np.mean(np.abs(z) <= sigmas):>8.2f}" for sigmas in (1, 2, 3))
        print(
            f"  {name:<16}{z.size:>7}{shares}   mean {z.mean():+.3f} +- {1 / math.sqrt(z.size):.3f}, "
            f"spread {z.std():.3f} +- {1 / math.sqrt(2 * z.size):.3f}, largest {np.abs(z).max():.1f}"
        )
    print(f"  where neither has noise: largest difference {found.still:.1e}")
    print(
        f"blocks: chi-square {found.chi_square:.0f} of {found.blocks.size}, p {_words(found.p_value)}: "
        f"{'agree within noise' if found.p_value > 0.01 else 'DO NOT AGREE'}"
    )


def print_control(
    theirs: tuple[np.ndarray, np.ndarray],
    ours: tuple[np.ndarray, np.ndarray],
    bins: Sequence[Bin],
    block: int,
) -> None:
    """Print what a wrong index would look like: raysect's bins against our next ones."""
    print("\nControl, raysect's bins against our next ones")
    for i in range(len(bins) - 1):
        wrong = compare(
            (theirs[0][i : i + 1], theirs[1][i : i + 1]),
            (ours[0][i + 1 : i + 2], ours[1][i + 1 : i + 2]),
            block,
        )
        print(
            f"  {bins[i]} with an index lower by {bins[i].index - bins[i + 1].index:.4f}: "
            f"chi-square {wrong.chi_square:.0f} of {wrong.blocks.size}, p {_words(wrong.p_value)}"
        )


def draw(
    theirs: tuple[np.ndarray, np.ndarray], ours: tuple[np.ndarray, np.ndarray], bins: Sequence[Bin]
) -> Figure:
    """Draw both, and their difference over its standard error, in the first, middle and last bin."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 10.4), dpi=110)
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.02, top=0.96, wspace=0.05, hspace=0.1)
    shown = (0, len(bins) // 2, len(bins) - 1)
    top = float(np.percentile(theirs[0], 99.5))
    sigma = np.sqrt(ours[1] ** 2 + theirs[1] ** 2)
    sigmas = (ours[0] - theirs[0]) / np.where(sigma > 1e-5 * theirs[0], sigma, np.inf)
    for column, i in enumerate(shown):
        for row, (name, values) in enumerate(
            {"raysect": theirs[0], "gemrender": ours[0], "": sigmas}.items()
        ):
            axes = figure.add_subplot(3, 3, 3 * row + column + 1)
            if name:
                axes.imshow(values[i], cmap="gray", vmin=0, vmax=top)
            else:
                axes.imshow(values[i], cmap="RdBu_r", vmin=-4, vmax=4)
            axes.set_title(f"{name or 'difference / error'}, {bins[i]}", fontsize=10)
            axes.set_axis_off()
    return figure


def main() -> None:
    """Render with both, compare, and draw if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stone", default="inoue-3", help="a bundled stone, or a file")
    parser.add_argument(
        "--samples",
        type=int,
        default=2048,
        help="raysect's samples a pixel and bin; below 1000 rare paths make the noise unlike a normal one",
    )
    parser.add_argument(
        "--ours", type=int, default=64, help=f"our independent passes of {SAMPLES} samples a pixel and bin"
    )
    parser.add_argument("--pixels", type=int, default=48, help="pixels a side")
    parser.add_argument(
        "--block", type=int, default=4, help="pixels a side that the chi-square takes together"
    )
    parser.add_argument("--passes", type=int, default=16, help="independent passes of raysect")
    parser.add_argument("--workers", type=int, default=2, help="processes that raysect may use")
    parser.add_argument(
        "--scale", type=float, default=RAYSECT_SCALE, help="size of a girdle radius in raysect"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the figure and the numbers")
    options = parser.parse_args()
    if importlib.util.find_spec("raysect") is None:
        parser.exit(2, "raysect is not there; install it beside gemrender: pip install raysect\n")

    scene = SceneDescription(stone=load_stone(options.stone), pixels=options.pixels)
    bins = make_bins()
    print_furnace(scene, bins, options)
    found = raysect_radiance(
        scene, bins, options.samples, options.seed,
        passes=options.passes, workers=options.workers, scale=options.scale,
    )  # fmt: skip
    begun = time.perf_counter()
    ours = gemrender_radiance(scene, bins, options.ours, options.seed)
    samples = options.ours * SAMPLES * scene.pixels**2 * len(bins)
    print(f"  ours: {samples:.3g} samples, {time.perf_counter() - begun:.0f} s")
    theirs = found[0], with_unseen_noise(found[1], ours[1])
    print_found(compare(theirs, ours, options.block), bins, options.block)
    print_control(theirs, ours, bins, options.block)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        figure = draw(theirs, ours, bins)
        print(f"written: {write_whole(options.out, {'raysect.png': lambda part: save_png(figure, part)})[0]}")
        np.savez(options.out / "raysect.npz", theirs=np.array(theirs), ours=np.array(ours))


if __name__ == "__main__":
    main()

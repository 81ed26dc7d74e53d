"""The contestants of `benchmark_photoreal.py`: one scene, and each renderer in a process of its own.

Two renderers in one process would share thread pools, Embree and LLVM; apart, each runs as its user has it.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from gemrender.cuts import load_stone
from gemrender.errors import GemrenderError
from gemrender.scene.loading import load_scene
from gemrender.stone import Stone, tessellate

__all__ = ["BUILDERS", "ContestantError", "Remote", "Shot", "View", "cores", "scene"]

#: Peter 1923 between 380 and 780 nm as Cauchy's A + B / L^2, L in micrometres: to 0.0013 in the index.
CAUCHY_A, CAUCHY_B = 2.37812, 0.013670
#: Peter 1923 at the sodium D line, for those without dispersion.
INDEX_D = 2.41726
#: Longest paths. What is left in the stone after so many events is next to nothing.
DEPTH = 128
#: Rays that Mitsuba follows at once: more of them take more memory, and no less time each.
WAVEFRONT = 1 << 22
#: More than the passes of a picture: seeds of passes are this many times the picture's, and on.
PASSES = 1 << 14


class ContestantError(Exception):
    """A contestant cannot run here; the message says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quad:
    """A rectangle: its corners anticlockwise seen from its front, which is the side that a light lights."""

    corners: np.ndarray
    radiance: float = 0.0
    reflectance: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What all contestants render: a stone, table up, before a camera, under the same lights [girdle radii].

    Attributes
    ----------
    stone : Stone
        The stone.
    environment : float
        Radiance of the constant environment.
    quads : sequence of Quad
        Softboxes, and the ground if any.
    origin, target : (3,) tuple
        Where the camera is, and looks at; up is z.
    angle : float
        Field of view [degrees].
    size : int
        Pixels a side.
    """

    stone: Stone
    environment: float
    quads: Sequence[Quad]
    origin: tuple[float, float, float]
    target: tuple[float, float, float]
    angle: float
    size: int

    def silhouette(self) -> np.ndarray:
        """Return the pixels whose centres the (convex) stone covers, (size, size) bool."""
        forward = np.subtract(self.target, self.origin)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        away = np.asarray(tessellate(self.stone).vertices) - self.origin
        scale = 1.0 / (away @ forward * np.tan(np.radians(self.angle / 2)))
        points = np.stack([away @ right * scale, away @ np.cross(right, forward) * scale])
        grid = (np.arange(self.size) + 0.5) / self.size * 2 - 1
        inside = np.ones((self.size, self.size), dtype=bool)
        for angle in np.linspace(0, 2 * np.pi, 720, endpoint=False):
            x, y = np.cos(angle), np.sin(angle)
            inside &= x * grid - y * grid[:, None] <= (x * points[0] + y * points[1]).max()
        return inside


def softbox(position: Sequence[float], half: float, radiance: float) -> Quad:
    """Return a square light at `position` that faces the stone."""
    front = -np.asarray(position, dtype=float) / np.linalg.norm(position)
    right = np.cross((0.0, 0.0, 1.0), front)
    right /= np.linalg.norm(right)
    up = np.cross(front, right)
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = np.array([np.asarray(position) + half * (x * right + y * up) for x, y in signs])
    return Quad(corners=corners, radiance=radiance)


def scene(ground: bool, size: int, stone: str = "inoue-3", *, small: bool = False) -> View:
    """Return the benchmark's scene, with or without a grey ground that the culet stands on.

    With one small light, of 0.003 sr, in a dim room instead of the softboxes, where `small` is true.
    """
    shape = load_stone(stone)
    quads = [
        softbox((3.5, -1.5, 3.5), 1.6, 5.0),
        softbox((-3.5, -0.5, 2.5), 1.3, 5.0),
        softbox((0.3, 3.0, 4.0), 1.3, 5.0),
    ]
    if small:
        quads = [softbox((3.5, -1.5, 3.5), 0.15, 500.0)]
    if ground:
        z = float(tessellate(shape).vertices[:, 2].min()) - 0.005
        corners = np.array([(-8, -8, z), (8, -8, z), (8, 8, z), (-8, 8, z)], dtype=float)
        quads.append(Quad(corners=corners, reflectance=0.5))
    return View(
        stone=shape, environment=0.05 if small else 0.2, quads=quads,
        origin=(1.5, -6.0, 4.6), target=(0.0, 0.0, -0.3), angle=18.0, size=size,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A picture.

    Attributes
    ----------
    image : (h, w, 3) float64
        Linear sRGB, the first row the highest.
    seconds : float
        Time of the rendering itself [s].
    busy : float
        Processor time over all cores' share of that time: below 1 where cores idled or were taken by others.
    samples : float
        Samples a pixel.
    besides : float
        Time before and after it, for each picture [s].
    """

    image: np.ndarray
    seconds: float
    busy: float
    samples: float
    besides: float = 0.0


def cores() -> int:
    """Return the number of cores, which all contestants use."""
    return os.cpu_count() or 1


class Clock:
    """What has passed since it was made."""

    def __init__(self) -> None:
        self._start, self._used = time.perf_counter(), time.process_time()

    def read(self) -> tuple[float, float]:
        """Return the seconds, and the share of all cores' time in them that this process had."""
        seconds = time.perf_counter() - self._start
        return seconds, (time.process_time() - self._used) / (seconds * cores())


@contextmanager
def silence() -> Iterator[None]:
    """Send what is written to the standard output meanwhile, by libraries too, nowhere."""
    sys.stdout.flush()
    kept = os.dup(1)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


class Contestant(Protocol):
    """A renderer with its scene loaded."""

    def render(self, samples: int, seed: int) -> Shot:
        """Render at least so many samples a pixel. Pictures of different seeds are independent."""

    def warm(self, samples: int) -> None:
        """Do what a picture of so many samples a pixel needs done once, as compiling."""


class LuxCore:
    """LuxCore's path tracer on the processor, with Cauchy's dispersion.

    What LuxCore takes as `interiorior` is Cauchy's A, which it reflects by, too; each refraction draws a
    wavelength of its own. Its pictures are adaptively sampled, as they are by default, from 64 samples on.
    """

    def __init__(
        self,
        view: View,
        sampler: str = "SOBOL",
        dispersion: bool = True,
        roulette: int | None = None,
        engine: str = "PATHCPU",
        light_traced: bool = False,
    ) -> None:
        try:
            with silence():  # it prints what libraries it loads
                pyluxcore: Any = importlib.import_module("pyluxcore")
        except ImportError as error:
            raise ContestantError(f"pyluxcore cannot be imported ({error}): pip install pyluxcore") from error
        self._lux = pyluxcore
        pyluxcore.Init(lambda _: None)
        self._view, self._scene = view, pyluxcore.Scene()
        self._settings = {
            "renderengine.type": engine,
            "native.threads.count": cores(),
            "sampler.type": sampler,
            "path.pathdepth.total": DEPTH,
            "path.pathdepth.diffuse": DEPTH,
            "path.pathdepth.glossy": DEPTH,
            "path.pathdepth.specular": DEPTH,
            "path.clamping.variance.maxvalue": 0.0,
            "film.width": view.size,
            "film.height": view.size,
            "film.filter.type": "BOX",
            "film.filter.width": 0.5,
            "film.imagepipelines.0.0.type": "NOP",
        }
        if engine == "BIDIRCPU":
            self._settings |= {"path.maxdepth": DEPTH, "light.maxdepth": DEPTH}
        if light_traced:  # of caustics, a share of all samples
            self._settings |= {"path.hybridbackforward.enable": True, "path.hybridbackforward.partition": 0.5}
        if roulette is not None:
            self._settings["path.russianroulette.depth"] = roulette
        mesh = tessellate(view.stone)
        positions, normals, faces = mesh.split()
        scene = self._scene
        scene.DefineMesh(
            "stone",
            [tuple(map(float, p)) for p in positions],
            [tuple(map(int, f)) for f in faces],
            [tuple(map(float, n)) for n in normals],
            None, None, None,
        )  # fmt: skip
        row = 2.0 / view.size  # without the shift LuxCore's picture is a row lower than Mitsuba's
        described: dict[str, Any] = {
            "scene.camera.type": "perspective",
            "scene.camera.lookat.orig": view.origin,
            "scene.camera.lookat.target": view.target,
            "scene.camera.up": (0.0, 0.0, 1.0),
            "scene.camera.fieldofview": view.angle,
            "scene.camera.screenwindow": (-1.0, 1.0, -1.0 - row, 1.0 - row),
            "scene.camera.lensradius": 0.0,
            "scene.camera.autofocus.enable": False,
            "scene.lights.around.type": "constantinfinite",
            "scene.lights.around.color": (view.environment,) * 3,
            "scene.materials.glass.type": "glass",
            "scene.materials.glass.kr": (1.0,) * 3,
            "scene.materials.glass.kt": (1.0,) * 3,
            "scene.materials.glass.interiorior": CAUCHY_A if dispersion else INDEX_D,
            "scene.materials.glass.exteriorior": 1.0,
            "scene.objects.stone.material": "glass",
            "scene.objects.stone.shape": "stone",
        }
        if dispersion:
            described["scene.materials.glass.cauchyb"] = CAUCHY_B
        for number, quad in enumerate(view.quads):
            name = f"quad{number}"
            corners = [tuple(map(float, corner)) for corner in quad.corners]
            scene.DefineMesh(name, corners, [(0, 1, 2), (0, 2, 3)], None, None, None, None)
            described |= {
                f"scene.materials.{name}.type": "matte",
                f"scene.materials.{name}.kd": (quad.reflectance,) * 3,
                f"scene.objects.{name}.material": name,
                f"scene.objects.{name}.shape": name,
            }
            if quad.radiance:
                # Power and efficiency 0: the emission is the radiance.
                described |= {
                    f"scene.materials.{name}.emission": (quad.radiance,) * 3,
                    f"scene.materials.{name}.emission.power": 0.0,
                    f"scene.materials.{name}.emission.efficency": 0.0,
                }
        scene.Parse(self._properties(described))

    def _properties(self, values: dict[str, Any]) -> Any:
        properties = self._lux.Properties()
        for key, value in values.items():
            properties.Set(self._lux.Property(key, list(value) if isinstance(value, tuple) else value))
        return properties

    def warm(self, samples: int) -> None:
        """Nothing: LuxCore has no kernels to compile."""

    def render(self, samples: int, seed: int) -> Shot:
        """Render until there are so many samples a pixel."""
        before = time.perf_counter()
        settings = self._properties({**self._settings, "renderengine.seed": seed + 1})
        session = self._lux.RenderSession(self._lux.RenderConfig(settings, self._scene))
        session.Start()
        clock = Clock()
        stats = session.GetStats()
        while True:
            session.UpdateStats()
            if stats.Get("stats.renderengine.pass").GetFloat() >= samples:
                break
            time.sleep(0.002)
        session.Pause()
        seconds, busy = clock.read()
        session.UpdateStats()
        size = self._view.size
        flat = np.zeros(size * size * 3, dtype=np.float32)
        session.GetFilm().GetOutputFloat(self._lux.FilmOutputType.RGB, flat, 0)
        total = stats.Get("stats.renderengine.pass").GetFloat()
        session.Stop()
        image = flat.reshape(size, size, 3)[::-1].astype(float)  # LuxCore's first row is the lowest
        besides = time.perf_counter() - before - seconds
        return Shot(image=image, seconds=seconds, busy=busy, samples=total, besides=besides)


def mitsuba_scene(
    mi: Any, view: View, integrator: dict[str, Any], sampler: str, stone: Any, spectrum: str = "rgb"
) -> Any:
    """Build the scene for the active variant.

    Parameters
    ----------
    integrator : dict
        What follows the rays.
    sampler : str
        What draws the samples.
    stone : mi.Shape or dict
        The stone, with its surface.
    spectrum : str
        Kind of Mitsuba's spectra: rgb, or uniform.
    """
    transform = mi.ScalarTransform4f
    described: dict[str, Any] = {
        "type": "scene",
        "integrator": integrator,
        "sensor": {
            "type": "perspective",
            "fov": view.angle,
            "to_world": transform().look_at(
                origin=list(view.origin), target=list(view.target), up=[0.0, 0.0, 1.0]
            ),
            "sampler": {"type": sampler},
            "film": {
                "type": "hdrfilm",
                "width": view.size,
                "height": view.size,
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
        },
        "around": {"type": "constant", "radiance": {"type": spectrum, "value": view.environment}},
        "stone": stone,
    }
    for number, quad in enumerate(view.quads):
        # The rectangle's corners are (+-1, +-1, 0), and its front is +z.
        x, y = quad.corners[1] - quad.corners[0], quad.corners[3] - quad.corners[0]
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x / 2, y / 2, np.cross(x, y) / 4
        matrix[:3, 3] = quad.corners.mean(axis=0)
        reflectance = {"type": spectrum, "value": quad.reflectance}
        described[f"quad{number}"] = {
            "type": "rectangle",
            "to_world": transform(matrix),
            "bsdf": {"type": "diffuse", "reflectance": reflectance},
        }
        if quad.radiance:
            light = {"type": "area", "radiance": {"type": spectrum, "value": quad.radiance}}
            described[f"quad{number}"]["light"] = light
    return load_scene(described)


class StockPath:
    """Mitsuba's own `path` with its own `dielectric`: no dispersion."""

    def __init__(self, view: View, sampler: str = "independent", roulette: int = 5) -> None:
        from gemrender.render.backend import ensure_variant

        ensure_variant("llvm_ad_rgb")
        import mitsuba as mi

        from gemrender.scene.mesh import stone_mesh

        mi.set_log_level(mi.LogLevel.Error)  # not that samples were rounded
        self._mi, self._view = mi, view
        integrator = {"type": "path", "max_depth": DEPTH, "rr_depth": roulette}
        glass = {"type": "dielectric", "int_ior": INDEX_D, "ext_ior": 1.0}
        self._scene = mitsuba_scene(mi, view, integrator, sampler, stone_mesh(view.stone, glass))

    def _passes(self, samples: int) -> tuple[int, int]:
        """Return the number of passes, and samples a pixel of each, that `WAVEFRONT` holds."""
        passes = -(-samples // max(WAVEFRONT // self._view.size**2, 1))
        return passes, -(-samples // passes)

    def warm(self, samples: int) -> None:
        """Render a pass: Dr.Jit compiles its kernels, if they have not been yet."""
        self.render(self._passes(samples)[1], 0)

    def render(self, samples: int, seed: int) -> Shot:
        """Render, in passes."""
        size = self._view.size
        passes, each = self._passes(samples)
        clock = Clock()
        total = np.zeros((size, size, 3))
        for number in range(passes):
            total += np.array(self._mi.render(self._scene, spp=each, seed=seed * PASSES + number))
        seconds, busy = clock.read()
        done = passes * self._scene.sensors()[0].sampler().sample_count()  # samplers may round it up
        return Shot(image=total / passes, seconds=seconds, busy=busy, samples=done)


class GemPath:
    """gemrender's `gem_path`, with the dispersion of diamond, as `gemrender render` runs it.

    Or with caustics of small lights found by chance, as they are from the eye.
    """

    def __init__(self, view: View, caustics: bool = True) -> None:
        from gemrender.render.backend import ensure_variant

        ensure_variant("llvm_ad_spectral")
        import mitsuba as mi

        from gemrender.scene.mesh import stone_mesh

        glass = {"type": "gem_dielectric", "material": "diamond"}
        stone = stone_mesh(view.stone, glass)
        self._caustics = caustics
        # Lights of equal energy: they look white where white is equal energy, as in the RGB contestants
        self._scene = mitsuba_scene(mi, view, {"type": "gem_path"}, "independent", stone, "uniform")

    def warm(self, samples: int) -> None:
        """Render a pass: Dr.Jit compiles its kernels, if they have not been yet."""
        self.render(min(samples, 2), 0)

    def render(self, samples: int, seed: int) -> Shot:
        """Render, in passes."""
        from gemrender.colorimetry import adapt, white_xyz, xyz_to_linear_srgb
        from gemrender.render.passes import Passes

        passes = Passes(self._scene, seed=seed, caustics=self._caustics)
        clock = Clock()
        while passes.samples < samples:
            passes.add(min(passes.samples_of_a_pass(), samples - passes.samples))
        xyz = passes.xyz
        seconds, busy = clock.read()
        image = xyz_to_linear_srgb(adapt(xyz, white_xyz("e"))).astype(float)
        return Shot(image=image, seconds=seconds, busy=busy, samples=passes.samples)


Builder = Callable[[View], Contestant]
#: What each contestant can be built as: the better one is to be taken. Keys are names for the tables.
BUILDERS: dict[str, dict[str, Builder]] = {
    "gem_path": {"as it is": GemPath},
    "gem_path by chance": {"caustics from the eye": partial(GemPath, caustics=False)},
    "path": {
        "independent, roulette from 5": StockPath,
        "independent, no roulette": partial(StockPath, roulette=DEPTH),
        "multijitter, roulette from 5": partial(StockPath, sampler="multijitter"),
        "multijitter, no roulette": partial(StockPath, sampler="multijitter", roulette=DEPTH),
    },
    "LuxCore": {
        "Sobol": LuxCore,
        "Sobol, no roulette": partial(LuxCore, roulette=DEPTH),
        "Metropolis": partial(LuxCore, sampler="METROPOLIS"),
        "random": partial(LuxCore, sampler="RANDOM"),
        "random, no roulette": partial(LuxCore, sampler="RANDOM", roulette=DEPTH),
        "Sobol, caustics from lights": partial(LuxCore, light_traced=True),
        "bidirectional": partial(LuxCore, engine="BIDIRCPU"),
        "bidirectional, Metropolis": partial(LuxCore, engine="BIDIRCPU", sampler="METROPOLIS"),
    },
}


def _serve(pipe: Connection, view: View, name: str, kind: str) -> None:
    """Build a contestant, and answer what comes through the pipe until it is closed."""
    try:
        start = time.perf_counter()
        contestant = BUILDERS[name][kind](view)
        pipe.send(time.perf_counter() - start)
        while True:
            samples, seed = pipe.recv()
            start = time.perf_counter()
            if seed is None:
                contestant.warm(samples)
                pipe.send(time.perf_counter() - start)
            else:
                pipe.send(contestant.render(samples, seed))
    except EOFError:
        os._exit(0)  # LuxCore may crash where Python takes it down
    except (ContestantError, GemrenderError) as error:
        pipe.send(ContestantError(str(error)))


class Remote:
    """A contestant in a process of its own.

    Attributes
    ----------
    setup : float
        What it took to load the renderer and to build the scene [s].
    """

    def __init__(self, view: View, name: str, kind: str) -> None:
        # A fresh home, so that Dr.Jit finds no kernels of earlier runs.
        self._home = tempfile.TemporaryDirectory(prefix="gemrender-benchmark-")
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, view, name, kind), daemon=True)
        with environment(HOME=self._home.name):
            self._process.start()
        theirs.close()
        self.setup: float = self._answer()

    def _answer(self) -> Any:
        try:
            answer = self._pipe.recv()
        except EOFError as error:
            self._process.join()
            raise ContestantError(f"its process ended with exit code {self._process.exitcode}") from error
        if isinstance(answer, ContestantError):
            raise answer
        return answer

    def warm(self, samples: int) -> float:
        """Do what a picture of so many samples a pixel needs done once; return its time [s]."""
        self._pipe.send((samples, None))
        return float(self._answer())

    def render(self, samples: int, seed: int) -> Shot:
        """Render so many samples a pixel, or some more."""
        self._pipe.send((samples, seed))
        shot: Shot = self._answer()
        return shot

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join(timeout=20)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()
        self._home.cleanup()


@contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set environment variables for processes started meanwhile."""
    before = {key: os.environ.get(key) for key in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for key, value in before.items():
            if value is None:
                del os.environ[key]
            else:
                os.environ[key] = value

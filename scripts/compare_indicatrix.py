"""Compare a birefringent stone with indicatrix's, an open renderer in Rust that no one here wrote.

    python scripts/compare_indicatrix.py [--stone inoue-3] [--pixels 64] [--samples 160] [--ours 128]
                                         [--reference 16] [--passes 8] [--chords 64] [--scale 10]
                                         [--seed 1] [--build FOLDER]

It needs `cargo` (https://rustup.rs), which builds a small program against one version of the crate in a
temporary folder; --build keeps that. Moissanite at 589.3 nm, of the same planes in both, a round girdle
being cut into chords. The eye is straight above, far away, under a uniform sky of radiance 1; from below the
horizon comes nothing. The mean radiance of each kind of crown facet, over pixels that show one facet alone,
is compared for one index (n_o in all directions), and for two with the optic axis upright and level.

The crate has no such sky. It is asked for the weight of each path in a furnace of radiance 1 and for where
the path goes in the end, both of which its API tells; here those that end above the horizon are counted.

Witnesses of our own are followed in numpy, to tell why the two differ. Of two indices: with the waves that
facets reflect (`gemrender.optics.crystals`), and with the crate's rule for them, by which the wave normal is
mirrored even where the mode changes, or its index with the direction. Of one index: unpolarised at each
facet, as ours is, and with fields, as the crate's is.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from gemrender.cuts import load_stone
from gemrender.optics import load_material
from gemrender.optics.crystals import Indicatrix, frame_of_c_axis, shares_entering, shares_inside
from gemrender.stone import Stone
from gemrender.stone.solid import convex_solid, with_chords

CRATE, GLAM = "0.9.0", "0.34"
MATERIAL, NM = "moissanite", 589.3
#: Kinds of facets that are compared: a round brilliant's crown.
ZONES = ("table", "star", "bezel", "upper_girdle")
#: Events that a path may have, in all; furnaces tell what that leaves out.
MOST_EVENTS = 1000
#: Weight below which the reference ends paths by chance.
ROULETTE = 0.05
#: Half the side of the square window [girdle radius].
HALF_WIDTH = 1.0
#: Height at which rays start [girdle radius].
HEIGHT = 2.0

MANIFEST = f"""[package]
name = "ends"
version = "0.0.0"
edition = "2024"

[dependencies]
indicatrix = "={CRATE}"
glam = "{GLAM}"
"""

# Numbers in and out are single-precision, little-endian. In: n_o, n_e - n_o, c axis (3), how many planes,
# rays and events, seed; planes (4 each), rays (6 each). Out, for each ray: weight and direction (3).
PROGRAM = """
use glam::Vec3;
use indicatrix::geometry::plane::GpuFacetPlane;
use indicatrix::geometry::tool::StoneGeometry;
use indicatrix::optics::fluorescence::Fluorescence;
use indicatrix::optics::materials::GemMaterial;
use indicatrix::optics::raytracer as rt;
use indicatrix::renderer::env_map::EnvironmentMap;
use std::io::{Read, Write};

fn main() {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).unwrap();
    let all: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let (head, rest) = all.split_at(9);
    let (n_planes, events, seed) = (head[5] as usize, head[7] as u32, head[8] as u32);
    let mut material = GemMaterial::new_custom("one wavelength", head[0], 0.0, head[1], [0.0; 3]);
    material.c_axis = Vec3::new(head[2], head[3], head[4]);
    let (planes, rays) = rest.split_at(4 * n_planes);
    assert_eq!(rays.len(), 6 * head[6] as usize);
    let planes: Vec<GpuFacetPlane> =
        planes.chunks_exact(4).map(|p| GpuFacetPlane::new(Vec3::new(p[0], p[1], p[2]), -p[3])).collect();
    let arena = rt::build_plane_soa(&planes);
    let furnace = EnvironmentMap::uniform(4, 4, [1.0; 3]);
    let sky = rt::EnvironmentSource::HdrMap(&furnace);
    let trace = |origin: Vec3, dir: Vec3, seed: u32| {
        rt::trace_spectral_ray_attributed_soa_geom(
            rt::Ray { origin, dir }, StoneGeometry::planes_only(&planes), &arena, &[], &material,
            Fluorescence::none(), events, sky, seed, 0.5, None,
        )
    };
    let open = trace(Vec3::new(0.0, 1e3, 0.0), Vec3::Y, 1).0.y;
    let mut out = Vec::with_capacity(16 * rays.len() / 6);
    for (i, ray) in rays.chunks_exact(6).enumerate() {
        let own = rt::hash_u32((i as u32).wrapping_mul(0x9E37_79B1) ^ rt::hash_u32(seed));
        let (xyz, path) = trace(Vec3::new(ray[0], ray[1], ray[2]), Vec3::new(ray[3], ray[4], ray[5]), own);
        let to = path.escaped_dir.unwrap_or(Vec3::ZERO);
        for value in [xyz.y / open, to.x, to.y, to.z] {
            out.extend_from_slice(&value.to_le_bytes());
        }
    }
    std::io::stdout().write_all(&out).unwrap();
}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A stone of one index or two; `c_axis` is a unit vector."""

    name: str
    ordinary: float
    extraordinary: float
    c_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    @property
    def birefringent(self) -> bool:
        """Whether it has two indices."""
        return self.ordinary != self.extraordinary

    @property
    def indicatrix(self) -> Indicatrix:
        """Its indices and axes."""
        return Indicatrix.uniaxial(self.ordinary, self.extraordinary, frame_of_c_axis(self.c_axis))


def make_cases() -> list[Case]:
    """Return the stone of one index, and that with the optic axis upright and level."""
    crystal = load_material(MATERIAL).crystal
    assert crystal is not None
    o, e = (float(n) for n in crystal.principal_indices(NM))
    return [
        Case(name="one index, n_o", ordinary=o, extraordinary=o),
        Case(name="c upright", ordinary=o, extraordinary=e),
        Case(name="c level", ordinary=o, extraordinary=e, c_axis=(1.0, 0.0, 0.0)),
    ]


def with_flat_girdle(stone: Stone, chords: int) -> Stone:
    """Return the stone with its round girdle cut into chords: planes alone, which the crate takes."""
    if not stone.is_round:
        return stone
    planes = with_chords(stone.solid.planes, chords)
    facet = np.append(stone.solid.facet, np.full(chords, stone.solid.n_facets - 1))
    return Stone(solid=convex_solid(planes, facet)[0], facets=stone.facets, name=stone.name)


# ---- Pixels ----


@dataclass(frozen=True, slots=True, kw_only=True)
class Pixels:
    """Pixels that show one facet alone: rows and columns from the top left, and which of `ZONES` it is."""

    rows: np.ndarray
    columns: np.ndarray
    zones: np.ndarray
    side: float

    def points(self, samples: int, rng: np.random.Generator) -> np.ndarray:
        """Return points evenly drawn in each pixel, (pixels, samples, 2)."""
        u = rng.random((len(self.rows), samples, 2))
        x = -HALF_WIDTH + self.side * (self.columns[:, None] + u[..., 0])
        y = HALF_WIDTH - self.side * (self.rows[:, None] + u[..., 1])
        return np.stack([x, y], axis=-1)

    def means(self, of_pixels: np.ndarray) -> np.ndarray:
        """Return the mean over each zone, and over all pixels, (zones + 1)."""
        parts = [self.zones == zone for zone in range(len(ZONES))]
        return np.array([of_pixels[part].mean() for part in parts] + [of_pixels.mean()])


def pixels_of(stone: Stone, count: int) -> Pixels:
    """Find the pixels whose four corners are on one facet, which is convex from above."""
    ticks = np.linspace(-HALF_WIDTH, HALF_WIDTH, count + 1)
    x, y = np.meshgrid(ticks, -ticks)
    xy = np.stack([x.ravel(), y.ravel()], axis=-1)
    normals, offsets = stone.solid.planes[:, :3], stone.solid.planes[:, 3]
    up, level = normals[:, 2] > 1e-8, np.abs(normals[:, 2]) <= 1e-8
    inside = (xy @ normals[level, :2].T <= offsets[level]).all(axis=1)
    height = (offsets[up] - xy @ normals[up, :2].T) / normals[up, 2]
    facet = np.where(inside, stone.solid.facet[up][np.argmin(height, axis=1)], -1).reshape(count + 1, -1)
    corners = np.stack([facet[:-1, :-1], facet[1:, :-1], facet[:-1, 1:], facet[1:, 1:]])
    one = (corners == corners[0]).all(axis=0) & (corners[0] >= 0)
    zone_of = np.array([ZONES.index(kind) if kind in ZONES else -1 for kind in stone.facet_kinds])
    zone = np.where(one, zone_of[corners[0]], -1)
    rows, columns = np.nonzero(zone >= 0)
    return Pixels(rows=rows, columns=columns, zones=zone[rows, columns], side=2 * HALF_WIDTH / count)


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """Mean radiance of each zone, and of all, with standard errors; (zones + 1) each."""

    mean: np.ndarray
    error: np.ndarray
    seconds: float

    @classmethod
    def of_passes(cls, passes: Sequence[np.ndarray], seconds: float) -> Found:
        """Return the mean of independent passes, and the error that their scatter tells."""
        error = np.std(passes, axis=0, ddof=1) / np.sqrt(len(passes))
        return cls(mean=np.mean(passes, axis=0), error=error, seconds=seconds)


# ---- indicatrix ----


def build(folder: Path) -> Path:
    """Build the program, and return it."""
    (folder / "src").mkdir(parents=True, exist_ok=True)
    (folder / "Cargo.toml").write_text(MANIFEST, encoding="utf-8")
    (folder / "src" / "main.rs").write_text(PROGRAM, encoding="utf-8")
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=folder, check=True)
    return folder / "target" / "release" / "ends"


def _y_up(vectors: np.ndarray) -> np.ndarray:
    return np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)


def indicatrix_paths(
    program: Path, stone: Stone, case: Case, xy: np.ndarray, seed: int, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """Follow rays from straight above through points (n, 2) with the crate, one path each.

    Returns
    -------
    weight, radiance : (n,) float64
        What each path brings in a furnace, and of the sky alone.
    """
    planes = np.column_stack([_y_up(stone.solid.planes[:, :3]), scale * stone.solid.planes[:, 3]])
    rays = np.zeros((len(xy), 6))
    rays[:, :3] = _y_up(scale * np.column_stack([xy, np.full(len(xy), HEIGHT)]))
    rays[:, 4] = -1
    head = [case.ordinary, case.extraordinary - case.ordinary, *_y_up(np.array(case.c_axis))]
    head += [len(planes), len(rays), MOST_EVENTS, seed]
    sent = np.concatenate([np.array(head), planes.ravel(), rays.ravel()]).astype("<f4").tobytes()
    done = subprocess.run([program], input=sent, stdout=subprocess.PIPE, check=True)
    out = np.frombuffer(done.stdout, "<f4").reshape(-1, 4).astype(np.float64)
    return out[:, 0], np.where(out[:, 2] > 0, out[:, 0], 0.0)


def passes_of(
    pixels: Pixels, samples: int, passes: int, seed: int, bring: Callable[[np.ndarray, int], np.ndarray]
) -> Found:
    """Render in independent passes; `bring` tells what rays through points bring, for a seed."""
    begun = time.perf_counter()
    each = max(1, samples // passes)
    found = []
    for number in range(passes):
        own = seed * passes + number
        xy = pixels.points(each, np.random.default_rng(own))
        found.append(pixels.means(bring(xy.reshape(-1, 2), own).reshape(-1, each).mean(axis=1)))
    return Found.of_passes(found, time.perf_counter() - begun)


# ---- gemrender ----


def gemrender_radiance(
    stone: Stone, case: Case, pixels: Pixels, count: int, passes: int, samples: int, seed: int
) -> Found:
    """Render with `gem_path`, in so many passes of so many samples a pixel."""
    from gemrender.render.backend import ensure_variant
    from gemrender.render.passes import Passes
    from gemrender.scene.loading import load_scene
    from gemrender.scene.mesh import stone_mesh

    ensure_variant("llvm_ad_spectral")
    surface = {
        "type": "gem_dielectric", "material": MATERIAL, "dispersion": False, "c_axis": list(case.c_axis),
        "birefringence": case.birefringent,
    }  # fmt: skip
    half = HALF_WIDTH
    scene = load_scene({
        "type": "scene",
        "integrator": {"type": "gem_path"},
        "sensor": {
            "type": "gem_orthographic", "sampling": "area", "distance": HEIGHT,
            "x_min": -half, "x_max": half, "y_min": -half, "y_max": half,
            "film": {"type": "hdrfilm", "width": count, "height": count},
        },
        "sky": {"type": "gem_hemisphere"},
        "stone": stone_mesh(stone, surface),
    })  # fmt: skip
    begun = time.perf_counter()
    ours = Passes(scene)
    found = [
        pixels.means(
            ours.radiance_at(NM, samples, seed=seed * passes + number)[0][pixels.rows, pixels.columns]
        )
        for number in range(passes)
    ]
    return Found.of_passes(found, time.perf_counter() - begun)


# ---- The reference, in numpy ----


def _next_facet(planes: np.ndarray, p: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which plane rays inside meet next, and how far it is."""
    along = d @ planes[:, :3].T
    gap = planes[:, 3] - p @ planes[:, :3].T
    t = np.where(along > 1e-12, np.maximum(gap, 0) / np.where(along > 1e-12, along, 1), np.inf)
    facet = np.argmin(t, axis=1)
    return facet, t[np.arange(len(t)), facet]


def _entry(planes: np.ndarray, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the plane that rays from straight above meet, and where."""
    up = np.nonzero(planes[:, 2] > 1e-8)[0]
    height = (planes[up, 3] - xy @ planes[up, :2].T) / planes[up, 2]
    first = np.argmin(height, axis=1)
    return up[first], np.column_stack([xy, height[np.arange(len(xy)), first]])


def _mirrored(
    k: np.ndarray, normal: np.ndarray, mode: np.ndarray, crystal: Indicatrix, total: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return wave vectors and rays of both modes by the crate's rule, (n, 2, 3) each.

    The wave normal is mirrored whatever the modes are; the ray is the wave normal, or after total reflection
    that of the mode that came.
    """
    unit = k / np.linalg.norm(k, axis=-1, keepdims=True)
    unit = unit - 2 * np.sum(unit * normal, axis=-1, keepdims=True) * normal
    c, (eps_o, _, eps_e) = crystal.frame[2], crystal.permittivities
    square = (unit @ c) ** 2
    index = np.stack(
        [np.full(len(unit), np.sqrt(eps_o)), (square / eps_o + (1 - square) / eps_e) ** -0.5], axis=-1
    )
    off = unit * eps_o + (eps_e - eps_o) * (unit @ c)[:, None] * c
    off /= np.linalg.norm(off, axis=-1, keepdims=True)
    ray = np.where((total & (mode == 1))[:, None], off, unit)
    return index[..., None] * unit[:, None, :], np.repeat(ray[:, None, :], 2, axis=1)


def reference_radiance(stone: Stone, case: Case, xy: np.ndarray, seed: int, *, mirrored: bool) -> np.ndarray:
    """Return what rays from straight above through points (n, 2) bring, by chance, with either rule."""
    planes, crystal = stone.solid.planes, case.indicatrix
    rng = np.random.default_rng(seed)
    facet, p = _entry(planes, xy)
    down = np.broadcast_to([0.0, 0.0, -1.0], p.shape)
    entering = shares_entering(planes[facet, :3], down, crystal)
    out = np.where(entering.outside[:, 2] > 0, entering.reflected, 0.0)
    at = np.arange(len(xy))
    shares, k, ray, weight = entering.transmitted, entering.k, entering.ray, np.ones(len(xy))
    for _ in range(MOST_EVENTS):
        total = shares.sum(axis=1)
        weight = weight * total
        survival = np.minimum(weight / ROULETTE, 1.0)
        on = rng.random(len(at)) < survival
        if not on.any():
            break
        mode = (rng.random(len(at)) * total >= shares[:, 0]).astype(int)[on]
        weight = (weight / np.where(survival > 0, survival, 1))[on]
        chosen = np.arange(len(mode)), mode
        at, p, k, ray = at[on], p[on], k[on][chosen], ray[on][chosen]
        facet, t = _next_facet(planes, p, ray)
        p = p + t[:, None] * ray
        normal = planes[facet, :3]
        met = shares_inside(normal, k, mode, crystal)
        leaves = met.transmitted.sum(axis=1)
        np.add.at(out, at, np.where(met.outside[:, 2] > 0, weight * leaves, 0.0))
        shares, came = met.reflected, k
        k, ray = _mirrored(came, normal, mode, crystal, leaves == 0) if mirrored else (met.k, met.ray)
    return out


def polarised_radiance(stone: Stone, index: float, xy: np.ndarray, seed: int, *, keeps: bool) -> np.ndarray:
    """Return what rays from straight above bring of a stone of one index; `keeps`: they stay polarised.

    Unpolarised light is two fields (n, 2, 3) that have nothing to do with one another, so scaled that their
    squares are energies.
    """
    planes, rng = stone.solid.planes, np.random.default_rng(seed)
    facet, p = _entry(planes, xy)
    d = np.tile([0.0, 0.0, -1.0], (len(xy), 1))
    normal, at = planes[facet, :3], np.arange(len(xy))
    cos_i = -np.sum(d * normal, axis=1)
    cos_t = np.sqrt(1 - (1 - cos_i**2) / index**2)
    s = _across(d, normal)
    r = np.stack([(cos_i - index * cos_t), (index * cos_i - cos_t)], axis=1)
    r /= np.stack([(cos_i + index * cos_t), (index * cos_i + cos_t)], axis=1)
    going_up = (d + 2 * cos_i[:, None] * normal)[:, 2] > 0
    out = np.where(going_up, (r**2).sum(axis=1) / 2, 0.0)
    d = d / index + (cos_i / index - cos_t)[:, None] * normal
    a = np.tile(np.eye(2) / np.sqrt(2), (len(xy), 1, 1)) * np.sqrt(1 - r**2)[:, None, :]  # along s and p
    for _ in range(MOST_EVENTS):
        frame = np.stack([s, np.cross(d, s)], axis=1)
        field = a @ frame
        energy = (np.abs(a) ** 2).sum(axis=(1, 2))
        survival = np.minimum(energy / ROULETTE, 1.0)
        on = rng.random(len(at)) < survival
        if not on.any():
            break
        if not keeps:
            field = np.sqrt(energy / 2)[:, None, None] * frame
        field = field[on] / np.sqrt(survival[on])[:, None, None]
        at, p, d = at[on], p[on], d[on]
        facet, t = _next_facet(planes, p, d)
        p, normal = p + t[:, None] * d, planes[facet, :3]
        cos_i = np.sum(d * normal, axis=1)
        square = 1 - index**2 * (1 - cos_i**2)
        cos_t = np.sqrt(square + 0j)
        s = _across(d, normal)
        a = field @ np.stack([s, np.cross(d, s)], axis=2)
        r = np.stack([(index * cos_i - cos_t), (cos_i - index * cos_t)], axis=1)
        r /= np.stack([(index * cos_i + cos_t), (cos_i + index * cos_t)], axis=1)
        leaves = (np.abs(a) ** 2 * (1 - np.abs(r) ** 2)[:, None, :]).sum(axis=(1, 2))
        rise = index * d[:, 2] + (cos_t.real - index * cos_i) * normal[:, 2]
        np.add.at(out, at, np.where((square > 0) & (rise > 0), leaves, 0.0))
        a = a * r[:, None, :]
        d = d - 2 * cos_i[:, None] * normal
    return out


def _across(d: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return unit vectors across directions and normals, any across the direction where these are one."""
    s = np.cross(d, normal)
    alike = np.linalg.norm(s, axis=1) < 1e-9
    s[alike] = np.cross(d[alike], [0.6, 0.0, 0.8]) + np.cross(d[alike], [0.0, 1e-3, 0.0])
    return np.asarray(s / np.linalg.norm(s, axis=1, keepdims=True))


def witnesses(stone: Stone, case: Case) -> dict[str, Callable[[np.ndarray, int], np.ndarray]]:
    """Return the witnesses of a case: what rays through points bring, for a seed."""
    if case.birefringent:
        by_waves = partial(reference_radiance, stone, case)
        return {"exact": partial(by_waves, mirrored=False), "mirrored": partial(by_waves, mirrored=True)}
    by_fields = partial(polarised_radiance, stone, case.ordinary)
    return {"unpolarised": partial(by_fields, keeps=False), "polarised": partial(by_fields, keeps=True)}


# ---- Printing ----


def print_case(case: Case, pixels: Pixels, ours: Found, others: dict[str, Found]) -> None:
    """Print one case: our means, and others' ratios to them."""
    print(
        f"\n{case.name}: n_o {case.ordinary:.5f}, n_e {case.extraordinary:.5f} (in brackets: standard errors)"
    )
    print(
        f"  {'zone':<14}{'pixels':>7}{'ours':>9}{'error':>9}"
        + "".join(f"{name + ' / ours - 1':>34}" for name in others)
    )
    counts = [*np.bincount(pixels.zones, minlength=len(ZONES)), len(pixels.zones)]
    for row, name in enumerate((*ZONES, "all")):
        line = f"  {name:<14}{counts[row]:>7}{ours.mean[row]:>9.5f}{ours.error[row]:>9.5f}"
        for other in others.values():
            off = other.mean[row] / ours.mean[row] - 1
            error = np.hypot(other.error[row], ours.error[row]) / ours.mean[row]
            line += f"{100 * off:>+16.3f} +- {100 * error:.3f} % ({off / error:>+6.1f})"
        print(line)
    spent = ", ".join(f"{name} {found.seconds:.0f} s" for name, found in {"ours": ours, **others}.items())
    print(f"  {spent}", flush=True)


def main() -> None:
    """Build, render, and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stone", default="inoue-3", help="a bundled stone, or a file: a round brilliant")
    parser.add_argument("--pixels", type=int, default=64, help="pixels a side")
    parser.add_argument("--samples", type=int, default=160, help="indicatrix's paths a pixel")
    parser.add_argument("--ours", type=int, default=128, help="our samples a pixel")
    parser.add_argument("--reference", type=int, default=16, help="the reference's paths a pixel; 0 is none")
    parser.add_argument("--passes", type=int, default=8, help="independent passes of each, at least 2")
    parser.add_argument("--chords", type=int, default=64, help="what a round girdle is cut into")
    parser.add_argument("--scale", type=float, default=10.0, help="size of a girdle radius in indicatrix")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--build", type=Path, metavar="FOLDER", help="where to build, to be kept")
    options = parser.parse_args()
    if shutil.which("cargo") is None:
        parser.exit(2, "cargo is not there; install Rust from https://rustup.rs\n")

    stone = load_stone(options.stone)
    if not stone.is_convex or not set(ZONES) <= set(stone.facet_kinds):
        parser.exit(2, f"stone {options.stone}: must be a round brilliant\n")
    stone = with_flat_girdle(stone, options.chords)
    pixels = pixels_of(stone, options.pixels)
    with tempfile.TemporaryDirectory() as temporary:
        begun = time.perf_counter()
        program = build((options.build or Path(temporary)).resolve())
        print(f"indicatrix {CRATE}, built in {time.perf_counter() - begun:.0f} s")
        for case in make_cases():
            lost: list[float] = []

            def theirs(xy: np.ndarray, seed: int, case: Case = case, lost: list[float] = lost) -> np.ndarray:
                weight, radiance = indicatrix_paths(program, stone, case, xy, seed, options.scale)
                lost.append(1 - float(weight.mean()))
                return radiance

            others = {"indicatrix": passes_of(pixels, options.samples, options.passes, options.seed, theirs)}
            for name, witness in witnesses(stone, case).items() if options.reference else ():
                others[name] = passes_of(pixels, options.reference, options.passes, options.seed + 1, witness)
            ours = gemrender_radiance(
                stone,
                case,
                pixels,
                options.pixels,
                options.passes,
                options.ours // options.passes,
                options.seed,
            )
            print_case(case, pixels, ours, others)
            error = np.std(lost, ddof=1) / np.sqrt(len(lost))
            print(f"  indicatrix loses {np.mean(lost):.1e} +- {error:.1e} in a furnace")


if __name__ == "__main__":
    main()

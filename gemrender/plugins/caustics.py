"""Light that stones throw on the surfaces around them, traced from the lights to the camera."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.plugins.branches import is_diffuse
from gemrender.plugins.checks import SceneCheck, is_stone
from gemrender.plugins.emission import Emission
from gemrender.plugins.modes import walk_modes
from gemrender.plugins.projection import Projection
from gemrender.plugins.spectra import mean_of
from gemrender.plugins.stones import RAY_OFFSET, Stones
from gemrender.plugins.tracing import instances_held
from gemrender.plugins.walk import LATE, LATE_SURVIVAL, walk
from gemrender.scene.sobol import TEA_ROUNDS, sobol

__all__ = ["Caustics"]

#: Numbers that a ray is drawn by: light, place on it (2), stone, direction (2), wavelength.
_NUMBERS = 7
#: Sums are of whole numbers, of which one is so much of what a ray commonly counts: the order of a sum of
#: whole numbers makes no difference. They hold 2^39 such counts.
_FINENESS = 2.0**24
#: Rays from the lights for each camera sample.
RAYS_A_SAMPLE = 1.0


class Caustics:
    r"""Traces light of small lamps through stones to diffuse surfaces, and from those to the camera.

    In Heckbert's notation (1990), with s a small light and L any, S a stone's surface, D a diffuse one, X
    any, and E the eye, light is parted by its path:

    ====================  =============================================================================
    Paths                 Followed from
    ====================  =============================================================================
    ``s S+ D E``          through one stone both, weighted by how densely either finds them; through
                          several the light, by this class
    ``s S+ D X* D E``     the light, by this class
    all others            the eye, by `gem_path`: what comes straight from lights (``L D X* E``), what
                          is seen in stones (``L X* S E``), what passes mirrors or glossy surfaces before
                          or after the diffuse one (``s S+ G X* E``, ``s S+ D X* G E``, ``s G S+ D E``),
                          and light of large lamps
    ====================  =============================================================================

    So no path counts twice, and none is left out: a path is the light's if its lamp is small and, counted
    from the eye, its first surface is diffuse, and so is the last one before the stones that part it from the
    lamp. `gem_path` leaves out light that it finds so when it is told what is traced, but for its share. A
    surface is diffuse when all parts of its BSDF are: paper, velvet and plain grounds are, skin (which
    shines), metals and glass are not, and light that passes one of these between lamp and stone, or between
    stone and the first diffuse surface, is the eye's. A light is small by the solid angle that the stones see
    it under (see `Emission`), as points and directions are. A sky is one light, an image or a studio of boxes
    too: it is traced as a whole where what is bright in it is small, as a sun in a dim sky; small boxes
    beside large ones are left to the eye with it.

    S is any surface of a stone, a rough girdle too: `walk`, from the light as from the eye, scatters there as
    `split` does (see `rough`), and goes on. Things of ground glass are no stones.

    From the eye such a path is found only when a ray off the paper happens to meet the light through the
    stone; from the light each one lands on the paper. Paths through one stone, which are most, are counted
    both ways, each by its share of the density of both (balance heuristic, Veach 1997, section 9.2.2): per
    etendue, which stones leave as it is, light's rays have the density that `Emission.density` tells, and
    the eye's that of their places by 1 / pi of diffuse surfaces, for each wavelength that goes by itself.
    Where a rough girdle scatters these are not quite the densities; the shares of a path add up to 1 still.

    Parameters
    ----------
    scene : mi.Scene
        Scene of a spectral variant.
    sensor : mi.Sensor
        The camera.
    check : SceneCheck
        What has checked the scene.
    max_depth : int
        As of `gem_path`.

    Attributes
    ----------
    rays_a_sample : float
        Rays from the lights for each camera sample, which the shares of both are for.
    any : bool
        Whether there is light to trace: there are stones, diffuse surfaces and small lights, and lights and
        camera are of known kinds.
    """

    def __init__(self, scene: mi.Scene, sensor: mi.Sensor, check: SceneCheck, max_depth: int) -> None:
        self._scene, self._check, self._max_depth = scene, check, max_depth
        self.rays_a_sample = RAYS_A_SAMPLE
        shapes = [shape for shape in scene.shapes() if is_stone(shape)]
        self._projection: Any = None
        self.any = False
        diffuse = any(_scatters(shape.bsdf()) for shape in scene.shapes() if not is_stone(shape))
        if not (mi.is_spectral and shapes and diffuse and Emission.known(scene) and scene.emitters()):
            return
        try:
            self._projection = Projection(sensor)
        except ValueError:
            return
        with dr.suspend_grad():
            self._emission = Emission(scene, shapes)
        if not self._emission.n_emitters:
            return
        numbers = dr.reinterpret_array(mi.UInt32, scene.emitters_dr())
        of_emitters = np.asarray(numbers)
        table = np.zeros(int(of_emitters.max()) + 1, dtype=bool)
        table[of_emitters[self._emission.small]] = True
        self._traced = mi.Bool(table)
        middle = np.mean([np.array(s.bbox().center(), dtype=np.float64).ravel() for s in shapes], axis=0)
        typical = self._emission.mean_weight * self._projection.typical(middle)
        self.any = 0 < typical < float("inf")
        self._unit = float(typical / _FINENESS)

    def trace(self, number: mi.UInt32, key: mi.UInt32, splat: Any, draw: Any) -> None:
        """Send out rays, and hand on what they count in the picture.

        Parameters
        ----------
        number, key : UInt32
            Of each ray its number, rays of other numbers being spread between these, and the seed: of other
            ones they are independent.
        splat : callable
            Called with the place in the film, (0, 0) to (1, 1), the wavelengths' values in units of `unit`,
            the surface that is seen there (a shape), and which of the rays count; once, while the kernel is
            made.
        draw : callable
            Makes wavelengths of a number in [0, 1).
        """
        with dr.suspend_grad(), instances_held():
            keys = [mi.sample_tea_32(key, mi.UInt32(k), TEA_ROUNDS)[0] for k in range(_NUMBERS)]
            u = sobol(number, keys)
            a, b = mi.sample_tea_32(number, key, TEA_ROUNDS)
            chance = mi.PCG32(1, mi.UInt64(a), mi.UInt64(b))
            wavelengths = draw(u[6])
            ray, weight, density = self._emission.sample(u[:6], wavelengths)
            sampler = _Numbers(chance)
            stones = Stones(self._scene, sampler, self._check)
            weight *= dr.opaque(mi.Float, 1 / self._unit)
            self._walks(stones, ray, weight, density, chance, splat)

    def traces(self, emitter: mi.EmitterPtr) -> mi.Bool:
        """Return whether a light is one of those whose light is traced."""
        return dr.gather(mi.Bool, self._traced, dr.reinterpret_array(mi.UInt32, emitter))

    def seen(self, p: mi.Point3f, n: mi.Normal3f) -> mi.Float:
        """Return how densely the eye sends rays off diffuse surfaces that it sees, for each of light's.

        Parameters
        ----------
        p, n : Point3f, Normal3f
            Places on the surfaces, and the normals there.

        Returns
        -------
        Float
            Density [1/etendue] of rays of one wavelength.
        """
        return self._projection.density(p, n) * (dr.inv_pi / self.rays_a_sample)

    def of_eye(
        self,
        seen: mi.Float,
        emitter: mi.EmitterPtr,
        si: mi.SurfaceInteraction3f,
        ray: mi.Ray3f,
        active: mi.Bool,
    ) -> mi.Float:
        """Return the share of light that the eye counts, of which `trace` counts the rest; see the class.

        It is 1 of lights that are not traced.

        Parameters
        ----------
        seen : Float
            As `seen` tells, of the surface that the ray left through one stone, times the wavelengths that go
            by themselves; 0 where the way was another: all is the light's then.
        emitter, si, ray : EmitterPtr, SurfaceInteraction3f, Ray3f
            The light, where the ray meets it, and the ray.
        active : Bool
            Where the light came through stones alone from the last diffuse surface, the first one being so.
        """
        traced = active & self.traces(emitter)
        both = traced & (seen > 0)
        of_light = self._emission.density(emitter, dr.select(si.is_valid(), si.p, ray.o), si.n, -ray.d, both)
        return dr.select(traced, dr.select(both, seen / (seen + of_light), 0), 1)

    @property
    def unit(self) -> float:
        """What a value of 1 handed to `splat` is, of flux times importance."""
        return self._unit

    @dr.syntax
    def _walks(self, stones, ray, β, density, chance, splat):  # type: ignore[no-untyped-def]  # dr.syntax
        scene, projection = self._scene, self._projection
        max_depth = mi.UInt32(self._max_depth if self._max_depth >= 0 else 0xFFFFFFFF)
        context = mi.BSDFContext(mi.TransportMode.Importance)
        ray = mi.Ray3f(ray)
        sent = mean_of(β)
        active = sent > 0
        parted = mi.Bool(False)
        depth = mi.UInt32(0)  # segments before the next
        through = mi.Bool(False)  # whether it has been through a stone
        again = mi.Bool(False)  # whether it has been through another one
        landed = mi.Bool(False)  # whether it has been through a stone and then met a diffuse surface

        while dr.hint(active, label="caustics"):
            si = scene.ray_intersect(ray, mi.RayFlags.AllNonDifferentiable, False, active)
            active &= si.is_valid() & (depth + 2 <= max_depth)
            stone = stones.of(si, active)
            on_stone = active & (stone != 0)
            bsdf = si.bsdf(ray)
            diffuse = active & ~on_stone & is_diffuse(bsdf.flags())
            # The first surface after the stones must be diffuse: others are left to gem_path
            plain = active & ~on_stone & (landed | (through & diffuse))
            diffuse &= plain

            # ---- To the camera ----

            place, to_camera, distance, importance = projection.connect(
                si.p, mi.Point2f(chance.next_float32(), chance.next_float32())
            )
            sees = diffuse & (importance > 0)
            wo = si.to_local(to_camera)
            value = bsdf.eval(context, si, wo, sees)
            # What shading normals take from one direction of light and not from the other (Veach 1997, 5.3.2)
            off = dr.dot(si.n, to_camera) * mi.Frame3f.cos_theta(si.wi)
            off *= dr.rcp(mi.Frame3f.cos_theta(wo) * dr.dot(si.n, -ray.d))
            counts = β * value * (importance * dr.abs(off))
            seen = self.seen(si.p, si.n) * dr.select(parted, mi.Float(stones.n_ways), 1)
            counts *= dr.select(landed | again, 1, density / (density + seen))
            sees &= (dr.max(counts) > 0) & dr.isfinite(dr.max(counts))
            shadow = si.spawn_ray(to_camera)
            shadow.maxt = distance * (1 - mi.math.ShadowEpsilon)
            sees &= ~scene.ray_test(shadow, sees)
            splat(place, ray.wavelengths, counts, si.shape, sees)

            # ---- On, off a surface ----

            bs, weight = bsdf.sample(
                context,
                si,
                chance.next_float32(),
                mi.Point2f(chance.next_float32(), chance.next_float32()),
                plain,
            )
            next_ray = si.spawn_ray(si.to_world(bs.wo))
            ray.o = dr.select(plain, next_ray.o, ray.o)

            # ---- Through a stone ----

            n = stones.outward(si, stone, active)
            arrives = on_stone & (dr.dot(n, ray.d) < 0)
            behind = on_stone & ~arrives
            ray.o = dr.select(behind, si.p + RAY_OFFSET * stones.size * ray.d, ray.o)
            part = arrives & ~parted & stones.disperses(stone, arrives)
            entering = stones.first_for_all(β, part)
            eta = stones.index(stone, ray.wavelengths, arrives)
            index = stones.of_channel(eta, stones.alive(entering))
            birefringent = mi.Bool(False)
            if dr.hint(stones.crystals.any, mode="scalar"):
                birefringent = stones.crystals.among(stone, arrives)
            o, d, β_out, depth_out, left = walk(
                stones,
                stone,
                si.p,
                ray.d,
                n,
                entering,
                index,
                ray.wavelengths,
                chance,
                depth,
                max_depth,
                arrives & ~birefringent,
            )
            if dr.hint(stones.crystals.any, mode="scalar"):
                nm = stones.nm_of(stone, ray.wavelengths, stones.alive(entering), arrives)
                of_modes = walk_modes(
                    stones,
                    stone,
                    si.p,
                    ray.d,
                    n,
                    entering,
                    nm,
                    ray.wavelengths,
                    chance,
                    depth,
                    max_depth,
                    arrives & birefringent,
                )
                o, d, β_out, depth_out, left = dr.select(
                    birefringent, of_modes, (o, d, β_out, depth_out, left)
                )
            ray.o = dr.select(arrives, o, ray.o)
            ray.d = dr.select(arrives, d, dr.select(plain, next_ray.d, ray.d))
            β = dr.select(arrives, β_out, dr.select(plain, β * weight, β))
            parted |= part
            depth = dr.select(arrives, depth_out, depth + 1)
            again |= arrives & through
            through |= arrives
            landed |= plain
            active = behind | plain | left

            # ---- Russian roulette: all rays that are left carry alike; late ones end by chance ----

            q = dr.minimum(mean_of(β) / sent, 1)
            q = dr.select(depth > LATE, q * LATE_SURVIVAL, q)
            active &= (q > 0) & (chance.next_float32() < q)
            β *= dr.select(active, dr.rcp(q), 0)
            ray.maxt = dr.largest(mi.Float)


def _scatters(bsdf: mi.BSDF) -> bool:
    """Return whether a BSDF is diffuse, and not black all over, as lamps often are that only shine."""
    flags = bsdf.flags()
    if not dr.any(is_diffuse(mi.UInt32(flags)), axis=None):
        return False
    if mi.has_flag(flags, mi.BSDFFlags.SpatiallyVarying):
        return True
    lanes = len(mi.UnpolarizedSpectrum())
    for side in (1.0, -1.0):
        si = dr.zeros(mi.SurfaceInteraction3f, 512)
        first = 360.0 + dr.arange(mi.Float, 512) * (470.0 / 511)
        si.wavelengths = mi.UnpolarizedSpectrum([first for _ in range(lanes)])
        si.wi = mi.Vector3f(0, 0, side)
        if dr.any(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0.0, 0.6 * side, 0.8 * side)) > 0, axis=None):
            return True
    return False


class _Numbers:
    """The random numbers of rays as a sampler, which `Stones` asks in RGB variants."""

    def __init__(self, chance: mi.PCG32) -> None:
        self._chance = chance

    def next_1d(self) -> mi.Float:
        return self._chance.next_float32()

"""Light that is sent towards the stones of a scene: from which light, where, and in which direction."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.plugins.spectra import mean_of
from gemrender.scene.shapes import mesh_buffers

__all__ = ["Emission"]

#: More stones are aimed at as one sphere about them all.
MOST_SPHERES = 12
#: Rays that tell how much light of each lamp is on its way to the stones, and wavelengths they have [nm].
_TRIALS = 256
_TRIAL_NM = (450.0, 530.0, 580.0, 630.0)
#: Lights are small that the stones see under less [sr]: 23 degrees about their middle. Softboxes of 0.4 sr
#: each, traced, make paper as even in 0.5 (luminance) and 0.65 (RGB) times the time that paths from the eye
#: need; the larger a light, the sooner these find it.
SMALL_SR = 0.5
#: Share of the rays that is spread over all lights alike: a trial may miss what is bright.
_EVEN = 0.1
#: How much larger a sphere is than its stone: rounding.
_ROOM = 1.001


class Emission:
    """Draws rays from the small lights of a scene towards its stones.

    A light is drawn by what a trial found of its flux towards the stones; on it a place; and one of the
    spheres about the stones, towards which the direction is uniform. Of a light at infinity the direction is
    the light's own, and the place is uniform on the disc across it that the sphere fills. Where spheres cover
    each other, the density is the mean over those that a ray meets (one-sample balance heuristic, Veach
    1997, section 9.2.2, of one ray each).

    Parameters
    ----------
    scene : mi.Scene
        The scene.
    stones : sequence of mi.Shape
        The stones.
    """

    def __init__(self, scene: mi.Scene, stones: list[mi.Shape]) -> None:
        spheres = _spheres(stones)
        self.n_spheres = len(spheres)
        # Not of numpy's memory: it is aligned by chance, and kernels that read one sphere know how
        self._spheres = [mi.Float(c.tolist()) for c in spheres.T]
        dr.make_opaque(self._spheres)
        self._each = [tuple(dr.opaque(mi.Float, float(x)) for x in sphere) for sphere in spheres]
        #: Mean weight of a ray, over all lights; 0 where there is no light.
        self.mean_weight = 0.0
        #: Which of the scene's lights are small, and these.
        self.small = np.flatnonzero(_solid_angles(scene, spheres) < SMALL_SR)
        self.n_emitters = len(self.small)
        if not self.n_emitters:
            return
        self.emitters = dr.gather(mi.EmitterPtr, scene.emitters_dr(), mi.UInt32(self.small.astype(np.uint32)))
        infinite = int(mi.EmitterFlags.Infinite)
        self._any_far = any(scene.emitters()[k].flags() & infinite for k in self.small)
        box = scene.bbox()
        low, high = (np.array(x, dtype=np.float64) for x in (box.min, box.max))
        #: Farther than the scene reaches: where rays of lights at infinity start.
        self._far = dr.opaque(mi.Float, float(np.linalg.norm(high - low)) + 1.0)
        self._choose(scene)

    @staticmethod
    def known(scene: mi.Scene) -> bool:
        """Return whether all lights are of kinds that rays can be drawn of."""
        flags = mi.EmitterFlags
        kinds = (flags.Surface, flags.Infinite, flags.DeltaPosition, flags.DeltaDirection | flags.Infinite)
        varying = ~int(flags.SpatiallyVarying)
        return all(e.flags() & varying in [int(kind) for kind in kinds] for e in scene.emitters())

    def _choose(self, scene: mi.Scene) -> None:
        """Find by a trial how much light each of the lights sends towards the stones."""
        n = self.n_emitters * _TRIALS
        lanes = dr.arange(mi.UInt32, n)
        chance = mi.PCG32(1, mi.UInt64(lanes), mi.UInt64(lanes) + 1)
        u = [chance.next_float32() for _ in range(5)]
        _, weight, *_ = self._ray(lanes // _TRIALS, u, mi.UnpolarizedSpectrum(*_trial_wavelengths()))
        found = np.array(mean_of(weight), dtype=np.float64).reshape(self.n_emitters, _TRIALS)
        flux = np.where(np.isfinite(found), found, 0).mean(axis=1)
        self.mean_weight = float(flux.sum())
        if self.mean_weight > 0:
            chosen = (1 - _EVEN) * flux / self.mean_weight + _EVEN / self.n_emitters
            edges = np.concatenate([[0.0], np.cumsum(chosen)]) / chosen.sum()
            self._edges = mi.Float(edges.astype(np.float32))
            self._keep_tables(scene, np.diff(edges))

    def _keep_tables(self, scene: mi.Scene, chosen: np.ndarray) -> None:
        """Keep what `density` asks of a light, by the number that Dr.Jit knows it by."""
        numbers = np.asarray(dr.reinterpret_array(mi.UInt32, scene.emitters_dr()))
        tables = np.ones((2, int(numbers.max()) + 1), dtype=np.float32)
        tables[0] = 0
        tables[0, numbers[self.small]] = chosen
        for shape in scene.shapes():
            if shape.is_emitter():
                number = dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(shape.emitter()))[0]
                tables[1, number] = 1 / float(np.asarray(shape.surface_area()).ravel()[0])
        self._chosen, self._per_area = (mi.Float(table) for table in tables)

    def sample(
        self, u: list[mi.Float], wavelengths: mi.UnpolarizedSpectrum
    ) -> tuple[mi.Ray3f, mi.UnpolarizedSpectrum, mi.Float]:
        """Return rays, the flux by wavelength that each stands for, and their `density`.

        Parameters
        ----------
        u : six Float in [0, 1)
            Numbers for the light, the place on it, the stone and the direction.
        wavelengths : Spectrum
            Wavelengths [nm].
        """
        row = dr.binary_search(
            0, self.n_emitters - 1, lambda k: dr.gather(mi.Float, self._edges, k + 1) <= u[0]
        )
        low, high = (dr.gather(mi.Float, self._edges, row + k) for k in (0, 1))
        ray, weight, emitter, n = self._ray(row, u[1:], wavelengths)
        return ray, weight / (high - low), self.density(emitter, ray.o, n, ray.d)

    def density(
        self, emitter: mi.EmitterPtr, p: mi.Point3f, n: mi.Normal3f, d: mi.Vector3f, active: mi.Bool = True
    ) -> mi.Float:
        """Return how densely rays are drawn [1/etendue]: what they carry is the radiance by that.

        Of an evenly bright surface, and of lights at infinity, it is exact. It is the same anywhere along a
        ray, and through stones, whose choices between reflection and refraction are as probable either way.
        Of a light that is a point or a direction it is beyond all.

        Parameters
        ----------
        emitter : EmitterPtr
            Small lights.
        p, n : Point3f, Normal3f
            Places on the rays, and the normal there: of a light that is a surface, on it.
        d : Vector3f
            Directions in which light goes.
        active : Bool
            Which there are.
        """
        number = dr.reinterpret_array(mi.UInt32, emitter)
        flags = emitter.flags()
        far, delta = mi.has_flag(flags, mi.EmitterFlags.Infinite), mi.has_flag(flags, mi.EmitterFlags.Delta)
        # Discs across light from infinity are met by rays that start before them
        start = dr.select(far, p - self._far * d, p)
        of_place = dr.gather(mi.Float, self._per_area, number, active) / dr.maximum(dr.dot(n, d), 0)
        if self._any_far:
            it, ds = dr.zeros(mi.Interaction3f, dr.width(p)), dr.zeros(mi.DirectionSample3f, dr.width(p))
            ds.d = -d
            of_place = dr.select(far, emitter.pdf_direction(it, ds, active & far & ~delta), of_place)
        none = mi.UInt32(self.n_spheres)
        density = of_place * self._density(start, d, none, far)
        density *= dr.gather(mi.Float, self._chosen, number, active)
        return dr.select(delta, dr.largest(mi.Float), dr.minimum(density, dr.largest(mi.Float)))

    def _ray(
        self, row: mi.UInt32, u: list[mi.Float], wavelengths: mi.UnpolarizedSpectrum
    ) -> tuple[mi.Ray3f, mi.UnpolarizedSpectrum, mi.EmitterPtr, mi.Normal3f]:
        emitter = dr.gather(mi.EmitterPtr, self.emitters, row)
        flags = emitter.flags()
        at_surface = mi.has_flag(flags, mi.EmitterFlags.Surface)
        far = mi.has_flag(flags, mi.EmitterFlags.Infinite)
        at_point = ~at_surface & ~far
        place, aim = mi.Point2f(u[0], u[1]), mi.Point2f(u[3], u[4])
        number = dr.minimum(mi.UInt32(u[2] * self.n_spheres), self.n_spheres - 1)
        x, y, z, radius = (dr.gather(mi.Float, column, number) for column in self._spheres)
        centre = mi.Point3f(x, y, z)

        # ---- Where it starts: of a light at infinity, the direction it comes from ----

        ps, place_weight = emitter.sample_position(0.0, place, at_surface)
        it = dr.zeros(mi.SurfaceInteraction3f, dr.width(row))
        it.p, it.wavelengths = centre, wavelengths
        ds, arriving = emitter.sample_direction(it, place, ~at_surface)
        start = dr.select(at_surface, ps.p, ds.p)

        # ---- Towards the sphere, or beside its middle across a given direction ----

        to = centre - start
        distance2 = dr.squared_norm(to)
        sin2 = dr.minimum(dr.square(radius) / distance2, 1)
        # All around where the light is within the sphere; 1 - cos without its digits' loss
        within = sin2 >= 1
        less = dr.select(within, 2, sin2 / (1 + dr.safe_sqrt(1 - sin2)))
        fall = aim.x * less
        turn, across = dr.two_pi * aim.y, dr.safe_sqrt(fall * (2 - fall))
        sin, cos = dr.sincos(turn)
        d = mi.Frame3f(to * dr.rsqrt(distance2)).to_world(mi.Vector3f(across * cos, across * sin, 1 - fall))
        d = dr.select(far, -ds.d, d)
        disc = radius * dr.safe_sqrt(aim.x)
        beside = mi.Frame3f(d).to_world(mi.Vector3f(disc * cos, disc * sin, 0))
        start = dr.select(far, centre + beside - self._far * d, start)
        density = self._density(start, d, number, far)

        # ---- What it carries ----

        si = mi.SurfaceInteraction3f(ps, wavelengths)
        si.wi = si.to_local(d)
        leaving = emitter.eval(si, at_surface) * (place_weight * dr.maximum(dr.dot(ps.n, d), 0))
        it.p = mi.Point3f(start + d)  # a unit away: the intensity of a light at a point
        _, intensity = emitter.sample_direction(it, place, at_point)
        weight = dr.select(at_surface, leaving, dr.select(far, arriving, intensity)) / density
        weight = dr.select(dr.isfinite(density) & (density > 0), weight, 0)
        ray = mi.Ray3f(start, d, 0.0, wavelengths)
        from_light = si.spawn_ray(d)
        ray.o = dr.select(at_surface, from_light.o, ray.o)
        return ray, weight, emitter, ps.n

    def _density(self, start: mi.Point3f, d: mi.Vector3f, number: mi.UInt32, far: mi.Bool) -> mi.Float:
        """Return the density of a direction [1/sr], of light at infinity that of a place across it."""
        density = mi.Float(0)
        for k, (x, y, z, radius) in enumerate(self._each):
            to = mi.Point3f(x, y, z) - start
            distance2, along = dr.squared_norm(to), dr.dot(to, d)
            sin2 = dr.minimum(dr.square(radius) / distance2, 1)
            less = dr.select(sin2 >= 1, 2, sin2 / (1 + dr.safe_sqrt(1 - sin2)))
            own = dr.select(far, dr.inv_pi / dr.square(radius), dr.inv_two_pi / less)
            meets = (along > 0) & (dr.squared_norm(dr.cross(to, d)) <= dr.square(radius))
            # The one that it was drawn for it meets, whatever rounding says
            density += dr.select(meets | (sin2 >= 1) | (number == k), own, 0)
        return density / self.n_spheres


def _solid_angles(scene: mi.Scene, spheres: np.ndarray) -> np.ndarray:
    """Return the solid angles that lights are seen under from the stones' middle [sr], (emitters,).

    Of lights at infinity, whose radiance L may vary, (integral L)^2 / integral L^2.
    """
    middle = spheres[:, :3].mean(axis=0)
    out = []
    for k, emitter in enumerate(scene.emitters()):
        if emitter.flags() & int(mi.EmitterFlags.Delta):
            out.append(0.0)
            continue
        chance = mi.PCG32(_TRIALS, 0, 2 * k + 1)
        place = mi.Point2f(chance.next_float32(), chance.next_float32())
        it = dr.zeros(mi.SurfaceInteraction3f, _TRIALS)
        it.p = mi.Point3f(*(float(x) for x in middle))
        it.wavelengths = mi.UnpolarizedSpectrum(*_trial_wavelengths())
        if emitter.flags() & int(mi.EmitterFlags.Infinite):
            ds, weight = emitter.sample_direction(it, place)
            w = mean_of(weight)
            total, square = (np.asarray(x, dtype=np.float64).mean() for x in (w, w * w * ds.pdf))
            out.append(total**2 / square if square > 0 else np.inf)
            continue
        ps, weight = emitter.sample_position(0.0, place)
        to = it.p - ps.p
        distance = dr.norm(to)
        angle = weight * dr.maximum(dr.dot(to, ps.n), 0) / (dr.square(distance) * distance)
        out.append(float(np.asarray(angle, dtype=np.float64).mean()))
    return np.array(out)


def _trial_wavelengths() -> list[float]:
    n = len(mi.UnpolarizedSpectrum())
    return [_TRIAL_NM[k % len(_TRIAL_NM)] for k in range(n)]


def _spheres(stones: list[mi.Shape]) -> np.ndarray:
    """Return centre and radius of spheres about stones, (n, 4)."""
    spheres = []
    for shape in stones:
        box = shape.bbox()
        low, high = np.array(box.min, dtype=np.float64), np.array(box.max, dtype=np.float64)
        middle, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
        if shape.is_mesh():
            radius = float(np.linalg.norm(mesh_buffers(shape)[0] - middle, axis=1).max())
        spheres.append([*middle, _ROOM * radius])
    found = np.array(spheres)
    if len(found) > MOST_SPHERES:
        low = (found[:, :3] - found[:, 3:]).min(axis=0)
        high = (found[:, :3] + found[:, 3:]).max(axis=0)
        middle = 0.5 * (low + high)
        radius = (np.linalg.norm(found[:, :3] - middle, axis=1) + found[:, 3]).max()
        found = np.array([[*middle, radius]])
    return found

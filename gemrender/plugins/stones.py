"""The stones of a scene as `gem_path` sees them: where their facets are, and what their material does."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.plugins.checks import RAY_OFFSET, SceneCheck, is_stone
from gemrender.plugins.crystals import Crystals
from gemrender.plugins.polarisation import Filters
from gemrender.plugins.spectra import N_ROWS, mean_of, parting_colour, row_of, tabulated, unpolarised
from gemrender.scene.convex import PlacedSolid
from gemrender.scene.shapes import FLAT

__all__ = ["RAY_OFFSET", "Stones", "reflectance", "refracted"]

#: Numbers of planes that kernels are compiled for; a stone with fewer has the rest of no effect, so that
#: another stone seldom needs another kernel. On two cores Embree takes as long as some 450 planes.
PLANE_CLASSES = (32, 64, 96, 128, 192, 256, 384)
#: Planes of all stones together that are compiled, one stone beside the other; where there are more, Embree
#: is asked. Eight stones of 64 planes take a third of its time.
_MOST_COMPILED = 512


class Stones:
    """Stones of a scene: shapes whose surface is a `gem_dielectric`. Numbered from 1; 0 is none.

    Parameters
    ----------
    scene : mi.Scene
        The scene.
    sampler : mi.Sampler
        Source of the wavelength of a path in RGB variants.
    check : SceneCheck, optional
        What has checked the scene before.
    filters : Filters, optional
        Polarising filters, where light's polarisation is to be followed.

    Raises
    ------
    InputError
        The scene is none that light can be followed through; see `SceneCheck`.
    """

    def __init__(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        check: SceneCheck | None = None,
        filters: Filters | None = None,
    ) -> None:
        self.filters = filters
        by_shape = {stone.ptr: stone for stone in (check or SceneCheck()).stones(scene)}
        shapes = scene.shapes()
        of_shape = {int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(s))[0]): s for s in shapes}
        self.scene = scene
        self.environment = scene.environment()
        numbers = np.zeros(
            max([*of_shape, *_numbers_in_groups(scene, shapes)], default=0) + 1, dtype=np.uint32
        )
        stones = []
        for number, shape in of_shape.items():
            if is_stone(shape):
                stones.append(shape)
                numbers[number] = len(stones)
        self.number_of_shape = mi.UInt32(numbers)
        surfaces = [stone.bsdf() for stone in stones]
        checked = [by_shape[stone.ptr] for stone in stones]
        # Row 0 stands for no stone: an index that divides.
        self.indices = mi.Float(np.concatenate([np.ones(N_ROWS), *(s.index_table for s in surfaces)]))
        self.absorption = mi.Float(
            np.concatenate([np.zeros(N_ROWS), *(s.absorption_table for s in surfaces)])
        )
        self.any_absorbs = any(s.absorbs for s in surfaces)
        self.crystals = Crystals(surfaces)
        alphas = [s.girdle_alpha for s in surfaces]
        #: Whether any has a rough girdle.
        self.any_rough = any(alphas)
        if self.any_rough:
            self.alphas = mi.Float([0.0, *alphas])
            self.axes = [mi.Float([0.0, *(s.axis[k] for s in surfaces)]) for k in range(3)]
        monochrome, rgb = mi.is_monochromatic, mi.is_rgb
        parts = [s.disperses or (rgb and s.absorbs) for s in surfaces]
        self.any_parts = any(parts) and not monochrome
        self.parts = mi.Bool([False, *parts])
        #: The wavelength of monochrome light [nm]: in RGB variants each path's own.
        if monochrome:
            self.fixed_nm = mi.Float([0.0, *(s.wavelength[0] for s in surfaces)])
        elif rgb and self.any_parts:
            self.path_nm, self.colour = parting_colour(sampler.next_1d())
        else:
            self.path_nm = mi.Float(589.3)
        solids = [stone.solid for stone in checked]
        radii = [0.5 * float(np.max(np.array(s.bbox().extents()))) for s in stones]
        self.size = dr.opaque(mi.Float, max(radii, default=1.0))
        #: Whether a ray that leaves a stone can meet only the sky.
        self.alone = len(shapes) == len(stones) == 1 and solids[0] is not None
        #: Whether the next facet is found by planes, of all stones; else Embree is asked.
        self.by_planes = self._compile([solid for solid in solids if solid is not None], len(solids))
        self.any_turned = any(stone.facing is not None for stone in checked)
        if self.any_turned:
            # Row 0 stands for all faces that look outwards as they are
            facing = [stone.facing for stone in checked if stone.facing is not None]
            self.facing = mi.Float(np.concatenate([np.ones(1, dtype=np.float32), *facing]))
            counts = np.array([0, *(0 if s.facing is None else len(s.facing) for s in checked)])
            first = np.where(counts > 0, 1 + np.cumsum(counts) - counts, 0)
            self.first_face = mi.UInt32(first.astype(np.uint32))

    # ---- Numbers ----

    def of(self, si: mi.SurfaceInteraction3f, active: mi.Bool) -> mi.UInt32:
        """Return the number of the stone that was hit."""
        shape = dr.reinterpret_array(mi.UInt32, si.shape)
        return dr.gather(mi.UInt32, self.number_of_shape, shape, active & si.is_valid())

    # ---- Material ----

    def index(
        self, stone: mi.UInt32, wavelengths: mi.UnpolarizedSpectrum, active: mi.Bool
    ) -> mi.UnpolarizedSpectrum:
        """Return the relative index of each channel."""
        return self._look_up(self.indices, stone, wavelengths, active)

    def transmittance(
        self, stone: mi.UInt32, wavelengths: mi.UnpolarizedSpectrum, distance: mi.Float, active: mi.Bool
    ) -> mi.UnpolarizedSpectrum:
        """Return the share that a way inside leaves, by Beer and Lambert."""
        if not self.any_absorbs:
            return mi.UnpolarizedSpectrum(1)
        coefficient = self._look_up(self.absorption, stone, wavelengths, active)
        return dr.exp(-coefficient * dr.maximum(distance, 0))

    def transmittance_of_mode(
        self,
        stone: mi.UInt32,
        wavelengths: mi.UnpolarizedSpectrum,
        counts: mi.Vector3f,
        distance: mi.Float,
        active: mi.Bool,
    ) -> mi.UnpolarizedSpectrum:
        """Return the same of a birefringent stone, of a mode that absorbs as `waves.Mode` tells."""
        if not self.crystals.any_absorbs:
            return mi.UnpolarizedSpectrum(1)
        channels = self._nm_of_channels(stone, wavelengths, active)
        values = self.crystals.transmittance(stone, channels, counts, distance, active)
        return mi.UnpolarizedSpectrum(values if mi.is_spectral else values[0])

    def nm_of(
        self, stone: mi.UInt32, wavelengths: mi.UnpolarizedSpectrum, channel: mi.UInt32, active: mi.Bool
    ) -> mi.Float:
        """Return the wavelength of a channel [nm]."""
        if mi.is_spectral:
            return self.of_channel(wavelengths, channel)
        return mi.Float(self._nm_of_channels(stone, wavelengths, active)[0])

    def disperses(self, stone: mi.UInt32, active: mi.Bool) -> mi.Bool:
        """Return whether wavelengths part in a stone."""
        if not self.any_parts:
            return mi.Bool(False)
        return dr.gather(mi.Bool, self.parts, stone, active)

    @property
    def n_ways(self) -> int:
        """How many wavelengths go on where they part: in spectral variants all of them."""
        return len(mi.UnpolarizedSpectrum()) if mi.is_spectral and self.any_parts else 1

    @staticmethod
    def alive(spectrum: mi.UnpolarizedSpectrum) -> mi.UInt32:
        """Return the channel of a path whose wavelengths have parted: the one that is left."""
        channel = mi.UInt32(0)
        for k in range(1, len(spectrum)):
            channel = dr.select(spectrum[k] > spectrum[0], mi.UInt32(k), channel)
        return channel if mi.is_spectral else mi.UInt32(0)

    @staticmethod
    def of_channel(spectrum: mi.UnpolarizedSpectrum, channel: mi.UInt32) -> mi.Float:
        """Return the value of a channel: in spectral variants of that given, else of the first."""
        value = mi.Float(spectrum[0])
        if mi.is_spectral:
            for k in range(1, len(spectrum)):
                value = dr.select(channel == k, spectrum[k], value)
        return value

    def only(
        self, throughput: mi.UnpolarizedSpectrum, channel: mi.UInt32, part: mi.Bool
    ) -> mi.UnpolarizedSpectrum:
        """Return the throughput of a channel alone, where wavelengths part."""
        alone = mi.UnpolarizedSpectrum(throughput)
        if mi.is_spectral and self.any_parts:
            for k in range(len(alone)):
                alone[k] = dr.select(~part | (channel == k), throughput[k], 0)
        return alone

    def first_for_all(self, throughput: mi.UnpolarizedSpectrum, part: mi.Bool) -> mi.UnpolarizedSpectrum:
        """Return a throughput of which, where wavelengths part, the first is left and stands for all."""
        alone = mi.UnpolarizedSpectrum(throughput * self.parting_weight())
        if self.n_ways > 1:
            alone = mi.UnpolarizedSpectrum(self.n_ways * throughput[0], *([0] * (self.n_ways - 1)))
        return dr.select(part, alone, throughput)

    def parting_weight(self) -> mi.UnpolarizedSpectrum:
        """Return what the channels are multiplied by where wavelengths part."""
        return (
            mi.UnpolarizedSpectrum(self.colour) if mi.is_rgb and self.any_parts else mi.UnpolarizedSpectrum(1)
        )

    def enter(
        self,
        entering: mi.UnpolarizedSpectrum,
        eta: mi.UnpolarizedSpectrum,
        d: mi.Vector3f,
        n: mi.Vector3f,
        cos_air: mi.Float,
        channel: mi.UInt32,
        part: mi.Bool,
    ) -> tuple[mi.UnpolarizedSpectrum, mi.Float, mi.Vector3f]:
        """Return throughput, index and direction of a wavelength that enters a stone.

        Parameters
        ----------
        entering, eta : Spectrum
            Throughput of what enters, and relative index, of all channels.
        d, n, cos_air
            Direction outside, outward normal, and cosine of the angle of incidence.
        channel : UInt32
            The channel that goes on.
        part : Bool
            Whether the others have ways of their own.
        """
        index, throughput = self.of_channel(eta, channel), self.only(entering, channel, part)
        cos_stone = dr.safe_sqrt(1 - (1 - dr.square(cos_air)) / dr.square(index))
        return throughput, index, refracted(d, n, cos_air, cos_stone, 1 / index)

    def weight(self, throughput: mi.UnpolarizedSpectrum, split: mi.Bool) -> mi.Float:
        """Return a throughput inside, as Russian roulette takes it: of one of many ways as if all went it."""
        mean = mean_of(throughput)
        return dr.select(split, self.n_ways * mean, mean)

    def _look_up(
        self, table: mi.Float, stone: mi.UInt32, wavelengths: mi.UnpolarizedSpectrum, active: mi.Bool
    ) -> mi.UnpolarizedSpectrum:
        """Read a material's table at the wavelength of each channel."""
        channels = self._nm_of_channels(stone, wavelengths, active)
        values = [tabulated(table, stone * N_ROWS, row_of(nm), active) for nm in channels]
        return mi.UnpolarizedSpectrum(values if mi.is_spectral else values[0])

    def _nm_of_channels(
        self, stone: mi.UInt32, wavelengths: mi.UnpolarizedSpectrum, active: mi.Bool
    ) -> list[mi.Float]:
        """Return the wavelength of each channel [nm]: in variants that are not spectral, of all together."""
        if mi.is_spectral:
            return list(wavelengths)
        if mi.is_monochromatic:
            return [dr.gather(mi.Float, self.fixed_nm, stone, active)]
        return [self.path_nm]

    def one_wavelength(
        self, throughput: mi.UnpolarizedSpectrum, eta: mi.UnpolarizedSpectrum, part: mi.Bool, chance: mi.PCG32
    ) -> tuple[mi.UnpolarizedSpectrum, mi.Float]:
        """Return throughput and index of a path that goes on with one wavelength, drawn where they part."""
        if not mi.is_spectral:
            return mi.UnpolarizedSpectrum(throughput), mi.Float(eta[0])
        n = len(eta)
        drawn = dr.minimum(mi.UInt32(chance.next_float32() * n), n - 1)
        channel = dr.select(part, drawn, self.alive(throughput))
        index, out = mi.Float(eta[0]), mi.UnpolarizedSpectrum(throughput)
        for k in range(n):
            index = dr.select(channel == k, eta[k], index)
            out[k] = dr.select(part, dr.select(channel == k, n * throughput[k], 0), throughput[k])
        return out, index

    # ---- Geometry ----

    def roughness(self, stone: mi.UInt32, n: mi.Vector3f, active: mi.Bool) -> mi.Float:
        """Return the roughness of a facet by its outward normal: that of the girdle, else 0."""
        axis = mi.Vector3f(*(dr.gather(mi.Float, values, stone, active) for values in self.axes))
        level = dr.abs(dr.dot(axis, n)) < _LEVEL
        return dr.select(level, dr.gather(mi.Float, self.alphas, stone, active), 0)

    def outward(self, si: mi.SurfaceInteraction3f, stone: mi.UInt32, active: mi.Bool) -> mi.Vector3f:
        """Return the outward normal of a stone that was hit, of other surfaces the shading normal."""
        n = mi.Vector3f(si.sh_frame.n)
        if not self.any_turned:
            return n
        first = dr.gather(mi.UInt32, self.first_face, stone, active)
        row = dr.select(first > 0, first + si.prim_index, 0)
        facing = dr.gather(mi.Float, self.facing, row, active)
        n = dr.select(dr.abs(facing) == FLAT, mi.Vector3f(si.n), n)
        return dr.select(facing < 0, -n, n)

    def next_surface(
        self, stone: mi.UInt32, p: mi.Point3f, d: mi.Vector3f, active: mi.Bool
    ) -> tuple[mi.Float, mi.Vector3f, mi.Bool]:
        """Return how far a ray inside a stone goes, the outward normal there, and whether it met anything."""
        if not self.by_planes:
            si = self.scene.ray_intersect(mi.Ray3f(p, d), mi.RayFlags.ShadingFrame, False, active)
            n = (
                self.outward(si, self.of(si, active), active)
                if self.any_turned
                else mi.Vector3f(si.sh_frame.n)
            )
            return si.t, n, si.is_valid() & (dr.dot(n, d) > 0)
        t, n = self._nearest_plane(stone, p, d)
        return t, n, t < _NOTHING

    def inwards(self, p: mi.Point3f, n: mi.Vector3f) -> mi.Point3f:
        """Return where the next query starts, for a point on the surface."""
        return p if self.by_planes else mi.Point3f(p - RAY_OFFSET * self.size * n)

    def outside(self, ray: mi.Ray3f, active: mi.Bool) -> tuple[mi.Bool, mi.UnpolarizedSpectrum]:
        """Look along a ray that has left a stone.

        Returns
        -------
        (found, radiance)
            Whether it meets something that is neither light nor sky, and the radiance of light and sky.
        """
        if self.alone:
            if self.environment is None:
                return mi.Bool(False), mi.UnpolarizedSpectrum(0)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi, si.wavelengths = -ray.d, ray.wavelengths
            return mi.Bool(False), unpolarised(self.environment.eval(si, active))
        si = self.scene.ray_intersect(ray, mi.RayFlags.AllNonDifferentiable, False, active)
        radiance = unpolarised(si.emitter(self.scene, active).eval(si, active))
        return active & si.is_valid() & ~si.shape.is_emitter(), radiance

    def _compile(self, solids: list[PlacedSolid], n_stones: int) -> bool:
        """Put the planes of all stones into the kernel, as numbers that it reads once, if they are few."""
        most = max((len(solid.planes) for solid in solids), default=0)
        padded = next((n for n in PLANE_CLASSES if n >= most), None)
        if not solids or len(solids) < n_stones or padded is None or n_stones * padded > _MOST_COMPILED:
            return False
        planes = np.zeros((n_stones, padded, 4))  # no ray runs towards the zeros
        cylinders = np.zeros((n_stones, 7))
        cylinders[:, 2], cylinders[:, 6] = 1, -1  # no cylinder: radius -1
        for k, solid in enumerate(solids):
            planes[k, : len(solid.planes)] = solid.planes
            if solid.cylinder is not None:
                cylinders[k] = solid.cylinder
        self.planes = [[[_opaque(x) for x in row] for row in of_stone] for of_stone in planes]
        self.cylinders = [[_opaque(x) for x in row] for row in cylinders]
        return True

    def _nearest_plane(self, stone: mi.UInt32, p: mi.Point3f, d: mi.Vector3f) -> tuple[mi.Float, mi.Vector3f]:
        """Return how far the surface is that a ray leaves a convex stone through, and its outward normal."""
        others = [stone == k + 1 for k in range(1, len(self.planes))]

        def of(values: list[list[mi.Float]]) -> list[mi.Float]:
            out = list(values[0])
            for chosen, value in zip(others, values[1:], strict=True):
                out = [dr.select(chosen, v, x) for v, x in zip(value, out, strict=True)]
            return out

        t, n = mi.Float(_NOTHING), mi.Vector3f(0, 0, 1)
        for k in range(len(self.planes[0])):
            a, b, c, offset = of([planes[k] for planes in self.planes])
            along = dr.fma(a, d.x, dr.fma(b, d.y, c * d.z))
            gap = offset - dr.fma(a, p.x, dr.fma(b, p.y, c * p.z))
            t_plane = gap / along
            nearer = (along > 0) & (t_plane < t)
            t = dr.select(nearer, t_plane, t)
            n = dr.select(nearer, mi.Vector3f(a, b, c), n)
        return _nearer_cylinder(of(self.cylinders), p, d, t, n)


#: Facets whose normal is as much across the axis are the girdle's [cosine]: single precision, with a margin.
_LEVEL = 1e-4
#: No surface is as far [scene unit].
_NOTHING = 1e30


def _numbers_in_groups(scene: mi.Scene, shapes: list[mi.Shape]) -> list[int]:
    """Return the numbers of shapes that only instances of groups show."""
    if not any(shape.class_name() == "Instance" for shape in shapes):
        return []
    inner = [node for node in mi.traverse(scene).hierarchy if isinstance(node, mi.Shape)]
    return [int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0]) for shape in inner]


def _opaque(x: np.floating) -> mi.Float:
    return dr.opaque(mi.Float, float(x))


def _nearer_cylinder(
    cylinder: list[mi.Float], p: mi.Point3f, d: mi.Vector3f, t: mi.Float, n: mi.Vector3f
) -> tuple[mi.Float, mi.Vector3f]:
    """Return the girdle's wall, where a ray inside leaves its cylinder before the planes."""
    axis, centre, radius = mi.Vector3f(*cylinder[:3]), mi.Point3f(*cylinder[3:6]), cylinder[6]
    to = p - centre
    q = to - dr.dot(to, axis) * axis
    e = d - dr.dot(d, axis) * axis
    a, b, c = dr.dot(e, e), dr.dot(q, e), dr.dot(q, q) - dr.square(radius)
    t_wall = (-b + dr.safe_sqrt(dr.square(b) - a * c)) / a
    nearer = (radius > 0) & (t_wall < t)  # false along the axis: 0 / 0
    return dr.select(nearer, t_wall, t), dr.select(nearer, (q + t_wall * e) / radius, n)


# ---- Optics ----


def reflectance(cos_air: mi.Float, cos_stone: mi.Float, eta: mi.Float) -> mi.Float:
    """Return the reflected share of unpolarised light, from the cosines on both sides.

    Born & Wolf, 7th ed., section 1.5.2, equations (21a).
    """
    r_s = (cos_air - eta * cos_stone) / (cos_air + eta * cos_stone)
    r_p = (eta * cos_air - cos_stone) / (eta * cos_air + cos_stone)
    return 0.5 * (dr.square(r_s) + dr.square(r_p))


def refracted(
    d: mi.Vector3f, n: mi.Vector3f, cos_i: mi.Float, cos_t: mi.Float, ratio: mi.Float
) -> mi.Vector3f:
    """Return the direction of a ray that enters through a surface of outward normal n, by Snell's law.

    Parameters
    ----------
    cos_i, cos_t : Float
        Cosines of the angles of incidence and refraction.
    ratio : Float
        Index on the side that the ray comes from, by that on the other.
    """
    return dr.normalize(ratio * (d + cos_i * n) - cos_t * n)

"""`gem_path`: a path integrator made for cut stones, with dispersion."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.plugins.branches import NEGLIGIBLE, Branch, is_diffuse, split
from gemrender.plugins.caustics import Caustics
from gemrender.plugins.checks import SceneCheck
from gemrender.plugins.direct import MOST_LIGHTS, direct_light, mis_weight, one_light
from gemrender.plugins.modes import split_modes, walk_modes
from gemrender.plugins.polarisation import Field, Filters
from gemrender.plugins.properties import direction, truth, whole_number
from gemrender.plugins.spectra import mean_of, unpolarised
from gemrender.plugins.stones import RAY_OFFSET, Stones
from gemrender.plugins.tracing import instances_held
from gemrender.plugins.walk import LATE, LATE_SURVIVAL, walk

#: Names of the AOVs, in order: what a denoiser wants to know of the first hit.
AOV_NAMES = ("albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z")

#: Throughput below which a way outside stones goes on by chance only.
ROULETTE_OUTSIDE = 0.15


class PathIntegrator(mi.SamplingIntegrator):
    r"""
    .. _integrator-gem_path:

    Paths through cut stones (:monosp:`gem_path`)
    ---------------------------------------------

    .. pluginparameters::

     * - max_depth
       - |int|
       - Number of segments after which a path is cut off, as for ``path``; -1 for none. (Default: -1)
       -

     * - analyser
       - |vector|
       - Axis along which a polarising filter before the camera lets light through. (Default: no filter)
       -

     * - polariser
       - |vector|
       - The same of a filter before all lights. (Default: no filter)
       -

     * - right_analyser
       - |vector|
       - That of a right one of two windows, which pictures by ``gemrender render`` then show side by side;
         ``analyser`` is the left one's. (Default: one window)
       -

     * - aovs
       - |bool|
       - Whether the film gets albedo and normal after its own channels, for a denoiser. (Default: false)
       -

    Radiance of scenes with cut stones: shapes whose surface is a ``gem_dielectric``. It takes the same scenes
    as Mitsuba's ``path`` and, without dispersion, gives the same pictures, but it knows what a stone does to
    light:

    - **No choice by chance between reflection and refraction.** Where a ray meets a stone from outside, both
      branches are followed. Inside, at each surface that lets some light through, what comes in there is
      added with its share, and the rest is followed on by reflection. Of the branches that end on something
      that is neither light nor sky one is drawn, in proportion to its share, and goes on.
    - **Inside a convex stone no ray tracer is asked**: the next facet is the nearest of its planes, which its
      mesh carries (``gemrender scene`` writes them). Other stones, and those of more than 384 planes, are
      left to Embree.
    - **Dispersion.** In spectral variants the wavelengths of a path part where it first enters a dispersive
      stone, and each goes on by itself; until then all share a way. Each is lit by what shines straight on
      the diffuse surface that it ends on; from there one goes on with its own wavelength only, and stands for
      all. In RGB variants the path draws a wavelength, weighted by the linear sRGB response; in monochrome
      ones all light has the wavelength of the stone's ``gem_dielectric``.
    - **Birefringence.** In a birefringent stone light is in one mode at a time, ordinary or extraordinary,
      fast or slow, with its own index, direction of energy and absorption. The phases of two part within
      micrometres, so that they add as energies: of those that a facet hands light on to, one is drawn by its
      share of the energy. Outside, light is unpolarised, but between filters: a thick plate at 45 degrees
      between crossed ones passes a quarter of it, less what it reflects, without interference colours.
    - **Polarised variants.** The first stone that is seen polarises light, by its facets and its modes, and
      the integrator returns what unpolarised light becomes, as Mueller matrices: nest it in ``stokes``. Light
      is taken as unpolarised by all else. Each path is followed with one polarisation of all that there are,
      even over Poincaré's sphere; samplers that spread numbers evenly, as ``multijitter``, have a third of
      the noise of ``independent`` there.
    - **Absorption** along the way inside, by the material (Beer and Lambert).
    - Russian roulette goes by the throughput, and total reflection does not lessen it: long bright paths are
      not clipped. Multiple importance sampling (power heuristic) at all other surfaces; at the first one that
      is seen each light has a sample of its own, or, of more than eight, each eighth of them.

    With ``aovs``, the film gets ``albedo.R``, ``.G``, ``.B`` (1 on stones) and ``normal.X``, ``.Y``, ``.Z``
    of the first surface too.

    A scene is checked when it is first rendered, and again when it has changed. Stones are closed meshes or
    spheres: the solid counts, not how its mesh is wound. Faces that look inwards are turned round, and a
    ``GemrenderWarning`` says so. Where vertex normals are more than 30 degrees off those of faces, as those
    are at sharp edges that Mitsuba makes for a file without, the facets are flat. A part of a mesh inside
    another part is a hollow. Surfaces that are open or one-sided, faces that are there twice, stones that
    overlap (they may touch), stones in shape groups, and cameras or lights inside stones are refused: by an
    ``InputError``, which ``mi.render`` tells as the cause of its own error. ``scene.integrator().check(scene,
    sensor)`` checks only, and raises it as it is.

    Stones that lie face to face, closer than a ray starts from a facet, are taken without air between them,
    and a ``GemrenderWarning`` says so.

    Light that lamps throw through stones on diffuse surfaces is found by chance only. ``gemrender render``
    traces that of lamps which the stones see under less than 0.5 sr from the lamps too, and tells the
    integrator so: of each path that ends on such a lamp, whose first surface from the camera is diffuse, and
    whose last diffuse surface only stones part from the lamp, it then counts its share where that is one
    stone and the first surface is the last diffuse one, and else nothing.

    At a rough girdle (``girdle_alpha``) one way is drawn, out or in, that carries all the light; where a path
    first enters a dispersive stone there, it goes on with one wavelength, drawn of all. Light that is traced
    from lamps is scattered there alike.

    A rough girdle of a birefringent stone scatters as one of its mean index does, into either mode.

    Point and directional lights light plain surfaces, but are not seen in or through stones. Participating
    media are not followed. A ``GemrenderWarning`` says either.

    .. tabs::
        .. code-tab:: xml
            :name: gem-path

            <integrator type="gem_path"/>

        .. code-tab:: python

            'type': 'gem_path'

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.max_depth = whole_number(props, "max_depth", -1, least=-1)
        self.aovs = truth(props, "aovs", False)
        #: Axes of the polarising filters, unit vectors; None is no filter.
        self.analyser, self.polariser, self.right_analyser = (
            direction(props, key) if key in props else None
            for key in ("analyser", "polariser", "right_analyser")
        )
        if self.right_analyser is not None and self.analyser is None:
            raise InputError("missing, beside right_analyser", key="analyser")
        self.scene_check = SceneCheck()

    def aov_names(self) -> list[str]:
        """Return the names of the channels after the film's own."""
        return list(AOV_NAMES) if self.aovs else []

    def check(self, scene: mi.Scene, sensor: mi.Sensor) -> None:
        """Check a scene and a camera; what can be mended is, with a `GemrenderWarning`.

        Raises
        ------
        InputError
            Light cannot be followed: a stone is open, stones overlap, a light or the camera is inside one.
        """
        self.scene_check.camera(scene, sensor)

    def render(
        self,
        scene: mi.Scene,
        sensor: mi.Sensor | int = 0,
        seed: mi.UInt32 | int = 0,
        spp: int = 0,
        develop: bool = True,
        evaluate: bool = True,
    ) -> mi.TensorXf:
        """Render a scene, as every integrator does, once it is checked; see the class."""
        self.check(scene, scene.sensors()[sensor] if isinstance(sensor, int) else sensor)
        with instances_held():
            return super().render(scene, sensor, seed, spp, develop, evaluate)

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool = True,
    ) -> tuple[mi.UnpolarizedSpectrum, mi.Bool, list[mi.Float]]:
        """Return the radiance along a ray from outside all stones; see the class."""
        if len(scene.sensors()) == 1:  # another integrator may ask, which has checked nothing
            self.check(scene, scene.sensors()[0])
        radiance, valid, aovs, stokes = self._sample(scene, sampler, ray, active)
        return _as_mueller(radiance, stokes), valid, aovs if self.aovs else []

    def caustics(self, scene: mi.Scene, sensor: mi.Sensor) -> Caustics | None:
        """Return what traces the light of a checked scene that stones throw on diffuse surfaces.

        None where there are polarising filters: light is followed from the eye only then.
        """
        if self.filters() is not None:
            return None
        return Caustics(scene, sensor, self.scene_check, self.max_depth)

    def filters(self, right: mi.Bool | None = None) -> Filters | None:
        """Return the polarising filters; None where light's polarisation makes no difference.

        `right` tells which paths begin in the right one of two windows; None is none of them.
        """
        if self.analyser is None and self.polariser is None and not mi.is_polarized:
            return None
        return Filters(self.analyser, self.polariser, self.right_analyser, right)

    def sample_with_aovs(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        active: mi.Bool = True,
        *,
        caustics: Caustics | None = None,
        modes_by: mi.Float | None = None,
        right: mi.Bool | None = None,
    ) -> tuple[mi.UnpolarizedSpectrum, mi.Bool, list[mi.Float]]:
        """Return the radiance along a ray with the AOVs, whether `aovs` asks for them or not.

        With `caustics`, the light that these count is left out. `modes_by` are numbers in [0, 1), even over a
        pixel together with the places in it, that draw the modes in the first stone, if it is birefringent.
        `right` is as of `filters`.
        """
        return self._sample(scene, sampler, ray, active, caustics, modes_by, right)[:3]

    def to_string(self) -> str:
        """Describe the integrator in Mitsuba's manner."""
        return f"PathIntegrator[\n  max_depth = {self.max_depth},\n  aovs = {self.aovs}\n]"

    def _sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        active: mi.Bool,
        caustics: Caustics | None = None,
        modes_by: mi.Float | None = None,
        right: mi.Bool | None = None,
    ) -> tuple[mi.UnpolarizedSpectrum, mi.Bool, list[mi.Float], mi.Vector3f]:
        """Return what `sample_with_aovs` does, and Stokes' parameters as `Filters.stokes` does."""
        with dr.suspend_grad(), instances_held():
            stones = Stones(scene, sampler, self.scene_check, self.filters(right))
            radiance, valid, albedo, normal, stokes = self._radiance(
                scene, stones, sampler, mi.Ray3f(ray), mi.Bool(active), caustics, modes_by
            )
        return radiance, valid, [*albedo, *normal], stokes

    @dr.syntax
    def _radiance(self, scene, stones, sampler, ray, active, caustics, modes_by):  # type: ignore[no-untyped-def]  # dr.syntax
        max_depth = mi.UInt32(self.max_depth if self.max_depth >= 0 else 0xFFFFFFFF)
        context = mi.BSDFContext()
        walking = caustics is not None

        L = mi.UnpolarizedSpectrum(0)  # radiance found so far
        β = mi.UnpolarizedSpectrum(1)  # throughput
        parted = mi.Bool(False)  # whether the wavelengths have parted
        depth = mi.UInt32(0)  # segments so far
        valid = mi.Bool(False)
        first = mi.Bool(True)
        direct = mi.Bool(True)  # whether it has met nothing but mirrors and stones
        # What `Caustics` traces: the first surface is diffuse, the last one too, and stones have come since
        first_diffuse, last_diffuse, through = mi.Bool(False), mi.Bool(False), mi.Bool(False)
        lit = mi.Bool(False)  # whether light straight on the next surface is counted, if that is diffuse
        dark = mi.Bool(False)  # whether light that the ray meets is counted
        of_eye = mi.Float(0)  # how densely rays come off the first surface, through one stone at most
        albedo, normal = mi.Color3f(0), mi.Vector3f(0)
        from_p = mi.Point3f(ray.o)  # the surface before, for multiple importance sampling
        from_pdf = mi.Float(1)
        from_delta = mi.Bool(True)
        # A picture's noise on plain surfaces is mostly of which light is asked at the first
        at_first = mi.UInt32(min(max(len(scene.emitters()), 1), MOST_LIGHTS))
        from_lights = mi.UInt32(1)  # samples of the lights that were taken there

        # Inside stones numbers are needed by the dozen, and their spread does not matter there
        seeds = mi.sample_tea_32(
            mi.UInt32(sampler.next_1d() * 4294967040.0), mi.UInt32(sampler.next_1d() * 4294967040.0)
        )
        chance = mi.PCG32(1, mi.UInt64(seeds[0]), mi.UInt64(seeds[1]))

        field, looked_at = Field.linear(mi.Vector3f(1, 0, 0)), mi.Float(1)
        if dr.hint(stones.filters is not None, mode="scalar"):
            β *= stones.filters.leaves
            field = stones.filters.begins(ray.d, mi.Bool(True), sampler.next_2d())
            looked_at = stones.filters.passes(field, ray.d)
        seen_by, seen_along = field, mi.Vector3f(ray.d)
        polarises = mi.Bool(self.polariser is not None)  # whether anything has, that the camera sees

        while dr.hint(active, label="gem_path"):
            si = scene.ray_intersect(ray, mi.RayFlags.AllNonDifferentiable, False, active)
            stone = stones.of(si, active)
            on_stone = active & (stone != 0)

            # ---- Light that the ray ends on ----

            emitter = si.emitter(scene, active & ~on_stone)
            came_from = mi.Interaction3f(0.0, ray.time, ray.wavelengths, from_p)
            ds = mi.DirectionSample3f(scene, si, came_from)
            weigh = active & ~from_delta & (emitter != None)  # noqa: E711 (an array)
            mis = mis_weight(from_pdf, from_lights * scene.pdf_emitter_direction(came_from, ds, weigh))
            mis = dr.select(from_delta, 1, mis)
            light = unpolarised(emitter.eval(si, active & ~on_stone))
            traced = active & ~on_stone & first_diffuse & last_diffuse & through
            share = _of_eye(caustics, dr.select(through, of_eye, 0), emitter, si, ray, traced)
            L += dr.select(active & ~on_stone & ~dark, β * mis * share * light * looked_at, 0)
            looked_at = mi.Float(1)

            # ---- What a denoiser wants to know ----

            bsdf = si.bsdf(ray)
            seen = first & active & si.is_valid()
            reflects = seen & ~on_stone
            valid |= seen
            normal = dr.select(seen, stones.outward(si, stone, seen), normal)
            diffuse = unpolarised(bsdf.eval_diffuse_reflectance(si, reflects))
            albedo = dr.select(seen, dr.select(on_stone, mi.Color3f(1), _as_rgb(diffuse)), albedo)
            first = mi.Bool(False)

            # ---- Surfaces other than stones: emitter sampling, BSDF sampling ----

            goes_on = active & si.is_valid() & (depth + 1 < max_depth)
            plain = goes_on & ~on_stone
            n = stones.outward(si, stone, active)
            d = mi.Vector3f(ray.d)
            cos_air = -dr.dot(n, d)
            arrives = goes_on & on_stone & (cos_air > 0)
            # A ray that starts within rounding of a facet may meet it from behind: on, through it.
            behind = goes_on & on_stone & ~arrives
            is_matt = is_diffuse(bsdf.flags())
            dark = plain & lit & is_matt
            smooth = plain & ~dark & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            samples = dr.select(depth == 0, at_first, 1)
            found = direct_light(scene, si, bsdf, sampler.next_2d(), samples, smooth)
            L += dr.select(smooth, β * found, 0)

            bs, weight = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d(), plain)
            weight = unpolarised(weight)
            next_ray = si.spawn_ray(si.to_world(bs.wo))
            next_ray.o = dr.select(behind, si.p + RAY_OFFSET * stones.size * ray.d, next_ray.o)
            next_ray.d = dr.select(behind, ray.d, next_ray.d)
            first_diffuse |= plain & (depth == 0) & is_matt
            last_diffuse = dr.select(plain, is_matt, last_diffuse)
            through = ~plain & (through | arrives)
            if dr.hint(walking, mode="scalar"):
                of_eye = dr.select(plain & (depth == 0) & is_matt, caustics.seen(si.p, si.n), of_eye)
                of_eye = dr.select((depth == 0) | ((depth == 1) & arrives), of_eye, 0)

            # ---- Stones: all ways are followed for light; where that is traced, only one, by chance ----

            walks = arrives & first_diffuse & last_diffuse & walking
            splits = arrives & ~walks
            birefringent = mi.Bool(False)
            if dr.hint(stones.crystals.any, mode="scalar"):
                birefringent = stones.crystals.among(stone, arrives)
            if dr.hint(stones.filters is not None, mode="scalar"):
                polarises |= arrives & (depth == 0)
                state = mi.Point2f(chance.next_float32(), chance.next_float32())
                field = dr.select(depth == 0, seen_by, stones.filters.begins(d, mi.Bool(False), state))
            Le, drawn, part = split(
                stones, stone, si.p, d, n, β, parted, field, ray.wavelengths, ray.time,
                chance, depth, max_depth, direct, splits & ~birefringent,
            )  # fmt: skip
            L += dr.select(splits & ~birefringent, Le, 0)
            if dr.hint(stones.crystals.any, mode="scalar"):
                number = sampler.next_1d()
                if dr.hint(modes_by is not None, mode="scalar"):
                    number = dr.select(depth == 0, modes_by, number)
                Le, drawn_modes, part_modes = split_modes(
                    stones, stone, si.p, d, n, β, parted, field, ray.wavelengths, ray.time,
                    number, chance, depth, max_depth, direct, splits & birefringent,
                )  # fmt: skip
                L += dr.select(splits & birefringent, Le, 0)
                drawn = dr.select(birefringent, drawn_modes, drawn)
                part |= part_modes

            # ---- What a wavelength's way ends on is lit, of each; the first goes on, for all ----

            part |= walks & ~parted & stones.disperses(stone, walks)
            eta = stones.index(stone, ray.wavelengths, arrives)
            hero = drawn[0]
            way = mi.UInt32(0)
            ends = mi.Bool(walks)
            for k in range(stones.n_ways):
                ends |= part & (drawn[k].weight > 0)
            if dr.hint(walking or stones.n_ways > 1, mode="scalar"):
                while dr.hint(ends, label="gem_path: ends"):
                    end = drawn[0]
                    for k in range(1, stones.n_ways):
                        end = dr.select(way == k, drawn[k], end)
                    if dr.hint(walking, mode="scalar"):
                        channel = dr.select(part, way, stones.alive(β))
                        walk_o, walk_d, walk_β, walk_depth, walked = walk(
                            stones, stone, si.p, d, n, stones.only(β, channel, part),
                            stones.of_channel(eta, channel), ray.wavelengths,
                            chance, depth, max_depth, ends & walks & ~birefringent,
                        )  # fmt: skip
                        if dr.hint(stones.crystals.any, mode="scalar"):
                            of_modes = walk_modes(
                                stones, stone, si.p, d, n, stones.only(β, channel, part),
                                stones.nm_of(stone, ray.wavelengths, channel, arrives), ray.wavelengths,
                                chance, depth, max_depth, ends & walks & birefringent,
                            )  # fmt: skip
                            walk_o, walk_d, walk_β, walk_depth, walked = dr.select(
                                birefringent, of_modes, (walk_o, walk_d, walk_β, walk_depth, walked)
                            )
                        weight_of_walk = dr.select(walked, mean_of(walk_β), 0)
                        walked_end = Branch(weight_of_walk, walk_o, walk_d, walk_β, part | parted, walk_depth)
                        end = dr.select(walks, walked_end, end)
                    looks = ends & part & (end.weight > 0)
                    end_ray = mi.Ray3f(end.o, end.d, ray.time, ray.wavelengths)
                    end_si = scene.ray_intersect(end_ray, mi.RayFlags.AllNonDifferentiable, False, looks)
                    end_bsdf = end_si.bsdf()
                    shines = looks & walks
                    end_light = end_si.emitter(scene, shines)
                    share = _of_eye(caustics, of_eye * stones.n_ways, end_light, end_si, end_ray, shines)
                    end_Le = unpolarised(end_light.eval(end_si, shines))
                    L += dr.select(shines, end.throughput * share * end_Le, 0)
                    lights = looks & (end.depth + 2 <= max_depth) & end_si.is_valid()
                    lights &= stones.of(end_si, lights) == 0
                    lights &= is_diffuse(end_bsdf.flags())
                    place = mi.Point2f(chance.next_float32(), chance.next_float32())
                    found = one_light(scene, end_si, end_bsdf, place, lights)
                    L += dr.select(lights, end.throughput * found, 0)
                    hero = dr.select(way == 0, end, hero)
                    way += 1
                    ends &= part & (way < stones.n_ways)

            lit = part & (hero.weight > 0) & (stones.n_ways > 1)
            dark |= walks & part
            drawn_on = arrives & (hero.weight > 0)
            ray.o = dr.select(drawn_on, hero.o, next_ray.o)
            ray.d = dr.select(drawn_on, hero.d, next_ray.d)
            # Of the ways of parted wavelengths the first stands for all: samples spread its wavelength evenly
            many = dr.select(part & hero.parted, mi.Float(stones.n_ways), 1)
            β = dr.select(drawn_on, hero.throughput * many, dr.select(plain, β * weight, β))
            parted = dr.select(drawn_on, hero.parted, parted)
            depth = dr.select(drawn_on, hero.depth, depth + 1)
            from_p = dr.select(plain, si.p, from_p)
            from_pdf = dr.select(plain, bs.pdf, 1)
            from_lights = dr.select(plain, samples, 1)
            direct &= ~plain | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            from_delta = ~plain | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)

            active = drawn_on | behind | (plain & (mean_of(β) > 0))
            q = dr.minimum(mean_of(β) * (1 / ROULETTE_OUTSIDE), 1)
            q = dr.select(depth > LATE, q * LATE_SURVIVAL, q)
            active &= (chance.next_float32() < q) & (q > NEGLIGIBLE)
            β *= dr.select(active, dr.rcp(q), 0)
            ray.maxt = dr.largest(mi.Float)

        stokes = mi.Vector3f(0)
        if dr.hint(stones.filters is not None, mode="scalar"):
            stokes = stones.filters.stokes(seen_by, seen_along, polarises)
        return L, valid, albedo, normal, stokes


def _of_eye(caustics: Caustics | None, *light: Any) -> mi.Float:
    """Return the share of light that the eye counts, as `Caustics.of_eye`: all where nothing is traced."""
    return mi.Float(1) if caustics is None else caustics.of_eye(*light)


def _as_mueller(radiance: mi.UnpolarizedSpectrum, stokes: mi.Vector3f) -> mi.Spectrum:
    """Return radiance as Mitsuba has it: in polarised variants what unpolarised light becomes."""
    if not mi.is_polarized:
        return radiance
    matrix = mi.Spectrum(0)
    for row, share in enumerate([mi.Float(1), *stokes]):
        matrix[row, 0] = radiance * share
    return matrix


def _as_rgb(value: mi.UnpolarizedSpectrum) -> mi.Color3f:
    """Return a colour that a denoiser can take: of a spectrum its mean."""
    return value if dr.size_v(value) == 3 else mi.Color3f(mean_of(value))


mi.register_integrator("gem_path", lambda props: PathIntegrator(props))

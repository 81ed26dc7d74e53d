"""`gem_path`: a path integrator made for cut stones, with dispersion."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.plugins.checks import SceneCheck
from gemrender.plugins.properties import truth, whole_number
from gemrender.plugins.rough import scattered
from gemrender.plugins.stones import RAY_OFFSET, Stones, reflectance

#: Names of the AOVs, in order: what a denoiser wants to know of the first hit.
AOV_NAMES = ("albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z")

#: Throughput below which a way inside a stone goes on by chance only, and that of a way outside.
ROULETTE_INSIDE, ROULETTE_OUTSIDE = 0.1, 0.15
#: From so many surfaces on, a way goes on with probability `LATE_SURVIVAL` at each, whatever its throughput:
#: rays can be caught by total reflection for ever.
LATE, LATE_SURVIVAL = 1024, 0.98
#: Throughput that counts as none: far below what a picture can show, and its reciprocal is a number still.
NEGLIGIBLE = 1e-30


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
      stone, and each goes on by itself; until then all share a way. A branch outside that is drawn later
      goes on with its own wavelength only, and stands for all. In RGB variants the path draws a wavelength,
      weighted by the linear sRGB response; in monochrome ones all light has the wavelength of the stone's
      ``gem_dielectric``.
    - **Absorption** along the way inside, by the material (Beer and Lambert).
    - Russian roulette goes by the throughput, and total reflection does not lessen it: long bright paths are
      not clipped. Multiple importance sampling (power heuristic) at all other surfaces.

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
        if mi.is_polarized:
            raise InputError("gem_path takes unpolarised variants only", key="variant", value=mi.variant())
        self.max_depth = whole_number(props, "max_depth", -1, least=-1)
        self.aovs = truth(props, "aovs", False)
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
        return super().render(scene, sensor, seed, spp, develop, evaluate)

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        """Return the radiance along a ray from outside all stones; see the class."""
        if len(scene.sensors()) == 1:  # another integrator may ask, which has checked nothing
            self.check(scene, scene.sensors()[0])
        radiance, valid, aovs = self.sample_with_aovs(scene, sampler, ray, active)
        return radiance, valid, aovs if self.aovs else []

    def sample_with_aovs(
        self, scene: mi.Scene, sampler: mi.Sampler, ray: mi.RayDifferential3f, active: mi.Bool = True
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        """Return the radiance along a ray with the AOVs, whether `aovs` asks for them or not."""
        with dr.suspend_grad():
            stones = Stones(scene, sampler, self.scene_check)
            radiance, valid, albedo, normal = self._radiance(
                scene, stones, sampler, mi.Ray3f(ray), mi.Bool(active)
            )
        return radiance, valid, [*albedo, *normal]

    def to_string(self) -> str:
        """Describe the integrator in Mitsuba's manner."""
        return f"PathIntegrator[\n  max_depth = {self.max_depth},\n  aovs = {self.aovs}\n]"

    @dr.syntax
    def _radiance(self, scene, stones, sampler, ray, active):  # type: ignore[no-untyped-def]  # dr.syntax
        max_depth = mi.UInt32(self.max_depth if self.max_depth >= 0 else 0xFFFFFFFF)
        context = mi.BSDFContext()

        L = mi.Spectrum(0)  # radiance found so far
        β = mi.Spectrum(1)  # throughput
        parted = mi.Bool(False)  # whether the wavelengths have parted
        depth = mi.UInt32(0)  # segments so far
        valid = mi.Bool(False)
        first = mi.Bool(True)
        direct = mi.Bool(True)  # whether it has met nothing but mirrors and stones
        albedo, normal = mi.Color3f(0), mi.Vector3f(0)
        from_p = mi.Point3f(ray.o)  # the surface before, for multiple importance sampling
        from_pdf = mi.Float(1)
        from_delta = mi.Bool(True)

        # Inside stones numbers are needed by the dozen, and their spread does not matter there
        seeds = mi.sample_tea_32(
            mi.UInt32(sampler.next_1d() * 4294967040.0), mi.UInt32(sampler.next_1d() * 4294967040.0)
        )
        chance = mi.PCG32(1, mi.UInt64(seeds[0]), mi.UInt64(seeds[1]))

        while dr.hint(active, label="gem_path"):
            si = scene.ray_intersect(ray, mi.RayFlags.AllNonDifferentiable, False, active)
            stone = stones.of(si, active)
            on_stone = active & (stone != 0)

            # ---- Light that the ray ends on ----

            emitter = si.emitter(scene, active & ~on_stone)
            came_from = mi.Interaction3f(0.0, ray.time, ray.wavelengths, from_p)
            ds = mi.DirectionSample3f(scene, si, came_from)
            weigh = active & ~from_delta & (emitter != None)  # noqa: E711 (an array)
            mis = _mis_weight(from_pdf, scene.pdf_emitter_direction(came_from, ds, weigh))
            mis = dr.select(from_delta, 1, mis)
            light = emitter.eval(si, active & ~on_stone)
            L += dr.select(active & ~on_stone, β * mis * light, 0)

            # ---- What a denoiser wants to know ----

            bsdf = si.bsdf(ray)
            seen = first & active & si.is_valid()
            reflects = seen & ~on_stone
            valid |= seen
            normal = dr.select(seen, stones.outward(si, stone, seen), normal)
            diffuse = bsdf.eval_diffuse_reflectance(si, reflects)
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
            smooth = plain & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            ds, em_weight = scene.sample_emitter_direction(si, sampler.next_2d(), True, smooth)
            smooth &= ds.pdf != 0
            wo = si.to_local(ds.d)
            value, pdf = bsdf.eval_pdf(context, si, wo, smooth)
            mis = dr.select(ds.delta, 1, _mis_weight(ds.pdf, pdf))
            L += dr.select(smooth, β * mis * value * em_weight, 0)

            bs, weight = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d(), plain)
            next_ray = si.spawn_ray(si.to_world(bs.wo))
            next_ray.o = dr.select(behind, si.p + RAY_OFFSET * stones.size * ray.d, next_ray.o)
            next_ray.d = dr.select(behind, ray.d, next_ray.d)
            next_β = dr.select(plain, β * weight, β)
            next_parted = mi.Bool(parted)
            next_depth = depth + 1

            # ---- Stones: what is reflected, and into the stone ----

            eta = stones.index(stone, ray.wavelengths, arrives)
            cos_stone = dr.safe_sqrt(1 - (1 - dr.square(cos_air)) / dr.square(eta))
            reflected = reflectance(cos_air, cos_stone, eta)

            side = mi.Bool(arrives)  # whether there is a branch outside to look along
            side_o = mi.Point3f(si.p + RAY_OFFSET * stones.size * n)
            side_d = mi.Vector3f(d + 2 * cos_air * n)
            side_β = mi.Spectrum(β * reflected)
            side_parted = mi.Bool(parted)
            side_counts = mi.Float(1)  # what it counts where one branch is drawn
            side_depth = depth + 1

            # One wavelength after the other where they part here; one way for all where they do not.
            part = arrives & ~parted & stones.disperses(stone, arrives)
            entering = β * (1 - reflected) * dr.select(part, stones.parting_weight(), mi.Spectrum(1))
            in_parted = parted | part
            channel = dr.select(part, mi.UInt32(0), stones.alive(β))
            left = dr.select(part, stones.n_ways - 1, mi.UInt32(0))
            ways = [
                stones.enter(entering, eta, d, n, cos_air, mi.UInt32(k), part) for k in range(stones.n_ways)
            ]
            β_in, n_in, d_in = stones.enter(entering, eta, d, n, cos_air, channel, part)
            start = mi.Point3f(stones.inwards(si.p, n))
            inside = mi.Bool(arrives)

            # ---- A rough girdle: one way by chance, with all the light ----

            if dr.hint(stones.any_rough, mode="scalar"):
                alpha = stones.roughness(stone, n, arrives)
                rough = arrives & (alpha > 0)
                β_one, n_one = stones.one_wavelength(β, eta, part, chance)
                d_one, outside = scattered(mi.Vector3f(ray.d), n, arrives, n_one, alpha, chance, rough)
                side &= ~rough | outside
                inside &= ~(rough & outside)
                side_d = dr.select(rough, d_one, side_d)
                side_β = dr.select(rough, β_one, side_β)
                side_parted |= rough & part & mi.Bool(stones.n_ways > 1)
                β_in = dr.select(
                    rough, β_one * dr.select(part, stones.parting_weight(), mi.Spectrum(1)), β_in
                )
                n_in, d_in = dr.select(rough, n_one, n_in), dr.select(rough, d_one, d_in)
                part &= ~rough
                left = dr.select(rough, 0, left)

            p, d = mi.Point3f(start), mi.Vector3f(d_in)
            in_depth = depth + 1

            # One branch outside is drawn of those that met neither light nor sky.
            drawn_weight = mi.Float(0)  # sum of the throughputs of all of them
            drawn_o, drawn_d = mi.Point3f(0), mi.Vector3f(0, 0, 1)
            drawn_β, drawn_parted, drawn_depth = mi.Spectrum(0), mi.Bool(False), mi.UInt32(0)

            while dr.hint(inside | side, label="gem_path: inside"):
                # ---- Along the branch outside ----
                branch = mi.Ray3f(side_o, side_d, ray.time, ray.wavelengths)
                found, Le = stones.outside(branch, side)
                L += dr.select(side, side_β * Le, 0)
                share = dr.select(found, side_counts * stones.mean(side_β), 0)
                share = dr.select(share > NEGLIGIBLE, share, 0)
                drawn_weight += share
                take = (share > 0) & (chance.next_float32() * drawn_weight < share)
                drawn_o, drawn_d = dr.select(take, side_o, drawn_o), dr.select(take, side_d, drawn_d)
                drawn_β = dr.select(take, side_counts * side_β, drawn_β)
                drawn_parted = dr.select(take, side_parted, drawn_parted)
                drawn_depth = dr.select(take, side_depth, drawn_depth)

                # ---- To the next facet, and through it ----
                t, n, met = stones.next_surface(stone, p, d, inside)
                inside &= met & (in_depth < max_depth)
                p = dr.select(inside, p + t * d, p)
                β_in *= stones.transmittance(stone, ray.wavelengths, t, inside)
                cos_i = dr.dot(n, d)
                sin2 = dr.square(n_in) * (1 - dr.square(cos_i))
                leaves = inside & (sin2 < 1)
                cos_t = dr.safe_sqrt(1 - sin2)
                back = dr.select(leaves, reflectance(cos_t, cos_i, n_in), 1)
                d_out = n_in * (d - cos_i * n) + cos_t * n
                d_back = d - 2 * cos_i * n
                if dr.hint(stones.any_rough, mode="scalar"):
                    alpha = stones.roughness(stone, n, inside)
                    rough = inside & (alpha > 0)
                    d_one, outside = scattered(d, n, mi.Bool(False), n_in, alpha, chance, rough)
                    leaves = dr.select(rough, outside, leaves)
                    back = dr.select(rough, dr.select(outside, mi.Float(0), 1), back)
                    d_out, d_back = dr.select(rough, d_one, d_out), dr.select(rough, d_one, d_back)
                side = leaves & (in_depth + 2 <= max_depth)
                side_o = mi.Point3f(p + RAY_OFFSET * stones.size * n)
                side_d = dr.normalize(d_out)
                side_β = β_in * (1 - back)
                side_parted = mi.Bool(in_parted)
                # Of many ways the first stands for all: samples spread its wavelength evenly.
                side_counts = dr.select(part, dr.select(channel == 0, mi.Float(stones.n_ways), 0), 1)
                side_depth = in_depth + 1
                β_in *= back
                d = d_back
                p = stones.inwards(p, n)
                in_depth += 1

                # ---- Russian roulette ----
                q = dr.minimum(stones.weight(β_in, part & direct) * (1 / ROULETTE_INSIDE), 1)
                q = dr.select(in_depth > LATE, q * LATE_SURVIVAL, q)
                inside &= (chance.next_float32() < q) & (q > NEGLIGIBLE)
                β_in *= dr.select(inside, dr.rcp(q), 0)

                # ---- The next wavelength ----
                if dr.hint(stones.n_ways > 1, mode="scalar"):
                    again = arrives & ~inside & (left > 0)
                    left = dr.select(again, left - 1, left)
                    channel = dr.select(again, channel + 1, channel)
                    for k in range(1, stones.n_ways):
                        this = again & (channel == k)
                        β_in = dr.select(this, ways[k][0], β_in)
                        n_in = dr.select(this, ways[k][1], n_in)
                        d = dr.select(this, ways[k][2], d)
                    p = dr.select(again, start, p)
                    in_depth = dr.select(again, depth + 1, in_depth)
                    inside |= again

            drawn = arrives & (drawn_weight > 0)
            ray.o = dr.select(drawn, drawn_o, next_ray.o)
            ray.d = dr.select(drawn, drawn_d, next_ray.d)
            β = dr.select(drawn, drawn_β * (drawn_weight / stones.mean(drawn_β)), next_β)
            parted = dr.select(drawn, drawn_parted, next_parted)
            depth = dr.select(drawn, drawn_depth, next_depth)
            from_p = dr.select(plain, si.p, from_p)
            from_pdf = dr.select(plain, bs.pdf, 1)
            direct &= ~plain | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            from_delta = ~plain | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)

            active = drawn | behind | (plain & (stones.mean(β) > 0))
            q = dr.minimum(stones.mean(β) * (1 / ROULETTE_OUTSIDE), 1)
            q = dr.select(depth > LATE, q * LATE_SURVIVAL, q)
            active &= (chance.next_float32() < q) & (q > NEGLIGIBLE)
            β *= dr.select(active, dr.rcp(q), 0)
            ray.maxt = dr.largest(mi.Float)

        return L, valid, albedo, normal


def _mis_weight(pdf: mi.Float, other: mi.Float) -> mi.Float:
    """Power heuristic (Veach 1997, section 9.2.4) for a sample of density `pdf`, against one other."""
    # By the ratio: the square of a density can be infinite where a light is seen edge-on
    return dr.select(pdf > 0, dr.rcp(1 + dr.square(other / pdf)), 0)


def _as_rgb(value: mi.Spectrum) -> mi.Color3f:
    """Return a colour that a denoiser can take: of a spectrum its mean."""
    return value if dr.size_v(value) == 3 else mi.Color3f(dr.mean(value))


mi.register_integrator("gem_path", lambda props: PathIntegrator(props))

"""`gem_primary`: an AOV integrator that follows the principal ray through a stone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.observation import (
    CROSSING_CHANNELS,
    GROUND,
    INTENSITIES,
    LATER_CHANNELS,
    LIGHT_LEVEL,
    MAP_CHANNELS,
    MOST_REFLECTIONS,
    PATH_CODE_FACTOR,
    PATH_CODE_MASK,
    REAR_RULES,
    RayStatus,
)
from gemrender.optics.fresnel import (
    FRESNEL_LAWS,
    GUBELIN_ANGLES_DEG,
    GUBELIN_INDEX,
    GUBELIN_REFLECTED,
    LEAST_TOTAL,
)
from gemrender.paths import FOLLOW
from gemrender.plugins.checks import FacetCheck
from gemrender.plugins.properties import choice, number, whole_number
from gemrender.plugins.stones import reflectance
from gemrender.plugins.surfaces import RAY_OFFSET, Way, enter, meet, set_out, turn
from gemrender.stone.facets import LEVEL


def _names(*parts: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(name for part in parts for names in part.values() for name in names)


#: The integrator's channels, in order, after the film's own; where all light is followed, all of them.
AOV_NAMES, PATH_NAMES, LATER_NAMES = (
    _names(MAP_CHANNELS),
    _names(MAP_CHANNELS, CROSSING_CHANNELS),
    _names(LATER_CHANNELS),
)

#: How far the relative index may be from the one that Gübelin's table holds for: as far as air's from 1.
GUBELIN_MARGIN = 1e-3


class PrimaryIntegrator(mi.SamplingIntegrator):
    r"""
    .. _integrator-gem_primary:

    Principal rays of a cut stone (:monosp:`gem_primary`)
    -----------------------------------------------------

    .. pluginparameters::

     * - int_ior
       - |float|
       - Refractive index of the stone. (Default: 2.4173, diamond at 589.3 nm)
       - |exposed|

     * - ext_ior
       - |float|
       - Refractive index of what surrounds it. (Default: 1.0)
       - |exposed|

     * - fresnel
       - |string|
       - Transmittance law: ``gubelin``, the table of Inoue's paper (diamond only), or ``exact``, the
         unpolarised Fresnel equations. (Default: ``gubelin``)
       -

     * - rear
       - |string|
       - What counts as rear light: light that came in below the girdle's lower edge, z <= 0
         (``position``), light that came in through a facet that faces down (``facet``), or light from
         below the horizon (``direction``). (Default: ``position``)
       -

     * - ground
       - |float|
       - Height of the girdle's lower edge, for ``position``: z = 0, within rounding. (Default: 1e-10)
       -

     * - intensity
       - |string|
       - ``primary``, the paper's intensity per unit cross-section of the beam, or ``radiance``, without
         the change of the cross-section. (Default: ``primary``)
       -

     * - max_reflections
       - |int|
       - Number of reflections inside after which a ray counts as trapped. (Default: 1000)
       - |exposed|

     * - follow
       - |string|
       - Which light is followed: ``principal``, or ``all``, where what the principal path's surface
         reflects goes on, and a later exit is drawn. (Default: ``principal``)
       -

    Follows each sensor ray into the stone by refraction, on by total reflection, and out where it first
    meets a surface below the critical angle: the ray is followed backwards, so this is where its light
    came in. Weaker branches are ignored (Inoue; ``docs/model.md``, section 4). The colour channels hold the
    radiance that the scene's emitters send along this one path, and black outside the stone. The AOVs are

    - ``primary.intensity`` [%], ``rear.mask``, ``coverage`` (1 where the stone is),
    - ``status`` (0 missed, 1 exited, 2 trapped, 3 lost), ``reflections``,
    - ``exit.x``, ``.y``, ``.z`` [scene units] and ``exit.dx``, ``.dy``, ``.dz`` (unit vector): where and in
      which direction the ray followed back leaves the stone,
    - ``entry.facet``, ``exit.facet`` (-1 for none), ``path.code``, a 24-bit code of the facet sequence.

    With ``follow`` ``all``, the ray goes on from there with what that surface reflects. Wherever it meets a
    surface below the critical angle again, it leaves with the probability T = 1 - R or goes on with R, the
    reflectance of unpolarised light by Fresnel's equations, whatever ``fresnel`` says: one later exit of all
    that there are. These AOVs come after the others:

    - ``entry.nx``, ``.ny``, ``.nz``: the outward normal where the ray enters, and ``entry.cosine``,
      ``exit.cosine``: of the angles in air at both crossings (0 for none),
    - ``later.status`` (0 where there is no later exit, the others as above), ``later.reflections``, all that
      there were inside, and ``later.partial``, the partial ones among them, at least 1,
    - ``later.weight``, the product of the reflectances at these, and ``later.probability``, by which this
      exit was chosen,
    - ``later.x``, ``.y``, ``.z``, ``later.dx``, ``.dy``, ``.dz``, ``later.facet``, ``later.cosine``: as of
      the exit.

    What a sum over all later exits has is, on average, what this one has divided by ``later.probability``.
    The colours remain those of the principal path. The sampler must be a random one: of ``stratified``
    without ``jitter`` all pixels get the same number.

    The stone is a mesh in its own frame (table up, about the origin; round girdles of radius 1), convex or
    not, with facets and planes as face attributes; ``gemrender scene`` writes it, others are refused, and so
    are those that have been moved since. Positions and directions are in double precision. With more samples
    than one a pixel, AOVs are averages.

    .. tabs::
        .. code-tab:: xml
            :name: gem-primary

            <integrator type="gem_primary">
                <float name="int_ior" value="2.4173"/>
                <string name="fresnel" value="exact"/>
            </integrator>

        .. code-tab:: python

            'type': 'gem_primary',
            'int_ior': 2.4173,
            'fresnel': 'exact'

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.fresnel = choice(props, "fresnel", FRESNEL_LAWS)
        self.rear = choice(props, "rear", REAR_RULES)
        self.ground = number(props, "ground", GROUND)
        self.intensity = choice(props, "intensity", INTENSITIES)
        self.follow = choice(props, "follow", FOLLOW)
        self.int_ior = mi.Float64(number(props, "int_ior", GUBELIN_INDEX))
        self.ext_ior = mi.Float64(number(props, "ext_ior", 1.0))
        self.max_reflections = mi.UInt32(whole_number(props, "max_reflections", MOST_REFLECTIONS, least=1))
        # One of three heights and its limit, not compiled in: that of the place, the normal or the direction.
        below_level = -math.nextafter(LEVEL, 1.0)
        limits = {"position": self.ground, "facet": below_level, "direction": 0.0}
        self._rear_rule = (
            dr.opaque(mi.Vector3d, [float(self.rear == rule) for rule in limits]),
            dr.opaque(mi.Float64, limits[self.rear]),
        )
        self.facet_check = FacetCheck()
        self.table_angles = mi.Float(GUBELIN_ANGLES_DEG)
        self.table_reflected = mi.Float(GUBELIN_REFLECTED)
        self._update()

    def _update(self) -> None:
        """Check the parameters that can change, and keep them out of the kernel: literals are compiled in."""
        int_ior, ext_ior = self.int_ior[0], self.ext_ior[0]
        if not 0 < ext_ior < int_ior < math.inf:
            raise InputError(f"must be greater than ext_ior = {ext_ior:g}", key="int_ior", value=int_ior)
        if self.fresnel == "gubelin" and abs(int_ior / ext_ior - GUBELIN_INDEX) > GUBELIN_MARGIN:
            raise InputError(
                f"Gübelin's table holds for a relative index of {GUBELIN_INDEX} (diamond) only; "
                "set fresnel to exact",
                key="int_ior",
                value=int_ior,
            )
        if self.max_reflections[0] < 1:
            raise InputError("must be at least 1", key="max_reflections", value=self.max_reflections[0])
        dr.make_opaque(self.int_ior, self.ext_ior, self.max_reflections)

    def traverse(self, cb: mi.TraversalCallback) -> None:
        """Expose the parameters that can change without a new kernel."""
        cb.put("int_ior", self.int_ior, mi.ParamFlags.NonDifferentiable)
        cb.put("ext_ior", self.ext_ior, mi.ParamFlags.NonDifferentiable)
        cb.put("max_reflections", self.max_reflections, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: list[str]) -> None:
        """Take over changed parameters."""
        self._update()

    def aov_names(self) -> list[str]:
        """Return the names of the channels after the film's own."""
        return list(AOV_NAMES if self.follow == "principal" else PATH_NAMES + LATER_NAMES)

    def sample(
        self,
        scene: mi.Scene,
        sampler: mi.Sampler,
        ray: mi.RayDifferential3f,
        medium: mi.Medium | None = None,
        active: mi.Bool = True,
    ) -> tuple[mi.Spectrum, mi.Bool, list[mi.Float]]:
        """Follow one ray; see the class."""
        hides = self.facet_check.hides(scene)
        with dr.suspend_grad():
            path = self._follow(scene, mi.Ray3f(ray), mi.Bool(active))
            transmitted, values = self._measure(scene, sampler, path)
            exited = path.status == int(RayStatus.EXITED)
            light = self._light(scene, ray, path.way.p, path.way.d, exited, hides)
            light = dr.select(exited, mi.Spectrum(mi.Float(transmitted)) * light, 0)
            return light, path.hit, [mi.Float(values[name]) for name in self.aov_names()]

    def measure(
        self, scene: mi.Scene, ray: mi.RayDifferential3f, sampler: mi.Sampler | None = None
    ) -> list[mi.Float]:
        """Return the AOVs alone, which are the same whatever light there is; all light needs a sampler."""
        values = self.trace(scene, ray, sampler)
        return [mi.Float(values[name]) for name in self.aov_names()]

    def trace(
        self, scene: mi.Scene, ray: mi.RayDifferential3f, sampler: mi.Sampler | None = None
    ) -> dict[str, mi.Float | mi.Float64 | mi.UInt32]:
        """Return the AOVs by name and in full precision, those of the crossings in any case."""
        self.facet_check.hides(scene)
        with dr.suspend_grad():
            return self._measure(scene, sampler, self._follow(scene, mi.Ray3f(ray), mi.Bool(True)))[1]

    def to_string(self) -> str:
        """Describe the integrator in Mitsuba's manner."""
        return (
            f"PrimaryIntegrator[\n  int_ior = {self.int_ior[0]:g},\n  ext_ior = {self.ext_ior[0]:g},\n"
            f"  fresnel = {self.fresnel},\n  rear = {self.rear},\n  intensity = {self.intensity},\n"
            f"  max_reflections = {self.max_reflections[0]},\n  follow = {self.follow}\n]"
        )

    @dr.syntax
    def _follow(self, scene, ray, active):  # type: ignore[no-untyped-def]  # dr.syntax reads the source
        eta = self.int_ior / self.ext_ior

        # ---- Into the stone: refraction at the first surface ----

        entry = enter(scene, ray, active)
        hit, n, cos_air_eye = entry.hit, entry.normal, entry.cos_air
        sin2 = (1 - dr.square(cos_air_eye)) / dr.square(eta)
        cos_stone_eye = dr.safe_sqrt(1 - sin2)
        d = (entry.direction + cos_air_eye * n) / eta - cos_stone_eye * n

        # ---- From surface to surface by total reflection, until the ray leaves ----

        p = dr.select(hit, entry.point, 0)
        d = dr.select(hit, d, mi.Vector3d(0, 0, -1))
        way = set_out(p, d, entry.on_wall)
        inside = mi.Bool(hit)
        status = dr.select(hit, mi.UInt32(int(RayStatus.TRAPPED)), mi.UInt32(int(RayStatus.MISSED)))
        reflections = mi.UInt32(0)
        facet = mi.Float(-1)
        code = dr.select(hit, mi.UInt32(entry.facet) + 1, 0)
        cos_stone = mi.Float64(1)  # of the angle inside, where the ray leaves
        cos_air = mi.Float64(1)  # of the angle outside
        normal = mi.Vector3d(0)  # there

        while dr.hint(inside, label="gem_primary"):
            met = meet(scene, way, inside)
            status[inside & ~met.found & ~met.again] = mi.UInt32(int(RayStatus.LOST))
            code = dr.select(
                met.found, (code * PATH_CODE_FACTOR + mi.UInt32(met.facet) + 1) & PATH_CODE_MASK, code
            )

            d, n, cos_i = way.d, met.normal, met.cos
            sin2 = dr.square(eta) * (1 - dr.square(cos_i))
            exits = met.found & (sin2 < LEAST_TOTAL)  # is_totally_reflected, in double precision as all here
            cos_t = dr.safe_sqrt(1 - sin2)
            status[exits] = mi.UInt32(int(RayStatus.EXITED))
            facet = dr.select(exits, met.facet, facet)
            cos_stone = dr.select(exits, cos_i, cos_stone)
            cos_air = dr.select(exits, cos_t, cos_air)
            normal = dr.select(exits, n, normal)

            reflects = met.found & ~exits & (reflections < self.max_reflections)
            refracted = eta * (d - cos_i * n) + cos_t * n
            d = dr.select(exits, refracted, dr.select(reflects, d - 2 * cos_i * n, d))
            reflections[reflects] += 1
            inside = reflects | met.again
            way = turn(way, met, d)

        return _Path(
            hit=hit,
            status=status,
            reflections=reflections,
            entry_facet=entry.facet,
            entry_normal=entry.normal,
            exit_facet=facet,
            code=code,
            way=way,
            eye_side=(cos_air_eye, cos_stone_eye),
            light_side=(cos_air, cos_stone),
            normal=normal,
        )

    @dr.syntax
    def _follow_on(self, scene, sampler, path):  # type: ignore[no-untyped-def]  # dr.syntax reads the source
        """Follow what is reflected where the principal path leaves, to one later exit."""
        eta = self.int_ior / self.ext_ior

        # ---- Reflection where the principal path leaves: it is certain ----

        inside = path.status == int(RayStatus.EXITED)
        (cos_air, cos_stone), n = path.light_side, path.normal
        weight = reflectance(cos_air, cos_stone, eta)
        probability = mi.Float64(1)
        partial = mi.UInt32(1)
        d = (path.way.d - cos_air * n) / eta - cos_stone * n
        way = set_out(path.way.p, dr.normalize(d), path.way.on_wall)
        status = dr.select(inside, mi.UInt32(int(RayStatus.TRAPPED)), mi.UInt32(int(RayStatus.MISSED)))
        any_later = mi.Bool(inside)
        inside &= path.reflections < self.max_reflections
        reflections = dr.select(inside, path.reflections + 1, path.reflections)
        facet = mi.Float(-1)
        cos_out = mi.Float64(0)  # of the angle in air, where it leaves

        # ---- From surface to surface, until it leaves by chance ----

        while dr.hint(inside, label="gem_primary: all light"):
            met = meet(scene, way, inside)
            status[inside & ~met.found & ~met.again] = mi.UInt32(int(RayStatus.LOST))

            d, n, cos_i = way.d, met.normal, met.cos
            sin2 = dr.square(eta) * (1 - dr.square(cos_i))
            parts = met.found & (sin2 < LEAST_TOTAL)
            cos_t = dr.safe_sqrt(1 - sin2)
            back = dr.select(parts, reflectance(cos_t, cos_i, eta), 1)
            exits = parts & (mi.Float64(sampler.next_1d(parts)) >= back)
            probability *= dr.select(exits, 1 - back, back)
            status[exits] = mi.UInt32(int(RayStatus.EXITED))
            facet = dr.select(exits, met.facet, facet)
            cos_out = dr.select(exits, cos_t, cos_out)

            reflects = met.found & ~exits
            weight *= dr.select(reflects, back, 1)
            partial[parts & ~exits] += 1
            refracted = eta * (d - cos_i * n) + cos_t * n
            d = dr.select(exits, refracted, dr.select(reflects, d - 2 * cos_i * n, d))
            reflects &= reflections < self.max_reflections
            reflections[reflects] += 1
            inside = reflects | met.again
            way = turn(way, met, d)

        exited = status == int(RayStatus.EXITED)
        p, d = dr.select(exited, way.p, 0), dr.select(exited, way.d, 0)
        counts = (reflections, partial, weight, probability)
        values = (status, *(dr.select(any_later, x, 0) for x in counts), *p, *d, facet, cos_out)
        return dict(zip(LATER_NAMES, values, strict=True))

    def _measure(
        self, scene: mi.Scene, sampler: mi.Sampler | None, path: _Path
    ) -> tuple[mi.Float64, dict[str, mi.Float | mi.Float64 | mi.UInt32]]:
        """Return the share of the light that the principal path transmits, and the AOVs."""
        exited = path.status == int(RayStatus.EXITED)
        p, d = path.way.p, path.way.d
        chosen, most = self._rear_rule
        rear = exited & (dr.dot(chosen, mi.Vector3d(p.z, path.normal.z, d.z)) <= most)
        transmitted = self._transmittance(*path.eye_side) * self._transmittance(*path.light_side)
        intensity = LIGHT_LEVEL * transmitted
        (air_eye, stone_eye), (air_light, stone_light) = path.eye_side, path.light_side
        if self.intensity == "primary":
            # S1/S2 at both crossings, as the light travels (the paper's section 2.2)
            intensity *= (air_light / stone_light) * (stone_eye / air_eye)
        p, d = dr.select(exited, p, 0), dr.select(exited, d, 0)
        values = (
            dr.select(exited & ~rear, intensity, 0),
            dr.select(rear, mi.Float(1), 0),
            dr.select(path.hit, mi.Float(1), 0),
            path.status,
            path.reflections,
            *p,
            *d,
            dr.select(path.hit, path.entry_facet, -1),
            path.exit_facet,
            path.code,
            *dr.select(path.hit, path.entry_normal, 0),
            dr.select(path.hit, air_eye, 0),
            dr.select(exited, air_light, 0),
        )
        out = dict(zip(PATH_NAMES, values, strict=True))
        if self.follow == "all":
            out |= self._follow_on(scene, sampler, path)
        return transmitted, out

    def _transmittance(self, cos_air: mi.Float64, cos_stone: mi.Float64) -> mi.Float64:
        """Return the transmitted share at one crossing, from both of its angles."""
        eta = self.int_ior / self.ext_ior
        if self.fresnel == "exact":
            return 1 - reflectance(cos_air, cos_stone, eta)
        angle = dr.rad2deg(dr.safe_acos(mi.Float(cos_air)))
        row = mi.UInt32(0)
        for k in range(1, len(GUBELIN_ANGLES_DEG) - 1):
            row += dr.select(angle >= mi.Float(GUBELIN_ANGLES_DEG[k]), mi.UInt32(1), 0)
        a0, a1 = dr.gather(mi.Float, self.table_angles, row), dr.gather(mi.Float, self.table_angles, row + 1)
        r0 = dr.gather(mi.Float, self.table_reflected, row)
        r1 = dr.gather(mi.Float, self.table_reflected, row + 1)
        return mi.Float64(1 - (r0 + (r1 - r0) * (angle - a0) / (a1 - a0)))

    def _light(
        self,
        scene: mi.Scene,
        ray: mi.Ray3f,
        p: mi.Point3d,
        d: mi.Vector3d,
        active: mi.Bool,
        hides: bool,
    ) -> mi.Spectrum:
        """Radiance that arrives from outside along the ray that left the stone."""
        outside = mi.Ray3f(mi.Point3f(p), mi.Vector3f(d), ray.time, ray.wavelengths)
        environment = scene.environment()
        if environment is not None and not hides:
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi = -outside.d
            si.wavelengths = ray.wavelengths
            return environment.eval(si, active)
        outside.o += RAY_OFFSET * mi.Vector3f(d)
        si = scene.ray_intersect(outside, active)
        return si.emitter(scene, active).eval(si, active)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Path:
    """What is known of a ray that has been followed; arrays, one value a ray."""

    hit: mi.Bool
    status: mi.UInt32
    reflections: mi.UInt32
    entry_facet: mi.Float
    entry_normal: mi.Vector3d
    exit_facet: mi.Float
    code: mi.UInt32
    way: Way  # where the ray leaves the stone, and in which direction
    eye_side: tuple[mi.Float64, mi.Float64]  # cosines of the angles in air and in the stone
    light_side: tuple[mi.Float64, mi.Float64]
    normal: mi.Vector3d  # where it leaves


mi.register_integrator("gem_primary", lambda props: PrimaryIntegrator(props))

"""`gem_primary`: an AOV integrator that follows the principal ray through a stone."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.observation import (
    CROSSING_CHANNELS,
    GROUND,
    INTENSITIES,
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
from gemrender.plugins.crystals import Crystal
from gemrender.plugins.primary_later import LATER_NAMES, follow_on
from gemrender.plugins.primary_modes import Path, follow_modes
from gemrender.plugins.properties import choice, crystal_axes, number, three_numbers, whole_number
from gemrender.plugins.stones import reflectance
from gemrender.plugins.surfaces import RAY_OFFSET, enter, meet, set_out, turn
from gemrender.stone.facets import LEVEL


def _names(*parts: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(name for part in parts for names in part.values() for name in names)


#: The integrator's channels, in order, after the film's own; where all light is followed, all of them.
AOV_NAMES, PATH_NAMES = _names(MAP_CHANNELS), _names(MAP_CHANNELS, CROSSING_CHANNELS)

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
       - Refractive index of what surrounds it; exposed without ``principal``. (Default: 1.0)
       - |exposed|

     * - principal
       - |vector|
       - In place of ``int_ior``, of a birefringent stone: its principal indices, along ``a_axis``, across
         both axes, and along ``c_axis``. Its light is split, see below.
       -

     * - c_axis, a_axis
       - |vector|
       - The axes of its crystal, at right angles; of two indices ``c_axis`` is the optic axis, and any
         ``a_axis`` will do. (Default: 0, 0, 1, and any across it)
       -

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
    without ``jitter`` all pixels get the same number, so it is refused.

    With ``principal``, light inside is in one of two modes at a time (``docs/exact-engine.md``, birefringent
    stones): by their shares the sampler draws which one enters, and which one goes on from each total
    reflection. Where the ray first may leave it does, as above. T is what enters, and what of its mode
    leaves, and the beam's cross-section is that across the ray, along which its energy goes. A sample has one
    history of modes, and the mean over samples is that over all: ``gemrender score --birefringence`` tells
    it. Waves are in double precision, and ``fresnel`` is ``exact``; ``follow`` must be ``principal``, and the
    sampler a random one.

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
        self.crystal = self._crystal(props) if "principal" in props else None
        self.fresnel = choice(props, "fresnel", FRESNEL_LAWS if self.crystal is None else ("exact",))
        self.rear = choice(props, "rear", REAR_RULES)
        self.ground = number(props, "ground", GROUND)
        self.intensity = choice(props, "intensity", INTENSITIES)
        self.follow = choice(props, "follow", FOLLOW)
        least = GUBELIN_INDEX if self.crystal is None else min(self.principal)
        self.int_ior = mi.Float64(number(props, "int_ior", least))
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
        if self.crystal is not None and self.follow == "all":
            raise InputError(
                "must be principal: all light is followed in stones of one index only",
                key="follow",
                value=self.follow,
            )

    def _crystal(self, props: mi.Properties) -> Crystal:
        """Read the crystal of a birefringent stone."""
        if "int_ior" in props:
            raise InputError("needs int_ior or principal, not both", key="int_ior", value=props["int_ior"])
        indices, ext_ior = three_numbers(props, "principal"), number(props, "ext_ior", 1.0)
        if not 0 < ext_ior < indices.min():
            raise InputError(
                f"must be greater than ext_ior = {ext_ior:g}", key="principal", value=indices.tolist()
            )
        self.principal = tuple(indices.tolist())
        return Crystal(indices / ext_ior, crystal_axes(props))

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
        if self.crystal is None:
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
            path = self._path(scene, sampler, mi.Ray3f(ray), mi.Bool(active))
            values = self._measure(scene, sampler, path)
            exited = path.status == int(RayStatus.EXITED)
            light = self._light(scene, ray, path.way.p, path.way.d, exited, hides)
            light = dr.select(exited, mi.Spectrum(mi.Float(path.transmitted)) * light, 0)
            return light, path.hit, [mi.Float(values[name]) for name in self.aov_names()]

    def measure(
        self, scene: mi.Scene, ray: mi.RayDifferential3f, sampler: mi.Sampler | None = None
    ) -> list[mi.Float]:
        """Return the AOVs alone, the same whatever light there is; all light and modes need a sampler."""
        values = self.trace(scene, ray, sampler)
        return [mi.Float(values[name]) for name in self.aov_names()]

    def trace(
        self, scene: mi.Scene, ray: mi.RayDifferential3f, sampler: mi.Sampler | None = None
    ) -> dict[str, mi.Float | mi.Float64 | mi.UInt32]:
        """Return the AOVs by name and in full precision, those of the crossings in any case."""
        self.facet_check.hides(scene)
        with dr.suspend_grad():
            path = self._path(scene, sampler, mi.Ray3f(ray), mi.Bool(True))
            return self._measure(scene, sampler, path)

    def to_string(self) -> str:
        """Describe the integrator in Mitsuba's manner."""
        inside = f"int_ior = {self.int_ior[0]:g}"
        if self.crystal is not None:
            inside = f"principal = {', '.join(f'{index:g}' for index in self.principal)}"
        return (
            f"PrimaryIntegrator[\n  {inside},\n  ext_ior = {self.ext_ior[0]:g},\n"
            f"  fresnel = {self.fresnel},\n  rear = {self.rear},\n  intensity = {self.intensity},\n"
            f"  max_reflections = {self.max_reflections[0]},\n  follow = {self.follow}\n]"
        )

    def _path(self, scene: mi.Scene, sampler: mi.Sampler | None, ray: mi.Ray3f, active: mi.Bool) -> Path:
        """Follow rays, in modes if the stone is birefringent."""
        if self.crystal is not None or self.follow == "all":
            _require_random(sampler)
        if self.crystal is None:
            path: Path = self._follow(scene, ray, active)
        else:
            path = follow_modes(scene, sampler, self.crystal, self.max_reflections, ray, active)
        return path

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

        eye_side, light_side = (cos_air_eye, cos_stone_eye), (cos_air, cos_stone)
        return Path(
            hit=hit,
            status=status,
            reflections=reflections,
            entry_facet=entry.facet,
            entry_normal=entry.normal,
            exit_facet=facet,
            code=code,
            way=way,
            eye_side=eye_side,
            light_side=light_side,
            normal=normal,
            transmitted=self._transmittance(*eye_side) * self._transmittance(*light_side),
            # S1/S2 at both crossings, as the light travels (the paper's section 2.2)
            section=(cos_air / cos_stone) * (cos_stone_eye / cos_air_eye),
        )

    def _measure(
        self, scene: mi.Scene, sampler: mi.Sampler | None, path: Path
    ) -> dict[str, mi.Float | mi.Float64 | mi.UInt32]:
        """Return the AOVs of a path."""
        exited = path.status == int(RayStatus.EXITED)
        p, d = path.way.p, path.way.d
        chosen, most = self._rear_rule
        rear = exited & (dr.dot(chosen, mi.Vector3d(p.z, path.normal.z, d.z)) <= most)
        intensity = LIGHT_LEVEL * path.transmitted
        if self.intensity == "primary":
            intensity *= path.section
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
            dr.select(path.hit, path.eye_side[0], 0),
            dr.select(exited, path.light_side[0], 0),
        )
        out = dict(zip(PATH_NAMES, values, strict=True))
        if self.follow == "all":
            out |= follow_on(scene, sampler, self.int_ior / self.ext_ior, self.max_reflections, path)
        return out

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


def _require_random(sampler: mi.Sampler | None) -> None:
    """Refuse a sampler by which nothing can be drawn: none, or one whose numbers are the same everywhere."""
    if sampler is None or "jitter = 0" in str(sampler):
        value = None if sampler is None else sampler.class_name()
        raise InputError("must be a random one, such as independent", key="sampler", value=value)


mi.register_integrator("gem_primary", lambda props: PrimaryIntegrator(props))

"""`gem_primary`: an AOV integrator that follows the principal ray through a stone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.observation import (
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
from gemrender.plugins.checks import FacetCheck
from gemrender.plugins.properties import choice, number, whole_number
from gemrender.scene.mesh import FACET_ATTRIBUTE, NORMAL_ATTRIBUTES, OFFSET_ATTRIBUTES
from gemrender.stone.facets import LEVEL

#: The integrator's channels, in order, after the film's own.
AOV_NAMES = tuple(name for names in MAP_CHANNELS.values() for name in names)

#: How far the search for the next facet starts from the last one [girdle radius]. Must exceed the sagitta
#: of the mesh's girdle (4.7e-6) and single precision's rounding at distance 1 (6e-8).
RAY_OFFSET = 1e-5

#: How far a surface's place along a ray may be from the mesh's [girdle radius]: more than the girdle's chords
#: and arcs are apart along a ray that grazes it (3e-3), less than most ways through the stone.
MOST_APART = 1e-2

#: A ray that runs along a round girdle meets it so far behind the mesh's chord, or more, that it may meet a
#: facet in between [girdle radius]. At steeper angles chord and wall are closer.
GRAZING = 2e-5
#: How far aside a second look is taken for that facet [girdle radius]: more than the sagitta of the chords.
ASIDE = 1e-5

#: How far the relative index may be from the one that Gübelin's table holds for: as far as air's from 1.
GUBELIN_MARGIN = 1e-3

#: Further queries, beyond a surface that was passed by or beside the last place, before a ray is lost.
MOST_RETRIES = 8


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
       - Number of total reflections after which a ray counts as trapped. (Default: 1000)
       - |exposed|

    Follows each sensor ray into the stone by refraction, on by total reflection, and out where it first
    meets a surface below the critical angle: the ray is followed backwards, so this is where its light
    came in. Weaker branches are ignored (Inoue; ``docs/model.md``, section 4). The colour channels hold the
    radiance that the scene's emitters send along this one path, and black outside the stone. The AOVs are

    - ``primary.intensity`` [%], ``rear.mask``, ``coverage`` (1 where the stone is),
    - ``status`` (0 missed, 1 exited, 2 trapped, 3 lost), ``reflections``,
    - ``exit.x``, ``.y``, ``.z`` [scene units] and ``exit.dx``, ``.dy``, ``.dz`` (unit vector): where and in
      which direction the ray followed back leaves the stone,
    - ``entry.facet``, ``exit.facet`` (-1 for none), ``path.code``, a 24-bit code of the facet sequence.

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
        return list(AOV_NAMES)

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
            transmitted, aovs = self._measure(path)
            exited = path.status == int(RayStatus.EXITED)
            light = self._light(scene, ray, path.point, path.direction, exited, hides)
            return dr.select(exited, mi.Spectrum(mi.Float(transmitted)) * light, 0), path.hit, aovs

    def measure(self, scene: mi.Scene, ray: mi.RayDifferential3f) -> list[mi.Float]:
        """Return the AOVs alone, which are the same whatever light there is."""
        self.facet_check.hides(scene)
        with dr.suspend_grad():
            return self._measure(self._follow(scene, mi.Ray3f(ray), mi.Bool(True)))[1]

    def to_string(self) -> str:
        """Describe the integrator in Mitsuba's manner."""
        return (
            f"PrimaryIntegrator[\n  int_ior = {self.int_ior[0]:g},\n  ext_ior = {self.ext_ior[0]:g},\n"
            f"  fresnel = {self.fresnel},\n  rear = {self.rear},\n  intensity = {self.intensity},\n"
            f"  max_reflections = {self.max_reflections[0]}\n]"
        )

    @dr.syntax
    def _follow(self, scene, ray, active):  # type: ignore[no-untyped-def]  # dr.syntax reads the source
        eta = self.int_ior / self.ext_ior

        # ---- Into the stone: refraction at the first surface ----

        si = _first_hit(scene, ray, active)
        hit = active & si.is_valid()
        entry_facet, n, offset = _surface(si, hit)
        on_wall = _is_wall(n)
        d = dr.normalize(mi.Vector3d(ray.d))
        p, n = _meet(mi.Point3d(ray.o), d, n, offset, entering=True)
        cos_air_eye = -dr.dot(n, d)
        hit &= cos_air_eye > 0
        sin2 = (1 - dr.square(cos_air_eye)) / dr.square(eta)
        cos_stone_eye = dr.safe_sqrt(1 - sin2)
        d = (d + cos_air_eye * n) / eta - cos_stone_eye * n

        # ---- From surface to surface by total reflection, until the ray leaves ----

        p = dr.select(hit, p, 0)
        d = dr.select(hit, d, mi.Vector3d(0, 0, -1))
        retries = mi.UInt32(0)
        start = _query_start(p, d, on_wall, retries)  # p itself stays on the surface
        inside = mi.Bool(hit)
        status = dr.select(hit, mi.UInt32(int(RayStatus.TRAPPED)), mi.UInt32(int(RayStatus.MISSED)))
        reflections = mi.UInt32(0)
        facet = mi.Float(-1)
        code = dr.select(hit, mi.UInt32(entry_facet) + 1, 0)
        cos_stone = mi.Float64(1)  # of the angle inside, where the ray leaves
        cos_air = mi.Float64(1)  # of the angle outside
        rise = mi.Float64(0)  # of the normal there
        wall_facet = mi.Float(-1)  # number of the wall that a ray grazes
        to_wall = mi.Float64(
            0
        )  # how far the ray goes to a wall that it grazes, while looking for facets before it

        while dr.hint(inside, label="gem_primary"):
            si = scene.ray_intersect(mi.Ray3f(start, mi.Vector3f(d)), mi.RayFlags.Minimal, False, inside)
            found = inside & si.is_valid()
            facet_here, n, offset = _surface(si, found)
            is_wall = _is_wall(n)
            q, n = _meet(p, d, n, offset)
            cos_i = dr.dot(n, d)
            # Beside an edge the mesh may show a face whose own place on this line is elsewhere.
            apart = dr.dot(q - mi.Point3d(start), d) - mi.Float64(si.t)
            found &= (cos_i > 0) & (dr.abs(apart) < MOST_APART)

            # The mesh's girdle stands inside the true wall: between them a ray along it may meet a facet,
            # which a parallel one a little further inside finds.
            looks_aside = to_wall > 0
            grazes = found & ~looks_aside & is_wall & (apart > GRAZING)
            before_wall = found & ~is_wall & (dr.dot(q - p, d) < to_wall)
            at_wall = looks_aside & ~before_wall
            q = dr.select(at_wall, p + to_wall * d, q)
            n = dr.select(at_wall, _radial(q), n)
            wall_facet = dr.select(grazes, facet_here, wall_facet)
            facet_here = dr.select(at_wall, wall_facet, facet_here)
            is_wall |= at_wall
            cos_i = dr.select(at_wall, dr.dot(n, d), cos_i)
            found = (found | at_wall) & ~grazes
            to_wall = dr.select(grazes, dr.dot(q - p, d), 0)
            # What faces the other way is passed by; a ray may also slip through an edge in single precision.
            retries = dr.select(found | grazes, 0, retries + 1)
            again = inside & ~found & (retries <= MOST_RETRIES)
            status[inside & ~found & ~again] = mi.UInt32(int(RayStatus.LOST))
            beyond = mi.Point3f(mi.Point3d(start) + (mi.Float64(si.t) + RAY_OFFSET) * d)
            p = dr.select(found, q, p)
            code = dr.select(
                found, (code * PATH_CODE_FACTOR + mi.UInt32(facet_here) + 1) & PATH_CODE_MASK, code
            )

            sin2 = dr.square(eta) * (1 - dr.square(cos_i))
            exits = found & (sin2 < LEAST_TOTAL)  # is_totally_reflected, in double precision as all here
            cos_t = dr.safe_sqrt(1 - sin2)
            status[exits] = mi.UInt32(int(RayStatus.EXITED))
            facet = dr.select(exits, facet_here, facet)
            cos_stone = dr.select(exits, cos_i, cos_stone)
            cos_air = dr.select(exits, cos_t, cos_air)
            rise = dr.select(exits, n.z, rise)

            reflects = found & ~exits & (reflections < self.max_reflections)
            refracted = eta * (d - cos_i * n) + cos_t * n
            d = dr.select(exits, refracted, dr.select(reflects, d - 2 * cos_i * n, d))
            reflections[reflects] += 1
            inside = reflects | again
            passes_by = again & si.is_valid() & ~grazes
            aside = mi.Point3f(p + RAY_OFFSET * d - ASIDE * _radial(p + to_wall * d))
            on_wall = dr.select(found, is_wall, on_wall)
            start = dr.select(passes_by, beyond, _query_start(p, d, on_wall, retries))
            start = dr.select(grazes, aside, start)

        return _Path(
            hit=hit,
            status=status,
            reflections=reflections,
            entry_facet=entry_facet,
            exit_facet=facet,
            code=code,
            point=p,
            direction=d,
            eye_side=(cos_air_eye, cos_stone_eye),
            light_side=(cos_air, cos_stone),
            rise=rise,
        )

    def _measure(self, path: _Path) -> tuple[mi.Float64, list[mi.Float]]:
        """Return the share of the light that the path transmits, and the AOVs."""
        exited = path.status == int(RayStatus.EXITED)
        p, d = path.point, path.direction
        chosen, most = self._rear_rule
        rear = exited & (dr.dot(chosen, mi.Vector3d(p.z, path.rise, d.z)) <= most)
        transmitted = self._transmittance(*path.eye_side) * self._transmittance(*path.light_side)
        intensity = LIGHT_LEVEL * transmitted
        if self.intensity == "primary":
            # S1/S2 at both crossings, as the light travels (the paper's section 2.2)
            (air_eye, stone_eye), (air_light, stone_light) = path.eye_side, path.light_side
            intensity *= (air_light / stone_light) * (stone_eye / air_eye)
        p, d = dr.select(exited, p, 0), dr.select(exited, d, 0)
        aovs = [
            mi.Float(dr.select(exited & ~rear, intensity, 0)),
            dr.select(rear, mi.Float(1), 0),
            dr.select(path.hit, mi.Float(1), 0),
            mi.Float(path.status),
            mi.Float(path.reflections),
            *(mi.Float(x) for x in (p.x, p.y, p.z, d.x, d.y, d.z)),
            dr.select(path.hit, path.entry_facet, -1),
            path.exit_facet,
            mi.Float(path.code),
        ]
        return transmitted, aovs

    def _transmittance(self, cos_air: mi.Float64, cos_stone: mi.Float64) -> mi.Float64:
        """Return the transmitted share at one crossing, from both of its angles."""
        eta = self.int_ior / self.ext_ior
        if self.fresnel == "exact":
            # Born & Wolf, 7th ed., section 1.5.2, equations (21a)
            r_s = (cos_air - eta * cos_stone) / (cos_air + eta * cos_stone)
            r_p = (eta * cos_air - cos_stone) / (eta * cos_air + cos_stone)
            return 1 - 0.5 * (dr.square(r_s) + dr.square(r_p))
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
    exit_facet: mi.Float
    code: mi.UInt32
    point: mi.Point3d  # where the ray leaves the stone
    direction: mi.Vector3d  # in which it leaves
    eye_side: tuple[mi.Float64, mi.Float64]  # cosines of the angles in air and in the stone
    light_side: tuple[mi.Float64, mi.Float64]
    rise: mi.Float64  # z of the normal where it leaves


# ---- Queries ----


def _first_hit(scene: mi.Scene, ray: mi.Ray3f, active: mi.Bool) -> mi.SurfaceInteraction3f:
    """Return where rays from outside meet the stone.

    The ray tracer may miss both faces beside an edge that a ray meets exactly, as whole rows of pixels do,
    and find the stone's far side, what is behind it, or nothing: where rays a little to either side do not,
    one of them counts.
    """

    def meet(ray: mi.Ray3f, active: mi.Bool) -> mi.SurfaceInteraction3f:
        return scene.ray_intersect(ray, mi.RayFlags.Minimal, False, active)

    si = meet(ray, active)
    missed = active & ~_comes_in(si, ray)
    aside = ASIDE * mi.Frame3f(ray.d).s
    left, right = (mi.Ray3f(ray.o + side, ray.d, ray.time, ray.wavelengths) for side in (aside, -aside))
    beside = meet(left, missed)
    leaks = missed & _comes_in(beside, ray)
    leaks &= _comes_in(meet(right, leaks), ray)
    return dr.select(leaks, beside, si)


def _comes_in(si: mi.SurfaceInteraction3f, ray: mi.Ray3f) -> mi.Bool:
    """Return whether a ray meets a stone's face from outside."""
    valid = si.is_valid()
    return valid & si.shape.has_attribute(NORMAL_ATTRIBUTES[0], valid) & (dr.dot(si.n, ray.d) < 0)


def _query_start(p: mi.Point3d, d: mi.Vector3d, on_wall: mi.Bool, retries: mi.UInt32) -> mi.Point3f:
    """Where to look for the next facet from: inside the stone, although p lies on its surface.

    From a plane a little way along the ray, which leaves the line as it is. From a round girdle, whose mesh
    runs inside the true wall, and after a query that found nothing (p lies beside an edge), towards the
    stone's middle; each retry also aside of the last.
    """
    along = p + RAY_OFFSET * d
    step = RAY_OFFSET * mi.Float64(retries)
    drawn_in = p * (1 - RAY_OFFSET - step) + step * dr.cross(d, mi.Vector3d(0.8, 0.36, 0.48))
    return mi.Point3f(dr.select(on_wall | (retries > 0), drawn_in, along))


# ---- Surfaces of the stone, in double precision ----


def _surface(si: mi.SurfaceInteraction3f, active: mi.Bool) -> tuple[mi.Float, mi.Vector3d, mi.Float64]:
    """Facet number, and the plane's outward normal and offset, of the face that was hit."""
    shape = si.shape
    facet = shape.eval_attribute_1(FACET_ATTRIBUTE, si, active)
    normal, offset = (
        kind(shape_value(high, si, active)) + kind(shape_value(low, si, active))
        for kind, shape_value, (high, low) in (
            (mi.Vector3d, shape.eval_attribute_3, NORMAL_ATTRIBUTES),
            (mi.Float64, shape.eval_attribute_1, OFFSET_ATTRIBUTES),
        )
    )
    return facet, normal, offset


def _meet(
    p: mi.Point3d,
    d: mi.Vector3d,
    n: mi.Vector3d,
    offset: mi.Float64,
    *,
    entering: bool = False,
) -> tuple[mi.Point3d, mi.Vector3d]:
    """Return where the ray p + t d meets the surface, and the outward normal there."""
    is_wall = _is_wall(n)
    on_plane = (offset - dr.dot(n, p)) / dr.dot(n, d)
    # A round girdle is the cylinder of radius `offset`, entered through the nearer root and left through
    # the farther one.
    a = dr.square(d.x) + dr.square(d.y)
    b = p.x * d.x + p.y * d.y
    c = dr.square(p.x) + dr.square(p.y) - dr.square(offset)
    root = dr.safe_sqrt(dr.square(b) - a * c)
    on_wall = (-b - root if entering else -b + root) / a
    q = p + dr.select(is_wall, on_wall, on_plane) * d
    return q, dr.select(is_wall, _radial(q), n)


def _is_wall(n: mi.Vector3d) -> mi.Bool:
    """Whether a face belongs to a round girdle: what it carries as a plane's normal is 0."""
    return dr.squared_norm(n) < 0.5


def _radial(q: mi.Point3d) -> mi.Vector3d:
    """Return the unit vector away from the stone's axis."""
    return mi.Vector3d(q.x, q.y, 0) * dr.rsqrt(dr.square(q.x) + dr.square(q.y))


mi.register_integrator("gem_primary", lambda props: PrimaryIntegrator(props))

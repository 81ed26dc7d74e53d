"""The emitter ``gem_hemisphere``: uniform light from above the horizon."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError


class HemisphereEmitter(mi.Emitter):
    r"""
    .. _emitter-gem_hemisphere:

    Hemispherical environment emitter (:monosp:`gem_hemisphere`)
    ------------------------------------------------------------

    .. pluginparameters::

     * - radiance
       - |spectrum|
       - The emitted radiance [power per unit area per unit steradian], the same from all directions above
         the horizon. A number means a flat spectrum, see below. (Default: 1)
       - |exposed|, |differentiable|

     * - radius
       - |float|
       - Radius of a sphere around the origin that holds the whole scene [girdle radii]. Light that is traced
         from the emitter starts outside it, and shadow rays end outside it. (Default: 100)
       - |exposed|

    This plugin implements an environment emitter that sends uniform radiance down from the upper hemisphere,
    from directions with :math:`z > 0`, and none from the horizon or from below. It is the light that
    brilliance is scored under: a ray from the eye that leaves the stone upwards finds light, one that leaves
    it downwards finds darkness.

    The irradiance on a horizontal plane is :math:`\pi` times the radiance, so a diffuse plane reflects its
    albedo times the radiance.

    .. note::

        In spectral variants a plain number is the same radiance at every wavelength. This differs from
        Mitsuba's own emitters, which take a number for a multiple of the daylight spectrum D65. For daylight
        give an :monosp:`rgb` value or a :monosp:`d65` spectrum. In RGB variants a number is the value of
        each channel.

    .. tabs::
        .. code-tab:: xml

            <emitter type="gem_hemisphere">
                <float name="radiance" value="1"/>
            </emitter>

        .. code-tab:: python

            'type': 'gem_hemisphere',
            'radiance': 1.0

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    #: Why there is no `to_world`.
    _FIXED = "not allowed here, the light always comes from z > 0"
    #: Solid angle that directions are drawn from [sr].
    _solid_angle: float | mi.Float = 2 * math.pi

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.m_flags = +mi.EmitterFlags.Infinite
        if "to_world" in props:  # the base class takes it from every emitter, and would ignore it
            raise InputError(self._FIXED, key="to_world")
        self._read(props)

        radius = props.get("radius", 100.0)
        if isinstance(radius, bool) or not isinstance(radius, int | float) or not 0 < radius < math.inf:
            raise InputError("must be a finite number above 0", key="radius", value=radius)
        self.radius = dr.opaque(mi.Float, radius)

    # ---- What an environment of another kind overrides ----

    def _read(self, props: mi.Properties) -> None:
        """Read what is emitted."""
        self.radiance = emitted(props, "radiance")

    def _draw(self, sample: mi.Point2f) -> mi.Vector3f:
        """Return a direction to the light, uniformly over `_solid_angle`."""
        return mi.warp.square_to_uniform_hemisphere(sample)

    def _density(self, d: mi.Vector3f) -> mi.Float:
        """Return the density of `_draw` [1/sr]."""
        return dr.select(d.z > 0, mi.Float(dr.inv_two_pi), 0)

    def _incident(self, it: mi.Interaction3f, d: mi.Vector3f, active: mi.Bool) -> mi.Spectrum:
        """Return the radiance that arrives at `it` from the direction `d`."""
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wavelengths = it.wavelengths
        return mi.depolarizer(self.radiance.eval(si, active)) & (d.z > 0)

    def eval(self, si: mi.SurfaceInteraction3f, active: mi.Bool = True) -> mi.Spectrum:
        """Return the radiance that a ray which leaves the scene finds."""
        return self._incident(si, -si.wi, active)

    def sample_direction(
        self, it: mi.Interaction3f, sample: mi.Point2f, active: mi.Bool = True
    ) -> tuple[mi.DirectionSample3f, mi.Spectrum]:
        """Choose a direction from `it` to the emitter."""
        d = self._draw(sample)
        distance = 2 * dr.maximum(self.radius, dr.norm(it.p))

        ds = dr.zeros(mi.DirectionSample3f)
        ds.p = dr.fma(d, distance, it.p)
        ds.n = -d
        ds.uv = sample
        ds.time = it.time
        ds.d = d
        ds.dist = distance
        ds.delta = False
        ds.emitter = mi.EmitterPtr(self)
        ds.pdf = self.pdf_direction(it, ds, active)
        # The rim, as z = 0 of the hemisphere, has no light and no density.
        weight = (self._incident(it, d, active) / ds.pdf) & (ds.pdf > 0)
        return ds, weight

    def pdf_direction(
        self, it: mi.Interaction3f, ds: mi.DirectionSample3f, active: mi.Bool = True
    ) -> mi.Float:
        """Return the density of `sample_direction` [1/sr]."""
        return self._density(ds.d)

    def eval_direction(
        self, it: mi.Interaction3f, ds: mi.DirectionSample3f, active: mi.Bool = True
    ) -> mi.Spectrum:
        """Return the radiance that arrives at `it` from the direction of `ds`."""
        return self._incident(it, ds.d, active)

    def sample_ray(
        self,
        time: mi.Float,
        sample1: mi.Float,
        sample2: mi.Point2f,
        sample3: mi.Point2f,
        active: mi.Bool = True,
    ) -> tuple[mi.Ray3f, mi.Spectrum]:
        """Return a ray from the emitter into the scene, and its weight."""
        # A uniform direction, and across it a uniform point of the disc that faces the scene's sphere.
        d = -self._draw(sample3)
        disc = mi.warp.square_to_uniform_disk_concentric(sample2)
        offset = mi.Frame3f(d).to_world(mi.Vector3f(disc.x, disc.y, 0))
        origin = mi.Point3f(self.radius * (offset - d))

        interaction = dr.zeros(mi.SurfaceInteraction3f)
        interaction.wi = d
        wavelengths, weight = self.sample_wavelengths(interaction, sample1, active)
        weight *= self._solid_angle * dr.pi * dr.square(self.radius)
        return mi.Ray3f(origin, d, time, wavelengths), weight & (self._density(-d) > 0)

    def sample_wavelengths(
        self, si: mi.SurfaceInteraction3f, sample: mi.Float, active: mi.Bool = True
    ) -> tuple[mi.Spectrum, mi.Spectrum]:
        """Choose wavelengths by the radiance's spectrum; the weight includes the radiance."""
        # Without wavelengths the texture wants an empty array here, and sample_shifted returns a full one.
        shifted = mi.sample_shifted(sample) if mi.is_spectral else si.wavelengths
        wavelengths, weight = self.radiance.sample_spectrum(si, shifted, active)
        return wavelengths, mi.depolarizer(weight)

    def sample_position(
        self, time: mi.Float, sample: mi.Point2f, active: mi.Bool = True
    ) -> tuple[mi.PositionSample3f, mi.Float]:
        """Return nothing of use: an emitter at infinity has no positions (as Mitsuba's own)."""
        return dr.zeros(mi.PositionSample3f), mi.Float(dr.nan)

    def bbox(self) -> mi.ScalarBoundingBox3f:
        """Return an empty box: the emitter occupies no region of space."""
        return mi.ScalarBoundingBox3f()

    def traverse(self, callback: mi.TraversalCallback) -> None:
        """Expose the radiance and the radius."""
        super().traverse(callback)
        callback.put("radiance", self.radiance, mi.ParamFlags.Differentiable)
        callback.put("radius", self.radius, mi.ParamFlags.NonDifferentiable)

    def parameters_changed(self, keys: list[str]) -> None:
        """Take over changed parameters."""
        super().parameters_changed(keys)
        dr.make_opaque(self.radius)  # a literal would be compiled into the kernel

    def to_string(self) -> str:
        """Describe the emitter in Mitsuba's manner."""
        radiance = str(self.radiance).replace("\n", "\n  ")
        return f"HemisphereEmitter[\n  radiance = {radiance},\n  radius = {self.radius[0]:g}\n]"


def emitted(props: mi.Properties, key: str) -> mi.Texture:
    """Read a radiance: a number, which is a flat spectrum, or an emission."""
    radiance = props.get(key, 1.0)
    if isinstance(radiance, int | float):
        if isinstance(radiance, bool) or not 0 <= radiance < math.inf:
            raise InputError("must be a finite number of at least 0", key=key, value=radiance)
        # Read as a reflectance, a number becomes a flat spectrum; read as an emission it becomes D65.
        texture = props.get_texture(key, 1.0)
    else:
        texture = props.get_emissive_texture(key)
    if texture.is_spatially_varying():
        raise InputError("must be the same in all directions, not a varying texture", key=key)
    return texture


mi.register_emitter("gem_hemisphere", HemisphereEmitter)

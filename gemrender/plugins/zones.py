"""The emitter ``gem_zones``: light by zones of elevation above a viewer's horizon."""

from __future__ import annotations

import math
from itertools import pairwise

import drjit as dr
import mitsuba as mi

from gemrender.errors import InputError
from gemrender.plugins.hemisphere import HemisphereEmitter, emitted

#: Most zones: each is asked for its radiance in every kernel.
MOST_ZONES = 32


class ZonesEmitter(HemisphereEmitter):
    r"""
    .. _emitter-gem_zones:

    Environment emitter by zones of elevation (:monosp:`gem_zones`)
    ---------------------------------------------------------------

    .. pluginparameters::

     * - edges
       - |string|
       - Elevations that part the zones, two to 33 increasing numbers from -90 to 90 [degrees]. A direction
         of elevation e belongs to zone k if edge k <= e < edge k + 1; 90 belongs to the last. Beyond the
         edges there is no light. (Default: 0, 90)
       -

     * - radiance_1, radiance_2, ...
       - |spectrum|
       - The emitted radiance of each zone [power per unit area per unit steradian]. A number means a flat
         spectrum, as in ``gem_hemisphere``. (Default: 1)
       - |exposed|, |differentiable|

     * - axis
       - |vector|
       - Direction to the zenith, elevation 90: that to the viewer. (Default: (0, 0, 1))
       -

     * - radius
       - |float|
       - As of ``gem_hemisphere``. (Default: 100)
       - |exposed|

    This plugin implements an environment emitter whose radiance depends on the elevation only, as of the
    instruments that gems are looked at in: coloured reflectors about the viewer's line of sight.

    .. tabs::
        .. code-tab:: xml

            <emitter type="gem_zones">
                <string name="edges" value="0, 45, 75, 90"/>
                <rgb name="radiance_1" value="0, 1, 0"/>
                <rgb name="radiance_2" value="1, 0, 0"/>
                <rgb name="radiance_3" value="0, 0, 1"/>
            </emitter>

        .. code-tab:: python

            'type': 'gem_zones',
            'edges': '0, 45, 75, 90',
            'radiance_1': {'type': 'rgb', 'value': [0, 1, 0]},
            'radiance_2': {'type': 'rgb', 'value': [1, 0, 0]},
            'radiance_3': {'type': 'rgb', 'value': [0, 0, 1]}

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    _FIXED = "not allowed here, axis says where the zenith is"

    def _read(self, props: mi.Properties) -> None:
        edges = _edges(props)
        axis = mi.ScalarVector3f(props.get("axis", mi.ScalarVector3f(0, 0, 1)))
        length = float(dr.norm(axis))
        if not 0 < length < math.inf:
            raise InputError("must be a direction", key="axis", value=list(axis))
        self.edges_deg = edges
        self.radiances = [emitted(props, f"radiance_{k}") for k in range(1, len(edges))]
        # Opaque: other zones need no other kernel, if they are as many
        self.axis = mi.Vector3f(*(dr.opaque(mi.Float, float(x) / length) for x in axis))
        #: Sines of the edges; beyond any at the poles, which rounding is not to miss.
        self.sines = [dr.opaque(mi.Float, _sine(edge)) for edge in edges]
        #: Sines that directions are drawn between.
        low, high = math.sin(math.radians(edges[0])), math.sin(math.radians(edges[-1]))
        self.low, self.span = dr.opaque(mi.Float, low), dr.opaque(mi.Float, high - low)
        self._solid_angle = dr.two_pi * self.span

    def _draw(self, sample: mi.Point2f) -> mi.Vector3f:
        z = dr.fma(self.span, sample.y, self.low)
        sin, cos = dr.sincos(dr.two_pi * sample.x)
        r = dr.safe_sqrt(1 - dr.square(z))
        return mi.Frame3f(self.axis).to_world(mi.Vector3f(r * cos, r * sin, z))

    def _density(self, d: mi.Vector3f) -> mi.Float:
        z = dr.dot(d, self.axis)
        inside = (z >= self.sines[0]) & (z < self.sines[-1])
        return dr.select(inside, dr.rcp(self._solid_angle), 0)

    def _incident(self, it: mi.Interaction3f, d: mi.Vector3f, active: mi.Bool) -> mi.Spectrum:
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wavelengths = it.wavelengths
        z = dr.dot(d, self.axis)
        found = mi.UnpolarizedSpectrum(0)
        for (low, high), radiance in zip(pairwise(self.sines), self.radiances, strict=True):
            found = dr.select((z >= low) & (z < high), radiance.eval(si, active), found)
        return mi.depolarizer(found)

    def sample_wavelengths(
        self, si: mi.SurfaceInteraction3f, sample: mi.Float, active: mi.Bool = True
    ) -> tuple[mi.Spectrum, mi.Spectrum]:
        """Choose wavelengths evenly; the weight includes the radiance in the direction of `si`."""
        if not mi.is_spectral:
            return si.wavelengths, self.eval(si, active)
        first, last = mi.MI_CIE_MIN, mi.MI_CIE_MAX
        wavelengths = first + (last - first) * mi.sample_shifted(sample)
        at = mi.SurfaceInteraction3f(si)
        at.wavelengths = wavelengths
        return wavelengths, self.eval(at, active) * (last - first)

    def traverse(self, callback: mi.TraversalCallback) -> None:
        """Expose the radiances and the radius."""
        mi.Emitter.traverse(self, callback)
        for k, radiance in enumerate(self.radiances, start=1):
            callback.put(f"radiance_{k}", radiance, mi.ParamFlags.Differentiable)
        callback.put("radius", self.radius, mi.ParamFlags.NonDifferentiable)

    def to_string(self) -> str:
        """Describe the emitter in Mitsuba's manner."""
        edges = ", ".join(f"{edge:g}" for edge in self.edges_deg)
        axis = ", ".join(f"{x[0]:g}" for x in self.axis)
        return f"ZonesEmitter[\n  edges = [{edges}],\n  axis = [{axis}],\n  radius = {self.radius[0]:g}\n]"


def _edges(props: mi.Properties) -> list[float]:
    """Read the elevations that part the zones [deg]."""
    text = props.get("edges", "0, 90")
    allowed = f"must be 2 to {MOST_ZONES + 1} increasing numbers from -90 to 90, as 0, 45, 75, 90 [degrees]"
    try:
        edges = [float(word) for word in text.split(",")]
    except (AttributeError, ValueError) as error:
        raise InputError(allowed, key="edges", value=text) from error
    sound = 2 <= len(edges) <= MOST_ZONES + 1 and edges[0] >= -90 and edges[-1] <= 90
    if not sound or not all(low < high for low, high in pairwise(edges)):
        raise InputError(allowed, key="edges", value=text)
    return edges


def _sine(elevation_deg: float) -> float:
    """Return the sine of an elevation [deg], infinite at the poles."""
    if abs(elevation_deg) == 90:
        return math.copysign(math.inf, elevation_deg)
    return math.sin(math.radians(elevation_deg))


mi.register_emitter("gem_zones", ZonesEmitter)

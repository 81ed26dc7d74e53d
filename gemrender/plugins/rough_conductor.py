"""The surface ``gem_rough_conductor``: rough metal that keeps the light that its microfacets throw about."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.errors import InputError
from gemrender.optics.microfacets import COSINES, single_albedo
from gemrender.plugins.properties import number
from gemrender.scene.loading import load_scene

#: Gauss and Legendre's places and weights, for the mean of Fresnel's reflectance over the hemisphere.
_PLACES, _WEIGHTS = (0.5 * (x + k) for x, k in zip(np.polynomial.legendre.leggauss(4), (1, 0), strict=True))


class RoughConductor(mi.BSDF):
    r"""
    .. _bsdf-gem_rough_conductor:

    Rough conductor that keeps its energy (:monosp:`gem_rough_conductor`)
    ---------------------------------------------------------------------

    .. pluginparameters::

     * - eta, k
       - |spectrum|
       - Real and imaginary part of the index. (Default: 0 and 1, a mirror that reflects all)
       - |exposed|, |differentiable|

     * - alpha
       - |float|
       - Roughness of GGX's distribution, from 0.01 to 1. (Default: 0.1)
       -

    Mitsuba's ``roughconductor`` follows light among microfacets to the first bounce only; what meets another
    one is lost: of a mirror 9 % of light from all around at a roughness of 0.2, 23 % at 0.4. Here that light
    comes back, spread as what is missing is: f = F (1 - E(i)) (1 - E(o)) / (pi (1 - A)), with E the share of
    the first bounce by angle and A its mean over the hemisphere (Kulla & Conty, "Revisiting physically based
    shading at Imageworks", SIGGRAPH course, 2017), and F = M^2 A / (1 - M (1 - A)) what metal of a mean
    reflectance M leaves of it after a second bounce and more (Fdez-Aguera, "A multiple-scattering microfacet
    model for real-time image-based lighting", J. Comput. Graph. Tech. 8 (1), 2019). A mirror loses nothing,
    and light and eye may change places. In polarised variants that light is unpolarised.

    .. tabs::
        .. code-tab:: xml
            :name: gem-rough-conductor

            <bsdf type="gem_rough_conductor">
                <float name="alpha" value="0.2"/>
            </bsdf>

        .. code-tab:: python

            'type': 'gem_rough_conductor',
            'alpha': 0.2

    """  # noqa: D400 (opens with a label, as Mitsuba's manual does)

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.alpha = number(props, "alpha", 0.1)
        if not 0.01 <= self.alpha <= 1:
            raise InputError("must be from 0.01 to 1", key="alpha", value=self.alpha)
        self.eta, self.k = props.get_unbounded_texture("eta", 0.0), props.get_unbounded_texture("k", 1.0)
        index = {"eta": self.eta, "k": self.k}
        #: What the first bounce does.
        self.single = load_scene(
            {"type": "roughconductor", "distribution": "ggx", "alpha": self.alpha, **index}
        )
        albedo, self.average = single_albedo(self.alpha)
        self.missing = mi.Float((1 - albedo).astype(np.float32))
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def traverse(self, cb: mi.TraversalCallback) -> None:
        """Expose the index."""
        cb.put("eta", self.eta, mi.ParamFlags.Differentiable)
        cb.put("k", self.k, mi.ParamFlags.Differentiable)

    def sample(
        self,
        ctx: mi.BSDFContext,
        si: mi.SurfaceInteraction3f,
        sample1: mi.Float,
        sample2: mi.Point2f,
        active: mi.Bool = True,
    ) -> tuple[mi.BSDFSample3f, mi.Spectrum]:
        """Draw from the first bounce, or evenly for the others, as they share light between them."""
        active &= mi.Frame3f.cos_theta(si.wi) > 0
        others = active & (sample1 < self._missing(si.wi))
        bs, _ = self.single.sample(ctx, si, sample1, sample2, active)
        bs.wo = dr.select(others, mi.warp.square_to_cosine_hemisphere(sample2), bs.wo)
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        bs.eta = 1
        bs.sampled_component = 0
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        return bs, dr.select(bs.pdf > 0, value / bs.pdf, 0)

    def eval(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> mi.Spectrum:
        """Return the first bounce and what the others leave, times the cosine."""
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (cos_i > 0) & (cos_o > 0) & ctx.is_enabled(mi.BSDFFlags.GlossyReflection, 0)
        spread = self._missing(si.wi) * self._missing(wo) * (dr.inv_pi * cos_o / (1 - self.average))
        value = self.single.eval(ctx, si, wo, active) + mi.depolarizer(self._left(si, active) * spread)
        return dr.select(active, value, 0)

    def pdf(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> mi.Float:
        """Return the density of directions that `sample` draws."""
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (cos_i > 0) & (cos_o > 0) & ctx.is_enabled(mi.BSDFFlags.GlossyReflection, 0)
        density = dr.lerp(self.single.pdf(ctx, si, wo, active), dr.inv_pi * cos_o, self._missing(si.wi))
        return dr.select(active, density, 0)

    def eval_pdf(
        self, ctx: mi.BSDFContext, si: mi.SurfaceInteraction3f, wo: mi.Vector3f, active: mi.Bool = True
    ) -> tuple[mi.Spectrum, mi.Float]:
        """Return both."""
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def _missing(self, w: mi.Vector3f) -> mi.Float:
        """Return the share of light in a direction that the first bounce loses."""
        place = dr.sqrt(dr.clip(mi.Frame3f.cos_theta(w), 0, 1)) * (len(COSINES) - 1)
        below = mi.UInt32(dr.minimum(place, len(COSINES) - 2))
        a, b = (dr.gather(mi.Float, self.missing, below + k) for k in (0, 1))
        return dr.fma(place - mi.Float(below), b - a, a)

    def _left(self, si: mi.SurfaceInteraction3f, active: mi.Bool) -> mi.UnpolarizedSpectrum:
        """Return what of that light is left after all bounces but the first."""
        eta, k = self.eta.eval(si, active), self.k.eval(si, active)
        left = mi.UnpolarizedSpectrum(0)
        for channel in range(len(left)):
            index = mi.Complex2f(eta[channel], k[channel])
            mean = mi.Float(0)  # over the squared cosine, which is over the hemisphere
            for place, weight in zip(_PLACES, _WEIGHTS, strict=True):
                mean += float(weight) * mi.fresnel_conductor(float(np.sqrt(place)), index)
            left[channel] = dr.square(mean) * self.average / (1 - mean * (1 - self.average))
        return left

    def to_string(self) -> str:
        """Describe the surface in Mitsuba's manner."""
        return f"RoughConductor[\n  alpha = {self.alpha:g},\n  eta = {self.eta},\n  k = {self.k}\n]"


mi.register_bsdf("gem_rough_conductor", lambda props: RoughConductor(props))

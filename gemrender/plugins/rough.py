"""Bruted girdles: how a ground facet scatters, with all light accounted for."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

__all__ = ["scattered"]

#: So many microfacets a ray meets at most before it is let go along the normal: at a roughness of 0.4 one in
#: some 1e9 meets more.
_MOST = 64
#: Directions as steep, or as level, count as upright, or as level [cosine].
_UPRIGHT, _LEVEL = 0.9999, 1e-4


@dr.syntax
def scattered(d, n, outside, eta, alpha, chance, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Return where a ray goes that meets a rough surface, and whether it is outside then.

    A random walk among the microfacets of a height field with GGX's distribution, whose heights are uniform:
    Heitz, Hanika, d'Eon & Dachsbacher, "Multiple-scattering microfacet BSDFs with the Smith model", ACM
    Trans. Graph. 35 (2016); their normals by Dupuy & Benyoub, "Sampling visible GGX normals with spherical
    caps", Comput. Graph. Forum 42 (2023). At each facet chance reflects or refracts by Fresnel's shares, so
    that every ray comes out somewhere with its whole weight: no light is lost.

    Parameters
    ----------
    d, n : Vector3f
        Direction of the ray, and the surface's outward normal.
    outside : Bool
        Whether it comes from outside.
    eta : Float
        Index inside by that outside.
    alpha : Float
        Roughness.
    chance : PCG32
        Source of random numbers; its state goes on.
    active : Bool
        The rays that count.
    """
    frame = mi.Frame3f(n)
    w = frame.to_local(d)
    out = mi.Bool(outside)
    height = dr.select(out, mi.Float(1), 0)  # share of the field that is below: 1 is on top of it
    live = mi.Bool(active)
    met = mi.UInt32(0)

    while dr.hint(live, label="gem_path: rough girdle"):
        # As if from above: below the field all is upside down
        flip = dr.select(out, mi.Float(1), -1)
        wr, h = w * flip, dr.select(out, height, 1 - height)

        # ---- To the next facet, or away ----
        sin2 = dr.maximum(1 - dr.square(wr.z), 1e-12)
        root = dr.sqrt(1 + dr.square(alpha) * sin2 / dr.maximum(dr.square(wr.z), 1e-20))
        smith = 0.5 * (dr.select(wr.z > 0, root, -root) - 1)
        u = chance.next_float32()
        away = (wr.z > 0) & ((u <= dr.power(h, smith)) | (wr.z > _UPRIGHT))
        # What is left of u is as good as new
        v = dr.select(wr.z > 0, (1 - u) / dr.maximum(1 - dr.power(h, smith), 1e-12), u)
        v = dr.clip(v, 0, 1 - 1e-7)
        # Of the ways that meet something: (h / h')^smith = 1 - v (1 - h^smith)
        met_at = 1 - v * dr.select(wr.z > 0, 1 - dr.power(h, smith), 1)
        lower = h * dr.power(dr.maximum(met_at, 1e-20), -dr.rcp(smith))
        lower = dr.select(dr.abs(wr.z) < _LEVEL, h, dr.clip(lower, 0, 1))
        live &= ~away & (met < _MOST)
        w = dr.select(active & ~away & ~live & (met >= _MOST), mi.Vector3f(0, 0, 1) * flip, w)
        height = dr.select(live, dr.select(out, lower, 1 - lower), height)

        # ---- Its normal ----
        wi = -wr
        stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
        z = dr.fma(1 - chance.next_float32(), 1 + stretched.z, -stretched.z)
        s, c = dr.sincos(2 * dr.pi * chance.next_float32())
        r = dr.safe_sqrt(1 - dr.square(z))
        m = mi.Vector3f(r * c, r * s, z) + stretched
        m = dr.normalize(mi.Vector3f(alpha * m.x, alpha * m.y, dr.maximum(m.z, 1e-7)))

        # ---- Reflected or refracted ----
        cos_i = dr.maximum(dr.dot(wi, m), 1e-7)
        share, cos_t, _, ratio = mi.fresnel(cos_i, dr.select(out, eta, dr.rcp(eta)))
        reflects = chance.next_float32() <= share
        new = dr.select(reflects, 2 * cos_i * m - wi, (ratio * cos_i + cos_t) * m - ratio * wi)
        w = dr.select(live, dr.normalize(new) * flip, w)
        out = dr.select(live & ~reflects, ~out, out)
        met += 1

    return frame.to_world(w), out

"""One way through a stone, drawn by chance: reflected or refracted at each facet by Fresnel's shares."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from gemrender.plugins.rough import scattered
from gemrender.plugins.stones import RAY_OFFSET, reflectance, refracted

__all__ = ["LATE", "LATE_SURVIVAL", "walk"]

#: From so many surfaces on, a way goes on with probability `LATE_SURVIVAL` at each, whatever its throughput:
#: rays can be caught by total reflection for ever.
LATE, LATE_SURVIVAL = 1024, 0.98


@dr.syntax
def walk(stones, stone, p, d, n, β, index, wavelengths, chance, depth, max_depth, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Follow rays that meet a stone from outside until they leave it, reflected at once or refracted twice.

    Both directions of light are followed alike: the shares are the same, rough girdles scatter alike either
    way, and radiance's factor n^2 of the way in is undone on the way out.

    Parameters
    ----------
    stones : Stones
        The stones.
    stone : UInt32
        Number of the stone that is met.
    p, d, n : Point3f, Vector3f, Vector3f
        Where, in which direction, and the outward normal there.
    β : Spectrum
        Throughput of the wavelengths that go this way.
    index : Float
        Relative index for them.
    wavelengths : Spectrum
        All wavelengths [nm].
    chance : PCG32
        Random numbers.
    depth, max_depth : UInt32
        Segments up to p, less one, and the most a path may have.
    active : Bool
        Which rays meet a stone.

    Returns
    -------
    (o, d, β, depth, active)
        Rays outside again, as before; and which of them there are.
    """
    cos_air = -dr.dot(n, d)
    cos_stone = dr.safe_sqrt(1 - (1 - dr.square(cos_air)) / dr.square(index))
    left = active & (chance.next_float32() < reflectance(cos_air, cos_stone, index))
    out_o = mi.Point3f(p + RAY_OFFSET * stones.size * n)
    out_d = mi.Vector3f(d + 2 * cos_air * n)
    d_in = mi.Vector3f(refracted(d, n, cos_air, cos_stone, 1 / index))
    if dr.hint(stones.any_rough, mode="scalar"):
        alpha = stones.roughness(stone, n, active)
        rough = active & (alpha > 0)
        d_one, outside = scattered(d, n, active, index, alpha, chance, rough)
        left = dr.select(rough, outside, left)
        out_d, d_in = dr.select(rough, d_one, out_d), dr.select(rough, d_one, d_in)
    inside = active & ~left
    p = mi.Point3f(stones.inwards(p, n))
    d = mi.Vector3f(d_in)
    depth = mi.UInt32(depth + 1)
    while dr.hint(inside, label="walk through a stone"):
        t, n, met = stones.next_surface(stone, p, d, inside)
        inside &= met & (depth + 2 <= max_depth)
        p = dr.select(inside, p + t * d, p)
        β = dr.select(inside, β * stones.transmittance(stone, wavelengths, t, inside), β)
        cos_i = dr.dot(n, d)
        sin2 = dr.square(index) * (1 - dr.square(cos_i))
        cos_t = dr.safe_sqrt(1 - sin2)
        back = dr.select(sin2 < 1, reflectance(cos_t, cos_i, index), 1)
        leaves = inside & (chance.next_float32() >= back)
        d_out = index * (d - cos_i * n) + cos_t * n
        d_back = d - 2 * cos_i * n
        if dr.hint(stones.any_rough, mode="scalar"):
            alpha = stones.roughness(stone, n, inside)
            rough = inside & (alpha > 0)
            d_one, outside = scattered(d, n, mi.Bool(False), index, alpha, chance, rough)
            leaves = dr.select(rough, outside, leaves)
            d_out, d_back = dr.select(rough, d_one, d_out), dr.select(rough, d_one, d_back)
        out_o = dr.select(leaves, p + RAY_OFFSET * stones.size * n, out_o)
        out_d = dr.select(leaves, dr.normalize(d_out), out_d)
        depth = dr.select(inside, depth + 1, depth)
        left |= leaves
        inside &= ~leaves
        d = d_back
        p = stones.inwards(p, n)
        late = inside & (depth > LATE)
        inside &= ~late | (chance.next_float32() < LATE_SURVIVAL)
        β = dr.select(late, β / LATE_SURVIVAL, β)
    return out_o, out_d, β, depth, left

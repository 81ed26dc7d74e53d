"""Branches of light that leave a stone: one is drawn of many."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.plugins.polarisation import at_interface, mirrored, refracted_field
from gemrender.plugins.rough import scattered
from gemrender.plugins.spectra import mean_of
from gemrender.plugins.stones import RAY_OFFSET, reflectance
from gemrender.plugins.walk import LATE, LATE_SURVIVAL

__all__ = ["NEGLIGIBLE", "Branch", "is_diffuse", "split"]

#: Throughput below which a way inside a stone goes on by chance only.
ROULETTE_INSIDE = 0.1
#: Throughput that counts as none: far below what a picture can show, and its reciprocal is a number still.
NEGLIGIBLE = 1e-30


@dataclass
class Branch:
    """A branch outside, drawn in proportion to its throughput of those that were offered (a reservoir).

    Attributes
    ----------
    weight : Float
        Sum of the throughputs of all; 0 where there were none.
    o, d : Point3f, Vector3f
        Ray.
    β, parted, depth : Spectrum, Bool, UInt32
        Its throughput, whether its wavelengths have parted, and its segments.
    """

    weight: mi.Float
    o: mi.Point3f
    d: mi.Vector3f
    β: mi.UnpolarizedSpectrum
    parted: mi.Bool
    depth: mi.UInt32

    @staticmethod
    def none() -> Branch:
        """Return no branch."""
        return Branch(
            mi.Float(0),
            mi.Point3f(0),
            mi.Vector3f(0, 0, 1),
            mi.UnpolarizedSpectrum(0),
            mi.Bool(False),
            mi.UInt32(0),
        )

    def or_offered(self, other: Branch, number: mi.Float, active: mi.Bool) -> Branch:
        """Return this or another, whose weight is its throughput, by a number in [0, 1)."""
        share = dr.select(active & (other.weight > NEGLIGIBLE), other.weight, 0)
        total = self.weight + share
        drawn: Branch = dr.select((share > 0) & (number * total < share), other, self)
        drawn.weight = total
        return drawn

    @property
    def throughput(self) -> mi.UnpolarizedSpectrum:
        """What it stands for: all that were offered."""
        return dr.select(self.weight > 0, self.β * (self.weight / mean_of(self.β)), 0)


def is_diffuse(flags: mi.UInt32) -> mi.Bool:
    """Return whether all parts of a BSDF are diffuse, of its flags."""
    kinds = mi.BSDFFlags
    other = int(kinds.Glossy | kinds.Delta | kinds.Delta1D)
    return ((flags & int(kinds.Diffuse)) != 0) & ((flags & other) == 0)


@dr.syntax
def split(  # type: ignore[no-untyped-def]  # dr.syntax
    stones, stone, p, d, n, β, parted, field, wavelengths, time, chance, depth, max_depth, direct, active
):
    """Follow all ways of light through a stone that is met from outside; see `gem_path`.

    Parameters
    ----------
    stones : Stones
        The stones.
    stone : UInt32
        Number of the stone that is met.
    p, d, n : Point3f, Vector3f, Vector3f
        Where, in which direction, and the outward normal there.
    β, parted : Spectrum, Bool
        Throughput, and whether its wavelengths have parted.
    field : Field
        Its polarisation, where there are polarising filters.
    wavelengths, time : Spectrum, Float
        Of the ray [nm, s].
    chance : PCG32
        Random numbers.
    depth, max_depth : UInt32
        Segments up to p, less one, and the most a path may have.
    direct : Bool
        Whether the path has met nothing but mirrors and stones before.
    active : Bool
        Which rays meet a stone.

    Returns
    -------
    (radiance, branches, part)
        Light and sky that the branches outside end on; of each wavelength one of those that end on something
        else, where wavelengths do not part of all together; and where each has ways of its own.
    """
    L = mi.UnpolarizedSpectrum(0)
    cos_air = -dr.dot(n, d)
    eta = stones.index(stone, wavelengths, active)
    cos_stone = dr.safe_sqrt(1 - (1 - dr.square(cos_air)) / dr.square(eta))
    reflected = reflectance(cos_air, cos_stone, eta)
    side_seen = mi.Float(1)  # what filters leave of light along that branch
    if dr.hint(stones.filters is not None, mode="scalar"):
        reflected, side_field = mirrored(field, d, n, cos_air, eta)
        side_seen = stones.filters.passes(side_field, d + 2 * cos_air * n)

    side = mi.Bool(active)  # whether there is a branch outside to look along
    side_o = mi.Point3f(p + RAY_OFFSET * stones.size * n)
    side_d = mi.Vector3f(d + 2 * cos_air * n)
    side_β = mi.UnpolarizedSpectrum(β * reflected)
    side_parted = mi.Bool(parted)
    side_depth = depth + 1
    side_way = mi.UInt32(0)

    # One wavelength after the other where they part here; one way for all where they do not.
    part = active & ~parted & stones.disperses(stone, active)
    entering = β * (1 - reflected) * dr.select(part, stones.parting_weight(), mi.UnpolarizedSpectrum(1))
    in_parted = parted | part
    channel = dr.select(part, mi.UInt32(0), stones.alive(β))
    left = dr.select(part, stones.n_ways - 1, mi.UInt32(0))
    ways = [stones.enter(entering, eta, d, n, cos_air, mi.UInt32(k), part) for k in range(stones.n_ways)]
    β_in, n_in, d_in = stones.enter(entering, eta, d, n, cos_air, channel, part)
    start = mi.Point3f(stones.inwards(p, n))
    inside = mi.Bool(active)
    first_field, first_d, first_n = field, mi.Vector3f(d), mi.Vector3f(n)
    if dr.hint(stones.filters is not None, mode="scalar"):
        field = refracted_field(first_field, first_d, first_n, cos_air, n_in, d_in)

    # A rough girdle: one way by chance, with all the light, and of one wavelength where they part.
    if dr.hint(stones.any_rough, mode="scalar"):
        alpha = stones.roughness(stone, n, active)
        rough = active & (alpha > 0)
        β_one, n_one = stones.one_wavelength(β, eta, part, chance)
        d_one, outside = scattered(d, n, active, n_one, alpha, chance, rough)
        side &= ~rough | outside
        inside &= ~(rough & outside)
        side_d = dr.select(rough, d_one, side_d)
        side_β = dr.select(rough, β_one, side_β)
        side_parted |= rough & part & mi.Bool(stones.n_ways > 1)
        side_seen = dr.select(rough, 1, side_seen)
        β_in = dr.select(
            rough, β_one * dr.select(part, stones.parting_weight(), mi.UnpolarizedSpectrum(1)), β_in
        )
        n_in, d_in = dr.select(rough, n_one, n_in), dr.select(rough, d_one, d_in)
        part &= ~rough
        left = dr.select(rough, 0, left)

    p, d = mi.Point3f(start), mi.Vector3f(d_in)
    in_depth = depth + 1
    drawn = [Branch.none() for _ in range(stones.n_ways)]

    while dr.hint(inside | side, label="split by a stone"):
        # ---- Along the branch outside ----
        branch = mi.Ray3f(side_o, side_d, time, wavelengths)
        found, Le = stones.outside(branch, side)
        L += dr.select(side, side_β * Le * side_seen, 0)
        met_branch = Branch(mean_of(side_β), side_o, side_d, side_β, side_parted, side_depth)
        number = chance.next_float32()
        for k in range(stones.n_ways):
            drawn[k] = drawn[k].or_offered(met_branch, number, side & found & (side_way == k))

        # ---- To the next facet, and through it ----
        t, n, met = stones.next_surface(stone, p, d, inside)
        inside &= met & (in_depth < max_depth)
        p = dr.select(inside, p + t * d, p)
        β_in *= stones.transmittance(stone, wavelengths, t, inside)
        cos_i = dr.dot(n, d)
        sin2 = dr.square(n_in) * (1 - dr.square(cos_i))
        leaves = inside & (sin2 < 1)
        cos_t = dr.safe_sqrt(1 - sin2)
        back = dr.select(leaves, reflectance(cos_t, cos_i, n_in), 1)
        d_out = n_in * (d - cos_i * n) + cos_t * n
        d_back = d - 2 * cos_i * n
        if dr.hint(stones.filters is not None, mode="scalar"):
            share, field, side_field = at_interface(field, d, n, cos_i, n_in, d_back, dr.normalize(d_out))
            back = dr.select(leaves, share, 1)
            side_seen = stones.filters.passes(side_field, dr.normalize(d_out))
        if dr.hint(stones.any_rough, mode="scalar"):
            alpha = stones.roughness(stone, n, inside)
            rough = inside & (alpha > 0)
            d_one, outside = scattered(d, n, mi.Bool(False), n_in, alpha, chance, rough)
            leaves = dr.select(rough, outside, leaves)
            back = dr.select(rough, dr.select(outside, mi.Float(0), 1), back)
            d_out, d_back = dr.select(rough, d_one, d_out), dr.select(rough, d_one, d_back)
            side_seen = dr.select(rough, 1, side_seen)
        side = leaves & (in_depth + 2 <= max_depth)
        side_o = mi.Point3f(p + RAY_OFFSET * stones.size * n)
        side_d = dr.normalize(d_out)
        side_β = β_in * (1 - back)
        side_parted = mi.Bool(in_parted)
        side_way = dr.select(part, channel, mi.UInt32(0))
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
            again = active & ~inside & (left > 0)
            left = dr.select(again, left - 1, left)
            channel = dr.select(again, channel + 1, channel)
            for k in range(1, stones.n_ways):
                this = again & (channel == k)
                β_in = dr.select(this, ways[k][0], β_in)
                n_in = dr.select(this, ways[k][1], n_in)
                d = dr.select(this, ways[k][2], d)
            if dr.hint(stones.filters is not None, mode="scalar"):
                entered = refracted_field(first_field, first_d, first_n, cos_air, n_in, d)
                field = dr.select(again, entered, field)
            p = dr.select(again, start, p)
            in_depth = dr.select(again, depth + 1, in_depth)
            inside |= again
    return L, drawn, part

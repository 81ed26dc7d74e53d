"""Ways of light through birefringent stones, in one mode at a time: all that are seen, or one by chance."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.plugins.branches import NEGLIGIBLE, ROULETTE_INSIDE, Branch
from gemrender.plugins.polarisation import Field
from gemrender.plugins.polarisation import mirrored as mirrored_light
from gemrender.plugins.rough import scattered
from gemrender.plugins.spectra import mean_of
from gemrender.plugins.stones import RAY_OFFSET
from gemrender.plugins.walk import LATE, LATE_SURVIVAL
from gemrender.plugins.waves import Mode

__all__ = ["split_modes", "walk_modes"]


@dataclass
class Met:
    """What a facet does to a wave of one mode, or to light that comes to it from outside.

    Attributes
    ----------
    passes : Float
        Share that is outside afterwards.
    stays : Float
        Share that is inside afterwards: in one mode, which stands for both.
    out : Vector3f
        Direction of what leaves, from inside.
    next : Mode
        The wave that goes on inside.
    second : Bool
        Whether that is of the second mode.
    u : Float
        A number in [0, 1) for the next facet.
    rough : Bool
        Whether the facet is ground.
    field : Field
        The field of what leaves, from inside, where there are polarising filters.
    """

    passes: mi.Float
    stays: mi.Float
    out: mi.Vector3f
    next: Mode
    second: mi.Bool
    u: mi.Float
    rough: mi.Bool
    field: Field


@dr.syntax
def meet(stones, stone, principal, n, k, mode, entering, field, u, chance, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Return what a facet does to light, as `Met`; a mode that goes on is drawn by its share.

    Parameters
    ----------
    stones, stone : Stones, UInt32
        The stones, and which one.
    principal : Vector3f
        Relative indices along the axes of its optic frame.
    n, k : Vector3f
        Outward normal of the facet, and wave vector: that outside where light comes from there.
    mode, entering : Bool
        Whether the wave is of the second mode, and whether light comes from outside.
    field : Field
        Polarisation of light from outside, where there are polarising filters.
    u : Float
        A number in [0, 1) that draws the mode. What is left of it draws the next one: so numbers that are
        evenly spread, as a pixel's are, are so over whole ways.
    chance : PCG32
        Random numbers.
    active : Bool
        Which lanes meet a facet.
    """
    along = k - dr.dot(k, n) * n
    # What enters is what would leave, reversed: a mode takes half of that of unpolarised light
    kt = dr.select(entering, -along, along)
    facet = stones.crystals.at_facet(stone, principal, kt, n, active)
    into = []
    for j in range(2):
        share = dr.select(mode, facet.reflected[1][j], facet.reflected[0][j])
        part = mi.Float(0.5)  # of unpolarised light
        if dr.hint(stones.filters is not None, mode="scalar"):
            part = field.share(facet.fields[j])
        into.append(dr.select(entering, part * facet.passed[j], share))
    stays = into[0] + into[1]
    passes = dr.select(entering, 1 - stays, dr.select(mode, facet.passed[1], facet.passed[0]))
    drawn = u * stays
    second = drawn >= into[0]
    rest = dr.select(second, (drawn - into[0]) / into[1], drawn / into[0])
    rest = dr.clip(dr.select(stays > NEGLIGIBLE, rest, u), 0, dr.one_minus_epsilon(mi.Float))
    came = dr.select(second, facet.out[1], facet.out[0])
    going = dr.select(second, facet.back[1], facet.back[0])
    going = dr.select(entering, Mode(-came.k, -came.ray, came.absorbs), going)
    out = mi.Vector3f(kt + dr.safe_sqrt(1 - dr.squared_norm(kt)) * n)
    rough = mi.Bool(False)
    if dr.hint(stones.any_rough, mode="scalar"):
        # One way by chance, as of the mean index, in either mode
        alpha = stones.roughness(stone, n, active)
        rough = active & (alpha > 0)
        mean = (principal.x + principal.y + principal.z) * (1 / 3)
        d, outside = scattered(dr.normalize(k), n, mi.Bool(entering), mean, alpha, chance, rough)
        passes = dr.select(rough, dr.select(outside, mi.Float(1), 0), passes)
        stays = dr.select(rough, 1 - passes, stays)
        second = dr.select(rough, chance.next_float32() < 0.5, second)
        going = dr.select(rough, Mode(mean * d, d, mi.Vector3f(1 / 3)), going)
        out = dr.select(rough, d, out)
    return Met(
        passes,
        stays,
        dr.normalize(out),
        going,
        second,
        rest,
        rough,
        dr.select(mode, facet.fields[1], facet.fields[0]),
    )


@dr.syntax
def split_modes(  # type: ignore[no-untyped-def]  # dr.syntax
    stones, stone, p, d, n, β, parted, field, wavelengths, time, u, chance, depth, max_depth, direct, active
):
    """Follow the ways of light through a birefringent stone that is met from outside; as `branches.split`.

    Inside, light is in one eigenmode at a time: after micrometres the phases of two have parted, so that they
    add as energies. What leaves at a facet is added with its share; the modes that go back are two, as are
    those that enter, and one of them, drawn by its share, stands for both. Outside, light is unpolarised.
    Shares are of energy, of waves of one tangential wave vector; as such radiance has no factor of the index.

    Parameters and results are those of `branches.split`, but for `u`, a number in [0, 1) that draws the modes
    of each wavelength's way.
    """
    L = mi.UnpolarizedSpectrum(0)
    crystals = stones.crystals
    part = active & ~parted & stones.disperses(stone, active)
    in_parted = parted | part
    channel = dr.select(part, mi.UInt32(0), stones.alive(β))
    left = dr.select(part, stones.n_ways - 1, mi.UInt32(0))
    n = mi.Vector3f(n)
    first_d, first_n = mi.Vector3f(d), mi.Vector3f(n)
    mirrored = mi.Vector3f(d - 2 * dr.dot(n, d) * n)
    start = mi.Point3f(stones.inwards(p, n))
    start_out = mi.Point3f(p + RAY_OFFSET * stones.size * n)
    weighted = β * dr.select(part, stones.parting_weight(), mi.UnpolarizedSpectrum(1))

    side = mi.Bool(False)  # whether there is a branch outside to look along
    side_o, side_d, side_β = mi.Point3f(start_out), mi.Vector3f(mirrored), mi.UnpolarizedSpectrum(0)
    side_parted, side_depth, side_way = mi.Bool(parted), depth + 1, mi.UInt32(0)
    mirrors = mi.UnpolarizedSpectrum(0)  # share of each wavelength that is mirrored at once
    side_seen, mirrored_seen = mi.Float(1), mi.Float(1)  # what filters leave of light along that branch
    if dr.hint(stones.filters is not None, mode="scalar"):
        # As of a surface of the ordinary index
        _, mirrored_field = mirrored_light(
            field, d, n, -dr.dot(d, n), stones.index(stone, wavelengths, active)
        )
        mirrored_seen = stones.filters.passes(mirrored_field, mirrored)

    entering = mi.Bool(active)  # whether the way begins here
    inside = mi.Bool(active)
    p = mi.Point3f(start)
    wave = Mode(mi.Vector3f(d), mi.Vector3f(d), mi.Vector3f(1 / 3))
    mode = mi.Bool(False)  # whether it is the second one
    principal = crystals.principal(stone, stones.nm_of(stone, wavelengths, channel, active), active)
    β_in = stones.only(weighted, channel, part)
    u, number_of_way = mi.Float(u), mi.Float(u)
    in_depth = depth + 1
    drawn = [Branch.none() for _ in range(stones.n_ways)]

    while dr.hint(inside | side, label="split by a birefringent stone"):
        # ---- Along the branch outside ----
        branch = mi.Ray3f(side_o, side_d, time, wavelengths)
        found, Le = stones.outside(branch, side)
        L += dr.select(side, side_β * Le * side_seen, 0)
        met_branch = Branch(mean_of(side_β), side_o, side_d, side_β, side_parted, side_depth)
        number = chance.next_float32()
        for way in range(stones.n_ways):
            drawn[way] = drawn[way].or_offered(met_branch, number, side & found & (side_way == way))

        # ---- To the next facet, and what it does ----
        on = inside & ~entering
        t, n, hit = stones.next_surface(stone, p, wave.ray, on)
        inside &= entering | (hit & (in_depth < max_depth))
        on &= inside
        p = dr.select(on, p + t * wave.ray, p)
        β_in *= stones.transmittance_of_mode(stone, wavelengths, wave.absorbs, t, on)
        n = dr.select(entering, first_n, n)
        met = meet(stones, stone, principal, n, wave.k, mode, entering, field, u, chance, inside)

        # ---- What leaves. All wavelengths are mirrored alike: together, once the last one's share is known
        mirrored_here = dr.select(met.rough, 0, met.passes)
        if dr.hint(stones.n_ways > 1, mode="scalar"):
            for way in range(stones.n_ways):
                mirrors[way] = dr.select(entering & (~part | (channel == way)), mirrored_here, mirrors[way])
        else:
            mirrors = dr.select(entering, mi.UnpolarizedSpectrum(mirrored_here), mirrors)
        together = inside & entering & (left == 0) & ~met.rough
        scatters = entering & met.rough & (met.passes > 0)
        side = together | scatters | (on & (met.passes > 0) & (in_depth + 2 <= max_depth))
        side_o = dr.select(entering, start_out, mi.Point3f(p + RAY_OFFSET * stones.size * n))
        side_d = dr.select(together, mirrored, met.out)
        side_β = dr.select(together, β * mirrors, β_in * met.passes)
        if dr.hint(stones.filters is not None, mode="scalar"):
            side_seen = dr.select(together, mirrored_seen, stones.filters.passes(met.field, met.out))
            side_seen = dr.select(met.rough, 1, side_seen)
        side_parted = dr.select(together, parted, in_parted)
        side_way = dr.select(part & ~together, channel, mi.UInt32(0))
        side_depth = dr.select(entering, depth + 1, in_depth + 1)

        # ---- What goes on ----
        β_in *= met.stays
        wave, mode, u = met.next, met.second, met.u
        p = dr.select(entering, start, stones.inwards(p, n))
        in_depth = dr.select(entering, in_depth, in_depth + 1)
        entering = mi.Bool(False)

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
            β_in = dr.select(again, stones.only(weighted, channel, part), β_in)
            nm = stones.nm_of(stone, wavelengths, channel, again)
            principal = dr.select(again, crystals.principal(stone, nm, again), principal)
            wave = dr.select(again, Mode(first_d, first_d, wave.absorbs), wave)
            p = dr.select(again, start, p)
            # The wavelengths of a sample take their numbers from other parts of [0, 1)
            number_of_way = dr.select(again, number_of_way + 1 / stones.n_ways, number_of_way)
            number_of_way -= dr.floor(number_of_way)
            u = dr.select(again, number_of_way, u)
            in_depth = dr.select(again, depth + 1, in_depth)
            entering |= again
            inside |= again
    return L, drawn, part


@dr.syntax
def walk_modes(stones, stone, p, d, n, β, nm, wavelengths, chance, depth, max_depth, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Follow rays that meet a birefringent stone from outside until they leave it; as `walk.walk`.

    Parameters and results are those of `walk.walk`, but for `nm`: the wavelength of what goes this way [nm].
    """
    crystals = stones.crystals
    principal = crystals.principal(stone, nm, active)
    field = Field.linear(mi.Vector3f(1, 0, 0))  # light that is drawn by chance is unpolarised
    out_o, out_d = mi.Point3f(p + RAY_OFFSET * stones.size * n), mi.Vector3f(d)
    n, mirrored = mi.Vector3f(n), mi.Vector3f(d - 2 * dr.dot(n, d) * n)
    first_n, p = mi.Vector3f(n), mi.Point3f(p)
    wave = Mode(mi.Vector3f(d), mi.Vector3f(d), mi.Vector3f(1 / 3))
    mode, entering = mi.Bool(False), mi.Bool(active)
    inside, left = mi.Bool(active), mi.Bool(False)
    depth = mi.UInt32(depth)
    while dr.hint(inside, label="walk through a birefringent stone"):
        on = inside & ~entering
        t, n, hit = stones.next_surface(stone, p, wave.ray, on)
        inside &= entering | (hit & (depth + 2 <= max_depth))
        on &= inside
        p = dr.select(on, p + t * wave.ray, p)
        β = dr.select(on, β * stones.transmittance_of_mode(stone, wavelengths, wave.absorbs, t, on), β)
        n = dr.select(entering, first_n, n)
        number = chance.next_float32()
        met = meet(stones, stone, principal, n, wave.k, mode, entering, field, number, chance, inside)
        leaves = inside & (chance.next_float32() < met.passes)
        out_o = dr.select(leaves, mi.Point3f(p + RAY_OFFSET * stones.size * n), out_o)
        out_d = dr.select(leaves, dr.select(entering & ~met.rough, mirrored, met.out), out_d)
        depth = dr.select(inside, depth + 1, depth)
        left |= leaves
        inside &= ~leaves
        wave, mode = met.next, met.second
        p = stones.inwards(p, n)
        entering = mi.Bool(False)
        late = inside & (depth > LATE)
        inside &= ~late | (chance.next_float32() < LATE_SURVIVAL)
        β = dr.select(late, β / LATE_SURVIVAL, β)
    return out_o, out_d, β, depth, left

"""The waves of a biaxial stone at a facet; for kernels. In double precision: its two sheets nearly touch."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from gemrender.plugins.waves import Facet, Wave, complex_root

__all__ = ["biaxial"]

#: Steps by Newton's method that a root is polished by.
_POLISHING = 2
#: Imaginary parts below this are rounding of a double root: the root of double precision's, with a margin.
_REAL = 1e-6
#: Waves of one facet whose wave vectors are closer than this run next to an optic axis: their fields are told
#: apart by what is left of a double root, and lose as many digits as it twice.
_TOUCHING = 1e-6


def biaxial(facet: Facet, axes: list[mi.Vector3f], principal: mi.Vector3f) -> tuple[tuple[Wave, Wave], ...]:
    """Return the waves of a biaxial crystal: fast and slow, outwards and inwards.

    The normal part of a wave vector is a root of Fresnel's equation, a quartic (H. G. Booker, Phil. Trans. R.
    Soc. A 237, 411 (1939), for other media). Of four real roots the two largest belong to waves that carry
    energy outwards, the larger one to the slow wave, whose surface is the outer one; of two the pair of
    complex ones is the fast wave's, evanescent. Where the outer surface dips towards an optic axis, a line
    may meet it four times; there the two are mistaken for each other in part, and no energy is lost. Along an
    optic axis any two fields at right angles do.

    Parameters
    ----------
    facet : Facet
        The facet.
    axes : three Vector3f
        Axes of the optic frame, unit vectors in the world.
    principal : Vector3f
        Relative indices along them.
    """
    κ = mi.Float64(facet.κ)
    ε = [dr.square(mi.Float64(n)) for n in principal]
    # The facet's frame in the optic one, as exact as it is orthogonal there
    b = [mi.Float64(dr.dot(axis, facet.n)) for axis in axes]
    a = [mi.Float64(dr.dot(axis, facet.t)) for axis in axes]
    b = _unit(b)
    along = sum(x * y for x, y in zip(a, b, strict=True))
    a = _unit([x - along * y for x, y in zip(a, b, strict=True)])
    c = [b[(i + 1) % 3] * a[(i + 2) % 3] - b[(i + 2) % 3] * a[(i + 1) % 3] for i in range(3)]
    inward, outward = _roots(_quartic(κ, a, b, ε))
    kind = type(facet.n)
    frame = a, c, b
    made = []
    for pair in (outward, inward):
        touching, k_n, along_axis = _along_axis(pair, κ, frame, ε)
        waves = []
        for own, of_axis in zip(pair, along_axis, strict=True):
            field = [
                dr.select(touching, x, y) for x, y in zip(of_axis, _field(own, κ, frame, ε), strict=True)
            ]
            waves.append(_wave(dr.select(touching, k_n, own), κ, frame, ε, field, kind))
        made.append((waves[0], waves[1]))
    return tuple(made)


def _unit(v: list[Any]) -> list[Any]:
    scale = dr.rsqrt(sum(dr.square(x) for x in v))
    return [x * scale for x in v]


def _quartic(κ: Any, a: list[Any], b: list[Any], ε: list[Any]) -> list[Any]:
    """Return the coefficients of Fresnel's equation for k = κ a + x b, from the constant on, monic.

    k^2 sum ε_i k_i^2 - sum ε_i (ε_j + ε_k) k_i^2 + ε_1 ε_2 ε_3 = 0; Born & Wolf, 7th ed., section 15.2.2.
    """
    others = [ε[i] * (ε[(i + 1) % 3] + ε[(i + 2) % 3]) for i in range(3)]

    def form(weights: list[Any], u: list[Any], v: list[Any]) -> Any:
        return sum(w * x * y for w, x, y in zip(weights, u, v, strict=True))

    κ2 = dr.square(κ)
    q0, q1, q2 = κ2 * form(ε, a, a), κ * form(ε, a, b), form(ε, b, b)
    l0, l1, l2 = κ2 * form(others, a, a), κ * form(others, a, b), form(others, b, b)
    lead = dr.rcp(q2)
    return [
        (κ2 * q0 - l0 + ε[0] * ε[1] * ε[2]) * lead,
        2 * (κ2 * q1 - l1) * lead,
        (q0 + κ2 * q2 - l2) * lead,
        2 * q1 * lead,
    ]


def _roots(c: list[Any]) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """Return the roots of a monic quartic, fast and slow: of waves inwards and outwards.

    Ferrari's way: with x = y - c_3 / 4, (y^2 + h)^2 = (g y - z)^2, where g^2 = 2 m of the largest root m of
    the resolvent.
    """
    shift = 0.25 * c[3]
    p = c[2] - 6 * dr.square(shift)
    q = c[1] - 2 * shift * c[2] + 8 * shift * dr.square(shift)
    r = c[0] - shift * c[1] + dr.square(shift) * c[2] - 3 * dr.square(dr.square(shift))
    m = dr.maximum(_largest_root(p, 0.25 * dr.square(p) - r, -0.125 * dr.square(q)), 0)
    h, g = 0.5 * p + m, dr.sqrt(2 * m)
    # 2 g z = q and z^2 = h^2 - r: the first loses digits where g is small, the second where z is
    z = dr.select(q < 0, -1.0, 1.0) * dr.safe_sqrt(dr.square(h) - r)
    z = dr.select(dr.square(g) > 0.1 * dr.abs(p), 0.5 * q / g, z)
    pairs = []
    for sign in (1, -1):
        root = complex_root(dr.square(g) - 4 * (h - sign * z))
        pairs.append([_polished(0.5 * (-sign * g + s * root) - shift, c) for s in (1, -1)])
    return _sorted(pairs)


def _largest_root(b: Any, c: Any, d: Any) -> Any:
    """Return the largest real root of x^3 + b x^2 + c x + d."""
    third = b * (1 / 3)
    p = dr.square(third) - c * (1 / 3)
    q = third * dr.square(third) - 0.5 * third * c + 0.5 * d  # x = y - third: y^3 - 3 p y + 2 q
    cube = p * dr.square(p)
    over = dr.square(q) - cube
    # Three real roots: by the cosine; one: by Cardano's formula, of terms of one sign
    angle = dr.acos(dr.clip(-q * dr.rsqrt(dr.maximum(cube, 1e-300)), -1, 1))
    three = 2 * dr.safe_sqrt(p) * dr.cos(angle * (1 / 3))
    term = dr.cbrt(dr.abs(q) + dr.safe_sqrt(over))
    one = dr.select(q > 0, -1.0, 1.0) * (term + p / dr.maximum(term, 1e-300))
    x = dr.select((over <= 0) & (p > 0), three, one) - third
    for _ in range(_POLISHING):
        slope = (3 * x + 2 * b) * x + c
        step = (((x + b) * x + c) * x + d) / slope
        x = dr.select(dr.isfinite(step), x - step, x)
    return x


def _polished(x: Any, c: list[Any]) -> Any:
    for _ in range(_POLISHING):
        value = (((x + c[3]) * x + c[2]) * x + c[1]) * x + c[0]
        slope = ((4 * x + 3 * c[3]) * x + 2 * c[2]) * x + c[1]
        step = value / slope
        small = dr.isfinite(dr.real(step)) & dr.isfinite(dr.imag(step)) & (dr.squared_norm(step) < 1e-4)
        x = dr.select(small, x - step, x)
    return x


def _real_if_nearly(x: Any) -> Any:
    """Return a root, of which rounding may have made one of a complex pair where two real ones are close."""
    return mi.Complex2f64(dr.real(x), dr.select(dr.abs(dr.imag(x)) < _REAL, 0, dr.imag(x)))


def _sorted(pairs: list[list[Any]]) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """Return roots by where their waves carry energy, of two pairs of which each may be complex."""
    (a, b), (c, d) = ([_real_if_nearly(x) for x in pair] for pair in pairs)
    first, second = dr.imag(a) != 0, dr.imag(c) != 0
    # Four real ones: those in the middle by their size, each pair holding the larger one first
    high, low = dr.real(a) >= dr.real(c), dr.real(b) >= dr.real(d)
    top, other = dr.select(high, a, c), dr.select(high, c, a)
    bottom, above = dr.select(low, d, b), dr.select(low, b, d)
    over = dr.real(other) >= dr.real(above)
    third, second_root = dr.select(over, other, above), dr.select(over, above, other)
    # A complex pair: its root of positive imaginary part comes first, and fades outwards
    fast_out = dr.select(first, a, dr.select(second, c, third))
    fast_in = dr.select(first, b, dr.select(second, d, second_root))
    slow_out = dr.select(first, c, dr.select(second, a, top))
    slow_in = dr.select(first, d, dr.select(second, b, bottom))
    return (fast_in, slow_in), (fast_out, slow_out)


def _field(k_n: Any, κ: Any, frame: tuple[list[Any], list[Any], list[Any]], ε: list[Any]) -> list[Any]:
    """Return the field of a wave vector, of length 1, in the optic frame: what k k^T - k^2 + ε takes to 0."""
    t, _, n = frame
    k = [κ * x + k_n * y for x, y in zip(t, n, strict=True)]
    square = dr.square(κ) + k_n * k_n
    d = [square - x for x in ε]
    columns = []
    for i in range(3):
        second, third = (i + 1) % 3, (i + 2) % 3
        column = [None, None, None]
        column[i] = d[second] * d[third] - d[second] * k[third] ** 2 - d[third] * k[second] ** 2
        column[second], column[third] = k[i] * k[second] * d[third], k[i] * k[third] * d[second]
        columns.append(column)
    field, size = columns[0], dr.squared_norm(columns[0][0])
    for i in (1, 2):
        larger = dr.squared_norm(columns[i][i]) > size
        size = dr.select(larger, dr.squared_norm(columns[i][i]), size)
        field = [dr.select(larger, x, y) for x, y in zip(columns[i], field, strict=True)]
    unit = dr.rsqrt(dr.maximum(sum(dr.squared_norm(x) for x in field), 1e-300))
    return [x * unit for x in field]


def _along_axis(
    pair: tuple[Any, Any], κ: Any, frame: tuple[list[Any], list[Any], list[Any]], ε: list[Any]
) -> tuple[Any, Any, list[list[Any]]]:
    """Return whether two waves run along an optic axis, and what wave vector and fields they have then.

    D is along the axes of the section of 1/ε across the wave vector, here one of both (Born & Wolf, 7th ed.,
    section 15.2.3): s, and z across it.
    """
    t, s, n = frame
    gap = dr.abs(dr.real(pair[0]) - dr.real(pair[1]))
    touching = (dr.imag(pair[0]) == 0) & (dr.imag(pair[1]) == 0) & (gap < _TOUCHING)
    k_n = 0.5 * (dr.real(pair[0]) + dr.real(pair[1]))
    by = dr.rsqrt(dr.square(κ) + dr.square(k_n))
    z = [(k_n * x - κ * y) * by for x, y in zip(t, n, strict=True)]
    ss, zz, zs = (
        sum(x * y / e for x, y, e in zip(u, v, ε, strict=True)) for u, v in ((s, s), (z, z), (z, s))
    )
    half = 0.5 * (zz - ss)
    spread = dr.sqrt(dr.square(half) + dr.square(zs))
    # Of the fast wave 1/ε is the larger; from the row that does not cancel
    first = dr.select(half >= 0, half + spread, zs)
    second = dr.select(half >= 0, zs, spread - half)
    first = dr.select(spread > 0, first, 1)
    fields = []
    for of_z, of_s in ((first, second), (-second, first)):
        e = [(of_z * x + of_s * y) / of_axis for x, y, of_axis in zip(z, s, ε, strict=True)]
        unit = dr.rsqrt(sum(dr.square(x) for x in e))
        fields.append([mi.Complex2f64(x * unit) for x in e])
    return touching, mi.Complex2f64(k_n), fields


def _wave(
    k_n: Any,
    κ: Any,
    frame: tuple[list[Any], list[Any], list[Any]],
    ε: list[Any],
    field: list[Any],
    kind: Any,
) -> Wave:
    """Return the wave of a wave vector and a field; its vectors are of a kind."""
    t, s, n = frame

    def along(axis: list[Any]) -> Any:
        return sum(x * y for x, y in zip(field, axis, strict=True))

    e_t, e_s, e_n = along(t), along(s), along(n)
    h_t, h_s, h_n = -k_n * e_s, k_n * e_t - κ * e_n, κ * e_s
    flow = [
        dr.real(e_s * dr.conj(h_n) - e_n * dr.conj(h_s)),
        dr.real(e_n * dr.conj(h_t) - e_t * dr.conj(h_n)),
        dr.real(e_t * dr.conj(h_s) - e_s * dr.conj(h_t)),
    ]
    rate = dr.rsqrt(dr.maximum(sum(dr.square(x) for x in flow), 1e-300))
    absorbs = [dr.sqrt(x) * dr.squared_norm(e) * rate for x, e in zip(ε, field, strict=True)]
    return Wave(k_n, e_t, e_s, h_t, h_s, kind(*(x * rate for x in flow)), kind(*absorbs))

"""The waves of a biaxial crystal at a facet, compiled.

Their wave vectors' parts along the normal are the roots of Booker's quartic (Proc. R. Soc. A 155, 235
(1936)), found all at once (Aberth, Math. Comp. 27, 339 (1973)). Those of waves that carry energy are polished
by Newton's method on k^2 eta(k) = 1, with eta the eigenvalue of the section of the index ellipsoid across k,
whose derivative by the root is twice the energy flux: so the two sheets are kept apart where they nearly
touch.
"""

from __future__ import annotations

import cmath
import math
from typing import Any

from gemrender.beam.compiled import jit_inner
from gemrender.beam.modes.waves import BACK, OUT, norm2, write_field

__all__ = ["write_biaxial"]

#: Imaginary parts below this are rounding of a double root: the root of double precision, with a margin.
_REAL = 1e-6
#: Steps of Aberth's method at the most, and when they end [relative]: of third order, the last one is exact.
_STEPS, _SMALL_STEP = 60, 1e-9
#: Steps by Newton's method, and the flux from which on they are taken: below it they would part the two of a
#: nearly double root.
_POLISHING, _STEEP = 3, 0.1
#: Parts of 1/eps that differ by less are those of a wave along an optic axis.
_NEXT_TO_AXIS = 1e-9


@jit_inner
def _write_tensors(crystal: Any, waves: Any) -> None:
    """Write the crystal's tensors along the facet's own axes."""
    axes = waves.axes
    for i in range(3):
        for j in range(3):
            one = other = 0.0
            for a in range(3):
                for b in range(3):
                    by = axes[i, a] * axes[j, b]
                    one += by * crystal.permittivity[a, b]
                    other += by * crystal.inverse[a, b]
            waves.tensors[0, i, j], waves.tensors[1, i, j] = one, other


@jit_inner
def _write_roots(kappa: float, eps: Any, roots: Any) -> None:
    """Write the four roots: real ones first and in order.

    k^2 (k . eps k) - k . (tr A - A) k + det eps = 0 with A the adjugate of eps; Born & Wolf, 7th ed.,
    section 15.2.2.
    """
    a_xx, a_nn = eps[1, 1] * eps[2, 2] - eps[1, 2] ** 2, eps[0, 0] * eps[1, 1] - eps[0, 1] ** 2
    a_yy, a_xn = eps[0, 0] * eps[2, 2] - eps[0, 2] ** 2, eps[0, 1] * eps[1, 2] - eps[0, 2] * eps[1, 1]
    a_xy = eps[0, 2] * eps[1, 2] - eps[0, 1] * eps[2, 2]
    determinant = eps[0, 0] * a_xx + eps[0, 1] * a_xy + eps[0, 2] * a_xn
    k2 = kappa * kappa
    lead = 1.0 / eps[2, 2]
    c3 = 2.0 * kappa * eps[0, 2] * lead
    c2 = (k2 * eps[0, 0] + k2 * eps[2, 2] - (a_xx + a_yy)) * lead
    c1 = (2.0 * kappa * eps[0, 2] * k2 + 2.0 * kappa * a_xn) * lead
    c0 = (k2 * k2 * eps[0, 0] - k2 * (a_yy + a_nn) + determinant) * lead
    mean = (eps[0, 0] + eps[1, 1] + eps[2, 2]) / 3.0
    high, low = cmath.sqrt(complex(1.05 * mean - k2, 0.05)), cmath.sqrt(complex(0.95 * mean - k2, -0.03))
    roots[0], roots[1], roots[2], roots[3] = high, low, -low, -high
    for _ in range(_STEPS):
        moved = 0.0
        for i in range(4):
            x = roots[i]
            value = (((x + c3) * x + c2) * x + c1) * x + c0
            slope = ((4.0 * x + 3.0 * c3) * x + 2.0 * c2) * x + c1
            others = complex(0.0, 0.0)
            for j in range(4):
                if j != i and roots[j] != x:
                    others += _inverse(x - roots[j])
            under = slope - value * others
            if under == 0.0:
                continue
            step = value * _inverse(under)
            roots[i] = x - step
            moved = max(moved, abs(step.real) + abs(step.imag))
        if moved < _SMALL_STEP * math.sqrt(mean):
            break
    for i in range(4):
        if abs(roots[i].imag) < _REAL:
            roots[i] = complex(roots[i].real, 0.0)
    for i in range(1, 4):  # in order
        x, j = roots[i], i
        while j > 0 and _is_before(x, roots[j - 1]):
            roots[j] = roots[j - 1]
            j -= 1
        roots[j] = x


@jit_inner
def _inverse(x: complex) -> complex:
    """Return 1 / x, in a tenth of the time that Python's careful division takes."""
    by = 1.0 / (x.real * x.real + x.imag * x.imag)
    return complex(x.real * by, -x.imag * by)


@jit_inner
def _is_before(x: complex, y: complex) -> bool:
    if (x.imag == 0.0) != (y.imag == 0.0):
        return x.imag == 0.0
    return x.real < y.real or (x.real == y.real and x.imag < y.imag)


@jit_inner
def _section(kappa: float, x: complex, inverse: Any) -> Any:
    """Return k^2, the x and n parts of the vector z that with y spans the plane across k, and 1/eps there."""
    square = kappa * kappa + x * x
    size = cmath.sqrt(square)
    by = _inverse(size)
    zx, zn = x * by, -kappa * by
    eta_x = inverse[0, 0] * zx + inverse[0, 2] * zn
    eta_n = inverse[2, 0] * zx + inverse[2, 2] * zn
    return square, zx, zn, zx * eta_x + zn * eta_n, inverse[1, 0] * zx + inverse[1, 2] * zn


@jit_inner
def _misses(kappa: float, x: complex, inverse: Any) -> Any:
    """Return how far a root is from either sheet, fast and slow, and how far these are from each other."""
    square, _, _, zz, zy = _section(kappa, x, inverse)
    yy = inverse[1, 1]
    half = 0.5 * (zz - yy)
    spread = square * cmath.sqrt(half * half + zy * zy)
    rest = 1.0 - 0.5 * square * (zz + yy)
    return abs(rest - spread), abs(rest + spread), abs(spread)


@jit_inner
def _field(kappa: float, x: complex, branch: float, inverse: Any) -> Any:
    """Return E of unit length, and k^2 eta - 1."""
    square, zx, zn, zz, zy = _section(kappa, x, inverse)
    yy = complex(inverse[1, 1])
    half = 0.5 * (zz - yy)
    spread = cmath.sqrt(half * half + zy * zy)
    # The eigenvector of mean + spread, from the row that does not cancel
    if (half * spread.conjugate()).real >= 0.0:
        first, second = half + spread, zy
    else:
        first, second = zy, spread - half
    if first == 0.0 and second == 0.0:
        first = complex(1.0, 0.0)
    if branch < 0.0:
        first, second = -second, first
    dx, dy, dn = first * zx, second, first * zn
    ex = inverse[0, 0] * dx + inverse[0, 1] * dy + inverse[0, 2] * dn
    ey = inverse[1, 0] * dx + inverse[1, 1] * dy + inverse[1, 2] * dn
    en = inverse[2, 0] * dx + inverse[2, 1] * dy + inverse[2, 2] * dn
    unit = 1.0 / math.sqrt(norm2(ex, ey, en))
    miss = square * (0.5 * (zz + yy) + branch * spread) - 1.0
    return ex * unit, ey * unit, en * unit, miss


@jit_inner
def _flow(kappa: float, x: complex, ex: complex, ey: complex, en: complex) -> Any:
    """Return the energy flux along the normal of a wave of field E, and the square of |H|."""
    hx, hy, hn = -x * ey, x * ex - kappa * en, kappa * ey
    return (ex * hy.conjugate() - ey * hx.conjugate()).real, norm2(hx, hy, hn)


@jit_inner
def _sheets(kappa: float, roots: Any, inverse: Any) -> Any:
    """Return the sheet of each root: 1 the fast one, -1 the slow one, which encloses it."""
    fast0, slow0, apart0 = _misses(kappa, roots[0], inverse)
    fast1, slow1, apart1 = _misses(kappa, roots[1], inverse)
    fast2, slow2, apart2 = _misses(kappa, roots[2], inverse)
    fast3, slow3, apart3 = _misses(kappa, roots[3], inverse)
    if roots[3].imag == 0.0:
        # Two of either sheet, but where the normal passes by the inner one and cuts the outer one, which has
        # dimples at the optic axes, four times. At the bottom of a dimple the sheets touch.
        bottom = (apart0 < _NEXT_TO_AXIS and apart1 < _NEXT_TO_AXIS) or (
            apart2 < _NEXT_TO_AXIS and apart3 < _NEXT_TO_AXIS
        )
        if slow1 + slow2 < fast1 + fast2 and not bottom:
            return -1.0, -1.0, -1.0, -1.0
        return -1.0, 1.0, 1.0, -1.0
    third, fourth = 1.0 if fast2 <= slow2 else -1.0, 1.0 if fast3 <= slow3 else -1.0
    if roots[1].imag == 0.0:
        return -1.0, -1.0, third, fourth
    return 1.0 if fast0 <= slow0 else -1.0, 1.0 if fast1 <= slow1 else -1.0, third, fourth


@jit_inner
def _polished(kappa: float, x: complex, branch: float, inverse: Any) -> complex:
    """Return a root that is nearer to its sheet."""
    if x.imag != 0.0:
        return x
    for _ in range(_POLISHING):
        ex, ey, en, miss = _field(kappa, x, branch, inverse)
        flux, power = _flow(kappa, x, ex, ey, en)
        if abs(flux) <= _STEEP * power:
            break
        x = complex(x.real - 0.5 * miss.real * power / flux, 0.0)
    return x


@jit_inner
def write_biaxial(crystal: Any, kappa: float, waves: Any) -> None:
    """Write the waves of a biaxial crystal: of each pair first the fast one, or what dies away sooner."""
    roots = waves.roots
    _write_tensors(crystal, waves)
    eps, inverse = waves.tensors[0], waves.tensors[1]
    _write_roots(kappa, eps, roots)
    sheets = _sheets(kappa, roots, inverse)
    for i in range(4):
        roots[i] = _polished(kappa, roots[i], sheets[i], inverse)
    lead = eps[2, 2]
    n_out, n_back = 0, 0
    for i in range(4):
        x = roots[i]
        ex, ey, en, _ = _field(kappa, x, sheets[i], inverse)
        flux, _ = _flow(kappa, x, ex, ey, en)
        is_real = x.imag == 0.0
        goes_out = flux > 0.0 if is_real else x.imag > 0.0
        flux = _told_flux(kappa, roots, i, lead, eps, flux) if is_real else 0.0
        # By the side that energy goes to; two at the most, which grazing waves may exceed by rounding
        if (goes_out and n_out < 2) or n_back == 2:
            at, first, n = OUT + n_out, OUT, n_out
            n_out += 1
        else:
            at, first, n = BACK + n_back, BACK, n_back
            n_back += 1
        waves.k[at], waves.flux[at] = x, flux
        write_field(kappa, at, ex, ey, en, waves)
        if n == 1 and _is_faster(x, waves.k[first], first == OUT):
            _swap(waves, first)


@jit_inner
def _told_flux(kappa: float, roots: Any, i: int, lead: float, eps: Any, flux: float) -> float:
    """Return the energy flux of a wave of unit E, by the quartic's slope where that tells it better.

    With W = eps + k k^T - k^2 the derivative of det W is -2 times the trace of W's adjugate times the flux:
    right relative to itself, however small; next to an optic axis slope and trace are small.
    """
    x = roots[i].real
    k2 = kappa * kappa + x * x
    xx, yy, nn = eps[0, 0] + kappa * kappa - k2, eps[1, 1] - k2, eps[2, 2] + x * x - k2
    xy, xn, yn = eps[0, 1], eps[0, 2] + kappa * x, eps[1, 2]
    trace = xx * yy - xy * xy + xx * nn - xn * xn + yy * nn - yn * yn
    if abs(trace) <= abs(flux):
        return flux
    slope = complex(lead, 0.0)
    for j in range(4):
        if j != i:
            slope *= roots[i] - roots[j]
    return float(-0.5 * slope.real / trace)


@jit_inner
def _is_faster(x: complex, other: complex, is_out: bool) -> bool:
    if x.imag != 0.0 or other.imag != 0.0:
        return abs(x.imag) > abs(other.imag)
    return x.real < other.real if is_out else x.real > other.real


@jit_inner
def _swap(waves: Any, i: int) -> None:
    waves.k[i], waves.k[i + 1] = waves.k[i + 1], waves.k[i]
    waves.flux[i], waves.flux[i + 1] = waves.flux[i + 1], waves.flux[i]
    for a in range(3):
        waves.e[i, a], waves.e[i + 1, a] = waves.e[i + 1, a], waves.e[i, a]
        waves.h[i, a], waves.h[i + 1, a] = waves.h[i + 1, a], waves.h[i, a]

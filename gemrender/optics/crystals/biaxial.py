"""Plane waves of a biaxial crystal with a given tangential wave vector: the roots of Booker's quartic."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gemrender.optics.crystals.indicatrix import Indicatrix
from gemrender.optics.crystals.modes import ON_AXIS

__all__ = ["biaxial_fields"]

#: Imaginary parts below this are rounding of a double root [of k_n].
_REAL = 1e-8
#: Roots closer than this are one within rounding, and one wave vector serves both of their fields.
_ONE_ROOT = 1e-13
#: Eigenvalues of 1/eps closer than this [relative] are those of a wave next to an optic axis.
_NEXT_TO_AXIS = 1e-9
#: Flux from which on a root is polished: below it Newton's step would part the two of a nearly double root,
#: whose mean and product the eigenvalues have to all digits.
_STEEP = 0.1
#: Trace of the adjugate below which fields are mixed by rounding with those of a wave next to them.
_MIXED = 1e-2

#: Sheets of four real roots in order: the outer, where the slow wave is (-1), encloses the inner (+1).
_NESTED = np.array([-1.0, 1.0, 1.0, -1.0])


def biaxial_fields(length: np.ndarray, local: Indicatrix) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield k, E, H, flux and whether they propagate, of the two waves to either side of a boundary.

    The quartic (Booker, Proc. R. Soc. A 155, 235 (1936)) is the characteristic polynomial of Berreman's
    matrix (J. Opt. Soc. Am. 62, 502 (1972)), and its roots are taken as that matrix's eigenvalues: next to an
    optic axis these are as well determined as the waves are, and the roots of a polynomial with rounded
    coefficients are not. Roots are polished by Newton's method on k^2 eta(k) = 1, with eta the eigenvalue of
    the section of the index ellipsoid (`modes`), whose derivative is twice the energy flux; and E is of its
    eigenvector.

    Parameters
    ----------
    length : (...) array
        Length of the tangential wave vector, along x.
    local : Indicatrix
        The crystal, its frame in the boundary's axes x, y, n.
    """
    frame, eps = local.frame, local.permittivities
    tensor = np.einsum("...ai,...a,...aj->...ij", frame, eps, frame)
    inverse = np.einsum("...ai,...a,...aj->...ij", frame, 1 / eps, frame)
    shape = np.broadcast_shapes(np.shape(length), tensor.shape[:-2])
    length = np.broadcast_to(length, shape)
    tensor, inverse = (np.broadcast_to(of, (*shape, 3, 3)) for of in (tensor, inverse))
    roots = _roots(length, tensor)
    real = roots.imag == 0
    branch = _branch(length, roots, inverse)
    for _ in range(2):
        miss, flow = _miss(length, roots, inverse, branch)
        steep = real & (np.abs(flow) > _STEEP)
        roots = roots - np.where(steep, miss.real / (2 * np.where(steep, flow.real, 1.0)), 0.0)
    order = _order(length, roots, inverse, branch)
    roots, branch, real = (np.take_along_axis(of, order, axis=-1) for of in (roots, branch, real))
    roots, branch = _one_root(length, roots, inverse, branch)
    e = _field(length, roots, inverse, branch)[0]
    k = _wave_vector(length, roots)
    h = np.cross(k, e)
    trace = _adjugate_trace(k, tensor)
    _part(e, h, real & (np.abs(trace) < _MIXED))
    # What the quartic's slope makes of the flux is right relative to itself, however small; next to an optic
    # axis, where the other waves make slope and trace small, the fields are the better source.
    flux = flux_between(e, h, e, h).real
    by_slope = real & (np.abs(trace) > np.abs(flux))
    slope = _slope(roots, tensor[..., 2, 2]) / np.where(by_slope, trace, 1.0)
    flux = np.where(real, np.where(by_slope, -0.5 * slope.real, flux), 0.0)
    for side in (slice(0, 2), slice(2, 4)):
        yield k[..., side, :], e[..., side, :], h[..., side, :], flux[..., side], real[..., side]


def flux_between(e: np.ndarray, h: np.ndarray, other_e: np.ndarray, other_h: np.ndarray) -> np.ndarray:
    """Return half of (E1 x H2* + E2* x H1) . n: zero between two waves of one tangential wave vector.

    Lorentz's reciprocity of two different waves in a medium that absorbs nothing; of one wave with itself it
    is its energy flux.
    """
    one = e[..., 0] * other_h[..., 1].conj() - e[..., 1] * other_h[..., 0].conj()
    two = other_e[..., 0].conj() * h[..., 1] - other_e[..., 1].conj() * h[..., 0]
    return np.asarray(0.5 * (one + two))


def _roots(length: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    """Return the four k_n, the real ones first and in order."""
    # Waves reversed are solved as the same matrix, so that they are reversed to the last bit.
    mirror = np.where(tensor[..., 0, 2] != 0, tensor[..., 0, 2], tensor[..., 1, 2]) < 0
    signs = np.where(mirror[..., None], np.array([-1.0, -1.0, 1.0]), 1.0)
    solved = tensor * signs[..., :, None] * signs[..., None, :]
    roots = np.linalg.eigvals(_berreman(length, solved)).astype(complex) * signs[..., :1]
    real = np.abs(roots.imag) < _REAL
    roots = np.where(real, roots.real, roots)
    return np.take_along_axis(roots, np.lexsort((roots.imag, roots.real, ~real)), axis=-1)


def _branch(length: np.ndarray, roots: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Tell which of the two sheets of the wave-vector surface each root is on: +1 the fast, -1 the slow."""
    square, _, zz, zy, yy = _section(length, roots, inverse)
    spread = np.sqrt(((zz - yy) / 2) ** 2 + zy**2)
    rest = 1 - square * (zz + yy) / 2
    fast, slow = np.abs(rest - square * spread), np.abs(rest + square * spread)
    n_real = np.sum(roots.imag == 0, axis=-1)[..., None]
    # Four real roots are two of either sheet, but where the normal passes by the inner one and cuts the outer
    # one, which has dimples at the optic axes, four times. At the bottom of a dimple the sheets touch.
    dimple = slow[..., 1] + slow[..., 2] < fast[..., 1] + fast[..., 2]
    touching = np.abs(square * spread) < _NEXT_TO_AXIS
    bottom = (touching[..., 0] & touching[..., 1]) | (touching[..., 2] & touching[..., 3])
    four = np.where((dimple & ~bottom)[..., None], -1.0, _NESTED)
    nearest = np.where(fast <= slow, 1.0, -1.0)
    two = np.where(roots.imag == 0, -1.0, nearest)
    return np.select([n_real == 4, n_real == 2], [four, two], nearest)


def _order(length: np.ndarray, roots: np.ndarray, inverse: np.ndarray, branch: np.ndarray) -> np.ndarray:
    """Return the order out, out, back, back of four roots, as `Waves` has each two."""
    real = roots.imag == 0
    flow = _miss(length, roots, inverse, branch)[1].real
    score = np.where(real, np.clip(flow, -1, 1), 2 * np.sign(roots.imag))
    order = np.argsort(-score, axis=-1, kind="stable")
    sides = []
    for side, which in ((1.0, order[..., :2]), (-1.0, order[..., 2:])):
        root = np.take_along_axis(roots, which, axis=-1)
        key = np.where(root.imag == 0, side * root.real, -1e3 - np.abs(root.imag))
        sides.append(np.take_along_axis(which, np.argsort(key, axis=-1, kind="stable"), axis=-1))
    return np.concatenate(sides, axis=-1)


def _one_root(
    length: np.ndarray, roots: np.ndarray, inverse: np.ndarray, branch: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Make of two waves to one side that rounding cannot tell apart one k_n with fields at right angles."""
    _, _, zz, zy, yy = _section(length, roots, inverse)
    alike = np.abs(np.sqrt(((zz - yy) / 2) ** 2 + zy**2)) < 10 * ON_AXIS * np.abs(zz + yy)
    for side in (slice(0, 2), slice(2, 4)):
        pair, sheets = roots[..., side], branch[..., side]
        gap = np.abs(pair[..., :1] - pair[..., 1:])
        same = (gap < _ONE_ROOT) | (
            (gap * np.abs(pair[..., :1]) < 20 * _ONE_ROOT) & alike[..., side].any(axis=-1, keepdims=True)
        )
        roots[..., side] = np.where(same, pair.mean(axis=-1, keepdims=True), pair)
        twice = same & (sheets[..., :1] == sheets[..., 1:])
        branch[..., side] = np.where(twice, np.array([1.0, -1.0]), sheets)
    return roots, branch


def _part(e: np.ndarray, h: np.ndarray, mixed: np.ndarray) -> None:
    """Take out of waves what flux rounding has left between them, in place.

    Of waves as close as next to an optic axis rounding mixes the fields, in which any mixture is a wave: each
    is parted from those with more flux.
    """
    if not mixed.any():
        return
    at = np.nonzero(mixed.any(axis=-1))
    some_e, some_h, mixed = e[at], h[at], mixed[at]
    flux = flux_between(some_e, some_h, some_e, some_h).real
    order = np.argsort(-np.abs(flux), axis=-1, kind="stable")
    rows = np.arange(len(order))
    for i in range(1, 4):
        for j in range(i):
            one, other = order[:, i], order[:, j]
            total = flux[rows, other]
            between = flux_between(
                some_e[rows, one], some_h[rows, one], some_e[rows, other], some_h[rows, other]
            )
            # More than half is no rounding: the other wave runs along the boundary.
            possible = mixed[rows, one] & mixed[rows, other] & (2 * np.abs(between) < np.abs(total))
            share = np.where(possible, between / np.where(possible, total, 1.0), 0.0)[:, None]
            some_e[rows, one] -= share * some_e[rows, other]
            some_h[rows, one] -= share * some_h[rows, other]
    e[at], h[at] = some_e, some_h


def _slope(roots: np.ndarray, leading: np.ndarray) -> np.ndarray:
    """Return the derivative of the quartic, det W (see `_adjugate_trace`), at each of its roots."""
    apart = roots[..., :, None] - roots[..., None, :] + np.eye(4)
    return np.asarray(leading[..., None] * np.prod(apart, axis=-1))


def _adjugate_trace(k: np.ndarray, eps: np.ndarray) -> np.ndarray:
    """Return the trace of the adjugate of W = eps + k k^T - k^2, which a wave's E is the null vector of.

    The adjugate is that trace times E E^T, and dW/dk_n = n k^T + k n^T - 2 k_n: so the derivative of det W is
    -2 times the trace times the energy flux E x (k x E) . n of the wave of unit E.
    """
    w = eps[..., None, :, :] + k[..., :, None] * k[..., None, :]
    w = w - np.sum(k * k, axis=-1)[..., None, None] * np.eye(3)
    minors = [w[..., i, i] * w[..., j, j] - w[..., i, j] ** 2 for i, j in ((0, 1), (0, 2), (1, 2))]
    return np.asarray(sum(minors))


def _berreman(length: np.ndarray, eps: np.ndarray) -> np.ndarray:
    """Return the matrix whose eigenvalues are k_n, for (E_x, E_y, H_x, H_y): k x E = H, k x H = -eps E."""
    matrix = np.zeros((*length.shape, 4, 4))
    inverse = 1 / eps[..., 2, 2]
    # E_n of (E_x, E_y, H_y), from the normal component of the second equation.
    e_n = np.stack(
        [-eps[..., 2, 0] * inverse, -eps[..., 2, 1] * inverse, 0 * inverse, -length * inverse], axis=-1
    )
    matrix[..., 0, :] = length[..., None] * e_n
    matrix[..., 0, 3] += 1
    matrix[..., 1, 2] = -1
    matrix[..., 2, :] = -eps[..., 1, 2, None] * e_n
    matrix[..., 2, 0] -= eps[..., 1, 0]
    matrix[..., 2, 1] += length**2 - eps[..., 1, 1]
    matrix[..., 3, :] = eps[..., 0, 2, None] * e_n
    matrix[..., 3, 0] += eps[..., 0, 0]
    matrix[..., 3, 1] += eps[..., 0, 1]
    return matrix


def _wave_vector(length: np.ndarray, roots: np.ndarray) -> np.ndarray:
    along = np.broadcast_to(length[..., None], roots.shape)
    return np.stack([along + 0j, np.zeros_like(roots), roots], axis=-1)


def _section(
    length: np.ndarray, roots: np.ndarray, inverse: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return k^2, the vector z that with y spans the plane across k, and 1/eps in that plane.

    Vectors across k are bilinear (no conjugates), so that all holds for complex k too.
    """
    square = length[..., None] ** 2 + roots**2
    size = np.sqrt(square)
    z = np.stack([roots / size, np.zeros_like(roots), -length[..., None] / size], axis=-1)
    eta_z = np.einsum("...ij,...mj->...mi", inverse, z)
    return square, z, np.sum(z * eta_z, axis=-1), eta_z[..., 1], inverse[..., None, 1, 1]


def _field(
    length: np.ndarray, roots: np.ndarray, inverse: np.ndarray, branch: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return E of unit length, and k^2 and its eigenvalue of 1/eps."""
    square, z, zz, zy, yy = _section(length, roots, inverse)
    half = (zz - yy) / 2
    spread = np.sqrt(half**2 + zy**2)
    # Eigenvector of mean + spread, from the row that does not cancel.
    towards = (half * spread.conj()).real >= 0
    first = np.where(towards, half + spread, zy)
    second = np.where(towards, zy, spread - half)
    # Where rounding alone tells the two apart, they are polarised in the plane of incidence and across it.
    nothing = np.abs(spread) < ON_AXIS * np.abs(zz + yy)
    first, second = np.where(nothing, 1.0, first), np.where(nothing, 0.0, second)
    plus = branch > 0
    along_z = np.where(plus, first, -second)[..., None]
    along_y = np.where(plus, second, first)[..., None]
    d = along_z * z + along_y * np.array([0.0, 1.0, 0.0])
    e = np.einsum("...ij,...mj->...mi", inverse, d)
    e = e / np.sqrt(np.sum(np.abs(e) ** 2, axis=-1, keepdims=True))
    return e, square, (zz + yy) / 2 + branch * spread


def _miss(
    length: np.ndarray, roots: np.ndarray, inverse: np.ndarray, branch: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return k^2 eta - 1, and half of its derivative by k_n: the energy flux of a wave of unit |H|."""
    e, square, eta = _field(length, roots, inverse, branch)
    h = np.cross(_wave_vector(length, roots), e)
    power = np.sum(np.abs(h) ** 2, axis=-1)
    flow = (e[..., 0] * h[..., 1].conj() - e[..., 1] * h[..., 0].conj()) / power
    return square * eta - 1, flow

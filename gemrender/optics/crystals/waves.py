"""The four plane waves in a crystal that share one tangential wave vector at a boundary.

Units as in `modes`: wave vectors in omega / c, H in E over the impedance of vacuum, time as
exp(-i omega t), so that a wave that dies away along the normal has a positive imaginary part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.optics.crystals.biaxial import biaxial_fields, flux_between
from gemrender.optics.crystals.indicatrix import Indicatrix
from gemrender.optics.crystals.modes import ON_AXIS

__all__ = ["Waves", "boundary_axes", "boundary_waves", "flux_between"]


#: Sine of the angle to the optic axis below which the extraordinary wave is found from the ordinary one.
_NEAR_AXIS = 0.03


@dataclass(frozen=True, slots=True)
class Waves:
    """Two plane waves of a crystal that take energy to the same side of a boundary, or die away to it.

    Components of vectors are along the boundary's own axes, `boundary_axes`: along the tangential wave
    vector, across it, and along the normal.

    Uniaxial crystals: first the ordinary wave, then the extraordinary one. Biaxial: first the fast one (of
    the inner sheet of the wave-vector surface), then the slow one; of two that die away the first does so
    within the shorter length. So a wave and the same wave reversed have one number.

    Attributes
    ----------
    k : (..., 2, 3) complex
        Wave vectors.
    e, h : (..., 2, 3) complex
        Fields, |e| = 1.
    flux : (..., 2) float
        Energy flux along the normal, Re(E x H*) . n: positive for waves that go out along it. Zero for an
        evanescent wave, which carries no energy away.
    propagating : (..., 2) bool
        Whether the wave vector is real.
    """

    k: np.ndarray
    e: np.ndarray
    h: np.ndarray
    flux: np.ndarray
    propagating: np.ndarray

    @property
    def ray(self) -> np.ndarray:
        """Directions of the energy (..., 2, 3), unit vectors; of evanescent waves along the boundary."""
        flow = np.cross(self.e, self.h.conj()).real
        flow = np.concatenate([flow[..., :2], self.flux[..., None]], axis=-1)
        length = np.linalg.norm(flow, axis=-1, keepdims=True)
        return np.asarray(flow / np.where(length > 0, length, 1.0))


def boundary_axes(normal: np.ndarray, tangential: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a boundary's own axes for a tangential wave vector, and that vector's length.

    Parameters
    ----------
    normal : (..., 3) array
        Unit vectors.
    tangential : (..., 3) array
        Wave vectors; what they have along the normal is left out.

    Returns
    -------
    axes : (..., 3, 3)
        Rows are x along the tangential wave vector, y = n cross x, and n. Where the vector is zero, x is any
        direction along the boundary.
    length : (...)
        Length of the tangential wave vector, the index times the sine.
    """
    n, k = np.broadcast_arrays(np.asarray(normal, float), np.asarray(tangential, float))
    k = k - np.sum(k * n, axis=-1, keepdims=True) * n
    length = np.linalg.norm(k, axis=-1)
    nothing = (length < 1e-100)[..., None]
    other = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
    other = other - np.sum(other * n, axis=-1, keepdims=True) * n
    x = np.where(nothing, other, k)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    x = x - np.sum(x * n, axis=-1, keepdims=True) * n  # k may have been next to nothing beside the normal
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(n, x), n], axis=-2), np.where(nothing[..., 0], 0.0, length)


def boundary_waves(axes: np.ndarray, length: np.ndarray, indicatrix: Indicatrix) -> tuple[Waves, Waves]:
    """Return the four waves with a tangential wave vector, two by two by the side that their energy goes to.

    Sorted by the energy's flow, not by the wave vector's side: of a tilted crystal near grazing the two
    differ. Evanescent waves are sorted by the side that they die away to.

    Parameters
    ----------
    axes : (..., 3, 3) array
        The boundary's own axes, as `boundary_axes` makes them.
    length : (...) array
        Length of the tangential wave vector.
    indicatrix : Indicatrix
        The crystal.

    Returns
    -------
    out, back : Waves
        Those that go along the normal, and those that go against it.

    Notes
    -----
    Uniaxial crystals in closed form: Lekner, J. Phys.: Condens. Matter 3, 6121 (1991), here in vectors. With
    the optic axis c, k = kappa c + p: the ordinary wave has k_n^2 = eps_o - k_t^2 and E along c x p; the
    extraordinary one the quadratic k . eps . k = eps_o eps_e and E = (eps_o / eps_e) p^2 c - kappa p, which
    loses no digit near the optic axis (there p^2 is eps_o - kappa^2 times eps_e / eps_o).

    Along the optic axis p vanishes and its direction is taken along the first axis of the frame. Biaxial
    crystals: `biaxial`. Where rounding alone tells two waves apart, as next to a biaxial's optic axis or of
    nearly equal indices, they are polarised in the plane of incidence and across it; no flux is between them.

    Where both waves die away, they may be one and the same for a single tangential wave vector (the
    optic axis lies in the boundary and k_t along it is the ordinary index): only light from a denser medium
    outside gets there, and there the crystal's amplitudes have no value.
    """
    local = Indicatrix(
        indicatrix.indices,
        np.einsum("...ij,...kj->...ik", indicatrix.frame, axes),
        indicatrix.has_optic_axis,
    )
    if indicatrix.has_optic_axis:
        return _uniaxial(length, local, 1.0), _uniaxial(length, local, -1.0)
    out, back = biaxial_fields(length, local)
    return Waves(*out), Waves(*back)


def _uniaxial(length: np.ndarray, local: Indicatrix, side: float) -> Waves:
    eps = local.permittivities
    c, first = local.frame[..., 2, :], local.frame[..., 0, :]
    length, eo, ee, c_x, c_y, c_n = np.broadcast_arrays(
        length, eps[..., 0], eps[..., 2], *np.moveaxis(c, -1, 0)
    )
    difference = ee - eo
    eps_nn = eo + difference * c_n**2
    square = ee * eps_nn - length**2 * (eo + difference * (c_x**2 + c_n**2))
    root = np.sqrt(eo * square + 0j) * side  # (eps k)_n of the extraordinary wave
    k_o = np.sqrt(eo - length**2 + 0j) * side
    k_e = (root - difference * c_n * c_x * length) / eps_nn
    # What x and n have across the optic axis, without cancellation.
    x_across = length[..., None] * np.stack([c_y**2 + c_n**2, -c_x * c_y, -c_x * c_n], axis=-1)
    n_across = np.stack([-c_n * c_x, -c_n * c_y, c_x**2 + c_y**2], axis=-1)
    p_o = _across(x_across + k_o[..., None] * n_across, c)
    # Of both sides, so that the two waves of a double root are found in one way.
    least = np.minimum(
        *(np.sum(np.abs(p) ** 2, axis=-1) for p in (p_o, x_across - k_o[..., None] * n_across))
    )
    near = (k_o.imag == 0) & (least < _NEAR_AXIS**2 * eo)
    step, root_near = _step(
        eo * k_o + difference * c_n * (length * c_x + k_o * c_n),
        difference * np.sum(p_o * p_o, axis=-1),
        eps_nn,
        side,
    )
    p_e = np.where(
        near[..., None], p_o + step[..., None] * n_across, _across(x_across + k_e[..., None] * n_across, c)
    )
    k_e, root = np.where(near, k_o + step, k_e), np.where(near, root_near, root)
    size_o, size_e = (np.sqrt(np.sum(np.abs(p) ** 2, axis=-1)) for p in (p_o, p_e))
    to_o, to_e = (_direction(p, size, eo, first) for p, size in ((p_o, size_o), (p_e, size_e)))
    kappa = length * c_x + k_e * c_n
    e_e = (eo / ee * size_e * np.sum(to_e * to_e, axis=-1))[..., None] * c - kappa[..., None] * to_e
    power = np.sum(np.abs(e_e) ** 2, axis=-1)
    k = _vectors(length, np.stack([k_o, k_e], axis=-1))
    e = np.stack(np.broadcast_arrays(np.cross(c, to_o), e_e / np.sqrt(power)[..., None]), axis=-2)
    # S_n of a wave of unit |E|: k_n of the ordinary one, and (eps k)_n, which is the root, of the other.
    flux = np.stack([k_o.real, eo / ee * root.real / power], axis=-1)
    return Waves(k, e, np.cross(k, e), flux, k[..., 2].imag == 0)


def _step(
    flow: np.ndarray, rise: np.ndarray, eps_nn: np.ndarray, side: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return k_e - k_o, and (eps k_e)_n, by what k_o misses.

    Next to the optic axis the two wave vectors part by next to nothing, p^2; that keeps all digits here:
    eps_nn step^2 + 2 (eps k_o)_n step = (eps_e - eps_o) p_o^2.
    """
    root = np.sqrt(flow**2 + eps_nn * rise + 0j) * side
    along = (flow * root).real > 0
    return np.where(along, rise / np.where(along, flow + root, 1.0), (root - flow) / eps_nn), root


def _vectors(length: np.ndarray, normal: np.ndarray) -> np.ndarray:
    along = np.broadcast_to(length[..., None], normal.shape)
    return np.stack([along + 0j, np.zeros_like(normal), normal], axis=-1)


def _across(p: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return p without what rounding has left along c."""
    return np.asarray(p - np.sum(p * c, axis=-1, keepdims=True) * c)


def _direction(p: np.ndarray, size: np.ndarray, square: np.ndarray, first: np.ndarray) -> np.ndarray:
    on_axis = (size < ON_AXIS * np.sqrt(square))[..., None]
    return np.where(on_axis, first, p / np.where(on_axis, 1.0, size[..., None]))

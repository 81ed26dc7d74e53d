"""The waves of a birefringent stone at a facet, and how light is shared among them; for kernels.

Wave vectors are in units of that outside, so that a wave's is as long as its relative index is. At a facet
all waves have the same part along it: kt = κ t. Vectors are given in the frame (t, s, N), with N the outward
normal and s = N x t. Fields go as exp(i (k . r - ω t)); H = k x E and D = -k x H.

All is in single precision, or in double where the facet is: vectors are Vector3f or Vector3d then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from gemrender.optics.fresnel import LEAST_TOTAL
from gemrender.plugins.polarisation import Field

__all__ = ["Facet", "Mode", "Shares", "Wave", "complex_root", "shares", "uniaxial"]

#: Waves closer to the optic axis than this [sine], in single precision and in double, are taken as of an axis
#: that is as far off, where the two modes are told apart: along it any two would do, and rounding knows
#: neither.
_NEAR_AXIS, _NEAR_AXIS_DOUBLE = 1e-3, 1e-6
#: What stands for 0 as a divisor, of fields of which some are as small as waves are near the axis.
_LEAST, _LEAST_DOUBLE = 1e-30, 1e-300


@dataclass
class Facet:
    """A facet as waves of one tangential wave vector meet it.

    Attributes
    ----------
    t, s, n : Vector3f
        Its frame: along the tangential wave vector, across it, outwards.
    κ : Float
        Length of the tangential wave vector.
    """

    t: mi.Vector3f
    s: mi.Vector3f
    n: mi.Vector3f
    κ: mi.Float

    @staticmethod
    def of(kt: mi.Vector3f, n: mi.Vector3f) -> Facet:
        """Return the facet of an outward normal as waves meet it whose part along it is `kt`."""
        κ = dr.norm(kt)
        # Any frame does for light straight on
        t = dr.select(κ > 1e-6, kt * dr.rcp(κ), type(n)(mi.coordinate_system(mi.Vector3f(n))[0]))
        t = dr.normalize(t - dr.dot(t, n) * n)
        return Facet(t, dr.cross(n, t), n, κ)

    @property
    def is_double(self) -> bool:
        """Whether it is in double precision."""
        return type(self.κ) is not mi.Float

    def to_world(self, v: mi.Vector3f) -> mi.Vector3f:
        """Return a vector of the facet's frame in the world's."""
        return v.x * self.t + v.y * self.s + v.z * self.n

    def to_local(self, v: mi.Vector3f) -> mi.Vector3f:
        """Return a vector of the world in the facet's frame."""
        return type(v)(dr.dot(v, self.t), dr.dot(v, self.s), dr.dot(v, self.n))


@dataclass
class Wave:
    """A plane wave inside, in a facet's frame.

    Attributes
    ----------
    k_n : Complex2f
        Its wave vector's part along the outward normal.
    e_t, e_s, h_t, h_s : Complex2f
        Its tangential fields, to some scale.
    ray : Vector3f
        Unit vector along which its energy flows, where it is no evanescent wave.
    absorbs : Vector3f
        What the absorption coefficients along the optic frame's axes count for, along the ray.
    """

    k_n: Any
    e_t: Any
    e_s: Any
    h_t: Any
    h_s: Any
    ray: mi.Vector3f
    absorbs: mi.Vector3f

    @property
    def flux(self) -> Any:
        """Energy through the facet, outwards, to the scale of the fields squared."""
        return dr.real(self.e_t * dr.conj(self.h_s) - self.e_s * dr.conj(self.h_t))


@dataclass
class Mode:
    """A wave as a path takes it on, in the world.

    Attributes
    ----------
    k : Vector3f
        Wave vector.
    ray : Vector3f
        Unit vector along which its energy flows.
    absorbs : Vector3f
        As of `Wave`.
    """

    k: mi.Vector3f
    ray: mi.Vector3f
    absorbs: mi.Vector3f


@dataclass
class Shares:
    """How a facet shares light that comes from inside in one mode.

    Attributes
    ----------
    out, back : two Mode each
        The waves towards the facet, and those that leave it inwards, of each mode.
    reflected : 2 x 2 of Float
        Share of the energy of a wave of one mode that goes on in each: ``reflected[of][into]``.
    passed : two Float
        Share that leaves the stone.
    fields : two Field
        The field of what leaves, outside.
    """

    out: list[Mode]
    back: list[Mode]
    reflected: list[list[mi.Float]]
    passed: list[mi.Float]
    fields: list[Field]


def complex_root(x: Any) -> Any:
    """Return the square root of a real number: positive, or positive times i."""
    kind = mi.Complex2f if type(x) is mi.Float else mi.Complex2f64
    return kind(dr.safe_sqrt(x), dr.safe_sqrt(-x))


def uniaxial(facet: Facet, c: mi.Vector3f, n_o: mi.Float, n_e: mi.Float) -> tuple[tuple[Wave, Wave], ...]:
    """Return the waves of a uniaxial crystal: ordinary and extraordinary, outwards and inwards.

    With q = c . k, V = k x c and W = c - q k / n_o^2 the fields are E = V, H = -n_o^2 W of the ordinary wave,
    where k^2 = n_o^2, and E = W, H = V of the extraordinary one, where (k^2 - q^2) / n_e^2 + q^2 / n_o^2 = 1:
    both fulfil Maxwell's equations, as one sees by putting them in. The surfaces of wave vectors: Born &
    Wolf, 7th ed., section 15.3; reflection: J. Lekner, J. Phys.: Condens. Matter 3, 6121 (1991).

    Parameters
    ----------
    facet : Facet
        The facet.
    c : Vector3f
        Optic axis, a unit vector in the world.
    n_o, n_e : Float
        Principal indices by that outside.
    """
    κ, axis = facet.κ, facet.to_local(c)
    root = complex_root(dr.square(n_o) - dr.square(κ))
    axis = _off_waves(axis, κ, dr.real(root), n_o, _NEAR_AXIS_DOUBLE if facet.is_double else _NEAR_AXIS)
    a, b = dr.rcp(dr.square(n_e)), dr.rcp(dr.square(n_o)) - dr.rcp(dr.square(n_e))
    # a (κ^2 + k_n^2) + b (κ c_t + k_n c_n)^2 = 1
    square, half = a + b * dr.square(axis.z), b * axis.z * axis.x * κ
    constant = a * dr.square(κ) + b * dr.square(axis.x * κ) - 1
    root_e = complex_root(dr.square(half) - square * constant)
    made = []
    for sign in (1, -1):
        ordinary = sign * root
        extraordinary = (sign * root_e - half) * dr.rcp(square)
        made.append(
            (
                _uniaxial_wave(ordinary, κ, axis, n_o, n_e, ordinary=True),
                _uniaxial_wave(extraordinary, κ, axis, n_o, n_e, ordinary=False),
            )
        )
    return tuple(made)


def _off_waves(axis: mi.Vector3f, κ: mi.Float, k_n: mi.Float, n_o: mi.Float, apart: float) -> mi.Vector3f:
    """Return the optic axis, a little off where a wave runs along it."""
    near = mi.Bool(False)
    for sign in (1, -1):
        along = dr.square(κ * axis.x + sign * k_n * axis.z)
        near |= dr.square(n_o) - along < dr.square(apart * n_o)
    kind = type(axis)
    across = dr.select(dr.abs(axis.y) < 0.8, kind(0, 1, 0), kind(1, 0, 0))
    return dr.select(near, dr.normalize(axis + 2 * apart * across), axis)


def _uniaxial_wave(
    k_n: mi.Complex2f, κ: mi.Float, c: mi.Vector3f, n_o: mi.Float, n_e: mi.Float, *, ordinary: bool
) -> Wave:
    kind = type(c)
    q = κ * c.x + k_n * c.z
    v_t, v_s, w_s = -c.y * k_n, c.x * k_n - κ * c.z, type(k_n)(c.y)
    by = dr.rcp(dr.square(n_o))
    w_t = c.x - q * (κ * by)
    k = kind(κ, 0, dr.real(k_n))
    if ordinary:
        minus = -dr.square(n_o)
        ray = dr.normalize(k)
        return Wave(k_n, v_t, v_s, minus * w_t, minus * w_s, ray, kind(1, 0, 0))
    along = dr.real(q)
    a = dr.rcp(dr.square(n_e))
    flow = a * k + (by - a) * along * c  # its length times k^2 - q^2 is that of E x H
    across2 = dr.maximum(dr.squared_norm(k) - dr.square(along), 0)
    # Of W the part along c is 1 - q^2 / n_o^2 = (k^2 - q^2) / n_e^2
    absorbs = kind(n_o * dr.square(along * by), 0, n_e * across2 * dr.square(a))
    absorbs *= dr.rcp(dr.norm(flow))
    return Wave(k_n, w_t, w_s, v_t, v_s, dr.normalize(flow), absorbs)


def shares(facet: Facet, out: tuple[Wave, Wave], back: tuple[Wave, Wave]) -> Shares:
    """Return how a facet shares light that comes to it from inside in one mode.

    Outside, a wave's tangential fields are H . t = -k_z E . s and k_z H . s = E . t, with k_z = sqrt(1 - κ^2)
    its wave vector along the normal: of the sum of the wave that comes and the two that go back both hold,
    which are two equations for their amplitudes. What does not come back has left; beyond the critical angle
    of the outside, nothing has.

    Light that comes from outside is shared alike, reversed: unpolarised light goes into a mode with half the
    share that leaves the stone of that mode when it comes the other way (reciprocity).
    """
    κ = type(dr.real(out[0].k_n))(facet.κ)
    k_z = complex_root(1 - dr.square(κ))
    total = dr.square(κ) >= LEAST_TOTAL
    real, least = type(facet.κ), _LEAST_DOUBLE if facet.is_double else _LEAST

    def residues(wave: Wave) -> tuple[Any, Any]:
        return wave.h_t + k_z * wave.e_s, k_z * wave.h_s - wave.e_t

    (a0, b0), (a1, b1) = (residues(wave) for wave in back)
    flux = [dr.maximum(-wave.flux, 0) for wave in back]
    mixed = a0 * b1 - a1 * b0
    determinant = dr.squared_norm(mixed)
    reflected, passed, fields = [], [], []
    for wave in out:
        a, b = residues(wave)
        unit = dr.rcp(dr.maximum(determinant * wave.flux, least))
        amplitudes = a * b1 - a1 * b, a0 * b - a * b0
        shared = [dr.squared_norm(x) * f * unit for x, f in zip(amplitudes, flux, strict=True)]
        whole = dr.maximum(shared[0] + shared[1], least)
        over = dr.select(total | (whole > 1), dr.rcp(whole), 1)
        reflected.append([real(share * over) for share in shared])
        passed.append(real(dr.select(total, 0, dr.maximum(1 - whole, 0))))
        of = [x / mixed for x in amplitudes]
        e_t, e_s = wave.e_t - of[0] * back[0].e_t, wave.e_s - of[0] * back[0].e_s
        fields.append(_outside(facet, e_t - of[1] * back[1].e_t, e_s - of[1] * back[1].e_s))
    towards, away = ([_mode(facet, wave) for wave in pair] for pair in (out, back))
    return Shares(towards, away, reflected, passed, fields)


def _outside(facet: Facet, e_t: Any, e_s: Any) -> Field:
    """Return the field of light outside, of its tangential parts."""
    k_z = dr.safe_sqrt(1 - dr.square(facet.κ))
    p = k_z * facet.t - facet.κ * facet.n  # s x k
    single = [mi.Complex2f(mi.Float(dr.real(x)), mi.Float(dr.imag(x))) for x in (e_t, e_s)]
    return Field.of(mi.Vector3f(facet.s), single[1] * mi.Float(k_z), mi.Vector3f(p), single[0])


def _mode(facet: Facet, wave: Wave) -> Mode:
    k = facet.κ * facet.t + type(facet.κ)(dr.real(wave.k_n)) * facet.n
    return Mode(k, facet.to_world(wave.ray), wave.absorbs)

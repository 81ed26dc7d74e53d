"""Polarising filters before the camera and the lights, and the field of light between them; for kernels.

Light from the camera is followed backwards as a field of one polarisation: that of the filter before the
camera, or one drawn evenly of all, which in the mean is unpolarised light. Fields are complex vectors across
the ray, of length 1; they go as exp(i (k . r - ω t)).

What a path brings of light of a drawn state tells Stokes' vector of what arrives: of states even over
Poincaré's sphere, s, the light L(s) = L (1 + s . S) that a filter for each lets through, twice, has the mean
L, and 3 s L(s) has L S.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

__all__ = ["Field", "Filters", "at_interface", "mirrored", "refracted_field"]


@dataclass
class Field:
    """A complex vector across a ray, of length 1.

    Attributes
    ----------
    re, im : Vector3f
        Its real and imaginary parts.
    """

    re: mi.Vector3f
    im: mi.Vector3f

    @staticmethod
    def linear(direction: mi.Vector3f) -> Field:
        """Return the field of linearly polarised light along a unit vector."""
        return Field(mi.Vector3f(direction), mi.Vector3f(0))

    @staticmethod
    def of(s: mi.Vector3f, of_s: mi.Complex2f, p: mi.Vector3f, of_p: mi.Complex2f) -> Field:
        """Return the field of two components, scaled to length 1."""
        scale = dr.rsqrt(dr.maximum(dr.squared_norm(of_s) + dr.squared_norm(of_p), 1e-30))
        re = (dr.real(of_s) * s + dr.real(of_p) * p) * scale
        return Field(re, (dr.imag(of_s) * s + dr.imag(of_p) * p) * scale)

    def along(self, axis: mi.Vector3f) -> mi.Complex2f:
        """Return the component along a unit vector."""
        return mi.Complex2f(dr.dot(self.re, axis), dr.dot(self.im, axis))

    def share(self, other: Field) -> mi.Float:
        """Return the share of its energy that a filter for another field lets through."""
        # The other's conjugate: what it is orthogonal to is stopped
        re = dr.dot(self.re, other.re) + dr.dot(self.im, other.im)
        im = dr.dot(self.im, other.re) - dr.dot(self.re, other.im)
        return dr.square(re) + dr.square(im)


class Filters:
    """Polarising filters, by the axes along which they let light through.

    Parameters
    ----------
    analyser, polariser : (3,) array or None
        Axis of the filter before the camera, and of that before all lights, in the world; of light in another
        direction it is that across the light which is nearest to it. None is no filter.
    right_analyser : (3,) array or None
        Of the right one of two windows.
    right : Bool or None
        Which paths from the camera begin in the right one; None is none of them.
    """

    def __init__(
        self,
        analyser: np.ndarray | None,
        polariser: np.ndarray | None,
        right_analyser: np.ndarray | None = None,
        right: mi.Bool | None = None,
    ) -> None:
        self._analyser, self._polariser = _axis(analyser), _axis(polariser)
        if right is not None and right_analyser is not None:
            self._analyser = dr.select(right, _axis(right_analyser), self._analyser)
        #: What all filters together leave of unpolarised light that nothing else polarises.
        self.leaves = 0.5 ** sum(axis is not None for axis in (analyser, polariser))

    def begins(self, d: mi.Vector3f, first: mi.Bool, state: mi.Point2f) -> Field:
        """Return the field that a path is followed with: of the filter, or of any state.

        Parameters
        ----------
        d : Vector3f
            Its direction.
        first : Bool
            Whether it comes straight from the camera; the light of others is unpolarised.
        state : Point2f
            Numbers in [0, 1): where on Poincaré's sphere.
        """
        frame = mi.Frame3f(d)
        s, c = dr.sincos(dr.pi * state.x)
        # Axes of the ellipse
        long, short = c * frame.s + s * frame.t, c * frame.t - s * frame.s
        s, c = dr.sincos(0.5 * dr.safe_asin(2 * state.y - 1))
        field = Field(c * long, s * short)
        if self._analyser is not None:
            field = dr.select(first, Field.linear(_across(self._analyser, d)), field)
        return field

    def stokes(self, field: Field, d: mi.Vector3f, polarises: mi.Bool) -> mi.Vector3f:
        """Return the last three of Stokes' parameters of a path from the camera, by the first.

        Parameters
        ----------
        field : Field
            What `begins` told.
        d : Vector3f
            The path's direction; they are told in Mitsuba's basis of light that goes against it
            (``mitsuba.mueller.stokes_basis``).
        polarises : Bool
            Whether anything that polarises light has been met.
        """
        x = mi.mueller.stokes_basis(-d)
        of_x, of_y = field.along(x), field.along(dr.cross(x, d))
        both = of_x * dr.conj(of_y)
        s = mi.Vector3f(dr.squared_norm(of_x) - dr.squared_norm(of_y), 2 * dr.real(both), -2 * dr.imag(both))
        # Behind the camera's filter all light has its state
        return s if self._analyser is not None else dr.select(polarises, 3 * s, 0)

    def passes(self, field: Field, d: mi.Vector3f) -> mi.Float:
        """Return what the filter before a light leaves of a path, by what it leaves of unpolarised light."""
        if self._polariser is None:
            return mi.Float(1)
        return 2 * field.share(Field.linear(_across(self._polariser, d)))


def _axis(axis: np.ndarray | None) -> mi.Vector3f | None:
    return None if axis is None else mi.Vector3f(*(dr.opaque(mi.Float, float(x)) for x in axis))


def _across(axis: mi.Vector3f, d: mi.Vector3f) -> mi.Vector3f:
    """Return the unit vector across a direction that is nearest to an axis."""
    across = axis - dr.dot(axis, d) * d
    length = dr.norm(across)
    return dr.select(length > 1e-6, across / length, mi.Frame3f(d).s)


def at_interface(
    field: Field,
    d: mi.Vector3f,
    n: mi.Vector3f,
    cos_i: mi.Float,
    index: mi.Float,
    d_back: mi.Vector3f,
    d_on: mi.Vector3f,
) -> tuple[mi.Float, Field, Field]:
    """Return what an interface of two isotropic media does to a field.

    Fresnel's equations, Born & Wolf, 7th ed., sections 1.5.2 and 1.5.4; p-polarised fields are told by those
    of their magnetic fields.

    Parameters
    ----------
    field : Field
        Light that comes.
    d, d_back, d_on : Vector3f
        Its direction, that of what is reflected, and that of what is refracted.
    n : Vector3f
        The normal.
    cos_i : Float
        Cosine of the angle of incidence, above 0.
    index : Float
        Index on the side that light comes from, by that beyond.

    Returns
    -------
    (share, back, on)
        Reflected share, and the fields that are reflected and refracted.
    """
    s = dr.cross(d, n)
    length = dr.norm(s)
    s = dr.select(length > 1e-5, s / length, mi.Frame3f(n).s)
    s = dr.normalize(s - dr.dot(s, d) * d)
    square = 1 - dr.square(index) * (1 - dr.square(cos_i))
    cos_t = mi.Complex2f(dr.safe_sqrt(square), dr.safe_sqrt(-square))
    of_s, of_p = field.along(s), field.along(dr.cross(s, d))
    r_s = (index * cos_i - cos_t) / (index * cos_i + cos_t)
    r_p = (cos_i - index * cos_t) / (cos_i + index * cos_t)
    whole = dr.maximum(dr.squared_norm(of_s) + dr.squared_norm(of_p), 1e-30)
    share = (dr.squared_norm(r_s * of_s) + dr.squared_norm(r_p * of_p)) / whole
    back = Field.of(s, r_s * of_s, dr.cross(s, d_back), r_p * of_p)
    through_s, through_p = (dr.safe_sqrt(1 - dr.squared_norm(r)) for r in (r_s, r_p))
    on = Field.of(s, through_s * of_s, dr.cross(s, d_on), through_p * of_p)
    return dr.select(square <= 0, 1, dr.minimum(share, 1)), back, on


def mirrored(
    field: Field, d: mi.Vector3f, n: mi.Vector3f, cos_air: mi.Float, eta: mi.UnpolarizedSpectrum
) -> tuple[mi.UnpolarizedSpectrum, Field]:
    """Return what a surface mirrors of light from outside, of each index, and the field of the first."""
    d_back = d + 2 * cos_air * n
    found = [at_interface(field, d, n, cos_air, dr.rcp(index), d_back, d) for index in eta]
    return mi.UnpolarizedSpectrum([share for share, *_ in found]), found[0][1]


def refracted_field(
    field: Field, d: mi.Vector3f, n: mi.Vector3f, cos_air: mi.Float, index: mi.Float, d_in: mi.Vector3f
) -> Field:
    """Return the field of light that has entered in a direction, through a surface of an index inside."""
    return at_interface(field, d, n, cos_air, dr.rcp(index), d, d_in)[2]

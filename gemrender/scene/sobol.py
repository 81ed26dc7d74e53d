"""Random numbers that are even over all samples, however many: Owen-scrambled Sobol' sequences.

References: A. B. Owen, Monte Carlo variance of scrambled net quadrature, SIAM J. Numer. Anal. 34 (1997); the
scrambling by hashes is that of B. Burley, Practical hash-based Owen scrambling, JCGT 9 (2020).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["DIMENSIONS", "TEA_ROUNDS", "PixelSamples", "sobol"]

#: Degree and inner coefficients of the primitive polynomials, and first direction numbers, of the dimensions
#: from the second on (S. Joe and F. Y. Kuo, Constructing Sobol sequences with better two-dimensional
#: projections, SIAM J. Sci. Comput. 30 (2008), their table new-joe-kuo-6.21201).
_POLYNOMIALS = (
    (1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)), (3, 2, (1, 1, 1)), (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
)  # fmt: skip
#: Dimensions that there are.
DIMENSIONS = 1 + len(_POLYNOMIALS)
#: Rounds of the cipher that makes keys: with Mitsuba's default of 4, neighbouring pixels and the two halves
#: of a picture, whose seeds are neighbours, get numbers that go together; from 6 on none that do.
TEA_ROUNDS = 8


def sobol(number: Any, keys: Sequence[Any]) -> list[Any]:
    """Return a point of a scrambled Sobol' sequence, its coordinates in [0, 1).

    Parameters
    ----------
    number : UInt32
        Which point. Of any first 2^k of them each elementary interval has its share.
    keys : sequence of UInt32
        One a dimension, at most `DIMENSIONS`: sequences of other keys are independent.
    """
    import mitsuba as mi

    return [
        mi.Float(_scrambled(_sobol(number, dimension), key) >> 8) * 2.0**-24
        for dimension, key in enumerate(keys)
    ]


@dataclass
class PixelSamples:
    """The samples of pixels, as a sampler that an integrator asks.

    What the camera is asked with is one sequence. Every later number or pair of numbers is a sequence of its
    own, of the same samples in another order ("padding": M. Pharr, W. Jakob, G. Humphreys, Physically Based
    Rendering, 4th ed., section 8.7). It is a PyTree of Dr.Jit's, so that loops carry it on.

    Parameters
    ----------
    number : UInt32
        Which sample of its pixel each is.
    key : UInt32
        Of pixel and seed: numbers of other keys are independent.
    draws : UInt32
        How many sequences there have been.
    """

    number: Any
    key: Any
    draws: Any

    @classmethod
    def of(cls, pixel: Any, number: Any, seed: Any) -> PixelSamples:
        """Return the samples of pixels, by the pixel's number, the sample's, and a seed (UInt32)."""
        import mitsuba as mi

        key, _ = mi.sample_tea_32(pixel, seed, TEA_ROUNDS)
        return cls(mi.UInt32(number), key, mi.UInt32(0))

    def next(self, dimensions: int) -> list[Any]:
        """Return the coordinates, in [0, 1), of a point of a new sequence, in the order of the samples."""
        return sobol(self.number, self._keys(dimensions))

    def next_1d(self, active: Any = True) -> Any:
        """Return a number in [0, 1) for each sample."""
        order, key = self._keys(2)
        return sobol(_scrambled(self.number, order), [key])[0]

    def next_2d(self, active: Any = True) -> Any:
        """Return two numbers in [0, 1) for each sample, which are even as a pair."""
        import mitsuba as mi

        order, *keys = self._keys(3)
        return mi.Point2f(*sobol(_scrambled(self.number, order), keys))

    def _keys(self, n: int) -> list[Any]:
        """Return independent keys of a new sequence."""
        import mitsuba as mi

        self.draws += 1
        keys = list(mi.sample_tea_32(self.key, self.draws, TEA_ROUNDS))
        while len(keys) < n:
            keys += mi.sample_tea_32(keys[-2], keys[-1], TEA_ROUNDS)
        return keys[:n]


def _directions(dimension: int) -> list[int]:
    """Return the direction numbers of a dimension after the first, in 2^-32: of bits from the lowest."""
    degree, inner, first = _POLYNOMIALS[dimension - 1]
    m = list(first)
    for k in range(degree, 32):
        new = m[k - degree] ^ (m[k - degree] << degree)
        for j in range(1, degree):
            if (inner >> (degree - 1 - j)) & 1:
                new ^= m[k - j] << j
        m.append(new)
    return [value << (31 - bit) for bit, value in enumerate(m)]


def _sobol(number: Any, dimension: int) -> Any:
    """Return a coordinate of a point of Sobol's own sequence, in 2^-32."""
    import drjit as dr
    import mitsuba as mi

    if dimension == 0:
        return dr.brev(number)
    out = mi.UInt32(0)
    for bit, direction in enumerate(_directions(dimension)):
        out ^= dr.select((number & (1 << bit)) != 0, mi.UInt32(direction), 0)
    return out


def _scrambled(x: Any, key: Any) -> Any:
    """Turn each binary digit by a hash of the digits before it: numbers that share digits go on to do so."""
    import drjit as dr

    x = dr.brev(x)
    x ^= x * 0x3D20ADEA
    x += key
    x *= (key >> 16) | 1
    x ^= x * 0x05526C56
    x ^= x * 0x53A22864
    return dr.brev(x)

"""Numbers of samples: even over every stratum, and independent of those of other pixels and seeds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gemrender.render.backend import ensure_variant
from gemrender.scene.sobol import DIMENSIONS, PixelSamples, sobol

#: Points, as many as samples that a picture commonly has.
N = 256
#: Probability below which what should be chance is not believed to be.
UNBELIEVED = 1e-4
#: Standard deviations that correlations stay within: a hundred of them, at that probability.
SURE = 5.0


@pytest.fixture(scope="module", autouse=True)
def _variant():
    ensure_variant("llvm_ad_spectral")


def points(key=1, first=0, n=N):
    """Return points of all dimensions, (n, DIMENSIONS)."""
    import drjit as dr
    import mitsuba as mi

    keys = [mi.UInt32(key * 7919 + k) for k in range(DIMENSIONS)]
    return np.stack([np.asarray(x) for x in sobol(dr.arange(mi.UInt32, n) + first, keys)], axis=1)


def numbers(pixel, draws, *, n=N, seed=0):
    """Return the pairs of one pixel's samples, (draws, n, 2)."""
    import drjit as dr
    import mitsuba as mi

    samples = PixelSamples.of(mi.UInt32(pixel), dr.arange(mi.UInt32, n), seed)
    return np.stack([np.array(samples.next_2d()).T for _ in range(draws)])


def counts(x, *strata):
    """Return how many points each box has, of so many strata an axis."""
    edges = [np.linspace(0, 1, n + 1) for n in strata]
    return np.histogramdd(x, bins=edges)[0].ravel()


@pytest.mark.parametrize("first", [0, 3 * N, 1 << 22])
def test_each_number_is_in_a_stratum_of_its_own(first):
    x = points(first=first)
    assert ((x >= 0) & (x < 1)).all()
    for column in x.T:
        assert (counts(column[:, None], N) == 1).all()


@pytest.mark.parametrize("wide", [2**k for k in range(9)])
def test_a_pair_fills_every_kind_of_box(wide):
    """Sobol's first two dimensions are a (0, 2)-sequence in base 2, and scrambling keeps that."""
    assert (counts(points()[:, :2], wide, N // wide) == 1).all()
    for pair in numbers(pixel=5, draws=3):
        assert (counts(pair, wide, N // wide) == 1).all()


def test_the_sequence_is_that_of_joe_and_kuo():
    """Owen's scrambling changes boxes, not how many points they have: those of SciPy's own sequence."""
    from scipy import stats

    ours, theirs = points(), stats.qmc.Sobol(DIMENSIONS, scramble=False).random(N)
    for axes in itertools.combinations(range(DIMENSIONS), 3):
        for strata in ((8, 8, 4), (16, 2, 2), (2, 4, 16)):
            found, right = (np.sort(counts(x[:, axes], *strata)) for x in (ours, theirs))
            assert (found == right).all(), (axes, strata)


def test_a_point_is_anywhere_by_chance():
    """The same point of many keys: uniform, as Owen's scrambling makes it."""
    import drjit as dr
    import mitsuba as mi
    from scipy import stats

    keys = dr.arange(mi.UInt32, 1 << 14)
    keys = [mi.sample_tea_32(keys, mi.UInt32(k), 8)[0] for k in range(DIMENSIONS)]
    for number in (0, 1, 77):
        for x in sobol(mi.UInt32(number), keys):
            assert stats.kstest(np.asarray(x), "uniform").pvalue > UNBELIEVED


def test_pixels_seeds_and_draws_are_independent():
    of_each = [numbers(pixel, 3, n=1 << 12, seed=seed) for pixel in (0, 1, 640) for seed in (0, 1)]
    columns = np.concatenate([x.transpose(0, 2, 1).reshape(6, -1) for x in of_each])
    correlations = np.corrcoef(columns) - np.eye(len(columns))
    assert np.abs(correlations).max() < SURE / np.sqrt(columns.shape[1])


def test_numbers_go_on_where_a_pass_before_ended():
    whole = points(n=64)
    assert (np.concatenate([points(n=40), points(first=40, n=24)]) == whole).all()

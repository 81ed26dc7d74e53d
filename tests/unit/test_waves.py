"""Waves of birefringent stones in kernels, against the reference in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from thorough import chosen

from gemrender.optics.crystals import Indicatrix, optic_axes, shares_entering, shares_inside
from gemrender.render.backend import ensure_variant

#: Shares of energy and directions in single precision.
SINGLE = 2e-5
#: The same in double: as much better as rounding is, but for what the numbers lose on the way there.
DOUBLE = 1e-10
#: The share of cases where single precision does worse: at critical angles, and near optic axes, along which
#: the kernel takes them to be a little off.
RARE = 1e-3
CASES = 20_000


def _units(rng: np.random.Generator, n: int) -> np.ndarray:
    v = rng.normal(size=(n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1)[:, None])


def _frames(rng: np.random.Generator, n: int) -> np.ndarray:
    z, other = _units(rng, n), _units(rng, n)
    x = np.cross(other, z)
    x /= np.linalg.norm(x, axis=1)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=1)


def _crystals(kind: str, seed: int) -> Indicatrix:
    rng = np.random.default_rng(seed)
    n_o = rng.uniform(1.4, 2.8, CASES)
    ratio = 1 + rng.uniform(0.002, 0.15, (2, CASES)) * rng.choice([-1, 1], (2, CASES))
    frames = _frames(rng, CASES)
    if kind == "uniaxial":
        return Indicatrix.uniaxial(n_o, n_o * ratio[0], frames)
    return Indicatrix.biaxial(n_o, n_o * ratio[0], n_o * ratio[1], frames)


def _kernel(kind: str, crystal: Indicatrix, kt: np.ndarray, n: np.ndarray, within: float):  # type: ignore[no-untyped-def]
    """Return the kernel's shares: reflected[of][into], passed[of], as arrays."""
    ensure_variant("llvm_ad_mono")
    import mitsuba as mi

    from gemrender.plugins.waves import Facet, shares, uniaxial
    from gemrender.plugins.waves_biaxial import biaxial

    vector = mi.Vector3f if within == SINGLE else mi.Vector3d
    facet = Facet.of(vector(kt.T), vector(n.T))
    axes = [vector(crystal.frame[:, i].T) for i in range(3)]
    index = vector(crystal.indices.T)
    if kind == "uniaxial":
        return shares(facet, *uniaxial(facet, axes[2], index.x, index.z))
    return shares(facet, *biaxial(facet, axes, index))


def _differ(kernel: np.ndarray, reference: np.ndarray, within: float) -> None:
    off = np.abs(kernel - reference)
    assert np.isfinite(kernel).all()
    assert np.mean(off > within) < RARE


@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("within", chosen([SINGLE, DOUBLE], [DOUBLE]))
def test_reflection_inside_is_the_references(kind: str, mode: int, within: float) -> None:
    crystal = _crystals(kind, 1)
    rng = np.random.default_rng(2)
    n, d = _units(rng, CASES), _units(rng, CASES)
    d *= np.sign(np.sum(d * n, axis=1))[:, None]
    k = d * crystal.indices.min(axis=1)[:, None]  # within both surfaces of wave vectors
    kt = k - np.sum(k * n, axis=1)[:, None] * n
    kernel = _kernel(kind, crystal, kt, n, within)
    reference = shares_inside(n, k, np.full(CASES, mode), crystal)
    for into in range(2):
        _differ(np.array(kernel.reflected[mode][into]), reference.reflected[:, into], within)
        _differ(np.array(kernel.back[into].k).T, reference.k[:, into], within)
        _differ(np.array(kernel.back[into].ray).T, reference.ray[:, into], within)
    _differ(np.array(kernel.passed[mode]), reference.transmitted.sum(axis=1), within)


@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
@pytest.mark.parametrize("within", [SINGLE, DOUBLE])
def test_what_enters_is_what_would_leave(kind: str, within: float) -> None:
    crystal = _crystals(kind, 3)
    rng = np.random.default_rng(4)
    n, d = _units(rng, CASES), _units(rng, CASES)
    d *= -np.sign(np.sum(d * n, axis=1))[:, None]
    # Closer to grazing the part along the normal, 1 - kt^2, is rounding in single precision
    d = np.where(np.abs(np.sum(d * n, axis=1)) > 0.02, d.T, -n.T).T
    kt = d - np.sum(d * n, axis=1)[:, None] * n
    kernel = _kernel(kind, crystal, -kt, n, within)
    reference = shares_entering(n, d, crystal)
    for mode in range(2):
        _differ(0.5 * np.array(kernel.passed[mode]), reference.transmitted[:, mode], within)
        _differ(-np.array(kernel.out[mode].k).T, reference.k[:, mode], within)
        _differ(-np.array(kernel.out[mode].ray).T, reference.ray[:, mode], within)


@pytest.mark.parametrize("within", [SINGLE, DOUBLE])
@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-5])
def test_along_an_optic_axis_of_a_biaxial_crystal_the_index_is_the_middle_one(
    within: float, off: float
) -> None:
    """Straight on, where both waves are one and so reflected by Fresnel's law; or next to that."""
    indices = np.array([1.619, 1.622, 1.631])
    crystal = Indicatrix.biaxial(*indices, np.eye(3))
    axis = np.asarray(optic_axes(crystal)).reshape(-1, 3)[0]
    across = np.cross(axis, [0.0, 1.0, 0.0])
    n = axis + off * across / np.linalg.norm(across)
    one = Indicatrix(indices[None], np.eye(3)[None], False)
    kernel = _kernel("biaxial", one, np.zeros((1, 3)), n[None], within)
    back = ((indices[1] - 1) / (indices[1] + 1)) ** 2
    for mode in range(2):
        assert np.array(kernel.passed[mode])[0] == pytest.approx(1 - back, abs=max(within, off))
        assert sum(np.array(x)[0] for x in kernel.reflected[mode]) == pytest.approx(
            back, abs=max(within, off)
        )
    # Fields at right angles: what one wave takes of unpolarised light the other leaves
    first, second = (np.array(field.re)[:, 0] for field in kernel.fields)
    assert abs(first @ second) < max(2e-7, off)


def test_absorption_counts_one_of_an_ordinary_wave_and_between_of_the_other() -> None:
    # Straight on through a facet across the optic axis' plane: the extraordinary field is along the axis
    ensure_variant("llvm_ad_mono")
    import mitsuba as mi

    from gemrender.plugins.waves import Facet, uniaxial

    facet = Facet.of(mi.Vector3f(0, 0, 0), mi.Vector3f(0, 0, 1))
    (ordinary, extraordinary), _ = uniaxial(facet, mi.Vector3f(1, 0, 0), mi.Float(1.6), mi.Float(1.7))
    np.testing.assert_allclose(np.array(ordinary.absorbs).ravel(), [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(np.array(extraordinary.absorbs).ravel(), [0, 0, 1], atol=1e-6)

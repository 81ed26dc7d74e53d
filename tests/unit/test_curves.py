"""Tone curves: what each does to black, grey and white, and to colours."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from gemrender.cli import render as command
from gemrender.render.curves import (
    AGX_WHITE,
    CURVES,
    FILMIC_WHITE,
    MID_GREY,
    apply_curve,
    lifted,
    needed_for,
)
from gemrender.render.develop import develop
from gemrender.scene import setup

#: What a handful of roundings in double precision come to.
ROUNDING = 1e-12
#: Where each reaches white: what is above is cut by the gamut. Neutral does so in the limit.
WHITES = {"linear": 1.0, "contrast": 1.0, "filmic": FILMIC_WHITE, "agx": AGX_WHITE, "neutral": 1e15}


def grey(curve, values):
    """A curve's output for greys."""
    out = apply_curve(curve, np.repeat(np.atleast_1d(np.asarray(values, float))[:, None], 3, axis=1))
    np.testing.assert_allclose(out, out[:, :1].repeat(3, axis=1), rtol=ROUNDING, atol=ROUNDING)
    return out[:, 0]


def test_set_ups_and_the_command_line_know_all_curves():
    assert tuple(CURVES) == setup.CURVES == inspect.getmodule(command).CURVES


@pytest.mark.parametrize("curve", CURVES)
def test_black_stays_black_and_white_gets_white(curve):
    np.testing.assert_allclose(grey(curve, [0.0, WHITES[curve]]), [0, 1], atol=ROUNDING)


@pytest.mark.parametrize("curve", CURVES)
def test_more_light_is_brighter_up_to_white(curve):
    values = grey(curve, np.geomspace(1e-3, min(WHITES[curve], 1e3), 2000))
    assert (np.diff(values) > 0).all()


@pytest.mark.parametrize("curve", [curve for curve in CURVES if curve != "neutral"])
def test_mid_grey_stays(curve):
    np.testing.assert_allclose(grey(curve, MID_GREY), MID_GREY, rtol=ROUNDING)


def test_contrast_darkens_the_darks_and_lightens_the_lights():
    below, above = np.linspace(0.001, 0.179, 50), np.linspace(0.181, 0.999, 50)
    assert (grey("contrast", below) < below).all()
    assert (grey("contrast", above) > above).all()


def test_neutral_is_exact_from_8_to_80_hundredths_but_for_what_a_surface_mirrors(rng):
    colours = rng.uniform(0.08, 0.8, (500, 3))
    np.testing.assert_allclose(apply_curve("neutral", colours), colours - 0.04, rtol=ROUNDING)


def test_neutral_keeps_hues_however_bright(rng):
    colours = rng.uniform(0, 50, (500, 3))
    out = apply_curve("neutral", colours)
    assert out.min() >= 0
    assert out.max() < 1
    # The middle channel keeps its place between the other two
    low, middle, high = np.sort(colours, axis=1).T
    new_low, new_middle, new_high = np.sort(out, axis=1).T
    np.testing.assert_allclose(
        (new_middle - new_low) / (new_high - new_low), (middle - low) / (high - low), rtol=1e-9
    )


def test_agx_makes_bright_colours_pale():
    red = np.array([[0.5, 0.02, 0.02]]) * np.array([[1.0], [8.0], [64.0]])
    out = apply_curve("agx", red)
    saturation = 1 - out.min(axis=1) / out.max(axis=1)
    assert (np.diff(saturation) < -0.1).all()


def test_agx_passes_where_its_sigmoid_was_drawn():
    """Half a stop either side of mid grey, the sigmoid's slope, 2.4 a range of 16.5 stops, tells the rest."""
    step = 1e-4
    log = np.log2(grey("agx", MID_GREY * 2.0 ** np.array([-step, step])))
    encoded = 2.0 ** (log / 2.4)
    slope = (encoded[1] - encoded[0]) / (2 * step) * 16.5
    assert slope == pytest.approx(2.4, rel=1e-4)


def test_colours_beyond_the_screen_are_lifted_to_its_edge_at_their_luminance():
    from gemrender.colorimetry import luminance_weights

    colours = np.array([[0.5, -0.1, 0.2], [-0.3, 1.0, -0.2], [0.1, 0.2, 0.3], [0.0, -1.0, 0.0]])
    out = lifted(colours)
    np.testing.assert_allclose(out.min(axis=1), [0, 0, 0.1, 0], atol=ROUNDING)
    expected = np.maximum(colours @ luminance_weights(), 0)
    np.testing.assert_allclose(out @ luminance_weights(), expected, atol=ROUNDING)


@pytest.mark.parametrize("curve", CURVES)
def test_the_grey_that_a_curve_needs_is_its_inverse(curve):
    for level in (0.01, 0.18, 0.956):
        np.testing.assert_allclose(grey(curve, needed_for(level, curve)), level, rtol=1e-9)


@pytest.mark.parametrize("curve", CURVES)
def test_any_number_is_developed(curve):
    xyz = np.array([[[1e30, 2e30, 1e29], [-1.0, -5.0, 3.0], [1e-30, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    shown = develop(xyz, white_xyz=(0.95, 1.0, 1.09), exposure=1.0, curve=curve)
    assert shown[0, 0].min() > 250
    np.testing.assert_array_equal(shown[0, 1:], 0)

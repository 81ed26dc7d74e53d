"""Tone curves: what becomes of linear sRGB, after exposure, on the way to a screen.

Each takes linear sRGB (n, 3) and returns linear sRGB, which `develop` then fits into the gamut. Grey stays
grey, black stays black, and more light never gets darker. They differ in what they do with white:

==========  ==================================================================================
Name        Curve
==========  ==================================================================================
`linear`    none: 1 is white, and all above it too
`contrast`  S-shaped: black, mid grey and 1 stay, darks get darker and lights lighter
`neutral`   Khronos PBR Neutral, of product pictures: exact colours below 0.8, then a shoulder
`filmic`    Narkowicz's fit to ACES: 1 becomes 0.73, white is 10
`agx`       AgX as in Blender 4: 1 becomes 0.55, white is 16.3; bright colours go pale
==========  ==================================================================================
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from gemrender.colorimetry import colour_science, luminance_weights

__all__ = [
    "AGX_WHITE",
    "CURVES",
    "FILMIC_WHITE",
    "MID_GREY",
    "apply_curve",
    "filmic_gain",
    "lifted",
    "needed_for",
]

#: Luminance that all curves but `neutral` leave as it is: a grey card's 18 %.
MID_GREY = 0.18

#: Coefficients a, b, c, d and e of the filmic curve (Narkowicz 2015, see `filmic_gain`).
_FILMIC = (2.51, 0.03, 2.43, 0.59, 0.14)

# Khronos PBR Neutral (see `_neutral`): what is taken off, where the shoulder begins, how colours get paler
_F90, _SHOULDER, _PALER = 0.04, 0.76, 0.15

#: AgX (see `_agx`): stops below and above mid grey that it shows, its slope there, and power of both ends.
_AGX_STOPS, _AGX_SLOPE, _AGX_POWER = (-10.0, 6.5), 2.4, 1.5
#: Exponent of the screen that its sigmoid is drawn for.
_AGX_SCREEN = 2.4
_AGX_INSET = (
    (0.856627153315983, 0.0951212405381588, 0.0482516061458583),
    (0.137318972929847, 0.761241990602591, 0.101439036467562),
    (0.11189821299995, 0.0767994186031903, 0.811302368396859),
)
_AGX_OUTSET = (
    (1.1271005818144368, -0.11060664309660323, -0.016493938717834573),
    (-0.1413297634984383, 1.157823702216272, -0.016493938717834257),
    (-0.14132976349843826, -0.11060664309660294, 1.2519364065950405),
)
#: Luminance that it shows as white.
AGX_WHITE = MID_GREY * 2 ** _AGX_STOPS[1]


def apply_curve(name: str, rgb: np.ndarray) -> np.ndarray:
    """Return linear sRGB (n, 3) after the curve of a name of `CURVES`."""
    return CURVES[name](rgb)


def needed_for(level: float, curve: str) -> float:
    """Return the grey that a curve brings to a level, 0 to below 1: its inverse, by halving.

    Parameters
    ----------
    level : float
        Linear value on the screen.
    curve : str
        A name of `CURVES`.
    """
    low, high = 0.0, 1e3
    for _ in range(80):
        middle = 0.5 * (low + high)
        reached = float(CURVES[curve](np.full((1, 3), middle))[0, 0])
        low, high = (low, middle) if reached >= level else (middle, high)
    return high


# ---- The curves ----


def _linear(rgb: np.ndarray) -> np.ndarray:
    return rgb


def filmic_gain(luminance: object) -> np.ndarray:
    """Return the filmic curve's output over its input, (...) as the luminance.

    The curve is Krzysztof Narkowicz's fit to the ACES reference output, "ACES Filmic Tone Mapping Curve"
    (2015): x (a x + b) / (x (c x + d) + e). Its input is scaled here (by 0.723) such that `MID_GREY` stays
    in place; 1 becomes 0.73, and white is reached at 10.01. Applied to the luminance, not to each channel,
    which would pull strong colours to the hues of the primaries: fire is to keep its hue.

    Parameters
    ----------
    luminance : array_like (...)
        Luminance after exposure; below 0 counts as 0.
    """
    return _narkowicz_gain(np.maximum(luminance, 0), _filmic_scale(), 1.0)  # type: ignore[call-overload]


def _narkowicz_gain(luminance: np.ndarray, scale: float, factor: float) -> np.ndarray:
    """Return factor f(scale Y) / Y of Narkowicz's curve f; its limit in the dark is a number."""
    a, b, c, d, e = _FILMIC
    x = luminance * scale
    return np.asarray(factor * scale * (a * x + b) / (x * (c * x + d) + e))


def _filmic(rgb: np.ndarray) -> np.ndarray:
    return np.asarray(rgb * filmic_gain(rgb @ luminance_weights())[:, None])


def _contrast(rgb: np.ndarray) -> np.ndarray:
    """Return the same curve with its white at 1, as a photographer sets the white of a print to the paper's.

    Both ends are scaled such that mid grey and 1 stay: k f(s Y), k f(s) = 1, k f(s MID_GREY) = MID_GREY.
    """
    scale, factor = _contrast_scales()
    gain = _narkowicz_gain(np.maximum(rgb @ luminance_weights(), 0), scale, factor)
    return np.asarray(rgb * gain[:, None])


def _neutral(rgb: np.ndarray) -> np.ndarray:
    """Return the curve that shops' pictures of products are made with.

    Khronos Group, "Khronos PBR Neutral Tone Mapper" (Emmett Lalish, 2024),
    https://github.com/KhronosGroup/ToneMapping: the 0.04 that smooth surfaces mirror of white surroundings is
    taken off (below 0.08 less, such that 0 stays), the largest channel is bent from 0.76 on, and what is so
    bent gets paler by and by. Hues stay. White is reached in the limit; 1 becomes 0.87.
    """
    colours = lifted(rgb)
    least = colours.min(axis=1)
    out = colours - np.where(least < 2 * _F90, least - least**2 / (4 * _F90), _F90)[:, None]
    peak = out.max(axis=1)
    bent = peak > _SHOULDER
    room = 1 - _SHOULDER
    new = 1 - room**2 / (np.maximum(peak, _SHOULDER) + room - _SHOULDER)
    kept = 1 / (_PALER * (peak - new) + 1)
    pale = kept[:, None] * out * (new / np.where(bent, peak, 1))[:, None] + (new * (1 - kept))[:, None]
    return np.where(bent[:, None], pale, out)


def _agx(rgb: np.ndarray) -> np.ndarray:
    """Return Troy Sobotka's AgX with the numbers of Blender 4 (Eary Chow), without its mixing of hues.

    https://github.com/EaryChow/AgX_LUT_Gen, AgXBaseRec2020.py: linear BT.2020, drawn towards grey by a
    matrix, a sigmoid of log2 from 10 stops below mid grey to 6.5 above for each channel, and drawn back in
    part by another. The sigmoid is y0 + s u / (1 + u^p)^(1/p) with u = slope (x - x0) / s on either side
    of mid grey, (x0, y0), and the scales s such that it ends at 0 and 1.
    """
    colours = lifted(rgb)
    to_wide, from_wide = _agx_matrices()
    wide = np.maximum(colours @ to_wide.T, MID_GREY * 2 ** _AGX_STOPS[0])
    low, high = _AGX_STOPS
    x = np.minimum((np.log2(wide / MID_GREY) - low) / (high - low), 1)
    x0, y0 = -low / (high - low), MID_GREY ** (1 / _AGX_SCREEN)
    p = _AGX_POWER

    def side(u: np.ndarray, width: float, height: float) -> np.ndarray:
        """From mid grey outwards: u from 0 to `width` gives 0 to `height`."""
        end = _AGX_SLOPE * width
        scale = (end**-p * ((end / height) ** p - 1)) ** (-1 / p)
        v = _AGX_SLOPE * np.maximum(u, 0) / scale
        return np.asarray(scale * v / (1 + v**p) ** (1 / p))

    y = y0 + side(x - x0, 1 - x0, 1 - y0) - side(x0 - x, x0, y0)
    return np.asarray(np.clip(y, 0, 1) ** _AGX_SCREEN @ from_wide.T)


#: The curves by their names, as on the command line.
CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "linear": _linear,
    "filmic": _filmic,
    "contrast": _contrast,
    "neutral": _neutral,
    "agx": _agx,
}


def lifted(rgb: np.ndarray) -> np.ndarray:
    """Return linear sRGB (n, 3) without channels below 0: mixed with the grey of the same luminance."""
    grey = np.maximum(rgb @ luminance_weights(), 0)
    low = rgb.min(axis=1)
    kept = np.ones_like(grey)
    np.divide(grey, grey - low, out=kept, where=low < 0)
    return np.asarray(np.maximum(kept[:, None] * rgb + ((1 - kept) * grey)[:, None], 0))


# ---- What they are made of ----


def _filmic_scale() -> float:
    """Return the factor on the curve's input that leaves `MID_GREY` where it is: the quadratic's root."""
    return _crossing(MID_GREY, MID_GREY)


def _crossing(x: float, y: float) -> float:
    """Return the scale s with f(s x) = y of Narkowicz's curve f: the quadratic's positive root."""
    a, b, c, d, e = _FILMIC
    p, q, r = a - y * c, b - y * d, -y * e
    return float((-q + np.sqrt(q * q - 4 * p * r)) / (2 * p * x))


#: Luminance that the filmic curve shows as white.
FILMIC_WHITE = _crossing(1.0, 1.0) / _filmic_scale()


@lru_cache(maxsize=1)
def _contrast_scales() -> tuple[float, float]:
    """Return s and k of `_contrast`, by halving: the share of mid grey in white falls as s grows less."""
    low, high = 0.3, 0.723
    for _ in range(80):
        scale = 0.5 * (low + high)
        white = float(_narkowicz_gain(np.array(1.0), scale, 1.0))
        grey = float(MID_GREY * _narkowicz_gain(np.array(MID_GREY), scale, 1.0))
        low, high = (low, scale) if grey / white > MID_GREY else (scale, high)
    return high, 1 / white


@lru_cache(maxsize=1)
def _agx_matrices() -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices from linear sRGB to where AgX's sigmoid is drawn, and back."""
    colour = colour_science()
    spaces = colour.RGB_COLOURSPACES
    wide = colour.matrix_RGB_to_RGB(spaces["sRGB"], spaces["ITU-R BT.2020"], None)
    narrow = np.linalg.inv(wide)
    to, back = np.array(_AGX_INSET) @ wide, narrow @ np.array(_AGX_OUTSET)
    return to / to.sum(axis=1, keepdims=True), back / back.sum(
        axis=1, keepdims=True
    )  # grey stays grey exactly

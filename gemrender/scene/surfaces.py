"""What things beside the stones are made of: metals, glass, paper, velvet, skin, as Mitsuba's surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.colorimetry import colour_matching, xyz_to_linear_srgb
from gemrender.optics.metals import METALS, Metal

__all__ = ["COLOURED", "FINISHED", "FINISHES", "MATERIALS", "surface_of"]

FINISHES = ("polished", "rough")
#: Materials with a finish, materials that take a colour, and all.
FINISHED = (*METALS, "glass")
COLOURED = ("paper", "velvet")
MATERIALS = (*METALS, "glass", *COLOURED, "skin")

#: Roughness, alpha of GGX's distribution, chosen: of a rough metal, as of satin finish; of ground glass and
#: bruted girdles; of skin.
SATIN, GROUND, SKIN_GLOSS = 0.2, 0.4, 0.35
#: Index of crown glass, and of skin's surface.
CROWN_GLASS, SKIN_INDEX = 1.52, 1.4
#: Diffuse reflectance where no colour is given: white paper, and black velvet.
_GREY = {"paper": 0.85, "velvet": 0.015}
#: Where spectra are written down [nm].
_NM = np.arange(360.0, 831.0, 10.0)
#: Reflectance of fair skin every 20 nm from 380 nm: the patch "light skin" of the ColorChecker, mean of 30
#: charts (BabelColor, "The ColorChecker Pages", 2012).
_SKIN_NM = np.arange(380.0, 741.0, 20.0)
_SKIN = (
    0.117, 0.175, 0.196, 0.204, 0.228, 0.280, 0.329, 0.315, 0.273, 0.277, 0.339, 0.488, 0.546, 0.578, 0.612,
    0.638, 0.678, 0.717, 0.740,
)  # fmt: skip


def surface_of(
    material: str,
    *,
    finish: str = "polished",
    colour: tuple[float, float, float] | None = None,
    stock: bool = False,
) -> dict[str, Any]:
    """Return the surface of a material, as a scene dictionary.

    Parameters
    ----------
    material : str
        One of `MATERIALS`.
    finish : {"polished", "rough"}
        Of metals and glass.
    colour : (float, float, float), optional
        Diffuse reflectance of paper and velvet, linear sRGB.
    stock : bool
        Whether colours are RGB.
    """
    if material == "glass":
        glass = {"int_ior": CROWN_GLASS, "ext_ior": 1.0}
        if finish == "polished":
            return {"type": "dielectric", **glass}
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": GROUND, **glass}
    # Of metal and what is opaque no inside is seen: which way a mesh's faces look does not matter
    return {"type": "twosided", "bsdf": _opaque(material, finish, colour, stock)}


def _opaque(
    material: str, finish: str, colour: tuple[float, float, float] | None, stock: bool
) -> dict[str, Any]:
    if material in METALS:
        metal = METALS[material]
        rough = finish == "rough"
        if stock:  # the colour that it reflects straight back, as RGB variants know no spectra
            kind = {"type": "roughconductor", "distribution": "ggx", "alpha": SATIN}
            colour_of = {"material": "none", "specular_reflectance": _rgb(metal.reflectance(_NM))}
            return (kind if rough else {"type": "conductor"}) | colour_of
        kind = {"type": "gem_rough_conductor", "alpha": SATIN} if rough else {"type": "conductor"}
        return kind | {"eta": _table(metal, metal.n), "k": _table(metal, metal.k)}
    if material == "skin":
        skin = np.interp(_NM, _SKIN_NM, _SKIN)
        return {
            "type": "roughplastic",
            "distribution": "ggx",
            "alpha": SKIN_GLOSS,
            "int_ior": SKIN_INDEX,
            "ext_ior": 1.0,
            "diffuse_reflectance": _rgb(skin) if stock else _regular(skin),
        }
    if colour is None:
        grey = _GREY[material]
        return {"type": "diffuse", "reflectance": {"type": "rgb" if stock else "uniform", "value": grey}}
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}


def _table(metal: Metal, values: tuple[float, ...]) -> dict[str, Any]:
    """Return a metal's values by wavelength."""
    return _regular(np.interp(_NM, metal.wavelength_nm, values))


def _regular(values: np.ndarray) -> dict[str, Any]:
    """Return values at `_NM` as a spectrum."""
    return {
        "type": "regular",
        "wavelength_min": float(_NM[0]),
        "wavelength_max": float(_NM[-1]),
        "values": ", ".join(f"{x:.6g}" for x in values),
    }


def _rgb(reflectances: np.ndarray) -> dict[str, Any]:
    """Return the linear sRGB of reflectances at `_NM`, such that white is white."""
    seen = colour_matching(_NM)
    rgb = xyz_to_linear_srgb((reflectances[:, None] * seen).sum(axis=0))
    white = xyz_to_linear_srgb(seen.sum(axis=0))
    return {"type": "rgb", "value": [float(x) for x in np.clip(rgb / white, 0.0, 1.0)]}

"""What there is to know of a material, in numbers: the sheet that `gemrender materials` prints."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from typing import Any

from gemrender.optics.abbe import (
    FRAUNHOFER_B_NM,
    FRAUNHOFER_C_NM,
    FRAUNHOFER_F_NM,
    FRAUNHOFER_G_NM,
    SODIUM_NM,
)
from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import Formula
from gemrender.optics.material import Material
from gemrender.optics.material_files import load_material
from gemrender.optics.principal import is_pleochroic

__all__ = ["MaterialSheet", "material_sheet"]

#: What records call the indices, by Fraunhofer's letters.
_NAMES = {"n_g": "n_G", "n_f": "n_F", "n_d": "n_D", "n_c": "n_C", "n_b": "n_B"}


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialSheet:
    """A material in numbers.

    Parameters
    ----------
    name : str
        What it is called.
    n_g, n_f, n_d, n_c, n_b : float
        Refractive index, relative to air, at Fraunhofer's lines: 430.8, 486.1, 589.3, 656.3 and 686.7 nm.
    abbe_number : float or None
        Abbe's number V_D = (n_D - 1) / (n_F - n_C); None without dispersion.
    dispersion_b_g : float
        What gemmologists call dispersion, n_G - n_B.
    density : float or None
        Density [g/cm^3]; None is unknown.
    index_from : str
        What the index comes from: one of `dispersion.FORMULAE`, or ``table``.
    range_nm : pair of float
        Wavelengths that it was published for [nm].
    continued_nm : tuple of pairs of float
        Stretches of visible light beyond that range, where the index is continued [nm].
    absorbs : bool
        Whether it has a body colour.
    source : str
        Where the numbers come from.
    notes : tuple of str
        What a user should know, each a line; among them what is continued, and how.
    optic_class : str
        "isotropic", "uniaxial" or "biaxial".
    n_o, n_e : float or None
        Of a uniaxial material the ordinary and the extraordinary index at the sodium line.
    n_alpha, n_beta, n_gamma : float or None
        Of a biaxial material the least, the middle and the greatest index there.
    birefringence : float
        The greatest principal index less the least one, at the sodium line.
    optic_sign : str or None
        "+" or "-"; None of an isotropic material.
    two_v_deg : float or None
        Of a biaxial material the acute angle between its optic axes [deg].
    pleochroic : bool
        Whether its colour depends on the direction.
    """

    name: str
    n_g: float
    n_f: float
    n_d: float
    n_c: float
    n_b: float
    abbe_number: float | None
    dispersion_b_g: float
    density: float | None
    index_from: str
    range_nm: tuple[float, float]
    continued_nm: tuple[tuple[float, float], ...]
    absorbs: bool
    source: str
    notes: tuple[str, ...]
    optic_class: str
    n_o: float | None
    n_e: float | None
    n_alpha: float | None
    n_beta: float | None
    n_gamma: float | None
    birefringence: float
    optic_sign: str | None
    two_v_deg: float | None
    pleochroic: bool

    def to_dict(self) -> dict[str, Any]:
        """Return the sheet as JSON takes it: fields by name, in order, n_G for `n_g`, tuples as lists."""
        return {_NAMES.get(key, key): _lists(value) for key, value in asdict(self).items()}


def material_sheet(material: Material | str | os.PathLike[str] | float | None) -> MaterialSheet:
    """Return the sheet of a material; its notes say what `load_material` warns of.

    Parameters
    ----------
    material : Material, str, path-like, float or None
        A material, or what `load_material` takes: a name, a file, an index, or None for diamond.

    Raises
    ------
    InputError
        As `load_material`.
    """
    made = material if isinstance(material, Material) else load_material(material, warn=False)
    lines = (FRAUNHOFER_G_NM, FRAUNHOFER_F_NM, SODIUM_NM, FRAUNHOFER_C_NM, FRAUNHOFER_B_NM)
    g, f, d, c, b = (float(n) for n in made.index(lines))
    return MaterialSheet(
        name=made.name,
        n_g=g,
        n_f=f,
        n_d=d,
        n_c=c,
        n_b=b,
        abbe_number=made.abbe_number,
        dispersion_b_g=made.dispersion_b_g,
        density=made.density,
        index_from=made.dispersion.formula if isinstance(made.dispersion, Formula) else "table",
        range_nm=made.range_nm,
        continued_nm=made.continued_nm,
        absorbs=made.absorption is not None,
        source=made.source,
        notes=made.notes,
        **_of_crystal(made.crystal),
    )


def _of_crystal(crystal: Crystal | None) -> dict[str, Any]:
    """Return what a sheet says of a crystal, or of none."""
    facts: dict[str, Any] = dict.fromkeys(("n_o", "n_e", "n_alpha", "n_beta", "n_gamma"))
    number = 1 if crystal is None else len(crystal.dispersions)
    facts |= {
        "optic_class": {1: "isotropic", 2: "uniaxial", 3: "biaxial"}[number],
        "birefringence": 0.0,
        "optic_sign": None,
        "two_v_deg": None,
        "pleochroic": False,
    }
    if crystal is None:
        return facts
    names = {1: (), 2: ("n_o", "n_e"), 3: ("n_alpha", "n_beta", "n_gamma")}[number]
    return facts | {
        **dict(zip(names, crystal.principal_indices(SODIUM_NM).tolist(), strict=False)),
        "birefringence": crystal.birefringence,
        "optic_sign": crystal.optic_sign or None,
        "two_v_deg": crystal.optic_axial_angle_deg,
        "pleochroic": is_pleochroic(crystal),
    }


def _lists(value: Any) -> Any:
    return [_lists(part) for part in value] if isinstance(value, tuple) else value

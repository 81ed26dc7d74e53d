"""The materials that gemrender knows: colourless crystals, and body colours of some."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

from gemrender.errors import InputError
from gemrender.optics import absorption, pleochroism
from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import Formula
from gemrender.optics.fresnel import GUBELIN_INDEX
from gemrender.optics.material import INDEX_RANGE, SODIUM_NM, Material, constant_index
from gemrender.optics.minerals import birefringent_crystals
from gemrender.optics.principal import isotropic_absorption
from gemrender.optics.tabulated import Table
from gemrender.reading import did_you_mean

__all__ = ["INDEX_RANGE", "find_material", "material_names", "named_index", "normal_name"]

_CHOSEN = "bands of the literature, strength chosen for about 1 carat"
_COLOUR, _GRADE = f"body colour: {_CHOSEN}", f"colour grade: {_CHOSEN}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Colour:
    """A body colour: the crystal that has it, and how it absorbs, in all directions alike or in each."""

    crystal: str
    absorption: Callable[[], Table | tuple[Table, ...] | None]
    source: str
    note: str = _COLOUR


def _crystal(
    name: str, formula: str, coefficients: tuple[object, ...], range_nm: tuple[float, float],
    density: float, source: str, note: str = "",
) -> Material:  # fmt: skip
    """Make a colourless material."""
    return Material(
        name=name,
        dispersion=Formula(formula=formula, coefficients=coefficients),
        range_nm=range_nm,
        source=source,
        note=note,
        density=density,
    )


@cache
def _crystals() -> dict[str, Material]:
    """Return the materials without their colours, by name; some names mean the coloured one.

    Coefficients as published, for wavelengths in micrometres; they and the ranges are those of
    refractiveindex.info (CC0). Densities: O'Donoghue, Gems, 6th ed. (2006), rounded.
    """
    made = (
        _crystal(
            "diamond", "sellmeier", ((4.3356, 0.1060), (0.3306, 0.1750)), (226, 760), 3.52,
            "F. Peter, Z. Phys. 15, 358 (1923)",
        ),
        _crystal(
            "cubic zirconia", "sellmeier",
            ((1.347091, 0.062543), (2.117788, 0.166739), (9.452943, 24.320570)), (361, 5135), 5.9,
            "Wood & Nassau, Appl. Opt. 21, 2978 (1982), 12 % Y2O3",
        ),
        _crystal(
            "garnet", "cauchy", (1.73709, 0.007957), (430, 687), 3.84,
            "GIA, Gem Reference Guide (1988): index 1.760 and dispersion 0.026 of rhodolite",
            "pyrope-almandine, without its colour, which is rhodolite",
        ),
        _crystal(
            "spinel", "sellmeier", ((1.8938, 0.09942), (3.0755, 15.826)), (350, 5500), 3.60,
            "Tropf & Thomas, in Palik, Handbook of Optical Constants of Solids II (1991)",
        ),
        _crystal(
            "strontium titanate", "sellmeier",
            ((3.042143, 0.1475902), (1.170065, 0.2953086), (30.83326, 33.18606)), (430, 3800), 5.13,
            "W. L. Bond, J. Appl. Phys. 36, 1674 (1965); Dodge (1986)",
        ),
        _crystal(
            "yag", "sellmeier-2", ((2.28200, 0.01185), (3.27644, 282.734)), (400, 5000), 4.55,
            "Zelmon, Small & Page, Appl. Opt. 37, 4933 (1998)",
        ),
    )  # fmt: skip
    return {material.name: material for material in (*made, *birefringent_crystals())}


_PLEOCHROIC = f"pleochroic; {_COLOUR}"
_COLOURS: dict[str, _Colour] = {
    "ruby": _Colour(
        crystal="sapphire",
        absorption=pleochroism.ruby,
        source="McClure (1962), Cronemeyer (1966)",
        note=f"{_PLEOCHROIC}; no fluorescence",
    ),
    "blue sapphire": _Colour(
        crystal="sapphire",
        absorption=pleochroism.blue_sapphire,
        source="Ferguson & Fielding (1971)",
        note=_PLEOCHROIC,
    ),
    "amethyst": _Colour(
        crystal="quartz",
        absorption=pleochroism.amethyst,
        source="Lehmann & Moore (1966), Hassan & Cohen (1974)",
        note=f"{_PLEOCHROIC}; difference of the rays chosen",
    ),
    "citrine": _Colour(
        crystal="quartz",
        absorption=pleochroism.citrine,
        source="Lehmann & Bambauer (1973)",
        note=f"{_PLEOCHROIC}; difference of the rays chosen",
    ),
    "green tourmaline": _Colour(
        crystal="tourmaline",
        absorption=pleochroism.green_tourmaline,
        source="Mattson & Rossman (1987, 1988)",
        note=_PLEOCHROIC,
    ),
    "blue zircon": _Colour(
        crystal="zircon",
        absorption=pleochroism.blue_zircon,
        source="Renfro (2016), Zeug et al. (2018)",
        note=f"heated; {_PLEOCHROIC}",
    ),
    "emerald": _Colour(
        crystal="beryl",
        absorption=pleochroism.emerald,
        source="Wood & Nassau (1968), Burns (1993)",
        note=f"{_PLEOCHROIC}; no fluorescence",
    ),
    "aquamarine": _Colour(
        crystal="beryl",
        absorption=pleochroism.aquamarine,
        source="Wood & Nassau (1968), Goldman et al. (1978)",
        note=_PLEOCHROIC,
    ),
    "blue topaz": _Colour(
        crystal="topaz",
        absorption=pleochroism.blue_topaz,
        source="Nassau (1985)",
        note=f"irradiated; {_PLEOCHROIC}; difference of the directions chosen",
    ),
    "peridot": _Colour(
        crystal="peridot",
        absorption=pleochroism.peridot,
        source="Farrell & Newnham (1965), Burns (1993)",
        note=_PLEOCHROIC,
    ),
    "tanzanite": _Colour(
        crystal="tanzanite",
        absorption=pleochroism.tanzanite,
        source="Faye & Nickel (1971)",
        note=f"heated; {_PLEOCHROIC}; shares of the directions chosen",
    ),
    "unheated tanzanite": _Colour(
        crystal="tanzanite",
        absorption=pleochroism.unheated_tanzanite,
        source="Faye & Nickel (1971)",
        note=f"{_PLEOCHROIC}; shares of the directions chosen",
    ),
    "alexandrite": _Colour(
        crystal="chrysoberyl",
        absorption=pleochroism.alexandrite,
        source="Farrell & Newnham (1965)",
        note=f"{_PLEOCHROIC}; bands of the directions chosen for their colours; no fluorescence",
    ),
    "rhodolite": _Colour(
        crystal="garnet", absorption=absorption.rhodolite, source="GIA (1988), Manning (1967)"
    ),
    "fancy yellow diamond": _Colour(
        crystal="diamond", absorption=absorption.fancy_yellow, source="Dyer et al. (1965), Collins (1982)"
    ),
    **{
        f"diamond {grade}": _Colour(
            crystal="diamond",
            absorption=partial(absorption.cape_diamond, grade),
            source="Walker (1979), Collins (1982)",
            note=_GRADE if grade != "d" else "colour grade: without absorption",
        )
        for grade in absorption.DIAMOND_GRADES
    },
}


def material_names() -> list[str]:
    """Return the names of the materials that come with gemrender, in alphabetical order."""
    return sorted({*_crystals(), *_COLOURS})


def normal_name(name: str) -> str:
    """Return a name as the materials are called: case, hyphens, underscores and more spaces do not count."""
    return " ".join(name.lower().replace("-", " ").replace("_", " ").split())


@cache
def _material(name: str) -> Material:
    if name not in _COLOURS:
        return _crystals()[name]
    colour = _COLOURS[name]
    crystal, made = _crystals()[colour.crystal], colour.absorption()
    if isinstance(made, tuple):
        assert crystal.crystal is not None
        split = Crystal(dispersions=crystal.crystal.dispersions, absorptions=made)
        crystal = replace(crystal, crystal=split, absorption=isotropic_absorption(split))
    else:
        crystal = replace(crystal, absorption=made)
    return replace(
        crystal,
        name=name,
        source=f"{crystal.source}; colour: {colour.source}",
        note="; ".join(part for part in (crystal.note, colour.note) if part),
    )


def find_material(name: str, hint: str = "") -> Material:
    """Return a material by its name.

    Parameters
    ----------
    name : str
        One of `material_names`; case, hyphens and underscores do not count.
    hint : str
        What an error adds to the names that are allowed.

    Raises
    ------
    InputError
        Unknown name.
    """
    wanted = normal_name(name)
    if wanted not in _COLOURS and wanted not in _crystals():
        raise InputError(f"must be {_listed(wanted, hint)}", key="name", value=name)
    return _material(wanted)


def named_index(material: str | float | None) -> float:
    """Return the refractive index of a material at 589.3 nm, which scores are computed at.

    Diamond, of whatever colour, has the paper's 2.4173 (Peter's formula gives 2.41726).

    Parameters
    ----------
    material : str, float or None
        One of `material_names` (case and hyphens do not count), an index, or None for diamond.

    Raises
    ------
    InputError
        Unknown name, or an index outside `INDEX_RANGE`.
    """
    if material is None:
        return GUBELIN_INDEX
    if not isinstance(material, str):
        return constant_index(material)
    found = find_material(material)
    crystal = _COLOURS[found.name].crystal if found.name in _COLOURS else found.name
    return GUBELIN_INDEX if crystal == "diamond" else float(found.index(SODIUM_NM))


def _listed(word: str, hint: str) -> str:
    """List the names, the diamond grades as one, with a guess at what was meant."""
    grades = [f"diamond {grade}" for grade in absorption.DIAMOND_GRADES]
    names = [name for name in material_names() if name not in grades]
    shown = sorted([*names, f"{grades[0]} to {grades[-1]}"])
    return f"one of {', '.join(shown)}{hint}{did_you_mean(word, names)}"

"""What a stone is, in figures: its facets by tier, its proportions, symmetry, volume and weight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.cuts.stones import taken_lines
from gemrender.errors import InputError
from gemrender.optics import load_material, refractive_index
from gemrender.optics.material import DIAMETER_RANGE_MM
from gemrender.report.displays.projection import corners_of
from gemrender.report.formats import Column, TextTable
from gemrender.report.measured import Dimension, measured_dimensions
from gemrender.report.tiers import TierFigures, tiers_of_stone
from gemrender.stone import Orientation, Stone

__all__ = [
    "DEFAULT_SIZE_MM",
    "Inspection",
    "check_size",
    "figures_of_stone",
    "inspect_stone",
    "inspection_records",
    "inspection_tables",
    "inspection_values",
]

#: Longer side of the outline that stones are weighed at where none is asked for or stated [mm].
DEFAULT_SIZE_MM = 6.5
#: Cubic millimetres times g/cm3 are milligrams; so many make a carat.
_CARAT_MG = 200.0
#: So many neighbouring teeth of an index wheel are told by the first and the last.
_MANY = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """What a stone is, in figures.

    Attributes
    ----------
    name : str
        The stone's name.
    cut : str
        How it was given: "round brilliant", the family's name, "design", "measured round brilliant", "planes"
        or "mesh".
    facets, corners : int
        Number of facets, and of points where three and more of them meet.
    dimensions : dict of str to Dimension
        As of `measured_dimensions` [% of the width].
    symmetry : str
        In words.
    fold : int
        Turns by 360 / fold degrees leave it as it is.
    mirrors_deg : tuple of float
        Azimuths of its upright mirror planes [deg].
    rear_rule : str
        What tells rear light by default: "position" or "facet".
    material : str
        What it is made of, as the stone says; "diamond" where it says nothing.
    index : float
        Its refractive index.
    density : float or None
        Density of the material, where it is known [g/cm3].
    size_mm : float
        Longer side of the outline, or the diameter of a round one [mm].
    length_mm, width_mm, depth_mm, volume_mm3 : float
        At that size [mm], [mm^3].
    carat : float or None
        Weight at that size, where the density is known [carat of 0.2 g].
    volume : float
        Volume in the stone's own unit, half the longer side of the outline, cubed.
    tiers : tuple of TierFigures
        Crown, girdle, pavilion; in the order of the facets.
    notes, assumed : tuple of str
        What was mended when it was read, and what was assumed.
    crystal : str or None
        How the crystal of a birefringent stone lies in it, in words.
    """

    name: str
    cut: str
    facets: int
    corners: int
    dimensions: dict[str, Dimension]
    symmetry: str
    fold: int
    mirrors_deg: tuple[float, ...]
    rear_rule: str
    material: str
    index: float
    density: float | None
    size_mm: float
    length_mm: float
    width_mm: float
    depth_mm: float
    volume_mm3: float
    carat: float | None
    volume: float
    tiers: tuple[TierFigures, ...]
    notes: tuple[str, ...]
    assumed: tuple[str, ...]
    crystal: str | None = None


def check_size(size_mm: float) -> float:
    """Return a size, if a stone can have it.

    Raises
    ------
    InputError
        It cannot.
    """
    low, high = DIAMETER_RANGE_MM
    if not low <= size_mm <= high:  # false for NaN too
        raise InputError(f"must be from {low:g} to {high:g} [mm]", key="size", value=size_mm)
    return size_mm


def inspect_stone(stone: Stone, *, size_mm: float | None = None) -> Inspection:
    """Return what a stone is, in figures.

    Parameters
    ----------
    stone : Stone
        The stone.
    size_mm : float, optional
        Longer side of its outline, or its diameter if it is round [mm]; by default the stone's own size, of
        one without `DEFAULT_SIZE_MM`.

    Raises
    ------
    InputError
        A size that no stone has, or a material that is not known.
    """
    if size_mm is None:
        size_mm = DEFAULT_SIZE_MM if stone.size_mm is None else stone.size_mm
    millimetre = check_size(size_mm) / 2.0
    name = "diamond" if stone.material is None else stone.material
    try:
        material, index = load_material(name), refractive_index(stone.material)
    except InputError as error:
        raise error.at(stone.source or stone.name, "material") from error
    known = measured_dimensions(stone)
    width = millimetre * 2.0 / known["length_to_width"].value
    symmetry = stone.symmetry
    volume = stone.solid.volume
    density = material.density
    return Inspection(
        name=stone.name,
        cut=_cut_of(stone),
        facets=len(stone.facets),
        corners=len(corners_of(stone)),
        dimensions=known,
        symmetry=str(symmetry) if stone.is_convex else "not looked for: it is not convex",
        fold=symmetry.fold,
        mirrors_deg=tuple(np.degrees(symmetry.mirrors).tolist()),
        rear_rule=stone.rear_rule,
        material=f"index {name:g}" if isinstance(name, float | int) else name,
        index=index,
        density=density,
        size_mm=size_mm,
        length_mm=2.0 * millimetre,
        width_mm=width,
        depth_mm=width * known["total_depth"].value / 100.0,
        volume_mm3=volume * millimetre**3,
        carat=None if density is None else volume * millimetre**3 * density / _CARAT_MG,
        volume=volume,
        tiers=tiers_of_stone(stone),
        notes=stone.notes,
        assumed=stone.assumed,
        crystal=None if material.crystal is None else _crystal_of(stone, len(material.crystal.dispersions)),
    )


def _crystal_of(stone: Stone, directions: int) -> str:
    """Say how a crystal lies in a stone."""
    told = stone.crystal or Orientation()
    if told.key == "angles":
        return f"Euler's angles {', '.join(f'{angle:g}' for angle in told.value)} degrees"
    axis = "axis gamma" if directions == 3 else "optic axis"
    if told.value == "table":
        return f"{axis} along the stone's axis"
    along = stone.crystal_axes[2] if not told.key else told.value
    return f"{axis} along ({', '.join(f'{part:.4g}' for part in along)})"


def _cut_of(stone: Stone) -> str:
    if stone.labelled_vertices is not None:
        return "round brilliant" if stone.proportions is not None else "measured round brilliant"
    if isinstance(stone.cut, Family):
        return stone.cut.family()
    if isinstance(stone.cut, Design):
        return "design"
    return "planes" if stone.is_convex else "mesh"


# ---- For people, and for machines ----------------------------------------------------------------------


def inspection_tables(inspections: Sequence[Inspection]) -> list[TextTable]:
    """Return two tables a stone: its figures, and its facets by tier."""
    tables = []
    for found in inspections:
        figures = TextTable([Column(found.name, is_text=True), Column("", is_text=True, wraps=True)])
        figures.rows += figures_of_stone(found)
        for words in (*found.notes, *(f"taken: {words}" for words in taken_lines(found.assumed))):
            figures.note(f"{found.name}: {words}.", "yellow")
        tables += [figures, _tier_table(found)]
    tables[-1].note(
        "Proportions in per cent of the width; the crown above the girdle's highest point, the pavilion "
        "below its lowest."
    )
    tables[-1].note("Angle to the girdle plane in degrees; area in per cent of the surface.")
    return tables


def figures_of_stone(found: Inspection) -> list[list[str]]:
    """Return what a stone is in words: a name and a text a row."""
    d = found.dimensions
    girdle = d["girdle_thickness"]
    size = f"{found.length_mm:.2f} x {found.width_mm:.2f} x {found.depth_mm:.2f} mm"
    weight = f"unknown: no density of {found.material}" if found.carat is None else f"{found.carat:.3f} ct"
    heights = [
        [d[key].name.capitalize(), f"{d[key].value:.2f} %"]
        for key in ("table", "crown_height", "pavilion_depth", "total_depth")
        if key in d
    ]
    spread = girdle.spread.replace("–", "to")
    thickness = f"{girdle.value:.2f} %" + (f" ({spread} %)" if spread else "")
    heights.insert(-2, ["Girdle thickness", thickness])
    material = found.material
    if not material.startswith("index "):
        material += f", index {found.index:g}"
    return [
        ["Cut", found.cut],
        ["Facets, corners", f"{found.facets}, {found.corners}"],
        ["Length to width", f"{d['length_to_width'].value:.3f}"],
        *heights,
        ["Symmetry", found.symmetry],
        ["Rear light", f"by {found.rear_rule}"],
        ["Material", material],
        *([["Crystal", found.crystal]] if found.crystal else []),
        ["Size", size],
        ["Volume", f"{found.volume_mm3:.2f} mm3"],
        ["Weight", weight],
    ]  # fmt: skip


def _tier_table(found: Inspection) -> TextTable:
    columns = [
        Column("Tier", is_text=True),
        Column("Side", is_text=True),
        Column("Facets"),
        Column("Angle"),
        Column("Area"),
    ]
    has_indices = any(tier.indices for tier in found.tiers)
    if has_indices:
        columns.append(Column("Index", is_text=True, wraps=True))
    table = TextTable(columns)
    for tier in found.tiers:
        row = [tier.name, tier.side, f"{tier.number}", _angle(tier), f"{tier.area:.2f}"]
        table.rows.append([*row, _index_text(tier)] if has_indices else row)
    return table


def _angle(tier: TierFigures) -> str:
    if tier.angle_deg is None:
        return "90.00"  # a girdle all round
    least, most = f"{tier.least_angle_deg:.2f}", f"{tier.most_angle_deg:.2f}"
    return least if least == most else f"{least}-{most}"


def _index_text(tier: TierFigures) -> str:
    indices = sorted(tier.indices or ())
    if len(indices) >= _MANY and indices == [indices[0] + k for k in range(len(indices))]:
        return f"{indices[0]:.6g} to {indices[-1]:.6g}"  # a round girdle in level facets
    return "-".join(f"{index:.6g}" for index in tier.indices or ())


def inspection_values(found: Inspection) -> dict[str, Any]:
    """Return an inspection as JSON has it: lengths in per cent of the width where they have no unit."""
    values = {key: getattr(found, key) for key in Inspection.__dataclass_fields__ if key not in
              ("dimensions", "tiers", "notes", "assumed")}  # fmt: skip
    d = dict(found.dimensions)
    girdle = d.pop("girdle_thickness")
    lengths = {key: dimension.value for key, dimension in d.items()}
    lengths["girdle_thickness"] = girdle.value
    lengths |= {"girdle_thinnest": girdle.least, "girdle_thickest": girdle.most}
    return {
        **values,
        "proportions": lengths,
        "tiers": [asdict(tier) for tier in found.tiers],
        "notes": list(found.notes),
        "assumed": list(found.assumed),
    }


def inspection_records(found: Inspection) -> list[dict[str, Any]]:
    """Return an inspection as flat records, one a tier; what the stone has stands in each."""
    values = inspection_values(found)
    tiers = values.pop("tiers")
    proportions = values.pop("proportions")
    first = {"name": values.pop("name")}
    return [{**first, "tier": tier.pop("name"), **tier, **proportions, **values} for tier in tiers]

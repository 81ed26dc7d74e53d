"""What there is, as tables and records: stones, set-ups, materials, measures; and what `doctor` found."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gemrender.cuts import bundled_stones, load_stone
from gemrender.cuts.families.family import Family
from gemrender.cuts.shape_words import ROUND, read_shape
from gemrender.measures import measures
from gemrender.optics import material_names
from gemrender.optics.material_sheet import material_sheet
from gemrender.render.diagnosis import Check
from gemrender.report.formats import Column, TextTable
from gemrender.scene.setup import bundled_setups, load_setup

__all__ = [
    "check_records",
    "check_table",
    "material_records",
    "material_table",
    "measure_records",
    "measure_table",
    "setup_records",
    "setup_table",
    "sheet_table",
    "stone_records",
    "stone_table",
]

#: Proportions of a bundled stone's record, in their order; of round brilliants the first six are the paper's.
_PROPORTIONS = (
    "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness",
    "lower_half", "crown_angle", "pavilion_angle",
)  # fmt: skip
#: Columns of the bundled stones: heading, key of their record, and when a narrow terminal does without.
_COLUMNS = (
    ("L/W", "length_to_width", 1),
    ("Table", "table", 0),
    ("Crown", "crown_angle", 0),
    ("Pavilion", "pavilion_angle", 0),
    ("Star", "star", 2),
    ("Lower half", "lower_half", 3),
    ("Girdle", "girdle_thickness", 4),
    ("Crown height", "crown_height", 5),
    ("Pavilion depth", "pavilion_depth", 6),
)


def stone_records(shape: str | None = None) -> list[dict[str, Any]]:
    """Return the bundled stones, a record each: names, then proportions [%] and angles [deg].

    Parameters
    ----------
    shape : str, optional
        Only those of a family, in its own or in a laboratory's words.

    Raises
    ------
    InputError
        No such shape.
    """
    family = None if shape is None else read_shape(shape).family
    records = []
    for name in bundled_stones():
        stone = load_stone(name)
        cut, proportions = stone.cut, stone.proportions
        own: dict[str, Any] = {}
        if proportions is not None:
            own = asdict(proportions)
            own["lower_half"] = 100.0 - proportions.lower_girdle_contact
            own["crown_angle"] = proportions.crown_angle_deg
            own["pavilion_angle"] = proportions.pavilion_angle_deg
        elif isinstance(cut, Family):
            own = cut.values() | cut.alternatives()
        of = cut.family() if isinstance(cut, Family) else ROUND
        if family is not None and of != family:
            continue
        record: dict[str, Any] = {"name": name, "title": stone.name}
        record |= {key: own.get(key) for key in _PROPORTIONS}
        record |= {"material": stone.material or "diamond", "family": of}
        records.append(record | {key: own.get(key) for key in ("length_to_width", "culet")})
    return records


def stone_table(shape: str | None = None) -> TextTable:
    """Return the bundled stones, or those of a family, with their proportions as a report has them."""
    table = TextTable(
        [
            Column("Name", is_text=True),
            Column("Stone", is_text=True),
            *(Column(heading, rank) for heading, _, rank in _COLUMNS),
        ]
    )
    for record in stone_records(shape):
        numbers = (record[key] for _, key, _ in _COLUMNS)
        shown = ("–" if number is None else f"{number:.4g}" for number in numbers)
        table.rows.append([record["name"], record["title"], *shown])
    table.note(
        "L/W: length over width; angles in degrees; lower half: 100 less the lower-girdle contact; the rest "
        "in per cent of the width."
    )
    table.note("gemrender stones --show NAME prints the file of one, --family NAME lists those of a family.")
    return table


def setup_records() -> list[dict[str, Any]]:
    """Return the bundled set-ups, a record each."""
    records = []
    for name in bundled_setups():
        setup = load_setup(name)
        records.append({"name": name, "title": setup.name, "about": setup.about})
    return records


def setup_table() -> TextTable:
    """Return the bundled set-ups, and what they are."""
    table = TextTable([Column("Name", is_text=True), Column("Set-up", is_text=True, wraps=True)])
    for record in setup_records():
        table.rows.append([record["name"], f"{record['title']}: {record['about']}"])
    table.note("gemrender setups --show NAME prints the file of one.")
    return table


def material_records(names: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return materials, a record each, as `MaterialSheet.to_dict` has it; by default all that are bundled.

    Parameters
    ----------
    names : sequence of str, optional
        Names or files.
    """
    sheets = []
    for name in names or material_names():
        sheet = material_sheet(name).to_dict()
        sheets.append(sheet if names else {**sheet, "name": name})
    return sheets


def material_table() -> TextTable:
    """Return the materials that come with gemrender; those that differ in colour alone share a row."""
    table = TextTable(
        [
            Column("Material", is_text=True),
            Column("n", is_text=True),
            Column("Biref.", 1),
            *map(Column, ("B-G", "g/cm3")),
            Column("Source and notes", is_text=True, wraps=True),
        ]
    )

    def alike(record: dict[str, Any]) -> list[Any]:
        return [record[key] for key in ("n_D", "n_e", "dispersion_b_g", "density", "source", "notes")]

    for _, group in itertools.groupby(material_records(), key=alike):
        records = list(group)
        first, last = records[0], records[-1]
        called = first["name"] if len(records) == 1 else f"{first['name']} to {last['name']}"
        words = "; ".join(part for part in (first["source"], *first["notes"]) if part)
        numbers = (
            ", ".join(f"{index:.4f}" for index in _principal(first)),
            "–" if first["optic_sign"] is None else f"{first['birefringence']:.4f} {first['optic_sign']}",
            f"{first['dispersion_b_g']:.4f}",
            f"{first['density']:.2f}",
        )
        table.rows.append([called, *numbers, words])
    table.note("n at 589.3 nm: two of uniaxial crystals, ordinary and extraordinary, three of biaxial ones.")
    table.note("Biref.: birefringence, the greatest n less the least, and the optic sign.")
    table.note("B-G: dispersion, the index at 430.8 nm less that at 686.7 nm.")
    table.note("gemrender materials NAME|FILE tells one in full; --show NAME prints a file to start from.")
    return table


def _principal(record: dict[str, Any]) -> list[float]:
    """Return the principal indices of a material's record; of an isotropic one its index."""
    split = [record[key] for key in ("n_o", "n_e", "n_alpha", "n_beta", "n_gamma")]
    return [index for index in split if index is not None] or [record["n_D"]]


#: Columns of sheets: heading, key of their record, and how it is shown.
_SHEET = (
    ("n G", "n_G", ".5f"),
    ("n F", "n_F", ".5f"),
    ("n D", "n_D", ".5f"),
    ("n C", "n_C", ".5f"),
    ("n B", "n_B", ".5f"),
    ("Abbe", "abbe_number", ".2f"),
    ("B-G", "dispersion_b_g", ".4f"),
    ("g/cm3", "density", ".2f"),
)


def sheet_table(names: Sequence[str]) -> TextTable:
    """Return materials in full: indices at Fraunhofer's lines, where they come from, what is continued.

    Parameters
    ----------
    names : sequence of str
        Names or files.
    """
    table = TextTable([Column("Material", is_text=True), *(Column(heading) for heading, _, _ in _SHEET)])
    for record in material_records(names):
        shown = ("–" if record[key] is None else format(record[key], how) for _, key, how in _SHEET)
        table.rows.append([record["name"], *shown])
        low, high = record["range_nm"]
        index = f"{record['index_from']}, {low:g} to {high:g} nm"
        table.note(f"{record['name']}: {record['source']} ({index}).", style="")
        if record["optic_sign"] is not None:
            table.note(f"{record['name']}: {_crystal_words(record)}.", style="")
        for words in record["notes"]:
            table.note(f"{record['name']}: {words}.", style="yellow" if "continued" in words else "")
    table.note("n at G 430.8, F 486.1, D 589.3, C 656.3 and B 686.7 nm; Abbe: (n D - 1)/(n F - n C).")
    return table


def _crystal_words(record: dict[str, Any]) -> str:
    """Tell of a birefringent material its class and sign, and the indices of its principal directions."""
    indices = ", ".join(
        f"{key.replace('_', ' ')} {record[key]:.5f}"
        for key in ("n_o", "n_e", "n_alpha", "n_beta", "n_gamma")
        if record[key] is not None
    )
    angle = "" if record["two_v_deg"] is None else f", 2V {record['two_v_deg']:.1f} degrees"
    colour = ", pleochroic" if record["pleochroic"] else ""
    return (
        f"{record['optic_class']} {record['optic_sign']}, {indices}, birefringence "
        f"{record['birefringence']:.4f}{angle}{colour}"
    )


def measure_records() -> list[dict[str, Any]]:
    """Return the measures, a record each; the light is all that is followed, or the principal light."""
    return [
        {
            "name": measure.name,
            "version": measure.version,
            "definition": measure.definition,
            "source": measure.source,
            "values": [*measure.keys, *measure.detail_keys],
            "light": measure.follow,
        }
        for measure in measures()
    ]


def measure_table() -> TextTable:
    """Return the measures with their definition and source."""
    table = TextTable(
        [
            Column("Measure", is_text=True),
            Column("Version"),
            Column("Definition", is_text=True, wraps=True),
            Column("Source", is_text=True, wraps=True),
        ],
        ruled=True,
    )
    for record in measure_records():
        table.rows.append([record["name"], str(record["version"]), record["definition"], record["source"]])
    table.note("Values are means over the view in per cent, unless the definition says otherwise.")
    table.note("w: light inside; R: reflectance at a crossing, (Rs + Rp)/2 by Fresnel; T = 1 - R.")
    return table


def check_records(checks: Sequence[Check]) -> list[dict[str, Any]]:
    """Return the findings of `gemrender doctor`, a record each."""
    return [{"check": c.name, "ok": c.ok, "found": c.detail, "cure": c.cure} for c in checks]


def check_table(checks: Sequence[Check]) -> TextTable:
    """Return the findings of `gemrender doctor` as a table."""
    names = ("Check", "OK", "Found", "Cure")
    table = TextTable([Column(name, is_text=True) for name in names])
    marks = {True: "yes", False: "no", None: "–"}
    table.rows += [[c.name, marks[c.ok], c.detail, c.cure or ""] for c in checks]
    return table

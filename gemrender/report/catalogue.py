"""What there is, as tables and records: bundled stones, set-ups, materials; and what `doctor` found."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gemrender.optics import load_material, material_names, refractive_index
from gemrender.render.diagnosis import Check
from gemrender.report.formats import Column, TextTable
from gemrender.scene.setup import bundled_setups, load_setup
from gemrender.stone import bundled_stones, load_stone

__all__ = [
    "check_records",
    "check_table",
    "material_records",
    "material_table",
    "setup_records",
    "setup_table",
    "stone_records",
    "stone_table",
]

#: Columns of the bundled stones: heading, key of their record, and when a narrow terminal does without.
_PROPORTIONS = (
    ("Table", "table", 0),
    ("Crown", "crown_angle", 0),
    ("Pavilion", "pavilion_angle", 0),
    ("Star", "star", 1),
    ("Lower half", "lower_half", 2),
    ("Girdle", "girdle_thickness", 3),
    ("Crown height", "crown_height", 4),
    ("Pavilion depth", "pavilion_depth", 5),
)


def stone_records() -> list[dict[str, Any]]:
    """Return the bundled stones, a record each: names, then proportions [%] and angles [deg]."""
    records = []
    for name in bundled_stones():
        stone = load_stone(name)
        record: dict[str, Any] = {"name": name, "title": stone.name}
        if (proportions := stone.proportions) is not None:
            record |= asdict(proportions)
            record["lower_half"] = 100.0 - proportions.lower_girdle_contact
            record["crown_angle"] = proportions.crown_angle_deg
            record["pavilion_angle"] = proportions.pavilion_angle_deg
        records.append(record | {"material": stone.material or "diamond"})
    return records


def stone_table() -> TextTable:
    """Return the bundled stones with their proportions as a report of a laboratory has them."""
    table = TextTable(
        [
            Column("Name", is_text=True),
            Column("Stone", is_text=True),
            *(Column(heading, rank) for heading, _, rank in _PROPORTIONS),
        ]
    )
    for record in stone_records():
        table.rows.append(
            [
                record["name"],
                record["title"],
                *(f"{record[key]:.4g}" if key in record else "–" for _, key, _ in _PROPORTIONS),
            ]
        )
    table.note("Angles in degrees; lower half: 100 less the lower-girdle contact; the rest in per cent.")
    table.note("gemrender stones --show NAME prints the file of one.")
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


def material_records() -> list[dict[str, Any]]:
    """Return the materials, a record each: index at 589.3 nm, dispersion, density [g/cm3], sources."""
    records = []
    for name in material_names():
        material = load_material(name)
        records.append(
            {
                "name": name,
                "n_D": refractive_index(name),
                "dispersion_b_g": material.dispersion_b_g,
                "density": material.density,
                "source": material.source,
                "note": material.note,
            }
        )
    return records


def material_table() -> TextTable:
    """Return the materials; those that differ in nothing but their colour share a row."""
    table = TextTable(
        [
            Column("Material", is_text=True),
            *map(Column, ("n", "B-G", "g/cm3")),
            Column("Source and notes", is_text=True, wraps=True),
        ]
    )

    def alike(record: dict[str, Any]) -> list[Any]:
        return [record[key] for key in ("n_D", "dispersion_b_g", "density", "source", "note")]

    for _, group in itertools.groupby(material_records(), key=alike):
        records = list(group)
        first, last = records[0], records[-1]
        called = first["name"] if len(records) == 1 else f"{first['name']} to {last['name']}"
        words = "; ".join(part for part in (first["source"], first["note"]) if part)
        numbers = f"{first['n_D']:.4f}", f"{first['dispersion_b_g']:.4f}", f"{first['density']:.2f}"
        table.rows.append([called, *numbers, words])
    table.note("n at 589.3 nm; B-G: dispersion, the index at 430.8 nm less that at 686.7 nm.")
    table.note("gemrender materials NAME|FILE tells one in full, with --show as a file to start from.")
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

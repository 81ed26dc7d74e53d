"""Weigh the stones of published reports by their measurements, and print the published weights beside it.

    python scripts/weigh_reports.py [--csv FILE] [--allowed 3]

Each row of scripts/reports.csv is a diamond whose report, as a dealer or a newspaper has published it, states
measurements in millimetres and a weight, and, where the columns say so, table, crown height and girdle. All
else is the family's own: the bulge of a pavilion, the shoulders of an oval, most girdles (of rounds `ROUND`).
Then the weight is volume times density. Beside it stands the weight by the trade's formula (length x width x
depth x a factor), without its corrections.

A weight in hundredths of a carat is known to half a hundredth, 2 % of a stone of 0.25 ct, and girdles that
are not stated are worth 3 to 8 % (Esslinger, below): single stones differ by more than 3 %, the mean of a
shape may not. If that of a shape with at least five stones does, the exit status is 1.

Sources of the rows, in the order in which they have them, the first ones of a shape that are heavy enough:
    ringbuilder        github.com/danchen4/ringbuilder, data/diamonds.csv: of 1.5 ct and more
    excelUpload        github.com/VanshKothari05/excelUpload, rapnet.csv
    nivoda-shop        a shop's example stones by Nivoda, "0.70ct Emerald Natural Diamond", GIA
    debadas            huggingface.co/datasets/debadas/diamonds: of 0.85 ct and more
    update-diamond     update-diamond.blogspot.com, "Magnificent colored diamond sale", October 2010
Formulas: Octonus, 3D-Book of Diamonds, "Mounting diamonds weight determination" (3dbook.octonus.com);
Esslinger, "Stone weight estimation formula" (blog.esslinger.com, 2014).
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts.families import families
from gemrender.cuts.families.stated import from_values
from gemrender.cuts.measurements import read_size
from gemrender.optics import load_material

ROWS = Path(__file__).with_name("reports.csv")
#: By how much the mean of a shape may differ from the published weights [%], of so many stones.
ALLOWED, ENOUGH = 3.0, 5
#: Factors of the trade's formula [carat/mm^3], by length to width where they depend on it.
FACTORS = {
    "emerald": ((1.0, 1.5, 2.0, 2.5), (0.0080, 0.0092, 0.0100, 0.0106)),
    "marquise": ((1.5, 2.0, 2.5, 3.0), (0.00565, 0.0058, 0.00585, 0.00595)),
    "pear": ((1.25, 1.5, 1.66, 2.0), (0.00615, 0.0060, 0.0059, 0.00575)),
    "asscher": ((1.0,), (0.0080,)),
    "baguette": ((1.0,), (0.00915,)),
}
#: Factors that multiply the square of the mean diameter in place of length x width.
ROUNDED = {"round": 0.0061, "oval": 0.0062}
#: What a report of a round stone must say and these rows do not: the commonest.
ROUND = {"crown_angle": 34.5, "girdle": "medium to slightly thick"}
CARAT_MG = 200.0


def weigh(row: dict[str, str]) -> float:
    """Return the weight that the measurements of a row make [carat]."""
    size = read_size({key: float(row[key]) for key in ("length_mm", "width_mm", "depth_mm")})
    stated: dict[str, Any] = {key: float(row[key]) for key in ("table", "crown_height") if row[key]}
    if row["girdle"]:
        stated["girdle"] = row["girdle"]
    if row["shape"] == "round":
        stated = ROUND | stated
    kind = families()["round brilliant" if row["shape"] == "round" else row["shape"]]
    cut = from_values(kind, stated | size.proportions(kind, stated))[0]
    stone = size.sized(cut.stone())
    density = load_material("diamond").density
    assert density is not None
    assert stone.size_mm is not None
    return float(stone.solid.volume * (stone.size_mm / 2.0) ** 3 * density / CARAT_MG)


def by_formula(row: dict[str, str]) -> float:
    """Return the weight by the trade's formula, without corrections [carat]; nan where there is none."""
    length, width, depth = (float(row[key]) for key in ("length_mm", "width_mm", "depth_mm"))
    shape = row["shape"]
    if shape in ROUNDED:
        return ROUNDED[shape] * ((length + width) / 2.0) ** 2 * depth
    if shape not in FACTORS:
        return float("nan")
    return float(np.interp(length / width, *FACTORS[shape])) * length * width * depth


def read_rows(path: Path = ROWS) -> list[dict[str, str]]:
    """Return the rows of a table of reports."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def means(rows: list[dict[str, str]]) -> dict[str, tuple[int, float]]:
    """Return, by shape, how many stones there are and by how much their weights differ on average [%]."""
    found = defaultdict(list)
    for row in rows:
        found[row["shape"]].append(100.0 * (weigh(row) / float(row["carat"]) - 1.0))
    return {shape: (len(values), float(np.mean(values))) for shape, values in found.items()}


def main() -> int:
    """Print the weights; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--csv", type=Path, default=ROWS, metavar="FILE")
    parser.add_argument("--allowed", type=float, default=ALLOWED, metavar="PER CENT")
    options = parser.parse_args()
    rows = read_rows(options.csv)
    print(f"{'':10}{'measurements [mm]':>21}{'published':>11}{'ours':>8}{'':>8}{'formula':>10}")
    near = 0
    for row in rows:
        carat, ours, formula = float(row["carat"]), weigh(row), by_formula(row)
        size = f"{row['length_mm']} x {row['width_mm']} x {row['depth_mm']}"
        off, off_formula = (
            f"{100.0 * (one / carat - 1.0):+.1f} %" if one == one else "" for one in (ours, formula)
        )
        near += abs(ours / carat - 1.0) <= options.allowed / 100.0
        print(f"{row['shape']:10}{size:>21}{carat:>8.2f} ct{ours:>8.3f}{off:>8}{off_formula:>10}")
    print(f"{near} of {len(rows)} within {options.allowed:g} %")
    failed = False
    for shape, (count, mean) in means(rows).items():
        failed |= count >= ENOUGH and abs(mean) > options.allowed
        print(f"{shape:10} mean of {count}: {mean:+.1f} %")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())

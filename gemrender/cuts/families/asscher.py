"""The Asscher cut: a square emerald cut with wide corners, a high crown and a small table.

Laboratories call it a square emerald cut. Sources of the defaults: 8caratdiamondring.com, "8 Carat Asscher
cut diamond ring": table 60 to 65.5 %, crown height 12 to 15 %, length to width 1.00 to 1.03; samarajames.com,
"Asscher cut diamonds": depth 68 %. The corners leave 92 % of the square, as the face-up areas of diamdb.com,
"10 Carat Asscher" (134.5 of 146.2 mm2). No reports with weights were found; bulge and girdle are those of
emerald cuts. So it weighs 0.0084 carat/mm3 x length x width x depth, between the 0.0080 of the trade's
formula for plain stones (blog.esslinger.com, "Stone weight estimation formula") and the 0.0087 of diamdb.com.
"""

from __future__ import annotations

from dataclasses import dataclass

from gemrender.cuts.families import emerald
from gemrender.cuts.families.parameters import girdle_thickness, parameter

__all__ = ["FAMILY", "Parameters"]

FAMILY = "asscher"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(emerald.Parameters):
    """An Asscher cut, which laboratories call a square emerald cut; parameters as of the emerald cut."""

    length_to_width: float = parameter(1.0, 1.15, default=1.0, unit="")
    corner: float = parameter(12.0, 30.0, default=20.0, why="as the areas of stones on the market")
    table: float = parameter(40.0, 75.0, default=61.0)
    crown_height: float = parameter(8.0, 25.0, default=14.0)
    crown_bulge: float = parameter(0.2, 3.0, default=2.0, why="steps of 46, 36 and 22 deg")
    girdle_thickness: float = girdle_thickness(4.5)
    pavilion_depth: float = parameter(35.0, 65.0, default=49.0)
    pavilion_bulge: float = parameter(0.5, 8.0, default=6.0, why="steps of 53, 44 and 32 deg")

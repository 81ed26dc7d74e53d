"""Optics of gem materials: transmittance of their surface, index, dispersion and colour. Needs numpy only."""

from __future__ import annotations

from gemrender.optics.fresnel import FRESNEL_LAWS, critical_angle_deg, transmittance
from gemrender.optics.material import Material, carat_to_girdle_diameter_mm
from gemrender.optics.material_files import load_material, refractive_index
from gemrender.optics.material_sheet import MaterialSheet, material_sheet
from gemrender.optics.material_text import material_template
from gemrender.optics.materials import material_names

__all__ = [
    "FRESNEL_LAWS",
    "Material",
    "MaterialSheet",
    "carat_to_girdle_diameter_mm",
    "critical_angle_deg",
    "load_material",
    "material_names",
    "material_sheet",
    "material_template",
    "refractive_index",
    "transmittance",
]

"""Optics of the surface: transmittance and refractive indices. Needs numpy only."""

from __future__ import annotations

from gemrender.optics.fresnel import FRESNEL_LAWS, critical_angle_deg, transmittance
from gemrender.optics.materials import refractive_index

__all__ = ["FRESNEL_LAWS", "critical_angle_deg", "refractive_index", "transmittance"]

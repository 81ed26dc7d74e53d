"""How far a birefringent stone doubles what is seen through it: `doubling`, the angle of its two images."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure
from gemrender.optics.material_files import load_material, refractive_index

__all__ = ["Doubling"]


class Doubling(Measure):
    """Mean angle between the two images that each virtual facet shows."""

    name, version = "doubling", 1
    definition = (
        "angle [deg] between the exit directions of the two images that are seen through the same facets: of "
        "light that enters in the ordinary (biaxial: fast) mode and stays in it at every reflection, and of "
        "light that does so in the extraordinary (slow) one; mean over the area, times share, of the "
        "principal light whose facets show both. 0 of an isotropic stone, and of a plane-parallel plate, "
        "which displaces an image and does not turn it; none of a birefringent stone whose light is not split"
    )
    source = "gemrender"
    channels = ("angle", "area")
    follow = "principal"
    unit = "deg"
    needs_images = True
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return the angle [deg] and 1 for what shows both images, (n, 2)."""
        out, angle = np.zeros((2, len(light))).T, light.paths.image_angle  # by columns
        both = light.is_principal & light.is_exit
        if angle is not None:
            both &= np.isfinite(angle)
            out[both, 0] = angle[both]
        elif _is_birefringent(light):
            out[both, 0] = np.nan
        out[both, 1] = 1.0
        return out

    def values(self, sums: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return the mean angle [deg]; NaN where there are no two images."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(sums[..., :1] / sums[..., 1:])


def _is_birefringent(light: Light) -> bool:
    """Whether the stone is, whose ordinary index the light has been traced by."""
    material = light.paths.stone.material
    crystal = load_material(material, warn=False).crystal
    return crystal is not None and light.model.index == refractive_index(material)

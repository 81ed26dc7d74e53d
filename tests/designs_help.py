"""Stones from planes, for tests of what has neither a cylinder nor a brilliant's names."""

from __future__ import annotations

import numpy as np

from gemrender.stone import ConvexSolid, Facet, Stone
from gemrender.stone.facets import side_of


def stone_of(planes: np.ndarray, *, name: str = "planes", material: float = 1.54) -> Stone:
    """Return the stone inside planes (p, 4), one facet each; none may be cut away by others."""
    planes = np.asarray(planes, dtype=float)
    planes = planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    facets = tuple(Facet(f"f{k}", "facet", side_of(plane[2])) for k, plane in enumerate(planes))
    solid = ConvexSolid(planes=planes, facet=np.arange(len(planes)))
    return Stone(solid=solid, facets=facets, name=name, material=material)


def ring(
    sides: int, slope_deg: float, offset: float, *, start: float = 0.5, stretch: float = 1.0
) -> np.ndarray:
    """Planes around the axis (sides, 4): of so many degrees from level, downwards if negative, 90 upright.

    Stretched, the solid is longer along x.
    """
    azimuth = (np.arange(sides) + start) * 2 * np.pi / sides
    slope = np.radians(abs(slope_deg))
    rise = np.full(sides, np.copysign(np.cos(slope), slope_deg) if abs(slope_deg) < 90 else 0.0)
    normals = np.column_stack(
        [np.sin(slope) * np.cos(azimuth) / stretch, np.sin(slope) * np.sin(azimuth), rise]
    )
    return np.column_stack([normals, np.full(sides, offset)])


def level(offset: float, *, down: bool = False) -> np.ndarray:
    """A level plane, (1, 4)."""
    return np.array([[0.0, 0.0, -1.0 if down else 1.0, offset]])

"""Paths: what light does in a stone that is seen from one direction, whoever has traced it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.stone import Stone

__all__ = ["Paths"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Paths:
    """Principal paths, one row a path, followed back from the eye: of a pixel, a ray, or a virtual facet.

    No tracer knows a measure, and no measure a tracer: measures are functions of these
    (`gemrender.measures`). Where planes carry derivatives (complex128), so do areas, cosines, points and
    directions.

    Attributes
    ----------
    area : (n,) float64 or complex128
        Area of the view that each stands for [stone's unit^2].
    status : (n,) int64
        `RayStatus`.
    reflections : (n,) int64
        Total reflections.
    entry_facet, exit_facet : (n,) int64
        Facets on the eye's side and on the light's side; -1 for none.
    cos_entry, cos_exit : (n,) float64 or complex128
        Cosines of the angles in air at both crossings; 0 where there is none.
    exit_point : (n, 3) float64 or complex128
        Where the path leaves the stone: where the light came in [stone's unit].
    exit_direction : (n, 3) float64 or complex128
        Unit direction in which it leaves; the light came the opposite way.
    stone : Stone
        What was traced.
    """

    area: np.ndarray
    status: np.ndarray
    reflections: np.ndarray
    entry_facet: np.ndarray
    exit_facet: np.ndarray
    cos_entry: np.ndarray
    cos_exit: np.ndarray
    exit_point: np.ndarray
    exit_direction: np.ndarray
    stone: Stone

    def __len__(self) -> int:
        return len(self.status)

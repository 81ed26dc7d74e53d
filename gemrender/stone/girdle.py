"""The girdle: the wall between the upper and the lower girdle vertices.

A round stone's girdle is the cylinder of radius 1. The outline of a measured stone is not round: its wall
is the surface r = rho(azimuth, z) through its 32 girdle vertices, linear in azimuth between neighbouring
vertices and linear in height between the upper and the lower edge. With all vertices at radius 1 that is
the cylinder, exactly. The outward normal is horizontal and radial for every stone, as the paper has it
(its section 2.1, step 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Girdle"]

#: Deviation of the girdle vertices from radius 1 that still counts as round [girdle radius]: rounding.
ROUND_TOLERANCE = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Girdle:
    """The wall through the upper and lower girdle vertices.

    Parameters
    ----------
    upper, lower : (16, 3) float64
        Girdle vertices [girdle radius], anticlockwise seen from the table.
    """

    upper: np.ndarray
    lower: np.ndarray

    @property
    def is_round(self) -> bool:
        """Whether the wall is the cylinder of radius 1."""
        radii = np.hypot(*np.concatenate([self.upper, self.lower])[:, :2].T)
        return bool(np.all(np.abs(radii - 1.0) <= ROUND_TOLERANCE))

    @property
    def largest_radius(self) -> float:
        """Largest radius of a girdle vertex [girdle radius]."""
        return float(np.hypot(*np.concatenate([self.upper, self.lower])[:, :2].T).max())

    def radius(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the wall's radius rho at the azimuth of (x, y) and the height z.

        Parameters
        ----------
        x, y, z : (n,) float64
            Points [girdle radius].

        Returns
        -------
        (n,) float64
            Radius [girdle radius].
        """
        if self.is_round:
            return np.ones(np.broadcast_shapes(np.shape(x), np.shape(y), np.shape(z)))
        azimuth = np.arctan2(y, x)
        r_upper, z_upper = _around(self.upper, azimuth)
        r_lower, z_lower = _around(self.lower, azimuth)
        thickness = z_upper - z_lower
        # A knife edge has no height to interpolate over: its upper and lower edge are one.
        share = np.where(thickness > 0, (z - z_lower) / np.where(thickness > 0, thickness, 1.0), 0.5)
        # Scallops reach a little beyond the vertices' heights; further out the wall is never asked for.
        share = np.clip(share, -1.0, 2.0)
        return np.asarray((1 - share) * r_lower + share * r_upper)


def _around(ring: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radius and height of a ring of vertices at the azimuths, linear between the vertices."""
    angles = np.arctan2(ring[:, 1], ring[:, 0])
    radii = np.hypot(ring[:, 0], ring[:, 1])
    return (
        np.interp(azimuth, angles, radii, period=2 * np.pi),
        np.interp(azimuth, angles, ring[:, 2], period=2 * np.pi),
    )

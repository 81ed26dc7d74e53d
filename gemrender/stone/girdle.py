"""The girdle: the wall between the upper and the lower girdle vertices.

A round stone's girdle is the cylinder of radius 1, with a horizontal and radial normal, as the paper has it
(its section 2.1, step 4). The outline of a measured stone is not round: its wall is the surface
r = rho(azimuth, z) through its 32 girdle vertices, linear in azimuth between neighbouring vertices and
linear in height between the upper and the lower edge, and the normal is that surface's. With all vertices
at radius 1 both are the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Girdle"]

#: Deviation of the girdle vertices from radius 1 that still counts as round [girdle radius]: rounding.
ROUND_TOLERANCE = 1e-12

#: Least height that the wall is interpolated over [girdle radius].
_KNIFE_EDGE = 1e-9


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

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of the wall's edges [girdle radius], less what scallops may add."""
        radii = np.hypot(*np.concatenate([self.upper, self.lower])[:, :2].T)
        return float(radii.min() - np.ptp(radii))

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
        return self._wall(np.arctan2(y, x), z)[0]

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Return the wall's outward unit normals, (n, 3), at points (n, 3) of it [girdle radius]."""
        x, y, z = points.T
        radial = np.stack([x, y, np.zeros_like(x)], axis=-1) / np.hypot(x, y)[:, None]
        if self.is_round:
            return np.asarray(radial)
        radius, by_azimuth, by_height = self._wall(np.arctan2(y, x), z)
        along = np.stack([-radial[:, 1], radial[:, 0], np.zeros_like(x)], axis=-1)
        # The gradient of r - rho(azimuth, z).
        out = radial - (by_azimuth / radius)[:, None] * along - by_height[:, None] * (0.0, 0.0, 1.0)
        return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))

    def _wall(self, azimuth: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Radius of a measured wall, and its derivatives by azimuth and height."""
        r_upper, z_upper, dr_upper, dz_upper = _around(self.upper, azimuth)
        r_lower, z_lower, dr_lower, dz_lower = _around(self.lower, azimuth)
        # A knife edge has no height to interpolate over: its upper and lower edge are one.
        thickness = np.maximum(z_upper - z_lower, _KNIFE_EDGE)
        # Scallops reach a little beyond the vertices' heights; further out the wall is never asked for.
        share = np.clip((z - z_lower) / thickness, -1.0, 2.0)
        by_share = r_upper - r_lower
        share_by_azimuth = -(dz_lower + share * (dz_upper - dz_lower)) / thickness
        by_azimuth = (1 - share) * dr_lower + share * dr_upper + by_share * share_by_azimuth
        return (1 - share) * r_lower + share * r_upper, by_azimuth, by_share / thickness


def _around(ring: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Radius and height of a ring at the azimuths, linear between its vertices, and their derivatives."""
    angles = np.arctan2(ring[:, 1], ring[:, 0])
    order = np.argsort(angles)
    angles = angles[order]
    values = np.stack([np.hypot(ring[:, 0], ring[:, 1]), ring[:, 2]])[:, order]
    steps = np.diff(angles, append=angles[0] + 2 * np.pi)
    slopes = (np.roll(values, -1, axis=1) - values) / steps
    sector = np.searchsorted(angles, azimuth, side="right") - 1  # -1: the last, from the other side of pi
    beyond = (azimuth - angles[sector]) % (2 * np.pi)
    radius, height = values[:, sector] + slopes[:, sector] * beyond
    return radius, height, slopes[0, sector], slopes[1, sector]

"""Where the light comes from, by the zones of an ASET: `aset`, of principal and of all light."""

from __future__ import annotations

import math

import numpy as np

from gemrender.measures.measure import Light, Measure, is_above, is_tied

__all__ = ["ZONES", "ZONE_LIMITS", "Aset", "zone"]

#: Zones by elevation above the viewer's horizon, from below up, and the limits between them as cosines with
#: the zenith: 0, 45 and 75 degrees.
ZONES = ("leak", "green", "red", "blue")
ZONE_LIMITS = (0.0, math.sin(math.radians(45.0)), math.sin(math.radians(75.0)))

_SHOWN = ("green", "red", "blue", "leak")
_COLUMN = np.array([_SHOWN.index(name) for name in ZONES])


def zone(light: Light) -> np.ndarray:
    """Return the zone of each exit, (n,) int64, a number of `ZONES`; a tie is in the lower one."""
    above = (is_above(light.zenith_cosine, limit) for limit in ZONE_LIMITS)
    return np.asarray(sum(above, start=np.zeros(len(light), dtype=np.int64)))


class Aset(Measure):
    """Shares of the view by the zone that its light comes from."""

    name, version = "aset", 1
    definition = (
        "shares by the elevation of the exit above the viewer's horizon: [0, 45) deg green, [45, 75) red, "
        "[75, 90] blue, below leak. Of the principal light by area, with what is trapped or lost 100; of all "
        "light (weighted_...) by w (1 - R), with the reflection of the surface and the rest inside 100. "
        "What is within 1e-7 of a limit (cosine) is in the lower zone, and `tied`"
    )
    source = "AGS, US patent 7,382,445 (expired)"
    keys = (
        *_SHOWN,
        "trapped",
        *(f"weighted_{name}" for name in _SHOWN),
        "surface",
        "rest",
        "tied",
        "weighted_tied",
    )
    smooth_keys = (
        *_SHOWN,
        "trapped",
        "tied",
        *(f"weighted_{name}" for name in _SHOWN),
        "surface",
        "rest",
        "weighted_tied",
    )
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return shares by zone, (n, 13), in the order of `keys`."""
        out = np.zeros((len(self.keys), len(light)), light.share.dtype).T  # by columns
        exits, principal = light.is_exit, light.is_principal
        column = _COLUMN[zone(light)]
        ties = exits & is_tied(light.zenith_cosine, *ZONE_LIMITS)

        rows = np.flatnonzero(principal)
        out[rows, np.where(exits, column, 4)[rows]] = 1.0
        out[:, 11] = ties & principal

        for k in range(4):
            out[:, 5 + k] = np.where(column == k, light.share, 0.0)
        out[:, 9] = np.where(principal, light.surface_reflectance, 0.0)
        out[:, 10] = np.where(exits, 0.0, light.arriving)
        out[:, 12] = np.where(ties, light.share, 0.0)
        return out

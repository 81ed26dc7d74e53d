"""Inoue's primary intensity, rear light, and their shares of a view (`docs/model.md`, sections 4 and 6)."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure
from gemrender.observation import Model, RayStatus
from gemrender.optics.fresnel import transmittance
from gemrender.paths import Paths
from gemrender.stone.facets import PAVILION

__all__ = [
    "BANDS",
    "BAND_EDGES",
    "INTENSITY",
    "LOST",
    "MET",
    "N_SUMS",
    "REAR",
    "TRAPPED",
    "Inoue",
    "path_intensity",
    "primary_intensity",
    "rear_mask",
    "sum_up",
]

#: What is summed up over paths: intensity, rear light, trapped, lost, light in the six bands, brightest
#: first, and all that met the stone.
INTENSITY, REAR, TRAPPED, LOST, BANDS, MET, N_SUMS = 0, 1, 2, 3, 4, 10, 11

# Whole numbers: numpy takes long to find out that an enumeration's member is one.
_MISSED, _EXITED, _TRAPPED, _LOST = map(int, RayStatus)
#: Lower edges of the bands of intensity but the last, brightest first, as shares of the light.
BAND_EDGES = (0.75, 0.60, 0.45, 0.30, 0.15)
_FALLING = -np.array(BAND_EDGES)


def rear_mask(paths: Paths, model: Model) -> np.ndarray:
    """Tell rear light, (n,) bool: by where it came in, through which facet, or from where."""
    if model.rear == "position":
        rear = paths.exit_point[:, 2].real <= model.ground
    elif model.rear == "facet":
        is_pavilion = np.array([side == PAVILION for side in paths.stone.facet_sides])
        rear = is_pavilion[paths.exit_facet]
    else:
        rear = paths.exit_direction[:, 2].real <= 0.0
    return np.asarray(rear & (paths.status == _EXITED))


def path_intensity(cos_entry: np.ndarray, cos_exit: np.ndarray, model: Model) -> np.ndarray:
    """Return what of the light the two crossings leave: T S T S, or T T for radiance (section 4).

    T is the transmitted share, and S, where light enters, the ratio of the cosines in air and in the stone;
    where it leaves its reciprocal.

    Parameters
    ----------
    cos_entry, cos_exit : (n,) float64 or complex128
        Cosines of the angles in air on the eye's side and on the light's side.

    Returns
    -------
    (n,) array like them
        Shares, 0 to 1.
    """
    index, both = model.index, np.concatenate([cos_entry, cos_exit])
    share = transmittance(both, index, model.fresnel)
    share = share[: len(cos_entry)] * share[len(cos_entry) :]
    if model.intensity == "radiance":
        return np.asarray(share)
    in_stone = np.sqrt((index**2 - 1.0 + cos_entry**2) / (index**2 - 1.0 + cos_exit**2))
    return np.asarray(share * cos_exit / cos_entry * in_stone)


def primary_intensity(paths: Paths, model: Model, rear: np.ndarray) -> np.ndarray:
    """Return the intensity of each principal path, (n,), 0 to 1.

    It is 0 for rear light (n,) bool, without an exit, and of light that has been reflected in part. Of a
    birefringent stone T is what enters, and what of its mode leaves, and S S the ratio of cross-sections.
    """
    lit = np.flatnonzero((paths.status == _EXITED) & ~rear & (paths.partial_reflections == 0))
    out = np.zeros(len(paths), dtype=paths.cos_exit.dtype)
    if paths.entering is not None and paths.leaving is not None and paths.section is not None:
        out[lit] = paths.entering[lit] * paths.leaving[lit]
        if model.intensity == "primary":
            out[lit] *= paths.section[lit]
        return out
    out[lit] = path_intensity(paths.cos_entry[lit], paths.cos_exit[lit], model)
    return out


def sum_up(
    paths: Paths,
    rear: np.ndarray,
    intensity: np.ndarray,
    n_sets: int = 1,
) -> np.ndarray:
    """Sum up areas by what became of the principal light, each set of paths by itself.

    Parameters
    ----------
    paths : Paths
        The paths.
    rear, intensity : (n,) bool, (n,) float64
        Which are rear light, and their intensity (0 to 1).
    n_sets : int
        How many sets there are (`Paths.set_number`); without sets all paths are one.

    Returns
    -------
    (n_sets, N_SUMS) float64
        Areas [stone's unit^2], INTENSITY of area times intensity.
    """
    out = np.zeros((n_sets, N_SUMS))
    sets = np.zeros(len(paths), dtype=np.int64) if paths.set_number is None else paths.set_number
    out[:, INTENSITY] = np.bincount(sets, paths.area * intensity, n_sets)
    column = _columns(paths, rear, intensity)
    met = np.flatnonzero((paths.status != _MISSED) & (paths.partial_reflections == 0))
    by_column = np.bincount(sets[met] * N_SUMS + column[met], paths.area[met], n_sets * N_SUMS)
    out += by_column.reshape(n_sets, N_SUMS)
    out[:, MET] = np.bincount(sets[met], paths.area[met], n_sets)
    return out


def _columns(paths: Paths, rear: np.ndarray, intensity: np.ndarray) -> np.ndarray:
    """Return the sum that the area of each path belongs to, (n,): REAR, TRAPPED, LOST or a band's."""
    column = BANDS + np.searchsorted(_FALLING, -intensity, side="left")
    column[rear] = REAR
    column[paths.status == _TRAPPED] = TRAPPED
    column[paths.status == _LOST] = LOST
    return np.asarray(column)


class Inoue(Measure):
    """The paper's score, by the rules of the model: Average, Rear, and shares by intensity."""

    name, version = "inoue", 1
    definition = (
        "mean primary intensity T S T S of the principal light, by the model's transmittances T and "
        "cross-sections S, rear light counted as 0 (average); rear, trapped and lost light, and bands of "
        "intensity, as shares of the view"
    )
    source = "Inoue's paper (docs/model.md)"
    keys = ("average", "rear", "trapped", "lost", *(f"band_{100 * edge:.0f}" for edge in (*BAND_EDGES, 0.0)))
    follow = "principal"
    smooth_keys = keys
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return the intensity (0 to 1), and 1 for the share that each path belongs to, (n, 10)."""
        rear = rear_mask(light.paths, light.model)
        # Of other rows than these nothing is asked.
        intensity = primary_intensity(light.paths, light.model, rear | ~light.is_principal)
        out = np.zeros((MET, len(light)), intensity.dtype).T  # by columns
        rows = np.flatnonzero(light.is_principal)
        out[rows, _columns(light.paths, rear, intensity.real)[rows]] = 1.0
        out[rows, INTENSITY] = intensity[rows]
        return out

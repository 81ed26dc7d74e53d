"""How far a stone fans out colours: `dispersion`, the angle between blue and red light that it gives back."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure, is_above
from gemrender.optics.abbe import ABBE_LINES_NM
from gemrender.optics.material_files import load_material

__all__ = ["Dispersion", "exit_directions", "fan_angle"]

DEGREE = np.pi / 180


def exit_directions(
    direction: np.ndarray, entry_normal: np.ndarray, exit_normal: np.ndarray, index: float
) -> np.ndarray:
    """Refract a ray in and out of the unfolded stone, whatever has been reflected in between.

    Parameters
    ----------
    direction : (3,) or (n, 3) float64
        Unit direction from the eye.
    entry_normal, exit_normal : (n, 3) float64
        Outward unit normals of the unfolded stone (`Paths`).
    index : float
        Refractive index of the light's colour.

    Returns
    -------
    (n, 3) float64
        Unit directions in the unfolded frame. Light beyond the critical angle ends at it: it grazes.
    """

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("...j,...j->...", a, b)[..., None])

    # Snell's law (Born & Wolf, Principles of Optics, 7th ed., section 1.5.1): what is tangential is divided
    # by the index at the entry, and multiplied at the exit.
    along = (direction - dot(direction, entry_normal) * entry_normal) / index
    inside = along - np.sqrt(1.0 - dot(along, along)) * entry_normal
    along = index * (inside - dot(inside, exit_normal) * exit_normal)
    squared = dot(along, along)
    grazes = squared.real >= 1.0  # then rounding must not make a direction of it: its root is 1e-8
    along = along / np.where(grazes, np.sqrt(squared), 1.0)
    return np.asarray(
        along + np.where(grazes, 0.0, np.sqrt(np.where(grazes, 1.0, 1.0 - squared))) * exit_normal
    )


def fan_angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the angle between unit directions (n, 3), (n,) [deg]; exact for small ones too."""
    apart = first - second
    half_chord = 0.5 * np.sqrt((apart * apart).sum(axis=-1))  # analytic, as a norm is not
    return np.asarray(2.0 * np.arcsin(np.minimum(half_chord, 1.0)) / DEGREE)


class Dispersion(Measure):
    """Mean angle between the light of two colours that leave together."""

    name, version = "dispersion", 1
    definition = (
        "angle [deg] between the exit directions at F (486.1 nm) and C (656.3 nm) along the same facets: "
        "mean over the area whose principal light comes from above the viewer's horizon; weighted: by the "
        "shares T T that both crossings leave, too. None where the index is not that of a material with "
        "known dispersion. Not DCLR, whose formula is unpublished"
    )
    source = "gemrender"
    keys = ("value", "weighted")
    channels = ("angle", "area", "weighted_angle", "weighted_area")
    follow = "principal"
    unit = "deg"
    smooth_keys = keys
    needs_normals = True
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return angle [deg] and 1 for what is counted, and both times T T, (n, 4); NaN where not known."""
        paths, out = light.paths, np.zeros((4, len(light)), light.share.dtype).T  # by columns
        rows = np.flatnonzero(light.is_principal & light.is_exit & is_above(light.zenith_cosine, 0.0))
        indices = _blue_and_red(light)
        if indices is None or paths.entry_normal is None or paths.unfolded_exit_normal is None:
            angle = np.full(len(rows), np.nan)
        else:
            eye, entry = light.view.basis()[2], paths.entry_normal[rows]
            leaves = paths.unfolded_exit_normal[rows]
            angle = fan_angle(*(exit_directions(-eye, entry, leaves, index) for index in indices))
        out[rows] = np.column_stack(
            [angle, np.ones(len(rows)), *(light.share[rows] * [angle, np.ones(len(rows))])]
        )
        return out

    def values(self, sums: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return the mean angles [deg]; NaN where no light is given back."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(sums[..., 0::2] / sums[..., 1::2])


def _blue_and_red(light: Light) -> tuple[float, float] | None:
    """Return the indices at F and C of the stone's material, None where the light has another index."""
    material = load_material(light.paths.stone.material, warn=False)  # of an index without dispersion
    blue, _, red = (float(index) for index in material.index(ABBE_LINES_NM))
    return (blue, red) if red < light.model.index < blue else None

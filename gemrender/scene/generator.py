"""Scenes as plain dictionaries: the stone, its light, the sensor and the integrator."""

from __future__ import annotations

from typing import Any

from gemrender.observation import Model, View, indicatrix_of
from gemrender.optics.crystals import Indicatrix
from gemrender.stone import Stone

__all__ = ["film", "integrator", "sensor", "stone_scene"]


def stone_scene(
    stone: Stone,
    view: View,
    model: Model,
    *,
    rows: int | None = None,
    follow: str = "principal",
    birefringence: bool = False,
) -> dict[str, Any]:
    """Return the scene of the paper: the stone under a uniform upper hemisphere, seen by parallel rays.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View
        The map to render.
    model : Model
        The optical model.
    rows : int, optional
        Rows of the film, where a map is rendered in passes; by default the view's.
    follow : {"principal", "all"}
        Which light is followed; all of it by random numbers.
    birefringence : bool
        Whether light is split in a birefringent stone, by random numbers too; if not, it has its ordinary
        index.

    Returns
    -------
    dict
        For `mi.load_dict`; "stone" is a `mi.Mesh` of the active variant, all else is plain.
    """
    from gemrender.scene.mesh import stone_mesh

    crystal = indicatrix_of(stone, model) if birefringence else None
    scene = {
        "type": "scene",
        "integrator": integrator(model, crystal),
        "sensor": sensor(view, rows=rows),
        "light": {"type": "gem_hemisphere"},
        "stone": stone_mesh(stone, bsdf=dielectric(model.index)),
    }
    if follow != "principal":
        scene["integrator"]["follow"] = follow
    if follow != "principal" or crystal is not None:
        scene["sensor"]["sampler"] = {"type": "independent", "sample_count": 1}
    return scene


def dielectric(index: float) -> dict[str, Any]:
    """Return the stone's surface for Mitsuba's own integrators: smooth, against an exterior of index 1."""
    return {"type": "dielectric", "int_ior": index, "ext_ior": 1.0}


def integrator(model: Model, crystal: Indicatrix | None = None) -> dict[str, Any]:
    """Return the integrator that follows the model, of a crystal in its modes."""
    inside: dict[str, Any] = {"int_ior": model.index, "ext_ior": 1.0, "fresnel": model.fresnel}
    if crystal is not None:
        axes = {"c_axis": crystal.frame[2].tolist(), "a_axis": crystal.frame[0].tolist()}
        inside = {"principal": crystal.indices.tolist(), **axes, "ext_ior": 1.0, "fresnel": "exact"}
    return {
        "type": "gem_primary",
        **inside,
        "rear": model.rear,
        "intensity": model.intensity,
        "max_reflections": model.max_reflections,
        "ground": model.ground,
    }


def sensor(view: View, *, rows: int | None = None) -> dict[str, Any]:
    """Return the sensor of a view: one film pixel is one cell, sampled at its centre."""
    rows = rows or view.resolution
    return {
        "type": "gem_orthographic",
        "x_min": -view.half_width,
        "x_max": view.half_width,
        **rows_window(view, 0, rows),
        "tilt": view.tilt_deg,
        "tilt_azimuth": view.tilt_azimuth_deg,
        "sampling": "centre",
        "film": film(view.resolution, rows),
        "sampler": {"type": "stratified", "sample_count": 1, "jitter": False},
    }


def rows_window(view: View, first: int, rows: int) -> dict[str, float]:
    """Return the sensor's window in y for `rows` rows of the view from row `first` on."""
    step = 2 * view.half_width / view.resolution
    y_max = view.half_width - first * step
    return {"y_min": y_max - rows * step, "y_max": y_max}


def film(width: int, height: int) -> dict[str, Any]:
    """Return a film that keeps each sample in its own pixel, unfiltered and in float32."""
    return {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "luminance",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }

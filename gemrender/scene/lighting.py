"""Light of scenes for pictures: lights and skies of a set-up, as Mitsuba dictionaries."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from gemrender.colorimetry import (
    adapt,
    adaptation_matrix,
    colour_spectrum,
    colour_xyz,
    illuminant_spectrum,
    matrix_to_linear_srgb,
    white_xyz,
    xyz_to_linear_srgb,
)
from gemrender.scene.placing import towards
from gemrender.scene.setup import Light, Setup
from gemrender.scene.sky_boxes import Box, draw_studio
from gemrender.scene.sky_image import environment, read_sky_image
from gemrender.scene.zones import Zone, layers

__all__ = ["lights", "reflectance", "sky"]

#: Where spectra are written down [nm]: Mitsuba's range, in the steps of CIE's tables.
_SPECTRUM_NM = np.arange(360.0, 831.0, 5.0)
#: Radius of the can that stands in place of zones [girdle radius], and elevation of its ends' rims, where no
#: zone's limit is nearer to a pole [deg].
_FAR, _END_DEG = 1e4, 45.0


def lights(setup: Setup, target: np.ndarray, stock: bool) -> dict[str, Any]:
    """Return the lights of a set-up, by their names in the scene.

    Parameters
    ----------
    setup : Setup
        The set-up.
    target : (3,) float64
        The stones' middle [scene unit].
    stock : bool
        Whether to use Mitsuba's own plugins only.
    """
    import mitsuba as mi

    out: dict[str, Any] = {}
    # Their surface is black: what is seen of a light is its radiance, not light of others that it reflects.
    # Without a radiance it is a black screen; Mitsuba takes no emitter that emits nothing.
    black = {"type": "diffuse", "reflectance": reflectance(0.0, stock)}
    for number, light in enumerate(setup.lights, start=1):
        surface: dict[str, Any] = {"bsdf": black}
        if light.radiance > 0:
            radiance = _emission(light.radiance, light.spectrum, setup, stock)
            surface["emitter"] = {"type": "area", "radiance": radiance}
        place = target + light.distance * towards(light.elevation, light.azimuth)
        if light.shape == "sphere":
            out[f"light_{number}"] = {
                "type": "sphere",
                "center": place.tolist(),
                "radius": 0.5 * light.size[0],
                **surface,
            }
            continue
        to_world = _facing(light, place, target)
        width, height = light.size
        if light.shape == "ring":
            for k in range(light.count):
                turn = 2 * np.pi * k / light.count
                at = [0.5 * width * np.cos(turn), 0.5 * width * np.sin(turn), 0.0]
                diode = mi.ScalarTransform4f().translate(at).scale([0.5 * height, 0.5 * height, 1.0])
                out[f"light_{number}_{k + 1}"] = {
                    "type": "disk",
                    "to_world": to_world @ diode,
                    **surface,
                }
            continue
        scale = mi.ScalarTransform4f().scale([0.5 * width, 0.5 * height, 1.0])
        out[f"light_{number}"] = {
            "type": "rectangle" if light.shape == "rectangle" else "disk",
            "to_world": to_world @ scale,
            **surface,
        }
    return out


def _facing(light: Light, place: np.ndarray, target: np.ndarray) -> Any:
    """Return the transform of a light that faces the stones."""
    import mitsuba as mi

    up = [0.0, 0.0, 1.0]
    if abs(light.elevation) > 89:  # straight above: up is away from the light's azimuth
        up = (-towards(0.0, light.azimuth)).tolist()
    return mi.ScalarTransform4f().look_at(place.tolist(), target.tolist(), up)


def sky(setup: Setup, target: np.ndarray, stock: bool) -> dict[str, Any]:
    """Return the sky of a set-up, and what stands in place of it where plugins are Mitsuba's own.

    Parameters
    ----------
    setup : Setup
        The set-up.
    target : (3,) float64
        The stones' middle [scene unit].
    stock : bool
        Whether to use Mitsuba's own plugins only.
    """
    of = setup.sky
    if of.is_dark:
        return {}
    if of.type == "zones":
        axis = towards(setup.camera.elevation, setup.camera.azimuth)
        if stock:
            return _can_of_zones(setup, axis, target)
        bands = layers(of.zones)
        lit = [k for k, (_, _, zone) in enumerate(bands) if zone is not None]
        bands = bands[lit[0] : lit[-1] + 1]
        edges = [bands[0][0], *(high for _, high, _ in bands)]
        zones = {"type": "gem_zones", "axis": axis.tolist(), "edges": ", ".join(f"{e:.9g}" for e in edges)}
        for k, (_, _, zone) in enumerate(bands, start=1):
            zones[f"radiance_{k}"] = 0.0 if zone is None else _colour(zone, setup, stock)
        return {"sky": zones}
    if of.type in ("image", "studio"):
        return {"sky": _image_sky(setup, stock)}
    radiance = _emission(of.radiance, of.spectrum, setup, stock)
    if of.type == "uniform":
        return {"sky": {"type": "constant", "radiance": radiance}}
    if not stock:
        return {"sky": {"type": "gem_hemisphere", "radiance": radiance}}
    # Black below the horizon: a black floor under the stones, wide enough for any ray
    import mitsuba as mi

    floor = mi.ScalarTransform4f().translate([0.0, 0.0, -1e-3]).scale([1e4, 1e4, 1.0])
    black = {"type": "diffuse", "reflectance": reflectance(0.0, stock)}
    return {
        "sky": {"type": "constant", "radiance": radiance},
        "below": {"type": "disk", "to_world": floor, "bsdf": black},
    }


def _image_sky(setup: Setup, stock: bool) -> dict[str, Any]:
    """Return a sky that is an image, or drawn as one."""
    of = setup.sky
    if of.type == "image":
        pixels = read_sky_image(of.image)
        to_rgb = np.eye(3)
        if stock:
            to_rgb = _stock_matrix(setup) @ np.linalg.inv(matrix_to_linear_srgb())
    else:
        pixels = _drawn(of.boxes, of.radiance, of.spectrum)
        to_rgb = _stock_matrix(setup) if stock else matrix_to_linear_srgb()
    rgb = np.maximum(pixels @ to_rgb.T.astype(np.float32), 0)
    return environment(rgb, azimuth_deg=of.azimuth, scale=of.scale, stock=stock)


@lru_cache(maxsize=2)  # two seconds each, and a film has one for all frames
def _drawn(boxes: tuple[Box, ...], radiance: float, spectrum: str | float) -> np.ndarray:
    pixels = draw_studio(boxes, radiance=radiance, spectrum=spectrum)
    pixels.flags.writeable = False
    return pixels


def _stock_matrix(setup: Setup) -> np.ndarray:
    """Return the matrix (3, 3) from XYZ to linear sRGB, of which white is the set-up's."""
    return np.asarray(matrix_to_linear_srgb() @ adaptation_matrix(white_xyz(setup.white)))


def _can_of_zones(setup: Setup, axis: np.ndarray, target: np.ndarray) -> dict[str, Any]:
    """Return zones as Mitsuba's own plugins have them: a far can, cylinders with a disc at each end."""
    out: dict[str, Any] = {}
    black = {"type": "diffuse", "reflectance": reflectance(0.0, stock=True)}
    for k, (low, high, zone) in enumerate(layers(setup.sky.zones), start=1):
        if zone is None:
            continue
        light = {"type": "area", "radiance": _colour(zone, setup, stock=True)}
        # What reaches a pole is a disc there, and a cylinder up to it
        floor, roof = min(high, -_END_DEG), max(low, _END_DEG)
        if low == -90:
            low = floor
            out[f"zone_{k}_bottom"] = _end_of_can(-axis, -floor, target)
        if high == 90:
            high = roof
            out[f"zone_{k}_top"] = _end_of_can(axis, roof, target)
        if low < high:
            ends = [target + _FAR * np.tan(np.radians(edge)) * axis for edge in (low, high)]
            wall = {"type": "cylinder", "p0": ends[0].tolist(), "p1": ends[1].tolist()}
            out[f"zone_{k}"] = {**wall, "radius": _FAR, "flip_normals": True}
        for name in (f"zone_{k}", f"zone_{k}_bottom", f"zone_{k}_top"):
            if name in out:
                out[name] |= {"bsdf": black, "emitter": light}
    return out


def _end_of_can(side: np.ndarray, elevation_deg: float, target: np.ndarray) -> dict[str, Any]:
    """Return the disc that is seen from an elevation to the pole on a side."""
    import mitsuba as mi

    middle = target + _FAR * np.tan(np.radians(elevation_deg)) * side
    up = [0.0, 0.0, 1.0] if abs(side[2]) < 0.9 else [0.0, 1.0, 0.0]
    place = mi.ScalarTransform4f().look_at(middle.tolist(), target.tolist(), up)
    return {"type": "disk", "to_world": place @ mi.ScalarTransform4f().scale([_FAR, _FAR, 1.0])}


def _colour(zone: Zone, setup: Setup, stock: bool) -> dict[str, Any]:
    """Return the emission of a zone: of white light's own spectrum where it is grey."""
    if stock:
        rgb = xyz_to_linear_srgb(adapt(colour_xyz(zone.colour), white_xyz(setup.white))) * zone.radiance
        return {"type": "rgb", "value": [float(x) for x in np.maximum(rgb, 0.0)]}
    if len(set(zone.colour)) == 1:
        return _emission(zone.radiance * zone.colour[0], "d65", setup, stock)
    return _regular(colour_spectrum(zone.colour, _SPECTRUM_NM) * zone.radiance)


def _emission(radiance: float, spectrum: str | float, setup: Setup, stock: bool) -> dict[str, Any]:
    """Return an emission: luminance `radiance` of a light's colour."""
    if stock:
        rgb = xyz_to_linear_srgb(adapt(white_xyz(spectrum), white_xyz(setup.white))) * radiance
        return {"type": "rgb", "value": [float(x) for x in np.maximum(rgb, 0.0)]}
    return _regular(illuminant_spectrum(spectrum, _SPECTRUM_NM) * radiance)


def _regular(values: np.ndarray) -> dict[str, Any]:
    """Return a spectrum of values at `_SPECTRUM_NM`."""
    return {
        "type": "regular",
        "wavelength_min": float(_SPECTRUM_NM[0]),
        "wavelength_max": float(_SPECTRUM_NM[-1]),
        # With all digits of single precision: twice the radiance is twice the picture
        "values": ", ".join(f"{x:.9g}" for x in values),
    }


def reflectance(value: float, stock: bool) -> dict[str, Any]:
    """Return a reflectance that is the same at all wavelengths."""
    return {"type": "rgb", "value": value} if stock else {"type": "uniform", "value": value}

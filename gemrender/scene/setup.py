"""Set-ups: camera, lights, sky and ground that a stone is pictured in, each a TOML file."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import (
    bundled_files,
    did_you_mean,
    located_at,
    parse_toml,
    read_lines,
    refuse_unknown,
    section,
    stem,
    text_line,
)
from gemrender.scene import setup_checks as check
from gemrender.scene.filters import Filters
from gemrender.scene.settings.setting import Setting
from gemrender.scene.sky_boxes import Box, boxes_of
from gemrender.scene.things import Thing, things_of
from gemrender.scene.zones import Zone, zones_of

__all__ = [
    "CAMERAS",
    "CURVES",
    "EXPOSURES",
    "GIRDLES",
    "GROUNDS",
    "LIGHTS",
    "POSES",
    "Box",
    "Camera",
    "Filters",
    "Ground",
    "Light",
    "Setting",
    "Setup",
    "Sky",
    "Thing",
    "Zone",
    "bundled_setups",
    "load_setup",
]

CAMERAS = ("perspective", "thin-lens", "orthographic")
LIGHTS = ("rectangle", "disc", "ring", "sphere")
SKIES = ("uniform", "hemisphere", "zones", "image", "studio")
GROUNDS = ("none", "plane", "sweep", "cup")
EXPOSURES = ("stones", "ground", "white", "light")
#: Tone curves; what they do is in `gemrender.render.curves`.
CURVES = ("linear", "filmic", "contrast", "neutral", "agx")
POSES = ("table-up", "lying", "table-down")
GIRDLES = ("polished", "faceted", "bruted")


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """Where the picture is taken from. Lengths in girdle radii of the (first) stone, angles in degrees.

    Attributes
    ----------
    type : {"perspective", "thin-lens", "orthographic"}
        Kind of camera.
    elevation, azimuth : float
        Direction from the stones to the camera: above the horizon (90 looks straight down), and about the
        vertical, anticlockwise from x [deg].
    distance : float
        From the stones' middle to the camera.
    margin : float
        Side of the picture, as a multiple of what the stones take up.
    aperture : float
        Radius of the lens ("thin-lens").
    focus : float
        What is sharp: so far in front of the stones' middle, towards the camera ("thin-lens").
    """

    type: str = "perspective"
    elevation: float = 35.0
    azimuth: float = -90.0
    distance: float = 15.0
    margin: float = 1.25
    aperture: float = 0.0
    focus: float = 0.0

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "type", CAMERAS)
            mistakes.of(check.within, self, "elevation", -90, 90)
            mistakes.of(check.within, self, "azimuth", -360, 360)
            mistakes.of(check.within, self, "distance", 0.1, 1e4)
            mistakes.of(check.within, self, "margin", 0.05, 100)
            mistakes.of(check.within, self, "aperture", 0, 100)
            mistakes.of(check.within, self, "focus", -1e3, 1e3)
        if self.type == "thin-lens" and self.aperture == 0:
            raise InputError("must be above 0 for a thin lens", key="aperture", value=self.aperture)
        if self.focus >= self.distance:
            raise InputError("must be less than the distance", key="focus", value=self.focus)


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """A light that shines towards the stones.

    Attributes
    ----------
    shape : {"rectangle", "disc", "ring", "sphere"}
        A ring is a circle of small discs, as of diodes about a loupe.
    elevation, azimuth, distance : float
        Where its middle stands, as seen from the stones' middle [deg, girdle radius].
    size : (float, float)
        Width and height of a rectangle; diameter of a disc, a sphere and a ring, and of a ring's discs
        [girdle radius].
    count : int
        Discs of a ring.
    radiance : float
        Luminance, relative: that of white ground under a sky of radiance 1 is its reflectance. All that is
        seen of a light is its radiance, its surface is black; of radiance 0 it is a black screen.
    spectrum : str or float
        A light of colorimetry ("d65", "a", "e", ...) or the temperature of a blackbody [K].
    """

    shape: str
    elevation: float = 45.0
    azimuth: float = 0.0
    distance: float = 8.0
    size: tuple[float, float] = (2.0, 2.0)
    count: int = 24
    radiance: float = 1.0
    spectrum: str | float = "d65"

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "shape", LIGHTS)
            mistakes.of(check.within, self, "elevation", -90, 90)
            mistakes.of(check.within, self, "azimuth", -360, 360)
            mistakes.of(check.within, self, "distance", 0.1, 1e4)
            mistakes.of(check.radiance, self)
            mistakes.of(check.spectrum, self)
            size = mistakes.of(check.two_sizes, self.size)
            if isinstance(self.count, bool) or not isinstance(self.count, int) or not 1 <= self.count <= 256:
                allowed = "must be a whole number from 1 to 256"
                mistakes.add(InputError(allowed, key="count", value=self.count))
        object.__setattr__(self, "size", size)


#: Keys of a sky that not all types have, and which have them.
_SKY_KEYS = {
    "radiance": ("uniform", "hemisphere", "studio"),
    "spectrum": ("uniform", "hemisphere", "studio"),
    "zones": ("zones",),
    "image": ("image",),
    "azimuth": ("image", "studio"),
    "scale": ("image", "studio"),
    "boxes": ("studio",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Sky:
    """Light from all around, beyond everything else.

    Attributes
    ----------
    type : {"uniform", "hemisphere", "zones", "image", "studio"}
        The same from everywhere; from above the horizon only, as in Inoue's paper; by zones of elevation
        above the viewer's horizon, whatever way the camera looks; an image of all that is around, infinitely
        far away; or a studio, softboxes in a room, as far.
    radiance : float
        Luminance, relative; of a studio that of the room. Zones have their own, images a scale.
    spectrum : str or float
        As of a light; not of zones and images.
    zones : tuple of Zone
        The zones; in rows of a file tables of their attributes. What no zone covers is black.
    image : str
        An OpenEXR or Radiance file (.exr, .hdr), equirectangular: all around by zenith to nadir, linear sRGB
        whose (1, 1, 1) is D65 of luminance 1. In a set-up file its path is as seen from there.
    azimuth : float
        Where the image's middle column is, or what a studio is turned by about the vertical [deg].
    scale : float
        What an image, or a whole studio, is multiplied by.
    boxes : tuple of Box
        The softboxes of a studio; in a file tables [[sky.boxes]]. Later ones hide earlier ones.
    """

    type: str = "uniform"
    radiance: float = 0.0
    spectrum: str | float = "d65"
    zones: tuple[Zone, ...] = ()
    image: str = ""
    azimuth: float = 0.0
    scale: float = 1.0
    boxes: tuple[Box, ...] = ()

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "type", SKIES)
            mistakes.of(check.radiance, self)
            mistakes.of(check.spectrum, self)
            mistakes.of(check.within, self, "azimuth", -360, 360)
            mistakes.of(check.within, self, "scale", 0, 1e6)
            mistakes.of(check.one_line, self, "image")
            for key, kinds in _SKY_KEYS.items():
                of_other = self.type in SKIES and self.type not in kinds
                if of_other and getattr(self, key) != Sky.__dataclass_fields__[key].default:
                    told = f"is for type = {' or '.join(map(_quoted, kinds))}"
                    if self.type == "zones" and key in ("radiance", "spectrum"):
                        told = "not allowed here, zones have colours and radiances of their own"
                    elif key in ("zones", "boxes"):
                        told = told.replace("is", "are", 1)
                    mistakes.add(InputError(told, key=key, value=getattr(self, key)))
            if self.type == "zones":
                object.__setattr__(self, "zones", mistakes.of(zones_of, self.zones) or ())
            elif self.type == "studio":
                object.__setattr__(self, "boxes", mistakes.of(boxes_of, self.boxes) or ())
            elif self.type == "image" and not self.image:
                mistakes.add(InputError("missing; must be the path of an image", key="image"))

    @property
    def is_dark(self) -> bool:
        """Whether it gives no light."""
        if self.type == "zones":
            return all(zone.is_dark for zone in self.zones)
        if self.type == "image":
            return self.scale == 0
        boxes = self.scale == 0 or all(box.is_dark for box in self.boxes)
        return boxes if self.type == "studio" and self.radiance == 0 else self.radiance * self.scale == 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ground:
    """What the stones lie on.

    Attributes
    ----------
    type : {"none", "plane", "sweep", "cup"}
        A sweep is a plane that curves up to a wall behind the stones, as photographers' paper does. A cup
        holds each stone up to its girdle: where it is black, light that comes in through the pavilion counts
        nothing, as in Inoue's paper.
    reflectance : float
        Diffuse reflectance: 0.01 is velvet, 0.85 white paper.
    distance : float
        From the stones' middle to where a sweep's wall stands [girdle radius].
    """

    type: str = "none"
    reflectance: float = 0.5
    distance: float = 12.0

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "type", GROUNDS)
            mistakes.of(check.within, self, "reflectance", 0, 1)
            mistakes.of(check.within, self, "distance", 3, 1e3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """All that stands around the stones.

    Attributes
    ----------
    name, about : str
        What to call it, and what it is for.
    pose : {"table-up", "lying", "table-down"}
        How the stones rest; lying is on a facet of the pavilion, as a loose stone does.
    facing : float
        Azimuth that the table of a lying stone leans to, from the camera's [deg].
    gap : float
        Between stones that stand side by side [girdle radius].
    girdle : {"polished", "faceted", "bruted"}
        Finish of the stones' girdles: smooth, with a round one as it is; a round one in level facets; or
        ground and matt. A girdle that is not round has its facets in any case.
    white : str or float
        The light that is white in the picture, as a light's spectrum.
    expose_for : {"stones", "ground", "white", "light"}
        What the automatic exposure goes by: the stones; the ground, which comes out light; the ground as what
        is white, in brightness and colour, as of a product on white paper; or the light: a radiance of 1 is
        white, so that pictures of different stones can be compared.
    exposure : float
        Correction of the automatic exposure [stops].
    curve : {"linear", "filmic", "contrast", "neutral", "agx"}
        Tone curve of pictures for the screen.
    camera, lights, sky, ground
        The parts.
    setting : Setting
        What holds each of the stones. A stone in one stands table up, whether its pose is that or lying.
    things : tuple of Thing
        Meshes beside the stones.
    filters : Filters
        Polarising filters before the camera and the lights.
    source : str or None
        The file, for error messages.
    """

    name: str
    about: str = ""
    pose: str = "table-up"
    facing: float = 0.0
    gap: float = 0.4
    girdle: str = "polished"
    white: str | float = "d65"
    expose_for: str = "stones"
    exposure: float = 0.0
    curve: str = "filmic"
    camera: Camera = field(default_factory=Camera)
    lights: tuple[Light, ...] = ()
    sky: Sky = field(default_factory=Sky)
    ground: Ground = field(default_factory=Ground)
    setting: Setting = field(default_factory=Setting)
    things: tuple[Thing, ...] = ()
    filters: Filters = field(default_factory=Filters)
    source: str | None = None

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(check.one_of, self, "pose", POSES)
            mistakes.of(check.one_of, self, "girdle", GIRDLES)
            mistakes.of(check.one_of, self, "expose_for", EXPOSURES)
            mistakes.of(check.one_of, self, "curve", CURVES)
            mistakes.of(check.within, self, "facing", -360, 360)
            mistakes.of(check.within, self, "gap", 0.01, 100)
            mistakes.of(check.within, self, "exposure", -20, 20)
            mistakes.of(check.spectrum, self, "white")
        if self.ground.type == "cup" and self.pose != "table-up":
            raise InputError("must be table-up in a cup", key="pose", value=self.pose)
        if self.setting.type != "none":
            if self.pose == "table-down":
                raise InputError("must not be table-down in a setting", key="pose", value=self.pose)
            if self.ground.type == "cup":
                raise InputError("must be none in a cup", key="setting", value=self.setting.type)
        if self.sky.is_dark and not any(light.radiance > 0 for light in self.lights):
            raise InputError("needs a light or a sky with a radiance above 0", key="[[light]]")

    def grown(self, scale: float) -> Setup:
        """Return the set-up of something larger: camera, lights and ground as they are, but farther off."""
        lights = tuple(
            replace(
                light, distance=scale * light.distance, size=(scale * light.size[0], scale * light.size[1])
            )
            for light in self.lights
        )
        return replace(
            self,
            camera=replace(
                self.camera,
                **{key: scale * getattr(self.camera, key) for key in ("distance", "aperture", "focus")},
            ),
            lights=tuple(lights),
            ground=replace(self.ground, distance=scale * self.ground.distance),
        )


def load_setup(setup: str | os.PathLike[str]) -> Setup:
    """Load a set-up from a TOML file, or a bundled one by its name.

    Parameters
    ----------
    setup : str or path-like
        The file, or a name of `bundled_setups`; a file of that name wins over the bundled set-up.

    Raises
    ------
    InputError
        No such set-up, or a file that makes none.
    """
    name = os.fspath(setup)
    bundled = bundled_files("setups")
    path = Path(name)
    if name in bundled and not _is_file(path):
        path = bundled[name]
    names = ", ".join(sorted(bundled))
    if path.name == name and not name.endswith(".toml") and not _is_file(path):
        raise InputError(
            f"must be a set-up file or one of {names}{did_you_mean(name, bundled)}", key="setup", value=name
        )
    source = str(path)
    with located_at(source), Mistakes() as mistakes:
        top = parse_toml(read_lines(path, kind="set-up"), kind="set-up")
        keys = [f.name for f in fields(Setup) if f.name not in ("source", "lights", "things")]
        mistakes.of(refuse_unknown, top, [*keys, "light", "thing"])
        values: dict[str, Any] = {
            key: top[key]
            for key in ("pose", "facing", "gap", "girdle", "white", "expose_for", "exposure", "curve")
            if key in top
        }
        values["name"] = mistakes.of(text_line, top, "name", stem(path, "set-up"), 100)
        values["about"] = mistakes.of(text_line, top, "about", "", 1000, empty=True)
        before = len(mistakes.errors)
        parts = {"camera": Camera, "sky": Sky, "ground": Ground, "setting": Setting, "filters": Filters}
        for key, part in parts.items():
            if key in top:
                values[key] = mistakes.of(_part, part, top, key, mistakes)
        if (image := getattr(values.get("sky"), "image", "")) and (place := path.parent / image):
            values["sky"] = replace(values["sky"], image=str(place))
            if not _is_file(place):
                mistakes.add(InputError("no such file", key="sky.image", value=image))
        values["lights"] = mistakes.of(_lights, top.get("light", []), mistakes)
        values["things"] = mistakes.of(things_of, top.get("thing", []), path.parent, mistakes)
        if len(mistakes.errors) > before:  # other parts in their place, for the other keys to be checked
            values |= {"camera": Camera(), "sky": Sky(radiance=1.0), "ground": Ground(), "lights": ()}
            values |= {"setting": Setting(), "filters": Filters(), "things": ()}
        made = mistakes.of(Setup, **values, source=source)
    assert made is not None
    return made


def bundled_setups() -> list[str]:
    """Return the names of the set-ups that come with gemrender."""
    return sorted(bundled_files("setups"))


def _quoted(word: str) -> str:
    return f'"{word}"'


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or with a null character
        return False


def _part(part: Callable[..., Any], top: dict[str, Any], key: str, mistakes: Mistakes) -> Any:
    table = section(top, key, [f.name for f in fields(part)], mistakes=mistakes)  # type: ignore[arg-type]
    with located_at(None, key):
        return part(**table)


def _lights(tables: object, mistakes: Mistakes) -> tuple[Light, ...]:
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError("must be sections: a line [[light]] before each", key="light", value=tables)
    lights = [mistakes.of(_light, table, f"light {k}", mistakes) for k, table in enumerate(tables, start=1)]
    return tuple(light for light in lights if light is not None)


def _light(table: dict[str, Any], name: str, mistakes: Mistakes) -> Light:
    values = section({name: table}, name, [f.name for f in fields(Light)], mistakes=mistakes)
    with located_at(None, name), Mistakes() as own:
        if "shape" not in table:
            own.add(InputError(f"missing; must be one of {', '.join(LIGHTS)}", key="shape"))
        light = own.of(Light, **{"shape": LIGHTS[0], **values})
    assert light is not None
    return light

"""Set-up files: the bundled ones load, and each mistake gets one line that says what is allowed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from thorough import chosen

import gemrender
from gemrender.colorimetry import illuminant_names
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.optics import load_material
from gemrender.reading import LONGEST_LINE, MOST_BYTES
from gemrender.scene.photoreal import Gem, photoreal_scene
from gemrender.scene.setup import Camera, Ground, Light, Setup, Sky, Zone, bundled_setups, load_setup
from gemrender.scene.zones import layers

BUNDLED = [
    "arrows", "aset", "dichroscope", "fire", "hand", "hearts", "hemisphere", "ideal-scope", "loupe", "macro",
    "polariscope", "product", "studio", "sun", "velvet", "white", "window",
]  # fmt: skip
SETUPS = Path(gemrender.__file__).parent.parent / "scenes" / "setups"

SKY = "[sky]\nradiance = 1\n"
ZONES = '[sky]\ntype = "zones"\n'
LIGHT = '[[light]]\nshape = "disc"\n'
CAMERA = f"{SKY}[camera]\n"
GROUND = f"{SKY}[ground]\n"
#: No float is as large.
HUGE = f"0x{'f' * 300}"


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def write(text: str | bytes, name: str = "x.toml") -> str:
    Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return name


def refusal(setup: str) -> str:
    """The one line that a set-up is refused with."""
    with pytest.raises(InputError) as caught:
        load_setup(setup)
    line = str(caught.value)
    assert "\n" not in line
    return line


# ---- Set-ups that load ---------------------------------------------------------------------------------


def test_bundled_setups_are_named_in_order():
    assert bundled_setups() == BUNDLED


def test_a_copy_of_a_bundled_setup_finds_the_mesh_that_comes_along():
    copy = write((SETUPS / "hand.toml").read_text())
    assert Path(load_setup(copy).things[0].mesh) == SETUPS / "hand.ply"
    copy = write((SETUPS / "hand.toml").read_text().replace("hand.ply", "foot.ply"))
    assert refusal(copy) == "x.toml: thing 1.mesh = 'foot.ply': no such file"
    copy = write((SETUPS / "hand.toml").read_text().replace("hand.ply", "mine/hand.ply"))
    assert refusal(copy) == "x.toml: thing 1.mesh = 'mine/hand.ply': no such file"


@pytest.mark.parametrize("name", BUNDLED)
def test_a_bundled_setup_loads_and_names_its_source(name):
    setup = load_setup(name)
    assert setup.source == str(SETUPS / f"{name}.toml")
    assert setup.name != name  # of its own
    assert setup.about
    assert load_setup(setup.source) == setup


@pytest.mark.parametrize("stones", chosen([1, 3], [3]))  # of one there are pictures
# All of them are rendered by Mitsuba's own program, with two stones
@pytest.mark.parametrize("name", chosen(BUNDLED, ["aset", "polariscope", "white"]))
def test_a_bundled_setup_makes_a_scene(name, stones, variant_llvm_ad_spectral):
    import mitsuba as mi

    gem = Gem(
        stone=load_stone("inoue-3"), material=load_material("ruby"), material_name="ruby", diameter_mm=5.0
    )
    scene = photoreal_scene([gem] * stones, load_setup(name), width=9, height=5)
    made = mi.load_dict(scene.to_dict())
    assert tuple(made.sensors()[0].film().size()) == (9, 5)
    surfaces = [type(shape.bsdf()).__name__ for shape in made.shapes()]
    assert surfaces.count("GemDielectric") == stones
    assert len(made.emitters()) >= 1


def test_a_file_may_be_short():
    setup = load_setup(write(SKY, "Mein Licht.toml"))
    assert setup == Setup(name="Mein Licht", sky=Sky(radiance=1), source="Mein Licht.toml")


def test_every_key_arrives():
    text = """\
name = "All"
about = "Everything"
pose = "table-down"
facing = 1
gap = 2
white = "a"
exposure = -3
[camera]
type = "thin-lens"
elevation = 4
azimuth = 5
distance = 6
margin = 7
aperture = 0.8
focus = -9
[[light]]
shape = "sphere"
elevation = 10
azimuth = 11
distance = 12
size = 13
radiance = 14
spectrum = 5500
[[light]]
shape = "ring"
size = [15, 16]
count = 17
spectrum = "5500 K"
[sky]
type = "hemisphere"
radiance = 18
spectrum = "D50"
[ground]
type = "sweep"
reflectance = 0.19
distance = 20
"""
    assert load_setup(write(text)) == Setup(
        name="All",
        about="Everything",
        pose="table-down",
        facing=1,
        gap=2,
        white="a",
        exposure=-3,
        camera=Camera(type="thin-lens", elevation=4, azimuth=5, distance=6, margin=7, aperture=0.8, focus=-9),
        lights=(
            Light(
                shape="sphere",
                elevation=10,
                azimuth=11,
                distance=12,
                size=(13, 13),
                radiance=14,
                spectrum=5500,
            ),
            Light(shape="ring", size=(15, 16), count=17, spectrum="5500 K"),
        ),
        sky=Sky(type="hemisphere", radiance=18, spectrum="D50"),
        ground=Ground(type="sweep", reflectance=0.19, distance=20),
        source="x.toml",
    )


def test_zones_arrive_in_any_order_and_may_leave_gaps():
    rows = "[{ elevation = [45, 90], colour = [0, 1, 0.5], radiance = 3 }, { elevation = [-90, -10] }]"
    sky = load_setup(write(f"{ZONES}zones = {rows}")).sky
    above = Zone(elevation=(45, 90), colour=(0, 1, 0.5), radiance=3)
    below = Zone(elevation=(-90, -10), colour=(1, 1, 1), radiance=1)
    assert sky == Sky(type="zones", zones=(above, below))
    assert layers(sky.zones) == [(-90, -10, below), (-10, 45, None), (45, 90, above)]


def test_zones_may_meet():
    meeting = ", ".join(f"{{ elevation = [{low}, {low + 15}] }}" for low in range(-90, 90, 15))
    zones = load_setup(write(f"{ZONES}zones = [{meeting}]")).sky.zones
    assert [zone.elevation for zone in zones] == [(low, low + 15) for low in range(-90, 90, 15)]


def test_one_light_of_several_is_enough():
    assert len(load_setup(write(f"{LIGHT}radiance = 0\n{LIGHT}")).lights) == 2
    assert load_setup(write(LIGHT)).sky.radiance == 0


def test_a_file_wins_over_the_bundled_setup_but_a_folder_does_not():
    Path("studio").mkdir()
    assert load_setup("studio").name == "Jeweller's studio"
    write(SKY, "velvet")
    assert load_setup("velvet").source == "velvet"


def test_any_order_line_ends_and_byte_order_mark_do():
    text = f"\ufeff{LIGHT}[camera]\nelevation = 50\n".replace("\n", "\r\n")
    setup = load_setup(write(text))
    assert (setup.camera.elevation, setup.lights[0].shape) == (50, "disc")


# ---- Mistakes ------------------------------------------------------------------------------------------

_SKY_KEYS = "type, radiance, spectrum, zones, image, azimuth, scale, boxes"
_TOP = (
    "name, about, pose, facing, gap, girdle, white, expose_for, exposure, curve, camera, sky, ground, "
    "setting, filters, light, thing"
)
_OF_CAMERA = "type, elevation, azimuth, distance, margin, aperture, focus"
_OF_LIGHT = "shape, elevation, azimuth, distance, size, count, radiance, spectrum"
_SIZE = "must be one or two numbers above 0 [girdle radius]"
_COUNT = "must be a whole number from 1 to 256"
_DARK = "[[light]]: needs a light or a sky with a radiance above 0"
_SECTIONS = "must be sections: a line [[light]] before each"
_ROWS = "must be 1 to 16 rows, as { elevation = [0, 45], colour = [0, 1, 0] }"
_LIMITS = "must be two increasing numbers from -90 to 90"
_COLOUR = "must be red, green and blue, three numbers from 0 to 1"
_SPECTRUM = f"must be 1000 to 25000 [K] or one of {', '.join(illuminant_names())}"

#: Text of a file, and what it is refused with.
REFUSED = {
    # ---- The file ----
    "empty": ("", "is empty"),
    "not TOML": ("name = x\n", "is not TOML: Invalid value (at line 1, column 8)"),
    "a section twice": (SKY + SKY, "is not TOML: Cannot declare ('sky',) twice (at line 3, column 5)"),
    "Latin-1": ('name = "zoë"'.encode("latin-1"), "must be text in UTF-8; byte 11 is not"),
    "long line": (
        "#" * (LONGEST_LINE + 1),
        f"line 1: is {LONGEST_LINE + 1} characters long; at most {LONGEST_LINE} are allowed",
    ),
    "huge": ("#\n" * MOST_BYTES, f"is no set-up file: larger than {MOST_BYTES} bytes"),
    "nested": ("a = " + "[\n" * 100_000, "is not TOML that makes a set-up: nested too deeply"),
    # ---- Unknown keys ----
    "key": (f"lihgt = 1\n{SKY}", f"lihgt = 1: unknown key; must be one of {_TOP}; did you mean light?"),
    "Python's name": (
        f"lights = []\n{SKY}", f"lights = []: unknown key; must be one of {_TOP}; did you mean light?",
    ),
    "source": (f'source = "x"\n{SKY}', f"source = 'x': unknown key; must be one of {_TOP}"),
    "camera's key": (
        f"{CAMERA}elevaton = 3",
        f"camera.elevaton = 3: unknown key; must be one of {_OF_CAMERA}; did you mean elevation?",
    ),
    "light's key": (
        f"{LIGHT}sise = 3",
        f"light 1.sise = 3: unknown key; must be one of {_OF_LIGHT}; did you mean size?",
    ),
    "sky's key": (
        f'{SKY}color = "a"', f"sky.color = 'a': unknown key; must be one of {_SKY_KEYS}",
    ),
    "ground's key": (
        f"{GROUND}kind = 1", "ground.kind = 1: unknown key; must be one of type, reflectance, distance",
    ),
    # ---- No sections ----
    "camera that is text": (
        f'camera = "x"\n{SKY}',
        f"camera = 'x': must be a section: a line [camera], and below it {_OF_CAMERA}",
    ),
    "sky that is a number": (
        "sky = 1", f"sky = 1: must be a section: a line [sky], and below it {_SKY_KEYS}",
    ),
    "one light": ("[light]\nradiance = 1", f"light = {{'radiance': 1}}: {_SECTIONS}"),
    "light that is a number": (f"light = 1\n{SKY}", f"light = 1: {_SECTIONS}"),
    "lights that are numbers": (f"light = [1]\n{SKY}", f"light = [1]: {_SECTIONS}"),
    # ---- The top ----
    "name": (f"name = 3\n{SKY}", "name = 3: must be one line of 1 to 100 characters"),
    "empty name": (f'name = " "\n{SKY}', "name = ' ': must be one line of 1 to 100 characters"),
    "name of two lines": (
        f'name = "a\\nb"\n{SKY}', r"name = 'a\nb': must be one line of 1 to 100 characters",
    ),
    "about": (f"about = 3\n{SKY}", "about = 3: must be one line of at most 1000 characters"),
    "pose": (
        f'pose = "lieing"\n{SKY}',
        "pose = 'lieing': must be one of table-up, lying, table-down; did you mean lying?",
    ),
    "pose that is no text": (f"pose = []\n{SKY}", "pose = []: must be one of table-up, lying, table-down"),
    "facing": (f'facing = "n"\n{SKY}', "facing = 'n': must be a number from -360 to 360"),
    "facing that is not finite": (f"facing = nan\n{SKY}", "facing = nan: must be a number from -360 to 360"),
    "facing that is a date": (
        f"facing = 2020-01-01\n{SKY}",
        "facing = datetime.date(2020, 1, 1): must be a number from -360 to 360",
    ),
    "gap": (f"gap = -1\n{SKY}", "gap = -1: must be a number from 0.01 to 100"),
    "no gap": (f"gap = 0\n{SKY}", "gap = 0: must be a number from 0.01 to 100"),
    "gap that is no number": (f"gap = true\n{SKY}", "gap = True: must be a number from 0.01 to 100"),
    "exposure": (f"exposure = -inf\n{SKY}", "exposure = -inf: must be a number from -20 to 20"),
    "exposure beyond any float": (
        f"exposure = {HUGE}\n{SKY}",
        f"exposure = {str(int(HUGE, 16))[:59]}…: must be a number from -20 to 20",
    ),
    "white": (f'white = "d66"\n{SKY}', f"white = 'd66': {_SPECTRUM}"),
    "white that is no number": (f"white = true\n{SKY}", f"white = True: {_SPECTRUM}"),
    # ---- Polarising filters ----
    "windows without a filter": (
        f"{SKY}[filters]\nwindows = 2", "filters.windows = 2: needs an analyser, that of the left one",
    ),
    "windows": (
        f"{SKY}[filters]\nanalyser = 4\nwindows = 3", "filters.windows = 3: must be 1 or 2",
    ),
    "filter": (
        f"{SKY}[filters]\nanalyser = 400", "filters.analyser = 400: must be a number from -360 to 360",
    ),
    "filter's key": (
        f"{SKY}[filters]\nanalyzer = 4",
        "filters.analyzer = 4: unknown key; must be one of analyser, polariser, windows; did you mean "
        "analyser?",
    ),
    # ---- The camera ----
    "camera": (
        f'{CAMERA}type = "thinlens"',
        "camera.type = 'thinlens': must be one of perspective, thin-lens, orthographic; did you mean "
        "thin-lens?",
    ),
    "camera that is a list": (
        f'{CAMERA}type = ["perspective"]',
        "camera.type = ['perspective']: must be one of perspective, thin-lens, orthographic",
    ),
    "elevation": (f"{CAMERA}elevation = 91", "camera.elevation = 91: must be a number from -90 to 90"),
    "azimuth": (f"{CAMERA}azimuth = nan", "camera.azimuth = nan: must be a number from -360 to 360"),
    "distance": (f"{CAMERA}distance = -1", "camera.distance = -1: must be a number from 0.1 to 10000"),
    "no distance": (
        f"{CAMERA}distance = 0\nfocus = -1", "camera.distance = 0: must be a number from 0.1 to 10000",
    ),
    "margin": (f"{CAMERA}margin = 0", "camera.margin = 0: must be a number from 0.05 to 100"),
    "aperture": (f"{CAMERA}aperture = -0.1", "camera.aperture = -0.1: must be a number from 0 to 100"),
    "f-number": (f'{CAMERA}aperture = "f/8"', "camera.aperture = 'f/8': must be a number from 0 to 100"),
    "lens without an aperture": (
        f'{CAMERA}type = "thin-lens"', "camera.aperture = 0.0: must be above 0 for a thin lens",
    ),
    "focus in the camera": (
        f"{CAMERA}distance = 15\nfocus = 15", "camera.focus = 15: must be less than the distance",
    ),
    "focus behind the camera": (f"{CAMERA}focus = 99", "camera.focus = 99: must be less than the distance"),
    # ---- Lights ----
    "no shape": (
        "[[light]]\nradiance = 1", "light 1.shape: missing; must be one of rectangle, disc, ring, sphere",
    ),
    "shape": (
        '[[light]]\nshape = "rectangel"',
        "light 1.shape = 'rectangel': must be one of rectangle, disc, ring, sphere; did you mean rectangle?",
    ),
    "the second light": (
        f"{LIGHT}{LIGHT}radiance = -1", "light 2.radiance = -1: must be a number from 0 to 1e+09",
    ),
    "radiance": (
        f'{LIGHT}radiance = "bright"', "light 1.radiance = 'bright': must be a number from 0 to 1e+09",
    ),
    "light's distance": (f"{LIGHT}distance = 0", "light 1.distance = 0: must be a number from 0.1 to 10000"),
    "light's elevation": (
        f"{LIGHT}elevation = -91", "light 1.elevation = -91: must be a number from -90 to 90",
    ),
    "negative size": (f"{LIGHT}size = -1", f"light 1.size = -1: {_SIZE}"),
    "no size": (f"{LIGHT}size = [1, 0]", f"light 1.size = [1, 0]: {_SIZE}"),
    "three sizes": (f"{LIGHT}size = [1, 2, 3]", f"light 1.size = [1, 2, 3]: {_SIZE}"),
    "size that is no number": (f"{LIGHT}size = [true, 1]", f"light 1.size = [True, 1]: {_SIZE}"),
    "size that is text": (f'{LIGHT}size = "wide"', f"light 1.size = 'wide': {_SIZE}"),
    "size that is not finite": (f"{LIGHT}size = nan", f"light 1.size = nan: {_SIZE}"),
    "count": (f"{LIGHT}count = 0", f"light 1.count = 0: {_COUNT}"),
    "half a diode": (f"{LIGHT}count = 1.5", f"light 1.count = 1.5: {_COUNT}"),
    "spectrum": (f'{LIGHT}spectrum = "candle"', f"light 1.spectrum = 'candle': {_SPECTRUM}"),
    "hot": (f"{LIGHT}spectrum = 99999", f"light 1.spectrum = 99999: {_SPECTRUM}"),
    "spectrum that is a list": (f"{LIGHT}spectrum = [1]", f"light 1.spectrum = [1]: {_SPECTRUM}"),
    # ---- Sky and ground ----
    "sky": (
        '[sky]\ntype = "dome"',
        "sky.type = 'dome': must be one of uniform, hemisphere, zones, image, studio",
    ),
    "sky's radiance": ("[sky]\nradiance = inf", "sky.radiance = inf: must be a number from 0 to 1e+09"),
    "sky's spectrum": (f"{SKY}spectrum = nan", f"sky.spectrum = nan: {_SPECTRUM}"),
    # ---- Zones ----
    "no zones": (ZONES, f"sky.zones: missing; {_ROWS}"),
    "no rows": (f"{ZONES}zones = []", f"sky.zones = []: {_ROWS}"),
    "zones that are numbers": (f"{ZONES}zones = [[0, 45]]", f"sky.zones = [[0, 45]]: {_ROWS}"),
    "a number of zones": (f"{ZONES}zones = 3", f"sky.zones = 3: {_ROWS}"),
    "too many zones": (
        f"{ZONES}zones = [{', '.join(['{}'] * 17)}]",
        f"sky.zones = [{', '.join(['{}'] * 14)}, {{}}…: {_ROWS}",
    ),
    "zone without limits": (
        f"{ZONES}zones = [{{ radiance = 1 }}]",
        "sky.zones 1.elevation: missing; must be two increasing numbers from -90 to 90",
    ),
    "zone's key": (
        f"{ZONES}zones = [{{ elevation = [0, 9], color = 1 }}]",
        "sky.zones 1.color = 1: unknown key; must be one of elevation, colour, radiance; did you mean "
        "colour?",
    ),
    "limits the wrong way round": (
        f"{ZONES}zones = [{{ elevation = [45, 0] }}]", f"sky.zones 1.elevation = [45, 0]: {_LIMITS}",
    ),
    "one limit": (f"{ZONES}zones = [{{ elevation = 45 }}]", f"sky.zones 1.elevation = 45: {_LIMITS}"),
    "limit that is no number": (
        f"{ZONES}zones = [{{ elevation = [0, nan] }}]", f"sky.zones 1.elevation = [0, nan]: {_LIMITS}",
    ),
    "limit beyond the zenith": (
        f"{ZONES}zones = [{{ elevation = [0, 91] }}]", f"sky.zones 1.elevation = [0, 91]: {_LIMITS}",
    ),
    "the second zone's colour": (
        f"{ZONES}zones = [{{ elevation = [0, 9] }}, {{ elevation = [9, 10], colour = [0, 255, 0] }}]",
        f"sky.zones 2.colour = [0, 255, 0]: {_COLOUR}",
    ),
    "colour in words": (
        f'{ZONES}zones = [{{ elevation = [0, 9], colour = "red" }}]',
        f"sky.zones 1.colour = 'red': {_COLOUR}",
    ),
    "zone's radiance": (
        f"{ZONES}zones = [{{ elevation = [0, 9], radiance = -1 }}]",
        "sky.zones 1.radiance = -1: must be a number from 0 to 1e+09",
    ),
    "zones that overlap": (
        f"{ZONES}zones = [{{ elevation = [0, 45] }}, {{ elevation = [40, 90] }}]",
        "sky.zones 2.elevation = [40.0, 90.0]: must not overlap another zone's, [0.0, 45.0]",
    ),
    "zones under a hemisphere": (
        f'{SKY}type = "hemisphere"\nzones = 1', 'sky.zones = 1: are for type = "zones"',
    ),
    "radiance of zones": (
        f"{ZONES}radiance = 2\nzones = [{{ elevation = [0, 9] }}]",
        "sky.radiance = 2: not allowed here, zones have colours and radiances of their own",
    ),
    "spectrum of zones": (
        f'{ZONES}spectrum = "a"\nzones = [{{ elevation = [0, 9] }}]',
        "sky.spectrum = 'a': not allowed here, zones have colours and radiances of their own",
    ),
    "ground": (f'{GROUND}type = "floor"', "ground.type = 'floor': must be one of none, plane, sweep, cup"),
    "reflectance": (f"{GROUND}reflectance = 1.2", "ground.reflectance = 1.2: must be a number from 0 to 1"),
    "wall": (f"{GROUND}distance = 1", "ground.distance = 1: must be a number from 3 to 1000"),
    # ---- No light ----
    "dark": ('name = "Cellar"', _DARK),
    "dark light": (f"{LIGHT}radiance = 0", _DARK),
    "black zone": (f"{ZONES}zones = [{{ elevation = [0, 9], colour = [0, 0, 0] }}]", _DARK),
    "dark zone": (f"{ZONES}zones = [{{ elevation = [0, 9], radiance = 0 }}]", _DARK),
    "dark sky": ("[sky]\nradiance = 0.0", _DARK),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_bad_file_is_told_in_one_line(case):
    text, line = REFUSED[case]
    assert refusal(write(text)) == f"x.toml: {line}"


@pytest.mark.parametrize("key", ["facing", "gap", "exposure"])
@pytest.mark.parametrize("value", ['"1"', "nan", "inf", "1e999", HUGE, "true", "[]", "{}"])
def test_numbers_of_the_top_are_finite_numbers(key, value):
    assert refusal(write(f"{key} = {value}\n{SKY}")).startswith(f"x.toml: {key} = ")


@pytest.mark.parametrize(
    "key",
    [f"[camera] {key}" for key in ("elevation", "azimuth", "distance", "margin", "aperture", "focus")]
    + [f"[[light]] {key}" for key in ("elevation", "azimuth", "distance", "size", "count", "radiance")]
    + ["[sky] radiance", "[ground] reflectance", "[ground] distance"],
)
@pytest.mark.parametrize("value", ['"1"', "nan", "inf", "1e999", HUGE, "true", "[]", "{}"])
def test_numbers_of_the_parts_are_finite_numbers(key, value):
    section, key = key.split()
    head = {"[[light]]": LIGHT, "[sky]": "[sky]\n", "[camera]": CAMERA, "[ground]": GROUND}[section]
    told = {"[[light]]": "light 1"}.get(section, section.strip("[]"))
    assert refusal(write(f"{head}{key} = {value}\n")).startswith(f"x.toml: {told}.{key} = ")


# ---- Names and paths -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("studo", "; did you mean studio?"),
        ("Velvet", "; did you mean velvet?"),
        ("moonlight", ""),
        ("", ""),
        (" ", ""),
        ("\0", ""),
    ],
)
def test_an_unknown_name_lists_the_bundled_setups(name, hint):
    listed = f"must be a set-up file or one of {', '.join(BUNDLED)}{hint}"
    assert refusal(name) == f"setup = {name!r}: {listed}"


def test_a_missing_file_is_told():
    assert refusal("nope.toml") == "nope.toml: no such file"
    assert refusal("there/studio") == "there/studio: no such file"


def test_a_folder_is_no_setup():
    Path("x.toml").mkdir()
    assert refusal("x.toml").startswith("x.toml: cannot be read (")


@pytest.mark.parametrize("name", ["a\0.toml", "a" * 5000, "x/" * 3000, "a" * 5000 + ".toml"])
def test_a_path_that_no_file_can_have(name):
    assert refusal(name)


# ---- What does not come from a file --------------------------------------------------------------------


def test_parts_made_in_python_are_checked_too():
    for make, part in [
        (lambda: Camera(type="pinhole"), "type = 'pinhole': must be one of perspective, "),
        (lambda: Camera(distance=2, focus=3), "focus = 3: must be less than the distance"),
        (lambda: Light(shape="disc", size=(1, -1)), "size = (1, -1): must be one or two numbers above 0"),
        (lambda: Sky(spectrum="x"), "spectrum = 'x': must be 1000 to 25000 [K] or one of "),
        (lambda: Setup(name="x"), "[[light]]: needs a light or a sky"),
    ]:
        with pytest.raises(InputError) as caught:
            make()
        assert str(caught.value).startswith(part)


# ---- Sense ---------------------------------------------------------------------------------------------

WHOLE = 'name = "A"\n[sky]\nradiance = 1\n'


def scene_of(path, stones=1):
    from gemrender.cuts import load_stone
    from gemrender.render.backend import ensure_variant
    from gemrender.render.photoreal import make_gems
    from gemrender.scene.photoreal import photoreal_scene

    ensure_variant("llvm_ad_spectral")
    gems = make_gems([load_stone("inoue-3")] * stones)
    return photoreal_scene(gems, load_setup(path), width=16, height=16)


def test_a_cup_holds_stones_table_up_only(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text('pose = "lying"\n' + WHOLE + '[ground]\ntype = "cup"\n')
    with pytest.raises(InputError, match=r"pose = 'lying': must be table-up in a cup$"):
        load_setup(path)


def test_a_camera_under_the_ground_is_refused(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(WHOLE + '[ground]\ntype = "plane"\n[camera]\nelevation = -20\n')
    with pytest.raises(InputError, match=r"camera.elevation = -20: must be such that the camera is above"):
        scene_of(path)


def test_a_light_among_the_stones_is_refused(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(WHOLE + '[[light]]\nshape = "sphere"\nelevation = 0\ndistance = 1.2\nsize = 1\n')
    with pytest.raises(InputError, match=r"light 1.distance = 1.2: too near: the stones reach 1\.?"):
        scene_of(path)


def test_a_row_of_stones_that_reaches_its_lights_gets_the_same_setup_larger(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(WHOLE + '[[light]]\nshape = "sphere"\nelevation = 0\ndistance = 4\nsize = 1\n')
    near, far = (scene_of(path, stones=number).plain["light_1"] for number in (1, 5))
    grown = far["radius"] / near["radius"]
    assert grown == pytest.approx(1.25**3)
    assert np.hypot(*far["center"][:2]) == pytest.approx(grown * np.hypot(*near["center"][:2]))


def test_a_sweep_bends_up_beyond_any_row_of_stones():
    scene = scene_of("white", stones=9)
    measures = scene.built["ground"][0].keywords
    reach = max(np.hypot(*stone.points()[:, :2].T).max() for stone in scene.stones)
    assert measures["wall"] - measures["bend"] >= reach

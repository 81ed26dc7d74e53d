"""`gemrender render` and `gemrender scene --setup`: what they refuse, in one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from render_help import (
    SMALL,
)

from gemrender.render import photoreal

RENDER = "render inoue-3 -o a.png"

SCENE = "scene inoue-3 --out s"

BAD_INPUT = {
    "render": "STONE: missing: stone files (.toml, .csv, .asc, ",
    "render inoue-3": "--out: missing: picture or film to write, or the folder for it: .png, ",
    "render inoue-9 -o a.png": "inoue-9: no such file, and no bundled stone (see: gemrender stones); ",
    "render inoue-3 -o a.bmp": "--out = 'a.bmp': must end in .png, .jpg, .jpeg, .webp, .exr, .mp4",
    "render inoue-3 -o a": "--out = 'a': must end in .png, .jpg, .jpeg, .webp, .exr, .mp4",
    "render inoue-3 -o text.txt/a.png": "--out = 'text.txt': must be a folder that can be written: is a file",
    "render inoue-3 -o /proc/a.png": "--out = '/proc': must be a folder that can be written: ",
    f"{RENDER} --material unobtainium": "--material = 'unobtainium': must be one of alexandrite, ",
    f"{RENDER} --material no.toml": "no.toml: no such file",
    "render odd.toml -o a.png": "odd.toml: material.name = 'unobtainium': must be one of alexandrite, ",
    f"{RENDER} --setup studoi": "--setup = 'studoi': must be a set-up file or one of arrows, ",
    f"{RENDER} --setup no.toml": "no.toml: no such file",
    f"{RENDER} --setup dark.toml": "dark.toml: [[light]]: needs a light or a sky with a radiance above 0",
    f"{RENDER} --setup near.toml": "near.toml: camera.distance = 0.3: is too near to see Inoue sample 3 ",
    f"{RENDER} --curve log": "--curve = 'log': must be one of linear, filmic, contrast, neutral, agx",
    f"{RENDER} --size 0": "--size = '0': must be a number of pixels or two, as 1024 or 1600x900, from 1 to ",
    f"{RENDER} --size -5": "--size = '-5': must be a number of pixels or two",
    f"{RENDER} --size 70000": "--size = '70000': must be a number of pixels or two",
    f"{RENDER} --size 12x": "--size = '12x': must be a number of pixels or two",
    f"{RENDER} --size 12x0": "--size = '12x0': must be a number of pixels or two",
    f"{RENDER} --size 1x2x3": "--size = '1x2x3': must be a number of pixels or two",
    f"{RENDER} --size 1{'0' * 9999}": f"--size = '1{'0' * 57}…: must be a number of pixels or two",
    f"{RENDER} --spp 0": "--spp = 0: must be from 1 to 16777216",
    f"{RENDER} --spp many": "--spp = 'many': must be a whole number",
    f"{RENDER} --noise 0": "--noise = 0.0: must be from 0.00001 to 1",
    f"{RENDER} --noise nan": "--noise = 'nan': must be a finite number",
    f"{RENDER} --time 0": "--time = 0.0: must be above 0 [s]",
    f"{RENDER} --time -1": "--time = -1.0: must be above 0 [s]",
    f"{RENDER} --seed -1": "--seed = -1: must be from 0 to 1073741823",
    f"{RENDER} --seed x": "--seed = 'x': must be a whole number",
    f"{RENDER} --carat 0": "--carat = 0.0: must be a finite number above 0",
    f"{RENDER} --carat heavy": "--carat = 'heavy': must be a finite number of carats",
    f"{RENDER} --diameter 0": "--diameter = 0.0: must be from 0.1 to 1000 [mm]",
    f"{RENDER} --carat 1 --diameter 6": "--carat = 1.0: give a weight or a diameter, not both",
    f"{RENDER} --carat 1 --material glass.toml": "--carat = 1.0: needs the material's density",
    f"{RENDER} --exposure 21": "--exposure = 21.0: must be from -20 to 20",
    f"{RENDER} --exposure x": "--exposure = 'x': must be a finite number of stops",
    f"{RENDER} --turn x": "--turn = 'x': must be a finite number of degrees",
    f"{RENDER} --bins 8": "--bins = 8: go into EXR pictures only",
    "render inoue-3 -o a.exr --bins 0": "--bins = 0: must be from 1 to 200",
    "render inoue-3 -o a.exr --bins x": "--bins = 'x': must be a whole number",
    "render inoue-3 -o a.exr --bins 8 --range 900,300": "--range = '900,300': must be two increasing ",
    "render inoue-3 -o a.exr --bins 8 --range 300,900": "--range = '300,900': must be two increasing ",
    "render inoue-3 -o a.exr --bins 8 --range 500": "--range = '500': must be two wavelengths, as 380,760",
    "render inoue-3 -o a.exr --bins 8 --range 500,": "--range = '500,': must be two wavelengths, as 380,760",
    f"{RENDER} --frames 9": "--frames = 9: go with a film, a file that ends in .mp4",
    "render inoue-3 -o x.mp4": "--frames: missing: a film needs a number of frames",
    "render inoue-3 -o x.mp4 --frames 1": "--frames = 1: must be from 2 to 100000",
    "render inoue-3 -o x.mp4 --frames x": "--frames = 'x': must be a whole number",
    "render inoue-3 -o x.mp4 --frames 3 --fps 0": "--fps = 0.0: must be from 1 to 240 [frames a second]",
    "render inoue-3 -o x.mp4 --frames 3 --size 15": "--size = '15x15': must be even for a film",
    "render inoue-3 -o x.mp4 --frames 3 --bins 8": "--bins = 8: go into EXR pictures only",
    "render inoue-3 -o x.mp4 --frames 3 --turn 8": "--turn = 8.0: is for still pictures only",
    f"{RENDER} --aspect wide": "--aspect = 'wide': must be width to height, as 4:5 or 9:16, from 1:10 to ",
    f"{RENDER} --aspect 4:5 --size 30x20": "--aspect = '4:5': goes with one side; ",
    f"{RENDER} --aspect 1:2 --size 9000": "--size = '9000': must be such that the longer side is up to ",
    f"{RENDER} --move rock": "--move = 'rock': is of films; give a number of --frames, too",
    f"{RENDER} --to 20": "--to = 20.0: is of ",
    "render inoue-3 -o x.mp4 --frames 3 --move spin": "--move = 'spin': must be one of turntable, rock, tilt",
    "render inoue-3 -o x.mp4 --frames 3 --to 20": "--to = 20.0: is of rock and tilt; ",
    "render inoue-3 -o x.mp4 --frames 3 --move rock --to 0": "--to = 0.0: must be above 0 and up to 90",
    "render inoue-3 -o x.mp4 --frames 3 --move rock --to x": "--to = 'x': must be a finite number of degrees",
    "render inoue-3 -o x.mp4 --frames 3 --move tilt --setup hemisphere": "--move = 'tilt': must be ",
    f"{RENDER} --variant llvm_ad_rgb": "--variant = 'llvm_ad_rgb': must be a spectral variant, ",
    f"{RENDER} --variant spectral": "--variant = 'spectral': must be a spectral variant, ",
    f"{RENDER} --variant x_spectral": "--variant = 'x_spectral': must be one of llvm_ad_rgb, ",
    # ---- Scenes ----
    f"{SCENE} --setup studoi": "--setup = 'studoi': must be a set-up file or one of arrows, ",
    f"{SCENE} --setup near.toml": "near.toml: camera.distance = 0.3: is too near to see ",
    f"{SCENE} --setup studio --resolution 9": "--resolution: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --resolution 1024": "--resolution: is for the scored scene only, not with ",
    f"{SCENE} --setup studio --fresnel exact": "--fresnel: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --rear position": "--rear: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --intensity primary": "--intensity: is for the scored scene only, not with ",
    f"{SCENE} --setup studio --tilt 0": "--tilt: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --tilt-azimuth 0": "--tilt-azimuth: is for the scored scene only, not with ",
    f"{SCENE} --stock": "--stock: is for a picture's scene only, with --setup",
    f"{SCENE} --carat 1": "--carat: is for a picture's scene only, with --setup",
    f"{SCENE} --diameter 6": "--diameter: is for a picture's scene only, with --setup",
    f"{SCENE} --size 16": "--size: is for a picture's scene only, with --setup",
    f"{SCENE} --spp 16": "--spp: is for a picture's scene only, with --setup",
    f"{SCENE} --setup studio --material x": "--material = 'x': must be one of alexandrite, ",
    f"{SCENE} --setup studio --carat x": "--carat = 'x': must be a finite number of carats",
    f"{SCENE} --setup studio --size 0": "--size = '0': must be a number of pixels or two",
    f"{SCENE} --setup studio --spp 0": "--spp = 0: must be from 1 to 16777216",
    f"{SCENE} --setup studio --variant scalar_rgb": "--variant = 'scalar_rgb': scalar variants are refused",
    "scene inoue-3 --setup studio --out text.txt": "--out = 'text.txt': must be a folder that can be written",
}


@pytest.mark.parametrize(("line", "words"), BAD_INPUT.items(), ids=[line[:70] for line in BAD_INPUT])
def test_bad_input_is_one_line_that_says_what_is_allowed(line, words, gemrender, folder):
    Path("text.txt").write_text("text")
    Path("dark.toml").write_text('name = "Cellar"\n')
    Path("near.toml").write_text("[sky]\nradiance = 1\n[camera]\ndistance = 0.3\n")
    Path("glass.toml").write_text("[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n")
    shape = "table = 54\nstar = 57\nlower_girdle_contact = 20\ncrown_height = 15\npavilion_depth = 43\n"
    Path("odd.toml").write_text(
        f'[proportions]\n{shape}girdle_thickness = 3\n[material]\nname = "unobtainium"\n'
    )
    before = sorted(folder.rglob("*"))

    status, out, err = gemrender(*line.split())

    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert err.startswith(f"gemrender: {words}")
    assert sorted(folder.rglob("*")) == before  # nothing is written, no folder made


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_folder_that_may_not_be_written_is_told_before_any_work(name, gemrender, folder, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    status, out, err = gemrender("render", "inoue-3", "-o", name, *SMALL)
    assert (status, out) == (2, "")
    assert err == "gemrender: --out = '.': must be a folder that can be written: Permission denied\n"


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_full_disk_is_one_line_and_leaves_what_was_there(name, gemrender, folder, monkeypatch):
    Path(name).write_bytes(b"before")

    def full(self, path, *_, **__):
        Path(str(path)).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("PIL.Image.Image.save", full)
    monkeypatch.setattr("OpenEXR.File.write", full)
    status, out, err = gemrender("render", "inoue-3", "-o", name, *SMALL)
    assert (status, out, err) == (2, "", f"gemrender: {name}: cannot be written: No space left on device\n")
    assert [path.read_bytes() for path in folder.iterdir()] == [b"before"]

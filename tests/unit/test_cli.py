"""The command line: bad input is one line and exit status 2, results are the contract's, stops are clean."""

from __future__ import annotations

import json
import math
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from observations import ROOT, environment, run_gemrender, run_python
from solids import bent_stone
from thorough import chosen

import gemrender
from gemrender import crosscheck, load_stone, sensitivity
from gemrender.cli import output
from gemrender.cuts import bundled_stones
from gemrender.cuts.files import save_vertices
from gemrender.optics import load_material
from gemrender.optics.dispersion import SODIUM_NM

#: A map that the reference traces in an instant.
FAST = ["--engine", "reference", "--resolution", "16"]
#: Time that an interrupted trace may take to stop [s]: the blocks under way are finished, which takes 1.3 s
#: on two free processors.
STOPS_WITHIN = 20.0

STONE_FILE = """\
name = {name}
[proportions]
table = 54.00
star = 57.0
lower_girdle_contact = 20.0
crown_height = 15.70
pavilion_depth = 43.08
girdle_thickness = 2.50
"""
SAPPHIRE = '[material]\nname = "sapphire"\n'


def stone_file(path, name="a stone", more=""):
    text = STONE_FILE.format(name=json.dumps(name, ensure_ascii=False)) + more
    Path(path).write_text(text, encoding="utf-8")


def names(folder):
    return {path.name for path in Path(folder).iterdir()}


# ---- Bad input -----------------------------------------------------------------------------------------

SCORE = "score inoue-1"
BAD_INPUT = {
    "": "COMMAND: missing: one of score, compare, ",
    "scor inoue-1": "COMMAND = 'scor': must be one of score, compare, ",
    "--frob": "--frob: unknown option; must be one of --version, --help",
    # ---- Stones ----
    "score": "STONE: missing: stone files (.toml, .csv, .asc, ",
    "scene --out x": "STONE: missing: stone files (.toml, .csv, .asc, ",
    "crosscheck": "STONE: missing: name stones, or ask for some by --random",
    "score inoue-9": "inoue-9: no such file, and no bundled stone (see: gemrender stones); ",
    "score inoue-1 inoue-9 --out x": "inoue-9: no such file, and ",
    "score .": ".: cannot be read (Is a directory)",
    "score text.toml": "text.toml: ",
    "score table.toml": "table.toml: proportions.table = 'wide': must be a number",
    "score short.csv": "short.csv: 1 rows: must be 57: ",
    # ---- Options ----
    f"{SCORE} --resoluton 9": "--resoluton: unknown option; must be one of --set, --engine, --variant, ",
    f"{SCORE} --resolution": "--resolution: requires an argument",
    f"{SCORE} --json=3": "--json: does not take a value",
    "stones inoue-1": "stones: got unexpected extra argument",
    "scene inoue-1": "--out: missing: where to write the XML and PLY files",
    # ---- Their values ----
    f"{SCORE} --engine mitsubishi": "--engine = 'mitsubishi': must be one of auto, exact, mitsuba, reference",
    f"{SCORE} --engine magic --out x": "--engine = 'magic': must be one of auto, exact, mitsuba, reference",
    f"{SCORE} --variant mono --out x": "--variant = 'mono': must be one of llvm_ad_rgb, llvm_ad_mono, ",
    f"{SCORE} --variant mono --engine reference": "--variant = 'mono': must be one of llvm_ad_rgb, ",
    f"{SCORE} --variant scalar_rgb": "--variant = 'scalar_rgb': must be one of llvm_ad_rgb, ",
    "scene inoue-1 --variant scalar_rgb --out x": "--variant = 'scalar_rgb': scalar variants are refused, ",
    f"{SCORE} --bound x": "--bound = 'x': must be a finite number of per cent",
    f"{SCORE} --bound 0": "--bound = 0.0: must be from 0.0001 to 10 [%]",
    f"{SCORE} --engine exact --bound -1": "--bound = -1.0: must be from 0.0001 to 10 [%]",
    "score hollow.csv --engine exact": "hollow.csv: is not convex; the exact engine traces convex stones",
    "sensitivity": "STONE: missing: stone files (.toml, .csv, .asc, ",
    "sensitivity hollow.csv": "hollow.csv: has no proportions to differentiate by",
    "sensitivity inoue-1 hollow.csv --out x": "hollow.csv: has no proportions to differentiate by",
    "sensitivity inoue-1 --bound x": "--bound = 'x': must be a finite number of per cent",
    "sensitivity inoue-1 --bound 0": "--bound = 0.0: must be from 0.0001 to 10 [%]",
    "sensitivity inoue-1 --measures facets": "--measures = 'facets': cannot be differentiated: its values ",
    "sensitivity inoue-1 --measures sparkle": "--measures = 'sparkle': must be one of inoue, iso, ",
    "sensitivity inoue-1 --reach 1": "--reach: is of cliffs; add --cliffs",
    "sensitivity inoue-1 --cliffs --reach 0": "--reach = 0.0: must be a number above 0",
    "sensitivity inoue-1 --cliffs --threshold -1": "--threshold = -1.0: must be a number above 0",
    "sensitivity inoue-1 --cliffs --measures dispersion": "--measures = 'dispersion': must have values ",
    "sensitivity inoue-1 --out text.toml": "--out = 'text.toml': must be a folder that can be written",
    "crosscheck inoue-1 --variant mono": "--variant = 'mono': must be one of llvm_ad_rgb, llvm_ad_mono, ",
    "scene inoue-1 --variant mono --out x": "--variant = 'mono': must be one of llvm_ad_rgb, ",
    f"{SCORE} --resolution x": "--resolution = 'x': must be a whole number, such as 1024",
    f"{SCORE} --resolution 1.5": "--resolution = '1.5': must be a whole number, such as 1024",
    f"{SCORE} --resolution nan": "--resolution = 'nan': must be a whole number, such as 1024",
    f"{SCORE} --resolution 0": "--resolution = 0: must be from 1 to 16384 pixels a side",
    f"{SCORE} --resolution -3": "--resolution = -3: must be from 1 to 16384 pixels a side",
    f"{SCORE} --resolution 16385": "--resolution = 16385: must be from 1 to 16384 pixels a side",
    f"{SCORE} --resolution 1{'0' * 99}": f"--resolution = 1{'0' * 58}…: must be from 1 to 16384",
    f"{SCORE} --resolution 1{'0' * 9999}": f"--resolution = '1{'0' * 57}…: must be a whole number",
    f"{SCORE} --resolution 2 --tilt 85 --engine reference": "--resolution = 2: must be larger, no ray met",
    f"{SCORE} --tilt x": "--tilt = 'x': must be a finite number of degrees",
    f"{SCORE} --tilt nan": "--tilt = 'nan': must be a finite number of degrees",
    f"{SCORE} --tilt inf": "--tilt = 'inf': must be a finite number of degrees",
    f"{SCORE} --tilt 90": "--tilt = 90.0: must be from 0 to below 90",
    f"{SCORE} --tilt -1": "--tilt = -1.0: must be from 0 to below 90",
    f"{SCORE} --tilt-azimuth nan": "--tilt-azimuth = 'nan': must be a finite number of degrees",
    f"{SCORE} --tilt-azimuth 1e999": "--tilt-azimuth = '1e999': must be a finite number of degrees",
    f"{SCORE} --fresnel table": "--fresnel = 'table': must be one of gubelin, exact",
    f"{SCORE} --rear below": "--rear = 'below': must be one of position, facet, direction",
    f"{SCORE} --intensity bright": "--intensity = 'bright': must be one of primary, radiance",
    "score inoue-1 sapphire.toml --fresnel gubelin": "--fresnel = 'gubelin': Gübelin's table holds for "
    "diamond (index 2.4173) only",
    "crosscheck --random x": "--random = 'x': must be a whole number",
    "crosscheck --random -1": "--random = -1: must be from 0 to 100000",
    "crosscheck --random 1e9": "--random = '1e9': must be a whole number",
    "crosscheck --random 1000000": "--random = 1000000: must be from 0 to 100000",
    "crosscheck --random 1 --seed x": "--seed = 'x': must be a whole number",
    "crosscheck --random 1 --seed -1": "--seed = -1: must not be negative",
    # ---- Where to write ----
    f"{SCORE} --out text.toml": "--out = 'text.toml': must be a folder that can be written: is a file",
    f"{SCORE} --out text.toml/x": "--out = 'text.toml/x': must be a folder that can be written: Not a dir",
    f"{SCORE} --out /proc/x": "--out = '/proc/x': must be a folder that can be written: ",
    "scene x --setup studio --stock --birefringence --out x": "--birefringence = True: is not for --stock",
    "crosscheck inoue-1 --birefringence --resolution 0": "--resolution = 0: must be from 1 to 16384",
    "scene inoue-1 --out text.toml": "--out = 'text.toml': must be a folder that can be written: is a file",
}
#: The same, where an argument is empty or holds spaces.
BAD_ARGUMENTS = [
    (["score", ""], "STONE = '': must be a stone file or a bundled stone (see: "),
    (["score", "inoue-1", "--out", ""], "--out = '': must be a folder that can be written: has no name"),
    (["score", "inoue-1", "--engine", ""], "--engine = '': must be one of auto, exact, mitsuba, reference"),
    (["score", "inoue-1", "--variant", ""], "--variant = '': must be one of llvm_ad_rgb, "),
    (["score", "inoue-1", "--tilt", ""], "--tilt = '': must be a finite number of degrees"),
    (
        ["score", "a\nb\x1b[31m"],
        "a b\ufffd[31m: no such file, and ",
    ),  # no second line, no commands to a terminal
    (["score", "inoue-1", "--out", "\udcff"], "--out = '\\udcff': must be a folder that can be written: "),
]
TABLE = [(line.split(), words) for line, words in BAD_INPUT.items()] + BAD_ARGUMENTS


@pytest.mark.parametrize(
    ("arguments", "words"), TABLE, ids=[ascii(" ".join(arguments))[1:60] for arguments, _ in TABLE]
)
def test_bad_input_is_one_line_that_says_what_is_allowed(arguments, words, folder, gemrender):
    Path("text.toml").write_text("no TOML")
    Path("table.toml").write_text(STONE_FILE.format(name='"x"').replace("54.00", '"wide"'))
    Path("short.csv").write_text("culet, 0, 0, -1\n")
    if "hollow.csv" in arguments:
        save_vertices(bent_stone(0.003), "hollow.csv")
    stone_file("sapphire.toml", more=SAPPHIRE)
    before = sorted(folder.rglob("*"))

    status, out, err = gemrender(*arguments)

    assert status == 2
    assert err.count("\n") == 1
    assert err.startswith(f"gemrender: {words}")
    assert out == "" or not arguments  # without a command, help comes first
    assert sorted(folder.rglob("*")) == before  # nothing is written, no folder made


@pytest.mark.parametrize(
    ("slip", "meant"),
    [
        ("scor inoue-1", "score"),
        (f"{SCORE} --resoluton 9", "--resolution"),
        ("score inoue3", "inoue-3, inoue-2 or inoue-1"),
    ],
)
def test_a_slip_is_answered_with_what_was_meant(slip, meant, gemrender):
    assert gemrender(*slip.split())[2].endswith(f"; did you mean {meant}?\n")


def test_bad_input_with_json_leaves_stdout_empty(gemrender):
    assert gemrender("score", "inoue-1", "--json", "--tilt", "x")[1] == ""


def test_a_damaged_file_among_good_ones_stops_before_any_work(folder, gemrender):
    Path("bad.toml").write_text("[proportions]\n")
    status, out, err = gemrender("score", "inoue-1", "bad.toml", *FAST, "--out", "maps", "--json")
    assert (status, out) == (2, "")
    assert err.startswith("gemrender: bad.toml: [proportions]: missing table, ")
    assert not Path("maps").exists()


# ---- Results -------------------------------------------------------------------------------------------


def test_json_is_the_contract(gemrender):
    status, out, err = gemrender("score", "inoue-3", "inoue-1", *FAST, "--json")
    assert (status, err) == (0, "")
    first, second = json.loads(out)
    assert (first["name"], second["name"]) == ("Inoue sample 3", "Inoue sample 1")
    assert list(first)[:5] == ["name", "average", "rear", "bands", "trapped"]
    assert list(first)[5:10] == ["engine", "variant", "resolution", "fresnel", "seconds"]
    assert (first["engine"], first["resolution"], first["fresnel"]) == ("reference", 16, "gubelin")
    assert [(band["from"], band["to"]) for band in first["bands"]] == [
        (75, None), (60, 75), (45, 60), (30, 45), (15, 30), (0, 15),
    ]  # fmt: skip
    numbers = [first[key] for key in ("average", "rear", "trapped", "seconds")]
    assert all(isinstance(number, float) for number in numbers + [band["share"] for band in first["bands"]])


def test_json_of_mitsuba_names_its_variant(gemrender, variant_llvm_ad_mono):
    (score,) = json.loads(
        gemrender("score", "inoue-3", "--engine", "mitsuba", "--resolution", "64", "--json")[1]
    )
    assert (score["engine"], score["variant"]) == ("mitsuba", "llvm_ad_mono")


def test_options_reach_the_tracer(gemrender):
    view = ["--tilt", "10", "--tilt-azimuth", "-20"]
    rules = ["--fresnel", "exact", "--rear", "direction", "--intensity", "radiance"]
    (score,) = json.loads(gemrender("score", "inoue-3", *FAST, *view, *rules, "--json")[1])
    assert (score["tilt_deg"], score["tilt_azimuth_deg"]) == (10, -20)
    assert (score["fresnel"], score["rear_rule"], score["intensity"]) == ("exact", "direction", "radiance")


def test_the_table_has_a_row_a_stone_and_the_rules(gemrender):
    status, out, err = gemrender("score", "inoue-3", "inoue-1", *FAST)
    assert (status, err) == (0, "")
    head, row3, row1 = (line for line in out.splitlines() if line.startswith((" Stone", " Inoue")))
    bands = [">=", "75", "60-75", "45-60", "30-45", "15-30", "0-15"]
    assert head.split() == ["Stone", "Average", "Rear", *bands, "Trapped"]
    (score,) = json.loads(gemrender("score", "inoue-3", *FAST, "--json")[1])
    assert row3.split()[:5] == ["Inoue", "sample", "3", f"{score['average']:.2f}", f"{score['rear']:.2f}"]
    assert row1.startswith(" Inoue sample 1 ")
    assert "16 × 16 rays, reference." in out
    assert "primary intensity, Gübelin's table (index 2.4173), rear light by position." in out


def test_the_table_tells_stones_of_other_materials_apart(folder, gemrender):
    stone_file("sapphire.toml", "blue", SAPPHIRE)
    out = gemrender("score", "inoue-3", "sapphire.toml", *FAST)[1]
    assert "Gübelin's table (index 2.4173), rear light by position: Inoue sample 3." in out
    index = float(load_material("sapphire").index(SODIUM_NM))
    assert f"Fresnel's equations (index {index:g}), rear light by position: blue." in out


@pytest.mark.parametrize("name", [r"[/] [bold]x $\frac$ {} %s", "石 «№ 1»", "W" * 100])
def test_any_name_is_printed_as_it_is(name, folder, gemrender):
    stone_file("x.toml", name)
    status, out, err = gemrender("score", "x.toml", *FAST, "--out", "maps")
    assert (status, err) == (0, "maps written to maps\n")
    assert f" {name} " in out
    assert names("maps") == {"x.exr", "x.png"}


def test_maps_are_named_as_the_user_named_the_stones(folder, gemrender):
    stone_file("Mein Stein ü.toml", "a/b")
    assert gemrender("score", "inoue-3", "Mein Stein ü.toml", "inoue-3", *FAST, "--out", "a/b")[0] == 0
    stems = ["inoue-3", "inoue-3-2", "mein-stein-ü"]
    assert names("a/b") == {f"{stem}.{kind}" for stem in stems for kind in ("exr", "png")}


def test_messages_keep_out_of_json(folder, gemrender):
    status, out, err = gemrender("score", "inoue-3", *FAST, "--json", "--out", "maps")
    assert (status, len(json.loads(out)), err) == (0, 1, "maps written to maps\n")


def test_scene_writes_both_files(folder, gemrender, variant_llvm_ad_mono):
    status, out, err = gemrender("scene", "inoue-3", "inoue-1", "--out", "s", "--resolution", "64")
    assert (status, out, err) == (0, "", "written: s/inoue-3.xml\nwritten: s/inoue-1.xml\n")
    assert names("s") == {"inoue-1.ply", "inoue-1.xml", "inoue-3.ply", "inoue-3.xml"}


def test_scored_scenes_split_light_where_they_are_told_to(folder, gemrender, variant_llvm_ad_mono):
    for option, told in (("--birefringence", True), ("--no-birefringence", False), ("--resolution=8", False)):
        assert gemrender("scene", "inoue-3", "--material", "topaz", "--out", "s", option)[0] == 0
        assert ('<vector name="principal"' in Path("s/inoue-3.xml").read_text()) == told


def test_scenes_of_pictures_split_light_unless_they_are_told_not_to(
    folder, gemrender, variant_llvm_ad_spectral
):
    options = ("--material", "topaz", "--setup", "hemisphere", "--out", "s")
    for option, told in (((), False), (("--birefringence",), False), (("--no-birefringence",), True)):
        assert gemrender("scene", "inoue-3", *options, *option)[0] == 0
        text = Path("s/inoue-3-hemisphere.xml").read_text()
        assert ('<boolean name="birefringence" value="false"/>' in text) == told


def test_stones_lists_the_bundled_ones(gemrender):
    status, out, _ = gemrender("stones")
    assert status == 0
    rows = [line for line in out.splitlines() if line.startswith(" ") and not line.startswith((" ─", "  "))]
    assert [row.split()[0] for row in rows] == ["Name", *bundled_stones()]


def test_stones_lists_those_of_a_family(gemrender):
    status, out, _ = gemrender("stones", "--family", "OV", "--format", "json")
    assert status == 0
    records = json.loads(out)
    assert records
    assert {record["family"] for record in records} == {"oval"}
    of_all = json.loads(gemrender("stones", "--format", "json")[1])
    assert all(list(record) == list(records[0]) for record in of_all)
    status, _, err = gemrender("stones", "--family", "x")
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith("gemrender: --family = 'x': must be one of round brilliant, ")


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], ["score", "-h"], ["crosscheck", "--help"]])
def test_help_is_no_error(arguments, gemrender):
    status, out, err = gemrender(*arguments)
    assert (status, err) == (0, "")
    assert "Usage:" in out


def test_progress_is_shown_on_a_terminal_and_taken_away(gemrender, monkeypatch):
    monkeypatch.setattr(output, "PATIENCE_S", -1.0)
    monkeypatch.setenv("FORCE_COLOR", "1")  # what rich takes for a terminal
    status, out, err = gemrender("score", "inoue-3", "inoue-1", *FAST, "--json")
    assert status == 0
    assert len(json.loads(out)) == 2
    assert "Inoue sample 1" in err
    assert "100 %" in err


def test_progress_of_many_stones_is_not_written_into_a_file(gemrender, monkeypatch):
    monkeypatch.setattr(output, "PATIENCE_S", -1.0)
    assert (
        gemrender("score", *["inoue-3"] * 50, "--engine", "reference", "--resolution", "2", "--json")[2] == ""
    )


#: A roof upside down of quartz: behind (180 - theta_c)/3 its second main lets all light out.
ROOF = """GemCad 5.0
g 96 0.0
y 1 n
I 1.54
a -46.2 0.6 0 n M 48
a 90 1.0 24 n E 72
a 90 0.5 0 n S 48
a 0 0.3 0 n T
"""


# ---- Derivatives ---------------------------------------------------------------------------------------


def test_sensitivity_prints_a_row_for_each_parameter_and_writes_a_figure(folder, gemrender):
    status, out, err = gemrender("sensitivity", "inoue-3", "--out", "d")
    assert (status, err) == (0, "written: d/inoue-3-sensitivity.png\n")
    found = sensitivity(load_stone("inoue-3"))
    rows = [line for line in out.splitlines() if " 1 %" in line or " 1 °" in line]
    assert len(rows) == len(found.derivatives)
    assert f"Inoue sample 3: Average {found.average:.2f}, Rear {found.rear:.2f}" in out
    assert names("d") == {"inoue-3-sensitivity.png"}


def test_sensitivity_as_json(gemrender):
    (found,) = json.loads(gemrender("sensitivity", "inoue-3", "--json")[1])
    assert (found["name"], round(found["average"], 1)) == ("Inoue sample 3", 60.4)  # the paper's
    first, *_, last = found["derivatives"]
    assert (first["parameter"], first["kept"], first["unit"]) == ("table", "proportions", "%")
    assert (last["parameter"], last["kept"]) == ("lower_half", "angles")
    assert {"average", "rear", "average_bound", "rear_bound"} < set(first)
    assert "measures" not in first
    assert "cliffs" not in found


def test_sensitivity_of_measures(gemrender):
    command = ["sensitivity", "inoue-3", "--material", "quartz", "--derivative-bound", "10"]
    (found,) = json.loads(gemrender(*command, "--measures", "window,aset", "--json")[1])
    zones = ["green", "red", "blue", "leak", "trapped", "tied"]
    zones += [f"weighted_{zone}" for zone in zones[:4]] + ["surface", "rest", "weighted_tied"]
    for of in found["derivatives"]:
        assert list(of)[-1] == "measures"
        assert {name: list(values) for name, values in of["measures"].items()} == {
            "window": ["value"],
            "aset": zones,
        }
        assert set(of["measures"]["window"]["value"]) == {"slope", "bound"}
    status, out, err = gemrender("sensitivity", "inoue-3", "--measures", "window", "--format", "csv")
    assert (status, err) == (0, "")
    assert out.splitlines()[0].endswith("rear_bound,window,window_bound")


def test_sensitivity_tells_cliffs(folder, gemrender, monkeypatch):
    monkeypatch.setattr("gemrender.sweep.cliffs.STEPS", 3)  # the nearest is the only one
    (folder / "roof.asc").write_text(ROOF, encoding="utf-8")
    (found,) = json.loads(gemrender("sensitivity", "roof.asc", "--cliffs", "--reach", "0.5", "--json")[1])
    assert list(found)[-1] == "cliffs"
    steeper, flatter = found["cliffs"][:2]
    assert (steeper["side"], flatter["side"], flatter["at"]) == ("below", "above", None)
    assert steeper["parameter"] == found["derivatives"][0]["parameter"]
    mirrors_to = -(180.0 - math.degrees(math.asin(1.0 / 1.54))) / 3.0
    assert steeper["at"] == pytest.approx(mirrors_to, abs=0.01)
    assert steeper["jumps"]["inoue"]["rear"] == pytest.approx(-100.0, abs=0.01)
    status, out, err = gemrender("sensitivity", "roof.asc", "--cliffs", "--reach", "0.5")
    assert (status, err) == (0, "")
    assert f"{mirrors_to:.3f}" in out
    assert "inoue rear -100.00" in out


# ---- Cross-check ---------------------------------------------------------------------------------------


def test_crosscheck_agrees_with_status_0(gemrender, variant_llvm_ad_mono):
    status, out, err = gemrender("crosscheck", "inoue-3", "--random", "1", "--resolution", "48", "--json")
    assert (status, err) == (0, "")
    checks = json.loads(out)
    pairs = [(check["name"], *check["engines"]) for check in checks]
    others = ("mitsuba", "exact")
    assert pairs == [(name, e, "reference") for name in ("Inoue sample 3", "random 1.1") for e in others]
    assert all(check["failures"] == [] for check in checks)


def test_crosscheck_of_split_light_compares_scores(gemrender, variant_llvm_ad_mono):
    options = ("--material", "sapphire", "--birefringence", "--resolution", "64")
    status, out, err = gemrender("crosscheck", "inoue-3", "--random", "1", *options, "--json")
    assert (status, err) == (0, "")
    checks = json.loads(out)
    assert [(c["name"], *c["engines"]) for c in checks] == [
        (name, "mitsuba", "exact") for name in ("Inoue sample 3", "random 1.1")
    ]
    assert all(check["failures"] == [] for check in checks)
    table = gemrender("crosscheck", "inoue-3", *options)[1]
    for word in ("ΔAverage", "±", "ΔRear", "agrees", "99.9 %"):
        assert word in table


def test_crosscheck_that_differs_has_status_1_and_still_prints(gemrender, monkeypatch, variant_llvm_ad_mono):
    monkeypatch.setattr(crosscheck, "LEAST_SAME_EXIT", 100.5)
    status, out, err = gemrender("crosscheck", "inoue-3", "--resolution", "16", "--json")
    assert (status, err) == (1, "")
    assert json.loads(out)[0]["failures"] == ["100.0000 % of rays end alike, at least 100.5 % must"]


def test_crosscheck_prints_every_difference(gemrender, monkeypatch, variant_llvm_ad_mono):
    monkeypatch.setattr(crosscheck, "LEAST_SAME_EXIT", 100.5)
    out = gemrender("crosscheck", "inoue-3", "--resolution", "16")[1]
    for column in (
        "Same exit",
        "Same path",
        "ΔI mean",
        "ΔI max",
        "Lost",
        "ΔAverage",
        "ΔRear",
        "Δ >= 75",
        "Δ 0-15",
    ):
        assert column in out
    assert "differs" in out
    assert "Inoue sample 3, mitsuba: 100.0000 % of rays end alike, at least 100.5 % must" in out


# ---- The process ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def without_llvm(tmp_path_factory):
    """A process without LLVM that scores by the reference, then by Mitsuba; and what it would write into."""
    maps = tmp_path_factory.mktemp("without_llvm") / "maps"
    code = (
        "import sys; from gemrender.cli.program import run; "
        f"status = run(['score', 'inoue-3', *{FAST}, '--json']); "
        "print(status, {'mitsuba', 'drjit'} & set(sys.modules), file=sys.stderr); "
        f"sys.exit(run(['score', 'inoue-3', '--engine', 'mitsuba', '--out', {str(maps)!r}]))"
    )
    return run_python("-c", code, environment={"DRJIT_LIBLLVM_PATH": "/nowhere/libLLVM.so"}), maps


def test_the_reference_needs_no_mitsuba_and_no_llvm(without_llvm):
    done, _ = without_llvm
    assert done.stderr.startswith("0 set()\n")
    assert json.loads(done.stdout)[0]["engine"] == "reference"


def test_no_llvm_is_one_line_with_the_cure(without_llvm):
    done, maps = without_llvm
    _, error = done.stderr.splitlines()
    assert done.returncode == 1
    assert "unset DRJIT_LIBLLVM_PATH" in error
    assert error.endswith("; without Mitsuba, --engine exact and --engine reference work")
    assert not maps.exists()


LONG = ["score --help", f"score inoue-3 {' '.join(FAST)} --json", f"score inoue-3 {' '.join(FAST)}", "stones"]


@pytest.mark.parametrize("line", chosen(LONG, LONG[:2]))
def test_a_reader_that_leaves_early_is_no_error_to_talk_about(line):
    process = subprocess.Popen(
        [sys.executable, "-m", "gemrender", *line.split()],
        env=environment({}),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    process.wait()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("options", chosen([[], ["--json"]], [[]]), ids=["table", "json"])
def test_a_full_disk_behind_stdout_is_one_line(options):
    with Path("/dev/full").open("w") as full:
        done = run_gemrender(
            "score", "inoue-3", *FAST, *options, capture_output=False, stdout=full, stderr=subprocess.PIPE
        )
    assert (done.returncode, done.stderr) == (
        1,
        "gemrender: input or output failed: No space left on device\n",
    )


def shell(line):
    """Run a line of shell in which $GEMRENDER scores a stone."""
    command = f"'{sys.executable}' -m gemrender score inoue-3 {' '.join(FAST)}"
    return subprocess.run(
        ["sh", "-c", line.replace("$GEMRENDER", command)],
        env=environment({}),
        capture_output=True,
        text=True,
        timeout=60,
    )


def test_a_full_disk_behind_out_is_one_line_and_leaves_nothing(tmp_path):
    done = shell(f"ulimit -f 1; $GEMRENDER --out '{tmp_path}'")  # no file of more than one block
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(f"gemrender: {tmp_path / 'inoue-3.exr'}: cannot be written: ")
    assert list(tmp_path.iterdir()) == []


def one_process(lines, stream="stdout"):
    """Return Python that runs lines one after the other, and prints the exit status after each."""
    return (
        f"import sys\nfrom gemrender.cli import main\nfor line in {lines!a}:\n"
        "    try:\n        main(line)\n    except SystemExit as ended:\n"
        f"        print('status', ended.code, file=sys.{stream})\n"
    )


def test_a_closed_stdout_is_one_line_and_a_failure(tmp_path):
    forms = [[], ["--json"], ["--format", "csv"], ["--format", "markdown"]]
    lines = [["score", "inoue-3", *FAST, *form] for form in forms]
    (tmp_path / "lines.py").write_text(one_process(lines, "stderr"))
    done = shell(f"'{sys.executable}' '{tmp_path / 'lines.py'}' >&-")
    told = "gemrender: input or output failed: standard output is closed\nstatus 1\n"
    assert (done.returncode, done.stdout, done.stderr) == (0, "", told * len(forms))


def test_a_closed_stderr_is_no_error(tmp_path):
    lines = [["score", "inoue-3", *FAST, "--json"], ["score", "inoue-9"]]
    (tmp_path / "lines.py").write_text(one_process(lines))
    done = shell(f"'{sys.executable}' '{tmp_path / 'lines.py'}' 2>&-")
    out, *rest = re.split(r"status (\d)\n", done.stdout)
    # The second one's message has nowhere to go, least of all to stdout
    assert (len(json.loads(out)), rest) == (1, ["0", "", "2", ""])


def test_a_terminal_without_our_letters_shows_what_it_can(tmp_path):
    stone_file(tmp_path / "x.toml", "石 1")
    ascii_only = {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "LC_ALL": "C"}
    line = ["score", str(tmp_path / "x.toml"), *FAST]
    done = run_python("-c", one_process([line, [*line, "--json"]]), environment=ascii_only)
    table, status, records, *rest = re.split(r"status (\d)\n", done.stdout)
    assert (done.stderr, status, rest) == ("", "0", ["0", ""])
    assert "|? 1 " in table
    assert json.loads(records)[0]["name"] == "石 1"


def test_an_interruption_stops_soon_and_leaves_no_files(tmp_path):
    maps = tmp_path / "maps"
    process = subprocess.Popen(
        [sys.executable, "-m", "gemrender", "score", "inoue-1", "--engine", "reference",
         "--resolution", "3072", "--out", str(maps)],
        env=environment({}), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 60
        while not maps.exists():  # made right before the trace
            assert time.monotonic() < deadline
            time.sleep(0.05)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=STOPS_WITHIN)
    finally:  # on a busy machine a wait may be too short
        process.kill()
        process.wait()
    *progress, last = err.splitlines()
    assert (process.returncode, out, last) == (130, "", "gemrender: interrupted")
    assert all(line.endswith("done)") for line in progress)
    assert list(maps.iterdir()) == []


def test_the_module_and_the_version():
    done = run_gemrender("--version", cwd=ROOT)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{gemrender.__version__}\n", "")

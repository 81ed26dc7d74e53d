"""The command line's tables: many stones, settings, forms, widths; old options; what a shell completes."""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path

import pytest
from thorough import chosen
from typer.testing import CliRunner

from gemrender.cli.program import app
from gemrender.cuts import bundled_stones
from tests.observations import run_gemrender, run_python

FAST = ["--engine", "reference", "--resolution", "16"]
BANDS = ["band_75", "band_60", "band_45", "band_30", "band_15", "band_0"]
#: A report's list as a dealer has it.
TABLE = """\
Report No,Shape,Carat,Table %,Depth %,Crown Angle,Pavilion Angle,Girdle,Culet,Star,Lower Half
A1,Round Brilliant,1.01,57,61.5,34.5,40.8,Thin - Medium,None,50,80
=B2,Round,0.9,56,62.1,35,40.6,Medium,Pointed,,
"""


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


# ---- Forms -----------------------------------------------------------------------------------------------

PRINTING = {
    "score": ["score", "inoue-3", *FAST],
    "compare": ["compare", "inoue-3", *FAST],
    "symmetry": ["symmetry", "inoue-3", "--draws", "1", *FAST],
    "tilt": ["tilt", "inoue-3", "--to", "1"],
    "sensitivity": ["sensitivity", "inoue-3", "--derivative-bound", "10"],
    "stones": ["stones"],
    "setups": ["setups"],
    "materials": ["materials"],
    "one material": ["materials", "diamond"],
    "measures": ["measures"],
}


@pytest.mark.parametrize("name", PRINTING)
def test_every_table_has_the_four_forms(name, gemrender):
    printed = {}
    for form in ("table", "json", "csv", "markdown"):  # --format json: test_contracts.py
        options = ["--json"] if form == "json" else ["--format", form]
        status, printed[form], err = gemrender(*PRINTING[name], *options)
        assert (status, err) == (0, "")
    first = json.loads(printed["json"])[0]
    assert first["name"] == rows(printed["csv"])[0]["name"]
    assert printed["markdown"].startswith("| ")


def test_json_and_another_form_are_refused(gemrender):
    status, out, err = gemrender("score", "inoue-3", "--json", "--format", "csv")
    assert (status, out) == (2, "")
    assert err == "gemrender: --format = 'csv': is another form than --json\n"


def test_csv_has_every_digit_of_json(gemrender):
    (record,) = rows(gemrender("score", "inoue-3", *FAST, "--format", "csv")[1])
    (score,) = json.loads(gemrender("score", "inoue-3", *FAST, "--json")[1])
    assert float(record["average"]) == score["average"]
    assert [float(record[key]) for key in BANDS] == [band["share"] for band in score["bands"]]
    assert (record["engine"], float(record["index"]), record["rear_rule"]) == (
        "reference",
        2.4173,
        "position",
    )
    assert record["bound"] == ""


COMMANDS = (
    "score", "compare", "sensitivity", "show", "report", "render", "symmetry", "tilt", "atlas",
    "crosscheck", "scene", "stones", "setups", "materials", "measures", "doctor",
)  # fmt: skip

# ---- Widths ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("columns", chosen([60, 80, 200], [60]))
@pytest.mark.parametrize("name", PRINTING)
def test_tables_fit_the_terminal(name, columns, gemrender, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    out = gemrender(*PRINTING[name])[1]
    assert max(map(len, out.splitlines())) <= columns


@pytest.mark.parametrize("command", ["", *COMMANDS])
@pytest.mark.parametrize("columns", [80, 200])
def test_help_fits_the_terminal(command, columns, gemrender, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    status, out, err = gemrender(*command.split(), "--help")
    assert (status, err) == (0, "")
    assert max(map(len, out.splitlines())) <= columns
    assert "…" not in out  # nothing is cut
    assert not re.search(r"\w \.(\s|$)", out)  # or taken for markup


def test_whole_names_at_80_columns(gemrender, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    out = gemrender("score", "inoue-3", "inoue-1")[1]
    assert " Inoue sample 3 " in out
    assert " Inoue sample 1 " in out
    assert "Left out" in out


# ---- Many stones -----------------------------------------------------------------------------------------


def test_a_table_of_stones_is_scored_row_by_row(folder, gemrender):
    Path("list.csv").write_text(TABLE)
    status, out, err = gemrender("score", "list.csv", *FAST, "--format", "csv")
    assert status == 0
    assert [row["name"] for row in rows(out)] == ["A1", "'=B2"]  # defused
    assert "list.csv: columns not used: Carat\n" in err
    assert "list.csv: assumed in 1 of 2 rows: star 50 (not in the report)\n" in err
    # The table says so itself.
    assert "assumed in 1 of 2 rows: lower half 80" in gemrender("score", "list.csv", *FAST)[1]


def test_pandas_reads_many_stones_without_help(folder, gemrender):
    pandas = pytest.importorskip("pandas")
    head = "name,table,crown_angle,pavilion_angle,star,lower_half,girdle_thickness"
    lines = [f"s{i},{53 + i % 10},{33 + i % 5},{40.2 + i % 9 / 10},50,80,3" for i in range(200)]
    Path("stones.csv").write_text("\n".join([head, *lines]))
    status, out, err = gemrender(
        "score", "stones.csv", "--engine", "reference", "--resolution", "2", "--format", "csv"
    )
    assert status == 0
    assert err.splitlines()[-1].startswith("200 stones in ")
    read = pandas.read_csv(io.StringIO(out))
    assert list(read["name"]) == [f"s{i}" for i in range(200)]
    assert all(read[key].dtype == "float64" for key in ("average", "rear", *BANDS))


def test_a_bad_row_stops_before_any_work(folder, gemrender):
    Path("list.csv").write_text(TABLE.replace("40.6", "wide"))
    status, out, err = gemrender("score", "inoue-3", "list.csv", *FAST, "--format", "csv", "--out", "maps")
    assert (status, out) == (2, "")
    assert err.startswith("gemrender: list.csv: row 2 (line 3), Pavilion Angle = 'wide': must be ")
    assert not Path("maps").exists()


def test_maps_of_a_table_are_named_after_its_rows(folder, gemrender):
    Path("list.csv").write_text(TABLE)
    assert gemrender("score", "list.csv", *FAST, "-o", "maps")[0] == 0
    assert {path.name for path in Path("maps").iterdir()} == {"a1.exr", "a1.png", "b2.exr", "b2.png"}


REPORT = "[report]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\ngirdle_thickness = 3\n"
TOLD = "gemrender: one.toml: taken: star 50 (not in the report)\n"


@pytest.mark.parametrize(
    "command",
    [
        "score one.toml --json",
        "compare one.toml --format csv",
        "symmetry one.toml --draws 1",
        "show one.toml --what outline",
        "report one.toml",
        "scene one.toml --out s",
        "scene one.toml --out s --setup studio",
        "render one.toml -o a.png --setup hemisphere --size 8 --spp 1",
    ],
)
def test_what_was_assumed_is_told_whatever_is_done(command, folder, gemrender, variant_llvm_ad_mono):
    Path("one.toml").write_text(REPORT)
    fast = FAST if command.split()[0] in ("score", "compare", "symmetry", "report") else []
    status, _, err = gemrender(*command.split(), *fast)
    assert status == 0, err
    assert TOLD in err


# ---- Settings --------------------------------------------------------------------------------------------


def test_a_grid_has_a_column_a_setting(gemrender):
    grid = ["--set", "pavilion_angle=40.5:41:0.25", "--set", "table=54,57"]
    found = rows(gemrender("score", "inoue-3", *FAST, *grid, "--format", "csv")[1])
    assert list(found[0])[:4] == ["name", "pavilion_angle", "table", "average"]
    expected = [(angle, table) for angle in (40.5, 40.75, 41.0) for table in (54.0, 57.0)]
    assert [(float(row["pavilion_angle"]), float(row["table"])) for row in found] == expected
    (first, *_) = json.loads(gemrender("score", "inoue-3", *FAST, *grid, "--json")[1])
    assert first["settings"] == {"pavilion_angle": 40.5, "table": 54.0}
    compared = json.loads(gemrender("compare", "inoue-3", *FAST, *grid, "--format", "json")[1])
    assert compared[0]["settings"] == first["settings"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["inoue-3", "--set", "pavilion=40"], "--set: pavilion: unknown key; must be one of "),
        (["inoue-3", "--set", "table"], "--set: 'table': must be KEY=VALUE"),
        (["inoue-3", "inoue-1", "--set", "table=54"], "--set = 'table=54': varies one stone; name only one"),
        (["inoue-3", "--set", "table=400"], "--set: table = 400.0: must be from 5 to 92 [%]"),
    ],
)
def test_settings_that_cannot_be_are_one_line(arguments, words, gemrender):
    status, out, err = gemrender("score", *arguments, *FAST)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"gemrender: {words}")


# ---- Options that have changed their name ------------------------------------------------------------------


def test_the_facets_deviation_is_called_so(gemrender):
    study = ["symmetry", "inoue-3", "--draws", "1", *FAST, "--json"]
    status, new, err = gemrender(*study, "--deviation", "1")
    assert (status, err) == (0, "")
    status, old, err = gemrender(*study, "--tilt", "1")
    assert (status, old) == (0, new)
    assert err.startswith("gemrender: --tilt 1 is taken as --deviation 1, its new name in this command")
    tilted = gemrender(*study, "--deviation", "1", "--tilt", "10")[1]
    assert json.loads(tilted)[0]["perfect"] != json.loads(new)[0]["perfect"]  # the eye's tilt


def test_the_derivatives_bound_is_called_so(gemrender):
    status, _, err = gemrender("sensitivity", "inoue-3", "--bound", "10", "--json")
    assert (status, err) == (0, "gemrender: --bound is called --derivative-bound in this command now\n")
    status, _, err = gemrender("sensitivity", "inoue-3", "--bound", "10", "--derivative-bound", "5")
    assert (status, err) == (
        2,
        "gemrender: --bound = 10.0: is the old name of --derivative-bound; give one of them\n",
    )


# ---- Where to write --------------------------------------------------------------------------------------


#: Commands and what they write; by -o, test_contracts.py has the others.
WRITING = [
    (["score", "inoue-3", *FAST], "inoue-3.exr"),
    (["report", "inoue-3", *FAST], "report.html"),
    (["compare", "inoue-3", *FAST], "comparison.csv"),
    (["show", "inoue-3", "--what", "outline"], "inoue-3-outline.png"),
    (["symmetry", "inoue-3", "--draws", "1", *FAST], "inoue-3-symmetry.jsonl"),
]


@pytest.mark.parametrize("option", chosen(["-o", "--out"], ["--out"]))
@pytest.mark.parametrize(
    ("command", "name"), chosen(WRITING, WRITING[:2]), ids=["score", "report", "compare", "show", "symmetry"]
)
def test_every_command_writes_into_a_folder_that_it_makes(command, name, option, folder, gemrender):
    assert gemrender(*command, option, "a/b/")[0] == 0
    assert (folder / "a" / "b" / name).exists()


def test_where_to_write_is_checked_before_anything_is_compiled(folder, gemrender, monkeypatch):
    from gemrender import engines

    def compiled(*_, **__):
        raise AssertionError("too late")

    monkeypatch.setattr(engines, "require_engine", compiled)
    Path("file").write_text("")
    for command in ("score", "compare", "symmetry", "sensitivity"):
        status, _, err = gemrender(command, "inoue-3", "--out", "file")
        assert (status, err.count("\n")) == (2, 1)
        assert err.startswith("gemrender: --out = 'file': must be a folder that can be written")


# ---- Files to start from ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "name"), [("stones", "inoue-3"), ("setups", "studio"), ("materials", "ruby")]
)
def test_a_file_to_start_from_is_printed(command, name, gemrender):
    import tomllib

    status, out, err = gemrender(command, "--show", name)
    assert (status, err) == (0, "")
    assert tomllib.loads(out)["name"]
    status, out, err = gemrender(command, "--show", f"{name}x")
    assert (status, out) == (2, "")
    assert f"did you mean {name}?" in err


def test_a_materials_file_is_told_in_full(folder, gemrender):
    Path("narrow.toml").write_text('name = "narrow"\n[index]\nwavelength_nm = [586, 656]\nn = [1.70, 1.66]\n')
    out = gemrender("materials", "narrow.toml")[1]
    assert "continued to 380 and 760 nm" in out
    (record,) = json.loads(gemrender("materials", "narrow.toml", "--json")[1])
    assert list(record)[:8] == ["name", "n_G", "n_F", "n_D", "n_C", "n_B", "abbe_number", "dispersion_b_g"]
    assert record["continued_nm"] == [[380.0, 586.0], [656.0, 760.0]]


# ---- The shell -------------------------------------------------------------------------------------------


def asks(line: str) -> dict[str, str]:
    """What bash asks by what may stand at the end of a line."""
    return {"_GEMRENDER_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}


def test_commands_options_choices_and_names_are_completed(folder):
    Path("inside.toml").write_text("")
    Path("inside.txt").write_text("")
    Path("into").mkdir()
    expected = {
        "gemrender sco": ["score"],
        "gemrender score --eng": ["--engine"],
        "gemrender score --engine e": ["exact"],
        "gemrender score ino": [name for name in bundled_stones() if name.startswith("ino")],
        "gemrender score ins": ["inside.toml"],
        "gemrender score int": ["into/"],
        "gemrender score inoue-3 --set pavilion_a": ["pavilion_angle="],
        "gemrender render --setup stu": ["studio"],
        "gemrender render --material ru": ["ruby", "rutile"],
        "gemrender score inoue-3 --format m": ["markdown"],
    }
    completed = {
        line: CliRunner().invoke(app, prog_name="gemrender", env=asks(line)).stdout.split()
        for line in expected
    }
    assert completed == expected


def test_a_process_of_its_own_completes():
    code = "from gemrender.cli import app; app(prog_name='gemrender')"
    done = run_python("-c", code, environment=asks("gemrender sco"))
    assert (done.stdout.split(), done.stderr) == (["score"], "")


@pytest.mark.skipif(os.name == "nt", reason="a shell's line")
def test_doctor_prints_the_line_for_the_shell_and_nothing_else(gemrender):
    done = run_gemrender("doctor", "--export")
    assert (done.returncode, done.stderr, done.stdout.count("\n")) == (0, "", 1)
    assert done.stdout.startswith("export DRJIT_LIBLLVM_PATH=")
    assert gemrender("doctor", "-e") == (0, done.stdout, "")


def test_what_was_mended_in_a_stones_file_is_told(gemrender, tmp_path):
    (tmp_path / "cube.asc").write_text(
        "g 96 0.0\nI 1.5\na -90 1 96 24 48 72 96\na 0 1 96\na 0 -1 96\na 45 9 3\n"
    )
    status, _, err = gemrender("convert", str(tmp_path / "cube.asc"), "-o", str(tmp_path / "cube.obj"))
    assert status == 0
    assert [line.split(": ", 2)[2] for line in err.splitlines()[:3]] == [
        "has no first line GemCad",
        "the same plane stands twice, once is used: G1_96_2",
        "other facets cut away C1",
    ]

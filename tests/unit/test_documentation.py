"""Every block of code of the readme and of the pages: commands, files, Python."""

from __future__ import annotations

import importlib
import re
import shutil
import tomllib
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import typer
from documents import PAGES, Block, blocks, blocks_in, command_lines
from meshes import box, obj
from observations import ROOT

import gemrender
from gemrender.cli.program import app, run
from gemrender.cuts import load_stone
from gemrender.optics import load_material
from gemrender.scene.bitmaps import another_thread
from gemrender.sweep.atlas import read_plan

STONES = ROOT / "tests" / "cases" / "stones"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
#: Python that tests of these pages run.
OF_OTHER_TESTS = {"docs/adding-a-cut.md", "docs/notebooks.md", "docs/own-measure.md", "docs/studio.md"}
#: What makes commands cheap: options that are set so, or taken out where it is None.
CHEAPER: dict[str, dict[str, str | None]] = {
    "render": {
        "--size": "12", "--spp": "1", "--quality": None, "--noise": None, "--frames": "2", "--time": None,
        "--bins": "4",
    },
    "improve": {
        "--rounds": "1", "--answers": "1", "--check": None, "--resolution": None, "--reach": "0.1",
        "--draws": "2",
    },
    "symmetry": {"--draws": "2"},
    "tolerance": {"--draws": "2"},
    "tilt": {"--to": "4", "--step": "4"},
    "score": {"--resolution": "32"},
    "crosscheck": {"--resolution": "32"},
    "compare": {"--resolution": "32"},
    "report": {"--resolution": "32"},
    "atlas": {"--dry-run": ""},
}  # fmt: skip
#: Options of `CHEAPER` that are given where a page does not, too.
ALWAYS = {
    "render": ("--size", "--spp"), "improve": ("--rounds", "--answers", "--draws", "--reach"),
    "symmetry": ("--draws",),
    "tolerance": ("--draws",), "tilt": ("--to", "--step"), "compare": ("--resolution",),
    "report": ("--resolution",), "score": ("--resolution",), "atlas": ("--dry-run",),
    "crosscheck": ("--resolution",),
}  # fmt: skip
#: Half a second and more each: run on request.
SLOW = {
    "atlas", "compare", "improve", "render", "report", "scene", "sensitivity", "show", "symmetry", "tilt",
    "tolerance", "--set", "stereo", "crosscheck", "--out",
}  # fmt: skip
#: Would serve until it is stopped.
NOT_RUN = ("studio",)


def commands() -> list[tuple[Block, list[str]]]:
    shell = [block for language in ("", "sh") for block in blocks_in(language)]
    return [(block, words) for block in shell for words in command_lines(block)]


COMMANDS = [
    pytest.param(words[1:], id=f"{block}-{' '.join(words[1:])[:60]}", marks=[pytest.mark.slow] * is_slow)
    for block, words in commands()
    if words[0].endswith("gemrender") and words[1] not in NOT_RUN
    for is_slow in [not SLOW.isdisjoint(words)]
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Make a folder with the files that the pages name."""
    folder = tmp_path_factory.mktemp("documents")
    for name in ("oval.asc", "round.asc", "pear.gem", "novelty-chiral.asc"):
        shutil.copy(STONES / name, folder)
    shutil.copy(STONES / "round-16-main.gcs", folder / "heart.gcs")
    shutil.copy(STONES / "emerald.asc", folder / "my-stone.asc")
    [report] = [block.text for block in blocks_in("toml") if block.page == "README.md"]
    [oval] = [block.text for block in blocks_in("toml") if "A jeweller's oval" in block.text]
    [plan] = [block.text for block in blocks_in("toml") if "[vary]" in block.text]
    [glass] = [block.text for block in blocks_in("toml") if "My glass" in block.text]
    for name, text in {
        "my-stone.toml": report, "report.toml": report, "oval.toml": oval, "plan.toml": plan,
        "my-glass.toml": glass,
        "stones.csv": "name,Table %,Crown Angle,Pavilion Angle,Girdle\none,57,34.5,40.8,Thin\n",
    }.items():  # fmt: skip
        (folder / name).write_text(text, encoding="utf-8")
    obj(folder / "box.obj", box())
    shutil.copy(ROOT / "scenes" / "setups" / "studio.toml", folder / "my.toml")
    assert run(["convert", "quartz-round", "-o", str(folder / "design.asc")]) == 0
    for name in ("docs", "scripts"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def cheaper(words: list[str]) -> list[str]:
    """Return a command line with less to do."""
    name, *rest = words
    options = CHEAPER.get(name, {})
    made, i = [], 0
    given = set()
    while i < len(rest):
        word = rest[i]
        if word in options:
            value = options[word]
            takes = word not in ("--check", "--dry-run")
            i += 1 + takes
            given.add(word)
            made += [] if value is None else [word, value] if value else [word]
            continue
        made.append(word)
        i += 1
    for word in ALWAYS.get(name, ()):
        if word not in given and not (name == "atlas" and "export" in words):
            value = options[word]
            made += [word, value] if value else [word]
    return [name, *made]


def test_every_block_is_known():
    """Those in no language are of the shell, and of those in "text" nobody says that they can be run."""
    assert len(PAGES) > 20
    assert {block.language for block in blocks()} <= {"", "sh", "toml", "python", "text"}
    silent = [str(block) for block in blocks() if block.language in ("", "sh") and not command_lines(block)]
    assert silent == []


def test_commands_are_as_the_program_takes_them():
    known = typer.main.get_command(app).commands
    for block, words in commands():
        if words[0].endswith("gemrender"):
            command = known.get(words[1])
            assert command is not None, f"{block}: {words}"
            arguments = words[2:]
            if ">" in arguments:
                arguments = arguments[: arguments.index(">")]
            # As under the program: Click keeps the help option that it makes for the first context
            command.make_context(words[1], list(arguments), help_option_names=["-h", "--help"])


def test_scripts_extras_and_files_are_there():
    for block, words in commands():
        if words[0].startswith("python") and words[1] != "-m":
            script = ROOT / words[1]
            source = script.read_text(encoding="utf-8")
            for word in words[2:]:
                assert not word.startswith("--") or f'"{word}"' in source, f"{block}: {words}"
        for word in words:
            for extras in re.findall(r"(?:\.|gemrender)\[([\w,]+)\]", word):
                assert set(extras.split(",")) <= set(PROJECT["optional-dependencies"]), f"{block}: {word}"


@pytest.mark.parametrize("words", COMMANDS)
def test_commands_run(words, folder, monkeypatch, capfd):
    monkeypatch.chdir(folder)
    if ">" in words:
        words = words[: words.index(">")]
    if words[0] == "atlas" and "export" in words:
        pytest.skip("needs an atlas: tests/unit/test_atlas.py exports one")
    if words[0] == "show" and "plan.zarr" in words:
        words = ["docs/atlas/round-brilliants.nc" if word == "plan.zarr" else word for word in words]
    words = [word.replace("docs/atlas", "drawn") if word == "docs/atlas" else word for word in words]
    if "stone.stl" in words and not Path("stone.stl").exists():
        assert run(["convert", "oval.asc", "-o", "stone.stl"]) == 0
    assert run(cheaper(words)) == 0, capfd.readouterr().err


def test_files_are_read(folder, monkeypatch):
    monkeypatch.chdir(folder)
    mpl.use("agg")
    kinds = {"stone": 0, "set-up": 0, "material": 0, "plan": 0}
    for block in blocks_in("toml"):
        path = Path("block.toml")
        path.write_text(block.text, encoding="utf-8")
        keys = set(tomllib.loads(block.text))
        if block.page == "docs/adding-a-cut.md" or "tool" in keys:
            continue  # a family that is not there; tests/unit/test_turning_test.py
        if keys & {"sky", "setting", "thing"}:
            read_setup(block.text)
            kinds["set-up"] += 1
        elif "vary" in keys:
            assert read_plan(path).number > 100
            kinds["plan"] += 1
        elif "index" in keys:
            assert load_material(str(path)).name == "My glass"
            kinds["material"] += 1
        else:
            assert load_stone(path).solid.volume > 0
            kinds["stone"] += 1
    assert min(kinds.values()) > 0


def read_setup(text: str) -> None:
    """Read a part of a set-up: with a sky, where it has none."""
    whole = text if "[sky]" in text else f"[sky]\nradiance = 1\n{text}"
    if "studio.hdr" in text:
        from gemrender.render.backend import ensure_variant

        ensure_variant("llvm_ad_mono")
        import mitsuba as mi

        mi.Bitmap(np.ones((4, 8, 3), dtype=np.float32)).write("studio.hdr")
    Path("setup.toml").write_text(whole, encoding="utf-8")
    gemrender.load_setup("setup.toml")


RUN_HERE = [
    "README.md",
    "docs/birefringence.md",
    "docs/from-python.md",
    "docs/in-mitsuba.md",
    "docs/settings.md",
]


@pytest.mark.parametrize("page", RUN_HERE)
@pytest.mark.parametrize("pictures", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_python_runs(page, pictures, folder, monkeypatch, capfd):
    """Blocks in their order; those that render, which compiles scenes, on request."""
    monkeypatch.chdir(folder)
    if pictures and page == "docs/in-mitsuba.md":
        assert run(["scene", "inoue-3", "--out", "scenes", "--resolution", "32"]) == 0
    if pictures and page == "docs/birefringence.md":
        options = ["--material", "ruby", "--setup", "polariscope", "--size", "16", "--spp", "4"]
        assert run(["scene", "corundum-round", *options, "--out", "scenes"]) == 0
    names: dict = {}
    for block in blocks_in("python"):
        if block.page == page:
            code = compile(block.text, str(block), "exec")
            if pictures or "render(" not in block.text:
                with another_thread():  # some write OpenEXR by Mitsuba
                    exec(code, names)


def test_other_python_is_run_by_tests_of_its_page_or_names_what_there_is():
    for block in blocks_in("python"):
        if block.page in (*OF_OTHER_TESTS, *RUN_HERE):
            continue
        assert block.page in ("docs/atlas.md", "docs/cluster.md")  # an atlas of some minutes, a cluster
        compile(block.text, str(block), "exec")
        for module, names in re.findall(r"^from (gemrender[\w.]*) import (.+)$", block.text, re.MULTILINE):
            assert set(names.split(", ")) <= set(importlib.import_module(module).__all__)

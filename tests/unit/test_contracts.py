"""What scripts rely on, as frozen samples: JSON keys and their order, CSV columns, file names, EXR channels.

A key may be added after the others, and a column at the end; nothing here may go, move or change its type.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gemrender import cli

SAMPLES = Path(__file__).parents[1] / "samples"
FAST = ["--engine", "reference", "--resolution", "16"]

#: A command for each sample, without the option that says the form.
COMMANDS = {
    "score": ["score", "inoue-3", *FAST],
    "score-exact": ["score", "inoue-3"],
    "compare": ["compare", "inoue-3", *FAST],
    "sensitivity": ["sensitivity", "inoue-3", "--derivative-bound", "10"],
    "symmetry": ["symmetry", "inoue-3", "--draws", "2", *FAST],
    "tilt": ["tilt", "inoue-3", "--to", "5", "--step", "5", "--measures", "inoue,iso"],
    "crosscheck": ["crosscheck", "inoue-3", "--resolution", "16"],
    "crosscheck-birefringence": ["crosscheck", "inoue-3", "--birefringence", "--resolution", "16"],
    "stones": ["stones"],
    "setups": ["setups"],
    "materials": ["materials"],
    "measures": ["measures"],
    "doctor": ["doctor"],
}


@pytest.fixture
def printed(capsys):
    """Run the command line in this process; returns stdout."""

    def run(*arguments: str) -> str:
        with pytest.raises(SystemExit) as caught:
            cli.main(list(arguments))
        assert caught.value.code == 0
        return capsys.readouterr().out

    return run


def kinds(value):
    """What a value is made of: keys in their order, and the types of what they hold."""
    if isinstance(value, dict):
        return {key: kinds(item) for key, item in value.items()}
    if isinstance(value, list):
        return [kinds(value[0])] if value else []
    if isinstance(value, bool) or value is None:
        return "null" if value is None else "boolean"
    return "number" if isinstance(value, (int, float)) else "string"


def goes_on(old, new, where=""):
    """Check that the new kinds begin with the old ones, all the way down."""
    if isinstance(old, dict):
        assert isinstance(new, dict), where
        assert list(new)[: len(old)] == list(old), where
        for key in old:
            goes_on(old[key], new[key], f"{where}.{key}")
    elif isinstance(old, list):
        assert isinstance(new, list), where
        if old and new:
            goes_on(old[0], new[0], f"{where}[]")
    else:
        assert old == new or "null" in (old, new), where


@pytest.mark.parametrize("name", COMMANDS)
def test_json_and_csv_go_on_as_they_were(name, printed, variant_llvm_ad_mono):
    frozen = json.loads((SAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    goes_on(frozen["json"], kinds(json.loads(printed(*COMMANDS[name], "--format", "json"))))
    head = printed(*COMMANDS[name], "--format", "csv").splitlines()[0].split(",")
    assert head[: len(frozen["csv"])] == frozen["csv"]


def test_maps_have_their_names_and_channels(printed, tmp_path):
    import OpenEXR

    printed("score", "inoue-3", *FAST, "--out", str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {"inoue-3.exr", "inoue-3.png"}
    frozen = json.loads((SAMPLES / "maps.json").read_text(encoding="utf-8"))
    with OpenEXR.File(str(tmp_path / "inoue-3.exr"), separate_channels=True) as file:
        assert set(frozen["channels"]) <= set(file.channels())
        assert set(frozen["attributes"]) <= set(file.header())
        goes_on(frozen["gemrender"], kinds(json.loads(file.header()["gemrender"])))


FILES = {
    "compare": (
        ["compare", "inoue-1", "inoue-3", *FAST],
        {"comparison.csv", "comparison.json", "comparison.png", "difference.png"},
    ),
    "show": (["show", "inoue-3", "--what", "outline"], {"inoue-3-outline.png"}),
    "symmetry": (
        ["symmetry", "inoue-3", "--draws", "1", *FAST],
        {"inoue-3-symmetry.jsonl", "inoue-3-symmetry.png"},
    ),
    "tilt": (["tilt", "inoue-3", "--to", "1"], {"inoue-3-tilt.jsonl", "inoue-3-tilt.png"}),
    "sensitivity": (["sensitivity", "inoue-3", "--derivative-bound", "10"], {"inoue-3-sensitivity.png"}),
    "scene": (["scene", "inoue-3", "--resolution", "16"], {"inoue-3.xml", "inoue-3.ply"}),
}


@pytest.mark.parametrize("name", FILES)
def test_files_have_their_names(name, printed, tmp_path, variant_llvm_ad_mono):
    command, names = FILES[name]
    folder = tmp_path / "a" / "b"  # made, where there is none
    printed(*command, "-o", str(folder))
    assert {path.name for path in folder.iterdir()} == names

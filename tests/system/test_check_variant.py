"""`scripts/check_variant.py`: one table of whether a variant works; told in one line where there is none."""

from __future__ import annotations

import dataclasses
import importlib
import sys

import pytest
from observations import ROOT

from gemrender import BackendError, engines, load_stone


@pytest.fixture
def script(monkeypatch):
    """The script, with checks that take no time."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    module = importlib.import_module("check_variant")
    sizes = {"FURNACE_SPP": 64, "CROSSCHECK_SIZE": 24, "PICTURE_SIZE": 16, "RAYS_SIZE": 32, "REPEATS": 1}
    for name, size in sizes.items():
        monkeypatch.setattr(module, name, size)
    monkeypatch.setattr(module, "MOST_RATIO", float("inf"))  # tests are not timed
    return module


def run(script, monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["check_variant.py", *words])
    return (script.main(), *capsys.readouterr())


def test_a_variant_that_works_passes_everything(script, monkeypatch, capsys, folder):
    status, out, err = run(script, monkeypatch, capsys, "--variant", "llvm_ad_mono", "--out", "a.png")
    assert (status, err) == (0, ""), out
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in out.splitlines()]
    assert rows[0] == ["check", "found", "bar", "passes"]
    assert [row[3] for row in rows[2:] if row[2]] == ["yes"] * 9
    for check in ("white furnace", "cross-check", "principal rays", "picture"):
        assert any(row[0].startswith(check) and row[2] for row in rows), check
    assert (folder / "a.png").is_file()


@pytest.mark.parametrize(
    ("variant", "status", "words"),
    [
        ("nope", 2, "variant = 'nope': must be one of llvm_ad_rgb, "),
        ("scalar_rgb", 2, "variant = 'scalar_rgb': scalar variants are refused, "),
    ],
)
def test_a_variant_that_there_is_not_is_one_line(variant, status, words, script, monkeypatch, capsys):
    found, out, err = run(script, monkeypatch, capsys, "--variant", variant)
    assert (found, out, err.count("\n")) == (status, "", 1)
    assert err.startswith(f"check_variant: {words}")


def test_without_a_gpu_it_is_one_line(script, monkeypatch, capsys):
    def refuse(variant):
        raise BackendError(f"{variant} needs an NVIDIA graphics processor")

    monkeypatch.setattr(script.gemrender, "mitsuba", refuse)
    status, out, err = run(script, monkeypatch, capsys, "--variant", "cuda_ad_spectral")
    assert (status, out) == (1, "")
    assert err == "check_variant: cuda_ad_spectral needs an NVIDIA graphics processor\n"


def test_what_is_beyond_its_bar_is_told_and_the_others_go_on(script, monkeypatch, capsys):
    def broken(*_):
        raise RuntimeError("no such\nkernel")

    monkeypatch.setattr(script, "furnace", broken)
    monkeypatch.setattr(script, "MOST_COLOUR", -1.0)
    monkeypatch.setattr(script, "crosscheck", lambda *_: iter(()))
    monkeypatch.setattr(script, "rays", lambda *_: iter(()))
    status, out, _ = run(script, monkeypatch, capsys, "--variant", "llvm_ad_spectral")
    assert status == 1
    assert "| RuntimeError: no such kernel " in out
    assert out.count("| NO ") == 2
    assert out.count("| yes ") == 2  # the picture


def test_a_tracer_whose_rays_leave_elsewhere_is_found(script, monkeypatch):
    truth = engines.observe(load_stone("inoue-3"), engine="reference", resolution=script.CROSSCHECK_SIZE)
    for observed, kept in (
        (truth, [True] * 4),
        (dataclasses.replace(truth, exit_facet=truth.exit_facet + 1), [False, True, True, False]),
        (dataclasses.replace(truth, rear_mask=truth.rear_mask * 0), [True, True, False, False]),
    ):
        monkeypatch.setattr(engines, "observe_alike", lambda *_, observed=observed, **__: (truth, observed))
        assert [row.passes for row in script.crosscheck(truth.stone, "llvm_ad_mono")] == kept

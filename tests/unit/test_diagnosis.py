"""The checks of the machine, and the doctor's report of them."""

from __future__ import annotations

import io
import os

import pytest
from doctor_help import found
from rich.console import Console

from gemrender.render import diagnosis
from gemrender.render.diagnosis import Check
from gemrender.report.doctor import print_doctor


def test_diagnosis_runs_kernels_in_both_variants(monkeypatch):
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    checks = {check.name: check.ok for check in diagnosis.diagnose()}
    assert [checks[name] for name in ("LLVM", "Dr.Jit", "llvm_ad_mono", "llvm_ad_spectral")] == [True] * 4


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals")
def test_diagnosis_survives_and_reports_an_abort(monkeypatch):
    check = found(monkeypatch, running="import os; os.abort()")["Dr.Jit"]
    assert (check.ok, check.detail) == (False, "the process was ended by SIGABRT")


def test_cache_that_cannot_be_written_is_no_failure(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("DRJIT_CACHE_DIR", str(tmp_path / "file"))
    check = found(monkeypatch)["kernel cache"]
    assert check.ok is None
    assert check.detail == f"{tmp_path / 'file'} is not writable, every run compiles its kernels again"


def report(*checks: Check, encoding: str = "utf-8") -> tuple[bool, list[str]]:
    """Print a report; return the verdict and the lines."""
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    verdict = print_doctor(checks, Console(file=file, width=60))
    file.seek(0)
    return verdict, file.read().splitlines()


GOOD = Check(name="Python", ok=True, detail="3.12.1")
NOTE = Check(name="CUDA", ok=None, detail="none found")
BAD = Check(name="LLVM", ok=False, detail="none found", cure="apt-get install libllvm19")


def test_verdict_is_ready_where_nothing_failed():
    verdict, lines = report(GOOD, NOTE)
    assert verdict
    assert lines[-1].startswith("gemrender is ready: ")


def test_verdict_names_the_first_failure_and_its_cure():
    verdict, lines = report(GOOD, BAD, Check(name="Dr.Jit", ok=False, detail="aborted"))
    assert not verdict
    assert lines[-1] == "gemrender cannot run here: LLVM: apt-get install libllvm19"


def test_what_works_without_mitsuba_is_told():
    _, lines = report(GOOD, BAD, Check(name=diagnosis.EXACT_ENGINE, ok=True, detail="numba"))
    assert lines[-2].startswith("gemrender cannot run here: LLVM: ")
    assert "gemrender score --engine exact" in lines[-1]


def test_the_exact_engine_is_checked_without_mitsuba(monkeypatch):
    check = found(monkeypatch, running="raise SystemExit('no Mitsuba')")["exact engine"]
    assert check.ok
    assert check.detail.startswith("numba ")


def test_cure_stays_on_one_line_however_narrow_the_terminal():
    cure = " ".join(["apt-get install"] * 10)
    _, lines = report(Check(name="LLVM", ok=False, detail="", cure=cure))
    assert f"LLVM: {cure}" in lines


def test_report_is_plain_where_the_terminal_is():
    _, lines = report(GOOD, BAD, Check(name="LLVM", ok=None, detail="/home/zoë"), encoding="ascii")
    assert "".join(lines).isascii()

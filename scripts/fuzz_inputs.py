"""Damage every kind of input at random, and count what the command line makes of it.

python scripts/fuzz_inputs.py [--number 3000] [--seed 1] [--longest 20] [--keep FOLDER]

An input is accepted (status 0) or refused (status 2, one line); anything else is a failure, and told: a
traceback, another status, a refusal of several lines, JSON that is none, a result of a damaged journal that
is not that of a whole one, or an input that takes longer than `--longest` seconds.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import re
import signal
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cli.program import run
from gemrender.reading import bundled_files

#: Values that stand where numbers, texts and lists did.
NASTY = (
    "1e308", "-1e308", "1e-308", "5e-324", "nan", "inf", "-inf", "-0.0", "0", "-1", "1" * 400, "9" * 19,
    "true", '""', '"x"', "[]", "[[]]", "[1, [2, [3]]]", "{}", "{a = 1}", "1979-05-27", "0x10", "1_000", "''",
    '"' + "é" * 200 + '"',
)  # fmt: skip
#: The same where there is no TOML.
NASTY_CELLS = (
    "",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e999",
    "=1+1",
    "'",
    '"',
    "0x10",
    "1_000",
    "9" * 400,
    "\0",
    "½",
    "1,5",
)
SCORE = ["--engine", "reference", "--resolution", "4", "--json"]
STUDY = ["--draws", "3", "--engine", "reference", "--resolution", "8", "--json"]

TABLE = """\
name;table;crown_angle;pavilion_angle;star;lower_half;girdle_thickness;material
one;57;34,5;40,8;50;80;3;diamond
two;54;33;41;55;75;2,5;sapphire
"""
REPORTS = """\
Report No,Shape,Carat,Table %,Depth %,Crown Angle,Pavilion Angle,Girdle,Culet,Star,Lower Half
A1,Round Brilliant,1.01,57,61.5,34.5,40.8,Thin - Medium,None,50,80
B2,Round,0.9,56,62.1,35,40.6,Medium,Pointed,,
"""
FANCY_REPORTS = """\
Report No,Shape,Carat,Measurements,L/W,Table %,Depth %,Girdle,Culet,Star,Mains
A1,Oval Brilliant,1.08,8.10 x 5.95 x 3.70 mm,1.36,57,62.2,Medium,None,50,8
B2,EM,1.52,7.50-5.40x3.55,,65,65.7,Slightly Thick,None,,
C3,Cushion Modified Brilliant,1.2,6.10 x 5.90 x 3.95,1.03,60,66.9,Medium,Very Small,,
"""
FANCY_REPORT = """\
name = "A report of an oval"
[report]
shape = "Oval Brilliant"
table = 57
depth = 62.2
girdle = "Medium"
culet = "none"
star = 50
[size]
measurements = "8.10 x 5.95 x 3.70 mm"
length_mm = 8.1
carat = 1.08
"""
REPORT = """\
name = "A report"
[report]
table = 57
depth = 61.5
crown_angle = 34.5
pavilion_angle = 40.8
girdle = "Thin - Medium"
culet = "none"
[material]
index = 1.77
"""
MATERIALS = (
    """\
name = "A glass"
density = 3.2
[index]
formula = "sellmeier"
coefficients = [[1.03, 0.077], [0.23, 0.141], [1.01, 10.18]]
range_nm = [360, 1000]
[absorption]
wavelength_nm = [380, 500, 760]
per_mm = [0.3, 0.1, 0.0]
""",
    """\
[index]
wavelength_nm = [380, 486, 589, 656, 760]
n = [1.75, 1.73, 1.72, 1.71, 1.70]
""",
)


class TooLongError(Exception):
    """An input has taken longer than is allowed."""


# ---- Damage --------------------------------------------------------------------------------------------


def damaged(text: str, rng: np.random.Generator, nasty: tuple[str, ...]) -> bytes:
    """Return a text after one or two accidents."""
    data = text
    for _ in range(int(rng.integers(1, 3))):
        data = ACCIDENTS[int(rng.integers(len(ACCIDENTS)))](data, rng, nasty)
    out = data.encode("utf-8", "surrogatepass")
    kind = rng.integers(12)
    if kind == 0:
        out = b"\xef\xbb\xbf" + out
    elif kind == 1:
        out = out.replace(b"\n", b"\r\n")
    elif kind == 2 and out:
        at = int(rng.integers(len(out)))
        out = out[:at] + bytes(rng.integers(0, 256, 8, dtype=np.uint8)) + out[at:]
    return out


def _value(text: str, rng: np.random.Generator, nasty: tuple[str, ...]) -> str:
    """Put a nasty value where a value was."""
    found = list(re.finditer(r'(?<=[=,;\[ ])"?[\w.+-]+"?(?=[,;\]\n ])', text))
    if not found:
        return text
    match = found[int(rng.integers(len(found)))]
    return text[: match.start()] + nasty[int(rng.integers(len(nasty)))] + text[match.end() :]


def _cut(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    if not text:
        return text
    first, last = sorted(rng.integers(0, len(text) + 1, 2))
    return text[:first] + text[last:] if rng.integers(2) else text[:last]


def _twice(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    lines = text.split("\n")
    k = int(rng.integers(len(lines)))
    return "\n".join([*lines[: k + 1], *lines[k:]])


def _shuffled(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    lines = text.split("\n")
    rng.shuffle(lines)
    return "\n".join(lines)


def _letter(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    if not text:
        return text
    k = int(rng.integers(len(text)))
    return text[:k] + str(rng.choice(list('aZ0=[]{}",;.-#\n\t\\\0é石'))) + text[k + 1 :]


def _deep(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    depth = int(rng.integers(10, 3000))
    return text.replace("\n", f"\nx = {'[' * depth}{']' * depth}\n", 1)


def _long(text: str, rng: np.random.Generator, _: tuple[str, ...]) -> str:
    return text + "a" * int(rng.integers(1, 200_000)) if rng.integers(2) else text * int(rng.integers(2, 60))


ACCIDENTS: tuple[Callable[[str, np.random.Generator, tuple[str, ...]], str], ...] = (
    _value, _value, _value, _value, _cut, _twice, _shuffled, _letter, _letter, _deep, _long,
)  # fmt: skip


# ---- Kinds of input ------------------------------------------------------------------------------------


def kinds() -> dict[str, tuple[list[str], str, tuple[str, ...], Callable[[Path], list[str]]]]:
    """Return by name: texts to damage, the ending of the file, nasty values, and the command for it."""
    stones = [path.read_text(encoding="utf-8") for path in bundled_files("").values()]
    setups = [path.read_text(encoding="utf-8") for path in bundled_files("setups").values()]
    return {
        "stones": (
            [*stones, REPORT, FANCY_REPORT],
            ".toml",
            NASTY,
            lambda path: ["score", str(path), *SCORE],
        ),
        "tables": (
            [TABLE, REPORTS, FANCY_REPORTS],
            ".csv",
            NASTY_CELLS,
            lambda path: ["score", str(path), *SCORE],
        ),
        "set-ups": (
            setups,
            ".toml",
            NASTY,
            lambda path: ["scene", "inoue-3", "--setup", str(path), "--size", "8", "--out", str(path.parent)],
        ),
        "materials": (list(MATERIALS), ".toml", NASTY, lambda path: ["materials", str(path), "--json"]),
        "journals": (
            [whole_journal()],
            ".jsonl",
            ("NaN", "Infinity", "null", '"x"', "[]", "{}", "1e999", "-5", "[0, NaN, 1]", "[1]"),
            lambda path: ["symmetry", "inoue-3", *STUDY, "--out", str(path.parent)],
        ),
    }


def whole_journal() -> str:
    """Return the journal of a study that was not interrupted."""
    with tempfile.TemporaryDirectory() as folder:
        called("symmetry", "inoue-3", *STUDY, "--out", folder)
        return Path(folder, "inoue-3-symmetry.jsonl").read_text(encoding="utf-8")


def called(*arguments: str) -> tuple[int, str, str]:
    """Run the command line; return exit status, stdout and stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = run(list(arguments))
    return status, out.getvalue(), err.getvalue()


@contextlib.contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raise TooLongError after a time."""

    def late(*_: Any) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def outcome(kind: str, arguments: list[str], longest: float, truth: Any) -> str:
    """Return "accepted", "refused", or what went wrong."""
    try:
        with at_most(longest):
            status, out, err = called(*arguments)
    except TooLongError:
        return "hang"
    except BaseException:
        return "traceback: " + traceback.format_exc(limit=-3).replace("\n", " | ")
    if status == 2:
        return "refused" if err.strip().count("\n") == 0 and not out else f"refused in several lines: {err!r}"
    if status != 0 or "Traceback" in err:
        return f"status {status}: {err!r}"
    if "--json" in arguments:
        try:
            values = json.loads(out, parse_constant=lambda word: 1 / 0)
        except (ValueError, ZeroDivisionError):
            return f"no JSON: {out[:200]!r}"
        if kind == "journals" and values != truth:
            return f"poisoned: {out[:300]!r}"
    return "accepted"


def main() -> None:
    """Damage, run, count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=3000, help="inputs in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=float, default=20.0, help="time that an input may take [s]")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where to keep inputs that fail")
    options = parser.parse_args()

    rng = np.random.default_rng(options.seed)
    inputs = kinds()
    truth = json.loads(called("symmetry", "inoue-3", *STUDY)[1])
    called(
        "scene", "inoue-3", "--setup", "studio", "--size", "8", "--out", tempfile.mkdtemp()
    )  # Mitsuba starts
    counts = {kind: Counter[str]() for kind in inputs}
    slowest = dict.fromkeys(inputs, 0.0)
    for number in range(options.number):
        kind = list(inputs)[number % len(inputs)]
        texts, suffix, nasty, command = inputs[kind]
        data = damaged(texts[int(rng.integers(len(texts)))], rng, nasty)
        with tempfile.TemporaryDirectory() as folder:
            name = "inoue-3-symmetry" if kind == "journals" else "input"
            path = Path(folder, f"{name}{suffix}")
            path.write_bytes(data)
            started = time.perf_counter()
            found = outcome(kind, command(path), options.longest, truth)
            slowest[kind] = max(slowest[kind], time.perf_counter() - started)
        if found not in ("accepted", "refused"):
            print(f"{kind} {number}: {found}", flush=True)
            if options.keep is not None:
                options.keep.mkdir(parents=True, exist_ok=True)
                (options.keep / f"{number}{suffix}").write_bytes(data)
            found = found.split(":")[0].split(" ")[0]
        counts[kind][found] += 1
    columns = ("accepted", "refused", "traceback", "hang")
    print(f"{'':<12}{''.join(f'{name:>11}' for name in columns)}{'other':>8}{'longest [s]':>13}")
    for kind, found_of in counts.items():
        other = found_of.total() - sum(found_of[name] for name in columns)
        numbers = "".join(f"{found_of[name]:>11}" for name in columns)
        print(f"{kind:<12}{numbers}{other:>8}{slowest[kind]:>13.2f}")
    failed = sum(
        found_of.total() - found_of["accepted"] - found_of["refused"] for found_of in counts.values()
    )
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()

"""Scenes that gemrender wrote, rendered as their headings say: by Mitsuba's own program, or in Python."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from observations import environment, run_python
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.render.llvm import LLVM_VARIABLE, export_line
from gemrender.render.photoreal import make_gems
from gemrender.scene.bitmaps import read_bitmap
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import Setup, Sky
from gemrender.scene.xml import write_photoreal

#: A name that takes care to write: into a shell, into Python, and into an XML comment.
NAME = "a --- scene"

MITSUBA = Path(sys.executable).with_name("mitsuba")

#: Means of two pictures of 16 x 16 pixels and 256 samples, with random numbers that differ between them but
#: not from run to run; they are 0.1 % apart.
MEANS = 0.01
#: One picture twice, with sums in an order that threads choose [relative to the mean].
LAST_BITS = 1e-5

needs_the_program = pytest.mark.skipif(
    not MITSUBA.exists() or sys.platform == "win32", reason="needs Mitsuba's program, and a shell"
)


#: One light and one mesh: of several the order, and with it the picture, differs from run to run in Mitsuba's
#: own loader, and its program cannot be told otherwise. Light from everywhere: no noise.
SETUP = Setup(name="Overcast", sky=Sky(radiance=1.0))


def written(folder, *, stock):
    gems = make_gems([load_stone("inoue-3")])
    made = photoreal_scene(gems, SETUP, width=16, height=16, samples=256, stock=stock)
    return write_photoreal(folder, NAME, made, about="a stone", stock=stock)


@pytest.fixture
def stock(tmp_path, variant_llvm_ad_rgb):
    """A scene for Mitsuba's own program, in a folder with a blank and a quote in its name."""
    return written(tmp_path / "it's mine", stock=True)


def rendered_by_the_program(scene, variant, folder):
    """Render as a user does who types the exported line into a shell, then the program's name."""
    import mitsuba as mi

    folder.mkdir()
    script = f'{export_line()}\nexec "$0" -m {variant} "$1" -o x.exr'
    done = subprocess.run(
        ["sh", "-c", script, str(MITSUBA), str(scene)],
        cwd=folder, env=environment({LLVM_VARIABLE: ""}), capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return np.array(read_bitmap(folder / "x.exr").convert(mi.Bitmap.PixelFormat.RGB))


@needs_the_program
def test_the_program_renders_what_python_renders_in_both_variants(stock, tmp_path):
    import mitsuba as mi

    expected = np.array(mi.render(mi.load_file(str(stock))))[..., :3]
    assert expected.shape == (16, 16, 3)
    assert expected.min() > 0
    compiled = rendered_by_the_program(stock, "llvm_ad_rgb", tmp_path / "llvm")
    np.testing.assert_allclose(compiled, expected, rtol=0, atol=LAST_BITS * expected.mean())
    scalar = rendered_by_the_program(stock, "scalar_rgb", tmp_path / "scalar")
    np.testing.assert_allclose(scalar.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=MEANS)


@needs_the_program
def test_the_heading_has_the_lines_to_type(stock):
    heading, _, rest = stock.read_text(encoding="utf-8").partition("-->\n")
    assert rest.startswith("<scene version=")
    assert "--" not in heading.removeprefix("<!--")
    assert LLVM_VARIABLE in heading
    export, render = (line.strip() for line in heading.splitlines() if line.startswith("    "))
    assert export == 'eval "$(gemrender doctor -e)"'
    script = f'mitsuba() {{ printf "%s" "$@"; }}\n{render}'
    assert subprocess.run(["sh", "-c", script], capture_output=True, text=True).stdout == f"{NAME}.xml"


#: What a user did before the heading's lines.
BEFORE = ["", "import mitsuba; mitsuba.set_variant('scalar_rgb')", "import drjit, mitsuba"]


@pytest.mark.parametrize("before", chosen(BEFORE, BEFORE[1:2]))
def test_the_headings_lines_of_python_render_the_scene(before, tmp_path, variant_llvm_ad_spectral):
    path = written(tmp_path, stock=False)
    lines = path.read_text(encoding="utf-8").partition("-->\n")[0].splitlines()
    code = textwrap.dedent("\n".join(line for line in lines if line.startswith("    ")))
    shown = "import numpy\nprint(mi.variant(), numpy.isfinite(numpy.array(image)).all(), image.shape[:2])"
    done = run_python("-c", f"{before}\n{code}\n{shown}", cwd=tmp_path, environment={LLVM_VARIABLE: ""})
    assert done.stdout == "llvm_ad_spectral True (16, 16)\n", done.stderr

"""Mitsuba's own program on a scene that gemrender wrote, as the scene's heading says, from another folder."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from observations import environment

from gemrender.render.llvm import LLVM_VARIABLE, export_line
from gemrender.render.photoreal import make_gems
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup
from gemrender.scene.xml import write_photoreal
from gemrender.stone import load_stone

MITSUBA = Path(sys.executable).with_name("mitsuba")

#: Means of two pictures of 16 x 16 pixels and 256 samples, with random numbers that differ between them but
#: not from run to run; they are 0.1 % apart.
MEANS = 0.01
#: One picture twice, with sums in an order that threads choose [relative to the mean].
LAST_BITS = 1e-5

pytestmark = [
    pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program"),
    pytest.mark.skipif(sys.platform == "win32", reason="needs a shell"),
]


@pytest.fixture
def stock(tmp_path, variant_llvm_ad_rgb):
    """A scene for Mitsuba's own program, in a folder with a blank and a quote in its name."""
    gems = make_gems([load_stone("inoue-3")])
    made = photoreal_scene(gems, load_setup("white"), width=16, height=16, samples=256, stock=True)
    return write_photoreal(tmp_path / "it's mine", "a scene", made, about="a stone", stock=True)


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
    return np.array(mi.Bitmap(str(folder / "x.exr")).convert(mi.Bitmap.PixelFormat.RGB))


def test_the_program_renders_what_python_renders_in_both_variants(stock, tmp_path):
    import mitsuba as mi

    expected = np.array(mi.render(mi.load_file(str(stock))))[..., :3]
    assert expected.shape == (16, 16, 3)
    assert expected.min() > 0
    compiled = rendered_by_the_program(stock, "llvm_ad_rgb", tmp_path / "llvm")
    np.testing.assert_allclose(compiled, expected, rtol=0, atol=LAST_BITS * expected.mean())
    scalar = rendered_by_the_program(stock, "scalar_rgb", tmp_path / "scalar")
    np.testing.assert_allclose(scalar.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=MEANS)


def test_the_heading_has_the_lines_to_type(stock):
    heading, _, rest = stock.read_text(encoding="utf-8").partition("-->\n")
    assert rest.startswith("<scene version=")
    typed = [line.strip() for line in heading.splitlines() if line.startswith("    ")]
    assert typed == ['eval "$(gemrender doctor -e)"', "mitsuba 'a scene.xml'"]
    assert LLVM_VARIABLE in heading

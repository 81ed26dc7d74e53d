"""One seed, one picture: bit for bit, in fresh processes that run at once, with any number of threads."""

from __future__ import annotations

import subprocess
import sys

from observations import ROOT


def test_processes_at_once_render_the_same_picture():
    """`window` has four rectangles, whose order Mitsuba leaves to addresses in memory."""
    script = ROOT / "scripts" / "check_reproducibility.py"
    options = "--renders 4 --renders-a-process 2 --processes 2 --threads 1 0 --setups window"
    done = subprocess.run([sys.executable, str(script), *options.split()], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "window: 4 renders, 2 processes at once, 1 outcome (" in done.stdout

"""Image files by Mitsuba, which waits for ever for another thread where Dr.Jit has one."""

from __future__ import annotations

import os

import pytest
from observations import run_python

PROGRAM = """
import os
os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
import gemrender, numpy as np
mi = gemrender.mitsuba("llvm_ad_spectral")
import drjit as dr
from gemrender.scene.bitmaps import read_bitmap, write_bitmap
image = mi.Bitmap(np.full((8, 16, 3), 2, dtype=np.float32))
image.write("a.exr")
print(np.array(mi.Bitmap("a.exr")).mean(), dr.thread_count())
dr.set_thread_count(1)
write_bitmap(image, "b.exr")
print(np.array(read_bitmap("b.exr")).mean(), dr.thread_count())
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs a process on one processor")
def test_images_are_written_and_read_on_one_processor_and_on_one_thread(folder):
    done = run_python("-c", PROGRAM)
    assert (done.returncode, done.stdout) == (0, "2.0 2\n2.0 1\n"), done.stderr

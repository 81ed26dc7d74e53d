"""The process that renders the studio's pictures: orders come in by its input, pictures go out by its output.

A process of its own, as the map must wait neither for the cores nor for Python's lock, which is held while
kernels are traced; it runs at the lowest priority, and a crash in it ends nothing else. `pictures` starts it.

Orders are pickled: ("paint", Job), ("pause", None), ("go", None). Answers are pickled dictionaries.
"""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import sys
import threading
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from gemrender.errors import GemrenderError, GemrenderWarning

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["Job", "Orders", "Stage", "main", "paint"]


@dataclass(frozen=True, slots=True)
class Job:
    """A stone in a set-up and a setting, to be pictured, denoised or not; its pictures have its `key`."""

    key: int
    stone: Stone
    setup: str
    denoise: bool = False
    setting: str | None = None
    metal: str | None = None


class Stage(NamedTuple):
    """Side of a picture [pixels], and its last sample a pixel."""

    size: int
    spp: int


#: A small coarse picture first, which is there soon; the last one refines until its noise is not seen.
_STAGES = (Stage(128, 8), Stage(256, 16), Stage(512, 1024))
_NOISE = 0.01
#: Samples of a pass: some seconds of one core, so that a pass ends soon where it is wanted no more.
_PASS_SAMPLES = 1 << 18
#: The last stage's pictures are shown so far apart [s].
_APART = 1.0
#: Of 0 to 19: everything else comes first.
_NICE = 19

_log = logging.getLogger("gemrender.studio")


class Orders:
    """What is wanted: the newest job, and whether work at it pauses."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._job: Job | None = None
        self._is_paused = False
        self._begun: Job | None = None

    def take(self, order: str, job: Job | None = None) -> None:
        """Take an order: "paint" a job instead of the one before, "pause", or "go" on."""
        with self._changed:
            if order == "paint":
                self._job, self._is_paused = job, False
            else:
                self._is_paused = order == "pause"
            self._changed.notify_all()

    def next(self) -> Job:
        """Wait for a job that was not begun yet."""
        with self._changed:
            self._changed.wait_for(lambda: self._job is not self._begun and not self._is_paused)
            assert self._job is not None
            self._begun = self._job
            return self._job

    def go_on(self, job: Job) -> bool:
        """Wait while work pauses; return whether this job is still wanted."""
        with self._changed:
            self._changed.wait_for(lambda: self._job is not job or not self._is_paused)
            return self._job is job


def main() -> None:
    """Take orders until there are no more."""
    with contextlib.suppress(AttributeError, OSError):  # Windows has no priorities of this kind
        os.nice(_NICE)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    orders = Orders()
    threading.Thread(target=_read, args=(orders, sys.stdin.buffer), daemon=True).start()
    while True:
        job = orders.next()
        try:
            paint(job, orders, answers)
        except GemrenderError as error:
            _tell(answers, {"key": job.key, "why": " ".join(str(error).split())})
        except Exception as error:
            _log.warning("studio: %s: %s", type(error).__name__, error)
            _tell(answers, {"key": job.key, "why": f"cannot be rendered: {type(error).__name__}"})


def _read(orders: Orders, source: IO[bytes]) -> None:
    """Take orders until there is nobody to give them."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            orders.take(*pickle.load(source))
    os._exit(0)  # whatever is worked at is for nobody


def paint(
    job: Job, orders: Orders, answers: IO[bytes], stages: Sequence[Stage] = _STAGES, apart: float = _APART
) -> None:
    """Tell pictures of a job, until the last one or another job is wanted.

    Parameters
    ----------
    job, orders : Job, Orders
        What to paint, and what is wanted meanwhile.
    answers : binary file
        Where each picture is told, pickled.
    stages : sequence of Stage
        The pictures, at least two. Of all but the last one only the end is told.
    apart : float
        The last one's states are told so far apart [s].

    Raises
    ------
    GemrenderError
        It cannot be rendered.
    """
    from gemrender.render.photoreal import require_denoiser
    from gemrender.render.picture import Picture
    from gemrender.render.shots import prepare

    if job.denoise:
        require_denoiser()
    least_rays = stages[-2].spp * stages[-2].size ** 2
    for stage in stages:
        last = time.monotonic()
        is_last = stage is stages[-1]
        shot = prepare(
            job.stone, job.setup, setting=job.setting, metal=job.metal,
            size=stage.size, spp=stage.spp, noise=_NOISE if is_last else None,
        )  # fmt: skip

        def show(picture: Picture, share: float, stage: Stage = stage, is_last: bool = is_last) -> bool:
            nonlocal last
            if not orders.go_on(job):
                return False
            is_done = share >= 1.0
            # Of a coarse picture the end only; of the fine one no worse ones, now and then.
            is_worth = time.monotonic() - last > apart and picture.samples * stage.size**2 >= least_rays
            if is_done or (is_last and is_worth):
                last = time.monotonic()
                _tell(answers, _told(job, picture, share if is_last else 0.0, is_last and is_done))
            return True

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GemrenderWarning)  # the picture itself shows an empty scene
            stopped = shot.picture(on_pass=show, pass_samples=_PASS_SAMPLES).stopped
        if stopped == "interrupted":
            return


def _told(job: Job, picture: Any, share: float, is_done: bool) -> dict[str, Any]:
    return {
        "key": job.key,
        "png": (replace(picture, noisy=picture) if job.denoise else picture)._repr_png_(),
        "title": picture.title,
        "samples": picture.samples,
        "noise": float(picture.noise),
        "share": float(share),
        "isDone": is_done,
    }


def _tell(answers: IO[bytes], told: dict[str, Any]) -> None:
    pickle.dump(told, answers)
    answers.flush()


if __name__ == "__main__":
    main()

"""The pictures of one page: rendered by a process of their own (`painter`) while nothing moves."""

from __future__ import annotations

import contextlib
import json
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from gemrender.stone import Stone
from gemrender.studio.frames import Wanted
from gemrender.studio.painter import Job
from gemrender.studio.protocol import packed

__all__ = ["Pictures"]

#: What to do, and with which job; None ends.
_Order = tuple[str, Job | None] | None


class Pictures:
    """What is rendered for a page, and when.

    While something moves the process pauses after the pass that it is at. What then rests is the same scene,
    which goes on where it was, or another one.

    Parameters
    ----------
    send : callable
        Takes a message for the page; called by other threads.
    """

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send, self._lock = send, threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._orders: queue.SimpleQueue[_Order] = queue.SimpleQueue()
        self._scene, self._key = "", 0
        self._number: int | None = None  # of the state that rests; None while something moves
        self._last: dict[str, Any] | None = None

    def pause(self) -> None:
        """Stop soon: something moves."""
        with self._lock:
            if self._number is not None:
                self._number = None
                self._order("pause")

    def rest(self, wanted: Wanted, stone: Stone) -> None:
        """Render what rests, or go on with it."""
        with self._lock:
            if wanted.picture is None:
                self._end()
                return
            how = (wanted.picture, wanted.denoise, wanted.setting, wanted.metal)
            scene = json.dumps([wanted.cut, wanted.material, wanted.size_mm, *how], sort_keys=True)
            self._number = wanted.number
            if scene == self._scene and self._process is not None:
                self._order("go")
                if self._last is not None:
                    self._show(self._last)
                return
            self._scene, self._key, self._last = scene, self._key + 1, None
            if self._process is None:
                self._start()
            self._order("paint", Job(self._key, stone, *how))

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._end()

    # ---- The process ----

    def _start(self) -> None:
        command = [sys.executable, "-m", "gemrender.studio.painter"]
        # A session of its own: Ctrl-C is for the server, whose end it sees by the end of its input.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        self._orders = queue.SimpleQueue()
        for work in (partial(self._listen, self._process), partial(_write, self._process, self._orders)):
            threading.Thread(target=work, name="studio pictures", daemon=True).start()

    def _end(self) -> None:
        process, self._process = self._process, None
        self._scene, self._number, self._last = "", None, None
        if process is not None:
            self._orders.put(None)
            process.kill()
            process.wait()

    def _order(self, what: str, job: Job | None = None) -> None:
        if self._process is not None:
            self._orders.put((what, job))

    def _listen(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        with process.stdout as answers:
            while True:
                try:
                    told = pickle.load(answers)
                except (EOFError, OSError, pickle.UnpicklingError):
                    break
                with self._lock:
                    if self._process is process and told["key"] == self._key:
                        self._last = told
                        if self._number is not None:
                            self._show(told)
        with self._lock:
            if self._process is not process:
                return
            status, number = process.wait(), self._number
            self._end()  # the next rest starts another one
            self._send(packed({"type": "unpictured", "number": number, "why": _lost(status)}))

    def _show(self, told: dict[str, Any]) -> None:
        if "why" in told:
            self._send(packed({"type": "unpictured", "number": self._number, "why": told["why"]}))
            return
        facts = {key: told[key] for key in ("title", "samples", "noise", "share", "isDone")}
        header = {"type": "picture", "number": self._number, **facts}
        self._send(packed(header, {"png": np.frombuffer(told["png"], dtype=np.uint8)}))


def _write(process: subprocess.Popen[bytes], orders: queue.SimpleQueue[_Order]) -> None:
    """Hand orders on; who gives them never waits for a process that has not begun to read."""
    assert process.stdin is not None
    with contextlib.suppress(OSError), process.stdin as target:  # lost meanwhile: seen by who listens
        while (order := orders.get()) is not None:
            pickle.dump(order, target)
            target.flush()


def _lost(status: int) -> str:
    how = f"signal {-status}" if status < 0 else f"exit status {status}"
    return f"the process that renders ended by {how}" + ("; perhaps memory ran out" if status == -9 else "")

"""One page: what it sends is taken here, and answers go out, whatever carries both."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any

from gemrender.errors import GemrenderError, InputError
from gemrender.studio.desk import Desk
from gemrender.studio.live import Live, Shown
from gemrender.studio.protocol import packed, unpacked

__all__ = ["Session"]

#: Questions that may wait: a page asks one at a time, by hand.
_MOST_ASKED = 32


class Session:
    """A page at work.

    Parameters
    ----------
    desk : Desk
        What it can open and save.
    send : callable
        Takes a message for the page; called by other threads.
    shown : callable, optional
        Takes what the page shows, whenever that is something else; called by other threads.
    """

    def __init__(self, desk: Desk, send: Callable[[bytes], None], shown: Shown | None = None) -> None:
        self._desk, self._send = desk, send
        self._live = Live(desk.shelf, send, shown)
        self._asked: queue.Queue[tuple[Mapping[str, Any], bytes] | None] = queue.Queue(_MOST_ASKED)
        threading.Thread(target=self._answer, name="studio answers", daemon=True).start()

    def take(self, message: str | bytes) -> None:
        """Take what the page sent; returns at once."""
        header: Mapping[str, Any] = {}
        try:
            header, data = unpacked(message)
            if header["type"] == "state":
                self._live.want(header)
            else:
                self._asked.put_nowait((header, data))
        except queue.Full:
            self._fail(header, InputError("too much is asked for at once", key="message"))
        except GemrenderError as error:
            self._fail(header, error)

    def close(self, wait: float = 0.0) -> None:
        """End the work; with a time [s] wait so long for its threads to end."""
        while True:
            try:
                self._asked.put_nowait(None)
                break
            except queue.Full:  # what nobody hears any more
                self._asked.get_nowait()
        self._live.close(wait)

    def _answer(self) -> None:
        while (asked := self._asked.get()) is not None:
            header, data = asked
            try:
                self._send(self._desk.answer(header, data))
            except GemrenderError as error:
                self._fail(header, error)
            except (RecursionError, TypeError, ValueError, KeyError) as error:
                self._fail(
                    header, InputError(f"cannot be: {type(error).__name__}", key=str(header["type"])[:40])
                )

    def _fail(self, header: Mapping[str, Any], error: Exception) -> None:
        why = " ".join(str(error).split())
        self._send(packed({"type": "failed", "of": header.get("type"), "why": why}))

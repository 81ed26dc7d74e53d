"""What is worked at for one page: the newest state it wants, and what is found out of it while it stays.

Two threads: one makes frames, the other studies; a process renders (`pictures`). What the page does not want
any more is dropped, before it is begun or while it is worked at.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from gemrender.beam import prepare
from gemrender.errors import GemrenderError, InputError
from gemrender.scoring import Score
from gemrender.stone import Stone
from gemrender.studio.frames import MOVING, RESTING, Wanted, frame, is_final
from gemrender.studio.pictures import Pictures
from gemrender.studio.protocol import packed
from gemrender.studio.studies import Outdated, studies

__all__ = ["Live", "Shown"]

#: Nothing has moved for so long before studies begin [s]: longer than a page on a slow machine draws.
_REST = 0.4

_log = logging.getLogger("gemrender.studio")

Send = Callable[[bytes], None]
Shown = Callable[[Wanted, Stone, Score], None]


class _Seen(NamedTuple):
    """What a page shows: the count of what it wanted, that, its stone, and whether it is the same at rest."""

    generation: int
    wanted: Wanted
    stone: Stone
    is_final: bool


class Live:
    """The work for one page.

    Parameters
    ----------
    shelf : dict of str to Stone
        The stones that were opened, by key; may grow.
    send : callable
        Takes a message for the page; called by other threads.
    shown : callable, optional
        Takes what the page shows, its stone and its score; called by other threads.
    """

    def __init__(self, shelf: dict[str, Stone], send: Send, shown: Shown | None = None) -> None:
        self._shelf, self._send, self._tell = shelf, send, shown
        self._pictures = Pictures(send)
        self._changed = threading.Condition()
        self._newest: Mapping[str, Any] | None = None
        self._generation, self._done = 0, 0
        self._shown: _Seen | None = None
        self._is_closed = False
        self._threads = [
            threading.Thread(target=work, name=f"studio {name}", daemon=True)
            for name, work in (("frames", self._make_frames), ("studies", self._study))
        ]
        for thread in self._threads:
            thread.start()

    def want(self, told: Mapping[str, Any]) -> None:
        """Take over what the page wants; what it wanted before is dropped."""
        with self._changed:
            self._pictures.pause()
            self._newest = told
            self._generation += 1
            self._changed.notify_all()

    def close(self, wait: float = 0.0) -> None:
        """End the work; with a time [s] wait so long for the threads to end."""
        with self._changed:
            self._is_closed = True
            self._generation += 1
            self._changed.notify_all()
        self._pictures.close()
        for thread in self._threads:
            thread.join(wait)

    # ---- Frames ----

    def _make_frames(self) -> None:
        try:
            prepare()
        except Exception as error:  # what it could not do is tried again for each frame, and told there
            _log.warning("studio: %s: %s", type(error).__name__, error)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_closed or self._done != self._generation)
                if self._is_closed:
                    return
                generation, told = self._generation, self._newest
            assert told is not None
            shown = self._frame(told)
            with self._changed:
                self._done = generation
                self._shown = None if shown is None else _Seen(generation, *shown)
                self._changed.notify_all()

    def _frame(self, told: Mapping[str, Any]) -> tuple[Wanted, Stone, bool] | None:
        """Send a frame, or in one line why there is none; return what it is of, and whether it is final."""
        number = told.get("number")
        try:
            wanted = Wanted.of(told)
            stone = wanted.stone(self._shelf)
            header, arrays, score = frame(wanted, stone, MOVING)
            self._show(wanted, stone, header, arrays, score)
        except (GemrenderError, RecursionError) as error:
            self._refuse(number, error)
            return None
        except Exception as error:
            _log.warning("studio: %s: %s", type(error).__name__, error)
            self._refuse(number, InputError("cannot be shown; the server's terminal says more"))
            return None
        return wanted, stone, is_final(header)

    def _show(self, wanted: Wanted, stone: Stone, header: Any, arrays: Any, score: Score) -> None:
        self._send(packed(header, arrays))
        if self._tell is not None:
            self._tell(wanted, stone, score)

    def _refuse(self, number: object, error: Exception) -> None:
        self._send(packed({"type": "refused", "number": number, "why": " ".join(str(error).split())}))

    # ---- Studies ----

    def _study(self) -> None:
        studied = 0
        while (shown := self._rested(studied)) is not None:
            studied, wanted, stone, _ = shown
            check = partial(self._check, studied)
            try:
                self._picture(studied, wanted, stone)
                if not shown.is_final:
                    self._settle(check, wanted, stone)
                for message in studies(wanted, stone, self._shelf, check):
                    check()
                    self._send(packed(message))
                self._send(packed({"type": "rested", "number": wanted.number}))
            except Outdated:
                continue
            except Exception as error:  # a study that fails is one that is missing
                _log.warning("studio: %s: %s", type(error).__name__, error)

    def _rested(self, studied: int) -> _Seen | None:
        """Wait until something else than what was studied is shown, and for a while; None at the end."""
        with self._changed:
            while not self._is_closed:
                shown = self._shown
                if shown is None or shown.generation == studied or shown.generation != self._generation:
                    self._changed.wait()
                elif not self._changed.wait(_REST):
                    return shown
            return None

    def _picture(self, studied: int, wanted: Wanted, stone: Stone) -> None:
        with self._changed:  # or what moves meanwhile would have paused it before
            self._check(studied)
            self._pictures.rest(wanted, stone)

    def _settle(self, check: Callable[[], None], wanted: Wanted, stone: Stone) -> None:
        """Send the frame again with the bound that scores have at rest."""
        made = frame(wanted, stone, RESTING)
        check()
        self._show(wanted, stone, *made)

    def _check(self, generation: int) -> None:
        if self._generation != generation:
            raise Outdated

"""The studio in notebooks: a widget that shows the same page, and works as the server does.

A frame holds the page; its messages go through the widget's comm, as binary buffers, to the same `Session`.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gemrender.errors import BackendError

if TYPE_CHECKING:
    from gemrender.cuts import StoneLike
    from gemrender.scoring import Score
    from gemrender.stone import Stone
    from gemrender.studio.frames import Wanted

try:
    import anywidget
    import traitlets
except ImportError as _error:
    _missing: str | None = str(_error.name)
else:
    _missing = None

__all__ = ["Studio"]

#: Most views that are worked for: a notebook that is loaded anew does not say that its old ones are gone.
_MOST_VIEWS = 8
_HEIGHT = 760
_CURE = "pip install 'gemrender[widget]'"

if _missing is not None:  # and a line says so where it is asked for, not where it is imported

    class Studio:
        """The studio in a notebook; needs anywidget."""

        def __init__(self, stone: StoneLike = "inoue-3", *, height: int = _HEIGHT) -> None:
            raise BackendError(f"the studio in notebooks needs {_missing}; to get it: {_CURE}")

else:
    from gemrender.studio.assets import WIDGET, files

    class Studio(anywidget.AnyWidget):  # type: ignore[misc, no-redef]
        """A stone in a notebook that answers while its sliders are dragged: the page of `gemrender studio`.

        ::

            studio = gemrender.Studio("inoue-3")
            studio                      # the last line of a cell: shown
            studio.stone, studio.score  # in a later cell: what it shows by then
            studio.observe(lambda change: print(change.new.average), "score")

        Parameters
        ----------
        stone : Stone, str or path
            The stone that it begins with: as of `load_stone`, or what it takes.
        height : int
            Height of the page in the notebook [pixels].

        Attributes
        ----------
        stone : Stone
            The stone that is shown; another one may be given in its place.
        score : Score or None
            Its score, of the view that is shown, with the bound that it has so far; None until something is
            shown. `observe` calls back from the studio's own thread.

        Raises
        ------
        InputError
            The stone cannot be read, or is not convex.
        BackendError
            anywidget is not installed; with the cure.
        """

        _esm = files()[WIDGET][1].decode()
        stone = traitlets.Any()
        score = traitlets.Any(None, allow_none=True, read_only=True)
        height = traitlets.Int(_HEIGHT, min=200, max=4000).tag(sync=True)

        def __init__(self, stone: StoneLike = "inoue-3", *, height: int = _HEIGHT) -> None:
            from gemrender.studio.desk import Desk

            self._sessions: dict[str, Any] = {}
            self._lock = threading.Lock()
            self._shown: Stone | None = None
            begun = _checked(stone)
            self._desk = Desk([begun])
            super().__init__(stone=begun, height=height)
            self.observe(self._given, "stone")
            self.on_msg(self._hear)

        @traitlets.validate("stone")  # type: ignore[untyped-decorator]
        def _validate_stone(self, proposal: Any) -> Stone:
            return _checked(proposal.value)

        def close(self) -> None:
            """End the work of all views, and the widget."""
            with self._lock:
                ended, self._sessions = list(self._sessions.values()), {}
            for session in ended:
                session.close()
            super().close()

        # ---- Views ----

        def _hear(self, _: Any, content: Any, buffers: Sequence[Any]) -> None:
            """Take what a view sends."""
            if not isinstance(content, dict) or not isinstance(view := content.get("view"), str):
                return
            kind = content.get("type")
            if kind == "begin":
                self._begin(view)
            elif kind == "end":
                with self._lock:
                    session = self._sessions.pop(view, None)
                if session is not None:
                    session.close()
            elif kind == "message" and (session := self._sessions.get(view)) is not None:
                session.take(bytes(buffers[0]) if buffers else str(content.get("text", "")))

        def _begin(self, view: str) -> None:
            from gemrender.studio.assets import embedded_page
            from gemrender.studio.session import Session

            def send(message: bytes) -> None:
                self.send({"view": view, "type": "message"}, [message])

            with self._lock:
                known = list(self._sessions)
                old = [self._sessions.pop(name) for name in known[: max(len(known) + 1 - _MOST_VIEWS, 0)]]
                self._sessions[view] = Session(self._desk, send, self._follow)
            for session in old:
                session.close()
            self.send({"view": view, "type": "page"}, [embedded_page(self._desk.told())])

        def _follow(self, wanted: Wanted, stone: Stone, score: Score) -> None:
            """Take over what a view shows."""
            self._shown = stone
            self.stone = stone
            self.set_trait("score", score)

        def _given(self, change: Any) -> None:
            """Show a stone that was given."""
            if change.new is self._shown:
                return
            message = self._desk.put_first(change.new)
            with self._lock:
                views = list(self._sessions)
            for view in views:
                self.send({"view": view, "type": "message"}, [message])


def _checked(stone: Any) -> Stone:
    """Return the stone that is meant, and see that the studio can show it."""
    from gemrender.cuts import as_stone
    from gemrender.studio.cuttings import check_convex

    made = as_stone(stone)
    check_convex(made)
    return made

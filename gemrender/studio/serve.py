"""The studio started: a free port on loopback, a token, the browser."""

from __future__ import annotations

import contextlib
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable, Sequence

from gemrender.errors import BackendError, InputError
from gemrender.stone import Stone

__all__ = ["check_installed", "listen", "serve"]

#: Bytes of the token: as many as cannot be guessed.
_TOKEN_BYTES = 16
_CURE = "pip install 'gemrender[studio]'"


def check_installed() -> None:
    """See that the server's libraries are there.

    Raises
    ------
    BackendError
        One is not installed; says the cure.
    """
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
        import websockets  # noqa: F401
    except ImportError as error:
        raise BackendError(f"the studio needs {error.name}; to get it: {_CURE}") from error


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens there; port 0 is any free one.

    Raises
    ------
    InputError
        The host is none of this machine's addresses, or the port is taken or out of range.
    """
    if not 0 <= port <= 65535:
        raise InputError("must be from 0 to 65535", key="port", value=port)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((host, port))
    except (OSError, OverflowError, UnicodeError) as error:
        listening.close()
        is_port = isinstance(error, OSError) and port and error.errno in (13, 98, 48, 10013, 10048)
        key, value = ("port", port) if is_port else ("host", host)
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be listened at: {reason}", key=key, value=value) from error
    return listening


def serve(
    stones: Sequence[Stone],
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    open_browser: bool = True,
    tell: Callable[[str], object] = print,
) -> None:
    """Serve the studio until it is interrupted.

    Parameters
    ----------
    stones : sequence of Stone
        The stones that it begins with.
    host : str
        Address to listen at; loopback is what only this machine reaches.
    port : int
        Port; 0 for any free one.
    open_browser : bool
        Whether to open the page.
    tell : callable
        Takes the address, once it is reached.

    Raises
    ------
    InputError
        As of `listen`.
    BackendError
        A library is not installed; says the cure.
    """
    check_installed()
    import uvicorn

    from gemrender.studio.app import make_app
    from gemrender.studio.desk import Desk
    from gemrender.studio.protocol import MOST_MESSAGE

    with listen(host, port) as listening:
        at = listening.getsockname()[1]
        token = secrets.token_urlsafe(_TOKEN_BYTES)
        name = f"[{host}]" if ":" in host else host
        address = f"http://{name}:{at}/{token}/"
        server = uvicorn.Server(
            uvicorn.Config(
                make_app(Desk(stones), token, at, host),
                log_level="warning",
                access_log=False,
                ws_max_size=MOST_MESSAGE,
                ws_per_message_deflate=False,
                timeout_graceful_shutdown=1,
                server_header=False,
            )
        )
        tell(address)
        if open_browser:
            threading.Thread(target=_open, args=(address,), daemon=True).start()
        server.run(sockets=[listening])


def _open(address: str) -> None:
    with contextlib.suppress(webbrowser.Error):
        webbrowser.open(address)

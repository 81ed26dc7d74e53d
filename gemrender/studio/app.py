"""The server: the page and its files, and the websocket that a page's work goes through.

Everything lies under the token, so that relative links need none. Who has no token, comes from a page of
another origin, or by a host name that is not the server's own (DNS rebinding) is refused before anything else
looks at the request. No path of a request is ever one of the disk: files are known by their names beforehand.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import secrets
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from gemrender.studio.assets import TYPES, WIDGET, files, page
from gemrender.studio.desk import Desk
from gemrender.studio.protocol import MOST_MESSAGE
from gemrender.studio.session import Session

__all__ = ["make_app"]

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}
#: Messages that may wait for a slow page.
_MOST_WAITING = 256


def make_app(desk: Desk, token: str, port: int, host: str = "127.0.0.1") -> App:
    """Return the server as an ASGI application.

    Parameters
    ----------
    desk : Desk
        What pages can open and save.
    token : str
        What the address begins with.
    port : int
        Port that it is reached at.
    host : str
        Address that it listens on.
    """
    served = {name: of for name, of in files().items() if not name.endswith(".html") and name != WIDGET}

    async def file(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in served:
            return PlainTextResponse("no such file", 404)
        kind, data = served[name]
        return Response(data, media_type=kind)

    async def begin(request: Request) -> Response:
        return Response(page(desk.told()), media_type=TYPES["html"])

    async def live(socket: WebSocket) -> None:
        await _serve(socket, desk)

    app = Starlette(
        routes=[
            Route("/{token}/", begin),
            Route("/{token}/assets/{name}", file),
            WebSocketRoute("/{token}/live", live),
        ]
    )
    return _Guard(app, token, _hosts(host, port), is_open=not _is_loopback(host), port=port)


# ---- Who may ask ---------------------------------------------------------------------------------------


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _hosts(host: str, port: int) -> set[str]:
    names = {host, "localhost", "127.0.0.1", "[::1]"}
    if ":" in host:
        names = {name for name in names if name != host} | {f"[{host}]"}
    return {f"{name}:{port}" for name in names}


class _Guard:
    """What stands before the application, and adds the headers of every answer."""

    def __init__(self, app: App, token: str, hosts: Iterable[str], *, is_open: bool, port: int) -> None:
        self._app, self._token, self._hosts = app, token.encode(), set(hosts)
        self._is_open, self._port = is_open, port

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        why = self._refused(scope)

        async def with_headers(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message.get("headers", []),
                    *((name.encode(), value.encode()) for name, value in HEADERS.items()),
                ]
            await send(message)

        if not why:
            await self._app(scope, receive, with_headers)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            await PlainTextResponse(why, 403)(scope, receive, with_headers)

    def _refused(self, scope: Scope) -> str:
        """Return why a request is refused; empty if it is not."""
        given = [(name.lower(), value.decode("latin-1")) for name, value in scope["headers"]]
        hosts = [value for name, value in given if name == b"host"]
        origins = [value for name, value in given if name == b"origin"]
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return "another host name than the server's"
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return "asked from another page"
        if scope["type"] == "websocket" and not origins:
            return "asked from no page"
        part = scope["path"].split("/", 2)[1] if scope["path"].startswith("/") else ""
        if not secrets.compare_digest(part.encode("utf-8", "replace"), self._token):
            return "the address has not the token that the terminal shows"
        return ""

    def _is_own(self, host: str) -> bool:
        if host.lower() in self._hosts:
            return True
        if not self._is_open:
            return False
        # Listening beyond this machine: by number, as no name of elsewhere can be.
        name, _, port = host.rpartition(":")
        with contextlib.suppress(ValueError):
            ipaddress.ip_address(name.strip("[]"))
            return port == str(self._port)
        return False


# ---- A page --------------------------------------------------------------------------------------------


async def _serve(socket: WebSocket, desk: Desk) -> None:
    """Answer a page until it goes."""
    await socket.accept()
    loop, waiting = asyncio.get_running_loop(), asyncio.Queue[bytes]()

    def send(message: bytes) -> None:
        def put() -> None:
            if waiting.qsize() < _MOST_WAITING:
                waiting.put_nowait(message)

        with contextlib.suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(put)

    async def write() -> None:
        while True:
            await socket.send_bytes(await waiting.get())

    session, writer = Session(desk, send), asyncio.create_task(write())
    try:
        while True:
            event = await socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            message = event.get("bytes") or event.get("text") or ""
            if len(message) > MOST_MESSAGE:
                await socket.close(1009)
                return
            session.take(message)
    except WebSocketDisconnect:
        return
    finally:
        writer.cancel()
        session.close()

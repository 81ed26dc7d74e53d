"""The page and its files: as a server serves them, and as one document that needs nothing else."""

from __future__ import annotations

import base64
import json
import re
import secrets
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

__all__ = ["TYPES", "WIDGET", "embedded_page", "files", "page"]

_OWN = resources.files("gemrender.studio").joinpath("page")
#: What the page shares with the report.
_SHARED = resources.files("gemrender.report").joinpath("assets")
SHARED = ("tracer.js", "dom.js", "light.js", "ray.js", "stone.js", "stage.js", "three.min.js", "page.css")
TYPES = {
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "html": "text/html; charset=utf-8",
}
#: The script that notebooks load; it is no file of the page.
WIDGET = "widget.js"
#: What the document within a notebook may do: run what it has brought with it, and nothing from elsewhere.
_POLICY = (
    "default-src 'none'; script-src 'nonce-{nonce}' data:; style-src data:; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)
#: How modules import each other.
_IMPORT = re.compile(r"from '\./([\w.]+)'")


@cache
def files() -> dict[str, tuple[str, bytes]]:
    """Return type and content of all files of the page, by name."""
    found: dict[str, tuple[str, bytes]] = {}
    for file in [*(_SHARED.joinpath(name) for name in SHARED), *_OWN.iterdir()]:
        ending = file.name.rpartition(".")[2]
        if ending in TYPES:
            found[file.name] = (TYPES[ending], file.read_bytes())
    return found


def page(told: Mapping[str, Any]) -> bytes:
    """Return the page; `told` is what it is told at once, for JSON."""
    # Data that no HTML parser takes for anything else.
    data = json.dumps(told, separators=(",", ":"), allow_nan=False)
    for sign in "&<>":
        data = data.replace(sign, f"\\u{ord(sign):04x}")
    return files()["index.html"][1].replace(b"{{data}}", data.encode())


def embedded_page(told: Mapping[str, Any]) -> bytes:
    """Return the page with all its files in it, for a frame in a notebook.

    Its modules are found by an import map, as within data addresses no file is beside another.
    """
    html = page({**told, "isEmbedded": True}).decode()
    nonce = secrets.token_urlsafe(16)
    modules = {
        f"gemrender/{name}": _address(name)
        for name in files()
        if _OWN.joinpath(name).is_file() and name.endswith(".js") and name != WIDGET
    }
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY.format(nonce=nonce)}">\n'
        f'<script type="importmap" nonce="{nonce}">{json.dumps({"imports": modules})}</script>\n'
    )
    html = html.replace('<meta charset="utf-8">\n', '<meta charset="utf-8">\n' + head, 1)
    return re.sub(r'"assets/([\w.]+)"', lambda found: f'"{_address(found[1])}"', html).encode()


@cache
def _address(name: str) -> str:
    """Return a file as a data address; of a module the imports are by names of the import map."""
    kind, data = files()[name]
    text = _IMPORT.sub(r"from 'gemrender/\1'", data.decode()).encode()
    return f"data:{kind.replace(' ', '')};base64,{base64.b64encode(text).decode()}"

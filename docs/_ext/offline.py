"""Pages that fetch nothing: formulae as MathML, and a check that no page loads from elsewhere."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

_LOG = logging.getLogger(__name__)
#: What a browser fetches of itself: scripts, pictures, frames, style sheets, fonts.
_FETCHES = re.compile(
    r"""<(?:script|img|iframe|source|video|embed)\b[^>]*?\bsrc(?:set)?=["'](?:https?:)?//"""
    r"""|<link\b(?![^>]*\brel=["'](?:canonical|search|next|prev|index|author)["'])[^>]*?\bhref=["'](?:https?:)?//"""
    r"""|@import[^;]*?(?:https?:)?//|url\(["']?(?:https?:)?//""",
    re.IGNORECASE,
)


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _display(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(f'<div class="math">{_mathml(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def _mathml(node: nodes.Element, *, as_block: bool) -> str:
    """Return a formula as MathML, by docutils."""
    try:
        return tex2mathml(node.astext(), as_block=as_block)
    except ValueError as error:
        _LOG.warning("formula: %s", error, location=node)
        return f"<code>{escape(node.astext())}</code>"


def _check(app: Sphinx, failed: Exception | None) -> None:
    """Warn of pages that load something from elsewhere."""
    if failed or app.builder.format != "html":
        return
    for path in [*Path(app.outdir).rglob("*.html"), *Path(app.outdir).rglob("*.css")]:
        for found in _FETCHES.finditer(path.read_text(encoding="utf-8")):
            _LOG.warning("%s fetches from elsewhere: %s", path.relative_to(app.outdir), found.group()[:200])


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the renderer of formulae, and the check."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    app.connect("build-finished", _check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

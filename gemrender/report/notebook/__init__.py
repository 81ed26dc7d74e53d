"""What notebooks show of results: HTML with its drawings in it, readable on light ground and on dark."""

from __future__ import annotations

from gemrender.report.notebook.pages import html_of

__all__ = ["html_of"]

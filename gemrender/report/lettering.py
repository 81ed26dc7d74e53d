"""Letters of figures: fonts for the names of stones, which may be in any script."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["boxes_for_letters", "name_fonts", "save_png"]

#: Fonts with Japanese and Chinese, of which the first that is there helps out where DejaVu has no letter.
_EAST_ASIAN = ("Noto Sans CJK JP", "Noto Sans JP", "Hiragino Sans", "Yu Gothic", "Meiryo", "MS Gothic",
               "IPAexGothic", "IPAGothic", "TakaoGothic", "WenQuanYi Zen Hei")  # fmt: skip


def name_fonts() -> list[str]:
    """Return the fonts for a stone's name."""
    from matplotlib.font_manager import fontManager

    there = {font.name for font in fontManager.ttflist}
    return ["DejaVu Sans", *[font for font in _EAST_ASIAN if font in there][:1]]


@contextmanager
def boxes_for_letters() -> Iterator[None]:
    """Do not warn of letters that no font has; they are drawn as boxes."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        yield


def save_png(figure: Figure, path: Path, **options: Any) -> None:
    """Save a figure as PNG, at its own resolution."""
    with boxes_for_letters():
        figure.savefig(path, format="png", dpi=figure.dpi, **options)

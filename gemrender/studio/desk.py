"""What pages can open and save: the shelf of stones, the families, files that were dropped."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any

from gemrender.cuts import bundled_stones, load_stone
from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.measures import measures
from gemrender.optics.materials import material_names
from gemrender.optics.metals import METALS
from gemrender.report.measure_maps import ZONE_COLOURS
from gemrender.report.page import common_data
from gemrender.scene.settings.setting import SETTINGS
from gemrender.scene.setup import bundled_setups
from gemrender.scoring import BAND_EDGES
from gemrender.stone import Stone
from gemrender.studio.cuttings import family_cutting, opened, stone_of
from gemrender.studio.frames import Wanted
from gemrender.studio.protocol import packed
from gemrender.studio.texts import SAVED_KINDS, dropped_stones, saved

__all__ = ["Desk"]

#: Most dropped stones that are kept: past them the oldest is forgotten.
_MOST_DROPPED = 400


class Desk:
    """What the pages of one server share.

    Parameters
    ----------
    stones : sequence of Stone
        The stones that the studio was started with.
    """

    def __init__(self, stones: Sequence[Stone] = ()) -> None:
        self.shelf: dict[str, Stone] = {}
        self._count, self._lock = 0, threading.Lock()
        self._first: list[str] = []
        for stone in stones:
            self._first.append(self._put(stone))
        self._answers: dict[str, Callable[[Mapping[str, Any], bytes], bytes]] = {
            "open": self._open,
            "drop": self._drop,
            "save": self._save,
        }

    def _put(self, stone: Stone) -> str:
        with self._lock:
            self._count += 1
            key = f"stone {self._count}"
            self.shelf[key] = stone
            dropped = [of for of in self.shelf if of not in self._first]
            for old in dropped[: max(len(dropped) - _MOST_DROPPED, 0)]:
                del self.shelf[old]
        return key

    def put_first(self, stone: Stone) -> bytes:
        """Take over a stone as the one that pages begin with; return what tells open pages to show it."""
        key = self._put(stone)
        self._first[:1] = [key]
        return _opened([opened(stone, key).to_dict()])

    def told(self) -> dict[str, Any]:
        """Return what a page is told when it is opened, for JSON."""
        common = common_data()
        return {
            **common,
            "colours": {**common["colours"], "zones": ZONE_COLOURS},
            # As `light.js` knows the bands.
            "stones": [{"score": {"bands": [{"low": low} for low in BAND_EDGES]}}],
            "shelf": [{"key": key, "name": self.shelf[key].name} for key in self._first],
            "families": list(families()),
            "bundled": bundled_stones(),
            "materials": material_names(),
            "kinds": SAVED_KINDS,
            "setups": bundled_setups(),
            "settings": SETTINGS,
            "metals": tuple(METALS),
            "hasDenoiser": find_spec("mitsuba_oidn") is not None,
            "measures": [
                {
                    "name": of.name,
                    "definition": of.definition,
                    "source": of.source,
                    "unit": of.unit,
                    "keys": of.keys,
                }
                for of in measures()
                if of.name != "inoue"
            ],
        }

    def answer(self, header: Mapping[str, Any], data: bytes) -> bytes:
        """Answer what a page asks for once.

        Raises
        ------
        InputError
            It asks for what cannot be.
        """
        asked = self._answers.get(header["type"])
        if asked is None:
            raise InputError(f"must be one of state, {', '.join(self._answers)}", key="type")
        return asked(header, data)

    def _open(self, header: Mapping[str, Any], data: bytes) -> bytes:
        """Open a family, a bundled stone, the cutting of a link, or one of the shelf."""
        if isinstance(cut := header.get("cut"), Mapping):
            # Of a design the sliders are those of the file; what a link has changed of it stays the page's.
            own = {**cut, "values": {}} if "design" in cut else cut
            name, material = str(header.get("name") or "stone")[:100], header.get("material")
            key = str(cut.get("stone"))
            return _opened([opened(stone_of(own, self.shelf, name, material), key).to_dict()])
        if "family" in header:
            return _opened([family_cutting(str(header["family"])).to_dict()])
        if "bundled" in header:
            name = header["bundled"]
            if name not in bundled_stones():  # and never a path
                raise InputError("must be a bundled stone", key="bundled", value=name)
            return _opened([opened(load_stone(_bundled_file(name)), "").to_dict()])
        key = str(header.get("key"))
        if key not in self.shelf:
            raise InputError("is not open any more", key="stone", value=key)
        return _opened([opened(self.shelf[key], key).to_dict()])

    def _drop(self, header: Mapping[str, Any], data: bytes) -> bytes:
        """Open a file that was dropped on the page."""
        stones = dropped_stones(str(header.get("name") or "file"), data)
        return _opened([opened(stone, self._put(stone)).to_dict() for stone in stones])

    def _save(self, header: Mapping[str, Any], data: bytes) -> bytes:
        """Return a stone as a file."""
        told = header.get("state")
        if not isinstance(told, Mapping):
            raise InputError("must be what the page shows", key="state")
        wanted, kind = Wanted.of(told), str(header.get("kind"))
        stone = wanted.stone(self.shelf)
        content = _content(stone, wanted, kind)
        return packed({"type": "saved", "name": f"{_stem(wanted.name)}.{_ending(kind)}"}, {"file": content})


def _bundled_file(name: str) -> Any:
    from gemrender.reading import bundled_files

    return bundled_files("")[name]


def _opened(stones: list[dict[str, Any]]) -> bytes:
    return packed({"type": "opened", "stones": stones})


def _stem(name: str) -> str:
    return re.sub(r"[^\w.-]+", "-", name).strip("-.")[:80] or "stone"


def _ending(kind: str) -> str:
    return {"scores": "csv", "report": "html", "vertices": "csv"}.get(kind, kind)


def _content(stone: Stone, wanted: Wanted, kind: str) -> Any:
    import numpy as np

    if kind == "scores":
        text = _scores_csv(stone, wanted)
    elif kind == "report":
        text = _report(stone, wanted)
    else:
        return np.frombuffer(saved(stone, "csv" if kind == "vertices" else kind), dtype=np.uint8)
    return np.frombuffer(text.encode(), dtype=np.uint8)


def _scores_csv(stone: Stone, wanted: Wanted) -> str:
    """Return the scores as `gemrender score --format csv` prints them."""
    from gemrender.report.formats import csv_lines
    from gemrender.report.tables import score_record
    from gemrender.scoring import score

    told = score(
        stone, tilt=wanted.tilt, tilt_azimuth=wanted.azimuth, head=wanted.head,
        measures=wanted.measures or None,
    )  # fmt: skip
    return "".join(f"{line}\r\n" for line in csv_lines([score_record(told)]))


def _report(stone: Stone, wanted: Wanted) -> str:
    from gemrender.report.page import report_html
    from gemrender.report.studied import study_stone

    return report_html([study_stone(stone, tilt=wanted.tilt, tilt_azimuth=wanted.azimuth)])

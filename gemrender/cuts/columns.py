"""Columns of tables of stones: which of them are known, under the many names that people give them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

from gemrender.cuts.families import families
from gemrender.cuts.families.stated import stated_keys
from gemrender.errors import InputError
from gemrender.reading import did_you_mean

__all__ = ["ALIASES", "SIZE_ALIASES", "Columns", "known_column", "match_columns"]

#: Names of each column, as `_folded` leaves them: without case, blanks, punctuation and units ("Table %",
#: "TABLE_PCT" and "table (%)" are all "table"). The first name of each is that of stone files.
ALIASES: dict[str, tuple[str, ...]] = {
    "table": ("table", "tablesize", "tablewidth", "tablediameter", "tablefacet", "tbl", "tb"),
    "depth": ("depth", "totaldepth", "depthtotal", "totalheight", "td"),
    "crown_angle": ("crownangle", "crownang", "crangle", "crang", "crnangle", "crownmainangle", "ca"),
    "crown_height": ("crownheight", "crownht", "crheight", "crht", "crnheight", "crowndepth", "ch"),
    "pavilion_angle": (
        "pavilionangle", "pavilionang", "pavangle", "pavang", "pvangle", "pavilionmainangle", "pa",
    ),
    "pavilion_depth": (
        "paviliondepth", "pavilionheight", "pavdepth", "pavheight", "pavht", "pavdp", "pvdepth", "pd", "ph",
    ),
    "girdle": ("girdle", "girdledescription", "girdledesc", "girdlename", "girdlewords", "girdlerange"),
    "girdle_thickness": ("girdlethickness", "girdlesize", "girdleaverage", "gt"),
    "girdle_thin": ("girdlethin", "girdlemin", "girdleminimum", "girdlefrom", "girdlethinnest", "mingirdle"),
    "girdle_thick": ("girdlethick", "girdlemax", "girdlemaximum", "girdleto", "girdlethickest", "maxgirdle"),
    "star": ("star", "starlength", "starlen", "starfacet", "starfacets", "starfacetlength", "sl"),
    "lower_half": (
        "lowerhalf", "lowerhalflength", "lowerhalflen", "lowerhalves", "lowerhalffacet", "lowergirdle",
        "lowergirdlelength", "lowergirdlefacet", "lowergirdlefacets", "lowergirdlehalf", "lh", "lhl", "lgf",
    ),
    "lower_girdle_contact": ("lowergirdlecontact",),
    "culet": ("culet", "culetsize", "culetgrade"),
    "shape": ("shape", "shapename", "cutshape", "stoneshape"),
    "name": (
        "name", "stone", "stonename", "label", "reportno", "reportnumber", "report", "certificateno",
        "certificatenumber", "certno", "certnumber", "certificateid", "cert", "certificate", "giano",
        "stockno", "stocknumber", "stockid", "stock", "stoneid", "diamondid", "lotno", "lotnumber", "lot",
        "itemno", "itemid", "sku", "id",
    ),
    "material": ("material", "materialname"),
    "index": ("index", "materialindex", "refractiveindex", "ri"),
}  # fmt: skip

#: The same of columns that tell the size of a stone, and of its length over its width: of use for shapes
#: that are not round. Millimetres are told from per cent by their names.
SIZE_ALIASES: dict[str, tuple[str, ...]] = {
    "measurements": (
        "measurements", "measurement", "measurementsmm", "measurementmm", "meas", "measmm", "dimensions",
        "dimension", "dimensionsmm", "dims", "dim", "lxwxd", "lwd", "mm",
    ),
    "length_mm": (
        "lengthmm", "length", "len", "lenmm", "measurementslength", "measurementlength", "measlength",
        "measlengthmm", "lengthofstone", "stonelength",
    ),
    "width_mm": (
        "widthmm", "width", "wid", "measurementswidth", "measurementwidth", "measwidth", "measwidthmm",
        "stonewidth",
    ),
    "depth_mm": (
        "depthmm", "totaldepthmm", "heightmm", "height", "measurementsdepth", "measurementdepth", "measdepth",
        "measdepthmm", "measurementsheight", "measheight", "stonedepth", "stoneheight",
    ),
    "diameter_mm": ("diametermm", "diameter", "diam", "dia", "diammm"),
    "carat": (
        "carat", "carats", "ct", "cts", "weight", "wt", "caratweight", "caratwt", "weightct", "weightcts",
        "weightcarat", "weightcarats", "caratsize", "ctsize", "ctweight", "ctwt", "cttw",
    ),
    "length_to_width": (
        "lengthtowidth", "lengthwidth", "lengthtowidthratio", "lengthwidthratio", "lw", "lwratio", "ratio",
        "ltow", "ltowratio", "aspectratio",
    ),
}  # fmt: skip

_KEY = {alias: key for key, aliases in ALIASES.items() for alias in aliases}
_SIZE_KEY = {alias: key for key, aliases in SIZE_ALIASES.items() for alias in aliases}
#: What describes a cut; the rest does in any table.
_CUT = {key for key in ALIASES if key not in ("name", "material", "index", "shape", "star")}
_UNITS = {
    "percent", "percentage", "pct", "perc", "per", "degrees", "degree", "deg", "avg", "average", "mean",
    "value", "in", "of",
}  # fmt: skip
_GLUED = re.compile(r"(?<=[a-z]{2})(?:percentage|percent|pct|perc|per|degrees|degree|deg)$")
#: Taken for no slip: lists have other columns that are called alike ("Cut Grade" and "Culet Grade").
_NEVER_MEANT = {"culet", "shape", "name", "girdle_thin", "girdle_thick"}
#: From this likeness on, a column is taken for a slip in the name of a known one (of difflib, 0 to 1).
_LIKENESS = 0.85


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of a table.

    Parameters
    ----------
    place : dict of str to int
        Where each known column is, by key of `ALIASES`.
    title : dict of str to str
        What the table calls it.
    unused : tuple of str
        Titles of the columns that round brilliants do not use.
    others : dict of str to int
        Where columns are that stones of other shapes use besides, by key: of `SIZE_ALIASES`, or of a family.
    """

    place: dict[str, int]
    title: dict[str, str]
    unused: tuple[str, ...]
    others: dict[str, int] = field(default_factory=dict)


def _folded(title: str) -> tuple[str, bool]:
    """Return a title without case, punctuation and units, and whether it had a unit."""
    has_unit = bool(re.search(r"[%°]", title))
    split = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", title)  # CrownAngle
    split = split.replace("#", " no ")
    words = re.findall(r"[^\W_]+", split.casefold())
    kept = [word for word in words if word not in _UNITS]
    glued = "".join(kept or words)
    name = _GLUED.sub("", glued)
    return name, has_unit or name != "".join(words)


def known_column(title: str) -> str | None:
    """Return the key of a column by its title; None for one that is not known, in millimetres for example."""
    name, has_unit = _folded(title)
    key = _KEY.get(name)
    return "girdle_thickness" if key == "girdle" and has_unit else key


def match_columns(titles: Sequence[str]) -> Columns | None:
    """Find the known columns of a table.

    Parameters
    ----------
    titles : sequence of str
        The cells of its first row.

    Returns
    -------
    Columns or None
        None where no title is that of a part of a stone.

    Raises
    ------
    InputError
        Two columns for one thing, or one that looks like a slip in a known name.
    """
    titles = ["".join(c if c.isprintable() else "\ufffd" for c in title) for title in titles]
    found: dict[str, list[int]] = {}
    for i, title in enumerate(titles):
        if key := known_column(title):
            found.setdefault(key, []).append(i)
    if not _CUT & found.keys():
        return None
    place = {key: _one(key, places, titles) for key, places in found.items()}
    used = set(place.values())
    unused = tuple(title.strip() for i, title in enumerate(titles) if i not in used and title.strip())
    others = _others(titles, place)
    known = {titles[i].strip() for i in others.values()}
    for title in unused:
        if title not in known and (meant := _slip(title, found)):
            raise InputError(f"unknown column{did_you_mean(meant, [meant])}", key=title)
    title_of = {key: titles[i].strip() for key, i in (others | place).items()}
    return Columns(place, title_of, unused, others)


def _others(titles: Sequence[str], place: dict[str, int]) -> dict[str, int]:
    """Find columns of sizes and of parameters of families; the first of those for one thing."""
    found: dict[str, int] = {}
    for i, title in enumerate(titles):
        if i in place.values():
            continue
        name = _folded(title)[0]
        key = _SIZE_KEY.get(name) or _family_keys().get(name)
        if key is None and _KEY.get(name) == "depth":  # the other one is in per cent
            key = "depth_mm"
        if key is not None and key not in place:
            found.setdefault(key, i)
    return found


@cache
def _family_keys() -> dict[str, str]:
    """Return the keys of families that have no other names, by their names as `_folded` leaves them."""
    keys = (key for kind in families().values() for key in stated_keys(kind))
    return {name: key for key in keys if (name := _folded(key)[0]) not in _KEY and name not in _SIZE_KEY}


def _one(key: str, places: list[int], titles: Sequence[str]) -> int:
    """Choose among columns of one meaning: the first name of a stone; else the only one with a unit."""
    if key == "name":
        return min(places, key=lambda i: ALIASES["name"].index(_folded(titles[i])[0]))
    if len(places) > 1:
        with_unit = [i for i in places if _folded(titles[i])[1]]
        if len(with_unit) != 1:
            columns = " and ".join(repr(titles[i].strip()) for i in places)
            raise InputError(
                f"columns {columns} are both the {key.replace('_', ' ')}; keep one", key="header"
            )
        places = with_unit
    return places[0]


def _slip(title: str, found: dict[str, list[int]]) -> str | None:
    """Return the key of a column that is not there, and that the title is a misspelling of."""
    name = _folded(title)[0]
    for alias, key in _KEY.items():
        # What has a name whole, and more, is something else: "Crown Height (mm)", "Crown Angle Min".
        more = len(name) >= len(alias) + 2 and alias in name
        if key in found or key in _NEVER_MEANT or len(alias) < 4 or more:
            continue
        exchanged = len(name) == len(alias) and sorted(name) == sorted(alias)
        alike = difflib.SequenceMatcher(None, name, alias)
        if exchanged or (alike.real_quick_ratio() >= _LIKENESS and alike.ratio() >= _LIKENESS):
            return key
    return None

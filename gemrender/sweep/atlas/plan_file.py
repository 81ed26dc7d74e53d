"""Plans of atlases read from TOML files."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from gemrender.cuts import load_stone
from gemrender.cuts.families.suggest import stone_of
from gemrender.cuts.files import read_cut
from gemrender.cuts.variations import Value, check_keys, parse_setting, settings_of
from gemrender.engines import DEFAULT_BOUND, DEFAULT_HEAD, check_head
from gemrender.errors import InputError
from gemrender.measures import Measure, chosen_measures
from gemrender.optics.materials import named_index
from gemrender.reading import located_at, parse_toml, read_lines, refuse_unknown, section, stem
from gemrender.stone import Stone
from gemrender.sweep.atlas.plan import CHUNK, MOST_CELLS, AtlasPlan

__all__ = ["read_plan"]

#: Allowed numbers of stones of a chunk, and most views of a stone.
_CHUNKS, _MOST_VIEWS = (1, 65_536), 1000
#: So many stones are tried before a plan is refused of which none can be made.
_TRIED = 64

_TOP = (
    "name", "stone", "cut", "material", "vary", "sobol", "measures", "bound", "head", "tilts", "chunk",
)  # fmt: skip
_RANGE_FORMS = "must be first:last with first below last, two finite numbers"


def read_plan(path: str | Path) -> AtlasPlan:
    """Read the plan of an atlas from a TOML file.

    Parameters
    ----------
    path : str or path-like
        The file: `stone` or `[cut]`, `[vary]`, and what `docs/atlas.md` names besides.

    Raises
    ------
    InputError
        The file cannot be read; an unknown key; a parameter that the cut has not; a measure that there is
        not; too many stones; or no stone at all that can be made.
    """
    file = Path(path)
    with located_at(str(file)):
        top = parse_toml(read_lines(file, kind="plan", longest_line=3500), kind="plan")
        refuse_unknown(top, _TOP)
        plan = _plan(top, file)
        _check_stones(plan)
    return plan


def _plan(top: dict[str, Any], file: Path) -> AtlasPlan:
    from gemrender.beam import beam_stone, check_bound

    base = _base(top, file)
    grid, ranges = _varied(top, base)
    tilts = _tilts(top.get("tilts", []))
    number, seed = _sobol(top, bool(ranges))
    beam_stone(base)  # convex, or refused
    name = top.get("name", stem(file, "atlas"))
    if not isinstance(name, str) or not name.strip() or len(name) > 100:
        raise InputError("must be a text of 1 to 100 characters", key="name", value=name)
    plan = AtlasPlan(
        name=name.strip(),
        stone=base,
        grid=grid,
        ranges=ranges,
        number=number,
        seed=seed,
        measures=_measures(top.get("measures", "inoue"), bool(tilts)),
        bound=check_bound(top.get("bound", DEFAULT_BOUND)),
        head=check_head(top.get("head", DEFAULT_HEAD)),
        tilts=tilts,
        chunk=_whole(top, "chunk", CHUNK, *_CHUNKS),
    )
    if plan.stones > MOST_CELLS:
        sizes = " x ".join(map(str, plan.shape))
        raise InputError(
            f"makes {sizes} = {plan.stones} stones; at most {MOST_CELLS} are allowed", key="vary"
        )
    return plan


def _base(top: dict[str, Any], file: Path) -> Stone:
    """Return the stone that is varied."""
    if ("stone" in top) == ("cut" in top):
        has = "both" if "stone" in top else "none"
        raise InputError(
            f"needs exactly one of stone, a name or a file, and a section [cut]; has {has}", key="stone"
        )
    if "cut" in top:
        cut, taken = read_cut(top["cut"])
        with located_at(None, "cut"):
            stone = stone_of(
                cut, name=str(top["cut"]["family"]), source=str(file), description="cut", assumed=taken
            )
    else:
        named = top["stone"]
        if not isinstance(named, str) or not named.strip():
            raise InputError("must be the name of a bundled stone, or of a file", key="stone", value=named)
        beside = file.parent / named
        try:
            stone = load_stone(beside if beside.is_file() else named)
        except InputError as error:
            if error.source is not None and Path(error.source).exists():
                raise
            raise InputError(error.allowed, key="stone", value=named) from error
    if "material" in top:
        stone = replace(stone, material=_material(top["material"]))
    return stone


def _material(value: Any) -> str | float:
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise InputError("must be the name of a material, or a refractive index", key="material", value=value)
    try:
        named_index(value)
    except InputError as error:
        raise InputError(error.allowed, key="material", value=value) from error
    return value if isinstance(value, str) else float(value)


def _varied(
    top: dict[str, Any], base: Stone
) -> tuple[dict[str, tuple[Value, ...]], dict[str, tuple[float, float]]]:
    """Return the grid's values, and the ranges of the Sobol design."""
    given = section(top | {"vary": top.get("vary", {})}, "vary", settings_of(base))
    if not given:
        raise InputError(f"has no parameter; may have {', '.join(settings_of(base))}", key="[vary]")
    grid: dict[str, tuple[Value, ...]] = {}
    ranges: dict[str, tuple[float, float]] = {}
    with located_at(None, "vary"):
        check_keys(base, given)
        for key, value in given.items():
            if isinstance(value, str) and value.count(":") == 1:
                ranges[key] = _range(key, value)
                continue
            grid[key] = _values(key, value, base)
            if len(set(grid[key])) < len(grid[key]):
                raise InputError("has a value twice", key=key, value=value)
            for one in grid[key] if key in ("material", "index") else ():
                _material(one)
    return grid, ranges


def _values(key: str, value: Any, base: Stone) -> tuple[Value, ...]:
    """Return the values of a parameter on the grid: a text as of --set, a value, or a list of them."""
    if isinstance(value, str):
        return parse_setting(f"{key}={value}", settings_of(base))[1]
    listed = value if isinstance(value, list) else [value]
    words = all(isinstance(each, str) and each.strip() for each in listed)
    numbers = all(
        isinstance(each, (int, float)) and not isinstance(each, bool) and math.isfinite(each)
        for each in listed
    )
    if not listed or not (words or numbers):
        raise InputError(
            'must be a value, a list of values, first:last:step such as "39:42:0.1", or first:last for a '
            "Sobol design",
            key=key,
            value=value,
        )
    return tuple(listed) if words else tuple(map(float, listed))


def _range(key: str, text: str) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        raise InputError(_RANGE_FORMS, key=key, value=text) from None
    if key == "material" or not -math.inf < low < high < math.inf:
        raise InputError(_RANGE_FORMS, key=key, value=text)
    return low, high


def _sobol(top: dict[str, Any], needed: bool) -> tuple[int, int]:
    """Return number of stones and seed of the Sobol design; 0 where there is none."""
    if not needed:
        if "sobol" in top:
            raise InputError('is of no use: no parameter in [vary] is a range such as "39:42"', key="[sobol]")
        return 0, 1
    if "sobol" not in top:
        raise InputError('missing: a range such as "39:42" needs number and seed here', key="[sobol]")
    values = section(top, "sobol", ("number", "seed"))
    with located_at(None, "sobol"):
        if "number" not in values:
            raise InputError("missing", key="number")
        return _whole(values, "number", 0, 1, MOST_CELLS), _whole(values, "seed", 1, 0, 2**63 - 1)


def _whole(values: dict[str, Any], key: str, default: int, low: int, high: int) -> int:
    value = values.get(key, default)
    if type(value) is not int or not low <= value <= high:
        raise InputError(f"must be a whole number from {low} to {high}", key=key, value=value)
    return value


def _tilts(given: Any) -> tuple[tuple[float, float], ...]:
    """Return tilts and azimuths of views: numbers, or pairs of them."""
    allowed = "must be a list of tilts, 0 to below 90, or of [tilt, azimuth] in degrees"
    if not isinstance(given, list) or len(given) > _MOST_VIEWS:
        raise InputError(f"{allowed}, at most {_MOST_VIEWS}", key="tilts", value=given)
    out = []
    for each in given:
        pair = each if isinstance(each, list) else [each, 0.0]
        good = len(pair) == 2 and all(type(part) in (int, float) and math.isfinite(part) for part in pair)
        if not good or not 0 <= pair[0] < 90:
            raise InputError(allowed, key="tilts", value=each)
        out.append((float(pair[0]), float(pair[1])))
    if len(set(out)) < len(out):
        raise InputError("has a view twice", key="tilts", value=given)
    return tuple(out)


def _measures(given: Any, tilted: bool) -> tuple[Measure, ...]:
    allowed = "must be names of measures, with commas between them or as a list"
    names = given if isinstance(given, list) else [given]
    if not all(isinstance(name, str) for name in names):
        raise InputError(allowed, key="measures", value=given)
    chosen = chosen_measures(names)
    if "all" in names:
        chosen = tuple(of for of in chosen if of.keys and (of.views == "one" or not tilted))
    for of in chosen:
        if not of.keys:
            raise InputError("has no numbers that an atlas could hold", key="measures", value=of.name)
        if tilted and of.views != "one":
            raise InputError("is a sum over all views and has no tilt", key="measures", value=of.name)
    return chosen


def _check_stones(plan: AtlasPlan) -> None:
    """Refuse a plan of which no stone can be made."""
    refused = []
    for setting in plan.sample(_TRIED):
        try:
            plan.made(setting)
            return
        except InputError as error:
            words = " ".join(f"{key}={value}" for key, value in setting.items())
            refused.append(f"{words}: {error.allowed if error.key is None else error}")
    raise InputError(f"no stone can be made; {refused[0]}", key="vary")

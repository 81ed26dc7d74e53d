"""What of a stone can be changed: sliders with a laboratory's words, and the stone that their values make.

A cutting is plain data, so that a link can hold it: `{"family": ..., "values": {...}}`, or
`{"design": text of an .asc file, "meets": ..., "values": {...}}`, either with `"crystal": {...}` as a stone
file has it, or, where nothing but the stone itself is known, `{"stone": key on the shelf}`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from typing import Any

from gemrender.cuts.convert import design_of
from gemrender.cuts.crystal_axes import orientation_values, read_orientation
from gemrender.cuts.design import LARGEST_ANGLE, Design
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.cuts.families.round_brilliant import Parameters as RoundParameters
from gemrender.cuts.families.stated import read_values
from gemrender.cuts.meets import WAYS, changeable
from gemrender.cuts.round_brilliant import RoundBrilliant
from gemrender.cuts.turning import Free, parameter_name, tier_parameters, values_of
from gemrender.errors import InputError
from gemrender.stone import Stone
from gemrender.studio.texts import asc_text, design_of_text, is_number, known_material

__all__ = ["Opened", "Slider", "check_convex", "family_cutting", "opened", "present_values", "stone_of"]

#: What laboratories call parameters, where that is not the name with blanks.
_LABELS = {
    "table": "Table size",
    "star": "Star length",
    "lower_half": "Lower half",
    "girdle_thickness": "Girdle",
    "crown_painting": "Painting, crown",
    "pavilion_painting": "Painting, pavilion",
}
#: What sliders reach where the family's range is far wider than what is cut; numbers may be typed beyond it.
_USUAL = {
    "table": (45.0, 75.0),
    "crown_angle": (20.0, 45.0),
    "pavilion_angle": (36.0, 46.0),
    "star": (30.0, 70.0),
    "lower_half": (60.0, 95.0),
    "girdle_thickness": (0.0, 10.0),
    "culet": (0.0, 10.0),
}
#: Others reach so far to either side of the family's own value, by unit; and steps of a slider.
_REACH = {"deg": 8.0, "%": 15.0, "": 0.4}
_STEP = {"deg": 0.05, "%": 0.1, "": 0.005}
#: Sliders of distances reach so far to either side [share of the largest].
_NEAR = 0.05
#: Longest text of a design [characters], and most values of a cutting.
MOST_TEXT, MOST_VALUES = 200_000, 400


@dataclass(frozen=True, slots=True, kw_only=True)
class Slider:
    """One number of a stone that can be changed.

    Attributes
    ----------
    name : str
        Its key among the values; of a list with its place, as "crown_angles.0".
    label : str
        What laboratories call it.
    unit : {"deg", "%", ""}
        What it counts.
    value : float, int or str
        What it is in the stone that was opened.
    low, high, step : float
        What the slider reaches, and its steps.
    least, most : float
        What is allowed.
    choices : tuple
        What it may be instead, where that is no number from a range.
    group : str
        Part of the stone that it belongs to.
    """

    name: str
    label: str
    unit: str
    value: Any = None
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    least: float = 0.0
    most: float = 0.0
    choices: tuple[Any, ...] = ()
    group: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Opened:
    """A stone as a page works at it.

    Attributes
    ----------
    cut : dict
        The cutting.
    sliders : tuple of Slider
        What of it can be changed.
    name : str
        What the stone is called.
    material : str, float or None
        As of the stone.
    size_mm : float or None
        As of the stone.
    """

    cut: dict[str, Any]
    sliders: tuple[Slider, ...]
    name: str
    material: str | float | None
    size_mm: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {**asdict(self), "sliders": [asdict(slider) for slider in self.sliders]}


def check_convex(stone: Stone) -> None:
    """See that the exact engine traces a stone.

    Raises
    ------
    InputError
        It is not convex.
    """
    if not stone.is_convex:
        raise InputError(
            "is not convex, and the studio shows convex stones only; gemrender report shows it",
            source=stone.source or stone.name,
        )


# ---- Opening -------------------------------------------------------------------------------------------


def opened(stone: Stone, key: str) -> Opened:
    """Return a stone as a page works at it; `key` is what the shelf knows it by.

    Raises
    ------
    InputError
        It is not convex.
    """
    check_convex(stone)
    cut: dict[str, Any]
    sliders: tuple[Slider, ...]
    of = stone.cut
    if isinstance(of, RoundBrilliant):
        of = _as_family(of)
    if isinstance(of, Family):
        cut, sliders = _family_cut(of), tuple(_family_sliders(of))
    elif isinstance(of, Design):
        design = design_of(stone)[0]
        cut, sliders = _design_cut(stone, design), tuple(_design_sliders(stone, design))
    else:
        cut, sliders = {"stone": key}, ()
    if stone.crystal is not None and "stone" not in cut:
        cut["crystal"] = orientation_values(stone.crystal)
    return Opened(cut=cut, sliders=sliders, name=stone.name, material=stone.material, size_mm=stone.size_mm)


def family_cutting(family: str) -> Opened:
    """Return a family's own stone, as its defaults make it.

    Raises
    ------
    InputError
        There is no such family.
    """
    known = families()
    if family not in known:
        raise InputError(f"must be one of {', '.join(known)}", key="family", value=family)
    return opened(known[family]().stone(name=f"New {family}"), "")


def _as_family(of: RoundBrilliant) -> RoundParameters:
    values = of.values()
    return RoundParameters(lower_half=100.0 - values.pop("lower_girdle_contact"), **values)


def _angles(cut: Family | type[Family]) -> dict[str, Any]:
    """Return the angles that stand for heights, by the height's name."""
    return {of.stands_for: of for of in cut.ALTERNATIVES if of.name.endswith("angle")}


def _family_cut(cut: Family) -> dict[str, Any]:
    values, angles = cut.values(), _angles(cut)
    stated: dict[str, Any] = {}
    for name, value in values.items():
        if name in angles:  # as laboratories measure it
            stated[angles[name].name] = float(angles[name].from_parameter(values))
        else:
            stated[name] = list(value) if isinstance(value, tuple) else value
    return {"family": cut.family(), "values": stated}


def _family_sliders(cut: Family) -> list[Slider]:
    kind, angles = type(cut), _angles(cut)
    own, given = _family_cut(kind())["values"], _family_cut(cut)["values"]
    out = []
    for part in fields(cut):  # type: ignore[arg-type]
        other = angles.get(part.name)
        name = other.name if other else part.name
        label = _LABELS.get(name) or name.replace("_", " ").capitalize()
        if "allowed" in part.metadata:
            choices = part.metadata["allowed"]
            out.append(Slider(name=name, label=label, unit="", value=given[name], choices=choices))
            continue
        least, most = (other.low, other.high) if other else part.metadata["range"]
        least = 0.0 if not other and part.metadata["or_zero"] else least
        unit = unit_of(cut, name)
        if not part.metadata["many"]:
            reach = _reach(name, own[name], given[name], unit, least, most)
            out.append(Slider(name=name, label=label, unit=unit, value=given[name], **reach))
            continue
        for place, value in enumerate(given[name]):
            reach = _reach("", value, value, unit, least, most)
            words = f"{label.removesuffix('s')} {place + 1}"
            out.append(Slider(name=f"{name}.{place}", label=words, unit=unit, value=value, **reach))
    return out


def _reach(name: str, own: float, given: float, unit: str, least: float, most: float) -> dict[str, Any]:
    low, high = _USUAL.get(name, (own - _REACH[unit], own + _REACH[unit]))
    low, high = max(min(low, own, given), least), min(max(high, own, given), most)
    step = _STEP[unit]
    return {
        "low": round(math.floor(low / step + 1e-9) * step, 6),
        "high": round(math.ceil(high / step - 1e-9) * step, 6),
        "step": step,
        "least": float(least),
        "most": float(most),
    }


def _design_cut(stone: Stone, design: Design) -> dict[str, Any]:
    return {"design": asc_text(design), "meets": "loose", "values": {}}


def _design_sliders(stone: Stone, design: Design) -> list[Slider]:
    """Return sliders for each tier's angle and distance."""
    number = {name: k for k, name in enumerate(design.facet_names())}
    widest = float(values_of(design)[1].max())
    out = []
    for tier, quantity in tier_parameters(design, (number[facet.name] for facet in stone.facets)):
        value, label = _shown(design, tier, quantity), design.tier_names()[tier]
        unit = "deg" if quantity == "angle_deg" else ""
        if unit:
            reach = _reach("", value, value, unit, 0.1, LARGEST_ANGLE - 0.1)
        else:
            label += " distance"
            reach = {
                "low": round(max(value - _NEAR * widest, 0.0), 3),
                "high": round(value + _NEAR * widest, 3),
                "step": 0.001,
                "least": 0.0,
                "most": 4.0 * widest,
            }
        name = parameter_name(design, tier, quantity)
        out.append(
            Slider(name=name, label=label, unit=unit, value=value, group=_group(design, tier), **reach)
        )
    return out


def _group(design: Design, tier: int) -> str:
    if abs(float(values_of(design)[0][tier])) >= LARGEST_ANGLE:
        return "Girdle"
    return "Crown" if design.tiers[tier].is_crown else "Pavilion"


def _shown(design: Design, tier: int, quantity: str) -> float:
    """Return a tier's angle or distance; angles have the file's own sign, below the girdle negative."""
    angles, distances = values_of(design)
    return abs(float(angles[tier])) if quantity == "angle_deg" else float(distances[tier])


def present_values(stone: Stone) -> dict[str, float]:
    """Return angles and distances that the tiers of a design have by now: some follow others."""
    if not isinstance(stone.cut, Design):
        return {}
    design, every = stone.cut, range(len(stone.cut.facet_tiers))
    return {
        parameter_name(design, tier, quantity): _shown(design, tier, quantity)
        for tier, quantity in tier_parameters(design, every)
    }


# ---- Making --------------------------------------------------------------------------------------------


def stone_of(
    cut: Mapping[str, Any], shelf: Mapping[str, Stone], name: str, material: object, size_mm: object = None
) -> Stone:
    """Make the stone of a cutting.

    Parameters
    ----------
    cut : mapping
        The cutting, as a page sends it: nothing of it is trusted.
    shelf : mapping of str to Stone
        The stones that were opened, by key.
    name : str
        What to call it.
    material : str, float or None
        A name of `material_names`, a refractive index, or None for diamond.
    size_mm : float, optional
        Diameter or longer side [mm].

    Raises
    ------
    InputError
        The cutting is none, or makes no stone.
    """
    of = known_material(material)
    if size_mm is not None and not (is_number(size_mm) and 0.0 < float(size_mm) < 1e4):  # type: ignore[arg-type]
        raise InputError("must be a number above 0 [mm]", key="size", value=size_mm)
    facts: dict[str, Any] = {"name": name, "material": of, "size_mm": size_mm}
    if "crystal" in cut:
        if not isinstance(cut["crystal"], Mapping):
            raise InputError("must be c_axis or angles", key="crystal")
        facts["crystal"] = read_orientation(cut["crystal"])
    values = cut.get("values", {})
    if not isinstance(values, Mapping) or len(values) > MOST_VALUES:
        raise InputError("must be values by name", key="values")
    if "family" in cut:
        known = families()
        kind = known.get(cut["family"]) if isinstance(cut["family"], str) else None
        if kind is None:
            raise InputError(f"must be one of {', '.join(known)}", key="family", value=cut["family"])
        made: Stone = read_values(kind, values)[0].stone(**facts)
        return made
    if "design" in cut:
        return _turned(cut, values).stone(**facts)
    stone = shelf.get(str(cut.get("stone")))
    if stone is None:
        raise InputError("is not open any more: open its file again", key="stone")
    return replace(stone, **facts)


def _turned(cut: Mapping[str, Any], values: Mapping[str, Any]) -> Design:
    """Return a design with angles and distances of some tiers changed, its meets kept or not."""
    text, meets = cut["design"], cut.get("meets", "loose")
    if not isinstance(text, str) or len(text) > MOST_TEXT:
        raise InputError(f"must be text of at most {MOST_TEXT} characters", key="design")
    if meets not in WAYS:
        raise InputError(f"must be one of {', '.join(WAYS)}", key="meets", value=meets)
    if not values:
        return design_of_text(text)
    ways = _ways(text, str(meets))
    every = range(len(ways.design.facet_tiers))
    known = {parameter_name(ways.design, *of): of for of in tier_parameters(ways.design, every)}
    changes: dict[Any, float] = {}
    for name, value in values.items():
        if name not in known or not is_number(value):
            raise InputError("must be an angle or a distance of a tier", key=str(name)[:40], value=value)
        tier, quantity = known[name]
        sign = -1.0 if quantity == "angle_deg" and not ways.design.tiers[tier].is_crown else 1.0
        changes[tier, quantity] = sign * float(value)
    return ways.changed(changes)


@lru_cache(maxsize=8)
def _ways(text: str, meets: str) -> Free:
    return changeable(design_of_text(text), meets)

"""Stones with parameters changed, whatever they were made from: what can be varied, and the stone it makes.

Of a faceter's design that is the angle of each tier from the girdle plane [deg], and its distance from the
origin [% of half the stone's length], by the names that `gemrender sensitivity` has for them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from gemrender.beam.by_tiers import design_unit, parameters_of_stone
from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.cuts.meets import changeable
from gemrender.cuts.turning import Quantity, parameter_name
from gemrender.cuts.variations import vary
from gemrender.errors import InputError
from gemrender.stone import Stone
from gemrender.sweep.unknown import figures_of

__all__ = ["DEFAULT_MEETS", "Remake", "angles_that_followed", "remaker", "varied_figures"]

#: From parameters by name, the stone.
Remake = Callable[[Mapping[str, float]], Stone]
#: Angles that differ by less are the same [deg]: what meets in files are closed by.
_FOLLOWED = 1e-3
#: What becomes of meets where nothing is said.
DEFAULT_MEETS = "kept"


def varied_figures(stone: Stone) -> dict[str, float]:
    """Return what can be varied of a stone, by name: parameters and angles, or tiers of a design.

    Raises
    ------
    InputError
        It was made neither from proportions, nor of a family, nor from a design.
    """
    if not isinstance(stone.cut, Design):
        return figures_of(stone)
    scale = 100.0 / design_unit(stone, stone.cut)
    figures = {}
    for tier, quantity in parameters_of_stone(stone, stone.cut):
        value = abs(float(getattr(stone.cut.tiers[tier], quantity)))
        figures[parameter_name(stone.cut, tier, quantity)] = value * (
            scale if quantity == "distance" else 1.0
        )
    return figures


def remaker(stone: Stone, meets: str | None = None) -> Remake:
    """Return what makes a stone with some of its figures changed; InputError where that is no stone.

    Parameters
    ----------
    stone : Stone
        The stone.
    meets : {"kept", "loose"}, optional
        Of a design, what becomes of meet points where tiers change: other tiers follow, or each turns about
        the middle of its facets (`gemrender.cuts.meets`); by default they are kept.

    Raises
    ------
    InputError
        Meets of a stone that is no design, or a design whose meets cannot be kept.
    """
    cut = stone.cut
    if isinstance(cut, Design):
        return _of_design(stone, cut, meets or DEFAULT_MEETS)
    if meets is not None:
        raise InputError("only designs of tiers have meets", key="meets", value=meets)
    if isinstance(cut, Family):
        kept = ("name", "material", "size_mm", "crystal")
        facts: dict[str, Any] = {key: getattr(stone, key) for key in kept}

        def of_family(values: Mapping[str, float]) -> Stone:
            made: Stone = cut.changed(**values).stone(**facts)
            return made

        return of_family
    return lambda values: replace(
        vary(stone, [(key, (value,)) for key, value in values.items()])[0], name=stone.name
    )


def _of_design(stone: Stone, design: Design, meets: str) -> Remake:
    ways, unit = changeable(design, meets), design_unit(stone, design)
    by_name: dict[str, tuple[int, Quantity]] = {
        parameter_name(design, *of): of for of in parameters_of_stone(stone, design)
    }
    kinds = {facet.kind for facet in stone.facets}

    def remade(values: Mapping[str, float]) -> Stone:
        changes: dict[tuple[int, Quantity], float] = {}
        for name, value in values.items():
            tier, quantity = by_name[name]
            if quantity == "distance":
                changes[tier, quantity] = 0.01 * unit * value
            else:
                changes[tier, quantity] = value if design.tiers[tier].is_crown else -value
        made = ways.changed(changes).stone(
            name=stone.name,
            material=stone.material,
            size_mm=stone.size_mm,
            crystal=stone.crystal,
            source=stone.source,
        )
        lost = kinds - {facet.kind for facet in made.facets}
        if lost:
            raise InputError(f"cuts {', '.join(sorted(lost))} away", key=", ".join(values))
        return made

    return remade


def angles_that_followed(stone: Stone, made: Stone, asked: Mapping[str, float]) -> tuple[str, ...]:
    """Return a line on each tier of a design whose angle changed though that was not asked for."""
    if not isinstance(stone.cut, Design):
        return ()
    after = varied_figures(made)
    return tuple(
        f"{name} follows: {before:.6g} to {after[name]:.6g}"
        for name, before in varied_figures(stone).items()
        if name.endswith("angle") and name not in asked and abs(after[name] - before) > _FOLLOWED
    )

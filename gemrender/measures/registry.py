"""The measures that there are, by name."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from gemrender.errors import InputError
from gemrender.measures.aset import Aset
from gemrender.measures.dispersion import Dispersion
from gemrender.measures.doubling import Doubling
from gemrender.measures.extinction import Extinction
from gemrender.measures.facets import VirtualFacetSizes
from gemrender.measures.gemray import GemRay
from gemrender.measures.inoue import Inoue
from gemrender.measures.iso import SKIES, Iso
from gemrender.measures.measure import Measure
from gemrender.measures.window import Window
from gemrender.measures.wlr import WlrLike
from gemrender.reading import did_you_mean

__all__ = ["chosen_measures", "measure_named", "measures"]


@cache
def measures() -> tuple[Measure, ...]:
    """Return all measures, in the order in which they are listed."""
    return (
        Inoue(),
        *map(Iso, SKIES),
        *map(GemRay, SKIES),
        Aset(),
        Window(),
        Extinction(),
        WlrLike(),
        Dispersion(),
        VirtualFacetSizes(),
        Doubling(),
    )


def measure_named(name: str, *, key: str = "measure") -> Measure:
    """Return a measure by its name.

    Parameters
    ----------
    name : str
        One of the names of `measures`.
    key : str
        What an error calls it.

    Raises
    ------
    InputError
        Unknown name.
    """
    by_name = {measure.name: measure for measure in measures()}
    if name not in by_name:
        allowed = f"must be one of {', '.join(by_name)}{did_you_mean(str(name), by_name)}"
        raise InputError(allowed, key=key, value=name)
    return by_name[name]


def chosen_measures(chosen: str | Measure | Iterable[str | Measure]) -> tuple[Measure, ...]:
    """Return the measures that were asked for, each once, in the order in which they were.

    Parameters
    ----------
    chosen : str, Measure, or iterable of them
        Names, several with commas between them, `all`, or measures of one's own.

    Raises
    ------
    InputError
        None at all, an unknown name, or two measures of one name.
    """
    out: dict[str, Measure] = {}
    for item in [chosen] if isinstance(chosen, (str, Measure)) else chosen:
        for measure in _of_item(item):
            if out.setdefault(measure.name, measure) is not measure:
                raise InputError("is the name of two measures", key="measures", value=measure.name)
    if not out:
        raise InputError(
            "must be names of measures, with commas between them, or all", key="measures", value=chosen
        )
    return tuple(out.values())


def _of_item(item: str | Measure) -> tuple[Measure, ...]:
    if isinstance(item, Measure):
        if not item.name:
            raise InputError("must have a name", key="measures", value=type(item).__name__)
        return (item,)
    if not isinstance(item, str):
        raise InputError("must be names or measures", key="measures", value=item)
    names = [name.strip() for name in item.split(",")]
    if names == ["all"]:
        return measures()
    return tuple(measure_named(name, key="measures") for name in names if name)

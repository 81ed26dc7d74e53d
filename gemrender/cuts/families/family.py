"""What all families of cuts do: from parameters to points, planes, tiers and the stone."""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from typing import Any, ClassVar, Self

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.meet_points import GEAR
from gemrender.cuts.design import Design, Tier
from gemrender.cuts.families.parameters import Alternative, check_parameters
from gemrender.cuts.marks import Mark, usual_marks
from gemrender.stone import ConvexSolid, Facet, Stone

__all__ = ["Family"]

#: The girdle of a stone with a round outline: its last facet.
_GIRDLE = Facet("girdle", "girdle", "girdle")


class Family:
    """A family of cuts: a frozen dataclass of parameters, made by `parameter`, that can construct its stone.

    Class attributes
    ----------------
    ALTERNATIVES : tuple of Alternative
        What may be stated in place of a parameter, such as an angle for a height.
    IS_ROUND : bool
        Whether the girdle is a cylinder.
    """

    __slots__ = ()
    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = ()
    IS_ROUND: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_parameters(self)

    @classmethod
    def family(cls) -> str:
        """Return the family's name, as stone files have it."""
        return str(sys.modules[cls.__module__].FAMILY)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets for values of all parameters, real or complex; unchecked."""
        raise NotImplementedError

    def values(self, **changes: Any) -> dict[str, Any]:
        """Return the parameters by name, with some of them, or alternatives to them, changed.

        Nothing is checked, and numbers may be complex: analytic, for derivatives by the complex step.
        """
        values = {part.name: getattr(self, part.name) for part in fields(self)}  # type: ignore[arg-type]
        by_name = {other.name: other for other in self.ALTERNATIVES}
        # Alternatives depend on parameters, so these come first.
        values |= {name: value for name, value in changes.items() if name not in by_name}
        for other in self.ALTERNATIVES:
            if other.name in changes:
                values[other.stands_for] = other.to_parameter(changes[other.name], values)
        return values

    def alternatives(self) -> dict[str, Any]:
        """Return what the alternatives to parameters are in this cut, by name."""
        values = self.values()
        return {other.name: other.from_parameter(values) for other in self.ALTERNATIVES}

    def changed(self, **changes: Any) -> Self:
        """Return the cut with some of its parameters, or alternatives to them, changed.

        Raises
        ------
        InputError
            A value out of range.
        """
        return replace(self, **self.values(**changes))  # type: ignore[type-var]

    def construction(self, **changes: Any) -> Construction:
        """Return its meet points and facets, with some parameters changed as by `values`; unchecked."""
        return self.construct(**self.values(**changes))

    def planes(self, **changes: Any) -> np.ndarray:
        """Return the planes of its facets, (f, 4), with some parameters changed as by `values`."""
        return self.construction(**changes).planes

    def tiers(self, **changes: Any) -> tuple[Tier, ...]:
        """Return its facets as a faceter's tiers, with some parameters changed as by `values`."""
        return self.construction(**changes).tiers()

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows, measured from its meet points.

        A family that has more to say than every cut has overrides this, and adds its own to `usual_marks`.
        """
        return usual_marks(self.construction(), is_round=self.IS_ROUND)

    def design(self) -> Design:
        """Return it as a faceter's design; of a cut with a round girdle all facets but the girdle."""
        return Design(tiers=self.tiers(), gear=GEAR)

    def stone(self, **facts: Any) -> Stone:
        """Make the stone; `facts` are fields of `Stone` such as its name.

        Raises
        ------
        InputError
            The parameters make no convex stone that has all its facets.
        """
        made = self.construction()
        made.check()
        return self.stone_of(made, **facts)

    def stone_of(self, made: Construction, **facts: Any) -> Stone:
        """Make the stone of its meet points, as they are; `facts` are fields of `Stone`."""
        planes = made.planes
        return Stone(
            solid=ConvexSolid(planes=planes, facet=np.arange(len(planes)), is_round=self.IS_ROUND),
            facets=(*made.facets, *([_GIRDLE] if self.IS_ROUND else [])),
            **{"cut": self, **facts},
        )

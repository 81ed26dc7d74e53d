"""A faceter's design: tiers of facets by angle, distance and index, and the stone that they cut.

The formula of the planes is GemCad's: a facet at angle i from the girdle plane and azimuth phi, measured from
+y towards +x, has the outward normal (sin i sin phi, sin i cos phi, +-cos i), and lies at its distance from
the origin. It is analytic: complex angles and distances give complex planes, for derivatives by the complex
step.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.stone.facets import Facet, side_of
from gemrender.stone.frame import in_frame
from gemrender.stone.polyhedron import intersect
from gemrender.stone.solid import convex_solid
from gemrender.stone.stone import Stone

__all__ = ["MOST_FACETS", "Design", "Tier", "first_of_twins", "names_text"]

#: Most facets of a design; of 2,270 designs the largest has 637.
MOST_FACETS = 5000
#: Largest angle from the girdle plane [deg].
LARGEST_ANGLE = 90.0
#: Largest difference of two normals, and of two distances relative to the largest, that is the same plane:
#: well below the eight decimals that files have.
SAME_PLANE = 1e-9
#: So many facets are named in a note; of the others their number.
MOST_NAMED = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Tier:
    """Facets that are cut at one angle and one distance, at several positions of the index wheel.

    Parameters
    ----------
    angle_deg : float
        Angle from the girdle plane [deg]: positive on the crown, negative on the pavilion, 90 or -90 on the
        girdle; 0 is a table, -0.0 a culet facet. Complex for derivatives: `complex(angle_deg, step)`, as a
        sum with a complex step loses the sign of -0.0.
    distance : float
        Distance of the facets from the origin, 0 or more [any unit of length]. Complex for derivatives.
    indices : tuple of float
        Position of each facet on the index wheel [teeth]; fractions and negative ones are allowed.
    names : tuple of str
        The name that stands at each index, blank where none does; a name holds for what follows it too.
    instructions : str
        How to cut it, such as "cut to meet point".
    """

    angle_deg: float | complex
    distance: float | complex
    indices: tuple[float, ...]
    names: tuple[str, ...] = ()
    instructions: str = ""

    @property
    def is_crown(self) -> bool:
        """Whether the normals point up, or would if a level facet leaned the least bit."""
        return not np.signbit(np.real(self.angle_deg))

    @property
    def side(self) -> str:
        """The side that the tier is cut on: "crown", "girdle" or "pavilion"."""
        if abs(np.real(self.angle_deg)) == LARGEST_ANGLE:
            return "girdle"
        return "crown" if self.is_crown else "pavilion"

    def facet_names(self) -> tuple[str, ...]:
        """Return the name that holds at each index, blank where the tier has none at all."""
        given = [*self.names, *[""] * (len(self.indices) - len(self.names))]
        name = next((name for name in given if name), "")
        held = []
        for own in given:
            name = own or name
            held.append(name)
        return tuple(held)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """A faceter's design.

    Parameters
    ----------
    tiers : tuple of Tier
        In the order of cutting.
    gear : float
        Teeth of the index wheel; negative where the index runs the other way.
    offset : float
        Index at azimuth 0, which is +y [teeth].
    index : float or None
        Refractive index that it was designed for.
    folds, is_mirrored : int, bool
        The symmetry that was asked for when it was made. Of the facets it says nothing: they are all there.
    headers, footnotes : tuple of str
        What is printed above and below the design; the first header is its title. They hold people's names.
    notes : tuple of str
        What was mended when it was read.
    """

    tiers: tuple[Tier, ...]
    gear: float = 96
    offset: float = 0.0
    index: float | None = None
    folds: int = 1
    is_mirrored: bool = False
    headers: tuple[str, ...] = ()
    footnotes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not 1 <= abs(self.gear) < math.inf:
            raise InputError("must be 1 tooth or more, or negative", key="gear", value=self.gear)
        for number, tier in enumerate(self.tiers, start=1):
            _check_tier(tier, f"tier {number}")
        if self.n_facets > MOST_FACETS:
            raise InputError(f"has {self.n_facets} facets; at most {MOST_FACETS} are allowed")

    @property
    def title(self) -> str:
        """The first header."""
        return next((header for header in self.headers if header.strip()), "")

    @property
    def n_facets(self) -> int:
        """Number of facets, those that others cut away included."""
        return sum(len(tier.indices) for tier in self.tiers)

    @property
    def facet_tiers(self) -> np.ndarray:
        """(n,) int64: number of each facet's tier."""
        return np.repeat(np.arange(len(self.tiers)), [len(tier.indices) for tier in self.tiers])

    def planes(self) -> np.ndarray:
        """Return the plane of each facet, tier by tier.

        Returns
        -------
        (n, 4) float64
            Outward unit normal and distance from the origin: n . p <= distance inside. Complex where an
            angle, a distance or an index is complex; analytic.
        """
        if not self.n_facets:
            return np.empty((0, 4))
        of_tier = self.facet_tiers
        angles = np.array([tier.angle_deg for tier in self.tiers])[of_tier]
        distances = np.array([tier.distance for tier in self.tiers])[of_tier]
        up = np.where([tier.is_crown for tier in self.tiers], 1.0, -1.0)[of_tier]
        indices = np.array([index for tier in self.tiers for index in tier.indices])
        sin_i, cos_i = sin_cos_deg(angles * up)  # up to 90 degrees, so the cosine is 0 or more
        sin_phi, cos_phi = sin_cos_deg((indices - self.offset) * (360.0 / self.gear))
        return np.column_stack([sin_i * sin_phi, sin_i * cos_phi, up * cos_i, distances])

    def kinds(self) -> tuple[str, ...]:
        """Return what each facet is one of: the name that it has in its tier, or one made for the tier.

        Made names are P (pavilion), G (girdle), C (crown) and the tier's number on that side, such as "P1"; T
        is a table and K a culet facet.
        """
        used = {name for tier in self.tiers for name in tier.facet_names()}
        counts: Counter[str] = Counter()
        kinds = []
        for tier in self.tiers:
            made = ""
            for name in tier.facet_names():
                if not name and not made:
                    made = _made_name(tier, counts, used)
                kinds.append(name or made)
        return tuple(kinds)

    def tier_names(self) -> tuple[str, ...]:
        """Return a name for each tier, unique in the design: the kind of its first facet."""
        kinds, of_tier = self.kinds(), self.facet_tiers.tolist()
        names: dict[str, None] = {}
        for number in range(len(self.tiers)):
            name = first = kinds[of_tier.index(number)] if number in of_tier else f"tier {number + 1}"
            more = 1
            while name in names:
                more += 1
                name = f"{first} ({more})"
            names[name] = None
        return tuple(names)

    def facet_names(self) -> tuple[str, ...]:
        """Return a name for each facet, unique in the design: its kind and its index, such as "P1_24"."""
        kinds = self.kinds()
        alone = {kind for kind, count in Counter(kinds).items() if count == 1}
        names: dict[str, None] = {}
        indices = (index for tier in self.tiers for index in tier.indices)
        for kind, index in zip(kinds, indices, strict=True):
            name = first = kind if kind in alone else f"{kind}_{self._index_text(index)}"
            number = 1
            while name in names:
                number += 1
                name = f"{first}_{number}"
            names[name] = None
        return tuple(names)

    def corners(self) -> list[np.ndarray]:
        """Return the corners of each facet, (k, 3) float64, anticlockwise seen from outside.

        A facet that others cut away has none, nor the second of two in one plane.

        Raises
        ------
        InputError
            The facets do not close.
        """
        planes = self.planes().real
        used = np.unique(first_of_twins(planes))
        body = intersect(planes[used])
        corners = [np.empty((0, 3))] * len(planes)
        for place, facet in enumerate(used.tolist()):
            corners[facet] = body.vertices[body.polygon(place)]
        return corners

    def stone(self, *, with_headers: bool = False, **facts: Any) -> Stone:
        """Make the stone of the design, in the frame of stones.

        A plane that stands twice is one facet, and what others cut away is none; the stone's `notes` say so.
        The design's index is the stone's material.

        Parameters
        ----------
        with_headers : bool
            Whether the stone keeps headers and footnotes, in its notes and its cut. They hold people's names
            and addresses.
        **facts
            Fields of `Stone`, such as its name; a material takes the place of the design's index.

        Raises
        ------
        InputError
            There are no facets, or they do not close.
        """
        planes, names, kinds = self.planes().real, self.facet_names(), self.kinds()
        if not len(planes):
            raise InputError("has no facets")
        first, notes = first_of_twins(planes), list(self.notes)
        twins = [
            name for name, number, own in zip(names, first, range(len(first)), strict=True) if number != own
        ]
        if twins:
            notes.append(f"the same plane stands twice, once is used: {names_text(twins)}")
        used = np.unique(first)
        framed, _ = in_frame(planes[used])
        solid, left = convex_solid(framed, np.arange(len(used)))
        gone = [names[used[number]] for number in sorted(set(range(len(used))) - set(left.tolist()))]
        if gone:
            notes.append(f"other facets cut away {names_text(gone)}")
        assumed = list(facts.pop("assumed", ()))
        if facts.get("material") is None:
            facts["material"] = self.index
            if self.index is None:
                assumed.append("diamond (no refractive index in the file)")
        if with_headers:
            notes += [line for line in (*self.headers, *self.footnotes) if line.strip()]
        return Stone(
            solid=solid,
            facets=tuple(
                Facet(names[number], kinds[number], side_of(planes[number, 2])) for number in used[left]
            ),
            cut=self if with_headers else replace(self, headers=(), footnotes=()),
            assumed=tuple(assumed),
            notes=tuple(notes),
            **facts,
        )

    def _index_text(self, index: float | complex) -> str:
        """Return an index as faceters say it: 1 to the number of teeth."""
        teeth = abs(self.gear)
        place = float(np.real(index)) % teeth
        return f"{place if place > SAME_PLANE else teeth:g}"

    def with_tier(self, number: int, **changes: object) -> Design:
        """Return the design with a tier changed, such as `with_tier(0, angle_deg=-41.5)`.

        Parameters
        ----------
        number : int
            The tier, from 0.
        **changes
            New values of the tier's fields.
        """
        tiers = list(self.tiers)
        tiers[number] = replace(tiers[number], **changes)  # type: ignore[arg-type]
        return replace(self, tiers=tuple(tiers))


def sin_cos_deg(angle_deg: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return sines and cosines of angles [deg], exact at multiples of 90; analytic."""
    quarters = np.round(np.real(angle_deg) / 90.0)
    rest = np.radians(1.0) * (angle_deg - 90.0 * quarters)
    sin, cos = np.sin(rest), np.cos(rest)
    quarter = quarters % 4
    where = [quarter == 0, quarter == 1, quarter == 2]
    return np.select(where, [sin, cos, -sin], -cos), np.select(where, [cos, -sin, -cos], sin)


def names_text(names: Sequence[str]) -> str:
    """Return names for a note: the first few, and how many more there are."""
    more = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def first_of_twins(planes: np.ndarray) -> np.ndarray:
    """Return the number of the first plane that is the same as each of these (n, 4), (n,) int64."""
    scaled = planes / [1.0, 1.0, 1.0, planes[:, 3].max() or 1.0]
    first = np.arange(len(planes))
    for number, plane in enumerate(scaled):
        if first[number] == number:
            same = np.abs(scaled[number + 1 :] - plane).max(axis=1, initial=0.0) <= SAME_PLANE
            first[number + 1 :][same & (first[number + 1 :] > number)] = number
    return first


def _check_tier(tier: Tier, key: str) -> None:
    angle, distance = complex(tier.angle_deg), complex(tier.distance)
    if not abs(angle.real) <= LARGEST_ANGLE:  # false for NaN too
        raise InputError("must be -90 to 90 degrees", key=f"{key} angle", value=angle.real)
    if not 0 <= distance.real < math.inf:
        raise InputError("must be a finite number, 0 or more", key=f"{key} distance", value=distance.real)
    if not np.isfinite(np.array(tier.indices, dtype=complex)).all():
        raise InputError("must be finite numbers", key=f"{key} indices")


def _made_name(tier: Tier, counts: Counter[str], used: set[str]) -> str:
    """Return a name for a tier without one, and keep it among those that are used."""
    if complex(tier.angle_deg).real == 0:
        letter = "T" if tier.is_crown else "K"
        if letter not in used:
            used.add(letter)
            return letter
    else:
        letter = {"crown": "C", "girdle": "G", "pavilion": "P"}[tier.side]
    while True:
        counts[letter] += 1
        name = f"{letter}{counts[letter]}"
        if name not in used:
            used.add(name)
            return name

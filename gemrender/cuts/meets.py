"""Meet points of a faceter's design, and designs with other angles that keep them.

A meet is a corner of the solid that more than three facets go through. For facets n . x = d of given angles
that is linear in corners and distances; where an angle changes the distances follow, and where there are more
conditions than distances the angles of other tiers do. Of this list each changes as little as those before it
allow:

1. what is asked for, and the meets; they are kept, or the change is refused;
2. the girdle: its outline, and the mean heights of its two edges, and so its thickness;
3. the angles of other tiers;
4. how wide table and culet facets are;
5. the distances; a tier whose angle is asked for turns about the middle of its facets.

Unknown are tiers, not facets, so that indices and symmetry stay. Steps are Gauss-Newton's: the conditions are
made linear, and solved in turn (`least_change`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from gemrender.cuts.design import LARGEST_ANGLE, Design, first_of_twins
from gemrender.cuts.least_change import solve_in_turn
from gemrender.cuts.turning import (
    Changes,
    Free,
    Loose,
    Quantity,
    check_changes,
    middles_of_tiers,
    parameter_name,
    tier_parameters,
    turned_distances,
    values_of,
    with_tiers,
)
from gemrender.errors import InputError
from gemrender.stone.polyhedron import Polyhedron, intersect
from gemrender.stone.solid import LEAST_AREA

__all__ = ["KEPT", "SAME_CORNER", "WAYS", "Meets", "changeable"]

#: Corners that are joined by an edge shorter than this are one meet [share of the solid's size]; where not
#: all of them can be closed, as they contradict each other by a little, those of edges shorter than the next.
#: Of the edges of real files none but slips are between 0.003 and 0.012; 0.003 is 0.03 mm of 10 mm.
SAME_CORNER = (3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 1e-7, 1e-8)
#: Meets are met to this, and so is what is kept [share of the solid's size].
KEPT = 1e-9
#: Steps end when they are shorter [rad, share of the solid's size].
_SHORT = 1e-12
#: Longest change at once that is solved for, longest step [rad, share of the solid's size], and most steps.
_FAR, _TOO_FAR, _MOST_STEPS = 0.02, 0.3, 40
#: Step of a derivative by the complex step [deg].
_STEP = 1e-30

#: The order in which things are kept where a tier is changed; and where meets of a file are closed, there by
#: distances alone wherever that will do.
_CHANGED = ("girdle", "angles", "level", "distances")
_CLOSED = ("angles", "girdle", "level", "distances")

_SIDES = ("crown", "girdle", "pavilion")

#: What is kept, by name: derivatives by the unknowns (m, u), and values (m,).
_Kept = dict[str, tuple[np.ndarray, np.ndarray]]


class Meets(Free):
    """A design whose meet points are kept whatever of it changes.

    Parameters
    ----------
    design : Design
        The design, of real numbers.

    Attributes
    ----------
    design : Design
        The design with its meets closed: files are rounded, so that facets miss a meet by a little. No more
        is changed than that needs, distances rather than angles.
    corners : list of (k,) int64
        The facets through each meet.

    Raises
    ------
    InputError
        The facets do not close.
    """

    def __init__(self, design: Design) -> None:
        super().__init__(design)
        planes = design.planes().real
        self._first = first_of_twins(planes)
        used = np.unique(self._first)
        body = intersect(planes[used])
        self._size = float(np.ptp(body.vertices, axis=0).max())
        # Twins of a facet lie in its plane and so go through its corners: they follow.
        bounds = used[body.areas > LEAST_AREA * self._size**2]
        self._facets = np.flatnonzero(np.isin(self._first, bounds))
        self._of_tier = design.facet_tiers
        self._sides = np.array([tier.side for tier in design.tiers])
        self._middles = middles_of_tiers(design, body, used)
        self._unknowns = tier_parameters(design, self._facets.tolist())
        for near in SAME_CORNER:
            self.design, self.corners = design, self._found(body, used, near)
            #: How much of a meet other facets may cut away: those that contradict it by as little do.
            self._outside = KEPT if near == SAME_CORNER[0] else SAME_CORNER[0]
            self._base = self._kept(design)
            try:
                angles, distances = _unrounded(design, self._solved({}, _CLOSED))
                self.design = with_tiers(design, angles.tolist(), distances.tolist())
            except InputError:
                if near == SAME_CORNER[-1]:
                    raise
            else:
                break
        self._base = self._kept(self.design)

    # ---- Corners ----

    def _found(self, body: Polyhedron, used: np.ndarray, near: float) -> list[np.ndarray]:
        """Return the facets through each meet, and sort all corners by how many facets go through them."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        ends = body.edges[:, :2]
        lengths = np.linalg.norm(np.diff(body.vertices[ends], axis=1)[:, 0], axis=1)
        joined = ends[lengths < near * self._size]
        links = coo_array((np.ones(len(joined)), joined.T), shape=(len(body.vertices),) * 2)
        label = connected_components(links, directed=False)[1]
        through: dict[int, set[int]] = {}
        for place, number in enumerate(used.tolist()):
            for vertex in body.polygon(place).tolist():
                through.setdefault(int(label[vertex]), set()).add(number)
        by_count: dict[int, list[np.ndarray]] = {}
        for own in through.values():
            facets = self._facets[np.isin(self._first[self._facets], sorted(own))]
            by_count.setdefault(len(facets), []).append(facets)
        #: (c, k) int64 each.
        self._groups = [np.array(by_count[count]) for count in sorted(by_count) if count > 2]
        return [facets for group in self._groups for facets in group if len(facets) > 3]

    # ---- What is kept ----

    def _kept(self, design: Design) -> _Kept:
        """Return what is kept of a design, and its derivatives by the unknowns [rad, solid's size]."""
        count = len(design.tiers)
        angles, distances = values_of(design)
        leaning = with_tiers(design, (angles + 1j * _STEP).tolist(), distances.tolist())
        planes, turn = leaning.planes(), turned_distances(leaning, self._middles) / self._size
        points, moves, sides, level, missed = [], [], [], [], [(np.empty((0, 2 * count)), np.empty(0))]
        for at in self._groups:
            tiers, normals = self._of_tier[at], planes.real[at][..., :3]
            whole, triangle = np.linalg.qr(normals, mode="complete")
            inverse = np.linalg.solve(triangle[:, :3], whole[..., :3].transpose(0, 2, 1))
            offsets = distances[tiers][..., None] / self._size
            point = inverse @ offsets
            # n . x - d by angles and distances while the corner stays, and how the corner moves with them.
            turning = planes.imag[at][..., :3] / np.radians(_STEP)
            by = np.zeros((*at.shape, 2 * count))
            corner, place = np.indices(at.shape)
            by[corner, place, tiers] = (turning @ point)[..., 0]
            by[corner, place, count + tiers] = -1.0
            across = whole[..., 3:].transpose(0, 2, 1)  # what no move of the corner can mend
            missed.append((
                (across @ by).reshape(-1, 2 * count), (across @ (normals @ point - offsets)).reshape(-1),
            ))  # fmt: skip
            points.append(point[..., 0])
            moves.append(-inverse @ by)
            sides.append(
                [(self._sides[tiers] == side).any(axis=1) for side in ("crown", "girdle", "pavilion")]
            )
            level.append((tiers[..., None] == np.flatnonzero(angles == 0.0)).any(axis=1))
        point, move = np.concatenate(points), np.concatenate(moves)
        crown, girdle, pavilion = np.concatenate(sides, axis=1)
        edge = girdle | (crown & pavilion)
        heights = [_mean_height(point[on], move[on]) for on in (edge & pavilion, edge & crown) if on.any()]
        if not girdle.any():  # its outline is the edge between crown and pavilion
            heights.append(_mean_radius(point[edge], move[edge]))
        widths = [_mean_radius(point[on], move[on]) for on in np.concatenate(level).T if on.any()]
        unit, rows = np.eye(2 * count), np.arange(count)
        off = unit[count:].copy()
        off[rows, rows] = -turn.imag / np.radians(_STEP)
        slanted = [tier for tier, quantity in self._unknowns if quantity == "angle_deg"]
        on_stone = [tier for tier, quantity in self._unknowns if quantity == "distance"]
        walls = [tier for tier in on_stone if self._sides[tier] == "girdle"]
        of_tier = distances / self._size
        kept = {
            "meets": _stacked(missed, 2 * count),
            "girdle": _stacked([(unit[[count + t for t in walls]], of_tier[walls]), *heights], 2 * count),
            "angles": (unit[slanted], np.radians(angles[slanted])),
            "level": _stacked(widths, 2 * count),
            "distances": (off[on_stone], (of_tier - turn.real)[on_stone]),
        }
        columns = [tier + (0 if of == "angle_deg" else count) for tier, of in self._unknowns]
        return {key: (by[:, columns], values) for key, (by, values) in kept.items()}

    # ---- Changes ----

    def slopes(self, tier: int, quantity: Quantity) -> tuple[np.ndarray, np.ndarray]:
        """Return how fast angles and distances of all tiers follow a change of one.

        Parameters
        ----------
        tier : int
            Number of the tier, from 0.
        quantity : {"angle_deg", "distance"}
            By its angle, or by its distance.

        Returns
        -------
        ((t,) float64, (t,) float64)
            Derivatives of angles [deg] and of distances [unit of the design] by the angle [deg] or by the
            distance; its own is 1.

        Raises
        ------
        InputError
            It cannot be changed with the meets kept.
        """
        place = self._place(tier, quantity)
        asked = np.eye(len(self._unknowns))[[place]]
        blocks = [(self._base[key][0], np.zeros(len(self._base[key][1]))) for key in ("meets", *_CHANGED)]
        found, left = solve_in_turn([(asked, np.ones(1)), *blocks])
        if left[1] > KEPT or (left[2] > KEPT and self._sides[tier] != "girdle"):
            kept = "its meets" if left[1] > KEPT else "its meets and the girdle"
            raise InputError(
                f"cannot be changed while the design keeps {kept}",
                key=parameter_name(self.design, tier, quantity),
            )
        angles, distances = np.zeros((2, len(self.design.tiers)))
        for (number, of), value in zip(self._unknowns, found.tolist(), strict=True):
            (angles if of == "angle_deg" else distances)[number] = value
        if quantity == "angle_deg":
            return angles, distances * self._size * np.radians(1.0)
        return np.degrees(angles) / self._size, distances

    def changed(self, changes: Changes) -> Design:
        """Return the design with angles and distances of some tiers changed, and all meets kept.

        Parameters
        ----------
        changes : mapping
            From number of a tier, and "angle_deg" or "distance", to the new value [deg], [unit of the
            design].

        Raises
        ------
        InputError
            A value is out of range, or meets or girdle cannot be kept; says which tier.
        """
        check_changes(self.design, changes)
        asked = {
            self._place(tier, quantity): float(value) * self._scale(quantity)
            for (tier, quantity), value in changes.items()
        }
        angles, distances = _unrounded(self.design, self._solved(asked, _CHANGED))
        for (tier, quantity), value in changes.items():
            (angles if quantity == "angle_deg" else distances)[tier] = value
        return with_tiers(self.design, angles.tolist(), distances.tolist())

    def _scale(self, quantity: Quantity) -> float:
        return float(np.radians(1.0)) if quantity == "angle_deg" else 1.0 / self._size

    def _place(self, tier: int, quantity: Quantity) -> int:
        if (tier, quantity) not in self._unknowns:
            raise InputError("has no facet on the stone", key=parameter_name(self.design, tier, quantity))
        return self._unknowns.index((tier, quantity))

    def _values(self, design: Design) -> np.ndarray:
        """Return the unknowns of a design [rad, solid's size]."""
        own = [float(np.real(getattr(design.tiers[tier], of))) for tier, of in self._unknowns]
        return np.array(own) * [self._scale(of) for _, of in self._unknowns]

    def _solved(self, asked: Mapping[int, float], order: Sequence[str]) -> Design:
        """Return the design with what is asked for, by its place among the unknowns."""
        design, kept = self.design, self._base
        rows = np.eye(len(self._unknowns))[list(asked)]
        for _ in range(_MOST_STEPS):
            ahead = np.array([*asked.values()]) - self._values(design)[list(asked)]
            blocks = [(rows, np.clip(ahead, -_FAR, _FAR)), (kept["meets"][0], -kept["meets"][1])]
            blocks += [(kept[key][0], self._base[key][1] - kept[key][1]) for key in order]
            step, _ = solve_in_turn(blocks)
            length = float(np.abs(step).max(initial=0.0))
            if not length < _TOO_FAR:
                break
            moved = self._moved(design, step)
            if moved is None:
                break
            try:
                design, kept = moved, self._kept(moved)
            except np.linalg.LinAlgError:  # facets of a corner that have turned into one direction
                break
            if length < _SHORT:
                self._check(design, kept, asked)
                return design
        raise self._refusal(kept, asked)

    def _moved(self, design: Design, step: np.ndarray) -> Design | None:
        """Return the design a step further; None where a tier would leave its side, or pass the origin."""
        angles, distances = values_of(design)
        for (tier, of), by in zip(self._unknowns, step.tolist(), strict=True):
            (angles if of == "angle_deg" else distances)[tier] += by / self._scale(of)
        upward = angles * [1.0 if tier.is_crown else -1.0 for tier in design.tiers]
        if not all(0.0 < upward[tier] < LARGEST_ANGLE for tier, of in self._unknowns if of == "angle_deg"):
            return None
        return with_tiers(design, angles.tolist(), distances.tolist()) if distances.min() >= 0.0 else None

    # ---- Refusals ----

    def _check(self, design: Design, kept: _Kept, asked: Mapping[int, float]) -> None:
        """Refuse a design that has lost a meet or its girdle."""
        if np.abs(kept["meets"][1]).max(initial=0.0) > KEPT:
            raise self._refusal(kept, asked)
        walls = any(self._sides[self._unknowns[place][0]] == "girdle" for place in asked)
        if asked and not walls and np.abs(kept["girdle"][1] - self._base["girdle"][1]).max() > KEPT:
            raise self._refusal(kept, asked, "the girdle would change")
        planes = design.planes().real / [1.0, 1.0, 1.0, self._size]
        for at in self.corners:
            point = np.linalg.lstsq(planes[at, :3], planes[at, 3], rcond=None)[0]
            outside = np.flatnonzero(planes[:, :3] @ point - planes[:, 3] > self._outside)[:1]
            if len(outside):
                why = f"{self._listed(outside)} would cut away where {self._listed(at)} meet"
                raise self._refusal(kept, asked, why, outside)

    def _refusal(
        self, kept: _Kept, asked: Mapping[int, float], why: str = "", facets: np.ndarray | None = None
    ) -> InputError:
        """Say why meets cannot be kept, or which is missed most; and which change, of these facets if any."""
        if not why:
            why = "no other angles and distances are found that keep all corners"
            if self.corners:
                ends = np.cumsum([0, *(len(at) - 3 for at in self.corners)])
                off = [np.abs(kept["meets"][1][a:b]).max() for a, b in pairwise(ends)]
                facets = self.corners[int(np.argmax(off))]
                why = f"no other angles and distances are found that keep where {self._listed(facets)} meet"
        if not asked:
            return InputError(f"facets miss their meets, and cannot be made to meet: {why}", key="meets")
        own = self._values(self.design)
        tiers = [] if facets is None else self._of_tier[facets].tolist()
        place = max(
            asked, key=lambda place: (self._unknowns[place][0] in tiers, abs(asked[place] - own[place]))
        )
        tier, quantity = self._unknowns[place]
        value = asked[place] / self._scale(quantity)
        return InputError(
            f"meets cannot be kept: {why}",
            key=parameter_name(self.design, tier, quantity),
            value=f"{abs(value):.6g}",
        )

    def _listed(self, facets: np.ndarray) -> str:
        """Name the tiers of facets, each once."""
        names = self.design.tier_names()
        *words, last = dict.fromkeys(names[int(self._of_tier[number])] for number in facets.tolist())
        return f"{', '.join(words)} and {last}" if words else last


def _unrounded(before: Design, after: Design) -> tuple[np.ndarray, np.ndarray]:
    """Return angles [deg] and distances of a design after a solution; what changed by rounding is as before.

    So 34 degrees are not written as 34.000000000000004.
    """
    angles, distances = (
        np.where(np.abs(new - old) <= _SHORT * np.maximum(1.0, np.abs(old)), old, new)
        for old, new in zip(values_of(before), values_of(after), strict=True)
    )
    return angles, distances


#: What becomes of meets where a tier changes: the tier's other number and all other tiers stay ("free"), the
#: tier turns about the middle of its facets ("loose"), or other tiers follow ("kept").
WAYS: dict[str, type[Free]] = {"free": Free, "loose": Loose, "kept": Meets}


def changeable(design: Design, meets: str) -> Free:
    """Return a design that can be changed with its meets free, loose or kept.

    Raises
    ------
    InputError
        There is no such way, or the facets of the design do not close.
    """
    if meets not in WAYS:
        raise InputError(f"must be one of {', '.join(WAYS)}", key="meets", value=meets)
    return WAYS[meets](design)


def _mean_height(points: np.ndarray, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean height of corners (c, 3), and its derivatives, from those of the corners."""
    return moves[:, 2].mean(axis=0)[None], points[:, 2].mean(keepdims=True)


def _mean_radius(points: np.ndarray, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far corners (c, 3) are from their middle, seen from above, and its derivatives."""
    at, move = points[:, :2] - points[:, :2].mean(axis=0), moves[:, :2] - moves[:, :2].mean(axis=0)
    radius = np.linalg.norm(at, axis=1)
    outward = at / np.where(radius > 0, radius, 1.0)[:, None]
    return np.einsum("ij,ijk->k", outward, move)[None] / len(at), radius.mean(keepdims=True)


def _stacked(parts: Sequence[tuple[np.ndarray, np.ndarray]], width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives (m, n) and values (m,) of parts, one below the other."""
    by = np.vstack([np.empty((0, width)), *(by for by, _ in parts)])
    return by, np.concatenate([np.empty(0), *(values for _, values in parts)])

"""Tiers of a faceter's design changed: one number and nothing else, or turned about their facets' middle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from gemrender.cuts.design import LARGEST_ANGLE, Design, first_of_twins
from gemrender.errors import InputError
from gemrender.stone.polyhedron import Polyhedron, intersect

__all__ = [
    "Changes", "Free", "Loose", "Quantity", "check_changes", "has_angle", "middles_of_tiers",
    "parameter_name", "tier_parameters", "turned_distances", "values_of", "with_tiers",
]  # fmt: skip

#: What of a tier can be changed.
Quantity = Literal["angle_deg", "distance"]
#: Step of a derivative by the complex step [deg].
_STEP = 1e-30
#: New angles [deg] and distances, by number of the tier and quantity.
Changes = Mapping[tuple[int, Quantity], float]


def tier_parameters(design: Design, facets: Iterable[int]) -> list[tuple[int, Quantity]]:
    """Return tiers with one of these facets, and "angle_deg" or "distance": what can be changed of each."""
    of_tier = design.facet_tiers
    parameters: list[tuple[int, Quantity]] = []
    for tier in sorted({int(of_tier[facet]) for facet in facets}):
        if has_angle(design, tier):
            parameters.append((tier, "angle_deg"))
        parameters.append((tier, "distance"))
    return parameters


def has_angle(design: Design, tier: int) -> bool:
    """Whether a tier has an angle that can be changed: tables and culets are level, girdles upright."""
    return 0.0 < abs(complex(design.tiers[tier].angle_deg).real) < LARGEST_ANGLE


def parameter_name(design: Design, tier: int, quantity: str) -> str:
    """Return what a tier's angle or distance is called, such as "P1 angle"."""
    return f"{design.tier_names()[tier]} {'angle' if quantity == 'angle_deg' else 'distance'}"


def check_changes(design: Design, changes: Changes) -> None:
    """Refuse angles that are not on the tier's side of the girdle plane, and distances below 0.

    Raises
    ------
    InputError
        Says which tier.
    """
    for (tier, quantity), value in changes.items():
        key = parameter_name(design, tier, quantity)
        if quantity == "distance":
            if not 0.0 <= value < np.inf:
                raise InputError("must be a finite number, 0 or more", key=key, value=value)
        elif not has_angle(design, tier):
            raise InputError("cannot be changed: the tier is level or upright", key=key)
        elif not 0.0 < (value if design.tiers[tier].is_crown else -value) < LARGEST_ANGLE:
            raise InputError("must be between 0 and 90 degrees from the girdle", key=key, value=f"{value:g}")


class Free:
    """A design of which one number changes at a time, and nothing else.

    Parameters
    ----------
    design : Design
        The design, of real numbers.
    """

    def __init__(self, design: Design) -> None:
        self.design = design

    def changed(self, changes: Changes) -> Design:
        """Return the design with angles and distances of some tiers changed.

        Parameters
        ----------
        changes : mapping
            From number of a tier, and "angle_deg" or "distance", to the new value [deg], [unit of the
            design].

        Raises
        ------
        InputError
            A value is out of range; says which tier.
        """
        check_changes(self.design, changes)
        angles, distances = values_of(self.design)
        for (tier, quantity), value in changes.items():
            (angles if quantity == "angle_deg" else distances)[tier] = value
        return with_tiers(self.design, angles.tolist(), distances.tolist())

    def slopes(self, tier: int, quantity: Quantity) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of angles (t,) [deg] and distances (t,) of all tiers by a tier's own."""
        angles, distances = np.zeros((2, len(self.design.tiers)))
        (angles if quantity == "angle_deg" else distances)[tier] = 1.0
        return angles, distances


class Loose(Free):
    """A design whose tiers turn about the middle of their facets, and no other tier moves.

    So a facet's depth changes as little as it can; where it met others it meets them nearly.

    Raises
    ------
    InputError
        The facets of the design do not close.
    """

    def __init__(self, design: Design) -> None:
        super().__init__(design)
        used = np.unique(first_of_twins(design.planes().real))
        self._middles = middles_of_tiers(design, intersect(design.planes().real[used]), used)

    def changed(self, changes: Changes) -> Design:
        """Return the design with angles and distances of some tiers changed.

        A tier whose angle and distance are both given has that distance; otherwise as `Free.changed`.
        """
        made = super().changed(changes)
        angles, distances = values_of(made)
        through = turned_distances(made, self._middles)
        for tier, quantity in changes:
            if quantity == "angle_deg" and (tier, "distance") not in changes:
                distances[tier] = max(float(through[tier].real), 0.0)
        return with_tiers(made, angles.tolist(), distances.tolist())

    def slopes(self, tier: int, quantity: Quantity) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of angles (t,) [deg] and distances (t,) of all tiers by a tier's own."""
        angles, distances = super().slopes(tier, quantity)
        if quantity == "angle_deg":
            own, held = values_of(self.design)
            leaning = with_tiers(self.design, (own + 1j * _STEP * angles).tolist(), held.tolist())
            distances[tier] = turned_distances(leaning, self._middles)[tier].imag / _STEP
        return angles, distances


def values_of(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """Return angles [deg] and distances of a design's tiers, (t,) float64 each."""
    angles = np.array([float(np.real(tier.angle_deg)) for tier in design.tiers])
    return angles, np.array([float(np.real(tier.distance)) for tier in design.tiers])


def middles_of_tiers(design: Design, body: Polyhedron, used: np.ndarray) -> np.ndarray:
    """Return where the middles of each tier's facets are, in the mean of their areas.

    Parameters
    ----------
    design : Design
        The design.
    body : Polyhedron
        Its solid, of the planes of these facets:
    used : (n,) int64
        Their numbers.

    Returns
    -------
    (t, 2) float64
        Distance from the axis along the facet's azimuth, and height [unit of the design]; 0 of a tier without
        facets on the solid.
    """
    areas = np.maximum(body.areas, 0.0)
    middles = np.where(areas[:, None] > 0, np.nan_to_num(body.middles), 0.0)
    normals = body.planes[:, :2]
    level = np.linalg.norm(normals, axis=1)
    outward = np.einsum("ij,ij->i", normals, middles[:, :2]) / np.where(level > 0, level, 1.0)
    of_tier, count = design.facet_tiers[used], len(design.tiers)
    sums = [np.bincount(of_tier, areas * part, count) for part in (outward, middles[:, 2])]
    whole = np.bincount(of_tier, areas, count)
    return np.column_stack(sums) / np.where(whole > 0, whole, 1.0)[:, None]


def turned_distances(design: Design, middles: np.ndarray) -> np.ndarray:
    """Return the distances of tiers that go through these middles (t, 2), (t,); analytic in the angles."""
    up = np.array([1.0 if tier.is_crown else -1.0 for tier in design.tiers])
    angles = np.array([tier.angle_deg for tier in design.tiers]) * up * np.radians(1.0)
    return np.asarray(np.sin(angles) * middles[:, 0] + up * np.cos(angles) * middles[:, 1])


def with_tiers(
    design: Design, angles: Sequence[float | complex], distances: Sequence[float | complex]
) -> Design:
    """Return the design with these angles [deg] and distances of its tiers; level ones keep their angle."""
    changed = zip(design.tiers, angles, distances, strict=True)
    return replace(
        design,
        tiers=tuple(
            replace(tier, angle_deg=angle if has_angle(design, k) else tier.angle_deg, distance=distance)
            for k, (tier, angle, distance) in enumerate(changed)
        ),
    )

"""The virtual facets of a stone: its view as polygons, each with one path and one intensity."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget, no_limits
from gemrender.beam.compiled import jit
from gemrender.beam.crossing import EXACT, GUBELIN
from gemrender.beam.polygons import EXITED, GIRDLE_CELL, TRAPPED, trace_polygons
from gemrender.beam.rules import Rules
from gemrender.beam.solid import NO_WEDGE, BeamStone, beam_stone
from gemrender.observation import LIGHT_LEVEL, REAR_RULES, Model, View
from gemrender.stone import Stone

__all__ = ["FacetStatus", "VirtualFacets", "kernel_rules", "trace_facets"]

#: Beams of a smaller area are trapped [girdle radius^2].
LEAST_AREA = 1e-14
#: Virtual facets of a smaller area do not count among them: slivers that rounding makes [girdle radius^2].
SMALLEST_FACET = 1e-12


class FacetStatus(IntEnum):
    """What became of the light of a virtual facet, followed back."""

    EXITED = EXITED  #: it left the stone: here the light came in
    TRAPPED = TRAPPED  #: still inside after the largest number of reflections, or too narrow
    #: It comes near the curved girdle, where beams part, or the budget was spent: no polygon tells the rest.
    GIRDLE = GIRDLE_CELL


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VirtualFacets:
    """A view of a stone, cut into convex polygons of one path each.

    Attributes
    ----------
    corners : (c, 2) float64
        Corners of all polygons in the view [girdle radius], one polygon after the other, anticlockwise.
    starts, ends : (n,) int64
        Where the corners of each begin and end.
    status : (n,) int64
        `FacetStatus`.
    area : (n,) float64
        Area [girdle radius^2].
    primary_intensity : (n,) float64
        Intensity by the model [%]; 0 for rear light, and where it is not known.
    rear_mask : (n,) bool
        Whether its light is rear light.
    reflections : (n,) int64
        Total reflections, as far as the path is known.
    exit_direction : (n, 3) float64
        Unit direction in which the ray followed back leaves.
    node : (n,) int64
        Its last node in the tree of paths.
    nodes : (k, 2) int64
        Of each node its parent, -1 at the crown, and the facet that the light meets there.
    exit_map : (n, 3, 3) float64
        Where the ray at (x, y) leaves: exit_map[0] + x exit_map[1] + y exit_map[2] [girdle radius]; of girdle
        cells where it was last reflected.
    covered, covered_ends
        Outlines of the facets in the view as far as polygons tell them, for each plane where they end.
    unaccounted : float
        Area that none of them holds: slivers thinner than rounding [girdle radius^2].
    left_over : float
        Area of the girdle cells that were made for want of time or memory [girdle radius^2].
    why_left_over : str
        Which of them, in words; empty where there was enough.
    wedge : (k, 2) float64
        Rows w with w . (x, y) <= 0 in the part of the view that was traced; none for all of it.
    stone, view, model
        What was traced. Of the view only its direction counts.
    """

    corners: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    status: np.ndarray
    area: np.ndarray
    primary_intensity: np.ndarray
    rear_mask: np.ndarray
    reflections: np.ndarray
    exit_direction: np.ndarray
    node: np.ndarray
    nodes: np.ndarray
    exit_map: np.ndarray
    covered: np.ndarray
    covered_ends: np.ndarray
    unaccounted: float
    left_over: float
    why_left_over: str
    wedge: np.ndarray
    stone: Stone
    view: View
    model: Model

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def is_counted(self) -> np.ndarray:
        """(n,) bool: which of them count as virtual facets: not girdle cells, nor slivers of rounding."""
        return np.asarray((self.status != FacetStatus.GIRDLE) & (self.area > SMALLEST_FACET))

    @property
    def parts(self) -> int:
        """So many images of what was traced make the whole view."""
        return 2 * self.stone.symmetry.fold if len(self.wedge) else 1

    def polygon(self, i: int) -> np.ndarray:
        """Return the corners of a virtual facet, (k, 2) [girdle radius]."""
        return self.corners[self.starts[i] : self.ends[i]]

    def path(self, i: int) -> list[int]:
        """Return the facets that its light meets, from the eye; of girdle cells as far as the girdle."""
        out = []
        node = int(self.node[i])
        while node >= 0:
            out.append(int(self.nodes[node, 1]))
            node = int(self.nodes[node, 0])
        return out[::-1]

    def images(self) -> np.ndarray:
        """Return the number of virtual facets of the whole view that each stands for, (n,) int64.

        That is 1, unless a wedge was traced: as many as there are parts; half as many where it is the half of
        one that a mirror plane cuts (its path meets only facets that the mirror image leaves in place), or 1
        around the axis.
        """
        if not len(self.wedge):
            return np.ones(len(self), dtype=np.int64)
        images = self.stone.symmetry.images[: len(self.wedge)]  # of the mirrors beside the wedge
        cut = _all_along(self.nodes, np.ascontiguousarray((images == np.arange(images.shape[1])).T))
        number = cut[self.node].sum(axis=1)
        return np.asarray(np.where(number == 2, 1, self.parts >> number))


@jit
def _all_along(nodes: Any, of_facet: Any) -> Any:
    """Whether something holds of all facets on the path to each node (k, 2), from whether it does of each."""
    out = np.empty((len(nodes), of_facet.shape[1]), np.bool_)
    for node in range(len(nodes)):  # parents come first
        parent, facet = nodes[node]
        for k in range(of_facet.shape[1]):
            out[node, k] = of_facet[facet, k] and (parent < 0 or out[parent, k])
    return out


def kernel_rules(model: Model) -> Rules:
    """Return the model as the kernels take it."""
    return Rules(
        refractive_index=float(model.index),
        law=GUBELIN if model.fresnel == "gubelin" else EXACT,
        radiance=model.intensity == "radiance",
        rear=REAR_RULES.index(model.rear),
        max_reflections=int(model.max_reflections),
    )


def trace_facets(
    stone: Stone | BeamStone,
    *,
    view: View | None = None,
    model: Model | None = None,
    whole: bool = True,
    budget: Budget | None = None,
) -> VirtualFacets:
    """Cut a view of a convex stone into its virtual facets.

    Parameters
    ----------
    stone : Stone or BeamStone
        The stone.
    view : View, optional
        Where the eye is; by default straight above. Its resolution does not matter.
    model : Model, optional
        The optical model; by default that of the stone's material.
    whole : bool
        Whether to trace the whole view, or, of a symmetric stone from straight above, a sixteenth.
    budget : Budget, optional
        Time and memory to keep to: what is not followed to its end within them becomes girdle cells. Without
        one there are no limits, and a few stones of a high index take minutes and gigabytes.

    Raises
    ------
    InputError
        The stone is not convex.
    """
    ready = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    view = view or View(resolution=1)
    model = model or Model.of(ready.stone)
    wedge = NO_WEDGE if whole else ready.wedge(view)
    with budget.polygon_limits() if budget else nullcontext(no_limits()) as limits:
        traced = trace_polygons(ready.solid, view.basis(), wedge, kernel_rules(model), LEAST_AREA, limits)
    corners, ends, what, values, beams, nodes, covered, covered_ends, unaccounted, left_over = traced
    why = ""
    if budget is not None and left_over.any():
        why = budget.memory_is_full if left_over[1] else budget.time_is_up
    nodes[:, 1] = ready.facet[nodes[:, 1]]
    return VirtualFacets(
        corners=corners,
        starts=np.concatenate([[0], ends[:-1]]).astype(np.int64),
        ends=ends,
        status=what[:, 0],
        area=values[:, 0],
        primary_intensity=LIGHT_LEVEL * values[:, 1],
        rear_mask=what[:, 3] == 1,
        reflections=what[:, 2],
        exit_direction=values[:, 2:5],
        node=what[:, 1],
        nodes=nodes,
        exit_map=beams[:, :9].reshape(-1, 3, 3),
        covered=covered,
        covered_ends=covered_ends,
        unaccounted=unaccounted,
        left_over=float(left_over.sum()),
        why_left_over=why,
        wedge=wedge,
        stone=ready.stone,
        view=view,
        model=model,
    )

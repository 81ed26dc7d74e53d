"""The virtual facets of a stone: its view as polygons, each with one path and one intensity."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from gemrender.beam.budget import Budget, no_limits
from gemrender.beam.polygons import EXITED, GIRDLE_CELL, TRAPPED, Traced, trace_polygons
from gemrender.beam.rules import Rules
from gemrender.beam.solid import NO_WEDGE, BeamStone, beam_stone
from gemrender.beam.unfold import in_common, unfolding
from gemrender.cuts import StoneLike, as_stone
from gemrender.measures import inoue
from gemrender.observation import LIGHT_LEVEL, Model, RayStatus, View
from gemrender.paths import Paths
from gemrender.request import ShortForms, resolve, spelt_out
from gemrender.shown import Shown, library, plots
from gemrender.stone import Stone

__all__ = ["FacetStatus", "VirtualFacets", "kernel_rules", "polygon_paths", "trace_facets"]

#: Virtual facets of a smaller area do not count among them: slivers that rounding makes [girdle radius^2].
SMALLEST_FACET = 1e-12


class FacetStatus(IntEnum):
    """What became of the light of a virtual facet, followed back."""

    EXITED = int(EXITED)  #: it left the stone: here the light came in
    TRAPPED = int(TRAPPED)  #: still inside after the largest number of reflections, or too narrow
    #: It comes near the curved girdle, where beams part, or the budget was spent: no polygon tells the rest.
    GIRDLE = int(GIRDLE_CELL)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class VirtualFacets(Shown):
    """A view of a stone, cut into convex polygons of one path each.

    Where all light was followed there are more of them, behind the others: those of light that has been
    reflected in part, of which there may be several at a place.

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
    reflections : (n,) int64
        Total reflections, as far as the path is known.
    exit_direction : (n, 3) float64
        Unit direction in which the ray followed back leaves; of the others the one that it has inside.
    node : (n,) int64
        Its last node in the tree of paths.
    nodes : (k, 2) int64
        Of each node its parent, -1 at the crown, and the facet that the light meets there.
    exit_map : (n, 3, 3) float64
        Where the ray at (x, y) leaves: exit_map[0] + x exit_map[1] + y exit_map[2] [girdle radius]; of girdle
        cells where it was last reflected.
    paths : Paths
        What its light does, in columns; of girdle cells as far as the girdle (they count as missed).
    unfolding : (k, 3, 3) float64 or None
        Where all light was followed, what mirrors a direction at each node back through all reflections.
    covered, covered_ends
        Outlines of the facets in the view as far as polygons tell them, for each plane where they end.
    unaccounted : float
        Area that none of them holds: slivers thinner than rounding [girdle radius^2].
    left_over : float
        Area of the girdle cells that were made for want of time or memory [girdle radius^2].
    why_left_over : str
        Which of them, in words; empty where there was enough.
    wedge : (k, 3) float64
        Rows (a, b, c) with a x + b y + c <= 0 in the part of the view that was traced; none for all of it.
    stone, view, model
        What was traced. Of the view only its direction counts.
    """

    corners: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    status: np.ndarray
    area: np.ndarray
    reflections: np.ndarray
    exit_direction: np.ndarray
    node: np.ndarray
    nodes: np.ndarray
    exit_map: np.ndarray
    paths: Paths
    unfolding: np.ndarray | None
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

    def __repr__(self) -> str:
        return f"<VirtualFacets of {self.stone.name!r}: {len(self)} polygons>"

    @cached_property
    def primary_intensity(self) -> np.ndarray:
        """(n,) intensity of principal light by the model [%]; 0 for rear light, and where it is not known."""
        return LIGHT_LEVEL * inoue.primary_intensity(self.paths, self.model, self.rear_mask)

    @cached_property
    def rear_mask(self) -> np.ndarray:
        """(n,) bool: whether its light is rear light."""
        return inoue.rear_mask(self.paths, self.model)

    @property
    def is_counted(self) -> np.ndarray:
        """(n,) bool: which count as virtual facets: of principal light, no girdle cells, no slivers."""
        is_principal = self.paths.partial_reflections == 0
        return np.asarray(is_principal & (self.status != FacetStatus.GIRDLE) & (self.area > SMALLEST_FACET))

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

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame, one row a virtual facet: what it is, and what its light does.

        Its columns: `kind` (`FacetStatus`, in lower case), `counted` (as `is_counted`), `corners` (their
        number), `middle_x` and `middle_y` (mean of its corners), `primary_intensity` [%], `rear`, then those
        of `Paths`; row i has the polygon `polygon(i)`.

        Raises
        ------
        BackendError
            pandas is not installed.
        """
        number = self.ends - self.starts
        middle = np.add.reduceat(self.corners, self.starts) / number[:, None] if len(self) else self.corners
        kinds = np.array([FacetStatus(status).name.lower() for status in range(len(FacetStatus))])
        return library("pandas").DataFrame(
            {
                "kind": kinds[self.status],
                "counted": self.is_counted,
                "corners": number,
                "middle_x": middle[:, 0],
                "middle_y": middle[:, 1],
                "primary_intensity": self.primary_intensity,
                "rear": self.rear_mask,
                **self.paths.to_dict(),
            }
        )

    def plot(self, ax: Any = None, *, colour: str = "intensity") -> Any:
        """Draw the virtual facets as the polygons that they are; what no polygon tells is hatched.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.
        colour : {"intensity", "reflections", "facet"}
            What the colours tell: the band of intensity, the number of total reflections, or the kind of
            facet through which the light comes in.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            Another word.
        """
        return plots().plot_facets(self, ax, colour)

    def images(self) -> np.ndarray:
        """Return the number of virtual facets of the whole view that each stands for, (n,) int64.

        That is 1, unless a wedge was traced: as many as there are parts; half as many where it is the half of
        one that a mirror plane cuts (its path meets only facets that the mirror image leaves in place), or 1
        around the axis.
        """
        if not len(self.wedge):
            return np.ones(len(self), dtype=np.int64)
        images = self.stone.symmetry.images[: len(self.wedge)]  # of the mirrors beside the wedge
        stays = images == np.arange(images.shape[1])  # of each facet, a bit for each mirror
        bits = (stays << np.arange(len(stays))[:, None]).sum(axis=0)
        in_both = in_common(self.nodes, bits)[self.node]
        number = np.array([0, 1, 1, 2])[in_both]
        return np.asarray(np.where(number == 2, 1, self.parts >> number))


def kernel_rules(model: Model, least: float = 0.0, walls_move: bool = True) -> Rules:
    """Return what the kernels need of the model; all light is followed down to a least share of the view."""
    return Rules(
        refractive_index=float(model.index),
        max_reflections=int(model.max_reflections),
        cut_at_ground=model.rear == "position",
        ground=float(model.ground),
        follows_all=least > 0.0,
        least=float(least),
        walls_move=walls_move,
    )


#: `RayStatus` of each `FacetStatus`; what of the view no polygon tells, others count.
_RAY_STATUS = np.array([RayStatus.EXITED, RayStatus.TRAPPED, RayStatus.MISSED], dtype=np.int64)


def polygon_paths(
    polygons: Traced,
    planes: np.ndarray,
    facet: np.ndarray,
    view: View,
    stone: Stone,
    unfolding: np.ndarray | None = None,
) -> Paths:
    """Return the paths of polygons.

    Parameters
    ----------
    polygons : Traced
        What was traced.
    planes, facet
        The planes that were traced (p, 4), and the facet that each belongs to (p + 1,).
    view, stone : View, Stone
        From where, and what.
    unfolding : (k, 3, 3) float64, optional
        Of their nodes; without it they get no normals.
    """
    status, _, reflections, entry, leaves, partial = polygons.facts.T
    exits = status == EXITED
    ends = polygons.ends
    starts = np.concatenate([[0], ends[:-1]]).astype(np.int64)
    middles = polygons.corners[starts]
    if len(ends):
        middles = np.add.reduceat(polygons.corners, starts) / (ends - starts)[:, None]
    beams, direction = polygons.beams, polygons.beams[:, 9:12]
    cos_exit = (planes[leaves, :3] * direction).sum(axis=1)
    return Paths(
        area=polygons.areas,
        weight=polygons.weights,
        status=_RAY_STATUS[status],
        reflections=reflections,
        partial_reflections=partial,
        entry_facet=facet[entry],
        exit_facet=np.where(exits, facet[leaves], -1),
        cos_entry=(planes[:, :3] @ view.basis()[2])[entry],
        cos_exit=np.where(exits & (cos_exit.real > 0.0), cos_exit, 0.0),
        exit_point=beams[:, :3] + middles[:, :1] * beams[:, 3:6] + middles[:, 1:] * beams[:, 6:9],
        exit_direction=direction,
        entry_normal=None if unfolding is None else planes[entry, :3],
        unfolded_exit_normal=None if unfolding is None else _unfolded_normals(polygons, planes, unfolding),
        stone=stone,
    )


def _unfolded_normals(polygons: Traced, planes: np.ndarray, unfolding: np.ndarray) -> np.ndarray:
    """Return the normals where polygons leave, mirrored back through their reflections, (n, 3)."""
    _, node, _, _, leaves, _ = polygons.facts.T
    return np.asarray((unfolding[polygons.nodes[node, 0]] * planes[leaves, None, :3]).sum(axis=2))


@spelt_out()
def trace_facets(
    stone: StoneLike | BeamStone,
    *,
    view: View | None = None,
    model: Model | None = None,
    whole: bool = True,
    least: float = 0.0,
    budget: Budget | None = None,
    **short: Unpack[ShortForms],
) -> VirtualFacets:
    """Cut a view of a convex stone into its virtual facets.

    Parameters
    ----------
    stone : Stone, str, path or BeamStone
        The stone, or what `load_stone` takes; it must be convex.
    view : View, optional
        Where the eye is; by default straight above. Its resolution does not matter.
    whole : bool
        Whether to trace the whole view, or, of a symmetric stone from straight above, a part.
    least : float
        Follow all light, down to so small a share of the view; what is left of it becomes girdle cells. By
        default only principal light is followed.
    budget : Budget, optional
        Time and memory to keep to: what is not followed to its end within them becomes girdle cells. Without
        one there are no limits, and a few stones of a high index take minutes and gigabytes.
    **short
        As of `ShortForms`.

    Returns
    -------
    VirtualFacets
        Polygons, each with its path; `plot`, `to_pandas`.

    Raises
    ------
    InputError
        The stone is not convex, or a short form is refused.
    """
    convex = stone if isinstance(stone, BeamStone) else beam_stone(as_stone(stone))
    if short:
        view, model = resolve(convex.stone, view, model, short)
    view = view or View(resolution=1)
    model = model or Model.of(convex.stone)
    wedge = NO_WEDGE if whole else convex.wedge(view)
    rules = kernel_rules(model, least)
    with budget.polygon_limits() if budget else nullcontext(no_limits()) as limits:
        traced = trace_polygons(convex.solid, view.basis(), wedge, rules, limits)
    why = ""
    if budget is not None and traced.no_time + traced.no_memory > 0.0:
        why = budget.memory_is_full if traced.no_memory else budget.time_is_up
    nodes = traced.nodes
    unfolded = unfolding(nodes, convex.solid.values) if least else None
    paths = polygon_paths(traced, convex.solid.values, convex.facet, view, convex.stone, unfolded)
    return VirtualFacets(
        corners=traced.corners,
        starts=np.concatenate([[0], traced.ends[:-1]]).astype(np.int64),
        ends=traced.ends,
        status=traced.facts[:, 0],
        area=traced.areas,
        reflections=paths.reflections,
        exit_direction=paths.exit_direction,
        node=traced.facts[:, 1],
        nodes=np.column_stack([nodes[:, 0], convex.facet[nodes[:, 1]]]),
        exit_map=traced.beams[:, :9].reshape(-1, 3, 3),
        paths=paths,
        unfolding=unfolded,
        covered=traced.outlines,
        covered_ends=traced.outline_ends,
        unaccounted=traced.unaccounted,
        left_over=traced.no_time + traced.no_memory,
        why_left_over=why,
        wedge=wedge,
        stone=convex.stone,
        view=view,
        model=model,
    )

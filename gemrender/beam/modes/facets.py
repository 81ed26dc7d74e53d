"""The virtual facets of a birefringent stone: polygons of one path and one history of modes."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget, no_limits
from gemrender.beam.facets import SMALLEST_FACET, FacetStatus, kernel_rules
from gemrender.beam.modes.crystal import Biaxial, Uniaxial
from gemrender.beam.modes.images import image_angles, images_of_nodes
from gemrender.beam.modes.lists import (
    AREA,
    ENTERING,
    LEAVING,
    SECTION,
    SHARE,
    WEIGHT,
    ModePolygons,
    ModeWork,
)
from gemrender.beam.modes.polygons import trace_modes
from gemrender.beam.polygons import EXITED
from gemrender.beam.rules import Rules
from gemrender.beam.solid import NO_WEDGE, BeamStone
from gemrender.measures import inoue
from gemrender.observation import LIGHT_LEVEL, Model, RayStatus, View
from gemrender.paths import Paths
from gemrender.shown import Shown
from gemrender.stone import Stone

__all__ = ["LEAST", "ModeFacets", "mode_rules", "trace_mode_facets"]

#: Polygons are followed down to this share of the view, area times share of the light; single rays from
#: there.
LEAST = 3e-6
#: An optic axis is along the stone's axis within this [sine]: rounding.
_ALONG = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ModeFacets(Shown):
    """A view of a birefringent stone, cut into convex polygons of one path and one history of modes each.

    They cover the view several times: at each place their shares make 1. Those that are left to single rays
    are among them.

    Attributes
    ----------
    corners : (c, 2) float64
        Corners of all polygons in the view [girdle radius], one polygon after the other, anticlockwise.
    starts, ends : (n,) int64
        Where the corners of each begin and end.
    status : (n,) int64
        `FacetStatus`; GIRDLE is what single rays follow on.
    area, share : (n,) float64
        Area [girdle radius^2], and of the light inside at each place of it the share that has this history.
    node : (n,) int64
        Its last node in the tree of paths.
    nodes : (k, 3) int64
        Of each node its parent, -1 at the crown, the facet that the light meets there, and the mode in which
        it goes on: 0 ordinary or fast, 1 extraordinary or slow, -1 where it leaves.
    waves : (k, 5) float64
        Of each node the wave vector from there on [that in air], the beam's cross-section by that in the
        view, and the share of the light at the eye that has entered.
    paths : Paths
        What its light does, in columns, areas times shares.
    covered, covered_ends
        Outlines of the facets in the view, for each plane where they end.
    unaccounted : float
        Area times share that none of them holds: slivers thinner than rounding [girdle radius^2].
    wedge : (k, 3) float64
        Rows (a, b, c) with a x + b y + c <= 0 in the part of the view that was traced; none for all of it.
    polygons : ModePolygons
        The same, as kernels take them.
    images_of_nodes : (k, 2, 3) float64 or None
        Wave vectors of both images behind each node (`images.images_of_nodes`), if they were asked for.
    stone, view, model
        What was traced. Of the view only its direction counts, of the model not its index.
    """

    corners: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    status: np.ndarray
    area: np.ndarray
    share: np.ndarray
    node: np.ndarray
    nodes: np.ndarray
    waves: np.ndarray
    paths: Paths
    covered: np.ndarray
    covered_ends: np.ndarray
    unaccounted: float
    wedge: np.ndarray
    stone: Stone
    view: View
    model: Model
    polygons: ModePolygons
    images_of_nodes: np.ndarray | None

    def __len__(self) -> int:
        return len(self.starts)

    def __repr__(self) -> str:
        return f"<ModeFacets of {self.stone.name!r}: {len(self)} polygons>"

    @property
    def primary_intensity(self) -> np.ndarray:
        """(n,) intensity of each by itself [%]: times its share it adds up at a place; 0 of rear light."""
        return LIGHT_LEVEL * inoue.primary_intensity(self.paths, self.model, self.rear_mask)

    @property
    def rear_mask(self) -> np.ndarray:
        """(n,) bool: whether its light is rear light."""
        return inoue.rear_mask(self.paths, self.model)

    @property
    def exit_direction(self) -> np.ndarray:
        """(n, 3) unit direction in which the ray followed back leaves; of the others that which it has."""
        return self.paths.exit_direction

    @property
    def is_counted(self) -> np.ndarray:
        """(n,) bool: which count as virtual facets: of principal light, whole paths, no slivers."""
        is_principal = self.paths.partial_reflections == 0
        return np.asarray(is_principal & (self.status != FacetStatus.GIRDLE) & (self.area > SMALLEST_FACET))

    @property
    def parts(self) -> int:
        """So many images of what was traced make the whole view."""
        return 2 * self.stone.symmetry.fold if len(self.wedge) else 1

    def images(self) -> np.ndarray:
        """Return the number of polygons of the whole view that each stands for, (n,) int64."""
        return np.full(len(self), self.parts, dtype=np.int64)

    def polygon(self, i: int) -> np.ndarray:
        """Return the corners of a virtual facet, (k, 2) [girdle radius]."""
        return self.corners[self.starts[i] : self.ends[i]]

    def path(self, i: int) -> list[tuple[int, int]]:
        """Return the facets that its light meets, from the eye, and in which mode it goes on from each."""
        out, node = [], int(self.node[i])
        while node >= 0:
            parent, facet, mode = (int(value) for value in self.nodes[node])
            out.append((facet, mode))
            node = parent
        return out[::-1]


def mode_rules(model: Model, least: float, *, follows_all: bool = False) -> Rules:
    """Return what the kernels need of the model."""
    return kernel_rules(model)._replace(follows_all=follows_all, least=least)


def trace_mode_facets(
    convex: BeamStone,
    crystal: Uniaxial | Biaxial,
    *,
    view: View,
    model: Model,
    least: float = LEAST,
    follows_all: bool = False,
    whole: bool = True,
    needs_images: bool = False,
    budget: Budget | None = None,
) -> ModeFacets:
    """Cut the view of a birefringent stone into polygons.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    crystal : Uniaxial or Biaxial
        What it is made of (`optical_crystal`).
    view, model : View, Model
        Where the eye is, and the rules for rear light. The model's index makes no difference.
    least : float
        What has a smaller area times share [share of the view] is left to single rays.
    follows_all : bool
        Whether what is reflected in part goes on.
    whole : bool
        Whether all of the view is wanted; if not, of a stone that is symmetric together with its crystal, the
        part that tells it.
    needs_images : bool
        Whether the angle between the two images of each is asked for (`Paths.image_angle`).
    budget : Budget, optional
        Time and memory to keep to.
    """
    basis = view.basis()
    wedge = NO_WEDGE if whole or not _is_axial(crystal) else convex.wedge(view)
    rules = mode_rules(model, least, follows_all=follows_all)
    with budget.polygon_limits() if budget is not None else nullcontext(no_limits()) as limits:
        work, outlines, outline_ends = trace_modes(convex.solid, crystal, basis, wedge, rules, limits)
    n_corners, n = work.done.used
    facts, numbers, used = work.done.facts[:n], work.done.numbers[:n], int(work.used[0])
    images, angles = None, None
    if needs_images:
        images = images_of_nodes(work, crystal, convex.solid.planes, basis)
        angles = image_angles(work.done, convex.solid.planes, images)
    nodes = work.nodes[:used].copy()
    nodes[:, 1] = convex.facet[nodes[:, 1]]
    corners, ends = work.done.corners[:n_corners], facts[:, 0]
    starts = np.concatenate([[0], ends[:-1]]).astype(np.int64)
    return ModeFacets(
        corners=corners,
        starts=starts,
        ends=ends,
        status=facts[:, 1],
        area=numbers[:, AREA],
        share=numbers[:, SHARE],
        node=facts[:, 2],
        nodes=nodes,
        waves=work.waves[:used],
        paths=replace(_paths(work, corners, starts, convex, basis), image_angle=angles),
        covered=outlines,
        covered_ends=outline_ends,
        unaccounted=float(work.sums[0]),
        wedge=wedge,
        stone=convex.stone,
        view=view,
        model=model,
        polygons=work.done,
        images_of_nodes=images,
    )


def _is_axial(crystal: Uniaxial | Biaxial) -> bool:
    """Whether a crystal looks the same however it is turned about the stone's axis."""
    return isinstance(crystal, Uniaxial) and bool(np.hypot(crystal.axis[0], crystal.axis[1]) <= _ALONG)


#: `RayStatus` of each `FacetStatus`; what single rays follow on, they count.
_RAY_STATUS = np.array([RayStatus.EXITED, RayStatus.TRAPPED, RayStatus.MISSED], dtype=np.int64)


def _paths(
    work: ModeWork, corners: np.ndarray, starts: np.ndarray, convex: BeamStone, basis: np.ndarray
) -> Paths:
    n = int(work.done.used[1])
    facts, numbers, planes, facet = (
        work.done.facts[:n],
        work.done.numbers[:n],
        convex.solid.planes,
        convex.facet,
    )
    ends, status, node, reflections, entry, leaves, partial = facts.T
    middles = np.empty((0, 2))
    if n:
        middles = np.add.reduceat(corners, starts) / (ends - starts)[:, None]
    exits = status == EXITED
    point = numbers[:, :3] + middles[:, :1] * numbers[:, 3:6] + middles[:, 1:] * numbers[:, 6:9]
    direction = numbers[:, 9:12]
    waves: Any = work.waves[node]
    return Paths(
        area=numbers[:, AREA] * numbers[:, SHARE],
        weight=numbers[:, WEIGHT],
        status=_RAY_STATUS[status],
        reflections=reflections,
        partial_reflections=partial,
        entry_facet=facet[entry],
        exit_facet=np.where(exits, facet[leaves], -1),
        cos_entry=planes[entry, :3] @ basis[2],
        cos_exit=np.where(exits, (planes[leaves, :3] * direction).sum(axis=1), 0.0),
        exit_point=point,
        exit_direction=direction,
        entering=waves[:, ENTERING],
        leaving=np.where(exits, numbers[:, LEAVING], 0.0),
        section=waves[:, SECTION],
        stone=convex.stone,
    )

"""Sums over virtual facets, with derivatives where the planes have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gemrender.beam.budget import Budget, no_limits
from gemrender.beam.compiled import STEP
from gemrender.beam.facets import VirtualFacets, kernel_rules, polygon_paths, trace_facets
from gemrender.beam.later import LaterCells
from gemrender.beam.polygons import Traced, trace_polygons
from gemrender.beam.solid import NO_WEDGE, BeamStone
from gemrender.beam.unfold import unfolding
from gemrender.errors import InputError
from gemrender.measures import inoue
from gemrender.measures.evaluate import area_sums, contributions, light_of
from gemrender.measures.tally import Tally
from gemrender.observation import Model, RayStatus, View
from gemrender.optics.fresnel import reflectance
from gemrender.paths import Paths
from gemrender.stone import Stone

__all__ = [
    "Side",
    "channel_sums",
    "facet_sides",
    "facet_totals",
    "least_share",
    "refuse_left_over",
    "side_sums",
    "trace_planes",
]

#: Where all light is followed: polygons down to the smallest of these shares of the view, area times weight,
#: with which there are not more virtual facets than so many (each is some three times as many as the one
#: before). What is left is a ten thousandth of the light with 1e-8.
_LEAST, _MOST_FACETS = (1e-8, 1e-7, 1e-6, 1e-5), 100_000
#: A tenth of the share makes so many times as many polygons.
_MORE_FACETS = 2.2
#: How far aside derivatives are taken where they jump [% or deg]: far beyond rounding; 0 is where they are.
_ASIDE = (0.0, 1e-8, 1e-7)
#: Sums of derivatives of areas agree to rounding but for such a share of them.
_BALANCE = 1e-7


class Side(NamedTuple):
    """What one trace of planes with derivatives tells.

    totals : (4 + k,) complex128
        As of `facet_totals`.
    later : LaterCells or None
        Where all light is followed, what polygons leave of it.
    is_balanced : bool
        Whether virtual facets and view grow alike, and none of no width opens.
    """

    totals: np.ndarray
    later: LaterCells | None
    is_balanced: bool


def facet_totals(
    convex: BeamStone,
    planes: np.ndarray,
    *,
    view: View | None = None,
    model: Model | None = None,
    whole: bool = False,
    tally: Tally | None = None,
    least: float = _LEAST[-1],
) -> np.ndarray:
    """Sum up the virtual facets of planes, with derivatives where those have them.

    Parameters
    ----------
    convex : BeamStone
        The stone; only its facets' numbers, its walls and its symmetry count.
    planes : (p, 4) float64 or complex128
        Outward unit normals and offsets. With `STEP` times derivatives as imaginary parts, the sums have
        theirs.
    view, model
        As for `measure`.
    whole : bool
        Whether to sum up the whole view of a symmetric stone, too: where the planes do not move alike.
    tally : Tally, optional
        Further measures, with values that can be differentiated (`Measure.smooth_keys`).
    least : float
        If they need all light, the share of the view, area times weight, down to which it is followed.

    Returns
    -------
    (4 + k,) array like `planes`
        Area times intensity (0 to 1), area of rear light, area of all virtual facets, and area of the girdle
        cells [stone's unit^2]; of a symmetric stone seen from straight above, of a part of the view. Then the
        sums of all channels of the tally's measures, but for what is left where all light is followed.
    """
    view = view or View(resolution=1)
    tally = tally or Tally(view, model or Model.of(convex.stone))
    return channel_sums(tally, trace_planes(convex, planes, tally, whole, least, walls_move=True)[1])


def trace_planes(
    convex: BeamStone, planes: np.ndarray, tally: Tally, whole: bool, least: float, walls_move: bool
) -> tuple[Traced, Paths, np.ndarray | None]:
    """Trace planes, all light if a measure needs it; return polygons, paths, and their unfolding."""
    view, model = tally.view, tally.model
    wedge = NO_WEDGE if whole else convex.wedge(view)
    values = np.ascontiguousarray(planes.real)
    solid = convex.solid._replace(planes=planes, values=values, columns=np.ascontiguousarray(values.T))
    rules = kernel_rules(model, least if tally.follows_all else 0.0, walls_move)
    traced = trace_polygons(solid, view.basis(), wedge, rules, no_limits())
    needs_normals = tally.needs_normals or tally.follows_all
    unfolded = unfolding(traced.nodes, planes) if needs_normals else None
    return traced, polygon_paths(traced, planes, convex.facet, view, convex.stone, unfolded), unfolded


def channel_sums(tally: Tally, paths: Paths) -> np.ndarray:
    """Return what `facet_totals` does."""
    model, is_principal = tally.model, paths.partial_reflections == 0
    rear, near = inoue.rear_mask(paths, model), paths.status == RayStatus.MISSED
    intensity = inoue.primary_intensity(paths, model, rear)
    areas = paths.area
    chosen = [rear & is_principal, ~near & is_principal, near & is_principal]
    sums = [np.array([areas @ intensity, *(areas[of].sum() for of in chosen)])]
    if tally.measures:
        light = tally.light(paths)
        of_each = ((of, light_of(of, light)) for of in tally.measures)
        sums += [area_sums(lit.paths, contributions(of, lit)) for of, lit in of_each]
    return np.concatenate(sums)


def facet_sides(
    convex: BeamStone,
    planes: np.ndarray,
    tally: Tally,
    *,
    whole: bool = False,
    least: float = _LEAST[-1],
    walls_move: bool = False,
) -> list[Side]:
    """Sum up virtual facets as `facet_totals`, where their derivatives jump on both sides of the jump.

    Parameters
    ----------
    convex, planes, tally, whole, least
        As for `facet_totals`; planes (p, 4) complex128.
    walls_move : bool
        Whether the line at a round girdle's walls moves at which rays take over later light from polygons.
        That changes what both have, but not their sum; `facet_totals` has it so.

    Returns
    -------
    list of Side
        One; or two, a little below and above, where virtual facets of no width open: by that their areas
        and those of the view do not grow alike.
    """
    sides = []
    for by in _ASIDE:
        sides = [
            _side(convex, planes + side * planes.imag / STEP, tally, whole, least, walls_move)
            for side in ((-by, by) if by else (0.0,))
        ]
        if all(side.is_balanced for side in sides):
            break
    return sides


def _side(
    convex: BeamStone, planes: np.ndarray, tally: Tally, whole: bool, least: float, walls_move: bool
) -> Side:
    traced, paths, unfolded = trace_planes(convex, planes, tally, whole, least, walls_move)
    is_balanced = not traced.opens and _is_balanced(traced, paths)
    later = None
    if tally.follows_all and unfolded is not None:
        is_balanced = is_balanced and _is_light_balanced(paths, tally.model.index)
        later = LaterCells(convex, planes, traced, paths, unfolded, tally)
    return Side(channel_sums(tally, paths), later, is_balanced)


def _is_balanced(traced: Traced, paths: Paths) -> bool:
    """Tell whether the areas of virtual facets together have the derivative of the view's."""
    grows, facets = 0.0, paths.area.imag[paths.partial_reflections == 0]
    for start, end in zip(np.append(0, traced.outline_ends[:-1]), traced.outline_ends, strict=True):
        x, y = traced.outlines[start:end].T
        grows += 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).imag.sum())
    return abs(float(facets.sum()) - grows) <= _BALANCE * float(np.abs(facets).sum())


def _is_light_balanced(paths: Paths, index: float) -> bool:
    """Tell whether what goes on inside has the derivative of what is reflected in part at all exits."""
    amounts = paths.area * paths.weight
    exits = paths.status == int(RayStatus.EXITED)
    reflected = (amounts[exits] * reflectance(paths.cos_exit[exits], index)).imag
    later = amounts[paths.partial_reflections > 0].imag
    return abs(float(later.sum() - reflected.sum())) <= _BALANCE * float(np.abs(later).sum())


def side_sums(sides: Sequence[Side], seed: int, rays: int) -> np.ndarray:
    """Return the sums of all light of each side by sets of rays, (1 or 2, SETS or 1, 4 + k) complex128.

    Parameters
    ----------
    sides : sequence of Side
        What `facet_sides` returns.
    seed, rays : int
        Seed of the rays, and how many of each set, where polygons leave some light.
    """
    out = []
    for side in sides:
        totals = side.totals[None]
        if side.later is not None:
            found = side.later.sums(seed, rays)
            totals = np.repeat(totals, len(found), axis=0)
            totals[:, 4:] += found
        out.append(totals)
    return np.array(out)


def least_share(convex: BeamStone, tally: Tally, *, whole: bool, budget: Budget | None = None) -> float:
    """Return down to which share of the view all light is to be followed, by how many polygons that makes.

    Raises
    ------
    InputError
        There are more virtual facets than can be differentiated within the budget.
    """
    coarse = 1e-6
    facets = trace_facets(
        convex, view=tally.view, model=tally.model, whole=whole, budget=budget,
        least=coarse if tally.follows_all else 0.0,
    )  # fmt: skip
    refuse_left_over(facets, convex.stone)
    expected = {least: len(facets) * _MORE_FACETS ** np.log10(coarse / least) for least in _LEAST}
    return next((least for least, n in expected.items() if n <= _MOST_FACETS), _LEAST[-1])


def refuse_left_over(facets: VirtualFacets, stone: Stone) -> None:
    """Refuse a stone whose virtual facets were not all found within a budget."""
    if facets.left_over:
        raise InputError(
            f"falls into more virtual facets than can be differentiated: {facets.why_left_over}",
            source=stone.source or stone.name,
        )

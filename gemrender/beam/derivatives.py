"""What derivatives of scores are, and the sums over virtual facets that they are made of."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from gemrender.beam.budget import no_limits
from gemrender.beam.compiled import STEP
from gemrender.beam.facets import kernel_rules, polygon_paths
from gemrender.beam.polygons import Traced, trace_polygons
from gemrender.beam.solid import NO_WEDGE, BeamStone
from gemrender.beam.unfold import unfolding
from gemrender.measures import inoue
from gemrender.measures.evaluate import area_sums, contributions, light_of
from gemrender.measures.tally import REST, Tally, bounds_of_sets
from gemrender.observation import LIGHT_LEVEL, Model, RayStatus, View
from gemrender.stone import Stone

__all__ = [
    "Derivative",
    "Sensitivity",
    "ValueSlope",
    "derivative",
    "facet_sides",
    "facet_totals",
    "result",
    "score_slopes",
    "smooth_values",
]


#: How far aside derivatives are taken where they jump [% or deg]: far beyond rounding; 0 is where they are.
_ASIDE = (0.0, 1e-8, 1e-7)
#: Sums of derivatives of areas agree to rounding but for such a share of them.
_BALANCE = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class ValueSlope:
    """How fast a measure's value changes with one parameter.

    Attributes
    ----------
    measure, key : str
        Name of the measure and of its value.
    unit : str
        The value's unit, such as "%".
    slope, bound : float
        Its derivative, NaN where the value is not defined, and how far that may be off, with a confidence of
        99.9 % [the value's unit per unit of the parameter].
    """

    measure: str
    key: str
    unit: str
    slope: float
    bound: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Derivative:
    """How fast the scores change with one parameter.

    Attributes
    ----------
    parameter : str
        Its name, as stone files have it; of a design the tier's name and "angle" or "distance".
    kept : str
        What stays as it is: the other "proportions", the other "angles" of a laboratory report, or the other
        "tiers" of a design.
    unit : str
        "%" or "deg"; distances of tiers are in per cent of half the stone's length.
    average, rear : float
        d(Average) and d(Rear) [% per unit].
    average_bound, rear_bound : float
        How far they may be off, with a confidence of 99.9 % [% per unit]. Where the derivatives on the two
        sides differ, their mean is told, and half of the difference counts here.
    measures : tuple of ValueSlope
        The values of further measures.
    """

    parameter: str
    kept: str
    unit: str
    average: float
    rear: float
    average_bound: float
    rear_bound: float
    measures: tuple[ValueSlope, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the derivatives for JSON; those of further measures by name, if there are any."""
        out = asdict(self)
        del out["measures"]
        measures: dict[str, dict[str, Any]] = {}
        for of in self.measures:
            is_known = not np.isnan(of.slope)
            told = {"slope": of.slope if is_known else None, "bound": of.bound if is_known else None}
            measures.setdefault(of.measure, {})[of.key] = told
        return out | ({"measures": measures} if measures else {})


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensitivity:
    """The derivatives of one stone's scores.

    Attributes
    ----------
    name : str
        The stone's name.
    average, rear : float
        The scores themselves [%].
    derivatives : tuple of Derivative
        By the paper's proportions, then by what a laboratory report prints.
    girdle : float
        Share of the view that no virtual facet tells [%].
    fresnel, rear_rule, intensity : str
        The model's options.
    index : float
        Refractive index.
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye and its azimuth [deg].
    seconds : float
        Time that it took [s].
    """

    name: str
    average: float
    rear: float
    derivatives: tuple[Derivative, ...]
    girdle: float
    fresnel: str
    rear_rule: str
    intensity: str
    index: float
    tilt_deg: float
    tilt_azimuth_deg: float
    seconds: float

    def to_dict(self) -> dict[str, object]:
        """Return the derivatives for JSON."""
        out = {each.name: getattr(self, each.name) for each in fields(self)}
        return out | {"derivatives": [of.to_dict() for of in self.derivatives]}


def facet_totals(
    convex: BeamStone,
    planes: np.ndarray,
    *,
    view: View | None = None,
    model: Model | None = None,
    whole: bool = False,
    tally: Tally | None = None,
) -> np.ndarray:
    """Sum up the virtual facets of a stone with these planes in place of its own.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    planes : (p, 4) float64 or complex128
        Planes; with `compiled.STEP` times their derivatives as imaginary parts, the sums have theirs.
    view, model
        As for `measure`.
    whole : bool
        Whether to sum up the whole view of a symmetric stone, too: where the planes do not move alike.
    tally : Tally, optional
        Further measures, with values that can be differentiated (`Measure.smooth_keys`).

    Returns
    -------
    (4 + k,) array like `planes`
        Area times intensity (0 to 1), area of rear light, area of all virtual facets, and area of the girdle
        cells [stone's unit^2]; of a symmetric stone seen from straight above, of a part of the view. Then the
        sums of all channels of the tally's measures.
    """
    view = view or View(resolution=1)
    tally = tally or Tally(view, model or Model.of(convex.stone))
    return _totals(convex, planes, tally, whole)[0]


def _totals(convex: BeamStone, planes: np.ndarray, tally: Tally, whole: bool) -> tuple[np.ndarray, bool]:
    """Return what `facet_totals` does, and whether virtual facets and view grow alike."""
    view, model, measures = tally.view, tally.model, tally.measures
    wedge = NO_WEDGE if whole else convex.wedge(view)
    values = np.ascontiguousarray(planes.real)
    solid = convex.solid._replace(planes=planes, values=values, columns=np.ascontiguousarray(values.T))
    traced = trace_polygons(solid, view.basis(), wedge, kernel_rules(model), no_limits())
    unfolded = unfolding(traced.nodes, planes) if any(of.needs_normals for of in measures) else None
    paths = polygon_paths(traced, planes, convex.facet, view, convex.stone, unfolded)
    rear, near = inoue.rear_mask(paths, model), paths.status == RayStatus.MISSED
    intensity = inoue.primary_intensity(paths, model, rear)
    areas = paths.area
    sums = [np.array([areas @ intensity, areas[rear].sum(), areas[~near].sum(), areas[near].sum()])]
    if measures:
        light = tally.light(paths)
        of_each = ((of, light_of(of, light)) for of in measures)
        sums += [area_sums(lit.paths, contributions(of, lit)) for of, lit in of_each]
    return np.concatenate(sums), _is_balanced(traced)


def _is_balanced(traced: Traced) -> bool:
    """Tell whether the areas of virtual facets together have the derivative of the view's."""
    grows, facets = 0.0, traced.areas.imag
    for start, end in zip(np.append(0, traced.outline_ends[:-1]), traced.outline_ends, strict=True):
        x, y = traced.outlines[start:end].T
        grows += 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).imag.sum())
    return abs(float(facets.sum()) - grows) <= _BALANCE * float(np.abs(facets).sum())


def facet_sides(convex: BeamStone, planes: np.ndarray, tally: Tally, *, whole: bool = False) -> np.ndarray:
    """Sum up virtual facets as `facet_totals`, where their derivatives jump on both sides of the jump.

    Parameters
    ----------
    convex, planes, tally, whole
        As for `facet_totals`; planes (p, 4) complex128.

    Returns
    -------
    (1 or 2, 4 + k) complex128
        One row; or two, a little below and above, where virtual facets of no width open: by that their areas
        and those of the view do not grow alike.
    """
    for by in _ASIDE:
        sides = [
            _totals(convex, planes + side * planes.imag / STEP, tally, whole)
            for side in ((-by, by) if by else (0.0,))
        ]
        if all(is_balanced for _, is_balanced in sides):
            break
    return np.array([totals for totals, _ in sides])


def smooth_values(tally: Tally, area: np.ndarray, channels: np.ndarray) -> np.ndarray:
    """Return the values that can be differentiated, measure by measure, (..., n).

    Parameters
    ----------
    tally : Tally
        The measures.
    area : (...,) float64 or complex128
        Area of the view [stone's unit^2].
    channels : (..., k) float64 or complex128
        Sums of all channels of the measures [stone's unit^2].
    """
    sums = np.zeros((*channels.shape[:-1], tally.n_sums), channels.dtype)
    sums[..., inoue.MET], sums[..., REST + 1 :] = area, channels
    out = [
        values[..., [of.keys.index(key) for key in of.smooth_keys]]
        for of, values in zip(tally.measures, tally.values(sums), strict=True)
    ]
    return np.concatenate(out, axis=-1) if out else np.zeros((*channels.shape[:-1], 0), channels.dtype)


def score_slopes(tally: Tally, totals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Average, Rear and values of measures, (2 + n,), and their derivatives, (1 or 2, 1, 2 + n).

    Parameters
    ----------
    tally : Tally
        The measures.
    totals : (1 or 2, 4 + k) complex128
        What `facet_sides` returns, of a stone that is nothing but polygons.
    """
    scores = LIGHT_LEVEL * (totals[:, :2] / totals[:, 2:3])
    both = np.hstack([scores, smooth_values(tally, totals[:, 2], totals[:, 4:])])
    return both[0].real, both.imag[:, None] / STEP


def derivative(parameter: str, kept: str, unit: str, tally: Tally, slopes: np.ndarray) -> Derivative:
    """Put together the derivatives by a parameter.

    Parameters
    ----------
    parameter, kept, unit
        As in `Derivative`.
    tally : Tally
        The measures.
    slopes : (1 or 2, SETS or 1, 2 + n) float64
        Derivatives of Average, Rear and the values of measures, where they differ on both sides, by each set
        of rays; one of what is exact.
    """
    sets, sides = slopes.mean(axis=0), slopes.mean(axis=1)
    means = sets.mean(axis=0).tolist()
    scatter = bounds_of_sets(sets) if len(sets) > 1 else 0.0
    bounds = (scatter + 0.5 * np.abs(sides[-1] - sides[0])).tolist()
    names = [(of.name, key, of.unit) for of in tally.measures for key in of.smooth_keys]
    return Derivative(
        parameter=parameter, kept=kept, unit=unit,
        average=means[0], rear=means[1], average_bound=bounds[0], rear_bound=bounds[1],
        measures=tuple(
            ValueSlope(measure=measure, key=key, unit=of, slope=slope, bound=bound)
            for (measure, key, of), slope, bound in zip(names, means[2:], bounds[2:], strict=True)
        ),
    )  # fmt: skip


def result(
    stone: Stone,
    tally: Tally,
    scores: np.ndarray,
    derivatives: list[Derivative],
    girdle: float,
    start: float,
) -> Sensitivity:
    """Put the derivatives of a stone together.

    The scores (2 + n,) are Average, Rear, and values of measures; `start` is when the work began
    (`time.perf_counter`) [s].
    """
    view, model = tally.view, tally.model
    return Sensitivity(
        name=stone.name,
        average=float(scores[0]),
        rear=float(scores[1]),
        derivatives=tuple(derivatives),
        girdle=float(girdle),
        fresnel=model.fresnel,
        rear_rule=model.rear,
        intensity=model.intensity,
        index=model.index,
        tilt_deg=float(view.tilt_deg),
        tilt_azimuth_deg=float(view.tilt_azimuth_deg),
        seconds=time.perf_counter() - start,
    )

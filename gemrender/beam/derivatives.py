"""What derivatives of scores are, and the sums over virtual facets that they are made of."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass

import numpy as np

from gemrender.beam.budget import no_limits
from gemrender.beam.facets import kernel_rules, polygon_paths
from gemrender.beam.polygons import trace_polygons
from gemrender.beam.solid import NO_WEDGE, BeamStone
from gemrender.measures import inoue
from gemrender.observation import Model, RayStatus, View
from gemrender.stone import Stone

__all__ = ["Derivative", "Sensitivity", "facet_totals", "result"]


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
        How far they may be off, with a confidence of 99.9 % [% per unit].
    """

    parameter: str
    kept: str
    unit: str
    average: float
    rear: float
    average_bound: float
    rear_bound: float


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
        return asdict(self)


def facet_totals(
    convex: BeamStone,
    planes: np.ndarray,
    *,
    view: View | None = None,
    model: Model | None = None,
    whole: bool = False,
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

    Returns
    -------
    (4,) array like `planes`
        Area times intensity (0 to 1), area of rear light, area of all virtual facets, and area of the girdle
        cells [stone's unit^2]; of a symmetric stone seen from straight above, of a part of the view.
    """
    view = view or View(resolution=1)
    wedge = NO_WEDGE if whole else convex.wedge(view)
    values = np.ascontiguousarray(planes.real)
    solid = convex.solid._replace(planes=planes, values=values, columns=np.ascontiguousarray(values.T))
    model = model or Model.of(convex.stone)
    traced = trace_polygons(solid, view.basis(), wedge, kernel_rules(model), no_limits())
    paths = polygon_paths(traced, planes, convex.facet, view, convex.stone)
    rear, near = inoue.rear_mask(paths, model), paths.status == RayStatus.MISSED
    intensity = inoue.primary_intensity(paths, model, rear)
    areas = paths.area
    return np.array([areas @ intensity, areas[rear].sum(), areas[~near].sum(), areas[near].sum()])


def result(
    stone: Stone,
    view: View,
    model: Model,
    scores: tuple[float, float],
    derivatives: list[Derivative],
    girdle: float,
    start: float,
) -> Sensitivity:
    """Put the derivatives of a stone together; `start` is when the work began (`time.perf_counter`) [s]."""
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

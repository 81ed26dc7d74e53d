"""Derivatives of a stone's scores by its proportions, moving edges included.

Areas and intensities of the virtual facets are smooth functions of the planes, and so are their edges: the
derivative of a sum over them is exact, by the complex step (`compiled`). No sampled image gives that: a pixel
does not move. Near the girdle there are no virtual facets. What is exact there too is how its share of the
view grows. How the mean of its light changes is a difference quotient of rays, with its error; it is small,
and from one hundredth of a per cent to the next too rough for a derivative to mean anything.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from gemrender.beam.budget import Budget, no_limits
from gemrender.beam.compiled import STEP
from gemrender.beam.facets import kernel_rules, polygon_paths, trace_facets
from gemrender.beam.measure import check_bound, facet_sums
from gemrender.beam.near_girdle import SETS, STUDENT_T, NearGirdle
from gemrender.beam.polygons import trace_polygons
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.cuts import RoundBrilliant
from gemrender.cuts.round_brilliant.planes import facet_planes
from gemrender.cuts.round_brilliant.proportions import brilliant_vertices
from gemrender.errors import InputError
from gemrender.measures import inoue
from gemrender.measures.inoue import INTENSITY, MET, REAR
from gemrender.observation import LIGHT_LEVEL, Model, RayStatus, View
from gemrender.stone import Stone

__all__ = [
    "PROPORTIONS",
    "Derivative",
    "Sensitivity",
    "check_differentiable",
    "facet_totals",
    "proportion_planes",
    "sensitivity",
]

#: The proportions that a stone is differentiated by, as `RoundBrilliant` names them.
PROPORTIONS = (
    "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness"
)  # fmt: skip

#: What derivatives may take by default: time [s] and memory [GiB].
TIME_LIMIT, MEMORY_LIMIT = 30.0, 1.0
#: In one round of rays polygons are traced so many times; a budget lets them run for 0.4 of its time.
_TRACES = 12

#: Steps of the difference quotient near the girdle [%]; a smaller one is taken where the girdle cells are not
#: the same ones on both sides, told by their area, which may differ by this share from what it should be.
_QUOTIENT_STEPS, _SAME_CELLS = (0.05, 0.02, 0.01, 0.005), 0.02
#: Rays of each set and side at first and at the most, and by how much they are increased.
_RAYS, _MOST_RAYS, _MORE = 512, 8192, 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Derivative:
    """How fast the scores change with one parameter.

    Attributes
    ----------
    parameter : str
        Its name, as stone files have it.
    kept : str
        What stays as it is: the other "proportions", or the other "angles" of a laboratory report.
    unit : str
        "%" or "deg".
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


def proportion_planes(proportions: RoundBrilliant, parameter: str) -> np.ndarray:
    """Return a brilliant's planes, (57, 4) complex128, with their derivatives by a proportion [1/%]."""
    numbers: dict[str, complex] = asdict(proportions)
    numbers[parameter] = complex(numbers[parameter], STEP)
    return facet_planes(brilliant_vertices(**numbers))


def facet_totals(
    ready: BeamStone, planes: np.ndarray, *, view: View | None = None, model: Model | None = None
) -> np.ndarray:
    """Sum up the virtual facets of a stone with these planes in place of its own.

    Parameters
    ----------
    ready : BeamStone
        The stone.
    planes : (p, 4) float64 or complex128
        Planes; with `compiled.STEP` times their derivatives as imaginary parts, the sums have theirs.
    view, model
        As for `measure`.

    Returns
    -------
    (4,) array like `planes`
        Area times intensity (0 to 1), area of rear light, area of all virtual facets, and area of the girdle
        cells [girdle radius^2]; of a symmetric stone seen from straight above, of a sixteenth of the view.
    """
    view = view or View(resolution=1)
    wedge = ready.wedge(view)
    solid = ready.solid._replace(planes=planes, values=np.ascontiguousarray(planes.real))
    model = model or Model.of(ready.stone)
    traced = trace_polygons(solid, view.basis(), wedge, kernel_rules(model), no_limits())
    paths = polygon_paths(traced.polygons, planes, ready.facet, view, ready.stone)
    rear, near = inoue.rear_mask(paths, model), paths.status == RayStatus.MISSED
    intensity = inoue.primary_intensity(paths, model, rear)
    areas = paths.area
    return np.array([areas @ intensity, areas[rear].sum(), areas[~near].sum(), areas[near].sum()])


def check_differentiable(stone: Stone) -> None:
    """Refuse a stone that was not made from proportions.

    Raises
    ------
    InputError
        It has none to differentiate by.
    """
    if stone.proportions is None:
        raise InputError(
            "has no proportions to differentiate by: it must be made from [proportions], [angles] "
            "or [report]",
            source=stone.source or stone.name,
        )


def sensitivity(
    stone: Stone,
    *,
    view: View | None = None,
    model: Model | None = None,
    seed: int = 1,
    bound: float = 0.2,
    time_limit: float = TIME_LIMIT,
    memory_limit: float = MEMORY_LIMIT,
    progress: Callable[[float], None] | None = None,
) -> Sensitivity:
    """Differentiate a stone's Average and Rear by each of its proportions and angles.

    Where a whole virtual facet reaches the critical angle the scores jump; between such places the derivative
    is that of the scores.

    Parameters
    ----------
    stone : Stone
        A stone made from proportions or angles.
    view, model
        As for `measure`.
    seed : int
        Seed of the rays near the girdle.
    bound : float
        Wanted bound of every derivative [% per unit]. Rays near the girdle are added until it is reached, but
        no more than 8192 of each of the sixteen sets, and none that time is not left for.
    time_limit, memory_limit : float
        What it may take [s], [GiB].
    progress : callable, optional
        Called with the share done, 0 to 1.

    Raises
    ------
    InputError
        The stone was not made from proportions, the bound or a limit is out of range, or the stone falls into
        more virtual facets than can be differentiated within the limits.
    """
    start = time.perf_counter()
    check_differentiable(stone)
    assert stone.proportions is not None
    wanted = check_bound(bound)
    view, model = view or View(resolution=1), model or Model.of(stone)
    whole = Budget(time_limit, memory_limit)
    rays = _RAYS
    while True:
        before = whole.seconds
        base = _Scored(stone, view, model, seed, rays, budget=Budget(time_limit / _TRACES, memory_limit))
        slopes = {}
        for done, parameter in enumerate(PROPORTIONS, start=1):
            slopes[parameter] = _slope(base, parameter, seed)
            if progress is not None:
                progress(done / len(PROPORTIONS))
        derivatives = _derivatives(stone.proportions, slopes)
        reached = max(max(d.average_bound, d.rear_bound) for d in derivatives)
        if reached <= wanted or rays >= _MOST_RAYS or _MORE * (whole.seconds - before) > whole.left:
            break
        rays *= _MORE
    average, rear = base.scores().mean(axis=0)
    return Sensitivity(
        name=stone.name,
        average=float(average),
        rear=float(rear),
        derivatives=tuple(derivatives),
        girdle=float(100.0 * (1.0 - base.resolved[MET] / base.area)),
        fresnel=model.fresnel,
        rear_rule=model.rear,
        intensity=model.intensity,
        index=model.index,
        tilt_deg=float(view.tilt_deg),
        tilt_azimuth_deg=float(view.tilt_azimuth_deg),
        seconds=time.perf_counter() - start,
    )


class _Scored:
    """A stone with its virtual facets and its light near the girdle."""

    def __init__(
        self,
        stone: Stone,
        view: View,
        model: Model,
        seed: int,
        rays: int,
        numbers: tuple[int, int] | None = None,
        budget: Budget | None = None,
    ) -> None:
        self.stone, self.view, self.model = stone, view, model
        self.ready = beam_stone(stone)
        facets = trace_facets(self.ready, view=view, model=model, whole=False, budget=budget)
        if facets.left_over:
            raise InputError(
                f"falls into more virtual facets than can be differentiated: {facets.why_left_over}",
                source=stone.source or stone.name,
            )
        self.resolved, near = facet_sums(facets), NearGirdle(self.ready, facets, seed)
        self.numbers = numbers or near.numbers(rays)
        near.go_on(self.numbers)
        self.near, self.cell_area, self.area = near.found(), near.cell_area, near.view_area

    def scores(self) -> np.ndarray:
        """Average and Rear by each set of rays, (SETS, 2) [%]."""
        return np.asarray(100.0 * (self.resolved + self.near)[:, [INTENSITY, REAR]] / self.area)

    def near_means(self) -> np.ndarray:
        """Mean intensity and share of rear light near the girdle, by each set of rays, (SETS, 2) (0 to 1)."""
        met = self.near[:, MET:]
        return np.asarray(self.near[:, [INTENSITY, REAR]] / np.where(met > 0, met, 1.0))

    def moved(self, parameter: str, by: float, seed: int) -> _Scored:
        """Return the stone with one proportion changed [%], scored by the very same rays."""
        assert self.stone.proportions is not None
        numbers = asdict(self.stone.proportions)
        numbers[parameter] += by
        stone = Stone.from_proportions(RoundBrilliant(**numbers), material=self.stone.material)
        return _Scored(stone, self.view, self.model, seed, 0, self.numbers)


def _slope(base: _Scored, parameter: str, seed: int) -> np.ndarray:
    """Differentiate Average and Rear by one proportion, by each set of rays, (SETS, 2)."""
    assert base.stone.proportions is not None
    planes = proportion_planes(base.stone.proportions, parameter)
    light, rear, resolved, cells = (
        facet_totals(base.ready, planes, view=base.view, model=base.model).imag / STEP
    )
    for step in _QUOTIENT_STEPS:
        low, high, between = _sides(base, parameter, step, seed)
        grown = high.cell_area - low.cell_area - between * cells
        if abs(grown) <= _SAME_CELLS * base.cell_area:
            break
    grows = (high.area - low.area) / between
    near, near_grows = base.area - base.resolved[MET], grows - resolved
    change = (high.near_means() - low.near_means()) / between
    near_slope = base.near_means() * near_grows + near * change
    slope = np.array([light, rear]) + near_slope - base.scores() / LIGHT_LEVEL * grows
    return np.asarray(LIGHT_LEVEL * slope / base.area)


def _sides(base: _Scored, parameter: str, step: float, seed: int) -> tuple[_Scored, _Scored, float]:
    """Return the stone with a proportion a step smaller and a step larger, and how far apart [%].

    At the end of the allowed range the stone itself is one of the two.
    """
    sides, between = [], 0.0
    for by in (-step, step):
        try:
            sides.append(base.moved(parameter, by, seed))
        except InputError:
            sides.append(base)
        else:
            between += step
    if not between:
        raise InputError("leaves no room for a difference on either side", key=parameter)
    return sides[0], sides[1], between


def _derivatives(proportions: RoundBrilliant, slopes: dict[str, np.ndarray]) -> list[Derivative]:
    """Put the derivatives together; those by angles follow from those by heights (the chain rule).

    crown height = (100 - table) / 2 tan(crown angle), pavilion depth = 50 tan(pavilion angle).
    """
    crown, pavilion = (math.radians(a) for a in (proportions.crown_angle_deg, proportions.pavilion_angle_deg))
    by_crown, by_pavilion = slopes["crown_height"], slopes["pavilion_depth"]
    degree = math.radians(1.0)
    angles = {
        "table": ("%", slopes["table"] - 0.5 * math.tan(crown) * by_crown),
        "crown_angle": ("deg", degree * (100.0 - proportions.table) / 2 / math.cos(crown) ** 2 * by_crown),
        "pavilion_angle": ("deg", degree * 50.0 / math.cos(pavilion) ** 2 * by_pavilion),
        "lower_half": ("%", -slopes["lower_girdle_contact"]),
    }
    rows = [(name, "proportions", "%", slope) for name, slope in slopes.items()]
    rows += [(name, "angles", unit, slope) for name, (unit, slope) in angles.items()]
    out = []
    for name, kept, unit, slope in rows:
        (average, rear), spread = slope.mean(axis=0), slope.std(axis=0, ddof=1) / math.sqrt(SETS)
        bounds = [float(STUDENT_T * s) for s in spread]
        out.append(
            Derivative(
                parameter=name, kept=kept, unit=unit, average=float(average), rear=float(rear),
                average_bound=bounds[0], rear_bound=bounds[1],
            )
        )  # fmt: skip
    return out

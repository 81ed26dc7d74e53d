"""Light for tests of measures: points spread evenly over a view, paths through them, and paths by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.measures import Light, evaluate, measures
from gemrender.observation import Model, RayStatus, View
from gemrender.paths import Paths
from gemrender.reference import paths
from gemrender.stone import Stone

#: Measures of one view.
OF_A_VIEW = tuple(measure for measure in measures() if measure.views == "one")

#: Roberts' R2 sequence: multiples of the reciprocals of the plastic number and of its square.
_PLASTIC = 1.3247179572447460


def spread_points(side: int, view: View) -> np.ndarray:
    """Return side^2 points spread evenly over the square of a view, (side^2, 2): no edge lies along them."""
    unit = (0.5 + np.arange(side**2)[:, None] / [_PLASTIC, _PLASTIC**2]) % 1.0
    return view.half_width * (2.0 * unit - 1.0)


def light_of(
    stone: Stone, side: int, *, least: float, tilt: float = 0.0, tilt_azimuth: float = 90.0, **model: Any
) -> Light:
    """Return all light of a stone through side^2 points."""
    view = View.of(stone, side, tilt_deg=tilt, tilt_azimuth_deg=tilt_azimuth)
    rules = Model.of(stone, **model)
    found = paths(stone, view, rules, follow="all", points=spread_points(side, view), least=least)
    return Light(paths=found, view=view, model=rules)


def values(light: Light, chosen: tuple[Any, ...] = OF_A_VIEW) -> dict[str, dict[str, Any]]:
    """Return the values of measures by name."""
    return evaluate([light], chosen)


def by_hand(
    stone: Stone, *, tilt: float = 0.0, head: float = 10.0, index: float = 1.5, **columns: Any
) -> Light:
    """Return light of paths whose columns are given; the others are those of one straight down and out.

    A single value holds for every path.
    """
    n = max(np.atleast_1d(column).shape[0] for column in columns.values())

    def column(name: str, default: Any, *shape: int, kind: type = np.float64) -> np.ndarray:
        return np.broadcast_to(np.asarray(columns.pop(name, default), dtype=kind), (n, *shape)).copy()

    made = Paths(
        area=column("area", 1.0),
        weight=column("weight", 1.0),
        status=column("status", RayStatus.EXITED, kind=np.int64),
        reflections=column("reflections", 0, kind=np.int64),
        partial_reflections=column("partial_reflections", 0, kind=np.int64),
        entry_facet=column("entry_facet", 0, kind=np.int64),
        exit_facet=column("exit_facet", 1, kind=np.int64),
        cos_entry=column("cos_entry", 1.0),
        cos_exit=column("cos_exit", 1.0),
        exit_point=column("exit_point", 0.0, 3),
        exit_direction=column("exit_direction", (0.0, 0.0, -1.0), 3),
        entry_normal=column("entry_normal", (0.0, 0.0, 1.0), 3),
        unfolded_exit_normal=column("unfolded_exit_normal", (0.0, 0.0, -1.0), 3),
        **columns,
        stone=stone,
    )
    view = View(resolution=1, tilt_deg=tilt, tilt_azimuth_deg=90.0)
    return Light(paths=made, view=view, model=Model(index=index, fresnel="exact"), head_deg=head)


def towards(cosine: Any) -> np.ndarray:
    """Return directions (n, 3) with these cosines with the stone's axis."""
    cosine = np.atleast_1d(np.asarray(cosine, dtype=float))
    return np.column_stack([np.sqrt(1.0 - cosine**2), np.zeros(len(cosine)), cosine])

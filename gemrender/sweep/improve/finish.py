"""A search's answers finished: by single steps, and on continuous ranges by slopes."""

from __future__ import annotations

import math

import numpy as np

from gemrender.sweep.improve.goal_slopes import goal_slopes, has_slopes
from gemrender.sweep.improve.search import Places, Search

__all__ = ["finished"]

#: Most times that slopes and steps take turns.
_MOST_TURNS = 3
#: Most goals that are looked at along slopes, and without slopes for each parameter.
_MOST_ALONG, _MOST_EACH = 20, 40
#: Bound of slopes that are followed [% per unit]: few rays, the same ones whatever the time they take.
_ROUGHLY = 10.0
#: Gains by less are none [of the goal]: an exact value has an error bound that is larger.
_LEAST_GAIN = 1e-6
#: Without slopes: size of the first simplex, and where it ends [steps].
_SIMPLEX, _SMALLEST = 1.0, 1e-3


def finished(search: Search, places: Places) -> Places:
    """Go on from a stone of a search with one goal until no stone nearby is better; return the best.

    Whole steps are tried one by one, which needs no slope where values jump. On continuous ranges the goal's
    exact slopes are followed by L-BFGS-B (Byrd et al., SIAM J. Sci. Comput. 16, 1190 (1995)); a goal that has
    none, or of light that is reflected in part, goes by Nelder and Mead's simplex (Comput. J. 7, 308
    (1965)). Both by scipy; what they tried counts with the rest, so that a jump on their way loses nothing.
    """
    for _ in range(_MOST_TURNS):
        before = search.known[places][0]
        places = _by_steps(search, places)
        if not search.is_whole.all():
            places = _continuous(search, places)
        if search.is_whole.all() or not search.known[places][0] > before + _LEAST_GAIN:
            break
    return places


def _by_steps(search: Search, places: Places) -> Places:
    """Go by single steps of single parameters to better stones, until none is."""
    while True:
        beside = [
            (*places[:k], places[k] + by, *places[k + 1 :])
            for k, of in enumerate(search.ranges)
            for by in (-1, 1)
            if not of.is_continuous and 0 <= places[k] + by <= of.last
        ]
        search.measure(beside)
        best = max(beside, key=lambda at: (search.known[at], at), default=places)
        if not search.known[best] > search.known[places]:
            return places
        places = best


def _continuous(search: Search, places: Places) -> Places:
    """Move on the continuous ranges, the others as they are, to the best of all that was tried there."""
    from scipy.optimize import minimize

    moving = np.flatnonzero(~search.is_whole)
    limits = [(0.0, float(search.ranges[k].last)) for k in moving]
    tried = [places]

    def at(x: np.ndarray) -> Places:
        numbers = np.array(places, dtype=float)
        numbers[moving] = x
        return search.on_ranges(numbers)

    def loss(x: np.ndarray) -> float:
        tried.append(at(x))
        return float(search.losses(np.array([tried[-1]], dtype=float))[0, 0])

    def slopes(x: np.ndarray) -> np.ndarray:
        found = goal_slopes(search, search.values(at(x)), bound=_ROUGHLY)[0]
        scale = [search.ranges[k].step for k in moving]
        slope = np.array([found[search.ranges[k].name].slope for k in moving])
        return np.asarray(-np.nan_to_num(slope) * scale)

    start = np.array([places[k] for k in moving], dtype=float)
    # Slopes of all light take longer than the simplex.
    if has_slopes(search.aims[0]) and all(of.follow == "principal" for of in search.measures):
        minimize(
            loss, start, jac=slopes, bounds=limits, method="L-BFGS-B",
            options={"maxfun": _MOST_ALONG, "ftol": 0.0, "gtol": 1e-6},
        )  # fmt: skip
    else:
        corners = np.array([start, *(start + _SIMPLEX * side for side in np.eye(len(moving)))])
        over = corners > [high for _, high in limits]
        corners = np.where(over, corners - 2.0 * _SIMPLEX, corners).clip(0.0, [high for _, high in limits])
        minimize(
            loss, start, bounds=limits, method="Nelder-Mead",
            options={"initial_simplex": corners, "xatol": _SMALLEST, "fatol": math.inf,
                     "maxfev": _MOST_EACH * len(moving)},
        )  # fmt: skip
    return max(tried, key=lambda one: (search.known[one][0], [-x for x in one]))

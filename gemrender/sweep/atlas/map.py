"""Maps taken out of an atlas: a measure over two parameters, and where it jumps."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.optics.materials import named_index
from gemrender.reading import did_you_mean
from gemrender.stone import Stone
from gemrender.sweep.atlas.plan import STONES, VIEWS
from gemrender.sweep.atlas.store import ROUND_BRILLIANT

if TYPE_CHECKING:
    import xarray

__all__ = ["STEEPER", "AtlasMap", "atlas_map", "cliffs", "parameter_of", "two_mains_limit"]

#: A step is a cliff if it is so many times as steep as those before and after it.
STEEPER = 3.0
#: Stones of a design in a cell of its map, on the average; most cells a side.
_PER_CELL, _MOST_CELLS = 16, 60


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AtlasMap:
    """A measure over two parameters of an atlas, the others fixed or averaged over.

    Attributes
    ----------
    title, measure, unit : str
        The atlas, the variable's name, and its unit in words.
    x, y : str
        The parameters.
    at_x, at_y : (n,), (m,) float64
        Their values.
    values, bounds : (m, n) float64
        The measure, NaN where there is no stone or none yet, and its error bounds.
    fixed : dict of str to float or str
        The other parameters.
    averaged : tuple of str
        Parameters that the values are means over: those of a Sobol design.
    index : float or None
        Refractive index, where the light is seen from straight above and the stones are round brilliants.
    """

    title: str
    measure: str
    unit: str
    x: str
    y: str
    at_x: np.ndarray
    at_y: np.ndarray
    values: np.ndarray
    bounds: np.ndarray
    fixed: dict[str, float | str] = field(default_factory=dict)
    averaged: tuple[str, ...] = ()
    index: float | None = None


# ---- The map -------------------------------------------------------------------------------------------


def atlas_map(
    atlas: xarray.Dataset, x: str | None, y: str | None, measure: str | None, at: dict[str, str]
) -> AtlasMap:
    """Take a map out of an atlas.

    Parameters
    ----------
    atlas : xarray.Dataset
        The atlas (`open_atlas`).
    x, y : str or None
        The parameters; by default the first two that have several values.
    measure : str or None
        The variable, such as inoue_average or iso; `inoue.average` and `inoue` are understood; by default the
        first measure.
    at : dict of str to str
        Where the other parameters are fixed: at the value that is nearest. By default in their middle.

    Raises
    ------
    InputError
        An unknown parameter or measure, or a value that is none.
    """
    design = [str(name) for name in atlas.coords if atlas[name].dims == (STONES,)]
    grid = [str(name) for name in atlas.dims if name not in (STONES, VIEWS)]
    numeric = design + [name for name in grid if atlas[name].dtype.kind == "f" and atlas.sizes[name] > 1]
    x, y = _axes(numeric, x, y)
    name = _variable(atlas, measure)
    for key in at:
        if key not in grid and key != VIEWS:
            allowed = [*(g for g in grid if g not in (x, y)), *([VIEWS] if VIEWS in atlas.dims else [])]
            raise InputError(
                f"cannot be fixed; must be one of {', '.join(allowed) or '(nothing)'}", key="--at", value=key
            )
        if key in (x, y):
            raise InputError("is an axis of the map", key="--at", value=key)
    part = atlas
    fixed: dict[str, float | str] = {}
    for key in [*(g for g in grid if g not in (x, y)), *([VIEWS] if VIEWS in atlas.dims else [])]:
        place = _place(atlas, key, at.get(key))
        part = part.isel({key: place})
        if key == VIEWS:
            fixed |= {name: float(part[name]) for name in ("tilt", "tilt_azimuth")}
        elif atlas.sizes[key] > 1 or key in at:
            fixed[key] = part[key].item() if part[key].dtype.kind == "f" else str(part[key].item())
    made = _from_design if design else _from_grid
    at_x, at_y, values, bounds = made(part, x, y, name)
    unit = {"percent": "%", "degree": "°"}.get(atlas[name].attrs.get("units", ""), "")
    return AtlasMap(
        title=str(atlas.attrs["title"]), measure=name, unit=unit, x=x, y=y, at_x=at_x, at_y=at_y,
        values=values, bounds=bounds, fixed=fixed,
        averaged=tuple(key for key in design if key not in (x, y)),
        index=_index(atlas, fixed),
    )  # fmt: skip


def _axes(numeric: list[str], x: str | None, y: str | None) -> tuple[str, str]:
    for option, name in (("--x", x), ("--y", y)):
        if name is not None and name not in numeric:
            raise InputError(
                f"must be one of {', '.join(numeric)}{did_you_mean(name, numeric)}", key=option, value=name
            )
    others = [name for name in numeric if name not in (x, y)]
    x = x or (others.pop(0) if others else None)
    y = y or (others.pop(0) if others else None)
    if x is None or y is None:
        raise InputError("has no two parameters of several numbers each", key="--y")
    if x == y:
        raise InputError("is the other axis, too", key="--y", value=y)
    return x, y


def _variable(atlas: xarray.Dataset, measure: str | None) -> str:
    bounds = [str(name) for name in atlas.data_vars if str(name).endswith("_bound")]
    names = [str(name) for name in atlas.data_vars if name not in (*bounds, "status")]
    if measure is None:
        first = atlas.attrs["measures"].split()[0].partition(":")[0].replace("-", "_")
        measure = first
    name = measure.replace(".", "_").replace("-", "_")
    if name not in names and f"{name}_average" in names:
        return f"{name}_average"
    if name not in names:
        raise InputError(
            f"must be one of {', '.join(sorted(names))}{did_you_mean(name, names)}",
            key="--measure",
            value=measure,
        )
    return name


def _place(atlas: xarray.Dataset, key: str, text: str | None) -> int:
    """Return the place along a dimension that is nearest to what was written, or the middle one."""
    size = atlas.sizes[key]
    if text is None:
        return 0 if key == VIEWS else size // 2
    if key != VIEWS and atlas[key].dtype.kind != "f":
        words = [str(word) for word in atlas[key].values]
        if text not in words:
            raise InputError(f"must be one of {', '.join(words)}", key=f"--at {key}", value=text)
        return words.index(text)
    values = np.arange(size) if key == VIEWS else atlas[key].values
    try:
        wanted = float(text)
    except ValueError:
        wanted = math.nan
    if not values.min() <= wanted <= values.max():
        raise InputError(
            f"must be a number from {values.min():g} to {values.max():g}", key=f"--at {key}", value=text
        )
    return int(np.abs(values - wanted).argmin())


def _from_grid(part: xarray.Dataset, x: str, y: str, name: str) -> tuple[np.ndarray, ...]:
    at_x, at_y = (np.asarray(part[key].values, dtype=np.float64) for key in (x, y))
    right, up = np.argsort(at_x), np.argsort(at_y)
    values, bounds = (
        np.asarray(part[key].transpose(y, x).values, dtype=np.float64)[np.ix_(up, right)]
        for key in (name, _bound_of(part, name))
    )
    return at_x[right], at_y[up], values, bounds


def _from_design(part: xarray.Dataset, x: str, y: str, name: str) -> tuple[np.ndarray, ...]:
    """Return means over the stones of a design that fall into each cell of a grid."""
    values = part[name].values.astype(np.float64)
    known = np.isfinite(values)
    if not known.any():
        raise InputError("has no stone yet", key="--measure", value=name)
    side = int(np.clip(math.sqrt(known.sum() / _PER_CELL), 1, _MOST_CELLS))
    points = [part[key].values[known].astype(np.float64) for key in (y, x)]
    counts, edges_y, edges_x = np.histogram2d(points[0], points[1], bins=side)
    with np.errstate(invalid="ignore", divide="ignore"):
        means, bounds = (
            np.histogram2d(
                points[0], points[1], bins=[edges_y, edges_x], weights=of.values[known].astype(np.float64)
            )[0]
            / counts
            for of in (part[name], part[_bound_of(part, name)])
        )
    return 0.5 * (edges_x[1:] + edges_x[:-1]), 0.5 * (edges_y[1:] + edges_y[:-1]), means, bounds


def _bound_of(atlas: xarray.Dataset, name: str) -> str:
    return str(atlas[name].attrs["ancillary_variables"].split()[0])


def _index(atlas: xarray.Dataset, fixed: dict[str, float | str]) -> float | None:
    """Return the index of round brilliants that are seen from straight above; else None."""
    if atlas.attrs["cut"] != ROUND_BRILLIANT or fixed.get("tilt"):
        return None
    material: Any = fixed.get("material", fixed.get("index", atlas.attrs["material"]))
    return float(named_index(material))


# ---- Cliffs --------------------------------------------------------------------------------------------


def cliffs(at: np.ndarray, values: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Tell between which neighbours of a row the values jump, (..., n - 1) bool.

    A step is a cliff if it is over thrice as steep as the steps before and after it, which tell the
    derivative there, and larger than the sum of its ends' error bounds. Of the two steps next to it on either
    side the flatter one counts, as the other may be a cliff too. The first and the last step have one side
    only, which is not enough to tell.

    Parameters
    ----------
    at : (n,) float64
        Where the values are, in increasing order.
    values, bounds : (..., n) float64
        The values and their error bounds; NaN where there are none.
    """
    steps = np.abs(np.diff(values, axis=-1))
    slopes = steps / np.diff(at)
    before, after = _beside(slopes), _beside(slopes[..., ::-1])[..., ::-1]
    beside = np.maximum(before, after)  # NaN where one side is missing
    is_larger = slopes > STEEPER * beside  # of NaN, nothing is larger
    return np.asarray(is_larger & (steps > bounds[..., 1:] + bounds[..., :-1]))


def _beside(slopes: np.ndarray) -> np.ndarray:
    """Return the smaller one of the two slopes before each; NaN where there is none."""
    return np.asarray(np.fmin(_shifted(slopes, 1), _shifted(slopes, 2)))


def _shifted(slopes: np.ndarray, by: int) -> np.ndarray:
    """Return the slope so many places before each; NaN where there is none."""
    missing = np.full((*slopes.shape[:-1], by), np.nan)
    return np.asarray(np.concatenate([missing, slopes], axis=-1)[..., : slopes.shape[-1]])


def two_mains_limit(crown_angle: np.ndarray, index: float) -> np.ndarray:
    """Return the pavilion angle at which light straight from above begins to be held back by bezels [deg].

    Light that enters the table straight from above, and is reflected by two opposite pavilion mains of the
    angle p, comes up at 180 - 4 p deg to the axis, and meets the bezel of angle c at 4 p - 180 + c deg: it is
    totally reflected from p = (180 - c + critical angle) / 4 on.
    """
    critical = math.degrees(math.asin(1.0 / index))
    return np.asarray((180.0 - crown_angle + critical) / 4.0)


def parameter_of(stone: Stone, key: str) -> float | None:
    """Return a stone's value of a parameter, by the keys that atlases vary; None where it has none."""
    cut = stone.proportions
    if cut is not None:
        other = {
            "crown_angle": lambda: cut.crown_angle_deg,
            "pavilion_angle": lambda: cut.pavilion_angle_deg,
            "lower_half": lambda: 100.0 - cut.lower_girdle_contact,
        }
        return float(other[key]() if key in other else getattr(cut, key, math.nan))
    if isinstance(stone.cut, Family):
        value = (stone.cut.values() | stone.cut.alternatives()).get(key)
        return float(value) if isinstance(value, (int, float)) else None
    return None

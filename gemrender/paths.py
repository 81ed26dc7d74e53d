"""Paths: what light does in a stone that is seen from one direction, whoever has traced it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from gemrender.shown import Shown, library
from gemrender.stone import Stone

__all__ = ["FOLLOW", "Paths", "library"]

#: Ways to follow light: `principal`, by total reflection until the first crossing below the critical angle
#: (the paper); `all`, where at each such crossing the transmitted share leaves and the reflected one goes on.
FOLLOW = ("principal", "all")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Paths(Shown):
    """Paths of light, one row a path, followed back from the eye: of a pixel, a ray, or a virtual facet.

    No tracer knows a measure, and no measure a tracer: measures are functions of these
    (`gemrender.measures`). Where planes carry derivatives (complex128), so do areas, weights, cosines, points
    and directions.

    Where all light is followed, a ray has a row for each crossing through which some of it leaves, and the
    first of them is its principal path: rows with no partial reflection together make the view. The share of
    the light at the eye that comes along a path is T(cos_entry) weight T(cos_exit), T = 1 - R by Fresnel.

    Attributes
    ----------
    area : (n,) float64 or complex128
        Area of the view that each stands for [stone's unit^2]. Of random continuations (rows of a ray that
        has been reflected in part) the area divided by the probability of being chosen: sums of area times
        share are unbiased.
    weight : (n,) float64 or complex128
        Product of the reflectances at the partial reflections inside before it leaves; 1 without any.
    status : (n,) int64
        `RayStatus`. TRAPPED is light that is still inside where it was followed no further.
    reflections : (n,) int64
        Reflections inside, total and partial ones.
    partial_reflections : (n,) int64
        The partial ones among them, below the critical angle; 0 on the principal path.
    entry_facet, exit_facet : (n,) int64
        Facets on the eye's side and on the light's side; -1 for none.
    cos_entry, cos_exit : (n,) float64 or complex128
        Cosines of the angles in air at both crossings; 0 where there is none.
    exit_point : (n, 3) float64 or complex128
        Where the path leaves the stone: where the light came in [stone's unit].
    exit_direction : (n, 3) float64 or complex128
        Unit direction in which it leaves; the light came the opposite way.
    entry_normal : (n, 3) float64 or None
        Outward unit normal where it enters; None if the tracer does not give it.
    unfolded_exit_normal : (n, 3) float64 or None
        Outward unit normal where it leaves, mirrored back through all reflections of the path: the stone
        unfolded into one straight way from the entry. None if the tracer does not give it.
    set_number : (n,) int64 or None
        Of rays in independent sets the set that each belongs to: what the sets find scatters, and so tells
        the error. None where the rows are no random sample.
    pixel : (n,) int64 or None
        Of rays through the pixels of a map the number of the pixel, row by row from the top; else None.
    entering, leaving : (n,) float64 or None
        Shares T of the light that cross the surface where the path enters and where it leaves, of a
        birefringent stone, whose modes are not shared out by Fresnel's equations; None where they are. There
        `area` is that of a polygon or ray times the share of its modes, of all that a place has: so areas
        still make the view.
    section : (n,) float64 or None
        With them: cross-section of the light outside, where the path leaves, by that in the view.
    image_angle : (n,) float64 or None
        With them, where a measure needs it: angle at which the light of the two images leaves that are seen
        through the facets of the path, one of light that stays in one mode and one of that in the other
        [deg]; NaN where there are not both.
    images : (n,) int64 or None
        Of a part of a symmetric view, how many of the whole view's virtual facets each row stands for; None
        where the whole view was traced.
    stone : Stone
        What was traced.
    """

    area: np.ndarray
    weight: np.ndarray
    status: np.ndarray
    reflections: np.ndarray
    partial_reflections: np.ndarray
    entry_facet: np.ndarray
    exit_facet: np.ndarray
    cos_entry: np.ndarray
    cos_exit: np.ndarray
    exit_point: np.ndarray
    exit_direction: np.ndarray
    entry_normal: np.ndarray | None = None
    unfolded_exit_normal: np.ndarray | None = None
    set_number: np.ndarray | None = None
    pixel: np.ndarray | None = None
    entering: np.ndarray | None = None
    leaving: np.ndarray | None = None
    section: np.ndarray | None = None
    image_angle: np.ndarray | None = None
    images: np.ndarray | None = None
    stone: Stone

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        return f"<Paths of {self.stone.name!r}: {len(self)} paths>"

    def rows(self, chosen: np.ndarray) -> Paths:
        """Return some of the paths: those of numbers (k,), or where a mask (n,) is true."""
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(
            self,
            **{name: column[chosen] for name, column in columns.items() if isinstance(column, np.ndarray)},
        )

    @staticmethod
    def joined(parts: Sequence[Paths]) -> Paths:
        """Return the rows of several, one after the other: a column that one of them lacks all lack.

        But `set_number`: rows of a part without it are in none, -1.
        """
        values: dict[str, Any] = {}
        for name in (each.name for each in fields(Paths) if each.name != "stone"):
            columns = [getattr(part, name) for part in parts]
            if name == "set_number" and any(column is not None for column in columns):
                columns = [
                    np.full(len(part), -1) if column is None else column
                    for part, column in zip(parts, columns, strict=True)
                ]
            lacks = any(column is None for column in columns)
            values[name] = None if lacks else np.concatenate(columns)
        return Paths(stone=parts[0].stone, **values)

    def to_dict(self) -> dict[str, np.ndarray]:
        """Return the columns by name; points and directions in three, named `..._x`, `..._y` and `..._z`."""
        out: dict[str, np.ndarray] = {}
        for name in (each.name for each in fields(self) if each.name != "stone"):
            column = getattr(self, name)
            if column is None:
                continue
            if column.ndim == 2:
                out |= {f"{name}_{axis}": column[:, k] for k, axis in enumerate("xyz")}
            else:
                out[name] = column
        return out

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame, one row a path, with the columns of `to_dict`.

        Raises
        ------
        BackendError
            pandas is not installed.
        """
        return library("pandas").DataFrame(self.to_dict())

    def to_xarray(self) -> Any:
        """Return an xarray Dataset along `path`; points and directions along `axis` too.

        Raises
        ------
        BackendError
            xarray is not installed.
        """
        columns = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "stone"}
        return library("xarray").Dataset(
            {
                name: (("path", "axis")[: column.ndim], column)
                for name, column in columns.items()
                if column is not None
            },
            coords={"axis": ["x", "y", "z"]},
            attrs={"stone": self.stone.name},
        )

"""What a measure is: a function of paths, with a name, a version, a definition and a source.

One of your own is a class with a `contributions` method::

    class Overhead(Measure):
        name, version = "overhead", 1
        definition = "light from within 30 degrees of the viewer's zenith"
        source = "this example"

        def contributions(self, light):
            return light.share * (light.zenith_cosine > np.cos(np.pi / 6))

    gemrender.score(stone, measures=["inoue", Overhead()])
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from gemrender.observation import Model, RayStatus, View
from gemrender.optics.fresnel import reflectance, transmittance
from gemrender.paths import Paths

__all__ = ["HEAD_DEG", "TIE", "Light", "Measure", "in_columns", "is_above", "is_tied"]

T = TypeVar("T")

#: Half the angle at which the viewer's head is seen from the stone [deg].
HEAD_DEG = 10.0
#: A direction so close to a limit of a zone counts as outside it, and as tied (difference of cosines).
TIE = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class Light:
    """Paths as measures take them: what several measures need is worked out once.

    Attributes
    ----------
    paths : Paths
        One row a path.
    view, model : View, Model
        From where and by which model they were traced.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    zenith : (3,) float64, optional
        The viewer's zenith, the middle of the head; by default the direction to the eye. Of a pair of eyes it
        lies between them.
    """

    paths: Paths
    view: View
    model: Model
    head_deg: float = HEAD_DEG
    zenith: np.ndarray | None = None
    _found: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: str, work: Callable[[], T]) -> T:
        """Return what `work` returns, under a key of its own: worked out once, for all that ask for it."""
        if key not in self._found:
            self._found[key] = work()
        found: T = self._found[key]
        return found

    @cached_property
    def principal(self) -> Light:
        """The principal paths alone: what measures of the principal light are given."""
        if not self.paths.partial_reflections.any():
            return self
        return replace(self, paths=self.paths.rows(np.flatnonzero(self.paths.partial_reflections == 0)))

    def __len__(self) -> int:
        return len(self.paths)

    @cached_property
    def is_exit(self) -> np.ndarray:
        """(n,) bool: light that leaves the stone."""
        return np.asarray(self.paths.status == RayStatus.EXITED)

    @cached_property
    def is_principal(self) -> np.ndarray:
        """(n,) bool: principal paths, which have met the stone: their areas make the view."""
        return np.asarray((self.paths.partial_reflections == 0) & (self.paths.status != RayStatus.MISSED))

    def leaves_by(self, side: str) -> np.ndarray:
        """Tell which leave through a facet of the side "crown", "girdle" or "pavilion", (n,) bool."""
        return np.asarray(self.is_exit & self._on_side(self.paths.exit_facet, side))

    def enters_by(self, side: str) -> np.ndarray:
        """Tell which enter through a facet of that side, (n,) bool."""
        met = self.paths.status != RayStatus.MISSED
        return np.asarray(met & self._on_side(self.paths.entry_facet, side))

    def _on_side(self, facet: np.ndarray, side: str) -> np.ndarray:
        return np.asarray(np.array([of == side for of in self.paths.stone.facet_sides])[facet])

    @cached_property
    def head_cosine(self) -> float:
        """Cosine of the edge of the viewer's head; infinite without a head, which then hides nothing."""
        return math.cos(math.radians(self.head_deg)) if self.head_deg else math.inf

    @cached_property
    def zenith_cosine(self) -> np.ndarray:
        """(n,) cosine of the exit direction with the viewer's zenith; -1 to 1."""
        zenith = self.view.basis()[2] if self.zenith is None else self.zenith
        return np.asarray(self.paths.exit_direction @ zenith)

    @cached_property
    def entering(self) -> np.ndarray:
        """(n,) share of the light at the eye that is inside before any exit: T of the entry, by Fresnel."""
        met = self.paths.status != RayStatus.MISSED
        return np.asarray(np.where(met, 1.0 - self.surface_reflectance, 0.0))

    @cached_property
    def arriving(self) -> np.ndarray:
        """(n,) share of the light at the eye that arrives where the path leaves: entering times weight."""
        return np.asarray(self.entering * self.paths.weight)

    @cached_property
    def share(self) -> np.ndarray:
        """(n,) share of the light at the eye that comes along the path; 0 for what does not leave."""
        leaving = self.paths.leaving
        if leaving is None:
            leaving = transmittance(np.where(self.is_exit, self.paths.cos_exit, 1.0), self.model.index)
        return np.asarray(np.where(self.is_exit, self.arriving * leaving, 0.0))

    @cached_property
    def surface_reflectance(self) -> np.ndarray:
        """(n,) reflectance of the facet that each path enters by; 0 where none does."""
        met = self.paths.status != RayStatus.MISSED
        if self.paths.entering is not None:
            return np.asarray(np.where(met, 1.0 - self.paths.entering, 0.0))
        cos = np.where(met, self.paths.cos_entry, 1.0)
        return np.asarray(np.where(met, reflectance(cos, self.model.index), 0.0))

    @cached_property
    def sky_share(self) -> np.ndarray:
        """(n,) `share` of what comes from the open sky, between the horizon and the head; else 0."""
        return np.asarray(np.where(self._is_open(self.zenith_cosine), self.share, 0.0))

    @cached_property
    def mirrored_sky(self) -> np.ndarray:
        """(n,) reflectance where the facet of entry mirrors the open sky, on principal rows; else 0."""
        is_lit = self.is_principal & self._is_open(self.mirror_cosine)
        return np.asarray(np.where(is_lit, self.surface_reflectance, 0.0))

    def _is_open(self, cosine: np.ndarray) -> np.ndarray:
        return np.asarray(is_above(cosine, 0.0) & (cosine.real < self.head_cosine - TIE))

    @cached_property
    def sky_ties(self) -> tuple[np.ndarray, np.ndarray]:
        """Both (n,): `share`, and what is mirrored, of what is at the edge of horizon or head."""
        limits = 0.0, self.head_cosine
        mirrored = self.is_principal & is_tied(self.mirror_cosine, *limits)
        return (
            np.where(is_tied(self.zenith_cosine, *limits), self.share, 0.0),
            np.where(mirrored, self.surface_reflectance, 0.0),
        )

    @cached_property
    def mirror_cosine(self) -> np.ndarray:
        """(n,) cosine with the viewer's zenith of the direction that the facet of entry mirrors to the eye.

        With the zenith at the eye that is 2 cos^2 - 1.
        """
        cos = self.paths.cos_entry
        if self.zenith is None:
            return np.asarray(2.0 * cos**2 - 1.0)
        assert self.paths.entry_normal is not None, "all light has normals"
        return np.asarray(
            2.0 * cos * (self.paths.entry_normal @ self.zenith) - self.view.basis()[2] @ self.zenith
        )


def is_above(cosine: np.ndarray, limit: float) -> np.ndarray:
    """Tell which cosines with the zenith are above a limit, (n,) bool: a tie is not."""
    return np.asarray(cosine.real > limit + TIE)


def is_tied(cosine: np.ndarray, *limits: float) -> np.ndarray:
    """Tell which cosines with the zenith are at one of some limits within `TIE`, (n,) bool."""
    tied = np.zeros(np.shape(cosine), dtype=bool)
    for limit in limits:
        tied |= np.abs(cosine.real - limit) < TIE
    return tied


def in_columns(*columns: np.ndarray) -> np.ndarray:
    """Return columns (n,) side by side, (n, k), each contiguous in memory, as sums want them."""
    return np.array(columns, dtype=np.result_type(np.float64, *columns)).T


class Measure:
    """A function of paths; the base class of all measures.

    Attributes
    ----------
    name : str
        Name on the command line and in files.
    version : int
        Counted up whenever its numbers change.
    definition, source : str
        In words and formula, and whose it is.
    keys : tuple of str
        Names of its values; `("value",)` where there is one.
    channels : tuple of str
        Names of what `contributions` yields, in order, which are those of its maps; by default `keys`.
    unit : str
        Unit of its values. Rays are followed until values in per cent are within the wanted bound.
    detail_keys : tuple of str
        Names of what `details` returns.
    follow : {"principal", "all"}
        The light that it needs; of the principal light it is given the principal paths only.
    is_axial : bool
        Whether it is the same for every stone that a rotation about the eye's direction or a mirror plane
        through it yields; then a part of a symmetric stone's view is enough.
    views : {"one", "hemisphere"}
        Whether it is of one view, or a sum over all views from above.
    smooth_keys : tuple of str
        Names of the values that can be differentiated: `contributions` and `values` are analytic. Of complex
        paths, whose imaginary parts are derivatives, they yield complex numbers, and decide by real parts.
    needs_normals : bool
        Whether it needs the normals of paths (`Paths.entry_normal`, `Paths.unfolded_exit_normal`).
    needs_images : bool
        Whether it needs the angle between the two images of a birefringent stone (`Paths.image_angle`).
    """

    name: str = ""
    version: int = 1
    definition: str = ""
    source: str = ""
    keys: tuple[str, ...] = ("value",)
    channels: tuple[str, ...] = ()
    unit: str = "%"
    detail_keys: tuple[str, ...] = ()
    follow: str = "all"
    is_axial: bool = False
    views: str = "one"
    smooth_keys: tuple[str, ...] = ()
    needs_normals: bool = False
    needs_images: bool = False

    def contributions(self, light: Light) -> np.ndarray:
        """Return what each path adds, per unit of its area.

        Returns
        -------
        (n,) or (n, k) float64
            One column for each of `channels`, 0 to 1 for shares.
        """
        raise NotImplementedError

    def values(self, sums: np.ndarray, area: np.ndarray) -> np.ndarray:
        """Return the values, from the sums of area times contribution.

        Parameters
        ----------
        sums : (..., k) float64
            One for each of `channels` [stone's unit^2].
        area : (...,) float64
            Area of the view [stone's unit^2].

        Returns
        -------
        (..., len(keys)) float64
            By default the mean over the view in per cent.
        """
        return np.asarray(100.0 * sums / np.asarray(area)[..., None])

    def details(self, light: Light) -> dict[str, Any]:
        """Return further values that are no sums, of the paths of virtual facets; by default none."""
        return {}

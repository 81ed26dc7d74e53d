"""Light return under a sky that the viewer's head shades: `iso`, `cos` and `sc2`, with all light."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gemrender.measures.measure import Light, Measure, in_columns

__all__ = ["HEAD_WORDS", "SKIES", "Iso", "SkyMeasure", "sky_light"]


def _root(squared: np.ndarray) -> np.ndarray:
    """Return the square root, 0 of what rounding has made less than 0; complex where that is."""
    return np.asarray(np.sqrt(np.where(squared.real > 0.0, squared, 0.0)))


#: Brightness of each sky at a cosine d with the viewer's zenith, 0 < d <= 1; and as a formula.
SKIES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "iso": (np.ones_like, "1"),
    "cos": (np.asarray, "d"),
    "sc2": (lambda d: 2.0 * d * _root(1.0 - d**2), "2 d sqrt(1 - d^2)"),
}
#: What formulas of skies mean by h, and how ties count.
HEAD_WORDS = (
    "h half the angle of the viewer's head (10 deg); what is within 1e-7 of a limit is outside, and `tied`"
)


def sky_light(light: Light, name: str) -> tuple[np.ndarray, ...]:
    """Return what each path brings from the open sky, between the horizon and the viewer's head.

    Parameters
    ----------
    light : Light
        All light.
    name : {"iso", "cos", "sc2"}
        The sky.

    Returns
    -------
    four (n,) float64
        Brightness times the share that comes from inside; that the surface mirrors; and both of a limit of
        the sky within rounding.
    """

    def work() -> tuple[np.ndarray, ...]:
        sky, _ = SKIES[name]
        from_inside, mirrored = sky(light.zenith_cosine), sky(light.mirror_cosine)
        tied, mirrored_ties = light.sky_ties
        return (
            light.sky_share * from_inside,
            light.mirrored_sky * mirrored,
            tied * from_inside,
            mirrored_ties * mirrored,
        )

    return light.once(f"sky {name}", work)


class SkyMeasure(Measure):
    """Light return under one of `SKIES`.

    Parameters
    ----------
    sky : {"iso", "cos", "sc2"}
        Brightness of the sky.
    """

    keys: tuple[str, ...] = ("value", "internal", "surface", "tied")
    smooth_keys: tuple[str, ...] = keys
    is_axial = True

    def __init__(self, sky: str) -> None:
        self.sky, self.formula = sky, SKIES[sky][1]

    def contributions(self, light: Light) -> np.ndarray:
        """Return the light from inside and from the surface, (n, 4): together, each, and tied."""
        internal, surface, tied, tied_surface = sky_light(light, self.sky)
        return in_columns(internal + surface, internal, surface, tied + tied_surface)


class Iso(SkyMeasure):
    """`iso`, `cos` or `sc2`: all light, followed to its end."""

    version = 1
    source = "after GemRay 1.2.0, without its cap"

    def __init__(self, sky: str) -> None:
        super().__init__(sky)
        self.name = sky
        self.definition = (
            "light return of a sky of brightness g between horizon and head: R g(d) of the mirror direction "
            "of the facet of entry if 0 < d < cos h (surface), plus the sum of w (1 - R) g(d) over all exits "
            "with 0 < d <= cos h (internal); "
            f"g = {self.formula}, d the cosine with the viewer's zenith, {HEAD_WORDS}"
        )

"""The engines behind one call: any of them turns a stone into an Observation."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Observation
    from gemrender.stone import Stone

__all__ = ["DEFAULT_ENGINE", "DEFAULT_RESOLUTION", "DEFAULT_VARIANT", "ENGINES", "observe"]

ENGINES = ("mitsuba", "reference")
DEFAULT_ENGINE = "mitsuba"
DEFAULT_VARIANT = "llvm_ad_mono"
DEFAULT_RESOLUTION = 1024


def observe(
    stone: Stone,
    *,
    engine: str = DEFAULT_ENGINE,
    resolution: int = DEFAULT_RESOLUTION,
    variant: str = DEFAULT_VARIANT,
    fresnel: str | None = None,
    rear: str = "position",
    intensity: str = "primary",
    tilt_deg: float = 0.0,
    tilt_azimuth_deg: float = 0.0,
    progress: Callable[[float], None] | None = None,
) -> Observation:
    """Trace a stone's top view and return the maps behind its score.

    Parameters
    ----------
    stone : Stone
        The stone; `load_stone` reads one.
    engine : {"mitsuba", "reference"}
        Which tracer.
    resolution : int
        Pixels a side of the square map.
    variant : str
        Mitsuba variant; the reference has none.
    fresnel : {"gubelin", "exact"}, optional
        Transmittance law; by default Gübelin's table for diamond, Fresnel's equations for other stones.
    rear : {"position", "direction"}
        What counts as rear light.
    intensity : {"primary", "radiance"}
        The paper's measure, or radiance.
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye from the stone's axis, and the azimuth it is tilted to [deg].
    progress : callable, optional
        Called with the share done, 0 to 1.

    Raises
    ------
    InputError
        A value outside what is listed.
    BackendError
        Mitsuba cannot run here.
    """
    from gemrender.observation import Model, View

    if engine not in ENGINES:
        raise InputError(f"must be one of {', '.join(ENGINES)}", key="engine", value=engine)
    model = Model.of(stone, fresnel=fresnel, rear=rear, intensity=intensity)
    view = View.of(stone, resolution, tilt_deg=tilt_deg, tilt_azimuth_deg=tilt_azimuth_deg)
    if engine == "reference":
        from gemrender.reference import observe as by_reference

        return by_reference(stone, view, model, progress=progress)
    from gemrender.render.observe import observe as by_mitsuba

    return by_mitsuba(stone, view, model, variant=variant, progress=progress)

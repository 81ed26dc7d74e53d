"""The engines behind one call: any of them turns a stone into an Observation."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Observation
    from gemrender.stone import Stone

__all__ = [
    "DEFAULT_ENGINE",
    "DEFAULT_RESOLUTION",
    "DEFAULT_VARIANT",
    "ENGINES",
    "VARIANTS",
    "observe",
    "observe_both",
    "require_engine",
]

ENGINES = ("mitsuba", "reference")
DEFAULT_ENGINE = "mitsuba"
#: The variants of Mitsuba's wheels but the scalar ones, which are too slow for plugins in Python.
VARIANTS = tuple(
    f"{backend}_ad_{colour}"
    for backend in ("llvm", "cuda")
    for colour in ("rgb", "mono", "mono_polarized", "spectral", "spectral_polarized")
)
DEFAULT_VARIANT = "llvm_ad_mono"
#: Pixels a side.
DEFAULT_RESOLUTION = 1024


def require_engine(engine: str, variant: str = DEFAULT_VARIANT) -> None:
    """Check that an engine can trace here, before any work is done for it.

    Parameters
    ----------
    engine : {"mitsuba", "reference"}
        Which tracer. For Mitsuba, the variant is set, and left set.
    variant : str
        Mitsuba variant. The reference makes no use of it and needs no Mitsuba, but a name that no variant
        has is refused all the same: it is a slip.

    Raises
    ------
    InputError
        Unknown engine or variant.
    BackendError
        Mitsuba cannot run here.
    """
    if engine not in ENGINES:
        raise InputError(f"must be one of {', '.join(ENGINES)}", key="engine", value=engine)
    if engine == "mitsuba":
        from gemrender.render.backend import ensure_variant

        ensure_variant(variant)
    elif variant not in VARIANTS:
        raise InputError(f"must be one of {', '.join(VARIANTS)}", key="variant", value=variant)


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
        Mitsuba variant, which is set and left set; the reference makes no use of it.
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

    model = Model.of(stone, fresnel=fresnel, rear=rear, intensity=intensity)
    view = View.of(stone, resolution, tilt_deg=tilt_deg, tilt_azimuth_deg=tilt_azimuth_deg)
    require_engine(engine, variant)
    if engine == "reference":
        from gemrender.reference import observe as by_reference

        return by_reference(stone, view, model, progress=progress)
    from gemrender.render.observe import observe as by_mitsuba

    return by_mitsuba(stone, view, model, variant=variant, progress=progress)


def observe_both(
    stone: Stone,
    *,
    variant: str = DEFAULT_VARIANT,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> tuple[Observation, Observation]:
    """Trace the very same rays with Mitsuba and with the reference; options and errors as for `observe`.

    Mitsuba's rays start where single precision puts them, and the reference follows just those.
    """
    by_mitsuba = observe(stone, engine="mitsuba", variant=variant, **options)
    from gemrender.reference import observe as by_reference
    from gemrender.render.observe import sensor_rays

    rays = sensor_rays(by_mitsuba.view, variant=variant)
    return by_mitsuba, by_reference(stone, by_mitsuba.view, by_mitsuba.model, rays=rays, progress=progress)

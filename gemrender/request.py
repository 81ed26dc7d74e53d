"""What is asked of a stone: a view and a model, or the short forms that make them."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Model, View
    from gemrender.stone import Stone

__all__ = ["DEFAULT_RESOLUTION", "ShortForms", "resolve"]

#: Pixels a side.
DEFAULT_RESOLUTION = 1024

_VIEW = ("resolution", "tilt", "tilt_azimuth")
_MODEL = ("index", "fresnel", "rear", "intensity", "max_reflections")


class ShortForms(TypedDict, total=False):
    """Short forms of a view and a model: the same in every function and on the command line.

    resolution : int
        Pixels a side of the square map.
    tilt, tilt_azimuth : float
        Tilt of the eye from the stone's axis, 0 to below 90, and the azimuth it is tilted to [deg].
    index : float
        Refractive index; by default that of the stone's material.
    fresnel : {"gubelin", "exact"} or None
        Transmittance law; by default Gübelin's table for diamond, Fresnel's equations for other stones.
    rear : {"position", "facet", "direction"} or None
        What counts as rear light; by default "position" where the girdle's lower edge is level, else "facet".
    intensity : {"primary", "radiance"}
        The paper's measure, or radiance.
    max_reflections : int
        Total reflections after which a ray counts as trapped.
    """

    resolution: int
    tilt: float
    tilt_azimuth: float
    index: float | None
    fresnel: str | None
    rear: str | None
    intensity: str
    max_reflections: int


def resolve(stone: Stone, view: View | None, model: Model | None, short: ShortForms) -> tuple[View, Model]:
    """Return the view and the model that are asked for.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View or None
        Where the eye is; None for what the short forms make, by default straight above.
    model : Model or None
        The optical model; None for what the short forms make, by default that of the stone.
    short : dict
        See `ShortForms`.

    Raises
    ------
    InputError
        A value out of range, or a short form beside the object that it is of.
    TypeError
        A short form that there is not.
    """
    from gemrender.observation import Model, View

    for key in short:
        if key not in _VIEW + _MODEL:
            raise TypeError(f"unknown option {key!r}; there are view, model, {', '.join(_VIEW + _MODEL)}")
    for name, given, keys in (("view", view, _VIEW), ("model", model, _MODEL)):
        beside = [key for key in keys if key in short]
        if given is not None and beside:
            raise InputError(f"is given twice, by {name} and by itself", key=beside[0])
    if view is None:
        view = View.of(
            stone,
            short.get("resolution", DEFAULT_RESOLUTION),
            tilt_deg=short.get("tilt", 0.0),
            tilt_azimuth_deg=short.get("tilt_azimuth", 0.0),
        )
    if model is None:
        model = Model.of(stone, **{key: short[key] for key in _MODEL if key in short})  # type: ignore[literal-required]
    return view, model

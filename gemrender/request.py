"""What is asked of a stone: a view and a model, or the short forms that make them, and how it is traced."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

from gemrender import signatures
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Model, View
    from gemrender.stone import Stone

__all__ = [
    "DEFAULT_BOUND",
    "DEFAULT_HEAD",
    "DEFAULT_MEMORY_LIMIT",
    "DEFAULT_RESOLUTION",
    "DEFAULT_TIME_LIMIT",
    "DEFAULT_VARIANT",
    "ShortForms",
    "StudyOptions",
    "TiltOptions",
    "TraceOptions",
    "TracerOptions",
    "resolve",
    "spelt_out",
]

#: Pixels a side.
DEFAULT_RESOLUTION = 1024
DEFAULT_VARIANT = "llvm_ad_mono"
#: Error bound of exact scores [%].
DEFAULT_BOUND = 0.05
#: Half the angle at which the viewer's head is seen from the stone [deg].
DEFAULT_HEAD = 10.0
#: What an exact score may take before it ends with a larger bound: time [s] and memory [GiB].
DEFAULT_TIME_LIMIT = 5.0
DEFAULT_MEMORY_LIMIT = 1.0

_VIEW = ("resolution", "tilt", "tilt_azimuth")
_MODEL = ("index", "fresnel", "rear", "intensity", "max_reflections")


class ShortForms(TypedDict, total=False):
    """Short forms of a view and a model: the same in every function and on the command line.

    Keys
    ----
    resolution : int
        Pixels a side of the square map, 1 to 16384.
    tilt, tilt_azimuth : float
        Tilt of the eye from the stone's axis, 0 to below 90, and the azimuth it is tilted to [deg].
    index : float, optional
        Refractive index, 1.05 to 4; by default that of the stone's material.
    fresnel : {"gubelin", "exact"}, optional
        Transmittance law; by default Gübelin's table for diamond, Fresnel's equations for other stones.
    rear : {"position", "facet", "direction"}, optional
        What counts as rear light; by default "position" where the girdle's lower edge is level, else "facet".
    intensity : {"primary", "radiance"}
        The paper's measure, or radiance.
    max_reflections : int
        Total reflections after which a ray counts as trapped, 1 to 1000000.
    """

    resolution: int
    tilt: float
    tilt_azimuth: float
    index: float | None
    fresnel: str | None
    rear: str | None
    intensity: str
    max_reflections: int


class TracerOptions(ShortForms, total=False):
    """How a stone is traced, whatever by; and the short forms.

    Keys
    ----
    stone : Stone, str or path
        The stone, or what `load_stone` takes: the name of a bundled one, or a file.
    head : float
        Half the angle at which the viewer's head is seen from the stone, 0 to below 90 [deg].
    view : View, optional
        Where the eye is, and how many pixels a map has; by default what the short forms say: straight above,
        unless there is a tilt.
    model : Model, optional
        The optical model; by default what the short forms say: that of the stone's material.
    variant : str
        Mitsuba variant, which is set and left set; the other engines make no use of it.
    bound : float
        Wanted error bound of exact scores, with a confidence of 99.9 % [%]; the other engines make no use of
        it.
    time_limit, memory_limit : float
        What an exact score may take [s] (0.1 to 86400) and [GiB] (0.125 to 1024). Past them it ends with a
        larger bound, and a note that says so. Polygons get three fifths of the time, those of maps as much
        again. The other engines make no use of them.
    """

    view: View | None
    model: Model | None
    variant: str
    bound: float
    time_limit: float
    memory_limit: float


class TraceOptions(TracerOptions, total=False):
    """What is asked of a single trace, besides.

    Keys
    ----
    seed : int
        Seed of the exact engine's rays near the girdle, and of Mitsuba's where light is split; the reference
        makes no use of it.
    progress : callable, optional
        Called with the share done, 0 to 1.
    """

    seed: int
    progress: Callable[[float], None] | None


class StudyOptions(TracerOptions, total=False):
    """What is asked of each trace of a study, besides.

    Keys
    ----
    engine : {"auto", "exact", "mitsuba", "reference"}
        Which tracer; "auto" is the exact one for convex stones, and Mitsuba for others.
    """

    engine: str


class TiltOptions(StudyOptions, total=False):
    """The same of a study that draws nothing by chance itself; `seed` as of `TraceOptions`."""

    seed: int


_SHORT_DEFAULTS: ShortForms = {
    "resolution": DEFAULT_RESOLUTION,
    "tilt": 0.0,
    "tilt_azimuth": 0.0,
    "index": None,
    "fresnel": None,
    "rear": None,
    "intensity": "primary",
    "max_reflections": 1000,
}
_DEFAULTS: dict[str, Any] = {
    "engine": "auto",
    "view": None,
    "model": None,
    "variant": DEFAULT_VARIANT,
    "bound": DEFAULT_BOUND,
    "seed": 1,
    "time_limit": DEFAULT_TIME_LIMIT,
    "memory_limit": DEFAULT_MEMORY_LIMIT,
    "progress": None,
    **_SHORT_DEFAULTS,
}
_FORMS = {
    form.__name__: form for form in (ShortForms, TracerOptions, TraceOptions, StudyOptions, TiltOptions)
}
_TEXTS = {
    name: text for form in _FORMS.values() for name, text in signatures.parameter_texts(form.__doc__).items()
}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def spelt_out(**defaults: Any) -> Callable[[_Function], _Function]:
    """Spell out `**options: Unpack[...]`, of one of the forms above, in a function's help.

    Its docstring need say nothing of parameters that mean the same as there.

    Parameters
    ----------
    **defaults
        Those that are the function's own.
    """

    def spell_out(function: _Function) -> _Function:
        (form,) = (
            form
            for name, form in _FORMS.items()
            if f"Unpack[{name}]" in (str(annotation) for annotation in function.__annotations__.values())
        )
        types = signatures.types_of(form)
        of_form = {name: value for name, value in {**_DEFAULTS, **defaults}.items() if name in types}
        return signatures.spelt_out(defaults=of_form, texts=_TEXTS, types=types)(function)

    return spell_out


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
    asked: ShortForms = {**_SHORT_DEFAULTS, **short}
    if view is None:
        view = View.of(
            stone,
            asked["resolution"],
            tilt_deg=asked["tilt"],
            tilt_azimuth_deg=asked["tilt_azimuth"],
        )
    if model is None:
        model = Model.of(stone, **{key: asked[key] for key in _MODEL})  # type: ignore[literal-required]
    return view, model

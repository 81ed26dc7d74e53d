"""Paths of light by Mitsuba: principal ones, or all light by one random later exit for each ray."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import CROSSING_CHANNELS, LATER_CHANNELS, MAP_CHANNELS, Model, RayStatus, View
from gemrender.paths import FOLLOW, Paths
from gemrender.render.backend import ensure_variant
from gemrender.render.observe import film_rays, rows_of_pass, view_passes
from gemrender.scene.generator import stone_scene
from gemrender.scene.loading import load_scene
from gemrender.stone import Stone

__all__ = ["trace_passes", "trace_paths"]

#: Rays of a pass: of each, some thirty numbers in double precision are brought back.
PASS_RAYS = 1 << 19

#: Columns of Paths that are channels of the integrator: of the principal path, and of the later exit.
_ENTRY = {
    "entry_facet": MAP_CHANNELS["entry_facet"],
    **{name: CROSSING_CHANNELS[name] for name in ("entry_normal", "cos_entry")},
    "pixel": ("pixel",),
}
_PRINCIPAL = {
    **{
        name: MAP_CHANNELS[name]
        for name in ("status", "reflections", "exit_facet", "exit_point", "exit_direction")
    },
    "cos_exit": CROSSING_CHANNELS["cos_exit"],
    **_ENTRY,
}
_LATER = LATER_CHANNELS | _ENTRY
#: Columns of whole numbers.
_WHOLE = (
    "status", "reflections", "partial_reflections", "entry_facet", "exit_facet", "set_number", "pixel",
)  # fmt: skip


def trace_paths(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    follow: str = "all",
    variant: str = "llvm_ad_mono",
    seed: int = 1,
    spp: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Paths:
    """Follow rays from the eye into a stone with Mitsuba, in passes of some rows.

    Where all light is followed, a ray that leaves has a second row: one later exit of those to which the
    light comes that its first exit reflects. At each crossing it was that one with the probability T. Its
    area is the ray's divided by the probability with which it was chosen, so that sums of area times share
    are, on average, those over all exits; see `Paths`, and `docs/model.md`.

    Parameters
    ----------
    stone : Stone
        The stone.
    view : View
        Where the eye is, and how many pixels the view has.
    model : Model, optional
        The optical model; by default that of the stone's material.
    follow : {"principal", "all"}
        Which light.
    variant : str
        Mitsuba variant; set, and left set.
    seed : int
        Seed of the random numbers, 0 or more.
    spp : int
        Rays for each pixel. One goes through its centre, as in `observe`. Of more, each goes through a
        random place in the pixel: the first ones of all pixels are one independent set, the second ones
        another (`Paths.set_number`), and the scatter over the sets tells the error.
    progress : callable, optional
        Called with the share done, 0 to 1, after each pass.

    Returns
    -------
    Paths
        First the principal paths, ray after ray, then the later exits; rays that miss the stone left out.

    Raises
    ------
    InputError
        Unknown variant or way to follow light, or a number out of range.
    BackendError
        Mitsuba cannot run here.
    """
    parts = list(
        trace_passes(
            stone, view, model, follow=follow, variant=variant, seed=seed, spp=spp, progress=progress
        )
    )
    later = [part.partial_reflections > 0 for part in parts]
    principal = [part.rows(~chosen) for part, chosen in zip(parts, later, strict=True)]
    return Paths.joined([*principal, *(part.rows(chosen) for part, chosen in zip(parts, later, strict=True))])


def trace_passes(
    stone: Stone,
    view: View,
    model: Model | None = None,
    *,
    follow: str = "all",
    variant: str = "llvm_ad_mono",
    seed: int = 1,
    spp: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Iterator[Paths]:
    """Yield what `trace_paths` does pass by pass, as it is traced.

    A pass is some rows of the view, from the top; parameters and errors are those of `trace_paths`.
    """
    if follow not in FOLLOW:
        raise InputError(f"must be one of {', '.join(FOLLOW)}", key="follow", value=follow)
    for key, value, least in (("seed", seed, 0), ("spp", spp, 1)):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
            raise InputError(f"must be a whole number, at least {least}", key=key, value=value)
    model = model or Model.of(stone)
    ensure_variant(variant)
    rows = rows_of_pass(view, PASS_RAYS)
    described = stone_scene(stone, view, model, rows=rows, follow=follow)
    described["sensor"]["sampling"] = "centre" if spp == 1 else "area"
    scene: Any = load_scene(described)
    eye, sampler = scene.sensors()[0], load_scene({"type": "independent"})
    area = (2.0 * view.half_width / view.resolution) ** 2 / spp
    for number in range(spp):
        for first, kept in view_passes(eye, view, rows):
            of_pass = int(np.random.SeedSequence([seed, number, first]).generate_state(1)[0])
            sampler.seed(of_pass, rows * view.resolution)
            found = _trace(scene, film_rays(eye, None if spp == 1 else sampler), sampler)
            found = {name: values[: kept * view.resolution] for name, values in found.items()}
            found["pixel"] = first * view.resolution + np.arange(kept * view.resolution)
            of_ray = {"area": area, "set_number": number}
            met = found["status"] != RayStatus.MISSED
            columns = _columns(found, _PRINCIPAL, met, weight=1.0, partial_reflections=0, **of_ray)
            if follow == "all":
                later = _columns(found, _LATER, found["later.status"] != RayStatus.MISSED, **of_ray)
                later["area"] /= later.pop("probability")
                columns = {name: np.concatenate([column, later[name]]) for name, column in columns.items()}
            columns |= {name: columns[name].astype(np.int64) for name in _WHOLE}
            sets = columns.pop("set_number")
            yield Paths(**columns, set_number=sets if spp > 1 else None, stone=stone)
            if progress is not None:
                progress((number + (first + kept) / view.resolution) / spp)


def _trace(scene: Any, ray: Any, sampler: Any) -> dict[str, np.ndarray]:
    """Follow rays by the scene's integrator; return what it tells of them, each (n,)."""
    import drjit as dr

    found = scene.integrator().trace(scene, ray, sampler)
    dr.eval(found)
    return {name: np.asarray(values) for name, values in found.items()}


def _columns(
    found: dict[str, np.ndarray],
    channels: dict[str, tuple[str, ...]],
    chosen: np.ndarray,
    **constant: float,
) -> dict[str, Any]:
    """Return columns of Paths, of one channel or three, and constant ones, of the rays chosen (n,) bool."""
    parts = {name: [found[channel][chosen] for channel in of_map] for name, of_map in channels.items()}
    n = int(np.count_nonzero(chosen))
    return {
        **{name: part[0] if len(part) == 1 else np.column_stack(part) for name, part in parts.items()},
        **{name: np.full(n, value, dtype=np.float64) for name, value in constant.items()},
    }

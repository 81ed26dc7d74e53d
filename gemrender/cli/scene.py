"""The command `scene`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.gems import (
    SIZE,
    GemOptions,
    SettingOptions,
    Setup,
    Size,
    load_gems,
    picture_size,
)
from gemrender.cli.groups import command
from gemrender.cli.options import (
    EngineOptions,
    ModelOptions,
    Resolution,
    Stones,
    Variant,
    ViewOptions,
    output_option,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import say
from gemrender.cli.stones import load
from gemrender.cli.values import whole_option
from gemrender.engines import DEFAULT_RESOLUTION, DEFAULT_VARIANT
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.scene.photoreal import Gem
    from gemrender.scene.setup import Setup

__all__ = ["scene"]

#: Options of the scored scene, and those of a picture's.
_OF_SCORES = ("resolution", "fresnel", "rear", "intensity", "tilt", "tilt_azimuth")
_OF_PICTURES = (
    "stock", "carat", "diameter", "c_axis", "size", "spp",
    "setting", "metal", "girdle", "analyser", "polariser",
)  # fmt: skip
#: Stones that a picture's file is named after at most.
_MOST_NAMED = 3


@command
def scene(
    context: typer.Context,
    stones: Stones,
    model: ModelOptions,
    view: ViewOptions,
    gem: GemOptions,
    held: SettingOptions,
    out: Annotated[str, output_option("Where to write the XML and PLY files.")],
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
    setup: Annotated[str | None, Setup] = None,
    stock: Annotated[
        bool,
        typer.Option(
            "--stock", help="With Mitsuba's own plugins only, for its program mitsuba: no dispersion, RGB."
        ),
    ] = False,
    birefringence: Annotated[
        bool | None,
        typer.Option(
            "--birefringence/--no-birefringence",
            help="Whether birefringent stones split light, or have their ordinary index; by default they "
            "split it in pictures, not in the scored scene.",
        ),
    ] = None,
    size: Size = SIZE,
    spp: Annotated[
        int, whole_option("--spp", "Samples a pixel, where Mitsuba renders the picture.", low=1, high=1 << 24)
    ] = 64,
) -> None:
    """Write the scored scene of each stone, or with --setup a picture's, as Mitsuba XML with meshes."""
    for key in _OF_SCORES if setup is not None else _OF_PICTURES:
        if _is_given(context, key):
            which = "the scored scene only, not with" if setup is not None else "a picture's scene only, with"
            raise InputError(f"is for {which} --setup", key=f"--{key.replace('_', '-')}")
    if setup is None:
        engine = EngineOptions(variant=variant, resolution=resolution)
        _scored(stones, out, trace_options(engine, model, view), gem.material, bool(birefringence))
        return
    if stock and birefringence:
        raise InputError(
            "is not for --stock: Mitsuba's own plugins split no light", key="--birefringence", value=True
        )

    from gemrender.render.shots import filtered
    from gemrender.render.shots import held as held_in
    from gemrender.scene.setup import load_setup

    gems = load_gems(stones, gem)
    around = held_in(load_setup(setup), setting=held.setting, metal=held.metal, girdle=held.girdle)
    around = filtered(around, analyser=held.analyser, polariser=held.polariser)
    if not _is_given(context, "variant"):
        variant = "llvm_ad_rgb" if stock else "llvm_ad_spectral"
    splits = birefringence is not False
    _picture(stones, gems, around, out, variant, picture_size(size), spp, stock, splits)


def _is_given(context: typer.Context, key: str) -> bool:
    source = context.get_parameter_source(key)
    return source is not None and source.name != "DEFAULT"


def _scored(
    stones: list[str],
    out: str,
    options: dict[str, Any],
    material: str | float | None,
    birefringence: bool,
) -> None:
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import check_folder, file_stems, prepare_folder
    from gemrender.scene.xml import write_scene

    loaded = load(stones, options, material=material)
    check_folder(out)
    loaded.tell()
    ensure_variant(options["variant"])
    folder = prepare_folder(out)
    for stone, stem in zip(loaded.stones, file_stems(loaded.names), strict=True):
        view, model = view_and_model(stone, options)
        say(f"written: {write_scene(folder, stem, stone, view, model, birefringence=birefringence)}")


def _from_anywhere(material: str | float) -> str | float:
    """Name a material file such that it is found from any folder."""
    from gemrender.optics import material_names
    from gemrender.optics.materials import normal_name

    if not isinstance(material, str) or normal_name(material) in material_names():
        return material
    return str(Path(material).absolute())


def _picture(
    stones: list[str],
    gems: list[Gem],
    setup: Setup,
    out: str,
    variant: str,
    size: tuple[int, int],
    samples: int,
    stock: bool,
    birefringence: bool,
) -> None:
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import check_folder, file_stems, prepare_folder
    from gemrender.scene.photoreal import photoreal_scene, title_of
    from gemrender.scene.xml import write_photoreal

    check_folder(out)
    ensure_variant(variant)
    gems = [replace(gem, material_name=_from_anywhere(gem.material_name)) for gem in gems]
    width, height = size
    made = photoreal_scene(
        gems, setup, width=width, height=height, birefringence=birefringence, stock=stock, samples=samples
    )
    names = [*stones[:_MOST_NAMED], setup.source or setup.name]
    (stem,) = file_stems(["-".join(file_stems(names))])  # as a whole, it is no longer than one
    about = f"{title_of(gems)}; set-up {setup.name}"
    path = write_photoreal(prepare_folder(out), stem, made, about=about, stock=stock)
    say(f"written: {path}")

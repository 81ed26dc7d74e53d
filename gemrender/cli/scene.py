"""The command `scene`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.gems import SIZE, Carat, Diameter, Material, Size, load_gems, picture_size
from gemrender.cli.options import (
    RESOLUTION,
    Fresnel,
    Intensity,
    Rear,
    Resolution,
    Stones,
    Tilt,
    TiltAzimuth,
    Variant,
    load,
    trace_options,
    view_and_model,
    whole,
)
from gemrender.cli.output import say
from gemrender.engines import DEFAULT_VARIANT
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.scene.photoreal import Gem
    from gemrender.scene.setup import Setup

__all__ = ["scene"]

#: Options of the scored scene, and those of a picture's.
_OF_SCORES = ("resolution", "fresnel", "rear", "intensity", "tilt", "tilt_azimuth")
_OF_PICTURES = ("stock", "material", "carat", "diameter", "size", "spp")
#: Stones that a picture's file is named after at most.
_MOST_NAMED = 3


def scene(
    context: typer.Context,
    stones: Stones,
    out: Annotated[str, typer.Option(metavar="FOLDER", help="Where to write the XML and PLY files.")],
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    setup: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Write the scene of a picture instead, with all stones: a bundled set-up "
            "(see: gemrender setups) or a file.",
        ),
    ] = None,
    stock: Annotated[
        bool,
        typer.Option(
            "--stock", help="With Mitsuba's own plugins only, for its program mitsuba: no dispersion, RGB."
        ),
    ] = False,
    material: Material = None,
    carat: Carat = None,
    diameter: Diameter = None,
    size: Size = SIZE,
    spp: Annotated[
        str, typer.Option(metavar="NUMBER", help="Samples a pixel, where Mitsuba renders the picture.")
    ] = "64",
) -> None:
    """Write the scored scene of each stone, or with --setup a picture's, as Mitsuba XML with meshes."""
    for key in _OF_SCORES if setup is not None else _OF_PICTURES:
        if _is_given(context, key):
            which = "the scored scene only, not with" if setup is not None else "a picture's scene only, with"
            raise InputError(f"is for {which} --setup", key=f"--{key.replace('_', '-')}")
    if setup is None:
        _scored(stones, out, variant, trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth))
        return

    from gemrender.scene.setup import load_setup

    gems = load_gems(stones, material, carat, diameter)
    if not _is_given(context, "variant"):
        variant = "llvm_ad_rgb" if stock else "llvm_ad_spectral"
    _picture(stones, gems, load_setup(setup), out, variant, picture_size(size), whole("spp", spp), stock)


def _is_given(context: typer.Context, key: str) -> bool:
    source = context.get_parameter_source(key)
    return source is not None and source.name != "DEFAULT"


def _scored(stones: list[str], out: str, variant: str, options: dict[str, Any]) -> None:
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.xml import write_scene

    loaded = load(stones, options)
    ensure_variant(variant)
    folder = prepare_folder(out)
    for stone, stem in zip(loaded, file_stems(stones), strict=True):
        say(f"written: {write_scene(folder, stem, stone, *view_and_model(stone, options))}")


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
) -> None:
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.photoreal import photoreal_scene
    from gemrender.scene.xml import write_photoreal

    if not 1 <= samples <= 1 << 24:
        raise InputError(f"must be from 1 to {1 << 24}", key="spp", value=samples)
    ensure_variant(variant)
    gems = [replace(gem, material_name=_from_anywhere(gem.material_name)) for gem in gems]
    width, height = size
    made = photoreal_scene(gems, setup, width=width, height=height, stock=stock, samples=samples)
    names = [*stones[:_MOST_NAMED], setup.source or setup.name]
    shown = ", ".join(f"{gem.stone.name} ({gem.material.name})" for gem in gems)
    (stem,) = file_stems(["-".join(file_stems(names))])  # as a whole, it is no longer than one
    about = f"{shown}; set-up {setup.name}"
    path = write_photoreal(prepare_folder(out), stem, made, about=about, stock=stock)
    say(f"written: {path}")

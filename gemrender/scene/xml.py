"""A scene as files: Mitsuba XML and the stone's mesh as PLY beside it."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gemrender.errors import InputError
from gemrender.observation import Model, View
from gemrender.scene.bitmaps import write_bitmap
from gemrender.scene.generator import dielectric, stone_scene
from gemrender.stone import Stone
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from gemrender.scene.photoreal import PhotorealScene

__all__ = ["write_photoreal", "write_scene"]


def write_scene(
    folder: str | os.PathLike[str],
    name: str,
    stone: Stone,
    view: View,
    model: Model,
    *,
    birefringence: bool = False,
) -> Path:
    """Write `name`.xml and `name`.ply, which `mi.load_file` reads once the plugins are registered.

    Needs a Mitsuba variant (`gemrender.render.backend.ensure_variant`). Both files are written whole or
    not at all.

    Parameters
    ----------
    folder : path
        Where to; made if missing.
    name : str
        Stem of both files.
    stone, view, model : Stone, View, Model
        What the scene shows, and how.
    birefringence : bool
        Whether light is split in a birefringent stone.

    Returns
    -------
    Path
        The XML file.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    scene = stone_scene(stone, view, model, birefringence=birefringence)
    meshes = {"stone": scene.pop("stone")}
    heading = _heading(stone.name, name, "llvm_ad_mono")
    return _write(Path(folder), name, scene, meshes, {"stone": dielectric(model.index)}, heading)


def write_photoreal(
    folder: str | os.PathLike[str], name: str, scene: PhotorealScene, *, about: str, stock: bool
) -> Path:
    """Write a picture's scene as `name`.xml, with a PLY file for each mesh.

    Needs a Mitsuba variant. All files are written whole or not at all.

    Parameters
    ----------
    folder : path
        Where to; made if missing.
    name : str
        Stem of all files.
    scene : PhotorealScene
        The scene.
    about : str
        What it shows, for the heading.
    stock : bool
        Whether it uses Mitsuba's own plugins only, so that the program `mitsuba` renders it.

    Returns
    -------
    Path
        The XML file.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    heading = _stock_heading(about, name) if stock else _heading(about, name, "llvm_ad_spectral")
    meshes = scene.meshes(with_surface=False)
    return _write(Path(folder), name, scene.plain, meshes, scene.mesh_surfaces(), heading)


def _write(
    folder: Path,
    name: str,
    scene: dict[str, Any],
    meshes: dict[str, Any],
    surfaces: dict[str, dict[str, Any]],
    heading: str,
) -> Path:
    """Write a scene of which the meshes go into files of their own."""
    import mitsuba as mi

    files = {key: f"{name}.ply" if len(meshes) == 1 else f"{name}_{key}.ply" for key in meshes}
    plain = {**scene}
    for key, file in files.items():
        plain[key] = {"type": "ply", "filename": file, "bsdf": surfaces[key]}
    images = {}
    for key, part in plain.items():  # a sky that is an image gets a file of its own, too
        if isinstance(part, dict) and "bitmap" in part:
            images[f"{name}_{key}.exr"] = part["bitmap"]
            plain[key] = {k: v for k, v in part.items() if k != "bitmap"}
            plain[key]["filename"] = f"{name}_{key}.exr"
    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), plain)
    kinds = {
        "gem_primary": mi.ObjectType.Integrator,
        "gem_path": mi.ObjectType.Integrator,
        "gem_orthographic": mi.ObjectType.Sensor,
        "gem_hemisphere": mi.ObjectType.Emitter,
        "gem_zones": mi.ObjectType.Emitter,
        "gem_dielectric": mi.ObjectType.BSDF,
        "gem_rough_conductor": mi.ObjectType.BSDF,
    }
    for node in state.nodes:  # Mitsuba's writer does not know the kind of a Python plugin
        if node.props.plugin_name() in kinds:
            node.type = kinds[node.props.plugin_name()]

    def write_xml(path: Path) -> None:
        mi.parser.write_file(state, str(path))
        text = path.read_text(encoding="utf-8")
        path.write_text(heading + text, encoding="utf-8", newline="\n")

    def write_ply(mesh: Any) -> Callable[[Path], object]:
        return lambda path: mesh.write_ply(str(path))

    def write_image(image: Any) -> Callable[[Path], object]:
        return lambda path: write_bitmap(image, path)

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}", source=str(folder)) from error
    writers = {file: write_ply(meshes[key]) for key, file in files.items()}
    writers |= {file: write_image(image) for file, image in images.items()}
    return write_whole(folder, {**writers, f"{name}.xml": write_xml})[-1]


def _heading(what: str, name: str, variant: str) -> str:
    """Return a comment that says what the file is and how to read it."""
    how = "To render it, in Python (the program mitsuba lacks its plugins):"
    return _comment(f"""{what}, written by gemrender scene. {how}
    import gemrender
    mi = gemrender.mitsuba("{variant}")
    scene = mi.load_file("{_apart(name, '""')}.xml", optimize=False)
    image = mi.render(scene)
""")


def _stock_heading(what: str, name: str) -> str:
    # Hyphens that follow one another are no way to write doctor's option: it is there in its short form.
    return _comment(f"""{what}, written by gemrender scene. To render it:
    eval "$(gemrender doctor -e)"
    mitsuba {_apart(shlex.quote(f"{name}.xml"), "''")}
The first line tells mitsuba which LLVM to use, in DRJIT_LIBLLVM_PATH; once in a shell is enough.
""")


def _comment(text: str) -> str:
    return f"<!-- {_apart(text, ' ')}-->\n"


def _apart(text: str, between: str) -> str:
    """Put something between hyphens that follow one another, which no comment may hold.

    In a name, two quotes do not change what a shell or Python makes of it.
    """
    return re.sub("-(?=-)", f"-{between}", text)

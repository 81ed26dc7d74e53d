"""A scene as files: Mitsuba XML and the stone's mesh as PLY beside it."""

from __future__ import annotations

import os
import re
from pathlib import Path

from gemrender.errors import InputError
from gemrender.observation import Model, View
from gemrender.scene.generator import dielectric, stone_scene
from gemrender.stone import Stone
from gemrender.writing import write_whole

__all__ = ["write_scene"]


def write_scene(folder: str | os.PathLike[str], name: str, stone: Stone, view: View, model: Model) -> Path:
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

    Returns
    -------
    Path
        The XML file.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    import mitsuba as mi

    folder = Path(folder)
    scene = stone_scene(stone, view, model)
    mesh = scene["stone"]
    scene["stone"] = {"type": "ply", "filename": f"{name}.ply", "bsdf": dielectric(model.index)}
    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), scene)
    kinds = {
        "gem_primary": mi.ObjectType.Integrator,
        "gem_orthographic": mi.ObjectType.Sensor,
        "gem_hemisphere": mi.ObjectType.Emitter,
    }
    for node in state.nodes:  # Mitsuba's writer does not know the kind of a Python plugin
        if node.props.plugin_name() in kinds:
            node.type = kinds[node.props.plugin_name()]

    def write_xml(path: Path) -> None:
        mi.parser.write_file(state, str(path))
        text = path.read_text(encoding="utf-8")
        path.write_text(_heading(stone, name) + text, encoding="utf-8", newline="\n")

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}", source=str(folder)) from error
    written = write_whole(
        folder, {f"{name}.ply": lambda path: mesh.write_ply(str(path)), f"{name}.xml": write_xml}
    )
    return written[1]


def _heading(stone: Stone, name: str) -> str:
    """Return a comment that says what the file is and how to read it."""
    comment = f"""{stone.name}, written by gemrender scene. To read it in Python:
    from gemrender.render.backend import ensure_variant
    ensure_variant("llvm_ad_mono")
    import mitsuba
    scene = mitsuba.load_file("{name}.xml")
"""
    return f"<!-- {re.sub('-(?=-)', '- ', comment)}-->\n"  # no comment may hold two hyphens together

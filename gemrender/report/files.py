"""An observation as files: EXR for measuring, PNG for looking."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.errors import InputError
from gemrender.observation import Observation
from gemrender.score import score_observation

__all__ = ["file_stems", "prepare_folder", "write_exr", "write_observation"]

#: Channel of the EXR file for each map; vectors have three.
CHANNELS: dict[str, tuple[str, ...]] = {
    "primary_intensity": ("primary.intensity",),
    "rear_mask": ("rear.mask",),
    "coverage": ("coverage",),
    "status": ("status",),
    "reflections": ("reflections",),
    "exit_point": ("exit.x", "exit.y", "exit.z"),
    "exit_direction": ("exit.dx", "exit.dy", "exit.dz"),
    "entry_facet": ("entry.facet",),
    "exit_facet": ("exit.facet",),
    "path_code": ("path.code",),
}


def prepare_folder(folder: str | os.PathLike[str]) -> Path:
    """Make the folder and see that it can be written, before any work is done for it.

    Raises
    ------
    InputError
        It is a file, or cannot be made or written.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except FileExistsError as error:
        raise InputError("must be a folder, but is a file", source="--out", value=str(folder)) from error
    except OSError as error:
        raise InputError(
            f"must be a folder that can be written: {error.strerror}", source="--out", value=str(folder)
        ) from error
    return path


def file_stems(names: Iterable[str]) -> list[str]:
    """Return a stem for each name, safe in a file's name; the second of a kind gets a -2."""
    stems: list[str] = []
    for name in names:
        stem = re.sub(r"[^\w.-]+", "-", name).strip("-.").lower() or "stone"
        number, unique = 1, stem
        while unique in stems:
            number += 1
            unique = f"{stem}-{number}"
        stems.append(unique)
    return stems


def write_observation(observation: Observation, folder: Path, stem: str) -> list[Path]:
    """Write `stem`.exr and `stem`.png into the folder, each whole or not at all; return both."""
    from gemrender.report.figures import write_map_figure

    exr, png = folder / f"{stem}.exr", folder / f"{stem}.png"
    _whole(exr, lambda path: write_exr(observation, path))
    _whole(png, lambda path: write_map_figure(observation, path))
    return [exr, png]


def write_exr(observation: Observation, path: Path) -> None:
    """Write all maps as float32 channels, and what they are as attributes.

    The attribute `gemrender` is one JSON string with every number in full: stone, proportions, vertices,
    material, view, model, score, engine and version. Pixels are row by row from the top.
    """
    import OpenEXR

    channels = {}
    for name, names in CHANNELS.items():
        values = np.asarray(getattr(observation, name), dtype=np.float32)
        parts = [values] if len(names) == 1 else [values[..., k] for k in range(3)]
        channels.update({n: np.ascontiguousarray(p) for n, p in zip(names, parts, strict=True)})
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "gemrender": json.dumps(describe(observation)),
        "stone": observation.stone.name,
        "proportions": json.dumps(_proportions(observation)),
        "engine": f"{observation.engine} {observation.variant}".strip(),
        "version": gemrender.__version__,
    }
    OpenEXR.File(header, channels).write(str(path))


def describe(observation: Observation) -> dict[str, Any]:
    """Return all that is known of an observation besides its maps."""
    stone = observation.stone
    return {
        "stone": stone.name,
        "proportions": _proportions(observation),
        "vertices": stone.vertices.tolist(),
        "material": stone.material,
        "view": asdict(observation.view),
        "model": asdict(observation.model),
        "score": score_observation(observation).to_dict(),
        "version": gemrender.__version__,
    }


def _proportions(observation: Observation) -> dict[str, float] | None:
    proportions = observation.stone.proportions
    return None if proportions is None else asdict(proportions)


def _whole(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file beside its place, then move it there: a failure leaves the old one as it was."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    os.close(handle)
    part = Path(name)
    try:
        write(part)
        part.chmod(0o666 & ~_umask())
        part.replace(path)
    except (OSError, RuntimeError) as error:  # OpenEXR reports a full disk as RuntimeError
        raise InputError(f"cannot be written: {error}", source=str(path)) from error
    finally:
        part.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask

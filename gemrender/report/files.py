"""An observation as files: EXR for measuring, PNG for looking."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import tempfile
import unicodedata
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.errors import InputError
from gemrender.measures.maps import MeasureMaps
from gemrender.observation import MAP_CHANNELS, Observation
from gemrender.scoring import score_observation
from gemrender.writing import write_whole

__all__ = [
    "check_folder",
    "file_stems",
    "prepare_folder",
    "write_exr",
    "write_measures_exr",
    "write_observation",
]

#: Endings of stone files, which the files made from them do not have.
_ENDING = re.compile(r"\.(toml|csv|asc|gem|gcs|stl|obj|ply|glb|srn)$", re.IGNORECASE)
#: Longest stem of a file's name [bytes]: file systems take 255 with the ending.
MOST_STEM_BYTES = 200


def prepare_folder(folder: str | os.PathLike[str]) -> Path:
    """Make the folder and see that it can be written, before any work is done for it.

    Raises
    ------
    InputError
        It is a file, or cannot be made or written.
    """
    name = os.fspath(folder)

    def refused(reason: str) -> InputError:
        return InputError(f"must be a folder that can be written: {reason}", key="out", value=name)

    if not name.strip():
        raise refused("has no name")
    try:
        name.encode()
    except UnicodeEncodeError as error:  # OpenEXR refuses such a path
        raise refused("its name is not valid Unicode") from error
    path = Path(name)
    try:
        Path(os.path.realpath(path)).mkdir(parents=True, exist_ok=True)  # a link's folder need not be there
        with tempfile.TemporaryFile(dir=path):
            pass
    except FileExistsError as error:
        raise refused("is a file") from error
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise refused(getattr(error, "strerror", None) or str(error)) from error
    return path


def check_folder(folder: str | os.PathLike[str]) -> None:
    """See that a folder can be made and written, and leave no trace: before long work.

    Raises
    ------
    InputError
        It is a file, or cannot be made or written.
    """
    path = Path(folder)
    missing = []
    with contextlib.suppress(OSError, ValueError):  # what cannot be looked at is told below
        while not path.exists() and not path.is_symlink() and path != path.parent:
            missing.append(path)
            path = path.parent
    try:
        prepare_folder(folder)
    finally:
        for made in missing:
            with contextlib.suppress(OSError, ValueError):
                made.rmdir()


def file_stems(names: Iterable[str]) -> list[str]:
    """Return a stem for each stone, safe in a file's name; the second of a kind gets a -2.

    Parameters
    ----------
    names : iterable of str
        What the user named the stones by: bundled names, or paths of stone files.
    """
    stems: list[str] = []
    for name in names:
        plain = _ENDING.sub("", Path(name).name)
        plain = re.sub(r"[^\w.-]+", "-", unicodedata.normalize("NFC", plain)).strip("-.").lower()
        stem = plain.encode(errors="ignore")[:MOST_STEM_BYTES].decode(errors="ignore") or "stone"
        number, unique = 1, stem
        while unique in stems:
            number += 1
            unique = f"{stem}-{number}"
        stems.append(unique)
    return stems


def write_observation(observation: Observation, folder: Path, stem: str) -> list[Path]:
    """Write `stem`.exr and `stem`.png into the folder, both whole or none; return both.

    Raises
    ------
    InputError
        They cannot be written.
    """
    from gemrender.report.figures import write_map_figure

    return write_whole(
        folder,
        {
            f"{stem}.exr": lambda path: write_exr(observation, path),
            f"{stem}.png": lambda path: write_map_figure(observation, path),
        },
    )


def write_exr(observation: Observation, path: Path) -> None:
    """Write all maps as float32 channels, and what they are as attributes.

    The attribute `gemrender` is one JSON string with every number in full: stone, proportions, vertices,
    material, view, model, score, engine, version, and the facets with their planes. Pixels are row by row
    from the top.
    """
    channels: dict[str, np.ndarray] = {}
    for name, names in MAP_CHANNELS.items():
        values = np.asarray(getattr(observation, name), dtype=np.float32)
        parts = [values] if len(names) == 1 else [values[..., k] for k in range(3)]
        channels.update(zip(names, parts, strict=True))
    _write_channels(path, channels, observation, json.dumps(describe(observation)))


def write_measures_exr(maps: MeasureMaps, path: Path) -> None:
    """Write maps of measures as float32 channels such as `aset.green`, with `coverage`, and what they are.

    Per cent, or the measure's own unit. The attributes are those of `write_exr`, but for the paper's score,
    and `cut`, the kind of cut, and `measures`, the version of each measure by its name (JSON); in the
    attribute `gemrender`, of each measure version, unit, definition, source and values.
    """
    measures = {
        of.name: {"version": of.version, "unit": of.unit, "definition": of.definition, "source": of.source}
        | {"values": {key: _number(value) for key, value in maps.values[of.name].items()}}
        for of in maps.measures
    }
    known = _describe_stone(maps) | {"head_deg": maps.head_deg, "measures": measures}
    _write_channels(
        path,
        {"coverage": maps.coverage} | maps.channels(),
        maps,
        json.dumps(known | _describe_shape(maps)),
        cut="" if maps.stone.cut is None else type(maps.stone.cut).__name__,
        measures=json.dumps({of.name: of.version for of in maps.measures}),
    )


def _write_channels(
    path: Path, channels: dict[str, np.ndarray], of: Observation | MeasureMaps, known: str, **more: str
) -> None:
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "gemrender": known,
        "stone": of.stone.name,
        "proportions": json.dumps(_proportions(of)),
        "engine": f"{of.engine} {of.variant}".strip(),
        "gemrender.version": gemrender.__version__,  # "version" itself is OpenEXR's own, of another type
        **more,
    }
    contiguous = {name: np.ascontiguousarray(values) for name, values in channels.items()}
    OpenEXR.File(header, contiguous).write(str(path))


def describe(observation: Observation) -> dict[str, Any]:
    """Return all that is known of an observation besides its maps."""
    score = {"score": score_observation(observation).to_dict()}
    return _describe_stone(observation) | score | _describe_shape(observation)


def _describe_stone(of: Observation | MeasureMaps) -> dict[str, Any]:
    stone = of.stone
    return {
        "stone": stone.name,
        "proportions": _proportions(of),
        "vertices": stone.vertices.tolist(),
        "material": stone.material,
        "view": asdict(of.view) | {"resolution": int(of.view.resolution)},
        "model": asdict(of.model),
    }


def _describe_shape(of: Observation | MeasureMaps) -> dict[str, Any]:
    stone = of.stone
    return {
        "version": gemrender.__version__,
        "facets": [asdict(facet) for facet in stone.facets],
        "planes": stone.solid.planes.tolist(),
        "plane_facet": stone.solid.facet.tolist(),
        "is_round": stone.is_round,
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value


def _proportions(of: Observation | MeasureMaps) -> dict[str, float] | None:
    proportions = of.stone.proportions
    return None if proportions is None else asdict(proportions)

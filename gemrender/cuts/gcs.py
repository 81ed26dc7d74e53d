"""Gem Cut Studio's .gcs: a solved design as XML.

::

    <GemCutStudio version="1000">
      <index gear base symmetry mirror/>
      <tier angle depth name instructions visible guide>
        <facet nx ny nz index_angle> <vertex x y z/> ... </facet> ...
      </tier> ...
      <render material refractive_index ...> <color r g b/> </render>
      <info title author date .../>
    </GemCutStudio>

The tier's angle is that of the normal from +z: 0 table, 90 girdle, above 90 pavilion, 180 culet. The normals
and vertices are what counts; they have the digits of 32-bit numbers in files that the program itself wrote.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ElementTree, ParseError, SubElement, indent

import numpy as np

from gemrender.cuts.design import MOST_FACETS, Design
from gemrender.cuts.text import number_of, one_line
from gemrender.cuts.tiers import DOUBLE_ROUNDING, SINGLE_ROUNDING, tiers_of
from gemrender.errors import InputError
from gemrender.reading import located_at, read_bytes
from gemrender.stone.polyhedron import intersect
from gemrender.writing import write_whole

__all__ = ["parse_gcs", "read_gcs", "write_gcs"]

#: Name of the root.
ROOT = "GemCutStudio"
#: Largest number in a file: its square is finite, and so is what the numbers make.
LARGEST = 1e50
#: Most teeth of a gear.
MOST_TEETH = 100_000
#: Attributes of <info> that are headers, then those that are footnotes.
_HEADERS = ("title", "author", "date", "header2", "header3")
_FOOTNOTES = ("footer1", "footer2", "footer3", "footer4")


def read_gcs(path: str | os.PathLike[str]) -> Design:
    """Read a Gem Cut Studio .gcs file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Design
        The planes of the file's normals and vertices; its `notes` say what was left out.

    Raises
    ------
    InputError
        The file cannot be read, or is none of Gem Cut Studio's.
    """
    file = Path(path)
    with located_at(str(file)):
        return parse_gcs(read_bytes(file, kind="Gem Cut Studio .gcs", most_bytes=20_000_000))


def parse_gcs(data: bytes) -> Design:
    """Return the design in the bytes of a .gcs file.

    Raises
    ------
    InputError
        They are none of Gem Cut Studio's. It has no source: see `located_at`.
    """
    root = _root(data)
    wheel = root.find("index")
    gear, offset = (
        (96.0, 0.0) if wheel is None else (_of(wheel, "gear", "index"), _of(wheel, "base", "index", 0))
    )
    if not 1 <= abs(gear) <= MOST_TEETH or not abs(offset) <= MOST_TEETH:
        raise InputError(f"the number of teeth must be 1 to {MOST_TEETH}", key="index", value=(gear, offset))
    planes, keys, names, instructions = [], [], [], []
    notes = []
    guides = bare = 0
    for number, tier in enumerate(root.iter("tier"), start=1):
        if tier.get("guide") == "true":
            guides += 1
            continue
        for place, facet in enumerate(tier.iter("facet"), start=1):
            plane = _plane(facet, f"tier {number} facet {place}")
            if plane is None:
                bare += 1
                continue
            planes.append(plane)
            keys.append(number)
            names.append(one_line(tier.get("name", "")))
            instructions.append(one_line(tier.get("instructions", "")))
            if len(planes) > MOST_FACETS:
                raise InputError(f"more than {MOST_FACETS} facets", key=f"tier {number}")
    if not planes:
        raise InputError("has no facets with three vertices")
    if guides:
        notes.append(f"{guides} tiers that are guides, not facets, left out")
    if bare:
        notes.append(f"{bare} facets without three vertices, which others cut away, left out")
    index = _index(root, notes)
    info = root.find("info")
    texts = {} if info is None else {key: one_line(value) for key, value in info.items()}
    # Vertices of 32-bit numbers are in their planes to 1e-7, those of 64-bit numbers to 1e-16.
    rounding = SINGLE_ROUNDING if max(error for _, error in planes) > DOUBLE_ROUNDING else DOUBLE_ROUNDING
    array = np.array([plane for plane, _ in planes])
    if (array[:, 3] < 0).any():
        array, moved = _about_a_point_inside(array)
        notes += moved
    return Design(
        tiers=tiers_of(
            array,
            gear=gear,
            offset=offset,
            rounding=rounding,
            keys=keys,
            names=names,
            instructions=instructions,
        ),
        gear=gear,
        offset=offset,
        index=index,
        headers=tuple(filter(None, (texts.get(key, "") for key in _HEADERS))),
        footnotes=tuple(filter(None, (texts.get(key, "") for key in _FOOTNOTES))),
        notes=tuple(notes),
    )


def write_gcs(design: Design, path: str | os.PathLike[str]) -> None:
    """Write a design as a Gem Cut Studio .gcs file.

    Parameters
    ----------
    design : Design
        The design; of a stone, `convert.design_of` makes one.
    path : str or path-like
        File to write, whole or not at all; a file that is there is replaced.

    Raises
    ------
    InputError
        The facets do not close, or the file cannot be written.
    """
    planes = design.planes().real
    corners = design.corners()
    root = Element(ROOT, version="1000")
    SubElement(root, "index", gear=f"{abs(design.gear):g}", base="0", symmetry=str(design.folds), mirror="0")
    names, number = design.kinds(), 0
    for tier in design.tiers:
        name = names[number] if tier.indices else ""
        angle = float(np.real(tier.angle_deg))
        made = SubElement(
            root,
            "tier",
            angle=repr(angle if tier.is_crown else 180.0 + angle),
            depth=repr(float(np.real(tier.distance))),
            name=one_line(name),
            instructions=one_line(tier.instructions),
            visible="true",
            guide="false",
        )
        for plane in planes[number : number + len(tier.indices)]:
            _facet(made, plane, corners[number])
            number += 1
    SubElement(root, "render", material="(from file)", refractive_index=repr(design.index or 1.0))
    info = dict(zip(("title", "author", "date", "header2", "header3"), design.headers, strict=False))
    info |= dict(zip(_FOOTNOTES, design.footnotes, strict=False))
    SubElement(root, "info", {key: one_line(value) for key, value in info.items()})
    indent(root)
    file = Path(path)
    write_whole(file.parent, {file.name: lambda made: ElementTree(root).write(made, encoding="utf-8")})


def _facet(tier: Element, plane: np.ndarray, vertices: np.ndarray) -> None:
    azimuth = float(np.degrees(np.arctan2(plane[0], plane[1]))) % 360.0
    normal = {f"n{axis}": repr(value) for axis, value in zip("xyz", plane[:3].tolist(), strict=True)}
    made = SubElement(tier, "facet", {**normal, "index_angle": repr(azimuth)})
    for vertex in vertices.tolist():
        SubElement(made, "vertex", {axis: repr(value) for axis, value in zip("xyz", vertex, strict=True)})


# ---- Reading -------------------------------------------------------------------------------------------


def _root(data: bytes) -> Any:
    """Return the root; entities and document types, which can make a small file endless, are refused."""
    from defusedxml import DefusedXmlException
    from defusedxml.ElementTree import fromstring

    try:
        root = fromstring(data.strip(), forbid_dtd=True)
    except ParseError as error:
        raise InputError(f"is no Gem Cut Studio file: {error}") from error
    except DefusedXmlException as error:
        raise InputError("has a document type or entities, which no Gem Cut Studio file has") from error
    except (ValueError, LookupError, RecursionError) as error:  # encodings that there are none of
        raise InputError(f"is no Gem Cut Studio file: {one_line(str(error))}") from error
    if root.tag != ROOT:
        raise InputError(f"is no Gem Cut Studio file: its root is {one_line(str(root.tag))[:40]}, not {ROOT}")
    return root


def _plane(facet: Any, key: str) -> tuple[np.ndarray, float] | None:
    """Return the plane of a facet and how far its vertices are off it, or None without three vertices."""
    vertices = np.array([[_of(vertex, axis, key) for axis in "xyz"] for vertex in facet.iter("vertex")])
    if len(vertices) < 3:
        return None
    normal = np.array([_of(facet, name, key) for name in ("nx", "ny", "nz")])
    length = float(np.linalg.norm(normal))
    if not length > 0:
        raise InputError("the normal must not be 0", key=key)
    normal /= length
    along = vertices @ normal
    size = float(np.abs(vertices).max()) or 1.0
    return np.append(normal, along.mean()), float(np.ptp(along)) / size


def _of(element: Any, name: str, key: str, default: float | None = None) -> float:
    """Return an attribute that is a number."""
    text = element.get(name)
    if text is None and default is not None:
        return default
    number = None if text is None else number_of(text.strip())
    if number is None or not abs(number) <= LARGEST:
        raise InputError("must be a number", key=f"{key} {name}", value=text)
    return number


def _index(root: Any, notes: list[str]) -> float | None:
    render = root.find("render")
    text = "" if render is None else render.get("refractive_index", "")
    index = number_of(text.strip())
    if index is not None and 1 < index <= LARGEST:
        return index
    notes.append(f"{one_line(text) or 'nothing'} is no refractive index above 1; it is left out")
    return None


def _about_a_point_inside(planes: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return planes about a point inside them, as distances of a design are 0 or more."""
    middle = intersect(planes).vertices.mean(axis=0)
    return np.column_stack([planes[:, :3], planes[:, 3] - planes[:, :3] @ middle]), [
        "the origin is outside the stone; it was moved to its middle"
    ]

"""What a page shows of a stone: virtual facets, scores with their bounds, and the solid to trace paths in."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam import Budget
from gemrender.beam.facets import FacetStatus, VirtualFacets
from gemrender.beam.measure import measure_facets
from gemrender.engines import check_head
from gemrender.errors import InputError
from gemrender.observation import Measurement, MeasureValues, View
from gemrender.optics.fresnel import critical_angle_deg
from gemrender.optics.metals import METALS
from gemrender.report.dimensions import dimensions, length_unit
from gemrender.report.page import traced_solid
from gemrender.report.tables import band_name, model_text
from gemrender.scene.settings.setting import SETTINGS
from gemrender.scene.setup import bundled_setups
from gemrender.scoring import Score, score_measurement
from gemrender.stone import Stone, tessellate
from gemrender.stone.facets import CROWN, GIRDLE, PAVILION
from gemrender.studio.cuttings import present_values, stone_of
from gemrender.studio.texts import is_number

__all__ = [
    "MOVING",
    "RESTING",
    "Effort",
    "Wanted",
    "frame",
    "images_of",
    "is_final",
    "measured_values",
    "traced",
]


class Effort(NamedTuple):
    """How closely a score is wanted, and what it may take: bound [%], time [s], memory [GiB]."""

    bound: float
    time: float
    memory: float


#: Wanted bound of scores, and what a frame may take, while something is dragged and at rest [%], [s], [GiB].
MOVING, RESTING = Effort(0.2, 0.4, 1.0), Effort(0.05, 30.0, 2.0)
#: Largest tilt that the map can be turned to [deg].
MOST_TILT = 75.0
#: Straight pieces of a round girdle in the drawing, while something is dragged and at rest.
_FEW_PIECES, _PIECES = 32, 96
_LONGEST_NAME = 100
_SIDES = (CROWN, GIRDLE, PAVILION)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What a page wants to see.

    Attributes
    ----------
    number : int
        The page's own count: answers carry it.
    cut : mapping
        The cutting (`cuttings`).
    name, material, size_mm
        As of `cuttings.stone_of`.
    tilt, azimuth : float
        Where the eye is [deg].
    head : float
        Half the angle at which the viewer's head is seen [deg].
    measures : tuple of str
        Further measures, by name.
    picture : str or None
        Name of the bundled set-up that a picture is rendered in; None for no picture.
    denoise : bool
        Whether the picture is shown after the denoiser.
    setting, metal : str or None
        What holds the stone in the picture, and of which metal it is; None for what the set-up has.
    """

    number: int
    cut: Mapping[str, Any] = field(repr=False)
    name: str = "stone"
    material: Any = None
    size_mm: Any = None
    tilt: float = 0.0
    azimuth: float = 0.0
    head: float = 10.0
    measures: tuple[str, ...] = ()
    picture: str | None = None
    denoise: bool = False
    setting: str | None = None
    metal: str | None = None

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> Wanted:
        """Return what a message wants.

        Raises
        ------
        InputError
            It says what cannot be.
        """
        cut, view = told.get("cut"), told.get("view") or {}
        if not isinstance(cut, Mapping):
            raise InputError("must be a cutting", key="cut")
        numbers: dict[str, float] = {}
        for key, given, low, high in (
            ("number", told.get("number"), 0, 2**53),
            ("tilt", view.get("tilt", 0.0), 0.0, MOST_TILT),
            ("azimuth", view.get("azimuth", 0.0), -1e6, 1e6),
            ("head", told.get("head", 10.0), 0.0, 89.0),
        ):
            if not is_number(given) or not low <= float(given) <= high:  # type: ignore[arg-type]
                raise InputError(f"must be a number from {low:g} to {high:g}", key=key, value=given)
            numbers[key] = float(given)  # type: ignore[arg-type]
        picture, measures = told.get("picture"), told.get("measures") or []
        if not isinstance(measures, list) or not all(isinstance(name, str) for name in measures):
            raise InputError("must be a list of names", key="measures")
        return cls(
            number=int(numbers["number"]),
            cut=cut,
            name=_one_line(told.get("name")),
            material=told.get("material"),
            size_mm=told.get("size_mm"),
            tilt=numbers["tilt"],
            azimuth=numbers["azimuth"],
            head=check_head(numbers["head"]),
            measures=tuple(measures[:20]),
            picture=_setup_of(picture),
            denoise=isinstance(picture, Mapping) and picture.get("denoise") is True,
            setting=_word_of(picture, "setting", SETTINGS),
            metal=_word_of(picture, "metal", tuple(METALS)),
        )

    def stone(self, shelf: Mapping[str, Stone]) -> Stone:
        """Make the stone; errors as of `cuttings.stone_of`."""
        return stone_of(self.cut, shelf, self.name, self.material, self.size_mm)

    def view(self, stone: Stone) -> View:
        """Return the view of the stone."""
        return View.of(stone, 1, tilt_deg=self.tilt, tilt_azimuth_deg=self.azimuth)


def _setup_of(picture: object) -> str | None:
    """Return the set-up of a picture that is wanted: one that comes with gemrender, and never a file."""
    name = picture.get("setup") if isinstance(picture, Mapping) else None
    if picture is not None and name not in bundled_setups():
        raise InputError("must be in a bundled set-up", key="picture", value=name)
    return name


def _word_of(picture: object, key: str, allowed: tuple[str, ...]) -> str | None:
    """Return what else is said of a picture that is wanted."""
    word = picture.get(key) if isinstance(picture, Mapping) else None
    if word is not None and word not in allowed:
        raise InputError(f"must be {', '.join(allowed)}", key=key, value=word)
    return word


def _one_line(name: object) -> str:
    text = "".join(c if c.isprintable() else "?" for c in str(name or "stone"))
    return text.strip()[:_LONGEST_NAME] or "stone"


def traced(stone: Stone, view: View, effort: Effort = MOVING) -> tuple[Measurement, VirtualFacets]:
    """Score a stone and return its virtual facets, of a symmetric one those of a part of the view.

    Raises
    ------
    InputError
        The stone is not convex.
    """
    return measure_facets(
        stone, view=view, model=None, bound=effort.bound, seed=1, progress=None,
        budget=Budget(effort.time, effort.memory),
    )  # fmt: skip


def frame(
    wanted: Wanted, stone: Stone, effort: Effort = MOVING
) -> tuple[dict[str, Any], dict[str, np.ndarray], Score]:
    """Return what a page shows of a stone, as a message's header and arrays, and its score.

    Errors as of `traced`.
    """
    start = time.perf_counter()
    view = wanted.view(stone)
    measured, facets = traced(stone, view, effort)
    told = score_measurement(measured, stone, view, facets.model)
    solid, mesh = traced_solid(stone), tessellate(stone, _PIECES if effort is RESTING else _FEW_PIECES)
    last = len(stone.facets) - 1
    header: dict[str, Any] = {
        "type": "frame",
        "number": wanted.number,
        "name": stone.name,
        "values": present_values(stone),
        "unit": length_unit(stone),
        "view": {"basis": view.basis().tolist(), "tilt": wanted.tilt, "azimuth": wanted.azimuth},
        "halfWidth": view.half_width,
        "images": images_of(facets),
        "score": _score(told, stone),
        "model": {
            "index": facets.model.index,
            "fresnel": facets.model.fresnel,
            "rear": facets.model.rear,
            "intensity": facets.model.intensity,
            "maxReflections": facets.model.max_reflections,
            "ground": facets.model.ground,
        },
        "criticalAngle": critical_angle_deg(facets.model.index),
        "facetNames": stone.facet_names,
        "wall": last if len(stone.facet_normals) == last else None,
        "round": stone.is_round,
        "isSettled": effort is RESTING or (not facets.left_over and measured.bound <= RESTING.bound),
        "seconds": time.perf_counter() - start,
    }
    arrays: dict[str, np.ndarray] = {
        "planes": np.array(solid["planes"], dtype=np.float64),
        "planeFacet": np.array(solid["planeFacet"], dtype=np.uint16),
        "vertices": mesh.vertices.astype(np.float32),
        "faces": mesh.faces.astype(np.uint32),
        "faceFacet": mesh.face_facet.astype(np.uint16),
        **_polygons(facets),
    }
    return header, arrays, told


def is_final(header: Mapping[str, Any]) -> bool:
    """Return whether a frame would be the same at rest: settled, and no round girdle is drawn finer."""
    return bool(header["isSettled"]) and not header["round"]


def _polygons(facets: VirtualFacets) -> dict[str, np.ndarray]:
    paths = facets.paths
    exits = facets.status == FacetStatus.EXITED
    sides = np.array([_SIDES.index(side) for side in facets.stone.facet_sides], dtype=np.uint8)
    return {
        "corners": facets.corners.astype(np.float32),
        "ends": facets.ends.astype(np.uint32),
        "area": facets.area.astype(np.float32),
        "intensity": facets.primary_intensity.astype(np.float32),
        # Of the direction that the light comes from with that to the eye, where viewers have their head.
        "zenith": (paths.exit_direction @ facets.view.basis()[2]).astype(np.float32),
        "reflections": np.minimum(facets.reflections, 65535).astype(np.uint16),
        "status": facets.status.astype(np.uint8),
        "rear": facets.rear_mask.astype(np.uint8),
        "side": np.where(exits, sides[paths.exit_facet], 255).astype(np.uint8),
    }


def images_of(facets: VirtualFacets) -> list[list[float]]:
    """Return what makes the whole view of the part that was traced.

    Returns
    -------
    list of [a, b, c, d, e, f]
        Images: a point (x, y) is at (a x + c y + e, b x + d y + f), as canvases have it.
    """
    if not len(facets.wedge):
        return [[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]]
    symmetry, out = facets.stone.symmetry, []
    double = 2.0 * float(symmetry.mirrors[0])
    mirror = np.array([[np.cos(double), np.sin(double)], [np.sin(double), -np.cos(double)]])
    for k in range(symmetry.fold):
        angle = 2.0 * np.pi * k / symmetry.fold
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        for matrix in (turn, turn @ mirror):
            moved = symmetry.centre - matrix @ symmetry.centre
            out.append([*matrix.T.ravel().tolist(), *moved.tolist()])
    return out


def _score(told: Score, stone: Stone) -> dict[str, Any]:
    assert told.facets is not None
    return {
        "average": told.average,
        "rear": told.rear,
        "unsolved": told.trapped + told.lost,
        "bands": [
            {"name": band_name(band, typeset=True), "low": band.low, "share": band.share}
            for band in told.bands
        ],
        "bound": told.bound,
        "facets": told.facets.number,
        "nearGirdle": told.facets.near_girdle,
        "modelText": model_text(told),
        "notes": list(told.notes),
        "proportions": [
            {"key": key, "value": of.value, "unit": of.unit} for key, of in dimensions(stone).items()
        ],
    }


def measured_values(told: Sequence[MeasureValues]) -> list[dict[str, Any]]:
    """Return what measures say, for JSON."""
    return [{"name": of.name, "values": of.values, "details": of.details, "bound": of.bound} for of in told]

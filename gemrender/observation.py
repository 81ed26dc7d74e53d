"""What a tracer sees of a stone: the view, and maps over it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import lru_cache
from typing import Any

import numpy as np

from gemrender.cuts import StoneLike, as_stone
from gemrender.errors import InputError
from gemrender.measurement import Measurement, MeasureValues, bound_text
from gemrender.optics.crystals import Indicatrix
from gemrender.optics.dispersion import SODIUM_NM
from gemrender.optics.fresnel import FRESNEL_LAWS, GUBELIN_INDEX
from gemrender.optics.material_files import load_material, refractive_index
from gemrender.optics.materials import INDEX_RANGE
from gemrender.shown import Shown, library, plots
from gemrender.stone import Stone

__all__ = [
    "GROUND",
    "INTENSITIES",
    "LIGHT_LEVEL",
    "MAP_CHANNELS",
    "MAP_TYPES",
    "PATH_CODE_FACTOR",
    "PATH_CODE_MASK",
    "REAR_RULES",
    "MeasureValues",
    "Measurement",
    "Model",
    "Observation",
    "RayStatus",
    "View",
    "bound_text",
    "indicatrix_of",
]

#: Rear light by where it came in (the paper: z <= 0), by the facet that it came in through (one of the
#: pavilion), or by the direction it came from.
REAR_RULES = ("position", "facet", "direction")
#: The paper's intensity per unit beam cross-section, or radiance (the same without the S factors).
INTENSITIES = ("primary", "radiance")
#: Intensity of the light that falls on the stone [%].
LIGHT_LEVEL = 100.0

#: A facet sequence f1, f2, ... is coded as c <- (c * factor + f + 1) & mask: 24 bits, which single-precision
#: channels hold exactly.
PATH_CODE_FACTOR = 61
PATH_CODE_MASK = (1 << 24) - 1

#: z = 0 within rounding, such as that of a level base's height [stone's unit].
GROUND = 1e-10
#: Largest accepted map [pixels a side].
MOST_PIXELS = 16384
#: A ray still inside after so many reflections is trapped; symmetric stones reach several hundred.
MOST_REFLECTIONS = 1000


class RayStatus(IntEnum):
    """What became of a ray followed back into the stone."""

    MISSED = 0  #: it passed the stone by
    EXITED = 1  #: it left the stone: here its light came in
    TRAPPED = 2  #: still inside after the largest number of reflections
    LOST = 3  #: numerical failure: it found no surface from inside; counted, never hidden


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """The optical model that a tracer follows (`docs/model.md`, sections 3 to 5).

    Parameters
    ----------
    index : float
        Refractive index of the stone relative to air.
    fresnel : {"gubelin", "exact"}
        Transmittance by Gübelin's table (diamond only) or by Fresnel's equations.
    rear : {"position", "facet", "direction"}
        Whether light is rear light by where it came in (z <= 0), by coming in through a pavilion facet, or by
        coming from below the horizon.
    intensity : {"primary", "radiance"}
        The paper's measure T S T S, or radiance T T.
    max_reflections : int
        Total reflections after which a ray counts as trapped.
    ground : float
        Height at and below which light is rear light by position: 0, within rounding [stone's unit].

    Raises
    ------
    InputError
        A value outside what is listed, or Gübelin's table for another index than diamond's.
    """

    index: float = GUBELIN_INDEX
    fresnel: str = "gubelin"
    rear: str = "position"
    intensity: str = "primary"
    max_reflections: int = MOST_REFLECTIONS
    ground: float = GROUND

    def __post_init__(self) -> None:
        for key, allowed in (("fresnel", FRESNEL_LAWS), ("rear", REAR_RULES), ("intensity", INTENSITIES)):
            if getattr(self, key) not in allowed:
                raise InputError(f"must be one of {', '.join(allowed)}", key=key, value=getattr(self, key))
        low, high = INDEX_RANGE
        if not low <= self.index <= high:
            raise InputError(f"must be from {low:g} to {high:g}", key="index", value=self.index)
        if self.fresnel == "gubelin" and self.index != GUBELIN_INDEX:
            raise InputError(
                f"Gübelin's table holds for diamond (index {GUBELIN_INDEX}) only, not for index "
                f"{self.index:g}; use exact",
                key="fresnel",
                value=self.fresnel,
            )
        if not 1 <= self.max_reflections <= 1_000_000:
            raise InputError("must be from 1 to 1000000", key="max_reflections", value=self.max_reflections)

    @classmethod
    def of(
        cls,
        stone: StoneLike,
        *,
        index: float | None = None,
        fresnel: str | None = None,
        rear: str | None = None,
        intensity: str = "primary",
        max_reflections: int = MOST_REFLECTIONS,
    ) -> Model:
        """Return the model for a stone.

        By default the index is that of its material, the law Gübelin's table for diamond and else Fresnel's,
        and the rule for rear light the stone's own (`Stone.rear_rule`). The stone may be what `load_stone`
        takes.
        """
        stone = as_stone(stone)
        if index is None:
            try:
                index = refractive_index(stone.material)
            except InputError as error:
                if error.source is not None:  # a material's file
                    raise
                raise error.at(stone.source or stone.name, "material") from error
        if fresnel is None:
            fresnel = "gubelin" if index == GUBELIN_INDEX else "exact"
        return cls(
            index=index,
            fresnel=fresnel,
            rear=rear or stone.rear_rule,
            intensity=intensity,
            max_reflections=max_reflections,
            # z = 0 is the level lower edge, and a level base there lies below it. Where the edge is not
            # level, it is the edge's lowest point, and nothing that reaches no lower does.
            ground=GROUND if stone.rear_rule == "position" else -GROUND,
        )


def indicatrix_of(stone: Stone, model: Model) -> Indicatrix | None:
    """Return the crystal of a birefringent stone at 589.3 nm, as it lies in the stone.

    None of an isotropic material, and where the model has another index than the material's ordinary one: who
    gives an index asks for an isotropic stone.

    Raises
    ------
    InputError
        A material that there is not.
    """
    crystal = load_material(stone.material, warn=False).crystal
    if crystal is None or model.index != refractive_index(stone.material):
        return None
    return crystal.indicatrix(SODIUM_NM, stone.crystal_axes)


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A square map of parallel rays, seen from far along one direction.

    Row 0 is the top (largest y), column 0 the left (smallest x). At tilt 0 the eye looks along -z and the
    map's x and y are the stone's. A tilt turns the eye, and the map with it, from +z towards an azimuth.

    Parameters
    ----------
    resolution : int
        Pixels a side.
    half_width : float
        Half the width of the map [girdle radius]; its centre is the origin.
    tilt_deg, tilt_azimuth_deg : float
        Tilt of the eye from the stone's axis (0 to below 90) and the azimuth it is tilted to [deg].

    Raises
    ------
    InputError
        A resolution that is not from 1 to 16384, or a tilt that is not from 0 to below 90.
    """

    resolution: int
    half_width: float = 1.0
    tilt_deg: float = 0.0
    tilt_azimuth_deg: float = 0.0

    def __post_init__(self) -> None:
        resolution = self.resolution
        if isinstance(resolution, bool) or not isinstance(resolution, (int, np.integer)):
            raise InputError("must be a whole number of pixels", key="resolution", value=resolution)
        if not 1 <= resolution <= MOST_PIXELS:
            raise InputError(
                f"must be from 1 to {MOST_PIXELS} pixels a side", key="resolution", value=resolution
            )
        if not 0 <= self.tilt_deg < 90:
            raise InputError("must be from 0 to below 90 [deg]", key="tilt", value=self.tilt_deg)
        if not np.isfinite(self.tilt_azimuth_deg):
            raise InputError("must be a finite angle [deg]", key="tilt_azimuth", value=self.tilt_azimuth_deg)

    @classmethod
    def of(
        cls, stone: StoneLike, resolution: int, *, tilt_deg: float = 0.0, tilt_azimuth_deg: float = 0.0
    ) -> View:
        """Return the view whose map just holds the stone; tilted, however it is turned.

        The stone may be what `load_stone` takes.
        """
        stone = as_stone(stone)
        half_width = max(stone.half_width, stone.reach) if tilt_deg else stone.half_width
        return cls(
            resolution=resolution,
            half_width=half_width,
            tilt_deg=tilt_deg,
            tilt_azimuth_deg=tilt_azimuth_deg,
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return (self.resolution, self.resolution)

    def basis(self) -> np.ndarray:
        """Return the map's right, its up, and the direction to the eye, in the stone's frame, (3, 3)."""
        return _basis(self.tilt_deg, self.tilt_azimuth_deg).copy()

    def cell_centres(self) -> tuple[np.ndarray, np.ndarray]:
        """Return x of the columns and y of the rows, each (resolution,) [girdle radius]."""
        step = 2 * self.half_width / self.resolution
        x = -self.half_width + step * (np.arange(self.resolution) + 0.5)
        return x, -x


@lru_cache(maxsize=16)  # a score asks for it several times
def _basis(tilt_deg: float, azimuth_deg: float) -> np.ndarray:
    tilt, azimuth = math.radians(tilt_deg), math.radians(azimuth_deg)
    cos, sin, x, y = math.cos(tilt), math.sin(tilt), math.cos(azimuth), math.sin(azimuth)
    # Rodrigues' rotation about the horizontal axis (-y, x, 0).
    across = -(1.0 - cos) * x * y
    return np.array(
        [
            [cos + (1.0 - cos) * y * y, across, -sin * x],
            [across, cos + (1.0 - cos) * x * x, -sin * y],
            [sin * x, sin * y, cos],
        ]
    )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Observation(Shown):
    """Maps over a view of a stone, one value a pixel, row 0 at the top.

    Attributes
    ----------
    primary_intensity : (h, w) float32
        Intensity by the model [%]; 0 for rear light, trapped and lost rays and outside the stone.
    rear_mask : (h, w) float32
        1 where the light is rear light, else 0.
    coverage : (h, w) float32
        1 where the ray met the stone, else 0.
    status : (h, w) uint8
        `RayStatus`.
    reflections : (h, w) int32
        Number of total reflections.
    exit_point : (h, w, 3) float32
        Where the ray followed back leaves the stone [girdle radius]: where the light came in.
    exit_direction : (h, w, 3) float32
        Unit direction in which it leaves; the light came the opposite way.
    entry_facet, exit_facet : (h, w) int16
        Facets on the eye's side and on the light's side; -1 for none.
    path_code : (h, w) int32
        Code of the whole facet sequence, for comparing paths (`PATH_CODE_FACTOR`).
    stone, view, model : Stone, View, Model
        What was traced.
    engine, variant : str
        Which tracer, and which Mitsuba variant ("" for the reference).
    seconds : float
        Time that the trace took [s].
    measured : Measurement or None
        What the engine knows of the whole view besides the pixels.
    """

    primary_intensity: np.ndarray
    rear_mask: np.ndarray
    coverage: np.ndarray
    status: np.ndarray
    reflections: np.ndarray
    exit_point: np.ndarray
    exit_direction: np.ndarray
    entry_facet: np.ndarray
    exit_facet: np.ndarray
    path_code: np.ndarray
    stone: Stone = field(repr=False)
    view: View
    model: Model
    engine: str
    variant: str = ""
    seconds: float = 0.0
    measured: Measurement | None = None

    def __post_init__(self) -> None:
        for name in MAP_TYPES:
            array = getattr(self, name)
            if array.shape[:2] != self.view.shape:
                raise ValueError(f"{name} must have shape {self.view.shape}, got {array.shape}")

    def __repr__(self) -> str:
        side, engine = self.view.resolution, " ".join(filter(None, (self.engine, self.variant)))
        return f"<Observation of {self.stone.name!r}: {side} pixels a side, by {engine}>"

    def to_xarray(self) -> Any:
        """Return the maps as an xarray Dataset along `y` (from the top) and `x`; vectors along `axis` too.

        x and y are places in the view [stone's unit]; `attrs` name the stone and what traced it.

        Raises
        ------
        BackendError
            xarray is not installed.
        """
        x, y = self.view.cell_centres()
        maps = {name: getattr(self, name) for name in MAP_TYPES}
        return library("xarray").Dataset(
            {name: (("y", "x", "axis")[: values.ndim], values) for name, values in maps.items()},
            coords={"x": x, "y": y, "axis": ["x", "y", "z"]},
            attrs={"stone": self.stone.name, "engine": self.engine, "variant": self.variant},
        )

    def plot(self, ax: Any = None) -> Any:
        """Draw the map of intensity in its bands.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.

        Returns
        -------
        matplotlib.axes.Axes
        """
        return plots().plot_observation(self, ax)


#: Type of each map of an Observation.
MAP_TYPES: dict[str, type[np.generic]] = {
    "primary_intensity": np.float32,
    "rear_mask": np.float32,
    "coverage": np.float32,
    "status": np.uint8,
    "reflections": np.int32,
    "exit_point": np.float32,
    "exit_direction": np.float32,
    "entry_facet": np.int16,
    "exit_facet": np.int16,
    "path_code": np.int32,
}

#: Channels that make each map, as the integrator and EXR files name them; vectors have three.
MAP_CHANNELS: dict[str, tuple[str, ...]] = {
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

#: Further channels of paths where all light is followed: what the principal path's crossings are.
CROSSING_CHANNELS: dict[str, tuple[str, ...]] = {
    "entry_normal": ("entry.nx", "entry.ny", "entry.nz"),
    "cos_entry": ("entry.cosine",),
    "cos_exit": ("exit.cosine",),
}

#: And one later exit, drawn at random, of the light that is reflected there.
LATER_CHANNELS: dict[str, tuple[str, ...]] = {
    "status": ("later.status",),
    "reflections": ("later.reflections",),
    "partial_reflections": ("later.partial",),
    "weight": ("later.weight",),
    "probability": ("later.probability",),
    "exit_point": ("later.x", "later.y", "later.z"),
    "exit_direction": ("later.dx", "later.dy", "later.dz"),
    "exit_facet": ("later.facet",),
    "cos_exit": ("later.cosine",),
}

"""Zones of a sky: light by elevation above the viewer's horizon, as of gem viewers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import located_at, section
from gemrender.scene import setup_checks as check

__all__ = ["MOST_ZONES", "Zone", "layers", "zones_of"]

#: Most zones of a sky, with the black ones between them.
MOST_ZONES = 32
_ALLOWED = f"must be 1 to {MOST_ZONES // 2} rows, as {{ elevation = [0, 45], colour = [0, 1, 0] }}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """A zone of a sky.

    Attributes
    ----------
    elevation : (float, float)
        From where to where it reaches above the viewer's horizon, the plane across the direction to the
        camera: 90 is straight towards the camera, -90 away from it [deg]. The lower limit belongs to it.
    colour : (float, float, float)
        Linear sRGB, 0 to 1, that comes out as it is in an EXR picture where white is D65.
    radiance : float
        What the colour is multiplied by.
    """

    elevation: tuple[float, float]
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    radiance: float = 1.0

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            elevation = mistakes.of(_numbers, self, "elevation", 2, -90, 90, "two increasing numbers")
            colour = mistakes.of(_numbers, self, "colour", 3, 0, 1, "red, green and blue, three numbers")
            mistakes.of(check.radiance, self)
        object.__setattr__(self, "elevation", elevation)
        object.__setattr__(self, "colour", colour)

    @property
    def is_dark(self) -> bool:
        """Whether it gives no light."""
        return self.radiance == 0 or not any(self.colour)


def zones_of(rows: Any) -> tuple[Zone, ...]:
    """Return the zones of rows, each a `Zone` or a table of its attributes.

    Raises
    ------
    InputError
        What is wrong with each, or a zone that overlaps another.
    """
    if rows == ():
        raise InputError(f"missing; {_ALLOWED}", key="zones")
    if not isinstance(rows, (list, tuple)) or not 1 <= len(rows) <= MOST_ZONES // 2:
        raise InputError(_ALLOWED, key="zones", value=rows)
    if not all(isinstance(row, (Zone, dict)) for row in rows):
        raise InputError(_ALLOWED, key="zones", value=list(rows))
    with Mistakes() as mistakes:
        zones = [mistakes.of(_zone, row, f"zones {k}", mistakes) for k, row in enumerate(rows, start=1)]
    found = [zone for zone in zones if zone is not None]
    with Mistakes() as mistakes:
        for k, zone in enumerate(found):
            for other in found[:k]:
                if max(zone.elevation[0], other.elevation[0]) < min(zone.elevation[1], other.elevation[1]):
                    allowed = f"must not overlap another zone's, {list(other.elevation)}"
                    key, value = f"zones {k + 1}.elevation", list(zone.elevation)
                    mistakes.add(InputError(allowed, key=key, value=value))
                    break
    return tuple(found)


def layers(zones: Sequence[Zone]) -> list[tuple[float, float, Zone | None]]:
    """Return zones with their limits from -90 to 90 [deg], the lowest first; None is a black one."""
    out: list[tuple[float, float, Zone | None]] = []
    reached = -90.0
    for zone in sorted((zone for zone in zones if not zone.is_dark), key=lambda one: one.elevation):
        low, high = zone.elevation
        if reached < low:
            out.append((reached, low, None))
        out.append((low, high, zone))
        reached = high
    return out if reached == 90 else [*out, (reached, 90.0, None)]


def _zone(row: Any, name: str, mistakes: Mistakes) -> Zone:
    if isinstance(row, Zone):
        return row
    values = section({name: row}, name, [f.name for f in fields(Zone)], mistakes=mistakes)
    with located_at(None, name):
        if "elevation" not in row:
            raise InputError("missing; must be two increasing numbers from -90 to 90", key="elevation")
        return Zone(**values)


def _numbers(part: Zone, key: str, count: int, low: float, high: float, what: str) -> tuple[float, ...]:
    values = getattr(part, key)
    error = InputError(f"must be {what} from {low:g} to {high:g}", key=key, value=values)
    if not isinstance(values, (list, tuple)) or len(values) != count:
        raise error
    for value in values:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            raise error
    if count == 2 and not values[0] < values[1]:
        raise error
    return tuple(float(value) for value in values)

"""What is stated of a stone's size: millimetres, one by one or as reports print them, carats."""

from __future__ import annotations

import re
from collections.abc import Mapping

from gemrender.cuts.round_brilliant.proportions import number_within
from gemrender.cuts.size import LENGTHS, ROUNDING_MM, StatedSize
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.optics.material import CARAT_RANGE, DIAMETER_RANGE_MM

__all__ = ["SIZE_KEYS", "read_measurements", "read_size"]

#: What may be stated of a stone's size.
SIZE_KEYS = ("measurements", "length_mm", "width_mm", "depth_mm", "diameter_mm", "carat")
_NUMBER = r"(\d+(?:[.,]\d+)?)\s*(?:mm\.?)?"
_BY = r"\s*(?:[x\u00d7\u2715*/\u2013\u2014-]|by)\s*"
_MEASUREMENTS = re.compile(rf"{_NUMBER}{_BY}{_NUMBER}(?:{_BY}{_NUMBER})?")
_AS_PRINTED = 'must be as reports print it: "8.10 x 5.95 x 3.70", of rounds "6.52 - 6.55 x 4.01" [mm]'


def read_size(values: Mapping[str, object]) -> StatedSize:
    """Read what is stated of a size.

    Parameters
    ----------
    values : mapping
        By key of `SIZE_KEYS`: numbers [mm, carat], and the measurements as one text.

    Raises
    ------
    InputError
        Nothing is stated, a value that no stone has, or two for one thing that differ.
    """
    found: dict[str, float] = {}
    told: dict[str, tuple[str, object]] = {}
    rounding = ROUNDING_MM
    with Mistakes() as mistakes:

        def add(part: str, number: float, key: str) -> None:
            if part in found and abs(found[part] - number) > rounding + ROUNDING_MM:
                other, value = told[part]
                raise InputError(
                    f"{other} = {value!r} makes it {found[part]:g}; state only one", key=key, value=number
                )
            if part not in found:
                found[part], told[part] = number, (key, values[key])

        if "measurements" in values:
            read = mistakes.of(read_measurements, values["measurements"])
            if read is not None:
                numbers, rounding = read
                for part, number in zip(LENGTHS, numbers, strict=False):
                    add(part, number, "measurements")
        for key in ("length_mm", "width_mm", "depth_mm", "diameter_mm"):
            if key not in values:
                continue
            value = mistakes.of(number_within, key, values[key], DIAMETER_RANGE_MM, "mm")
            for part in LENGTHS[:2] if key == "diameter_mm" else (key,):
                if value is not None:
                    mistakes.of(add, part, value, key)
        if "carat" in values:
            weight = mistakes.of(number_within, "carat", values["carat"], CARAT_RANGE, "carat")
            if weight is not None:
                add("carat", weight, "carat")
        if not values:
            raise InputError(f"needs one or more of {', '.join(SIZE_KEYS)}")
    return StatedSize(**found, rounding_mm=rounding, told=told)


def read_measurements(text: object) -> tuple[tuple[float, ...], float]:
    """Read measurements as reports print them.

    Parameters
    ----------
    text : str
        "8.10 x 5.95 x 3.70 mm": length, width and depth, or the first two alone; of rounds the smallest and
        the largest diameter and the depth, "6.52 - 6.55 x 4.01".

    Returns
    -------
    (tuple of float, float)
        Length, width and depth, the longer side first [mm], and half of the step that they are rounded to.

    Raises
    ------
    InputError
        It is no such text.
    """
    found = _MEASUREMENTS.fullmatch(" ".join(text.casefold().split())) if isinstance(text, str) else None
    if found is None:
        raise InputError(_AS_PRINTED, key="measurements", value=text)
    parts = [part.replace(",", ".") for part in found.groups() if part is not None]
    numbers = [number_within("measurements", float(part), DIAMETER_RANGE_MM, "mm") for part in parts]
    decimals = max(len(part.partition(".")[2]) for part in parts)
    return tuple(numbers), 0.5 * 10.0 ** -min(decimals, 2)

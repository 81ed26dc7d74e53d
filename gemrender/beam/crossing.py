"""What crossing the surface leaves of a ray's light, compiled; the laws are those of `gemrender.optics`."""

from __future__ import annotations

from typing import Any

from gemrender.beam.compiled import angle_deg, jit, real, root
from gemrender.optics.fresnel import GUBELIN_ANGLES_DEG, GUBELIN_REFLECTED, LEAST_TOTAL

__all__ = ["EXACT", "GUBELIN", "crossing_factor", "into_air", "into_stone", "is_total", "transmittance"]

EXACT, GUBELIN = 0, 1


@jit
def transmittance(cos_air: Any, index: float, law: int) -> Any:
    """Return the transmitted share T; the laws and their sources are `gemrender.optics.fresnel`'s."""
    if law == GUBELIN:
        angle = angle_deg(cos_air)
        row = 1
        while row < len(GUBELIN_ANGLES_DEG) - 1 and real(angle) > GUBELIN_ANGLES_DEG[row]:
            row += 1
        low, high = GUBELIN_ANGLES_DEG[row - 1], GUBELIN_ANGLES_DEG[row]
        share = (angle - low) / (high - low)
        return 1.0 - (GUBELIN_REFLECTED[row - 1] * (1.0 - share) + GUBELIN_REFLECTED[row] * share)
    cos_stone = root(1.0 - (1.0 - cos_air * cos_air) / (index * index))
    r_s = (cos_air - index * cos_stone) / (cos_air + index * cos_stone)
    r_p = (index * cos_air - cos_stone) / (index * cos_air + cos_stone)
    return 1.0 - 0.5 * (r_s * r_s + r_p * r_p)


@jit
def is_total(cos_stone: Any, index: float) -> bool:
    """Return whether a surface reflects all light: `gemrender.optics.fresnel.is_totally_reflected`."""
    cos = real(cos_stone)
    return bool(index * index * (1.0 - cos * cos) >= LEAST_TOTAL)


@jit
def crossing_factor(
    cos_air: Any, cos_stone: Any, index: float, law: int, radiance: bool, towards_eye: bool
) -> Any:
    """Return T S of one crossing, or T alone for radiance (`docs/model.md`, section 4)."""
    t = transmittance(cos_air, index, law)
    if radiance:
        return t
    return t * cos_stone / cos_air if towards_eye else t * cos_air / cos_stone


@jit
def into_stone(
    dx: Any, dy: Any, dz: Any, nx: Any, ny: Any, nz: Any, index: float
) -> tuple[Any, Any, Any, Any, Any]:
    """Refract a ray into the stone: its direction, and the cosines in air and in the stone."""
    cos_air = -(dx * nx + dy * ny + dz * nz)
    tx, ty, tz = (dx + cos_air * nx) / index, (dy + cos_air * ny) / index, (dz + cos_air * nz) / index
    cos_stone = root(1.0 - tx * tx - ty * ty - tz * tz)
    return tx - cos_stone * nx, ty - cos_stone * ny, tz - cos_stone * nz, cos_air, cos_stone


@jit
def into_air(
    dx: Any, dy: Any, dz: Any, nx: Any, ny: Any, nz: Any, index: float
) -> tuple[Any, Any, Any, Any, Any]:
    """Refract a ray out of the stone: its direction, and the cosines in air and in the stone."""
    cos_stone = dx * nx + dy * ny + dz * nz
    tx, ty, tz = (dx - cos_stone * nx) * index, (dy - cos_stone * ny) * index, (dz - cos_stone * nz) * index
    left = 1.0 - tx * tx - ty * ty - tz * tz
    cos_air = root(left) if real(left) > 0.0 else 0.0 * left
    return tx + cos_air * nx, ty + cos_air * ny, tz + cos_air * nz, cos_air, cos_stone

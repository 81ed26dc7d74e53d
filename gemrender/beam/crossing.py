"""Where a ray goes at the surface, compiled; the laws are those of `gemrender.optics`."""

from __future__ import annotations

from typing import Any

from gemrender.beam.compiled import jit, real, root
from gemrender.optics.fresnel import LEAST_TOTAL

__all__ = ["PARALLEL", "into_air", "into_stone", "is_total", "reflected_share"]

#: A ray runs along a plane and never meets it if the cosine between it and the normal is no larger: rounding.
PARALLEL = 1e-12


@jit
def is_total(cos_stone: Any, index: float) -> bool:
    """Return whether a surface reflects all light: `gemrender.optics.fresnel.is_totally_reflected`."""
    cos = real(cos_stone)
    return bool(index * index * (1.0 - cos * cos) >= LEAST_TOTAL)


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


@jit
def reflected_share(cos_air: Any, cos_stone: Any, index: float) -> Any:
    """Return the reflectance for unpolarised light: `gemrender.optics.fresnel.reflectance`."""
    a, b = cos_air, cos_stone
    s, p = (a - index * b) / (a + index * b), (index * a - b) / (index * a + b)
    return 0.5 * (s * s + p * p)

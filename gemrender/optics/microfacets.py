"""How much light a rough surface keeps where, among its microfacets, only the first bounce counts."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

__all__ = ["COSINES", "single_albedo"]

#: Cosines from 0 to 1 that the albedo is tabulated at: near 0, where it changes most, they are closest.
COSINES = np.linspace(0.0, 1.0, 65) ** 2
#: Strata across of the numbers that it is averaged over.
_STRATA = 128


@lru_cache(maxsize=16)
def single_albedo(alpha: float) -> tuple[np.ndarray, float]:
    """Return what a mirror's microfacets send out after one bounce, at each angle and on average.

    Facets of GGX's distribution with Smith's shadowing and masking, each by itself (G = G1 G1), as Mitsuba's
    ``roughconductor`` has it. Normals are drawn as they are seen: Dupuy & Benyoub, "Sampling visible GGX
    normals with spherical caps", Comput. Graph. Forum 42 (2023); then the share of a bounce is G1 of the
    direction that it goes out in: Heitz, "Sampling the GGX distribution of visible normals", J. Comput.
    Graph. Tech. 7 (4), 2018, equation (19).

    Parameters
    ----------
    alpha : float
        Roughness, above 0 and up to 1.

    Returns
    -------
    albedo : (65,) float64
        Share of light that comes in at `COSINES`.
    average : float
        The same of light from everywhere, 2 times the integral of albedo cos d(cos) of that table.
    """
    u, v = np.meshgrid(*2 * [(np.arange(_STRATA) + 0.5) / _STRATA])
    albedo = np.array([_albedo(cos, alpha, u, v) for cos in COSINES])
    root = np.linspace(0.0, 1.0, 4097)  # of the cosine, which is read by it
    return albedo, float(4 * np.trapezoid(np.interp(root, np.sqrt(COSINES), albedo) * root**3, root))


def _albedo(cos: float, alpha: float, u: np.ndarray, v: np.ndarray) -> float:
    seen = np.array([alpha * np.sqrt(1 - cos * cos), 0.0, max(cos, 1e-6)])
    seen /= np.linalg.norm(seen)
    z = (1 - v) * (1 + seen[2]) - seen[2]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    cap = np.stack([across * np.cos(2 * np.pi * u), across * np.sin(2 * np.pi * u), z], axis=-1) + seen
    normal = cap * (alpha, alpha, 1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    wi = np.array([np.sqrt(1 - cos * cos), 0.0, cos])
    out = 2 * (normal @ wi) * normal[..., 2] - cos  # cosine of the direction that is sent out
    tan2 = (1 - out**2) / np.maximum(out**2, 1e-12)
    return float(np.where(out > 0, 2 / (1 + np.sqrt(1 + alpha**2 * tan2)), 0.0).mean())

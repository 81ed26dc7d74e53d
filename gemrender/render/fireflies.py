"""Fireflies: pixels that one chance sample made bright. Clamped for the screen only, never in an EXR."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gemrender.render.photoreal import Picture

__all__ = ["FEWEST_SAMPLES", "firefly_scale", "without_fireflies"]

#: How much brighter a pixel may be than what both halves of the samples saw in it or beside it. On velvet at
#: 64 samples 2 % of the pixels are, with 0.16 % of the light; in other set-ups fewer than 0.1 %.
BRIGHTER = 2.0
#: Samples a pixel from which on chance is told from light; with fewer, all of a stone is chance.
FEWEST_SAMPLES = 16


def firefly_scale(halves: np.ndarray) -> np.ndarray:
    """Return what the pixels are multiplied by, (h, w): 1, or less where one is a firefly.

    Two independent halves of the samples see the same light. What only one of them saw, and none of the eight
    pixels beside it either, came by chance: the luminance is brought down to `BRIGHTER` times the largest,
    of the pixel and those beside it, of what both halves saw, which is the lesser of the two. A sparkle of a
    single pixel stays: it is in both.

    Parameters
    ----------
    halves : (2, h, w) float
        Luminance by each half of the samples.
    """
    height, width = halves.shape[1:]
    agreed = np.pad(np.min(halves, axis=0), 1)
    beside = [agreed[i : i + height, j : j + width] for i in range(3) for j in range(3)]
    limit = BRIGHTER * np.max(beside, axis=0)
    luminance = np.mean(halves, axis=0)
    scale = np.ones(luminance.shape, dtype=np.float32)
    np.divide(limit, luminance, out=scale, where=luminance > limit)
    return scale


def without_fireflies(picture: Picture) -> Picture:
    """Return the picture with fireflies clamped; as it is where they cannot be told (one pass, denoised)."""
    if picture.halves is None or picture.samples < FEWEST_SAMPLES:
        return picture
    scale = firefly_scale(picture.halves)[..., None]
    front = picture.foreground
    if front is not None:
        front = replace(front, xyz=front.xyz * scale)
    clamped = int((scale < 1).sum())
    return replace(picture, xyz=picture.xyz * scale, foreground=front, halves=None, clamped=clamped)

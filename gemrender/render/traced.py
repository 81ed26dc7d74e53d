"""The film of light that stones throw: rays from lights, summed up in the pixels that see where they land."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from gemrender.render.lanes import lanes_at_once

__all__ = ["TracedFilm"]


class TracedFilm:
    """Sums up what rays from lights count, in whole numbers: in whatever order, the sum is the same.

    Parameters
    ----------
    caustics : Caustics
        What traces light.
    width, height : int
        Size [pixels].
    filter_radius : float
        As of `Passes`: the filter's share of a ray goes to each pixel.
    draw : callable
        Makes wavelengths, their weights, and the responses of X, Y, Z of a number in [0, 1).
    binned : callable
        Makes the values of spectral bins of radiance, weights and wavelengths: a list, empty where there are
        none.
    kept : callable, optional
        Tells of shapes whether they are the foreground: X, Y, Z of it are summed up too, and bins are of it
        alone.
    """

    def __init__(
        self,
        caustics: Any,
        *,
        width: int,
        height: int,
        filter_radius: float,
        draw: Callable[..., Any],
        binned: Callable[..., list[Any]],
        kept: Callable[[Any], Any] | None = None,
    ) -> None:
        self._caustics, self._draw, self._binned, self._kept = caustics, draw, binned, kept
        self._width, self._height, self._radius = width, height, filter_radius

    def rays_for(self, samples: int) -> int:
        """Return how many rays go with so many samples of the camera."""
        return max(1, round(float(self._caustics.rays_a_sample) * samples))

    def radiance(self, n: int, first: int, seeds: Sequence[int]) -> np.ndarray:
        """Return the mean radiance that n rays from the lights add, (seeds, k, pixels) float64.

        Channels are X, Y, Z; those of the foreground, where it is asked for; and bins.

        Parameters
        ----------
        n, first : int
            How many rays of each seed, and how many there have been of it.
        seeds : sequence of int
            One seed or two, each for a film of its own.
        """
        import drjit as dr
        import mitsuba as mi

        pixels = self._width * self._height
        sums: list[Any] = []
        drawn: list[Any] = []

        def draw(u: Any) -> Any:
            nm, weight, response = self._draw(u)
            drawn[:] = weight, response
            return nm

        def splat(film: Any, place: Any, nm: Any, counts: Any, shape: Any, active: Any) -> None:
            weight, response = drawn
            values = [c * w for c, w in zip(counts, weight, strict=True)]
            channels = [sum(v * r[k] for v, r in zip(values, response, strict=True)) for k in range(3)]
            if self._kept is not None:
                kept = self._kept(shape)
                channels += [dr.select(kept, channel, 0) for channel in channels]
                counts = dr.select(kept, counts, 0)
            channels += self._binned(counts, weight, nm)
            for pixel, share, shown in self._pixels(place, active):
                for total, value in zip(sums, channels, strict=True):
                    counts_here = mi.UInt64(dr.maximum(value, 0) * share)
                    # Copies for each thread, as by default, would have the film's size in the kernel
                    dr.scatter_add(total, counts_here, film + pixel, shown, dr.ReduceMode.Local)

        n_channels = (3 if self._kept is None else 6) + len(
            self._binned(mi.Spectrum(0), mi.Spectrum(0), mi.Spectrum(0))
        )
        sums += [dr.zeros(mi.UInt64, len(seeds) * pixels) for _ in range(n_channels)]
        dr.eval(sums)
        rays, at_once = len(seeds) * n, lanes_at_once()
        for start in range(0, rays, at_once):
            ray = dr.arange(mi.UInt32, min(at_once, rays - start)) + dr.opaque(mi.UInt32, start)
            is_second = ray >= dr.opaque(mi.UInt32, n)
            film = dr.select(is_second, dr.opaque(mi.UInt32, pixels), 0)
            number = ray - dr.select(is_second, dr.opaque(mi.UInt32, n), 0)
            number += dr.opaque(mi.UInt32, first & 0xFFFFFFFF)
            key = dr.select(is_second, *(dr.opaque(mi.UInt32, seed) for seed in (seeds[-1], seeds[0])))
            self._caustics.trace(number, key, partial(splat, film), draw)
            dr.eval(sums)
        unit = self._caustics.unit * pixels / n
        films = [np.asarray(total).astype(np.float64).reshape(len(seeds), -1) * unit for total in sums]
        return np.stack(films, axis=1)

    def _pixels(self, place: Any, active: Any) -> Iterator[tuple[Any, Any, Any]]:
        """Yield the pixels whose filter a place in the film is in, the filter there, and for which rays."""
        import drjit as dr
        import mitsuba as mi

        tent = self._radius > 0.5
        across = math.ceil(2 * self._radius) if tent else 1
        of_axes = []
        for x, pixels in ((place.x, self._width), (place.y, self._height)):
            size = dr.opaque(mi.Float, pixels)
            at = x * size - 0.5  # in pixels: their middles are whole numbers
            first = dr.ceil(at - self._radius) if tent else dr.round(at)
            axis = []
            for k in range(across):
                pixel = first + k
                share = dr.maximum(1 - dr.abs(at - pixel) / self._radius, 0) / self._radius if tent else 1.0
                axis.append((pixel, share, active & (pixel >= 0) & (pixel < size)))
            of_axes.append(axis)
        width = dr.opaque(mi.UInt32, self._width)
        for row, share_y, in_y in of_axes[1]:
            for column, share_x, in_x in of_axes[0]:
                shown = in_x & in_y
                number = mi.UInt32(dr.select(shown, row, 0)) * width + mi.UInt32(dr.select(shown, column, 0))
                yield number, share_x * share_y, shown

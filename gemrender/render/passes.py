"""Passes of a picture: camera samples well spread over pixel, lens and wavelength, summed up as XYZ."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from gemrender.render.first_seen import Seen, is_foreground, kind_of, kinds_of
from gemrender.render.lanes import lanes_at_once
from gemrender.render.noise import relative_error
from gemrender.render.traced import TracedFilm
from gemrender.render.wavelengths import FIRST_NM, LAST_NM, binned, drawing_table
from gemrender.scene.sobol import PixelSamples

__all__ = ["FIRST_NM", "LAST_NM", "LEAST_SPP", "Passes", "camera_samples", "check_range"]

#: Samples a pixel that a pass has at least: they are spread evenly over it.
LEAST_SPP = 8


class Passes:
    """Renders a scene in passes, and keeps their sums.

    Two independent halves are kept apart; what they differ by tells the noise.

    Parameters
    ----------
    scene : mi.Scene
        Scene of a spectral variant whose integrator is `gem_path`; its first sensor's film gives the size,
        or else its shape.
    seed : int
        Seed.
    filter_radius : float
        Radius of the tent that pixels are filtered by [pixel]; 0.5 and less is a box of a pixel. Samples are
        spread as the tent is, and belong to one pixel: no two pixels share noise.
    bins_nm : sequence of float, optional
        Edges of spectral bins, increasing [nm]; None for no spectrum.
    foreground : bool
        Whether what is seen on stones, settings and things is also summed up by itself; spectral bins are of
        it alone, then.
    caustics : bool
        Whether light that stones throw on diffuse surfaces is traced from the lights (see
        `gemrender.plugins.caustics.Caustics`), where that can be; else it is found from the eye, by chance.
    size : (int, int), optional
        Width and height [pixels], in the film's proportions. Mitsuba's cameras have the film's own size in
        their kernels: films of one size for pictures of many have one kernel.
    pass_samples : int, optional
        About the samples of a pass, of all pixels; by default as many as are rendered fastest.

    Attributes
    ----------
    samples : int
        Samples a pixel so far.
    caustics : Caustics or None
        What traces light from the lights; None where stones can throw none, or it is not asked for.
    unsound : int
        Samples, of all pixels, whose radiance was negative or not finite. They count as black.

    Raises
    ------
    InputError
        Light cannot be followed through the scene: the camera is inside a stone, a stone in a stone ...
    """

    def __init__(
        self,
        scene: Any,
        *,
        seed: int = 0,
        filter_radius: float = 0.5,
        bins_nm: Any = None,
        foreground: bool = False,
        caustics: bool = True,
        size: tuple[int, int] | None = None,
        pass_samples: int | None = None,
    ) -> None:
        self.scene, self.seed, self.filter_radius = scene, seed, filter_radius
        self.sensor = scene.sensors()[0]
        scene.integrator().check(scene, self.sensor)
        self._pass_samples = pass_samples or lanes_at_once()
        self._tile_pixels = max(1, lanes_at_once() // LEAST_SPP)
        #: Windows side by side that the picture is of: each has the film's proportions.
        self._windows = 1 if scene.integrator().right_analyser is None else 2
        width, height = (int(n) for n in self.sensor.film().size())
        self.width, self.height = size or (self._windows * width, height)
        self.bins_nm = None if bins_nm is None else np.asarray(bins_nm, dtype=np.float64)
        n_bins = 0 if self.bins_nm is None else len(self.bins_nm) - 1
        #: X, Y, Z, albedo, normal (3 each), coverage; the same of stones and what stands
        #: beside them alone; bins.
        self._of_bins = slice(20 if foreground else 10, None)
        self._n_channels = self._of_bins.start + n_bins
        # Bound to what they need and not to this object: a scene in a cycle stays until garbage is collected,
        # and its shapes' numbers in the kernels of the next one, which then are compiled anew.
        self._binned = partial(binned, np.empty(0) if self.bins_nm is None else self.bins_nm)
        self._kinds, self._has_foreground = kinds_of(scene), foreground
        self._halves = np.zeros((2, self.height * self.width, self._n_channels), dtype=np.float32)
        self._counts = [0, 0]
        self.unsound, self._unsound_of_pass = 0, 0
        self._shows: np.ndarray | None = None
        self._draw = drawing_table()
        self._turns = 0
        found = scene.integrator().caustics(scene, self.sensor) if caustics else None
        self.caustics = found if found is not None and found.any else None
        self._film: TracedFilm | None = None
        self._rays_sent = [0, 0]
        if self.caustics is not None:
            self._film = TracedFilm(
                self.caustics,
                width=self.width,
                height=self.height,
                filter_radius=filter_radius,
                draw=self._draw,
                binned=self._binned,
                kept=partial(is_foreground, self._kinds) if foreground else None,
            )

    # ---- Rendering ----

    @property
    def samples(self) -> int:
        """Samples a pixel so far."""
        return sum(self._counts)

    def samples_of_a_pass(self) -> int:
        """Return the samples a pixel that keep a pass small in memory."""
        most = max(1, self._pass_samples // min(self.width * self.height, self._tile_pixels))
        return int(1 << (most.bit_length() - 1))  # powers of two are the most even

    def add(self, spp: int, *, both: bool = False) -> None:
        """Render `spp` samples a pixel more of the half whose turn it is, or of each of both, at once.

        Interrupted, it leaves the sums as they were.

        Parameters
        ----------
        spp : int
            Samples a pixel.
        both : bool
            Whether both halves get so many, after as many of each. The samples are those of two passes, and
            the integrator is traced in Python once for both.
        """
        halves = (0, 1) if both else (self._turns % 2,)
        pixels = self.width * self.height
        begin, end = halves[0] * pixels, (halves[-1] + 1) * pixels
        sums = np.empty((len(halves), pixels, self._n_channels), dtype=np.float32)
        in_a_row = sums.reshape(end - begin, -1)
        self._unsound_of_pass = 0
        for first in range(begin, end, self._tile_pixels):
            last = min(first + self._tile_pixels, end)
            tile = self._tile(first, last - first, spp, self._counts[halves[0]])
            in_a_row[first - begin : last - begin] = tile
        sent = 0 if self._film is None else self._film.rays_for(pixels * spp)
        if sent:
            sums += np.float32(spp) * self._traced(sent, halves)
        for k, half in enumerate(halves):
            self._halves[half] += sums[k]
            self._counts[half] += spp
            self._rays_sent[half] += sent
        self.unsound += self._unsound_of_pass
        self._turns += len(halves)

    def radiance_at(self, nm: float, spp: int, *, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Return the radiance at one wavelength, and the standard error of it, (h, w) each.

        Parameters
        ----------
        nm : float
            Wavelength [nm].
        spp : int
            Samples a pixel, at least 2.
        """
        pixels = self.width * self.height
        out = np.empty((2, pixels))
        for first in range(0, pixels, self._tile_pixels):
            n = min(self._tile_pixels, pixels - first)
            out[:, first : first + n] = self._monochrome_tile(first, n, spp, nm, seed)
        return out[0].reshape(self.height, self.width), out[1].reshape(self.height, self.width)

    # ---- What came of it ----

    def _mean(self, channels: slice) -> np.ndarray:
        total = self._halves[0, :, channels] + self._halves[1, :, channels]
        return (total / max(self.samples, 1)).reshape(self.height, self.width, -1)

    @property
    def xyz(self) -> np.ndarray:
        """CIE 1931 XYZ, (h, w, 3) float32; equal-energy radiance 1 has Y = 1."""
        return self._mean(slice(0, 3))

    @property
    def halves(self) -> np.ndarray | None:
        """Luminance by each of the two halves, (2, h, w) float32; None before two passes."""
        if min(self._counts) == 0:
            return None
        counts = np.array(self._counts, dtype=np.float32)[:, None]
        return (self._halves[:, :, 1] / counts).reshape(2, self.height, self.width)

    @property
    def albedo(self) -> np.ndarray:
        """Albedo of the first surface, (h, w, 3) float32."""
        return self._mean(slice(3, 6))

    @property
    def normal(self) -> np.ndarray:
        """Normal of the first surface, (h, w, 3) float32."""
        return self._mean(slice(6, 9))

    @property
    def coverage(self) -> np.ndarray:
        """Share of the pixel that shows a surface, (h, w) float32."""
        return self._mean(slice(9, 10))[..., 0]

    @property
    def spectrum(self) -> np.ndarray:
        """Mean radiance in each bin, (h, w, bins) float32."""
        bins = self._mean(self._of_bins)
        if self._has_foreground:
            bins[self._mean(slice(19, 20))[..., 0] == 0] = 0
        return bins

    @property
    def foreground(self) -> tuple[np.ndarray, ...] | None:
        """What is seen on stones, settings and things: XYZ, albedo, normal and share of the pixel.

        (h, w, 3) and the last (h, w), float32. The values are means over all samples of a pixel, those that
        meet something else counting as 0. None if it was not asked for.
        """
        if not self._has_foreground:
            return None
        xyz, albedo, normal = (self._mean(slice(first, first + 3)) for first in (10, 13, 16))
        alpha = self._mean(slice(19, 20))[..., 0]
        xyz[alpha == 0] = 0  # traced light may have met a sliver that no sample of the pixel did
        return xyz, albedo, normal, alpha

    @property
    def shows(self) -> np.ndarray:
        """What the middle of each pixel shows, (h, w) uint8 of `Seen`."""
        if self._shows is None:
            pixels = self.width * self.height
            parts = [
                self._tile_shows(first, min(self._tile_pixels, pixels - first))
                for first in range(0, pixels, self._tile_pixels)
            ]
            self._shows = np.concatenate(parts)
        return self._shows.reshape(self.height, self.width)

    @property
    def stone_pixels(self) -> np.ndarray:
        """Pixels whose middle shows a stone, (h, w) bool."""
        return np.asarray(self.shows == Seen.STONE)

    def noise(self) -> float:
        """Return the root mean square error of luminance by its mean, of the pixels that show stones.

        Of all pixels where the middle of none shows a stone. Infinite before two passes, where a value is not
        finite, and where all is black but for samples that were left out.
        """
        if min(self._counts) == 0:
            return float("inf")
        shown = self.stone_pixels.ravel()
        a, b = self._halves[:, shown, 1] if shown.any() else self._halves[:, :, 1]
        n_a, n_b = self._counts
        error = relative_error(a / n_a, b / n_b, (n_a, n_b))
        return float("inf") if error == 0 and self.unsound else error

    # ---- Kernels ----

    def _rays(self, pixel: Any, u: list[Any], wavelengths: Any) -> tuple[Any, Any]:
        """Return rays, and which are of the right one of two windows; None where there is one."""
        import drjit as dr
        import mitsuba as mi

        width, right = dr.opaque(mi.UInt32, self.width), None
        row = pixel // width
        column = pixel - row * width
        if self._windows == 2:
            width = dr.opaque(mi.UInt32, self.width // 2)
            right = column >= width
            column -= dr.select(right, width, 0)
        if self.filter_radius > 0.5:
            dx, dy = (mi.warp.interval_to_tent(x) * self.filter_radius for x in u[:2])
        else:
            dx, dy = u[0] - 0.5, u[1] - 0.5
        size = mi.Vector2f(*(dr.opaque(mi.Float, n) for n in (self.width // self._windows, self.height)))
        place = mi.Point2f(mi.Float(column) + 0.5 + dx, mi.Float(row) + 0.5 + dy) / size
        ray, _ = self.sensor.sample_ray_differential(0.0, 0.5, place, mi.Point2f(u[3], u[4]))
        ray.wavelengths = wavelengths
        return ray, right

    def _traced(self, n: int, halves: tuple[int, ...]) -> np.ndarray:
        """Return the mean radiance that n rays from the lights add, (halves, pixels, channels) float32."""
        assert self._film is not None
        seeds = [int(np.random.SeedSequence([self.seed, half, 2]).generate_state(1)[0]) for half in halves]
        found = self._film.radiance(n, self._rays_sent[halves[0]], seeds).swapaxes(1, 2)
        out = np.zeros((*found.shape[:2], self._n_channels), dtype=np.float32)
        out[..., :3] = found[..., :3]
        if self._has_foreground:
            out[..., 10:13], found = found[..., 3:6], found[..., 3:]
        out[..., self._of_bins] = found[..., 3:]
        return out

    def _tile(self, first: int, n: int, spp: int, index: int) -> np.ndarray:
        """Return the sums of samples of pixels, counted through both halves, (n, channels) float32."""
        import drjit as dr
        import mitsuba as mi

        pixels = self.width * self.height
        pixel, samples, u = camera_samples(first, n, spp, index, 2 * self.seed, pixels)
        nm, weight, response = self._draw(u[2])
        ray, right = self._rays(pixel, u, nm)
        radiance, valid, aovs = self.scene.integrator().sample_with_aovs(
            self.scene, samples, ray, caustics=self.caustics, modes_by=u[5], right=right
        )
        xyz = [
            sum(L * w * r[k] for L, w, r in zip(radiance, weight, response, strict=True)) for k in range(3)
        ]
        # One sample that is no light would spoil its pixel for good: it is left out, and counted
        sound = dr.isfinite(dr.sum(xyz)) & (dr.min(radiance) >= 0)
        radiance, xyz = dr.select(sound, radiance, 0), [dr.select(sound, x, 0) for x in xyz]
        channels = [*xyz, *aovs, dr.select(valid, mi.Float(1), 0)]
        if self._has_foreground:
            found = self.scene.ray_intersect_preliminary(ray)
            kept = is_foreground(self._kinds, found.shape, found.is_valid())
            channels += [dr.select(kept, value, 0) for value in (*xyz, *aovs, mi.Float(1))]
            radiance = dr.select(kept, radiance, 0)
        channels += self._binned(radiance, weight, nm)
        dr.eval(channels, sound)  # once for all: each sum would trace again
        self._unsound_of_pass += n * spp - int(dr.count(sound)[0])
        sums = [dr.block_sum(channel, spp) for channel in channels]
        dr.eval(sums)
        return np.stack([np.asarray(s) for s in sums], axis=1)

    def _tile_shows(self, first: int, n: int) -> np.ndarray:
        import drjit as dr
        import mitsuba as mi

        pixel = dr.arange(mi.UInt32, n) + dr.opaque(mi.UInt32, first)
        rays, _ = self._rays(pixel, [mi.Float(0.5)] * 5, mi.Spectrum(550.0))
        found = self.scene.ray_intersect_preliminary(rays)
        return np.asarray(kind_of(self._kinds, found.shape, found.is_valid())).astype(np.uint8)

    def _monochrome_tile(self, first: int, n: int, spp: int, nm: float, seed: int) -> np.ndarray:
        import drjit as dr
        import mitsuba as mi

        pixel, samples, u = camera_samples(first, n, spp, 0, 2 * (self.seed + seed))
        wavelengths = mi.Spectrum(dr.opaque(mi.Float, float(nm)))
        ray, right = self._rays(pixel, u, wavelengths)
        radiance, _, _ = self.scene.integrator().sample_with_aovs(
            self.scene, samples, ray, modes_by=u[5], right=right
        )
        value = dr.mean(radiance)
        dr.eval(value)
        mean = dr.block_sum(value, spp) / spp
        spread = dr.block_sum(dr.square(value - dr.repeat(mean, spp)), spp) / (spp * max(spp - 1, 1))
        return np.stack([np.asarray(mean), np.sqrt(np.asarray(spread))])


def camera_samples(
    first: int, n: int, spp: int, index: int, seed: int, pixels: int | None = None
) -> tuple[Any, PixelSamples, list[Any]]:
    """Return samples of pixels, and what the camera is asked with for each.

    Parameters
    ----------
    first, n : int
        The first pixel's number, and how many pixels.
    spp, index : int
        Samples a pixel, and the number of the first of them.
    seed : int
        Seed: samples of other seeds are independent.
    pixels : int, optional
        Pixels of a half: numbers from there on are those of the other half, whose seed is the next one.

    Returns
    -------
    pixel : UInt32
        The pixel of each sample, (n spp,).
    samples : PixelSamples
        Where later numbers come from.
    numbers : list of Float
        In [0, 1): two for the place in the pixel, one for the wavelength, two for the lens, and one for
        the modes of birefringent stones.
    """
    import drjit as dr
    import mitsuba as mi

    # Opaque: sizes and samples in the kernel would make one for each
    lanes, of_a_pixel = dr.arange(mi.UInt32, n * spp), dr.opaque(mi.UInt32, spp)
    pixel = lanes // of_a_pixel
    number = lanes - pixel * of_a_pixel + dr.opaque(mi.UInt32, index)
    pixel += dr.opaque(mi.UInt32, first)
    seeds = dr.opaque(mi.UInt32, seed)
    if pixels is not None:
        is_second = pixel >= dr.opaque(mi.UInt32, pixels)
        pixel -= dr.select(is_second, dr.opaque(mi.UInt32, pixels), 0)
        seeds += dr.select(is_second, mi.UInt32(1), 0)
    samples = PixelSamples.of(pixel, number, seeds)
    x, y, nm, turn, *others = samples.next(7)
    # Wavelengths are drawn evenly from the first on: which of them is the first is drawn apart
    lanes_of_nm = len(mi.Spectrum())
    nm = dr.minimum((nm + dr.floor(turn * lanes_of_nm)) / lanes_of_nm, dr.one_minus_epsilon(mi.Float))
    return pixel, samples, [x, y, nm, *others]


def check_range(low: float, high: float) -> None:
    """Check a range of wavelengths [nm] of spectral bins.

    Raises
    ------
    InputError
        It is empty, or not within visible light.
    """
    from gemrender.errors import InputError

    if not FIRST_NM <= low < high <= LAST_NM:
        raise InputError(
            f"must be two increasing wavelengths from {FIRST_NM:g} to {LAST_NM:g} [nm]",
            key="range",
            value=f"{low:g},{high:g}",
        )

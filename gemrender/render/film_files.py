"""Films as files: H.264 in MP4, GIF and animated WebP, made of frames that are PNG files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from gemrender.errors import BackendError, InputError
from gemrender.render.picture_files import software
from gemrender.render.web_files import described, plain_text

__all__ = ["FPS_LIMIT", "check_film", "encode_film", "frame_times_ms"]

#: Most frames a second, by the film's ending. Players take a GIF's times below 0.02 s for 0.1 s.
FPS_LIMIT = {".mp4": 240, ".webp": 240, ".gif": 50}
#: Animated WebP without loss would be as large as its frames; at this quality its losses are not seen.
WEBP_OPTIONS: dict[str, Any] = {"quality": 90, "method": 4, "allow_mixed": True}
#: The last of a GIF's 256 colours stands for none: for what is transparent, or as in the frame before.
_NO_COLOUR = 255
#: Frames, and pixels of each, that a GIF's colours are chosen by.
_PALETTE_FRAMES, _PALETTE_PIXELS = 16, 1 << 14
#: Depth of a GIF's dither [of 255]: about what neighbours among its colours are apart.
_DITHER = 8.0
#: Share of a pixel from which on it is opaque in a GIF, which knows no shades of it.
_OPAQUE = 128


def check_film(path: Path, width: int, height: int, frames: int, fps: float) -> None:
    """Check what a film is asked to be, and that it can be written.

    Raises
    ------
    InputError
        A size, a number of frames or a rate that no film has.
    BackendError
        The library that writes it is not installed.
    """
    suffix = path.suffix.lower()
    most = FPS_LIMIT.get(suffix, FPS_LIMIT[".mp4"])
    if not 2 <= frames <= 100_000:
        raise InputError("must be from 2 to 100000", key="frames", value=frames)
    if not 1 <= fps <= most:
        of = "" if suffix == ".mp4" else f" in a {suffix} file"
        raise InputError(f"must be from 1 to {most} [frames a second]{of}", key="fps", value=fps)
    if suffix in (".gif", ".webp"):
        return
    if width % 2 or height % 2:
        raise InputError("must be even for a film", key="size", value=f"{width}x{height}")
    _require_av()


def encode_film(
    path: Path, files: Sequence[Path], fps: float, *, title: str = "", description: str = ""
) -> None:
    """Write frames as a film; GIF and WebP go round for ever.

    Parameters
    ----------
    path : Path
        The film; its ending tells its kind.
    files : sequence of Path
        Its frames in order, PNG files of one size. In MP4 alpha is left out; in GIF a pixel is opaque or not.
    fps : float
        Frames a second.
    title, description : str
        What the film is.

    Raises
    ------
    OSError
        It cannot be written.
    BackendError
        The library that writes it is not installed.
    """
    suffix = path.suffix.lower()
    title, description = plain_text(title), plain_text(description)
    if suffix == ".gif":
        _encode_gif(path, files, fps, title, description)
    elif suffix == ".webp":
        frames = _Frames(files, lambda image: image)
        about = described(title, description)
        times = frame_times_ms(fps, len(files))
        frames.save(path, "webp", save_all=True, duration=times, loop=0, **WEBP_OPTIONS, **about)
    else:
        _encode_mp4(path, files, fps, title, description)


def frame_times_ms(fps: float, frames: int, *, step_ms: int = 1) -> list[int]:
    """Return how long each frame is shown [ms], in whole steps, such that no frame is a step off its time.

    Parameters
    ----------
    fps : float
        Frames a second.
    frames : int
        Number of frames.
    step_ms : int
        What the file counts in [ms].
    """
    ends = np.rint(np.arange(frames + 1) * (1000.0 / fps / step_ms)).astype(int)
    return [int(t) * step_ms for t in np.diff(ends)]


class _Frames(Image.Image):  # type: ignore[misc]  # Pillow is untyped to us
    """Frames for Pillow to write, one in memory at a time: given a list, it would keep them all."""

    def __init__(self, files: Sequence[Path], prepared: Callable[[Image.Image], Image.Image]) -> None:
        super().__init__()
        self._files, self._prepared, self._at = files, prepared, -1
        self.seek(0)

    @property
    def n_frames(self) -> int:
        return len(self._files)

    def seek(self, frame: int) -> None:
        if not 0 <= frame < len(self._files):
            raise EOFError("no more frames")
        if frame == self._at:
            return
        with Image.open(self._files[frame]) as opened:
            opened.load()
            image = self._prepared(opened)
        self.im, self.palette, self._at = image.im, image.palette, frame
        self._mode, self._size = image.mode, image.size

    def tell(self) -> int:
        return self._at


# ---- GIF -----------------------------------------------------------------------------------------------


def _encode_gif(path: Path, files: Sequence[Path], fps: float, title: str, description: str) -> None:
    palette = _palette(files)
    with Image.open(files[0]) as first:
        transparent = "A" in first.getbands()
    about = "; ".join(text for text in (title, description, software()) if text)
    # What is as in the frame before is left out where nothing is transparent; else each frame clears the last
    options = {"disposal": 2} if transparent else {"disposal": 1, "optimize": True}
    frames = _Frames(files, lambda image: _indexed(image, palette))
    frames.save(
        path,
        "gif",
        save_all=True,
        duration=frame_times_ms(fps, len(files), step_ms=10),
        loop=0,
        transparency=_NO_COLOUR,
        comment=about.encode("ascii", "replace"),
        **options,
    )


def _palette(files: Sequence[Path]) -> Image.Image:
    """Return an image with the 255 colours of a film: one choice for all frames, or still parts flicker."""
    chosen = [files[k] for k in np.unique(np.linspace(0, len(files) - 1, _PALETTE_FRAMES).astype(int))]
    samples = []
    for file in chosen:
        with Image.open(file) as image:
            pixels = np.asarray(image.convert("RGBA")).reshape(-1, 4)
        pixels = pixels[:: max(len(pixels) // _PALETTE_PIXELS, 1)]
        samples.append(pixels[pixels[:, 3] >= _OPAQUE, :3])
    colours = np.concatenate([*samples, np.zeros((1, 3), np.uint8)])
    strip = Image.fromarray(colours[None])
    # Fire is a few pixels in a hundred: choices by the number of pixels have no colours for it
    return strip.quantize(_NO_COLOUR, method=Image.Quantize.MAXCOVERAGE, kmeans=1000)


def _indexed(image: Image.Image, palette: Image.Image) -> Image.Image:
    """Return a frame in the colours of a palette, dithered in a fixed pattern: what stands still stays so."""
    pixels = np.asarray(image.convert("RGBA"))
    height, width = pixels.shape[:2]
    pattern = np.tile(_bayer(), (height // 8 + 1, width // 8 + 1))[:height, :width, None]
    shifted = np.clip(pixels[..., :3] + _DITHER * pattern, 0, 255)
    indexed = Image.fromarray(np.rint(shifted).astype(np.uint8)).quantize(
        palette=palette, dither=Image.Dither.NONE
    )
    numbers = np.asarray(indexed).copy()
    numbers[pixels[..., 3] < _OPAQUE] = _NO_COLOUR
    out = Image.fromarray(numbers, "P")
    colours = list(indexed.getpalette() or [])
    out.putpalette(colours + [0] * (768 - len(colours)))
    return out


def _bayer() -> np.ndarray:
    """Return Bayer's 8 x 8 threshold pattern (1973), -0.5 to 0.5, of mean 0."""
    pattern = np.zeros((1, 1))
    for _ in range(3):
        pattern = np.block([[4 * pattern, 4 * pattern + 2], [4 * pattern + 3, 4 * pattern + 1]])
    return (pattern + 0.5) / 64 - 0.5


# ---- MP4 -----------------------------------------------------------------------------------------------


def _require_av() -> Any:
    try:
        import av
    except ImportError as error:
        cure = ".gif and .webp can; to cure it: pip install av"
        raise BackendError(f"an MP4 film cannot be written ({error}); {cure}") from error
    return av


def _encode_mp4(path: Path, files: Sequence[Path], fps: float, title: str, description: str) -> None:
    """Write frames as H.264 in MP4."""
    from fractions import Fraction

    av = _require_av()
    with av.open(str(path), "w", format="mp4") as container:
        about = {"title": title, "comment": description, "encoder": software()}
        container.metadata.update({key: text for key, text in about.items() if text})
        stream = container.add_stream(
            "libx264", rate=Fraction(fps).limit_denominator(1001), options={"crf": "16"}
        )
        stream.pix_fmt = "yuv420p"
        for file in files:
            with Image.open(file) as image:
                frame = av.VideoFrame.from_image(image.convert("RGB"))
            if not stream.codec_context.is_open:  # from then on PyAV refuses even the same size
                stream.width, stream.height = frame.width, frame.height
            container.mux(stream.encode(frame))
        container.mux(stream.encode())

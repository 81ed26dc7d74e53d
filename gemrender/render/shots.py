"""What is to be pictured, and how: options checked before any work, then rendered as a picture or a film.

The command `gemrender render` and `gemrender.render` are this.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.cuts import as_stone
from gemrender.errors import InputError
from gemrender.optics.metals import METALS
from gemrender.reading import did_you_mean
from gemrender.render import photoreal
from gemrender.render.curves import CURVES
from gemrender.render.develop import EV_LIMIT
from gemrender.render.formats import Background, output_kind
from gemrender.render.passes import check_range
from gemrender.render.picture import Picture
from gemrender.render.quality import Ends, Quality, ends_of
from gemrender.scene.moves import Move
from gemrender.scene.photoreal import MOST_PIXELS, Gem
from gemrender.scene.settings.setting import SETTINGS
from gemrender.scene.setup import GIRDLES, Setup, load_setup
from gemrender.stone import Stone

if TYPE_CHECKING:
    from gemrender.render.from_python import Stones

__all__ = ["MOST_BINS", "Shot", "held", "picture_size", "prepare"]

#: Most spectral bins: of 2 nm.
MOST_BINS = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """Stones in a set-up, with all that a picture and a film of them take.

    Attributes
    ----------
    gems : tuple of Gem
        The stones, from left to right.
    setup : Setup
        What stands around them.
    size : (int, int)
        Width and height [pixels].
    ends : Ends
        Where rendering ends.
    seed : int
        The seed.
    dispersion, birefringence, transparent, denoise : bool
        Whether the index depends on the wavelength, birefringent stones split light, the stones are kept by
        themselves, the denoiser is used.
    variant : str
        Spectral Mitsuba variant.
    turn_deg : float
        Turn of the stones about the vertical [deg].
    ev : float
        Correction of the exposure [stops].
    curve : str
        Tone curve.
    bins_nm : tuple of float or None
        Edges of spectral bins [nm].
    """

    gems: tuple[Gem, ...]
    setup: Setup
    size: tuple[int, int]
    ends: Ends
    seed: int
    dispersion: bool
    birefringence: bool
    transparent: bool
    denoise: bool
    variant: str
    turn_deg: float
    ev: float
    curve: str
    bins_nm: tuple[float, ...] | None

    def picture(
        self,
        *,
        progress: Callable[[float], None] | None = None,
        on_pass: Callable[[Picture, float], object] | None = None,
        pass_samples: int | None = None,
    ) -> Picture:
        """Render a picture; as for `gemrender.render`, and `pass_samples` as of `photoreal.render`."""
        look: dict[str, Any] = {"ev": self.ev, "curve": self.curve}
        preview = on_pass and (lambda picture, share: on_pass(replace(picture, **look), share))
        picture = photoreal.render(
            self.gems,
            self.setup,
            turn_deg=self.turn_deg,
            bins_nm=self.bins_nm,
            progress=progress,
            on_pass=preview,
            pass_samples=pass_samples,
            **self._options(),
        )
        if self.denoise:
            from gemrender.render.finish import denoised

            picture = replace(denoised(picture), noisy=picture)
        return replace(picture, **look)

    def film(
        self,
        path: Path,
        *,
        frames: int,
        fps: float,
        move: Move,
        progress: Callable[[int], Callable[[float], None]] = lambda frame: lambda share: None,
    ) -> Path:
        """Render a film; as for `gemrender.render_film`."""
        from gemrender.render.frames import render_film

        return render_film(
            path,
            self.gems,
            self.setup,
            frames=frames,
            fps=fps,
            move=move,
            turn_deg=self.turn_deg,
            ev=self.ev,
            curve=self.curve,
            denoise=self.denoise,
            progress=progress,
            **self._options(),
        )

    def check_film(self, path: Path, *, frames: int, fps: float, move: Move) -> None:
        """Check that a film can be made, before any work.

        Raises
        ------
        InputError
            An ending, a size, a number of frames or a rate that no film has, or a move or a turn that does
            not go with the rest.
        BackendError
            The library that writes it is not installed.
        """
        from gemrender.render.film_files import check_film

        output_kind(path, frames=frames, transparent=self.transparent, size=self.size)
        if self.bins_nm is not None:
            raise InputError("go into EXR pictures only", key="bins", value=len(self.bins_nm) - 1)
        if self.turn_deg and move.type == "turntable":
            raise InputError(
                "is for still pictures only, and to rock and tilt", key="turn", value=self.turn_deg
            )
        move.check_ground(self.setup.ground.type)
        check_film(path, *self.size, _whole("frames", frames), _number("fps", fps))

    def _options(self) -> dict[str, Any]:
        width, height = self.size
        return {
            "width": width,
            "height": height,
            **self.ends,
            "seed": self.seed,
            "dispersion": self.dispersion,
            "birefringence": self.birefringence,
            "transparent": self.transparent,
            "variant": self.variant,
        }


def prepare(
    stone: Stones,
    setup: str | os.PathLike[str] | Setup = "studio",
    *,
    material: str | float | None = None,
    carat: float | None = None,
    diameter: float | None = None,
    c_axis: str | Sequence[float] | None = None,
    setting: str | None = None,
    metal: str | None = None,
    girdle: str | None = None,
    analyser: float | None = None,
    polariser: float | None = None,
    size: int | str | Sequence[int] = 1024,
    aspect: str | Sequence[float] | None = None,
    quality: str | None = None,
    spp: int | None = None,
    noise: float | None = None,
    time: float | None = None,
    dispersion: bool = True,
    birefringence: bool = True,
    turn: float = 0.0,
    seed: int = 0,
    variant: str = photoreal.DEFAULT_VARIANT,
    background: str = "setup",
    denoise: bool = False,
    exposure: float = 0.0,
    curve: str | None = None,
    bins: int | None = None,
    range: str | Sequence[float] = (380.0, 760.0),  # noqa: A002 (the option's name)
) -> Shot:
    """Check options, load what they name, and return what can be rendered; as for `gemrender.render`."""
    if quality is not None:
        _word("quality", quality, tuple(Quality))
    _word("background", background, tuple(Background))
    if curve is not None:
        _word("curve", curve, tuple(CURVES))
    width_height = picture_size(size, aspect)
    ends = ends_of(
        None if quality is None else Quality(quality),
        spp=None if spp is None else _whole("spp", spp),
        noise=None if noise is None else _number("noise", noise),
        time_limit=None if time is None else _number("time", time),
    )
    photoreal.check_ends(**ends, seed=_whole("seed", seed))
    photoreal.check_variant(variant)
    gems = photoreal.make_gems(
        _stones(stone),
        material=material,
        carat=None if carat is None else _number("carat", carat),
        diameter_mm=None if diameter is None else _number("diameter", diameter),
        c_axis=c_axis,
    )
    around = setup if isinstance(setup, Setup) else load_setup(_path("setup", setup))
    around = held(around, setting=setting, metal=metal, girdle=girdle)
    around = filtered(around, analyser=analyser, polariser=polariser)
    around.filters.window_width(width_height[0])
    bins_nm = _bins(bins, range)
    if abs(_number("exposure", exposure) + around.exposure) > EV_LIMIT:
        allowed = f"must be from {-EV_LIMIT:g} to {EV_LIMIT:g} with the set-up's own, {around.exposure:g}"
        raise InputError(allowed, key="exposure", value=exposure)
    if denoise:
        photoreal.require_denoiser()
    return Shot(
        gems=tuple(gems),
        setup=around,
        size=width_height,
        ends=ends,
        seed=seed,
        dispersion=bool(dispersion),
        birefringence=bool(birefringence),
        transparent=background == Background.TRANSPARENT,
        denoise=bool(denoise),
        variant=variant,
        turn_deg=_number("turn", turn),
        ev=float(exposure),
        curve=curve or around.curve,
        bins_nm=bins_nm,
    )


def held(
    setup: Setup, *, setting: str | None = None, metal: str | None = None, girdle: str | None = None
) -> Setup:
    """Return a set-up with another setting, metal of it, or finish of the girdles, where they are given.

    Raises
    ------
    InputError
        Another word, a metal without a setting, or a setting that the set-up has no place for.
    """
    given = {"setting": (setting, SETTINGS), "metal": (metal, tuple(METALS)), "girdle": (girdle, GIRDLES)}
    for key, (value, allowed) in given.items():
        if value is not None:
            _word(key, value, allowed)
    if setting is metal is girdle is None:
        return setup
    made = replace(setup.setting, type=setting or setup.setting.type, metal=metal or setup.setting.metal)
    if metal and made.type == "none":
        raise InputError("is for a setting; give one too, as solitaire", key="metal", value=metal)
    if made.type != "none" and setup.pose == "table-down":
        raise InputError("must be none where stones lie table-down", key="setting", value=made.type)
    return replace(setup, setting=made, girdle=girdle or setup.girdle)


def filtered(setup: Setup, *, analyser: float | None = None, polariser: float | None = None) -> Setup:
    """Return a set-up with other polarising filters, where their angles are given [deg].

    Raises
    ------
    InputError
        An angle that is no number from -360 to 360.
    """
    given: dict[str, Any] = {
        key: x for key, x in (("analyser", analyser), ("polariser", polariser)) if x is not None
    }
    return replace(setup, filters=replace(setup.filters, **given)) if given else setup


def picture_size(size: int | str | Sequence[int], aspect: str | Sequence[float] | None) -> tuple[int, int]:
    """Return width and height of a picture [pixels].

    Parameters
    ----------
    size : int, str or two ints
        Its side, or width and height, as 1024, "1600x900" or (1600, 900). Of an aspect other than 1:1 a
        single side is the shorter one; the longer is even.
    aspect : str or two floats, optional
        Width to height, as "4:5" or (4, 5), beside a single side.

    Raises
    ------
    InputError
        Something else, or sides that no picture has.
    """
    allowed = f"must be a number of pixels or two, as 1024 or 1600x900, from 1 to {MOST_PIXELS}"
    sides = _numbers(size, "x")
    if len(sides) not in (1, 2) or not all(side % 1 == 0 and 1 <= side <= MOST_PIXELS for side in sides):
        raise InputError(allowed, key="size", value=size)
    width, height = int(sides[0]), int(sides[-1])
    if aspect is None:
        return width, height
    if len(sides) == 2:
        raise InputError("goes with one side; give it, or width and height", key="aspect", value=aspect)
    parts = _numbers(aspect, ":")
    if len(parts) != 2 or not all(0 < part < 1e6 for part in parts) or not 0.1 <= parts[0] / parts[1] <= 10:
        raise InputError(
            "must be width to height, as 4:5 or 9:16, from 1:10 to 10:1", key="aspect", value=aspect
        )
    longer = width if parts[0] == parts[1] else 2 * round(width * max(parts) / min(parts) / 2)
    if longer > MOST_PIXELS:
        told = f"must be such that the longer side is up to {MOST_PIXELS} [pixels], with aspect {aspect}"
        raise InputError(told, key="size", value=size)
    return (longer, width) if parts[0] > parts[1] else (width, longer)


def _stones(given: Stones) -> list[Stone]:
    one = isinstance(given, (Stone, str, os.PathLike))
    if not one and not isinstance(given, Iterable):
        raise InputError("must be a stone, a name or a file, or several", key="stone", value=given)
    named: list[Any] = [given] if one else list(given)  # type: ignore[arg-type]
    if not named:
        raise InputError("missing: one stone or more", key="stone")
    return [as_stone(each) for each in named]


def _bins(bins: int | None, among: str | Sequence[float]) -> tuple[float, ...] | None:
    """Return the edges of so many bins among two wavelengths [nm]."""
    ends = _numbers(among, ",")
    if len(ends) != 2:
        raise InputError("must be two wavelengths, as 380,760 [nm]", key="range", value=among)
    first, last = ends
    check_range(first, last)
    if bins is None:
        return None
    if not 1 <= _whole("bins", bins) <= MOST_BINS:
        raise InputError(f"must be from 1 to {MOST_BINS}", key="bins", value=bins)
    return tuple(first + (last - first) * k / bins for k in range(bins + 1))


def _numbers(value: Any, between: str) -> list[float]:
    """Return the finite numbers that a text, a number or a sequence holds; none where something else is."""
    parts = value.lower().split(between) if isinstance(value, str) else np.atleast_1d(value).tolist()
    try:
        numbers = [float(part) for part in parts if not isinstance(part, bool)]
    except (TypeError, ValueError):
        return []
    return numbers if len(numbers) == len(parts) and np.isfinite(numbers).all() else []


def _number(key: str, value: Any) -> float:
    real = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not real or not np.isfinite(value):
        raise InputError("must be a finite number", key=key, value=value)
    return float(value)


def _whole(key: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError("must be a whole number", key=key, value=value)
    return int(value)


def _word(key: str, value: Any, allowed: Sequence[str]) -> None:
    if value not in allowed:
        hint = did_you_mean(value, allowed) if isinstance(value, str) else ""
        raise InputError(f"must be one of {', '.join(allowed)}{hint}", key=key, value=value)


def _path(key: str, value: Any) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise InputError("must be a name or a file", key=key, value=value)
    return os.fspath(value)

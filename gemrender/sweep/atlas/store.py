"""The store of an atlas: an xarray data set in zarr, in a folder or wherever fsspec reaches.

A chunk's values are written first and its `status` last, each whole or not at all; so what `status` does not
tell is to do, however the work was stopped, and going on is a look at it.
"""

from __future__ import annotations

import itertools
import json
import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlparse

import numpy as np

import gemrender
from gemrender.cuts.families.family import Family
from gemrender.errors import BackendError, InputError
from gemrender.reading import reason
from gemrender.sweep.atlas.plan import STONES, VIEWS, AtlasPlan, AtlasVariable, part_shape

if TYPE_CHECKING:
    import xarray
    import zarr

__all__ = [
    "CHUNKS_AT_ONCE",
    "DONE",
    "FAILED",
    "NO_STONE",
    "ROUND_BRILLIANT",
    "TO_DO",
    "AtlasStore",
    "check_room",
    "is_atlas",
    "needed",
    "open_atlas",
]

#: What the attribute `cut` says of round brilliants; of other cuts it has the family's name.
ROUND_BRILLIANT = "round brilliant"
#: What `status` says of a stone: NaN stands in all its values but where it is done.
TO_DO, DONE, NO_STONE, FAILED = range(4)
_MEANINGS = "to_do done no_stone failed"
_CONVENTIONS = "CF-1.11"
#: The same bytes everywhere: one codec with its settings stated.
_LEVEL = 5
_RECORD = "plan"
#: So many chunks are read at a time: zarr has something in memory for each of them.
CHUNKS_AT_ONCE = 4096


def open_atlas(where: str) -> xarray.Dataset:
    """Open an atlas: a zarr store (a folder, or an address that fsspec knows), or a netCDF file.

    Returns
    -------
    xarray.Dataset
        Read when it is used; to be closed.

    Raises
    ------
    InputError
        There is none, or it is not gemrender's.
    BackendError
        xarray, zarr or h5netcdf is missing.
    """
    xarray = needed("xarray")
    is_file = _is_netcdf(where)
    needed("h5netcdf" if is_file else "zarr")
    try:
        if is_file:
            found = xarray.open_dataset(where, engine="h5netcdf")
        else:
            found = xarray.open_zarr(_place(where), consolidated=False, chunks=None)
    except Exception as error:
        raise InputError(f"is no atlas ({reason(error)})", source=where) from error
    if _RECORD not in found.attrs or "status" not in found:
        found.close()
        raise InputError("is a data set of something else than an atlas", source=where)
    return found


def is_atlas(where: str) -> bool:
    """Tell whether a name is that of a zarr store or a netCDF file, by what is there."""
    if _is_netcdf(where) or (_is_address(where) and "://" in where):
        return True
    return any((Path(where) / name).is_file() for name in ("zarr.json", ".zgroup"))


class AtlasStore:
    """The store of a plan: begun where there is none, gone on with where there is.

    Parameters
    ----------
    plan : AtlasPlan
        The plan.
    where : str
        A folder, or an address that fsspec knows, such as s3://bucket/atlas.zarr.

    Raises
    ------
    InputError
        There is something else, or an atlas of another plan; the disk is too small; or it cannot be written.
    BackendError
        zarr or fsspec is missing.
    """

    def __init__(self, plan: AtlasPlan, where: str) -> None:
        self.plan, self.where = plan, where
        self._arrays: dict[str, Any] = {}  # as opened: to look one up is as much work as to write a chunk
        try:
            self._group = self._opened()
            self._fill_in()
        except (OSError, ValueError, RuntimeError) as error:
            if isinstance(error, (InputError, BackendError)):
                raise
            raise InputError(f"cannot be written ({reason(error)})", source=where) from error

    def to_do(self) -> list[int]:
        """Return the chunks that are not done, in order; one that cannot be read is not."""
        plan = self.plan
        try:
            found = self.status()
        except Exception:  # a damaged chunk, told by whatever its codec raises
            return [k for k in range(plan.chunks) if not self._is_done(plan.place(k))]
        return [k for k in range(plan.chunks) if (found[plan.place(k)] == TO_DO).any()]

    def _is_done(self, place: tuple[slice, ...]) -> bool:
        try:
            return bool((np.asarray(self._arrays["status"][place]) != TO_DO).all())
        except Exception:
            return False

    def write(self, chunk: int, found: dict[str, np.ndarray]) -> None:
        """Write what was found of a chunk (`measure_chunk`), its status last.

        Raises
        ------
        InputError
            It cannot be written.
        """
        place = self.plan.place(chunk)
        try:
            for name in sorted(found, key=lambda name: name == "status"):
                on_design = name in self.plan.ranges
                self._arrays[name][place[:1] if on_design else place] = found[name]
        except (OSError, RuntimeError) as error:
            raise InputError(f"cannot be written ({reason(error)})", source=self.where) from error

    def status(self) -> np.ndarray:
        """Return what is known of every stone, of the plan's shape."""
        plan, array = self.plan, self._arrays["status"]
        out = np.empty(plan.shape, dtype=np.int8)
        numbers = part_shape(plan.chunks_along, CHUNKS_AT_ONCE)
        for first in itertools.product(*map(range, itertools.repeat(0), plan.chunks_along, numbers)):
            place = tuple(
                slice(k * size, (k + number) * size)
                for k, number, size in zip(first, numbers, plan.chunk_shape, strict=True)
            )
            out[place] = array[place]
        return out

    def tidy(self) -> None:
        """Remove what processes that were killed have left of files they had begun, once all is done."""
        if not _is_address(self.where):
            for path in Path(_path(self.where)).rglob("*.partial"):
                path.unlink(missing_ok=True)

    # ---- Making it ----

    def _opened(self) -> zarr.Group:
        zarr = needed("zarr")
        record = json.dumps(self.plan.record, sort_keys=True)
        try:
            group = zarr.open_group(_place(self.where), mode="r", zarr_format=3)
        except FileNotFoundError:
            check_room(self.plan, self.where)
            attributes = _attributes(self.plan) | {_RECORD: record}
            place = _place(self.where, writes=True)
            return zarr.create_group(place, zarr_format=3, attributes=attributes)
        there = group.attrs.get(_RECORD)
        if there is None:
            raise InputError("is a zarr store of something else; name another folder", source=self.where)
        if there != record:
            raise InputError(
                f"is the atlas of another plan{_difference(there, self.plan.record)}; name another folder, "
                "or remove it",
                source=self.where,
            )
        return zarr.open_group(_place(self.where, writes=True), mode="r+", zarr_format=3)

    def _fill_in(self) -> None:
        """Make the arrays that are not there yet: all of a new store, some of one whose making stopped."""
        plan = self.plan
        dims, views = list(plan.sizes), [VIEWS] if plan.tilts else []
        extra = (len(plan.tilts),) if plan.tilts else ()
        for key, values in plan.grid.items():
            self._coordinate(key, (key,), np.array(values, dtype=None if _words(values) else np.float64))
        if plan.tilts:
            for name, column in (("tilt", 0), ("tilt_azimuth", 1)):
                self._coordinate(name, (VIEWS,), np.array([tilt[column] for tilt in plan.tilts]))
        for key in plan.ranges:
            self._array(key, plan.shape[:1], plan.chunk_shape[:1], np.float64, [STONES], _parameter(key))
        for variable in plan.variables:
            self._array(
                variable.name, plan.shape + extra, plan.chunk_shape + extra, np.float32, dims + views,
                _described(variable, bool(plan.ranges), bool(plan.tilts), plan),
            )  # fmt: skip
        self._array("status", plan.shape, plan.chunk_shape, np.int8, dims, {
            "long_name": "what is known of the stone",
            "flag_values": list(range(4)),
            "flag_meanings": _MEANINGS,
        })  # fmt: skip

    def _coordinate(self, name: str, dims: tuple[str, ...], values: np.ndarray) -> None:
        array = self._array(name, values.shape, values.shape, values.dtype, list(dims), _parameter(name))
        array[...] = values.astype(str).astype(object) if values.dtype.kind == "U" else values

    def _array(
        self, name: str, shape: tuple[int, ...], chunks: tuple[int, ...], dtype: Any, dims: list[str],
        attributes: dict[str, Any],
    ) -> Any:  # fmt: skip
        if name in self._group:
            self._arrays[name] = self._group[name]
            return self._arrays[name]
        zarr = needed("zarr")
        kind = np.dtype(dtype)
        words = kind.kind == "U"
        filled = {} if words else {"fill_value": math.nan if kind.kind == "f" else 0}
        self._arrays[name] = self._group.create_array(
            name, shape=shape, chunks=chunks, dtype=str if words else kind, dimension_names=dims,
            compressors=zarr.codecs.ZstdCodec(level=_LEVEL), attributes=attributes, **filled,
        )  # fmt: skip
        return self._arrays[name]


def _words(values: tuple[Any, ...]) -> bool:
    return isinstance(values[0], str)


def _attributes(plan: AtlasPlan) -> dict[str, Any]:
    return {
        "Conventions": _CONVENTIONS,
        "title": plan.name,
        "source": f"gemrender {gemrender.__version__}, exact engine",
        "gemrender_version": gemrender.__version__,
        "cut": _cut_of(plan),
        "bound": plan.bound,
        "head": plan.head,
        "material": "diamond" if plan.stone.material is None else plan.stone.material,
        "measures": " ".join(f"{of.name}:{of.version}" for of in plan.measures),
    }


def _cut_of(plan: AtlasPlan) -> str:
    """Name the cut that is varied; "measured" for a stone that is made from no parameters."""
    if plan.stone.proportions is not None:
        return ROUND_BRILLIANT
    return plan.stone.cut.family() if isinstance(plan.stone.cut, Family) else "measured"


def _described(variable: AtlasVariable, design: bool, tilted: bool, plan: AtlasPlan) -> dict[str, Any]:
    of = variable.measure
    beside = [*(plan.ranges if design else ()), *(("tilt", "tilt_azimuth") if tilted else ())]
    more = {"coordinates": " ".join(beside)} if beside else {}
    unit = {"%": "percent", "deg": "degree", "": "1"}.get(of.unit, of.unit)
    if not variable.key:
        return {"long_name": f"error bound of {of.name}", "units": unit} | more
    return {
        "long_name": of.name if variable.key == "value" else f"{of.name}, {variable.key}",
        "units": unit,
        "measure_version": of.version,
        "definition": of.definition,
        "references": of.source,
        "ancillary_variables": f"{of.name.replace('-', '_')}_bound status",
    } | more


def _parameter(key: str) -> dict[str, Any]:
    is_angle = key.endswith("angle") or key in ("tilt", "tilt_azimuth")
    unit = (
        {} if key == "material" else {"units": "1" if key == "index" else "degree" if is_angle else "percent"}
    )
    return {"long_name": key.replace("_", " ")} | unit


def _difference(there: str, record: dict[str, Any]) -> str:
    """Say in which keys two plans differ."""
    try:
        other = json.loads(there)
        keys = [key for key in record if other.get(key) != record[key]]
    except (ValueError, AttributeError):
        return ""
    return f" (other {', '.join(keys)})" if keys else ""


# ---- Places --------------------------------------------------------------------------------------------


def _is_address(where: str) -> bool:
    """Tell an address of fsspec's from a path."""
    return "://" in where and not where.startswith("file://")


def _path(where: str) -> str:
    return unquote(urlparse(where).path) if where.startswith("file://") else where


def _is_netcdf(where: str) -> bool:
    return where.endswith(".nc") and not Path(where).is_dir()


def _place(where: str, *, writes: bool = False) -> Any:
    """Return zarr's store for a path, whose files are replaced whole, or for an address of fsspec's."""
    if not _is_address(where):
        path = Path(_path(where))
        if path.exists() and not path.is_dir():
            raise InputError("is a file; an atlas is a folder", source=where)
        if path.is_dir() and not (path / "zarr.json").exists() and any(path.iterdir()):
            raise InputError("is a folder of something else; name another one", source=where)
        needed("zarr")
        from zarr.storage import LocalStore

        return LocalStore(path, read_only=not writes)
    needed("zarr")
    needed("fsspec")
    from zarr.storage import FsspecStore

    try:
        return FsspecStore.from_url(where, read_only=not writes)
    except (ValueError, ImportError, OSError) as error:  # an address or a package that is not known
        raise InputError(f"cannot be opened ({reason(error)})", source=where) from error


def check_room(plan: AtlasPlan, where: str) -> None:
    """Refuse a plan that is larger than what is free on the disk of its store.

    Raises
    ------
    InputError
        It is.
    """
    if _is_address(where):
        return
    folder = Path(_path(where)).resolve()
    while not folder.exists():
        folder = folder.parent
    free = shutil.disk_usage(folder).free
    if plan.bytes > free:
        raise InputError(
            f"takes up to {plan.bytes / 1e9:.3g} GB; only {free / 1e9:.3g} GB are free there", source=where
        )


def needed(name: str) -> Any:
    """Import a package of the extra `atlas`.

    Raises
    ------
    BackendError
        It cannot be imported.
    """
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BackendError(
            f"atlases need {name} ({error}); to cure it: pip install 'gemrender[atlas]'"
        ) from error

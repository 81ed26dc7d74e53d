"""An atlas as one netCDF file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.errors import InputError
from gemrender.sweep.atlas.plan import part_shape
from gemrender.sweep.atlas.store import TO_DO, needed, open_atlas
from gemrender.writing import write_whole

if TYPE_CHECKING:
    import xarray

__all__ = ["export_atlas"]

#: Most numbers that are copied, and kept in one compressed piece of the file, at a time.
_BLOCK, _PIECE = 4_000_000, 65_536
_LEVEL = 6


def export_atlas(
    where: str, path: str | Path, *, progress: Callable[[float], None] | None = None
) -> tuple[Path, int]:
    """Write an atlas as a netCDF 4 file, whole or not at all; a part of it is in memory at a time.

    Parameters
    ----------
    where : str
        The store.
    path : str or Path
        The file, in a folder that is there.
    progress : callable, optional
        Called with the share done, 0 to 1.

    Returns
    -------
    (Path, int)
        The file, and how many stones are still to do in it, whose values are NaN.

    Raises
    ------
    InputError
        No atlas, or a file that cannot be written.
    BackendError
        xarray, zarr or h5netcdf is missing.
    """
    h5netcdf = needed("h5netcdf")
    file = Path(path)
    if file.suffix != ".nc":
        raise InputError("must end in .nc", key="--out", value=str(path))
    if not file.parent.is_dir():
        raise InputError("no such folder", source=str(file.parent))
    with open_atlas(where) as atlas:

        def write(made: Path) -> None:
            with h5netcdf.File(made, "w") as out:
                _copy(atlas, out, progress)

        written = write_whole(file.parent, {file.name: write})[0]
        return written, int((atlas["status"].values == TO_DO).sum())


def _copy(atlas: xarray.Dataset, out: Any, progress: Callable[[float], None] | None) -> None:
    out.dimensions = {str(name): size for name, size in atlas.sizes.items()}
    for key, value in atlas.attrs.items():
        out.attrs[key] = value
    names = [*sorted(map(str, atlas.coords)), *sorted(map(str, atlas.data_vars))]
    for done, name in enumerate(names):
        source = atlas[name]
        dtype = source.dtype
        if dtype.kind not in "fiu":  # words
            import h5py

            made = out.create_variable(name, source.dims, h5py.string_dtype())
            made[...] = np.array([str(word) for word in source.values], dtype=object)
        else:
            options: dict[str, Any] = {"fillvalue": dtype.type(np.nan)} if dtype.kind == "f" else {}
            if source.ndim and source.size:
                options |= {
                    "chunks": part_shape(source.shape, _PIECE), "compression": "gzip",
                    "compression_opts": _LEVEL, "shuffle": True,
                }  # fmt: skip
            made = out.create_variable(name, source.dims, dtype, **options)
            for part in _blocks(source.shape):
                made[part] = source[part].values
        for key, value in {**source.attrs, **_coordinates(source)}.items():
            made.attrs[key] = np.array(value, dtype=np.int8) if key == "flag_values" else value
        if progress is not None:
            progress((done + 1) / len(names))


def _coordinates(source: xarray.DataArray) -> dict[str, str]:
    """Return the attribute that names coordinates which are no dimensions, as xarray has taken it away."""
    named = source.encoding.get("coordinates")
    return {"coordinates": named} if named else {}


def _blocks(shape: tuple[int, ...]) -> Iterator[tuple[slice, ...]]:
    """Yield slices that cover a shape, few enough numbers in each."""
    parts = part_shape(shape, _BLOCK)
    for first in product(*(range(0, size, part) for size, part in zip(shape, parts, strict=True))):
        yield tuple(slice(k, k + part) for k, part in zip(first, parts, strict=True))

"""HDF5 files written through Python's own file, so that a disk that fails can't crash the library.

HDF5 2.0 keeps what it could not write and crashes on it later, at the latest when the process ends. Here it never
learns of a failure: the first one is kept, nothing more is written, and it is raised once HDF5 has closed the file.
Variables with dimension scales, a unit and a meaning make such a file valid NetCDF-4.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import h5py

NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable.{:10d}"  # NetCDF-4's name of such a scale


class HeldBack(io.FileIO):
    """A file that keeps its first failure to itself; `failure` is None where there was none."""

    failure: OSError | None = None

    def write(self, data) -> int:
        """All of it; nothing after a failure."""
        view = memoryview(data).cast("B")
        size = len(view)
        try:
            while view and self.failure is None:
                view = view[self.put(view) :]
        except OSError as error:
            self.failure = error
        return size

    def put(self, data: memoryview) -> int:
        """As many bytes as the system takes at once."""
        return super().write(data) or 0

    def truncate(self, size: int | None = None) -> int:
        try:
            if self.failure is None:
                return super().truncate(size)
        except OSError as error:
            self.failure = error
        return size or 0


@contextmanager
def hdf5_to_write(path: Path, mode: str = "w", **options: Any) -> "Iterator[h5py.File]":
    """An HDF5 file, new ("w") or to be changed ("r+"), closed at the end; options are those of h5py.File.

    Errors
    ------
    OSError: the disk failed, said at the end.
    """
    import h5py

    with HeldBack(path, {"w": "w+", "r+": "r+"}[mode]) as raw:
        try:
            with h5py.File(raw, mode, **options) as file:
                yield file
        except Exception:
            if raw.failure is None:
                raise
        if raw.failure is not None:  # also of what HDF5 found strange in a file that lacks what it has written
            raise raw.failure


def dimension(file: "h5py.File", name: str, size: int) -> None:
    """Add a dimension that has no coordinates."""
    file.create_dataset(name, shape=(size,), dtype=">f4").make_scale(NO_VARIABLE.format(size))


def variable(
    file: "h5py.File", name: str, values: Any, dimensions: tuple[str, ...], unit: str, long_name: str
) -> None:
    """Add numbers, or words (dtype object), along dimensions that the file has; along its own name: a coordinate."""
    values = np.asarray(values)
    if values.dtype == object:
        import h5py

        file.create_dataset(name, data=values, dtype=h5py.string_dtype())
    else:
        file.create_dataset(name, data=values)
    label(file, name, dimensions, unit, long_name)


def label(file: "h5py.File", name: str, dimensions: tuple[str, ...], unit: str, long_name: str) -> None:
    """Say of a variable of the file along which dimensions it is, its unit and its meaning."""
    data = file[name]
    data.attrs["units"], data.attrs["long_name"] = unit, long_name
    if dimensions == (name,):
        data.make_scale(name)
        return
    for axis, each in enumerate(dimensions):
        data.dims[axis].attach_scale(file[each])

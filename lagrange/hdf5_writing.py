"""HDF5 files written through Python's own file, so that a disk that fails can't crash the library.

HDF5 2.0 keeps what it could not write and crashes on it later, at the latest when the process ends. Here it never
learns of a failure: the first one is kept, nothing more is written, and it is raised once HDF5 has closed the file.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import h5py


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

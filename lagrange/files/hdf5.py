"""HDF5 files: written through Python's own file, read guarded whatever they hold.

HDF5 2.0 keeps what it could not write and crashes on it later, at the latest when the process ends. Here it never
learns of a failure: the first one is kept, nothing more is written, and it is raised once HDF5 has closed the file.
Variables with dimension scales, a unit and a meaning make such a file valid NetCDF-4.

A file that is read may be damaged or foreign. `read_numbers` takes nothing but plain arrays of the file at hand: no
links into other files, no filters that the library would load code for, no chunks or shapes far beyond the data.
"""

import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.errors import UsageError
from lagrange.files.input import LARGEST_FILE, digest

if TYPE_CHECKING:
    import h5py

SIGNATURE = b"\x89HDF\r\n\x1a\n"  # an HDF5 file's first bytes
CHECKSUM = "checksum"  # attribute: twice a number of samples and the CRC-32 of the variable up to there
SCENE_CHECKSUM = "scene_checksum"  # attribute of the file: CRC-32 of the scene's text
FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32"}  # by HDF5's numbers
LARGEST_CHUNK = 64 * 2**20  # bytes
MOST_COMPRESSION = 1100  # deflate can't do better than 1032 to 1
SCENE_FILE = "scene_file_{}"  # variable: bytes of a file that the scene names
MOST_SCENE_FILES = 200
WORDS = {"f": "floating-point numbers", "i": "whole numbers", "u": "bytes"}  # by numpy's kinds


class Damaged(UsageError):
    """What a file holds can't be used; the text says what is wrong, without the file's name."""


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


def variable(file: "h5py.File", name: str, values: Any, dimensions: tuple[str, ...], unit: str, long_name: str) -> None:
    """Add numbers, or words (dtype object), along dimensions that the file has; along its own name: a coordinate."""
    import h5py

    values = np.asarray(values)
    file.create_dataset(name, data=values, dtype=h5py.string_dtype() if values.dtype == object else None)
    label(file, name, dimensions, unit, long_name)


def new_block(group, name: str, shape: tuple[int, ...], dtype: str, fill=None) -> "h5py.Dataset":
    """A variable whose numbers stand in one piece of the file, allotted at once."""
    import h5py

    room = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    room.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape=shape, dtype=dtype, fillvalue=fill, dcpl=room)


def label(file: "h5py.File", name: str, dimensions: tuple[str, ...], unit: str, long_name: str) -> None:
    """Say of a variable of the file along which dimensions it is, its unit and its meaning."""
    data = file[name]
    data.attrs["units"], data.attrs["long_name"] = unit, long_name
    if dimensions == (name,):
        data.make_scale(name)
        return
    for axis, each in enumerate(dimensions):
        data.dims[axis].attach_scale(file[each])


def read_numbers(file, name: str, count: int) -> np.ndarray:
    """The first `count` samples of a variable of an open HDF5 file, its checksum verified where it has one.

    Damaged: no such variable, not an array of floating-point numbers in this file, too short, chunks or shapes out of
    proportion, an unknown filter, another checksum than stored.
    """
    data = check_array(file, name, count)
    values, record = data[:count].astype(float), data.attrs.get(CHECKSUM)
    if record is not None:
        pairs = np.ravel(record).tolist()
        known = dict(zip(pairs[0::2], pairs[1::2], strict=False))
        if count not in known:
            raise Damaged(f"{name} has no checksum of its {count} samples")
        if known[count] != checksum(values):
            raise Damaged(f"{name} is not what was written: its checksum differs")
    return values


def has(file, name: str) -> bool:
    """Whether an open HDF5 file has an entry of a name, without following it where it is a link."""
    return file.get(name, getlink=True) is not None


def check_array(file, name: str, count: int | None, kinds: str = "f", dimensions: tuple[int, ...] = (1, 2)):
    """The variable, after what is refused before anything is read; `count` None: a group, looked into no further.

    Damaged: see `read_numbers`.
    """
    link = file.get(name, getlink=True)
    if link is None:
        raise Damaged(f"{name} is missing")
    if type(link).__name__ != "HardLink":
        raise Damaged(f"{name} is a link to another place, which is not followed")
    data = file[name]
    if count is None:
        if type(data).__name__ != "Group":
            raise Damaged(f"{name} is not a group")
        return data
    if type(data).__name__ != "Dataset" or data.dtype.kind not in kinds or data.dtype.itemsize > 8:
        raise Damaged(f"{name} is not an array of {WORDS.get(kinds, 'text')}")
    if data.is_virtual or data.external:
        raise Damaged(f"{name} lies in another file, which is not followed")
    if data.ndim not in dimensions or data.shape[0] < count:
        raise Damaged(f"{name} has shape {data.shape} but {count} samples are committed; the file is truncated")
    plan = data.id.get_create_plist()
    filters = [plan.get_filter(i)[0] for i in range(plan.get_nfilters())]
    if unknown := [number for number in filters if number not in FILTERS]:
        raise Damaged(f"{name} is packed by an unknown filter (HDF5's number {unknown[0]})")
    if data.chunks is not None and prod(data.chunks) * data.dtype.itemsize > LARGEST_CHUNK:
        raise Damaged(f"{name} has chunks of {data.chunks}, more than {LARGEST_CHUNK / 2**20:.0f} MiB")
    wanted = count * prod(data.shape[1:]) * data.dtype.itemsize
    if data.id.get_storage_size() * (MOST_COMPRESSION if filters else 1) < wanted:
        raise Damaged(f"{name} has shape {data.shape}, but the file holds only part of it")
    return data


def read_scene_text(file) -> str:
    """The attribute `scene` of an open HDF5 file. Damaged: another checksum than stored. KeyError: there is none."""
    text = file.attrs["scene"]
    text = text.decode("utf-8", errors="replace") if isinstance(text, bytes) else str(text)
    if SCENE_CHECKSUM in file.attrs and int(file.attrs[SCENE_CHECKSUM]) != text_checksum(text):
        raise Damaged("the attribute scene is not what was written: its checksum differs")
    return text


def read_scene_files(file) -> dict[str, str]:
    """Texts of the files that an open HDF5 file's scene names, by their digests. Damaged: too large, or no text."""
    found = {}
    for number in range(MOST_SCENE_FILES):
        name = SCENE_FILE.format(number)
        if not has(file, name):
            break
        data = check_array(file, name, 0, kinds="u", dimensions=(1,))
        if data.nbytes > LARGEST_FILE or data.dtype.itemsize > 1:
            raise Damaged(f"{name} holds more than {LARGEST_FILE} bytes, or other numbers")
        check_array(file, name, len(data), kinds="u", dimensions=(1,))
        try:
            text = data[:].tobytes().decode()
        except UnicodeDecodeError:
            raise Damaged(f"{name} is no UTF-8 text") from None
        found[digest(text)] = text
    return found


def text_checksum(text: str) -> int:
    """CRC-32 of a text as UTF-8."""
    return zlib.crc32(text.encode("utf-8", errors="replace"))


def checksum(values: np.ndarray, before: int = 0) -> int:
    """CRC-32 of values as little-endian doubles, going on from that of the values before them."""
    return zlib.crc32(np.ascontiguousarray(values, dtype="<f8").data, before)

"""Records in files of other programs: WAV, MATLAB, NumPy; UFF58, TDMS and Parquet by optional packages."""

import io
import re
import warnings
import zipfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lagrange.files.hdf5 import SIGNATURE, Damaged, check_array, refusal_in_child
from lagrange.files.input import read_plain
from residual.measured.text import Channels, text_channels

LARGEST = 1 << 30  # bytes of a file, and of what is packed in it
MOST_CHANNELS = 256
DEEPEST = 6  # structs in structs
SECONDS, MEMORY = 20.0, 2 << 30  # that reading an HDF5 file may take
RATE_NAMES = ("rate", "fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
UNIVERSAL = re.compile(rb"\s*-1\s*\n\s*58b?\s")


def read_channels(path: Path) -> Channels:
    """Channels of a file, whose format follows from its first bytes rather than its name.

    Errors
    ------
    OSError: it can't be read. ValueError, a sentence without the file's name: no record, damaged, a package missing.
    """
    data = read_plain(path, LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"larger than {LARGEST >> 30} GiB; cut a part of it")
    if not data.strip():
        raise ValueError("it is empty")
    if SIGNATURE in (data[:8], data[512:520]):
        return _hdf5(path)
    for start, kind, read in KINDS:
        if data.startswith(start):
            if read is _matlab:
                return _tried_in_child(lambda: _guarded("a MATLAB file", _matlab, data, path))
            return _guarded(kind, read, data, path)
    if UNIVERSAL.match(data):
        return _guarded("a universal file (UFF58)", _universal, data, path)
    if path.suffix.lower() == ".mat":  # version 4 has no mark of its own
        return _tried_in_child(lambda: _guarded("a MATLAB file", _matlab, data, path))
    return text_channels(data)


def _guarded(kind: str, read: Callable[[bytes, Path], Channels], data: bytes, path: Path) -> Channels:
    """Read by a library, whose every failure on a damaged file becomes a sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what a library finds odd but reads
            found = read(data, path)
    except (MemoryError, _Refused):
        raise
    except Exception as error:  # of any kind: libraries raise what happens to go wrong
        said = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        raise ValueError(f"begins as {kind}, but can't be read ({said}); is it damaged?") from None
    if not found.values:
        raise ValueError(f"{kind} without a signal: no row or column of real numbers is in it")
    return found


def _tried_in_child(read: Callable[[], Channels]) -> Channels:
    """Read by a library that may crash or never end on a damaged file: tried in a child process first."""
    refusal = refusal_in_child(read, "it", SECONDS, MEMORY)
    if refusal is not None:
        raise ValueError(refusal.replace("the HDF5 library", "the library that reads such files"))
    return read()


class _Refused(ValueError):
    """A sentence of our own."""


def _package(name: str, kind: str, install: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise _Refused(f"{kind}; reading it takes a further package: python -m pip install {install}") from None


def _wav(data: bytes, path: Path) -> Channels:
    """All channels of any width; whole numbers become shares of full scale."""
    from scipy.io import wavfile

    rate, values = wavfile.read(io.BytesIO(data))
    values = values.reshape(len(values), -1)
    found = values.astype(float)
    notes = []
    if values.dtype.kind == "u":
        found = found / 128.0 - 1.0  # 8 bits have no sign
    elif values.dtype.kind == "i":
        found /= float(1 << (8 * values.dtype.itemsize - 1))
    if values.dtype.kind in "iu":
        notes.append("whole numbers were taken as shares of full scale")
    return Channels(values={f"channel {k}": found[:, k - 1] for k in range(1, found.shape[1] + 1)}, rate=float(rate),
                    notes=notes)  # fmt: skip


def _matlab(data: bytes, path: Path) -> Channels:
    """Variables and fields of structs, by dotted names."""
    from scipy.io import loadmat

    file = loadmat(io.BytesIO(data), squeeze_me=True, struct_as_record=False)
    return _collected({name: value for name, value in file.items() if not name.startswith("__")})


def _numpy(data: bytes, path: Path) -> Channels:
    return _collected({"x": np.load(io.BytesIO(data), allow_pickle=False)})


def _archive(data: bytes, path: Path) -> Channels:
    """The arrays of an NPZ file."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        if not any(entry.filename.endswith(".npy") for entry in entries):
            raise _Refused("an Excel workbook or an archive; save the sheet as CSV")
        if sum(entry.file_size for entry in entries) > LARGEST:
            raise _Refused(f"unpacks to more than {LARGEST >> 30} GiB")
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        return _collected({name: file[name] for name in file.files})


def _collected(tree: dict[str, Any]) -> Channels:
    """Signals and the rate among values of any kind, nested as structs are."""
    found = Channels(values={})
    _collect(tree, "", found, 0)
    longest = max((len(values) for values in found.values.values()), default=0)
    found.values = {name: values for name, values in found.values.items() if len(values) == longest}
    return found


def _collect(value: Any, name: str, found: Channels, depth: int) -> None:
    if depth > DEEPEST or len(found.values) >= MOST_CHANNELS:
        return
    if isinstance(value, dict) or hasattr(value, "_fieldnames"):
        items = value.items() if isinstance(value, dict) else ((key, getattr(value, key)) for key in value._fieldnames)
        for key, inner in items:
            _collect(inner, f"{name}.{key}" if name else key, found, depth + 1)
        return
    if isinstance(value, str):
        if re.fullmatch(r"(?:.*[._])?units?", name, re.IGNORECASE):
            found.units[""] = value
        return
    array = np.asarray(value)
    if array.dtype == object:
        for k, inner in enumerate(array.ravel()[:MOST_CHANNELS], 1):
            _collect(inner, f"{name}[{k}]", found, depth + 1)
        return
    if array.dtype.kind not in "fiu" or array.size == 0:
        return
    if array.size == 1:
        last = re.sub(r"[^a-z]", "", name.rpartition(".")[2].lower()).removesuffix("hz")
        if last in RATE_NAMES and float(array.ravel()[0]) > 0.0:
            found.rate = float(array.ravel()[0])
        return
    array = array.squeeze()
    if array.ndim == 1:
        found.values[name] = array.astype(float)
    elif array.ndim == 2 and min(array.shape) <= MOST_CHANNELS:
        for k, values in enumerate(array if array.shape[0] < array.shape[1] else array.T, 1):
            found.values[f"{name}[{k}]"] = values.astype(float)


def _hdf5(path: Path) -> Channels:
    """Numbers of a MATLAB 7.3 file or another HDF5 file, first read in a child process that may crash."""
    import h5py

    def read() -> Channels:
        try:
            with h5py.File(path, "r") as file:
                tree = _hdf5_tree(file, 0)
        except (OSError, RuntimeError, KeyError, TypeError) as error:
            raise Damaged(f"begins as HDF5 (MATLAB 7.3), but can't be read ({str(error)[:200]})") from None
        found = _collected(tree)
        if not found.values:
            raise Damaged("an HDF5 file (MATLAB 7.3) without a signal: no row or column of real numbers is in it")
        return found

    return _tried_in_child(read)


def _hdf5_tree(group: Any, depth: int) -> dict[str, Any]:
    """Numbers and groups; texts, cells and links are left out."""
    tree: dict[str, Any] = {}
    for name in list(group)[:MOST_CHANNELS]:
        if name.startswith("#") or type(group.get(name, getlink=True)).__name__ != "HardLink":
            continue
        item = group[name]
        if type(item).__name__ == "Group" and depth < DEEPEST:
            tree[name] = _hdf5_tree(item, depth + 1)
        elif type(item).__name__ == "Dataset" and item.dtype.kind in "fiu" and item.ndim in (1, 2):
            if item.attrs.get("MATLAB_class", b"") in (b"char", "char") or item.shape[0] == 0:
                continue
            data = check_array(group, name, item.shape[0], kinds="fiu")
            if data.size * data.dtype.itemsize > LARGEST:
                raise Damaged(f"{name} holds more than {LARGEST >> 30} GiB")
            tree[name] = data[()]
    return tree


def _universal(data: bytes, path: Path) -> Channels:
    pyuff = _package("pyuff", "a universal file (UFF58)", "pyuff")
    sets = pyuff.UFF(str(path)).read_sets()
    sets = [each for each in (sets if isinstance(sets, list) else [sets]) if each.get("type") == 58]
    found = _collected({f"{k} {each.get('id1', '')}".strip(): np.real(each["data"]) for k, each in enumerate(sets, 1)})
    steps = [each["abscissa_inc"] for each in sets if each.get("abscissa_inc")]
    found.rate = 1.0 / steps[0] if steps else None
    return found


def _tdms(data: bytes, path: Path) -> Channels:
    nptdms = _package("nptdms", "a TDMS file", "nptdms")
    file = nptdms.TdmsFile.read(path)
    channels = [channel for group in file.groups() for channel in group.channels()]
    found = _collected({f"{channel.group_name}.{channel.name}": channel[:] for channel in channels})
    found.units = {f"{c.group_name}.{c.name}": c.properties["unit_string"] for c in channels
                   if "unit_string" in c.properties}  # fmt: skip
    steps = [c.properties["wf_increment"] for c in channels if c.properties.get("wf_increment")]
    found.rate = 1.0 / steps[0] if steps else None
    return found


def _parquet(data: bytes, path: Path) -> Channels:
    parquet = _package("pyarrow.parquet", "a Parquet file", "pyarrow")
    table = parquet.read_table(io.BytesIO(data))
    return _collected({name: np.asarray(table[name]) for name in table.column_names})


KINDS: tuple[tuple[bytes, str, Callable[[bytes, Path], Channels]], ...] = (
    (b"RIFF", "a WAV file", _wav),
    (b"RIFX", "a WAV file", _wav),
    (b"RF64", "a WAV file", _wav),
    (b"MATLAB", "a MATLAB file", _matlab),
    (b"\x93NUMPY", "an NPY file", _numpy),
    (b"PK\x03\x04", "an NPZ file", _archive),
    (b"TDSm", "a TDMS file", _tdms),
    (b"PAR1", "a Parquet file", _parquet),
)

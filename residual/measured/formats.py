"""Records in files of other programs: WAV, MATLAB, NumPy; UFF58, TDMS and Parquet by optional packages."""

import io
import re
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lagrange.errors import UsageError
from lagrange.files.hdf5 import SIGNATURE, check_array
from lagrange.files.input import read_plain
from lagrange.files.tables import MOST_NUMBERS, TextTable, decoded

LARGEST = 1 << 29  # bytes of a file, and of what is packed in it
MOST_CHANNELS = 256
DEEPEST = 6  # structs in structs
SLOWEST = 100.0  # Hz, of samples: beside a faster rate a slower one is that of the shaft
RATE_NAMES = ("rate", "fs", "sr", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
STEP_NAMES = ("increment", "dt", "timestep", "timeincrement", "sampleinterval", "samplinginterval", "wfincrement")
TIME_RESPONSE, TIME_AXIS = 1, 17  # UFF58's numbers of a function and of its abscissa
_NUMBER = r"(?P<number>\d{1,12}(?:[.,]\d{1,12}){0,4})"
RATES = tuple(  # "Sampling rate: 25.6 kHz", "Abtastrate;25600 Hz"; "Sampling frequency (Hz),25600"; "fs = 25600"
    re.compile(form, re.IGNORECASE)
    for form in (
        rf"(?:rate|freq\w{{0,20}}|fs|sampl\w{{0,20}})\b[^\d\n]{{0,30}}?{_NUMBER}\s{{0,9}}(?P<kilo>k?)Hz",
        rf"(?:rate|freq\w{{0,20}}|fs)\s{{0,9}}[\[(]?(?P<kilo>k?)Hz[\])]?\W{{0,10}}{_NUMBER}\W{{0,10}}$",
        rf"\b(?P<kilo>)(?:fs|sampl\w{{0,20}}[\s_]{{0,9}}(?:rate|freq\w{{0,20}})|abtastrate)\W{{1,10}}{_NUMBER}\W{{0,10}}$",
    )
)
GROUPS = re.compile(r"[1-9]\d{0,2}(?:[.,]\d{3})+")  # of thousands
OF_SAMPLES = re.compile(r"(?i)fs\b|sampl|abtast|rate")  # said of a rate, not of any frequency
OTHER = re.compile(r"(?i)(?:shaft|rotation\w{0,9}|dreh|mains|filter|(?:cut)?-?off|resonan\w{0,9})[\s_]{0,9}$")  # rate
LONGEST_STATEMENT = 300  # characters of a line that states a rate


@dataclass
class Channels:
    """Signals by name as they are stored, their units as written, the rates, Hz, that the file states for each."""

    values: dict[str, np.ndarray] = field(default_factory=dict)  # (n_times,) each, of any length, real numbers
    units: dict[str, str] = field(default_factory=dict)
    rates: dict[str, frozenset[float]] = field(default_factory=dict)  # more than one: it contradicts itself
    line: int | None = None  # of a text: number of the line of the first sample
    notes: list[str] = field(default_factory=list)

    @property
    def longest(self) -> list[str]:
        most = max(map(len, self.values.values()), default=0)
        return [name for name, values in self.values.items() if len(values) == most]

    def collect(self, value: Any, name: str = "", rates: frozenset[float] = frozenset(), unit: str = "", depth=0):
        """Add the signals of a value, nested as structs are; rates, Hz, and unit are stated beside it or about it."""
        if depth > DEEPEST or len(self.values) >= MOST_CHANNELS:
            return self
        if isinstance(value, dict) or hasattr(value, "_fieldnames"):
            items = value if isinstance(value, dict) else {key: getattr(value, key) for key in value._fieldnames}
            stated = [rate for key, inner in items.items() if (rate := _rate_of(key, inner)) > 0.0]
            own = frozenset(rate for rate in stated if rate >= SLOWEST or max(stated) < SLOWEST)
            title = next((x for key, x in items.items() if key.lower() == "name" and isinstance(x, str) and x), None)
            name = name if title is None else f"{name} {title}".strip()
            said = (x for key, x in items.items() if re.fullmatch(r"(.*_)?units?", key, re.IGNORECASE))
            words = {x for x in said if isinstance(x, str)}
            unit = unit if not words else words.pop() if len(words) == 1 else ""  # of several none
            for key, inner in items.items():
                self.collect(inner, f"{name}.{key}" if name else key, own or rates, unit, depth + 1)
            return self
        array = np.asarray(value)
        if array.dtype == object:
            for k, inner in enumerate(array.ravel()[:MOST_CHANNELS], 1):
                self.collect(inner, f"{name}[{k}]", rates, unit, depth + 1)
        elif array.dtype.kind in "fiu" and array.size > 1:
            array = array.squeeze()
            columns: Any = [] if array.ndim != 2 else array if array.shape[0] < array.shape[1] else array.T
            signals = {name: array} if array.ndim == 1 else {f"{name}[{k}]": x for k, x in enumerate(columns, 1)}
            if len(signals) <= MOST_CHANNELS:
                self.values |= signals
                self.rates |= dict.fromkeys(signals, rates)
                self.units |= dict.fromkeys(signals, unit)
        return self


def _rate_of(key, value):
    """The rate, Hz, that a number of this name states, itself or by the step between samples, s; 0: none."""
    word = re.sub(r"[^a-z]", "", key.lower()).removesuffix("hz")
    if word not in RATE_NAMES + STEP_NAMES or isinstance(value, str | dict):
        return 0.0
    array = np.asarray(value)
    number = float(array.ravel()[0]) if array.dtype.kind in "fiu" and array.size == 1 else 0.0
    return number if word in RATE_NAMES or number <= 0.0 else 1.0 / number


def read_channels(path: Path) -> Channels:
    """Channels of a file, whose format follows from its first bytes rather than its name.

    OSError: it can't be read. ValueError, a sentence without the file's name: no record, damaged, a package missing.
    """
    data = read_plain(path, LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"larger than {LARGEST >> 20} MiB; cut a part of it")
    if not data.strip():
        raise ValueError("it is empty")
    matlab = ("a MATLAB file", _matlab) if path.suffix.lower() == ".mat" else None  # version 4 has no mark of its own
    known = next(((kind, read) for begin, kind, read in KINDS if re.match(begin, data)), matlab)
    if known is None:
        table = TextTable.sniffed(decoded(data))  # and the rate that is stated before its numbers
        tried = (_stated_rate(line[:LONGEST_STATEMENT], table.decimal) for line in table.before)
        stated = [each for each in tried if each is not None]
        rates = frozenset(rate for rate, sampled in stated if sampled) or frozenset(rate for rate, _ in stated)
        values = dict(zip(table.names, table.numbers().T, strict=True))
        return Channels(values, table.units, dict.fromkeys(table.names, rates), table.line)
    kind, read = known
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what a library finds odd but reads
            found = read(data, path)
    except UsageError:
        raise
    except ModuleNotFoundError as error:
        package = str(error.name).partition(".")[0]
        raise ValueError(f"{kind}; reading it takes a further package: python -m pip install {package}") from None
    except Exception as error:  # of any kind: libraries raise what happens to go wrong
        said = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        raise ValueError(f"begins as {kind}, but can't be read ({said}); is it damaged?") from None
    if not found.values:
        raise ValueError(f"{kind} without a signal: no row or column of real numbers is in it")
    return found


def _stated_rate(line, decimal):
    """The rate that a line before the numbers states, Hz, and whether it says that it is one of samples.

    Marks in its number are decimal signs or of thousands: 25,600 Hz in a file of decimal points is 25600 Hz.
    """
    for form in RATES:
        said = form.search(line)
        if said is None or OTHER.search(line[max(0, said.start() - 40) : said.start()]):
            continue
        number, kilo = said["number"], bool(said["kilo"])
        marks, whole, last = re.findall("[.,]", number), number, ""
        if len(set(marks)) == 2:
            whole, _, last = number.rpartition(marks[-1])
        elif len(marks) == 1 and (kilo or marks[0] == decimal or not GROUPS.fullmatch(number)):
            whole, _, last = number.partition(marks[0])
        rate = float(f"{re.sub('[.,]', '', whole)}.{last}")
        return 1e3 * rate if kilo else rate, bool(OF_SAMPLES.search(said[0]))
    return None


def _check_size(size):
    if size > LARGEST:
        raise UsageError(f"unpacks to more than {LARGEST >> 20} MiB; cut a part of it")


def _wav(data, path):
    """All channels of any width; whole numbers become shares of full scale."""
    from scipy.io import wavfile

    rate, values = wavfile.read(io.BytesIO(data))
    if values.size > MOST_NUMBERS:
        raise UsageError(f"a WAV file of more than {MOST_NUMBERS} samples; cut a part of it")
    kind, found = values.dtype.kind, values.reshape(len(values), -1).astype(float)
    if kind == "u":
        found = found / 128.0 - 1.0  # 8 bits have no sign
    elif kind == "i":
        found /= float(1 << (8 * values.dtype.itemsize - 1))
    channels = {f"channel {k}": column for k, column in enumerate(found.T, 1)}
    notes = ["integers were taken as fractions of full scale"] if kind in "iu" else []
    return Channels(channels, rates=dict.fromkeys(channels, frozenset([float(rate)])), notes=notes)


def _matlab(data, path):
    """Variables and fields of structs, by dotted names."""
    from scipy.io import loadmat

    file = loadmat(io.BytesIO(data), squeeze_me=True, struct_as_record=False)
    return Channels().collect({name: value for name, value in file.items() if not name.startswith("__")})


def _archive(data, path):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        if not any(entry.filename.endswith(".npy") for entry in entries):
            raise UsageError("an Excel workbook or an archive; save the sheet as CSV")
        _check_size(sum(entry.file_size for entry in entries))
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        return Channels().collect({name: file[name] for name in file.files})


def _hdf5(data, path):
    """Numbers and groups of a MATLAB 7.3 file or another HDF5 file; texts, cells and links are left out."""
    import h5py

    def tree(group, depth=0):
        found: dict[str, Any] = {}
        for name in list(group)[:MOST_CHANNELS]:
            if name.startswith("#") or type(group.get(name, getlink=True)).__name__ != "HardLink":
                continue
            item = group[name]
            if isinstance(item, h5py.Group) and depth < DEEPEST:
                found[name] = tree(item, depth + 1)
            elif isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and item.ndim in (1, 2) and item.shape[0]:
                if item.attrs.get("MATLAB_class", b"") not in (b"char", "char"):
                    data = check_array(group, name, item.shape[0], kinds="fiu")
                    _check_size(data.size * data.dtype.itemsize)
                    found[name] = data[()]
        return found

    with h5py.File(path, "r") as file:
        return Channels().collect(tree(file))


def _universal(data, path):
    """Data sets 58 over equal steps of time; spectra and the like are no signals."""
    from pyuff import UFF

    sets = UFF(str(path)).read_sets()
    sets = [each for each in (sets if isinstance(sets, list) else [sets]) if each.get("type") == 58]
    found = Channels()
    for k, each in enumerate(sets, 1):
        over_time = (each["func_type"], each.get("abscissa_spec_data_type")) == (0, TIME_AXIS)
        if (over_time or each["func_type"] == TIME_RESPONSE) and np.isrealobj(each["data"]):
            step = each["abscissa_inc"] if each["abscissa_spacing"] == 1 else None
            rates = frozenset([1.0 / step] if step else [])
            found.collect(each["data"], f"{k} {each.get('id1', '')}".strip(), rates)
    if sets and not found.values:
        sets = f"{len(sets)} data sets, none of them over time"
        raise UsageError(f"a universal file (UFF58) of {sets}; spectra cannot be used")
    return found


def _tdms(data, path):
    from nptdms import TdmsFile

    found = Channels()
    with TdmsFile.open(path) as file:
        channels = [c for group in file.groups() for c in group.channels() if c.dtype.kind in "fiu"]
        _check_size(sum(len(channel) * channel.dtype.itemsize for channel in channels))
        for each in channels:
            about = each.properties
            rates = frozenset([1.0 / about["wf_increment"]] if about.get("wf_increment") else [])
            found.collect(each[:], f"{each.group_name}.{each.name}", rates, about.get("unit_string", ""))
    return found


def _parquet(data, path):
    from pyarrow.parquet import ParquetFile

    file = ParquetFile(io.BytesIO(data))
    kinds = {each.name: str(each.type) for each in file.schema_arrow}
    numbers = [name for name, kind in kinds.items() if re.fullmatch(r"u?int\d+|float|double|halffloat", kind)]
    _check_size(8 * file.metadata.num_rows * len(numbers))
    table = file.read(columns=numbers, use_threads=False)
    return Channels().collect({name: np.asarray(table[name]) for name in table.column_names})


KINDS: tuple[tuple[bytes, str, Callable[[bytes, Path], Channels]], ...] = (  # by how they begin
    (rb"(?s:.{512})?" + re.escape(SIGNATURE), "an HDF5 file (MATLAB 7.3)", _hdf5),
    (rb"\s*-1[ \t\r]*\n[ \t]*58b?\s", "a universal file (UFF58)", _universal),
    (rb"RIFF|RIFX|RF64", "a WAV file", _wav),
    (rb"MATLAB", "a MATLAB file", _matlab),
    (rb"\x93NUMPY", "an NPY file", lambda data, _: Channels().collect(np.load(io.BytesIO(data)), "x")),
    (rb"PK\x03\x04", "an NPZ file", _archive),
    (rb"TDSm", "a TDMS file", _tdms),
    (rb"PAR1", "a Parquet file", _parquet),
)

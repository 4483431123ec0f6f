"""One channel of a record, in SI units and at equal steps, with what is wrong with it in sentences."""

import re
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lagrange.errors import InputError
from lagrange.messages import G, shown
from residual.measured.formats import MOST_NUMBERS, read_channels

TIME = re.compile(
    r"(?:.*[._])?(?:time|t|zeit|timestamp|abscissa|x[_ ]?values?)(?:[\s_]*[\[(]?(s|sec|ms|us|µs|ns)[\])]?)?"
    r"|(?:.*\.)?X(?:\[\d+\])?(?: [^.]*)?\.data",
    re.IGNORECASE,
)
SPECTRAL = re.compile(r"(?:.*[._])?(?:f|freq|frequen\w{0,9})(?:[\s_]*[\[(]?k?Hz[\])]?)?", re.IGNORECASE)
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
UNITS = {  # as people write them: factor to SI, SI unit
    **dict.fromkeys(("g", "gn"), (G, "m/s²")), "mg": (1e-3 * G, "m/s²"),
    **dict.fromkeys(("m/s²", "m/s2", "m/s^2", "m_s2"), (1.0, "m/s²")),
    **dict.fromkeys(("mm/s²", "mm/s2", "mm/s^2", "mm_s2"), (1e-3, "m/s²")),
    **dict.fromkeys(("mm/s", "mm_s"), (1e-3, "m/s")), "m/s": (1.0, "m/s"),
}  # fmt: skip
VOLTS = {"v": 1.0, "mv": 1e-3}
SENSITIVITY = re.compile(r"([\d.]+)\s*(m?)V\s*/\s*\(?\s*(g|m/s2|m/s²|m/s\^2|mm/s)\s*\)?", re.IGNORECASE)
IN_BRACKETS = re.compile(r"[\[(]([^\])]+)[\])]\s*$")  # of a channel's name
BEHIND = re.compile(r"_(g|mm?_s2|mm_s|mm?/s(?:\^?2|²)?)$")
FEWEST = 1024  # samples
UNEVEN, APART = 0.02, 1.5  # steps, by which times may scatter as they are written with few digits; more is a gap
RATES_AGREE = 0.01
CLIPPED_RUN, CLIPPED = 3, 3  # equal samples in a row at the largest value, and how many such runs are no chance
SATURATED, DROPPED = 0.01, 32  # of the samples at the largest values; equal samples in a row
OFFSET = 1.0  # times the rms about the mean
LARGEST = 1e30  # of a sample: more is no measured number, nor finite when squared
FASTEST, SLOWEST = 1e9, 1e6  # Hz; s between samples
COARSE = 32  # different values


class Signal(NamedTuple):
    """One channel at equal steps."""

    name: str  # of the file and the channel
    values: np.ndarray  # (n_times,), in `unit`, its mean removed
    rate: float  # Hz
    unit: str  # "m/s²", "m/s"; "" where the record does not tell
    notes: tuple[str, ...] = ()
    records: int = 1  # equally long ones of one speed, one behind the other in `values`

    @property
    def duration(self) -> float:
        return self.values.size / self.rate


@np.errstate(over="ignore", invalid="ignore")  # what overflows is not finite, and refused as such
def read_signal(
    path: str | Path, rate: float | None = None, channel: str | None = None, unit: str | None = None,
    sensitivity: str | None = None,
) -> Signal:  # fmt: skip
    """Read one channel of a record.

    rate : Hz; None: the channel's own, by its column of times or as the file states it
    channel : its name, also without _m_s2, a part of it, or its number from 1; None: the only one
    unit : g, m/s2, mm/s or V; None: as the file says
    sensitivity : of a record in volts, as "100 mV/g"

    InputError: no record, no such channel, no rate, a unit that is not known, fewer than 1024 samples, no vibration.
    """
    path = Path(path)
    try:
        channels = read_channels(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    times = _times(channels)
    name = _chosen(path, channels, channel)
    values = channels.values[name]
    if values.size > MOST_NUMBERS:
        raise InputError(f"{path}: {name} has {values.size} samples, at most {MOST_NUMBERS} are read; cut a part of it")
    word, place = "line" if channels.line else "sample", (channels.line or 1) + np.arange(values.size)
    values, time = values.astype(float), _time_of(path, name, values.size, times, rate)
    if time is not None:  # rows that hold neither: the times about them tell of the gap
        there = ~(np.isnan(time) & np.isnan(values))
        time, values, place = time[there], values[there], place[there]
        if not np.all(np.isfinite(time)):
            if rate is None:
                where = f"{word} {place[np.argmin(np.isfinite(time))]}"
                raise InputError(f"{path}: {where} has no time; delete it, or give --rate, which goes before times")
            time = None
    else:
        for axis, along in channels.values.items():
            if SPECTRAL.fullmatch(axis.strip()) and along.size == values.size and _rises(along):
                what = f"a spectrum over {shown(axis)}, not a record over time"
                raise InputError(f"{path}: {what}; export the time signal")
    notes = [f"{note[0].upper()}{note[1:]}." for note in channels.notes]
    found = _rate(path, name, time, channels.rates.get(name, frozenset()), rate, notes)
    whole, (values, missing) = values.size, _longest(path, values, time, word, place)
    if values.size < FEWEST:
        few = f"{name} has {values.size} samples in one piece; at least {FEWEST} are needed"
        raise InputError(f"{path}: {few}" + (f"; it has {missing}" if missing else ""))
    if missing:
        notes.append(f"The record has {missing}; the longest piece was taken, {values.size} of {whole} samples.")
    factor, si = _unit(path, name, channels, unit, sensitivity)
    if not si:
        notes.append("The record has no unit: levels are in the file's own; give --unit for others.")
    notes += _faults(values, found)
    mean = float(values.mean())
    values = factor * (values - mean)
    if not np.max(np.abs(values)) > 1.0 / LARGEST:
        raise InputError(f"{path}: {name} is constant, {mean:g}: no vibration; is it the right channel?")
    title = path.name if len(channels.values) == 1 else f"{path.name}, {shown(name)}"
    return Signal(title, values, found, si, tuple(notes))


def _times(channels):
    """Columns of times, s, by name, taken out of the channels."""
    times = {}
    for name, values in list(channels.values.items()):
        said = TIME.fullmatch(name.strip())
        unnamed = name == "column 1" and len(channels.values) > 1
        if not ((said or unnamed) and _rises(values)):
            continue
        steps = np.diff(values)
        if said or (np.all(np.isfinite(steps)) and np.mean(np.abs(steps / np.median(steps) - 1.0) > 0.1) < 0.01):
            unit = (said and said[1]) or channels.units.get(name, "s")
            times[name] = channels.values.pop(name) * SECONDS.get(unit.strip().lower(), 1.0)
    return times


def _rises(values):
    finite = values[np.isfinite(values)]
    return bool(finite.size > 2 and np.all(np.diff(finite) > 0))


def _time_of(path, name, size, times, given):
    """The times of a channel, of its own struct or of one about it; None: there are none, or a rate must decide.

    InputError: several columns of times differ, and no rate is given.
    """
    found: dict[str, list[np.ndarray]] = {}
    for each, values in times.items():
        if values.size == size:
            found.setdefault(each.rpartition(".")[0], []).append(values)
    within = name.split(".")[:-1]
    scopes = [".".join(within[:depth]) for depth in range(len(within), -1, -1)]
    if sum(map(len, found.values())) == 1:  # the only one: signals and times in structs of their own
        scopes += found
    own = next((found[scope] for scope in scopes if scope in found), [])
    steps = [float(np.median(np.diff(values[np.isfinite(values)]))) for values in own]
    if steps and max(steps) > (1.0 + RATES_AGREE) * min(steps):
        if given is None:
            raise InputError(f"{path}: {len(own)} columns of times with different steps; give --rate for {shown(name)}")
        return None
    return own[0] if own else None


def _chosen(path, channels, wanted):
    """The name of a channel that is asked for, or of the only one."""
    names = list(channels.values)
    if not names:
        raise InputError(f"{path}: holds times but no signal")
    first = channels.longest if wanted is None else names  # short ones are seldom what a record is of
    listed = ", ".join(f"{k} {shown(name)[:60]}" for k, name in enumerate(first[:20], 1))
    if wanted is None and len(first) == 1:
        return first[0]
    if wanted is None:
        raise InputError(f"{path}: holds {len(first)} channels; add --channel and one of: {listed}")
    whole = [name for name in (wanted, f"{wanted}_m_s2") if name in names]  # as exports name them, beside the same in g
    matches = [name for name in names if wanted.lower() in name.lower()]
    words = [name for name in matches if re.search(rf"(?<![^\W_]){re.escape(wanted)}(?![^\W_])", name, re.IGNORECASE)]
    for found in (whole[:1], matches, words):  # "B" is a word of "Beschleunigung B", not of "Beschleunigung A"
        if len(found) == 1:
            return found[0]
    if wanted.isdecimal() and 1 <= int(wanted) <= len(names):
        return names[int(wanted) - 1]
    how = "several channels" if matches else "no channel"
    raise InputError(f"{path}: --channel {wanted}: {how} of that name; there are: {listed}")


def _rate(path, name, time, stated, given, notes):
    """The rate, Hz, as given, of the times, or as the file states it for this channel."""
    if given is not None and not 1.0 <= given <= FASTEST:
        raise InputError(f"--rate {given:g}: must be a number of Hz from 1 to 1e9")
    own = sorted(stated)
    if time is not None:
        steps = np.diff(time)
        step = float(np.median(steps))
        near = steps[steps < APART * step]
        own = [1.0 / float(near.mean())]
        if (scatter := float(np.std(near)) / step) > UNEVEN:
            notes.append(f"Times scatter by {100.0 * scatter:.2g} % of a step; samples were taken as equally spaced, "
                         "which blurs lines where they are not.")  # fmt: skip
    written = " or ".join(f"{rate:.6g}" for rate in own)
    if given is not None:
        if any(abs(rate / given - 1.0) > RATES_AGREE for rate in own):
            notes.append(f"The file says {written} Hz; --rate {given:g} Hz was taken.")
        return float(given)
    if not own:
        raise InputError(f"{path}: neither a rate nor a column of times is in it; add --rate and the number of Hz")
    if not all(1.0 / SLOWEST <= rate <= FASTEST for rate in own):
        raise InputError(f"{path}: its times or rate give {written} Hz, which no record has; give --rate")
    if own[-1] > (1.0 + RATES_AGREE) * own[0]:
        raise InputError(f"{path}: states {written} Hz; give --rate for {shown(name)}")
    return own[-1]


def _longest(path, values, time, word, place):
    """The longest piece without a gap, and what is missing between pieces; `place`: numbers of lines or samples."""
    broken = ~(np.abs(values) < LARGEST)
    steps = np.diff(time) if time is not None else np.ones(1)
    ends = np.flatnonzero(steps > APART * float(np.median(steps))) + 1
    if not broken.any() and not ends.size:
        return values, ""
    edges = np.unique([0, values.size, *ends, *(np.flatnonzero(np.diff(broken)) + 1)]).tolist()
    pieces = [(b - a, a, b) for a, b in pairwise(edges) if not broken[a]]
    if not pieces:
        raise InputError(f"{path}: no sample of it is a number")
    _, first, last = max(pieces)
    counts = (
        (int(broken.sum()), "sample", f" without a number (the first: {word} {place[np.argmax(broken)]})"),
        (ends.size, "gap", f" in time (the first before {word} {place[ends[0]] if ends.size else 0})"),
    )
    what = " and ".join(f"{n} {one}{'s' if n > 1 else ''}{which}" for n, one, which in counts if n)
    return values[first:last], what


def _unit(path, name, channels, given, sensitivity):
    """Factor to SI and the SI unit, "" of a unit that is not stated."""
    in_name = IN_BRACKETS.search(name[-80:]) or BEHIND.search(name)
    unit = (given if given is not None else channels.units.get(name) or (in_name[1] if in_name else "")).strip().lower()
    if sensitivity is not None:
        said = SENSITIVITY.fullmatch(sensitivity.strip())
        if said is None or not float(said[1]) > 0.0:
            raise InputError(f"--sensitivity {shown(sensitivity)}: write it as 100mV/g, 10mV/(m/s2) or 4mV/(mm/s)")
        if unit and unit not in VOLTS:
            raise InputError(f"{path}: --sensitivity is for a record in V, but this one is in {shown(unit)}")
        factor, si = UNITS[said[3].lower()]
        return VOLTS.get(unit, 1.0) * factor / (float(said[1]) * (1e-3 if said[2] else 1.0)), si
    if given is not None and unit in VOLTS:
        raise InputError(f"--unit {given}: add the sensor's --sensitivity, as 100mV/g")
    if given is not None and unit not in UNITS:
        raise InputError(f"--unit {shown(given)}: not known; known are g, m/s2, mm/s2, mm/s, and V with --sensitivity")
    return UNITS.get(unit, (VOLTS.get(unit, 1.0), ""))


def _faults(values, rate):
    """What is wrong with a record, as sentences."""
    starts = np.append(0, np.flatnonzero(np.diff(values) != 0.0) + 1)
    lengths, high, low = np.diff(starts, append=values.size), values.max(), values.min()
    clipped = ((values[starts] == high) | (values[starts] == low)) & (lengths >= CLIPPED_RUN)
    dropped = (lengths >= DROPPED) & ~clipped
    if clipped.sum() >= CLIPPED and high > low:
        share = float(lengths[clipped].sum()) / values.size
        how = "saturated" if share > SATURATED else "clipped"
        yield (f"The record is {how}: {clipped.sum()} runs of samples at its largest or smallest "
               f"value ({100.0 * share:.2g} % of it); lower the gain. Levels are too low.")  # fmt: skip
    if dropped.any() and high > low:
        longest = f"{1e3 * float(lengths[dropped].max()) / rate:.3g} ms"
        yield f"The signal drops out {dropped.sum()} times: it stays at one value, for up to {longest}."
    mean, spread = float(values.mean()), float(values.std())
    if spread > 0.0 and abs(mean) > OFFSET * spread:
        yield f"Its mean, {mean:.3g}, is larger than its rms about it, {spread:.3g}, and was removed."
    different = np.unique(values[: 1 << 16]).size
    if 1 < different < COARSE:
        yield f"It has {different} different values only: the range was set too wide."

"""Orders: spectra over the shaft's angle, in which the bearing's lines stay where they are while its speed changes.

Computed order tracking: a signal is resampled at equal angles of the shaft, and its spectrum taken as of any other; in
place of Hz then stands the order, cycles per turn of the shaft, and in place of s the turn.

Source: Fyfe and Munck, Analysis of computed order tracking, Mechanical Systems and Signal Processing 11 (1997) 187-205.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from lagrange.kinematics import OUTER_RING, kinematics, turned
from residual.lines import named_peaks
from residual.record import FEWEST_SAMPLES, Record
from residual.spectrum import (
    PASSAGE_SHARE,
    Peak,
    ShortTime,
    Spectrum,
    band_envelope,
    find_peaks,
    kinematic_lines,
    power_spectrum,
    short_time_spectrum,
)
from residual.vibration import ENVELOPE_FROM, ENVELOPE_TO, NARROWEST

FEWEST_TURNS = 1.0  # in fewer no order is resolved
SLOWEST = 1.0 / 8.0  # of the highest speed: below, so many samples go to one turn that nothing new is in them
DEGREE = 5  # of the spline through a signal's samples
TURNS_PER_PIECE = 10.0  # of short-time spectra: FTF, some 0.4, is then four bins off order 0
HIGHEST = 2.2  # times BPFI: as far as lines are looked for in short-time spectra


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """A part of a record in which a ring turns on, and its equal angles."""

    ring: str  # "shaft", or the outer ring where that stands
    part: slice  # of the record's samples
    time: np.ndarray  # (n_times,), s, of the part
    turn: np.ndarray  # (n_times,), rising, turns of the ring at the samples
    angles: np.ndarray  # (n_angles,), turns, equally spaced
    lines: dict[str, float]  # orders, by the run's own cage

    @property
    def step(self) -> float:
        """Between angles, turns."""
        return float((self.angles[-1] - self.angles[0]) / (self.angles.size - 1))

    def resampled(self, signal: np.ndarray) -> np.ndarray:
        """A signal of the whole record, (n_record,), at the equal angles.

        Errors
        ------
        Angles are as near to each other as samples are where the ring is slowest, so that nothing is folded down.
        """
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.turn, signal[self.part], k=DEGREE)(self.angles)

    def envelope(self, acceleration: np.ndarray) -> np.ndarray | None:
        """Envelope of an acceleration, (n_record,), above the roller passage at the highest speed."""
        interval = float(self.time[1] - self.time[0])
        fastest = float(np.gradient(self.turn, interval).max())  # 1/s
        inner, cage = max(self.lines[name] for name in ("BPFO", "BPFI")) * fastest, self.lines["FTF"] * fastest
        found = band_envelope(acceleration, interval, ENVELOPE_FROM * inner, ENVELOPE_TO, cage)
        return None if found is None or found.high - found.low < NARROWEST * inner else found.level


@dataclass(frozen=True, kw_only=True)
class OrderSpectra:
    """Order spectra of one direction; `frequency` of spectra, peaks and levels is an order, a density is per order."""

    tracking: Tracking
    error: Spectrum  # of the error force, N²
    path: Spectrum  # of the hub's place, m²
    peaks: list[Peak]  # of that
    short_time: ShortTime | None  # of that, over turns; None: the record is too short
    envelope: Spectrum | None  # of the envelope of the measured acceleration, (m/s²)²; None: no band is free for it


def tracking_of(record: Record) -> Tracking | None:
    """The longest part of a record with equal angles; None where speeds stay, or nothing turns that is counted.

    Angles are those of the shaft, or of an outer ring that turns about a standing one.

    What is slower than an eighth of the highest speed, or turns back, is left out.
    """
    if not record.varies_speed:
        return None
    inner, outer = (np.asarray(each) for each in record.acting.ring_speeds)
    ring, speed = ("shaft", inner) if np.any(inner) else (OUTER_RING, outer)
    fast = np.sign(speed) * (np.abs(speed) >= SLOWEST * np.abs(speed).max())
    ends = np.concatenate([[0], 1 + np.flatnonzero(np.diff(fast)), [speed.size]])
    first, last = max(((a, b) for a, b in pairwise(ends) if fast[a] != 0.0), key=lambda e: e[1] - e[0])
    part = slice(int(first), int(last))
    time = record.time[part]
    way = turned(record.bearing, record.operation, time)
    turn = fast[first] * ((way.shaft if ring == "shaft" else way.outer_ring) / (2.0 * np.pi))
    if time.size < FEWEST_SAMPLES or turn[-1] - turn[0] < FEWEST_TURNS:
        return None
    count = int(np.ceil((turn[-1] - turn[0]) / np.diff(turn).min())) + 1
    return Tracking(
        ring=ring, part=part, time=time, turn=turn, angles=np.linspace(turn[0], turn[-1], count),
        lines=_lines(record.samples(part), turn[-1] - turn[0]),
    )  # fmt: skip


def _lines(record: Record, turns: float) -> dict[str, float]:
    """Orders of the kinematic lines, by the run's own cage where it turns with the rings."""
    first, last = (turned(record.bearing, record.operation, record.time[at]) for at in (0, -1))
    ways = (last.shaft - first.shaft) / turns, (last.outer_ring - first.outer_ring) / turns
    ideal = kinematics(record.bearing, *ways)
    seen = record.cage_speed * (record.time[-1] - record.time[0]) / turns
    found = kinematic_lines(replace(ideal, cage=seen))
    return found if "FTF" in found and seen * ideal.cage > 0.0 else kinematic_lines(ideal)


def order_spectra(tracking: Tracking, error: np.ndarray, path: np.ndarray, acceleration: np.ndarray) -> OrderSpectra:
    """Order spectra of signals of the whole record: an error force, N, the hub's place, m, an acceleration, m/s²."""
    lines, step = tracking.lines, tracking.step
    slowest, place = lines["FTF"], tracking.resampled(path)
    spectrum, envelope = power_spectrum(place, step, slowest), tracking.envelope(acceleration)
    return OrderSpectra(
        tracking=tracking, error=power_spectrum(tracking.resampled(error), step, slowest), path=spectrum,
        peaks=named_peaks(find_peaks(spectrum, lines), spectrum, lines, 0.0, 0.0),
        short_time=_short_time(place, step, HIGHEST * max(lines["BPFO"], lines["BPFI"])),
        envelope=None if envelope is None else power_spectrum(tracking.resampled(envelope), step, slowest),
    )  # fmt: skip


def _short_time(values: np.ndarray, step: float, highest: float) -> ShortTime | None:
    """Short-time spectrum up to an order, after a filter against what lies above."""
    from scipy.signal import decimate

    fewer = max(1, int(0.5 / (1.5 * highest * step)))
    if fewer > 1:
        values, step = decimate(values, fewer, ftype="fir"), step * fewer
    return short_time_spectrum(values, step, PASSAGE_SHARE / TURNS_PER_PIECE)

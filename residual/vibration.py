"""Lines of a bearing and levels of its vibration: in spectra, in envelopes, and in orders where its speed changes.

A density in N²/Hz is for noise; a line's height in it depends on the record's length. A line is stated as the rms of
its main lobe, which does not; in the unit of the signal: N of an error force, m/s² of an acceleration.

Computed order tracking: a signal is resampled at equal angles of the shaft, and its spectrum taken as of any other; in
place of Hz then stands the order, cycles per turn of the shaft, and in place of s the turn.

Source: Fyfe and Munck, Analysis of computed order tracking, Mechanical Systems and Signal Processing 11 (1997) 187-205.
"""

import re
from dataclasses import replace
from itertools import pairwise, product
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from lagrange.errors import InputError
from lagrange.kinematics import OUTER_RING, kinematics, turned
from residual import spectrum as spectra
from residual.budget import Accelerations
from residual.record import FEWEST_SAMPLES, Record
from residual.spectrum import MAIN_LOBE, Envelope, Level, Peak, Spectrum, band_envelope, power_spectrum

# of spectra
CAGE_HARMONICS = (2, 3)
SIDES = tuple(product(("BPFO", "2×BPFO", "BPFI", "2×BPFI"), ("shaft", OUTER_RING, "FTF")))  # carrier, modulator
BOTH_SIDES = (-1, "−"), (1, "+")
HUB = "hub on its contacts"
NEAR_RESONANCE = 0.08  # of it: of rollers without mass, whose two contacts are taken as equally stiff
SURE = 0.999  # a line stands out where noise on the background would stay below with this probability
SAME_LINE = 0.01  # relative: a frequency asked for in Hz this near a line is that line
# of envelopes and levels
VELOCITY_BAND = (10.0, 1000.0)  # Hz, of ISO 20816
BANDS = ((0.0, 1e3), (1e3, 5e3), (5e3, 20e3), (20e3, 50e3))  # Hz
ENVELOPE_FROM = 3.0  # times BPFI: above what rollers do to the hub by passing
ENVELOPE_TO = 50e3  # Hz, as far as accelerometers go
NARROWEST = 2.0  # times BPFI: an envelope shows nothing faster than its band's width
FAULT_LINES = ("BPFO", "2×BPFO", "3×BPFO", "BPFI", "2×BPFI")
FAULT_SIDES = (
    ("BPFO", OUTER_RING), ("2×BPFO", OUTER_RING), ("BPFI", "shaft"), ("2×BPFI", "shaft"), ("2×BSF", "FTF"))  # fmt: skip
NEIGHBOURS, FEWEST_NEIGHBOURS = 8, 4  # cage multiples on either side that a line is compared with; together
# times its neighbours' median, 12 dB: a perfect bearing's BPFO, of passing rollers, reaches 3.7 (docs/surfaces.md)
STANDS_OUT = 4.0
SIDE_LOBE = 0.03  # of the highest line, Hann's first side lobe: less may be that line's leakage
# of orders
FEWEST_TURNS = 1.0  # in fewer no order is resolved
SLOWEST = 1.0 / 8.0  # of the highest speed: below, so many samples go to one turn that nothing new is in them
DEGREE = 5  # of the spline through a signal's samples
HIGHEST = 2.2  # times BPFI, that figures show


class LineLevel(NamedTuple):
    name: str
    frequency: float  # Hz, from kinematics or as asked for
    rms: float  # in low … high
    background: float  # rms that the smooth background alone has in that band
    low: float  # Hz
    high: float
    stands_out: bool
    resolved: bool  # no other line, nor zero frequency, within the main lobe
    obstacle: str  # the nearest of them, "zero frequency" or a line's name
    record_needed: float  # s, of a record that resolves it

    def unresolved_note(self, resolution: float) -> str:
        """Why the line can't be resolved at a resolution, Hz, and the record length that would."""
        return (
            f"{self.name} can't be resolved from this record: with Δf = {resolution:.4g} Hz it lies "
            f"{self.frequency / resolution:.2g} bins up, and {self.obstacle} lies within two bins of it; it takes a "
            f"record of at least {self.record_needed:.2g} s"
        )


def sidebands(lines: dict[str, float]) -> dict[str, float]:
    """Frequencies, Hz, by name, of lines that only a long record separates: "2×FTF", "BPFO+shaft", ...

    The sidebands are the first ones of the ball-pass lines, modulated by shaft and cage.
    """
    return {f"{k}×FTF": k * lines["FTF"] for k in CAGE_HARMONICS if "FTF" in lines} | _first_sidebands(lines, SIDES)


def _first_sidebands(lines, sides):
    found = {f"{carrier}{symbol}{modulator}": lines[carrier] + sign * lines[modulator] for carrier, modulator in sides
             if carrier in lines and modulator in lines for sign, symbol in BOTH_SIDES}  # fmt: skip
    return {name: frequency for name, frequency in found.items() if frequency > 0.0}


def _surroundings(frequency, among, resolution):
    """Nearest other line, or "zero frequency"; how far off it is, and half of the band that is a line's own, Hz.

    That is its main lobe, less where another line is nearer.
    """
    gaps = [(abs(f - frequency), name) for name, f in (among | {"zero frequency": 0.0}).items()]
    gap, nearest = min((each for each in gaps if each[0] > SAME_LINE * frequency), key=lambda each: each[0])
    return nearest, gap, max(min(MAIN_LOBE * resolution, 0.5 * gap), 0.75 * resolution)


def _level(spectrum, name, frequency, among):
    """Level of one line: the rms in its main lobe, cut half-way to the nearest other line of `among`.

    It stands out where it exceeds what noise on the background would be.
    """
    from scipy.special import chdtri  # scipy.stats costs half a second to import

    obstacle, gap, half = _surroundings(frequency, among, spectrum.resolution)
    low, high = frequency - half, frequency + half
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high) & (spectrum.frequency > 0.0)
    power, background = (of[inside].sum() * spectrum.resolution for of in (spectrum.psd, spectrum.smooth_background))
    freedom = 2.0 * spectrum.segments * max(1.0, inside.sum() / spectra.NOISE_BINS)
    stands_out = power > background * (chdtri(freedom, 1.0 - SURE) / freedom)
    resolved, needed = gap >= MAIN_LOBE * spectrum.resolution, MAIN_LOBE / gap
    return LineLevel(name, frequency, sqrt(power), sqrt(background), low, high, stands_out, resolved, obstacle, needed)


def line_levels(spectrum: Spectrum, lines: dict[str, float]) -> list[LineLevel]:
    """Levels of all lines and all resolved sidebands below the Nyquist frequency, by frequency."""
    every = lines | sidebands(lines)
    levels = [_level(spectrum, name, every[name], lines if name in lines else every) for name in every]
    shown = (x for x in levels if x.high <= spectrum.frequency[-1] and (x.name in lines or x.resolved))
    return sorted(shown, key=lambda level: level.frequency)


def watched_level(spectrum: Spectrum, wanted: str, lines: dict[str, float]) -> LineLevel:
    """Level of a line that the user asks for: "22" (Hz), "BPFO", "2xBPFO", "BPFO-shaft".

    InputError: neither a line's name nor a frequency within the spectrum.
    """
    sides, top = sidebands(lines), spectrum.frequency[-1]
    among = lines | sides
    name = re.sub(r"(?<=\d)x", "×", wanted.strip().replace("-", "−").replace("*", "×"))
    frequency = {key.lower(): value for key, value in among.items()}.get(name.lower())
    if frequency is None:
        try:
            frequency = float(wanted)
        except ValueError:
            raise InputError(
                f"--line {wanted}: neither a frequency in Hz nor a line; lines here are {', '.join(among) or 'none'}"
            ) from None
        name = f"{frequency:g} Hz"
    if not spectra.LOWEST < frequency < top:
        limits = f"{spectra.LOWEST:g} Hz and the Nyquist frequency {top:.4g} Hz"
        raise InputError(f"--line {wanted}: must lie between {limits}")
    return _level(spectrum, name, frequency, among if name.lower() in map(str.lower, sides) else lines)


def named_peaks(
    peaks: list[Peak], spectrum: Spectrum, lines: dict[str, float], resonance: float, noise: float
) -> list[Peak]:
    """Name peaks without a line after a resolved sideband within half a bin.

    Those near the hub's resonance there, Hz, are named so too; peaks of no more than the noise, N rms, are left out.
    """
    bands = [level for level in line_levels(spectrum, lines) if level.name not in lines]
    named, near = list[Peak](), 0.5 * spectrum.resolution  # Hz
    for peak in (peak for peak in peaks if peak.rms > noise):
        names = () if peak.line else [each.name for each in bands if abs(each.frequency - peak.frequency) <= near]
        hub = (HUB,) if abs(peak.frequency - resonance) <= NEAR_RESONANCE * resonance else ()
        named.append(peak._replace(line=next(iter(names), peak.line), also=(*peak.also, *hub)))
    return named


class FaultLine(NamedTuple):
    name: str
    frequency: float  # Hz, by the run's own cage speed
    amplitude: float  # m/s², not rms
    floor: float  # m/s², median of the amplitudes at cage multiples from the line
    ratio: float  # amplitude over floor
    resolved: bool  # no other fault line within the main lobe
    is_high: bool  # ratio at least STANDS_OUT, and no leakage of another line
    nearest: str  # of the other lines
    record_needed: float  # s, to resolve it from that

    @property
    def stands_out(self) -> bool:
        return self.is_high and self.resolved


class Vibration(NamedTuple):
    """Acceleration of a body in one direction, its mean removed."""

    body: str  # "sensor", "housing" or "hub"
    acceleration: np.ndarray  # (n_times,), m/s²
    level: Level  # m/s²
    bands: dict[tuple[float, float], Level]  # by the band's limits, Hz; their rms by the spectrum
    velocity: float | None  # m/s rms in ISO 20816's band; None: the record is too short or too slow for it
    spectrum: Spectrum
    envelope: Envelope | None
    lines: list[FaultLine]  # of the envelope


def measured(record: Record, accelerations: Accelerations | None = None) -> list[tuple[str, Any]]:
    """Body and acceleration, (n_times,), m/s², along x and along y, in the fixed frame, as an accelerometer shows it.

    The sensor's where a run has one, else the housing's (that of the outer ring in it, or its own beside a ring with a
    fit), else the hub's; the integrator's own where the source holds it, else from positions, or None. A sensor
    measures along y alone; along x stands the housing beside it.

    `accelerations` : from positions; None: the integrator's own alone count
    """
    mounting = record.scene.mounting()
    hub, ring, housing = map(record.along, ("inner_a", "outer_ring_a", "housing_a"))
    if accelerations is not None:
        hub = accelerations.whole if hub is None else hub
        ring = accelerations.outer_ring if ring is None else ring
    moved = None if mounting.housing is None else ring if mounting.bore is None else housing
    body, along = ("hub", hub) if moved is None else ("housing", moved)
    x, y = (None, None) if along is None else along
    return [(body, x), (body, y) if record.sensor_ay is None else ("sensor", record.sensor_ay)]


def _fault_band(acceleration, interval, inner, cage):
    """Envelope of what lies above the passages of rollers, Hz, as far as accelerometers go; None: no band is left."""
    found = band_envelope(acceleration, interval, ENVELOPE_FROM * inner, ENVELOPE_TO, cage)
    return None if found is None or found.high - found.low < NARROWEST * inner else found


def vibration(
    acceleration, interval: float, lines: dict[str, float], body: str = "hub", band: tuple[float, float] | None = None
) -> Vibration:
    """Levels and fault lines of one component of a body's acceleration, (n_times,), m/s².

    lines : kinematic lines, Hz, as `spectrum.kinematic_lines` names them; none for a standing bearing
    band : Hz, that is demodulated; None: from 3 BPFI to 50 kHz, or 0.9 of the Nyquist frequency

    The record is sampled without a filter: vibration beyond the Nyquist frequency is folded into the bands below it.
    Band levels are weighted by the spectrum's window, so those of a vibration that dies away are its middle's.
    InputError: the record has no such band, or is too short for its envelope.
    """
    from scipy import fft

    motion = np.asarray(acceleration, dtype=float)
    motion = motion - motion.mean()
    cage, inner, found = lines.get("FTF", 0.0), max(lines.get("BPFO", 0.0), lines.get("BPFI", 0.0)), None
    if cage > 0.0:
        found = (_fault_band(motion, interval, inner, cage) if band is None
                 else band_envelope(motion, interval, *band, cage))  # fmt: skip
    if band is not None and (found is None or found.high < band[1]):
        raise InputError(
            f"--band {band[0]:g}-{band[1]:g}: no envelope of this record; it needs a bearing that turns at one speed, "
            f"a band below {spectra.TOP_OF_NYQUIST * 0.5 / interval:.5g} Hz, and some periods of the band's width"
        )
    spectrum, bands = power_spectrum(motion, interval, cage), {}
    top, transform, frequency = spectrum.frequency[-1], fft.rfft(motion), fft.rfftfreq(motion.size, interval)
    for low, high in ((low, min(high, top)) for low, high in BANDS if low + spectrum.resolution < top):
        part = fft.irfft(np.where((frequency >= low) & (frequency < high), transform, 0.0), motion.size)
        bands[low, high] = Level.of(part)._replace(rms=spectrum.band_rms(low, high))
    faults = [] if found is None else envelope_lines(found, lines)
    return Vibration(body, motion, Level.of(motion), bands, velocity_level(spectrum), spectrum, found, faults)


def velocity_level(spectrum: Spectrum) -> float | None:
    """Vibration velocity, m/s rms, in ISO 20816's band, of the spectrum of an acceleration, m/s².

    None: the record is too short or too slow for the band.
    """
    low, high = VELOCITY_BAND
    if spectrum.resolution > 0.5 * low or spectrum.frequency[-1] < high:
        return None
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high)
    of_velocity = spectrum.psd[inside] / (2.0 * np.pi * spectrum.frequency[inside]) ** 2
    return np.sqrt(np.sum(of_velocity) * spectrum.resolution)


def fault_lines(lines: dict[str, float]) -> dict[str, float]:
    """Lines, Hz, that faults of outer ring, inner ring and rollers leave in an envelope, by name.

    A ring's fault goes through the load zone as the ring turns, a roller's with the cage; a roller's strikes both
    raceways in each of its turns.
    """
    found = {name: lines[name] for name in FAULT_LINES if name in lines}
    found |= {"2×BSF": 2.0 * lines["BSF"]} if "BSF" in lines else {}
    return found | _first_sidebands(lines | found, FAULT_SIDES)


def envelope_lines(found: Envelope, lines: dict[str, float]) -> list[FaultLine]:
    """Amplitudes of the fault lines below the band's width beside the floor around them, by frequency.

    The floor is the median level at multiples of the cage's frequency from the line, not of all bins between them: a
    run repeats nearly, once a revolution of the cage, so its spectrum is a comb of them even where nothing is wrong.
    """
    spectrum, described = found.spectrum, []
    wanted, cage, step, top = fault_lines(lines), lines["FTF"], spectrum.resolution, found.high - found.low
    spacing = cage * np.ceil(2.0 * MAIN_LOBE * step / cage)
    for name, frequency in wanted.items():
        nearest, gap, half = _surroundings(frequency, wanted, step)
        beside = frequency + spacing * np.array([k for k in range(-NEIGHBOURS, NEIGHBOURS + 1) if k])
        beside = beside[(beside > half + step) & (beside < top - half)]
        if beside.size >= FEWEST_NEIGHBOURS and frequency + half < top:
            amplitude, *others = (np.sqrt(2.0) * spectrum.band_rms(f - half, f + half) for f in (frequency, *beside))
            floor = np.median(others)
            ratio = amplitude / floor if floor > 0.0 else 0.0
            described.append(FaultLine(
                name, frequency, amplitude, floor, ratio, resolved=gap >= MAIN_LOBE * step,
                is_high=ratio >= STANDS_OUT, nearest=nearest, record_needed=MAIN_LOBE / gap))  # fmt: skip
    least = SIDE_LOBE * max((line.amplitude for line in described), default=0.0)
    described = [line._replace(is_high=line.is_high and line.amplitude >= least) for line in described]
    return sorted(described, key=lambda line: line.frequency)


class Tracking(NamedTuple):
    """A part of a record in which a ring turns on, and its equal angles."""

    ring: str  # "shaft", or the outer ring where that stands
    part: slice  # of the record's samples
    time: np.ndarray  # (n_times,), s, of the part
    turn: np.ndarray  # (n_times,), rising, turns of the ring at the samples
    angles: np.ndarray  # (n_angles,), turns, equally spaced
    lines: dict[str, float]  # orders, by the run's own cage

    def resampled(self, signal: np.ndarray) -> np.ndarray:
        """A signal of the whole record, (n_record,), at the equal angles.

        Angles are as near to each other as samples are where the ring is slowest, so that nothing is folded down.
        """
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.turn, signal[self.part], k=DEGREE)(self.angles)


class OrderSpectra(NamedTuple):
    """Order spectra of one direction; `frequency` of spectra, peaks and levels is an order, a density is per order."""

    tracking: Tracking
    error: Spectrum  # of the error force, N²
    path: Spectrum  # of the hub's place, m²
    peaks: list[Peak]  # of that
    envelope: Spectrum | None  # of the envelope of the measured acceleration, (m/s²)²; None: no band is free for it


def tracking_of(record: Record) -> Tracking | None:
    """The longest part of a record with equal angles; None where speeds stay, or nothing turns that is counted.

    Angles are those of the shaft, or of an outer ring that turns about a standing one. What is slower than an eighth of
    the highest speed, or turns back, is left out. Lines go by the run's own cage where it turns with the rings.
    """
    if not record.varies_speed:
        return None
    inner, outer = (np.asarray(each) for each in record.acting.ring_speeds)
    ring, speed = ("shaft", inner) if np.any(inner) else (OUTER_RING, outer)
    fast = np.sign(speed) * (np.abs(speed) >= SLOWEST * np.abs(speed).max())
    ends = np.concatenate([[0], 1 + np.flatnonzero(np.diff(fast)), [speed.size]])
    first, last = max(((a, b) for a, b in pairwise(ends) if fast[a] != 0.0), key=lambda e: e[1] - e[0])
    part = slice(first, last)
    time, way = record.time[part], turned(record.bearing, record.operation, record.time[part])
    turn = fast[first] * ((way.shaft if ring == "shaft" else way.outer_ring) / (2.0 * np.pi))
    turns = turn[-1] - turn[0]
    if time.size < FEWEST_SAMPLES or turns < FEWEST_TURNS:
        return None
    ways = (np.broadcast_to(of, time.shape) for of in (way.shaft, way.outer_ring))
    ideal = kinematics(record.bearing, *((of[-1] - of[0]) / turns for of in ways))
    seen = record.samples(part).cage_speed * (time[-1] - time[0]) / turns
    lines = spectra.kinematic_lines(replace(ideal, cage=seen))
    lines = lines if "FTF" in lines and seen * ideal.cage > 0.0 else spectra.kinematic_lines(ideal)
    angles = np.linspace(turn[0], turn[-1], int(np.ceil(turns / np.diff(turn).min())) + 1)
    return Tracking(ring, part, time, turn, angles, lines)


def order_spectra(tracking: Tracking, error: np.ndarray, path: np.ndarray, acceleration: np.ndarray) -> OrderSpectra:
    """Order spectra of signals of the whole record: an error force, N, the hub's place, m, an acceleration, m/s²."""
    lines, angles = tracking.lines, tracking.angles
    step, slowest = (angles[-1] - angles[0]) / (angles.size - 1), lines["FTF"]
    spectrum, interval = power_spectrum(tracking.resampled(path), step, slowest), tracking.time[1] - tracking.time[0]
    fastest = np.gradient(tracking.turn, interval).max()  # 1/s
    passing = max(lines["BPFO"], lines["BPFI"])
    envelope = _fault_band(acceleration, interval, passing * fastest, slowest * fastest)
    return OrderSpectra(
        tracking, power_spectrum(tracking.resampled(error), step, slowest), spectrum,
        named_peaks(spectra.find_peaks(spectrum, lines), spectrum, lines, 0.0, 0.0),
        None if envelope is None else power_spectrum(tracking.resampled(envelope.level), step, slowest))  # fmt: skip

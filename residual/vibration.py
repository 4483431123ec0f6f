"""Vibration as bearing engineers read it: levels of an acceleration, and fault lines in its envelope."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lagrange.kinematics import OUTER_RING
from residual.budget import Accelerations
from residual.errors import InputError
from residual.lines import first_sidebands, half_band, nearest_line
from residual.record import Record
from residual.spectrum import (
    MAIN_LOBE,
    TOP_OF_NYQUIST,
    Envelope,
    Level,
    Spectrum,
    band_envelope,
    power_spectrum,
)

Measured = tuple[str, Any]  # a body and its acceleration along an axis, (n_times,), m/s²; None: the source has none
VELOCITY_BAND = (10.0, 1000.0)  # Hz, of ISO 20816
BANDS = ((0.0, 1e3), (1e3, 5e3), (5e3, 20e3), (20e3, 50e3))  # Hz
ENVELOPE_FROM = 3.0  # times BPFI: above what rollers do to the hub by passing
ENVELOPE_TO = 50e3  # Hz, as far as accelerometers go
NARROWEST = 2.0  # times BPFI: an envelope shows nothing faster than its band's width
HARMONICS = (("BPFO", 3), ("BPFI", 2))
SIDES = (
    ("BPFO", OUTER_RING), ("2×BPFO", OUTER_RING), ("BPFI", "shaft"), ("2×BPFI", "shaft"), ("2×BSF", "FTF"),
)  # fmt: skip
NEIGHBOURS = 8  # cage multiples on either side that a line is compared with
FEWEST_NEIGHBOURS = 4
# times its neighbours' median, 12 dB: a perfect bearing's BPFO, of passing rollers, reaches 3.7 (docs/surfaces.md)
STANDS_OUT = 4.0
SIDE_LOBE = 0.03  # of the highest line, Hann's first side lobe: less may be that line's leakage


@dataclass(frozen=True, kw_only=True)
class FaultLine:
    """One line of the envelope's spectrum."""

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


@dataclass(frozen=True, kw_only=True)
class Vibration:
    """Acceleration of a body in one direction, its mean removed."""

    body: str  # "sensor", "housing" or "hub"
    acceleration: np.ndarray  # (n_times,), m/s²
    level: Level  # m/s²
    bands: dict[tuple[float, float], Level]  # by the band's limits, Hz; their rms by the spectrum
    velocity: float | None  # m/s rms in ISO 20816's band; None: the record is too short or too slow for it
    spectrum: Spectrum
    envelope: Envelope | None
    lines: list[FaultLine]  # of the envelope

    @property
    def high_lines(self) -> list[FaultLine]:
        """Lines that are high above their floors, whether or not the record resolves them."""
        return [line for line in self.lines if line.is_high]

    @property
    def tells_lines(self) -> bool:
        """Whether the record is long enough to tell any fault line from the others."""
        return any(line.resolved for line in self.lines)


def measured(record: Record, accelerations: Accelerations | None = None) -> tuple[Measured, Measured]:
    """Body and acceleration along x and along y, in the fixed frame: what an accelerometer on the machine would show.

    The sensor's where a run has one, else the housing's (that of the outer ring in it, or its own beside a ring with a
    fit), else the hub's; the integrator's own where the source holds it, else from positions. A sensor measures along y
    alone; along x stands the housing beside it.

    `accelerations` : from positions; None: the integrator's own alone count
    """
    mounting, found, none = record.scene.mounting(), [], (None, None)
    hubs, rings = (none, none) if accelerations is None else (accelerations.whole, accelerations.outer_ring)
    for axis, hub, ring in zip("xy", hubs, rings, strict=True):
        own = {name: getattr(record, f"{name}_a{axis}") for name in ("inner", "outer_ring", "housing")}
        place = "hub", hub if own["inner"] is None else own["inner"]
        moved = (
            own["housing"] if mounting.bore is not None else ring if own["outer_ring"] is None else own["outer_ring"]
        )
        if mounting.housing is not None and moved is not None:
            place = "housing", moved
        found.append(place)
    return found[0], found[1] if record.sensor_ay is None else ("sensor", record.sensor_ay)


def vibration(
    acceleration, interval: float, lines: dict[str, float], body: str = "hub", band: tuple[float, float] | None = None
) -> Vibration:
    """Levels and fault lines of one component of a body's acceleration.

    Parameters
    ----------
    acceleration : ndarray, (n_times,), m/s²
    interval : float, s
    lines : kinematic lines, Hz, as `spectrum.kinematic_lines` names them; none for a standing bearing
    band : Hz, that is demodulated; None: from 3 BPFI to 50 kHz, or 0.9 of the Nyquist frequency

    Errors
    ------
    The record is sampled without a filter: vibration beyond the Nyquist frequency is folded into the bands below it.
    Band levels are weighted by the spectrum's window, so those of a vibration that dies away are its middle's.
    InputError: the record has no such band, or is too short for its envelope.
    """
    motion = np.asarray(acceleration, dtype=float)
    motion = motion - motion.mean()
    cage, inner = lines.get("FTF", 0.0), max(lines.get("BPFO", 0.0), lines.get("BPFI", 0.0))
    low, high = (ENVELOPE_FROM * inner, ENVELOPE_TO) if band is None else band
    found = band_envelope(motion, interval, low, high, cage) if cage > 0.0 else None
    if band is not None and (found is None or found.high < high):
        raise InputError(
            f"--band {low:g}-{high:g}: no envelope of this record; it needs a bearing that turns at one speed, a band "
            f"below {TOP_OF_NYQUIST * 0.5 / interval:.5g} Hz, and some periods of the band's width"
        )
    if band is None and found is not None and found.high - found.low < NARROWEST * inner:
        found = None
    spectrum = power_spectrum(motion, interval, cage)
    return Vibration(
        body=body, acceleration=motion, level=Level.of(motion),
        bands=band_levels(motion, interval, spectrum), velocity=velocity_level(spectrum), spectrum=spectrum,
        envelope=found,
        lines=[] if found is None else envelope_lines(found, lines),
    )  # fmt: skip


def band_levels(motion: np.ndarray, interval: float, spectrum: Spectrum) -> dict[tuple[float, float], Level]:
    """Levels in the bands that engineers use, as far as the spectrum goes, by their limits, Hz."""
    from scipy import fft

    top = float(spectrum.frequency[-1])
    transform, frequency = fft.rfft(motion), fft.rfftfreq(motion.size, interval)
    found = {}
    for low, high in ((low, min(high, top)) for low, high in BANDS if low + spectrum.resolution < top):
        part = fft.irfft(np.where((frequency >= low) & (frequency < high), transform, 0.0), motion.size)
        found[low, high] = replace(Level.of(part), rms=spectrum.band_rms(low, high))
    return found


def velocity_level(spectrum: Spectrum) -> float | None:
    """Vibration velocity, m/s rms, in ISO 20816's band, of the spectrum of an acceleration, m/s².

    None: the record is too short or too slow for the band.
    """
    low, high = VELOCITY_BAND
    if spectrum.resolution > 0.5 * low or spectrum.frequency[-1] < high:
        return None
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high)
    of_velocity = spectrum.psd[inside] / (2.0 * np.pi * spectrum.frequency[inside]) ** 2
    return float(np.sqrt(np.sum(of_velocity) * spectrum.resolution))


def fault_lines(lines: dict[str, float]) -> dict[str, float]:
    """Lines, Hz, that faults of outer ring, inner ring and rollers leave in an envelope, by name.

    A ring's fault goes through the load zone as the ring turns, a roller's with the cage; a roller's strikes both
    raceways in each of its turns.
    """
    found: dict[str, float] = {}
    for name, count in HARMONICS:
        if name in lines:
            found |= {name if k == 1 else f"{k}×{name}": k * lines[name] for k in range(1, count + 1)}
    if "BSF" in lines:
        found["2×BSF"] = 2.0 * lines["BSF"]
    return found | first_sidebands(lines | found, SIDES)


def envelope_lines(found: Envelope, lines: dict[str, float]) -> list[FaultLine]:
    """Amplitudes of the fault lines below the band's width beside the floor around them, by frequency.

    The floor is the median level at multiples of the cage's frequency from the line, not of all bins between them: a
    run repeats nearly, once a revolution of the cage, so its spectrum is a comb of them even where nothing is wrong.
    """
    spectrum = found.spectrum
    wanted, cage, step = fault_lines(lines), lines["FTF"], spectrum.resolution
    spacing = cage * np.ceil(2.0 * MAIN_LOBE * step / cage)
    top, levels = found.high - found.low, {}
    for name, frequency in wanted.items():
        half = half_band(nearest_line(frequency, wanted)[1], step)
        beside = frequency + spacing * np.array([k for k in range(-NEIGHBOURS, NEIGHBOURS + 1) if k])
        beside = beside[(beside > half + step) & (beside < top - half)]
        if beside.size >= FEWEST_NEIGHBOURS and frequency + half < top:
            amplitude, *others = (np.sqrt(2.0) * spectrum.band_rms(f - half, f + half) for f in (frequency, *beside))
            levels[name] = float(amplitude), float(np.median(others))
    least = SIDE_LOBE * max((amplitude for amplitude, _ in levels.values()), default=0.0)
    described = []
    for name, (amplitude, floor) in levels.items():
        ratio = amplitude / floor if floor > 0.0 else 0.0
        nearest, gap = nearest_line(wanted[name], wanted)
        resolved = gap >= MAIN_LOBE * step
        described.append(
            FaultLine(
                name=name, frequency=wanted[name], amplitude=amplitude, floor=floor, ratio=ratio, resolved=resolved,
                is_high=ratio >= STANDS_OUT and amplitude >= least, nearest=nearest, record_needed=MAIN_LOBE / gap,
            )
        )  # fmt: skip
    return sorted(described, key=lambda line: line.frequency)

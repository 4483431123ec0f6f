"""Records whose truth is known: strikes through resonances, with slip, in the noise of a machine.

They are made of nothing that the diagnosis is made of, and have what measured records have and simulated ones lack:
speeds that are not the nominal ones, strikes that come early or late, lines of shaft and inverter, coloured noise.
"""

from dataclasses import dataclass

import numpy as np

from residual.measured.diagnosis import BODIES, SLIP, Geometry, side_of
from residual.measured.signals import Signal

LOAD_ZONE = 0.35  # of a turn, where an inner ring's or element's fault is struck
MOST_SHAFT = 4  # harmonics in the noise's own modulation


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """A record and what is in it."""

    signal: Signal
    fault: str | None  # "BPFO", "BPFI", "2×BSF"
    line: float  # Hz, of the fault, as it is
    sides: float  # Hz, spacing of its sidebands; 0: none
    shaft: float  # Hz, as it is


def synthetic_record(
    rng: np.random.Generator, geometry: Geometry, shaft: float, fault: str | None, strength: float, *,
    speed_error: float = 0.0, duration: float = 2.0, rate: float = 25_600.0, inverter: bool = True,
) -> Truth:  # fmt: skip
    """One record.

    Parameters
    ----------
    shaft : float, Hz, nominal; it turns by a share `speed_error` faster
    fault : name of the line of the damaged part; None: healthy
    strength : rms of the strikes over that of all noise
    """
    n, turning = int(duration * rate), shaft * (1.0 + speed_error)
    time = np.arange(n) / rate
    lines = geometry.lines(turning)
    resonances = [(rng.uniform(0.1, 0.2) * rate, rng.uniform(0.02, 0.05)) for _ in range(2)]
    noise = rng.standard_normal(n)
    noise += 1.5 * _through(rng.standard_normal(n), rate, resonances)
    swell = sum(
        rng.uniform(0.0, 0.15) / k * np.cos(2.0 * np.pi * k * turning * time + rng.uniform(0.0, 6.3))
        for k in range(1, MOST_SHAFT + 1)
    )
    noise *= 1.0 + swell
    for k in range(1, 9):
        noise += rng.uniform(0.0, 1.5) * np.cos(2.0 * np.pi * k * turning * time + rng.uniform(0.0, 6.3))
    if inverter:
        supply, carrier = turning * rng.choice([1, 2, 3]) * rng.uniform(1.005, 1.04), rng.uniform(2e3, 5e3)
        for k in range(1, 3):
            for m in range(-6, 7, 2):
                tone = k * carrier + m * supply
                noise += rng.uniform(0.0, 2.0) * np.cos(2.0 * np.pi * tone * time + rng.uniform(0.0, 6.3))
    noise /= noise.std()
    line = sides = 0.0
    if fault is not None:
        slip = rng.uniform(-SLIP, 0.3 * SLIP)
        line = lines[fault] * (1.0 + slip)
        sides = side_of(fault, lines)
        strikes = _through(_strikes(rng, n, rate, line, sides), rate, resonances)
        noise = noise + strength * strikes / strikes.std()
    scale = 10.0 ** rng.uniform(-1.0, 1.5)
    values = scale * (noise - noise.mean())
    signal = Signal(name="synthetic", values=values, rate=rate, unit="m/s²")
    return Truth(signal=signal, fault=fault, line=line, sides=sides, shaft=turning)


def _strikes(rng: np.random.Generator, n: int, rate: float, line: float, sides: float) -> np.ndarray:
    """A train of unit pulses that comes early or late by slip, (n,), by a load zone where `sides` is above 0."""
    count = int(1.1 * line * n / rate) + 3
    times = np.cumsum(1.0 / line * (1.0 + 0.007 * rng.standard_normal(count)))
    times = times[np.rint(times * rate) < n - 1]
    times *= 1.0 + (times.size / line / times[-1] - 1.0)  # the mean rate is the line's
    size = 1.0 + 0.2 * rng.standard_normal(times.size)
    if sides:
        angle = np.mod(sides * times + rng.uniform(), 1.0)
        size *= np.maximum(0.05, np.cos(np.pi * np.minimum(1.0, np.abs(angle - 0.5) / LOAD_ZONE) / 2.0))
    train = np.zeros(n)
    index = np.rint(times * rate).astype(int)
    np.add.at(train, index[index < n], size[index < n])
    return train


def _through(values: np.ndarray, rate: float, resonances: list[tuple[float, float]]) -> np.ndarray:
    """Values through resonances, Hz and damping ratios, of rms 1."""
    from scipy.signal import fftconvolve

    time = np.arange(int(0.02 * rate)) / rate
    total = np.zeros(time.size)
    for frequency, damping in resonances:
        omega = 2.0 * np.pi * frequency
        total += np.exp(-damping * omega * time) * np.sin(omega * time)
    found = fftconvolve(values, total)[: values.size]
    return found / found.std()


def drawn(
    rng: np.random.Generator, healthy: bool, tolerance: float, duration: float = 2.0
) -> tuple[Truth, Geometry, float]:
    """A record of a bearing, fault, strength and speed drawn by chance; its geometry and nominal shaft speed, Hz.

    A fifth of healthy bearings have strikes too, so weak that they are no damage.
    """
    count = int(rng.integers(7, 18))
    share = min(rng.uniform(0.12, 0.24), 0.8 * np.pi / count)
    geometry = Geometry(elements=count, element_diameter=share * 0.05, pitch_diameter=0.05)
    shaft = rng.uniform(8.0, 50.0)
    fault = str(rng.choice(list(BODIES)))
    strength = 10.0 ** rng.uniform(-0.7, 0.5)
    if healthy:
        fault_or_none, strength = (fault, 0.05) if rng.uniform() < 0.2 else (None, 0.0)
    else:
        fault_or_none = fault
    truth = synthetic_record(
        rng, geometry, shaft, fault_or_none, strength, speed_error=rng.uniform(-tolerance, tolerance),
        duration=duration, inverter=bool(rng.uniform() < 0.5),
    )  # fmt: skip
    return truth, geometry, shaft

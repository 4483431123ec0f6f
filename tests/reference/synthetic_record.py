"""Records whose truth is known: strikes through resonances, with slip, in the noise of a machine.

They are made of nothing that the diagnosis is made of, and have what measured records have and simulated ones lack:
speeds that are not the nominal ones, strikes that come early or late, lines of shaft and inverter, coloured noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from residual.measured.diagnosis import BODIES, SLIP, Geometry, side_of
from residual.measured.signals import Signal

LOAD_ZONE = 0.35  # of a turn, where an inner ring's or element's fault is struck
MOST_SHAFT = 4  # harmonics in the noise's own modulation


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """A record and what is in it."""

    signal: Signal
    alone: Signal  # without what a coupling adds
    fault: str | None  # "BPFO", "BPFI", "2×BSF"
    line: float  # Hz, of the fault, as it is
    sides: float  # Hz, spacing of its sidebands; 0: none
    shaft: float  # Hz, as it is


def synthetic_record(
    rng: np.random.Generator, geometry: Geometry, shaft: float, fault: str | None, strength: float, *,
    speed_error: float = 0.0, duration: float = 2.0, rate: float = 25_600.0, inverter: bool = True, drift: float = 0.0,
    jaws: int = 0, vibration: np.ndarray | None = None,
) -> Truth:  # fmt: skip
    """One record.

    Parameters
    ----------
    shaft : float, Hz, nominal; it turns by a share `speed_error` faster
    fault : name of the line of the damaged part; None: healthy
    strength : rms of the strikes over that of the noise without its tones
    drift : of the speed from begin to end, relative
    jaws : of a coupling that strikes so often in a turn; 0: none
    vibration : (n_times,), of a simulated bearing at that speed, in place of strikes made here
    """
    n, turning = int(duration * rate), shaft * (1.0 + speed_error)
    time = np.arange(n) / rate
    share = time / duration
    turned = share + 0.5 * drift * (share**2 - share)  # of all turns
    turn = turned * duration * turning
    lines = geometry.lines(turning)
    resonances = [(rng.uniform(0.1, 0.2) * rate, rng.uniform(0.02, 0.05)) for _ in range(2)]
    noise = rng.standard_normal(n)
    noise += 1.5 * _through(rng.standard_normal(n), rate, resonances)
    noise *= 1.0 + sum(
        rng.uniform(0.0, 0.15) / k * np.cos(2.0 * np.pi * k * turn + rng.uniform(0.0, 6.3))
        for k in range(1, MOST_SHAFT + 1)
    )
    noise /= noise.std()
    tones = sum(rng.uniform() / k * np.cos(2.0 * np.pi * k * turn + rng.uniform(0.0, 6.3)) for k in range(1, 9))
    if inverter:
        supply, carrier = turning * rng.choice([1, 2, 3]) * rng.uniform(1.005, 1.04), rng.uniform(2e3, 5e3)
        for k in range(1, 3):
            for m in range(-6, 7, 2):
                tone = k * carrier + m * supply
                tones += rng.uniform(0.0, 1.0) * np.cos(2.0 * np.pi * tone * time + rng.uniform(0.0, 6.3))
    values, coupling = noise + tones, np.zeros(n)
    if jaws:
        struck = np.interp(np.arange(1, int(turn[-1] * jaws)) / jaws, turn, time)
        struck += 1e-4 * rng.standard_normal(struck.size)
        train = _train(n, rate, struck, 1.0 + 0.2 * rng.standard_normal(struck.size))
        coupling = 10.0 ** rng.uniform(-0.7, 0.2) * _through(train, rate, resonances)
    line = sides = 0.0
    if fault is not None:
        line = lines[fault] * (1.0 + (rng.uniform(-SLIP, 0.3 * SLIP) if vibration is None else 0.0))
        sides = side_of(fault, lines)
    if vibration is not None:
        values += strength * np.interp(turned * duration, time, vibration) / vibration.std()
    elif fault is not None:
        struck, size = _strikes(rng, duration, line, sides)
        strikes = _through(_train(n, rate, np.interp(struck, turned * duration, time), size), rate, resonances)
        values += strength * strikes / strikes.std()
    scale = 10.0 ** rng.uniform(-1.0, 1.5)
    signal, alone = (
        Signal(name="synthetic", values=scale * (each - each.mean()), rate=rate, unit="m/s²")
        for each in (values + coupling, values)
    )
    return Truth(signal=signal, alone=alone, fault=fault, line=line, sides=sides, shaft=turning)


def _strikes(rng, duration, line, sides):
    """Times, s, of strikes that come early or late by slip, and their sizes, by a load zone if `sides` is above 0."""
    times = np.cumsum(1.0 / line * (1.0 + 0.007 * rng.standard_normal(int(1.1 * line * duration) + 3)))
    times = times[times < duration]
    times *= 1.0 + (times.size / line / times[-1] - 1.0)  # the mean rate is the line's
    size = 1.0 + 0.2 * rng.standard_normal(times.size)
    if sides:
        angle = np.mod(sides * times + rng.uniform(), 1.0)
        size *= np.maximum(0.05, np.cos(np.pi * np.minimum(1.0, np.abs(angle - 0.5) / LOAD_ZONE) / 2.0))
    return times, size


def _train(n, rate, times, size):
    """Pulses of sizes at times, s, (n,)."""
    train, index = np.zeros(n), np.rint(times * rate).astype(int)
    inside = (index >= 0) & (index < n)
    np.add.at(train, index[inside], size[inside])
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


class Run(NamedTuple):
    """A simulated bearing at a sensor."""

    geometry: Geometry
    shaft: float  # Hz
    fault: str | None
    vibration: np.ndarray  # (n_times,), m/s²
    rate: float  # Hz


def drawn(
    rng: np.random.Generator, healthy: bool, tolerance: float, duration: float = 2.0, runs: Sequence[Run] = ()
) -> tuple[Truth, Geometry, float]:
    """A record of a bearing, fault, strength and speed drawn by chance; its geometry and nominal shaft speed, Hz.

    Half of the speeds drift by up to 1 %, a third of the machines have a coupling with jaws that strikes. A fifth of
    healthy bearings have strikes too, so weak that they are no damage; that of a run vibrates as it does in 0.5 to 10
    m/s² of noise, damage up to twenty times less.
    """
    off = rng.uniform(-tolerance, tolerance)
    surroundings = dict(
        speed_error=off, inverter=bool(rng.uniform() < 0.5), drift=rng.uniform(-0.01, 0.01) * (rng.uniform() < 0.5),
        jaws=int(rng.integers(3, 6)) * (rng.uniform() < 0.33),
    )  # fmt: skip
    if runs:
        fitting = [run for run in runs if (run.fault is None) == healthy]
        run = fitting[rng.integers(len(fitting))]
        strength = run.vibration.std() / 10.0 ** rng.uniform(-0.3, 1.0) * (healthy or 10.0 ** rng.uniform(-1.3, 0.0))
        truth = synthetic_record(
            rng, run.geometry, run.shaft / (1.0 + off), run.fault, strength, duration=run.vibration.size / run.rate,
            rate=run.rate, vibration=run.vibration, **surroundings)  # fmt: skip
        return truth, run.geometry, run.shaft / (1.0 + off)
    count = int(rng.integers(7, 18))
    share = min(rng.uniform(0.12, 0.24), 0.8 * np.pi / count)
    geometry = Geometry(elements=count, element_diameter=share * 0.05, pitch_diameter=0.05)
    shaft, fault = rng.uniform(8.0, 50.0), str(rng.choice(list(BODIES)))
    strength = 10.0 ** rng.uniform(-0.7, 0.5)
    if healthy:
        fault, strength = (fault, 0.05) if rng.uniform() < 0.2 else (None, 0.0)
    return synthetic_record(rng, geometry, shaft, fault, strength, duration=duration, **surroundings), geometry, shaft

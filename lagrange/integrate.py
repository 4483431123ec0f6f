"""Time stepping from sample to sample, in pieces: how a run is cut into them changes no bit of it."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lagrange.contact_damping import ContactDamping
from lagrange.systems import Packed

# Blanes and Moan 2002, RKN scheme of order 4 with six stages: kicks b, drifts a, of which half are independent
KICKS = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)
DRIFTS = (0.245298957184271, 0.604872665711080)
ALL_KICKS = (*KICKS, 1.0 - 2.0 * sum(KICKS), *KICKS[::-1])
ALL_DRIFTS = (*DRIFTS, 0.5 - sum(DRIFTS), 0.5 - sum(DRIFTS), *DRIFTS[::-1])
BLOCK = 64  # samples whose directions are tabulated at a time
FARTHEST = 1e50  # m and m/s: energies of such a motion are still numbers


@dataclass(frozen=True, kw_only=True)
class Record:
    """Stored samples; the works are integrals taken along with the steps."""

    z: np.ndarray  # (n_times,)
    z_rate: np.ndarray
    q: np.ndarray  # (n_times, n_rollers)
    q_rate: np.ndarray
    held_work: np.ndarray  # J, of contacts and weights against the held angles; 0 where none are held
    ramp_work: np.ndarray  # J, minus the integral of the hub's place times the load's rate
    dissipated: np.ndarray  # J, by contacts' dampers
    by_dashpots: np.ndarray  # J, dissipated by what holds the shaft

    def sound(self) -> "Record":
        """The samples before the first whose motion is no number, or too large for its energies to be numbers."""
        motion = np.column_stack([self.z, self.z_rate, self.q, self.q_rate])
        with np.errstate(over="ignore", invalid="ignore"):
            lost = ~np.all(np.abs(motion) < FARTHEST, axis=1)
        count = int(np.argmax(lost)) if lost.any() else len(lost)
        return Record(**{name: values[:count] for name, values in vars(self).items()})


class Integration(ABC):
    """Steps of a system, `per_sample` of them from one sample to the next; the start is the first sample.

    `memory` is all that the next steps need, arrays that are changed in place: hub and elements, their rates and
    accelerations after the last step; the works of held angles, of the ramp, of the dampers and of dashpots, and the
    power that holds the angles. Before the first step accelerations and power are not known yet.
    """

    def __init__(self, system, start: Packed, step: float, per_sample: int, damping: ContactDamping):
        self._system, self._step, self._per_sample, self._damping = system, step, per_sample, damping
        self.done = 0  # samples
        self.memory = {
            "hub": np.array([start.z, start.z_rate, 0j]),
            "elements": np.array([start.q, start.q_rate, 0.0 * start.q], dtype=system.dtype),
            "works": np.zeros(5),
        }

    def advance(self, count: int) -> Record:
        """The next so many samples; fewer where numbers overflow."""
        z = np.empty((2, count), dtype=complex)
        q = np.empty((2, count, self._system.n), dtype=self._system.dtype)
        works = np.zeros((4, count))
        there = int(self.done == 0 < count)
        if there:
            hub, elements, sums = self.memory.values()
            z[:, 0], q[:, 0], works[:, 0] = hub[:2], elements[:2], sums[:4]
        there += self._fill(self.done + there, z[:, there:], q[:, there:], works[:, there:])
        record = Record(
            z=z[0, :there], z_rate=z[1, :there], q=q[0, :there], q_rate=q[1, :there],
            held_work=works[0, :there], ramp_work=works[1, :there], dissipated=works[2, :there],
            by_dashpots=works[3, :there],
        ).sound()  # fmt: skip
        self.done += len(record.z)
        return record

    @abstractmethod
    def _fill(self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray) -> int:
        """Take the steps to the samples after `done`, fill these arrays with them, and keep the memory.

        Parameters
        ----------
        z, q : ndarray, (2, n_times) and (2, n_times, n_rollers), of hub and elements, and their rates
        works : ndarray, (4, n_times), J, of held angles, of the ramp, of the dampers and of dashpots

        Returns
        -------
        Samples filled: fewer where the last is no number any more.
        """


class NumpyIntegration(Integration):
    """Steps in plain numpy."""

    def __init__(self, system, start: Packed, step: float, per_sample: int, damping: ContactDamping):
        super().__init__(system, start, step, per_sample, damping)
        self._advance = self._leapfrog if damping.acts or system.has_dashpots else self._blanes_moan

    def _fill(self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray) -> int:
        hub, elements, sums = self.memory.values()
        there, count = 0, z.shape[1]
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # seen by `Record.sound`
            while there < count and np.isfinite(hub[0]):
                last = done + there - 1
                border = last - last % BLOCK + BLOCK
                for _ in self._advance(last, min(border, done + count - 1)):
                    z[:, there], q[:, there], works[:, there] = hub[:2], elements[:2], sums[:4]
                    there += 1
        return there

    def _remembered(self) -> tuple[list[complex], np.ndarray, list[float]]:
        """The memory as the steps take it: Python's own numbers are faster."""
        hub, elements, works = self.memory.values()
        return hub.tolist(), elements.copy(), works.tolist()

    def _remember(self, *values) -> None:
        for kept, now in zip(self.memory.values(), values, strict=True):
            kept[:] = now

    def _blanes_moan(self, first: int, last: int) -> Iterator[None]:
        """Six-stage symplectic steps of fourth order from one sample to another; stops at each in between."""
        system, step, per_sample = self._system, self._step, self._per_sample
        at = np.cumsum(ALL_DRIFTS)
        steps = np.arange(first * per_sample, last * per_sample)
        times = step * (steps[:, None] + at).ravel()
        turns = system.directions(times)
        times = times.tolist()
        whole = np.ones(system.n, dtype=system.dtype)
        pairs = [
            (step * a, step * a * whole, step * b, step * b * whole)
            for a, b in zip(ALL_DRIFTS, ALL_KICKS[1:], strict=True)
        ]
        begin, begin_all = step * ALL_KICKS[0], step * ALL_KICKS[0] * whole
        (z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power) = self._remembered()
        accelerations, ramping = system.accelerations, system.load_changes
        if first % BLOCK == 0:  # anew, at a time without the round-off of the stages' sum
            time = step * first * per_sample
            z_acc, q_acc, power = accelerations(time, z, q, system.directions(np.array([time]))[0])
        else:
            time = step * (first * per_sample - 1 + float(at[-1]))
        i = 0
        for _ in range(first, last):
            for _ in range(per_sample):
                z_rate = z_rate + begin * z_acc
                q_rate = q_rate + begin_all * q_acc
                held += begin * power
                if ramping:
                    ramped += begin * system.change_power(time, z)
                for drift, drift_all, kick, kick_all in pairs:
                    z = z + drift * z_rate
                    q = q + drift_all * q_rate
                    time = times[i]
                    z_acc, q_acc, power = accelerations(time, z, q, turns[i])
                    i += 1
                    z_rate = z_rate + kick * z_acc
                    q_rate = q_rate + kick_all * q_acc
                    held += kick * power
                    if ramping:
                        ramped += kick * system.change_power(time, z)
            self._remember((z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power))
            yield

    def _leapfrog(self, first: int, last: int) -> Iterator[None]:
        """Drift, kick, damp, kick, drift; second order.

        The contacts' dampers flow by the midpoint rule at frozen positions, the shaft's dashpots exactly in the kicks.
        """
        system, step, per_sample, damping = self._system, self._step, self._per_sample, self._damping
        steps = np.arange(first * per_sample, last * per_sample)
        times = step * (steps + 0.5)
        turns = system.directions(times)
        times = times.tolist()
        (z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power) = self._remembered()
        half = 0.5 * step
        i = 0
        for _ in range(first, last):
            for _ in range(per_sample):
                z = z + half * z_rate
                q = q + half * q_rate
                z_acc, q_acc, power = system.accelerations(times[i], z, q, turns[i])
                z_rate, q_rate, loss = self._half_kick(z_rate, z_acc, q_rate, q_acc, half)
                dashed += loss
                held += step * power
                if system.load_changes:
                    ramped += step * system.change_power(times[i], z)
                if damping.acts:
                    dampers = system.damper_coefficients(damping)
                    z_slow, q_slow, _, _ = system.damper(z_rate, q_rate, q, z, turns[i], dampers)
                    z_slow, q_slow, loss, taken = system.damper(
                        z_rate + half * z_slow, q_rate + half * q_slow, q, z, turns[i], dampers
                    )
                    z_rate, q_rate = z_rate + step * z_slow, q_rate + step * q_slow
                    lost += step * loss
                    held += step * taken
                z_rate, q_rate, loss = self._half_kick(z_rate, z_acc, q_rate, q_acc, half)
                dashed += loss
                z = z + half * z_rate
                q = q + half * q_rate
                i += 1
            self._remember((z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power))
            yield

    def _half_kick(self, z_rate, z_acc, q_rate, q_acc, seconds: float):
        """Velocities of hub and elements after a kick, the dashpots with it, and what these take, J."""
        z_rate, q_rate, loss = z_rate + seconds * z_acc, q_rate + seconds * q_acc, 0.0
        if self._system.has_dashpots:
            z_rate, loss = self._system.slowed(z_rate, z_acc, seconds)
        return z_rate, q_rate, loss

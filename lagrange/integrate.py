"""Time stepping from sample to sample, in pieces: how a run is cut into them changes no bit of it."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lagrange.cage_motion import first_row, row_width
from lagrange.cage_steps import CageSteps
from lagrange.contact.damping import ContactDamping
from lagrange.step_size import Steps, near_faults
from lagrange.systems import Packed

# Blanes and Moan 2002, RKN scheme of order 4 with six stages: kicks b, drifts a, of which half are independent
KICKS = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)
DRIFTS = (0.245298957184271, 0.604872665711080)
ALL_KICKS = (*KICKS, 1.0 - 2.0 * sum(KICKS), *KICKS[::-1])
LEAP_KICKS, LEAP_DRIFTS = (0.5, 0.5), (1.0,)  # of second order; better for its costs where steps follow a profile
ALL_DRIFTS = (*DRIFTS, 0.5 - sum(DRIFTS), 0.5 - sum(DRIFTS), *DRIFTS[::-1])
BLOCK = 64  # samples whose directions are tabulated at a time
MOTION = "hub", "elements", "works", "housing"  # of `Integration.memory`
OF_CAGE = "cage."  # begins names in it of a free cage's arrays, which kinds of steps have of their own
FARTHEST = 1e50  # m and m/s: energies of such a motion are still numbers


@dataclass(frozen=True, kw_only=True)
class Record:
    """Stored samples; the works are integrals taken along with the steps."""

    z: np.ndarray  # (n_times,), or in a housing that moves (n_times, 2): from the outer ring's centre, and that
    z_rate: np.ndarray
    q: np.ndarray  # (n_times, n_rollers)
    q_rate: np.ndarray
    held_work: np.ndarray  # J, of contacts and weights against the held angles; 0 where none are held
    ramp_work: np.ndarray  # J, minus the integral of the hub's place times the load's rate
    dissipated: np.ndarray  # J, by contacts' dampers
    by_dashpots: np.ndarray  # J, dissipated by what holds shaft and housing
    sensor: np.ndarray  # (n_times, 2), r, m, and ṙ, m/s, of a sensor on the housing
    cage: np.ndarray  # (n_times, width), of a free cage, see `cage_motion.CageRows`; no columns without one

    def sound(self) -> "Record":
        """The samples before the first whose motion is no number, or too large for its energies to be numbers."""
        motion = np.column_stack([self.z, self.z_rate, self.q, self.q_rate])  # of one or of two columns each
        with np.errstate(over="ignore", invalid="ignore"):
            lost = ~np.all(np.abs(motion) < FARTHEST, axis=1)
        count = int(np.argmax(lost)) if lost.any() else len(lost)
        return Record(**{name: values[:count] for name, values in vars(self).items()})


class Integration(ABC):
    """Steps of a system from one sample to the next, `interval` s apart; the start is the first sample.

    `memory` is all that the next steps need, arrays that are changed in place: hub and elements, their rates and
    accelerations after the last step; the works of held angles, of the ramp, of the dampers and of dashpots, and the
    power that holds the angles; of a housing its sensor's motion and what `lagrange.in_housing` calls S. Before the
    first step accelerations and power are not known yet.
    """

    def __init__(self, system, start: Packed, interval: float, steps: Steps, damping: ContactDamping):
        self._system, self._steps, self._damping = system, steps, damping
        self._section = interval / steps.sections
        self.done = 0  # samples
        self.memory = {
            "hub": np.array([start.z, start.z_rate, 0.0 * start.z], dtype=complex),
            "elements": np.array([start.q, start.q_rate, 0.0 * start.q], dtype=system.dtype),
            "works": np.zeros(5),
            "housing": np.zeros(4),
        }

    def advance(self, count: int) -> Record:
        """The next so many samples; fewer where numbers overflow."""
        z = np.empty((2, count, *self.memory["hub"].shape[1:]), dtype=complex)
        sensor = np.zeros((count, 2))
        q = np.empty((2, count, self._system.n), dtype=self._system.dtype)
        works = np.zeros((4, count))
        there = int(self.done == 0 < count)
        cage = np.empty((count, row_width(self._system.n, self._system.problem.free_cage)))
        if there:
            hub, elements, sums, senses = (self.memory[name] for name in MOTION)
            z[:, 0], q[:, 0], works[:, 0], sensor[0] = hub[:2], elements[:2], sums[:4], senses[:2]
            if cage.size:
                cage[0] = first_row(self._system.n, self._system.cage)
        empty = z[:, there:], q[:, there:], works[:, there:], sensor[there:], cage[there:]
        there += self._fill(self.done + there, *empty)
        record = Record(
            z=z[0, :there], z_rate=z[1, :there], q=q[0, :there], q_rate=q[1, :there],
            held_work=works[0, :there], ramp_work=works[1, :there], dissipated=works[2, :there],
            by_dashpots=works[3, :there], sensor=sensor[:there], cage=cage[:there],
        ).sound()  # fmt: skip
        self.done += len(record.z)
        return record

    def _near(self, done: int, count: int) -> np.ndarray:
        """Whether contacts are near faults in the sections of so many samples after `done`, (count, sections)."""
        sections, steps = self._steps.sections, self._steps
        if not steps.looks:
            return np.ones((count, sections), dtype=bool)
        found = near_faults(self._system.problem, (done - 1) * sections, count * sections, self._section)
        return found.reshape(count, sections)

    @property
    def _scheme(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Kicks and drifts of a step without damping."""
        return (LEAP_KICKS, LEAP_DRIFTS) if self._steps.leaps else (ALL_KICKS, ALL_DRIFTS)

    @abstractmethod
    def _fill(
        self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray, sensor: np.ndarray, cage: np.ndarray
    ) -> int:
        """Take the steps to the samples after `done`, fill these arrays with them, and keep the memory.

        Parameters
        ----------
        z, q : ndarray, (2, n_times) and (2, n_times, n_rollers), of hub and elements, and their rates
        works : ndarray, (4, n_times), J, of held angles, of the ramp, of the dampers and of dashpots
        sensor : ndarray, (n_times, 2)
        cage : ndarray, (n_times, width), of a free cage

        Returns
        -------
        Samples filled: fewer where the last is no number any more.
        """


class NumpyIntegration(Integration):
    """Steps in plain numpy."""

    def __init__(self, system, start: Packed, interval: float, steps: Steps, damping: ContactDamping):
        super().__init__(system, start, interval, steps, damping)
        cage = system.problem.free_cage
        leaps = damping.acts or system.has_dashpots or cage is not None
        self._advance = self._leapfrog if leaps else self._composed
        step = self._section / steps.near  # where elements are free all steps are equal
        self._cage = None
        if cage is not None:
            ring = complex(np.asarray(start.z)[1]) if np.ndim(start.z) else 0j
            self._cage = CageSteps(system, cage, step, ring)
            self.memory |= {f"{OF_CAGE}{name}": array for name, array in self._cage.memory.items()}
        sensor = system.problem.operation.mounting.sensor
        self._sensor_steps = None if sensor is None else {n: sensor.step(self._section / n) for n in {*steps.counts}}

    def _fill(
        self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray, sensor: np.ndarray, cage: np.ndarray
    ) -> int:
        hub, elements, sums, senses = (self.memory[name] for name in MOTION)
        there, count = 0, z.shape[1]
        near = self._near(done, count)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # seen by `Record.sound`
            while there < count and np.all(np.isfinite(hub[0])):
                last = done + there - 1
                border = min(last - last % BLOCK + BLOCK, done + count - 1)
                for _ in self._through(last, border, near[there:]):
                    z[:, there], q[:, there], works[:, there] = hub[:2], elements[:2], sums[:4]
                    sensor[there] = senses[:2]
                    if self._cage is not None:
                        cage[there] = self._cage.row(*hub[:2])
                    there += 1
        return there

    def _through(self, first: int, last: int, near: np.ndarray) -> Iterator[None]:
        """Steps from one sample to another, with contacts near faults or not in the sections; stops at each sample."""
        sections = self._steps.sections
        if near.all():  # turns of many steps are tabulated at once
            for at, _ in enumerate(self._advance(first * sections, last * sections, True), 1):
                if at % sections == 0:
                    yield
            return
        for sample in range(first, last):
            for k in range(sections):
                at = sample * sections + k
                for _ in self._advance(at, at + 1, bool(near[sample - first, k])):
                    pass
            yield

    def _remembered(self) -> tuple[list[complex], np.ndarray, list[float]]:
        """The memory as the steps take it: Python's own numbers are faster."""
        hub, elements, works, housing = (self.memory[name] for name in MOTION)
        self._system.shift = complex(*housing[2:])
        return hub.tolist() if hub.ndim == 1 else list(hub.copy()), elements.copy(), works.tolist()

    def _remember(self, *values) -> None:
        for name, now in zip(("hub", "elements", "works"), values, strict=True):
            self.memory[name][:] = now
        self.memory["housing"][2:] = self._system.shift.real, self._system.shift.imag

    def _sense(self, before, after, count: int) -> None:
        """Move a sensor on by one of so many steps of a section, in which the housing's velocity, the second one, has
        changed so."""
        if self._sensor_steps is not None:
            acceleration = (after[1] - before[1]).imag * count / self._section
            motion = self.memory["housing"][:2]
            motion[:] = self._sensor_steps[count] @ [*motion, acceleration]

    def _composed(self, first: int, last: int, near: bool) -> Iterator[None]:
        """Symplectic steps from one section's begin to another's; stops at the end of each."""
        system, count = self._system, self._steps.near if near else self._steps.far
        step = self._section / count
        kicks, drifts = self._scheme
        at = np.cumsum(drifts)
        steps = np.arange(first * count, last * count)
        times = step * (steps[:, None] + at).ravel()
        turns = system.directions(times)
        times = times.tolist()
        whole = np.ones(system.n, dtype=system.dtype)
        pairs = [
            (step * a, step * a * whole, step * b, step * b * whole) for a, b in zip(drifts, kicks[1:], strict=True)
        ]
        begin, begin_all = step * kicks[0], step * kicks[0] * whole
        (z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power) = self._remembered()
        accelerations, ramping, carries = system.accelerations, system.load_changes, system.carries
        if first % (BLOCK * self._steps.sections) == 0:  # anew, at a time without the round-off of the stages' sum
            time = step * first * count
            z_acc, q_acc, power = accelerations(time, z, q, system.directions(np.array([time]))[0])
        else:
            time = step * (first * count - 1 + float(at[-1]))
        i = 0
        for _ in range(first, last):
            for _ in range(count):
                before = z_rate
                z_rate = z_rate + begin * z_acc
                q_rate = q_rate + begin_all * q_acc
                held += begin * power
                if carries:
                    held += begin * system.carried_power(z_rate, z_acc, begin)
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
                    if carries:
                        held += kick * system.carried_power(z_rate, z_acc, kick)
                    if ramping:
                        ramped += kick * system.change_power(time, z)
                self._sense(before, z_rate, count)
            self._remember((z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power))
            yield

    def _leapfrog(self, first: int, last: int, near: bool) -> Iterator[None]:
        """Drift, kick, damp, kick, drift; second order.

        The contacts' dampers flow by the midpoint rule at frozen positions, the shaft's dashpots exactly in the kicks;
        a free cage's dashpots and friction end the kick.
        """
        cage = self._cage
        system, damping, count = self._system, self._damping, self._steps.near if near else self._steps.far
        step = self._section / count
        steps = np.arange(first * count, last * count)
        times = step * (steps + 0.5)
        turns = system.directions(times)
        times = times.tolist()
        (z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power) = self._remembered()
        half = 0.5 * step
        i = 0
        for _ in range(first, last):
            for _ in range(count):
                before = z_rate
                z = z + half * z_rate
                q = q + half * q_rate
                z_acc, q_acc, power = system.accelerations(times[i], z, q, turns[i])
                if cage is not None:
                    cage.drift(half)
                    z_rate, q_rate = cage.meet(z, z_rate, q, q_rate)
                z_rate, q_rate, loss, taken = self._half_kick(z_rate, z_acc, q_rate, q_acc, half)
                dashed += loss
                held += step * power + taken
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
                z_rate, q_rate, loss, taken = self._half_kick(z_rate, z_acc, q_rate, q_acc, half)
                dashed += loss
                held += taken
                if cage is not None:
                    z_rate, q_rate, taken = cage.rub(z_rate, q_rate)
                    held += taken
                    cage.drift(half)
                self._sense(before, z_rate, count)
                z = z + half * z_rate
                q = q + half * q_rate
                i += 1
            self._remember((z, z_rate, z_acc), (q, q_rate, q_acc), (held, ramped, lost, dashed, power))
            yield

    def _half_kick(self, z_rate, z_acc, q_rate, q_acc, seconds: float):
        """Velocities of hub and elements after a kick, the dashpots with it; what these take, and held angles, J."""
        system = self._system
        z_rate, q_rate, loss, taken = z_rate + seconds * z_acc, q_rate + seconds * q_acc, 0.0, 0.0
        if system.carries:
            taken = seconds * system.carried_power(z_rate, z_acc, seconds)
        if system.has_dashpots:
            z_rate, q_rate, loss, more = system.slowed(z_rate, z_acc, q_rate, seconds)
            taken += more
        return z_rate, q_rate, loss, taken

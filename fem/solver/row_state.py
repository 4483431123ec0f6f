"""States that a compiled time loop advances, writing rows that are looked at as they come."""

import time
from abc import abstractmethod

import numpy as np

from fem.kernels.bodies import DONE
from fem.kernels.fields import kind_of
from fem.solver.guards import (
    ASTRAY,
    DOUBTFUL,
    energy_trouble,
    good_rows,
    largest_forces,
    n_balanced,
    n_in_place,
    place_trouble,
    run_warnings,
)
from fem.solver.samples import SampleReader
from fem.solver.simulate import LARGEST_BLOCK, size_of_block
from fem.solver.solver import Block, Numbers, Plan, RunState, Samples
from lagrange.errors import UsageError

LONGEST_UNWATCHED = 100  # steps between two looks at the energy


class RowState(RunState):
    """Arrays that kernels change in place, and the reader of their rows.

    Its plan has `looks` at the energy per sample, `stride` steps between samples, and what `guards` ask of it.
    """

    def __init__(self, plan: Plan):
        super().__init__(plan)
        self.reader = SampleReader(plan)
        self._largest = np.zeros(3)  # N, so far: see `largest_forces`
        self._missed, self._passed_on = 0.0, 0.0  # J, the largest energy error so far, and what it is measured by
        self._came_apart = False  # whether the last block ended because bodies were out of place

    @property
    def steps_per_sample(self) -> int:
        return self.plan.stride

    @abstractmethod
    def named_arrays(self) -> dict[str, np.ndarray]:
        """All arrays that a run changes and the next steps need, as views."""

    @abstractmethod
    def digest(self) -> str:
        """Of all that the steps need and no run changes."""

    @abstractmethod
    def step_rows(self, first: int, stride: int, rows: np.ndarray) -> tuple[int, int, int]:
        """From step `first` on fill rows, one each `stride` steps: the kernel's status, and step and body where it is
        not DONE."""

    def check(self) -> None:
        """Refuse arrays that kernels can't take. ValueError."""

    def frame(self):
        """The fields at the next sample, which the scene asks for."""
        return None

    def take_steps(self, n_rows: int, before: int = 0) -> tuple[np.ndarray, int, int, int]:
        """Advance the arrays by so many rows: them, the kernel's status, and step and body where it is not DONE.

        `before`: rows since the last sample.
        """
        plan = self.plan
        rows, stride = np.zeros((n_rows, self.reader.width)), plan.stride // plan.looks
        return rows, *self.step_rows(self.done * plan.stride + before * stride, stride, rows)

    def _take_long_sample(self) -> tuple[np.ndarray, int, int, int] | None:
        """One sample in parts, between which the run can be stopped: then None, and the arrays are as before."""
        looks, kept = self.plan.looks, {name: array.copy() for name, array in self.named_arrays().items()}
        whole, done, size = np.zeros((looks, self.reader.width)), 0, 1
        while True:
            began = time.perf_counter()
            rows, status, step, body = self.take_steps(min(size, looks - done), done)
            whole[done : done + len(rows)] = rows
            done += len(rows)
            if status != DONE or done == looks:
                return whole[:done], status, step, body
            if self.stop():
                for name, array in self.named_arrays().items():
                    array[...] = kept[name]
                return None
            size = size_of_block(size, len(rows), time.perf_counter() - began)

    def advance(self, most: int) -> Block:
        plan, frame = self.plan, None
        most = min(most, LARGEST_BLOCK // plan.looks or 1)
        if plan.frame_stride:  # between two samples the state is that of the one to come
            since = self.done % plan.frame_stride
            most = min(most, plan.frame_stride - since)
            if since == 0:
                frame = self.frame()
        with self.timed():
            taken = self._take_long_sample() if most == 1 < plan.looks else self.take_steps(plan.looks * most)
        if taken is None:
            return Block()
        rows, status, step, body = taken
        samples, trouble, self._came_apart = None, None, False
        if status != DONE:
            rows = rows[: good_rows(rows)]
            trouble = self.velocity_trouble(step, body, len(rows))
        if len(rows):
            looked = self.read(rows)
            count, trouble = self.sound_part(looked, trouble)
            sound = looked.first(count)
            self._largest = np.maximum(self._largest, largest_forces(sound))
            if count:
                self._missed = max(self._missed, float(np.abs(sound.error).max()))
                self._passed_on = float(sound.passed_on[-1])
            samples = sound.every(plan.looks)
            self.done += len(samples)
        return Block(samples=samples, frame=frame, trouble=trouble)

    def read(self, rows: np.ndarray) -> Samples:
        """Quantities of the next rows."""
        return self.reader.read(rows)

    def velocity_trouble(self, step: int, body: int, n_good: int) -> str:
        """What to say of a velocity that is no number, of a roller or the hub (below 0), after so many good rows."""
        plan, name = self.plan, "the hub" if body < 0 else f"roller {body}"
        hint = f"{plan.model.failure_hint}lower numerics.time_step_safety or check the load"
        return f"the velocity of {name} is not finite at step {step}, t = {1e3 * step * plan.time_step:.5g} ms; {hint}"

    def sound_part(self, looked: Samples, trouble: str | None) -> tuple[int, str | None]:
        """How many of the next samples are sound, and why no more are; `trouble` : after all of them."""
        plan, bearing = self.plan, self.plan.model.bearing
        give = ASTRAY * bearing.roller_radius + plan.model.give(plan.operation.heaviest)
        balanced, in_place = n_balanced(looked), n_in_place(bearing, give, looked)
        self.imbalance = float(looked.relative_error()[min(balanced, len(looked) - 1)])
        self._came_apart = in_place < balanced
        if self._came_apart:
            trouble = place_trouble(plan, looked, in_place)
        elif balanced < len(looked):
            trouble = energy_trouble(plan, looked, balanced)
        return min(balanced, in_place), trouble

    @property
    def warnings(self) -> tuple[str, ...]:
        wide, missed, passed_on = run_warnings(self.plan.model.bearing, self._largest), self._missed, self._passed_on
        if missed <= DOUBTFUL * passed_on:
            return wide
        return (
            *wide,
            f"the energy balance is off by up to {100.0 * missed / passed_on:.2g} % of what is exchanged "
            f"({1e3 * passed_on:.3g} mJ): the motion may be off by as much; {self.plan.finer}",
        )

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays = self.named_arrays() | {f"reader.{name}": value for name, value in self.reader.to_keep().items()}
        numbers = {"model": self.digest(), "missed": self._missed, "passed_on": self._passed_on}
        return arrays | {"largest": self._largest}, numbers

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        if numbers["model"] != self.digest():
            raise UsageError(
                "its meshes and matrices are not those computed here; go on where it was written, or start again "
                "without --resume"
            )
        for name, own in self.named_arrays().items():
            own[...] = arrays[name]
        self.check()
        if np.any(arrays["largest"] < 0.0):
            raise ValueError("forces that pull")
        self._largest = arrays["largest"]
        self._missed, self._passed_on = float(numbers["missed"]), float(numbers["passed_on"])
        self.reader.take_back({name: arrays[f"reader.{name}"] for name in self.reader.to_keep()}, self.done)


def changing_arrays(group: tuple, place: str) -> dict[str, np.ndarray]:
    """Every array of a named tuple, and of those in it, that a run changes, by where it stands."""
    found: dict[str, tuple[np.ndarray, bool]] = {}
    collect_arrays(group, place, found)
    return {name: array for name, (array, given) in found.items() if not given}


def collect_arrays(group: tuple, place: str, found: dict[str, tuple[np.ndarray, bool]]) -> None:
    """By the fields' declarations; an array without one is given if it holds places in arrays, whole numbers."""
    for name, entry in zip(getattr(group, "_fields", range(len(group))), group, strict=True):
        if isinstance(entry, np.ndarray):
            kind = kind_of(group, name) or ("state" if entry.dtype.kind == "f" else "given")
            if kind != "room" and not any(entry is other for other, _ in found.values()):
                found[f"{place}.{name}"] = entry, kind == "given"
        elif isinstance(entry, tuple):
            collect_arrays(entry, f"{place}.{name}", found)

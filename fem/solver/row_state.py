"""States that a compiled time loop advances, writing rows that are looked at as they come."""

import time
from abc import abstractmethod

import numpy as np

from fem.kernels import time_loop
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.solver.guards import energy_trouble, good_rows, n_balanced, n_in_place, place_trouble, velocity_trouble
from fem.solver.samples import SampleReader
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import Block, Numbers, Plan, RunState

LONGEST_UNWATCHED = 100  # steps between two looks at the energy


class RowState(RunState):
    """Arrays that kernels change in place, and the reader of their rows.

    Its plan has `looks` at the energy per sample, `stride` steps between samples, and what `guards` ask of it.
    """

    def __init__(self, plan: Plan):
        super().__init__(plan)
        self.reader = SampleReader(plan)

    @property
    def steps_per_sample(self) -> int:
        return self.plan.stride

    @abstractmethod
    def named_arrays(self) -> dict[str, np.ndarray]:
        """All arrays that the next steps need, as views."""

    @abstractmethod
    def step_rows(self, rows: np.ndarray) -> tuple[int, int, int]:
        """Advance by so many rows and fill them: the kernel's status, and step and body where it is not DONE."""

    def frame(self):
        """The fields at the next sample, which the scene asks for."""
        return None

    def take_steps(self, n_rows: int) -> tuple[np.ndarray, int, int, int]:
        """Advance the arrays by so many rows: them, the kernel's status, and step and body where it is not DONE."""
        rows = np.zeros((n_rows, N_SCALARS + len(BLOCKS) * self.plan.model.bearing.n_rollers))
        return rows, *self.step_rows(rows)

    def advance(self, most: int) -> Block:
        plan, frame = self.plan, None
        most = min(most, LARGEST_BLOCK // plan.looks or 1)
        if plan.frame_stride:  # between two samples the state is that of the one to come
            since = self.done % plan.frame_stride
            most = min(most, plan.frame_stride - since)
            if since == 0:
                frame = self.frame()
        began = time.perf_counter()
        rows, status, step, body = self.take_steps(plan.looks * most)
        self.wall += time.perf_counter() - began
        samples, trouble = None, None
        if status != time_loop.DONE:
            rows, trouble = rows[: good_rows(rows)], velocity_trouble(plan, step, body)
        if len(rows):
            looked = self.reader.read(rows)
            balanced, in_place = n_balanced(looked), n_in_place(plan, looked)
            self.imbalance = float(looked.relative_imbalance()[min(balanced, len(looked) - 1)])
            samples = looked.first(min(balanced, in_place)).every(plan.looks)
            self.done += len(samples)
            if in_place < balanced:
                trouble = place_trouble(plan, looked, in_place)
            elif balanced < len(rows):
                trouble = energy_trouble(plan, looked, balanced)
        return Block(samples=samples, frame=frame, trouble=trouble)

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        return self.named_arrays() | {f"reader.{name}": value for name, value in self.reader.to_keep().items()}, {}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        for name, own in self.named_arrays().items():
            own[...] = arrays[name]
        self.reader.take_back({name: arrays[f"reader.{name}"] for name in self.reader.to_keep()})

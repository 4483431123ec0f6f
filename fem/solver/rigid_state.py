"""A run of rigid bodies in their time loop, whatever their contacts."""

import hashlib
from abc import abstractmethod
from dataclasses import replace

import numpy as np

from fem.kernels.fields import filled
from fem.kernels.rigid.loop import advance_rigid
from fem.kernels.rigid.state import Before, ReducedDrive, ReducedForces, RigidBodies
from fem.solver.rigid_arrays import paces_of
from fem.solver.row_state import RowState
from fem.solver.run_arrays import changing_arrays
from fem.solver.samples import SampleReader
from fem.solver.solver import Block, Numbers, Progress, Samples
from fem.solver.tilted_arrays import LESS, beyond_tables

MOST_DOUBLINGS = 4  # of the force that tables go to


class RigidState(RowState):
    """Rigid bodies and contacts. A run whose steps turn out too long restarts with half of them, one whose contacts
    leave their tables with tables up to twice the force.

    Its plan has `halved(times)`, the same with so many halvings of the step, `reaching(times)`, the same whose tables
    of contacts that tilt go to so many times the force, and `sections` of two step lengths.
    """

    most_halvings: int

    def __init__(self, plan):
        super().__init__(plan)
        self._whole, self._halvings, self._doublings = plan, 0, 0
        self._begin()

    @abstractmethod
    def arrays_of(self, plan) -> tuple[RigidBodies, tuple, ReducedForces, ReducedDrive]:
        """Bodies, contacts and their forces, and what acts from outside, at a plan's start."""

    def _begin(self) -> None:
        self.plan = plan = self._whole.reaching(2**self._doublings).halved(self._halvings)
        self.reader = SampleReader(plan)
        self._largest, self._missed, self._passed_on = np.zeros(3), 0.0, 0.0
        self.bodies, self.contacts, self.forces, self.drive = self.arrays_of(plan)
        self.drives, self.paces = paces_of(plan, self.drive)
        self._before = filled(Before, {"columns": self.bodies.columns})

    def advance(self, most: int) -> Block:
        block = super().advance(most)
        tables = () if self.contacts.tilted is None else self.contacts.tilted.tables
        if block.trouble is None and (beyond := beyond_tables(self.bodies.tilts, tables)) is not None:
            return self._further(block, beyond)
        return self.judged(block)

    @abstractmethod
    def judged(self, block: Block) -> Block:
        """The block, or the restart that it takes."""

    def _further(self, block: Block, beyond: str) -> Block:
        """The restart with tables that go further, or the end where they cannot."""
        reason = LESS if self._doublings == MOST_DOUBLINGS else self.plan.too_far(2 ** (self._doublings + 1))
        if reason is not None:
            return replace(block, trouble=f"{beyond}; {reason}")
        self._doublings += 1
        return self._again(block.samples, f"{beyond}; the run restarts with tables up to twice the force")

    @property
    def may_restart(self) -> bool:
        """Whether a halving is left."""
        return self._halvings < self.most_halvings

    def restart(self, samples: Samples | None, reason: str) -> Block:
        """The block that makes all samples so far void, of a run that is at its start again with half the step."""
        self._halvings += 1
        return self._again(samples, f"{reason}; the run restarts with half of it")

    def _again(self, samples: Samples | None, why: str) -> Block:
        self.void_steps += self.progress.steps
        self.done, self.imbalance = 0, 0.0
        self._begin()
        return Block(samples=samples, restarts=why)

    def step_rows(self, first: int, stride: int, rows: np.ndarray) -> tuple[int, int, int]:
        moving = self.bodies, self.contacts, self.forces, self._before
        return advance_rigid(moving, self.drives, self.paces, first // stride, stride, rows)

    @property
    def progress(self) -> Progress:
        found = super().progress
        if self.paces is None:
            return found
        made = int(self.paces.made.sum())
        left = round(found.steps_left * made / found.steps) if found.steps else round(self.plan.steps)
        speed = (self.void_steps + made) / found.wall if found.wall > 0.0 else 0.0
        return replace(found, steps=made, steps_left=left, speed=speed)

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        found = super().outcome_attributes | {"time_step": self.plan.time_step}
        return found if self.paces is None else found | {"long_step": self.plan.long_step}

    def named_arrays(self) -> dict[str, np.ndarray]:
        found: dict[str, np.ndarray] = {}
        for place, group in (("bodies", self.bodies), ("forces", self.forces), ("drive", self.drive)):
            found |= changing_arrays(group, place)
        return found if self.paces is None else found | {"paces.now": self.paces.now, "paces.made": self.paces.made}

    @property
    def fixed(self) -> tuple:
        """Compliances of the contacts, without surfaces, which follow from the scene that checkpoints hold."""
        return self.contacts._replace(ring_profiles=(), roller_profiles=())

    def digest(self) -> str:
        return hashlib.sha256(np.concatenate([*_numbers(self.fixed)]).tobytes()).hexdigest()

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = super().to_keep()
        return arrays, numbers | self.restarts

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        self.take_restarts(numbers)
        super().take_back(arrays, numbers)

    @property
    def restarts(self) -> Numbers:
        """How often the run has restarted, by reason."""
        return {"halvings": self._halvings, "doublings": self._doublings}

    def take_restarts(self, numbers: Numbers) -> None:
        """Stand at the start with the step and the tables that another state of the same plan had."""
        halvings, doublings = int(numbers["halvings"]), int(numbers["doublings"])
        if not (0 <= halvings <= self.most_halvings and 0 <= doublings <= MOST_DOUBLINGS):
            raise ValueError(f"{halvings} halvings of the step, {doublings} doublings of tables")
        self._halvings, self._doublings = halvings, doublings
        self._begin()


def _numbers(group: tuple):
    """Every number of a tuple and of those in it, in order."""
    for entry in group:
        if isinstance(entry, tuple):
            yield from _numbers(entry)
        else:
            yield np.ravel(np.asarray(entry, dtype=float))

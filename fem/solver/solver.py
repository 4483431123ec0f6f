"""What every solver answers: a plan, its first state, samples block by block, and what a checkpoint keeps.

A solver is a module with `make_plan(scene)` that gives a `Plan`; `simulate.SOLVERS` names it. The runner, the result
file, checkpoints and the command know solvers by nothing else.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, KeysView, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lagrange import Bearing, Operation
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene
from lagrange.surface.faults import Spall

if TYPE_CHECKING:
    from rich.table import Table

ROUND_OFF = 1e-9  # of the kinetic energy, no imbalance: a bearing without load exchanges next to nothing
OF_ENERGY = "imbalance", "exchanged", "error"  # of `Samples`
Numbers = dict[str, object]  # what a line of JSON holds


@dataclass(frozen=True, kw_only=True)
class Samples:
    """A block of samples: arrays by the result file's names, time first; SI."""

    values: dict[str, np.ndarray]
    imbalance: np.ndarray  # (n,), J: stored energy less what came in, since the start
    exchanged: np.ndarray  # (n,), J, the most so far of elastic and contact energy, or of the kinetic energy's change
    error: np.ndarray  # (n,), J: the part of the imbalance that is not dissipated yet, see `EnergyAccount`

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    def keys(self) -> KeysView[str]:
        """Names of the arrays."""
        return self.values.keys()

    def get(self, name: str) -> np.ndarray | None:
        """An array, or None where such a run has none of that name."""
        return self.values.get(name)

    def __len__(self) -> int:
        return len(self.imbalance)

    @classmethod
    def joined(cls, blocks: Sequence["Samples"]) -> "Samples":
        """Blocks of one run, one after the other."""
        values = {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0].keys()}
        energies = {name: np.concatenate([getattr(block, name) for block in blocks]) for name in OF_ENERGY}
        return cls(values=values, **energies)

    def at(self, which: slice) -> "Samples":
        """Some of the block."""
        values = {name: array[which] for name, array in self.values.items()}
        return Samples(values=values, **{name: getattr(self, name)[which] for name in OF_ENERGY})

    def relative_error(self) -> np.ndarray:
        """Energy error over the energy exchanged, (n,)."""
        return self.error / self.energy_scale

    @property
    def energy_scale(self) -> np.ndarray:
        """Energy that an error is measured by, (n,), J: that exchanged, or what the kinetic energy rounds to."""
        return np.fmax(self.exchanged, ROUND_OFF * np.abs(self["energy_kinetic"]) + 1e-30)


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Displacements at one sample, in the bodies' own frames; m."""

    sample: int
    time: float  # s
    roller_turn: np.ndarray  # (n_rollers,), rad
    ring_turn: float  # rad, of the inner ring
    outer_turn: float  # rad, of the outer ring
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), about the centre of mass
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to its held circle or its bore


class Block(NamedTuple):
    """What an advance gives."""

    samples: Samples | None = None
    frame: Frame | None = None  # the fields of the first of the samples, where the scene asks for them
    trouble: str | None = None  # why the run can't go on after these samples
    restarts: str | None = None  # why all samples so far are void and the run goes on from its start


class Progress(NamedTuple):
    """Where a run stands."""

    samples: int
    steps: int  # up to the last sample
    steps_left: int
    simulated: float  # s
    wall: float  # s, time loop only
    speed: float  # steps per second of wall time
    imbalance: float  # energy error over the exchanged energy: see `Samples`


class RunState(ABC):
    """A run after its last sample. A solver's own adds what its next steps need."""

    def __init__(self, plan: "Plan"):
        self.plan = plan
        self.done = 0  # samples
        self.wall = 0.0  # s, time loop only
        self.processor = 0.0  # s of this thread in it since the process began, whoever else the machine works for
        self.imbalance = 0.0  # of the last sample: the energy error over the exchanged energy
        self.void_steps = 0  # of what was restarted
        self.stop: Callable[[], bool] = lambda: False  # whether an advance that takes long shall leave off

    steps_per_sample = property(lambda self: self.plan.stride)

    @contextmanager
    def timed(self) -> Iterator[None]:
        """Count what is done meanwhile as the time loop's."""
        wall, processor = time.perf_counter(), time.thread_time()
        yield
        self.wall += time.perf_counter() - wall
        self.processor += time.thread_time() - processor

    @abstractmethod
    def advance(self, most: int) -> Block:
        """The next samples, at most so many and at least one; keeps `done`, `wall` and `imbalance` up to date.

        None, and the state of the last sample, where `stop` says so on the way.
        """

    @abstractmethod
    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        """What a checkpoint stores: all arrays that the next steps need but for those the plan determines, and
        whatever JSON can hold. Names, types and shapes don't change as the run goes on; what is a number in the first
        state is one in all."""

    @abstractmethod
    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        """Go on where another state of the same plan was kept, which had come to `done`.

        UsageError: of another model. Any other: not what `to_keep` gives.
        """

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        """Attributes of the result file that the run finds out."""
        warnings = "\n".join((*self.plan.warnings, *self.warnings))
        return {"steps": self.progress.steps, "wall_seconds": self.wall, "warnings": warnings}

    warnings = property(lambda self: ())  # of the run, printed at its end and kept in the result file with the plan's
    notices = property(lambda self: ())  # of the run, printed at its end even with --quiet

    @property
    def progress(self) -> Progress:
        """Where the run stands after its last sample."""
        last, per_sample = max(0, self.done - 1), self.steps_per_sample
        return Progress(
            samples=self.done, steps=last * per_sample, steps_left=(self.plan.n_samples - 1 - last) * per_sample,
            simulated=last * self.plan.interval, wall=self.wall,
            speed=(self.void_steps + last * per_sample) / self.wall if self.wall > 0.0 else 0.0,
            imbalance=self.imbalance,
        )  # fmt: skip


class Plan(ABC):
    """Everything decided before the first step, and what the result file says of it."""

    scene: Scene
    n_samples: int
    time_step: float  # s
    critical_time_step: float  # s, at which the scheme becomes unstable
    degrees_of_freedom: int
    mesh_nodes: int = 0  # of elastic bodies
    frame_stride: int = 0  # samples between stored fields; 0: none
    warnings: tuple[str, ...] = ()  # shown at the start, kept in the result file
    notices: tuple[str, ...] = ()  # shown at the start even to those who want quiet, since the file does not keep them
    model_name: str  # "finite elements"
    lacks: str  # what the model leaves out of a bearing
    expected_seconds: float  # of the time loop, on one thread of a 2024 server core; only a guide

    interval = property(lambda self: 1e-6 * self.scene.numerics.output_interval_us)  # Between samples, s

    @abstractmethod
    def static_hub(self) -> np.ndarray:
        """Hub under the radial load alone, standing, weightless, (2,), m. RuntimeError, UsageError: no equilibrium."""

    def prepare(self, tell: Callable[[str], None] | None = None) -> RunState:
        """Load or compile what the steps need, and give the first state; `tell` gets a sentence if that takes long."""
        return self.first_state()

    @abstractmethod
    def first_state(self) -> RunState:
        """The state of a run that has not begun. RunFailed: there is none."""

    @abstractmethod
    def versions(self) -> dict[str, str]:
        """Of everything beside the program that decides the bits of a run, the processor included."""

    @abstractmethod
    def rows(self) -> dict[str, str]:
        """What --dry-run shows, name and value. RunFailed: there is no equilibrium to tell of."""

    def table(self) -> "Table | None":
        """What --dry-run shows above that."""
        return None


def sample_count(scene: Scene) -> int:
    """Samples of a scene, of which the start is the first."""
    return 1 + int(1e-3 * scene.numerics.duration_ms / (1e-6 * scene.numerics.output_interval_us) * (1.0 + 1e-12))


# times gravity that turning must press rollers outwards by, or those without load fall within the bearing
HELD = 5.0


def may_strike(scene: Scene, bearing: Bearing, operation: Operation) -> bool:
    """Whether bodies may strike each other: from rest, by spalls, under tables of speed or load, or as rollers fall."""
    spalled = any(isinstance(fault, Spall) for fault in bearing.faults)
    outwards = kinematics(bearing, *operation.ring_speeds).cage ** 2 * bearing.pitch_radius
    falling = 0.0 < outwards < HELD * operation.gravity
    return spalled or falling or scene.numerics.start == "rest" or operation.history is not None

"""How far results are off, and how it falls with refinement. Each module is a command; `--write` keeps its tables.

The tables stand in docs/measurements/ (`tests.measurements`):

convergence    observed orders in mesh size, time step and output interval; meshes from far coarser than a contact to
               those that resolve it; processors
reduced        the reduced model against finite elements: steady, in clearance, on random bearings; its steps
fault_finding  spalls found in random runs and by a sensor
spalls         one crossing of a spall against half-planes and resolved contacts; the line of a measured bearing
rocking        vibration of rollers that stick to both raceways
tilted         rollers that tilt, on meshes, over spalls and their edges
cage, starts   what a cage does; light starts of the Lagrangian model against another integration
"""

from typing import NamedTuple

import numpy as np

from fem.solver.simulate import run
from fem.solver.solver import Plan, RunState, Samples
from lagrange.errors import RunFailed


class Found(NamedTuple):
    """A run to its end, whatever that was."""

    samples: Samples | None  # None: stopped before the first
    state: RunState
    restarts: int
    trouble: str | None

    def __getitem__(self, name: str) -> np.ndarray:
        return self.samples[name]

    @property
    def imbalance(self) -> float:
        """Largest, of the exchanged energy, or of what the kinetic energy rounds to."""
        return float(np.abs(self.samples.imbalance).max()) / self.samples.passed_on.max()

    @property
    def largest(self) -> float:
        """Contact force, N."""
        return float(max(self[name].max() for name in ("inner_force", "outer_force"))) if self.samples else 0.0


def found(plan: Plan, halving: bool = True) -> Found:
    """Run a plan; without `halving` a reduced model keeps its step whatever its energy does."""
    blocks, restarts, state, trouble = [], [], plan.first_state(), None
    if not halving:
        state.most_halvings = 0
    plan.prepare()
    try:
        run(plan, blocks.append, state=state, restart=lambda reason: (restarts.append(reason), blocks.clear()))
    except RunFailed as error:
        trouble = str(error)
    return Found(Samples.joined(blocks) if any(map(len, blocks)) else None, state, len(restarts), trouble)

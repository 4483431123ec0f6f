"""A solver of next to nothing, as another one would be added: one module, one line in the registry.

The hub swings on a spring, one exact turn of a phase a step; rollers stand where kinematics has them.
"""

from dataclasses import dataclass

import numpy as np

from fem.solver.solver import Block, Plan, RunState, Samples, sample_count
from lagrange.columns import PER_TIME, columns_of
from lagrange.scene.scene import Scene

TURN = 0.1  # rad a sample
GONE = 1e5  # rpm, from which on the spring breaks


@dataclass(frozen=True, kw_only=True)
class ToyPlan(Plan):
    scene: Scene
    n_samples: int
    model_name, lacks, expected_seconds = "toy", "all but a spring", 0.0
    degrees_of_freedom = 1
    time_step, critical_time_step = 1e-6, 2e-6

    def first_state(self):
        return ToyState(self)

    def versions(self):
        return {"toy": "1"}

    def static_hub(self):
        return np.zeros(2)

    def rows(self):
        return {"spring": "one"}


class ToyState(RunState):
    steps_per_sample = 10

    def __init__(self, plan):
        super().__init__(plan)
        self.phase = np.array([1.0, 0.0])

    def advance(self, most):
        rows = []
        c, s = np.cos(TURN), np.sin(TURN)
        for _ in range(most):
            rows.append(self.phase)
            self.phase = np.array([c * self.phase[0] - s * self.phase[1], s * self.phase[0] + c * self.phase[1]])
        n = self.plan.scene.bearing.rollers
        values = {
            name: np.zeros(most if dimensions == PER_TIME else (most, n))
            for name, (dimensions, *_) in columns_of("").items()
        }
        values["time"] = self.plan.interval * np.arange(self.done, self.done + most)
        values["inner_x"], values["inner_y"] = np.array(rows).T
        self.done += most
        self.wall += 1e-3
        broken = abs(self.plan.scene.operation.speed_rpm) >= GONE and self.done > 20
        samples = Samples(values=values, imbalance=np.zeros(most), exchanged=np.ones(most), error=np.zeros(most))
        return Block(samples=samples, trouble="the spring has broken" if broken else None)

    def to_keep(self):
        return {"phase": self.phase}, {"note": "any"}

    def take_back(self, arrays, numbers):
        self.phase = arrays["phase"]


def make_plan(scene):
    return ToyPlan(scene=scene, n_samples=sample_count(scene))

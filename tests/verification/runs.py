"""Runs of whole bearings, kept in memory."""

from dataclasses import dataclass, replace

import numpy as np

from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan
from lagrange.scene.scene import read_scene
from tests.reference.whole_run import whole_run


@dataclass(frozen=True, kw_only=True)
class RunSamples:
    """All samples of a run, by the result file's names; SI."""

    plan: ElementPlan
    values: dict[str, np.ndarray]  # time first
    imbalance: np.ndarray  # J

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    @property
    def largest_stored(self) -> float:
        """Elastic and contact energy, J."""
        return float(np.max(self["energy_elastic"] + self["energy_contact"]))


def plan_of(**settings: float | str) -> ElementPlan:
    """The paper's scene but for these keys: `operation__speed_rpm=900`."""
    return make_plan(read_scene(None, tuple(f"{key.replace('__', '.')}={value}" for key, value in settings.items())))


def record(plan: ElementPlan) -> RunSamples:
    """Run a plan to its end."""
    found = whole_run(plan)
    return RunSamples(plan=plan, values=found.values, imbalance=found.imbalance)


def every_step(plan: ElementPlan, n_steps: int) -> ElementPlan:
    """The plan with a sample at each of its first steps."""
    return replace(plan, stride=1, n_samples=n_steps + 1)


def without_spin(plan: ElementPlan) -> ElementPlan:
    """The plan with rollers that go round with the cage and do not turn."""
    return replace(plan, start=replace(plan.start, kinematics=replace(plan.start.kinematics, roller=0.0)))

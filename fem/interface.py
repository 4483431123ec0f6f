"""Simulations from Python: what the commands do, without files, signals or printing, in any thread.

from fem import Scene, simulate

result = simulate(Scene(model="reduced"))
result["inner_y"].mean(), result.quantities["load_zone"].value
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from fem.solver.simulate import make_plan, programs_named, run
from lagrange.mounting import from_outer_ring

if TYPE_CHECKING:
    from fem.errors import RunFailed, UsageError
    from fem.recording import Result
    from fem.solver.solver import Progress
    from lagrange.scene import Scene, SceneError, read_scene

__all__ = [
    "Progress",
    "Result",
    "RunFailed",
    "Scene",
    "SceneError",
    "Statics",
    "UsageError",
    "read_scene",
    "simulate",
    "statics",
]

_HOME = {
    "Progress": "fem.solver.solver",
    "Result": "fem.recording",
    "RunFailed": "fem.errors",
    "Scene": "lagrange.scene",
    "SceneError": "lagrange.scene",
    "UsageError": "fem.errors",
    "read_scene": "lagrange.scene",
}
_PLANNING = Lock()  # meshes, factorisations and compiling are not for two threads at once
SHARE = 0.005  # of the load, by which it is changed to find the stiffness


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'fem.interface' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def simulate(
    scene: "Scene",
    *,
    progress: "Callable[[Progress], None] | None" = None,
    stop: Callable[[], bool] = lambda: False,
) -> "Result":
    """Simulate a scene by the model that it names and keep its samples in memory.

    Parameters
    ----------
    progress : is called after each block of samples
    stop : is asked after each block, and within samples that take long; the result then holds the samples so far

    Returns
    -------
    Result

    Errors
    ------
    UsageError: the model can't take the scene, or a program it needs is missing. RunFailed: the run went wrong
    numerically.
    """
    from fem.recording import Memory, Result

    began = time.perf_counter()
    with _PLANNING:
        plan = programs_named(lambda: make_plan(scene))
        plan.prepare()
    setup, memory, state = time.perf_counter() - began, Memory(plan), plan.first_state()
    run(plan, memory.append, progress or (lambda seen: None), stop, state, memory.keep, memory.begin_again)
    return Result.of(state, memory, setup)


@dataclass(frozen=True, kw_only=True)
class Statics:
    """A bearing in equilibrium at the start of its scene: under load and weight, and as steady rotation loads it."""

    hub: np.ndarray  # (2,), m, from the outer ring's centre
    roller_theta: np.ndarray  # (n_rollers,), rad, from +x
    roller_rho: np.ndarray  # (n_rollers,), m, from the outer ring's centre
    inner_force: np.ndarray  # (n_rollers,), N, >= 0
    outer_force: np.ndarray  # (n_rollers,), N, >= 0
    scene: "Scene" = field(repr=False)

    @cached_property
    def stiffness(self) -> float:
        """Radial stiffness against the load, N/m: from two more equilibria, under 0.5 % more and less load.

        Errors
        ------
        Second order in that share; ValueError: there is no load.
        """
        load = self.scene.operation.radial_load_N
        if load == 0.0:
            raise ValueError("operation.radial_load_N = 0: the stiffness against a load needs one")
        more, less = (
            statics(self.scene.varied({"operation.radial_load_N": load * (1.0 + sign * SHARE)})) for sign in (1, -1)
        )
        return float(2.0 * SHARE * load / (less.hub[1] - more.hub[1]))


def statics(scene: "Scene") -> Statics:
    """The static equilibrium of a scene, by the model that it names: the start of its run from equilibrium.

    Errors
    ------
    UsageError: no equilibrium; see also `simulate`.
    """
    found = simulate(scene.varied({"numerics.duration_ms": 0.0, "numerics.start": "equilibrium"}))
    return Statics(
        hub=np.array([place[0] for place in from_outer_ring(found.values, "inner")]),
        roller_theta=found["roller_theta"][0],
        roller_rho=found["roller_rho"][0],
        inner_force=found["inner_force"][0],
        outer_force=found["outer_force"][0],
        scene=scene,
    )

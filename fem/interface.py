"""Simulations from Python: what the commands do, without files, signals or printing, in any thread.

from fem.interface import Scene, simulate

result = simulate(Scene(model="reduced"))
result["inner_y"].mean(), result.quantities["load_zone"].value
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from fem.quantities import Quantity, labels
from fem.rating.answers import rating
from fem.recording import Memory, Result, open_result
from fem.solver.simulate import make_plan, programs_named, run
from fem.solver.solver import Progress
from lagrange.errors import RunFailed, UsageError
from lagrange.mounting import from_outer_ring
from lagrange.scene.scene import Scene, SceneError, parse_scene, read_scene

# The one place of the solver's side that knows the checker: for runs from Python, and for studies.
#
# It hands over a result file and takes numbers back. Nothing that makes a result file imports it.


if TYPE_CHECKING:
    from residual import Evaluation

MOMENTS = {"mean": "mean", "rms": "rms", "std": "standard deviation"}
LINES = ("FTF", "shaft", "BSF", "BPFO", "BPFI")
MEASURED = "the sensor (or the housing, or the hub)"
OF_CHECK = {  # unit and meaning of what a check tells of a run
    **{
        f"error_{m}_{axis}": ("N", f"{word} of the error force along {axis}")
        for axis in "xy"
        for m, word in MOMENTS.items()
    },
    **{f"{n.lower()}_{axis}": ("N", f"rms of the error force along {axis} at {n}") for axis in "xy" for n in LINES},
    "sensor_rms": ("m/s2", f"rms of the acceleration along y of {MEASURED}"),
    "sensor_crest": ("1", "crest factor of this acceleration"),
    "sensor_kurtosis": ("1", "kurtosis of this acceleration (Gaussian noise: 3)"),
    "sensor_bpfo": ("m/s2", "amplitude of BPFO in the envelope of this acceleration"),
    "sensor_bpfi": ("m/s2", "amplitude of BPFI in the envelope of this acceleration"),
}


def evaluated(path: Path, law: str | None = None, start: float | None = None, order: int = 6) -> "Evaluation":
    """The check of a result file; arguments and errors as `residual.evaluate`."""
    from residual import evaluate, read_result

    return evaluate(read_result(path), law, start, order)


def check_quantities(evaluation: "Evaluation") -> list[Quantity]:
    """All of OF_CHECK; NaN for lines that a bearing at rest or a short record does not have."""
    found = {}
    for direction in evaluation.directions:
        levels = {level.name: level.rms for level in direction.levels}
        for moment in MOMENTS:
            found[f"error_{moment}_{direction.name}"] = float(getattr(direction.error, moment))
        for line in LINES:
            found[f"{line.lower()}_{direction.name}"] = float(levels.get(line, nan))
    measured = evaluation.y.vibration
    amplitudes = {line.name: line.amplitude for line in measured.lines}
    found |= {
        "sensor_rms": measured.level.rms,
        "sensor_crest": nan if measured.level.crest is None else measured.level.crest,
        "sensor_kurtosis": nan if measured.level.kurtosis is None else measured.level.kurtosis,
        "sensor_bpfo": amplitudes.get("BPFO", nan),
        "sensor_bpfi": amplitudes.get("BPFI", nan),
    }
    return [Quantity(name, *about, found[name]) for name, about in OF_CHECK.items()]


__all__ = [
    "Progress",
    "Result",
    "RunFailed",
    "Scene",
    "SceneError",
    "Statics",
    "UsageError",
    "frequencies",
    "open_result",
    "rating",
    "read_scene",
    "simulate",
    "statics",
]

_PLANNING = Lock()  # meshes, factorisations and compiling are not for two threads at once
SHARE = 0.005  # of the load, by which it is changed to find the stiffness


def simulate(
    scene: Scene,
    *,
    progress: Callable[[Progress], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Result:
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
    began = time.perf_counter()
    with _PLANNING:
        plan = programs_named(lambda: make_plan(scene))
        state = plan.prepare()
    setup, memory = time.perf_counter() - began, Memory(plan)
    run(plan, memory.append, progress or (lambda seen: None), stop, state, memory.keep, memory.restart)
    return Result.of(state, memory, setup)


@dataclass(frozen=True, kw_only=True)
class Statics:
    """A bearing in equilibrium at the start of its scene: under load and weight, and as steady rotation loads it.

    At a contact angle places and forces are the section's, see `lagrange.section`; the stiffness is the bearing's.
    """

    hub: np.ndarray  # (2,), m, from the outer ring's centre
    roller_theta: np.ndarray  # (n_rollers,), rad, from +x
    roller_rho: np.ndarray  # (n_rollers,), m, from the outer ring's centre
    inner_force: np.ndarray  # (n_rollers,), N, >= 0
    outer_force: np.ndarray  # (n_rollers,), N, >= 0
    scene: Scene = field(repr=False)

    @cached_property
    def stiffness(self) -> float:
        """Radial stiffness against the load, N/m: from two more equilibria, under 0.5 % more and less load.

        Errors
        ------
        Second order in that share; ValueError: there is no load.
        """
        load = self.scene.operation.radial_load_N
        if load == 0.0:
            raise ValueError("operation.radial_load_N = 0: the stiffness needs a load")
        more, less = (
            statics(self.scene.varied({"operation.radial_load_N": load * (1.0 + sign * SHARE)})) for sign in (1, -1)
        )
        return float(2.0 * SHARE * load * self.scene.bearing.cosine / (less.hub[1] - more.hub[1]))


def statics(scene: Scene) -> Statics:
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


def frequencies(designation: str, speed_rpm: float) -> dict[str, float]:
    """FTF, BSF, BPFO and BPFI, Hz, of a standard bearing whose inner ring turns, rolling without slip.

    Errors
    ------
    SceneError: a designation that is not in the table.
    """
    tables = {"model": "lagrange", "bearing": {"designation": designation}, "operation": {"speed_rpm": speed_rpm}}
    found = labels(parse_scene(tables, designation))
    return {name: float(found[f"{name}_Hz"]) for name in ("FTF", "BSF", "BPFO", "BPFI")}

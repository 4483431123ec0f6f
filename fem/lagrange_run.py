"""`run-fem --model lagrange`: the ideal bearing's own solution as a result file. No mesh, no compiled kernels.

Rigid bodies on contact springs: tractions and mesh energy are 0, the springs' energy is `energy_contact`. Friction,
mesh and time step safety of the scene play no part. The file is written when the run is done.
"""

import signal
import sys
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console

from fem.errors import UsageError
from fem.result.store import ResultFile
from fem.wording import run_line, statics_lines
from lagrange import Trajectory, contact_laws, simulate, static_equilibrium
from lagrange.laws import PowerLaw
from lagrange.raceway_laws import caution
from lagrange.scene import Scene
from lagrange.simulate import steps_per_sample

LARGEST_RUN = 4 * 2**30  # bytes of arrays
ARRAYS = 30  # per roller and sample, at the most at a time
# one thread of a 2024 server core; only a guide
SECONDS_PER_STEP = {True: 65e-6, False: 160e-6}  # power law, other


@dataclass(frozen=True, kw_only=True)
class LagrangePlan:
    """What a scene asks for, and what the file says of it."""

    scene: Scene
    interval: float  # s, between samples
    n_samples: int
    time_step: float  # s
    steps: int
    critical_time_step: float = 0.0  # s, known after the run
    mesh_nodes: int = 0
    frame_stride: int = 0
    cautions: tuple[str, ...] = ()  # of law and material, which concern this run alone: told as it starts

    @property
    def degrees_of_freedom(self) -> int:
        """N_b + 2, or 2 N_b + 2 where the angles are free."""
        per_roller = 2 if self.scene.lagrange.angles == "free" else 1
        return per_roller * self.scene.bearing.rollers + 2

    @property
    def memory(self) -> int:
        """Bytes that the run takes."""
        return 8 * ARRAYS * (self.scene.bearing.rollers + 1) * self.n_samples


def make_plan(scene: Scene) -> LagrangePlan:
    """Samples and steps of a scene.

    Errors
    ------
    UsageError: more samples than fit in memory.
    """
    interval = 1e-6 * scene.numerics.output_interval_us
    n_samples = 1 + int(1e-3 * scene.numerics.duration_ms / interval * (1.0 + 1e-12))
    bearing = scene.ideal_bearing()
    per_sample = steps_per_sample(
        bearing, scene.ideal_operation(), contact_laws(scene.lagrange.law, bearing), interval,
        scene.lagrange.damping_N_s_m,
    )  # fmt: skip
    plan = LagrangePlan(
        scene=scene, interval=interval, n_samples=n_samples, time_step=interval / per_sample,
        steps=per_sample * (n_samples - 1),
    )  # fmt: skip
    if plan.memory > LARGEST_RUN:
        raise UsageError(
            f"numerics.duration_ms = {scene.numerics.duration_ms:g}: {n_samples} samples take "
            f"{plan.memory / 2**30:.3g} GiB, at most {LARGEST_RUN / 2**30:.0f} GiB; shorten the run or raise "
            f"numerics.output_interval_us = {scene.numerics.output_interval_us:g}"
        )
    return plan


def solve(plan: LagrangePlan) -> Trajectory:
    """Integrate a plan.

    Errors
    ------
    RuntimeError: no equilibrium to start from, or steps too long for the forces met. UserWarning: rattling contacts
    that even refined steps resolve badly.
    """
    scene = plan.scene
    bearing, numerics, options = scene.ideal_bearing(), scene.numerics, scene.lagrange
    return simulate(
        bearing, scene.ideal_operation(), contact_laws(options.law, bearing),
        (plan.n_samples - 1) * plan.interval, plan.interval,
        start=numerics.start, angles=options.angles, damping=options.damping_N_s_m,
        load_ramp=1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0,
    )  # fmt: skip


def variables(run: Trajectory) -> dict[str, np.ndarray]:
    """A solution by the result file's names."""
    per_time, per_roller = np.zeros(run.time.shape), np.zeros(run.roller_rho.shape)
    same = ("time", "inner_x", "inner_y", "inner_vx", "inner_vy", "inner_ax", "inner_ay", "roller_x", "roller_y",
            "roller_rho", "roller_theta", "inner_force", "outer_force", "energy_kinetic", "energy_contact",
            "work_external", "work_dissipated")  # fmt: skip
    return {name: getattr(run, name) for name in same} | {
        "roller_spin": per_roller + run.roller_spin,
        "inner_traction": per_roller,
        "outer_traction": per_roller,
        "roller_roller_force": per_roller,
        "energy_elastic": per_time,
    }


def run_command(scene: Scene, path: Path, quiet: bool) -> int:
    """Solve, write, tell; the exit code."""
    began = time.perf_counter()
    plan = make_plan(scene)
    _warn(caution(scene.lagrange.law, scene.ideal_bearing()))
    signal.signal(signal.SIGTERM, _terminated)
    set_up = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        try:
            run = solve(plan)
        except RuntimeError as error:
            print(f"error: {error}\nnothing was written", file=sys.stderr)
            return 1
    wall = time.perf_counter() - set_up
    for warning in caught:
        _warn(str(warning.message))
    plan = replace(plan, time_step=run.time_step, steps=run.steps, critical_time_step=run.critical_time_step)
    with ResultFile(path, plan, set_up - began) as store:
        store.append(variables(run))
        store.finish("complete", run.steps, wall)
    if not quiet:
        _print_run(run, wall, path)
    return 0


def _warn(text: str | None) -> None:
    if text is not None:
        print(f"warning: {text}", file=sys.stderr)


def _terminated(number, frame):
    raise SystemExit(128 + number)


def print_plan(plan: LagrangePlan) -> None:
    """Steps, memory, the time to expect and the statics."""
    scene = plan.scene
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    laws = contact_laws(scene.lagrange.law, bearing)
    seconds = plan.steps * SECONDS_PER_STEP[isinstance(laws.inner, PowerLaw)]
    statics = static_equilibrium(bearing, operation, laws)
    console = Console(highlight=False)
    console.print(f"Plan of {scene.name}, Lagrangian model", style="italic")
    rows = {
        "degrees of freedom": f"{plan.degrees_of_freedom} ({scene.lagrange.angles} angles)",
        "contact law": f"{scene.lagrange.law}, {laws.inner.range}",
        "damping of a contact": f"{scene.lagrange.damping_N_s_m:g} N s/m",
        "time step": f"{1e6 * plan.time_step:.3g} µs, halved where contacts rattle",
        "steps": f"{plan.steps} for {1e3 * (plan.n_samples - 1) * plan.interval:g} ms",
        "samples": f"{plan.n_samples}",
        "memory": f"{1e-6 * plan.memory:.1f} MB",
        "expected time": f"about {seconds:.2g} s",
        "largest static contact force": f"{max(statics.inner_force.max(), statics.outer_force.max()):.1f} N",
    }
    for name, value in rows.items():
        console.print(f"{name + ':':30s} {value}", soft_wrap=True)


def _print_run(run: Trajectory, wall: float, path: Path) -> None:
    console = Console(highlight=False)
    if run.time.size == 1:
        lines = statics_lines(run.inner_x[0], run.inner_y[0], run.inner_force[0])
    else:
        stored = max(float(run.energy_contact.max()), np.finfo(float).tiny)
        lines = [run_line(run.time[-1], wall, run.steps, run.energy_error[-1] / stored, "contact")]
    for line in lines:
        console.print(line, soft_wrap=True)
    console.print(f"Result: {path}", soft_wrap=True, markup=False)

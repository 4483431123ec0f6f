"""From a scene to a finished run: plan the time steps, advance in blocks, watch the energy, hand samples on."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil

import numba
import numpy as np

from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import Model
from fem.kernels import time_loop
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.solver.arrays import Arrays, make_arrays
from fem.solver.cautions import cautions
from fem.solver.discretise import expected_forces, model_of
from fem.solver.frames import Frame, frame_of
from fem.solver.limits import check_contacts, check_meshes, check_speed, check_threads, check_widths
from fem.solver.samples import SampleReader, Samples
from fem.solver.start import Start, equilibrium_start, rest_start
from fem.statics.contact_balance import NotFound
from lagrange import Operation, kinematics
from lagrange.scene import Scene

BLOCK_SECONDS = 0.2  # wall time between two looks at the samples
IMBALANCE_LIMIT = 0.05  # of the exchanged energy; a sound run stays far below 1e-2
# Modes that grow balance too: leapfrog's kinetic energy ½ v(t − dt/2)·M·v(t + dt/2) goes to minus the stored one. In a
# mode of frequency ω it is −(ω dt/2)² of it at least, −0.98 at 0.99 of the critical step.
NEGATIVE_LIMIT = 0.98
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body gives way so far
LARGEST_BLOCK = 4096  # rows of samples, whatever the clock says
LONGEST_UNWATCHED = 100  # steps between two looks at the energy


class RunFailed(RuntimeError):
    """The run went wrong numerically; the text names step, time and body."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Everything decided before the first step."""

    scene: Scene
    model: Model
    operation: Operation
    start: Start
    critical_time_step: float  # s
    time_step: float  # s
    stride: int  # steps between samples
    n_samples: int
    largest_force: float  # N, static, of any contact
    frame_stride: int  # samples between stored fields; 0: none
    cautions: tuple[str, ...] = ()

    @property
    def interval(self) -> float:
        """Between samples, s."""
        return self.stride * self.time_step

    @property
    def looks(self) -> int:
        """At the energy per sample: as few as leave at most LONGEST_UNWATCHED steps between two."""
        fewest = ceil(self.stride / LONGEST_UNWATCHED)
        return next(looks for looks in range(fewest, self.stride + 1) if self.stride % looks == 0)

    @property
    def steps(self) -> int:
        return (self.n_samples - 1) * self.stride

    @property
    def mesh_nodes(self) -> int:
        return self.model.n_nodes

    @property
    def degrees_of_freedom(self) -> int:
        return self.model.degrees_of_freedom

    def arrays(self) -> Arrays:
        """Fresh arrays at the start."""
        numerics = self.scene.numerics
        ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
        friction = self.scene.contact.friction_coefficient
        return make_arrays(
            self.model, self.operation, self.start, self.time_step, friction, ramp, self.largest_force, numerics.threads
        )


def make_plan(scene: Scene) -> Plan:
    """Mesh, assemble, calibrate, solve the start, find the critical step.

    The time step is the largest below safety · critical that divides the output interval, and the interval between two
    looks at the energy.

    Errors
    ------
    RuntimeError: gmsh is needed and missing.
    UsageError: the model can't bear the speed or the load.
    """
    numerics = scene.numerics
    operation = scene.ideal_operation()
    check_threads(numerics.threads)
    forces = expected_forces(scene)
    model = model_of(scene, forces)
    check_meshes(model)
    check_speed(model, kinematics(model.bearing, operation.speed))
    try:
        loaded = equilibrium_start(model, operation)
    except NotFound:
        if model.is_sized_by_forces:  # contacts wider than all pressure points have none: better say so
            check_widths(model.bearing, forces.largest)
        raise
    check_contacts(model, loaded.equilibrium)
    start = rest_start(model, operation) if numerics.start == "rest" else loaded
    expected = max(
        float(loaded.equilibrium.inner_force.max()),
        float(loaded.equilibrium.outer_force.max()),
        5.0 * operation.radial_load / model.bearing.n_rollers,
    )
    critical = critical_time_step(model, expected)
    interval = 1e-6 * numerics.output_interval_us
    steps = max(1, ceil(interval / (numerics.time_step_safety * critical)))
    looks = ceil(steps / LONGEST_UNWATCHED)
    stride = looks * ceil(steps / looks)  # `Plan.looks` shall divide it
    return Plan(
        scene=scene,
        model=model,
        operation=operation,
        start=start,
        critical_time_step=critical,
        time_step=interval / stride,
        stride=stride,
        largest_force=expected,
        cautions=cautions(model, operation, loaded.equilibrium, interval),
        n_samples=1 + int(1e-3 * numerics.duration_ms / interval * (1.0 + 1e-12)),
        frame_stride=round(1e-3 * scene.output.fields_every_ms / interval),
    )


def compile_kernels(plan: Plan) -> None:
    """Compile the time loop, or load it compiled, without taking a step."""
    if plan.scene.numerics.threads > 1:
        numba.set_num_threads(plan.scene.numerics.threads)
    arrays = plan.arrays()
    _advance(plan, arrays, 0, np.zeros((0, _row_width(plan))))


def _row_width(plan: Plan) -> int:
    return N_SCALARS + len(BLOCKS) * plan.model.bearing.n_rollers


def _advance(plan: Plan, arrays: Arrays, done: int, rows: np.ndarray) -> tuple[int, int, int]:
    return time_loop.advance(
        arrays.rollers,
        arrays.inner,
        arrays.outer,
        arrays.contacts,
        arrays.drive,
        arrays.scratch,
        done * plan.stride,
        plan.stride // plan.looks,
        rows,
    )


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where a run stands."""

    samples: int
    steps: int
    simulated: float  # s
    wall: float  # s, time loop only
    imbalance: float  # energy imbalance over the exchanged energy: see `Samples`


@dataclass(kw_only=True)
class RunState:
    """A run after its last sample: what a checkpoint holds."""

    arrays: Arrays
    reader: SampleReader
    done: int = 0  # samples
    wall: float = 0.0  # s, time loop only
    imbalance: float = 0.0  # energy imbalance of the last sample over the exchanged energy


def first_state(plan: Plan) -> RunState:
    """The state of a plan that has not begun."""
    return RunState(arrays=plan.arrays(), reader=SampleReader(plan))


def run(
    plan: Plan,
    write: Callable[[Samples], None],
    report: Callable[[Progress], None] = lambda progress: None,
    stop: Callable[[], bool] = lambda: False,
    state: RunState | None = None,
    keep: Callable[[Frame], None] = lambda frame: None,
) -> Progress:
    """Advance a plan to its end, or until `stop` says so, handing samples to `write` as they come.

    `state`, where given, is where to go on from; it is kept up to date after each block, before `report`. `keep` gets
    the fields the scene asks for, each before the sample of its instant.

    Errors
    ------
    RunFailed: a velocity is not a number, or the energy no longer balances; good samples were written.
    """
    state = first_state(plan) if state is None else state
    compile_kernels(plan)
    block = 1
    while state.done < plan.n_samples and not stop():
        left = plan.n_samples - state.done
        if plan.frame_stride:  # between two samples the state is that of the one to come
            since = state.done % plan.frame_stride
            left = min(left, plan.frame_stride - since)
            if since == 0:
                keep(frame_of(plan.model, state.arrays, state.done, plan.interval))
        rows = np.zeros((plan.looks * min(block, left), _row_width(plan)))
        began = time.perf_counter()
        status, step, body = _advance(plan, state.arrays, state.done, rows)
        took = time.perf_counter() - began
        state.wall += took
        if status != time_loop.DONE:
            rows = rows[: _good_rows(rows)]
        if len(rows):
            looked = state.reader.read(rows)
            good, state.imbalance = _balanced(looked)
            held = _in_place(plan, looked)
            samples = looked.first(min(good, held)).every(plan.looks)
            write(samples)
            state.done += len(samples)
            if held < good:
                raise RunFailed(_place_trouble(plan, looked, held))
            if good < len(rows):
                raise RunFailed(_energy_trouble(plan, looked, good, state.imbalance))
        if status != time_loop.DONE:
            raise RunFailed(_velocity_trouble(plan, step, body))
        report(progress_of(plan, state))
        block = min(4 * block, LARGEST_BLOCK // plan.looks or 1)
        if took > 0.0:  # clocks have stood still
            block = max(1, min(block, int(BLOCK_SECONDS / took * len(samples))))
    return progress_of(plan, state)


def progress_of(plan: Plan, state: RunState) -> Progress:
    """Where a run stands after its last sample."""
    last = max(0, state.done - 1)
    return Progress(
        samples=state.done,
        steps=last * plan.stride,
        simulated=last * plan.interval,
        wall=state.wall,
        imbalance=state.imbalance,
    )


def _good_rows(rows: np.ndarray) -> int:
    """How many rows from the first are finite and were filled."""
    good = np.all(np.isfinite(rows), axis=1) & np.any(rows != 0.0, axis=1)
    return len(rows) if good.all() else int(np.argmin(good))


def _balanced(samples: Samples) -> tuple[int, float]:
    """Number of leading samples whose energy balances, and the last one's relative imbalance."""
    # a bearing without load exchanges next to nothing: round-off of the kinetic energy is not an imbalance
    relative = samples.imbalance / np.fmax(samples.exchanged, 1e-9 * np.abs(samples["energy_kinetic"]) + 1e-30)
    stored = samples["energy_elastic"] + samples["energy_contact"]
    growing = (samples["energy_kinetic"] < -NEGATIVE_LIMIT * stored) & (stored > 0.5 * samples.exchanged)
    bad = ~(np.abs(relative) <= IMBALANCE_LIMIT) | growing
    good = int(np.argmax(bad)) if bad.any() else len(bad)
    return good, float(relative[min(good, len(bad) - 1)])


def _in_place(plan: Plan, samples: Samples) -> int:
    """Number of leading samples in which the rollers are between the raceways and the hub is between the rollers."""
    bearing = plan.model.bearing
    give = ASTRAY * bearing.roller_radius + plan.model.give(plan.operation.radial_load)
    hub_x, hub_y = samples["inner_x"], samples["inner_y"]
    from_hub = np.hypot(samples["roller_x"] - hub_x[:, None], samples["roller_y"] - hub_y[:, None]).min(axis=1)
    astray = from_hub < bearing.inner_raceway_radius + bearing.roller_radius - give
    astray |= samples["roller_rho"].max(axis=1) > bearing.outer_raceway_radius - bearing.roller_radius + give
    astray |= np.hypot(hub_x, hub_y) > 2.0 * (abs(bearing.radial_clearance) + give)
    return int(np.argmax(astray)) if astray.any() else len(astray)


def _place_trouble(plan: Plan, samples: Samples, held: int) -> str:
    step = round(samples["time"][held] / plan.time_step)
    return (
        f"the bearing has come apart at step {step}, t = {1e3 * samples['time'][held]:.5g} ms: the hub is "
        f"{1e3 * np.hypot(samples['inner_x'][held], samples['inner_y'][held]):.3g} mm from the middle; without a cage "
        "few rollers gather on one side: take more rollers or contact.friction_coefficient above 0"
    )


def _energy_trouble(plan: Plan, samples: Samples, good: int, imbalance: float) -> str:
    step = round(samples["time"][good] / plan.time_step)
    fastest = int(np.argmax(np.abs(samples["roller_spin"][good] - plan.start.kinematics.roller)))
    where = f"at step {step}, t = {1e3 * samples['time'][good]:.5g} ms (roller {fastest} strays furthest)"
    if abs(imbalance) <= IMBALANCE_LIMIT:
        return f"vibrations grow without end {where}: the time step is too long; lower numerics.time_step_safety"
    return (
        f"energy imbalance {100 * imbalance:.3g} % of the exchanged energy exceeds {100 * IMBALANCE_LIMIT:.0f} % "
        f"{where}; lower numerics.time_step_safety or numerics.mesh_size_mm"
    )


def _velocity_trouble(plan: Plan, step: int, body: int) -> str:
    name = "the hub" if body < 0 else f"roller {body}"
    hint = f"{plan.model.failure_hint}lower numerics.time_step_safety or check the load"
    return f"the velocity of {name} is not finite at step {step}, t = {1e3 * step * plan.time_step:.5g} ms; {hint}"

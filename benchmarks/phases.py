"""The phases of a step, each timed alone on a bearing's own arrays, and the work they need at least."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import njit

from benchmarks.machine import Machine
from benchmarks.measuring import median_seconds
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.kernels import disc_kernels, ring_kernels, sample_kernels, time_loop
from fem.kernels.contact_kernels import press_patches
from fem.kernels.friction_solution import friction_contacts, slips_after, slips_before
from fem.solver.elements.arrays import Arrays
from fem.solver.elements.plan import ElementPlan

TARGET_SECONDS = 0.02  # of one measurement
# arithmetic instructions (multiply-add, or add) per node at least
ROLLER_UPDATE = 16  # angular acceleration 2, torque 2, position 2, turn of u and w 8, lead 2
RING_STENCIL = 22  # 18 coefficients of a reflection-symmetric stencil, 4 sums of neighbours
TURN, STILL = 10, 2  # position and, in a turning frame, the turn of u and w
STATE_BYTES = 64  # u and w of a node read and written once


@cache
def _repeated(function: Callable) -> Callable:
    """A compiled loop around a kernel, so that no call from Python is timed."""

    @njit
    def loop(count, *arguments):
        for _ in range(count):
            function(*arguments)

    return loop


@njit
def _normal(groups, rollers, surface, contacts, drive):
    press_patches(groups, rollers, surface, contacts, drive)


@njit
def _slip_and_friction(groups, rollers, surface, contacts, drive, still):
    """Normal forces' impulses on nodes, too: friction gives both at once."""
    lumped = drive.slowing == 0.0
    slips_before(groups, rollers, surface, contacts, still, lumped)
    friction = contacts.friction
    friction_contacts(groups, rollers, surface, contacts, drive, friction.overlapping, friction.whole, True)
    slips_after(groups, rollers, surface, contacts, drive.dt, lumped)


@njit
def _rings_kick(inner, outer):
    ring_kernels.kick(*inner)
    ring_kernels.kick(*outer)


@njit
def _rings_slow_waves(inner, outer, calming, dt):
    for ring in (inner, outer):
        if calming > 0.0:
            ring_kernels.calm(ring.calming, ring.w, ring.calmed, ring.grown, 0.0, ring.first_row, ring.last_row)
        ring_kernels.find_velocities(ring.slowed, ring.calmed, ring.w, ring.v, dt, ring.raceway)
        ring_kernels.slow_waves(ring.slowed, ring.u, ring.calmed, ring.first_row, ring.last_row, ring.raceway)


@njit
def _rings_kick_and_weight(inner, outer, cosines, sines, weight):
    for k, ring in enumerate((inner, outer)):
        ring_kernels.set_rigid(weight[k], 0, cosines[k], sines[k], 0.0, 1e-12)
        table, u, w, first, last = ring
        ring_kernels.kick_and_add(table, u, w, weight[k], first, last)


@njit
def _rings_drift(inner, outer, radii, grown):
    _, u, w, first, last = inner
    ring_kernels.drift((u, w, w), radii, grown, 1e-12, (1.0, 1e-12), (first, last, -1))
    _, u, w, first, last = outer
    ring_kernels.drift_still(u, w, 1e-12, first, last)


def _rows(ring) -> tuple:
    """Parts of a ring that the kernels take: passing all of it would take longer than a small ring's kick."""
    return ring.table, ring.u, ring.w, ring.first_row, ring.last_row


@njit
def _hub(inner, scratch):
    ring_kernels.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = ring_kernels.resultant(scratch.bore, inner.cosines, inner.sines)
    held = 2 * inner.held * inner.cosines.size
    ring_kernels.set_rigid(inner.u, held, inner.cosines, inner.sines, 1e-12 * x, 1e-12 * y)


@njit
def _sampled(bodies, groups, contacts, drive, scratch, row):
    sample_kernels.remember(bodies, drive, scratch)
    sample_kernels.write_sample(bodies, groups, contacts, drive, scratch, row, 0.0, 0.0)


def _seconds(function: Callable, *arguments) -> float:
    """Time of one call of a kernel, s."""
    loop = _repeated(function)
    count = 4
    while True:
        taken = median_seconds(loop, count, *arguments, repeats=1)
        if taken > 0.2 * TARGET_SECONDS:
            break
        count *= 4
    return median_seconds(loop, count, *arguments) / count


def time_phases(plan: ElementPlan) -> dict[str, float]:
    """Time that a step spends in each phase, s, contacts and friction at the static loads."""
    a: Arrays = plan.arrays()
    r = a.bodies.rollers
    row = np.zeros(sample_kernels.N_SCALARS + len(sample_kernels.BLOCKS) * r.n)
    contacts = (a.groups, r, a.bodies.surface, a.contacts, a.drive)
    out = {
        "contacts": _seconds(_normal, *contacts),
        "impulses and friction": _seconds(_slip_and_friction, *contacts, a.scratch.still),
    }
    a = plan.arrays()
    r, d, i, o, x = a.bodies.rollers, a.bodies.disc, a.bodies.inner, a.bodies.outer, a.scratch
    still, turn = np.zeros(r.columns), np.full(r.columns, 1e-12)
    out["rollers' forces"] = _seconds(disc_kernels.kick, d, d.w, r.columns, x.torque)
    out["rings' forces"] = _seconds(_rings_kick, _rows(i), _rows(o))
    slowing, calming, dt = a.drive.slowing, a.drive.calming, a.drive.dt
    waves = (d, np.ones(r.columns), r.columns, slowing, calming, dt, x.torque)
    out["rollers' waves"] = _seconds(disc_kernels.slow_waves, *waves) if slowing else 0.0
    out["rings' waves"] = _seconds(_rings_slow_waves, i, o, calming, dt) if slowing else 0.0
    a = plan.arrays()
    r, d, i, o, x = a.bodies.rollers, a.bodies.disc, a.bodies.inner, a.bodies.outer, a.scratch
    turns = disc_kernels.Turns(still, np.ones(r.columns), turn, still, still)
    out["rollers' motion"] = _seconds(disc_kernels.drift, d, turns, r.columns, 1e-12, x.torque)
    inner, outer = _rows(i), _rows(o)
    out["rings' motion"] = _seconds(_rings_drift, inner, outer, i.radii, i.grown)
    lines = (i.cosines, o.cosines), (i.sines, o.sines), (x.bore, x.line)
    out["gravity"] = _seconds(_rings_kick_and_weight, inner, outer, *lines) - out["rings' forces"]  # added on the way
    out["hub"] = _seconds(_hub, i, x)
    a = plan.arrays()
    sample = _seconds(_sampled, a.bodies, a.groups, a.contacts, a.drive, a.scratch, row)
    out["sampling"] = sample / plan.stride
    return out


def step_seconds(plan: ElementPlan, repeats: int = 3) -> float:
    """Time of one whole step of the running bearing, s, samples included."""
    a = plan.arrays()
    width = sample_kernels.N_SCALARS + len(sample_kernels.BLOCKS) * a.bodies.rollers.n

    def advance(samples, at=[0]):  # noqa: B006 the state runs on from call to call
        rows = np.zeros((samples, width))
        time_loop.advance(a.bodies, a.groups, a.contacts, a.drive, a.scratch, at[0], plan.stride, rows)
        at[0] += samples * plan.stride

    advance(1)
    taken = median_seconds(advance, 2, repeats=1) / 2
    samples = max(2, int(10 * TARGET_SECONDS / taken))
    return median_seconds(advance, samples, repeats=repeats) / samples / plan.stride


@dataclass(frozen=True, kw_only=True)
class Work:
    """The least work that one step needs; contacts, a few hundred nodes, are not counted."""

    operations: dict[str, float]  # by phase
    bytes_moved: float
    working_set: float  # bytes of state and matrices

    def floor(self, machine: Machine) -> tuple[float, str]:
        """Seconds per step, and the ceiling that binds."""
        level = machine.level(self.working_set)
        arithmetic = sum(self.operations.values()) / machine.fma_rate
        traffic = self.bytes_moved / machine.update_rate[level]
        return (arithmetic, "arithmetic") if arithmetic > traffic else (traffic, level)


def least_work(plan: ElementPlan) -> Work:
    """Count the operations and bytes of one step of a bearing."""
    a, n = plan.arrays(), plan.model.bearing.n_rollers
    disc = a.bodies.disc.mass.size * n
    rings = [(ring.last_row - ring.first_row) * ring.n_sectors for ring in (a.bodies.inner, a.bodies.outer)]
    slowed = {LUMPED: 0.0, SECOND: 1.0, THIRD: 2.0}[plan.mass]  # the stiffness is applied as often again
    turning = TURN if plan.operation.speed else STILL
    tables = a.bodies.disc.blocks.nbytes + a.bodies.disc.neighbours.nbytes
    return Work(
        operations={
            "rollers' forces": a.bodies.disc.blocks.size * n,
            "rings' forces": RING_STENCIL * sum(rings),
            "rollers' waves": slowed * a.bodies.disc.blocks.size * n,
            "rings' waves": slowed * RING_STENCIL * sum(rings),
            "rollers' motion": ROLLER_UPDATE * disc,
            "rings' motion": turning * rings[0] + STILL * rings[1],
        },
        bytes_moved=STATE_BYTES * (disc + sum(rings)) + tables,
        working_set=0.5 * STATE_BYTES * (disc + sum(rings)) + tables,
    )


def state_bytes(plan: ElementPlan) -> int:
    """Size of all arrays of the time loop, bytes."""
    return plan.arrays().nbytes

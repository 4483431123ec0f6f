"""Kernels called from Python, bodies and contacts that tests build for them."""

from dataclasses import replace
from math import ceil
from types import SimpleNamespace

import numpy as np

from fem.elastic.reciprocal_mass import ReciprocalMass
from fem.kernels import columns, law
from fem.kernels.elements import discs, friction, loop, rings, samples
from fem.kernels.elements.rings import HALO
from fem.kernels.jit import kernel
from fem.kernels.lanes import splat
from fem.solver.elements.arrays import Arrays, disc_nodes
from fem.solver.rigid.lagrangian import LagrangianPlan
from fem.solver.rigid.state import LagrangianState
from fem.solver.solver import Samples
from lagrange import BallBearing
from lagrange.first_state import Problem
from lagrange.step_size import longest_step
from tests.reference.forward_motion import simulate
from tests.reference.kit import arrays, copies, model, operation, paper, resolved_model, soft, within

# ---- Parts of the time loop as kernels that Python can call, kept compiled as the time loop is.

kick_disc, drift_disc, slow_disc = map(kernel, (discs.kick, discs.drift, discs.slow_waves))
calm_ring, kick_ring, drift_slowed_ring = map(kernel, (rings.calm, rings.kick, rings.drift_slowed))
find_velocities, wrap_all, spring_energy = map(kernel, (rings.find_velocities, rings.wrap_all, friction.spring_energy))
kick_force, stored_energy, next_force = map(kernel, (law.kick_force, law.stored_energy, law.next_force))
place, creep_traction = kernel(law.place), kernel(law.creep_traction)
kick, remember = kernel(loop.kick), kernel(samples.remember)
kinetic_energy, elastic_energy = kernel(samples.kinetic_energy), kernel(samples.elastic_energy)


def of_state(function):
    run = kernel(function)
    return lambda state, *more: run(state.groups, state.bodies, state.contacts, state.drive, *more)


press_contacts, push_surfaces = of_state(loop.press_contacts), of_state(loop.push_surfaces)


@of_state
def find_slips(groups, bodies, contacts, drive, turn_kick, out):
    friction.grip_all(groups, bodies.rollers, bodies.surface, contacts)
    friction.slip_all(groups, bodies.rollers, bodies.surface, contacts, turn_kick, out)


@of_state
def rub_contacts(groups, bodies, contacts, drive):
    """Tractions of patches that grip and slip, and their impulses; what they take in a step, J.

    With springs nodes are given the normal forces' impulses too, but where `whole` says that they have had them.
    """
    rollers, surface = bodies.rollers, bodies.surface
    if contacts.friction.shear is not None:
        friction.follow_slips_before(contacts.friction.shear, contacts.friction, rollers.n)
    friction.friction_contacts(groups, rollers, surface, contacts, drive)
    return 0.5 * drive.dt * friction.slips_after(groups, rollers, surface, contacts, drive.dt, True)


@of_state
def _energy(groups, bodies, contacts, drive, out):
    samples.add_contact_energy(groups, contacts, bodies.rollers.n, out)


def contact_energy(state: Arrays) -> float:
    out = np.zeros(columns.CONTACT + 1)
    _energy(state, out)
    return float(out[columns.CONTACT])


@kernel
def drift(bodies, groups, contacts, drive, scratch):
    taken = loop.slide(bodies, groups, contacts, drive, scratch)
    loop.drift(bodies, drive, scratch)
    return taken


@kernel
def pull_spring(shear, contacts, pair, dt, limit, full_slip):
    friction.pull(shear, contacts, pair, 0, dt, splat(limit), splat(full_slip))


@kernel
def follow_slips(shear, forces, of_contacts, dt, n):
    friction.follow_slips_after(shear, forces, of_contacts, dt, n)
    friction.follow_slips_before(shear, of_contacts, n)


def disc_steps(body, dt: float, mass: ReciprocalMass):
    """Nodes of sixteen discs that do not turn, and what moves them by a step."""
    nodes, slowing, still, torque = disc_nodes(body, dt, 16), mass.at(dt), np.zeros(16), np.zeros(16)
    nodes = nodes if mass.calming else nodes._replace(calmed=nodes.w)
    turns = discs.Turns(still, np.ones(16), still, still, still)

    def step():
        kick_disc(nodes, nodes.w, 16, torque)
        slow_disc(nodes, turns.cosine, 16, slowing.waves, slowing.velocities / dt, dt, torque)
        drift_disc(nodes, turns, 16, dt, torque)

    return nodes, step


def ring_steps(body, dt: float, mass: ReciprocalMass):
    """u and w of a held ring that does not turn, with halos, and what moves them by a step."""
    table, slowing = -dt * rings.coefficients(body.stencil) / body.row_mass[:, None], mass.at(dt)
    u, w, v, calmed = np.zeros((4, body.n_rows, 2, body.n_sectors + 2 * HALO))
    calmed, rows = calmed if mass.calming else w, (int(body.free_rows[0]), int(body.free_rows[-1]) + 1)

    def step():
        kick_ring(table, u, w, None, *rows)
        wrap_all(w)
        if mass.calming:
            calm_ring(slowing.velocities / dt * table, w, calmed, np.zeros(len(w)), 0.0, *rows)
        find_velocities(slowing.waves * table, calmed, w, v, dt, body.raceway_row)
        drift_slowed_ring(slowing.waves * table, (u, w, v), calmed, dt, (*rows, body.raceway_row))

    return u, w, step


# ---- Compiled runs of the Lagrangian model, and their judge, `forward_motion`, which shares no step with them.

COMPARED = ("inner_x", "inner_y", "roller_rho", "inner_vy", "inner_ay", "roller_theta", "inner_force", "outer_force",
            "work_external", "work_dissipated", "housing_y", "housing_ay", "sensor_ay")  # fmt: skip
# m/s, m/s² and J, for motions of nanometres: 2e-5 of what a load of 2 kN makes of the hub; the reference's tolerance
FLOORS = {"inner_vy": 1e-7, "inner_ay": 0.5, "housing_ay": 0.5, "sensor_ay": 0.5, "work_external": 1e-11}


class Motion:
    def __init__(self, problem: Problem, interval: float = 1e-5, time_step: float | None = None):
        step = longest_step(problem) if time_step is None else time_step
        tilted = () if problem.axial is None else ("axial", *(("damping of tilt",) if problem.damping.acts else ()))
        scene = SimpleNamespace(
            cage=problem.cage, ideal_cage=lambda: problem.cage, model="lagrange", axial=problem.axial,
            bearing=SimpleNamespace(type="ball" if isinstance(problem.bearing, BallBearing) else "roller"),
            parts=(*problem.operation.mounting.parts, *(() if problem.cage is None else ("cage",)), *tilted),
            numerics=SimpleNamespace(output_interval_us=1e6 * interval),
        )  # fmt: skip
        stride = ceil(interval / step * (1.0 - 1e-12))
        facts = {"sections": None, "law_warning": None, "n_samples": 10**6, "stride": stride}
        self.problem, self.trouble = problem, None
        self.state = LagrangianState(LagrangianPlan(scene=scene, problem=problem, **facts))

    @property
    def time_step(self) -> float:
        return self.state.plan.time_step

    def advance(self, count: int) -> SimpleNamespace:
        """The next samples by their names, their energy error, and a cage's by names of `CageSamples`."""
        blocks: list[Samples] = []
        end = self.state.done + count
        while self.state.done < end and self.trouble is None:
            block = self.state.advance(end - self.state.done)
            blocks += [] if block.samples is None else [block.samples]
            self.trouble = block.trouble
        found = Samples.joined(blocks)
        values = found.values
        cage = {name.removeprefix("cage_"): value for name, value in values.items() if name.startswith("cage_")}
        return SimpleNamespace(
            **values, energy_error=found.imbalance, cage=SimpleNamespace(**cage),
            work_damping=values["work_damping_contact"], steps=round(values["time"][-1] / self.time_step),
        )  # fmt: skip

    def gone_on(self) -> "Motion":
        """Another one that goes on from what a checkpoint would keep of this."""
        arrays, numbers = self.state.to_keep()
        found = Motion(self.problem, self.state.plan.interval, self.time_step)
        found.state.done = self.state.done
        found.state.take_back({name: array.copy() for name, array in arrays.items()}, numbers)
        return found


def compiled(problem: Problem, count: int, interval: float = 1e-5, time_step: float | None = None) -> SimpleNamespace:
    return Motion(problem, interval, time_step).advance(count)


def solved(problem: Problem, duration: float, interval: float) -> SimpleNamespace:
    return compiled(problem, int(duration / interval + 1e-9) + 1, interval)


def assert_right(problem: Problem, count=31, interval=1e-5, share=2e-3, finer=2.0) -> None:
    """The usual step, so many times shorter, makes the reference's motion to this share of every quantity."""
    found = compiled(problem, count, interval, Motion(problem, interval).time_step / finer)
    exact = simulate(problem, (count - 1) * interval, interval)
    assert np.count_nonzero(np.ptp(exact.inner_force, axis=0) > 1.0) > 1  # something happens
    for name in (name for name in COMPARED if hasattr(found, name)):
        ours, right = (np.asarray(getattr(run, name)) for run in (found, exact))
        within(ours, right, share * np.abs(right).max() + FLOORS.get(name, 0.0), name)


# ---- States of a bearing whose contacts are pressed at random, and what contacts do to their bodies.

DT = 1e-7
PRESSED = 5e-6  # m, typical overlap of the circles
WAVY = 1e-6  # m, random displacement of every node: surfaces tilt by a milliradian


def set_turns(state, roller_turn, ring_turn):
    rollers = state.bodies.rollers
    rollers.turn[: rollers.n] = roller_turn
    rollers.cosine[:], rollers.sine[:] = np.cos(rollers.turn), np.sin(rollers.turn)
    state.drive.frame[:] = ring_turn, np.cos(ring_turn), np.sin(ring_turn)


def roller_field(state, flat):
    return flat.reshape(state.bodies.disc.mass.size, 2, state.bodies.rollers.columns)[:, :, : state.bodies.rollers.n]


def fill_ring(field, values):
    field[:, :, HALO:-HALO] = values
    field[:, :, HALO - 1], field[:, :, -HALO:] = field[:, :, -HALO - 1], field[:, :, HALO : 2 * HALO]


def random_state(seed, resolved=False, mesh_size=1e-3):
    """Rollers pressed on both raceways and two on each other, everything turned and wavy at random."""
    rng = np.random.default_rng(seed)
    whole = resolved_model(soft(), 2e-4) if resolved else model(paper(), mesh_size)
    state = copies(arrays(whole, operation(speed=300.0), DT, from_rest=True))
    rollers, n = state.bodies.rollers, state.bodies.rollers.n
    angle = np.cumsum(rng.uniform(0.95, 1.05, n)) * 2.0 * np.pi / n
    angle[4] = angle[3] + 2.0 * np.arcsin((rollers.radius - 0.5 * PRESSED) / 0.023)  # 3 and 4 press on each other
    rho = 0.023 + PRESSED * rng.uniform(-1.0, 1.0, n)
    rho[4] = rho[3]
    rollers.centre[:, :n] = rho * np.cos(angle), rho * np.sin(angle)
    state.drive.hub[:] = PRESSED * rng.uniform(-1.0, 1.0, 2)
    set_turns(state, rng.uniform(-np.pi, np.pi, n), rng.uniform(-np.pi, np.pi))
    shake(state, rng, "u", WAVY)
    return state


def shake(state, rng, name, size):
    bodies = state.bodies
    at = roller_field(state, getattr(bodies.disc, name))
    at[:] = size * rng.standard_normal(at.shape)
    for ring in (bodies.inner, bodies.outer):
        fill_ring(getattr(ring, name), size * rng.standard_normal((ring.radii.size, 2, ring.n_sectors)))


def press(state):
    state = copies(state)
    bodies, rollers, drive = state.bodies, state.bodies.rollers, state.drive
    for entry in (
        bodies.disc.w, bodies.inner.w, bodies.outer.w, rollers.node_impulse, rollers.body_impulse, rollers.turn_kick,
        drive.impulse, drive.moment, state.contacts.forces.force,
    ):  # fmt: skip
        entry[:] = 0.0
    press_contacts(state)
    push_surfaces(state)
    return state


def cartesian_resultant(ring, c=1.0, s=0.0):
    w = ring.w[:, :, HALO:-HALO] * ring.row_mass[:, None, None]
    cosine, sine = ring.cosines[HALO:-HALO], ring.sines[HALO:-HALO]
    x, y = np.sum(w[:, 0] * cosine - w[:, 1] * sine), np.sum(w[:, 0] * sine + w[:, 1] * cosine)
    return np.array([c * x - s * y, s * x + c * y])


def roller_resultants(state):
    rollers, n = state.bodies.rollers, state.bodies.rollers.n
    x, y = np.sum(roller_field(state, state.bodies.disc.w) * state.bodies.disc.mass[:, None, None], axis=0)
    c, s = rollers.cosine[:n], rollers.sine[:n]
    return np.column_stack([c * x - s * y, s * x + c * y])


# ---- States of random contacts that rub, with tangential springs and without.


def rubbing_state(seed=1, mesh_size=1e-3):
    state = pressed_state(seed, mesh_size)
    push_surfaces(state)
    state.drive.moment[0] = 0.0
    return state


def pressed_state(seed, mesh_size):
    state, rng = random_state(seed, mesh_size=mesh_size), np.random.default_rng(7)
    rollers, n = state.bodies.rollers, state.bodies.rollers.n
    shake(state, rng, "w", 1.0)
    rollers.velocity[:, :n] = rng.standard_normal((n, 2)).T
    rollers.spin[:n] = 500.0 * rng.standard_normal(n)
    state = with_friction(state, coefficient=0.1)
    state.contacts.forces.force[:] = 0.0
    state.drive.impulse[:] = 0.0
    press_contacts(state)
    for entry in (rollers.node_impulse, rollers.body_impulse, rollers.turn_kick):
        entry[:] = 0.0
    return state


def with_friction(state, **changes):
    return replace(state, contacts=state.contacts._replace(friction=state.contacts.friction._replace(**changes)))


def rub(state):
    """Friction at a copy; returns it, slips before and after, and the energy it takes, J."""
    state = with_friction(copies(state), whole=True)  # the normal forces' impulses have been given
    find_slips(state, state.bodies.rollers.turn_kick, state.contacts.friction.slip)
    before = state.contacts.friction.slip.copy()
    taken, after = rub_contacts(state), np.zeros_like(before)
    find_slips(state, state.bodies.rollers.turn_kick, after)
    return state, before, after, taken


def stretched_state():
    """Springs of closed contacts stretched at random, some beyond what sliding stretches them by, and slipping."""
    state, rng = rubbing_state(), np.random.default_rng(3)
    shear, force = state.contacts.friction.shear, state.contacts.forces.force
    shear.compliance[:] = 1e-9 * rng.uniform(1.0, 4.0, force.shape)
    shear.stretch[:] = 0.1 * force * shear.compliance * rng.uniform(-1.5, 1.5, force.shape)
    shear.stretch[rng.uniform(size=force.shape) < 0.2] = 0.0  # these have just closed
    shear.creep[:] = 1e-3 * np.sign(shear.stretch)
    shear.since[:] = DT * (shear.stretch != 0.0)
    state.bodies.rollers.velocity[:] *= 0.05
    return state

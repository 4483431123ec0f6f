"""What cases set in motion: whole bearings, and two free rollers thrown at each other."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np

from fem.contacts.critical_step import critical_time_step
from fem.elastic.reciprocal_mass import LUMPED
from fem.kernels.columns import ROLLER
from fem.solver.elements.arrays import make_arrays, rest_start
from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan
from fem.solver.solver import Samples
from lagrange import Bearing, Operation
from lagrange.scene.scene import read_scene
from tests.reference import compiled
from tests.reference.kit import LENGTH, STEEL_ON_STEEL, loop_arguments, model

# wide enough that rollers never reach a raceway
WIDE = Bearing(
    n_rollers=3, roller_radius=0.005, roller_length=LENGTH, inner_raceway_radius=0.018, outer_raceway_radius=0.029,
    bore_radius=0.0125, outside_radius=0.0325, **STEEL_ON_STEEL,
)  # fmt: skip
# the third roller stays far from the other two
NOTHING_ACTS = Operation(speed=0.0, radial_load=0.0, inner_mass=0.1, gravity=0.0, first_roller_angle=-0.5 * pi)
GAP = 1e-8  # m, before the first touch
LARGEST_FORCE = 2000.0  # N, about what 1 m/s makes
MAX_STEPS = 5000


def plan_of(**settings: float | str) -> ElementPlan:
    """The paper's scene but for these keys: `operation__speed_rpm=900`."""
    return make_plan(read_scene(None, tuple(f"{key.replace('__', '.')}={value}" for key, value in settings.items())))


def largest_stored(found: Samples) -> float:
    """Elastic and contact energy, J."""
    return float(np.max(found["energy_elastic"] + found["energy_contact"]))


def every_step(plan: ElementPlan, n_steps: int) -> ElementPlan:
    return replace(plan, stride=1, n_samples=n_steps + 1)


def without_spin(plan: ElementPlan) -> ElementPlan:
    """The plan with rollers that go round with the cage and do not turn."""
    return replace(plan, start=replace(plan.start, kinematics=replace(plan.start.kinematics, roller=0.0)))


def collide(velocities, mesh_size=1e-3, friction=0.0, spins=(0.0, 0.0), courant=0.5, n_after=200) -> SimpleNamespace:
    """Throw two undeformed rollers at each other along x, and follow them for some steps after they part.

    Parameters
    ----------
    velocities : (2, 2), m/s, of the left and the right roller; spins : rad/s
    mesh_size : m; courant : time step over the critical one

    Returns
    -------
    time_step and, a row a step, SI: force, traction, energy (n, 3: kinetic, elastic, contact), dissipated in each step,
    momentum (n, 2) of all rollers, angular_momentum about the origin, velocity (n, 2, 2) of the two centres of mass;
    duration, from first to last touch
    """
    whole = model(WIDE, mesh_size)
    dt = courant * critical_time_step(whole, LARGEST_FORCE)
    state = make_arrays(whole, NOTHING_ACTS, rest_start(whole, NOTHING_ACTS), dt, friction, 0.0, LARGEST_FORCE, LUMPED)
    rollers, disc, contacts = state.bodies.rollers, state.bodies.disc, state.contacts
    moving = (state.bodies, state.drive, state.scratch)
    shape, mass, points = (disc.mass.size, 2, rollers.columns), disc.mass[:, None], disc.points.reshape(-1, 2)
    field, total = disc.w.reshape(shape), rollers.total_mass
    for j, side in enumerate((-1.0, 1.0)):
        rollers.centre[:, j] = side * (rollers.radius + 0.5 * GAP), -0.0229
        rollers.velocity[:, j] = velocities[j]
        rollers.spin[j], rollers.increment[j] = spins[j], spins[j] * dt
        field[:, 0, j], field[:, 1, j] = -spins[j] * points[:, 1], spins[j] * points[:, 0]

    def step() -> list[float]:
        """Advance by one step; the quantities at its kick."""
        compiled.remember(*moving)
        compiled.kick(state.bodies, state.groups, contacts, state.drive, 0.0, state.scratch)
        energy = compiled.kinetic_energy(*moving), compiled.elastic_energy(*moving), compiled.contact_energy(state)
        place, w, n = points[:, :, None] + disc.u.reshape(shape), disc.w.reshape(shape), rollers.n
        own = np.sum(mass * (place[:, 0] * w[:, 1] - place[:, 1] * w[:, 0]))
        own += rollers.inertia * rollers.turn_kick[:n].sum()  # as `drift` does
        velocity, centre = (rollers.velocity[:, :n] + rollers.node_impulse[:, :n] / total).T, rollers.centre[:, :n].T
        orbital = total * np.sum(centre[:, 0] * velocity[:, 1] - centre[:, 1] * velocity[:, 0])
        force, traction = contacts.forces.force[ROLLER, 0], contacts.friction.traction[ROLLER, 0]
        found = [force, traction, *energy, *(total * velocity.sum(axis=0)), own + orbital, *velocity[:2].ravel()]
        return [*found, compiled.drift(*loop_arguments(state))]

    rows, since, touched = [], 0, False
    while since < n_after:
        if len(rows) == MAX_STEPS:
            raise RuntimeError(f"the rollers have not parted after {MAX_STEPS} steps")
        rows.append(step())
        touched = touched or rows[-1][0] > 0.0
        since = since + 1 if touched and rows[-1][0] == 0.0 else 0
    found = np.array(rows)
    touching = np.flatnonzero(found[:, 0] > 0.0)
    return SimpleNamespace(
        time_step=dt, force=found[:, 0], traction=found[:, 1], energy=found[:, 2:5], momentum=found[:, 5:7],
        angular_momentum=found[:, 7], velocity=found[:, 8:12].reshape(-1, 2, 2), dissipated=found[:, 12],
        duration=float((touching[-1] - touching[0] + 1) * dt) if len(touching) else 0.0,
    )  # fmt: skip

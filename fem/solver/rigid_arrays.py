"""The arrays of rigid bodies in their time loop, for every model that places them and closes their contacts."""

from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from fem.kernels.fields import filled
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.paces import INSIDE, ON_INNER_RING, ON_OUTER_RING, OUTSIDE, Paces
from fem.kernels.rigid.state import ReducedDrive, RigidBodies
from fem.solver.cage_arrays import cage_state, pair_of_rigid
from fem.solver.part_arrays import history_arrays, housing_of, springs_on
from fem.solver.rigid.plan import RigidPlan, spalls_met
from fem.solver.samples import row_width
from lagrange import Bearing, Operation, kinematics
from lagrange.bearing import Cage
from lagrange.kinematics import kinematics_met
from lagrange.surface.deviation import profiles

STILL = np.zeros(2)
BODIES = {"inner_ring": ON_INNER_RING, "outer_ring": ON_OUTER_RING, "inside": INSIDE, "outside": OUTSIDE}
CALM = 3e-5  # of the energy of load and strike: what a change to longer steps may miss
STEADY = 4.0  # times what rollers on their circles have of that: less is no vibration


class Placed(NamedTuple):
    """Where bodies are as the loop begins, half a step behind in velocity; m and m/s from the ground."""

    angle: np.ndarray  # (n_rollers,), rad
    hub: np.ndarray  # (2,)
    hub_velocity: np.ndarray  # (2,)
    centre: np.ndarray  # (2, n_rollers)
    velocity: np.ndarray  # (2, n_rollers)
    ring: np.ndarray  # (2,), of the outer ring in its housing
    ring_velocity: np.ndarray  # (2,)
    cage: np.ndarray  # (2,), of a free cage
    cage_velocity: np.ndarray  # (2,)


def columns_for(n_rollers: int) -> int:
    """Lanes for so many rollers, in whole registers."""
    return -(-n_rollers // WIDTH) * WIDTH


def rigid_bodies(
    bearing: Bearing, operation: Operation, cage: Cage | None, placed: Placed, dt: float, **of_model: Any
) -> RigidBodies:
    """Everything that moves; `cage` : one that moves freely; `of_model` : fields that only the model knows."""
    n, mounting = bearing.n_rollers, operation.mounting
    columns, mass = columns_for(n), float(operation.inner_mass)
    hub, hub_velocity = placed.hub.copy(), placed.hub_velocity.copy()
    housing = housing_of(mounting, bearing.outer_ring_mass, None, placed.ring, dt, row_width(n, None))
    if housing is not None:
        housing.velocity[:] = placed.ring_velocity
    bodies = filled(
        RigidBodies,
        {"columns": columns},
        hub=hub,
        hub_velocity=hub_velocity,
        hub_mass=mass,
        mass=float(bearing.roller_mass),
        radius=float(bearing.roller_radius),
        n=n,
        columns=columns,
        cage=None,
        shaft=springs_on(mounting, hub, hub_velocity, np.zeros((2, 2)), mass, n),
        housing=housing,
        **of_model,
    )
    bodies.centre[:, :n], bodies.velocity[:, :n] = placed.centre, placed.velocity
    if cage is None:
        return bodies
    speed = kinematics(bearing, *operation.ring_speeds).cage
    state = cage_state(bearing, cage, placed.angle, speed, row_width(n, None, mounting))
    state.motion[:2, :2] = placed.cage, placed.cage_velocity
    return bodies._replace(cage=pair_of_rigid(state, cage, bodies, float(operation.speed)))


def outer_drive(
    bearing: Bearing,
    operation: Operation,
    dt: float,
    ramp: float,
    friction: float = 0.0,
    growth: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> ReducedDrive:
    """What acts from outside, before any work.

    Parameters
    ----------
    dt, ramp : s, a step, and the time in which the load comes
    growth : m s², by which inner ring and roller together, and a roller, grow as the shaft turns, over its speed's
        square; and by which the outer raceway does, over its own
    """
    return filled(
        ReducedDrive,
        {},
        speed=float(operation.speed),
        gravity=float(operation.gravity),
        dt=float(dt),
        radial_load=float(operation.radial_load),
        ramp=float(ramp),
        friction=float(friction),
        inner_radius=float(bearing.inner_raceway_radius),
        history=history_arrays(bearing, operation, growth=growth[0], roller_growth=growth[1], outer_growth=growth[2]),
    )


def paces_of(plan: RigidPlan, drive: ReducedDrive) -> tuple[tuple[ReducedDrive, ...], Paces | None]:
    """The drive at every pace of a plan, and when which; None: there is one."""
    found, long, bearing = plan.sections, plan.long_step, plan.model.bearing
    if found is None:
        return (drive,), None
    spalls = list(spalls_met(bearing))
    where = [(BODIES[body], 0 if spall[0] is None else spall[0]) for body, _, spall, _ in spalls]
    arcs = [(middle, np.cos(min(half + found.margin / radius, pi))) for _, _, (_, middle, half), radius in spalls]
    smooth = profiles(bearing).shortest_of_waves == inf
    sensor, steps = plan.operation.mounting.sensor, (drive.dt, long)
    none, outward = (
        np.zeros((2, 2, 3)),
        bearing.pitch_radius * np.abs(kinematics_met(bearing, plan.operation).cage).max() ** 2,
    )
    steady = STEADY * bearing.n_rollers * bearing.roller_mass * outward**2
    paces = Paces(
        counts=np.array([found.near, found.far], dtype=np.intp),
        sections=found.count,
        now=np.zeros(1, dtype=np.intp),
        made=np.zeros(2, dtype=np.intp),
        where=np.array(where, dtype=np.intp),
        arcs=np.array(arcs),
        stiffness=float(2.0 * bearing.roller_mass / plan.critical_time_step**2),
        outward=float(outward),
        calm=float(steady + 12.0 * CALM * (plan.static_energy + found.strike) / long**2),
        smooth=smooth,
        step=none if sensor is None else np.array([sensor.step(dt) for dt in steps]),
        half_step=none if sensor is None else np.array([sensor.step(0.5 * dt) for dt in steps]),
    )
    return (drive, drive._replace(dt=float(long), looks=not smooth)), paces

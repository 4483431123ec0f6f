"""Two step lengths for bearings with spalls, for the time loop of rigid bodies: how its arrays say when which."""

from math import inf, pi
from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.reduced_paces import INSIDE, ON_INNER_RING, ON_OUTER_RING, OUTSIDE, Paces
from fem.kernels.reduced_state import ReducedDrive
from fem.solver.sections import spalls_met
from lagrange.kinematics import kinematics_met
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.lagrangian import LagrangianPlan
    from fem.solver.reduced import ReducedPlan

BODIES = {"inner_ring": ON_INNER_RING, "outer_ring": ON_OUTER_RING, "inside": INSIDE, "outside": OUTSIDE}
CALM = 3e-5  # of the energy of load and strike: what a change to longer steps may miss
STEADY = 4.0  # times what rollers on their circles have of that: less is no vibration


def paces_of(
    plan: "ReducedPlan | LagrangianPlan", drive: ReducedDrive
) -> tuple[tuple[ReducedDrive, ...], Paces | None]:
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

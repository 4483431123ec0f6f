"""The arrays of the reduced model's time loop, filled with a plan's start."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.fields import filled
from fem.kernels.lanes import WIDTH
from fem.kernels.reduced_state import (
    INNER,
    OUTER,
    UNEVEN,
    Compliance,
    Radiation,
    ReducedDrive,
    ReducedForces,
    RigidBodies,
)
from fem.solver.cage_arrays import cage_state, pair_of_rigid
from fem.solver.part_arrays import course_arrays, housing_of, raceway_profiles, rigid_dampers, springs_on
from fem.solver.samples import row_width
from fem.solver.vibrations import vibrations
from lagrange import Bearing, kinematics
from lagrange.equations import touching_distances
from lagrange.spinning import growths
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.reduced import ReducedPlan


def rigid_bodies(plan: "ReducedPlan") -> RigidBodies:
    """Everything that moves, half a step behind in velocity."""
    bearing, start, dt = plan.model.bearing, plan.start, plan.time_step
    n = bearing.n_rollers
    columns = -(-n // WIDTH) * WIDTH
    radial = np.array([np.cos(start.angle), np.sin(start.angle)])
    around = np.array([-radial[1], radial[0]])
    cage, half = start.kinematics.cage, 0.5 * dt if start.steady else 0.0
    load = (plan.operation.side_load, -plan.operation.radial_load) if start.steady else (0.0, 0.0)
    vibrating = vibrations(plan.model, start, load, columns, dt)
    carried = (
        np.zeros(2) if vibrating is None else np.einsum("ln,ltn->t", vibrating.inner.carried, vibrating.inner.amplitude)
    )
    bodies = filled(
        RigidBodies,
        {"columns": columns},
        hub=start.hub + start.ring - carried,
        hub_velocity=start.hub_velocity.copy(),
        hub_mass=float(plan.operation.inner_mass),
        mass=float(bearing.roller_mass),
        inertia=float(0.5 * bearing.roller_mass * bearing.roller_radius**2),
        radius=float(bearing.roller_radius),
        vibrations=vibrating,
        n=n,
        columns=columns,
        cage=None,
    )
    # steps take forces dt²/12 of the acceleration ahead, on a circle inwards; that far out they are the static ones
    bodies.centre[:, :n] = (1.0 + (half * cage) ** 2 / 3.0) * start.rho * radial + start.ring[:, None]
    bodies.velocity[:, :n] = start.rho_rate * radial + cage * start.rho * around + half * cage**2 * start.rho * radial
    bodies.spin[:n] = start.kinematics.roller
    hub = bodies.hub, bodies.hub_velocity, np.zeros((2, 2)), bodies.hub_mass
    shaft = springs_on(plan.operation.mounting, *hub, n)
    column = row_width(n, None)
    housing = housing_of(plan.operation.mounting, bearing.outer_ring_mass, None, start.ring, dt, column)
    bodies, ideal = bodies._replace(shaft=shaft, housing=housing), plan.scene.ideal_cage()
    if ideal is None:
        return bodies
    state = cage_state(bearing, ideal, start.angle, cage, row_width(n, None, plan.operation.mounting))
    state.motion[0, :2] = start.ring + plan.seat
    return bodies._replace(cage=pair_of_rigid(state, ideal, bodies, float(plan.operation.speed)))


def contact_compliance(plan: "ReducedPlan", columns: int) -> Compliance:
    """How contacts give way, on the surfaces of the plan's scene; `columns`: of the bodies' arrays."""
    model = plan.model
    reach, track = touching_distances(model.bearing)
    inner, outer = raceway_profiles(model.bearing, columns)
    apart = 2.0 * np.pi / model.bearing.n_rollers * np.arange(columns)
    return Compliance(
        inner=model.inner_law.constants,
        outer=model.outer_law.constants,
        between=model.between.constants,
        reach=float(reach + model.inner_growth + model.roller_growth),
        track=float(track - model.roller_growth),
        sag=model.sag,
        across=model.across,
        relaxation_factor=plan.relaxation_factor,
        **vars(model.rings),
        apart=np.array([np.cos(apart), np.sin(apart)]),
        tangential=plan.tangential,
        ring_profiles=(inner["profile"], outer["profile"]),
        roller_profiles=(inner["roller_profiles"], outer["roller_profiles"]),
    )


def contact_forces(plan: "ReducedPlan", columns: int) -> ReducedForces:
    """Contacts under the start's forces, with the accounts that the plan's scene asks for."""
    n, start = plan.model.bearing.n_rollers, plan.start
    rings = plan.model.rings
    halo = int(np.abs(rings.distance).max(initial=0))
    uneven = profiles(plan.model.bearing) is not None
    absent = () if uneven else UNEVEN
    absent += () if plan.strikes else ("ahead", "cut") if plan.model.modes is not None else ("ahead", "cut", "taken")
    found = filled(
        ReducedForces,
        {"columns": columns, "haloed": columns + 2 * halo, "lanes": WIDTH, "neighbours": rings.distance.size},
        along=np.repeat(rings.along[:, :, None], columns, axis=2),
        radiation=_radiation(plan, columns),
        halo=halo,
        dampers=rigid_dampers(plan.scene.damping.contacts, columns),
        **dict.fromkeys(absent),
    )
    for row, force in ((INNER, start.inner_force), (OUTER, start.outer_force)):
        found.force[row, :n] = force
        at = np.arange(-halo, n + halo)
        found.guess[row, : n + 2 * halo] = force[at % n]
    return found


def _radiation(plan: "ReducedPlan", columns: int) -> Radiation:
    return filled(
        Radiation,
        {"columns": columns},
        inertia=plan.waves.inertia,
        settling=1.0 / plan.waves.slowest,
        state=np.zeros(1, dtype=np.intp),
    )


def outer_drive(plan: "ReducedPlan") -> ReducedDrive:
    """What acts from outside, before any work."""
    bearing: Bearing = plan.model.bearing
    numerics, operation = plan.scene.numerics, plan.operation
    inner, roller = growths(bearing, kinematics(bearing, 1.0))
    return filled(
        ReducedDrive,
        {},
        speed=float(operation.speed),
        gravity=float(operation.gravity),
        dt=float(plan.time_step),
        radial_load=float(operation.radial_load),
        ramp=1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0,
        friction=float(plan.scene.friction_coefficient),
        inner_radius=float(bearing.inner_raceway_radius),
        course=course_arrays(bearing, operation, growth=inner + roller, roller_growth=roller),
    )

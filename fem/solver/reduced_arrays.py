"""The arrays of the reduced model's time loop, filled with a plan's start."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.fields import at_line, filled
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.state import (
    INNER,
    OUTER,
    UNEVEN,
    Contacts,
    Coupling,
    Radiation,
    ReducedDrive,
    ReducedForces,
    RigidBodies,
)
from fem.solver.part_arrays import rigid_dampers, surfaces_of
from fem.solver.rigid_arrays import STILL, Placed, outer_drive, rigid_bodies
from fem.solver.tilted_arrays import tilted_contacts, with_moments, with_tilts
from fem.statics.reduced_bearing import neighbours_of
from lagrange import kinematics
from lagrange.axial import SpalledTable
from lagrange.equations import touching_distances
from lagrange.fits import growths, outer_growth
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.rigid.reduced import ReducedPlan


def bodies_of(plan: "ReducedPlan") -> RigidBodies:
    """Everything that moves, half a step behind in velocity."""
    bearing, operation, start, dt = plan.model.bearing, plan.operation, plan.start, plan.time_step
    radial = np.array([np.cos(start.angle), np.sin(start.angle)])
    around = np.array([-radial[1], radial[0]])
    cage, half = start.kinematics.cage, 0.5 * dt if start.steady else 0.0
    placed = Placed(
        angle=start.angle,
        hub=start.hub + start.ring,
        hub_velocity=start.hub_velocity,
        # steps take forces dt²/12 of the acceleration ahead, on a circle inwards; that far out they are the static ones
        centre=(1.0 + (half * cage) ** 2 / 3.0) * start.rho * radial + start.ring[:, None],
        velocity=start.rho_rate * radial + cage * start.rho * around + half * cage**2 * start.rho * radial,
        ring=start.ring,
        ring_velocity=STILL,
        cage=start.ring + plan.seat,
        cage_velocity=STILL,
    )
    inertia = float(0.5 * bearing.roller_mass * bearing.roller_radius**2)
    free = plan.scene.ideal_cage()
    bodies = rigid_bodies(bearing, operation, free, placed, dt, inertia=inertia)
    bodies.spin[: bearing.n_rollers] = start.kinematics.roller
    axial = plan.scene.ideal_axial()
    if axial is None:
        return bodies
    return with_tilts(bodies, bearing, operation, axial, free, start.tilts)


def contacts_of(plan: "ReducedPlan", columns: int) -> Contacts:
    """Contacts on the surfaces of the plan's scene; `columns`: of the bodies' arrays."""
    model = plan.model
    reach, track = touching_distances(model.bearing)
    return Contacts(
        inner=model.inner_law.constants,
        outer=model.outer_law.constants,
        reach=float(reach + model.inner_growth + model.roller_growth),
        track=float(track - model.roller_growth + model.outer_growth),
        **surfaces_of(model.bearing, columns),
        sag=model.sag,
        coupling=_coupling(plan, columns),
        tilted=None if plan.tables is None else tilted_contacts(plan.tables, model.bearing, columns),
    )


def _coupling(plan: "ReducedPlan", columns: int) -> Coupling:
    """Compliances along the rings, of each roller by its neighbours."""
    model, bearing, rings = plan.model, plan.model.bearing, plan.model.rings
    found, at = neighbours_of(bearing, rings)
    pocket = np.arange(columns)
    pocket[: bearing.n_rollers] = np.array(bearing.pocket) - bearing.pocket[0]
    apart = 2.0 * np.pi / bearing.pockets * pocket

    def of_each(values: np.ndarray) -> np.ndarray:
        """(..., neighbours, columns) of (..., pockets)."""
        filled_in = np.zeros((*values.shape[:-1], at.shape[0], columns))
        filled_in[..., : at.shape[1]] = np.where(at >= 0, values[..., at], 0.0)
        return at_line(filled_in)

    return Coupling(
        between=model.between.constants,
        across=model.across,
        relaxation_factor=plan.relaxation_factor,
        **vars(found) | {name: of_each(getattr(rings, name)) for name in ("along", "steep", "bent", "crossed")},
        apart=np.array([np.cos(apart), np.sin(apart)]),
        tangential=plan.tangential,
    )


def contact_forces(plan: "ReducedPlan", columns: int, coupling: Coupling) -> ReducedForces:
    """Contacts under the start's forces, with the accounts that the plan's scene asks for."""
    n, start = plan.model.bearing.n_rollers, plan.start
    halo = int(np.abs(coupling.distance).max(initial=0))
    uneven = profiles(plan.model.bearing) is not None
    absent = () if uneven else UNEVEN
    if plan.tables is not None:  # with accounts of their own
        absent += "ahead", "cut"
    elif not plan.strikes:
        absent += "ahead", "cut", "taken"
    found = filled(
        ReducedForces,
        {"columns": columns, "haloed": columns + 2 * halo, "lanes": WIDTH, "neighbours": coupling.distance.size},
        along=at_line(coupling.along),
        radiation=_radiation(plan, columns) if plan.tables is None else None,
        halo=halo,
        dampers=rigid_dampers(plan.scene.damping.contacts, columns),
        **dict.fromkeys(absent),
    )
    for row, force in ((INNER, start.inner_force), (OUTER, start.outer_force)):
        found.force[row, :n] = force
        at = np.arange(-halo, n + halo)
        found.guess[row, : n + 2 * halo] = force[at % n]
    if start.inner_moment is None or start.outer_moment is None:
        return found
    spalled = any(isinstance(table, SpalledTable) for table in plan.tables or ())
    return with_moments(found, start.inner_moment, start.outer_moment, plan.model.bearing, spalled)


def _radiation(plan: "ReducedPlan", columns: int) -> Radiation:
    return filled(
        Radiation,
        {"columns": columns},
        inertia=plan.waves.inertia,
        settling=1.0 / plan.waves.slowest,
        state=np.zeros(1, dtype=np.intp),
    )


def drive_of(plan: "ReducedPlan") -> ReducedDrive:
    """What acts from outside, before any work."""
    bearing, numerics, operation = plan.model.bearing, plan.scene.numerics, plan.operation
    (inner, roller), outer = (
        growths(bearing, kinematics(bearing, 1.0)),
        outer_growth(bearing, kinematics(bearing, 0.0, 1.0)),
    )
    ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
    friction = float(plan.scene.friction_coefficient)
    return outer_drive(bearing, operation, plan.time_step, ramp, friction, (inner + roller, roller, outer))

"""The arrays of the reduced model's time loop, filled with a plan's start."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.fields import at_line, filled
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
    Spacing,
)
from fem.kernels.tilted_contacts import Tilted
from fem.solver.part_arrays import raceway_profiles, rigid_dampers
from fem.solver.rigid_arrays import STILL, Placed, outer_drive, rigid_bodies
from fem.solver.tilted_arrays import tilted, with_moments, with_tilts
from fem.statics.reduced_bearing import RingCouplings, neighbours_of
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


def contact_compliance(plan: "ReducedPlan", columns: int) -> Compliance | Tilted:
    """Compliance of the contacts on the surfaces of the plan's scene; `columns`: of the bodies' arrays."""
    model = plan.model
    reach, track = touching_distances(model.bearing)
    inner, outer = raceway_profiles(model.bearing, columns)
    rings, spacing = _couplings(plan, columns)
    pocket = np.arange(columns)
    pocket[: model.bearing.n_rollers] = np.array(model.bearing.pocket) - model.bearing.pocket[0]
    apart = 2.0 * np.pi / model.bearing.pockets * pocket
    found = Compliance(
        inner=model.inner_law.constants,
        outer=model.outer_law.constants,
        between=model.between.constants,
        reach=float(reach + model.inner_growth + model.roller_growth),
        track=float(track - model.roller_growth + model.outer_growth),
        sag=model.sag,
        across=model.across,
        relaxation_factor=plan.relaxation_factor,
        **vars(rings),
        apart=np.array([np.cos(apart), np.sin(apart)]),
        tangential=plan.tangential,
        ring_profiles=(inner["profile"], outer["profile"]),
        roller_profiles=(inner["roller_profiles"], outer["roller_profiles"]),
        spacing=spacing,
    )
    return found if plan.tables is None else tilted(found, plan.tables, model.bearing)


def _couplings(plan: "ReducedPlan", columns: int) -> tuple[RingCouplings, Spacing | None]:
    """Along the rings by neighbours, and of each roller where some are missing."""
    bearing, rings = plan.model.bearing, plan.model.rings
    if not bearing.missing:
        return rings, None
    found, at = neighbours_of(bearing, rings)

    def of_each(values: np.ndarray) -> np.ndarray:
        """(..., neighbours, columns) of (..., pockets)."""
        filled_in = np.zeros((*values.shape[:-1], at.shape[0], columns))
        filled_in[..., : at.shape[1]] = np.where(at >= 0, values[..., at], 0.0)
        return at_line(filled_in)

    return found, Spacing(**{name: of_each(getattr(rings, name)) for name in Spacing._fields})


def contact_forces(plan: "ReducedPlan", columns: int) -> ReducedForces:
    """Contacts under the start's forces, with the accounts that the plan's scene asks for."""
    n, start = plan.model.bearing.n_rollers, plan.start
    rings, spacing = _couplings(plan, columns)
    halo = int(np.abs(rings.distance).max(initial=0))
    uneven = profiles(plan.model.bearing) is not None
    absent = () if uneven else UNEVEN
    if plan.tables is not None:  # with accounts of their own
        absent += "ahead", "cut", "taken"
    absent += () if plan.strikes else ("ahead", "cut", "taken")
    found = filled(
        ReducedForces,
        {"columns": columns, "haloed": columns + 2 * halo, "lanes": WIDTH, "neighbours": rings.distance.size},
        along=np.repeat(rings.along[:, :, None], columns, axis=2) if spacing is None else spacing.along.copy(),
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

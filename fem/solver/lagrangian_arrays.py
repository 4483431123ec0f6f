"""The Lagrangian model's bodies and contacts as arrays of the time loop of rigid bodies."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.bodies import TWELFTH
from fem.kernels.fields import filled
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.rays import Prescribed
from fem.kernels.rigid.state import UNEVEN, Contacts, PowerConstants, ReducedForces, RigidBodies
from fem.kernels.state import Law
from fem.solver.part_arrays import rigid_dampers, surfaces_of
from fem.solver.rigid_arrays import Placed, columns_for, rigid_bodies
from fem.solver.samples import row_width
from fem.solver.tilted_arrays import tilted_contacts, with_moments, with_tilts
from lagrange import kinematics
from lagrange.axial import ContactTable, SpalledTable, contact_tables
from lagrange.axial.facts import Axial
from lagrange.axial.slices import steepest_slope
from lagrange.contact.laws import LogarithmicLaw, PowerLaw
from lagrange.equations import touching_distances
from lagrange.first_state import Problem
from lagrange.step_size import expected_force
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.rigid.lagrangian import LagrangianPlan


def bodies_of(plan: "LagrangianPlan") -> RigidBodies:
    """Everything that moves: half a step behind in velocity, and where forces a little ahead are those of the start."""
    problem, begin, dt = plan.problem, plan.begin, plan.time_step
    bearing, operation = problem.bearing, problem.operation
    half, ahead, mounting = 0.5 * dt, TWELFTH * dt**2, operation.mounting
    ring_velocity = np.zeros(2)
    if mounting.housing is not None:
        mass = mounting.housing.mass + bearing.outer_ring_mass
        ring_velocity = -_gained(begin.ring_acceleration, half, mass, mounting.housing)
    placed = Placed(
        angle=begin.angle,
        hub=begin.hub - ahead * begin.hub_acceleration,
        hub_velocity=begin.hub_velocity
        - _gained(begin.hub_acceleration, half, float(operation.inner_mass), mounting.shaft),
        centre=begin.centre - ahead * begin.pushed,
        velocity=begin.velocity - half * begin.acceleration,
        ring=begin.ring - ahead * begin.ring_acceleration,
        ring_velocity=ring_velocity,
        cage=begin.ring,
        cage_velocity=np.array([0.0, half * operation.gravity]),
    )
    n, held, ideal = bearing.n_rollers, problem.angles == "kinematic", kinematics(bearing, 1.0)
    by_outer = kinematics(bearing, 0.0, 1.0)
    rays = np.zeros((2, columns_for(n)))
    rays[:, :n] = np.cos(begin.angle), np.sin(begin.angle)
    shown = held and plan.scene.ideal_cage() is not None
    prescribed = Prescribed(
        spin=float(ideal.roller),
        cage=float(ideal.cage),
        spin_by_outer=float(by_outer.roller),
        cage_by_outer=float(by_outer.cage),
        first=rays if held else None,
        force=np.zeros(columns_for(n)),
        work=np.zeros(2),
        column=row_width(n, None, mounting) if shown else -1,
    )
    of_model = {"inertia": np.inf, "prescribed": prescribed}  # their spin is prescribed
    free = None if problem.free_cage is None else plan.scene.ideal_cage()
    bodies = rigid_bodies(bearing, operation, free, placed, dt, **of_model)
    tilts = problem.first_state.state.tilts
    if problem.axial is None or tilts is None:
        return bodies
    return with_tilts(bodies, bearing, operation, problem.axial, plan.scene.ideal_cage(), tilts)


def _gained(acceleration: np.ndarray, half: float, mass: float, springs) -> np.ndarray:
    """Velocity that a body gains in half a step, s, with its dashpot's share at the end of it."""
    return half * acceleration / (1.0 + half * (0.0 if springs is None else springs.damping) / mass)


def contacts_of(problem: Problem, times: float) -> Contacts:
    """Contacts on the surfaces of a problem; `times` : see `tables_of`."""
    reach, track = touching_distances(problem.bearing)
    columns, inner, outer, tilted = columns_for(problem.bearing.n_rollers), None, None, None
    if problem.axial is None:
        inner, outer = _constants(problem.laws.inner), _constants(problem.laws.outer)
    else:
        tilted = tilted_contacts(tables_of(problem, problem.axial, times), problem.bearing, columns)
    return Contacts(
        inner=inner,
        outer=outer,
        reach=float(reach),
        track=float(track),
        **surfaces_of(problem.bearing, columns),
        tilted=tilted,
    )


def tables_of(
    problem: Problem, axial: Axial, times: float = 1.0
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:
    """Tables made of the slices that the reference has, up to a few times the largest static force, or `times` that."""
    bearing, laws, force = problem.bearing, (problem.laws.inner, problem.laws.outer), times * expected_force(problem)
    slope = steepest_slope(bearing, axial, problem.operation.misalignment, float(laws[0].approach(force)))
    return contact_tables(bearing, axial, laws, force, slope)


def _constants(law) -> PowerConstants | Law:
    """A law as kernels take it."""
    if isinstance(law, PowerLaw):
        return PowerConstants(stiffness=float(law.stiffness), exponent=float(law.exponent))
    if isinstance(law, LogarithmicLaw):  # S Q (B − ln Q) is 2S Q (½B − ½ ln Q); widths play no part
        A, B = float(2.0 * law.compliance), float(0.5 * law.level)
        return Law(A=A, B=B, Q_line=float(law.largest_force), half_width_factor=0.0, curvature=0.0)
    raise TypeError(f"{type(law).__name__}: no compiled form of such a law; see `fem.kernels.rigid.contacts.law_force`")


def contact_forces(plan: "LagrangianPlan") -> ReducedForces:
    """Contacts under the start's forces; what neighbours tell each other has no room."""
    problem, start, n = plan.problem, plan.begin.samples, plan.problem.bearing.n_rollers
    columns = columns_for(n)
    absent = () if profiles(problem.bearing) is not None else UNEVEN
    absent += ("taken",) if problem.axial is None else ("ahead", "cut")
    found = filled(
        ReducedForces,
        {"columns": columns, "haloed": 0, "lanes": WIDTH, "neighbours": 0},
        first=np.full((2, columns), np.nan),
        tilt=np.zeros((2, 0)),
        lifted=np.zeros((2, 2, 0)),
        radiation=None,
        halo=0,
        dampers=rigid_dampers(problem.damping, columns),
        **dict.fromkeys(absent),
    )
    for row, force in enumerate((start["inner_force"], start["outer_force"])):
        found.force[row, :n] = found.estimate[row, :n] = force[0]
    if problem.axial is None:
        return found
    spalled = any(part is not None for part in problem.axial.parts(problem.bearing))
    return with_moments(found, start["inner_moment"][0], start["outer_moment"][0], problem.bearing, spalled)

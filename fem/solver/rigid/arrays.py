"""Arrays of rigid bodies and their contacts in their time loop, for every model that places them."""

from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from fem.kernels.fields import at_line, filled
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.paces import INSIDE, ON_INNER_RING, ON_OUTER_RING, OUTSIDE, Paces
from fem.kernels.rigid.state import (
    UNEVEN,
    Contacts,
    Coupling,
    PowerConstants,
    Radiation,
    ReducedDrive,
    ReducedForces,
    RigidBodies,
    TiltedContacts,
    TiltedDampers,
)
from fem.kernels.state import Law
from fem.kernels.tilts import TiltedForces
from fem.solver.parts import (
    cage_state,
    history_arrays,
    housing_of,
    laws_of,
    pair_of_rigid,
    part_profiles,
    rigid_dampers,
    springs_on,
)
from fem.solver.rigid.plan import RigidPlan, spalls_met
from fem.solver.samples import row_width
from fem.statics.reduced_bearing import ReducedBearing, neighbours_of
from lagrange import Bearing, Operation
from lagrange.axial import ContactTable, SpalledTable
from lagrange.bearing import Cage
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import LogarithmicLaw, PowerLaw
from lagrange.kinematics import kinematics, kinematics_met
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


def tilted_contacts(
    tables: tuple[ContactTable | SpalledTable, ContactTable | SpalledTable], bearing: Bearing, columns: int
) -> TiltedContacts:
    """What contacts of rollers that tilt have beside those of parallel axes."""
    length, (laws, rests) = float(bearing.roller_length), laws_of(tables)
    part = None if rests[0] is None else part_profiles(bearing, columns)
    return TiltedContacts(tables=laws, rests=rests, part=part, share=12.0 / length**2, length=length)


def coupling_of(model: ReducedBearing, relaxation_factor: float, tangential: np.ndarray) -> Coupling:
    """Compliances along the rings, by each roller's neighbours; `tangential` : (3,), m/N, of contacts that stick."""
    bearing, rings, columns = model.bearing, model.rings, columns_for(model.bearing.n_rollers)
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
        relaxation_factor=relaxation_factor,
        **vars(found) | {name: of_each(getattr(rings, name)) for name in ("along", "steep", "bent", "crossed")},
        apart=np.array([np.cos(apart), np.sin(apart)]),
        tangential=tangential,
    )


def contact_forces(
    bearing: Bearing,
    contacts: Contacts,
    forces: tuple[np.ndarray, np.ndarray],
    moments: tuple[np.ndarray, np.ndarray],
    damping: ContactDamping,
    absent: tuple[str, ...],
    radiation: Radiation | None = None,
) -> ReducedForces:
    """Contacts under a start's forces, N, and, where they tilt, moments, N m, of inner and outer ones, (n_rollers,).

    `absent` : accounts that are not kept. Where contacts are not coupled what neighbours tell each other has no room.
    """
    columns, n, halo, coupling = columns_for(bearing.n_rollers), bearing.n_rollers, 0, contacts.coupling
    dampers = rigid_dampers(damping, columns)
    if coupling is None:
        sizes = {"columns": columns, "haloed": 0, "lanes": WIDTH, "neighbours": 0}
        known = {"first": np.full((2, columns), np.nan), "tilt": np.zeros((2, 0)), "lifted": np.zeros((2, 2, 0))}
    else:
        halo = int(np.abs(coupling.distance).max(initial=0))
        sizes = {"columns": columns, "haloed": columns + 2 * halo, "lanes": WIDTH, "neighbours": coupling.distance.size}
        known = {"along": at_line(coupling.along)}
    absent += () if profiles(bearing) is not None else UNEVEN
    around = np.arange(-halo, n + halo) % n
    known |= dict.fromkeys(absent)
    found = filled(ReducedForces, sizes, radiation=radiation, halo=halo, dampers=dampers, **known)
    for row, force in enumerate(forces):
        found.force[row, :n] = force
        if coupling is None:
            found.estimate[row, :n] = force
        else:
            found.guess[row, : around.size] = force[around]
    if contacts.tilted is None:
        return found
    absent = (() if contacts.tilted.part is not None else ("sunken",)) + (() if found.slope is not None else ("edges",))
    tilted = filled(TiltedForces, sizes, **dict.fromkeys(absent))
    for row, moment in enumerate(moments):
        tilted.moment[row, :n] = moment
        if coupling is not None:
            tilted.guess[row, : around.size] = moment[around]
    if dampers is not None:
        over_reach, length = 1.0 / (bearing.inner_raceway_radius + bearing.roller_radius), float(bearing.roller_length)
        dampers = dampers._replace(tilted=filled(TiltedDampers, sizes, over_reach=over_reach, length=length))
    return found._replace(tilted=tilted, dampers=dampers)


def law_constants(law) -> PowerConstants | Law:
    """A law as kernels take it."""
    if isinstance(law, PowerLaw):
        return PowerConstants(stiffness=float(law.stiffness), exponent=float(law.exponent))
    if isinstance(law, LogarithmicLaw):  # S Q (B − ln Q) is 2S Q (½B − ½ ln Q); widths play no part
        A, B = float(2.0 * law.compliance), float(0.5 * law.level)
        return Law(A=A, B=B, Q_line=float(law.largest_force), half_width_factor=0.0, curvature=0.0)
    raise TypeError(f"{type(law).__name__}: no compiled form of such a law; see `fem.kernels.rigid.contacts.law_force`")

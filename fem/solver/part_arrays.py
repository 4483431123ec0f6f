"""Parts of a scene as the time loops' named tuples: bore, shaft, housing, load history, dampers, surfaces."""

from dataclasses import replace
from math import expm1, inf
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.kernels.bore import Bore
from fem.kernels.drive import N_NOW, N_OUTER_NOW
from fem.kernels.fields import at_line, filled
from fem.kernels.housing_kernels import Housing, Resonator
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.state import ReducedDampers
from fem.kernels.shaft import Shaft, late_mass
from fem.kernels.state import BodyDamping, Dampers, Drive, LoadHistory, OuterTurn, Ring, RingProfile, RollerProfiles
from fem.kernels.tilted_contact import PartProfiles
from fem.solver.run_arrays import Arrays
from fem.solver.samples import row_places
from lagrange import Bearing, Kinematics, Operation
from lagrange.contact.damping import ContactDamping
from lagrange.mounting import Mounting, Sensor
from lagrange.scene.run import DampingTable
from lagrange.surface.deviation import Profile, profiles

if TYPE_CHECKING:  # needs the finite elements' libraries
    from fem.contacts.model import Model
    from fem.elastic.bodies import RingBody


def bore_body(
    body: "RingBody", ring: Ring, outer_rate: np.ndarray, housing: Housing | None, column: int
) -> Bore | None:
    """The bore of a housing, or of the ground; None where the ring is held otherwise.

    Parameters
    ----------
    outer_rate : (n_rows, 2, n_sectors), m/s, of the ring's nodes at the start; column : of a row, the first for it
    """
    from fem.elastic.outer_support import BoredRing  # needs libraries that a reduced model does without

    if not isinstance(body, BoredRing):
        return None
    return filled(
        Bore,
        {"n_sectors": body.n_sectors, "width": ring.w.shape[2]},
        ring=ring,
        place=np.zeros(2) if housing is None else housing.place,
        impulse=np.zeros(2) if housing is None else housing.impulse,  # the ground's, which nobody reads
        velocity=body.cartesian(outer_rate).reshape(body.n_rows, -1, 2)[body.held_row].mean(axis=0),
        play=float(body.play),
        stiffness=float(body.stiffness),
        column=column,
    )


def shaft_springs(mounting: Mounting, drive: Drive, n: int) -> Shaft | None:
    """Springs and dashpots on the finite elements' hub, of n rollers; None where nothing holds the shaft."""
    return springs_on(mounting, drive.hub, drive.velocity, drive.slowed, drive.mass, n)


def springs_on(
    mounting: Mounting, hub: np.ndarray, velocity: np.ndarray, slowed: np.ndarray, mass: float, n: int
) -> Shaft | None:
    """The same on a hub with its place and velocity, (2,), m and m/s; `slowed` : (2, 2), m, as `Drive`'s."""
    shaft = mounting.shaft
    if shaft is None:
        return None
    return filled(
        Shaft,
        {},
        place=hub,
        velocity=velocity,
        slowed=slowed,
        before=velocity.copy(),
        mass=float(mass),
        stiffness=float(shaft.stiffness),
        damping=float(shaft.damping),
        column=row_places(n, mounting.parts)["energy_shaft"],
    )


def housing_body(
    model: "Model", operation: Operation, ring: Ring, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The housing at rest at a place, (2,), m, its outer ring with it; None where the ground holds the ring.

    `column` : of a sample's row, the first for it
    """
    mounting, body = operation.mounting, model.outer_ring
    if mounting.housing is None:
        return None
    from fem.elastic.outer_support import BoredRing  # as those above

    if isinstance(body, BoredRing):  # which moves by itself
        return housing_of(mounting, 0.0, None, place, dt, column)
    rigid = body.material.rigid
    carried = body.total_mass if rigid else body.n_sectors * body.row_mass[body.held_row]
    return housing_of(mounting, carried, None if rigid else ring, place, dt, column)


def housing_of(
    mounting: Mounting, carried: float, ring: Ring | None, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The same with a ring of which so much, kg, moves as a whole; None for one without a mesh, or free in its bore."""
    housing, sensor = mounting.housing, mounting.sensor
    if housing is None:
        return None
    return filled(
        Housing,
        {"width": 0 if ring is None else ring.u.shape[2]},
        place=place.copy(),
        ring=ring,
        sensor=None if sensor is None else _resonator(sensor, dt),
        mass=float(housing.mass + carried),
        late_mass=late_mass(float(housing.mass + carried), float(housing.damping), dt),
        stiffness=float(housing.stiffness),
        damping=float(housing.damping),
        column=column,
    )


def _resonator(sensor: Sensor, dt: float) -> Resonator:
    return filled(
        Resonator,
        {},
        step=np.ascontiguousarray(sensor.step(dt)),
        half_step=np.ascontiguousarray(sensor.step(0.5 * dt)),
        pull=sensor.pull,
    )


def history_arrays(
    bearing: Bearing,
    operation: Operation,
    *,
    growth: float = 0.0,
    roller_growth: float = 0.0,
    outer_growth: float = 0.0,
) -> LoadHistory | None:
    """None where nothing changes.

    Parameters
    ----------
    growth, roller_growth : m s², of the distances at which a roller touches the inner ring, and the outer one, by the
        square of the shaft's speed
    outer_growth : m s², of the outer raceway's radius, by the square of the outer ring's
    """
    found = operation.history
    if found is None:
        return None
    return filled(
        LoadHistory,
        {"n_now": N_NOW},
        turn_knots=found.turn.x.copy(),
        turn=np.ascontiguousarray(found.turn.c[::-1].T),
        load_knots=found.load.x.copy(),
        load=np.ascontiguousarray(found.load.c[::-1].swapaxes(0, 1)),
        drive_work=np.array([0.0, np.nan, 0.0]),
        unbalance=float(found.unbalance),
        unbalance_angle=float(found.unbalance_angle),
        outer=_outer_turn(bearing, operation, outer_growth),
        rotating_load=float(found.rotating_load),
        rotating_load_angle=float(found.rotating_load_angle),
        growth=float(growth),
        roller_growth=float(roller_growth),
    )


def _outer_turn(bearing: Bearing, operation: Operation, growth: float) -> OuterTurn | None:
    """What turns an outer ring; None where it stands still."""
    found = operation.history
    if found is None or found.outer_turn is None:
        return None
    return filled(
        OuterTurn,
        {"n_outer_now": N_OUTER_NOW},
        turn_knots=found.outer_turn.x.copy(),
        turn=np.ascontiguousarray(found.outer_turn.c[::-1].T),
        frame=np.array([0.0, 1.0, 0.0]),
        drive_work=np.array([0.0, np.nan, 0.0]),
        radius=float(bearing.outer_raceway_radius),
        speed=float(operation.outer_speed),
        growth=float(growth),
        carries_load=found.rotating_load_with == "outer_ring",
    )


def with_damping(arrays: Arrays, model: "Model", table: DampingTable) -> Arrays:
    """The arrays with what a scene's [damping] says; themselves where it says nothing."""
    contacts, bodies, dt = arrays.contacts, arrays.bodies, arrays.drive.dt
    if table.contacts.acts:
        levels = np.array(model.kernel_data(1.0).whole_levels)
        shape = contacts.forces.force.shape
        contacts = contacts._replace(dampers=_dampers(table.contacts, levels, shape))
    if table.bodies_1_s > 0.0:
        step = table.bodies_1_s * dt
        around = [body for body in bodies.others if isinstance(body, Bore | Housing)]  # a housing's bore first
        turning = None if arrays.drive.history is None else arrays.drive.history.outer
        damping = filled(BodyDamping, {}, share=-expm1(-step), around=around[0] if around else turning)
        bodies = bodies._replace(damping=damping)
    return replace(arrays, contacts=contacts, bodies=bodies)


def _dampers(damping: ContactDamping, levels: np.ndarray, shape: tuple[int, int]) -> Dampers:
    """At rest. `levels` : of the contacts' whole approach; `shape` : pairs and columns."""
    return filled(
        Dampers,
        dict(zip(("pairs", "columns"), shape, strict=True)),
        law=damping,
        whole=levels,
    )


def raceway_profiles(bearing: Bearing, columns: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the inner and the outer raceway's `Pair` know of surfaces that are not perfect.

    Both raceways have a profile where one has, and so one type and one code.
    """
    surfaces = profiles(bearing)
    if surfaces is None:
        nothing = {"profile": None, "roller_profiles": None}
        return nothing, nothing
    on_rings, on_rollers = _profiles_met(list(vars(surfaces).values()), columns)
    return tuple(
        {"profile": ring, "roller_profiles": roller} for ring, roller in zip(on_rings, on_rollers, strict=True)
    )


def surfaces_of(bearing: Bearing, columns: int) -> dict[str, tuple]:
    """The same as fields of contacts of rigid bodies."""
    inner, outer = raceway_profiles(bearing, columns)
    return {
        "ring_profiles": (inner["profile"], outer["profile"]),
        "roller_profiles": (inner["roller_profiles"], outer["roller_profiles"]),
    }


def part_profiles(bearing: Bearing, columns: int) -> PartProfiles:
    """What the part of the rollers' length that spalls take meets besides."""
    every = vars(profiles(bearing)).values()
    return PartProfiles(*_profiles_met([None if profile is None else profile.part for profile in every], columns))


def _profiles_met(every: list[Profile | None], columns: int) -> tuple[tuple, tuple]:
    """Of both rings, and of rollers in their contacts with them, in the order of `Profiles`."""
    rings, rollers, on_rings, on_rollers = every[:2], every[2:], (None, None), (None, None)
    if any(ring is not None for ring in rings):
        on_rings = tuple(_ring_profile(ring) for ring in rings)
    if all(roller is not None for roller in rollers):
        on_rollers = tuple(_roller_profiles(roller, columns) for roller in rollers)
    return on_rings, on_rollers


def time_along_a_knot(bearing: Bearing, ideal: Kinematics) -> float:
    """Time in which contacts roll over the shortest knot of a profile, s; infinite on perfect circles, or standing."""
    surfaces = profiles(bearing)
    # of contacts along every surface
    speed = float(np.abs(ideal.cage - ideal.outer_ring).max()) * bearing.outer_raceway_radius
    return inf if surfaces is None or speed == 0.0 else surfaces.shortest / speed


def _ring_profile(profile: Profile | None) -> RingProfile:
    sinkage = np.zeros(WIDTH) if profile is None else profile.coefficients[0]
    soft = None if profile is None or profile.compliance is None else profile.compliance[0]
    return RingProfile(sinkage=at_line(sinkage), compliance=at_line(np.zeros_like(sinkage) if soft is None else soft))


def _roller_profiles(profile: Profile, columns: int) -> RollerProfiles:
    first = np.zeros(columns, dtype=np.int64)
    first[: profile.row.size] = profile.row * profile.coefficients.shape[1]
    soft = np.zeros_like(profile.coefficients) if profile.compliance is None else profile.compliance
    return RollerProfiles(sinkage=at_line(profile.coefficients), compliance=at_line(soft), first=at_line(first))


def rigid_dampers(damping: ContactDamping, columns: int) -> ReducedDampers | None:
    """Dampers of contacts between rigid bodies, at rest; None where a scene has none."""
    if not damping.acts:
        return None
    return filled(ReducedDampers, {"columns": columns, "lanes": WIDTH}, law=damping)

"""Parts of a scene as the time loops' named tuples: shaft, housing, load history, surfaces, cage, axes that tilt."""

from math import inf, sqrt
from typing import Any

import numpy as np

import fem.kernels.cage as kernels
from fem.kernels.cage import CageContacts, CagePair, GuidingRing, Riders
from fem.kernels.drive import N_NOW, N_OUTER_NOW
from fem.kernels.fields import at_line, filled, lined_up
from fem.kernels.housing_kernels import Housing, Resonator
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.state import ReducedDampers, RigidBodies
from fem.kernels.shaft import Shaft, late_mass
from fem.kernels.state import (
    LoadHistory,
    OuterTurn,
    Ring,
    RingProfile,
    RollerProfiles,
)
from fem.kernels.tilted_contact import PartProfiles, SpalledRest, TiltedLaw
from fem.kernels.tilts import Tilts as TiltArrays
from fem.solver.samples import row_places, row_width
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial import ContactTable, SpalledTable
from lagrange.axial.facts import Axial
from lagrange.bearing import Cage
from lagrange.contact.damping import ContactDamping
from lagrange.errors import UsageError
from lagrange.kinematics import kinematics
from lagrange.mounting import Mounting, Sensor
from lagrange.surface.deviation import Profile, profiles
from lagrange.tilt import Tilts, hub_axial_inertia, hub_tilt, roller_inertias


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


FINEST = 1e-4  # µm: a place is found to so much


def cage_seat(
    bearing: Bearing, cage: Cage | None, angle: np.ndarray, rho: np.ndarray, hub: np.ndarray, force: float
) -> np.ndarray:
    """The centre of a cage, (2,), m, from the outer ring's: there, or if it does not fit, where it is least wedged.

    Parameters
    ----------
    angle, rho : ndarray, (n_rollers,), rad and m, of the rollers in equilibrium; hub : ndarray, (2,), m
    force : N, largest of the raceways' contacts

    Errors
    ------
    UsageError: wherever it stands, rollers or its guide wedge it with more than that force.
    """
    middle = np.zeros(2)
    if cage is None:
        return middle
    outward = np.array([np.cos(angle), np.sin(angle)])
    around = np.array([-outward[1], outward[0]])
    off = (rho - bearing.pitch_radius) * outward  # of pockets' middles, if the cage is in the middle

    def wedged(place: np.ndarray) -> float:
        """How far its tightest contact is closed, m."""
        if cage.guidance == "rollers":
            return float(np.hypot(*(off - place[:, None])).max()) - 0.5 * cage.pocket_clearance
        from_guide = place - hub if cage.guidance == "inner_ring" else place
        in_guide = float(np.hypot(*from_guide)) - 0.5 * (cage.guidance_clearance or 0.0)
        return max(float(np.abs(place @ around).max()) - 0.5 * cage.pocket_clearance, in_guide)

    if wedged(middle) <= 0.0:
        return middle
    from scipy.optimize import minimize  # which other runs save

    options = {"xatol": FINEST, "fatol": FINEST}
    found = minimize(lambda place: 1e6 * wedged(1e-6 * place), 1e6 * hub, method="Nelder-Mead", options=options)
    left, place = 1e-6 * float(found.fun), 1e-6 * found.x
    if cage.stiffness * left > force:
        clearances = f"cage.pocket_clearance_mm = {1e3 * cage.pocket_clearance:g}"
        if cage.guidance_clearance is not None:
            clearances += f", cage.guidance_clearance_mm = {1e3 * cage.guidance_clearance:g}"
        raise UsageError(
            f"{clearances}: where rollers and rings are in equilibrium the cage does not fit: wherever it stands, a "
            f"contact of it is closed by {1e6 * left:.3g} µm, which takes {cage.stiffness * left:.3g} N, and raceways "
            f"push with {force:.3g} N at most; use more clearance, a lighter load, stiffer rings, or "
            'numerics.start = "rest"'
        )
    return place


GUIDE_SIDES = {"inner_ring": -1.0, "outer_ring": 1.0}  # of the cage, where it meets that ring


def cage_state(bearing: Bearing, cage: Cage, angle: np.ndarray, speed: float, first: int | None = None) -> kernels.Cage:
    """The cage at t = 0, concentric and turning with the rollers, at these angles, rad; `first` of its columns."""
    n, side = bearing.n_rollers, GUIDE_SIDES.get(cage.guidance)
    padded = np.concatenate([angle, np.zeros(-n % WIDTH)])
    radii = {"inner_ring": bearing.inner_raceway_radius, "outer_ring": bearing.outer_raceway_radius}
    return lined_up(
        filled(
            kernels.Cage,
            {"columns": padded.size},
            motion=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, speed], [0.0, 0.0, speed]]),
            frame=np.array([1.0, 0.0]),
            cosine=np.cos(padded),
            sine=np.sin(padded),
            pockets=filled(CageContacts, {"n": n}),
            guide=None if side is None else filled(CageContacts, {"n": 1}),
            mass=float(cage.mass),
            inertia=float(cage.inertia),
            pitch_radius=bearing.pitch_radius,
            roller_radius=bearing.roller_radius,
            half_clearance=0.5 * cage.pocket_clearance,
            play=0.5 * (cage.guidance_clearance or 0.0),
            guide_radius=0.0 if side is None else side * radii[cage.guidance],
            stiffness=float(cage.stiffness),
            damping=float(cage.damping),
            friction=float(cage.friction_coefficient),
            drag_torque=float(cage.drag_torque),
            at=row_width(n, None) if first is None else first,
        )
    )


def pair_of_rigid(body: kernels.Cage, cage: Cage, bodies: RigidBodies, speed: float) -> CagePair:
    """The cage among the reduced model's bodies; `speed` of the shaft, rad/s."""
    riders = Riders(
        centre=bodies.centre,
        velocity=bodies.velocity,
        spin=bodies.spin,
        node_impulse=np.zeros_like(bodies.velocity),
        body_impulse=np.zeros_like(bodies.velocity),
        turn_kick=np.zeros_like(bodies.spin),
        n=bodies.n,
        mass=bodies.mass,
        inertia=bodies.inertia,
        radius=bodies.radius,
        swelling=None,
    )
    hub = ring_that_guides(bodies.hub, bodies.hub_velocity, np.zeros(2), bodies.hub_mass, speed)
    outer = None if bodies.housing is None else ring_of_housing(bodies.housing, bodies.housing.mass)
    return CagePair(cage=body, riders=riders, ring=guiding(cage, hub, outer))


def guiding(cage: Cage, hub: GuidingRing, outer: GuidingRing | None) -> GuidingRing | None:
    """The ring that guides a cage; None where rollers do, or an outer ring that the ground holds."""
    return {"inner_ring": hub, "outer_ring": outer, "rollers": None}[cage.guidance]


def ring_of_housing(housing: Housing, mass: float) -> GuidingRing:
    return ring_that_guides(housing.place, housing.velocity, housing.impulse, mass)


def ring_that_guides(
    place: np.ndarray, velocity: np.ndarray, impulse: np.ndarray, mass: float, speed: float | None = None
) -> GuidingRing:
    """A ring with a body's arrays; `speed` of the shaft that turns it, None: it does not turn."""
    return filled(
        GuidingRing,
        {},
        place=place,
        velocity=velocity,
        impulse=impulse,
        mass=mass,
        speed=np.array([0.0 if speed is None else speed]),
        turns=speed is not None,
    )


def cage_springs(bearing: Bearing, cage: Cage | None, operation: Operation) -> tuple[float, float]:
    """What all contacts of a cage, closed, add to ω² of the bearing's bodies, and the cage's own ω², 1/s².

    A spring k between two bodies is counted as EVENLY k on each, as in `critical_time_step`. The bearing's bodies have
    other springs too; on the cage there is nothing else.
    """
    if cage is None:
        return 0.0, 0.0
    from fem.contacts.critical_step import EVENLY  # and with it scipy.sparse, which runs without a cage save

    spring, n, pitch = EVENLY * cage.stiffness, bearing.n_rollers, bearing.pitch_radius
    guided = cage.guidance != "rollers"
    housing = operation.mounting.housing
    guiding = {"inner_ring": operation.inner_mass, "outer_ring": inf if housing is None else housing.mass}
    of_bearing = spring / min(bearing.roller_mass, guiding.get(cage.guidance, inf))
    of_cage = spring * (n * (1.0 / cage.mass + pitch**2 / cage.inertia) + (1.0 / cage.mass if guided else 0.0))
    return of_bearing, of_cage


def critical_with_cage(critical: float, bearing: Bearing, cage: Cage | None, operation: Operation) -> float:
    """Critical step of leapfrog, s, of a bearing, s, with all its cage's contacts closed too."""
    of_bearing, of_cage = cage_springs(bearing, cage, operation)
    return critical if cage is None else 2.0 / sqrt(max(4.0 / critical**2 + of_bearing, of_cage))


def axes_at(
    bearing: Bearing, operation: Operation, axial: Axial, cage: Cage | None, start: Tilts, columns: int
) -> TiltArrays:
    """The axes of rollers and hub at the slopes and rates of a start; `columns` : of rollers in arrays."""
    n, hub = bearing.n_rollers, hub_tilt(operation, axial)
    (across, along), turns = roller_inertias(bearing), (kinematics(bearing, 1.0), kinematics(bearing, 0.0, 1.0))
    tilts = filled(
        TiltArrays,
        {"columns": columns, "lanes": WIDTH},
        slope=np.array([start.slope_x, start.slope_y], dtype=float),
        slope_rate=np.array([start.slope_x_rate, start.slope_y_rate], dtype=float),
        inertia=float(across),
        along=float(along),
        spin=tuple(float(each.roller) for each in turns),
        cage=tuple(float(each.cage) for each in turns),
        hub_over=1.0 / hub.inertia if hub.is_free else 0.0,
        hub_spin=float(hub_axial_inertia(bearing, operation)),
        hub_stiffness=float(hub.stiffness),
        rest=(float(hub.slope_x), float(hub.slope_y)),
        column=row_width(n, cage, operation.mounting),
    )
    tilts.tilt[:n], tilts.rate[:n] = start.tilt, start.tilt_rate
    return tilts


def laws_of(tables: tuple[ContactTable | SpalledTable, ...]) -> tuple[tuple[TiltedLaw, ...], tuple]:
    """Laws of contacts by their tables, of all slices, and without those that spalls take; None: these take none."""
    laws = tuple(TiltedLaw.of(table.whole if isinstance(table, SpalledTable) else table) for table in tables)
    if not any(isinstance(table, SpalledTable) for table in tables):
        return laws, (None,) * len(tables)
    return laws, tuple(map(_rest, tables))  # of all contacts, so that they are of one type


def _rest(table: ContactTable | SpalledTable) -> SpalledRest:
    if not isinstance(table, SpalledTable):
        return SpalledRest(law=TiltedLaw.of(table), of_rest=1.0, of_part=0.0)
    return SpalledRest(law=TiltedLaw.of(table.rest), of_rest=1.0 / (1.0 - table.share), of_part=1.0 / table.share)


LESS = "reduce impacts and tilt of the rollers, or leave [axial] out"  # where tables go no further


def beyond_tables(tilts: TiltArrays | None, tables: tuple[TiltedLaw, ...]) -> str | None:
    """A clause where closed contacts have been further than their tables go; None: they have not, or have none.

    `tables` : of the inner and the outer contact, or none
    """
    if tilts is None or not tables:
        return None
    *approaches, slope = tilts.furthest.max(axis=1)
    for law, approach, side in zip(tables, approaches, ("inner", "outer"), strict=True):
        deepest = law.first_approach + (law.rows + 1.0) / law.per_approach
        if approach > deepest:
            return (
                f"a roller and the {side} raceway approached by {1e6 * approach:.3g} µm, and contacts that tilt are "
                f"tabulated up to {1e6 * deepest:.3g} µm"
            )
        steepest = law.first_slope + (law.columns + 1.0) / law.per_slope
        if slope > steepest:
            return (
                f"a roller and a raceway were misaligned by {1e3 * slope:.3g} mrad, and contacts that tilt are "
                f"tabulated up to {1e3 * steepest:.3g} mrad"
            )
    return None

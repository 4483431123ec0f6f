"""A cage for the time loops: its arrays at the start, its numbers in a sample, the step that it allows."""

from dataclasses import replace
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

import fem.kernels.cage as kernels
from fem.errors import UsageError
from fem.kernels.cage import CageContacts, CagePair, GuidingRing, Riders
from fem.kernels.fields import filled, lined_up
from fem.kernels.housing_kernels import Housing
from fem.kernels.lanes import WIDTH
from fem.kernels.rigid.state import RigidBodies
from fem.kernels.state import Drive, Rollers
from fem.solver.run_arrays import Arrays
from fem.solver.samples import row_width
from lagrange.bearing import Bearing, Cage, Operation
from lagrange.mounting import Mounting

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


if TYPE_CHECKING:  # needs the finite elements' libraries
    from fem.solver.elements.start import Start

GUIDE_SIDES = {"inner_ring": -1.0, "outer_ring": 1.0}  # of the cage, where it meets that ring


def with_cage(
    arrays: Arrays, bearing: Bearing, cage: Cage, start: "Start", seat: np.ndarray, mounting: Mounting
) -> Arrays:
    """Arrays of the finite elements with a cage; `seat` : (2,), m, of its centre from the outer ring's."""
    rollers, drive = arrays.bodies.rollers, arrays.drive
    first = row_width(bearing.n_rollers, None, mounting)
    body = cage_state(bearing, cage, start.angle, start.kinematics.cage, first)
    body.motion[0, :2] = start.housing + seat
    if arrays.bodies.disc.mass.size:
        rollers = rollers._replace(swelling=np.zeros(rollers.columns))
    housing = _housing(arrays)
    outer = None if housing is None else _of_housing(housing, housing.late_mass)
    pair = CagePair(cage=body, riders=_riders(rollers), ring=_guiding(cage, _hub(drive), outer))
    return replace(
        arrays,
        bodies=arrays.bodies._replace(rollers=rollers, others=(*arrays.bodies.others, body)),
        groups=((pair,), *arrays.groups),  # before impulses through nodes, which it would take for its rollers' own
    )


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


def _riders(rollers: Rollers) -> Riders:
    return Riders(
        centre=rollers.centre,
        velocity=rollers.velocity,
        spin=rollers.spin,
        node_impulse=rollers.node_impulse,
        body_impulse=rollers.body_impulse,
        turn_kick=rollers.turn_kick,
        n=rollers.n,
        mass=rollers.total_mass,
        inertia=rollers.inertia,
        radius=rollers.radius,
        swelling=rollers.swelling,
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
    hub = _ring(bodies.hub, bodies.hub_velocity, np.zeros(2), bodies.hub_mass, speed)
    outer = None if bodies.housing is None else _of_housing(bodies.housing, bodies.housing.mass)
    return CagePair(cage=body, riders=riders, ring=_guiding(cage, hub, outer))


def _guiding(cage: Cage, hub: GuidingRing, outer: GuidingRing | None) -> GuidingRing | None:
    """The ring that guides a cage; None where rollers do, or an outer ring that the ground holds."""
    return {"inner_ring": hub, "outer_ring": outer, "rollers": None}[cage.guidance]


def _of_housing(housing: Housing, mass: float) -> GuidingRing:
    return _ring(housing.place, housing.velocity, housing.impulse, mass)


def _hub(drive: Drive) -> GuidingRing:
    return _ring(drive.hub, drive.velocity, drive.impulse, drive.late_mass, drive.speed)


def _housing(arrays: Arrays) -> Housing | None:
    return next((body for body in arrays.bodies.others if isinstance(body, Housing)), None)


def _ring(
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

"""Fill the time loop's arrays from a model, a start and a time step."""

from dataclasses import replace

import numpy as np

from fem.contacts.model import Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.outer_support import SupportedRing
from fem.elastic.reciprocal_mass import ReciprocalMass, Slowing, disc_momenta, held_velocity, ring_momenta
from fem.elastic.rigid import RigidRing
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.bore import HeldNodes
from fem.kernels.fields import filled, lined_up
from fem.kernels.lanes import WIDTH
from fem.kernels.ring_kernels import HALO
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.shaft import late_mass
from fem.kernels.state import (
    Bodies,
    Disc,
    Drive,
    Ring,
    Rollers,
    Scratch,
)
from fem.solver.contact_arrays import contact_arrays, disc_surface, pair_groups
from fem.solver.part_arrays import bore_body, history_arrays, housing_body, shaft_springs
from fem.solver.run_arrays import Arrays
from fem.solver.start import Start
from lagrange import Operation


def make_arrays(
    model: Model,
    operation: Operation,
    start: Start,
    dt: float,
    friction: float,
    ramp: float,
    largest_force: float,
    mass: ReciprocalMass,
) -> Arrays:
    """Positions at t = 0 and velocities at −dt/2.

    `ramp` in s; the largest static contact force in N; `mass` : of nodes.
    """
    slowing = mass.at(dt)
    inner = ring_nodes(model.inner_ring, dt, slowing)
    outer = ring_nodes(model.outer_ring, dt, slowing)
    rollers = _rollers(model.roller, model.bearing.n_rollers)
    disc = disc_nodes(model.roller, dt, rollers.columns)
    drive = _drive(model, operation, start, dt, ramp, slowing)
    data = model.kernel_data(largest_force)
    contacts = contact_arrays(model, operation, start, data, friction, mass, rollers.columns)
    if not model.inner_ring.material.rigid:
        places = start.equilibrium.inner_ring, start.equilibrium.hub + start.housing
        rates, chord = (start.inner_rate, start.hub_velocity), dt if start.steady else 0.0
        momenta = _place_turning(model.inner_ring, inner, places, rates, operation.speed, chord, slowing)
        drive.velocity[:] -= held_velocity(model.inner_ring, momenta, slowing, drive.mass)
    if not model.outer_ring.material.rigid:
        shift = np.broadcast_to(start.housing, (len(model.outer_ring.points), 2))
        _fill(outer.u, start.equilibrium.outer_ring + model.outer_ring.polar(shift))
        outer_momenta = ring_momenta(model.outer_ring, start.outer_rate, slowing)
        _fill(outer.w, outer_momenta)
        if operation.history is not None and operation.history.outer_turn is not None:
            places, rates = (start.equilibrium.outer_ring, np.zeros(2)), (start.outer_rate, np.zeros(2))
            chord = dt if start.steady else 0.0
            _place_turning(model.outer_ring, outer, places, rates, operation.outer_speed, chord, slowing)
    _place_rollers(model.roller, rollers, disc, start, dt, slowing)
    rollers, disc, inner, outer = (lined_up(group) for group in (rollers, disc, inner, outer))
    if mass.share == 0.0:
        disc, inner, outer = (group._replace(v=group.w) for group in (disc, inner, outer))
    if mass.calming == 0.0:
        disc, inner, outer = (group._replace(calmed=group.w) for group in (disc, inner, outer))
    surface = disc_surface(model, rollers, disc, data)
    column = N_SCALARS + len(BLOCKS) * rollers.n
    housing = housing_body(model, operation, outer, start.housing, dt, column)
    shaft = shaft_springs(operation.mounting, drive, rollers.n)
    of_bore = column + len(replace(operation.mounting, bore=None).columns)
    bore = bore_body(model.outer_ring, outer, start.outer_rate, housing, of_bore)
    others = tuple(body for body in (bore, housing, shaft) if body is not None)  # the bore moves the housing
    if housing is not None and housing.ring is not None:
        housing.velocity[:] -= held_velocity(model.outer_ring, outer_momenta, slowing, housing.mass)
    if isinstance(model.outer_ring, SupportedRing):
        held = model.outer_ring.held_sectors.astype(np.int64)
        place = outer.u[outer.held][:, HALO + held].copy()
        moved = {"u": outer.u, "w": outer.w, "calmed": outer.calmed}
        others = (*others, HeldNodes(**moved, sectors=held, place=place, row=outer.held))
    return Arrays(
        bodies=Bodies(rollers=rollers, disc=disc, surface=surface, inner=inner, outer=outer, others=others),
        groups=pair_groups(model, (inner, outer), drive, housing, data, rollers.columns),
        contacts=lined_up(contacts),
        drive=drive,
        scratch=lined_up(_scratch(rollers, disc, inner, outer)),
    )


def _rollers(disc: DiscBody, n: int) -> Rollers:
    columns = -(-n // disc_kernels.COLUMNS) * disc_kernels.COLUMNS
    whole = {"total_mass": disc.total_mass, "inertia": disc.polar_inertia, "radius": disc.shape.radius}
    return filled(Rollers, {"columns": columns}, n=n, columns=columns, **whole)


def disc_nodes(disc: DiscBody, dt: float, columns: int) -> Disc:
    """Nodes at rest of so many rollers, for steps of `dt`, s; none of rigid ones."""
    starts, neighbours, blocks = disc.blocks()
    points, mass = disc.points, disc.mass
    grown = -dt * (disc.stiffness @ points.ravel()) / np.repeat(mass, 2)
    if disc.material.rigid:
        starts, points, mass, grown = np.zeros(1, dtype=np.int64), np.zeros((0, 2)), np.zeros(0), np.zeros(0)
    rows = np.repeat(np.arange(len(mass)), np.diff(starts))
    return filled(
        Disc,
        {"n_nodes": len(mass), "columns": columns},
        starts=starts,
        neighbours=neighbours,
        blocks=np.ascontiguousarray(-dt * blocks / mass[rows][:, None, None]).ravel(),
        points=np.ascontiguousarray(points).ravel(),
        grown=grown,
        mass=mass.copy(),
        first=0 if disc.material.rigid else disc.first_surface_node,
    )


def ring_nodes(ring: RingBody, dt: float, slowing: Slowing) -> Ring:
    """Nodes at rest of a ring, for steps of `dt`, s."""
    if isinstance(ring, RigidRing):
        return _rigid_ring(ring)
    width = ring.n_sectors + 2 * HALO
    angle = 2.0 * np.pi * (np.arange(width) - HALO) / ring.n_sectors
    table = -dt * ring_kernels.coefficients(ring.stencil) / ring.row_mass[:, None]
    widening = ring.harmonic_stiffness(np.zeros(1)).real.reshape(ring.n_rows, 2, ring.n_rows, 2)
    first = int(ring.free_rows[0])
    return filled(
        Ring,
        {"n_rows": ring.n_rows, "width": width},
        table=table,
        slowed=slowing.waves * table,
        calming=slowing.velocities / dt * table,
        radii=ring.radii.copy(),
        grown=-slowing.waves * dt * (widening[:, 0, :, 0] @ ring.radii) / ring.row_mass,
        row_mass=ring.row_mass.copy(),
        cosines=np.cos(angle),
        sines=np.sin(angle),
        n_sectors=ring.n_sectors,
        first_row=first,
        last_row=first + len(ring.free_rows),
        raceway=ring.raceway_row,
        held=ring.held_row,
    )


def _rigid_ring(ring: RigidRing) -> Ring:
    width = WIDTH + 2 * HALO  # one node, in a register of its own
    return filled(
        Ring,
        {"n_rows": 1, "width": width},
        radii=np.array([np.sqrt(ring.polar_inertia / ring.total_mass)]),
        row_mass=np.array([ring.total_mass]),
        cosines=np.ones(width),
        n_sectors=1,
        first_row=0,
        last_row=0,
        raceway=0,
        held=0,
    )


def _fill(target: np.ndarray, values: np.ndarray) -> None:
    target[:, :, HALO:-HALO] = values
    target[:, :, HALO - 1] = target[:, :, -HALO - 1]
    target[:, :, -HALO:] = target[:, :, HALO : 2 * HALO]


Moved = tuple[np.ndarray, np.ndarray]  # a ring's nodes about its centre, (n_rows, 2, n_sectors), and that, (2,)


def _place_turning(
    body: RingBody, ring: Ring, places: Moved, rates: Moved, speed: float, chord: float, slowing: Slowing
) -> np.ndarray:
    """Polar state about the outer ring's centre: the centre's motion, the rotation and the deformation.

    Parameters
    ----------
    places, rates : displacements, m, and velocities, m/s; chord : s, a step in which forces hold nodes on circles, or 0

    Returns the momenta, (n_rows, 2, n_sectors), m/s, without what half a step turns of them.
    """
    cosine, sine = np.cos(body.angles), np.sin(body.angles)

    def polar(vector):
        return np.stack([vector[0] * cosine + vector[1] * sine, vector[1] * cosine - vector[0] * sine])

    _fill(ring.u, places[0] + polar(places[1]))
    position = places[0].copy()
    position[:, 0] += body.radii[:, None]
    turned = np.stack([-position[:, 1], position[:, 0]], axis=1)
    velocity = rates[0] + speed * turned + polar(rates[1])
    kick = chord * speed**2 * position  # along chords after it
    momenta = ring_momenta(body, velocity, slowing)
    _fill(ring.w, momenta + 0.5 * kick)
    return momenta


def _place_rollers(body: DiscBody, rollers: Rollers, disc: Disc, start: Start, dt: float, slowing: Slowing) -> None:
    n, spin, cage = rollers.n, start.kinematics.roller, start.kinematics.cage
    rho, angle = start.equilibrium.rho, start.angle
    radial = rho * np.stack([np.cos(angle), np.sin(angle)])
    rollers.centre[:, :n] = radial + start.housing[:, None]
    rollers.centre[:, n:] = rollers.centre[:, :1]  # spare columns need a direction, or there would be a division by 0
    half_step = 0.5 * dt if start.steady else 0.0
    rollers.velocity[:, :n] = start.roller_velocity.T + half_step * cage**2 * radial
    rollers.spin[:n] = spin
    rollers.increment[:n] = spin * dt
    if body.material.rigid:
        return
    position = body.points + start.equilibrium.rollers
    turned = np.stack([-position[..., 1], position[..., 0]], axis=-1)
    kick = 2.0 * half_step * spin**2 * position  # along chords after it
    momenta = disc_momenta(body, start.roller_rate + spin * turned, slowing) + 0.5 * kick
    shape = (body.n_nodes, 2, rollers.columns)
    disc.u.reshape(shape)[:, :, :n] = np.moveaxis(start.equilibrium.rollers, 0, -1)
    disc.w.reshape(shape)[:, :, :n] = np.moveaxis(momenta, 0, -1)


def _drive(model: Model, operation: Operation, start: Start, dt: float, ramp: float, slowing: Slowing) -> Drive:
    mass, shaft = hub_mass(model.inner_ring, operation), operation.mounting.shaft
    return filled(
        Drive,
        {},
        hub=start.equilibrium.hub + start.housing,
        velocity=start.hub_velocity.copy(),
        frame=np.array([0.0, 1.0, 0.0]),
        mass=mass,
        late_mass=late_mass(mass, 0.0 if shaft is None else shaft.damping, dt),
        speed=float(operation.speed),
        gravity=float(operation.gravity),
        dt=float(dt),
        slowing=slowing.waves,
        calming=slowing.velocities / float(dt),
        radial_load=float(operation.radial_load),
        ramp=float(ramp),
        history=history_arrays(model.bearing, operation),
    )


def hub_mass(ring: RingBody, operation: Operation) -> float:
    """What moves with the hub, kg: the shaft, and the ring's held row or a rigid ring."""
    held = ring.total_mass if ring.material.rigid else ring.n_sectors * ring.row_mass[ring.held_row]
    return float(operation.inner_mass - ring.total_mass + held)


def _scratch(rollers: Rollers, disc: Disc, inner: Ring, outer: Ring) -> Scratch:
    return filled(
        Scratch,
        {"columns": rollers.columns, "inner": inner.u.shape[2], "outer": outer.u.shape[2]},
        rollers_w=np.zeros_like(disc.w),
        rollers_velocity=np.zeros_like(rollers.velocity),
        inner_w=np.zeros_like(inner.w),
        outer_w=np.zeros_like(outer.w),
    )

"""Fill the time loop's arrays from a model, a start and a time step."""

from dataclasses import dataclass

import numpy as np

from fem.contacts.model import Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.rigid import RigidRing
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.simd import WIDTH
from fem.kernels.state import Contacts, Drive, Ring, Rollers, Scratch
from fem.solver.start import Start
from lagrange import Operation, kinematics

REACH = 0.01  # of a roller's radius
CACHE_LINE = 64  # bytes, as long as one register of eight


@dataclass(frozen=True, kw_only=True)
class Arrays:
    """All state of a run: what the kernels change in place."""

    rollers: Rollers
    inner: Ring
    outer: Ring
    contacts: Contacts
    drive: Drive
    scratch: Scratch


def make_arrays(
    model: Model,
    operation: Operation,
    start: Start,
    dt: float,
    friction: float,
    ramp: float,
    largest_force: float,
    threads: int,
) -> Arrays:
    """Positions at t = 0 and velocities at −dt/2. `ramp` in s; the largest static contact force in N."""
    inner = _ring(model.inner_ring, dt)
    outer = _ring(model.outer_ring, dt)
    rollers = _rollers(model.roller, model.bearing.n_rollers, dt)
    drive = _drive(model, operation, start, dt, friction, ramp)
    contacts = _contacts(model, operation, start, largest_force, rollers.columns)
    if not inner.rigid:
        _place_inner(model.inner_ring, inner, start, operation.speed, dt)
    if not outer.rigid:
        _fill(outer.u, start.equilibrium.outer_ring)
        _fill(outer.w, start.outer_rate)
    _place_rollers(model.roller, rollers, start, dt)
    return Arrays(
        rollers=_lined_up(rollers),
        inner=_lined_up(inner),
        outer=_lined_up(outer),
        contacts=_lined_up(contacts),
        drive=drive,
        scratch=_lined_up(_scratch(rollers, inner, outer, contacts, threads)),
    )


def _lined_up(group):
    """A named tuple whose arrays begin at cache lines: eight lanes that lie across two cost two accesses."""
    return type(group)(*(_at_line(entry) if isinstance(entry, np.ndarray) else entry for entry in group))


def _at_line(values: np.ndarray) -> np.ndarray:
    room = np.zeros(values.nbytes + CACHE_LINE, dtype=np.uint8)
    first = -room.ctypes.data % CACHE_LINE
    copy = room[first : first + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[...] = values
    return copy


def _rollers(disc: DiscBody, n: int, dt: float) -> Rollers:
    starts, neighbours, blocks = disc.blocks()
    points, mass = disc.points, disc.mass
    if disc.material.rigid:
        starts, points, mass = np.zeros(1, dtype=np.int64), np.zeros((0, 2)), np.zeros(0)
    rows = np.repeat(np.arange(len(mass)), np.diff(starts))
    columns = -(-n // disc_kernels.COLUMNS) * disc_kernels.COLUMNS
    return Rollers(
        starts=starts,
        neighbours=neighbours,
        blocks=np.ascontiguousarray(-dt * blocks / mass[rows][:, None, None]).ravel(),
        points=np.ascontiguousarray(points).ravel(),
        mass=mass.copy(),
        lightness=1.0 / mass,
        u=np.zeros(len(mass) * 2 * columns),
        w=np.zeros(len(mass) * 2 * columns),
        centre=np.zeros((2, columns)),
        velocity=np.zeros((2, columns)),
        turn=np.zeros(columns),
        cosine=np.ones(columns),
        sine=np.zeros(columns),
        increment=np.zeros(columns),
        lead=np.zeros(columns),
        spin=np.zeros(columns),
        impulse=np.zeros((2, columns)),
        tilt=np.zeros((2, columns)),
        turn_kick=np.zeros(columns),
        first_surface=disc.first_surface_node,
        n_surface=disc.shape.surface_nodes,
        n=n,
        columns=columns,
        total_mass=disc.total_mass,
        inertia=disc.polar_inertia,
        radius=disc.shape.radius,
        rigid=_mark(disc),
    )


def _mark(body: DiscBody | RingBody) -> tuple[int, ...]:
    """A body's `rigid`, see `fem.kernels.state`."""
    return (1,) if body.material.rigid else ()


def _ring(ring: RingBody, dt: float) -> Ring:
    if isinstance(ring, RigidRing):
        return _rigid_ring(ring)
    width = ring.n_sectors + 2 * HALO
    angle = 2.0 * np.pi * (np.arange(width) - HALO) / ring.n_sectors
    table = ring_kernels.coefficients(ring.stencil)
    first = 1 if ring.held_row == 0 else 0
    return Ring(
        table=-dt * table / ring.row_mass[:, None],
        u=np.zeros((ring.n_rows, 2, width)),
        w=np.zeros((ring.n_rows, 2, width)),
        radii=ring.radii.copy(),
        row_mass=ring.row_mass.copy(),
        cosines=np.cos(angle),
        sines=np.sin(angle),
        n_sectors=ring.n_sectors,
        first_row=first,
        last_row=first + ring.n_rows - 1,
        raceway=ring.raceway_row,
        held=ring.held_row,
        radius=ring.raceway_radius,
        rigid=_mark(ring),
    )


def _rigid_ring(ring: RigidRing) -> Ring:
    width = WIDTH + 2 * HALO  # one node, in a register of its own
    return Ring(
        table=np.zeros((1, 18)),
        u=np.zeros((1, 2, width)),
        w=np.zeros((1, 2, width)),
        radii=np.array([np.sqrt(ring.polar_inertia / ring.total_mass)]),
        row_mass=np.array([ring.total_mass]),
        cosines=np.ones(width),
        sines=np.zeros(width),
        n_sectors=1,
        first_row=0,
        last_row=0,
        raceway=0,
        held=0,
        radius=ring.raceway_radius,
        rigid=_mark(ring),
    )


def _fill(target: np.ndarray, values: np.ndarray) -> None:
    target[:, :, HALO:-HALO] = values
    target[:, :, HALO - 1] = target[:, :, -HALO - 1]
    target[:, :, -HALO] = target[:, :, HALO]


def _place_inner(body: RingBody, ring: Ring, start: Start, speed: float, dt: float) -> None:
    """Polar state about the outer ring's centre: the hub's motion, the rotation and the deformation."""
    cosine, sine = np.cos(body.angles), np.sin(body.angles)

    def polar(vector):
        return np.stack([vector[0] * cosine + vector[1] * sine, vector[1] * cosine - vector[0] * sine])

    deformed = start.equilibrium.inner_ring.copy()
    _fill(ring.u, deformed + polar(start.equilibrium.hub))
    position = deformed.copy()
    position[:, 0] += body.radii[:, None]
    turned = np.stack([-position[:, 1], position[:, 0]], axis=1)
    velocity = start.inner_rate + speed * turned + polar(start.hub_velocity)
    if start.steady:
        velocity += 0.5 * dt * speed**2 * position
    _fill(ring.w, velocity)


def _place_rollers(disc: DiscBody, rollers: Rollers, start: Start, dt: float) -> None:
    n, spin, cage = rollers.n, start.kinematics.roller, start.kinematics.cage
    rho, angle = start.equilibrium.rho, start.angle
    rollers.centre[:, :n] = rho * np.cos(angle), rho * np.sin(angle)
    rollers.centre[:, n:] = rollers.centre[:, :1]  # spare columns need a direction, lest there be a division by 0
    half_step = 0.5 * dt if start.steady else 0.0
    rollers.velocity[:, :n] = start.roller_velocity.T + half_step * cage**2 * rollers.centre[:, :n]
    rollers.spin[:n] = spin
    rollers.increment[:n] = spin * dt
    if rollers.rigid:
        return
    position = disc.points + start.equilibrium.rollers
    turned = np.stack([-position[..., 1], position[..., 0]], axis=-1)
    velocity = start.roller_rate + spin * turned + half_step * spin**2 * position
    shape = (disc.n_nodes, 2, rollers.columns)
    rollers.u.reshape(shape)[:, :, :n] = np.moveaxis(start.equilibrium.rollers, 0, -1)
    rollers.w.reshape(shape)[:, :, :n] = np.moveaxis(velocity, 0, -1)


def _reach(model: Model, operation: Operation) -> float:
    """A gap that elastic motion can't close: far above any contact's approach, and twice the growth under rotation."""
    ring, disc = model.inner_ring, model.roller
    growth = ring.held(ring.body_load(0.0, 0.0, operation.speed))
    spin = kinematics(model.bearing, operation.speed).roller
    swelling = disc.relaxed(spin**2 * (disc.mass[:, None] * disc.points).ravel())
    return REACH * disc.shape.radius + 2.0 * float(np.abs(growth).max() + np.abs(swelling).max())


def _contacts(model: Model, operation: Operation, start: Start, largest_force: float, columns: int) -> Contacts:
    n = model.bearing.n_rollers
    force = np.zeros((3, columns))
    force[0, :n], force[1, :n] = start.equilibrium.inner_force, start.equilibrium.outer_force
    data, pairs = model.kernel_data(largest_force), [law.pair for law in model.laws]
    width = N_NODES * len(data.entries["stretch"])
    on_raceways, on_rollers = _crowded(model, data.neighbourly)
    return Contacts(
        **data.entries,
        reach=_reach(model, operation) + data.facet_depth,
        half_width_factor=np.array([pair.half_width_factor for pair in pairs]),
        curvature=np.array([1.0 / pair.relative_radius for pair in pairs]),
        force=force,
        approach=np.full((3, columns), np.nan),
        push=np.zeros((3, columns)),
        owed=np.zeros((3, columns)),
        bracket=np.zeros((3, columns)),
        traction=np.zeros((3, columns)),
        change=np.zeros((3, columns)),
        normal=np.zeros((3, 2, columns)),
        slip=np.zeros((3, columns)),
        crowded=on_raceways,
        crowded_rollers=on_rollers,
        start=np.zeros((6, columns), dtype=np.int64),
        weight=np.zeros((6, width, columns)),
        outward=np.zeros((6, 2, columns)),
        along=np.zeros((6, width, columns)),
        across=np.zeros((6, width, columns)),
        scale=np.zeros((6, columns)),
        lean=np.zeros((6, columns)),
        mobility=np.zeros((3, columns)),
    )


def _crowded(model: Model, width: float) -> tuple[bool, bool]:
    """Whether patches can come within `width` nodes: on a raceway those of rollers that touch, on a roller its own."""
    bearing = model.bearing
    apart = 2.0 * np.arcsin(min(1.0, bearing.roller_radius / bearing.pitch_radius))  # of rollers that touch
    angle = 2.0 * np.pi * width
    rings = (model.inner_ring, model.outer_ring)
    return (
        any(ring.n_sectors * apart < angle for ring in rings if not ring.material.rigid),
        not model.roller.material.rigid and model.roller.shape.surface_nodes * 0.5 * (np.pi - apart) < angle,
    )


def _drive(model: Model, operation: Operation, start: Start, dt: float, friction: float, ramp: float) -> Drive:
    ring = model.inner_ring
    held = ring.total_mass if ring.material.rigid else ring.n_sectors * ring.row_mass[ring.held_row]
    return Drive(
        hub=start.equilibrium.hub.copy(),
        velocity=start.hub_velocity.copy(),
        impulse=np.zeros(2),
        ring=np.array([0.0, 1.0, 0.0, 0.0, 0.0]),
        sums=np.zeros(6),
        mass=float(operation.inner_mass - ring.total_mass + held),
        speed=float(operation.speed),
        gravity=float(operation.gravity),
        friction=float(friction),
        dt=float(dt),
        load=float(operation.radial_load),
        ramp=float(ramp),
    )


def _scratch(rollers: Rollers, inner: Ring, outer: Ring, contacts: Contacts, threads: int) -> Scratch:
    columns = rollers.columns
    return Scratch(
        slope=np.zeros((contacts.weight.shape[1], WIDTH)),
        slip=np.zeros((3, rollers.columns)),
        bore=np.zeros((2, inner.u.shape[2])),
        line=np.zeros((2, outer.u.shape[2])),
        team=None if threads == 1 else np.zeros(threads),
        torque=np.zeros(threads * columns),
        still=np.zeros(columns),
        shift=np.zeros((2, columns)),
        cosine=np.ones(columns),
        sine=np.zeros(columns),
        rollers_w=np.zeros_like(rollers.w),
        rollers_velocity=np.zeros_like(rollers.velocity),
        inner_w=np.zeros_like(inner.w),
        outer_w=np.zeros_like(outer.w),
        hub_velocity=np.zeros(2),
    )

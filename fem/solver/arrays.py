"""Fill the time loop's arrays from a model, a start and a time step."""

from dataclasses import dataclass

import numpy as np

from fem.contacts.model import KernelData, Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.rigid import RigidRing
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.friction_kernels import ALWAYS, WHERE_ROLLERS_TOUCH
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.simd import WIDTH
from fem.kernels.state import (
    INNER,
    OUTER,
    ROLLER,
    Bodies,
    Contacts,
    Disc,
    DiscSurface,
    Drive,
    Forces,
    Friction,
    Ground,
    Hub,
    Neighbours,
    Patches,
    Raceway,
    RigidDisc,
    Ring,
    RingSurface,
    Rollers,
    Scratch,
)
from fem.solver.start import Start
from lagrange import Operation, kinematics

REACH = 0.01  # of a roller's radius
CACHE_LINE = 64  # bytes, as long as one register of eight


@dataclass(frozen=True, kw_only=True)
class Arrays:
    """All state of a run: what the kernels change in place."""

    bodies: Bodies
    groups: tuple[tuple[Raceway | Neighbours, ...], ...]  # pairs of bodies; see `fem.kernels.jit.every`
    contacts: Contacts
    drive: Drive
    scratch: Scratch

    def named(self) -> dict[str, np.ndarray]:
        """Every array that outlives a step, by where it stands; pairs share theirs with bodies and drive."""
        found: dict[str, np.ndarray] = {}
        for name in ("bodies", "contacts", "drive"):
            _collect(getattr(self, name), name, found)
        return found


def _collect(group: tuple, place: str, found: dict[str, np.ndarray]) -> None:
    for name, entry in zip(group._fields, group, strict=True):
        if isinstance(entry, np.ndarray):
            found[f"{place}.{name}"] = entry
        elif hasattr(entry, "_fields"):
            _collect(entry, f"{place}.{name}", found)


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
    rollers = _rollers(model.roller, model.bearing.n_rollers)
    disc = _disc(model.roller, dt, rollers.columns)
    drive = _drive(model, operation, start, dt, ramp)
    data = model.kernel_data(largest_force)
    contacts = _contacts(model, operation, start, data, friction, rollers.columns)
    if not model.inner_ring.material.rigid:
        _place_inner(model.inner_ring, inner, start, operation.speed, dt)
    if not model.outer_ring.material.rigid:
        _fill(outer.u, start.equilibrium.outer_ring)
        _fill(outer.w, start.outer_rate)
    _place_rollers(model.roller, rollers, disc, start, dt)
    rollers, disc, inner, outer = (_lined_up(group) for group in (rollers, disc, inner, outer))
    surface = _disc_surface(model, rollers, disc, data)
    return Arrays(
        bodies=Bodies(rollers=rollers, disc=disc, surface=surface, inner=inner, outer=outer),
        groups=_groups(model, inner, outer, drive, data),
        contacts=_lined_up(contacts),
        drive=drive,
        scratch=_lined_up(_scratch(rollers, disc, inner, outer, threads)),
    )


def _lined_up(group):
    """A named tuple whose arrays begin at cache lines: eight lanes that lie across two cost two accesses."""
    return type(group)(*(_lined_up_entry(entry) for entry in group))


def _lined_up_entry(entry):
    if isinstance(entry, np.ndarray):
        return _at_line(entry)
    return _lined_up(entry) if hasattr(entry, "_fields") else entry


def _at_line(values: np.ndarray) -> np.ndarray:
    room = np.zeros(values.nbytes + CACHE_LINE, dtype=np.uint8)
    first = -room.ctypes.data % CACHE_LINE
    copy = room[first : first + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[...] = values
    return copy


def _rollers(disc: DiscBody, n: int) -> Rollers:
    columns = -(-n // disc_kernels.COLUMNS) * disc_kernels.COLUMNS
    return Rollers(
        centre=np.zeros((2, columns)),
        velocity=np.zeros((2, columns)),
        turn=np.zeros(columns),
        cosine=np.ones(columns),
        sine=np.zeros(columns),
        increment=np.zeros(columns),
        lead=np.zeros(columns),
        spin=np.zeros(columns),
        node_impulse=np.zeros((2, columns)),
        body_impulse=np.zeros((2, columns)),
        turn_kick=np.zeros(columns),
        n=n,
        columns=columns,
        total_mass=disc.total_mass,
        inertia=disc.polar_inertia,
        radius=disc.shape.radius,
    )


def _disc(disc: DiscBody, dt: float, columns: int) -> Disc:
    starts, neighbours, blocks = disc.blocks()
    points, mass = disc.points, disc.mass
    if disc.material.rigid:
        starts, points, mass = np.zeros(1, dtype=np.int64), np.zeros((0, 2)), np.zeros(0)
    rows = np.repeat(np.arange(len(mass)), np.diff(starts))
    return Disc(
        starts=starts,
        neighbours=neighbours,
        blocks=np.ascontiguousarray(-dt * blocks / mass[rows][:, None, None]).ravel(),
        points=np.ascontiguousarray(points).ravel(),
        mass=mass.copy(),
        u=np.zeros(len(mass) * 2 * columns),
        w=np.zeros(len(mass) * 2 * columns),
    )


def _disc_surface(model: Model, rollers: Rollers, disc: Disc, data: KernelData) -> DiscSurface | RigidDisc:
    """What contacts see of rollers."""
    if model.roller.material.rigid:
        return RigidDisc(
            velocity=rollers.velocity,
            spin=rollers.spin,
            turn_kick=rollers.turn_kick,
            columns=rollers.columns,
            total_mass=rollers.total_mass,
            inertia=rollers.inertia,
            radius=rollers.radius,
        )
    return DiscSurface(
        u=disc.u,
        w=disc.w,
        points=disc.points,
        lightness=_at_line(1.0 / disc.mass),
        impulse=rollers.node_impulse,
        ripple=_at_line(data.ripples[ROLLER]),
        first=model.roller.first_surface_node,
        n_nodes=model.roller.shape.surface_nodes,
        columns=rollers.columns,
        radius=rollers.radius,
    )


def _ring_surface(body: RingBody, ring: Ring, ripple: np.ndarray) -> RingSurface:
    """What contacts see of an elastic ring."""
    return RingSurface(
        u=ring.u,
        w=ring.w,
        cosines=ring.cosines,
        sines=ring.sines,
        ripple=_at_line(ripple),
        row=ring.raceway,
        n_nodes=ring.n_sectors,
        node_mass=float(ring.row_mass[ring.raceway]),
        radius=body.raceway_radius,
    )


def _groups(model: Model, inner: Ring, outer: Ring, drive: Drive, data: KernelData) -> tuple:
    """All pairs of bodies that may touch, in groups of one type."""
    bearing, (hub, ground) = model.bearing, (model.inner_ring, model.outer_ring)
    nowhere = np.zeros(2)
    inner_surface = Hub(
        place=drive.hub,
        velocity=drive.velocity,
        impulse=drive.impulse,
        n_contacts=bearing.n_rollers,
        mass=drive.mass,
        speed=drive.speed,
        radius=hub.raceway_radius,
    )
    if not hub.material.rigid:
        inner_surface = _ring_surface(hub, inner, data.ripples[INNER])
    outer_surface = Ground(radius=ground.raceway_radius)
    if not ground.material.rigid:
        outer_surface = _ring_surface(ground, outer, data.ripples[OUTER])
    orbit = ground.raceway_radius - model.roller.shape.radius
    on_inner = Raceway(
        row=INNER,
        sign=1.0,
        radius=hub.raceway_radius,
        orbit=orbit,
        law=data.laws[INNER],
        surface=inner_surface,
        centre=drive.hub,
        counted_from=nowhere if hub.material.rigid else drive.hub,
        frame=drive.frame,
        impulse=drive.impulse,
        moment=drive.moment,
    )
    on_outer = Raceway(
        row=OUTER,
        sign=-1.0,
        radius=ground.raceway_radius,
        orbit=orbit,
        law=data.laws[OUTER],
        surface=outer_surface,
        centre=nowhere,
        counted_from=nowhere,
        frame=np.array([0.0, 1.0, 0.0]),
        impulse=np.zeros(2),  # the ground's, which nobody reads
        moment=np.zeros(2),
    )
    between = Neighbours(row=ROLLER, law=data.laws[ROLLER])
    if type(inner_surface) is type(outer_surface):
        return (on_inner, on_outer), (between,)
    return (on_inner,), (on_outer,), (between,)


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


def _place_rollers(body: DiscBody, rollers: Rollers, disc: Disc, start: Start, dt: float) -> None:
    n, spin, cage = rollers.n, start.kinematics.roller, start.kinematics.cage
    rho, angle = start.equilibrium.rho, start.angle
    rollers.centre[:, :n] = rho * np.cos(angle), rho * np.sin(angle)
    rollers.centre[:, n:] = rollers.centre[:, :1]  # spare columns need a direction, or there would be a division by 0
    half_step = 0.5 * dt if start.steady else 0.0
    rollers.velocity[:, :n] = start.roller_velocity.T + half_step * cage**2 * rollers.centre[:, :n]
    rollers.spin[:n] = spin
    rollers.increment[:n] = spin * dt
    if body.material.rigid:
        return
    position = body.points + start.equilibrium.rollers
    turned = np.stack([-position[..., 1], position[..., 0]], axis=-1)
    velocity = start.roller_rate + spin * turned + half_step * spin**2 * position
    shape = (body.n_nodes, 2, rollers.columns)
    disc.u.reshape(shape)[:, :, :n] = np.moveaxis(start.equilibrium.rollers, 0, -1)
    disc.w.reshape(shape)[:, :, :n] = np.moveaxis(velocity, 0, -1)


def _reach(model: Model, operation: Operation) -> float:
    """A gap that elastic motion can't close: far above any contact's approach, and twice the growth under rotation."""
    ring, disc = model.inner_ring, model.roller
    growth = ring.held(ring.body_load(0.0, 0.0, operation.speed))
    spin = kinematics(model.bearing, operation.speed).roller
    swelling = disc.relaxed(spin**2 * (disc.mass[:, None] * disc.points).ravel())
    return REACH * disc.shape.radius + 2.0 * float(np.abs(growth).max() + np.abs(swelling).max())


def _contacts(
    model: Model, operation: Operation, start: Start, data: KernelData, friction: float, columns: int
) -> Contacts:
    n = model.bearing.n_rollers
    pairs = 3
    force = np.zeros((pairs, columns))
    force[INNER, :n], force[OUTER, :n] = start.equilibrium.inner_force, start.equilibrium.outer_force
    width = N_NODES * len(data.units)
    return Contacts(
        forces=Forces(
            force=force,
            kick=np.zeros((pairs, columns)),
            approach=np.full((pairs, columns), np.nan),
            residual=np.zeros((pairs, columns)),
            bracket=np.zeros((pairs, columns)),
        ),
        patches=Patches(
            normal=np.zeros((pairs, 2, columns)),
            start=np.zeros((2 * pairs, columns), dtype=np.int64),
            weight=np.zeros((2 * pairs, width, columns)),
            outward=np.zeros((2 * pairs, 2, columns)),
            along=np.zeros((2 * pairs, width, columns)),
            across=np.zeros((2 * pairs, width, columns)),
            scale=np.zeros((2 * pairs, columns)),
            slope=np.zeros((2 * pairs, columns)),
            weight_slope=np.zeros((N_NODES, WIDTH)),
            columns=columns,
            units=data.units,
        ),
        friction=Friction(
            traction=np.zeros((pairs, columns)),
            change=np.zeros((pairs, columns)),
            slip=np.zeros((pairs, columns)),
            slip_left=np.zeros((pairs, columns)),
            mobility=np.zeros((pairs, columns)),
            coefficient=float(friction),
            overlapping=_overlapping(model, data.neighbourly),
            whole=True if model.roller.material.rigid or model.inner_ring.material.rigid else None,
        ),
        points=data.points,
        reach=_reach(model, operation) + data.facet_depth,
    )


def _overlapping(model: Model, width: float) -> int | None:
    """Whether patches can come within `width` nodes, as `Friction.overlapping` says it.

    On a raceway those of rollers that touch, on a roller its own.
    """
    bearing = model.bearing
    apart = 2.0 * np.arcsin(min(1.0, bearing.roller_radius / bearing.pitch_radius))  # of rollers that touch
    angle = 2.0 * np.pi * width
    rings = (model.inner_ring, model.outer_ring)
    if any(ring.n_sectors * apart < angle for ring in rings if not ring.material.rigid):
        return ALWAYS
    on_rollers = model.roller.shape.surface_nodes * 0.5 * (np.pi - apart) < angle
    return WHERE_ROLLERS_TOUCH if on_rollers and not model.roller.material.rigid else None


def _drive(model: Model, operation: Operation, start: Start, dt: float, ramp: float) -> Drive:
    ring = model.inner_ring
    held = ring.total_mass if ring.material.rigid else ring.n_sectors * ring.row_mass[ring.held_row]
    return Drive(
        hub=start.equilibrium.hub.copy(),
        velocity=start.hub_velocity.copy(),
        frame=np.array([0.0, 1.0, 0.0]),
        impulse=np.zeros(2),
        moment=np.zeros(2),
        sums=np.zeros(6),
        mass=float(operation.inner_mass - ring.total_mass + held),
        speed=float(operation.speed),
        gravity=float(operation.gravity),
        dt=float(dt),
        radial_load=float(operation.radial_load),
        ramp=float(ramp),
    )


def _scratch(rollers: Rollers, disc: Disc, inner: Ring, outer: Ring, threads: int) -> Scratch:
    columns = rollers.columns
    return Scratch(
        bore=np.zeros((2, inner.u.shape[2])),
        line=np.zeros((2, outer.u.shape[2])),
        team=None if threads == 1 else np.zeros(threads),
        torque=np.zeros(threads * columns),
        still=np.zeros(columns),
        shift=np.zeros((2, columns)),
        cosine=np.ones(columns),
        sine=np.zeros(columns),
        rollers_w=np.zeros_like(disc.w),
        rollers_velocity=np.zeros_like(rollers.velocity),
        inner_w=np.zeros_like(inner.w),
        outer_w=np.zeros_like(outer.w),
        hub_velocity=np.zeros(2),
    )

"""Arrays of the finite elements' time loop from a model, a start and a time step: bodies, surfaces, pairs, contacts."""

import hashlib
from dataclasses import dataclass, replace
from itertools import groupby
from math import expm1

import numba
import numpy as np

from fem.contacts.model import KernelData, Model
from fem.elastic.bodies import DiscBody, RigidRing, RingBody
from fem.elastic.outer_support import BoredRing, LooseRing, SupportedRing
from fem.elastic.reciprocal_mass import ReciprocalMass, Slowing, disc_momenta, held_velocity, ring_momenta
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.bore import Bore, HeldNodes
from fem.kernels.cage import CagePair, Riders
from fem.kernels.fields import at_line, filled, lined_up
from fem.kernels.friction_solution import ALWAYS, WHERE_ROLLERS_TOUCH
from fem.kernels.housing_kernels import Housing
from fem.kernels.lanes import WIDTH
from fem.kernels.law import with_seam
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.shaft import late_mass
from fem.kernels.state import (
    INNER,
    OUTER,
    ROLLER,
    Bodies,
    BodyDamping,
    Contacts,
    Dampers,
    Disc,
    DiscSurface,
    Drive,
    Forces,
    Friction,
    Ground,
    Hub,
    Pair,
    Patches,
    RigidDisc,
    Ring,
    RingSurface,
    Rollers,
    Scratch,
    Shear,
)
from fem.solver.elements.start import Start
from fem.solver.parts import (
    cage_state,
    guiding,
    history_arrays,
    housing_of,
    raceway_profiles,
    ring_of_housing,
    ring_that_guides,
    springs_on,
)
from fem.solver.row_state import collect_arrays
from fem.solver.samples import row_width
from lagrange import Bearing, Operation
from lagrange.bearing import Cage
from lagrange.kinematics import kinematics_met
from lagrange.mounting import Mounting
from lagrange.scene.run import DampingTable
from lagrange.surface.deviation import profiles


@dataclass(frozen=True, kw_only=True)
class Arrays:
    """All state of a run: what the kernels change in place."""

    bodies: Bodies
    groups: tuple[tuple[Pair, ...], ...]  # pairs of bodies; see `fem.kernels.jit.every`
    contacts: Contacts
    drive: Drive
    scratch: Scratch

    def named(self) -> dict[str, np.ndarray]:
        """Every array that a run changes, once, by where it stands; surfaces and pairs share those of bodies."""
        return {name: array for name, (array, given) in self._all().items() if not given}

    def digest(self) -> str:
        """Of the arrays that the model determines, which no run changes."""
        text = hashlib.sha256()
        for name, (array, given) in self._all().items():
            if given:
                text.update(f"{name} {array.dtype} {array.shape} ".encode() + array.tobytes())
        return text.hexdigest()

    @property
    def nbytes(self) -> int:
        """Of the arrays that a run changes, and of those that each step fills."""
        return sum(getattr(array, "nbytes", 0) for array in (*self.named().values(), *self.scratch))

    def _all(self) -> dict[str, tuple[np.ndarray, bool]]:
        """Every array that outlives a step, and whether the model determines it."""
        found: dict[str, tuple[np.ndarray, bool]] = {}
        for name in ("bodies", "contacts", "drive"):
            collect_arrays(getattr(self, name), name, found)
        return found

    def check(self) -> None:
        """Refuse places in arrays that are outside of them: kernels look there unseen; springs that push when pulled.

        Errors
        ------
        ValueError.
        """
        patches, points, shear = self.contacts.patches, self.contacts.points, self.contacts.friction.shear
        for pair in (pair for group in self.groups for pair in group if hasattr(pair, "row")):
            sides = pair.surface or self.bodies.surface, self.bodies.surface
            for side, surface in enumerate(sides):
                _check_between("patches.start", patches.start[2 * pair.row + side], getattr(surface, "n_nodes", 1) - 1)
                _check_between("patches.place", patches.place[2 * pair.row + side], _last_place(surface))
        if points is not None and points.spread is not None:
            closed, most = points.spread.closed, points.closing.size
            _check_between("closed", closed[..., 0], closed[..., 1])
            _check_between("closed", closed[..., 1], most)
        if shear is not None and np.any(shear.compliance <= 0.0):
            raise ValueError("springs without a compliance")


REACH = 0.01  # of a roller's radius
REACH_OF_LOOSE = 0.1  # the same where an outer ring bends or moves as a whole; twice what guards let rollers go


def pair_groups(
    model: Model, rings: tuple[Ring, Ring], drive: Drive, housing: Housing | None, data: KernelData, columns: int
) -> tuple:
    """All pairs of bodies that may touch, in groups of one type. `housing`: of the outer ring; None: the ground."""
    bearing, (hub, ground) = model.bearing, (model.inner_ring, model.outer_ring)
    nowhere = np.zeros(2)
    held_at = nowhere if housing is None else housing.place
    turning = None if drive.history is None else drive.history.outer
    if not hub.material.rigid:
        inner_surface = _ring_surface(hub, rings[0], data.ripples[INNER])
    else:
        inner_surface = _moved_with(bearing, drive.hub, drive, hub.raceway_radius)._replace(
            speed=drive.speed, history=drive.history
        )
    if not ground.material.rigid:
        outer_surface = _ring_surface(ground, rings[1], data.ripples[OUTER])
    elif housing is None:
        outer_surface = Ground(radius=ground.raceway_radius, turning=turning)
    else:
        outer_surface = _moved_with(bearing, housing.place, housing, ground.raceway_radius)
    orbit = ground.raceway_radius - model.roller.shape.radius
    inner_profiles, outer_profiles = raceway_profiles(bearing, columns)
    on_inner = Pair(
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
        **inner_profiles,
    )
    on_outer = Pair(
        row=OUTER,
        sign=-1.0,
        radius=ground.raceway_radius,
        orbit=orbit,
        law=data.laws[OUTER],
        surface=outer_surface,
        centre=held_at,
        counted_from=nowhere if ground.material.rigid else held_at,
        frame=np.array([0.0, 1.0, 0.0]) if turning is None else turning.frame,
        impulse=np.zeros(2) if housing is None else housing.impulse,  # the ground's, which nobody reads
        moment=np.zeros(2) if turning is None else turning.moment,
        **outer_profiles,
    )
    between = Pair(row=ROLLER, law=data.laws[ROLLER])
    return tuple(tuple(group) for _, group in groupby((on_inner, on_outer, between), key=numba.typeof))


def _moved_with(bearing: Bearing, place: np.ndarray, body: Drive | Housing, radius: float) -> Hub:
    """A rigid ring that is part of the hub, or of the housing, and does not turn."""
    return Hub(
        place=place,
        velocity=body.velocity,
        impulse=body.impulse,
        n_contacts=bearing.n_rollers,
        late_mass=body.late_mass,
        speed=0.0,
        radius=radius,
    )


def disc_surface(model: Model, rollers: Rollers, disc: Disc, data: KernelData) -> DiscSurface | RigidDisc:
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
        v=disc.v,
        points=disc.points,
        inverse_mass=at_line(
            1.0 / np.append(disc.mass, np.resize(disc.mass[model.roller.first_surface_node :], WIDTH))
        ),
        impulse=rollers.node_impulse,
        ripple=at_line(with_seam(data.ripples[ROLLER])),
        first=model.roller.first_surface_node,
        n_nodes=model.roller.shape.surface_nodes,
        columns=rollers.columns,
        radius=rollers.radius,
    )


def _ring_surface(body: RingBody, ring: Ring, ripple: np.ndarray) -> RingSurface:
    return RingSurface(
        u=ring.u,
        w=ring.w,
        v=ring.v,
        cosines=ring.cosines,
        sines=ring.sines,
        ripple=at_line(with_seam(ripple)),
        row=ring.raceway,
        n_nodes=ring.n_sectors,
        node_mass=float(ring.row_mass[ring.raceway]),
        radius=body.raceway_radius,
    )


def contact_arrays(
    model: Model,
    operation: Operation,
    start: Start,
    data: KernelData,
    friction: float,
    mass: ReciprocalMass,
    columns: int,
) -> Contacts:
    """Contacts at the start, with its static forces. `mass` : of nodes.

    Errors
    ------
    ValueError: long steps, in which velocities are not momenta's, and friction that is solved for by these.
    """
    if mass.share > 0.0 and friction > 0.0 and data.shear_levels is None:
        raise ValueError("contacts without tangential springs need lumped masses")
    n = model.bearing.n_rollers
    pairs = len(data.laws)
    force = np.zeros((pairs, columns))
    force[INNER, :n], force[OUTER, :n] = start.equilibrium.inner_force, start.equilibrium.outer_force
    sizes = {"pairs": pairs, "columns": columns, "entries": N_NODES * len(data.units)}
    return Contacts(
        forces=filled(Forces, sizes, force=force),
        patches=filled(Patches, sizes, columns=columns, units=data.units),
        friction=filled(
            Friction,
            sizes,
            coefficient=float(friction),
            overlapping=_overlapping(model, data.neighbourly) if data.shear_levels is None else None,
            whole=True if _shares_rigid_bodies(model, operation) else None,
            shear=None if data.shear_levels is None else filled(Shear, sizes, level=np.array(data.shear_levels)),
        ),
        points=data.points,
        reach=_reach(model, operation) + data.facet_depth,
    )


def _shares_rigid_bodies(model: Model, operation: Operation) -> bool:
    moves = operation.mounting.housing is not None
    return model.roller.material.rigid or model.inner_ring.material.rigid or (model.outer_ring.material.rigid and moves)


def _overlapping(model: Model, width: float) -> int | None:
    """Whether patches can come within `width` nodes, as `Friction.overlapping` says it.

    On a raceway those of rollers that touch, on a roller its own.
    """
    on_raceways, on_rollers = _nodes_between(model)
    if on_raceways < width:
        return ALWAYS
    return WHERE_ROLLERS_TOUCH if on_rollers < width else None


def _nodes_between(model: Model) -> tuple[float, float]:
    """Node spacings between contacts of two rollers that touch: on a raceway, and on a roller; infinite on rigid ones.

    On a roller that is from a raceway to the other roller, less than from raceway to raceway.
    """
    bearing = model.bearing
    apart = np.arcsin(min(1.0, bearing.roller_radius / bearing.pitch_radius)) / np.pi  # turns
    rings = [ring.n_sectors * apart for ring in (model.inner_ring, model.outer_ring) if not ring.material.rigid]
    on_rollers = model.roller.shape.surface_nodes * (0.25 - 0.5 * apart)
    return min(rings, default=np.inf), np.inf if model.roller.material.rigid else on_rollers


def _reach(model: Model, operation: Operation) -> float:
    """A gap that elastic motion can't close: far above any contact's approach, and twice the growth under rotation."""
    disc, met = model.roller, kinematics_met(model.bearing, operation)
    growth = 0.0
    for ring, speeds in ((model.inner_ring, met.shaft), (model.outer_ring, met.outer_ring)):
        if fastest := float(np.abs(speeds).max()):
            growth = max(growth, float(np.abs(ring.held(ring.body_load(0.0, 0.0, fastest))).max()))
    spin = np.abs(met.roller).max()
    swelling = disc.relaxed(spin**2 * (disc.mass[:, None] * disc.points).ravel())
    surfaces = profiles(model.bearing)
    highest = 0.0 if surfaces is None else surfaces.highest
    reach = REACH_OF_LOOSE if isinstance(model.outer_ring, LooseRing) else REACH
    return reach * disc.shape.radius + 2.0 * float(growth + np.abs(swelling).max()) + highest


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
    shaft = springs_on(operation.mounting, drive.hub, drive.velocity, drive.slowed, drive.mass, rollers.n)
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


def _last_place(surface: tuple) -> int:
    """The last place in a surface's arrays where a node may stand, with what is read beside and behind it."""
    if isinstance(surface, RingSurface):
        return surface.u.size - surface.cosines.size - WIDTH
    return surface.u.size - surface.columns - 1 if isinstance(surface, DiscSurface) else 0


def _check_between(name: str, found: np.ndarray, most: np.ndarray | int) -> None:
    if np.any(found < 0) or np.any(found > most):
        raise ValueError(f"{name} lies outside of its array")


def bore_body(body: RingBody, ring: Ring, outer_rate: np.ndarray, housing: Housing | None, column: int) -> Bore | None:
    """The bore of a housing, or of the ground; None where the ring is held otherwise.

    Parameters
    ----------
    outer_rate : (n_rows, 2, n_sectors), m/s, of the ring's nodes at the start; column : of a row, the first for it
    """
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


def housing_body(
    model: Model, operation: Operation, ring: Ring, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The housing at rest at a place, (2,), m, its outer ring with it; None where the ground holds the ring.

    `column` : of a sample's row, the first for it
    """
    mounting, body = operation.mounting, model.outer_ring
    if mounting.housing is None:
        return None
    if isinstance(body, BoredRing):  # which moves by itself
        return housing_of(mounting, 0.0, None, place, dt, column)
    rigid = body.material.rigid
    carried = body.total_mass if rigid else body.n_sectors * body.row_mass[body.held_row]
    return housing_of(mounting, carried, None if rigid else ring, place, dt, column)


def with_damping(arrays: Arrays, model: Model, table: DampingTable) -> Arrays:
    """The arrays with what a scene's [damping] says; themselves where it says nothing."""
    contacts, bodies, dt = arrays.contacts, arrays.bodies, arrays.drive.dt
    if table.contacts.acts:
        levels = np.array(model.kernel_data(1.0).whole_levels)
        shape = contacts.forces.force.shape
        sizes = dict(zip(("pairs", "columns"), shape, strict=True))
        contacts = contacts._replace(dampers=filled(Dampers, sizes, law=table.contacts, whole=levels))
    if table.bodies_1_s > 0.0:
        step = table.bodies_1_s * dt
        around = [body for body in bodies.others if isinstance(body, Bore | Housing)]  # a housing's bore first
        turning = None if arrays.drive.history is None else arrays.drive.history.outer
        damping = filled(BodyDamping, {}, share=-expm1(-step), around=around[0] if around else turning)
        bodies = bodies._replace(damping=damping)
    return replace(arrays, contacts=contacts, bodies=bodies)


def with_cage(
    arrays: Arrays, bearing: Bearing, cage: Cage, start: Start, seat: np.ndarray, mounting: Mounting
) -> Arrays:
    """Arrays of the finite elements with a cage; `seat` : (2,), m, of its centre from the outer ring's."""
    rollers, drive = arrays.bodies.rollers, arrays.drive
    first = row_width(bearing.n_rollers, None, mounting)
    body = cage_state(bearing, cage, start.angle, start.kinematics.cage, first)
    body.motion[0, :2] = start.housing + seat
    if arrays.bodies.disc.mass.size:
        rollers = rollers._replace(swelling=np.zeros(rollers.columns))
    housing = next((body for body in arrays.bodies.others if isinstance(body, Housing)), None)
    outer = None if housing is None else ring_of_housing(housing, housing.late_mass)
    pair = CagePair(
        cage=body,
        riders=_riders(rollers),
        ring=guiding(
            cage, ring_that_guides(drive.hub, drive.velocity, drive.impulse, drive.late_mass, drive.speed), outer
        ),
    )
    return replace(
        arrays,
        bodies=arrays.bodies._replace(rollers=rollers, others=(*arrays.bodies.others, body)),
        groups=((pair,), *arrays.groups),  # before impulses through nodes, which it would take for its rollers' own
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

"""What the time loop of the finite elements takes: the state a run starts from, and arrays from it.

A start is static equilibrium in rolling motion, or undeformed and centred; rollers may tilt. Arrays are those of
bodies, surfaces, pairs and contacts, from a model, a start and a time step; and the fields that are read off them:
displacements at an instant, and what they are in the fixed axes.
"""

from dataclasses import dataclass, replace
from itertools import groupby
from math import expm1

import numba
import numpy as np

from fem.contacts.model import Model, Motion
from fem.contacts.subgrid import SubgridModel
from fem.contacts.tilted import MeshedContact, rounded_range
from fem.elastic import bodies
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.outer_support import BoredRing, LooseRing, SupportedRing
from fem.elastic.reciprocal_mass import ReciprocalMass, Slowing, disc_momenta, held_velocity, ring_momenta
from fem.kernels.cage import Riders
from fem.kernels.columns import BLOCKS, INNER, N_SCALARS, OUTER, ROLLER
from fem.kernels.elements import discs, rings, state
from fem.kernels.elements.bodies import Bore, HeldNodes
from fem.kernels.elements.friction import ALWAYS, WHERE_ROLLERS_TOUCH
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import Bodies, Contacts, Disc, DiscSurface, Drive, Pair, Ring, Rollers
from fem.kernels.elements.surfaces import N_NODES
from fem.kernels.elements.tilted import Axes, PatchMoments, SlicedLaw, TiltedSurfaces
from fem.kernels.fields import at_line, lined_up
from fem.kernels.lanes import WIDTH
from fem.kernels.law import with_seam
from fem.kernels.mounts import Housing, late_mass
from fem.solver import parts
from fem.solver.parts import filled
from fem.solver.row_state import collect_arrays, row_width
from fem.solver.solver import Frame
from fem.solver.start import Tables, tables_of, unloaded
from fem.statics.contact_balance import ROUND_OFF, Loads, hub_spring, hub_stiffness
from fem.statics.equilibrium import Equilibrium, Tilting, equilibrium
from fem.statics.exact_statics import exact_contacts, kept_contacts
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial.slices import MORE, Axial
from lagrange.bearing import Cage
from lagrange.errors import UsageError
from lagrange.first_state import Passing, passing, places_moving, tilts_moving
from lagrange.kinematics import kinematics, kinematics_met, roller_angles, turned
from lagrange.motion import Tilts, hub_tilt
from lagrange.mounting import ring_place
from lagrange.scene.run import DampingTable
from lagrange.surface.deviation import profiles

# ---- The state a run starts from: static equilibrium in rolling motion, or undeformed and centred; rollers may tilt.

LOOK_AHEAD = 0.01  # of a node spacing: how far contacts roll between the equilibria that give the velocities


@dataclass(frozen=True, kw_only=True)
class Start:
    """Positions and velocities at t = 0. SI; frames as in `fem.kernels.elements.discs` and `rings`."""

    equilibrium: Equilibrium
    kinematics: Kinematics
    angle: np.ndarray  # (n_rollers,), rad
    hub_velocity: np.ndarray  # (2,)
    roller_velocity: np.ndarray  # (n_rollers, 2)
    roller_rate: np.ndarray  # du/dt in the frames, (n_rollers, n_nodes, 2)
    inner_rate: np.ndarray  # (n_rows, 2, n_sectors)
    outer_rate: np.ndarray
    housing: np.ndarray  # (2,), m, of the outer ring's centre; all other places are about it
    tilts: Tilts | None = None  # of rollers that tilt; None: axes stay parallel
    steady: bool = True  # forces hold every node on its circle; False: nothing is strained yet, nodes go straight on
    warning: str | None = None  # on velocities that it starts without


def rolling_motion(model: Model, operation: Operation, time: float) -> Motion:
    """Angles and speeds at a time if everything rolls without slip."""
    bearing, way = model.bearing, turned(model.bearing, operation, time)
    ideal = kinematics(bearing, *operation.at(time).ring_speeds)
    return Motion(
        roller_angle=roller_angles(bearing, operation.first_roller_angle) + way.cage,
        roller_turn=np.full(bearing.n_rollers, way.roller), ring_turn=way.shaft, outer_turn=way.outer_ring,
        cage_speed=ideal.cage, roller_speed=ideal.roller, ring_speed=ideal.shaft, outer_speed=ideal.outer_ring,
    )  # fmt: skip


def equilibrium_start(model: Model, operation: Operation, tilting: Tilting | None = None) -> Start:
    """Static equilibrium at t = 0, with the velocities of `passing`; `tilting` : None: axes stay parallel."""
    bearing, motion, ring = model.bearing, rolling_motion(model, operation, 0.0), np.zeros(2)

    def at(time, ring, near=None):
        acting, near = operation.at(time), near or (tilting and tilting.near)
        tilted, loads = tilting and tilting.at(acting, ring), Loads.of(acting, ring=ring)
        return equilibrium(model, rolling_motion(model, operation, time), loads, near, tilted)

    if operation.mounting.shaft is not None:
        on_springs = _weight_on_springs(model, operation)
        ring = ring_place(operation.mounting, on_springs, lambda place: at(0.0, place).outer_force @ motion.radial)
    middle = at(0.0, ring)

    def stiffness():
        """Of the hub by the exact compliances of elastic bodies."""
        if middle.axes is not None:
            return middle.axes.radial_stiffness
        contacts = replace(exact_contacts(bearing, motion.roller_angle), turns=motion.turns)
        return hub_stiffness(contacts, middle.place, middle.forces, hub_spring(operation, ring))

    way = LOOK_AHEAD * model.roller.shape.surface_spacing
    found, warning = passing(lambda time: at(time, ring, middle), stiffness, bearing, operation, way)
    return _start(model, operation, motion, middle, found, warning=warning)


def rest_start(model: Model, operation: Operation, tilting: Tilting | None = None) -> Start:
    """Centred and undeformed, in rolling motion; with preload, by crests or a press fit, at rest without load.

    So are rollers that tilt.
    """
    motion, surfaces, bearing = rolling_motion(model, operation, 0.0), profiles(model.bearing), model.bearing
    if tilting is not None:
        idle = unloaded(operation)
        found = equilibrium(model, motion, Loads.of(idle), tilting.near, tilting.at(idle, np.zeros(2)))
        return _start(model, operation, motion, found)
    clearance = bearing.radial_clearance - (0.0 if surfaces is None else 2.0 * surfaces.highest)
    pressed = isinstance(model.outer_ring, BoredRing) and model.outer_ring.play < 0.0
    if pressed or clearance < -ROUND_OFF * bearing.roller_radius:
        return _start(model, operation, motion, equilibrium(model, motion, Loads(0.0)))
    n = bearing.n_rollers
    inner, outer = (np.zeros((ring.n_rows, 2, ring.n_sectors)) for ring in (model.inner_ring, model.outer_ring))
    undeformed = Equilibrium(
        hub=np.zeros(2), rho=np.full(n, bearing.pitch_radius), inner_force=np.zeros(n), outer_force=np.zeros(n),
        inner_ring=inner, outer_ring=outer, rollers=np.zeros((n, model.roller.n_nodes, 2)),
    )  # fmt: skip
    return _start(model, operation, motion, undeformed, steady=False)


def _weight_on_springs(model, operation):
    housing = operation.mounting.housing
    return 0.0 if housing is None else operation.gravity * (housing.mass + model.outer_ring.total_mass)


def _start(model, operation, motion, found, around=None, **more):
    """Of an equilibrium, with the rates of the `Passing` around it; None: at rest."""
    ideal, housing, axes = kinematics(model.bearing, *operation.ring_speeds), operation.mounting.housing, None
    place = np.zeros(2)
    if housing is not None:  # on its springs, under the contact forces on the outer ring and both weights
        place = (found.outer_force @ motion.radial - [0.0, _weight_on_springs(model, operation)]) / housing.stiffness
    hub, rho, rollers, inner, outer = (
        np.zeros_like(getattr(found, name)) if around is None else around.rate(name)
        for name in ("hub", "rho", "rollers", "inner_ring", "outer_ring")
    )
    if found.axes is not None:
        tilting = around and Passing(around.before.axes, around.after.axes, around.time)
        axes = tilts_moving(found.axes, places_moving(found.axes, tilting))
    return Start(
        equilibrium=found, kinematics=ideal, angle=motion.roller_angle, hub_velocity=hub, roller_rate=rollers,
        roller_velocity=rho[:, None] * motion.radial + (ideal.cage * found.rho)[:, None] * motion.around,
        inner_rate=inner, outer_rate=outer, housing=place, tilts=axes, **more,
    )  # fmt: skip


def tilting_of(model: Model, operation: Operation, axial: Axial, force: float, near: Equilibrium) -> Tilting:
    """Contacts for forces at rest of so many N, near the equilibrium of parallel axes.

    Of a contact's plane compliance A (B − ½ ln Q) its mesh has what the law below the grid leaves, a constant.

    UsageError: a mesh that resolves contacts, by points or nearly by patches.
    """
    too_fine, most = None, MORE * rounded_range(force, 0.0)[0]
    if not isinstance(model, SubgridModel):
        too_fine = "resolves the contacts"
    elif most > (least := min(model.inner_law.Q_line, model.outer_law.Q_line)):
        too_fine = f"resolves contacts under {least:.4g} N, and tables of rollers go to {most:.4g} N"
    if too_fine is not None:
        raise UsageError(
            f"[axial]: the mesh {too_fine}, where slices have no law of their own; use a larger numerics.mesh_size_mm"
        )
    laws, below = kept_contacts(model.bearing)[0].laws, (model.inner_law, model.outer_law)
    meshed = tuple(whole.A * (whole.B - law.B) for whole, law in zip(laws, below, strict=True))
    tables = tables_of(model.bearing, operation, axial, laws, force, meshed)
    met = (MeshedContact(table=tables[0], meshed=meshed[0]), MeshedContact(table=tables[1], meshed=meshed[1]))
    return Tilting(laws=met, hub=hub_tilt(operation, axial), near=near, operation=operation, ring=np.zeros(2))


@dataclass(frozen=True, kw_only=True)
class Arrays:
    """All state of a run: what the kernels change in place."""

    bodies: Bodies
    groups: tuple[tuple[Pair, ...], ...]  # pairs of bodies; see `fem.kernels.jit.every`
    contacts: Contacts
    drive: Drive
    scratch: state.Scratch

    def every(self) -> dict[str, tuple[np.ndarray, bool]]:
        """Every array that outlives a step, once, by where it stands, and whether the model determines it.

        Surfaces and pairs share those of bodies.
        """
        return collect_arrays({"bodies": self.bodies, "contacts": self.contacts, "drive": self.drive})

    def named(self) -> dict[str, np.ndarray]:
        """Those that a run changes."""
        return {name: array for name, (array, given) in self.every().items() if not given}

    @property
    def nbytes(self) -> int:
        """Of the arrays that a run changes, and of those that each step fills."""
        return sum(getattr(array, "nbytes", 0) for array in (*self.named().values(), *self.scratch))

    def check(self) -> None:
        """Refuse places in arrays that are outside of them: kernels look there unseen; springs that push when pulled.

        ValueError.
        """
        patches, points, shear, looked = self.contacts.patches, self.contacts.points, self.contacts.friction.shear, []
        for pair in (pair for group in self.groups for pair in group if hasattr(pair, "row")):
            for side, surface in enumerate((pair.surface or self.bodies.surface, self.bodies.surface)):
                at, last = 2 * pair.row + side, 0  # where a node may stand, with what is read beside and behind it
                if isinstance(surface, state.RingSurface):
                    last = surface.u.size - surface.cosines.size - WIDTH
                elif isinstance(surface, DiscSurface):
                    last = surface.u.size - surface.columns - 1
                first = "patches.start", patches.start[at], getattr(surface, "n_nodes", 1) - 1
                looked += [first, ("patches.place", patches.place[at], last)]
        if points is not None and points.spread is not None:
            begin, end = np.moveaxis(points.spread.closed, -1, 0)
            looked += [("closed", begin, end), ("closed", end, points.closing.size)]
        for name, found, most in looked:
            if np.any(found < 0) or np.any(found > most):
                raise ValueError(f"{name} lies outside of its array")
        if shear is not None and np.any(shear.compliance <= 0.0):
            raise ValueError("springs without a compliance")


REACH = 0.01  # of a roller's radius
REACH_OF_LOOSE = 0.1  # the same where an outer ring bends or moves as a whole; twice what guards let rollers go


def _pair_groups(model, rings, drive, housing, data, columns):
    """All pairs of bodies that may touch, in groups of one type. `housing`: of the outer ring; None: the ground."""
    bearing, (hub, ground), nowhere = model.bearing, (model.inner_ring, model.outer_ring), np.zeros(2)
    held_at, pushed = (nowhere, np.zeros(2)) if housing is None else (housing.place, housing.impulse)
    turning = None if drive.history is None else drive.history.outer
    profile, n = parts.surfaces_of(bearing, columns), {"n_contacts": bearing.n_rollers}

    def raceway(body, ring, row, rigid, **more):
        """Its `Pair` with the rollers; `rigid` : its surface, if it is."""
        surface = rigid
        if not body.material.rigid:
            mass, ripple = ring.row_mass[ring.raceway], at_line(with_seam(data.ripples[row]))
            of_row = {"row": ring.raceway, "n_nodes": ring.n_sectors, "node_mass": mass, "ripple": ripple}
            surface = filled(state.RingSurface, {}, ring, **of_row, radius=body.raceway_radius)
        return Pair(
            row=row, sign=1.0 if row == INNER else -1.0, radius=body.raceway_radius,
            orbit=ground.raceway_radius - model.roller.shape.radius, law=data.laws[row], surface=surface,
            counted_from=nowhere if body.material.rigid else more["centre"], profile=profile.ring_profiles[row],
            roller_profiles=profile.roller_profiles[row], **more,
        )  # fmt: skip

    # rigid rings are part of the hub, or of the housing, which does not turn
    on_hub = filled(state.Hub, {}, drive, **n, place=drive.hub, radius=hub.raceway_radius)
    on_ground = state.Ground(radius=ground.raceway_radius, turning=turning)
    if housing is not None:
        on_ground = filled(state.Hub, {}, housing, **n, speed=0.0, radius=ground.raceway_radius)
    moved = {"frame": drive.frame, "impulse": drive.impulse, "moment": drive.moment}
    on_inner = raceway(hub, rings[0], INNER, on_hub, centre=drive.hub, **moved)
    moved = {"frame": np.array([0.0, 1.0, 0.0]), "moment": np.zeros(2), "impulse": pushed}  # the ground's nobody reads
    if turning is not None:
        moved |= {"frame": turning.frame, "moment": turning.moment}
    on_outer = raceway(ground, rings[1], OUTER, on_ground, centre=held_at, **moved)
    between = Pair(row=ROLLER, law=data.laws[ROLLER])
    return tuple(tuple(group) for _, group in groupby((on_inner, on_outer, between), key=numba.typeof))


def _contact_arrays(model, operation, start, data, friction, mass, columns):
    """Contacts at the start, with its static forces. `mass` : of nodes.

    ValueError: long steps, in which velocities are not momenta's, and friction that is solved for by these.
    """
    if mass.share > 0.0 and friction > 0.0 and data.shear_levels is None:
        raise ValueError("contacts without tangential springs need lumped masses")
    n, pairs, moves = model.bearing.n_rollers, len(data.laws), operation.mounting.housing is not None
    force, shear, overlapping = np.zeros((pairs, columns)), None, None
    force[INNER, :n], force[OUTER, :n] = start.equilibrium.inner_force, start.equilibrium.outer_force
    sizes = {"pairs": pairs, "columns": columns, "entries": N_NODES * len(data.units)}
    if data.shear_levels is not None:
        shear = filled(state.Shear, sizes, level=np.array(data.shear_levels))
    else:
        overlapping = _overlapping(model, data.neighbourly)
    rigid = [body.material.rigid for body in (model.roller, model.inner_ring, model.outer_ring)]
    shared = rigid[0] or rigid[1] or (rigid[2] and moves)  # rigid bodies, by contacts
    how = {"coefficient": friction, "overlapping": overlapping, "whole": True if shared else None, "shear": shear}
    return Contacts(
        forces=filled(state.Forces, sizes, force=force),
        patches=filled(state.Patches, sizes, columns=columns, units=data.units),
        friction=filled(state.Friction, sizes, **how),
        points=data.points,
        reach=_reach(model, operation) + data.facet_depth,
    )


def _overlapping(model, width):
    """Whether patches can come within `width` nodes, as `Friction.overlapping` says it.

    On a raceway those of rollers that touch; on a roller its own, from a raceway to the other roller, which is less
    than from raceway to raceway. On rigid bodies none.
    """
    bearing, rings = model.bearing, (model.inner_ring, model.outer_ring)
    apart = np.arcsin(min(1.0, bearing.roller_radius / bearing.pitch_radius)) / np.pi  # turns
    if any(ring.n_sectors * apart < width for ring in rings if not ring.material.rigid):
        return ALWAYS
    on_roller = model.roller.shape.surface_nodes * (0.25 - 0.5 * apart)
    return WHERE_ROLLERS_TOUCH if on_roller < width and not model.roller.material.rigid else None


def _reach(model, operation):
    """A gap that elastic motion can't close: far above any contact's approach, and twice the growth under rotation."""
    disc, met = model.roller, kinematics_met(model.bearing, operation)
    growth = 0.0
    for ring, speeds in ((model.inner_ring, met.shaft), (model.outer_ring, met.outer_ring)):
        if fastest := float(np.abs(speeds).max()):
            growth = max(growth, float(np.abs(ring.held(ring.body_load(0.0, 0.0, fastest))).max()))
    spin = np.abs(met.roller).max()
    swelling, surfaces = disc.relaxed(spin**2 * (disc.mass[:, None] * disc.points).ravel()), profiles(model.bearing)
    highest = 0.0 if surfaces is None else surfaces.highest
    reach = REACH_OF_LOOSE if isinstance(model.outer_ring, LooseRing) else REACH
    return reach * disc.shape.radius + 2.0 * float(growth + np.abs(swelling).max()) + highest


def make_arrays(
    model: Model, operation: Operation, start: Start, dt: float, friction: float, ramp: float, largest_force: float,
    mass: ReciprocalMass,
) -> Arrays:  # fmt: skip
    """Positions at t = 0 and velocities at −dt/2.

    `ramp` in s; the largest static contact force in N; `mass` : of nodes.
    """
    slowing, data, around = mass.at(dt), model.kernel_data(largest_force), start.equilibrium
    hub, ground, body, mounting = model.inner_ring, model.outer_ring, model.roller, operation.mounting
    n, chord, nowhere = model.bearing.n_rollers, dt if start.steady else 0.0, np.zeros(2)
    inner, outer = ring_nodes(hub, dt, slowing), ring_nodes(ground, dt, slowing)
    columns, column = -(-n // discs.COLUMNS) * discs.COLUMNS, N_SCALARS + len(BLOCKS) * n
    whole = {"total_mass": body.total_mass, "inertia": body.polar_inertia, "radius": body.shape.radius}
    rollers, disc = filled(Rollers, {"columns": columns}, n=n, columns=columns, **whole), disc_nodes(body, dt, columns)
    mass_on_hub, damped = hub_mass(hub, operation), 0.0 if mounting.shaft is None else mounting.shaft.damping
    drive = filled(
        Drive, {}, operation, hub=around.hub + start.housing, velocity=start.hub_velocity.copy(),
        frame=np.array([0.0, 1.0, 0.0]), mass=mass_on_hub, late_mass=late_mass(mass_on_hub, damped, dt), dt=dt,
        slowing=slowing.waves, calming=slowing.velocities / float(dt), ramp=ramp,
        history=parts.history_arrays(model.bearing, operation),
    )  # fmt: skip
    contacts = _contact_arrays(model, operation, start, data, friction, mass, columns)
    if not hub.material.rigid:
        places, rates = (around.inner_ring, drive.hub), (start.inner_rate, start.hub_velocity)
        momenta = _place_ring(hub, inner, places, rates, operation.speed, chord, slowing)
        drive.velocity[:] -= held_velocity(hub, momenta, slowing, drive.mass)
    if not ground.material.rigid:
        places, rates = (around.outer_ring, start.housing), (start.outer_rate, nowhere)
        outer_momenta = _place_ring(ground, outer, places, rates, operation.outer_speed, chord, slowing)
    _place_rollers(body, rollers, disc, start, dt, slowing)
    rollers, disc, inner, outer = (lined_up(group) for group in (rollers, disc, inner, outer))
    for name, absent in (("v", mass.share), ("calmed", mass.calming)):
        if absent == 0.0:
            disc, inner, outer = (group._replace(**{name: group.w}) for group in (disc, inner, outer))
    free = isinstance(ground, BoredRing)  # which moves by itself
    on_housing = 0.0 if free else _held_mass(ground), None if free or ground.material.rigid else outer
    housing = parts.housing_of(mounting, *on_housing, start.housing, dt, column)
    shaft = parts.springs_on(mounting, drive.hub, drive.velocity, drive.slowed, drive.mass, n)
    bore = bore_body(ground, outer, start.outer_rate, housing, column + len(replace(mounting, bore=None).columns))
    others = tuple(body for body in (bore, housing, shaft) if body is not None)  # the bore moves the housing
    if housing is not None and housing.ring is not None:
        housing.velocity[:] -= held_velocity(ground, outer_momenta, slowing, housing.mass)
    if isinstance(ground, SupportedRing):
        held = ground.held_sectors.astype(np.int64)
        place = outer.u[outer.held][:, HALO + held].copy()
        others = (*others, filled(HeldNodes, {}, outer, sectors=held, place=place, row=outer.held))
    copies = {"rollers_w": disc.w, "rollers_velocity": rollers.velocity, "inner_w": inner.w, "outer_w": outer.w}
    copies = {name: np.zeros_like(array) for name, array in copies.items()}
    sizes = {"columns": columns, "inner": inner.u.shape[2], "outer": outer.u.shape[2]}
    if body.material.rigid:
        surface = filled(state.RigidDisc, {}, rollers)
    else:
        masses = np.append(disc.mass, np.resize(disc.mass[body.first_surface_node :], WIDTH))
        known = {"inverse_mass": at_line(1.0 / masses), "ripple": at_line(with_seam(data.ripples[ROLLER]))}
        known |= {"impulse": rollers.node_impulse, "n_nodes": body.shape.surface_nodes}
        surface = filled(DiscSurface, {}, disc, rollers, **known)
    return Arrays(
        bodies=Bodies(rollers=rollers, disc=disc, surface=surface, inner=inner, outer=outer, others=others),
        groups=_pair_groups(model, (inner, outer), drive, housing, data, columns), contacts=lined_up(contacts),
        drive=drive, scratch=lined_up(filled(state.Scratch, sizes, **copies)),
    )  # fmt: skip


def disc_nodes(disc: DiscBody, dt: float, columns: int) -> Disc:
    """Nodes at rest of so many rollers, for steps of `dt`, s; none of rigid ones."""
    starts, neighbours, blocks = disc.blocks()
    points, mass = disc.points, disc.mass
    grown = -dt * (disc.stiffness @ points.ravel()) / np.repeat(mass, 2)
    if disc.material.rigid:
        starts, points, mass, grown = np.zeros(1, dtype=np.int64), np.zeros((0, 2)), np.zeros(0), np.zeros(0)
    rows = np.repeat(np.arange(len(mass)), np.diff(starts))
    return filled(
        Disc, {"n_nodes": len(mass), "columns": columns}, starts=starts, neighbours=neighbours,
        blocks=np.ascontiguousarray(-dt * blocks / mass[rows][:, None, None]).ravel(),
        points=np.ascontiguousarray(points).ravel(), grown=grown, mass=mass.copy(),
        first=0 if disc.material.rigid else disc.first_surface_node,
    )  # fmt: skip


def ring_nodes(ring: RingBody, dt: float, slowing: Slowing) -> Ring:
    """Nodes at rest of a ring, for steps of `dt`, s."""
    if ring.material.rigid:
        width = WIDTH + 2 * HALO  # one node, in a register of its own
        gyration, mass = np.array([np.sqrt(ring.polar_inertia / ring.total_mass)]), np.array([ring.total_mass])
        rows = dict.fromkeys(("first_row", "last_row", "raceway", "held"), 0)
        one = {"radii": gyration, "row_mass": mass, "cosines": np.ones(width), "n_sectors": 1}
        return filled(Ring, {"n_rows": 1, "width": width}, **one, **rows)
    width = ring.n_sectors + 2 * HALO
    angle = 2.0 * np.pi * (np.arange(width) - HALO) / ring.n_sectors
    table = -dt * rings.coefficients(ring.stencil) / ring.row_mass[:, None]
    widening = ring.harmonic_stiffness(np.zeros(1)).real.reshape(ring.n_rows, 2, ring.n_rows, 2)
    first = int(ring.free_rows[0])
    return filled(
        Ring, {"n_rows": ring.n_rows, "width": width}, table=table, slowed=slowing.waves * table,
        calming=slowing.velocities / dt * table, radii=ring.radii.copy(),
        grown=-slowing.waves * dt * (widening[:, 0, :, 0] @ ring.radii) / ring.row_mass, row_mass=ring.row_mass.copy(),
        cosines=np.cos(angle), sines=np.sin(angle), n_sectors=ring.n_sectors, first_row=first,
        last_row=first + len(ring.free_rows), raceway=ring.raceway_row, held=ring.held_row,
    )  # fmt: skip


def _place_ring(body, ring, places, rates, speed, chord, slowing):
    """Polar state about the outer ring's centre: the centre's motion, the rotation and the deformation.

    places, rates : displacements, m, and velocities, m/s, of nodes about the ring's centre, (n_rows, 2, n_sectors), and
        of that, (2,)
    chord : s, a step in which forces hold nodes on circles, or 0

    Returns the momenta, (n_rows, 2, n_sectors), m/s, without what half a step turns of them.
    """
    whole = [body.polar(np.broadcast_to(vector, (len(body.points), 2))) for vector in (places[1], rates[1])]
    position = places[0].copy()
    position[:, 0] += body.radii[:, None]
    turned = np.stack([-position[:, 1], position[:, 0]], axis=1)
    momenta = ring_momenta(body, rates[0] + speed * turned + whole[1], slowing)
    kicked = momenta + 0.5 * (chord * speed**2 * position)  # along chords after it
    for target, values in ((ring.u, places[0] + whole[0]), (ring.w, kicked)):
        target[:, :, HALO:-HALO] = values
        target[:, :, HALO - 1], target[:, :, -HALO:] = values[:, :, -1], values[:, :, :HALO]
    return momenta


def _place_rollers(body, rollers, disc, start, dt, slowing):
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


def hub_mass(ring: RingBody, operation: Operation) -> float:
    """What moves with the hub, kg: the shaft, and the ring's held row or a rigid ring."""
    return float(operation.inner_mass - ring.total_mass + _held_mass(ring))


def _held_mass(ring):
    return ring.total_mass if ring.material.rigid else ring.n_sectors * ring.row_mass[ring.held_row]


def bore_body(body: RingBody, ring: Ring, outer_rate: np.ndarray, housing: Housing | None, column: int) -> Bore | None:
    """The bore of a housing, or of the ground; None where the ring is held otherwise.

    outer_rate : (n_rows, 2, n_sectors), m/s, of the ring's nodes at the start; column : of a row, the first for it
    """
    if not isinstance(body, BoredRing):
        return None
    sizes, velocity = {"n_sectors": body.n_sectors, "width": ring.w.shape[2]}, body.cartesian(outer_rate)
    velocity = velocity.reshape(body.n_rows, -1, 2)[body.held_row].mean(axis=0)
    # the ground's impulse nobody reads
    place, impulse = (np.zeros(2), np.zeros(2)) if housing is None else (housing.place, housing.impulse)
    known = {"ring": ring, "place": place, "impulse": impulse, "velocity": velocity, "column": column}
    return filled(Bore, sizes, **known, play=body.play, stiffness=body.stiffness)


def with_damping(arrays: Arrays, model: Model, table: DampingTable) -> Arrays:
    """The arrays with what a scene's [damping] says; themselves where it says nothing."""
    contacts, bodies, history = arrays.contacts, arrays.bodies, arrays.drive.history
    if table.contacts.acts:
        levels = np.array(model.kernel_data(1.0).whole_levels)
        sizes = dict(zip(("pairs", "columns"), contacts.forces.force.shape, strict=True))
        contacts = contacts._replace(dampers=filled(state.Dampers, sizes, law=table.contacts, whole=levels))
    if table.bodies_1_s > 0.0:
        share = -expm1(-table.bodies_1_s * arrays.drive.dt)
        turning = None if history is None else history.outer
        around = next((body for body in bodies.others if isinstance(body, Bore | Housing)), turning)  # a bore first
        bodies = bodies._replace(damping=filled(state.BodyDamping, {}, share=share, around=around))
    return replace(arrays, contacts=contacts, bodies=bodies)


def with_cage(
    arrays: Arrays, bearing: Bearing, cage: Cage, start: Start, seat: np.ndarray, operation: Operation
) -> Arrays:
    """Arrays with a cage; `seat` : (2,), m, of its centre from the outer ring's."""
    rollers, drive, bodies = arrays.bodies.rollers, arrays.drive, arrays.bodies
    first = row_width(bearing.n_rollers, None, operation.mounting)
    body = parts.cage_state(bearing, cage, start.angle, start.kinematics.cage, first)
    body.motion[0, :2] = start.housing + seat
    if bodies.disc.mass.size:
        rollers = rollers._replace(swelling=np.zeros(rollers.columns))
    housing = next((body for body in bodies.others if isinstance(body, Housing)), None)
    outer = None if housing is None else (housing.place, housing.velocity, housing.impulse, housing.late_mass)
    hub = drive.hub, drive.velocity, drive.impulse, drive.late_mass
    riders = filled(Riders, {}, rollers, mass=rollers.total_mass)
    pair = parts.cage_pair(body, cage, riders, hub, outer, drive.speed)
    return replace(
        arrays,
        bodies=bodies._replace(rollers=rollers, others=(*bodies.others, body)),
        groups=((pair,), *arrays.groups),  # before impulses through nodes, which it would take for its rollers' own
    )


def with_axes(
    arrays: Arrays, bearing: Bearing, operation: Operation, axial: Axial, cage: Cage | None, tables: Tables,
    start: Start,
) -> Arrays:  # fmt: skip
    """Arrays with axes that tilt from a start on."""
    bodies, rollers, (laws, rests) = arrays.bodies, arrays.bodies.rollers, parts.laws_of(tables)
    sizes, uneven = {"columns": rollers.columns}, profiles(bearing) is not None
    part = None if rests[INNER] is None else parts.surfaces_of(bearing, rollers.columns, of_part=True)
    absent = ([] if uneven else ["edges"]) + ([] if part is not None else ["sunken"])
    tilts = parts.axes_at(bearing, operation, axial, cage, start.tilts, rollers.columns)
    axes = filled(Axes, sizes, tilts=tilts, tilted=filled(PatchMoments, sizes, **dict.fromkeys(absent)), n=rollers.n)
    outer = next(pair for group in arrays.groups for pair in group if getattr(pair, "row", None) == OUTER)

    def sliced(pair):
        """A raceway's pair with tables, and without edges, which these take: for patches they would be ripples."""
        if not isinstance(pair, Pair) or pair.surface is None:
            return pair
        row, whole, surfaces = pair.row, {"profile": pair.profile, "roller_profiles": pair.roller_profiles}, None
        if uneven:
            of_part = None if part is None else (part.ring_profiles[row], part.roller_profiles[row])
            surfaces = filled(TiltedSurfaces, {}, pair, rest=rests[row], whole=tuple(whole.values()), part=of_part)
        law = filled(
            SlicedLaw, {}, pair.law, pair, table=laws[row], axes=axes, length=bearing.roller_length,
            slope=axes.tilts.slope if row == INNER else np.zeros(2),
            on_ring=axes.on_hub if row == INNER else np.zeros(2),
            middle=outer.centre, back=outer.impulse, surfaces=surfaces,
        )  # fmt: skip
        smooth = {
            name: each._replace(compliance=at_line(np.zeros_like(each.compliance)))
            for name, each in whole.items()
            if each is not None
        }
        return pair._replace(law=law, **smooth)

    groups = tuple(tuple(sliced(pair) for pair in group) for group in arrays.groups)
    return replace(arrays, bodies=bodies._replace(others=(*bodies.others, axes)), groups=groups)


def frame_of(model: Model, arrays: Arrays, sample: int, interval: float) -> Frame:
    """The solver's displacements just before a sample is taken."""
    rollers, disc, drive, ring = arrays.bodies.rollers, arrays.bodies.disc, arrays.drive, model.inner_ring
    turn = float(drive.frame[0])
    outer, bodies = model.outer_ring, np.zeros((model.roller.n_nodes, 2, rollers.n))
    inner, outside = (np.zeros((body.n_rows, 2, body.n_sectors)) for body in (ring, outer))
    if not model.roller.material.rigid:
        bodies = disc.u.reshape(model.roller.n_nodes, 2, rollers.columns)[:, :, : rollers.n].copy()
    if not ring.material.rigid:
        shift = np.broadcast_to(drive.hub, (len(ring.points), 2))
        inner = arrays.bodies.inner.u[:, :, HALO:-HALO] - ring.polar(shift, turn)
    if not outer.material.rigid:
        outside = arrays.bodies.outer.u[:, :, HALO:-HALO].copy()
        for carrier in (body for body in arrays.bodies.others if isinstance(body, Housing)):
            outside -= outer.polar(np.broadcast_to(carrier.place, (len(outer.points), 2)))
    return Frame(
        sample=sample, time=sample * interval, roller_turn=rollers.turn[: rollers.n].copy(), ring_turn=turn,
        outer_turn=0.0 if drive.history is None or drive.history.outer is None else float(drive.history.outer.frame[0]),
        rollers=np.moveaxis(bodies, -1, 0), inner_ring=inner, outer_ring=outside,
    )  # fmt: skip


def global_fields(model: Model, frame: Frame) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement (..., n_nodes, 2), m, and the mesh's stress (..., n_nodes, 3), Pa, of each kind of body, by a
    `Frame` or what has its displacements and turns.

    In the fixed axes; a roller's arrays have the rollers in front.
    """
    n = len(frame.roller_turn)
    local = (model.roller.stress @ frame.rollers.reshape(n, -1).T).T.reshape(n, -1, 3)
    turn = frame.roller_turn[:, None]
    fields = {"roller": (rotated(frame.rollers, turn), bodies.turned(local, turn))}
    for name, angle in (("inner_ring", frame.ring_turn), ("outer_ring", frame.outer_turn)):
        ring, polar = getattr(model, name), getattr(frame, name)
        stress = (ring.stress @ ring.cartesian(polar).ravel()).reshape(-1, 3)
        fields[name] = ring.cartesian(polar, angle), bodies.turned(stress, angle)
    return fields


def rotated(vectors: np.ndarray, angle) -> np.ndarray:
    """Vectors (..., 2) turned counter-clockwise by angles, rad, of shape (...) or one that broadcasts to it."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)

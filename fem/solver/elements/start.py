"""The state a run starts from: static equilibrium in rolling motion, or undeformed and centred; rollers may tilt."""

from dataclasses import dataclass, replace

import numpy as np

from fem.contacts.model import Model, Motion
from fem.contacts.subgrid import SubgridModel
from fem.contacts.tilted import MeshedContact, rounded_range
from fem.elastic.outer_support import BoredRing
from fem.solver import start as massless
from fem.solver.start import unloaded
from fem.statics.contact_balance import ROUND_OFF, Loads, hub_spring, hub_stiffness, passing, standing_ring
from fem.statics.equilibrium import Equilibrium, Tilting, equilibrium
from fem.statics.exact_statics import exact_contacts, kept_contacts, reduced_bearing
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial import Axial
from lagrange.axial.slices import MORE
from lagrange.errors import UsageError
from lagrange.first_state import places_moving, tilts_moving
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.motion import Tilts, hub_tilt
from lagrange.surface.deviation import profiles

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


def rolling_motion(model: Model, operation: Operation, time: float) -> tuple[Motion, Kinematics]:
    """Angles at a time if everything rolls without slip."""
    ideal = kinematics(model.bearing, *operation.at(time).ring_speeds)
    way = turned(model.bearing, operation, time)
    angle = roller_angles(model.bearing, operation.first_roller_angle)
    n = model.bearing.n_rollers
    motion = Motion(
        roller_angle=angle + way.cage, roller_turn=np.full(n, way.roller), ring_turn=way.shaft, cage_speed=ideal.cage,
        roller_speed=ideal.roller, ring_speed=ideal.shaft, outer_turn=way.outer_ring, outer_speed=ideal.outer_ring,
    )  # fmt: skip
    return motion, ideal


def equilibrium_start(model: Model, operation: Operation, tilting: Tilting | None = None) -> Start:
    """Static equilibrium at t = 0, with the velocities of `passing`; `tilting` : None: axes stay parallel."""

    def at(time, ring, near=None):
        (motion, _), acting = rolling_motion(model, operation, time), operation.at(time)
        if tilting is not None:
            return equilibrium(model, motion, Loads.of(acting), near or tilting.near, tilting.at(acting, ring))
        return equilibrium(model, motion, Loads.of(acting)._replace(spring=hub_spring(operation, ring)), near)

    (motion, ideal), ring = rolling_motion(model, operation, 0.0), np.zeros(2)
    if operation.mounting.shaft is not None:
        on_springs = _weight_on_springs(model, operation)
        ring = standing_ring(operation, on_springs, lambda place: at(0.0, place).outer_force @ motion.radial)
    middle = at(0.0, ring)

    def stiffness() -> np.ndarray:
        """Of the hub by the exact compliances of elastic bodies."""
        if middle.axes is not None:
            return middle.axes.radial_stiffness
        place = np.concatenate([middle.hub, middle.rho])
        forces = np.concatenate([middle.inner_force, middle.outer_force])
        contacts = replace(exact_contacts(model.bearing, motion.roller_angle), turns=motion.turns)
        return hub_stiffness(contacts, place, forces, hub_spring(operation, ring))

    way = LOOK_AHEAD * model.roller.shape.surface_spacing
    found, warning = passing(lambda time: at(time, ring, middle), stiffness, model.bearing, operation, way)
    still = _still(model, operation, middle, motion, warning=warning)
    if found is None:
        return still
    axes = None
    if middle.axes is not None:
        axes = tilts_moving(middle.axes, places_moving(found.before.axes, middle.axes, found.after.axes, found.time))
    return replace(
        still, hub_velocity=found.rate("hub"),
        roller_velocity=found.rate("rho")[:, None] * motion.radial + (ideal.cage * middle.rho)[:, None] * motion.around,
        roller_rate=found.rate("rollers"), inner_rate=found.rate("inner_ring"), outer_rate=found.rate("outer_ring"),
        tilts=axes,
    )  # fmt: skip


def rest_start(model: Model, operation: Operation, tilting: Tilting | None = None) -> Start:
    """Centred and undeformed, in rolling motion; with preload, by crests or a press fit, at rest without load.

    So are rollers that tilt.
    """
    (motion, _), surfaces, bearing = rolling_motion(model, operation, 0.0), profiles(model.bearing), model.bearing
    if tilting is not None:
        idle = unloaded(operation)
        found = equilibrium(model, motion, Loads.of(idle), tilting.near, tilting.at(idle, np.zeros(2)))
        return _still(model, operation, found, motion)
    clearance = bearing.radial_clearance - (0.0 if surfaces is None else 2.0 * surfaces.highest)
    pressed = isinstance(model.outer_ring, BoredRing) and model.outer_ring.play < 0.0
    if pressed or clearance < -ROUND_OFF * bearing.roller_radius:
        return _still(model, operation, equilibrium(model, motion, Loads(0.0)), motion)
    n = bearing.n_rollers
    inner, outer = (np.zeros((ring.n_rows, 2, ring.n_sectors)) for ring in (model.inner_ring, model.outer_ring))
    undeformed = Equilibrium(
        hub=np.zeros(2), rho=np.full(n, bearing.pitch_radius), inner_force=np.zeros(n), outer_force=np.zeros(n),
        inner_ring=inner, outer_ring=outer, rollers=np.zeros((n, model.roller.n_nodes, 2)),
    )  # fmt: skip
    return _still(model, operation, undeformed, motion, steady=False)


def _weight_on_springs(model: Model, operation: Operation) -> float:
    housing = operation.mounting.housing
    return 0.0 if housing is None else operation.gravity * (housing.mass + model.outer_ring.total_mass)


def _still(model: Model, operation: Operation, equilibrium: Equilibrium, motion: Motion, **more) -> Start:
    ideal, housing, place = kinematics(model.bearing, *operation.ring_speeds), operation.mounting.housing, np.zeros(2)
    if housing is not None:  # on its springs, under the contact forces on the outer ring and both weights
        force = equilibrium.outer_force @ motion.radial
        place = (force - [0.0, _weight_on_springs(model, operation)]) / housing.stiffness
    return Start(
        equilibrium=equilibrium, kinematics=ideal, angle=motion.roller_angle, hub_velocity=np.zeros(2),
        roller_velocity=(ideal.cage * equilibrium.rho)[:, None] * motion.around,
        roller_rate=np.zeros_like(equilibrium.rollers), inner_rate=np.zeros_like(equilibrium.inner_ring),
        outer_rate=np.zeros_like(equilibrium.outer_ring), housing=place,
        tilts=None if equilibrium.axes is None else tilts_moving(equilibrium.axes), **more,
    )  # fmt: skip


def tilting_of(model: Model, operation: Operation, axial: Axial, force: float, near: Equilibrium) -> Tilting:
    """Contacts for forces at rest of so many N, near the equilibrium of parallel axes.

    Of a contact's plane compliance A (B − ½ ln Q) its mesh has what the law below the grid leaves, a constant.

    UsageError: a mesh that resolves contacts, by points or nearly by patches.
    """
    bearing, too_fine = model.bearing, None
    most = MORE * rounded_range(force, 0.0)[0]
    if not isinstance(model, SubgridModel):
        too_fine = "resolves the contacts"
    elif most > (least := min(model.inner_law.Q_line, model.outer_law.Q_line)):
        too_fine = f"resolves contacts under {least:.4g} N, and tables of rollers go to {most:.4g} N"
    if too_fine is not None:
        raise UsageError(
            f"[axial]: the mesh {too_fine}, where slices have no law of their own; use a larger numerics.mesh_size_mm"
        )
    contacts, _ = kept_contacts(bearing)
    laws, below = (contacts.inner_law, contacts.outer_law), (model.inner_law, model.outer_law)
    inner, outer = (whole.A * (whole.B - law.B) for whole, law in zip(laws, below, strict=True))
    tables = massless.tables_of(bearing, operation, axial, laws, force, (inner, outer))
    met = (MeshedContact(table=tables[0], meshed=inner), MeshedContact(table=tables[1], meshed=outer))
    return Tilting(laws=met, hub=hub_tilt(operation, axial), near=near, operation=operation, ring=np.zeros(2))


def check_slices_unmeshed(bearing: Bearing, operation: Operation, axial: Axial) -> None:
    """`check_slices` before anything is meshed, of an outer ring that is held all around. UsageError."""
    if operation.mounting.points is None and operation.mounting.bore is None:
        model = reduced_bearing(bearing, kinematics(bearing, *operation.ring_speeds), gravity=operation.gravity)
        massless.check_slices(model, operation, axial, massless.equilibrium_start(model, operation))


def check_slices(model: Model, axial: Axial, start: Start) -> None:
    """Refuse coupled slices that are too narrow for the forces of a start. UsageError."""
    contacts, _ = kept_contacts(model.bearing)
    laws, axes = (contacts.inner_law, contacts.outer_law), start.equilibrium.axes
    if axes is not None and (reason := massless.narrow_slices(model.bearing, axial, laws, axes)) is not None:
        raise UsageError(reason)

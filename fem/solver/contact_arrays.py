"""Contacts for the time loop: the bodies' surfaces, the pairs that may touch, and the arrays of their contacts."""

from itertools import groupby
from typing import TYPE_CHECKING

import numba
import numpy as np

from fem.elastic.outer_support import LooseRing
from fem.elastic.reciprocal_mass import ReciprocalMass
from fem.kernels.fields import at_line, filled
from fem.kernels.friction_solution import ALWAYS, WHERE_ROLLERS_TOUCH
from fem.kernels.housing_kernels import Housing
from fem.kernels.lanes import WIDTH
from fem.kernels.law import with_seam
from fem.kernels.patches import N_NODES
from fem.kernels.state import (
    INNER,
    OUTER,
    ROLLER,
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
    Shear,
)
from fem.solver.part_arrays import raceway_profiles
from lagrange import Bearing, Operation
from lagrange.kinematics import kinematics_met
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.contacts.model import KernelData, Model
    from fem.elastic.bodies import RingBody
    from fem.solver.start import Start

REACH = 0.01  # of a roller's radius
REACH_OF_LOOSE = 0.1  # the same where an outer ring bends or moves as a whole; twice what guards let rollers go


def pair_groups(
    model: "Model", rings: tuple[Ring, Ring], drive: Drive, housing: Housing | None, data: "KernelData", columns: int
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
        **inner_profiles,
    )
    on_outer = Raceway(
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
    between = Neighbours(row=ROLLER, law=data.laws[ROLLER])
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


def disc_surface(model: "Model", rollers: Rollers, disc: Disc, data: "KernelData") -> DiscSurface | RigidDisc:
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


def _ring_surface(body: "RingBody", ring: Ring, ripple: np.ndarray) -> RingSurface:
    """What contacts see of an elastic ring."""
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
    model: "Model",
    operation: Operation,
    start: "Start",
    data: "KernelData",
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


def _shares_rigid_bodies(model: "Model", operation: Operation) -> bool:
    """Whether a rigid body that moves has several contacts."""
    moves = operation.mounting.housing is not None
    return model.roller.material.rigid or model.inner_ring.material.rigid or (model.outer_ring.material.rigid and moves)


def _overlapping(model: "Model", width: float) -> int | None:
    """Whether patches can come within `width` nodes, as `Friction.overlapping` says it.

    On a raceway those of rollers that touch, on a roller its own.
    """
    on_raceways, on_rollers = _nodes_between(model)
    if on_raceways < width:
        return ALWAYS
    return WHERE_ROLLERS_TOUCH if on_rollers < width else None


def _nodes_between(model: "Model") -> tuple[float, float]:
    """Node spacings between contacts of two rollers that touch: on a raceway, and on a roller; infinite on rigid ones.

    On a roller that is from a raceway to the other roller, less than from raceway to raceway.
    """
    bearing = model.bearing
    apart = np.arcsin(min(1.0, bearing.roller_radius / bearing.pitch_radius)) / np.pi  # turns
    rings = [ring.n_sectors * apart for ring in (model.inner_ring, model.outer_ring) if not ring.material.rigid]
    on_rollers = model.roller.shape.surface_nodes * (0.25 - 0.5 * apart)
    return min(rings, default=np.inf), np.inf if model.roller.material.rigid else on_rollers


def _reach(model: "Model", operation: Operation) -> float:
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

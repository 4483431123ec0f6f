"""The stress of an instant including what lies below the grid: the mesh's, less its patches', plus Hertz's.

On rollers the exchange is made everywhere: what the mesh is left with is then smooth throughout. On rings it fades out
with the distance from the contact; far away the two fields agree, and around the outer ring they can't be continued.
"""

from dataclasses import dataclass

import numpy as np

from fem.contacts.model import Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.stress import turned
from fem.pictures.recover import Instant
from fem.pictures.subsurface import SurfaceLoad, hertz_stress, spline_displacement
from fem.solver.frames import global_fields, rotated

WINDOW = 0.4, 0.8  # radii of a raceway: whole up to this distance from the contact, nothing from the second on
BEYOND = 1.0  # radii: strains at the window's end look at nodes further away
INNER_RING, OUTER_RING, FIRST_ROLLER = 0, 1, 2  # numbers of bodies


@dataclass(frozen=True, kw_only=True)
class BodyLoad:
    """A contact force on a body, `load` in the body's axes: from its centre, not turned with it."""

    body: int
    kind: str  # of contact: inner, outer, next (roller j with j + 1)
    roller: int  # j of the contact
    load: SurfaceLoad
    radius: float  # m, of the surface, > 0 convex
    spacing: float | None  # m, a quarter of the patch that the mesh carries the force as; None: the true pressure
    is_rigid: bool  # the body has no stress

    @property
    def is_resolved(self) -> bool:
        """Whether the mesh carries the true pressure: there is nothing to exchange."""
        return self.spacing is None

    def share(self, points: np.ndarray) -> np.ndarray:
        """How far the exchange is made at points (n, 2) from the body's centre: 1 at the contact, 0 far away."""
        if self.is_resolved or self.is_rigid:
            return np.zeros(len(points))
        if self.body >= FIRST_ROLLER:
            return np.ones(len(points))
        distance = np.hypot(*(points - self.load.point).T) / abs(self.radius)
        x = np.clip((WINDOW[1] - distance) / (WINDOW[1] - WINDOW[0]), 0.0, 1.0)
        return x * x * (3.0 - 2.0 * x)


def contact_loads(instant: Instant) -> list[BodyLoad]:
    """All contact forces on all bodies, two for each contact."""
    model, length = instant.model, instant.model.bearing.roller_length
    disc, inner, outer = model.roller, model.inner_ring, model.outer_ring
    n = model.bearing.n_rollers
    loads = []

    def add(contact, body, shape, angle, force, half_width):
        convex = -1.0 if body == OUTER_RING else 1.0
        radius, nodes = _surface(shape)
        outward = np.array([np.cos(angle), np.sin(angle)])
        load = SurfaceLoad(
            point=radius * outward, inward=-convex * outward, force=force / length, half_width=half_width
        )
        kind, roller = contact
        loads.append(
            BodyLoad(
                body=body,
                kind=kind,
                roller=roller,
                load=load,
                radius=convex * radius,
                spacing=model.smeared(2.0 * np.pi * radius / nodes, half_width),
                is_rigid=shape.material.rigid,
            )
        )

    for kind, ring, body, sign in (("inner", inner, INNER_RING, 1.0), ("outer", outer, OUTER_RING, -1.0)):
        law = getattr(model, f"{kind}_law")
        angles, forces, tractions = (getattr(instant, f"{kind}_{name}") for name in ("angle", "force", "traction"))
        for j in np.flatnonzero(forces > 0.0):
            c, s = np.cos(angles[j]), np.sin(angles[j])
            push = sign * forces[j] * np.array([c, s]) + tractions[j] * np.array([-s, c])  # on the roller
            b = law.pair.half_width(forces[j])
            add((kind, j), body, ring, angles[j], -push, b)
            add((kind, j), FIRST_ROLLER + j, disc, angles[j] + (np.pi if sign > 0.0 else 0.0), push, b)
    for j in np.flatnonzero(instant.roller_force > 0.0):
        angle, b = instant.next_angle[j], model.roller_law.pair.half_width(instant.roller_force[j])
        push = instant.roller_force[j] * np.array([np.cos(angle), np.sin(angle)])
        add(("next", j), FIRST_ROLLER + j, disc, angle, -push, b)
        add(("next", j), FIRST_ROLLER + (j + 1) % n, disc, angle + np.pi, push, b)
    return loads


def _surface(body: DiscBody | RingBody) -> tuple[float, int]:
    """Radius, m, and node count of the circle that carries contacts."""
    if isinstance(body, DiscBody):
        return body.shape.radius, body.shape.surface_nodes
    return body.raceway_radius, body.n_sectors


def smooth_stress(instant: Instant, loads: list[BodyLoad]) -> list[np.ndarray]:
    """Nodal stress of every body less its patches' near the contacts, (n_nodes, 3), Pa, fixed axes; by body number."""
    model, fields = instant.model, global_fields(instant.model, instant)
    stresses = [fields["inner_ring"][1], fields["outer_ring"][1], *fields["roller"][1]]
    for item in loads:
        if item.is_resolved or item.is_rigid:
            continue
        body, turn = _body(model, instant, item.body)
        points = rotated(body.points, turn)
        near = np.hypot(*(points - item.load.point).T) < BEYOND * abs(item.radius)
        near |= item.body >= FIRST_ROLLER
        displacement = np.zeros_like(points)
        displacement[near] = spline_displacement(points[near], item.load, item.radius, item.spacing, body.material)
        stress = turned((body.stress @ rotated(displacement, -turn).ravel()).reshape(-1, 3), turn)
        stresses[item.body] -= item.share(points)[:, None] * stress
    return stresses


def _body(model: Model, instant: Instant, number: int) -> tuple[DiscBody | RingBody, float]:
    if number == INNER_RING:
        return model.inner_ring, instant.ring_turn
    if number == OUTER_RING:
        return model.outer_ring, 0.0
    return model.roller, float(instant.roller_turn[number - FIRST_ROLLER])


def add_hertz(stress: np.ndarray, points: np.ndarray, body: np.ndarray, loads: list[BodyLoad]) -> None:
    """Add the contacts' own fields to a smooth stress, in place.

    Parameters
    ----------
    stress : (n, 3), Pa; points : (n, 2), m, from the bodies' centres; body : (n,), numbers
    """
    for item in loads:
        at = np.flatnonzero(body == item.body)
        share = item.share(points[at])
        at, share = at[share > 0.0], share[share > 0.0]
        stress[at] += share[:, None] * hertz_stress(points[at], item.load)

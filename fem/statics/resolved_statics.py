"""Static equilibrium with resolved contacts: Newton on hub and radii around an active set of pressure points."""

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from fem.elastic.model import Model
from fem.elastic.resolved import disc_push, ring_push
from fem.kernels.facet_kernels import chord
from fem.statics.contact_balance import LOOSE_SPRING, Condensed, Loads, NotFound, balance, closed_forces, first_guess
from fem.statics.equilibrium import Equilibrium, Motion
from fem.statics.exact_statics import exact_contacts

PASSES = 2  # points sit along the lines of centres, which the solution moves by microradians
FACET_PASSES = 6  # and by milliradians where facets leave the hub room
REACH = 2.0  # points lie up to so many half-widths of the expected force from the line of centres
FAINT = 0.05  # of the largest force: contacts expected to carry less get the points of this one
MAX_NEWTON = 40
MAX_CLOSING = 100
ENOUGH = 1e-9  # of the load


@dataclass(frozen=True, kw_only=True)
class Pressures:
    """Of one contact, along the tangent."""

    across: np.ndarray  # (n_points,), m, from the line of centres
    pressure: np.ndarray  # (n_points,), Pa


def resolved_equilibrium(
    model: Model, motion: Motion, radial_load: float, weight: float, gravity: float, start: Equilibrium | None = None
) -> Equilibrium:
    """The equilibrium of `equilibrium.static_equilibrium` with resolved contacts in place of a law below the grid.

    Errors
    ------
    NotFound: no equilibrium. The balance is exact to ENOUGH of the load.
    """
    return _equilibrium(model, *_solved(model, motion, radial_load + weight, gravity, start))


def contact_pressures(model: Model, motion: Motion, radial_load: float) -> list[Pressures]:
    """Pressures of all contacts under a load, N, weightless: inner ones by roller, then outer ones."""
    points, _, forces = _solved(model, motion, radial_load, 0.0, None)
    found = []
    for contact in range(2 * model.bearing.n_rollers):
        law = (model.inner_law, model.outer_law)[contact // model.bearing.n_rollers]
        mine = points.contact == contact
        found.append(Pressures(across=points.across[mine], pressure=forces[mine] / (law.spacing * law.thickness)))
    return found


def _solved(model: Model, motion: Motion, load: float, gravity: float, start: Equilibrium | None):
    """Points, hub and radii, and the forces of the points in equilibrium."""
    bearing, n = model.bearing, model.bearing.n_rollers
    if start is None:
        contacts = exact_contacts(bearing, motion.roller_angle)
        guess = first_guess(bearing, contacts.radial, load)
        place, forces = balance(contacts, Loads(load, gravity, motion.cage_speed), guess)
    else:
        place = np.concatenate([start.hub, start.rho])
        forces = np.concatenate([start.inner_force, start.outer_force])
    for _ in range(FACET_PASSES if model.inner_law.is_one_point else PASSES):
        points = _points(model, motion, gravity, place, forces)
        if model.inner_law.is_one_point:
            place, pressed = balance(_condensed(model, motion, points), Loads(load, gravity, motion.cage_speed), place)
            pressed = closed_forces(pressed)
        else:
            place, pressed = _balance(model, motion, points, place, load, gravity)
        forces = np.bincount(points.contact, pressed, minlength=2 * n)
    return points, place, pressed


@dataclass(frozen=True, kw_only=True)
class _Points:
    """Pressure points of all contacts (inner ones first, then outer), and the elastic response to forces on them."""

    contact: np.ndarray  # (n_points,)
    across: np.ndarray  # (n_points,), m, from the line of centres along the tangent
    rise: np.ndarray  # (n_points,), m, by which the circles, or their facets, fall apart
    growth: np.ndarray  # (n_points,), m, closing by centrifugal load and weight
    compliance: np.ndarray  # (n_points, n_points), m/N, with what the mesh lacks
    loads: list  # per ring and roller: (points, nodes, (2 nodes, points) nodal forces of unit forces)
    inner_growth: np.ndarray
    outer_sag: np.ndarray
    roller_growth: np.ndarray


def _points(model: Model, motion: Motion, gravity: float, place, forces) -> _Points:
    _bearing, n = model.bearing, model.bearing.n_rollers
    disc, rings = model.roller, (model.inner_ring, model.outer_ring)
    laws = (model.inner_law, model.outer_law)
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    to_roller = radial * place[2:, None] - place[:2]
    line = np.concatenate([np.arctan2(to_roller[:, 1], to_roller[:, 0]), motion.roller_angle])
    faintest = FAINT * forces.max()
    across, contact = [], []
    for c in range(2 * n):
        law = laws[c // n]
        if law.is_one_point:
            across.append(np.zeros(1))
            contact.append(np.full(1, c))
            continue
        half = max(2, int(np.ceil(REACH * law.half_width(max(forces[c], faintest)) / law.spacing)))
        half = min(half, law.most_points // 2)
        across.append((np.arange(-half, half) + 0.5) * law.spacing)
        contact.append(np.full(2 * half, c))
    across, contact = np.concatenate(across), np.concatenate(contact)
    kind, j = contact // n, contact % n
    rise, angles = np.zeros(across.size), np.zeros((2, across.size))
    for side in (0, 1):
        radius = np.array([law.radii[side] for law in laws])[kind]
        angles[side] = np.arcsin(across / np.abs(radius))
        rise += radius * (1.0 - np.cos(angles[side]))
    on_ring = line[contact] + angles[0]
    on_roller = np.where(kind == 0, line[contact] + pi - angles[1], line[contact] + angles[1]) - motion.roller_turn[j]
    rise += _chords(laws, kind, 1, on_roller, disc.shape.surface_nodes)
    for k, (ring, turn) in enumerate(zip(rings, (motion.ring_turn, 0.0), strict=True)):
        mine = kind == k
        rise[mine] += _chords(laws, kind[mine], 0, on_ring[mine] - turn, ring.n_sectors)

    compliance = np.zeros((across.size, across.size))
    for c in range(2 * n):
        mine = np.flatnonzero(contact == c)
        compliance[np.ix_(mine, mine)] = laws[c // n].local_compliance(mine.size)
    growth, loads = np.zeros(across.size), []
    fields = (
        rings[0].held(rings[0].body_load(gravity, motion.ring_turn, motion.ring_speed)),
        rings[1].held(rings[1].body_load(gravity)),
    )
    for k, ring in enumerate(rings):
        mine = np.flatnonzero(kind == k)
        turn, outward = (motion.ring_turn, 1.0) if k == 0 else (0.0, -1.0)
        nodes, push = ring_push(ring, on_ring[mine] - turn, outward / np.cos(angles[0, mine]), laws[k].spreads)
        compliance[np.ix_(mine, mine)] += push.T @ ring.surface_influence(nodes) @ push
        growth[mine] += push.T @ fields[k][ring.raceway_row][:, nodes].T.ravel()
        loads.append((mine, nodes, push))
    swelling = disc.relaxed(motion.roller_speed**2 * (disc.mass[:, None] * disc.points).ravel())
    for roller in range(n):
        mine = np.flatnonzero(j == roller)
        nodes, push = disc_push(disc, on_roller[mine], 1.0 / np.cos(angles[1, mine]), laws[0].spreads)
        compliance[np.ix_(mine, mine)] += push.T @ disc.surface_influence(nodes) @ push
        growth[mine] += push.T @ swelling.reshape(-1, 2)[disc.first_surface_node + nodes].ravel()
        loads.append((mine, nodes, push))
    return _Points(
        contact=contact,
        across=across,
        rise=rise,
        growth=growth,
        compliance=compliance,
        loads=loads,
        inner_growth=fields[0],
        outer_sag=fields[1],
        roller_growth=swelling,
    )


class _Nothing:
    """The law of a contact whose every compliance is in the matrix."""

    @staticmethod
    def approach(force):
        return np.zeros_like(force)

    softness = approach


def _condensed(model: Model, motion: Motion, points: _Points) -> Condensed:
    """Contacts of one point each, for the balance that bears facets which leave load to three rollers."""
    return Condensed(
        bearing=model.bearing,
        radial=np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)]),
        inner_law=_Nothing,
        outer_law=_Nothing,
        compliance=points.compliance,
        growth=points.growth - points.rise,
    )


def _chords(laws, kind, side: int, angle, n_nodes: int) -> np.ndarray:
    """How far facets lie below the circle at angles of a surface, (n_points,), m."""
    sagitta = np.array([(law.sagitta or (0.0, 0.0))[side] for law in laws])[kind]
    return sagitta * np.array([chord(x)[0] for x in np.mod(angle * n_nodes / (2.0 * pi), 1.0)])


def _pressed(points: _Points, overlap: np.ndarray, active: np.ndarray):
    """Forces of all points, N, their derivative to the contacts' overlaps summed by contact, and the active points."""
    closing = overlap[points.contact] - points.rise + points.growth
    count = overlap.size
    for _ in range(MAX_CLOSING):
        i = np.flatnonzero(active)
        force = np.zeros(closing.size)
        factor = lu_factor(points.compliance[np.ix_(i, i)]) if i.size else None
        if i.size:
            force[i] = lu_solve(factor, closing[i])
        left = closing - points.compliance @ force
        found = np.where(active, force > 0.0, left > 0.0)
        if np.array_equal(found, active):
            break
        active = found
    else:
        raise NotFound(f"static equilibrium not found: contacts still open and close after {MAX_CLOSING} steps")
    slopes = np.zeros((count, count))
    if i.size:
        spread = np.zeros((i.size, count))
        spread[np.arange(i.size), points.contact[i]] = 1.0
        slopes = spread.T @ lu_solve(factor, spread)
    return force, slopes, active


def _balance(model: Model, motion: Motion, points: _Points, place, load: float, gravity: float):
    """Hub and radii in equilibrium, (2 + n_rollers,), and the forces of all points."""
    bearing, n = model.bearing, model.bearing.n_rollers
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    active = np.zeros(points.contact.size, dtype=bool)

    def system(place, active):
        to_roller = radial * place[2:, None] - place[:2]
        distance = np.hypot(to_roller[:, 0], to_roller[:, 1])
        normal = to_roller / distance[:, None]
        along = np.sum(normal * radial, axis=1)
        overlap = np.concatenate(
            [
                bearing.inner_raceway_radius + bearing.roller_radius - distance,
                place[2:] + bearing.roller_radius - bearing.outer_raceway_radius,
            ]
        )
        force, slopes, active = _pressed(points, overlap, active)
        total = np.bincount(points.contact, force, minlength=2 * n)
        inner, outer = total[:n], total[n:]
        residual = np.concatenate(
            [
                -inner @ normal - np.array([0.0, load]) - LOOSE_SPRING * place[:2],
                inner * along
                - outer
                + bearing.roller_mass * (motion.cage_speed**2 * place[2:] - gravity * radial[:, 1])
                - LOOSE_SPRING * (place[2:] - bearing.pitch_radius),
            ]
        )
        j = np.arange(n)
        closing = np.zeros((2 * n, 2 + n))
        closing[:n, :2] = normal
        closing[j, 2 + j], closing[n + j, 2 + j] = -along, 1.0
        # forces do work on the closing they cause; the turning of the normals adds what is left
        jacobian = -closing.T @ slopes @ closing - LOOSE_SPRING * np.eye(2 + n)
        for k in range(n):
            turn = (np.eye(2) - np.outer(normal[k], normal[k])) * (inner[k] / distance[k])
            jacobian[:2, :2] += turn
            jacobian[:2, 2 + k] -= turn @ radial[k]
            jacobian[2 + k, :2] -= turn @ radial[k]
            jacobian[2 + k, 2 + k] += radial[k] @ turn @ radial[k]
        return residual, jacobian, force, active

    residual, jacobian, force, active = system(place, active)
    enough = ENOUGH * max(load, 1.0)
    for _ in range(MAX_NEWTON):
        norm = np.linalg.norm(residual)
        if norm <= enough:
            return place, force
        step, length = np.linalg.solve(jacobian, -residual), 1.0
        while True:
            trial = place + length * step
            found = system(trial, active)
            if np.linalg.norm(found[0]) < norm or length < 1e-6:
                break
            length *= 0.5
        if length < 1e-6:
            break
        place, (residual, jacobian, force, active) = trial, found
    if norm > 100.0 * enough + 2.0 * LOOSE_SPRING * abs(bearing.radial_clearance):
        raise NotFound(f"static equilibrium not found: residual {norm:.2e} N under {load:.4g} N, contacts resolved")
    return place, force


def _equilibrium(model: Model, points: _Points, place, pressed) -> Equilibrium:
    n, disc = model.bearing.n_rollers, model.roller
    forces = np.bincount(points.contact, pressed, minlength=2 * n)
    fields = []
    for ring, growth, (mine, nodes, push) in zip(
        (model.inner_ring, model.outer_ring), (points.inner_growth, points.outer_sag), points.loads, strict=False
    ):
        nodal = np.zeros((ring.n_rows, 2, ring.n_sectors))
        nodal[ring.raceway_row][:, nodes] = -(push @ pressed[mine]).reshape(-1, 2).T
        fields.append(growth + ring.held(nodal))
    nodal = np.zeros((disc.n_nodes, 2, n))
    for roller, (mine, nodes, push) in enumerate(points.loads[2:]):
        nodal[disc.first_surface_node + nodes, :, roller] = -(push @ pressed[mine]).reshape(-1, 2)
    rollers = disc.relaxed(nodal.reshape(-1, n)) + points.roller_growth[:, None]
    return Equilibrium(
        hub=place[:2].copy(),
        rho=place[2:].copy(),
        inner_force=forces[:n].copy(),
        outer_force=forces[n:].copy(),
        inner_ring=fields[0],
        outer_ring=fields[1],
        rollers=rollers.T.reshape(n, -1, 2).copy(),
    )

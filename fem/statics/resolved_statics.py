"""Static equilibrium with resolved contacts: pressure points and the elastic response to forces on them."""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.elastic.model import Model
from fem.elastic.points import disc_push, ring_push
from fem.kernels.facet_kernels import chord
from fem.statics.contact_balance import Condensed, Loads, NoLaw, balance, closed_forces, first_guess
from fem.statics.equilibrium import Equilibrium, Motion
from fem.statics.exact_statics import exact_contacts
from fem.statics.pressure_balance import PressurePoints, balance_pressures

PASSES = 2  # points sit along the lines of centres, which the solution moves by microradians
FACET_PASSES = 6  # and by milliradians where facets leave the hub room
REACH = 2.0  # points lie up to so many half-widths of the expected force from the line of centres
FAINT = 0.05  # of the largest force: contacts expected to carry less get the points of this one


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
    NotFound: no equilibrium. The balance is exact to 1e-9 of the load.
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
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    if start is None:
        contacts = exact_contacts(bearing, motion.roller_angle)
        guess = first_guess(bearing, radial, load)
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
            outward = bearing.roller_mass * (motion.cage_speed**2 * place[2:] - gravity * radial[:, 1])
            place, pressed = balance_pressures(bearing, radial, points, load, outward, place)
        forces = np.bincount(points.contact, pressed, minlength=2 * n)
    return points, place, pressed


@dataclass(frozen=True, kw_only=True)
class _Points(PressurePoints):
    """Pressure points, what the mesh lacks in their compliance, and what the bodies do under forces on them."""

    across: np.ndarray  # (n_points,), m, from the line of centres along the tangent
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
        closing=growth - rise,
        compliance=compliance,
        loads=loads,
        inner_growth=fields[0],
        outer_sag=fields[1],
        roller_growth=swelling,
    )


def _condensed(model: Model, motion: Motion, points: _Points) -> Condensed:
    """Contacts of one point each, for the balance that bears facets which leave load to three rollers."""
    return Condensed(
        bearing=model.bearing,
        radial=np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)]),
        inner_law=NoLaw,
        outer_law=NoLaw,
        compliance=points.compliance,
        growth=points.closing,
    )


def _chords(laws, kind, side: int, angle, n_nodes: int) -> np.ndarray:
    """How far facets lie below the circle at angles of a surface, (n_points,), m."""
    sagitta = np.array([(law.sagitta or (0.0, 0.0))[side] for law in laws])[kind]
    return sagitta * np.array([chord(x)[0] for x in np.mod(angle * n_nodes / (2.0 * pi), 1.0)])


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

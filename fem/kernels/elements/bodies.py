"""Further bodies, neither roller nor ring nor hub: what the time loop asks of each; what holds an outer ring outside.

That is a bore around it, with play or pressed in, or points that stand still, or the housing, with which the ring's
held row moves as the inner ring's does with the hub. A bore's kicks are those of contacts, `law.kick_force`, so that a
node that meets or leaves it within a step costs no energy. Without friction nothing keeps the ring from turning but an
impulse around the circle, the same at all nodes, that leaves their velocities around a mean of 0, and so does no work.

Equation (3) of docs/supports.md.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels import mounts
from fem.kernels.cage import Cage, drift_cage, kick_cage, write_cage
from fem.kernels.columns import CONTACT
from fem.kernels.elements import rings
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import Ring
from fem.kernels.elements.tilted import Axes, kick_axes_of
from fem.kernels.fields import given, room, state
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import load_pair
from fem.kernels.lanes import WIDTH, load, select, splat, store, total
from fem.kernels.law import kick_force
from fem.kernels.mounts import Housing, Shaft
from fem.kernels.tilts import turn_axes, write_axes

PLACE_X, PLACE_Y, AX, AY, FORCE_X, FORCE_Y, ARC = range(7)  # of the bore's columns, from its first one on


class HeldNodes(NamedTuple):
    """They take what a kick gives them, and do no work."""

    u: np.ndarray
    w: np.ndarray  # (n_rows, 2, n_sectors + 2 HALO), of the ring
    calmed: np.ndarray
    sectors: given("n_held", dtype=np.int64)
    place: state("2, n_held")  # m
    row: int


class Bore(NamedTuple):
    """Around a ring; of a housing, which moves, or of the ground."""

    ring: Ring
    place: np.ndarray  # (2,), m, of its centre: the housing's
    impulse: np.ndarray  # (2,), N s, of this step on the housing
    velocity: state("2")  # m/s, mean of the ring's outside, at t − dt/2
    before: state("2")  # m/s, before the last kick
    depth: state("n_sectors", np.nan)  # m, of the nodes in the bore at the last kick; below 0: apart, NaN: not known
    kick: state("n_sectors")  # N, that the last kick gave them
    residual: state("n_sectors")  # J, stored beyond what kicks have taken
    line: room("2, width")  # of the ring
    play: float  # m, radial; negative: what the ring is larger by
    stiffness: float  # N/m, at one node
    column: int  # of a sample's row, its first


@part
def kick_body(body, drive):
    """Advance a body's velocities by one step: its weight, and the impulses of pairs, which are then cleared."""
    if isinstance(body, Shaft):
        mounts.kick_shaft(body, drive.dt, body.place[0], body.place[1])
    elif isinstance(body, Housing):
        ring = body.ring
        if ring is not None:  # what the held row has from its nodes
            rings.row_force(ring.table, ring.u, ring.held, body.line)
            x, y = rings.resultant(body.line, ring.cosines, ring.sines)
            body.impulse[0] += ring.row_mass[ring.held] * x
            body.impulse[1] += ring.row_mass[ring.held] * y
        mounts.kick_housing(body, drive)
    elif isinstance(body, Cage):
        kick_cage(body, drive)
    elif isinstance(body, Axes):
        kick_axes_of(body, drive)
    elif isinstance(body, Bore):
        ring, dt = body.ring, drive.dt
        radial = 2 * ring.held * ring.cosines.size
        around, over = radial + ring.cosines.size, dt / ring.row_mass[ring.held]
        x, y, turning = splat(0.0), splat(0.0), splat(0.0)
        for k in range(HALO, HALO + ring.n_sectors, WIDTH):
            depth, before = _depths(body, radial, k), load(body.depth, k - HALO)
            force = select(depth > 0.0, body.stiffness * depth, 0.0)
            last = select(before > 0.0, body.stiffness * before, 0.0)
            past = before, last, 0.0, load(body.kick, k - HALO), load(body.residual, k - HALO)
            kick, residual = kick_force((1.0, 0.0), past, (depth, force, 0.0))
            store(body.depth, k - HALO, depth)
            store(body.kick, k - HALO, kick)
            store(body.residual, k - HALO, residual)
            store(ring.w, radial + k, load(ring.w, radial + k) - over * kick)
            x += kick * load(ring.cosines, k)
            y += kick * load(ring.sines, k)
            turning += load(ring.w, around + k)
        body.impulse[0] += dt * total(x)
        body.impulse[1] += dt * total(y)
        mean = total(turning) / ring.n_sectors
        for k in range(HALO, HALO + ring.n_sectors, WIDTH):
            store(ring.w, around + k, load(ring.w, around + k) - mean)
        body.before[0], body.before[1] = body.velocity[0], body.velocity[1]
    elif isinstance(body, HeldNodes):
        _put_at_held_nodes(body, body.w, None, False)


@part
def drift_body(body, drive):
    """Advance a body's positions by one step."""
    if isinstance(body, Shaft):
        mounts.drift_shaft(body, drive)
    elif isinstance(body, Housing):
        mounts.drift_housing(body, drive)
        if body.ring is not None:
            _set_held_row(body.ring, body.ring.u, body.place)
    elif isinstance(body, Cage):
        drift_cage(body, drive)
    elif isinstance(body, Axes):
        turn_axes(body.tilts, drive)
    elif isinstance(body, HeldNodes):
        _put_at_held_nodes(body, body.u, body.place, True)


@part
def write_body(body, drive, out):
    """Add a body's kinetic energy at the kick just made, J, its work of gravity, what it stores and dissipates to a
    sample's, and its own numbers to their places."""
    if isinstance(body, Shaft):
        mounts.write_shaft(body, drive, out)
    elif isinstance(body, Housing):
        mounts.write_housing(body, drive, out)
    elif isinstance(body, Cage):
        write_cage(body, drive, out)
    elif isinstance(body, Axes):
        write_axes(body.tilts, body, body, drive, out)
    elif isinstance(body, Bore):
        ring, at, dt = body.ring, body.column, drive.dt
        radial = 2 * ring.held * ring.cosines.size
        x, y, square, touching = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for k in range(HALO, HALO + ring.n_sectors, WIDTH):
            depth = _depths(body, radial, k)
            pushed = select(depth > 0.0, depth, 0.0)
            x += pushed * load(ring.cosines, k)
            y += pushed * load(ring.sines, k)
            square += pushed * pushed
            touching += select(depth > 0.0, splat(1.0), 0.0)
        out[CONTACT] += 0.5 * body.stiffness * total(square)
        out[at + PLACE_X], out[at + PLACE_Y] = _mean(ring, ring.u, radial)
        out[at + AX], out[at + AY] = (body.velocity[0] - body.before[0]) / dt, (body.velocity[1] - body.before[1]) / dt
        out[at + FORCE_X], out[at + FORCE_Y] = -body.stiffness * total(x), -body.stiffness * total(y)
        out[at + ARC] = 2.0 * np.pi * total(touching) / ring.n_sectors


@part
def take_late(housing):
    """Take the impulses of pairs that have come after a housing's kick."""
    for k in range(2):
        housing.velocity[k] += housing.impulse[k] / housing.late_mass
        housing.impulse[k] = 0.0


@part
def end_kick(body, drive):
    """Conclude a kick in which a body's velocities are those after it."""
    if isinstance(body, Shaft):
        mounts.conclude(body)
        drive.moment[1] += drive.dt * (body.place[0] * body.drag[1] - body.place[1] * body.drag[0])
    elif isinstance(body, Housing):
        mounts.conclude(body)


@part
def _set_held_row(ring, field, vector):
    at = 2 * ring.held * ring.cosines.size
    rings.set_rigid(field, at, ring.cosines, ring.sines, vector[0], vector[1])


@part
def prepare(housing):
    """Give an elastic ring's held row the velocity of the housing."""
    if housing.ring is not None:
        _set_held_row(housing.ring, housing.ring.w, housing.velocity)


@part
def calm_body(body):
    """Give what an elastic ring's row has of a body's motion to its calmed velocities."""
    if isinstance(body, Housing):
        if body.ring is not None:
            rings.calm_held(body.ring, body.mass, body.line)
    elif isinstance(body, HeldNodes):
        _put_at_held_nodes(body, body.calmed, None, True)


@part
def slow_body(body, drive):
    """Find what the reciprocal mass adds to a body's motion in the next step."""
    if isinstance(body, Housing):
        ring = body.ring
        if ring is not None:
            if drive.slowing > 0.0:
                rings.row_force(ring.slowed, ring.calmed, ring.held, body.line)
                x, y = rings.resultant(body.line, ring.cosines, ring.sines)
                share = ring.row_mass[ring.held] / body.mass
                remember_slowed(body.slowed, share * x, share * y)
    elif isinstance(body, Bore):  # the mean velocity of the outside: that of momenta, and what the mass adds
        ring = body.ring
        body.velocity[0], body.velocity[1] = _mean(ring, ring.w, 2 * ring.held * ring.cosines.size)
        if drive.slowing > 0.0:
            rings.row_force(ring.slowed, ring.calmed, ring.held, body.line)
            x, y = _mean(ring, body.line, 0)
            body.velocity[0] += x / drive.dt
            body.velocity[1] += y / drive.dt


@part
def remember_slowed(slowed, x, y):
    """What the reciprocal mass adds in the next step, m, after that of the last one; (2, 2)."""
    slowed[0, 0], slowed[0, 1] = slowed[1, 0], slowed[1, 1]
    slowed[1, 0], slowed[1, 1] = x, y


kick_others, drift_others, write_others = every(kick_body), every(drift_body), every(write_body)
take_all_late, prepare_others = every(take_late, Housing), every(prepare, Housing)
end_kicks, calm_others, slow_others = every(end_kick), every(calm_body), every(slow_body)


@part
def _put_at_held_nodes(held, field, values, wraps):
    """Give held nodes `values`, (2, n_held), of a field of the ring; None: 0. And its halos, if it `wraps`."""
    for component in range(2):
        for i in range(held.sectors.size):
            value = 0.0 if values is None else values[component, i]
            field[held.row, component, HALO + held.sectors[i]] = value
    if wraps:
        rings.wrap(field, 2 * held.row * field.shape[2], field.shape[2])


@part
def _depths(bore, radial, k):
    """How far eight nodes are in the bore, m; below 0 they are not."""
    ring = bore.ring
    outward = load(ring.u, radial + k) - bore.place[0] * load(ring.cosines, k) - bore.place[1] * load(ring.sines, k)
    return outward - bore.play


@part
def _mean(ring, polar, radial):
    """Mean of vectors at the nodes of the ring's outside, x and y, whose radial components begin at `radial`."""
    x, y = splat(0.0), splat(0.0)
    for k in range(HALO, HALO + ring.n_sectors, WIDTH):
        c, s = load(ring.cosines, k), load(ring.sines, k)
        a, b = load_pair(polar, radial + k, ring.cosines.size)
        x += a * c - b * s
        y += a * s + b * c
    return total(x) / ring.n_sectors, total(y) / ring.n_sectors

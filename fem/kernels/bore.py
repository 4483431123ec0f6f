"""What holds an outer ring at its outside: a bore around it, with play or pressed in, or points that stand still.

Kicks are those of contacts, `law.kick_force`, so that a node that meets or leaves the bore within a step costs no
energy. Without friction nothing keeps the ring from turning but an impulse around the circle, the same at all nodes,
that leaves their velocities around a mean of 0, and so does no work.

Equation (3) of docs/supports.md.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.bodies import add_motion, calm_body, drift_body, kick_body, slow_body
from fem.kernels.fields import given, room, state
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, select, splat, total
from fem.kernels.law import kick_force
from fem.kernels.ring_kernels import HALO, row_force, wrap
from fem.kernels.sample_kernels import CONTACT
from fem.kernels.state import Ring


class HeldNodes(NamedTuple):
    """They take what a kick gives them, and do no work."""

    u: np.ndarray
    w: np.ndarray  # (n_rows, 2, n_sectors + 2 HALO), of the ring
    calmed: np.ndarray
    sectors: given("n_held", np.int64)
    place: state("2, n_held")  # m
    row: int


@kick_body.of(HeldNodes)
def _hold(held, drive):
    for i in range(held.sectors.size):
        for component in range(2):
            held.w[held.row, component, HALO + held.sectors[i]] = 0.0


@calm_body.of(HeldNodes)
def _calm(held):
    width = held.calmed.shape[2]
    for component in range(2):
        for i in range(held.sectors.size):
            held.calmed[held.row, component, HALO + held.sectors[i]] = 0.0
        wrap(held.calmed, (2 * held.row + component) * width, width)


@drift_body.of(HeldNodes)
def _stay(held, drive):
    width = held.u.shape[2]
    for component in range(2):
        for i in range(held.sectors.size):
            held.u[held.row, component, HALO + held.sectors[i]] = held.place[component, i]
        wrap(held.u, (2 * held.row + component) * width, width)


PLACE_X, PLACE_Y, AX, AY, FORCE_X, FORCE_Y, ARC = range(7)  # of the bore's columns, from its first one on


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
def _lines(ring):
    """Where the radial and the tangential components of the ring's outside begin."""
    radial = 2 * ring.held * ring.cosines.size
    return radial, radial + ring.cosines.size


@part
def _depths(bore, radial, k):
    """How far eight nodes are in the bore, m; below 0 they are not."""
    ring = bore.ring
    outward = load(ring.u, radial + k) - bore.place[0] * load(ring.cosines, k) - bore.place[1] * load(ring.sines, k)
    return outward - bore.play


@part
def _mean(ring, polar, radial):
    """Mean of vectors at the nodes of the ring's outside, x and y, whose radial components begin at `radial`."""
    around = radial + ring.cosines.size
    x, y = splat(0.0), splat(0.0)
    for k in range(HALO, HALO + ring.n_sectors, WIDTH):
        c, s, a, b = load(ring.cosines, k), load(ring.sines, k), load(polar, radial + k), load(polar, around + k)
        x += a * c - b * s
        y += a * s + b * c
    return total(x) / ring.n_sectors, total(y) / ring.n_sectors


@part
def _pushed(bore, i, depth):
    """What a kick gives eight nodes from node i on inward, N."""
    before = load(bore.depth, i)
    last = select(before > 0.0, bore.stiffness * before, 0.0)
    force = select(depth > 0.0, bore.stiffness * depth, 0.0)
    state = before, last, 0.0, load(bore.kick, i), load(bore.residual, i)
    kick, residual = kick_force((1.0, 0.0), state, (depth, force, 0.0))
    store(bore.depth, i, depth)
    store(bore.kick, i, kick)
    store(bore.residual, i, residual)
    return kick


@kick_body.of(Bore)
def _kick(bore, drive):
    ring, dt = bore.ring, drive.dt
    radial, around = _lines(ring)
    over = dt / ring.row_mass[ring.held]
    x, y, turning = splat(0.0), splat(0.0), splat(0.0)
    for k in range(HALO, HALO + ring.n_sectors, WIDTH):
        kick = _pushed(bore, k - HALO, _depths(bore, radial, k))
        store(ring.w, radial + k, load(ring.w, radial + k) - over * kick)
        x += kick * load(ring.cosines, k)
        y += kick * load(ring.sines, k)
        turning += load(ring.w, around + k)
    bore.impulse[0] += dt * total(x)
    bore.impulse[1] += dt * total(y)
    mean = total(turning) / ring.n_sectors
    for k in range(HALO, HALO + ring.n_sectors, WIDTH):
        store(ring.w, around + k, load(ring.w, around + k) - mean)
    bore.before[0], bore.before[1] = bore.velocity[0], bore.velocity[1]


@slow_body.of(Bore)
def _slow(bore, drive):
    """The mean velocity of the outside: that of momenta, and what the reciprocal mass adds."""
    ring = bore.ring
    bore.velocity[0], bore.velocity[1] = _mean(ring, ring.w, _lines(ring)[0])
    if drive.slowing > 0.0:
        row_force(ring.slowed, ring.calmed, ring.held, bore.line)
        x, y = _mean(ring, bore.line, 0)
        bore.velocity[0] += x / drive.dt
        bore.velocity[1] += y / drive.dt


@add_motion.of(Bore)
def _add_motion(bore, drive, out, kinetic):
    ring, at, dt = bore.ring, bore.column, drive.dt
    radial, _ = _lines(ring)
    x, y, square, touching = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(HALO, HALO + ring.n_sectors, WIDTH):
        depth = _depths(bore, radial, k)
        pushed = select(depth > 0.0, depth, 0.0)
        x += pushed * load(ring.cosines, k)
        y += pushed * load(ring.sines, k)
        square += pushed * pushed
        touching += select(depth > 0.0, splat(1.0), 0.0)
    out[CONTACT] += 0.5 * bore.stiffness * total(square)
    out[at + PLACE_X], out[at + PLACE_Y] = _mean(ring, ring.u, radial)
    out[at + AX], out[at + AY] = (bore.velocity[0] - bore.before[0]) / dt, (bore.velocity[1] - bore.before[1]) / dt
    out[at + FORCE_X], out[at + FORCE_Y] = -bore.stiffness * total(x), -bore.stiffness * total(y)
    out[at + ARC] = 2.0 * np.pi * total(touching) / ring.n_sectors

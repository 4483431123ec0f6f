"""Contacts of finite elements with rollers that tilt: tables of energy below the grid by approach and misalignment.

The mesh gives the approach of the patches and carries the normal force alone; rigid slopes of rollers and hub give the
misalignment ψ. A contact's table has what the mesh lacks of U(δ, ψ): `fem.contacts.tilted`. At a place where the mesh
is stiffer by the ripple r than in the mean the contact stores U(δ − r Q, ψ) + ½ r Q², of which Q is the slope by δ.
Where spalls let a part of the length sink by h, U(δ, ψ, h) stands in its place: `fem.kernels.tilted_contact`.

Tilts are bodies of their own, moved by leapfrog as all others: moments act where contacts are, none is taken ahead.

Equation (4) of docs/tilted_motion.md.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels import tilted_contact as tables
from fem.kernels.fields import room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair, logarithm, maximum, minimum
from fem.kernels.lanes import WIDTH, absolute, load, scatter_add, select, splat, square_root, store, total
from fem.kernels.law import Law, lowered_ring, lowered_rollers
from fem.kernels.tilted_contact import SpalledRest, TiltedLaw
from fem.kernels.tilts import Tilts, kick_axes, kick_hub_axis, note_furthest

FAINTEST = 1e-300  # N, of which a logarithm is a number


class PatchMoments(NamedTuple):
    """Further state of contacts to `state.Forces`, for each raceway and roller."""

    moment: state("2, columns")  # N m, of the last kick
    slope: state("2, columns", np.nan)  # rad, misalignment then
    approach: state("2, columns", np.nan)  # m, then
    energy: state("2, columns")  # J, then
    edges: state("4, 2, columns")  # as `tilts.TiltedForces` has them
    sunken: state("8, 2, columns")


class Axes(NamedTuple):
    """The axes of rollers and hub, a body of the time loop."""

    tilts: Tilts
    tilted: PatchMoments
    turning: room("columns")  # N m, of this step, on rollers outwards
    on_hub: room("2")  # N m, of this step
    n: int  # rollers


class TiltedSurfaces(NamedTuple):
    """What a raceway and the rollers that it meets have beside the sinkage of their whole length."""

    rest: SpalledRest | None  # None: spalls take no part of the length
    whole: tuple  # `RingProfile` and `RollerProfiles`, of whose edges
    part: tuple  # the same of the part of the length that spalls take, of its sinkage too; None: there is none
    frame: np.ndarray  # of the `Pair`
    moment: np.ndarray


# contacts as `tilted_contact.table_at` takes them
class Looked(NamedTuple):
    tilted: PatchMoments
    estimate: np.ndarray


# `Law`, which friction takes, and what tilt takes
SlicedLaw = NamedTuple(
    "SlicedLaw",
    [
        *Law.__annotations__.items(),
        ("sign", float),  # of the normal, as the pair's
        ("table", TiltedLaw),
        ("axes", Axes),
        ("length", float),  # m, of a roller
        ("slope", np.ndarray),  # (2,), rad, of the ring's axis
        ("on_ring", np.ndarray),  # (2,), N m, of this step, on that; of one that stands straight nobody reads it
        ("middle", np.ndarray),  # (2,), m, of the outer ring's centre, from which rollers tilt outwards
        ("back", np.ndarray),  # (2,), N s, of this step on the outer ring as a whole
        ("surfaces", TiltedSurfaces | None),  # None: perfect circles
    ],
)


@part
def press_tilted(law, rollers, forces, group, row, normal, met, dt):
    """Forces of eight contacts and what a kick gives, N, with their moments on the axes; 0 where they are not near.

    `met` : whether near, approaches, m, and the ripple, m/N. Returns beside the forces the moments by the slopes' part
    across the normal, and of forces by that of spalls, N m.
    """
    (nx, ny), (near, approach, ripple), axes, own, sign = normal, met, law.axes, law.axes.tilted, law.sign
    surfaces, columns, apart = law.surfaces, rollers.columns, 2 * rollers.columns
    tilt, bx, by = load(axes.tilts.tilt, group), law.slope[0], law.slope[1]
    x, y = load_pair(rollers.centre, group, columns)
    x, y = x - law.middle[0], y - law.middle[1]
    over = 1.0 / square_root(x * x + y * y)
    ox, oy = x * over, y * over
    facing, beside = nx * ox + ny * oy, oy * nx - ox * ny
    slope = sign * (tilt * facing - (bx * nx + by * ny))
    rest = None
    if surfaces is not None:  # keep edges under contacts, and what spalls of part of the length let sink
        rest, c, s = surfaces.rest, surfaces.frame[1], surfaces.frame[2]
        on_ring = c * nx + s * ny, c * ny - s * nx
        c, s = load(rollers.cosine, group), load(rollers.sine, group)
        on_roller = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
        ring, roller = _met(surfaces.whole, group, on_ring, on_roller)
        store(own.edges, tables.NOW * apart + row, ring[2] + roller[2])
        if surfaces.part is not None:
            ring_part, roller_part = _met(surfaces.part, group, on_ring, on_roller)
            store(own.sunken, tables.SUNK * apart + row, -ring_part[0] - roller_part[0])
            store(own.sunken, tables.PART_EDGES * apart + row, ring_part[2] + roller_part[2])
    # one step from the last force's ripple, to second order of what the force has changed: beyond round-off only in
    # steps in which a contact opens or closes, where a ripple counts for nothing
    last = load(forces.force, row)
    deep = select(near, approach - ripple * last, law.table.first_approach)
    energy, Q, M, stiff, cross, _ = tables.table_at(
        Looked(own, forces.force), (law.table, rest), row, columns, deep, slope
    )
    gained = (Q - last) / (1.0 + stiff * ripple)
    further = -(ripple * gained)
    now = last + gained
    energy += (Q + 0.5 * stiff * further) * further + 0.5 * ripple * now * now
    closed = (Q > 0.0) & (now > 0.0)
    most = now * law.length  # slices lie no further out than half of that, which tables overshoot
    M = maximum(minimum(M - cross * further, most), -most)
    Q, M, energy = select(closed, now, 0.0), select(closed, M, 0.0), select(closed, energy, 0.0)
    P = select(near, _kicked(law, own, forces, row, (approach, slope, ripple), (Q, M, energy)), 0.0)
    store(forces.kick, row, P)
    store(forces.force, row, Q)
    store(forces.bracket, row, law.B + ripple * (1.0 / law.A))
    # the plane law's approach of this force: by it springs of contacts that stick are as soft as those of the plane
    plane = law.A * Q * (law.B + ripple * (1.0 / law.A) - 0.5 * logarithm(maximum(Q, FAINTEST)))
    store(forces.approach, row, select(near, plane, np.nan))
    deepest = tables.own_approach(own.edges, row, approach, Q)
    note_furthest(axes.tilts, row // columns, select(Q > 0.0, deepest, 0.0), select(Q > 0.0, absolute(slope), 0.0))
    # forces along the slopes of surfaces, N, times their centres' distances, m; they turn rollers and ring
    along = splat(0.0)
    if surfaces is not None:
        soft, by_ring, by_roller = load(own.edges, tables.FALL * apart + row), splat(0.0), splat(0.0)
        if surfaces.part is not None:
            share = load(own.sunken, (tables.SUNK + tables.FALL) * apart + row)
            eased = load(own.sunken, (tables.PART_EDGES + tables.FALL) * apart + row)
            by_ring = eased * ring_part[3] - share * ring_part[1]
            by_roller = eased * roller_part[3] - share * roller_part[1]
        by_ring, by_roller = P * (by_ring + soft * ring[3]), P * (by_roller + soft * roller[3])
        scatter_add(rollers.turn_kick, group, -by_roller * (dt / rollers.inertia))
        surfaces.moment[0] += total(by_ring)
        along = by_ring + by_roller
    scatter_add(axes.turning, group, M * sign * facing)
    push = M * sign * tilt * beside * over * dt  # tilts turn with their rollers' angles
    scatter_add(rollers.body_impulse, group, push * oy)
    scatter_add(rollers.body_impulse, columns + group, -(push * ox))
    law.back[0] -= total(push * oy)
    law.back[1] += total(push * ox)
    law.on_ring[0] -= total(M * sign * nx)
    law.on_ring[1] -= total(M * sign * ny)
    return Q, P, M * sign * (tilt * beside - (by * nx - bx * ny)) + along


@part
def _kicked(law, own, forces, row, place, found):
    """What a kick gives of eight contacts' forces, N: `law.kick_force`, moments doing work by leapfrog."""
    (approach, slope, ripple), (Q, M, energy) = place, found
    before, Q_before, P_before = load(own.approach, row), load(forces.force, row), load(forces.kick, row)
    way, given = tables.fallen(own, row, forces.force.shape[1], Q - Q_before)
    residual, step = load(forces.residual, row), approach - before - way
    work = given + energy - load(own.energy, row) + 0.5 * (M + load(own.moment, row)) * (slope - load(own.slope, row))
    ripple_before = (load(forces.bracket, row) - law.B) * law.A
    stays = (Q > 0.0) & (Q_before > 0.0)
    work += select(stays, 0.25 * (Q * Q + Q_before * Q_before) * (ripple - ripple_before), 0.0)
    P = tables.kick_by_work(Q, Q_before, P_before, residual, approach, step, work)
    left = residual + work - 0.5 * step * (P_before + P)
    store(forces.residual, row, select(step != step, residual, left))
    store(own.approach, row, approach)
    store(own.slope, row, slope)
    store(own.energy, row, energy)
    store(own.moment, row, M)
    return P


@part
def _met(profiles, group, on_ring, on_roller):
    """What contacts meet of ring and rollers, as `lowered_ring` has it, with slopes per rad."""
    (of_ring, of_rollers), still = profiles, (splat(0.0), splat(0.0), splat(0.0), splat(0.0))
    ring = lowered_ring(of_ring, 1.0, still, on_ring[0], on_ring[1])
    return ring, lowered_rollers(of_rollers, group, still, on_roller[0], on_roller[1])


@part
def kick_axes_of(axes, drive):
    """The kick of all axes by the moments of this step, which are then cleared."""
    for group in range(0, axes.n, WIDTH):
        kick_axes(axes.tilts, drive, group, load(axes.turning, group))
        store(axes.turning, group, splat(0.0))
    kick_hub_axis(axes.tilts, drive, (axes.on_hub[0], axes.on_hub[1]))
    axes.on_hub[0] = axes.on_hub[1] = 0.0

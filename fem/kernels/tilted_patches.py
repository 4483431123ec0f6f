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

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.contact_kernels import press, turned_aside
from fem.kernels.fields import room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import logarithm, maximum, minimum
from fem.kernels.lane_memory import load, scatter_add, store
from fem.kernels.lanes import WIDTH, absolute, select, splat, square_root, total
from fem.kernels.sample_kernels import energy_below
from fem.kernels.state import Law
from fem.kernels.surfaces import lowered_ring, lowered_rollers
from fem.kernels.tilted_contact import (
    FALL,
    NOW,
    PART_EDGES,
    SUNK,
    SpalledRest,
    TiltedLaw,
    fallen,
    kick_by_work,
    own_approach,
    table_at,
)
from fem.kernels.tilts import Tilts, kick_axes, kick_hub_axis, note_furthest, turn_axes, write_axes

FAINTEST = 1e-300  # N, of which a logarithm is a number


class PatchMoments(NamedTuple):
    """Further state of contacts to `state.Forces`, for each raceway and roller."""

    moment: state("2, columns")  # N m, of the last kick
    slope: state("2, columns", np.nan)  # rad, misalignment then
    approach: state("2, columns", np.nan)  # m, then
    energy: state("2, columns")  # J, then
    edges: state("4, 2, columns")  # as `tilts.TiltedForces` has them
    sunken: state("8, 2, columns")
    across: room("2, columns")  # N m, of moments by the slopes' part across the normal, of forces by that of `sunken`


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


@press.of(SlicedLaw)
def _press(law, rollers, forces, at, normal, met, ripple, dt):
    """`contact_kernels.press` with the moments of eight contacts on the axes."""
    (group, row), (nx, ny), (near, closed) = at, normal, met
    axes, columns, sign = law.axes, rollers.columns, law.sign
    own, tilt, bx, by = axes.tilted, load(axes.tilts.tilt, group), law.slope[0], law.slope[1]
    x, y = load(rollers.centre, group) - law.middle[0], load(rollers.centre, columns + group) - law.middle[1]
    over = 1.0 / square_root(x * x + y * y)
    ox, oy = x * over, y * over
    facing, beside = nx * ox + ny * oy, oy * nx - ox * ny
    slope = sign * (tilt * facing - (bx * nx + by * ny))
    slopes = _besides(law.surfaces, own, rollers, at, normal, sign)
    Q, M, energy = _looked_up(law, forces, row, near, closed, slope, ripple)
    P = _kicked(law, own, forces, row, (closed, slope, ripple), (Q, M, energy))
    store(forces.kick, row, select(near, P, 0.0))
    store(forces.force, row, Q)
    store(forces.bracket, row, law.B + ripple * (1.0 / law.A))
    # the plane law's approach of this force: by it springs of contacts that stick are as soft as those of the plane
    plane = law.A * Q * (law.B + ripple * (1.0 / law.A) - 0.5 * logarithm(maximum(Q, FAINTEST)))
    store(forces.approach, row, select(near, plane, np.nan))
    deepest = own_approach(own.edges, row, closed, Q)
    note_furthest(axes.tilts, row // columns, select(Q > 0.0, deepest, 0.0), select(Q > 0.0, absolute(slope), 0.0))
    # Forces of eight contacts along these slopes, N, times their centres' distances, m; they turn rollers and ring.
    if law.surfaces is None:
        along = splat(0.0)
    else:
        (ring, roller), of_part = slopes
        apart = 2 * rollers.columns
        soft = load(own.edges, FALL * apart + at[1])
        on_ring, on_roller = _pushed_by_part(of_part, own.sunken, at[1], apart)
        on_ring, on_roller = P * (on_ring + soft * ring[3]), P * (on_roller + soft * roller[3])
        scatter_add(rollers.turn_kick, at[0], -on_roller * (dt / rollers.inertia))
        law.surfaces.moment[0] += total(on_ring)
        along = on_ring + on_roller
    store(own.across, row, M * sign * (tilt * beside - (by * nx - bx * ny)) + along)
    scatter_add(axes.turning, group, M * sign * facing)
    aside = M * sign * tilt * beside * over * dt  # tilts turn with their rollers' angles
    scatter_add(rollers.body_impulse, group, aside * oy)
    scatter_add(rollers.body_impulse, columns + group, -(aside * ox))
    law.back[0] -= total(aside * oy)
    law.back[1] += total(aside * ox)
    law.on_ring[0] -= total(M * sign * nx)
    law.on_ring[1] -= total(M * sign * ny)
    return Q, P


@part
def _looked_up(law, forces, row, near, closed, slope, ripple):
    """Forces, N, moments, N m, and energies, J, of eight contacts; 0 of those that are open.

    One step from the last force's ripple, to second order of what the force has changed: beyond round-off only in steps
    in which a contact opens or closes, where a ripple counts for nothing.
    """
    last = load(forces.force, row)
    deep = select(near, closed - ripple * last, law.table.first_approach)
    looked, laws = Looked(law.axes.tilted, forces.force), (law.table, _rest(law.surfaces))
    energy, Q, M, stiff, cross, _ = table_at(looked, laws, row, forces.force.shape[1], deep, slope)
    gained = (Q - last) / (1.0 + stiff * ripple)
    further = -(ripple * gained)
    now = last + gained
    energy += (Q + 0.5 * stiff * further) * further + 0.5 * ripple * now * now
    is_closed = (Q > 0.0) & (now > 0.0)
    most = now * law.length  # slices lie no further out than half of that, which tables overshoot
    M = maximum(minimum(M - cross * further, most), -most)
    return select(is_closed, now, 0.0), select(is_closed, M, 0.0), select(is_closed, energy, 0.0)


@part
def _kicked(law, own, forces, row, place, met):
    """What a kick gives of eight contacts' forces, N: `law.kick_force`, moments doing work by leapfrog."""
    (closed, slope, ripple), (Q, M, energy) = place, met
    before, Q_before, P_before = load(own.approach, row), load(forces.force, row), load(forces.kick, row)
    way, given = fallen(own, row, forces.force.shape[1], Q - Q_before)
    residual, step = load(forces.residual, row), closed - before - way
    work = given + energy - load(own.energy, row) + 0.5 * (M + load(own.moment, row)) * (slope - load(own.slope, row))
    ripple_before = (load(forces.bracket, row) - law.B) * law.A
    stays = (Q > 0.0) & (Q_before > 0.0)
    work += select(stays, 0.25 * (Q * Q + Q_before * Q_before) * (ripple - ripple_before), 0.0)
    P = kick_by_work(Q, Q_before, P_before, residual, closed, step, work)
    left = residual + work - 0.5 * step * (P_before + P)
    store(forces.residual, row, select(step != step, residual, left))
    store(own.approach, row, closed)
    store(own.slope, row, slope)
    store(own.energy, row, energy)
    store(own.moment, row, M)
    return P


@part
def _rest(surfaces):
    return None if surfaces is None else surfaces.rest


@part
def _besides(surfaces, own, rollers, at, normal, sign):
    """Keep edges under eight contacts, and what spalls of part of the length let sink; slopes per rad of all of these.

    They are of ring and rollers, each of the whole length and of the part, as `lowered_ring` has them.
    """
    if surfaces is None:
        return None
    (group, row), (nx, ny), apart = at, normal, 2 * rollers.columns
    c, s = surfaces.frame[1], surfaces.frame[2]
    on_ring = c * nx + s * ny, c * ny - s * nx
    c, s = load(rollers.cosine, group), load(rollers.sine, group)
    on_roller = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
    ring, roller = _met(surfaces.whole, group, on_ring, on_roller)
    store(own.edges, NOW * apart + row, ring[2] + roller[2])
    return (ring, roller), _met_by_part(surfaces.part, own.sunken, group, row, apart, on_ring, on_roller)


@part
def _met(profiles, group, on_ring, on_roller):
    (of_ring, of_rollers), still = profiles, (splat(0.0), splat(0.0), splat(0.0), splat(0.0))
    ring = lowered_ring(of_ring, 1.0, still, on_ring[0], on_ring[1])
    return ring, lowered_rollers(of_rollers, group, still, on_roller[0], on_roller[1])


@part
def _met_by_part(profiles, sunken, group, row, apart, on_ring, on_roller):
    if profiles is None:
        return None
    ring, roller = _met(profiles, group, on_ring, on_roller)
    store(sunken, SUNK * apart + row, -ring[0] - roller[0])
    store(sunken, PART_EDGES * apart + row, ring[2] + roller[2])
    return ring, roller


@part
def _pushed_by_part(slopes, sunken, row, apart):
    if slopes is None:
        return splat(0.0), splat(0.0)
    share, soft = load(sunken, (SUNK + FALL) * apart + row), load(sunken, (PART_EDGES + FALL) * apart + row)
    ring, roller = slopes
    return soft * ring[3] - share * ring[1], soft * roller[3] - share * roller[1]


@turned_aside.of(SlicedLaw)
def _turned_aside(law, row, aside):
    return aside - load(law.axes.tilted.across, row)


@energy_below.of(SlicedLaw)
def _energy_below(law, forces, row, j):
    return law.axes.tilted.energy[row, j]


@kick_body.of(Axes)
def _kick_axes(axes, drive):
    for group in range(0, axes.n, WIDTH):
        kick_axes(axes.tilts, drive, group, load(axes.turning, group))
        store(axes.turning, group, splat(0.0))
    kick_hub_axis(axes.tilts, drive, (axes.on_hub[0], axes.on_hub[1]))
    axes.on_hub[0] = axes.on_hub[1] = 0.0


@drift_body.of(Axes)
def _drift_axes(axes, drive):
    turn_axes(axes.tilts, drive)


@add_motion.of(Axes)
def _add_motion(axes, drive, out, kinetic):
    write_axes(axes.tilts, axes, axes, drive, out)

"""Surfaces that are not perfect circles under rollers that tilt: edges of spalls, spalls of part of the length.

Edges are compliances in series with a contact, or with either part of one whose length spalls take a part of:
equation (5) of docs/tilted_motion.md and `lagrange.axial.table.SpalledTable`.
"""

from typing import NamedTuple

from fem.kernels.drive import outer_of
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import absolute, any_lane, select, splat
from fem.kernels.reduced_contacts import met_surfaces, store_pair
from fem.kernels.tilted_contact import SHORTEST, force_and_stiffness
from lagrange.axial.table import FAINT

MOST_STEPS, SETTLED = 60, 1e-6  # of Newton's method, and of what edges take: what is left is of its square, and taken
# of `TiltedForces.edges` and `.sunken`: what changes under a contact, and by how much its energy falls by that, over
# its force; now, and at the last kick
NOW, FALL, BEFORE, FALL_BEFORE = range(4)
SUNK, PART_EDGES = 0, 4  # of `sunken`: the part's sinkage, m, and compliance of edges, m/N, beside the whole length's


class PartProfiles(NamedTuple):
    """What the part of the length that spalls take meets besides: see `Compliance`."""

    ring_profiles: tuple
    roller_profiles: tuple


class SpalledRest(NamedTuple):
    """A contact without the part of its length that spalls take; without such a part the whole contact."""

    law: tuple  # `TiltedLaw`
    of_rest: float  # the length over that of the rest
    of_part: float  # and over that of the part; 0: there is none


@part
def surfaces_met(slope, bodies, compliance, forces, drive, group, turn):
    """`met_surfaces` of the whole length and of spalls' part, where contacts are on surfaces that are not perfect."""
    if slope is None:
        return _met(slope, bodies, compliance, forces, group, turn, None)
    if drive.looks:
        return _met(slope, bodies, compliance, forces, group, turn, outer_of(drive.history))
    return _met(None, bodies, compliance, forces, group, turn, None)


@part
def _met(slope, bodies, compliance, forces, group, turn, outer):
    whole = met_surfaces(slope, bodies, compliance, forces, group, turn, outer)
    return whole, _met_by_part(compliance.part, slope, bodies, forces, group, turn, outer)


@part
def _met_by_part(profiles, slope, bodies, forces, group, turn, outer):
    if profiles is None:
        return None
    return met_surfaces(slope, bodies, profiles, forces, group, turn, outer)


@part
def sunk(slope, forces, columns, group, met, inner, outer):
    """Approaches of eight rollers, m, less what their contacts sink; what else surfaces do to contacts is kept."""
    if slope is None:
        return inner, outer
    ring, own, ring_o, own_o = met[0]
    store_pair(forces.tilted.edges, NOW * 2 * columns + group, columns, ring[2] + own[2], ring_o[2] + own_o[2])
    _keep_part(forces.tilted.sunken, columns, group, met[1])
    return inner + ring[0] + own[0], outer + ring_o[0] + own_o[0]


@part
def _keep_part(sunken, columns, group, met):
    if sunken is not None:
        ring, own, ring_o, own_o = met
        store_pair(sunken, SUNK * 2 * columns + group, columns, -ring[0] - own[0], -ring_o[0] - own_o[0])
        store_pair(sunken, PART_EDGES * 2 * columns + group, columns, ring[2] + own[2], ring_o[2] + own_o[2])


@part
def keep_slopes(slope, forces, columns, group, met):
    """Slopes of approaches along surfaces, with those of all by which the contacts' energies fall over their forces."""
    if slope is not None:
        ring, own, ring_o, own_o = met[0]
        soft_i, soft_o = _falls(forces.tilted.edges, FALL, columns, group)
        turning, turning_o = own[1] - soft_i * own[3], own_o[1] - soft_o * own_o[3]
        both, both_o = ring[1] - soft_i * ring[3] + turning, ring_o[1] - soft_o * ring_o[3] + turning_o
        more, more_o, more_both, more_both_o = _slopes_of_part(forces.tilted.sunken, columns, group, met[1])
        store_pair(slope, group, columns, both + more_both, turning + more)
        store_pair(slope, 2 * columns + group, columns, both_o + more_both_o, turning_o + more_o)


@part
def _falls(array, row, columns, group):
    at = row * 2 * columns + group
    return load(array, at), load(array, at + columns)


@part
def _slopes_of_part(sunken, columns, group, met):
    """The same of spalls' part: of rollers, inner and outer, and of both bodies."""
    if sunken is None:
        return splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    ring, own, ring_o, own_o = met
    share_i, share_o = _falls(sunken, SUNK + FALL, columns, group)
    soft_i, soft_o = _falls(sunken, PART_EDGES + FALL, columns, group)
    turning, turning_o = share_i * own[1] - soft_i * own[3], share_o * own_o[1] - soft_o * own_o[3]
    both, both_o = share_i * ring[1] - soft_i * ring[3], share_o * ring_o[1] - soft_o * ring_o[3]
    return turning, turning_o, both + turning, both_o + turning_o


@part
def table_at(forces, laws, at, columns, deep, slope):
    """`force_and_stiffness` of eight contacts at edges of spalls and with part of their length over spalls."""
    table, rest = laws
    if forces.tilted.edges is None:
        return force_and_stiffness(table, deep, slope)
    return _over_spalls(rest, table, forces, at, columns, deep, slope)


@part
def _over_spalls(rest, table, forces, at, columns, deep, slope):
    if rest is None:
        found = in_series(None, table, deep, slope, load(forces.tilted.edges, at), load(forces.estimate, at))
        store(forces.tilted.edges, FALL * 2 * columns + at, 0.5 * found[1])
        return found
    return _in_pieces(forces.tilted.sunken, rest, table, forces, at, columns, deep, slope)


@part
def _in_pieces(sunken, rest, table, forces, at, columns, deep, slope):
    if sunken is None:
        return force_and_stiffness(table, deep, slope)
    apart, edges = 2 * columns, forces.tilted.edges
    h, soft, more = load(sunken, SUNK * apart + at), load(edges, at), load(sunken, PART_EDGES * apart + at)
    share, last = load(sunken, (SUNK + FALL) * apart + at), load(forces.estimate, at)
    if not any_lane((absolute(h) > 0.0) | (absolute(soft) > FAINT) | (absolute(more) > FAINT)):
        store(edges, FALL * apart + at, splat(0.0))
        store(sunken, (SUNK + FALL) * apart + at, splat(0.0))
        store(sunken, (PART_EDGES + FALL) * apart + at, splat(0.0))
        return force_and_stiffness(table, deep, slope)
    a = in_series(None, rest.law, deep, slope, rest.of_rest * soft, (1.0 - share) * last)
    b = in_series(rest.law, table, deep - h, slope, rest.of_part * (soft + more), share * last)
    Q = a[1] + b[1]
    over = select(Q > 0.0, 1.0 / select(Q > 0.0, Q, 1.0), 0.0)
    soft_part = 0.5 * rest.of_part * b[1] * b[1] * over
    store(edges, FALL * apart + at, 0.5 * rest.of_rest * a[1] * a[1] * over + soft_part)
    store(sunken, (SUNK + FALL) * apart + at, b[1] * over)
    store(sunken, (PART_EDGES + FALL) * apart + at, soft_part)
    return a[0] + b[0], Q, a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@part
def in_series(rest, table, deep, slope, soft, last):
    """Eight contacts, less those of a rest, with compliances in series, m/N; `last` : N, forces of the last step."""
    if not any_lane(absolute(soft) > FAINT):
        return _less(rest, table, deep, slope)
    return _softer(rest, table, deep, slope, soft, last)


@part(inlined=False)
def _softer(rest, table, deep, slope, soft, last):
    """U(δ', ψ) + ½ s Q² and its derivatives; δ' + s Q(δ', ψ) = δ by Newton's method, whose last step is linear."""
    own = deep - soft * last
    energy, Q, M, stiff, cross, tilting = _less(rest, table, own, slope)
    for _ in range(MOST_STEPS):
        step = (deep - own - soft * Q) / (1.0 + soft * stiff)
        if not any_lane(absolute(step) > SETTLED * absolute(soft * Q) + SHORTEST):
            break
        own = own + step
        energy, Q, M, stiff, cross, tilting = _less(rest, table, own, slope)
    energy, Q, M = energy + Q * step, Q + stiff * step, M - cross * step
    give = 1.0 / (1.0 + soft * stiff)
    tilting = tilting - soft * cross * cross * give
    return energy + 0.5 * soft * Q * Q, Q, M, stiff * give, cross * give, tilting


@part
def _less(rest, table, deep, slope):
    if rest is None:
        return force_and_stiffness(table, deep, slope)
    a, b = force_and_stiffness(table, deep, slope), force_and_stiffness(rest, deep, slope)
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]


@part
def fallen(tilted, at, columns, gained):
    """What spalls that came under eight contacts since the last kick took of their forces' ways, m, and of work, J.

    A kick works along surfaces by its force times the fall of then: the mean of both ends' products, not the product
    of means.

    Parameters
    ----------
    tilted : `TiltedForces`; gained : N, of forces since the last kick
    """
    way, work = _fallen(tilted.edges, 0, at, columns, gained)
    more, besides = _fallen_part(tilted.sunken, at, columns, gained)
    return way + more, work + besides


@part
def _fallen_part(sunken, at, columns, gained):
    if sunken is None:
        return splat(0.0), splat(0.0)
    way, work = _fallen(sunken, SUNK, at, columns, gained)
    more, besides = _fallen(sunken, PART_EDGES, at, columns, gained)
    return way + more, work + besides


@part
def _fallen(array, first, at, columns, gained):
    if array is None:
        return splat(0.0), splat(0.0)
    apart = 2 * columns
    now, before = (first + NOW) * apart + at, (first + BEFORE) * apart + at
    fall, last = load(array, now + apart), load(array, before + apart)
    passed = load(array, now) - load(array, before)
    store(array, before, load(array, now))
    store(array, before + apart, fall)
    return 0.5 * (fall + last) * passed, 0.25 * gained * (fall - last) * passed


@part
def own_approach(edges, at, approach, Q):
    """Approaches of eight contacts, m, less what edges take of them."""
    if edges is None:
        return approach
    return approach - load(edges, at) * Q

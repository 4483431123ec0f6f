"""Surfaces that are not perfect circles under rollers that tilt, and contacts over spalls of part of their length.

Equation (5) of docs/tilted_motion.md.
"""

from fem.kernels.drive import outer_of
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import any_lane, select, splat
from fem.kernels.reduced_contacts import met_surfaces, store_pair
from fem.kernels.tilted_contact import force_and_stiffness

SUNK, SHARE, BEFORE = 0, 1, 2  # of `TiltedForces.sunken`; on from BEFORE at the last kick


@part
def surfaces_met(slope, bodies, compliance, forces, drive, group, turn):
    """`met_surfaces`, where any contact is on surfaces that are not perfect circles; compliances are `sunken` parts."""
    if slope is None:
        return met_surfaces(slope, bodies, compliance, forces, group, turn, None)
    if drive.looks:
        return met_surfaces(slope, bodies, compliance, forces, group, turn, outer_of(drive.history))
    return met_surfaces(None, bodies, compliance, forces, group, turn, None)


@part
def sunk(slope, forces, columns, group, met, inner, outer):
    """Approaches of eight rollers, m, less what their contacts sink; what a part of the length sinks more is kept."""
    if slope is None:
        return inner, outer
    ring, own, ring_o, own_o = met
    _keep_sunk(forces.tilted.sunken, columns, group, ring[2] + own[2], ring_o[2] + own_o[2])
    return inner + ring[0] + own[0], outer + ring_o[0] + own_o[0]


@part
def _keep_sunk(sunken, columns, group, inner, outer):
    if sunken is not None:
        store_pair(sunken, SUNK * 2 * columns + group, columns, inner, outer)


@part
def keep_slopes(slope, forces, columns, group, met):
    """Slopes of approaches along surfaces, with those of a part of the length by its share of the force."""
    if slope is not None:
        ring, own, ring_o, own_o = met
        share_i, share_o = _shares(forces.tilted.sunken, columns, group)
        turning, turning_o = own[1] - share_i * own[3], own_o[1] - share_o * own_o[3]
        store_pair(slope, group, columns, ring[1] - share_i * ring[3] + turning, turning)
        store_pair(slope, 2 * columns + group, columns, ring_o[1] - share_o * ring_o[3] + turning_o, turning_o)


@part
def _shares(sunken, columns, group):
    if sunken is None:
        return splat(0.0), splat(0.0)
    at = SHARE * 2 * columns + group
    return load(sunken, at), load(sunken, at + columns)


@part
def table_at(sunken, laws, at, columns, deep, slope):
    """`force_and_stiffness` of eight contacts, part of whose length may lie over spalls: see `SpalledTable`."""
    table, rest = laws
    if sunken is None:
        return force_and_stiffness(table, deep, slope)
    return _spalled(rest, table, sunken, at, columns, deep, slope)


@part
def _spalled(rest, table, sunken, at, columns, deep, slope):
    if rest is None:
        return force_and_stiffness(table, deep, slope)
    h = load(sunken, SUNK * 2 * columns + at)
    energy, Q, M, stiff, cross, tilting = force_and_stiffness(table, deep - h, slope)
    share = splat(0.0)
    if any_lane(h != 0.0):
        a, b = force_and_stiffness(rest, deep, slope), force_and_stiffness(rest, deep - h, slope)
        part = Q - b[1]
        energy, Q, M = energy + (a[0] - b[0]), Q + (a[1] - b[1]), M + (a[2] - b[2])
        stiff, cross, tilting = stiff + (a[3] - b[3]), cross + (a[4] - b[4]), tilting + (a[5] - b[5])
        share = select((h != 0.0) & (Q > 0.0), part / select(Q > 0.0, Q, 1.0), 0.0)
    store(sunken, SHARE * 2 * columns + at, share)
    return energy, Q, M, stiff, cross, tilting


@part
def part_sunk(sunken, at, columns):
    """By how much less than its approach a contact's force has worked since the last kick, m, as a part has sunk."""
    if sunken is None:
        return splat(0.0)
    now, last = at, BEFORE * 2 * columns + at
    h, share = load(sunken, now), load(sunken, now + 2 * columns)
    sunk = 0.5 * (share + load(sunken, last + 2 * columns)) * (h - load(sunken, last))
    store(sunken, last, h)
    store(sunken, last + 2 * columns, share)
    return sunk

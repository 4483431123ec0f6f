"""The load zone: passages through it, equilibria of the Lagrangian model beside it, pressures along rollers in it."""

from dataclasses import replace
from math import pi
from typing import NamedTuple

import numpy as np

from lagrange import contact_laws, static_equilibrium
from lagrange.axial.pressure import borne, pressures_under, profile_ends
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import law_names
from lagrange.kinematics import kinematics, roller_angles
from residual.record import Record, angle_from_load

CHATTER = 0.05  # of a cage revolution
PHASES = 24  # of one roller pitch; where rollers are missing, of each pitch of a turn
FAINT = 0.01  # of the largest force: contacts taken as open
INSIDE = 0.99  # of the largest moment that a force has: beyond, a roller stands on an end
BINS, ROLLERS = 120, 3  # of angles; shown from their side


def load_zones(loaded: np.ndarray, bridge: int) -> list[tuple[int, int]]:
    """Find the first and last sample of each pass through the load zone; gaps up to `bridge` are chatter."""
    at = np.flatnonzero(loaded)
    if at.size == 0:
        return []
    ends = np.flatnonzero(np.diff(at) > bridge + 1)
    return list(zip(at[[0, *(ends + 1)]].tolist(), at[[*ends, -1]].tolist(), strict=True))


def chatter_gap(record: Record) -> int:
    """Longest opening within one pass through the load zone, samples: 5 % of a cage revolution."""
    cage = np.mean(np.abs(kinematics(record.bearing, *record.acting.ring_speeds).cage)) / (2.0 * pi)
    samples = record.time.size // 50
    return max(1, samples if samples * record.interval * cage <= CHATTER else int(CHATTER / cage / record.interval))


def chosen_roller(loaded: np.ndarray, bridge: int) -> int:
    """The roller that passes through the load zone most often, whole passes first."""

    def merit(j):
        zones = load_zones(loaded[:, j], bridge)
        whole = sum(first > 0 and last < loaded.shape[0] - 1 for first, last in zones)
        return len(zones), whole, loaded[:, j].sum()

    return max(range(loaded.shape[1]), key=merit)


class QuasiStatic(NamedTuple):
    """Equilibria of rigid rings with rollers at cage speed, over one period of the bearing."""

    law: str
    x: np.ndarray  # (phases + 1,), m, of the hub; the last closes the loop
    y: np.ndarray
    angle: np.ndarray  # (n,), rad from the load line, counter-clockwise, −π … π, rising
    force: np.ndarray  # (n,), N, of the inner contact


def quasi_static(record: Record, law: str) -> QuasiStatic | None:
    """Equilibria with a named law, for a fitted law with the usual one; None where there is none, or loads change."""
    bearing, operation, known = record.bearing, record.operation, law_names(record.bearing)
    if not operation.is_steady:
        return None
    name = law if law in known else known[0]
    laws, found, start = contact_laws(name, bearing), [], None
    phases = PHASES * round(bearing.period * bearing.pockets / (2.0 * pi))
    ring = tuple(np.mean(record.hub - record.inner, axis=1))
    for phase in np.arange(phases + 1) / phases * bearing.period:
        angles = roller_angles(bearing, operation.first_roller_angle) + phase
        try:
            found.append(static_equilibrium(bearing, operation, laws, angles=angles, start=start, ring=ring))
        except RuntimeError:
            return None
        start = found[-1].x, found[-1].y
    away = np.concatenate([angle_from_load(each.theta) for each in found])
    force, order = np.concatenate([each.inner_force for each in found]), np.argsort(away)
    x, y = np.array([(each.x, each.y) for each in found]).T
    return QuasiStatic(name, x, y, away[order], force[order])


class AlongRollers(NamedTuple):
    """Pressures along rollers of a run; of contacts (2, n, n_slices), Pa, inner and outer raceway."""

    place: np.ndarray  # (n_slices,), m, along the axis from the middle
    angle: np.ndarray  # (BINS,), rad from the load's direction
    around: np.ndarray  # at these angles the contact with the largest force; 0 of open ones
    time: float  # s, of the largest moment of an inner contact
    rollers: np.ndarray  # (n,), the most loaded ones at that instant, of which there is
    along: np.ndarray
    edges: bool  # whether a loaded end has an edge, where pressure has no limit


def along_rollers(record: Record) -> AlongRollers | None:
    """None where the source does not hold what pressures follow from, or other forces than those of its slices."""
    axial, slices, bearing = record.scene.ideal_axial(), record.slices, record.scene.perfect_bearing()
    forces, moments = (record.inner_force, record.outer_force), (record.inner_moment, record.outer_moment)
    if axial is None or slices is None or any(each is None for each in (*forces, *moments)):
        return None
    force, moment = np.asarray(forces[0]), np.asarray(moments[0])
    sample = np.unravel_index(np.abs(moment).argmax(), force.shape)[0]
    rollers = np.sort(np.argsort(force[sample])[-ROLLERS:])
    bins = np.floor((record.from_load / (2.0 * pi) + 0.5) * BINS).astype(int).ravel() % BINS
    around, along, edges = np.zeros((2, BINS, slices[0].count)), [], False
    of_sides = zip(
        slices, contact_pairs(bearing), profile_ends(bearing, axial), forces, moments, axial.parts(record.bearing),
        record.contacts.surfaces, strict=False)  # fmt: skip
    for found, (own, pair, ends, pushes, tilts, part, surface) in zip(around, of_sides, strict=True):
        own, pushed, tilted = replace(own, part=part), np.ravel(pushes), np.ravel(tilts)
        sunk = np.broadcast_to(0.0 if surface is None else surface.part_sinkage, np.shape(pushes)).ravel()
        order, largest = np.argsort(pushed), np.full(BINS, -1)
        largest[bins[order]] = order  # the last one of each bin
        shown, closed = largest >= 0, pushed > FAINT * pushed.max()
        closed &= np.abs(tilted) < INSIDE * own.place[-1] * pushed
        try:
            found[shown], rows = (
                pressures_under(own, pair, pushed[at], tilted[at], sunk[at], closed[at])[0]
                for at in (largest[shown], sample * force.shape[1] + rollers)
            )
        except (RuntimeError, ValueError):
            return None
        along.append(rows)
        edges |= ends.are_loaded(own, borne(pair, found)).any()
    angle = 2.0 * pi * ((np.arange(BINS) + 0.5) / BINS - 0.5)
    return AlongRollers(slices[0].place, angle, around, float(record.time[sample]), rollers, np.array(along), edges)

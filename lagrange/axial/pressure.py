"""Hertz pressures along a tilted roller, by the forces of its slices."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.axial.slices import Axial, Slices
from lagrange.bearing import Bearing
from lagrange.contact.hertz import Pair, contact_pairs

SHARP = "a loaded end of a roller or a bend of a measured profile is an edge, where pressure has no limit"
KNEE = 2.5  # cosh⁻¹(a/x) at a sixth of the contact's half-width from it
STEPS, HALVINGS = 100, 30  # of Newton's method
SETTLED = 1e-6  # of a force: it comes from a table
UNEVEN = 1.15  # times an even load, that last slices bear beside it at most: 1.05 to 1.11 under the load itself
FADING = 0.5  # of the largest approach along a roller
AT_END = 1.0 - 1e-6  # of the last slice's place: the slice before it still bears
LOOSE = 1e-9  # of a contact's stiffness, against slopes that a single slice does not hold
FAINTEST = 1e-6  # N, of a slice at a roller's end
SLOPES, DEPTHS = 64, 64  # of which a table of peaks is made: slopes either way, and approaches at each
FORCES, PLACES = 128, 512  # steps of the table, of √Q and of M/Q


def pressures(slices: Slices, pair: Pair, approach, slope, sunk=0.0) -> ndarray:
    """Largest pressure of each slice, (..., n), Pa, by approach, m, and slope, rad, of contacts, (...,).

    Each slice has Hertz's pressure across: p0 = √(q E*/(π R)), q its force by its width; `sunk` : m, of the part of the
    length that spalls take. Errors: with coupled slices 0.7 % of peaks on profiled rollers; alone 3 to 9 %; at an edge
    there is no limit: `Ends`. RuntimeError: as `Slices.forces`.
    """
    return _hertz(pair, slices.count * slices.forces(approach, slope, sunk))


def _hertz(pair, force):
    """p0, Pa, under forces on the whole length, N."""
    return np.sqrt(force / (np.pi * pair.relative_radius * pair.length) * pair.modulus)


def pressures_under(slices: Slices, pair: Pair, force, moment, sunk, closed) -> tuple[ndarray, ndarray]:
    """Pressures on the slices of contacts that bear forces, N, and moments, N m, (..., n), Pa, and their slopes, rad.

    force, moment, sunk : (...,), `sunk` as of `pressures`; closed : (...,), which contacts are meant; others get 0.
    ValueError: as `placed`. RuntimeError: as `Slices.forces`.
    """
    found, slope = np.zeros((*np.shape(force), slices.count)), np.zeros(np.shape(force))
    moment = exerted(slices, force, moment)
    approach, slope[closed] = placed(slices, force[closed], moment[closed], sunk[closed])
    found[closed] = pressures(slices, pair, approach, slope[closed], sunk[closed])
    return found, slope


class Ends(NamedTuple):
    """What a contact's profiles do at a roller's ends, where pressure has no limit if an edge is loaded.

    A drop a ln[1/(1 − s²)] bears a line load π E* a/2 up to the very end, which is Lundberg's even one, and no more.
    """

    drop: ndarray  # (2,), m, of roller and raceway at −L/2 and L/2; infinite where it is such a logarithm
    even: float  # N, that load times the roller's length
    pair: Pair | None = None  # of a contact with `knees`
    knees: ndarray = np.zeros((2, 0))  # places, m, and by how much measured profiles bend there, rad

    def are_loaded(self, slices: Slices, whole: ndarray) -> ndarray:
        """Whether an edge is, (...,), by slices' forces times their number, (..., n), N.

        A contact that ends before a finite drop does must fade in its last slice, or slices do not see how it ends.
        A knee that bends by Δ adds E* Δ/π cosh⁻¹(a/x) at a distance x (Johnson, Contact Mechanics, 1985, (5.7)): it is
        an edge where KNEE of that makes more than slices know of the contact.
        """
        last = whole[..., [0, -1]]
        if np.isinf(self.drop).any():
            found = last.max(axis=-1) > UNEVEN * self.even
        else:
            own = np.where(whole > 0.0, slices.law.approach(np.maximum(whole, FAINTEST)), 0.0)
            (outer, inner), drop = (own[..., ends] for ends in ([0, -1], [1, -2])), slices.drop
            beyond = outer + 0.5 * (outer + drop[[0, -1]] - inner - drop[[1, -2]]) + drop[[0, -1]] - self.drop
            fading = outer <= FADING * own.max(axis=-1, keepdims=True)
            found = ((last > FAINTEST) & ~(fading & (beyond <= 0.0))).any(axis=-1)
        if self.pair is None or not self.knees.size:
            return found
        at = np.abs(slices.place[:, None] - self.knees[0]).argmin(axis=0)
        pressure, more = _hertz(self.pair, whole), KNEE * self.pair.modulus / np.pi * self.knees[1]
        here = np.where(pressure[..., at] > 0.0, pressure[..., at] + more, 0.0)
        return found | (here.max(axis=-1) > UNEVEN * pressure.max(axis=-1))


def profile_ends(bearing: Bearing, axial: Axial) -> tuple[Ends, Ends]:
    """Of the inner and the outer contact."""
    end, own, found = np.array([-0.5, 0.5]) * bearing.roller_length, axial.roller, []
    for ring, pair in zip((axial.inner_raceway, axial.outer_raceway), contact_pairs(bearing)[:2], strict=True):
        drop, even = own.drop(end, bearing) + ring.drop(end, bearing), own.even_load(bearing) + ring.even_load(bearing)
        found.append(Ends(drop, even, pair, np.concatenate([own.knees, ring.knees], axis=1)))
    return found[0], found[1]


def borne(pair: Pair, pressure: ndarray) -> ndarray:
    """Forces of slices times their number, N, by their pressures, Pa."""
    return np.pi * pair.relative_radius * pair.length * pressure**2 / pair.modulus


class PeakTable(NamedTuple):
    """Largest pressure of a contact by its force and moment, at equal steps of √Q and of M/Q."""

    root: float  # √N, of the largest force
    arm: float  # m, of the last slice: the largest M/Q
    peaks: ndarray  # (forces, places), Pa; NaN where an edge is loaded

    def at(self, force, moment) -> ndarray:
        """Pa, by forces, N, and moments, N m, of one shape; 0 of open contacts, NaN where an edge is loaded."""
        from scipy.ndimage import map_coordinates

        force, closed = np.asarray(force, dtype=float), np.asarray(force) > 0.0
        place = np.where(closed, moment, 0.0) / (np.where(closed, force, 1.0) * self.arm)
        share = np.array([np.sqrt(np.maximum(force, 0.0)) / self.root, 0.5 + 0.5 * place])
        at = (np.clip(share, 0.0, 1.0).T * np.subtract(self.peaks.shape, 1)).T
        return np.where(closed, map_coordinates(self.peaks, at, order=1, mode="nearest"), 0.0)


def peak_table(slices: Slices, pair: Pair, end: Ends, largest_force: float, steepest: float) -> PeakTable:
    """The table up to a force, N, and up to the M/Q that a slope, rad, either way makes; `end` : of its profiles.

    Errors: 0.05 % rms of the largest peak beside `pressures`, 1 % at worst. RuntimeError: as `Slices.forces`.
    """
    turn = np.linspace(-1.0, 1.0, 2 * SLOPES + 1)
    slope = steepest * turn * np.abs(turn)  # narrower about 0, where small forces have their moments
    opening, deepest = slices.opening(slope), slices.approach_under(largest_force, slope)
    depth = np.linspace(0.0, 1.0, DEPTHS + 1)[1:] ** 2
    at = opening[:, None] + (deepest - opening)[:, None] * depth, np.broadcast_to(slope[:, None], (slope.size, DEPTHS))
    forces, arm = slices.forces(*at), float(slices.place[-1])
    whole, peak = forces.sum(axis=-1), _hertz(pair, slices.count * forces.max(axis=-1))
    peak = np.where(end.are_loaded(slices, slices.count * forces), np.nan, peak)
    place = forces @ slices.place / (arm * np.maximum(whole, FAINTEST))
    root, places, found = sqrt(largest_force), np.linspace(-1.0, 1.0, PLACES + 1), np.zeros((FORCES + 1, PLACES + 1))
    for i, level in enumerate(np.linspace(0.0, root, FORCES + 1)[1:], start=1):
        columns = zip(np.sqrt(whole), place, peak, strict=True)
        there = [(np.interp(level, x, a), np.interp(level, x, b)) for x, a, b in columns]
        found[i] = np.interp(places, *np.array(there)[::-1].T)  # the steeper, the nearer to the end −z
    return PeakTable(root=root, arm=arm, peaks=found)


def exerted(slices: Slices, force, moment):
    """Moments, N m, at most those of forces, N, at a roller's end, which a table exceeds under light ones."""
    most = AT_END * float(slices.place[-1]) * np.asarray(force)
    return np.clip(moment, -most, most)


def placed(slices: Slices, force, moment, sunk=0.0) -> tuple[ndarray, ndarray]:
    """Approaches, m, and slopes, rad, of contacts that bear forces, N, > 0, and moments, N m, of one shape.

    `sunk` : as of `pressures`. ValueError: a moment is more than the force at a roller's end, or nothing is found.
    """
    force, moment, arm = np.asarray(force, dtype=float), np.asarray(moment, dtype=float), float(slices.place[-1])
    beyond = np.abs(moment) >= arm * force
    if beyond.any():
        at = np.unravel_index(beyond.argmax(), beyond.shape)
        raise ValueError(f"a moment of {moment[at]:.4g} N m is beyond what {force[at]:.4g} N within {arm:.4g} m exert")
    place = np.stack([slices.law.approach(force) + slices.drop.mean(), np.zeros(force.shape)], axis=-1)
    weight = np.array([1.0, 1.0 / arm])

    def left(place):
        found = slices.at(place[..., 0], place[..., 1], sunk)
        missing = np.stack([force - found.force, found.moment - moment], axis=-1)
        return found, missing, np.abs(missing * weight).max(axis=-1)

    found, missing, size = left(place)
    for _ in range(STEPS):
        wanted = size > SETTLED * force
        if not wanted.any():
            return place[..., 0], place[..., 1]
        matrix = np.stack([found.stiffness, found.cross, found.cross, found.tilt_stiffness], axis=-1)
        loose = LOOSE * found.stiffness[..., None, None] * np.diag([1.0, arm**2])
        step = np.linalg.solve(matrix.reshape(*force.shape, 2, 2) + loose, missing[..., None])[..., 0]
        step = np.where(wanted[..., None], step, 0.0)
        for _ in range(HALVINGS):
            near = left(place + step)
            if not np.any(further := wanted & (near[2] >= size)):
                break
            step = np.where(further[..., None], 0.5 * step, step)
        place, (found, missing, size) = place + step, near
    raise ValueError(f"no places of rollers are found at which their slices bear {force} N and {moment} N m")

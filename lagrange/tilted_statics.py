"""Static equilibrium of hub and rollers that tilt, at given angles: Newton's method.

Unknowns are the hub's place and, where it is free, its slope, the rollers' radii and tilts, and each contact's own
approach and misalignment: where bodies are elastic these are less than the bodies' by what the forces and moments of
other contacts take. Contacts are smooth tables, so no contact has to be found open or closed.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.equations import PolarOverlaps, polar_overlaps
from lagrange.kinematics import kinematics
from lagrange.tilt import HubTilt, TiltedLaws, Tilts, misalignments, precession_stiffness

MOST_STEPS, MOST_HALVINGS = 200, 30
BALANCED = 1e-10  # of the largest force, and of that over the rollers' length
FAINTEST = 1e-4  # N, on rollers that only LOOSE holds: there the tables have kinks
ROUND_OFF = 1e-7  # N
FITTING = 1e-15  # m, of approaches
LOOSE = 1.0  # N/m, and N m/rad a metre squared, keeps in the middle what no force holds


class Elastic(NamedTuple):
    """How bodies give way between contacts, inner ones first, and what closes these beside their places."""

    compliance: np.ndarray  # (2 n_rollers, 2 n_rollers), m/N, of forces
    tilt_compliance: np.ndarray  # the same, rad per N m, of moments
    closing: np.ndarray  # (2 n_rollers,), m


@dataclass(frozen=True, kw_only=True)
class TiltedStatics:
    """An equilibrium; SI, arrays (n_rollers,)."""

    place: np.ndarray  # (4,), of the hub: x, y, m, and its slope along x and y, rad
    rho: np.ndarray
    tilt: np.ndarray
    theta: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    inner_moment: np.ndarray  # N m
    outer_moment: np.ndarray
    own: np.ndarray  # (2, 2 n_rollers), approach, m, and misalignment, rad, of each contact's law
    stiffness: np.ndarray  # (2, 2), N/m, of the hub's place as all else follows
    on_hub: np.ndarray  # (2,), N m, moment of the contacts on the hub's slope

    @property
    def moved(self) -> np.ndarray:
        """All places, (4 + 2 n_rollers,): of the hub, radii, tilts."""
        return np.concatenate([self.place, self.rho, self.tilt])


class _Point(NamedTuple):
    """The system at one state of its unknowns."""

    forces: np.ndarray  # (4 n,), Q of all contacts, then −M
    stiff: np.ndarray  # (4 n, 4 n), their derivatives by own approaches and misalignments
    geometric: np.ndarray  # (4 n,), approaches and misalignments of the bodies
    ways: np.ndarray  # (4 n, 4 + 2 n), their derivatives by the bodies' places
    left: np.ndarray  # (4 + 2 n,), unbalanced forces and moments
    missing: np.ndarray  # (4 n,), by which own approaches and misalignments are off
    turning: np.ndarray  # (4 + 2 n, 4 + 2 n), stiffness by contacts' normals that turn


def tilted_equilibrium(
    bearing: Bearing,
    operation: Operation,
    laws: TiltedLaws,
    hub: HubTilt,
    theta: np.ndarray,
    start: tuple[np.ndarray, np.ndarray],
    *,
    elastic: Elastic | None = None,
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0),
) -> TiltedStatics:
    """Equilibrium under load, weights and centrifugal forces at cage speed.

    Parameters
    ----------
    laws : of the inner and the outer contact
    theta : (n_rollers,), rad
    start : hub's place, (2,), and rollers' radii, (n_rollers,), m, to begin from
    elastic : None: bodies are rigid but for their contacts
    ring : where the outer ring's centre is, m, from which all places are

    Errors
    ------
    RuntimeError: no equilibrium found.
    """
    system = _System(bearing, operation, laws, hub, theta, elastic, np.asarray(ring, dtype=float))
    slope = np.array([hub.slope_x, hub.slope_y])
    radial = np.array([np.cos(theta), np.sin(theta)])
    moved = np.concatenate([start[0], slope, start[1], 0.5 * (slope @ radial)])
    own = system.geometry(moved)[0]
    here = system.at(moved, own)
    for _ in range(MOST_STEPS):
        if system.size_of(here) <= 1.0:
            return system.found(moved, own, here)
        moved, own, here = _descended(system, moved, own, here)
    raise RuntimeError(
        f"no static equilibrium with tilt after {MOST_STEPS} steps: {np.abs(here.left[:2]).max():.3g} N unbalanced at "
        f"the hub; check load, operation.misalignment_mrad and profiles"
    )


def _descended(system: "_System", moved, own, here: _Point):
    """Newton's step, as much of it as makes what is left less."""
    step, own_step = system.newton(here)
    size = system.length_of(here)
    for _ in range(MOST_HALVINGS):
        there = moved + step, own + own_step
        point = system.at(*there)
        if system.length_of(point) < size:
            break
        step, own_step = 0.5 * step, 0.5 * own_step
    return *there, point


class _System:
    """Balance of hub, rollers and contacts."""

    def __init__(self, bearing, operation, laws, hub, theta, elastic, ring):
        n = self.n = bearing.n_rollers
        self.bearing, self.operation, self.laws, self.hub, self.theta, self.ring = (
            bearing,
            operation,
            laws,
            hub,
            theta,
            ring,
        )
        self.cos, self.sin = np.cos(theta), np.sin(theta)
        nothing = np.zeros((2 * n, 2 * n))
        elastic = elastic or Elastic(nothing, nothing, np.zeros(2 * n))
        self.compliance = np.block([[elastic.compliance, nothing], [nothing, elastic.tilt_compliance]])
        self.closing = np.concatenate([elastic.closing, np.zeros(2 * n)])
        cage, m = kinematics(bearing, operation.speed).cage, bearing.roller_mass
        self.spin, self.length = m * cage**2, bearing.roller_length
        self.applied = np.concatenate([
            [operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)], np.zeros(2),
            -m * operation.gravity * self.sin, np.zeros(n),
        ])  # fmt: skip
        slope, shaft = np.array([hub.slope_x, hub.slope_y]), operation.mounting.shaft
        slack = np.concatenate(
            [np.zeros(2), slope, np.full(n, bearing.pitch_radius), 0.5 * (slope[0] * self.cos + slope[1] * self.sin)]
        )
        self.springs = np.full(4 + 2 * n, LOOSE)
        self.springs[2:4] = hub.stiffness if hub.is_free else np.inf
        self.springs[4 + n :] = LOOSE * self.length**2
        if shaft is not None:
            self.springs[:2], slack[:2] = shaft.stiffness, -ring
        self.slack, self.moves = slack, np.isfinite(self.springs)
        self.weights = np.repeat([1.0, self.length], n)
        self.typical = bearing.roller.elastic.youngs_modulus * self.length  # N/m, of contacts, about
        self.precession = precession_stiffness(bearing, operation.speed)

    def geometry(self, moved) -> tuple[np.ndarray, np.ndarray, PolarOverlaps]:
        """Approaches and misalignments, (4 n,), their derivatives, (4 n, 4 + 2 n), and the circles' overlaps."""
        n, (x, y, bx, by), cos, sin = self.n, moved[:4], self.cos, self.sin
        rho, tilt = moved[4 : 4 + n], moved[4 + n :]
        found = polar_overlaps(self.bearing, rho, x * cos + y * sin, y * cos - x * sin)
        at = misalignments(
            found, Tilts(tilt=tilt, skew=0.0, tilt_rate=tilt, skew_rate=0.0, slope_x=bx, slope_y=by), cos, sin
        )
        nx, ny = found.radial * cos - found.tangential * sin, found.radial * sin + found.tangential * cos
        across, j = at.inner_across / found.distance, np.arange(n)
        ways = np.zeros((4 * n, 4 + 2 * n))
        ways[j, 0], ways[j, 1], ways[j, 4 + j] = nx, ny, -found.radial
        ways[n + j, 4 + j] = 1.0
        psi = 2 * n + j
        ways[psi, 0], ways[psi, 1], ways[psi, 4 + j] = across * ny, -across * nx, -across * found.tangential
        ways[psi, 2], ways[psi, 3], ways[psi, 4 + n + j] = -nx, -ny, found.radial
        ways[3 * n + j, 4 + n + j] = -1.0
        return np.concatenate([found.inner, found.outer, at.inner, at.outer]) + self.closing, ways, found

    def at(self, moved, own) -> _Point:
        """Forces by contacts' own approaches, and what they leave of balance and fit."""
        n, j = self.n, np.arange(self.n)
        geometric, ways, found = self.geometry(moved)
        forces, stiff = np.zeros(4 * n), np.zeros((4 * n, 4 * n))
        for row, law in enumerate(self.laws):
            d, p = row * n + j, (2 + row) * n + j
            met = law.at(own[d], own[p])
            forces[d], forces[p] = met.force, -met.moment
            stiff[d, d], stiff[d, p], stiff[p, d], stiff[p, p] = met.stiffness, met.cross, met.cross, met.tilt_stiffness
        held = np.where(self.moves, self.springs, 0.0) * (moved - self.slack)
        left = self.applied - held - ways.T @ forces
        left[4 : 4 + n] += self.spin * moved[4 : 4 + n]
        left[4 + n :] -= self.precession * moved[4 + n :]
        across = np.zeros((n, 4 + 2 * n))  # ways along the inner contacts' tangents
        nx, ny = ways[j, 0], ways[j, 1]
        across[:, 0], across[:, 1], across[j, 4 + j] = ny, -nx, -found.tangential
        turning = -(across.T * (forces[:n] / found.distance)) @ across
        return _Point(forces, stiff, geometric, ways, left, geometric - self.compliance @ forces - own, turning)

    def size_of(self, here: _Point) -> float:
        """Of what is left, over what may be: at most 1 in equilibrium."""
        n, left = self.n, np.where(self.moves, np.abs(here.left), 0.0)
        largest = max(float(np.abs(self.applied).max()), float(np.abs(here.forces[: 2 * n]).max()))
        left[2:4], left[4 + n :] = left[2:4] / self.length, left[4 + n :] / self.length
        fits = max(np.abs(here.missing[: 2 * n]).max(), self.length * np.abs(here.missing[2 * n :]).max())
        enough = BALANCED * largest
        return max(left[:4].max() / (enough + ROUND_OFF), left[4:].max() / (enough + FAINTEST), fits / FITTING)

    def length_of(self, here: _Point) -> float:
        """Of the vector of all that is left, N, which Newton's steps make shorter."""
        left = np.where(self.moves, here.left, 0.0) / np.concatenate(
            [[1.0, 1.0], np.full(2, self.length), self.weights]
        )
        missing = here.missing / np.repeat([1.0, 1.0 / self.length], 2 * self.n)
        return float(np.sqrt(left @ left + self.typical**2 * (missing @ missing)))

    def _effective(self, here: _Point) -> np.ndarray:
        """Stiffness of all contacts by the bodies' approaches, (4 n, 4 n)."""
        return np.linalg.solve((np.eye(4 * self.n) + self.compliance @ here.stiff).T, here.stiff.T).T

    def _stiffness(self, here: _Point, effective: np.ndarray) -> np.ndarray:
        n = self.n
        whole = here.ways.T @ effective @ here.ways + here.turning
        own = np.where(self.moves, self.springs, 1.0)
        own[4 : 4 + n] -= self.spin
        own[4 + n :] += self.precession
        return whole + np.diag(own)

    def newton(self, here: _Point) -> tuple[np.ndarray, np.ndarray]:
        """Newton's step of the bodies, and of the contacts' own approaches and misalignments."""
        effective, moves = self._effective(here), self.moves
        whole = self._stiffness(here, effective)[np.ix_(moves, moves)]
        right = (here.left - here.ways.T @ (effective @ here.missing))[moves]
        step = np.zeros(moves.size)
        step[moves] = np.linalg.solve(whole, right)
        own_step = np.linalg.solve(np.eye(4 * self.n) + self.compliance @ here.stiff, here.missing + here.ways @ step)
        longest = 1e-3 * self.bearing.roller_radius
        share = min(1.0, longest / max(float(np.abs(own_step[: 2 * self.n]).max()), 1e-30))
        return share * step, share * own_step

    def found(self, moved, own, here: _Point) -> TiltedStatics:
        n, forces = self.n, here.forces
        whole = self._stiffness(here, self._effective(here))
        first, rest = np.arange(2), np.flatnonzero(self.moves)[2:]
        cross = whole[np.ix_(first, rest)]
        stiffness = whole[:2, :2] - cross @ np.linalg.solve(whole[np.ix_(rest, rest)], cross.T)
        return TiltedStatics(
            place=moved[:4], rho=moved[4 : 4 + n], tilt=moved[4 + n :], theta=self.theta,
            inner_force=forces[:n], outer_force=forces[n : 2 * n], inner_moment=-forces[2 * n : 3 * n],
            outer_moment=-forces[3 * n :], own=own.reshape(2, 2 * n), stiffness=stiffness,
            on_hub=-(here.ways.T @ forces)[2:4],
        )  # fmt: skip

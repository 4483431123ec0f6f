"""Motion of hub and rollers, all that a search for faults sees of a run: no forces, and no surfaces of the scene."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.hertz import Pair, Side, contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.equations import approaches
from lagrange.kinematics import turned
from lagrange.surface.edges import softening
from lagrange.surface.faults import Spall
from lagrange.surface.rolling_envelope import Circles
from residual.record import SMALL_LOAD, Record

SIDES: dict[str, tuple[Side, ...]] = {"outer_ring": ("outer",), "inner_ring": ("inner",), "roller": ("outer", "inner")}
SCALES = 0.5, 2.0  # of a law's stiffness by the hub's load: beyond, the run is not what its scene says
PHASE_STEP = 0.7  # of the roller's vibration between its contacts, rad: leapfrog is off by 2 % of a cycle
SOFTEST, STIFFEST = 1e-8, 3e-4  # m, overlaps that the contacts' law is tabulated for
TABULATED = 300
STIFF = 2e-5  # m, overlap whose stiffness sets the time step
VELOCITY_STEPS = 2  # secant steps
FIRST_VELOCITY_STEP, LONGEST_VELOCITY_STEP = 0.01, 0.3  # m/s
INSENSITIVE = 0.15  # of the time between samples: below, velocities show little in the outer samples and are left
EDGE_ROUNDING = 0.02  # edge radius over roller radius: 0.1 mm of 5 mm; the width changes by 1 % from 0 to twice it
SOFT_WAY = 0.04, 200  # of the roller's radius, on either side of an edge; points
AT_ONCE = 1_000_000  # numbers held of one array


@dataclass(frozen=True, kw_only=True)
class Place:
    """A body and the raceways at which its surface is met; angles in its frame, as in `lagrange.surface.faults`."""

    body: Literal["outer_ring", "inner_ring", "roller"]
    roller: int | None
    radius: float  # m, of its surface

    @property
    def sides(self) -> tuple[Side, ...]:
        return SIDES[self.body]

    @property
    def rollers(self) -> slice:
        """Rollers that pass over the body's surface."""
        return slice(None) if self.roller is None else slice(self.roller, self.roller + 1)


@dataclass(frozen=True, kw_only=True)
class RollerMotion:
    """Trajectories, and overlaps of the perfect circles, m: what sinks into a spall overlaps more. Time first."""

    bearing: Bearing  # perfect circles
    operation: Operation
    load: tuple[np.ndarray, np.ndarray]  # N, (n_times,), of the hub along x and y, its weight included
    interval: float  # s
    rho: np.ndarray  # (n_times, n_rollers), m
    outer_angle: np.ndarray  # (n_times, n_rollers), rad, of the contacts in fixed axes
    inner_angle: np.ndarray
    inner_turn: np.ndarray  # (n_times, 1), rad
    outer_turn: np.ndarray
    roller_turn: np.ndarray  # (n_times, n_rollers), rad
    inner: np.ndarray  # (n_times, n_rollers), m, overlap with the inner raceway
    outer: np.ndarray

    def angles(self, place: Place, side: Side) -> np.ndarray:
        """Where contacts lie on a body, in its own frame, (n_times, n_rollers that pass), rad, unwrapped."""
        if place.body == "outer_ring":
            return self.outer_angle - self.outer_turn
        if place.body == "inner_ring":
            return self.inner_angle - self.inner_turn
        direction = self.outer_angle if side == "outer" else self.inner_angle + np.pi
        return (direction - self.roller_turn)[:, place.rollers]

    def travel(self, place: Place) -> float:
        """Median way of contacts on a body from sample to sample, m."""
        return float(np.median(np.abs(np.diff(self.angles(place, place.sides[0]), axis=0)))) * place.radius

    def places(self) -> list[Place]:
        """Every surface that may have a spall."""
        b = self.bearing
        outer = Place(body="outer_ring", roller=None, radius=b.outer_raceway_radius)
        inner = Place(body="inner_ring", roller=None, radius=b.inner_raceway_radius)
        return [outer, inner, *(Place(body="roller", roller=j, radius=b.roller_radius) for j in range(b.n_rollers))]


def roller_motion(record: Record) -> RollerMotion:
    """Take a record's trajectories alone: its contact forces and its scene's surfaces stay behind.

    The rollers' rotations are the record's own, or else those of rolling on the outer raceway without slip.
    """
    bearing, operation = replace(record.bearing, faults=()), record.operation
    found = approaches(bearing, record.inner_x, record.inner_y, record.roller_x, record.roller_y)
    rho = np.hypot(record.roller_x, record.roller_y)
    theta = np.unwrap(np.arctan2(record.roller_y, record.roller_x), axis=0)
    way = turned(bearing, operation, record.time[:, None])
    outer_turn, roller_turn = np.asarray(way.outer_ring), np.asarray(way.roller)
    turn = record.roller_turn
    if turn is None:
        track = bearing.outer_raceway_radius - bearing.roller_radius
        surface = (outer_turn - outer_turn[0]) * bearing.outer_raceway_radius
        turn = roller_turn[0] - ((theta - theta[0]) * track - surface) / bearing.roller_radius
    return RollerMotion(
        bearing=bearing, operation=operation, load=record.whole_load, interval=record.interval,
        rho=rho, outer_angle=theta,
        inner_angle=np.unwrap(np.arctan2(-found.direction_y, -found.direction_x), axis=0),
        inner_turn=np.asarray(way.shaft), outer_turn=outer_turn, roller_turn=turn,
        inner=found.inner, outer=found.outer,
    )  # fmt: skip


def stiffness(motion: RollerMotion, law: str):
    """Secant stiffness of a contact, N/m, as a function of its overlap, m: the law's, scaled to carry the hub's load.

    Errors
    ------
    One factor for all contacts: neighbours that press on the same ring, and bending rings, are in it on the average.
    The law's own stiffness where the load is small beside the contacts' forces, as with a preload.
    """
    named = contact_laws(law, motion.bearing).inner
    force = named.force(motion.inner)
    load = np.hypot(*motion.load)
    loaded = (load > 0.0) & (load >= SMALL_LOAD * force.max(initial=0.0))
    angle, (load_x, load_y) = motion.inner_angle, motion.load
    along = np.sum(force * np.cos(angle), axis=1) * load_x + np.sum(force * np.sin(angle), axis=1) * load_y  # N²
    carried = float(np.median(along[loaded] / load[loaded] ** 2)) if loaded.any() else 0.0  # of the load
    scale = float(np.clip(1.0 / carried, *SCALES)) if carried > 0.0 else 1.0
    return lambda overlap: scale * named.force(overlap) / overlap


Spalled = tuple[Place, np.ndarray]  # a body and spalls of it
Sunk = Callable[[float], dict[Side, tuple[np.ndarray | float, np.ndarray | float]]]
NONE = 0.0  # no edges


class Contact:
    """Force of a contact over its overlap, tabulated; near the edges of spalls it is softer."""

    def __init__(self, bearing: Bearing, stiffness: Callable[[np.ndarray], np.ndarray]):
        """`stiffness`, N/m, secant, by overlap, m."""
        deep = np.geomspace(SOFTEST, STIFFEST, TABULATED)
        self._overlap = np.concatenate([[0.0], deep])
        self._force = np.concatenate([[0.0], stiffness(deep) * deep])
        self.mass = bearing.roller_mass
        self.fastest = float(np.sqrt(2.0 * stiffness(np.array([STIFF]))[0] / bearing.roller_mass))  # rad/s
        r, inner, outer = bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius
        self._way = np.linspace(-SOFT_WAY[0] * r, SOFT_WAY[0] * r, SOFT_WAY[1])
        wide = Spall(body="outer_ring", roller=None, angle=0.0, width=0.4 * r, depth=r, edge_radius=EDGE_ROUNDING * r)
        edge = wide.half_opening(r) - self._way
        inside, outside, _ = contact_pairs(bearing)
        pairs: dict[Side, tuple[Pair, Circles]] = {
            "inner": (inside, Circles(inner, r, "outside", r)),
            "outer": (outside, Circles(outer, r, "bore", r)),
        }
        self._soft = {
            side: np.zeros_like(self._way) if isinstance(bearing, BallBearing)
            else pair.line_compliance * softening(wide, circles, np.arcsin(edge / circles.own))
            for side, (pair, circles) in pairs.items()
        }  # fmt: skip

    def stride(self, interval: float) -> int:
        """Samples that are about half a period of the roller's vibration apart."""
        return max(1, round(np.pi / (self.fastest * interval)))

    def softness(self, side: Side, inside: np.ndarray) -> np.ndarray:
        """Compliance that an edge adds, m/N, by the way that a contact has gone over it, m, negative before it."""
        return np.interp(inside, self._way, self._soft[side])

    def push(self, overlap: np.ndarray, softness: np.ndarray | float) -> np.ndarray:
        """Acceleration of the roller, m/s²."""
        force = np.interp(overlap, self._overlap, self._force)
        if softness is not NONE:
            force = force * overlap / np.maximum(overlap + softness * force, SOFTEST)
        return force / self.mass


class ThreeSamples:
    """Some rollers at some times, with the samples before and after; arrays (n,).

    A roller moves from one sample to the next two by its equation of motion between two contacts that only push. The
    middle sample is the start, forwards and backwards in time; the velocity there is the one that fits the difference
    of the outer two, whose sum then follows from the equation. So the roller's state before need not be known: whether
    it rests, flies or rattles, three samples depend on the surfaces met between them.
    """

    def __init__(self, motion: RollerMotion, contact: Contact, middle: np.ndarray, roller: np.ndarray):
        """`middle` : numbers of the middle samples; `roller` : of the rollers."""
        self.motion, self.contact, self.middle, self.roller = motion, contact, middle, roller
        self.stride = contact.stride(motion.interval)
        self.lapse = self.stride * motion.interval
        self.steps = int(np.ceil(self.lapse * contact.fastest / PHASE_STEP))
        b = motion.bearing
        self._before, self._now, self._after = (motion.rho[middle + k * self.stride, roller] for k in (-1, 0, 1))
        angle = self._through(motion.outer_angle)
        rate = angle[1] / self.lapse
        self._pull = b.pitch_radius * rate**2 - motion.operation.gravity * np.sin(angle[0])
        self._inside = self._through(motion.inner + motion.rho)  # place at which the inner contact opens
        self._outside = self._through(motion.rho - motion.outer)
        # velocities at the middle over the first surfaces asked for, from which others are a step away
        self._settled: tuple[np.ndarray, np.ndarray] | None = None

    def _through(self, of: np.ndarray, column: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
        """Coefficients of the parabola through three samples, over time from −1 to 1."""
        at = self.roller if column is None else column
        before, now, after = (of[self.middle + k * self.stride, at] for k in (-1, 0, 1))
        return now, 0.5 * (after - before), 0.5 * (after + before) - now

    def angle(self, place: Place, side: Side) -> np.ndarray:
        """Angles of the contacts at the middle samples in the place's own frame, (n,), rad; of a roller, its own."""
        column = self.roller if place.roller is None else np.zeros_like(self.roller)
        return self.motion.angles(place, side)[self.middle, column]

    def _outer(self, sunk: Sunk) -> Callable[[np.ndarray, int], np.ndarray]:
        """Places at the samples after (1) and before (−1), by the velocity at the middle one and that sign.

        `sunk` : how deep the surface under either contact lies, m, and what edges add to its compliance, m/N, (..., n),
        at a time from −1 to 1
        """
        n, step = self.steps, self.lapse / self.steps
        surfaces = []  # low and high at each step, and what edges add to their compliance
        for t in np.arange(-n, n + 1) / n:
            deeper = sunk(t)
            (low, soft_low), (high, soft_high) = deeper["inner"], deeper["outer"]
            surfaces.append((_at(self._inside, t) - low, soft_low, _at(self._outside, t) + high, soft_high))

        def rate(place, k):
            low, soft_low, high, soft_high = surfaces[n + k]
            return self.contact.push(low - place, soft_low) - self.contact.push(place - high, soft_high) + self._pull

        first = rate(self._now, 0)

        def outer(velocity, sign):
            place, speed = self._now, sign * velocity + 0.5 * step * first
            for k in range(1, n):
                place = place + step * speed
                speed = speed + step * rate(place, sign * k)
            return place + step * speed

        return outer

    def _missed(self, sunk: Sunk, settled: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Excess of the outer samples' sum over that of the equation of motion, (..., n), m."""
        outer, apart, (velocity, slope) = self._outer(sunk), self._after - self._before, settled
        moved = outer(velocity, 1) - outer(velocity, -1)
        velocity = velocity + _move(apart - moved, slope, self.lapse)
        return self._after + self._before - outer(velocity, 1) - outer(velocity, -1)

    def over(self, spalled: Sequence[Spalled], more: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """Mismatch of three samples over spalls, (n_spalls, n), m; each place with as many spalls, or with one.

        Parameters
        ----------
        spalled : places, and ndarray, (n_spalls, 3): angle of the middle, rad; width, m; depth, m
        more : m, that the inner and the outer surface lie deeper than that everywhere
        """
        most = max((len(spalls) for _, spalls in spalled), default=1)
        if self._settled is None:
            first = self._outer(self._sunk([(place, spalls[:1]) for place, spalls in spalled], more))
            self._settled = _velocity(first, self._after - self._before, self.lapse)
        each = max(1, AT_ONCE // max(1, self.middle.size))
        parts = []
        for k in range(0, most, each):
            part = [(place, spalls if len(spalls) == 1 else spalls[k : k + each]) for place, spalls in spalled]
            parts.append(np.atleast_2d(self._missed(self._sunk(part, more), self._settled)))
        return np.concatenate(parts)

    def _sunk(self, spalled: Sequence[Spalled], more: tuple[float, float]) -> Sunk:
        """How deep the surfaces with some spalls lie under both contacts, by the time from −1 to 1."""
        sinkers = [self._sinker(place, spalls, side) for place, spalls in spalled for side in place.sides]

        def sunk(time):
            total = {side: (each, NONE) for side, each in zip(("inner", "outer"), more, strict=True)}
            for side, sinker in sinkers:
                depth, softness = sinker(time)
                total[side] = total[side][0] + depth, total[side][1] + softness
            return total

        return sunk

    def _sinker(self, place: Place, spalls: np.ndarray, side: Side):
        """How deep some spalls are under the contacts of a side, and how soft, by the time from −1 to 1."""
        b = self.motion.bearing
        column, own = self.roller, 1.0
        if place.roller is not None:
            column, own = np.zeros_like(self.roller), (self.roller == place.roller).astype(float)
        path = self._through(self.motion.angles(place, side), column)
        angle, width, depth = (spalls[:, k, None] for k in range(3))
        raceway, sign = (b.outer_raceway_radius, -1.0) if side == "outer" else (b.inner_raceway_radius, 1.0)

        def sunk(time):
            beyond = np.abs(np.mod(_at(path, time) - angle + np.pi, 2.0 * np.pi) - np.pi) * place.radius
            inside = np.where(width > 0.0, 0.5 * width * np.sqrt(1.0 + EDGE_ROUNDING), -b.roller_radius) - beyond
            fallen = edge_sinkage(np.maximum(inside, 0.0), b.roller_radius, raceway, sign)
            return own * np.minimum(fallen, depth), own * self.contact.softness(side, inside)

        return side, sunk


def _velocity(outer, apart: np.ndarray, lapse: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocities at the middle samples that fit the outer ones' difference, m/s, and its change by them, s."""
    last = 0.5 * apart / lapse
    new, moved = last + FIRST_VELOCITY_STEP, outer(last, 1) - outer(last, -1)
    for _ in range(VELOCITY_STEPS):
        change, before = new - last, moved
        moved = outer(new, 1) - outer(new, -1)
        slope = (moved - before) / np.where(change == 0.0, 1.0, change)
        last, new = new, new + _move(apart - moved, slope, lapse)
    return new, slope


def _move(short: np.ndarray, slope: np.ndarray, lapse: float) -> np.ndarray:
    """Change of the velocities for a difference of the outer samples, m/s."""
    move = short * slope / (slope**2 + (INSENSITIVE * lapse) ** 2)
    return np.clip(move, -LONGEST_VELOCITY_STEP, LONGEST_VELOCITY_STEP)


def _at(coefficients: tuple[np.ndarray, ...], time: float) -> np.ndarray:
    level, slope, curve = coefficients
    return level + (slope + curve * time) * time


def edge_sinkage(inside: np.ndarray, roller_radius: float, raceway_radius: float, sign: float) -> np.ndarray:
    """How far a roller sinks that has gone a way over an edge, m; `sign` is 1 on the inner raceway, −1 in the outer.

    Errors
    ------
    The edge's rounding is `EDGE_ROUNDING` whatever it is; ways beyond 0.95 of the roller's radius count as that.
    """
    turned = roller_radius * (1.0 + EDGE_ROUNDING)
    way = np.minimum(inside, 0.95 * roller_radius)
    fallen = turned - np.sqrt(turned**2 - way**2)
    return fallen + sign * (raceway_radius - np.sqrt(raceway_radius**2 - way**2))

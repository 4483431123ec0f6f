"""Spalls found from trajectories alone: which bodies, where, how wide, each with an interval; or none.

Three samples of a roller depend on the surfaces that it meets between them, by its equation of motion. Sinkage maps,
medians of all passages by each body's own angle, show how deep rollers find the surface there beyond perfect circles. A
spall is deep in every passage at its own angle of its own body; by the angle of any other body its passages lie
scattered, and the median does not show them; waves have no single deepest place. For each suspect place the spall is
sought that explains most, the best of them is found, what it explains is taken out, and so on until none stands out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from scipy.ndimage import median

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.hertz import Side, contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.errors import InputError
from lagrange.kinematics import turned
from lagrange.surface.edges import Circles, softening
from lagrange.surface.faults import Spall
from residual.record import SMALL_LOAD, Record

SIDES: dict[str, tuple[Side, ...]] = {"outer_ring": ("outer",), "inner_ring": ("inner",), "roller": ("outer", "inner")}
SCALES = 0.5, 2.0  # of a law's stiffness by the hub's load: beyond, the run is not what its scene says
PHASE_STEP = 0.7  # of the roller's vibration between its contacts, rad: leapfrog is off by 2 % of a cycle
SOFTEST, STIFFEST, TABULATED = 1e-8, 3e-4, 300  # m, overlaps that the contacts' law is tabulated for; points
STIFF = 2e-5  # m, overlap whose stiffness sets the time step
VELOCITY_STEPS, FIRST_VELOCITY_STEP, LONGEST_VELOCITY_STEP = 2, 0.01, 0.3  # of the secant method; m/s
INSENSITIVE = 0.15  # of the time between samples: below, velocities show little in the outer samples and are left
EDGE_ROUNDING = 0.02  # edge radius over roller radius: 0.1 mm of 5 mm; the width changes by 1 % from 0 to twice it
SOFT_WAY = 0.04, 200  # of the roller's radius, on either side of an edge; points
AT_ONCE = 1_000_000  # numbers held of one array

# of maps
BIN = 5e-5  # m along the surface, a sixth of the narrowest spall looked for
FEWEST_IN_BIN, SMOOTHED = 3, 3  # of a bin that counts as seen; bins
OFF_RACEWAY = 3e-7  # m: rollers farther off a raceway say nothing about it
PROBE = 1e-6  # m, of sinkage, whose effect scales all others
LEAST_GAIN = 0.3  # of what three samples are changed by over the probe: below, rollers hardly touch
MOST, LEAST = 3e-5, 3e-7  # m, largest sinkage that rollers reach; maps of perfect bearings reach 0.2 µm
MAP_BESIDE = 0.03, 2e-3  # of the circumference, and m: as far from the deepest place the rest of a map begins
REST, FEWEST_REST = 0.99, 20  # quantile of the rest of a map that its deepest place is compared with; bins
MAP_STANDS_OUT = 3.0  # times the rest of its map: perfect and wavy bearings reach 2
# of the search
MOST_SUSPECTS, MOST_SPALLS = 4, 4
WIDTHS = 1e-3 * np.geomspace(0.22, 3.4, 12)  # m, first tried
ASIDE = np.linspace(-0.6, 0.6, 9)  # of the width, first tried beside the map's deepest place
STARTS, MOST_SAMPLES = 2, 1200  # best of these, each made finer; that a spall is matched to
DEEP, DEPTH_RATIOS = 2e-4, (1.8, 1.5, 1.3, 1.2, 1.1)  # m, first tried; from one refinement to the next
MOVED = 4  # steps that either edge is moved by in each refinement
DEPTH_TELLS = 8e-4  # m, width from which a roller may reach a bottom
FINER, FIRST_STEP = 0.55, 0.16  # of the width
BESIDE = 2e-4  # m, that rollers are followed beside a spall's edges
UNREST = 1.5e-7  # m, that three samples are missed by anyway
FARTHEST, NARROWEST = 3e-4, 1.5e-4  # m, from sample to sample; of a spall
RESAMPLED, SIGMAS = 200, 2.0  # sets of passages drawn with replacement; of intervals
MODEL_WIDTH, MODEL_PLACE = 0.03, 1.5e-5  # of the width, and m: scatter on known spalls beyond that of passages

Pair = tuple[np.ndarray, np.ndarray]
# a body, and spalls of it, (n_spalls, 3): angle of the middle, rad; width, m; depth, m
Spalled = tuple["Place", np.ndarray]


class Place(NamedTuple):
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
    """All that a search sees of a run, no forces and no surfaces of the scene; overlaps are of perfect circles, m.

    What sinks into a spall overlaps more. Arrays (n_times, n_rollers), angles of contacts in fixed axes, rad.
    """

    bearing: Bearing  # perfect circles
    operation: Operation
    law: Callable[[np.ndarray], np.ndarray]  # force of a contact, N, by its overlap
    load: np.ndarray  # N, (2, n_times), of the hub along x and y, its weight included
    interval: float  # s
    rho: np.ndarray  # m
    outer_angle: np.ndarray
    inner_angle: np.ndarray
    inner_turn: np.ndarray  # (n_times, 1), rad
    outer_turn: np.ndarray
    roller_turn: np.ndarray  # rad
    inner: np.ndarray  # m, overlap with the inner raceway
    outer: np.ndarray

    @cached_property
    def scale(self) -> float:
        """Factor of the law's forces by which they carry the hub's load; 1 where that is small, as with a preload.

        One factor for all contacts: neighbours that press on the same ring, and bending rings, are in it on average.
        """
        force, load, (load_x, load_y) = self.law(self.inner), np.hypot(*self.load), self.load
        loaded = (load > 0.0) & (load >= SMALL_LOAD * force.max(initial=0.0))
        along = [np.sum(force * part(self.inner_angle), axis=1) for part in (np.cos, np.sin)]
        along = along[0] * load_x + along[1] * load_y  # N²
        carried = np.median(along[loaded] / load[loaded] ** 2) if loaded.any() else 0.0  # of the load
        return np.clip(1.0 / carried, *SCALES) if carried > 0.0 else 1.0

    @cached_property
    def table(self) -> Pair:
        """Overlaps of a contact, m, and its push of a roller, N, by the scaled law."""
        deep = np.geomspace(SOFTEST, STIFFEST, TABULATED)
        return np.append(0.0, deep), np.append(0.0, self.scale * self.law(deep))

    @cached_property
    def softness(self) -> dict[Side, Pair]:
        """Ways into a spall past its edge, m, and what the edge adds to a contact's compliance there, m/N; by side."""
        b, r = self.bearing, self.bearing.roller_radius
        way = np.linspace(-SOFT_WAY[0] * r, SOFT_WAY[0] * r, SOFT_WAY[1])
        if isinstance(b, BallBearing):
            return {side: (way, 0.0 * way) for side in SIDES["roller"]}
        wide = Spall(body="outer_ring", roller=None, angle=0.0, width=0.4 * r, depth=r, edge_radius=EDGE_ROUNDING * r)
        edge, inside, outside = wide.half_opening(r) - way, *contact_pairs(b)[:2]
        met: dict[Side, tuple] = {
            "inner": (inside, Circles(b.inner_raceway_radius, r, "outside", r)),
            "outer": (outside, Circles(b.outer_raceway_radius, r, "bore", r)),
        }
        return {
            side: (way, pair.line_compliance * softening(wide, at, np.arcsin(edge / at.own)))
            for side, (pair, at) in met.items()
        }

    @cached_property
    def fastest(self) -> float:
        """Angular frequency of a roller between two contacts, rad/s."""
        force = self.scale * self.law(np.array([STIFF]))[0]
        return np.sqrt(2.0 * force / STIFF / self.bearing.roller_mass)

    @property
    def stride(self) -> int:
        """Samples that are about half a period of the roller's vibration apart."""
        return max(1, round(np.pi / (self.fastest * self.interval)))

    def push(self, overlap: np.ndarray, softness) -> np.ndarray:
        """Acceleration of a roller, m/s², by a contact; softness, m/N, of edges, or 0 without any."""
        force = np.interp(overlap, *self.table)
        if np.ndim(softness):
            force = force * overlap / np.maximum(overlap + softness * force, SOFTEST)
        return force / self.bearing.roller_mass

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
        return np.median(np.abs(np.diff(self.angles(place, place.sides[0]), axis=0))) * place.radius

    def places(self) -> list[Place]:
        """Every surface that may have a spall: outer ring, inner ring, rollers."""
        b = self.bearing
        rings = Place("outer_ring", None, b.outer_raceway_radius), Place("inner_ring", None, b.inner_raceway_radius)
        return [*rings, *(Place("roller", j, b.roller_radius) for j in range(b.n_rollers))]


def roller_motion(record: Record) -> RollerMotion:
    """Take a record's trajectories alone: its contact forces and its scene's surfaces stay behind.

    The rollers' rotations are the record's own, or else those of rolling on the outer raceway without slip.
    """
    bearing, operation, turn = replace(record.bearing, faults=()), record.operation, record.roller_turn
    found, theta = record.circles, record.theta
    way = turned(bearing, operation, record.time[:, None])
    outer_turn = np.asarray(way.outer_ring)
    if turn is None:
        track = bearing.outer_raceway_radius - bearing.roller_radius
        surface = (outer_turn - outer_turn[0]) * bearing.outer_raceway_radius
        turn = np.asarray(way.roller)[0] - ((theta - theta[0]) * track - surface) / bearing.roller_radius
    return RollerMotion(
        bearing=bearing, operation=operation, law=contact_laws(record.scene.lagrange.law, bearing).inner.force,
        load=record.whole_load, interval=record.interval, rho=record.rho,
        outer_angle=theta, inner_angle=np.unwrap(np.arctan2(-found.direction_y, -found.direction_x), axis=0),
        inner_turn=np.asarray(way.shaft), outer_turn=outer_turn, roller_turn=turn, inner=found.inner,
        outer=found.outer)  # fmt: skip


class ThreeSamples:
    """Some rollers at some times, with the samples before and after; arrays (n,).

    A roller moves from one sample to the next two by its equation of motion between two contacts that only push. The
    middle sample is the start, forwards and backwards in time; the velocity there is the one that fits the difference
    of the outer two, whose sum then follows from the equation. So the roller's state before need not be known: whether
    it rests, flies or rattles, three samples depend on the surfaces met between them.
    """

    def __init__(self, motion: RollerMotion, middle: np.ndarray, roller: np.ndarray):
        """`middle` : numbers of the middle samples; `roller` : of the rollers."""
        self.motion, self.middle, self.roller = motion, middle, roller
        self.lapse = motion.stride * motion.interval
        self.steps = int(np.ceil(self.lapse * motion.fastest / PHASE_STEP))
        self.before, self.now, self.after = (motion.rho[middle + k * motion.stride, roller] for k in (-1, 0, 1))
        angle = self._through(motion.outer_angle, roller)
        self.pull = motion.bearing.pitch_radius * (angle[1] / self.lapse) ** 2
        self.pull = self.pull - motion.operation.gravity * np.sin(angle[2])
        self.inside = self._through(motion.inner + motion.rho, roller)  # place at which the inner contact opens
        self.outside = self._through(motion.rho - motion.outer, roller)
        # velocities at the middle over the first surfaces asked for, from which others are a step away, and the change
        # of the outer samples' difference by them
        self.settled: Pair | None = None

    def _through(self, of, column):
        """Coefficients of the parabola through three samples, over time from −1 to 1, highest first."""
        before, now, after = (of[self.middle + k * self.motion.stride, column] for k in (-1, 0, 1))
        return np.array([0.5 * (after + before) - now, 0.5 * (after - before), now])

    def _surfaces(self, spalled, more):
        """At each step the places at which both contacts open, m, each with what edges add to its compliance, m/N."""
        b, met, found = self.motion.bearing, [], []
        for place, spalls in spalled:
            column, own = self.roller, 1.0
            if place.roller is not None:
                column, own = np.zeros_like(self.roller), (self.roller == place.roller).astype(float)
            angle, width, depth = (spalls[:, k, None] for k in range(3))
            half = np.where(width > 0.0, 0.5 * width * np.sqrt(1.0 + EDGE_ROUNDING), -b.roller_radius)
            for side in place.sides:
                path = self._through(self.motion.angles(place, side), column)
                met.append((side, path, angle, place.radius, half, depth, own))
        raceways = {"outer": (b.outer_raceway_radius, -1.0), "inner": (b.inner_raceway_radius, 1.0)}
        for t in np.arange(-self.steps, self.steps + 1) / self.steps:
            sunk: dict[Side, tuple] = {"inner": (more[0], 0.0), "outer": (more[1], 0.0)}
            for side, path, angle, radius, half, depth, own in met:
                inside = half - np.abs(_around(np.polyval(path, t) - angle)) * radius
                fallen = edge_sinkage(np.maximum(inside, 0.0), b.roller_radius, *raceways[side])
                soft = np.interp(inside, *self.motion.softness[side])
                sunk[side] = sunk[side][0] + own * np.minimum(fallen, depth), sunk[side][1] + own * soft
            (low, soft_low), (high, soft_high) = sunk["inner"], sunk["outer"]
            found.append((np.polyval(self.inside, t) - low, soft_low, np.polyval(self.outside, t) + high, soft_high))
        return found

    def _ends(self, surfaces, velocity):
        step, push, found = self.lapse / self.steps, self.motion.push, []
        for sign in (1, -1):
            place, speed = self.now, sign * velocity
            for k in range(self.steps):
                low, soft_low, high, soft_high = surfaces[self.steps + sign * k]
                rate = push(low - place, soft_low) - push(place - high, soft_high) + self.pull
                speed = speed + (step if k else 0.5 * step) * rate
                place = place + step * speed
            found.append(place)
        return found

    def over(self, spalled: Sequence[Spalled], more: Sequence[float] = (0.0, 0.0)) -> np.ndarray:
        """Excess of the outer samples' sum over that of the equation of motion, (n_spalls, n), m.

        spalled : each place with as many spalls, or with one
        more : m, that the inner and the outer surface lie deeper than that everywhere
        """
        apart, each, parts = self.after - self.before, max(1, AT_ONCE // max(1, self.middle.size)), []

        def better(velocity, ends, slope):
            short = apart - (ends[0] - ends[1])
            move = short * slope / (slope**2 + (INSENSITIVE * self.lapse) ** 2)
            return velocity + np.clip(move, -LONGEST_VELOCITY_STEP, LONGEST_VELOCITY_STEP)

        if self.settled is None:
            surfaces = self._surfaces([(place, spalls[:1]) for place, spalls in spalled], more)
            last = 0.5 * apart / self.lapse
            new, ends = last + FIRST_VELOCITY_STEP, self._ends(surfaces, last)
            for _ in range(VELOCITY_STEPS):
                change, before, ends = new - last, ends, self._ends(surfaces, new)
                slope = (ends[0] - ends[1] - (before[0] - before[1])) / np.where(change == 0.0, 1.0, change)
                last, new = new, better(new, ends, slope)
            self.settled = new, slope
        settled, slope = self.settled
        for k in range(0, max((len(spalls) for _, spalls in spalled), default=1), each):
            surfaces = self._surfaces([(at, s if len(s) == 1 else s[k : k + each]) for at, s in spalled], more)
            ends = self._ends(surfaces, better(settled, self._ends(surfaces, settled), slope))
            parts.append(np.atleast_2d(self.after + self.before - ends[0] - ends[1]))
        return np.concatenate(parts)


def _around(angle):
    return np.mod(angle + np.pi, 2.0 * np.pi) - np.pi


def edge_sinkage(inside: np.ndarray, roller_radius: float, raceway_radius: float, sign: float) -> np.ndarray:
    """How far a roller sinks that has gone a way over an edge, m; `sign` is 1 on the inner raceway, −1 in the outer.

    The edge's rounding is `EDGE_ROUNDING` whatever it is; ways beyond 0.95 of the roller's radius count as that.
    """
    edge, way = roller_radius * (1.0 + EDGE_ROUNDING), np.minimum(inside, 0.95 * roller_radius)
    return edge - np.sqrt(edge**2 - way**2) + sign * (raceway_radius - np.sqrt(raceway_radius**2 - way**2))


@dataclass(frozen=True, kw_only=True, eq=False)
class SinkageMap:
    """Median sinkage around one body."""

    place: Place
    height: np.ndarray  # (n_bins,), m, NaN where not seen; bins begin at angle 0

    @property
    def angle(self) -> np.ndarray:
        """Angles of the bins' middles, rad."""
        return 2.0 * np.pi * (np.arange(self.height.size) + 0.5) / self.height.size

    @property
    def seen(self) -> float:
        return np.mean(np.isfinite(self.height))

    @cached_property
    def deepest(self) -> tuple[float, float]:
        """Angle of the deepest place, rad, and its depth over the rest's; 0 if too little is seen."""
        if not self.seen:
            return 0.0, 0.0
        n, k = self.height.size, np.nanargmax(self.height)
        away = np.abs((np.arange(n) - k + n // 2) % n - n // 2)
        rest = self.height[away > MAP_BESIDE[0] * n + MAP_BESIDE[1] * n / (2.0 * np.pi * self.place.radius)]
        rest = rest[np.isfinite(rest)]
        if rest.size < FEWEST_REST:
            return 0.0, 0.0
        return self.angle[k], self.height[k] / max(np.quantile(rest, REST), LEAST)


def sinkage_maps(motion: RollerMotion, known: Sequence[Spalled] = ()) -> list[SinkageMap]:
    """Maps of every body: rings, then rollers; what `known` spalls explain is taken out, and their places are.

    Smoothed medians by bins around the circumference, of samples at which rollers touch.
    """
    stride, (n_times, n_rollers), places = motion.stride, motion.rho.shape, motion.places()
    thinned = max(1, int(0.5 * BIN / max(motion.travel(places[0]), 1e-9)))
    times = np.arange(stride, n_times - stride, thinned)
    middle, roller = np.repeat(times, n_rollers), np.tile(np.arange(n_rollers), times.size)
    every, sunk, maps = ThreeSamples(motion, middle, roller), {}, []
    missed, probes = every.over(known)[0], {"outer": (motion.outer, 0.0, PROBE), "inner": (motion.inner, PROBE, 0.0)}
    for side, (overlap, *deeper) in probes.items():
        gain, sign = (missed - every.over(known, deeper)[0]) / PROBE, 1.0 if side == "outer" else -1.0
        gain = np.where(np.abs(gain) < LEAST_GAIN, sign * LEAST_GAIN, gain)
        touches = overlap[middle, roller] > -OFF_RACEWAY
        sunk[side] = np.where(touches, np.clip(missed / gain, -MOST, MOST), np.nan)  # m, that explains three samples
    for place in places:
        travel = thinned * motion.travel(place)
        if travel == 0.0:
            continue
        own, column = (slice(None), roller) if place.roller is None else (roller == place.roller, 0)
        angle = np.concatenate([motion.angles(place, side)[middle, column][own] for side in place.sides])
        depth = np.concatenate([sunk[side][own] for side in place.sides])
        n, used = max(SMOOTHED, int(2.0 * np.pi * place.radius / max(BIN, travel))), np.isfinite(depth)
        label = np.minimum((np.mod(angle[used], 2.0 * np.pi) * (n / (2.0 * np.pi))).astype(np.int64), n - 1)
        height, enough = np.full(n, np.nan), np.flatnonzero(np.bincount(label, minlength=n) >= FEWEST_IN_BIN)
        if enough.size:
            height[enough] = median(depth[used], label, enough)
        around = np.stack([np.roll(height, k - SMOOTHED // 2) for k in range(SMOOTHED)])
        there = np.isfinite(around).any(axis=0)
        height[there] = np.nanmedian(around[:, there], axis=0)
        found = SinkageMap(place=place, height=height)
        for at, spalls in known:
            if at == place:
                away = np.abs(_around(found.angle - spalls[0, 0])) * place.radius
                height[away < spalls[0, 1] + MAP_BESIDE[1]] = np.nan
        maps.append(found)
    return maps


class FoundSpall(NamedTuple):
    """A spall with the intervals (95 %) of its place and width."""

    place: Place
    spall: np.ndarray  # (3,): angle of its middle, rad, as `lagrange.surface.faults` counts it; width, m; depth, m
    angle_error: float  # rad
    width_error: float  # m
    stands_out: float  # times the rest of its map
    explained: float  # of what three samples miss there on perfect circles
    passages: int  # that it was matched to
    seen: SinkageMap  # its body's map, before it was found

    @property
    def angle(self) -> float:
        """Angle of its middle, rad."""
        return self.spall[0]

    @property
    def width(self) -> float:
        return self.spall[1]

    @property
    def spalled(self) -> Spalled:
        return self.place, self.spall[None]


class FaultSearch(NamedTuple):
    """Spalls found by a search, the clearest first, and the maps of all bodies."""

    motion: RollerMotion
    maps: list[SinkageMap]  # on perfect circles
    left: list[SinkageMap]  # once all that was found is taken out
    found: tuple[FoundSpall, ...]

    @property
    def says_more(self) -> bool:
        """Whether something stands out that no spall was matched to."""
        return any(m.deepest[1] >= MAP_STANDS_OUT for m in self.left)


def find_faults(record: Record) -> FaultSearch:
    """Search a run's trajectories for spalls.

    A spall that no roller presses on in the run is not seen; the maps show which parts of a body are.
    InputError: the bearing stands, or turns so far from sample to sample that the narrowest spall would not be met.
    """
    motion, found = roller_motion(record), list[FoundSpall]()
    travel = motion.travel(motion.places()[1])
    if motion.operation.fastest == 0.0 or travel == 0.0:
        raise InputError(f"{record.source}: --find-faults: the bearing stands still; rollers pass over nothing")
    if travel > FARTHEST:
        raise InputError(
            f"{record.source}: --find-faults: contacts move {1e3 * travel:.3g} mm from sample to sample, at most "
            f"{1e3 * FARTHEST:g} mm can be distinguished from a spall; store more often (numerics.output_interval_us)"
        )
    maps = left = sinkage_maps(motion)
    while len(found) < MOST_SPALLS:
        known = [each.spalled for each in found]
        suspects = sorted((m for m in left if m.deepest[1] >= MAP_STANDS_OUT), key=lambda m: -m.deepest[1])
        matches = [match for m in suspects[:MOST_SUSPECTS] if (match := _match(motion, m, known)) is not None]
        if not matches:
            break
        found.append(max(matches, key=lambda match: match[0])[1])
        left = sinkage_maps(motion, [each.spalled for each in found])
    again = []  # each made finer with the others known
    for mine in found if len(found) > 1 else ():
        fit = _refined(motion, mine.place, mine.spall, [each.spalled for each in found if each is not mine])
        again.append(mine if fit is None else mine._replace(spall=fit[0], angle_error=fit[1], width_error=fit[2]))
    return FaultSearch(motion, maps, left, tuple(again or found))


class Near:
    """Three samples near a place of a body, by passages, and what is between them and spalls there."""

    def __init__(self, motion: RollerMotion, place: Place, angle: float, half: float, rest: Sequence[Spalled]):
        """As far as `half`, m, on either side of an angle, rad; `rest` : other spalls of the bearing."""
        self.place, self.rest, stride, found = place, rest, motion.stride, []
        for side in place.sides:
            turns = (motion.angles(place, side)[stride:-stride] - angle) / (2.0 * np.pi)
            number = np.round(turns)
            beyond = (turns - number) * (2.0 * np.pi * place.radius)
            at, column = np.nonzero(np.abs(beyond) <= half)
            roller, outside = np.arange(motion.rho.shape[1])[place.rollers][column], np.full(at.size, side == "outer")
            found.append(np.column_stack([at + stride, roller, number[at, column], outside, beyond[at, column]]))
        every = np.concatenate(found)
        every = every[:: max(1, -(-len(every) // MOST_SAMPLES))]
        self.beyond = every[:, 4]  # m, of the contacts from the angle at the middle samples
        whole = every[:, :4].astype(np.int64)
        _, self.passage = np.unique(whole[:, 1:], axis=0, return_inverse=True)
        self.passages = self.passage.max(initial=-1) + 1
        self.samples = ThreeSamples(motion, whole[:, 0], whole[:, 1])

    def misfit(self, spalls: np.ndarray) -> np.ndarray:
        """Misfit with spalls, (n_spalls, n_passages), 0 for a perfect fit.

        Sums of √(1 + z²) − 1, z the mismatch over the usual one: nearly its magnitude, because strikes shake all.
        """
        cost = np.hypot(1.0, self.samples.over([(self.place, spalls), *self.rest]) / UNREST) - 1.0
        return np.stack([np.bincount(self.passage, each, self.passages) for each in cost])


def _match(motion, suspect, rest):
    """The spall that fits a suspect best, and how much of the misfit without it it takes away."""
    place, (angle, ratio) = suspect.place, suspect.deepest
    near = Near(motion, place, angle, 1.2 * WIDTHS[-1], rest)
    if not near.passages:
        return None
    tried = np.array([[(angle + aside * w / place.radius, w, DEEP) for aside in ASIDE] for w in WIDTHS])
    misfit = near.misfit(tried.reshape(-1, 3)).sum(axis=1).reshape(tried.shape[:2])
    starts = tried[np.arange(WIDTHS.size), misfit.argmin(axis=1)][np.argsort(misfit.min(axis=1))[:STARTS]]
    fits = [fit for start in starts if (fit := _refined(motion, place, start, rest)) is not None]
    if not fits:
        return None
    half = max(0.5 * spall[1] + BESIDE + place.radius * abs(spall[0] - angle) for spall, *_ in fits)
    near = Near(motion, place, angle, half, rest)
    *misfits, without = near.misfit(np.array([*(fit[0] for fit in fits), (angle, 0.0, 0.0)])).sum(axis=1)
    best = np.argmin(misfits)
    gain = without - misfits[best]
    if gain <= 0.0:
        return None
    spall, angle_error, width_error = fits[best]
    explained = gain / without
    return gain, FoundSpall(place, spall, angle_error, width_error, ratio, explained, near.passages, suspect)


def _refined(motion, place, spall, rest):
    """A spall's edges and depth made finer step by step; half intervals (95 %) of its angle, rad, and width, m.

    The mismatch of three samples depends on the surface between them: one edge at a time. The intervals are by other
    draws of the passages, and the model's own scatter. None without passages.
    """
    step, moves, edges = FIRST_STEP * spall[1], np.array(sorted(range(-MOVED, MOVED + 1), key=abs)), list[tuple]()
    for ratio in DEPTH_RATIOS:
        near = Near(motion, place, spall[0], 0.5 * spall[1] + MOVED * step + BESIDE, rest)
        if not near.passages:
            break
        edges = []  # spalls with one edge moved, the given one first, and their misfits
        for sign in (-1.0, 1.0):
            widths = np.maximum(spall[1] + sign * step * moves, NARROWEST)
            angles = spall[0] + 0.5 * (moves * step) / place.radius
            grid = np.column_stack([angles, widths, np.full(moves.size, spall[2])])
            edges.append((grid, near.misfit(grid)))
            spall = grid[np.argmin(edges[-1][1].sum(axis=1))]
        if spall[1] > DEPTH_TELLS:
            deeper = spall * np.array([(1.0, 1.0, 1.0), (1.0, 1.0, ratio), (1.0, 1.0, 1.0 / ratio)])
            spall = deeper[np.argmin(near.misfit(deeper).sum(axis=1))]
        step *= FINER
    if not edges:
        return None
    scatter = []  # of either edge, m
    for grid, misfit in edges:
        n = misfit.shape[1]
        draws = np.random.default_rng(0).multinomial(n, np.full(n, 1.0 / n), size=RESAMPLED)
        away = grid[:, 1] - grid[np.argmin(misfit.sum(axis=1)), 1]
        scatter.append(np.sqrt(np.mean(away[np.argmin(draws @ misfit.T, axis=1)] ** 2)))
    apart, of_width = np.hypot(*scatter), MODEL_WIDTH * spall[1]
    angle = SIGMAS * np.hypot(0.5 * apart, np.hypot(MODEL_PLACE, 0.5 * of_width)) / place.radius
    return spall, angle, SIGMAS * np.sqrt(apart**2 + of_width**2 + MODEL_PLACE**2)

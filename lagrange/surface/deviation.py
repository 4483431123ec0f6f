"""Imperfect surfaces as contacts meet them: how far the centres of two bodies come nearer than perfect circles allow.

This sinkage is a smooth periodic function of where on a body the contact lies: a cubic spline, the same for rigid
and elastic bodies, equations and checker. It is subtracted from the overlap of the circles, and its slope turns the
force: all forces stay the gradient of one potential. At the edges of spalls line contacts are softer: a compliance c,
a spline as well, stands in series with the contact's law; balls meet edges with their groove's law. The potential at
a given overlap then changes along a surface by −Q σ' − ½ Q² c': in all that asks for slopes, c adds ½ Q c' to that
of σ.

Equation (2) of docs/surfaces.md.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, inf, pi
from typing import Any, NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.hertz import Pair, contact_pairs
from lagrange.kinematics import kinematics, turned
from lagrange.surface.edges import Circles, Meeting, measured_sinkage, reach, sinkage, softening
from lagrange.surface.faults import Body, Fault, Film, MeasuredSurface, Spall, UnequalRoller, Waviness

KNOTS_PER_SPALL = 200  # along its width; the kink in its middle is rounded within two of them, 0.3 % too low
KNOTS_PER_WAVE = 64  # the spline misses a wave by 1e-7 of its amplitude
FEWEST_KNOTS = 8
FAINT = 1e-13  # m, of a spline's ringing beside spalls
RINGING = 10  # knots beyond a kink after which a spline through it is off by a millionth of what it is at the kink


class BodyDeviation(NamedTuple):
    """What contacts meet along one body, each (..., n_rollers), and its slopes as the angle grows."""

    sinkage: np.ndarray  # m
    slope: np.ndarray  # m/rad
    compliance: np.ndarray | float = 0.0  # m/N
    softening: np.ndarray | float = 0.0  # m/N/rad
    part: "BodyDeviation | None" = None  # what the part of the length that spalls take meets besides; None: nothing


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Sinkages along circles, as periodic cubic B-splines; row 0 of those of rollers is a perfect one's."""

    coefficients: np.ndarray  # (n_rows, n_knots), m; knots equally spaced from angle 0
    compliance: np.ndarray | None  # (n_rows, n_knots), m/N, coefficients of what edges add; None: there are none
    row: np.ndarray  # (n_rollers,), the row that each roller's contact meets
    spacing: float  # m, between knots along the surface
    spalls: tuple[tuple[int | None, float, float], ...] = ()  # roller, middle and half of each, with its edges, rad
    waves: float = inf  # m, between the knots that all but spalls would need; infinite: between spalls circles are
    # perfect
    part: "Profile | None" = None  # on the same knots, of spalls of part of the rollers' length; None: no such

    @property
    def deepest(self) -> float:
        """How far a contact sinks at most, m."""
        return float((self.coefficients if self.part is None else self.coefficients + self.part.coefficients).max())

    def at(self, angle: np.ndarray) -> BodyDeviation:
        """At angles of the rollers' contacts, (..., n_rollers), rad."""
        n = self.coefficients.shape[1]
        place = np.asarray(angle) * (n / (2.0 * pi))
        base = np.floor(place)
        t, first, knot = place - base, self.row * n, base.astype(np.int64)
        near = [first + (knot + k) % n for k in (-1, 0, 1, 2)]
        found = BodyDeviation(*_cubic([self.coefficients.take(at) for at in near], t, 0.5 * n / pi))
        if self.part is not None:
            found = found._replace(part=self.part.at(angle))
        if self.compliance is None:
            return found
        soft = [self.compliance.take(at) for at in near]
        compliance, softening = _cubic(soft, t, 0.5 * n / pi) if np.any(soft) else (0.0, 0.0)
        return found._replace(compliance=compliance, softening=softening)


def _cubic(near: list[np.ndarray], t: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes of a spline between two knots, from the four coefficients nearest; `rate`: of t, 1/rad."""
    c0, c1, c2, c3 = near
    powers = c0 + 4.0 * c1 + c2, 3.0 * (c2 - c0), 3.0 * (c0 - 2.0 * c1 + c2), c3 - c0 + 3.0 * (c1 - c2)
    a, b, c, d = (power / 6.0 for power in powers)
    return a + t * (b + t * (c + t * d)), (b + t * (2.0 * c + t * (3.0 * d))) * rate


@dataclass(frozen=True, kw_only=True)
class Turns:
    """How far bodies have turned since t = 0, rad, and how fast they turn, rad/s, in fixed axes."""

    inner_ring: float | np.ndarray = 0.0
    rollers: float | np.ndarray = 0.0  # about their own axes
    inner_ring_speed: float = 0.0
    roller_speed: float = 0.0
    outer_ring: float | np.ndarray = 0.0
    outer_ring_speed: float = 0.0

    @classmethod
    def rolling(cls, bearing: Bearing, operation: Operation, time) -> "Turns":
        """Of rolling without slip at a time, s."""
        now, way = kinematics(bearing, *operation.at(time).ring_speeds), turned(bearing, operation, time)
        return cls(
            inner_ring=way.shaft, rollers=way.roller, inner_ring_speed=now.shaft, roller_speed=now.roller,
            outer_ring=way.outer_ring, outer_ring_speed=now.outer_ring,
        )  # fmt: skip


UNTURNED = Turns()


class Falls(NamedTuple):
    """By how much a contact's energy falls, over its force, as the part that spalls take sinks and edges soften."""

    part: np.ndarray | float = 0.0  # by the sinkage of the part
    compliance: np.ndarray | float = 0.0  # N, by the compliance of edges across the whole length
    part_compliance: np.ndarray | float = 0.0  # N, by that of the part's


@dataclass(frozen=True, kw_only=True)
class SurfaceDeviation:
    """What the contacts with one raceway meet, and its slopes as the angle grows, (..., n_rollers)."""

    sinkage: np.ndarray  # m, of ring and roller together
    ring_slope: np.ndarray  # m/rad
    roller_slope: np.ndarray
    compliance: np.ndarray | float = 0.0  # m/N, of edges, of ring and roller together; 0.0: no contact is near one
    ring_softening: np.ndarray | float = 0.0  # m/N/rad
    roller_softening: np.ndarray | float = 0.0
    part: "SurfaceDeviation | None" = None  # what the part of the length that spalls take meets besides; None: nothing

    @property
    def slope(self) -> np.ndarray:
        """Of both, m/rad."""
        return self.ring_slope + self.roller_slope

    @property
    def soft(self) -> bool:
        """Whether a contact is near an edge."""
        return not isinstance(self.compliance, float)

    @property
    def part_sinkage(self) -> np.ndarray | float:
        """Of the part of the length that spalls take, beside that of all of it, m."""
        return 0.0 if self.part is None else self.part.sinkage

    def rows(self, which: slice) -> "SurfaceDeviation":
        """Of some of the times alone."""
        part = None if self.part is None else self.part.rows(which)
        own: dict[str, Any] = {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}
        return replace(self, **{name: each[which] for name, each in own.items()}, part=part)

    def at_force(self, force: np.ndarray) -> "SurfaceDeviation":
        """With the slopes that the surfaces have for contacts under these forces, N."""
        if not self.soft:
            return self
        return self.at_contact(Falls(compliance=0.5 * force))

    def at_contact(self, falls: Falls) -> "SurfaceDeviation":
        """With the slopes that the surfaces have for contacts of rollers that tilt, see `Falls`."""
        soft, part = falls.compliance, self.part
        ring, roller = self.ring_slope + soft * self.ring_softening, self.roller_slope + soft * self.roller_softening
        if part is not None:
            share, soft = falls.part, falls.part_compliance
            ring = ring + share * part.ring_slope + soft * part.ring_softening
            roller = roller + share * part.roller_slope + soft * part.roller_softening
        return replace(self, ring_slope=ring, roller_slope=roller)

    def passing(self, ring_speed: float, roller_speed: float) -> np.ndarray:
        """Rate at which contacts close, m/s, because ring and rollers turn on under them at these speeds, rad/s."""
        return ring_speed * self.ring_slope + roller_speed * self.roller_slope


@dataclass(frozen=True, kw_only=True, eq=False)
class Profiles:
    """All surfaces of a bearing; None where they are perfect."""

    inner_ring: Profile | None
    outer_ring: Profile | None
    rollers_inside: Profile | None  # the rollers', where they meet the inner raceway
    rollers_outside: Profile | None

    def inner(self, direction, turns: Turns) -> SurfaceDeviation:
        """At the inner raceway; `direction` from the inner ring's centre to the rollers', (..., n_rollers), rad."""
        return _deviation(
            self.inner_ring, direction - turns.inner_ring, self.rollers_inside, direction + pi - turns.rollers
        )

    def outer(self, direction, turns: Turns) -> SurfaceDeviation:
        """At the outer raceway; `direction` from the outer ring's centre to the rollers', (..., n_rollers), rad."""
        on_ring = direction - turns.outer_ring
        return _deviation(self.outer_ring, on_ring, self.rollers_outside, direction - turns.rollers)

    @property
    def highest(self) -> float:
        """How far a contact may close before the circles touch, m."""
        low = [0.0 if profile is None else profile.coefficients.min() for profile in vars(self).values()]
        return max(0.0, -(min(low[:2]) + min(low[2:])))

    @property
    def deepest(self) -> float:
        """How far a contact may sink below where the circles touch, m."""
        high = [0.0 if profile is None else profile.deepest for profile in vars(self).values()]
        return max(0.0, max(high[:2]) + max(high[2:]))

    @property
    def parts(self) -> tuple[float, float]:
        """How far a part of the length may sink deeper than the rest in inner and outer contacts, m."""
        ring, outer, *rollers = (
            0.0 if profile is None or profile.part is None else float(profile.part.coefficients.max())
            for profile in vars(self).values()
        )
        return ring + rollers[0], outer + rollers[1]

    @property
    def shortest(self) -> float:
        """The least distance between knots, m."""
        return min(profile.spacing for profile in vars(self).values() if profile is not None)

    @property
    def shortest_of_waves(self) -> float:
        """The same of all but spalls; infinite: between these circles are perfect."""
        return min(profile.waves for profile in vars(self).values() if profile is not None)


def _deviation(ring: Profile | None, on_ring, roller: Profile | None, on_roller) -> SurfaceDeviation:
    """Of contacts at angles on the ring and on the rollers, rad."""
    one, other = (
        BodyDeviation(np.zeros_like(angle), np.zeros_like(angle)) if profile is None else profile.at(angle)
        for profile, angle in ((ring, on_ring), (roller, on_roller))
    )
    return _both(one, other)


def _both(one: BodyDeviation, other: BodyDeviation) -> SurfaceDeviation:
    """Of a ring and of rollers together."""
    parts = one.part, other.part
    flat = np.zeros_like(one.sinkage)
    return SurfaceDeviation(
        sinkage=one.sinkage + other.sinkage, ring_slope=one.slope, roller_slope=other.slope,
        compliance=one.compliance + other.compliance, ring_softening=one.softening, roller_softening=other.softening,
        part=None if parts == (None, None) else _both(*(part or BodyDeviation(flat, flat) for part in parts)),
    )  # fmt: skip


@lru_cache(maxsize=16)
def profiles(bearing: Bearing) -> Profiles | None:
    """The surfaces of a bearing; None where all are perfect circles."""
    if not bearing.faults:
        return None
    inside, outside, _ = contact_pairs(bearing)
    return Profiles(
        inner_ring=_profile(bearing, "inner_ring", inside, "outside"),
        outer_ring=_profile(bearing, "outer_ring", outside, "bore"),
        rollers_inside=_profile(bearing, "roller", inside, "outside"),
        rollers_outside=_profile(bearing, "roller", outside, "in_bore"),
    )


def _profile(bearing: Bearing, body: Body, pair: Pair, meeting: Meeting) -> Profile | None:
    faults = [fault for fault in bearing.faults if fault.body == body]
    if not faults:
        return None
    raceway, roller = abs(pair.radii[0]), bearing.element_radius
    own, other = (roller, raceway) if body == "roller" else (raceway, roller)
    circles = Circles(own, other, meeting, roller)
    n = max([FEWEST_KNOTS, *(_knots(fault, circles) for fault in faults)])
    rollers = sorted({fault.roller for fault in faults if fault.roller is not None})
    rows = [[fault for fault in faults if fault.roller == number] for number in (None, *rollers)]
    row = np.zeros(bearing.n_rollers, dtype=np.int64)
    for k, number in enumerate(rollers, 1):
        row[number] = k
    parted = [f for f in faults if isinstance(f, Spall) and f.is_part(bearing)]
    whole, parts = ([[f for f in some if (f in parted) is wanted] for some in rows] for wanted in (False, True))
    smooth = [_knots(fault, circles) for fault in faults if not isinstance(fault, Spall)]

    def half(spall: Spall) -> float:  # from its middle to where contacts are sound, rad
        return max(float(np.arcsin(spall.half_opening(circles.roller) / circles.own)), reach(spall, circles))

    def profile(rows: list[list[Fault]], part: Profile | None = None) -> Profile:
        compliance, spalled = None, any(isinstance(fault, Spall) for some in rows for fault in some)
        if spalled and not isinstance(bearing, BallBearing):
            softer = [_softening(some, circles, n) for some in rows]
            compliance = _spline(pair.line_compliance * np.array(softer))
        return Profile(
            coefficients=_spline(np.array([_sinkages(some, circles, n) for some in rows])),
            compliance=compliance,
            row=row,
            spacing=2.0 * pi * own / n,
            spalls=tuple(
                (fault.roller, fault.angle, half(fault) + RINGING * 2.0 * pi / n)
                for fault in faults
                if isinstance(fault, Spall)
            ),
            waves=2.0 * pi * own / max(FEWEST_KNOTS, *smooth) if smooth else inf,
            part=part,
        )

    if not any(parts):
        return profile(whole)
    part = profile(parts)  # off spalls exactly nothing: contacts there look no more up
    clean = np.where(np.abs(part.coefficients) > FAINT, part.coefficients, 0.0)
    return profile(whole, replace(part, coefficients=clean))


def _knots(fault: Fault, circles: Circles) -> int:
    """Knots around the circle that a fault needs."""
    if isinstance(fault, Spall):
        return ceil(2.0 * pi * circles.own * KNOTS_PER_SPALL / fault.width)
    if isinstance(fault, MeasuredSurface):
        return circles.points_around
    return KNOTS_PER_WAVE * fault.order if isinstance(fault, Waviness) else FEWEST_KNOTS


def _sinkages(faults: list[Fault], circles: Circles, n: int) -> np.ndarray:
    """At the knots, (n,), m."""
    angle = 2.0 * pi * np.arange(n) / n
    found = np.zeros(n)
    for fault in faults:
        if isinstance(fault, UnequalRoller):
            found -= 0.5 * fault.diameter_deviation
        elif isinstance(fault, Waviness):
            found -= fault.amplitude * np.cos(fault.order * angle + fault.phase)
        elif isinstance(fault, Film):
            found -= fault.thickness
        elif isinstance(fault, MeasuredSurface):
            found += measured_sinkage(fault, circles, n)
        else:
            beyond, over = _near(fault, angle, np.arcsin(fault.half_opening(circles.roller) / circles.own))
            found[over] += sinkage(fault, circles, beyond[over])
    return found


def _softening(faults: list[Fault], circles: Circles, n: int) -> np.ndarray:
    """ΔB at the knots, (n,), by the edges of spalls."""
    angle = 2.0 * pi * np.arange(n) / n
    found = np.zeros(n)
    for fault in faults:
        if isinstance(fault, Spall):
            beyond, over = _near(fault, angle, reach(fault, circles))
            found[over] += softening(fault, circles, beyond[over])
    return found


def _near(spall: Spall, angle: np.ndarray, within: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the spall's middle, (n,), rad, and the indices of those that are within an angle of it."""
    beyond = np.mod(angle - spall.angle + pi, 2.0 * pi) - pi
    return beyond, np.flatnonzero(np.abs(beyond) < within)


def _spline(samples: np.ndarray) -> np.ndarray:
    """Coefficients of the periodic cubic B-splines through equally spaced samples, along the last axis."""
    n = samples.shape[-1]
    wave = 2.0 * pi * np.fft.rfftfreq(n)
    return np.fft.irfft(np.fft.rfft(samples) * 3.0 / (2.0 + np.cos(wave)), n=n)

"""Imperfect surfaces as contacts meet them: how far the centres of two bodies come nearer than perfect circles allow.

This sinkage is a smooth periodic function of where on a body the contact lies: a cubic spline, the same for rigid and
elastic bodies, equations and checker. It is subtracted from the overlap of the circles, and its slope turns the force:
all forces stay the gradient of one potential. At the edges of spalls line contacts are softer: a compliance c, a spline
as well, stands in series with the contact's law; balls meet edges with their groove's law. The potential at a given
overlap then changes along a surface by −Q σ' − ½ Q² c': in all that asks for slopes, c adds ½ Q c' to that of σ.

Equation (2) of docs/surfaces.md.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, inf, pi
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import kinematics, turned
from lagrange.surface import edges
from lagrange.surface.faults import Film, MeasuredSurface, Spall, UnequalRoller, Waviness

KNOTS_PER_SPALL = 200  # along its width; the kink in its middle is rounded within two of them, 0.3 % too low
KNOTS_PER_WAVE = 64  # the spline misses a wave by 1e-7 of its amplitude
FEWEST_KNOTS = 8
FAINT = 1e-13  # m, of a spline's ringing beside spalls
RINGING = 10  # knots beyond a kink after which a spline through it is off by a millionth of what it is at the kink


class Falls(NamedTuple):
    """By how much a contact's energy falls, over its force, as the part that spalls take sinks and edges soften."""

    part: ndarray | float = 0.0  # by the sinkage of the part
    compliance: ndarray | float = 0.0  # N, by the compliance of edges across the whole length
    part_compliance: ndarray | float = 0.0  # N, by that of the part's


class SurfaceDeviation(NamedTuple):
    """What the contacts with one raceway meet, (..., n_rollers), of ring and roller together."""

    sinkage: ndarray  # m
    slopes: ndarray  # (2, ..., n_rollers), m/rad, as the angle on ring and on roller grows
    softenings: ndarray  # the same of the compliance, m/N/rad
    compliance: ndarray | float  # m/N, of edges; 0.0: no contact is near one
    part: "SurfaceDeviation | None" = None  # what the part of the length that spalls take meets besides; None: nothing

    @property
    def slope(self) -> ndarray:
        """Of both, m/rad."""
        return self.slopes[0] + self.slopes[1]

    @property
    def soft(self) -> bool:
        """Whether a contact is near an edge."""
        return not isinstance(self.compliance, float)

    @property
    def part_sinkage(self) -> ndarray | float:
        """Of the part of the length that spalls take, beside that of all of it, m."""
        return 0.0 if self.part is None else self.part.sinkage

    def rows(self, which: slice) -> "SurfaceDeviation":
        """Of some of the times alone."""
        return SurfaceDeviation(sinkage=self.sinkage[which], slopes=self.slopes[:, which],
            softenings=self.softenings[:, which], compliance=self.compliance if isinstance(self.compliance, float)
            else self.compliance[which], part=None if self.part is None else self.part.rows(which))  # fmt: skip

    def at_contact(self, falls: Falls) -> "SurfaceDeviation":
        """With the slopes that the surfaces have for contacts, see `Falls`; without tilt by ½ Q of the compliance."""
        slopes, part = self.slopes + falls.compliance * self.softenings, self.part
        if part is not None:
            slopes = slopes + falls.part * part.slopes + falls.part_compliance * part.softenings
        return self._replace(slopes=slopes)

    def passing(self, ring_speed: float, roller_speed: float) -> ndarray:
        """Rate at which contacts close, m/s, because ring and rollers turn on under them at these speeds, rad/s."""
        return ring_speed * self.slopes[0] + roller_speed * self.slopes[1]


class Profile(NamedTuple):
    """Sinkages along circles, as periodic cubic B-splines; row 0 of those of rollers is a perfect one's."""

    coefficients: ndarray  # (n_rows, n_knots), m; knots equally spaced from angle 0
    compliance: ndarray | None  # (n_rows, n_knots), m/N, coefficients of what edges add; None: there are none
    row: ndarray  # (n_rollers,), the row that each roller's contact meets
    spacing: float  # m, between knots along the surface
    spalls: tuple[tuple[int | None, float, float], ...] = ()  # roller, middle and half of each, with its edges, rad
    waves: float = inf  # m, between the knots that all but spalls would need; infinite: between spalls circles are
    # perfect
    part: "Profile | None" = None  # on the same knots, of spalls of part of the rollers' length; None: no such

    def at(self, angle: ndarray) -> tuple:
        """Sinkage, its slope, compliance and its slope at angles of the rollers' contacts, (..., n_rollers), rad."""
        n = self.coefficients.shape[1]
        place = np.asarray(angle) * (n / (2.0 * pi))
        base = np.floor(place)
        t, first, knot = place - base, self.row * n, base.astype(np.int64)
        near, rate = [first + (knot + k) % n for k in (-1, 0, 1, 2)], 0.5 * n / pi
        soft = [] if self.compliance is None else [self.compliance.take(at) for at in near]
        found = _cubic([self.coefficients.take(at) for at in near], t, rate)
        return *found, *(_cubic(soft, t, rate) if np.any(soft) else (0.0, 0.0))


def _cubic(near, t, rate):
    """Values and slopes of a spline between two knots, from the four coefficients nearest; `rate`: of t, 1/rad."""
    c0, c1, c2, c3 = near
    powers = c0 + 4.0 * c1 + c2, 3.0 * (c2 - c0), 3.0 * (c0 - 2.0 * c1 + c2), c3 - c0 + 3.0 * (c1 - c2)
    a, b, c, d = (power / 6.0 for power in powers)
    return a + t * (b + t * (c + t * d)), (b + t * (2.0 * c + t * (3.0 * d))) * rate


@dataclass(frozen=True, kw_only=True)
class Turns:
    """How far bodies have turned since t = 0, rad, and how fast they turn, rad/s, in fixed axes."""

    inner_ring: float | ndarray = 0.0
    rollers: float | ndarray = 0.0  # about their own axes
    inner_ring_speed: float = 0.0
    roller_speed: float = 0.0
    outer_ring: float | ndarray = 0.0
    outer_ring_speed: float = 0.0

    @classmethod
    def rolling(cls, bearing: Bearing, operation: Operation, time) -> "Turns":
        """Of rolling without slip at a time, s."""
        now, way = kinematics(bearing, *operation.at(time).ring_speeds), turned(bearing, operation, time)
        return cls(inner_ring=way.shaft, rollers=way.roller, inner_ring_speed=now.shaft, roller_speed=now.roller,
            outer_ring=way.outer_ring, outer_ring_speed=now.outer_ring)  # fmt: skip


UNTURNED = Turns()


class Profiles(NamedTuple):
    """All surfaces of a bearing; None where they are perfect."""

    inner_ring: Profile | None
    outer_ring: Profile | None
    rollers_inside: Profile | None  # the rollers', where they meet the inner raceway
    rollers_outside: Profile | None

    def inner(self, direction, turns: Turns) -> SurfaceDeviation:
        """At the inner raceway; `direction` from the inner ring's centre to the rollers', (..., n_rollers), rad."""
        angles = direction - turns.inner_ring, direction + pi - turns.rollers
        return _deviation((self.inner_ring, self.rollers_inside), angles)

    def outer(self, direction, turns: Turns) -> SurfaceDeviation:
        """At the outer raceway; `direction` from the outer ring's centre to the rollers', (..., n_rollers), rad."""
        angles = direction - turns.outer_ring, direction - turns.rollers
        return _deviation((self.outer_ring, self.rollers_outside), angles)

    @property
    def highest(self) -> float:
        """How far a contact may close before the circles touch, m."""
        low = [0.0 if profile is None else profile.coefficients.min() for profile in self]
        return max(0.0, -(min(low[:2]) + min(low[2:])))

    @property
    def deepest(self) -> float:
        """How far a contact may sink below where the circles touch, m."""
        high = [0.0 if p is None else (p.coefficients if p.part is None else p.coefficients + p.part.coefficients).max()
                for p in self]  # fmt: skip
        return max(0.0, float(max(high[:2]) + max(high[2:])))

    @property
    def shortest(self) -> float:
        """The least distance between knots, m."""
        return min(profile.spacing for profile in self if profile is not None)

    @property
    def shortest_of_waves(self) -> float:
        """The same of all but spalls; infinite: between these circles are perfect."""
        return min(profile.waves for profile in self if profile is not None)


def _deviation(bodies, angles):
    """Of contacts at angles on the ring and on the rollers, rad."""
    flat = np.zeros(np.broadcast_shapes(*map(np.shape, angles)))
    pairs = zip(bodies, angles, strict=True)
    each = [(flat, flat, 0.0, 0.0) if profile is None else profile.at(angle) for profile, angle in pairs]
    sinkage, slopes, compliance, softenings = zip(*each, strict=True)
    parts = tuple(None if profile is None else profile.part for profile in bodies)
    return SurfaceDeviation(sinkage=sinkage[0] + sinkage[1], slopes=np.array(np.broadcast_arrays(*slopes)),
        compliance=compliance[0] + compliance[1], softenings=np.array(np.broadcast_arrays(*softenings, flat)[:2]),
        part=None if parts == (None, None) else _deviation(parts, angles))  # fmt: skip


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


def _profile(bearing, body, pair, meeting):
    faults = [fault for fault in bearing.faults if fault.body == body]
    if not faults:
        return None
    own, other = abs(pair.radii[0]), bearing.element_radius
    if body == "roller":
        own, other = other, own
    circles = edges.Circles(own, other, meeting, bearing.element_radius)
    needed = [_knots(fault, circles) for fault in faults]
    smooth = [_knots(fault, circles) for fault in faults if not isinstance(fault, Spall)]
    n, spalls = max(FEWEST_KNOTS, *needed), [fault for fault in faults if isinstance(fault, Spall)]
    rollers = sorted({fault.roller for fault in faults if fault.roller is not None})
    row = np.zeros(bearing.n_rollers, dtype=np.int64)
    row[rollers] = np.arange(1, len(rollers) + 1)
    of_part = [spall for spall in spalls if spall.is_part(bearing)]

    def half(spall):  # from its middle to where contacts are sound, rad
        return max(circles.half_angle(spall), edges.reach(spall, circles)) + RINGING * 2.0 * pi / n

    def profile(taken, part=None):
        soft = any(isinstance(fault, Spall) for fault in taken) and not isinstance(bearing, BallBearing)
        rows = [[fault for fault in taken if fault.roller == number] for number in (None, *rollers)]
        sunk, softer = np.swapaxes([_along(some, circles, n, soft) for some in rows], 0, 1)
        return Profile(
            coefficients=_spline(sunk), compliance=_spline(pair.line_compliance * softer) if soft else None, row=row,
            spacing=2.0 * pi * own / n, spalls=tuple((spall.roller, spall.angle, half(spall)) for spall in spalls),
            waves=2.0 * pi * own / max(FEWEST_KNOTS, *smooth) if smooth else inf, part=part)  # fmt: skip

    if not of_part:
        return profile(faults)
    part = profile(of_part)  # off spalls exactly nothing: contacts there look no more up
    clean = np.where(np.abs(part.coefficients) > FAINT, part.coefficients, 0.0)
    return profile([fault for fault in faults if fault not in of_part], part._replace(coefficients=clean))


def _knots(fault, circles):
    """Knots around the circle that a fault needs."""
    if isinstance(fault, Spall):
        return ceil(2.0 * pi * circles.own * KNOTS_PER_SPALL / fault.width)
    if isinstance(fault, MeasuredSurface):
        return circles.points_around
    return KNOTS_PER_WAVE * fault.order if isinstance(fault, Waviness) else FEWEST_KNOTS


def _along(faults, circles, n, soft):
    """Sinkage, m, and where contacts are `soft` at edges ΔB, at the knots, (2, n)."""
    angle, found = 2.0 * pi * np.arange(n) / n, np.zeros((2, n))
    sunk, softer = found
    for fault in faults:
        if isinstance(fault, UnequalRoller):
            sunk -= 0.5 * fault.diameter_deviation
        elif isinstance(fault, Waviness):
            sunk -= fault.amplitude * np.cos(fault.order * angle + fault.phase)
        elif isinstance(fault, Film):
            sunk -= fault.thickness
        elif isinstance(fault, MeasuredSurface):
            sunk += edges.measured_sinkage(fault, circles, n)
        else:
            beyond = np.mod(angle - fault.angle + pi, 2.0 * pi) - pi
            over = np.flatnonzero(np.abs(beyond) < circles.half_angle(fault))
            sunk[over] += edges.sinkage(fault, circles, beyond[over])
            if soft:
                over = np.flatnonzero(np.abs(beyond) < edges.reach(fault, circles))
                softer[over] += edges.softening(fault, circles, beyond[over])
    return found


def _spline(samples):
    """Coefficients of the periodic cubic B-splines through equally spaced samples, along the last axis."""
    from scipy.ndimage import spline_filter1d

    return spline_filter1d(samples, mode="grid-wrap")

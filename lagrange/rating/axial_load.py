"""Rows of rolling elements under radial load, axial load and tilting moment at rest; rigid rings. N, mm, rad.

The hub is displaced by x, y (against the load) and z (along the shaft), and tilts by small angles about x and y; a
positive tilt about x moves its +z end towards the load. An equilibrium is the minimum of a convex energy, whose
gradient is what the rows carry, whose second derivative is their stiffness.

* Balls: Hertz' contacts in series between the centres of two grooves, which are A = (f_i + f_o − 1) D apart where
  nothing bears; each ball has its own contact angle.
* Rollers: laminae of ISO/TS 16281 on the line of contact, at right angles to the contact angle.
* Cylindrical rollers between two flanges: a rigid flange tilts the rollers that it meets by its own axial displacement
  over the arm of both flanges' forces, until the laminae at both raceways bear that couple.

Tilts move the contacts of balls at half the pitch diameter, as the standard's moment has it, and not at the centres of
the inner groove, 1 % farther out. Left out: centrifugal forces and gyroscopic moments of balls, the rib of
tapered rollers.

Source: ISO/TS 16281:2008; Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 7.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, sin, tan
from typing import Any, NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.bearing import BallBearing, Bearing, RowLoads
from lagrange.contact.laws import ContactLaws, PowerLaw
from lagrange.errors import exceeds
from lagrange.kinematics import roller_angles
from lagrange.rating.life import Dimensions
from lagrange.rating.reference_life import LAMINAE, laminae_of
from lagrange.rating.sources import Unavailable

STEPS = 400  # of Newton's method; ten are usual
LONGEST_STEP, FARTHEST = 0.02, 1.0  # of an element's diameter: one step, and the hub's way
SETTLED, NEAREST = 1e-11, 1e-15  # of the load left, and of a step over a diameter, where it ends
LOOSE = 1e-10  # of the stiffness, in directions in which nothing bears
OVERSHOOT = 0.9  # of the load along a step, that may act against it at its end


class Reaction(NamedTuple):
    """What rows do at a place of the hub; elements, (n,), rollers in laminae."""

    energy: float  # N mm
    force: ndarray  # (5,), N and N mm, that holds the hub there
    stiffness: ndarray  # (5, 5)
    inner: ndarray  # (n,) or (n, laminae), N
    outer: ndarray
    angle: ndarray  # (n,), rad, of contact; 0 without load

    @property
    def loads(self) -> ndarray:
        """Of elements, (n,), N."""
        return self.inner if self.inner.ndim == 1 else self.inner.sum(axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Row:
    """What rows of balls and of rollers have in common."""

    place: ndarray  # (n,), of the elements, rad from +x
    diameter: float  # of an element
    pitch: float  # radius
    angle: float  # nominal contact angle
    law: PowerLaw  # of both contacts together, over the whole length
    gap: float  # between element and raceway along the contact, hub in the middle: half the clearance times cos α
    side: int = 1  # sign of the axial displacement that closes it
    middle: float = 0.0  # z
    shift: float = 0.0  # of the inner ring towards closing, by preload

    def motion(self, radius: float | ndarray, axial: float | ndarray) -> ndarray:
        """Displacements, outwards and towards closing, of points of the hub by its own, (n, points, 2, 5)."""
        cosine, sine = np.cos(self.place)[:, None], np.sin(self.place)[:, None]
        radius, axial = np.atleast_1d(radius), np.atleast_1d(axial)
        found = np.zeros((self.place.size, max(radius.size, axial.size), 2, 5))
        found[:, :, 0, 0], found[:, :, 0, 1], found[:, :, 1, 2] = cosine, sine, self.side
        found[:, :, 0, 3], found[:, :, 0, 4] = -axial * sine, axial * cosine
        found[:, :, 1, 3], found[:, :, 1, 4] = self.side * radius * sine, -self.side * radius * cosine
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class BallRow(Row):
    """Balls in grooves."""

    span: float  # A

    def at(self, hub: ndarray) -> Reaction:
        motion, start = self.motion(self.pitch, self.middle)[:, 0], self.span - self.gap
        across = motion @ hub + [start * cos(self.angle), start * sin(self.angle) + self.shift]
        length = np.hypot(*across.T)
        normal = across / length[:, None]
        rate = np.einsum("kd,kdi->ki", normal, motion)
        turn = normal[:, :1] * motion[:, 1] - normal[:, 1:] * motion[:, 0]
        met = self.law.at(length - self.span)
        stiffness = rate.T @ (met.stiffness[:, None] * rate) + turn.T @ ((met.force / length)[:, None] * turn)
        angle = np.where(met.force > 0.0, self.side * np.arctan2(normal[:, 1], normal[:, 0]), 0.0)
        return Reaction(met.energy.sum(), met.force @ rate, stiffness, met.force, met.force, angle)


@dataclass(frozen=True, kw_only=True, eq=False)
class RollerRow(Row):
    """Rollers in laminae."""

    along: ndarray  # (laminae,), of their middles from the roller's
    drop: ndarray  # (laminae,), of both contacts together

    @property
    def lamina_law(self) -> PowerLaw:
        return replace(self.law, stiffness=self.law.stiffness / self.along.size)

    def at(self, hub: ndarray) -> Reaction:
        normal = np.array([cos(self.angle), sin(self.angle)])
        motion = self.motion(self.pitch - self.along * normal[1], self.middle + self.side * self.along * normal[0])
        rate = np.einsum("d,jkdi->jki", normal, motion)
        met = self.lamina_law.at(rate @ hub + self.shift * normal[1] - self.gap - self.drop)
        stiffness = np.einsum("jk,jki,jkl->il", met.stiffness, rate, rate, optimize=True)
        angle = np.where(met.force.any(axis=1), self.side * self.angle, 0.0)
        force = np.einsum("jk,jki->i", met.force, rate)
        return Reaction(met.energy.sum(), force, stiffness, met.force, met.force, angle)


@dataclass(frozen=True, kw_only=True, eq=False)
class FlangedRow(RollerRow):
    """Cylindrical rollers between flanges of both rings."""

    arm: float  # radial, between the forces of both rings' flanges

    def at(self, hub: ndarray) -> Reaction:
        """A roller is moved outwards by t, tilted by g: its laminae approach d_i = δ + x ψ − t − x g, d_o = t + x g.

        Half of the law's approach is either contact's. t balances the roller; g is half the hub's slope ψ, where the
        hub's flange meets the roller its axial displacement over the arm.
        """
        x, half = self.along, 0.5 * self.drop
        law = replace(self.lamina_law, stiffness=self.lamina_law.stiffness * 2.0**self.law.exponent)
        outwards, closing = np.moveaxis(self.motion(self.pitch, self.middle)[:, 0], 1, 0)
        slope = self.motion(self.pitch, 1.0)[:, 0, 0] - self.motion(self.pitch, 0.0)[:, 0, 0]
        tilt = np.where((closing @ hub > 0.5 * self.arm * slope @ hub)[:, None], closing / self.arm, 0.5 * slope)
        rates = np.stack([outwards, slope, tilt])
        (delta, psi, g), parts = rates @ hub, np.stack([np.ones(x.size), x, -x])
        delta = delta - self.gap
        t = 0.5 * delta
        for _ in range(STEPS):
            outer = law.at((t + np.outer(x, g)).T - half)
            inner = law.at((delta - t + np.outer(x, psi - g)).T - half)
            whole = np.maximum((inner.stiffness + outer.stiffness).sum(axis=1), np.finfo(float).tiny)
            step = (inner.force - outer.force).sum(axis=1) / whole
            t = t + step
            if np.all(np.abs(step) <= NEAREST * self.diameter):
                break
        force = np.stack([inner.force.sum(axis=1), inner.force @ x, (outer.force - inner.force) @ x])
        follow = np.stack([inner.stiffness @ part for part in parts])  # of t: it balances the roller
        follow[2] -= outer.stiffness @ x
        second = np.einsum("ak,bk,jk->abj", parts, parts, inner.stiffness)
        second[2, 2] += outer.stiffness @ x**2
        second -= follow[:, None] * follow / whole
        stiffness = np.einsum("abj,aji,bjl->il", second, rates, rates, optimize=True)
        energy = inner.energy.sum() + outer.energy.sum()
        force = np.einsum("aj,aji->i", force, rates)
        return Reaction(energy, force, stiffness, inner.force, outer.force, np.zeros(t.size))


class Balance(NamedTuple):
    """An equilibrium."""

    hub: ndarray  # (5,), mm and rad: x, y, z, tilts about x and y
    rows: tuple[Reaction, ...]
    kept: ndarray  # directions, ascending, in which the hub is free

    @property
    def force(self) -> ndarray:
        """(5,), N and N mm, that holds the hub: loads, and reactions of held directions."""
        return np.sum([row.force for row in self.rows], axis=0)

    @property
    def stiffness(self) -> ndarray:
        """(5, 5), N/mm, N, N mm."""
        return np.sum([row.stiffness for row in self.rows], axis=0)

    def condensed(self, *directions: int) -> ndarray:
        """Stiffness in some directions, N/mm, N, N mm, the hub's other free ones in balance."""
        these, others = list(directions), np.setdiff1d(self.kept, directions)
        along = self.stiffness[:, these]
        follow = np.linalg.lstsq(self.stiffness[np.ix_(others, others)], along[others])[0]
        return along[these] - along[others].T @ follow


def balanced(rows: Sequence[BallRow | RollerRow], load: ndarray, free: Sequence[bool], start: ndarray) -> Balance:
    """The hub under a load, (5,), N and N mm, where it is free, (5,); elsewhere it stays at the start, (5,).

    Newton's method on a convex energy, with short steps where nothing bears. Unavailable: the hub runs away.
    """
    diameter, kept = rows[0].diameter, np.flatnonzero(free)
    unit = np.array([1.0, 1.0, 1.0, 1.0 / rows[0].pitch, 1.0 / rows[0].pitch])[kept]  # tilts as lengths
    size = float(np.max(np.abs(unit * load[kept]))) or 1.0
    found = Balance(start, tuple(row.at(start) for row in rows), kept)
    for _ in range(STEPS):
        left = unit * (load - found.force)[kept]
        if np.max(np.abs(left)) <= SETTLED * size:
            return found
        stiffness = unit[:, None] * found.stiffness[np.ix_(kept, kept)] * unit
        stiffness += LOOSE * (np.trace(stiffness) + size / diameter) * np.eye(kept.size)
        step = np.linalg.solve(stiffness, left)
        step *= min(1.0, LONGEST_STEP * diameter / np.max(np.abs(step)))
        while True:
            hub = found.hub.copy()
            hub[kept] += unit * step
            here = Balance(hub, tuple(row.at(hub) for row in rows), kept)
            against = unit * (load - here.force)[kept] @ step
            if against >= -OVERSHOOT * (left @ step) or np.max(np.abs(step)) <= NEAREST * diameter:
                break
            step *= 0.5
        found = here
        if np.max(np.abs(hub[kept] - start[kept]) / unit) > FARTHEST * diameter:
            raise Unavailable("the row does not hold the hub: it runs away along the load")
        if np.max(np.abs(step)) <= NEAREST * diameter:
            return found
    raise Unavailable(f"no equilibrium within {STEPS} steps")


class LaminaLoads(NamedTuple):
    """Loads of laminae, (n_rollers, n_laminae), N, under which rigid rings are in equilibrium."""

    loads: ndarray
    displacement: float  # δ_r, mm
    moment: float  # that holds the tilt, N mm

    @property
    def of_rollers(self) -> ndarray:
        """(n_rollers,), N."""
        return self.loads.sum(axis=1)


def rigid_loads(
    row: Dimensions, load: float, clearance=0.0, tilt=0.0, *, profile=True, laminae=LAMINAE, first=0.0
) -> LaminaLoads:
    """Load distribution of ISO/TS 16281 (38) to (46): rigid rings, a radial load, N, and a prescribed tilt, rad.

    load, clearance : of one row's section: F_r/(i cos α), N; s cos α, diametral, mm
    profile : of `laminae_of`
    first : rad, of roller 0 from the load
    """
    place = first - 0.5 * np.pi + 2.0 * np.pi * np.arange(row.rollers) / row.rollers
    slices: Any = laminae_of(row, profile, laminae)
    one = RollerRow(place=place, diameter=row.diameter, pitch=0.5 * row.pitch, angle=0.0, law=slices.law,
                    gap=0.5 * clearance, along=slices.place, drop=slices.drop)  # fmt: skip
    found = balanced([one], np.array([0.0, -load, 0.0, 0.0, 0.0]), [False, True, False, False, False],
                     np.array([0.0, 0.0, 0.0, tilt, 0.0]))  # fmt: skip
    return LaminaLoads(found.rows[0].inner, -float(found.hub[1]), float(found.force[3]))


def rows_of(
    bearing: Bearing, given: RowLoads, laws: ContactLaws, place: ndarray, drop: ndarray | bool = True
) -> list[BallRow | RollerRow]:
    """Of a bearing whose elements are at angles from +x, (n,), rad: one for each of its rows.

    laws : of balls; rollers have the standard's, with `drop` as `laminae_of` takes it
    """
    diameter, height = 2e3 * bearing.element_radius, 1e3 * (given.flange_height or 0.0)
    same: dict[str, Any] = {"place": place, "diameter": diameter, "pitch": 1e3 * bearing.pitch_radius,
        "angle": bearing.contact_angle, "gap": 1e3 * bearing.radial_clearance,
        "side": -1 if given.axial_load < 0.0 else 1}  # fmt: skip
    row: BallRow | RollerRow
    if isinstance(bearing, BallBearing):
        inner, outer = laws
        assert isinstance(inner, PowerLaw)
        assert isinstance(outer, PowerLaw)
        n, span = inner.exponent, 1e3 * (bearing.inner_groove_radius + bearing.outer_groove_radius) - diameter
        both = (inner.stiffness ** (-1.0 / n) + outer.stiffness ** (-1.0 / n)) ** -n
        law = replace(inner, stiffness=both * 1e-3**n)
        if not exceeds(span, same["gap"]):
            raise Unavailable("the clearance is as wide as the grooves are apart: balls reach their edges")
        row = BallRow(**same, law=law, span=span)
    else:
        slices = laminae_of(Dimensions.of(bearing), drop)
        same |= {"law": slices.law, "along": slices.place, "drop": slices.drop}
        flanged = height > 0.0 and given.axial_load != 0.0
        row = FlangedRow(**same, arm=diameter - height) if flanged else RollerRow(**same)
    if given.arrangement is None:
        return [row] * bearing.rows
    thrust = np.array([0.0, 0.0, row.side * given.preload, 0.0, 0.0])
    shift = row.side * balanced([row], thrust, [False, False, True, False, False], np.zeros(5)).hub[2]
    ends = (-1, 1) if given.arrangement == "back_to_back" else (1, -1)
    far = 0.5e3 * given.row_distance
    return [replace(row, side=side, middle=end * far, shift=shift) for side, end in zip((1, -1), ends, strict=True)]


def at_rest(
    bearing: Bearing, force: ndarray, given: RowLoads, laws: ContactLaws, first_roller_angle: float,
    drop: ndarray | bool = True,
) -> Balance:  # fmt: skip
    """The hub of a bearing under a force in x and y, (2,), N; without axial load a row at a contact angle is held.

    Unavailable: its rows carry no such load.
    """
    rows = rows_of(bearing, given, laws, roller_angles(bearing, first_roller_angle), drop)
    angle, tilts = bearing.contact_angle, given.moment is not None
    grooves = isinstance(bearing, BallBearing) and angle == 0.0
    slides = grooves or given.arrangement is not None or given.axial_load != 0.0
    load = np.array([*force, given.axial_load, 1e3 * (given.moment or 0.0), 0.0])
    try:
        found = balanced(rows, load, [True, True, slides, tilts, tilts], np.array([0.0, 0.0, 0.0, given.tilt, 0.0]))
        if angle == 0.0 or all((row.side * one.angle >= 0.0).all() for row, one in zip(rows, found.rows, strict=True)):
            return found
    except Unavailable:
        if angle == 0.0:
            raise
    radial, slides_open = float(np.hypot(*force)), f"at {bearing.contact_angle_deg:.4g}° a row slides open"
    if given.arrangement is not None or exceeds(abs(given.axial_load), radial * tan(angle)):
        raise Unavailable(f"{slides_open} under this tilt or moment; raise the axial load or the preload")
    least = f"{radial:.0f} N of radial load need {radial * tan(angle):.0f} N of axial load at least"
    raise Unavailable(f"{slides_open}: {least}; raise it, or give bearing.arrangement with rows = 2")

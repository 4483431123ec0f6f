"""Static equilibrium of hub and rolling elements at given angles, rigid rings, by Newton's method.

Each element's radius ρ is eliminated: at a given hub position its radial balance has one root. The equilibrium is
the least of a potential of the hub's two coordinates, found by Newton's method with a line search.
"""

from dataclasses import dataclass, replace

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.contact.laws import ContactLaws
from lagrange.equations import nothing_carries, touching_distances
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.deviation import UNTURNED, Turns, profiles
from lagrange.surface.edges import pressed, softened

BALANCE = 1e-10  # of load and contact forces: what Newton's method must reach
MAX_NEWTON = 200
MAX_RADIAL = 100
ROUND_OFF = 4e-16  # of a radius: two units in its last place
SOFTEST = 1e-6  # smallest curvature in use, of the stiffest direction of one contact


@dataclass(frozen=True, kw_only=True)
class Statics:
    """An equilibrium; m, rad, N; arrays (n_rollers,)."""

    x: float  # centre of the inner ring
    y: float
    rho: np.ndarray
    theta: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    stiffness: np.ndarray  # (2, 2), N/m, of the hub's place as elements follow it; negative across what it balances on


def static_equilibrium(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    *,
    angles: np.ndarray | None = None,
    roller_mass: float | None = None,
    start: tuple[float, float] | None = None,
    turns: Turns = UNTURNED,
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0),
) -> Statics:
    """Equilibrium under load, weights and the elements' centrifugal force at cage speed.

    Parameters
    ----------
    angles : (n_rollers,), rad; default: equally spaced from the operation's first angle
    roller_mass : kg; default: the bearing's; 0 leaves out the elements' weight and centrifugal force
    start : hub position to begin from, m
    turns : of ring and rollers, which matter where their surfaces are not perfect
    ring : where the outer ring's centre is, m, from which all places are; the shaft's springs know the fixed frame

    Errors
    ------
    RuntimeError: no equilibrium found. Forces balance to 1e-10 of the load and of the contacts' forces, or to the
    round-off of the approaches (1e-8 N) if that is more. Without load the hub
    of a bearing with clearance stays where it is put; an element that nothing holds lies midway in its gap.
    """
    theta = roller_angles(bearing, operation.first_roller_angle) if angles is None else np.asarray(angles, dtype=float)
    mass = bearing.roller_mass if roller_mass is None else roller_mass
    load = _load(operation)
    weight = float(np.hypot(*load))
    system = _System(bearing, operation, laws, theta, mass, turns, np.asarray(ring, dtype=float))
    hub = np.zeros(2) if start is None else np.array(start, dtype=float)
    if start is None and weight > 0.0:
        perfect = _System(replace(bearing, faults=()), operation, laws, theta, mass, turns, system.ring)
        hub = _sink(perfect, load, load / weight)  # near enough, and faster
    here = system.at(hub, load)
    finest = ROUND_OFF * np.max(system.track) * system.typical_stiffness * bearing.n_rollers
    for _ in range(MAX_NEWTON):
        if np.max(np.abs(here.unbalance)) <= BALANCE * (weight + np.sum(here.inner_force)) + finest:
            return Statics(
                x=float(hub[0]), y=float(hub[1]), rho=here.rho, theta=theta,
                inner_force=here.inner_force, outer_force=here.outer_force, stiffness=here.stiffness,
            )  # fmt: skip
        step = _newton_step(here, system.typical_stiffness)
        hub, here = _descend(system, hub, here, step, load)
    raise RuntimeError(
        nothing_carries(bearing, theta, load)
        or f"no static equilibrium after {MAX_NEWTON} steps: {np.max(np.abs(here.unbalance)):.3g} N unbalanced at hub "
        f"x = {hub[0]:.3e} m, y = {hub[1]:.3e} m; check load, clearance {bearing.radial_clearance:.3e} m and law"
    )


def held_hub(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    hub: np.ndarray,
    *,
    angles: np.ndarray,
    turns: Turns = UNTURNED,
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force that holds the hub at a place, (2,), N, ρ of elements in radial balance, (n_rollers,), m, its stiffness.

    Parameters: as of `static_equilibrium`; hub : (2,), m
    """
    place = np.asarray(ring, dtype=float)
    here = _System(bearing, operation, laws, angles, bearing.roller_mass, turns, place).at(hub, _load(operation))
    return here.unbalance, here.rho, here.stiffness


def _load(operation: Operation) -> np.ndarray:
    """Load and weight on the hub, (2,), N."""
    return np.array([operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)])


@dataclass(frozen=True, kw_only=True)
class _Point:
    """The system at one hub position, elements in radial balance."""

    rho: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    unbalance: np.ndarray  # (2,), gradient of the potential, N
    stiffness: np.ndarray  # (2, 2), N/m
    potential: float  # J


class _System:
    """Potential of the hub's position."""

    def __init__(self, bearing, operation, laws, theta, mass, turns, ring):
        self.inner_law, self.outer_law = laws
        self.theta, self.turns, self.surfaces = theta, turns, profiles(bearing)
        self.cos, self.sin = np.cos(theta), np.sin(theta)
        self.reach, self.track = touching_distances(bearing)
        if self.surfaces is not None:
            outer = self.surfaces.outer(theta, turns)
            self.track, self.outer_law = self.track + outer.sinkage, softened(laws.outer, outer.compliance)
        cage = kinematics(bearing, *operation.ring_speeds).cage
        self.spin = mass * cage**2
        self.weight = mass * operation.gravity * self.sin
        self.bearing, self.ring = bearing, ring
        shaft = operation.mounting.shaft
        self.shaft_stiffness = 0.0 if shaft is None else shaft.stiffness
        depth = 1e-4 * bearing.roller_radius
        self.typical_stiffness = float(laws.inner.slope(depth))

    def at(self, hub, load) -> _Point:
        """Balance the elements, then sum up their forces, the shaft's and the load, (2,), N, on the hub."""
        s = hub[0] * self.cos + hub[1] * self.sin  # hub's offset along and across each element's radius
        t = hub[1] * self.cos - hub[0] * self.sin
        rho = self._balance(s, t)
        chi, c, d, depth_in, depth_out, law_in = self._overlaps(rho, s, t)
        inner, slope_in = pressed(law_in, depth_in)
        outer, slope_out = pressed(self.outer_law, depth_out)
        radial, across = -inner * c, inner * d  # on the hub, along s and t
        unbalance = -np.array(
            [
                np.sum(radial * self.cos - across * self.sin) + load[0],
                np.sum(radial * self.sin + across * self.cos) + load[1],
            ]
        )
        place, springs = hub + self.ring, self.shaft_stiffness
        unbalance += springs * place
        # Hessian of the inner contact's energy in (along, t), then ρ eliminated
        aa = slope_in * c * c - inner / chi * d * d
        at = slope_in * c * d + inner / chi * c * d
        tt = slope_in * d * d - inner / chi * c * c
        own = aa + slope_out - self.spin
        own = np.where(own > 0.0, own, np.inf)
        ss, st, tt = aa - aa * aa / own, -(at - aa * at / own), tt - at * at / own
        cos, sin = self.cos, self.sin
        xx = np.sum(ss * cos * cos - 2.0 * st * cos * sin + tt * sin * sin)
        yy = np.sum(ss * sin * sin + 2.0 * st * cos * sin + tt * cos * cos)
        xy = np.sum((ss - tt) * cos * sin + st * (cos * cos - sin * sin))
        potential = np.sum(
            law_in.potential(depth_in) + self.outer_law.potential(depth_out)
            + self.weight * depth_out - 0.5 * self.spin * (rho * rho - self.track**2)
        )  # fmt: skip
        potential += 0.5 * springs * (place @ place)
        return _Point(
            rho=rho, inner_force=inner, outer_force=outer, unbalance=unbalance,
            stiffness=np.array([[xx + springs, xy], [xy, yy + springs]]),
            potential=float(potential) - load[1] * hub[1] - load[0] * hub[0],
        )  # fmt: skip

    def _overlaps(self, rho, s, t):
        """χ, the cosine and sine of its direction against the radius, both overlaps, m, and the inner contacts' law.

        Those are the derivatives of χ by ρ and by t; on surfaces that are not perfect, of χ and the sinkage.
        """
        along = rho - s
        chi = np.hypot(along, t)
        c, d = along / chi, t / chi
        if self.surfaces is None:
            return chi, c, d, self.reach - chi, rho - self.track, self.inner_law
        inner = self.surfaces.inner(self.theta - np.arctan2(t, along), self.turns)
        law, depth = softened(self.inner_law, inner.compliance), self.reach - chi - inner.sinkage
        aside = inner.at_force(law.force(depth)).slope / chi
        return chi, c + aside * d, d - aside * c, depth, rho - self.track, law

    def _radial(self, rho, s, t):
        """Force on the elements along +ρ, N, and minus its derivative."""
        _, c, _, depth_in, depth_out, law_in = self._overlaps(rho, s, t)
        inner, slope_in = pressed(law_in, depth_in)
        outer, slope_out = pressed(self.outer_law, depth_out)
        force = inner * c - outer + self.spin * rho - self.weight
        return force, slope_in * c**2 + slope_out - self.spin

    def _balance(self, s, t):
        """ρ of every element in radial balance: Newton's method kept inside a bracket."""
        touch_in = s + np.sqrt(np.maximum(self.reach**2 - t * t, 0.0))  # ρ that touches the inner raceway
        if self.surfaces is not None:
            touch_in -= self.surfaces.inner(self.theta - np.arctan2(t, touch_in - s), self.turns).sinkage
        push = np.abs(self.weight) + 2.0 * self.spin * self.track
        room = np.maximum(self.inner_law.approach(push), self.outer_law.approach(push)) * 1.5
        low = np.minimum(touch_in, self.track) - room
        high = np.maximum(touch_in, self.track) + room
        rho, finest = 0.5 * (touch_in + self.track), ROUND_OFF * self.track
        for _ in range(MAX_RADIAL):
            force, stiffness = self._radial(rho, s, t)
            low, high = np.where(force > 0.0, rho, low), np.where(force < 0.0, rho, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = rho + force / stiffness
            # an end of the bracket may be the root but for round-off
            inside = (newton > low - finest) & (newton < high + finest) & (stiffness > 0.0)
            step = np.where(force == 0.0, rho, np.where(inside, newton, 0.5 * (low + high)))
            if np.all(np.abs(step - rho) <= finest):
                return step
            rho = step
        return rho


def _sink(system: _System, load: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Hub position along the load's direction where the elements first hold it, m: by bisection."""
    radius = system.bearing.roller_radius
    far, near, way = max(system.bearing.radial_clearance, 0.0) + 1e-6 * radius, 0.0, 1e-5 * radius

    def holds(distance: float) -> bool:
        return float(system.at(distance * along, load).unbalance @ along) > 0.0

    for _ in range(20):
        if holds(far):
            break
        near, far, way = far, far + way, 2.0 * way
    for _ in range(60):
        middle = 0.5 * (near + far)
        if holds(middle):
            far = middle
        else:
            near = middle
        if far - near < 1e-5 * radius:
            break
    return far * along


def _newton_step(here: _Point, typical: float) -> np.ndarray:
    """Newton's step; directions without or with negative stiffness go downhill instead."""
    values, vectors = np.linalg.eigh(here.stiffness)
    values = np.maximum(np.abs(values), SOFTEST * typical)
    return -vectors @ ((vectors.T @ here.unbalance) / values)


def _descend(system: _System, hub, here: _Point, step, load: np.ndarray):
    """Go along a step as far as it lowers the potential, or the unbalance once round-off hides that."""
    size = np.linalg.norm(step)
    longest = 1e-2 * system.bearing.roller_radius
    step = step * min(1.0, longest / size) if size > 0.0 else step
    expected = float(here.unbalance @ step)  # < 0
    forces = np.hypot(*load) + np.sum(here.inner_force + here.outer_force)
    forces += system.shaft_stiffness * np.hypot(*(hub + system.ring))
    noise = 10.0 * ROUND_OFF * (abs(here.potential) + forces * np.max(system.track))
    for _ in range(60):
        there = system.at(hub + step, load)
        lower = there.potential <= here.potential + 1e-4 * expected
        finer = there.potential <= here.potential + noise and (
            np.linalg.norm(there.unbalance) < np.linalg.norm(here.unbalance)
        )
        if lower or finer:
            return hub + step, there
        step, expected = 0.5 * step, 0.5 * expected
    return hub, here

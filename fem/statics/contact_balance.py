"""The balance of hub and rollers on elastic contacts that may open and close.

Every body is condensed to the compliance between its contacts, or between points of them that push or stand open; where
that comes from (finite elements, exact series) is not known here.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from fem.contacts.contact_law import ContactLaw, NoLaw
from lagrange import Bearing, Operation
from lagrange.equations import nothing_carries, overlaps
from lagrange.errors import UsageError
from lagrange.motion import HubTilt
from lagrange.statics import Elastic, Placement, Statics, tilted_equilibrium
from lagrange.surface.deviation import UNTURNED, Falls, Turns

LOOSE_SPRING = 1.0  # N/m, keeps in place what no force holds (a roller in clearance); 1e-6 N per µm
FAINTEST = 1e-6  # N; a smaller force is what the barrier left
NEWTON_STEPS = 8  # from an equilibrium that is near: 2 or 3 are usual
MAX_TURNS, MAX_STEPS = 50, 200  # measured at most 13 and 61 in 373 random bearings, 101 with preload and no load at all
SETTLED = 1e-13  # of a radius: bodies stand still, contacts fit
BALANCED = 1e-11  # of the largest force
BARELY = 1e-19  # of the largest force times the roller's radius: force times gap that is left
FIRST_GAP = 1e-4  # of a roller's radius, beside what the contact is open by
SHRINK = 0.1  # of the mean force times gap in a step
TO_THE_WALL = 0.95  # of the way to where a force or a gap would vanish
ROUND_OFF = 1e-12  # of a roller radius: less preload than this is none


class NotFound(UsageError):
    """No static equilibrium was found: the load is more than the contacts bear."""


class HubSpring(NamedTuple):
    """Springs on the hub along x and y: of a shaft, see `lagrange.mounting.Shaft`."""

    stiffness: float  # N/m
    x: float = 0.0  # m, of the hub where they are slack
    y: float = 0.0


class Loads(NamedTuple):
    """What the contacts must carry."""

    hub: float  # N, downwards
    gravity: float = 0.0  # m/s²
    cage_speed: float = 0.0  # rad/s
    side_load: float = 0.0  # N, on the hub along +x
    spring: HubSpring | None = None

    @classmethod
    def of(cls, acting: Operation, cage_speed: float = 0.0, ring: np.ndarray | None = None) -> "Loads":
        """Loads and weights at an instant, see `Operation.at`; springs, with the outer ring's centre at a place."""
        down, spring = float(acting.radial_load) + acting.inner_mass * acting.gravity, hub_spring(acting, ring)
        return cls(down, acting.gravity, cage_speed, float(acting.side_load), spring)


def hub_spring(operation: Operation, ring: np.ndarray | None) -> HubSpring | None:
    """The shaft's springs about the outer ring's centre, which is at (2,), m; None where nothing holds the shaft."""
    shaft = operation.mounting.shaft
    return None if shaft is None or ring is None else HubSpring(shaft.stiffness, -float(ring[0]), -float(ring[1]))


@dataclass(frozen=True, kw_only=True)
class Condensed:
    """A bearing reduced to its contacts: inner ones first, then outer ones."""

    bearing: Bearing
    radial: np.ndarray  # (n_rollers, 2), unit, from the outer ring's centre to the rollers
    inner_law: ContactLaw | NoLaw  # of the approach that `compliance` leaves out
    outer_law: ContactLaw | NoLaw
    compliance: np.ndarray  # (n_points, n_points), m/N
    closing: np.ndarray  # (n_points,), m, of each by other loads, beside the overlap of its contact's surfaces
    turns: Turns = UNTURNED  # of the bodies, which matter where their surfaces are not perfect
    contact: np.ndarray | None = None  # (n_points,), whose point each is; None: every contact is one, (2 n_rollers,)

    laws = property(lambda self: (self.inner_law, self.outer_law))

    @cached_property
    def law(self) -> ContactLaw | NoLaw:
        """Both laws as one, of the forces of all contacts, (2 n_rollers,): its constants are arrays."""
        if isinstance(self.inner_law, NoLaw):
            return self.inner_law
        constants = [(law.A, law.B, law.Q_line) for law in self.laws]
        A, B, Q_line = np.repeat(constants, self.bearing.n_rollers, axis=0).T.copy()
        return replace(self.inner_law, A=A, B=B, Q_line=Q_line)


def first_guess(bearing: Bearing, radial, load: float, side_load: float = 0.0) -> np.ndarray:
    """Hub and radii, (n_rollers + 2,): the hub pushed until rigid rollers would touch, rollers midway.

    `load`, `side_load` : N, downwards and along +x
    """
    size, hub = np.hypot(load, side_load), np.zeros(2)
    if size > 0.0:
        hub = (max(bearing.radial_clearance, 0.0) + 1e-7 * bearing.roller_radius) * np.array([side_load, -load]) / size
    return np.concatenate([hub, bearing.pitch_radius + 0.5 * (radial @ hub)])


def hub_stiffness(contacts: Condensed, place: np.ndarray, forces: np.ndarray, spring: HubSpring | None) -> np.ndarray:
    """Of the hub in equilibrium as rollers follow it, (2, 2), N/m; negative across a roller that it balances on.

    place : (n_rollers + 2,), m; forces : (2 n_rollers,), N

    Errors: weight and centrifugal force of rollers are left out.
    """
    bearing, n, forces = contacts.bearing, contacts.bearing.n_rollers, closed_forces(forces)
    held, closed = Held(contacts, Loads(0.0, spring=spring), place, forces), np.flatnonzero(forces > 0.0)
    soft, directions = np.diag(contacts.law.softness(np.where(forces > 0.0, forces, 1.0))), held.directions
    soft = (held.compliance + soft)[np.ix_(closed, closed)]
    whole = np.diag(held.springs) + directions[closed].T @ np.linalg.solve(soft, directions[closed])
    normal = directions[:n, :2]
    across = np.zeros((n, n + 2))  # the inner contacts' ways along their tangents, by which their normals turn
    across[:, :2] = np.column_stack([-normal[:, 1], normal[:, 0]])
    across[range(n), range(2, n + 2)] = -np.sum(across[:, :2] * contacts.radial, axis=1)
    whole -= across.T @ ((forces[:n] / (bearing.inner_raceway_radius + bearing.roller_radius))[:, None] * across)
    return whole[:2, :2] - whole[:2, 2:] @ np.linalg.solve(whole[2:, 2:], whole[2:, :2])


def closed_forces(forces: np.ndarray) -> np.ndarray:
    """The contact forces of a solution, N; what the barrier leaves at open contacts is 0."""
    return np.where(forces > FAINTEST, forces, 0.0)


def balance(
    contacts: Condensed, loads: Loads, start: np.ndarray | None = None, near: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Hub and radii, (n_rollers + 2,), and the forces of inner and outer contacts, or of points, in equilibrium.

    With the directions of the contacts held the problem is convex, however many contacts open or close: the least
    potential energy of elastic bodies that may not pull. That is solved, the directions are set anew, and so on; they
    move by microradians, or by a roller's pitch where a hub in clearance rolls over to the next roller.

    start : (n_rollers + 2,), m; None: `first_guess`
    near : (n_points,), N, forces of an equilibrium that is near, where there is one

    Errors: NotFound. The balance is exact to about 1e-9 of the load.
    """
    bearing = contacts.bearing
    position = first_guess(bearing, contacts.radial, loads.hub, loads.side_load) if start is None else start
    forces = np.zeros(contacts.closing.size) if near is None else near
    for _ in range(MAX_TURNS):
        held = Held(contacts, loads, position, closed_forces(forces))
        moved, forces = _closed_alone(held, closed_forces(forces)) or _convex(held)
        change = np.abs(moved - position).max()
        position = moved
        if change <= SETTLED * bearing.pitch_radius:
            return position, forces
        if np.hypot(position[0], position[1]) > bearing.roller_radius + abs(bearing.radial_clearance):
            raise held.not_found("the hub sinks by more than a roller's radius")
    raise held.not_found(f"the bodies still move by {change:.1e} m after {MAX_TURNS} turns of their contacts")


def tilted_balance(
    contacts: Condensed, operation: Operation, laws: tuple, hub: HubTilt, ring: np.ndarray, start: np.ndarray,
    elastic: Elastic,
) -> Statics:  # fmt: skip
    """Equilibrium of rollers that tilt near hub and radii at a start, (n_rollers + 2,), m, in place of `balance`.

    laws : of tilted contacts, inner and outer; ring : (2,), m, of the outer ring's centre

    Errors: NotFound.
    """
    placement = Placement(np.arctan2(contacts.radial[:, 1], contacts.radial[:, 0]), ring, contacts.turns)
    near, laws = (start[:2], start[2:]), laws
    try:
        return tilted_equilibrium(contacts.bearing, operation, laws, hub, placement, near, elastic)
    except RuntimeError as error:
        raise NotFound(str(error)) from None


class Held:
    """The convex problem: the contacts' directions are held as they are at a position under the last forces."""

    def __init__(self, contacts: Condensed, loads: Loads, position: np.ndarray, last: np.ndarray):
        bearing, radial, turns = contacts.bearing, contacts.radial, contacts.turns
        self.contacts, self.loads, self.position = contacts, loads, position
        overlap, directions, soft = geometry(bearing, radial, position, turns, last)
        if contacts.contact is not None:
            overlap, directions, soft = (of_contacts[contacts.contact] for of_contacts in (overlap, directions, soft))
        self.overlap = overlap + contacts.closing  # (n_points,), m, there, of bodies under no contact forces
        self.directions = directions  # (n_points, n_rollers + 2), its derivatives
        self.compliance = contacts.compliance + np.diag(soft)  # (n_points, n_points), m/N, without the laws'
        # the centrifugal force's own growth is left out: a roller in clearance would be sent the wrong way
        on_rollers = bearing.roller_mass * (loads.cage_speed**2 * position[2:] - loads.gravity * radial[:, 1])
        self.applied = np.concatenate([[loads.side_load, -loads.hub], on_rollers])  # (n_rollers + 2,), N
        # what holds hub and rollers beside contacts: stiffness, N/m, and where it rests, m
        self.springs = np.full(bearing.n_rollers + 2, LOOSE_SPRING)
        self.middle = np.concatenate([np.zeros(2), np.full(bearing.n_rollers, bearing.pitch_radius)])
        if loads.spring is not None and loads.spring.stiffness > LOOSE_SPRING:
            self.springs[:2], self.middle[:2] = loads.spring.stiffness, loads.spring[1:]
        self.size = max(float(np.abs(self.applied).max()), FAINTEST)

    def unbalanced(self, moved: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Forces on hub and rollers that are left, (n_rollers + 2,), N."""
        return self.applied - self.springs * (moved - self.middle) - self.directions.T @ force

    def through(self, moved: np.ndarray, force: np.ndarray) -> np.ndarray:
        """How far the bodies' surfaces would lie in each other under these forces, (n_points,), m."""
        moving = self.directions @ (moved - self.position)
        return self.overlap + moving - self.compliance @ force - self.contacts.law.approach(force)

    def not_found(self, why: str) -> NotFound:
        bearing, radial, loads = self.contacts.bearing, self.contacts.radial, self.loads
        angle = np.arctan2(radial[:, 1], radial[:, 0])
        return NotFound(
            nothing_carries(bearing, angle, (loads.side_load, -loads.hub))
            or f"no static equilibrium under {loads.hub:.4g} N at the hub: {why}; lower operation.radial_load_N or "
            "take a stiffer material"
        )


def _closed_alone(held, near):
    """Positions and forces by Newton's method on the contacts that forces near by close; None: it does not get there.

    Where no force pulls and no other contact is closed it is the solution, as a convex problem has but one.
    """
    is_open, radius, law = near <= 0.0, held.contacts.bearing.roller_radius, held.contacts.law
    closed, n = np.flatnonzero(~is_open), held.applied.size
    if not closed.size:
        return None
    matrix = np.diag(np.concatenate([held.springs, np.zeros(closed.size)]))
    matrix[:n, n:], matrix[n:, :n] = held.directions[closed].T, -held.directions[closed]
    own = held.compliance[np.ix_(closed, closed)]
    moved, force = held.position, near.copy()
    for done in range(NEWTON_STEPS):
        through, unbalanced = held.through(moved, force), held.unbalanced(moved, force)
        if (
            done > 0  # a hub that could balance on one roller must tip: the least imbalance across it counts
            and np.abs(unbalanced).max() <= BALANCED * max(held.size, float(force.max()))
            and np.abs(through[closed]).max() <= SETTLED * radius
        ):
            return None if (through[is_open] > SETTLED * radius).any() else (moved, force)
        matrix[n:, n:] = own + np.diag(law.softness(np.where(is_open, 1.0, force))[closed])
        step = np.linalg.solve(matrix, np.concatenate([unbalanced, through[closed]]))
        moved, force[closed] = moved + step[:n], force[closed] + step[n:]
        if (force[closed] <= 0.0).any():
            return None
    return None


def _convex(held):
    """Positions and forces, whatever contacts close.

    Primal-dual interior-point method (Nocedal and Wright, Numerical Optimization, 2006, chapter 19): forces q and gaps
    s stay positive while their products shrink to 0.
    """
    directions, radius, law = held.directions, held.contacts.bearing.roller_radius, held.contacts.law
    moved, force = held.position.copy(), np.full(held.overlap.size, held.size)
    gap, springs = FIRST_GAP * radius + np.maximum(-held.overlap, 0.0), np.diag(held.springs)

    def room(value, step):
        """Share of a step that keeps values above 0."""
        return TO_THE_WALL * float(np.divide(-value, step, out=np.full(len(step), inf), where=step < 0.0).min())

    for _ in range(MAX_STEPS):
        unbalanced, apart = held.unbalanced(moved, force), held.through(moved, force) + gap
        product, scale = float(force @ gap) / force.size, max(held.size, float(force.max()))
        if (
            np.abs(unbalanced).max() <= BALANCED * scale
            and np.abs(apart).max() <= SETTLED * radius
            and product <= BARELY * scale * radius
        ):
            return moved, force
        barrier, soft = SHRINK * product, held.compliance + np.diag(law.softness(force) + gap / force)
        solved = np.linalg.solve(soft, np.column_stack([directions, apart + barrier / force - gap]))
        step = np.linalg.solve(springs + directions.T @ solved[:, :-1], unbalanced - directions.T @ solved[:, -1])
        force_step = solved[:, :-1] @ step + solved[:, -1]
        gap_step = (barrier - force * gap - gap * force_step) / force
        length = min(1.0, room(force, force_step), room(gap, gap_step))
        moved, force, gap = moved + length * step, force + length * force_step, gap + length * gap_step
    raise held.not_found(f"{np.abs(unbalanced).max():.2e} N are unbalanced after {MAX_STEPS} steps")


def geometry(bearing: Bearing, radial, position, turns: Turns = UNTURNED, forces=None) -> tuple[np.ndarray, ...]:
    """Overlap of undeformed bodies at every contact, (2 n,), m, and its derivatives by hub and radii, (2 n, n + 2);
    the compliance of spalls' edges, (2 n,), m/N.

    On soft edges the derivatives are those of the contacts' energy over their `forces`, (2 n,), N.
    """
    n, j, theta = bearing.n_rollers, np.arange(bearing.n_rollers), np.arctan2(radial[:, 1], radial[:, 0])
    found = overlaps(bearing, position[0], position[1], position[2:], theta).on_surfaces(bearing, turns)
    soft = np.concatenate([np.zeros(n) + compliance for compliance in found.compliances])
    if forces is not None:
        found = found.at_contact(Falls(compliance=0.5 * forces[:n]))
    directions = np.zeros((2 * n, n + 2))
    directions[:n, 0], directions[:n, 1], directions[j, 2 + j] = -found.direction_x, -found.direction_y, -found.radial
    directions[n + j, 2 + j] = 1.0
    return np.concatenate([found.inner, found.outer]), directions, soft

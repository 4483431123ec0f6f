"""A cage, its contacts and the bodies that it meets, as named tuples of arrays."""

from typing import NamedTuple

import numpy as np

DASHPOTS, FRICTION, DRAG = 0, 1, 2  # of `Cage.lost`
# of a sample, in this order: place, angle, speed, guide's force, losses; then three blocks of rollers
N_CAGE_SCALARS = 9


class Riders(NamedTuple):
    """Rollers, as a cage meets them."""

    centre: np.ndarray  # (2, columns), m
    velocity: np.ndarray  # (2, columns), m/s, at t − dt/2; after the kick at t + dt/2
    spin: np.ndarray  # (columns,), rad/s, likewise
    node_impulse: np.ndarray  # (2, columns), N s, of this step, not in the velocity yet
    body_impulse: np.ndarray  # (2, columns), N s, of this step, which the kick takes
    turn_kick: np.ndarray  # (columns,), rad/s, of this step, not in the spin yet
    n: int
    mass: float
    inertia: float
    radius: float
    swelling: np.ndarray | None  # (columns,), kg m², inertia gained by deformation; None: rigid


class GuidingRing(NamedTuple):
    """A ring that guides the cage: the inner one, which is the hub, or the outer one in a housing that moves."""

    place: np.ndarray  # (2,), m
    velocity: np.ndarray  # (2,), m/s
    impulse: np.ndarray  # (2,), N s, of this step, which the kick takes
    rubbed: np.ndarray  # (3,), N s, of this step, in the velocity already; N m s about its centre
    mass: float  # kg; in finite elements, which kick it by themselves, a `late_mass`, see `ground_dashpots`
    speed: np.ndarray  # (1,), rad/s, in this step
    turns: bool  # with the shaft


class CageContacts(NamedTuple):
    """Contacts of a cage: in its pockets, or with its guide. Forces are those on the rollers, or on the cage by its
    guide, along a contact's normal n and across it: there along (n_y, −n_x) of a roller, (−n_y, n_x) of the guide."""

    approach: np.ndarray  # (n,), m, at the last kick; negative: apart, NaN: not known
    force: np.ndarray  # (n,), N, of the spring, >= 0
    kick: np.ndarray  # (n,), N, that the last kick gave: see `law.kick_force`
    residual: np.ndarray  # (n,), J, likewise
    normal: np.ndarray  # (2, n), unit, from the pocket to the roller's surface, or from the guide to the cage
    arm: np.ndarray  # (2, n), m, at which forces along and across turn the cage
    closed: np.ndarray  # (n,), 1 or 0
    rates: np.ndarray  # (2, n), m/s, before the kick, along and across
    closing: np.ndarray  # (n,), m/s, on the way here along the last step's normal
    given: np.ndarray  # (2, n), N, by dashpot and by friction


class Cage(NamedTuple):
    """A rigid ring. Rows of `motion`: place, m, and angle; its velocity at t − dt/2; that before the last kick."""

    motion: np.ndarray  # (3, 3)
    impulse: np.ndarray  # (3,), N s and N m s, of this step
    lost: np.ndarray  # (3,), J, so far: in dashpots, by friction, by drag
    drag: np.ndarray  # (1,), N m s, of this step
    frame: np.ndarray  # (2,), cosine and sine of the angle
    cosine: np.ndarray  # (columns,), of the pockets' angles at t = 0
    sine: np.ndarray
    off: np.ndarray  # (columns,), m, of rollers off their pockets' middles; room
    pockets: CageContacts
    guide: CageContacts | None  # None: rollers guide it
    mass: float  # kg
    inertia: float  # kg m²
    pitch_radius: float  # m, of the pockets' middles
    roller_radius: float  # m
    half_clearance: float  # m, of pockets
    play: float  # m, half the guide's clearance
    guide_radius: float  # m, at which the guide rubs; negative where the cage's bore is around it
    stiffness: float  # N/m
    damping: float  # N s/m
    friction: float
    drag_torque: float  # N m
    at: int  # place of its first number in a sample


class CagePair(NamedTuple):
    """A cage, its rollers, and the ring that guides it."""

    cage: Cage
    riders: Riders
    ring: GuidingRing | None  # None: no ring guides the cage, or one that stands still

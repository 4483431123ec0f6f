"""State of the Lagrangian model: a rigid hub, rigid rolling elements, contact laws between them.

Named tuples of arrays, for kernels. Elements are lanes: `columns` is their number rounded up to WIDTH; spare ones stay
where they are and feel nothing. SI throughout.

Elements move in axes of their own. Those that a cage holds are on the first axis, which turns with the cage; free ones
have the fixed axes.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.cage import CagePair
from fem.kernels.state import Course

INNER, OUTER = 0, 1  # rows of contact arrays


class PowerConstants(NamedTuple):
    """Q = K δⁿ."""

    stiffness: float  # K, N/mⁿ
    exponent: float  # n


class IdealHousing(NamedTuple):
    """What carries the outer ring, and a sensor on it; hub and elements are then from the ring's centre."""

    motion: np.ndarray  # (3, 2), place, m, velocity, acceleration
    sensor: np.ndarray  # (2,), r, m, and ṙ, m/s; 0 without one
    sensor_step: np.ndarray  # (2, 2, 3), of a step far from faults and near
    shift: np.ndarray  # (2,), N, S: by the housing's velocity, power that held angles take up
    lever: np.ndarray  # (2,), kg m/s, L: minus that by its acceleration
    damped: np.ndarray  # (2,), m/s², acceleration by the contacts' dampers
    turned: np.ndarray  # (2,), cosine and sine of the held elements' turn, at the positions last seen
    mass: float  # kg, with the outer ring
    stiffness: float  # N/m
    damping: float  # N s/m


class IdealMotion(NamedTuple):
    """All that changes from step to step."""

    hub: np.ndarray  # (3, 2), place, m, velocity, acceleration
    elements: np.ndarray  # (3, 1 or 2, columns), the same along each axis of their own
    # (5,), J: of what holds the angles and turns the bodies, of the ramp, dissipated by contacts, and by the shaft's
    # dashpots; and the power of the first, W
    works: np.ndarray
    force: np.ndarray  # (2, columns), N, of the springs; those of the last positions, room before any
    cage: CagePair | None = None  # among free elements; it shares their arrays and the hub's
    housing: IdealHousing | None = None  # None: the ground holds the outer ring


class Surfaces(NamedTuple):
    """Surfaces that are not perfect circles, see `surfaces`; None: of these all are."""

    rings: tuple  # the inner and the outer raceway
    rollers: tuple  # the elements in their contacts with them
    near: np.ndarray  # (1,), 0 while no contact is near a fault


class ShaftSprings(NamedTuple):
    """What holds the shaft beside the bearing; see `lagrange.mounting.Shaft`."""

    stiffness: float  # N/m
    damping: float  # N s/m


class IdealBearing(NamedTuple):
    """What moves, and what acts on it."""

    laws: tuple  # of inner and outer contacts: `PowerConstants`, or `state.Law` for δ = A Q (B − ½ ln Q)
    surfaces: Surfaces | None  # None: perfect circles
    first: np.ndarray | None  # (2, columns), cosine and sine of held elements' angles at t = 0; None: they are free
    reach: float  # m, from the hub to an element that touches the inner ring
    track: float  # m, from the outer ring's centre to one that touches that
    mass: float  # kg, of an element
    hub_mass: float  # kg
    gravity: float  # m/s²
    radial_load: float  # N
    ramp: float  # s, 0: full load at once
    turning: float  # rad/s, of the elements' own axes
    shaft: float  # rad/s
    spin: float  # rad/s, of an element about its own centre
    n: int
    columns: int
    course: Course | None = None  # of speed and load; None: they stay
    springs: ShaftSprings | None = None  # None: the bearing alone holds the hub


class Dampers(NamedTuple):
    """Dampers beside the springs, and room for what they take from the positions."""

    constant: float  # N s/m
    time: float  # s, of the contact's stiffness
    hunt_crossley: float  # s/m
    coefficient: np.ndarray  # (2, columns), N s/m, of inner and outer contact
    axes: np.ndarray  # (2, columns), cosine and sine of the direction of each element's first axis
    normal: np.ndarray  # (2, 2, columns), outward and along each element's own axes, of inner and outer contact
    closing: np.ndarray  # (2, columns), m/s, rates at which contacts close because surfaces pass
    hub: np.ndarray  # (2,), m/s², acceleration by the dampers
    elements: np.ndarray  # (1 or 2, columns)


class Clock(NamedTuple):
    """Where the steps are, and their scheme; of two values the first is far from faults, the second near."""

    lengths: np.ndarray  # (2,), s, of steps
    counts: np.ndarray  # (2,), steps of a section
    sections: int  # of a sample
    near: np.ndarray  # (n_rows, sections), 1 where a contact is near a fault
    done: int  # samples so far
    kicks: np.ndarray | None  # (stages + 1,), of a step; None: of leapfrog, for what takes energy
    drifts: np.ndarray | None  # (stages,)


class Rows(NamedTuple):
    """Stored samples."""

    hub: np.ndarray  # (n_rows, 2, 2), places and velocities
    elements: np.ndarray  # (n_rows, 2, 1 or 2, columns)
    works: np.ndarray  # (n_rows, 4), J
    cage: np.ndarray  # (n_rows, width), see `lagrange.cage_motion.CageRows`; no columns without one
    housing: np.ndarray  # (n_rows, 2, 2), places and velocities
    sensor: np.ndarray  # (n_rows, 2)

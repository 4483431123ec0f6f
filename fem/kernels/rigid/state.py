"""State of the loop of rigid bodies: these, and contacts between bodies whose elasticity has no mass.

Named tuples of arrays, for kernels. Rollers are lanes: `columns` is their number rounded up to WIDTH, entries of spare
ones mean nothing. SI throughout.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.cage import CagePair
from fem.kernels.drive import LoadHistory
from fem.kernels.fields import given, room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair
from fem.kernels.law import Law
from fem.kernels.mounts import Housing, Shaft
from fem.kernels.rigid.rays import Prescribed
from fem.kernels.tilts import TiltedForces, Tilts
from lagrange.contact.damping import ContactDamping

UNEVEN = "soft_before", "soft", "slope", "softening"  # of `ReducedForces`: None on perfect circles
SLOPE, ENERGY, MOMENT, CROSS = range(4)  # entries of `TiltedForces.met`


class RigidBodies(NamedTuple):
    """The hub with the inner ring, and the rollers."""

    hub: state("2")  # m
    hub_velocity: state("2")  # m/s, at t − dt/2
    centre: state("2, columns")  # m
    velocity: state("2, columns")  # m/s, at t − dt/2
    turn: state("columns")  # rad
    spin: state("columns")  # rad/s, at t − dt/2
    hub_mass: float  # kg
    mass: float  # kg, of a roller
    inertia: float  # kg m²
    radius: float  # m, of a roller, undeformed
    n: int
    columns: int
    cage: CagePair | None
    shaft: Shaft | None = None  # None: the bearing alone holds the hub
    housing: Housing | None = None  # None: the ground holds the outer ring
    prescribed: Prescribed | None = None  # None: rollers turn and go round by the forces on them
    tilts: Tilts | None = None  # None: axes stay parallel


class PowerConstants(NamedTuple):
    """Q = K δⁿ."""

    stiffness: float  # K, N/mⁿ
    exponent: float  # n


class Coupling(NamedTuple):
    """What forces on other contacts of the same elastic body do to a contact; of each roller by its neighbours."""

    between: Law  # of two rollers
    across: float  # m/N, approach of a roller's contact by the force on its other one
    relaxation_factor: float  # of the force increments that neighbours use: see `contacts`
    distance: np.ndarray  # (neighbours,), in rollers, of contacts whose forces count along a ring: −1, 1, −2 ...
    counts: np.ndarray  # (2, 2), whole: by row, of how many of these compliances follow angles, and how many count
    along: given("2, neighbours, columns")  # m/N, at the pockets' angles
    steep: given("2, neighbours, columns")  # m/N per rad that the angle to the neighbour is larger
    bent: given("2, 4, neighbours, columns")  # m/N/rad² to m/N/rad⁵
    strays: float  # rad, by which angles may be smaller or larger; beyond, compliances stay
    crossed: given("2, neighbours, columns")  # m/N, by their tractions on these rollers
    crossing: np.ndarray  # (2,), whole: by row, of how many of them
    apart: np.ndarray  # (2, columns), cosine and sine of the pockets' angles from the first roller on
    tangential: np.ndarray  # (3,), m/N, of contacts that stick


class TiltedContacts(NamedTuple):
    """What tilt takes of contacts."""

    tables: tuple  # `tilted_contact.TiltedLaw` of the inner and the outer contacts
    rests: tuple  # `tilted_contact.SpalledRest` of both; None: spalls take no part of the length
    part: tuple  # `tilted_contact.PartProfiles`; None: as above
    share: float  # 12/L², 1/m²
    length: float  # m, of a roller


class Contacts(NamedTuple):
    """Contacts of rollers with raceways."""

    inner: tuple  # `Law`, or `PowerConstants` without coupling; where bodies are rigid and tilt there are tables alone
    outer: tuple
    reach: float  # m, distance of centres at which a roller, grown by its spin, touches the grown inner ring
    track: float  # m, and the outer ring
    ring_profiles: tuple  # of the inner and the outer raceway, see `surfaces`; None: a perfect circle
    roller_profiles: tuple  # of the rollers in their contacts with them
    sag: tuple[float, float] = (0.0, 0.0)  # m, by which raceways' centres lie below hub and outer ring, by own weight
    coupling: Coupling | None = None  # None: bodies are rigid, contacts do not know each other
    tilted: TiltedContacts | None = None  # None: axes stay parallel


class Step(NamedTuple):
    """A step of leapfrog, from velocities half of it behind to those half of it ahead."""

    bodies: tuple  # `RigidBodies`
    contacts: tuple  # `Contacts`
    forces: tuple  # `ReducedForces`
    before: tuple  # `Before`
    drive: tuple  # `ReducedDrive`
    time: float  # s, of the kick


class Change(NamedTuple):
    """The change from one step length to another: see `paces`."""

    drive: tuple  # with the new step
    shift: float  # s², of an acceleration by which places change
    back: float  # of what a kick has given, by which velocities change
    step: np.ndarray  # (2, 3), a sensor's with the new step: see `mounts.Resonator`
    half_step: np.ndarray  # (2, 3)


class TiltedDampers(NamedTuple):
    """Further dampers to `ReducedDampers`. Arrays over rollers by row."""

    moment: state("2, columns")  # N m, of the last kick
    lever: room("2, columns")  # m, z
    turning: room("2, columns")  # N m s, g
    over_reach: float  # 1/m, over the distance of rollers' centres from the hub's
    length: float  # m, of a roller


class ReducedDampers(NamedTuple):
    """Dampers of contacts: see `dampers`. Arrays over rollers by row."""

    law: ContactDamping
    force: state("3, columns")  # N
    rate: room("2, columns")  # m/s, at which contacts close
    gain: room("1, columns")  # N s/m, of inner forces by the hub's velocity
    coefficient: room("2, columns")  # N s/m
    work: state("2")  # J, dissipated up to the last kick; and after it in that step
    tilted: TiltedDampers | None = None  # None: axes stay parallel


class Radiation(NamedTuple):
    """What strikes give to elastic waves that the model does not follow: see `strikes`."""

    inertia: tuple[float, float]  # s⁴/kg, of both raceways' contacts, Σ s²/ω⁴ of all modes that the model lacks
    settling: float  # s, 1/ω of the slowest of them
    owed: state("2, columns")  # J, lost by contacts that have opened, and not yet taken from what moves
    speed: room("2, columns")  # m/s, at which contacts have closed, or < 0 opened, in this step
    kick: room("2, columns")  # N, what the last step's impulses are over a step
    work: state("2")  # J, given up to the last kick; and after it in that step
    state: np.ndarray  # (1,), whole: whether a contact has been struck in this step, or kicked in the last


class ReducedForces(NamedTuple):
    """Contacts by row and roller. Arrays with a halo repeat a ring's other end on either side."""

    force: state("3, columns")  # N
    approach: state("3, columns", np.nan)  # m, of the law; NaN: not known
    kick: state("3, columns")  # N, what the last kick gave
    residual: state("3, columns")  # J, stored beyond what kicks have taken: see `law.kick_force`
    traction: state("3, columns")  # N, on the roller along +θ, or on the next roller
    fastest: state("lanes")  # N, by lane, the most that a force has changed in a step
    beyond: state("1")  # N, the most that kicks have given the hub beyond the forces of the same sample
    guess: state("2, haloed")  # N, the forces expected of this step
    gained: state("2, haloed")  # N, what they turn out beyond that
    first: state("2, columns")  # m, approach by the guess; room
    estimate: state("2, columns")  # N, its force; room
    stiffness: state("2, columns")  # N/m; room
    normal: state("2, 2, columns")  # outward; room
    # at the angles where rollers are: see `contacts.follow_angles`
    strayed: room("haloed")  # rad, by how much rollers are ahead of equal angles
    along: room("2, neighbours, columns")  # m/N
    steep: room("2, neighbours, columns")  # m/N per rad
    tilt: room("2, columns")  # of the raceways under contacts by forces on others
    # of surfaces that are not perfect circles, or None: compliance of edges; slopes of approaches and of compliances
    # along the inner raceway, the roller's share of that, the outer raceway, the roller's share
    soft_before: state("2, columns")  # m/N, in the last kick
    soft: state("2, columns")  # room
    slope: state("4, columns")  # m/rad; room
    softening: state("4, columns")  # m/N/rad; room
    radiation: Radiation | None  # None: no waves are reckoned with
    pulled: state("2, haloed")  # N, tractions of the last step
    lifted: state("2, 2, columns")  # m, how far they push the raceways back: now, at the last kick
    # of approaches, m, by other contacts' forces: now, at the last kick; None: not asked for
    taken: state("2, 2, columns")
    halo: int
    dampers: ReducedDampers | None  # None: contacts without
    # where bodies may strike each other, of the last kick, else None: how far forces were ahead, m (NaN: not known),
    # and what the kick gave beyond forces that are not, N
    ahead: state("2, 2, columns", np.nan)
    cut: state("2, columns")  # m, there too, what the last kick's approaches were cut by
    tilted: TiltedForces | None = None  # None: axes stay parallel


class ReducedDrive(NamedTuple):
    """What acts from outside, and works so far."""

    sums: state("3")  # J: work of the load, of the drive, dissipated work
    speed: float  # rad/s
    gravity: float  # m/s²
    dt: float
    radial_load: float  # N
    ramp: float  # s, 0: full load at once
    friction: float
    inner_radius: float  # m, of the raceway
    history: LoadHistory | None = None  # of speed and load; None: they stay
    looks: bool = True  # whether contacts look up surfaces that are not perfect circles


class Before(NamedTuple):
    """Velocities before a kick, accelerations by conservative forces and what acts in it: what parts need of a step."""

    hub_velocity: state("2")
    velocity: state("2, columns")
    spin: state("columns")
    acceleration: state("2, columns")  # m/s²
    hub_acceleration: state("2")
    ring_acceleration: state("2")  # of the outer ring in a housing
    load: state("2")  # N, along x and against y
    driven: state("1")  # J, work of the drive before the kick


@part
def normals(forces, group, columns):
    """Of eight rollers' inner and outer contacts: x, y, x, y."""
    ix, iy = load_pair(forces.normal, group, columns)
    ox, oy = load_pair(forces.normal, 2 * columns + group, columns)
    return ix, iy, ox, oy

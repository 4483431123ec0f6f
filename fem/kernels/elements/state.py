"""The arrays the time loop works on. Plain named tuples: what one holds is part of its type.

A body has nodes, and a surface by which its contacts know it: `DiscSurface`, `RingSurface`, `RigidDisc`, `Hub` or
`Ground`. A `Pair` of bodies is a ring's surface and the rollers, or roller j and j + 1; its
row is where its contacts stand in the arrays of `Contacts`. Surfaces and pairs share their arrays with the bodies. What
a scene's bodies and contacts do not need is thereby not compiled.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.drive import LoadHistory, OuterTurn
from fem.kernels.fields import given, room, state
from fem.kernels.law import Law, RingProfile, RollerProfiles
from lagrange.contact.damping import ContactDamping


class Rollers(NamedTuple):
    """Motion of all rollers. Arrays over rollers have `columns` entries, spare ones 0. Frames: see `discs`."""

    centre: state("2, columns")  # m
    velocity: state("2, columns")  # m/s, at t − dt/2
    turn: state("columns")  # rad, of the frames
    cosine: state("columns", 1.0)  # of turn
    sine: state("columns")
    increment: state("columns")  # rad, the frames' next turn
    lead: state("columns")  # rad, by which the bodies lead their frames
    spin: state("columns")  # rad/s
    node_impulse: state("2, columns")  # N s, of this step, through nodes
    body_impulse: state("2, columns")  # N s, of this step, on the whole body
    turn_kick: state("columns")  # rad/s, of this step, turning the whole body
    n: int
    columns: int
    total_mass: float
    inertia: float
    radius: float
    swelling: np.ndarray | None = None  # (columns,), kg m², inertia gained by deformation; None: not asked for


class Disc(NamedTuple):
    """Nodes of all rollers; none where these are rigid. Arrays of fields: see `discs`."""

    starts: given("n_nodes + 1", dtype=np.int64)  # rows of 2 x 2 blocks
    neighbours: given("n_blocks", dtype=np.int64)
    blocks: given("4 * n_blocks")  # −dt·M⁻¹K
    points: given("2 * n_nodes")  # m
    grown: given("2 * n_nodes")  # m/s, blocks·points
    mass: given("n_nodes")  # kg
    first: int  # node of the surface, whose nodes are the last ones
    u: state("n_nodes * 2 * columns")  # m
    w: state("n_nodes * 2 * columns")  # momentum over lumped mass, m/s
    v: room("n_nodes * 2 * columns")  # velocities of the surface's nodes, m/s; w itself where masses are lumped
    # w with its fastest waves lessened, m/s, see `reciprocal_mass`; w itself but in the third degree
    calmed: room("n_nodes * 2 * columns")


class Ring(NamedTuple):
    """Nodes of a ring. Frames: see `rings`. A rigid one is a held row of one node at the radius of gyration."""

    table: given("n_rows, 18")  # −dt·M⁻¹K
    slowed: given("n_rows, 18")  # γ dt² times that, see `reciprocal_mass`
    calming: given("n_rows, 18")  # β dt times that
    u: state("n_rows, 2, width")  # of n_sectors and two halos
    w: state("n_rows, 2, width")  # momentum over lumped mass
    v: room("n_rows, 2, width")  # of the raceway's nodes, as a disc's
    calmed: room("n_rows, 2, width")  # as a disc's
    radii: given("n_rows")
    grown: given("n_rows")  # slowed·radii
    row_mass: given("n_rows")
    cosines: given("width")  # of the sectors' angles
    sines: given("width")
    n_sectors: int
    first_row: int  # free rows
    last_row: int
    raceway: int
    held: int


class DiscSurface(NamedTuple):
    """Surface of all elastic rollers, whose nodes are the last ones."""

    u: np.ndarray
    w: np.ndarray
    v: np.ndarray
    points: np.ndarray
    inverse_mass: given("n_nodes + 8")  # 1/kg, inverse masses; the surface's first eight once more
    impulse: np.ndarray  # (2, columns), N s, of this step, through nodes
    ripple: given("n_knots")  # of the law below the grid, `law.with_seam`; empty without one
    first: int
    n_nodes: int  # on the surface
    columns: int
    radius: float


class RingSurface(NamedTuple):
    """Raceway of an elastic ring."""

    u: np.ndarray
    w: np.ndarray
    v: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray
    ripple: given("n_knots")
    row: int  # of nodes
    n_nodes: int
    node_mass: float
    radius: float


class RigidDisc(NamedTuple):
    """All rollers, rigid."""

    velocity: np.ndarray
    spin: np.ndarray
    turn_kick: np.ndarray
    columns: int
    total_mass: float
    inertia: float
    radius: float


class Hub(NamedTuple):
    """A rigid inner ring, which is part of the hub."""

    place: np.ndarray  # (2,), m
    velocity: np.ndarray  # (2,), m/s
    impulse: np.ndarray  # (2,), N s
    n_contacts: int
    late_mass: float  # kg, see `mounts`
    speed: float
    radius: float
    history: LoadHistory | None = None  # None: the speed stays


class Ground(NamedTuple):
    """A rigid outer ring."""

    radius: float
    turning: OuterTurn | None = None


class Pair(NamedTuple):
    """Bodies that touch, of which side 1 is a roller: rollers on a ring, side 0; or roller j, side 0, with j + 1.

    Of two rollers the surface of side 0 is theirs: `surface` and all after it is None.
    """

    row: int
    law: Law
    sign: float = 1.0  # of the normal, from the ring's centre to a roller, outward of the raceway: 1, of a bore −1
    surface: RingSurface | Hub | Ground | None = None
    radius: float | None = None  # m, of the raceway
    orbit: float | None = None  # m, of the rollers' centres
    centre: np.ndarray | None = None  # (2,), m, of the ring
    counted_from: np.ndarray | None = None  # (2,), m, rigid motion that is in the nodes' displacement
    frame: np.ndarray | None = None  # (3,), turn, cosine, sine
    impulse: np.ndarray | None = None  # (2,), N s, of this step on the ring as a whole
    # of this step: on the frame, N m, held by the drive; on nodes about the origin, N m s
    moment: np.ndarray | None = None
    profile: RingProfile | None = None  # None: a perfect circle
    roller_profiles: RollerProfiles | None = None  # None: perfect circles


class Forces(NamedTuple):
    """Normal forces, by pair and roller."""

    force: state("pairs, columns")  # N
    kick: state("pairs, columns")  # N, that the last kick gave: see `law.kick_force`
    approach: state("pairs, columns", np.nan)  # m, below the grid, at the last kick; negative: apart; NaN: far apart
    residual: state("pairs, columns")  # J, stored beyond what the kicks have taken: see `law.kick_force`
    bracket: state("pairs, columns")  # B with the ripples of the present positions
    overlap: state("pairs, columns", np.nan)  # m, of the undeformed circles; NaN: far apart
    nearness: state("pairs, columns")  # 1/m, over the distance of the centres


class Patches(NamedTuple):
    """Where contacts meet surfaces, by side (2·row + 0 or 1) and roller; see `surfaces`."""

    normal: state("pairs, 2, columns")  # by pair, unit, from side 0 to side 1 (outer raceway: outward)
    start: state("2 * pairs, columns", dtype=np.int64)  # first surface node or sector
    position: state("2 * pairs, columns")  # in node spacings
    beyond: state("2 * pairs, columns")  # of it past a node
    motion: state("2 * pairs, 5, columns")  # see `surfaces.interpolate_displacement`
    # of nodes in the bodies' arrays; of a ring the first of every six
    place: state("2 * pairs, entries, columns", dtype=np.int64)
    weight: state("2 * pairs, entries, columns")
    outward: state("2 * pairs, 2, columns")  # of a roller, unit, in its frame
    # of a ring: weight times the cosine of the angle to the node's radius
    along: state("2 * pairs, entries, columns")
    across: state("2 * pairs, entries, columns")  # times the sine
    # what a unit traction does to nodes, W g: radial on a ring, else x
    traction_x: state("2 * pairs, entries, columns")
    traction_y: state("2 * pairs, entries, columns")  # tangential or y
    inverse_mass: state("2 * pairs, entries, columns")  # of a roller's nodes, 1/kg
    columns: int
    units: tuple[int, ...]  # m entries: what nodes carry of a contact is kept for 6 m of them


class Shear(NamedTuple):
    """Tangential springs of contacts, by pair and roller: see `friction`."""

    level: given("pairs")  # of what the mesh lacks of a contact's compliance over the law's A, less ½ ln Q
    stretch: state("pairs, columns")  # m, along the slip; between two kicks halfway, see `friction`
    creep: state("pairs, columns")  # m/s, at the last kick
    since: state("pairs, columns")  # s, a step where the contact was closed then, else 0
    compliance: state("pairs, columns", 1.0)  # m/N, then


class Friction(NamedTuple):
    """Tractions, by pair and roller."""

    traction: state("pairs, columns")  # N, on side 1, along +θ (counter-clockwise about side 0)
    change: state("pairs, columns")  # N, of the traction, that the bodies are still to be given
    slip: state("pairs, columns")  # m/s, before the step's kick
    slip_left: state("pairs, columns")  # m/s, after it
    mobility: state("pairs, columns")  # 1/kg, of both sides together
    coefficient: float
    overlapping: int | None  # when patches of neighbouring contacts overlap, see `friction`; None: never
    whole: bool | None  # None: no contacts share rigid bodies
    shear: Shear | None  # None: surfaces give way tangentially as the mesh does


class Spread(NamedTuple):
    """Pressure points whose forces are spread over patches, see `points`."""

    missing: given("pairs, n_points")  # m/N, compliance the mesh lacks between two points by their distance
    inverse: given("pairs, n_inverse")  # N/m, inverses for 1, 2 ... points in contact
    closed: state("pairs, n, 2", dtype=np.int64)  # first point in contact and the one after the last


class Points(NamedTuple):
    """Points of pressure contacts and of penalty springs, by pair, side and point; see `points`."""

    shift: given("pairs, 2, n_points")  # rad, of a point's direction from the line of centres
    tangent: given("pairs, 2, n_points")  # t-component of the outward normal over its n-component's size
    rise: given("pairs, n_points")  # m, by which the circles fall apart
    sagitta: given("pairs, 2")  # m, of one facet, negative in a bore; 0: exact circles
    stiffness: given("pairs")  # N/m, of one point
    energy: state("pairs, n")  # J, of this step
    # of the last kick: closings, m, forces and what it gave beside, N; or NaN
    before: state("pairs, n, 3, n_points", np.nan)
    residual: state("pairs, n")  # J, stored beyond what the kicks have taken
    closing: state("n_points")  # m, and so on: room for one contact
    force: state("n_points")  # N
    turning: state("3, n_points")
    share: room("2 * n_points * 6")  # of the nodes around each point in its force, by side
    slope: room("2 * 6")  # of these by the place, at a point
    spread: Spread | None  # None: a layer between points and surfaces


class Dampers(NamedTuple):
    """Dampers of contacts, by pair and roller: see `damping`."""

    law: ContactDamping
    whole: given("pairs")  # level of the contacts' whole approach, A Q (level − ½ ln Q)
    rate: state("pairs, columns", np.nan)  # m/s, at which approaches have grown on the way to the last kick
    # m/s, the same by the nodes' velocities, after the last damping; NaN: not damped
    left: state("pairs, columns", np.nan)
    along: state("pairs, columns")  # slope of the approach by the way of side 1 across the line of centres
    first: state("pairs, columns")  # m, the same per rad by which side 0 turns back
    second: state("pairs, columns")  # m, by which side 1 does
    force: state("pairs, columns")  # N, beside the laws below the grid
    whole_force: state("pairs, columns")  # N, beside the contacts' whole approach
    work: state("1")  # J, dissipated up to the last kick


class BodyDamping(NamedTuple):
    """Damping of bodies, in proportion to mass, see `damping`."""

    share: float  # of a velocity, that a step takes
    work: state("2")  # J, the share of twice the kinetic energy that it was of: of all kicks, and of the last
    # `Bore` of an outer ring in play, the `Housing` that carries one, or the `OuterTurn` of one; None: the ground
    around: tuple | None


class Contacts(NamedTuple):
    """All contacts. Arrays over rollers have `columns` entries, spare ones without meaning or 0."""

    forces: Forces
    patches: Patches
    friction: Friction
    points: Points | None  # None: the law below the grid
    reach: float  # m, a wider gap than any elastic motion can close
    dampers: Dampers | None = None  # None: contacts without


class Drive(NamedTuple):
    """The hub and what acts on it."""

    hub: state("2")  # m
    velocity: state("2")  # m/s, at t − dt/2
    frame: state("3")  # turn of the shaft, its cosine and sine
    impulse: state("2")  # N s, of this step, by contacts on the inner ring as a whole
    moment: state("2")  # of this step, by contacts: on the frame, N m; on the nodes about the origin, N m s
    sums: state("6")  # so far: work of the load, J; moment on hub and ring but for drive and gravity, N m s;
    # work of tractions, J; that of gravity, and what it was at which time
    mass: float  # hub and held nodes, kg
    late_mass: float  # kg, see `mounts`
    speed: float  # rad/s
    gravity: float  # m/s²
    dt: float
    slowed: state("2, 2")  # m, that the reciprocal mass adds to the hub's motion: in the last step, in the next
    slowing: float  # γ dt², s², see `reciprocal_mass`
    calming: float  # β dt, s
    radial_load: float  # N
    ramp: float  # s, 0: full load at once
    history: LoadHistory | None = None  # of speed and load; None: they stay


class Bodies(NamedTuple):
    """Everything that moves, but for the hub."""

    rollers: Rollers
    disc: Disc  # the rollers' nodes
    surface: DiscSurface | RigidDisc  # of the rollers
    inner: Ring
    outer: Ring
    others: tuple = ()  # further bodies; see `bodies`
    damping: BodyDamping | None = None  # of rollers and rings; None: they have none


class Scratch(NamedTuple):
    """Room to work in; nothing here outlives a step."""

    bore: room("2, inner")
    line: room("2, outer")
    torque: room("columns")
    still: room("columns")  # 0
    shift: room("2, columns")
    cosine: room("columns", 1.0)  # of the frames' turn in a step
    sine: room("columns")
    rollers_w: np.ndarray  # copies of velocities before a kick
    rollers_velocity: np.ndarray
    inner_w: np.ndarray
    outer_w: np.ndarray
    hub_velocity: room("2")

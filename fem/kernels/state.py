"""The arrays the time loop works on, grouped by body. Plain named tuples: numba passes them by reference.

A body's `rigid` is a tuple whose length is part of its type: none of an elastic body, one entry of a rigid one, which
has no nodes. What a scene's bodies do not need is thereby not compiled.
"""

from typing import NamedTuple

import numpy as np

INNER, OUTER, ROLLER = 0, 1, 2  # kinds of contact: inner raceway, outer raceway, roller j with j + 1


class Rollers(NamedTuple):
    """All rollers. Frames: see `disc_kernels`. Arrays over rollers have `columns` entries, spare ones 0."""

    starts: np.ndarray  # rows of 2 x 2 blocks
    neighbours: np.ndarray
    blocks: np.ndarray  # −dt·M⁻¹K
    points: np.ndarray  # (2 n_nodes,), m
    mass: np.ndarray  # (n_nodes,), kg
    lightness: np.ndarray  # (n_nodes,), 1/kg: 1/mass
    u: np.ndarray  # (n_nodes · 2 · columns,), m
    w: np.ndarray  # m/s
    centre: np.ndarray  # (2, columns), m
    velocity: np.ndarray  # (2, columns), m/s, at t − dt/2
    turn: np.ndarray  # (columns,), rad, of the frames
    cosine: np.ndarray  # of turn
    sine: np.ndarray
    increment: np.ndarray  # rad, the frames' next turn
    lead: np.ndarray  # rad, by which the bodies lead their frames
    spin: np.ndarray  # rad/s
    impulse: np.ndarray  # (2, columns), N s, of this step, through nodes
    tilt: np.ndarray  # (2, columns), N s, of this step, on the whole body
    turn_kick: np.ndarray  # (columns,), rad/s, of this step, turning the whole body
    first_surface: int
    n_surface: int
    n: int
    columns: int
    total_mass: float
    inertia: float
    radius: float
    rigid: tuple[int, ...]


class Ring(NamedTuple):
    """One ring. Frames: see `ring_kernels`. A rigid one is a held row of one node, at the radius of gyration."""

    table: np.ndarray  # −dt·M⁻¹K
    u: np.ndarray  # (n_rows, 2, n_sectors + 2 HALO)
    w: np.ndarray
    radii: np.ndarray
    row_mass: np.ndarray
    cosines: np.ndarray  # (n_sectors + 2 HALO,), of the sectors' angles
    sines: np.ndarray
    n_sectors: int
    first_row: int  # free rows
    last_row: int
    raceway: int
    held: int
    radius: float  # of the raceway
    rigid: tuple[int, ...]


class Resolved(NamedTuple):
    """Points of resolved and of penalty contacts, by kind, side and point; see `resolved_kernels`."""

    shift: np.ndarray  # (3, 2, n_points), rad, of a point's direction from the line of centres
    tangent: np.ndarray  # (3, 2, n_points), t-component of the outward normal over its n-component's size
    rise: np.ndarray  # (3, n_points), m, by which the circles fall apart
    sagitta: np.ndarray  # (3, 2), m, of one facet, negative in a bore; 0: exact circles
    stiffness: np.ndarray  # (3,), N/m, of one point
    energy: np.ndarray  # (3, n), J, of this step
    before: np.ndarray  # (3, n, 3, n_points), of the last kick: closings, m, forces and what it gave beside, N; or NaN
    owed: np.ndarray  # (3, n), J, stored beyond what the kicks have taken
    closing: np.ndarray  # (n_points,), m, and so on: room for one contact
    force: np.ndarray  # (n_points,), N
    turning: np.ndarray  # (3, n_points)
    # of points spread over patches: see `spread_kernels`; None: a layer between points and surfaces
    lack: np.ndarray | None  # (3, n_points), m/N, what the mesh lacks between two points by their distance
    inverse: np.ndarray | None  # (3, ...), N/m, inverses for 1, 2 ... points in contact
    closed: np.ndarray | None  # (3, n, 2), first point in contact and the one after the last
    share: np.ndarray | None  # (2 · n_points · 6,), of the nodes around each point, by side
    slope: np.ndarray | None  # (2 · 6,), room


class Contacts(NamedTuple):
    """All contacts, by kind and roller; side 0 is the ring (or roller j), side 1 the roller (or roller j + 1).

    Arrays over rollers have `columns` entries, spare ones without meaning or 0.
    """

    A: np.ndarray  # (3,)
    B: np.ndarray
    Q_line: np.ndarray
    reach: float  # m, a wider gap than any elastic motion can close
    half_width_factor: np.ndarray  # b²/Q
    curvature: np.ndarray  # 1/R, 1/m
    roller_ripple: np.ndarray
    inner_ripple: np.ndarray
    outer_ripple: np.ndarray
    force: np.ndarray  # (3, columns), N
    approach: np.ndarray  # (3, columns), m, below the grid, at the last kick; negative: apart; NaN: far apart
    push: np.ndarray  # (3, columns), N, that the last kick gave: see `kick_force`
    owed: np.ndarray  # (3, columns), J, stored beyond what the kicks have taken: see `kick_force`
    bracket: np.ndarray  # (3, columns), B with the ripples of the present positions
    traction: np.ndarray  # (3, columns), N, on side 1, along +θ (counter-clockwise about side 0)
    change: np.ndarray  # (3, columns), N, of the traction, that the bodies are still to be given
    normal: np.ndarray  # (3, 2, columns), unit, from side 0 to side 1 (outer contact: outward)
    slip: np.ndarray  # (3, columns), m/s, before the step's kick
    crowded: bool  # patches of neighbouring contacts may overlap on a raceway
    crowded_rollers: bool  # on a roller, where it touches its neighbours
    stretch: tuple[int, ...]  # m entries: what nodes carry of a contact is kept for 6 m of them
    # patches: 2·kind + side
    start: np.ndarray  # (6, columns), first surface node or sector
    weight: np.ndarray  # (6, 6 m, columns)
    outward: np.ndarray  # (6, 2, columns), of a roller, unit, in its frame
    along: np.ndarray  # (6, 6 m, columns), of a ring: weight times the cosine of the angle to the node's radius
    across: np.ndarray  # times the sine
    scale: np.ndarray  # (6, columns), of the tangential directions, see `patch_kernels`
    lean: np.ndarray  # (6, columns)
    mobility: np.ndarray  # (3, columns), 1/kg, of both sides together
    resolved: Resolved | None  # None: the law below the grid


class Drive(NamedTuple):
    """The hub and what acts on it."""

    hub: np.ndarray  # (2,), m
    velocity: np.ndarray  # (2,), m/s, at t − dt/2
    impulse: np.ndarray  # (2,), N s, of this step, by contacts' tilt
    ring: (
        np.ndarray
    )  # (5,): turn, cosine, sine; in this step, by contacts: moment on the frame, N m, held by the drive,
    # and moment on the nodes about the origin, N m s
    sums: np.ndarray  # (5,), so far: work of the load, J; moment on hub and ring but for drive and gravity, N m s;
    # dissipated work, J; that of gravity, and what it was at which time
    mass: float  # hub and held nodes, kg
    speed: float  # rad/s
    gravity: float  # m/s²
    friction: float
    dt: float
    load: float  # N
    ramp: float  # s, 0: full load at once


class Scratch(NamedTuple):
    """Room to work in; nothing here outlives a step."""

    slope: np.ndarray  # (6 m, 8)
    slip: np.ndarray  # (3, columns)
    bore: np.ndarray  # (2, inner n_sectors + 2 HALO)
    line: np.ndarray  # (2, outer n_sectors + 2 HALO)
    team: np.ndarray | None  # (threads,); None: one
    torque: np.ndarray  # (threads · columns,)
    still: np.ndarray  # (columns,)
    shift: np.ndarray  # (2, columns)
    cosine: np.ndarray  # (columns,), of the frames' turn in a step
    sine: np.ndarray
    rollers_w: np.ndarray  # copies of velocities before a kick
    rollers_velocity: np.ndarray
    inner_w: np.ndarray
    outer_w: np.ndarray
    hub_velocity: np.ndarray  # (2,)

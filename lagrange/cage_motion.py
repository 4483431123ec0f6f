"""A cage in the Lagrangian model: its samples, and the forces on rolling elements by which it holds their angles.

Among free elements a cage is a rigid body of its own; its springs' forces and energies follow from places alone and are
found here, at the samples. With kinematic angles it is what holds the elements at them, without mass or clearance.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Cage, Operation
from lagrange.kinematics import kinematics, roller_angles
from lagrange.motion import ContactState, State, accelerations, housing_accelerations

SMALLEST = 1e-30  # m
LOSSES = ("dashpots", "friction", "drag")


@dataclass(frozen=True, kw_only=True)
class CageSamples:
    """Motion of a cage at samples, under the result file's names without "cage_"; (n_times,) unless said."""

    x: np.ndarray  # m
    y: np.ndarray
    angle: np.ndarray  # rad, since t = 0
    speed: np.ndarray  # rad/s
    guidance_x: np.ndarray  # N, of the guiding ring on the cage
    guidance_y: np.ndarray
    work_dashpots: np.ndarray  # J
    work_friction: np.ndarray
    work_drag: np.ndarray
    force: np.ndarray  # (n_times, n_rollers), N, on the elements, forward along the pitch circle
    radial_force: np.ndarray  # (n_times, n_rollers), N, on them, outward
    moment: np.ndarray  # (n_times, n_rollers), N m, of friction on them, about their centres


@dataclass(frozen=True, kw_only=True)
class CageRows:
    """A free cage as the steps leave it at samples."""

    place: np.ndarray  # (n_times, 3), m and rad, from the outer ring's centre
    rate: np.ndarray  # (n_times, 3)
    lost: np.ndarray  # (n_times, 3), J, see LOSSES
    guide: np.ndarray  # (n_times, 2), N, by dashpot and by friction at the guide
    pockets: np.ndarray  # (n_times, 2, n_rollers), N, likewise in the pockets

    @classmethod
    def of(cls, rows: np.ndarray) -> "CageRows":
        """Of rows as wide as `row_width` says."""
        return cls(
            place=rows[:, :3], rate=rows[:, 3:6], lost=rows[:, 6:9], guide=rows[:, 9:11],
            pockets=rows[:, 11:].reshape(len(rows), 2, -1),
        )  # fmt: skip


def first_row(n_rollers: int, speed: float) -> np.ndarray:
    """A cage at the start: concentric, turning with the elements, rad/s; nothing touches."""
    row = np.zeros(11 + 2 * n_rollers)
    row[5] = speed
    return row


@dataclass(frozen=True, kw_only=True)
class FreeCage:
    """A free cage's quantities at samples."""

    samples: CageSamples
    kinetic: np.ndarray  # (n_times,), J
    stored: np.ndarray  # (n_times,), J, in its springs
    lift: np.ndarray  # (n_times,), kg m, mass times height
    dissipated: np.ndarray  # (n_times,), J
    push: np.ndarray  # (2, n_times), N, on the hub, x and y
    push_on_ring: np.ndarray  # (2, n_times), N, on an outer ring in a housing


def free_cage(bearing: Bearing, cage: Cage, state: State, rows: CageRows, first_angle: float) -> FreeCage:
    """A free cage's forces and energies beside elements and hub in a state.

    Parameters
    ----------
    rows : of the state's samples
    first_angle : rad, of the first pocket at t = 0

    Errors
    ------
    Springs' forces are those of the samples' places; dashpots' and friction's are the last step's.
    """
    angle = roller_angles(bearing, first_angle) + rows.place[:, 2:]
    ahead_x, ahead_y = -np.sin(angle), np.cos(angle)
    x = state.rho * np.cos(state.theta) - rows.place[:, :1]
    y = state.rho * np.sin(state.theta) - rows.place[:, 1:2]
    if cage.guidance == "rollers":
        x, y = x - bearing.pitch_radius * ahead_y, y + bearing.pitch_radius * ahead_x
        off = np.hypot(x, y)
        nx, ny = x / np.maximum(off, SMALLEST), y / np.maximum(off, SMALLEST)
    else:
        along = x * ahead_x + y * ahead_y
        off, nx, ny = np.abs(along), np.sign(along) * ahead_x, np.sign(along) * ahead_y
    depth = np.maximum(off - 0.5 * cage.pocket_clearance, 0.0)
    pushed, rubbed = rows.pockets[:, 0] - cage.stiffness * depth, rows.pockets[:, 1]
    fx, fy = pushed * nx + rubbed * ny, pushed * ny - rubbed * nx
    guided_x, guided_y, sunk = _guided(cage, state, rows)
    against = -np.array([guided_x, guided_y])
    place_x, place_y = rows.place[:, 0] + state.ring_x, rows.place[:, 1] + state.ring_y  # in the fixed frame
    rate_x, rate_y = rows.rate[:, 0] + state.ring_x_rate, rows.rate[:, 1] + state.ring_y_rate
    samples = CageSamples(
        x=place_x, y=place_y, angle=rows.place[:, 2], speed=rows.rate[:, 2],
        guidance_x=guided_x, guidance_y=guided_y, force=fx * ahead_x + fy * ahead_y,
        radial_force=fx * ahead_y - fy * ahead_x, moment=-rubbed * bearing.roller_radius,
        **{f"work_{name}": rows.lost[:, k] for k, name in enumerate(LOSSES)},
    )  # fmt: skip
    return FreeCage(
        samples=samples,
        kinetic=0.5 * (cage.mass * (rate_x**2 + rate_y**2) + cage.inertia * rows.rate[:, 2] ** 2),
        stored=0.5 * cage.stiffness * (np.sum(depth**2, axis=1) + sunk**2),
        lift=cage.mass * place_y,
        dissipated=np.sum(rows.lost, axis=1),
        push=against if cage.guidance == "inner_ring" else 0.0 * against,
        push_on_ring=against if cage.guidance == "outer_ring" else 0.0 * against,
    )


def _guided(cage: Cage, state: State, rows: CageRows):
    """Force of the guide on the cage, N, x and y, and how deep it is in it, m."""
    if cage.guidance_clearance is None:
        nothing = np.zeros(len(rows.place))
        return nothing, nothing, nothing
    x, y = rows.place[:, 0], rows.place[:, 1]
    if cage.guidance == "inner_ring":
        x, y = x - state.x, y - state.y
    off = np.hypot(x, y)
    nx, ny = x / np.maximum(off, SMALLEST), y / np.maximum(off, SMALLEST)
    depth = np.maximum(off - 0.5 * cage.guidance_clearance, 0.0)
    pushed, rubbed = rows.guide[:, 0] - cage.stiffness * depth, rows.guide[:, 1]
    return pushed * nx - rubbed * ny, pushed * ny + rubbed * nx, depth


def holding_cage(bearing: Bearing, operation: Operation, time, state: State, touch: ContactState) -> CageSamples:
    """The kinematic cage at times, (n_times,), s: the forces along θ that hold the elements at their angles.

    Parameters
    ----------
    operation : that of the run's start; its history tells how the cage speeds up
    """
    nothing, per_roller = np.zeros(len(time)), np.zeros(state.rho.shape)
    history = operation.history
    gain = 0.0 if history is None else kinematics(bearing, *history.ring_speeds(time[:, None], 1)).cage
    ring = housing_accelerations(bearing, operation, state, touch)
    *_, free = accelerations(bearing, operation, state, touch, ring)
    force = bearing.roller_mass * state.rho * (gain - free)
    return CageSamples(
        x=nothing + state.ring_x, y=nothing + state.ring_y, angle=state.theta[:, 0] - operation.first_roller_angle,
        speed=state.theta_rate[:, 0],
        guidance_x=nothing, guidance_y=nothing, force=force, radial_force=per_roller, moment=per_roller,
        **{f"work_{name}": nothing for name in LOSSES},
    )  # fmt: skip

"""What is solved: a bearing at an operating point under contact laws, the model's choices, and where it starts."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.cage import Cage
from lagrange.contact_damping import UNDAMPED, ContactDamping
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.motion import State
from lagrange.mounting import ring_place
from lagrange.profile import Turns
from lagrange.raceway_laws import ContactLaws
from lagrange.statics import static_equilibrium

DIFFERENCE = 1e-6  # s, for the velocities of the moving equilibrium
NO_MOVE = 1e-9  # m within that time, below which a jump doesn't matter


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One motion to be found; the parameters are those of `lagrange.simulate`.

    Errors
    ------
    ValueError: impossible choices.
    """

    bearing: Bearing
    operation: Operation
    laws: ContactLaws
    start: Literal["equilibrium", "rest"] = "equilibrium"
    angles: Literal["kinematic", "free"] = "kinematic"
    damping: ContactDamping = UNDAMPED  # of every closed contact
    load_ramp: float = 0.0  # s
    cage: Cage | None = None  # free angles: a body of its own; else what holds the angles

    def __post_init__(self):
        if not (min(vars(self.damping).values()) >= 0.0 and self.load_ramp >= 0.0):
            raise ValueError(f"damping = {self.damping}, load_ramp = {self.load_ramp}: both must be at least 0")
        if self.start not in ("equilibrium", "rest") or self.angles not in ("kinematic", "free"):
            raise ValueError(
                f"start = {self.start!r}, angles = {self.angles!r}: equilibrium or rest, kinematic or free"
            )

    @property
    def free_cage(self) -> Cage | None:
        """The cage, where it moves by the forces on it."""
        return self.cage if self.angles == "free" else None

    @property
    def is_damped(self) -> bool:
        """Whether contacts, a free cage or what holds shaft and housing take energy."""
        mounting = self.operation.mounting
        dashpots = (part.damping > 0.0 for part in (mounting.shaft, mounting.housing) if part is not None)
        return self.damping.acts or self.free_cage is not None or any(dashpots)

    @cached_property
    def first_state(self) -> State:
        """The state at t = 0.

        Errors
        ------
        RuntimeError: no equilibrium to start from.
        """
        bearing, operation = self.bearing, self.operation
        theta = roller_angles(bearing, operation.first_roller_angle)
        ideal = kinematics(bearing, operation.speed)
        cage = ideal.cage
        zero = np.zeros(bearing.n_rollers)
        if self.start == "rest":
            ring = ring_place(replace(operation.mounting, shaft=None), self._weight_on_springs, lambda _: np.zeros(2))
            return State(
                x=0.0, y=0.0, rho=zero + bearing.pitch_radius, theta=theta,
                x_rate=0.0, y_rate=0.0, rho_rate=zero, theta_rate=zero + cage, ring_x=ring[0], ring_y=ring[1],
            )  # fmt: skip
        if self.load_ramp > 0.0:
            operation = replace(operation, radial_load=0.0, side_load=0.0, course=None)

        def force_at(place):
            still = static_equilibrium(bearing, operation, self.laws, angles=theta, ring=place)
            return np.array([still.outer_force @ np.cos(theta), still.outer_force @ np.sin(theta)])

        ring = ring_place(operation.mounting, self._weight_on_springs, force_at)
        now = static_equilibrium(bearing, operation, self.laws, angles=theta, ring=ring)
        before, after = (
            static_equilibrium(
                bearing,
                operation.at(shift),
                self.laws,
                angles=theta + turned(bearing, operation, shift).cage,
                start=(now.x, now.y),
                turns=Turns.rolling(bearing, operation, shift),
                ring=ring,
            )
            for shift in (-DIFFERENCE, DIFFERENCE)
        )
        earlier, middle, later = (np.array([s.x, s.y, *s.rho]) for s in (before, now, after))
        rates = (later - earlier) / (2.0 * DIFFERENCE)
        bend, move = np.abs(later + earlier - 2.0 * middle), np.abs(later - earlier)
        if np.any((bend > 0.5 * move) & (np.maximum(bend, move) > NO_MOVE)):
            rates[:] = 0.0  # the equilibrium jumps here: a ring in clearance that tips from roller to roller
        return State(
            x=now.x, y=now.y, rho=now.rho, theta=theta,
            x_rate=rates[0], y_rate=rates[1], rho_rate=rates[2:], theta_rate=zero + cage,
            ring_x=ring[0], ring_y=ring[1],
        )  # fmt: skip

    @property
    def _weight_on_springs(self) -> float:
        """Of a housing and its outer ring, N; 0 without."""
        housing = self.operation.mounting.housing
        return 0.0 if housing is None else self.operation.gravity * (housing.mass + self.bearing.outer_ring_mass)

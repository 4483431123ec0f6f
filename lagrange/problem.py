"""What is solved: a bearing at an operating point under contact laws, the model's choices, and where it starts."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from lagrange.bearing import Bearing, Operation
from lagrange.cage import Cage
from lagrange.contact_damping import UNDAMPED, ContactDamping
from lagrange.first_state import FirstState, equilibrium_state, rest_state
from lagrange.raceway_laws import ContactLaws


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
    def first_state(self) -> FirstState:
        """The state at t = 0, and what to say of it.

        Errors
        ------
        RuntimeError: no equilibrium to start from.
        """
        if self.start == "rest":
            return rest_state(self.bearing, self.operation)
        operation = self.operation
        if self.load_ramp > 0.0:
            operation = replace(operation, radial_load=0.0, side_load=0.0, course=None)
        return equilibrium_state(self.bearing, operation, self.laws)

"""A cage's motion and forces in a run, and how much of them reaches the hub."""

from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Cage

COLUMNS = {  # of a result file, by what they are here
    "cage_x": "x",
    "cage_y": "y",
    "cage_angle": "angle",
    "cage_guidance_x": "guidance_x",
    "cage_guidance_y": "guidance_y",
    "cage_force": "force",
    "cage_moment": "moment",
}


@dataclass(frozen=True, kw_only=True)
class CageMotion:
    """A cage's samples."""

    x: np.ndarray  # (n_times,), m, of its centre
    y: np.ndarray
    angle: np.ndarray  # (n_times,), rad, since the run's start
    guidance_x: np.ndarray  # (n_times,), N, of the guiding ring on the cage
    guidance_y: np.ndarray
    force: np.ndarray  # (n_times, n_rollers), N, on the rollers, forward
    moment: np.ndarray  # (n_times, n_rollers), N m, on the rollers about their centres

    @property
    def by_column(self) -> dict[str, np.ndarray]:
        """The arrays by the result file's names."""
        return {column: getattr(self, name) for column, name in COLUMNS.items()}

    def samples(self, part: slice) -> "CageMotion":
        """Restrict the cage to some samples."""
        return CageMotion(**{name: value[part] for name, value in vars(self).items()})

    def speed(self, interval: float) -> float:
        """Mean angular speed, rad/s; samples are so many s apart."""
        return float((self.angle[-1] - self.angle[0]) / (interval * (self.angle.size - 1)))

    def whirl(self, interval: float) -> float:
        """Mean angular speed of its centre about the bearing's, rad/s."""
        angle = np.unwrap(np.arctan2(self.y, self.x))
        return float((angle[-1] - angle[0]) / (interval * (self.angle.size - 1)))


def traction_against(cage: CageMotion, bearing: Bearing) -> np.ndarray:
    """Part of the inner raceway's tractions that stands against the cage's forces on rollers, N, (n_times, n_rollers).

    A roller's equations of motion along the pitch circle and about its centre give its two tractions from its inertia,
    the cage's force F and moment M: of the inner one F and M take −½ (F − M/radius).
    """
    return -0.5 * (cage.force - cage.moment / bearing.roller_radius)


def push_on_hub(cage: CageMotion, facts: Cage | None) -> tuple[np.ndarray, np.ndarray]:
    """Force of the cage on the hub that guides it, N, x and y, each (n_times,)."""
    if facts is None or facts.guidance != "inner_ring":
        return np.zeros_like(cage.x), np.zeros_like(cage.x)
    return -cage.guidance_x, -cage.guidance_y

"""What a bearing stands in: the housing of its outer ring, and a sensor on it; facts, SI."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

OF_HOUSING = ("housing_x", "housing_y", "housing_ax", "housing_ay", "energy_support")  # what samples tell of it
OF_SENSOR = ("sensor_ay",)


@dataclass(frozen=True, kw_only=True)
class Housing:
    """A rigid body around the outer ring, on springs and dashpots along x and y to the ground. It does not turn."""

    mass: float  # kg, without the outer ring
    stiffness: float  # N/m, along either axis
    damping: float  # N s/m


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A resonator on the housing, along y, so light that the housing does not feel it: base-excited.

    Its displacement r relative to the housing obeys r̈ + 2ζω ṙ + ω² r = −Ÿ; it shows its own acceleration Ÿ + r̈.
    """

    frequency: float  # Hz, undamped
    damping_ratio: float  # below 1

    def step(self, seconds: float) -> np.ndarray:
        """What so many seconds under a constant acceleration of the housing make of its state, exactly, (2, 3).

        Columns: of r, m, of ṙ, m/s, and of Ÿ, m/s²; rows: r and ṙ then.
        """
        omega, zeta = 2.0 * pi * self.frequency, self.damping_ratio
        damped = omega * sqrt(1.0 - zeta**2)
        c, s = np.cos(damped * seconds), np.sin(damped * seconds) * omega / damped
        free = np.exp(-zeta * omega * seconds) * np.array([[c + zeta * s, s / omega], [-omega * s, c - zeta * s]])
        still = np.array([-1.0 / omega**2, 0.0])  # where it rests under a unit acceleration
        return np.column_stack([free, still - free @ still])

    @property
    def pull(self) -> np.ndarray:
        """Its own acceleration by r and by ṙ, (2,), 1/s² and 1/s."""
        omega = 2.0 * pi * self.frequency
        return -np.array([omega**2, 2.0 * self.damping_ratio * omega])


@dataclass(frozen=True, kw_only=True)
class Points:
    """Arcs of its outside in which the ground holds the outer ring, which is free between them."""

    angles: tuple[float, ...]  # rad from +x, of their middles
    width: float  # m, of each, along the outside


@dataclass(frozen=True, kw_only=True)
class Mounting:
    """How the bearing is held. Without points and without a housing the ground holds the outer ring all around."""

    points: Points | None = None
    housing: Housing | None = None
    sensor: Sensor | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of what samples tell of it, as they stand behind each other."""
        if self.housing is None:
            return ()
        return OF_HOUSING if self.sensor is None else (*OF_HOUSING, *OF_SENSOR)


HELD = Mounting()


def from_outer_ring(samples: Mapping[str, np.ndarray], *bodies: str) -> list[np.ndarray]:
    """Places <body>_x, <body>_y, ... of samples from the outer ring's centre, which a housing may move, m."""
    found = []
    for body in bodies:
        for axis in "xy":
            place = samples[f"{body}_{axis}"]
            moved = samples.get(f"housing_{axis}")
            found.append(place if moved is None else (place.T - moved).T)
    return found

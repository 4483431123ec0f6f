"""What holds a bearing in its machine: its outer ring's housing and fit, a sensor on it, its shaft's springs; SI."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from math import pi, sqrt

import numpy as np
from numpy import ndarray

from lagrange.columns import columns_of

OF_HOUSING, OF_BORE = tuple(columns_of("housing")), tuple(columns_of("bore"))  # columns of samples
PARTS = ("housing", "sensor", "shaft", "bore")  # of a mounting that samples have columns of
ENERGIES = tuple(name for name, column in columns_of(*PARTS).items() if column.unit == "J")  # among these

LOOK_AROUND = 1e-8  # relative, for derivatives, of what statics are exact to 1e-10 of
SETTLED, FINEST = 1e-7, 1e-7  # of the way that a housing sinks, m


@dataclass(frozen=True, kw_only=True)
class Housing:
    """A rigid body around the outer ring, on springs and dashpots along x and y to the ground. It does not turn."""

    mass: float  # kg, without the outer ring
    stiffness: float  # N/m, along either axis
    damping: float  # N s/m


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A resonator on the housing, along y, too light to react on the housing: base-excited.

    Its displacement r relative to the housing obeys r̈ + 2ζω ṙ + ω² r = −Ÿ; it shows its own acceleration Ÿ + r̈.
    """

    frequency: float  # Hz, undamped
    damping_ratio: float  # below 1

    def step(self, seconds: float) -> ndarray:
        """What so many seconds under a constant Ÿ make of its state, exactly, (2, 3): r, ṙ then by r, ṙ and Ÿ, SI."""
        omega, zeta = 2.0 * pi * self.frequency, self.damping_ratio
        damped = omega * sqrt(1.0 - zeta**2)
        c, s = np.cos(damped * seconds), np.sin(damped * seconds) * omega / damped
        free = np.exp(-zeta * omega * seconds) * np.array([[c + zeta * s, s / omega], [-omega * s, c - zeta * s]])
        still = np.array([-1.0 / omega**2, 0.0])  # where it rests under a unit acceleration
        return np.column_stack([free, still - free @ still])

    @property
    def pull(self) -> ndarray:
        """Its own acceleration by r and by ṙ, (2,), 1/s² and 1/s."""
        omega = 2.0 * pi * self.frequency
        return -np.array([omega**2, 2.0 * self.damping_ratio * omega])


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """Springs and dashpots between hub and ground, along x and along y: what else holds the shaft.

    They are slack where the hub's centre is at the origin. The dashpots stand still; they do not turn with the shaft.
    """

    stiffness: float  # N/m, along either axis
    damping: float  # N s/m

    def force(self, place, velocity):
        """On the hub along an axis, N, at its place, m, and velocity, m/s, along it; any shape."""
        return -self.stiffness * place - self.damping * velocity


@dataclass(frozen=True, kw_only=True)
class Points:
    """Arcs of its outside in which the ground holds the outer ring, which is free between them."""

    angles: tuple[float, ...]  # rad from +x, of their middles
    width: float  # m, of each, along the outside


@dataclass(frozen=True, kw_only=True)
class Bore:
    """A round bore around the outer ring, of a housing or of the ground, that pushes where they touch and never pulls.

    Its deflection is proportional to the local pressure (Winkler's bed); it has no friction; only the
    ring's turning as a whole is held.
    """

    clearance: float  # m, its diameter less the ring's; negative: a press fit
    stiffness: float | None = None  # N/m³, pressure over displacement; None: of a thick wall

    def stiffness_around(self, radius: float, lame_mu: float) -> float:
        """Its stiffness, N/m³, around a ring of an outside radius R, m; without one of its own that of a thick wall.

        Pushed all around by p, a wall much thicker than R, of the ring's shear modulus μ, Pa, widens by p R/2μ.
        Source: Timoshenko and Goodier, Theory of Elasticity (1970), section 28, thick tube (Lamé), outside → ∞.
        """
        return 2.0 * lame_mu / radius if self.stiffness is None else self.stiffness


@dataclass(frozen=True, kw_only=True)
class Mounting:
    """How the bearing is held. Without points, housing and bore the ground holds the outer ring all around."""

    points: Points | None = None
    housing: Housing | None = None
    bore: Bore | None = None  # of the housing, or of the ground; None: the ring is held all around, without play
    sensor: Sensor | None = None
    shaft: Shaft | None = None  # None: the bearing alone carries the hub

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of what samples have of it, as they stand behind each other."""
        return tuple(columns_of(*self.parts))

    @property
    def parts(self) -> tuple[str, ...]:
        return tuple(part for part in PARTS if getattr(self, part) is not None)

    @property
    def rows(self) -> dict[str, str]:
        """What --dry-run shows of it, name and value."""
        found, h, bore, shaft = dict[str, str](), self.housing, self.bore, self.shaft
        if h is not None:
            found["housing"] = f"{h.mass:.4g} kg without the ring, on {h.stiffness:.4g} N/m, {h.damping:.4g} N s/m"
        if bore is not None:
            kind = "play" if bore.clearance >= 0.0 else "press fit"
            found["fit of the outer ring"] = f"{1e6 * abs(bore.clearance):.4g} µm of {kind} in its bore"
        if shaft is not None:
            springs = f"{shaft.stiffness:.4g} N/m, {shaft.damping:.4g} N s/m"
            found["springs of the shaft"] = f"{springs} parallel to the bearing"
        return found

    @property
    def centre(self) -> tuple[str, ...]:
        """Names of the outer ring's centre, x and y, and of its accelerations; none where it stands still."""
        if self.bore is not None:
            return OF_BORE[:4]
        return () if self.housing is None else OF_HOUSING[:4]

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the columns that tell where housing and outer ring are, as far as they move."""
        return tuple(name for name in self.columns if name in (*OF_HOUSING[:2], *OF_BORE[:2]))


HELD = Mounting()


def ring_place(mounting: Mounting, weight: float, force_at: Callable[[ndarray], ndarray]) -> ndarray:
    """Where the outer ring's centre stands in its housing, (2,), m; 0 without one. RuntimeError: no place is found.

    weight : N, of housing and ring; force_at : the contacts' force on the ring, (2,), N, by its place, which matters
    with a shaft's springs alone: they pull the more the further ring and hub have sunk.
    """
    housing = mounting.housing
    if housing is None:
        return np.zeros(2)

    def sunk(place):
        return (force_at(place) - np.array([0.0, weight])) / housing.stiffness

    first = sunk(np.zeros(2))
    if mounting.shaft is None:
        return first
    from scipy.optimize import root

    found = root(lambda place: place - sunk(place), first, options={"xtol": 1e-12, "eps": LOOK_AROUND})
    if np.abs(found.fun).max() > SETTLED * max(np.abs(found.x).max(), FINEST):
        raise RuntimeError(f"the housing does not settle between its springs and the shaft's: {found.message}")
    return found.x


def from_outer_ring(samples: Mapping[str, ndarray], *bodies: str) -> list[ndarray]:
    """Places <body>_x, <body>_y, ... of samples from the outer ring's centre, which its mounting may move, m."""
    found = []
    for body, axis in product(bodies, "xy"):
        place, moved = samples[f"{body}_{axis}"], samples.get(f"outer_ring_{axis}")
        moved = samples.get(f"housing_{axis}") if moved is None else moved
        found.append(place if moved is None else (place.T - moved).T)
    return found

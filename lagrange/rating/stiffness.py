"""The hub's 2 × 2 stiffness and damping over a pitch of the rollers, whatever contacts carry it. SI.

K_ij = ∂F_i/∂x_j at a fixed angle of the cage, everything else in equilibrium again; exact, by the implicit function
theorem, where each balance is solved. y is against the load, x along it to the right.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy import ndarray

from lagrange.bearing import Bearing, Operation, stiffness_factor
from lagrange.contact.damping import UNDAMPED, ContactDamping
from lagrange.contact.laws import ContactLaws
from lagrange.equations import overlaps
from lagrange.kinematics import roller_angles
from lagrange.mounting import HELD
from lagrange.statics import static_equilibrium

SAMPLES = 64  # cage angles in a pitch; stiffness jumps where contacts open, so that means are off by 0.5 % at most
LOOSE = 1.0  # N/m, of rollers that nothing holds
HARMONICS = 6
ON_LINE = 1e-12  # cosine of an angle that is the load's


@dataclass(frozen=True, kw_only=True)
class Point:
    """Equilibrium of a bearing's section at an angle of the cage."""

    place: ndarray  # (2,), m, of the hub from the outer ring's centre
    rho: ndarray  # (n_rollers,), m
    inner_force: ndarray  # (n_rollers,), N
    outer_force: ndarray
    stiffness: ndarray  # (2, 2), N/m
    damping: ndarray  # (2, 2), N s/m


@dataclass(frozen=True, kw_only=True)
class Pitch(Point):
    """Equilibria over a pitch of the rollers, equally spaced: of a bearing, with the forces of its contacts.

    Arrays of `Point` begin with the angles, (n, ...); ρ stays the section's.
    """

    turned: ndarray  # (n,), rad, of the cage from its first angle
    theta: ndarray  # (n, n_rollers), rad from +x

    @property
    def mean(self) -> ndarray:
        """Stiffness, (2, 2), N/m, mean over the pitch."""
        return self.stiffness.mean(axis=0)

    @property
    def range(self) -> ndarray:
        """Lowest and highest stiffness by entry, (2, 2, 2), N/m."""
        return np.stack([self.stiffness.min(axis=0), self.stiffness.max(axis=0)])

    @property
    def harmonics(self) -> ndarray:
        """Amplitudes at 1, 2 ... times the rollers' passage, (HARMONICS, 2, 2), N/m."""
        return (np.abs(np.fft.rfft(self.stiffness, axis=0)) * 2.0 / len(self.turned))[1 : HARMONICS + 1]

    @property
    def is_stable(self) -> bool:
        """Whether the hub is held in every direction at every angle."""
        return bool(np.linalg.eigvalsh(self.stiffness).min() > 0.0)


def mirrored(bearing: Bearing, operation: Operation) -> bool:
    """Whether the second half of a pitch mirrors the first: roller 0 begins on the line of the load."""
    return bool(
        operation.side_load == 0.0 and not bearing.missing and abs(np.cos(operation.first_roller_angle)) < ON_LINE
    )


def over_pitch(
    bearing: Bearing, first_roller_angle: float, solve: Callable[[ndarray, Point | None], Point], samples: int,
    mirrors: bool = False,
) -> Pitch:  # fmt: skip
    """Solve at equally spaced angles of the cage, each from the one before; where rollers are missing over a turn.

    `solve` : of the rollers' angles, (n_rollers,), rad, and a point that is near; `mirrors` : of `mirrored`
    """
    turned, factor, found = bearing.period * np.arange(samples) / samples, stiffness_factor(bearing), list[Point]()
    theta = roller_angles(bearing, first_roller_angle) + turned[:, None]
    solved = samples // 2 + 1 if mirrors else samples
    for angles in theta[:solved]:
        found.append(solve(angles, found[-1] if found else None))
    found += [_mirror(found[samples - k]) for k in range(solved, samples)]
    scales = {"place": 1.0 / bearing.cosine, "stiffness": factor, "damping": factor}
    every = {name: scales.get(name, 1.0) * np.stack([vars(point)[name] for point in found]) for name in vars(found[0])}
    return Pitch(turned=turned, theta=theta, **every)


def _mirror(point):  # across the line of the load
    side, swapped = np.array([-1.0, 1.0]), np.array([[1.0, -1.0], [-1.0, 1.0]])
    return Point(
        place=side * point.place, rho=point.rho[::-1], inner_force=point.inner_force[::-1],
        outer_force=point.outer_force[::-1], stiffness=swapped * point.stiffness, damping=swapped * point.damping,
    )  # fmt: skip


def lagrangian_pitch(
    bearing: Bearing, operation: Operation, laws: ContactLaws, damping=UNDAMPED, samples: int = SAMPLES
) -> Pitch:
    """Of rigid rings on contact laws, perfect surfaces, under what loads the bearing: the shaft's springs do not.

    RuntimeError: no equilibrium.
    """
    bearing, operation = replace(bearing, faults=()), replace(operation, mounting=HELD)

    def solve(angles, near):
        try:
            still = static_equilibrium(bearing, operation, laws, angles=angles, start=near and near.place)
        except RuntimeError:
            still = static_equilibrium(bearing, operation, laws, angles=angles)
        both = still.inner_force, still.outer_force
        slopes = np.concatenate([law.slope(law.approach(q)) for law, q in zip(laws, both, strict=True)])
        rates = approach_rates(bearing, angles, still.hub, still.rho)
        return Point(
            place=still.hub, rho=still.rho, inner_force=both[0], outer_force=both[1], stiffness=still.stiffness,
            damping=damping_matrix(rates, np.diag(slopes), slopes, np.concatenate(both), damping))  # fmt: skip

    return over_pitch(bearing, operation.first_roller_angle, solve, samples, mirrored(bearing, operation))


def approach_rates(bearing: Bearing, theta: ndarray, place: ndarray, rho: ndarray) -> ndarray:
    """Approach of contacts, inner ones first, by hub and radii of rollers, (2 n_rollers, n_rollers + 2)."""
    n, met = bearing.n_rollers, overlaps(bearing, place[0], place[1], rho, theta)
    rates = np.zeros((2 * n, n + 2))
    rates[:n, :2] = np.transpose(met.normal)
    rates[:n, 2:] = np.diag(-met.radial)
    rates[n:, 2:] = np.eye(n)
    return rates


def damping_matrix(
    rates: ndarray, contacts: ndarray, slopes: ndarray, forces: ndarray, damping: ContactDamping
) -> ndarray:
    """Of the hub by the contacts' dampers, (2, 2), N s/m, so slow that massless rollers stay in balance.

    rates : of `approach_rates`
    contacts : (2 n_rollers, 2 n_rollers), N/m, forces by approaches
    slopes : (2 n_rollers,), N/m, of the contacts alone; forces : N
    """
    if not damping.acts:
        return np.zeros((2, 2))
    whole = rates.T @ contacts @ rates + LOOSE * np.eye(rates.shape[1])
    follow = -np.linalg.solve(whole[2:, 2:], whole[2:, :2])
    closing = rates[:, :2] + rates[:, 2:] @ follow
    coefficient = np.where(forces > 0.0, damping.coefficient(forces, slopes), 0.0)
    return closing.T @ (coefficient[:, None] * closing)

"""Error forces of equations (22) and (23), and what they are made of.

Where the run tells its own contact forces, the error splits exactly:

    error = differentiation + contact_law + friction + load_and_weight + ring_flexibility

differentiation   M (our acceleration − the integrator's)
contact_law       − Σ (law − run's normal force): what the law costs, and that it takes each contact alone
friction          Σ traction on the inner ring, which (22), (23) leave out
load_and_weight   W + M g of the equations less what acted in the run: the load ramp of a start from rest
ring_flexibility  the rest: inertia of the elastic ring, whose centre of mass is not the hub; the solver's own error

and the momentum balance, the run's own forces in place of the law, is differentiation + ring_flexibility.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.equations import approaches, contact_resultant, error_forces
from lagrange.kinematics import kinematics
from lagrange.load_ramp import load_share
from lagrange.overlap import Overlaps
from residual.fitted_laws import Law, law_force
from residual.trajectory import Trajectory

CHATTER = 0.05  # of a cage revolution


@dataclass(frozen=True, kw_only=True)
class Budget:
    """Error forces and their terms, each (n_times,), N. The terms of one direction add up to its error.

    `momentum_*` is None where the run does not tell its forces; then the error has no terms.
    """

    error_x: np.ndarray
    error_y: np.ndarray
    terms_x: dict[str, np.ndarray]
    terms_y: dict[str, np.ndarray]
    momentum_x: np.ndarray | None
    momentum_y: np.ndarray | None
    law_force: np.ndarray  # (n_times, n_rollers), N, the law's
    contacts: Overlaps
    closing_speed: np.ndarray  # (n_times, n_rollers), m/s, of the inner contacts
    loaded: np.ndarray  # (n_times, n_rollers), bool, inner contact closed


def acting_terms(budget: Budget) -> list[str]:
    """Terms that are not zero throughout in both directions."""
    return [name for name, x in budget.terms_x.items() if np.any(x) or np.any(budget.terms_y[name])]


def traction_resultant(contacts: Overlaps, traction) -> tuple[np.ndarray, np.ndarray]:
    """x and y components of the tangential forces on the inner ring, N, each (n_times,).

    `traction`, (n_times, n_rollers), N, acts on the roller along t = (−n_y, n_x), n pointing from the inner
    ring's centre to the roller's; the ring feels the opposite.
    """
    outward_x, outward_y = -contacts.direction_x, -contacts.direction_y
    return (
        np.sum(traction * outward_y, axis=1),
        np.sum(-traction * outward_x, axis=1),
    )


def missing_load(trajectory: Trajectory) -> np.ndarray:
    """Load of the equations that did not act yet, N, (n_times,): of a start from rest, during its ramp."""
    numerics = trajectory.scene.numerics
    ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
    return trajectory.operation.radial_load * (1.0 - load_share(trajectory.time, ramp))


def error_budget(trajectory: Trajectory, law: Law, acceleration_x, acceleration_y, closing_speed) -> Budget:
    """Error forces with a contact law, and their causes.

    Parameters
    ----------
    acceleration_x, acceleration_y : ndarray, (n_times,), m/s², of the inner ring's centre, from positions
    closing_speed : ndarray, (n_times, n_rollers), m/s, rate of the inner contacts' approach, from positions

    Errors
    ------
    The terms add up to the error to round-off, about 1e-12 of the load.
    """
    operation = trajectory.operation
    contacts = approaches(
        trajectory.bearing, trajectory.inner_x, trajectory.inner_y, trajectory.roller_x, trajectory.roller_y
    )
    force = law_force(law, contacts.inner, closing_speed)
    law_x, law_y = contact_resultant(contacts, force)
    error_x, error_y = error_forces(operation, acceleration_x, acceleration_y, law_x, law_y)
    terms_x, terms_y, momentum_x, momentum_y = {}, {}, None, None
    own = (trajectory.inner_ax, trajectory.inner_ay)
    if own[0] is not None and own[1] is not None:
        terms_x["differentiation"] = operation.inner_mass * (acceleration_x - own[0])
        terms_y["differentiation"] = operation.inner_mass * (acceleration_y - own[1])
    if trajectory.inner_force is None:
        terms_x, terms_y = {}, {}
    else:
        fem_x, fem_y = contact_resultant(contacts, trajectory.inner_force)
        terms_x["contact_law"], terms_y["contact_law"] = fem_x - law_x, fem_y - law_y
        momentum_x, momentum_y = error_x - terms_x["contact_law"], error_y - terms_y["contact_law"]
        if trajectory.inner_traction is not None:
            friction_x, friction_y = traction_resultant(contacts, trajectory.inner_traction)
            terms_x["friction"], terms_y["friction"] = friction_x, friction_y
            momentum_x, momentum_y = momentum_x - friction_x, momentum_y - friction_y
        terms_x["load_and_weight"], terms_y["load_and_weight"] = np.zeros_like(error_x), missing_load(trajectory)
        momentum_y = momentum_y - terms_y["load_and_weight"]
        terms_x["ring_flexibility"] = error_x - sum(terms_x.values())
        terms_y["ring_flexibility"] = error_y - sum(terms_y.values())
    closed = contacts.inner > 0.0 if trajectory.inner_force is None else trajectory.inner_force > 0.0
    return Budget(
        error_x=error_x, error_y=error_y, terms_x=terms_x, terms_y=terms_y,
        momentum_x=momentum_x, momentum_y=momentum_y, law_force=force, contacts=contacts,
        closing_speed=closing_speed, loaded=closed,
    )  # fmt: skip


def near_contact_change(loaded: np.ndarray, reach: int) -> np.ndarray:
    """Samples within `reach` of a contact that opens or closes, (n_times,) bool: there the order drops."""
    change = np.zeros(loaded.shape[0], dtype=bool)
    change[1:] = np.any(loaded[1:] != loaded[:-1], axis=1)
    kernel = np.ones(2 * reach + 1)
    return np.convolve(change, kernel, mode="same") > 0.5


def load_zones(loaded: np.ndarray, bridge: int) -> list[tuple[int, int]]:
    """First and last sample of each pass through the load zone; gaps up to `bridge` are chatter."""
    at = np.flatnonzero(loaded)
    if at.size == 0:
        return []
    ends = np.flatnonzero(np.diff(at) > bridge + 1)
    first = at[np.concatenate([[0], ends + 1])]
    last = at[np.concatenate([ends, [at.size - 1]])]
    return list(zip(first.tolist(), last.tolist(), strict=True))


def chatter_gap(trajectory: Trajectory) -> int:
    """Longest opening, samples, within one pass through the load zone: 5 % of a cage revolution."""
    cage = kinematics(trajectory.bearing, trajectory.operation.speed).frequencies["FTF"]
    samples = trajectory.time.size // 50
    if cage > 0.0:
        samples = min(samples, int(CHATTER / cage / trajectory.interval))
    return max(1, samples)

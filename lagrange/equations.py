"""Geometry (19), (26), (27) and the inner ring's equations of motion (22), (23), vectorised over time.

Source: Rubio, García Prada, Castejón, Laniado, Dynamic analysis of rolling bearing system using Lagrangian model
vs. FEM code (IFToMM 2007), with the signs put right: y points up, the load W acts along −y.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Operation


@dataclass(frozen=True, kw_only=True)
class Approaches:
    """Where the rollers are and how deep their contacts; each (n_times, n_rollers)."""

    distance: np.ndarray  # χ, inner ring's centre to roller's centre, m
    direction_x: np.ndarray  # unit vector from the roller to the inner ring's centre, (∂χ/∂x, ∂χ/∂y)
    direction_y: np.ndarray
    inner: np.ndarray  # δ_in, m, > 0 in the load zone
    outer: np.ndarray  # δ_out, m


def approaches(bearing: Bearing, inner_x, inner_y, roller_x, roller_y) -> Approaches:
    """χ and the approaches δ_in, δ_out of every contact.

    Parameters
    ----------
    inner_x, inner_y : ndarray, (n_times,), m, centre of the inner ring
    roller_x, roller_y : ndarray, (n_times, n_rollers), m, centres of the rollers

    Errors
    ------
    Round-off: about 4 eps·χ (1e-17 m for a bearing of 50 mm), 4 orders below a contact's nanometre.

    Source: (19), (26), (27). Cartesian differences give the same χ as (19) with less cancellation.
    """
    to_inner_x = np.asarray(inner_x)[:, None] - roller_x
    to_inner_y = np.asarray(inner_y)[:, None] - roller_y
    distance = np.hypot(to_inner_x, to_inner_y)
    rho = np.hypot(roller_x, roller_y)
    return Approaches(
        distance=distance,
        direction_x=to_inner_x / distance,
        direction_y=to_inner_y / distance,
        inner=bearing.inner_raceway_radius + bearing.roller_radius - distance,
        outer=rho + bearing.roller_radius - bearing.outer_raceway_radius,
    )


def contact_resultant(state: Approaches, inner_force) -> tuple[np.ndarray, np.ndarray]:
    """x and y components of the rollers' normal forces on the inner ring, N, each (n_times,).

    `inner_force` is (n_times, n_rollers), N, >= 0: from a contact law, or measured.
    """
    return (
        np.sum(inner_force * state.direction_x, axis=1),
        np.sum(inner_force * state.direction_y, axis=1),
    )


def error_forces(operation: Operation, acceleration_x, acceleration_y, resultant_x, resultant_y):
    """Left sides of (22) and of (23) with the load moved over: both 0 when the model fits perfectly.

    Parameters
    ----------
    acceleration_x, acceleration_y : ndarray, (n_times,), m/s², of the inner ring's centre
    resultant_x, resultant_y : ndarray, (n_times,), N, see `contact_resultant`

    Returns
    -------
    error_x, error_y : ndarray, (n_times,), N
        M ẍ − ΣQ_x and M ÿ + M g − ΣQ_y + W.
    """
    mass = operation.inner_mass
    error_x = mass * acceleration_x - resultant_x
    error_y = mass * acceleration_y + mass * operation.gravity - resultant_y + operation.radial_load
    return error_x, error_y

"""Geometry (19), (26), (27) and the inner ring's equations of motion (22), (23), vectorised over time.

Source: Rubio, García Prada, Castejón, Laniado, Dynamic analysis of rolling bearing system using Lagrangian model
vs. FEM code (IFToMM 2007), with the signs put right: y points up, the load W acts along −y.
"""

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.overlap import Overlaps, overlaps, sunk
from lagrange.profile import Turns


def approaches(bearing: Bearing, inner_x, inner_y, roller_x, roller_y, turns: Turns | None = None) -> Overlaps:
    """Overlaps of a record, which are the approaches δ_in, δ_out of rigid bodies; each (n_times, n_rollers).

    Parameters
    ----------
    inner_x, inner_y : ndarray, (n_times,), m, centre of the inner ring
    roller_x, roller_y : ndarray, (n_times, n_rollers), m, centres of the rollers
    turns : of ring and rollers, for the bearing's surfaces as they are; None: for perfect circles
    """
    x, y = np.asarray(inner_x)[:, None], np.asarray(inner_y)[:, None]
    found = overlaps(bearing, x, y, roller_x, roller_y, np.hypot(roller_x, roller_y))
    return found if turns is None else sunk(bearing, found, turns, np.arctan2(roller_y, roller_x))


def contact_resultant(state: Overlaps, inner_force) -> tuple[np.ndarray, np.ndarray]:
    """x and y components of the rollers' normal forces on the inner ring, N, each (n_times,).

    `inner_force` is (n_times, n_rollers), N, >= 0: from a contact law, or measured.
    """
    return (
        np.sum(inner_force * state.direction_x, axis=1),
        np.sum(inner_force * state.direction_y, axis=1),
    )


def error_forces(
    operation: Operation, acceleration_x, acceleration_y, resultant_x, resultant_y, shaft_force=(0.0, 0.0)
):
    """Left sides of (22) and of (23) with the load moved over: both 0 when the model fits perfectly.

    Parameters
    ----------
    operation : of each time, see `Operation.at`
    acceleration_x, acceleration_y : ndarray, (n_times,), m/s², of the inner ring's centre
    resultant_x, resultant_y : ndarray, (n_times,), N, see `contact_resultant`
    shaft_force : of what holds the shaft beside the bearing, on the hub, along x and y, (n_times,), N

    Returns
    -------
    error_x, error_y : ndarray, (n_times,), N
        M ẍ − ΣQ_x − the load along x, 0 of the paper's, and M ÿ + M g − ΣQ_y + W; less the shaft's force.
    """
    mass = operation.inner_mass
    error_x = mass * acceleration_x - resultant_x - operation.side_load
    error_y = mass * acceleration_y + mass * operation.gravity - resultant_y + operation.radial_load
    return error_x - shaft_force[0], error_y - shaft_force[1]

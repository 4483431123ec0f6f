"""The housing of a run for the time loop."""

import numpy as np

from fem.contacts.model import Model
from fem.elastic.bored import BoredRing
from fem.kernels.housing_kernels import Housing, Resonator
from fem.kernels.state import Ring
from lagrange import Operation
from lagrange.mounting import Sensor


def housing_body(
    model: Model, operation: Operation, ring: Ring, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The housing at rest at a place, (2,), m, its outer ring with it; None where the ground holds the ring.

    `column` : of a sample's row, the first for it
    """
    mounting, body = operation.mounting, model.outer_ring
    if mounting.housing is None:
        return None
    rigid, bored = body.material.rigid, isinstance(body, BoredRing)
    carried = body.total_mass if rigid else body.n_sectors * body.row_mass[body.held_row]
    sensor = None if mounting.sensor is None else _resonator(mounting.sensor, dt)
    return Housing(
        place=place.copy(),
        velocity=np.zeros(2),
        before=np.zeros(2),
        impulse=np.zeros(2),
        drag=np.zeros(2),
        dissipated=np.zeros(1),
        ring=None if rigid or bored else ring,
        line=np.zeros((2, ring.u.shape[2])),
        sensor=sensor,
        mass=float(mounting.housing.mass + (0.0 if bored else carried)),
        stiffness=float(mounting.housing.stiffness),
        damping=float(mounting.housing.damping),
        column=column,
    )


def _resonator(sensor: Sensor, dt: float) -> Resonator:
    return Resonator(
        motion=np.zeros(2),
        step=np.ascontiguousarray(sensor.step(dt)),
        half_step=np.ascontiguousarray(sensor.step(0.5 * dt)),
        pull=sensor.pull,
    )

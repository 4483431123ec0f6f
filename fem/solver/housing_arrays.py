"""The housing of a run for the time loop."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.ground_dashpots import late_mass
from fem.kernels.housing_kernels import Housing, Resonator
from fem.kernels.state import Ring
from lagrange import Operation
from lagrange.mounting import Mounting, Sensor

if TYPE_CHECKING:  # needs the finite elements' libraries
    from fem.contacts.model import Model


def housing_body(
    model: "Model", operation: Operation, ring: Ring, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The housing at rest at a place, (2,), m, its outer ring with it; None where the ground holds the ring.

    `column` : of a sample's row, the first for it
    """
    mounting, body = operation.mounting, model.outer_ring
    if mounting.housing is None:
        return None
    from fem.elastic.bored import BoredRing  # as those above

    if isinstance(body, BoredRing):  # which moves by itself
        return housing_of(mounting, 0.0, None, place, dt, column)
    rigid = body.material.rigid
    carried = body.total_mass if rigid else body.n_sectors * body.row_mass[body.held_row]
    return housing_of(mounting, carried, None if rigid else ring, place, dt, column)


def housing_of(
    mounting: Mounting, carried: float, ring: Ring | None, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """The same with a ring of which so much, kg, moves as a whole; None for one without a mesh, or free in its bore."""
    housing, sensor = mounting.housing, mounting.sensor
    if housing is None:
        return None
    return Housing(
        place=place.copy(),
        velocity=np.zeros(2),
        before=np.zeros(2),
        impulse=np.zeros(2),
        slowed=np.zeros((2, 2)),
        drag=np.zeros(2),
        dissipated=np.zeros(1),
        ring=ring,
        line=np.zeros((2, 0 if ring is None else ring.u.shape[2])),
        sensor=None if sensor is None else _resonator(sensor, dt),
        mass=float(housing.mass + carried),
        late_mass=late_mass(float(housing.mass + carried), float(housing.damping), dt),
        stiffness=float(housing.stiffness),
        damping=float(housing.damping),
        column=column,
    )


def _resonator(sensor: Sensor, dt: float) -> Resonator:
    return Resonator(
        motion=np.zeros(2),
        step=np.ascontiguousarray(sensor.step(dt)),
        half_step=np.ascontiguousarray(sensor.step(0.5 * dt)),
        pull=sensor.pull,
    )

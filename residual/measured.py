"""Which body's vibration a report is of: the sensor's where a run has one, else the housing's, else the hub's."""

import numpy as np

from residual.budget import Accelerations
from residual.record import Record

Measured = tuple[str, np.ndarray]  # a body and its acceleration along an axis, (n_times,), m/s²


def measured(record: Record, accelerations: Accelerations) -> tuple[Measured, Measured]:
    """Body and acceleration along x and along y, in the fixed frame: what an accelerometer on the machine would see.

    The integrator's own where the source tells it, else from positions. A sensor measures along y alone; along x stands
    the housing beside it.
    """
    hub_x, hub_y = accelerations.whole
    (housing_x, housing_y), sensor = _housing(record, accelerations), record.sensor_ay
    hub = (hub_x if record.inner_ax is None else record.inner_ax, hub_y if record.inner_ay is None else record.inner_ay)
    x: Measured = ("hub", hub[0]) if housing_x is None else ("housing", housing_x)
    y: Measured = ("hub", hub[1]) if housing_y is None else ("housing", housing_y)
    return x, y if sensor is None else ("sensor", sensor)


def _housing(record: Record, accelerations: Accelerations) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Accelerations of the housing: those of the outer ring that it holds, or its own beside a ring with a fit."""
    mounting = record.scene.mounting()
    if mounting.housing is None:
        return None, None
    if mounting.bore is not None:
        return record.housing_ax, record.housing_ay
    x, y = accelerations.outer_ring
    return x if record.outer_ring_ax is None else record.outer_ring_ax, (
        y if record.outer_ring_ay is None else record.outer_ring_ay
    )

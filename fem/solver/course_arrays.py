"""A scene's course of speed and load as kernels take it."""

import numpy as np

from fem.kernels.course_kernels import N_NOW
from fem.kernels.state import Course
from lagrange import Bearing, Operation, kinematics


def course_arrays(
    bearing: Bearing, operation: Operation, *, held: bool = True, growth: float = 0.0, roller_growth: float = 0.0
) -> Course | None:
    """None where nothing changes.

    Parameters
    ----------
    held : elements turn with the cage of rolling without slip
    growth, roller_growth : m s², of the distances at which a roller touches the inner ring, and the outer one, by the
        square of the shaft's speed
    """
    found = operation.course
    if found is None:
        return None
    ideal = kinematics(bearing, 1.0)
    return Course(
        turn_knots=found.turn.x.copy(),
        turn=np.ascontiguousarray(found.turn.c[::-1].T),
        load_knots=found.load.x.copy(),
        load=np.ascontiguousarray(found.load.c[::-1].swapaxes(0, 1)),
        now=np.zeros(N_NOW),
        drive_work=np.array([0.0, np.nan, 0.0]),
        unbalance=float(found.unbalance),
        unbalance_angle=float(found.unbalance_angle),
        rotating_load=float(found.rotating_load),
        rotating_load_angle=float(found.rotating_load_angle),
        cage=float(ideal.cage) if held else 0.0,
        spin=float(ideal.roller),
        growth=float(growth),
        roller_growth=float(roller_growth),
    )

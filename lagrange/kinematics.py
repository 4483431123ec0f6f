"""Kinematics of an ideal bearing: rolling without slip, outer ring fixed."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from lagrange.bearing import Bearing, Operation


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """Angular speeds of rolling without slip, rad/s, signed (counter-clockwise positive).

    Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 8; the contact angle is in the section.
    """

    shaft: float
    cage: float  # of the rollers' centres
    roller: float  # of a roller about its own axis, in the fixed frame
    n_rollers: int  # pockets: a missing roller changes no line
    cosine: float = 1.0  # of the contact angle, by which elements of a section turn too fast about their own axes

    @property
    def frequencies(self) -> dict[str, float]:
        """Kinematic lines, Hz, positive, by the vibration engineer's name.

        FTF: cage; BSF: a roller's spin relative to the cage; BPFO, BPFI: rollers passing a point of a ring.
        """
        cage = abs(self.cage) / (2.0 * pi)
        shaft = abs(self.shaft) / (2.0 * pi)
        return {
            "shaft": shaft,
            "FTF": cage,
            "BSF": abs(self.roller - self.cage) * self.cosine / (2.0 * pi),
            "BPFO": self.n_rollers * cage,
            "BPFI": self.n_rollers * abs(shaft - cage),
        }


def kinematics(bearing: Bearing, speed: float) -> Kinematics:
    """Rolling without slip of a bearing whose inner ring turns at `speed`, rad/s.

    With clearance the rollers run on the pitch circle, midway between the raceways.
    """
    surface_speed = speed * bearing.inner_raceway_radius
    cage = 0.5 * surface_speed / bearing.pitch_radius
    return Kinematics(
        shaft=speed,
        cage=cage,
        roller=-0.5 * surface_speed / bearing.roller_radius,
        n_rollers=bearing.pockets,
        cosine=bearing.cosine,
    )


def turned(bearing: Bearing, operation: Operation, time) -> Kinematics:
    """How far shaft, cage and rollers have turned since t = 0 by rolling without slip, rad; `time` in s, any shape."""
    if operation.course is not None:
        return kinematics(bearing, operation.course.turn(time)[()])
    ideal = kinematics(bearing, operation.speed)
    return replace(ideal, shaft=ideal.shaft * time, cage=ideal.cage * time, roller=ideal.roller * time)


def roller_angles(bearing: Bearing, first_roller_angle: float) -> np.ndarray:
    """Angles of the rollers' centres, in equally spaced pockets, (n_rollers,), rad: equation (20) of the paper."""
    return first_roller_angle + 2.0 * pi * np.array(bearing.pocket) / bearing.pockets

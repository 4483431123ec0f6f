"""Kinematics of an ideal bearing: rolling without slip between two rings that may turn: (2) of docs/operation.md."""

from dataclasses import dataclass
from math import pi

import numpy as np

from lagrange.bearing import Bearing, Operation

OUTER_RING = "outer ring"  # the line of its turns


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
    outer_ring: float = 0.0

    @property
    def frequencies(self) -> dict[str, float]:
        """Kinematic lines, Hz, positive, by the vibration engineer's name.

        FTF: cage; BSF: a roller's spin relative to the cage; BPFO, BPFI: rollers passing a point of a ring. The outer
        ring's turns are a line where it turns.
        """
        shaft, cage, ring = (speed / (2.0 * pi) for speed in (self.shaft, self.cage, self.outer_ring))
        spin = abs(self.roller - self.cage) * self.cosine / (2.0 * pi)
        passed = {"BPFO": self.n_rollers * abs(cage - ring), "BPFI": self.n_rollers * abs(shaft - cage)}
        found = {"shaft": abs(shaft), "FTF": abs(cage), "BSF": spin, **passed}
        return found | {OUTER_RING: abs(ring)} if ring else found


def kinematics(bearing: Bearing, speed, outer_speed=0.0) -> Kinematics:
    """Rolling without slip of a bearing whose inner ring turns at `speed`, rad/s, its outer ring at `outer_speed`.

    With clearance the rollers run on the pitch circle, midway between the raceways. A cage turns at the mean of both
    surfaces' speeds over the pitch radius, rollers at half of their difference over a roller's radius.
    """
    inner, outer = speed * bearing.inner_raceway_radius, outer_speed * bearing.outer_raceway_radius
    return Kinematics(
        shaft=speed, cage=0.5 * (inner + outer) / bearing.pitch_radius,
        roller=-0.5 * (inner - outer) / bearing.roller_radius, n_rollers=bearing.pockets, cosine=bearing.cosine,
        outer_ring=outer_speed)  # fmt: skip


def kinematics_met(bearing: Bearing, operation: Operation) -> Kinematics:
    """Rolling without slip where speeds of a run are highest or lowest, arrays (n,)."""
    return kinematics(bearing, *operation.ring_speeds_met)


def fastest_kinematics(bearing: Bearing, operation: Operation) -> Kinematics:
    """Rolling without slip where contacts run fastest; of the shaft, or else the outer ring, counter-clockwise."""
    inner, outer = operation.ring_speeds_met
    met = kinematics(bearing, inner, outer)
    k = int(np.argmax(np.abs(met.roller - met.cage)))
    sign = -1.0 if (inner[k] or outer[k]) < 0.0 else 1.0
    return kinematics(bearing, float(sign * inner[k]), float(sign * outer[k]))


def mean_kinematics(bearing: Bearing, operation: Operation, time: float) -> Kinematics | None:
    """On the mean up to a time, s; None where a ring turns both ways: a slip over the mean has no meaning."""
    history = operation.history
    if history is None or not history.varies_speed or time <= 0.0:
        return kinematics(bearing, *operation.ring_speeds)
    if history.reverses(time):
        return None
    return kinematics(bearing, *(float(turn) / time for turn in history.ring_turns(time)))


def turned(bearing: Bearing, operation: Operation, time) -> Kinematics:
    """How far rings, cage and rollers have turned since t = 0 by rolling without slip, rad; `time` in s, any shape."""
    history, (inner, outer) = operation.history, operation.ring_speeds
    return kinematics(bearing, *((inner * time, outer * time) if history is None else history.ring_turns(time)))


def roller_angles(bearing: Bearing, first_roller_angle: float) -> np.ndarray:
    """Angles of the rollers' centres, in equally spaced pockets, (n_rollers,), rad: equation (20) of the paper."""
    return first_roller_angle + 2.0 * pi * np.array(bearing.pocket) / bearing.pockets

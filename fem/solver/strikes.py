"""Where bodies may strike each other: what a plan takes more trouble over."""

from lagrange import Operation, kinematics
from lagrange.faults import Spall
from lagrange.scene import Scene

# times gravity that turning must press rollers outwards by, or those without load fall within the bearing
HELD = 5.0


def may_strike(scene: Scene, operation: Operation) -> bool:
    """Whether bodies may strike each other: from rest, by spalls, under tables of speed or load, or as rollers fall."""
    bearing = scene.ideal_bearing()
    spalled = any(isinstance(fault, Spall) for fault in bearing.faults)
    outwards = kinematics(bearing, operation.speed).cage ** 2 * bearing.pitch_radius
    falling = 0.0 < outwards < HELD * operation.gravity
    return spalled or falling or scene.numerics.start == "rest" or operation.course is not None

"""The ideal bearing.

bearing     Material, Bearing, Operation: geometry, masses, operating point
kinematics  rolling without slip: shaft, cage, roller spin, ball-pass frequencies
laws        line-contact laws Q(δ)
equations   the paper's geometry (19), (26), (27) and the inner ring's equations (22), (23)
scene       the TOML scene file: validated, in the bearing engineer's units; gives the objects above in SI

Everything but `scene` (which validates with pydantic) needs numpy and scipy only.
"""

from lagrange.bearing import Bearing, Material, Operation
from lagrange.kinematics import Kinematics, kinematics

__all__ = ["Bearing", "Kinematics", "Material", "Operation", "kinematics"]

"""The ideal bearing: the paper's Lagrangian model, stated and solved.

bearing, catalogue, mounting    geometry, masses, operating point; standard bearings; housing, shaft, sensor
kinematics, load_history        rolling without slip; speed and load that change
contact, surface                laws Q(δ), Hertz, dampers; spalls, waviness, measured heights, a film
equations, motion               (1)-(23) in Cartesian coordinates; the N_b + 2 equations of motion
statics, first_state            equilibrium of hub and rolling elements; where a motion starts
rating                          load ratings, lives, friction and stiffness for a machine's designer
simulate, trajectory            forward solution, and its result
scene                           the TOML scene file: validated, in the bearing engineer's units; the objects above in SI
files, messages                 files that commands read and write; what they print

Example, 5 ms of the paper's bearing:

    from lagrange import Problem, contact_laws, simulate
    from lagrange.scene import read_scene

    scene = read_scene()
    bearing = scene.ideal_bearing()
    run = simulate(Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing)), 5e-3, 1e-5)

Everything but `scene` (which validates with pydantic) and `files.pages` (jinja) needs numpy and scipy only.
"""

from lagrange.bearing import BallBearing, Bearing, Material, Operation
from lagrange.contact.raceway_laws import ContactLaws, contact_laws
from lagrange.first_state import Problem
from lagrange.kinematics import Kinematics, kinematics
from lagrange.simulate import simulate
from lagrange.statics import Statics, static_equilibrium
from lagrange.trajectory import Trajectory

__all__ = [
    "BallBearing",
    "Bearing",
    "ContactLaws",
    "Kinematics",
    "Material",
    "Operation",
    "Problem",
    "Statics",
    "Trajectory",
    "contact_laws",
    "kinematics",
    "simulate",
    "static_equilibrium",
]

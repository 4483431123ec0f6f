"""The ideal bearing: the paper's Lagrangian model, stated; `fem.interface` solves it.

bearing, catalogue, mounting    geometry, masses, operating point; standard bearings; housing, shaft, sensor
kinematics, load_history        rolling without slip; speed and load that change
contact, surface                laws Q(δ), Hertz, dampers; spalls, waviness, measured heights, a film
equations, motion               overlaps (19), (26), (27); the N_b + 2 equations of motion (21)-(23), energies
statics, first_state            equilibrium of hub and rolling elements; where a motion starts, samples
rating                          load ratings, lives, friction and stiffness for a machine's designer
scene                           the TOML scene file: validated, in the bearing engineer's units; the objects above in SI
files, messages                 files that commands read and write; what they print

Example, the loads of the paper's rollers at rest:

    from lagrange import contact_laws, static_equilibrium
    from lagrange.scene import read_scene

    scene = read_scene()
    bearing = scene.ideal_bearing()
    found = static_equilibrium(bearing, scene.ideal_operation(), contact_laws("harris", bearing)).inner_force

Everything but `scene` (which validates with pydantic) and `files.output` (jinja) needs numpy and scipy only.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lagrange.bearing import BallBearing, Bearing, Material, Operation
    from lagrange.contact.laws import ContactLaws, contact_laws
    from lagrange.first_state import Problem
    from lagrange.kinematics import Kinematics
    from lagrange.statics import Statics, static_equilibrium

HOMES = {
    "bearing": ("BallBearing", "Bearing", "Material", "Operation"), "contact.laws": ("ContactLaws", "contact_laws"),
    "first_state": ("Problem",), "kinematics": ("Kinematics",),
    "statics": ("Statics", "static_equilibrium")}  # fmt: skip
__all__ = ["BallBearing", "Bearing", "ContactLaws", "Kinematics", "Material", "Operation", "Problem", "Statics",
    "contact_laws", "static_equilibrium"]  # fmt: skip


def __getattr__(name: str) -> Any:
    """A name from its module when it is asked for: commands that only print their help load no numpy."""
    for home, names in HOMES.items():
        if name in names:
            return getattr(import_module(f"lagrange.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

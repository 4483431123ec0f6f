"""Ideal bearings, faults and operating points that tests of the Lagrangian model share."""

from dataclasses import replace

import numpy as np

from lagrange.bearing import BallBearing, Material
from lagrange.contact.laws import contact_laws
from lagrange.motion import State
from lagrange.scene.scene import Scene
from lagrange.surface.faults import Spall, UnequalRoller, Waviness

PAPER = Scene().ideal_bearing()
RUNNING = Scene().ideal_operation()
HARRIS = contact_laws("harris", PAPER)
PRELOADED = replace(PAPER, outer_raceway_radius=0.02799)  # every contact stays closed: smooth forces
DOWN = -0.5 * np.pi
STEEL_207 = Material(youngs_modulus=207e9, poisson_ratio=0.3, density=7850.0)
# the 209 deep-groove bearing of Harris' examples: 9 balls of 12.7 mm, grooves of 52 %
DGBB_209 = BallBearing(
    n_rollers=9, roller_radius=6.35e-3, roller_length=19e-3,
    inner_raceway_radius=26.1455e-3, outer_raceway_radius=38.853e-3, bore_radius=22.5e-3, outside_radius=42.5e-3,
    inner_groove_radius=6.604e-3, outer_groove_radius=6.604e-3,
    roller=STEEL_207, inner_ring=STEEL_207, outer_ring=STEEL_207,
)  # fmt: skip


def spall(body, angle, width=1e-3, depth=1e-4):
    """Of this width and depth, m, its middle at an angle on a ring or on roller 0."""
    roller = 0 if body == "roller" else None
    return Spall(body=body, roller=roller, angle=angle, width=width, depth=depth, edge_radius=1e-4)


def wavy():
    """Waves on all bodies, and a roller that is too thick."""
    return (
        Waviness(body="inner_ring", roller=None, order=12, amplitude=0.5e-6, phase=0.3),
        Waviness(body="outer_ring", roller=None, order=5, amplitude=0.4e-6, phase=0.0),
        Waviness(body="roller", roller=1, order=4, amplitude=0.3e-6, phase=0.0),
        UnequalRoller(roller=3, diameter_deviation=1e-6),
    )


def state_of(run) -> State:
    """Generalised coordinates of a trajectory whose outer ring stands still."""
    return State(
        x=run.inner_x, y=run.inner_y, rho=run.roller_rho, theta=run.roller_theta,
        x_rate=run.inner_vx, y_rate=run.inner_vy, rho_rate=run.roller_rho_rate, theta_rate=run.roller_theta_rate,
    )  # fmt: skip

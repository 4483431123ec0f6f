"""What each crossing of a spall on the inner ring restores is the healthy bearing's load there: the load zone."""

from dataclasses import replace
from functools import cache
from math import gamma, pi

import numpy as np

from lagrange import contact_laws, kinematics
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.scene.scene import Scene
from lagrange.statics import static_equilibrium
from lagrange.surface.faults import Spall
from tests.reference.compiled_motion import solved

PAPER = Scene().ideal_bearing()  # no clearance and rigid rings: half the ring is loaded
HARRIS = contact_laws("harris", PAPER)
RUNNING = Scene().ideal_operation()
SLOW = replace(RUNNING, gravity=0.0, speed=0.1 * RUNNING.speed)
DAMPING = ContactDamping(constant=500.0)  # N s/m; the hub's vibration dies away within a crossing
BESIDE = 0.15e-3  # m, of the way beyond either edge
NODES = 6  # of Gauss's quadrature over the loaded quarter


@cache
def crossing(place: float) -> tuple[float, float]:
    """Force restored, N, by a crossing that ends at an angle from the load direction, rad; and the healthy load, N.

    The roller is released in the middle of 0.5 mm. As the exit edge lifts it the force returns; what it returns to, its
    largest value, is compared with the load that a bearing without the spall gives the roller at that instant.
    """
    spall = Spall(body="inner_ring", roller=None, angle=0.0, width=0.5e-3, depth=1e-4, edge_radius=1e-4)
    ideal = kinematics(PAPER, SLOW.speed)
    speed, opening = (ideal.shaft - ideal.cage) * PAPER.inner_raceway_radius, spall.half_opening(PAPER.roller_radius)
    exit_time, exit_angle = (BESIDE + 2.0 * opening) / speed, opening / PAPER.inner_raceway_radius
    there = place - 0.5 * pi
    operation = replace(SLOW, first_roller_angle=there - ideal.cage * exit_time)
    bearing = replace(PAPER, faults=(replace(spall, angle=there + exit_angle - ideal.shaft * exit_time),))
    run = solved(Problem(bearing, operation, HARRIS, damping=DAMPING), exit_time + BESIDE / speed, exit_time / 80)
    force = run.inner_force[:, 0]
    released = int(np.argmin(force))
    at = released + int(np.argmax(force[released:]))
    healthy = static_equilibrium(PAPER, SLOW, HARRIS, angles=run.roller_theta[at])
    return float(force[at] - force[released]), float(healthy.inner_force[0])


def zone() -> tuple[np.ndarray, np.ndarray]:
    """Angles from the load direction, rad, and the weights of Gauss's quadrature."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    return 0.25 * pi * (1.0 + node), 0.25 * pi * weight


def test_a_crossing_restores_the_healthy_load_of_its_place():
    """Measured: within 1.2 %, of loads from 630 N to 28 N."""
    found, healthy = np.array([crossing(place) for place in zone()[0]]).T
    np.testing.assert_allclose(found, healthy, rtol=0.02)


def test_crossing_forces_weigh_the_lines_as_the_load_zone_does():
    """Q_m/Q_0 of q = q₀ cosⁿ θ over half the ring, n = 10/9: the line at BPFI, and m shaft speeds beside it.

    Source: McFadden and Smith, J. Sound Vib. 96 (1984) 69, eq. 3, for ε = ½; the integral in closed form.
    """
    place, weight = zone()
    force = np.array([crossing(each)[0] for each in place])
    found = [weight @ (force * np.cos(m * place)) / (weight @ force) for m in range(1, 5)]
    n = 10.0 / 9.0
    expected = [
        gamma(0.5 * n + 1.0) ** 2 / (gamma(1.0 + 0.5 * (n + m)) * gamma(1.0 + 0.5 * (n - m))) for m in range(1, 5)
    ]
    np.testing.assert_allclose(expected, [0.795, 0.357, 0.0215, -0.062], atol=5e-4)
    np.testing.assert_allclose(found, expected, atol=0.005)

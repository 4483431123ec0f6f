"""Dashpots of shaft and housing to the ground, under forces that are found after theirs."""

import numpy as np
import pytest
from numba import njit

from fem.interface import simulate
from fem.kernels.jit import OPTIONS
from fem.kernels.shaft import Shaft, conclude, give_way, late_mass, mobility, pull, settle
from lagrange.scene.scene import parse_scene

DT, MASS, DAMPING, STIFFNESS = 4e-7, 7.6e-4, 300.0, 1e6
FIRST, LATER = np.array([40.0, -7.0]), np.array([-9.0, 25.0])  # N


ASKING, UNKNOWING, HEAVIER = range(3)  # how forces are given that are found after the dashpots'
LATE_MASS = late_mass(MASS, DAMPING, DT)


@njit(**OPTIONS)
def shake(shaft, first, later, how):
    """A kick by forces, the shaft's, and forces found later."""
    for k in range(2):
        shaft.velocity[k] += DT / MASS * first[k]
    pull(shaft, DT, shaft.place[0], shaft.place[1])
    for k in range(2):
        if how == ASKING:
            gained = mobility(shaft, MASS, DT) * later[k]
            shaft.velocity[k] += gained
            give_way(shaft, k, gained)
        else:
            shaft.velocity[k] += DT / (MASS if how == UNKNOWING else LATE_MASS) * later[k]
    if how == UNKNOWING:
        settle(shaft, DT)
    elif how == HEAVIER:
        conclude(shaft)


@pytest.mark.parametrize("how", [ASKING, UNKNOWING, HEAVIER])
def test_the_dashpots_force_is_that_of_the_mean_of_the_velocities_before_and_after_all_forces(how):
    """M (v₁ − v₀)/dt = F − k x − ½ c (v₀ + v₁), solved by hand."""
    v0, place = np.array([0.02, -0.03]), np.array([3e-6, -5e-6])
    shaft = Shaft(
        place=place, velocity=v0.copy(), before=v0.copy(), drag=np.zeros(2), stored=np.zeros(1),
        slowed=np.zeros((2, 2)), dissipated=np.zeros(1), mass=MASS, stiffness=STIFFNESS, damping=DAMPING, column=0,
    )  # fmt: skip
    shake(shaft, FIRST, LATER, how)
    half = 0.5 * DAMPING
    wanted = ((MASS / DT - half) * v0 + FIRST + LATER - STIFFNESS * place) / (MASS / DT + half)
    np.testing.assert_allclose(shaft.velocity, wanted, rtol=1e-13)
    np.testing.assert_allclose(shaft.drag, -half * (v0 + wanted), rtol=1e-13)


@pytest.mark.slow
def test_contact_dampers_and_a_shaft_s_dashpots_leave_a_light_hub_in_balance():
    """What the run's own forces leave of its equations; 0.3 % of the largest where dashpots knew no later forces."""
    tables = {
        "model": "reduced", "damping": {"contact_time_us": 25.0},
        "operation": {
            "inner_ring_and_shaft_kg": 0.05, "shaft": "springs", "shaft_stiffness_N_per_m": 1e7,
            "shaft_damping_N_s_m": 2e4, "rotating_load_N": 300.0,
        },
        "numerics": {"duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 2.0},
    }  # fmt: skip
    found = simulate(parse_scene(tables, ""))
    largest = np.max(found["inner_force"])
    assert np.max(np.abs(found["inner_damping_force"])) > 0.02 * largest
    for direction in found.residual().directions:
        assert np.max(np.abs(direction.budget.terms["ring_flexibility"])) < 1e-4 * largest

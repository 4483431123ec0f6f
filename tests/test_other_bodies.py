"""A body of a kind of its own, with a pair of its own: the time loop takes both without knowing them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.contact_kernels import normal_forces
from fem.kernels.jit import OPTIONS
from fem.kernels.sample_kernels import BLOCKS, CONTACT, KINETIC, N_SCALARS, add_energy
from fem.kernels.time_loop import DONE, advance
from tests.reference.bearings import arrays, model, operation, paper

STIFFNESS, MASS, AMPLITUDE, DT = 3e7, 0.02, 1e-6, 2e-7  # N/m, kg, m, s


class Mass(NamedTuple):
    """A mass that moves along a line."""

    motion: np.ndarray  # (4,): place, m; velocity at t − dt/2, m/s; impulse of the step, N s; velocity before the kick
    mass: float


class Spring(NamedTuple):
    """Between a mass and the ground."""

    body: Mass
    stiffness: float


@normal_forces.of(Spring)
def _press(spring, rollers, disc, contacts, drive):
    spring.body.motion[2] -= spring.stiffness * spring.body.motion[0] * drive.dt


@add_energy.of(Spring)
def _store(spring, contacts, n, points, out):
    out[CONTACT] += 0.5 * spring.stiffness * spring.body.motion[0] ** 2


@kick_body.of(Mass)
def _kick(body, drive):
    body.motion[3] = body.motion[1]
    body.motion[1] += body.motion[2] / body.mass
    body.motion[2] = 0.0


@drift_body.of(Mass)
def _drift(body, drive):
    body.motion[0] += drive.dt * body.motion[1]


@add_motion.of(Mass)
def _add_motion(body, drive, out, kinetic):
    out[kinetic] += 0.5 * body.mass * body.motion[3] * body.motion[1]


@pytest.mark.slow
def test_a_further_body_swings_beside_the_bearing_and_changes_none_of_its_bits():
    """x = a cos ωt with leapfrog's ω, cos ω dt = 1 − k dt²/2m, and an energy that stays."""
    at_rest = arrays(model(paper(), 2e-3), operation(), DT, 0.1)
    swinging = arrays(model(paper(), 2e-3), operation(), DT, 0.1)
    # so that the place at t = 0 is the largest: velocities are those half a step before
    body = Mass(np.array([AMPLITUDE, 0.5 * DT * STIFFNESS / MASS * AMPLITUDE, 0.0, 0.0]), MASS)
    with_it = replace(
        swinging,
        bodies=swinging.bodies._replace(others=((body,),)),
        groups=(*swinging.groups, (Spring(body, STIFFNESS),)),
    )
    run = njit(**OPTIONS)(advance.py_func)  # not kept: the key of kept kernels knows nothing of this module
    rows = np.zeros((2, 30, N_SCALARS + len(BLOCKS) * 13))
    for state, row in ((at_rest, rows[0]), (with_it, rows[1])):
        found = run(state.bodies, state.groups, state.contacts, state.drive, state.scratch, 0, 40, row)
        assert found == (DONE, 30 * 40, -2)
    omega = np.arccos(1.0 - 0.5 * STIFFNESS / MASS * DT**2) / DT
    assert body.motion[0] == pytest.approx(AMPLITUDE * np.cos(omega * 1200 * DT), abs=1e-9 * AMPLITUDE)
    energy = (rows[1] - rows[0])[:, [KINETIC, CONTACT]]
    stored = 0.5 * STIFFNESS * AMPLITUDE**2
    assert np.ptp(energy[:, 1]) > 0.9 * stored, "it swings"
    # leapfrog's own energy: stored at the start, where the kinetic part is -(ω dt/2)² of it
    np.testing.assert_allclose(energy.sum(axis=1), energy[0].sum(), rtol=0.0, atol=1e-6 * stored)
    assert energy[0].sum() == pytest.approx(stored, rel=2.0 * (omega * DT / 2.0) ** 2)
    rows[:, :, [KINETIC, CONTACT]] = 0.0
    np.testing.assert_array_equal(rows[1], rows[0])
    assert set(at_rest.named()) < set(with_it.named()), "a checkpoint keeps the body too"

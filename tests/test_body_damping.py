"""Damping of bodies: what moves and turns as a whole is not braked, what else moves dies, momentum is kept."""

import numpy as np
import pytest
from numba import njit

from fem.interface import simulate as run_scene
from fem.kernels.elements.damping import damp_bodies
from fem.kernels.elements.rings import HALO
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Housing
from fem.solver.simulate import make_plan
from lagrange.scene.scene import parse_scene
from tests.reference.budgets import balance_of
from tests.reference.swinging import ring_down

pytestmark = pytest.mark.slow  # kernels of their own; whole runs
RATE = 5000.0  # 1/s
HELD = {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
IN_PLAY = {"kind": "bore", "fit_clearance_um": 20.0}
COARSE = {"mesh_size_mm": 2.0}


@njit(**OPTIONS)
def damp_once(bodies, drive, damping):
    damp_bodies(bodies, drive, damping)


class Outer:
    """The outer ring of a bearing's arrays, in fixed axes."""

    def __init__(self, support):
        tables = {"support": support, "damping": {"bodies_1_s": RATE}, "numerics": COARSE}
        self.arrays = make_plan(parse_scene(tables, "")).arrays()
        self.ring = ring = self.arrays.bodies.outer
        self.rows, self.nodes = slice(ring.first_row, ring.last_row), slice(HALO, HALO + ring.n_sectors)
        self.mass = np.broadcast_to(ring.row_mass[self.rows, None], self.place.shape)

    def _cartesian(self, polar):
        outward = (self.ring.cosines + 1j * self.ring.sines)[self.nodes]
        return (polar[self.rows, 0, self.nodes] + 1j * polar[self.rows, 1, self.nodes]) * outward

    @property
    def place(self):
        """Of the nodes, m, as complex numbers, half a step back, where velocities are."""
        polar = self.ring.u - 0.5 * self.arrays.drive.dt * self.ring.w
        polar[:, 0] += self.ring.radii[:, None]
        return self._cartesian(polar)

    @property
    def velocity(self):
        return self._cartesian(self.ring.w)

    def move(self, velocity):
        """Give the nodes these velocities, m/s."""
        outward = (self.ring.cosines + 1j * self.ring.sines)[self.nodes]
        polar = velocity * np.conj(outward)
        self.ring.w[self.rows, 0, self.nodes], self.ring.w[self.rows, 1, self.nodes] = polar.real, polar.imag

    def damp(self):
        arrays = self.arrays
        damp_once(arrays.bodies, arrays.drive, arrays.bodies.damping)

    @property
    def momentum(self):
        """And the angular one about the origin."""
        return np.sum(self.mass * self.velocity), np.sum(self.mass * (np.conj(self.place) * self.velocity).imag)


def shaken(ring, size):
    """Velocities of its nodes in no order, m/s."""
    random = np.random.default_rng(3)
    return size * (random.standard_normal(ring.mass.shape) + 1j * random.standard_normal(ring.mass.shape))


def test_a_ring_goes_with_its_housing_undamped_and_gives_it_what_its_own_motion_loses():
    outer = Outer(HELD)
    (housing,) = (body for body in outer.arrays.bodies.others if isinstance(body, Housing))
    housing.velocity[:] = 0.3, -0.2
    whole = np.full(outer.mass.shape, 0.3 - 0.2j)
    outer.move(whole)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole, rtol=1e-13)
    np.testing.assert_allclose(housing.impulse, 0.0, atol=1e-15)
    own = shaken(outer, 0.1)
    outer.move(whole + own)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole + own * np.exp(-RATE * outer.arrays.drive.dt), rtol=1e-12)
    given = np.sum(outer.mass * (whole + own - outer.velocity))
    np.testing.assert_allclose(housing.impulse, [given.real, given.imag], rtol=1e-9)


def test_a_ring_in_play_keeps_its_momentum_and_its_turning():
    outer = Outer(IN_PLAY)
    for _ in range(3):  # places half a step back follow the velocities
        whole = 0.3 - 0.2j + 40j * outer.place
        outer.move(whole)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole, rtol=1e-12)
    outer.move(whole + shaken(outer, 0.1))
    before, lost = outer.momentum, outer.velocity
    outer.damp()
    assert np.abs(outer.velocity - lost).max() > 1e-5
    np.testing.assert_allclose(outer.momentum, before, rtol=1e-7)  # places half a step back move with the velocities


def test_a_housing_rings_down_as_if_bodies_were_not_damped():
    """√(k/M)/2π and c/2√(kM) of all that swings on its springs; with a ring damped against the ground ζ would be 0.09.

    Rollers, which nothing holds along the raceways, swing there by themselves.
    """
    tables = {
        "bearing": {"outer_raceway_diameter_mm": 55.98},
        "operation": {"speed_rpm": 0.0, "gravity_m_s2": 0.0, "radial_load_N": 0.0},
        "contact": {"friction_coefficient": 0.0}, "damping": {"bodies_1_s": RATE}, "support": {"kind": "housing"},
        "numerics": COARSE | {"duration_ms": 24.0, "output_interval_us": 50.0},
    }  # fmt: skip
    plan = make_plan(parse_scene(tables, ""))
    state, bearing = plan.first_state(), plan.model.bearing
    bodies = state.arrays.bodies
    (housing,) = (body for body in bodies.others if isinstance(body, Housing))
    for ring in (bodies.inner, bodies.outer):
        ring.w[:, 0, :] += 1e-3 * ring.sines
        ring.w[:, 1, :] += 1e-3 * ring.cosines
    bodies.rollers.velocity[1, : bearing.n_rollers] += 1e-3
    housing.velocity[1] = state.arrays.drive.velocity[1] = 1e-3
    found = []
    while state.done < plan.n_samples:
        block = state.advance(100)
        assert block.trouble is None
        found.append(block.samples.values)
    place = np.concatenate([values["housing_y"] for values in found])
    rollers = 0.5 * bearing.n_rollers * bearing.roller_mass  # along their radii: nothing moves them across
    mass = 12.638 + bearing.outer_ring_mass + plan.operation.inner_mass + rollers
    frequency, zeta = ring_down(place[3:], 5e-5)
    assert frequency == pytest.approx(np.sqrt(15.1e6 / mass) / (2.0 * np.pi), rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * mass)), rel=2e-3)
    assert found[-1]["work_damping_bodies"][-1] < 1e-6 * found[-1]["work_dissipated"][-1]


@pytest.mark.parametrize(("support", "limit"), [(HELD, 1e-4), (IN_PLAY, 5e-4)], ids=["housing", "bore"])
def test_energy_is_balanced_to_the_square_of_the_step_where_the_outer_ring_moves(support, limit):
    """From rest under a sudden load."""
    missing = []
    for safety in (0.9, 0.45):
        numerics = COARSE | {"duration_ms": 1.0, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 5.0,
                             "time_step_safety": safety}  # fmt: skip
        tables = {"damping": {"bodies_1_s": 2e4}, "support": support, "numerics": numerics}
        result = run_scene(parse_scene(tables, ""))
        assert result.values["work_damping_bodies"][-1] > 10.0 * limit * np.ptp(result.energies["energy_kinetic"])
        missing.append(balance_of(result))
    assert missing[0] < limit and missing[1] < 0.3 * missing[0]

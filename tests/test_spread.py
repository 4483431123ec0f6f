"""Pressure points spread over patches: the term below the grid fades out as the mesh is refined; a balanced run."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import nnls

from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.points import points
from fem.contacts.resolved import SpreadModel
from fem.kernels.jit import kernel
from fem.kernels.points import spread_forces
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.time_loop import advance
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import parse_scene
from tests.reference.bearings import arrays, copies, loop_arguments, operation, soft
from tests.reference.compiled import press_contacts
from tests.reference.contact_pressures import contact_pressures
from tests.reference.whole_run import whole_run

ON_A_ROLLER = -0.5 * np.pi
LOAD = 300.0


def five():
    """Five rollers of a plastic in the paper's raceways; b = 0.24 mm under LOAD."""
    return soft(n_rollers=5)


@cache
def spread_model(mesh_size):
    return SpreadModel.of_force(five(), mesh_size, LOAD)


SIZES = (1.0, 0.5, 0.25, 0.12)  # mm; b = 0.24 mm


@cache
def fade(sizes=SIZES):
    """Mesh size, mm -> errors of hub and loads against the series, and the most loaded contact's share below."""
    exact = exact_statics(five(), LOAD, ON_A_ROLLER)
    law = exact_contacts(five(), roller_angles(five(), ON_A_ROLLER)).inner_law
    found = {}
    for size in sizes:
        model = spread_model(1e-3 * size)
        rest = equilibrium(model, standing(five(), ON_A_ROLLER), Loads(LOAD))
        pressed = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[int(rest.inner_force.argmax())]
        force = pressed.pressure * model.inner_law.spacing * model.inner_law.pair.length
        below = force @ model.inner_law.local_compliance(force.size) @ force / force.sum()
        found[size] = (
            abs(rest.hub[1] / exact.hub[1] - 1.0),
            np.abs(rest.inner_force - exact.inner_force).max() / exact.inner_force.max(),
            below / float(law.approach(force.sum())),
        )
    return found


def test_the_term_below_the_grid_fades_out():
    """Smoothly, from two fifths of a contact's approach."""
    share = np.array([found[2] for found in fade().values()])
    assert share[0] > 0.35
    assert np.all(share[1:] < 0.7 * share[:-1])


@pytest.mark.slow  # a mesh with ten times the others' nodes
def test_next_to_nothing_is_left_below_a_grid_of_a_quarter_of_the_half_width():
    hub, forces, share = fade((0.06,))[0.06]
    assert share < 0.02
    assert hub < 1e-3 and forces < 1.5e-3


def test_statics_stay_exact_from_far_too_coarse_to_resolved():
    """What a mesh lacks is a mean over places, of which it strays by 1 % itself; that fades out as well."""
    for size, (hub, forces, _) in fade().items():
        assert hub < (1e-3 if size < 0.3 else 5e-3) and forces < 1.5e-3, size


@pytest.mark.parametrize("size", [0.5, 0.12])
def test_pressures_are_hertzs(size):
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4), on any mesh."""
    model = spread_model(1e-3 * size)
    law = model.inner_law
    found = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[0]
    force = found.pressure.sum() * law.spacing * law.pair.length
    b = law.pair.half_width(force)
    inside = np.abs(found.across) < 0.9 * b
    hertz = 2.0 * force / (np.pi * b * law.pair.length) * np.sqrt(1.0 - (found.across[inside] / b) ** 2)
    np.testing.assert_allclose(found.pressure[inside], hertz, rtol=0.03)
    assert 2.0 * np.sqrt(np.sum(found.pressure * found.across**2) / found.pressure.sum()) == pytest.approx(b, rel=0.01)


@pytest.mark.parametrize(("clearance_um", "mass", "first"), [(40.0, 3.0, 0.0), (15.0, 0.1, 9.0)])
def test_rollers_that_only_their_weight_presses_find_their_place(clearance_um, mass, first):
    """Points leave a contact open by a nanometre that the series close, and a weight must not fall through the ring."""
    load = 4e4
    data = {
        "bearing": {"outer_raceway_diameter_mm": 56.0 + 1e-3 * clearance_um},
        "operation": {"inner_ring_and_shaft_kg": mass, "speed_rpm": 0.0, "radial_load_N": load,
                      "first_roller_deg": first},
        "numerics": {"mesh_size_mm": 0.5, "duration_ms": 0.0},
    }  # fmt: skip
    plan = make_plan(parse_scene(data, "test"))
    bearing, found = plan.model.bearing, plan.start.equilibrium
    exact = exact_statics(bearing, load + 9.81 * mass, ON_A_ROLLER + np.radians(first))
    np.testing.assert_allclose(found.inner_force, exact.inner_force, rtol=0.0, atol=1e-2 * exact.inner_force.max())
    upward = np.sin(roller_angles(bearing, ON_A_ROLLER + np.radians(first)))
    weight = 9.81 * bearing.roller_mass * upward  # along the radius
    loose = (weight > 0.0) & (exact.inner_force == 0.0)
    np.testing.assert_allclose(found.inner_force[loose], weight[loose], rtol=0.0, atol=1e-4)  # LOOSE_SPRING, 0.1 mm


def test_meshes_choose_the_contact():
    """One patch on meshes more than twice as coarse as the half-width, 0.24 mm; points below."""
    for size, spreads in ((0.6, False), (0.4, True)):
        model = model_of(rolling_scene(0.0, size, 1.0))
        assert isinstance(model, SpreadModel) == spreads


@kernel
def _spread_forces(points, spread, row, j):
    return spread_forces(points, spread, row, j)


def test_points_in_contact_are_found_as_by_another_method():
    """Against non-negative least squares of the factored problem (Lawson and Hanson), also where a wave parts them."""
    laws = spread_model(2.5e-4).laws
    some = points(laws, LOAD, 5)
    x = np.linspace(-1.0, 1.0, some.closing.size)
    full = toeplitz(laws[0].missing_compliance)
    root = np.linalg.cholesky(full)
    for shape in (0.1 - x**2, 0.05 - x**2 + 0.02 * x, 0.25 * np.cos(12.0 * x) - 2.0 * x**2, -1.0 - x**2):
        some.closing[:] = 1e-6 * shape
        energy = _spread_forces(some, some.spread, 0, 0)
        wanted, _ = nnls(root.T, np.linalg.solve(root, some.closing))
        np.testing.assert_allclose(some.force, wanted, rtol=0.0, atol=1e-7 * max(wanted.max(), 1e-9))
        assert energy == pytest.approx(0.5 * wanted @ full @ wanted, rel=1e-6, abs=1e-15)


def test_a_contact_wider_than_its_points_is_not_a_number():
    laws = (spread_model(2.5e-4).inner_law,) * 3
    some = points(laws, LOAD, 5)
    some.closing[:] = 1e-5
    _spread_forces(some, some.spread, 0, 0)
    assert np.isnan(some.force).any()


# dynamics -------------------------------------------------------------------------------------------------------


def rolling_scene(friction, mesh_size, duration):
    return parse_scene(
        {
            "bearing": {"rollers": 5},
            "material": {"youngs_modulus_GPa": 5.0},
            "operation": {"radial_load_N": LOAD, "gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 0.3},
            "contact": {"friction_coefficient": friction},
            "numerics": {"mesh_size_mm": mesh_size, "duration_ms": duration},
        },
        "test",
    )


@pytest.mark.slow  # a time loop of its own to compile
def test_the_start_stands_still():
    model = spread_model(2.5e-4)
    how = operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    state = copies(arrays(model, how, 0.9 * critical_time_step(model, LOAD)))
    wanted = equilibrium(model, standing(five(), how.first_roller_angle), Loads(LOAD))
    press_contacts(state)
    found = state.contacts.forces.force[:, :5]
    np.testing.assert_allclose(found[0], wanted.inner_force, rtol=0.0, atol=1e-6 * LOAD)
    np.testing.assert_allclose(found[1], wanted.outer_force, rtol=0.0, atol=1e-6 * LOAD)


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize(("friction", "most"), [(0.0, 1e-5), (0.1, 2e-4)])
def test_a_run_balances_its_energy(friction, most):
    """Forces are the gradient of one potential, and what opens and closes gives back what it took."""
    seen = run(make_plan(rolling_scene(friction, 0.3, 3.0)), lambda samples: None)
    assert abs(seen.imbalance) < most


@pytest.mark.slow
def test_points_and_one_patch_give_the_same_run():
    hub = {}
    for size in (0.25, 0.8):
        found = whole_run(make_plan(rolling_scene(0.1, size, 0.5)))
        hub[size] = np.array([found["inner_x"], found["inner_y"]])
    assert np.abs(hub[0.25] - hub[0.8]).max() < 5e-3 * np.abs(hub[0.8][1]).mean()


@pytest.mark.slow  # a time loop of its own to compile
def test_the_step_limit_is_on_its_safe_side_and_close():
    model = spread_model(2.5e-4)
    how = operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    limit = critical_time_step(model, LOAD)

    def grown(share):
        state = copies(arrays(model, how, share * limit))
        rows = np.zeros((12, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
        advance(*loop_arguments(state), 0, 100, rows)
        path = rows[:, 1:3]
        return not np.all(np.isfinite(path)) or np.abs(path - path[0]).max() > 1e-3 * np.abs(path[0]).max()

    assert not grown(0.99)
    assert grown(1.3)

"""Contacts resolved by the mesh: Hertz's pressure, exact statics, a balanced run."""

import itertools

import numpy as np
import pytest

from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.kernels.sample_kernels import BLOCKS, HUB_AX, HUB_AY, N_SCALARS
from fem.kernels.time_loop import advance
from fem.solver.limits import check_meshes
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_statics
from lagrange.scene.scene import parse_scene
from meshes import GradedAnnulus, GradedDisc, quality
from meshes.graded import graded_disc
from meshes.shapes import make
from tests.reference.bearings import arrays, copies, loop_arguments, operation, resolved_model, soft
from tests.reference.compiled import press_contacts
from tests.reference.contact_pressures import contact_pressures, layer_approach
from tests.reference.whole_run import whole_run

ON_A_ROLLER = -0.5 * np.pi
LOAD = 300.0


def five():
    """Five rollers of a plastic in the paper's raceways; b = 0.24 mm under LOAD."""
    return soft(n_rollers=5)


def solved(model, load=LOAD, first=ON_A_ROLLER):
    return equilibrium(model, standing(model.bearing, first), Loads(load))


# meshes that coarsen away from the raceways ---------------------------------------------------------------------


def test_a_graded_disc_halves_its_rows_and_keeps_its_triangles_fair():
    shape = graded_disc(0.005, 1e-4)
    counts = [row.nodes for row in shape.rows]
    assert isinstance(shape, GradedDisc) and shape.levels >= 1
    assert counts[-1] == shape.surface_nodes == 6 * shape.layers
    assert all(after in (before, 2 * before, before + 6) for before, after in itertools.pairwise(counts[1:]))
    mesh = make(shape)
    assert len(mesh.points) == sum(counts) and len(mesh.cells) == shape.n_cells
    found = quality(mesh)
    assert found.smallest_angle > 40.0 and found.largest_angle < 95.0
    assert found.largest_edge > 2.0 * shape.surface_spacing, "the inside is coarser"


@pytest.mark.parametrize("outside", [True, False])
def test_a_graded_ring_is_finest_at_its_raceway(outside):
    shape = GradedAnnulus(inner_radius=0.0125, outer_radius=0.018, sectors=320, raceway_outside=outside)
    steps = np.diff(shape.radii)
    assert shape.radii[[0, -1]] == pytest.approx([0.0125, 0.018], rel=1e-12)
    finest = steps[-1] if outside else steps[0]
    raceway = 0.018 if outside else 0.0125
    assert finest == steps.min() and 0.7 < finest / (2.0 * np.pi * raceway / 320) <= 1.0
    mesh = make(shape)
    assert mesh.cells.shape == (320 * shape.layers, 4)
    radius = np.hypot(*mesh.points.T).reshape(-1, 320)
    np.testing.assert_allclose(radius, np.tile(shape.radii[:, None], 320), rtol=1e-12)


# statics --------------------------------------------------------------------------------------------------------


@pytest.mark.slow  # `python -m tests.verification` has resolved statics as well
def test_the_resolved_equilibrium_converges_to_the_exact_series():
    """Hertz's own error is (b/R)² = 0.1 %; the layer's and the mesh's shrink with the mesh."""
    exact = exact_statics(five(), LOAD, ON_A_ROLLER)
    models = [resolved_model(five(), size) for size in (1.2e-4, 6e-5)]
    found = [solved(model) for model in models]
    errors = [abs(one.hub[1] / exact.hub[1] - 1.0) for one in found]
    assert errors[1] < 3e-3, errors
    layers = [layer_approach(model.inner_law, exact.inner_force.max()) for model in models]
    assert layers[0] / layers[1] == pytest.approx(2.0, rel=0.05)
    for one, tolerance in zip(found, (8e-3, 2e-3), strict=True):
        np.testing.assert_allclose(one.inner_force, exact.inner_force, atol=tolerance * LOAD)
        assert abs(one.hub[0]) < 1e-3 * abs(one.hub[1])


def test_pressures_are_hertzs():
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4)."""
    model = resolved_model(five(), 6e-5)
    found = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[0]
    law = model.inner_law
    force = found.pressure.sum() * law.spacing * law.pair.length
    b = law.pair.half_width(force)
    peak = 2.0 * force / (np.pi * b * law.pair.length)
    nodal = np.convolve(found.pressure, np.full(4, 0.25), mode="same")  # four points to a node
    assert nodal.max() == pytest.approx(peak, rel=0.04)
    width = 2.0 * np.sqrt(np.sum(found.pressure * found.across**2) / found.pressure.sum())
    assert width == pytest.approx(b, rel=0.04)
    assert abs(np.sum(found.pressure * found.across)) < 1e-3 * b * found.pressure.sum()


# dynamics -------------------------------------------------------------------------------------------------------


def advanced(state, n_samples, stride):
    """Samples of a run, finite or not."""
    samples = np.zeros((n_samples, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
    advance(*loop_arguments(state), 0, stride, samples)
    return samples


@pytest.mark.slow  # a time loop of its own to compile
def test_the_resolved_start_stands_still():
    """Forces of the time loop at t = 0 are those of the equilibrium; nothing pushes the hub."""
    model = resolved_model(five(), 1.2e-4)
    how = operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    dt = 0.9 * critical_time_step(model, LOAD)
    state = copies(arrays(model, how, dt))
    wanted = solved(model, LOAD, how.first_roller_angle)
    press_contacts(state)
    found = state.contacts.forces.force[:, : len(wanted.inner_force)]
    np.testing.assert_allclose(found[0], wanted.inner_force, rtol=0.0, atol=1e-6 * LOAD)
    np.testing.assert_allclose(found[1], wanted.outer_force, rtol=0.0, atol=1e-6 * LOAD)
    acceleration = advanced(copies(arrays(model, how, dt)), 1, 1)[0, [HUB_AX, HUB_AY]]
    assert np.abs(acceleration).max() * how.inner_mass < 1e-3 * LOAD


def rolling_scene(model, friction, mesh_size, duration):
    return parse_scene(
        {
            "bearing": {"rollers": 5},
            "material": {"youngs_modulus_GPa": 5.0},
            "operation": {"radial_load_N": LOAD, "speed_rpm": 3000.0},
            "contact": {"model": model, "friction_coefficient": friction},
            "numerics": {"mesh_size_mm": mesh_size, "duration_ms": duration, "output_interval_us": 5.0},
        },
        "test",
    )


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_resolved_run_balances_its_energy(friction):
    plan = make_plan(rolling_scene("resolved", friction, 0.12, 0.2))
    check_meshes(plan.model)
    found = whole_run(plan)
    assert abs(found.relative_error()[-1]) < 2e-4
    force = found["inner_force"]
    assert np.all(np.isfinite(force)) and force.max() < 1.1 * LOAD


@pytest.mark.slow  # a time loop of its own to compile
def test_both_contact_models_give_the_same_run():
    hub = {}
    for model, size in (("resolved", 0.08), ("subgrid", 1.0)):
        found = whole_run(make_plan(rolling_scene(model, 0.1, size, 0.2)))
        hub[model] = np.array([found["inner_x"], found["inner_y"]])
    size = np.abs(hub["subgrid"][1]).mean()
    assert np.abs(hub["resolved"] - hub["subgrid"]).max() < 2e-2 * size


@pytest.mark.slow  # a time loop of its own to compile
def test_the_resolved_step_limit_is_on_its_safe_side_and_close():
    """Free vibration of a squeezed bearing from round-off: stable at 0.99 of the limit, gone well before 1.3 of it."""
    model = resolved_model(five(), 1.2e-4)
    how = operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    limit = critical_time_step(model, LOAD)

    def grown(share):
        rows = advanced(copies(arrays(model, how, share * limit)), 12, 100)
        path = rows[:, 1:3]
        return not np.all(np.isfinite(path)) or np.abs(path - path[0]).max() > 1e-3 * np.abs(path[0]).max()

    assert not grown(0.99)
    assert grown(1.3)

"""Static equilibrium: the paper's bearing against a fully resolved reference, balances, other bearings, light loads."""

from dataclasses import replace
from functools import cache, lru_cache

import h5py
import numpy as np
import pytest
import xarray

from fem.commands.run_fem import run_main
from fem.contacts.model import Motion, unloaded
from fem.kernels.elements.rings import HALO
from fem.quantities import Quantity, moving_quantities
from fem.solver.errors import SAFETY, Choice, coarser_scene, estimates, mesh_table, model_choices, suggestion
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import LOOSE_SPRING, Loads, NotFound
from fem.statics.equilibrium import equilibrium, static_quantities
from fem.statics.exact_statics import exact_statics
from lagrange import Bearing, Material
from lagrange.errors import UsageError
from lagrange.fits import spinning_growth
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import read_scene
from lagrange.surface.faults import UnequalRoller
from meshes import quality
from tests.reference.compiled import drift, kick, press_contacts
from tests.reference.continua import half_width, squeezed_disc_approach
from tests.reference.kit import (
    HALF_PITCH,
    LENGTH,
    LOAD,
    ON_A_ROLLER,
    RESOLVED,
    SHAPES,
    STEEL,
    arrays,
    copies,
    fair_load,
    model,
    operation,
    paper,
    start_of,
)
from tests.reference.quadratic import (
    RefinedDisc,
    RefinedSector,
    Spot,
    contact_nodes,
    disc_spot_compliance,
    quadratic_statics,
    refined_mesh,
    ring_spot_compliance,
)
from tests.verification.contact_statics import at_rest

SOFT = Material(youngs_modulus=3e9, poisson_ratio=0.45, density=1200.0)


def motion(bearing, first, turn=0.0, cage_speed=0.0, roller_speed=0.0, ring_speed=0.0):
    return Motion(
        roller_angle=roller_angles(bearing, first), roller_turn=np.full(bearing.n_rollers, turn), ring_turn=turn,
        cage_speed=cage_speed, roller_speed=roller_speed, ring_speed=ring_speed,
    )  # fmt: skip


@lru_cache
def solve(bearing, mesh_size, first, load=LOAD, turn=0.0, weight=0.0, gravity=0.0, **speeds):
    how = motion(bearing, first, turn, **speeds)
    return equilibrium(model(bearing, mesh_size), how, Loads(load + weight, gravity))


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.37])
@pytest.mark.parametrize(("first", "microns", "loads"), RESOLVED.values(), ids=RESOLVED.keys())
@pytest.mark.parametrize(
    # measured 0.043 % and 0.124 % (the springiness between contacts is the mesh's own); the reference is good to 0.02 %
    ("mesh_size", "tolerance"), [(1e-3, 8e-4), (2e-3, 2e-3)]
)  # fmt: skip
def test_the_papers_bearing_agrees_with_the_resolved_reference(mesh_size, tolerance, first, microns, loads, turn):
    found = solve(paper(), mesh_size, first, turn=turn)
    assert -1e6 * found.hub[1] == pytest.approx(microns, rel=tolerance)
    assert abs(found.hub[0]) < 1e-4 * microns * 1e-6
    # a force as wrong as the printed digit and the hub's displacement make it, each 0.1 N
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][:7], loads, rtol=2e-4, atol=0.1)


def test_the_answer_does_not_depend_on_how_bodies_are_turned_under_their_contacts():
    hubs = [solve(paper(), 2e-3, ON_A_ROLLER, turn=turn).hub[1] for turn in (0.0, 0.05, 0.1, 0.2, 0.37)]
    assert np.ptp(hubs) < 2e-6 * abs(np.mean(hubs))  # the calibrated ripples; 1.4 % of a contact without them


every_bearing = pytest.mark.parametrize("bearing", SHAPES.values(), ids=SHAPES.keys())


def normals(bearing, found, first):
    angle = roller_angles(bearing, first)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    to_roller = radial * found.rho[:, None] - found.hub
    return radial, to_roller / np.hypot(*to_roller.T)[:, None]


@every_bearing
def test_forces_balance_the_load(bearing):
    load, first = fair_load(bearing), ON_A_ROLLER + 0.1
    found = solve(bearing, 0.4 * bearing.roller_radius, first, load)
    radial, normal = normals(bearing, found, first)
    tolerance = 1e-8 * load + LOOSE_SPRING * 1e-4  # Newton's, and the springs that keep loose rollers
    np.testing.assert_allclose(-found.inner_force @ normal, [0.0, load], rtol=0.0, atol=tolerance)
    along = np.sum(normal * radial, axis=1)
    np.testing.assert_allclose(found.inner_force * along, found.outer_force, rtol=0.0, atol=tolerance)
    assert found.inner_force.min() >= -tolerance
    assert found.inner_force.max() > 2.5 * load / bearing.n_rollers  # 4 by Stribeck without clearance


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "three rollers"])
def test_a_symmetric_scene_has_a_symmetric_answer(name):
    bearing = SHAPES[name]
    found = solve(bearing, 0.4 * bearing.roller_radius, ON_A_ROLLER, fair_load(bearing))
    assert abs(found.hub[0]) < 1e-4 * abs(found.hub[1])  # meshes are no mirror images: 1e-6 of ripple is left
    mirrored = np.roll(found.inner_force[::-1], 1)
    np.testing.assert_allclose(found.inner_force, mirrored, rtol=0.0, atol=1e-4 * found.inner_force.max())
    assert np.argmax(found.inner_force) == 0


def test_a_hub_that_could_only_balance_on_one_roller_leans_on_two():
    found = solve(SHAPES["three rollers"], 2e-3, ON_A_ROLLER)
    loaded = found.inner_force > 0.0
    assert loaded[0] and loaded.sum() == 2
    # sunk by s and rolled aside by t, it meets the next roller, 30° above the horizontal, where t cos 30° = s sin 30°
    assert abs(found.hub[0]) == pytest.approx(-found.hub[1] * np.tan(np.pi / 6.0), rel=5e-3)


@every_bearing
def test_halving_the_mesh_changes_the_answer_by_discretisation_only(bearing):
    coarse, fine = (
        solve(bearing, size * bearing.roller_radius, ON_A_ROLLER + 0.1, fair_load(bearing)) for size in (0.4, 0.2)
    )
    assert coarse.hub[1] == pytest.approx(fine.hub[1], rel=2e-3)  # measured at most 1.1e-3, preload
    np.testing.assert_allclose(coarse.inner_force, fine.inner_force, rtol=0.0, atol=1e-3 * fine.inner_force.max())


def test_three_rollers_share_the_load_by_statics_alone():
    first = ON_A_ROLLER + np.pi / 3.0  # two rollers at ±60° to the load, one opposite
    found = solve(SHAPES["three rollers"], 2e-3, first)
    turn = -found.hub[1] * np.sin(np.pi / 3.0) / 0.023  # of the lines of centres, 0.8 mrad as the hub sinks by 21 µm
    assert turn < 1e-3
    np.testing.assert_allclose(found.inner_force[[0, 2]], 0.5 * LOAD / np.cos(np.pi / 3.0 + turn), rtol=1e-5)
    assert found.inner_force[1] < 1e-3


def test_clearance_lets_the_hub_down_further_by_about_itself():
    play, tight = (solve(SHAPES[name], 2e-3, ON_A_ROLLER) for name in ("clearance", "paper"))
    assert SHAPES["clearance"].radial_clearance == pytest.approx(1e-5, rel=1e-6)
    assert 1e-5 < tight.hub[1] - play.hub[1] < 1.3e-5  # and fewer rollers carry
    assert np.sum(play.inner_force > 1.0) < np.sum(tight.inner_force > 1.0)


def test_preload_loads_every_roller_alike_without_a_load():
    bearing = SHAPES["preload"]
    found = solve(bearing, 2e-3, ON_A_ROLLER + 0.1, 0.0)
    assert found.inner_force.min() > 1.0
    np.testing.assert_allclose(found.inner_force, found.inner_force.mean(), rtol=1e-4)
    assert np.abs(found.hub).max() < 1e-10


@pytest.mark.parametrize("name", ["clearance", "paper"])
def test_without_load_nothing_touches_and_nothing_moves(name):
    found = solve(SHAPES[name], 2e-3, ON_A_ROLLER + 0.1, 0.0)
    np.testing.assert_allclose(found.inner_force, 0.0, atol=1e-8)
    np.testing.assert_allclose(found.outer_force, 0.0, atol=1e-8)
    assert np.abs(found.hub).max() < 1e-12
    assert np.abs(found.rollers).max() < 1e-15


@pytest.mark.parametrize("load", [1e-2, 1.0, 30.0, 100.0, 2000.0, 20000.0])
@pytest.mark.parametrize("name", ["paper", "clearance", "preload", "ceramic rollers"])
def test_every_load_converges_wherever_the_rollers_are(name, load):
    bearing = SHAPES[name]
    for first in ON_A_ROLLER + np.linspace(0.0, 2.0 * np.pi / 13.0, 7):
        found = solve(bearing, 2e-3, first, load)
        _, normal = normals(bearing, found, first)
        assert -(found.inner_force @ normal)[1] == pytest.approx(load, rel=1e-6, abs=2e-5)


@pytest.mark.parametrize("load", [0.0, 10.0])
@pytest.mark.parametrize("speed", [0.0, 471.2])
@pytest.mark.parametrize("name", ["paper", "clearance", "ceramic rollers"])
def test_light_loads_with_gravity_converge_wherever_the_rollers_are(name, speed, load):
    for first in ON_A_ROLLER + np.linspace(0.0, 2.0 * np.pi / 13.0, 9):
        how = operation(radial_load=load, speed=speed, first_roller_angle=first)
        found = start_of(model(SHAPES[name], 2e-3), how).equilibrium
        _, normal = normals(SHAPES[name], found, first)
        assert -(found.inner_force @ normal)[1] == pytest.approx(load + how.inner_mass * how.gravity, abs=2e-5)


@pytest.mark.parametrize("load", [3.0, 3350.0])
@pytest.mark.parametrize("first", [-0.757, -1.5, ON_A_ROLLER])
def test_many_weightless_rollers_in_a_wide_clearance_converge(first, load):
    """18 of 53 rollers touch; those opposite and those that only their clearance holds are free."""
    bearing = Bearing(
        n_rollers=53, roller_radius=0.003, roller_length=0.018, inner_raceway_radius=0.0522,
        outer_raceway_radius=0.05828, bore_radius=0.045, outside_radius=0.066,
        roller=STEEL, inner_ring=STEEL, outer_ring=STEEL,
    )  # fmt: skip
    found = solve(bearing, 1.2e-3, first, load)
    _, normal = normals(bearing, found, first)
    # beside the contacts only the springs that keep loose rollers act, 1 N/m over 0.1 mm
    np.testing.assert_allclose(-found.inner_force @ normal, [0.0, load], rtol=0.0, atol=1e-8 * load + 1e-4)
    assert found.hub[1] == pytest.approx(-bearing.radial_clearance, rel=0.06)


def test_unloaded_rollers_at_speed_lean_on_the_outer_ring_with_their_centrifugal_force():
    bearing, cage = SHAPES["clearance"], 200.0
    found = solve(bearing, 2e-3, ON_A_ROLLER + 0.1, cage_speed=cage)
    centrifugal = bearing.roller_mass * cage**2 * found.rho
    assert centrifugal.mean() > 5.0
    free = found.inner_force < 1e-9
    assert free.sum() >= 6
    np.testing.assert_allclose(found.outer_force[free], centrifugal[free], rtol=1e-5)
    _, normal = normals(bearing, found, ON_A_ROLLER + 0.1)
    radial, _ = normals(bearing, found, ON_A_ROLLER + 0.1)
    along = np.sum(normal * radial, axis=1)
    np.testing.assert_allclose(found.outer_force - found.inner_force * along, centrifugal, rtol=1e-5)


def test_weight_acts_on_hub_and_rollers():
    bearing, gravity = paper(), 981.0  # strong, to be seen
    found = solve(bearing, 2e-3, ON_A_ROLLER, weight=50.0, gravity=gravity)
    radial, normal = normals(bearing, found, ON_A_ROLLER)
    assert -(found.inner_force @ normal)[1] == pytest.approx(LOAD + 50.0, rel=1e-7)
    along = np.sum(normal * radial, axis=1)
    held = found.outer_force - found.inner_force * along
    np.testing.assert_allclose(held, -bearing.roller_mass * gravity * radial[:, 1], rtol=0.0, atol=5e-5)


def test_a_fast_ring_closes_its_contacts_by_its_growth():
    still, fast = (solve(paper(), 2e-3, ON_A_ROLLER, ring_speed=speed) for speed in (0.0, 5000.0))
    growth = fast.inner_ring[-1, 0].mean() - still.inner_ring[-1, 0].mean()
    assert growth > 1e-7
    assert fast.inner_force.sum() > still.inner_force.sum() + 1.0


def test_bodies_that_spin_carry_around_what_they_have_grown_by():
    """Plastic at 360 m/s, beside the exact solution: what differs is the mesh's, of slow bodies as much."""
    bearing = replace(paper(), **dict.fromkeys(("inner_ring", "roller"), SOFT))
    whole = model(bearing, 2e-3)
    shares = []
    for speed in (20.0, 2e4):
        free = unloaded(whole, motion(bearing, 0.0, ring_speed=speed, roller_speed=3.6 * speed), 0.0)
        disc, ring = whole.roller, bearing.inner_raceway_radius
        surface = slice(disc.first_surface_node, None)
        outward = disc.points[surface] / bearing.roller_radius
        rolled = np.sum(free.roller_growth.reshape(-1, 2)[surface] * outward, axis=1).mean()
        exact = spinning_growth(ring, bearing.bore_radius, SOFT, speed)
        exact_rolled = spinning_growth(bearing.roller_radius, 0.0, SOFT, 3.6 * speed)
        shares.append([free.inner_growth[-1, 0].mean() / exact, rolled / exact_rolled])
    np.testing.assert_allclose(shares[1], shares[0], rtol=1e-4)
    np.testing.assert_allclose(shares[0], 1.0, atol=0.03)


def test_the_deformed_bodies_carry_the_contact_forces():
    """The fields that come out are equilibria of the assembled bodies, contact by contact."""
    whole, found = model(paper(), 2e-3), solve(paper(), 2e-3, ON_A_ROLLER + 0.1)
    free = whole.inner_ring.free_rows
    force = whole.inner_ring.force(found.inner_ring)[free]
    assert np.abs(force[:-1]).max() < 1e-9 * LOAD
    resultant = np.sum(force[-1, 0] * np.sin(whole.inner_ring.angles) + force[-1, 1] * np.cos(whole.inner_ring.angles))
    # the load presses the ring up against its bore; patches sit along the last but one lines of centres
    assert resultant == pytest.approx(LOAD, rel=1e-5)
    for j in (0, 5):
        inside = (whole.roller.stiffness @ found.rollers[j].ravel()).reshape(-1, 2)[: whole.roller.first_surface_node]
        assert np.abs(inside).max() < 1e-3 * LOAD  # inertia relief of the microradians between the two contacts
        assert abs(whole.roller.mass @ found.rollers[j][:, 0]) < 1e-15 * whole.roller.total_mass


def nothing_turns(**changes):
    return operation(speed=0.0, gravity=0.0, first_roller_angle=ON_A_ROLLER + 0.1, **changes)


def test_the_time_loop_sees_the_same_contact_forces():
    state = arrays(model(paper(), 2e-3), nothing_turns(), 1e-7)
    wanted = state.contacts.forces.force.copy()
    state.contacts.forces.force[:] = 0.0
    press_contacts(state)
    # geometry to the last digit: 3.5e-18 m of round-off times 1e9 N/m, and patches turned by the last Newton pass
    np.testing.assert_allclose(state.contacts.forces.force, wanted, rtol=0.0, atol=1e-6 * LOAD)


@pytest.mark.slow  # a time loop of its own to compile
def test_the_time_loop_stays_in_static_equilibrium():
    dt = 1e-7
    state = copies(arrays(model(paper(), 2e-3), nothing_turns(), dt))
    for _ in range(200):
        kick(state.bodies, state.groups, state.contacts, state.drive, 0.0, state.scratch)
        drift(state.bodies, state.groups, state.contacts, state.drive, state.scratch)
    # a surface node of 3e-5 kg under one newton more would run at 3e-3 m/s after one step
    assert np.abs(state.drive.velocity).max() < 1e-7
    assert np.abs(state.bodies.disc.w).max() < 1e-6
    for ring in (state.bodies.inner, state.bodies.outer):
        assert np.abs(ring.w[..., HALO:-HALO]).max() < 1e-6  # beside them what contacts put across the seam is left


@pytest.mark.parametrize("load", [500.0, LOAD])
def test_the_rolling_start_passes_through_its_neighbouring_equilibria(load):
    """Velocities of the start against equilibria a longer way ahead and behind."""
    how = operation(radial_load=load)
    whole = model(paper(), 2e-3)
    start = start_of(whole, how)
    ideal, ahead = start.kinematics, 2e-7

    def at(time):
        moved = Motion(
            roller_angle=start.angle + ideal.cage * time, roller_turn=np.full(13, ideal.roller * time),
            ring_turn=how.speed * time, cage_speed=ideal.cage, roller_speed=ideal.roller, ring_speed=how.speed,
        )  # fmt: skip
        return equilibrium(whole, moved, Loads.of(how), start.equilibrium)

    before, after = at(-ahead), at(ahead)
    velocity = (after.hub - before.hub) / (2.0 * ahead)
    # second-order differences over steps that differ twofold; and Newton's 1e-9 of 4 µm over 4e-7 s
    np.testing.assert_allclose(start.hub_velocity, velocity, rtol=0.0, atol=1e-3 * np.abs(velocity).max() + 1e-8)
    assert np.abs(velocity).max() > 1e-5
    rate = (after.rollers - before.rollers) / (2.0 * ahead)
    np.testing.assert_allclose(start.roller_rate, rate, rtol=0.0, atol=5e-3 * np.abs(rate).max())


# The finite elements converge to the mesh-free yardstick


def test_the_elements_converge_to_the_yardstick():
    exact = -exact_statics(paper(), LOAD, HALF_PITCH).hub[1]
    error = [abs(-at_rest(paper(), size, HALF_PITCH, LOAD).hub[1] / exact - 1.0) for size in (2e-3, 1e-3, 0.5e-3)]
    assert error[0] > error[1] > error[2]
    assert error[0] < 1.2e-3 and error[2] < 1e-4


# What a dry run says of every model for a scene


def choices_of(*settings: str) -> dict[str, Choice]:
    return {each.model: each for each in model_choices(make_plan(read_scene(None, settings)))}


def test_elastic_models_are_near_the_exact_series_and_rigid_bodies_are_not():
    """Harris' law errs by 14 % of the paper's bearing: docs/lagrange.md."""
    found = choices_of("model=reduced", "numerics.mesh_size_mm=2")
    assert found["reduced"].hub_error < 1e-6
    assert found["fem"].hub_error == pytest.approx(1.0e-3, rel=0.2)
    assert found["lagrange"].hub_error == pytest.approx(0.14, abs=0.01)
    assert min(each.seconds for each in found.values()) > 0.0  # what they are is the machine's
    assert suggestion(list(found.values())).startswith('start with "reduced"')


def test_what_a_model_refuses_is_told_with_its_reason():
    found = choices_of("model=lagrange", "bodies.rollers=rigid", "numerics.mesh_size_mm=2")
    assert found["reduced"].seconds is None and "rigid" in found["reduced"].lacks
    assert found["fem"].seconds > 0.0
    assert suggestion(list(found.values())).startswith('model = "fem"')


def test_without_load_no_error_is_named():
    found = choices_of("model=lagrange", "operation.radial_load_N=0", "numerics.mesh_size_mm=2")
    assert {each.hub_error for each in found.values()} == {None}


def test_a_dry_run_shows_the_models(capsys):
    assert run_main(["--dry-run", "--mesh-size", "2"]) == 0
    told = capsys.readouterr().out
    assert "Models for this scene" in told and "start with" in told


def test_balls_leave_no_choice(capsys):
    assert run_main(["--dry-run", "--model", "lagrange", "--set", "bearing.type=ball"]) == 0
    assert "Models for this scene" not in capsys.readouterr().out


# run-fem --converge: statics on three meshes, Richardson's value beside the exact series


@pytest.fixture(scope="module")
def found_mesh_convergence():
    return mesh_table(read_scene(None, ("numerics.mesh_size_mm=1.5",)))


def test_richardsons_value_is_nearer_to_the_exact_series_than_the_finest_mesh(found_mesh_convergence):
    hub, exact = found_mesh_convergence.meshes[-1].quantities[0].value, found_mesh_convergence.exact[0]
    assert abs(found_mesh_convergence.extrapolated[0] - exact) < 0.5 * abs(hub - exact)
    assert found_mesh_convergence.extrapolated[0] == pytest.approx(exact, rel=5e-4)


def test_loads_and_pressures_of_all_meshes_are_those_of_the_series(found_mesh_convergence):
    assert [mesh.size for mesh in found_mesh_convergence.meshes] == pytest.approx([3.0, 2.1213, 1.5], abs=1e-4)
    assert (
        found_mesh_convergence.meshes[0].nodes
        < found_mesh_convergence.meshes[1].nodes
        < found_mesh_convergence.meshes[2].nodes
    )
    for mesh in found_mesh_convergence.meshes:
        _, force, pressure = mesh.quantities
        assert force.value == pytest.approx(found_mesh_convergence.exact[1], rel=1e-3)
        assert pressure.value == pytest.approx(found_mesh_convergence.exact[2], rel=1e-3)


def test_comparison_contacts_are_refused():
    with pytest.raises(UsageError, match="order of convergence"):
        mesh_table(read_scene(None, ("contact.model=faceted",)))


def test_the_command_shows_meshes_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "110")
    assert run_main(["--converge", "--mesh-size", "2"]) == 0
    told = capsys.readouterr().out
    assert "Richardson" in told and "exact series" in told and "MPa" in told and not list(tmp_path.iterdir())


def test_where_the_scenes_mesh_is_coarse_it_is_the_coarsest():
    table = mesh_table(read_scene(None, ("numerics.mesh_size_mm=2.5",)))
    assert table.meshes[0].size == pytest.approx(2.5)


# The stated discretisation error: Richardson's extrapolation, bracketing the true one, in the result file


def quantity(value):
    return Quantity(name="q", unit="m", meaning="any", value=value)


@pytest.mark.parametrize("ratio", [1.5, 2.0, 3.0])
def test_the_error_of_a_second_order_sequence_is_found_up_to_the_factor_of_safety(ratio):
    exact, factor = 3.6, -0.4
    fine, coarse = (quantity(exact + factor * h**2) for h in (0.1, 0.1 * ratio))
    found = estimates([fine], [coarse], ratio)[0]
    assert found.error == pytest.approx(SAFETY * abs(fine.value - exact), rel=1e-12)
    assert found.relative == pytest.approx(found.error / 3.596, rel=1e-12)


def test_the_estimate_brackets_the_true_error_of_nine_bearings_in_ten():
    """Against the exact series; surface spacings of a fifth and two fifths of the rollers' radius."""
    bracketed = {}
    for name, bearing in SHAPES.items():
        how = operation(gravity=0.0, radial_load=fair_load(bearing))
        size = bearing.roller_radius / 5.0
        fine, coarse = (model(bearing, h) for h in (size, 2.0 * size))
        ratio = coarse.roller.shape.surface_spacing / fine.roller.shape.surface_spacing
        found = estimates(static_quantities(fine, how), static_quantities(coarse, how), ratio)
        exact = exact_statics(bearing, how.radial_load, how.first_roller_angle)
        true = {
            "static_hub_y": abs(found[1].quantity.value - exact.hub[1]),
            "static_largest_force": abs(found[2].quantity.value - exact.inner_force.max()),
        }
        round_off = {"static_hub_y": 1e-8 * abs(exact.hub[1]), "static_largest_force": 1e-8 * how.radial_load}
        bracketed[name] = all(
            each.error + round_off[each.quantity.name] >= true[each.quantity.name] for each in found[1:3]
        )
    assert len(bracketed) >= 10
    assert sum(bracketed.values()) >= 0.9 * len(bracketed), bracketed


def test_quantities_at_rest_are_those_of_the_whole_load():
    """A load that a pitch of the rollers has turned displaces the hub as far, a pitch further round."""
    how = operation(gravity=0.0, radial_load=2000.0)
    whole = model(SHAPES["paper"], 1e-3)
    pitch = 2.0 * np.pi / whole.bearing.n_rollers
    turned = replace(how, radial_load=2000.0 * np.cos(pitch), side_load=2000.0 * np.sin(pitch))
    down, aside = (complex(*(each.value for each in static_quantities(whole, loads)[:2])) for loads in (how, turned))
    assert aside == pytest.approx(down * np.exp(1j * pitch), rel=1e-3)


def test_moving_quantities_are_those_of_a_made_up_record():
    time = np.linspace(0.0, 1.0, 1001)
    wave = np.sin(2.0 * np.pi * 10.0 * time)
    angle = 3.0 * time[:, None] + np.arange(4)
    force = np.column_stack([100.0 + 5.0 * wave, 50.0 + 0.0 * time, 0.0 * time, 0.0 * time])
    record = {"time": time, "inner_x": 1e-8 * wave, "inner_y": -3e-6 + 2e-8 * wave, "inner_force": force}
    found = {each.name: each.value for each in moving_quantities({**record, "roller_theta": angle})}
    assert found["hub_mean_y"] == pytest.approx(-3e-6, rel=1e-9)
    assert found["hub_std_x"] == pytest.approx(1e-8 / np.sqrt(2.0), rel=1e-3)
    assert found["hub_std_y"] == pytest.approx(2e-8 / np.sqrt(2.0), rel=1e-3)
    assert found["largest_force"] == pytest.approx(105.0, rel=1e-4)
    assert found["mean_largest_force"] == pytest.approx(100.0, rel=1e-4)
    assert found["cage_speed"] == pytest.approx(3.0, rel=1e-12)


def test_a_mesh_that_leaves_no_coarser_one_is_refused(capsys, tmp_path):
    with pytest.raises(UsageError, match=r"mesh_size_mm = 2\.5"):
        coarser_scene(read_scene(None, ("numerics.mesh_size_mm=2.5",)))
    assert coarser_scene(read_scene()).numerics.mesh_size_mm == 2.0
    output = tmp_path / "no.nc"
    assert run_main(["--estimate-error", "--mesh-size", "3", "--output", str(output)]) == 2
    assert "--estimate-error" in capsys.readouterr().err and not output.exists()


def test_the_result_file_states_the_error_until_the_record_grows(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "1.9", "--output", str(path), "--duration"]
    assert run_main([*options, "0.3", "--estimate-error"]) == 0
    assert "may be off by" in capsys.readouterr().out
    with xarray.open_dataset(path) as data:
        names = data["quantity"].values.tolist()
        error, value = (data[name].values for name in ("quantity_error", "quantity_value"))
        assert data.attrs["coarse_mesh_size"] == pytest.approx(np.pi * 1e-3)
        hub = names.index("hub_mean_y")
        mean = np.trapezoid(data["inner_y"], data["time"]) / float(data["time"][-1] - data["time"][0])
        assert value[hub] == pytest.approx(mean, rel=1e-12)
        assert 1e-5 < error[hub] / abs(value[hub]) < 0.02
        assert np.all(error >= 0.0)
    assert run_main([*options, "0.4", "--resume"]) == 0
    with h5py.File(path) as file:
        assert "quantity" not in file and "coarse_mesh_size" not in file.attrs


# Statics on refined quadratic meshes: meshes, compliances of single bodies, and the whole bearing.


B = 5e-5  # m
SPOT = Spot(half_width=B, per_half_width=4)
OTHER = Spot(half_width=0.8 * B, per_half_width=4)  # the same contact on another mesh


def pressed_by_hertz(spot):
    """Shares of a Hertz pressure of half-width B on the nodes of a spot."""
    along, length = contact_nodes(spot)
    share = length * np.sqrt(np.maximum(0.0, 1.0 - (along / B) ** 2))
    return share / share.sum()


# meshes and compliances -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape",
    [
        RefinedDisc(radius=0.005, spot=SPOT),
        RefinedSector(raceway_radius=0.018, held_radius=0.0125, sectors=13, spot=SPOT),
        RefinedSector(raceway_radius=0.028, held_radius=0.0325, sectors=3, spot=SPOT),
    ],
)
def test_meshes_are_as_fine_as_the_contact_and_their_triangles_fair(shape):
    mesh = refined_mesh(shape)
    found = quality(mesh)
    assert found.smallest_angle > 30.0 and found.largest_angle < 120.0
    assert found.smallest_edge < 1.05 * SPOT.finest
    assert found.largest_edge > 100.0 * SPOT.finest, "coarse away from the contact"
    edges = np.diff(SPOT.corners)
    at_rim = edges[np.searchsorted(SPOT.corners, B) - 1]
    assert at_rim == pytest.approx(B / 4.0, rel=0.2)


def test_node_lengths_integrate_quadratics():
    along, length = contact_nodes(SPOT)
    end = along[-1]
    assert length.sum() == pytest.approx(2.0 * end, rel=1e-12)
    assert length @ along**2 == pytest.approx(2.0 / 3.0 * end**3, rel=1e-12)


def test_a_squeezed_disc_gives_way_as_johnson_says():
    own, other = disc_spot_compliance(RefinedDisc(radius=0.005, spot=SPOT), STEEL, LENGTH)
    np.testing.assert_allclose(own, own.T, atol=1e-10 * own.max())
    share, along = pressed_by_hertz(SPOT), contact_nodes(SPOT)[0]
    width = 2.0 * np.sqrt(share @ along**2)  # of the pressure as the nodes have it: 0.8 % off B
    # a mean weighted with the pressure: the middle sinks in by q/(2πE') more
    q = 1.0 / LENGTH
    middle = share @ (own + other[:, ::-1]) @ share + 0.5 * q / (np.pi * STEEL.plane_strain_modulus)
    exact = squeezed_disc_approach(q, 0.005, width, STEEL.plane_strain_modulus)
    assert middle == pytest.approx(exact, rel=2e-4)


@pytest.mark.slow
def test_a_ring_is_the_same_cut_into_other_sectors():
    shape = {"raceway_radius": 0.018, "held_radius": 0.0125}
    of_four = ring_spot_compliance(RefinedSector(sectors=4, spot=SPOT, **shape), STEEL, LENGTH)
    of_eight = ring_spot_compliance(RefinedSector(sectors=8, spot=OTHER, **shape), STEEL, LENGTH)
    four = pressed_by_hertz(SPOT) @ of_four @ pressed_by_hertz(SPOT)
    eight = pressed_by_hertz(OTHER) @ of_eight @ pressed_by_hertz(OTHER)
    np.testing.assert_allclose(four, eight[::2], atol=2e-3 * four[0])
    np.testing.assert_allclose(four[1:], eight[2::2], rtol=2e-3)
    np.testing.assert_allclose(of_eight[3], of_eight[-3].T, atol=1e-9 * of_eight[0].max())


# the whole bearing ----------------------------------------------------------------------------------------------


@cache
def at_rest_quadratic_statics(place, per_half_width):
    return quadratic_statics(paper(), LOAD, RESOLVED[place][0], per_half_width)


@pytest.mark.parametrize("place", RESOLVED)
def test_the_papers_bearing_rests_as_another_code_finds(place):
    _, microns, loads = RESOLVED[place]
    found = at_rest_quadratic_statics(place, 4.0)
    assert -1e6 * found.hub[1] == pytest.approx(microns, rel=5e-4)
    assert abs(found.hub[0]) < 1e-5 * abs(found.hub[1])
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][:7], loads, atol=1e-3 * max(loads))


def test_bodies_push_or_stand_apart_and_carry_the_load():
    found = at_rest_quadratic_statics("on a roller", 4.0)
    pressure = np.array([found.inner_pressure, found.outer_pressure])
    assert pressure.min() == 0.0 and found.gap.min() > -1e-15
    assert np.abs(found.gap[pressure > 0.0]).max() < 1e-15
    angle = -0.5 * np.pi + 2.0 * np.pi * np.arange(13) / 13
    centres = found.rho[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) - found.hub
    normal = centres / np.linalg.norm(centres, axis=1)[:, None]
    np.testing.assert_allclose(found.inner_force @ normal, [0.0, -LOAD], atol=1e-5)
    np.testing.assert_allclose(found.outer_force, found.inner_force, atol=1e-4)


def test_pressures_are_hertzs():
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4); nodes beside its rim apart."""
    found = at_rest_quadratic_statics("on a roller", 4.0)
    for forces, pressures, curvature in (
        (found.inner_force, found.inner_pressure, 1.0 / 0.005 + 1.0 / 0.018),
        (found.outer_force, found.outer_pressure, 1.0 / 0.005 - 1.0 / 0.028),
    ):
        q = forces[0] / LENGTH
        b = half_width(q, 1.0 / curvature, 0.5 * STEEL.plane_strain_modulus)
        peak = 2.0 * q / (np.pi * b)
        inside, outside = np.abs(found.across) < 0.8 * b, np.abs(found.across) > 1.2 * b
        ellipse = peak * np.sqrt(1.0 - (found.across[inside] / b) ** 2)
        np.testing.assert_allclose(pressures[0, inside], ellipse, atol=0.03 * peak)
        assert pressures[0].max() == pytest.approx(peak, rel=0.01)
        assert not pressures[0, outside].any()


def test_a_mesh_made_for_other_contacts_is_refused():
    with pytest.raises(ValueError, match="radial load 0 N"):
        quadratic_statics(paper(), 0.0, 0.0)
    with pytest.raises(NotFound, match="wider than"):  # preload, not the load, makes the contacts
        quadratic_statics(paper(outer_raceway_radius=0.027995), 1.0, 0.0, 2.0)


def test_surfaces_that_are_not_circles_are_refused():
    faulty = replace(paper(), faults=(UnequalRoller(roller=0, diameter_deviation=1e-6),))
    with pytest.raises(ValueError, match="perfect circles"):
        quadratic_statics(faulty, LOAD, -np.pi / 2)

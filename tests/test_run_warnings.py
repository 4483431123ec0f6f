"""What a run warns of when it is over: contacts that a shock has pressed wider than at rest."""

import h5py
import numpy as np
import pytest
from scipy.special import elliprd

from fem.commands.run_fem import run_main
from fem.interface import simulate
from fem.solver.guards import n_in_place, run_warnings
from fem.solver.rigid.lagrangian import Judge
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.contact.hertz import contact_ellipse, contact_pairs, raceway_curvature
from lagrange.equations import THROUGH, farthest_place
from lagrange.scene.scene import parse_scene, read_scene
from tests.reference.commands import command
from tests.reference.whole_run import whole_run

SOFT = """
[bearing]
rollers = 31
roller_diameter_mm = 13.2
roller_length_mm = 20.0
inner_raceway_diameter_mm = 140.0
outer_raceway_diameter_mm = 166.4
bore_diameter_mm = 110.0
outside_diameter_mm = 196.0
[material]
youngs_modulus_GPa = 3.6
[operation]
speed_rpm = 500.0
radial_load_N = 7756.0
inner_ring_and_shaft_kg = 30.0
gravity_m_s2 = 200.0
[numerics]
start = "rest"
load_ramp_ms = 0.0
duration_ms = 6.0
mesh_size_mm = 3.0
"""
WORDS = "beyond Hertz's theory and small strains (at most 0.66 mm)"


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    folder = tmp_path_factory.mktemp("soft")
    (folder / "soft.toml").write_text(SOFT)
    return folder


def test_contacts_too_wide_in_a_shock_are_told_in_the_summary_and_the_result_and_remembered_by_a_resumed_run(soft):
    """The second leg, whose duration is the first one's, takes no step of its own."""
    for words in ([], ["--resume"]):
        done = command("run-fem", "soft.toml", "--output", "soft.nc", *words, folder=soft)
        assert done.returncode == 0 and done.stdout.count(WORDS) == 1
        with h5py.File(soft / "soft.nc") as file:
            assert file.attrs["warnings"].count(WORDS) == 1 and file.attrs["status"] == "complete"


def test_the_same_load_from_equilibrium_is_told_nothing_of(soft):
    arguments = ["--set", "numerics.start=equilibrium", "--set", "operation.gravity_m_s2=9.81", "--output", "calm.nc"]
    done = command("run-fem", "soft.toml", *arguments, folder=soft)
    assert done.returncode == 0 and "Warning" not in done.stdout
    with h5py.File(soft / "calm.nc") as file:
        assert file.attrs["warnings"] == ""


def test_the_lagrangian_model_watches_its_largest_contact_too(soft):
    """Its law knows nothing of widths; the second leg takes no step of its own."""
    path = soft / "springs.nc"
    arguments = [str(soft / "soft.toml"), "--model", "lagrange", "--output", str(path), "--quiet"]
    for words in ([], ["--resume"]):
        assert run_main([*arguments, *words]) == 0
        with h5py.File(path) as file:
            assert WORDS in file.attrs["warnings"] and file.attrs["warnings"].count("beyond Hertz") == 1


@pytest.mark.parametrize("which", range(3))
def test_the_limit_is_a_tenth_of_the_rollers_radius_for_each_kind_of_contact(which):
    """Hertz: b² = 4QR/(πE*L)."""
    bearing = read_scene().ideal_bearing()
    pair = contact_pairs(bearing)[which]
    force = (0.1 * bearing.roller_radius) ** 2 / pair.half_width_factor
    forces = [0.0, 0.0, 0.0]
    for factor, count in ((0.999, 0), (1.001, 1)):
        forces[which] = factor * force
        assert len(run_warnings(bearing, np.array(forces))) == count


def test_balls_are_watched_by_the_ellipse_in_their_groove():
    """Hertz's pressure on the ellipse closes the gap of the curvatures, by potential theory's integrals."""
    bearing = parse_scene({"model": "lagrange", "bearing": {"designation": "6205"}}, "").ideal_bearing()
    force = 2000.0
    a, b = contact_ellipse(bearing, "inner", force)
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / bearing.inner_ring.plane_strain_modulus
    pressure = 1.5 * force / (np.pi * a * b)
    curvature = raceway_curvature(bearing, "inner")
    along, across = curvature.ball_2 + curvature.raceway_2, curvature.ball_1 + curvature.raceway_1
    for axis, other, of in ((a, b, along), (b, a, across)):  # Johnson, Contact Mechanics, 3.35
        integral = 2.0 / 3.0 * elliprd(0.0, other**2, axis**2)  # ∫ dw/((axis² + w)^(3/2) √((other² + w) w)), 0 to ∞
        assert pressure * a * b * compliance * integral == pytest.approx(of, rel=1e-9)
    limit = (0.6 * bearing.element_radius / a) ** 3 * force
    for factor, count in ((0.999, 0), (1.001, 1)):
        assert len(run_warnings(bearing, np.array([factor * limit, 0.0, 0.0]))) == count


def test_a_soft_law_of_ones_own_is_watched_by_its_overlaps():
    law = {"contact_stiffness_N_per_m_n": [2e6, 3e6], "contact_exponent": 1.0}
    plan = make_plan(parse_scene({"model": "lagrange", "lagrange": law}, ""))
    judge = Judge(plan.problem, plan.time_step)
    limit = 0.05 * plan.problem.bearing.roller_radius * 2e6
    assert judge.warnings(np.array([0.999 * limit, 0.0, 0.0])) == ()
    assert "overlap by 0.25 mm on the inner" in judge.warnings(np.array([1.001 * limit, limit, 0.0]))[0]


def test_the_checker_reads_whatever_a_run_goes_on_with():
    """A hub between four rollers, as far off as rigid bodies may be in one another."""
    table = {"rollers": 4, "roller_diameter_mm": 3.0, "roller_length_mm": 4.4, "inner_raceway_diameter_mm": 3.3}
    table |= {"outer_raceway_diameter_mm": 9.32, "bore_diameter_mm": 2.7, "outside_diameter_mm": 12.9}
    bearing = parse_scene({"model": "lagrange", "bearing": table}, "").ideal_bearing()
    give = THROUGH * bearing.roller_radius
    off = 1.999 * (bearing.radial_clearance + give)
    angle = np.radians([0.0, 90.0, 180.0, 270.0])
    x, y = bearing.pitch_radius * np.cos(angle), bearing.pitch_radius * np.sin(angle) + off
    values = {"inner_x": np.zeros(1), "inner_y": np.array([off]), "roller_x": x[None], "roller_y": y[None]}
    values["roller_rho"] = np.full((1, 4), bearing.pitch_radius)
    samples = Samples(values=values, imbalance=np.zeros(1), exchanged=np.zeros(1), error=np.zeros(1))
    assert n_in_place(bearing, give, samples) == 1
    assert 0.2 * bearing.pitch_radius < off < farthest_place(bearing)


def test_what_kicks_give_beyond_forces_is_what_the_hub_s_balance_misses_and_is_told_where_nothing_else_is():
    """Of rollers that strike: M a − forces, from the run's own samples, is at most what it says."""
    numerics = {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 1.0, "output_interval_us": 2.0}
    scene = parse_scene({"model": "reduced", "contact": {"friction_coefficient": 0.0}, "numerics": numerics}, "")
    plan = make_plan(scene)
    state = plan.first_state()
    found = whole_run(plan, state)  # it restarts with shorter steps
    x, y = (found[f"roller_{axis}"] - found[f"inner_{axis}"][:, None] for axis in "xy")
    push = found["inner_force"] / np.hypot(x, y)
    operation = plan.operation
    missed = np.hypot(
        operation.inner_mass * found["inner_ax"] + np.sum(push * x, axis=1),
        operation.inner_mass * (found["inner_ay"] + operation.gravity)
        + operation.radial_load
        + np.sum(push * y, axis=1),
    )
    most, largest = float(state.forces.beyond[0]), float(found["inner_force"].max())
    assert 1e-3 * largest < missed.max() <= most * (1.0 + 1e-6)
    assert not any("give the hub" in note for note in state.warnings), "it says that shocks excite waves"
    state.forces.fastest[:] = 0.0
    assert f"up to {most:.3g} N more or less than the contacts' forces" in state.warnings[-1]
    state._largest[:] = 0.0
    assert state._unequal_kicks == ()


@pytest.mark.slow
def test_what_a_guide_s_kicks_give_the_hub_beyond_forces_is_told_too():
    """A cage of 50 g strikes the inner ring of a preloaded bearing with 380 N, and rollers hardly notice it."""
    tables = {
        "model": "reduced", "bearing": {"outer_raceway_diameter_mm": 55.98},
        "cage": {
            "mass_kg": 0.05025, "guidance": "inner_ring", "guidance_clearance_mm": 0.02738,
            "pocket_clearance_mm": 0.4187, "friction_coefficient": 0.1025, "drag_torque_N_m": 0.6086,
            "damping_N_s_m": 0.2764, "stiffness_N_per_m": 2.849e8,
        },
        "operation": {
            "inner_ring_and_shaft_kg": 2.9256, "speed_rpm": 5963.9, "radial_load_N": 434.8, "rotating_load_N": 196.3,
            "shaft": "springs", "shaft_stiffness_N_per_m": 6.218e6, "shaft_damping_N_s_m": 15.74,
        },
        "support": {
            "kind": "housing", "mass_kg": 3.58, "stiffness_N_per_m": 3.172e7, "damping_N_s_m": 240.7,
        },
        "numerics": {"duration_ms": 5.0, "output_interval_us": 2.0},
    }  # fmt: skip
    scene = parse_scene(tables, "")
    plan = make_plan(scene)
    state = plan.first_state()
    run(plan, lambda block: None, state=state)
    budgets = [direction.budget for direction in simulate(scene).residual().directions]
    missed = np.hypot(*(budget.terms["ring_flexibility"] for budget in budgets)).max()
    most = float(state.forces.beyond[0])
    assert 0.5 * most < missed < most * (1.0 + 1e-2)

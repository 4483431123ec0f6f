"""Steps of two lengths on spalled bearings of rigid bodies, against short ones throughout."""

from dataclasses import replace

import numpy as np
import pytest

from fem.kernels.rigid.paces import FAR, NEAR
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.scene.scene import parse_scene

DAMPED = {"contact_time_us": 12.5}
SPALL = {"body": "outer_ring", "width_mm": 1.2}
NU206 = {
    "model": "reduced",
    "bearing": {"designation": "NU206", "clearance_um": 15.0},
    "operation": {"speed_rpm": 2900.0, "radial_load_N": 3000.0, "inner_ring_and_shaft_kg": 3.0},
    "damping": DAMPED,
    "cage": {"kind": "none"},
    "spall": [SPALL],
    "numerics": {"duration_ms": 30.0, "output_interval_us": 5.0},
}
AROUND = {
    "cage": {"mass_kg": 0.02, "guidance": "inner_ring", "guidance_clearance_mm": 0.3, "drag_torque_N_m": 0.001},
    "support": {"kind": "housing", "mass_kg": 12.0, "stiffness_N_per_m": 1.5e7, "damping_N_s_m": 2200.0},
    "sensor": {"frequency_Hz": 15000.0, "damping_ratio": 0.05},
    "operation": NU206["operation"]
    | {"shaft": "springs", "shaft_stiffness_N_per_m": 1e7, "shaft_damping_N_s_m": 50.0, "unbalance_g_mm": 50.0},
    "waviness": [{"body": "inner_ring", "order": 12, "amplitude_um": 0.2}],
}


def plan_of(**tables):
    return make_plan(parse_scene(NU206 | tables, "test"))


def short_throughout(plan):
    return replace(plan, sections=None)


def ran(plan):
    """The state at the end, and the samples."""
    state, blocks = plan.first_state(), []
    run(plan, blocks.append, state=state, restart=lambda reason: pytest.fail(reason))
    return state, Samples.joined(blocks)


def error(state):
    """The largest energy error over the energy exchanged."""
    return state.missed[0] / state.passed_on[0]


def off(found, wanted):
    """Root mean square of a difference, over that of what is wanted about its mean."""
    return np.sqrt(np.mean((found - wanted) ** 2) / np.mean((wanted - wanted.mean(axis=0)) ** 2))


@pytest.mark.parametrize(("model", "body"), [
    ("reduced", "outer_ring"), ("reduced", "inner_ring"),
    pytest.param("lagrange", "outer_ring", marks=pytest.mark.slow),
])  # fmt: skip
def test_strikes_are_those_of_short_steps_throughout(model, body):
    """Differences are those of short steps from half as long ones, 1e-3, or less; energy errs no more."""
    plan = plan_of(model=model, spall=[SPALL | {"body": body}])
    (state, found), (other, wanted) = ran(plan), ran(short_throughout(plan))
    assert state.paces.made[FAR] * plan.long_step > 0.6 * found["time"][-1]
    assert state.progress.steps < 0.45 * other.progress.steps
    assert error(state) < 2.0 * error(other) < 1e-4
    for name in ("inner_force", "outer_force", "inner_y", "inner_vy"):
        assert off(found[name], wanted[name]) < 2e-3
    np.testing.assert_array_equal(found["outer_force"].argmax(axis=0), wanted["outer_force"].argmax(axis=0))
    assert found["work_damping_contact"][-1] == pytest.approx(wanted["work_damping_contact"][-1], rel=1e-4)
    assert found["work_external"][-1] == pytest.approx(wanted["work_external"][-1], rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_all_around_a_bearing_changes_its_steps_with_it(model):
    """Cage, shaft, housing, sensor, unbalance, waves between the spalls; later the cage's hits part the paths."""
    free = {"angles": "free"} if model == "lagrange" else {}
    plan = plan_of(model=model, lagrange=free, **AROUND, numerics=NU206["numerics"] | {"duration_ms": 8.0})
    (state, found), (other, wanted) = ran(plan), ran(short_throughout(plan))
    assert state.paces.made.min() > 0
    assert not state.paces.smooth
    assert error(state) < 1e-4 and error(other) < 1e-4
    for name in ("inner_force", "outer_force", "inner_y", "housing_y", "sensor_ay"):
        assert off(found[name], wanted[name]) < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_rollers_that_tilt_change_their_steps_alike(model):
    """Over a spall of half the length, the hub's slope free."""
    axial = {"slices": 12, "roller_profile": "logarithmic", "hub_tilt_inertia_kg_m2": 1e-3}
    axial["shaft_tilt_stiffness_N_m_rad"] = 2e4
    plan = plan_of(
        model=model, axial=axial, operation=NU206["operation"] | {"misalignment_mrad": 1.0},
        spall=[SPALL | {"length_mm": 4.5, "z_mm": 2.25}], numerics=NU206["numerics"] | {"duration_ms": 20.0},
    )  # fmt: skip
    (state, found), (other, wanted) = ran(plan), ran(short_throughout(plan))
    assert state.progress.steps < 0.45 * other.progress.steps
    assert error(state) < 1e-4 and error(other) < 1e-4
    for name in ("inner_force", "inner_vy", "inner_moment", "roller_tilt", "inner_slope_y"):
        assert off(found[name], wanted[name]) < 2e-3, name


@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_a_run_cut_anywhere_makes_the_same_bits(model):
    """Within a strike too, and where steps have just become longer."""
    plan = plan_of(model=model, numerics=NU206["numerics"] | {"duration_ms": 6.0})
    whole, cut = plan.first_state(), plan.first_state()
    wanted, found, paces = whole.advance(plan.n_samples).samples, [], []
    while cut.done < plan.n_samples:
        found.append(cut.advance(min(17 + cut.done % 5, plan.n_samples - cut.done)).samples)
        paces.append(int(cut.paces.now[0]))
        kept, done = cut.to_keep(), cut.done
        kept = {name: array.copy() for name, array in kept[0].items()}, kept[1]
        cut = plan.first_state()
        cut.done = done
        cut.take_back(*kept)
    assert NEAR in paces and FAR in paces
    for name in wanted.keys():
        np.testing.assert_array_equal(np.concatenate([samples[name] for samples in found]), wanted[name])
    assert cut.progress.steps == whole.progress.steps


@pytest.mark.slow
def test_a_roller_that_rolls_over_its_own_spall_and_many_at_once():
    spalls = [SPALL, {"body": "roller", "roller": 3, "width_mm": 0.8}, {"body": "inner_ring", "width_mm": 1.0}]
    plan = plan_of(spall=spalls, numerics=NU206["numerics"] | {"duration_ms": 10.0})
    (state, found), (_, wanted) = ran(plan), ran(short_throughout(plan))
    assert state.paces.made.min() > 0
    assert error(state) < 2e-4
    assert off(found["inner_force"], wanted["inner_force"]) < 1e-2


def test_where_nothing_would_be_won_steps_are_of_one_length():
    """Undamped contacts vibrate on; where spalls are everywhere, so are short steps."""
    plan = plan_of()
    assert 4.0 < plan.long_step / plan.time_step < 5.0
    assert plan.steps < 0.5 * plan.stride * (plan.n_samples - 1)
    assert "near edges" in plan.rows()["time step"] and "about" in plan.rows()["steps"]
    assert plan_of(damping={}).sections is None
    assert plan_of(spall=[]).sections is None
    many = [SPALL | {"angle_deg": 360.0 / 50.0 * k} for k in range(50)]
    assert plan_of(spall=many).sections is None


def test_a_run_that_restarts_halves_both_lengths():
    plan = plan_of()
    state = plan.first_state()
    state.restarts["halvings"] = 5
    state._begin()
    assert state.plan.time_step == pytest.approx(plan.time_step / 32)
    assert state.plan.long_step == pytest.approx(plan.long_step / 32)
    assert state.drives[FAR].dt == pytest.approx(plan.long_step / 32)
    found = state.advance(3).samples
    np.testing.assert_allclose(np.diff(found["time"]), 5e-6)
    more = replace(plan.sections, count=3, near=34)  # than a hundred steps between two looks at the energy
    assert replace(plan, sections=more, stride=102 * plan.looks).halved(0).sections == more

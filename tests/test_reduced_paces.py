"""Steps of two lengths on spalled bearings of rigid bodies, against short ones; energy errors of long runs."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fem.commands.run_fem import run_main
from fem.kernels.rigid.paces import FAR, NEAR
from fem.solver.guards import IMBALANCE_LIMIT, EnergyAccount, n_balanced
from fem.solver.rigid import state as rigid_state
from fem.solver.rigid.state import LIMIT, ReducedState
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.scene.scene import parse_scene

SPALL = {"body": "outer_ring", "width_mm": 1.2}
NU206 = {
    "model": "reduced", "bearing": {"designation": "NU206", "clearance_um": 15.0}, "cage": {"kind": "none"},
    "operation": {"speed_rpm": 2900.0, "radial_load_N": 3000.0, "inner_ring_and_shaft_kg": 3.0},
    "damping": {"contact_time_us": 12.5}, "spall": [SPALL],
    "numerics": {"duration_ms": 30.0, "output_interval_us": 5.0},
}  # fmt: skip
RIGID = pytest.mark.parametrize("model", ["reduced", "lagrange"])


def plan_of(duration=30.0, **tables):
    numerics = NU206["numerics"] | {"duration_ms": duration}
    return make_plan(parse_scene(NU206 | {"numerics": numerics} | tables, "test"))


def ran(plan):
    """The state at the end, and the samples."""
    state, blocks = plan.first_state(), []
    run(plan, blocks.append, state=state, restart=lambda reason: pytest.fail(reason))
    return state, Samples.joined(blocks)


def beside_short_steps(plan):
    """States and samples of a plan and of one with short steps throughout."""
    return *ran(plan), *ran(replace(plan, sections=None))


def error(state):
    """The largest energy error over the energy exchanged."""
    return state.missed[0] / state.passed_on[0]


def assert_near(found, wanted, limit, *names):
    """Root mean square of a difference, over that of what is wanted about its mean."""
    for a, b in ((found[name], wanted[name]) for name in names):
        assert np.sqrt(np.mean((a - b) ** 2) / np.mean((b - b.mean(axis=0)) ** 2)) < limit, names


@pytest.mark.parametrize(("model", "body"), [
    ("reduced", "outer_ring"), ("reduced", "inner_ring"),
    pytest.param("lagrange", "outer_ring", marks=pytest.mark.slow),
])  # fmt: skip
def test_strikes_are_those_of_short_steps_throughout(model, body):
    """Differences are those of short steps from half as long ones, 1e-3, or less; energy errs no more."""
    plan = plan_of(model=model, spall=[SPALL | {"body": body}])
    state, found, other, wanted = beside_short_steps(plan)
    assert state.paces.made[FAR] * plan.long_step > 0.6 * found["time"][-1]
    assert state.progress.steps < 0.45 * other.progress.steps
    assert error(state) < 2.0 * error(other) < 1e-4
    assert_near(found, wanted, 2e-3, "inner_force", "outer_force", "inner_y", "inner_vy")
    assert_array_equal(found["outer_force"].argmax(axis=0), wanted["outer_force"].argmax(axis=0))
    for name in ("work_damping_contact", "work_external"):
        assert found[name][-1] == pytest.approx(wanted[name][-1], rel=1e-4)


@pytest.mark.slow
@RIGID
def test_all_around_a_bearing_changes_its_steps_with_it(model):
    """Cage, shaft, housing, sensor, unbalance, waves between the spalls; later the cage parts paths of any steps."""
    state, found, other, wanted = beside_short_steps(plan_of(
        3.0, model=model, lagrange={"angles": "free"} if model == "lagrange" else {},
        cage={"mass_kg": 0.02, "guidance": "inner_ring", "guidance_clearance_mm": 0.3, "drag_torque_N_m": 0.001},
        support={"kind": "housing", "mass_kg": 12.0, "stiffness_N_per_m": 1.5e7, "damping_N_s_m": 2200.0},
        sensor={"frequency_Hz": 15000.0, "damping_ratio": 0.05}, operation=NU206["operation"] | {
            "shaft": "springs", "shaft_stiffness_N_per_m": 1e7, "shaft_damping_N_s_m": 50.0, "unbalance_g_mm": 50.0,
        }, waviness=[{"body": "inner_ring", "order": 12, "amplitude_um": 0.2}],
    ))  # fmt: skip
    assert state.paces.made.min() > 0 and not state.paces.smooth
    assert error(state) < 1e-4 and error(other) < 1e-4
    # measured 6e-4; steps half as long as the short ones differ from these by 2e-3, and by 4e-2 after 4 ms
    assert_near(found, wanted, 5e-3, "inner_force", "outer_force", "inner_y", "housing_y", "sensor_ay")


@pytest.mark.slow
@RIGID
def test_rollers_that_tilt_change_their_steps_alike(model):
    """Over a spall of half the length, the hub's slope free."""
    axial = {"slices": 12, "roller_profile": "logarithmic", "hub_tilt_inertia_kg_m2": 1e-3}
    axial["shaft_tilt_stiffness_N_m_rad"] = 2e4
    state, found, other, wanted = beside_short_steps(plan_of(
        20.0, model=model, axial=axial, operation=NU206["operation"] | {"misalignment_mrad": 1.0},
        spall=[SPALL | {"length_mm": 4.5, "z_mm": 2.25}],
    ))  # fmt: skip
    assert state.progress.steps < 0.45 * other.progress.steps
    assert error(state) < 1e-4 and error(other) < 1e-4
    assert_near(found, wanted, 2e-3, "inner_force", "inner_vy", "inner_moment", "roller_tilt", "inner_slope_y")


@RIGID
def test_a_run_cut_anywhere_makes_the_same_bits(model):
    """Within a strike too, and where steps have just become longer."""
    plan = plan_of(6.0, model=model)
    whole, cut = plan.first_state(), plan.first_state()
    wanted, found, paces = whole.advance(plan.n_samples).samples, [], []
    while cut.done < plan.n_samples:
        found.append(cut.advance(min(17 + cut.done % 5, plan.n_samples - cut.done)).samples)
        paces.append(int(cut.paces.now[0]))
        (arrays, numbers), done = cut.to_keep(), cut.done
        arrays, cut = {name: array.copy() for name, array in arrays.items()}, plan.first_state()
        cut.done = done
        cut.take_back(arrays, numbers)
    assert NEAR in paces and FAR in paces
    for name in wanted.keys():
        assert_array_equal(np.concatenate([samples[name] for samples in found]), wanted[name])
    assert cut.progress.steps == whole.progress.steps


@pytest.mark.slow
def test_a_roller_that_rolls_over_its_own_spall_and_many_at_once():
    spalls = [SPALL, {"body": "roller", "roller": 3, "width_mm": 0.8}, {"body": "inner_ring", "width_mm": 1.0}]
    state, found, _, wanted = beside_short_steps(plan_of(10.0, spall=spalls))
    assert state.paces.made.min() > 0 and error(state) < 2e-4
    assert_near(found, wanted, 1e-2, "inner_force")


def test_where_nothing_would_be_won_steps_are_of_one_length():
    """Undamped contacts vibrate on; where spalls are everywhere, so are short steps."""
    plan = plan_of()
    assert 4.0 < plan.long_step / plan.time_step < 5.0 and plan.steps < 0.5 * plan.stride * (plan.n_samples - 1)
    assert "near edges" in plan.rows()["time step"] and "about" in plan.rows()["steps"]
    many = [SPALL | {"angle_deg": 360.0 / 50.0 * k} for k in range(50)]
    for tables in ({"damping": {}}, {"spall": []}, {"spall": many}):
        assert plan_of(**tables).sections is None


def test_a_run_that_restarts_halves_both_lengths():
    plan = plan_of()
    state = plan.first_state()
    state.restarts["halvings"] = 5
    state.begin()
    assert state.plan.time_step == pytest.approx(plan.time_step / 32)
    assert (state.plan.long_step, state.drives[FAR].dt) == pytest.approx((plan.long_step / 32, plan.long_step / 32))
    assert_allclose(np.diff(state.advance(3).samples["time"]), 5e-6)
    more = replace(plan.sections, count=3, near=34)  # than a hundred steps between two looks at the energy
    assert replace(plan, sections=more, stride=102 * plan.looks).halved(0).sections == more


# Energy errors of long runs: what accumulates is judged by what accumulates, and a late fault as an early one.

EXCHANGED = 0.02  # J
PER_SAMPLE = 0.01  # of it, dissipated


def samples(imbalance: np.ndarray, account: EnergyAccount | None = None, first: int = 0, per_sample=PER_SAMPLE):
    """Samples of a steady run that dissipates so much of the exchanged energy in each."""
    n = len(imbalance)
    values = {"energy_kinetic": np.full(n, 1.0), "energy_elastic": np.full(n, EXCHANGED), "energy_contact": np.zeros(n)}
    values["work_dissipated"] = EXCHANGED * per_sample * np.arange(first, first + n)
    return (account or EnergyAccount()).samples(values, imbalance, np.full(n, EXCHANGED))


def missed(share: float, n: int = 200_000) -> np.ndarray:
    """The imbalance of a run that misses a share of what it dissipates."""
    return share * EXCHANGED * PER_SAMPLE * np.arange(n)


def test_a_steady_error_is_the_share_of_the_dissipated_energy_however_long_the_run():
    """1.9e-5 of 2000 times the exchanged energy: 3.8 % of that, and 1.9e-5 of what it is all the while."""
    found = samples(missed(1.9e-5))
    assert found.imbalance[-1] > 0.03 * EXCHANGED
    assert_allclose(found.error[1000:], 1.9e-5 * EXCHANGED, rtol=0.006)  # half of PER_SAMPLE
    assert n_balanced(samples(missed(1e-4))) == 200_000  # the imbalance is 20 % of the exchanged energy
    imbalance = np.linspace(0.0, 0.1, 1001) * EXCHANGED  # without dissipation it is the imbalance
    found = samples(imbalance, per_sample=0.0)
    assert_allclose(found.error, imbalance, rtol=1e-12)
    assert n_balanced(found) == pytest.approx(501, abs=1)


def test_a_run_that_misses_much_or_gains_energy_from_nowhere_is_stopped_early_or_late():
    wrong, late, sudden = 2.0 * IMBALANCE_LIMIT, missed(1e-4), missed(1e-5)
    early = n_balanced(samples(missed(wrong)))
    assert early == pytest.approx(np.log(2.0) / PER_SAMPLE, abs=2.0)  # 1 − exp(−D/E) of the share: half
    late[150_000:] += missed(wrong, 50_000)
    assert n_balanced(samples(late)) - 150_000 == pytest.approx(early, abs=2.0)
    sudden[150_000:] += 1.1 * IMBALANCE_LIMIT * EXCHANGED  # 4e-5 of all that was dissipated
    assert n_balanced(samples(sudden)) == 150_000


def test_the_cut_into_blocks_changes_no_bit():
    imbalance = np.random.default_rng(0).normal(0.0, 1e-3 * EXCHANGED, 1000).cumsum()
    whole, account, parts = samples(imbalance), EnergyAccount(), []
    for first, last in ((0, 1), (1, 400), (400, 1000)):
        parts.append(samples(imbalance[first:last], account, first).error)
        account, kept = EnergyAccount(), account.sums  # as of a checkpoint
        account.sums[:] = kept
    assert_array_equal(np.concatenate(parts), whole.error)


@pytest.mark.parametrize(("share", "is_lost"), [(0.5 * LIMIT, False), (2.0 * LIMIT, True)])
def test_steps_are_halved_for_what_is_missed_of_the_dissipated_energy(share, is_lost):
    plan = make_plan(parse_scene({"model": "reduced", "numerics": {"duration_ms": 200.0}}, "scene"))
    state = ReducedState(plan)
    state.done = plan.n_samples
    assert state._loses_energy(samples(missed(share, plan.n_samples))) is is_lost


@pytest.mark.slow  # compiles a loop
def test_a_run_that_dissipates_fifty_times_what_it_exchanges_needs_no_shorter_steps(tmp_path, capsys, monkeypatch):
    """Its imbalance comes to 5e-6 of the exchanged energy and more, its energy error stays at 1e-6."""
    monkeypatch.setattr(rigid_state, "LIMIT", 3e-6)
    scene = tmp_path / "drag.toml"
    scene.write_text(
        'model = "reduced"\n[bearing]\ndesignation = "NU206"\nclearance_um = 20.0\n'
        "[operation]\nspeed_rpm = 9000.0\nradial_load_N = 1500.0\n[cage]\ndrag_torque_N_m = 0.3\n"
        '[[spall]]\nbody = "outer_ring"\nwidth_mm = 0.5\n[numerics]\nduration_ms = 40.0\noutput_interval_us = 20.0\n'
    )
    assert run_main([str(scene), "--output", str(tmp_path / "drag.nc")]) == 0
    told = capsys.readouterr()
    assert "restarts" not in told.out + told.err and "40 ms in" in told.out

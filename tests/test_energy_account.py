"""Energy errors of long runs: what accumulates is judged by what accumulates, and a late fault as an early one."""

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.solver.guards import IMBALANCE_LIMIT, EnergyAccount, n_balanced
from fem.solver.rigid import state as rigid_state
from fem.solver.rigid.state import LIMIT, ReducedState
from fem.solver.simulate import make_plan
from lagrange.scene.scene import parse_scene

EXCHANGED = 0.02  # J
PER_SAMPLE = 0.01  # of it, dissipated


def samples(imbalance: np.ndarray, account: EnergyAccount | None = None, first: int = 0, per_sample=PER_SAMPLE):
    """Samples of a steady run that dissipates so much of the exchanged energy in each."""
    n = len(imbalance)
    values = {
        "work_dissipated": EXCHANGED * per_sample * np.arange(first, first + n),
        "energy_kinetic": np.full(n, 1.0),
        "energy_elastic": np.full(n, EXCHANGED),
        "energy_contact": np.zeros(n),
    }
    return (account or EnergyAccount()).samples(values, imbalance, np.full(n, EXCHANGED))


def missed(share: float, n: int = 200_000) -> np.ndarray:
    """The imbalance of a run that misses a share of what it dissipates."""
    return share * EXCHANGED * PER_SAMPLE * np.arange(n)


def test_a_steady_error_is_the_share_of_the_dissipated_energy_however_long_the_run():
    """1.9e-5 of 2000 times the exchanged energy: 3.8 % of that, and 1.9e-5 of what it is all the while."""
    found = samples(missed(1.9e-5))
    assert found.imbalance[-1] > 0.03 * EXCHANGED
    np.testing.assert_allclose(found.error[1000:], 1.9e-5 * EXCHANGED, rtol=0.006)  # half of PER_SAMPLE
    assert n_balanced(samples(missed(1e-4))) == 200_000  # the imbalance is 20 % of the exchanged energy


def test_a_run_that_misses_much_of_what_it_dissipates_is_stopped_early_or_late():
    wrong = 2.0 * IMBALANCE_LIMIT
    early = n_balanced(samples(missed(wrong)))
    late = missed(1e-4)
    late[150_000:] += missed(wrong, 50_000)
    assert early == pytest.approx(np.log(2.0) / PER_SAMPLE, abs=2.0)  # 1 − exp(−D/E) of the share: half
    assert n_balanced(samples(late)) - 150_000 == pytest.approx(early, abs=2.0)


def test_energy_that_comes_from_nowhere_late_in_a_run_stops_it_at_once():
    imbalance = missed(1e-5)
    imbalance[150_000:] += 1.1 * IMBALANCE_LIMIT * EXCHANGED  # 4e-5 of all that was dissipated
    assert n_balanced(samples(imbalance)) == 150_000


def test_without_dissipation_an_error_is_the_imbalance():
    imbalance = np.linspace(0.0, 0.1, 1001) * EXCHANGED
    found = samples(imbalance, per_sample=0.0)
    np.testing.assert_allclose(found.error, imbalance, rtol=1e-12)
    assert n_balanced(found) == pytest.approx(501, abs=1)


def test_the_cut_into_blocks_changes_no_bit():
    imbalance = np.random.default_rng(0).normal(0.0, 1e-3 * EXCHANGED, 1000).cumsum()
    whole, account, parts = samples(imbalance), EnergyAccount(), []
    for first, last in ((0, 1), (1, 400), (400, 1000)):
        parts.append(samples(imbalance[first:last], account, first).error)
        account, kept = EnergyAccount(), account.sums  # as of a checkpoint
        account.sums[:] = kept
    np.testing.assert_array_equal(np.concatenate(parts), whole.error)


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

"""The reduced model with elastic waves: statics untouched, energy with that of the modes, going on bit for bit."""

import dataclasses

import numpy as np
import pytest

from fem.errors import UsageError
from fem.statics.exact_statics import exact_contacts, exact_statics
from tests.reference.reduced_runs import CLEARANCE, STILL, plan_of, samples_of

MODES = ("reduced.modes_up_to_kHz=300",)


def test_modes_change_no_static_force_nor_the_hubs_place():
    still = (*STILL, "operation.gravity_m_s2=0")
    plain, vibrating = (plan_of(*settings, *still) for settings in ((), MODES))
    np.testing.assert_array_equal(vibrating.start.hub, plain.start.hub)
    start = vibrating.start
    compliance = exact_contacts(plain.model.bearing, start.angle).compliance
    n, model = plain.model.bearing.n_rollers, vibrating.model
    modes = model.modes
    # what laws and couplings have left and what modes carry are the whole bodies' series
    assert model.across + modes.across == pytest.approx(compliance[0, n], rel=1e-12)
    for row, (law, ring) in enumerate(((model.inner_law, modes.inner), (model.outer_law, modes.outer))):
        whole = (plain.model.inner_law, plain.model.outer_law)[row]
        assert law.approach(500.0) + 500.0 * modes.own(ring) == pytest.approx(whole.approach(500.0), rel=1e-12)
        step = 2.0 * np.pi / n
        along = model.rings.along[row, list(model.rings.distance).index(1)] + ring.compliance(np.array(step))
        assert along == pytest.approx(compliance[row * n, row * n + 1], rel=1e-12)


def test_a_frequency_below_all_modes_is_the_model_without_and_too_many_modes_are_refused():
    assert plan_of("reduced.modes_up_to_kHz=100").model.modes is None
    with pytest.raises(UsageError, match="modes_up_to_kHz = 4000"):
        plan_of("reduced.modes_up_to_kHz=4000")


def test_modes_found_for_the_first_time_are_laid_out_as_kept_ones_are(tmp_path, monkeypatch):
    """The time loop is compiled for contiguous arrays; of a body with one mode any layout is."""
    monkeypatch.setattr("meshes.cache.cache_folder", lambda: tmp_path / "meshes")
    for up_to in (170, 300):
        bodies = plan_of(f"reduced.modes_up_to_kHz={up_to}").first_state().bodies
        for modes in (bodies.vibrations.roller, bodies.vibrations.inner, bodies.vibrations.outer):
            assert all(array.flags.c_contiguous for array in modes if isinstance(array, np.ndarray)), up_to


@pytest.mark.slow  # the loop with modes is a variant of its own
def test_a_bearing_with_modes_rests_in_the_exact_equilibrium():
    plan = plan_of(*MODES, *STILL, "operation.gravity_m_s2=0")
    exact = exact_statics(plan.model.bearing, plan.operation.radial_load, plan.operation.first_roller_angle)
    found = samples_of(
        dataclasses.replace(plan, stride=1), count=3
    )  # as without modes: rollers without friction set off
    assert np.abs(found["inner_y"] - exact.hub[1]).max() < 1e-5 * abs(exact.hub[1])
    assert np.abs(found["inner_force"] - exact.inner_force).max() < 1e-5 * plan.operation.radial_load


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "limit"),
    [((), 1e-6), (("numerics.start=rest", "numerics.load_ramp_ms=0.05"), 1e-4),
     ((*CLEARANCE, "numerics.start=rest", "numerics.load_ramp_ms=0"), 1e-3)],
)  # fmt: skip
def test_energy_balances_with_that_of_the_modes(settings, limit):
    found = samples_of(plan_of(*MODES, *settings, "numerics.duration_ms=20"))
    assert np.abs(found["imbalance"]).max() < limit * found["exchanged"][-1]
    if "numerics.load_ramp_ms=0" in settings:  # they hold a share of it that would be missed
        assert found["energy_elastic"][1000:].mean() > 20.0 * limit * found["exchanged"][-1]


@pytest.mark.slow
def test_a_run_with_modes_goes_on_bit_for_bit_and_damaged_amplitudes_are_refused():
    plan = plan_of(*MODES, "numerics.duration_ms=2", "numerics.start=rest")
    whole = samples_of(plan)
    first, second = plan.first_state(), plan.first_state()
    first.reader.read(first.take_steps(100 * plan.looks)[0])
    first.done = 100
    arrays, numbers = first.to_keep()
    arrays, second.done = {name: array.copy() for name, array in arrays.items()}, 100
    second.take_back(arrays, numbers)
    rest = second.reader.read(second.take_steps((plan.n_samples - 100) * plan.looks)[0])
    np.testing.assert_array_equal(rest["inner_x"], whole["inner_x"][100:])
    np.testing.assert_array_equal(rest["energy_elastic"], whole["energy_elastic"][100:])
    arrays["inner.amplitude"][0, 0] = 1.0
    with pytest.raises(ValueError, match="inner: vibrations beyond all bounds"):
        plan.first_state().take_back(arrays, numbers)

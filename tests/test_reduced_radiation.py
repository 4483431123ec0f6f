"""What strikes give to waves in the reduced model: exact impacts of a disc, balances of a bearing that rattles."""

from types import SimpleNamespace

import numpy as np
import pytest

from fem.elastic.continuum import Section
from fem.elastic.vibration import inertia
from fem.kernels.rigid.strikes import given
from tests.reference.bearings import LENGTH, STEEL, paper
from tests.reference.disc_impact import thrown_at_flat
from tests.reference.reduced_runs import CLEARANCE, plan_of

RATTLING = (*CLEARANCE, "numerics.start=rest", "numerics.load_ramp_ms=0", "numerics.duration_ms=4")


def test_strikes_give_to_waves_what_an_exact_disc_loses_on_a_flat():
    """Closing and opening together, as a mean over speeds.

    Which waves are in step with the end of a strike depends on how long it takes: single speeds differ by up to 50 %.
    The flat's law is Johnson's, δ = F/(π L E') (2 ln 4R/b − 1), b² = 4 F R/(π L E').
    """
    radius, mass, modulus = 0.005, paper().roller_mass, STEEL.plane_strain_modulus
    whole, slowest = inertia(Section(radius, 0.0, STEEL), LENGTH)
    unit = 1.0 / (np.pi * LENGTH * modulus)
    law = SimpleNamespace(A=2.0 * unit, B=0.5 * (np.log(16.0 * radius**2 / (4.0 * unit * radius)) - 1.0))
    speeds = np.geomspace(0.02, 2.0, 9)
    exact = [1.0 - thrown_at_flat(float(speed), radius, LENGTH, STEEL).rebound ** 2 for speed in speeds]
    found = [2.0 * given(law, whole, 1.0 / slowest, mass, speed) / (0.5 * mass * speed**2) for speed in speeds]
    assert np.mean(found) == pytest.approx(np.mean(exact), rel=0.15)  # measured 3 %
    assert 0.004 < min(exact) < max(exact) < 0.025  # and nearly nothing else is lost


def rattled(stop: int | None = None):
    """State of a rattling run, its energies and forces; `stop`: after so many samples it goes on in another state."""
    plan = plan_of(*RATTLING, "numerics.time_step_safety=0.45")
    state, found = plan.first_state(), []
    for count in [plan.n_samples] if stop is None else [stop, plan.n_samples - stop]:
        if found:
            arrays, numbers = state.to_keep()
            arrays, state = {name: array.copy() for name, array in arrays.items()}, plan.first_state()
            state.done = stop
            state.take_back(arrays, numbers)
        found.append(state.reader.read(state.take_steps(count * plan.looks)[0]))
        state.done += count
    return plan, state, found


def test_a_bearing_that_rattles_loses_to_waves_what_its_balance_says():
    plan, state, (samples,) = rattled()
    exchanged = samples.exchanged[-1]
    assert np.abs(samples.imbalance).max() < 1e-3 * exchanged
    given_to_waves = float(state.forces.radiation.work.sum())
    assert given_to_waves > 0.01 * exchanged
    assert given_to_waves < samples["work_dissipated"][-1]
    # what sample's forces lack of the hub's momentum is known: kicks of strikes that keep the energy
    angle, x, y = (samples[name] for name in ("roller_theta", "inner_x", "inner_y"))
    rho = samples["roller_rho"]
    away = np.stack([rho * np.cos(angle) - x[:, None], rho * np.sin(angle) - y[:, None]])
    normal = away / np.hypot(*away)
    operation = plan.operation
    along = np.stack([-normal[1], normal[0]])
    force = -samples["inner_force"] * normal - samples["inner_traction"] * along
    missing = np.stack([samples["inner_ax"], samples["inner_ay"]]) * operation.inner_mass - force.sum(axis=2)
    missing[1] += operation.radial_load + operation.inner_mass * operation.gravity
    assert np.hypot(*missing).max() < 1.01 * float(state.forces.beyond[0]) + 1e-6


def test_a_run_goes_on_bit_for_bit_with_what_contacts_owe():
    _, _, (whole,) = rattled()
    _, state, (_, rest) = rattled(stop=200)
    assert state.forces.radiation.owed.max() > 0.0
    np.testing.assert_array_equal(rest["inner_y"], whole["inner_y"][200:])
    np.testing.assert_array_equal(rest["work_dissipated"], whole["work_dissipated"][200:])


def test_contacts_that_waves_owe_energy_are_refused():
    plan = plan_of(*RATTLING)
    arrays, numbers = plan.first_state().to_keep()
    arrays = {name: array.copy() for name, array in arrays.items()}
    arrays["forces.radiation.owed"][0, 3] = -1e-6
    with pytest.raises(ValueError, match="negative energy loss to waves"):
        plan.first_state().take_back(arrays, numbers)

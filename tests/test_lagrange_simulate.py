"""Forward solution by scipy: balances, statics it settles on, its own residual, impacts; what it refuses."""

from dataclasses import replace
from math import atan2, exp, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lagrange.bearing import Cage, Operation
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws
from lagrange.equations import approaches, contact_resultant, error_forces
from lagrange.first_state import Problem
from lagrange.mounting import Housing, Mounting, Shaft
from lagrange.statics import static_equilibrium
from tests.reference import forward_motion
from tests.reference.forward_motion import simulate
from tests.reference.ideal import DGBB_209, DOWN, HARRIS, PAPER, PRELOADED, RUNNING, spall, wavy

ENERGY = 1e-8  # of the elastic energy
MOUNTED = replace(
    RUNNING,
    mounting=Mounting(
        housing=Housing(mass=0.5, stiffness=2e8, damping=4000.0), shaft=Shaft(stiffness=1e8, damping=300.0)
    ),
)


def own_errors(run, ax, ay):
    """Error forces (22), (23) of a run's positions with accelerations, N."""
    state = approaches(run.bearing, run.inner_x, run.inner_y, run.roller_x, run.roller_y)
    resultant = contact_resultant(state, run.laws.inner.force(state.inner))
    return np.array(error_forces(run.operation, ax, ay, *resultant))


@pytest.mark.parametrize("angles", ["kinematic", "free"])
@pytest.mark.parametrize(
    ("operation", "choices", "faults"),
    [
        (RUNNING, {}, ()),
        (RUNNING, {"start": "rest", "load_ramp": 3e-4}, ()),
        (RUNNING, {"start": "rest", "damping": ContactDamping(constant=100.0)}, ()),
        (MOUNTED, {"start": "rest", "load_ramp": 2e-4, "damping": ContactDamping(hunt_crossley=1.0)}, ()),
        (MOUNTED, {}, wavy()),
        (RUNNING, {}, (spall("outer_ring", DOWN + 0.02),)),
    ],
)
def test_the_work_of_every_force_is_in_the_balance(operation, choices, faults, angles):
    """Load, weight, held angles, a drive over slopes, dampers and dashpots; contacts rattle and a roller is struck."""
    duration = 2.5e-4 if operation is RUNNING and faults else 4e-4
    run = simulate(Problem(replace(PAPER, faults=faults), operation, HARRIS, angles=angles, **choices), duration, 1e-5)
    exchanged = max(np.ptp(run.energy_contact), np.ptp(run.work_external))
    assert np.abs(run.energy_error).max() < (1e-4 if faults else 1e-6) * exchanged  # splines have jumps of third order
    assert np.all(np.diff(run.work_dissipated) >= 0.0) and np.all(np.diff(run.work_damping) >= 0.0)
    if operation is MOUNTED or "damping" in choices:
        assert run.work_dissipated[-1] > 1e-10
    if angles == "kinematic":  # a wrong account of what holds the angles would show
        assert np.ptp(run.work_cage) > 1e-3 * exchanged


@pytest.mark.parametrize(
    ("bearing", "operation", "law", "largest"),
    [
        (PAPER, RUNNING, "harris", 630.8),
        (PAPER, RUNNING, "johnson", 635.1),
        (DGBB_209, replace(RUNNING, radial_load=8900.0, inner_mass=0.5), "hertz", 4530.0),
    ],
)
def test_energy_is_kept_while_elements_pass_through_the_load_zone(bearing, operation, law, largest):
    run = simulate(Problem(bearing, operation, contact_laws(law, bearing)), 1e-3, 1e-5)
    assert np.max(np.abs(run.energy_error)) < ENERGY * run.energy_contact.mean()
    assert run.inner_force.max() == pytest.approx(largest, rel=0.02)


def test_own_residual_is_round_off_with_own_accelerations():
    run = simulate(Problem(PAPER, RUNNING, HARRIS), 5e-4, 1e-5)
    assert np.max(np.abs(own_errors(run, run.inner_ax, run.inner_ay))) < 1e-7  # 3e-18 m of 0.5 GN/m


def test_accelerations_are_those_of_the_path():
    """Second differences of eighth order; 13.2 kHz and 54 kHz, where no contact opens or closes."""
    weights = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
    run = simulate(Problem(PRELOADED, RUNNING, contact_laws("harris", PRELOADED), start="rest"), 2e-4, 2e-6)
    assert run.inner_force.min() > 0.0
    for place, acceleration in ((run.inner_x, run.inner_ax), (run.inner_y, run.inner_ay)):
        found = np.convolve(place, weights, mode="valid") / 4e-12
        np.testing.assert_allclose(found, acceleration[4:-4], atol=1e-4 * np.abs(run.inner_ay).max())


@pytest.mark.slow
def test_a_tighter_tolerance_and_a_shorter_step_change_as_little_as_said(monkeypatch):
    choices = {"start": "rest", "load_ramp": 2e-4}
    run = simulate(Problem(PAPER, RUNNING, HARRIS, **choices), 4e-4, 1e-5)
    shorter = simulate(Problem(PAPER, RUNNING, HARRIS, **choices), 4e-4, 1e-4, time_step=2e-6)
    assert shorter.time_step < 2.0001e-6 and shorter.steps > run.steps
    for name in ("RELATIVE", "PLACE", "RATE", "WORK"):
        monkeypatch.setattr(forward_motion, name, 0.01 * getattr(forward_motion, name))
    finer = simulate(Problem(PAPER, RUNNING, HARRIS, **choices), 4e-4, 1e-5)
    np.testing.assert_allclose(run.inner_y, finer.inner_y, atol=1e-12)
    np.testing.assert_allclose(shorter.inner_y, finer.inner_y[::10], atol=1e-12)
    assert np.ptp(run.inner_y) > 1e-6


def test_varying_compliance_has_the_size_of_the_statics():
    """14 nm vertical and 120 nm horizontal, peak to peak, at the ball-pass frequency (independent solution)."""
    run = simulate(Problem(PAPER, RUNNING, HARRIS), 1 / 381.52, 2e-5)
    assert 1e9 * np.ptp(run.inner_y) == pytest.approx(14.5, abs=1.0)
    assert 1e9 * np.ptp(run.inner_x) == pytest.approx(122.0, abs=4.0)


def test_free_rollers_keep_the_angular_momentum():
    operation = replace(RUNNING, gravity=0.0, radial_load=0.0)
    run = simulate(
        Problem(PRELOADED, operation, contact_laws("harris", PRELOADED), start="rest", angles="free"), 2e-4, 1e-5
    )
    orbits = PAPER.roller_mass * np.sum(run.roller_rho**2 * run.roller_theta_rate, axis=1)
    hub = operation.inner_mass * (run.inner_x * run.inner_vy - run.inner_y * run.inner_vx)
    np.testing.assert_allclose(orbits + hub, orbits[0], rtol=1e-12)


def test_free_angles_start_as_told_and_turn_on():
    operation = replace(RUNNING, first_roller_angle=4.0)
    run = simulate(Problem(PAPER, operation, HARRIS, angles="free"), 1e-3, 1e-4)
    np.testing.assert_allclose(run.roller_theta[0], 4.0 + 2 * np.pi * np.arange(13) / 13, rtol=1e-12)
    turned = run.roller_theta[-1] - run.roller_theta[0]
    np.testing.assert_allclose(turned, 2 * np.pi * 29.348 * 1e-3, rtol=1e-2)


def test_a_standing_bearing_settles_on_its_statics_and_rests_there():
    standing = replace(RUNNING, speed=0.0)
    run = simulate(Problem(PAPER, standing, HARRIS, start="rest", damping=ContactDamping(constant=2000.0)), 2e-3, 1e-4)
    found = static_equilibrium(PAPER, standing, HARRIS)
    assert run.inner_y[-1] == pytest.approx(found.y, rel=1e-8)
    np.testing.assert_allclose(run.inner_force[-1], found.inner_force, atol=1e-4)
    still = simulate(Problem(PAPER, standing, HARRIS), 5e-4, 1e-5)
    assert np.ptp(still.inner_y) < 1e-13 and np.ptp(still.inner_x) < 1e-13


@pytest.mark.slow
def test_a_hub_that_drops_through_a_clearance_strikes_the_rollers():
    loose = replace(PAPER, outer_raceway_radius=0.02802)
    run = simulate(Problem(loose, RUNNING, HARRIS, start="rest"), 5e-4, 1e-5)  # by 20 µm
    assert run.inner_force.max() > 3000.0
    assert np.max(np.abs(run.energy_error)) < 1e-5 * run.energy_contact.max()
    tips = simulate(Problem(loose, replace(RUNNING, radial_load=0.0), HARRIS), 1e-3, 1e-5)
    assert tips.inner_force.max() < 50.0 and abs(tips.inner_vy[0]) < 1.0  # from roller to roller, without a kick


def test_no_duration_gives_the_start_alone():
    run = simulate(Problem(PAPER, RUNNING, HARRIS), 0.0, 1e-5)
    assert run.time.shape == (1,) and run.roller_rho.shape == (1, 13) and run.steps == 0
    assert run.inner_force[0].max() == pytest.approx(630.76, abs=0.05)


CAGE = Cage(
    mass=0.01, inertia=5e-6, pocket_clearance=1e-4, guidance="rollers", guidance_clearance=None, stiffness=1e8,
    damping=0.0, friction_coefficient=0.1, drag_torque=0.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "told"),
    [({"damping": ContactDamping(constant=-1.0)}, "damping"), ({"start": "hot"}, "start"),
     ({"angles": "fixed"}, "angles"), ({"load_ramp": -1.0}, "load_ramp")],
)  # fmt: skip
def test_impossible_problems_are_refused(wrong, told):
    with pytest.raises(ValueError, match=told):
        Problem(PAPER, RUNNING, HARRIS, **wrong)


@pytest.mark.parametrize(
    ("choices", "duration", "interval", "told"),
    [({}, 1e-3, 0.0, "interval"), ({}, -1.0, 1e-5, "duration"), ({}, float("nan"), 1e-5, "duration"),
     ({"angles": "free", "cage": CAGE}, 1e-3, 1e-5, "cage")],
)  # fmt: skip
def test_impossible_runs_are_refused(choices, duration, interval, told):
    with pytest.raises(ValueError, match=told):
        simulate(Problem(PAPER, RUNNING, HARRIS, **choices), duration, interval)


STIFFNESS = 1e8  # N/m


def thrown(damping: ContactDamping, speed: float, exponent: float = 1.0) -> float:
    """Speed over `speed` with which a roller comes back that is thrown at the outer ring; nothing else acts."""
    law = PowerLaw(name="test", stiffness=STIFFNESS, exponent=exponent, source="")
    far = replace(PAPER, n_rollers=1, inner_raceway_radius=0.9 * PAPER.inner_raceway_radius)
    still = Operation(speed=0.0, radial_load=0.0, inner_mass=1.0, gravity=0.0, first_roller_angle=0.0)
    laws = ContactLaws(inner=law, outer=law)
    motion = forward_motion.Motion(Problem(bearing=far, operation=still, laws=laws, damping=damping, start="rest"))
    start = motion.start
    start[4] = far.outer_raceway_radius - far.roller_radius - far.pitch_radius  # ρ, where it touches
    start[4 + 4 + 2] = speed
    unit = sqrt(far.roller_mass / STIFFNESS) * (1.0 if exponent == 1.0 else 4.0)
    found = solve_ivp(motion.rate, (0.0, 5.0 * unit), start, "DOP853", rtol=1e-9, atol=1e-13, max_step=0.1 * unit)
    assert found.y[4, -1] < start[4]  # it has left
    return float(-found.y[10, -1] / speed)


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.3])
def test_two_bodies_bounce_through_a_dashpot_as_theory_says(ratio, monkeypatch):
    """Where pulling is allowed the coefficient of restitution is exp(−πζ/√(1 − ζ²)); by the law itself, which never
    pulls, exp(−ζ/√(1 − ζ²)·(π − atan2(2ζ√(1 − ζ²), 1 − 2ζ²))) with the angle at which spring and damper cancel.

    Source of the latter: Schwager and Pöschel, Coefficient of restitution and linear-dashpot model revisited, Granular
    Matter 9 (2007).
    """
    damping = ContactDamping(constant=2.0 * ratio * sqrt(STIFFNESS * PAPER.roller_mass))
    decay, root = ratio / sqrt(1.0 - ratio**2), sqrt(1.0 - ratio**2)
    leaves = pi - atan2(2.0 * ratio * root, 1.0 - 2.0 * ratio**2)
    assert thrown(damping, 0.1) == pytest.approx(exp(-decay * leaves), rel=1e-5)
    monkeypatch.setattr("lagrange.motion.damper_force", lambda spring, rate, c: np.where(spring > 0.0, c * rate, 0.0))
    assert thrown(damping, 0.1) == pytest.approx(exp(-pi * decay), rel=1e-5)


@pytest.mark.parametrize("loss", [0.01, 0.03])
def test_hunt_and_crossley_lose_in_proportion_to_speed(loss):
    """e = 1 − αv + O((αv)²), whatever the spring's law."""
    speed = 0.1
    damping = ContactDamping(hunt_crossley=loss / speed)
    for exponent in (1.0, 10.0 / 9.0):
        assert thrown(damping, speed, exponent) == pytest.approx(1.0 - loss, abs=1.5 * loss**2)

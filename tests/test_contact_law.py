"""The contact law itself: force, energy and stiffness of one potential, and what a kick of the time loop gives."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad

from fem.kernels.law import STEEPEST, contact_force
from tests.reference.bearings import model, paper
from tests.reference.compiled import kick_force, next_force, stored_energy


def laws():
    whole = model(paper(), 2e-3)
    return {"inner": whole.inner_law, "outer": whole.outer_law, "roller": whole.roller_law}


def force_of(law, approach):
    return contact_force(approach, law.A, law.B, law.Q_line, 0.0)


every_law = pytest.mark.parametrize("name", ["inner", "outer", "roller"])


@every_law
def test_contact_force_inverts_the_approach(name):
    law = laws()[name]
    for force in np.concatenate([np.geomspace(1e-9, 0.999, 40) * law.Q_line, law.Q_line * np.array([1.0, 1.5, 30.0])]):
        approach = float(law.approach(force))
        for guess in (0.0, force, 0.1 * force, 7.0 * force, 1e9):
            # Newton stops at 1e-14 of Q; dQ/Q = dδ/δ times at most 3 (bracket over bracket − ½)
            assert contact_force(approach, law.A, law.B, law.Q_line, guess) == pytest.approx(force, rel=3e-13)


@every_law
def test_the_next_force_inverts_the_approach_and_level_whatever_the_last_was(name):
    """Tiny, usual and wild changes, with the ripple moving too; forces above Q_line and contacts that open or close."""
    law, rng = laws()[name], np.random.default_rng(5)
    forces = np.concatenate([np.geomspace(1e-9, 0.999, 20) * law.Q_line, law.Q_line * np.array([1.0, 1.5, 30.0])])
    for before in forces:
        for change in (0.0, 1e-12, 1e-6, -1e-3, 0.05, -0.3, 1.0, 40.0):
            level_before, level = law.B + 0.05 * rng.uniform(-1.0, 1.0, 2)
            known = stored_approach(law, before, level_before)
            force = before * (1.0 + change)
            approach = stored_approach(law, force, level)
            found = next_force(approach, law.A, level, law.Q_line, before, known, level_before)
            assert found == pytest.approx(force, rel=1e-12)
            for unknown in ((0.0, np.nan), (0.0, -1e-6)):
                found = next_force(approach, law.A, level, law.Q_line, *unknown, level_before)
                assert found == pytest.approx(force, rel=1e-12)
            assert next_force(-1e-9, law.A, level, law.Q_line, before, known, level_before) == 0.0
        assert np.isnan(next_force(np.nan, law.A, law.B, law.Q_line, before, known, level_before))


def stored_approach(law, force, level):
    """δ = A Q (B − ½ ln Q), and the straight line above Q_line, m."""
    q = min(force, law.Q_line)
    bracket = level - 0.5 * np.log(q)
    return law.A * (q * bracket + (force - q) * (bracket - 0.5))


@every_law
def test_contact_never_pulls(name):
    law = laws()[name]
    for approach in (0.0, -1e-20, -1e-6, -1.0):
        assert force_of(law, approach) == 0.0
    assert stored_energy(0.0, law.A, law.B, law.Q_line) == 0.0


@every_law
def test_contact_energy_is_the_integral_of_the_force(name):
    law = laws()[name]
    for top in (0.01 * law.Q_line, 0.5 * law.Q_line, 2.0 * law.Q_line):
        closing = float(law.approach(top))
        corner = min(closing, float(law.approach(law.Q_line)))
        wanted = (
            quad(partial(force_of, law), 0.0, corner, epsrel=1e-11)[0]
            + quad(partial(force_of, law), corner, closing, epsrel=1e-11)[0]
        )
        assert stored_energy(top, law.A, law.B, law.Q_line) == pytest.approx(wanted, rel=1e-8)


@every_law
@pytest.mark.parametrize("ripple", [-0.05, 0.0, 0.05])
def test_the_law_has_one_potential_wherever_the_contact_sits(name, ripple):
    """Also above Q_line, where a heavy impact may come: force is the slope of energy in approach, ½ A Q² that in B."""
    law = laws()[name]
    level = law.B + ripple

    def force(approach, level):
        return contact_force(approach, law.A, level, law.Q_line, 0.0)

    def energy(approach, level):
        return stored_energy(force(approach, level), law.A, level, law.Q_line)

    at_line = law.A * law.Q_line * (level - 0.5 * np.log(law.Q_line))
    assert force(at_line * (1.0 - 1e-12), level) == pytest.approx(force(at_line * (1.0 + 1e-12), level), rel=1e-10)
    for approach in at_line * np.array([0.01, 0.5, 0.99, 1.01, 1.5, 3.0]):
        Q, step = force(approach, level), 1e-4 * approach
        slope = (energy(approach + step, level) - energy(approach - step, level)) / (2.0 * step)
        assert slope == pytest.approx(Q, rel=1e-6)
        in_level = (energy(approach, level + 1e-5) - energy(approach, level - 1e-5)) / 2e-5
        assert in_level == pytest.approx(-0.5 * law.A * Q**2, rel=1e-6)


@every_law
def test_the_straight_line_continues_value_and_slope(name):
    law = laws()[name]
    step = 1e-6 * law.Q_line
    below, at, above = law.approach(law.Q_line + step * np.array([-1.0, 0.0, 1.0]))
    assert law.A * law.Q_line * (law.B - 0.5 * np.log(law.Q_line)) == pytest.approx(float(at), rel=1e-13)
    slope = law.A * STEEPEST
    # one-sided differences: error step · A/(4 Q), 1e-6 of the slope; and the round-off 1e-16/1e-6
    assert (at - below) / step == pytest.approx(slope, rel=1e-5)
    assert (above - at) / step == pytest.approx(slope, rel=1e-8)


@every_law
def test_stiffness_is_the_slope_of_the_force(name):
    law = laws()[name]
    for force in law.Q_line * np.array([1e-6, 1e-3, 0.3, 1.2]):
        step = 1e-5 * float(law.approach(force))
        slope = (force_of(law, law.approach(force) + step) - force_of(law, law.approach(force) - step)) / (2.0 * step)
        assert law.stiffness(force) == pytest.approx(slope, rel=1e-8)


def bounce(law, mass, speed, dt, gap, force_of_a_kick):
    """Speed, m/s, at which a point mass thrown at the law comes back."""
    position, velocity = -gap, speed
    before, Q_before, P, residual = np.nan, 0.0, 0.0, 0.0
    while position > -2.0 * gap or velocity > 0.0:
        Q = force_of(law, position)
        last, now = (before, Q_before, law.B, P, residual), (position, Q, law.B)
        P, residual = force_of_a_kick((law.A, law.Q_line), last, now)
        velocity -= dt / mass * P
        before, Q_before = position, Q
        position += dt * velocity
    return -velocity


def plain(law, last, now):
    return now[1], 0.0


def test_a_mass_bounces_off_with_nearly_the_speed_it_came_with():
    """Steps of 1/10 ... 1/80 of the time to the nearest point, beginning anywhere: fourth order and without a jump."""
    law, mass, speed = laws()["inner"], 0.006, 0.1
    counts, lost, usual = np.array([10.0, 20.0, 40.0, 80.0]), [], []
    for count in counts:
        dt = 0.5 * np.pi * np.sqrt(mass / law.stiffness(200.0)) / count
        gaps = speed * dt * (3.0 + np.linspace(0.0, 0.9, 10))
        away = np.array([bounce(law, mass, speed, dt, gap, kick_force) for gap in gaps])
        lost.append(1.0 - away / speed)
        usual.append(1.0 - np.array([bounce(law, mass, speed, dt, gap, plain) for gap in gaps]) / speed)
    lost, usual = np.array(lost), np.array(usual)
    assert np.polyfit(np.log(counts), np.log(lost.mean(axis=1)), 1)[0] == pytest.approx(-4.0, abs=0.2)
    assert np.all(np.abs(lost).max(axis=1) < 0.003 * np.abs(usual).max(axis=1))
    assert lost[0].max() < 5e-6


@pytest.mark.parametrize("dt", [3e-7, 3e-5], ids=["light", "beyond the line"])
@pytest.mark.parametrize("inwards", [True, False], ids=["closing", "opening"])
def test_at_constant_speed_kicks_add_up_to_the_true_impulse(inwards, dt):
    """The half of a kick that looks back and the half of the one before that looks ahead, step by step."""
    law, speed = laws()["inner"], 1.0
    approach = (speed * dt * (np.arange(-4, 8) + 0.31))[:: 1 if inwards else -1]
    force = np.array([force_of(law, x) for x in approach])
    kicks = []
    for i in range(1, len(approach)):
        last = approach[i - 1], force[i - 1], law.B, force[i - 1], 0.0  # nothing owed, so nothing is given back
        kicks.append(kick_force((law.A, law.Q_line), last, (approach[i], force[i], law.B))[0])
    kicks = np.array(kicks)
    impulse = dt * (0.5 * force[0] + np.sum(kicks) - 0.5 * force[-1])
    assert impulse == pytest.approx(stored_energy(force.max(), law.A, law.B, law.Q_line) / speed, rel=1e-9)
    assert (kicks.min() < 0.0) != inwards  # the first after an opening takes back what the one before gave too much
    assert np.all(kicks[approach[1:] > 0.0] > 0.0)


def test_the_line_lies_far_above_the_papers_loads_at_its_mesh():
    whole = model(paper(), 1e-3)
    assert min(whole.inner_law.Q_line, whole.outer_law.Q_line) > 10.0 * 628.5


def test_hertz_pressure_of_the_papers_inner_contact():
    """Q = 628 N: b = 52.1 µm and p₀ = 768 MPa inside, 65 µm outside (Johnson 1985, section 4.2)."""
    whole = model(paper(), 2e-3)
    assert 1e6 * whole.inner_law.pair.half_width(628.0) == pytest.approx(52.1, abs=0.05)
    assert 1e6 * whole.outer_law.pair.half_width(628.0) == pytest.approx(65.0, abs=0.5)
    assert 1e-6 * whole.inner_law.pair.peak_pressure(628.0) == pytest.approx(768.0, abs=0.5)
    assert whole.inner_law.pair.peak_pressure(0.0) == 0.0


# the patch ------------------------------------------------------------------------------------------------------

"""[damping]: dampers of contacts and bodies, in all models; values from theory."""

from dataclasses import replace
from math import atan2, exp, pi, sqrt

import numpy as np
import pytest

import lagrange.systems
from lagrange import Bearing, ContactLaws, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping, damper_force
from lagrange.contact.laws import PowerLaw
from lagrange.first_state import Problem
from lagrange.integrate import NumpyIntegration
from lagrange.scene.scene import SceneError, parse_scene_text, read_scene
from lagrange.step_size import Steps
from lagrange.systems import KinematicAngles, Packed

PAPER = read_scene().ideal_bearing()
STIFFNESS = 1e8  # N/m
STEP = 5e-3  # of 1/ω: when a contact opens or closes is off by part of a step


def thrown(bearing: Bearing, damping: ContactDamping, speed: float, exponent: float = 1.0) -> float:
    """Speed over `speed` with which rollers come back that are thrown at the outer ring; nothing else acts."""
    law = PowerLaw(name="test", stiffness=STIFFNESS, exponent=exponent, source="")
    far = replace(bearing, inner_raceway_radius=0.9 * bearing.inner_raceway_radius)  # rollers never meet the inner ring
    still = Operation(speed=0.0, radial_load=0.0, inner_mass=1.0, gravity=0.0, first_roller_angle=0.0)
    system = KinematicAngles(Problem(bearing=far, operation=still, laws=ContactLaws(inner=law, outer=law)))
    frequency = sqrt(STIFFNESS / bearing.roller_mass)
    touching = bearing.outer_raceway_radius - bearing.roller_radius
    ones = np.ones(system.n)
    start = Packed(0j, 0j, touching * ones - 1e-12, speed * ones)
    steps = 1000 if exponent == 1.0 else 3000
    record = NumpyIntegration(system, start, steps * STEP / frequency, Steps.equal(steps), damping).advance(2)
    assert np.all(record.q[-1] < touching)  # they have left
    return float(-record.q_rate[-1, 0] / speed)


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
    assert thrown(PAPER, damping, 0.1) == pytest.approx(exp(-decay * leaves), rel=2e-3)
    monkeypatch.setattr(lagrange.systems, "damper_force", lambda spring, rate, c: np.where(spring > 0.0, c * rate, 0.0))
    assert thrown(PAPER, damping, 0.1) == pytest.approx(exp(-pi * decay), rel=2e-3)


@pytest.mark.parametrize("loss", [0.01, 0.03])
def test_hunt_and_crossley_lose_in_proportion_to_speed(loss):
    """e = 1 − αv + O((αv)²), whatever the spring's law."""
    speed = 0.1
    damping = ContactDamping(hunt_crossley=loss / speed)
    for exponent in (1.0, 10.0 / 9.0):
        assert thrown(PAPER, damping, speed, exponent) == pytest.approx(1.0 - loss, abs=1.5 * loss**2)


def test_a_damper_s_coefficient_is_that_of_its_law():
    force, stiffness = np.array([100.0, 400.0]), np.array([2e8, 3e8])
    np.testing.assert_allclose(ContactDamping(time=1e-5).coefficient(force, stiffness), [2000.0, 3000.0])
    np.testing.assert_allclose(ContactDamping(hunt_crossley=2.0).coefficient(force, stiffness), [300.0, 1200.0])
    np.testing.assert_array_equal(ContactDamping(constant=7.0).coefficient(force, stiffness), 7.0)
    assert not UNDAMPED.acts


def test_spring_and_damper_together_never_pull():
    found = damper_force(np.array([1.0, 1.0, 1.0, 0.0]), np.array([0.5, -0.2, -3.0, 5.0]), 2.0)
    np.testing.assert_array_equal(found, [1.0, -0.4, -1.0, 0.0])


def test_the_former_name_of_the_lagrangian_model_is_read_still():
    """Results made before all models had dampers say it in [lagrange]; there is one place for it in a scene."""
    found = parse_scene_text("[lagrange]\ndamping_N_s_m = 250.0", "old.toml")
    assert found == parse_scene_text("[damping]\ncontact_N_s_m = 250.0", "new.toml")
    assert "damping_N_s_m" not in found.to_toml().replace("contact_N_s_m", "")
    assert parse_scene_text("[lagrange]\ndamping_N_s_m = 0.0", "old.toml") == read_scene()


def test_a_scene_without_damping_says_nothing_of_it():
    assert "damping" not in read_scene().to_toml()
    damped = read_scene(None, ("damping.contact_time_us=12",))
    assert damped.damping.contacts == ContactDamping(time=1e-6 * 12.0)
    assert parse_scene_text(damped.to_toml(), "again") == damped


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["damping.contact_N_s_m=1", "damping.contact_time_us=1"], ["contact_N_s_m = 1", "leave all but one out"]),
        (["damping.hunt_crossley_s_m=-1"], ["damping.hunt_crossley_s_m = -1", "0"]),
        (["damping.contact_N_s_m=1", "lagrange.damping_N_s_m=1"], ["lagrange.damping_N_s_m: unknown key"]),
        (["model=lagrange", "damping.bodies_1_s=1"], ["damping.bodies_1_s = 1", "'lagrange'", "fem"]),
        (["model=reduced", "damping.bodies_1_s=1"], ["damping.bodies_1_s = 1", "'reduced'"]),
        (["model=reduced", "reduced.modes_up_to_kHz=500", "damping.contact_N_s_m=1"], ["modes_up_to_kHz = 500"]),
        (["contact.model=penalty", "damping.contact_N_s_m=1"], ["[damping]", '"penalty"', "subgrid"]),
    ],
)
def test_damping_that_a_model_can_t_have_is_refused_by_name(settings, words):
    with pytest.raises(SceneError) as caught:
        read_scene(None, tuple(settings))
    assert all(word in str(caught.value) for word in words), str(caught.value)

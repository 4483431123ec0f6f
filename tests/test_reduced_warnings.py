"""What a run of the reduced model says of itself: vibrations that rings take part in, wide contacts, its energy."""

import re
from dataclasses import replace
from functools import partial
from math import inf, pi, sqrt

import numpy as np
import pytest

from fem.elastic.continuum import Section, plane_compliance, ring_sections, roller_section
from fem.elastic.vibration import shift_vibrations
from fem.solver.rigid.state import ReducedState
from fem.solver.simulate import make_plan
from fem.solver.validity import BY_PRESSURE, add_samples, frequency_error, law_warning, no_sums, vibration_warning
from fem.statics.exact_statics import exact_contacts, law_error
from lagrange import Material
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import parse_scene
from tests.reference.collocated_contact import approach
from tests.reference.free_vibration import vibrations
from tests.reference.reduced_runs import RATTLES, in_longer_steps, ran
from tests.stability.random_scenes import random_scene

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
RING, LENGTH = Section(0.018, 0.0125, STEEL), 0.01
PAPER = parse_scene({}, "test").ideal_bearing()


def plan_of(number: int):
    """A random scene of the campaign in docs/reduced.md."""
    return make_plan(parse_scene(random_scene(7, number, 5.0) | {"model": "reduced"}, "test"))


@pytest.mark.parametrize("hub", [None, 0.05, 1.0])
def test_a_rings_shifting_modes_are_those_of_one_wave_around(hub):
    modes, shifting = vibrations(RING, LENGTH, 2.0 * pi * 5e5, hub), shift_vibrations(RING, LENGTH, hub)
    once = modes.order == 1
    count = int(once.sum())
    assert count > 1
    for name in ("frequency", "shape", "carried"):
        ours, theirs = getattr(shifting, name)[:count], getattr(modes, name)[once]
        np.testing.assert_allclose(np.abs(ours), np.abs(theirs), rtol=1e-9)


def test_all_shifting_modes_carry_the_rings_statics():
    modes = shift_vibrations(RING, LENGTH)
    exact = plane_compliance(RING, np.array([1]))[0] / (pi * RING.loaded * LENGTH)
    assert np.sum((modes.shape / modes.frequency) ** 2) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("stiff", [1e9, 4e9])
def test_the_frequencys_error_is_what_the_rings_modes_make_of_it(stiff):
    """Hub and ring by their free modes, tied to the ground at the raceway by a spring, N/m."""
    mass = 0.05 + PAPER.inner_ring_mass
    bearing = replace(PAPER, outer_ring=replace(PAPER.outer_ring, youngs_modulus=1e6 * PAPER.outer_ring.youngs_modulus))
    modes = shift_vibrations(ring_sections(bearing)[0], bearing.roller_length, 0.05)
    shape = np.concatenate([[1.0 / sqrt(mass)], -modes.shape])
    own = np.concatenate([[0.0], modes.frequency**2])
    exact = sqrt(np.linalg.eigvalsh(np.diag(own) + stiff * np.outer(shape, shape))[0])
    static = np.sum(((modes.shape + modes.carried) / modes.frequency) ** 2)
    model = 1.0 / sqrt(mass * (1.0 / stiff + static))
    assert exact > 1.001 * model
    assert frequency_error(bearing, mass, model) == pytest.approx(exact / model - 1.0, rel=1e-5)


def test_a_hub_faster_than_its_rings_has_no_such_frequency():
    assert frequency_error(PAPER, 0.5, 2.0 * pi * 1e6) == inf


def test_sums_do_not_depend_on_how_samples_are_cut():
    rng = np.random.default_rng(1)
    names = [f"inner_{name}" for name in ("x", "y", "vx", "vy", "ax", "ay")]
    samples = {name: rng.normal(size=50) for name in names}
    whole, parts = no_sums(), no_sums()
    add_samples(whole, samples)
    for part in (slice(0, 1), slice(1, 30), slice(30, 50)):
        add_samples(parts, {name: values[part] for name, values in samples.items()})
    assert np.array_equal(whole, parts) and whole[0] == 50.0


def test_a_hub_that_does_not_vibrate_is_not_warned_of():
    sums = no_sums()
    still = {f"inner_{name}": np.full(10, value) for name, value in
             {"x": 0.0, "y": -1e-5, "vx": 1e-3, "vy": 0.0, "ax": 1e9, "ay": 0.0}.items()}  # fmt: skip
    add_samples(sums, still)
    assert vibration_warning(PAPER, 0.5, sums) is None


def test_a_soft_ring_that_vibrates_as_an_elastic_body_is_warned_of():
    """Four fifths of the hub's mass are a plastic ring, and the load comes at once."""
    state, _, _ = ran(plan_of(161))
    said = [sentence for sentence in state.warnings if "is vibration" in sentence]
    assert len(said) == 1 and 'model = "fem"' in said[0]


def test_what_a_law_lacks_under_a_wide_contact_is_half_of_what_collocation_finds():
    """A thin soft inner ring under a contact of 8 % of the roller's radius and 20 % of the ring's thickness."""
    bearing = plan_of(151).model.bearing
    contacts = exact_contacts(bearing, roller_angles(bearing, 0.0))
    roller = roller_section(bearing)
    for law, ring in zip((contacts.inner_law, contacts.outer_law), ring_sections(bearing), strict=True):
        force = (0.08 * bearing.roller_radius) ** 2 / law.pair.half_width_factor
        sides = [(side.loaded, partial(plane_compliance, side)) for side in (ring, roller)]
        reach, load = 1.5 * law.pair.half_width(force), force / law.pair.length
        coarse, fine = (approach(sides, law.pair.relative_radius, load, reach, strips) for strips in (40, 80))
        exact = (4.0 * fine - coarse) / 3.0
        assert exact / law.approach(force) - 1.0 == pytest.approx(BY_PRESSURE * law_error(bearing, law, force), rel=0.2)


def test_wide_contacts_are_warned_of_and_narrow_ones_are_not():
    model = plan_of(151).model
    wide = np.array([196.0, 190.0, 0.0])
    error = float(re.search(r"about ([\d.]+) %", law_warning(model.contacts, wide)).group(1))
    assert 0.5 <= error <= 1.5
    assert law_warning(model.contacts, 0.1 * wide) is None


def test_a_run_whose_energy_is_off_says_so():
    """Rollers that rattle without friction, and no shorter steps: 1 % of what is exchanged in 20 ms."""
    plan = in_longer_steps(RATTLES)
    state, worst = plan.first_state(), 0.0
    state._halvings = ReducedState.most_halvings  # none is left
    while state.done < plan.n_samples:
        samples = state.advance(100).samples
        worst = max(worst, np.abs(samples.imbalance).max())
    said = next(sentence for sentence in state.warnings if sentence.startswith("the energy balance is off"))
    share = float(re.search(r"by up to ([\d.]+) %", said).group(1))
    assert share == pytest.approx(100.0 * worst / samples.exchanged[-1], rel=0.06)  # two digits are told
    assert said.endswith("lower numerics.time_step_safety")
    # with those steps that it chooses it is not
    assert not any(sentence.startswith("the energy") for sentence in ran(plan)[0].warnings)


def test_energy_of_a_law_is_the_work_of_its_force():
    law = exact_contacts(PAPER, roller_angles(PAPER, 0.0)).inner_law
    forces = np.linspace(0.0, 1000.0, 20_001)
    approaches = law.approach(forces)
    work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(approaches))
    assert float(law.energy(1000.0)) == pytest.approx(work, rel=1e-6)
    assert sqrt(float(law.energy(0.0))) == 0.0

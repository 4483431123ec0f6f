"""The resolved crossing of a spall, a yardstick of tests/accuracy, against theory: Hertz's contact, a disc's impact."""

from dataclasses import replace

import numpy as np
import pytest

from fem.statics.exact_statics import exact_contacts
from lagrange.contact.hertz import contact_pairs
from lagrange.scene.scene import Scene
from tests.reference.disc_impact import thrown_at_flat
from tests.reference.modal_bodies import Body
from tests.reference.resolved_bodies import DOWN, FINE, Surface, roller_body, surface
from tests.reference.resolved_crossing import Crossing, Run, crossing

PAPER = Scene().ideal_bearing()
COARSE = replace(FINE, raceway=13e-6, roller=9e-6, far_roller=0.8e-3, far=1.5e-3, cutoff=1e5)


@pytest.fixture(scope="module")
def at_rest():
    """A roller pressed between perfect raceways, its crossing, and the forces on it."""
    run = Run(crossing(PAPER, None, hub=(0.0, -3.6e-6), ahead=0.0, beyond=0.0, swing=0.0, fine=COARSE), 1e-7)
    return run, run.settle()


def test_contacts_are_hertz_contacts(at_rest):
    """Half-width and pressure, by the share of the force that lies left of each element's end."""
    run, _ = at_rest
    rings = (run.of.outer, run.of.inner)
    for force, ring, pair in zip(run.pressures, rings, (contact_pairs(PAPER)[1], contact_pairs(PAPER)[0]), strict=True):
        x, whole = ring.position[:, 0], force.sum()
        b = 2.0 * np.sqrt(np.sum(force * x**2) / whole)  # of Hertz's pressure the mean of x² is b²/4
        assert b == pytest.approx(pair.half_width(whole), rel=0.01)
        corner = np.arange(0, x.size, 2)
        left = (np.cumsum(force) - 0.5 * force)[corner] / whole
        z = np.clip(x[corner] / pair.half_width(whole), -1.0, 1.0)
        hertz = 0.5 + (z * np.sqrt(1.0 - z**2) + np.arcsin(z)) / np.pi
        assert np.abs(left - hertz).max() < 0.01


def test_a_roller_between_raceways_yields_as_the_exact_series_say(at_rest):
    _, forces = at_rest
    contacts = exact_contacts(PAPER, DOWN + 2.0 * np.pi / 13.0 * np.arange(13))
    outer, inner = np.hypot(*forces.T)
    assert outer == pytest.approx(inner, rel=1e-3)
    approach = contacts.inner_law.approach(inner) + contacts.outer_law.approach(outer)
    approach += contacts.compliance[0, 13] * (inner + outer)
    assert approach == pytest.approx(3.6e-6, rel=3e-3)


def test_a_roller_thrown_at_a_rigid_flat_bounces_as_its_exact_modes_do():
    speed, step = 0.2, 1e-7
    roller = roller_body(PAPER, 0.05e-3, 0.02e-3, replace(COARSE, cutoff=0.7e6))
    nothing = np.zeros((0, 2))
    flat = np.stack([np.linspace(-60e-6, 60e-6, 25), np.full(25, -PAPER.roller_radius)], axis=1)
    rigid = [
        Body(points=at, omega=np.zeros(1), shapes=np.zeros((at.size, 1)), residual=np.zeros((at.size, at.size)),
             translation=np.zeros((1, 2)), mass=1.0)
        for at in (flat, nothing)
    ]  # fmt: skip
    rings = [
        Surface(body=one, position=one.points, node=np.arange(len(one.points)), angle=np.zeros(len(one.points)))
        for one in rigid
    ]
    run = Run(
        Crossing(
            roller=roller,
            lower=surface(roller, DOWN, lambda away: np.full_like(away, PAPER.roller_radius)),
            upper=surface(roller, -DOWN, lambda away: np.full_like(away, PAPER.roller_radius)),
            outer=rings[0],
            inner=rings[1],
            radius=PAPER.roller_radius,
            hub=np.zeros(2),
            start=np.array([0.0, 1e-9]),
            swing=0.0,
        ),
        step,
    )
    run.throw(np.array([0.0, -speed]))
    before = run.energy.sum()
    forces = np.array([run.advance()[0, 1] for _ in range(400)])
    exact = thrown_at_flat(speed, PAPER.roller_radius, PAPER.roller_length, PAPER.roller)
    assert forces[-1] == 0.0
    assert run.energy.sum() == pytest.approx(before, rel=2e-3)
    assert forces.max() == pytest.approx(exact.force, rel=0.01)
    assert np.count_nonzero(forces) * step == pytest.approx(exact.duration, rel=0.01)
    rebound = run.roller.mean(run.roller.v)[1] / speed
    assert rebound == pytest.approx(exact.rebound, abs=0.005)
    assert forces.sum() * step == pytest.approx(roller.mass * speed * (1.0 + rebound), rel=1e-3)

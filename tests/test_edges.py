"""Contacts at the edges of spalls: softer than on the sound surface, in one potential with all else."""

from dataclasses import replace
from math import log

import numpy as np
import pytest

from fem.solver.simulate import make_plan
from lagrange import contact_laws
from lagrange.contact.hertz import contact_pairs
from lagrange.motion import State, accelerations, contact_energy, contact_state
from lagrange.scene.scene import Scene, read_scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.edges import Circles, Softened, softening
from lagrange.surface.faults import Spall
from tests.reference.edge_contact import EdgeContact

PAPER = Scene().ideal_bearing()
LAWS = contact_laws("johnson", PAPER)
DOWN = -np.pi / 2


def deep(body, width=1e-3, depth=1e-4, edge_radius=1e-4):
    roller = 0 if body == "roller" else None
    return Spall(body=body, roller=roller, angle=0.0, width=width, depth=depth, edge_radius=edge_radius)


def yardstick(kind, spall):
    pair, law = contact_pairs(PAPER)[kind], LAWS[kind]
    half = spall.half_opening(PAPER.roller_radius)
    return EdgeContact(
        radius=pair.radii[0], roller_radius=PAPER.roller_radius, compliance=pair.line_compliance,
        level=0.5 * law.level, half_opening=half, edge_radius=spall.edge_radius, beside=0.4e-3,
    ), half, law  # fmt: skip


@pytest.mark.parametrize("kind", [0, 1])
def test_the_yardstick_is_hertz_contact_far_from_the_edge(kind):
    reference, half, law = yardstick(kind, deep("outer_ring"))
    for approach in (0.5e-6, 2e-6):
        force, pressure = reference.press(half + 0.15e-3, approach)
        assert force == pytest.approx(law.force(approach), rel=5e-4)
        assert pressure / PAPER.roller_length == pytest.approx(
            contact_pairs(PAPER)[kind].peak_pressure(force), rel=3e-3
        )


@pytest.mark.parametrize(
    ("body", "own", "other", "meeting", "curvature"),
    [("outer_ring", 0.028, 0.005, "bore", 1 / 0.005 - 1 / 0.028),
     ("inner_ring", 0.018, 0.005, "outside", 1 / 0.005 + 1 / 0.018),
     ("roller", 0.005, 0.028, "in_bore", 1 / 0.005 - 1 / 0.028)],
)  # fmt: skip
def test_an_edge_alone_has_its_own_curvature(body, own, other, meeting, curvature):
    """ΔB = ½ ln(ratio of the curvatures) where the contact lies on its edge, 0 beside the spall and in its middle."""
    spall = deep(body, width=2e-3)
    found = softening(spall, Circles(own, other, meeting, PAPER.roller_radius), np.array([0.0, 0.3e-3, 1.2e-3]) / own)
    with_other = 1e4 + (1.0 / other if meeting != "in_bore" else -1.0 / other)
    assert found[1] == pytest.approx(0.5 * log(with_other / curvature), abs=0.02)
    assert found[0] == found[2] == 0.0


@pytest.mark.parametrize(("body", "kind"), [("inner_ring", 0), ("outer_ring", 1)])
def test_forces_at_edges_are_those_of_half_planes(body, kind):
    """Measured: within 3.1 %, where the sinkage alone is off by up to 46 %."""
    spall = deep(body)
    reference, half, law = yardstick(kind, spall)
    places = half + np.array([60e-6, 20e-6, 0.0, -20e-6, -60e-6, -150e-6, -0.3e-3])
    angle = np.repeat(np.arcsin(places / abs(contact_pairs(PAPER)[kind].radii[0]))[:, None], 13, axis=1)
    met = getattr(profiles(replace(PAPER, faults=(spall,))), ("inner", "outer")[kind])(angle, Turns())
    for place, sinkage, soft in zip(places, met.sinkage[:, 0], met.compliance[:, 0], strict=True):
        for approach in (1e-6, 3e-6):
            exact, _ = reference.press(place, sinkage + approach)
            assert Softened(law=law, compliance=soft).force(approach) == pytest.approx(exact, rel=0.04)
    exact, _ = reference.press(half - 0.3e-3, met.sinkage[-1, 0] + 2e-6)
    assert law.force(2e-6) > 1.3 * exact


def test_a_shallow_spall_s_bottom_is_as_stiff_as_the_raceway():
    places = np.array([0.0, 0.1e-3]) / 0.028
    assert np.abs(softening(deep("outer_ring", depth=2e-6), Circles(0.028, 0.005, "bore", 0.005), places)).max() < 0.01


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_a_law_in_series_with_a_compliance(law):
    plain, depth = contact_laws(law, PAPER).outer, np.array([-1e-6, 0.0, 1e-9, 1e-6, 5e-6])
    soft = Softened(law=plain, compliance=1e-9)
    force = soft.force(depth)
    assert np.all(force[:2] == 0.0)
    np.testing.assert_allclose(soft.approach(force[2:]), depth[2:], rtol=1e-13)
    ahead, behind = soft.force(depth * 1.0001), soft.force(depth * 0.9999)
    np.testing.assert_allclose(soft.slope(depth[2:]), (ahead - behind)[2:] / (2e-4 * depth[2:]), rtol=1e-6)
    energy = soft.potential(depth * 1.0001) - soft.potential(depth * 0.9999)
    np.testing.assert_allclose(force[2:], energy[2:] / (2e-4 * depth[2:]), rtol=1e-6)


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_forces_at_edges_are_the_gradient_of_the_energy(law):
    """Rollers 20 µm and more beside the edge of a spall, on raceways and on a roller, by every coordinate."""
    faults = tuple(replace(deep(body), angle=angle) for body, angle in
                   (("outer_ring", DOWN), ("inner_ring", DOWN + 0.4735), ("roller", 0.3)))  # fmt: skip
    bearing, laws, n = replace(PAPER, faults=faults), contact_laws(law, PAPER), 13
    operation = replace(Scene().ideal_operation(), gravity=0.0, radial_load=0.0)
    track = PAPER.outer_raceway_radius - PAPER.roller_radius
    angle = DOWN + 0.0175 + np.arange(n) * 2 * np.pi / n
    start = np.concatenate([[1e-6, -4e-6], np.full(n, track + 2e-6), angle])
    turns = Turns(inner_ring=0.0, rollers=DOWN + 0.0175 - 0.3 - 0.0895)

    def state(values):
        rest = np.zeros(n)
        return State(x=values[0], y=values[1], rho=values[2 : n + 2], theta=values[n + 2 :], x_rate=0.0, y_rate=0.0,
                     rho_rate=rest, theta_rate=rest, turns=turns)  # fmt: skip

    def energy(values):
        return contact_energy(laws, contact_state(bearing, laws, state(values)))

    contacts = contact_state(bearing, laws, state(start))
    assert contacts.outer_compliance[0] > 1e-10 and contacts.outer_force[0] > 100.0
    assert contacts.inner_compliance[1] > 1e-10 and contacts.inner_force[1] > 50.0
    ax, ay, rho, theta = accelerations(bearing, operation, state(start), contacts)
    mass = bearing.roller_mass
    forces = np.concatenate([[operation.inner_mass * ax, operation.inner_mass * ay], mass * rho])
    moments = mass * start[2 : n + 2] ** 2 * theta
    steps = np.concatenate([np.full(n + 2, 1e-9), np.full(n, 1e-8)])
    gradient = np.array([
        (energy(start + h * unit) - energy(start - h * unit)) / (2.0 * h)
        for h, unit in zip(steps, np.eye(2 * n + 2), strict=True)
    ])  # fmt: skip
    np.testing.assert_allclose(forces, -gradient[: n + 2], atol=2e-3, rtol=1e-4)
    np.testing.assert_allclose(moments, -gradient[n + 2 :], atol=2e-5, rtol=1e-4)


@pytest.mark.parametrize(("body", "angle"), [("outer_ring", 3.0), ("inner_ring", -5.0)])
def test_energy_is_balanced_over_soft_edges_in_the_reduced_model(body, angle):
    """Both edges are crossed under load; measured 3e-5 at most."""
    settings = (
        'model="reduced"', f'spall.0.body="{body}"', f"spall.0.angle_deg={angle}", "spall.0.width_mm=0.4",
        "numerics.duration_ms=0.8", "numerics.output_interval_us=1",
    )  # fmt: skip
    plan = make_plan(read_scene(None, settings))
    block = plan.first_state().advance(plan.n_samples)
    assert block.trouble is None
    assert np.abs(block.samples.relative_error()).max() < 2e-4

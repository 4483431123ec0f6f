"""Reduced model: tractions along the rings press raceways down or push them up under other contacts."""

import numpy as np
import pytest

from fem.statics.exact_statics import crossings_at
from lagrange.scene.scene import Scene
from tests.reference.bearings import LENGTH, ring
from tests.reference.reduced_runs import couplings, plan_of, samples_of

PAPER = Scene().ideal_bearing()
SLIDING = ("contact.friction_coefficient=0.3", "operation.gravity_m_s2=0")
SECTORS, LAYERS = 312, 14  # of 0.4 mm, 24 a roller's distance


def stop_rollers(state):
    """They do not spin, so that all contacts slide."""
    state.bodies.spin[:] = 0.0


def pulled_rings() -> np.ndarray:
    """Inward displacement, m/N, of raceways under a unit force along +θ on node 0 of a mesh: (2, SECTORS)."""
    found = []
    for loaded, held in (
        (PAPER.inner_raceway_radius, PAPER.bore_radius),
        (PAPER.outer_raceway_radius, PAPER.outside_radius),
    ):
        body = ring(min(loaded, held), max(loaded, held), SECTORS, LAYERS, held < loaded)
        force = np.zeros((body.n_rows, 2, SECTORS))
        force[body.raceway_row, 1, 0] = 1.0
        outward = 1.0 if held < loaded else -1.0
        found.append(-outward * body.held(force)[body.raceway_row, 0])
    return np.array(found)


def test_a_traction_moves_a_raceway_as_a_mesh_says():
    """Of the same two rings by finite elements, which know neither series nor patches."""
    assert PAPER.roller_length == LENGTH
    apart = SECTORS // PAPER.n_rollers * np.array([-3, -2, -1, 1, 2, 3])
    meshed = pulled_rings()[:, apart % SECTORS]
    found = crossings_at(PAPER, 2.0 * np.pi * apart / SECTORS)
    for row in range(2):
        np.testing.assert_allclose(found[row], meshed[row], rtol=0.0, atol=0.01 * np.abs(meshed[row]).max())


def test_sliding_neighbours_take_of_an_approach_what_a_mesh_says():
    """Overlap of circles, less what all other forces take, less the law's own: what tractions have moved."""
    plan = plan_of(*SLIDING, "numerics.output_interval_us=0.5")
    model, given = plan.model, plan.first_state().contacts
    found = {name: value[-1] for name, value in samples_of(plan, stop_rollers, count=50).items()}
    hub, centre = np.array([found["inner_x"], found["inner_y"]]), np.array([found["roller_x"], found["roller_y"]])
    angle, Q, T = np.arctan2(centre[1], centre[0]), found["inner_force"], found["inner_traction"]
    loaded = Q > 1.0
    assert np.all(np.abs(T[loaded]) > 0.29 * Q[loaded])
    law, log = model.inner_law, np.log(np.where(loaded, Q, 1.0))
    left = given.reach - np.hypot(*(centre - hub[:, None])) - law.A * Q * (law.B - 0.5 * log)
    left -= couplings(model, angle)[0] @ Q + model.across * found["outer_force"]
    ahead = np.subtract.outer(angle, angle) * SECTORS / (2.0 * np.pi)  # in nodes, of a traction's place
    nodes = np.arange(SECTORS)
    moved = np.interp(ahead.ravel(), nodes, pulled_rings()[0], period=SECTORS).reshape(ahead.shape)
    np.fill_diagonal(moved, 0.0)  # its own traction moves a contact by nothing
    taken = -moved @ T  # rings are pulled the other way
    assert np.abs(taken[loaded]).max() > 2e-3 * np.abs(law.A * Q * law.B).max()
    # neighbours beyond the third are left out
    np.testing.assert_allclose(left[loaded], taken[loaded], rtol=0.0, atol=0.07 * np.abs(taken[loaded]).max())


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_energy_balances_while_rollers_slide(friction):
    """Without the tractions' work on raceways that forces shift along themselves it is 7e-4 and 2e-3 off."""
    plan = plan_of(f"contact.friction_coefficient={friction}", "numerics.duration_ms=5", stride=20)
    found = samples_of(plan, stop_rollers)
    assert found["work_dissipated"][-1] > 0.1
    assert np.abs(found["imbalance"]).max() < 5e-5 * found["exchanged"][-1]

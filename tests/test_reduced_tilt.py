"""Reduced model: forces along the rings tilt raceways under contacts, whose compliances go with rollers' angles."""

import numpy as np

from fem.statics.reduced_bearing import ReducedBearing
from lagrange.scene.scene import Scene
from tests.reference.reduced_runs import couplings, plan_of, samples_of

PAPER = Scene().ideal_bearing()
FRICTIONLESS = ("contact.friction_coefficient=0", "operation.gravity_m_s2=0", "numerics.output_interval_us=0.5")
STRAYED = 1e-3 * np.array([0.0, 3.1, -2.4, 1.7, 0.8, -3.0, 2.2, -1.1, 2.7, -0.6, 1.3, -2.8, 0.4])  # rad


def elastic_energy(model: ReducedBearing, coupling, reach: float, track: float, hub, centre) -> float:
    """Of all contacts, J, by Newton's method on every force at once; centres (2, n), m."""
    n = centre.shape[1]
    overlap = np.concatenate([reach - np.hypot(*(centre - hub[:, None])), np.hypot(*centre) - track])
    soft = np.zeros((2 * n, 2 * n))
    soft[:n, :n], soft[n:, n:] = coupling
    soft[np.arange(n), n + np.arange(n)] = soft[n + np.arange(n), np.arange(n)] = model.across
    A = np.repeat([model.inner_law.A, model.outer_law.A], n)
    B = np.repeat([model.inner_law.B, model.outer_law.B], n)
    closed, Q = overlap > 0.0, np.zeros(2 * n)
    Q[closed] = overlap[closed] / (10.0 * A[closed])
    for _ in range(60):
        own = np.where(closed, A * Q * (B - 0.5 * np.log(np.where(closed, Q, 1.0))), 0.0)
        missed = (own + soft @ Q - overlap)[closed]
        slope = soft + np.diag(np.where(closed, A * (B - 0.5 * np.log(np.where(closed, Q, 1.0)) - 0.5), 1.0))
        Q[closed] -= np.linalg.solve(slope[np.ix_(closed, closed)], missed)
    assert np.all(Q[closed] > 0.0)
    assert np.abs(missed).max() < 1e-18
    logs = np.log(np.where(closed, Q, 1.0))
    own = A * Q * Q * (B - 0.5 * logs) - A * Q * Q * (0.5 * B - 0.25 * logs + 0.125)
    return float(own.sum() + 0.5 * Q @ soft @ Q)


def test_rollers_are_pushed_along_raceways_as_elastic_energy_falls():
    """Against the gradient of the whole bearing's energy, compliances of the rollers' true angles in it."""
    plan = plan_of(*FRICTIONLESS)
    n = plan.model.bearing.n_rollers

    def stray(state):
        bodies = state.bodies
        bodies.velocity[:], bodies.hub_velocity[:] = 0.0, 0.0
        c, s = np.cos(STRAYED), np.sin(STRAYED)
        x, y = bodies.centre[:, :n].copy()
        bodies.centre[0, :n], bodies.centre[1, :n] = c * x - s * y, s * x + c * y

    found = samples_of(plan, stray, count=9)
    centre = np.array([found["roller_x"], found["roller_y"]])  # (2, n_times, n)
    at, dt = 4, plan.time_step
    pushed = plan.model.bearing.roller_mass * (centre[:, at + 1] - 2.0 * centre[:, at] + centre[:, at - 1]) / dt**2
    hub, centre = np.array([found["inner_x"][at], found["inner_y"][at]]), centre[:, at]
    away = np.hypot(*centre)
    along = np.array([-centre[1], centre[0]]) / away
    loaded = found["inner_force"][at] > 1.0
    assert 3 <= np.count_nonzero(loaded) < n
    given = plan.first_state().contacts
    step, wanted, flat = 1e-7, np.zeros(n), np.zeros(n)
    still = couplings(plan.model, np.arctan2(centre[1], centre[0]))
    for j in np.flatnonzero(loaded):
        energy = {}
        for sign in (-1.0, 1.0):
            moved = centre.copy()
            moved[:, j] += sign * step * along[:, j]
            turned = couplings(plan.model, np.arctan2(moved[1], moved[0]))
            for name, coupling in (("tilted", turned), ("flat", still)):
                energy[name, sign] = elastic_energy(plan.model, coupling, given.reach, given.track, hub, moved)
        wanted[j] = -(energy["tilted", 1.0] - energy["tilted", -1.0]) / (2.0 * step)
        flat[j] = -(energy["flat", 1.0] - energy["flat", -1.0]) / (2.0 * step)
    found_along = np.sum(pushed * along, axis=0)
    tilt = np.abs(wanted - flat).max()
    np.testing.assert_allclose(found_along[loaded], wanted[loaded], rtol=0.0, atol=0.02 * tilt)


def test_checkpoints_hold_no_compliances():
    """They follow from the model and from where rollers are."""
    kept = plan_of().first_state().named_arrays()
    assert "forces.force" in kept
    assert not {"forces.along", "forces.steep", "forces.strayed", "forces.tilt"} & set(kept)

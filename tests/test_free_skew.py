"""Rollers that are free to skew: tractions by slices against Carter's curve, precession, runs, the checker."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
import sympy as sp

from fem.contacts.tilted import tilted_slices
from fem.kernels.jit import kernel
from fem.kernels.lane_memory import load
from fem.kernels.reduced_friction import tractions
from fem.kernels.skews import drift_skews
from fem.kernels.sliced_friction import sliced_tractions
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from lagrange.scene.scene import Scene, SceneError
from lagrange.tilt import SlicedTractions
from residual.evaluation import evaluate
from residual.figures.motion import tilt_figure
from residual.sources import read_result
from tests.reference import tilted_runs
from tests.reference.tilted_runs import missed, moved

SPEED, ANGLE, FRICTION = 300.0, 0.4, 0.1  # rad/s, of rollers backwards; rad, of the roller that is looked at


def scene(axial=(), model="reduced", **changes):
    """That of rollers that tilt, which are free to skew."""
    return tilted_runs.scene(model, {"skew": "free", **dict(axial)}, **changes)


@pytest.mark.parametrize(
    ("axial", "changes", "remedy"),
    [
        ({}, {"contact__friction_coefficient": 0.0}, r"neutral against skew.*give contact\.friction_coefficient"),
        ({}, {"model": "lagrange"}, 'only with model = "reduced".*not with "lagrange"'),
        ({"skew": "guided", "skew_play_mrad": 1.0}, {}, r'skew_play_mrad = 1: only with skew = "free"'),
    ],
)
def test_free_skew_without_tractions_by_slices_is_refused_by_name(axial, changes, remedy):
    with pytest.raises(SceneError, match=remedy):
        scene(axial, **changes)


def test_moments_of_tractions_are_those_of_virtual_work():
    """By velocities of surfaces where they touch, the vector product of their rotation, in slopes' first order."""
    rates, (small, spin) = sp.symbols("rate_out rate_around"), sp.symbols("small spin")
    out, around, up = sp.Matrix([1, 0, 0]), sp.Matrix([0, 1, 0]), sp.Matrix([0, 0, 1])

    def on_slope(z, reach, angle, traction, axial):
        """Moments on a body's slope outwards and around of a traction that touches it at z, `reach` along a normal."""
        normal = sp.cos(angle) * out + sp.sin(angle) * around
        axis, turning = up + small * (2 * out - around), small * (rates[0] * out + rates[1] * around)
        velocity = (axis.cross(turning) + spin * axis).cross(z * axis + reach * normal)
        power = (traction * up.cross(normal) + axial * up).dot(velocity)
        return np.array([float(power.diff(rate).diff(small).subs(small, 0)) for rate in rates])

    bearing, z, angle = Scene().ideal_bearing(), (2e-3, -3e-3), 0.3
    r, along, across = bearing.roller_radius, (3.0, 5.0), (-2.0, 7.0)
    found = SlicedTractions(
        inner_moment=np.array([along[0] * z[0]]), inner_axial=np.array([across[0]]),
        outer_moment=np.array([along[1] * z[1]]), outer_axial=np.array([across[1]]),
    )  # fmt: skip
    normal = np.cos(angle), np.sin(angle)
    inner, outer = on_slope(z[0], -r, angle, along[0], across[0]), on_slope(z[1], r, 0.0, along[1], across[1])
    tilting, skewing = (inner + outer) * (1.0, -1.0)  # skew moves +z ends backwards
    assert np.ravel(found.on_roller(bearing, normal)) == pytest.approx([tilting, skewing], rel=1e-12)
    on_ring = on_slope(z[0], bearing.inner_raceway_radius, angle, -along[0], -across[0])
    assert np.ravel(found.on_hub(bearing, normal, np.ones(1), np.zeros(1))) == pytest.approx(on_ring, rel=1e-12)


@kernel
def rub(bodies, compliance, forces, drive, before, steps):
    """Tractions by slices of the first eight rollers after steps in which nothing else moves."""
    for _ in range(steps):
        sliced_tractions(bodies.tilts, bodies, compliance, forces, drive, before, 0)


@kernel
def rub_whole(bodies, compliance, forces, drive, before, steps):
    """The same of whole contacts, as in the plane section."""
    Q_i, Q_o = load(forces.estimate, 0), load(forces.estimate, bodies.columns)
    for _ in range(steps):
        tractions(bodies, compliance, forces, drive, before, 0, Q_i, Q_o)


class Spinning(NamedTuple):
    """What `drift_skews` reads of rollers and of what drives them."""

    spin: np.ndarray
    n: int
    columns: int
    dt: float


@kernel
def spin_freely(skews, rollers, steps):
    for _ in range(steps):
        drift_skews(skews, rollers, rollers)


@cache
def plan(profile):
    keys = {"roller_profile": profile, "coupling": profile != "none", "slices": 21}
    return make_plan(scene(keys, contact__friction_coefficient=FRICTION))


@cache
def slices_of(profile):
    """Those of the inner contact, solved for one by one."""
    model = plan(profile).model
    return tilted_slices(model.bearing, plan(profile).scene.ideal_axial(), (model.inner_law, model.outer_law))[0]


def rubbed(profile, approach, slope, kernel=rub, skew=0.0, skew_rate=0.0, slip=0.0):
    """Bodies and forces after rollers at one angle have rolled between still centres for a while."""
    state, bearing, slices = plan(profile).first_state(), plan(profile).model.bearing, slices_of(profile)
    bodies, forces, before, r = state.bodies, state.forces, state._before, bearing.roller_radius
    force = slices.forces(np.array([approach]), np.array([slope]))[0]
    n, t = np.array([np.cos(ANGLE), np.sin(ANGLE)]), np.array([-np.sin(ANGLE), np.cos(ANGLE)])
    forces.normal[:] = n[None, :, None]
    forces.estimate[:2], forces.first[:2] = force.sum(), approach
    forces.tilted.met[:, 0], forces.tilted.met[:, 2] = slope, force @ slices.place
    before.spin[:], before.velocity[:] = -SPEED, (SPEED * r + slip) * t[:, None]
    skews = bodies.tilts.skews._replace(gyration=0.0)
    skews.axis[:] = -skew * t[:, None]
    skews.rate[:] = (SPEED * r / bearing.pitch_radius * skew * n - skew_rate * t)[:, None]
    bodies = bodies._replace(tilts=bodies.tilts._replace(skews=skews))
    drive = state.drive._replace(speed=2.0 * SPEED * r / bearing.inner_raceway_radius, dt=1e-6)
    kernel(bodies, state.compliance, forces, drive, before, 5000)
    return bodies, forces, drive


def carter(profile, approach, slope, slip):
    """Tractions of an inner contact's slices, N, that slip, m/s, by Carter's curve, and their z, m."""
    slices, law, model = slices_of(profile), plan(profile).model.inner_law.constants, plan(profile).model
    force = slices.forces(np.array([approach]), np.array([slope]))[0]
    half_width = np.sqrt(law.half_width_factor * force.size * force)
    turn = SPEED * model.bearing.roller_radius / model.bearing.pitch_radius
    full = FRICTION * law.curvature * half_width * (SPEED + turn) * model.bearing.roller_radius
    share = np.minimum(np.abs(slip) / np.maximum(full, 1e-12), 1.0)
    return -FRICTION * force * share * (2.0 - share) * np.sign(slip), slices.place


# contacts, and by how much shares of the force that follow from depths may be off: along the axis, and turning
CONTACTS = [
    ("none", 4e-6, 0.0, 1e-6, 1e-6),
    ("logarithmic", 7e-6, 0.0, 0.01, 0.06),
    ("logarithmic", 7e-6, 1e-3, 0.01, 0.05),
]


@pytest.mark.parametrize(("profile", "approach", "slope", "off", "_"), CONTACTS)
@pytest.mark.parametrize("skew", [1e-5, 1e-3, 0.05])
def test_a_skewed_roller_creeps_along_the_axis_by_carters_curve(profile, approach, slope, off, _, skew):
    # from hardly any creep to sliding
    bodies, forces, _ = rubbed(profile, approach, slope, skew=skew)
    model, slid = plan(profile).model, bodies.tilts.skews.slid
    turn = SPEED * model.bearing.roller_radius / model.bearing.pitch_radius
    creep = skew * (SPEED + turn) * model.bearing.roller_radius
    nu = model.bearing.roller.poisson_ratio
    expected = carter(profile, approach, slope, (1.0 - nu) * creep)[0].sum()
    assert slid[1, 0] == pytest.approx(expected, rel=off)
    limit = FRICTION * forces.estimate[0, 0]
    assert abs(slid[1, 0]) <= limit * (1.0 + 1e-9)
    if skew == 0.05:
        assert slid[1, 0] == pytest.approx(-limit, rel=1e-9)
    r, n = model.bearing.roller_radius, np.array([np.cos(ANGLE), np.sin(ANGLE)])
    couple = bodies.tilts.skews.rubbed[:2, 0]  # the raceways pull opposite ways, and turn the roller's axis outwards
    assert slid[3, 0] > 0.0
    assert couple @ n == pytest.approx(r * (slid[1, 0] - slid[3, 0]), rel=1e-3)


@pytest.mark.parametrize(("profile", "approach", "slope", "_", "off"), CONTACTS)
@pytest.mark.parametrize("skew_rate", [0.02, 2.0, 1e4])
def test_a_roller_that_turns_on_its_contact_is_held_by_carters_curve(profile, approach, slope, _, off, skew_rate):
    bodies, *_ = rubbed(profile, approach, slope, skew_rate=skew_rate)
    pulls, z = carter(profile, approach, slope, -skew_rate * slices_of(profile).place)
    assert bodies.tilts.skews.slid[0, 0] == pytest.approx(pulls @ z, rel=off)
    assert pulls @ z > 0.0


def test_slices_of_a_straight_roller_add_up_to_the_plane_sections_traction():
    for slip in (1e-5, 1e-3, 1.0):
        _, sliced, of_slices = rubbed("none", 4e-6, 0.0, slip=slip)
        _, whole, of_whole = rubbed("none", 4e-6, 0.0, kernel=rub_whole, slip=slip)
        assert whole.traction[0, 0] < 0.0
        assert sliced.traction[:2] == pytest.approx(whole.traction[:2], rel=1e-9)
        assert of_slices.sums[1:] == pytest.approx(of_whole.sums[1:], rel=1e-9)  # works of drive and friction


def test_a_free_roller_precesses_as_a_top_without_moments():
    state, bearing = plan("none").first_state(), plan("none").model.bearing
    skews, spin, steps = state.bodies.tilts.skews, 2000.0, 1000
    r, length = bearing.roller_radius, bearing.roller_length
    frequency = 6.0 * r**2 / (3.0 * r**2 + length**2) * spin
    columns, dt = state.bodies.columns, 0.75 * 2.0 * np.pi / frequency / steps  # three quarters of a turn
    skews.axis[:], skews.rate[0], skews.rate[1] = 0.0, 1.0, 0.0
    spin_freely(skews, Spinning(np.full(columns, spin), columns, columns, dt), steps)
    assert skews.rate[:, 0] == pytest.approx([0.0, -1.0], abs=1e-12)
    assert skews.axis[:, 0] == pytest.approx(np.array([-1.0, 1.0]) / frequency, rel=1e-5)  # round a circle


@pytest.mark.slow  # compiles a loop
def test_a_run_skews_and_its_equations_hold(tmp_path):
    path = tmp_path / "skewed.nc"
    found = scene(operation__misalignment_mrad=1.0, numerics__duration_ms=1.0, numerics__output_interval_us=2.0)
    run_scene(found, path, RunOptions(quiet=True))
    checked = evaluate(read_result(path))
    record, tilt = checked.record, checked.tilt
    assert np.abs(record.roller_skew).max() > 5e-5
    for equation in (tilt, tilt.skew):
        assert equation.error == pytest.approx(equation.contact_law + equation.balance, abs=1e-9)
    given = np.abs(record.outer_traction_moment + record.inner_traction_moment).max()
    tilting = record.bearing.roller_radius * np.abs(record.inner_axial_traction - record.outer_axial_traction).max()
    # but for what differentiation of samples misses
    assert np.sqrt(np.mean(tilt.skew.balance**2)) < 0.02 * given
    assert np.sqrt(np.mean(tilt.balance**2)) < 1e-3 * tilting
    drawn = tilt_figure(checked, tmp_path)
    assert "skew" in drawn.caption and len(drawn.curves) == 4


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "play"), [(0.1, 5.0), (0.02, 0.3)])
def test_energy_balances_where_rollers_skew_slide_and_meet_their_guides(friction, play):
    found = scene(
        {"slices": 21, "skew_play_mrad": play}, contact__friction_coefficient=friction,
        operation__misalignment_mrad=1.0, numerics__duration_ms=60.0,
    )  # fmt: skip
    samples = moved(found)
    assert np.abs(samples["guide_moment"]).max() > 0.0
    assert np.abs(samples["roller_skew"]).max() < 1e-3 * play * 1.03
    assert samples["work_dissipated"][-1] > samples["energy_contact"].max()
    assert missed(samples) < 1e-4


@pytest.mark.slow
def test_rollers_without_play_move_as_guided_ones():
    changes = {"operation__misalignment_mrad": 1.0, "contact__friction_coefficient": 1e-4}
    free, guided = (moved(scene(axial, **changes)) for axial in ({"skew_play_mrad": 0.0}, {"skew": "guided"}))
    assert 0.0 < np.abs(free["roller_skew"]).max() < 2e-7
    assert free["roller_tilt"] == pytest.approx(guided["roller_tilt"], abs=2e-3 * guided["roller_tilt"].max())
    assert free["inner_y"] == pytest.approx(guided["inner_y"], rel=1e-4)
    assert free["inner_moment"] == pytest.approx(guided["inner_moment"], abs=1e-3 * guided["inner_moment"].max())

"""Friction: Carter's creep, slips of patches, action and reaction of tractions, rollers that stick; dashpots."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal

from fem.elastic.continuum import Section, shear_compliance
from fem.interface import simulate
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.kernels.elements.friction import ALWAYS, WHERE_ROLLERS_TOUCH
from fem.kernels.elements.rings import HALO
from fem.kernels.fields import filled
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Shaft, conclude, kick_shaft, late_mass, push_mounted, settle
from lagrange.scene.scene import parse_scene
from tests.reference import compiled
from tests.reference.compiled import DT, creep_traction, find_slips, roller_field, rub
from tests.reference.continua import carter_creep
from tests.reference.kit import STEEL, copies, model, paper, whole_run, within
from tests.reference.modes import AROUND, receptance, sticking_modes
from tests.verification.runs import plan_of


def across(state):
    normal = np.moveaxis(state.contacts.patches.normal[:, :, :13], 1, 2)
    return np.stack([-normal[..., 1], normal[..., 0]], axis=-1)


def test_creep_follows_carter():
    """ξ = (μ b/R)(1 − sqrt(1 − T/(μP))); inner contact, μ = 0.1, 628 N: 3.897e-4 at T/(μP) = ½, 1.331e-3 at 1."""
    pair, force, mu = model(paper(), 2e-3).inner_law.pair, 628.0, 0.1
    b, R = pair.half_width(force), pair.relative_radius
    assert carter_creep(0.5, mu, b, R) == pytest.approx(3.897e-4, abs=3e-7)
    assert carter_creep(1.0, mu, b, R) == pytest.approx(1.331e-3, abs=1e-6)
    speed, rigid = 5.0, 1e-12  # a heavy patch: what slips before the step slips after it
    full = mu * b / R * speed
    for ratio in (0.01, 0.5, 0.9, 0.999):
        slip = carter_creep(ratio, mu, b, R) * speed
        assert creep_traction(slip, mu * force, full, rigid) == pytest.approx((ratio * mu * force, slip), rel=1e-6)
    for beyond in (1.0001, 3.0, 1e6):
        assert creep_traction(beyond * full, mu * force, full, rigid)[0] == pytest.approx(mu * force, rel=1e-12)


def test_creep_traction_solves_its_implicit_equation():
    rng = np.random.default_rng(5)
    for _ in range(2000):
        limit, full = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-5, 0)
        mobility = 10.0 ** rng.uniform(-6, 2) * full / limit  # k from far below to far above 1
        slip = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-4, 3) * full
        traction, left = creep_traction(slip, limit, full, mobility)
        assert 0.0 < abs(traction) <= limit * (1.0 + 1e-15)
        assert np.sign(traction) == np.sign(slip) == np.sign(left), "opposes slip and does not reverse it"
        x = min(abs(left) / full, 1.0)
        assert abs(traction) == pytest.approx(limit * (1.0 - (1.0 - x) ** 2), rel=1e-12)
        assert left + mobility * traction == pytest.approx(slip, rel=1e-12)
    assert creep_traction(0.0, 1.0, 1.0, 1.0) == (0.0, 0.0)
    limit, full, mobility = 60.0, 5e-3, 3e-5  # continuous where sliding sets in
    edge = full + mobility * limit
    assert_allclose(*(creep_traction(edge * (1.0 + e), limit, full, mobility) for e in (-1e-9, 1e-9)), rtol=1e-8)


def test_slip_is_the_sideways_speed_of_the_material():
    """Rigid bodies: v_roller + spin x arm − v_ring, whatever the node positions."""
    state, rng = compiled.random_state(2), np.random.default_rng(8)
    bodies, rollers, n = state.bodies, state.bodies.rollers, 13
    spin, velocity = 800.0 * rng.standard_normal(n), rng.standard_normal((n, 2))
    bodies.disc.u[:], bodies.inner.u[:], bodies.outer.u[:], state.drive.hub[:] = 0.0, 0.0, 0.0, 0.0
    rollers.spin[:n], rollers.velocity[:, :n] = spin, velocity.T
    points = bodies.disc.points.reshape(-1, 2)
    roller_field(state, bodies.disc.w)[:] = np.stack([-points[:, 1], points[:, 0]], axis=1)[:, :, None] * spin
    w = np.zeros((bodies.inner.radii.size, 2, bodies.inner.n_sectors))
    w[:, 1] = state.drive.speed * bodies.inner.radii[:, None]
    compiled.fill_ring(bodies.inner.w, w)
    pressed = compiled.press(state)
    for name in ("disc", "inner", "outer"):  # the push is taken off again
        getattr(pressed.bodies, name).w[:] = getattr(bodies, name).w
    pressed.bodies.rollers.velocity[:] = rollers.velocity
    found = np.zeros_like(pressed.contacts.friction.slip)
    find_slips(pressed, pressed.scratch.still, found)
    closed, along, r = pressed.contacts.forces.force[:, :n] > 0.0, across(pressed), rollers.radius
    wanted = np.einsum("kja,ja->kj", along, velocity) + np.array([[-r], [r], [-r]]) * spin
    wanted[INNER] -= state.drive.speed * 0.018
    other = np.roll(np.arange(n), -1)
    wanted[ROLLER] = np.sum(along[ROLLER] * (velocity[other] - velocity), axis=1) - r * (spin[other] + spin)
    within(found[:, :n][closed], wanted[closed], 1e-12 * np.abs(wanted[closed]).max())


@pytest.mark.parametrize("sprung", [False, True], ids=["solved", "springs"])
def test_tractions_are_on_carters_curve_at_the_creep_they_leave_and_take_what_bodies_lose(sprung):
    state = compiled.stretched_state() if sprung else compiled.with_friction(compiled.rubbing_state(), shear=None)
    rubbed, before, after, taken = rub(state)
    contacts, rollers = rubbed.contacts, rubbed.bodies.rollers
    tractions, closed, normals = contacts.friction.traction, contacts.forces.force > 0.0, contacts.patches.normal
    creep = contacts.friction.shear.creep if sprung else after
    laws, pitch = [pair.law for group in rubbed.groups for pair in group], 0.028 - 0.005
    assert closed.sum() > 8 and np.all(tractions[~closed] == 0.0)
    for kind, j in np.argwhere(closed):
        Q, traction, n, rolling = contacts.forces.force[kind, j], tractions[kind, j], normals[kind, :, j], 0.0
        if kind != ROLLER:
            orbit = (rollers.velocity[1, j] * n[0] - rollers.velocity[0, j] * n[1]) / pitch
            rolling = abs(rollers.spin[j] - orbit) * rollers.radius
        full = max(0.1 * np.sqrt(laws[kind].half_width_factor * Q) * laws[kind].curvature * rolling, 1e-4)
        share = min(abs(creep[kind, j]) / full, 1.0)
        if not sprung or abs(traction) < 0.1 * Q * (1.0 - 1e-12):  # what slides off a spring is no steady creep
            assert abs(traction) == pytest.approx(0.1 * Q * (1.0 - (1.0 - share) ** 2), rel=1e-6)
        assert abs(traction) <= 0.1 * Q * (1.0 + 1e-15) and traction * creep[kind, j] <= 0.0
        assert sprung or traction * before[kind, j] < 0.0 <= before[kind, j] * after[kind, j]
    lost = -np.sum((tractions * 0.5 * (before + after))[closed]) * DT
    assert taken == pytest.approx(lost, rel=1e-9)


def test_normal_impulses_given_with_the_tractions_do_what_they_do_given_before():
    first = compiled.pressed_state(3, 1e-3)
    first.contacts.friction.shear.stretch[:] = 1e-9
    assert first.contacts.forces.kick[ROLLER, 3] > 0.0
    find_slips(first, first.bodies.rollers.turn_kick, first.contacts.friction.slip)
    together = copies(first)
    compiled.push_surfaces(first)
    apart = compiled.rub_contacts(compiled.with_friction(first, whole=True))
    assert compiled.rub_contacts(together) == pytest.approx(apart, rel=1e-12)
    for what in (
        lambda state: state.bodies.disc.w, lambda state: state.bodies.inner.w[:, :, HALO:-HALO],
        lambda state: state.bodies.outer.w[:, :, HALO:-HALO], lambda state: state.bodies.rollers.node_impulse,
        lambda state: state.contacts.friction.traction, lambda state: state.drive.moment,
    ):  # fmt: skip
        within(what(together), what(first), 1e-12 * np.abs(what(first)).max())


@pytest.mark.slow  # compiles a loop
def test_a_coarse_rollers_contacts_are_solved_in_turn_only_while_rollers_touch():
    def tractions(touching, overlapping):
        state = compiled.with_friction(compiled.rubbing_state(mesh_size=2e-3), shear=None)
        bodies, forces = state.bodies, state.contacts.forces.force
        assert np.any(forces[ROLLER] > 0.0)
        for slow in (bodies.disc.w, bodies.rollers.velocity, bodies.rollers.spin, bodies.outer.w):
            slow[:] *= 1e-4  # so that contacts creep
        if not touching:
            forces[ROLLER] = 0.0
        return rub(compiled.with_friction(state, overlapping=overlapping))[0].contacts.friction.traction

    assert_array_equal(tractions(True, WHERE_ROLLERS_TOUCH), tractions(True, ALWAYS))
    assert_array_equal(tractions(False, WHERE_ROLLERS_TOUCH), tractions(False, None))
    assert np.abs(tractions(True, ALWAYS) - tractions(True, None)).max() > 1e-3


def test_friction_is_action_and_reaction_with_the_raceways_arm():
    state = compiled.stretched_state()
    rubbed, *_ = rub(state)
    closed = rubbed.contacts.forces.force[:, :13] > 0.0
    traction = rubbed.contacts.friction.traction[:, :13] * closed
    push, scale = traction[..., None] * across(rubbed), np.abs(traction).sum()
    impulse = rubbed.bodies.rollers.node_impulse
    wanted = push[INNER] + push[OUTER] + np.roll(push[ROLLER], 1, axis=0) - push[ROLLER]
    within(impulse[:, :13].T / DT, wanted, 1e-12 * scale)
    gained = copies(rubbed)
    bodies, drive = gained.bodies, gained.drive
    for name in ("disc", "inner", "outer"):
        getattr(bodies, name).w[:] -= getattr(state.bodies, name).w
    round_off = 1e-9 * scale * DT  # velocities of metres per second change by micrometres per second
    within(compiled.roller_resultants(gained), impulse[:, :13].T, round_off)
    within(compiled.cartesian_resultant(bodies.inner, *drive.frame[1:]), -push[INNER].sum(axis=0) * DT, round_off)
    within(compiled.cartesian_resultant(bodies.outer), -push[OUTER].sum(axis=0) * DT, round_off)
    # moment about a roller's centre: traction times radius
    points, force = bodies.disc.points.reshape(-1, 2), roller_field(gained, bodies.disc.w) / DT
    force = force * bodies.disc.mass[:, None, None]
    moment = np.sum(points[:, :1] * force[:, 1] - points[:, 1:] * force[:, 0], axis=0)
    arm = bodies.rollers.radius * traction
    within(moment, arm[OUTER] - arm[INNER] - arm[ROLLER] - np.roll(arm[ROLLER], 1), 1e-9 * scale * 0.005)
    assert np.all(bodies.rollers.turn_kick == 0.0) and drive.moment[0] == 0.0
    on_ring = np.sum(bodies.inner.w[:, 1, HALO:-HALO] * (bodies.inner.row_mass * bodies.inner.radii)[:, None]) / DT
    assert on_ring == pytest.approx(-0.018 * np.sum(traction[INNER]), abs=1e-9 * scale * 0.018)


# Rollers that stick to both raceways: tangential springs against the exact vibration of discs between rings

SLOW = 1e3  # rad/s; harmonics of some 100 kHz give way by 1e-5 more than at rest
DISC, RINGS = (0.005, 0.0), ((0.018, 0.0125), (0.028, 0.0325))


@pytest.mark.parametrize(("radii", "waves"), [(DISC, (0, 1, 2, 3, 8)), *((ring, (0, 1, 2, 13, 26)) for ring in RINGS)])
def test_receptances_are_static_compliances_of_what_moves_slowly_and_a_disc_moves_as_a_rigid_one(radii, waves):
    """Traction sin nθ: moment 2πR² of a uniform one on ½mR², force πR of one that varies once around on m."""
    section, mass = Section(*radii, STEEL), STEEL.density * np.pi * 0.005**2
    rigid = {0: 2.0 * np.pi * 0.005**3 / (0.5 * mass * 0.005**2 * SLOW**2), 1: np.pi * 0.005 / (mass * SLOW**2)}
    for n in waves:
        static = shear_compliance(section, np.array([n]))[0]
        more = receptance(section, n, SLOW, AROUND) - static
        if radii == DISC and n in rigid:
            assert more == pytest.approx(-rigid[n], rel=1e-5)
        else:
            assert abs(more) < 1e-4 * static


@pytest.mark.parametrize(("mesh_size_mm", "limit"), [(2.0, 5e-3), pytest.param(1.0, 1.5e-3, marks=pytest.mark.slow)])
def test_rollers_that_stick_rock_and_shift_at_the_exact_frequencies(mesh_size_mm, limit):
    """A bearing with preload and without load stands; all its rollers are given a little spin, 0.05 rad/s.

    Shifting is seen in how the rollers go round, rocking in their spin. Without tangential springs frequencies are 10
    to 40 % too high, and fall with the mesh.
    """
    plan = plan_of(
        numerics__mesh_size_mm=mesh_size_mm, numerics__duration_ms=0.4, numerics__output_interval_us=1.0,
        bearing__outer_raceway_diameter_mm=55.993, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
        operation__speed_rpm=0.0, contact__friction_coefficient=0.5,
    )  # fmt: skip
    found = whole_run(replace(plan, start=replace(plan.start, kinematics=replace(plan.start.kinematics, roller=0.05))))
    wanted = sticking_modes(plan.model.bearing, float(plan.start.equilibrium.inner_force.mean()), 40e3, 75e3)
    around, padded, peaks = found["roller_theta"][:, 0], 2**20, []  # for peaks finer than the run is long
    for signal, low, high in ((np.diff(around), 35e3, 65e3), (found["roller_spin"][:, 0], 65e3, 110e3)):
        size = np.abs(np.fft.rfft(signal * np.hanning(signal.size), padded))
        frequency = np.fft.rfftfreq(padded, plan.interval)
        peaks.append(frequency[np.argmax(size * ((frequency > low) & (frequency < high)))])
    assert len(wanted) == 2
    assert_allclose(peaks, wanted, rtol=limit)


# Dashpots of shaft and housing to the ground, under forces that are found after theirs

STEP, MASS, DAMPING, STIFFNESS = 4e-7, 7.6e-4, 300.0, 1e6
FIRST, LATER = np.array([40.0, -7.0]), np.array([-9.0, 25.0])  # N
ASKING, UNKNOWING, HEAVIER = range(3)  # how forces are given that are found after the dashpots'
LATE_MASS = late_mass(MASS, DAMPING, STEP)


@njit(**OPTIONS)
def shake(shaft, first, later, how):
    for k in range(2):
        shaft.velocity[k] += STEP / MASS * first[k]
    kick_shaft(shaft, STEP, shaft.place[0], shaft.place[1])
    if how == ASKING:
        push_mounted(shaft, shaft.velocity, MASS, later[0], later[1], STEP)
        return
    for k in range(2):
        shaft.velocity[k] += STEP / (MASS if how == UNKNOWING else LATE_MASS) * later[k]
    if how == UNKNOWING:
        settle(shaft, STEP)
    else:
        conclude(shaft)


@pytest.mark.parametrize("how", [ASKING, UNKNOWING, HEAVIER], ids=["asking", "unknowing", "heavier"])
def test_the_dashpots_force_is_that_of_the_mean_of_the_velocities_before_and_after_all_forces(how):
    """M (v₁ − v₀)/dt = F − k x − ½ c (v₀ + v₁), solved by hand."""
    v0, place, half = np.array([0.02, -0.03]), np.array([3e-6, -5e-6]), 0.5 * DAMPING
    how_held = {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING, "column": 0}
    shaft = filled(Shaft, {}, place=place, velocity=v0.copy(), before=v0.copy(), slowed=np.zeros((2, 2)), **how_held)
    shake(shaft, FIRST, LATER, how)
    wanted = ((MASS / STEP - half) * v0 + FIRST + LATER - STIFFNESS * place) / (MASS / STEP + half)
    assert_allclose(shaft.velocity, wanted, rtol=1e-13)
    assert_allclose(shaft.drag, -half * (v0 + wanted), rtol=1e-13)


@pytest.mark.slow
def test_contact_dampers_and_a_shaft_s_dashpots_leave_a_light_hub_in_balance():
    """What the run's own forces leave of its equations; 0.3 % of the largest where dashpots knew no later forces."""
    found = simulate(parse_scene({
        "model": "reduced", "damping": {"contact_time_us": 25.0},
        "operation": {"inner_ring_and_shaft_kg": 0.05, "shaft": "springs", "shaft_stiffness_N_per_m": 1e7,
                      "shaft_damping_N_s_m": 2e4, "rotating_load_N": 300.0},
        "numerics": {"duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 2.0},
    }, ""))  # fmt: skip
    largest = np.max(found["inner_force"])
    assert np.max(np.abs(found["inner_damping_force"])) > 0.02 * largest
    for direction in found.residual().directions:
        assert np.max(np.abs(direction.budget.terms["ring_flexibility"])) < 1e-4 * largest

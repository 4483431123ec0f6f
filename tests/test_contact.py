"""Normal contact forces: the gradient of one potential, action and reaction; springs that stick; contact models."""

from dataclasses import replace
from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.interpolate import BSpline

from fem.contacts import MODELS, points
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.resolved import FacetedModel, PenaltyModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.surfaces import CORNER, chord
from fem.kernels.lanes import WIDTH
from fem.kernels.law import STEEPEST, contact_force
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan
from fem.statics import exact_statics
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.scene.run import STIFF_PENALTY, ContactTable
from lagrange.scene.scene import parse_scene
from tests.reference import compiled, kit
from tests.reference.compiled import DT, press, random_state, roller_field, set_turns
from tests.reference.continua import impact_on_rigid_flat
from tests.reference.kit import LENGTH, ON_A_ROLLER, STEEL, copies, model, paper, within
from tests.verification.rolling import OBLIQUE
from tests.verification.runs import WIDE, collide

ALONE = ("roller u", "centre", "turn", "inner u", "outer u", "hub", "ring turn")


class Motion:
    """A direction of motion in every coordinate the contacts know; zero unless asked for."""

    def __init__(self, state, seed, kinds):
        rng, bodies = np.random.default_rng(seed), state.bodies
        n, nodes = bodies.rollers.n, bodies.disc.mass.size

        def draw(kind, scale, *shape):
            return scale * rng.standard_normal(shape) * (kind in kinds)

        self.roller_u, self.centre = draw("roller u", 1.0, nodes, 2, n), draw("centre", 1.0, n, 2)
        self.turn = draw("turn", 1.0 / 0.005, n)
        self.inner_u = draw("inner u", 1.0, *bodies.inner.u[:, :, HALO:-HALO].shape)
        self.outer_u = draw("outer u", 1.0, *bodies.outer.u[:, :, HALO:-HALO].shape)
        self.hub, self.ring_turn = draw("hub", 1.0, 2), float(draw("ring turn", 1.0 / 0.018, 1)[0])

    def moved(self, state, step):
        state = copies(state)
        bodies, n = state.bodies, state.bodies.rollers.n
        roller_field(state, bodies.disc.u)[:] += step * self.roller_u
        bodies.rollers.centre[:, :n] += step * self.centre.T
        set_turns(state, bodies.rollers.turn[:n] + step * self.turn, state.drive.frame[0] + step * self.ring_turn)
        for field, rate in ((bodies.inner.u, self.inner_u), (bodies.outer.u, self.outer_u)):
            compiled.fill_ring(field, field[:, :, HALO:-HALO] + step * rate)
        state.drive.hub[:] += step * self.hub
        return state

    def power(self, state):
        """Power of all forces that contacts exert, as the time loop applies them, W."""
        pressed = press(state)
        bodies, rollers, n = pressed.bodies, pressed.bodies.rollers, pressed.bodies.rollers.n
        force = roller_field(pressed, bodies.disc.w) * bodies.disc.mass[:, None, None] / DT  # in the frames
        c, s, (x, y) = rollers.cosine[:n], rollers.sine[:n], self.centre.T
        position = bodies.disc.points.reshape(-1, 2, 1) + roller_field(pressed, bodies.disc.u)
        turned = np.stack([-position[:, 1], position[:, 0]], axis=1) * self.turn
        total = np.sum(force * (self.roller_u + np.stack([c * x + s * y, c * y - s * x])[None] + turned))
        total += np.sum(rollers.body_impulse[:, :n].T * self.centre) / DT
        total += rollers.inertia * (rollers.turn_kick[:n] @ self.turn) / DT
        for ring, rate, spin in ((bodies.inner, self.inner_u, self.ring_turn), (bodies.outer, self.outer_u, 0.0)):
            place = ring.u[:, :, HALO:-HALO].copy()
            place[:, 0] += ring.radii[:, None]
            moved = rate + spin * np.stack([-place[:, 1], place[:, 0]], axis=1)
            total += np.sum(ring.w[:, :, HALO:-HALO] * ring.row_mass[:, None, None] / DT * moved)
        total += pressed.drive.impulse @ self.hub / DT
        # what the drive must hold against the contacts is what they exert on the frame, reversed
        return total - pressed.drive.moment[0] * self.ring_turn


@pytest.mark.parametrize("seed", [1, 2, 3, "resolved"])
@pytest.mark.parametrize("kinds", [*((kind,) for kind in ALONE), ALONE], ids=[*ALONE, "all together"])
def test_contact_forces_are_the_gradient_of_the_contact_energy(kinds, seed):
    resolved = seed == "resolved"
    state = random_state(4, resolved=True) if resolved else random_state(seed)
    motion = Motion(state, 104 if resolved else 100 + seed, kinds)
    pressed = press(state)
    force, rollers = pressed.contacts.forces.force, pressed.bodies.rollers
    assert (force[INNER] > 0.0).sum() >= 4 and (force[OUTER] > 0.0).sum() >= 4 and force[ROLLER, 3] > 0.0
    # forces at fixed patches alone miss the potential by the tilt of the surfaces, which is seen
    tilts = rollers.body_impulse, rollers.turn_kick * rollers.inertia / 0.005, pressed.drive.impulse
    assert resolved or min(np.abs(tilt).max() for tilt in tilts) / DT > 1e-5 * force.sum()
    found, total = motion.power(state), force.sum()

    def slope(step):
        sides = [press(motion.moved(state, s)) for s in (step, -step)]
        for side in () if resolved else sides:
            assert_array_equal(side.contacts.forces.force > 0.0, force > 0.0, "no contact opens on the way")
        ahead, behind = map(compiled.contact_energy, sides)
        return -(ahead - behind) / (2.0 * step)

    if resolved:
        # points that open within the step leave an error of first order in it; the chord's end a moment of spacing³
        wanted, error, least = slope(1e-11), 1e-6, 1e-4
    else:
        # fourth order; measured error 2e-10 of the sum of Q, mostly round-off; a patch's first moment is exact to
        # spacing⁷/5040 only: 2e-10 rad of Q·r, seen when a roller turns alone
        near, far = slope(2e-9), slope(4e-9)
        wanted, error, least = near + (near - far) / 3.0, 1e-9, 1e-6
    assert found == pytest.approx(wanted, rel=0.0, abs=error * total)
    assert abs(found) > least * total, "the comparison says something"


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", [INNER, OUTER, ROLLER], ids=["inner", "outer", "roller"])
def test_normal_forces_are_action_and_reaction(kind, seed):
    state, fresh = copies(random_state(seed)), random_state(seed)
    rollers, contacts, drive = state.bodies.rollers, state.contacts, state.drive
    alone = replace(state, groups=(((*state.groups[0], *state.groups[1])[kind : kind + 1]),))
    compiled.press_contacts(alone)
    compiled.push_surfaces(alone)
    Q, normal = contacts.forces.force[kind, :13], contacts.patches.normal[kind, :, :13].T
    scale, impulse, tilt = Q.sum() * DT, rollers.node_impulse[:, :13].T, rollers.body_impulse[:, :13].T
    state.bodies.disc.w[:] -= fresh.bodies.disc.w
    state.bodies.inner.w[:] -= fresh.bodies.inner.w
    # the roller's centre gets what its nodes get; the force is Q along the line of centres, tilt apart
    within(compiled.roller_resultants(state), impulse, 1e-12 * scale)
    push = Q[:, None] * normal * DT
    within(impulse, (push, -push, np.roll(push, 1, axis=0) - push)[kind], 1e-13 * scale)
    # nodes push nodes, and the tilt of both surfaces pushes both bodies (of the outer ring: the ground)
    rings = compiled.cartesian_resultant(state.bodies.outer)
    rings += compiled.cartesian_resultant(state.bodies.inner, *drive.frame[1:])
    within(impulse.sum(axis=0) + rings, 0.0, 1e-11 * scale)
    assert np.abs(tilt).max() > 1e-6 * scale
    assert kind == OUTER or np.abs(tilt.sum(axis=0) + drive.impulse).max() < 1e-15 * scale
    assert kind == ROLLER or np.abs(np.sum(tilt * normal, axis=1)[Q > 0.0]).max() < 1e-15 * scale  # across the line


def test_spare_lanes_that_sit_on_a_roller_add_nothing():
    """Thirteen rollers are two groups of eight: the last three lanes stand where roller 0 is."""
    state = random_state(1)
    rollers = state.bodies.rollers
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    assert press(state).contacts.forces.force[ROLLER, 3] > 0.0
    angle = np.arctan2(*rollers.centre[::-1, 12]) + 2.0 * np.arcsin(0.2174)  # 12 and 0 touch: in the last group
    rollers.centre[:, 0] = 0.023 * np.cos(angle), 0.023 * np.sin(angle)
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    pressed = press(state)
    assert pressed.contacts.forces.force[ROLLER, 12] > 0.0
    bodies = pressed.bodies
    for entry in (bodies.rollers.node_impulse, bodies.rollers.body_impulse, bodies.rollers.turn_kick, bodies.disc.w):
        assert np.all(np.isfinite(entry))


# The contact law itself: force, energy and stiffness of one potential, and what a kick of the time loop gives


@pytest.fixture(params=["inner", "outer", "roller"])
def law(request):
    return getattr(model(paper(), 2e-3), f"{request.param}_law")


def force_of(law, approach):
    return contact_force(approach, law.A, law.B, law.Q_line, 0.0)


def stored_approach(law, force, level):
    """δ = A Q (B − ½ ln Q), and the straight line above Q_line, m."""
    q = min(force, law.Q_line)
    bracket = level - 0.5 * np.log(q)
    return law.A * (q * bracket + (force - q) * (bracket - 0.5))


def test_contact_forces_invert_the_approach_and_level_whatever_the_last_was(law):
    """Tiny, usual and wild changes, with the ripple moving too; forces above Q_line and contacts that open or close."""
    rng = np.random.default_rng(5)
    for before in np.concatenate([np.geomspace(1e-9, 0.999, 40), [1.0, 1.5, 30.0]]) * law.Q_line:
        approach = float(law.approach(before))
        for guess in (0.0, before, 0.1 * before, 7.0 * before, 1e9):
            # Newton stops at 1e-14 of Q; dQ/Q = dδ/δ times at most 3 (bracket over bracket − ½)
            assert contact_force(approach, law.A, law.B, law.Q_line, guess) == pytest.approx(before, rel=3e-13)
        for change in (0.0, 1e-12, 1e-6, -1e-3, 0.05, -0.3, 1.0, 40.0):
            level_before, level = law.B + 0.05 * rng.uniform(-1.0, 1.0, 2)
            known, force = stored_approach(law, before, level_before), before * (1.0 + change)
            approach = stored_approach(law, force, level)
            for last in ((before, known), (0.0, np.nan), (0.0, -1e-6)):
                found = compiled.next_force(approach, law.A, level, law.Q_line, *last, level_before)
                assert found == pytest.approx(force, rel=1e-12)
            assert compiled.next_force(-1e-9, law.A, level, law.Q_line, before, known, level_before) == 0.0
        assert np.isnan(compiled.next_force(np.nan, law.A, law.B, law.Q_line, before, known, level_before))
    assert all(force_of(law, approach) == 0.0 for approach in (0.0, -1e-20, -1e-6, -1.0)), "never pulls"


@pytest.mark.parametrize("ripple", [-0.05, 0.0, 0.05])
def test_the_law_has_one_potential_and_one_stiffness_wherever_the_contact_sits(law, ripple):
    """Also above Q_line, where a heavy impact may come: force is the slope of energy in approach, ½ A Q² that in B."""
    level = law.B + ripple

    def force(approach, level=level):
        return contact_force(approach, law.A, level, law.Q_line, 0.0)

    def energy(approach, level=level):
        return compiled.stored_energy(force(approach, level), approach, law.A, law.Q_line)

    def slope(of, at, step):
        return (of(at + step) - of(at - step)) / (2.0 * step)

    at_line = stored_approach(law, law.Q_line, level)
    assert energy(0.0) == 0.0
    assert force(at_line * (1.0 - 1e-12)) == pytest.approx(force(at_line * (1.0 + 1e-12)), rel=1e-10)
    for approach in at_line * np.array([0.01, 0.5, 0.99, 1.01, 1.5, 3.0]):
        Q = force(approach)
        assert slope(energy, approach, 1e-4 * approach) == pytest.approx(Q, rel=1e-6)
        in_level = slope(lambda level, at=approach: energy(at, level), level, 1e-5)
        assert in_level == pytest.approx(-0.5 * law.A * Q**2, rel=1e-6)
        parts = (0.0, min(approach, at_line), approach)
        work = sum(quad(force, *ends, epsabs=0.0, epsrel=1e-11)[0] for ends in pairwise(parts))
        assert energy(approach) == pytest.approx(work, rel=1e-8)
    step = 1e-6 * law.Q_line
    below, at, above = law.approach(law.Q_line + step * np.array([-1.0, 0.0, 1.0]))
    assert stored_approach(law, law.Q_line, law.B) == pytest.approx(float(at), rel=1e-13)
    # one-sided differences: error step · A/(4 Q), 1e-6 of the slope; and the round-off 1e-16/1e-6
    assert (at - below) / step == pytest.approx(law.A * STEEPEST, rel=1e-5)
    assert (above - at) / step == pytest.approx(law.A * STEEPEST, rel=1e-8)
    for known in law.Q_line * np.array([1e-6, 1e-3, 0.3, 1.2]):
        place = float(law.approach(known))
        assert law.stiffness(known) == pytest.approx(slope(lambda d: force_of(law, d), place, 1e-5 * place), rel=1e-8)


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


def test_a_mass_bounces_off_with_nearly_the_speed_it_came_with():
    """Steps of 1/10 ... 1/80 of the time to the nearest point, beginning anywhere: fourth order and without a jump."""
    law, mass, speed = model(paper(), 2e-3).inner_law, 0.006, 0.1
    counts, lost = np.array([10.0, 20.0, 40.0, 80.0]), {}
    for name, kick in (("ours", compiled.kick_force), ("usual", lambda law, last, now: (now[1], 0.0))):
        steps = 0.5 * np.pi * np.sqrt(mass / law.stiffness(200.0)) / counts
        gaps = [speed * dt * (3.0 + np.linspace(0.0, 0.9, 10)) for dt in steps]
        away = [[bounce(law, mass, speed, dt, gap, kick) for gap in some] for dt, some in zip(steps, gaps, strict=True)]
        lost[name] = 1.0 - np.array(away) / speed
    ours = lost["ours"]
    assert np.polyfit(np.log(counts), np.log(ours.mean(axis=1)), 1)[0] == pytest.approx(-4.0, abs=0.2)
    assert np.all(np.abs(ours).max(axis=1) < 0.003 * np.abs(lost["usual"]).max(axis=1)) and ours[0].max() < 5e-6


@pytest.mark.parametrize("dt", [3e-7, 3e-5], ids=["light", "beyond the line"])
@pytest.mark.parametrize("inwards", [True, False], ids=["closing", "opening"])
def test_at_constant_speed_kicks_add_up_to_the_true_impulse(inwards, dt):
    """The half of a kick that looks back and the half of the one before that looks ahead, step by step."""
    law, speed = model(paper(), 2e-3).inner_law, 1.0
    approach = (speed * dt * (np.arange(-4, 8) + 0.31))[:: 1 if inwards else -1]
    force, kicks = np.array([force_of(law, x) for x in approach]), []
    for i in range(1, len(approach)):
        last = approach[i - 1], force[i - 1], law.B, force[i - 1], 0.0  # nothing owed, so nothing is given back
        kicks.append(compiled.kick_force((law.A, law.Q_line), last, (approach[i], force[i], law.B))[0])
    kicks = np.array(kicks)
    stored = compiled.stored_energy(force.max(), approach.max(), law.A, law.Q_line)
    assert dt * (0.5 * force[0] + np.sum(kicks) - 0.5 * force[-1]) == pytest.approx(stored / speed, rel=1e-9)
    assert (kicks.min() < 0.0) != inwards  # the first after an opening takes back what the one before gave too much
    assert np.all(kicks[approach[1:] > 0.0] > 0.0)


def test_the_line_is_far_above_the_papers_loads_and_kernels_have_the_pairs_of_the_laws():
    assert min(law.Q_line for law in model(paper(), 1e-3).laws[:2]) > 10.0 * 628.5
    for found in (model(paper(), 2e-3), of_springs(1e8, False)):  # the kernels' friction needs the same pairs
        for law, known in zip(found.laws, found.kernel_data(650.0).laws, strict=True):
            assert known.half_width_factor == law.pair.half_width_factor
            assert known.curvature * law.pair.relative_radius == pytest.approx(1.0, rel=1e-15)


# Contact models: each of a scene's names has one, none solves statics twice


@pytest.mark.parametrize(("contact", "mesh_size", "modulus", "kind", "statics"), [
    ("subgrid", 2.0, 210.0, SubgridModel, 0), ("subgrid", 0.6, 5.0, SpreadModel, 1),
    ("subgrid", 0.9, 5.0, SubgridModel, 1),  # more than twice as coarse as the half-width of 0.43 mm
    ("penalty", 2.0, 210.0, PenaltyModel, None), ("faceted", 2.0, 210.0, FacetedModel, None),
])  # fmt: skip
def test_a_scene_gets_its_model_and_exact_statics_are_solved_once_at_most(
    contact, mesh_size, modulus, kind, statics, monkeypatch
):
    assert set(MODELS) == set(get_args(ContactTable.model_fields["model"].annotation))
    numerics = {"mesh_size_mm": mesh_size, "duration_ms": 0.0}
    scene = {"contact": {"model": contact}, "numerics": numerics, "material": {"youngs_modulus_GPa": modulus}}
    scene, calls, solve = parse_scene(scene, "test"), [], exact_statics.exact_statics
    monkeypatch.setattr(exact_statics, "exact_statics", lambda *args: calls.append(args) or solve(*args))
    assert type(model_of(scene)) is kind
    assert scene.contact.penalty_stiffness_N_per_m == (STIFF_PENALTY if contact in ("penalty", "faceted") else None)
    if statics is not None:
        calls.clear()
        make_plan(scene)
        assert len(calls) == statics


# Tangential springs of contacts that stick: in series with creep, vibrating, dragged along, calibrated


class OneSpring:
    """Eight alike, on contacts of given compliance, m/N; `pulled` moves on by a slip, m/s."""

    def __init__(self, soft: float, dt: float, limit: float, full_slip: float):
        self.state, self.dt, self.how = copies(compiled.rubbing_state()), dt, (limit, full_slip)
        contacts, self.pair = self.state.contacts, self.state.groups[0][0]
        self.friction, self.shear = contacts.friction, contacts.friction.shear
        self.shear.stretch[:] = self.shear.creep[:] = 0.0
        self.shear.since[:] = dt
        # so that the law gives this compliance
        contacts.forces.force[:], contacts.forces.approach[:], contacts.forces.bracket[:] = 1.0, 0.0, 0.0
        self.shear.level[:] = soft / self.pair.law.A
        self.shear.compliance[:] = soft

    def pulled(self, slip: float) -> float:
        """Traction, N, after a step."""
        self.friction.slip[:] = self.friction.slip_left[:] = slip
        compiled.follow_slips(self.shear, self.state.contacts.forces, self.friction, self.dt, WIDTH)
        compiled.pull_spring(self.shear, self.state.contacts, self.pair, self.dt, *self.how)
        return self.shear.stretch[0, 0] / self.shear.compliance[0, 0]


@pytest.mark.parametrize("per_period", [10, 40])
def test_a_mass_on_a_spring_that_sticks_vibrates_without_loss_and_with_leapfrogs_period(per_period):
    """sin(ω̂ dt/2) = ω dt/2."""
    mass, soft = 2e-3, 2e-9
    omega = np.sqrt(1.0 / (mass * soft))
    dt = 2.0 * np.pi / omega / per_period
    spring = OneSpring(soft, dt, 1e12, 1e-6)
    place, velocity, places, totals, traction = 0.0, 1.0, [], [], 0.0
    for _ in range(5 * per_period):
        places.append(place)
        last, velocity = velocity, velocity - dt / mass * traction
        totals.append(0.5 * mass * last * velocity + compiled.spring_energy(spring.shear, WIDTH) / (3 * WIDTH))
        place += dt * velocity
        traction = spring.pulled(velocity)
    turned = 2.0 * np.arcsin(0.5 * omega * dt) * np.arange(len(places))
    amplitude = places[1] / np.sin(turned[1])
    within(places, amplitude * np.sin(turned), 1e-6 * amplitude)
    assert np.ptp(totals) < 1e-6 * totals[0]


def test_a_contact_dragged_along_is_stretched_until_it_slides_steadily_and_then_springs_back():
    soft, limit, dt, speed = 2e-9, 60.0, 1e-7, 0.1
    spring, tractions, creeps = OneSpring(soft, dt, limit, 1e-4), [], []
    for step in range(60):
        tractions.append(spring.pulled(speed if step < 40 else -speed))
        creeps.append(spring.shear.creep[0, 0])
    elastic = speed * dt / soft  # 5 N a step: 12 steps up to the limit
    assert_allclose(tractions[:10], elastic * np.arange(1, 11), rtol=0.05)
    assert np.all(np.array(tractions[14:40]) == pytest.approx(limit, rel=1e-12)), "and does not swing from step to step"
    assert_allclose(creeps[15:40], speed, rtol=1e-9)
    assert_allclose(tractions[40:45], limit - elastic * np.arange(1, 6), atol=elastic)
    state = compiled.rubbing_state()
    state.check()
    state.contacts.friction.shear.compliance[OUTER, 2] = 0.0
    with pytest.raises(ValueError, match="without a compliance"):
        state.check()


def test_tractions_push_the_nodes_that_the_springs_are_calibrated_with():
    state = compiled.stretched_state()
    rubbed, *_ = compiled.rub(state)
    whole, traction, patches = model(paper(), 1e-3), rubbed.contacts.friction.traction, rubbed.contacts.patches
    scale, forces = np.abs(traction).sum(), rubbed.contacts.forces.force
    names = "inner", "outer", "disc"
    gained = {name: getattr(rubbed.bodies, name).w - getattr(state.bodies, name).w for name in names}
    for name, kind, turn in (("inner", INNER, rubbed.drive.frame[0]), ("outer", OUTER, 0.0)):
        body, angle = getattr(whole, f"{name}_ring"), np.arctan2(*patches.normal[kind, ::-1, :13]) - turn
        pushes = (T * points.patch_traction(body, a) for T, a in zip(traction[kind, :13], angle, strict=True))
        found = gained[name][:, :, HALO:-HALO] * (body.row_mass / DT)[:, None, None]
        within(found, -sum(pushes), 1e-8 * scale)
    wanted = np.zeros((13, 2 * whole.roller.n_nodes))
    for kind in (INNER, OUTER, ROLLER):
        for j in np.flatnonzero(forces[kind, :13]):
            around = -traction[kind, j] * (-1.0 if kind == OUTER else 1.0)
            for i, row in [(j, 4), ((j + 1) % 13, 5)] if kind == ROLLER else [(j, 2 * kind + 1)]:
                at = np.arctan2(*patches.outward[row, ::-1, j])
                wanted[i] += around * points.patch_traction(whole.roller, at)
    found = roller_field(rubbed, gained["disc"]) * rubbed.bodies.disc.mass[:, None, None] / DT
    within(np.moveaxis(found, 2, 0).reshape(13, -1), wanted, 1e-8 * scale)


# Two rollers that collide, with and without friction: momenta, energy, and the order of its error


def test_reference_impact_is_the_quasi_static_one():
    """A roller of 5 mm by 10 mm on a rigid frictionless flat with Johnson's approach (1985, eq. 5.57)."""
    for speed, *wanted in ((0.1, 0.333e-6, 193.0, 10.34e-6), (1.0, 3.008e-6, 2156.0, 9.31e-6)):
        found = impact_on_rigid_flat(speed, 0.005, LENGTH, paper().roller_mass, STEEL.plane_strain_modulus)
        within((np.array(found) - wanted) / (5e-10, 0.5, 6e-9), 0.0, 1.0)


def energy_and_loss(found):
    """Energy and what friction has dissipated up to the same instant, half a step's share at the last."""
    return found.energy.sum(axis=1) + np.cumsum(found.dissipated) - 0.5 * found.dissipated


@pytest.mark.parametrize(("spins", "friction"), [
    ((0.0, 0.0), 0.0), ((800.0, -300.0), 0.0), ((800.0, 500.0), 0.1), ((800.0, 500.0), 0.5)
])  # fmt: skip
def test_a_collision_keeps_momenta_and_loses_what_it_dissipates(spins, friction):
    found = collide(OBLIQUE, spins=spins, **({"friction": friction, "courant": 0.25} if friction else {}))
    within(found.momentum, WIDE.roller_mass * np.tile(np.sum(OBLIQUE, axis=0), (len(found.force), 1)),
           1e-13 * WIDE.roller_mass)  # fmt: skip
    # what the patch's moment misses, spacing⁷/5040; tractions act at both circles' radii while these overlap by 2 µm:
    # arms differ by 2e-4 at the very most
    assert np.ptp(found.angular_momentum) < (2e-4 if friction else 1e-10) * abs(found.angular_momentum[0])
    energy = energy_and_loss(found)
    assert np.ptp(energy) < 2e-4 * energy[0]  # the contact's corner, O(dt²) of its share
    assert found.force.max() > 1000.0 and np.all(np.abs(found.traction) <= friction * found.force * (1.0 + 1e-14))
    if friction:
        assert_allclose(energy, energy[0], rtol=5e-5)  # as without friction; measured 2.6e-5
        assert np.all(found.dissipated >= 0.0) and found.dissipated.sum() > 0.1 * energy[0]
    else:
        assert energy[-1] == pytest.approx(energy[0], rel=2e-5) and not found.dissipated.any()


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_collisions_energy_error_shrinks_with_the_square_of_the_step(friction):
    courant, how = np.array([0.4, 0.2, 0.1, 0.05]), {"spins": (800.0, -300.0), "friction": friction}
    energies = [energy_and_loss(collide(OBLIQUE, courant=float(c), **how)) for c in courant]
    error = [np.ptp(energy) / energy[0] for energy in energies]
    # less than 2 by where the contact opens between two steps; measured 1.84
    assert np.polyfit(np.log(courant), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.3)
    assert error[-1] < 2e-6


# Patches of nodes that a contact reads and pushes: weights, places, and kernels against matrices


@pytest.mark.parametrize("n", [18, 56])
def test_a_direction_gets_its_place_among_the_nodes(n):
    for position in (0.0, 0.25, n / 2.0, n - 0.5, n - 1e-9):
        angle = 2.0 * np.pi * position / n
        found = compiled.place(0.3 * np.cos(angle), 0.3 * np.sin(angle), n)
        assert min(abs(found - position), n - abs(found - position)) < 1e-13 * n and 0.0 <= found < n
    for tiny in (1e-300, 1e-20, 1e-16):  # just below the first node: adding n rounds up to n
        assert 0.0 <= compiled.place(1.0, -tiny, n) < n
    nodes, weight, offset = points.patch(18, 2.0 * np.pi * 17.4 / 18.0)
    assert nodes.tolist() == [15, 16, 17, 0, 1, 2], "patches wrap round the body"
    spline = BSpline.basis_element(np.arange(7) - 3.0, extrapolate=False)  # Schoenberg's quintic
    for position in 17.0 + np.append(np.linspace(0.0, 0.95, 20), 1.0 - 1e-9):
        _, weight, offset = points.patch(18, 2.0 * np.pi * position / 18.0)
        assert_allclose(weight, np.nan_to_num(spline(offset * 18.0 / (2.0 * np.pi))), rtol=0.0, atol=1e-14)
        assert weight.sum() == pytest.approx(1.0, abs=3e-16) and weight @ offset == pytest.approx(0.0, abs=1e-15)


# Contacts as other programs have them on a coarse mesh: penalty springs between circles, or between facets


def of_springs(stiffness, faceted):
    return (FacetedModel if faceted else PenaltyModel).build(paper(), 2e-3, stiffness=stiffness)


def test_sagittas_are_those_of_the_meshes_own_chords():
    """h²/8R, to its own relative error h²/R²/48; in a bore the chord lies on the other side of the circle."""
    found = of_springs(STIFF_PENALTY, faceted=True)
    surface = found.roller.points[found.roller.first_surface_node :]
    inside = found.inner_ring.points.reshape(found.inner_ring.n_rows, -1, 2)[-1]
    bore = found.outer_ring.points.reshape(found.outer_ring.n_rows, -1, 2)[0]
    for law, side, nodes, sign in (
        (found.inner_law, 0, inside, 1.0), (found.outer_law, 0, bore, -1.0),
        (found.inner_law, 1, surface, 1.0), (found.outer_law, 1, surface, 1.0), (found.roller_law, 0, surface, 1.0),
    ):  # fmt: skip
        middle = 0.5 * (nodes + np.roll(nodes, -1, axis=0))
        below = np.hypot(*nodes.T).mean() - np.hypot(*middle.T)
        assert_allclose(below, sign * law.sagitta[side], rtol=6e-3)
    assert of_springs(STIFF_PENALTY, faceted=False).inner_law.sagitta == (0.0, 0.0)
    depth, slope = np.transpose([chord(t) for t in (np.arange(20_000) + 0.5) / 20_000])
    assert depth.max() == pytest.approx(chord(0.5)[0]) and depth.max() == pytest.approx(1.0, abs=2.0 * CORNER**2)
    assert depth.mean() == pytest.approx(2.0 / 3.0, abs=1e-8), "rounding the corners moves no mean"
    change, after = 20_000 * (np.roll(depth, -1) - depth), np.roll(slope, -1)  # round the node as well
    assert_allclose(change, 0.5 * (slope + after), atol=2e-3)
    assert np.abs(after - slope).max() < 0.02, "no jump, at the node neither"


def test_the_hub_sinks_by_the_springs_compliance_and_the_step_limit_knows_them():
    """Two springs in series under each loaded roller, δ = y cos ψ: y = 2 W / (k Σ cos² ψ) over the lower half.

    A tenth of a millimetre turns the normals by half a per cent.
    """
    share = np.sum(np.maximum(np.cos(2.0 * np.pi * np.arange(13) / 13), 0.0) ** 2)
    at_rest = standing(paper(), ON_A_ROLLER)
    soft, softer = (equilibrium(of_springs(k, False), at_rest, Loads(kit.LOAD)).hub[1] for k in (2e7, 1e7))
    assert soft - softer == pytest.approx(2.0 * kit.LOAD / share * (1e-7 - 0.5e-7), rel=8e-3)
    assert of_springs(1e8, False).give(kit.LOAD) == pytest.approx(2.0 * kit.LOAD / 1e8, rel=1e-12)
    assert model(paper(), 2e-3).give(kit.LOAD) == 0.0, "only springs may give way"
    limits = [critical_time_step(of_springs(k, False), 650.0) for k in (1e7, 1e11, 1e12)]
    assert limits[0] > 10.0 * limits[2] and limits[1] / limits[2] == pytest.approx(np.sqrt(10.0), rel=0.02)


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize("faceted", [False, True])
def test_the_start_carries_the_load_on_the_same_springs(faceted):
    how, found = kit.operation(speed=0.0, gravity=0.0), of_springs(STIFF_PENALTY, faceted)
    wanted = equilibrium(found, standing(found.bearing, how.first_roller_angle), Loads(how.radial_load))
    state = copies(kit.arrays(found, how, 1e-8))
    compiled.press_contacts(state)
    within(state.contacts.forces.force[:2, :13], [wanted.inner_force, wanted.outer_force], 1e-6 * kit.LOAD)
    if faceted:  # 2 mm facets leave gaps far wider than contacts yield
        assert np.count_nonzero(wanted.inner_force) <= 4 and wanted.hub[1] < -50e-6


@pytest.mark.slow  # two time loops of their own to compile
@pytest.mark.parametrize(("name", "limit"), [("penalty", 1e-3), ("faceted", 3e-3)])
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_runs_balance_their_energy(name, limit, friction):
    """Facets throw rollers about at several m/s, and friction takes twenty times what the contacts store."""
    contact = {"model": name, "penalty_stiffness_N_per_m": STIFF_PENALTY, "friction_coefficient": friction}
    numerics = {"mesh_size_mm": 2.0, "duration_ms": 2.0, "time_step_safety": 0.45}
    values = kit.whole_run(make_plan(parse_scene({"contact": contact, "numerics": numerics}, "test")))
    assert np.abs(values.imbalance).max() / values.exchanged[-1] < limit
    force = np.hstack([values[f"{kind}_force"] for kind in ("inner", "outer", "roller_roller")])
    stored = np.sum(force**2, axis=1) / (2.0 * STIFF_PENALTY)
    assert_allclose(values["energy_contact"], stored, rtol=1e-9, atol=1e-12)
    spread = np.ptp(values["inner_y"])
    assert (spread > 50e-6) if name == "faceted" else (spread < 5e-6)

"""Normal contact forces: the gradient of one potential, action and reaction."""

from functools import partial
from typing import get_args

import numpy as np
import pytest
from numba import njit
from scipy.integrate import quad
from scipy.interpolate import BSpline

from fem.commands.run_fem import run_main
from fem.contacts import MODELS
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import Model, standing
from fem.contacts.points import disc_patch_force, disc_patch_traction, patch, ring_patch_force, ring_patch_traction
from fem.contacts.resolved import FacetedModel, PenaltyModel, ResolvedModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import DiscSurface, Patches, RingSurface
from fem.kernels.elements.surfaces import CORNER, N_NODES, ONE, chord, interpolate_displacement, locate_patch, weights
from fem.kernels.jit import OPTIONS
from fem.kernels.lanes import WIDTH, count_from, load, store
from fem.kernels.law import STEEPEST, contact_force, ripple_at, with_seam
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan
from fem.statics import exact_statics as expected_forces
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.scene.run import STIFF_PENALTY, ContactTable
from lagrange.scene.scene import Scene, parse_scene, parse_scene_text
from tests.reference.compiled import (
    DT,
    cartesian_resultant,
    contact_energy,
    fill_ring,
    follow_slips,
    kick_force,
    next_force,
    place,
    press,
    press_contacts,
    press_groups,
    pull_spring,
    random_state,
    roller_field,
    roller_resultants,
    rub,
    rubbing_state,
    set_turns,
    spring_energy,
    stored_energy,
    stretched_state,
    weight_slopes,
)
from tests.reference.continua import impact_on_rigid_flat
from tests.reference.kit import (
    LENGTH,
    ON_A_ROLLER,
    STEEL,
    arrays,
    copies,
    disc,
    model,
    operation,
    paper,
    ring,
    soft,
    whole_run,
)
from tests.reference.kit import LOAD as LOAD_COMPARISON_CONTACTS
from tests.verification.runs import WIDE, collide


def potential(state):
    """Energy of all contacts, J."""
    return contact_energy(press(state))


class Motion:
    """A direction of motion in every coordinate the contacts know; zero unless asked for."""

    def __init__(self, state, seed, kinds):
        rng = np.random.default_rng(seed)
        n, nodes = state.bodies.rollers.n, state.bodies.disc.mass.size

        def draw(kind, scale, *shape):
            return scale * rng.standard_normal(shape) * (kind in kinds)

        self.roller_u = draw("roller u", 1.0, nodes, 2, n)
        self.centre = draw("centre", 1.0, n, 2)
        self.turn = draw("turn", 1.0 / 0.005, n)
        self.inner_u = draw("inner u", 1.0, *state.bodies.inner.u[:, :, HALO:-HALO].shape)
        self.outer_u = draw("outer u", 1.0, *state.bodies.outer.u[:, :, HALO:-HALO].shape)
        self.hub = draw("hub", 1.0, 2)
        self.ring_turn = float(draw("ring turn", 1.0 / 0.018, 1)[0])

    def moved(self, state, step):
        state = copies(state)
        n = state.bodies.rollers.n
        roller_field(state, state.bodies.disc.u)[:] += step * self.roller_u
        state.bodies.rollers.centre[:, :n] += step * self.centre.T
        set_turns(state, state.bodies.rollers.turn[:n] + step * self.turn, state.drive.frame[0] + step * self.ring_turn)
        fill_ring(state.bodies.inner.u, state.bodies.inner.u[:, :, HALO:-HALO] + step * self.inner_u)
        fill_ring(state.bodies.outer.u, state.bodies.outer.u[:, :, HALO:-HALO] + step * self.outer_u)
        state.drive.hub[:] += step * self.hub
        return state

    def power(self, state):
        """Power of all forces that contacts exert, as the time loop applies them, W."""
        pressed = press(state)
        rollers, n = pressed.bodies.rollers, pressed.bodies.rollers.n
        force = (
            roller_field(pressed, pressed.bodies.disc.w) * pressed.bodies.disc.mass[:, None, None] / DT
        )  # in the frames
        c, s = rollers.cosine[:n], rollers.sine[:n]
        centre = np.stack(
            [c * self.centre[:, 0] + s * self.centre[:, 1], c * self.centre[:, 1] - s * self.centre[:, 0]]
        )
        position = pressed.bodies.disc.points.reshape(-1, 2, 1) + roller_field(pressed, pressed.bodies.disc.u)
        turned = np.stack([-position[:, 1], position[:, 0]], axis=1) * self.turn
        total = np.sum(force * (self.roller_u + centre[None] + turned))
        total += np.sum(rollers.body_impulse[:, :n].T * self.centre) / DT
        total += rollers.inertia * (rollers.turn_kick[:n] @ self.turn) / DT
        for annulus, rate, spin in (
            (pressed.bodies.inner, self.inner_u, self.ring_turn),
            (pressed.bodies.outer, self.outer_u, 0.0),
        ):
            nodal = annulus.w[:, :, HALO:-HALO] * annulus.row_mass[:, None, None] / DT
            place = annulus.u[:, :, HALO:-HALO].copy()
            place[:, 0] += annulus.radii[:, None]
            total += np.sum(nodal * (rate + spin * np.stack([-place[:, 1], place[:, 0]], axis=1)))
        total += pressed.drive.impulse @ self.hub / DT
        # what the drive must hold against the contacts is what they exert on the frame, reversed
        return total - pressed.drive.moment[0] * self.ring_turn


ALONE = ("roller u", "centre", "turn", "inner u", "outer u", "hub", "ring turn")


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("kinds", [*((kind,) for kind in ALONE), ALONE], ids=[*ALONE, "all together"])
def test_contact_forces_are_the_gradient_of_the_contact_energy(kinds, seed):
    state = random_state(seed)
    motion = Motion(state, 100 + seed, kinds)
    closed = press(state).contacts.forces.force > 0.0
    assert closed[INNER].sum() >= 4 and closed[OUTER].sum() >= 4 and closed[ROLLER, 3]
    found, total = motion.power(state), press(state).contacts.forces.force.sum()

    def slope(step):
        ahead, behind = motion.moved(state, step), motion.moved(state, -step)
        for other in (ahead, behind):
            np.testing.assert_array_equal(
                press(other).contacts.forces.force > 0.0, closed, "no contact opens on the way"
            )
        return -(potential(ahead) - potential(behind)) / (2.0 * step)

    near, far = slope(2e-9), slope(4e-9)
    wanted = near + (near - far) / 3.0  # fourth order; measured error 2e-10 of the sum of Q, mostly round-off
    # a patch's first moment is exact to spacing⁷/5040 only: 2e-10 rad of Q·r, seen when a roller turns alone
    assert found == pytest.approx(wanted, rel=0.0, abs=1e-9 * total)
    assert abs(wanted) > 1e-6 * total, "the comparison says something"


@pytest.mark.parametrize("kinds", [*((kind,) for kind in ALONE), ALONE], ids=[*ALONE, "all together"])
def test_resolved_contact_forces_are_the_gradient_of_their_energy(kinds):
    state = random_state(4, resolved=True)
    motion = Motion(state, 104, kinds)
    closed = press(state).contacts.forces.force > 0.0
    assert closed[INNER].sum() >= 4 and closed[OUTER].sum() >= 4 and closed[ROLLER, 3]
    found, total = motion.power(state), press(state).contacts.forces.force.sum()

    def slope(step):
        return -(potential(motion.moved(state, step)) - potential(motion.moved(state, -step))) / (2.0 * step)

    # points that open within the step leave an error of first order in it; the chord's end a moment of spacing³
    assert found == pytest.approx(slope(1e-11), rel=0.0, abs=1e-6 * total)
    assert abs(found) > 1e-4 * total, "the comparison says something"


def test_the_tilt_terms_are_seen_by_the_gradient_test():
    """Forces at fixed patches alone miss the potential by the tilt of the surfaces."""
    state = random_state(1)
    pressed = press(state)
    total = pressed.contacts.forces.force.sum()
    assert np.abs(pressed.bodies.rollers.body_impulse).max() / DT > 1e-5 * total
    assert np.abs(pressed.bodies.rollers.turn_kick).max() * pressed.bodies.rollers.inertia / DT > 1e-5 * total * 0.005
    assert np.abs(pressed.drive.impulse).max() / DT > 1e-5 * total
    assert abs(pressed.drive.moment[0]) > 1e-5 * total * 0.018


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", ["inner", "outer", "roller"])
def test_normal_forces_are_action_and_reaction(kind, seed):
    state = copies(random_state(seed))
    rollers, contacts, drive = state.bodies.rollers, state.contacts, state.drive
    pairs = {"inner": state.groups[0][0], "outer": state.groups[0][1], "roller": state.groups[1][0]}
    press_groups(state, ((pairs[kind],),))
    number = {"inner": INNER, "outer": OUTER, "roller": ROLLER}[kind]
    Q, normal = contacts.forces.force[number, :13], contacts.patches.normal[number, :, :13].T
    scale, impulse, tilt = Q.sum() * DT, rollers.node_impulse[:, :13].T, rollers.body_impulse[:, :13].T
    fresh = random_state(seed)
    state.bodies.disc.w[:] -= fresh.bodies.disc.w
    state.bodies.inner.w[:] -= fresh.bodies.inner.w
    # the roller's centre gets what its nodes get; the force is Q along the line of centres, tilt apart
    np.testing.assert_allclose(roller_resultants(state), impulse, rtol=0.0, atol=1e-12 * scale)
    push = Q[:, None] * normal * DT
    wanted = {"inner": push, "outer": -push, "roller": np.roll(push, 1, axis=0) - push}[kind]
    np.testing.assert_allclose(impulse, wanted, rtol=0.0, atol=1e-13 * scale)
    # nodes push nodes, and the tilt of both surfaces pushes both bodies (of the outer ring: the ground)
    rings = cartesian_resultant(state.bodies.outer) + cartesian_resultant(state.bodies.inner, *drive.frame[1:])
    np.testing.assert_allclose(impulse.sum(axis=0) + rings, 0.0, rtol=0.0, atol=1e-11 * scale)
    assert np.abs(tilt).max() > 1e-6 * scale
    if kind != "outer":
        np.testing.assert_allclose(tilt.sum(axis=0) + drive.impulse, 0.0, rtol=0.0, atol=1e-15 * scale)
    closed = Q > 0.0
    if kind != "roller":  # across the line of centres
        np.testing.assert_allclose(np.sum(tilt * normal, axis=1)[closed], 0.0, rtol=0.0, atol=1e-15 * scale)


def test_spare_lanes_that_sit_on_a_roller_add_nothing():
    """Thirteen rollers are two groups of eight: the last three lanes stand where roller 0 is."""
    state = random_state(1)
    rollers = state.bodies.rollers
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    pressed = press(state)
    assert pressed.contacts.forces.force[ROLLER, 3] > 0.0
    angle, apart = np.arctan2(*rollers.centre[::-1, 12]), 2.0 * np.arcsin(0.2174)  # 12 and 0 touch: in the last group
    rollers.centre[:, 0] = 0.023 * np.cos(angle + apart), 0.023 * np.sin(angle + apart)
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    pressed = press(state)
    assert pressed.contacts.forces.force[ROLLER, 12] > 0.0
    for entry in (
        pressed.bodies.rollers.node_impulse,
        pressed.bodies.rollers.body_impulse,
        pressed.bodies.rollers.turn_kick,
        pressed.bodies.disc.w,
    ):
        assert np.all(np.isfinite(entry))


def test_nothing_touches_nothing_pushes():
    state = random_state(1)
    state.drive.hub[:] = 0.0
    angle = 2.0 * np.pi * np.arange(13) / 13.0
    state.bodies.rollers.centre[:, :13] = 0.0229 * np.cos(angle), 0.0229 * np.sin(angle)
    pressed = press(state)  # 0.1 mm off the outer ring and into the inner one
    assert np.all(pressed.contacts.forces.force[OUTER] == 0.0)
    assert np.all(pressed.contacts.forces.force[ROLLER] == 0.0)
    assert np.all(pressed.contacts.forces.force[INNER, :13] > 0.0)
    assert np.all(pressed.bodies.outer.w == 0.0)


# The contact law itself: force, energy and stiffness of one potential, and what a kick of the time loop gives


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


# Contact models: each of a scene's names has one, all answer the same questions, none solves statics twice


LOAD = 650.0
BUILT = {
    "subgrid": lambda: SubgridModel.build(paper(), 2e-3),
    "spread": lambda: SpreadModel.of_force(soft(), 6e-4, LOAD),
    "resolved": lambda: ResolvedModel.build(soft(), 3e-4),
    "penalty": lambda: PenaltyModel.of_stiffness(paper(), 2e-3, 1e8),
    "faceted": lambda: FacetedModel.of_stiffness(paper(), 2e-3, 1e8),
}
every_model = pytest.mark.parametrize("name", BUILT)


def built(name) -> Model:
    return BUILT[name]()


def scene(contact="subgrid", mesh_size=2.0, modulus=210.0):
    tables = {
        "contact": {"model": contact},
        "numerics": {"mesh_size_mm": mesh_size, "duration_ms": 0.0},
        "material": {"youngs_modulus_GPa": modulus},
    }
    return parse_scene(tables, "test")


def test_every_name_of_the_scene_has_a_model():
    assert set(MODELS) == set(get_args(ContactTable.model_fields["model"].annotation))


@pytest.mark.parametrize(
    ("contact", "mesh_size", "modulus", "kind"),
    [
        ("subgrid", 2.0, 210.0, SubgridModel),
        ("subgrid", 0.6, 5.0, SpreadModel),
        ("penalty", 2.0, 210.0, PenaltyModel),
        ("faceted", 2.0, 210.0, FacetedModel),
    ],
)
def test_a_scene_gets_its_model(contact, mesh_size, modulus, kind):
    assert type(model_of(scene(contact, mesh_size, modulus))) is kind


@every_model
def test_the_kernels_get_what_they_know_and_no_more(name):
    """A law below the grid with its ripples, or points; of every pair its half-width."""
    model = built(name)
    given = model.kernel_data(LOAD)
    assert (given.points is None) == (name == "subgrid") == all(law.A > 0.0 for law in given.laws)
    assert all((ripple.size > 0) == (name == "subgrid") for ripple in given.ripples)
    for law, known in zip(model.laws, given.laws, strict=True):
        assert known.half_width_factor == law.pair.half_width_factor
        assert known.curvature * law.pair.relative_radius == pytest.approx(1.0, rel=1e-15)


@every_model
@pytest.mark.parametrize("kind", [INNER, OUTER, ROLLER])
def test_nodes_carry_a_whole_contact_around_its_middle(name, kind):
    """Shares sum to 1 and their first moment is that of the contact: neither force nor moment is lost."""
    nodes, share, offset = built(name).carried(kind, 60, 1.234, 5e-3, LOAD)
    assert share.sum() == pytest.approx(1.0, rel=1e-12)
    assert share @ offset == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.mod(nodes * (2.0 * np.pi / 60.0) + offset, 2.0 * np.pi), 1.234, rtol=1e-12)


@every_model
def test_springs_push_each_body_at_every_contact(name):
    """Forces of a column balance those of the contact: outward on the roller, radial on a ring."""
    model = built(name)
    springs = model.springs(10.0 * LOAD)
    assert springs["roller"].shape[0] == 2 * model.roller.n_nodes
    for annulus in ("inner_ring", "outer_ring"):
        body = getattr(model, annulus)
        on = springs[annulus].toarray().reshape(body.n_rows, 2, body.n_sectors, -1)
        assert np.abs(np.delete(on, body.raceway_row, axis=0)).max() == 0.0
        assert np.abs(on[body.raceway_row, 0]).max() > 0.0


def test_only_soft_springs_may_give_way():
    for name in BUILT:
        assert (built(name).give(2000.0) > 0.0) == (name in ("penalty", "faceted"))
    assert built("penalty").give(2000.0) == pytest.approx(2.0 * 2000.0 / 1e8, rel=1e-12)


@pytest.mark.parametrize(
    ("contact", "mesh_size", "modulus", "most"), [("subgrid", 2.0, 210.0, 0), ("subgrid", 0.6, 5.0, 1)]
)
def test_exact_statics_of_a_scene_are_solved_once_at_most(contact, mesh_size, modulus, most, monkeypatch):
    calls = []
    solve = expected_forces.exact_statics
    monkeypatch.setattr(expected_forces, "exact_statics", lambda *args: calls.append(args) or solve(*args))
    make_plan(scene(contact, mesh_size, modulus))
    assert len(calls) == most


# Tangential springs of contacts that stick: in series with creep, vibrating, dragged along, calibrated


def missing_shear(state, kind, force):
    level, law = state.contacts.friction.shear.level[kind], [pair.law for group in state.groups for pair in group][kind]
    return law.A * (level - 0.5 * np.log(force))


def test_springs_and_creep_are_in_series():
    """e₊ − e = dt (slip − creep), both as means; where it slides what is left creeps."""
    state = stretched_state()
    rubbed, slips_before, slips, _ = rub(state)
    forces, friction, shear = rubbed.contacts.forces.force, rubbed.contacts.friction, rubbed.contacts.friction.shear
    before, slid = state.contacts.friction.shear, 0
    for kind, j in np.argwhere(forces > 0.0):
        Q, traction = forces[kind, j], -friction.traction[kind, j]
        soft = missing_shear(state, kind, Q)
        assert shear.compliance[kind, j] == pytest.approx(soft, rel=1e-12)
        creep = shear.creep[kind, j]
        to_come = soft * traction + 0.5 * DT * (slips[kind, j] - creep)  # the other half is the next kick's
        assert shear.since[kind, j] == DT
        assert shear.stretch[kind, j] == pytest.approx(to_come, rel=1e-9, abs=1e-9 * soft * Q)
        kept = min(1.0, soft / before.compliance[kind, j])  # the stretch, or the force if that has grown
        free = kept * (before.stretch[kind, j] + 0.5 * before.since[kind, j] * slips_before[kind, j])
        if abs(traction) < 0.1 * Q:
            assert soft * traction == pytest.approx(free - 0.5 * DT * creep, rel=1e-9, abs=1e-9 * soft * Q)
        else:
            slid += 1
            assert abs(traction) <= 0.1 * Q * (1.0 + 1e-15)
            slid_off = free + 0.5 * DT * before.creep[kind, j] - soft * traction
            assert DT * creep == pytest.approx(slid_off, rel=1e-9, abs=1e-20)
        assert creep * traction >= 0.0
    assert 0 < slid < np.sum(forces > 0.0)
    open_ones = forces <= 0.0
    for left in (shear.stretch, shear.creep, shear.since, friction.traction):
        assert np.all(left[open_ones] == 0.0)


class OneSpring:
    """Eight alike, on contacts of given compliance, m/N; `pulled` moves on by a slip, m/s."""

    def __init__(self, soft: float, dt: float, limit: float, full_slip: float):
        self.state, self.dt, self.how = copies(rubbing_state()), dt, (limit, full_slip)
        contacts, pair = self.state.contacts, self.state.groups[0][0]
        self.friction, self.shear, self.pair = contacts.friction, contacts.friction.shear, pair
        self.shear.stretch[:] = self.shear.creep[:] = 0.0
        self.shear.since[:] = dt
        # so that the law gives this compliance
        contacts.forces.force[:], contacts.forces.approach[:], contacts.forces.bracket[:] = 1.0, 0.0, 0.0
        self.shear.level[:] = soft / pair.law.A
        self.shear.compliance[:] = soft

    def pulled(self, slip: float) -> float:
        """Traction, N, after a step."""
        self.friction.slip[:] = self.friction.slip_left[:] = slip
        follow_slips(self.shear, self.state.contacts.forces, self.friction, self.dt, WIDTH)
        pull_spring(self.shear, self.state.contacts, self.pair, self.dt, *self.how)
        return self.shear.stretch[0, 0] / self.shear.compliance[0, 0]

    @property
    def energy(self) -> float:
        return spring_energy(self.shear, WIDTH) / (3 * WIDTH)


def test_a_mass_on_a_spring_that_sticks_vibrates_without_loss_and_with_leapfrogs_period():
    """sin(ω̂ dt/2) = ω dt/2."""
    mass, soft, periods = 2e-3, 2e-9, 5
    omega = np.sqrt(1.0 / (mass * soft))
    for per_period in (10, 40):
        dt = 2.0 * np.pi / omega / per_period
        spring = OneSpring(soft, dt, 1e12, 1e-6)
        place, velocity, places, totals, traction = 0.0, 1.0, [], [], 0.0
        for _ in range(periods * per_period):
            places.append(place)
            last, velocity = velocity, velocity - dt / mass * traction
            totals.append(0.5 * mass * last * velocity + spring.energy)
            place += dt * velocity
            traction = spring.pulled(velocity)
        turned = 2.0 * np.arcsin(0.5 * omega * dt) * np.arange(len(places))
        amplitude = places[1] / np.sin(turned[1])
        np.testing.assert_allclose(places, amplitude * np.sin(turned), rtol=0.0, atol=1e-6 * amplitude)
        assert np.ptp(totals) < 1e-6 * totals[0]


def test_a_contact_dragged_along_is_stretched_until_it_slides_steadily_and_then_springs_back():
    soft, limit, dt, speed = 2e-9, 60.0, 1e-7, 0.1
    spring, tractions, creeps = OneSpring(soft, dt, limit, 1e-4), [], []
    for step in range(60):
        velocity = speed if step < 40 else -speed
        tractions.append(spring.pulled(velocity))
        creeps.append(spring.shear.creep[0, 0])
    elastic = speed * dt / soft  # 5 N a step: 12 steps up to the limit
    np.testing.assert_allclose(tractions[:10], elastic * np.arange(1, 11), rtol=0.05)
    assert np.all(np.array(tractions[14:40]) == pytest.approx(limit, rel=1e-12)), "and does not swing from step to step"
    np.testing.assert_allclose(creeps[15:40], speed, rtol=1e-9)
    np.testing.assert_allclose(tractions[40:45], limit - elastic * np.arange(1, 6), atol=elastic)


def test_tractions_push_the_nodes_that_the_springs_are_calibrated_with():
    state = stretched_state()
    rubbed, *_ = rub(state)
    whole, traction, patches = model(paper(), 1e-3), rubbed.contacts.friction.traction, rubbed.contacts.patches
    scale = np.abs(traction).sum()

    def gained(name):
        return getattr(rubbed.bodies, name).w - getattr(state.bodies, name).w

    for body, kind, turn in ((whole.inner_ring, INNER, rubbed.drive.frame[0]), (whole.outer_ring, OUTER, 0.0)):
        angle = np.arctan2(*patches.normal[kind, ::-1, :13]) - turn
        wanted = -sum(T * ring_patch_traction(body, a) for T, a in zip(traction[kind, :13], angle, strict=True))
        name = "inner" if kind == INNER else "outer"
        found = gained(name)[:, :, HALO:-HALO] * (body.row_mass / DT)[:, None, None]
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-8 * scale)
    wanted = np.zeros((13, 2 * whole.roller.n_nodes))
    for kind in (INNER, OUTER, ROLLER):
        for j in np.flatnonzero(rubbed.contacts.forces.force[kind, :13]):
            i = (j + 1) % 13 if kind == ROLLER else j
            around = -traction[kind, j] * (-1.0 if kind == OUTER else 1.0)
            wanted[i] += around * disc_patch_traction(whole.roller, np.arctan2(*patches.outward[2 * kind + 1, ::-1, j]))
            if kind == ROLLER:
                wanted[j] += around * disc_patch_traction(whole.roller, np.arctan2(*patches.outward[4, ::-1, j]))
    found = roller_field(rubbed, gained("disc")) * rubbed.bodies.disc.mass[:, None, None] / DT
    np.testing.assert_allclose(np.moveaxis(found, 2, 0).reshape(13, -1), wanted, rtol=0.0, atol=1e-8 * scale)


def test_a_spring_without_a_compliance_is_refused():
    state = rubbing_state()
    state.check()
    state.contacts.friction.shear.compliance[OUTER, 2] = 0.0
    with pytest.raises(ValueError, match="without a compliance"):
        state.check()


# Two rollers that collide, with and without friction: momenta, energy, and the order of its error


# A roller of 5 mm by 10 mm thrown at a rigid frictionless flat, quasi-static with Johnson's approach (1985, eq. 5.57)
THROWN = [(0.1, 0.333, 193.0, 10.34), (1.0, 3.008, 2156.0, 9.31)]


@pytest.mark.parametrize(("speed", "microns", "newtons", "microseconds"), THROWN)
def test_reference_impact_is_the_quasi_static_one(speed, microns, newtons, microseconds):
    approach, force, time = impact_on_rigid_flat(speed, 0.005, LENGTH, paper().roller_mass, STEEL.plane_strain_modulus)
    assert 1e6 * approach == pytest.approx(microns, abs=5e-4)
    assert force == pytest.approx(newtons, abs=0.5)
    assert 1e6 * time == pytest.approx(microseconds, abs=6e-3)


OBLIQUE = ([1.0, 0.2], [-0.4, -0.1])  # m/s


@pytest.mark.parametrize("spins", [(0.0, 0.0), (800.0, -300.0)])
def test_a_frictionless_collision_conserves_momenta_and_energy(spins):
    found = collide(OBLIQUE, spins=spins)
    wanted = np.tile(WIDE.roller_mass * np.sum(OBLIQUE, axis=0), (len(found.force), 1))
    np.testing.assert_allclose(found.momentum, wanted, rtol=0.0, atol=1e-13 * WIDE.roller_mass)
    # what the patch's moment misses, spacing⁷/5040
    assert np.ptp(found.angular_momentum) < 1e-10 * abs(found.angular_momentum[0])
    energy = found.energy.sum(axis=1)
    assert np.ptp(energy) < 2e-4 * energy[0]  # the contact's corner, O(dt²) of its share
    assert energy[-1] == pytest.approx(energy[0], rel=2e-5)
    assert found.force.max() > 1000.0
    assert np.all(found.traction == 0.0)


def energy_and_loss(found):
    """Energy and what friction has dissipated up to the same instant, half a step's share at the last."""
    return found.energy.sum(axis=1) + np.cumsum(found.dissipated) - 0.5 * found.dissipated


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_collisions_energy_error_shrinks_with_the_square_of_the_step(friction):
    courant, error = np.array([0.4, 0.2, 0.1, 0.05]), []
    for c in courant:
        energy = energy_and_loss(collide(OBLIQUE, spins=(800.0, -300.0), friction=friction, courant=float(c)))
        error.append(np.ptp(energy) / energy[0])
    # less than 2 by where the contact opens between two steps; measured 1.84
    assert np.polyfit(np.log(courant), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.3)
    assert error[-1] < 2e-6


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_a_rubbing_collision_loses_what_it_dissipates(friction):
    found = collide(OBLIQUE, spins=(800.0, 500.0), friction=friction, courant=0.25)
    assert np.ptp(found.momentum, axis=0).max() < 1e-13 * WIDE.roller_mass
    assert np.all(found.dissipated >= 0.0)
    energy = energy_and_loss(found)
    np.testing.assert_allclose(energy, energy[0], rtol=5e-5)  # as without friction; measured 2.6e-5
    assert found.dissipated.sum() > 0.1 * energy[0]
    # tractions act at both circles' radii while these overlap by 2 µm: arms differ by 2e-4 at the very most
    assert np.ptp(found.angular_momentum) < 2e-4 * abs(found.angular_momentum[0])
    assert np.all(np.abs(found.traction) <= friction * found.force * (1.0 + 1e-14))


# Patches of nodes that a contact reads and pushes: weights, places, and kernels against matrices


RADIUS = 0.005
FRACTIONS = np.append(np.linspace(0.0, 1.0, 41)[:-1], np.nextafter(1.0, 0.0))


def weights_at(t):
    return np.array(weights(t))


def slopes_at(t):
    return np.array(weight_slopes(t))


def test_weights_are_schoenbergs_quintic_spline():
    spline = BSpline.basis_element(np.arange(7) - 3.0, extrapolate=False)
    for t in FRACTIONS:
        offset = np.arange(N_NODES) - 2 - t
        np.testing.assert_allclose(weights_at(t), np.nan_to_num(spline(offset)), rtol=0.0, atol=1e-15)


def test_weights_sum_to_one_and_have_the_moments_of_a_smooth_kernel():
    first_four = []
    for t in FRACTIONS:
        weight, offset = weights_at(t), np.arange(N_NODES) - 2 - t
        assert weight.min() >= 0.0
        assert weight.sum() == pytest.approx(1.0, abs=3e-16)
        assert weight @ offset == pytest.approx(0.0, abs=5e-16)
        first_four.append([weight @ offset**k for k in range(2, 6)])
    # second ... fifth moment do not depend on where between the nodes the patch sits
    np.testing.assert_allclose(first_four, np.tile([0.5, 0.0, 0.7, 0.0], (len(FRACTIONS), 1)), atol=2e-14)


def test_weight_slopes_are_the_derivatives_of_the_weights():
    step = 1e-5  # central difference: step² · W‴/6 = 2e-11, round-off 1e-16/1e-5 = 1e-11
    for t in np.linspace(0.05, 0.95, 19):
        difference = (weights_at(t + step) - weights_at(t - step)) / (2.0 * step)
        np.testing.assert_allclose(slopes_at(t), difference, rtol=0.0, atol=1e-10)
        assert slopes_at(t).sum() == pytest.approx(0.0, abs=3e-16)


def test_nothing_happens_when_a_node_passes():
    end = 1.0
    np.testing.assert_allclose(weights_at(end)[1:], weights_at(0.0)[:-1], atol=1e-16)
    np.testing.assert_allclose(slopes_at(end)[1:], slopes_at(0.0)[:-1], atol=1e-16)
    assert weights_at(end)[0] == weights_at(0.0)[-1] == 0.0


@pytest.mark.parametrize("n", [18, 56])
def test_a_direction_gets_its_place_among_the_nodes(n):
    for position in (0.0, 0.25, n / 2.0, n - 0.5, n - 1e-9):
        angle = 2.0 * np.pi * position / n
        found = place(0.3 * np.cos(angle), 0.3 * np.sin(angle), n)
        assert min(abs(found - position), n - abs(found - position)) < 1e-13 * n
        assert 0.0 <= found < n
    for tiny in (1e-300, 1e-20, 1e-16):  # just below the first node: adding n rounds up to n
        assert 0.0 <= place(1.0, -tiny, n) < n


def test_patches_wrap_round_the_body():
    nodes, weight, offset = patch(18, 2.0 * np.pi * 17.4 / 18.0)
    assert nodes.tolist() == [15, 16, 17, 0, 1, 2]
    assert weight @ offset == pytest.approx(0.0, abs=1e-15)


ANGLES = np.array([0.0, 0.37, 2.0, -0.01, -3.0, np.pi, -1.6, 1.234])  # of eight contacts, read at once
GROUP, COLUMNS = 8, 16


@njit(**OPTIONS)
def read_group(surface, patches, bx, by, out):
    for component, b in enumerate((bx, by)):
        store(patches.outward, (2 + component) * COLUMNS + GROUP, load(b, 0))
    locate_patch(surface, patches, 1, GROUP)
    found = interpolate_displacement(surface, patches, 1, GROUP, count_from(GROUP))
    for k in range(5):
        store(out, 8 * k, found[k])


def some_patches():
    weight, along, across, traction_x, traction_y, lightness = (np.zeros((2, N_NODES, COLUMNS)) for _ in range(6))
    position, beyond = np.zeros((2, COLUMNS)), np.zeros((2, COLUMNS))
    return Patches(
        normal=np.zeros((1, 2, COLUMNS)), start=np.zeros((2, COLUMNS), dtype=np.int64), position=position,
        beyond=beyond, motion=np.zeros((2, 5, COLUMNS)), place=np.zeros((2, N_NODES, COLUMNS), dtype=np.int64),
        weight=weight, outward=np.zeros((2, 2, COLUMNS)), along=along, across=across, traction_x=traction_x,
        traction_y=traction_y, inverse_mass=lightness, columns=COLUMNS, units=ONE,
    )  # fmt: skip


def readings(surface, at):
    """What contacts read of a surface at angles, (8,): its displacement, sideways, their rates and ripple, (5, 8)."""
    out = np.zeros((5, 8))
    read_group(surface, some_patches(), np.cos(at), np.sin(at), out)
    return out


def test_kernels_and_matrices_use_the_same_roller_patches():
    body = disc(RADIUS, 3)
    u = np.random.default_rng(1).standard_normal((body.n_nodes, 2, COLUMNS))
    ripples = np.random.default_rng(2).standard_normal(3 * 8)
    surface = DiscSurface(
        u=u.ravel(), w=u.ravel(), v=u.ravel(), points=body.points.ravel(), inverse_mass=np.ones(body.n_nodes + 8),
        impulse=np.zeros((2, COLUMNS)), ripple=with_seam(ripples), first=body.first_surface_node,
        n_nodes=body.shape.surface_nodes, columns=COLUMNS, radius=RADIUS,
    )  # fmt: skip

    step = 1e-6
    (out, side, rate, ripple, ripple_rate), ahead, behind = (
        readings(surface, ANGLES + turn) for turn in (0.0, step, -step)
    )
    for j, angle in enumerate(ANGLES):
        mine = u[:, :, GROUP + j].ravel()
        along = disc_patch_force(body, angle)
        assert out[j] == pytest.approx(along @ mine, abs=1e-14)
        across = np.einsum("ab,nb->na", [[0.0, -1.0], [1.0, 0.0]], along.reshape(-1, 2)).ravel()
        assert side[j] == pytest.approx(across @ mine, abs=1e-14)
        position = np.mod(angle * 18.0 / (2.0 * np.pi), 18.0)
        assert ripple[j] == pytest.approx(ripple_at(position, ripples)[0], abs=1e-12)
    # out turns with the direction as well: d(U·b)/ds = dU/ds·b + U·Jb
    np.testing.assert_allclose(rate + side, (ahead[0] - behind[0]) / (2.0 * step), rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(ripple_rate, (ahead[3] - behind[3]) / (2.0 * step), rtol=1e-5, atol=1e-5)


def test_kernels_and_matrices_use_the_same_ring_patches():
    body = ring(0.0125, 0.018, 56, 3, True)
    u = np.random.default_rng(3).standard_normal((body.n_rows, 2, body.n_sectors))
    padded = np.ascontiguousarray(np.concatenate([u[..., -HALO:], u, u[..., :HALO]], axis=-1))
    ripples = np.random.default_rng(4).standard_normal(8)
    sector = 2.0 * np.pi * (np.arange(56 + 2 * HALO) - HALO) / 56
    surface = RingSurface(
        u=padded, w=padded, v=padded, cosines=np.cos(sector), sines=np.sin(sector), ripple=with_seam(ripples),
        row=body.raceway_row, n_nodes=56, node_mass=1.0, radius=0.018,
    )  # fmt: skip

    step = 1e-6
    (out, side, rate, ripple, ripple_rate), ahead, behind = (
        readings(surface, ANGLES + turn) for turn in (0.0, step, -step)
    )
    for j, angle in enumerate(ANGLES):
        along = ring_patch_force(body, angle)
        assert out[j] == pytest.approx(np.vdot(along, u), abs=1e-13)
        turned = np.stack([-along[:, 1], along[:, 0]], axis=1)
        assert side[j] == pytest.approx(np.vdot(turned, u), abs=1e-13)
        position = np.mod(angle * 56.0 / (2.0 * np.pi), 1.0)
        assert ripple[j] == pytest.approx(ripple_at(position, ripples)[0], abs=1e-10)
    np.testing.assert_allclose(rate + side, (ahead[0] - behind[0]) / (2.0 * step), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(ripple_rate, (ahead[3] - behind[3]) / (2.0 * step), rtol=1e-5, atol=1e-4)


# Contacts as other programs have them on a coarse mesh: penalty springs between circles, or between facets


MESH_MM = 2.0


def model_comparison_contacts(stiffness, faceted, mesh_mm=MESH_MM):
    return (FacetedModel if faceted else PenaltyModel).of_stiffness(paper(), 1e-3 * mesh_mm, stiffness)


def hub(a_model):
    return equilibrium(a_model, standing(a_model.bearing, ON_A_ROLLER), Loads(LOAD_COMPARISON_CONTACTS)).hub


# geometry -------------------------------------------------------------------------------------------------------


def test_a_facet_is_deepest_in_its_middle_and_smooth_at_its_ends():
    beyond = (np.arange(20_000) + 0.5) / 20_000
    depth, slope = np.array([chord(t) for t in beyond]).T
    assert depth.max() == pytest.approx(chord(0.5)[0]) and depth.max() == pytest.approx(1.0, abs=2.0 * CORNER**2)
    assert depth.mean() == pytest.approx(2.0 / 3.0, abs=1e-8), "rounding the corners moves no mean"
    change = np.diff(np.append(depth, depth[0])) * beyond.size
    np.testing.assert_allclose(change, 0.5 * (slope + np.append(slope[1:], slope[0])), atol=2e-3)
    assert np.abs(np.diff(np.append(slope, slope[0]))).max() < 0.02, "no jump, at the node neither"


def test_sagittas_are_those_of_the_meshes_own_chords():
    """h²/8R, to its own relative error h²/R²/48; in a bore the chord lies on the other side of the circle."""
    found = model_comparison_contacts(STIFF_PENALTY, faceted=True)
    disc, inner, outer = found.roller, found.inner_ring, found.outer_ring

    def below_the_circle(points):
        middle = 0.5 * (points + np.roll(points, -1, axis=0))
        return np.hypot(*points.T).mean() - np.hypot(*middle.T)

    surface = disc.points[disc.first_surface_node :]
    inside = inner.points.reshape(inner.n_rows, -1, 2)[-1]
    bore = outer.points.reshape(outer.n_rows, -1, 2)[0]
    for law, side, points, sign in (
        (found.inner_law, 0, inside, 1.0), (found.outer_law, 0, bore, -1.0),
        (found.inner_law, 1, surface, 1.0), (found.outer_law, 1, surface, 1.0), (found.roller_law, 0, surface, 1.0),
    ):  # fmt: skip
        np.testing.assert_allclose(below_the_circle(points), sign * law.sagitta[side], rtol=6e-3)
    assert model_comparison_contacts(STIFF_PENALTY, faceted=False).inner_law.sagitta == (0.0, 0.0)


# the spring -----------------------------------------------------------------------------------------------------


def test_the_hub_sinks_by_the_springs_compliance():
    """Two springs in series under each loaded roller, δ = y cos ψ: y = 2 W / (k Σ cos² ψ) over the lower half.

    A tenth of a millimetre turns the normals by half a per cent.
    """
    angle = 2.0 * np.pi * np.arange(13) / 13
    share = np.sum(np.maximum(np.cos(angle), 0.0) ** 2)
    soft, softer = (
        hub(model_comparison_contacts(2e7, faceted=False)),
        hub(model_comparison_contacts(1e7, faceted=False)),
    )
    assert soft[1] - softer[1] == pytest.approx(2.0 * LOAD_COMPARISON_CONTACTS / share * (1e-7 - 0.5e-7), rel=8e-3)


def test_the_step_limit_knows_the_spring():
    limits = [critical_time_step(model_comparison_contacts(k, faceted=False), 650.0) for k in (1e7, 1e11, 1e12)]
    assert limits[0] > 10.0 * limits[2]
    assert limits[1] / limits[2] == pytest.approx(np.sqrt(10.0), rel=0.02)


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize("faceted", [False, True])
def test_the_start_carries_the_load_on_the_same_springs(faceted):
    how = operation(speed=0.0, gravity=0.0)
    found = model_comparison_contacts(STIFF_PENALTY, faceted)
    wanted = equilibrium(found, standing(found.bearing, how.first_roller_angle), Loads(how.radial_load))
    state = copies(arrays(found, how, 1e-8))
    press_contacts(state)
    np.testing.assert_allclose(
        state.contacts.forces.force[0, :13], wanted.inner_force, rtol=0.0, atol=1e-6 * LOAD_COMPARISON_CONTACTS
    )
    np.testing.assert_allclose(
        state.contacts.forces.force[1, :13], wanted.outer_force, rtol=0.0, atol=1e-6 * LOAD_COMPARISON_CONTACTS
    )
    if faceted:  # 2 mm facets leave gaps far wider than contacts yield
        assert np.count_nonzero(wanted.inner_force) <= 4 and wanted.hub[1] < -50e-6


# motion ---------------------------------------------------------------------------------------------------------


def moved(name, stiffness, friction):
    scene = parse_scene(
        {
            "contact": {"model": name, "penalty_stiffness_N_per_m": stiffness, "friction_coefficient": friction},
            "numerics": {"mesh_size_mm": MESH_MM, "duration_ms": 2.0, "time_step_safety": 0.45},
        },
        "test",
    )
    found = whole_run(make_plan(scene))
    return found, np.abs(found.imbalance).max() / found.exchanged[-1]


@pytest.mark.slow  # two time loops of their own to compile
@pytest.mark.parametrize(("name", "limit"), [("penalty", 1e-3), ("faceted", 3e-3)])
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_runs_balance_their_energy(name, limit, friction):
    """Facets throw rollers about at several m/s, and friction takes twenty times what the contacts store."""
    values, imbalance = moved(name, STIFF_PENALTY, friction)
    assert imbalance < limit
    force = np.hstack([values[f"{kind}_force"] for kind in ("inner", "outer", "roller_roller")])
    stored = np.sum(force**2, axis=1) / (2.0 * STIFF_PENALTY)
    np.testing.assert_allclose(values["energy_contact"], stored, rtol=1e-9, atol=1e-12)
    spread = np.ptp(values["inner_y"])
    assert (spread > 50e-6) if name == "faceted" else (spread < 5e-6)


# scenes ---------------------------------------------------------------------------------------------------------


def test_only_comparison_models_have_a_spring():
    assert Scene().contact.model == "subgrid" and "penalty" not in Scene().to_toml()
    stiff = parse_scene({"contact": {"model": "faceted"}}, "s")
    assert stiff.contact.penalty_stiffness_N_per_m == STIFF_PENALTY
    assert parse_scene_text(stiff.to_toml(), "again") == stiff


def test_no_error_is_estimated_for_a_comparison_model(capsys):
    assert run_main(["--set", "contact.model=penalty", "--estimate-error", "--dry-run", "--mesh-size", "2"]) in (0, 2)
    assert run_main(["--set", "contact.model=penalty", "--estimate-error", "--mesh-size", "1"]) == 2
    assert "comparison only" in capsys.readouterr().err

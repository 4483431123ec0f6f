"""Normal contact forces: the gradient of one potential, action and reaction."""

import numpy as np
import pytest

from fem.kernels import sample_kernels
from fem.kernels.contact_kernels import (
    push_contacts,
    ring_contacts,
    roller_contacts,
)
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import INNER, OUTER, ROLLER
from tests.reference.bearings import copies
from tests.reference.contact_states import (
    DT,
    cartesian_resultant,
    fill_ring,
    press,
    random_state,
    roller_field,
    roller_resultants,
    set_turns,
)


def potential(state):
    """Energy of all contacts, J."""
    pressed = press(state)
    return sample_kernels.contacts_energy(pressed.contacts, pressed.rollers.n, pressed.contacts.resolved)


class Motion:
    """A direction of motion in every coordinate the contacts know; zero unless asked for."""

    def __init__(self, state, seed, kinds):
        rng = np.random.default_rng(seed)
        n, nodes = state.rollers.n, state.rollers.mass.size

        def draw(kind, scale, *shape):
            return scale * rng.standard_normal(shape) * (kind in kinds)

        self.roller_u = draw("roller u", 1.0, nodes, 2, n)
        self.centre = draw("centre", 1.0, n, 2)
        self.turn = draw("turn", 1.0 / 0.005, n)
        self.inner_u = draw("inner u", 1.0, *state.inner.u[:, :, HALO:-HALO].shape)
        self.outer_u = draw("outer u", 1.0, *state.outer.u[:, :, HALO:-HALO].shape)
        self.hub = draw("hub", 1.0, 2)
        self.ring_turn = float(draw("ring turn", 1.0 / 0.018, 1)[0])

    def moved(self, state, step):
        state = copies(state)
        n = state.rollers.n
        roller_field(state, state.rollers.u)[:] += step * self.roller_u
        state.rollers.centre[:, :n] += step * self.centre.T
        set_turns(state, state.rollers.turn[:n] + step * self.turn, state.drive.ring[0] + step * self.ring_turn)
        fill_ring(state.inner.u, state.inner.u[:, :, HALO:-HALO] + step * self.inner_u)
        fill_ring(state.outer.u, state.outer.u[:, :, HALO:-HALO] + step * self.outer_u)
        state.drive.hub[:] += step * self.hub
        return state

    def power(self, state):
        """Power of all forces that `normal_contacts` exerts, as the time loop applies them, W."""
        pressed = press(state)
        rollers, n = pressed.rollers, pressed.rollers.n
        force = roller_field(pressed, rollers.w) * rollers.mass[:, None, None] / DT  # in the frames
        c, s = rollers.cosine[:n], rollers.sine[:n]
        centre = np.stack(
            [c * self.centre[:, 0] + s * self.centre[:, 1], c * self.centre[:, 1] - s * self.centre[:, 0]]
        )
        position = rollers.points.reshape(-1, 2, 1) + roller_field(pressed, rollers.u)
        turned = np.stack([-position[:, 1], position[:, 0]], axis=1) * self.turn
        total = np.sum(force * (self.roller_u + centre[None] + turned))
        total += np.sum(rollers.tilt[:, :n].T * self.centre) / DT
        total += rollers.inertia * (rollers.turn_kick[:n] @ self.turn) / DT
        for ring, rate, spin in ((pressed.inner, self.inner_u, self.ring_turn), (pressed.outer, self.outer_u, 0.0)):
            nodal = ring.w[:, :, HALO:-HALO] * ring.row_mass[:, None, None] / DT
            place = ring.u[:, :, HALO:-HALO].copy()
            place[:, 0] += ring.radii[:, None]
            total += np.sum(nodal * (rate + spin * np.stack([-place[:, 1], place[:, 0]], axis=1)))
        total += pressed.drive.impulse @ self.hub / DT
        # what the drive must hold against the contacts is what they exert on the frame, reversed
        return total - pressed.drive.ring[3] * self.ring_turn


ALONE = ("roller u", "centre", "turn", "inner u", "outer u", "hub", "ring turn")


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("kinds", [*((kind,) for kind in ALONE), ALONE], ids=[*ALONE, "all together"])
def test_contact_forces_are_the_gradient_of_the_contact_energy(kinds, seed):
    state = random_state(seed)
    motion = Motion(state, 100 + seed, kinds)
    closed = press(state).contacts.force > 0.0
    assert closed[INNER].sum() >= 4 and closed[OUTER].sum() >= 4 and closed[ROLLER, 3]
    found, total = motion.power(state), press(state).contacts.force.sum()

    def slope(step):
        ahead, behind = motion.moved(state, step), motion.moved(state, -step)
        for other in (ahead, behind):
            np.testing.assert_array_equal(press(other).contacts.force > 0.0, closed, "no contact opens on the way")
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
    closed = press(state).contacts.force > 0.0
    assert closed[INNER].sum() >= 4 and closed[OUTER].sum() >= 4 and closed[ROLLER, 3]
    found, total = motion.power(state), press(state).contacts.force.sum()

    def slope(step):
        return -(potential(motion.moved(state, step)) - potential(motion.moved(state, -step))) / (2.0 * step)

    # points that open within the step leave an error of first order in it; the chord's end a moment of spacing³
    assert found == pytest.approx(slope(1e-11), rel=0.0, abs=1e-6 * total)
    assert abs(found) > 1e-4 * total, "the comparison says something"


def test_the_tilt_terms_are_seen_by_the_gradient_test():
    """Forces at fixed patches alone miss the potential by the tilt of the surfaces."""
    state = random_state(1)
    pressed = press(state)
    total = pressed.contacts.force.sum()
    assert np.abs(pressed.rollers.tilt).max() / DT > 1e-5 * total
    assert np.abs(pressed.rollers.turn_kick).max() * pressed.rollers.inertia / DT > 1e-5 * total * 0.005
    assert np.abs(pressed.drive.impulse).max() / DT > 1e-5 * total
    assert abs(pressed.drive.ring[3]) > 1e-5 * total * 0.018


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", ["inner", "outer", "roller"])
def test_normal_forces_are_action_and_reaction(kind, seed):
    state = copies(random_state(seed))
    rollers, contacts, drive, slope = state.rollers, state.contacts, state.drive, state.scratch.slope
    if kind == "inner":
        ring_contacts(INNER, rollers, state.inner, state.outer, contacts, drive, slope)
    elif kind == "outer":
        ring_contacts(OUTER, rollers, state.inner, state.outer, contacts, drive, slope)
    else:
        roller_contacts(rollers, contacts, drive, slope)
    push_contacts(rollers, state.inner, state.outer, contacts, drive)
    number = {"inner": INNER, "outer": OUTER, "roller": ROLLER}[kind]
    Q, normal = contacts.force[number, :13], contacts.normal[number, :, :13].T
    scale, impulse, tilt = Q.sum() * DT, rollers.impulse[:, :13].T, rollers.tilt[:, :13].T
    fresh = random_state(seed)
    rollers.w[:] -= fresh.rollers.w
    state.inner.w[:] -= fresh.inner.w
    # the roller's centre gets what its nodes get; the force is Q along the line of centres, tilt apart
    np.testing.assert_allclose(roller_resultants(state), impulse, rtol=0.0, atol=1e-12 * scale)
    push = Q[:, None] * normal * DT
    wanted = {"inner": push, "outer": -push, "roller": np.roll(push, 1, axis=0) - push}[kind]
    np.testing.assert_allclose(impulse, wanted, rtol=0.0, atol=1e-13 * scale)
    # nodes push nodes, and the tilt of both surfaces pushes both bodies (of the outer ring: the ground)
    rings = cartesian_resultant(state.outer) + cartesian_resultant(state.inner, *drive.ring[1:3])
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
    rollers = state.rollers
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    pressed = press(state)
    assert pressed.contacts.force[ROLLER, 3] > 0.0
    angle, apart = np.arctan2(*rollers.centre[::-1, 12]), 2.0 * np.arcsin(0.2174)  # 12 and 0 touch: in the last group
    rollers.centre[:, 0] = 0.023 * np.cos(angle + apart), 0.023 * np.sin(angle + apart)
    rollers.centre[:, 13:] = rollers.centre[:, :1]
    pressed = press(state)
    assert pressed.contacts.force[ROLLER, 12] > 0.0
    for entry in (pressed.rollers.impulse, pressed.rollers.tilt, pressed.rollers.turn_kick, pressed.rollers.w):
        assert np.all(np.isfinite(entry))


def test_nothing_touches_nothing_pushes():
    state = random_state(1)
    state.drive.hub[:] = 0.0
    angle = 2.0 * np.pi * np.arange(13) / 13.0
    state.rollers.centre[:, :13] = 0.0229 * np.cos(angle), 0.0229 * np.sin(angle)
    pressed = press(state)  # 0.1 mm off the outer ring and into the inner one
    assert np.all(pressed.contacts.force[OUTER] == 0.0)
    assert np.all(pressed.contacts.force[ROLLER] == 0.0)
    assert np.all(pressed.contacts.force[INNER, :13] > 0.0)
    assert np.all(pressed.outer.w == 0.0)

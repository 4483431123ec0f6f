"""Tangential springs of contacts that stick: in series with creep, vibrating, dragged along, calibrated."""

import numpy as np
import pytest

from fem.contacts.points import disc_patch_traction, ring_patch_traction
from fem.kernels.lanes import WIDTH
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import INNER, OUTER, ROLLER
from tests.reference.bearings import copies, model, paper
from tests.reference.compiled import (
    follow_slips,
    pull_spring,
    spring_energy,
)
from tests.reference.contact_states import (
    DT,
    roller_field,
)
from tests.reference.rubbing import (
    rub,
    rubbing_state,
    stretched_state,
)


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

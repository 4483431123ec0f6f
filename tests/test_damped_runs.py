"""Damped runs and damped bodies; each test compiles loops of its own: all are slow."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.optimize import curve_fit

from fem.interface import simulate as run_scene
from fem.kernels.elements.damping import damp_bodies
from fem.kernels.elements.rings import HALO
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Housing
from fem.result.checkpoint import load_checkpoint, save_checkpoint
from fem.result.store import Stored, variables_of
from fem.solver.elements import plan as elements
from fem.solver.rigid import reduced
from fem.solver.simulate import make_plan
from fem.statics.equilibrium import static_equilibrium
from lagrange.scene.scene import parse_scene, read_scene
from tests.reference.kit import balance_of, ring_down

pytestmark = pytest.mark.slow
PLANS = {"fem": elements.make_plan, "reduced": reduced.make_plan}
ROLLING = ("numerics.mesh_size_mm=2", "numerics.duration_ms=1", "numerics.output_interval_us=5")
STILL = (
    "numerics.mesh_size_mm=2", "numerics.duration_ms=0.6", "numerics.output_interval_us=1", "operation.speed_rpm=0",
    "operation.gravity_m_s2=0", "contact.friction_coefficient=0",
)  # fmt: skip
LAWS = [(300.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.5)]  # N s/m, µs, s/m
PUSH = 1e-3  # m/s


def setting(constant, time, hunt_crossley):
    names = "contact_N_s_m", "contact_time_us", "hunt_crossley_s_m"
    return tuple(f"damping.{name}={value}" for name, value in zip(names, (constant, time, hunt_crossley), strict=True))


def plan_of(model, *settings):
    return PLANS[model](read_scene(None, (f"model={model}", *settings)))


def samples(state, count):
    """The next so many samples of a state, one array each."""
    found, first = [], state.done
    while state.done < first + count:
        block = state.advance(min(100, first + count - state.done))
        assert block.trouble is None and block.restarts is None
        found.append(block.samples)
    values = {name: np.concatenate([part.values[name] for part in found]) for name in found[0].values}
    return values | {"imbalance": np.concatenate([part.imbalance for part in found])}, found[-1].exchanged[-1]


@pytest.mark.parametrize("model", PLANS)
@pytest.mark.parametrize("time", [12.5, 50.0])
def test_strong_dampers_at_rest_take_energy_and_give_none(model, time):
    """Of a bearing that rolls quietly, where nothing strikes: what dampers take never falls."""
    plan = plan_of(model, *ROLLING, f"damping.contact_time_us={time}")
    found, exchanged = samples(plan.first_state(), 200)
    assert np.abs(found["imbalance"]).max() < 1e-5 * exchanged
    assert np.diff(found["work_damping_contact"]).min() >= -1e-9 * exchanged


def statics_around(plan):
    """Equilibria under a newton less and more than the load, and under the load."""
    loads = plan.operation.radial_load + np.array([-1.0, 1.0, 0.0])
    return [static_equilibrium(plan.model, replace(plan.operation, radial_load=load)) for load in loads]


def log_decrement_by_statics(plan, constant, time, hunt_crossley):
    """Of the hub's vertical mode, by what its contacts' whole approaches do in statics; and the rollers' part in it."""
    less, more, now = statics_around(plan)
    moved = more.hub[1] - less.hub[1]
    shape = (more.rho - less.rho) / moved
    lost, bearing = 0.0, plan.model.bearing
    for kind, name in enumerate(("inner_force", "outer_force")):
        force, law, level = getattr(now, name), plan.model.laws[kind], plan.model.whole_levels[kind]
        closed = force > 0.0
        soft = law.A * (level - 0.5 * np.log(force[closed]) - 0.5)
        rate = (getattr(more, name) - getattr(less, name))[closed] / moved * soft
        lost += np.sum((constant + 1e-6 * time / soft + 1.5 * hunt_crossley * force[closed]) * rate**2)
    mass = plan.operation.inner_mass + bearing.roller_mass * np.sum(shape**2)
    stiffness = 2.0 / abs(moved)
    return np.pi * lost / np.sqrt(mass * stiffness), shape


def log_decrement_by_modes(plan, constant, time, hunt_crossley):
    """Of the slowest mode of hub and rollers as masses on linear contacts, by eigenvalues."""
    model, start, n = plan.model, plan.start, plan.model.bearing.n_rollers
    force = np.concatenate([start.inner_force, start.outer_force])
    closed = force > 0.0
    soft = np.concatenate([law.softness(np.maximum(q, 1e-9)) for law, q in
                           ((model.inner_law, start.inner_force), (model.outer_law, start.outer_force))])  # fmt: skip
    stiff = np.linalg.inv((np.diag(soft) + model.contacts.compliance)[np.ix_(closed, closed)])
    overlap, j = np.zeros((2 * n, 2 + n)), np.arange(n)
    overlap[j, 0], overlap[j, 1], overlap[j, 2 + j], overlap[n + j, 2 + j] = (
        np.cos(start.angle), np.sin(start.angle), -1.0, 1.0,
    )  # fmt: skip
    overlap = overlap[closed]
    used = np.any(overlap != 0.0, axis=0)
    overlap = overlap[:, used]
    mass = np.concatenate([np.full(2, plan.operation.inner_mass), np.full(n, model.bearing.roller_mass)])[used, None]
    damping = constant + 1e-6 * time / soft[closed] + 1.5 * hunt_crossley * force[closed]
    forces = overlap.T @ stiff @ overlap, overlap.T @ (damping[:, None] * overlap)
    size = len(mass)
    first_order = np.block([[np.zeros((size, size)), np.eye(size)], [-forces[0] / mass, -forces[1] / mass]])
    values = np.linalg.eigvals(first_order)
    slowest = min(values[values.imag > 1e4], key=abs)
    return -2.0 * np.pi * slowest.real / slowest.imag


def push(state, shape):
    """Give the hub, the inner ring and the rollers the velocities of the hub's vertical mode."""
    if hasattr(state, "arrays"):
        bodies, ring = state.arrays.bodies.rollers, state.arrays.bodies.inner
        ring.w[:, 0, :] += PUSH * ring.sines
        ring.w[:, 1, :] += PUSH * ring.cosines
        state.arrays.drive.velocity[1] = PUSH
    else:
        bodies = state.bodies
        bodies.hub_velocity[1] = PUSH
    centre = bodies.centre[:, : bodies.n]
    bodies.velocity[:, : bodies.n] += PUSH * shape * centre / np.hypot(*centre)


def log_decrement(height):
    """Of a vibration about a place that drifts, sampled each µs, but for the first 0.1 ms, when rollers vibrate too."""

    def vibration(t, a, b, c, d, along, across, decay, frequency):
        swing = along * np.cos(frequency * t) + across * np.sin(frequency * t)
        return a + b * t + c * t**2 + d * t**3 + np.exp(-decay * t) * swing

    t = 1e-3 * np.arange(100, len(height))  # ms
    y = 1e9 * (height[100:] - height[0])
    found, _ = curve_fit(vibration, t, y, p0=[0.0, 0.0, 0.0, 0.0, 0.0, np.max(y), 3.0, 85.8])
    return 2.0 * np.pi * found[6] / found[7]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("model", ["fem", "reduced"])
def test_the_hub_s_free_vibration_dies_at_the_rate_that_theory_gives(model, law):
    by_statics, shape = log_decrement_by_statics(plan_of("fem", *STILL), *law)
    plan = plan_of(model, *STILL, *setting(*law))
    state = plan.first_state()
    push(state, shape)
    found = log_decrement(samples(state, 601)[0]["inner_y"])
    if model == "fem":
        assert found == pytest.approx(by_statics, rel=0.01)
    else:
        assert found == pytest.approx(log_decrement_by_modes(plan, *law), rel=1e-3)
        assert found == pytest.approx(by_statics, rel=0.03)  # neighbours on a ring are part of neither approach


@pytest.mark.parametrize(("model", "mesh_size"), [("fem", 2), ("fem", 1), ("reduced", 2)])
def test_energy_is_balanced_with_the_dissipated_work_of_each_kind(model, mesh_size):
    """From rest under a sudden load: contacts close, open and lose half of what they exchange.

    On 1 mm no contacts share nodes: these are given normal force, damper and friction together.
    """
    bodies = ("damping.bodies_1_s=20000",) if model == "fem" else ()
    start = "numerics.start=rest", "numerics.load_ramp_ms=0.05", f"numerics.mesh_size_mm={mesh_size}"
    found, exchanged = samples(
        plan_of(model, *ROLLING, *start, "damping.contact_N_s_m=2000", *bodies).first_state(), 201
    )
    still, also = samples(plan_of(model, *ROLLING, *start).first_state(), 201)
    unbalanced = np.abs(found["imbalance"]).max() / exchanged
    assert unbalanced < max(1.5 * np.abs(still["imbalance"]).max() / also, 2e-5)
    total, contacts, of_bodies = (found[f"work_{name}"] for name in ("dissipated", "damping_contact", "damping_bodies"))
    assert contacts[-1] > 0.2 * exchanged
    assert np.all(np.diff(contacts) >= -1e-12) and np.all(np.diff(of_bodies) >= 0.0)
    assert (of_bodies[-1] > 0.0) == (model == "fem")
    assert np.all(total - contacts - of_bodies > -1e-9)  # friction's
    assert found["inner_force"].min() >= 0.0 and found["outer_force"].min() >= 0.0


def unbalanced_over_a_spall(model, body, duration, **numerics):
    """Of a damped run whose rollers cross it: the energy that is missing, and damped, over what is exchanged."""
    spall = {"body": body, "width_mm": 1.0, "angle_deg": 10.0} | ({"roller": 3} if body == "roller" else {})
    tables = {
        "model": model, "spall": [spall], "damping": {"contact_time_us": 5.0},
        "numerics": {"duration_ms": duration, "output_interval_us": 5.0, **numerics},
    }  # fmt: skip
    plan = PLANS[model](parse_scene(tables, ""))
    state = (plan if model == "fem" else replace(plan, sections=None)).first_state()  # steps of one length
    found, exchanged = samples(state, round(200 * duration) + 1)
    return np.abs(found["imbalance"]).max() / exchanged, found["work_damping_contact"][-1] / exchanged


@pytest.mark.parametrize("turning", ["outer_ring", "inner_ring", "roller"])
def test_energy_is_balanced_where_damped_rollers_cross_the_edges_of_a_spall(turning):
    """Dampers resist surfaces that pass: they push rollers along these, turn them and brake the shaft.

    With a damper's last force along the surface, or the surface's last rate, the balance is off by 3e-3 here.
    """
    missing, damped = unbalanced_over_a_spall("reduced", turning, 30.0)
    assert missing < 1e-4 and damped > 0.1


@pytest.mark.parametrize("turning", ["outer_ring", "inner_ring", "roller"])
def test_finite_elements_lose_energy_by_the_square_of_the_step_there(turning):
    """As without dampers; with a damper's last force along the surface it is 8e-3, whatever the step."""
    missing, damped = zip(
        *(unbalanced_over_a_spall("fem", turning, 15.0, mesh_size_mm=2, time_step_safety=safety)
          for safety in (0.9, 0.45)), strict=True)  # fmt: skip
    assert missing[0] < 1e-4 and missing[1] < 0.4 * missing[0]
    assert min(damped) > 0.1


def test_energy_is_balanced_where_damped_rollers_strike_each_other():
    """Without friction and cage the load pushes them out of its zone; both raceways and neighbours damp them at once.

    By the two rollers' own kicks alone dampers' work is off by 3e-4 of the energy exchanged in 8 ms, whatever the step.
    """
    tables = {
        "model": "reduced", "bearing": {"designation": "NU206"}, "damping": {"contact_time_us": 10.0},
        "operation": {"speed_rpm": 600.0, "radial_load_N": 3000.0}, "contact": {"friction_coefficient": 0.0},
        "numerics": {"duration_ms": 8.0, "output_interval_us": 20.0, "time_step_safety": 0.2},
    }  # fmt: skip
    found, exchanged = samples(reduced.make_plan(parse_scene(tables, "")).first_state(), 401)
    assert found["roller_roller_force"].max() > 10.0
    assert np.abs(found["imbalance"]).max() < 5e-6 * exchanged


@pytest.mark.parametrize("model", ["fem", "reduced"])
def test_the_statics_are_those_without_damping_and_a_hub_that_was_pushed_comes_back_there(model):
    damped, plain = plan_of(model, *STILL, "damping.contact_N_s_m=2000"), plan_of(model, *STILL)
    np.testing.assert_array_equal(damped.static_hub(), plain.static_hub())
    if model == "reduced":  # damped meshes keep their lumped masses
        assert damped.critical_time_step == plain.critical_time_step
    state = damped.first_state()
    push(state, np.zeros(damped.model.bearing.n_rollers))
    found, _ = samples(state, 601)
    assert np.ptp(found["inner_y"]) > 5e-9
    # rollers that have been pushed slide on, without friction, and let the hub down by 0.2 nm
    assert found["inner_y"][-1] == pytest.approx(samples(plain.first_state(), 1)[0]["inner_y"][0], abs=3e-10)
    assert np.abs(found["inner_damping_force"][-1]).max() < 0.5


@pytest.mark.parametrize("model", ["fem", "reduced"])
def test_a_damped_run_goes_on_from_its_checkpoint_with_the_same_bits(model, tmp_path):
    plan = plan_of(
        model, *ROLLING, "damping.hunt_crossley_s_m=2", *(("damping.bodies_1_s=500",) if model == "fem" else ())
    )
    whole, _ = samples(plan.first_state(), 60)
    first = plan.first_state()
    samples(first, 25)
    stored = Stored(samples=25, checksums=dict.fromkeys(variables_of(plan.scene), 0))
    save_checkpoint(tmp_path / "run.nc", first, stored)
    second, _ = load_checkpoint(tmp_path / "run.nc", plan)
    rest, _ = samples(second, 35)
    for name in ("inner_y", "roller_x", "inner_damping_force", "work_dissipated"):
        np.testing.assert_array_equal(rest[name], whole[name][25:])


def test_a_body_that_moves_and_turns_as_a_whole_is_not_damped():
    """No load, no friction, no gravity: spinning rings and rollers only grow, and keep their energy."""
    free = "operation.radial_load_N=0", "operation.gravity_m_s2=0", "contact.friction_coefficient=0"
    damped = "damping.bodies_1_s=1e4", "damping.contact_N_s_m=1"
    found, _ = samples(plan_of("fem", *ROLLING, *free, *damped).first_state(), 201)
    kinetic = found["energy_kinetic"]
    assert found["work_damping_bodies"][-1] < 1e-9 * kinetic[0]
    assert np.ptp(kinetic) < 1e-7 * kinetic[0]


# Damping of bodies: what moves and turns as a whole is not braked, what else moves dies, momentum is kept


pytestmark = pytest.mark.slow  # kernels of their own; whole runs
RATE = 5000.0  # 1/s
HELD = {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
IN_PLAY = {"kind": "bore", "fit_clearance_um": 20.0}
COARSE = {"mesh_size_mm": 2.0}


@njit(**OPTIONS)
def damp_once(bodies, drive, damping):
    damp_bodies(bodies, drive, damping)


class Outer:
    """The outer ring of a bearing's arrays, in fixed axes."""

    def __init__(self, support):
        tables = {"support": support, "damping": {"bodies_1_s": RATE}, "numerics": COARSE}
        self.arrays = make_plan(parse_scene(tables, "")).arrays()
        self.ring = ring = self.arrays.bodies.outer
        self.rows, self.nodes = slice(ring.first_row, ring.last_row), slice(HALO, HALO + ring.n_sectors)
        self.mass = np.broadcast_to(ring.row_mass[self.rows, None], self.place.shape)

    def _cartesian(self, polar):
        outward = (self.ring.cosines + 1j * self.ring.sines)[self.nodes]
        return (polar[self.rows, 0, self.nodes] + 1j * polar[self.rows, 1, self.nodes]) * outward

    @property
    def place(self):
        """Of the nodes, m, as complex numbers, half a step back, where velocities are."""
        polar = self.ring.u - 0.5 * self.arrays.drive.dt * self.ring.w
        polar[:, 0] += self.ring.radii[:, None]
        return self._cartesian(polar)

    @property
    def velocity(self):
        return self._cartesian(self.ring.w)

    def move(self, velocity):
        """Give the nodes these velocities, m/s."""
        outward = (self.ring.cosines + 1j * self.ring.sines)[self.nodes]
        polar = velocity * np.conj(outward)
        self.ring.w[self.rows, 0, self.nodes], self.ring.w[self.rows, 1, self.nodes] = polar.real, polar.imag

    def damp(self):
        arrays = self.arrays
        damp_once(arrays.bodies, arrays.drive, arrays.bodies.damping)

    @property
    def momentum(self):
        """And the angular one about the origin."""
        return np.sum(self.mass * self.velocity), np.sum(self.mass * (np.conj(self.place) * self.velocity).imag)


def shaken(ring, size):
    """Velocities of its nodes in no order, m/s."""
    random = np.random.default_rng(3)
    return size * (random.standard_normal(ring.mass.shape) + 1j * random.standard_normal(ring.mass.shape))


def test_a_ring_goes_with_its_housing_undamped_and_gives_it_what_its_own_motion_loses():
    outer = Outer(HELD)
    (housing,) = (body for body in outer.arrays.bodies.others if isinstance(body, Housing))
    housing.velocity[:] = 0.3, -0.2
    whole = np.full(outer.mass.shape, 0.3 - 0.2j)
    outer.move(whole)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole, rtol=1e-13)
    np.testing.assert_allclose(housing.impulse, 0.0, atol=1e-15)
    own = shaken(outer, 0.1)
    outer.move(whole + own)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole + own * np.exp(-RATE * outer.arrays.drive.dt), rtol=1e-12)
    given = np.sum(outer.mass * (whole + own - outer.velocity))
    np.testing.assert_allclose(housing.impulse, [given.real, given.imag], rtol=1e-9)


def test_a_ring_in_play_keeps_its_momentum_and_its_turning():
    outer = Outer(IN_PLAY)
    for _ in range(3):  # places half a step back follow the velocities
        whole = 0.3 - 0.2j + 40j * outer.place
        outer.move(whole)
    outer.damp()
    np.testing.assert_allclose(outer.velocity, whole, rtol=1e-12)
    outer.move(whole + shaken(outer, 0.1))
    before, lost = outer.momentum, outer.velocity
    outer.damp()
    assert np.abs(outer.velocity - lost).max() > 1e-5
    np.testing.assert_allclose(outer.momentum, before, rtol=1e-7)  # places half a step back move with the velocities


def test_a_housing_rings_down_as_if_bodies_were_not_damped():
    """√(k/M)/2π and c/2√(kM) of all that swings on its springs; with a ring damped against the ground ζ would be 0.09.

    Rollers, which nothing holds along the raceways, swing there by themselves.
    """
    tables = {
        "bearing": {"outer_raceway_diameter_mm": 55.98},
        "operation": {"speed_rpm": 0.0, "gravity_m_s2": 0.0, "radial_load_N": 0.0},
        "contact": {"friction_coefficient": 0.0}, "damping": {"bodies_1_s": RATE}, "support": {"kind": "housing"},
        "numerics": COARSE | {"duration_ms": 24.0, "output_interval_us": 50.0},
    }  # fmt: skip
    plan = make_plan(parse_scene(tables, ""))
    state, bearing = plan.first_state(), plan.model.bearing
    bodies = state.arrays.bodies
    (housing,) = (body for body in bodies.others if isinstance(body, Housing))
    for ring in (bodies.inner, bodies.outer):
        ring.w[:, 0, :] += 1e-3 * ring.sines
        ring.w[:, 1, :] += 1e-3 * ring.cosines
    bodies.rollers.velocity[1, : bearing.n_rollers] += 1e-3
    housing.velocity[1] = state.arrays.drive.velocity[1] = 1e-3
    found = []
    while state.done < plan.n_samples:
        block = state.advance(100)
        assert block.trouble is None
        found.append(block.samples.values)
    place = np.concatenate([values["housing_y"] for values in found])
    rollers = 0.5 * bearing.n_rollers * bearing.roller_mass  # along their radii: nothing moves them across
    mass = 12.638 + bearing.outer_ring_mass + plan.operation.inner_mass + rollers
    frequency, zeta = ring_down(place[3:], 5e-5)
    assert frequency == pytest.approx(np.sqrt(15.1e6 / mass) / (2.0 * np.pi), rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * mass)), rel=2e-3)
    assert found[-1]["work_damping_bodies"][-1] < 1e-6 * found[-1]["work_dissipated"][-1]


@pytest.mark.parametrize(("support", "limit"), [(HELD, 1e-4), (IN_PLAY, 5e-4)], ids=["housing", "bore"])
def test_energy_is_balanced_to_the_square_of_the_step_where_the_outer_ring_moves(support, limit):
    """From rest under a sudden load."""
    missing = []
    for safety in (0.9, 0.45):
        numerics = COARSE | {"duration_ms": 1.0, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 5.0,
                             "time_step_safety": safety}  # fmt: skip
        tables = {"damping": {"bodies_1_s": 2e4}, "support": support, "numerics": numerics}
        result = run_scene(parse_scene(tables, ""))
        assert result.values["work_damping_bodies"][-1] > 10.0 * limit * np.ptp(result.energies["energy_kinetic"])
        missing.append(balance_of(result))
    assert missing[0] < limit and missing[1] < 0.3 * missing[0]

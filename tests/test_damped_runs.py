"""Damped runs and damped bodies; each test compiles loops of its own: all are slow."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import curve_fit

from fem.interface import simulate as run_scene
from fem.kernels.elements.damping import damp_bodies
from fem.kernels.elements.rings import HALO
from fem.kernels.jit import kernel
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
BOTH = pytest.mark.parametrize("model", PLANS)
ROLLING = ("numerics.mesh_size_mm=2", "numerics.duration_ms=1", "numerics.output_interval_us=5")
STILL = (
    "numerics.mesh_size_mm=2", "numerics.duration_ms=0.6", "numerics.output_interval_us=1", "operation.speed_rpm=0",
    "operation.gravity_m_s2=0", "contact.friction_coefficient=0",
)  # fmt: skip
PUSH = 1e-3  # m/s


def plan_of(model, *settings):
    return PLANS[model](read_scene(None, (f"model={model}", *settings)))


def samples(state, count):
    """The next so many samples of a state, one array each, and the energy exchanged."""
    found, end = [], state.done + count
    while state.done < end:
        block = state.advance(min(100, end - state.done))
        assert block.trouble is None and block.restarts is None
        found.append(block.samples)
    values = {name: np.concatenate([part.values[name] for part in found]) for name in found[0].values}
    return values | {"imbalance": np.concatenate([part.imbalance for part in found])}, found[-1].exchanged[-1]


def missing(found, exchanged):
    return np.abs(found["imbalance"]).max() / exchanged


@BOTH
@pytest.mark.parametrize("time", [12.5, 50.0])
def test_strong_dampers_at_rest_take_energy_and_give_none(model, time):
    """Of a bearing that rolls quietly, where nothing strikes: what dampers take never falls."""
    found, exchanged = samples(plan_of(model, *ROLLING, f"damping.contact_time_us={time}").first_state(), 200)
    assert missing(found, exchanged) < 1e-5
    assert np.diff(found["work_damping_contact"]).min() >= -1e-9 * exchanged


def log_decrement_by_statics(plan, constant, time, hunt_crossley):
    """Of the hub's vertical mode, by what its contacts' whole approaches do in statics; and the rollers' part in it."""
    loads = plan.operation.radial_load + np.array([-1.0, 1.0, 0.0])
    less, more, now = (static_equilibrium(plan.model, replace(plan.operation, radial_load=load)) for load in loads)
    moved, lost, bearing = more.hub[1] - less.hub[1], 0.0, plan.model.bearing
    shape = (more.rho - less.rho) / moved
    for kind, name in enumerate(("inner_force", "outer_force")):
        force, law, level = getattr(now, name), plan.model.laws[kind], plan.model.whole_levels[kind]
        closed = force > 0.0
        soft = law.A * (level - 0.5 * np.log(force[closed]) - 0.5)
        rate = (getattr(more, name) - getattr(less, name))[closed] / moved * soft
        lost += np.sum((constant + 1e-6 * time / soft + 1.5 * hunt_crossley * force[closed]) * rate**2)
    mass = plan.operation.inner_mass + bearing.roller_mass * np.sum(shape**2)
    return np.pi * lost / np.sqrt(mass * 2.0 / abs(moved)), shape


def log_decrement_by_modes(plan, constant, time, hunt_crossley):
    """Of the slowest mode of hub and rollers as masses on linear contacts, by eigenvalues."""
    model, start, n = plan.model, plan.start, plan.model.bearing.n_rollers
    force = np.concatenate([start.inner_force, start.outer_force])
    closed, (inner, outer) = force > 0.0, np.maximum(force, 1e-9).reshape(2, n)
    soft = np.concatenate([model.inner_law.softness(inner), model.outer_law.softness(outer)])
    stiff = np.linalg.inv((np.diag(soft) + model.contacts.compliance)[np.ix_(closed, closed)])
    overlap, j = np.zeros((2 * n, 2 + n)), np.arange(n)
    overlap[j, 0], overlap[j, 1] = np.cos(start.angle), np.sin(start.angle)
    overlap[j, 2 + j], overlap[n + j, 2 + j] = -1.0, 1.0
    used = np.any(overlap[closed] != 0.0, axis=0)
    overlap = overlap[closed][:, used]
    mass = np.concatenate([np.full(2, plan.operation.inner_mass), np.full(n, model.bearing.roller_mass)])[used, None]
    damping = constant + 1e-6 * time / soft[closed] + 1.5 * hunt_crossley * force[closed]
    forces, size = (overlap.T @ stiff @ overlap / mass, overlap.T @ (damping[:, None] * overlap) / mass), len(mass)
    values = np.linalg.eigvals(np.block([[np.zeros((size, size)), np.eye(size)], [-forces[0], -forces[1]]]))
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


@pytest.mark.parametrize("law", [(300.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.5)])  # N s/m, µs, s/m
@BOTH
def test_the_hub_s_free_vibration_dies_at_the_rate_that_theory_gives(model, law):
    by_statics, shape = log_decrement_by_statics(plan_of("fem", *STILL), *law)
    names = "contact_N_s_m", "contact_time_us", "hunt_crossley_s_m"
    plan = plan_of(model, *STILL, *(f"damping.{name}={value}" for name, value in zip(names, law, strict=True)))
    state = plan.first_state()
    push(state, shape)
    found = log_decrement(samples(state, 601)[0]["inner_y"])
    # neighbours on a ring are part of neither approach
    assert found == pytest.approx(by_statics, rel=0.01 if model == "fem" else 0.03)
    assert model == "fem" or found == pytest.approx(log_decrement_by_modes(plan, *law), rel=1e-3)


@pytest.mark.parametrize(("model", "mesh_size"), [("fem", 2), ("fem", 1), ("reduced", 2)])
def test_energy_is_balanced_with_the_dissipated_work_of_each_kind(model, mesh_size):
    """From rest under a sudden load: contacts close, open and lose half of what they exchange.

    On 1 mm no contacts share nodes: these are given normal force, damper and friction together.
    """
    start = *ROLLING, "numerics.start=rest", "numerics.load_ramp_ms=0.05", f"numerics.mesh_size_mm={mesh_size}"
    damped = "damping.contact_N_s_m=2000", *(("damping.bodies_1_s=20000",) if model == "fem" else ())
    found, exchanged = samples(plan_of(model, *start, *damped).first_state(), 201)
    still = samples(plan_of(model, *start).first_state(), 201)
    assert missing(found, exchanged) < max(1.5 * missing(*still), 2e-5)
    total, contacts, of_bodies = (found[f"work_{name}"] for name in ("dissipated", "damping_contact", "damping_bodies"))
    assert contacts[-1] > 0.2 * exchanged and (of_bodies[-1] > 0.0) == (model == "fem")
    assert np.all(np.diff(contacts) >= -1e-12) and np.all(np.diff(of_bodies) >= 0.0)
    assert np.all(total - contacts - of_bodies > -1e-9)  # friction's
    assert min(found["inner_force"].min(), found["outer_force"].min()) >= 0.0


@pytest.mark.parametrize("body", ["outer_ring", "inner_ring", "roller"])
@pytest.mark.parametrize(("model", "duration", "ways"), [
    ("reduced", 30.0, [{}]), ("fem", 15.0, [{"mesh_size_mm": 2, "time_step_safety": share} for share in (0.9, 0.45)]),
], ids=["reduced", "fem"])  # fmt: skip
def test_energy_is_balanced_where_damped_rollers_cross_the_edges_of_a_spall(model, duration, ways, body):
    """Dampers resist surfaces that pass: they push rollers along these, turn them and brake the shaft.

    With a damper's last force along the surface, or the surface's last rate, the balance is off by 3e-3 here, by 8e-3
    with finite elements, whatever the step; as it is these lose energy by the square of the step, as without dampers.
    """
    spall, left = {"body": body, "width_mm": 1.0, "angle_deg": 10.0} | ({"roller": 3} if body == "roller" else {}), []
    for numerics in ways:
        plan = PLANS[model](parse_scene({
            "model": model, "spall": [spall], "damping": {"contact_time_us": 5.0},
            "numerics": {"duration_ms": duration, "output_interval_us": 5.0, **numerics},
        }, ""))  # fmt: skip
        state = (plan if model == "fem" else replace(plan, sections=None)).first_state()  # steps of one length
        found, exchanged = samples(state, round(200 * duration) + 1)
        left.append(missing(found, exchanged))
        assert found["work_damping_contact"][-1] > 0.1 * exchanged
    assert left[0] < 1e-4 and (model == "reduced" or left[1] < 0.4 * left[0])


def test_energy_is_balanced_where_damped_rollers_strike_each_other():
    """Without friction and cage the load pushes them out of its zone; both raceways and neighbours damp them at once.

    By the two rollers' own kicks alone dampers' work is off by 3e-4 of the energy exchanged in 8 ms, whatever the step.
    """
    plan = reduced.make_plan(parse_scene({
        "model": "reduced", "bearing": {"designation": "NU206"}, "damping": {"contact_time_us": 10.0},
        "operation": {"speed_rpm": 600.0, "radial_load_N": 3000.0}, "contact": {"friction_coefficient": 0.0},
        "numerics": {"duration_ms": 8.0, "output_interval_us": 20.0, "time_step_safety": 0.2},
    }, ""))  # fmt: skip
    found, exchanged = samples(plan.first_state(), 401)
    assert found["roller_roller_force"].max() > 10.0 and missing(found, exchanged) < 5e-6


@BOTH
def test_the_statics_are_those_without_damping_and_a_hub_that_was_pushed_comes_back_there(model):
    damped, plain = plan_of(model, *STILL, "damping.contact_N_s_m=2000"), plan_of(model, *STILL)
    assert_array_equal(damped.static_hub(), plain.static_hub())
    # damped meshes keep their lumped masses
    assert model == "fem" or damped.critical_time_step == plain.critical_time_step
    state = damped.first_state()
    push(state, np.zeros(damped.model.bearing.n_rollers))
    found, _ = samples(state, 601)
    assert np.ptp(found["inner_y"]) > 5e-9
    # rollers that have been pushed slide on, without friction, and let the hub down by 0.2 nm
    assert found["inner_y"][-1] == pytest.approx(samples(plain.first_state(), 1)[0]["inner_y"][0], abs=3e-10)
    assert np.abs(found["inner_damping_force"][-1]).max() < 0.5


@BOTH
def test_a_damped_run_goes_on_from_its_checkpoint_with_the_same_bits(model, tmp_path):
    bodies = ("damping.bodies_1_s=500",) if model == "fem" else ()
    plan = plan_of(model, *ROLLING, "damping.hunt_crossley_s_m=2", *bodies)
    whole, first = samples(plan.first_state(), 60)[0], plan.first_state()
    samples(first, 25)
    stored = Stored(samples=25, checksums=dict.fromkeys(variables_of(plan.scene), 0))
    save_checkpoint(tmp_path / "run.nc", first, stored)
    rest, _ = samples(load_checkpoint(tmp_path / "run.nc", plan)[0], 35)
    for name in ("inner_y", "roller_x", "inner_damping_force", "work_dissipated"):
        assert_array_equal(rest[name], whole[name][25:])


def test_a_body_that_moves_and_turns_as_a_whole_is_not_damped():
    """No load, no friction, no gravity: spinning rings and rollers only grow, and keep their energy."""
    free = "operation.radial_load_N=0", "operation.gravity_m_s2=0", "contact.friction_coefficient=0"
    damped = "damping.bodies_1_s=1e4", "damping.contact_N_s_m=1"
    found, _ = samples(plan_of("fem", *ROLLING, *free, *damped).first_state(), 201)
    kinetic = found["energy_kinetic"]
    assert found["work_damping_bodies"][-1] < 1e-9 * kinetic[0] and np.ptp(kinetic) < 1e-7 * kinetic[0]


# Damping of bodies: what moves and turns as a whole is not braked, what else moves dies, momentum is kept

RATE = 5000.0  # 1/s
HELD = {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
IN_PLAY = {"kind": "bore", "fit_clearance_um": 20.0}
COARSE = {"mesh_size_mm": 2.0}


damp_once = kernel(damp_bodies)


def outer_ring(support):
    """Arrays with a damped outer ring, its nodes' masses, directions outwards, and a field of it in fixed axes."""
    tables = {"support": support, "damping": {"bodies_1_s": RATE}, "numerics": COARSE}
    arrays = make_plan(parse_scene(tables, "")).arrays()
    ring = arrays.bodies.outer
    rows, nodes = slice(ring.first_row, ring.last_row), slice(HALO, HALO + ring.n_sectors)
    outward = (ring.cosines + 1j * ring.sines)[nodes]

    def seen(polar):
        return (polar[rows, 0, nodes] + 1j * polar[rows, 1, nodes]) * outward

    def move(velocity):
        polar = velocity * np.conj(outward)
        ring.w[rows, 0, nodes], ring.w[rows, 1, nodes] = polar.real, polar.imag

    def place():
        """m, half a step back, where velocities are."""
        polar = ring.u - 0.5 * arrays.drive.dt * ring.w
        polar[:, 0] += ring.radii[:, None]
        return seen(polar)

    def damp():
        damp_once(arrays.bodies, arrays.drive, arrays.bodies.damping)
        return seen(ring.w)

    mass = np.broadcast_to(ring.row_mass[rows, None], place().shape)
    real, imaginary = np.random.default_rng(3).standard_normal((2, *mass.shape))
    return arrays, mass, place, move, damp, 0.1 * (real + 1j * imaginary)


def test_a_ring_goes_with_its_housing_undamped_and_gives_it_what_its_own_motion_loses():
    arrays, mass, _, move, damp, shaken = outer_ring(HELD)
    (housing,) = (body for body in arrays.bodies.others if isinstance(body, Housing))
    housing.velocity[:] = 0.3, -0.2
    whole = np.full(mass.shape, 0.3 - 0.2j)
    move(whole)
    assert_allclose(damp(), whole, rtol=1e-13)
    assert_allclose(housing.impulse, 0.0, atol=1e-15)
    move(whole + shaken)
    left = damp()
    assert_allclose(left, whole + shaken * np.exp(-RATE * arrays.drive.dt), rtol=1e-12)
    given = np.sum(mass * (whole + shaken - left))
    assert_allclose(housing.impulse, [given.real, given.imag], rtol=1e-9)


def test_a_ring_in_play_keeps_its_momentum_and_its_turning():
    _, mass, place, move, damp, shaken = outer_ring(IN_PLAY)
    for _ in range(3):  # places half a step back follow the velocities
        whole = 0.3 - 0.2j + 40j * place()
        move(whole)
    assert_allclose(damp(), whole, rtol=1e-12)

    def momenta(velocity):
        return np.sum(mass * velocity), np.sum(mass * (np.conj(place()) * velocity).imag)

    move(whole + shaken)
    before = momenta(whole + shaken)
    after = damp()
    assert np.abs(after - whole - shaken).max() > 1e-5
    assert_allclose(momenta(after), before, rtol=1e-7)  # places half a step back move with the velocities


def test_a_housing_rings_down_as_if_bodies_were_not_damped():
    """√(k/M)/2π and c/2√(kM) of all that swings on its springs; with a ring damped against the ground ζ would be 0.09.

    Rollers, which nothing holds along the raceways, swing there by themselves.
    """
    plan = make_plan(parse_scene({
        "bearing": {"outer_raceway_diameter_mm": 55.98},
        "operation": {"speed_rpm": 0.0, "gravity_m_s2": 0.0, "radial_load_N": 0.0},
        "contact": {"friction_coefficient": 0.0}, "damping": {"bodies_1_s": RATE}, "support": {"kind": "housing"},
        "numerics": COARSE | {"duration_ms": 24.0, "output_interval_us": 50.0},
    }, ""))  # fmt: skip
    state, bearing = plan.first_state(), plan.model.bearing
    bodies = state.arrays.bodies
    (housing,) = (body for body in bodies.others if isinstance(body, Housing))
    for ring in (bodies.inner, bodies.outer):
        ring.w[:, 0, :] += PUSH * ring.sines
        ring.w[:, 1, :] += PUSH * ring.cosines
    bodies.rollers.velocity[1, : bearing.n_rollers] += PUSH
    housing.velocity[1] = state.arrays.drive.velocity[1] = PUSH
    found, _ = samples(state, plan.n_samples)
    rollers = 0.5 * bearing.n_rollers * bearing.roller_mass  # along their radii: nothing moves them across
    mass = 12.638 + bearing.outer_ring_mass + plan.operation.inner_mass + rollers
    frequency, zeta = ring_down(found["housing_y"][3:], 5e-5)
    assert frequency == pytest.approx(np.sqrt(15.1e6 / mass) / (2.0 * np.pi), rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * mass)), rel=2e-3)
    assert found["work_damping_bodies"][-1] < 1e-6 * found["work_dissipated"][-1]


@pytest.mark.parametrize(("support", "limit"), [(HELD, 1e-4), (IN_PLAY, 5e-4)], ids=["housing", "bore"])
def test_energy_is_balanced_to_the_square_of_the_step_where_the_outer_ring_moves(support, limit):
    """From rest under a sudden load."""
    left, more = [], {"duration_ms": 1.0, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 5.0}
    for safety in (0.9, 0.45):
        numerics = COARSE | more | {"time_step_safety": safety}
        tables = {"damping": {"bodies_1_s": 2e4}, "support": support, "numerics": numerics}
        result = run_scene(parse_scene(tables, ""))
        assert result.values["work_damping_bodies"][-1] > 10.0 * limit * np.ptp(result.energies["energy_kinetic"])
        left.append(balance_of(result))
    assert left[0] < limit and left[1] < 0.3 * left[0]

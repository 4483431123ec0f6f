"""Bodies declared rigid: statics against exact series, their motion, balances, what is refused."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.linalg import block_diag, eigh
from scipy.optimize import brentq

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.points import ring_patch_force
from fem.kernels.sample_kernels import HUB_Y
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_statics
from lagrange import contact_laws, kinematics
from lagrange.scene.scene import parse_scene, parse_scene_text
from tests.reference.bearings import LENGTH, STEEL, arrays, block, model, operation, paper, run
from tests.reference.line_contact import half_width, squeezed_disc_approach
from tests.reference.refusals import assert_refused, refusal
from tests.stability.random_scenes import random_scene
from tests.verification.runs import every_step, plan_of, record, without_spin

RIGID = replace(STEEL, rigid=True)
BODIES = {"rollers": "roller", "inner_ring": "inner_ring", "outer_ring": "outer_ring"}  # scene: Bearing
ALLOWED = (("rollers",), ("inner_ring",), ("outer_ring",), ("inner_ring", "outer_ring"))
every_choice = pytest.mark.parametrize("names", ALLOWED, ids=" and ".join)
every_run = pytest.mark.parametrize(
    "names", [pytest.param(names, marks=pytest.mark.slow, id=" and ".join(names)) for names in ALLOWED]
)  # each is a time loop of its own to compile; `test_a_rigid_inner_ring_is_the_hub` runs with every change
LOAD, HALF_PITCH = 2000.0, -np.pi / 2.0 + np.pi / 13.0


def bearing_with(names, material=RIGID, **changes):
    """The paper's bearing with some bodies of another material."""
    return paper(**{BODIES[name]: material for name in names}, **changes)


def settings(names):
    return {f"bodies__{name}": "rigid" for name in names}


# scene ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ('[bodies]\nrollers = "rigid"\nouter_ring = "rigid"', ["bodies", 'outer_ring = "rigid"', "--model lagrange"]),
        (
            '[bodies]\nrollers = "rigid"\ninner_ring = "rigid"\nouter_ring = "rigid"',
            ['inner_ring = "rigid" and outer_ring = "rigid"', "no compliance", "--model lagrange"],
        ),
        ('[bodies]\nrollers = "stiff"', ["bodies.rollers = 'stiff'", "'elastic' or 'rigid'"]),
        ('[bodies]\nroller = "rigid"', ["bodies.roller", "did you mean rollers?"]),
        ('[bodies]\nouter_ring = "rigid"\n[contact]\nmodel = "resolved"', ["bodies.outer_ring", '"subgrid"']),
        ('[bodies]\nrollers = "rigid"\n[contact]\nmodel = "penalty"', ["bodies.rollers", '"penalty"']),
    ],
)
def test_what_can_not_be_rigid_is_named(tables, words):
    assert_refused(tables, *words)
    assert "\n" not in refusal(tables)


def test_contacts_wider_than_the_mesh_need_elastic_bodies(capsys):
    """Points of pressure sit on the surface nodes of both bodies, and a rigid body has none."""
    how = ["--mesh-size", "0.05", "--set", 'bodies.rollers="rigid"', "--set", "operation.radial_load_N=20000"]
    assert run_main([*how, "--dry-run"]) == 2
    said = capsys.readouterr().err
    assert "bodies.rollers" in said and "numerics.mesh_size_mm = 0.05" in said and "at least 0." in said


def test_all_elastic_is_the_default_and_the_table_survives_the_round_trip():
    assert parse_scene_text("", "s.toml") == parse_scene_text('[bodies]\nrollers = "elastic"', "s.toml")
    scene = parse_scene_text('[bodies]\ninner_ring = "rigid"', "s.toml")
    assert parse_scene_text(scene.to_toml(), "again") == scene
    bearing = scene.ideal_bearing()
    assert bearing.inner_ring.rigid and not bearing.outer_ring.rigid and not bearing.roller.rigid
    assert bearing.inner_ring.density == STEEL.density


def test_laws_that_know_the_material_know_a_rigid_body():
    """Half the compliance is a contact modulus twice as large; the one with a rigid roller is the ring's alone."""
    elastic, rigid = (contact_laws("houpert", bearing) for bearing in (paper(), bearing_with(["rollers"])))
    assert rigid.inner.stiffness == pytest.approx(2.0 * elastic.inner.stiffness, rel=1e-12)
    stiff = replace(STEEL, youngs_modulus=1e9 * STEEL.youngs_modulus)
    for names in ALLOWED:
        found, wanted = (contact_laws("johnson", bearing_with(names, material)) for material in (RIGID, stiff))
        for side in ("inner", "outer"):
            assert getattr(found, side).approach(500.0) == pytest.approx(getattr(wanted, side).approach(500.0), 1e-7)


# statics --------------------------------------------------------------------------------------------------------


@every_choice
def test_the_equilibrium_is_that_of_exact_series_with_an_infinite_modulus(names):
    stiff = replace(STEEL, youngs_modulus=1e9 * STEEL.youngs_modulus)
    exact = exact_statics(bearing_with(names, stiff), LOAD, HALF_PITCH)
    bearing = bearing_with(names)
    found = equilibrium(model(bearing, 1e-3), standing(bearing, HALF_PITCH), Loads(LOAD))
    np.testing.assert_allclose(found.hub, exact.hub, rtol=0.0, atol=1e-3 * np.linalg.norm(exact.hub))
    np.testing.assert_allclose(found.inner_force, exact.inner_force, rtol=0.0, atol=1e-3 * exact.inner_force.max())
    same = exact_statics(bearing, LOAD, HALF_PITCH)
    np.testing.assert_allclose(same.hub, exact.hub, rtol=1e-7, atol=1e-15)


def test_between_rigid_rings_every_roller_is_johnsons_squeezed_disc():
    """Johnson (1985), 5.6, at both contacts; the rings' approach at the angle θ from the load is y cos θ."""
    bearing = bearing_with(["inner_ring", "outer_ring"])
    r, modulus = bearing.roller_radius, STEEL.plane_strain_modulus
    relative = [
        1.0 / (1.0 / r + 1.0 / bearing.inner_raceway_radius),
        1.0 / (1.0 / r - 1.0 / bearing.outer_raceway_radius),
    ]

    def approach(force):
        q = force / LENGTH
        return sum(squeezed_disc_approach(q, r, half_width(q, R, modulus), modulus) for R in relative)

    def force(depth):
        return brentq(lambda q: approach(q) - depth, 1e-9, 1e5, xtol=1e-10) if depth > 0.0 else 0.0

    cosine = np.cos(2.0 * np.pi * np.arange(13) / 13 + HALF_PITCH + np.pi / 2.0)
    sink = brentq(lambda y: sum(force(y * c) * c for c in cosine) - LOAD, 1e-7, 1e-5, xtol=1e-16)
    found = equilibrium(model(bearing, 1e-3), standing(bearing, HALF_PITCH), Loads(LOAD))
    assert -found.hub[1] == pytest.approx(sink, rel=5e-4)
    np.testing.assert_allclose(found.inner_force, [force(sink * c) for c in cosine], rtol=0.0, atol=0.5)


# motion ---------------------------------------------------------------------------------------------------------


@lru_cache
def moving(names, **changes):
    """1 ms of the paper's scene at 2 mm."""
    how = {"numerics__mesh_size_mm": 2.0, "numerics__duration_ms": 1.0} | changes
    return record(plan_of(**how, **settings(names)))


@every_run
def test_the_energy_balances(names):
    for start in ("equilibrium", "rest"):
        found = moving(names, numerics__start=start, numerics__load_ramp_ms=0.2)
        # measured 3e-8 from equilibrium, 1e-6 loaded in 0.2 ms
        assert np.abs(found.imbalance).max() < (1e-6 if start == "equilibrium" else 1e-5) * found.largest_stored


@every_run
def test_it_rolls_without_slip(names):
    found = moving(names, operation__gravity_m_s2=0.0)
    ideal = found.plan.start.kinematics
    turned = found["roller_theta"][-1] - found["roller_theta"][0]
    assert turned.mean() / found["time"][-1] == pytest.approx(ideal.cage, rel=5e-4)
    np.testing.assert_allclose(found["roller_spin"], ideal.roller, rtol=1e-3)


@every_run
def test_it_moves_as_with_bodies_a_thousand_times_as_stiff(names):
    """What the stiff ones keep of their compliance is a thousandth; so are the differences."""
    interval, samples = 5e-6, []
    for material in (RIGID, replace(STEEL, youngs_modulus=1e3 * STEEL.youngs_modulus)):
        whole = model(bearing_with(names, material), 2e-3)
        stride = int(np.ceil(interval / (0.9 * critical_time_step(whole, 800.0))))
        samples.append(run(arrays(whole, operation(), interval / stride, 0.1), 31, stride))
    rigid, stiff = samples
    np.testing.assert_allclose(rigid[:, HUB_Y], stiff[:, HUB_Y], rtol=1.5e-3)
    for name in ("inner_force", "outer_force"):
        np.testing.assert_allclose(block(rigid, name), block(stiff, name), rtol=0.0, atol=1.0)
    for name in ("roller_x", "roller_y"):
        np.testing.assert_allclose(block(rigid, name), block(stiff, name), rtol=0.0, atol=1e-8)


def by_steps(names, slides=False, **changes):
    plan = plan_of(numerics__mesh_size_mm=2.0, **settings(names), **changes)
    plan = without_spin(plan) if slides else plan
    return record(every_step(plan, 300)), plan


def directions(found):
    """Unit vectors of the inner and the outer contacts, from the rings' centres, (n_times, n_rollers, 2)."""
    centres = np.stack([found["roller_x"], found["roller_y"]], axis=-1)
    from_hub = centres - np.stack([found["inner_x"], found["inner_y"]], axis=-1)[:, None]
    return [v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (from_hub, centres)]


def across(vectors):
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize("slides", [False, True], ids=["rolling", "sliding"])
def test_rigid_rollers_obey_newton_and_euler_at_every_step(slides):
    """m a and I dΩ/dt from the stored forces and tractions alone: no force is lost, none acts beside the contacts."""
    found, plan = by_steps(("rollers",), slides, contact__friction_coefficient=0.3)
    dt, body = plan.time_step, plan.model.roller
    assert body.total_mass == pytest.approx(paper().roller_mass, rel=1e-12)
    assert body.polar_inertia == pytest.approx(0.5 * paper().roller_mass * 0.005**2, rel=1e-9)
    inner, outer = directions(found)
    Q_i, Q_o = found["inner_force"][..., None], found["outer_force"][..., None]
    T_i, T_o = found["inner_traction"][..., None], found["outer_traction"][..., None]
    force = Q_i * inner - Q_o * outer + T_i * across(inner) + T_o * across(outer)
    force[..., 1] -= body.total_mass * plan.operation.gravity
    centres = np.stack([found["roller_x"], found["roller_y"]], axis=-1)
    acceleration = (centres[2:] - 2.0 * centres[1:-1] + centres[:-2]) / dt**2
    error = np.abs(body.total_mass * acceleration - force[1:-1]).max(axis=-1)
    closed = np.stack([found["inner_force"], found["outer_force"]]) > 0.0
    changes = ((closed[:, 2:] != closed[:, 1:-1]) | (closed[:, :-2] != closed[:, 1:-1])).any(axis=0)
    # but for the slope of the deformed raceways, 3e-5 of 630 N; under 190 N of sudden traction 2e-3, measured
    assert error[~changes].max() < (2.0 if slides else 0.05)
    # a contact that opens or closes within a step gives what its energy has changed by, here 4.6 N beside its force
    assert changes.any() == slides and (not slides or error[changes].max() < 10.0)
    turning = body.polar_inertia * np.diff(found["roller_spin"], axis=0) / dt
    np.testing.assert_allclose(turning, 0.005 * (T_o - T_i)[:-1, :, 0], rtol=0.0, atol=1e-9)
    assert np.abs(T_i).max() > (180.0 if slides else 0.1)


@pytest.mark.slow  # a time loop of its own to compile
def test_a_rigid_inner_ring_is_the_hub():
    """(m_in + m_R) a = −Σ (Q n + T t) + load and weight, with nothing left over."""
    found, plan = by_steps(("inner_ring", "outer_ring"))
    normal, _ = directions(found)
    force = -np.sum(
        found["inner_force"][..., None] * normal + found["inner_traction"][..., None] * across(normal), axis=1
    )
    force[:, 1] -= plan.operation.radial_load + plan.operation.inner_mass * plan.operation.gravity
    mass = plan.operation.inner_mass
    error = mass * np.stack([found["inner_ax"], found["inner_ay"]], axis=-1) - force
    assert np.abs(error).max() < 0.1, "but for the slope of the deformed rollers"


@pytest.mark.slow  # a time loop of its own to compile
def test_rigid_rollers_are_spun_up_by_friction():
    """Rollers that do not turn at first, under preload: each loses ½ I Ω² until it rolls, as solid cylinders do.

    Little friction, so that the rings' tangential deformation, which springs back in the end, holds little energy.
    """
    plan = without_spin(
        plan_of(
            numerics__mesh_size_mm=2.0, numerics__duration_ms=0.6, numerics__output_interval_us=1.0,
            bearing__outer_raceway_diameter_mm=55.99, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
            contact__friction_coefficient=0.02, **settings(["rollers"]),
        )
    )  # fmt: skip
    found, ideal = record(plan), kinematics(plan.model.bearing, plan.operation.speed).roller
    inertia = 0.5 * plan.model.bearing.roller_mass * plan.model.bearing.roller_radius**2
    # measured 1.5e-3 below; elastic rollers 2.9e-3
    assert found["work_dissipated"][-1] == pytest.approx(13 * 0.5 * inertia * ideal**2, rel=3e-3)
    np.testing.assert_allclose(found["roller_spin"][-1], ideal, rtol=1e-3)


def test_only_what_moves_is_counted():
    whole = plan_of(numerics__mesh_size_mm=2.0)
    rollers, rings = (plan_of(numerics__mesh_size_mm=2.0, **settings(names)) for names in (ALLOWED[0], ALLOWED[3]))
    of_rollers = 13 * whole.model.roller.n_nodes
    assert rollers.mesh_nodes == whole.mesh_nodes - of_rollers
    assert rollers.degrees_of_freedom == whole.degrees_of_freedom - 2 * of_rollers + 3 * 13
    assert rings.mesh_nodes == of_rollers and rings.degrees_of_freedom == 2 * of_rollers + 2
    state = rollers.arrays()
    assert state.bodies.disc.u.size == state.bodies.disc.blocks.size == 0
    assert rings.arrays().bodies.inner.u.shape[0] == 1


def free_ring(body):
    """Stiffness, mass, (n, n), and the rows of a held ring's free degrees of freedom among all."""
    size, free = body.n_rows * 2 * body.n_sectors, np.zeros((body.n_rows, 2, body.n_sectors), dtype=bool)
    free[body.free_rows] = True
    unit = np.eye(size)[free.ravel()]
    stiffness = np.array([body.force(u.reshape(free.shape)).ravel()[free.ravel()] for u in unit])
    mass = np.broadcast_to(body.row_mass[:, None, None], free.shape)[free]
    return stiffness, mass, free.ravel()


@pytest.mark.parametrize("density", [7850.0, 100.0])
def test_the_step_limit_holds_for_a_rigid_roller_between_elastic_rings(density):
    """Against the dense eigenvalue of both rings, the roller's radial motion and contacts a hundred times too hard."""
    whole = model(bearing_with(["rollers"], replace(RIGID, density=density)), 2e-3)
    laws = {name: getattr(whole, name) for name in ("inner_law", "outer_law")}
    hard = replace(whole, **{name: replace(law, A=1e-2 * law.A) for name, law in laws.items()})
    springs = [getattr(hard, name).stiffness(min(6500.0, getattr(hard, name).Q_line)) for name in laws]
    rings = [(ring, *free_ring(ring)) for ring in (hard.inner_ring, hard.outer_ring)]
    stiffness = block_diag(*(ring[1] for ring in rings), np.zeros((1, 1)))
    mass = np.concatenate([ring[2] for ring in rings] + [[hard.roller.total_mass]])
    first = 0
    for (ring, matrix, _, free), spring in zip(rings, springs, strict=True):
        closing = np.zeros(mass.size)
        closing[first : first + len(matrix)] = ring_patch_force(ring, 0.3).ravel()[free]
        closing[-1] = -1.0
        stiffness += spring * np.outer(closing, closing)
        first += len(matrix)
    scale = 1.0 / np.sqrt(mass)
    fastest = eigh(scale[:, None] * stiffness * scale, eigvals_only=True)[-1]
    found = critical_time_step(hard, 650.0, sticks=False)
    assert found <= 2.0 / np.sqrt(fastest)
    assert found > 0.3 * 2.0 / np.sqrt(fastest), "and is no wild guess"
    assert found < 0.8 * critical_time_step(whole, 650.0, sticks=False)


@pytest.mark.slow  # with and without friction: two time loops for each choice
@every_run
def test_random_bearings_stay_stable(names):
    """Of random scenes on coarse meshes none fails or loses 1 % of its energy."""
    tried = 0
    for number in (0, 3, 4, 8, 11):
        tables = random_scene(5, number, 0.3, budget=1e5) | {"bodies": dict.fromkeys(names, "rigid")}
        try:
            plan = make_plan(parse_scene(tables, "random"))
        except ValueError:  # the materials don't bear the scene
            continue
        found = record(plan)
        exchanged = found.largest_stored + np.abs(found["work_external"]).max()
        assert np.abs(found.imbalance).max() < 1e-2 * exchanged, tables["name"]
        tried += 1
    assert tried >= 3


@pytest.mark.slow  # compiles a loop
def test_a_run_with_rigid_bodies_goes_on_bit_for_bit(tmp_path):
    import h5py

    how = ["--mesh-size", "2", "--set", 'bodies.rollers="rigid"', "--quiet"]
    whole, part = (str(tmp_path / f"{name}.nc") for name in ("whole", "part"))
    assert run_main([*how, "--duration", "1", "--output", whole]) == 0
    assert run_main([*how, "--duration", "0.4", "--output", part]) == 0
    assert run_main([*how, "--duration", "1", "--output", part, "--resume"]) == 0
    with h5py.File(whole) as one, h5py.File(part) as other:
        assert one.attrs["mesh_nodes"] == 488
        for name in ("inner_y", "roller_x", "inner_traction", "energy_kinetic"):
            assert np.array_equal(one[name][:], other[name][:])

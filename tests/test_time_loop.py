"""The time loop of a whole bearing: balances, order in dt, reproducibility; rigid bodies; parts; the calibrated law."""

import importlib
from collections import namedtuple
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from numba.core.event import install_recorder
from numpy.testing import assert_allclose
from scipy.linalg import block_diag, eigh
from scipy.optimize import brentq

from fem.commands.run_fem import run_main
from fem.contacts import points, subgrid
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.elastic.bodies import disc_body
from fem.elastic.continuum import hertz_approach, stick_approach
from fem.elastic.reciprocal_mass import LUMPED, THIRD
from fem.kernels import columns
from fem.kernels.jit import KernelCache, PartCache, every, kernel, part
from fem.kernels.law import ripple_at
from fem.kernels.part_compiler import WHOLE, fields_used, shifted
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_statics
from lagrange import Material, contact_laws
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import kinematics
from lagrange.scene.scene import parse_scene, parse_scene_text
from meshes import Disc
from tests.reference import kit
from tests.reference.continua import half_width, squeezed_disc_approach
from tests.reference.kit import HALF_PITCH, LENGTH, LOAD, STEEL, arrays, block, model, operation, paper, within
from tests.stability.machine import random_scene
from tests.verification.contact_statics import POSITIONS, law_on_rigid, squeezed
from tests.verification.runs import every_step, largest_stored, plan_of, without_spin

SAMPLES, INTERVAL = 61, 5e-6
SPIN = 4500.0 * np.pi / 30.0


@lru_cache
def whole_run(friction=0.1, courant=0.9, from_rest=False, ramp=0.0, mesh_size=2e-3, **changes):
    whole, how = model(paper(), mesh_size), operation(**changes)
    mass = LUMPED if from_rest else THIRD  # as `fem.solver.solver.may_strike`
    stride = int(np.ceil(INTERVAL / (courant * critical_time_step(whole, 800.0, mass=mass))))
    state = arrays(whole, how, INTERVAL / stride, friction, from_rest=from_rest, ramp=ramp, mass=mass)
    samples = kit.run(state, SAMPLES, stride)
    samples.flags.writeable = False
    return samples, state, how


def imbalance(samples):
    energy = samples[:, [columns.KINETIC, columns.ELASTIC, columns.CONTACT, columns.DISSIPATED]].sum(axis=1)
    left = energy - samples[:, [columns.WORK_LOAD, columns.WORK_GRAVITY, columns.WORK_DRIVE]].sum(axis=1)
    return left - left[0]


# Of the hub's error, rms, N: the elastic ring's own motion is all that may be left: 1e-3 N in rolling without friction
# and gravity. The start knows no traction; the ramp shakes the rings, of 350 N of inertia; measured 6 ... 11
SCENES = {
    "paper": ({}, 0.6), "frictionless": ({"friction": 0.0}, 3e-3),
    "frictionless and weightless": ({"friction": 0.0, "gravity": 0.0}, 3e-3),
    "from rest": ({"from_rest": True, "ramp": 1e-4}, 20.0), "backwards": ({"speed": -SPIN}, 0.6),
    "strong gravity": ({"gravity": 981.0}, 3.0), "standing still": ({"speed": 0.0}, 0.04),
}  # fmt: skip


@pytest.mark.parametrize(("scene", "limit"), SCENES.values(), ids=SCENES.keys())
def test_energy_balances_and_the_hub_follows_its_contact_forces(scene, limit):
    """(m_in + m_R) a = −Σ Q n + T t + load and weight, but for the elastic ring's own motion."""
    samples, _, how = whole_run(**scene, courant=0.45)
    stored = (samples[:, columns.ELASTIC] + samples[:, columns.CONTACT]).max()
    # at half the usual step; measured 4e-12 where nothing turns, else 2e-7 or 4e-7 (loaded in 0.1 ms)
    assert np.abs(imbalance(samples)).max() < (1e-6 if how.speed else 1e-11) * stored
    samples, *_ = whole_run(**scene)
    hub = samples[:, [columns.HUB_X, columns.HUB_Y]]
    x, y = block(samples, "roller_x") - hub[:, :1], block(samples, "roller_y") - hub[:, 1:]
    Q, T, nx, ny = block(samples, "inner_force"), block(samples, "inner_traction"), *(np.array([x, y]) / np.hypot(x, y))
    time, ramp = samples[:, columns.TIME], scene.get("ramp", 0.0)
    share = np.where(time >= ramp, 1.0, 0.5 * (1.0 - np.cos(np.pi * time / ramp))) if ramp else 1.0
    weight = share * how.radial_load + how.inner_mass * how.gravity
    force = np.array([np.sum(-Q * nx + T * ny, axis=1), np.sum(-Q * ny - T * nx, axis=1) - weight])
    error = how.inner_mass * samples[:, [columns.HUB_AX, columns.HUB_AY]].T - force
    assert np.sqrt(np.mean(error**2, axis=1)).max() < limit


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_the_energy_imbalance_is_of_second_order(friction):
    how = {"friction": friction, "speed": 4.0 * SPIN, "from_rest": True}
    coarse, fine = (np.abs(imbalance(whole_run(courant=c, **how)[0])).max() for c in (0.9, 0.3))
    assert fine < 0.13 * coarse  # (1/3)² = 0.11


def test_rollers_follow_the_cage_and_their_contact_forces_and_tractions_dissipate_within_coulombs_limit():
    samples, state, how = whole_run()
    x, y = block(samples, "roller_x"), block(samples, "roller_y")
    turned = np.unwrap(np.arctan2(y, x), axis=0)
    cage = (turned[-1] - turned[0]) / (samples[-1, columns.TIME] - samples[0, columns.TIME])
    ideal, spin = 0.5 * how.speed * 0.018 / 0.023, block(samples, "roller_spin")
    assert_allclose(cage, ideal, rtol=5e-4)
    assert_allclose(spin, -0.5 * how.speed * 0.018 / 0.005, rtol=1e-3)
    rate = np.diff(block(samples, "roller_turn"), axis=0) / INTERVAL
    assert_allclose(rate.mean(axis=0), spin.mean(axis=0), rtol=1e-4)
    # radially: Q_i − Q_o + m ρ cage² − m g sin = m ρ''; waves and the contact resonance ring about it
    Q_i, Q_o = block(samples, "inner_force"), block(samples, "outer_force")
    held = Q_o - Q_i - state.bodies.rollers.total_mass * (ideal**2 * np.hypot(x, y) - how.gravity * np.sin(turned))
    assert np.abs(held.mean(axis=0)).max() < 0.02 and held.std() < 0.2  # measured 2e-3; 0.04 rms
    for side, force in (("inner", Q_i), ("outer", Q_o)):
        traction = block(samples, f"{side}_traction")
        assert np.all(np.abs(traction) <= 0.1 * force * (1.0 + 1e-14)) and traction.any()
    lost = samples[:, columns.DISSIPATED]
    # a step's share takes the mean of the slips before and after it, which may have another sign than the traction's
    assert np.diff(lost).min() > -1e-6 * samples[:, columns.ELASTIC].max()
    assert lost[-1] > 5e-10 and np.polyfit(np.arange(len(lost)), lost, 1)[0] > 0.0


def test_a_run_starts_quietly_from_equilibrium_and_without_friction_has_no_traction():
    samples, *_ = whole_run(friction=0.0)
    hub = samples[:, columns.HUB_Y]
    # 3.614 µm static, centrifugal force and 0.8 N of weight; rolling 0.3 ms passes 5° of a 28° period
    assert -1e6 * hub.mean() == pytest.approx(3.62, rel=0.01) and np.ptp(hub) < 5e-9  # measured 1.3e-9
    assert (block(samples, "inner_force") > 0.0).sum(axis=1).max() <= 7
    assert not block(samples, "inner_traction").any() and not block(samples, "outer_traction").any()
    assert not samples[:, columns.DISSIPATED].any()


def test_the_same_run_has_the_same_bits_and_the_stride_or_half_the_step_change_no_trajectory():
    first, *_ = whole_run()
    whole_run.cache_clear()
    again, *_ = whole_run()
    assert first is not again and first.tobytes() == again.tobytes()
    hub, fine = first[:, columns.HUB_Y], whole_run(courant=0.45)[0][:, columns.HUB_Y]
    within(hub, fine, 1e-5 * np.abs(fine).max())
    whole, how, dt = model(paper(), 2e-3), operation(), 2e-7
    fine, coarse = (kit.run(arrays(whole, how, dt, 0.1), *count) for count in ((60, 1), (6, 10)))
    difference = fine[::10] - coarse
    # in the drive's work, gravity's moment is summed at samples
    assert np.abs(difference[:, columns.WORK_DRIVE]).max() < 1e-9 * np.abs(coarse[:, columns.ELASTIC]).max()
    difference[:, columns.WORK_DRIVE] = 0.0
    assert np.all(difference == 0.0)


def test_a_mirrored_scene_has_the_mirrored_answer():
    # 18 nodes on a roller: gmsh's triangles are mirror images too (with 15 none is opposite another), so only round-off
    # differs, a few ulp of 23 mm and what 300 µs make of it
    (forward, *_), (backward, *_) = (whole_run(mesh_size=1.75e-3, speed=speed) for speed in (SPIN, -SPIN))
    for names, scale in (("HUB_X HUB_Y", 4e-6), ("HUB_VX HUB_VY", 2e-4)):
        at = [getattr(columns, name) for name in names.split()]
        within(backward[:, at], [-1.0, 1.0] * forward[:, at], 1e-6 * scale)
    mirrored = np.roll(block(forward, "inner_force")[:, ::-1], 1, axis=1)
    within(block(backward, "inner_force"), mirrored, 1e-5)


# Bodies declared rigid: statics against exact series, their motion, balances, what is refused

RIGID, STIFF = replace(STEEL, rigid=True), replace(STEEL, youngs_modulus=1e9 * STEEL.youngs_modulus)
BODIES = {"rollers": "roller", "inner_ring": "inner_ring", "outer_ring": "outer_ring"}  # scene: Bearing
ALLOWED = (("rollers",), ("inner_ring",), ("outer_ring",), ("inner_ring", "outer_ring"))
every_choice = pytest.mark.parametrize("names", ALLOWED, ids=" and ".join)


def bearing_with(names, material=RIGID, **changes):
    return paper(**{BODIES[name]: material for name in names}, **changes)


def settings(names):
    return {f"bodies__{name}": "rigid" for name in names}


@pytest.mark.parametrize(("tables", "words"), [
    ('[bodies]\nrollers = "rigid"\nouter_ring = "rigid"', ["bodies", 'outer_ring = "rigid"', "--model lagrange"]),
    (
        '[bodies]\nrollers = "rigid"\ninner_ring = "rigid"\nouter_ring = "rigid"',
        ['inner_ring = "rigid" and outer_ring = "rigid"', "no compliance", "--model lagrange"],
    ),
    ('[bodies]\nrollers = "stiff"', ["bodies.rollers = 'stiff'", "'elastic' or 'rigid'"]),
    ('[bodies]\nroller = "rigid"', ["bodies.roller", "did you mean rollers?"]),
    ('[bodies]\nouter_ring = "rigid"\n[contact]\nmodel = "resolved"', ["bodies.outer_ring", '"subgrid"']),
    ('[bodies]\nrollers = "rigid"\n[contact]\nmodel = "penalty"', ["bodies.rollers", '"penalty"']),
])  # fmt: skip
def test_what_can_not_be_rigid_is_named(tables, words):
    kit.assert_refused(tables, *words)
    assert "\n" not in kit.refusal(tables)


def test_all_elastic_is_the_default_and_contacts_wider_than_the_mesh_need_elastic_bodies(capsys):
    how = ["--mesh-size", "0.05", "--set", 'bodies.rollers="rigid"', "--set", "operation.radial_load_N=20000"]
    assert run_main([*how, "--dry-run"]) == 2
    said = capsys.readouterr().err
    assert "bodies.rollers" in said and "numerics.mesh_size_mm = 0.05" in said and "at least 0." in said
    assert parse_scene_text("", "s.toml") == parse_scene_text('[bodies]\nrollers = "elastic"', "s.toml")
    bearing = parse_scene_text('[bodies]\ninner_ring = "rigid"', "s.toml").ideal_bearing()
    assert bearing.inner_ring == RIGID and not bearing.outer_ring.rigid and not bearing.roller.rigid


def test_laws_that_know_the_material_know_a_rigid_body():
    """Half the compliance is a contact modulus twice as large; the one with a rigid roller is the ring's alone."""
    assert contact_pairs(bearing_with(["rollers"]))[2] == contact_pairs(paper())[2], "but two rigid rollers are elastic"
    elastic, rigid = (contact_laws("houpert", bearing) for bearing in (paper(), bearing_with(["rollers"])))
    assert rigid.inner.stiffness == pytest.approx(2.0 * elastic.inner.stiffness, rel=1e-12)
    for names in ALLOWED:
        found, wanted = (contact_laws("johnson", bearing_with(names, material)) for material in (RIGID, STIFF))
        for side in ("inner", "outer"):
            assert getattr(found, side).approach(500.0) == pytest.approx(getattr(wanted, side).approach(500.0), 1e-7)


@every_choice
def test_the_equilibrium_is_that_of_exact_series_with_an_infinite_modulus(names):
    exact, bearing = exact_statics(bearing_with(names, STIFF), LOAD, HALF_PITCH), bearing_with(names)
    found = equilibrium(model(bearing, 1e-3), standing(bearing, HALF_PITCH), Loads(LOAD))
    within(found.hub, exact.hub, 1e-3 * np.linalg.norm(exact.hub))
    within(found.inner_force, exact.inner_force, 1e-3 * exact.inner_force.max())
    assert_allclose(exact_statics(bearing, LOAD, HALF_PITCH).hub, exact.hub, rtol=1e-7, atol=1e-15)


def test_between_rigid_rings_every_roller_is_johnsons_squeezed_disc():
    """Johnson (1985), 5.6, at both contacts; the rings' approach at the angle θ from the load is y cos θ."""
    bearing, modulus = bearing_with(["inner_ring", "outer_ring"]), STEEL.plane_strain_modulus
    r = bearing.roller_radius
    relative = [1.0 / (1.0 / r + s) for s in (1.0 / bearing.inner_raceway_radius, -1.0 / bearing.outer_raceway_radius)]

    def approach(force):
        q = force / LENGTH
        return sum(squeezed_disc_approach(q, r, half_width(q, R, modulus), modulus) for R in relative)

    def force(depth):
        return brentq(lambda q: approach(q) - depth, 1e-9, 1e5, xtol=1e-10) if depth > 0.0 else 0.0

    cosine = np.cos(2.0 * np.pi * np.arange(13) / 13 + HALF_PITCH + np.pi / 2.0)
    sink = brentq(lambda y: sum(force(y * c) * c for c in cosine) - LOAD, 1e-7, 1e-5, xtol=1e-16)
    found = equilibrium(model(bearing, 1e-3), standing(bearing, HALF_PITCH), Loads(LOAD))
    assert -found.hub[1] == pytest.approx(sink, rel=5e-4)
    within(found.inner_force, [force(sink * c) for c in cosine], 0.5)


@pytest.mark.slow  # each is a time loop of its own to compile; `test_a_rigid_inner_ring_is_the_hub` runs with changes
@every_choice
def test_rigid_bodies_balance_roll_and_move_as_bodies_a_thousand_times_as_stiff(names):
    ways = {"numerics__mesh_size_mm": 2.0, "numerics__duration_ms": 1.0, **settings(names)}
    for start, limit in (("equilibrium", 1e-6), ("rest", 1e-5)):  # measured 3e-8, and 1e-6 loaded in 0.2 ms
        found = kit.whole_run(plan_of(**ways, numerics__start=start, numerics__load_ramp_ms=0.2))
        assert np.abs(found.imbalance).max() < limit * largest_stored(found)
    plan = plan_of(**ways, operation__gravity_m_s2=0.0)
    found, ideal = kit.whole_run(plan), plan.start.kinematics
    turned = found["roller_theta"][-1] - found["roller_theta"][0]
    assert turned.mean() / found["time"][-1] == pytest.approx(ideal.cage, rel=5e-4)
    assert_allclose(found["roller_spin"], ideal.roller, rtol=1e-3)
    kit.assert_same_bits(*kit.rest_of_run(plan, 40, 61)[::-1])
    interval, samples = 5e-6, []
    for material in (RIGID, replace(STEEL, youngs_modulus=1e3 * STEEL.youngs_modulus)):
        whole = model(bearing_with(names, material), 2e-3)
        stride = int(np.ceil(interval / (0.9 * critical_time_step(whole, 800.0))))
        samples.append(kit.run(arrays(whole, operation(), interval / stride, 0.1), 31, stride))
    rigid, stiff = samples
    assert_allclose(rigid[:, columns.HUB_Y], stiff[:, columns.HUB_Y], rtol=1.5e-3)
    for name, error in (("inner_force", 1.0), ("outer_force", 1.0), ("roller_x", 1e-8), ("roller_y", 1e-8)):
        within(block(rigid, name), block(stiff, name), error)


def by_steps(names, slides=False, **changes):
    plan = plan_of(numerics__mesh_size_mm=2.0, **settings(names), **changes)
    plan = without_spin(plan) if slides else plan
    return kit.whole_run(every_step(plan, 300)), plan


def directions(found):
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
    dt, body, (inner, outer) = plan.time_step, plan.model.roller, directions(found)
    assert body.total_mass == pytest.approx(paper().roller_mass, rel=1e-12)
    assert body.polar_inertia == pytest.approx(0.5 * paper().roller_mass * 0.005**2, rel=1e-9)
    names = ("inner_force", "outer_force", "inner_traction", "outer_traction")
    Q_i, Q_o, T_i, T_o = (found[name][..., None] for name in names)
    force = Q_i * inner - Q_o * outer + T_i * across(inner) + T_o * across(outer)
    force[..., 1] -= body.total_mass * plan.operation.gravity
    centres = np.stack([found["roller_x"], found["roller_y"]], axis=-1)
    acceleration = np.diff(centres, 2, axis=0) / dt**2
    error = np.abs(body.total_mass * acceleration - force[1:-1]).max(axis=-1)
    closed = np.stack([found["inner_force"], found["outer_force"]]) > 0.0
    changes = ((closed[:, 2:] != closed[:, 1:-1]) | (closed[:, :-2] != closed[:, 1:-1])).any(axis=0)
    # but for the slope of the deformed raceways, 3e-5 of 630 N; under 190 N of sudden traction 2e-3, measured
    assert error[~changes].max() < (2.0 if slides else 0.05)
    # a contact that opens or closes within a step gives what its energy has changed by, here 4.6 N beside its force
    assert changes.any() == slides and (not slides or error[changes].max() < 10.0)
    turning = body.polar_inertia * np.diff(found["roller_spin"], axis=0) / dt
    within(turning, 0.005 * (T_o - T_i)[:-1, :, 0], 1e-9)
    assert np.abs(T_i).max() > (180.0 if slides else 0.1)


@pytest.mark.slow  # a time loop of its own to compile
def test_a_rigid_inner_ring_is_the_hub():
    """(m_in + m_R) a = −Σ (Q n + T t) + load and weight, with nothing left over."""
    found, plan = by_steps(("inner_ring", "outer_ring"))
    normal, operation = directions(found)[0], plan.operation
    push = found["inner_force"][..., None] * normal + found["inner_traction"][..., None] * across(normal)
    force = -push.sum(axis=1) - [0.0, operation.radial_load + operation.inner_mass * operation.gravity]
    error = operation.inner_mass * np.stack([found["inner_ax"], found["inner_ay"]], axis=-1) - force
    assert np.abs(error).max() < 0.1, "but for the slope of the deformed rollers"


@pytest.mark.slow  # a time loop of its own to compile
def test_rigid_rollers_are_spun_up_by_friction():
    """Rollers that do not turn at first, under preload: each loses ½ I Ω² until it rolls, as solid cylinders do.

    Little friction, so that the rings' tangential deformation, which springs back in the end, holds little energy.
    """
    plan = without_spin(plan_of(
        numerics__mesh_size_mm=2.0, numerics__duration_ms=0.6, numerics__output_interval_us=1.0,
        bearing__outer_raceway_diameter_mm=55.99, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
        contact__friction_coefficient=0.02, **settings(["rollers"]),
    ))  # fmt: skip
    found, bearing = kit.whole_run(plan), plan.model.bearing
    ideal, inertia = kinematics(bearing, plan.operation.speed).roller, 0.5 * bearing.roller_mass * 0.005**2
    # measured 1.5e-3 below; elastic rollers 2.9e-3
    assert found["work_dissipated"][-1] == pytest.approx(13 * 0.5 * inertia * ideal**2, rel=3e-3)
    assert_allclose(found["roller_spin"][-1], ideal, rtol=1e-3)


def test_only_what_moves_is_counted():
    whole = plan_of(numerics__mesh_size_mm=2.0)
    rollers, rings = (plan_of(numerics__mesh_size_mm=2.0, **settings(names)) for names in (ALLOWED[0], ALLOWED[3]))
    of_rollers = 13 * whole.model.roller.n_nodes
    assert rollers.mesh_nodes == whole.mesh_nodes - of_rollers
    assert rollers.degrees_of_freedom == whole.degrees_of_freedom - 2 * of_rollers + 3 * 13
    assert rings.mesh_nodes == of_rollers and rings.degrees_of_freedom == 2 * of_rollers + 2
    disc = rollers.arrays().bodies.disc
    assert disc.u.size == disc.blocks.size == 0 and rings.arrays().bodies.inner.u.shape[0] == 1


@pytest.mark.parametrize("density", [7850.0, 100.0])
def test_the_step_limit_holds_for_a_rigid_roller_between_elastic_rings(density):
    """Against the dense eigenvalue of both rings, the roller's radial motion and contacts a hundred times too hard."""
    whole = model(bearing_with(["rollers"], replace(RIGID, density=density)), 2e-3)
    laws = {name: getattr(whole, name) for name in ("inner_law", "outer_law")}
    hard = replace(whole, **{name: replace(law, A=1e-2 * law.A) for name, law in laws.items()})
    parts, masses, first = [], [], 0
    for body in (hard.inner_ring, hard.outer_ring):  # stiffness and mass of a held ring's free degrees of freedom
        free = body.free_places
        parts.append(body.matrix[free][:, free].toarray())
        masses.append(np.repeat(body.row_mass, 2 * body.n_sectors)[free])
    stiffness, mass = block_diag(*parts, np.zeros((1, 1))), np.concatenate([*masses, [hard.roller.total_mass]])
    for body, name in ((hard.inner_ring, "inner_law"), (hard.outer_ring, "outer_law")):
        push, law, closing = points.patch_force(body, 0.3).ravel()[body.free_places], getattr(hard, name), 0.0 * mass
        closing[first : first + len(push)], closing[-1] = push, -1.0
        stiffness += law.stiffness(min(6500.0, law.Q_line)) * np.outer(closing, closing)
        first += len(push)
    scale = 1.0 / np.sqrt(mass)
    exact = 2.0 / np.sqrt(eigh(scale[:, None] * stiffness * scale, eigvals_only=True)[-1])
    found = critical_time_step(hard, 650.0, sticks=False)
    assert 0.3 * exact < found <= exact, "and is no wild guess"
    assert found < 0.8 * critical_time_step(whole, 650.0, sticks=False)


@pytest.mark.slow  # with and without friction: two time loops for each choice
@every_choice
def test_random_bearings_stay_stable(names):
    tried = 0
    for number in (0, 3, 4, 8, 11):
        tables = random_scene(5, number, 0.3, budget=1e5) | {"bodies": dict.fromkeys(names, "rigid")}
        try:
            plan = make_plan(parse_scene(tables, "random"))
        except ValueError:  # the materials don't bear the scene
            continue
        found = kit.whole_run(plan)
        exchanged = largest_stored(found) + np.abs(found["work_external"]).max()
        assert np.abs(found.imbalance).max() < 1e-2 * exchanged, tables["name"]
        tried += 1
    assert tried >= 3


# Parts of kernels are compiled for the fields that they use, whatever else their arguments hold


Wheel, Brake = namedtuple("Wheel", "speed radius"), namedtuple("Brake", "force")
Car = namedtuple("Car", "wheel brake load")


@part
def slow(brake, speed):
    if isinstance(brake, Wheel):
        speed[0] -= 1e9
    elif isinstance(brake, Brake):
        speed[0] -= brake.force


@part
def radius_of(wheel):
    return wheel.radius


@part
def drive(car, more):
    wheel, brake = car.wheel, car.brake
    turning = wheel.speed
    turning[0] += more / radius_of(wheel)
    slow(brake, turning)
    return brake is None


@part
def keep_all(car):
    return car


drive_all = every(drive)


@part
def brake_all(cars, more):
    (car,), loads = cars, (cars[0].load, None)
    load = loads[0] if loads[0] is not None else loads[1]
    if car.brake is not None and more > 0.0:
        car.wheel.speed[0] -= car.brake.force
    if load is None:
        car.wheel.speed[0] += 1.0
    else:
        car.wheel.speed[0] += load[0]


@pytest.fixture
def not_kept(monkeypatch):
    monkeypatch.setattr("fem.kernels.jit.cache_folder", lambda: None)


@pytest.mark.parametrize(("function", "used"), [
    (radius_of, ({"radius": WHOLE},)),
    (drive, ({"wheel": {"speed": WHOLE, "radius": WHOLE}, "brake": {"force": WHOLE}}, WHOLE)),
    (keep_all, (WHOLE,)), (slow, ({"force": WHOLE}, WHOLE)), (drive_all, (WHOLE, WHOLE)),
])  # fmt: skip
def test_fields_that_a_part_uses_itself_or_by_parts_that_it_calls(function, used):
    assert fields_used(function) == used


def test_a_part_is_compiled_once_for_arguments_that_differ_in_what_it_does_not_use(not_kept, tmp_path):
    @kernel
    def advance(cars, more):
        drive_all(cars, more)

    with install_recorder("numba:compile") as compiled:
        for brake, load, speed in ((None, None, 4.0), (Brake(1.0), None, 3.0), (Brake(1.0), np.zeros(2), 3.0)):
            car = Car(Wheel(np.zeros(1), 0.5), brake, load)
            advance(((car,),), 2.0)
            assert car.wheel.speed[0] == speed
    begun = [event.data["dispatcher"].py_func.__name__ for _, event in compiled.buffer if event.is_start]
    assert (begun.count("advance"), begun.count("drive"), begun.count("radius_of")) == (3, 2, 1)
    written = [code for code in shifted if code.__name__ == "code"]  # for groups, and kept as of the part's module
    assert written and all(importlib.import_module(code.__module__) for code in written)
    files = [cache(radius_of, tmp_path)._file(("any", "key")) for cache in (PartCache, KernelCache)]
    assert files[0] != files[1], "what is kept of a part and of a kernel of one function"


def test_one_function_serves_scenes_with_a_part_and_without_it(not_kept):
    advance = kernel(lambda cars, more: brake_all(cars, more))
    for brake, load, speed in ((None, None, 1.0), (Brake(2.0), np.full(1, 5.0), 3.0)):
        car = Car(Wheel(np.zeros(1), 0.5), brake, load)
        advance((car,), 1.0)
        assert car.wheel.speed[0] == speed


def test_a_question_that_the_reader_of_fields_does_not_see_is_no_silent_no(not_kept, monkeypatch):
    monkeypatch.setattr("fem.kernels.jit.fields_used", lambda function: ({"wheel": WHOLE},))

    is_free = part(lambda car: car.brake is None)
    with pytest.raises(TypeError, match="fields_used does not see"):
        kernel(lambda car: is_free(car))(Car(Wheel(np.zeros(1), 0.5), None, None))


# The contact law below the grid: finite elements plus law give the exact approach wherever the contact sits

RADIUS = 0.005
CALIBRATED_AT = 5e-5  # half-width b, m, as `fem.contacts.subgrid` does for this roller
SPRINGY = Material(youngs_modulus=100e9, poisson_ratio=0.2, density=3000.0)
HELD = {"inside": ((0.0125, 0.018), (56, 3), True), "outside": ((0.028, 0.0325), (88, 2), False)}


def surface_of(body, b=CALIBRATED_AT):
    return subgrid.surface_compliance(body, LENGTH, b)


@pytest.mark.parametrize(("layers", "material"), [(3, STEEL), (5, STEEL), (10, STEEL), (5, SPRINGY)])
def test_a_squeezed_disc_has_johnsons_approach_at_every_position_and_where_it_sticks(layers, material):
    """Poisson's ratio matters only through the plane-strain modulus."""
    body, modulus = kit.disc(RADIUS, layers, material), material.plane_strain_modulus
    surface = surface_of(body)
    law = law_on_rigid(surface, RADIUS, material)
    grid = np.array([squeezed(body, surface, p * layers / 5.0) for p in POSITIONS])
    for force in (100.0, 200.0, 400.0, 628.0, 800.0, 1000.0):
        q = force / LENGTH
        b, found = half_width(q, RADIUS, modulus), grid * force + law.approach(force)
        assert law.pair.half_width(force) == pytest.approx(b, rel=1e-12)
        # Johnson's formula is the limit b << R; its next term is O(b/R) of a bracket of about 14, 0.05 % at b/R = 0.013
        assert_allclose(found, squeezed_disc_approach(q, RADIUS, b, modulus), rtol=1e-3)
        # measured spread 1e-4: between its knots the ripple's spline is off by h⁴ of a short wave
        assert np.ptp(found) < 5e-4 * found.mean()
    # without the ripple the same contact is softer at some places than at others
    assert np.ptp(surface.ripple) > 5e-3 * surface.whole
    loads = [points.patch_traction(body, 2.0 * np.pi * p * layers / 5.0 / body.n_surface) for p in POSITIONS]
    for force in (30.0, 628.0):
        exact = stick_approach(body.section, law.pair.half_width(force)) / LENGTH
        found = [float(load @ body.relaxed(load)) + missing_shear(surface, law.pair, force) for load in loads]
        # the mesh is softer at some places than at others, which the level, a mean, does not follow
        assert_allclose(found, exact, rtol=0.012)
        assert np.mean(found) == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("which", HELD)
@pytest.mark.parametrize("scale", [1, 2])
def test_a_held_ring_has_the_exact_approach_at_every_position_and_where_it_sticks(which, scale):
    radii, (sectors, layers), inside = HELD[which]
    body, force = kit.ring(*radii, sectors * scale, layers * scale, inside), 500.0
    surface = surface_of(body)
    law = law_on_rigid(surface, body.raceway_radius)
    b = law.pair.half_width(force)
    for position in (0.0, 0.19, 0.5, 7.7, body.n_sectors - 0.4):
        angle = 2.0 * np.pi * position / body.n_sectors
        load, along = points.patch_force(body, angle), points.patch_traction(body, angle)
        grid = np.vdot(load, body.held(load)) + ripple_at(np.mod(position, 1.0), surface.ripple)[0]
        # b differs fourfold from the calibration's; O(b/R)
        exact = hertz_approach(body.section, b) / LENGTH * force
        assert grid * force + law.approach(force) == pytest.approx(exact, rel=1e-3)
        if scale == 1:
            below, exact = missing_shear(surface, law.pair, force), stick_approach(body.section, b) / LENGTH
            assert np.vdot(along, body.held(along)) + below == pytest.approx(exact, rel=2e-3)


def missing_shear(surface, pair, force):
    """What the mesh lacks of a contact's tangential compliance, m/N, against a rigid plane."""
    level = subgrid.level(surface, subgrid.rigid_surface(1.0), pair, "missing_shear")
    return surface.unit * (level - 0.5 * np.log(force))


def test_the_law_scales_with_modulus_size_and_the_half_width_it_is_calibrated_at():
    """Twice the size at the same length: the same compliance, half-widths larger by the square root of two."""
    body = kit.disc(RADIUS, 3)
    surface = surface_of(body)
    law = law_on_rigid(surface, RADIUS)
    for factor in (0.5, 2.0):
        soft = replace(STEEL, youngs_modulus=factor * 210e9)
        other = surface_of(replace(body, material=soft, stiffness=factor * body.stiffness))
        assert other.missing == pytest.approx(surface.missing / factor, rel=1e-9)
        assert other.unit == pytest.approx(surface.unit / factor, rel=1e-14)
        width = law_on_rigid(other, RADIUS, soft).pair.half_width_factor
        assert width * factor == pytest.approx(law.pair.half_width_factor, rel=1e-12)
    bodies = kit.disc(RADIUS, 4), disc_body(Disc(radius=2.0 * RADIUS, layers=4), STEEL, LENGTH)
    small, large = (law_on_rigid(surface_of(b, 0.01 * b.shape.radius), b.shape.radius) for b in bodies)
    assert large.A == small.A
    # ln b enters with b²/Q = 2 R A: at the same Q/R the approach over Q is the same
    assert large.B == pytest.approx(small.B + 0.5 * np.log(2.0), abs=1e-9)
    wide, narrow = (law_on_rigid(surface_of(kit.disc(RADIUS, 5), CALIBRATED_AT / share), RADIUS) for share in (1, 10))
    # the O(b/R) that is left out, 0.3 b/R of a bracket of about 2
    assert wide.B == pytest.approx(narrow.B, abs=0.01)
    assert wide.A == narrow.A == pytest.approx(2.0 / (np.pi * STEEL.plane_strain_modulus * LENGTH), rel=1e-14)

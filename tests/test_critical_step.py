"""The critical time step: dense eigenvalues, and leapfrog itself just below and just above it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh

from fem.contacts import points
from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.critical_step import LANCZOS_TOLERANCE, STEP_TOLERANCE, critical_time_step
from fem.elastic.bodies import RingBody, assemble
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.kernels.elements.rings import HALO
from fem.solver.simulate import make_plan
from lagrange.scene.scene import parse_scene
from meshes import Mesh
from tests.reference import compiled
from tests.reference.kit import LENGTH, STEEL, disc, model, paper, ring, whole_run

LOAD = 650.0  # N, on the most loaded roller
LAWS = ("inner_law", "outer_law", "roller_law")
LONG = pytest.mark.parametrize("mass", [SECOND, THIRD], ids=["second degree", "third degree"])
NOTHING = ((0.0, 0.0),) * 3


@cache
def coarse():
    return model(paper(), 2e-3)


def harder(names, times):
    laws = {name: getattr(coarse(), name) for name in names}
    return replace(coarse(), **{name: replace(law, A=law.A / times) for name, law in laws.items()})


def springs_of(load, sticks):
    force, laws = LOAD_MARGIN * load, [getattr(coarse(), name) for name in LAWS]
    both = zip(laws, coarse().shear_levels, strict=True)
    return tuple((law.stiffness(force), sticks / (law.A * (level - 0.5 * np.log(force)))) for law, level in both)


def dense(body, springs=((0.0, 0.0),)):
    """M⁻¹K and Σ 2k M⁻¹ f fᵀ, symmetric, of a disc or a held ring, Cartesian, from scikit-fem's own matrix."""
    stiffness = assemble(Mesh(points=body.points, cells=body.cells), body.material, LENGTH).stiffness
    if isinstance(body, RingBody):
        free = np.flatnonzero(np.repeat(np.arange(body.n_rows) != body.held_row, 2 * body.n_sectors))
        mass = np.repeat(body.row_mass, 2 * body.n_sectors)[free]
    else:
        free, mass = np.arange(2 * body.n_nodes), np.repeat(body.mass, 2)
    scale, pressed = 1.0 / np.sqrt(mass), np.zeros((free.size, free.size))
    for j, both in enumerate(springs):
        for spring, force in zip(both, (points.patch_force, points.patch_traction), strict=True):
            patch = force(body, 2.0 * np.pi * j / len(springs))
            patch = scale * (body.cartesian(patch) if isinstance(body, RingBody) else patch).ravel()[free]
            pressed += 2.0 * spring * np.outer(patch, patch)
    return scale[:, None] * stiffness.toarray()[np.ix_(free, free)] * scale, pressed


def squares_of_steps(waves, pressed, mass):
    """Largest dt² ω² of q(dt² A)(A + S), q(z) = 1 − γ z (1 − β z), as a function of dt; and the largest ω² of A.

    In A's own axes, by the symmetric product with the roots of q(dt² A), which is not negative where q is made for.
    """
    squares, modes = eigh(waves)
    whole = np.diag(squares) + modes.T @ pressed @ modes

    def largest(dt):
        z = dt**2 * squares
        q = 1.0 - mass.share * z * (1.0 - mass.calming * z)
        assert q.min() > -1e-9
        root = np.sqrt(np.maximum(q, 0.0))
        return dt**2 * eigh(root[:, None] * whole * root, eigvals_only=True)[-1]

    return largest, squares[-1]


def longest(waves, pressed, mass):
    """By bisection: dt² ω² of q(dt² A)(A + S) reaches 4, or dt² A what q is made for."""
    largest, fastest = squares_of_steps(waves, pressed, mass)
    low, high = 0.0, np.sqrt(mass.reach / fastest)
    if largest(high) <= 4.0:
        return high
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if largest(middle) <= 4.0 else (low, middle)
    return 0.5 * (low + high)


def dense_step(springs, mass):
    bodies = (coarse().roller, springs), (coarse().inner_ring, springs[:1]), (coarse().outer_ring, springs[1:2])
    return min(longest(*dense(*each), mass) for each in bodies)


@LONG
def test_it_is_the_dense_eigenvalue_without_contacts_and_with_springs(mass):
    found, wanted = critical_time_step(harder(LAWS, 1e-12), LOAD, mass=mass), dense_step(NOTHING, mass)
    # never above; Lanczos' tolerance below, and the same added for safety
    assert wanted * (1.0 - 1.1 * LANCZOS_TOLERANCE) <= found <= wanted * (1.0 + 1e-9)
    for sticks in (False, True):
        found = critical_time_step(coarse(), LOAD, mass=mass, sticks=sticks)
        wanted = dense_step(springs_of(LOAD, sticks), mass)
        assert wanted * (1.0 - 2.0 * STEP_TOLERANCE) <= found <= wanted * (1.0 + 3e-4), sticks  # of twelve halves
    assert found == critical_time_step(coarse(), LOAD, mass=mass), "the same number every time"


@LONG
@pytest.mark.parametrize(
    "load", [LOAD, *(pytest.param(n * LOAD, marks=pytest.mark.slow) for n in (2.0, 4.0, 7.0, 20.0))]
)
def test_all_shorter_steps_are_stable(load, mass):
    """dt² ω² of slowed waves on springs rises with the step, and then may fall."""
    springs, found = springs_of(load, True), critical_time_step(coarse(), load, mass=mass)
    assert found > 0.0 or load > LOAD, "not worth it"
    for each in ((coarse().roller, springs), (coarse().outer_ring, springs[1:2])):
        largest, _ = squares_of_steps(*dense(*each), mass)
        for dt in found * np.array([0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0]):
            assert largest(dt) <= 4.0 + 1e-6


@pytest.mark.slow
@LONG
def test_where_a_reciprocal_mass_gains_too_little_there_is_none(mass):
    stiff = 1e3 * LOAD
    assert critical_time_step(coarse(), stiff, mass=mass) == 0.0
    lumped = critical_time_step(coarse(), stiff)
    assert dense_step(springs_of(stiff, True), mass) < mass.worth * lumped * (1.0 + 3e-4)
    assert critical_time_step(coarse(), LOAD, mass=mass) > mass.worth * critical_time_step(coarse(), LOAD)


def test_contacts_and_finer_meshes_lower_it():
    free = critical_time_step(harder(LAWS, 1e-12), LOAD)
    steps = np.array([critical_time_step(coarse(), load) for load in (1.0, 100.0, 1e4, 1e6, 1e9)])
    assert np.all(np.diff(steps) <= 1e-12 * free)  # stiffer with the load
    assert np.all(steps <= free * (1.0 + LANCZOS_TOLERANCE))
    assert steps[-2] == pytest.approx(steps[-1], rel=1e-6)  # the straight line has a stiffness of its own
    assert critical_time_step(harder(["roller_law"], 100.0), LOAD) < 0.7 * free
    step, finer = (critical_time_step(whole, LOAD) for whole in (coarse(), model(paper(), 1e-3)))
    # half the spacing, half the step; node counts are rounded: 18 and 30 on the roller, 2 and 4 layers in the ring
    assert step / finer == pytest.approx(2.0, rel=0.25)
    # by the square of the time in which a wave crosses an element
    assert finer < 1e-3 / STEEL.dilatational_wave_speed


def leapfrog(body, dt, n_steps, mass):
    """Largest displacement, relative to the first, after free steps."""
    rng = np.random.default_rng(1)
    if isinstance(body, RingBody):
        u, _, step = compiled.ring_steps(body, dt, mass)
        u[body.free_rows, :, HALO:-HALO] = rng.standard_normal((len(body.free_rows), 2, body.n_sectors))
        compiled.wrap_all(u)
    else:
        nodes, step = compiled.disc_steps(body, dt, mass)
        u = nodes.u
        u.reshape(body.n_nodes, 2, -1)[:, :, 0] = rng.standard_normal((body.n_nodes, 2))
    start = np.abs(u).max()
    for _ in range(n_steps):
        step()
    return np.abs(u).max() / start


@LONG
@pytest.mark.parametrize(("make", "size"), [
    (disc, (0.005, 3)), (ring, (0.0125, 0.018, 56, 3, True)), (ring, (0.028, 0.0325, 88, 2, False)),
], ids=["roller", "inner ring", "outer ring"])  # fmt: skip
def test_leapfrog_is_stable_just_below_it_and_blows_up_just_above(make, size, mass):
    body, times = make(*size), 1.03
    limit = longest(*dense(body), mass)
    # dt² ω² of a step is z q(z) with z = (ω dt)², at most 3.5: at any number of steps a mode is amplified at most
    # 1/sqrt(1 − 3.5/4) = 2.8 times, the second degree's fastest 1/sqrt(1 − 0.98²) = 5 times
    assert leapfrog(body, limit, 4000, mass) < 20.0
    # of the fastest it is below 0 beyond the second degree's limit, and above 4 beyond the third's
    growth = np.log([leapfrog(body, times * limit, n_steps, mass) for n_steps in (200, 250)])
    assert growth[0] > 40.0
    z = times**2 * mass.reach
    beyond = z * (1.0 - mass.share * z * (1.0 - mass.calming * z))
    a_step = np.arccosh(0.5 * np.sqrt(beyond)) if beyond > 4.0 else np.arcsinh(0.5 * np.sqrt(-beyond))
    assert np.diff(growth)[0] / 50 == pytest.approx(2.0 * a_step, rel=0.02)


# Long steps with the reciprocal mass: what turns fast gains no energy by them

FAST = {
    "material": {"youngs_modulus_GPa": 70.0}, "operation": {"speed_rpm": 40_000.0, "radial_load_N": 500.0},
    "numerics": {"mesh_size_mm": 2.2, "duration_ms": 1.0, "time_step_safety": 0.65},
}  # fmt: skip


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_ring_and_rollers_that_turn_fast_keep_their_energy(friction):
    """A stencil applied to velocities along chords, in frames at the step's start, took 3e-4 of it: as Ω⁴ dt³."""
    plan = make_plan(parse_scene(FAST | {"contact": {"friction_coefficient": friction}}, "scene"))
    assert plan.mass is not LUMPED
    found = whole_run(plan)
    assert np.abs(found.imbalance).max() < 3e-5 * found.exchanged[-1]


@pytest.mark.parametrize(("tables", "long_steps"), [
    ({}, True), ({"operation": {"speed_rpm": 0.0}}, True),
    ({"operation": {"speed_rpm": 500.0}}, False),  # gravity is half of what turning presses rollers outwards by
    ({"operation": {"speed_rpm": 500.0, "gravity_m_s2": 0.0}}, True),
    ({"numerics": {"start": "rest", "load_ramp_ms": 5.0}}, False),
    ({"spall": [{"body": "outer_ring", "angle_deg": 0.0, "width_mm": 1.0}]}, False),
    ({"numerics": {"mesh_size_mm": 0.4}}, False),  # contacts leave too little
])  # fmt: skip
def test_steps_are_long_where_nothing_strikes_and_it_pays(tables, long_steps):
    numerics = {"mesh_size_mm": 2.2, "duration_ms": 0.1} | tables.get("numerics", {})
    assert (make_plan(parse_scene(tables | {"numerics": numerics}, "scene")).mass is not LUMPED) is long_steps


@LONG
@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_contacts_that_roll_feed_no_waves(friction, mass, monkeypatch):
    """Springs that follow momenta instead of places gained 2e-4 in 10 ms with the third degree, and grew on."""
    monkeypatch.setattr("fem.solver.elements.plan.LONG", (mass,))
    numerics = {"mesh_size_mm": 2.0, "duration_ms": 15.0}
    plan = make_plan(parse_scene({"contact": {"friction_coefficient": friction}, "numerics": numerics}, "scene"))
    assert plan.mass is mass
    found = whole_run(plan)
    assert np.abs(found.imbalance).max() < 5e-7 * found.exchanged[-1]  # measured 1e-7

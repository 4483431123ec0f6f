"""An outer ring in a bore, with play or pressed in, or held at points: exact series, its motion, and runs in time."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import FINELY, critical_time_step
from fem.contacts.points import patch_force
from fem.elastic.outer_support import FEWEST, LooseRing, bored_ring, supported_ring
from fem.elastic.reciprocal_mass import SECOND
from fem.kernels.columns import CONTACT, ELASTIC, KINETIC
from fem.kernels.elements import bodies, rings
from fem.kernels.elements.bodies import ARC, AX, PLACE_X, PLACE_Y
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.samples import _changes, _copy, _ring_power
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Housing as HousingBody
from fem.solver.elements.arrays import bore_body, equilibrium_start, ring_nodes, rolling_motion
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan
from lagrange.errors import UsageError
from lagrange.mounting import Bore, Housing, Mounting, Points
from lagrange.scene.scene import parse_scene, parse_scene_text
from tests.reference import modes
from tests.reference.kit import (
    LENGTH,
    STEEL,
    assert_refused,
    assert_same_bits,
    drive,
    rest_of_run,
    ring,
    whole_run,
    within,
)  # fmt: skip
from tests.reference.quadratic import ring_in_bore

INNER, OUTER = 0.028, 0.0325  # m, the paper's outer ring
WALL = 2.0 * STEEL.lame_mu / OUTER  # Pa/m, of a thick wall
BEARING_LOADS = [(-0.5 * np.pi + 2.0 * np.pi / 13.0 * j, f) for j, f in ((-2, 250), (-1, 500), (0, 650), (1, 500))]
COLUMN = 20
NUMERICS = {"mesh_size_mm": 2.0, "duration_ms": 2.0}


def outer_ring(layers: int):
    """With elements about as long as they are high."""
    return ring(INNER, OUTER, 48 * layers, layers, False)


def in_bore(layers: int, clearance: float, stiffness: float | None = None):
    """The paper's outer ring in a bore wider than it by so much, m."""
    return bored_ring(outer_ring(layers), Bore(clearance=clearance, stiffness=stiffness), LENGTH)


def nothing_on(body):
    return np.zeros((body.n_rows, 2, body.n_sectors))


@pytest.mark.parametrize("touching", [0, 10, 60, -1])
def test_influences_of_a_ring_on_some_springs_are_those_that_its_factors_give(touching):
    """From all springs' by Woodbury's formula, beside the sparse solution with the springs that act."""
    body = in_bore(2, 20e-6)
    far = np.abs(np.angle(np.exp(1j * (body.angles + 1.7))))
    body, nodes = replace(body, touching=far <= np.sort(far)[touching]), np.array([3, 4, 5, 40, 41, 90])
    expected = LooseRing._influence(body, nodes)
    within(body.surface_influence(nodes), expected, 1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("wall", [1.0, 20.0])
def test_a_press_fit_shrinks_the_raceway_as_lame_has_it(wall):
    """Within 0.3 %, in a thick wall of steel (two thick rings) and in a stiffer bore; found within 1e-4."""
    body = in_bore(4, -40e-6, wall * WALL)
    found = body.rested(nothing_on(body))
    pressure, raceway, outside = modes.pressed_ring(INNER, OUTER, STEEL, wall * WALL, 20e-6)
    assert_allclose(found[0, 0], raceway, rtol=3e-4)
    assert_allclose(found[-1, 0], outside, rtol=3e-4)
    force = pressure * 2.0 * np.pi * OUTER * LENGTH
    assert body.pressure_forces(found).sum() == pytest.approx(force, rel=3e-4)
    assert body.pressed_energy == pytest.approx(0.5 * force * 20e-6, rel=3e-4)  # mean force times the way


def test_a_bore_without_a_stiffness_is_a_thick_wall_of_the_rings_steel():
    """Lamé's thick tube, its outside 1e4 times as far: widens by p R (1 + ν)/E."""
    assert Bore(clearance=0.0).stiffness_around(OUTER, STEEL.lame_mu) == pytest.approx(WALL, rel=1e-12)
    far, nu = 1e4 * OUTER, STEEL.poisson_ratio
    share = (far**2 + OUTER**2) / (far**2 - OUTER**2) + nu / (1.0 - nu)
    assert STEEL.youngs_modulus / (1.0 - nu**2) / (OUTER * share) == pytest.approx(WALL, rel=1e-6)


@pytest.mark.parametrize(("play", "wall"), [(20e-6, 1.0), pytest.param(60e-6, 10.0, marks=pytest.mark.slow)])
def test_the_load_zone_of_a_ring_with_play_is_that_of_an_exact_ring(play, wall):
    """Pressures and displacement against quadratic elements on a one-sided bed; the mesh is 0.8 % too stiff."""
    body = in_bore(8, 2.0 * play, wall * WALL)
    found = body.rested(sum(force * patch_force(body, angle) for angle, force in BEARING_LOADS))
    spline = zip(2.0 * np.pi / body.n_sectors * np.arange(-1, 2), [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], strict=True)
    forces = [(INNER, angle + off, share * f / LENGTH) for off, share in spline for angle, f in BEARING_LOADS]
    pressure, moved = (of[::2] for of in ring_in_bore((INNER, OUTER), STEEL, wall * WALL, play, forces, 256))
    every = body.n_sectors // 128
    mine = body.pressure_forces(found)[::every] / (2.0 * np.pi * OUTER * LENGTH / body.n_sectors)
    assert np.abs(mine - pressure).max() < 0.035 * pressure.max()
    assert mine.max() == pytest.approx(pressure.max(), rel=0.015)
    assert abs(np.mean(mine > 0.0) - np.mean(pressure > 0.0)) < 3.0 / 128.0
    assert_allclose(found[-1, 0, ::every], moved, atol=5e-3 * np.ptp(moved))


def test_a_ring_pinched_in_a_wide_bore_is_the_exact_one():
    """What widens it across two opposite forces, within 0.3 % of quadratic elements; of a thin ring 215.8 µm/kN."""
    body = in_bore(16, 1.0)
    n, body = body.n_sectors, replace(body, touching=np.zeros(body.n_sectors, dtype=bool))
    force = nothing_on(body)
    for at in (0, n // 2):
        force[-1, 0, (at + np.arange(-1, 2)) % n] -= [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0]
    pinch = [(OUTER, angle, -1.0 / LENGTH) for angle in (0.0, np.pi)]
    _, exact = ring_in_bore((INNER, OUTER), STEEL, WALL, 1.0, pinch, 128)
    assert exact[32] + exact[96] == pytest.approx(215.8e-9, rel=0.03)
    moved = body.rested(force)[-1, 0]
    assert moved[n // 4] + moved[3 * n // 4] == pytest.approx(exact[32] + exact[96], rel=3e-3)


def test_what_rests_in_a_bore_is_in_balance():
    """Bore, loads and weight: no node is left with a force but the loose springs', none turns the ring."""
    body = in_bore(3, 30e-6)
    load = 400.0 * patch_force(body, -1.3) + 300.0 * patch_force(body, -2.2)
    found, left = body.rested(load), load.copy()
    left[-1, 0] -= body.pressure_forces(found)
    assert np.abs(left - body.force(found)).max() < 1e-4 and abs(found[-1, 1].mean()) < 1e-15
    assert_allclose(body.cartesian(left).sum(axis=0), 0.0, atol=1e-3)
    # and in a bearing with play
    scene = parse_scene({"support": {"kind": "bore", "fit_clearance_um": 40.0}, "numerics": {"mesh_size_mm": 2.0}}, "")
    model, operation = model_of(scene), scene.ideal_operation()
    body, static = model.outer_ring, equilibrium_start(model, operation).equilibrium
    bore = -body.pressure_forces(static.outer_ring) @ np.column_stack([np.cos(body.angles), np.sin(body.angles)])
    on_ring = static.outer_force @ rolling_motion(model, operation, 0.0).radial
    assert_allclose(bore, -on_ring + [0.0, operation.gravity * body.total_mass], atol=1e-4)
    assert -static.hub[1] > 20e-6


def test_the_critical_step_counts_the_whole_bore():
    """A stiff one, counted FINELY times: against the ring on such springs all around, harmonic by harmonic."""
    tables = {"support": {"kind": "bore", "bore_stiffness_N_per_mm3": 1e5}, "numerics": {"mesh_size_mm": 2.0}}
    model = model_of(parse_scene(tables, ""))
    body, harmonics = model.outer_ring, np.arange(model.outer_ring.n_sectors // 2 + 1)
    stiffness, scale = body.harmonic_stiffness(harmonics), 1.0 / np.sqrt(np.repeat(body.row_mass, 2))
    waves = scale[:, None] * stiffness * scale
    stiffness[:, 2 * body.held_row, 2 * body.held_row] += FINELY * body.stiffness
    sprung, found = scale[:, None] * stiffness * scale, critical_time_step(model, 650.0)
    slowed = (np.eye(len(scale)) - SECOND.share * found**2 * waves) @ sprung
    assert found**2 * np.abs(np.linalg.eigvals(slowed)).max() < 4.0
    assert SECOND.share * found**2 * np.linalg.eigvalsh(waves).max() < 1.0
    turn = np.sqrt(body.stiffness / body.row_mass[-1]) * found
    assert turn < 2.0 / np.sqrt(FINELY) * (1.0 + 1e-12), "rad in a step"
    light = critical_time_step(model, 650.0, Mounting(housing=Housing(mass=1e-3, stiffness=1e6, damping=0.0)))
    both = 0.5 * body.n_sectors * body.stiffness * (1.0 / 1e-3 + 1.0 / body.total_mass)  # both as wholes
    assert light < min(found, 2.0 / np.sqrt(both))


@njit(**OPTIONS)
def live(ring, bore, housing, drive, room, line, rows, stride):
    """A ring, its bore and the bore's housing alone: a row each `stride` steps, as samples have them."""
    for i in range(rows.shape[0] * stride):
        row = rows[i // stride]
        if i % stride == 0:
            _copy(ring.w, room)
        rings.kick(ring.table, ring.u, ring.w, None, ring.first_row, ring.last_row)
        bodies.kick_body(bore, drive)
        bodies.kick_body(housing, drive)
        rings.wrap_all(ring.w)
        bodies.slow_body(bore, drive)
        if i % stride == 0:
            slowed = drive.slowing / drive.dt * _ring_power(ring, ring.calmed, room, line)
            row[KINETIC] = 0.5 * (_changes(ring, room)[1] + slowed)
            bodies.write_body(bore, drive, row)
            bodies.write_body(housing, drive, row)
            row[ELASTIC] = -0.5 * _ring_power(ring, ring.u, ring.u, line) / drive.dt
        rings.find_velocities(ring.slowed, ring.calmed, ring.w, ring.v, drive.dt, ring.raceway)
        motion, places = (ring.u, ring.w, ring.v), (ring.first_row, ring.last_row, ring.raceway)
        rings.drift_slowed(ring.slowed, motion, ring.calmed, drive.dt, places)
        bodies.drift_body(housing, drive)


class Alive:
    """A ring's nodes, its bore and the bore's housing, at rest."""

    def __init__(self, body, dt: float, mass: float):
        ring = ring_nodes(body, dt, SECOND.at(dt))
        zeros = {name: np.zeros(2) for name in ("place", "velocity", "before", "impulse", "drag")}
        self.housing = HousingBody(
            **zeros, slowed=np.zeros((2, 2)), dissipated=np.zeros(1), ring=None, line=np.zeros((2, 8)), sensor=None,
            mass=mass, late_mass=mass, stiffness=1e6, damping=0.0, column=COLUMN + 7,
        )  # fmt: skip
        self.ring, self.dt = ring._replace(calmed=ring.w), dt
        self.bore = bore_body(body, self.ring, nothing_on(body), self.housing, COLUMN)

    def rows(self, count: int, stride: int) -> np.ndarray:
        rows, w = np.zeros((count, COLUMN + 12)), self.ring.w
        live(self.ring, self.bore, self.housing, drive(self.dt), np.zeros_like(w), np.zeros_like(w[0]), rows, stride)
        return rows


def fill(target: np.ndarray, values: np.ndarray) -> None:
    """Put values (n_rows, 2, n_sectors) between halos, and repeat their ends in these."""
    target[:, :, HALO:-HALO] = values
    target[:, :, HALO - 1], target[:, :, -HALO:] = values[:, :, -1], values[:, :, :HALO]


@pytest.mark.parametrize(
    ("layers", "dt", "error"), [(4, 1e-7, 0.017), pytest.param(16, 2.5e-8, 2e-3, marks=pytest.mark.slow)]
)
def test_a_free_ring_in_a_wide_bore_vibrates_at_its_exact_frequency(layers, dt, error):
    """Two waves around, 3251.5 Hz, within 0.2 % on sixteen layers; by the time between crossings of 0."""
    body = in_bore(layers, 1.0)
    alive, exact = Alive(body, dt, 1.0), modes.ring_frequency(2, INNER, OUTER, 2e4, 2.1e4, STEEL) / (2.0 * np.pi)
    spectrum = np.zeros((body.n_rows, 2, body.n_sectors // 2 + 1), dtype=complex)
    stiffness, mass = body.harmonic_stiffness(np.array([2]))[0], np.repeat(body.row_mass, 2)
    squares, shapes = np.linalg.eigh(stiffness / np.sqrt(np.outer(mass, mass)))
    spectrum[:, :, 2] = (shapes[:, 0] / np.sqrt(mass)).reshape(-1, 2)
    shape = np.fft.irfft(spectrum, n=body.n_sectors, axis=2)
    fill(alive.ring.u, 1e-6 * shape / np.abs(shape).max())
    at, seen = HALO + int(np.argmax(np.abs(shape[-1, 0]))), []
    for _ in range(120):
        alive.rows(1, round(2.5e-6 / dt))
        seen.append(alive.ring.u[-1, 0, at])
    seen = np.array(seen)
    crossed = np.flatnonzero(seen[:-1] * seen[1:] < 0.0)
    first, second = (crossed + seen[crossed] / (seen[crossed] - seen[crossed + 1])) * 2.5e-6
    found = 0.5 / (second - first)
    assert found == pytest.approx(np.sqrt(squares[0]) / (2.0 * np.pi), rel=1e-3)
    assert found == pytest.approx(exact, rel=error)


def test_a_ring_thrown_into_its_bore_keeps_energy_and_momentum():
    """It hits the bore of a light housing on springs a dozen times, and rings; only those springs change the sum."""
    body, dt = in_bore(3, 20e-6), 1e-7
    alive, thrown = Alive(body, dt, 0.2), np.broadcast_to([0.1, -0.2], (len(body.points), 2))
    ring, bore, housing = alive.ring, alive.bore, alive.housing
    fill(ring.w, body.polar(thrown))
    bore.velocity[:] = thrown[0]
    rows = alive.rows(2000, 5)
    energy = rows[:, [KINETIC, ELASTIC, CONTACT, COLUMN + 11]].sum(axis=1)
    assert energy[0] == pytest.approx(0.5 * body.total_mass * 0.05, rel=1e-6)
    assert rows[:, ELASTIC].max() > 0.05 * energy[0] and rows[:, CONTACT].max() > 0.05 * energy[0]
    assert np.count_nonzero(np.diff(rows[:, COLUMN + ARC] > 0.0)) > 10
    assert_allclose(energy, energy[0], rtol=1e-5)  # at an instant; nothing adds up:
    assert np.mean(energy[-500:]) == pytest.approx(energy[0], rel=5e-7)

    def fixed(field):
        return body.cartesian(field[:, :, HALO:-HALO]).reshape(body.n_rows, -1, 2)

    momentum = np.tensordot(body.row_mass, fixed(ring.w), (0, 0)).sum(axis=0) + housing.mass * housing.velocity
    springs = housing.stiffness * 5 * dt * rows[:, COLUMN + 7 : COLUMN + 9].sum(axis=0)
    assert_allclose(momentum, body.total_mass * thrown[0] - springs, rtol=2e-3)
    # nothing turns it, and the columns tell the mean of its outside
    assert abs(ring.u[-1, 1, HALO:-HALO].mean()) < 1e-15
    place, rows = fixed(ring.u)[-1].mean(axis=0), alive.rows(3, 1)
    places = rows[:, COLUMN + PLACE_X : COLUMN + PLACE_Y + 1]
    assert_allclose(places[0], place, rtol=1e-12)
    assert_allclose(rows[1, COLUMN + AX], np.diff(places[:, 0], 2)[0] / dt**2, rtol=1e-6)


BORE, POINTS = {"kind": "bore"}, {"kind": "points"}


@pytest.mark.parametrize(("support", "more", "words"), [
    (POINTS | {"fit_clearance_um": 1.0}, {}, ['only with kind = "housing" or "bore"', '"points"']),
    (BORE | {"mass_kg": 1.0}, {}, ['mass_kg = 1: only with kind = "housing", not "bore"']),
    ({"kind": "housing", "bore_stiffness_N_per_mm3": 9.0}, {}, ["only with fit_clearance_um"]),
    (BORE | {"bore_stiffness_N_per_mm3": 0.0}, {}, ["support.bore_stiffness_N_per_mm3"]),
    (BORE | {"fit_clearance_um": 140.0}, {}, ["outside diameter, 65 mm; between -130 and 130"]),
    (BORE, {"model": "lagrange"}, ["fit_clearance_um = 0", '"lagrange"']),
    (BORE, {"model": "reduced"}, ["fit_clearance_um = 0", '"reduced"']),
    (BORE, {"bodies": {"outer_ring": "rigid"}}, ["elastic outer ring"]),
    (BORE, {"contact": {"model": "resolved"}}, ["fit_clearance_um", '"resolved"']),
    (BORE, {"cage": {"guidance": "outer_ring"}}, ['cage.guidance = "outer_ring"']),
    (BORE, {"sensor": {}}, ["[sensor]"]),
    (POINTS | {"angles_deg": []}, {}, ["support.angles_deg"]),
    (POINTS | {"angles_deg": [400.0]}, {}, ["angles_deg.0 = 400", "360"]),
    (POINTS | {"width_mm": 0.0}, {}, ["support.width_mm"]),
    (POINTS | {"mass_kg": 1.0}, {}, ['mass_kg = 1: only with kind = "housing", not "points"']),
    ({"kind": "housing", "width_mm": 1.0}, {}, ['width_mm = 1: only with kind = "points"']),
    (POINTS, {"model": "lagrange"}, ['support.kind = "points": only with model = "fem"', '"lagrange"']),
    (POINTS, {"bodies": {"outer_ring": "rigid"}}, ["rigid outer ring"]),
    (POINTS, {"contact": {"model": "resolved"}}, ['"resolved"']),
    (POINTS, {"sensor": {}}, ["[sensor]"]),
])  # fmt: skip
def test_what_makes_no_sense_is_refused_by_name(support, more, words):
    assert_refused({"support": support, **more}, *words)


@pytest.mark.parametrize(("kind", "key"), [("bore", "fit_clearance_um"), ("points", "kind")])
def test_a_mesh_for_spread_contacts_refuses_a_fit_and_points(kind, key):
    with pytest.raises(UsageError, match=rf"support\.{key}.*mesh_size_mm = 0\.05"):
        model_of(parse_scene({"support": {"kind": kind}, "numerics": {"mesh_size_mm": 0.05}}, ""))


def test_supports_survive_as_text_and_a_fit_is_left_out_where_there_is_none():
    fit = {"kind": "housing", "fit_clearance_um": -12.0, "bore_stiffness_N_per_mm3": 2000.0}
    scenes = [parse_scene({"support": table}, "") for table in (BORE, POINTS | {"angles_deg": [0.0, 90.0]}, fit)]
    for scene in scenes:
        assert parse_scene_text(scene.to_toml(), "") == scene
    assert scenes[1].mounting().points.angles == pytest.approx((-0.5 * np.pi, 0.0))
    assert scenes[2].mounting().bore == Bore(clearance=pytest.approx(-12e-6), stiffness=2e12)
    glued = parse_scene({"support": {"kind": "housing"}}, "")
    assert glued.mounting().bore is None and "fit" not in glued.to_toml()


def plan_in(**support):
    """The paper's bearing on 2 mm for 2 ms."""
    return make_plan(parse_scene({"support": support, "numerics": NUMERICS}, ""))


@pytest.mark.slow
@pytest.mark.parametrize("fit", [20.0, -20.0])
def test_a_run_keeps_its_energy_and_the_ring_is_in_balance(fit):
    """Contacts, bore and weight make the ring's mean acceleration; 5e-8 of the stored energy is unaccounted for."""
    plan = plan_in(kind="bore", fit_clearance_um=fit)
    values, body = whole_run(plan), plan.model.outer_ring
    angle = np.arctan2(values["roller_y"], values["roller_x"])  # contacts are about the bore
    stored = values["energy_elastic"] + values["energy_contact"] - body.pressed_energy
    assert np.abs(values.imbalance).max() < 2e-7 * stored.max()
    pushes = values["outer_force"] * np.sin(angle) - values["outer_traction"] * np.cos(angle)
    on_ring = np.sum(pushes, axis=1) + values["bore_force_y"] - plan.operation.gravity * body.total_mass
    # it stays in the bore, but for the raceway's tilt, which is the bore's
    assert abs(np.mean(on_ring)) < 1e-4 * 2000.0
    if fit > 0.0:  # its outside moves nearly as its centre of mass does
        assert np.corrcoef(on_ring, values["outer_ring_ay"])[0, 1] > 0.5
        assert np.ptp(values["bore_arc"]) > 0.0 and values["bore_arc"].max() < 2.5


@pytest.mark.slow
def test_a_housing_with_play_carries_what_its_bore_carries():
    """Springs, dashpots, weight and the bore's force accelerate the housing."""
    plan = plan_in(kind="housing", fit_clearance_um=20.0, mass_kg=1.0)
    values, housing = whole_run(plan), plan.operation.mounting.housing
    place, inertia = values["housing_y"], housing.mass * values["housing_ay"]
    push = -values["bore_force_y"] - housing.mass * plan.operation.gravity - housing.stiffness * place
    left = push - housing.damping * np.gradient(place, values["time"]) - inertia
    assert np.std(left) < 0.02 * np.std(inertia) and np.std(inertia) > 0.1
    assert np.abs(values.imbalance).max() < 2e-7 * (values["energy_elastic"] + values["energy_contact"]).max()


@pytest.mark.slow
def test_a_run_in_a_bore_goes_on_bit_for_bit():
    assert_same_bits(*rest_of_run(plan_in(kind="bore", fit_clearance_um=20.0), 20, 20)[::-1])


# Outer rings held at points


def test_supports_carry_what_is_put_on_the_ring():
    body = supported_ring(outer_ring(3), Points(angles=(0.5 * np.pi, 3.6, 5.8), width=6e-3))
    force = np.random.default_rng(3).standard_normal((body.n_rows, 2, body.n_sectors, 2))
    moved = body.held(force)
    assert np.abs(moved[-1][:, body.held_sectors]).max() == 0.0 < np.abs(moved).max()
    for k in range(2):
        left, carried = body.force(moved[..., k]) - force[..., k], nothing_on(body)
        carried[-1][:, body.held_sectors] = left[-1][:, body.held_sectors]
        assert np.abs(left - carried).max() < 1e-9 * np.abs(force).max() * 100
        assert_allclose(body.cartesian(force[..., k] + carried).sum(axis=0), 0.0, atol=1e-8)


def test_nodes_within_the_width_are_held_and_two_of_each_point_at_least():
    body, spacing = outer_ring(3), 2.0 * np.pi * OUTER / outer_ring(3).n_sectors
    narrow, wide, whole = (supported_ring(body, Points(angles=angles, width=width)) for angles, width in (
        ((1.0, 4.0), 1e-6), ((0.0,), 10.0 * spacing), ((0.0,), 2.0 * np.pi * OUTER)))  # fmt: skip
    assert len(narrow.held_sectors) == 2 * FEWEST
    assert narrow.n_free_nodes == body.n_rows * body.n_sectors - 4
    assert len(wide.held_sectors) == 11 and 0 in wide.held_sectors
    load = np.ones((4, 2, body.n_sectors))
    assert_allclose(whole.held(load), body.held(load), atol=1e-20)
    body, nodes = supported_ring(body, Points(angles=(0.0, np.pi), width=2e-3)), np.array([5, 40])
    found, force = body.surface_influence(nodes), nothing_on(body)
    force[body.raceway_row, 1, 40] = 1.0
    assert_allclose(found[:, 3], body.held(force)[body.raceway_row][:, nodes].T.ravel(), rtol=1e-12)
    assert_allclose(found, found.T, rtol=1e-9)


def told_of(capsys, *settings: str) -> str:
    """What --dry-run says of the paper's bearing held at three points."""
    points = ["support.kind=points", "numerics.duration_ms=0", *settings]
    assert run_main(["--dry-run", *(part for each in points for part in ("--set", each))]) == 0
    told = capsys.readouterr()
    return " ".join((told.out + told.err).replace("│", " ").split())


def test_widths_that_the_mesh_holds_are_shown_and_warned_of_where_they_are_not_those_asked_for(capsys):
    """176 edges around 65 mm are 1.160 mm long: five nodes hold 5.80 mm. 56 are 3.646 mm long: two hold 7.29 mm."""
    width, fine = f"{5 * np.pi * 65.0 / 176:.3g}", told_of(capsys, "numerics.mesh_size_mm=1")
    assert f"over {width}, {width}, {width} mm" in fine and "width_mm = 6:" not in fine
    coarse = told_of(capsys, "numerics.mesh_size_mm=3")
    assert "support.width_mm = 6: the mesh holds the outer ring over 7.29, 7.29, 7.29 mm" in coarse
    narrow = told_of(capsys, "numerics.mesh_size_mm=2", "support.width_mm=0.1")
    assert "the mesh holds the outer ring over 4.64, 4.64, 4.64 mm, from nodes 2.32 mm apart" in narrow


@pytest.mark.slow
def test_a_run_held_at_three_points_keeps_its_energy_and_its_points():
    """Balanced as well as one held all around; the ring is oval, its held nodes stand."""
    plan = plan_in(kind="points", angles_deg=[180.0, 60.0, 300.0])
    state = plan.first_state()
    found = whole_run(plan, state)
    assert np.abs(found.relative_error()).max() < 1e-6
    outside = state.frame().outer_ring[-1]
    assert np.abs(outside[:, plan.model.outer_ring.held_sectors]).max() < 1e-18 < 1e-6 < np.abs(outside).max()
    assert found["inner_y"].mean() == pytest.approx(-7.5e-6, abs=0.5e-6)  # docs/paper.md, statics

"""Stress below the contacts of a coarse mesh: against theory, an exact field and a resolved model."""

import itertools
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import toeplitz
from scipy.optimize import nnls

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.points import points
from fem.contacts.resolved import SpreadModel
from fem.elastic.bodies import max_shear, stress_operator, turned, von_mises
from fem.kernels import columns
from fem.kernels.elements.loop import advance
from fem.kernels.elements.points import spread_forces
from fem.kernels.jit import kernel
from fem.pictures import stress_below
from fem.pictures.bodies import drawn_bearing, shear_peak
from fem.pictures.recover import FIRST_ROLLER, INNER_RING, OUTER_RING
from fem.pictures.stress_below import hertz_stress, spline_displacement
from fem.solver.limits import check_meshes
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import parse_scene
from meshes import Annulus, Disc, GradedAnnulus, GradedDisc, mesh_of, quality
from meshes.graded import graded_disc
from meshes.shapes import make
from tests.reference import continua, kit
from tests.reference.compiled import press_contacts
from tests.reference.continua import contact_pressures, flamant, mcewen
from tests.reference.kit import ON_A_ROLLER, STEEL, arrays, copies, operation, resolved_model, whole_run
from tests.reference.quadratic import resolved_disc


@pytest.fixture(scope="module")
def bearing(tmp_path_factory):
    """The static bearing at a mesh size, mm, with settings, as an instant of its run and as drawn."""
    folder = tmp_path_factory.mktemp("standing")

    @cache
    def make(mesh_size, *settings):
        path = folder / f"{len(list(folder.iterdir()))}.nc"
        still = "operation.speed_rpm=0", "operation.gravity_m_s2=0", "contact.friction_coefficient=0"
        options = [word for each in (*still, *settings) for word in ("--set", each)]
        options += ["--mesh-size", str(mesh_size), "--duration", "0", "--output", str(path), "--quiet"]
        assert run_main(options) == 0
        instant = kit.read_instant(path)
        return instant, drawn_bearing(instant)

    return make


def peaks(drawn, least):
    """Of all contacts above a line load, N/m: body, shear over p₀, depth over b."""
    found = []
    for item in (item for item in drawn.loads if np.hypot(*item.load.force) > least):
        peak = shear_peak(drawn, item)
        found.append((item.body, peak.shear / peak.pressure, peak.depth / peak.half_width, peak.half_width))
    return np.array(found)


@pytest.mark.slow
def test_pressure_points_and_a_mesh_that_resolves_its_contacts_show_the_same_stress(bearing):
    """On meshes about as fine as contacts are wide, and three to four times finer, which need no exchange."""
    instant, drawn = bearing(0.3, "operation.radial_load_N=30000")
    assert isinstance(instant.model, SpreadModel)
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=2e-3)  # recovered with Hertz's
    found = peaks(drawn, 400e3)
    _, shear, depth, half_width = found[found[:, 0] >= FIRST_ROLLER].T
    # in so wide a contact the disc's own uniform tension and the opposite force count: q/(2πR) = p₀ b/(4R)
    # and so narrow a patch, a third as strong as Hertz's pressure, brings more of the mesh's own error
    assert shear == pytest.approx(0.3003 + 0.25 * half_width / 5e-3, rel=0.05)
    assert depth == pytest.approx(np.full(10, 0.7861), rel=0.02)
    instant, drawn = bearing(0.08, "contact.model=resolved", "operation.radial_load_N=50000")
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=0.01)
    assert np.array_equal(drawn.stress(), drawn.smooth_stress)
    found = peaks(drawn, 700e3)  # nodal means of a mesh that has three to four elements in a half-width
    assert np.all((found[:, 1] > 0.26) & (found[:, 1] < 0.31)) and np.all((found[:, 2] > 0.6) & (found[:, 2] < 1.1))


@pytest.mark.parametrize("mesh_size, degrees", [(1.0, 0.0), (1.0, 3.7), (2.0, 1.1)])
def test_the_largest_shear_and_its_depth_are_those_of_theory_on_a_coarse_mesh(bearing, mesh_size, degrees):
    """0.300 p₀ at 0.786 b (McEwen, in Johnson, Contact Mechanics, 1985, section 4.2), within 2 %."""
    found = peaks(bearing(mesh_size, f"operation.first_roller_deg={degrees}")[1], 20e3)
    assert set(found[:, 0]) >= {INNER_RING, OUTER_RING, FIRST_ROLLER}
    assert_allclose(found[:, 1], 0.3003, rtol=0.02)
    assert_allclose(found[:, 2], 0.7861, rtol=0.02)


def test_along_a_rollers_axis_the_stress_is_the_exact_one(bearing):
    """A disc under two opposite forces: two simple radial fields and a uniform tension q/(πR) (Michell, 1900)."""
    instant, drawn = bearing(1.0, "operation.first_roller_deg=0.0")
    disc, radius, q = drawn.refined(2e-6, 3e-4, 0.1), 5e-3, instant.inner_force[0] / 10e-3
    at = np.flatnonzero(disc.body == FIRST_ROLLER)
    axis = at[np.abs(disc.local[at, 0]) < 2e-6]
    axis = axis[np.argsort(disc.local[axis, 1])]
    y, pairs = disc.local[axis, 1], (instant.model.outer_law.pair, instant.model.inner_law.pair)
    b = [pair.half_width(f[0]) for pair, f in zip(pairs, (instant.outer_force, instant.inner_force), strict=True)]
    expected = np.full((2, len(y)), q / (np.pi * radius))
    for depth, half_width in ((radius + y, b[0]), (radius - y, b[1])):
        peak = 2.0 * q / (np.pi * half_width)
        expected += mcewen(0.0 * depth, np.maximum(depth, 1e-9), half_width, peak)[:2]
    found, inside = disc.stress()[axis], np.abs(y) < 3.5e-3  # the mesh's own part
    assert len(y) > 50
    assert found[:, :2].T == pytest.approx(expected, abs=0.01 * peak)
    assert found[inside, 1] == pytest.approx(expected[1, inside], rel=0.05)


def test_the_shear_below_a_contact_is_the_resolved_models_and_the_same_on_two_meshes(bearing):
    instant, drawn = bearing(1.0, "operation.first_roller_deg=0.0")
    model, q = instant.model, instant.inner_force[0] / 10e-3
    widths = model.outer_law.pair.half_width(instant.outer_force[0]), model.inner_law.pair.half_width(10e-3 * q)
    y, xx, yy = resolved_disc(5e-3, model.roller.material, q, widths)
    shear = 0.5 * np.abs(xx - yy)
    for sign, b in ((-1.0, widths[0]), (1.0, widths[1])):
        end = np.flatnonzero((sign * y > 0.0) & (5e-3 - np.abs(y) < 3.0 * b))
        item = next(i for i in drawn.loads if i.body == FIRST_ROLLER and sign * i.load.point[1] > 0.0)
        peak = shear_peak(drawn, item)
        assert peak.shear == pytest.approx(shear[end].max(), rel=0.02)
        # the resolved mesh's nodes are a tenth of b apart
        assert peak.depth == pytest.approx((5e-3 - np.abs(y[end]))[shear[end].argmax()], abs=0.1 * b)
    fields = []
    for _, other in (bearing(size, "operation.first_roller_deg=0.0") for size in (1.0, 2.0)):
        item = next(i for i in other.loads if i.body == INNER_RING and i.load.point[1] < -17.99e-3)
        peak = shear_peak(other, item)
        fields.append((peak.shear, peak.depth))
    assert fields[0] == pytest.approx(fields[1], rel=0.01)
    gone = {name: 0.0 * getattr(instant, name)
            for name in ("inner_force", "outer_force", "inner_ring", "outer_ring", "rollers")}  # fmt: skip
    drawn = drawn_bearing(replace(instant, **gone)).refined(1e-4, 5e-4, 0.3)
    assert drawn.loads == [] and max_shear(drawn.stress()).max() == 0.0, "an unloaded bearing has no loads"


# Stress from displacements, and what is read from it


@pytest.mark.parametrize(
    "shape", [Disc(radius=5e-3, layers=3), Annulus(inner_radius=12.5e-3, outer_radius=18e-3, sectors=56, layers=3)]
)
@pytest.mark.parametrize(("gradient", "mises", "shear"), [
    ([[1.0, 0.0], [0.0, 0.0]], 2.0, 1.0),  # λ adds alike to all three
    ([[0.0, 1.0], [0.0, 0.0]], sqrt(3.0), 1.0), ([[1.0, 0.0], [0.0, 1.0]], 2.0, 0.0),
    ([[0.0, 1.0], [-1.0, 0.0]], 0.0, 0.0),  # a rotation
])  # fmt: skip
def test_stress_of_a_uniform_strain_is_exact(shape, gradient, mises, shear):
    mesh, unit = mesh_of(shape), STEEL.lame_mu * 1e-4
    displacement = mesh.points @ (1e-4 * np.array(gradient)).T
    stress = (stress_operator(mesh.points, mesh.cells, STEEL) @ displacement.ravel()).reshape(-1, 3)
    assert_allclose(von_mises(stress, STEEL.poisson_ratio), mises * unit, rtol=1e-9, atol=1.0)
    assert_allclose(max_shear(stress), shear * unit, rtol=1e-9, atol=1.0)


def tensors(stress):
    return np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=1)


def test_a_turned_stress_is_the_tensor_rotated():
    rng = np.random.default_rng(3)
    stress, angle = rng.normal(size=(5, 3)), rng.uniform(-4.0, 4.0, 5)
    rotation = np.moveaxis(np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]), 2, 0)
    found = turned(stress, angle)
    assert tensors(found) == pytest.approx(rotation @ tensors(stress) @ np.swapaxes(rotation, 1, 2))
    assert max_shear(found) == pytest.approx(max_shear(stress))
    assert von_mises(found, 0.3) == pytest.approx(von_mises(stress, 0.3))


# Analytic fields below a contact: against McEwen's formulas and against Flamant's solution summed up numerically

B, RADIUS, SPACING = 0.05e-3, 5e-3, 1e-3


def load_at(angle, force, inward_sign=-1.0, radius=RADIUS):
    """On a circle about the origin; `force` along the inward normal and along the counter-clockwise tangent, N/m."""
    outward = np.array([np.cos(angle), np.sin(angle)])
    inward, along = inward_sign * outward, np.array([-outward[1], outward[0]])
    return stress_below.SurfaceLoad(
        point=radius * outward, inward=inward, force=force[0] * inward + force[1] * along, half_width=B
    )


def below(load, x, z):
    """Points at depths z and distances x along the surface's tangent."""
    return load.point + np.outer(x, [load.inward[1], -load.inward[0]]) + np.outer(z, load.inward)


def test_largest_shear_of_the_half_plane_lies_where_the_textbook_says():
    """0.30 p₀ at 0.78 b (Johnson, Contact Mechanics, 1985, section 4.2)."""
    z, load = np.linspace(0.5, 1.1, 60_001) * B, load_at(0.4, (60e3, 0.0))
    xx, yy, xy = hertz_stress(below(load, 0.0 * z, z), load).T
    shear = np.hypot(0.5 * (xx - yy), xy) / (2.0 * 60e3 / (np.pi * B))
    assert shear.max() == pytest.approx(0.30, abs=0.001) == stress_below.LARGEST_SHEAR
    assert z[shear.argmax()] / B == pytest.approx(stress_below.AT_DEPTH, abs=1e-4)


@pytest.mark.parametrize("turned", [0.0, -np.pi / 2, 1.1, 2.3])
def test_pressure_with_traction_is_the_sum_of_flamants_solutions_and_far_away_their_resultant(turned):
    load, rng, angle = load_at(turned, (60e3, 9e3)), np.random.default_rng(2), np.pi * np.arange(1, 4001) / 4001
    node, weight = np.cos(angle), 2.0 / 4001 * np.sin(angle) ** 2  # Gauss-Chebyshev, of a unit semi-ellipse
    places = below(load, B * rng.uniform(-3.0, 3.0, 50), B * rng.uniform(0.05, 4.0, 50))
    expected = flamant(places, below(load, B * node, 0.0 * node), weight[:, None] * load.force)
    assert hertz_stress(places, load) == pytest.approx(expected, rel=1e-6, abs=1e3)
    far = below(load, np.array([-4e-3, 1e-3, 3e-3]), np.array([3e-3, 5e-3, 1e-3]))
    single = flamant(far, load.point[None], load.force[None])
    assert hertz_stress(far, load) == pytest.approx(single, rel=2e-3, abs=1e3)  # (b/r)²


@pytest.mark.parametrize("radius, inward_sign", [(RADIUS, -1.0), (-28e-3, 1.0)])
def test_the_smooth_patch_strains_as_flamants_solutions_on_its_arc_do(radius, inward_sign):
    load, step = load_at(-1.2, (60e3, 20e3), inward_sign, abs(radius)), 1e-7
    t = (np.arange(40_000) + 0.5) / 10_000 - 2.0
    angle = -1.2 + inward_sign * -t * SPACING / abs(radius)
    depth, across = np.array([0.5, 0.9, 2.0, 3.1]), np.array([-1.3, 0.2, 0.8, -2.5])
    polar, r = -1.2 + across * SPACING / abs(radius), abs(radius) - np.sign(radius) * depth * SPACING
    sources, places = (R * np.exp(1j * a) for R, a in ((abs(radius), angle), (r, polar)))
    sources, places = (np.column_stack([z.real, z.imag]) for z in (sources, places))
    expected = flamant(places, sources, continua.cubic_bspline(t)[:, None] / 10_000 * load.force)
    ahead, behind = (np.array([spline_displacement(places + sign * shift, load, radius, SPACING, STEEL)
                               for shift in step * np.eye(2)]) for sign in (1.0, -1.0))  # fmt: skip
    gradient = np.moveaxis((ahead - behind) / (2.0 * step), 0, -1)
    strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
    dilation = np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(2)
    stress = 2.0 * STEEL.lame_mu * strain + STEEL.lame_lambda * dilation
    assert stress == pytest.approx(tensors(expected), rel=2e-4, abs=2e-4 * np.abs(expected).max())
    # it is a displacement: it has no jump, and its rotation is its own
    assert np.all(np.abs(gradient) < 1e-2)


def test_the_patch_is_continuous_where_its_intervals_and_its_arc_end():
    angle = np.linspace(-3.0, 3.0, 4001) * SPACING / RADIUS
    surface = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    moved = spline_displacement(surface, load_at(0.0, (60e3, 0.0)), RADIUS, SPACING, STEEL)
    assert np.abs(np.diff(moved, axis=0)).max() < 3.0 * np.ptp(moved, axis=0).max() / 1000.0


# Pressure points, resolved by the mesh or spread over patches: Hertz's pressure, exact statics, a balanced run

LOAD = 300.0


def five():
    """Five rollers of a plastic in the paper's raceways; b = 0.24 mm under LOAD."""
    return kit.soft(n_rollers=5)


@cache
def spread_model(mesh_size):
    return SpreadModel.build(five(), mesh_size, LOAD)


def solved(model, load=LOAD, first=ON_A_ROLLER):
    return equilibrium(model, standing(model.bearing, first), Loads(load))


def test_graded_bodies_are_finest_where_they_touch_and_keep_their_cells_fair():
    shape = graded_disc(0.005, 1e-4)
    counts, mesh = [row.nodes for row in shape.rows], make(shape)
    assert isinstance(shape, GradedDisc) and shape.levels >= 1
    assert counts[-1] == shape.surface_nodes == 6 * shape.layers
    assert all(after in (before, 2 * before, before + 6) for before, after in itertools.pairwise(counts[1:]))
    assert len(mesh.points) == sum(counts) and len(mesh.cells) == shape.n_cells
    found = quality(mesh)
    assert found.smallest_angle > 40.0 and found.largest_angle < 95.0
    assert found.largest_edge > 2.0 * shape.surface_spacing, "the inside is coarser"
    for outside in (True, False):
        shape = GradedAnnulus(inner_radius=0.0125, outer_radius=0.018, sectors=320, raceway_outside=outside)
        steps, mesh = np.diff(shape.radii), make(shape)
        assert shape.radii[[0, -1]] == pytest.approx([0.0125, 0.018], rel=1e-12)
        assert (steps[-1] if outside else steps[0]) == steps.min()
        assert 0.7 < steps.min() / (2.0 * np.pi * (0.018 if outside else 0.0125) / 320) <= 1.0
        assert mesh.cells.shape == (320 * shape.layers, 4)
        assert_allclose(np.hypot(*mesh.points.T).reshape(-1, 320), np.tile(shape.radii[:, None], 320), rtol=1e-12)


@pytest.mark.slow  # `python -m tests.verification` has resolved statics as well
def test_the_resolved_equilibrium_converges_to_the_exact_series():
    """Hertz's own error is (b/R)² = 0.1 %; the layer's and the mesh's shrink with the mesh."""
    exact = exact_statics(five(), LOAD, ON_A_ROLLER)
    models = [resolved_model(five(), size) for size in (1.2e-4, 6e-5)]
    layers = [continua.layer_approach(model.inner_law, exact.inner_force.max()) for model in models]
    assert layers[0] / layers[1] == pytest.approx(2.0, rel=0.05)
    for found, tolerance in zip(map(solved, models), (8e-3, 2e-3), strict=True):
        assert_allclose(found.inner_force, exact.inner_force, atol=tolerance * LOAD)
        assert abs(found.hub[0]) < 1e-3 * abs(found.hub[1])
    assert abs(found.hub[1] / exact.hub[1] - 1.0) < 3e-3


@cache
def fade(size):
    """At a mesh size, mm: errors of hub and loads against the series, and the most loaded contact's share below."""
    exact, model = exact_statics(five(), LOAD, ON_A_ROLLER), spread_model(1e-3 * size)
    law, rest = exact_contacts(five(), roller_angles(five(), ON_A_ROLLER)).inner_law, solved(model)
    pressed = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[int(rest.inner_force.argmax())]
    force = pressed.pressure * model.inner_law.spacing * model.inner_law.pair.length
    below = force @ model.inner_law.local_compliance(force.size) @ force / force.sum()
    loads = np.abs(rest.inner_force - exact.inner_force).max() / exact.inner_force.max()
    return abs(rest.hub[1] / exact.hub[1] - 1.0), loads, below / float(law.approach(force.sum()))


def test_the_term_below_the_grid_fades_out_and_statics_stay_exact_from_far_too_coarse_to_resolved():
    """Smoothly, from two fifths of a contact's approach, b = 0.24 mm.

    What a mesh lacks is a mean over places, of which it strays by 1 % itself; that fades out as well.
    """
    hub, loads, share = np.transpose([fade(size) for size in (1.0, 0.5, 0.25, 0.12)])
    assert share[0] > 0.35 and np.all(share[1:] < 0.7 * share[:-1])
    assert hub.max() < 5e-3 and hub[2:].max() < 1e-3 and loads.max() < 1.5e-3


@pytest.mark.slow  # a mesh with ten times the others' nodes
def test_next_to_nothing_is_left_below_a_grid_of_a_quarter_of_the_half_width():
    hub, forces, share = fade(0.06)
    assert share < 0.02 and hub < 1e-3 and forces < 1.5e-3


@pytest.mark.parametrize(("model", "peak_error", "width_error"), [
    (lambda: spread_model(5e-4), 0.03, 0.01), (lambda: spread_model(1.2e-4), 0.03, 0.01),
    (lambda: resolved_model(five(), 6e-5), 0.04, 0.04),
], ids=["spread on 0.5 mm", "spread on 0.12 mm", "resolved"])  # fmt: skip
def test_pressures_are_hertzs(model, peak_error, width_error):
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4), on any mesh."""
    law, found = model().inner_law, contact_pressures(model(), standing(five(), ON_A_ROLLER), LOAD)[0]
    force, whole = found.pressure.sum() * law.spacing * law.pair.length, found.pressure.sum()
    b = law.pair.half_width(force)
    peak, inside = 2.0 * force / (np.pi * b * law.pair.length), np.abs(found.across) < 0.9 * b
    if width_error == peak_error:  # four points to a node
        assert np.convolve(found.pressure, np.full(4, 0.25), mode="same").max() == pytest.approx(peak, rel=peak_error)
        assert abs(np.sum(found.pressure * found.across)) < 1e-3 * b * whole
    else:
        hertz = peak * np.sqrt(1.0 - (found.across[inside] / b) ** 2)
        assert_allclose(found.pressure[inside], hertz, rtol=peak_error)
    assert 2.0 * np.sqrt(np.sum(found.pressure * found.across**2) / whole) == pytest.approx(b, rel=width_error)


@pytest.mark.parametrize(("clearance_um", "mass", "first"), [(40.0, 3.0, 0.0), (15.0, 0.1, 9.0)])
def test_rollers_that_only_their_weight_presses_find_their_place(clearance_um, mass, first):
    """Points leave a contact open by a nanometre that the series close, and a weight must not fall through the ring."""
    load, angle = 4e4, ON_A_ROLLER + np.radians(first)
    plan = make_plan(parse_scene({
        "bearing": {"outer_raceway_diameter_mm": 56.0 + 1e-3 * clearance_um},
        "operation": {"inner_ring_and_shaft_kg": mass, "speed_rpm": 0.0, "radial_load_N": load,
                      "first_roller_deg": first},
        "numerics": {"mesh_size_mm": 0.5, "duration_ms": 0.0},
    }, "test"))  # fmt: skip
    bearing, found = plan.model.bearing, plan.start.equilibrium
    exact = exact_statics(bearing, load + 9.81 * mass, angle)
    kit.within(found.inner_force, exact.inner_force, 1e-2 * exact.inner_force.max())
    weight = 9.81 * bearing.roller_mass * np.sin(roller_angles(bearing, angle))  # along the radius
    loose = (weight > 0.0) & (exact.inner_force == 0.0)
    kit.within(found.inner_force[loose], weight[loose], 1e-4)  # LOOSE_SPRING, 0.1 mm


def test_points_in_contact_are_found_as_by_another_method():
    """Against non-negative least squares of the factored problem (Lawson and Hanson), also where a wave parts them."""
    laws = spread_model(2.5e-4).laws
    some, full = points(laws, LOAD, 5), toeplitz(laws[0].missing_compliance)
    x, root, find = np.linspace(-1.0, 1.0, some.closing.size), np.linalg.cholesky(full), kernel(spread_forces)
    for shape in (0.1 - x**2, 0.05 - x**2 + 0.02 * x, 0.25 * np.cos(12.0 * x) - 2.0 * x**2, -1.0 - x**2):
        some.closing[:] = 1e-6 * shape
        energy = find(some, some.spread, 0, 0)
        wanted, _ = nnls(root.T, np.linalg.solve(root, some.closing))
        kit.within(some.force, wanted, 1e-7 * max(wanted.max(), 1e-9))
        assert energy == pytest.approx(0.5 * wanted @ full @ wanted, rel=1e-6, abs=1e-15)
    some = points((laws[0],) * 3, LOAD, 5)
    some.closing[:] = 1e-5
    find(some, some.spread, 0, 0)
    assert np.isnan(some.force).any(), "a contact wider than its points is not a number"


compiles = pytest.mark.slow  # a time loop of its own


@compiles
@pytest.mark.parametrize(
    "make", [lambda: resolved_model(five(), 1.2e-4), lambda: spread_model(2.5e-4)], ids=["resolved", "spread"]
)
def test_the_start_stands_still_and_the_step_limit_is_on_its_safe_side_and_close(make):
    """Forces of the time loop at t = 0 are those of the equilibrium; nothing pushes the hub.

    Free vibration of a squeezed bearing from round-off: stable at 0.99 of the limit, gone well before 1.3 of it.
    """
    model, how = make(), operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    limit, wanted = critical_time_step(model, LOAD), solved(model, LOAD, how.first_roller_angle)
    state = copies(arrays(model, how, 0.9 * limit))
    press_contacts(state)
    kit.within(state.contacts.forces.force[:2, :5], [wanted.inner_force, wanted.outer_force], 1e-6 * LOAD)

    def advanced(share, n_samples, stride):
        """Samples of a run, finite or not."""
        state = copies(arrays(model, how, share * limit))
        samples = np.zeros((n_samples, columns.N_SCALARS + len(columns.BLOCKS) * state.bodies.rollers.n))
        advance(*kit.loop_arguments(state), 0, stride, samples)
        return samples

    acceleration = advanced(0.9, 1, 1)[0, [columns.HUB_AX, columns.HUB_AY]]
    assert np.abs(acceleration).max() * how.inner_mass < 1e-3 * LOAD

    def grown(share):
        path = advanced(share, 12, 100)[:, 1:3]
        return not np.all(np.isfinite(path)) or np.abs(path - path[0]).max() > 1e-3 * np.abs(path[0]).max()

    assert not grown(0.99) and grown(1.3)


def rolling_scene(model, friction, mesh_size, duration, **operation):
    return parse_scene({
        "bearing": {"rollers": 5}, "material": {"youngs_modulus_GPa": 5.0},
        "operation": {"radial_load_N": LOAD, "speed_rpm": 3000.0, **operation},
        "contact": {"model": model, "friction_coefficient": friction},
        "numerics": {"mesh_size_mm": mesh_size, "duration_ms": duration, "output_interval_us": 5.0},
    }, "test")  # fmt: skip


LIGHT_HUB = {"gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 0.3}


@compiles
@pytest.mark.parametrize(("friction", "most"), [(0.0, 1e-5), (0.1, 2e-4)])
def test_runs_with_resolved_and_with_spread_points_balance_their_energy(friction, most):
    """Forces are the gradient of one potential, and what opens and closes gives back what it took."""
    plan = make_plan(rolling_scene("resolved", friction, 0.12, 0.2))
    check_meshes(plan.model)
    found = whole_run(plan)
    assert abs(found.relative_error()[-1]) < 2e-4
    assert np.all(np.isfinite(found["inner_force"])) and found["inner_force"].max() < 1.1 * LOAD
    found = run(make_plan(rolling_scene("subgrid", friction, 0.3, 3.0, **LIGHT_HUB)), lambda samples: None)
    assert abs(found.imbalance) < most


@compiles
@pytest.mark.parametrize(("one", "other", "duration", "operation", "most"), [
    (("resolved", 0.08), ("subgrid", 1.0), 0.2, {"speed_rpm": 3000.0}, 2e-2),
    (("subgrid", 0.25), ("subgrid", 0.8), 0.5, LIGHT_HUB, 5e-3),  # points and one patch
])  # fmt: skip
def test_contact_models_give_the_same_run(one, other, duration, operation, most):
    plans = [make_plan(rolling_scene(model, 0.1, size, duration, **operation)) for model, size in (one, other)]
    hubs = np.array([[run["inner_x"], run["inner_y"]] for run in map(whole_run, plans)])
    assert np.abs(hubs[0] - hubs[1]).max() < most * np.abs(hubs[1, 1]).mean()

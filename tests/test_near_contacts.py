"""Stress below the contacts of a coarse mesh: against theory, an exact field and a resolved model."""

import itertools
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import nnls

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.points import points
from fem.contacts.resolved import SpreadModel
from fem.elastic.bodies import max_shear, stress_operator, turned, von_mises
from fem.kernels.columns import BLOCKS, HUB_AX, HUB_AY, N_SCALARS
from fem.kernels.elements.loop import advance
from fem.kernels.elements.points import spread_forces
from fem.kernels.jit import kernel
from fem.pictures.bodies import drawn_bearing
from fem.pictures.recover import read_instant
from fem.pictures.stress_below import (
    AT_DEPTH,
    FIRST_ROLLER,
    INNER_RING,
    LARGEST_SHEAR,
    OUTER_RING,
    SurfaceLoad,
    hertz_stress,
    shear_peak,
    spline_displacement,
)
from fem.solver.elements.plan import model_of
from fem.solver.limits import check_meshes
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange import Material
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import parse_scene
from meshes import Annulus, Disc, GradedAnnulus, GradedDisc, mesh_of, quality
from meshes.graded import graded_disc
from meshes.shapes import make
from tests.reference.compiled import press_contacts
from tests.reference.continua import contact_pressures, cubic_bspline, flamant, layer_approach, mcewen
from tests.reference.kit import arrays, copies, loop_arguments, operation, resolved_model, soft, whole_run
from tests.reference.resolved import resolved_disc

STANDING = ["operation.speed_rpm=0", "operation.gravity_m_s2=0", "contact.friction_coefficient=0"]


@pytest.fixture(scope="module")
def bearing(tmp_path_factory):
    """The static bearing at a mesh size, mm, its first roller so many degrees from the load line."""
    folder = tmp_path_factory.mktemp("standing")

    def make(mesh_size, degrees=0.0):
        path = folder / f"{mesh_size}_{degrees}.nc"
        sets = [*STANDING, f"operation.first_roller_deg={degrees}"]
        options = [word for each in sets for word in ("--set", each)]
        options += ["--mesh-size", str(mesh_size), "--duration", "0", "--output", str(path), "--quiet"]
        assert run_main(options) == 0
        instant = read_instant(path)
        return instant, drawn_bearing(instant)

    return make


@pytest.mark.slow
def test_pressure_points_give_way_to_the_same_stress(tmp_path):
    """A mesh about as fine as its contacts are wide."""
    path = tmp_path / "points.nc"
    sets = [*STANDING, "operation.radial_load_N=30000"]
    options = [word for each in sets for word in ("--set", each)]
    assert run_main(["--mesh-size", "0.3", "--duration", "0", "--output", str(path), "--quiet", *options]) == 0
    instant = read_instant(path)
    assert isinstance(instant.model, SpreadModel)
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=2e-3)  # recovered with Hertz's
    drawn = drawn_bearing(instant)
    rollers = [item for item in drawn.loads if item.body >= FIRST_ROLLER and np.hypot(*item.load.force) > 400e3]
    for item in rollers:
        peak = shear_peak(drawn, item)
        # in so wide a contact the disc's own uniform tension and the opposite force count: q/(2πR) = p₀ b/(4R)
        # and so narrow a patch, a third as strong as Hertz's pressure, brings more of the mesh's own error
        assert peak.shear / peak.pressure == pytest.approx(0.3003 + 0.25 * peak.half_width / 5e-3, rel=0.05)
        assert peak.depth / peak.half_width == pytest.approx(0.7861, rel=0.02)
    assert len(rollers) == 10


@pytest.mark.slow
def test_a_mesh_that_resolves_its_contacts_needs_no_exchange(tmp_path):
    path = tmp_path / "resolved.nc"
    sets = [*STANDING, "contact.model=resolved", "operation.radial_load_N=50000"]
    options = [word for each in sets for word in ("--set", each)]
    assert run_main(["--mesh-size", "0.08", "--duration", "0", "--output", str(path), "--quiet", *options]) == 0
    instant = read_instant(path)
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=0.01)
    drawn = drawn_bearing(instant)
    assert np.array_equal(drawn.stress(), drawn.smooth_stress)
    found = _peaks(drawn, 700e3)  # nodal means of a mesh that has three to four elements in a half-width
    assert np.all((found[:, 1] > 0.26) & (found[:, 1] < 0.31)) and np.all((found[:, 2] > 0.6) & (found[:, 2] < 1.1))


def _peaks(drawn, least):
    """Of all contacts above a line load, N/m: body, shear over p₀, depth over b."""
    found = []
    for item in drawn.loads:
        if np.hypot(*item.load.force) > least:
            peak = shear_peak(drawn, item)
            found.append((item.body, peak.shear / peak.pressure, peak.depth / peak.half_width))
    return np.array(found)


@pytest.mark.parametrize("mesh_size, degrees", [(1.0, 0.0), (1.0, 3.7), (2.0, 1.1)])
def test_the_largest_shear_and_its_depth_are_those_of_theory_on_a_coarse_mesh(bearing, mesh_size, degrees):
    """0.300 p₀ at 0.786 b (McEwen, in Johnson, Contact Mechanics, 1985, section 4.2), within 2 %."""
    _, drawn = bearing(mesh_size, degrees)
    found = _peaks(drawn, 20e3)
    assert set(found[:, 0]) >= {INNER_RING, OUTER_RING, FIRST_ROLLER}
    assert found[:, 1] == pytest.approx(np.full(len(found), 0.3003), rel=0.02)
    assert found[:, 2] == pytest.approx(np.full(len(found), 0.7861), rel=0.02)


def test_along_a_rollers_axis_the_stress_is_the_exact_one(bearing):
    """A disc under two opposite forces: two simple radial fields and a uniform tension q/(πR) (Michell, 1900)."""
    instant, drawn = bearing(1.0)
    disc = drawn.refined(2e-6, 3e-4, 0.1)
    at = np.flatnonzero(disc.body == FIRST_ROLLER)
    local = disc.local[at]
    axis = at[np.abs(local[:, 0]) < 2e-6]
    axis = axis[np.argsort(disc.local[axis, 1])]
    y, radius = disc.local[axis, 1], 5e-3
    q = instant.inner_force[0] / 10e-3
    model = instant.model
    b = model.outer_law.pair.half_width(instant.outer_force[0]), model.inner_law.pair.half_width(instant.inner_force[0])
    expected = np.full((2, len(y)), q / (np.pi * radius))
    for depth, half_width in ((radius + y, b[0]), (radius - y, b[1])):
        sx, sz, _ = mcewen(0.0 * depth, np.maximum(depth, 1e-9), half_width, 2.0 * q / (np.pi * half_width))
        expected += [sx, sz]
    found = disc.stress()[axis]
    peak = 2.0 * q / (np.pi * b[1])
    assert len(y) > 50
    assert found[:, 0] == pytest.approx(expected[0], abs=0.01 * peak)
    assert found[:, 1] == pytest.approx(expected[1], abs=0.01 * peak)
    inside = np.abs(y) < 3.5e-3  # the mesh's own part
    assert found[inside, 1] == pytest.approx(expected[1, inside], rel=0.05)


def test_the_shear_below_a_contact_is_the_resolved_models(bearing):
    instant, drawn = bearing(1.0)
    model = instant.model
    q = instant.inner_force[0] / 10e-3
    outer, inner = model.outer_law.pair, model.inner_law.pair
    widths = outer.half_width(instant.outer_force[0]), inner.half_width(instant.inner_force[0])
    y, xx, yy = resolved_disc(5e-3, model.roller.material, q, widths)
    shear = 0.5 * np.abs(xx - yy)
    for sign, b in ((-1.0, widths[0]), (1.0, widths[1])):
        end = np.flatnonzero((sign * y > 0.0) & (5e-3 - np.abs(y) < 3.0 * b))
        resolved, depth = shear[end].max(), (5e-3 - np.abs(y[end]))[shear[end].argmax()]
        item = next(i for i in drawn.loads if i.body == FIRST_ROLLER and sign * i.load.point[1] > 0.0)
        peak = shear_peak(drawn, item)
        assert peak.shear == pytest.approx(resolved, rel=0.02)
        assert peak.depth == pytest.approx(depth, abs=0.1 * b)  # the resolved mesh's nodes are a tenth of b apart


def test_two_meshes_show_the_same_stress_near_a_contact(bearing):
    fields = []
    for mesh_size in (1.0, 2.0):
        _, drawn = bearing(mesh_size)
        item = next(i for i in drawn.loads if i.body == INNER_RING and i.load.point[1] < -17.99e-3)
        peak = shear_peak(drawn, item)
        fields.append((peak.shear, peak.depth))
    assert fields[0] == pytest.approx(fields[1], rel=0.01)


def test_an_unloaded_bearing_has_no_loads(bearing):
    instant, _ = bearing(2.0)
    nothing = np.zeros(13)
    still = replace(
        instant, inner_force=nothing, outer_force=nothing, inner_ring=0.0 * instant.inner_ring,
        outer_ring=0.0 * instant.outer_ring, rollers=0.0 * instant.rollers,
    )  # fmt: skip
    drawn = drawn_bearing(still).refined(1e-4, 5e-4, 0.3)
    assert drawn.loads == [] and max_shear(drawn.stress()).max() == 0.0


# Stress from displacements, and what is read from it


STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)


@pytest.mark.parametrize(
    "shape", [Disc(radius=5e-3, layers=3), Annulus(inner_radius=12.5e-3, outer_radius=18e-3, sectors=56, layers=3)]
)
@pytest.mark.parametrize(
    "gradient, mises, shear",
    [
        ([[1e-4, 0.0], [0.0, 0.0]], 2.0 * STEEL.lame_mu * 1e-4, STEEL.lame_mu * 1e-4),  # λ adds alike to all three
        ([[0.0, 1e-4], [0.0, 0.0]], sqrt(3.0) * STEEL.lame_mu * 1e-4, STEEL.lame_mu * 1e-4),
        ([[1e-4, 0.0], [0.0, 1e-4]], 2.0 * STEEL.lame_mu * 1e-4, 0.0),
        ([[0.0, 1e-4], [-1e-4, 0.0]], 0.0, 0.0),  # a rotation
    ],
)
def test_stress_of_a_uniform_strain_is_exact(shape, gradient, mises, shear):
    mesh = mesh_of(shape)
    displacement = mesh.points @ np.array(gradient).T
    stress = (stress_operator(mesh.points, mesh.cells, STEEL) @ displacement.ravel()).reshape(-1, 3)
    n = len(mesh.points)
    assert von_mises(stress, STEEL.poisson_ratio) == pytest.approx(np.full(n, mises), rel=1e-9, abs=1.0)
    assert max_shear(stress) == pytest.approx(np.full(n, shear), rel=1e-9, abs=1.0)


def test_a_turned_stress_is_the_tensor_rotated():
    rng = np.random.default_rng(3)
    stress, angle = rng.normal(size=(5, 3)), rng.uniform(-4.0, 4.0, 5)
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=1)
    tensor = np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=1)
    expected = rotation @ tensor @ np.swapaxes(rotation, 1, 2)
    found = turned(stress, angle)
    assert found[:, 0] == pytest.approx(expected[:, 0, 0])
    assert found[:, 1] == pytest.approx(expected[:, 1, 1])
    assert found[:, 2] == pytest.approx(expected[:, 0, 1])
    assert max_shear(found) == pytest.approx(max_shear(stress))
    assert von_mises(found, 0.3) == pytest.approx(von_mises(stress, 0.3))


# Analytic fields below a contact: against McEwen's formulas and against Flamant's solution summed up numerically


B = 0.05e-3
RADIUS, SPACING = 5e-3, 1e-3


def load_at(angle, force, inward_sign=-1.0, radius=RADIUS):
    """On a circle about the origin; `force` along the inward normal and along the counter-clockwise tangent, N/m."""
    outward = np.array([np.cos(angle), np.sin(angle)])
    inward, along = inward_sign * outward, np.array([-outward[1], outward[0]])
    return SurfaceLoad(
        point=radius * outward, inward=inward, force=force[0] * inward + force[1] * along, half_width=B
    )  # fmt: skip


def below(load, x, z):
    """Points at depths z and distances x along the surface's tangent."""
    along = np.array([load.inward[1], -load.inward[0]])
    return load.point + np.outer(x, along) + np.outer(z, load.inward)


@pytest.mark.parametrize("angle", [0.0, -np.pi / 2, 2.3])
def test_pressure_gives_mcewens_stresses_in_any_direction(angle):
    rng = np.random.default_rng(1)
    x, z = B * rng.uniform(-5.0, 5.0, 200), B * rng.uniform(1e-3, 5.0, 200)
    load = load_at(angle, (60e3, 0.0))
    found = hertz_stress(below(load, x, z), load)
    sx, sz, txz = mcewen(x, z, B, 2.0 * 60e3 / (np.pi * B))
    along, inward = np.array([load.inward[1], -load.inward[0]]), load.inward
    tensor = np.stack([found[:, [0, 2]], found[:, [2, 1]]], axis=1)
    assert np.einsum("nij,i,j->n", tensor, along, along) == pytest.approx(sx, rel=1e-9, abs=1.0)
    assert np.einsum("nij,i,j->n", tensor, inward, inward) == pytest.approx(sz, rel=1e-9, abs=1.0)
    assert np.einsum("nij,i,j->n", tensor, along, inward) == pytest.approx(txz, rel=1e-9, abs=1.0)


def test_largest_shear_of_the_half_plane_lies_where_the_textbook_says():
    """0.30 p₀ at 0.78 b (Johnson, Contact Mechanics, 1985, section 4.2)."""
    z = np.linspace(0.5, 1.1, 60_001) * B
    load = load_at(0.4, (60e3, 0.0))
    xx, yy, xy = hertz_stress(below(load, 0.0 * z, z), load).T
    shear = np.hypot(0.5 * (xx - yy), xy) / (2.0 * 60e3 / (np.pi * B))
    assert shear.max() == pytest.approx(0.30, abs=0.001) == LARGEST_SHEAR
    assert z[shear.argmax()] / B == pytest.approx(AT_DEPTH, abs=1e-4)


def test_pressure_with_traction_is_the_sum_of_flamants_solutions():
    load = load_at(1.1, (60e3, 9e3))
    node = np.cos(np.pi * np.arange(1, 4001) / 4001)  # Gauss-Chebyshev points of the second kind
    weight = 2.0 / 4001 * np.sin(np.pi * np.arange(1, 4001) / 4001) ** 2  # of a unit semi-ellipse
    sources = below(load, B * node, 0.0 * node)
    rng = np.random.default_rng(2)
    points = below(load, B * rng.uniform(-3.0, 3.0, 50), B * rng.uniform(0.05, 4.0, 50))
    expected = flamant(points, sources, weight[:, None] * load.force)
    assert hertz_stress(points, load) == pytest.approx(expected, rel=1e-6, abs=1e3)


def test_far_away_only_the_resultant_matters():
    load = load_at(0.0, (60e3, 9e3))
    points = below(load, np.array([-4e-3, 1e-3, 3e-3]), np.array([3e-3, 5e-3, 1e-3]))
    single = flamant(points, load.point[None], load.force[None])
    assert hertz_stress(points, load) == pytest.approx(single, rel=2e-3, abs=1e3)  # (b/r)²


@pytest.mark.parametrize("radius, inward_sign", [(RADIUS, -1.0), (-28e-3, 1.0)])
def test_the_smooth_patch_strains_as_flamants_solutions_on_its_arc_do(radius, inward_sign):
    load = load_at(-1.2, (60e3, 20e3), inward_sign, abs(radius))
    t = (np.arange(40_000) + 0.5) / 10_000 - 2.0
    weight = cubic_bspline(t) / 10_000
    angle = -1.2 + inward_sign * -t * SPACING / abs(radius)
    sources = abs(radius) * np.column_stack([np.cos(angle), np.sin(angle)])
    depth, across = np.array([0.5, 0.9, 2.0, 3.1]), np.array([-1.3, 0.2, 0.8, -2.5])
    polar = -1.2 + across * SPACING / abs(radius)
    r = abs(radius) - np.sign(radius) * depth * SPACING
    points = r[:, None] * np.column_stack([np.cos(polar), np.sin(polar)])
    expected = flamant(points, sources, weight[:, None] * load.force)

    step = 1e-7
    gradient = np.stack([
        (spline_displacement(points + shift, load, radius, SPACING, STEEL)
         - spline_displacement(points - shift, load, radius, SPACING, STEEL)) / (2.0 * step)
        for shift in step * np.eye(2)
    ], axis=-1)  # fmt: skip
    strain = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
    stress = 2.0 * STEEL.lame_mu * strain + STEEL.lame_lambda * np.trace(strain, axis1=1, axis2=2)[
        :, None, None
    ] * np.eye(2)  # fmt: skip
    found = np.stack([stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1]], axis=-1)
    assert found == pytest.approx(expected, rel=2e-4, abs=2e-4 * np.abs(expected).max())
    # it is a displacement: it has no jump, and its rotation is its own
    assert np.all(np.abs(gradient) < 1e-2)


def test_the_patch_is_continuous_where_its_intervals_and_its_arc_end():
    load = load_at(0.0, (60e3, 0.0))
    across = np.linspace(-3.0, 3.0, 4001)
    angle = across * SPACING / RADIUS
    surface = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    moved = spline_displacement(surface, load, RADIUS, SPACING, STEEL)
    steps = np.abs(np.diff(moved, axis=0)).max()
    assert steps < 3.0 * np.ptp(moved, axis=0).max() / 1000.0


# Pressure points, resolved by the mesh or spread over patches: Hertz's pressure, exact statics, a balanced run


ON_A_ROLLER = -0.5 * np.pi
LOAD = 300.0


def five():
    """Five rollers of a plastic in the paper's raceways; b = 0.24 mm under LOAD."""
    return soft(n_rollers=5)


@cache
def spread_model(mesh_size):
    return SpreadModel.of_force(five(), mesh_size, LOAD)


def solved(model, load=LOAD, first=ON_A_ROLLER):
    return equilibrium(model, standing(model.bearing, first), Loads(load))


# meshes that coarsen away from the raceways ---------------------------------------------------------------------


def test_a_graded_disc_halves_its_rows_and_keeps_its_triangles_fair():
    shape = graded_disc(0.005, 1e-4)
    counts = [row.nodes for row in shape.rows]
    assert isinstance(shape, GradedDisc) and shape.levels >= 1
    assert counts[-1] == shape.surface_nodes == 6 * shape.layers
    assert all(after in (before, 2 * before, before + 6) for before, after in itertools.pairwise(counts[1:]))
    mesh = make(shape)
    assert len(mesh.points) == sum(counts) and len(mesh.cells) == shape.n_cells
    found = quality(mesh)
    assert found.smallest_angle > 40.0 and found.largest_angle < 95.0
    assert found.largest_edge > 2.0 * shape.surface_spacing, "the inside is coarser"


@pytest.mark.parametrize("outside", [True, False])
def test_a_graded_ring_is_finest_at_its_raceway(outside):
    shape = GradedAnnulus(inner_radius=0.0125, outer_radius=0.018, sectors=320, raceway_outside=outside)
    steps = np.diff(shape.radii)
    assert shape.radii[[0, -1]] == pytest.approx([0.0125, 0.018], rel=1e-12)
    finest = steps[-1] if outside else steps[0]
    raceway = 0.018 if outside else 0.0125
    assert finest == steps.min() and 0.7 < finest / (2.0 * np.pi * raceway / 320) <= 1.0
    mesh = make(shape)
    assert mesh.cells.shape == (320 * shape.layers, 4)
    radius = np.hypot(*mesh.points.T).reshape(-1, 320)
    np.testing.assert_allclose(radius, np.tile(shape.radii[:, None], 320), rtol=1e-12)


@pytest.mark.slow  # `python -m tests.verification` has resolved statics as well
def test_the_resolved_equilibrium_converges_to_the_exact_series():
    """Hertz's own error is (b/R)² = 0.1 %; the layer's and the mesh's shrink with the mesh."""
    exact = exact_statics(five(), LOAD, ON_A_ROLLER)
    models = [resolved_model(five(), size) for size in (1.2e-4, 6e-5)]
    found = [solved(model) for model in models]
    errors = [abs(one.hub[1] / exact.hub[1] - 1.0) for one in found]
    assert errors[1] < 3e-3, errors
    layers = [layer_approach(model.inner_law, exact.inner_force.max()) for model in models]
    assert layers[0] / layers[1] == pytest.approx(2.0, rel=0.05)
    for one, tolerance in zip(found, (8e-3, 2e-3), strict=True):
        np.testing.assert_allclose(one.inner_force, exact.inner_force, atol=tolerance * LOAD)
        assert abs(one.hub[0]) < 1e-3 * abs(one.hub[1])


def test_pressures_are_hertzs():
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4)."""
    model = resolved_model(five(), 6e-5)
    found = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[0]
    law = model.inner_law
    force = found.pressure.sum() * law.spacing * law.pair.length
    b = law.pair.half_width(force)
    peak = 2.0 * force / (np.pi * b * law.pair.length)
    nodal = np.convolve(found.pressure, np.full(4, 0.25), mode="same")  # four points to a node
    assert nodal.max() == pytest.approx(peak, rel=0.04)
    width = 2.0 * np.sqrt(np.sum(found.pressure * found.across**2) / found.pressure.sum())
    assert width == pytest.approx(b, rel=0.04)
    assert abs(np.sum(found.pressure * found.across)) < 1e-3 * b * found.pressure.sum()


SIZES = (1.0, 0.5, 0.25, 0.12)  # mm; b = 0.24 mm


@cache
def fade(sizes=SIZES):
    """Mesh size, mm -> errors of hub and loads against the series, and the most loaded contact's share below."""
    exact = exact_statics(five(), LOAD, ON_A_ROLLER)
    law = exact_contacts(five(), roller_angles(five(), ON_A_ROLLER)).inner_law
    found = {}
    for size in sizes:
        model = spread_model(1e-3 * size)
        rest = equilibrium(model, standing(five(), ON_A_ROLLER), Loads(LOAD))
        pressed = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[int(rest.inner_force.argmax())]
        force = pressed.pressure * model.inner_law.spacing * model.inner_law.pair.length
        below = force @ model.inner_law.local_compliance(force.size) @ force / force.sum()
        found[size] = (
            abs(rest.hub[1] / exact.hub[1] - 1.0),
            np.abs(rest.inner_force - exact.inner_force).max() / exact.inner_force.max(),
            below / float(law.approach(force.sum())),
        )
    return found


def test_the_term_below_the_grid_fades_out():
    """Smoothly, from two fifths of a contact's approach."""
    share = np.array([found[2] for found in fade().values()])
    assert share[0] > 0.35
    assert np.all(share[1:] < 0.7 * share[:-1])


@pytest.mark.slow  # a mesh with ten times the others' nodes
def test_next_to_nothing_is_left_below_a_grid_of_a_quarter_of_the_half_width():
    hub, forces, share = fade((0.06,))[0.06]
    assert share < 0.02
    assert hub < 1e-3 and forces < 1.5e-3


def test_statics_stay_exact_from_far_too_coarse_to_resolved():
    """What a mesh lacks is a mean over places, of which it strays by 1 % itself; that fades out as well."""
    for size, (hub, forces, _) in fade().items():
        assert hub < (1e-3 if size < 0.3 else 5e-3) and forces < 1.5e-3, size


@pytest.mark.parametrize("size", [0.5, 0.12])
def test_pressures_of_spread_points_are_hertzs(size):
    """On any mesh."""
    model = spread_model(1e-3 * size)
    law = model.inner_law
    found = contact_pressures(model, standing(five(), ON_A_ROLLER), LOAD)[0]
    force = found.pressure.sum() * law.spacing * law.pair.length
    b = law.pair.half_width(force)
    inside = np.abs(found.across) < 0.9 * b
    hertz = 2.0 * force / (np.pi * b * law.pair.length) * np.sqrt(1.0 - (found.across[inside] / b) ** 2)
    np.testing.assert_allclose(found.pressure[inside], hertz, rtol=0.03)
    assert 2.0 * np.sqrt(np.sum(found.pressure * found.across**2) / found.pressure.sum()) == pytest.approx(b, rel=0.01)


@pytest.mark.parametrize(("clearance_um", "mass", "first"), [(40.0, 3.0, 0.0), (15.0, 0.1, 9.0)])
def test_rollers_that_only_their_weight_presses_find_their_place(clearance_um, mass, first):
    """Points leave a contact open by a nanometre that the series close, and a weight must not fall through the ring."""
    load = 4e4
    data = {
        "bearing": {"outer_raceway_diameter_mm": 56.0 + 1e-3 * clearance_um},
        "operation": {"inner_ring_and_shaft_kg": mass, "speed_rpm": 0.0, "radial_load_N": load,
                      "first_roller_deg": first},
        "numerics": {"mesh_size_mm": 0.5, "duration_ms": 0.0},
    }  # fmt: skip
    plan = make_plan(parse_scene(data, "test"))
    bearing, found = plan.model.bearing, plan.start.equilibrium
    exact = exact_statics(bearing, load + 9.81 * mass, ON_A_ROLLER + np.radians(first))
    np.testing.assert_allclose(found.inner_force, exact.inner_force, rtol=0.0, atol=1e-2 * exact.inner_force.max())
    upward = np.sin(roller_angles(bearing, ON_A_ROLLER + np.radians(first)))
    weight = 9.81 * bearing.roller_mass * upward  # along the radius
    loose = (weight > 0.0) & (exact.inner_force == 0.0)
    np.testing.assert_allclose(found.inner_force[loose], weight[loose], rtol=0.0, atol=1e-4)  # LOOSE_SPRING, 0.1 mm


def test_meshes_choose_the_contact():
    """One patch on meshes more than twice as coarse as the half-width, 0.24 mm; points below."""
    for size, spreads in ((0.6, False), (0.4, True)):
        model = model_of(rolling_scene("subgrid", 0.0, size, 1.0))
        assert isinstance(model, SpreadModel) == spreads


@kernel
def _spread_forces(points, spread, row, j):
    return spread_forces(points, spread, row, j)


def test_points_in_contact_are_found_as_by_another_method():
    """Against non-negative least squares of the factored problem (Lawson and Hanson), also where a wave parts them."""
    laws = spread_model(2.5e-4).laws
    some = points(laws, LOAD, 5)
    x = np.linspace(-1.0, 1.0, some.closing.size)
    full = toeplitz(laws[0].missing_compliance)
    root = np.linalg.cholesky(full)
    for shape in (0.1 - x**2, 0.05 - x**2 + 0.02 * x, 0.25 * np.cos(12.0 * x) - 2.0 * x**2, -1.0 - x**2):
        some.closing[:] = 1e-6 * shape
        energy = _spread_forces(some, some.spread, 0, 0)
        wanted, _ = nnls(root.T, np.linalg.solve(root, some.closing))
        np.testing.assert_allclose(some.force, wanted, rtol=0.0, atol=1e-7 * max(wanted.max(), 1e-9))
        assert energy == pytest.approx(0.5 * wanted @ full @ wanted, rel=1e-6, abs=1e-15)


def test_a_contact_wider_than_its_points_is_not_a_number():
    laws = (spread_model(2.5e-4).inner_law,) * 3
    some = points(laws, LOAD, 5)
    some.closing[:] = 1e-5
    _spread_forces(some, some.spread, 0, 0)
    assert np.isnan(some.force).any()


# dynamics -------------------------------------------------------------------------------------------------------


def advanced(state, n_samples, stride):
    """Samples of a run, finite or not."""
    samples = np.zeros((n_samples, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
    advance(*loop_arguments(state), 0, stride, samples)
    return samples


compiles = pytest.mark.slow  # a time loop of its own
both_kinds = pytest.mark.parametrize(
    "make", [lambda: resolved_model(five(), 1.2e-4), lambda: spread_model(2.5e-4)], ids=["resolved", "spread"]
)


@compiles
@both_kinds
def test_the_start_stands_still(make):
    """Forces of the time loop at t = 0 are those of the equilibrium; nothing pushes the hub."""
    model, how = make(), operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    dt = 0.9 * critical_time_step(model, LOAD)
    state, wanted = copies(arrays(model, how, dt)), solved(model, LOAD, how.first_roller_angle)
    press_contacts(state)
    found = state.contacts.forces.force[:2, :5]
    np.testing.assert_allclose(found, [wanted.inner_force, wanted.outer_force], rtol=0.0, atol=1e-6 * LOAD)
    acceleration = advanced(copies(arrays(model, how, dt)), 1, 1)[0, [HUB_AX, HUB_AY]]
    assert np.abs(acceleration).max() * how.inner_mass < 1e-3 * LOAD


def rolling_scene(model, friction, mesh_size, duration, **operation):
    return parse_scene(
        {
            "bearing": {"rollers": 5},
            "material": {"youngs_modulus_GPa": 5.0},
            "operation": {"radial_load_N": LOAD, "speed_rpm": 3000.0, **operation},
            "contact": {"model": model, "friction_coefficient": friction},
            "numerics": {"mesh_size_mm": mesh_size, "duration_ms": duration, "output_interval_us": 5.0},
        },
        "test",
    )


LIGHT_HUB = {"gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 0.3}


@compiles
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_resolved_run_balances_its_energy(friction):
    plan = make_plan(rolling_scene("resolved", friction, 0.12, 0.2))
    check_meshes(plan.model)
    found = whole_run(plan)
    assert abs(found.relative_error()[-1]) < 2e-4
    force = found["inner_force"]
    assert np.all(np.isfinite(force)) and force.max() < 1.1 * LOAD


@compiles
@pytest.mark.parametrize(("friction", "most"), [(0.0, 1e-5), (0.1, 2e-4)])
def test_a_run_with_spread_points_balances_its_energy(friction, most):
    """Forces are the gradient of one potential, and what opens and closes gives back what it took."""
    found = run(make_plan(rolling_scene("subgrid", friction, 0.3, 3.0, **LIGHT_HUB)), lambda samples: None)
    assert abs(found.imbalance) < most


@compiles
@pytest.mark.parametrize(
    ("one", "other", "duration", "operation", "most"),
    [
        (("resolved", 0.08), ("subgrid", 1.0), 0.2, {"speed_rpm": 3000.0}, 2e-2),
        (("subgrid", 0.25), ("subgrid", 0.8), 0.5, LIGHT_HUB, 5e-3),  # points and one patch
    ],
)
def test_contact_models_give_the_same_run(one, other, duration, operation, most):
    found = [
        whole_run(make_plan(rolling_scene(model, 0.1, size, duration, **operation))) for model, size in (one, other)
    ]
    hubs = np.array([[run["inner_x"], run["inner_y"]] for run in found])
    assert np.abs(hubs[0] - hubs[1]).max() < most * np.abs(hubs[1, 1]).mean()


@compiles
@both_kinds
def test_the_step_limit_is_on_its_safe_side_and_close(make):
    """Free vibration of a squeezed bearing from round-off: stable at 0.99 of the limit, gone well before 1.3 of it."""
    model, how = make(), operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    limit = critical_time_step(model, LOAD)

    def grown(share):
        path = advanced(copies(arrays(model, how, share * limit)), 12, 100)[:, 1:3]
        return not np.all(np.isfinite(path)) or np.abs(path - path[0]).max() > 1e-3 * np.abs(path[0]).max()

    assert not grown(0.99)
    assert grown(1.3)

"""Analytic fields below a contact: against McEwen's formulas and against Flamant's solution summed up numerically."""

import numpy as np
import pytest

from fem.pictures.stress_below import AT_DEPTH, LARGEST_SHEAR, SurfaceLoad, hertz_stress, spline_displacement
from lagrange import Material
from tests.reference.half_plane import cubic_bspline, flamant, mcewen

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
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

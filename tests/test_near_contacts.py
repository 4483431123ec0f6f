"""Stress below the contacts of a coarse mesh: against theory, an exact field and a resolved model."""

from dataclasses import replace

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.contacts.resolved import SpreadModel
from fem.elastic.bodies import max_shear
from fem.pictures.bodies import drawn_bearing
from fem.pictures.closeup import shear_peak
from fem.pictures.recover import read_instant
from fem.pictures.stress_below import FIRST_ROLLER, INNER_RING, OUTER_RING
from tests.reference.half_plane import mcewen
from tests.reference.resolved_roller import resolved_disc

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

"""An outer ring held at points: the free ring's modes, the pinched ring, reactions, statics, and runs in time."""

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.contacts.points import patch
from fem.elastic.outer_support import FEWEST, supported_ring
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan
from lagrange.errors import UsageError
from lagrange.mounting import Points
from lagrange.scene.scene import parse_scene, parse_scene_text
from tests.reference.bearings import LENGTH, STEEL
from tests.reference.free_vibration import ring_frequency
from tests.reference.half_plane import cubic_bspline_patch
from tests.reference.outer_ring import FINE, INNER, OUTER, free_modes, outer_ring, pinched, thin_ring
from tests.reference.refusals import assert_refused
from tests.reference.whole_run import whole_run

SIDES = Points(angles=(0.0, np.pi), width=2e-3)


@pytest.mark.parametrize(("order", "thin"), [(2, 3287.0), (3, 9297.0), (4, 17827.0)])
def test_the_free_ring_vibrates_at_the_exact_frequencies(order, thin):
    """Within 0.2 % of the exact equation with sixteen layers; the thin ring's formula is some per cent high."""
    assert thin_ring(order) == pytest.approx(thin, rel=1e-3)
    bounds = 2.0 * np.pi * thin * np.array([0.85, 1.02])
    exact = ring_frequency(order, INNER, OUTER, *bounds, STEEL) / (2.0 * np.pi)
    assert 1.005 < thin / exact < 1.12
    assert free_modes(outer_ring(FINE), order)[0] == pytest.approx(exact, rel=2e-3)


def test_the_ring_pinched_at_two_points_is_the_exact_one():
    """Its oval shape between two opposite forces, within 0.3 % of the exact ring; a thin one: 215.8 and 235.0 µm/kN."""
    body = outer_ring(FINE)
    force = np.zeros((body.n_rows, 2, body.n_sectors))
    for angle in (0.0, np.pi):
        nodes, weight, offset = patch(body.n_sectors, angle)
        force[-1, 0, nodes] -= weight * np.cos(offset)
        force[-1, 1, nodes] -= weight * np.sin(offset)
    spacing = 2.0 * np.pi * OUTER / body.n_sectors
    orders = np.arange(2, 141, 2)
    series = pinched(orders, 2.0 * spacing)
    across = 2.0 * (series * np.cos(0.5 * np.pi * orders)).sum() / LENGTH
    along = 2.0 * (series * cubic_bspline_patch(orders, 2.0 * spacing, OUTER)).sum() / LENGTH
    moved = bent(body, force)
    quarter = body.n_sectors // 4
    assert across == pytest.approx(215.8e-9, rel=0.03) and along == pytest.approx(-235.0e-9, rel=0.06)
    assert moved[-1, 0, quarter] + moved[-1, 0, 3 * quarter] == pytest.approx(across, rel=3e-3)
    assert -np.vdot(force, moved) == pytest.approx(along, rel=3e-3)


def bent(body, force: np.ndarray) -> np.ndarray:
    """Displacement of the ring held nowhere, (n_rows, 2, n_sectors), m; even orders from 2 on."""
    spectrum = np.fft.rfft(force, axis=2)
    solved = np.zeros_like(spectrum)
    for n in range(2, spectrum.shape[2], 2):
        column = np.linalg.solve(body.harmonic_stiffness(np.array([n]))[0], spectrum[:, :, n].reshape(-1))
        solved[:, :, n] = column.reshape(-1, 2)
    return np.fft.irfft(solved, n=body.n_sectors, axis=2)


def test_supports_carry_what_is_put_on_the_ring():
    body = supported_ring(outer_ring(3), Points(angles=(0.5 * np.pi, 3.6, 5.8), width=6e-3))
    rng = np.random.default_rng(3)
    force = rng.standard_normal((body.n_rows, 2, body.n_sectors, 2))
    moved = body.held(force)
    assert np.abs(moved[-1][:, body.held_sectors]).max() == 0.0 and np.abs(moved).max() > 0.0
    for k in range(2):
        left = body.force(moved[..., k]) - force[..., k]
        carried = left[-1][:, body.held_sectors].copy()
        left[-1][:, body.held_sectors] = 0.0
        assert np.abs(left).max() < 1e-9 * np.abs(force).max() * 100
        resultant = (body.cartesian(force[..., k]) + body.cartesian(_only(body, carried))).sum(axis=0)
        np.testing.assert_allclose(resultant, 0.0, atol=1e-8)


def _only(body, carried):
    force = np.zeros((body.n_rows, 2, body.n_sectors))
    force[-1][:, body.held_sectors] = carried
    return force


def test_nodes_within_the_width_are_held_and_two_of_each_point_at_least():
    body = outer_ring(3)
    spacing = 2.0 * np.pi * OUTER / body.n_sectors
    narrow = supported_ring(body, Points(angles=(1.0, 4.0), width=1e-6))
    assert len(narrow.held_sectors) == 2 * FEWEST
    wide = supported_ring(body, Points(angles=(0.0,), width=10.0 * spacing))
    assert len(wide.held_sectors) == 11 and 0 in wide.held_sectors
    assert narrow.n_free_nodes == body.n_rows * body.n_sectors - 4
    ends = supported_ring(body, Points(angles=(0.0,), width=2.0 * np.pi * OUTER))
    np.testing.assert_allclose(
        ends.held(np.ones((4, 2, body.n_sectors))), body.held(np.ones((4, 2, body.n_sectors))), atol=1e-20
    )


def told_of(capsys, *settings: str) -> str:
    """What --dry-run says of the paper's bearing held at three points."""
    points = ["support.kind=points", "numerics.duration_ms=0", *settings]
    assert run_main(["--dry-run", *(part for each in points for part in ("--set", each))]) == 0
    told = capsys.readouterr()
    return " ".join((told.out + told.err).replace("│", " ").split())


def test_widths_that_the_mesh_holds_are_shown_and_warned_of_where_they_are_not_those_asked_for(capsys):
    """176 edges around 65 mm are 1.160 mm long: five nodes hold 5.80 mm. 56 are 3.646 mm long: two hold 7.29 mm."""
    edge = np.pi * 65.0 / 176
    fine = told_of(capsys, "numerics.mesh_size_mm=1")
    assert f"over {5 * edge:.3g}, {5 * edge:.3g}, {5 * edge:.3g} mm" in fine and "width_mm = 6:" not in fine
    coarse = told_of(capsys, "numerics.mesh_size_mm=3")
    assert "support.width_mm = 6: the mesh holds the outer ring over 7.29, 7.29, 7.29 mm" in coarse
    narrow = told_of(capsys, "numerics.mesh_size_mm=2", "support.width_mm=0.1")
    assert "the mesh holds the outer ring over 4.64, 4.64, 4.64 mm, from nodes 2.32 mm apart" in narrow


def test_influence_of_surface_nodes_is_that_of_unit_forces():
    body = supported_ring(outer_ring(3), SIDES)
    nodes = np.array([5, 40])
    found = body.surface_influence(nodes)
    force = np.zeros((body.n_rows, 2, body.n_sectors))
    force[body.raceway_row, 1, 40] = 1.0
    moved = body.held(force)[body.raceway_row][:, nodes]
    np.testing.assert_allclose(found[:, 3], moved.T.ravel(), rtol=1e-12)
    np.testing.assert_allclose(found, found.T, rtol=1e-9)


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"support": {"kind": "points", "angles_deg": []}}, ["support.angles_deg"]),
        ({"support": {"kind": "points", "angles_deg": [400.0]}}, ["angles_deg", "-360 and 360"]),
        ({"support": {"kind": "points", "width_mm": 0.0}}, ["support.width_mm"]),
        ({"support": {"kind": "points", "mass_kg": 1.0}}, ['mass_kg = 1.0: only with kind = "housing", not "points"']),
        ({"support": {"kind": "housing", "width_mm": 1.0}}, ['width_mm = 1.0: only with kind = "points"']),
        ({"support": {"kind": "points"}, "model": "lagrange"}, ['support.kind = "points"', '"lagrange"']),
        ({"support": {"kind": "points"}, "bodies": {"outer_ring": "rigid"}}, ["rigid outer ring"]),
        ({"support": {"kind": "points"}, "contact": {"model": "resolved"}}, ['"resolved"']),
        ({"support": {"kind": "points"}, "sensor": {}}, ["[sensor]"]),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(tables, words):
    assert_refused(tables, *words)


def test_points_survive_as_text():
    scene = parse_scene({"support": {"kind": "points", "angles_deg": [0.0, 90.0]}}, "")
    assert parse_scene_text(scene.to_toml(), "") == scene
    assert scene.mounting().points.angles == pytest.approx((-0.5 * np.pi, 0.0))


def test_a_mesh_for_spread_contacts_refuses_points():
    tables = {"support": {"kind": "points"}, "numerics": {"mesh_size_mm": 0.05}}
    with pytest.raises(UsageError, match=r"support\.kind.*mesh_size_mm = 0\.05"):
        model_of(parse_scene(tables, ""))


@pytest.mark.slow
def test_a_run_held_at_three_points_keeps_its_energy_and_its_points():
    """Balanced as well as one held all around; the ring is oval, its held nodes stand."""
    tables = {
        "support": {"kind": "points", "angles_deg": [180.0, 60.0, 300.0]},
        "numerics": {"mesh_size_mm": 2.0, "duration_ms": 2.0},
    }
    plan = make_plan(parse_scene(tables, ""))
    state = plan.first_state()
    found = whole_run(plan, state)
    assert np.abs(found.relative_error()).max() < 1e-6
    ring_now = state.frame().outer_ring
    assert np.abs(ring_now[-1][:, plan.model.outer_ring.held_sectors]).max() < 1e-18
    assert np.abs(ring_now[-1]).max() > 1e-6
    assert found["inner_y"].mean() == pytest.approx(-7.5e-6, abs=0.5e-6)  # docs/paper.md, statics

"""Figures that only some runs have: what they tell, and that they are left out elsewhere."""

import pytest

from lagrange.scene.scene import parse_scene
from residual.evaluation import evaluate
from residual.figures.comparison import point_contact
from residual.figures.saved import TERM_COLOURS
from residual.figures.spectra import envelope_figure, short_time_figure
from residual.report import render_report
from residual.summary import ReportOptions
from tests.reference.synthetic_run import make_run, recorded

# the 209 bearing of Harris' examples
BALLS = {
    "type": "ball", "rollers": 9, "roller_diameter_mm": 12.7, "inner_raceway_diameter_mm": 52.291,
    "outer_raceway_diameter_mm": 77.706, "bore_diameter_mm": 45.0, "outside_diameter_mm": 85.0,
    "outer_conformity": 0.52,
}  # fmt: skip


@pytest.fixture(scope="module")
def ball_run(tmp_path_factory):
    scene = parse_scene({"bearing": BALLS, "operation": {"inner_ring_and_shaft_kg": 0.5}}, "test")
    path = tmp_path_factory.mktemp("balls") / "balls.nc"
    return evaluate(recorded(path, make_run(n_times=1201, scene=scene)))


def test_figure_4_marks_the_bearings_own_contacts(ball_run, tmp_path):
    """Harris: F = 0.940 and 0.912, Σρ = 0.202 and 0.138 mm⁻¹."""
    drawn = point_contact(ball_run.record.bearing, tmp_path)
    assert drawn.png.stat().st_size > 10_000 and drawn.svg.exists()
    for words in ("inner raceway Σρ = 0.2018", "F = 0.9400", "outer raceway Σρ = 0.1378", "F = 0.9121"):
        assert words in drawn.caption
    assert "9 balls Ø 12.7 mm" in render_report(ball_run, {"paper": [drawn]}, ReportOptions(), "0")


def test_short_time_spectra_need_two_passages(ball_run, tmp_path):
    drawn = short_time_figure(ball_run, tmp_path)
    assert drawn.png.stat().st_size > 10_000
    assert "half a roller passage" in drawn.caption
    short = make_run(n_times=401)
    assert short_time_figure(evaluate(recorded(tmp_path / "a.nc", short)), tmp_path) is None


def test_envelope_of_a_record_shorter_than_a_passage(tmp_path):
    scene = parse_scene({"operation": {"speed_rpm": 5.0}}, "test")
    drawn = envelope_figure(evaluate(recorded(tmp_path / "slow.nc", make_run(n_times=1201, scene=scene))), tmp_path)
    assert drawn.png.stat().st_size > 10_000
    assert {len(curve.points) for curve in drawn.curves} == {20}


def test_terms_that_may_stand_in_one_figure_have_colours_of_their_own():
    colours = {name: colour for name, colour in TERM_COLOURS.items() if name != "other_forces"}  # in another's place
    assert len(set(colours.values())) == len(colours)

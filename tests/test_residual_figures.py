"""Figures that only some runs have: what they tell, and that they are left out elsewhere."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from lagrange.scene.scene import parse_scene
from residual.check_vibration import main as check_vibration
from residual.evaluation import evaluate
from residual.figures import measured, style
from residual.figures.saved import TERM_COLOURS
from residual.figures.spectra import envelope_figure, short_time_figure
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


def test_short_time_spectra_need_two_passages(ball_run, tmp_path):
    drawn = short_time_figure(ball_run, tmp_path)
    assert drawn.png.stat().st_size > 10_000
    assert "half a roller passage" in drawn.caption
    short = make_run(n_times=401)
    assert short_time_figure(evaluate(recorded(tmp_path / "a.nc", short)), tmp_path) is None


def test_envelope_of_a_record_shorter_than_a_passage(tmp_path, monkeypatch):
    scene = parse_scene({"operation": {"speed_rpm": 5.0}}, "test")
    monkeypatch.setattr(f"{envelope_figure.__module__}.save", lambda figure, *_: figure)
    drawn = envelope_figure(evaluate(recorded(tmp_path / "slow.nc", make_run(n_times=1201, scene=scene))), tmp_path)
    assert {len(axis.lines[0].get_xdata()) for axis in drawn.axes} == {20}


def test_terms_that_may_stand_in_one_figure_have_colours_of_their_own():
    colours = {name: colour for name, colour in TERM_COLOURS.items() if name != "other_forces"}  # in another's place
    assert len(set(colours.values())) == len(colours)


def drawn_texts(figure):
    """Boxes of a figure's texts but those of ticks, pixels, and the figure's."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    texts = [text for axis in figure.axes for text in (*axis.texts, axis.xaxis.label, axis.yaxis.label)]
    texts += [text for axis in figure.axes if axis.get_legend() for text in axis.get_legend().get_texts()]
    return [text.get_window_extent(renderer) for text in texts if text.get_text()], figure.bbox


def test_a_legend_of_many_terms_is_in_its_figure_and_panels_stay_where_they_are(tmp_path):
    figure, axes = style.panels(2, 5.6, x="time, ms", y=["terms, N", "others, N"])
    before = axes[1].get_position().height * 5.6
    for name in TERM_COLOURS:
        axes[0].plot([0.0, 1.0, 2.0], [1.0, 2.0, 1.0], label=name.replace("_", " "))
    style.legend_above(axes[0], 5, left=-0.08)
    style.save(figure, tmp_path, "many", "Many", "")
    boxes, whole = drawn_texts(figure)
    assert len(boxes) == len(TERM_COLOURS) + 3
    assert all(whole.x0 <= b.x0 and whole.y0 <= b.y0 and b.x1 <= whole.x1 and b.y1 <= whole.y1 for b in boxes)
    assert axes[1].get_position().height * figure.get_size_inches()[1] == pytest.approx(before)


def test_names_of_near_lines_do_not_cover_each_other(tmp_path):
    figure, (axis,) = style.panels(1, 3.0, x="frequency, Hz")
    axis.set(xlim=(0.0, 500.0), ylim=(0.0, 1.0))
    style.name_lines(axis, [(f, name, "black") for f, name in ((153.0, "BPFO"), (149.0, "2×BSF"), (499.0, "3×BPFO"))])
    boxes, whole = drawn_texts(figure)
    names = boxes[:3]
    assert not any(a.overlaps(b) for k, a in enumerate(names) for b in names[:k])
    assert all(b.x1 <= whole.x1 for b in names)


def test_two_records_beside_each_other_share_their_ordinate(tmp_path, monkeypatch):
    kept, save = [], measured.save
    monkeypatch.setattr(measured, "save", lambda figure, *rest: (kept.append(figure), save(figure, *rest))[1])
    time = np.arange(20_000) / 20_000.0
    for name, depth in (("deep", 0.9), ("faint", 0.1)):
        swell = 1.0 + depth * np.cos(2.0 * np.pi * 124.0 * time)
        noise = np.random.default_rng(1).standard_normal(time.size)
        np.savez(tmp_path / f"{name}.npz", acc=swell * noise, rate=20_000.0)
    options = ["--bearing", "NU206", "--speed", "1480", "--against", str(tmp_path / "faint.npz"), "--quiet"]
    assert check_vibration([str(tmp_path / "deep.npz"), *options]) == 0
    upper, lower = (axis.get_ylim() for axis in kept[0].axes)
    assert upper == lower

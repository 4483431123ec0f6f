"""Figures that only some runs have: what they tell, and that they are left out elsewhere."""

import json
from dataclasses import replace

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from fem.commands.run_fem import run_main
from lagrange.scene.scene import parse_scene_text
from residual import figures as style
from residual.check_vibration import main as check_vibration
from residual.evaluation import evaluate
from residual.figures import make_plain, plain
from residual.formatting import TERM_COLOURS
from residual.sources import read_result
from tests.reference.kit import sets


def drawn_texts(figure):
    """Boxes of a figure's texts but those of ticks, pixels, and the figure's."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    texts = [text for axis in figure.axes for text in (*axis.texts, axis.xaxis.label, axis.yaxis.label)]
    texts += [text for axis in figure.axes if axis.get_legend() for text in axis.get_legend().get_texts()]
    return [text.get_window_extent(renderer) for text in texts if text.get_text()], figure.bbox


def test_a_legend_of_many_terms_and_names_of_near_lines_have_room_and_panels_stay_where_they_are(tmp_path):
    figure, axes = style.panels(2, 5.6, x="time, ms", y=["terms, N", "others, N"])
    before = axes[1].get_position().height * 5.6
    for name in TERM_COLOURS:
        axes[0].plot([0.0, 1.0, 2.0], [1.0, 2.0, 1.0], label=name.replace("_", " "))
    style.legend_above(axes[0], 5, left=-0.08)
    style.save(style.Drawing("many", "Many", "", figure), tmp_path)
    boxes, whole = drawn_texts(figure)
    colours = {name: colour for name, colour in TERM_COLOURS.items() if name != "other_forces"}  # in another's place
    assert len(set(colours.values())) == len(colours), "terms that may stand in one figure have colours of their own"
    assert len(boxes) == len(TERM_COLOURS) + 3
    assert all(whole.x0 <= b.x0 and whole.y0 <= b.y0 and b.x1 <= whole.x1 and b.y1 <= whole.y1 for b in boxes)
    assert axes[1].get_position().height * figure.get_size_inches()[1] == pytest.approx(before)
    # names of near lines do not cover each other
    figure, (axis,) = style.panels(1, 3.0, x="frequency, Hz")
    axis.set(xlim=(0.0, 500.0), ylim=(0.0, 1.0))
    style.name_lines(axis, [(f, name, "black") for f, name in ((153.0, "BPFO"), (149.0, "2×BSF"), (499.0, "3×BPFO"))])
    (*names, _), whole = drawn_texts(figure)
    assert not any(a.overlaps(b) for k, a in enumerate(names) for b in names[:k])
    assert all(b.x1 <= whole.x1 for b in names)


def test_two_records_beside_each_other_share_their_ordinate(tmp_path, monkeypatch):
    kept, save = [], style.save
    monkeypatch.setattr(style, "save", lambda drawing, to: (kept.append(drawing.figure), save(drawing, to))[1])
    time = np.arange(20_000) / 20_000.0
    for name, depth in (("deep", 0.9), ("faint", 0.1)):
        swell = 1.0 + depth * np.cos(2.0 * np.pi * 124.0 * time)
        noise = np.random.default_rng(1).standard_normal(time.size)
        np.savez(tmp_path / f"{name}.npz", acc=swell * noise, rate=20_000.0)
    options = ["--bearing", "NU206", "--speed", "1480", "--against", str(tmp_path / "faint.npz"), "--quiet"]
    assert check_vibration([str(tmp_path / "deep.npz"), *options]) == 0
    upper, lower = (axis.get_ylim() for axis in kept[0].axes)
    assert upper == lower


SURFACES = {
    "outer ring": "[[spall]]\nangle_deg = 1.5\nwidth_mm = 0.4\n",
    "inner ring": '[[spall]]\nbody = "inner_ring"\nangle_deg = -8\nwidth_mm = 0.4\ndepth_um = 2\n',
    "roller": '[[spall]]\nbody = "roller"\nroller = 0\nangle_deg = 120\nwidth_mm = 0.4\n',
    "waves": "[[waviness]]\norder = 12\n\n[[unequal_roller]]\nroller = 1\n",
}  # fmt: skip
RUN = 'model = "lagrange"\n[numerics]\nduration_ms = 1.0\noutput_interval_us = 1.0\n'


@pytest.mark.parametrize("name", SURFACES)
def test_the_equations_know_the_surfaces(name, tmp_path):
    """In the solution of the same equations what is left is the differentiation's; on circles the fault is left.

    The outer raceway's sinkage is in the rollers' equations, not in the hub's, which are checked here.
    """
    path, scene = tmp_path / "run.nc", tmp_path / "scene.toml"
    scene.write_text(RUN + SURFACES[name], encoding="utf-8")
    assert run_main([str(scene), "--output", str(path), "--quiet"]) == 0
    record = read_result(path)
    plain = replace(record, scene=parse_scene_text(RUN, "plain"), roller_turn=None)
    known, unknown = evaluate(record), evaluate(plain)
    right, wrong = (np.abs(found.budget.y.terms["contact_law"]).max() for found in (known, unknown))
    assert right < 1e-6 and (wrong < 1e-6 if name == "outer ring" else wrong > 20.0)
    # where a roller is released or strikes the stencils have a kink
    assert np.median(np.abs(known.y.budget.error)) < 0.5


def test_rollers_are_where_their_own_spin_has_brought_them_and_a_result_file_tells_its_faults(tmp_path):
    path, same = tmp_path / "run.nc", ["--output", str(tmp_path / "run.nc"), "--quiet", "--set", "model=lagrange"]
    faults = "spall.0.body=roller", "spall.0.roller=3", "spall.0.width_mm=2", "unequal_roller.0.roller=3"
    assert run_main([*same, *sets("numerics.duration_ms=1", *faults)]) == 0
    record = read_result(path)
    with h5py.File(path) as file:
        spin = file["roller_spin"][0, 0]
        spall, unequal = json.loads(file.attrs["faults"])
    np.testing.assert_allclose(record.roller_turn, np.repeat(spin * record.time[:, None], 13, axis=1), atol=1e-12)
    assert (spall["kind"], spall["body"], spall["width"]) == ("spall", "roller", 2e-3)
    assert (unequal["kind"], unequal["roller"], unequal["diameter_deviation"]) == ("unequal_roller", 3, 1e-6)
    assert run_main([*same, "--duration", "0", "--force"]) == 0
    with h5py.File(path) as file:
        assert "faults" not in file.attrs


LABELS = {
    r"$\mathdefault{10^{-3}}$": "10⁻³", r"$\mathdefault{10^{12}}$": "10¹²", "1e−5": "×10⁻⁵", "1e6": "×10⁶", "": "",
    r"$\mathdefault{2\times10^{-3}}$": "2×10⁻³", "0.25": "0.25",
}  # fmt: skip


def test_powers_of_ten_are_raised_figures_and_no_label_of_a_figure_needs_mathematics():
    assert {label: plain(label) for label in LABELS} == LABELS
    figure, (left, right) = plt.subplots(1, 2)
    left.loglog([1e-9, 2e3], [3e-7, 5e2])
    right.plot([0.0, 1.0], [0.0, 3e-7])
    make_plain(figure)
    figure.draw_without_rendering()
    labels = [text.get_text() for axes in (left, right) for text in (*axes.get_xticklabels(), *axes.get_yticklabels())]
    labels.append(right.yaxis.get_offset_text().get_text())
    plt.close(figure)
    assert not any(mark in label for label in labels for mark in "$^\\") and "10⁻⁷" in labels[-1] and "10³" in labels

"""The report's figure of a spall: passages laid over each other."""

import re
from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.runner import RunOptions, run_scene
from lagrange.scene.scene import read_scene
from residual.evaluation import evaluate
from residual.figures.passages import passage_figures
from residual.sources import read_result

SETTINGS = ("model=lagrange", "numerics.duration_ms=0.45", "numerics.output_interval_us=2", "spall.0.width_mm=0.5")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """One roller passes a spall in the load zone, none another one."""
    found = tmp_path_factory.mktemp("passages") / "run.nc"
    scene = read_scene(None, (*SETTINGS, "spall.0.angle_deg=2", "spall.1.angle_deg=180.0"))
    run_scene(scene, found, RunOptions(quiet=True))
    return found


@pytest.fixture(scope="module")
def evaluation(path):
    return evaluate(read_result(path))


def test_the_figure_tells_the_strikes_of_the_result_file(path, evaluation, tmp_path):
    figures = passage_figures(evaluation, tmp_path)
    assert [figure.name for figure in figures] == ["passages_0"]
    caption = figures[0].caption
    force, share = re.search(r"medians are (\d+) N and (0\.\d+) of the crossing", caption).groups()
    with h5py.File(path) as file:
        events = {name: file["events"][name][:] for name in ("kind", "spall", "force", "time")}
    kinds = {kind: (events["kind"] == kind) & (events["spall"] == 0) for kind in (b"entry", b"strike", b"exit")}
    assert kinds[b"strike"].sum() == 1
    entry, strike, leaving = (events["time"][kinds[kind]] for kind in kinds)
    assert float(force) == pytest.approx(np.median(events["force"][kinds[b"strike"]]), abs=0.51)
    assert float(share) == pytest.approx(np.median((strike - entry) / (leaving - entry)), abs=0.01)
    assert "0.5 mm wide spall on the outer ring" in caption and "0.512° away" in caption
    assert figures[0].png.stat().st_size > 10_000 and figures[0].svg.exists()


def test_without_spalls_or_forces_there_is_none(evaluation, tmp_path):
    perfect = replace(evaluation, record=replace(evaluation.record, scene=read_scene(None, SETTINGS[:3])))
    assert passage_figures(perfect, tmp_path) == []
    untold = replace(evaluation, record=replace(evaluation.record, inner_force=None))
    assert passage_figures(untold, tmp_path) == []

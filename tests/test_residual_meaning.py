"""What the report says of the Lagrangian model, the statics it compares with, error estimates, the picture."""

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from lagrange.files.pages import render_page
from lagrange.scene.scene import parse_scene
from residual.evaluation import evaluate
from residual.interpretation import interpretation, verdict
from residual.load_zone import quasi_static
from residual.report import MOST_POINTS, TEMPLATE, page_of, picture_of, spectra_json
from residual.sources import read_result
from residual.summary import ReportOptions
from residual.tables import stated_error_table
from tests.reference.synthetic_run import make_run, recorded, run_variables, write_result


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run whose forces are the law's times 1.25: the law carries a fifth less than the run."""
    run = make_run(n_times=1201)
    path = tmp_path_factory.mktemp("made") / "made.nc"
    return recorded(path, run, run_variables(run, force_factor=1.25))


def test_statics_are_those_of_rigid_rings_on_harris_law(made):
    """629.7 N under the load, 607.0 N where it falls between two rollers; approach 4.11 µm; 14 and 120 nm of varying
    compliance: computed independently of this package with Harris' law and rigid rings, without the rollers' mass.
    """
    found = quasi_static(made, "harris")
    assert found.force.max() == pytest.approx(629.7, abs=1.5)
    assert found.force[np.abs(found.angle) < 1e-6] == pytest.approx(629.7, abs=1.5)
    assert np.interp(np.pi / 13, found.angle, found.force) == pytest.approx(607.0, abs=1.5)
    assert -1e6 * found.y.mean() == pytest.approx(4.12, abs=0.03)
    assert 1e9 * np.ptp(found.y) == pytest.approx(14.0, abs=1.0)
    assert 1e9 * np.ptp(found.x) == pytest.approx(120.0, abs=5.0)
    assert found.x[-1] == pytest.approx(found.x[0], abs=1e-12)  # one pitch further the bearing is the same


def test_a_law_fitted_to_the_run_is_stood_in_for_by_the_usual_one(made):
    assert quasi_static(made, "fitted").law == "harris"


def test_the_sentences_say_how_much_of_the_load_the_law_carries(made):
    found = evaluate(made, law="iso16281")
    sentences = " ".join(interpretation(found, quasi_static(made, "harris")))
    share = 100.0 * found.y.error.mean / 2000.0
    assert abs(share) > 1.0
    direction = "less" if share > 0.0 else "more"
    assert f"gives {abs(share):.3g} % {direction} force than the load" in sentences
    assert "630.8 N on the most loaded roller" in sentences
    best = found.laws[0]
    assert f"{best.name} has the smallest error" in sentences


def test_without_forces_the_sentences_blame_nobody(tmp_path):
    run = make_run(n_times=401)
    bare = {name: value for name, value in run_variables(run).items() if "force" not in name and "traction" not in name}
    found = evaluate(recorded(tmp_path / "bare.nc", run, bare))
    sentences = interpretation(found, None)
    assert "without contact forces" in verdict(found).lower()
    assert not any("leaves out" in sentence for sentence in sentences)


def test_an_unloaded_bearing_gets_no_share_of_its_load(tmp_path):
    run = make_run(n_times=401, scene=parse_scene({"operation": {"radial_load_N": 0.0}}, "test"))
    found = evaluate(recorded(tmp_path / "idle.nc", run))
    assert not any("% less" in sentence or "% more" in sentence for sentence in interpretation(found, None))


def test_the_pages_spectra_are_those_of_the_evaluation(made):
    found = evaluate(made)
    data = json.loads(spectra_json(found))
    assert data["frequency"] == pytest.approx(found.x.spectrum.frequency[1:], rel=1e-6)
    assert data["x"] == pytest.approx(found.x.spectrum.psd[1:], rel=1e-3, abs=1e-15 * found.x.spectrum.psd.max())
    named = {line["name"]: line["frequency"] for line in data["lines"]}
    assert named["BPFO"] == pytest.approx(found.lines["BPFO"], rel=1e-6)


def test_of_a_long_record_every_peak_is_kept(tmp_path):
    run = make_run(n_times=40_001, tone=9_000.0)
    found = evaluate(recorded(tmp_path / "long.nc", run))
    directions = {d.name: replace(d, spectrum=_one_segment(d.budget.error)) for d in found.directions}
    found = replace(found, **directions)
    data = json.loads(spectra_json(found))
    assert len(data["frequency"]) <= 2 * MOST_POINTS < len(found.x.spectrum.frequency)
    assert max(data["x"]) == pytest.approx(found.x.spectrum.psd.max(), rel=1e-3)
    top = data["x"].index(max(data["x"]))
    assert data["frequency"][top] == pytest.approx(9_000.0, abs=3.0)


def _one_segment(record):
    from residual.spectrum import power_spectrum

    return power_spectrum(record, 1e-5)


def test_error_estimates_of_the_run_are_told(tmp_path):
    run = make_run(n_times=401)
    path = write_result(tmp_path / "made.nc", run)
    with h5py.File(path, "r+") as file:
        file["quantity_meaning"] = ["static displacement of the hub"]
        file["quantity_unit"] = ["m"]  # as run-fem writes it
        file["quantity_value"], file["quantity_error"] = [3.6156e-6], [0.0018e-6]
    found = evaluate(read_result(path))
    assert stated_error_table(found).rows == [["static displacement of the hub", "3.6156 µm", "0.0018 µm", "0.05 %"]]
    page = render_page(TEMPLATE, version="0", figures={}, **page_of(found, ReportOptions()))
    assert "Discretisation error" in page and "0.0018 µm" in page
    plain = page_of(evaluate(read_result(write_result(tmp_path / "plain.nc", run))), ReportOptions())
    assert "Discretisation error" not in render_page(TEMPLATE, version="0", figures={}, **plain)


def _png(path, source):
    about = PngInfo()
    if source:
        about.add_itxt("Source", source)
        about.add_itxt("Description", "Von Mises stress.")
    Image.new("RGB", (40, 30)).save(path, pnginfo=about)


def test_only_a_picture_of_this_very_run_is_shown(tmp_path):
    run = tmp_path / "run.nc"
    run.write_bytes(b"run")
    assert picture_of(run) is None
    _png(tmp_path / "run.png", None)
    assert picture_of(run) is None  # some picture
    _png(tmp_path / "run.png", "another.nc")
    assert picture_of(run) is None
    _png(tmp_path / "run.png", "run.nc")
    found = picture_of(run)
    assert found.caption == "Von Mises stress." and found.address.startswith("data:image/png;base64,")
    os.utime(tmp_path / "run.png", (1.0, 1.0))
    assert picture_of(run) is None  # of an earlier run of that name
    (tmp_path / "run.png").write_bytes(b"no picture")
    assert picture_of(run) is None


def test_render_fem_s_picture_is_shown(coarse_run, tmp_path):
    from fem.commands.render_fem import render_main

    run = Path(shutil.copy(coarse_run, tmp_path / "run.nc"))
    assert render_main([str(run), "--width", "300", "--time", "2"]) == 0
    shown = "Von Mises stress, the whole bearing at 2 ms; finite elements, no contact damping."
    assert picture_of(run).caption == shown

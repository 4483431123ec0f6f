"""check-residual as its users meet it: exit codes, messages, the report folder."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from residual.cli import main
from tests.reference.synthetic_run import exact_errors, make_run, run_variables, write_result, write_table
from tests.waiting import GIVE_UP, wait_until

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=401)


@pytest.fixture
def result(run, tmp_path):
    return write_result(tmp_path / "made.nc", run)


def scene_file(run, folder):
    path = folder / "scene.toml"
    path.write_text(run.scene.to_toml(), encoding="utf-8")
    return path


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.usefixtures("plain_report")
def test_table_with_a_known_residual_is_reproduced(tmp_path, capsys):
    run = make_run(n_times=6001, tone=3000.0, amplitude=2e-6)
    table = write_table(run, tmp_path / "table.csv")
    out = tmp_path / "report"
    assert main([str(table), "--scene", str(scene_file(run, tmp_path)), "--output", str(out)]) == 0
    found = summary_of(out)
    assert found["samples"] == 6001 and found["interval_s"] == pytest.approx(1e-5)
    for name, exact in zip(("x", "y"), exact_errors(run), strict=True):
        assert found[f"error_{name}"]["std_N"] == pytest.approx(exact.std(), rel=5e-3)
        assert found[f"error_{name}"]["mean_N"] == pytest.approx(exact.mean(), rel=5e-3)
        assert found[f"error_{name}"]["rms_N"] == pytest.approx(np.sqrt(np.mean(exact**2)), rel=5e-3)
        assert found[f"error_{name}"]["max_abs_N"] == pytest.approx(np.max(np.abs(exact)), rel=5e-3)
        assert found[f"peaks_{name}"][0]["frequency_Hz"] == pytest.approx(3000.0, rel=1e-3)
        assert found[f"peaks_{name}"][0]["line"] is None
    bpfo = [p for p in found["peaks_x"] if p["line"] == "BPFO"]
    assert bpfo and bpfo[0]["frequency_Hz"] == pytest.approx(381.52, rel=5e-3)
    assert "3000 Hz" in capsys.readouterr().out


def test_report_folder_is_complete(result, tmp_path, capsys):
    assert main([str(result)]) == 0
    folder = tmp_path / "made-residual"
    names = {p.name for p in folder.iterdir()}
    figures = (
        "history whole_spectra budget orbit "
        "load_distribution passage loads energy budget_stacked budget_spectra envelope hub_spectrum"
    )
    assert names == {"residual.nc", "summary.json", "report.html"} | {
        f"{figure}.{kind}" for figure in figures.split() for kind in ("png", "svg")
    }
    contract = {
        "run", "law", "samples", "interval_s", "start_s", "error_x", "error_y", "frequency_resolution_Hz",
        "peaks_x", "peaks_y", "loaded_rollers", "budget_x", "budget_y",
    }  # fmt: skip
    found = summary_of(folder)
    assert contract <= set(found)
    assert found["run"] == "made" and found["law"] == "harris" and found["samples"] == 401
    assert found["loaded_rollers"] == {"min": 6, "max": 7}
    assert sum(found["budget_mean_y"].values()) == pytest.approx(found["error_y"]["mean_N"], abs=1e-9)
    with h5py.File(folder / "residual.nc") as file:
        assert file["error_x"].attrs["units"] == "N"
        assert file["psd_y"].dims[0][0] == file["frequency"]
        assert np.std(file["error_y"]) == pytest.approx(found["error_y"]["std_N"], rel=1e-12)
        terms = sum(file[name][:] for name in file if name.startswith("budget_x_"))
        np.testing.assert_allclose(terms, file["error_x"][:], atol=2e-6)
    assert str(folder / "report.html") in capsys.readouterr().out.replace("\n", "")


@pytest.mark.usefixtures("plain_report")
def test_residual_file_opens_in_xarray_by_netcdf(result, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    assert main([str(result), "--quiet"]) == 0
    with xarray.open_dataset(tmp_path / "made-residual" / "residual.nc", engine="netcdf4", decode_times=False) as data:
        assert data["error_x"].dims == ("time",) and data["psd_x"].dims == ("frequency",)
        assert data["psd_x"].attrs["units"] == "N2 Hz-1"


def test_page_fetches_nothing_and_escapes_names(run, tmp_path):
    path = write_result(tmp_path / "a <b> & c.nc", run)
    assert main([str(path), "--quiet"]) == 0
    page = (tmp_path / "a <b> & c-residual" / "report.html").read_text(encoding="utf-8")
    assert "a &lt;b&gt; &amp; c" in page and "<b> &" not in page
    assert 'src="http' not in page and "<script src" not in page and "@import" not in page
    assert page.count("data:image/") == 12
    assert len(page) < 5_000_000


@pytest.mark.parametrize(("tolerance", "code", "word"), [("1e6", 0, "passes"), ("0.001", 1, "fails")])
@pytest.mark.usefixtures("plain_report")
def test_tolerance_gives_the_verdict(result, tmp_path, tolerance, code, word, capsys):
    assert main([str(result), "--tolerance", tolerance]) == code
    assert summary_of(tmp_path / "made-residual")["verdict"] == word
    assert word in capsys.readouterr().out.lower()


@pytest.mark.usefixtures("plain_report")
def test_newest_run_is_the_default(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    old = write_result(tmp_path / "runs" / "a.nc", run)
    write_result(tmp_path / "runs" / "b.nc", run)
    os.utime(old, (1, 1))
    assert main(["--quiet"]) == 0
    assert [p.name for p in (tmp_path / "runs").iterdir() if p.is_dir()] == ["b-residual"]


@pytest.mark.usefixtures("plain_report")
def test_quiet_prints_nothing(result, capfd):
    assert main([str(result), "--quiet"]) == 0
    assert capfd.readouterr() == ("", "")


@pytest.mark.usefixtures("plain_report")
def test_unfinished_run_is_used_up_to_its_committed_samples(run, tmp_path, capsys):
    variables = run_variables(run)
    variables["inner_x"] = variables["inner_x"].copy()
    variables["inner_x"][300:] = np.nan
    path = write_result(tmp_path / "cut.nc", run, variables, committed=300, status="failed: energy grows at step 7")
    assert main([str(path)]) == 0
    assert "warning" in (warned := capsys.readouterr().err) and "energy grows" in warned
    assert summary_of(tmp_path / "cut-residual")["samples"] == 300


@pytest.mark.usefixtures("plain_report")
def test_older_report_is_replaced_and_a_foreign_folder_is_not(result, tmp_path, capsys):
    folder = tmp_path / "made-residual"
    assert main([str(result), "--quiet"]) == 0
    (folder / "summary.json").write_text(json.dumps(summary_of(folder) | {"samples": -1}))
    assert main([str(result), "--quiet"]) == 0
    assert summary_of(folder)["samples"] == 401
    (folder / "thesis.docx").write_text("dear")
    assert main([str(result), "--quiet"]) == 2
    assert "thesis.docx" in capsys.readouterr().err
    other = tmp_path / "photos"
    other.mkdir()
    (other / "cat.jpg").write_text("meow")
    assert main([str(result), "--output", str(other)]) == 2
    assert [p.name for p in other.iterdir()] == ["cat.jpg"]
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


@pytest.mark.usefixtures("plain_report")
def test_failure_half_way_leaves_no_report(result, tmp_path, monkeypatch, capsys):
    from residual import store

    def full_disk(*_):
        raise OSError(28, "No space left on device", "residual.nc")

    monkeypatch.setattr(store, "_write_arrays", full_disk)
    assert main([str(result)]) == 2
    assert "No space left" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["made.nc"]


@pytest.mark.parametrize(
    ("which", "code"), [pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow), (signal.SIGINT, 130)]
)
def test_signals_end_it_without_a_report(which, code, tmp_path):
    path = write_result(tmp_path / "made.nc", make_run(n_times=6001))
    process = subprocess.Popen(
        [sys.executable, "-m", "residual.cli", str(path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    wait_until(lambda: list(tmp_path.glob(".made-residual-*")), process)
    process.send_signal(which)
    _, err = process.communicate(timeout=GIVE_UP)
    assert process.returncode in (code, -which)  # the same to a shell: Python may pass an interrupt on as it leaves
    assert "Traceback" not in err
    assert [p.name for p in tmp_path.iterdir()] == ["made.nc"]


def test_help_and_version(capsys):
    for option, word in (("--help", "Example"), ("--version", "")):
        try:
            code = main([option])
        except SystemExit as stop:
            code = stop.code or 0
        assert code == 0
        assert word in capsys.readouterr().out

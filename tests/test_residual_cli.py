"""check-residual as its users meet it: exit codes, messages, the report folder."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "reference"))
from synthetic_run import exact_errors, make_run, run_variables, write_result, write_table

from residual.cli import main

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
        "fig04",
        "fig06",
        "fig07",
        "fig08",
        "fig09",
        "fig10",
        "fig11",
        "fig10b",
        "fig11b",
        "budget",
        "orbit",
        "load_distribution",
        "passage",
        "loads",
        "energy",
        "budget_stacked",
        "budget_spectra",
        "envelope",
    )
    assert names == {"residual.nc", "summary.json", "report.html"} | {
        f"{figure}.{kind}" for figure in figures for kind in ("png", "svg")
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
    assert page.count("data:image/") == 18
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
    (folder / "summary.json").write_text('{"program": "check-residual", "samples": -1}')
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


def broken(change):
    """A result file with one thing wrong."""

    def make(run, folder):
        path = write_result(folder / "bad.nc", run)
        with h5py.File(path, "a") as file:
            change(file)
        return [str(path)], "bad.nc"

    return make


def replaced(name, value):
    """A result file with one variable exchanged; None drops it."""

    def change(file):
        old = file[name][:]
        del file[name]
        if value is not None:
            file[name] = value(old)

    return broken(change)


def attribute(name, value):
    def change(file):
        if value is None:
            del file.attrs[name]
        else:
            file.attrs[name] = value

    return broken(change)


def poke(index, value):
    def change(old):
        old[index] = value
        return old

    return change


def text_file(name, text):
    def make(run, folder):
        (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return [str(folder / name)], name

    return make


def table(edit, with_scene=True):
    """A trajectory table whose lines have been edited."""

    def make(run, folder):
        path = write_table(run, folder / "bad.csv")
        path.write_text("\n".join(edit(path.read_text().splitlines())) + "\n")
        scene = ["--scene", str(scene_file(run, folder))] if with_scene else []
        return [str(path), *scene], "bad.csv"

    return make


def truncated(run, folder):
    path = write_result(folder / "bad.nc", run)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return [str(path)], "bad.nc"


def overwritten(run, folder):
    path = write_result(folder / "bad.nc", run)
    data = bytearray(path.read_bytes())
    data[200:4000] = b"\xa5" * 3800
    path.write_bytes(data)
    return [str(path)], "bad.nc"


def with_options(*options):
    def make(run, folder):
        return [str(write_result(folder / "made.nc", run)), *options], options[0]

    return make


def other_scene(run, folder):
    (folder / "other.toml").write_text("[operation]\nspeed_rpm = 3000.0\n")
    return [str(write_result(folder / "made.nc", run)), "--scene", str(folder / "other.toml")], "other.toml"


def huge(file):
    for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y"):
        del file[name]
        shape = (10**12,) if not name.startswith("roller") else (10**12, 13)
        file.create_dataset(name, shape=shape, dtype="f8", chunks=True)
    file.attrs["committed_samples"] = 10**12


def drop_column(lines):
    return [line.partition(",")[2] for line in lines]


FAULTS = {
    "no such file": lambda run, folder: ([str(folder / "gone.nc")], "gone.nc"),
    "a folder": lambda run, folder: ([str(folder)], str(folder)),
    "empty file": text_file("bad.nc", ""),
    "not HDF5": text_file("bad.nc", "time,inner_x\n"),
    "HDF5 signature only": text_file("bad.nc", b"\x89HDF\r\n\x1a\n" + bytes(40)),
    "truncated": truncated,
    "overwritten in the middle": overwritten,
    "another program's": attribute("scene", None),
    "wrong version": attribute("format_version", 99),
    "no version": attribute("format_version", None),
    "scene not TOML": attribute("scene", "name = ["),
    "scene impossible": attribute("scene", "[operation]\nspeed_rpm = nan\n"),
    "negative commit counter": attribute("committed_samples", -3),
    "commit counter as text": attribute("committed_samples", "many"),
    "commit counter beyond the data": attribute("committed_samples", 100_000),
    "too few samples": attribute("committed_samples", 10),
    "nothing committed": attribute("committed_samples", 0),
    "no inner_y": replaced("inner_y", None),
    "no time": replaced("time", None),
    "NaN": replaced("inner_x", poke(7, np.nan)),
    "infinite force": replaced("inner_force", poke((7, 3), np.inf)),
    "NaN in the energies": replaced("energy_kinetic", poke(7, np.nan)),
    "time falls": replaced("time", poke(7, 0.0)),
    "time irregular": replaced("time", lambda t: t + np.where(t > 1e-3, 3e-6, 0.0)),
    "rollers missing": replaced("roller_x", lambda v: v[:, :-1]),
    "roller loads of another bearing": replaced("inner_force", lambda v: v[:, :-1]),
    "flat roller array": replaced("roller_y", lambda v: v[:, 0]),
    "text instead of numbers": replaced("inner_x", lambda v: v.astype("S8")),
    "group instead of an array": broken(lambda f: (f.__delitem__("inner_x"), f.create_group("inner_x"))),
    "millimetres": replaced("roller_x", lambda v: 1e3 * v),
    "too big to hold": broken(huge),
    "table without scene": table(lambda lines: lines, with_scene=False),
    "table without time": table(drop_column),
    "table with a word": table(lambda lines: [*lines[:5], lines[5].replace("0", "zero", 1), *lines[6:]]),
    "table with a short row": table(lambda lines: [*lines[:5], lines[5].rpartition(",")[0], *lines[6:]]),
    "table with a roller less": table(lambda lines: [line.rsplit(",", 2)[0] for line in lines]),
    "table with a column twice": table(lambda lines: [f"{line},{line.split(',')[0]}" for line in lines]),
    "table with NaN": table(lambda lines: [*lines[:5], "nan" + lines[5][lines[5].index(",") :], *lines[6:]]),
    "table of a header only": table(lambda lines: lines[:1]),
    "picture": text_file("cat.png", b"\x89PNG\r\n\x1a\n" + bytes(range(256))),
    "prose": text_file("notes.csv", "dear diary\n"),
    "scene of another run": other_scene,
    "missing scene file": with_options("--scene", "nowhere.toml"),
    "unknown law": with_options("--law", "hooke"),
    "negative start": with_options("--start", "-1"),
    "start beyond the end": with_options("--start", "1e6"),
    "start not a number": with_options("--start", "nan"),
    "negative tolerance": with_options("--tolerance", "-1"),
    "odd order": with_options("--order", "5"),
    "unknown option": with_options("--odrer", "4"),
}


@pytest.mark.filterwarnings("ignore:loadtxt")
@pytest.mark.parametrize("fault", FAULTS)
def test_unusable_input_exits_2_names_the_culprit_and_leaves_nothing(fault, run, tmp_path, capfd):
    arguments, culprit = FAULTS[fault](run, tmp_path)
    before = {p.name for p in tmp_path.iterdir()}
    try:
        code = main(arguments)
    except SystemExit as stop:  # the option parser's own way out
        code = stop.code
    out, err = capfd.readouterr()
    assert code == 2
    named = {"start beyond the end": "made.nc", "missing scene file": "nowhere.toml"}.get(fault, culprit)
    assert named in err
    assert "Traceback" not in err and out == ""
    assert {p.name for p in tmp_path.iterdir()} == before


def test_no_runs_at_all_is_said_plainly(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([]) == 2
    assert "run-fem" in capsys.readouterr().err


@pytest.mark.parametrize(("which", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_signals_end_it_without_a_report(which, code, tmp_path):
    path = write_result(tmp_path / "made.nc", make_run(n_times=6001))
    process = subprocess.Popen(
        [sys.executable, "-m", "residual.cli", str(path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60.0
    while not list(tmp_path.glob(".made-residual-*")) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(which)
    _, err = process.communicate(timeout=60)
    assert process.returncode == code
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


def test_importing_the_command_loads_nothing_heavy():
    heavy = "numpy scipy matplotlib h5py xarray pydantic jinja2 fem meshes"
    code = f"import sys, residual.cli; print([m for m in '{heavy}'.split() if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)},
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert done.stdout.strip() == "[]"

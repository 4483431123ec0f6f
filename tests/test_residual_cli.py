"""check-residual as its users meet it: exit codes, the report folder, verdicts, comparisons, what it warns of."""

import json
import os
import re
import shutil
import signal
import subprocess
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from fem.commands.run_fem import run_main
from lagrange import contact_laws, static_equilibrium
from lagrange.scene.scene import Scene
from residual import report
from residual.cli import main
from residual.evaluation import evaluate
from residual.fault_finding import roller_motion
from residual.figures.run import method_sentence
from residual.findings import difference_table, error_table, interpretation, peak_name, verdict
from residual.formatting import hertz, length, text
from residual.load_zone import quasi_static
from residual.record import Record
from residual.report import MOST_POINTS, picture_of, spectra_json
from residual.sampling import stationarity
from residual.sources import read_result, read_table
from residual.spectrum import find_peaks, power_spectrum
from residual.vibration import HUB, named_peaks
from tests.reference import synthetic_run as made
from tests.reference.kit import environment, read_json, started_as
from tests.reference.synthetic_run import make_run, recorded, report_of, run_variables, write_result, write_table
from tests.waiting import GIVE_UP, wait_until

STEP = 1e-5  # s, of made-up runs
FIGURES = "history whole_spectra budget orbit load_distribution passage loads energy budget_spectra hub_spectrum"
PLAIN = "--quiet", "--no-figures"


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=401)


@pytest.fixture(scope="module")
def pair(run, tmp_path_factory):
    """Runs "quiet", and "loud", whose hub moves by thrice as much."""
    folder, loud = tmp_path_factory.mktemp("runs"), make_run(n_times=401, amplitude=6e-7)
    return write_result(folder / "quiet.nc", run), write_result(folder / "loud.nc", loud)


def checked(run, folder, capsys, law="harris"):
    """Summary, check, terminal and warnings of a run as a table."""
    table, scene = write_table(run, folder / "table.csv"), folder / "scene.toml"
    scene.write_text(run.scene.to_toml(), encoding="utf-8")
    summary, _ = report_of(table, folder / "out", "--scene", scene, "--law", law, "--no-figures")
    printed = capsys.readouterr()
    return summary, evaluate(read_table(table, run.scene), law), printed.out, printed.err.splitlines()


def test_table_with_a_known_residual_is_reproduced(tmp_path, capsys):
    run = make_run(n_times=6001, tone=3000.0, amplitude=2e-6)
    found, _, told, _ = checked(run, tmp_path, capsys)
    assert found["samples"] == 6001 and found["interval_s"] == pytest.approx(1e-5)
    for name, exact in zip("xy", made.exact_errors(run), strict=True):
        numbers = {"std_N": exact.std(), "mean_N": exact.mean(), "max_abs_N": np.max(np.abs(exact)),
                   "rms_N": np.sqrt(np.mean(exact**2))}  # fmt: skip
        assert found[f"error_{name}"] == pytest.approx(numbers, rel=5e-3)
        first = found[f"peaks_{name}"][0]
        assert first["frequency_Hz"] == pytest.approx(3000.0, rel=1e-3) and first["line"] is None
    bpfo = [p for p in found["peaks_x"] if p["line"] == "BPFO"]
    assert bpfo and bpfo[0]["frequency_Hz"] == pytest.approx(381.52, rel=5e-3)
    assert "3000 Hz" in told and str(tmp_path / "out" / "report.html") in told.replace("\n", "")


def test_report_folder_is_complete_its_page_fetches_nothing_and_escapes_names(run, tmp_path):
    assert main([str(write_result(tmp_path / "a <b> & c.nc", run)), "--quiet"]) == 0
    odd = tmp_path / "a <b> & c-residual"
    names = {f"{figure}.{kind}" for figure in FIGURES.split() for kind in ("png", "svg")}
    assert {p.name for p in odd.iterdir()} == {"residual.nc", "summary.json", "report.html"} | names
    found = read_json(odd / "summary.json")
    contract = "interval_s start_s error_x frequency_resolution_Hz peaks_x peaks_y budget_x budget_y"
    assert set(contract.split()) <= set(found)
    assert (found["run"], found["law"], found["samples"]) == ("a <b> & c", "harris", 401)
    assert found["loaded_rollers"] == {"min": 6, "max": 7}
    assert sum(found["budget_mean_y"].values()) == pytest.approx(found["error_y"]["mean_N"], abs=1e-9)
    with h5py.File(odd / "residual.nc") as file:
        assert file["error_x"].attrs["units"] == "N" and file["psd_x"].attrs["units"] == "N2 Hz-1"
        assert file["psd_y"].dims[0][0] == file["frequency"] and file["error_x"].dims[0][0] == file["time"]
        assert np.std(file["error_y"]) == pytest.approx(found["error_y"]["std_N"], rel=1e-12)
        terms = sum(file[name][:] for name in file if name.startswith("budget_x_"))
        np.testing.assert_allclose(terms, file["error_x"][:], atol=2e-6)
    page = (odd / "report.html").read_text(encoding="utf-8")
    assert "a &lt;b&gt; &amp; c" in page and "<b> &" not in page
    assert not any(word in page for word in ('src="http', "<script src", "@import"))
    assert page.count("data:image/") == 10 and len(page) < 5_000_000
    pytest.importorskip("netCDF4")
    with xarray.open_dataset(odd / "residual.nc", engine="netcdf4", decode_times=False) as data:
        assert data["error_x"].dims == ("time",) and data["psd_x"].dims == ("frequency",)


def test_newest_run_is_the_default_quiet_prints_nothing_and_help_tells(run, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    os.utime(write_result(tmp_path / "runs" / "a.nc", run), (1, 1))
    write_result(tmp_path / "runs" / "b.nc", run)
    assert main([*PLAIN]) == 0 and capfd.readouterr() == ("", "")
    assert [p.name for p in (tmp_path / "runs").iterdir() if p.is_dir()] == ["b-residual"]
    assert main(["--help"]) == 0 and "Example" in capfd.readouterr().out and main(["--version"]) == 0


def test_unfinished_run_is_used_up_to_its_committed_samples_and_a_warning_told_once(run, tmp_path, capsys):
    variables = run_variables(run)
    variables["inner_x"] = np.where(np.arange(401) < 300, variables["inner_x"], np.nan)
    about = {"committed": 300, "status": "failed: energy grows at step 7", "warnings": "the same\nthe same"}
    path = write_result(tmp_path / "cut.nc", run, variables, **about)
    found, page = report_of(path, tmp_path / "out", "--no-figures")
    warned = capsys.readouterr().err
    assert "warning" in warned and "energy grows" in warned and found["samples"] == 300
    assert warned.count("the same") == 1 and page.lower().count("the same</li>") == 1


def test_older_report_is_replaced_a_foreign_folder_is_not(run, tmp_path, monkeypatch, capsys):
    result, folder = write_result(tmp_path / "made.nc", run), tmp_path / "made-residual"
    options = [str(result), *PLAIN]
    with monkeypatch.context() as patch:
        patch.setattr(report, "_write_arrays", lambda *_: open("/dev/full", "w", buffering=1).write("x\n"))
        assert main(options) == 2 and "No space left" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["made.nc"] and main(options) == 0
    earlier = read_json(folder / "summary.json")
    (folder / "summary.json").write_text(json.dumps(earlier | {"samples": -1}))
    assert report_of(result, folder, *PLAIN)[0]["samples"] == 401
    (folder / "thesis.docx").write_text("dear")
    assert main(options) == 2 and "thesis.docx" in capsys.readouterr().err
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


@pytest.mark.parametrize(
    ("which", "code"), [pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow), (signal.SIGINT, 130)]
)
def test_signals_end_it_without_a_report(which, code, tmp_path):
    path = write_result(tmp_path / "made.nc", make_run(n_times=6001))
    process = subprocess.Popen([*started_as("check-residual"), str(path)], env=environment(), stderr=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)  # fmt: skip
    wait_until(lambda: list(tmp_path.glob(".made-residual-*")), process)
    process.send_signal(which)
    _, err = process.communicate(timeout=GIVE_UP)
    assert process.returncode in (code, -which)  # the same to a shell: Python may pass an interrupt on as it leaves
    assert "Traceback" not in err and [p.name for p in tmp_path.iterdir()] == ["made.nc"]


# What the report says of the Lagrangian model, the statics it compares with, error estimates, the picture
@pytest.fixture(scope="module")
def meant(tmp_path_factory):
    """A run whose forces are the law's times 1.25: the law carries a fifth less than the run."""
    run = make_run(n_times=1201)
    return recorded(tmp_path_factory.mktemp("made") / "made.nc", run, run_variables(run, force_factor=1.25))


def test_statics_are_those_of_rigid_rings_on_harris_law(meant):
    """629.7 N under the load, 607.0 N where it falls between two rollers; approach 4.11 µm; 14 and 120 nm of varying
    compliance: computed independently of this package with Harris' law and rigid rings, without the rollers' mass.
    """
    found = quasi_static(meant, "harris")
    forces = [found.force.max(), *np.interp([0.0, np.pi / 13], found.angle, found.force)]
    assert forces == pytest.approx([629.7, 629.7, 607.0], abs=1.5)
    assert -1e6 * found.y.mean() == pytest.approx(4.12, abs=0.03)
    assert [1e9 * np.ptp(found.y), 1e9 * np.ptp(found.x) / 5.0] == pytest.approx([14.0, 24.0], abs=1.0)
    assert found.x[-1] == pytest.approx(found.x[0], abs=1e-12)  # one pitch further the bearing is the same
    assert quasi_static(meant, "fitted").law == "harris"  # a law fitted to the run is stood in for


def test_the_sentences_say_how_much_of_the_load_the_law_carries_or_blame_nobody(meant, run, tmp_path):
    found = evaluate(meant, law="iso16281")
    sentences, share = " ".join(interpretation(found)), 100.0 * found.y.error.mean / 2000.0
    assert abs(share) > 1.0
    assert f"gives {abs(share):.3g} % {'less' if share > 0.0 else 'more'} force than the load" in sentences
    assert f"{text(float(found.statics.force.max()))} N on the most loaded roller" in sentences
    assert f"{found.laws[0].name} has the smallest error" in sentences
    bare = {name: value for name, value in run_variables(run).items() if "force" not in name and "traction" not in name}
    found = evaluate(recorded(tmp_path / "bare.nc", run, bare))
    assert "without contact forces" in verdict(found).lower()
    assert not any("leaves out" in sentence for sentence in interpretation(found))
    idle = replace(run, scene=run.scene.varied({"operation.radial_load_N": 0.0}))
    found = evaluate(recorded(tmp_path / "idle.nc", idle))
    assert not any("% less" in sentence or "% more" in sentence for sentence in interpretation(found))
    assert found.record.load == pytest.approx(MASS * GRAVITY)  # a preloaded bearing is judged by its contact forces
    assert found.reference == (found.force.max(), "largest contact force")


def test_the_pages_spectra_are_those_of_the_evaluation_and_every_peak_of_a_long_record_is_kept(meant, tmp_path):
    found = evaluate(meant)
    data, psd = json.loads(spectra_json(found)), found.x.spectrum.psd
    assert data["frequency"] == pytest.approx(found.x.spectrum.frequency[1:], rel=1e-6)
    assert data["x"] == pytest.approx(psd[1:], rel=1e-3, abs=1e-15 * psd.max())
    named = {line["name"]: line["frequency"] for line in data["lines"]}
    assert named["BPFO"] == pytest.approx(found.lines["BPFO"], rel=1e-6)
    found = evaluate(recorded(tmp_path / "long.nc", make_run(n_times=40_001, tone=9_000.0)))
    whole = {d.name: replace(d, spectrum=power_spectrum(d.budget.error, STEP)) for d in found.directions}
    data, psd = json.loads(spectra_json(replace(found, **whole))), whole["x"].spectrum.psd
    assert len(data["frequency"]) <= 2 * MOST_POINTS < psd.size and max(data["x"]) == pytest.approx(psd.max(), rel=1e-3)
    assert data["frequency"][np.argmax(data["x"])] == pytest.approx(9_000.0, abs=3.0)


def test_tolerance_gives_the_verdict_and_error_estimates_of_the_run_are_told(run, tmp_path, capsys):
    result = write_result(tmp_path / "made.nc", run)
    for tolerance, code, word in (("1e6", 0, "passes"), ("0.001", 1, "fails")):
        found, page = report_of(result, tmp_path / "out", "--tolerance", tolerance, "--no-figures", code=code)
        assert found["verdict"] == word and word in capsys.readouterr().out.lower()
    assert "Discretisation error" not in page
    with h5py.File(result, "r+") as file:
        file["quantity_meaning"], file["quantity_unit"] = ["displacement of the hub"], ["m"]  # as run-fem writes it
        file["quantity_value"], file["quantity_error"] = [3.6156e-6], [0.0018e-6]
    _, page = report_of(result, tmp_path / "out", *PLAIN)
    cells = "</td><td>".join(("displacement of the hub", "3.6156 µm", "0.0018 µm", "0.05 %"))
    assert "Discretisation error" in page and f"<tr><td>{cells}</td></tr>" in page


def test_only_a_picture_of_this_very_run_is_shown(coarse_run, tmp_path):
    from fem.commands.render_fem import render_main

    run, picture = tmp_path / "run.nc", tmp_path / "run.png"
    run.write_bytes(b"run")
    assert picture_of(run) is None
    for source in ("", "another.nc", "run.nc"):  # some picture, another run's, this one's
        about = PngInfo()
        about.add_itxt("Source", source)
        about.add_itxt("Description", "Von Mises stress.")
        Image.new("RGB", (40, 30)).save(picture, pnginfo=about)
        assert (picture_of(run) is None) == (source != "run.nc")
    found = picture_of(run)
    assert found["caption"] == "Von Mises stress." and found["address"].startswith("data:image/png;base64,")
    os.utime(picture, (1.0, 1.0))
    assert picture_of(run) is None  # of an earlier run of that name
    picture.write_bytes(b"no picture")
    assert picture_of(run) is None
    picture.unlink()
    shutil.copy(coarse_run, run)
    assert render_main([str(run), "--width", "300", "--time", "2"]) == 0
    assert picture_of(run)["caption"].startswith("Von Mises stress, the whole bearing at 2 ms; finite elements")


# What a report calls things: numbers as a person reads them, causes by their right names, one sentence first
def test_numbers_are_written_out_where_a_person_would_and_noise_is_0():
    told = {
        -8.03e-5: "−8.03·10⁻⁵", 46460.0: "46460", 213.6049: "213.6", 0.0: "0", -0.5: "−0.5", None: "-",
        0.000123456: "0.0001235", 2.5e10: "2.5·10¹⁰", 1.09e-9: "1.09·10⁻⁹", 99999.6: "100000", 1e6: "1·10⁶",
    }  # fmt: skip
    assert {value: text(value) for value in told} == told
    assert text(-2.8e-4, noise=2e-3) == "0" and text(2.8e-3, noise=2e-3) == "0.0028"
    assert hertz(380.04) == "380 Hz" and hertz(46460.0) == "46.46 kHz"
    assert [length(x) for x in (3.034e-10, -1.477e-5, 0.0, 1e-13)] == ["0.3034 nm", "−14.77 µm", "0 nm", "0 nm"]


def damped_record(damping):
    """A table's record whose contact forces hold the hub's motion with a damper that stands in no column."""
    run = make_run(n_times=2001)
    o, mass = run.scene.operation, run.scene.operation.inner_ring_and_shaft_kg
    velocity = 2 * np.pi * 500.0 * run.inner_x  # of inner_y: d(sin) = ω cos
    wanted = mass * run.acceleration_y + mass * o.gravity_m_s2 + o.radial_load_N + damping * velocity
    share = wanted / -np.sum(run.law_force * np.sin(run.angle), axis=1)
    places = {name: getattr(run, name) for name in ("scene", "time", "inner_x", "inner_y", "roller_x", "roller_y")}
    record = Record(name="rig", source="rig.csv", inner_force=run.law_force * share[:, None], **places)
    return record, damping * velocity


def test_a_hidden_damper_is_found_as_other_forces_and_the_first_sentence_tells_sound_trajectories(pair):
    record, force = damped_record(2e4)
    terms = evaluate(record).budget.y.terms
    assert "ring_flexibility" not in terms
    np.testing.assert_allclose(terms["other_forces"][50:-50], -force[50:-50], atol=5e-3 * np.abs(force).max())
    good = evaluate(damped_record(0.0)[0])
    assert verdict(good).startswith("The trajectories are") and "at most" in verdict(good)
    rows = {row[0]: row[1:] for row in error_table(good).rows}
    assert rows["momentum balance, y"][0] == "0"  # round-off of a table
    told = evaluate(read_result(pair[0]))
    found, worst, peak = verdict(told), max(e.rms for e in told.judged), max(e.max_abs for e in told.judged)
    assert found.startswith("The trajectories are not sound")
    assert f"{text(100 * worst / 2000, 3)} % of the load, and at most by {text(peak)} N" in found
    assert verdict(told, 1.0).startswith("Fails the tolerance of 1 N: the trajectories")
    # a roller that barely touches is not loaded
    own = told.record.inner_force
    for least, loaded in ((0.0, (6, 7)), (0.009, (6, 7)), (0.011, (13, 13))):  # of the largest force
        record = replace(told.record, inner_force=np.maximum(own, least * own.max()))
        assert replace(told, record=record).loaded_range == loaded


def test_the_hubs_resonance_and_two_lines_in_one_bin_are_named_and_noise_is_left_out():
    def spectrum(scale, *tones):
        time = STEP * np.arange(6001)
        record = 1e-3 * np.random.default_rng(3).standard_normal(time.size)
        return power_spectrum(scale * (record + sum(np.cos(2 * np.pi * f * time) for f in tones)), STEP)

    lines, loud = {"BPFO": 380.0, "5×BPFI": 2995.0, "8×BPFO": 3003.0}, spectrum(1.0, 3000.0, 13_100.0, 7000.0)
    peaks = named_peaks(find_peaks(loud, lines), loud, lines, 13_000.0, 0.0)
    names = {round(peak.frequency, -2): peak_name(peak) for peak in peaks}
    assert names[3000.0] in ("8×BPFO or 5×BPFI", "5×BPFI or 8×BPFO")
    assert names[13_100.0] == HUB and names[7000.0] == "-"
    lines, faint = {"BPFO": 380.0}, spectrum(1e-9, 3000.0)
    for noise, told in ((0.0, True), (1e-6, False)):
        assert bool(named_peaks(find_peaks(faint, lines), faint, lines, 13_000.0, noise)) == told


# Two runs or two laws beside each other, a report without equations, the data for other programs
def number(cell):
    return float(cell.replace("−", "-"))


def test_the_differences_of_two_runs_are_those_of_their_motion_of_two_laws_those_of_their_errors(pair):
    here, there = (evaluate(read_result(path)) for path in pair)
    rows = {row[0]: row[1:] for row in difference_table(here, there).rows}
    for axis in "xy":
        stds = [1e9 * getattr(each.record, f"inner_{axis}").std() for each in (here, there)]
        *told, words = rows[f"hub {axis}, std, nm"]
        assert [number(cell) for cell in told] == pytest.approx([*stds, stds[0] - stds[1]], rel=5e-3)
        assert words == "66.7 % less"  # of a third of the amplitude
    assert rows["largest roller load, N"][2:] == ["0", "alike"]
    assert method_sentence(here, there).endswith(" Run loud: finite elements, no contact damping.")
    damped = here.record.scene.varied({"model": "reduced", "damping.contact_time_us": 12.5})
    of_time = replace(here, record=replace(here.record, scene=damped))
    assert method_sentence(of_time, None) == " Run quiet: reduced model, contact damping 12.5 µs times its stiffness."
    assert method_sentence(replace(here, record=replace(here.record, attributes={})), None) == ""  # a table's
    there = evaluate(here.record, "palmgren")
    rows = {row[0]: row[1:] for row in difference_table(here, there).rows}
    assert rows["hub y, mean, µm"][2] == "0"
    change = here.y.error.rms - there.y.error.rms
    assert abs(change) > 1.0 and number(rows["error_y, rms, N"][2]) == pytest.approx(change, rel=5e-3)


def test_a_run_is_compared_in_words_and_without_equations_by_its_motion_alone(pair, tmp_path, capsys, monkeypatch):
    report_of(pair[0], tmp_path / "laws", "--against", "palmgren", "--no-figures")
    assert "palmgren" in capsys.readouterr().out
    out, (quiet, loud) = tmp_path / "out", pair
    _, page = report_of(loud, out, "--against", quiet, "--no-equations")
    printed = capsys.readouterr().out
    assert "loud − quiet" in printed and "<th>loud − quiet</th>" in page and 'id="against"' in page
    assert "<td>3 times</td>" in page  # of thrice the amplitude
    assert "error_" not in printed and "error_x, mean" not in page and "(22)" not in printed
    assert "Run quiet: finite elements, no contact damping.</figcaption>" in page
    body = page.partition("<script")[0].partition("<footer>")[0].partition("<details>")[0]
    assert 'id="vibration"' in body and 'id="player"' in body and "The trajectories are" in printed
    assert not any(word in body for word in ("error_x", 'id="budget-of-errors"', 'id="laws"'))
    assert '"unit":"m²/s⁴/Hz"' in page or "m\\u00b2/s\\u2074/Hz" in page
    monkeypatch.setattr("residual.evaluation.evaluate", lambda *given, **more: pytest.fail("evaluated"))
    assert main([str(loud), "--against", "palmgren", "--no-equations", "--output", str(out)]) == 2
    assert "--no-equations leaves out" in capsys.readouterr().err
    for other in ("nothing.nc", "hariss"):
        assert main([str(quiet), "--against", other, "--output", str(tmp_path / "none")]) == 2
        assert f"--against {other}: neither a file nor a contact law" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


def test_signals_are_exported_as_csv_alone(pair, tmp_path, capsys):
    out = tmp_path / "out"
    report_of(pair[0], out, "--export", "csv", *PLAIN)
    record = read_result(pair[0])
    table = np.genfromtxt(out / "signals.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["inner_y"], record.inner_y, rtol=1e-11)
    np.testing.assert_allclose(table["inner_force_5"], record.inner_force[:, 5], rtol=1e-11)
    report_of(pair[0], out, *PLAIN)  # they are an earlier report's
    assert not (out / "signals.csv").exists()
    for gone in ("mat", "wav", "curves"):
        assert main([str(pair[0]), "--export", gone, "--output", str(out)]) == 2
        assert f"error: --export {gone}: only csv is written; MATLAB reads" in capsys.readouterr().err


# What a check warns of in a record itself: vibration folded down, a beginning that is a transient
# NU 206 (not E) by its makers' catalogues, a normal clearance, a shaft of 3 kg
NU206 = "bearing = { rollers = 13, roller_diameter_mm = 7.5, roller_length_mm = 9.0, inner_raceway_diameter_mm = 38.5, "
NU206 += "outer_raceway_diameter_mm = 53.54, bore_diameter_mm = 30.0, outside_diameter_mm = 62.0 }\n"
NU206 += "operation = { speed_rpm = 3000.0, radial_load_N = 1500.0, inner_ring_and_shaft_kg = 3.0 }\n"
NU206 += "numerics = { duration_ms = 6.0, mesh_size_mm = 2.0 }"
SPALLED = 'model = "reduced"\nbearing.designation = "NU206"\nnumerics.duration_ms = 8.0\n'
SPALLED += "operation = { speed_rpm = 2950.0, radial_load_N = 3000.0 }\nspall = [{ width_mm = 1.2 }]"
PASSING = 400.0


def checked_at(folder, scene, interval):
    """Check of a run of a scene, sampled every so many µs."""
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    options = ["--set", f"numerics.output_interval_us={interval}", "--output", str(folder / f"{interval}.nc")]
    assert run_main([str(folder / "scene.toml"), *options, "--quiet"]) == 0
    return evaluate(read_result(folder / f"{interval}.nc"))


def test_vibration_beyond_the_samples_is_warned_of_and_the_interval_named_cures_it(tmp_path, coarse_run):
    """Also strikes in a spall: Newton's law holds for slow motion, as samples show it, and not for the strikes; the
    interval named is right where it holds for all.
    """
    coarse = checked_at(tmp_path, NU206, 10)
    (note,) = [note for note in coarse.notes if "aliased" in note]
    fine = checked_at(tmp_path, NU206, float(note.rpartition("= ")[2]))
    for sound in (fine, evaluate(read_result(coarse_run))):
        assert not any("aliased" in note for note in sound.notes)
    assert all(direction.balance.rms < 1.5 * direction.floor for direction in fine.directions)
    assert fine.y.balance.rms < 0.3 * coarse.y.balance.rms
    coarse = verdict(checked_at(tmp_path, SPALLED, 5.0))
    assert coarse.startswith("The trajectories are sound below 10 kHz") and "samples every 5 µs do not follow" in coarse
    enough = float(re.search(r"output_interval_us = ([\d.]+)", coarse)[1])
    assert verdict(checked_at(tmp_path, SPALLED, enough)).startswith("The trajectories are sound (")


def swinging(amplitudes):
    """A record whose hub swings by so much, m, in each of four quarters of 20 ms."""
    time, none = STEP * np.arange(8000), np.zeros((8000, 13))
    swing = np.repeat(amplitudes, 2000) * np.sin(2 * np.pi * 900.0 * time)
    return Record(name="made", source=Path("made.nc"), scene=Scene(), time=time, inner_x=swing, inner_y=0.1 * swing,
                  roller_x=none, roller_y=none)  # fmt: skip


QUARTERS = {(1, 1, 1.2, 1): 0, (1, 3, 3.1, 3): 1, (1, 2, 4, 4.4): 2, (1, 2, 3, 6): None, (1e-5, 3e-5, 1e-6, 0): 0}


@pytest.mark.parametrize("amplitudes", QUARTERS, ids=str)
def test_the_quarter_from_which_the_hub_swings_alike(amplitudes):
    record, settled = swinging(1e-7 * np.array(amplitudes, dtype=float)), QUARTERS[amplitudes]
    found = stationarity(record, {"x": record.inner_x, "y": record.inner_y}, PASSING)
    assert found.settled == settled
    np.testing.assert_allclose(found.hub["x"], 1e-7 * np.array(amplitudes) / np.sqrt(2), rtol=1e-6)
    remedy = "simulate longer" if settled is None else f"--start {20 * settled} leaves it out"
    assert remedy in found.note if settled != 0 else found.note is None
    assert stationarity(record.samples(slice(0, 1900)), {}, PASSING) is None, "of few passages"
    assert stationarity(record, {}, 0.0) is None, "nothing passes"


TURNS = 75.0  # Hz, of the shaft
MASS, GRAVITY = 0.078, 9.81
UNBALANCE = 2000.0 / (2 * np.pi * TURNS) ** 2 * 1e6  # g mm
LOADS = {  # lines of [operation], and the rms of the whole load, N
    "down": ("radial_load_N = 2000.0", 2000.0 + MASS * GRAVITY),
    "table": ('load_table = "turning.csv"\ngravity_m_s2 = 0.0', 2000.0),
    "aside": ('load_table = "aside.csv"', np.hypot(2000.0, 20.0 + MASS * GRAVITY)),
    "rotating": ("radial_load_N = 0.0\nrotating_load_N = 2000.0\ngravity_m_s2 = 0.0", 2000.0),
    "unbalance": (f"radial_load_N = 0.0\nunbalance_g_mm = {UNBALANCE}\ngravity_m_s2 = 0.0", 2000.0),
    "weight": ("radial_load_N = 0.0\ninner_ring_and_shaft_kg = 200.0", 200.0 * GRAVITY),
}


@pytest.mark.parametrize("name", LOADS)
def test_a_load_is_a_scale_wherever_it_points_and_however_it_turns(tmp_path, name, capsys):
    """Palmgren's law misses the same share of 2000 N from any direction: the bearing is round. The share is what it
    carries more than Harris' on the approaches of an equilibrium with the latter.
    """
    lines, load = LOADS[name]
    time = np.linspace(0.0, 20.0, 801)  # ms
    angle = 2e-3 * np.pi * TURNS * time
    turning = np.column_stack([time, 2000.0 * np.cos(angle), 2000.0 * np.sin(angle)])
    np.savetxt(tmp_path / "turning.csv", turning, "%.9f", ",", header="time_ms,x_N,y_N", comments="")
    (tmp_path / "aside.csv").write_text("time_ms,x_N,y_N\n0,2000,-20\n20,2000,-20\n", encoding="utf-8")
    checked_at(tmp_path, f'model = "lagrange"\n[operation]\n{lines}\n[numerics]\nduration_ms = 16.0\n', 5.0)
    summary, page = report_of(tmp_path / "5.0.nc", tmp_path / "out", "--law", "palmgren", "--no-figures")
    printed = capsys.readouterr().out
    assert "The trajectories are sound" in printed and "of the load" in printed
    assert summary["load_N"] == pytest.approx(load, rel=1e-5)  # a table is joined smoothly
    bearing = Scene().ideal_bearing()
    harris, palmgren = (contact_laws(law, bearing).inner for law in ("harris", "palmgren"))
    force = static_equilibrium(bearing, Scene().ideal_operation(), contact_laws("harris", bearing)).inner_force
    down = np.cos(2.0 * np.pi / 13 * np.arange(13))  # roller 0 under the load
    more = 100.0 * (np.sum(palmgren.force(harris.approach(force)) * down) / np.sum(force * down) - 1.0)
    percent = float(page.partition("law palmgren gives ")[2].partition(" %")[0])
    assert percent == pytest.approx(more, rel=0.03) and "% more force than the load" in page


@pytest.mark.parametrize("rate", [0.0, 50.0])
def test_contacts_are_as_stiff_whatever_the_direction_of_the_load(pair, rate):
    """All turned by an angle, constant or growing: nothing else in the bearing has a direction."""
    motion = roller_motion(read_result(pair[0]))
    motion = replace(motion, law=contact_laws("palmgren", motion.bearing).inner.force)
    angle, (x, y) = 1.0 + rate * STEP * np.arange(401), motion.load
    load = np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y
    turned = replace(motion, inner_angle=motion.inner_angle + angle[:, None], load=load)
    assert turned.scale == pytest.approx(motion.scale, rel=1e-12)
    assert replace(motion, load=(0.0 * x, 0.0 * y)).scale == 1.0
    assert abs(motion.scale - 1.0) > 0.02  # the load matters: the law is scaled to carry it


HEAVY = 3.0  # kg
PLACES = ("inner_x", "inner_y", "roller_x", "roller_y")


@pytest.fixture(scope="module")
def still():
    """Held still at an approach that carries 2000 N within 60 N: a hub that moves less than a micrometre."""
    made = make_run(n_times=2001, amplitude=1e-9)
    return replace(made, scene=made.scene.varied({"operation.inner_ring_and_shaft_kg": HEAVY}))


def noisy(still, size):
    rng = np.random.default_rng(5)
    places = {name: getattr(still, name) for name in PLACES}
    return replace(still, **{name: at + size * rng.standard_normal(at.shape) for name, at in places.items()})


def test_positions_rounded_to_a_micrometre_blame_no_law_and_exact_ones_are_told_nothing_of(still, tmp_path, capsys):
    """Noise of the inertia has no mean: what a law carries too little of the load is seen through it."""
    rounded = replace(still, **{name: np.round(getattr(still, name), 6) for name in PLACES})
    summary, found, out, warnings = checked(rounded, tmp_path, capsys)
    assert "rounding to 1 µm" in warnings[0] and "residuals mean nothing" in warnings[0]
    assert "say nothing about the contact law harris" in out and "is off by" not in out
    assert summary["position_noise"]["rounding_step_m"] == pytest.approx(1e-6) and summary["position_noise"]["within"]
    sentences = " ".join(interpretation(found))
    assert "carries" not in sentences and "has the smallest error" not in sentences
    summary, _, out, warnings = checked(still, tmp_path, capsys, "johnson")
    assert not any("positions have an error" in line for line in warnings) and "with the contact law johnson" in out
    assert summary["position_noise"]["rounding_step_m"] < 1e-12 and not summary["position_noise"]["within"]
    found = checked(noisy(still, 1e-8), tmp_path, capsys, "johnson")[1]
    assert found.within_noise and "johnson gives" in " ".join(interpretation(found))


def test_white_noise_is_told_from_the_motion_and_its_force_is_that_of_its_second_derivative(still, tmp_path, capsys):
    """Independent: the same noise, put through M d²/dt² of order 6, and the stiffness of the law at the approaches."""
    moved = noisy(still, 1e-8)
    summary, found, out, warnings = checked(moved, tmp_path, capsys)
    noise = summary["position_noise"]
    assert [*noise["hub_rms_m"].values(), noise["roller_rms_m"]] == pytest.approx([1e-8] * 3, rel=0.1)
    inertia = HEAVY * 1e-8 * np.linalg.norm([2, -27, 270, -490, 270, -27, 2]) / 180.0 / STEP**2
    assert list(noise["balance_N"].values()) == pytest.approx([inertia] * 2, rel=0.1)
    assert [d.error.std for d in found.directions] == pytest.approx(list(noise["error_N"].values()), rel=0.1)
    assert "noise" in warnings[0] and "say nothing about the contact law harris" in out
    with_forces = evaluate(replace(found.record, inner_force=still.law_force))
    assert "the trajectories cannot be checked" in verdict(with_forces).lower()
    # by the law itself, typed in again, at the noisy and at the exact approaches
    b, pushes = still.scene.ideal_bearing(), []
    for each in (still, moved):
        x, y = each.roller_x - each.inner_x[:, None], each.roller_y - each.inner_y[:, None]
        away = np.hypot(x, y)
        force = made.harris_force(b.inner_raceway_radius + b.roller_radius - away)
        pushes.append(np.sum(force * np.stack([x, y]) / away, axis=2))
    assert found.position_noise.law == pytest.approx(np.std(pushes[1] - pushes[0], axis=1), rel=0.1)

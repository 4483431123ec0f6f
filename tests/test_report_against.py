"""Two runs or two laws beside each other, a report without equations, the data for other programs."""

from dataclasses import replace

import numpy as np
import pytest

from residual.cli import main
from residual.evaluation import evaluate
from residual.figures.drawing import method_sentence
from residual.sources import read_result
from residual.tables import difference_table
from tests.reference.synthetic_run import make_run, write_result


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    quiet, loud = make_run(n_times=401), make_run(n_times=401, amplitude=6e-7)
    return write_result(folder / "quiet.nc", quiet), write_result(folder / "loud.nc", loud)


def test_the_differences_of_two_runs_are_those_of_their_motion(runs):
    here, there = (evaluate(read_result(path)) for path in runs)
    rows = {row[0]: row[1:] for row in difference_table(here, there).rows}
    for axis, place in (("x", "inner_x"), ("y", "inner_y")):
        stds = [1e9 * getattr(each.record, place).std() for each in (here, there)]
        told = [float(cell.replace("−", "-")) for cell in rows[f"hub {axis}, std, nm"][:3]]
        assert told[:2] == pytest.approx(stds, rel=1e-4)
        assert told[2] == pytest.approx(stds[0] - stds[1], rel=5e-3)
        assert rows[f"hub {axis}, std, nm"][3] == "66.7 % less"  # of a third of the amplitude
    assert rows["largest roller load, N"][2:] == ["0", "alike"]


def test_two_laws_of_one_run_share_its_motion_and_differ_in_their_errors(runs, tmp_path, capsys):
    out = tmp_path / "out"
    assert main([str(runs[0]), "--against", "palmgren", "--no-figures", "--output", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "harris" in printed and "palmgren" in printed
    here, there = (evaluate(read_result(runs[0]), law) for law in ("harris", "palmgren"))
    rows = {row[0]: row[1:] for row in difference_table(here, there).rows}
    assert rows["hub y, mean, µm"][2] == "0"
    change = here.y.error.rms - there.y.error.rms
    assert abs(change) > 1.0
    assert float(rows["error_y, rms, N"][2].replace("−", "-")) == pytest.approx(change, rel=5e-3)


def test_a_run_is_compared_in_words_and_without_equations_by_its_motion_alone(runs, tmp_path, capsys):
    out, (quiet, loud) = tmp_path / "out", runs
    assert main([str(loud), "--against", str(quiet), "--no-equations", "--no-figures", "--output", str(out)]) == 0
    printed, page = capsys.readouterr().out, (out / "report.html").read_text(encoding="utf-8")
    assert "loud − quiet" in printed and "<th>loud − quiet</th>" in page
    assert "<td>3 times</td>" in page and "more by" not in page  # of thrice the amplitude
    assert "error_" not in printed and "error_x, mean" not in page
    assert main([str(loud), "--against", "palmgren", "--no-equations", "--output", str(out)]) == 2
    assert "--no-equations leaves out" in capsys.readouterr().err


@pytest.mark.parametrize("other", ["nothing.nc", "hariss"])
def test_what_is_neither_a_file_nor_a_law_is_refused_by_name(runs, tmp_path, capsys, other, monkeypatch):
    monkeypatch.setattr("residual.evaluation.evaluate", lambda *given, **more: pytest.fail("evaluated"))
    assert main([str(runs[0]), "--against", other, "--output", str(tmp_path / "out")]) == 2
    assert f"--against {other}: neither a file nor a contact law" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_report_without_equations_speaks_of_the_run_alone(runs, tmp_path, capsys):
    out = tmp_path / "out"
    assert main([str(runs[0]), "--no-equations", "--no-figures", "--output", str(out)]) == 0
    page, printed = (out / "report.html").read_text(encoding="utf-8"), capsys.readouterr().out
    assert "(22)" not in printed and "harris" not in printed and "The trajectories are" in printed
    body = page.partition("<script")[0].partition("<footer>")[0].partition("<details>")[0]
    assert 'id="vibration"' in body and 'id="player"' in body
    assert not any(word in body for word in ("error_x", 'id="budget-of-errors"', 'id="laws"', 'id="paper"'))
    assert '"unit":"m²/s⁴/Hz"' in page or "m\\u00b2/s\\u2074/Hz" in page


def test_signals_are_exported_as_csv_alone(runs, tmp_path, capsys):
    out = tmp_path / "out"
    assert main([str(runs[0]), "--export", "csv", "--no-figures", "--quiet", "--output", str(out)]) == 0
    record = read_result(runs[0])
    table = np.genfromtxt(out / "signals.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["inner_y"], record.inner_y, rtol=1e-11)
    np.testing.assert_allclose(table["inner_force_5"], record.inner_force[:, 5], rtol=1e-11)
    assert main([str(runs[0]), "--no-figures", "--output", str(out), "--quiet"]) == 0  # they are an earlier report's
    assert not (out / "signals.csv").exists()
    for gone in ("mat", "wav", "curves"):
        assert main([str(runs[0]), "--export", gone, "--output", str(out)]) == 2
        assert f"error: --export {gone}: only csv is written; MATLAB reads" in capsys.readouterr().err


def test_captions_of_figures_name_the_model_and_the_damping_of_their_runs(runs, tmp_path):
    here, there = (evaluate(read_result(path)) for path in runs)
    assert method_sentence(here, there).endswith(" Run loud: finite elements, no contact damping.")
    damped = here.record.scene.varied({"model": "reduced", "damping.contact_time_us": 12.5})
    of_time = replace(here, record=replace(here.record, scene=damped))
    assert method_sentence(of_time, None) == " Run quiet: reduced model, contact damping 12.5 µs times its stiffness."
    assert method_sentence(replace(here, record=replace(here.record, attributes={})), None) == ""  # a table's


@pytest.mark.usefixtures("plain_report")
def test_a_comparison_stands_on_the_page_with_its_captions(runs, tmp_path):
    out = tmp_path / "out"
    assert main([str(runs[0]), "--against", str(runs[1]), "--output", str(out), "--quiet"]) == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Run loud: finite elements, no contact damping.</figcaption>" in page
    assert "quiet against loud" in page and 'id="against"' in page

"""Studies that can't be run: refused with exit code 2 before anything is solved, the key named."""

from pathlib import Path

import pytest

from fem.commands.run_study import study_main
from tests.reference.small_study import TWO_SPEEDS

GOOD = '[sampling]\nmethod = "grid"' + TWO_SPEEDS
SPEED = '"operation.speed_rpm" = [1500, 3000]'


def change(old, new):
    assert old in GOOD
    return GOOD.replace(old, new)


BAD = {  # what is wrong: the study and what must be told
    "not TOML": ("[sampling", "not valid TOML"),
    "unknown table": (GOOD + "[kept]\n", "kept: unknown key; did you mean keep?"),
    "unknown key of sampling": (change('method = "grid"', "metod = 1"), "sampling.metod: unknown key; did you mean"),
    "unknown method": (change('"grid"', '"random"'), "sampling.method = 'random'"),
    "samples of a grid": (change('"grid"', '"grid"\nsamples = 4'), "sampling: samples = 4: only for"),
    "no samples": (change('"grid"', '"lhs"'), "sampling: samples: missing"),
    "uneven Sobol": (change('"grid"', '"sobol"\nsamples = 100'), "samples = 100: a Sobol sequence"),
    "indices of a hypercube": (change('"grid"', '"lhs"\nsamples = 4\nindices = true'), "indices = true: only for"),
    "negative seed": (change('"grid"', '"lhs"\nsamples = 4\nseed = -1'), "sampling.seed = -1"),
    "too many samples": (change('"grid"', '"lhs"\nsamples = 10000000'), "sampling.samples = 10000000"),
    "file of a grid": (change('"grid"', '"grid"\nfile = "a.csv"'), "file: a CSV table of points"),
    "list without a file": (change('"grid"', '"list"'), "file: a CSV table of points"),
    "list that is missing": (change(SPEED, "").replace('"grid"', '"list"\nfile = "a.csv"'), "a.csv: can't be read"),
    "list with parameters": (change('"grid"', '"list"\nfile = "a.csv"'), "[parameters]: with method"),
    "no parameters": (change(SPEED, ""), "[parameters]: empty"),
    "unknown scene key": (change(SPEED, '"operation.spede_rpm" = [1]'), "did you mean speed_rpm"),
    "unknown scene table": (change(SPEED, '"operatin.speed_rpm" = [1]'), "did you mean operation"),
    "a table for a key": (change(SPEED, '"operation" = [1, 2]'), "operation = 1: must be a table"),
    "unquoted key": (change(SPEED, "operation.speed_rpm = [1]"), "dotted keys of the scene are quoted"),
    "a plain value": (change(SPEED, '"operation.speed_rpm" = 1500'), '"operation.speed_rpm" = 1500: must be a list'),
    "an empty list": (change(SPEED, '"operation.speed_rpm" = []'), "holds 0 values"),
    "a value twice": (change(SPEED, '"operation.speed_rpm" = [1, 1]'), "1 is there twice"),
    "a value that is none": (change(SPEED, '"operation.speed_rpm" = [nan]'), "nan is no value of a scene"),
    "a list of lists": (change(SPEED, '"operation.speed_rpm" = [[1], [2]]'), "is no value of a scene"),
    "value out of the scene's range": (change("3000]", "3e9]"), "point 1 (operation.speed_rpm = 3e+09)"),
    "value of the wrong type": (change("3000]", '"fast"]'), "operation.speed_rpm = 'fast'"),
    "range upside down": (change("[1500, 3000]", "{ from = 2, to = 1, count = 3 }"), "from = 2 must be below to = 1"),
    "range without an end": (change("[1500, 3000]", "{ from = 2, count = 3 }"), '"operation.speed_rpm".to = None'),
    "range without a count": (change("[1500, 3000]", "{ from = 1, to = 2 }"), "needs a list or a range with a count"),
    "range of one value": (change("[1500, 3000]", "{ from = 1, to = 2, count = 1 }"), ".count = 1: must be"),
    "range with a typo": (change("[1500, 3000]", "{ from = 1, to = 2, cuont = 5 }"), ".cuont: unknown key"),
    "logarithm of nothing": (change("[1500, 3000]", '{ from = 0, to = 2, count = 3, scale = "log" }'), "above 0"),
    "unknown scale": (change("[1500, 3000]", '{ from = 1, to = 2, count = 3, scale = "sqrt" }'), ".scale = 'sqrt'"),
    "distribution of a grid": (change("[1500, 3000]", "{ normal = [1500, 5] }"), "needs a list or a range"),
    "unknown distribution": (change("[1500, 3000]", "{ gauss = [1500, 5] }"), ".gauss: no range and no continuous"),
    "uniform by location and scale": (change("[1500, 3000]", "{ uniform = [1, 2] }"), "write { from"),
    "distribution of nothing": (change("[1500, 3000]", "{ normal = [1500, -5] }"), "outside the distribution"),
    "arguments of a distribution": (change("[1500, 3000]", "{ normal = [1, 2, 3, 4] }"), "4 arguments"),
    "two things at once": (change("[1500, 3000]", "{ normal = [1, 2], gamma = [1] }"), "must be a list"),
    "count of a draw": (
        change('"grid"', '"lhs"\nsamples = 4').replace("[1500, 3000]", "{ from = 1, to = 2, count = 3 }"),
        "count is only for a grid",
    ),
    "lengths of a zip": (
        change('"grid"', '"zip"').replace(SPEED, SPEED + '\n"operation.radial_load_N" = [1, 2, 3]'),
        "needs as many values of each",
    ),
    "too many points": (
        change("[1500, 3000]", "{ from = 1, to = 2, count = 9999 }").replace(
            "[keep]", '"operation.radial_load_N" = { from = 1, to = 2, count = 9999 }\n[keep]'
        ),
        "99,980,001 points; at most",
    ),
    "unknown quantity": (change("hub_mean_y", "hub_mean_z"), "'hub_mean_z' is unknown; did you mean hub_mean_"),
    "quantities that are no names": (change('["hub_mean_y"]', "[1, 2]"), "keep.quantities.1 = 2: "),
    "quantity twice": (change('["hub_mean_y"]', '["hub_mean_y", "hub_mean_y"]'), "is there twice"),
    "unknown signal": (GOOD + 'signals = ["inner_az"]', "keep.signals: 'inner_az' is no signal"),
    "rate without signals": (GOOD + "signal_rate_kHz = 1.0", "there are no signals"),
    "rate above the samples'": (GOOD + 'signals = ["inner_ay"]\nsignal_rate_kHz = 200.0', "samples are stored at 100"),
    "rate of no sample": (GOOD + 'signals = ["inner_ay"]\nsignal_rate_kHz = 0.5', "keeps one of 200 samples, but"),
    "rate next to nothing": (GOOD + 'signals = ["inner_ay"]\nsignal_rate_kHz = 1e-320', "signal_rate_kHz = 1e-320"),
    "signals of other lengths": (
        change(SPEED, '"numerics.duration_ms" = [1.0, 2.0]').replace('"numerics.duration_ms" = 1.0', "", 1)
        + 'signals = ["inner_ay"]',
        "signals must have the same length in every point",
    ),
    "motion of a bearing at rest": (change("_ms\" = 1.0", "_ms\" = 0.0"), "a run at rest has only the quantities"),
    "a key fixed and varied": (change("model =", '"operation.speed_rpm" = 1\nmodel ='), "stands in [fixed] and in"),
    "no time": (GOOD + "[limits]\nseconds_per_point = 0", "limits.seconds_per_point = 0"),
    "a scene that is missing": ('scene = "none.toml"\n' + GOOD, "none.toml: no such file"),
    "a name that is none": ('name = "../x"\n' + GOOD, "name = '../x'"),
    "a file of a scene": (change(SPEED, '"profile.0.file" = ["a.csv", "b.csv"]'), "files of a scene can't be varied"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_is_refused_by_its_key(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text, told = BAD[kind]
    Path("study.toml").write_text(text, encoding="utf-8")
    assert study_main(["study.toml", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert told in said, said
    assert "Traceback" not in said
    assert not Path("studies").exists()


def test_every_fault_of_the_points_is_told_with_its_point(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(change("[1500, 3000]", "[1500, -3e9, 3000, 4e9]"), encoding="utf-8")
    assert study_main(["study.toml", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert "point 1 (" in said and "point 3 (" in said and "point 0" not in said


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "name a study file"),
        (["study.toml", "--workers", "0"], "--workers 0"),
        (["study.toml", "--workers", "2", "--scheduler", "tcp://x:1"], "its own workers"),
        (["study.toml", "--export", "shards"], "training sets are no longer exported; study.nc holds"),
        (["--collect", "nowhere"], "nowhere: no study"),
        (["--collect", ".", "--resume"], "--collect solves nothing"),
        (["study.toml", "--output", "study.toml"], "is a file, not a folder"),
        (["study.toml", "--output", "other"], "other: not empty and no study"),
        (["none.toml"], "none.toml: can't be read"),
    ],
)
def test_unusable_options_are_refused(words, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(GOOD, encoding="utf-8")
    Path("other").mkdir()
    Path("other/mine.txt").write_text("mine", encoding="utf-8")
    assert study_main([*words, "--quiet"]) == 2
    assert told in capsys.readouterr().err
    assert Path("other/mine.txt").read_text(encoding="utf-8") == "mine"

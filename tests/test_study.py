"""Studies: the same results as run-fem, points of each method, pages, what fails or is refused, what goes on.

In several processes of this machine, which open no port, and on a real scheduler; some die or hang.
"""

import io
import json
import multiprocessing
import os
import re
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray
from scipy import stats

from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main
from fem.rating.answers import rating
from fem.study import figures, solving
from fem.study.folder import Folder, write_dataset
from fem.study.page import table_of, write_page
from fem.study.solving import COMPLETE, FAILED, Solved, checked_points
from fem.study.study_file import design_of, read_study
from lagrange.files.output import read_sealed, write_sealed
from lagrange.scene.scene import SceneError, read_scene
from tests.documented import blocks
from tests.reference.kit import BASE, GRID, TWO_SPEEDS, many, read_json, same
from tests.waiting import GIVE_UP, wait_until

KEPT = Path("studies/study")
DOCS = Path(__file__).parents[1] / "docs"
LIST = '[sampling]\nmethod = "list"\nfile = "points.csv"\n'
PATH = [entry for entry in sys.path if entry]


@pytest.fixture
def here(here, monkeypatch):
    """Pages are made without figures, which take most of the time and are tested below."""
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return here


def run(text, *words, workers=("--workers", "1")):
    Path("study.toml").write_text(text, encoding="utf-8")
    return study_main(["study.toml", "--quiet", *workers, *words])


def points_of(text=None, name="study.toml"):
    if text is not None:
        Path(name).write_text(text, encoding="utf-8")
    study = read_study(Path(name))
    return checked_points(study, design_of(study))


def test_a_point_is_what_run_fem_gives_bit_for_bit_and_the_dataset_says_what_it_is(here):
    assert run(GRID, "--keep-runs") == 0
    points = points_of(GRID)
    scene = points.scene(3)
    assert scene.operation.speed_rpm == 3000.0 and scene.bearing.outer_raceway_diameter_mm == 56.02
    Path("scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert run_main(["scene.toml", "--quiet", "--output", "run.nc"]) == 0
    with h5py.File("run.nc") as command, h5py.File(Folder(path=KEPT).run(points.digests[3])) as point:
        for name in command:
            assert command[name][...].tobytes() == point[name][...].tobytes(), name
    with h5py.File("run.nc") as command, xarray.open_dataset(KEPT / "study.nc") as found:
        at = found.sel(speed_rpm=3000.0, outer_raceway_diameter_mm=56.02)
        assert float(at.largest_force) == command["inner_force"][:].max()
        assert float(at.hub_mean_y) == np.trapezoid(command["inner_y"][:], command["time"][:]) / command["time"][-1]
        assert at.inner_ay.dims == ("time",) and at.inner_force.dims == ("time", "roller")
        assert float(at.time[1]) == pytest.approx(4e-5)  # of 10 µs, decimated to 25 kHz
        assert found.sizes["speed_rpm"] == 3 and found.sizes["outer_raceway_diameter_mm"] == 2
        assert found.speed_rpm.attrs["units"] == "rpm" and found.largest_force.attrs["units"] == "N"
        assert np.all(found.status == "complete") and found.attrs["seed"] == 0
        assert found.attrs["study"] == GRID and set(json.loads(found.attrs["libraries"])) >= {"numpy", "numba"}
        lines = found.BPFO_Hz.isel(outer_raceway_diameter_mm=0).values
        assert lines == pytest.approx(13 * np.array([25.0, 50.0, 75.0]) * 18.0 / 46.0)
        assert np.all(found.spall_body == "none")


def test_words_empty_cells_and_signals_of_a_list_are_as_other_readers_have_them(here):
    Path("points.csv").write_text("operation.speed_rpm,lagrange.law\n1500,harris\n,palmgren\n3000,\n")
    assert run(BASE + LIST + '[keep]\nsignals = ["inner_force"]\n') == 0
    with netCDF4.Dataset(KEPT / "study.nc") as found:
        assert {name: len(each) for name, each in found.dimensions.items()} == {"point": 3, "time": 101, "roller": 13}
        assert "point" not in found.variables and found["law"].dimensions == ("point",)
        assert found["law"][:].tolist() == ["harris", "palmgren", ""]
        assert found["speed_rpm"][:].filled(np.nan).tolist() == pytest.approx([1500.0, np.nan, 3000.0], nan_ok=True)
        force = found["inner_force"]
        assert force.dimensions == ("point", "time", "roller") and np.isnan(force._FillValue)
    with xarray.open_dataset(KEPT / "study.nc") as found:
        assert list(found.coords) == ["time"] and np.isfinite(found.inner_force).all()
        assert found.message.values.tolist() == ["", "", ""]


def test_a_study_goes_on_with_its_points_alone_not_beside_another_run_and_is_collected(here, monkeypatch, capsys):
    folder, digests = Folder(path=KEPT), points_of(GRID).digests
    with folder.held(points_of(GRID), resume=False):
        assert run(GRID, "--resume") == 2
    assert "studies/study: another run-study works there; wait for its end" in capsys.readouterr().err
    assert run(GRID, "--resume") == 0
    shutil.copy(folder.dataset, "first.nc")
    assert run(GRID) == 2 and "--resume goes on" in capsys.readouterr().err
    assert run(GRID.replace("[1500.0, 3000.0, 4500.0]", "[1000.0, 2000.0]"), "--resume") == 2
    assert "studies/study: holds another study, none of whose points is one of this study" in capsys.readouterr().err
    same(folder.dataset, "first.nc")
    (folder.path / "points" / f"{digests[1]}.point").unlink()
    (folder.path / "points" / f"{digests[4]}.point").write_bytes(b"half a file")
    solved, real = [], solving.solve
    monkeypatch.setattr(solving, "solve", lambda *given: solved.append(given[0]) or real(*given))
    assert run(GRID, "--resume") == 0 and len(solved) == 2
    same(folder.dataset, "first.nc")
    folder.page.unlink()
    folder.dataset.unlink()
    assert study_main(["--collect", str(KEPT), "--quiet"]) == 0 and len(solved) == 2
    same(folder.dataset, "first.nc")
    assert folder.page.is_file()
    assert run(GRID.replace("[1500.0, ", "[1500.0, 2000.0, "), "--resume") == 0 and len(solved) == 4
    assert len(list((KEPT / "points").iterdir())) == 8


def test_points_of_another_version_are_named_with_both_versions(here, monkeypatch, capsys):
    assert run(TWO_SPEEDS) == 0
    next((KEPT / "points").iterdir()).unlink()
    monkeypatch.setattr("fem.study.folder.program", lambda: "of-another")
    monkeypatch.setattr("fem.study.folder.VERSION", "99.0")
    assert study_main(["--collect", str(KEPT), "--quiet"]) == 1
    error, version = capsys.readouterr().err, read_json(KEPT / "study.json")["version"]
    assert f"begun by run-study {version}, program " in error and "this is run-study 99.0, program of-an" in error
    assert run(TWO_SPEEDS, "--resume") == 0 and "all points are solved again" in capsys.readouterr().err


FAILING = """
fixed = { "bearing.type" = "ball", "lagrange.law" = "hertz", "numerics.duration_ms" = 0.5 }
parameters = { "operation.radial_load_N" = [1000.0, 2000.0], model = ["lagrange", "reduced"] }
keep = { quantities = ["largest_force"] }
"""


def test_what_fails_or_takes_too_long_is_collected_with_its_text(here, capsys):
    """The reduced model takes no balls, which only its plan sees. Where it refuses all, the study is not begun."""
    assert run(FAILING.replace('"lagrange", ', "")) == 2
    error = capsys.readouterr().err
    assert "point 0 (operation.radial_load_N = 1000, model = 'reduced'): " in error
    assert "cylindrical rollers only" in error and not Path("studies").exists() and run(FAILING) == 1
    first, second, third = capsys.readouterr().err.splitlines()[-3:]  # --quiet keeps no reason back
    assert first == "4 points: 2 complete, 2 failed" and "model = 'reduced'" in third
    assert "'reduced'): failed: " in second and "cylindrical rollers only" in second
    with xarray.open_dataset(KEPT / "study.nc") as found:
        failed, sound = found.sel(model="reduced"), found.sel(model="lagrange")
        assert np.all(failed.status == "failed") and np.all(np.isnan(failed.largest_force))
        assert "cylindrical rollers only" in str(failed.message.values.ravel()[0])
        assert np.all(sound.status == "complete") and np.all(sound.largest_force > 0.0)
    assert run(GRID + "[limits]\nseconds_per_point = 1e-6\n", "--output", "slow") == 1
    with xarray.open_dataset("slow/study.nc") as found:
        assert np.all(found.status == "stopped")
        assert "limits.seconds_per_point = 1e-06" in str(found.message.values[0, 0])


def test_a_full_disk_ends_the_study_and_resume_goes_on(here, monkeypatch, capsys):
    calls, real = [], write_sealed

    def full(path, data):
        calls.append(path)
        if len(calls) == 3:
            raise OSError(28, "No space left on device", str(path))
        real(path, data)

    monkeypatch.setattr("fem.study.folder.write_sealed", full)
    assert run(GRID) == 2
    error = capsys.readouterr().err
    assert "No space left on device" in error and "--resume goes on" in error
    assert run(GRID, "--resume") == 0 and run(GRID, "--output", "whole") == 0
    same(KEPT / "study.nc", "whole/study.nc")


@pytest.mark.slow
@pytest.mark.parametrize(("count", "moments", "sent"), [(12, 1, signal.SIGINT), (40, 20, signal.SIGKILL)])
def test_a_study_ended_at_any_moment_goes_on_to_the_same_dataset(here, count, moments, sent):
    Path("study.toml").write_text(many(count), encoding="utf-8")
    rng, kept = np.random.default_rng(5), KEPT / "points"
    program = f"import sys; sys.path[:0] = {PATH!r}; from fem.commands.entry import run_study; run_study()"
    for moment in range(moments):
        words = ["study.toml", "--workers", "1", *(["--quiet", "--resume"] if moments > 1 else [])]
        process = subprocess.Popen([sys.executable, "-c", program, *words], stderr=subprocess.PIPE, text=True)
        enough = len(list(kept.glob("*.point"))) + (int(rng.integers(0, 4)) if moments > 1 else 3)
        wait_until(lambda: len(list(kept.glob("*.point"))) >= enough, process, pause=0.005)  # noqa: B023
        process.send_signal(sent)
        assert process.wait(GIVE_UP) == (130 if sent == signal.SIGINT else -sent), moment
    assert sent != signal.SIGINT or "--resume goes on with the other" in process.stderr.read()
    assert run(many(count), "--resume") == 0 and run(many(count), "--output", "whole") == 0
    same(KEPT / "study.nc", "whole/study.nc")


def test_a_study_of_ratings_runs_nothing(here, monkeypatch):
    monkeypatch.setattr(solving, "simulate", None)
    names = ["rating_life", "rating_peak_pressure", "rating_moment"]
    assert run(f'[parameters]\n"operation.radial_load_N" = [1000.0, 2000.0]\n[keep]\nquantities = {names}\n') == 0
    with h5py.File(KEPT / "study.nc") as file:
        life, pressure, moment = (file[name][...] for name in names)
    answers = rating(read_scene().varied({"operation.radial_load_N": 1000.0}))
    assert life[0] == 1e6 * answers["L10r_Mrev"] and pressure[0] == 1e6 * answers["peak_pressure_MPa"] < pressure[1]
    assert np.isnan(moment).all()  # of a plane section


def test_zip_takes_values_side_by_side_a_list_those_of_a_table_and_a_base_may_lack_what_every_point_gives(here):
    zipped = BASE + '[sampling]\nmethod = "zip"\n[parameters]\n"operation.speed_rpm" = [1000, 2000]\n'
    assert points_of(zipped + '"operation.radial_load_N" = [500, 900]\n').design.points == [(1000, 500), (2000, 900)]
    header = 'operation.speed_rpm,spall.0.body,"spall.0.width_mm"\n'
    Path("points.csv").write_text(header + "1000,,\n1000,outer_ring,1.5\n2000,inner_ring,2\n")
    listed, folder = points_of(BASE + LIST), Folder(path=Path("out"))
    assert [[(spall.body, spall.width_mm) for spall in listed.scene(i).spall] for i in range(3)] == [
        [], [("outer_ring", 1.5)], [("inner_ring", 2.0)]]  # fmt: skip
    assert listed.design.names == ("speed_rpm", "body", "width_mm")
    folder.begin(listed)
    _, body, width = table_of(listed, write_dataset(listed, folder)).parameters
    with xarray.open_dataset(folder.dataset, engine="netcdf4") as dataset:
        assert dataset.body.values.tolist() == ["", "outer_ring", "inner_ring"]
    assert body.words[0] == "-" and np.isnan(width.values[0]) and width.values[2] == 2.0
    Path("base.toml").write_text('model = "reduced"\n[axial]\nroller_profile = "crowned"\n', encoding="utf-8")
    Path("points.csv").write_text("axial.crown_um\n4.0\n8.0\n", encoding="utf-8")
    for sampling in ('[parameters]\n"axial.crown_um" = [4.0, 8.0]\n', LIST):
        points = points_of('scene = "base.toml"\n' + sampling)
        assert [points.scene(i).axial.crown_um for i in range(2)] == [4.0, 8.0]
    Path("points.csv").write_text("axial.crown_um,axial.slices\n4.0,5\n,7\n", encoding="utf-8")
    with pytest.raises(SceneError, match="needs crown_um"):
        points_of('scene = "base.toml"\n' + LIST)


DRAWN = f"""sampling = {{ method = "lhs", samples = 128, seed = 3 }}
{BASE}
[parameters]
"operation.speed_rpm" = {{ from = 1000.0, to = 3000.0 }}
"material.youngs_modulus_GPa" = {{ normal = [210.0, 5.0] }}
"operation.radial_load_N" = {{ from = 100.0, to = 1000.0, scale = "log" }}
"bearing.rollers" = {{ from = 9, to = 12 }}
"bearing.roller_length_mm" = [9.0, 10.0]
"""


@pytest.mark.parametrize("method", ["lhs", "sobol"])
def test_drawn_points_follow_their_distributions(method, here):
    """Kolmogorov and Smirnov's distance of 128 even points is of the order 1/128; random ones have 0.12."""
    text = DRAWN.replace('"lhs"', f'"{method}"')
    design = points_of(text).design
    speed, modulus, load, rollers, length = (np.array(column) for column in zip(*design.points, strict=True))
    laws = stats.uniform(1000.0, 2000.0), stats.norm(210.0, 5.0), stats.loguniform(100.0, 1000.0)
    for column, law in zip((speed, modulus, load), laws, strict=True):
        assert stats.kstest(column, law.cdf).statistic < 0.02
    assert np.unique(rollers, return_counts=True)[1] == pytest.approx([32] * 4, abs=1)
    assert np.unique(length, return_counts=True)[1] == pytest.approx([64] * 2, abs=1)
    assert points_of(text).design.points == design.points
    assert points_of(text.replace("seed = 3", "seed = 4")).design.points != design.points
    if method == "sobol":  # matrices of its indices differ in one column each
        points = points_of(text.replace('"sobol"', '"sobol", indices = true').replace("= 128", "= 8")).design.points
        A, B, *mixed = (points[8 * k : 8 * (k + 1)] for k in range(7))
        for i, AB in enumerate(mixed):
            assert AB == [(*a[:i], b[i], *a[i + 1 :]) for a, b in zip(A, B, strict=True)]


def test_dry_run_tells_the_cost_and_writes_nothing_and_the_built_in_scene_is_left_as_it_is(here, capsys):
    """A study of nothing but its scene is run-fem's scene: varying must not spell anything differently."""
    assert points_of('[parameters]\n"operation.speed_rpm" = [4500.0]\n').scene(0).to_toml() == read_scene().to_toml()
    Path("study.toml").write_text(GRID, encoding="utf-8")
    assert study_main(["study.toml", "--dry-run"]) == 0
    out = capsys.readouterr().out
    for word in ("6 (grid, 3 × 2), 6 to be solved", "processor time", "memory", "disk", "this process"):
        assert word in out
    assert os.listdir() == ["study.toml"]
    base = points_of(GRID).digests  # by which points are known: of the scene and of what is kept
    assert len(set(base)) == 6 and points_of(GRID + "[limits]\nseconds_per_point = 5\n").digests == base
    assert not set(points_of(GRID.replace("hub_mean_y", "hub_mean_x")).digests) & set(base)


def test_a_clearance_is_varied_as_it_is_written_and_a_folder_gives_the_scenes_that_were_studied(here):
    """It becomes the outer raceway's diameter, which must not stand in the way of the next one's; tables as written."""
    Path("speeds.csv").write_text("time_ms,speed_rpm\n0,1000\n100,2000\n", encoding="utf-8")
    Path("loads.csv").write_text("time_ms,x_N,y_N\n0,0,-500\n100,0,-900\n", encoding="utf-8")
    tables = '[operation]\nspeed_table = "speeds.csv"\nload_table = "loads.csv"\n'
    varied = 'scene = "base.toml"\n[parameters]\n"bearing.clearance_um" = [10.0, 40.0]\n'
    for base in ('designation = "NU206"\nclearance_um = 30.0\n', "clearance_um = 30.0\n" + tables):
        Path("base.toml").write_text(f"[bearing]\n{base}", encoding="utf-8")
        points = points_of(varied)
        low, high = (points.scene(i).ideal_bearing().radial_clearance for i in range(2))
        assert high - low == pytest.approx(15e-6)
        Folder(path=Path("s")).begin(points)
        again = Folder(path=Path("s")).points()
        assert [again.scene(i) for i in range(2)] == [points.scene(i) for i in range(2)]
        assert again.scene(1).ideal_bearing().radial_clearance == high
    grown = read_scene(None, ("bearing.clearance_um=20",)).varied({"bearing.clearance_um": 50.0, "spall.0.width_mm": 1})
    assert grown.ideal_bearing().radial_clearance == pytest.approx(25e-6)


@pytest.fixture(scope="module")
def solved_once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "s.toml").write_text(TWO, encoding="utf-8")
    assert study_main([str(folder / "s.toml"), "--output", str(folder / "s"), "--workers", "1", "--quiet"]) == 0
    return folder / "s"


@pytest.fixture
def study_folder(solved_once, tmp_path):
    return shutil.copytree(solved_once, tmp_path / "s")


def in_a_pipe(path):
    path.unlink()
    os.mkfifo(path)


def seal(path, **arrays):
    np.savez(archive := io.BytesIO(), **arrays)
    write_sealed(path, archive.getvalue())


def refused(folder, words, capsys):
    assert study_main(["--collect", str(folder), "--quiet"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and words in error and len(error) < 5000, error


FACTS = {  # what is put into study.json or done to it, and what must be told
    "digests that lead elsewhere": ({"digests": ["../../x"] * 2}, "digests.0: String should match"),
    "digests without points": ({"digests": ["0" * 32] * 6}, "as many digests as points"),
    "axes that are none": ({"axes": "abc"}, "axes: "),
    "axes that make other points": ({"axes": [[1] * 1000]}, "axes: must make the points"),
    "keys that are none": ({"keys": [1]}, "keys.0: "),
    "no name": ({"name": None}, "name: "),
    "a program that is none": ({"made_by": {"a": 1}}, "made_by: "),
    "a study of thirty thousand tables": ({"study": "a." * 30_000 + "a = 1"}, "a key of more than 50 parts"),
    "a speed that is no number": ({"points": [[float("nan")]] * 2}, "points.0.0."),
    "one that nests": (lambda about: about.write_text("[" * 10**5, encoding="utf-8"), "recursion limit"),
    "a pipe": (in_a_pipe, "not a plain file"),
}


@pytest.mark.parametrize(("change", "words"), list(FACTS.values()), ids=FACTS)
def test_a_study_that_can_not_be_is_refused(change, words, study_folder, capsys):
    about = study_folder / "study.json"
    if callable(change):
        change(about)
    else:
        about.write_text(json.dumps(read_json(about) | change), encoding="utf-8")
    refused(study_folder, words, capsys)


POINTS = {
    "no archive": lambda path: write_sealed(path, b"hello"), "no facts": lambda path: seal(path, a=np.zeros(1)),
    "a pipe": in_a_pipe, "another seal": lambda path: path.write_bytes(path.read_bytes()[:50]),
}  # fmt: skip


@pytest.mark.parametrize("change", list(POINTS.values()), ids=POINTS)
def test_a_point_that_can_not_be_is_left_out(change, study_folder, capsys):
    for path in (study_folder / "points").iterdir():
        change(path)
    assert study_main(["--collect", str(study_folder)]) == 1
    out, error = capsys.readouterr()
    assert "2 points: 2 missing" in out and "Traceback" not in error and "Warning" not in error


def test_a_point_is_known_by_what_is_sealed_and_not_by_its_name(solved_once, study_folder, capsys):
    first, second = sorted((study_folder / "points").iterdir())
    shutil.copy(first, second)
    assert study_main(["--collect", str(study_folder)]) == 1
    assert "2 points: 1 complete, 1 missing" in capsys.readouterr().out
    assert study_main([str(solved_once.parent / "s.toml"), "--output", str(study_folder), "--resume", "--quiet"]) == 0
    assert first.read_bytes() != second.read_bytes()
    with np.load(io.BytesIO(read_sealed(first))) as found:
        seal(first, facts=found["facts"], inner_ay=found["inner_ay"][:7])
    refused(study_folder, "its signals have another length than those of other points", capsys)


GOOD = '[sampling]\nmethod = "grid"' + TWO_SPEEDS
SPEED, RANGE, MANY = '"operation.speed_rpm" = [1500, 3000]', "[1500, 3000]", "{ from = 1, to = 2, count = 9999 }"


def change(old, new, *more):
    """The study with some text in place of other; pairs of them."""
    text = GOOD
    for before, after in ((old, new), *zip(more[::2], more[1::2], strict=True)):
        assert before in text
        text = text.replace(before, after)
    return text


VALUES = {  # of "operation.speed_rpm", and what must be told
    "[1500, -3e9, 3000, 4e9]": "error: point 1 (operation. & \npoint 3 (operation.", "[1, 1]": "1 is there twice",
    '{ from = 1, to = 2, count = 3, scale = "sqrt" }': ".scale = 'sqrt'", "{ normal = [1, 2, 3, 4] }": "4 arguments",
    "{ from = 2, to = 1, count = 3 }": "from = 2 must be below to = 1", "[[1], [2]]": "is no value of a scene",
    "{ from = 1, to = 2 }": "needs a list or a range with a count", "{ normal = [1500, 5] }": "needs a list or a range",
    "{ gauss = [1500, 5] }": ".gauss: no range and no continuous", "{ normal = [1, 2], gamma = [1] }": "must be a list",
    "{ from = 2, count = 3 }": '"operation.speed_rpm".to = None', "{ normal = [1500, -5] }": "outside the distribution",
    '{ from = 0, to = 2, count = 3, scale = "log" }': "above 0", "1500": '"operation.speed_rpm" = 1500: must be a list',
    "{ from = 1, to = 2, count = 1 }": ".count = 1: must be", "{ from = 1, to = 2, cuont = 5 }": ".cuont: unknown key",
    "[1500, 3e9]": "point 1 (operation.speed_rpm = 3e+09)", '[1500, "fast"]': "operation.speed_rpm = 'fast'",
    "{ uniform = [1, 2] }": "write { from", "[nan]": "nan is no value of a scene", "[]": "holds 0 values",
}  # fmt: skip
METHODS = {  # in place of "grid"
    '"lhs"\nsamples = 4\nindices = true': "indices = true: only for", '"random"': "sampling.method = 'random'",
    '"sobol"\nsamples = 100': "samples = 100: a Sobol sequence", '"lhs"\nsamples = 4\nseed = -1': "sampling.seed = -1",
    '"lhs"\nsamples = 10000000': "sampling.samples = 10000000", '"grid"\nfile = "a.csv"': "file: a CSV table of points",
    '"grid"\nsamples = 4': "sampling: samples = 4: only for", '"list"\nfile = "a.csv"': "[parameters]: with method",
    '"list"': "file: a CSV table of points", '"lhs"': "sampling: samples: missing",
}  # fmt: skip
SPEEDS = {  # in place of the line of the speed
    '"operation.spede_rpm" = [1]': "did you mean speed_rpm", '"operatin.speed_rpm" = [1]': "did you mean operation",
    '"operation" = [1, 2]': "operation = 1: must be a table", "": "[parameters]: empty",
    '"profile.0.file" = ["a.csv", "b.csv"]': "files of a scene can't be varied",
    "operation.speed_rpm = [1]": "dotted keys of the scene are quoted",
}  # fmt: skip
ADDED = {  # at the end, where quantities are kept
    'signals = ["inner_ay"]\nsignal_rate_kHz = 200.0': "samples are stored at 100",
    'signals = ["inner_ay"]\nsignal_rate_kHz = 0.5': "keeps one of 200 samples, but",
    'signals = ["inner_ay"]\nsignal_rate_kHz = 1e-320': "signal_rate_kHz = 1e-320",
    'signals = ["inner_az"]': "keep.signals: 'inner_az' is no signal", "signal_rate_kHz = 1.0": "there are no signals",
    "[limits]\nseconds_per_point = 0": "limits.seconds_per_point = 0", "[kept]": "kept: unknown key; did you mean keep",
}  # fmt: skip
BAD = {new: (change(old, new), words) for old, table in ((RANGE, VALUES), ('"grid"', METHODS), (SPEED, SPEEDS))
       for new, words in table.items()} | {more: (GOOD + more, words) for more, words in ADDED.items()}  # fmt: skip
BAD |= {  # what is wrong: the study and what must be told
    "not TOML": ("[sampling", "not valid TOML"), "a name that is none": ('name = "../x"\n' + GOOD, "name = '../x'"),
    "a scene that is missing": ('scene = "none.toml"\n' + GOOD, "none.toml: no such file"),
    "unknown key of sampling": (change('method = "grid"', "metod = 1"), "sampling.metod: unknown key; did you mean"),
    "list that is missing": (change(SPEED, "").replace('"grid"', '"list"\nfile = "a.csv"'), "a.csv: can't be read"),
    "a key fixed and varied": (change("model =", '"operation.speed_rpm" = 1\nmodel ='), "stands in [fixed] and in"),
    "lengths of a zip": (change('"grid"', '"zip"', SPEED, SPEED + '\n"operation.radial_load_N" = [1]'), "as many"),
    "motion of a bearing at rest": (change("_ms\" = 1.0", "_ms\" = 0.0"), "a run at rest has only the quantities"),
    "unknown quantity": (change("hub_mean_y", "hub_mean_z"), "'hub_mean_z' is unknown; did you mean hub_mean_"),
    "quantities that are no names": (change('["hub_mean_y"]', "[1, 2]"), "keep.quantities.1 = 2: "),
    "quantity twice": (change('["hub_mean_y"]', '["hub_mean_y", "hub_mean_y"]'), "is there twice"),
    "count of a draw": (change('"grid"', '"lhs"\nsamples = 4', RANGE, MANY), "count is only"), "too many points": (
        change(RANGE, MANY, "[keep]", f'"operation.radial_load_N" = {MANY}\n[keep]'), "99,980,001 points; at most"),
    "signals of other lengths": (
        change(SPEED, '"numerics.duration_ms" = [1.0, 2.0]').replace('"numerics.duration_ms" = 1.0', "", 1)
        + 'signals = ["inner_ay"]', "signals must have the same length in every point"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "words"), list(BAD.values()), ids=BAD)
def test_is_refused_by_its_key(text, words, here, capsys):
    assert run(text) == 2
    error = capsys.readouterr().err
    assert all(each in error for each in words.split(" & ")) and "Traceback" not in error, error
    assert not Path("studies").exists()


@pytest.mark.parametrize(("words", "told"), [
    ("", "name a study file"), ("study.toml --workers 0", "--workers 0"),
    ("study.toml --workers 2 --scheduler tcp://x:1", "its own workers"),
    ("study.toml --export shards", "training sets are no longer exported; study.nc holds"),
    ("--collect nowhere", "nowhere: no study"), ("--collect . --resume", "--collect solves nothing"),
    ("study.toml --output study.toml", "is a file, not a folder"),
    ("study.toml --output other", "other: not empty and no study"), ("none.toml", "none.toml: can't be read"),
])  # fmt: skip
def test_unusable_options_are_refused(words, told, here, capsys):
    Path("study.toml").write_text(GOOD, encoding="utf-8")
    Path("other").mkdir()
    Path("other/mine.txt").write_text("mine", encoding="utf-8")
    assert study_main([*words.split(), "--quiet"]) == 2 and told in capsys.readouterr().err
    assert Path("other/mine.txt").read_text(encoding="utf-8") == "mine"


MADE_UP = """
sampling = {{ {sampling} }}
keep = {{ quantities = ["largest_force", "hub_mean_y"] }}
[parameters]
"operation.speed_rpm" = {speed}
"operation.radial_load_N" = {load}
"bearing.roller_length_mm" = {length}
"""
OF_GRID = dict(sampling="", speed="[1, 2, 3]", load="[10, 20]", length="[8.0, 9.0, 10.0, 11.0]")
OF_DRAWN = dict(sampling='method = "sobol", samples = 64, indices = true', speed="{ from = -1.0, to = 1.0 }",
                load="{ from = 0.0, to = 1.0 }", length="{ from = 9.0, to = 11.0 }")  # fmt: skip
FORCE, HUB = "largest force on the inner raceway, N", "mean position of the hub, y, µm"


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """Gives the table of a study whose largest force is a function of speed, load and length, and its page's text."""
    monkeypatch.chdir(tmp_path)  # pages with figures

    def make(force, failed=(), page=False, **values):
        points, folder = points_of(MADE_UP.format(**values)), Folder(path=Path("out"))
        folder.begin(points)
        for i, digest in enumerate(points.digests):
            quantities = {"largest_force": float(force(*points.design.points[i])), "hub_mean_y": 1e-6}
            status = dict(status=FAILED, text="<b>it broke</b>") if i in failed else dict(status=COMPLETE)
            folder.add(digest, Solved(**status, seconds=0.1, quantities={} if i in failed else quantities))
        dataset = write_dataset(points, folder)
        if page:
            write_page(points, folder, dataset)
        return table_of(points, dataset), folder.page.read_text(encoding="utf-8") if page else ""

    return make


def shares(table):
    return {column.name: share for column, share in table.strongest(table.quantities[0])}


def cells(page):  # rows of all tables, each a list of texts
    return [re.findall(r"<t[dh]>(.*?)</t[dh]>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", page, re.S)]


def test_effects_of_a_sum_share_its_variance_but_for_what_chance_explains(made_up):
    """3 s + 0.4 l + h/2 of s = 1, 2, 3, l = 10, 20, h = 8 … 11: variances 9 · 2/3, 0.16 · 25, 0.25 · 1.25.
    In a grid nothing is drawn, so no part of a small share is chance. Eight groups of 320 drawn points explain 7/319
    of a variance that knows nothing of the parameter, and the page says so."""
    table, page = made_up(lambda speed, load, length: 3.0 * speed + 0.4 * load + 0.5 * length, page=True, **OF_GRID)
    whole = 6.0 + 4.0 + 0.3125
    expected = {"speed_rpm": 6.0 / whole, "radial_load_N": 4.0 / whole, "roller_length_mm": 0.3125 / whole}
    assert shares(table) == pytest.approx(expected, abs=1e-12) and "chance" not in page
    found = shares(made_up(lambda speed, load, length: speed**2, **OF_GRID)[0])  # explained by it alone
    assert found["speed_rpm"] == pytest.approx(1.0) and found["radial_load_N"] == found["roller_length_mm"] == 0.0
    rng = np.random.default_rng(3)
    table, page = made_up(lambda *_: rng.normal(), page=True, **OF_DRAWN)
    assert max(shares(table).values()) < 0.04 and "chance" in page
    assert ["largest force on the inner raceway", "radial load"] in [row[:2] for row in cells(page)]
    assert re.findall('<figure id="([^"]*)"', page) == ["main-effects", "heat-map", "scatter-matrix", "sobol-indices"]


def test_sobol_indices_are_those_of_a_function_whose_variance_is_known(made_up):
    """3 x + 2 y + z + 3 x y, each even over a width of 2: the terms have variances 3, 4/3, 1/3 and 1."""
    table, _ = made_up(lambda x, y, z: 3.0 * x + 2.0 * (2.0 * y - 1.0) + z + 3.0 * x * (2.0 * y - 1.0), **OF_DRAWN)
    first, total = table.sobol_indices(table.quantities[0])
    whole = 3.0 + 4.0 / 3.0 + 1.0 / 3.0 + 1.0
    assert len(table.points) == 5 * 64
    assert first == pytest.approx(np.array([3.0, 4.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert total == pytest.approx(np.array([4.0, 7.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert table.sobol_indices(table.quantities[1]) is None  # it never changes


def test_pages_have_a_line_for_each_value_a_table_of_points_and_what_can_be_told(made_up):
    _, page = made_up(lambda speed, load, length: speed + load, failed=(5,), page=True, **OF_GRID)
    assert "Varied: speed, radial load, roller length; 23 of 24 points are complete" in page
    assert "&lt;b&gt;it broke&lt;/b&gt;" in page and "point 5 (operation.speed_rpm = 1" in page
    assert re.findall('<figure id="([^"]*)"', page) == ["lines"]
    for row in (
        [HUB, "1", "1", "23", "-"], ["point", "speed, rpm", "radial load, N", "roller length, mm", FORCE, HUB],
        ["0", "1", "10", "8", "11", "1"], ["5", "1", "20", "9", "-", "-"],
    ):  # fmt: skip
        assert row in cells(page)
    assert "http" not in page.split("<pre>")[0].replace("http://www.w3.org", "")
    one = OF_GRID | {"load": "[10]", "length": "[8.0]"}
    _, page = made_up(lambda speed, *_: 100.0 * speed, page=True, **one)
    assert [FORCE, "100", "300", "3"] in cells(page) and "variance" not in page
    _, page = made_up(lambda speed, *_: np.nan if speed < 3.0 else speed, page=True, **OF_GRID)
    assert [FORCE, "3", "3", "8", "-"] in cells(page)
    _, page = made_up(lambda *_: 1.0, failed=range(24), page=True, **OF_GRID)
    assert "0 of 24 points are complete" in page and "Too few complete points" in page


@pytest.mark.parametrize(("speed", "length"), [("[2]", "[8.0]"), ("[1, 2, 3]", "[8.0]"), ("[1, 2, 3]", "[8.0, 9.0]")])
def test_lines_of_a_grid_go_through_every_point(made_up, speed, length, monkeypatch):
    """A mean over loads would be of no bearing."""
    scene, seen = OF_GRID | dict(speed=speed, load="[250, 500, 1000, 2000]", length=length), []
    table, _ = made_up(lambda speed, load, length: speed * load + length, **scene)
    monkeypatch.setattr(figures, "finished", lambda figure, *_: seen.append(figure))
    figures.study_figures(table, [])
    drawn = np.concatenate([line.get_ydata() for axis in seen[0].axes for line in axis.lines])
    assert len(seen) == 1 and sorted(drawn) == sorted(table.quantities[0].values)


@pytest.fixture
def script(here, monkeypatch):
    shutil.copytree(DOCS / "studies", here, dirs_exist_ok=True)

    def run(name, *words):
        monkeypatch.setattr(sys, "argv", [name, *words])
        runpy.run_path(name, run_name="__main__")

    return run


def test_the_studies_of_the_docs_are_studies(script):
    (block,) = blocks(DOCS / "studies.md", "toml")
    assert run_main(["--example", "NU206"]) == 0
    found = points_of(block, "shown.toml")
    assert found.design.shape == (2, 3, 2, 2) and found.study.name == "clearance"
    # what is commented out can be taken in
    drawn = block.replace('"grid"', '"sobol"').replace("# samples", "samples").replace("# seed", "seed")
    drawn = drawn.replace("# indices", "indices").replace('# "material', '"material')
    assert len(points_of(re.sub(r", count = \d+", "", drawn), "drawn.toml")) == 64 * (5 + 2)
    assert [len(points_of(name=f"{name}.toml")) for name in ("clearance", "widths", "profiles")] == [42, 84, 28]
    script("spalls.py", "8")
    found = points_of(name="spalls.toml")
    bodies = ["none" if not (spalls := found.scene(i).spall) else spalls[0].body for i in range(8)]
    assert bodies == ["none", "outer_ring", "inner_ring", "roller"] * 2


@pytest.mark.slow
def test_the_programs_of_the_examples_run(script, capsys):
    pytest.importorskip("sklearn")
    script("spalls.py", "16")
    Path("docs").mkdir()
    shutil.move("clearance.py", "docs/clearance.py")
    text = Path("clearance.toml").read_text().replace("count = 7", "count = 2").replace("count = 6", "count = 2")
    Path("clearance.toml").write_text(text)
    for name in ("clearance", "spalls"):
        assert study_main([f"{name}.toml", "--quiet", "--workers", "1"]) == 0
    script("docs/clearance.py")
    script("spalls.py")
    assert "of 8 right" in capsys.readouterr().out


TWO = TWO_SPEEDS + 'signals = ["inner_ay"]\n'
DEED = """
from fem.solver.rigid.state import LagrangianState

def advance(state, most, real=LagrangianState.advance):
    if state.plan.scene.operation.speed_rpm == 3000.0:
        {deed}
    return real(state, most)

LagrangianState.advance = advance
"""
STUDIED = """
from fem.commands.run_study import study_main
if __name__ == "__main__":
    from fem.study import solving
    solving.GRACE = 3.0
    sys.exit(study_main(["study.toml", "--quiet", "--workers", "2"]))
"""
HANG = "import ctypes; ctypes.PyDLL(None).sleep(3600)"  # keeps even the interpreter's lock: it answers nobody


def child(text, deed):
    Path("study.toml").write_text(text, encoding="utf-8")
    program = f"import sys\nsys.path[:0] = {PATH!r}\n{DEED.format(deed=deed)}{STUDIED}"
    Path("run.py").write_text(program, encoding="utf-8")  # the processes begin with it, too
    return subprocess.Popen([sys.executable, "run.py"], stderr=subprocess.PIPE, text=True)


def is_as_by_one_process(text):
    assert run(text, "--output", "here") == 0
    same("studies/study/study.nc", "here/study.nc")


def listening(pid):  # ports on which a process takes connections
    links = (os.readlink(link) for link in Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink())
    sockets = {link.removeprefix("socket:[").rstrip("]") for link in links if link.startswith("socket:")}
    rows = [row.split() for name in ("tcp", "tcp6") for row in Path(f"/proc/net/{name}").read_text().splitlines()[1:]]
    return [row[1] for row in rows if row[3] == "0A" and row[9] in sockets]


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="Linux tells who listens")
def test_processes_give_what_one_gives_and_nobody_can_connect_to_them(here, monkeypatch):
    opened, processes, real = [], set(), Folder.add

    def add(*given):
        pids = [os.getpid(), *(child.pid for child in multiprocessing.active_children())]
        processes.update(pids)
        opened.extend(port for pid in pids for port in listening(pid))
        return real(*given)

    monkeypatch.setattr(Folder, "add", add)
    assert run(TWO, workers=("--workers", "2")) == 0
    assert len(processes) == 3 and not opened and not multiprocessing.active_children()
    is_as_by_one_process(TWO)


@pytest.mark.slow
@pytest.mark.parametrize(("deed", "status"), [
    ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "missing"), (HANG, "stopped"),
])  # fmt: skip
def test_a_process_that_dies_or_hangs_costs_its_own_point(deed, status, here):
    process = child(GRID + "[limits]\nseconds_per_point = 20.0\n", deed)
    _, error = process.communicate()
    assert process.returncode == 1
    assert status == "stopped" or "its process died (exit code -9)" in error
    with xarray.open_dataset(KEPT / "study.nc") as found:
        assert (found.sel(speed_rpm=3000.0).status == status).all()
        assert (found.drop_sel(speed_rpm=3000.0).status == "complete").all()


@pytest.mark.slow
def test_processes_end_with_an_interrupted_study(here):
    process = child(GRID, "import time; time.sleep(3600)")
    wait_until(lambda: len(list(KEPT.glob("points/*.point"))) == 2, process)
    mine = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.send_signal(signal.SIGINT)
    assert process.wait(30) == 130 and "--resume goes on with the other 4" in process.stderr.read()
    places = [Path(f"/proc/{pid}/cmdline") for pid in mine]
    wait_until(lambda: not any(place.exists() and place.read_bytes() for place in places))  # empty: not asked for yet


@pytest.fixture
def cluster(tmp_path):
    """Options that name a scheduler, and what starts a worker of it by the tests' own import path."""
    pytest.importorskip("distributed")
    running, file, local = [], tmp_path / "scheduler.json", ("--no-dashboard", "--host", "127.0.0.1")

    def start(program, *words):
        command = [sys.executable, "-m", f"distributed.cli.{program}", *words]
        with open(tmp_path / f"log-{len(running)}", "w", encoding="utf-8") as log:
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(PATH)}
            running.append(subprocess.Popen(command, stderr=log, stdout=log, env=environment))
        return running[-1]

    def worker(*words):
        return start("dask_worker", address, "--nthreads", "1", "--no-dashboard", *(words or ("--no-nanny",)))

    start("dask_scheduler", "--port", "0", "--scheduler-file", str(file), *local)
    wait_until(lambda: file.exists() and file.read_text().endswith("}"))
    address = read_json(file)["address"]
    yield ("--scheduler", address), worker
    for process in reversed(running):
        process.kill()  # they hold nothing, and a worker without its scheduler waits long
    for process in running:
        process.wait(GIVE_UP)


def test_two_workers_of_a_scheduler_give_what_one_process_gives(here, cluster):
    scheduler, worker = cluster
    _ = worker(), worker()
    assert run(TWO, workers=scheduler) == 0
    is_as_by_one_process(TWO)


def test_what_is_no_scheduler_is_named_and_dask_asked_for_before_any_work(here, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.setattr("fem.study.solving.CONNECT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        hangs = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in ("tcp://127.0.0.1:9", hangs, "tls://127.0.0.1:9", "ucx://a", "inproc://x", "tcp://", ""):
            assert run(GRID, workers=("--scheduler", address)) == 2
            error = capsys.readouterr().err
            assert f"--scheduler {address}: does not answer: " in error and not error.endswith(": \n")
    monkeypatch.setattr("fem.commands.start_up.find_spec", lambda name: None)
    for more in ((), ("--dry-run",)):
        assert study_main(["study.toml", "--scheduler", "tcp://127.0.0.1:8786", *more]) == 2
        error = capsys.readouterr().err
        assert "--scheduler: needs distributed" in error and "python -m pip install distributed" in error
    assert os.listdir() == ["study.toml"]  # the study has not begun


@pytest.mark.slow
def test_points_of_a_killed_worker_are_solved_by_another(here, cluster):
    scheduler, worker = cluster
    first, _ = worker(), worker()

    def kill():
        wait_until(lambda: len(list(KEPT.glob("points/*.point"))) > 5)
        first.send_signal(signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    assert run(many(40), workers=scheduler) == 0
    thread.join()
    assert first.wait(GIVE_UP) == -signal.SIGKILL
    is_as_by_one_process(many(40))


@pytest.mark.slow
def test_a_point_that_hangs_in_compiled_code_ends_by_its_limit_and_the_study_goes_on(here, cluster, monkeypatch):
    scheduler, worker = cluster
    monkeypatch.setattr("fem.study.solving.GRACE", 3.0)
    Path("hanging.py").write_text(DEED.format(deed=HANG), encoding="utf-8")
    worker("--preload", str(here / "hanging.py"))
    assert run(GRID + "[limits]\nseconds_per_point = 2.0\n", workers=scheduler) == 1
    with xarray.open_dataset(KEPT / "study.nc") as found:
        hung = found.sel(speed_rpm=3000.0)
        assert (hung.status == "stopped").all()
        assert all("hung in compiled code" in str(text) for text in hung.message.values.ravel())
        assert (found.drop_sel(speed_rpm=3000.0).status == "complete").all()

"""Studies: the same results as run-fem, points of each method, what fails, and going on after any end."""

import json
import os
import signal
import subprocess
import sys
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
from fem.study.folder import Folder
from fem.study.sampling import design_of
from fem.study.solving import checked_points
from fem.study.study_file import read_study
from lagrange.scene.scene import SceneError, read_scene
from tests.reference.small_study import BASE, GRID, many, same
from tests.waiting import GIVE_UP, wait_until


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder of its own; pages are made without figures, which take most of the time and are tested elsewhere."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return tmp_path


def run(text, *words, name="study.toml"):
    Path(name).write_text(text, encoding="utf-8")
    return study_main([name, "--quiet", "--workers", "1", *words])


def points_of(text, name="study.toml"):
    Path(name).write_text(text, encoding="utf-8")
    study = read_study(Path(name))
    return checked_points(study, design_of(study))


def test_a_point_is_what_run_fem_gives_bit_for_bit(here):
    assert run(GRID, "--keep-runs") == 0
    points = points_of(GRID)
    scene = points.scene(3)
    assert scene.operation.speed_rpm == 3000.0 and scene.bearing.outer_raceway_diameter_mm == 56.02
    Path("scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert run_main(["scene.toml", "--quiet", "--output", "run.nc"]) == 0
    kept = Folder(path=Path("studies/study")).run(points.digests[3])
    with h5py.File("run.nc") as command, h5py.File(kept) as point:
        for name in command:
            assert command[name][...].tobytes() == point[name][...].tobytes(), name
    with h5py.File("run.nc") as command, xarray.open_dataset("studies/study/study.nc") as found:
        at = found.sel(speed_rpm=3000.0, outer_raceway_diameter_mm=56.02)
        assert float(at.largest_force) == command["inner_force"][:].max()
        assert float(at.hub_mean_y) == np.trapezoid(command["inner_y"][:], command["time"][:]) / command["time"][-1]
        assert at.inner_ay.dims == ("time",) and at.inner_force.dims == ("time", "roller")
        assert float(at.time[1]) == pytest.approx(4e-5)  # of 10 µs, decimated to 25 kHz


def test_the_dataset_says_what_it_is(here):
    assert run(GRID) == 0
    with xarray.open_dataset("studies/study/study.nc") as found:
        assert found.sizes["speed_rpm"] == 3 and found.sizes["outer_raceway_diameter_mm"] == 2
        assert found.speed_rpm.attrs["units"] == "rpm" and found.largest_force.attrs["units"] == "N"
        assert np.all(found.status == "complete") and found.attrs["seed"] == 0
        assert found.attrs["study"] == GRID and set(json.loads(found.attrs["libraries"])) >= {"numpy", "numba"}
        lines = found.BPFO_Hz.isel(outer_raceway_diameter_mm=0).values
        assert lines == pytest.approx(13 * np.array([25.0, 50.0, 75.0]) * 18.0 / 46.0)
        assert np.all(found.spall_body == "none")


def test_words_empty_cells_and_signals_of_a_list_are_as_other_readers_have_them(here):
    Path("points.csv").write_text("operation.speed_rpm,lagrange.law\n1500,harris\n,palmgren\n3000,\n")
    text = BASE + '[sampling]\nmethod = "list"\nfile = "points.csv"\n[keep]\nsignals = ["inner_force"]\n'
    assert run(text) == 0
    with netCDF4.Dataset("studies/study/study.nc") as found:
        assert {name: len(each) for name, each in found.dimensions.items()} == {"point": 3, "time": 101, "roller": 13}
        assert "point" not in found.variables and found["law"].dimensions == ("point",)
        assert found["law"][:].tolist() == ["harris", "palmgren", ""]
        assert found["speed_rpm"][:].filled(np.nan).tolist() == pytest.approx([1500.0, np.nan, 3000.0], nan_ok=True)
        force = found["inner_force"]
        assert force.dimensions == ("point", "time", "roller") and np.isnan(force._FillValue)
    with xarray.open_dataset("studies/study/study.nc") as found:
        assert list(found.coords) == ["time"] and np.isfinite(found.inner_force).all()
        assert found.message.values.tolist() == ["", "", ""]


def test_dask_is_asked_for_before_any_work(here, monkeypatch, capsys):
    words = "--scheduler", "tcp://127.0.0.1:8786"
    monkeypatch.setattr("fem.commands.start_up.find_spec", lambda name: None)
    for more in ((), ("--dry-run",)):
        assert study_main(["study.toml", *words, *more]) == 2
        told = capsys.readouterr().err
        assert f"{words[0]}: needs distributed" in told and "python -m pip install distributed" in told
    assert list(here.iterdir()) == []


def test_collect_makes_the_same_dataset_and_page_without_solving(here, monkeypatch):
    assert run(GRID) == 0
    folder = Folder(path=Path("studies/study"))
    folder.dataset.rename("first.nc")
    folder.page.unlink()
    monkeypatch.setattr("fem.study.running.solve", lambda *_: pytest.fail("a point was solved"))
    assert study_main(["--collect", "studies/study", "--quiet"]) == 0
    same(folder.dataset, "first.nc")
    assert folder.page.is_file()


def test_a_study_is_not_begun_twice_and_resume_solves_what_is_missing(here, monkeypatch, capsys):
    assert run(GRID) == 0
    folder = Folder(path=Path("studies/study"))
    folder.dataset.rename("first.nc")
    assert run(GRID) == 2
    assert "--resume goes on" in capsys.readouterr().err
    digests = points_of(GRID).digests
    (folder.path / "points" / f"{digests[1]}.point").unlink()
    (folder.path / "points" / f"{digests[4]}.point").write_bytes(b"half a file")
    solved = []
    from fem.study import running

    real = running.solve
    monkeypatch.setattr(running, "solve", lambda *given: solved.append(given[0]) or real(*given))
    assert run(GRID, "--resume") == 0
    assert len(solved) == 2
    same(folder.dataset, "first.nc")


FAILING = """
[fixed]
"bearing.type" = "ball"
"lagrange.law" = "hertz"
"numerics.duration_ms" = 0.5
[parameters]
"operation.radial_load_N" = [1000.0, 2000.0]
model = ["lagrange", "reduced"]
[keep]
quantities = ["largest_force"]
"""


def test_what_fails_is_collected_with_its_text(here, capsys):
    """The reduced model takes no balls, which only its plan sees."""
    assert run(FAILING) == 1
    first, second, third = capsys.readouterr().err.splitlines()[-3:]  # --quiet keeps no reason back
    assert first == "4 points: 2 complete, 2 failed"
    assert (
        "model = 'reduced'): failed: " in second
        and "cylindrical rollers only" in second
        and "model = 'reduced'" in third
    )
    with xarray.open_dataset("studies/study/study.nc") as found:
        failed = found.sel(model="reduced")
        assert np.all(failed.status == "failed") and np.all(np.isnan(failed.largest_force))
        assert "cylindrical rollers only" in str(failed.message.values.ravel()[0])
        assert np.all(found.sel(model="lagrange").status == "complete")
        assert np.all(found.sel(model="lagrange").largest_force > 0.0)


def test_a_study_whose_plans_are_all_refused_is_not_begun(here, capsys):
    assert run(FAILING.replace('"lagrange", ', "")) == 2
    said = capsys.readouterr().err
    assert (
        "point 0 (operation.radial_load_N = 1000, model = 'reduced'): " in said and "cylindrical rollers only" in said
    )
    assert not Path("studies").exists()


def test_a_point_that_takes_too_long_is_stopped_and_said_so(here):
    text = GRID + "[limits]\nseconds_per_point = 1e-6\n"
    assert run(text) == 1
    with xarray.open_dataset("studies/study/study.nc") as found:
        assert np.all(found.status == "stopped")
        assert "limits.seconds_per_point = 1e-06" in str(found.message.values[0, 0])


def test_a_full_disk_ends_the_study_and_resume_goes_on(here, monkeypatch, capsys):
    from fem.study import folder as kept

    real, calls = kept.write_sealed, []

    def full(path, data):
        calls.append(path)
        if len(calls) == 3:
            raise OSError(28, "No space left on device", str(path))
        real(path, data)

    monkeypatch.setattr(kept, "write_sealed", full)
    assert run(GRID) == 2
    said = capsys.readouterr().err
    assert "No space left on device" in said and "--resume goes on" in said
    monkeypatch.setattr(kept, "write_sealed", real)
    assert run(GRID, "--resume") == 0
    assert run(GRID, "--output", "whole") == 0
    same("studies/study/study.nc", "whole/study.nc")


def test_zip_takes_values_side_by_side_and_a_list_those_of_a_table(here):
    zipped = BASE + '[sampling]\nmethod = "zip"\n[parameters]\n"operation.speed_rpm" = [1000, 2000]\n'
    zipped += '"operation.radial_load_N" = [500, 900]\n'
    assert points_of(zipped).design.points == [(1000, 500), (2000, 900)]
    Path("points.csv").write_text(
        'operation.speed_rpm,spall.0.body,"spall.0.width_mm"\n1000,outer_ring,1.5\n2000,inner_ring,2\n',
        encoding="utf-8",
    )
    listed = points_of(BASE + '[sampling]\nmethod = "list"\nfile = "points.csv"\n')
    assert listed.scene(1).spall[0].body == "inner_ring" and listed.scene(0).spall[0].width_mm == 1.5
    assert listed.design.names == ("speed_rpm", "body", "width_mm")


DRAWN = (
    BASE
    + """
[sampling]
method = "lhs"
samples = 128
seed = 3
[parameters]
"operation.speed_rpm" = { from = 1000.0, to = 3000.0 }
"material.youngs_modulus_GPa" = { normal = [210.0, 5.0] }
"operation.radial_load_N" = { from = 100.0, to = 1000.0, scale = "log" }
"bearing.rollers" = { from = 9, to = 12 }
"bearing.roller_length_mm" = [9.0, 10.0]
"""
)


@pytest.mark.parametrize("method", ["lhs", "sobol"])
def test_drawn_points_follow_their_distributions(method, here):
    """Kolmogorov and Smirnov's distance of 128 even points is of the order 1/128; random ones have 0.12."""
    design = points_of(DRAWN.replace('"lhs"', f'"{method}"')).design
    speed, modulus, load, rollers, length = (np.array(column) for column in zip(*design.points, strict=True))
    laws = stats.uniform(1000.0, 2000.0), stats.norm(210.0, 5.0), stats.loguniform(100.0, 1000.0)
    for column, law in zip((speed, modulus, load), laws, strict=True):
        assert stats.kstest(column, law.cdf).statistic < 0.02
    assert np.unique(rollers, return_counts=True)[1] == pytest.approx([32] * 4, abs=1)
    assert np.unique(length, return_counts=True)[1] == pytest.approx([64] * 2, abs=1)
    again = points_of(DRAWN.replace('"lhs"', f'"{method}"')).design
    assert again.points == design.points
    other = points_of(DRAWN.replace('"lhs"', f'"{method}"').replace("seed = 3", "seed = 4")).design
    assert other.points != design.points


def test_matrices_of_sobol_indices_differ_in_one_column_each(here):
    text = DRAWN.replace('"lhs"', '"sobol"\nindices = true').replace("samples = 128", "samples = 8")
    design = points_of(text).design
    A, B, *mixed = (design.points[8 * k : 8 * (k + 1)] for k in range(7))
    for i, AB in enumerate(mixed):
        for a, b, ab in zip(A, B, AB, strict=True):
            assert ab == (*a[:i], b[i], *a[i + 1 :])


def test_dry_run_tells_the_cost_and_writes_nothing(here, capsys):
    Path("study.toml").write_text(GRID, encoding="utf-8")
    assert study_main(["study.toml", "--dry-run"]) == 0
    told = capsys.readouterr().out
    for word in ("6 (grid, 3 × 2), 6 to be solved", "processor time", "memory", "disk", "this process"):
        assert word in told
    assert {path.name for path in here.iterdir()} == {"study.toml"}


def test_digests_follow_scene_and_what_is_kept(here):
    base = points_of(GRID).digests
    assert len(set(base)) == 6 and points_of(GRID).digests == base
    assert not set(points_of(GRID.replace("hub_mean_y", "hub_mean_x")).digests) & set(base)
    wider = points_of(GRID.replace("[1500.0, 3000.0, 4500.0]", "[1500.0, 3000.0, 4500.0, 6000.0]"))
    assert set(base) < set(wider.digests)  # a study that grows keeps its points
    seconds = points_of(GRID + "[limits]\nseconds_per_point = 5\n").digests
    assert seconds == base


def test_a_clearance_is_varied_as_it_is_written(here):
    """It becomes the outer raceway's diameter, which must not stand in the way of the next one's."""
    Path("base.toml").write_text('[bearing]\ndesignation = "NU206"\nclearance_um = 30.0\n', encoding="utf-8")
    points = points_of('scene = "base.toml"\n[parameters]\n"bearing.clearance_um" = [10.0, 40.0]\n')
    low, high = (points.scene(i).ideal_bearing().radial_clearance for i in range(2))
    assert high - low == pytest.approx(15e-6)
    grown = read_scene(None, ("bearing.clearance_um=20",)).varied({"bearing.clearance_um": 50.0, "spall.0.width_mm": 1})
    assert grown.ideal_bearing().radial_clearance == pytest.approx(25e-6)


def test_the_base_may_lack_a_key_that_every_point_gives(here):
    Path("base.toml").write_text('model = "reduced"\n[axial]\nroller_profile = "crowned"\n', encoding="utf-8")
    Path("points.csv").write_text("axial.crown_um\n4.0\n8.0\n", encoding="utf-8")
    for sampling in ('[parameters]\n"axial.crown_um" = [4.0, 8.0]\n', '[sampling]\nmethod="list"\nfile="points.csv"\n'):
        points = points_of('scene = "base.toml"\n' + sampling)
        assert [points.scene(i).axial.crown_um for i in range(2)] == [4.0, 8.0]
    Path("points.csv").write_text("axial.crown_um,axial.slices\n4.0,5\n,7\n", encoding="utf-8")
    with pytest.raises(SceneError, match="needs crown_um"):
        points_of('scene = "base.toml"\n' + sampling)


def test_a_folder_gives_the_scenes_that_were_studied(here):
    """A clearance and tables of speed and load stand in it as they were written."""
    Path("speeds.csv").write_text("time_ms,speed_rpm\n0,1000\n100,2000\n", encoding="utf-8")
    Path("loads.csv").write_text("time_ms,x_N,y_N\n0,0,-500\n100,0,-900\n", encoding="utf-8")
    Path("base.toml").write_text(
        '[bearing]\nclearance_um = 30.0\n[operation]\nspeed_table = "speeds.csv"\nload_table = "loads.csv"\n',
        encoding="utf-8",
    )
    points = points_of('scene = "base.toml"\n[parameters]\n"bearing.clearance_um" = [10.0, 40.0]\n')
    Folder(path=Path("s")).begin(points)
    again = Folder(path=Path("s")).points()
    assert [again.scene(i) for i in range(2)] == [points.scene(i) for i in range(2)]
    assert again.scene(1).ideal_bearing().radial_clearance == pytest.approx(20e-6)


COMMAND = "import sys; sys.path[:0] = {path!r}; from fem.commands.run_study import run_study; run_study()"


def command(*words):
    """A study as a process of its own."""
    program = COMMAND.format(path=[entry for entry in sys.path if entry])
    return subprocess.Popen([sys.executable, "-c", program, *words], stderr=subprocess.PIPE, text=True)


def ended_after(process, folder, count, number):
    """Send a signal once so many points are there."""
    wait_until(lambda: len(list(folder.glob("*.point"))) >= count, process, pause=0.005)
    process.send_signal(number)
    return process.wait(GIVE_UP)


def test_resume_goes_on_with_the_same_study_or_a_grown_one_alone(here, capsys):
    assert run(GRID) == 0
    before = Path("studies/study/study.nc").read_bytes()
    other = GRID.replace("[1500.0, 3000.0, 4500.0]", "[1000.0, 2000.0]")
    assert run(other, "--resume") == 2
    assert "studies/study: holds another study, none of whose points is one of this study" in capsys.readouterr().err
    assert Path("studies/study/study.nc").read_bytes() == before
    assert run(GRID.replace("[1500.0, ", "[1500.0, 2000.0, "), "--resume") == 0
    assert len(list(Path("studies/study/points").iterdir())) == 8


def test_two_runs_do_not_work_in_one_folder(here, capsys):
    with Folder(path=Path("studies/study")).held(points_of(GRID), resume=False):
        assert run(GRID, "--resume") == 2
    assert "studies/study: another run-study works there; wait for its end" in capsys.readouterr().err
    assert run(GRID, "--resume") == 0


@pytest.mark.slow
def test_an_interrupted_study_says_so_and_goes_on(here):
    Path("study.toml").write_text(many(12), encoding="utf-8")
    process = command("study.toml", "--workers", "1")
    assert ended_after(process, Path("studies/study/points"), 3, signal.SIGINT) == 130
    assert "--resume goes on with the other" in process.stderr.read()
    assert run(many(12), "--resume") == 0
    assert run(many(12), "--output", "whole") == 0
    same("studies/study/study.nc", "whole/study.nc")


@pytest.mark.slow
def test_a_study_killed_at_twenty_moments_gives_the_same_dataset(here):
    Path("study.toml").write_text(many(40), encoding="utf-8")
    rng = np.random.default_rng(5)
    for moment in range(20):
        process = command("study.toml", "--workers", "1", "--quiet", "--resume")
        done = len(list(Path("studies/study/points").glob("*.point")))
        ended_after(process, Path("studies/study/points"), done + int(rng.integers(0, 4)), signal.SIGKILL)
        assert process.returncode == -signal.SIGKILL, moment
    assert run(many(40), "--resume") == 0
    assert run(many(40), "--output", "whole") == 0
    same("studies/study/study.nc", "whole/study.nc")


def test_the_built_in_scene_is_left_as_it_is(here):
    """A study of nothing but its scene is run-fem's scene: varying must not spell anything differently."""
    text = '[parameters]\n"operation.speed_rpm" = [4500.0]\n'
    assert points_of(text).scene(0).to_toml() == read_scene().to_toml()
    assert os.listdir() == ["study.toml"]


def test_a_study_of_ratings_runs_nothing(here, monkeypatch):
    monkeypatch.setattr("fem.study.solving.simulate", None)
    kept = '[keep]\nquantities = ["rating_life", "rating_peak_pressure", "rating_moment"]\n'
    assert run('[parameters]\n"operation.radial_load_N" = [1000.0, 2000.0]\n' + kept) == 0
    with h5py.File("studies/study/study.nc") as file:
        life, pressure, moment = (file[f"rating_{name}"][...] for name in ("life", "peak_pressure", "moment"))
    answers = rating(read_scene().varied({"operation.radial_load_N": 1000.0}))
    assert life[0] == 1e6 * answers["L10r_Mrev"]
    assert pressure[0] == 1e6 * answers["peak_pressure_MPa"] < pressure[1]
    assert np.isnan(moment).all()  # of a plane section

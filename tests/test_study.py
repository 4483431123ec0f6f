"""Studies: the same results as run-fem, points of each method, what fails, and going on after any end."""

import io
import json
import os
import re
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
from fem.study.dataset import write_dataset
from fem.study.effects import sobol_indices, table_of
from fem.study.folder import Folder
from fem.study.page import write_page
from fem.study.sampling import design_of
from fem.study.solving import COMPLETE, FAILED, Solved, checked_points
from fem.study.study_file import read_study
from lagrange.files.output import read_sealed, write_sealed
from lagrange.scene.scene import SceneError, read_scene
from tests.reference.small_study import BASE, GRID, TWO_SPEEDS, many, same
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


# Studies on a cluster: a real scheduler with workers as processes of their own, some of which are killed


pytest.importorskip("distributed")


@pytest.fixture
def here_cluster(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return tmp_path


@pytest.fixture
def started(tmp_path):
    """Starts a program of dask with the tests' own import path; all are ended with the test."""
    running = []

    def start(*words):
        path = os.pathsep.join(entry for entry in sys.path if entry)
        log = open(tmp_path / f"log-{len(running)}", "w", encoding="utf-8")
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], stderr=log, stdout=log,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
        running.append(process)
        return process

    yield start
    for process in reversed(running):
        process.kill()  # they hold nothing, and a worker without its scheduler waits long
    for process in running:
        process.wait(GIVE_UP)


@pytest.fixture
def scheduler_cluster(started, tmp_path):
    """Address of a scheduler."""
    file = tmp_path / "scheduler.json"
    started("dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file), "--host", "127.0.0.1")
    wait_until(lambda: file.exists() and file.read_text().endswith("}"))
    return json.loads(file.read_text())["address"]


def worker(started, address, *words):
    return started("dask_worker", address, "--nthreads", "1", "--no-dashboard", *(words or ("--no-nanny",)))


def test_two_workers_of_a_scheduler_give_what_one_process_gives(here_cluster, started, scheduler_cluster):
    """Three programs and two points: what CI has of a cluster. The slow tests below kill and hang them."""
    for _ in range(2):
        worker(started, scheduler_cluster)
    text = BASE + '[parameters]\n"operation.speed_rpm" = [1500.0, 3000.0]\n[keep]\nsignals = ["inner_ay"]\n'
    Path("study.toml").write_text(text, encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler_cluster]) == 0
    assert study_main(["study.toml", "--quiet", "--workers", "1", "--output", "here"]) == 0
    same("studies/study/study.nc", "here/study.nc")


def test_what_is_no_scheduler_is_named(here_cluster, monkeypatch, capsys):
    monkeypatch.setattr("fem.study.workers.CONNECT", 0.5)
    Path("study.toml").write_text(GRID, encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        hangs = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in ("tcp://127.0.0.1:9", hangs, "tls://127.0.0.1:9", "ucx://a", "inproc://x", "tcp://", ""):
            assert study_main(["study.toml", "--quiet", "--scheduler", address]) == 2
            said = capsys.readouterr().err
            assert f"--scheduler {address}: does not answer: " in said and not said.endswith(": \n")
    assert not Path("studies").exists()  # the study has not begun


@pytest.mark.slow
def test_points_of_a_killed_worker_are_solved_by_another(here_cluster, started, scheduler_cluster):
    first, _ = worker(started, scheduler_cluster), worker(started, scheduler_cluster)
    Path("study.toml").write_text(many(40), encoding="utf-8")
    kept = Path("studies/study/points")

    def kill():
        wait_until(lambda: len(list(kept.glob("*.point"))) > 5)
        first.send_signal(signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler_cluster]) == 0
    thread.join()
    assert first.wait(GIVE_UP) == -signal.SIGKILL
    assert study_main(["study.toml", "--quiet", "--workers", "1", "--output", "here"]) == 0
    same("studies/study/study.nc", "here/study.nc")


HANGING = """
import ctypes
from fem.solver.rigid.state import LagrangianState

def advance(state, most, real=LagrangianState.advance):
    if state.plan.scene.operation.speed_rpm == 3000.0:
        ctypes.PyDLL(None).sleep(3600)  # keeps even the interpreter's lock: the worker answers nobody
    return real(state, most)

LagrangianState.advance = advance
"""


@pytest.mark.slow
def test_a_point_that_hangs_in_compiled_code_ends_by_its_limit_and_the_study_goes_on(
    here_cluster, started, scheduler_cluster, monkeypatch
):
    monkeypatch.setattr("fem.study.workers.GRACE", 3.0)
    Path("hanging.py").write_text(HANGING, encoding="utf-8")
    worker(started, scheduler_cluster, "--preload", str(here_cluster / "hanging.py"))
    Path("study.toml").write_text(GRID + "[limits]\nseconds_per_point = 2.0\n", encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler_cluster]) == 1
    with xarray.open_dataset("studies/study/study.nc") as found:
        hung = found.sel(speed_rpm=3000.0)
        assert np.all(hung.status == "stopped")
        assert all("hung in compiled code" in str(text) for text in hung.message.values.ravel())
        assert np.all(found.drop_sel(speed_rpm=3000.0).status == "complete")


# Folders of studies that others have made: `run-study --collect` refuses them, or leaves points out, and soon


STUDY = TWO_SPEEDS + 'signals = ["inner_ay"]\n'


@pytest.fixture(scope="module")
def study_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "s.toml").write_text(STUDY, encoding="utf-8")
    assert study_main([str(folder / "s.toml"), "--output", str(folder / "s"), "--workers", "1", "--quiet"]) == 0
    return folder / "s"


FACTS = {  # what is put into study.json, and what must be told
    "digests that lead elsewhere": ({"digests": ["../../x"] * 2}, "digests.0: String should match"),
    "digests without points": ({"digests": ["0" * 32] * 6}, "as many digests as points"),
    "axes that are none": ({"axes": "abc"}, "axes: "),
    "axes that make other points": ({"axes": [[1] * 1000]}, "axes: must make the points"),
    "keys that are none": ({"keys": [1]}, "keys.0: "),
    "no name": ({"name": None}, "name: "),
    "a program that is none": ({"made_by": {"a": 1}}, "made_by: "),
    "a study of thirty thousand tables": ({"study": "a." * 30_000 + "a = 1"}, "a key of more than 50 parts"),
    "a speed that is no number": ({"points": [[float("nan")]] * 2}, "points.0.0."),
}


@pytest.mark.parametrize("kind", FACTS)
def test_a_study_that_can_not_be_is_refused(kind, study_folder, tmp_path, capsys):
    change, words = FACTS[kind]
    folder = shutil.copytree(study_folder, tmp_path / "s")
    about = folder / "study.json"
    about.write_text(json.dumps(json.loads(about.read_text(encoding="utf-8")) | change), encoding="utf-8")
    _refused(folder, words, capsys)


def test_a_study_that_nests_is_refused(study_folder, tmp_path, capsys):
    folder = shutil.copytree(study_folder, tmp_path / "s")
    (folder / "study.json").write_text("[" * 10**5, encoding="utf-8")
    _refused(folder, "recursion limit", capsys)


def test_a_study_in_a_pipe_is_refused(study_folder, tmp_path, capsys):
    folder = shutil.copytree(study_folder, tmp_path / "s")
    (folder / "study.json").unlink()
    os.mkfifo(folder / "study.json")
    _refused(folder, "not a plain file", capsys)


def _refused(folder, words, capsys):
    assert study_main(["--collect", str(folder), "--quiet"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ") and words in said and len(said) < 5000, said


def _seal(path, save, arrays):
    archive = io.BytesIO()
    save(archive, **arrays)
    write_sealed(path, archive.getvalue())


def in_a_pipe(path):
    path.unlink()
    os.mkfifo(path)


POINTS = {
    "no archive": lambda path: write_sealed(path, b"hello"),
    "no facts": lambda path: _seal(path, np.savez, {"a": np.zeros(1)}),
    "a pipe": in_a_pipe,
    "another seal": lambda path: path.write_bytes(path.read_bytes()[:50]),
}


def test_a_point_is_known_by_what_is_sealed_and_not_by_its_name(study_folder, tmp_path, capsys):
    """One copied under another's name is none of either's: solved anew, and missing where nothing is solved."""
    folder = shutil.copytree(study_folder, tmp_path / "s")
    first, second = sorted((folder / "points").iterdir())
    shutil.copy(first, second)
    assert study_main(["--collect", str(folder)]) == 1
    assert "2 points: 1 complete, 1 missing" in capsys.readouterr().out
    assert study_main([str(study_folder.parent / "s.toml"), "--output", str(folder), "--resume", "--quiet"]) == 0
    assert first.read_bytes() != second.read_bytes()


@pytest.mark.parametrize("kind", POINTS)
def test_a_point_that_can_not_be_is_left_out(kind, study_folder, tmp_path, capsys):
    folder = shutil.copytree(study_folder, tmp_path / "s")
    for path in (folder / "points").iterdir():
        POINTS[kind](path)
    assert study_main(["--collect", str(folder)]) == 1
    out, error = capsys.readouterr()
    assert "2 points: 2 missing" in out and "Traceback" not in error and "Warning" not in error


def test_a_signal_of_another_length_is_named(study_folder, tmp_path, capsys):
    folder = shutil.copytree(study_folder, tmp_path / "s")
    path = min((folder / "points").iterdir())
    with np.load(io.BytesIO(read_sealed(path))) as found:
        _seal(path, np.savez, {"facts": found["facts"], "inner_ay": found["inner_ay"][:7]})
    _refused(folder, "its signals have another length than those of other points", capsys)


# Studies that can't be run: refused with exit code 2 before anything is solved, the key named


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


# The page of a study and the numbers behind it, on points whose results are made up


STUDY_PAGE = """
[sampling]
method = "{method}"
[parameters]
"operation.speed_rpm" = {speed}
"operation.radial_load_N" = {load}
"bearing.roller_length_mm" = {length}
[keep]
quantities = ["largest_force", "hub_mean_y"]
"""
GRID_PAGE = dict(method="grid", speed="[1, 2, 3]", load="[10, 20]", length="[8.0, 9.0, 10.0, 11.0]")
DRAWN_PAGE = dict(
    method='sobol"\nsamples = 64\nindices = true\n#"', speed="{ from = -1.0, to = 1.0 }",
    load="{ from = 0.0, to = 1.0 }", length="{ from = 9.0, to = 11.0 }",
)  # fmt: skip


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """Gives the table of a study whose largest force is a function of speed, load and length."""
    monkeypatch.chdir(tmp_path)

    def make(force, failed=(), **values):
        Path("study.toml").write_text(STUDY_PAGE.format(**values), encoding="utf-8")
        study = read_study(Path("study.toml"))
        points = checked_points(study, design_of(study))
        folder = Folder(path=Path("out"))
        folder.begin(points)
        for i, digest in enumerate(points.digests):
            quantities = {"largest_force": float(force(*points.design.points[i])), "hub_mean_y": 1e-6}
            status = dict(status=FAILED, text="<b>it broke</b>") if i in failed else dict(status=COMPLETE)
            folder.add(digest, Solved(**status, seconds=0.1, quantities={} if i in failed else quantities))
        write_dataset(points, folder)
        return points, folder

    return make


def shares(points, folder):
    table = table_of(points, write_dataset(points, folder))
    return {each.name: share for each, share in table.strongest(table.quantities[0])}, table


def test_a_quantity_of_one_parameter_is_explained_by_it_alone(made_up):
    found, _ = shares(*made_up(lambda speed, load, length: speed**2, **GRID_PAGE))
    assert found["speed_rpm"] == pytest.approx(1.0)
    assert found["radial_load_N"] == found["roller_length_mm"] == 0.0


def test_effects_of_a_sum_share_its_variance(made_up):
    """3 s + 0.4 l + h/2 of s = 1, 2, 3, l = 10, 20, h = 8 … 11: variances 9 · 2/3, 0.16 · 25, 0.25 · 1.25.

    In a grid nothing is drawn, so no part of a small share is chance.
    """
    found, _ = shares(*made_up(lambda speed, load, length: 3.0 * speed + 0.4 * load + 0.5 * length, **GRID_PAGE))
    whole = 6.0 + 4.0 + 0.3125
    assert found["speed_rpm"] == pytest.approx(6.0 / whole, abs=1e-12)
    assert found["radial_load_N"] == pytest.approx(4.0 / whole, abs=1e-12)
    assert found["roller_length_mm"] == pytest.approx(0.3125 / whole, abs=1e-12)


def test_shares_of_drawn_points_are_less_what_chance_explains_and_the_page_says_so(made_up):
    """Eight groups of 320 drawn points explain 7/319 of a variance that knows nothing of the parameter."""
    rng = np.random.default_rng(3)
    points, folder = made_up(lambda *_: rng.normal(), **DRAWN_PAGE)
    found, _ = shares(points, folder)
    assert max(found.values()) < 0.04
    write_page(points, folder, write_dataset(points, folder))
    assert "chance" in folder.page.read_text(encoding="utf-8")
    points, folder = made_up(lambda speed, load, length: speed, **GRID_PAGE)
    write_page(points, folder, write_dataset(points, folder))
    assert "chance" not in folder.page.read_text(encoding="utf-8")


def test_sobol_indices_are_those_of_a_function_whose_variance_is_known(made_up):
    """3 x + 2 y + z + 3 x y, each even in -1 … 1: the terms have variances 3, 4/3, 1/3 and 1."""

    def known(speed, load, length):
        x, y, z = speed, 2.0 * load - 1.0, length - 10.0
        return 3.0 * x + 2.0 * y + z + 3.0 * x * y

    points, folder = made_up(known, **DRAWN_PAGE)
    assert len(points) == 5 * 64
    _, table = shares(points, folder)
    found, whole = sobol_indices(table, table.quantities[0]), 3.0 + 4.0 / 3.0 + 1.0 / 3.0 + 1.0
    assert found.first == pytest.approx(np.array([3.0, 4.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert found.total == pytest.approx(np.array([4.0, 7.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert sobol_indices(table, table.quantities[1]) is None  # it never changes


def cells(page):
    """Rows of all tables, each a list of texts."""
    rows = re.findall(r"<tr>(.*?)</tr>", page.read_text(encoding="utf-8"), re.S)
    return [re.findall(r"<t[dh]>(.*?)</t[dh]>", re.sub("</?span[^>]*>", "", row), re.S) for row in rows]


def test_the_page_of_a_grid_has_a_line_for_each_value_and_a_table_of_points(made_up):
    points, folder = made_up(lambda speed, load, length: speed + load, failed=(5,), **GRID_PAGE)
    write_page(points, folder, write_dataset(points, folder))
    text = folder.page.read_text()
    assert "Varied: speed, radial load, roller length; 23 of 24 points are complete" in text
    assert "&lt;b&gt;it broke&lt;/b&gt;" in text and "point 5 (operation.speed_rpm = 1" in text
    assert re.findall('<figure id="([^"]*)"', text) == ["lines"]
    rows = cells(folder.page)
    assert ["mean position of the hub, y, µm", "1", "1", "23", "-"] in rows
    assert ["point", "speed, rpm", "radial load, N", "roller length, mm", "largest force on the inner raceway, N",
            "mean position of the hub, y, µm"] in rows  # fmt: skip
    assert ["0", "1", "10", "8", "11", "1"] in rows and ["5", "1", "20", "9", "-", "-"] in rows
    assert "http" not in text.split("<pre>")[0].replace("http://www.w3.org", "")


@pytest.mark.parametrize(("speed", "length"), [("[2]", "[8.0]"), ("[1, 2, 3]", "[8.0]"), ("[1, 2, 3]", "[8.0, 9.0]")])
def test_lines_of_a_grid_go_through_every_point(made_up, speed, length):
    """A mean over loads would be of no bearing."""
    from fem.study import figures

    scene = GRID_PAGE | dict(speed=speed, load="[250, 500, 1000, 2000]", length=length)
    points, folder = made_up(lambda speed, load, length: speed * load + length, **scene)
    table = table_of(points, write_dataset(points, folder))
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "finished", lambda figure, *_: seen.append(figure))
        figures.study_figures(table, [])
    (figure,) = seen
    drawn = np.concatenate([line.get_ydata() for axis in figure.axes for line in axis.lines])
    assert sorted(drawn) == sorted(table.quantities[0].values)


def test_drawn_points_have_clouds_with_means_of_groups(made_up):
    points, folder = made_up(lambda speed, load, length: speed + load, **DRAWN_PAGE)
    write_page(points, folder, write_dataset(points, folder))
    text = folder.page.read_text()
    assert re.findall('<figure id="([^"]*)"', text) == ["main-effects", "heat-map", "scatter-matrix", "sobol-indices"]
    assert ["largest force on the inner raceway", "radial load"] in [row[:2] for row in cells(folder.page)]


def test_one_parameter_has_no_shares_and_points_that_can_not_tell_are_left_out(made_up):
    points, folder = made_up(lambda speed, *_: 100.0 * speed, **{**GRID_PAGE, "load": "[10]", "length": "[8.0]"})
    write_page(points, folder, write_dataset(points, folder))
    assert ["largest force on the inner raceway, N", "100", "300", "3"] in cells(folder.page)
    assert "variance" not in folder.page.read_text(encoding="utf-8")
    points, folder = made_up(lambda speed, *_: np.nan if speed < 3.0 else speed, **GRID_PAGE)
    write_page(points, folder, write_dataset(points, folder))
    assert ["largest force on the inner raceway, N", "3", "3", "8", "-"] in cells(folder.page)


def test_a_study_without_a_complete_point_has_a_page_too(made_up):
    points, folder = made_up(lambda *_: 1.0, failed=range(24), **GRID_PAGE)
    write_page(points, folder, write_dataset(points, folder))
    assert "0 of 24 points are complete" in folder.page.read_text()
    assert "Too few complete points" in folder.page.read_text()


def test_an_empty_cell_is_no_value_of_its_parameter(tmp_path, monkeypatch):
    """A point without a spall has no width, and its body is a word of its own."""
    monkeypatch.chdir(tmp_path)
    Path("points.csv").write_text(
        "operation.speed_rpm,spall.0.body,spall.0.width_mm\n1000,,\n1000,outer_ring,1.0\n1000,outer_ring,2.0\n"
    )
    Path("study.toml").write_text('[sampling]\nmethod = "list"\nfile = "points.csv"\n')
    study = read_study(Path("study.toml"))
    points = checked_points(study, design_of(study))
    assert not points.scene(0).spall and points.scene(2).spall[0].width_mm == 2.0
    folder = Folder(path=Path("out"))
    folder.begin(points)
    write_dataset(points, folder)
    body, width = table_of(points, write_dataset(points, folder)).parameters
    with xarray.open_dataset(folder.dataset, engine="netcdf4") as dataset:
        assert dataset.body.values.tolist() == ["", "outer_ring", "outer_ring"]
    assert body.words == ("-", "outer_ring") and np.isnan(width.values[0]) and width.values[2] == 2.0

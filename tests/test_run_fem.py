"""The command run-fem: what it refuses, what it writes, how it ends."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.commands.summary import result_megabytes, size_warning
from fem.errors import RunFailed
from fem.result.store import ResultFile
from fem.solver.simulate import make_plan, run
from lagrange.columns import columns_of
from lagrange.scene.scene import read_scene

COARSE = ("numerics.mesh_size_mm=2", "numerics.duration_ms=1")


def test_help_has_an_example_and_version_a_number(capsys):
    run_main(["--help"])
    assert "Example: run-fem" in capsys.readouterr().out
    run_main(["--version"])
    assert capsys.readouterr().out.strip()


def test_dry_run_shows_the_plan_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_main(["--dry-run", "--mesh-size", "2"]) == 0
    out = capsys.readouterr().out
    for word in ("degrees of freedom", "time step", "steps", "memory", "result file", "angles"):
        assert word in out
    assert not list(tmp_path.iterdir())


def test_a_large_result_file_is_announced_with_the_keys_that_make_it_smaller(tmp_path):
    """What is announced is what the file takes, but for some tens of kB of its own."""
    short, long = (
        make_plan(read_scene(None, ("model=lagrange", f"numerics.duration_ms={duration}"))) for duration in (20, 2000)
    )
    assert size_warning(short) is None
    assert {"numerics.duration_ms", "numerics.output_interval_us"} <= set(size_warning(long).split())
    with ResultFile(tmp_path / "run.nc", short, 0.0):
        assert 1e-6 * (tmp_path / "run.nc").stat().st_size == pytest.approx(result_megabytes(short), rel=0.05)


def test_static_run_prints_and_stores_the_equilibrium(tmp_path, capsys):
    """Whole bearing on resolved P2 meshes: 3.6140 µm; 628.5, 549.5, 337.2, 62.9 N (independent static solution)."""
    path = tmp_path / "static.nc"
    settings = ["operation.speed_rpm=0", "operation.gravity_m_s2=0"]
    options = [word for setting in settings for word in ("--set", setting)]
    assert run_main(["--duration", "0", "--output", str(path), *options]) == 0
    assert "Static equilibrium at rest: hub" in capsys.readouterr().out
    with h5py.File(path) as file:
        assert file["time"].shape == (1,)
        assert -1e6 * file["inner_y"][0] == pytest.approx(3.6140, rel=1e-3)
        loads = np.sort(file["inner_force"][0])[::-1][:7]
    assert loads == pytest.approx([628.5, 549.5, 549.5, 337.2, 337.2, 62.9, 62.9], rel=3e-3)


def test_an_equilibrium_says_at_what_speed_it_is(tmp_path, capsys):
    options = ["--duration", "0", "--model", "lagrange", "--output", str(tmp_path / "static.nc")]
    assert run_main([*options, "--set", "operation.speed_rpm=3000"]) == 0
    assert "Static equilibrium at 3000 rpm, with centrifugal force: hub" in capsys.readouterr().out


def test_result_file_holds_the_contract(coarse_run):
    with h5py.File(coarse_run) as file:
        assert file.attrs["status"] == "complete"
        assert file.attrs["committed_samples"] == 401 == file["time"].shape[0]
        for name, (dimensions, units, _) in columns_of("").items():
            assert file[name].attrs["units"] == units and file[name].attrs["long_name"]
            assert file[name].ndim == len(dimensions)
            assert np.all(np.isfinite(file[name][:]))
        for attribute in (
            "scene",
            "program_version",
            "mesh_nodes",
            "degrees_of_freedom",
            "time_step",
            "critical_time_step",
            "steps",
            "wall_seconds",
            "setup_seconds",
        ):
            assert attribute in file.attrs
        assert file["time"][1] - file["time"][0] == pytest.approx(1e-5, rel=1e-12)


def test_result_file_opens_in_xarray_and_netcdf4(coarse_run):
    xarray = pytest.importorskip("xarray")
    netcdf = pytest.importorskip("netCDF4")
    with xarray.open_dataset(coarse_run, engine="netcdf4") as data:
        assert data["inner_force"].dims == ("time", "roller")
        assert data["inner_y"].attrs["units"] == "m"
    with netcdf.Dataset(coarse_run) as data:
        assert data.variables["roller_rho"].dimensions == ("time", "roller")


def test_physics_of_the_coarse_run(coarse_run):
    """Cage 29.35 Hz by kinematics; six or seven loaded rollers, largest load 620-650 N."""
    with h5py.File(coarse_run) as file:
        time_, force, angle = file["time"][:], file["inner_force"][:], file["roller_theta"][:]
        stored = file["energy_kinetic"][:] + file["energy_elastic"][:] + file["energy_contact"][:]
        balance = stored - file["work_external"][:] + file["work_dissipated"][:]
        elastic = file["energy_elastic"][:].max()
        assert file["roller_roller_force"][:].max() == 0.0
    loaded = np.count_nonzero(force > 0.0, axis=1)
    assert (loaded.min(), loaded.max()) == (6, 7)
    assert 620.0 < force.max() < 650.0
    cage = np.mean(angle[-1] - angle[0]) / (2.0 * np.pi * time_[-1])
    assert cage == pytest.approx(29.35, rel=0.01)
    assert np.ptp(balance) < 1e-4 * elastic  # 1 % is asked for; measured 4e-6


def test_halving_the_interval_changes_no_shared_sample(tmp_path):
    """The storage stride must not touch the trajectory when the step divides both intervals."""
    paths = []
    for interval in (10.0, 20.0):
        plan = make_plan(read_scene(None, (*COARSE, f"numerics.output_interval_us={interval}")))
        paths.append((plan, tmp_path / f"{interval}.nc"))
    assert paths[0][0].time_step == pytest.approx(paths[1][0].time_step, rel=0.03)
    fine = replace(paths[1][0], time_step=paths[0][0].time_step, stride=2 * paths[0][0].stride)
    for plan, path in ((paths[0][0], paths[0][1]), (fine, paths[1][1])):
        with ResultFile(path, plan, 0.0) as store:
            progress = run(plan, store.append)
            store.finish("complete", steps=progress.steps, wall_seconds=progress.wall)
    with h5py.File(paths[0][1]) as often, h5py.File(paths[1][1]) as seldom:
        assert np.array_equal(often["inner_y"][::2], seldom["inner_y"][:])
        assert np.array_equal(often["roller_x"][::2], seldom["roller_x"][:])


def test_a_step_beyond_the_limit_stops_the_run_and_keeps_the_good_samples(tmp_path):
    plan = make_plan(read_scene(None, COARSE))
    wild = replace(plan, time_step=1.05 * plan.critical_time_step, stride=10)
    path = tmp_path / "wild.nc"
    with ResultFile(path, wild, 0.0) as store:
        with pytest.raises(RunFailed, match=r"step \d+, t = .* ms"):
            run(wild, store.append)
        store.finish("failed: test")
    with h5py.File(path) as file:
        assert 0 < file.attrs["committed_samples"] < wild.n_samples
        assert np.all(np.isfinite(file["inner_y"][:]))
        assert np.abs(file["inner_y"][:]).max() < 1e-4

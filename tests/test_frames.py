"""Fields stored in the result file: the solver's own, where the scene asks for them and nowhere else."""

import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.elastic.bodies import turned
from fem.errors import UsageError
from fem.pictures.recover import StoredRun, read_instant
from fem.result.fields import GROUP
from fem.result.store import ResultFile
from fem.solver.frames import frame_of
from fem.solver.simulate import make_plan, run
from lagrange.scene.scene import SceneError, read_scene
from tests.reference.unchecked import unchecked_copy

EVERY = ["--set", "output.fields_every_ms=0.5"]


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    """The shared coarse run, with fields."""
    path = tmp_path_factory.mktemp("fields") / "fields.nc"
    assert run_main(["--mesh-size", "2", "--duration", "4", "--output", str(path), "--quiet", *EVERY]) == 0
    return path


def test_frames_are_at_the_samples_asked_for(with_fields):
    with h5py.File(with_fields) as file:
        assert file[GROUP]["sample"][:].tolist() == list(range(0, 401, 50))
        assert file[GROUP]["time"][:] == pytest.approx(0.5e-3 * np.arange(9), rel=1e-12)
        assert file["time"][file[GROUP]["sample"][:]] == pytest.approx(file[GROUP]["time"][:], rel=1e-12)


def test_storing_fields_does_not_change_the_run(with_fields, coarse_run):
    with h5py.File(with_fields) as file, h5py.File(coarse_run) as plain:
        assert GROUP not in plain
        for name in ("inner_x", "inner_y", "roller_x", "inner_force", "energy_elastic"):
            assert np.array_equal(file[name][:], plain[name][:])


@pytest.mark.parametrize("sample", [0, 150, 400])
def test_stored_displacements_have_the_runs_elastic_energy(with_fields, sample):
    instant = StoredRun(with_fields).instant(sample)
    assert instant.stored
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-6)


@pytest.mark.parametrize("sample", [150, 400])
def test_recovered_fields_are_the_stored_ones_but_for_waves(with_fields, coarse_run, sample):
    stored, recovered = StoredRun(with_fields).instant(sample), StoredRun(coarse_run).instant(sample)
    assert not recovered.stored
    assert recovered.roller_turn == pytest.approx(stored.roller_turn, abs=1e-5)
    for name in ("rollers", "inner_ring", "outer_ring"):
        expected = getattr(stored, name)
        assert getattr(recovered, name) == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def test_stored_stress_is_that_of_the_stored_displacement(with_fields):
    instant = StoredRun(with_fields).instant(250)
    disc, j = instant.model.roller, int(instant.inner_force.argmax())
    local = (disc.stress @ instant.rollers[j].ravel()).reshape(-1, 3)
    with h5py.File(with_fields) as file:
        stored = file[GROUP]["roller_stress"][5, j]
    assert stored == pytest.approx(turned(local, instant.roller_turn[j]), abs=1e-5 * np.abs(local).max())
    assert np.abs(stored).max() > 5e6


def test_displacements_are_in_the_fixed_axes(with_fields):
    """The most loaded roller, near the load line, is shortened along y and bulges along x."""
    with h5py.File(with_fields) as file:
        group = file[GROUP]
        j = int(file["inner_force"][400].argmax())
        turn, points = group["roller_turn"][-1, j], group["roller_points"][:]
        moved = group["roller_displacement"][-1, j]
        angle = np.arctan2(file["roller_y"][400, j], file["roller_x"][400, j])
    c, s = np.cos(turn), np.sin(turn)
    placed = points @ np.array([[c, s], [-s, c]])
    radial, around = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    assert np.sum((placed @ radial) * (moved @ radial)) < 0.0 < np.sum((placed @ around) * (moved @ around))


def test_the_group_opens_in_xarray(with_fields):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    with xarray.open_dataset(with_fields, group=GROUP, engine="netcdf4", decode_times=False) as fields:
        assert fields["roller_displacement"].dims == ("time", "roller", "roller_node", "component")
        assert fields["outer_ring_stress"].dims == ("time", "outer_ring_node", "stress_component")
        assert fields["inner_ring_displacement"].attrs["units"] == "m"


def test_fields_take_little_room(with_fields, coarse_run):
    with h5py.File(with_fields) as file:
        nodes = sum(len(file[GROUP][f"{name}_points"]) * count for name, count in
                    (("roller", 13), ("inner_ring", 1), ("outer_ring", 1)))  # fmt: skip
    per_frame = (with_fields.stat().st_size - coarse_run.stat().st_size) / 9
    assert per_frame < 40.0 * nodes  # 20 bytes of numbers a node, and the file's own structure on a mesh this small


def _resumed(folder, stop_at):
    """A run stopped after some samples and gone on with."""
    plan = make_plan(read_scene(None, ("numerics.mesh_size_mm=2.0", "numerics.duration_ms=1.0",
                                       "output.fields_every_ms=0.25")))  # fmt: skip
    path, state = folder / f"{stop_at}.nc", plan.first_state()
    short = replace(plan, n_samples=stop_at)
    with ResultFile(path, short, 0.0) as store:
        run(short, store.append, state=state, keep=store.keep)
        store.keep(frame_of(plan.model, state.arrays, state.done, plan.interval))  # stopped between frame and sample
        store.commit()
        stored = store.stored
    with ResultFile(path, plan, 0.0, stored) as store:
        run(plan, store.append, state=state, keep=store.keep)
        store.finish("complete", steps=plan.steps)
    return path


@pytest.mark.parametrize("stop_at", [50, 63])
def test_a_resumed_run_has_every_frame_once(tmp_path, stop_at):
    path = _resumed(tmp_path, stop_at)
    with h5py.File(path) as file:
        assert file[GROUP]["sample"][:].tolist() == [0, 25, 50, 75, 100]
        assert file[GROUP]["roller_displacement"].shape[0] == 5
    for sample in (50, 75):
        instant = StoredRun(path).instant(sample)
        assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-6)


def test_a_file_whose_frames_are_gone_is_not_gone_on_with(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "2", "--output", str(path), "--quiet", *EVERY, "--duration"]
    assert run_main([*options, "1"]) == 0
    with h5py.File(path, "r+") as file:
        del file[GROUP]
    assert run_main([*options, "2", "--resume"]) == 2
    assert "frames" in capsys.readouterr().err


def test_frames_beyond_the_committed_samples_are_not_trusted(with_fields, tmp_path):
    path = unchecked_copy(with_fields, tmp_path / "copy.nc")
    with h5py.File(path, "r+") as file:
        file.attrs["committed_samples"] = 101
    assert StoredRun(path).stored_samples.tolist() == [0, 50, 100]


def test_damaged_fields_are_refused(with_fields, tmp_path):
    path = shutil.copy(with_fields, tmp_path / "copy.nc")
    with h5py.File(path, "r+") as file:
        del file[GROUP]["outer_ring_displacement"]
    with pytest.raises(UsageError, match="outer_ring_displacement"):
        read_instant(path, 1e-3)


def test_a_changed_frame_is_refused_by_its_checksum(with_fields, tmp_path):
    path = shutil.copy(with_fields, tmp_path / "copy.nc")
    with h5py.File(path, "r+") as file:
        file[GROUP]["inner_ring_stress"][3, 7, 1] *= 1.0 + 1e-6
    assert StoredRun(path).instant(100).stored
    with pytest.raises(UsageError, match=r"sample 150 .* checksum"):
        StoredRun(path).instant(150)


def test_fields_in_another_file_are_not_followed(with_fields, tmp_path):
    path = shutil.copy(with_fields, tmp_path / "copy.nc")
    with h5py.File(path, "r+") as file:
        del file[GROUP]["outer_ring_displacement"]
        file[GROUP]["outer_ring_displacement"] = h5py.ExternalLink("/etc/passwd", "/x")
    with pytest.raises(UsageError, match="outer_ring_displacement is a link"):
        StoredRun(path)


def test_fields_more_often_than_samples_are_refused():
    with pytest.raises(SceneError, match=r"output\.fields_every_ms = 0\.005 must not be below .* \(0\.01 ms\)"):
        read_scene(None, ("output.fields_every_ms=0.005",))


def test_the_dry_run_says_what_fields_will_take(capsys):
    assert run_main(["--mesh-size", "2", "--duration", "4", "--dry-run", *EVERY]) == 0
    assert "9, one every 0.5 ms, 0.151 MB" in capsys.readouterr().out

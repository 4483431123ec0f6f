"""Disks that fail, fill up or tear a write: what is left is an earlier file or a sound one."""

import errno
import gc
import itertools
import math
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from fem.result.store import ResultFile
from fem.solver.simulate import make_plan
from lagrange.columns import PER_TIME, columns_of
from lagrange.files.hdf5 import HeldBack, read_numbers
from lagrange.scene.scene import read_scene
from tests.reference.recorded_disk import RecordedDisk
from tests.reference.run_files import EARLIER, OPTIONS, SHORT, names_in, same_data
from tests.stability import forked
from tests.waiting import GIVE_UP, wait_until

ROOT = Path(__file__).resolve().parent.parent
BLOCKS = (1, 4, 15)  # samples appended and committed at a time, of 41
ROLLERS = 13


@pytest.fixture(scope="module")
def plan():
    return make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=0.4")))


@pytest.fixture(scope="module")
def samples():
    """Made-up samples: what a file holds of them can be told apart."""
    n = sum(BLOCKS)
    numbers = np.random.default_rng(1)
    return {
        name: numbers.uniform(size=n if dimensions == PER_TIME else (n, ROLLERS))
        for name, (dimensions, *_) in columns_of("").items()
    }


def write(path, plan, samples):
    """All blocks, each committed; fewer samples than there is room for."""
    with ResultFile(path, plan, 0.0) as store:
        for block, start in zip(BLOCKS, itertools.accumulate((0, *BLOCKS)), strict=False):
            part = {name: values[start : start + block] for name, values in samples.items()}
            store.append(part)
            store.commit()
        store.finish("interrupted", steps=7, wall_seconds=1.5)


ENDS = [(0, "running"), (1, "running"), (5, "running"), (20, "running"), (20, "interrupted")]


def found(path, samples):
    """Number of samples and status of a file that any HDF5 reader can open; its samples must be right."""
    with h5py.File(path, "r", locking=False) as file:
        count = int(file.attrs["committed_samples"])
        for name in columns_of(""):
            np.testing.assert_array_equal(read_numbers(file, name, count), samples[name][:count])
        return count, file.attrs["status"]


def test_a_run_that_is_killed_after_any_write_leaves_the_samples_of_its_last_commit(
    plan, samples, tmp_path, monkeypatch
):
    path, probe = tmp_path / "run.nc", tmp_path / "probe.nc"
    disk = RecordedDisk(monkeypatch)
    write(path, plan, samples)
    ends = []
    for content in dict.fromkeys(disk.after_kills(path)):
        probe.write_bytes(content)
        ends.append(found(probe, samples))
    assert len(ends) > 3 * 2 * len(columns_of(""))
    assert list(dict.fromkeys(ends)) == ENDS


def test_a_power_cut_leaves_a_sound_file_whichever_sectors_had_reached_the_disk(plan, samples, tmp_path, monkeypatch):
    path, probe = tmp_path / "run.nc", tmp_path / "probe.nc"
    disk = RecordedDisk(monkeypatch)
    write(path, plan, samples)
    ends = []
    for content in dict.fromkeys(disk.after_power_cuts(path, np.random.default_rng(5), tries=2)):
        probe.write_bytes(content)
        ends.append(ENDS.index(found(probe, samples)))
    assert len(ends) > 200
    assert set(ends) == set(range(len(ENDS)))
    assert all(later >= sooner - 1 for sooner, later in itertools.pairwise(ends))  # the commit in work is on it or not


def test_the_counter_is_not_torn(plan, tmp_path):
    """Eight aligned bytes: within one sector, and one page."""
    with ResultFile(tmp_path / "run.nc", plan, 0.0) as store:
        assert store._places.committed % 8 == 0
    with h5py.File(tmp_path / "run.nc") as file:
        assert file.attrs["committed_samples"] == 0 and np.all(np.isnan(file["time"]))


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.slow)])
def test_a_disk_that_fails_at_a_write_leaves_the_earlier_file_or_a_sound_one(
    every, plan, samples, tmp_path, monkeypatch
):
    path = tmp_path / "run.nc"
    with monkeypatch.context() as sound:
        disk = RecordedDisk(sound)
        write(path, plan, samples)
    earlier, left = EARLIER, []
    for fail_at in range(0, disk.calls - 1, every):  # the last one syncs the folder, which not all can
        path.write_bytes(earlier)
        with monkeypatch.context() as failing:
            RecordedDisk(failing, fail_at)
            try:
                write(path, plan, samples)
                left.append("ended")
            except OSError as error:
                assert error.filename == str(path) and error.strerror == "No space left on device"
        assert names_in(tmp_path) == ["run.nc"]
        left.append(earlier if path.read_bytes() == earlier else found(path, samples))
    if every == 1:
        # once all samples are there and only a second file can't be written, the first one takes the outcome
        assert list(dict.fromkeys(left)) == [earlier, *ENDS[:-1], "ended", ENDS[-1]]
    assert set(left) <= {earlier, *ENDS, "ended"} and len(set(left)) > 4


def test_a_disk_that_fails_while_hdf5_lays_a_file_out_is_said_once_it_is_closed(plan, tmp_path, monkeypatch):
    put, count = HeldBack.put, [0, math.inf]

    def failing(file, data):
        count[0] += 1
        if count[0] >= count[1]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return put(file, data)

    monkeypatch.setattr(HeldBack, "put", failing)
    ResultFile(tmp_path / "run.nc", plan, 0.0).close()
    for fail_at in range(1, count[0] + 1):
        count[:] = 0, fail_at
        with pytest.raises(OSError, match="No space left"):
            ResultFile(tmp_path / "run.nc", plan, 0.0)
    gc.collect()  # where HDF5 would crash on what it could not write


STAGES = {  # of a run in the order they come: function, how many calls go well before it fails
    "claiming room": ("os.posix_fallocate", 0),
    "syncing the new file": ("os.fsync", 0),
    "moving it into place": ("os.replace", 0),
    "the first commit": ("os.fsync", 2),  # the second sync is of the folder
    "its counter": ("os.fsync", 3),
}


@pytest.mark.parametrize("stage", STAGES)
def test_a_result_that_can_not_be_written_is_said_and_what_was_there_stays(stage, whole, tmp_path, monkeypatch, capsys):
    path = Path(shutil.copy(whole, tmp_path / "run.nc"))
    function, good = STAGES[stage]
    fail_after(monkeypatch, function, good)
    assert run_main([*SHORT, "--output", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {path}: Input/output error") and "Traceback" not in error
    assert names_in(tmp_path) == ["run.nc"]
    if good:
        with h5py.File(path) as file:
            assert file.attrs["status"] == "running"
    else:
        assert path.read_bytes() == whole.read_bytes()


def fail_after(monkeypatch, function, good):
    """Every call of a function of `os` after the first `good` ones fails."""
    name = function.removeprefix("os.")
    real, calls = getattr(os, name), itertools.count()

    def failing(*arguments):
        if next(calls) >= good:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return real(*arguments)

    monkeypatch.setattr(f"os.{name}", failing)


@pytest.mark.parametrize(
    "function",
    ["fem.result.checkpoint.open", "fem.result.checkpoint.np.savez", "lagrange.files.output.move_into_place"],
)
def test_a_checkpoint_that_can_not_be_written_leaves_the_last_one_and_the_run_goes_on(
    function, whole, tmp_path, monkeypatch, capsys
):
    path = tmp_path / "run.nc"
    assert run_main([*SHORT[:-1], "1", "--output", str(path)]) == 0
    kept = checkpoint_path(path).read_bytes()

    def fail(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(function, fail, raising=False)
    assert run_main([*SHORT, "--output", str(path), "--resume"]) == 0
    error = capsys.readouterr().err
    assert f"warning: {checkpoint_path(path)}: No space left" in error and "Traceback" not in error
    assert checkpoint_path(path).read_bytes() == kept
    assert same_data(path, whole)
    assert names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]


def test_a_full_disk_at_a_page_names_the_page(tmp_path, monkeypatch, capsys):
    """A write's own error names no file."""
    from fem.commands.rate_bearing import rate_main
    from fem.commands.run_study import study_main
    from residual.report import TEMPLATE
    from residual.store import Page, write_folder
    from tests.reference.small_study import TWO_SPEEDS

    def full(path, data, real=Path.write_bytes):
        if data.startswith(b"<!DOCTYPE html>"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(path, data)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    monkeypatch.setattr("fem.rating.figures.rating_figures", lambda *_: [])
    monkeypatch.setattr(Path, "write_bytes", full)
    assert rate_main(["--bearing", "NU206", "--output", "rated", "--quiet"]) == 2
    assert capsys.readouterr().err == "error: rated/rating.html: No space left on device\n"
    Path("study.toml").write_text(TWO_SPEEDS, encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--workers", "1"]) == 2
    assert capsys.readouterr().err == "error: studies/study/study.html: No space left on device\n"
    with pytest.raises(OSError) as raised:
        page = Page("report.html", TEMPLATE, {})
        write_folder(
            tmp_path / "report", "check-residual", {}, page,
            more=lambda fresh: full(fresh / "report.html", b"<!DOCTYPE html>"),
        )  # fmt: skip
    assert raised.value.filename == str(tmp_path / "report")


@pytest.mark.skipif(os.name != "posix", reason="POSIX limits")
def test_a_result_larger_than_a_file_may_be_is_refused_before_the_run(tmp_path):
    import resource

    path = tmp_path / "run.nc"
    path.write_bytes(EARLIER)
    small = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (10**6, 10**6))
    done = forked.run(["run-fem", *OPTIONS, "--duration", "60", "--output", str(path)], tmp_path, 60.0, before=small)
    assert done.code == 2
    assert f"error: {path}: File too large" in done.said and "Traceback" not in done.said
    assert names_in(tmp_path) == ["run.nc"] and path.read_bytes() == EARLIER


@pytest.mark.skipif(not hasattr(os, "posix_fallocate") or sys.platform != "linux", reason="Linux")
def test_a_run_whose_disk_fails_half_way_can_be_resumed(tmp_path):
    """The limit on file sizes is lowered while the run goes; it hits the variables that lie beyond it."""
    import resource

    path, other = tmp_path / "run.nc", tmp_path / "other.nc"
    arguments = [*OPTIONS, "--duration", "15", "--output"]
    process = subprocess.Popen(
        [sys.executable, "-m", "fem.commands.run_fem", *arguments, str(path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until(checkpoint_path(path).exists, process)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (800_000, 800_000))
    _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == 2
    assert f"error: {path}: File too large" in error and "--resume" in error and "Traceback" not in error
    assert names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]
    assert run_main([*arguments, str(path), "--resume"]) == 0
    assert run_main([*arguments, str(other)]) == 0
    assert same_data(path, other)


def mounts_tmpfs():
    """Whether this user may mount a file system in a name space of their own."""
    command = ["unshare", "--user", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    return shutil.which("unshare") is not None and subprocess.run(command, capture_output=True).returncode == 0


@pytest.mark.skipif(not mounts_tmpfs(), reason="needs user name spaces")
def test_on_a_disk_of_one_megabyte_a_run_that_fits_is_complete_and_one_that_does_not_is_refused(tmp_path):
    """1.02 MB of result leave no room for a checkpoint of 84 kB and for a second file to finish in."""
    disk, log = tmp_path / "disk", tmp_path / "log"
    disk.mkdir()
    run = f'"{sys.executable}" -m fem.commands.run_fem {" ".join(OPTIONS)} --output "{disk}/run.nc"'
    script = f"""
        mount -t tmpfs -o size=1m none "{disk}"
        {run} --duration 8.8; echo "exit $?"; cp "{disk}/run.nc" "{tmp_path}"; ls -A "{disk}"
        {run} --duration 12 --force; echo "exit $?"; cmp "{disk}/run.nc" "{tmp_path}/run.nc" && ls -A "{disk}"
    """
    with open(log, "w", encoding="utf-8") as out:
        subprocess.run(
            ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", script],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=out,
            stderr=subprocess.STDOUT,
        )
    lines = [line for line in log.read_text().splitlines() if not line.startswith("warning:")]
    assert f"warning: {disk}/run.nc.checkpoint: No space left on device" in log.read_text()
    assert lines[:2] == ["exit 0", "run.nc"]
    assert lines[2].startswith(f"error: {disk}/run.nc: No space left on device")
    assert lines[3:] == ["exit 2", "run.nc"]
    other = tmp_path / "other.nc"
    assert run_main([*OPTIONS, "--duration", "8.8", "--output", str(other)]) == 0
    assert same_data(tmp_path / "run.nc", other)

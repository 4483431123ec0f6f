"""Result files on disks that fail, fill up or tear a write; nothing is overwritten silently, no link followed."""

import errno
import gc
import itertools
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.signal  # noqa: F401 (as residual.report below)

import residual.report  # noqa: F401 (loaded before the right to do so is given up)
from fem.commands.rate_bearing import rate_main
from fem.commands.render_fem import render_main
from fem.commands.run_fem import result_name, run_main
from fem.commands.run_study import study_main
from fem.pictures.output import refuse_foreign, write_film
from fem.result import store
from fem.result.checkpoint import checkpoint_path
from fem.result.store import ResultFile
from fem.solver import compiling
from fem.solver.simulate import make_plan
from lagrange.columns import PER_TIME, columns_of
from lagrange.files.hdf5 import HeldBack, read_numbers
from lagrange.files.output import new_part, remove_left, replaced
from lagrange.scene.scene import read_scene
from residual.cli import main as check_main
from residual.report import TEMPLATE
from residual.store import Page, write_folder
from tests.reference import kit
from tests.reference.kit import EARLIER, OPTIONS, SHORT, environment, names_in, same_data
from tests.reference.synthetic_run import make_run, write_result
from tests.waiting import GIVE_UP, no_endless_wait, wait_until

BLOCKS = (1, 4, 15)  # samples appended and committed at a time, of 41
ROLLERS = 13
SECTOR = 512  # bytes a disk writes whole
ENDS = [(0, "running"), (1, "running"), (5, "running"), (20, "running"), (20, "interrupted")]
PRECIOUS = "time_s,load_x_N\n0,0\n1,2000\n"


class RecordedDisk:
    """A disk that remembers writes, syncs and moves, and can lose power at any moment.

    Give `fail_at` to have the call of that number, and all after it, fail for want of room.
    """

    def __init__(self, monkeypatch, fail_at=math.inf):
        self.calls, self.log = 0, []  # ("write", file, place, bytes), ("move", file, path, content), ("sync",)
        for owner, name, told in (
            (store, "write_at", lambda handle, data, at: ("write", os.fstat(handle).st_ino, at, bytes(data))),
            (store, "move_into_place", lambda a, b: ("move", os.stat(a).st_ino, b, a.read_bytes())),
            (os, "fsync", lambda handle: ("sync",)), (os, "posix_fallocate", lambda *_: ("claim",)),
            # what is changed in place needs no room
            (HeldBack, "put", lambda file, data: ("lay out",) if str(file.name).endswith(".part") else None),
        ):  # fmt: skip
            monkeypatch.setattr(owner, name, self._watched(getattr(owner, name), told, fail_at))

    def _watched(self, real, told, fail_at):
        def call(*given):
            if (event := told(*given)) is not None:
                if self.calls >= fail_at:
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                self.calls += 1
                self.log.append(event)
            return real(*given)

        return call

    def after(self, path, numbers=None, tries=1):
        """The content of a file after each call, which a killed process leaves; with random numbers after power cuts:
        any of the sectors since the last sync on the disk or not."""
        there, synced, since = None, None, []
        for kind, *what in self.log:
            if kind == "move" and what[1] == path:
                there, synced, since = what[0], bytearray(what[2]), []
            elif kind == "write" and what[0] == there:
                place, data = what[1:]
                borders = [place, *range(place - place % SECTOR + SECTOR, place + len(data), SECTOR), place + len(data)]
                since += [(a, data[a - place : b - place]) for a, b in itertools.pairwise(borders)]
            for _ in range(tries if synced is not None else 0):
                content = synced.copy()
                for place, data in since:
                    if numbers is None or numbers.random() < 0.5:
                        content[place : place + len(data)] = data
                yield bytes(content)
            if kind == "sync":
                for place, data in since:
                    synced[place : place + len(data)] = data
                since = []


@pytest.fixture(scope="module")
def plan():
    return make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=0.4")))


@pytest.fixture(scope="module")
def samples():
    n, numbers = sum(BLOCKS), np.random.default_rng(1)
    return {
        name: numbers.uniform(size=n if dimensions == PER_TIME else (n, ROLLERS))
        for name, (dimensions, *_) in columns_of("").items()
    }


def write(path, plan, samples):
    with ResultFile(path, plan, 0.0) as file:
        for start, end in itertools.pairwise(itertools.accumulate((0, *BLOCKS))):
            file.append({name: values[start:end] for name, values in samples.items()})
            file.commit()
        file.finish("interrupted", steps=7, wall_seconds=1.5)


def found(path, samples):
    """Number of samples and status of a file that any HDF5 reader can open; its samples must be right."""
    with h5py.File(path, "r", locking=False) as file:
        count = int(file.attrs["committed_samples"])
        for name in columns_of(""):
            np.testing.assert_array_equal(read_numbers(file, name, count), samples[name][:count])
        return count, file.attrs["status"]


def test_kills_and_power_cuts_leave_the_samples_of_the_last_commit(plan, samples, tmp_path, monkeypatch):
    """After any write, and whichever sectors had reached the disk. The counter, eight aligned bytes, is not torn."""
    path, probe = tmp_path / "run.nc", tmp_path / "probe.nc"
    with ResultFile(path, plan, 0.0) as result:
        assert result._places.committed % 8 == 0
    with h5py.File(path) as file:
        assert file.attrs["committed_samples"] == 0 and np.all(np.isnan(file["time"]))
    disk = RecordedDisk(monkeypatch)
    write(path, plan, samples)

    def ends(contents):
        for content in dict.fromkeys(contents):
            probe.write_bytes(content)
            yield found(probe, samples)

    killed = list(ends(disk.after(path)))
    assert len(killed) > 3 * 2 * len(columns_of("")) and list(dict.fromkeys(killed)) == ENDS
    cut = [ENDS.index(end) for end in ends(disk.after(path, np.random.default_rng(5), tries=2))]
    assert len(cut) > 200 and set(cut) == set(range(len(ENDS)))
    assert all(later >= sooner - 1 for sooner, later in itertools.pairwise(cut))  # the commit in work is on it or not


@pytest.mark.parametrize("every", [11, pytest.param(1, marks=pytest.mark.slow)])
def test_a_disk_that_fails_leaves_the_earlier_file_or_a_sound_one(every, plan, samples, tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    with monkeypatch.context() as sound:
        disk = RecordedDisk(sound)
        write(path, plan, samples)
    left = []
    for fail_at in range(0, disk.calls - 1, every):  # the last one syncs the folder, which not all can
        path.write_bytes(EARLIER)
        with monkeypatch.context() as failing:
            RecordedDisk(failing, fail_at)
            try:
                write(path, plan, samples)
                left.append("ended")
            except OSError as error:
                assert error.filename == str(path) and error.strerror.startswith("No space left on device")
        assert names_in(tmp_path) == ["run.nc"]
        left.append("earlier" if path.read_bytes() == EARLIER else found(path, samples))
    if every == 1:  # once all samples are there and only a second file can't be written, the first takes the outcome
        assert list(dict.fromkeys(left)) == ["earlier", *ENDS[:-1], "ended", ENDS[-1]]
    assert set(left) <= {"earlier", *ENDS, "ended"} and len(set(left)) > 4
    gc.collect()  # where HDF5 would crash on what it could not write


def test_a_result_that_can_not_be_written_is_said_and_samples_stay(whole, tmp_path, monkeypatch, capsys):
    path, calls, real = Path(shutil.copy(whole, tmp_path / "run.nc")), itertools.count(), os.fsync

    def failing(*arguments):
        if next(calls) >= 2:  # the first sync is of the new file, the second of the folder
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return real(*arguments)

    monkeypatch.setattr(os, "fsync", failing)
    assert run_main([*SHORT, "--output", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {path}: Input/output error") and "Traceback" not in error
    assert names_in(tmp_path) == ["run.nc"] and kit.attributes(path)["status"] == "running"


@pytest.mark.parametrize("function", ["result.checkpoint.open", "result.checkpoint.np.savez", "move_into_place"])
def test_a_checkpoint_that_can_not_be_written_leaves_the_last_one(function, whole, tmp_path, monkeypatch, capsys):
    path = tmp_path / "run.nc"
    assert run_main([*SHORT[:-1], "1", "--output", str(path)]) == 0
    kept = checkpoint_path(path).read_bytes()

    def fail(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    inside = "lagrange.files.output" if function == "move_into_place" else "fem"
    monkeypatch.setattr(f"{inside}.{function}", fail, raising=False)
    assert run_main([*SHORT, "--output", str(path), "--resume"]) == 0
    error = capsys.readouterr().err
    assert f"warning: {checkpoint_path(path)}: No space left" in error and "Traceback" not in error
    assert checkpoint_path(path).read_bytes() == kept and same_data(path, whole)
    assert names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]


def test_a_full_disk_at_a_page_names_the_page(here, monkeypatch, capsys):
    """A write's own error names no file."""

    def full(path, data, real=Path.write_bytes):
        if data.startswith(b"<!DOCTYPE html>"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(path, data)

    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    monkeypatch.setattr("fem.rating.figures.rating_figures", lambda *_: [])
    monkeypatch.setattr(Path, "write_bytes", full)
    assert rate_main(["--bearing", "NU206", "--output", "rated", "--quiet"]) == 2
    assert capsys.readouterr().err == "error: rated/rating.html: No space left on device\n"
    Path("study.toml").write_text(kit.TWO_SPEEDS, encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--workers", "1"]) == 2
    assert capsys.readouterr().err == "error: studies/study/study.html: No space left on device\n"
    page, fill = Page("report.html", TEMPLATE, {}), lambda fresh: full(fresh / "report.html", b"<!DOCTYPE html>")
    with pytest.raises(OSError) as raised:
        write_folder(here / "report", "check-residual", {}, page, more=fill)
    assert raised.value.filename == str(here / "report")


def test_a_result_larger_than_a_file_may_be_is_refused_before_the_run(tmp_path):
    path = tmp_path / "run.nc"
    path.write_bytes(EARLIER)
    small = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (10**6, 10**6))
    done = kit.command("run-fem", *OPTIONS, "--duration", "60", "--output", path, prepare=small)
    assert done.returncode == 2 and f"error: {path}: File too large" in done.stderr and "Traceback" not in done.stderr
    assert names_in(tmp_path) == ["run.nc"] and path.read_bytes() == EARLIER


@pytest.mark.skipif(sys.platform != "linux", reason="Linux")
def test_a_run_whose_disk_fails_half_way_can_be_resumed(tmp_path):
    """The limit on file sizes is lowered while the run goes; it hits the variables that lie beyond it."""
    path, other = tmp_path / "run.nc", tmp_path / "other.nc"
    arguments = [*OPTIONS, "--duration", "15", "--output"]
    run_fem = [*kit.started_as("run-fem"), *arguments, str(path)]
    process = subprocess.Popen(run_fem, env=environment(), stderr=subprocess.PIPE, text=True)
    wait_until(checkpoint_path(path).exists, process)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (800_000, 800_000))
    _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == 2
    assert f"error: {path}: File too large" in error and "--resume" in error and "Traceback" not in error
    assert names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]
    assert run_main([*arguments, str(path), "--resume"]) == run_main([*arguments, str(other)]) == 0
    assert same_data(path, other)


# Nothing is overwritten silently, no link or pipe in the way of a file is followed
QUICK = ["--model", "reduced", "--duration", "0.5", "--quiet"]


@pytest.fixture
def kept(here):
    assert run_main(QUICK) == 0
    return here / "runs" / "paper.nc"


def test_a_complete_run_is_replaced_by_its_own_scene_or_by_force_and_what_is_incomplete_by_any(kept, capsys):
    before, faster = kept.read_bytes(), ["--output", str(kept), "--set", "operation.speed_rpm=5000"]
    assert run_main([*QUICK, *faster]) == 2
    told = capsys.readouterr().err
    assert "operation.speed_rpm was 4500.0, now 5000.0" in told and "--force" in told and "--output" in told
    for duration, resume in (("0.7", True), ("0.3", False)):
        kept.write_bytes(before)
        other = ["--model", "reduced", "--duration", duration, "--quiet"]
        assert run_main(other) == 2 and ("--resume extends it" in capsys.readouterr().err) is resume
        assert kept.read_bytes() == before and run_main([*other, "--resume" if resume else "--force"]) == 0
    assert run_main([*QUICK, *faster, "--force"]) == 0 and "speed_rpm = 5000.0" in kit.attributes(kept)["scene"]
    assert run_main([*QUICK, *faster]) == 0
    with h5py.File(kept, "r+") as file:
        file.attrs.modify("status", "interrupted")
    assert run_main([*QUICK, *kit.sets("numerics.output_interval_us=20"), "--output", str(kept)]) == 0
    kept.write_bytes(kept.read_bytes()[:3000])
    assert run_main(QUICK) == 0


def test_names_say_what_was_set_and_stay_names_of_files_and_long_ones_are_cut_and_stay_apart(kept):
    speed, friction = "operation.speed_rpm=3000", "contact.friction_coefficient = 0"
    for settings, name in {
        (): "a", (speed, friction): "a-speed_rpm-3000-friction_coefficient-0",
        ("spall.0.width_mm=2",): "a-spall.0.width_mm-2", ("numerics.duration_ms=90", "name=a"): "a",
        ('profile.0.file="../x y.csv"',): "a-profile.0.file-_.._x_y.csv_",
    }.items():  # fmt: skip
        assert result_name("a", list(settings)) == name
    assert run_main([*QUICK, "--set", speed]) == 0
    assert {path.name for path in kept.parent.glob("*.nc")} == {"paper.nc", "paper-speed_rpm-3000.nc"}
    names = {result_name("a", ["lagrange.law=" + 200 * "x" + end]) for end in "pq"}
    assert len(names) == 2 and all(len(name) < 140 for name in names)


def put(kind, place):
    """Put a file, a link to one or a pipe there; gives the function that says whether it has stayed as it was."""
    precious, there = place.parents[1] / f"precious{place.suffix}", {"pipe": place.is_fifo}
    precious.write_text(PRECIOUS)
    make = {"file": lambda: place.write_text(PRECIOUS), "link": lambda: place.symlink_to(precious)}
    make.get(kind, lambda: os.mkfifo(place))()
    return lambda: precious.read_text() == PRECIOUS and there.get(kind, lambda: place.read_text() == PRECIOUS)()


@pytest.mark.parametrize("name", ["paper.nc.part", "paper.nc.checkpoint.part", "paper.nc.checkpoint"])
@pytest.mark.parametrize("kind", ["file", "link", "pipe"])
def test_what_stands_under_a_name_that_a_run_may_need_stays(name, kind, here, capsys):
    (here / "runs").mkdir()
    stays = put(kind, here / "runs" / name)
    with no_endless_wait():
        assert run_main(QUICK) == (0 if name.endswith(".part") else 2)
    assert stays()
    if name.endswith(".part"):
        assert {path.name for path in Path("runs").iterdir()} >= {name, "paper.nc"}
    else:
        assert "paper.nc.checkpoint: is no" in capsys.readouterr().err


def test_files_left_on_their_way_are_removed_those_of_others_stay_and_the_longest_name_has_parts(tmp_path):
    ours, others = new_part(tmp_path / "a.nc"), [new_part(tmp_path / "b.nc"), tmp_path / "a.nc.part"]
    others[1].write_text("")
    remove_left(tmp_path / "a.nc")
    assert not ours.exists() and all(other.exists() for other in others)
    (tmp_path / "long").mkdir()
    place = tmp_path / "long" / ("a" * 255)
    with replaced(place) as part:
        part.write_text("new")
    assert place.read_text() == "new" and list(place.parent.iterdir()) == [place]


@pytest.mark.parametrize("ending", [".csv", ".wav", ".vtu", ".vtkhdf", ".gif", ".mp4", ".png"])
@pytest.mark.parametrize("kind", ["file", "link", "pipe"])
def test_only_an_export_is_replaced_by_an_export(ending, kind, kept, capsys):
    option = {".gif": "--animation", ".mp4": "--animation", ".png": "--output"}.get(ending, "--export")
    place = kept.with_name(f"target{ending}")
    stays = put(kind, place)
    with no_endless_wait():
        assert render_main([str(kept), option, str(place), "--quiet"]) == 2
    told = capsys.readouterr().err
    assert str(place) in told and ("not a plain file" if kind == "pipe" else "--force") in told and stays()


@pytest.mark.parametrize("ending", [".csv", ".wav", ".vtu", ".vtkhdf"])
def test_an_export_is_replaced_by_the_next_and_any_file_by_force(ending, kept, coarse_run):
    source, place = kept if ending in (".csv", ".wav") else coarse_run, kept.with_name(f"target{ending}")
    some = ["--frames", "2"] if ending == ".vtkhdf" else []
    place.write_text(PRECIOUS)
    for options in (["--force"], []):
        assert render_main([str(source), "--export", str(place), "--quiet", *some, *options]) == 0
    assert place.read_bytes() != PRECIOUS.encode()


def test_films_are_known_as_such(tmp_path):
    images = np.zeros((2, 64, 64, 3), dtype=np.uint8)
    for place in (tmp_path / "a.gif", tmp_path / "a.mp4"):
        write_film(place, iter(images), 25.0, images[0])
        refuse_foreign(place, force=False)


@pytest.mark.usefixtures("plain_report")
def test_a_report_replaces_the_files_it_has_listed_and_no_others(kept, capsys):
    folder = kept.with_name("report")
    arguments = [str(kept), "--quiet", "--no-figures", "--export", "csv", "--output", str(folder)]
    assert check_main(arguments) == check_main(arguments) == 0
    (folder / "mine.csv").write_text(PRECIOUS)
    assert check_main(arguments) == 2 and "mine.csv, which is not part of a report" in capsys.readouterr().err
    (folder / "mine.csv").unlink()
    (folder / "summary.json").unlink()
    os.mkfifo(folder / "summary.json")
    with no_endless_wait():
        assert check_main(arguments) == 2


def test_a_pipe_in_the_place_of_what_is_remembered_is_not_waited_for(tmp_path, monkeypatch):
    os.mkfifo(place := tmp_path / "pace.json")
    monkeypatch.setattr(compiling, "pace_file", lambda: place)
    with no_endless_wait():
        compiling.remember("reduced", 1.0, 2.0)
        assert compiling.pace("reduced") == 1.0


# Folders and files that can't be written, are open elsewhere, or are something else than they should be
@pytest.fixture
def closed_folder():
    """A folder with a result in it that this user can't write to (and one in it that they can); for root, as nobody."""
    folder = Path(tempfile.mkdtemp())
    (folder / "open").mkdir()
    (folder / "open").chmod(0o777)
    for path in (folder / "run.nc", folder / "open" / "run.nc"):
        write_result(path, make_run(n_times=40))
        path.chmod(0o444)
    folder.chmod(0o555)
    as_root = os.geteuid() == 0
    if as_root:
        os.seteuid(65534)
    try:
        yield folder
    finally:
        if as_root:
            os.seteuid(0)
        folder.chmod(0o755)
        shutil.rmtree(folder)


@pytest.mark.usefixtures("whole")  # kernels are compiled
def test_a_folder_or_file_that_can_not_be_written_is_named_and_left_alone(closed_folder, capsys):
    """A read-only file in an open folder could be renamed away, which its owner will not want."""
    path, content = closed_folder / "run.nc", (closed_folder / "run.nc").read_bytes()
    for command, arguments in (
        (run_main, [*SHORT, "--force", "--output", str(closed_folder / "fresh.nc")]),
        (run_main, [*SHORT, "--force", "--output", str(path)]),
        (run_main, [*SHORT, "--force", "--output", str(closed_folder / "open" / "run.nc")]),
        (run_main, [*SHORT, "--force", "--output", str(closed_folder / "deeper" / "run.nc")]),
        (check_main, [str(path)]),
    ):
        assert command(arguments) == 2
        error = capsys.readouterr().err
        assert str(closed_folder) in error and "Permission denied" in error and "Traceback" not in error
    assert names_in(closed_folder) == ["open", "run.nc"] and names_in(closed_folder / "open") == ["run.nc"]
    assert path.read_bytes() == (closed_folder / "open" / "run.nc").read_bytes() == content


@pytest.mark.parametrize("command", ["write", "resume"])
def test_a_result_that_is_open_elsewhere_is_left_alone(command, whole, tmp_path, capsys):
    path = Path(shutil.copy(whole, tmp_path / "run.nc"))
    shutil.copy(checkpoint_path(whole), checkpoint_path(path))
    before = path.read_bytes()
    with h5py.File(path, "r"):
        resume = ["--resume"] if command == "resume" else []
        assert run_main([*SHORT, "--output", str(path), *resume]) == 2
    assert f"{path}: is in use" in capsys.readouterr().err
    assert path.read_bytes() == before and names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]


@pytest.mark.parametrize("what", ["a folder", "a pipe", "a link to itself", "a scene"])
def test_what_is_no_result_is_not_replaced(what, tmp_path, capsys):
    path, scene = tmp_path / "run.toml", 'name = "mine"\n'
    make = {"a folder": path.mkdir, "a pipe": partial(os.mkfifo, path), "a scene": partial(path.write_text, scene)}
    make.get(what, partial(path.symlink_to, path))()
    for arguments in (SHORT, [path, "--model", "lagrange"], [path, *SHORT]) if what == "a scene" else (SHORT,):
        assert run_main([*map(str, arguments), "--output", str(path)]) == 2
        error = capsys.readouterr().err
        assert str(path) in error and (what != "a scene" or "is no result file (HDF5) and is not replaced" in error)
    assert names_in(tmp_path) == ["run.toml"]
    assert path.read_text() == scene if what == "a scene" else not path.is_file()


@pytest.mark.parametrize("what", ["a folder in its place", "a name too long for it"])
def test_a_run_whose_checkpoint_has_no_place_is_refused_before_it_replaces_anything(what, whole, tmp_path, capsys):
    path = tmp_path / ("run.nc" if what == "a folder in its place" else "x" * 243 + ".nc")
    shutil.copy(whole, path)
    if what == "a folder in its place":
        checkpoint_path(path).mkdir()
    assert run_main([*SHORT, "--output", str(path)]) == 2
    error = capsys.readouterr().err
    assert f"error: {checkpoint_path(path)}: " in error and error.count("\n") == 1
    assert path.read_bytes() == whole.read_bytes()


def test_a_link_keeps_leading_to_the_result(whole, tmp_path):
    (tmp_path / "disk").mkdir()
    link, target = tmp_path / "run.nc", tmp_path / "disk" / "result.nc"
    target.write_bytes(EARLIER)
    link.symlink_to(target)
    assert run_main([*SHORT, "--output", str(link)]) == 0 and link.is_symlink() and same_data(target, whole)

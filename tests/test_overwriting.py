"""Nothing is overwritten silently, no link or pipe in the way of a file is followed."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.signal  # noqa: F401 (as residual.store below)

import residual.store  # noqa: F401 (loaded before the right to do so is given up)
from fem.commands.render_fem import render_main
from fem.commands.run_fem import result_name, run_main
from fem.pictures.output import refuse_foreign
from fem.result.checkpoint import checkpoint_path
from lagrange.files.output import new_part, remove_left, replaced
from residual.cli import main as check_main
from tests.reference.run_files import EARLIER, names_in, same_data
from tests.reference.run_files import SHORT as SHORT_UNWRITABLE_PLACES
from tests.reference.synthetic_run import make_run, write_result
from tests.waiting import no_endless_wait

SHORT = ["--model", "reduced", "--duration", "0.5", "--quiet"]


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A complete run in runs/paper.nc."""
    monkeypatch.chdir(tmp_path)
    assert run_main(SHORT) == 0
    return tmp_path / "runs" / "paper.nc"


def test_a_complete_run_of_another_scene_is_replaced_by_force_only(kept, capsys):
    before = kept.read_bytes()
    faster = ["--output", str(kept), "--set", "operation.speed_rpm=5000"]
    assert run_main([*SHORT, *faster]) == 2
    told = capsys.readouterr().err
    assert "operation.speed_rpm was 4500.0, now 5000.0" in told and "--force" in told and "--output" in told
    assert kept.read_bytes() == before
    assert run_main([*SHORT, *faster, "--force"]) == 0
    with h5py.File(kept) as file:
        assert "speed_rpm = 5000.0" in file.attrs["scene"]


@pytest.mark.parametrize(("duration", "extends"), [("0.7", True), ("0.3", False)])
def test_a_longer_run_may_extend_what_is_there(kept, capsys, duration, extends):
    longer = ["--model", "reduced", "--duration", duration, "--quiet"]
    assert run_main(longer) == 2
    assert ("--resume extends it" in capsys.readouterr().err) is extends
    assert run_main([*longer, "--resume" if extends else "--force"]) == 0


def test_the_same_scene_runs_again_into_its_file(kept):
    assert run_main(SHORT) == 0


def test_what_is_incomplete_or_damaged_may_be_replaced(kept):
    other = [*SHORT, "--set", "numerics.output_interval_us=20", "--output", str(kept)]
    with h5py.File(kept, "r+") as file:
        file.attrs.modify("status", "interrupted")
    assert run_main(other) == 0
    kept.write_bytes(kept.read_bytes()[:3000])
    assert run_main(SHORT) == 0


def test_a_setting_changes_the_default_name(kept):
    assert run_main([*SHORT, "--set", "operation.speed_rpm=5000"]) == 0
    assert {path.name for path in kept.parent.glob("*.nc")} == {"paper.nc", "paper-speed_rpm-5000.nc"}


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ([], "a"),
        (["operation.speed_rpm=3000", "contact.friction_coefficient = 0"], "a-speed_rpm-3000-friction_coefficient-0"),
        (["spall.0.width_mm=2"], "a-spall.0.width_mm-2"),
        (["numerics.duration_ms=90", "name=a"], "a"),
        (['profile.0.file="../x y.csv"'], "a-profile.0.file-_.._x_y.csv_"),
    ],
)
def test_names_say_what_was_set_and_stay_names_of_files(settings, name):
    assert result_name("a", settings) == name


def test_long_names_are_cut_and_stay_apart():
    names = {result_name("a", ["lagrange.law=" + 200 * "x" + end]) for end in "pq"}
    assert len(names) == 2 and all(len(name) < 140 for name in names)


PRECIOUS = "time_s,load_x_N\n0,0\n1,2000\n"


def put(kind, place):
    """Put a file, a link to one or a pipe there; gives the function that says whether it has stayed as it was."""
    precious = place.parents[1] / f"precious{place.suffix}"
    precious.write_text(PRECIOUS)
    {"file": lambda: place.write_text(PRECIOUS), "link": lambda: place.symlink_to(precious),
     "pipe": lambda: os.mkfifo(place)}[kind]()  # fmt: skip
    return lambda: (
        precious.read_text() == PRECIOUS and (place.is_fifo() if kind == "pipe" else place.read_text() == PRECIOUS)
    )


@pytest.mark.parametrize("name", ["paper.nc.part", "paper.nc.checkpoint.part"])
@pytest.mark.parametrize("kind", ["file", "link", "pipe"])
def test_what_stands_under_a_name_that_a_run_may_need_stays(name, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    place = tmp_path / "runs" / name
    stays = put(kind, place)
    with no_endless_wait():
        assert run_main(SHORT) == 0
    assert stays()
    assert {path.name for path in place.parent.iterdir()} >= {name, "paper.nc"}


@pytest.mark.parametrize("kind", ["file", "link", "pipe"])
def test_a_checkpoint_that_is_none_is_neither_removed_nor_replaced(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    stays = put(kind, tmp_path / "runs" / "paper.nc.checkpoint")
    with no_endless_wait():
        assert run_main(SHORT) == 2
    assert "paper.nc.checkpoint: is no" in capsys.readouterr().err
    assert stays()


def test_files_left_on_their_way_are_removed_and_those_of_others_stay(tmp_path):
    ours, others = new_part(tmp_path / "a.nc"), [new_part(tmp_path / "b.nc"), tmp_path / "a.nc.part"]
    others[1].write_text("")
    remove_left(tmp_path / "a.nc")
    assert not ours.exists() and all(other.exists() for other in others)


def test_a_name_as_long_as_the_disk_takes_has_parts_of_its_own(tmp_path):
    place = tmp_path / ("a" * 255)
    with replaced(place) as part:
        part.write_text("new")
    assert place.read_text() == "new" and list(tmp_path.iterdir()) == [place]


@pytest.mark.parametrize("ending", [".csv", ".wav", ".vtu", ".vtkhdf", ".gif", ".mp4", ".png"])
@pytest.mark.parametrize("kind", ["file", "link", "pipe"])
def test_only_an_export_is_replaced_by_an_export(ending, kind, kept, capsys):
    option = {".gif": "--animation", ".mp4": "--animation", ".png": "--output"}.get(ending, "--export")
    place = kept.with_name(f"target{ending}")
    stays = put(kind, place)
    with no_endless_wait():
        assert render_main([str(kept), option, str(place), "--quiet"]) == 2
    told = capsys.readouterr().err
    assert str(place) in told and ("not a plain file" if kind == "pipe" else "--force") in told
    assert stays()


@pytest.mark.parametrize("ending", [".csv", ".wav", ".vtu", ".vtkhdf"])
def test_an_export_is_replaced_by_the_next_and_any_file_by_force(ending, kept, coarse_run):
    source, place = kept if ending in (".csv", ".wav") else coarse_run, kept.with_name(f"target{ending}")
    some = ["--frames", "2"] if ending == ".vtkhdf" else []
    place.write_text(PRECIOUS)
    for options in (["--force"], []):
        assert render_main([str(source), "--export", str(place), "--quiet", *some, *options]) == 0
    assert place.read_bytes() != PRECIOUS.encode()
    if ending == ".wav":
        from scipy.io import wavfile

        rate, signals = wavfile.read(place)
        assert rate == 25600 and signals.dtype == np.float32 and signals.shape[1] == 2


@pytest.mark.parametrize("ending", [".gif", ".mp4"])
def test_films_are_known_as_such(ending, tmp_path):
    from fem.pictures.output import write_film

    place, palette = tmp_path / f"a{ending}", np.zeros((1, 3), dtype=np.uint8)
    write_film(place, iter(np.zeros((2, 64, 64, 3), dtype=np.uint8)), 25.0, palette)
    refuse_foreign(place, force=False)


@pytest.mark.usefixtures("plain_report")
def test_a_report_replaces_the_files_it_has_listed_and_no_others(kept, capsys):
    folder = kept.with_name("report")
    arguments = [str(kept), "--quiet", "--no-figures", "--export", "csv", "--output", str(folder)]
    assert check_main(arguments) == check_main(arguments) == 0
    (folder / "mine.csv").write_text(PRECIOUS)
    assert check_main(arguments) == 2
    assert "mine.csv, which is not part of a report" in capsys.readouterr().err
    (folder / "mine.csv").unlink()
    (folder / "summary.json").unlink()
    os.mkfifo(folder / "summary.json")
    with no_endless_wait():
        assert check_main(arguments) == 2


def test_a_pipe_in_the_place_of_what_is_remembered_is_not_waited_for(tmp_path, monkeypatch):
    from fem.solver import compiling

    os.mkfifo(place := tmp_path / "pace.json")
    monkeypatch.setattr(compiling, "pace_file", lambda: place)
    with no_endless_wait():
        compiling.remember("reduced", 1.0, 2.0)
        assert compiling.pace("reduced") == 1.0


# Folders and files that can't be written, are open elsewhere, or are something else than they should be


ROOT = Path(__file__).resolve().parent.parent


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
    as_root = hasattr(os, "geteuid") and os.geteuid() == 0
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
        (run_main, [*SHORT_UNWRITABLE_PLACES, "--force", "--output", str(closed_folder / "fresh.nc")]),
        (run_main, [*SHORT_UNWRITABLE_PLACES, "--force", "--output", str(path)]),
        (run_main, [*SHORT_UNWRITABLE_PLACES, "--force", "--output", str(closed_folder / "open" / "run.nc")]),
        (run_main, [*SHORT_UNWRITABLE_PLACES, "--force", "--output", str(closed_folder / "deeper" / "run.nc")]),
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
        assert (
            run_main([*SHORT_UNWRITABLE_PLACES, "--output", str(path), *(["--resume"] if command == "resume" else [])])
            == 2
        )
    assert f"{path}: is in use" in capsys.readouterr().err
    assert path.read_bytes() == before and names_in(tmp_path) == ["run.nc", "run.nc.checkpoint"]


@pytest.mark.parametrize("what", ["a folder", "a pipe", "a link to itself"])
def test_what_is_no_plain_file_is_not_replaced(what, tmp_path, capsys):
    path = tmp_path / "run.nc"
    if what == "a folder":
        path.mkdir()
    elif what == "a pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(path)
    assert run_main([*SHORT_UNWRITABLE_PLACES, "--output", str(path)]) == 2
    assert str(path) in capsys.readouterr().err
    assert names_in(tmp_path) == ["run.nc"] and not path.is_file()


@pytest.mark.parametrize("model", ["fem", "lagrange"])
def test_a_scene_is_not_replaced_by_its_result(model, tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text('name = "mine"\n')
    assert run_main([str(path), "--model", model, "--mesh-size", "2", "--duration", "2", "--output", str(path)]) == 2
    assert f"{path}: is no result file (HDF5) and is not replaced" in capsys.readouterr().err
    assert names_in(tmp_path) == ["scene.toml"] and path.read_text() == 'name = "mine"\n'


@pytest.mark.parametrize("what", ["a folder in its place", "a name too long for it"])
def test_a_run_whose_checkpoint_has_no_place_is_refused_before_it_replaces_anything(what, whole, tmp_path, capsys):
    folder = what == "a folder in its place"
    path = tmp_path / ("run.nc" if folder else "x" * 243 + ".nc")
    shutil.copy(whole, path)
    if folder:
        checkpoint_path(path).mkdir()
    assert run_main([*SHORT_UNWRITABLE_PLACES, "--output", str(path)]) == 2
    error = capsys.readouterr().err
    assert f"error: {checkpoint_path(path)}: " in error and error.count("\n") == 1
    assert path.read_bytes() == whole.read_bytes()


@pytest.mark.usefixtures("whole")  # kernels are compiled
def test_a_closed_standard_error_stops_no_run(tmp_path):
    path = tmp_path / "run.nc"
    command = f'"{sys.executable}" -m fem.commands.run_fem --mesh-size 2 --duration 2 --output "{path}" 2>&-'
    assert subprocess.run(command, shell=True, env={**os.environ, "PYTHONPATH": str(ROOT)}).returncode == 0
    with h5py.File(path) as file:
        assert file.attrs["status"] == "complete"


def test_a_link_keeps_leading_to_the_result(whole, tmp_path):
    (tmp_path / "disk").mkdir()
    link, target = tmp_path / "run.nc", tmp_path / "disk" / "result.nc"
    target.write_bytes(EARLIER)
    link.symlink_to(target)
    assert run_main([*SHORT_UNWRITABLE_PLACES, "--output", str(link)]) == 0
    assert link.is_symlink() and same_data(target, whole)

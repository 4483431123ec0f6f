"""Folders and files that can't be written, are open elsewhere, or are something else than they should be."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import pytest
import scipy.signal  # noqa: F401 (as residual.store below)

import residual.store  # noqa: F401 (loaded before the right to do so is given up)
from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from residual.cli import main as check_main
from tests.reference.run_files import EARLIER, SHORT, names_in, same_data
from tests.reference.synthetic_run import make_run, write_result

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
        assert run_main([*SHORT, "--output", str(path), *(["--resume"] if command == "resume" else [])]) == 2
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
    assert run_main([*SHORT, "--output", str(path)]) == 2
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
    assert run_main([*SHORT, "--output", str(path)]) == 2
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
    assert run_main([*SHORT, "--output", str(link)]) == 0
    assert link.is_symlink() and same_data(target, whole)

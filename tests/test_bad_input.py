"""Every kind of unusable input: exit code 2, the culprit named, no traceback, nothing written."""

import contextlib
import os
import threading
import time

import h5py
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from residual.cli import main as check_main
from tests.reference.bad_files import BAD_CHECKPOINTS, BAD_FILES, BAD_PICTURES, DURATION, FINISHED, RUN
from tests.reference.bad_scenes import BAD_SCENES, BAD_SETTINGS
from tests.reference.synthetic_run import write_result

KINDS = {"scene": BAD_SCENES, "settings": BAD_SETTINGS, "file": BAD_FILES, "picture": BAD_PICTURES,
         "checkpoint": BAD_CHECKPOINTS}  # fmt: skip
CASES = [(kind, name) for kind, cases in KINDS.items() for name in cases]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    assert run_main([*FINISHED, *DURATION, "--output", str(folder / "run.nc")]) == 0
    return folder


def contents(folder):
    return {path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_unusable_input_exits_2_names_the_culprit_and_leaves_nothing(kind, name, tmp_path, monkeypatch, capfd, request):
    monkeypatch.chdir(tmp_path)
    given = (tmp_path, request.getfixturevalue("finished")) if kind == "checkpoint" else (tmp_path,)
    command, arguments, words = KINDS[kind][name](*given)
    before = contents(tmp_path)
    try:
        code = command(arguments)
    except SystemExit as stop:  # the option parser's own way out
        code = stop.code
    out, error = capfd.readouterr()
    assert code == 2
    assert all(word in error for word in words), error
    assert "Traceback" not in error and "Warning" not in error and out == ""
    assert len(error) < 5000 and all(c.isprintable() or c == "\n" for c in error)
    assert contents(tmp_path) == before


AT_ONCE = {
    "values": (
        "[bearing]\nrollers = 'x'\n[operation]\nspeed_rmp = 1\n[contact]\nfriction_coefficient = 9\n",
        ("bearing.rollers", "operation.speed_rmp", "contact.friction_coefficient"),
    ),
    "values of one table that contradict each other": (
        "[bearing]\nrollers = 20\nbore_diameter_mm = 40\noutside_diameter_mm = 50\n[numerics]\nduration_ms = -1\n",
        ("rollers = 20", "bore_diameter_mm = 40", "outside_diameter_mm = 50", "numerics.duration_ms"),
    ),
    "values of several tables": (
        "[operation]\ninner_ring_and_shaft_kg = 0.01\n[numerics]\nmesh_size_mm = 9\n[lagrange]\nlaw = 'hooke'\n",
        ("inner_ring_and_shaft_kg = 0.01", "mesh_size_mm = 9", "lagrange.law = 'hooke'"),
    ),
    "contradictions beside values and keys that can't be used": (
        "[bearing]\nbore_diameter_mm = 40\nrolers = 12\nroller_diameter_mm = 11\nroller_length_mm = -1\n"
        "[operation]\ninner_ring_and_shaft_kg = 0.01\n[numerics]\noutput_interval_us = nan\nmesh_size_mm = 9\n",
        ("bore_diameter_mm = 40", "rolers", "more preload", "roller_length_mm = -1", "interval_us", "mesh_size_mm = 9"),
    ),
    "contradictions beside a table that is none": (
        "bearing = 3\n[numerics]\nduration_ms = 0.001\nmesh_size = 1\n", ("bearing = 3", "duration_ms", "mesh_size"),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "named"), AT_ONCE.values(), ids=AT_ONCE.keys())
def test_all_faults_of_a_scene_come_at_once(text, named, tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert run_main([str(path)]) == 2
    error = capsys.readouterr().err
    assert error.count("scene.toml: ") == len(named)
    assert all(word in error for word in named)


def test_a_file_that_a_link_leads_to_is_not_even_opened(tmp_path):
    """A pipe can be opened for writing as soon as someone has opened it for reading."""
    pipe, path, opened, over = tmp_path / "pipe", write_result(tmp_path / "bad.nc", RUN), [], threading.Event()
    os.mkfifo(pipe)
    with h5py.File(path, "a") as file:
        del file["inner_x"]
        file["inner_x"] = h5py.ExternalLink(str(pipe), "/inner_x")

    def watch():
        while not over.is_set():
            with contextlib.suppress(OSError):
                os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
                opened.append(True)
            time.sleep(0.001)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        assert check_main([str(path)]) == render_main([str(path)]) == 2
    finally:
        over.set()
        watcher.join()
    assert not opened

"""Folders of studies that others have made: `run-study --collect` refuses them, or leaves points out, and soon."""

import io
import json
import os
import shutil

import numpy as np
import pytest

from fem.commands.run_study import study_main
from lagrange.files.output import read_sealed, write_sealed
from tests.reference.small_study import TWO_SPEEDS

STUDY = TWO_SPEEDS + 'signals = ["inner_ay"]\n'


@pytest.fixture(scope="module")
def study(tmp_path_factory):
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
def test_a_study_that_can_not_be_is_refused(kind, study, tmp_path, capsys):
    change, words = FACTS[kind]
    folder = shutil.copytree(study, tmp_path / "s")
    about = folder / "study.json"
    about.write_text(json.dumps(json.loads(about.read_text(encoding="utf-8")) | change), encoding="utf-8")
    _refused(folder, words, capsys)


def test_a_study_that_nests_is_refused(study, tmp_path, capsys):
    folder = shutil.copytree(study, tmp_path / "s")
    (folder / "study.json").write_text("[" * 10**5, encoding="utf-8")
    _refused(folder, "recursion limit", capsys)


def test_a_study_in_a_pipe_is_refused(study, tmp_path, capsys):
    folder = shutil.copytree(study, tmp_path / "s")
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


def test_a_point_is_known_by_what_is_sealed_and_not_by_its_name(study, tmp_path, capsys):
    """One copied under another's name is none of either's: solved anew, and missing where nothing is solved."""
    folder = shutil.copytree(study, tmp_path / "s")
    first, second = sorted((folder / "points").iterdir())
    shutil.copy(first, second)
    assert study_main(["--collect", str(folder)]) == 1
    assert "2 points: 1 complete, 1 missing" in capsys.readouterr().out
    assert study_main([str(study.parent / "s.toml"), "--output", str(folder), "--resume", "--quiet"]) == 0
    assert first.read_bytes() != second.read_bytes()


@pytest.mark.parametrize("kind", POINTS)
def test_a_point_that_can_not_be_is_left_out(kind, study, tmp_path, capsys):
    folder = shutil.copytree(study, tmp_path / "s")
    for path in (folder / "points").iterdir():
        POINTS[kind](path)
    assert study_main(["--collect", str(folder)]) == 1
    out, error = capsys.readouterr()
    assert "2 points: 2 missing" in out and "Traceback" not in error and "Warning" not in error


def test_a_signal_of_another_length_is_named(study, tmp_path, capsys):
    folder = shutil.copytree(study, tmp_path / "s")
    path = min((folder / "points").iterdir())
    with np.load(io.BytesIO(read_sealed(path))) as found:
        _seal(path, np.savez, {"facts": found["facts"], "inner_ay": found["inner_ay"][:7]})
    _refused(folder, "its signals have another length than those of other points", capsys)

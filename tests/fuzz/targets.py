"""The readers, each as a function of a file's content."""

import io
import json
import warnings
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from math import isfinite, pi
from pathlib import Path

from tests.fuzz.sound import FEW_ROLLERS

LONGEST_MESSAGE = 10_000  # characters: 21 lines
MOST_POINTS = 200  # of a study that the whole command sees


class Targets:
    """The readers, each as a function of a file's content."""

    def __init__(self, folder: Path):
        self._folder = folder
        warnings.simplefilter("error", RuntimeWarning)  # an overflow that nobody looked for

    def scene(self, data: bytes) -> bool:
        """Read a scene file; what is taken must come back from its own text. Whether it was taken."""
        from lagrange.scene.scene import SceneError, parse_scene_text, read_scene

        path = self._file("fuzzed.toml", data)
        try:
            scene = read_scene(path)
        except SceneError as error:
            return _refused(error)
        assert parse_scene_text(scene.to_toml(), "again", scene.files) == scene
        return True

    def heights(self, data: bytes) -> bool:
        """Run-fem's plan of a scene that names a table of heights; what is taken must close."""
        from lagrange.scene.scene import read_scene

        self._file("fuzzed-heights.csv", data)
        path = self._file("heights.toml", b'[[profile]]\nfile = "fuzzed-heights.csv"\n')
        if not self._planned(path):
            return False
        (fault,) = read_scene(path).ideal_bearing().faults
        angle, height = fault.table.angle, fault.table.height
        assert all(map(isfinite, height)) and (angle[1:] > angle[:-1]).all() and angle[-1] - angle[0] < 2.0 * pi
        return True

    def speeds(self, data: bytes) -> bool:
        """Run-fem's plan of a scene whose speed is a table."""
        self._file("fuzzed-speeds.csv", data)
        return self._planned(self._file("speeds.toml", b'[operation]\nspeed_table = "fuzzed-speeds.csv"\n'))

    def loads(self, data: bytes) -> bool:
        """Run-fem's plan of a scene whose load is a table."""
        self._file("fuzzed-loads.csv", data)
        return self._planned(self._file("loads.toml", b'[operation]\nload_table = "fuzzed-loads.csv"\n'))

    def study(self, data: bytes) -> bool:
        """Run-study's plan, of large studies the reader alone."""
        from fem.commands.run_study import study_main
        from fem.study.study_file import design_of, read_study
        from lagrange.errors import UsageError
        from lagrange.scene.scene import SceneError

        path = self._file("fuzzed-study.toml", data)
        self._file("points.csv", b"operation.speed_rpm,operation.radial_load_N\n1000,500\n2000,800\n")
        try:
            read = read_study(path)
            if len(design_of(read).points) > MOST_POINTS or read.scene.model != "lagrange":  # others take meshes
                return True
        except (UsageError, SceneError):
            pass  # the command must find it too
        return _commanded(study_main, str(path), "--dry-run", "--output", str(self._folder / "study"))

    def folder(self, data: bytes) -> bool:
        """Read what a study's folder tells of it, and make the scene of every point."""
        from fem.study.folder import Folder
        from lagrange.errors import UsageError
        from lagrange.scene.scene import SceneError

        try:
            points = Folder(path=self._file("study.json", data).parent).points()
            for i in range(min(len(points), MOST_POINTS)):
                points.scene(i)
        except (UsageError, SceneError) as error:
            return _refused(error)
        return True

    def _planned(self, scene: Path) -> bool:
        from fem.commands.run_fem import run_main

        return _commanded(run_main, str(scene), "--model", "lagrange", "--dry-run")

    def table(self, data: bytes) -> bool:
        """Read a trajectory table, and evaluate it where it is taken."""
        from lagrange.errors import InputError
        from lagrange.scene.scene import parse_scene_text
        from residual.sources import read_table

        path = self._file("fuzzed.csv", data)
        try:
            trajectory = read_table(path, parse_scene_text(FEW_ROLLERS, "few"))
            _evaluated(trajectory)
        except InputError as error:
            return _refused(error)
        return True

    def record_text(self, data: bytes) -> bool:
        """Read a vibration record from text, and judge it where it is taken."""
        return self._judged("fuzzed-record.csv", data)

    def record_wav(self, data: bytes) -> bool:
        """The same from a WAV file."""
        return self._judged("fuzzed-record.wav", data)

    def record_numpy(self, data: bytes) -> bool:
        """The same from an NPY or NPZ file."""
        return self._judged("fuzzed-record.npz", data)

    def _judged(self, name: str, data: bytes) -> bool:
        import numpy as np

        from lagrange.errors import InputError
        from residual.measured.diagnosis import Geometry, diagnose
        from residual.measured.signals import read_signal

        bearing = Geometry(elements=8, element_diameter=8e-3, pitch_diameter=40e-3)
        try:
            signal = read_signal(self._file(name, data))
        except InputError as error:
            return _refused(error)
        assert np.isfinite(signal.values).all() and 0.0 < signal.rate < np.inf
        for note in signal.notes:
            _refused(ValueError(note))
        try:
            found = diagnose(signal, bearing, 40.0)
        except InputError as error:
            _refused(error)  # a record that is too short or slow for this bearing is read all the same
        else:
            assert all(np.isfinite([each.clear, each.depth, each.p]).all() for each in found.findings)
        return True

    def _file(self, name: str, data: bytes) -> Path:
        path = self._folder / name
        path.write_bytes(data)
        return path


NAMES = (
    "scene", "heights", "speeds", "loads", "study", "folder", "table", "record_text", "record_wav", "record_numpy",
)  # fmt: skip


def _commanded(main: Callable[[list[str]], int], *arguments: str) -> bool:
    """Whether a command takes its input; it must end with 0, or with a sentence and 1 or 2."""
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as said:
        code = main(list(arguments))
    assert code in (0, 1, 2), code
    return code == 0 or _refused(ValueError(said.getvalue()))


def _refused(error: Exception) -> bool:
    """Check that the message is fit for a terminal."""
    text = str(error)
    assert 0 < len(text) <= LONGEST_MESSAGE and all(c.isprintable() or c == "\n" for c in text), repr(text)
    return False


def _evaluated(trajectory) -> None:
    """Check that what the reader takes can be evaluated, and the numbers be written."""
    from residual.evaluation import evaluate
    from residual.report import ReportOptions, summarise

    json.dumps(summarise(evaluate(trajectory), ReportOptions()), allow_nan=False)

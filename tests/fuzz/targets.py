"""The readers, each as a function of a file's content that tells whether it is taken; sound inputs for each."""

import io
import json
import tempfile
import warnings
from contextlib import redirect_stderr, redirect_stdout
from math import pi
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main
from fem.study.folder import Folder
from fem.study.solving import checked_points
from fem.study.study_file import design_of, read_study
from lagrange.errors import InputError, UsageError
from lagrange.scene.scene import Scene, SceneError, parse_scene_text, read_scene
from residual.evaluation import evaluate
from residual.measured.diagnosis import Geometry, diagnose
from residual.measured.signals import read_signal
from residual.report import ReportOptions, summarise
from residual.sources import read_table
from tests.reference.kit import GRID
from tests.reference.synthetic_run import make_run, write_table

LONGEST_MESSAGE = 10_000  # characters: 21 lines
MOST_POINTS = 200  # of a study that the whole command sees
NAMING = {
    "heights": '[[profile]]\nfile = "fuzzed.csv"\n', "speeds": '[operation]\nspeed_table = "fuzzed.csv"\n',
    "loads": '[operation]\nload_table = "fuzzed.csv"\n',
}  # fmt: skip
RECORDS = {"record_text": "record.csv", "record_wav": "record.wav", "record_numpy": "record.npz"}
FEW_ROLLERS = "[bearing]\nrollers = 3\ninner_raceway_diameter_mm = 36.0\n"


class Targets:
    """The readers; where a file is refused, the message must be fit for a terminal."""

    def __init__(self, folder: Path):
        self._folder = folder
        warnings.simplefilter("error", RuntimeWarning)  # an overflow that nobody looked for

    def __call__(self, name: str, data: bytes) -> bool:
        """Whether the reader of a name takes a file's content."""
        if name in RECORDS:
            return self.record(data, RECORDS[name])
        return self.named(data, name) if name in NAMING else getattr(self, name)(data)

    def scene(self, data: bytes) -> bool:
        """Read a scene file; what is taken must come back from its own text."""
        try:
            scene = read_scene(self._file("fuzzed.toml", data))
        except SceneError as error:
            return _refused(error)
        assert parse_scene_text(scene.to_toml(), "again", scene.files) == scene
        return True

    def study(self, data: bytes) -> bool:
        """Run-study's plan, of large studies the reader alone."""
        path = self._file("fuzzed-study.toml", data)
        self._file("points.csv", b"operation.speed_rpm,operation.radial_load_N\n1000,500\n2000,800\n")
        try:
            read = read_study(path)
            if len(design_of(read).points) > MOST_POINTS or read.scene.model != "lagrange":  # others take meshes
                return True
        except (UsageError, SceneError):
            pass  # the command must find it too
        return _commanded(study_main, path, "--dry-run", "--output", self._folder / "study")

    def folder(self, data: bytes) -> bool:
        """Read what a study's folder tells of it, and make the scene of every point."""
        try:
            points = Folder(path=self._file("study.json", data).parent).points()
            for i in range(min(len(points), MOST_POINTS)):
                points.scene(i)
        except (UsageError, SceneError) as error:
            return _refused(error)
        return True

    def table(self, data: bytes) -> bool:
        """Read a trajectory table; what is taken can be evaluated, and the numbers be written."""
        try:
            trajectory = read_table(self._file("fuzzed.csv", data), parse_scene_text(FEW_ROLLERS, "few"))
            json.dumps(summarise(evaluate(trajectory), ReportOptions()), allow_nan=False)
        except InputError as error:
            return _refused(error)
        return True

    def record(self, data: bytes, name: str) -> bool:
        """Read a vibration record from text, a WAV, an NPY or an NPZ file, and judge it where it is taken."""
        try:
            signal = read_signal(self._file(name, data))
        except InputError as error:
            return _refused(error)
        assert np.isfinite(signal.values).all() and 0.0 < signal.rate < np.inf
        for note in signal.notes:
            _refused(note)
        try:
            found = diagnose(signal, Geometry(elements=8, element_diameter=8e-3, pitch_diameter=40e-3), 40.0)
        except InputError as error:
            _refused(error)  # a record that is too short or slow for this bearing is read all the same
        else:
            assert all(np.isfinite([each.clear, each.depth, each.p]).all() for each in found.findings)
        return True

    def named(self, data: bytes, name: str) -> bool:
        """Run-fem's plan of a scene that names a table; heights that are taken must close."""
        self._file("fuzzed.csv", data)
        path = self._file("named.toml", NAMING[name].encode())
        if not _commanded(run_main, path, "--model", "lagrange", "--dry-run"):
            return False
        if name == "heights":
            (fault,) = read_scene(path).ideal_bearing().faults
            angle, height = fault.table.angle, fault.table.height
            assert np.isfinite(height).all() and (angle[1:] > angle[:-1]).all() and angle[-1] - angle[0] < 2.0 * pi
        return True

    def _file(self, name: str, data: bytes) -> Path:
        path = self._folder / name
        path.write_bytes(data)
        return path


def _commanded(main, *arguments) -> bool:
    """Whether a command takes its input; it must end with 0, or with a sentence and 1 or 2."""
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as said:
        code = main(list(map(str, arguments)))
    assert code in (0, 1, 2), code
    return code == 0 or _refused(said.getvalue())


def _refused(message: object) -> bool:
    text = str(message)
    assert 0 < len(text) <= LONGEST_MESSAGE and all(c.isprintable() or c == "\n" for c in text), repr(text)
    return False


# Sound inputs

DRAWN = """name = "drawn"
[sampling]
method = "sobol"
samples = 4
seed = 3
indices = true
[fixed]
model = "lagrange"
[parameters]
"operation.radial_load_N" = { from = 250.0, to = 8000.0, scale = "log" }
"material.youngs_modulus_GPa" = { normal = [210, 5] }
[limits]
seconds_per_point = 5.0
"""
LISTED = '[sampling]\nmethod = "list"\nfile = "points.csv"\n[fixed]\nmodel = "lagrange"\n'
STUDIES = GRID, DRAWN, DRAWN.replace("sobol", "lhs").replace("indices = true\n", ""), LISTED
SCENES = (
    Scene().to_toml(),
    '[bearing]\ntype = "ball"\n[material.roller]\ndensity_kg_m3 = 3200\n[operation]\nspeed_rpm = -3e3\n',
    '[table]\ntime = "t [ms]"\nroller_x = "x_{j} [um]"\ndecimal = ","\n',
    '[[spall]]\nbody = "roller"\nroller = 3\n[[spall]]\nwidth_mm = 2.0\nangle_deg = 90\nedge_radius_mm = 0\n'
    "[[waviness]]\norder = 14\n[[unequal_roller]]\nroller = 5\n", "name = 'x'\n",
)  # fmt: skip
HEIGHTS = "\n".join(["angle_deg,height_um", *(f"{angle},{0.1 * (angle % 7):.2g}" for angle in range(360))])
SOUND = {
    "scene": [text.encode() for text in SCENES], "study": [text.encode() for text in STUDIES],
    "heights": [HEIGHTS.replace(",", mark).encode() for mark in ",\t"],
    "speeds": [b"time_ms,speed_rpm\n0,1000\n2,1500\n6,5000\n80,6000\n",
               b"# ramp\nspeed_rpm;time_ms\n-300;-1\n10;900\n"],
    "loads": [b"time_ms,x_N,y_N\n0,0,-2000\n2,500,-1500\n4,500,-2500\n100,-300,-2000\n",
              b"y_N\ttime_ms\tx_N\n-1\t0\t9\n-3\t99\t8\n"],
}  # fmt: skip
NAMES = (*SOUND, "folder", "table", *RECORDS)


def seeds(name: str) -> list[bytes]:
    if name.startswith("record_"):
        return _records(name.removeprefix("record_"))
    with tempfile.TemporaryDirectory() as place:
        if name == "folder":  # what run-study writes of a study before it solves the first point
            return [_study_facts(Path(place), text) for text in STUDIES[:2]]
        return _tables(Path(place)) if name == "table" else SOUND[name]


def _records(kind: str) -> list[bytes]:
    """A record of 0.26 s in files of a kind."""
    rate, rng = 8000, np.random.default_rng(1)
    time = np.arange(2100) / rate
    wave = np.sin(820.0 * time) + 0.1 * rng.standard_normal(time.size)

    def written(write, *arguments, **keywords) -> bytes:
        target = io.BytesIO()
        write(target, *arguments, **keywords)
        return target.getvalue()

    if kind == "wav":
        return [written(wavfile.write, rate, values) for values in (wave.astype("f4"), (9e3 * wave).astype("i2"))]
    if kind == "numpy":
        return [written(np.savez, acc=wave, fs=8e3), written(np.savez, time=time, acc=wave)]
    rows = [f"{t:.6f},{a:.5f}" for t, a in zip(time, wave, strict=True)]
    german = "\n".join(row.replace(",", ";").replace(".", ",") for row in rows)
    one = "\n".join(f"{a:.5f}" for a in wave)
    return ["\n".join(["time_s,acc_g", *rows]).encode(), f"Zeit [s];Wert [m/s²]\n{german}".encode("cp1252"),
            f"Sampling rate: 8000 Hz\nacc\n{one}".encode("utf-16")]  # fmt: skip


def _study_facts(place: Path, text: str) -> bytes:
    (place / "study.toml").write_text(text, encoding="utf-8")
    study = read_study(place / "study.toml")
    Folder(path=place).begin(checked_points(study, design_of(study)))
    return (place / "study.json").read_bytes()


def _tables(place: Path) -> list[bytes]:
    """A motion as tables, with accelerations and contact forces and without."""
    run = make_run(41, scene=parse_scene_text(FEW_ROLLERS, "few"))
    forms = ((",", True), ("\t", False))
    return [write_table(run, place / "table.csv", mark, whole).read_bytes() for mark, whole in forms]

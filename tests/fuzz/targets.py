"""The readers, each as a function of a file's content, and sound inputs to start from.

Readers are imported where they are used: the search loads them anew to count their branches.
"""

import io
import json
import tempfile
import warnings
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from math import isfinite, pi
from pathlib import Path

LONGEST_MESSAGE = 10_000  # characters: 21 lines
DURATION = ["--duration", "0.4"]
MOST_POINTS = 200  # of a study that the whole command sees
FEW_ROLLERS = """[bearing]
rollers = 3
inner_raceway_diameter_mm = 36.0
"""

GRID = """[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
[parameters]
"operation.speed_rpm" = [1500, 3000]
"bearing.clearance_um" = { from = 0, to = 40, count = 3 }
[keep]
quantities = ["hub_mean_y", "error_rms_y"]
signals = ["inner_ay"]
signal_rate_kHz = 20.0
"""
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


class Targets:
    """The readers, each as a function of a file's content."""

    def __init__(self, folder: Path):
        self._folder = folder
        warnings.simplefilter("error", RuntimeWarning)  # an overflow that nobody looked for

    def scene(self, data: bytes) -> bool:
        """Read a scene file; what is taken must come back from its own text. Whether it was taken."""
        from lagrange.scene import SceneError, parse_scene_text, read_scene

        path = self._file("fuzzed.toml", data)
        try:
            scene = read_scene(path)
        except SceneError as error:
            return _refused(error)
        assert parse_scene_text(scene.to_toml(), "again", scene.files) == scene
        return True

    def heights(self, data: bytes) -> bool:
        """Run-fem's plan of a scene that names a table of heights; what is taken must close."""
        from lagrange.scene import read_scene

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
        from fem.errors import UsageError
        from fem.study.sampling import design_of
        from fem.study.study_file import read_study
        from fem.study_cli import study_main
        from lagrange.scene import SceneError

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
        from fem.errors import UsageError
        from fem.study.folder import Folder
        from lagrange.scene import SceneError

        try:
            points = Folder(path=self._file("study.json", data).parent).points()
            for i in range(min(len(points), MOST_POINTS)):
                points.scene(i)
        except (UsageError, SceneError) as error:
            return _refused(error)
        return True

    def _planned(self, scene: Path) -> bool:
        from fem.cli import run_main

        return _commanded(run_main, str(scene), "--model", "lagrange", "--dry-run")

    def table(self, data: bytes) -> bool:
        """Read a trajectory table, and evaluate it where it is taken."""
        from lagrange.scene import parse_scene_text
        from residual.errors import InputError
        from residual.table_source import read_table

        path = self._file("fuzzed.csv", data)
        try:
            trajectory = read_table(path, parse_scene_text(FEW_ROLLERS, "few"))
            _evaluated(trajectory)
        except InputError as error:
            return _refused(error)
        return True

    def result(self, data: bytes) -> bool:
        """Read a result file first in a child, as always; then here, so that the search sees which way it took."""
        from residual import sources
        from residual.errors import InputError

        sources.READ_SECONDS = 0.2  # of an input that sends HDF5 round in circles
        path = self._file("fuzzed.nc", data)
        try:
            sources.read_result(path)
        except InputError as error:
            if "reading it" in str(error):
                return _refused(error)
        try:
            sources._read(path)
        except InputError as error:
            return _refused(error)
        return True

    def checkpoint(self, data: bytes) -> bool:
        """Read the state of a run."""
        from fem.errors import UsageError
        from fem.result.checkpoint import load_checkpoint

        self._file("fuzzed.nc.checkpoint", data)
        try:
            load_checkpoint(self._folder / "fuzzed.nc", _plan())
        except UsageError as error:
            return _refused(error)
        return True

    def _file(self, name: str, data: bytes) -> Path:
        path = self._folder / name
        path.write_bytes(data)
        return path


NAMES = ("scene", "heights", "speeds", "loads", "study", "folder", "table", "result", "checkpoint")


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
    from residual.parts import Parts
    from residual.summary import summarise

    json.dumps(summarise(evaluate(trajectory), Parts(), "0"), allow_nan=False)


_PLANS: list = []


def _plan():
    from fem.solver.simulate import make_plan
    from lagrange.scene import read_scene

    if not _PLANS:
        _PLANS.append(make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=0.4"))))
    return _PLANS[0]


def seeds(name: str) -> list[bytes]:
    """Make small sound inputs to start from."""
    from lagrange.scene import Scene

    if name == "scene":
        ball = '[bearing]\ntype = "ball"\n[material.roller]\ndensity_kg_m3 = 3200\n[operation]\nspeed_rpm = -3e3\n'
        mapped = '[table]\ntime = "t [ms]"\nroller_x = "x_{j} [um]"\ndecimal = ","\n'
        faulty = (
            '[[spall]]\nbody = "roller"\nroller = 3\n[[spall]]\nwidth_mm = 2.0\nangle_deg = 90\nedge_radius_mm = 0\n'
        )
        faulty += "[[waviness]]\norder = 14\n[[unequal_roller]]\nroller = 5\n"
        return [text.encode() for text in (Scene().to_toml(), ball, mapped, faulty, "name = 'x'\n")]
    if name == "heights":
        rows = [f"{angle},{0.1 * (angle % 7):.2g}" for angle in range(360)]
        return ["\n".join(["angle_deg,height_um", *rows]).replace(",", mark).encode() for mark in ",\t"]
    if name == "speeds":
        return [
            b"time_ms,speed_rpm\n0,1000\n2,1500\n6,5000\n80,6000\n",
            b"# ramp\nspeed_rpm;time_ms\n-300;-1\n10;900\n",
        ]
    if name == "loads":
        return [
            b"time_ms,x_N,y_N\n0,0,-2000\n2,500,-1500\n4,500,-2500\n100,-300,-2000\n",
            b"y_N\ttime_ms\tx_N\n-1\t0\t9\n-3\t99\t8\n",
        ]
    if name == "study":
        return [text.encode() for text in STUDIES]
    with tempfile.TemporaryDirectory() as folder:
        if name == "folder":
            return [_study_facts(Path(folder), text) for text in STUDIES[:2]]
        path = Path(folder) / "seed.nc"
        if name == "checkpoint":
            _run(["--mesh-size", "2", *DURATION, "--output", str(path)])
            return [path.with_name("seed.nc.checkpoint").read_bytes()]
        scene = Path(folder) / "few.toml"
        scene.write_text(FEW_ROLLERS)
        _run([str(scene), "--model", "lagrange", *DURATION, "--output", str(path)])
        if name == "table":
            return [_table(path, ",", True), _table(path, "\t", False)]
        return [path.read_bytes(), _unchecked(path)]


def _study_facts(place: Path, text: str) -> bytes:
    """What run-study writes of a study before it solves the first point."""
    from fem.study.folder import Folder
    from fem.study.points import checked_points
    from fem.study.sampling import design_of
    from fem.study.study_file import read_study

    (place / "study.toml").write_text(text, encoding="utf-8")
    study = read_study(place / "study.toml")
    Folder(path=place).begin(checked_points(study, design_of(study)))
    return (place / "study.json").read_bytes()


def _run(arguments: list[str]) -> None:
    from fem.cli import run_main

    if run_main([*arguments, "--quiet"]) != 0:
        raise RuntimeError("the run that makes the first input failed")


def _unchecked(path: Path) -> bytes:
    """Read a result file without its checksums, which would stop most changes."""
    import h5py

    from lagrange.stored import CHECKSUM, SCENE_CHECKSUM

    with h5py.File(path, "r+") as file:
        for variable in file.values():
            variable.attrs.pop(CHECKSUM, None)
        file.attrs.pop(SCENE_CHECKSUM)
    return path.read_bytes()


def _table(path: Path, delimiter: str, forces: bool) -> bytes:
    """Write a result file's motion as a table, with or without its accelerations and contact forces."""
    import h5py
    import numpy as np

    with h5py.File(path) as file:
        columns = {name: file[name][:] for name in ("time", "inner_x", "inner_y")}
        for axis in "xy":
            columns |= {f"roller_{j}_{axis}": column for j, column in enumerate(file[f"roller_{axis}"][:].T)}
        for name in ("inner_force", "outer_force") if forces else ():
            columns |= {f"roller_{j}_{name}": column for j, column in enumerate(file[name][:].T)}
        columns |= {name: file[name][:] for name in ("inner_ax", "inner_ay")} if forces else {}
    text = io.StringIO()
    np.savetxt(text, np.column_stack(list(columns.values())), "%.9g", delimiter,
               header=delimiter.join(columns), comments="")  # fmt: skip
    return text.getvalue().encode()

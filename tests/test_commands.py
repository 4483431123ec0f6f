"""The commands as processes: exit codes, sentences, never a traceback; versions, what starts load, hostile files."""

import importlib
import os
import pkgutil
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import get_args
from unittest import mock

import h5py
import pytest
from cyclopts.completion.detect import ShellDetectionError

import fem
import lagrange
import meshes
import residual
from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main
from fem.contacts import contact_law
from fem.interface import simulate
from fem.kernels import law
from fem.solver.simulate import SOLVERS
from lagrange import version
from lagrange.commands import new_app, run_app_main
from lagrange.errors import RunFailed
from lagrange.scene.scene import Scene
from residual.cli import main as check_main
from tests.reference.kit import command, environment, sets, started_as
from tests.waiting import no_endless_wait

COARSE = ["--mesh-size", "2"]

TEXTS = {"escapes": "\x1b[31mred\a\u202e", "half a character": "\udcff", "long": "x" * 100_000}


@pytest.mark.parametrize("option", ["--quiet", pytest.param("--dry-run", marks=pytest.mark.slow)])
def test_a_scene_without_a_static_equilibrium_is_refused_in_a_sentence(option, tmp_path):
    sinking = sets("operation.radial_load_N=2e4", "contact.model=penalty", "contact.penalty_stiffness_N_per_m=1e5")
    done = command("run-fem", *COARSE, *sinking, option, folder=tmp_path)
    assert done.returncode == 2
    *slow, told = done.stderr.splitlines()  # on a slow machine a line says first what takes so long
    assert told.startswith("error: no static equilibrium under 2e+04 N") and len(slow) < 2


OWN = {
    f"{kind.__module__}.{kind.__qualname__}": kind
    for package in (fem, lagrange, meshes, residual)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    for kind in ([] if module.name.endswith("__main__") else vars(importlib.import_module(module.name)).values())
    if isinstance(kind, type) and issubclass(kind, Exception) and kind.__module__ == module.name
}
assert {"lagrange.errors.UsageError", "fem.statics.contact_balance.NotFound", "lagrange.files.hdf5.Damaged"} <= set(OWN)


@pytest.mark.parametrize("name", OWN)
def test_every_error_of_the_program_and_what_derives_from_it_ends_in_a_sentence(name, capsys):
    for kind in (OWN[name], type("Derived", (OWN[name],), {})):
        app = new_app("some", "")

        @app.default
        def fail(kind=kind):
            raise kind("some reason")

        assert run_app_main(app, []) == (1 if issubclass(kind, RunFailed) else 2)
        told = capsys.readouterr().err
        assert "some reason" in told and told.startswith("error: ") and "Traceback" not in told


def shell(line, name, *arguments):
    """A command in a line of the shell, and what it said but for what a loaded machine makes it say."""
    line = line.format(shlex.join([*started_as(name), *map(str, arguments)]))
    done = subprocess.run(["bash", "-c", line], env=environment(), capture_output=True, text=True)
    return done.returncode, [each for each in done.stderr.splitlines() if not each.startswith("planning: ")]


def test_a_reader_that_goes_or_a_full_disk_behind_the_output_is_no_failure_of_a_complete_run(tmp_path):
    path = tmp_path / "run.nc"
    for name, arguments in (
        ("run-fem", [*COARSE, "--duration", "0.5", "--output", path]),
        ("check-residual", [path, "--no-figures", "--output", tmp_path / "report"]),
        ("render-fem", [path, "--export", tmp_path / "mesh.vtu"]),
    ):
        for end in ("| true", "> /dev/full", ">&-", "2>&-") if name == "run-fem" else ("> /dev/full",):
            code, said = shell(f"{{}} {end}; exit ${{{{PIPESTATUS[0]}}}}", name, *arguments)
            assert code == 0, (name, end, said)
            assert not any(word in line for line in said for word in ("error", "Traceback", "Exception"))


@pytest.mark.parametrize("option", ["--help", "--version", "--dry-run"])
def test_what_is_printed_and_nothing_else_must_reach_its_disk_but_not_its_reader(option):
    assert shell("{} | true; exit ${{PIPESTATUS[0]}}", "run-fem", option) == (0, [])
    assert shell("{} > /dev/full", "run-fem", option) == (2, ["error: output: No space left on device"])


@pytest.mark.parametrize(("name", "text"), [
    *(("run-fem", text) for text in TEXTS), ("render-fem", "escapes"), ("check-residual", "escapes"),
    *(pytest.param(name, text, marks=pytest.mark.slow)
      for name in ("render-fem", "check-residual") for text in ("half a character", "long")),
])  # fmt: skip
def test_names_of_files_are_told_printable_and_not_endless(name, text, tmp_path):
    for arguments in ([f"{TEXTS[text]}.toml"], [f"--{TEXTS[text]}"]):
        done = command(name, *arguments, folder=tmp_path, PYTHONIOENCODING="utf-8:strict")
        assert done.returncode == 2 and done.stderr.startswith("error: "), done.stderr
        assert len(done.stderr) < 4000 and all(c.isprintable() or c == "\n" for c in done.stderr)
        assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_half_a_character_in_a_files_name_hinders_no_command(tmp_path):
    name, strict = "\udcff.nc", {"PYTHONIOENCODING": "utf-8:strict"}
    for called, arguments in (
        ("run-fem", [*COARSE, "--duration", "1", "--output", name]),
        ("check-residual", [name]),
        ("render-fem", [name, "--width", "300"]),
        ("render-fem", [name, "--export", "\udcff.vtkhdf"]),
    ):
        done = command(called, *arguments, folder=tmp_path, **strict)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("threads", ["0", "-1", "two", "", "99999999999999999999"])
def test_a_number_of_threads_that_numba_can_not_take_is_refused(threads, tmp_path):
    done = command("run-fem", *COARSE, "--duration", "0", folder=tmp_path, NUMBA_NUM_THREADS=threads)
    assert done.returncode == 2 and done.stderr.startswith("error: NUMBA_NUM_THREADS = ")
    assert done.stderr.count("\n") == 1


def test_planning_that_takes_long_says_so(monkeypatch, capsys):
    """A mesh of a million nodes takes a minute, a dry run of it too: it solves the same static equilibrium."""
    monkeypatch.setattr("fem.runner.PATIENCE", 0.0)
    for expected in (1, 0):
        assert run_main(["--mesh-size", "2", "--dry-run"]) == 0
        assert capsys.readouterr().err.count("planning: meshes, matrices") == expected
        monkeypatch.setattr("fem.runner.PATIENCE", 1e6)


@pytest.mark.parametrize("name", ["run-fem", "check-residual"])
def test_the_shell_learns_a_commands_options(name, tmp_path, monkeypatch, capsys):
    main = {"run-fem": run_main, "check-residual": check_main}[name]
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr("cyclopts.completion.detect.detect_shell", lambda: "bash")
    assert main(["--install-completion"]) == 0
    written = [path for path in tmp_path.rglob("*") if path.is_file() and path.name == name]
    assert written and "--quiet" in written[0].read_text(encoding="utf-8")

    monkeypatch.setattr("cyclopts.completion.detect.detect_shell", mock.Mock(side_effect=ShellDetectionError("none")))
    assert main(["--install-completion"]) == 2 and "none of bash, zsh and fish" in capsys.readouterr().err


# The version stands in one place, and a result names it and the code that made it
ROOT = Path(__file__).resolve().parents[1]


def test_package_citation_changelog_and_results_have_the_programs_version(coarse_run):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "lagrange.version.VERSION"}
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    changes = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert cited[1] == changes[1] == version.VERSION
    with h5py.File(coarse_run) as file:
        assert file.attrs["program_version"] == version.VERSION and file.attrs["source"] == version.source_digest()
    done = subprocess.run([sys.executable, "-m", "fem", "--version"], env=environment(), capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip()) == (0, version.VERSION)


def test_the_digest_is_that_of_the_code(tmp_path, monkeypatch):
    (tmp_path / "lagrange").mkdir()
    module, found = tmp_path / "lagrange" / "version.py", []
    monkeypatch.setattr(version, "__file__", str(module))
    for text, other in (("a = 1", "version.py"), ("a = 2", "version.py"), ("a = 1", "new.py"), ("a = 1", "notes.txt")):
        (module.parent / other).write_text("", encoding="utf-8")
        module.write_text(text, encoding="utf-8")
        found.append(version.source_digest.__wrapped__())
        (module.parent / other).unlink()
    assert len(set(found[:3])) == 3 and found[3] == found[0]


# What starting loads: libraries that a command does not need cost every start up to a second, compilers more
HEAVY = "scipy.interpolate scipy.optimize scipy.signal scipy.stats matplotlib websockets fem.live skfem "
RUN = "from fem.commands.run_fem import run_main; code = run_main([{}])"
SHORT = RUN.format("'--quiet', '--force', '--duration', '1', '--model', {!r}")
STARTS = {  # the program, what it may not load
    "help": (RUN.format("'--help'"), "numpy numba skfem pydantic h5py"),
    "reduced": (SHORT.format("reduced"), HEAVY + "scipy.sparse scipy.linalg scipy.special"),
    "lagrange": (SHORT.format("lagrange"), HEAVY),
    "at rest": (RUN.format("'--quiet', '--model', 'lagrange', '--duration', '0'"),
                "numba gmsh skfem meshes matplotlib fem.contacts.model fem.kernels.elements.loop"),
    "rating": ("from fem.commands.rate_bearing import rate_main; code = rate_main(['--bearing', 'NU206'])",
               "numba matplotlib scipy.optimize h5py"),
    "check-vibration": ("from residual.check_vibration import main; code = main(['--help'])",
                        "numpy scipy matplotlib h5py pydantic"),
    "interface": ("from fem.interface import simulate; code = 0", "numba scipy residual"),
}  # fmt: skip


@pytest.mark.parametrize("what", STARTS)
def test_a_start_loads_nothing_that_it_does_not_need(what, tmp_path):
    """The second one: the first compiles a run's loop and keeps what it has computed of its bearing."""
    assert contact_law.STEEPEST == law.STEEPEST  # the constant that ratings need of compiled code
    program, heavy = STARTS[what]
    program += f"\nimport sys; print(code, *(name for name in {heavy.split()!r} if name in sys.modules))"
    for _ in range(2 if what in SOLVERS else 1):
        started = [sys.executable, "-c", program]
        done = subprocess.run(started, cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "0", done.stderr
    assert what != "help" or all(model in done.stdout for model in get_args(Scene.model_fields["model"].annotation))
    assert get_args(Scene.model_fields["model"].annotation) == tuple(SOLVERS)


def test_a_run_from_python_writes_nothing(here):
    simulate(Scene(model="lagrange", numerics={"duration_ms": 1.0}))
    assert os.listdir() == []


# Scenes and studies, and the files that they name: hostile ones are refused in a sentence, and soon
QUOTE = '"' + ("x" * 900 + "\n") * 300  # a quotation mark that does not close, longer than csv takes
NESTED = "[" * 5000
GIANT = "9" * 400  # more than a float can hold
THOUSANDS = "0x" + "f" * 9000  # whole numbers in hexadecimal have any number of digits
CUT, NO_FILE = "line 2: 1 cells under 2 names", "a pipe or a device, not a plain file"
STUDY = '[sampling]\nmethod = "{}"\n{}\n[fixed]\nmodel = "lagrange"\n[parameters]\n{}\n'
SPEED = '"operation.speed_rpm" = '
GRID = STUDY.format("grid", "", "{}")
LISTED = STUDY.format("list", 'file = "table.csv"', "")
MANY = "\n".join(f'"numerics.key_{i}" = [1]' for i in range(1001))
WIDE = "\n".join(f'"numerics.key_{i}" = {{ from = 1, to = 2 }}' for i in range(11))

SCENES = {  # the scene, the file it names, what must be told
    "heights that are quoted": ('[[profile]]\nfile = "table.csv"\n', "angle_deg,height_um\n" + QUOTE, CUT),
    "speeds that are quoted": ('[operation]\nspeed_table = "table.csv"\n', "time_ms,speed_rpm\n" + QUOTE, CUT),
    "heights in a pipe": ('[[profile]]\nfile = "table.csv"\n', None, NO_FILE),
    "loads in a pipe": ('[operation]\nload_table = "table.csv"\n', None, NO_FILE),
    "heights that never end": ('[[profile]]\nfile = "/dev/zero"\n', None, NO_FILE),
    "thousands of digits": (f"[bearing]\nrollers = {THOUSANDS}\n", None, "rollers = a number of thousands of digits"),
    "10 000 keys": ("\n".join(f"key_{i} = 1" for i in range(10_000)), None, "and 9985 more"),
}  # fmt: skip
STUDIES = {  # the study, its table of points, what must be told
    "a range without end": (GRID.format(f"{SPEED}{{ from = 1, to = {GIANT}, count = 3 }}"), "", ".to = 99"),
    "a mean without end": (GRID.format(f"{SPEED}{{ normal = [{GIANT}, 1] }}"), "", "list of numbers"),
    "a value without end": (GRID.format(f"{SPEED}[{THOUSANDS}]"), "", "thousands of digits is no value"),
    "points of 1001 keys": (GRID.format(MANY), "", "at most 1000"),
    "eleven million numbers": (STUDY.format("lhs", "samples = 1000000", WIDE), "", "points times parameters"),
    "cells that nest": (LISTED, f"operation.speed_rpm\n{NESTED}\n", "operation.speed_rpm = '[[["),
    "cells that are quoted": (LISTED, f"operation.speed_rpm\n{QUOTE}", "table.csv: a row can't be read"),
    "cells without end": (LISTED, f"operation.speed_rpm\n{THOUSANDS}\n", "row 2, operation.speed_rpm = '0xff"),
    "points in a pipe": (LISTED, None, "table.csv: can't be read: a pipe or a device"),
    "a scene in a pipe": ('scene = "table.csv"\n' + GRID.format(f"{SPEED}[1]"), None, "a pipe or a device"),
}  # fmt: skip


@pytest.mark.parametrize("kind", [*SCENES, *STUDIES])
def test_a_hostile_file_is_refused_in_a_sentence(kind, here, capsys):
    main, (text, table, words) = (run_main, SCENES[kind]) if kind in SCENES else (study_main, STUDIES[kind])
    for name, content in (("given.toml", text), ("table.csv", table)):
        if content is None:  # a pipe that nobody writes to
            os.mkfifo(name)
        else:
            Path(name).write_text(content, encoding="utf-8")
    with no_endless_wait():
        assert main(["given.toml", "--dry-run"]) == 2
    out, error = capsys.readouterr()
    assert words in error and len(error) < 20_000 and out == "", error

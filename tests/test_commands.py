"""How the commands end, as processes: exit codes, sentences, never a traceback."""

import importlib
import pkgutil
import shlex
import subprocess
import sys

import pytest
from cyclopts.completion.detect import ShellDetectionError

import fem
import lagrange
import meshes
import residual
from fem.commands.run_fem import run_main
from lagrange.commands import new_app, run_app_main
from lagrange.errors import RunFailed
from lagrange.version import VERSION
from residual.cli import main as check_main
from tests.reference.commands import command, environment, started_as

COARSE = ["--mesh-size", "2"]

SINKING = """
[operation]
radial_load_N = 20000.0
[contact]
model = "penalty"
penalty_stiffness_N_per_m = 1e5
[numerics]
mesh_size_mm = 2.0
"""


@pytest.mark.parametrize("option", ["--quiet", pytest.param("--dry-run", marks=pytest.mark.slow)])
def test_a_scene_without_a_static_equilibrium_is_refused_in_a_sentence(option, tmp_path):
    (tmp_path / "scene.toml").write_text(SINKING)
    done = command("run-fem", "scene.toml", option, folder=tmp_path)
    assert done.returncode == 2
    *slow, told = done.stderr.splitlines()  # on a slow machine a line says first what takes so long
    assert told.startswith("error: no static equilibrium under 2e+04 N") and len(slow) < 2


def own_exceptions():
    """Every kind of error that a module of the program defines, once."""
    found = {}
    for package in (fem, lagrange, meshes, residual):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if module.name.endswith("__main__"):
                continue
            for kind in vars(importlib.import_module(module.name)).values():
                if isinstance(kind, type) and issubclass(kind, Exception) and kind.__module__ == module.name:
                    found[f"{kind.__module__}.{kind.__qualname__}"] = kind
    return found


OWN = own_exceptions()


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


def test_the_programs_errors_are_found():
    assert {"lagrange.errors.UsageError", "fem.statics.contact_balance.NotFound", "lagrange.files.hdf5.Damaged"} <= set(
        OWN
    )


def test_a_reader_that_goes_or_a_full_disk_behind_the_output_is_no_failure_of_a_complete_run(tmp_path):
    path = tmp_path / "run.nc"
    for name, arguments in (
        ("run-fem", [*COARSE, "--duration", "0.5", "--output", path]),
        ("check-residual", [path, "--no-figures", "--output", tmp_path / "report"]),
        ("render-fem", [path, "--export", tmp_path / "mesh.vtu"]),
    ):
        for end in ("| true", "> /dev/full", ">&-") if name == "run-fem" else ("> /dev/full",):
            done = shell(f"{quoted(name, *arguments)} {end}; exit ${{PIPESTATUS[0]}}")
            assert done.returncode == 0, (name, end, done.stderr)
            assert "error" not in done.stderr and "Traceback" not in done.stderr and "Exception" not in done.stderr


@pytest.mark.parametrize("option", ["--help", "--version", "--dry-run"])
def test_what_is_printed_and_nothing_else_must_reach_its_disk_but_not_its_reader(option):
    done = shell(f"{quoted('run-fem', option)} | true; exit ${{PIPESTATUS[0]}}")
    assert (done.returncode, complaints(done)) == (0, [])
    done = shell(f"{quoted('run-fem', option)} > /dev/full")
    assert (done.returncode, complaints(done)) == (2, ["error: output: No space left on device"])


def complaints(done):
    """What was said, but for what a loaded machine makes a command say."""
    return [line for line in done.stderr.splitlines() if not line.startswith("planning: ")]


def quoted(name, *arguments):
    return shlex.join([*started_as(name), *map(str, arguments)])


def shell(line):
    return subprocess.run(["bash", "-c", line], env=environment(), capture_output=True, text=True)


UNPRINTABLE = "\x1b[31mred\a\u202e"


TEXTS = {"escapes": UNPRINTABLE, "half a character": "\udcff", "long": "x" * 100_000}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        *(("run-fem", text) for text in TEXTS),
        ("render-fem", "escapes"),
        ("check-residual", "escapes"),
        *(
            pytest.param(name, text, marks=pytest.mark.slow)
            for name in ("render-fem", "check-residual")
            for text in ("half a character", "long")
        ),
    ],
)
def test_names_of_files_are_told_printable_and_not_endless(name, text, tmp_path):
    text = TEXTS[text]
    for arguments in ([f"{text}.toml"], [f"--{text}"]):
        done = command(name, *arguments, folder=tmp_path, PYTHONIOENCODING="utf-8:strict")
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("error: ") and len(done.stderr) < 4000
        assert all(c.isprintable() or c == "\n" for c in done.stderr) and "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "scene",
    [
        f'name = "{"x" * 900_000}"',
        f'[bearing]\nrollers = "{"x" * 900_000}"',
        f"[bearing]\n{'x' * 900_000} = 1",
        f'[{"x" * 900_000}]\n"\\u001b[31m" = 1',
        '[bearing]\nrollers = "\\u001b[31m"',
        f"[numerics]\nduration_ms = {'9' * 900_000}",
    ],
    ids=["name", "value", "key", "table", "escape", "number"],
)
def test_values_of_a_scene_are_told_printable_and_not_endless(scene, tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(scene)
    assert run_main([str(tmp_path / "scene.toml")]) == 2
    message = capsys.readouterr().err
    assert 0 < len(message) < 4000
    assert all(c.isprintable() or c == "\n" for c in message) and "Traceback" not in message


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

    def unknown():
        raise ShellDetectionError("no shell")

    monkeypatch.setattr("cyclopts.completion.detect.detect_shell", unknown)
    assert main(["--install-completion"]) == 2
    assert "none of bash, zsh and fish" in capsys.readouterr().err


def test_python_m_fem_is_run_fem():
    done = subprocess.run([sys.executable, "-m", "fem", "--version"], env=environment(), capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip()) == (0, VERSION)

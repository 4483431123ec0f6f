"""Commands started in folders, and with caches, that others have filled or that are damaged, full or closed."""

import ast
import json
import os
import pickle
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from fem.kernels.kernel_folder import cache_folder, version
from fem.solver import compiling
from lagrange.files.input import user_cache
from lagrange.files.output import write_sealed
from tests.reference.bare_system import LACKING, MODULES, bare, can_be_made_bare
from tests.reference.kit import command, environment, same_data

OPTIONS = ["--duration", "0.1", "--quiet"]
COARSE = [*OPTIONS, "--mesh-size", "2", "--output"]
KERNEL = """from fem.kernels import kernel_folder
from fem.kernels.jit import kernel
@kernel
def twice(x):
    return 2.0 * x
print(twice(3.0), sum(twice.stats.cache_hits.values()), len(kernel_folder.notices), *kernel_folder.notices)
"""
slow = pytest.mark.slow


@slow
def test_a_module_in_the_current_folder_is_not_run_by_a_picture(coarse_run, tmp_path):
    for name in ("matplotlib", "imageio_ffmpeg", "numpy"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'executed')!r}, 'w')\nraise SystemExit(3)\n")
    done = command("render-fem", coarse_run, "--output", tmp_path / "picture.png", "--width", 300, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").exists() and not (tmp_path / "executed").exists()


def booby_trap(file, folder):
    """Put into a kept kernel's place what would make a folder when it is unpickled."""
    of = type("Touch", (), {"__reduce__": lambda self: (os.mkdir, (str(folder / "executed"),))})
    write_sealed(file, pickle.dumps(of()))


def kept_kernel(folder):
    return next((folder / "cache").rglob("*.twice-*.nbc"))


def test_kernels_in_a_folder_that_others_can_write_are_not_loaded(coarse_run, tmp_path):
    """The user's own cache, which is private, serves instead."""
    foreign, own = (tmp_path / name / "kernels" for name in ("foreign", "own/roller-bearing-fem"))
    for folder in (own, foreign):
        shutil.copytree(cache_folder(), folder / version())
    for path in (foreign / version()).iterdir():
        booby_trap(path, tmp_path)
    foreign.parent.chmod(0o777)
    caches = {"NUMBA_CACHE_DIR": foreign.parent, "XDG_CACHE_HOME": tmp_path / "own"}
    done = command("run-fem", *COARSE, tmp_path / "run.nc", **caches)
    assert done.returncode == 0, done.stderr
    assert f"warning: {foreign / version()}: compiled kernels there are not used: {foreign.parent}: " in done.stderr
    assert done.stderr.count("\n") == 1 and not (tmp_path / "executed").exists()


DAMAGES = {
    "empty": lambda data: b"", "cut": lambda data: data[: len(data) // 2], "zeroed": lambda data: bytes(len(data)),
    "one bit flipped": lambda data: data[:150] + bytes([data[150] ^ 8]) + data[151:],
}  # fmt: skip


def compiled(folder, prepare=None, **variables):
    """Hits, notices and what these say of a program with a kernel of its own, whose caches are in a folder."""
    (script := folder / "program.py").write_text(KERNEL)
    variables = {"NUMBA_CACHE_DIR": folder / "cache", "XDG_CACHE_HOME": folder / "home", **variables}
    how = {"preexec_fn": prepare, "capture_output": True, "text": True}
    done = subprocess.run([sys.executable, script], env=environment(**variables), **how)
    assert done.returncode == 0, done.stderr
    value, hits, notices, *sentences = done.stdout.split(maxsplit=3)
    assert float(value) == 6.0
    return int(hits), int(notices), "".join(sentences)


def of_another_user(path):
    if os.geteuid():
        pytest.skip("only root gives folders away")
    os.chown(path, 54321, -1)


CLOSED = "others can write there"
OPENED = {  # what others can do with a folder above the kernels, how far above, and what is told
    "writable by all": (lambda path: path.chmod(0o777), 0, CLOSED),
    "writable by the group": (lambda path: path.chmod(0o775), 1, CLOSED),
    "above, writable by all": (lambda path: path.chmod(0o777), 2, CLOSED),
    "above, of another user": (of_another_user, 2, "belongs to another user"),
    "above, sticky, of another user": (lambda path: [path.chmod(0o1777), of_another_user(path)], 2, "another user"),
}


@pytest.mark.parametrize("opened", OPENED)
def test_kernels_that_another_user_could_have_exchanged_are_not_run(opened, tmp_path):
    compiled(tmp_path)
    file, (open_to_others, above, told) = kept_kernel(tmp_path), OPENED[opened]
    booby_trap(file, tmp_path)
    open_to_others(place := file.parents[above])
    _, notices, sentence = compiled(tmp_path)
    assert not (tmp_path / "executed").exists()
    assert notices == 1 and str(place) in sentence and told in sentence


def test_a_kernel_that_others_can_write_is_made_anew_and_a_sticky_folder_above_is_no_harm(tmp_path):
    compiled(tmp_path)
    (tmp_path / "cache").chmod(0o1777)
    assert compiled(tmp_path)[:2] == (1, 0)
    booby_trap(kept_kernel(tmp_path), tmp_path)
    kept_kernel(tmp_path).chmod(0o666)
    assert compiled(tmp_path)[:2] == (0, 0) and not (tmp_path / "executed").exists()
    assert compiled(tmp_path)[:2] == (1, 0), "replaced by one of the user's own"


def test_matrices_and_meshes_are_kept_where_nobody_else_can_write(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    assert user_cache("meshes").stat().st_mode & 0o777 == 0o700
    (tmp_path / "home").chmod(0o777)
    with pytest.raises(PermissionError, match="others can write there"):
        user_cache("meshes")
    monkeypatch.setattr(compiling, "pace_file", lambda: user_cache() / "pace.json")
    assert compiling.pace("fem") == 1.0  # as where nothing is kept


@slow
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_is_compiled_anew_and_replaced(damage, tmp_path):
    assert [compiled(tmp_path)[:2] for _ in range(2)] == [(0, 0), (1, 0)]
    file = kept_kernel(tmp_path)
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    hits, notices, sentence = compiled(tmp_path)
    assert (hits, notices) == (0, 1) and "damaged and have been compiled anew" in sentence
    assert compiled(tmp_path)[:2] == (1, 0)


@slow
@pytest.mark.parametrize("damage", ["empty", "cut", "zeroed"])
def test_a_run_with_a_damaged_time_loop_compiles_it_once_more(damage, coarse_run, tmp_path):
    folder = tmp_path / "kernels" / version()
    shutil.copytree(cache_folder(), folder)
    for file in folder.glob("fem.kernels.elements.loop.advance-*.nbc"):
        file.write_bytes(DAMAGES[damage](file.read_bytes()))
    first, second = (command("run-fem", *COARSE, tmp_path / "run.nc", NUMBA_CACHE_DIR=tmp_path) for _ in range(2))
    assert first.returncode == second.returncode == 0, first.stderr
    assert f"warning: {folder}: compiled kernels there were damaged" in first.stderr
    assert first.stderr.count("\n") == 1 and second.stderr == ""


@pytest.mark.parametrize("loop", [False, pytest.param(True, marks=slow)], ids=["a kernel", "a run"])
def test_where_nothing_can_be_written_kernels_are_not_kept_and_runs_complete(loop, tmp_path):
    (tmp_path / "file").write_text("in the way")
    closed = dict.fromkeys(("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"), tmp_path / "file")
    if loop:
        done = command("run-fem", *COARSE, tmp_path / "run.nc", **closed)
        assert done.returncode == 0, done.stderr
    else:
        assert compiled(tmp_path, **closed)[:2] == (0, 0)


def test_a_full_disk_costs_the_next_start_a_compilation_and_nothing_else(tmp_path):
    assert compiled(tmp_path, lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000)))[:2] == (0, 0)
    assert not list((tmp_path / "cache").rglob("*.twice-*")), "nor is half a file left"
    assert [compiled(tmp_path)[:2] for _ in range(2)] == [(0, 0), (1, 0)]


def shortened(data):
    at = data.index(b"'shape': (") + 10
    return data[:at] + b"1" + data[at + 1 :]


OF_ARRAYS = DAMAGES | {"shortened": shortened, "another header": lambda data: data[:30] + b"\xff" * 40 + data[70:]}


@pytest.mark.parametrize("damage", ["one bit flipped", "shortened", *(
    pytest.param(name, marks=slow) for name in ("empty", "cut", "zeroed", "another header"))])  # fmt: skip
def test_a_run_makes_damaged_matrices_and_meshes_anew(damage, coarse_run, tmp_path):
    """At 2.1 mm, whose meshes are not shipped. Compiled kernels are this session's."""
    caches = {"XDG_CACHE_HOME": tmp_path, "NUMBA_CACHE_DIR": cache_folder().parents[1]}

    def run(name):
        done = command("run-fem", *OPTIONS, "--mesh-size", "2.1", "--output", tmp_path / name, **caches)
        assert (done.returncode, done.stderr) == (0, "")

    run("1.nc")
    folders = (tmp_path / "roller-bearing-fem" / name for name in ("kept", "meshes"))
    files = {path: path.read_bytes() for folder in folders for path in folder.iterdir()}
    assert len(files) >= 4
    for path, data in files.items():
        path.write_bytes(OF_ARRAYS[damage](data))
    run("2.nc")
    assert {path: path.read_bytes() for path in files} == files
    assert same_data(tmp_path / "1.nc", tmp_path / "2.nc")


@pytest.mark.parametrize(("settings", "name"), [
    (b"text.usetex: True\nbackend: bogus\n", "check-residual"),
    *(pytest.param(b"\xff\xfe\x00", name, marks=slow) for name in ("check-residual", "render-fem")),
])  # fmt: skip
def test_no_figure_obeys_the_current_folder_or_a_variable(settings, name, coarse_run, tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(settings)
    options = ["--no-equations", "--output", "report"] if name == "check-residual" else ["--output", "a.png"]
    done = command(name, coarse_run, *options, "--quiet", folder=tmp_path, MPLBACKEND="bogus")
    assert (done.returncode, done.stderr) == (0, "")


ROOT = Path(__file__).resolve().parents[1]
SOURCES = {path: path.read_text(encoding="utf-8") for package in ("lagrange", "meshes", "fem", "residual") for path in
           sorted((ROOT / package).rglob("*.py"))}  # fmt: skip


@pytest.mark.skipif(not can_be_made_bare(), reason="needs /proc")
def test_a_run_is_made_resumed_and_checked_on_a_system_that_lacks_what_linux_has_whatever_the_code_page(tmp_path):
    def barely(*words):
        done = bare(*words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        return done

    run = "run-fem", "--model", "reduced", "--output", "a.nc", "--duration"
    barely(*run, "1")
    barely(*run, "1.5", "--resume")
    with h5py.File(tmp_path / "a.nc") as file:
        assert file.attrs["status"] == "complete" and file["time"].shape == (151,)
    barely("check-residual", "a.nc", "--no-figures")
    page = (tmp_path / "a-residual" / "report.html").read_bytes().decode("utf-8")
    assert "µ" in page and "�" not in page
    json.loads((tmp_path / "a-residual" / "summary.json").read_bytes().decode("utf-8"))
    barely("run-fem", "--example", "all")
    text = (tmp_path / "all.toml").read_bytes().decode("utf-8")
    assert "−" in text and "\r" not in text
    done = barely("run-fem", "all.toml", "--dry-run", "--model", "lagrange")
    assert "µm" in done.stdout.decode("cp1252")


def texts_without_encoding(source):
    for call in (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)):
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        if name not in ("open", "fdopen", "read_text", "write_text", "TextIOWrapper"):
            continue
        whose = ast.unparse(getattr(call.func, "value", None) or call.func)
        if name == "open" and (whose in ("os", "Image", "archive", "webbrowser") or whose.split(".")[-1] == "TdmsFile"):
            continue
        given = [*call.args, *(keyword.value for keyword in call.keywords if keyword.arg == "mode")]
        modes = [arg.value for arg in given[:2] if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]
        if not any("b" in mode for mode in modes) and not any(keyword.arg == "encoding" for keyword in call.keywords):
            yield call.lineno


def test_every_text_file_is_opened_in_a_named_encoding():
    for text in ("open(p)", "p.read_text()", "p.open('w')", "p.write_text(t)", "open(p, mode='a')"):
        assert list(texts_without_encoding(text)) == [1], text
    for text in ("open(p, 'rb')", "p.read_text(encoding='utf-8')", "os.open(p, f)", "open(p, 'wb')"):
        assert not list(texts_without_encoding(text)), text
    assert not [f"{path}:{line}" for path, text in SOURCES.items() for line in texts_without_encoding(text)]


def test_what_a_system_may_lack_is_asked_for_before_it_is_used():
    for path, text in SOURCES.items():
        for node in ast.parse(text).body:
            names = [alias.name for alias in getattr(node, "names", ())] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            assert not set(names) & set(MODULES), path
        for name in (name for name in LACKING if f"os.{name}(" in text):
            assert f'hasattr(os, "{name}")' in text or 'Path("/proc' in text, f"{path.name}: os.{name}"

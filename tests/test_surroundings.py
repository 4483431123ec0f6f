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
from lagrange.files.output import write_sealed
from tests.reference.bare_system import LACKING, MODULES, bare, can_be_made_bare
from tests.reference.kit import command, environment, same_data

OPTIONS = ["--duration", "0.1", "--quiet"]
COARSE = [*OPTIONS, "--mesh-size", "2"]
KERNEL = """
from fem.kernels import kernel_folder
from fem.kernels.jit import kernel

@kernel
def twice(x):
    return 2.0 * x

print(twice(3.0), sum(twice.stats.cache_hits.values()), len(kernel_folder.notices), *kernel_folder.notices)
"""


@pytest.mark.slow
def test_a_module_in_the_current_folder_is_not_run_by_a_picture(coarse_run, tmp_path):
    for name in ("matplotlib", "imageio_ffmpeg", "numpy"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'executed')!r}, 'w')\nraise SystemExit(3)\n")
    done = command("render-fem", coarse_run, "--output", tmp_path / "picture.png", "--width", 300, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").exists() and not (tmp_path / "executed").exists()


class Touch:
    """An object that makes a folder when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return os.mkdir, (self.path,)


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX rights")
def test_kernels_in_a_folder_that_others_can_write_are_not_loaded(coarse_run, tmp_path):
    """The user's own cache, which is private, serves instead."""
    foreign, own = (tmp_path / name / "kernels" for name in ("foreign", "own/roller-bearing-fem"))
    own.mkdir(parents=True)
    shutil.copytree(cache_folder(), own / version())
    shutil.copytree(cache_folder(), foreign / version())
    for path in (foreign / version()).iterdir():
        write_sealed(path, pickle.dumps(Touch(tmp_path / "executed")))
    foreign.parent.chmod(0o777)
    done = command(
        "run-fem", *COARSE, "--output", tmp_path / "run.nc",
        NUMBA_CACHE_DIR=foreign.parent, XDG_CACHE_HOME=tmp_path / "own",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert f"warning: {foreign / version()}: compiled kernels there are not used: {foreign.parent}: " in done.stderr
    assert done.stderr.count("\n") == 1 and not (tmp_path / "executed").exists()


DAMAGES = {
    "empty": lambda data: b"",
    "cut": lambda data: data[: len(data) // 2],
    "zeroed": lambda data: bytes(len(data)),
    "one bit flipped": lambda data: data[:150] + bytes([data[150] ^ 8]) + data[151:],
}


def compiled(folder, prepare=None, **variables):
    """What a program with a kernel of its own prints, whose caches are in a folder."""
    (script := folder / "program.py").write_text(KERNEL)
    variables = {"NUMBA_CACHE_DIR": folder / "cache", "XDG_CACHE_HOME": folder / "home", **variables}
    done = subprocess.run(
        [sys.executable, script], env=environment(**variables), preexec_fn=prepare, capture_output=True, text=True
    )
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


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX rights")
@pytest.mark.parametrize("opened", OPENED)
def test_kernels_that_another_user_could_have_exchanged_are_not_run(opened, tmp_path):
    compiled(tmp_path)
    (file,) = (tmp_path / "cache").rglob("*.twice-*.nbc")
    write_sealed(file, pickle.dumps(Touch(tmp_path / "executed")))
    open_to_others, above, told = OPENED[opened]
    open_to_others(place := file.parents[above])
    _, notices, sentence = compiled(tmp_path)
    assert not (tmp_path / "executed").exists()
    assert notices == 1 and str(place) in sentence and told in sentence


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX rights")
def test_a_kernel_that_others_can_write_is_made_anew_and_a_sticky_folder_above_is_no_harm(tmp_path):
    compiled(tmp_path)
    (tmp_path / "cache").chmod(0o1777)
    assert compiled(tmp_path)[:2] == (1, 0)
    (file,) = (tmp_path / "cache").rglob("*.twice-*.nbc")
    write_sealed(file, pickle.dumps(Touch(tmp_path / "executed")))
    file.chmod(0o666)
    assert compiled(tmp_path)[:2] == (0, 0) and not (tmp_path / "executed").exists()
    assert compiled(tmp_path)[:2] == (1, 0), "replaced by one of the user's own"


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX rights")
def test_matrices_and_meshes_are_kept_where_nobody_else_can_write(tmp_path, monkeypatch):
    from fem.solver import compiling
    from lagrange.files.input import user_cache

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    assert user_cache("meshes").stat().st_mode & 0o777 == 0o700
    (tmp_path / "home").chmod(0o777)
    with pytest.raises(PermissionError, match="others can write there"):
        user_cache("meshes")
    monkeypatch.setattr(compiling, "pace_file", lambda: user_cache() / "pace.json")
    assert compiling.pace("fem") == 1.0  # as where nothing is kept


@pytest.mark.slow
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_is_compiled_anew_and_replaced(damage, tmp_path):
    assert compiled(tmp_path)[:2] == (0, 0)
    assert compiled(tmp_path)[:2] == (1, 0)
    (file,) = (tmp_path / "cache").rglob("*.twice-*.nbc")
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    hits, notices, sentence = compiled(tmp_path)
    assert (hits, notices) == (0, 1) and "damaged and have been compiled anew" in sentence
    assert compiled(tmp_path)[:2] == (1, 0)


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["empty", "cut", "zeroed"])
def test_a_run_with_a_damaged_time_loop_compiles_it_once_more(damage, coarse_run, tmp_path):
    folder = tmp_path / "kernels" / version()
    shutil.copytree(cache_folder(), folder)
    files = list(folder.glob("fem.kernels.elements.loop.advance-*.nbc"))
    for file in files:
        file.write_bytes(DAMAGES[damage](file.read_bytes()))
    arguments = [*COARSE, "--output", tmp_path / "run.nc"]
    first, second = (command("run-fem", *arguments, NUMBA_CACHE_DIR=tmp_path) for _ in range(2))
    assert first.returncode == second.returncode == 0, first.stderr
    assert f"warning: {folder}: compiled kernels there were damaged" in first.stderr and first.stderr.count("\n") == 1
    assert second.stderr == ""


def test_where_nothing_can_be_written_kernels_are_not_kept(tmp_path):
    (tmp_path / "file").write_text("in the way")
    closed = {"NUMBA_CACHE_DIR": tmp_path / "file", "XDG_CACHE_HOME": tmp_path / "file", "HOME": tmp_path / "file"}
    assert compiled(tmp_path, **closed)[:2] == (0, 0)


def test_a_full_disk_costs_the_next_start_a_compilation_and_nothing_else(tmp_path):
    def fill():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))

    assert compiled(tmp_path, fill)[:2] == (0, 0)
    assert not list((tmp_path / "cache").rglob("*.twice-*")), "nor is half a file left"
    assert compiled(tmp_path)[:2] == (0, 0)
    assert compiled(tmp_path)[:2] == (1, 0)


def shortened(data):
    """An array that says of itself that it is shorter than it is."""
    at = data.index(b"'shape': (") + len(b"'shape': (")
    return data[:at] + b"1" + data[at + 1 :]


DAMAGES_OF_ARRAYS = DAMAGES | {
    "shortened": shortened,
    "another header": lambda data: data[:30] + b"\xff" * 40 + data[70:],
}


@pytest.mark.parametrize(
    "damage",
    [
        d if d in ("one bit flipped", "shortened") else pytest.param(d, marks=pytest.mark.slow)
        for d in DAMAGES_OF_ARRAYS
    ],
)
def test_a_run_makes_damaged_matrices_and_meshes_anew(damage, coarse_run, tmp_path):
    """At 2.1 mm, whose meshes are not shipped. Compiled kernels are this session's."""
    folder, arguments = tmp_path / "roller-bearing-fem", [*OPTIONS, "--mesh-size", "2.1"]
    caches = {"XDG_CACHE_HOME": tmp_path, "NUMBA_CACHE_DIR": cache_folder().parents[1]}
    first = command("run-fem", *arguments, "--output", tmp_path / "1.nc", **caches)
    assert first.returncode == 0, first.stderr
    files = {path: path.read_bytes() for name in ("kept", "meshes") for path in (folder / name).iterdir()}
    assert len(files) >= 4
    for path, data in files.items():
        path.write_bytes(DAMAGES_OF_ARRAYS[damage](data))
    second = command("run-fem", *arguments, "--output", tmp_path / "2.nc", **caches)
    assert second.returncode == 0 and second.stderr == ""
    assert {path: path.read_bytes() for path in files} == files
    assert same_data(tmp_path / "1.nc", tmp_path / "2.nc")


@pytest.mark.slow
def test_a_run_without_a_home_is_complete(tmp_path):
    (tmp_path / "file").write_text("in the way")
    closed = {"NUMBA_CACHE_DIR": tmp_path / "file", "XDG_CACHE_HOME": tmp_path / "file", "HOME": tmp_path / "file"}
    done = command("run-fem", *COARSE, "--output", tmp_path / "run.nc", **closed)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        (b"text.usetex: True\nbackend: bogus\n", "check-residual"),
        pytest.param(b"\xff\xfe\x00", "check-residual", marks=pytest.mark.slow),
        pytest.param(b"\xff\xfe\x00", "render-fem", marks=pytest.mark.slow),
    ],
)
def test_no_figure_obeys_the_current_folder_or_a_variable(settings, name, coarse_run, tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(settings)
    options = ["--no-equations", "--output", "report"] if name == "check-residual" else ["--output", "a.png"]
    done = command(name, coarse_run, *options, "--quiet", folder=tmp_path, MPLBACKEND="bogus")
    assert (done.returncode, done.stderr) == (0, "")


# Other systems: no fork, fcntl, resource or pwrite, renames of closed files only, a code page instead of UTF-8


ROOT = Path(__file__).resolve().parents[1]
SOURCES = [
    path for package in ("lagrange", "meshes", "fem", "residual") for path in sorted((ROOT / package).rglob("*.py"))
]
SHORT = ("--model", "reduced", "--duration", "1")


@pytest.mark.skipif(not can_be_made_bare(), reason="needs /proc")
def test_a_run_is_made_resumed_and_checked_on_a_system_that_lacks_what_linux_has(tmp_path):
    done = bare("run-fem", *SHORT, "--output", "a.nc", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    done = bare("run-fem", "--model", "reduced", "--duration", "1.5", "--output", "a.nc", "--resume", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.nc") as file:
        assert file.attrs["status"] == "complete" and file["time"].shape == (151,)
    done = bare("check-residual", "a.nc", "--no-figures", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "a-residual" / "report.html").read_bytes().decode("utf-8")
    assert "µ" in page and "�" not in page
    json.loads((tmp_path / "a-residual" / "summary.json").read_bytes().decode("utf-8"))


@pytest.mark.skipif(not can_be_made_bare(), reason="needs /proc")
def test_examples_are_utf_8_whatever_the_code_page(tmp_path):
    done = bare("run-fem", "--example", "all", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "all.toml").read_bytes().decode("utf-8")
    assert "−" in text and "\r" not in text
    done = bare("run-fem", "all.toml", "--dry-run", "--model", "lagrange", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "µm" in done.stdout.decode("cp1252")


def calls(source):
    tree = ast.parse(source.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.Call)]


def text_without_encoding(call):
    """Whether a call opens, reads or writes a file as text in whatever encoding there is."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name not in ("open", "fdopen", "read_text", "write_text", "TextIOWrapper"):
        return False
    of = getattr(call.func, "value", None)
    whose = ast.unparse(of or call.func)
    if name == "open" and (whose in ("os", "Image", "archive", "webbrowser") or whose.endswith(".TdmsFile")):
        return False
    given = [*call.args, *(keyword.value for keyword in call.keywords if keyword.arg == "mode")]
    binary = any(isinstance(arg, ast.Constant) and isinstance(arg.value, str) and "b" in arg.value for arg in given[:2])
    return not binary and not any(keyword.arg == "encoding" for keyword in call.keywords)


@pytest.mark.parametrize(
    ("texts", "found"),
    [
        (("open(p)", "p.read_text()", "p.open('w')", "p.write_text(t)", "open(p, mode='a')"), True),
        (("open(p, 'rb')", "p.read_text(encoding='utf-8')", "os.open(p, f)", "open(p, 'wb')"), False),
    ],
)
def test_the_search_finds_text_in_whatever_encoding_and_leaves_the_rest(texts, found):
    for text in texts:
        (call,) = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
        assert text_without_encoding(call) is found, text


def test_every_text_file_is_opened_in_a_named_encoding():
    assert not [f"{path}:{call.lineno}" for path in SOURCES for call in calls(path) if text_without_encoding(call)]


def test_no_module_needs_a_unix_module_to_be_imported():
    """Such imports stand inside functions, or are tried."""
    for path in SOURCES:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [alias.name for alias in getattr(node, "names", ())] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            assert not set(names) & set(MODULES), path


def test_what_a_system_may_lack_is_asked_for_before_it_is_used():
    """os.fork and the like stand only in modules that look whether they are there."""
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        for name in LACKING:
            if f"os.{name}(" in text:
                assert f'hasattr(os, "{name}")' in text or 'Path("/proc' in text, f"{path.name}: os.{name}"

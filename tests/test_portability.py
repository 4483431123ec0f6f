"""Other systems: no fork, fcntl, resource or pwrite, renames of closed files only, a code page instead of UTF-8."""

import ast
import json
from pathlib import Path

import h5py
import pytest

from tests.reference.bare_system import LACKING, MODULES, bare, can_be_made_bare

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
    if name == "open" and isinstance(of, ast.Name) and of.id in ("os", "Image", "archive", "webbrowser"):
        return False
    given = [*call.args, *(keyword.value for keyword in call.keywords if keyword.arg == "mode")]
    binary = any(isinstance(arg, ast.Constant) and isinstance(arg.value, str) and "b" in arg.value for arg in given[:2])
    return not binary and not any(keyword.arg == "encoding" for keyword in call.keywords)


@pytest.mark.parametrize("text", ["open(p)", "p.read_text()", "p.open('w')", "p.write_text(t)", "open(p, mode='a')"])
def test_the_search_finds_text_in_whatever_encoding(text):
    (call,) = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
    assert text_without_encoding(call)


@pytest.mark.parametrize("text", ["open(p, 'rb')", "p.read_text(encoding='utf-8')", "os.open(p, f)", "open(p, 'wb')"])
def test_the_search_leaves_the_rest(text):
    (call,) = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
    assert not text_without_encoding(call)


def test_every_text_file_is_opened_in_a_named_encoding():
    found = [
        f"{path.relative_to(ROOT)}:{call.lineno}"
        for path in SOURCES
        for call in calls(path)
        if text_without_encoding(call)
    ]
    assert found == []


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

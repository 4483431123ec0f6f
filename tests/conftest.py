"""What all tests share: a cache of meshes, a short run on the coarse mesh, reports without figures, a browser."""

import os
import shutil
import signal
import tempfile
import threading
from collections import Counter
from pathlib import Path
from unittest import mock

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN and threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background command: children ignore it, too
_CACHE = tempfile.TemporaryDirectory(prefix="test-cache-")  # a user's cache neither helps a test nor is changed by one
mock.patch("meshes.cache.cache_folder", lambda: Path(_CACHE.name) / "meshes").start()

mock.patch("fem.solver.compiling.pace_file", lambda: Path(_CACHE.name) / "pace.json").start()

# Two processes begin with these: one compiles the time loops, and the other files need no kernel.
FIRST = ("test_bad_input.py", "test_equilibrium.py", "test_lagrange_motion.py")
BROWSERS = ("chromium", "chromium-browser", "chromium-headless-shell", "google-chrome")


def pytest_configure(config):
    config.option.loadscopereorder = False  # `--dist loadfile` hands out files as they are collected


@pytest.hookimpl(trylast=True)  # of the tests that are run
def pytest_collection_modifyitems(items):
    """Put the first files in front, then those of many tests."""
    tests = Counter(item.path.name for item in items)
    place = {name: place - len(FIRST) for place, name in enumerate(FIRST)}
    items.sort(key=lambda item: (place.get(item.path.name, 0), -tests[item.path.name]))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder of its own to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def coarse_run(tmp_path_factory):
    """Result file of 4 ms of the paper's bearing at 2 mm."""
    from fem.commands.run_fem import run_main

    path = tmp_path_factory.mktemp("coarse") / "coarse.nc"
    assert run_main(["--mesh-size", "2", "--duration", "4", "--output", str(path), "--quiet"]) == 0
    return path


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """Result file of a short run that nothing disturbed."""
    from fem.commands.run_fem import run_main
    from tests.reference.kit import SHORT

    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*SHORT, "--output", str(path)]) == 0
    return path


@pytest.fixture(scope="session")
def can_draw():
    """Skip the test on a machine that can't draw off-screen."""
    from fem.pictures.output import check_rendering
    from lagrange.errors import UsageError

    try:
        check_rendering()
    except UsageError as error:
        pytest.skip(f"no off-screen rendering here: {error}")


@pytest.fixture
def plain_report(monkeypatch):
    """Make reports without figures, which take most of the time and are tested elsewhere."""
    monkeypatch.setattr("residual.figures.run.draw_figures", lambda *_: {})


@pytest.fixture(scope="session")
def browser():
    """Headless Chromium; where a browser is promised (REQUIRE_BROWSER), its absence is a failure."""
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    missing = pytest.fail if os.environ.get("REQUIRE_BROWSER") else pytest.skip
    if path is None:
        missing(f"no browser here ({', '.join(BROWSERS)}): apt-get install chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("playwright is not installed: pip install playwright")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()

"""What all tests share: their own cache of meshes, a short simulation on the coarse mesh, reports without figures."""

import os
import tempfile
from pathlib import Path
from unittest import mock

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")
_CACHE = tempfile.TemporaryDirectory(prefix="test-cache-")  # a user's cache neither helps a test nor is changed by one
mock.patch("meshes.cache.cache_folder", lambda: Path(_CACHE.name) / "meshes").start()


@pytest.fixture(scope="session")
def coarse_run(tmp_path_factory):
    """Result file of 4 ms of the paper's bearing at 2 mm."""
    from fem.cli import run_main

    path = tmp_path_factory.mktemp("coarse") / "coarse.nc"
    assert run_main(["--mesh-size", "2", "--duration", "4", "--output", str(path), "--quiet"]) == 0
    return path


@pytest.fixture(scope="session")
def can_draw():
    """Skip the test on a machine that can't draw off-screen."""
    from fem.errors import UsageError
    from fem.pictures.rendering_probe import check_rendering

    try:
        check_rendering()
    except UsageError as error:
        pytest.skip(f"no off-screen rendering here: {error}")


@pytest.fixture
def plain_report(monkeypatch):
    """Make reports without figures, which take most of the time and are tested elsewhere."""
    monkeypatch.setattr("residual.paper_figures.paper_figures", lambda *_: [])
    monkeypatch.setattr("residual.motion_figures.motion_figures", lambda *_: [])
    monkeypatch.setattr("residual.budget_figures.budget_figures", lambda *_: [])
    monkeypatch.setattr("residual.vibration_figures.vibration_figures", lambda *_: [])

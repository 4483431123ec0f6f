"""The studies that the docs show: their files are studies, their programs run on a smaller one."""

import re
import runpy
import shutil
import sys
from pathlib import Path

import pytest

from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main
from fem.study.sampling import design_of
from fem.study.solving import checked_points
from fem.study.study_file import read_study
from tests.documented import blocks

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture
def here(tmp_path, monkeypatch):
    for path in (DOCS / "studies").iterdir():
        if path.is_file():
            shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def points(name):
    study = read_study(Path(name))
    return checked_points(study, design_of(study))


def script(name, *words, monkeypatch):
    monkeypatch.setattr(sys, "argv", [name, *words])
    runpy.run_path(name, run_name="__main__")


def test_the_study_shown_is_one(here):
    (block,) = blocks(DOCS / "studies.md", "toml")
    Path("shown.toml").write_text(block)
    assert run_main(["--example", "NU206"]) == 0
    found = points("shown.toml")
    assert found.design.shape == (2, 3, 2, 2) and found.study.name == "clearance"
    # what is commented out can be taken in
    drawn = block.replace('"grid"', '"sobol"').replace("# samples", "samples").replace("# seed", "seed")
    drawn = drawn.replace("# indices", "indices").replace('# "material', '"material')
    Path("drawn.toml").write_text(re.sub(r", count = \d+", "", drawn))
    assert len(points("drawn.toml")) == 64 * (5 + 2)


def test_the_example_studies_are_studies(here, monkeypatch):
    assert len(points("clearance.toml")) == 42
    assert len(points("widths.toml")) == 84
    assert len(points("profiles.toml")) == 28
    script("spalls.py", "8", monkeypatch=monkeypatch)
    found = points("spalls.toml")
    bodies = ["none" if not (spalls := found.scene(i).spall) else spalls[0].body for i in range(8)]
    assert bodies == ["none", "outer_ring", "inner_ring", "roller"] * 2


@pytest.mark.slow
def test_the_programs_of_the_examples_run(here, monkeypatch, capsys):
    pytest.importorskip("sklearn")
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    script("spalls.py", "16", monkeypatch=monkeypatch)
    Path("docs").mkdir()
    shutil.move("clearance.py", "docs/clearance.py")
    text = Path("clearance.toml").read_text().replace("count = 7", "count = 2").replace("count = 6", "count = 2")
    Path("clearance.toml").write_text(text)
    for name in ("clearance", "spalls"):
        assert study_main([f"{name}.toml", "--quiet", "--workers", "1"]) == 0
    script("docs/clearance.py", monkeypatch=monkeypatch)
    script("spalls.py", monkeypatch=monkeypatch)
    assert "of 8 right" in capsys.readouterr().out

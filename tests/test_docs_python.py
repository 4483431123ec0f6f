"""Every example of the pages about Python is run, one page after the other from top to bottom."""

from pathlib import Path

import pytest

from tests.documented import blocks

DOCS = Path(__file__).parent.parent / "docs"


@pytest.mark.parametrize("page", ["python.md"])
def test_every_example_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    found = blocks(DOCS / page, "python")
    assert found
    for number, text in enumerate(found):
        exec(compile(text, f"{page}, example {number}", "exec"), names)
    said = capsys.readouterr().out
    assert "did you mean speed_rpm" in said and "interrupted" in said

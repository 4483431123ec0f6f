"""Every example of the pages about Python is run, one page after the other from top to bottom."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", (DOCS / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", ["python.md"])
def test_every_example_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    found = blocks(page)
    assert found
    for number, text in enumerate(found):
        exec(compile(text, f"{page}, example {number}", "exec"), names)
    said = capsys.readouterr().out
    assert "did you mean speed_rpm" in said and "interrupted" in said

"""Every example of the pages about Python is run, one page after the other from top to bottom."""

import sys
from pathlib import Path

import pytest

from tests.documented import blocks, same

DOCS = Path(__file__).parent.parent / "docs"


@pytest.mark.parametrize("page", ["python.md"])
def test_every_example_runs_and_prints_what_its_comments_say(page, tmp_path, monkeypatch):
    """A comment on the line after a `print` is what that prints."""
    monkeypatch.chdir(tmp_path)
    compared, lines = 0, []

    def compare(*values):
        nonlocal compared
        after = lines[sys._getframe(1).f_lineno].strip()
        if after.startswith("# "):
            assert same(after[2:], " ".join(map(str, values)))
            compared += 1

    names: dict[str, object] = {"print": compare}
    for number, text in enumerate(blocks(DOCS / page, "python")):
        lines[:] = [*text.splitlines(), "", ""]
        exec(compile(text, f"{page}, example {number}", "exec"), names)
    assert compared >= 4

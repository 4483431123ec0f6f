"""What commands that write pages of docs/ share."""

import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def commit() -> str:
    """Short name of the checked-out commit."""
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()


def write_section(page: str, heading: str, text: str) -> None:
    """Replace a page's section of the second level, up to the next one; add it at the end where there is none."""
    path, sign = DOCS / page, f"## {heading}\n"
    before, _, old = path.read_text().partition(f"\n{sign}")
    _, _, after = old.partition("\n## ")
    rest = f"\n## {after}" if after else ""
    path.write_text(f"{before.rstrip()}\n\n{sign}\n{text.strip()}\n{rest}")


def markdown_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table in markdown."""
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (headings, ["---"] * len(headings), *rows))

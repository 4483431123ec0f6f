"""`python -m benchmarks.elements` prints every figure and writes docs/elements.md and docs/elements.png."""

import subprocess
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.elements.bodies import paper_bodies
from benchmarks.elements.candidates import SIZES_MM, candidates
from benchmarks.elements.compare import plot, ratio_rows, rows
from benchmarks.elements.measure import measure
from benchmarks.elements.page import page

DOCS = Path(__file__).parents[2] / "docs"


def main() -> None:
    """Measure, print, write."""
    console, began = Console(width=210), time.perf_counter()
    points = []
    for body in paper_bodies():
        points += [measure(body, name, size) for name in candidates(body) for size in SIZES_MM]
        for cells in (rows(points, body.name), ratio_rows(points, body.name)):
            table = Table(*cells[0], title=body.name)
            for row in cells[1:]:
                table.add_row(*[cell.replace("**", "") for cell in row])
            console.print(table)
    plot(points, DOCS / "elements.png")
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    (DOCS / "elements.md").write_text(page(points, commit), encoding="utf-8")
    console.print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()

"""docs/elements.md."""

from benchmarks.elements.candidates import SOLVERS
from benchmarks.elements.compare import ratio_rows, rows
from benchmarks.elements.measure import Point


def page(points: list[Point], commit: str) -> str:
    """The page with its tables."""
    return TEXT.format(
        commit=commit,
        ratios="\n\n".join(_markdown(ratio_rows(points, body)) for body in SOLVERS),
        figures="\n\n".join(f"### {body.capitalize()}\n\n{_markdown(rows(points, body))}" for body in SOLVERS),
    )


def _markdown(cells: list[list[str]]) -> str:
    lines = [cells[0], ["---"] * len(cells[0]), *cells[1:]]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


TEXT = """{commit} {ratios} {figures}"""

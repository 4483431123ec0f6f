"""Rows about the levels of lines, for the report and the terminal."""

from residual.evaluation import Evaluation
from residual.lines import LineLevel
from residual.words import text


def level_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of line, Hz, N rms and background in x and in y, resolved; levels that stand out are marked."""
    rows = []
    for x, y in zip(evaluation.x.levels, evaluation.y.levels, strict=True):
        rows.append([x.name, text(x.frequency), *_cells(x), *_cells(y), "yes" if x.resolved else f"no: {x.obstacle}"])
    return rows


def _cells(level: LineLevel) -> list[str]:
    return [text(level.rms, 3) + (" *" if level.stands_out else ""), text(level.background, 3)]


def watched_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of a line asked for, N rms in x and in y, background in x and y, resolved."""
    return [
        [
            x.name if x.name.endswith("Hz") else f"{x.name} ({text(x.frequency)} Hz)",
            text(x.rms, 3),
            text(y.rms, 3),
            f"{text(x.background, 3)}, {text(y.background, 3)}",
            "yes" if x.resolved else "no",
        ]
        for x, y in evaluation.watched
    ]

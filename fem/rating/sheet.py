"""Lines of the sheet of a rating: the value of each answer in words, by block."""

from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from fem.rating.answers import BULKY, Answer, Rating
from lagrange.messages import engineering
from lagrange.rating.sources import Source

MIXED = "N/m, N, N m", "N/µm, N/mrad, N m/mrad"  # of a matrix of displacements and, at its end, of both tilts
NAMES = {"skf": "SKF", "palmgren": "Palmgren"}
TABLED = "contacts", "catalogue", "stiffness_harmonics_N_per_m"  # no lines of the sheet


class Line(NamedTuple):
    """A line of the sheet."""

    meaning: str
    value: str  # of a matrix, lines
    source: Source


def sheet(rating: Rating, bulky: bool = False) -> dict[str, list[Line]]:
    """Answers that could be computed, by block; those of one meaning in one line."""
    found: dict[str, list[Line]] = {}
    for (block, meaning), group in groupby(rating.answers.values(), lambda answer: (answer.block, answer.meaning)):
        there = [each for each in group if each.value is not None and (bulky or each.name not in BULKY)]
        if there and there[0].name not in TABLED:
            line = Line(meaning, ", ".join(in_words(each) for each in there), there[0].source)
            found.setdefault(block, []).append(line)
    return found


def in_words(answer: Answer) -> str:
    """A value with its unit for people."""
    value, (factor, unit) = answer.value, engineering(answer.unit)
    if np.ndim(value) >= 2:
        return _matrix(np.asarray(value), answer.unit)
    return f"{number(value, factor)} {unit}".rstrip()


def number(value: Any, factor: float = 1.0) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        parts = ((NAMES.get(name, name.replace("_", " ")), part) for name, part in value.items() if part is not None)
        return ", ".join(f"{name} {number(part, factor)}" for name, part in parts)
    if np.ndim(value) == 1:
        return ", ".join(number(each, factor) for each in _rounded(np.asarray(value)))
    scaled = factor * float(value) + 0.0  # no -0
    return f"{scaled:.4g}" if abs(scaled) < 1e4 or abs(scaled) >= 1e7 else f"{scaled:.0f}"


def _rounded(values):  # 0 in place of the round-off of what symmetry makes 0
    return np.where(np.abs(values) < 1e-9 * np.max(np.abs(values)), 0.0, values)


def _matrix(value, unit):
    """Lines with entries below each other; of lowest and highest ones, a line an entry."""
    factor, words = engineering(unit)
    if value.ndim == 3:
        low, high = (_rounded(each) for each in (value.min(axis=0), value.max(axis=0)))
        parts = ((name, *map(number, factor * np.array([low[at], high[at]])))
                 for name, at in (("xx", (0, 0)), ("yy", (1, 1)), ("xy", (0, 1))))  # fmt: skip
        return "\n".join(f"{name} {least} to {most}" for name, least, most in parts) + f" {words}"
    scale, size = np.full(value.shape, factor), np.sqrt(np.abs(np.diag(value)))
    if unit == MIXED[0]:
        scale[:], scale[:-2, :-2], words = 1e-3, 1e-6, MIXED[1]
    entries = np.where(np.abs(value) < 1e-7 * np.outer(size, size), 0.0, scale * value)
    cells = [[number(each) for each in row] for row in entries]
    wide = max(len(cell) for row in cells for cell in row)
    rows = ["  ".join(f"{cell:>{wide}}" for cell in row) for row in cells]
    return "\n".join([words, *rows] if len(rows) > 2 else [*rows[:-1], f"{rows[-1]} {words}"])


def ratings_in_words(rating: Rating) -> list[str]:  # where they are not the standards'
    return [of["words"] for of in (rating["catalogue"] or {}).values() if of["words"]]


def missing(rating: Rating) -> dict[str, str]:
    """Meanings of answers that were asked for and could not be computed, by the reason."""
    found: dict[str, list[str]] = {}
    for answer in rating.answers.values():
        if answer.reason and answer.asked and answer.name not in BULKY:
            found.setdefault(answer.reason, []).append(answer.meaning)
    return {reason: "; ".join(dict.fromkeys(meanings)) for reason, meanings in found.items()}

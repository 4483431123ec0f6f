"""Columns of numbers in a text: comma, tab or semicolon between them, told by the header; # begins a comment."""

import csv
import hashlib
from collections.abc import Iterator

import numpy as np

LARGEST_FILE = 4 * 2**20  # bytes
MOST_ROWS = 50_000
LONGEST_LINE = 1000  # characters


def digest(text: str) -> str:
    """By which a table's text is known again: its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


def delimiter_of(header: str) -> str:
    """Tab or semicolon where a header has one, else comma."""
    return next((character for character in "\t;" if character in header), ",")


def columns(text: str, names: tuple[str, ...]) -> np.ndarray:
    """The columns of these names, (n_rows, n_names), as they stand there; others are left out.

    Errors
    ------
    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too many or too long rows.
    """
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) > MOST_ROWS + 2 or any(len(line) > LONGEST_LINE for line in lines):
        raise ValueError(f"more than {MOST_ROWS} rows, or a row of more than {LONGEST_LINE} characters")
    delimiter = delimiter_of(lines[0]) if lines else ","
    header = [name.strip() for name in next(_rows(lines[:1], delimiter), [])]
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    for name in names:
        if header.count(name) != 1:
            what = "missing" if name not in header else "there twice"
            raise ValueError(f"column {name} is {what}; its first line must name {listed}")
    wanted, rows = [header.index(name) for name in names], []
    needed = {2: "two", 3: "three"}[len(names)]
    for number, row in enumerate(_rows(lines[1:], delimiter), 1):
        try:
            rows.append([float(row[k]) for k in wanted])
        except (ValueError, IndexError):
            raise ValueError(f"row {number} below the header can't be read: {needed} numbers are needed") from None
    return np.array(rows).reshape(-1, len(names))


def _rows(lines: list[str], delimiter: str) -> Iterator[list[str]]:
    """The cells of each line. ValueError: quotation marks that do not close."""
    try:
        yield from csv.reader(lines, delimiter=delimiter)
    except csv.Error as error:
        raise ValueError(f"a row can't be read: {error}") from None

"""Columns of numbers in a text: comma, tab, semicolon or blanks between them, as the header has; # begins a comment.

Numbers are written with ASCII digits and without marks of thousands; their decimal sign is a key of whoever names the
file, since 1,5 and 1.500 are not the same number everywhere.
"""

import csv
import hashlib
import re
from collections.abc import Iterator, Sequence

import numpy as np

LARGEST_FILE = 4 * 2**20  # bytes
MOST_ROWS = 50_000
LONGEST_LINE = 1000  # characters
LONGEST_QUOTE = 40  # characters of a cell in a message
MOST_BEFORE = 100  # lines among which a header is looked for, where the first is none


def digest(text: str) -> str:
    """By which a table's text is known again: its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


def delimiter_of(header: str) -> str | None:
    """Tab, semicolon or comma, the first that a header has; None: blanks."""
    return next((character for character in "\t;," if character in header), None)


def names_of(header: str, delimiter: str | None) -> list[str]:
    """The names of a header; between blanks a unit in brackets belongs to the name before it.

    Errors
    ------
    ValueError: quotation marks that do not close.
    """
    if delimiter is None:
        return re.findall(r"[^\s\[]+(?:\s*\[[^\]]*\])?", header)
    return [name.strip() for name in next(_rows([header], delimiter), [])]


def columns(text: str, names: tuple[str, ...], decimal: str = ".") -> np.ndarray:
    """The columns of these names, (n_rows, n_names), as they stand there; others are left out.

    Errors
    ------
    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too many or too long rows.
    """
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) > MOST_ROWS + 2 or any(len(line) > LONGEST_LINE for line in lines):
        raise ValueError(f"more than {MOST_ROWS} rows, or a row of more than {LONGEST_LINE} characters")
    delimiter = delimiter_of(lines[0]) if lines else ","
    header = names_of(lines[0], delimiter) if lines else []
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    for name in names:
        if header.count(name) != 1:
            what = "missing" if name not in header else "there twice"
            raise ValueError(f"column {name} is {what}; its first line must name {listed}{header_below(lines, names)}")
    check_decimal(delimiter, decimal)
    wanted, rows = [header.index(name) for name in names], []
    for number, row in enumerate(_rows(lines[1:], delimiter), 1):
        if fault := row_fault(row, header, wanted, delimiter, decimal):
            raise ValueError(f"row {number} below the header can't be read: {fault}")
        rows.append([float(row[k].replace(decimal, ".")) for k in wanted])
    return np.array(rows).reshape(-1, len(names))


def check_decimal(delimiter: str | None, decimal: str) -> None:
    """ValueError: commas stand between columns and within numbers."""
    if delimiter == decimal:
        raise ValueError('decimal = ",", but commas are between its columns, too; write semicolons or tabs there')


def header_below(lines: Sequence[str], names: Sequence[str]) -> str:
    """What to do where a later line is the header; empty: none is."""
    for before, line in enumerate(lines[:MOST_BEFORE]):
        delimiter = delimiter_of(line)
        try:
            found = names_of(line, delimiter)
        except ValueError:
            continue
        if before and all(name in found for name in names):
            return f": the header comes after {before} other lines; begin those with #, or delete them"
    return ""


def row_fault(
    cells: Sequence[str], header: Sequence[str], wanted: Sequence[int], delimiter: str | None, decimal: str
) -> str | None:
    """Why a row can't be read, and what to do; None: it can.

    Parameters
    ----------
    cells : of the row; empty ones at its end don't count
    wanted : the columns that must be numbers
    """
    n_names = len(header)
    if any(cell.strip() for cell in cells[n_names:]):
        hint = ""
        if delimiter == ",":
            hint = '; where commas are decimal, write semicolons or tabs between columns and give decimal = ","'
        return f"{len(cells)} cells under {n_names} names{hint}"
    if len(cells) <= max(wanted) or (delimiter is None and len(cells) < n_names):
        return f"{len(cells)} cells under {n_names} names"
    faulty = [k for k in wanted if not _is_number(cells[k], decimal)]
    if not faulty:
        return None
    if len(faulty) == len(wanted) > 1 and all(re.search(r"[^\W\d]|[%°]", cells[k]) for k in wanted):
        return "no numbers in it; a line of units is none of the table's rows: delete it, or begin it with #"
    cell = cells[faulty[0]].strip()
    quoted = repr(cell if len(cell) <= LONGEST_QUOTE else f"{cell[:LONGEST_QUOTE]}…")
    return f"{header[faulty[0]]} = {quoted} is no number{_remedy(cell, decimal)}"


def _is_number(cell: str, decimal: str) -> bool:
    """Whether a cell is a number of ASCII digits with this decimal sign."""
    if not cell.isascii() or "_" in cell or (decimal != "." and "." in cell):
        return False
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _remedy(cell: str, decimal: str) -> str:
    if decimal == "." and _is_number(cell, ","):
        return '; give decimal = "," where commas are decimal'
    if decimal == "," and "." in cell:
        return '; with decimal = "," no point may stand in it'
    return "; write digits 0 to 9 without marks between thousands"


def _rows(lines: list[str], delimiter: str | None) -> Iterator[list[str]]:
    """The cells of each line. ValueError: quotation marks that do not close."""
    if delimiter is None:
        yield from (line.split() for line in lines)
        return
    try:
        yield from csv.reader(lines, delimiter=delimiter)
    except csv.Error as error:
        raise ValueError(f"a row can't be read: {error}") from None

"""Files that users and other files name: read whole, or refused in a few words; tables of numbers in them.

Stands on the ground floor: scenes, their tables, studies and what is kept on disk are read here. Columns of numbers
have comma, tab, semicolon or blanks between them, as the header has; # begins a comment. Numbers are written with ASCII
digits and without marks of thousands; their decimal sign is a key of whoever names the file, since
1,5 and 1.500 are not the same number everywhere. Heights of a surface stand in columns angle_deg and height_um.
"""

import csv
import errno
import hashlib
import os
import re
import stat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from lagrange.files.private import check_private

ROOM = 2**16  # bytes, of files whose size the system does not know
FOREIGN = {  # first bytes of files that are no text: what they are, and how to make a table of them
    b"PK\x03\x04": "an Excel workbook or an archive; save the sheet as CSV UTF-8",
    b"\xd0\xcf\x11\xe0": "an Excel workbook; save the sheet as CSV UTF-8",
    b"PAR1": 'a Parquet file; pandas.read_parquet(file).to_csv("table.csv", index=False) makes a table of it',
    b"MATLAB": 'a MATLAB file; writetable(T, "table.csv") in MATLAB makes a table of it',
    b"\x1f\x8b": "compressed; unpack it by gunzip",
    b"\xff\xfe": "UTF-16 text; save it as UTF-8",
    b"\xfe\xff": "UTF-16 text; save it as UTF-8",
}


def not_text(data: bytes, at: int) -> str:
    """Why bytes that begin so are not UTF-8, and what to do; `at`: the first that can't be read."""
    what = next((what for start, what in FOREIGN.items() if data.startswith(start)), None)
    return f"not UTF-8 text (byte {at}): {what or 'save it as UTF-8, if it is text in Latin-1 or another code'}"


def read_plain(path: str | Path, most: int = -1, private: bool = False) -> bytes:
    """The first `most` bytes of a plain file, or all.

    Errors
    ------
    OSError: it can't be read, or is no plain file: a pipe would be waited for, a device may never end; of a private one
    also that others own it or can write it. ValueError: its name holds a null character.
    """
    with open(path, "rb", opener=_without_waiting) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "a pipe or a device, not a plain file", str(path))
        if private:
            check_private(path, about)
        return file.read(min(most, max(about.st_size + 1, ROOM)))  # room for all that is asked for is made beforehand


def plain_text(path: str | Path, most: int) -> str:
    """The text of a plain file of at most `most` bytes, UTF-8 with or without a mark.

    Errors
    ------
    ValueError, what is wrong, without the file's name: it can't be read, is too large, or not UTF-8.
    """
    try:
        data = read_plain(path, most + 1)
    except (OSError, ValueError) as error:
        raise ValueError(f"can't be read: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > most:
        raise ValueError(f"larger than {most // 2**20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(not_text(data, error.start)) from None


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


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


def header_of(text: str) -> list[str]:
    """The names of a table's text; none: it holds no line. ValueError: quotation marks that do not close."""
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    return names_of(first, delimiter_of(first)) if first else []


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


ANGLE, HEIGHT = "angle_deg", "height_um"
FEWEST_POINTS = 16
FULL_TURN = 360.0
AGAIN = 1e-6  # degrees, µm: two values that are the same
LARGEST_GAP = 3.0  # times the usual distance of two angles


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightTable:
    """Heights around one turn; arrays (n_points,)."""

    angle: np.ndarray  # rad, rising, less than a turn from first to last
    height: np.ndarray  # m, positive where material is added


@lru_cache(maxsize=16)
def height_table(text: str, decimal: str = ".") -> HeightTable:
    """The heights of a table's text with this decimal sign.

    Errors
    ------
    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too few or too many points,
    angles that do not rise, more than a turn, a gap, also at the seam, or two heights there.
    """
    angle, height = _columns(text, decimal)
    if not FEWEST_POINTS <= len(angle) <= MOST_ROWS:
        raise ValueError(f"it holds {len(angle)} points; at least {FEWEST_POINTS} and at most {MOST_ROWS} are taken")
    steps = np.diff(angle)
    if np.any(steps <= 0.0):
        at = int(np.argmax(steps <= 0.0))
        raise ValueError(f"{ANGLE} must rise from row to row: after {angle[at]:g} comes {angle[at + 1]:g}")
    seam = FULL_TURN - (angle[-1] - angle[0])
    if abs(seam) <= AGAIN:
        if abs(height[-1] - height[0]) > AGAIN:
            raise ValueError(
                f"it does not close: {HEIGHT} is {height[0]:g} at {angle[0]:g} degrees and {height[-1]:g} a turn on"
            )
        angle, height, steps = angle[:-1], height[:-1], steps[:-1]
        seam = FULL_TURN - (angle[-1] - angle[0])
    if seam <= 0.0:
        raise ValueError(f"{ANGLE} goes from {angle[0]:g} to {angle[-1]:g}, more than a turn")
    gaps, usual = np.append(steps, seam), float(np.median(steps))
    if gaps.max() > LARGEST_GAP * usual:
        at = int(gaps.argmax())
        where = "at the seam, " if at == len(steps) else ""
        raise ValueError(
            f"a gap of {gaps[at]:.4g} degrees {where}after {angle[at]:g}, where points are usually {usual:.4g} apart "
            f"(at most {LARGEST_GAP:g} times that)"
        )
    return HeightTable(angle=np.radians(angle), height=1e-6 * height)


def _columns(text: str, decimal: str) -> tuple[np.ndarray, np.ndarray]:
    """Degrees and µm, as they stand there."""
    found = columns(text, (ANGLE, HEIGHT), decimal)
    if not np.all(np.isfinite(found)) or np.any(np.abs(found[:, 0]) > 10.0 * FULL_TURN):
        raise ValueError(f"a value is not finite, or no {ANGLE} of a turn")
    return found[:, 0], found[:, 1]

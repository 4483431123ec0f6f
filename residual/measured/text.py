"""Records in text: delimiter, decimal sign, header, units and encoding are found by looking at the rows."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isnan

import numpy as np

from lagrange.files.input import FOREIGN, not_text

FORMS = (("\t", "."), ("\t", ","), (";", ","), (";", "."), (",", "."), (None, "."), (None, ","))  # delimiter, decimal
SAMPLED = 40  # rows that the form is found by
MOST_BEFORE = 200  # lines before the first row of numbers
LONGEST_LINE = 100_000  # characters
MISSING = {"", "nan", "-nan", "null", "none", "n/a", "na", "-"}  # cells that hold no number
UNIT = re.compile(
    r"|[\[(].*[\])]|-|1|m?g|s|sec|[mµun]s|m?V|m?m/s(?:\^?2|²)?|°?C|rpm|Hz|N", re.IGNORECASE
)  # a cell below names
_NUMBER = r"(?P<number>\d+(?:[.,]\d+)?)"
RATES = tuple(  # "Sampling rate: 25.6 kHz", "Abtastrate;25600 Hz"; "Sampling frequency (Hz),25600"; "fs = 25600"
    re.compile(form, re.IGNORECASE)
    for form in (
        rf"(?:rate|freq\w*|fs|sampl\w*)\b[^\d\n]{{0,30}}?{_NUMBER}\s*(?P<kilo>k?)Hz",
        rf"(?:rate|freq\w*|fs)\s*[\[(]?(?P<kilo>k?)Hz[\])]?\W{{0,10}}{_NUMBER}\W*$",
        rf"\b(?P<kilo>)(?:fs|sampl\w*[\s_]*(?:rate|freq\w*)|abtastrate)\W{{1,10}}{_NUMBER}\W*$",
    )
)
OTHER = re.compile(
    r"(?:shaft|rotation\w*|dreh|mains|filter|(?:cut)?-?off|resonan\w*)[\s_]*$", re.IGNORECASE
)  # frequency
DATED = re.compile(r"\d{4}-\d\d-\d\d|\d{1,2}[./]\d{1,2}[./]\d{4}|\d{1,2}:\d\d:\d\d")


@dataclass(kw_only=True)
class Channels:
    """Signals of one length by name, their units as written, the rate, Hz, where the file states it."""

    values: dict[str, np.ndarray]  # (n_times,) each, floating point
    units: dict[str, str] = field(default_factory=dict)
    rate: float | None = None
    notes: list[str] = field(default_factory=list)


def decoded(data: bytes) -> str:
    """The text of a file in UTF-8, UTF-16 with a mark, or else Windows-1252. ValueError: it is no text."""
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            try:
                return data.decode(encoding)
            except UnicodeDecodeError as error:
                raise ValueError(f"begins as {encoding} but is not (byte {error.start}); save it as UTF-8") from None
    kinds = [start for start in FOREIGN if data.startswith(start)]
    if kinds or b"\0" in data[:4096]:
        raise ValueError(not_text(data, 0))
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def text_channels(data: bytes) -> Channels:
    """Columns of a text's numbers.

    Errors
    ------
    ValueError, a sentence on the text: no rows of numbers, rows of another width, a cell that is no number.
    """
    lines = [line for line in decoded(data).splitlines() if line.strip(" \t\r\x1a")]
    if any(len(line) > LONGEST_LINE for line in lines):
        raise ValueError(f"a line of more than {LONGEST_LINE} characters; a record has one sample in each line")
    first, delimiter, decimal = _form(lines)
    before = [line.lstrip("#% ") for line in lines[:first]]
    rows = [line for line in lines[first:] if line[0] not in "#%"]
    values = _numbers(rows, delimiter, decimal, first)
    names, units = _heads(before, delimiter, values.shape[1])
    rate = next((rate for line in before if (rate := _stated_rate(line))), None)
    return Channels(values={name: values[:, k] for k, name in enumerate(names)}, units=units, rate=rate)


def _stated_rate(line: str) -> float | None:
    """The sampling rate that a line before the numbers states, Hz."""
    for form in RATES:
        if (said := form.search(line)) is not None and not OTHER.search(line[: said.start()]):
            return float(said["number"].replace(",", ".")) * (1e3 if said["kilo"] else 1.0)
    return None


def _form(lines: Sequence[str]) -> tuple[int, str | None, str]:
    """Number of the first row of numbers, the delimiter (None: blanks) and the decimal sign."""
    best: tuple[int, int, str | None, str] | None = None
    for delimiter, decimal in FORMS:
        for first in range(min(len(lines), MOST_BEFORE)):
            width = _width(lines[first], delimiter, decimal)
            if width == 0:
                continue
            sample = lines[first : first + SAMPLED]
            if all(_width(line, delimiter, decimal) in (0, width) for line in sample):
                widths = [_width(line, delimiter, decimal) for line in sample]
                if widths.count(width) >= 0.8 * len(sample) and (best is None or width > best[0]):
                    best = width, first, delimiter, decimal
                break
    if best is None:
        dated = DATED.search("\n".join(lines[:MOST_BEFORE]))
        raise ValueError(
            "no rows of numbers in it; a record has one sample in each line, in columns"
            + (f"; dates and clock times ({dated[0]}) are none: leave that column out and give --rate" if dated else "")
        )
    width, first, delimiter, decimal = best
    heads = lines[first - 1] if first else ""
    shown = lines[first : first + SAMPLED]
    one_comma = delimiter == "," and width == 2 and all("." not in x and x.count(",") == 1 for x in shown)
    if one_comma and "," not in heads:  # 0,123 below a header of one name, or none
        return first, None, ","
    return first, delimiter, decimal


def _cells(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    cells = next(csv.reader([line], delimiter=delimiter), []) if '"' in line else line.split(delimiter)
    cells = [cell.strip() for cell in cells]
    return cells[:-1] if cells and not cells[-1] else cells


def _number(cell: str, decimal: str) -> float | None:
    """The number of a cell, nan where it holds none; None: something else."""
    if cell.lower() in MISSING:
        return float("nan")
    if not cell.isascii() or "_" in cell or (decimal == "," and "." in cell):
        return None
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def _width(line: str, delimiter: str | None, decimal: str) -> int:
    """How many cells a row of numbers has; 0: it is none."""
    numbers = [_number(cell, decimal) for cell in _cells(line, delimiter)]
    if not numbers or None in numbers or all(isnan(x) for x in numbers if x is not None):
        return 0
    return len(numbers)


def _numbers(rows: list[str], delimiter: str | None, decimal: str, before: int) -> np.ndarray:
    """Numbers of rows, (n_rows, n_columns), nan where a cell is empty."""
    try:
        plain = rows if decimal == "." else [row.replace(",", ".") for row in rows]
        return np.loadtxt(plain, delimiter=delimiter, ndmin=2, comments=None)
    except ValueError:
        pass  # row by row, for cells that are empty or quoted, and to say which can't be read
    width, found = 0, []
    for number, row in enumerate(rows, 1 + before):
        cells = _cells(row, delimiter)
        numbers = [_number(cell, decimal) for cell in cells]
        if None in numbers:
            cell = cells[numbers.index(None)][:40]
            raise ValueError(f"line {number}: {cell!r} is no number; decimal sign {decimal!r} by the rows before")
        width = width or len(numbers)
        numbers += [float("nan")] * (width - len(numbers))
        if len(numbers) > width:
            raise ValueError(f"line {number} has {len(numbers)} cells, those before {width}")
        found.append(numbers)
    return np.array(found, dtype=float).reshape(-1, width)


def _heads(before: list[str], delimiter: str | None, width: int) -> tuple[list[str], dict[str, str]]:
    """Names and units of columns from the lines before them; numbers where there are none."""
    fitting = [cells for cells in (_cells(line, delimiter) for line in before[-4:]) if len(cells) == width]
    below = fitting.pop() if len(fitting) > 1 and all(UNIT.fullmatch(cell) for cell in fitting[-1]) else []
    names = fitting[-1] if fitting else [""] * width
    names = [name or f"column {k}" for k, name in enumerate(names, 1)]
    names = [f"{name} ({k + 1})" if name in names[:k] else name for k, name in enumerate(names)]
    units = {name: unit.strip("[]()") for name, unit in zip(names, below, strict=False)}
    return names, units

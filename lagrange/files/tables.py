"""The one reader of tables of numbers in text: columns by name, rows at fault in a sentence; all sizes are limited.

`TextTable.sniffed` is for records: it finds the first row of numbers, the delimiter, the decimal sign, names and units.
`TextTable.named` is for tables whose columns are asked for by name: the first line is the header and has the delimiter
(comma, tab, semicolon or blanks), # begins a comment, and the decimal sign is a key of whoever names the file, since
1,5 and 1.500 are not the same number everywhere. Numbers have ASCII digits and no marks of thousands.
"""

# fmt: off
import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrange.errors import exceeds
from lagrange.files.input import FOREIGN, not_text
from lagrange.messages import shown

LARGEST_TEXT = 1 << 28  # bytes
MOST_NUMBERS = 1 << 25
MOST_COLUMNS = 4096
LONGEST_LINE, LONGEST_NAME, LONGEST_QUOTE = 100_000, 200, 40  # characters: of a line, a name, a cell in a message
MOST_ROWS = 50_000  # of a table that a scene names
PART = 1 << 20  # characters read at once
MOST_BEFORE = 200  # lines before the header, or before the first row of numbers
HEAD, SAMPLED = 1 << 18, 40  # characters and rows that the form of a record is found by
FORMS = (("\t", "."), ("\t", ","), (";", ","), (";", "."), (",", "."), (None, "."), (None, ","))  # delimiter, decimal
ERRORS = ("#n/a", "#nv", "#null!", "#div/0!", "#value!", "#wert!", "#ref!", "#bezug!", "#name?", "#num!", "#zahl!")
MISSING = frozenset(["", "nan", "-nan", "null", "none", "n/a", "na", "-", *ERRORS])  # cells that hold no number
UNIT = re.compile(  # a cell below names
    r"|[\[(].*[\])]|-|1|m?g|s|sec|[mµun]s|m?V|m?m/s(?:\^?2|²)?|°?C|rpm|Hz|N", re.IGNORECASE)
DATED = re.compile(r"\d{4}-\d\d-\d\d|\d{1,2}[./]\d{1,2}[./]\d{4}|\d{1,2}:\d\d:\d\d")
GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")  # 1.234 where it may be 1234
FEWEST_GROUPED = 8  # cells that tell marks of thousands from decimal signs


def decoded(data: bytes) -> str:
    """A text in UTF-8, UTF-16 with a mark, or else Windows-1252. ValueError: it is none, or too large."""
    if len(data) > LARGEST_TEXT:
        raise ValueError(f"a text of more than {LARGEST_TEXT >> 20} MiB; cut a part of it")
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            try:
                return data.decode(encoding)
            except UnicodeDecodeError as error:
                raise ValueError(f"begins as {encoding} but is not (byte {error.start}); save it as UTF-8") from None
    if any(map(data.startswith, FOREIGN)) or b"\0" in data[:4096]:
        raise ValueError(not_text(data, 0))
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


@dataclass(frozen=True, kw_only=True)
class TextTable:
    """A text's names of columns, and its numbers on demand."""

    text: str
    names: list[str]  # of columns; none: an empty text
    delimiter: str | None  # None: blanks
    decimal: str
    start: int  # of the rows in the text
    line: int  # number of the first of them
    keyed: bool  # named: the decimal sign is a key; comments and blank lines are no rows, each row holds all numbers
    before: list[str] = field(default_factory=list)  # sniffed: lines before the rows, without marks of comments
    units: dict[str, str] = field(default_factory=dict)  # sniffed: by name

    @classmethod
    def named(cls, text: str, decimal: str = ".") -> "TextTable":
        """The table whose header is its first line. ValueError: quotation marks that do not close, too many columns."""
        text = _with_line_feeds(text)
        found = re.search(r"^(?!#).*\S", text, re.MULTILINE)
        first = found.start() if found else len(text)
        start = text.find("\n", first) + 1 or len(text)
        names, delimiter = _names(text[first:start])
        line = 1 + text.count("\n", 0, start)
        return cls(text=text, names=names, delimiter=delimiter, decimal=decimal, start=start, line=line, keyed=True)

    @classmethod
    def sniffed(cls, text: str) -> "TextTable":
        """The table of which nothing is known. ValueError: no rows of numbers; marks of thousands or decimal signs?"""
        text = _with_line_feeds(text)
        head = text[: text.find("\n", HEAD) + 1 or len(text)].split("\n")
        lines = {number: line for number, line in enumerate(head) if line.strip(" \t")}
        _check_lengths(head)
        first, delimiter, decimal = _form(list(lines.values()))
        before = [line.lstrip("#% ") for line in list(lines.values())[:first]]
        rows = [_cells(line, delimiter) for line in list(lines.values())[first:]]
        for cells in zip(*(row for row in rows if len(row) == len(rows[0])), strict=True):
            # marks before groups of three digits beside whole numbers below 1000, as of thousands
            marked = [cell for cell in cells if decimal in cell]
            bare = [cell for cell in cells if re.fullmatch(r"[-+]?[1-9]\d{0,2}", cell)]
            if bare and len(marked) >= FEWEST_GROUPED and all(map(GROUPED.fullmatch, marked)):
                raise ValueError(f"{marked[0]} beside {bare[0]} may be {marked[0].replace(decimal, '')} with a mark of "
                    "thousands; write numbers without such marks, or all with the same number of decimals")
        names, units = _heads(before, delimiter, len(rows[0]))
        number = list(lines)[first]
        return cls(text=text, names=names, delimiter=delimiter, decimal=decimal, line=number + 1, keyed=False,
            start=sum(len(line) + 1 for line in head[:number]), before=before, units=units)

    def header_below(self, names: Sequence[str]) -> str:
        """What to do where a later line is the header; empty: none is."""
        lines = [x for x in self.text[:PART].split("\n") if x.strip() and not x.startswith("#")]
        for before, line in enumerate(lines[:MOST_BEFORE]):
            if before and set(names) <= set(_names(line)[0]):
                return f": the header comes after {before} other lines; begin those with #, or delete them"
        return ""

    def numbers(self, wanted: Sequence[int] | None = None) -> np.ndarray:
        """Columns, (n_rows, n_wanted); of a sniffed table each line is a row, nan where it holds no number.

        ValueError, a sentence: the line at fault and what to do; too many numbers, too long a line.
        """
        if self.delimiter == self.decimal:
            raise ValueError('decimal = ",", but commas are between its columns, too; write semicolons or tabs there')
        wanted = range(len(self.names)) if wanted is None else wanted
        if (self.text.count("\n", self.start) + 1) * len(self.names) > MOST_NUMBERS:
            raise ValueError(f"more than {MOST_NUMBERS:,} numbers; cut it into parts".replace(",", " "))
        found, at, number = [np.empty((0, len(wanted)))], self.start, self.line
        while at < len(self.text):
            end = self.text.find("\n", at + PART) + 1 or len(self.text)
            lines = self.text[at:end].removesuffix("\n").split("\n")
            _check_lengths(lines)
            rows = {k: "" if _is_note(line, self.keyed) else line for k, line in enumerate(lines, number)}
            if self.keyed:
                rows = {k: line for k, line in rows.items() if line.strip()}
            part = self._loaded(list(rows.values()), wanted)
            if part is None:
                part = np.array([self._row(k, line, wanted) for k, line in rows.items()], dtype=float)
            found.append(part)
            at, number = end, number + len(lines)
        return np.concatenate(found)

    def _loaded(self, rows, wanted):
        """Numbers of rows as they stand; None: one has other cells than there are names, or can't be read."""
        if not rows:
            return np.empty((0, len(wanted)))
        between, mark = len(self.names) - 1, self.delimiter
        widths = (len(row.split()) - 1 if mark is None else row.count(mark) for row in rows)
        if not all(rows) or any(width != between for width in widths):
            return None
        if self.decimal == ",":
            rows = [row.replace(".", "?").replace(",", ".") for row in rows]
        try:
            return np.loadtxt(rows, delimiter=mark, usecols=wanted, ndmin=2, comments=None)
        except ValueError:
            return None

    def _row(self, number, line, wanted):
        cells, width = _cells(line, self.delimiter), len(self.names)
        too_few = len(cells) <= max(wanted) or (self.delimiter is None and len(cells) < width)
        if any(cells[width:]) or (self.keyed and too_few):
            hint = '; where commas are decimal, write semicolons or tabs between columns and give decimal = ","'
            is_hint = self.keyed and len(cells) > width and self.delimiter == ","
            raise ValueError(f"line {number}: {len(cells)} cells under {width} names{hint if is_hint else ''}")
        cells += [""] * (width - len(cells))
        values = [_number(cells[k], self.decimal, not self.keyed) for k in wanted]
        if None not in values:
            return [value for value in values if value is not None]
        words = all(re.search(r"[^\W\d]|[%°]", cells[k]) for k in wanted)
        if self.keyed and len(values) > 1 and set(values) == {None} and words and not line.startswith("#"):
            raise ValueError(f"line {number}: no numbers in it; a line of units is none of the table's rows: delete "
                "it, or begin it with #")
        at = wanted[values.index(None)]
        cell, name = cells[at], shown(self.names[at][:LONGEST_QUOTE])
        remedy = "; write digits 0 to 9 without marks between thousands"
        if self.keyed and self.decimal == "." and _number(cell, ",", False) is not None:
            remedy = '; give decimal = "," if commas are decimal signs'
        elif self.decimal == "," and "." in cell:
            remedy = '; with decimal = "," no point may stand in it' if self.keyed else "; its decimal sign is a comma"
        quoted = cell if len(cell) <= LONGEST_QUOTE else f"{cell[:LONGEST_QUOTE]}…"
        raise ValueError(f"line {number}: {name} = {quoted!r} is no number{remedy}")


def columns(
    text: str, names: Sequence[str], decimal: str = ".", units: Mapping[str, Mapping[str, float]] | None = None
) -> np.ndarray:
    """Columns of a named table, (n_rows, n_names), in the units of `names`; others are left out.

    `units` : by name, as time_ms, the units that a header may have in its place and their size, as in "time_s" or
    "time [s]"; those without stand as they are named. ValueError, a sentence on the text: columns missing or twice, an
    unknown unit, a line at fault.
    """
    table = TextTable.named(text, decimal)
    written = [_in_units(name, table.names, (units or {}).get(name, {})) for name in names]
    headers = [header for header, _ in written]
    for name in headers:
        if table.names.count(name) != 1:
            what = "missing" if name not in table.names else "there twice"
            listed = f"{', '.join(headers[:-1])} and {headers[-1]}"
            raise ValueError(f"column {name} is {what}; its first line must name {listed}{table.header_below(headers)}")
    found = table.numbers([table.names.index(name) for name in headers])
    if len(found) > MOST_ROWS:
        raise ValueError(f"more than {MOST_ROWS} rows")
    return found * [factor for _, factor in written]


def rising(
    text: str, names: Sequence[str], decimal: str, fewest: int, most: int = MOST_ROWS, step: float = 0.0,
    units: Mapping[str, Mapping[str, float]] | None = None
) -> np.ndarray:
    """`columns` of finite numbers, the first of which rise from row to row, by a step at least where one is given."""
    found = columns(text, names, decimal, units)
    if not fewest <= len(found) <= most:
        limit = f"at least {fewest} are needed" if len(found) < fewest else f"at most {most} are allowed"
        raise ValueError(f"it holds {len(found)} rows; {limit}")
    if not (sound := np.isfinite(found).all(axis=1)).all():
        raise ValueError(f"row {1 + int(np.argmin(sound))} holds a value that is not finite")
    steps = np.diff(found[:, 0])
    if (short := exceeds(step, steps) | (steps <= 0.0)).any():
        (before, after), by = found[np.argmax(short) :, 0][:2], f"by at least {step:g} " if step else ""
        raise ValueError(f"{names[0]} must rise {by}from row to row: after {before:g} comes {after:g}")
    return found


def _in_units(name, headers, units):
    """How a header names a column, and the factor to its own unit. ValueError: twice, or in an unknown unit."""
    bare = name.partition("_")[0]
    found = {header: units[unit] for header in headers for unit in units if re.fullmatch(
        rf"{bare}[\s_]*[\[(]?({re.escape(unit)}|{re.escape(unit.replace('/', '_'))})[\])]?", header)}
    if len(found) > 1:
        raise ValueError(f"columns {' and '.join(found)} say the same thing; leave all but one out")
    strange = [header for header in headers if units and re.fullmatch(rf"{bare}(\s*[\[(].*|_.*)?", header)]
    if not found and strange and name not in headers:
        raise ValueError(f"column {strange[0]}: its unit must be one of {', '.join(units)}, as in {name}")
    return next(iter(found.items()), (name, 1.0))


def _with_line_feeds(text):
    """A text whose lines end by one line feed, without what is blank at its end."""
    if "\r" in text:
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    return text.rstrip(" \t\n\x1a")


def _check_lengths(lines):
    if max(map(len, lines), default=0) > LONGEST_LINE:
        raise ValueError(f"a line of more than {LONGEST_LINE} characters; a table has one row in each line")


def _is_note(line, keyed=False):
    return line.startswith("#" if keyed else ("#", "%")) and not line.lower().startswith(ERRORS)


def _names(header):
    """Names and the delimiter of a header; between blanks a unit in brackets belongs to the name before it."""
    _check_lengths([header])
    delimiter = next((character for character in "\t;," if character in header), None)
    found = _cells(header, delimiter) if delimiter else re.findall(r"[^\s\[]+(?:\s*\[[^\]\[]*\])?", header)
    if len(found) > MOST_COLUMNS:
        raise ValueError(f"more than {MOST_COLUMNS} columns")
    return found, delimiter


def _cells(line, delimiter):
    """Cells of a line, without blanks about them; an empty one at its end is none."""
    if delimiter is None:
        return line.split()
    cells = next(csv.reader([line], delimiter=delimiter), []) if '"' in line else line.split(delimiter)
    cells = [cell.strip() for cell in cells]
    return cells[:-1] if cells and not cells[-1] else cells


def _number(cell, decimal, may_miss):
    """The number of a cell, nan where it may hold none; None: something else."""
    if may_miss and cell.lower() in MISSING:
        return float("nan")
    if not cell.isascii() or "_" in cell or (decimal == "," and "." in cell):
        return None
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def _form(lines):
    """Number of the first row of numbers, the delimiter (None: blanks) and the decimal sign."""
    forms = []
    for delimiter, decimal in FORMS:
        widths = [_width(line, delimiter, decimal) for line in lines[: MOST_BEFORE + SAMPLED]]
        for first, width in enumerate(widths[:MOST_BEFORE]):
            sample = widths[first : first + SAMPLED]
            if width and set(sample) <= {None, 0, width}:
                if sample.count(width) >= 0.8 * (len(sample) - sample.count(None)):
                    forms.append((width, first, delimiter, decimal))
                break
    if not forms:
        dated = DATED.search("\n".join(lines[:MOST_BEFORE]))
        marked = next((x for x in lines[:MOST_BEFORE] if re.search(r"\d[.]\d{3},\d|\d,\d{3}[.]\d", x)), None)
        raise ValueError("no rows of numbers in it; a record has one sample in each line, in columns"
            + (f"; dates and clock times ({dated[0]}) are none: leave that column out and give --rate" if dated else "")
            + (f"; write numbers without marks of thousands ({marked.strip()[:LONGEST_QUOTE]!r})" if marked else ""))
    width, first, delimiter, decimal = max(forms, key=lambda form: form[0])
    if delimiter == "," and width == 2 and (first == 0 or "," not in lines[first - 1]):
        if all("." not in row and row.count(",") == 1 for row in lines[first : first + SAMPLED]):
            return first, None, ","  # 0,123 below a header of one name, or none
    return first, delimiter, decimal


def _width(line, delimiter, decimal):
    """How many cells a row of numbers has; 0: it is none; None: a note, or all its numbers are missing."""
    cells = _cells(line, delimiter)
    if len(cells) > MOST_COLUMNS:
        return 0
    if _is_note(line):
        return None
    values = [_number(cell, decimal, True) for cell in cells]
    if None in values:
        return 0
    return len(cells) if any(value == value for value in values) else None


def _heads(before, delimiter, width):
    """Names and units of columns from the lines before them; numbers where there are none."""
    fitting = [cells for cells in (_cells(line, delimiter) for line in before[-4:]) if len(cells) == width]
    fitting = [cells for cells in fitting if not all(cell.lower() in MISSING for cell in cells)]  # a first row
    below = fitting.pop() if len(fitting) > 1 and all(map(UNIT.fullmatch, fitting[-1])) else []
    names = fitting[-1] if fitting else [""] * width
    names = [name[:LONGEST_NAME] or f"column {k}" for k, name in enumerate(names, 1)]
    names = [f"{name} ({k + 1})" if name in names[:k] else name for k, name in enumerate(names)]
    return names, {name: unit.strip("[]()") for name, unit in zip(names, below, strict=False)}

"""Reader of trajectory tables (CSV, TSV, semicolons): other people's data."""

import csv
import warnings
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from lagrange.files.input import MOST_BEFORE, check_decimal, delimiter_of, header_below, names_of, not_text, row_fault
from lagrange.messages import shown
from lagrange.scene.columns import Columns, per_roller
from lagrange.scene.scene import Scene
from residual.errors import InputError
from residual.orders import even_clock, evenly_sampled
from residual.record import Record, checked, relative
from residual.sources import LARGEST_READ, OPTIONAL, check_readable

LONGEST_LINE = 2**20  # characters
LONGEST_QUOTE = 200  # characters of a message
MOTION = ("time", "inner_x", "inner_y")
CARTESIAN, POLAR = ("roller_x", "roller_y"), ("roller_rho", "roller_theta")


@np.errstate(over="ignore", invalid="ignore")  # what overflows is not finite, and refused as such
def read_table(path: str | Path, scene: Scene, resample: bool = False) -> Record:
    """Read a trajectory table with one header line.

    Parameters
    ----------
    scene : its [table] gives names and units; without one: time, inner_x, inner_y and roller_<j>_x,
        roller_<j>_y or roller_<j>_rho, roller_<j>_theta, j from 0, in SI; accelerations and contact forces where it has
        them
    resample : bring irregular samples to equal steps instead of refusing them

    Columns may stand in any order; others are left out. Lines starting with # are comments. The delimiter (comma, tab,
    semicolon or blanks) is taken from the header. Rounded time stamps of an even clock become that clock's times.

    Errors
    ------
    InputError: no such file, not text, columns missing or twice, a number of rollers other than the scene's, a row
    that can't be read, more than fits in memory, and all that `checked` refuses.
    """
    path = Path(path)
    check_readable(path)
    return _record(path, scene, _read_columns(path, scene), resample)


def _read_columns(path: Path, scene: Scene) -> dict[str, np.ndarray]:
    """Read every quantity that the table has, SI."""
    columns = scene.table
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = (line for line in _lines(path, file) if line.strip() and not line.startswith("#"))
            first = next(lines, "")
            delimiter = delimiter_of(first)
            header = names_of(first, delimiter)
            try:
                found = _columns_found(path, header, scene)
            except InputError as error:
                names = [columns.header(quantity)[0][0] for quantity in MOTION[:2]]
                head = [first, *islice(lines, MOST_BEFORE)]
                raise InputError(f"{error}{header_below(head, names)}") from None
            check_decimal(delimiter, columns.decimal)
            order = [index for indices, _ in found.values() for index in indices]
            rows = _Rows(lines, header, order, delimiter, columns.decimal)
            lines = _at_most(path, rows.checked(), LARGEST_READ // (8 * len(order)))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of an empty table, which is refused for want of samples
                try:
                    table = np.loadtxt(lines, delimiter=delimiter, usecols=order, ndmin=2)
                except ValueError as error:
                    raise ValueError(rows.fault() or str(error)) from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: neither an HDF5 result file nor a text table: {not_text(b'', error.start)}"
        ) from None
    except InputError:
        raise
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path}: a row can't be read: {_shown(str(error))}") from None
    arrays, start = {}, 0
    for quantity, (indices, factor) in found.items():
        values = factor * table[:, start : start + len(indices)]
        arrays[quantity] = values if per_roller(quantity) else values[:, 0]
        start += len(indices)
    return arrays


class _Rows:
    """Rows on their way to be read, of as many cells as the header has names; the last one is known."""

    def __init__(
        self, lines: Iterable[str], header: list[str], order: list[int], delimiter: str | None, decimal: str
    ) -> None:
        self._lines, self._header, self._order = lines, header, order
        self._delimiter, self._decimal = delimiter, decimal
        self._number, self._line = 0, ""

    def checked(self) -> Iterator[str]:
        """Yield them with decimal points. ValueError: more or fewer cells."""
        points = str.maketrans({",": ".", ".": "?"}) if self._decimal == "," else None
        n_names = len(self._header)
        for number, line in enumerate(self._lines, 1):
            self._number, self._line = number, line
            cells = line.count(self._delimiter) + 1 if self._delimiter else len(line.split())
            if cells != n_names and (fault := self.fault()):
                raise ValueError(fault)
            yield line if points is None else line.translate(points)

    def fault(self) -> str | None:
        """Why the last row can't be read; None: it can."""
        cells = self._line.rstrip("\r\n").split(self._delimiter)
        reason = row_fault(cells, self._header, self._order, self._delimiter, self._decimal)
        return reason and f"row {self._number} below the header: {reason}"


def _lines(path: Path, file):
    """Yield the lines of a text; refuse one so long that it can't be a table's."""
    while line := file.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise InputError(f"{path}: a line of more than {LONGEST_LINE} characters; is it a table?")
        yield line


def _at_most(path: Path, lines, most: int):
    """Yield lines, but no more rows than fit in memory."""
    for count, line in enumerate(lines):
        if count >= most:
            raise InputError(f"{path}: more than {most} samples, {LARGEST_READ / 2**30:.0f} GiB; cut it into parts")
        yield line


def _shown(text: str) -> str:
    """Make the first line of a message fit to be printed."""
    line = (text.splitlines() or [""])[0]
    return "".join(c if c.isprintable() else "?" for c in line[:LONGEST_QUOTE])


def _record(path: Path, scene: Scene, arrays: dict[str, np.ndarray], resample: bool) -> Record:
    """Make the record: Cartesian, evenly sampled, checked, with notes on what the table lacks."""
    notes: list[str] = []
    centre = scene.mounting().centre
    if "roller_rho" in arrays:
        rho, theta = arrays.pop("roller_rho"), np.unwrap(arrays.pop("roller_theta"), axis=0)
        arrays["roller_x"], arrays["roller_y"] = rho * np.cos(theta), rho * np.sin(theta)
        for axis, place in zip("xy", centre, strict=False):  # polar coordinates are about the outer ring's centre
            arrays[f"roller_{axis}"] += arrays[place][:, None]
    if (clock := even_clock(arrays["time"])) is not None:
        arrays["time"] = clock[0]
        notes.append(clock[1])
    if resample:
        arrays, note = evenly_sampled(path, arrays)
        notes += [note] if note else []
    if "inner_force" not in arrays:
        notes.append("the table tells no contact forces: the error is not split into its terms, no law can be fitted")
    else:
        if "inner_ax" not in arrays or "inner_ay" not in arrays:
            notes.append("the table tells no accelerations of its own: the budget has no differentiation term")
        if "inner_traction" not in arrays:
            notes.append("the table tells no tangential forces: the budget has no friction term")
    columns: dict[str, Any] = relative(arrays, centre)  # fields of a record by their names
    return checked(Record(name=shown(path.stem), source=path, scene=scene, notes=tuple(notes), **columns))


def _columns_found(path: Path, header: list[str], scene: Scene) -> dict[str, tuple[list[int], float]]:
    """Find column numbers and factor to SI of each quantity that the table has."""
    columns, n_rollers = scene.table, scene.bearing.rollers
    centre = scene.mounting().centre
    polar_only = not _at(path, header, columns, "roller_x", n_rollers)[0] and bool(
        _at(path, header, columns, "roller_rho", n_rollers)[0]
    )
    wanted = [*MOTION, *(POLAR if polar_only else CARTESIAN), *centre[:2]]
    found, missing = {}, []
    for quantity in (*wanted, *OPTIONAL, *centre[2:]):
        indices, factor, absent = _at(path, header, columns, quantity, n_rollers)
        if quantity in wanted or indices:
            missing += absent
        if indices:
            found[quantity] = indices, factor
    if not {"time", "inner_x"} & set(found):
        raise InputError(
            f"{path}: neither an HDF5 result file nor a trajectory table: missing column {', '.join(missing[:2])}; "
            f"its first line: {_shown(', '.join(header)) or 'empty'}; other names and units: [table] in the scene file"
        )
    roller = POLAR[0] if polar_only else CARTESIAN[0]
    _check_count(path, header, columns, roller, n_rollers)
    if missing:
        more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
        if "inner_x" not in found and {"inner_ax", "inner_ay"} & set(found):
            more += " (accelerations alone do not do: the check needs positions of hub and rollers)"
        elif not {*CARTESIAN, *POLAR} & set(found):
            more += " (the hub's orbit alone does not do: contact forces follow from the rollers' positions)"
        raise InputError(
            f"{path}: missing column {', '.join(missing[:4])}{more}; where it has another name, [table] in the scene "
            "file tells it"
        )
    return found


def _check_count(path: Path, header, columns: Columns, quantity: str, n_rollers: int) -> None:
    """Refuse a table of fewer or more rollers than the scene has; one that lacks a roller in between lacks a column."""
    there = [any(name in header for name in columns.header(quantity, j)[0]) for j in range(n_rollers + 1)]
    count = there.index(False) if False in there else n_rollers + 1
    if (0 < count < n_rollers and not any(there[count:])) or there[n_rollers]:
        told = f"at least {n_rollers + 1}" if there[n_rollers] else count
        raise InputError(f"{path}: the table holds {told} rollers, the scene says {n_rollers}")


def _at(path: Path, header: list[str], columns: Columns, quantity: str, n_rollers: int):
    """Look for a quantity's columns: numbers of those found, factor to SI, names of those missing."""
    indices, absent, factor = [], [], 1.0
    for roller in range(n_rollers) if per_roller(quantity) else (None,):
        names, factor = columns.header(quantity, roller)
        present = next((name for name in names if name in header), None)
        if present is None:
            absent.append(names[0])
        elif header.count(present) > 1:
            raise InputError(f"{path}: column {present} appears twice")
        else:
            indices.append(header.index(present))
    return indices, factor, absent

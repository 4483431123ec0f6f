"""What commands print of files and values that may be anything, and the units that engineers read.

Such text is printable, not endless, and no reason to fail."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from math import pi, tau
from threading import Timer
from typing import NamedTuple

G = 9.80665  # m/s², standard gravity
ENGINEERING = {  # by the SI unit: the factor, and the unit that numbers printed for people have; others stay
    "m": (1e6, "µm"), "rad": (180.0 / pi, "°"), "rad/s": (1.0 / tau, "Hz"), "m/s2": (1.0 / G, "g"),
    "N/m": (1e-6, "N/µm"), "Pa": (1e-6, "MPa"), "1": (1.0, "")}  # fmt: skip


def engineering(unit: str) -> tuple[float, str]:
    """Factor from an SI unit, as result files spell it, to the one that people read, and its name; "" of a ratio."""
    return ENGINEERING.get(unit, (1.0, unit))


MOST_LINES, LONGEST_LINE = 60, 1200
ENDING = 300  # characters of a long line that stay of its end, where the remedy stands


def shown(text: object) -> str:
    """A text with control characters and halves of characters written out, long lines cut in the middle."""
    lines = str(text).split("\n")
    if len(lines) > MOST_LINES:
        lines = [*lines[:MOST_LINES], f"… {len(lines) - MOST_LINES} more lines"]
    return "\n".join(_line(line) for line in lines)


def _line(line):
    if len(line) > LONGEST_LINE:
        line = f"{line[: LONGEST_LINE - ENDING]} … {line[-ENDING:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)


def say(text: object) -> None:
    """Print to standard error, if anybody listens."""
    with suppress(OSError):
        print(shown(text), file=sys.stderr, flush=True)


@contextmanager
def said_if_long(seconds: float, sentence: str, tell: Callable[[str], None] | None) -> Iterator[None]:
    """Tell a sentence once what is done here has taken so long; None: nobody."""
    if tell is None:
        yield
        return
    timer = Timer(seconds, tell, (sentence,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@contextmanager
def telling() -> Iterator[None]:
    """Print what nobody need read: a reader that has gone, or a full disk behind standard output, is no failure."""
    try:
        yield
        if sys.stdout is not None:
            sys.stdout.flush()
    except (OSError, SystemExit):  # rich leaves by SystemExit where a pipe is broken
        close_output()


def close_output() -> None:
    """Discard all further output, Python's own at its end included."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


# Findings of a command, declared once: tables that its page and the terminal show


class Section(NamedTuple):
    """A table of texts; names stand at the left, numbers at the right."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    note: str = ""
    sum: str = ""  # rows whose first cell holds this are set apart
    kind: str = ""  # of the page's style: "words", "words stacked"


def print_section(section: Section, left: Sequence[int] = (0,)) -> None:
    """Print a table on the terminal, names that hold no blank on one line; columns of these numbers stand at the left.

    In its texts nothing is markup.
    """
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(shown(section.title)), title_justify="left", caption=section.note or None)
    for i, column in enumerate(section.columns):
        table.add_column(column, justify="left" if i in left else "right", no_wrap=column == "law")
    for row in section.rows:
        table.add_row(*(escape(shown(cell)) for cell in row))
    Console(highlight=False).print(table)

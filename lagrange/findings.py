"""Findings of a command, declared once: tables that its page and the terminal show."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Section:
    """A table of texts; names stand at the left, numbers at the right."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    note: str = ""
    sum: str = ""  # rows whose first cell holds this are set apart
    kind: str = ""  # of the page's style: "words", "words stacked"


def print_section(section: Section) -> None:
    """Print a table on the terminal, names that hold no blank on one line."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=section.title, title_justify="left", caption=section.note or None)
    for i, column in enumerate(section.columns):
        table.add_column(column, justify="right" if i else "left", no_wrap=column == "law")
    for row in section.rows:
        table.add_row(*row)
    Console(highlight=False).print(table)

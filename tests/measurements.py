"""Measurements of the handbook: tables in docs/measurements/, written by their commands and quoted by the pages.

A command with `--write` puts a section into docs/measurements/NAME.md; its second line says which command, when, with
which version and result format and on which processor. The record of an investigation that has ended stays when its
program goes: in place of the command it names `git show COMMIT:PATH`, a former program. A page quotes a number as a
link whose title names its cell:

    [0.04 %](measurements/verification.md#contact-statics "`resolved-bearing` · hub displacement: error")

`python -m tests.measurements` brings quoted numbers in line with the tables; `tests/test_measurements.py` fails where
that would change a page.
"""

import platform
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from functools import wraps
from itertools import pairwise
from pathlib import Path

from lagrange.columns import FORMAT_VERSION
from lagrange.version import VERSION
from tests.documented import value

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
HEAD = re.compile(
    r"^\*Measured by (?P<former>a former program \()?`(?P<command>[^`]+)`(?(former)\)) on (?P<date>\d{4}-\d\d-\d\d) "
    r"with version (?P<version>\d+\.\d+\.\d+), result format (?P<format>\d+), (?P<processor>[^*]+?)\.\*$",
    re.M,
)
QUOTE = re.compile(
    r'\[(?P<text>[^\]\n]+)\]\((?P<page>[\w/.-]*measurements/[\w.-]+\.md)#(?P<anchor>[\w-]+) "(?P<cell>[^"]+)"\)'
)
MEASURED = re.compile(r"^\*Measured with version [^*]+\.\*$", re.M)
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def markdown_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (headings, ["---"] * len(headings), *rows))


def publish(name: str, heading: str, command: str, *parts: str, write: bool) -> None:
    """Print a measurement; with `write` put it into docs/measurements/NAME.md as the section of its heading too.

    Parameters
    ----------
    command : the command that makes it, as it is typed, without --write
    parts : paragraphs and tables, from top to bottom
    """
    text = "\n\n".join(part.strip() for part in parts)
    print(f"## {heading}\n\n{text}", flush=True)
    if write:
        head = (
            f"*Measured by `{command} --write` on {date.today().isoformat()} with version {VERSION}, result format "
            f"{FORMAT_VERSION}, {processor()}.*"
        )
        write_section(DOCS / "measurements" / f"{name}.md", heading, f"{head}\n\n{text}")


def program(about: str | None, module: str, *sections: Callable[..., Iterable[tuple]]) -> None:
    """Run `python -m MODULE [SECTION] [OPTIONS] [--write]`.

    A section is a function whose parameters are the options; it yields a page, a heading and the parts below it as
    often as it has some. Where there is only one its name is not typed.
    """
    from cyclopts import App

    typed = [word for word in sys.argv[1:] if word != "--write"]
    command, write = " ".join(["python -m", module, *typed]), "--write" in sys.argv

    def published(section: Callable[..., Iterable[tuple]]) -> Callable[..., None]:
        @wraps(section)
        def run(*given, **options) -> None:
            for page, heading, *parts in section(*given, **options):
                publish(page, heading, command, *parts, write=write)

        return run

    app = App(help=about, help_format="markdown")
    for section in sections:
        (app.command if len(sections) > 1 else app.default)(published(section))
    app(typed)


def processor() -> str:
    try:
        name = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M)
    except OSError:
        name = None
    return name[1].strip() if name else platform.processor() or platform.machine()


def write_section(page: Path, heading: str, text: str) -> None:
    """Replace a page's section of the second level, up to the next one; add it at the end where there is none."""
    sign = f"## {heading}\n"
    before, _, old = page.read_text(encoding="utf-8").partition(f"\n{sign}")
    _, _, after = old.partition("\n## ")
    rest = f"\n## {after}" if after else ""
    page.write_text(f"{before.rstrip()}\n\n{sign}\n{text.strip()}\n{rest}", encoding="utf-8")


@dataclass(frozen=True)
class Quote:
    """A number of a page and the cell that it is quoted from."""

    whole: str
    text: str
    target: Path
    anchor: str
    cell: str

    @property
    def right(self) -> str:
        """The text with the table's numbers, in their order, rounded to as many decimals as are shown.

        Errors
        ------
        ValueError: no such section, row or column, or fewer numbers in the cell than in the text.
        """
        found = NUMBER.findall(cell_of(self.target, self.anchor, self.cell))
        values = iter([value(number)[0] for number in found])
        try:
            return NUMBER.sub(lambda shown: _written(next(values), shown[0]), self.text)
        except StopIteration:
            raise ValueError(f"{self.cell}: fewer numbers than {self.text!r}") from None


def quotes(page: Path, text: str | None = None) -> Iterator[Quote]:
    """Numbers that a page, or a text of it, quotes from measurements."""
    for found in QUOTE.finditer(page.read_text(encoding="utf-8") if text is None else text):
        target = (page.parent / found["page"]).resolve()
        yield Quote(found[0], found["text"], target, found["anchor"], found["cell"])


def sections_at(page: Path, anchor: str) -> list[str]:
    """A page's sections of that anchor."""
    sections = re.split(r"^(?=##+ )", page.read_text(encoding="utf-8"), flags=re.M)
    return [text for text in sections if slug(text.partition("\n")[0].lstrip("# ")) == anchor]


def heads(page: Path, text: str) -> list[re.Match]:
    """Where the numbers that a text of a page quotes are from, each head once."""
    every = (section for quote in quotes(page, text) for section in sections_at(quote.target, quote.anchor))
    return list({found[0]: found for section in every if (found := HEAD.search(section))}.values())


def measured_by(page: Path, section: str) -> str:
    """The line below numbers that says which versions on which processors they are from."""
    found = heads(page, section)
    versions, processors = (list(dict.fromkeys(head[name] for head in found)) for name in ("version", "processor"))
    named = "; ".join(name.removeprefix("on ") for name in processors)
    newest_last = sorted(versions, key=lambda version: [*map(int, version.split("."))])
    return f"*Measured with version {', '.join(newest_last)} on {named}.*"


def cell_of(page: Path, anchor: str, name: str) -> str:
    """A table's cell by `row: column`; a row is named by its first cells with ` · ` between them."""
    row, _, column = name.rpartition(": ")
    wanted = row.split(" · ")
    for headings, rows in (table for section in sections_at(page, anchor) for table in tables(section)):
        for cells in rows if column in headings else ():
            if cells[: len(wanted)] == wanted:
                return cells[headings.index(column)]
    raise ValueError(f"{page.name}#{anchor} has no cell {name!r}")


def tables(section: str) -> Iterator[tuple[list[str], list[list[str]]]]:
    """Headings and rows of a section's tables; an empty first cell is the one above."""
    for block in re.findall(r"(?:^\|.*\n?)+", section, re.M):
        headings, _, *rows = ([cell.strip() for cell in line.strip()[1:-1].split("|")] for line in block.splitlines())
        for above, below in pairwise(rows):
            below[0] = below[0] or above[0]
        yield headings, rows


def slug(heading: str) -> str:
    """Anchor of a heading, as the site and GitHub make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _written(value: float, like: str) -> str:
    """A value with the decimals, the power and the sign of another number; without a sign its size."""
    mantissa = re.split("e|·", like)[0]
    signed, decimals = mantissa[0] in "-+−", len(mantissa.partition(".")[2])
    if "e" in like or "·" in like:
        digits, _, power = f"{abs(value):.{decimals}e}".partition("e")
        text = f"{digits}e{power}" if "e" in like else f"{digits}·10{str(int(power)).translate(SUPERSCRIPT)}"
    else:
        text = f"{abs(value):.{decimals}f}"
    return (("+" if value >= 0.0 else "−" if "−" in mantissa else "-") if signed else "") + text


def refreshed(page: Path) -> str:
    """A page's text with the numbers of today's tables."""
    text = page.read_text(encoding="utf-8")
    for quote in quotes(page):
        text = text.replace(quote.whole, quote.whole.replace(f"[{quote.text}]", f"[{quote.right}]", 1))
    sections = re.split(r"^(?=## )", text, flags=re.M)
    return "".join(MEASURED.sub(lambda _, each=each: measured_by(page, each), each) for each in sections)


READER_PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]  # they quote measurements
MEASUREMENT_PAGES = sorted((DOCS / "measurements").glob("*.md"))  # commands write them

if __name__ == "__main__":
    for page in READER_PAGES:
        page.write_text(refreshed(page), encoding="utf-8")

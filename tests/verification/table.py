"""Outcomes as tables."""

from collections.abc import Iterator
from itertools import groupby

from rich.table import Table

from tests.measurements import markdown_table, publish
from tests.verification.case import Check, Outcome

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
HEADINGS = ("quantity", "computed", "reference", "error", "tolerance", "the reference's origin")


def screen(outcome: Outcome) -> Table:
    """Table of one case for the terminal."""
    verdict = "passed" if outcome.passed else "FAILED"
    table = Table(title=f"{outcome.case.name}: {verdict}, {outcome.seconds:.1f} s", title_justify="left")
    for i, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="left" if i in (0, 5) else "right", overflow="fold")
    for check in outcome.checks:
        table.add_row(*cells(check), style=None if check.passed else "bold red")
    if outcome.trouble:
        table.caption = outcome.trouble
    return table


def verdict(outcomes: list[Outcome]) -> str:
    """State the outcome of all cases in a line."""
    checks = sum(len(outcome.checks) for outcome in outcomes)
    seconds = sum(outcome.seconds for outcome in outcomes)
    failed = ", ".join(outcome.case.name for outcome in outcomes if not outcome.passed)
    return f"{len(outcomes)} cases, {checks} checks, {seconds:.0f} s: {f'FAILED: {failed}' if failed else 'all passed'}"


def cells(check: Check) -> list[str]:
    """Cells of a check's row."""
    unit = f" {check.unit}" if check.unit else ""
    return [
        check.quantity,
        _powers(f"{check.computed:.5g}") + unit,
        _powers(f"{check.reference:.5g}") + unit,
        _percent(check.error) + ("" if check.passed else " FAILS"),
        _percent(check.tolerance, sign=False),
        f"{check.origin}: {check.source}",
    ]


def _percent(share: float, sign: bool = True) -> str:
    """Write a share in per cent with two digits, as a power of ten where it is tiny."""
    value = 100.0 * share
    text = f"{value:+.2g}" if sign and value else f"{value:.2g}"
    if 0.0 < abs(value) < 1e-3:
        text = f"{value:+.1e}" if sign else f"{value:.0e}"
    return f"{_powers(text)} %"


def _powers(number: str) -> str:
    """Write 1.2e-07 as 1.2·10⁻⁷."""
    digits, e, power = number.partition("e")
    return f"{digits}·10{str(int(power)).translate(SUPERSCRIPT)}" if e else digits


def write_sections(outcomes: list[Outcome]) -> None:
    """Write subjects' sections of docs/measurements/verification.md: what each case does, and its checks."""
    for subject, group in groupby(outcomes, key=lambda outcome: outcome.case.subject):
        group = list(group)
        command = f"python -m tests.verification {dashed(subject)}"
        cases = "\n".join(f"* `{outcome.case.name}`: {outcome.case.description}" for outcome in group)
        table = markdown_table(("case", *HEADINGS), [row for outcome in group for row in _rows(outcome)])
        publish("verification", subject.capitalize(), command, cases, table, write=True)


def _rows(outcome: Outcome) -> Iterator[list[str]]:
    name = f"`{outcome.case.name}`"
    for check in outcome.checks:
        yield [name, *cells(check)]
        name = ""
    if outcome.trouble:
        yield [name, f"FAILED: {outcome.trouble}", *[""] * (len(HEADINGS) - 1)]


def dashed(subject: str) -> str:
    """A subject's name as it is typed."""
    return subject.replace(" ", "-")

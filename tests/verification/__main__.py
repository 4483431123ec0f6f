"""`python -m tests.verification`: run cases, print what was found, exit 1 if one fails.

A new case is a name in CASES of its subject's module.
"""

import sys
from itertools import groupby
from typing import Annotated

from cyclopts import App, Parameter

from tests.measurements import SUPERSCRIPT, markdown_table, publish
from tests.verification import Case, Check, Outcome, contact_statics, elastic_bodies, impact, rolling, run_case

CASES = [*elastic_bodies.CASES, *contact_statics.CASES, *impact.CASES, *rolling.CASES]
HEADINGS = ("quantity", "computed", "reference", "error", "tolerance", "the reference's origin")
OK, FAILED, UNUSABLE = 0, 1, 2

app = App(
    name="python -m tests.verification", version_flags=[], help_format="plaintext", result_action="return_value",
    help="""Hold the solver's pieces against analytic solutions, published values and conservation laws.

Example: python -m tests.verification disc-modes rolling
         python -m tests.verification rolling balances --write

Exit codes: 0 all passed; 1 a case failed; 2 unknown name.
""",
)  # fmt: skip


def option(text: str) -> Parameter:
    return Parameter(negative="", help=text)


@app.default
def main(
    *names: Annotated[str, Parameter(help="cases, or subjects with all of their cases; default: all")],
    fast: Annotated[bool, option("leave out the slow ones")] = False,
    list_cases: Annotated[bool, Parameter("--list", negative="", help="say what there is, run nothing")] = False,
    write: Annotated[bool, option("write the subjects' tables into docs/measurements/verification.md")] = False,
) -> int:
    try:
        cases = named(list(names)) if names else CASES
        touched = {case.subject for case in cases}
        if write and (fast or set(cases) != {case for case in CASES if case.subject in touched}):
            raise ValueError("--write takes whole subjects: name subjects, and leave out --fast")
    except ValueError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    cases = [case for case in cases if case.fast or not fast]
    if list_cases:
        for case in cases:
            print(f"{case.name} ({case.subject}{'' if case.fast else ', slow'}): {case.description}")
        return OK
    outcomes = []
    for case in cases:
        outcomes.append(run_case(case))
        print(f"{case.name}: {'passed' if outcomes[-1].passed else 'FAILED'}, {outcomes[-1].seconds:.1f} s")
        print(markdown_table(HEADINGS, rows(outcomes[-1])), flush=True)
    checks, seconds = sum(len(each.checks) for each in outcomes), sum(each.seconds for each in outcomes)
    failed = ", ".join(each.case.name for each in outcomes if not each.passed)
    verdict = f"FAILED: {failed}" if failed else "all passed"
    print(f"{len(outcomes)} cases, {checks} checks, {seconds:.0f} s: {verdict}")
    for subject, group in groupby(outcomes if write else [], key=lambda outcome: outcome.case.subject):
        write_section(subject, list(group))
    return FAILED if failed else OK


def named(names: list[str]) -> list[Case]:
    """The cases of these names, in the order of the suite; a subject's name stands for all of its cases.

    ValueError: an unknown name; the message lists the known ones.
    """
    wanted, known = {name.replace("_", "-").replace(" ", "-") for name in names}, [case.name for case in CASES]
    subjects = list(dict.fromkeys(dashed(case.subject) for case in CASES))
    if unknown := sorted(wanted - {*known, *subjects}):
        raise ValueError(
            f"unknown case {', '.join(unknown)}; cases: {', '.join(known)}; subjects: {', '.join(subjects)}"
        )
    return [case for case in CASES if {case.name, dashed(case.subject)} & wanted]


def dashed(subject: str) -> str:
    return subject.replace(" ", "-")


def rows(outcome: Outcome) -> list[list[str]]:
    trouble = [[f"FAILED: {outcome.trouble}", *[""] * (len(HEADINGS) - 1)]] if outcome.trouble else []
    return [cells(check) for check in outcome.checks] + trouble


def cells(check: Check) -> list[str]:
    values = [f"{_powers(f'{x:.5g}')} {check.unit}".strip() for x in (check.computed, check.reference)]
    error = _percent(check.error) + ("" if check.passed else " FAILS")
    return [check.quantity, *values, error, _percent(check.tolerance, sign=False), check.source]


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


def write_section(subject: str, outcomes: list[Outcome]) -> None:
    """Write a subject's section of docs/measurements/verification.md: what each case does, and its checks."""
    about = "\n".join(f"* `{each.case.name}`: {each.case.description}" for each in outcomes)
    every = [[f"`{each.case.name}`" if k == 0 else "", *row] for each in outcomes for k, row in enumerate(rows(each))]
    table, command = markdown_table(("case", *HEADINGS), every), f"python -m tests.verification {dashed(subject)}"
    publish("verification", subject.capitalize(), command, about, table, write=True)


if __name__ == "__main__":
    sys.exit(app())

"""Hold the solver's pieces against analytic solutions, published values and conservation laws.

    python -m tests.verification disc-modes rolling
    python -m tests.verification rolling balances --write

A new case is a name in CASES of its subject's module. Exit codes: 0 all passed; 1 a case failed; 2 unknown name.
"""

import sys
from itertools import groupby

from tests.measurements import SUPERSCRIPT, markdown_table, program
from tests.verification import Case, Check, Outcome, contact_statics, elastic_bodies, impact, rolling, run_case, spalls

CASES = [*elastic_bodies.CASES, *contact_statics.CASES, *impact.CASES, *rolling.CASES, *spalls.CASES]
HEADINGS = ("case", "quantity", "computed", "reference", "error", "tolerance", "the reference's origin")


def verification(*names: str, fast: bool = False, list_cases: bool = False):
    """Run cases and print what was found.

    Parameters
    ----------
    names: cases, or subjects with all of their cases; default: all
    fast: leave out the slow ones
    list_cases: say what there is, run nothing
    """
    try:
        cases = named(names)
        touched = {case.subject for case in cases}
        if "--write" in sys.argv and (fast or set(cases) != {case for case in CASES if case.subject in touched}):
            raise ValueError("--write takes whole subjects: name subjects, and leave out --fast")
    except ValueError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    cases, failed = [case for case in cases if case.fast or not fast], []
    if list_cases:
        for case in cases:
            print(f"{case.name} ({case.subject}{'' if case.fast else ', slow'}): {case.description}")
        return
    for subject, some in groupby(cases, key=lambda case: case.subject):
        about, table = [], []
        for outcome in map(run_case, some):
            name = outcome.case.name
            failed += [] if outcome.passed else [name]
            print(f"{name}: {'passed' if outcome.passed else 'FAILED'}, {outcome.seconds:.1f} s", flush=True)
            about.append(f"* `{name}`: {outcome.case.description}")
            table += [[f"`{name}`" if k == 0 else "", *row] for k, row in enumerate(rows(outcome))]
        yield "verification", subject.capitalize(), "\n".join(about), markdown_table(HEADINGS, table)
    print(f"FAILED: {', '.join(failed)}" if failed else f"{len(cases)} cases: all passed")
    sys.exit(bool(failed))


def named(names: tuple[str, ...]) -> list[Case]:
    """The cases of these names, in the order of the suite; a subject's name stands for all of its cases, none for all.

    ValueError: an unknown name; the message lists the known ones.
    """
    wanted = {name.replace("_", "-").replace(" ", "-") for name in names}
    known, subjects = ([*dict.fromkeys(of)] for of in ((c.name for c in CASES), (c.dashed_subject for c in CASES)))
    if unknown := sorted(wanted - {*known, *subjects}):
        raise ValueError(
            f"unknown case {', '.join(unknown)}; cases: {', '.join(known)}; subjects: {', '.join(subjects)}"
        )
    return [case for case in CASES if not wanted or {case.name, case.dashed_subject} & wanted]


def rows(outcome: Outcome) -> list[list[str]]:
    trouble = [[f"FAILED: {outcome.trouble}", *[""] * (len(HEADINGS) - 2)]] if outcome.trouble else []
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


if __name__ == "__main__":
    program(__doc__, "tests.verification", verification)

"""`python -m tests.verification`: run cases, print what was found, exit 1 if one fails."""

import sys
from typing import Annotated

from cyclopts import App, Parameter
from rich.console import Console

WIDTH = 160
OK, FAILED, UNUSABLE = 0, 1, 2

app = App(
    name="python -m tests.verification",
    version_flags=[],
    help_format="plaintext",
    result_action="return_value",
    help="""Hold the solver's pieces against analytic solutions, published values and conservation laws.

Example: python -m tests.verification disc-modes rolling
         python -m tests.verification rolling balances --write

Exit codes: 0 all passed; 1 a case failed; 2 unknown name.
""",
)


@app.default
def main(
    *names: Annotated[str, Parameter(help="cases, or subjects with all of their cases; default: all")],
    fast: Annotated[bool, Parameter(negative="", help="leave out the slow ones")] = False,
    list_cases: Annotated[bool, Parameter(name="--list", negative="", help="say what there is, run nothing")] = False,
    write: Annotated[
        bool, Parameter(negative="", help="write the subjects' tables into docs/measurements/verification.md")
    ] = False,
) -> int:
    from tests.verification import subjects, table  # loads the solver; --help does without
    from tests.verification.case import run_case

    console = Console(width=WIDTH, highlight=False)
    try:
        cases = subjects.named(list(names)) if names else subjects.all_cases()
        if write and (fast or not subjects.whole(cases)):
            raise ValueError("--write takes whole subjects: name subjects, and leave out --fast")
    except ValueError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    if fast:
        cases = tuple(case for case in cases if case.fast)
    if list_cases:
        for case in cases:
            print(f"{case.name} ({case.subject}{'' if case.fast else ', slow'}): {case.description}")
        return OK
    outcomes = []
    for case in cases:
        outcomes.append(run_case(case))
        console.print(table.screen(outcomes[-1]))
    console.print(table.verdict(outcomes))
    if write:
        table.write_sections(outcomes)
    return OK if all(outcome.passed for outcome in outcomes) else FAILED


if __name__ == "__main__":
    sys.exit(app())

"""All cases: one module per subject, each with a tuple CASES. A new subject is a new module and a line here."""

from tests.verification import (
    balances,
    contact_statics,
    elastic_bodies,
    impact,
    quadratic_statics,
    resolved,
    rolling,
    varying_compliance,
)
from tests.verification.case import Case

SUBJECTS = (elastic_bodies, contact_statics, quadratic_statics, resolved, impact, rolling, balances, varying_compliance)


def all_cases() -> tuple[Case, ...]:
    """Every case, by subject."""
    return tuple(case for subject in SUBJECTS for case in subject.CASES)


def named(names: list[str]) -> tuple[Case, ...]:
    """The cases of these names, in the order of the suite; a subject's name stands for all of its cases.

    Errors
    ------
    ValueError: an unknown name; the message lists the known ones.
    """
    known = all_cases()
    wanted = {name.replace("_", "-").replace(" ", "-") for name in names}
    offered = {case.name for case in known} | {case.subject.replace(" ", "-") for case in known}
    if unknown := sorted(wanted - offered):
        raise ValueError(
            f"unknown case {', '.join(unknown)}; cases: {', '.join(case.name for case in known)}; "
            f"subjects: {', '.join(dict.fromkeys(case.subject.replace(' ', '-') for case in known))}"
        )
    return tuple(case for case in known if {case.name, case.subject.replace(" ", "-")} & wanted)


def whole(cases: tuple[Case, ...]) -> bool:
    """Whether these are all cases of each of their subjects."""
    touched = {case.subject for case in cases}
    return set(cases) == {case for case in all_cases() if case.subject in touched}

"""Verification: the solver's own pieces against values it did not compute, `python -m tests.verification`.

A case is a function that yields checks, each a computed number against an independent one; `runs` is what cases set in
motion; exact solutions stand in tests/reference. A check's source begins with the kind of its reference:

analytic      a closed formula, a series or a root of an exact equation, evaluated here
literature    a formula or figure as published, an approximation or a fit
conservation  what must not change, or must balance
computed      a numerical solution by other means
other model   another idealisation: the difference is the models', and expected
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Check(NamedTuple):
    """A computed number held against one that does not come from the code under test."""

    quantity: str
    unit: str
    computed: float
    reference: float
    tolerance: float  # of `scale`
    source: str  # where formula or value stand
    scale: float | None = None  # what the error is measured by; None: the reference itself

    @property
    def error(self) -> float:
        """Signed, relative to the scale."""
        scale = self.reference if self.scale is None else self.scale
        return float((self.computed - self.reference) / abs(scale)) if scale else np.nan

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; not a number is not."""
        return bool(abs(self.error) <= self.tolerance)


@dataclass(frozen=True)
class Case:
    """One verification: the docstring of `checks` says what is done and which parts of the solver do it."""

    subject: str
    checks: Callable[[], Iterable[Check]]
    fast: bool = True  # takes seconds: part of the tests

    @property
    def name(self) -> str:
        return self.checks.__name__.replace("_", "-")

    @property
    def dashed_subject(self) -> str:
        return self.subject.replace(" ", "-")

    @property
    def description(self) -> str:
        """The docstring on one line."""
        return " ".join((self.checks.__doc__ or "").split())


class Outcome(NamedTuple):
    case: Case
    checks: tuple[Check, ...]
    seconds: float
    trouble: str = ""  # what stopped it

    @property
    def passed(self) -> bool:
        return not self.trouble and len(self.checks) > 0 and all(check.passed for check in self.checks)


def run_case(case: Case) -> Outcome:
    """Run a case; an exception is an outcome, so that the other cases are run too."""
    began, found, trouble = time.perf_counter(), [], ""
    try:
        found.extend(case.checks())
    except Exception as error:  # that is a failed verification
        trouble = f"{type(error).__name__}: {error}"
    return Outcome(case, tuple(found), time.perf_counter() - began, trouble)

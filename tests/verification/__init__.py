"""Verification: the solver's own pieces against values it did not compute, `python -m tests.verification`.

`case` says what a check and a case are; the other modules hold the cases of a subject each. `runs` is
what they set in motion; exact solutions stand in tests/reference.
"""

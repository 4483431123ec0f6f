"""Verification: the solver's own pieces against values it did not compute, `python -m tests.verification`.

case       a check, a case, and how one is run
subjects   all cases; the modules below hold them
table      cases and checks as tables on the screen and in docs/measurements/verification.md

elastic_bodies      vibration, bending and growth of discs and rings
contact_statics     line contact, bearings at rest
impact              a bar on a floor, a roller on a flat, a ball on a half-space
rolling             creep, spin-up, rolling without slip
balances            momentum, angular momentum, energy
varying_compliance  the hub as rollers pass under the load

shapes, runs, collision, bar   what the cases set in motion; exact solutions stand in tests/reference
"""

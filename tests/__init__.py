"""Tests, and the longer checks of correctness; each of those is a command, run from the checkout's root.

test_*         what `python -m pytest` runs, one module per subject
conftest       what all of them share
measurements   tables of docs/measurements/, which commands write and pages quote
reference      analytic and independent solutions, inputs sound and bad, bearings to try

verification   the solver's pieces against analytic solutions, published values, conservation laws
convergence    observed orders in mesh size, time step and output interval
paper          the paper's figures against ours, and the runs that explain the difference
stability      random scenes from the whole range of bearings: none may end silently wrong
fuzz           readers of text and of records against changed files

Speed is measured in `benchmarks`.
"""

"""How far results are off. Each module is a command; `--write` keeps its tables in docs/measurements/.

convergence  observed orders in mesh size, time step and output interval
spalls       one crossing of a spall against resolved contacts

The solver's pieces against independent values: `tests.verification`; run time against error of every model:
`benchmarks.work_precision`.
"""

"""Benchmarks, each a command that prints a table: run from the repository's root.

verification    the solver's pieces against analytic solutions, published values, conservation laws
work_precision  run time against error over meshes
elements        other elements and meshes: work of an explicit step against error
stability       random scenes from the whole range of bearings: none may end silently wrong
random_scenes   the draw of those scenes
step_limit      energy drift against time step over critical step: where the true limit is
lagrange_model  the Lagrangian model solved: its time, its energy, the checker on its own output
paper           the paper's figures against ours, and the runs that explain the difference
pictures        docs' pictures; stress below contacts, times, sizes
fuzz            every reader against changed files, guided by coverage; `mutations` makes them
threads         time of a step on one thread and on more
checkpoint_cost what checkpoints and commits cost, as paired ratios
throughput      time of every phase of a step against the machine's ceilings
machine         the ceilings, measured
phases          the phases of a step, timed, and the work they need at least
"""

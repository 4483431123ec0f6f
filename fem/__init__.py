"""Explicit elastic finite-element simulation of a roller bearing.

entry                     the installed commands, whose signals wait until they are loaded
cli, render_cli, live_cli, study_cli   the commands; outcome: how they end
summary, progress          what they print, answers: of a run, cage_answers: of its cage
collecting, children      when Python looks for garbage; where processes that libraries begin look for modules
runner                    a run of any solver with its file, checkpoints and signals
examples                  commented scenes to begin with
live                      a run played in a browser's page
study                     many runs of a scene: points, dataset, page
pictures                  off-screen pictures, films, fields for other programs
result                    the result file and checkpoints
solver                    what every solver answers; the finite elements and the Lagrangian model as solvers
statics                   bearings at rest, with a mesh and without
contacts                  contact models: how a mesh carries contacts, and what is added that it can't see
elastic                   discs and rings: meshes made into matrices, exact series
kernels                   the time loop

interface, recording       runs from Python: `simulate`, `statics`; `Result`, a run in memory
quantities, labels         numbers of interest of a run; what it is an example of
checking                   the one module that knows the checker, for runs from Python and studies

A package knows those below it; import-linter keeps it so. What a user imports stands in `fem.interface`.
"""

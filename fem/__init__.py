"""Explicit elastic finite-element simulation of a roller bearing.

commands                        the installed commands
runner                          a run of any solver with its file, checkpoints and signals; `run_summary`
interface                       runs from Python: `simulate`, `statics`; `recording`: a run in memory; `quantities`
rating                          load ratings, lives, stiffness and friction of a scene's bearing
live, study, pictures, result   a run played in a page, many runs of a scene, pictures and films, files
solver                          what every solver answers; the finite elements, the reduced and the Lagrangian model
statics, contacts, elastic      bearings at rest; how a mesh carries contacts; discs and rings
kernels                         the time loop
examples                        commented scenes to begin with

A package knows those below it; import-linter keeps it so. What a user imports stands in `fem.interface`.
"""

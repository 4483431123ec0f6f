"""Explicit elastic finite-element simulation of a roller bearing.

cli, render_cli           the commands; summary, progress: what they print
runner                    a run with its file, checkpoints and signals
lagrange_run, wording     the Lagrangian model in place of the finite elements; sentences both end with
pictures                  off-screen pictures, films, fields for other programs
result                    the result file and checkpoints
solver                    from a scene to a plan and a run
statics                   bearings at rest, with a mesh and without
contacts                  contact models: how a mesh carries contacts, and what is added that it can't see
elastic                   discs and rings: meshes made into matrices, exact series
kernels                   the time loop

A package knows those below it; import-linter keeps it so.
"""

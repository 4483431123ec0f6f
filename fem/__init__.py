"""Explicit elastic finite-element simulation of a roller bearing.

cli, render_cli           the commands; summary, progress: what they print
runner                    a run with its file, checkpoints and signals
lagrange_run, wording     the Lagrangian model in place of the finite elements; sentences both end with
pictures                  off-screen pictures, films, fields for other programs
result                    the result file and checkpoints
solver                    from a scene to a plan and a run
statics                   bearings at rest, with a mesh and without
elastic                   discs, rings, contacts: meshes made into matrices and calibrated laws
kernels                   the time loop

A package knows those below it; import-linter keeps it so.
"""

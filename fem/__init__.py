"""Explicit elastic finite-element simulation of a roller bearing.

cli, render_cli               the commands; summary, progress: what they print
simulate, limits, start       from a scene to a plan and a run; what is refused; the state a run starts from
lagrange_run, wording         the Lagrangian model in place of the finite elements; sentences both end with
samples, frames               rows of the time loop as quantities; stored fields
store, layout, earlier        the result file while it is written; what is in it; what is in its place before
durable                       files that appear whole or not at all
checkpoint, runner            the solver's state on disk; a run with checkpoints and signals
assembly, bodies, model       scikit-fem's matrices; a disc as rows of blocks, a ring as one sector's stencil; the whole
subgrid, patches              the calibrated contact law below the grid; B-spline patches
contact_balance, equilibrium  hub and rollers on elastic contacts; the static equilibrium of the finite elements
continuum, exact_statics      exact series for discs and rings; the whole bearing without a mesh, the yardstick
critical_step                 2/ω_max with the contacts in it
state, arrays                 what the time loop works on, and how it is filled
*_kernels, time_loop, simd    numba: bodies, contacts, what a sample stores; leapfrog; eight lanes as one value
jit                           @kernel: compiled once per version of the code
recover, export               fields of a stored instant; the same for other programs
stress, subsurface            stress from displacements; analytic fields below a contact that the mesh can't see
near_contacts, peaks          the two put together; the largest shear below a contact
render, film                  off-screen pictures, films; render_bodies, refine: what is drawn; render_bearing,
                              render_closeup: the views; render_look, _scale, _legend, _canvas, _shapes: how
"""

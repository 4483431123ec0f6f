"""From a scene to samples, by the solver that the scene's `model` names.

solver             what every solver answers: plan, first state, blocks of samples, what a checkpoint keeps
simulate           the registry of solvers, and the loop that advances a run of any of them
lagrangian         the Lagrangian model as a solver

The finite elements:

finite_elements    their plan: everything decided before the first step; `description`: what is shown of it
element_state      their state, advanced in blocks; `guards`: looks at the samples that no sound run fails
discretise         the model of a scene: mesh, contact model, width of the patches
limits, cautions   what is refused; what is warned of
start, arrays      the state a run starts from; the time loop's arrays filled with it, `contact_arrays` the contacts'
samples, frames    rows of the time loop as quantities; displacements at an instant
processor          what the compiler makes the kernels for
error_estimate     what a scene's results may be off by, from a second mesh
"""

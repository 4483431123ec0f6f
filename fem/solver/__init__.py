"""From a scene to samples.

discretise         the model of a scene: mesh, contact model, width of the patches
limits, cautions   what is refused; what is warned of
start, arrays      the state a run starts from; the time loop's arrays filled with it
simulate           plan and run
samples, frames    rows of the time loop as quantities; displacements at an instant
error_estimate     what a scene's results may be off by, from a second mesh
"""

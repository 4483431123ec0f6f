"""From a scene to samples, by the solver that the scene's `model` names.

solver             what every solver answers: plan, first state, blocks of samples, what a checkpoint keeps
simulate           the registry of solvers, and the loop that advances a run of any of them; `model_choice`: what each
                   would take for a scene and err by; `pace`: how fast this machine is
row_state          states that a compiled time loop advances; `guards`: looks at the samples that no sound run fails
samples            rows of a time loop as quantities; `energy_account`: the error of their energy; `compiling`:
                   plans whose loop is compiled
lagrangian         the Lagrangian model as a solver; `lagrangian_steps`: its integration, compiled
reduced            the reduced model as a solver: its plan; `reduced_start`: where its runs begin; `reduced_arrays`: its
                   time loop's; `reduced_state`: runs that begin again; `vibrations`: modes of its bodies;
                   `hub_vibration`: what runs without them miss of the hub's, `law_errors` what laws of wide contacts;
                   `reduced_estimate`: how far it is from finite elements

The finite elements:

finite_elements    their plan: everything decided before the first step; `description`: what is shown of it
element_state      their state
discretise         the model of a scene: mesh, contact model, width of the patches
limits, cautions   what is refused; what is warned of; `strikes`: whether bodies may strike each other, of the reduced
                   model too
wide_contacts      the largest contacts of a run, of all models
start, arrays      the state a run starts from; the time loop's arrays filled with it, `contact_arrays` the contacts',
                   `damping_arrays` the dampers'; `cage_arrays` the cage's, `cage_seat` where it stands,
                   `profile_arrays` the surfaces', of the reduced model too; `run_arrays`: which of all arrays a run
                   changes
frames             displacements at an instant
processor          what the compiler makes the kernels for
error_estimate     what a scene's results may be off by, from a second mesh
"""

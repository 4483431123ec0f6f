"""From a scene to samples, by the solver that the scene's `model` names.

solver, simulate                       what every solver answers: plan, first state, blocks of samples; the registry
finite_elements, reduced, lagrangian   the plans
row_state, rigid_state                 runs of compiled time loops; of rigid bodies
reduced_state, lagrangian_state        the models' own parts of these; the finite elements' stands beside their plan
rigid_arrays, reduced_arrays, lagrangian_arrays  arrays of rigid bodies; what each model has of its own
lagrangian_start, lagrangian_judge     its first sample and its verdict on steps, which need no compiler
sections                               two step lengths of rigid bodies
"""

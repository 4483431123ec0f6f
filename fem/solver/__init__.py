"""From a scene to samples, by the solver that the scene's `model` names.

solver, simulate                       what every solver answers: plan, first state, blocks of samples; the registry
finite_elements, reduced, lagrangian   the plans
element_state, reduced_state           their states; `lagrangian_start`, `lagrangian_steps`: of the Lagrangian model
"""

"""From a scene to samples, by the solver that the scene's `model` names.

Read `solver` first: what every solver answers, a plan, its first state, blocks of samples; then `simulate`, the
registry. `elements` and `rigid` are the solvers, `row_state` what runs of both have, `parts` parts of scenes; `start`
is where bodies without mass of their elasticity begin, `limits` and `guards` look at scenes and at samples.
"""

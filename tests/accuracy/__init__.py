"""How far results are off, and how it falls with refinement. Each module is a command; `--write` keeps its tables.

The tables stand in docs/measurements/ (`tests.measurements`):

convergence    observed orders in mesh size, time step and output interval
crossover      from meshes far coarser than a contact to meshes that resolve it
reduced        the reduced model against finite elements, and its energy by the step
reduced_waves  the reduced model on rattling bearings, and of the hub by bands of frequency
reduced_random the reduced model on random bearings
reduced_steps  how long the reduced model's steps may be
fault_finding  spalls found in random runs
rocking        vibration of rollers that stick to both raceways
spall_edges    one crossing of a spall by the contact law, against half-planes
spall_crossing one crossing of a spall by all models, against resolved contacts
"""

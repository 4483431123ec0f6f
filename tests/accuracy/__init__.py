"""How far results are off, and how it falls with refinement. Each module is a command that writes its page.

convergence    observed orders in mesh size, time step and output interval: docs/convergence.md
crossover      from meshes far coarser than a contact to meshes that resolve it: docs/crossover.md
reduced        the reduced model against finite elements, and its energy by the step: docs/reduced.md
fault_finding  spalls found in random runs (`random_faults`): docs/fault_finding.md
rocking        vibration of rollers that stick to both raceways: docs/rocking.md
reduced_waves  the reduced model on rattling bearings, and of the hub by bands of frequency: docs/reduced.md
reduced_random the reduced model on random bearings: docs/reduced.md
"""

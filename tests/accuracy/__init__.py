"""How far results are off, and how it falls with refinement. Each module is a command that writes its page.

convergence    observed orders in mesh size, time step and output interval: docs/convergence.md
crossover      from meshes far coarser than a contact to meshes that resolve it: docs/crossover.md
reduced        the reduced model against finite elements, and its energy by the step: docs/reduced.md
fault_finding  spalls found in random runs: docs/fault_finding.md
rocking        vibration of rollers that stick to both raceways: docs/rocking.md
"""

"""How errors fall as meshes, steps and output intervals are refined. Each module is a command that writes its page.

convergence  observed orders in mesh size, time step and output interval: docs/convergence.md
rocking      vibration of rollers that stick to both raceways: docs/rocking.md
crossover    from meshes far coarser than a contact to meshes that resolve it: docs/crossover.md
"""

"""How errors fall as meshes, steps and output intervals are refined. Each module is a command that writes its page.

convergence  observed orders in mesh size, time step and output interval: docs/convergence.md
crossover    from meshes far coarser than a contact to meshes that resolve it: docs/crossover.md
reduced      the reduced model against finite elements, its energy by the step: docs/reduced.md
reduced_waves   the same on rattling bearings, and of the hub by bands of frequency
reduced_random  the same on random bearings
"""

"""Rigid bodies in one time loop: `lagrangian` and `reduced` (the models' plans), `state` (arrays and runs)."""

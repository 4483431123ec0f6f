"""Rigid bodies in one time loop: `plan` (two step lengths), `reduced` and `lagrangian` (the models), `start`."""

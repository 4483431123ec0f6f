"""Rigid bodies on contacts without mass: the reduced and the Lagrangian model, of parallel axes or tilted.

Read `loop` first: a step. CONTACT FORCES are found in `contacts` (their predictor, laws and corrector) and given to
bodies in `kick`; FRICTION is in `friction`, THE CAGE in `fem.kernels.cage`. `state` has all arrays.
"""

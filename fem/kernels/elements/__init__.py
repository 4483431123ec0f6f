"""Elastic bodies of finite elements: all nodes of rollers and rings, in long vectors.

Read `loop` first: a step. CONTACT FORCES are in `contacts` (in `points` where pressures are resolved, in `tilted` where
rollers tilt), FRICTION in `friction`, THE CAGE in `fem.kernels.cage`. `state` has all arrays.
"""

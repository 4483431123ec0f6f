"""Ranges read off the paper's figures 6 to 11; ranges, not data.

Source: Rubio, García Prada, Castejón, Laniado (IFToMM 2007).
"""

INNER_X = -80e-6, 60e-6  # m, figure 6
INNER_Y = -220e-6, -80e-6  # m
ROLLER_RHO = 22.98e-3, 23.08e-3  # m, figure 7
ROLLER_VELOCITY = -0.4, 0.4  # m/s
ROLLER_ACCELERATION = -5e3, 5e3  # m/s²
ERROR_FORCE = -3000.0, 3000.0  # N, figures 8 and 9, around 0 and around the load
PEAK = 22.0  # Hz, figures 10 and 11

"""Ratings of a cylindrical roller bearing by the standards' and the makers' formulas: numbers of a machine's designer.

capacity            ISO 281 C, ISO 76 C0, fatigue load limit; static safety
life                L10, reliability, viscosity ratio, a_ISO; duty cycles
reference_life      ISO/TS 16281: life of rollers in laminae under any load distribution
contact_stress      Hertz's pressure and the stresses below it
friction            torque by SKF's and Palmgren's models, heat, temperature
stiffness           2 × 2 matrices of the hub over a pitch of the rollers, damping, springs in series
run_loads           load, roller loads and dissipation of a run
sources             where each formula comes from, and which constants are second hand

Needs numpy only. Units are those of the standards, mm, N, MPa and 1/min, unless said.
"""

"""Ratings of a rolling bearing by the standards' and the makers' formulas: numbers of a machine's designer.

Read `life` first (ISO 281, ISO 76), then `reference_life` (ISO/TS 16281, a run's loads); `sources` says where each
formula comes from, and which constants are second hand. Units are the standards', mm, N, MPa and 1/min, unless said.
"""

"""Finite elements: `plan` (all decided before the first step), `start`, `arrays`, `tilted` (rollers that tilt)."""

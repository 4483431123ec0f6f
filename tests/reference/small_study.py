"""A study to be tried quickly: two speeds, a millisecond each of the Lagrangian model."""

TWO_SPEEDS = """
[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
[parameters]
"operation.speed_rpm" = [1500, 3000]
[keep]
quantities = ["hub_mean_y"]
"""

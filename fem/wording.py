"""Sentences that runs of both models end with."""

import numpy as np


def statics_lines(hub_x: float, hub_y: float, inner_force: np.ndarray) -> list[str]:
    """A static equilibrium: hub, m, and the loaded rollers' forces, N."""
    loads = ", ".join(f"{value:.1f}" for value in sorted(inner_force[inner_force > 0.0], reverse=True))
    return [
        f"Static equilibrium: hub x {1e6 * hub_x:.4f} µm, y {1e6 * hub_y:.4f} µm",
        f"Loaded rollers: {loads or 'none'} N",
    ]


def run_line(duration: float, wall: float, steps: int, imbalance: float, reference: str) -> str:
    """A finished run: simulated time, s, wall time, s, and the energy imbalance over a reference energy."""
    return (
        f"{1e3 * duration:g} ms in {wall:.2f} s ({steps} steps), energy imbalance {imbalance:+.1e} of the {reference} "
        "energy"
    )

"""How stiff a bearing is that nothing loads, from statics alone."""

from dataclasses import replace

from lagrange import Bearing, ContactLaws, Operation, static_equilibrium


def stiffness_without_load(bearing: Bearing, operation: Operation, laws: ContactLaws, push: float) -> float:
    """Secant stiffness, N/m, of the hub between a push and a pull of so many N from the side."""
    still = replace(operation, history=None, radial_load=0.0, side_load=0.0)
    low, high = (static_equilibrium(bearing, replace(still, side_load=side), laws).x for side in (-push, push))
    return 2.0 * push / (high - low)

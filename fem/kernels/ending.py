"""How a time loop ends: what it returns, and what ends it before its time."""

from fem.kernels.jit import part

DONE, NOT_FINITE = 0, 1
FASTEST = 1e5  # m/s; no body is faster unless the run has blown up


@part
def lost(hub_velocity, rollers):
    """The first body whose velocity is not a number or absurd, or −2."""
    if not abs(hub_velocity[0]) + abs(hub_velocity[1]) < FASTEST:
        return -1
    for j in range(rollers.n):
        if not abs(rollers.velocity[0, j]) + abs(rollers.velocity[1, j]) < FASTEST:
            return j
    return -2

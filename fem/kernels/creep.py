"""Carter's creep below Coulomb's limit."""

from fem.kernels.jit import part
from fem.kernels.lanes import magnitude, root, select, with_sign

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)


@part
def creep_traction(slip, limit, full_slip, mobility_dt):
    """Traction, N, that opposes a slip velocity, and the slip it leaves, m/s; scalars or lanes.

    Carter's law T = limit·(1 − (1 − v/v_full)²) up to v_full, then `limit`; solved implicitly for the velocity after
    the step, v = slip − mobility·dt·T(v), so that no stiffness limits the step.

    Parameters
    ----------
    limit : N, μQ; full_slip : m/s; mobility_dt : m/s per N

    Source: Carter, On the action of a locomotive driving wheel (1926); Johnson, Contact Mechanics (1985), chapter 8.
    """
    v = magnitude(slip)
    k = mobility_dt * limit / full_slip
    x = v / full_slip
    sliding = x >= 1.0 + k
    b = 1.0 + 2.0 * k
    x = 2.0 * x / (b + root(select(sliding, 0.0, b * b - 4.0 * k * x)))
    traction = select(sliding, limit, limit * x * (2.0 - x))
    left = select(sliding, v - mobility_dt * limit, x * full_slip)
    return with_sign(traction, slip), with_sign(left, slip)

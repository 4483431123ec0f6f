"""What the time loop asks of every further body: one that is neither roller nor ring nor hub."""

from fem.kernels.jit import every, part, verb

DONE, NOT_FINITE = 0, 1
TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken, see `rigid.kick`
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


@part
def rescale_kick(before, after, k, back):
    """Change the velocities before and after a kick to those of another step length."""
    gained = after[k] - before[k]
    before[k] += back * gained
    after[k] -= back * gained


@verb
def kick_body(body, drive):
    """Advance a body's velocities by one step: its weight, and the impulses of pairs, which are then cleared."""


@verb
def drift_body(body, drive):
    """Advance a body's positions by one step."""


@verb
def take_late(body):
    """Take the impulses of pairs that have come after a body's kick."""


@verb
def end_kick(body, drive):
    """Conclude a kick in which a body's velocities are those after it."""


@verb
def prepare(body):
    """Give an elastic ring's held row the velocity of the body that carries it."""


@verb
def calm_body(body):
    """Give what an elastic ring's row has of a body's motion to its calmed velocities."""


@verb
def slow_body(body, drive):
    """Find what the reciprocal mass adds to a body's motion in the next step."""


@part
def remember_slowed(slowed, x, y):
    """What the reciprocal mass adds in the next step, m, after that of the last one; (2, 2)."""
    slowed[0, 0], slowed[0, 1] = slowed[1, 0], slowed[1, 1]
    slowed[1, 0], slowed[1, 1] = x, y


@verb
def add_motion(body, drive, out, kinetic):
    """Add a body's kinetic energy at the kick just made, J, to out[kinetic]; its work of gravity, what it dissipates
    and its own numbers to their places."""


kick_others, drift_others, add_all_motion = every(kick_body), every(drift_body), every(add_motion)
take_all_late, end_kicks = every(take_late), every(end_kick)
prepare_others, calm_others, slow_others = every(prepare), every(calm_body), every(slow_body)

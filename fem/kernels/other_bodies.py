"""What the time loop asks of every further body: one that is neither roller nor ring nor hub."""

from fem.kernels.jit import every, verb


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
def add_motion(body, drive, out, kinetic):
    """Add a body's kinetic energy at the kick just made, J, to out[kinetic]; its work of gravity, what it dissipates
    and its own numbers to their places."""


kick_others, drift_others, add_all_motion = every(kick_body), every(drift_body), every(add_motion)
take_all_late, end_kicks = every(take_late), every(end_kick)

"""What the time loop asks of every further body: one that is neither roller nor ring nor hub."""

from fem.kernels.jit import every, verb


@verb
def kick_body(body, drive):
    """Advance a body's velocities by one step: its weight, and the impulses of pairs, which are then cleared."""


@verb
def drift_body(body, drive):
    """Advance a body's positions by one step."""


@verb
def add_motion(body, drive, out, kinetic):
    """Add a body's kinetic energy at the kick just made, J, to out[kinetic]."""


@verb
def write_body(body, drive, out):
    """Put what a sample tells of a body beyond that into `out`: works, and columns of its own from its first one on."""


kick_others, drift_others, add_all_motion = every(kick_body), every(drift_body), every(add_motion)
write_others = every(write_body)

"""The hub: its kick and its motion."""

from fem.kernels import ring_kernels
from fem.kernels.course_kernels import is_turning, with_aside
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine


@part
def kick_hub(inner, drive, aside, radial_load, scratch):
    """The hub's kick by contacts, the reaction of the ring's held row, load along x and against y, and weight.

    Returns the moment about the origin of contacts and load on the hub, N m s.
    """
    dt, hub, velocity, impulse = drive.dt, drive.hub, drive.velocity, drive.impulse
    ring_kernels.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = ring_kernels.resultant(scratch.bore, inner.cosines, inner.sines)
    c, s = drive.frame[1], drive.frame[2]
    node_mass = inner.row_mass[inner.held]
    moment = hub[0] * (impulse[1] - radial_load * dt) - hub[1] * impulse[0]
    moment = with_aside(drive.course, moment, -hub[1] * aside * dt)
    pushed = with_aside(drive.course, node_mass * (c * x - s * y) + impulse[0], aside * dt)
    velocity[0] += pushed / drive.mass
    velocity[1] += (node_mass * (s * x + c * y) + impulse[1] - radial_load * dt) / drive.mass - drive.gravity * dt
    return moment


@part
def move_hub(inner, drive, step):
    """Move the hub and turn it by `step`, rad, and the inner ring's held row with it."""
    hub, frame = drive.hub, drive.frame
    hub[0] += drive.dt * drive.velocity[0] + drive.slowed[1, 0]
    hub[1] += drive.dt * drive.velocity[1] + drive.slowed[1, 1]
    if is_turning(drive.course, drive):
        frame[0] += step
        frame[1], frame[2] = cosine_and_sine(frame[0])
    c, s = frame[1], frame[2]
    x, y = c * hub[0] + s * hub[1], c * hub[1] - s * hub[0]
    ring_kernels.set_rigid(inner.u, 2 * inner.held * inner.cosines.size, inner.cosines, inner.sines, x, y)

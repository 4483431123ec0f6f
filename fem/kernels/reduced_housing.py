"""The outer ring of the reduced model in a housing that moves: the finite elements' `housing_kernels`, without a mesh.

Where the ground holds the ring the housing is None: its place and motion are 0, and nothing is compiled.
"""

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.housing_kernels import PLACE_X, PLACE_Y, STORED, Housing, Resonator
from fem.kernels.jit import verb
from fem.kernels.rigid_parts import TWELFTH, accelerate, change_step, drift_part, kick_part, rescale_kick, write_part
from fem.kernels.sample_kernels import CONTACT, KINETIC
from fem.kernels.shaft import give_way, mobility


@verb
def ring_place(housing):
    """Of the outer ring's centre, m."""
    return 0.0, 0.0


@ring_place.of(Housing)
def _ring_place(housing):
    return housing.place[0], housing.place[1]


@verb
def ring_velocity(housing):
    """Before its kick, m/s."""
    return 0.0, 0.0


@ring_velocity.of(Housing)
def _ring_velocity(housing):
    return housing.velocity[0], housing.velocity[1]


@verb
def ring_rates(housing):
    """Before and after its kick, m/s, as pairs."""
    return (0.0, 0.0), (0.0, 0.0)


@ring_rates.of(Housing)
def _ring_rates(housing):
    return (housing.before[0], housing.before[1]), (housing.velocity[0], housing.velocity[1])


@verb
def ring_acceleration(housing, before):
    """By forces that have a potential, m/s²."""
    return 0.0, 0.0


@ring_acceleration.of(Housing)
def _ring_acceleration(housing, before):
    return before.ring_acceleration[0], before.ring_acceleration[1]


@accelerate.of(Housing)
def _accelerate(housing, step, push):
    before = step.before
    before.ring_acceleration[0] = (push[2] - housing.stiffness * housing.place[0]) / housing.mass
    before.ring_acceleration[1] = (push[3] - housing.stiffness * housing.place[1]) / housing.mass - step.drive.gravity


@kick_part.of(Housing)
def _kick(housing, step, push):
    """The kick by contacts on the ring, by springs that are taken ahead as the contacts' forces are, and by weight."""
    before, dt = step.before, step.drive.dt
    ahead = TWELFTH * dt * dt * housing.stiffness
    housing.impulse[0] += dt * (push[2] - ahead * before.ring_acceleration[0])
    housing.impulse[1] += dt * (push[3] - ahead * before.ring_acceleration[1])
    kick_body(housing, step.drive)


@verb
def push_ring(housing, x, y, dt):
    """Add the forces of the contacts' dampers, N."""


@push_ring.of(Housing)
def _push_ring(housing, x, y, dt):
    over = mobility(housing, housing.mass, dt)
    gained = over * x, over * y
    for k in range(2):
        housing.velocity[k] += gained[k]
        give_way(housing, k, gained[k])


@drift_part.of(Housing)
def _drift(housing, step):
    drift_body(housing, step.drive)


@write_part.of(Housing)
def _write(housing, step, out):
    """The place that its springs' force is taken at, and what steps conserve beside: see `reduced_samples`."""
    drive = step.drive
    add_motion(housing, drive, out, KINETIC)
    a, square = step.before.ring_acceleration, drive.dt * drive.dt
    out[CONTACT] += square / 24.0 * housing.mass * (a[0] * a[0] + a[1] * a[1] + 2.0 * drive.gravity * a[1])
    ahead = TWELFTH * square
    x, y = housing.place[0] + ahead * a[0], housing.place[1] + ahead * a[1]
    out[housing.column + PLACE_X], out[housing.column + PLACE_Y] = x, y
    out[housing.column + STORED] = 0.5 * housing.stiffness * (x * x + y * y)


@change_step.of(Housing)
def _change(housing, step, change):
    """The housing's motion, as the hub's, and then that of a sensor on it."""
    dt, next_ = step.drive.dt, change.drive.dt
    for k in range(2):
        housing.place[k] += change.shift * step.before.ring_acceleration[k]
        moved = dt * housing.before[k]
        rescale_kick(housing.before, housing.velocity, k, change.back)
        housing.dissipated[0] -= 0.5 * housing.drag[k] * (moved - next_ * housing.before[k])
    _sense_anew(housing.sensor, change, (housing.velocity[1] - housing.before[1]) / next_)


@verb
def _sense_anew(sensor, change, pushed):
    """From half an old step before to half a new one before: there and back under the acceleration `pushed`, m/s²."""


@_sense_anew.of(Resonator)
def _sense_by(sensor, change, pushed):
    motion, half, whole = sensor.motion, sensor.half_step, change.half_step
    x = half[0, 0] * motion[0] + half[0, 1] * motion[1] + (half[0, 2] - whole[0, 2]) * pushed
    y = half[1, 0] * motion[0] + half[1, 1] * motion[1] + (half[1, 2] - whole[1, 2]) * pushed
    size = whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0]
    motion[0] = (whole[1, 1] * x - whole[0, 1] * y) / size
    motion[1] = (whole[0, 0] * y - whole[1, 0] * x) / size
    for i in range(2):
        for k in range(3):
            sensor.step[i, k], sensor.half_step[i, k] = change.step[i, k], change.half_step[i, k]

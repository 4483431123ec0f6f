"""Hub, shaft, housing and cage in the loop of rigid bodies: what holds hub and outer ring, THE CAGE's kick.

What these bodies are stands in `shaft`, `housing_kernels`, `cage`. A housing that is None has the
ground in its place: its motion is 0, and nothing is compiled.
"""

from fem.kernels.bodies import TWELFTH, add_motion, kick_body, rescale_kick
from fem.kernels.cage import push_ring_as_a_whole, rub
from fem.kernels.housing_kernels import PLACE_X, PLACE_Y, STORED
from fem.kernels.jit import part
from fem.kernels.sample_kernels import CONTACT, KINETIC
from fem.kernels.shaft import give_way, mobility, pull, settle


@part
def ring_place(housing):
    """Of the outer ring's centre, m."""
    if housing is None:
        return 0.0, 0.0
    return housing.place[0], housing.place[1]


@part
def ring_rates(housing):
    """Velocities of the outer ring before and after its kick, m/s, as pairs."""
    if housing is None:
        return (0.0, 0.0), (0.0, 0.0)
    return (housing.before[0], housing.before[1]), (housing.velocity[0], housing.velocity[1])


@part
def ring_acceleration(housing, before):
    """Of the outer ring by forces that have a potential, m/s²."""
    if housing is None:
        return 0.0, 0.0
    return before.ring_acceleration[0], before.ring_acceleration[1]


@part
def push_hub(bodies, x, y, dt):
    """Kick the hub by forces, N, that are found after the shaft's dashpots."""
    over = mobility(bodies.shaft, bodies.hub_mass, dt)
    gained = over * x, over * y
    for k in range(2):
        bodies.hub_velocity[k] += gained[k]
        give_way(bodies.shaft, k, gained[k])


@part
def push_ring(housing, x, y, dt):
    """Kick the outer ring by forces, N, that are found after the housing's dashpots."""
    if housing is not None:
        over = mobility(housing, housing.mass, dt)
        gained = over * x, over * y
        for k in range(2):
            housing.velocity[k] += gained[k]
            give_way(housing, k, gained[k])


@part
def kick_shaft(shaft, step):
    """The kick of springs that are taken ahead as the contacts' forces are: see `kick`."""
    dt, acceleration, place = step.drive.dt, step.before.hub_acceleration, shaft.place
    ahead = TWELFTH * dt * dt
    pull(shaft, dt, place[0] + ahead * acceleration[0], place[1] + ahead * acceleration[1])


@part
def change_shaft(shaft, step, change):
    velocity = step.before.hub_velocity
    for k in range(2):
        shaft.dissipated[0] -= 0.5 * shaft.drag[k] * (step.drive.dt * shaft.before[k] - change.drive.dt * velocity[k])
        shaft.before[k] = velocity[k]


@part
def accelerate_ring(housing, step, push):
    """`push` : N, of the raceways' contacts on hub and outer ring: x, y, x, y."""
    before = step.before
    before.ring_acceleration[0] = (push[2] - housing.stiffness * housing.place[0]) / housing.mass
    before.ring_acceleration[1] = (push[3] - housing.stiffness * housing.place[1]) / housing.mass - step.drive.gravity


@part
def kick_ring(housing, step, push):
    """The kick by contacts on the ring, by springs that are taken ahead as the contacts' forces are, and by weight."""
    before, dt = step.before, step.drive.dt
    ahead = TWELFTH * dt * dt * housing.stiffness
    housing.impulse[0] += dt * (push[2] - ahead * before.ring_acceleration[0])
    housing.impulse[1] += dt * (push[3] - ahead * before.ring_acceleration[1])
    kick_body(housing, step.drive)


@part
def write_ring(housing, step, out):
    """The place that its springs' force is taken at, and what steps conserve beside: see `samples`."""
    drive = step.drive
    add_motion(housing, drive, out, KINETIC)
    a, square = step.before.ring_acceleration, drive.dt * drive.dt
    out[CONTACT] += square / 24.0 * housing.mass * (a[0] * a[0] + a[1] * a[1] + 2.0 * drive.gravity * a[1])
    ahead = TWELFTH * square
    x, y = housing.place[0] + ahead * a[0], housing.place[1] + ahead * a[1]
    out[housing.column + PLACE_X], out[housing.column + PLACE_Y] = x, y
    out[housing.column + STORED] = 0.5 * housing.stiffness * (x * x + y * y)


@part
def change_ring(housing, step, change):
    """The housing's motion, as the hub's, and then that of a sensor on it.

    The sensor goes from half an old step before to half a new one before: there and back under one acceleration.
    """
    dt, next_ = step.drive.dt, change.drive.dt
    for k in range(2):
        housing.place[k] += change.shift * step.before.ring_acceleration[k]
        moved = dt * housing.before[k]
        rescale_kick(housing.before, housing.velocity, k, change.back)
        housing.dissipated[0] -= 0.5 * housing.drag[k] * (moved - next_ * housing.before[k])
    sensor = housing.sensor
    if sensor is not None:
        pushed = (housing.velocity[1] - housing.before[1]) / next_
        motion, half, whole = sensor.motion, sensor.half_step, change.half_step
        x = half[0, 0] * motion[0] + half[0, 1] * motion[1] + (half[0, 2] - whole[0, 2]) * pushed
        y = half[1, 0] * motion[0] + half[1, 1] * motion[1] + (half[1, 2] - whole[1, 2]) * pushed
        size = whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0]
        motion[0] = (whole[1, 1] * x - whole[0, 1] * y) / size
        motion[1] = (whole[0, 0] * y - whole[1, 0] * x) / size
        for i in range(2):
            for k in range(3):
                sensor.step[i, k], sensor.half_step[i, k] = change.step[i, k], change.half_step[i, k]


@part
def kick_cage(pair, step):
    """The cage's kick, and its forces on rollers and guiding ring, whose dashpots take their share of it."""
    bodies, drive, riders = step.bodies, step.drive, pair.riders
    over = 1.0 / bodies.mass
    for component in range(2):
        for j in range(bodies.n):
            bodies.velocity[component, j] += riders.body_impulse[component, j] * over
            riders.body_impulse[component, j] = 0.0
    push_ring_as_a_whole(pair.ring)
    kick_body(pair.cage, drive)
    rub(pair, drive.dt)
    for j in range(bodies.n):
        bodies.spin[j] += riders.turn_kick[j]
        riders.turn_kick[j] = 0.0
    if bodies.prescribed is not None:  # the work of what keeps the rollers' spin against what rubs on them
        for j in range(bodies.n):
            drive.sums[1] += drive.dt * pair.cage.pockets.given[1, j] * riders.radius * riders.spin[j]
    if pair.ring is not None:
        drive.sums[1] -= pair.ring.speed[0] * pair.ring.rubbed[2]
        settle(bodies.shaft, drive.dt)
        settle(bodies.housing, drive.dt)


@part
def change_cage(pair, step, change):
    """Works of its contacts' last step end by its next velocities, and so does its drag's."""
    motion = pair.cage.motion
    for i in range(3):
        rescale_kick(motion[2], motion[1], i, change.back)
    pair.cage.drag[0] *= change.drive.dt / step.drive.dt

"""The outer ring of the reduced model in a housing that moves: the finite elements' `housing_kernels`, without a mesh.

Where the ground holds the ring the housing is None: its place and motion are 0, and nothing is compiled.
"""

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.housing_kernels import PLACE_X, PLACE_Y, STORED, Housing
from fem.kernels.jit import verb
from fem.kernels.sample_kernels import CONTACT, KINETIC
from fem.kernels.shaft import give_way, mobility, settle

TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken, see `reduced_kick`


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


@verb
def accelerate_ring(housing, before, x, y, gravity):
    """Find that of a housing whose ring the contacts push by x and y, N."""


@accelerate_ring.of(Housing)
def _accelerate_ring(housing, before, x, y, gravity):
    before.ring_acceleration[0] = (x - housing.stiffness * housing.place[0]) / housing.mass
    before.ring_acceleration[1] = (y - housing.stiffness * housing.place[1]) / housing.mass - gravity


@verb
def kick_ring(housing, before, drive, x, y):
    """The kick of a housing whose ring the contacts push by x and y, N; springs ahead as the contacts' forces are."""


@kick_ring.of(Housing)
def _kick_ring(housing, before, drive, x, y):
    ahead = TWELFTH * drive.dt * drive.dt * housing.stiffness
    housing.impulse[0] += drive.dt * (x - ahead * before.ring_acceleration[0])
    housing.impulse[1] += drive.dt * (y - ahead * before.ring_acceleration[1])
    kick_body(housing, drive)


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


@verb
def settle_ring(housing, dt):
    """Let its dashpots take their share of what a cage has given it since its kick."""


@settle_ring.of(Housing)
def _settle_ring(housing, dt):
    settle(housing, dt)


@verb
def drift_ring(housing, drive):
    """Move the housing on."""


@drift_ring.of(Housing)
def _drift_ring(housing, drive):
    drift_body(housing, drive)


@verb
def write_ring(housing, before, drive, out):
    """Add the housing to a sample, at the place that its springs' force is taken at, and what steps conserve beside.

    See `reduced_samples`.
    """


@write_ring.of(Housing)
def _write_ring(housing, before, drive, out):
    add_motion(housing, drive, out, KINETIC)
    a, square = before.ring_acceleration, drive.dt * drive.dt
    out[CONTACT] += square / 24.0 * housing.mass * (a[0] * a[0] + a[1] * a[1] + 2.0 * drive.gravity * a[1])
    ahead = TWELFTH * square
    x, y = housing.place[0] + ahead * a[0], housing.place[1] + ahead * a[1]
    out[housing.column + PLACE_X], out[housing.column + PLACE_Y] = x, y
    out[housing.column + STORED] = 0.5 * housing.stiffness * (x * x + y * y)

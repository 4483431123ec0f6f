"""A housing that moves the outer ring of the Lagrangian model, on lanes.

All places are from the outer ring's centre, which the housing carries, so that contacts are as on the ground; that
frame does not turn, but it accelerates, and takes as much from every body's acceleration. z is an array of two: the hub
from the ring's centre, and the ring.

Free elements obey Newton's laws, and so does the whole. What holds kinematic angles turns about the ring's centre and
stands outside: its forces on the elements, N_j along the circle, have no counterpart on hub or ring. Their power is

    Σ N_j (ω ρ_j + t_j·Ż),    N_j = m (2 ρ̇_j ω + ρ_j ω̇ + t_j·(Z̈ + g e_y)) − the contacts' force along t_j

Its terms of the first kind are those on the ground but for Z̈; all that goes with ρ̇_j or is a rate of the state is
integrated by parts, which leaves S·Ż − L·Z̈ with S and L of positions alone, and what `lagrange.stepping.held_energy`
tells of a state.
Around at least three equally spaced elements Σ (r·Ż)(t·Ż) = 0 and Σ (t·Ż)² = ½ N_b |Ż|².

Where the ground holds the ring the housing is None and nothing of this is compiled.
"""

from math import exp, expm1

from fem.kernels.drive import GAIN
from fem.kernels.jit import part, verb
from fem.kernels.lagrangian_axes import load_own, own_axes, store_own
from fem.kernels.lagrangian_state import IdealHousing
from fem.kernels.lanes import WIDTH, splat, total
from fem.kernels.state import Course


@verb
def no_sums(housing):
    """Sums over elements, as pairs along x and y: force on the ring, N; places; forces along the circle, N."""
    return 0.0


@no_sums.of(IdealHousing)
def _no_sums(housing):
    return splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)


@verb
def add_sums(housing, sums, axes, out, on_ring, along):
    """Add eight elements, so far out on their first axes, m, with their forces along their own axes, N."""
    return sums


@add_sums.of(IdealHousing)
def _add_sums(housing, sums, axes, out, on_ring, along):
    c, s = axes
    x, y = on_ring
    return (
        sums[0] + c * x - s * y,
        sums[1] + s * x + c * y,
        sums[2] + c * out,
        sums[3] + s * out,
        sums[4] - s * along,
        sums[5] + c * along,
    )


@verb
def place_of_ring(housing, k):
    """Of the outer ring's centre along an axis, m."""
    return 0.0


@place_of_ring.of(IdealHousing)
def _place_of_ring(housing, k):
    return housing.motion[0, k]


@verb
def _cage_gain(course):
    """Of the cage's speed, rad/s²."""
    return 0.0


@_cage_gain.of(Course)
def _cage_gain_now(course):
    return course.cage * course.now[GAIN]


@part
def _less(bearing, array, row, turned, x, y):
    """Take a vector of the fixed axes from one of every element, a row of theirs along their own axes."""
    columns = bearing.columns
    for group in range(0, bearing.n, WIDTH):
        c, s = own_axes(bearing.first, group, columns, turned)
        along, aside = load_own(bearing.first, array, row, group, columns)
        along, aside = along - (c * x + s * y), aside - (c * y - s * x)
        store_own(bearing.first, array, row, group, columns, along, aside)


@verb
def carry_frame(housing, motion, bearing, sums, turned, turning):
    """Accelerate the housing, and take that from hub and elements; power that held angles take up from it, W.

    `turned`, `turning` : cosine and sine of the own axes' angle, and their speed, rad/s
    """
    return 0.0


@carry_frame.of(IdealHousing)
def _carry_frame(housing, motion, bearing, sums, turned, turning):
    place, mass = housing.motion, housing.mass
    x = (total(sums[0]) - housing.stiffness * place[0, 0]) / mass
    y = (total(sums[1]) - housing.stiffness * place[0, 1]) / mass - bearing.gravity
    housing.motion[2, 0], housing.motion[2, 1] = x, y
    motion.hub[2, 0] -= x
    motion.hub[2, 1] -= y
    _less(bearing, motion.elements, 2, turned, x, y)
    housing.turned[0], housing.turned[1] = turned
    if bearing.first is None:
        return 0.0
    m, gain = bearing.mass, _cage_gain(bearing.course)
    qx, qy = m * total(sums[2]), m * total(sums[3])
    housing.lever[0], housing.lever[1] = -turning * qy, turning * qx
    square = 2.0 * turning * turning
    housing.shift[0] = square * qx + gain * qy - total(sums[4])
    housing.shift[1] = square * qy - gain * qx - total(sums[5]) + 0.5 * bearing.n * m * bearing.gravity
    return -(x * housing.lever[0] + y * housing.lever[1])


@verb
def damp_frame(housing, dampers, bearing, sums, ahead):
    """What the contacts' dampers do to the housing, so many seconds ahead, as `carry_frame`."""
    return 0.0


@damp_frame.of(IdealHousing)
def _damp_frame(housing, dampers, bearing, sums, ahead):
    x, y = total(sums[0]) / housing.mass, total(sums[1]) / housing.mass
    vx = housing.motion[1, 0] + ahead * housing.damped[0]
    vy = housing.motion[1, 1] + ahead * housing.damped[1]
    housing.damped[0], housing.damped[1] = x, y
    dampers.hub[0] -= x
    dampers.hub[1] -= y
    _less(bearing, dampers.elements, 0, housing.turned, x, y)
    if bearing.first is None:
        return 0.0
    return -(vx * total(sums[4]) + vy * total(sums[5])) - (x * housing.lever[0] + y * housing.lever[1])


@verb
def push_damped(housing, seconds):
    """What the contacts' dampers make of the housing's velocity."""


@push_damped.of(IdealHousing)
def _push_damped(housing, seconds):
    for k in range(2):
        housing.motion[1, k] += seconds * housing.damped[k]


@verb
def kick_housing(housing, seconds):
    """The housing's kick; what held angles take up with its velocity, J."""
    return 0.0


@kick_housing.of(IdealHousing)
def _kick_housing(housing, seconds):
    power = 0.0
    for k in range(2):
        housing.motion[1, k] += seconds * housing.motion[2, k]
        power += (housing.motion[1, k] - 0.5 * seconds * housing.motion[2, k]) * housing.shift[k]
    return seconds * power


@verb
def drift_housing(housing, seconds):
    """Move the housing on."""


@drift_housing.of(IdealHousing)
def _drift_housing(housing, seconds):
    for k in range(2):
        housing.motion[0, k] += seconds * housing.motion[1, k]


@verb
def velocity_of_ring(housing):
    """Along x and y, m/s."""
    return 0.0, 0.0


@velocity_of_ring.of(IdealHousing)
def _velocity_of_ring(housing):
    return housing.motion[1, 0], housing.motion[1, 1]


@verb
def give_ring(housing, motion, bearing, gained):
    """Let a ring that guides a cage have what that has given it, m/s, which all others lose as seen from the ring."""


@give_ring.of(IdealHousing)
def _give_ring(housing, motion, bearing, gained):
    for k in range(2):
        housing.motion[1, k] += gained[k]
        motion.hub[1, k] -= gained[k]
    _less(bearing, motion.elements, 1, (1.0, 0.0), gained[0], gained[1])  # of free elements, on the fixed axes
    gained[0], gained[1] = 0.0, 0.0


@verb
def carry_cage(housing, pair, before):
    """Take from a free cage what the housing's velocity has gained since it was `before`, m/s."""


@carry_cage.of(IdealHousing)
def _carry_cage(housing, pair, before):
    if pair is not None:
        for k in range(2):
            pair.cage.motion[1, k] -= housing.motion[1, k] - before[k]


@verb
def sense(housing, before, near, seconds):
    """Move a sensor on by a step, in which the housing's velocity was so before, m/s; `near` a fault, 1, or far, 0."""


@sense.of(IdealHousing)
def _sense(housing, before, near, seconds):
    if seconds > 0.0:
        acceleration = (housing.motion[1, 1] - before[1]) / seconds
        r, rate, step = housing.sensor[0], housing.sensor[1], housing.sensor_step
        for k in range(2):
            moved = step[near, k, 0] * r + step[near, k, 1] * rate
            housing.sensor[k] = moved + step[near, k, 2] * acceleration


@part
def _flow(rate, mass, velocity, acceleration, seconds):
    """`lagrange.mounting.flow` along an axis."""
    if rate == 0.0:
        return velocity, 0.0
    left, before = exp(-rate * seconds), velocity - seconds * acceleration
    slower = left * before - expm1(-rate * seconds) / rate * acceleration
    return slower, -0.5 * mass * (slower - velocity) * (before + slower)


@part
def slow(springs, housing, motion, bearing, seconds):
    """A kick so long, just made, had the dashpots of shaft and housing acted as well; exact at any strength.

    Returns what these take, and what held angles take up from that, J.
    """
    lost, held, hub = 0.0, 0.0, motion.hub
    if seconds > 0.0:
        for k in range(2):
            moved, speeding, change = 0.0, 0.0, 0.0
            if housing is not None:
                moved, speeding = housing.motion[1, k], housing.motion[2, k]
                rate = housing.damping / housing.mass
                housing.motion[1, k], taken = _flow(rate, housing.mass, moved, speeding, seconds)
                change = housing.motion[1, k] - moved
                lost += taken
                held += change * (0.5 * seconds * housing.shift[k] - housing.lever[k])
            whole, taken = hub[1, k] + moved, 0.0
            if springs is not None:
                rate = springs.damping / bearing.hub_mass
                whole, taken = _flow(rate, bearing.hub_mass, whole, hub[2, k] + speeding, seconds)
            lost += taken
            hub[1, k] = whole - moved - change
            _slow_elements(housing, motion, bearing, k, change)
    return lost, held


@verb
def _slow_elements(housing, motion, bearing, k, change):
    """Elements do not feel what slows the housing along an axis."""


@_slow_elements.of(IdealHousing)
def _slow_elements_of(housing, motion, bearing, k, change):
    _less(bearing, motion.elements, 1, housing.turned, change if k == 0 else 0.0, change if k == 1 else 0.0)

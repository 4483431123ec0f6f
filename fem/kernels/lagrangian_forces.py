"""Accelerations of the Lagrangian model by springs and weights at given positions, and by its dampers.

The same for held and for free elements: each has axes of its own, which turn with the cage or not at all.
"""

from math import cos, sin

from fem.kernels.drive import GAIN, SPEED, TURN, follow, load_at, with_aside
from fem.kernels.jit import part, verb
from fem.kernels.lagrangian_axes import load_own, own_axes, store_own
from fem.kernels.lagrangian_housing import add_sums, carry_frame, damp_frame, no_sums, place_of_ring
from fem.kernels.lagrangian_state import INNER, OUTER, PowerConstants
from fem.kernels.lane_functions import exponential, larger, logarithm, smaller
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, magnitude, root, select, splat, total
from fem.kernels.law import contact_force
from fem.kernels.state import Course
from fem.kernels.surfaces import lowered_ring, lowered_rollers

FARTHEST = 1e100  # m²: what is farther, or not a number, has no direction
MOST_STEPS, SETTLED = 60, 1e-10  # of Newton's method, and of a depth: what is left is of its square


@verb
def spring_force(law, depth, guess, soft):
    """Forces of eight contacts, N, by δ = A Q (B − ½ ln Q).

    `depth`: m; `guess`: N, those a little earlier; `soft`: m/N, compliance of edges in series, or None.
    """
    if soft is None:
        return contact_force(depth, law.A, law.B, law.Q_line, guess)
    return contact_force(depth, law.A, law.B + soft * (1.0 / law.A), law.Q_line, guess)


@spring_force.of(PowerConstants)
def _power_force(law, depth, guess, soft):
    closed = depth > 0.0
    own = select(closed, depth, 1.0)
    if soft is not None:
        yielding = select(closed, soft, 0.0)
        if any_lane(yielding != 0.0):
            own = _less_yielding(law, own, yielding)
    return select(closed, _power(law, own), depth - depth)  # what is not a number stays so


@part
def _power(law, depth):
    return law.stiffness * exponential(law.exponent * logarithm(depth))


@part
def _less_yielding(law, depth, soft):
    """Depths of eight closed contacts, m, less what a compliance in series takes of them: Newton's method."""
    own = depth
    for _ in range(MOST_STEPS):
        force = _power(law, own)
        step = (own + soft * force - depth) / (1.0 + soft * law.exponent * force / own)
        own = larger(own - step, 0.1 * own)
        if not any_lane(magnitude(step) > SETTLED * own):
            break
    return own


@verb
def spring_stiffness(law, force):
    """Stiffness dQ/dδ of eight contacts under forces, N/m; 0 of open ones."""
    closed = force > 0.0
    soft = law.A * (law.B - 0.5 * logarithm(select(closed, smaller(force, law.Q_line), 1.0)) - 0.5)
    return select(closed, 1.0 / soft, 0.0)


@spring_stiffness.of(PowerConstants)
def _power_stiffness(law, force):
    closed = force > 0.0
    own = select(closed, force, 1.0)
    per_depth = exponential(logarithm(law.stiffness / own) * (1.0 / law.exponent))
    return select(closed, law.exponent * own * per_depth, 0.0)


@part
def accelerate(motion, bearing, dampers, time):
    """Accelerations of hub and elements by springs and weights.

    Returns the power, W, that held angles and the drive of turning bodies take up from them.

    Source: (21)-(23) and (θ), see `lagrange.motion`.
    """
    follow(bearing.course, time, 0.0)
    columns, hub, mass = bearing.columns, motion.hub, bearing.mass
    turning, shaft, spin = speeds_of(bearing.course, bearing)
    axes_angle, shaft_angle, spin_angle = _turned_by(bearing.course, bearing, time)
    turned = cos(axes_angle), sin(axes_angle)
    rolled = cos(shaft_angle), sin(shaft_angle), cos(spin_angle), sin(spin_angle)
    speeds = shaft - turning, spin - turning, -turning
    push_x, push_y, power = splat(0.0), splat(0.0), splat(0.0)
    ring = no_sums(motion.housing)
    for group in range(0, bearing.n, WIDTH):
        there = count_from(group) < bearing.n
        c, s = axes = own_axes(bearing.first, group, columns, turned)
        x, y = load_own(bearing.first, motion.elements, 0, group, columns)
        outer_at = _from_centre(bearing.first, x, y, there)
        inner_at = _direction(x - (c * hub[0, 0] + s * hub[0, 1]), y - (c * hub[0, 1] - s * hub[0, 0]), there)
        deep_i = select(there, bearing.reach - inner_at[0], -1.0)
        deep_o = select(there, outer_at[0] - bearing.track, -1.0)
        met_i, met_o = _met(bearing.surfaces, group, rolled, axes, inner_at, outer_at)
        inner = _forces(bearing.laws[INNER], deep_i, load(motion.force, group), met_i)
        outer = _forces(bearing.laws[OUTER], deep_o, load(motion.force, columns + group), met_o)
        ix, iy, ox, oy, closing = _turned(met_i, met_o, inner, outer, speeds, inner_at, outer_at)
        store(motion.force, group, inner)
        store(motion.force, columns + group, outer)
        push_x -= inner * (c * ix - s * iy)
        push_y -= inner * (s * ix + c * iy)
        fall_x, fall_y = select(there, bearing.gravity * s, 0.0), select(there, bearing.gravity * c, 0.0)
        along = (inner * ix - outer * ox) * (1.0 / mass) + turning * turning * x - fall_x
        aside = (inner * iy - outer * oy) * (1.0 / mass) + turning * turning * y - fall_y
        store_own(bearing.first, motion.elements, 2, group, columns, along, aside)
        power += mass * turning * (x * fall_y - y * fall_x) + inner * closing[INNER] + outer * closing[OUTER]
        power = _speeding_up(bearing.course, power, mass, select(there, x, 0.0))
        ring = add_sums(
            motion.housing, ring, axes, select(there, x, 0.0), (outer * ox, outer * oy), inner * iy - outer * oy
        )
        _remember(dampers, group, columns, axes, (ix, iy, ox, oy), closing)
        _keep_coefficients(dampers, bearing.laws[INNER], group, inner, met_i)
        _keep_coefficients(dampers, bearing.laws[OUTER], columns + group, outer, met_o)
    x, y = total(push_x), total(push_y)
    aside, radial_load = load_at(bearing.course, bearing, time)
    hub[2, 0] = with_aside(bearing.course, x, aside) / bearing.hub_mass
    hub[2, 1] = (y - radial_load) / bearing.hub_mass - bearing.gravity
    _pull_back(bearing.springs, motion.housing, hub, bearing.hub_mass)
    held = total(power) + turning * (hub[0, 0] * y - hub[0, 1] * x)
    return held + carry_frame(motion.housing, motion, bearing, ring, turned, turning)


@verb
def speeds_of(course, bearing):
    """Of the elements' own axes, of the shaft and of elements about their centres, rad/s."""
    return bearing.turning, bearing.shaft, bearing.spin


@speeds_of.of(Course)
def _speeds_now(course, bearing):
    speed = course.now[SPEED]
    return course.cage * speed, speed, course.spin * speed


@verb
def _turned_by(course, bearing, time):
    """How far they have turned, rad."""
    return bearing.turning * time, bearing.shaft * time, bearing.spin * time


@_turned_by.of(Course)
def _turned_by_now(course, bearing, time):
    turn = course.now[TURN]
    return course.cage * turn, turn, course.spin * turn


@verb
def _speeding_up(course, power, mass, along):
    """Power that held elements, so far out, m, take from the cage: less what `lagrange.trajectory` adds of it."""
    return power


@_speeding_up.of(Course)
def _speeding_up_now(course, power, mass, along):
    return power - mass * course.cage * course.cage * course.now[SPEED] * course.now[GAIN] * along * along


@part
def _direction(x, y, there):
    """Length and unit vector of a way; of spare lanes, and of what is lost, some that are numbers."""
    square = x * x + y * y
    length = root(select(there, square, 1.0))
    scale, sound = 1.0 / length, there & (square < FARTHEST)
    return length, select(sound, x * scale, 1.0), select(sound, y * scale, 0.0)


@part
def _from_centre(first, x, y, there):
    """The same from the outer ring's centre."""
    if first is None:
        return _direction(x, y, there)
    return select(there, x, 1.0), splat(1.0), splat(0.0)


@part
def _met(surfaces, group, rolled, axes, inner_at, outer_at):
    """What eight elements meet of surfaces that are not perfect circles.

    Parameters
    ----------
    rolled : cosine and sine of how far the inner ring and the elements have turned
    axes : cosine and sine of the direction of the elements' first axes
    inner_at, outer_at : distance from the hub, or the outer ring's centre, and direction along the own axes

    Returns
    -------
    of the inner contacts and the outer ones, by ring and by element: minus the sinkage, m, minus its slope per rad, the
    compliance of edges, m/N, and its slope; None on perfect circles
    """
    if surfaces is None:
        return None, None
    still = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if surfaces.near[0] == 0:
        return (still, still), (still, still)
    rings, rollers = surfaces.rings, surfaces.rollers
    _, ix, iy = inner_at
    _, ox, oy = outer_at
    c, s = axes
    fx, fy, gx, gy = c * ix - s * iy, s * ix + c * iy, c * ox - s * oy, s * ox + c * oy  # along fixed axes
    rx, ry, wx, wy = rolled
    ring_i = lowered_ring(rings[INNER], 1.0, still, rx * fx + ry * fy, rx * fy - ry * fx)
    ring_o = lowered_ring(rings[OUTER], 1.0, still, gx, gy)
    own_i = lowered_rollers(rollers[INNER], group, still, -(wx * fx + wy * fy), wy * fx - wx * fy)
    own_o = lowered_rollers(rollers[OUTER], group, still, wx * gx + wy * gy, wx * gy - wy * gx)
    return (ring_i, own_i), (ring_o, own_o)


@part
def _forces(law, depth, guess, met):
    """Forces of eight contacts, N, whose circles overlap by `depth`, m."""
    if met is None:
        return spring_force(law, depth, guess, None)
    (sunk, _, soft, _), (own_sunk, _, own_soft, _) = met
    return spring_force(law, depth + sunk + own_sunk, guess, soft + own_soft)


@part
def _turned(met_i, met_o, inner, outer, speeds, inner_at, outer_at):
    """Normals along the own axes, inner and outer, and the rates at which contacts close because surfaces pass, m/s.

    `inner`, `outer` : N, forces; `speeds` : rad/s, against the own axes, of inner ring, elements and outer ring
    """
    away, ix, iy = inner_at
    rho, ox, oy = outer_at
    if met_i is None:
        return ix, iy, ox, oy, (splat(0.0), splat(0.0))
    ring_i, own_i = _slopes(met_i, inner)
    ring_o, own_o = _slopes(met_o, outer)
    tilt_i, tilt_o = (ring_i + own_i) / away, (ring_o + own_o) / rho
    closing = -(speeds[0] * ring_i + speeds[1] * own_i), -(speeds[2] * ring_o + speeds[1] * own_o)
    return ix + tilt_i * iy, iy - tilt_i * ix, ox - tilt_o * oy, oy + tilt_o * ox, closing


@part
def _slopes(met, force):
    """Minus the slopes of ring and element per rad, m, for contacts under a force, N."""
    (_, slope, _, softening), (_, own_slope, _, own_softening) = met
    half = 0.5 * force
    return slope - half * softening, own_slope - half * own_softening


@part
def _remember(dampers, group, columns, axes, normals, closing):
    """Keep of the positions what dampers need."""
    if dampers is not None:
        for k in range(2):
            store(dampers.axes, k * columns + group, axes[k])
            store(dampers.closing, k * columns + group, closing[k])
        for k in range(4):
            store(dampers.normal, k * columns + group, normals[k])


@part
def _pull_back(springs, housing, hub, mass):
    """The shaft's springs accelerate the hub."""
    if springs is not None:
        for k in range(2):
            hub[2, k] -= springs.stiffness / mass * (hub[0, k] + place_of_ring(housing, k))


@part
def _keep_coefficients(dampers, law, at, force, met):
    """N s/m of eight contacts' dampers, by their springs' forces, N, and by what they meet."""
    if dampers is not None:
        stiffness = _softened(spring_stiffness(law, force), met)
        found = dampers.constant + dampers.time * stiffness + 1.5 * dampers.hunt_crossley * force
        store(dampers.coefficient, at, found)


@part
def _softened(stiffness, met):
    """Stiffnesses of eight contacts with the compliance of edges in series, N/m."""
    if met is None:
        return stiffness
    (_, _, soft, _), (_, _, own_soft, _) = met
    return stiffness / (1.0 + (soft + own_soft) * stiffness)


@part
def damp(motion, bearing, dampers, ahead):
    """Accelerations of hub and elements by the dampers, at the positions last seen by `accelerate`.

    At velocities so many seconds `ahead` by the accelerations that dampers had before; those are overwritten. Returns
    the loss and the power that held angles and the drive take up, W.
    """
    columns, hub, before = bearing.columns, motion.hub, dampers.hub
    turning, _, _ = speeds_of(bearing.course, bearing)
    # against the turning axes
    hub_x = hub[1, 0] + ahead * before[0] + turning * hub[0, 1]
    hub_y = hub[1, 1] + ahead * before[1] - turning * hub[0, 0]
    push_x, push_y, loss, driven = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    ring = no_sums(motion.housing)
    for group in range(0, bearing.n, WIDTH):
        c, s = load(dampers.axes, group), load(dampers.axes, columns + group)
        ix, iy = load(dampers.normal, group), load(dampers.normal, columns + group)
        ox, oy = load(dampers.normal, 2 * columns + group), load(dampers.normal, 3 * columns + group)
        closing_i, closing_o = load(dampers.closing, group), load(dampers.closing, columns + group)
        vx, vy = load_own(bearing.first, motion.elements, 1, group, columns)
        slow_x, slow_y = load_own(bearing.first, dampers.elements, 0, group, columns)
        vx, vy = vx + ahead * slow_x, vy + ahead * slow_y
        rate_i = closing_i - (vx - (c * hub_x + s * hub_y)) * ix - (vy - (c * hub_y - s * hub_x)) * iy
        rate_o = closing_o + vx * ox + vy * oy
        inner = _no_pull(load(dampers.coefficient, group) * rate_i, load(motion.force, group))
        outer = _no_pull(load(dampers.coefficient, columns + group) * rate_o, load(motion.force, columns + group))
        along, aside = inner * ix - outer * ox, inner * iy - outer * oy
        per_mass = 1.0 / bearing.mass
        store_own(bearing.first, dampers.elements, 0, group, columns, along * per_mass, aside * per_mass)
        push_x -= inner * (c * ix - s * iy)
        push_y -= inner * (s * ix + c * iy)
        ring = add_sums(motion.housing, ring, (c, s), splat(0.0), (outer * ox, outer * oy), aside)
        loss += inner * rate_i + outer * rate_o
        driven += inner * closing_i + outer * closing_o
    x, y = total(push_x), total(push_y)
    before[0], before[1] = x / bearing.hub_mass, y / bearing.hub_mass
    held = total(driven) + turning * (hub[0, 0] * y - hub[0, 1] * x)
    return total(loss), held + damp_frame(motion.housing, dampers, bearing, ring, ahead)


@part
def _no_pull(damper, spring):
    """The damper's force where spring and damper together push, else what takes the spring's away."""
    return select(spring > 0.0, larger(damper, -spring), 0.0)

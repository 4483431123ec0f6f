"""Accelerations of the Lagrangian model by springs and weights at given positions, and by its dampers.

The same for held and for free elements: each has axes of its own, which turn with the cage or not at all.
"""

from math import cos, sin

from fem.kernels.drive_kernels import radial_load_at
from fem.kernels.jit import part, verb
from fem.kernels.lagrangian_state import INNER, OUTER, PowerConstants
from fem.kernels.lane_functions import exponential, larger, logarithm
from fem.kernels.law import contact_force
from fem.kernels.profile_kernels import lowered_ring, lowered_rollers
from fem.kernels.simd import WIDTH, count_from, load, root, select, splat, store, total

FARTHEST = 1e100  # m²: what is farther, or not a number, has no direction


@verb
def spring_force(law, depth, guess):
    """Forces of eight contacts, N, by δ = A Q (B − ½ ln Q); `depth`: m; `guess`: N, those a little earlier."""
    return contact_force(depth, law.A, law.B, law.Q_line, guess)


@spring_force.of(PowerConstants)
def _power_force(law, depth, guess):
    closed = depth > 0.0
    force = law.stiffness * exponential(law.exponent * logarithm(select(closed, depth, 1.0)))
    return select(closed, force, depth - depth)  # what is not a number stays so


@part
def accelerate(motion, bearing, dampers, time):
    """Accelerations of hub and elements by springs and weights.

    Returns the power, W, that held angles and the drive of turning bodies take up from them.

    Source: (21)-(23) and (θ), see `lagrange.motion`.
    """
    columns, hub, mass, turning = bearing.columns, motion.hub, bearing.mass, bearing.turning
    turned = cos(turning * time), sin(turning * time)
    rolled = cos(bearing.shaft * time), sin(bearing.shaft * time), cos(bearing.spin * time), sin(bearing.spin * time)
    speeds = bearing.shaft - turning, bearing.spin - turning, -turning
    push_x, push_y, power = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, bearing.n, WIDTH):
        there = count_from(group) < bearing.n
        c, s = axes = _axes(bearing.first, group, columns, turned)
        x, y = _load_own(bearing.first, motion.elements, 0, group, columns)
        outer_at = _from_centre(bearing.first, x, y, there)
        inner_at = _direction(x - (c * hub[0, 0] + s * hub[0, 1]), y - (c * hub[0, 1] - s * hub[0, 0]), there)
        deep_i = select(there, bearing.reach - inner_at[0], -1.0)
        deep_o = select(there, outer_at[0] - bearing.track, -1.0)
        deep_i, deep_o, ix, iy, ox, oy, closing = _on_surfaces(
            bearing.surfaces, group, speeds, rolled, axes, (deep_i, *inner_at), (deep_o, *outer_at)
        )
        inner = spring_force(bearing.laws[INNER], deep_i, load(motion.force, group))
        outer = spring_force(bearing.laws[OUTER], deep_o, load(motion.force, columns + group))
        store(motion.force, group, inner)
        store(motion.force, columns + group, outer)
        push_x -= inner * (c * ix - s * iy)
        push_y -= inner * (s * ix + c * iy)
        fall_x, fall_y = select(there, bearing.gravity * s, 0.0), select(there, bearing.gravity * c, 0.0)
        along = (inner * ix - outer * ox) * (1.0 / mass) + turning * turning * x - fall_x
        aside = (inner * iy - outer * oy) * (1.0 / mass) + turning * turning * y - fall_y
        _store_own(bearing.first, motion.elements, 2, group, columns, along, aside)
        power += mass * turning * (x * fall_y - y * fall_x) + inner * closing[INNER] + outer * closing[OUTER]
        _remember(dampers, group, columns, axes, (ix, iy, ox, oy), closing)
    x, y = total(push_x), total(push_y)
    hub[2, 0] = x / bearing.hub_mass
    hub[2, 1] = (y - radial_load_at(bearing, time)) / bearing.hub_mass - bearing.gravity
    return total(power) + turning * (hub[0, 0] * y - hub[0, 1] * x)


@part
def _axes(first, group, columns, turned):
    """Cosine and sine of the directions of eight elements' first axes."""
    if first is None:
        return splat(1.0), splat(0.0)
    c, s = load(first, group), load(first, columns + group)
    return c * turned[0] - s * turned[1], s * turned[0] + c * turned[1]


@part
def _load_own(first, array, row, group, columns):
    """Of eight elements, along their own axes; the held are on the first."""
    if first is None:
        return load(array, 2 * row * columns + group), load(array, (2 * row + 1) * columns + group)
    return load(array, row * columns + group), splat(0.0)


@part
def _store_own(first, array, row, group, columns, along, aside):
    if first is None:
        store(array, 2 * row * columns + group, along)
        store(array, (2 * row + 1) * columns + group, aside)
    else:
        store(array, row * columns + group, along)


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
def _on_surfaces(surfaces, group, speeds, rolled, axes, inner_at, outer_at):
    """What surfaces that are not perfect circles change.

    Parameters
    ----------
    speeds : rad/s, against the own axes, of inner ring, elements and outer ring
    rolled : cosine and sine of how far the inner ring and the elements have turned
    axes : cosine and sine of the direction of the elements' first axes
    inner_at, outer_at : overlap of the circles, m; distance from the hub, or the outer ring's centre, and direction
        along the own axes

    Returns
    -------
    overlaps less the sinkages, normals along the own axes, inner and outer, and the rates at which both contacts close
    because surfaces pass, m/s
    """
    inner, away, ix, iy = inner_at
    outer, rho, ox, oy = outer_at
    if surfaces is None:
        return inner, outer, ix, iy, ox, oy, (splat(0.0), splat(0.0))
    rings, rollers = surfaces
    c, s = axes
    fx, fy, gx, gy = c * ix - s * iy, s * ix + c * iy, c * ox - s * oy, s * ox + c * oy  # along fixed axes
    rx, ry, wx, wy = rolled
    zero = splat(0.0)
    # the rates are minus the slopes, per rad
    inner, ring_i = lowered_ring(rings[INNER], 1.0, inner, zero, rx * fx + ry * fy, rx * fy - ry * fx)
    outer, ring_o = lowered_ring(rings[OUTER], 1.0, outer, zero, gx, gy)
    inner, own_i = lowered_rollers(rollers[INNER], group, inner, zero, -(wx * fx + wy * fy), wy * fx - wx * fy)
    outer, own_o = lowered_rollers(rollers[OUTER], group, outer, zero, wx * gx + wy * gy, wx * gy - wy * gx)
    tilt_i, tilt_o = (ring_i + own_i) / away, (ring_o + own_o) / rho
    closing = -(speeds[0] * ring_i + speeds[1] * own_i), -(speeds[2] * ring_o + speeds[1] * own_o)
    return inner, outer, ix + tilt_i * iy, iy - tilt_i * ix, ox - tilt_o * oy, oy + tilt_o * ox, closing


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
def damp(motion, bearing, dampers, ahead):
    """Accelerations of hub and elements by the dampers, at the positions last seen by `accelerate`.

    At velocities so many seconds `ahead` by the accelerations that dampers had before; those are overwritten. Returns
    the loss and the power that held angles and the drive take up, W.
    """
    columns, turning, hub, before = bearing.columns, bearing.turning, motion.hub, dampers.hub
    # against the turning axes
    hub_x = hub[1, 0] + ahead * before[0] + turning * hub[0, 1]
    hub_y = hub[1, 1] + ahead * before[1] - turning * hub[0, 0]
    push_x, push_y, loss, driven = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, bearing.n, WIDTH):
        c, s = load(dampers.axes, group), load(dampers.axes, columns + group)
        ix, iy = load(dampers.normal, group), load(dampers.normal, columns + group)
        ox, oy = load(dampers.normal, 2 * columns + group), load(dampers.normal, 3 * columns + group)
        closing_i, closing_o = load(dampers.closing, group), load(dampers.closing, columns + group)
        vx, vy = _load_own(bearing.first, motion.elements, 1, group, columns)
        slow_x, slow_y = _load_own(bearing.first, dampers.elements, 0, group, columns)
        vx, vy = vx + ahead * slow_x, vy + ahead * slow_y
        rate_i = closing_i - (vx - (c * hub_x + s * hub_y)) * ix - (vy - (c * hub_y - s * hub_x)) * iy
        rate_o = closing_o + vx * ox + vy * oy
        inner = _no_pull(dampers.damping * rate_i, load(motion.force, group))
        outer = _no_pull(dampers.damping * rate_o, load(motion.force, columns + group))
        along, aside = inner * ix - outer * ox, inner * iy - outer * oy
        per_mass = 1.0 / bearing.mass
        _store_own(bearing.first, dampers.elements, 0, group, columns, along * per_mass, aside * per_mass)
        push_x -= inner * (c * ix - s * iy)
        push_y -= inner * (s * ix + c * iy)
        loss += inner * rate_i + outer * rate_o
        driven += inner * closing_i + outer * closing_o
    x, y = total(push_x), total(push_y)
    before[0], before[1] = x / bearing.hub_mass, y / bearing.hub_mass
    return total(loss), total(driven) + turning * (hub[0, 0] * y - hub[0, 1] * x)


@part
def _no_pull(damper, spring):
    """The damper's force where spring and damper together push, else what takes the spring's away."""
    return select(spring > 0.0, larger(damper, -spring), 0.0)

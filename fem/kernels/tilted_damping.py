"""Dampers of contacts of rollers that tilt: in proportion to the second derivatives of a contact's energy.

A contact of the coefficient c and the stiffness K = ∂Q/∂δ damps by c/K ∂²U/∂(δ, ψ)²: by c on δ̇ + z ψ̇ at the lever
z = ∂Q/∂ψ/K, and by g = c/K (−∂M/∂ψ − z² K) on ψ̇ alone. The rollers' tilts are implicit as their centres are; the
hub's slope is explicit, whose inertia is so much larger.

Equation (6) of docs/tilted_motion.md.
"""

from typing import NamedTuple

from fem.kernels.fields import room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, count_from, select, splat, total


class TiltedDampers(NamedTuple):
    """Further dampers to `reduced_state.ReducedDampers`. Arrays over rollers by row."""

    moment: state("2, columns")  # N m, of the last kick
    lever: room("2, columns")  # m, z
    turning: room("2, columns")  # N m s, g
    over_reach: float  # 1/m, over the distance of rollers' centres from the hub's
    length: float  # m, of a roller


@part
def find_levers(tilted, forces, columns, group, c_i, c_o):
    """Levers and coefficients of tilt of eight rollers' contacts that damp approaches by c, N s/m; 0 of open ones."""
    if tilted is not None:
        _find_lever(tilted, forces, group, c_i, load(forces.tilted.met, 3 * columns + group))
        _find_lever(tilted, forces, columns + group, c_o, load(forces.tilted.met, 7 * columns + group))


@part
def _find_lever(tilted, forces, at, c, cross):
    closed = c > 0.0
    over = select(closed, 1.0 / select(closed, load(forces.stiffness, at), 1.0), 0.0)
    lever = cross * over
    store(tilted.lever, at, lever)
    store(tilted.turning, at, maximum(c * (load(forces.tilted.stiffness, at) * over - lever * lever), 0.0))


@part
def pair_mobility(tilted, bodies, dt, group, facing):
    """Response of eight rollers' dampers to their own forces, inner and outer, and to the other's, times the mass."""
    if tilted is None:
        return splat(1.0), splat(1.0), facing
    columns = bodies.columns
    z_i, z_o = load(tilted.lever, group), load(tilted.lever, columns + group)
    over = bodies.mass / _held(tilted, bodies, dt, group, facing)
    near = z_i * facing
    return 1.0 + over * near * near, 1.0 + over * z_o * z_o, facing + over * near * z_o


@part
def _held(tilted, bodies, dt, group, facing):
    """Inertia of eight rollers with what their dampers of tilt take in half a step, kg m²."""
    g_i, g_o = load(tilted.turning, group), load(tilted.turning, bodies.columns + group)
    return bodies.tilts.inertia + 0.5 * dt * (g_i * facing * facing + g_o)


@part
def with_turning(tilted, bodies, forces, drive, group, motions, facing, rates):
    """Rates of eight rollers' dampers, m/s, inner and outer: of approach, `rates`, and at levers of tilt.

    `motions` : before and after the kick, see `reduced_damping.passing_rates`
    """
    if tilted is None:
        return rates
    turned, gone = _mean_turning(tilted, bodies, forces, drive, group, motions, facing, splat(0.0))
    z_i, z_o = load(tilted.lever, group), load(tilted.lever, bodies.columns + group)
    return rates[0] + z_i * (turned * facing - gone), rates[1] - z_o * turned


@part
def _mean_turning(tilted, bodies, forces, drive, group, motions, facing, push):
    """Mean tilt rate of eight rollers in a kick, rad/s, under moments of dampers at levers, N m; and of `_gone`."""
    tilts = bodies.tilts
    gone = 0.5 * (_gone(tilted, bodies, forces, group, motions[0], tilts.slope_before))
    gone += 0.5 * (_gone(tilted, bodies, forces, group, motions[1], tilts.slope_rate))
    rate = 0.5 * tilts.inertia * (load(tilts.before, group) + load(tilts.rate, group))
    push = push + load(tilted.turning, group) * facing * gone
    return (rate + 0.5 * drive.dt * push) / _held(tilted, bodies, drive.dt, group, facing), gone


@part
def _gone(tilted, bodies, forces, group, motion, slope_rate):
    """How fast the hub's slope changes along eight inner contacts' normals, rad/s, which turn as rollers go round."""
    columns, slope, (hub, velocity, _, _) = bodies.columns, bodies.tilts.slope, motion
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    aside = (load(velocity, columns + group) - hub[1]) * ix - (load(velocity, group) - hub[0]) * iy
    return slope_rate[0] * ix + slope_rate[1] * iy + (slope[1] * ix - slope[0] * iy) * aside * tilted.over_reach


@part
def turn_back(tilted, bodies, forces, drive, group, motions, facing, given):
    """Kick eight rollers' tilts by the moments of their dampers.

    `given` : N, the dampers' forces of approach, inner and outer, and forces on rollers along the inner raceway.
    Returns the last with those of slopes across normals.
    """
    F_i, F_o, along = given
    if tilted is None:
        return along
    columns, tilts = bodies.columns, bodies.tilts
    near, far = load(tilted.lever, group) * F_i, load(tilted.lever, columns + group) * F_o
    turned, gone = _mean_turning(tilted, bodies, forces, drive, group, motions, facing, far - near * facing)
    M_i = _moment(tilted, forces, group, F_i, near, turned * facing - gone)
    M_o = _moment(tilted, forces, columns + group, F_o, far, -turned)
    store(tilts.rate, group, load(tilts.rate, group) + (M_i * facing - M_o) * (drive.dt / tilts.inertia))
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    return along + M_i * (tilts.slope[0] * iy - tilts.slope[1] * ix) * tilted.over_reach


@part
def _moment(tilted, forces, at, F, push, turned):
    """Moments of eight dampers, N m, that push at levers, and of tilt within what contacts press."""
    most = 0.5 * tilted.length * (load(forces.kick, at) + F)
    M = maximum(minimum(-(load(tilted.turning, at) * turned), most), -most) - push
    store(tilted.moment, at, M)
    return M


@part
def turn_hub_back(tilted, bodies, forces, drive):
    """Kick the hub's slope by the dampers' moments."""
    if tilted is not None:
        tilts, columns = bodies.tilts, bodies.columns
        on_x, on_y = splat(0.0), splat(0.0)
        for group in range(0, bodies.n, WIDTH):
            M = select(count_from(group) < bodies.n, load(tilted.moment, group), 0.0)
            on_x -= M * load(forces.normal, group)
            on_y -= M * load(forces.normal, columns + group)
        tilts.slope_rate[0] += drive.dt * tilts.hub_over * total(on_x)
        tilts.slope_rate[1] += drive.dt * tilts.hub_over * total(on_y)


@part
def with_turning_power(tilted, bodies, forces, group, motion, after, power):
    """Power of eight rollers' dampers, W, with that of their moments, before (False) or after a kick."""
    if tilted is None:
        return power
    columns, tilts = bodies.columns, bodies.tilts
    rates, slope_rate = (tilts.rate, tilts.slope_rate) if after else (tilts.before, tilts.slope_before)
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    rate, gone = load(rates, group), _gone(tilted, bodies, forces, group, motion, slope_rate)
    M_i, M_o = load(tilted.moment, group), load(tilted.moment, columns + group)
    more = M_o * rate - M_i * (rate * (ix * ox + iy * oy) - gone)
    return power + select(count_from(group) < bodies.n, more, 0.0)


@part
def write_turning(tilted, bodies, out):
    """Moments of the dampers, by themselves and in those of the contacts, N m."""
    if tilted is not None:
        n, at = bodies.n, bodies.tilts.column + 2 * bodies.n
        for row in range(2):
            for j in range(n):
                out[at + row * n + j] += tilted.moment[row, j]
                out[at + 2 * n + 2 + row * n + j] = tilted.moment[row, j]

"""A tilted contact in the time loop: energy, force and moment of a table by approach and slope; scalars or eight lanes.

The table is `lagrange.axial.ContactTable`. Edges of spalls are compliances in series with a contact, or with either
part of one whose length spalls take a part of: equation (5) of docs/tilted_motion.md and
`lagrange.axial.table.SpalledTable`.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lanes import absolute, any_lane, gather_quads, load, select, splat, store, to_float, to_int
from fem.kernels.law import MOST_REPAID, REPAID, STANDING, spline
from lagrange.axial.table import FAINT, SPAN, ContactTable

SHORTEST = 1e-16  # m, of an approach's change, by which work is divided
MOST_OFF = 0.02  # of a closed contact's force, by which its kick may differ

MOST_STEPS, SETTLED = 60, 1e-6  # of Newton's method, and of what edges take: what is left is of its square, and taken
# of `TiltedForces.edges` and `.sunken`: what changes under a contact, and by how much its energy falls by that, over
# its force; now, and at the last kick
NOW, FALL, BEFORE, FALL_BEFORE = range(4)
SUNK, PART_EDGES = 0, 4  # of `sunken`: the part's sinkage, m, and compliance of edges, m/N, beside the whole length's


class TiltedLaw(NamedTuple):
    """A contact's table as kernels take it."""

    first_approach: float  # m
    per_approach: float  # 1/m, steps
    rows: float  # the last first row of four
    first_slope: float  # rad
    per_slope: float  # 1/rad
    columns: float  # the last first column of four
    width: int  # of a row
    coefficients: np.ndarray  # (rows, width), J^½

    @classmethod
    def of(cls, table: ContactTable) -> "TiltedLaw":
        rows, columns = table.coefficients.shape
        return cls(
            table.first_approach, 1.0 / table.approach_step, float(rows - SPAN),
            table.first_slope, 1.0 / table.slope_step, float(columns - SPAN), columns, table.coefficients,
        )  # fmt: skip


class PartProfiles(NamedTuple):
    """What the part of the length that spalls take meets besides: see `Compliance`."""

    ring_profiles: tuple
    roller_profiles: tuple


class SpalledRest(NamedTuple):
    """A contact without the part of its length that spalls take; without such a part the whole contact."""

    law: tuple  # `TiltedLaw`
    of_rest: float  # the length over that of the rest
    of_part: float  # and over that of the part; 0: there is none


@part
def force_and_stiffness(law, approach, slope):
    """U, Q, M and the second derivatives of U: ∂Q/∂δ, N/m; ∂Q/∂ψ = −∂M/∂δ, N/rad; −∂M/∂ψ, N m/rad."""
    u, d, p, dd, dp, pp = _surface(law, approach, slope)
    u = _closed(law, approach, u)
    stiffness = select(u > 0.0, 2.0 * (d * d + u * dd), 0.0)
    cross = select(u > 0.0, 2.0 * (d * p + u * dp), 0.0)
    tilt = select(u > 0.0, 2.0 * (p * p + u * pp), 0.0)
    return u * u, 2.0 * u * d, -2.0 * u * p, stiffness, cross, tilt


@part
def _closed(law, approach, u):
    return select(approach > law.first_approach, maximum(u, 0.0), 0.0)


@part
def _surface(law, approach, slope):
    """u and its derivatives u_δ, u_ψ, u_δδ, u_δψ, u_ψψ."""
    x, y = (approach - law.first_approach) * law.per_approach, (slope - law.first_slope) * law.per_slope
    # an open contact may be far from the table, a place that is not known NaN
    inside, straight = minimum(maximum(x, 0.0), law.rows + 1.0), minimum(maximum(y, 0.0), law.columns + 1.0)
    beyond, aside = x - inside, y - straight
    row, column = to_int(minimum(inside, law.rows)), to_int(minimum(straight, law.columns))
    s, t = inside - to_float(row), straight - to_float(column)
    at = row * law.width + column
    first = _spline(t, gather_quads(law.coefficients, at))
    second = _spline(t, gather_quads(law.coefficients, at + law.width))
    third = _spline(t, gather_quads(law.coefficients, at + 2 * law.width))
    fourth = _spline(t, gather_quads(law.coefficients, at + 3 * law.width))
    u, d, dd = _spline(s, (first[0], second[0], third[0], fourth[0]))
    p, dp, _ = _spline(s, (first[1], second[1], third[1], fourth[1]))
    pp, _, _ = _spline(s, (first[2], second[2], third[2], fourth[2]))
    u += d * beyond + p * aside + dp * beyond * aside
    d, p = d + dp * aside, p + dp * beyond
    over, along = law.per_approach, law.per_slope
    return u, d * over, p * along, dd * over * over, dp * over * along, pp * along * along


@part
def _spline(t, coefficients):
    """`law.spline` and its bend per knot squared."""
    r = 1.0 - t
    c0, c1, c2, c3 = coefficients
    value, slope = spline(t, coefficients)
    bend = r * c0 + (3.0 * t - 2.0) * c1 + (3.0 * r - 2.0) * c2 + t * c3
    return value, slope, bend


@part
def table_at(forces, laws, at, columns, deep, slope):
    """`force_and_stiffness` of eight contacts at edges of spalls and with part of their length over spalls."""
    table, rest = laws
    if forces.tilted.edges is None:
        return force_and_stiffness(table, deep, slope)
    if rest is None:
        found = in_series(None, table, deep, slope, load(forces.tilted.edges, at), load(forces.estimate, at))
        store(forces.tilted.edges, FALL * 2 * columns + at, 0.5 * found[1])
        return found
    sunken = forces.tilted.sunken
    if sunken is None:
        return force_and_stiffness(table, deep, slope)
    apart, edges = 2 * columns, forces.tilted.edges
    h, soft, more = load(sunken, SUNK * apart + at), load(edges, at), load(sunken, PART_EDGES * apart + at)
    share, last = load(sunken, (SUNK + FALL) * apart + at), load(forces.estimate, at)
    if not any_lane((absolute(h) > 0.0) | (absolute(soft) > FAINT) | (absolute(more) > FAINT)):
        store(edges, FALL * apart + at, splat(0.0))
        store(sunken, (SUNK + FALL) * apart + at, splat(0.0))
        store(sunken, (PART_EDGES + FALL) * apart + at, splat(0.0))
        return force_and_stiffness(table, deep, slope)
    a = in_series(None, rest.law, deep, slope, rest.of_rest * soft, (1.0 - share) * last)
    b = in_series(rest.law, table, deep - h, slope, rest.of_part * (soft + more), share * last)
    Q = a[1] + b[1]
    over = select(Q > 0.0, 1.0 / select(Q > 0.0, Q, 1.0), 0.0)
    soft_part = 0.5 * rest.of_part * b[1] * b[1] * over
    store(edges, FALL * apart + at, 0.5 * rest.of_rest * a[1] * a[1] * over + soft_part)
    store(sunken, (SUNK + FALL) * apart + at, b[1] * over)
    store(sunken, (PART_EDGES + FALL) * apart + at, soft_part)
    return a[0] + b[0], Q, a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@part
def in_series(rest, table, deep, slope, soft, last):
    """Eight contacts, less those of a rest, with compliances in series, m/N; `last` : N, forces of the last step."""
    if not any_lane(absolute(soft) > FAINT):
        return _less(rest, table, deep, slope)
    return _softer(rest, table, deep, slope, soft, last)


@part(inlined=False)
def _softer(rest, table, deep, slope, soft, last):
    """U(δ', ψ) + ½ s Q² and its derivatives; δ' + s Q(δ', ψ) = δ by Newton's method, whose last step is linear."""
    own = deep - soft * last
    energy, Q, M, stiff, cross, tilting = _less(rest, table, own, slope)
    for _ in range(MOST_STEPS):
        step = (deep - own - soft * Q) / (1.0 + soft * stiff)
        if not any_lane(absolute(step) > SETTLED * absolute(soft * Q) + SHORTEST):
            break
        own = own + step
        energy, Q, M, stiff, cross, tilting = _less(rest, table, own, slope)
    energy, Q, M = energy + Q * step, Q + stiff * step, M - cross * step
    give = 1.0 / (1.0 + soft * stiff)
    tilting = tilting - soft * cross * cross * give
    return energy + 0.5 * soft * Q * Q, Q, M, stiff * give, cross * give, tilting


@part
def _less(rest, table, deep, slope):
    if rest is None:
        return force_and_stiffness(table, deep, slope)
    a, b = force_and_stiffness(table, deep, slope), force_and_stiffness(rest, deep, slope)
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]


@part
def fallen(tilted, at, columns, gained):
    """What spalls that came under eight contacts since the last kick took of their forces' ways, m, and of work, J.

    A kick works along surfaces by its force times the fall of then: the mean of both ends' products, not the product
    of means.

    tilted : `TiltedForces`; gained : N, of forces since the last kick
    """
    way, work, more, besides = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if tilted.edges is not None:
        way, work = _fallen(tilted.edges, 0, at, columns, gained)
    if tilted.sunken is not None:
        more, besides = _fallen(tilted.sunken, SUNK, at, columns, gained)
        edges, beyond = _fallen(tilted.sunken, PART_EDGES, at, columns, gained)
        more, besides = more + edges, besides + beyond
    return way + more, work + besides


@part
def _fallen(array, first, at, columns, gained):
    apart = 2 * columns
    now, before = (first + NOW) * apart + at, (first + BEFORE) * apart + at
    fall, last = load(array, now + apart), load(array, before + apart)
    passed = load(array, now) - load(array, before)
    store(array, before, load(array, now))
    store(array, before + apart, fall)
    return 0.5 * (fall + last) * passed, 0.25 * gained * (fall - last) * passed


@part
def own_approach(edges, at, approach, Q):
    """Approaches of eight contacts, m, less what edges take of them."""
    if edges is None:
        return approach
    return approach - load(edges, at) * Q


@part
def kick_by_work(Q, Q_before, P_before, residual, approach, step, work):
    """`law.kick_force` of a contact whose energy has grown by `work`, J, beside what moments have done; lanes, N.

    `step` : m, by which its force has worked since the last kick; NaN: not known
    """
    closed = (Q > 0.0) & (Q_before > 0.0)
    plain = (step != step) | (maximum(Q, Q_before) <= 0.0) | (closed & (absolute(step) < STANDING * absolute(approach)))
    way = select(absolute(step) < SHORTEST, SHORTEST, step)
    due = residual - 0.5 * step * (P_before - Q_before)
    back = maximum(minimum(REPAID * due / way, MOST_REPAID * Q), -MOST_REPAID * Q)
    off = select(closed, MOST_OFF * Q, maximum(Q, Q_before))
    more = 0.5 * (Q - Q_before) + work / way + select(closed, back, 0.0) - Q
    return Q + select(plain, 0.0, maximum(minimum(more, off), -off))

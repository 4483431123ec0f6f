"""A tilted contact in the time loop: energy, force and moment of a table by approach and slope; scalars or eight lanes.

The table is `lagrange.axial.ContactTable`.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import gather_quads
from fem.kernels.lanes import absolute, select, to_float, to_int
from fem.kernels.law import MOST_REPAID, REPAID, STANDING, spline
from lagrange.axial.table import SPAN, ContactTable

SHORTEST = 1e-16  # m, of an approach's change, by which work is divided
MOST_OFF = 0.02  # of a closed contact's force, by which its kick may differ


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

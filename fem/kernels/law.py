"""THE CONTACT LAW below the grid, and that of FRICTION: force, energy, the force of a kick; what varies along surfaces.

Of scalars or eight lanes (contacts). Surfaces that are not perfect circles have profiles, which
come off the outward motion of a contact's two sides: `lagrange.surface.deviation` says what a sinkage is, and the
compliance of edges, which adds to the ripple. Bodies without one have None, which compiles to nothing.

Equation (3) of docs/method.md.
"""

from math import log, pi
from typing import NamedTuple

import numpy as np

from fem.kernels import lanes
from fem.kernels.fields import given
from fem.kernels.jit import kernel, part
from fem.kernels.lane_functions import arc_tangent, logarithm, maximum, minimum
from fem.kernels.lanes import absolute, any_lane, gather, load, select, to_float, to_int
from lagrange.contact.damping import ContactDamping

STEEPEST = 0.25  # at this bracket less a half the mesh resolves the contact; the law goes on as a straight line
SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)
KNOTS_PER_NODE = 8  # the ripple's highest wave is one node spacing long
STANDING = 1e-4  # of its value: an approach that changes less works as a constant force
NEAR = 1e-5  # relative: a step of third order from so near leaves less than round-off
REPAID, MOST_REPAID = 0.25, 0.01  # of a contact's residual energy, in a step; of its force, at most


class Law(NamedTuple):
    """What contacts of a pair add to what the nodes carry; with pressure points only the last two count."""

    A: float
    B: float
    Q_line: float
    half_width_factor: float  # b²/Q
    curvature: float  # 1/R, 1/m


@part
def creep_traction(slip, limit, full_slip, mobility_dt):
    """Traction, N, that opposes a slip velocity, and the slip it leaves, m/s; scalars or lanes.

    Carter's law T = limit·(1 − (1 − v/v_full)²) up to v_full, then `limit`; solved implicitly for the velocity after
    the step, v = slip − mobility·dt·T(v), so that no stiffness limits the step.

    limit : N, μQ; full_slip : m/s; mobility_dt : m/s per N

    Source: Carter, On the action of a locomotive driving wheel (1926); Johnson, Contact Mechanics (1985), chapter 8.
    """
    v = absolute(slip)
    k = mobility_dt * limit / full_slip
    x = v / full_slip
    sliding = x >= 1.0 + k
    b = 1.0 + 2.0 * k
    x = 2.0 * x / (b + lanes.square_root(select(sliding, 0.0, b * b - 4.0 * k * x)))
    traction = select(sliding, limit, limit * x * (2.0 - x))
    left = select(sliding, v - mobility_dt * limit, x * full_slip)
    return lanes.with_sign(traction, slip), lanes.with_sign(left, slip)


@kernel(forceinline=True)
def contact_force(approach, A, B, Q_line, guess):
    """Force of a sub-grid approach; 0 where the surfaces are apart.

    δ = A Q (B − ½ ln Q) up to Q_line, from there straight on with the slope it has there.

    approach : m; A, B, Q_line : the law; guess : N, the last force, or 0

    Errors: Newton's method on a concave function, to round-off. What is not a number stays so.
    """
    apart = approach <= 0.0
    known = (guess > 0.0) & (guess <= Q_line)
    Q = select(known, guess, minimum(approach / (A * (absolute(B) + 10.0)), Q_line))
    Q = select(apart, Q_line, Q)
    for _ in range(60):
        bracket = B - 0.5 * logarithm(Q)
        step = (approach - A * Q * bracket) / (A * (bracket - 0.5))
        new = select(apart, Q, minimum(maximum(Q + step, 0.1 * Q), Q_line))
        moving = absolute(new - Q) > 1e-8 * new  # the error left is a tenth of the square of the relative step
        Q = new
        if not any_lane(moving):
            break
    if any_lane((Q >= Q_line) & (approach > 0.0)):
        # the ripple in B tilts the line as well: with another slope than this place's energy would not be conserved
        line = (approach * (1.0 / A) - 0.5 * Q_line) / (B - 0.5 * log(Q_line) - 0.5)  # STEEPEST but for B's ripple
        Q = select(Q >= Q_line, maximum(line, Q_line), Q)
    return select(apart, 0.0, Q + (approach - approach))


@part
def next_force(approach, A, B, Q_line, before, approach_before, B_before):
    """`contact_force` a step after the force `before` at an approach and a level of then, not a number where not known.

    The last force's logarithm follows from its approach, ½ ln Q = B − δ/(A Q). From there one step of third order
    brings the error to the third power of the relative change, a second one with a logarithm of its own below
    round-off; what changes more goes the long way.
    """
    apart = approach <= 0.0
    known = (before > 0.0) & (before < Q_line) & (approach_before > 0.0) & (approach > 0.0)
    guess = select(known, before, 1.0)
    level = B + select(known, approach_before / (A * guess) - B_before, 0.0)
    delta = approach * (1.0 / A)
    Q = guess + _third_order(delta, guess, level)
    Q = minimum(maximum(Q, 0.5 * guess), 2.0 * guess)
    step = _third_order(delta, Q, B - 0.5 * logarithm(Q))
    sure = known & (absolute(step) < NEAR * Q) & (Q < 0.99 * Q_line)
    Q = select(apart, 0.0, Q + step)
    if any_lane(select(apart, 0.0, select(sure, 0.0, 1.0)) != 0.0):  # what is not a number is neither
        return distant_force(approach, A, B, Q_line, before)
    return Q


@part
def _third_order(delta, Q, bracket):
    """Step of Halley's method for Q (B − ½ ln Q) = δ/A."""
    slope = bracket - 0.5
    double = 4.0 * Q * slope
    left = delta - Q * bracket
    return double * left / (double * slope - left)


@part(inlined=False)
def distant_force(approach, A, B, Q_line, guess):
    """`contact_force` where it is seldom asked for: one copy in a kernel."""
    return contact_force(approach, A, B, Q_line, guess)


# N s/m, by a `ContactDamping`, forces and stiffnesses
damping_coefficient = part(ContactDamping.coefficient)


@part
def kick_force(law, last, now):
    """The force a leapfrog kick gives, N, so that the contact stores what its forces take, `Q` + O(dt²).

    Each half of a kick works in the step on its side. The half that looks ahead is half of `Q`; the half that looks
    back is chosen so that both halves' work in the step behind is the change of the stored energy (a discrete
    gradient). With halves of `Q` alone a step in which a contact of stiffness k closes or opens, a fraction θ into it,
    would lose or gain ½ k v² dt² θ (1 − θ), which adds up where rollers rattle. What is left, of third order in dt,
    would still add up, to 3 % of the exchanged energy in half a second: this residual energy is recorded and repaid in
    small parts while the contact moves.

    law : its A and Q_line
    last : of the last kick the approach, m, the law's force, N, its level B, what the kick gave, N, and the energy, J,
        so far stored beyond what kicks have taken
    now : approach, force and level; scalars or lanes. An approach is negative: apart, or NaN: not known

    Returns: force, N, and residual energy, J, after this kick

    Source: Gonzalez, J. Nonlinear Sci. 6 (1996) 449 (discrete gradients).
    """
    (A, Q_line), (before, Q_before, B_before, P_before, residual), (approach, Q, B) = law, last, now
    work = stored_energy(Q, approach, A, Q_line) - stored_energy(Q_before, before, A, Q_line)
    level = 0.25 * A * (Q * Q + Q_before * Q_before) * (B - B_before)
    return kick_by_energy(before, Q_before, P_before, residual, approach, Q, work, level)


@part
def kick_by_energy(before, Q_before, P_before, residual, now, Q, work, level):
    """`kick_force` of any law: its energy has grown by `work`, J, and would by `level` more had its level stayed."""
    step, closed = now - before, minimum(before, now) > 0.0
    plain = (before != before) | (maximum(before, now) <= 0.0) | (closed & (absolute(step) < STANDING * now))
    work = work + select(closed, level, 0.0)  # what the level's change has done is not this force's work
    due = residual - 0.5 * step * (P_before - Q_before)  # the last kick has its other half yet to give
    most = MOST_REPAID * Q
    back = maximum(minimum(REPAID * due / step, most), -most)
    P = select(plain, Q, 0.5 * (Q - Q_before) + work / step + select(closed, back, 0.0))
    left = residual + work - 0.5 * step * (P_before + P)
    return P, select(before != before, residual, left)


@part
def released(most, Q, P, residual, ways, shortest):
    """Kicks P and residual energies of contacts that open, whose last force was `most`.

    Half of a kick works in the step behind, half in the step ahead, which is longer by the acceleration: 12 times how
    much further forces are taken. `ways` : by how far bodies have moved, and by how much further forces are taken;
    `shortest` : that counts
    """
    behind, ahead = ways
    behind = select(behind < 0.0, behind, 0.0)  # no release of an unknown residual
    onward = behind + ahead * 12.0
    opens = (Q <= 0.0) & (most > 0.0) & (behind < -shortest)
    more = (2.0 * residual - onward * P) / minimum(minimum(onward + behind, behind), -shortest)
    more = select(opens, maximum(minimum(more, most), -most), 0.0)
    return P + more, residual - 0.5 * behind * more


@part
def stored_energy(Q, approach, A, Q_line):
    """Energy stored below the grid, J, ∫ Q dδ of a force that goes with an approach; scalars or lanes."""
    q = minimum(Q, Q_line)
    return 0.5 * Q * approach - 0.125 * A * q * (2.0 * Q - q)


@kernel(forceinline=True)
def ripple_at(position, coefficients):
    """Ripple of A_i·B_i and its slope per node spacing at a position in node spacings, >= 0."""
    value, slope = spline_at(position * (1.0 * KNOTS_PER_NODE), coefficients, 0, coefficients.size)
    return value, slope * (1.0 * KNOTS_PER_NODE)


@part
def seamless(position, coefficients):
    """`ripple_at` of eight positions with the coefficients of `with_seam`."""
    n = coefficients.size - 3
    x = position * (1.0 * KNOTS_PER_NODE)
    base = to_int(x)
    t = x - to_float(base)
    base = base - to_int(to_float(base) * (1.0 / n)) * n
    base = select((base >= 0) & (base < n), base, 0)  # round-off may leave it n
    value, slope = spline(t, lanes.gather_quads(coefficients, base))
    return value, slope * (1.0 * KNOTS_PER_NODE)


def with_seam(coefficients: np.ndarray) -> np.ndarray:
    """Periodic coefficients with one more in front and two behind, so that any four neighbours stand in a row."""
    return np.concatenate([coefficients[-1:], coefficients, coefficients[:2]])


@part
def spline(t, coefficients):
    """A cubic B-spline and its slope per knot a fraction t beyond the second of four knots."""
    r = 1.0 - t
    c0, c1, c2, c3 = coefficients
    value = (
        r * r * r * c0 + (4.0 - 3.0 * t * t * (2.0 - t)) * c1 + (4.0 - 3.0 * r * r * (2.0 - r)) * c2 + t * t * t * c3
    ) * (1.0 / 6.0)
    slope = 0.5 * (t * (3.0 * t - 4.0) * c1 - r * r * c0 - r * (3.0 * r - 4.0) * c2 + t * t * c3)
    return value, slope


@part
def spline_at(x, coefficients, first, n):
    """A periodic cubic B-spline and its slope per knot at x knots, >= 0; its n coefficients stand from `first` on."""
    base = to_int(x)
    t = x - to_float(base)
    base = base - to_int(to_float(base) * (1.0 / n)) * n  # round-off may leave it n or −1
    base = select(base >= n, base - n, select(base < 0, base + n, base))
    before = select(base < 1, base + (n - 1), base - 1)
    after = select(base >= n - 1, base + (1 - n), base + 1)
    beyond = select(after >= n - 1, after + (1 - n), after + 1)
    c0, c1 = gather(coefficients, before + first), gather(coefficients, base + first)
    c2, c3 = gather(coefficients, after + first), gather(coefficients, beyond + first)
    return spline(t, (c0, c1, c2, c3))


class RingProfile(NamedTuple):
    """Surface of a ring over its angle: periodic cubic B-splines."""

    sinkage: given("n_knots")  # m
    # m/N, of edges; where rollers tilt, whose edges have none, m, sinkage of the part of the length that spalls take
    compliance: given("n_knots")


class RollerProfiles(NamedTuple):
    """The same of the rollers' contacts with one raceway by angle on the roller."""

    sinkage: given("n_rows, n_knots")  # m
    compliance: given("n_rows, n_knots")  # m/N, or m
    first: given("columns", dtype=np.int64)  # place of each roller's row


@part
def place(x, y, n_nodes):
    """Position, in node spacings in [0, n_nodes), of a direction in a body's frame; scalars or lanes."""
    position = arc_tangent(y, x) * (n_nodes / (2.0 * pi))
    position = select(position < 0.0, position + 1.0 * n_nodes, position)
    return select(position >= 1.0 * n_nodes, position - 1.0 * n_nodes, position)


@part
def _lowered(profile, first, n, sign, motion, bx, by):
    out, rate, ripple, ripple_rate = motion
    at, per_rad = place(bx, by, n), n / (2.0 * pi)
    sinkage, slope = spline_at(at, profile.sinkage, first, n)
    soft, softening = spline_at(at, profile.compliance, first, n)
    return out - sign * sinkage, rate - slope * (sign * per_rad), ripple + soft, ripple_rate + softening * per_rad


@part
def lowered_ring(profile, sign, motion, bx, by):
    """A raceway's outward motion, its slope per rad, ripple and its slope, at directions b in the ring's frame.

    `motion` : the four of a perfect circle; the sinkage comes off, compliance is added.
    """
    if profile is None:
        return motion
    return _lowered(profile, 0, profile.sinkage.size, sign, motion, bx, by)


@part
def lowered_rollers(profiles, group, motion, bx, by):
    """The same of eight rollers from `group` on, at directions b in their frames."""
    if profiles is None:
        return motion
    return _lowered(profiles, load(profiles.first, group), profiles.sinkage.shape[1], 1.0, motion, bx, by)

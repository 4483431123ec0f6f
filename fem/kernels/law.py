"""The contact law below the grid in the time loop: force, energy, the force of a kick, the ripple along a surface."""

import numpy as np

from fem.kernels.jit import kernel

KNOTS_PER_NODE = 8  # the ripple's highest wave is one node spacing long
STANDING = 1e-4  # of its value: an approach that changes less works as a constant force
STEEPEST = 0.25  # at this bracket less a half the mesh resolves the contact; the law goes on as a straight line


@kernel(forceinline=True)
def contact_force(approach, A, B, Q_line, guess):
    """Force of a sub-grid approach; 0 where the surfaces are apart.

    δ = A Q (B − ½ ln Q) up to Q_line, from there straight on with the slope it has there.

    Parameters
    ----------
    approach : float, m; A, B, Q_line : the law; guess : float, N, the last force, or 0

    Errors
    ------
    Newton's method on a concave function, to round-off.
    """
    if approach <= 0.0:
        return 0.0
    Q = guess
    if not 0.0 < Q <= Q_line:
        Q = min(approach / (A * (abs(B) + 10.0)), Q_line)
    for _ in range(60):
        bracket = B - 0.5 * np.log(Q)
        step = (approach - A * Q * bracket) / (A * (bracket - 0.5))
        new = min(max(Q + step, 0.1 * Q), Q_line)
        converged = abs(new - Q) <= 1e-8 * new  # the error left is a tenth of the square of the relative step
        Q = new
        if converged:
            break
    if Q < Q_line:
        return Q
    # the ripple in B tilts the line as well: its slope has to be that of this place, or energy would not be conserved
    return max(Q_line, (approach / A - 0.5 * Q_line) / _slope_of_line(B, Q_line))


@kernel(forceinline=True)
def _slope_of_line(B, Q_line):
    """dδ/dQ above Q_line over A: STEEPEST but for B's ripple."""
    return B - 0.5 * np.log(Q_line) - 0.5


@kernel(forceinline=True)
def kick_force(before, Q_before, B_before, now, Q, B, A, Q_line):
    """The force a leapfrog kick gives, N, so that the contact stores what its forces take: `Q` + O(dt²).

    Each half of a kick works in the step on its side. The half that looks ahead is half of `Q`; the half that looks
    back is chosen so that both halves' work in the step behind is the change of the stored energy (a discrete
    gradient). With halves of `Q` alone a step in which a contact of stiffness k closes or opens, a fraction θ into it,
    would lose or gain ½ k v² dt² θ (1 − θ), which adds up where rollers rattle. What is left is of higher order in dt.

    Parameters
    ----------
    before, now : float, m, approaches at this kick and the one before; negative: apart, NaN: not known
    Q_before, Q : float, N; B_before, B : the law's level then and now; A, Q_line : the law

    Source: Gonzalez, J. Nonlinear Sci. 6 (1996) 449 (discrete gradients).
    """
    if np.isnan(before) or max(before, now) <= 0.0:
        return Q
    step, closed = now - before, min(before, now) > 0.0
    if closed and abs(step) < STANDING * now:
        return Q
    work = _stored(Q, now, A, Q_line) - _stored(Q_before, before, A, Q_line)
    if closed:  # what the level's change has done is not this force's work
        work += 0.25 * A * (Q * Q + Q_before * Q_before) * (B - B_before)
    return 0.5 * (Q - Q_before) + work / step


@kernel(forceinline=True)
def _stored(Q, approach, A, Q_line):
    """`contact_energy` by way of the approach."""
    q = min(Q, Q_line)
    return 0.5 * Q * approach - 0.125 * A * q * (2.0 * Q - q)


@kernel(forceinline=True)
def contact_energy(Q, A, B, Q_line):
    """Energy stored below the grid, J: ∫ Q dδ."""
    if Q <= 0.0:
        return 0.0
    q = min(Q, Q_line)
    energy = 0.5 * A * q * q * (B - 0.5 * np.log(q) - 0.25)
    if Q > Q_line:
        energy += 0.5 * A * _slope_of_line(B, Q_line) * (Q * Q - Q_line * Q_line)
    return energy


@kernel(forceinline=True)
def ripple_at(position, coefficients):
    """Ripple of A_i·B_i and its slope per node spacing at a position in node spacings, >= 0."""
    x = position * KNOTS_PER_NODE
    base = int(x)
    t = x - base
    r = 1.0 - t
    n = coefficients.size
    while base >= n:
        base -= n
    before, after = base - 1, base + 1
    if before < 0:
        before += n
    if after >= n:
        after -= n
    beyond = after + 1
    if beyond >= n:
        beyond -= n
    c0, c1, c2, c3 = coefficients[before], coefficients[base], coefficients[after], coefficients[beyond]
    value = (
        r * r * r * c0 + (4.0 - 3.0 * t * t * (2.0 - t)) * c1 + (4.0 - 3.0 * r * r * (2.0 - r)) * c2 + t * t * t * c3
    ) / 6.0
    slope = 0.5 * (-r * r * c0 + t * (3.0 * t - 4.0) * c1 - r * (3.0 * r - 4.0) * c2 + t * t * c3)
    return value, slope * KNOTS_PER_NODE

"""Surfaces that are not perfect circles: what comes off the outward motion of a contact's two sides.

`lagrange.profile` says what a sinkage is. Bodies without one have None, which compiles to nothing.
"""

from math import pi

from fem.kernels.jit import part
from fem.kernels.law import spline_at
from fem.kernels.simd import load
from fem.kernels.surfaces import place


@part
def lowered_ring(profile, sign, out, rate, bx, by):
    """Outward motion of a raceway and its slope per rad, at directions b in the ring's frame, less its sinkage."""
    if profile is None:
        return out, rate
    n = profile.size
    sinkage, slope = spline_at(place(bx, by, n), profile, 0, n)
    return out - sign * sinkage, rate - slope * (sign * n / (2.0 * pi))


@part
def lowered_rollers(profiles, group, out, rate, bx, by):
    """The same of eight rollers from `group` on, at directions b in their frames."""
    if profiles is None:
        return out, rate
    n = profiles.coefficients.shape[1]
    sinkage, slope = spline_at(place(bx, by, n), profiles.coefficients, load(profiles.first, group), n)
    return out - sinkage, rate - slope * (n / (2.0 * pi))

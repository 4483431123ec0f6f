"""Surfaces that are not perfect circles: what comes off the outward motion of a contact's two sides.

`lagrange.profile` says what a sinkage is, and the compliance of edges, which adds to the ripple. Bodies without a
profile have None, which compiles to nothing.
"""

from math import pi

from fem.kernels.jit import part
from fem.kernels.lane_memory import load
from fem.kernels.law import spline_at
from fem.kernels.surfaces import place


@part
def lowered_ring(profile, sign, motion, bx, by):
    """A raceway's outward motion, its slope per rad, ripple and its slope, at directions b in the ring's frame.

    `motion` : the four of a perfect circle; the sinkage comes off, compliance is added.
    """
    if profile is None:
        return motion
    out, rate, ripple, ripple_rate = motion
    n = profile.sinkage.size
    at, per_rad = place(bx, by, n), n / (2.0 * pi)
    sinkage, slope = spline_at(at, profile.sinkage, 0, n)
    soft, softening = spline_at(at, profile.compliance, 0, n)
    return out - sign * sinkage, rate - slope * (sign * per_rad), ripple + soft, ripple_rate + softening * per_rad


@part
def lowered_rollers(profiles, group, motion, bx, by):
    """The same of eight rollers from `group` on, at directions b in their frames."""
    if profiles is None:
        return motion
    out, rate, ripple, ripple_rate = motion
    n = profiles.sinkage.shape[1]
    at, first, per_rad = place(bx, by, n), load(profiles.first, group), n / (2.0 * pi)
    sinkage, slope = spline_at(at, profiles.sinkage, first, n)
    soft, softening = spline_at(at, profiles.compliance, first, n)
    return out - sinkage, rate - slope * per_rad, ripple + soft, ripple_rate + softening * per_rad

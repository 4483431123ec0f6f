"""Surfaces that are not perfect circles: what comes off the outward motion of a contact's two sides.

`lagrange.surface.deviation` says what a sinkage is, and the compliance of edges, which adds to the ripple. Bodies
without a profile have None, which compiles to nothing.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from fem.kernels.fields import given
from fem.kernels.jit import part
from fem.kernels.lane_functions import arc_tangent
from fem.kernels.lanes import load, select
from fem.kernels.law import spline_at


class RingProfile(NamedTuple):
    """Surface of a ring over its angle: periodic cubic B-splines."""

    sinkage: given("n_knots")  # m
    # m/N, of edges; where rollers tilt, whose edges have none, m, sinkage of the part of the length that spalls take
    compliance: given("n_knots")


class RollerProfiles(NamedTuple):
    """The same of the rollers' contacts with one raceway by angle on the roller."""

    sinkage: given("n_rows, n_knots")  # m
    compliance: given("n_rows, n_knots")  # m/N, or m
    first: given("columns", np.int64)  # place of each roller's row


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

"""One contact's energy as a smooth table over approach and slope: force and moment are its exact derivatives.

u = √U is a bicubic B-spline, twice continuously differentiable; where it is negative the contact is open. A time step
costs the same at any number of slices, and conserves energy as the plane law does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy import ndarray

SPAN = 4  # coefficients that a cubic B-spline adds up in a point
FAINT = 1e-20  # m/N: less, a spline's ringing beside edges, moves no contact
NOTHING = np.zeros(())
NEWTON_STEPS, SETTLED = 60, 1e-8  # of the approach that a compliance takes: what is left is of its square


class TiltedContact(NamedTuple):
    """A contact's energy and its derivatives, shape of the approaches."""

    energy: ndarray  # U, J
    force: ndarray  # Q = ∂U/∂δ, N
    moment: ndarray  # M = −∂U/∂ψ, N m
    stiffness: ndarray = NOTHING  # ∂Q/∂δ, N/m
    cross: ndarray = NOTHING  # ∂Q/∂ψ = −∂M/∂δ, N/rad
    tilt_stiffness: ndarray = NOTHING  # −∂M/∂ψ, N m/rad
    part: ndarray = NOTHING  # −∂U/∂h, N, of the force what slices bear that spalls have sunk by h
    # −∂U/∂s, N², by the compliance of edges across the whole length, and of those of the part that spalls take
    edges: ndarray = NOTHING
    part_edges: ndarray = NOTHING


SUMMED = 6  # of these, which the sum of two contacts has by their sums


@dataclass(frozen=True, kw_only=True, eq=False)
class ContactTable:
    """u = √U, J^½, of one contact by approach δ, m, and relative slope ψ, rad.

    Slices approach each other by δ − P(z) − ψ z. Coefficients of a cubic B-spline on equally spaced knots: the first
    knot lies at the second coefficient, so that n coefficients cover n − 3 steps.
    """

    first_approach: float  # m
    approach_step: float
    first_slope: float  # rad
    slope_step: float
    coefficients: ndarray  # (n_approaches, n_slopes), J^½

    has_part: ClassVar[bool] = False

    @property
    def last_approach(self) -> float:
        """The largest approach, m, that the table holds."""
        return self.first_approach + (self.coefficients.shape[0] - 3) * self.approach_step

    @cached_property
    def _spline(self):
        from scipy.interpolate import NdBSpline

        axes = (self.first_approach, self.approach_step), (self.first_slope, self.slope_step)
        sizes = zip(axes, self.coefficients.shape, strict=True)
        knots = tuple(first + step * np.arange(1 - SPAN, n + 1) for (first, step), n in sizes)
        return NdBSpline(knots, self.coefficients, SPAN - 1)

    def at(self, approach, slope) -> TiltedContact:
        """Energy, force, moment and their derivatives at approaches, m, and slopes, rad, of any shape.

        Outside the table u goes on straight, so that an iteration may pass there.
        """
        approach, slope = np.broadcast_arrays(np.asarray(approach, dtype=float), np.asarray(slope, dtype=float))
        within = np.clip(approach, self.first_approach, self.last_approach)
        last_slope = self.first_slope + (self.coefficients.shape[1] - 3) * self.slope_step
        straight = np.clip(slope, self.first_slope, last_slope)
        orders, at = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)), np.stack([within, straight], axis=-1)
        u, d, p, dd, dp, pp = (self._spline(at, nu=order) for order in orders)
        beyond, aside = approach - within, slope - straight
        u = u + d * beyond + p * aside + dp * beyond * aside
        d, p = d + dp * aside, p + dp * beyond
        closed = (u > 0.0) & (approach > self.first_approach)
        u, d, p, dd, dp, pp = (np.where(closed, each, 0.0) for each in (u, d, p, dd, dp, pp))
        slopes = 2.0 * (d * d + u * dd), 2.0 * (d * p + u * dp), 2.0 * (p * p + u * pp)
        return TiltedContact(u * u, 2.0 * u * d, -2.0 * u * p, *slopes)


class TiltedLaw(Protocol):
    """One contact of a roller that may be tilted, a table or slices.

    last_approach : the largest, m, that it knows; has_part : whether `at` takes the spalls of a part of the length, as
    `SpalledTable.at` does; at : of approaches δ, m, in the plane z = 0 and slopes ψ, rad, of any shape
    """

    @property
    def last_approach(self) -> float: ...
    @property
    def has_part(self) -> bool: ...
    @property
    def at(self) -> Callable[..., TiltedContact]: ...


def in_series(at: Callable[..., TiltedContact], approach, slope, compliance, *spalls) -> TiltedContact:
    """A contact with a compliance s in series, which stores U(δ', ψ) + ½ s Q², δ' + s Q(δ', ψ) = δ.

    `at` : of the contact; approach, slope : m, rad, of any shape; compliance : m/N; spalls : what `at` takes besides.
    Errors: Newton's method, to round-off.
    """
    approach, slope, soft, *over = np.broadcast_arrays(np.asarray(approach, dtype=float), slope, compliance, *spalls)
    sound = at(approach, slope, *over)
    found = TiltedContact(*(np.array(np.broadcast_to(each, soft.shape)) for each in sound))
    found.edges[...] = 0.5 * found.force**2
    near = (np.abs(soft) > FAINT) & (found.force > 0.0)
    if not near.any():
        return found
    depth, turned, s, over = approach[near], slope[near], soft[near], [each[near] for each in over]
    own, here = depth, TiltedContact(*(each[near] for each in found))
    moves = np.ones(own.shape, dtype=bool)  # each until it has settled, whatever stands beside it
    for _ in range(NEWTON_STEPS):
        step = np.where(moves, (depth - own - s * here.force) / (1.0 + s * here.stiffness), 0.0)
        own = own + step
        here = at(own, turned, *over)
        moves &= np.abs(step) > SETTLED * np.abs(s) * here.force
        if not moves.any():
            break
    give, half = 1.0 / (1.0 + s * here.stiffness), 0.5 * here.force**2
    softer = here._replace(energy=here.energy + s * half, stiffness=here.stiffness * give, cross=here.cross * give,
        tilt_stiffness=here.tilt_stiffness - s * here.cross**2 * give, edges=half)  # fmt: skip
    for every, each in zip(found, softer, strict=True):
        every[near] = each
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class SpalledTable:
    """A contact, part of whose slices spalls let sink by h: U(δ, ψ, h) = U_rest(δ, ψ) + (U − U_rest)(δ − h, ψ).

    That is exact where slices stand alone, and wherever the part bears nothing or has not sunk; between these coupled
    slices of the part know those of the rest as if all had sunk. Edges are in series with either term, each a contact
    of its own length: its compliance is that of the whole length over the term's share of it.
    """

    whole: TiltedLaw  # of all slices
    rest: TiltedLaw  # without those of the part
    share: float  # of the slices, that the part has

    has_part: ClassVar[bool] = True

    @property
    def last_approach(self) -> float:
        return self.whole.last_approach

    def at(self, approach, slope, sunk=0.0, compliance=0.0, part_compliance=0.0) -> TiltedContact:
        """As `ContactTable.at`; `sunk` : h, m; compliances : m/N, of edges across the whole length, and of the part's,
        both as if these were across the whole length."""

        def of_part(approach, slope):
            every, rest = (law.at(approach, slope)[:SUMMED] for law in (self.whole, self.rest))
            return TiltedContact(*np.subtract(every, rest))

        of_rest = in_series(self.rest.at, approach, slope, compliance / (1.0 - self.share))
        part = in_series(of_part, approach - sunk, slope, (compliance + part_compliance) / self.share)
        edges, part_edges = of_rest.edges / (1.0 - self.share), part.edges / self.share
        sums = np.add(of_rest[:SUMMED], part[:SUMMED])
        return TiltedContact._make([*sums, part.force, edges + part_edges, part_edges])


def spline_coefficients(values: ndarray) -> ndarray:
    """Of cubic B-splines through the values of each column at equally spaced knots; no bend beyond their ends."""
    from scipy.linalg import solve_banded

    found, inside = np.zeros((len(values) + 2, *values.shape[1:])), 6.0 * values[1:-1]
    found[1], found[-2] = values[0], values[-1]  # c₀ − 2 c₁ + c₂ = 0 and c₀ + 4 c₁ + c₂ = 6 u
    inside[0] -= values[0]
    inside[-1] -= values[-1]
    found[2:-2] = solve_banded((1, 1), np.tile([[1.0], [4.0], [1.0]], len(inside)), inside)
    found[0], found[-1] = 2.0 * found[1] - found[2], 2.0 * found[-2] - found[-3]
    return found

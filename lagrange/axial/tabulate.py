"""Making a contact's table: its range, its steps, and the energy of slices at every knot."""

from math import ceil

import numpy as np

from lagrange.axial.facts import Axial
from lagrange.axial.slices import LineLaw, Slices
from lagrange.axial.table import ContactTable, fitted
from lagrange.bearing import Bearing

KNOTS = 96  # between the opening and the largest approach of a straight contact, and as many slopes either way
MORE = 3.0  # times the largest force: what moves carries more than what stands
DOUBLINGS = 60


def contact_tables(
    bearing: Bearing,
    axial: Axial,
    laws: tuple[LineLaw, LineLaw],
    largest_force: float,
    largest_slope: float,
    couplings: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[ContactTable, ContactTable]:
    """Tables of the inner and the outer contact, where all rollers are alike.

    Parameters
    ----------
    laws : of the whole length
    largest_force : N, of a contact at rest; largest_slope : rad, of a roller to a ring, either way
    couplings : (n, n) each, m/N, of slices; None: each is alone
    """
    place, drops = axial.centres(bearing), axial.drops(bearing)
    inner, outer = (
        tabulated(
            Slices(law=law, place=place, drop=drop, coupling=None if couplings is None else couplings[i]),
            largest_force,
            largest_slope,
        )
        for i, (law, drop) in enumerate(zip(laws, drops, strict=True))
    )
    return inner, outer


def tabulated(slices: Slices, largest_force: float, largest_slope: float) -> ContactTable:
    """The table of a contact's energy up to a force, N, of a straight contact, and to a slope, rad, either way.

    Where the contact is open u goes on as −u of the same depth beyond the opening: no kink there that a spline would
    ring from.
    """
    deepest = _approach(slices, MORE * largest_force)
    slope = np.linspace(-largest_slope, largest_slope, 2 * KNOTS + 1)
    opening = slices.opening(slope)
    step = (deepest - float(slices.opening(np.zeros(1))[0])) / KNOTS
    first = float(opening.min()) - 2.0 * step
    approach = first + step * np.arange(ceil((deepest - first) / step) + 1)
    signed = approach[:, None] - opening
    energy = slices.sums(opening + np.abs(signed), np.broadcast_to(slope, signed.shape)).energy
    return fitted((first, -largest_slope), (step, slope[1] - slope[0]), np.sign(signed) * np.sqrt(energy))


def _approach(slices: Slices, force: float) -> float:
    """Of a straight contact under a force, N; m."""
    still = np.zeros(1)
    low = float(slices.opening(still)[0])
    high = low + 1e-9
    for _ in range(DOUBLINGS):
        if slices.sums(np.array([high]), still).force[0] >= force:
            break
        high = low + 2.0 * (high - low)
    for _ in range(DOUBLINGS):
        middle = 0.5 * (low + high)
        if slices.sums(np.array([middle]), still).force[0] < force:
            low = middle
        else:
            high = middle
    return high

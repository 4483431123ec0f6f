"""Making a contact's table: its range, its steps, and the energy of slices at every knot."""

from dataclasses import replace
from math import ceil

import numpy as np

from lagrange.axial.facts import Axial
from lagrange.axial.slices import LineLaw, Slices
from lagrange.axial.table import ContactTable, SpalledTable, fitted
from lagrange.bearing import Bearing
from lagrange.surface.deviation import profiles

KNOTS = 72  # between the opening and the largest approach of a straight contact
COARSER = 2.0  # steps of slope, at a roller's end, over those of approach: energy is smoother along it
MOST_SLOPES = 300  # steps of slope either way
BELOW = 6  # steps of approach below the opening of which a spline's values above it still know
OUT_OF_REACH = 1e-3  # m, further than any slice approaches
MORE = 3.0  # times the largest force: what moves carries more than what stands


def contact_tables(
    bearing: Bearing,
    axial: Axial,
    laws: tuple[LineLaw, LineLaw],
    largest_force: float,
    largest_slope: float,
    couplings: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:
    """Tables of the inner and the outer contact, where all rollers are alike.

    Parameters
    ----------
    laws : of the whole length
    largest_force : N, of a contact at rest; largest_slope : rad, of a roller to a ring, either way
    couplings : (n, n) each, m/N, of slices; None: each is alone

    Errors
    ------
    RuntimeError: slices do not settle.
    """
    inner, outer = (
        spalled(each, tabulated(each, float(each.approach_under(MORE * largest_force, 0.0)), largest_slope))
        for each in contact_slices(bearing, axial, laws, couplings)
    )
    return inner, outer


def spalled(slices: Slices, whole: ContactTable) -> ContactTable | SpalledTable:
    """The table with that of the slices which no spall takes, if any takes a part of the length."""
    if slices.part is None:
        return whole
    return SpalledTable(whole=whole, rest=without_part(slices, whole), share=float(slices.part.mean()))


def alone(slices: Slices) -> Slices | SpalledTable:
    """A contact of slices that stand alone, apart in those that spalls of part of the length take and the rest."""
    if slices.part is None:
        return slices
    return SpalledTable(whole=replace(slices, part=None), rest=_bare(slices), share=float(slices.part.mean()))


def steepest_slope(bearing: Bearing, axial: Axial, misalignment: float, depth: float) -> float:
    """The largest slope, rad, of a roller to a ring: of the shaft, and as far as it can tilt between raceways.

    `depth` : m, largest approach of the contacts
    """
    play, ends = max(2.0 * bearing.radial_clearance, 0.0), np.minimum(axial.drops(bearing)[:, [0, -1]], 4.0 * depth)
    surfaces = profiles(bearing)
    if surfaces is not None:
        play += 2.0 * surfaces.deepest
    return abs(misalignment) + (play + float(ends.max(axis=1).sum()) + 2.0 * depth) / bearing.roller_length


def contact_slices(
    bearing: Bearing,
    axial: Axial,
    laws: tuple[LineLaw, LineLaw],
    couplings: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[Slices, Slices]:
    """The slices of the inner and the outer contact; as of `contact_tables`."""
    place, drops, parts = axial.centres(bearing), axial.drops(bearing), axial.parts(bearing)
    inner, outer = (
        Slices(law=law, place=place, drop=drop, coupling=None if couplings is None else couplings[i], part=part)
        for i, (law, drop, part) in enumerate(zip(laws, drops, parts, strict=True))
    )
    return inner, outer


def tabulated(slices: Slices, deepest: float, steepest: float) -> ContactTable:
    """The table of a contact's energy up to an approach, m, and to a slope, rad, either way.

    Of a light load on a roller that may tilt far the slopes are too many: then both steps are wider, in their ratio.
    """
    step, end = (deepest - float(slices.opening(np.zeros(1))[0])) / KNOTS, float(np.abs(slices.place).max())
    half = min(ceil(steepest * end / (COARSER * step)), MOST_SLOPES)
    step = max(step, steepest / half * end / COARSER)
    first = float(slices.opening(steepest / half * np.arange(-half, half + 1)).min()) - 2.0 * step
    return _on_grid(slices, (first, step, ceil((deepest - first) / step) + 1), (steepest / half, half))


def without_part(slices: Slices, whole: ContactTable) -> ContactTable:
    """The table on the same knots of a contact in whose part of the length that spalls take nothing bears."""
    rows, columns = whole.coefficients.shape
    return _on_grid(
        _bare(slices), (whole.first_approach, whole.approach_step, rows - 2), (whole.slope_step, (columns - 3) // 2)
    )


def _bare(slices: Slices) -> Slices:
    """Those of a contact in whose part of the length that spalls take nothing bears."""
    return replace(slices, drop=-slices.approaches(0.0, 0.0, OUT_OF_REACH), part=None)


def _on_grid(slices: Slices, rows: tuple[float, float, int], columns: tuple[float, int]) -> ContactTable:
    """The table through u at knots: first approach, its step, m, and their number; step of slope, rad, either way.

    Where the contact is open u goes on as −u of the same depth beyond the opening: no kink there that a spline would
    ring from.
    """
    (first, step, count), (by_slope, half) = rows, columns
    slope = by_slope * np.arange(-half, half + 1)
    opening = slices.opening(slope)
    approach = first + step * np.arange(count)
    signed = approach[:, None] - opening
    known = signed > -BELOW * step
    wanted = known & (slope >= 0.0) if slices.is_symmetric else known
    at, energy = np.nonzero(wanted), np.zeros(signed.shape)
    energy[at] = slices.sums(opening[at[1]] + np.abs(signed[at]), slope[at[1]]).energy
    if slices.is_symmetric:
        energy[:, :half] = energy[:, :half:-1]
    u = np.sign(signed) * np.sqrt(energy)
    least = np.where(known.any(axis=0), u.min(axis=0), u.min())
    u = np.where(known, u, least * signed / (-BELOW * step))
    return fitted((first, -half * by_slope), (step, by_slope), u)

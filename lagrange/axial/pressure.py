"""Hertz pressures along a tilted roller, by the forces of its slices."""

import numpy as np

from lagrange.axial.facts import Axial
from lagrange.axial.slices import Slices
from lagrange.bearing import Bearing
from lagrange.contact.raceway_laws import Pair

SHARP = "a roller's end is loaded, and its profile ends there with an edge, where pressure has no limit"
FAINTEST = 1e-6  # N, of a slice at a roller's end


def pressures(slices: Slices, pair: Pair, approach, slope) -> np.ndarray:
    """Largest pressure of each slice, (..., n), Pa, by approach, m, and slope, rad, of contacts, (...,).

    Each slice has Hertz's pressure across: p0 = √(q E*/(π R)), q its force by its width.

    Errors
    ------
    With coupled slices 0.7 % of peaks on profiled rollers; alone 3 to 9 %. At an edge there is no limit: `is_sharp`.
    RuntimeError: as `Slices.forces`.
    """
    return _hertz(pair, slices.count * slices.forces(approach, slope))


def _hertz(pair: Pair, force: np.ndarray) -> np.ndarray:
    """p0, Pa, under forces on the whole length, N."""
    return np.sqrt(force / (np.pi * pair.relative_radius * pair.length) * pair.modulus)


def sharp_ends(bearing: Bearing, axial: Axial) -> np.ndarray:
    """Whether profiles end with an edge at a roller's ends, inner and outer contact, (2,)."""
    end = np.array([-0.5, 0.5]) * bearing.roller_length
    own = axial.roller.drop(end, bearing)
    raceways = np.stack([each.drop(end, bearing) for each in (axial.inner_raceway, axial.outer_raceway)])
    return np.isfinite(own + raceways).any(axis=1)


def peak_pressures(slices: Slices, pair: Pair, sharp: bool, approach, slope) -> np.ndarray:
    """Largest pressure of contacts, (...,), Pa; NaN where an edge is loaded.

    `sharp` : of `sharp_ends`
    """
    forces = slices.forces(approach, slope)
    peak = _hertz(pair, slices.count * forces.max(axis=-1))
    return np.where(sharp & (forces[..., [0, -1]].max(axis=-1) > FAINTEST), np.nan, peak)

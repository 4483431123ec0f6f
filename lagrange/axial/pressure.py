"""Hertz pressures along a tilted roller, by the forces of its slices."""

import numpy as np

from lagrange.axial.facts import Axial
from lagrange.axial.slices import Slices
from lagrange.bearing import Bearing
from lagrange.contact.raceway_laws import Pair

SHARP = "a roller's end is loaded, and its profile ends there with an edge, where pressure has no limit"
STEPS, HALVINGS = 100, 30  # of Newton's method
SETTLED = 1e-6  # of a force: it comes from a table
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


def placed(slices: Slices, force: float, moment: float) -> tuple[float, float]:
    """Approach, m, and slope, rad, of a contact that bears a force, N, > 0, and a moment, N m.

    Errors
    ------
    ValueError: the moment is more than the force at a roller's end, or nothing is found.
    """
    arm = float(slices.place[-1])
    if not abs(moment) < arm * force:
        raise ValueError(f"a moment of {moment:.4g} N m is beyond what {force:.4g} N within {arm:.4g} m exert")
    at = np.array([slices.straight_approach(force), 0.0])
    weight = np.array([1.0, 1.0 / arm])

    def left(at):
        found = slices.at(at[0], at[1])
        return found, np.array([force - found.force, found.moment - moment])

    found, missing = left(at)
    for _ in range(STEPS):
        size = np.abs(missing * weight).max()
        if size <= SETTLED * force:
            return float(at[0]), float(at[1])
        matrix = np.array([[found.stiffness, found.cross], [found.cross, found.tilt_stiffness]])
        step = np.linalg.solve(matrix + 1e-9 * np.diag(np.diag(matrix)), missing)
        for _ in range(HALVINGS):
            near = left(at + step)
            if np.abs(near[1] * weight).max() < size:
                break
            step = 0.5 * step
        at, (found, missing) = at + step, near
    raise ValueError(f"no place of a roller is found at which its slices bear {force:.4g} N and {moment:.4g} N m")

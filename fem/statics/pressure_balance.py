"""The balance of hub and rollers on contacts of many pressure points: Newton around an active set.

Points push or stand open, never both. As in `contact_balance` the bodies are condensed to the compliance between them;
where that comes from is not known here.
"""

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from fem.contacts.model import PressurePoints
from fem.statics.contact_balance import LOOSE_SPRING, Loads, NotFound, bare_of, geometry, springs_of
from lagrange import Bearing
from lagrange.equations import overlaps

MAX_NEWTON = 40
MAX_CLOSING = 100
ENOUGH = 1e-9  # of the load


def balance_pressures(
    bearing: Bearing, radial: np.ndarray, points: PressurePoints, loads: Loads, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Hub and radii in equilibrium, (n_rollers + 2,), and the forces of all points, N.

    Parameters
    ----------
    radial : (n_rollers, 2), unit, from the outer ring's centre to the rollers; start : (n_rollers + 2,), m

    Errors
    ------
    NotFound: no equilibrium. The balance is exact to ENOUGH of the load.
    """
    n = bearing.n_rollers
    active = np.zeros(points.contact.size, dtype=bool)
    outward = bearing.roller_mass * (loads.cage_speed**2 * start[2:] - loads.gravity * radial[:, 1])
    applied = np.concatenate([[loads.side_load, -loads.hub], outward])
    springs, middle = springs_of(bearing, loads.spring)

    def system(place, active):
        overlap, directions = geometry(bearing, radial, place)
        force, slopes, active = _pressed(points, overlap, active)
        total = np.bincount(points.contact, force, minlength=2 * n)
        residual = applied - directions.T @ total - springs * (place - middle)
        jacobian = -directions.T @ slopes @ directions - np.diag(springs)
        return residual, jacobian + _turning(bearing, radial, place, total[:n]), force, active, overlap

    place = start
    residual, jacobian, force, active, overlap = system(place, active)
    size = float(np.hypot(loads.side_load, loads.hub))
    enough = ENOUGH * max(size, 1.0)
    for _ in range(MAX_NEWTON):
        norm = np.linalg.norm(residual)
        if norm <= enough:
            return place, force
        step, length = np.linalg.solve(jacobian, -residual), 1.0
        step[2:] = _in_reach(points, overlap, active, step[2:], residual[2:])
        while True:
            trial = place + length * step
            found = system(trial, active)
            if np.linalg.norm(found[0]) < norm or length < 1e-6:
                break
            length *= 0.5
        if length < 1e-6:
            break
        place, (residual, jacobian, force, active, overlap) = trial, found
    if norm > 100.0 * enough + 2.0 * LOOSE_SPRING * abs(bearing.radial_clearance):
        why = f"static equilibrium not found: residual {norm:.2e} N under {size:.4g} N, contacts resolved"
        raise NotFound(bare_of(bearing, radial, loads) or why)
    return place, force


def _in_reach(points: PressurePoints, overlap, active, step, force) -> np.ndarray:
    """Steps of the rollers, (n_rollers,), m; those of loose ones end where a contact bears their force.

    A roller that no point holds, because the mesh leaves open by a nanometre a contact that exact statics closes, has
    nothing but LOOSE_SPRING: by Newton's step its weight would send it through the rings, and the search along the step
    would hold all other bodies back with it.

    Parameters
    ----------
    overlap : (2 n_rollers,), m, of the contacts; force : (n_rollers,), N, outward, that is not balanced
    """
    n, found = step.size, step.copy()
    held = np.bincount(points.contact[active], minlength=2 * n).reshape(2, n).any(axis=0)
    for j in np.flatnonzero(~held):
        mine = np.flatnonzero(points.contact == (n + j if force[j] > 0.0 else j))
        left = overlap[points.contact[mine]] + points.closing[mine]
        first = mine[np.argmax(left)]
        most = points.compliance[first, first] * abs(force[j]) - float(left.max())
        found[j] = np.clip(step[j], -most, most)
    return found


def _turning(bearing: Bearing, radial, place, inner_force) -> np.ndarray:
    """Change of the balance as the inner contacts' normals turn, (n_rollers + 2, n_rollers + 2), N/m."""
    at = overlaps(bearing, place[0], place[1], *(radial * place[2:, None]).T, place[2:])
    direction = np.column_stack([at.direction_x, at.direction_y])
    found = np.zeros((2 + len(radial), 2 + len(radial)))
    for k in range(len(radial)):
        turn = (np.eye(2) - np.outer(direction[k], direction[k])) * (inner_force[k] / at.distance[k])
        found[:2, :2] += turn
        found[:2, 2 + k] -= turn @ radial[k]
        found[2 + k, :2] -= turn @ radial[k]
        found[2 + k, 2 + k] += radial[k] @ turn @ radial[k]
    return found


def _pressed(points: PressurePoints, overlap: np.ndarray, active: np.ndarray):
    """Forces of all points, N, their derivative to the contacts' overlaps summed by contact, and the active points."""
    count, overlap = overlap.size, overlap[points.contact] + points.closing
    for _ in range(MAX_CLOSING):
        i = np.flatnonzero(active)
        force = np.zeros(overlap.size)
        factor = lu_factor(points.compliance[np.ix_(i, i)]) if i.size else None
        if i.size:
            force[i] = lu_solve(factor, overlap[i])
        left = overlap - points.compliance @ force
        found = np.where(active, force > 0.0, left > 0.0)
        if np.array_equal(found, active):
            break
        active = found
    else:
        raise NotFound(f"static equilibrium not found: contacts still open and close after {MAX_CLOSING} steps")
    slopes = np.zeros((count, count))
    if i.size:
        spread = np.zeros((i.size, count))
        spread[np.arange(i.size), points.contact[i]] = 1.0
        slopes = spread.T @ lu_solve(factor, spread)
    return force, slopes, active

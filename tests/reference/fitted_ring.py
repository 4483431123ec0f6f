"""An elastic ring in a bore by exact series: a thick ring pressed in, and one with play under given forces."""

from math import pi

import numpy as np
from scipy.optimize import nnls

from fem.elastic.continuum import annulus_modes, kolosov
from lagrange import Material
from tests.reference.half_plane import cubic_bspline_patch

FORCE_COUNTS = 1e4  # how much more the sum of forces must be right than any gap


def pressed_ring(inner: float, outer: float, material: Material, bed: float, interference: float) -> tuple:
    """Pressure, Pa, and how far raceway and outside of a ring move, m, that is larger than its bore by so much, m.

    `bed` : of the bore, Pa/m. Source: Timoshenko and Goodier (1970), section 28 (Lamé), plane strain.
    """
    modulus = material.youngs_modulus / (1.0 - material.poisson_ratio**2)
    ratio = material.poisson_ratio / (1.0 - material.poisson_ratio)
    area = outer**2 - inner**2
    outside = outer / modulus * ((outer**2 + inner**2) / area - ratio)
    pressure = interference / (outside + 1.0 / bed)
    return pressure, -2.0 * inner * outer**2 / (modulus * area) * pressure, -outside * pressure


def ring_with_play(
    radii: tuple[float, float], material: Material, bed: float, play: float, forces, half_width: float, n_points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pressure, Pa, and outward displacement, m, of the outside at angles 2πi/n, of a ring in a bore.

    The ring is thick and plane; the bore pushes by bed · (displacement − play), never pulls, without friction. Forces
    from inside are (angle, N per m of length), spread as cubic B-splines of a half-width, m. The complementarity of
    pressures and gaps is solved as a least-squares problem without negative unknowns (Lawson and Hanson).
    """
    inner, outer = radii
    orders = np.arange(n_points // 2)
    angle = 2.0 * pi * np.arange(n_points) / n_points
    by_outside, by_inside = _influences(orders, inner, outer, material)
    spread = cubic_bspline_patch(orders, half_width, inner)
    weights = np.where(orders == 0, 1.0, 2.0) / (2.0 * pi)
    moved = np.zeros(n_points)
    for place, force in forces:
        moved += np.cos(np.multiply.outer(angle - place, orders)) @ (weights * by_inside * spread) * (force / inner)
    apart = angle[:, None] - angle[None, :]
    influence = np.cos(np.multiply.outer(apart, orders)) @ (weights * by_outside) * (2.0 * pi / n_points)
    compliance = influence + np.eye(n_points) / bed
    lower = np.linalg.cholesky(compliance)
    area = outer * 2.0 * pi / n_points
    directions = np.stack([np.cos(angle), np.sin(angle)])
    wanted = sum(force * np.array([np.cos(place), np.sin(place)]) for place, force in forces)
    scale = FORCE_COUNTS * np.linalg.norm(lower.T, 2)
    rows = np.vstack([lower.T, scale * directions])
    right = np.concatenate([np.linalg.solve(lower, moved - play), scale * wanted / area])
    pressure, _ = nnls(rows, right, maxiter=100 * n_points)
    # the rigid motion is what is left of the gaps where the bore pushes
    left = (compliance @ pressure - (moved - play))[pressure > 0.0]
    rigid, *_ = np.linalg.lstsq(directions[:, pressure > 0.0].T, left, rcond=None)
    return pressure, moved - influence @ pressure + rigid @ directions


def _influences(orders: np.ndarray, inner: float, outer: float, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Inward motion of the outside by pressure cos nθ on it, and outward motion by such pressure inside, m/Pa.

    Of n = 1 it is 0: such pressures must balance, and what they do to radii is that of a rigid motion.
    """
    modulus, found = material.youngs_modulus / (1.0 - material.poisson_ratio**2), np.zeros((2, len(orders)))
    ratio, area = material.poisson_ratio / (1.0 - material.poisson_ratio), outer**2 - inner**2
    found[:, 0] = outer / modulus * ((outer**2 + inner**2) / area - ratio), 2.0 * outer * inner**2 / (modulus * area)
    shape = orders[2:]
    t = inner / outer
    on_both = [annulus_modes(shape, r, t, kolosov(material)) for r in (1.0, t)]
    tractions = np.concatenate([modes[:, 2:] for modes in on_both], axis=1)
    for kind, row, sign in ((0, 0, -1.0), (1, 2, 1.0)):
        right = np.zeros((len(shape), 4, 1))
        right[:, row] = -1.0
        weights = np.linalg.solve(tractions, right)
        found[kind, 2:] = sign * (on_both[0][:, :1] @ weights)[:, 0, 0] * outer / (2.0 * material.lame_mu)
    return found[0], found[1]

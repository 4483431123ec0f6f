"""The paper's outer ring by itself: its own frequencies, and Michell's series of a free ring pinched at two points."""

import numpy as np

from fem.elastic.continuum import annulus_modes, kolosov
from tests.reference.bearings import STEEL, ring
from tests.reference.half_plane import cubic_bspline_patch

INNER, OUTER = 0.028, 0.0325  # m, the paper's outer ring
FINE = 16  # layers of elements, 0.3 mm


def outer_ring(layers: int):
    """The paper's outer ring with elements about as long as they are high."""
    return ring(INNER, OUTER, 48 * layers, layers, False)


def free_modes(body, order: int) -> np.ndarray:
    """Frequencies, Hz, of so many waves around, of the ring held nowhere, the lowest ones first."""
    stiffness = body.harmonic_stiffness(np.array([order]))[0]
    scale = 1.0 / np.sqrt(np.repeat(body.row_mass, 2))
    values = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)


def thin_ring(order: int) -> float:
    """Bending frequency, Hz, of a thin ring in plane strain. Source: Love (1927), article 293, E/(1 − ν²) for E."""
    R, t = 0.5 * (INNER + OUTER), OUTER - INNER
    modulus = STEEL.youngs_modulus / (1.0 - STEEL.poisson_ratio**2)
    n2 = order**2
    return order * (n2 - 1.0) / np.sqrt(n2 + 1.0) * t / R**2 * np.sqrt(modulus / (12.0 * STEEL.density)) / (2.0 * np.pi)


def pinched(orders: np.ndarray, half_width: float) -> np.ndarray:
    """Fourier coefficients cos nθ of the outward motion of the outer circle of a free ring, m per N/m, pinched at 0 and
    π by forces inward spread as a cubic B-spline; n even, from 2 on: Michell's series."""
    shape = 2.0 * cubic_bspline_patch(orders, half_width, OUTER) / (np.pi * OUTER)  # of both; odd orders cancel
    inner = INNER / OUTER
    outside, inside = (annulus_modes(orders, r, inner, kolosov(STEEL)) for r in (1.0, inner))
    tractions = np.concatenate([outside[:, 2:], inside[:, 2:]], axis=1)  # σ_rr, σ_rθ of both circles by four solutions
    coefficients = np.linalg.solve(tractions, np.broadcast_to([[-1.0], [0.0], [0.0], [0.0]], (len(orders), 4, 1)))
    return (outside[:, :1] @ coefficients)[:, 0, 0] * OUTER / (2.0 * STEEL.lame_mu) * shape

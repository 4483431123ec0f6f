"""Stress in a half plane under line contacts, from the textbook: the formulas typed in again, and a numerical sum."""

import numpy as np


def mcewen(x, z, half_width, peak):
    """σ_x, σ_z, τ_xz below a semi-elliptic pressure; z is the depth (Johnson, Contact Mechanics, 1985, (4.49))."""
    b2 = half_width**2
    common = np.sqrt((b2 - x**2 + z**2) ** 2 + 4.0 * x**2 * z**2)
    m = np.sqrt(0.5 * (common + (b2 - x**2 + z**2)))
    n = np.sign(x) * np.sqrt(np.maximum(0.5 * (common - (b2 - x**2 + z**2)), 0.0))
    ratio = (z**2 + n**2) / (m**2 + n**2)
    sigma_x = -peak / half_width * (m * (1.0 + ratio) - 2.0 * z)
    sigma_z = -peak / half_width * m * (1.0 - ratio)
    tau = -peak / half_width * n * (m**2 - z**2) / (m**2 + n**2)
    return sigma_x, sigma_z, tau


def flamant(points, sources, forces):
    """Sum of simple radial distributions σ_r = −(2/π) F·r/r², (n_points, 3): xx, yy, xy."""
    away = points[:, None, :] - sources[None, :, :]
    squared = np.sum(away**2, axis=-1)
    radial = -2.0 / np.pi * np.sum(away * forces, axis=-1) / squared**2
    return np.stack([
        np.sum(radial * away[..., 0] ** 2, axis=1),
        np.sum(radial * away[..., 1] ** 2, axis=1),
        np.sum(radial * away[..., 0] * away[..., 1], axis=1),
    ], axis=-1)  # fmt: skip


def cubic_bspline_patch(n, half_width, radius):
    """Transform (sin x / x)⁴, x = n a/(4R), of the cubic B-spline of unit resultant on [−a, a] of a circle."""
    return np.sinc(np.asarray(n) * (half_width / (4.0 * np.pi * radius))) ** 4


def cubic_bspline(t):
    """The cardinal B-spline on [−2, 2], of unit integral."""
    t = np.abs(t)
    return np.where(t < 1.0, 2.0 / 3.0 - t**2 + 0.5 * t**3, np.maximum(2.0 - t, 0.0) ** 3 / 6.0)

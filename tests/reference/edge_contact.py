"""A disc pressed at any place along a spall: two half-planes under pressures that may not pull.

The pressure is constant in cells; the displacement, weighted with the cells, fits the gap of the bare profile where
they touch (Galerkin's method). The pressures are the least of the elastic energy, found by non-negative least squares.
Far from an edge it is Hertz's contact.

Source: Johnson, Contact Mechanics (1985), chapters 2 and 5.
"""

from dataclasses import dataclass
from functools import cached_property
from math import exp, log

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

FINE, COARSE, GROWTH = 0.3e-6, 2e-6, 1.1  # m, cells at the edges and far from them


@dataclass(frozen=True, kw_only=True)
class EdgeContact:
    """A disc in a bore, or on a disc, with a deep spall whose edges are rounded."""

    radius: float  # m, of the raceway, negative of a bore
    roller_radius: float
    compliance: float  # A, m/N: of two surfaces, 2/(π E* L)
    level: float  # B of the sound contact, δ = A Q (B − ½ ln Q)
    half_opening: float  # m, from the middle to where the surface leaves its circle
    edge_radius: float
    beside: float  # m, of the sound surface

    @cached_property
    def bounds(self) -> np.ndarray:
        """Bounds of the cells along the chord, m; nothing is touched inside the edges' arcs."""
        steps = [FINE] * 40
        while sum(steps) < self.beside:
            steps.append(min(COARSE, GROWTH * steps[-1]))
        arc = self.half_opening - FINE * np.arange(int(0.25 * self.edge_radius / FINE), 0, -1)
        half = np.concatenate([arc, [self.half_opening], self.half_opening + np.cumsum(steps)])
        return np.concatenate([-half[::-1], half])

    @cached_property
    def _solid(self) -> np.ndarray:
        """Cells but the one across the spall."""
        return np.delete(np.arange(self.bounds.size - 1), self.bounds.size // 2 - 1)

    @cached_property
    def _influence(self) -> np.ndarray:
        """Mean displacement of a cell by a unit force spread over another, over A."""
        low, high = self.bounds[self._solid], self.bounds[self._solid + 1]
        factor = 2.0 * self.compliance / abs(1.0 / self.radius + 1.0 / self.roller_radius)
        unit = 0.5 * exp(self.level - 0.5 + 0.5 * log(factor))  # δ = A Q (½ + ln(2 unit/b)), b² = factor·Q

        def twice(z):  # ∫∫ ln|z|
            size = np.where(z == 0.0, 1.0, np.abs(z))
            return 0.5 * z * z * np.log(size / unit) - 0.75 * z * z

        h, l_ = high[:, None], low[:, None]
        whole = twice(h - low) - twice(h - high) - twice(l_ - low) + twice(l_ - high)
        return -whole / np.outer(high - low, high - low)

    def gaps(self, place: float) -> np.ndarray:
        """Gaps along the line of centres, at a place of the chord, to a disc that would touch the sound raceway, m."""
        middle = 0.5 * (self.bounds[self._solid] + self.bounds[self._solid + 1])
        inside, e = np.clip(self.half_opening - np.abs(middle), 0.0, None), self.edge_radius
        depth = e - np.sqrt(np.maximum(e * e - np.minimum(inside, e) ** 2, 0.0))
        R, r = abs(self.radius), self.roller_radius
        surface = R + depth if self.radius < 0.0 else R - depth
        turned = np.arcsin(middle / R) - np.arcsin(place / R)
        along, across = surface * np.cos(turned), surface * np.sin(turned)
        reach = np.sqrt(r * r - across**2)
        return along - reach - (R - r) if self.radius < 0.0 else R + r - along - reach

    def press(self, place: float, approach: float) -> tuple[float, float]:
        """Force, N, and largest force per length of cell, N/m, at an approach from the sound raceway, m."""
        room = approach - self.gaps(place)
        near = np.flatnonzero(room > 0.0)
        if near.size == 0:
            return 0.0, 0.0
        lower = cholesky(self._influence[np.ix_(near, near)], lower=True)
        force, _ = nnls(lower.T, solve_triangular(lower, room[near] / self.compliance, lower=True))
        cells = np.diff(self.bounds)[self._solid][near]
        return float(force.sum()), float((force / cells).max())

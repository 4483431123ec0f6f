"""Shapes whose mesh is fine at the surface that rolls and coarsens away from it, for contacts that are resolved."""

import itertools
from dataclasses import dataclass
from functools import cached_property
from math import log2, pi
from typing import NamedTuple

import numpy as np

ROWS_PER_LEVEL = 8  # rows of nodes of a disc before their number is halved
SHARE_OF_RADIUS = 0.5  # the graded rim of a disc is no deeper
GROWTH = 1.0 / ROWS_PER_LEVEL  # of a ring's radial step per step
LONGEST_STEP = 32.0  # of a ring's radial step, over the surface spacing


class Row(NamedTuple):
    """A circle of equally spaced nodes of a disc or a ring."""

    radius: float  # m
    nodes: int
    shift: float = 0.0  # angle of the first one, in spacings


@dataclass(frozen=True, kw_only=True)
class GradedDisc:
    """A disc whose rows of nodes halve their number `levels` times towards the inside, one mean edge length apart.

    Inside, the k-th concentric layer from the centre has 6k nodes, as in `Disc`.
    """

    radius: float  # m
    layers: int  # the surface has 6·layers nodes; a multiple of 2^levels
    levels: int

    surface_nodes = property(lambda self: 6 * self.layers)

    @property
    def surface_spacing(self) -> float:
        """Arc between neighbouring surface nodes, m."""
        return 2.0 * pi * self.radius / self.surface_nodes

    repeats = property(lambda self: 6)  # How many times the mesh looks the same in one turn

    @cached_property
    def rows(self) -> list[Row]:
        """Every concentric row, from the centre outwards."""
        rows, radius, k = [], self.radius, self.layers
        for _ in range(self.levels):
            for _ in range(ROWS_PER_LEVEL):
                rows.append(Row(radius, 6 * k))
                radius *= 1.0 - 1.0 / k
            k //= 2
        rows += [Row(radius * i / k, 6 * i) for i in range(k, 0, -1)]
        return [Row(0.0, 1), *rows[::-1]]

    @property
    def n_cells(self) -> int:
        """Triangles: one per edge of every row, seen from either side."""
        counts = [row.nodes for row in self.rows[1:]]
        return 6 + sum(inner + outer for inner, outer in itertools.pairwise(counts))


@dataclass(frozen=True, kw_only=True)
class GradedAnnulus:
    """An annulus of equal sectors whose radial steps grow away from the raceway."""

    inner_radius: float  # m
    outer_radius: float  # m
    sectors: int
    raceway_outside: bool

    @cached_property
    def radii(self) -> np.ndarray:
        """Radii of the rows of nodes, m, the innermost first."""
        raceway = self.outer_radius if self.raceway_outside else self.inner_radius
        thickness = self.outer_radius - self.inner_radius
        spacing = 2.0 * pi * raceway / self.sectors
        steps = [spacing]
        while sum(steps) < thickness:
            steps.append(min(steps[-1] * (1.0 + GROWTH), LONGEST_STEP * spacing))
        depth = np.concatenate([[0.0], np.cumsum(steps)])
        depth *= thickness / depth[-1]
        return raceway - depth[::-1] if self.raceway_outside else raceway + depth

    layers = property(lambda self: len(self.radii) - 1)  # Radial element layers


def graded_disc(radius: float, spacing: float) -> GradedDisc:
    """The disc whose surface spacing is nearest to the one asked for, m."""
    layers = max(2, round(2.0 * pi * radius / (6.0 * spacing)))
    levels = max(0, int(log2(1.0 + SHARE_OF_RADIUS * layers / ROWS_PER_LEVEL)))
    return GradedDisc(radius=radius, layers=round(layers / 2**levels) * 2**levels, levels=levels)

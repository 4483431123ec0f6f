"""A ring held at some nodes of its outer circle only: it bends as a whole between them."""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from fem.elastic.bodies import RingBody
from lagrange.mounting import Points

FEWEST = 2  # nodes of a point: one would be a hinge
OFF = 0.1  # of the width asked for: held widths further off are warned of


@dataclass(frozen=True, kw_only=True)
class LooseRing(RingBody):
    """A `RingBody` of whose held row not all nodes stand still: those that do not are as free as any."""

    @property
    def free_rows(self) -> np.ndarray:
        return np.arange(self.n_rows)

    def on_held_row(self, component: int) -> np.ndarray:
        """Places of one component of the held row's nodes among the rows of `matrix`, (n_sectors,)."""
        return (2 * self.held_row + component) * self.n_sectors + np.arange(self.n_sectors)

    @cached_property
    def _influences(self) -> dict[bytes, np.ndarray]:
        return {}

    def surface_influence(self, nodes: np.ndarray) -> np.ndarray:
        """As `RingBody.surface_influence`; kept: contacts stay over their nodes while an equilibrium is found."""
        nodes = np.asarray(nodes)
        key = nodes.tobytes()
        if key not in self._influences:
            self._influences[key] = self._influence(nodes)
        return self._influences[key]

    def _influence(self, nodes: np.ndarray) -> np.ndarray:
        force = np.zeros((self.n_rows, 2, self.n_sectors, 2 * nodes.size))
        each = np.arange(nodes.size)
        for component in range(2):
            force[self.raceway_row, component, nodes, 2 * each + component] = 1.0
        found = self.held(force)[self.raceway_row][:, nodes]  # (component, node, unit force)
        return found.transpose(1, 0, 2).reshape(2 * nodes.size, 2 * nodes.size)


@dataclass(frozen=True, kw_only=True)
class SupportedRing(LooseRing):
    """A ring of whose held row some nodes stand still."""

    held_sectors: np.ndarray  # (n_held,), whole
    held_nodes: np.ndarray  # (n_points,), of each point
    width: float  # m, of each, as the scene asks for

    @property
    def n_free_nodes(self) -> int:
        return self.n_rows * self.n_sectors - len(self.held_sectors)

    @property
    def held_width(self) -> np.ndarray:
        """Width that the nodes of each point stand for, half an edge beyond either end, (n_points,), m."""
        return self.held_nodes * self.edge

    @property
    def edge(self) -> float:
        """Between nodes of the outside, m."""
        return 2.0 * np.pi * float(self.radii[self.held_row]) / self.n_sectors

    @property
    def words(self) -> str:
        """What holds it, as --dry-run shows it."""
        widths = ", ".join(f"{1e3 * width:.3g}" for width in self.held_width)
        return f"over {widths} mm, from nodes {1e3 * self.edge:.3g} mm apart, for width_mm = {1e3 * self.width:g}"

    @property
    def cautions(self) -> tuple[str, ...]:
        """A sentence where the mesh makes a held width of another size than was asked for."""
        if np.abs(self.held_width / self.width - 1.0).max() <= OFF:
            return ()
        return (
            f"support.width_mm = {1e3 * self.width:g}: the mesh holds the outer ring {self.words}; forces and "
            "displacements are those of the held widths; take a smaller numerics.mesh_size_mm or a wider point",
        )

    @cached_property
    def free_places(self) -> np.ndarray:
        held = np.concatenate([self.on_held_row(component)[self.held_sectors] for component in range(2)])
        return np.setdiff1d(np.arange(self.matrix.shape[0]), held)

    @cached_property
    def _factor(self):
        from scipy.sparse.linalg import splu  # see `DiscBody`

        return splu(self.matrix[self.free_places][:, self.free_places])

    def held(self, force: np.ndarray) -> np.ndarray:
        """As `RingBody.held`: displacement under nodal forces, (n_rows, 2, n_sectors, ...), polar, m and N."""
        flat = force.reshape(self.matrix.shape[0], -1)
        displacement = np.zeros_like(flat)
        displacement[self.free_places] = self._factor.solve(np.ascontiguousarray(flat[self.free_places]))
        return displacement.reshape(force.shape)


def supported_ring(ring: RingBody, points: Points) -> SupportedRing:
    """An outer ring held at points: all nodes within their width, and the FEWEST nearest of each."""
    radius = float(ring.radii[ring.held_row])
    held: list[set[int]] = []
    for angle in points.angles:
        apart = radius * np.abs(np.angle(np.exp(1j * (ring.angles - angle))))
        within = np.flatnonzero(apart <= 0.5 * points.width * (1.0 + 1e-9)).tolist()
        held.append({*within, *np.argsort(apart, kind="stable")[:FEWEST].tolist()})
    return SupportedRing(
        **own_fields(ring),
        held_sectors=np.array(sorted(set().union(*held))),
        held_nodes=np.array([len(nodes) for nodes in held]),
        width=points.width,
    )


def own_fields(ring: RingBody) -> dict[str, Any]:
    """What a `RingBody` is made of."""
    return {field.name: getattr(ring, field.name) for field in fields(RingBody)}

"""An outer ring held by its outside: in a bore with play or pressed in, or at some nodes only."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np
from scipy import sparse

from fem.elastic.bodies import RingBody
from lagrange.errors import UsageError
from lagrange.mounting import Bore, Points

FEWEST = 2  # nodes of a point: one would be a hinge
OFF = 0.1  # of the width asked for: held widths further off are warned of


@dataclass(frozen=True, kw_only=True)
class LooseRing(RingBody):
    """A `RingBody` of whose held row not all nodes stand still: those that do not are as free as any."""

    free_rows = property(lambda self: np.arange(self.n_rows))

    def on_held_row(self, component: int) -> np.ndarray:
        """Places of one component of the held row's nodes among the rows of `matrix`, (n_sectors,)."""
        return (2 * self.held_row + component) * self.n_sectors + np.arange(self.n_sectors)

    _influences = cached_property(lambda self: {})  # by nodes

    def surface_influence(self, nodes: np.ndarray) -> np.ndarray:
        """As `RingBody.surface_influence`; kept: contacts stay over their nodes while an equilibrium is found."""
        if (key := np.asarray(nodes).tobytes()) not in self._influences:
            self._influences[key] = self._influence(np.asarray(nodes))
        return self._influences[key]

    def _influence(self, nodes):
        places = self.surface_places(nodes)
        force = np.zeros((self.matrix.shape[0], places.size))
        force[places, np.arange(places.size)] = 1.0
        found = self.held(force.reshape(self.n_rows, 2, self.n_sectors, -1))
        return found.reshape(force.shape)[places]


@dataclass(frozen=True, kw_only=True)
class SupportedRing(LooseRing):
    """A ring of whose held row some nodes stand still."""

    held_sectors: np.ndarray  # (n_held,), whole
    held_nodes: np.ndarray  # (n_points,), of each point
    width: float  # m, of each, as the scene asks for

    # width that the nodes of each point stand for, half an edge beyond either end, (n_points,), m
    held_width = property(lambda self: self.held_nodes * self.edge)
    # between nodes of the outside, m
    edge = property(lambda self: 2.0 * np.pi * self.radii[self.held_row] / self.n_sectors)

    @property
    def words(self) -> str:
        """What holds it, as --dry-run shows it."""
        widths = ", ".join(f"{1e3 * width:.3g}" for width in self.held_width)
        return f"over {widths} mm, from nodes {1e3 * self.edge:.3g} mm apart, for width_mm = {1e3 * self.width:g}"

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence where the mesh makes a held width of another size than was asked for."""
        if np.abs(self.held_width / self.width - 1.0).max() <= OFF:
            return ()
        return (
            f"support.width_mm = {1e3 * self.width:g}: the mesh holds the outer ring {self.words}; results are for "
            "the held widths; use a smaller numerics.mesh_size_mm or a wider point",
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
    away = ring.angles - np.array(points.angles)[:, None]
    apart = ring.radii[ring.held_row] * np.abs(np.angle(np.exp(1j * away)))  # (n_points, n_sectors), m
    held = apart <= 0.5 * points.width * (1.0 + 1e-9)
    np.put_along_axis(held, np.argsort(apart, axis=1, kind="stable")[:, :FEWEST], True, axis=1)
    sectors, nodes = np.flatnonzero(held.any(axis=0)), held.sum(axis=1)
    return SupportedRing(**vars(replace(ring)), held_sectors=sectors, held_nodes=nodes, width=points.width)


LOOSE_SPRING = 1.0  # N/m along x and along y, keeps in place a ring that nothing holds
FIRST_ARC = 0.4 * pi  # rad to either side of straight down, where a ring in play is first taken to touch
FEWEST_SPRINGS = 8  # that act: fewer leave too little of the stiffness of all
MOST_SETTLINGS = 200  # measured at most 34 in 40 random rings, loads, fits and bores
NOT_SETTLED = "no static equilibrium: where the outer ring touches its bore is not found; change fit_clearance_um"


@dataclass(frozen=True, kw_only=True)
class BoredRing(LooseRing):
    """A ring in a bore that is centred on its own axes; `held` is linear, with those nodes on springs that touch.

    Node k of the held row is pushed inward by stiffness · (u_r − play) where that is positive. The mean of the row's
    u_θ is held at 0: without friction nothing else would keep the ring from turning.
    """

    play: float  # m, radial; negative: what the ring is larger by
    stiffness: float  # N/m, of the bore at one node
    touching: np.ndarray  # (n_sectors,), bool, where springs are taken to act
    surrounded: "BoredRing | None" = None  # the same ring with every spring, of which all sectors are alike

    @cached_property
    def _factor(self):
        springs, turning = np.zeros(self.matrix.shape[0]), np.zeros((1, self.matrix.shape[0]))
        springs[self.on_held_row(0)] = self.stiffness * self.touching + 2.0 * LOOSE_SPRING / self.n_sectors
        turning[0, self.on_held_row(1)] = self.stiffness  # of the matrix's size, for the factors' sake
        whole = sparse.bmat([[self.matrix + sparse.diags(springs), turning.T], [turning, None]], format="csc")
        from scipy.sparse.linalg import splu  # see `DiscBody`

        return splu(whole)

    @cached_property
    def _kernel(self):
        """With every spring, motion of all sectors by unit forces on sector 0, (3, n_sectors, 3), m/N.

        Moved and pushed: the raceway along both components, the held row along its radius.
        """
        rows, components = [self.raceway_row, self.raceway_row, self.held_row], [0, 1, 0]
        force = np.zeros((self.n_rows, 2, self.n_sectors, 3))
        force[rows, components, 0, range(3)] = 1.0
        return self.held(force)[rows, components]

    def _influence(self, nodes):
        """As `LooseRing._influence`: that of every spring, less those that do not act.

        Errors: round-off, over the share of all springs' stiffness, along an axis, that is left.

        Source: Woodbury's formula; Hager, SIAM Review 31 (1989) 221.
        """
        if self.touching.sum() < FEWEST_SPRINGS:
            return super()._influence(nodes)
        kernel, away = (self.surrounded or self)._kernel, np.flatnonzero(~self.touching)

        def between(moved, pushed):
            apart = (moved[:, None] - pushed) % self.n_sectors
            return kernel[:, apart].transpose(1, 0, 2, 3)  # (node moved, component, node pushed, component)

        found = between(nodes, nodes)[:, :2, :, :2].reshape(2 * nodes.size, -1)
        if away.size:
            by = between(nodes, away)[:, :2, :, 2].reshape(2 * nodes.size, -1)
            to = between(away, nodes)[:, 2, :, :2].reshape(away.size, -1)
            left = np.eye(away.size) / self.stiffness - between(away, away)[:, 2, :, 2]
            found = found + by @ np.linalg.solve(left, to)
        return found

    def held(self, force: np.ndarray) -> np.ndarray:
        """As `RingBody.held`, with the springs that act, at no other load."""
        flat = force.reshape(self.matrix.shape[0], -1)
        balanced = np.concatenate([flat, np.zeros((1, flat.shape[1]))])
        return self._factor.solve(balanced)[:-1].reshape(force.shape)

    def sag(self, gravity: float) -> np.ndarray:
        """As `RingBody.sag`; what a press fit does to the ring is part of it."""
        return self.held(self.body_load(gravity) + self._by_play)

    @property
    def _by_play(self):
        """What springs push beside stiffness · u_r, (n_rows, 2, n_sectors), N."""
        force = np.zeros((self.n_rows, 2, self.n_sectors))
        force[self.held_row, 0] = self.stiffness * self.play * self.touching
        return force

    def settled(self, displacement: np.ndarray) -> "BoredRing":
        """The ring with springs where it is in the bore, displaced so, (n_rows, 2, n_sectors), m; itself if it was."""
        touching = displacement[self.held_row, 0] > self.play
        return self if np.array_equal(touching, self.touching) else replace(self, touching=touching)

    def rested(self, force: np.ndarray) -> np.ndarray:
        """As `RingBody.rested`.

        Errors: UsageError: where it touches is not found.
        """
        ring = self
        for _ in range(MOST_SETTLINGS):
            found = ring.held(force + ring._by_play)
            if (following := ring.settled(found)) is ring:
                return found
            ring = following
        raise UsageError(NOT_SETTLED)

    def pressure_forces(self, displacement: np.ndarray) -> np.ndarray:
        """Inward forces of the bore on the nodes, (n_sectors,), N, of a ring displaced so."""
        return self.stiffness * np.maximum(displacement[self.held_row, 0] - self.play, 0.0)

    def springs(self, share: float) -> sparse.csc_matrix:
        """All springs at once, as `Model.springs` has those of contacts; `share`: what of each counts."""
        size = self.n_rows * 2 * self.n_sectors
        values = np.full(self.n_sectors, np.sqrt(share * self.stiffness))
        return sparse.csc_matrix((values, (self.on_held_row(0), np.arange(self.n_sectors))), (size, self.n_sectors))

    @cached_property
    def pressed_energy(self) -> float:
        """What a press fit alone stores in ring and bore, J, less than which a fitted ring never has."""
        if self.play >= 0.0:
            return 0.0
        alone = self.rested(np.zeros((self.n_rows, 2, self.n_sectors)))
        inside = self.pressure_forces(alone)
        return 0.5 * float(np.vdot(alone, self.force(alone)) + (inside @ inside) / self.stiffness)


def bored_ring(ring: RingBody, bore: Bore, thickness: float) -> BoredRing:
    """An outer ring, `thickness` long, m, in a bore: at first taken to touch below, where there is play."""
    radius, play = float(ring.radii[ring.held_row]), 0.5 * bore.clearance
    area = 2.0 * pi * radius / ring.n_sectors * thickness
    from_below = np.abs(np.angle(np.exp(1j * (ring.angles + 0.5 * pi))))
    whole = BoredRing(
        **vars(replace(ring)), play=play, stiffness=area * bore.stiffness_around(radius, ring.material.lame_mu),
        touching=np.full(ring.n_sectors, True),
    )  # fmt: skip
    first = whole.touching if play <= 0.0 else from_below < FIRST_ARC
    return replace(whole, surrounded=whole, touching=first)

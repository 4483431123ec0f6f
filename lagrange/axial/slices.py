"""Forces of a roller's slices by their approaches: each by the plane law, alone or with its neighbours.

A slice of n carries the n-th part of what the plane law gives the whole length. Coupled, it yields to the others too:
d = δ_law(n F) + Σ C F, F ≥ 0, C symmetric.
"""

from dataclasses import dataclass
from math import inf
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from lagrange.axial.table import TiltedContact

STEPS = 60  # of Newton's method
SETTLED = 1e-12  # of the largest approach
MATRICES = 2**22  # numbers in the matrices of contacts that are solved at once: 34 MB, which some copies share
FIRST = 1e-8  # m, beyond the opening, to begin with


class LineLaw(Protocol):
    """Force and energy of the whole length by its approach; `PowerLaw` and `LogarithmicLaw` are such laws."""

    def force(self, approach): ...

    def slope(self, approach): ...

    def potential(self, approach): ...

    def approach(self, force): ...


class Sums(NamedTuple):
    """Of the slices of contacts, (...,)."""

    energy: np.ndarray  # J
    force: np.ndarray  # N
    moment: np.ndarray  # N m, Σ F z


@dataclass(frozen=True, kw_only=True, eq=False)
class Slices:
    """The slices of one contact. SI."""

    law: LineLaw
    place: np.ndarray  # (n,), z of their middles
    drop: np.ndarray  # (n,), of roller and raceway together
    coupling: np.ndarray | None = None  # C, (n, n), m/N; None: each is alone
    part: np.ndarray | None = None  # (n,), bool, which of them spalls of part of the length let sink; None: none

    last_approach: ClassVar[float] = inf
    has_part: ClassVar[bool] = False

    @property
    def count(self) -> int:
        return self.place.size

    @property
    def is_symmetric(self) -> bool:
        """Whether a slope and its opposite have the same energy."""
        return bool(np.allclose(self.drop, self.drop[::-1], rtol=1e-12, atol=0.0))

    def approach_under(self, force, slope) -> np.ndarray:
        """Of contacts with slopes, rad, each under a force, N, of shapes that go together; m.

        Newton's method from above: the force is convex in the approach.
        """
        force, slope = np.broadcast_arrays(np.asarray(force, dtype=float), slope)
        place, way = self.opening(slope), FIRST + self.law.approach(force)
        while np.any(short := self.sums(place, slope).force < force):
            place, way = np.where(short, place + way, place), 2.0 * way
        for _ in range(STEPS):
            here = self.at(place, slope)
            step = (here.force - force) / np.where(here.stiffness > 0.0, here.stiffness, np.inf)
            place = place - step
            if np.all(np.abs(step) <= SETTLED * np.abs(place).max()):
                break
        return place

    def opening(self, slope) -> np.ndarray:
        """The approach, m, from which on a contact of this slope, rad, is closed."""
        return np.min(self.drop + np.asarray(slope)[..., None] * self.place, axis=-1)

    def approaches(self, approach, slope, sunk=0.0) -> np.ndarray:
        """Of the slices, (..., n), m: δ − P − ψ z, less what those of `part` have sunk, (...,), m."""
        found = np.asarray(approach)[..., None] - self.drop - np.asarray(slope)[..., None] * self.place
        return found if self.part is None else found - np.asarray(sunk)[..., None] * self.part

    def forces(self, approach, slope, sunk=0.0) -> np.ndarray:
        """Of the slices, (..., n), N, by approach, m, slope, rad, and what those of `part` have sunk, m, (...,).

        Errors
        ------
        RuntimeError: coupled slices do not settle; they are narrower than their contacts.
        """
        deep = self.approaches(approach, slope, sunk)
        if self.coupling is None:
            return self.law.force(deep) / self.count
        every = deep.reshape(-1, self.count)
        blocks = np.array_split(every, 1 + len(every) * self.count**2 // MATRICES)
        return np.concatenate([_coupled(self.law, self.coupling, each) for each in blocks]).reshape(deep.shape)

    def sums(self, approach, slope, sunk=0.0) -> Sums:
        """Energy, force and moment of contacts, (...,)."""
        return self._sums(self.approaches(approach, slope, sunk), self.forces(approach, slope, sunk))

    def _sums(self, deep: np.ndarray, forces: np.ndarray) -> Sums:
        """The same by the slices' approaches and forces, (..., n)."""
        if self.coupling is None:
            energy = self.law.potential(deep).mean(axis=-1)
        else:
            own = self.law.potential(self.law.approach(self.count * forces)).mean(axis=-1)
            energy = own + 0.5 * np.einsum("...k,kl,...l->...", forces, self.coupling, forces)
        return Sums(energy, forces.sum(axis=-1), forces @ self.place)

    def at(self, approach, slope, sunk=0.0) -> TiltedContact:
        """The same with derivatives, as a table has them."""
        approach, slope = np.asarray(approach, dtype=float), np.asarray(slope, dtype=float)
        deep, forces = self.approaches(approach, slope, sunk), self.forces(approach, slope, sunk)
        if self.coupling is None:
            by_approach = self.law.slope(deep) / self.count
            by_slope = by_approach * self.place
        else:
            stiff = self.law.slope(deep - forces @ self.coupling)[..., None] / self.count * np.eye(self.count)
            stiff = np.linalg.solve(np.eye(self.count) + stiff @ self.coupling, stiff)  # K (1 + C K)⁻¹, symmetric
            by_approach, by_slope = stiff.sum(axis=-1), stiff @ self.place
        return TiltedContact(
            *self._sums(deep, forces),
            stiffness=by_approach.sum(axis=-1),
            cross=-by_slope.sum(axis=-1),
            tilt_stiffness=by_slope @ self.place,
            part=forces @ (np.zeros(self.count) if self.part is None else self.part),
        )


def _coupled(law: LineLaw, coupling: np.ndarray, deep: np.ndarray) -> np.ndarray:
    """Forces, (m, n), N, of slices that yield to each other too, by approaches, (m, n), m.

    Newton's method on w + C F(w) = d, w the approach that the plane law sees: slices with w < 0 are open.
    """
    n = coupling.shape[0]
    own, left = deep.copy(), np.arange(len(deep))
    for _ in range(STEPS):
        w = own[left]
        missing = deep[left] - w - law.force(w) @ coupling / n
        far = np.abs(missing).max(axis=1) > SETTLED * np.abs(deep[left]).max(axis=1)
        left, w, missing = left[far], w[far], missing[far]
        if not left.size:
            return law.force(own) / n
        matrix = np.eye(n) + coupling * (law.slope(w) / n)[:, None, :]
        own[left] = w + np.linalg.solve(matrix, missing[..., None])[..., 0]
    raise RuntimeError(f"{left.size} of {len(deep)} contacts of {n} coupled slices do not settle; lower axial.slices")

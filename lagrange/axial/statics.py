"""Equilibrium of a bearing whose rollers tilt: hub, slope of the shaft, radii and tilts of the rollers.

Rollers stand at given angles and are guided: they move along the radius and tilt in the plane of axis and radius.
Contacts are slices; elastic bodies' couplings are linear in the contacts' forces.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lagrange.axial.slices import Slices
from lagrange.axial.table import TiltedContact
from lagrange.bearing import Bearing

STEPS, COUPLED_STEPS = 200, 50  # of Newton's method; 10 to 20, and 3 to 5, are usual
SHORTER, SHORTEST = 0.5, 1e-6  # of steps by which the energy would rise
BALANCED = 1e-8  # of the load
AGREED = 1e-11  # of the load: forces and the approaches that they leave
LOOSE_SPRING = 1.0  # N/m, holds what no contact does; on tilts and slope at half a roller's length
DAMPING, MORE, LESS = 1e-6, 10.0, 0.1  # Levenberg and Marquardt's, of the contacts' stiffness


@dataclass(frozen=True, kw_only=True)
class TiltedStatics:
    """A bearing in equilibrium. SI; of contacts (2, n_rollers), inner ones first."""

    hub: np.ndarray  # (2,)
    hub_slope: np.ndarray  # (2,), rad: the shaft's axis at z is at the hub's place plus z times it
    rho: np.ndarray  # (n_rollers,)
    tilt: np.ndarray  # (n_rollers,), rad; > 0: the +z end outwards
    approach: np.ndarray
    slope: np.ndarray  # of roller and ring to each other, rad
    force: np.ndarray  # N
    moment: np.ndarray  # N m
    hub_moment: np.ndarray  # (2,), N m, from outside, that holds the shaft's slope; work is moment times slope
    stiffness: np.ndarray  # (4, 4), by hub and slope, rollers in equilibrium again: N/m, N/rad, N m/rad


Springs = tuple[np.ndarray, np.ndarray]


class _State(NamedTuple):
    """Of hub, slope, radii and tilts, (4 + 2 n,)."""

    energy: float
    gradient: np.ndarray
    force: np.ndarray  # (2 n,), N
    approach: np.ndarray
    slope: np.ndarray
    contact: TiltedContact
    by_approach: np.ndarray  # (2 n, 4 + 2 n)
    by_slope: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltedBearing:
    """What stands in equilibrium."""

    bearing: Bearing
    angle: np.ndarray  # (n_rollers,), rad from +x
    slices: tuple[Slices, Slices]  # of the inner and the outer contact
    load: tuple[float, float]  # N, on the hub
    shaft_tilt_stiffness: float | None = None  # N m/rad, against a slope that is free; None: it is prescribed
    compliance: np.ndarray | None = None  # (2 n, 2 n), m/N, of contacts by each other's forces; None: rigid bodies

    def equilibrium(self, slope: tuple[float, float], start: np.ndarray | None = None) -> TiltedStatics:
        """Where the energy is least.

        Parameters
        ----------
        slope : rad, of the shaft; where it is free, to begin with
        start : (4 + 2 n_rollers,), hub, slope, radii and tilts, near by

        Errors
        ------
        RuntimeError: no equilibrium is found.
        """
        x, rest = self._first(slope) if start is None else start.copy(), self._springs(slope)
        x[2:4] = slope
        free = np.ones(x.size, dtype=bool)
        free[2:4] = self.shaft_tilt_stiffness is not None
        size, damping = max(float(np.hypot(*self.load)), 1e-3), 0.0
        state = self._state(x, np.zeros(2 * self.angle.size), rest)
        for _ in range(STEPS):
            left = np.abs(state.gradient / self._units)[free].max()
            if left <= BALANCED * size:
                return self._answer(x, state, rest)
            hessian = self._hessian(x, state, rest)[np.ix_(free, free)]
            scale = np.diag(self._units[free] ** 2) * float(state.contact.stiffness.max() + LOOSE_SPRING)
            step = np.zeros(x.size)
            step[free] = -np.linalg.solve(hessian + damping * scale, state.gradient[free])
            length = 1.0 if step @ state.gradient < 0.0 else 0.0
            while length >= SHORTEST:
                new = self._state(x + length * step, state.force, rest)
                if new.energy <= state.energy + 1e-13 * (abs(state.energy) + size * 1e-6):
                    break
                length *= SHORTER
            else:
                damping = max(MORE * damping, DAMPING)
                continue
            damping = damping * LESS if damping > DAMPING else 0.0
            x, state = x + length * step, new
        raise RuntimeError(f"no equilibrium of tilted rollers: {left:.2e} N are unbalanced after {STEPS} steps")

    @property
    def _units(self) -> np.ndarray:
        """Of unbalanced forces and moments, in forces, (4 + 2 n,)."""
        n, arm = self.angle.size, 0.5 * self.bearing.roller_length
        return np.concatenate([[1.0, 1.0, arm, arm], np.ones(n), np.full(n, arm)])

    def _first(self, slope: tuple[float, float]) -> np.ndarray:
        """The hub pushed so that one roller carries the load, rollers midway and half as steep as the shaft."""
        load, b = np.array(self.load), np.array(slope)
        size = max(float(np.hypot(*load)), 1e-3)
        deep = max(self.slices[0].straight_approach(0.5 * size), 0.0)
        hub = (max(self.bearing.radial_clearance, 0.0) + 2.0 * deep) * load / size
        radial = np.column_stack([np.cos(self.angle), np.sin(self.angle)])
        return np.concatenate([hub, b, self.bearing.pitch_radius + 0.5 * radial @ hub, 0.5 * radial @ b])

    def _geometry(self, x: np.ndarray):
        """Approaches, slopes and their derivatives, of rigid bodies; ways along the inner contacts; their distances."""
        bearing, n, angle = self.bearing, self.angle.size, self.angle
        radial = np.column_stack([np.cos(angle), np.sin(angle)])
        hub, b, rho, tilt = x[:2], x[2:4], x[4 : 4 + n], x[4 + n :]
        from_hub = radial * rho[:, None] - hub
        apart = np.hypot(*from_hub.T)
        normal = from_hub / apart[:, None]
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        turned = radial * tilt[:, None] - b
        reach = bearing.roller_radius
        approach = np.concatenate(
            [bearing.inner_raceway_radius + reach - apart, rho + reach - bearing.outer_raceway_radius]
        )
        slope = np.concatenate([np.sum(turned * normal, axis=1), -tilt])
        by_approach, by_slope, across = np.zeros((2 * n, x.size)), np.zeros((2 * n, x.size)), np.zeros((n, x.size))
        j, along = np.arange(n), np.sum(radial * normal, axis=1)
        by_approach[:n, :2], by_approach[j, 4 + j], by_approach[n + j, 4 + j] = normal, -along, 1.0
        across[:, :2], across[j, 4 + j] = -tangent, np.sum(radial * tangent, axis=1)
        by_slope[:n] = (np.sum(turned * tangent, axis=1) / apart)[:, None] * across
        by_slope[:n, 2:4], by_slope[j, 4 + n + j], by_slope[n + j, 4 + n + j] = -normal, along, -1.0
        return approach, slope, by_approach, by_slope, across, apart

    def _contacts(self, approach: np.ndarray, slope: np.ndarray) -> TiltedContact:
        n = self.angle.size
        both = [slices.at(approach[k], slope[k])
                for slices, k in zip(self.slices, (slice(0, n), slice(n, None)), strict=True)]  # fmt: skip
        return TiltedContact(*(np.concatenate(pair) for pair in zip(*both, strict=True)))

    def _state(self, x: np.ndarray, near: np.ndarray, rest: Springs) -> _State:
        rigid, slope, by_approach, by_slope, _, _ = self._geometry(x)
        approach, contact = rigid, self._contacts(rigid, slope)
        energy = 0.0
        if self.compliance is not None:
            approach, contact = self._coupled(rigid, slope, near)
            energy = 0.5 * float(contact.force @ self.compliance @ contact.force)
        springs, middle = rest
        energy += float(contact.energy.sum() + 0.5 * np.sum(springs * (x - middle) ** 2) - np.dot(self.load, x[:2]))
        gradient = by_approach.T @ contact.force - by_slope.T @ contact.moment + springs * (x - middle)
        gradient[:2] -= self.load
        return _State(energy, gradient, contact.force, approach, slope, contact, by_approach, by_slope)

    def _coupled(self, rigid: np.ndarray, slope: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, TiltedContact]:
        """Approaches that forces leave, and contacts under these: Q = Q(δ − C Q, ψ)."""
        assert self.compliance is not None
        force, one = near, np.eye(near.size)
        for _ in range(COUPLED_STEPS):
            approach = rigid - self.compliance @ force
            contact = self._contacts(approach, slope)
            missing = contact.force - force
            if np.abs(missing).max() <= AGREED * max(float(np.abs(force).max()), 1.0):
                return approach, contact
            force = force + np.linalg.solve(one + contact.stiffness[:, None] * self.compliance, missing)
        raise RuntimeError("forces of tilted contacts and the approaches that they leave do not agree")

    def _springs(self, slope: tuple[float, float]) -> Springs:
        """On every coordinate, and where they rest, (4 + 2 n,)."""
        springs, middle, n = LOOSE_SPRING * self._units**2, np.zeros(self._units.size), self.angle.size
        middle[2:4], middle[4 : 4 + n] = slope, self.bearing.pitch_radius
        if self.shaft_tilt_stiffness is not None:
            springs[2:4] += self.shaft_tilt_stiffness
        return springs, middle

    def _hessian(self, x: np.ndarray, state: _State, rest: Springs) -> np.ndarray:
        contact, B, P = state.contact, state.by_approach, state.by_slope
        stiffness, cross, tilt = (part[:, None] for part in (contact.stiffness, contact.cross, contact.tilt_stiffness))
        by_force, closing = stiffness * B + cross * P, B
        if self.compliance is not None:
            by_force = np.linalg.solve(np.eye(B.shape[0]) + stiffness * self.compliance, by_force)
            closing = B - self.compliance @ by_force
        _, _, _, _, across, apart = self._geometry(x)
        n = self.angle.size
        turning = across.T @ ((state.force[:n] / apart)[:, None] * across)
        return B.T @ by_force + P.T @ (cross * closing + tilt * P) - turning + np.diag(rest[0])

    def _answer(self, x: np.ndarray, state: _State, rest: Springs) -> TiltedStatics:
        n = self.angle.size
        hessian = self._hessian(x, state, rest)
        follow = np.linalg.solve(hessian[4:, 4:], hessian[4:, :4])
        gradient = state.gradient - rest[0] * (x - rest[1])
        return TiltedStatics(
            hub=x[:2],
            hub_slope=x[2:4],
            rho=x[4 : 4 + n],
            tilt=x[4 + n :],
            approach=state.approach.reshape(2, n),
            slope=state.slope.reshape(2, n),
            force=state.force.reshape(2, n),
            moment=state.contact.moment.reshape(2, n),
            hub_moment=gradient[2:4],
            stiffness=hessian[:4, :4] - hessian[:4, 4:] @ follow,
        )

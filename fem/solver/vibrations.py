"""Modes of the reduced model's bodies: their arrays, where they begin, and how long a step may be with them."""

from math import ceil, inf, pi, sqrt

import numpy as np

from fem.elastic.vibration import Modes
from fem.kernels.lanes import WIDTH
from fem.kernels.reduced_state import RingModes, RollerModes, Vibrations
from fem.solver.reduced_start import ReducedStart
from fem.statics.reduced_bearing import ReducedBearing
from fem.statics.vibrating_bearing import BearingModes
from lagrange.kinematics import roller_angles

# rad, of the fastest mode in a step at a safety of 1; energy of rollers that rattle without friction takes shorter ones
TURN, FRICTIONLESS_TURN = 1.5, 1.0
STEADY = 1e-3  # of a step: how closely the critical one is found
MOST_LOOKS = 30


def leapfrogs_mass(frequency: np.ndarray, dt: float) -> np.ndarray:
    """Modal masses, kg, with which leapfrog's steps have the frequencies, rad/s, of modes of 1 kg: (x/sin x)²."""
    return 1.0 / np.sinc(frequency * dt / (2.0 * pi)) ** 2


def longest_with_modes(modes: BearingModes | None, friction: float) -> float:
    """The longest step, s, that follows modes; infinite without them."""
    return inf if modes is None else (TURN if friction > 0.0 else FRICTIONLESS_TURN) / modes.highest


def critical_with_modes(model: ReducedBearing, force: float, hub_mass: float) -> float:
    """2/ω_max, s, of hub, rollers and all modes, every contact closed under a force, N.

    Modal masses grow with the step, so it is sought from below, where every step is stable.
    """
    from scipy.linalg import eigh  # takes its time to load, and most scenes have no modes

    stiffness, masses, frequency = _coupled(model, force, hub_mass)
    dt = 0.0
    for _ in range(MOST_LOOKS):
        mass = np.concatenate([masses, leapfrogs_mass(frequency, dt)])
        scale = 1.0 / np.sqrt(mass)
        fastest = eigh(
            scale[:, None] * stiffness * scale, eigvals_only=True, subset_by_index=[len(mass) - 1, len(mass) - 1]
        )[0]
        before, dt = dt, 2.0 / sqrt(float(fastest))
        if dt - before <= STEADY * dt:
            break
    return dt


def _coupled(model: ReducedBearing, force: float, hub_mass: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, N/m, of hub, rollers' radial motion and modes; masses, kg, of the first two; modes' frequencies."""
    n, modes = model.bearing.n_rollers, model.modes
    soft = np.zeros((2, n, 2, n))
    rollers = np.arange(n)
    for row, law in enumerate((model.inner_law, model.outer_law)):
        soft[row, rollers, row, rollers] = law.softness(force)
        soft[row, rollers, 1 - row, rollers] = model.across
        for distance, along in zip(model.rings.distance, model.rings.along[row], strict=True):
            soft[row, rollers, row, (rollers + distance) % n] += along
    angle = roller_angles(model.bearing, 0.0)
    own, sign = modes.roller.shape, np.where(modes.roller.order % 2 == 0, 1.0, -1.0)
    rises = []
    for row, ring in ((0, modes.inner), (1, modes.outer)):
        rigid = np.column_stack([np.cos(angle), np.sin(angle)]) * (1.0 - row)
        travel = (-1.0 if row == 0 else 1.0) * np.eye(n)
        rolled = np.kron(np.eye(n), -own * (sign if row == 0 else 1.0))
        waves = [-turned(np.multiply.outer(angle, ring.order)) * ring.shape for turned in (np.cos, np.sin)]
        none = [np.zeros((n, 2 * len(modes.inner.order))), np.zeros((n, 2 * len(modes.outer.order)))]
        none[row] = np.hstack(waves)
        rises.append(np.hstack([rigid, travel, rolled, *none]))
    rise = np.vstack(rises)
    frequency = np.concatenate(
        [np.tile(modes.roller.frequency, n), *(np.tile(r.frequency, 2) for r in modes.bodies[1:])]
    )
    stiffness = rise.T @ np.linalg.solve(soft.reshape(2 * n, 2 * n), rise)
    oscillators = np.arange(2 + n, len(stiffness))
    stiffness[oscillators, oscillators] += frequency**2
    return stiffness, np.concatenate([[hub_mass] * 2, np.full(n, model.bearing.roller_mass)]), frequency


def vibrations(
    model: ReducedBearing, start: ReducedStart, load: tuple[float, float], columns: int, dt: float
) -> Vibrations | None:
    """Modes at rest as far out as the start's forces hold them, and the load at the hub, x and y, N, if any yet."""
    if model.modes is None:
        return None
    n = model.bearing.n_rollers
    inner, outer = start.inner_force, start.outer_force
    # a body's contacts lie where the normals are: of rollers the inner one opposite to the outer one
    to_hub = np.arctan2(*(start.rho * np.array([np.sin(start.angle), np.cos(start.angle)]) - start.hub[::-1, None]))
    rings = []
    for modes, angle, force, hub in (
        (model.modes.inner, to_hub, inner, load), (model.modes.outer, start.angle, outer, (0.0, 0.0))
    ):  # fmt: skip
        found, place = _ring_arrays(modes, dt)
        for twin, turned in enumerate((np.cos, np.sin)):
            push = modes.shape * (turned(np.multiply.outer(modes.order, angle)) @ force)
            found.amplitude[place[0], twin, place[1]] = (push + hub[twin] * modes.carried) / modes.frequency**2
        rings.append(found)
    modes = model.modes.roller
    roller = _roller_arrays(modes, columns, dt)
    for twin, turned in enumerate((np.cos, np.sin)):
        push = turned(np.multiply.outer(modes.order, to_hub + pi)) * inner
        push += turned(np.multiply.outer(modes.order, start.angle)) * outer
        roller.amplitude[:, twin, :n] = push * (modes.shape / modes.frequency**2)[:, None]
    return Vibrations(roller=roller, inner=rings[0], outer=rings[1], lean=np.zeros((2, columns)))


def _roller_arrays(modes: Modes, columns: int, dt: float) -> RollerModes:
    order, size = modes.order, (len(modes.order), 2, columns)
    orders, mass = int(order.max(initial=-1)) + 1, leapfrogs_mass(modes.frequency, dt)
    return RollerModes(
        start=np.searchsorted(order, np.arange(orders + 1)).astype(np.intp),
        shape=modes.shape,
        stiffness=modes.frequency**2,
        mass=mass,
        kick=dt / mass,
        amplitude=np.zeros(size),
        rate=np.zeros(size),
        before=np.zeros(size),
    )


def _ring_arrays(modes: Modes, dt: float) -> tuple[RingModes, tuple[np.ndarray, np.ndarray]]:
    """A ring's modes in layers, at rest, and the layer and number of waves of each."""
    order = modes.order
    orders = int(order.max(initial=-1)) + 1
    layer = np.arange(len(order)) - np.searchsorted(order, order)
    layers, room = int(layer.max(initial=-1)) + 1, WIDTH * ceil(orders / WIDTH)

    def laid(values: np.ndarray, elsewhere: float = 0.0) -> np.ndarray:
        found = np.full((layers, room), elsewhere)
        found[layer, order] = values
        return found

    mass = laid(leapfrogs_mass(modes.frequency, dt), 1.0)
    found = RingModes(
        orders=orders,
        shape=laid(modes.shape),
        carried=laid(modes.carried),
        stiffness=laid(modes.frequency**2),
        mass=mass,
        kick=dt / mass,
        amplitude=np.zeros((layers, 2, room)),
        rate=np.zeros((layers, 2, room)),
        before=np.zeros((layers, 2, room)),
        wave=np.zeros((2, room)),
        push=np.zeros((2, room, WIDTH)),
    )
    return found, (layer, order)

"""A roller on a raceway as two half-spaces: Love's rectangles, convolved by FFT, and constrained conjugate gradients.

The yardstick of slices: nothing is assumed of the pressure's shape. Half-spaces end nowhere; real rollers do, and their
end faces are left out on both sides of a comparison.

Sources: Love 1929 (Johnson, Contact Mechanics, 1985, 3.25); Polonsky and Keer, Wear 231 (1999) 206.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy import fft

SETTLED = 1e-7  # of pressures, from one step to the next
STEPS = 600


@dataclass(frozen=True, kw_only=True)
class Pressed:
    """Of two half-spaces in contact. SI."""

    pressure: np.ndarray  # (n_across, n_along), Pa
    place: np.ndarray  # (n_along,), m, of cells along the roller
    approach: float  # m
    moment: float  # N m, Σ Q z of the load, > 0 towards +z

    @property
    def peak(self) -> tuple[float, float]:
        """Largest pressure, Pa, and where along the roller, m."""
        along = self.pressure.max(axis=0)
        at = int(along.argmax())
        return float(along[at]), float(self.place[at])


def pressed(
    radius: float, length: float, modulus: float, load: float, drop, slope: float, cells=(64, 256), wide: float = 1e-4
) -> Pressed:
    """A roller under a load.

    Parameters
    ----------
    radius : R, m, of the contact; modulus : E*, Pa; load : N
    drop : of z, m, the profile; slope : rad, of roller and raceway to each other; the gap grows by slope · z
    wide : m, half of the width that is meshed
    """
    across, along = cells
    dx, dy = 2.0 * wide / across, length / along
    x = (np.arange(across) + 0.5 - 0.5 * across) * dx
    y = (np.arange(along) + 0.5 - 0.5 * along) * dy
    gap = x[:, None] ** 2 / (2.0 * radius) + drop(y) + slope * y
    kernel = fft.rfft2(_love(dx, dy, 2 * across, 2 * along)) / (pi * modulus)

    def displaced(pressure):
        return fft.irfft2(kernel * fft.rfft2(pressure, s=(2 * across, 2 * along)), s=(2 * across, 2 * along))[
            :across, :along
        ]

    area = dx * dy
    pressure = np.maximum(1.0 - gap / np.quantile(gap, 0.3), 0.0)
    pressure *= load / (pressure.sum() * area)
    direction, before, restart = np.zeros_like(gap), 1.0, 0.0
    for _ in range(STEPS):
        residual = displaced(pressure) + gap
        loaded = pressure > 0.0
        residual -= residual[loaded].mean()
        now = float(np.sum(residual[loaded] ** 2))
        direction = np.where(loaded, residual + restart * now / before * direction, 0.0)
        answer = displaced(direction)
        answer -= answer[loaded].mean()
        size = np.sum(residual[loaded] * direction[loaded]) / np.sum(answer[loaded] * direction[loaded])
        last = pressure
        pressure = np.maximum(pressure - size * direction, 0.0)
        joined = (pressure <= 0.0) & (residual < 0.0)
        pressure[joined] -= size * residual[joined]
        restart, before = float(not joined.any()), now
        pressure *= load / (pressure.sum() * area)
        if np.abs(pressure - last).sum() <= SETTLED * pressure.sum():
            break
    else:
        raise RuntimeError("pressures do not settle")
    total = displaced(pressure) + gap
    return Pressed(
        pressure=pressure,
        place=y,
        approach=float(total[pressure > 0.0].mean()),
        moment=-float(pressure.sum(axis=0) @ y) * area,
    )


def _love(dx: float, dy: float, across: int, along: int) -> np.ndarray:
    """∬ 1/r over a rectangle at the origin seen from cells of a grid that wraps around, m."""
    x = np.minimum(np.arange(across), across - np.arange(across))[:, None] * dx
    y = np.minimum(np.arange(along), along - np.arange(along))[None, :] * dy

    def corner(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    a, b = 0.5 * dx, 0.5 * dy
    return corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b)

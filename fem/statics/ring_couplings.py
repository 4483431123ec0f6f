"""How a bearing's contacts feel forces on others along their ring, at and near equal angles."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from fem.elastic.vibration import Modes
from fem.statics.exact_statics import couplings_at, crossings_at
from lagrange import Bearing

FAINT = 1e-6  # of a contact's own compliance: a neighbour's force that moves it less is left out
STRAYS = 0.25  # of the rollers' distance, by which compliances follow their angles
FAINT_CHANGE = 1e-4  # of a contact's own compliance: what changes less over that is left out
FAINT_TRACTION = 5e-3  # of a contact's own compliance: a neighbour's traction, a tenth of a force at most, likewise


@dataclass(frozen=True, kw_only=True)
class RingCouplings:
    """Compliances by neighbours, polynomials of how much further than at equal angles these are."""

    distance: np.ndarray  # (neighbours,), in rollers: −1, 1, −2 ...
    felt: np.ndarray  # (2, 2), whole: by ring, of how many the angles matter, and how many do themselves
    along: np.ndarray  # (2, neighbours), m/N
    steep: np.ndarray  # (2, neighbours), m/N per rad
    bent: np.ndarray  # (2, 4, neighbours), m/N/rad² to m/N/rad⁵
    strays: float  # rad, how much nearer or further
    crossed: np.ndarray  # (2, neighbours), m/N, by tractions on these rollers along +θ, at equal angles
    crossing: np.ndarray  # (2,), whole: by ring, of how many they matter


def strays(n_rollers: int) -> float:
    """By how much, rad, angles between rollers may be smaller or larger; beyond, compliances stay."""
    return STRAYS * 2.0 * pi / n_rollers


def series_around(bearing: Bearing) -> np.ndarray:
    """Compliances and slopes a bit less far, as far and further than 1, 2 ... of n equal parts: (2, 2, 3, n // 2)."""
    n = bearing.n_rollers
    shift = 2.0 * pi / n * np.arange(1, n // 2 + 1)
    angles = np.add.outer(strays(n) * np.array([-1.0, 0.0, 1.0]), shift)
    return couplings_at(bearing, angles.ravel()).reshape(2, 2, *angles.shape)


def crossed_series(bearing: Bearing) -> np.ndarray:
    """What a raceway gives way by a traction 1, 2 ... of n equal parts behind: (2, n // 2)."""
    n = bearing.n_rollers
    return crossings_at(bearing, 2.0 * pi / n * np.arange(1, n // 2 + 1))


def ring_couplings(
    bearing: Bearing, series: np.ndarray, crossed: np.ndarray, rings: Sequence[Modes], own: float
) -> RingCouplings:
    """Couplings by `series_around`, less what modes of the rings carry, and by `crossed_series`.

    `rings` : of both, or none; `own` : m/N, compliance of a contact, over ln Q.
    """
    n, h = bearing.n_rollers, strays(bearing.n_rollers)
    distance = np.array([d for k in range(1, n // 2 + 1) for d in ((-k, k) if 2 * k < n else (k,))], dtype=np.intp)
    ahead = distance > 0
    given, slope = series[:, :, :, np.abs(distance) - 1].swapaxes(0, 1)
    given = np.where(ahead, given, given[:, ::-1])  # an even function of the angle
    slope = np.where(ahead, slope, -slope[:, ::-1])
    angles = np.add.outer(h * np.array([-1.0, 0.0, 1.0]), 2.0 * pi / n * distance)
    for row, ring in enumerate(rings):
        given[row] -= ring.compliance(angles)
        slope[row] -= ring.slope(angles)
    along, steep, bent = given[:, 1], slope[:, 1], _bent(given, slope, h)
    changed = np.abs(given - given[:, 1:2]).max(axis=1)
    count = [_last(row, FAINT * own) for row in np.abs(along)]
    near = [min(_last(row, FAINT_CHANGE * own), most) for row, most in zip(changed, count, strict=True)]
    # an odd function of the angle; what pulls a roller along pulls its ring back
    crossed = np.where(ahead, crossed[:, np.abs(distance) - 1], -crossed[:, np.abs(distance) - 1])
    pulled = [_last(row, FAINT_TRACTION * own) for row in np.abs(crossed)]
    kept = slice(max(count + pulled))
    along, steep, bent, crossed = (np.ascontiguousarray(array[..., kept]) for array in (along, steep, bent, crossed))
    return RingCouplings(
        distance=distance[kept],
        felt=np.array([near, count], dtype=np.intp).T.copy(),
        along=along,
        steep=steep,
        bent=bent,
        strays=h,
        crossed=crossed,
        crossing=np.array(pulled, dtype=np.intp),
    )


def _bent(given: np.ndarray, slope: np.ndarray, h: float) -> np.ndarray:
    """Coefficients of x² to x⁵ of the polynomials with values and slopes, (2, 3, neighbours), at −h, 0, h."""
    even = 0.5 * (given[:, 2] + given[:, 0]) - given[:, 1]
    odd = 0.5 * (given[:, 2] - given[:, 0]) - h * slope[:, 1]
    of_even, of_odd = 0.5 * h * (slope[:, 2] - slope[:, 0]), h * (0.5 * (slope[:, 2] + slope[:, 0]) - slope[:, 1])
    fourth, fifth = 0.5 * of_even - even, 0.5 * of_odd - 1.5 * odd
    found = (even - fourth) / h**2, (odd - fifth) / h**3, fourth / h**4, fifth / h**5
    return np.stack(found, axis=1)


def _last(values: np.ndarray, limit: float) -> int:
    """How many values there are up to the last one beyond a limit."""
    return int(np.flatnonzero(values > limit).max(initial=-1)) + 1

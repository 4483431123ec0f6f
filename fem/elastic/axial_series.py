"""Exact answer of circular elastic bodies to line loads that vary along the axis, by harmonics around and along it.

A pressure cos nθ cos kz on a cylinder's surface displaces it by C_n(k) cos nθ cos kz. The plane series is C_n(0); waves
along the axis add to the approach of a contact the sum of C_n(k) − C_n(0) over n, the difference D(k), by which slices
that carry unequal loads yield to each other.

With u_r = U cos nθ cos kz, u_θ = V sin nθ cos kz, u_z = W cos nθ sin kz, three solutions of Navier's equations follow
from each harmonic function f(r) cos nθ cos kz, f = I_n(kr) or K_n(kr): its gradient, the curl of its turned copy along
the axis, and ∇(r ∂_r φ) + 4(1 − ν) ∂_z φ e_z. They are combined so that none is nearly another at large n.
"""

from itertools import accumulate
from math import asinh, log, pi

import numpy as np

from fem.elastic.continuum import Section, plane_compliance
from lagrange.bearing import Material

FEWEST = 200  # harmonics summed one by one; the rest, as of a half-space, in closed form
PER_WAVE = 6.0  # harmonics per kR
DECOUPLED = 40.0  # e-folds between held and loaded surface, beyond which neither knows the other
HIGHEST = 40.0  # waves along the axis per radius or thickness: beyond, bodies are half-spaces
SHORTEST = 100.0  # waves per slice; shorter ones are summed in closed form
STARTED = 30  # orders above the last from which ratios of I_n are recurred downwards


def axial_difference(body: Section, k: float) -> float:
    """D(k), m per N/m: displacement under a line load cos kz less that under an even one; positive into the body.

    k : 1/m, > 0

    Errors: 5e-5 of 1/(π E'), of the closed sum of high harmonics.
    """
    if body.material.rigid:
        return 0.0
    last = 2 * int(max(FEWEST, PER_WAVE * k * body.loaded) / 2.0)
    n = np.arange(0, last + 1, body.loads)
    terms = harmonic_compliance(body, n, k) - plane_compliance(body, n)
    terms[0] *= 0.5
    step = float(body.loads)  # two loads squeeze a roller: even harmonics alone, doubled
    x, beyond = k * body.loaded, last + 0.5 * step
    rest = log(2.0 * beyond / x) - asinh(beyond / x)  # ∫ 1/√(n² + x²) − 1/n over n
    total = step * float(np.sum(terms)) + 2.0 * body.loaded / body.material.plane_strain_modulus * rest
    return total / (pi * body.loaded)


def slice_compliance(body: Section, length: float, width: float, slices: int) -> np.ndarray:
    """What slices' forces add to their displacements beyond the plane law, mean over a slice, (slices, slices), m/N.

    length : m, on which the slices lie; width : m, of the body, whose end faces are free of shear and lie still

    Errors: 1e-6 of 1/(π E' h), h the slices' width, of short waves.
    """
    if body.material.rigid:
        return np.zeros((slices, slices))
    h, roller = length / slices, body.loads == 2
    place = (np.arange(slices) + 0.5 - 0.5 * slices) * h + 0.5 * width
    k = pi / width * np.arange(1, int(SHORTEST * 2.0 * width / h) + 1)
    exact = k <= HIGHEST / min(body.loaded, body.thickness)
    unit = pi * body.material.plane_strain_modulus
    difference = np.empty(k.size)
    difference[exact] = [axial_difference(body, each) for each in k[exact]]
    depth = difference[exact][-1] + 2.0 / unit * log(k[exact][-1])  # half-space from there on: −2 ln k/(π E')
    difference[~exact] = depth - 2.0 / unit * np.log(k[~exact])
    found = np.full((slices, slices), axial_limit(body.material) / width if roller else 0.0)
    for part in np.array_split(np.arange(k.size), max(1, k.size // 4096)):
        waves = np.cos(np.outer(place, k[part])) * np.sinc(k[part] * h / (2.0 * pi))
        found += 2.0 / width * (waves * difference[part]) @ waves.T
    # of shorter ones squares of cosine and sine have their means; of these neighbours share half
    beside = np.eye(slices) - 0.5 * (np.eye(slices, k=1) + np.eye(slices, k=-1))
    return found + 2.0 / (pi * h * h * k[-1]) * (difference[-1] - 2.0 / unit) * beside


def axial_limit(material: Material) -> float:
    """D of a roller at k → 0, m per N/m: it grows along the axis under an even load, and a plane section does not."""
    nu = material.poisson_ratio
    return 2.0 * nu**2 / (1.0 - nu**2) / (pi * material.plane_strain_modulus)


def harmonic_compliance(body: Section, n: np.ndarray, k: float) -> np.ndarray:
    """C_n(k), m/Pa: displacement into the body per unit pressure cos nθ cos kz.

    n : ndarray of int, 0 ... with even steps; k : 1/m, > 0
    """
    R, nu = body.loaded, body.material.poisson_ratio
    grow, decay = body.convexity > 0, body.convexity < 0  # the functions that fall off from the loaded surface
    free = _fields(n, k, R, nu, _functions(n, k, R, decay), decay)
    displacement, alone = np.empty(n.shape), np.ones(n.shape, dtype=bool)
    if body.held:
        alone = np.abs(_log_size(n, k * R, decay) - _log_size(n, k * body.held, decay)) > DECOUPLED
    pushed = np.array([-1.0, 0.0, 0.0])[None, :, None]  # σ_rr, σ_rθ, σ_rz
    weights = np.linalg.solve(free[alone][:, 3:], pushed)
    displacement[alone] = (free[alone][:, :1] @ weights)[:, 0, 0]
    if not alone.all():
        m = n[~alone]
        loaded = np.concatenate([free[~alone], _fields(m, k, R, nu, _scaled(m, k, R, body.held, grow), grow)], axis=2)
        falling = _fields(m, k, body.held, nu, _scaled(m, k, body.held, R, decay), decay)
        growing = _fields(m, k, body.held, nu, _functions(m, k, body.held, grow), grow)
        still = np.concatenate([falling, growing], axis=2)
        both = np.concatenate([loaded[:, 3:], still[:, :3]], axis=1)
        scale = np.abs(both).max(axis=1, keepdims=True)
        right = np.concatenate([pushed, np.zeros((1, 3, 1))], axis=1)
        weights = np.linalg.solve(both / scale, right) / np.swapaxes(scale, 1, 2)
        displacement[~alone] = (loaded[:, :1] @ weights)[:, 0, 0]
    return -body.convexity * displacement / body.material.lame_mu


def _fields(n, k, r, nu, functions, decay):
    """(n_n, 6, 3): U, V, W and the amplitudes of σ_rr, σ_rθ, σ_rz over μ, of three solutions.

    `functions` : f_n, f_{n+1}, f_{n−1}, with f' = k f_{n+1} + (n/r) f for both kinds
    """
    f, up, down = functions
    x, s = k * r, 4.0 * (1.0 - nu)
    d_up, d_down = k * f - (n + 1) / r * up, k * f + (n - 1) / r * down
    df = k * up + n / r * f
    zero = np.zeros(f.shape)
    first = k * up, k * up, -k * f, k * d_up, k * d_up, -k * df, zero
    second = k * down, -k * down, -k * f, k * d_down, -k * d_down, -k * df, zero
    other, d_other, c, sign = (down, d_down, -(n - s), 1.0) if decay else (up, d_up, n + s, -1.0)
    swelling = -4.0 * nu * k * k * f  # λ/μ div u
    third = (
        k * (x * f - c * other), sign * c * k * other, -k * x * other,
        k * (k * f + x * df - c * d_other), sign * c * k * d_other, -k * (k * other + x * d_other), swelling,
    )  # fmt: skip
    columns = [
        np.stack([U, V, W, swelling + 2.0 * dU, dV - (V + n * U) / r, dW - k * U], axis=1)
        for U, V, W, dU, dV, dW, swelling in (first, second, third)
    ]
    return np.stack(columns, axis=2)


def _functions(n, k, r, decay):
    """f_n = 1 and its neighbours at r: (f_n, f_{n+1}, f_{n−1}), as `_fields` takes them."""
    ratio, sign = _ratios(int(n.max()) + 1, k * r, decay), -1.0 if decay else 1.0  # f_{j+1}/f_j without signs
    up, down = ratio[n], 1.0 / ratio[np.maximum(n, 1) - 1]
    return np.ones(n.shape), sign * up, sign * np.where(n == 0, up, down)


def _scaled(n, k, r, other, decay):
    """The same over f_n at the other radius."""
    size = np.exp(_log_size(n, k * r, decay) - _log_size(n, k * other, decay))
    return tuple(size * part for part in _functions(n, k, r, decay))


def _ratios(count, x, decay):
    """I_{j+1}/I_j, or K_{j+1}/K_j, of x for j = 0 ... count − 1."""
    if decay:
        from scipy.special import k0e, k1e

        upwards = accumulate(range(1, count), lambda ratio, j: 2.0 * j / x + 1.0 / ratio, initial=k1e(x) / k0e(x))
        return np.array(list(upwards))
    orders = range(count + STARTED + int(x) + 1, 0, -1)
    downwards = accumulate(orders, lambda ratio, j: 1.0 / (2.0 * j / x + ratio), initial=0.0)
    return np.array(list(downwards))[: -count - 1 : -1]


def _log_size(n, x, decay):
    """ln I_n(x), or ln K_n(x)."""
    from scipy.special import i0e, k0e

    first = log(k0e(x)) - x if decay else log(i0e(x)) + x
    logs = np.concatenate([[first], first + np.cumsum(np.log(_ratios(int(n.max()) + 1, x, decay)))])
    return logs[n]

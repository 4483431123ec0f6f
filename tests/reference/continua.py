"""Contacts and rings of elasticity theory: half-planes, half-spaces, rings in polar coordinates."""

from collections.abc import Callable
from math import exp, gamma, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre
from scipy import fft
from scipy.integrate import quad
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, nnls

from fem.contacts.model import Model, Motion
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import solved

# ---- Stress in a half plane under line contacts, from the textbook: the formulas typed in again, and a numerical
# sum.


def mcewen(x, z, half_width, peak):
    """σ_x, σ_z, τ_xz below a semi-elliptic pressure; z is the depth (Johnson, Contact Mechanics, 1985, (4.49))."""
    b2 = half_width**2
    common = np.sqrt((b2 - x**2 + z**2) ** 2 + 4.0 * x**2 * z**2)
    m = np.sqrt(0.5 * (common + (b2 - x**2 + z**2)))
    n = np.sign(x) * np.sqrt(np.maximum(0.5 * (common - (b2 - x**2 + z**2)), 0.0))
    ratio, unit = (z**2 + n**2) / (m**2 + n**2), -peak / half_width
    return unit * (m * (1.0 + ratio) - 2.0 * z), unit * m * (1.0 - ratio), unit * n * (m**2 - z**2) / (m**2 + n**2)


def flamant(points, sources, forces):
    """Sum of simple radial distributions σ_r = −(2/π) F·r/r², (n_points, 3): xx, yy, xy."""
    away = points[:, None, :] - sources[None, :, :]
    radial = -2.0 / np.pi * np.sum(away * forces, axis=-1) / np.sum(away**2, axis=-1) ** 2
    x, y = away[..., 0], away[..., 1]
    return np.stack([np.sum(radial * product, axis=1) for product in (x * x, y * y, x * y)], axis=-1)


def cubic_bspline_patch(n, half_width, radius):
    """Transform (sin x / x)⁴, x = n a/(4R), of the cubic B-spline of unit resultant on [−a, a] of a circle."""
    return np.sinc(np.asarray(n) * (half_width / (4.0 * np.pi * radius))) ** 4


def cubic_bspline(t):
    """The cardinal B-spline on [−2, 2], of unit integral."""
    t = np.abs(t)
    return np.where(t < 1.0, 2.0 / 3.0 - t**2 + 0.5 * t**3, np.maximum(2.0 - t, 0.0) ** 3 / 6.0)


# ---- A roller on a raceway as two half-spaces: Love's rectangles, convolved by FFT, and constrained conjugate
# gradients. The yardstick of slices: nothing is assumed of the pressure's shape. Half-spaces end nowhere; real
# rollers do, and their end faces are left out on both sides of a comparison. Sources: Love 1929 (Johnson, Contact
# Mechanics, 1985, 3.25); Polonsky and Keer, Wear 231 (1999) 206.

SETTLED = 1e-7  # of pressures, from one step to the next
STEPS = 600


class Pressed(NamedTuple):
    """Of two half-spaces in contact. SI."""

    pressure: np.ndarray  # (n_across, n_along), Pa
    place: np.ndarray  # (n_along,), m, of cells along the roller
    approach: float  # m
    moment: float  # N m, Σ Q z of the load, > 0 towards +z

    @property
    def peak(self) -> tuple[float, float]:
        """Largest pressure, Pa, and where along the roller, m."""
        along = self.pressure.max(axis=0)
        return float(along.max()), float(self.place[along.argmax()])


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
    dx, dy, twice = 2.0 * wide / across, length / along, (2 * across, 2 * along)
    x, y = (np.arange(across) + 0.5 - 0.5 * across) * dx, (np.arange(along) + 0.5 - 0.5 * along) * dy
    gap, area = x[:, None] ** 2 / (2.0 * radius) + drop(y) + slope * y, dx * dy
    kernel = fft.rfft2(_love(dx, dy, *twice)) / (pi * modulus)

    def displaced(pressure):
        return fft.irfft2(kernel * fft.rfft2(pressure, s=twice), s=twice)[:across, :along]

    pressure = np.maximum(1.0 - gap / np.quantile(gap, 0.3), 0.0)
    pressure *= load / (pressure.sum() * area)
    direction, before, restart = np.zeros_like(gap), 1.0, 0.0
    for _ in range(STEPS):
        residual, loaded = displaced(pressure) + gap, pressure > 0.0
        residual -= residual[loaded].mean()
        now = float(np.sum(residual[loaded] ** 2))
        direction = np.where(loaded, residual + restart * now / before * direction, 0.0)
        answer = displaced(direction)
        answer -= answer[loaded].mean()
        size = np.sum(residual[loaded] * direction[loaded]) / np.sum(answer[loaded] * direction[loaded])
        last, pressure = pressure, np.maximum(pressure - size * direction, 0.0)
        joined = (pressure <= 0.0) & (residual < 0.0)
        pressure[joined] -= size * residual[joined]
        restart, before = float(not joined.any()), now
        pressure *= load / (pressure.sum() * area)
        if np.abs(pressure - last).sum() <= SETTLED * pressure.sum():
            break
    else:
        raise RuntimeError("pressures do not settle")
    approach = float((displaced(pressure) + gap)[pressure > 0.0].mean())
    return Pressed(pressure=pressure, place=y, approach=approach, moment=-float(pressure.sum(axis=0) @ y) * area)


def _love(dx: float, dy: float, across: int, along: int) -> np.ndarray:
    """∬ 1/r over a rectangle at the origin seen from cells of a grid that wraps around, m."""
    x = np.minimum(np.arange(across), across - np.arange(across))[:, None] * dx
    y = np.minimum(np.arange(along), along - np.arange(along))[None, :] * dy

    def corner(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    a, b = 0.5 * dx, 0.5 * dy
    return corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b)


# ---- Points of two bodies that touch without friction: gaps and forces are not negative, and one of the two is zero.


def separated(gap: np.ndarray, compliance: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Forces, (n,), N, >= 0, under which no gap, (n,), m, is negative; `active`: where to expect them.

    By active sets (Hintermüller, Ito and Kunisch, SIAM J. Optim. 13, 2002, 865), else by non-negative least squares.
    """
    for _ in range(40):  # 2 to 10 are usual
        force, k = np.zeros(gap.size), np.flatnonzero(active)
        if k.size:
            force[k] = np.linalg.solve(compliance[np.ix_(k, k)], -gap[k])
        changed = np.where(active, force > 0.0, gap + compliance[:, k] @ force[k] < 0.0)
        if np.array_equal(changed, active):
            return force
        active = changed
    lower = cholesky(compliance, lower=True)
    return nnls(lower.T, solve_triangular(lower, -gap, lower=True))[0]


# ---- A disc pressed at any place along a spall: two half-planes under pressures that may not pull. The pressure is
# constant in cells; the displacement, weighted with the cells, fits the gap of the bare profile where they touch
# (Galerkin's method). Far from an edge it is Hertz's contact. Source: Johnson, Contact Mechanics (1985), chapters 2 and
# 5.

FINE, COARSE, GROWTH = 0.3e-6, 2e-6, 1.1  # m, cells at the edges and far from them


class EdgeContact:
    """A disc in a bore, or on a disc, with a deep spall whose edges are rounded.

    radius, m, of the raceway, negative of a bore; compliance: A, m/N, of two surfaces, 2/(π E* L); level: B of the
    sound contact, δ = A Q (B − ½ ln Q); half_opening, m, from the middle to where the surface leaves its circle;
    beside: m, of the sound surface
    """

    def __init__(self, *, radius, roller_radius, compliance, level, half_opening, edge_radius, beside):
        self.radius, self.roller_radius, self.half_opening, self.edge_radius = (
            radius, roller_radius, half_opening, edge_radius)  # fmt: skip
        steps = [FINE] * 40
        while sum(steps) < beside:
            steps.append(min(COARSE, GROWTH * steps[-1]))
        arc = half_opening - FINE * np.arange(int(0.25 * edge_radius / FINE), 0, -1)
        bounds = np.concatenate([arc, [half_opening], half_opening + np.cumsum(steps)])  # none touches farther inside
        self.low, self.high = np.append(-bounds[:0:-1], bounds[:-1]), np.append(-bounds[-2::-1], bounds[1:])
        factor = 2.0 * compliance / abs(1.0 / radius + 1.0 / roller_radius)
        unit = 0.5 * exp(level - 0.5 + 0.5 * log(factor))  # δ = A Q (½ + ln(2 unit/b)), b² = factor·Q

        def twice(z):  # ∫∫ ln|z|
            return 0.5 * z * z * np.log(np.where(z == 0.0, 1.0, np.abs(z)) / unit) - 0.75 * z * z

        h, l_, size = self.high[:, None], self.low[:, None], self.high - self.low
        whole = twice(h - self.low) - twice(h - self.high) - twice(l_ - self.low) + twice(l_ - self.high)
        self._influence = -compliance * whole / np.outer(size, size)  # mean displacement of cells by unit forces

    def gaps(self, place: float) -> np.ndarray:
        """Gaps along the line of centres, at a place of the chord, to a disc that would touch the sound raceway, m."""
        middle = 0.5 * (self.low + self.high)
        inside, e = np.clip(self.half_opening - np.abs(middle), 0.0, None), self.edge_radius
        depth = e - np.sqrt(np.maximum(e * e - np.minimum(inside, e) ** 2, 0.0))
        R, r = abs(self.radius), self.roller_radius
        surface, turned = R - np.sign(self.radius) * depth, np.arcsin(middle / R) - np.arcsin(place / R)
        along, across = surface * np.cos(turned), surface * np.sin(turned)
        reach = np.sqrt(r * r - across**2)
        return along - reach - (R - r) if self.radius < 0.0 else R + r - along - reach

    def press(self, place: float, approach: float) -> tuple[float, float]:
        """Force, N, and largest force per length of cell, N/m, at an approach from the sound raceway, m."""
        gap = self.gaps(place) - approach
        force = separated(gap, self._influence, gap < 0.0)
        return float(force.sum()), float((force / (self.high - self.low)).max())


# ---- Two circular bodies pressed together without Hertz's theory: pressures on strips, the gap closed at each.
# Displacements are those of whole bodies by their angular harmonics, so that what differs from Hertz's theory is the
# shape of the pressure and of the bodies' own displacement across the contact. The gap is a parabola.

Compliance = Callable[[np.ndarray], np.ndarray]  # of n waves around, m/Pa
PER_STRIP = 40  # harmonics, of the waves that a strip's width has


def approach(
    sides: tuple[tuple[float, Compliance], ...], relative_radius: float, line_load: float, reach: float, strips: int
) -> float:
    """Approach, m, under a load, N/m, of bodies that are a radius, m, and a compliance each.

    `reach`, m: half of what strips cover, more than the contact. Errors: of second order in a strip's width.
    """
    width, i, near = 2.0 * reach / strips, np.arange(strips), 0.0
    for radius, compliance in sides:  # mean displacement of strips, so many away, under a unit line load over one
        n = np.arange(int(PER_STRIP * radius / width) + 1)
        amplitude = compliance(n) * np.sinc(n * width / (2.0 * np.pi * radius)) ** 2
        amplitude[0] *= 0.5
        near = near + np.cos(np.outer(i * width / radius, n)) @ amplitude / (np.pi * radius)
    gap = (((i + 0.5) * width - reach) ** 2 + width**2 / 12.0) / (2.0 * relative_radius)  # means over strips

    def missing(depth: float) -> float:
        return separated(gap - depth, near[np.abs(i[:, None] - i)], gap < depth).sum() - line_load

    return brentq(missing, 0.0, gap.max() + line_load * near[0], xtol=1e-18, rtol=1e-13)


# ---- Line contact of elastic cylinders: textbook formulas and the quasi-static impact they give. Source: Johnson,
# Contact Mechanics (1985): half-width of section 4.2(c), approach of a disc squeezed by two opposite line loads of
# section 5.6, creep of rolling cylinders of section 8.3 (Carter 1926).


def half_width(line_load: float, relative_radius: float, contact_modulus: float) -> float:
    """b, m, of a load in N/m; 1/contact_modulus = Σ (1 − ν²)/E."""
    return sqrt(4.0 * line_load * relative_radius / (pi * contact_modulus))


def squeezed_disc_approach(line_load: float, radius: float, half_width: float, modulus: float) -> float:
    """Approach of one contact towards the centre of a disc, m; modulus E/(1 − ν²)."""
    return line_load / (pi * modulus) * (2.0 * log(4.0 * radius / half_width) - 1.0)


def carter_creep(traction_ratio: float, friction: float, half_width: float, relative_radius: float) -> float:
    """Creep (slip velocity over rolling speed) at a share of the limiting traction."""
    return friction * half_width / relative_radius * (1.0 - sqrt(1.0 - traction_ratio))


def impact_on_rigid_flat(speed: float, radius: float, length: float, mass: float, modulus: float):
    """Quasi-static impact of a cylinder: largest approach, m, largest force, N, contact time, s."""

    def width(force):
        return half_width(force / length, radius, modulus)

    def slope(force):  # dδ/dQ: b grows as sqrt(Q), which takes 1 off the bracket
        return (2.0 * log(4.0 * radius / width(force)) - 2.0) / (pi * modulus * length)

    def energy(force):
        return quad(lambda x: x * slope(x), 0.0, force, epsrel=1e-10)[0]

    kinetic = 0.5 * mass * speed**2
    top = brentq(lambda force: energy(force) - kinetic, 1e-6, 1e6)

    # t = 2 ∫ dδ/v; with Q = top (1 − s²) the root at the turning point goes
    def integrand(s):
        force = top * (1.0 - s * s)
        return slope(force) * 2.0 * s * top / sqrt(2.0 * (kinetic - energy(force)) / mass)

    time = 2.0 * quad(integrand, 1e-4, 1.0 - 1e-12, epsrel=1e-6, limit=200)[0]
    return squeezed_disc_approach(top / length, radius, width(top), modulus), top, time


# ---- Navier's equations of one angular harmonic in plane strain, collocated: independent of any series of
# potentials.


class PolarNavier:
    """U, V of u_r = U cos nθ, u_θ = V sin nθ as Chebyshev series in r; Navier by divergence and curl."""

    def __init__(self, n, inner, outer, degree, material):
        self.n, self.outer, self.inner, self.degree = n, outer, inner, degree
        self.lam, self.mu = material.lame_lambda / material.lame_mu, 1.0

    def series(self, r, derivative):
        x, basis = (2.0 * r - self.inner - self.outer) / (self.outer - self.inner), np.eye(self.degree + 1)
        basis = chebyshev.chebder(basis, derivative, axis=0) if derivative else basis
        return chebyshev.chebval(x, basis).T * (2.0 / (self.outer - self.inner)) ** derivative

    def blocks(self, r):
        """Rows (..., 2 (degree+1)) of U, V, σ_rr, σ_rθ and of Navier's equations times r², at radii r."""
        n, lam, mu = self.n, self.lam, self.mu
        r = np.atleast_1d(np.asarray(r, dtype=float))
        c, fields = r[:, None], [self.series(r, k) for k in range(3)]
        (U, V), (dU, dV), (ddU, ddV) = (
            (np.hstack((f, 0.0 * fields[0])), np.hstack((0.0 * fields[0], f))) for f in fields
        )
        div, curl = dU + (U + n * V) / c, dV + (V + n * U) / c
        ddiv = ddU + (dU + n * dV) / c - (U + n * V) / c**2
        dcurl = ddV + (dV + n * dU) / c - (V + n * U) / c**2
        navier_r = (lam + 2 * mu) * ddiv - mu * n / c * curl
        navier_t = -(lam + 2 * mu) * n / c * div + mu * dcurl
        s_rr, s_rt = lam * div + 2 * mu * dU, mu * (dV - (V + n * U) / c)
        return U, V, s_rr, s_rt, c**2 * navier_r, c**2 * navier_t

    def solve(self, conditions, force=(0.0, 0.0)):
        """Coefficients of div σ + force = 0, collocated, with row @ coefficients = value per condition."""
        nodes = legendre.leggauss(self.degree + 1)[0]
        points = 0.5 * (self.inner + self.outer) + 0.5 * (self.outer - self.inner) * nodes
        *_, navier_r, navier_t = self.blocks(points)
        rows = np.vstack((navier_r, navier_t, *(row.reshape(1, -1) for row, _ in conditions)))
        values = np.concatenate((-force[0] * points**2, -force[1] * points**2, [value for _, value in conditions]))
        scale = np.linalg.norm(rows, axis=1)
        scale[scale == 0.0] = 1.0
        coefficients = np.linalg.lstsq(rows / scale[:, None], values / scale, rcond=1e-14)[0]
        assert np.max(np.abs((rows @ coefficients - values) / scale)) < 1e-9  # converged
        return coefficients


# ---- Pressures of contacts of many points at rest, and what a stiff layer adds to an approach.


class Pressures(NamedTuple):
    """Pressures of one contact, along the tangent."""

    across: np.ndarray  # (n_points,), m, from the line of centres
    pressure: np.ndarray  # (n_points,), Pa


def contact_pressures(model: Model, motion: Motion, radial_load: float) -> list[Pressures]:
    """Pressures at the points of all contacts under a load, N, weightless: inner ones by roller, then outer ones."""
    points, _, forces, _ = solved(model, motion, Loads(radial_load))
    found = []
    for contact in range(2 * model.bearing.n_rollers):
        law, mine = model.laws[contact // model.bearing.n_rollers], points.contact == contact
        found.append(Pressures(across=points.across[mine], pressure=forces[mine] / (law.spacing * law.pair.length)))
    return found


def layer_approach(law, force: float) -> float:
    """What the layer of a resolved contact adds to the approach, m: its mean deflection weighted with the pressure."""
    return 8.0 / (3.0 * pi) * 2.0 * force / (pi * law.pair.half_width(force) * law.pair.length) / law.layer


# ---- Load distribution of radially loaded bearings: published numbers and the integral behind them. Source: Stribeck
# 1901, Sjövall 1933, as tabulated in Harris, Rolling Bearing Analysis, and in bearing makers' catalogues (NSK E728g,
# 5.1), second hand: Q_max = F/(Z J_r), ε = ½ (1 − clearance/deflection), exponents 1.5 (point) and 1.1 (line).

# ε: (J_r point contact, J_r line contact)
SJOVALL = {
    0.2: (0.1590, 0.1737), 0.3: (0.1892, 0.2055), 0.4: (0.2117, 0.2286), 0.5: (0.2288, 0.2453), 0.6: (0.2416, 0.2568),
    0.7: (0.2505, 0.2636), 0.8: (0.2559, 0.2658), 0.9: (0.2576, 0.2628), 1.0: (0.2546, 0.2523),
    1.25: (0.2289, 0.2078), 2.5: (0.1339, 0.1075),
}  # fmt: skip


def stribeck_number(exponent: float) -> float:
    """Z Q_max/F of many elements without clearance: 2π/∫cos^(n+1) over the loaded half."""
    return 2.0 * pi * gamma(0.5 * exponent + 1.5) / (sqrt(pi) * gamma(0.5 * exponent + 1.0))

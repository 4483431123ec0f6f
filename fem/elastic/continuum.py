"""Exact plane-strain answer of circular elastic bodies to pressure on their surface, by angular harmonics.

The yardstick for a coarse mesh's contact compliance: what an infinitely fine mesh would give, without one.

- `Section`: what is loaded, and on which circle.
- `plane_compliance`: surface displacement per unit pressure cos nθ.
- `weight_sag`: what a ring's own weight does to its raceway.
- `hertz_patch`: Fourier transform of a unit line load spread over a patch.
- `patch_displacement`: the two combined, displacement per unit line load (N per m of roller length).
- `hertz_approach`: centre displacement under Hertz pressure, slow tails summed in closed form.

A displacement is positive in the direction of the push, which is into the body. Writing u_r = U(r) cos nθ,
u_θ = V(r) sin nθ, Muskhelishvili's φ = z^(1±n) and ψ = z^(−1±n) give the four solutions of Navier's
equations.

Tangential tractions (`shear_compliance`, `stick_approach`) have the same conventions: displacement per unit line load,
along the push, relative to what the body does as a whole."""

from collections.abc import Callable
from functools import lru_cache
from math import log, pi, sqrt
from typing import NamedTuple

import numpy as np

from lagrange.bearing import Bearing, Material
from lagrange.errors import UsageError

# Harmonics summed by the Hertz approaches: C_n less its 1/n and 1/n² parts leaves c/n³, and a truncation of
# 1/(2 n_max²) = 1e-9 of c against a sum of several c, however narrow the patch. Only thin rings, coupled up
# to n = 20 R/thickness, need so many.
N_HARMONICS = 20_000

# Held and loaded surface are taken as decoupled where n² t^(2n), t < 1 the radius ratio, is below this:
# their interaction is then lost in the round-off of the compliance.
DECOUPLED = 1e-18

# Largest truncation error of a plain sum, relative to the sum of the absolute terms.
SUM_TOLERANCE = 1e-5


class Section(NamedTuple):
    """A ring across its axis, loaded on one circle and held on the other, or a disc, which is held nowhere. m.

    Held inside the load: an inner ring loaded on its raceway. Held outside: an outer ring loaded on its raceway.
    """

    loaded: float  # radius
    held: float  # radius; 0: a disc, whose mean motion does not count, or a solid shaft, whose load acts all over it
    material: Material
    loads: int = 1  # evenly spaced around, all alike: two squeeze a disc, one accelerates it

    squeezed = property(lambda self: self._replace(loads=2))

    @property
    def elastic(self) -> "Section":
        """The same of a material that is not rigid."""
        return self._replace(material=self.material.elastic)

    @property
    def convexity(self) -> int:
        """Of the loaded surface: 1 as a disc's, −1 as a hole's in a plate."""
        return 1 if self.loaded > self.held else -1

    thickness = property(lambda self: abs(self.loaded - self.held))


def roller_section(bearing: Bearing) -> Section:
    return Section(bearing.roller_radius, 0.0, bearing.roller)


def ring_sections(bearing: Bearing) -> tuple[Section, Section]:
    """Of the inner ring and of the outer one."""
    return (
        Section(bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring),
        Section(bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring),
    )


def plane_compliance(section: Section, n: np.ndarray) -> np.ndarray:
    """Surface displacement per unit normal pressure cos nθ on the loaded circle.

    n : ndarray of int, >= 0
    Returns: ndarray, shape of n, m/Pa; positive into the body
    Errors: round-off, at most 1e-11 relative at any n for the rings of a bearing.
    """
    loaded, held, material, _ = section
    if loaded <= 0.0 or held < 0.0 or loaded == held:
        raise ValueError(f"ring radii must be positive and differ: loaded {loaded:.4g} m, held {held:.4g} m")
    lame_lambda, mu, kappa, t = material.lame_lambda, material.lame_mu, kolosov(material), held / loaded
    still = abs(1.0 - t**2) / (2.0 * (lame_lambda + mu) + 2.0 * mu * t**2)
    if held == 0.0:
        # for n = 1 the pressure has a resultant, balanced by the inertia of a uniform acceleration; the displacement is
        # u_r = −α r² cos θ, u_θ = −α r² sin θ, α = 1/(4 (λ+μ) R), whose mean over the area vanishes: half of n = 0
        still = (kappa - 1.0) / (4.0 * mu)
    return _surface(section, n, 1.0, (still, 0.5 * still), PRESSURE, 0, -section.convexity)


def _surface(section, n, sign, first, stress, component, towards):
    """Displacement of the loaded circle per unit stress, m/Pa; of a disc relative to its mean one.

    sign : of the part with κ, where the held circle is too far away to count, as in any disc
    first : for n = 0, and for n = 1 of a disc, over the radius
    stress, component, towards : of `annulus_surface`, and the sign of what is meant there
    """
    n, mu, kappa = _harmonics(n), section.material.lame_mu, kolosov(section.material)
    many = np.maximum(n, 2)
    found = (sign * kappa / (many + section.convexity) + 1.0 / (many - section.convexity)) / (4.0 * mu)
    found[n == 0] = first[0]
    if section.held == 0.0:
        found[n == 1] = first[1]
    else:
        t = section.held / section.loaded
        near = apart(n, t)[1]
        found[near] = towards * annulus_surface(n[near], t, kappa, stress)[:, component] / (2.0 * mu)
    return section.loaded * found


def apart(n: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Harmonics of a ring that the held circle, t loaded radii from the centre, does not change; and those it does."""
    far = (n > 1) & (2.0 * np.log(np.maximum(n, 1)) - 2.0 * n * abs(log(t)) < log(DECOUPLED))
    return far, (n > 0) & ~far


@lru_cache(maxsize=2)  # of the last bearing's rings
def weight_sag(section: Section, gravity: float) -> float:
    """How far the circle of a ring that is not held falls by its own weight, m; a solid shaft is held all over.

    Its radii change by s cos θ from straight down, as if it had been shifted. The weight asks for a displacement c x²
    downwards, x the depth below the centre, of which u_r has ¾ c r² cos θ; solutions without weight free the one
    circle and hold the other.

    gravity : float, m/s²
    Errors: round-off.
    """
    loaded, held, material, _ = section
    if held == 0.0:
        return 0.0
    lame_lambda, mu, kappa = material.lame_lambda, material.lame_mu, kolosov(material)
    one, t = np.array([1]), held / loaded
    bend = -material.density * gravity * loaded**2 / (2.0 * (lame_lambda + 2.0 * mu))

    def of_weight(r):
        """As the rows of `annulus_modes`, at r free radii."""
        displacement = 0.5 * mu * bend * r**2
        return np.array([3.0 * displacement, -displacement, (2.0 * lame_lambda + 3.0 * mu) * bend * r, -mu * bend * r])

    still, free = annulus_modes(one, t, t, kappa)[0], annulus_modes(one, 1.0, t, kappa)[0]
    conditions = np.concatenate([still[:2], free[2:]])
    weights = np.linalg.solve(conditions, -np.concatenate([of_weight(t)[:2], of_weight(1.0)[2:]]))
    return float(free[0] @ weights + of_weight(1.0)[0]) / (2.0 * mu)


def hertz_patch(n: np.ndarray, half_width: float, radius: float) -> np.ndarray:
    """Transform 2 J₁(x)/x, x = n b/R, of the semi-elliptic Hertz pressure of unit resultant; 1 at n = 0."""
    from scipy.special import j1  # 0.1 s to import, and a start with all compliances kept needs none

    x = _harmonics(n) * (half_width / radius)
    is_zero = x == 0.0
    x = np.where(is_zero, 1.0, x)
    return np.where(is_zero, 1.0, 2.0 * j1(x) / x)


def patch_displacement(
    compliance: np.ndarray, transform_load: np.ndarray, transform_probe: np.ndarray | float, radius: float,
    angle: float = 0.0,
) -> float:  # fmt: skip
    """Displacement at `angle` from the middle of a loaded patch, per unit line load.

    compliance : ndarray, (n_harmonics,), m/Pa, of n = 0, 1, 2, ...
    transform_load : ndarray, (n_harmonics,), of the load patch
    transform_probe : the same of the patch over which the displacement is averaged; 1.0 : of a point
    radius : m, of the loaded surface; angle : rad, from the middle of the load to the probe
    Returns: float, m per N/m; positive into the body at the probe
    Errors: truncation, below SUM_TOLERANCE of the sum of the absolute terms: it is estimated by fading out the last
    half of the terms, and too few are refused. A spline patch of half-width a on both sides needs some 15 R/a
    harmonics; Hertz pressure probed at a point 150 R/b: for its centre, rather take `hertz_approach`.
    """
    n = np.arange(compliance.size)
    amplitude = compliance * transform_load * transform_probe
    amplitude[0] *= 0.5
    terms = amplitude * np.cos(n * angle)
    truncation = abs(np.sum(terms * (1.0 - _fade(n))))
    limit = SUM_TOLERANCE * np.sum(np.abs(amplitude))
    if not truncation <= limit:
        left = f"{n.size} harmonics leave an error of about {truncation:.1e} m/Pa in the sum"
        raise ValueError(f"{left}, above {limit:.1e}; give more harmonics")
    return float(np.sum(terms)) / (pi * radius)


def patch_slope(compliance: np.ndarray, transform_load: np.ndarray, radius: float, angle: float) -> float:
    """How the displacement at a point changes with its angle from the middle of a loaded patch, m/rad per N/m.

    Parameters are those of `patch_displacement`.

    Errors: terms fall slowly, as n^-3/2, but change their signs outside the patch: fading out the last half leaves less
    than 1e-8 of slopes from 0.3 rad to 1 rad away.
    """
    return patch_crossing(np.arange(compliance.size) * compliance, transform_load, radius, angle)


def patch_crossing(crossing: np.ndarray, transform_load: np.ndarray, radius: float, angle: float) -> float:
    """Displacement into the body at an angle, rad, from the middle of a patch that is pulled along +θ, m per N/m.

    Parameters are those of `patch_displacement` and errors those of `patch_slope`; `crossing` : ndarray,
    (n_harmonics,), m/Pa, of displacements cos nθ by tractions sin nθ
    """
    n = np.arange(crossing.size)
    return -float(np.sum(crossing * transform_load * _fade(n) * np.sin(n * angle))) / (pi * radius)


def _fade(n):
    return np.cos(0.5 * pi * np.clip(2.0 * n / n.size - 1.0, 0.0, 1.0)) ** 2


def hertz_approach(section: Section, half_width: float) -> float:
    """Displacement into a body under the centre of each Hertz patch, m per N/m; a disc's relative to its mean one.

    Errors: truncation below 1e-8 relative.
    """
    return hertz_centre(plane_compliance, section, half_width)


def hertz_centre(compliance: Callable[[Section, np.ndarray], np.ndarray], section: Section, half_width: float) -> float:
    """Centre displacement under one of the evenly spaced Hertz patches on a section, m per N/m of each.

    Only harmonics that are multiples of the number of patches are excited. The part of C_n common to all bodies, c/n ∓
    c γ/n² with c = 2R/E', γ = (κ−1)/(κ+1), upper sign for a convex surface, is summed in closed form: Σ cos(mθ)/m =
    −ln|2 sin θ/2| and Σ cos(mθ)/m² = π²/6 − π|θ|/2 + θ²/4, averaged over the semi-ellipse.
    """
    radius, _, material, n_patches = section
    beta = n_patches * half_width / radius
    if not 0.0 < beta <= 1.0:
        raise ValueError(
            f"half-width {half_width:.4g} m must be positive and at most R/n_patches = {radius / n_patches:.4g} m"
        )
    n = n_patches * np.arange(1, N_HARMONICS + 1)
    flat = 2.0 * radius / material.plane_strain_modulus
    curvature = -section.convexity * (kolosov(material) - 1.0) / (kolosov(material) + 1.0)
    rest = np.sum((compliance(section, n) - flat / n * (1.0 + curvature / n)) * hertz_patch(n, half_width, radius))
    # next term of the series: 5 β⁶/11 612 160, below 5e-7
    first_sum = log(2.0 / beta) + 0.5 + beta**2 / 96.0 + beta**4 / 23040.0
    second_sum = pi**2 / 6.0 - 2.0 * beta / 3.0 + beta**2 / 16.0
    common = flat / n_patches * (first_sum + curvature / n_patches * second_sum)
    mean = 0.5 * compliance(section, np.array([0]))[0]
    return float(n_patches / (pi * radius) * (mean + rest + common))


PRESSURE, TRACTION = (-1.0, 0.0), (0.0, 1.0)  # amplitudes of σ_rr and σ_rθ on the loaded circle


def annulus_surface(n: np.ndarray, t: float, kappa: float, stress: tuple[float, float]) -> np.ndarray:
    """2μU and 2μV on radius 1, (n_n, 2), under stresses there of n >= 1 waves around, with radius t fixed."""
    return np.sum(annulus_modes(n, 1.0, t, kappa)[:, :2] * annulus_weights(n, t, kappa, stress)[:, None], axis=2)


def annulus_weights(n: np.ndarray, t: float, kappa: float, stress: tuple[float, float]) -> np.ndarray:
    """Weights of the annulus modes, (n_n, 4), for the same."""
    conditions = np.concatenate((annulus_modes(n, t, t, kappa)[:, :2], annulus_modes(n, 1.0, t, kappa)[:, 2:]), axis=1)
    right_side = np.array([0.0, 0.0, *stress]).reshape(1, 4, 1)
    return np.linalg.solve(conditions, right_side)[..., 0]


def annulus_modes(n: np.ndarray, r: float, t: float, kappa: float) -> np.ndarray:
    """Four solutions of Navier's equations between radii 1 and t at radius r, n >= 1.

    Rows: 2μU, 2μV, and the amplitudes of σ_rr (cos nθ) and σ_rθ (sin nθ). Columns: φ = z^(n+1) less (n+1)
    z^(n−1) in ψ, ψ = z^(n−1), φ = z^(1−n) plus (n−1) z^(−n−1) in ψ, ψ = z^(−n−1). The combinations keep the
    columns apart at large n; the growing pair has its powers scaled to 1 at the larger radius, the decaying
    pair at the smaller. At n = 1 the third is another translation and is replaced by φ = ln z, ψ = −κ ln z,
    the solution that carries the resultant.

    Source: Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, polar displacement
    and stress by φ and ψ; the tests substitute them in Navier's equations.
    """
    outer, inner = max(1.0, t), min(1.0, t)
    x, y = r / outer, inner / r
    n = n.astype(float)
    grow, decay = x ** (n - 1), y ** (n - 1)
    grow_bend, decay_bend = (n + 1) * (1.0 - x**2) * grow, (n - 1) * (1.0 - y**2) * decay
    grown, decayed = x**2 * grow, y**2 * decay
    modes = np.array([
        [kappa * grown + grow_bend, kappa * grown - grow_bend,
         ((n + 1) * grown + (n - 1) * grow_bend) / r, ((n + 1) * grown - (n - 1) * grow_bend) / r],
        [-grow, grow, -(n - 1) * grow / r, (n - 1) * grow / r],
        [kappa * decay + decay_bend, -kappa * decay + decay_bend,
         -((n - 1) * decay + (n + 1) * decay_bend) / r, ((n - 1) * decay - (n + 1) * decay_bend) / r],
        [-decayed, -decayed, (n + 1) * decayed / r, (n + 1) * decayed / r],
    ]).T.copy()  # fmt: skip
    log_r = 2.0 * kappa * log(r)
    modes[n == 1, :, 2] = (log_r - 1.0, -log_r - 1.0, (3.0 + kappa) / r, (1.0 - kappa) / r)
    return modes


def _harmonics(n):
    n = np.asarray(n)
    if not np.issubdtype(n.dtype, np.integer) or n.ndim == 0 or np.any(n < 0):
        raise ValueError(f"harmonics must be an array of integers >= 0, got {n!r}")
    return n


def kolosov(material: Material) -> float:
    """κ = 3 − 4ν of plane strain."""
    return 3.0 - 4.0 * material.poisson_ratio


FASTEST = 0.5  # of the speed of shear waves; Rayleigh's wave, at which nothing is steady, is at 0.87 and more


def moving_softening(material: Material, speed: float) -> float:
    """Displacement under a load that moves along a half-plane in steady motion, over that under one at rest; >= 1.

    1 + 0.74 (v/c₂)² of slow ones, c₂ the speed of shear waves: 1e-6 in the paper's bearing, per cents in soft ones that
    turn fast.

    speed : float, m/s, of the load along the surface

    Errors: of bodies of finite size: what it takes their waves to settle, and their slowest harmonics.
    UsageError: a speed beyond FASTEST.

    Source: Cole and Huth, J. Appl. Mech. 25 (1958) 433.
    """
    if material.rigid:
        return 1.0
    squared = material.density * speed**2 / material.lame_mu  # (v/c₂)²
    if squared > FASTEST**2:
        raise UsageError(
            f"operation.speed_rpm: contacts roll at {abs(speed):.4g} m/s along a surface whose shear waves travel at "
            f"{abs(speed) / sqrt(squared):.4g} m/s; the reduced model takes at most {FASTEST:g} of that: a lower speed "
            'or a stiffer material, or model = "fem"'
        )
    slow = material.lame_mu / (material.lame_lambda + 2.0 * material.lame_mu)  # (c₂/c₁)²
    pressure = sqrt(1.0 - slow * squared)
    product = pressure * sqrt(1.0 - squared)
    # Rayleigh's function 4 √(1 − (v/c₁)²) √(1 − (v/c₂)²) − (2 − (v/c₂)²)² over (v/c₂)², without the difference
    rayleigh = 4.0 * (slow * squared - 1.0 - slow) / (1.0 + product) + 4.0 - squared
    return pressure / rayleigh / (1.0 - material.poisson_ratio)


def shear_compliance(section: Section, n: np.ndarray) -> np.ndarray:
    """Tangential surface displacement per unit tangential traction sin nθ on the loaded circle.

    Parameters and errors as of `plane_compliance`; m/Pa. For n = 0 a uniform traction, which accelerates a disc's
    rotation.

    Source: Muskhelishvili's potentials for n >= 2; for n = 0 and 1 of a disc the polynomials r³ and r² cos θ, r² sin θ
    that balance a uniform angular and linear acceleration.
    """
    mu, lame = section.material.lame_mu, section.material.lame_lambda
    still = 1.0 / (6.0 * mu) if section.held == 0.0 else abs((section.loaded / section.held) ** 2 - 1.0) / (2.0 * mu)
    first = still, 0.75 / mu - lame / (4.0 * mu * (lame + mu))
    return _surface(section, n, 1.0, first, TRACTION, 1, section.convexity)


def cross_compliance(section: Section, n: np.ndarray) -> np.ndarray:
    """Displacement cos nθ into a body per unit tangential traction sin nθ on the loaded circle.

    Parameters and errors as of `plane_compliance`; m/Pa. By Betti it is also the displacement along sin nθ under a
    pressure cos nθ, from which a disc's for n = 1 follows.
    """
    first = 0.0, (1.0 - kolosov(section.material)) / (8.0 * section.material.lame_mu)
    return _surface(section, n, -1.0, first, TRACTION, 0, -1)


def stick_approach(section: Section, half_width: float) -> float:
    """Tangential displacement of each contact that sticks all over, m per N/m.

    The traction of a contact that sticks rises to its edges, 1/sqrt(b² − x²); under it a flat surface moves evenly, by
    1/(π E') less than the centre under a semi-ellipse.

    Source: Mindlin, J. Appl. Mech. 16 (1949) 259; Johnson, Contact Mechanics (1985), sections 2.8 and 7.2.
    """
    of_ellipse = hertz_centre(shear_compliance, section, half_width)
    return of_ellipse - 1.0 / (pi * section.material.plane_strain_modulus)

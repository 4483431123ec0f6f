"""Elastic bodies by their modes: free vibration, impact, rocking."""

from functools import cache
from math import log, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, nnls
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from scipy.special import jv, jvp, yv, yvp
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri
from skfem.helpers import dot

from fem.elastic import continuum, vibration
from fem.elastic.continuum import Section, annulus_modes, kolosov, stick_approach
from fem.elastic.vibration import Modes
from lagrange import Bearing, Material
from tests.reference.continua import cubic_bspline_patch
from tests.reference.kit import STEEL, ring
from tests.reference.quadratic import plane_strain_stiffness

# ---- Exact free in-plane vibration of plane-strain discs and rings. u = ∇φ + curl ψ with φ = f(k_L r) cos nθ and ψ =
# g(k_T r) sin nθ, f and g Bessel functions of order n; the free circles want σ_rr = σ_rθ = 0, the held ones u = 0.
# Source: Love, A Treatise on the Mathematical Theory of Elasticity (4th ed. 1927), vibrations of a circular cylinder;
# Graff, Wave Motion in Elastic Solids (1975), section 8.2 with the axial wavenumber 0.

BESSEL = {"j": (jv, jvp), "y": (yv, yvp)}


def disc_frequency(n: int, low: float, high: float, material: Material) -> float:
    """The root ω R/c_T between two bounds of the free solid disc, n waves around."""
    return brentq(lambda x: np.linalg.det(surface_tractions(n, 1.0, x, material, "j")), low, high, xtol=1e-12)


def ring_frequency(n: int, inner: float, outer: float, low: float, high: float, material: Material) -> float:
    """The root ω, rad/s, between two bounds of a ring free on both circles."""
    return brentq(_determinant(surface_tractions, n, inner, outer, material), low, high, rtol=1e-12)


def held_ring_frequencies(n: int, held: float, free: float, high: float, material: Material) -> list[float]:
    """All ω, rad/s, below a bound, of a ring held on one circle and free on the other, n waves around.

    Found as changes of sign on a grid of high/1000: two roots closer than that would be missed.
    """
    determinant = _determinant(surface_displacements, n, held, free, material)
    return [root for *_, root in _roots(determinant, np.linspace(0.0, high, 1001)[10:], rtol=1e-12)]


def _roots(function, grid: np.ndarray, **error):
    """Where a function changes its sign on a grid: bounds and roots."""
    values = np.array([function(at) for at in grid])
    for i in np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:])):
        yield grid[i], grid[i + 1], brentq(function, grid[i], grid[i + 1], **error)


def _determinant(condition, n: int, other: float, free: float, material: Material):
    """By ω, rad/s, of an annulus with a condition on one circle, free on the other; columns are scaled to 1."""
    speed = np.sqrt(material.lame_mu / material.density)

    def determinant(omega):
        x, rows = omega * free / speed, []
        for of, r in ((condition, other / free), (surface_tractions, 1.0)):
            rows.append(of(n, r, x, material, "jy"))
        matrix = np.concatenate(rows)
        return np.linalg.det(matrix / np.abs(matrix).max(axis=0))

    return determinant


def surface_displacements(n, r, x, material, kinds):
    """u_r and u_θ at radius r of each potential; x = ω/c_T for unit radius."""
    k_l, k_t, columns = x / np.sqrt(material.lame_lambda / material.lame_mu + 2.0), x, []
    for f, df in (BESSEL[kind] for kind in kinds):
        columns.append([k_l * df(n, k_l * r), -n * f(n, k_l * r) / r])
        columns.append([n * f(n, k_t * r) / r, -k_t * df(n, k_t * r)])
    return np.array(columns).T


def surface_tractions(n, r, x, material, kinds):
    """σ_rr and σ_rθ (over μ) at radius r of each potential; x = ω/c_T for unit radius."""
    ratio, k_t, columns = material.lame_lambda / material.lame_mu, x, []
    k_l = x / np.sqrt(ratio + 2.0)
    for f, df in (BESSEL[kind] for kind in kinds):
        p, dp, ddp = f(n, k_l * r), k_l * df(n, k_l * r), k_l**2 * df(n, k_l * r, 2)
        # u_r = φ', u_θ = −n φ/r (times cos, sin); div u = −k_l² φ
        columns.append([-ratio * k_l**2 * p + 2.0 * ddp, -2.0 * n * (dp / r - p / r**2)])
        s, ds, dds = f(n, k_t * r), k_t * df(n, k_t * r), k_t**2 * df(n, k_t * r, 2)
        # u_r = n ψ/r, u_θ = −ψ'
        columns.append([2.0 * n * (ds / r - s / r**2), -dds + ds / r - n**2 * s / r**2])
    return np.array(columns).T


def vibrations(section: Section, thickness: float, highest: float, hub: float | None = None) -> Modes:
    """All modes up to a frequency, rad/s, of a disc or ring so thick, m; but for a disc's rotation.

    `hub` : kg, of a rigid body that the held circle moves with; None: it does not move.
    """
    found = []
    for n in range(vibration.MOST_WAVES):
        frequency, into, carried = vibration._of_order(n, section, thickness, hub)
        some = (frequency > vibration.RIGID * highest) & (frequency <= highest)
        found += [(n, *mode) for mode in zip(frequency[some], into[some], carried[some], strict=True)]
        # a surface wave around a disc, or a layer's slowest wave, has its speed from below: none is left beyond
        if n > 2 and frequency[0] > highest:
            break
    order, frequency, shape, carried = np.array(found).reshape(-1, 4).T
    return Modes(order=order.astype(np.intp), frequency=frequency, shape=shape, carried=carried)


# ---- The paper's outer ring by itself: its own frequencies, and Michell's series of a free ring pinched at two
# points.

INNER, OUTER = 0.028, 0.0325  # m, the paper's outer ring
FINE_LAYERS = 16  # layers of elements, 0.3 mm


def outer_ring(layers: int):
    """The paper's outer ring with elements about as long as they are high."""
    return ring(INNER, OUTER, 48 * layers, layers, False)


def free_modes(body, order: int) -> np.ndarray:
    """Frequencies, Hz, of so many waves around, of the ring held nowhere, the lowest ones first."""
    stiffness = body.harmonic_stiffness(np.array([order]))[0]
    scale = 1.0 / np.sqrt(np.repeat(body.row_mass, 2))
    values = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)


def thin_ring(order: int) -> float:
    """Bending frequency, Hz, of a thin ring in plane strain. Source: Love (1927), article 293, E/(1 − ν²) for E."""
    R, t, n2 = 0.5 * (INNER + OUTER), OUTER - INNER, order**2
    speed = np.sqrt(STEEL.youngs_modulus / (1.0 - STEEL.poisson_ratio**2) / (12.0 * STEEL.density))
    return order * (n2 - 1.0) / np.sqrt(n2 + 1.0) * t / R**2 * speed / (2.0 * np.pi)


def _of_pressures(orders: np.ndarray, inner: float, outer: float, material: Material, row: int) -> np.ndarray:
    """Outward motion of a free ring's outside by pressure cos nθ on it, row 0, or inside, row 2, m/Pa; n from 2 on.

    σ_rr, σ_rθ of both circles by four solutions.
    """
    outside, inside = (annulus_modes(orders, r, inner / outer, kolosov(material)) for r in (1.0, inner / outer))
    right = np.zeros((len(orders), 4, 1))
    right[:, row] = -1.0
    weights = np.linalg.solve(np.concatenate([outside[:, 2:], inside[:, 2:]], axis=1), right)
    return (outside[:, :1] @ weights)[:, 0, 0] * outer / (2.0 * material.lame_mu)


def pinched(orders: np.ndarray, half_width: float) -> np.ndarray:
    """Fourier coefficients cos nθ of the outward motion of the outer circle of a free ring, m per N/m, pinched at 0 and
    π by forces inward spread as a cubic B-spline; n even, from 2 on: Michell's series."""
    shape = 2.0 * cubic_bspline_patch(orders, half_width, OUTER) / (np.pi * OUTER)  # of both; odd orders cancel
    return _of_pressures(orders, INNER, OUTER, STEEL, 0) * shape


# ---- An elastic ring in a bore by exact series: a thick ring pressed in, and one with play under given forces.

FORCE_COUNTS = 1e4  # how much more the sum of forces must be right than any gap


def _lame(inner: float, outer: float, material: Material) -> tuple[float, float]:
    """Inward motion of a ring's outside by pressure on it, and of its raceway, m/Pa: Timoshenko and Goodier (1970),
    section 28 (Lamé), plane strain; outward motion of the outside by pressure inside is inner/outer of the latter."""
    modulus, area = material.youngs_modulus / (1.0 - material.poisson_ratio**2), outer**2 - inner**2
    ratio = material.poisson_ratio / (1.0 - material.poisson_ratio)
    return outer / modulus * ((outer**2 + inner**2) / area - ratio), 2.0 * inner * outer**2 / (modulus * area)


def pressed_ring(inner: float, outer: float, material: Material, bed: float, interference: float) -> tuple:
    """Pressure, Pa, and how far raceway and outside of a ring move, m, that is larger than its bore by so much, m.

    `bed` : of the bore, Pa/m.
    """
    outside, raceway = _lame(inner, outer, material)
    pressure = interference / (outside + 1.0 / bed)
    return pressure, -raceway * pressure, -outside * pressure


def ring_with_play(
    radii: tuple[float, float], material: Material, bed: float, play: float, forces, half_width: float, n_points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pressure, Pa, and outward displacement, m, of the outside at angles 2πi/n, of a ring in a bore.

    The ring is thick and plane; the bore pushes by bed · (displacement − play), never pulls, without friction. Forces
    from inside are (angle, N per m of length), spread as cubic B-splines of a half-width, m. The complementarity of
    pressures and gaps is solved as a least-squares problem without negative unknowns (Lawson and Hanson).
    """
    inner, outer = radii
    orders, angle = np.arange(n_points // 2), 2.0 * pi * np.arange(n_points) / n_points
    # of n = 1 it is 0: such pressures must balance, and what they do to radii is that of a rigid motion
    by_outside, by_inside = np.zeros((2, len(orders)))
    by_outside[0], raceway = _lame(inner, outer, material)
    by_inside[0] = raceway * inner / outer
    by_outside[2:], by_inside[2:] = (s * _of_pressures(orders[2:], inner, outer, material, row)
                                     for s, row in ((-1.0, 0), (1.0, 2)))  # fmt: skip
    spread = cubic_bspline_patch(orders, half_width, inner)
    weights, moved = np.where(orders == 0, 1.0, 2.0) / (2.0 * pi), np.zeros(n_points)
    for place, force in forces:
        moved += np.cos(np.multiply.outer(angle - place, orders)) @ (weights * by_inside * spread) * (force / inner)
    apart = angle[:, None] - angle[None, :]
    influence = np.cos(np.multiply.outer(apart, orders)) @ (weights * by_outside) * (2.0 * pi / n_points)
    compliance, area = influence + np.eye(n_points) / bed, outer * 2.0 * pi / n_points
    lower, directions = np.linalg.cholesky(compliance), np.stack([np.cos(angle), np.sin(angle)])
    wanted = sum(force * np.array([np.cos(place), np.sin(place)]) for place, force in forces)
    scale = FORCE_COUNTS * np.linalg.norm(lower.T, 2)
    rows = np.vstack([lower.T, scale * directions])
    right = np.concatenate([np.linalg.solve(lower, moved - play), scale * wanted / area])
    pressure, _ = nnls(rows, right, maxiter=100 * n_points)
    # the rigid motion is what is left of the gaps where the bore pushes
    left = (compliance @ pressure - (moved - play))[pressure > 0.0]
    rigid, *_ = np.linalg.lstsq(directions[:, pressure > 0.0].T, left, rcond=None)
    return pressure, moved - influence @ pressure + rigid @ directions


# ---- Elastic bodies of quadratic triangles that touch without friction, node by node, in motion. A body moves by its
# lowest modes; what all others add to the motion of the nodes that may be touched follows at once, as in statics. A
# step is a small linear complementarity problem: gaps and forces are not negative, and one of the two is zero.
# Nothing stands between the nodes and the surfaces: what a contact yields is what the elements yield. Source: Rubin,
# AIAA J. 13 (1975) 995 (residual flexibility); Hintermüller, Ito and Kunisch, SIAM J. Optim. 13 (2002) 865 (active
# sets).

SHIFT = (2.0 * pi * 2e3) ** 2  # 1/s²: bodies are held by as much of their mass, far below any mode that is left out
AT_ONCE = 32  # unit forces solved for
MOST_TURNS = 40  # of the active set; 2 to 6 are usual


class Body(NamedTuple):
    """A body as its contact nodes feel it."""

    points: np.ndarray  # (n_contact, 2), m, contact nodes as meshed
    omega: np.ndarray  # (n_modes,), rad/s; 0 of rigid ones
    shapes: np.ndarray  # (2 n_contact, n_modes), x and y of each node, 1/√kg
    residual: np.ndarray  # (2 n_contact, 2 n_contact), m/N
    translation: np.ndarray  # (n_modes, 2), √kg: modes' parts in moving along x and y by 1
    mass: float  # kg


def body(mesh: MeshTri, material: Material, length: float, cutoff: float, touched, held=None, mass=None) -> Body:
    """Assemble a body and find its modes up to `cutoff`, Hz; `touched`, `held`: which of points, (2, n), may be, are.

    `mass` : kg, of the circle that the polygon stands for; None: as meshed
    """
    basis = Basis(mesh, ElementVector(ElementTriP2()))
    K = length * plane_strain_stiffness(basis, material)
    M = material.density * length * BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
    x, (along_x, rim) = basis.doflocs, np.zeros((2, basis.N), dtype=bool)
    along_x[basis.get_dofs(elements=np.arange(mesh.nelements)).all("u^1")] = True
    free = np.ones(basis.N, dtype=bool) if held is None else ~held(x)
    rim[basis.get_dofs(mesh.boundary_facets()).all()] = True
    at = rim & touched(x)
    first, second = (k[np.lexsort(np.round(x[:, k], 12))] for k in map(np.flatnonzero, (at & along_x, at & ~along_x)))
    contact = (np.cumsum(free) - 1)[np.stack([first, second], axis=1)].ravel()
    K, M = K[free][:, free].tocsc(), M[free][:, free].tocsc()
    unit = np.stack([along_x, ~along_x], axis=1).astype(float)[free]
    if mass is not None:
        M = M * (mass / float(unit[:, 0] @ (M @ unit[:, 0])))
    how = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    factor = splu((K + SHIFT * M).tocsc(), **how)
    omega, modes = _modes(K, M, factor, 2.0 * pi * cutoff, float(basis.dx.sum()), material)
    return Body(
        points=x[:, first].T.copy(), omega=omega, shapes=modes[contact],
        residual=_residual(factor, contact, omega, modes), translation=modes.T @ (M @ unit),
        mass=float(unit[:, 0] @ (M @ unit[:, 0])),
    )  # fmt: skip


def _modes(K, M, factor, cutoff: float, area: float, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies up to `cutoff`, rad/s, and modes of unit mass."""
    speeds = material.dilatational_wave_speed, np.sqrt(material.lame_mu / material.density)
    expected = area * cutoff**2 / (4.0 * pi) * sum(speed**-2 for speed in speeds)  # Weyl's law
    inverse, count = LinearOperator(K.shape, matvec=factor.solve), round(1.1 * expected) + 20
    start = np.random.default_rng(0).standard_normal(K.shape[0])  # ARPACK's own would differ from call to call
    squares, modes = eigsh(K, count, M, sigma=-SHIFT, OPinv=inverse, v0=start)
    if squares.max() < cutoff**2:
        raise RuntimeError(f"{count} modes end below the cutoff")
    kept = squares < cutoff**2
    squares = np.where(squares < 1e-3 * SHIFT, 0.0, squares)  # rigid motions, but for round-off
    return np.sqrt(squares[kept]), modes[:, kept]


def _residual(factor, contact: np.ndarray, omega: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Displacement of contact nodes by forces on them, without what the modes have of it."""
    found, shapes = [], modes[contact]
    for first in range(0, contact.size, AT_ONCE):
        some = contact[first : first + AT_ONCE]
        force = np.zeros((modes.shape[0], some.size))
        force[some, np.arange(some.size)] = 1.0
        found.append(factor.solve(force)[contact])
    whole = np.concatenate(found, axis=1) - (shapes / (omega**2 + SHIFT)) @ shapes.T
    return 0.5 * (whole + whole.T)


class Motion:
    """A body's modes in time, by the trapezoidal rule; `still`: at rest, with steps that find equilibrium."""

    def __init__(self, of: Body, step: float, still: bool = False):
        self.body, self.step, self.still = of, step, still
        self.inertia = (1.0 if still else 4.0) / step**2
        self.answer = 1.0 / (self.inertia + of.omega**2)
        self.compliance = of.residual + (of.shapes * self.answer) @ of.shapes.T
        self.q, self.v, self.a, self.load = np.zeros((4, of.omega.size))
        self.stored = 0.0  # J, beside the modes

    def expect(self) -> None:
        """Where the step would end if nothing touched."""
        self.drifted = self.q if self.still else self.q + self.step * self.v + 0.25 * self.step**2 * self.a
        self.expected = self.answer * (self.inertia * self.drifted + self.load)

    @property
    def expected_moves(self) -> np.ndarray:
        """Of contact nodes, (n_contact, 2), m."""
        return (self.body.shapes @ self.expected).reshape(-1, 2)

    def advance(self, force: np.ndarray) -> None:
        """Take the step with forces on the contact nodes, (2 n_contact,), N."""
        self.q, k = self.expected + self.answer * (force @ self.body.shapes), np.flatnonzero(force)
        self.stored = 0.5 * float(force[k] @ self.body.residual[np.ix_(k, k)] @ force[k])
        if not self.still:
            new = (self.q - self.drifted) * self.inertia
            self.v, self.a = self.v + 0.5 * self.step * (self.a + new), new

    def mean(self, q: np.ndarray) -> np.ndarray:
        """Motion of the centre of mass, (2,), m."""
        return q @ self.body.translation / self.body.mass

    @property
    def energy(self) -> tuple[float, float]:
        """Kinetic and elastic, J."""
        return 0.5 * float(self.v @ self.v), 0.5 * float(np.sum((self.body.omega * self.q) ** 2)) + self.stored


def separated(gap: np.ndarray, compliance: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Forces, (n,), N, >= 0, under which no gap, (n,), m, is negative; `active`: where to expect them."""
    for _ in range(MOST_TURNS):
        force, k = np.zeros(gap.size), np.flatnonzero(active)
        if k.size:
            force[k] = np.linalg.solve(compliance[np.ix_(k, k)], -gap[k])
        changed = np.where(active, force > 0.0, gap + compliance[:, k] @ force[k] < 0.0)
        if np.array_equal(changed, active):
            return force
        active = changed
    lower = cholesky(compliance, lower=True)
    return nnls(lower.T, solve_triangular(lower, -gap, lower=True))[0]


# ---- A free elastic disc thrown at a rigid frictionless flat: its exact vibration modes driven by a Hertz contact.
# The displacement at the contact is the static one (Johnson's, for two opposite line loads, less what the far load
# does) with the share of the lowest modes replaced by these modes' motion. Nothing is meshed. Source: Johnson,
# Contact Mechanics (1985), 5.6; Michell's series for the disc (Timoshenko and Goodier, Theory of Elasticity, chapter
# 4); modes as above.

LARGEST_N = 16  # waves around
LARGEST_ROOT = 40.0  # ω R/c_T
ROOT_SPACING = 0.02  # of the search
TIME_STEP = 2e-9  # s
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


class Impact(NamedTuple):
    """Numbers that describe an impact."""

    force: float  # largest, N
    duration: float  # s
    rebound: float  # speed of the centre of mass after over before


@cache
def disc_modes(n: int, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Roots ω R/c_T of n waves around, and each mode's static compliance at the surface, times μ and length.

    The compliance is U²/(M ω²) with U the radial displacement at the surface, M the modal mass.
    """

    def condition(x):
        tractions = surface_tractions(n, 1.0, x, material, "j")
        return tractions[0, 0] if n == 0 else np.linalg.det(tractions)  # at n = 0 torsion stands apart

    grid = np.arange(max(0.3, 0.5 * n if n > 2 else 0.0), LARGEST_ROOT, ROOT_SPACING)
    roots = np.array([root for *_, root in _roots(condition, grid, xtol=1e-12)])
    return roots, np.array([_compliance(n, x, material) for x in roots])


def _compliance(n: int, x: float, material: Material) -> float:
    r, a, b = np.append(0.5 * (NODES + 1.0), 1.0), 1.0, 0.0
    if n:  # shares of the two potentials in a mode: the null vector of the tractions
        tractions = surface_tractions(n, 1.0, x, material, "j")
        scale = np.abs(tractions).max(axis=0)
        a, b = np.linalg.svd(tractions / scale)[2][-1] / scale
    k_l, k_t = x / sqrt(material.lame_lambda / material.lame_mu + 2.0), x
    radial = a * k_l * jvp(n, k_l * r) + b * n * jv(n, k_t * r) / r
    tangential = -a * n * jv(n, k_l * r) / r - b * k_t * jvp(n, k_t * r)
    square = (radial**2 + tangential**2)[:-1]
    mass = pi * (2.0 if n == 0 else 1.0) * np.sum(0.5 * WEIGHTS * r[:-1] * square)
    return radial[-1] ** 2 / (mass * x**2)


def static_compliance(n: int, material: Material) -> float:
    """All modes of n waves together, as `disc_modes` gives them: Michell's series for cos nθ, the mean motion apart."""
    kappa = kolosov(material)
    bracket = 0.5 * (kappa - 1.0) if n == 1 else kappa / (n + 1.0) + 1.0 / (n - 1.0)
    return bracket / (4.0 * pi * (2.0 if n == 0 else 1.0))


def _far_load(material: Material) -> float:
    """Σ (−1)^n of the static compliances: displacement under one load by the opposite one, times μ and length."""
    # Σ_{n≥2} (−1)^n/(n+1) = ln 2 − ½ and Σ_{n≥2} (−1)^n/(n−1) = ln 2
    tail = (kolosov(material) * (log(2.0) - 0.5) + log(2.0)) / (4.0 * pi)
    return static_compliance(0, material) - static_compliance(1, material) + tail


def thrown_at_flat(speed: float, radius: float, length: float, material: Material) -> Impact:
    """Follow a disc from its first touch at `speed`, m/s, until it leaves.

    Errors
    ------
    0.1 % of force and time, by the modes left out and the time step.
    """
    roots, compliance = (np.concatenate(of) for of in zip(*(disc_modes(n, material) for n in range(LARGEST_N + 1)),
                                                          strict=True))  # fmt: skip
    compliance = compliance / (material.lame_mu * length)
    omega = roots * sqrt(material.lame_mu / material.density) / radius
    mass, modulus = material.density * pi * radius**2 * length, material.plane_strain_modulus
    moving = compliance.sum() + _far_load(material) / (material.lame_mu * length)

    def at_rest(force):
        """Displacement of all that follows at once, m, and its slope."""
        bracket = 2.0 * log(4.0 * radius) - log(4.0 * force * radius / (pi * modulus * length))
        unit = 1.0 / (pi * modulus * length)
        return force * (unit * (bracket - 1.0) - moving), unit * (bracket - 2.0) - moving

    turn, dt = np.exp(-1j * omega * TIME_STEP), TIME_STEP
    state = np.zeros(omega.size, dtype=complex)  # displacement of each mode + i rate/ω
    depth, rate, force, steps, largest = 0.0, speed, 1e-3, 0, 0.0
    while True:
        closing = depth - state.real.sum()
        force = _force(closing, at_rest, force) if closing > 0.0 else 0.0
        if force == 0.0 and rate < 0.0:
            return Impact(force=largest, duration=steps * dt, rebound=-rate / speed)
        largest = max(largest, force)
        rate -= force / mass * dt
        depth += rate * dt
        state = (state + 1j * omega * compliance * force * dt) * turn
        steps += 1


def _force(closing: float, law, guess: float) -> float:
    """Force of a law δ(Q), by Newton's method."""
    force = max(guess, 1e-6)
    for _ in range(60):
        value, slope = law(force)
        new = max(force - (value - closing) / slope, 0.1 * force)
        if abs(new - force) <= 1e-10 * new:
            return new
        force = new
    raise RuntimeError(f"no force for an approach of {closing:.3e} m")


# ---- Exact free vibrations of rollers that stick to both raceways, and roll and shift along them all alike. A roller
# meets the raceways at opposite ends of a diameter, with tangential motions v_i, v_o of its surface by tractions T_i,
# T_o, all counter-clockwise, at a frequency: v_i = D T_i + X T_o, v_o = X T_i + D T_o, and the rings' −G_i T_i = v_i,
# −G_o T_o = v_o D is what one traction does, D + X what two equal ones do. Each is a sum over harmonics: the static
# one under a traction that sticks (`fem.elastic.continuum`), and what inertia changes of its lower harmonics, by
# Bessel functions; a free disc moves as a whole in the harmonics 0 and 1. With all rollers alike a ring has the
# harmonics that are multiples of their number. Motion along the line of centres is symmetric about it and has no part
# in this.

HARMONICS = 30  # what inertia changes of them falls as 1/n³


def shear_receptance(section: Section, n: int, omega: float) -> float:
    """Tangential displacement of a held ring or a free disc per traction sin nθ at a frequency, rad/s; m/Pa."""
    loaded, held, material, _ = section
    x, kinds = omega * loaded / np.sqrt(material.lame_mu / material.density), "jy" if held else "j"
    conditions, wanted = surface_tractions(n, 1.0, x, material, kinds), [0.0, 1.0]
    if held:
        conditions = np.concatenate([surface_displacements(n, held / loaded, x, material, kinds), conditions])
        wanted = [0.0, 0.0, *wanted]
    scale = np.abs(conditions).max(axis=0)
    weights = np.linalg.solve(conditions / scale, wanted) / scale
    around = float(surface_displacements(n, 1.0, x, material, kinds)[1] @ weights)
    return section.convexity * loaded / material.lame_mu * around


def inertial(section: Section, omega: float) -> float:
    """What contacts that stick move more at a frequency, rad/s, than at rest, m per N/m of each."""
    found = 0.0
    for n in range(0, HARMONICS, section.loads):
        more = shear_receptance(section, n, omega) - float(continuum.shear_compliance(section, np.array([n]))[0])
        found += section.loads / (pi * section.loaded) * (0.5 if n == 0 else 1.0) * more
    return found


def sticking_modes(bearing: Bearing, force: float, low: float = 20e3, high: float = 100e3) -> list[float]:
    """Frequencies between two bounds, Hz, with a normal force, N, on every contact: shifting, then rocking.

    Found as changes of sign on a grid of 500 Hz: two as close as that would be missed.
    """
    one, two, static = continuum.roller_section(bearing), continuum.roller_section(bearing).squeezed, np.empty((2, 2))
    rings = [section._replace(loads=bearing.n_rollers) for section in continuum.ring_sections(bearing)]
    for i, (section, sign) in enumerate(zip(rings, (1.0, -1.0), strict=True)):
        curvature = 1.0 / bearing.roller_radius + sign / section.loaded
        softness = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / section.material.plane_strain_modulus
        half_width = np.sqrt(4.0 * force * softness / (pi * curvature * bearing.roller_length))
        static[i, i] = stick_approach(one, half_width) + stick_approach(section, half_width)
        static[i, 1 - i] = stick_approach(two, half_width) - stick_approach(one, half_width)

    def determinant(frequency: float) -> float:
        omega = 2.0 * pi * frequency
        own, both = inertial(one, omega), inertial(two, omega)
        matrix = static + np.diag([inertial(section, omega) for section in rings])
        matrix = matrix + np.array([[own, both - own], [both - own, own]])
        return np.linalg.det(matrix * bearing.roller.plane_strain_modulus)

    grid = np.arange(low, high, 500.0)
    usual = np.median(np.abs([determinant(frequency) for frequency in grid]))
    roots = [root for *_, root in _roots(determinant, grid, rtol=1e-10)]
    return [root for root in roots if abs(determinant(root)) < 1e-3 * usual]  # the rest are poles

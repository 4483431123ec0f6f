"""What each candidate costs and how far it is from the exact values. Errors are relative."""

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.sparse.linalg import eigsh, splu

from benchmarks.elements.bodies import HALF_WIDTH, Body
from benchmarks.elements.candidates import build
from benchmarks.elements.discretisations import Discrete
from fem.contacts.patch import patch
from fem.elastic.bodies import rigid_modes

SAFETY = 0.9  # step over critical step, the solver's default
PLACES = 2.0 * pi * np.mod(0.618034 * np.arange(24), 1.0)  # of a load, rad; every part of an element is met


@dataclass(frozen=True, kw_only=True)
class Point:
    """One candidate at one size."""

    body: str
    candidate: str
    size_mm: float  # surface spacing asked for
    spacing_mm: float  # as it came out
    freedom: int
    multiply_adds: int  # of one product K·u
    critical_step: float  # s
    compliance: float  # error under the smooth pressure
    frequencies: float  # error as stepped
    frequencies_still: float  # error with an infinitely short step
    ripple: float  # peak to peak under the solver's patch as it travels, over the exact approach
    coupling: float  # error of the displacement beside the solver's patch, over the exact approach

    @property
    def steps(self) -> float:
        """For one simulated millisecond."""
        return 1e-3 / (SAFETY * self.critical_step)

    @property
    def cost(self) -> float:
        """Multiply-adds of K·u for one simulated millisecond."""
        return self.multiply_adds * self.steps


def measure(body: Body, candidate: str, size_mm: float) -> Point:
    """Cost and errors of a candidate whose surface nodes are about `size_mm` apart."""
    discrete = build(body, candidate, 1e-3 * size_mm)
    free = body.free(discrete)
    stiffness, mass = discrete.stiffness[free][:, free], np.repeat(discrete.mass, 2)[free]
    scale = sparse.diags_array(1.0 / np.sqrt(mass))
    start = np.random.default_rng(0).standard_normal(mass.size)
    scaled = scale @ stiffness @ scale
    critical_step = 2.0 / np.sqrt(eigsh(scaled, k=1, which="LA", tol=1e-6, v0=start, return_eigenvectors=False)[0])
    exact = body.exact_frequencies
    still = frequencies(body, stiffness, mass, exact.size)
    stepped = as_stepped(still, SAFETY * critical_step)
    under, beside = patch_motion(body, discrete)
    return Point(
        body=body.name,
        candidate=candidate,
        size_mm=size_mm,
        spacing_mm=2e3 * pi * body.raceway / surface_nodes(body, discrete).size,
        freedom=free.size,
        multiply_adds=stiffness.tobsr((2, 2)).data.size,
        critical_step=float(critical_step),
        compliance=rms(smooth_compliance(body, discrete) / body.exact_compliance() - 1.0),
        frequencies=rms(stepped / exact - 1.0),
        frequencies_still=rms(still / exact - 1.0),
        ripple=float(np.ptp(under) / body.exact_approach()),
        coupling=rms(beside - body.exact_coupling()) / body.exact_approach(),
    )


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def surface_nodes(body: Body, discrete: Discrete) -> np.ndarray:
    """Nodes of the loaded surface by angle from 0, (m,)."""
    x, y = discrete.points.T
    on = np.flatnonzero(np.abs(np.hypot(x, y) - body.raceway) < 1e-9 * body.raceway)
    return on[np.argsort(np.mod(np.arctan2(y[on], x[on]) + 1e-9, 2.0 * pi))]


def frequencies(body: Body, stiffness: sparse.csr_array, mass: np.ndarray, count: int) -> np.ndarray:
    """The lowest ω, rad/s, above rigid motions."""
    rigid = 3 if body.held is None else 0
    shift = 0.1 * body.exact_frequencies[0] ** 2  # between the rigid motions and the first mode
    start = np.random.default_rng(1).standard_normal(mass.size)
    diagonal = sparse.diags_array(mass).tocsc()
    found = eigsh(stiffness.tocsc(), k=count + rigid, M=diagonal, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(found)[rigid:])


def as_stepped(frequency: np.ndarray, step: float) -> np.ndarray:
    """Frequency that leapfrog makes of ω, rad/s: (2/Δt) arcsin(ωΔt/2)."""
    return 2.0 / step * np.arcsin(0.5 * step * frequency)


def smooth_compliance(body: Body, discrete: Discrete) -> np.ndarray:
    """Displacement under the smooth pressure, averaged by it, at every place, m/N."""
    spline = BSpline.basis_element(np.linspace(-HALF_WIDTH, HALF_WIDTH, 5), extrapolate=False)
    unit = 2.0 / HALF_WIDTH  # a basis element's integral is a quarter of its support

    def pushed(angle):
        def pressure(theta):
            along = body.raceway * (np.mod(theta - angle + pi, 2.0 * pi) - pi)
            return unit * np.nan_to_num(spline(along))

        return -body.outward * discrete.pressed(body.raceway, pressure)

    loads, moved = _moved(body, discrete, pushed)
    return np.einsum("np,np->p", loads, moved)


def patch_motion(body: Body, discrete: Discrete) -> tuple[np.ndarray, np.ndarray]:
    """Displacement under the solver's patch of six surface nodes and that of the patch `apart` from it, m/N."""
    surface = surface_nodes(body, discrete)

    def pushed(angle):
        nodes, weight, _ = patch(surface.size, angle)
        force = np.zeros((len(discrete.points), 2))
        np.add.at(force, surface[nodes], body.outward * np.outer(weight, [np.cos(angle), np.sin(angle)]))
        return force.ravel()

    loads, moved = _moved(body, discrete, pushed)
    beside = np.stack([pushed(angle + body.apart) for angle in PLACES], axis=-1)
    return np.einsum("np,np->p", loads, moved), np.einsum("np,np->p", beside, moved)


def _moved(body: Body, discrete: Discrete, pushed) -> tuple[np.ndarray, np.ndarray]:
    """Unit loads `pushed(angle)` at every place, N, and what they and their like opposite move, m: (2n, places)."""
    loads = np.stack([pushed(angle) for angle in PLACES], axis=-1)
    everything = sum(np.stack([pushed(angle + at) for angle in PLACES], axis=-1) for at in body.loads)
    if body.held is not None:
        free = body.free(discrete)
        moved = np.zeros_like(loads)
        moved[free] = splu(discrete.stiffness[free][:, free].tocsc()).solve(everything[free])
        return loads, moved
    # rigid motions are held by Lagrange multipliers; the loads are balanced but for the mesh's errors
    modes = sparse.csc_array(rigid_modes(discrete.points) * np.repeat(discrete.mass, 2)[:, None])
    bordered = sparse.block_array([[discrete.stiffness, modes], [modes.T, None]], format="csc")
    return loads, splu(bordered).solve(np.concatenate([everything, np.zeros((3, PLACES.size))]))[: len(loads)]

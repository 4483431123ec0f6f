"""What the mesh can't see of a contact: the sub-grid Hertz compliance, calibrated to each body's mesh.

The finite elements carry the contact force as a smooth patch two to four nodes wide. The true Hertz pressure of
half-width b is far narrower; its extra approach, per body,

    δ_i = A_i Q (B_i − ½ ln Q),    A_i = 2 / (π E'_i L),

has the half-plane's dependence on b, and a B_i fixed so that finite elements plus sub-grid term give the exact
continuum answer for that body: a free disc squeezed by two Hertz pressures, a ring held on its other circle. A mesh
is softer at some places of its surface than at others (0.1 % between node and mid-edge, 1 % along a sextant of the
disc), so B_i is a periodic function of the contact's position: a mean and a ripple, a spline over one period.
"""

from dataclasses import dataclass
from math import exp, log, pi, sqrt

import numpy as np

from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.continuum import disc_hertz_approach, ring_hertz_approach
from fem.kernels.law import KNOTS_PER_NODE, STEEPEST, contact_force
from fem.kernels.patches import N_NODES, first_node, weights
from lagrange import Material


@dataclass(frozen=True, kw_only=True)
class SurfaceCompliance:
    """Approach of one body's surface under unit load: exact continuum minus finite elements."""

    missing: float  # m/N, at half_width, mean over positions
    half_width: float  # b at which the continuum was evaluated, m
    unit: float  # A_i = 2/(π E'_i L), m/N
    ripple: np.ndarray  # (period · KNOTS_PER_NODE,), coefficients of A_i·B_i minus its mean, cubic B-spline, m/N
    spread: float  # peak to peak of what the ripple takes away, relative to the exact approach


@dataclass(frozen=True, kw_only=True)
class ContactLaw:
    """Sub-grid approach of a pair of bodies: δ = A Q (B − ½ ln Q), a straight line above Q_line."""

    A: float  # m/N
    B: float
    Q_line: float  # N
    relative_radius: float  # R, m
    half_width_factor: float  # b²/Q = 4R/(π E* L), m²/N (Johnson, Contact Mechanics, 1985, ch. 4)

    def half_width(self, force: float) -> float:
        """Hertz half-width b, m."""
        return sqrt(self.half_width_factor * force)

    def approach(self, force):
        """Sub-grid approach, m, of a force, N, >= 0."""
        force = np.asarray(force, dtype=float)
        bracket = self.B - 0.5 * np.log(np.maximum(force, 1e-300))
        at_line = self.A * self.Q_line * (0.5 + STEEPEST)
        line = at_line + self.A * STEEPEST * (force - self.Q_line)
        return np.where(force > self.Q_line, line, self.A * force * bracket)

    def force(self, approach: float) -> float:
        """Force, N, of a sub-grid approach, m."""
        return contact_force(approach, self.A, self.B, self.Q_line, 0.0)

    def stiffness(self, force: float) -> float:
        """dQ/dδ, N/m, at a force, N, > 0."""
        return 1.0 / float(self.softness(force))

    def softness(self, force):
        """dδ/dQ, m/N, at a force, N, > 0."""
        return self.A * np.maximum(self.B - 0.5 * np.log(force) - 0.5, STEEPEST)


def patch(n_surface: int, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, weights and angular offsets (contact minus node, rad) of the patch at an angle; each (6,)."""
    position = angle * n_surface / (2.0 * pi)
    base = int(np.floor(position))
    weight = np.empty(N_NODES)
    weights(position - base, weight, 0, 1)
    nodes = first_node(base) + np.arange(N_NODES)
    return nodes % n_surface, weight, (position - nodes) * (2.0 * pi / n_surface)


def ring_patch_force(ring: RingBody, angle: float) -> np.ndarray:
    """Nodal forces (n_rows, 2, n_sectors) of a unit force along the outward radius at `angle` of the raceway."""
    nodes, weight, offset = patch(ring.n_sectors, angle)
    force = np.zeros((ring.n_rows, 2, ring.n_sectors))
    np.add.at(force, (ring.raceway_row, 0, nodes), weight * np.cos(offset))
    np.add.at(force, (ring.raceway_row, 1, nodes), weight * np.sin(offset))
    return force


def disc_patch_force(disc: DiscBody, angle: float) -> np.ndarray:
    """Nodal forces (2 n_nodes,) of a unit force along the outward radius at `angle` of the surface."""
    nodes, weight, _ = patch(disc.shape.surface_nodes, angle)
    force = np.zeros((disc.n_nodes, 2))
    np.add.at(force, disc.first_surface_node + nodes, np.outer(weight, [np.cos(angle), np.sin(angle)]))
    return force.ravel()


def ring_compliance(ring: RingBody, thickness: float, half_width: float) -> SurfaceCompliance:
    """Calibrate a held ring against the exact annulus under one Hertz pressure."""
    if ring.material.rigid:
        return rigid_surface(half_width)
    angles = np.arange(KNOTS_PER_NODE) / KNOTS_PER_NODE * (2.0 * pi / ring.n_sectors)
    loads = np.stack([ring_patch_force(ring, angle) for angle in angles], axis=-1)
    found = np.einsum("rcsp,rcsp->p", loads, ring.held(loads))
    held = float(ring.radii[ring.held_row])
    exact = ring_hertz_approach(ring.raceway_radius, held, ring.material, half_width) / thickness
    return _missing(exact, found, half_width, ring.material, thickness)


def disc_compliance(disc: DiscBody, thickness: float, half_width: float) -> SurfaceCompliance:
    """Calibrate a free disc against the exact disc squeezed by two opposite Hertz pressures."""
    if disc.material.rigid:
        return rigid_surface(half_width)
    nodes = disc.shape.surface_nodes
    angles = np.arange(nodes // disc.shape.repeats * KNOTS_PER_NODE) / KNOTS_PER_NODE * (2.0 * pi / nodes)
    found = np.concatenate([_squeezed(disc, some) for some in np.array_split(angles, 1 + angles.size // 512)])
    exact = disc_hertz_approach(disc.shape.radius, disc.material, half_width) / thickness
    return _missing(exact, found, half_width, disc.material, thickness)


def _squeezed(disc: DiscBody, angles: np.ndarray) -> np.ndarray:
    """Approach of the mesh's surface at one of two opposite unit forces, (n_angles,), m/N."""
    near = np.stack([disc_patch_force(disc, angle) for angle in angles], axis=-1)
    far = np.stack([disc_patch_force(disc, angle + pi) for angle in angles], axis=-1)
    return np.einsum("np,np->p", near, disc.relaxed(near + far))


def rigid_surface(half_width: float) -> SurfaceCompliance:
    """Of a body that does not give way."""
    return SurfaceCompliance(missing=0.0, half_width=half_width, unit=0.0, ripple=np.zeros(KNOTS_PER_NODE), spread=0.0)


def unmeshed_disc(radius: float, material: Material, thickness: float, half_width: float) -> SurfaceCompliance:
    """Of a disc without finite elements: the whole approach of the exact disc squeezed by two Hertz pressures."""
    return SurfaceCompliance(
        missing=disc_hertz_approach(radius, material, half_width) / thickness,
        half_width=half_width,
        unit=2.0 / (pi * material.plane_strain_modulus * thickness),
        ripple=np.zeros(KNOTS_PER_NODE),
        spread=0.0,
    )


def _missing(exact: float, found: np.ndarray, half_width: float, material: Material, thickness: float):
    return SurfaceCompliance(
        missing=float(exact - found.mean()),
        half_width=half_width,
        unit=2.0 / (pi * material.plane_strain_modulus * thickness),
        ripple=_spline_coefficients(found.mean() - found),
        spread=float(np.ptp(found) / exact),
    )


def _spline_coefficients(samples: np.ndarray) -> np.ndarray:
    """Coefficients of the periodic cubic B-spline through equally spaced samples."""
    wave = 2.0 * np.pi * np.fft.rfftfreq(samples.size)
    return np.fft.irfft(np.fft.rfft(samples) * 3.0 / (2.0 + np.cos(wave)), n=samples.size)


def contact_law(first: SurfaceCompliance, second: SurfaceCompliance, relative_radius: float) -> ContactLaw:
    """Law of a pair of calibrated surfaces, ripples apart."""
    factor = relative_radius * 2.0 * (first.unit + second.unit)
    A = first.unit + second.unit
    AB = sum(s.missing + s.unit * (log(s.half_width) - 0.5 * log(factor)) for s in (first, second))
    return ContactLaw(
        A=A,
        B=AB / A,
        Q_line=exp(2.0 * (AB / A - 0.5 - STEEPEST)),
        relative_radius=relative_radius,
        half_width_factor=factor,
    )

"""Statics of the whole bearing without a mesh: exact series for every body under Hertz pressures.

The yardstick for the finite-element model: any bearing, frictionless, standing, weightless, in milliseconds.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.continuum import (
    Section,
    cross_compliance,
    hertz_approach,
    hertz_patch,
    patch_crossing,
    patch_displacement,
    patch_slope,
    plane_compliance,
    ring_sections,
    roller_section,
)
from fem.statics.contact_balance import Condensed, Loads, NotFound, balance, closed_forces, first_guess
from lagrange import Bearing, Operation
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles

HALF_WIDTH = 0.01  # of a roller's radius; the logarithm of the true half-width is in the law
N_HARMONICS_PER_WIDTH = 200.0  # harmonics times b/R: point values under Hertz pressures converge slowly
LEAST_LOAD = 1e-6  # N; under less, bodies move by less than round-off


@dataclass(frozen=True, kw_only=True)
class ExactStatics:
    """Hub position, m, and contact forces, N."""

    hub: np.ndarray  # (2,)
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray


def exact_statics(bearing: Bearing, radial_load: float, first_roller_angle: float) -> ExactStatics:
    """Equilibrium of elastic bodies in Hertz contact under a load along −y, N; angle in rad from +x.

    Errors
    ------
    Each contact errs as Hertz's theory does, by (b/R)² of its approach; couplings are exact for loads along the radius.
    NotFound: no equilibrium.

    Source: Michell's series for ring and disc (`continuum`); Johnson, Contact Mechanics (1985), chapters 4 and 5.
    """
    n = bearing.n_rollers
    contacts = exact_contacts(bearing, roller_angles(bearing, first_roller_angle))
    start = first_guess(bearing, contacts.radial, radial_load)
    position, forces = balance(contacts, Loads(radial_load), start)
    forces = closed_forces(forces)
    return ExactStatics(hub=position[:2], inner_force=forces[:n], outer_force=forces[n:])


def exact_contacts(bearing: Bearing, angle: np.ndarray) -> Condensed:
    """The bearing reduced to its contacts by exact series, rollers at angles from +x, (n_rollers,), rad."""
    n, closing = bearing.n_rollers, np.zeros(2 * bearing.n_rollers)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    if bearing.missing:
        whole = exact_contacts(bearing.full, roller_angles(bearing.full, 0.0))
        compliance = of_present(bearing, whole.compliance)
        return replace(whole, bearing=bearing, radial=radial, compliance=compliance, closing=closing)
    half_width, length, roller = HALF_WIDTH * bearing.roller_radius, bearing.roller_length, roller_section(bearing)
    single, squeezed = hertz_approach(roller, half_width), hertz_approach(roller.squeezed, half_width)
    compliance, j, laws = np.zeros((2 * n, 2 * n)), np.arange(n), []
    for k, (ring, pair) in enumerate(zip(ring_sections(bearing), contact_pairs(bearing), strict=False)):
        series = _loaded_ring(ring, half_width)
        for shift in range(1, n // 2 + 1):  # equally spaced: one value per distance
            value = patch_displacement(*series, 1.0, ring.loaded, angle[shift] - angle[0])
            to = (j + shift) % n
            compliance[k * n + j, k * n + to] = compliance[k * n + to, k * n + j] = value
        approach = (hertz_approach(ring, half_width) + single) / length
        laws.append(ContactLaw.of_approach(approach, half_width, pair))
    compliance[j, n + j] = compliance[n + j, j] = squeezed - single
    return Condensed(
        bearing=bearing, radial=radial, inner_law=laws[0], outer_law=laws[1], compliance=compliance / length,
        closing=closing,
    )  # fmt: skip


def of_present(bearing: Bearing, compliance: np.ndarray) -> np.ndarray:
    """Compliance of the contacts of a bearing's rollers, (2 n_rollers, 2 n_rollers), of those of all pockets."""
    contacts = np.concatenate([bearing.pocket, bearing.pockets + np.array(bearing.pocket)])
    return compliance[np.ix_(contacts, contacts)]


def _loaded_ring(ring: Section, half_width: float, compliance: Callable = plane_compliance):
    """Compliance, m/Pa, and transform of the load, by harmonics, (n_harmonics,)."""
    harmonics = np.arange(int(N_HARMONICS_PER_WIDTH * ring.loaded / half_width))
    return compliance(ring, harmonics), hertz_patch(harmonics, half_width, ring.loaded)


def couplings_at(bearing: Bearing, angle: np.ndarray) -> np.ndarray:
    """Coupling compliance of a contact with a force at an angle, rad, along its ring, and its slope: (2, 2, n_angles).

    By ring, inner and outer: m/N, and m/N per rad.
    """
    found = []
    for ring in ring_sections(bearing):
        series = _loaded_ring(ring, HALF_WIDTH * bearing.roller_radius)
        given = [patch_displacement(*series, 1.0, ring.loaded, each) for each in angle]
        found.append([given, [patch_slope(*series, ring.loaded, each) for each in angle]])
    return np.array(found) / bearing.roller_length


def crossings_at(bearing: Bearing, angle: np.ndarray) -> np.ndarray:
    """Cross compliance of a raceway under tractions along +θ, at angles, rad, ahead of them: (2, n_angles), m/N.

    By ring, inner and outer.
    """
    found = []
    for ring in ring_sections(bearing):
        pulled = _loaded_ring(ring, HALF_WIDTH * bearing.roller_radius, cross_compliance)
        found.append([patch_crossing(*pulled, ring.loaded, each) for each in angle])
    return np.array(found) / bearing.roller_length


@lru_cache(maxsize=8)
def law_error(bearing: Bearing, law: ContactLaw, force: float) -> float:
    """By how much of its approach a raceway contact's law is too stiff under a force, N, as far as series know.

    The law takes a body's displacement near a contact for a half-plane's and what a narrow load adds; series have all
    of a body, under Hertz's pressure.

    Errors
    ------
    The pressure's own change is not in it: collocation of twenty contacts, of half-widths of 2 to 9 % of the roller's
    radius and up to 23 % of the ring's thickness, finds 1.6 to 2.4 times as much.
    ValueError: a half-width beyond the roller's radius.
    """
    inner, outer = ring_sections(bearing)
    half_width = law.pair.half_width(force)
    of_ring = hertz_approach(inner if law.pair.kind == "inner" else outer, half_width)
    whole = force * (of_ring + hertz_approach(roller_section(bearing), half_width)) / law.pair.length
    return whole / float(law.approach(force)) - 1.0


@dataclass(frozen=True)
class ExpectedForces:
    """Static forces of a bearing's contacts, N."""

    bearing: Bearing
    operation: Operation

    @cached_property
    def largest(self) -> float:
        """Largest force by exact statics, solved when first asked for; the bound where there is no equilibrium."""
        try:
            found = exact_statics(self.bearing, self._load, self.operation.first_roller_angle)
        except NotFound:
            return self.bound
        return float(np.concatenate([found.inner_force, found.outer_force]).max()) + self._centrifugal

    @property
    def bound(self) -> float:
        """Above any contact's force: all the load on one roller, and the preload of rigid rings."""
        bearing = self.bearing
        preload = max(0.0, -bearing.radial_clearance)
        bodies = bearing.roller, bearing.inner_ring, bearing.outer_ring
        modulus = max(material.plane_strain_modulus for material in bodies if not material.rigid)
        return self._load + self._centrifugal + modulus * bearing.roller_length * preload

    @property
    def _load(self) -> float:
        return self.operation.heaviest + self.operation.inner_mass * self.operation.gravity

    @property
    def _centrifugal(self) -> float:
        inner, outer = (np.abs(speeds).max() for speeds in self.operation.ring_speeds_met)
        cage = float(0.5 * inner + outer)  # or less
        return self.bearing.roller_mass * cage**2 * self.bearing.pitch_radius

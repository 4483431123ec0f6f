"""Statics of the whole bearing without a mesh: exact series for every body under Hertz pressures.

The yardstick for the finite-element model: any bearing, frictionless, standing, weightless, in milliseconds.
"""

from dataclasses import dataclass
from math import exp, log, pi

import numpy as np

from fem.contact_balance import SHARP, Condensed, Loads, balance, closed_forces, first_guess
from fem.continuum import (
    disc_hertz_approach,
    hertz_patch,
    patch_displacement,
    ring_compliance,
    ring_hertz_approach,
)
from fem.equilibrium import Motion, static_equilibrium
from fem.model import Model
from fem.subgrid import STEEPEST, ContactLaw
from lagrange import Bearing, Material, Operation
from lagrange.kinematics import roller_angles

HALF_WIDTH = 0.01  # of a roller's radius; the logarithm of the true half-width is in the law
N_HARMONICS_PER_WIDTH = 200.0  # harmonics times b/R: point values under Hertz pressures converge slowly


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
    angle = roller_angles(bearing, first_roller_angle)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    half_width = HALF_WIDTH * bearing.roller_radius
    inner = bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring
    outer = bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring
    single = disc_hertz_approach(bearing.roller_radius, bearing.roller, half_width, 1)
    squeezed = disc_hertz_approach(bearing.roller_radius, bearing.roller, half_width, 2)
    j = np.arange(n)
    compliance = np.zeros((2 * n, 2 * n))
    compliance[:n, :n] = _ring_coupling(*inner, half_width, angle)
    compliance[n:, n:] = _ring_coupling(*outer, half_width, angle)
    compliance[j, n + j] = compliance[n + j, j] = squeezed - single
    curvature = 1.0 / bearing.roller_radius
    contacts = Condensed(
        bearing=bearing,
        radial=radial,
        inner_law=_law(bearing, inner, single, half_width, curvature + 1.0 / bearing.inner_raceway_radius),
        outer_law=_law(bearing, outer, single, half_width, curvature - 1.0 / bearing.outer_raceway_radius),
        compliance=compliance / bearing.roller_length,
        growth=np.zeros(2 * n),
    )
    start = first_guess(bearing, radial, radial_load)
    found = balance(contacts, Loads(radial_load, 0.0, 0.0, SHARP * bearing.roller_radius, 0.0, start), cold=True)
    forces = closed_forces(found, n)
    return ExactStatics(hub=found[:2], inner_force=forces[:n], outer_force=forces[n:])


def _ring_coupling(radius: float, held: float, material: Material, half_width: float, angle) -> np.ndarray:
    """Displacement of each contact by a unit load, N/m, on each other; zero on the diagonal."""
    harmonics = np.arange(int(N_HARMONICS_PER_WIDTH * radius / half_width))
    series = ring_compliance(harmonics, radius, held, material)
    pressure = hertz_patch(harmonics, half_width, radius)
    coupling = np.zeros((len(angle), len(angle)))
    for shift in range(1, len(angle)):  # equally spaced: one value per distance
        value = patch_displacement(series, pressure, 1.0, radius, angle[shift] - angle[0])
        i = np.arange(len(angle))
        coupling[i, (i + shift) % len(angle)] = value
    return coupling


def _law(bearing: Bearing, ring, roller_approach: float, half_width: float, curvature: float) -> ContactLaw:
    """The whole approach of one contact, both bodies, as a law δ = A Q (B − ½ ln Q)."""
    radius, held, material = ring
    length = bearing.roller_length
    A = sum(2.0 / (pi * m.plane_strain_modulus * length) for m in (bearing.roller, material))
    factor = 2.0 * A / curvature
    total = (ring_hertz_approach(radius, held, material, half_width) + roller_approach) / length
    B = total / A + log(half_width) - 0.5 * log(factor)
    return ContactLaw(
        A=A,
        B=B,
        Q_line=exp(2.0 * (B - 0.5 - STEEPEST)),
        relative_radius=1.0 / curvature,
        half_width_factor=factor,
    )


@dataclass(frozen=True, kw_only=True)
class DiscretisationError:
    """The mesh against the series, standing, weightless and frictionless."""

    hub: float  # relative error of the hub's displacement
    largest_force: float  # largest error of a roller's load over the largest load


def static_error(model: Model, operation: Operation) -> DiscretisationError:
    """How far the finite elements of a scene are from exact elasticity under its load.

    Errors
    ------
    ValueError: without load there is nothing to compare. NotFound: no equilibrium.
    """
    if operation.radial_load <= 0.0:
        raise ValueError("without a radial load there is no static displacement to compare")
    still = Motion(
        roller_angle=roller_angles(model.bearing, operation.first_roller_angle),
        roller_turn=np.zeros(model.bearing.n_rollers),
        ring_turn=0.0,
        cage_speed=0.0,
        roller_speed=0.0,
        ring_speed=0.0,
    )
    exact = exact_statics(model.bearing, operation.radial_load, operation.first_roller_angle)
    found = static_equilibrium(model, still, operation.radial_load, 0.0, 0.0)
    return DiscretisationError(
        hub=float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)),
        largest_force=float(np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()),
    )

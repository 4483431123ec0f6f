"""Scenes the model can't bear although each of their values is fine: too fast, too soft, too heavily loaded."""

from math import pi, sqrt

import numba

from fem.elastic.model import Model
from fem.errors import UsageError
from fem.statics.equilibrium import Equilibrium
from lagrange import Bearing, Kinematics
from meshes import Mesh, quality

LEAST_ANGLE = 30.0  # degrees
LONGEST_EDGE = 40.0  # over the shortest of the same mesh
LARGEST_STRAIN = 0.01  # linear elasticity errs by about the strain itself
WIDEST_CONTACT = 0.1  # Hertz half-width over the roller's radius; the half-plane errs by about its square


def check_threads(threads: int) -> None:
    """Refuse more threads than the machine runs at once: they would wait for each other in every step."""
    most = numba.config.NUMBA_NUM_THREADS
    if threads > most:
        raise UsageError(
            f"numerics.threads = {threads}: this machine, or NUMBA_NUM_THREADS, has {most}; at most {most}"
        )


def check_meshes(model: Model) -> None:
    """Refuse meshes too distorted to be trusted."""
    for name in ("roller", "inner_ring", "outer_ring"):
        body = getattr(model, name)
        found = quality(Mesh(points=body.points, cells=body.cells))
        if found.smallest_angle < LEAST_ANGLE or found.largest_edge > LONGEST_EDGE * found.smallest_edge:
            raise UsageError(
                f"the mesh of the {name.replace('_', ' ')} has angles down to {found.smallest_angle:.0f} degrees (at "
                f"least {LEAST_ANGLE:.0f}) and edges from {1e3 * found.smallest_edge:.3g} to "
                f"{1e3 * found.largest_edge:.3g} mm (ratio at most {LONGEST_EDGE:.0f}); change numerics.mesh_size_mm "
                "or the ring's thickness"
            )


def check_speed(model: Model, ideal: Kinematics) -> None:
    """Refuse a speed whose centrifugal strain ρ v²/E leaves linear elasticity.

    v is the surface speed: of the inner raceway, of a roller about its own axis.
    """
    bearing = model.bearing
    bodies = {
        "the inner ring": (bearing.inner_ring, ideal.shaft * bearing.inner_raceway_radius),
        "the rollers": (bearing.roller, ideal.roller * bearing.roller_radius),
    }
    for name, (material, surface_speed) in bodies.items():
        strain = 0.0 if material.rigid else material.density * surface_speed**2 / material.youngs_modulus
        if strain > LARGEST_STRAIN:
            most = abs(ideal.shaft) * sqrt(LARGEST_STRAIN / strain) * 60.0 / (2.0 * pi)
            raise UsageError(
                f"operation.speed_rpm: {name} would strain by {strain:.2g} under centrifugal load, beyond the "
                f"{LARGEST_STRAIN} that linear elasticity bears; at most {most:.6g} rpm"
            )


def check_width(raceway: str, force: float, half_width: float, bearing: Bearing) -> None:
    """Refuse a contact too wide for Hertz's theory; N, m."""
    widest = WIDEST_CONTACT * bearing.roller_radius
    if half_width > widest:
        raise UsageError(
            f"the largest static force, {force:.4g} N on the {raceway} raceway, makes a contact of half-width "
            f"{1e3 * half_width:.3g} mm, beyond Hertz's theory (at most {1e3 * widest:.3g} mm here); lower "
            "operation.radial_load_N or operation.speed_rpm, or take a stiffer material"
        )


def check_contacts(model: Model, equilibrium: Equilibrium) -> None:
    """Refuse contacts too wide for Hertz's theory, or wider than a mesh this fine leaves to the sub-grid law."""
    raceways = (
        ("inner", model.inner_law, model.inner_ring, equilibrium.inner_force.max()),
        ("outer", model.outer_law, model.outer_ring, equilibrium.outer_force.max()),
    )
    for name, law, ring, force in raceways:
        half_width = law.half_width(float(force))
        check_width(name, float(force), half_width, model.bearing)
        if not model.is_resolved and force > law.Q_line:
            spacing = 2.0 * pi * ring.raceway_radius / ring.n_sectors
            enough = 1.2e3 * spacing * half_width / law.half_width(law.Q_line)
            raise UsageError(
                f"numerics.mesh_size_mm: the mesh is finer than the contact on the {name} raceway (half-width "
                f"{1e3 * half_width:.3g} mm), which the sub-grid law can't describe; at least {enough:.3g}"
            )

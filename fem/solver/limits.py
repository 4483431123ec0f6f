"""Scenes the model can't bear although each of their values is fine: too fast, too soft, too heavily loaded.

In the order in which a plan meets them: what is to be meshed, the contact model, meshes, speed, contacts at rest.
"""

from collections.abc import Callable
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fem.solver.guards import WIDEST_CONTACT
from fem.statics.exact_statics import ExpectedForces
from lagrange import Bearing, Kinematics
from lagrange.contact.hertz import Pair, contact_pairs
from lagrange.errors import UsageError
from lagrange.limits import exceeds
from lagrange.scene.scene import Scene
from lagrange.scene.surfaces import SURFACES
from meshes import Mesh, bearing_shapes, quality

if TYPE_CHECKING:
    from fem.contacts.model import Model
    from fem.statics.equilibrium import Equilibrium

LEAST_ANGLE = 30.0  # degrees
LONGEST_EDGE = 40.0  # over the shortest of the same mesh
LARGEST_STRAIN = 0.01  # linear elasticity errs by about the strain itself
MOST_NODES = 1_000_000  # take about 3 GB to mesh and assemble
HOPELESS = 2.0  # a contact so many times too wide, by a force that may be a bound, is refused before it is meshed


def check_rollers(scene: Scene) -> None:
    """Refuse balls, which no plane section describes."""
    if scene.bearing.type == "ball":
        raise UsageError(
            'bearing.type = "ball": finite elements and pictures are for cylindrical rollers only; use run-fem '
            "--model lagrange, and check-residual for figures"
        )


def check_mesh_size(bearing: Bearing, mesh_size: float, shapes_of: Callable = bearing_shapes) -> None:
    """Refuse a mesh before anything is allocated for it. `mesh_size` in m; `shapes_of`: a contact model's.

    Errors
    ------
    UsageError: elements thicker than a ring, or too many nodes.
    """
    for name, thickness in (
        ("inner ring", bearing.inner_raceway_radius - bearing.bore_radius),
        ("outer ring", bearing.outside_radius - bearing.outer_raceway_radius),
    ):
        if exceeds(mesh_size, thickness):
            raise UsageError(
                f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: the {name} is only {1e3 * thickness:.3g} mm thick; at "
                f"most {1e3 * thickness:.3g}"
            )
    shapes = shapes_of(bearing, mesh_size)
    nodes = bearing.n_rollers * sum(row.nodes for row in shapes.roller.rows)
    nodes += sum(ring.sectors * len(ring.radii) for ring in (shapes.inner_ring, shapes.outer_ring))
    if nodes > MOST_NODES:
        raise UsageError(
            f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: makes {nodes:,} nodes, at most {MOST_NODES:,} are allowed; "
            f"at least about {1e3 * mesh_size * (nodes / MOST_NODES) ** 0.5:.2g}"
        )


def check_outer_ring(kind: "type[Model]", scene: Scene) -> None:
    """Refuse what contacts spread over points of a fine mesh do not know: outer rings not held all around, sections."""
    mounting, angle = scene.mounting(), scene.bearing.contact_angle_deg
    if angle > 0.0 and not kind.has_law:
        raise UsageError(
            f"bearing.contact_angle_deg = {angle:g}: numerics.mesh_size_mm = {scene.numerics.mesh_size_mm:g} is so "
            "fine that contacts are spread over points, on circles of bodies' curvature; use a coarser mesh"
        )
    if (mounting.points is not None or mounting.bore is not None) and not kind.has_law:
        given = 'kind = "points"' if mounting.bore is None else "fit_clearance_um"
        raise UsageError(
            f"support.{given}: numerics.mesh_size_mm = {scene.numerics.mesh_size_mm:g} is so fine that "
            "contacts are spread over points, which takes rings that are held all around; use a coarser mesh"
        )


def check_contact_model(kind: "type[Model]", scene: Scene, expected: ExpectedForces) -> None:
    """Refuse what a contact model is not made for, before it is built.

    Errors
    ------
    UsageError: a mesh too coarse for it; where it is made for a force, contacts far too wide, and rigid bodies.
    """
    if kind.coarsest == inf:
        return
    bearing, mesh_size, force = expected.bearing, 1e-3 * scene.numerics.mesh_size_mm, expected.largest
    widths = [pair.half_width(force) for pair in contact_pairs(bearing)[:2]]
    if bearing.faults and not kind.has_law:
        given = next((f"[[{name}]]" for name in SURFACES if getattr(scene, name)), "[lubricant]")
        raise UsageError(
            f"{given}: numerics.mesh_size_mm = {1e3 * mesh_size:g} is so fine that contacts are spread over points, "
            "which lie on perfect circles; at "
            f"least {1e3 * kind.coarsest * max(widths):.3g}"
        )
    if not kind.is_made_for_a_force:
        coarsest = kind.coarsest * min(widths)
        if mesh_size > coarsest:
            raise UsageError(
                f"contact.model = '{scene.contact.model}': the narrowest of the most loaded contacts is "
                f"{1e3 * min(widths):.3g} mm wide on either side, the mesh {1e3 * mesh_size:.3g} mm; "
                f"numerics.mesh_size_mm at most {1e3 * coarsest:.3g}, or use contact.model = 'subgrid'"
            )
        return
    if max(widths) > HOPELESS * WIDEST_CONTACT * bearing.roller_radius:
        check_widths(bearing, force)
    if scene.bodies.rigid:
        raise UsageError(
            f'bodies.{scene.bodies.rigid[0]} = "rigid": numerics.mesh_size_mm = {1e3 * mesh_size:g} is so fine that '
            f"contacts are spread over nodes, and a rigid body has none; at least "
            f'{1e3 * kind.coarsest * max(widths):.3g}, or every body "elastic"'
        )


def check_meshes(model: "Model") -> None:
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


def check_speed(bearing: Bearing, ideal: Kinematics) -> None:
    """Refuse speeds, (n,), whose centrifugal strain ρ v²/E leaves linear elasticity.

    v is the surface speed: of the inner raceway, of a roller about its own axis, of a turning outer ring's outside.
    """
    shaft, ring, roller = (float(np.abs(each).max()) for each in (ideal.shaft, ideal.outer_ring, ideal.roller))
    key, fastest = ("speed_rpm", shaft) if shaft >= ring else ("outer_ring_speed_rpm", ring)
    bodies = {
        "the inner ring": (bearing.inner_ring, shaft * bearing.inner_raceway_radius),
        "the outer ring": (bearing.outer_ring, ring * bearing.outside_radius),
        "the rollers": (bearing.roller, roller * bearing.roller_radius),
    }
    for name, (material, surface_speed) in bodies.items():
        strain = 0.0 if material.rigid else material.density * surface_speed**2 / material.youngs_modulus
        if strain > LARGEST_STRAIN:
            most = fastest * sqrt(LARGEST_STRAIN / strain) * 60.0 / (2.0 * pi)
            raise UsageError(
                f"operation.{key}: {name} would strain by {strain:.2g} under centrifugal load, beyond the "
                f"{LARGEST_STRAIN} of linear elasticity; at most {most:.6g} rpm"
            )


def check_widths(bearing: Bearing, force: float) -> None:
    """Refuse a force, N, that makes contacts too wide for Hertz's theory."""
    for pair in contact_pairs(bearing)[:2]:
        _check_width(pair, force, bearing)


def _check_width(pair: Pair, force: float, bearing: Bearing) -> None:
    half_width, widest = pair.half_width(force), WIDEST_CONTACT * bearing.roller_radius
    if half_width > widest:
        raise UsageError(
            f"the largest static force, {force:.4g} N on the {pair.kind} raceway, makes a contact of half-width "
            f"{1e3 * half_width:.3g} mm, beyond Hertz's theory (at most {1e3 * widest:.3g} mm here); lower "
            "operation.radial_load_N or operation.speed_rpm, or use a stiffer material"
        )


def check_contacts(model: "Model", equilibrium: "Equilibrium") -> None:
    """Refuse contacts too wide for Hertz's theory, or wider than a mesh this fine leaves to the sub-grid law."""
    for law, ring, forces in (
        (model.inner_law, model.inner_ring, equilibrium.inner_force),
        (model.outer_law, model.outer_ring, equilibrium.outer_force),
    ):
        pair, force = law.pair, float(forces.max())
        _check_width(pair, force, model.bearing)
        if force > law.Q_line:
            half_width, spacing = pair.half_width(force), 2.0 * pi * ring.raceway_radius / ring.n_sectors
            enough = 1.2e3 * spacing * half_width / pair.half_width(law.Q_line)
            raise UsageError(
                f"numerics.mesh_size_mm: the mesh is finer than the contact on the {pair.kind} raceway (half-width "
                f"{1e3 * half_width:.3g} mm), which the sub-grid law can't describe; at least {enough:.3g}"
            )

"""From a scene to its discrete model: which meshes, which contact patches."""

import numpy as np

from fem.elastic.model import Model, build_model, build_penalty_model, build_resolved_model, build_spread_model
from fem.elastic.resolved import resolved_laws
from fem.elastic.spread import ONE_PATCH
from fem.errors import UsageError
from fem.kernels.state import INNER, OUTER
from fem.solver.limits import WIDEST_CONTACT, check_width
from fem.statics.contact_balance import NotFound
from fem.statics.exact_statics import exact_statics
from lagrange import Bearing, Operation
from lagrange.scene import Scene
from meshes import bearing_shapes, graded_shapes

COARSEST = 0.6  # surface spacing over the half-width of a contact to be resolved
HOPELESS = 2.0  # a contact so many times too wide, by a force that may be a bound, is refused before it is meshed
MOST_NODES = 1_000_000  # take about 3 GB to mesh and assemble


def model_of(scene: Scene) -> Model:
    """The discrete model of a scene.

    Errors
    ------
    RuntimeError: gmsh is needed and missing. UsageError: balls, which no plane section describes; the mesh is too
    coarse to resolve the contacts or for a ring, or has too many nodes.
    """
    if scene.bearing.type == "ball":
        raise UsageError(
            'bearing.type = "ball": finite elements and pictures are of plane sections of cylindrical rollers; '
            "run-fem --model lagrange takes balls"
        )
    bearing, operation, mesh_size = scene.ideal_bearing(), scene.ideal_operation(), 1e-3 * scene.numerics.mesh_size_mm
    spreads = scene.contact.model == "subgrid" and _spreads(bearing, operation, mesh_size)
    check_mesh_size(bearing, mesh_size, graded=spreads or scene.contact.model == "resolved")
    if spreads:
        force = largest_force(bearing, operation)
        _check_points(scene, bearing, force, mesh_size)
        return build_spread_model(bearing, mesh_size, force)
    if scene.contact.model == "resolved":
        _check_resolution(half_widths(bearing, largest_force(bearing, operation)), mesh_size)
        return build_resolved_model(bearing, mesh_size)
    if scene.contact.penalty_stiffness_N_per_m is not None:
        faceted = scene.contact.model == "faceted"
        return build_penalty_model(bearing, mesh_size, scene.contact.penalty_stiffness_N_per_m, faceted)
    return build_model(bearing, mesh_size)


def _spreads(bearing: Bearing, operation: Operation, mesh_size: float) -> bool:
    """Whether a mesh is so fine that one patch, four spacings wide, would not be far wider than a contact."""
    if mesh_size > ONE_PATCH * max(half_widths(bearing, _bound(bearing, operation))):  # far above what a roller carries
        return False
    return mesh_size < ONE_PATCH * max(half_widths(bearing, largest_force(bearing, operation)))


def check_widths(bearing: Bearing, force: float) -> None:
    """Refuse a force, N, that makes contacts too wide for Hertz's theory."""
    for raceway, half_width in zip(("inner", "outer"), half_widths(bearing, force), strict=True):
        check_width(raceway, force, half_width, bearing)


def _check_points(scene: Scene, bearing: Bearing, force: float, mesh_size: float) -> None:
    """Refuse pressure points under a force, N, that makes contacts far too wide, and on rigid bodies."""
    widths = half_widths(bearing, force)
    if max(widths) > HOPELESS * WIDEST_CONTACT * bearing.roller_radius:
        check_widths(bearing, force)
    if scene.bodies.rigid:
        raise UsageError(
            f'bodies.{scene.bodies.rigid[0]} = "rigid": numerics.mesh_size_mm = {1e3 * mesh_size:g} is so fine that '
            f"contacts are spread over nodes, and a rigid body has none; at least {1e3 * ONE_PATCH * max(widths):.3g}, "
            'or every body "elastic"'
        )


def _check_resolution(widths: tuple[float, float], mesh_size: float) -> None:
    coarsest = COARSEST * min(widths)
    if mesh_size > coarsest:
        raise UsageError(
            f"contact.model = 'resolved': the narrowest of the most loaded contacts is {1e3 * min(widths):.3g} mm wide "
            f"on either side, the mesh {1e3 * mesh_size:.3g} mm; numerics.mesh_size_mm at most {1e3 * coarsest:.3g}, "
            "or take contact.model = 'subgrid'"
        )


def check_mesh_size(bearing: Bearing, mesh_size: float, graded: bool = False) -> None:
    """Refuse a mesh before anything is allocated for it. `mesh_size` in m.

    Errors
    ------
    UsageError: elements thicker than a ring, or too many nodes.
    """
    for name, thickness in (
        ("inner ring", bearing.inner_raceway_radius - bearing.bore_radius),
        ("outer ring", bearing.outside_radius - bearing.outer_raceway_radius),
    ):
        if mesh_size > thickness:
            raise UsageError(
                f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: the {name} is only {1e3 * thickness:.3g} mm thick; at "
                f"most {1e3 * thickness:.3g}"
            )
    shapes = graded_shapes(bearing, mesh_size) if graded else bearing_shapes(bearing, mesh_size)
    nodes = bearing.n_rollers * sum(row.nodes for row in shapes.roller.rows)
    nodes += sum(ring.sectors * len(ring.radii) for ring in (shapes.inner_ring, shapes.outer_ring))
    if nodes > MOST_NODES:
        raise UsageError(
            f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: makes {nodes:,} nodes, at most {MOST_NODES:,} are taken; at "
            f"least about {1e3 * mesh_size * (nodes / MOST_NODES) ** 0.5:.2g}"
        )


def half_widths(bearing: Bearing, force: float) -> tuple[float, float]:
    """Hertz half-widths, m, of the inner and of the outer contact under a force, N."""
    laws = resolved_laws(bearing, dict.fromkeys(("roller", "inner_ring", "outer_ring"), 1.0))
    return laws[INNER].half_width(force), laws[OUTER].half_width(force)


def largest_force(bearing: Bearing, operation: Operation) -> float:
    """Largest force of a contact, N, by exact statics; a bound where there is none."""
    centrifugal = _centrifugal(bearing, operation)
    try:
        found = exact_statics(bearing, _load(operation), operation.first_roller_angle)
    except NotFound:
        return _bound(bearing, operation)
    return float(np.concatenate([found.inner_force, found.outer_force]).max()) + centrifugal


def _load(operation: Operation) -> float:
    return operation.radial_load + operation.inner_mass * operation.gravity


def _centrifugal(bearing: Bearing, operation: Operation) -> float:
    cage = 0.5 * abs(operation.speed)  # or less
    return bearing.roller_mass * cage**2 * bearing.pitch_radius


def _bound(bearing: Bearing, operation: Operation) -> float:
    """Above any contact's force, N: all the load on one roller, and the preload of rigid rings."""
    preload = max(0.0, -bearing.radial_clearance)
    bodies = bearing.roller, bearing.inner_ring, bearing.outer_ring
    modulus = max(material.plane_strain_modulus for material in bodies if not material.rigid)
    return _load(operation) + _centrifugal(bearing, operation) + modulus * bearing.roller_length * preload

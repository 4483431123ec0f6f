"""Scenes of which each value is fine but a model can't bear them, and those of which a plan warns.

Refusals in the order in which a plan meets them: what is to be meshed, the contact model, meshes, speed, contacts at
rest. What is warned of is sound, but its numbers need care.
"""

from collections.abc import Callable
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fem.solver.guards import WIDEST_CONTACT
from lagrange import Bearing, Kinematics, Operation, contact_laws
from lagrange.bearing import CORE
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError, exceeds
from lagrange.kinematics import kinematics_met, roller_angles
from lagrange.rating.life import speed_warning
from lagrange.rating.sources import Unavailable
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene
from lagrange.scene.surfaces import SURFACES
from lagrange.step_size import wave_interval
from lagrange.surface.faults import Spall, thickness
from lagrange.surface.passages import interval_warning

if TYPE_CHECKING:
    from fem.contacts.model import Model
    from fem.statics.equilibrium import Equilibrium
    from fem.statics.exact_statics import ExpectedForces

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


def check_mesh_size(bearing: Bearing, mesh_size: float, shapes_of: Callable) -> None:
    """Refuse a mesh before anything is allocated for it. `mesh_size` in m; `shapes_of`: a contact model's.

    UsageError: elements thicker than a ring, or too many nodes.
    """
    for body, words in (("inner_ring", "inner ring"), ("outer_ring", "outer ring")):
        if exceeds(mesh_size, most := thickness(bearing, body)):
            raise UsageError(
                f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: the {words} is only {1e3 * most:.3g} mm thick; at most "
                f"{1e3 * most:.3g}"
            )
    nodes = mesh_nodes(bearing, mesh_size, shapes_of)
    if nodes > MOST_NODES:
        raise UsageError(
            f"numerics.mesh_size_mm = {1e3 * mesh_size:g}: makes {nodes:,} nodes, at most {MOST_NODES:,} are allowed; "
            f"at least about {1e3 * mesh_size * (nodes / MOST_NODES) ** 0.5:.2g}"
        )


def mesh_nodes(bearing: Bearing, mesh_size: float, shapes_of: Callable) -> int:
    """Of all bodies' meshes, before they are made; `mesh_size` in m."""
    shapes = shapes_of(bearing, mesh_size)
    rings = sum(ring.sectors * len(ring.radii) for ring in (shapes.inner_ring, shapes.outer_ring))
    return rings + bearing.n_rollers * sum(row.nodes for row in shapes.roller.rows)


def check_outer_ring(kind: "type[Model]", scene: Scene) -> None:
    """Refuse what contacts spread over points of a fine mesh do not know: outer rings not held all around, sections."""
    mounting, angle, why = scene.mounting(), scene.bearing.contact_angle_deg, None
    if angle > 0.0:
        given, why = f"bearing.contact_angle_deg = {angle:g}", ", on circles of bodies' curvature"
    elif mounting.points is not None or mounting.bore is not None:
        given = 'support.kind = "points"' if mounting.bore is None else "support.fit_clearance_um"
        why = ", which takes rings that are held all around"
    if why is not None and not kind.has_law:
        raise UsageError(
            f"{given}: numerics.mesh_size_mm = {scene.numerics.mesh_size_mm:g} is so fine that contacts are spread "
            f"over points{why}; use a coarser mesh"
        )


def check_contact_model(kind: "type[Model]", scene: Scene, expected: "ExpectedForces") -> None:
    """Refuse what a contact model is not made for, before it is built.

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
            f"which lie on perfect circles; at least {1e3 * kind.coarsest * max(widths):.3g}"
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
    from meshes import Mesh, quality  # which runs of rigid bodies do without

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


def check_widths(bearing: Bearing, force: float, outer_force: float | None = None) -> None:
    """Refuse forces, N, that make contacts too wide for Hertz's theory; of the outer raceway, None: the same."""
    widest = WIDEST_CONTACT * bearing.roller_radius
    forces = force, force if outer_force is None else outer_force
    for pair, pressed in zip(contact_pairs(bearing)[:2], forces, strict=True):
        if (half_width := pair.half_width(pressed)) > widest:
            raise UsageError(
                f"the largest static force, {pressed:.4g} N on the {pair.kind} raceway, makes a contact of half-width "
                f"{1e3 * half_width:.3g} mm, beyond Hertz's theory (at most {1e3 * widest:.3g} mm here); lower "
                "operation.radial_load_N or operation.speed_rpm, or use a stiffer material"
            )


def check_contacts(model: "Model", equilibrium: "Equilibrium") -> None:
    """Refuse contacts too wide for Hertz's theory, or wider than a mesh this fine leaves to the sub-grid law."""
    inner, outer = float(equilibrium.inner_force.max()), float(equilibrium.outer_force.max())
    check_widths(model.bearing, inner, outer)
    for law, ring, force in ((model.inner_law, model.inner_ring, inner), (model.outer_law, model.outer_ring, outer)):
        if force > law.Q_line:
            pair, spacing = law.pair, 2.0 * pi * ring.raceway_radius / ring.n_sectors
            half_width = pair.half_width(force)
            enough = 1.2e3 * spacing * half_width / pair.half_width(law.Q_line)
            raise UsageError(
                f"numerics.mesh_size_mm: the mesh is finer than the contact on the {pair.kind} raceway (half-width "
                f"{1e3 * half_width:.3g} mm), which the sub-grid law can't describe; at least {enough:.3g}"
            )


# Static load rating of roller bearings (ISO 76): at this Hertz pressure steel keeps a dent of 1e-4 of the diameter
ISO_76_PRESSURE = 4e9  # Pa
RIGID_CORE = (
    f"bearing.bore_diameter_mm = 0: the mesh has a rigid core in the solid shaft, {CORE:g} of its radius: the hub's "
    'displacement is off by up to 1 % and loads by up to 3 %; model = "reduced" has the whole shaft elastic'
)
WIDEST_CLEARANCE = 0.05  # of a roller's diameter: beyond C5 of ISO 5753-1, which is up to 0.04 (needles)
LIGHTEST = 1e-3  # of the static load rating: loads below are hardly meant, but for none at all
FEWEST_PASSAGES = 2.0  # of rollers, in a default duration
USUAL_TIME_US = 12.5  # of a contact's damping over its stiffness, as ROSS takes it; Krämer: 2.5 to 25 (docs/damping.md)


def plan_warnings(
    scene: Scene, model: "Model", operation: Operation, equilibrium: "Equilibrium", interval: float, start: str | None
) -> tuple[str, ...]:
    """Sentences; none where all is well. `interval` between samples, s; `start` : what a start is warned of."""
    found = (
        RIGID_CORE if scene.model == "fem" and model.bearing.bore_radius == 0.0 else None, _yield(model, equilibrium),
        _sampling(model.bearing, operation, equilibrium, interval), _edges(model, equilibrium))  # fmt: skip
    return tuple(filter(None, (*found, *of_scene(scene, model.bearing, operation, interval), start)))


def of_scene(scene: Scene, bearing: Bearing, operation: Operation, interval: float) -> tuple[str, ...]:
    """Sentences that follow from the scene alone, whatever the model."""
    found, longest = [interval_warning(bearing, operation, interval)], wave_interval(bearing, operation)
    if interval > longest:
        found.append(
            f"numerics.output_interval_us = {1e6 * interval:g}: too coarse to resolve a [[waviness]]; at most "
            f"{1e6 * longest:.3g}"
        )
    found.append(_undamped(scene, operation))
    duration = scene.numerics.duration_ms
    cage = float(np.abs(kinematics_met(bearing, operation).cage).max()) / (2.0 * pi)
    turns = cage * 1e-3 * duration
    short = bearing.n_rollers * turns < FEWEST_PASSAGES and not scene.is_given("numerics", "duration_ms")
    if cage > 0.0 and short:
        found.append(
            f"numerics.duration_ms = {duration:g} (default) is {turns:.2g} turns of the cage, too short for lines of "
            f"the cage; one turn takes {1e3 / cage:.3g} ms"
        )
    clearance, diameter = round(2.0 * bearing.radial_clearance, 9), 2.0 * bearing.element_radius
    if exceeds(clearance, WIDEST_CLEARANCE * diameter):
        found.append(
            f"the operating clearance, {1e6 * clearance:.4g} µm, is {100.0 * clearance / diameter:.2g} % of a roller's "
            "diameter; group C5 of ISO 5753-1 has at most 4 %; is bearing.clearance_um in µm?"
        )
    found += [_light(scene, bearing, operation), speed_warning(bearing, operation.fastest / RPM)]
    return tuple(filter(None, found))


def _light(scene, bearing, operation):
    acting = scene.operation
    if acting.radial_load_N == 0.0 or bearing.radial_clearance < 0.0 or operation.history is not None:
        return None
    try:
        rating = scene.ratings().static
    except Unavailable:
        return None
    if acting.radial_load_N + acting.inner_ring_and_shaft_kg * acting.gravity_m_s2 >= LIGHTEST * rating:
        return None
    return (
        f"operation.radial_load_N = {acting.radial_load_N:g} is below a thousandth of the static load rating, C0 = "
        f"{1e-3 * rating:.3g} kN: rollers hardly touch; is it in N?"
    )


def _undamped(scene, operation):
    """Vibration that is excited again and again, and that nothing but friction takes energy from."""
    housing, named = operation.mounting.housing, ["[[spall]]"] if scene.spall else []
    named += ["operation.load_table"] if scene.operation.load_table is not None else []
    named += ['support.kind = "housing"'] if housing is not None and housing.damping == 0.0 else []
    takes_none = (scene.model == "fem" and scene.contact.model != "subgrid") or scene.axial is not None
    if not named or scene.damping.acts or takes_none or scene.numerics.duration_ms == 0.0:
        return None
    return (
        f"{' and '.join(named)} without [damping]: excited vibration hardly decays; give damping.contact_time_us, e.g. "
        f"{USUAL_TIME_US:g}"
    )


def _yield(model, equilibrium):
    """The model is elastic at any pressure; steel is not."""
    pressed = (model.inner_law.pair, equilibrium.inner_force), (model.outer_law.pair, equilibrium.outer_force)
    worst, name, force = max((pair.peak_pressure(float(f.max())), pair.kind, f.max()) for pair, f in pressed)
    if worst <= ISO_76_PRESSURE:
        return None
    return (
        f"the largest static force, {force:.4g} N on the {name} raceway, gives a Hertz pressure of {1e-6 * worst:.0f} "
        f"MPa, above ISO 76's {1e-6 * ISO_76_PRESSURE:.0f} MPa; real steel would yield; lower operation.radial_load_N, "
        "or the preload (a larger bearing.outer_raceway_diameter_mm)"
    )


def _sampling(bearing, operation, equilibrium, interval):
    laws = contact_laws("johnson", bearing)
    pressed = (laws.inner, equilibrium.inner_force), (laws.outer, equilibrium.outer_force)
    inner, outer = (law.slope(law.approach(forces)) for law, forces in pressed)
    loaded = (inner > 0.0) & (outer > 0.0)
    in_series = np.where(loaded, inner * outer / np.where(loaded, inner + outer, 1.0), 0.0)
    angle = roller_angles(bearing, operation.first_roller_angle)
    resonance = sqrt(float(np.sum(in_series * np.sin(angle) ** 2)) / operation.inner_mass) / (2.0 * pi)
    if 2.0 * resonance * interval < 1.0:
        return None
    return (
        f"numerics.output_interval_us = {1e6 * interval:g}: too coarse for the hub's vibration on its contacts, about "
        f"{1e-3 * resonance:.3g} kHz; check-residual needs less than {0.5e6 / resonance:.3g}"
    )


def _edges(model, equilibrium):
    """An edge that carries a contact has a far higher pressure than the raceway; the model stays elastic."""
    inner, outer = float(equilibrium.inner_force.max()), float(equilibrium.outer_force.max())
    on_body = {"inner_ring": inner, "outer_ring": outer, "roller": max(inner, outer)}
    spalls = [fault for fault in model.bearing.faults if isinstance(fault, Spall) and on_body[fault.body] > 0.0]

    def pressure_on(spall):
        if spall.edge_radius == 0.0:
            return inf
        pair = model.inner_law.pair._replace(radii=(spall.edge_radius, model.bearing.roller_radius))
        return pair.peak_pressure(on_body[spall.body])

    worst = max(spalls, key=pressure_on, default=None)
    if worst is None or (pressure := pressure_on(worst)) <= ISO_76_PRESSURE:
        return None
    size = "an unlimited pressure" if pressure == inf else f"{1e-6 * pressure:.0f} MPa"
    return (
        f"[[spall]] edge_radius_mm = {1e3 * worst.edge_radius:g}: under the largest static force, "
        f"{on_body[worst.body]:.4g} N, the edge would carry {size}, above ISO 76's {1e-6 * ISO_76_PRESSURE:.0f} MPa; "
        "real steel would yield"
    )

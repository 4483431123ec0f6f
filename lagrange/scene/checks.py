"""What tables of a scene can't be together, with the bearing that they describe, or in a model.

Keys that do not go with others, as features that a model or a contact model can't have, are rows of `REFUSED`.
"""

# fmt: off
from collections.abc import Callable
from math import asin, degrees, pi
from typing import Any

import numpy as np

from lagrange.axial.slices import slices_over
from lagrange.bearing import room_between_rollers, stiffness_factor
from lagrange.contact.laws import OWN, law_names
from lagrange.errors import exceeds
from lagrange.load_history import TIME
from lagrange.scene import bearing as bearings
from lagrange.scene.faults import Rule, SceneError, Table
from lagrange.scene.run import OF_CONTACTS
from lagrange.scene.surfaces import SURFACES
from lagrange.surface.faults import Spall, own_radius, thickness

FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
LARGEST_FIT = 2e-3  # of a diameter: strains of a press fit, and slopes of a ring in play; steel yields there
WIDEST = 0.8  # half an opening over the radius of the roller, or of the body it is in
LARGEST_DEVIATION = 0.005  # of a roller's diameter, as much as its preload may be
STEEPEST_WAVE = 0.1  # curvature of a wave over that of the contact: circle and surface still touch in one place
NARROWEST = {"inner_ring": 1e-4, "outer_ring": 1e-4, "roller": 5e-4}  # of the circumference: profiles are tables
DEEPEST_PROFILE = 0.1  # from its highest to its lowest point, of the roller's radius: contacts then stay in one place
COARSEST_PROFILE = 0.1  # of the roller's radius, between two points
STEEPEST_PROFILE = 2.0  # between two points: no stylus follows more, and an edge would lie anywhere between them


def _mesh(scene):
    if scene.bearing.type == "ball":
        return
    size, roller, model = scene.numerics.mesh_size_mm, scene.bearing.roller_diameter_mm, scene.contact.model
    coarsest, finest = pi * roller / 10.0, roller / FINEST.get(model, FINEST_OTHERWISE)
    if size > coarsest:
        yield f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})"
    if exceeds(finest, size):
        yield (f"numerics.mesh_size_mm = {size} is finer than contact.model = '{model}' is made for (at least "
            f"{finest:.3g})")


def _fit(scene):
    """Sizes that don't go with the bearing's; interferences, cold and in operation, and clearances too far out."""
    fit, b = scene.fit, scene.bearing
    if fit is None:
        return
    bore, outside, faults = b.bore_diameter_mm, b.outside_diameter_mm, list[str]()
    if fit.shaft_bore_mm >= bore > 0.0:
        faults.append(f"shaft_bore_mm = {fit.shaft_bore_mm:g} must be below bearing.bore_diameter_mm = {bore:g}; 0: "
            "solid")
    if 0.0 < fit.housing_outside_diameter_mm <= outside:
        faults.append(f"housing_outside_diameter_mm = {fit.housing_outside_diameter_mm:g} must be above "
            f"bearing.outside_diameter_mm = {outside:g}; 0: so thick that it is stiff")
    sides = [(f"{name}_interference", size, 1e3 * LARGEST_FIT * size) for name, size in (
        ("shaft", bore), ("housing", outside))]
    for name, size, most in sides:
        if exceeds(abs(given := getattr(fit, f"{name}_um")), most) and most > 0.0:
            faults.append(f"{name}_um = {given:g}: more than {LARGEST_FIT:g} of the diameter, {size:g} mm; between "
                f"{-most:g} and {most:g}")
    yield from (f"fit.{fault}" for fault in faults)
    if faults or (found := scene.clearance_without_films()) is None:
        return
    for name, size, most in sides:
        if exceeds(pressed := 1e6 * getattr(found, name), most):
            yield (f"fit: {pressed:.4g} µm of interference in operation, more than {LARGEST_FIT:g} of the diameter, "
                f"{size:g} mm; check fit.{name}_um, temperatures and expansions")
    least, highest = -bearings.LARGEST_PRELOAD * b.roller_diameter_mm, bearings.LARGEST_CLEARANCE * b.roller_diameter_mm
    total = round(1e3 * found.total, bearings.ROUNDED)
    parts = ", ".join(f"{name} {value} µm" for name, value, _ in found.rows())
    if exceeds(least, total):
        yield (f"fit: more preload than the model bears (at least {1e3 * least:.4g} µm); less interference, or more "
            f"clearance: {parts}")
    elif exceeds(total, highest):
        yield f"fit: too large a clearance (at most {1e3 * highest:.4g} µm); check temperatures and clearance: {parts}"


def _tables(scene):
    duration, o = scene.numerics.duration_ms, scene.operation
    for name in o.FILES:
        if (found := o.read(name)) is not None and exceeds(duration, end := found[0][-1]):
            yield (f'operation.{name} = "{getattr(o, name)}": it ends at {TIME} = {end:g}, before the run '
                f"(numerics.duration_ms = {duration:g}); give more rows, or shorten the run")


def _axial(scene):
    """Rings narrower than rollers, profiles shorter than them."""
    table = scene.axial
    if table is None:
        return
    length = 1e3 * scene.perfect_bearing().roller_length
    if table.ring_width_mm is not None and exceeds(length, table.ring_width_mm):
        yield f"axial.ring_width_mm = {table.ring_width_mm:g} must be at least bearing.roller_length_mm = {length:g}"
    for name in table.FILES:
        if (points := table.read(name)) is not None:
            first, last = 1e3 * points.place[0], 1e3 * points.place[-1]
            reach = 0.5 * length * (1.0 - 1.0 / table.slices)
            if exceeds(reach, -first) or exceeds(reach, last):
                yield (f'axial.{name} = "{getattr(table, name)}": its z_mm go from {first:g} to {last:g}; slices of '
                    f"rollers of {length:g} mm have their middles from {-reach:g} to {reach:g}")


def _roller_faults(scene):
    """Rollers that there are none of, or that are given two sizes."""
    n_rollers = scene.bearing.rollers
    for name in SURFACES:
        for i, entry in enumerate(getattr(scene, name)):
            if entry.roller is not None and entry.roller >= n_rollers:
                yield (f"{name}.{i}.roller = {entry.roller}: there is none; bearing.rollers = {n_rollers} are counted "
                    f"from 0 to {n_rollers - 1}")
    sized = [entry.roller for entry in scene.unequal_roller]
    for number in sorted({number for number in sized if sized.count(number) > 1}):
        yield f"unequal_roller: roller = {number} is there {sized.count(number)} times; give it one deviation"


def _spall_faults(scene):
    """Spalls that the bodies have no room for, and those that overlap."""
    edges: list[tuple[int, Spall, float]] = []
    bearing = scene.perfect_bearing()
    for i, table in enumerate(scene.spall):
        spall, place = table.fault(), f"spall.{i}"
        own, opening = own_radius(bearing, spall), spall.half_opening(bearing.roller_radius)
        widest = WIDEST * min(own, bearing.roller_radius)
        if exceeds(opening, widest):
            yield (f"{place}.width_mm = {table.width_mm:g} with edge_radius_mm = {table.edge_radius_mm:g} is an "
                f"opening of {2e3 * opening:.4g} mm, too wide for rollers of {2e3 * bearing.roller_radius:g} mm (at "
                f"most {2e3 * widest:.4g})")
            continue
        narrowest, deepest = NARROWEST[spall.body] * 2.0 * pi * own, thickness(bearing, spall.body)
        if spall.width < narrowest:
            yield (f"{place}.width_mm = {table.width_mm:g} is too narrow for a surface of {2e3 * own:g} mm diameter "
                f"(at least {1e3 * narrowest:.3g})")
        if not exceeds(deepest, spall.depth):
            yield f"{place}.depth_um = {table.depth_um:g} goes through the body; below {1e6 * deepest:.4g}"
        half = asin(opening / own)
        for k, other, other_half in edges:
            apart = abs((spall.angle - other.angle + pi) % (2.0 * pi) - pi)
            if (other.body, other.roller) == (spall.body, spall.roller) and apart < half + other_half:
                yield (f"spall.{k} and {place} overlap: their middles are {degrees(apart):.3g} degrees apart on the "
                    f"same surface, at least {degrees(half + other_half):.3g}; make one spall of them")
        edges.append((i, spall, half))


def _part_faults(scene):
    """Spalls of part of the rollers' length that take no slice, or others than those that the same contacts meet."""
    met: dict[str, tuple[int, list[bool]]] = {}
    bearing, slices = scene.perfect_bearing(), 0 if scene.axial is None else scene.axial.slices
    for i, table in enumerate(scene.spall if slices else ()):
        if not (spall := table.fault()).is_part(bearing):
            continue
        over, place = slices_over(bearing, slices, spall).tolist(), f"spall.{i}.length_mm = {table.length_mm:g}"
        if all(over) or not any(over):
            yield (f"{place} at z_mm = {table.z_mm:g} goes over {'all' if all(over) else 'no'} middles of "
                f"axial.slices = {slices} slices of {1e3 * bearing.roller_length / slices:.3g} mm; " + ("leave "
                "length_mm out" if all(over) else "use more slices, or a longer spall within the rollers"))
            continue
        for raceway in ("inner_ring", "outer_ring") if table.body == "roller" else (table.body,):
            k, other = met.setdefault(raceway, (i, over))
            if over != other:
                yield (f"{place}, z_mm = {table.z_mm:g} takes other slices of contacts with the {raceway} than "
                    f"spall.{k}; give both the same length_mm and z_mm")


def _profile_faults(scene):
    """Two profiles of one surface, and those too high, too deep, too coarse or too steep for rollers to follow."""
    seen: dict[tuple[str, int | None], int] = {}
    bearing = scene.perfect_bearing()
    for i, table in enumerate(scene.profile):
        place, before = f'profile.{i}.file = "{table.file}"', seen.setdefault((table.body, table.roller), i)
        if before != i:
            yield f"profile.{before} and profile.{i} are of the same surface; make one table of them"
        heights = table.read("file")
        if heights is None:
            continue
        angle, height, own, roller = heights.angle, heights.height, own_radius(bearing, table), bearing.roller_radius
        highest, range_ = float(height.max()), float(np.ptp(height))
        if exceeds(highest, 2.0 * LARGEST_DEVIATION * roller):
            yield f"{place}: {1e6 * highest:.4g} µm is too high (at most {2e6 * LARGEST_DEVIATION * roller:.4g})"
        if exceeds(range_, DEEPEST_PROFILE * roller):
            yield (f"{place}: heights range over {1e6 * range_:.4g} µm, more than contacts follow (at most "
                f"{1e6 * DEEPEST_PROFILE * roller:.4g}); what lies too deep for a roller to reach may be cut off")
        steps = own * np.diff(np.append(angle, angle[0] + 2.0 * pi))
        rises = np.abs(np.diff(np.append(height, height[0])))
        if steps.max() > COARSEST_PROFILE * roller:
            yield (f"{place}: points {1e3 * steps.max():.3g} mm apart are too coarse (at most "
                f"{1e3 * COARSEST_PROFILE * roller:.3g} for rollers of {2e3 * roller:g} mm)")
        at = int((rises / steps).argmax())
        if rises[at] > STEEPEST_PROFILE * steps[at]:
            yield (f"{place}: after {degrees(angle[at]):.6g} degrees the height changes by {1e6 * rises[at]:.3g} µm on "
                f"{1e6 * steps[at]:.3g} µm, too steep (at most {STEEPEST_PROFILE:g} times it); give points nearer to "
                "each other")


def _size_faults(scene):
    """Waves too high or too short for contacts in one place, and rollers too large."""
    bearing = scene.perfect_bearing()
    largest = LARGEST_DEVIATION * 2.0 * bearing.roller_radius
    for i, table in enumerate(scene.waviness):
        wave, place = table.fault(), f"waviness.{i}.amplitude_um = {table.amplitude_um:g}"
        if exceeds(wave.amplitude, largest):
            yield f"{place} is too high (at most {1e6 * largest:.4g})"
        inside, outside = 1.0 / bearing.inner_raceway_radius, -1.0 / bearing.outer_raceway_radius
        curvature = 1.0 / bearing.roller_radius + (inside if wave.body == "inner_ring" else outside)
        highest = STEEPEST_WAVE * curvature * (own_radius(bearing, wave) / wave.order) ** 2
        if wave.amplitude > highest:
            yield (f"{place} of order = {wave.order}: its valleys are too narrow for the rollers to follow (at most "
                f"{1e6 * highest:.3g} at this order)")
    for i, other in enumerate(scene.unequal_roller):
        if exceeds(abs(other.fault().diameter_deviation), largest):
            yield (f"unequal_roller.{i}.diameter_deviation_um = {other.diameter_deviation_um:g} is too large (at most "
                f"{1e6 * largest:.4g} either way)")


def _bore(scene):
    clearance = None if scene.support is None else scene.support.fit_clearance_um
    return None if clearance is None else f"support.fit_clearance_um = {clearance:g}"


def _turns(scene):
    return (name := scene.operation.turns_outer_ring) and f"operation.{name}"


def _stated(table, name, before=""):
    """A dotted key, or "key=value", as a scene writes it; None: it has none, its default, 0, or another value."""
    name, _, inner = name.partition(".")
    name, _, wanted = name.partition("=")
    value, place = getattr(table, name), f"{before}{name}"
    if isinstance(value, list) and inner:
        return next(filter(None, (_stated(each, inner, f"{place}.{i}.") for i, each in enumerate(value))), None)
    if inner:
        return None if value is None else _stated(value, inner, f"{place}.")
    text = f'"{value}"' if isinstance(value, str) else f"{value:g}" if isinstance(value, float) else value
    if wanted:
        return f"{place} = {text}" if wanted == str(text).strip('"') else None
    if not value or value == type(table).model_fields[name].default:
        return None
    return f"[[{place}]]" if isinstance(value, list) else f"[{place}]" if isinstance(value, Table) else (
        f"{place} = {text}")


def _has(scene, what):
    """How the scene writes the first of what it has of keys joined by "or", which binds more than "and"."""
    if callable(what):
        return what(scene)
    parts = [next(filter(None, (not _stated(scene, name[4:]) if name.startswith("not ") else _stated(scene, name)
        for name in part.split(" or "))), None) for part in what.split(" and ")]
    return parts[0] if all(parts) else None


Condition = str | Callable[[Any], Any]
MESH, POINTS, SPEED = "model=fem", "support.kind=points", "operation.outer_ring_speed_table or operation.speed_table"
OTHER, OTHER_ON_MESHES = "contact.model", f"contact.model and {MESH}"  # than "subgrid"
RIGID = "bodies.rollers=rigid or bodies.inner_ring=rigid or bodies.outer_ring=rigid"
DAMPED = " or ".join(f"damping.{name}" for name in OF_CONTACTS)
IN_HOUSING = " or ".join(f"fit.{name}" for name in bearings.FitTable.model_fields if name.startswith("housing_"))
OF_ROLLERS = " or ".join(f"{name}.body=roller" for name in SURFACES if name != "unequal_roller")
NOT_ROUND = " or ".join((*SURFACES, "lubricant"))
ANGLE, SOLID, MISSING = "bearing.contact_angle_deg", "bearing.bore_diameter_mm=0", "bearing.missing_rollers"
CYLINDERS = f"bearing.type=roller and not {ANGLE}"
BALLS, GUIDE, PART = "bearing.type=ball", "cage.guidance=outer_ring", "spall.length_mm"
EITHER = "; leave one of them out"
SUBGRID = '{0}: only with contact.model = "subgrid", not with "{t.contact.model}"'
COMPARES = f"{SUBGRID}, which is there to compare contacts{EITHER}"
FEM = '{0}: only with model = "fem", not with "{t.model}", whose outer ring'
RADIAL = f"{{0}}: only for rings whose contacts are radial, not with bearing.contact_angle_deg{EITHER}"
REFUSED: tuple[tuple[Condition, Condition, str], ...] = (
    (GUIDE, _bore, "{0}: not with {1}, in which that ring moves; choose another guidance"),
    (GUIDE, _turns, "{0}: not with {1}, of a guide that turns; choose another guidance"),
    ("operation.misalignment_mrad", f"not axial and {CYLINDERS}", "{0}: needs an [axial] table (an empty one is "
        "enough)"),
    ("operation.axial_load_N", lambda s: _has(s, f"not bearing.flange_height_mm and {CYLINDERS}") and (
        s.bearing.designation or "the bearing"), "{0}: {1} has no flanges on both rings and carries none: give an NJ "
        "or NUP, or bearing.flange_height_mm"),
    ("lubricant", SPEED, f"{{0}}: only at a steady speed, not with {{1}}: its film is as thick as at "
        f"one speed{EITHER}"),
    ("output.fields_every_ms", f"not {MESH}", "{0}: model = '{t.model}' has no mesh and no fields; leave it out or 0"),
    (RIGID, OTHER, f"{SUBGRID}, whose points of pressure sit on meshes"),
    (POINTS, f"not {MESH}", f'{FEM} does not bend as a whole; use kind = "housing", or leave one of them out'),
    (POINTS, "bodies.outer_ring=rigid", f"{{0}}: a rigid outer ring is held as well by any{EITHER}"),
    (POINTS, OTHER, f"{SUBGRID}{EITHER}"),
    ("operation.shaft=springs", OTHER_ON_MESHES, COMPARES),
    ("sensor", "not support.kind=housing",
     '{0}: stands on a housing that moves; add [support] with kind = "housing", or leave the sensor out'),
    (_bore, f"not {MESH}", f"{FEM} is held without play; leave it out"),
    (_bore, "bodies.outer_ring=rigid", f'{{0}}: only for an elastic outer ring, bodies.outer_ring is "rigid"{EITHER}'),
    (_bore, OTHER, f"{SUBGRID}{EITHER}"),
    ("damping.bodies_1_s", f"not {MESH}",
     "{0}: only for bodies with meshes, which model = '{t.model}' has none of; leave it out, or use model = 'fem'"),
    (DAMPED, OTHER_ON_MESHES, f"{SUBGRID}, whose points of pressure stand for part of a contact{EITHER}"),
    (IN_HOUSING, lambda s: _bore(s) or _has(s, POINTS),
     f"{{0}}: not with the [support] of an outer ring that its housing does not hold all around{EITHER}"),
    (lambda s: (name := s.operation.changes) and f"operation.{name}", OTHER_ON_MESHES, COMPARES),
    ("lubricant", BALLS, '{0}: films are those of line contacts, not with bearing.type = "ball"; leave it out'),
    (OF_ROLLERS, ANGLE,
     "{0}: a section's rollers turn faster than those of a bearing with contact_angle_deg; leave one of them out"),
    (POINTS, ANGLE, RADIAL), (_bore, ANGLE, RADIAL), ("fit", ANGLE, RADIAL),
    (OF_ROLLERS, MISSING, f"{{0}}: not together with bearing.missing_rollers{EITHER}"),
    ("unequal_roller", MISSING, f"{{0}}: not together with bearing.missing_rollers{EITHER}"),
    ("fit", SOLID, f"{{0}}: of a ring on a shaft; bearing.bore_diameter_mm = 0 is a solid one{EITHER}"),
    (SOLID, OTHER_ON_MESHES, f"{SUBGRID}, whose ring is held at its bore{EITHER}"),
    (ANGLE, OTHER_ON_MESHES, f"{SUBGRID}, whose circles are as curved as bodies{EITHER}"),
    ("axial", OTHER_ON_MESHES, f"{SUBGRID}, whose law is that of slices{EITHER}"),
    (RIGID, f"axial and {MESH}", f"{{0}}: not together with [axial], whose slices are those of elastic bodies{EITHER}"),
    (PART, "not axial", "{0}: needs an [axial] table (an empty one is enough); or leave length_mm out"),
    ("bearing.rows", "axial", f"{{0}}: not together with [axial], whose slope loads rows unequally{EITHER}"),
    (DAMPED, f"axial and {MESH}",
     '{0}: not together with [axial] on meshes; use model = "reduced", or leave one of them out'),
    ("axial", BALLS, '{0}: only for rollers, not with bearing.type = "ball"; leave it out'),
    ("axial", ANGLE, "{0}: of rollers whose axis is the shaft's, not with contact_angle_deg; leave one of them out"),
    (_turns, "support.kind", '{0}: only with support.kind = "held", not with "{t.support.kind}": '
        f"whatever turns with the outer ring holds it all around{EITHER}"),
    (_turns, "fit", f"{{0}}: not with [fit], whose housing stands still; give the operating clearance{EITHER}"),
    (NOT_ROUND, OTHER_ON_MESHES, f"{SUBGRID}, whose points of pressure lie on perfect circles{EITHER}"))


AT_REST = "operation.axial_load_N or operation.moment_N_m or bearing.arrangement", (
    "operation.misalignment_mrad and not axial")


def check_motion(scene: Any) -> None:
    """SceneError: of a scene with what models in motion lack."""
    for what in AT_REST:
        if (given := _has(scene, what)) is not None:
            raise SceneError(f"{given}: at rest and in ratings only (rate-bearing); motion keeps its plane: leave it "
                "out")


COMBINATIONS: tuple[Rule, ...] = (
    (lambda s: s.lagrange.law not in (*(known := law_names(s.perfect_bearing())), OWN) and ", ".join(known),
     "lagrange.law = {t.lagrange.law!r}: unknown for bearing.type = {t.bearing.type!r}; known are {0}"),
    (lambda s: (ring := (b := s.perfect_bearing()).inner_ring_mass * stiffness_factor(b)) >= (  # of the section's hub
        s.operation.inner_ring_and_shaft_kg) and ring, "operation.inner_ring_and_shaft_kg = "
        "{t.operation.inner_ring_and_shaft_kg} must exceed the mass of the elastic inner ring, {0:.4g} kg"),
    _mesh,
    *(((lambda s, ours=ours, other=other: (given := _has(s, ours)) and (what := _has(s, other)) and (given, what)),
        sentence) for ours, other, sentence in REFUSED),
    (lambda s: 0.0 < s.output.fields_every_ms and exceeds(least := 1e-3 * s.numerics.output_interval_us,
        s.output.fields_every_ms) and least, "output.fields_every_ms = {t.output.fields_every_ms} must not be below "
        "numerics.output_interval_us = {t.numerics.output_interval_us} ({0:g} ms); 0 stores none"),
    (lambda s: _bore(s) and exceeds(abs(s.support.fit_clearance_um), most := 1e3 * LARGEST_FIT * (
        s.bearing.outside_diameter_mm)) and (_bore(s), -most, most),
        f"{{0}}: more than {LARGEST_FIT:g} of the outer ring's outside diameter, {{t.bearing.outside_diameter_mm:g}} "
        "mm; between {1:g} and {2:g}"),
    _fit,
    (lambda s: s.cage and s.cage.pocket_clearance_mm and not exceeds(room := 1e3 * room_between_rollers(
        s.perfect_bearing()), s.cage.pocket_clearance_mm) and room, "cage.pocket_clearance_mm = "
        "{t.cage.pocket_clearance_mm:g}: neighbouring rollers are {0:.4g} mm apart, and a bar of the cage has to stand "
        "between them; reduce it, or use fewer rollers"),
    _tables, _roller_faults, _spall_faults, _size_faults, _profile_faults, _axial, _part_faults)

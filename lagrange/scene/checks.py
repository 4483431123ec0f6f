"""What tables of a scene can't be together, with the bearing that they describe, or in a model.

Features that models and contact models can't have follow from one table of features and kinds of scene: a new
feature is a line of `GIVEN`, a new kind of scene one of `KINDS`, a pair that does not go one of `REFUSED`.
"""

# fmt: off
from collections.abc import Iterator
from math import pi
from typing import TYPE_CHECKING

from lagrange.bearing import room_between_rollers, stiffness_factor
from lagrange.contact.laws import OWN, law_names
from lagrange.errors import exceeds
from lagrange.load_history import TIME
from lagrange.scene import bearing as bearings
from lagrange.scene import surfaces
from lagrange.scene.faults import Rule
from lagrange.scene.run import FIRST_SPEEDS

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
LARGEST_FIT = 2e-3  # of a diameter: strains of a press fit, and slopes of a ring in play; steel yields there


def _mesh(scene: "Scene") -> Iterator[str]:
    if scene.bearing.type == "ball":
        return
    size, roller, model = scene.numerics.mesh_size_mm, scene.bearing.roller_diameter_mm, scene.contact.model
    coarsest, finest = pi * roller / 10.0, roller / FINEST.get(model, FINEST_OTHERWISE)
    if size > coarsest:
        yield f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})"
    if exceeds(finest, size):
        yield (f"numerics.mesh_size_mm = {size} is finer than contact.model = '{model}' is made for (at least "
            f"{finest:.3g})")


def _fit(scene: "Scene") -> Iterator[str]:
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


def _tables(scene: "Scene") -> Iterator[str]:
    duration, o = scene.numerics.duration_ms, scene.operation
    for name in o.FILES:
        if (found := o.read(name)) is not None and exceeds(duration, end := found[0][-1]):
            yield (f'operation.{name} = "{getattr(o, name)}": it ends at {TIME} = {end:g}, before the run '
                f"(numerics.duration_ms = {duration:g}); give more rows, or shorten the run")


def _axial(scene: "Scene") -> Iterator[str]:
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


def _bore(scene: "Scene") -> str | None:
    clearance = None if scene.support is None else scene.support.fit_clearance_um
    return None if clearance is None else f"support.fit_clearance_um = {clearance:g}"


def _of_rollers(scene: "Scene") -> str | None:
    found = (f'{name}.{i}.body = "roller"' for name in surfaces.SURFACES for i, table in enumerate(getattr(scene, name))
             if getattr(table, "body", None) == "roller")
    return next(found, None)


def _speed_table(scene: "Scene") -> str | None:
    o = scene.operation
    return next((f'operation.{name} = "{table}"' for name in FIRST_SPEEDS if (table := getattr(o, name))), None)


# how a scene writes what it has, {0} of a sentence; nothing where it lacks it
GIVEN = {"fields": lambda s: (t := s.output.fields_every_ms) > 0.0 and f"output.fields_every_ms = {t}",
    "rigid body": lambda s: s.bodies.rigid and f'bodies.{s.bodies.rigid[0]} = "rigid"',
    "points": lambda s: s.support and s.support.kind == "points" and 'support.kind = "points"',
    "shaft": lambda s: s.operation.shaft == "springs" and 'operation.shaft = "springs"',
    "sensor": lambda s: s.sensor and "[sensor]", "bore": _bore,
    "guide": lambda s: s.cage and s.cage.guidance == "outer_ring" and 'cage.guidance = "outer_ring"',
    "slope": lambda s: (tilt := s.operation.misalignment_mrad) and f"operation.misalignment_mrad = {tilt:g}",
    "bodies' damping": lambda s: (rate := s.damping.bodies_1_s) > 0.0 and f"damping.bodies_1_s = {rate:g}",
    "contacts' damping": lambda s: s.damping.contacts.acts and "[damping] of contacts",
    "load history": lambda s: (name := s.operation.changes) and f"operation.{name}",
    "fit in the housing": lambda s: s.fit and s.fit.of_housing, "fit": lambda s: s.fit and "[fit]",
    "solid shaft": lambda s: s.bearing.bore_diameter_mm == 0.0 and "bearing.bore_diameter_mm = 0",
    "surfaces": lambda s: next((f"[[{name}]]" for name in surfaces.SURFACES if getattr(s, name)), s.lubricant and
    "[lubricant]"), "part of the length": lambda s: next((f"spall.{i}.length_mm = {spall.length_mm:g}" for i, spall in
    enumerate(s.spall) if spall.length_mm is not None), None), "lubricant": lambda s: s.lubricant and "[lubricant]",
    "rollers' surfaces": _of_rollers, "unequal rollers": lambda s: s.unequal_roller and "[[unequal_roller]]",
    "contact angle": lambda s: (a := s.bearing.contact_angle_deg) > 0.0 and f"bearing.contact_angle_deg = {a:g}",
    "axial": lambda s: s.axial and "[axial]", "rows": lambda s: s.bearing.rows > 1 and
    f"bearing.rows = {s.bearing.rows}", "outer ring's speed": lambda s: (name := s.operation.turns_outer_ring) and
    f"operation.{name}"}
# what scenes are that keeps them from a feature, {1} of a sentence
KINDS = {"no mesh": lambda s: s.model != "fem", "other contacts": lambda s: s.contact.model != "subgrid",
    "other contacts on meshes": lambda s: s.model == "fem" and s.contact.model != "subgrid",
    "rigid outer ring": lambda s: s.bodies.outer_ring == "rigid",
    "outer ring moves": lambda s: _bore(s) or (s.support and s.support.kind == "points"),
    "balls": lambda s: s.bearing.type == "ball", "contact angle": lambda s: s.bearing.contact_angle_deg > 0.0,
    "solid shaft": lambda s: s.bearing.bore_diameter_mm == 0.0, "missing rollers": lambda s: s.bearing.missing_rollers,
    "axial": lambda s: s.axial is not None, "no axial": lambda s: s.axial is None,
    "axial on meshes": lambda s: s.axial is not None and s.model == "fem", "fitted": lambda s: s.fit is not None,
    "no housing": lambda s: s.support is None or s.support.kind != "housing", "bore": _bore,
    "turning ring": lambda s: s.operation.turns_outer_ring, "changing speed": _speed_table,
    "mounted": lambda s: s.support is not None and s.support.kind != "held"}
EITHER = "; leave one of them out"
SUBGRID = '{0}: only with contact.model = "subgrid", not with "{t.contact.model}"'
COMPARES = f"{SUBGRID}, which is there to compare contacts{EITHER}"
FEM = '{0}: only with model = "fem", not with "{t.model}", whose outer ring'
RADIAL = f"{{0}}: only for rings whose contacts are radial, not with bearing.contact_angle_deg{EITHER}"
REFUSED = (
    ("guide", "bore", "{0}: not with {1}, in which that ring moves; choose another guidance"),
    ("guide", "turning ring", "{0}: not with operation.{1}, of a guide that turns; choose another guidance"),
    ("slope", "no axial", "{0}: needs an [axial] table (an empty one is enough)"),
    ("lubricant", "changing speed", f"{{0}}: only at a steady speed, not with {{1}}: its film is as thick as at "
        f"one speed{EITHER}"),
    ("fields", "no mesh", "{0}: model = '{t.model}' has no mesh and no fields; leave it out or 0"),
    ("rigid body", "other contacts", f"{SUBGRID}, whose points of pressure sit on meshes"),
    ("points", "no mesh", f'{FEM} does not bend as a whole; use kind = "housing", or leave one of them out'),
    ("points", "rigid outer ring", f"{{0}}: a rigid outer ring is held as well by any{EITHER}"),
    ("points", "other contacts", f"{SUBGRID}{EITHER}"),
    ("shaft", "other contacts on meshes", COMPARES),
    ("sensor", "no housing",
     '{0}: stands on a housing that moves; add [support] with kind = "housing", or leave the sensor out'),
    ("bore", "no mesh", f"{FEM} is held without play; leave it out"),
    ("bore", "rigid outer ring", f'{{0}}: only for an elastic outer ring, bodies.outer_ring is "rigid"{EITHER}'),
    ("bore", "other contacts", f"{SUBGRID}{EITHER}"),
    ("bodies' damping", "no mesh",
     "{0}: only for bodies with meshes, which model = '{t.model}' has none of; leave it out, or use model = 'fem'"),
    ("contacts' damping", "other contacts on meshes",
     f"{SUBGRID}, whose points of pressure stand for part of a contact{EITHER}"),
    ("fit in the housing", "outer ring moves",
     f"{{0}}: not with the [support] of an outer ring that its housing does not hold all around{EITHER}"),
    ("load history", "other contacts on meshes", COMPARES),
    ("lubricant", "balls", '{0}: films are those of line contacts, not with bearing.type = "ball"; leave it out'),
    ("rollers' surfaces", "contact angle",
     "{0}: a section's rollers turn faster than those of a bearing with contact_angle_deg; leave one of them out"),
    ("points", "contact angle", RADIAL),
    ("bore", "contact angle", RADIAL),
    ("fit", "contact angle", RADIAL),
    ("rollers' surfaces", "missing rollers", f"{{0}}: not together with bearing.missing_rollers{EITHER}"),
    ("unequal rollers", "missing rollers", f"{{0}}: not together with bearing.missing_rollers{EITHER}"),
    ("fit", "solid shaft", f"{{0}}: of a ring on a shaft; bearing.bore_diameter_mm = 0 is a solid one{EITHER}"),
    ("solid shaft", "other contacts on meshes", f"{SUBGRID}, whose ring is held at its bore{EITHER}"),
    ("contact angle", "other contacts on meshes", f"{SUBGRID}, whose circles are as curved as bodies{EITHER}"),
    ("axial", "other contacts on meshes", f"{SUBGRID}, whose law is that of slices{EITHER}"),
    ("rigid body", "axial on meshes",
     f"{{0}}: not together with [axial], whose slices are those of elastic bodies{EITHER}"),
    ("part of the length", "no axial",
     "{0}: needs an [axial] table (an empty one is enough); or leave length_mm out"),
    ("rows", "axial", f"{{0}}: not together with [axial], whose slope loads rows unequally{EITHER}"),
    ("contacts' damping", "axial on meshes",
     '{0}: not together with [axial] on meshes; use model = "reduced", or leave one of them out'),
    ("axial", "balls", '{0}: only for rollers, not with bearing.type = "ball"; leave it out'),
    ("axial", "contact angle",
     "{0}: of rollers whose axis is the shaft's, not with contact_angle_deg; leave one of them out"),
    ("outer ring's speed", "mounted", '{0}: only with support.kind = "held", not with "{t.support.kind}": '
        f"whatever turns with the outer ring holds it all around{EITHER}"),
    ("outer ring's speed", "fitted",
     f"{{0}}: not with [fit], whose housing stands still; give the operating clearance{EITHER}"),
    ("surfaces", "other contacts on meshes", f"{SUBGRID}, whose points of pressure lie on perfect circles{EITHER}"),
)


COMBINATIONS: tuple[Rule, ...] = (
    (lambda s: s.lagrange.law not in (*(known := law_names(s.perfect_bearing())), OWN) and ", ".join(known),
     "lagrange.law = {t.lagrange.law!r}: unknown for bearing.type = {t.bearing.type!r}; known are {0}"),
    (lambda s: (ring := (b := s.perfect_bearing()).inner_ring_mass * stiffness_factor(b)) >= (  # of the section's hub
        s.operation.inner_ring_and_shaft_kg) and ring, "operation.inner_ring_and_shaft_kg = "
        "{t.operation.inner_ring_and_shaft_kg} must exceed the mass of the elastic inner ring, {0:.4g} kg"),
    _mesh,
    *(((lambda s, feature=feature, kind=kind: (given := GIVEN[feature](s)) and (what := KINDS[kind](s)) and (
        given, what)), sentence) for feature, kind, sentence in REFUSED),
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
    _tables, surfaces.roller_faults, surfaces.spall_faults, surfaces.size_faults, surfaces.profile_faults, _axial,
    surfaces.part_faults,
)

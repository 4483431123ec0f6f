"""What tables of a scene can't be together, with the bearing that they describe, or in a model.

Features that models and contact models can't have follow from one table of features and kinds of scene: a new
feature is a line of `GIVEN`, a new kind of scene one of `KINDS`, a pair that does not go one of `REFUSED`.
"""

# fmt: off
from collections.abc import Iterator
from math import pi
from typing import TYPE_CHECKING

from lagrange.bearing import room_between_rollers
from lagrange.contact.laws import OWN, law_names
from lagrange.errors import exceeds
from lagrange.scene import bearing as bearings
from lagrange.scene import surfaces
from lagrange.scene.run import FIRST_SPEEDS
from lagrange.section import stiffness_factor

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
LARGEST_FIT = 2e-3  # of a diameter: strains of a press fit, and slopes of a ring in play; steel yields at about that


def _law(scene: "Scene") -> Iterator[str]:
    known = law_names(scene.perfect_bearing())
    if scene.lagrange.law not in (*known, OWN):
        yield (f"lagrange.law = {scene.lagrange.law!r}: unknown for bearing.type = {scene.bearing.type!r}; known are "
            f"{', '.join(known)}")


def _mass(scene: "Scene") -> Iterator[str]:
    bearing, given = scene.perfect_bearing(), scene.operation.inner_ring_and_shaft_kg
    ring = bearing.inner_ring_mass * stiffness_factor(bearing)  # as much as the section's is of the section's hub
    if given <= ring:
        name = "operation.inner_ring_and_shaft_kg"
        yield f"{name} = {given} must exceed the mass of the elastic inner ring, {ring:.4g} kg"


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


def _fields(scene: "Scene") -> Iterator[str]:
    every, sampled = scene.output.fields_every_ms, scene.numerics.output_interval_us
    if every > 0.0 and exceeds(1e-3 * sampled, every):
        yield (f"output.fields_every_ms = {every} must not be below numerics.output_interval_us = {sampled} "
            f"({1e-3 * sampled:g} ms); 0 stores none")


def _bore(scene: "Scene") -> Iterator[str]:
    bore, given, diameter = scene.mounting().bore, bore_given(scene), scene.bearing.outside_diameter_mm
    most = 1e3 * LARGEST_FIT * diameter  # µm
    if bore is not None and exceeds(abs(bore.clearance), 1e-6 * most):
        yield (f"{given}: more than {LARGEST_FIT:g} of the outer ring's outside diameter, {diameter:g} mm; between "
            f"{-most:g} and {most:g}")


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


def _cage(scene: "Scene") -> Iterator[str]:
    if scene.cage is None:
        return
    if scene.cage.guidance == "outer_ring":
        guided = 'cage.guidance = "outer_ring": not with '
        if scene.mounting().bore is not None:
            yield f"{guided}{bore_given(scene)}, in which that ring moves; choose another guidance"
        if turning := scene.operation.turns_outer_ring:
            yield f"{guided}operation.{turning}, of a guide that turns; choose another guidance"
    room, given = room_between_rollers(scene.perfect_bearing()), scene.cage.pocket_clearance_mm
    if given is not None and not exceeds(room, 1e-3 * given):
        yield (f"cage.pocket_clearance_mm = {given:g}: neighbouring rollers are {1e3 * room:.4g} mm apart, and a bar "
            "of the cage has to stand between them; reduce it, or use fewer rollers")


def _courses(scene: "Scene") -> Iterator[str]:
    yield from scene.operation.duration_faults(scene.numerics.duration_ms)
    for name in FIRST_SPEEDS if scene.lubricant is not None else ():
        if (table := getattr(scene.operation, name)) is not None:
            yield (f'[lubricant]: only at a steady speed, not with operation.{name} = "{table}": its film is as thick '
                "as at one speed; leave one of them out")


def _axial(scene: "Scene") -> Iterator[str]:
    """Rings narrower than rollers, profiles shorter than them; a slope without slices."""
    table, tilt = scene.axial, scene.operation.misalignment_mrad
    if table is None:
        if tilt:
            yield f"operation.misalignment_mrad = {tilt:g}: needs an [axial] table (an empty one is enough)"
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


def bore_given(scene: "Scene") -> str | None:
    """A ring's fit as the scene writes it."""
    bore = scene.mounting().bore
    return None if bore is None else f"support.fit_clearance_um = {1e6 * bore.clearance:g}"


def _of_rollers(scene: "Scene") -> str | None:
    """A roller's surface, but for its size."""
    found = (f'{name}.{i}.body = "roller"' for name in surfaces.SURFACES for i, table in enumerate(getattr(scene, name))
             if getattr(table, "body", None) == "roller")
    return next(found, None)


# how a scene writes what it has; nothing where it lacks it
GIVEN = {"fields": lambda s: (t := s.output.fields_every_ms) > 0.0 and f"output.fields_every_ms = {t}",
    "rigid body": lambda s: s.bodies.rigid and f'bodies.{s.bodies.rigid[0]} = "rigid"',
    "points": lambda s: s.mounting().points and 'support.kind = "points"', "shaft": lambda s: s.mounting().shaft and
    'operation.shaft = "springs"', "sensor": lambda s: s.sensor and "[sensor]", "bore": bore_given,
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
# what scenes are, by what keeps them from a feature
KINDS = {"no mesh": lambda s: s.model != "fem", "other contacts": lambda s: s.contact.model != "subgrid",
    "other contacts on meshes": lambda s: s.model == "fem" and s.contact.model != "subgrid",
    "rigid outer ring": lambda s: s.bodies.outer_ring == "rigid",
    "outer ring moves": lambda s: s.mounting().bore is not None or s.mounting().points is not None,
    "balls": lambda s: s.bearing.type == "ball", "contact angle": lambda s: s.bearing.contact_angle_deg > 0.0,
    "solid shaft": lambda s: s.bearing.bore_diameter_mm == 0.0, "missing rollers": lambda s: s.bearing.missing_rollers,
    "axial": lambda s: s.axial is not None, "no axial": lambda s: s.axial is None,
    "axial on meshes": lambda s: s.axial is not None and s.model == "fem", "fitted": lambda s: s.fit is not None,
    "no housing": lambda s: s.mounting().housing is None,
    "mounted": lambda s: s.support is not None and s.support.kind != "held"}
EITHER = "; leave one of them out"
SUBGRID = '{given}: only with contact.model = "subgrid", not with "{contact}"'
COMPARES = f"{SUBGRID}, which is there to compare contacts{EITHER}"
FEM = '{given}: only with model = "fem", not with "{model}", whose outer ring'
AXIAL_MESH = '{given}: not together with [axial] on meshes; use model = "reduced", or leave one of them out'
RADIAL = f"{{given}}: only for rings whose contacts are radial, not with bearing.contact_angle_deg{EITHER}"
REFUSED = (
    ("fields", "no mesh", "{given}: model = '{model}' has no mesh and no fields; leave it out or 0"),
    ("rigid body", "other contacts", f"{SUBGRID}, whose points of pressure sit on meshes"),
    ("points", "no mesh", f'{FEM} does not bend as a whole; use kind = "housing", or leave one of them out'),
    ("points", "rigid outer ring", f"{{given}}: a rigid outer ring is held as well by any{EITHER}"),
    ("points", "other contacts", f"{SUBGRID}{EITHER}"),
    ("shaft", "other contacts on meshes", COMPARES),
    ("sensor", "no housing",
     '{given}: stands on a housing that moves; add [support] with kind = "housing", or leave the sensor out'),
    ("bore", "no mesh", f"{FEM} is held without play; leave it out"),
    ("bore", "rigid outer ring", f'{{given}}: only for an elastic outer ring, bodies.outer_ring is "rigid"{EITHER}'),
    ("bore", "other contacts", f"{SUBGRID}{EITHER}"),
    ("bodies' damping", "no mesh",
     "{given}: only for bodies with meshes, which model = '{model}' has none of; leave it out, or use model = 'fem'"),
    ("contacts' damping", "other contacts on meshes",
     f"{SUBGRID}, whose points of pressure stand for part of a contact{EITHER}"),
    ("fit in the housing", "outer ring moves",
     f"{{given}}: not with the [support] of an outer ring that its housing does not hold all around{EITHER}"),
    ("load history", "other contacts on meshes", COMPARES),
    ("lubricant", "balls", '{given}: films are those of line contacts, not with bearing.type = "ball"; leave it out'),
    ("rollers' surfaces", "contact angle",
     "{given}: a section's rollers turn faster than those of a bearing with contact_angle_deg; leave one of them out"),
    ("points", "contact angle", RADIAL),
    ("bore", "contact angle", RADIAL),
    ("fit", "contact angle", RADIAL),
    ("rollers' surfaces", "missing rollers", f"{{given}}: not together with bearing.missing_rollers{EITHER}"),
    ("unequal rollers", "missing rollers", f"{{given}}: not together with bearing.missing_rollers{EITHER}"),
    ("fit", "solid shaft", f"{{given}}: of a ring on a shaft; bearing.bore_diameter_mm = 0 is a solid one{EITHER}"),
    ("solid shaft", "other contacts on meshes", f"{SUBGRID}, whose ring is held at its bore{EITHER}"),
    ("contact angle", "other contacts on meshes", f"{SUBGRID}, whose circles are as curved as bodies{EITHER}"),
    ("axial", "other contacts on meshes", f"{SUBGRID}, whose law is that of slices{EITHER}"),
    ("rigid body", "axial on meshes",
     f"{{given}}: not together with [axial], whose slices are those of elastic bodies{EITHER}"),
    ("part of the length", "no axial",
     "{given}: needs an [axial] table (an empty one is enough); or leave length_mm out"),
    ("rows", "axial", f"{{given}}: not together with [axial], whose slope loads rows unequally{EITHER}"),
    ("contacts' damping", "axial on meshes", AXIAL_MESH),
    ("axial", "balls", '{given}: only for rollers, not with bearing.type = "ball"; leave it out'),
    ("axial", "contact angle",
     "{given}: of rollers whose axis is the shaft's, not with contact_angle_deg; leave one of them out"),
    ("outer ring's speed", "mounted", '{given}: only with support.kind = "held", not with "{support}": '
        f"whatever turns with the outer ring holds it all around{EITHER}"),
    ("outer ring's speed", "fitted",
     f"{{given}}: not with [fit], whose housing stands still; give the operating clearance{EITHER}"),
    ("surfaces", "other contacts on meshes", f"{SUBGRID}, whose points of pressure lie on perfect circles{EITHER}"),
)


def refusals(scene: "Scene") -> Iterator[str]:
    """A sentence for every feature that this kind of scene can't have."""
    words = {"model": scene.model, "contact": scene.contact.model, "support": scene.support and scene.support.kind}
    found = {feature: written(scene) for feature, written in GIVEN.items()}
    for feature, kind, sentence in REFUSED:
        if found[feature] and KINDS[kind](scene):
            yield sentence.format(given=found[feature], **words)


COMBINATIONS = (
    _law, _mass, _mesh, refusals, _fields, _bore, _fit, _cage, _courses, surfaces.roller_faults,
    surfaces.spall_faults, surfaces.size_faults, surfaces.profile_faults, _axial, surfaces.part_faults)

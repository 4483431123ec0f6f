"""What models and contact models take: one table, feature by kind of scene, from which the refusals follow.

A new feature is a line of `GIVEN`, a new kind of scene one of `KINDS`, a pair that does not go one of `REFUSED`.
"""

from collections.abc import Callable, Iterator

from lagrange.scene.surfaces import SURFACES
from lagrange.scene.tables import SceneTables


def _surfaces(scene: SceneTables) -> str | None:
    given = [f"[[{name}]]" for name in SURFACES if getattr(scene, name)]
    return next(iter(given), None if scene.lubricant is None else "[lubricant]")


def _of_rollers(scene: SceneTables) -> str | None:
    """A roller's surface, but for its size."""
    found = (f'{name}.{i}.body = "roller"' for name in SURFACES for i, table in enumerate(getattr(scene, name))
             if getattr(table, "body", None) == "roller")  # fmt: skip
    return next(found, None)


def bore_given(scene: SceneTables) -> str | None:
    """A ring's fit as the scene writes it."""
    bore = scene.mounting().bore
    return None if bore is None else f"support.fit_clearance_um = {1e6 * bore.clearance:g}"


# how a scene writes what it has; None where it lacks it
GIVEN: dict[str, Callable[[SceneTables], str | None]] = {
    "fields": lambda scene: f"output.fields_every_ms = {t}" if (t := scene.output.fields_every_ms) > 0.0 else None,
    "rigid body": lambda scene: f'bodies.{scene.bodies.rigid[0]} = "rigid"' if scene.bodies.rigid else None,
    "points": lambda scene: 'support.kind = "points"' if scene.mounting().points else None,
    "housing": lambda scene: 'support.kind = "housing"' if scene.mounting().housing else None,
    "shaft": lambda scene: 'operation.shaft = "springs"' if scene.mounting().shaft else None,
    "sensor": lambda scene: "[sensor]" if scene.sensor else None,
    "bore": bore_given,
    "bodies' damping": lambda scene: f"damping.bodies_1_s = {r:g}" if (r := scene.damping.bodies_1_s) > 0.0 else None,
    "contacts' damping": lambda scene: "[damping] of contacts" if scene.damping.contacts.acts else None,
    "load history": lambda scene: f"operation.{key}" if (key := scene.operation.changes) else None,
    "fit in the housing": lambda scene: scene.fit.of_housing if scene.fit else None,
    "fit": lambda scene: "[fit]" if scene.fit else None,
    "solid shaft": lambda scene: None if scene.bearing.bore_diameter_mm else "bearing.bore_diameter_mm = 0",
    "surfaces": _surfaces,
    "part of the length": lambda scene: next(
        (f"spall.{i}.length_mm = {s.length_mm:g}" for i, s in enumerate(scene.spall) if s.length_mm is not None), None
    ),
    "lubricant": lambda scene: "[lubricant]" if scene.lubricant else None,
    "rollers' surfaces": _of_rollers,
    "missing rollers": lambda scene: f"bearing.missing_rollers = {m}" if (m := scene.bearing.missing_rollers) else None,
    "unequal rollers": lambda scene: "[[unequal_roller]]" if scene.unequal_roller else None,
    "contact angle": lambda scene: (
        f"bearing.contact_angle_deg = {a:g}" if (a := scene.bearing.contact_angle_deg) > 0.0 else None
    ),
    "axial": lambda scene: None if scene.axial is None else "[axial]",
    "rows": lambda scene: f"bearing.rows = {scene.bearing.rows}" if scene.bearing.rows > 1 else None,
    "outer ring's speed": lambda scene: f"operation.{key}" if (key := scene.operation.turns_outer_ring) else None,
}
# what scenes are, by what keeps them from a feature
KINDS: dict[str, Callable[[SceneTables], bool]] = {
    "no mesh": lambda scene: scene.model != "fem",
    "other contacts": lambda scene: scene.contact.model != "subgrid",
    "other contacts on meshes": lambda scene: scene.model == "fem" and scene.contact.model != "subgrid",
    "rigid outer ring": lambda scene: scene.bodies.outer_ring == "rigid",
    "outer ring moves": lambda scene: scene.mounting().bore is not None or scene.mounting().points is not None,
    "balls": lambda scene: scene.bearing.type == "ball",
    "contact angle": lambda scene: scene.bearing.contact_angle_deg > 0.0,
    "solid shaft": lambda scene: scene.bearing.bore_diameter_mm == 0.0,
    "missing rollers": lambda scene: bool(scene.bearing.missing_rollers),
    "axial": lambda scene: scene.axial is not None,
    "no axial": lambda scene: scene.axial is None,
    "axial on meshes": lambda scene: scene.axial is not None and scene.model == "fem",
    "not reduced": lambda scene: scene.model != "reduced",
    "frictionless": lambda scene: scene.friction_coefficient == 0.0,
    "fitted": lambda scene: scene.fit is not None,
    "no housing": lambda scene: scene.mounting().housing is None,
    "mounted": lambda scene: scene.support is not None and scene.support.kind != "held",
    "any": lambda scene: True,
}
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
    ("outer ring's speed", "mounted",
     f'{{given}}: only with support.kind = "held", not with "{{support}}": whatever turns with the outer ring holds it '
     f"all around{EITHER}"),
    ("outer ring's speed", "fitted",
     f"{{given}}: not with [fit], whose housing stands still; give the operating clearance{EITHER}"),
    ("surfaces", "other contacts on meshes", f"{SUBGRID}, whose points of pressure lie on perfect circles{EITHER}"),
)  # fmt: skip


def refusals(scene: SceneTables) -> Iterator[str]:
    """A sentence for every feature that this kind of scene can't have."""
    words = {
        "model": scene.model, "contact": scene.contact.model,
        "support": "held" if scene.support is None else scene.support.kind,
    }  # fmt: skip
    found = {feature: written(scene) for feature, written in GIVEN.items()}
    for feature, kind, sentence in REFUSED:
        if (given := found[feature]) is not None and KINDS[kind](scene):
            yield sentence.format(given=given, **words)

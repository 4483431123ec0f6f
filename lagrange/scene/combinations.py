"""What tables of a scene can't be together, or not with the bearing that they describe: one check a subject."""

from collections.abc import Callable, Iterator
from math import pi
from typing import TYPE_CHECKING

from lagrange.contact.raceway_laws import law_names
from lagrange.scene.bearing import cage_faults
from lagrange.scene.surfaces import SURFACES, profile_faults, roller_faults, size_faults, spall_faults

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
LARGEST_FIT = 2e-3  # of the outside diameter: strains of a press fit, and slopes of a ring in play, are about as large


def _law(scene: "Scene") -> Iterator[str]:
    known = law_names(scene.perfect_bearing())
    if scene.lagrange.law not in known:
        yield (
            f"lagrange.law = {scene.lagrange.law!r}: unknown for bearing.type = {scene.bearing.type!r}; known are "
            f"{', '.join(known)}"
        )


def _mass(scene: "Scene") -> Iterator[str]:
    ring = scene.perfect_bearing().inner_ring_mass
    if scene.operation.inner_ring_and_shaft_kg <= ring:
        yield (
            f"operation.inner_ring_and_shaft_kg = {scene.operation.inner_ring_and_shaft_kg} must exceed the mass of "
            f"the elastic inner ring, {ring:.4g} kg"
        )


def _mesh(scene: "Scene") -> Iterator[str]:
    if scene.bearing.type == "ball":
        return
    size, roller = scene.numerics.mesh_size_mm, scene.bearing.roller_diameter_mm
    coarsest = pi * roller / 10.0
    if size > coarsest:
        yield (f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})")
    finest = roller / FINEST.get(scene.contact.model, FINEST_OTHERWISE)
    if size < finest:
        yield (
            f"numerics.mesh_size_mm = {size} is finer than contact.model = '{scene.contact.model}' is made for "
            f"(at least {finest:.3g})"
        )


def _fields(scene: "Scene") -> Iterator[str]:
    every = scene.output.fields_every_ms
    if every > 0.0 and scene.model != "fem":
        yield (
            f"output.fields_every_ms = {every}: model = {scene.model!r} has no mesh and no fields; leave it out or 0"
        )
    interval = 1e-3 * scene.numerics.output_interval_us
    if 0.0 < every < interval * (1.0 - 1e-9):
        yield (
            f"output.fields_every_ms = {every} must not be below numerics.output_interval_us = "
            f"{scene.numerics.output_interval_us} ({interval:g} ms); 0 stores none"
        )


def _rigid_contacts(scene: "Scene") -> Iterator[str]:
    if scene.bodies.rigid and scene.contact.model != "subgrid":
        yield (
            f'bodies.{scene.bodies.rigid[0]} = "rigid": only with contact.model = "subgrid", not with '
            f'"{scene.contact.model}", whose points of pressure sit on meshes'
        )


def _damping(scene: "Scene") -> Iterator[str]:
    if scene.damping.bodies_1_s > 0.0 and scene.model != "fem":
        yield (
            f"damping.bodies_1_s = {scene.damping.bodies_1_s:g}: only for bodies with meshes, which model = "
            f"{scene.model!r} has none of; leave it out, or take model = 'fem'"
        )
    if not scene.damping.contacts.acts:
        return
    if scene.model == "fem" and scene.contact.model != "subgrid":
        yield (
            f'[damping] of contacts: only with contact.model = "subgrid", not with "{scene.contact.model}", whose '
            "points of pressure stand for part of a contact; leave one of them out"
        )
    if scene.model == "reduced" and scene.reduced.modes_up_to_kHz > 0.0:
        yield (
            f"reduced.modes_up_to_kHz = {scene.reduced.modes_up_to_kHz:g}: not together with [damping] of contacts, "
            "which would feed the modes; leave one of them out"
        )


def _support(scene: "Scene") -> Iterator[str]:
    mounting = scene.mounting()
    if mounting.points is not None and scene.model != "fem":
        yield (
            f'support.kind = "points": only with model = "fem", not with "{scene.model}", whose outer ring does not '
            'bend as a whole; take kind = "housing", or leave one of them out'
        )
    if mounting.points is not None and scene.bodies.outer_ring == "rigid":
        yield 'support.kind = "points": a rigid outer ring is held as well by any; leave one of them out'
    if mounting.points is not None and scene.contact.model != "subgrid":
        yield (
            f'support.kind = "points": only with contact.model = "subgrid", not with "{scene.contact.model}"; leave '
            "one of them out"
        )
    if mounting.shaft is not None and scene.model == "fem" and scene.contact.model != "subgrid":
        yield (
            f'operation.shaft = "springs": only with contact.model = "subgrid", not with "{scene.contact.model}", '
            "which is there to compare contacts; leave one of them out"
        )
    given = {'operation.shaft = "springs"': mounting.shaft, 'support.kind = "housing"': mounting.housing}
    for name, part in given.items():
        if part is not None and scene.model == "reduced" and scene.reduced.modes_up_to_kHz > 0.0:
            yield (
                f"{name}: not together with reduced.modes_up_to_kHz = {scene.reduced.modes_up_to_kHz:g}, whose modes "
                "are those of rings that contacts and load alone move; leave one of them out"
            )
    if scene.sensor is not None and mounting.housing is None:
        yield ('[sensor]: stands on a housing that moves; add [support] with kind = "housing", or leave the sensor out')


def _bore(scene: "Scene") -> Iterator[str]:
    bore = scene.mounting().bore
    if bore is None:
        return
    given, diameter = f"support.fit_clearance_um = {1e6 * bore.clearance:g}", scene.bearing.outside_diameter_mm
    most = 1e3 * LARGEST_FIT * diameter  # µm
    if scene.model != "fem":
        yield (
            f'{given}: only with model = "fem", not with "{scene.model}", whose outer ring is held without play; leave '
            "it out"
        )
    if scene.bodies.outer_ring == "rigid":
        yield f'{given}: only for an elastic outer ring, bodies.outer_ring is "rigid"; leave one of them out'
    if scene.contact.model != "subgrid":
        yield (f'{given}: only with contact.model = "subgrid", not with "{scene.contact.model}"; leave one of them out')
    if abs(bore.clearance) > 1e-6 * most:
        yield (
            f"{given}: more than {LARGEST_FIT:g} of the outer ring's outside diameter, {diameter:g} mm; between "
            f"{-most:g} and {most:g}"
        )
    if scene.cage is not None and scene.cage.guidance == "outer_ring":
        yield f'cage.guidance = "outer_ring": not with {given}, in which that ring moves; take another guidance'


def _cage(scene: "Scene") -> Iterator[str]:
    if scene.cage is not None:
        yield from cage_faults(scene.perfect_bearing(), scene.cage)


def _courses(scene: "Scene") -> Iterator[str]:
    yield from scene.operation.duration_faults(scene.numerics.duration_ms)
    if scene.lubricant is not None and scene.operation.speed_table is not None:
        yield (
            "[lubricant]: only at a steady speed, not with operation.speed_table = "
            f'"{scene.operation.speed_table}": its film is as thick as at one speed; leave one of them out'
        )
    if scene.operation.changes and scene.model == "fem" and scene.contact.model != "subgrid":
        yield (
            f'operation.{scene.operation.changes}: only with contact.model = "subgrid", not with '
            f'"{scene.contact.model}", which is there to compare contacts; leave one of them out'
        )


def _surface_models(scene: "Scene") -> Iterator[str]:
    given = [f"[[{name}]]" for name in SURFACES if getattr(scene, name)]
    given += [] if scene.lubricant is None else ["[lubricant]"]
    if given and scene.bearing.type == "ball":
        yield f'{given[0]}: only for rollers, not with bearing.type = "ball"; leave it out'
    if given and scene.model == "fem" and scene.contact.model != "subgrid":
        yield (
            f'{given[0]}: only with contact.model = "subgrid", not with "{scene.contact.model}", whose points of '
            "pressure lie on perfect circles; leave one of them out"
        )


def _rollers_with_faults(scene: "Scene") -> Iterator[str]:
    yield from roller_faults(scene.bearing.rollers, {name: getattr(scene, name) for name in SURFACES})


def _spalls(scene: "Scene") -> Iterator[str]:
    if scene.spall:
        yield from spall_faults(scene.perfect_bearing(), scene.spall)


def _sizes(scene: "Scene") -> Iterator[str]:
    if scene.waviness or scene.unequal_roller:
        yield from size_faults(scene.perfect_bearing(), scene.waviness, scene.unequal_roller)


def _profiles(scene: "Scene") -> Iterator[str]:
    if scene.profile:
        yield from profile_faults(scene.perfect_bearing(), scene.profile)


COMBINATIONS: tuple[Callable[["Scene"], Iterator[str]], ...] = (
    _law,
    _mass,
    _mesh,
    _fields,
    _rigid_contacts,
    _support,
    _bore,
    _cage,
    _damping,
    _courses,
    _surface_models,
    _rollers_with_faults,
    _spalls,
    _sizes,
    _profiles,
)

"""What tables of a scene can't be together, or not with the bearing that they describe: one check a subject.

Of what models take see `capabilities`.
"""

from collections.abc import Callable, Iterator
from math import pi

from lagrange.contact.laws import OWN, law_names
from lagrange.limits import exceeds
from lagrange.scene.axial import axial_faults
from lagrange.scene.bearing import LARGEST_CLEARANCE, LARGEST_PRELOAD, ROUNDED
from lagrange.scene.cage import cage_faults
from lagrange.scene.capabilities import bore_given, refusals
from lagrange.scene.fit import fit_faults, interference_faults
from lagrange.scene.operation import FIRST_SPEEDS
from lagrange.scene.surfaces import SURFACES, part_faults, profile_faults, roller_faults, size_faults, spall_faults
from lagrange.scene.tables import SceneTables
from lagrange.section import stiffness_factor

FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
LARGEST_FIT = 2e-3  # of the outside diameter: strains of a press fit, and slopes of a ring in play, are about as large


def _law(scene: SceneTables) -> Iterator[str]:
    known = law_names(scene.perfect_bearing())
    if scene.lagrange.law not in (*known, OWN):
        yield (
            f"lagrange.law = {scene.lagrange.law!r}: unknown for bearing.type = {scene.bearing.type!r}; known are "
            f"{', '.join(known)}"
        )


def _mass(scene: SceneTables) -> Iterator[str]:
    bearing = scene.perfect_bearing()
    ring = bearing.inner_ring_mass * stiffness_factor(bearing)  # as much as the section's is of the section's hub
    if scene.operation.inner_ring_and_shaft_kg <= ring:
        yield (
            f"operation.inner_ring_and_shaft_kg = {scene.operation.inner_ring_and_shaft_kg} must exceed the mass of "
            f"the elastic inner ring, {ring:.4g} kg"
        )


def _mesh(scene: SceneTables) -> Iterator[str]:
    if scene.bearing.type == "ball":
        return
    size, roller = scene.numerics.mesh_size_mm, scene.bearing.roller_diameter_mm
    coarsest = pi * roller / 10.0
    if size > coarsest:
        yield (f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})")
    finest = roller / FINEST.get(scene.contact.model, FINEST_OTHERWISE)
    if exceeds(finest, size):
        yield (
            f"numerics.mesh_size_mm = {size} is finer than contact.model = '{scene.contact.model}' is made for "
            f"(at least {finest:.3g})"
        )


def _fields(scene: SceneTables) -> Iterator[str]:
    every = scene.output.fields_every_ms
    interval = 1e-3 * scene.numerics.output_interval_us
    if every > 0.0 and exceeds(interval, every):
        yield (
            f"output.fields_every_ms = {every} must not be below numerics.output_interval_us = "
            f"{scene.numerics.output_interval_us} ({interval:g} ms); 0 stores none"
        )


def _bore(scene: SceneTables) -> Iterator[str]:
    bore, given, diameter = scene.mounting().bore, bore_given(scene), scene.bearing.outside_diameter_mm
    if bore is None:
        return
    most = 1e3 * LARGEST_FIT * diameter  # µm
    if exceeds(abs(bore.clearance), 1e-6 * most):
        yield (
            f"{given}: more than {LARGEST_FIT:g} of the outer ring's outside diameter, {diameter:g} mm; between "
            f"{-most:g} and {most:g}"
        )
    if scene.cage is not None and scene.cage.guidance == "outer_ring":
        yield f'cage.guidance = "outer_ring": not with {given}, in which that ring moves; choose another guidance'


def _fit(scene: SceneTables) -> Iterator[str]:
    if scene.fit is None:
        return
    faults = list(fit_faults(scene.bearing, scene.fit))
    yield from faults
    if faults:
        return
    found, roller = scene.clearance_without_films(), scene.bearing.roller_diameter_mm
    if found is None:
        return
    yield from interference_faults(scene.bearing, found)
    total = round(1e3 * found.total, ROUNDED)
    if not (exceeds(-LARGEST_PRELOAD * roller, total) or exceeds(total, LARGEST_CLEARANCE * roller)):
        return
    parts = ", ".join(f"{name} {value} µm" for name, value, _ in found.rows())
    limit, remedy = (
        (
            -LARGEST_PRELOAD,
            "more preload than the model bears (at least {:.4g} µm); less interference, or more clearance",
        )
        if found.total < 0.0
        else (LARGEST_CLEARANCE, "too large a clearance (at most {:.4g} µm); check temperatures and clearance")
    )
    yield f"fit: {remedy.format(1e3 * limit * roller)}: {parts}"


def _cage(scene: SceneTables) -> Iterator[str]:
    if scene.cage is not None and scene.cage.guidance == "outer_ring" and (key := scene.operation.turns_outer_ring):
        yield f'cage.guidance = "outer_ring": not with operation.{key}, of a guide that turns; choose another guidance'
    if scene.cage is not None:
        yield from cage_faults(scene.perfect_bearing(), scene.cage)


def _courses(scene: SceneTables) -> Iterator[str]:
    yield from scene.operation.duration_faults(scene.numerics.duration_ms)
    for name in FIRST_SPEEDS if scene.lubricant is not None else ():
        if (table := getattr(scene.operation, name)) is not None:
            yield (
                f'[lubricant]: only at a steady speed, not with operation.{name} = "{table}": its film is as thick as '
                "at one speed; leave one of them out"
            )


def _rollers_with_faults(scene: SceneTables) -> Iterator[str]:
    yield from roller_faults(scene.bearing.rollers, {name: getattr(scene, name) for name in SURFACES})


def _spalls(scene: SceneTables) -> Iterator[str]:
    if scene.spall:
        yield from spall_faults(scene.perfect_bearing(), scene.spall)


def _sizes(scene: SceneTables) -> Iterator[str]:
    if scene.waviness or scene.unequal_roller:
        yield from size_faults(scene.perfect_bearing(), scene.waviness, scene.unequal_roller)


def _profiles(scene: SceneTables) -> Iterator[str]:
    if scene.profile:
        yield from profile_faults(scene.perfect_bearing(), scene.profile)


def _axial(scene: SceneTables) -> Iterator[str]:
    if scene.axial is not None:
        yield from axial_faults(scene.perfect_bearing(), scene.axial)
        yield from part_faults(scene.perfect_bearing(), scene.axial.slices, scene.spall)
    elif scene.operation.misalignment_mrad:
        yield (
            f"operation.misalignment_mrad = {scene.operation.misalignment_mrad:g}: needs an [axial] table (an "
            "empty one is enough)"
        )


COMBINATIONS: tuple[Callable[[SceneTables], Iterator[str]], ...] = (
    _law,
    _mass,
    _mesh,
    refusals,
    _fields,
    _bore,
    _fit,
    _cage,
    _courses,
    _rollers_with_faults,
    _spalls,
    _sizes,
    _profiles,
    _axial,
)

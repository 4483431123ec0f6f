"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

It stands on the ground floor because both the solver and the checker read it, and neither may know the other.
"""

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from math import asin, pi, radians, sin
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import Field, ValidationError

from lagrange.bearing import BallBearing, Bearing, Material, Operation
from lagrange.raceway_laws import law_names
from lagrange.scene_columns import Columns
from lagrange.scene_faults import Check, Table, all_faults, printable
from lagrange.scene_files import content_in_place, content_of
from lagrange.scene_surfaces import (
    ProfileTable,
    SpallTable,
    UnequalRollerTable,
    WavinessTable,
    profile_faults,
    roller_faults,
    size_faults,
    spall_faults,
)

LONGEST_TEXT = 2**20  # characters of a scene
MOST_FAULTS = 15  # told at once: a file that is no scene may have thousands
RPM = 2.0 * pi / 60.0
MM = 1e-3
FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
SURFACES = ("spall", "waviness", "unequal_roller", "profile")  # arrays of tables
MOST_TABLES = 200  # of one array
COMPARISONS = ("penalty", "faceted")  # contact models that are only there to be compared with
STIFF_PENALTY = 1e9  # N/m, three times a contact of the paper's bearing; the mesh's nodes are no stiffer
# groove radius over ball diameter to which ISO 281 rates deep-groove bearings
USUAL_GROOVES = {"inner_conformity": 0.52, "outer_conformity": 0.53}


class SceneError(ValueError):
    """The scene can't be used; the text names file, key, value and limit, one fault a line."""


class BearingTable(Table):
    type: Literal["roller", "ball"] = "roller"
    rollers: int = Field(13, ge=3, le=200)
    roller_diameter_mm: float = Field(10.0, ge=0.5, le=500.0)
    roller_length_mm: float = Field(10.0, ge=0.1, le=2000.0)
    inner_raceway_diameter_mm: float = Field(36.0, gt=0.0, le=10_000.0)
    outer_raceway_diameter_mm: float = Field(56.0, gt=0.0, le=10_000.0)
    bore_diameter_mm: float = Field(25.0, gt=0.0, le=10_000.0)
    outside_diameter_mm: float = Field(65.0, gt=0.0, le=10_000.0)
    inner_conformity: float | None = Field(None, gt=0.5, le=1.0)  # of balls: groove radius over ball diameter
    outer_conformity: float | None = Field(None, gt=0.5, le=1.0)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        return USUAL_GROOVES | data if data.get("type") == "ball" else data

    def checks(self) -> tuple[Check, ...]:
        return self._grooves, self._inner_ring, self._outer_ring, self._clearance, self._room

    def _grooves(self) -> Iterator[str]:
        for key in USUAL_GROOVES:
            if self.type == "roller" and getattr(self, key) is not None:
                yield f'{key} = {getattr(self, key)}: only for balls; add type = "ball" or leave it out'

    def _inner_ring(self) -> Iterator[str]:
        inner = self.inner_raceway_diameter_mm
        if self.bore_diameter_mm >= inner:
            yield f"bore_diameter_mm = {self.bore_diameter_mm} must be below inner_raceway_diameter_mm = {inner}"

    def _outer_ring(self) -> Iterator[str]:
        outer = self.outer_raceway_diameter_mm
        if self.outside_diameter_mm <= outer:
            yield f"outside_diameter_mm = {self.outside_diameter_mm} must be above outer_raceway_diameter_mm = {outer}"

    def _clearance(self) -> Iterator[str]:
        roller, outer = self.roller_diameter_mm, self.outer_raceway_diameter_mm
        clearance = outer - self.inner_raceway_diameter_mm - 2.0 * roller
        if clearance < -0.005 * roller:
            yield (
                f"diametral clearance outer − inner − 2·roller = {clearance:.4g} mm is more preload than the model "
                f"bears (at least {-0.005 * roller:.4g} mm); widen outer_raceway_diameter_mm = {outer}"
            )
        if clearance > 0.2 * roller:
            yield (
                f"diametral clearance outer − inner − 2·roller = {clearance:.4g} mm is too large (at most "
                f"{0.2 * roller:.4g} mm); lower outer_raceway_diameter_mm = {outer}"
            )

    def _room(self) -> Iterator[str]:
        roller = self.roller_diameter_mm
        pitch = 0.5 * (self.inner_raceway_diameter_mm + self.outer_raceway_diameter_mm)
        if pitch * sin(pi / self.rollers) <= roller:
            most = int(pi / asin(roller / pitch)) if roller < pitch else 1
            yield (
                f"rollers = {self.rollers} of roller_diameter_mm = {roller} do not fit on the pitch circle of "
                f"{pitch:g} mm; at most {most}"
            )


class MaterialOverride(Table):
    youngs_modulus_GPa: float | None = Field(None, ge=0.1, le=2000.0)
    poisson_ratio: float | None = Field(None, ge=0.0, le=0.45)
    density_kg_m3: float | None = Field(None, ge=100.0, le=30_000.0)


class MaterialTable(Table):
    youngs_modulus_GPa: float = Field(210.0, ge=0.1, le=2000.0)
    poisson_ratio: float = Field(0.3, ge=0.0, le=0.45)
    density_kg_m3: float = Field(7850.0, ge=100.0, le=30_000.0)
    roller: MaterialOverride = MaterialOverride()
    inner_ring: MaterialOverride = MaterialOverride()
    outer_ring: MaterialOverride = MaterialOverride()

    def of(self, body: Literal["roller", "inner_ring", "outer_ring"]) -> Material:
        """Material of one kind of body, SI."""
        own = getattr(self, body)

        def pick(key):
            value = getattr(own, key)
            return getattr(self, key) if value is None else value

        return Material(
            youngs_modulus=pick("youngs_modulus_GPa") * 1e9,
            poisson_ratio=pick("poisson_ratio"),
            density=pick("density_kg_m3"),
        )


class BodiesTable(Table):
    """Which bodies are taken as undeformable."""

    rollers: Literal["elastic", "rigid"] = "elastic"
    inner_ring: Literal["elastic", "rigid"] = "elastic"
    outer_ring: Literal["elastic", "rigid"] = "elastic"

    def checks(self) -> tuple[Check, ...]:
        return (self._partners,)

    def _partners(self) -> Iterator[str]:
        rings = [name for name in ("inner_ring", "outer_ring") if getattr(self, name) == "rigid"]
        if self.rollers == "rigid" and rings:
            too = " and ".join(f'{name} = "rigid"' for name in rings)
            yield (
                f'rollers = "rigid" together with {too}: a contact of two rigid bodies has no compliance and so no '
                'force; leave the rollers or the rings "elastic", or, for bodies that are all rigid with a contact law '
                "between them, leave [bodies] out and take run-fem --model lagrange"
            )

    @property
    def rigid(self) -> tuple[str, ...]:
        """The keys of those that are."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) == "rigid")


class OperationTable(Table):
    speed_rpm: float = Field(4500.0, ge=-200_000.0, le=200_000.0)
    radial_load_N: float = Field(2000.0, ge=0.0, le=1e7)
    inner_ring_and_shaft_kg: float = Field(0.078, gt=0.0, le=1e6)
    gravity_m_s2: float = Field(9.81, ge=0.0, le=1000.0)
    first_roller_deg: float = Field(0.0, ge=-360.0, le=360.0)


class ContactTable(Table):
    model: Literal["subgrid", "resolved", "penalty", "faceted"] = "subgrid"
    penalty_stiffness_N_per_m: float | None = Field(None, ge=1e5, le=1e12)  # of each contact of a comparison model
    friction_coefficient: float = Field(0.1, ge=0.0, le=1.0)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        compared = data.get("model") in COMPARISONS
        return {"penalty_stiffness_N_per_m": STIFF_PENALTY} | data if compared else data

    def checks(self) -> tuple[Check, ...]:
        return (self._has_springs,)

    def _has_springs(self) -> Iterator[str]:
        if self.penalty_stiffness_N_per_m is not None and self.model not in COMPARISONS:
            yield (
                f"penalty_stiffness_N_per_m = {self.penalty_stiffness_N_per_m:g}: only for the comparison models "
                f'model = "penalty" and "faceted", not for "{self.model}"; leave it out'
            )


class NumericsTable(Table):
    duration_ms: float = Field(60.0, ge=0.0, le=1e6)
    start: Literal["equilibrium", "rest"] = "equilibrium"
    load_ramp_ms: float = Field(1.0, ge=0.0, le=1e6)
    mesh_size_mm: float = Field(1.0, gt=0.0, le=100.0)
    time_step_safety: float = Field(0.9, ge=0.01, lt=1.0)
    output_interval_us: float = Field(10.0, ge=1e-3, le=1e6)
    threads: int = Field(1, ge=1, le=64)

    def checks(self) -> tuple[Check, ...]:
        return (self._samples,)

    def _samples(self) -> Iterator[str]:
        if 0.0 < 1e3 * self.duration_ms < self.output_interval_us:
            yield (
                f"output_interval_us = {self.output_interval_us:g} is longer than the run (duration_ms = "
                f"{self.duration_ms:g}): nothing but the start would be stored; at most {1e3 * self.duration_ms:g}"
            )


class LagrangeTable(Table):
    """Options of the Lagrangian model: of its own solution and of what trajectories are checked against."""

    law: str = "harris"
    damping_N_s_m: float = Field(0.0, ge=0.0, le=1e6)
    angles: Literal["kinematic", "free"] = "kinematic"


class ReducedTable(Table):
    """Options of the reduced model."""

    modes_up_to_kHz: float = Field(0.0, ge=0.0, le=1e5)


class OutputTable(Table):
    fields_every_ms: float = Field(0.0, ge=0.0, le=1e6)


class Scene(Table):
    """A whole scene. Defaults are the paper's bearing."""

    name: str = Field("paper", min_length=1, max_length=100, pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    model: Literal["fem", "reduced", "lagrange"] = "fem"
    bearing: BearingTable = BearingTable()
    material: MaterialTable = MaterialTable()
    bodies: BodiesTable = BodiesTable()
    operation: OperationTable = OperationTable()
    contact: ContactTable = ContactTable()
    lagrange: LagrangeTable = LagrangeTable()
    reduced: ReducedTable = ReducedTable()
    numerics: NumericsTable = NumericsTable()
    output: OutputTable = OutputTable()
    spall: list[SpallTable] = Field([], max_length=MOST_TABLES)
    waviness: list[WavinessTable] = Field([], max_length=MOST_TABLES)
    unequal_roller: list[UnequalRollerTable] = Field([], max_length=MOST_TABLES)
    profile: list[ProfileTable] = Field([], max_length=MOST_TABLES)
    table: Columns = Columns()

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        bearing, options = data.get("bearing"), data.get("lagrange", {})
        if isinstance(bearing, dict) and bearing.get("type") == "ball" and isinstance(options, dict):
            return data | {"lagrange": {"law": "hertz"} | options}
        return data

    def checks(self) -> tuple[Check, ...]:
        surfaces = self._surface_models, self._rollers_with_faults, self._spalls, self._sizes, self._profiles
        return self._law, self._mass, self._mesh, self._fields, self._rigid_contacts, *surfaces

    def _law(self) -> Iterator[str]:
        known = law_names(self._perfect_bearing())
        if self.lagrange.law not in known:
            yield (
                f"lagrange.law = {self.lagrange.law!r}: unknown for bearing.type = {self.bearing.type!r}; known are "
                f"{', '.join(known)}"
            )

    def _mass(self) -> Iterator[str]:
        ring = self._perfect_bearing().inner_ring_mass
        if self.operation.inner_ring_and_shaft_kg <= ring:
            yield (
                f"operation.inner_ring_and_shaft_kg = {self.operation.inner_ring_and_shaft_kg} must exceed the mass of "
                f"the elastic inner ring, {ring:.4g} kg"
            )

    def _mesh(self) -> Iterator[str]:
        if self.bearing.type == "ball":
            return
        size, roller = self.numerics.mesh_size_mm, self.bearing.roller_diameter_mm
        coarsest = pi * roller / 10.0
        if size > coarsest:
            yield (f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})")
        finest = roller / FINEST.get(self.contact.model, FINEST_OTHERWISE)
        if size < finest:
            yield (
                f"numerics.mesh_size_mm = {size} is finer than contact.model = '{self.contact.model}' is made for "
                f"(at least {finest:.3g})"
            )

    def _fields(self) -> Iterator[str]:
        every = self.output.fields_every_ms
        if every > 0.0 and self.model != "fem":
            yield (
                f"output.fields_every_ms = {every}: model = {self.model!r} has no mesh and no fields; leave it out or 0"
            )
        interval = 1e-3 * self.numerics.output_interval_us
        if 0.0 < every < interval * (1.0 - 1e-9):
            yield (
                f"output.fields_every_ms = {every} must not be below numerics.output_interval_us = "
                f"{self.numerics.output_interval_us} ({interval:g} ms); 0 stores none"
            )

    def _rigid_contacts(self) -> Iterator[str]:
        if self.bodies.rigid and self.contact.model != "subgrid":
            yield (
                f'bodies.{self.bodies.rigid[0]} = "rigid": only with contact.model = "subgrid", not with '
                f'"{self.contact.model}", whose points of pressure sit on meshes'
            )

    def _surface_models(self) -> Iterator[str]:
        given = [f"[[{name}]]" for name in SURFACES if getattr(self, name)]
        if given and self.bearing.type == "ball":
            yield f'{given[0]}: only for rollers, not with bearing.type = "ball"; leave it out'
        if given and self.model == "fem" and self.contact.model != "subgrid":
            yield (
                f'{given[0]}: only with contact.model = "subgrid", not with "{self.contact.model}", whose points of '
                "pressure lie on perfect circles; leave one of them out"
            )

    def _rollers_with_faults(self) -> Iterator[str]:
        yield from roller_faults(self.bearing.rollers, {name: getattr(self, name) for name in SURFACES})

    def _spalls(self) -> Iterator[str]:
        if self.spall:
            yield from spall_faults(self._perfect_bearing(), self.spall)

    def _sizes(self) -> Iterator[str]:
        if self.waviness or self.unequal_roller:
            yield from size_faults(self._perfect_bearing(), self.waviness, self.unequal_roller)

    def _profiles(self) -> Iterator[str]:
        if self.profile:
            yield from profile_faults(self._perfect_bearing(), self.profile)

    def ideal_bearing(self) -> Bearing:
        """The bearing in SI, with the faults of its surfaces."""
        faults = tuple(table.fault() for name in SURFACES for table in getattr(self, name))
        return replace(self._perfect_bearing(), faults=faults)

    def _perfect_bearing(self) -> Bearing:
        b = self.bearing
        shape = dict(
            n_rollers=b.rollers,
            roller_radius=0.5 * MM * b.roller_diameter_mm,
            roller_length=MM * b.roller_length_mm,
            inner_raceway_radius=0.5 * MM * b.inner_raceway_diameter_mm,
            outer_raceway_radius=0.5 * MM * b.outer_raceway_diameter_mm,
            bore_radius=0.5 * MM * b.bore_diameter_mm,
            outside_radius=0.5 * MM * b.outside_diameter_mm,
            roller=replace(self.material.of("roller"), rigid=self.bodies.rollers == "rigid"),
            inner_ring=replace(self.material.of("inner_ring"), rigid=self.bodies.inner_ring == "rigid"),
            outer_ring=replace(self.material.of("outer_ring"), rigid=self.bodies.outer_ring == "rigid"),
        )
        if b.type == "roller":
            return Bearing(**shape)
        return BallBearing(
            **shape,
            inner_groove_radius=MM * b.inner_conformity * b.roller_diameter_mm,
            outer_groove_radius=MM * b.outer_conformity * b.roller_diameter_mm,
        )

    def ideal_operation(self) -> Operation:
        """The operating point in SI; the first roller's angle from +x."""
        o = self.operation
        return Operation(
            speed=o.speed_rpm * RPM,
            radial_load=o.radial_load_N,
            inner_mass=o.inner_ring_and_shaft_kg,
            gravity=o.gravity_m_s2,
            first_roller_angle=radians(o.first_roller_deg - 90.0),
        )

    @property
    def files(self) -> dict[str, str]:
        """Texts of the files that it names, by their digests, as far as they are at hand."""
        return {table.sha256: table.content for table in self.profile if table.content is not None}

    def to_toml(self) -> str:
        """The whole scene as TOML that `read_scene` takes back unchanged, where the files are that it names.

        Defaults are spelt out, but for [table]; arrays of tables are there where they are not empty.
        """
        tables = self.model_dump(exclude_none=True)
        for name in SURFACES:
            if not tables[name]:
                del tables[name]
        if self.table == Columns():
            del tables["table"]
        return tomli_w.dumps(tables)


def read_scene(path: str | Path | None = None, overrides: tuple[str, ...] = ()) -> Scene:
    """The scene of a TOML file (None: the paper's), with `table.key=value` overrides put on top.

    Errors
    ------
    SceneError: unreadable file, bad TOML, unknown key (with the likely one), wrong type, value out of range,
    values that contradict each other; all faults of the file at once.
    """
    name, data = "built-in scene", {}
    if path is not None:
        name = str(path)
        try:
            with open(path, "rb") as file:
                data = _load(file.read(LONGEST_TEXT + 1).decode("utf-8-sig"), name)
        except OSError as error:
            raise SceneError(f"{name}: can't be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise SceneError(f"{name}: not UTF-8 text (byte {error.start}); is it a scene file?") from None
    for override in overrides:
        _apply(data, override)
    with _refused(name):
        content_in_place(data, Path() if path is None else Path(path).parent)
    return parse_scene(data, name)


def parse_scene_text(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """A scene from TOML text, e.g. the `scene` attribute of a result file.

    Parameters
    ----------
    files : text of the files that it names, by their digests; None: a scene with profiles can be shown and compared,
        but gives no bearing
    """
    data = _load(text, name)
    with _refused(name):
        content_of(data, files)
    return parse_scene(data, name)


@contextmanager
def _refused(name: str) -> Iterator[None]:
    """Name the scene where a file of it can't be used."""
    try:
        yield
    except ValueError as error:
        raise SceneError(f"{name}: {printable(str(error))}") from None


def _load(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text."""
    if len(text) > LONGEST_TEXT:
        raise SceneError(f"{name}: longer than {LONGEST_TEXT} characters; is it a scene file?")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{name}: not valid TOML: {error}") from None
    except RecursionError:
        raise SceneError(f"{name}: not a scene: arrays or tables are nested too deeply") from None
    except ValueError as error:  # Python's own limit on the digits of a whole number
        raise SceneError(f"{name}: not a scene: {str(error).partition(';')[0]}") from None


def parse_scene(data: dict[str, Any], name: str) -> Scene:
    """A scene from nested tables."""
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        faults = all_faults(error, Scene, data)
        lines = [f"{name}: {fault}" for fault in faults[:MOST_FAULTS]]
        if len(faults) > MOST_FAULTS:
            lines.append(f"{name}: and {len(faults) - MOST_FAULTS} more")
        raise SceneError("\n".join(lines)) from None


def _apply(data: dict[str, Any], override: str) -> None:
    """Put `table.key=value` into nested tables; the value is TOML, or a plain string."""
    key, equals, text = override.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise SceneError(f"--set {override!r}: must read table.key=value, e.g. --set operation.speed_rpm=3000")
    try:
        value = _load(f"value = {text}", "")
    except SceneError:
        value = {}
    value = value["value"] if set(value) == {"value"} else text.strip()  # more than one: a string with line breaks
    table = data
    for part, after in pairwise(parts):
        table = _entry(table, part, [] if after.isdecimal() else {}, override)
    if isinstance(table, list):
        raise SceneError(f"--set {override!r}: {parts[-1]} is a whole table; set one of its keys")
    table[parts[-1]] = value


def _entry(table: dict[str, Any] | list, key: str, empty: dict | list, override: str) -> dict[str, Any] | list:
    """The table, or the array of tables, under a key or a number; made where there is none."""
    if isinstance(table, dict):
        found = table.setdefault(key, empty)
    else:
        if not key.isdecimal() or int(key[:9]) > len(table):
            raise SceneError(f"--set {override!r}: {key} is none of {len(table)} tables; numbers go on from 0")
        table.extend([empty] if int(key) == len(table) else [])
        found = table[int(key)]
    if not isinstance(found, dict | list):
        raise SceneError(f"--set {override!r}: {key} is a value, not a table")
    return found
